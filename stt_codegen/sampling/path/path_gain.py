"""The gain of a sampled loop: the gentlest that rests well inside the tube and is proved with a reserve.

Where a steady disturbance holds the state at |e| < 1, k = P W/(4 g_min q(E)) with e = tanh(E/2). A smaller gain rests nearer to
an edge, where the law is steep; a larger one answers to noise with more input, and needs a quicker drive.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from stt_codegen.decimals import above
from stt_codegen.sampling.path.integer_logarithm import LOG_BITS, log_bounds
from stt_codegen.sampling.path.path_proof import prove_path
from stt_codegen.sampling.path.path_windows import PathLoop

MULTIPLES = [Fraction(5, 4) ** k for k in range(15)]  # of the resting gain
LAST_MULTIPLES = [Fraction(4, 5) ** k for k in range(1, 5)]  # they rest nearer to an edge: tried where no larger one is proved
RESERVE_PARTS = (Fraction(1), Fraction(1, 2), Fraction(1, 5), Fraction(0))  # of the reserve above 1, tried in this order
PROVED_FACTORS = [Fraction(v) for v in ("1", "1.25", "1.5", "2", "2.5", "3", "4", "6", "10")]  # that a report looks for
GAIN_DIGITS = 3


class PathGain(NamedTuple):
    """A |k| by component, and the factor of the disturbance for which it was proved when it was chosen."""

    gain: tuple[Fraction, ...]
    reserve: Fraction


def choose_path_gain(
    loop: PathLoop, disturbance: Sequence[Fraction], resting_error: Fraction, reserve: Fraction
) -> PathGain | None:
    """Choose |k| by component: the smallest multiple of the resting gain that is proved with the reserve.

    Where none is, it is the smallest one with the largest part of the reserve. disturbance: the bound on |f + w| by component, of
    which the reserve is a multiple. Where inputs are coupled, all components have one multiple. None where no gain that is tried
    is proved.
    """
    if any(any(window.cross) for windows in loop.windows for window in windows):
        return _choose_for(loop, disturbance, resting_error, reserve)
    choices = [_choose_for(loop.component(i), disturbance[i : i + 1], resting_error, reserve) for i in range(loop.n)]
    proved = [choice for choice in choices if choice is not None]
    if len(proved) < loop.n:
        return None
    return PathGain(tuple(k for choice in proved for k in choice.gain), min(choice.reserve for choice in proved))


def _choose_for(loop: PathLoop, disturbance: Sequence[Fraction], resting_error: Fraction, reserve: Fraction) -> PathGain | None:
    """Choose one multiple for all components of a loop."""
    resting = [resting_gain(loop, i, resting_error) for i in range(loop.n)]
    # a gain counts only if it is proved without a reserve too: a path under smaller disturbances turns later, and may come nearer
    is_proved = cache(lambda gain: prove_path(with_gain(loop, gain)) is not None)
    for multiples in (MULTIPLES, LAST_MULTIPLES):
        gains = [tuple(Fraction(str(above(multiple * k, GAIN_DIGITS))) for k in resting) for multiple in multiples]
        if not any(map(is_proved, gains)):  # so that a loop that no gain proves is known without trying reserves
            continue
        for smaller_reserve in _reserves_below(reserve):
            for gain in gains:
                if _is_proved_with(loop, gain, disturbance, smaller_reserve) and is_proved(gain):
                    return PathGain(gain, smaller_reserve)
            gains = [gain for gain in gains if is_proved(gain)]
    return None


def reserve_of_gain(loop: PathLoop, disturbance: Sequence[Fraction], reserve: Fraction) -> Fraction | None:
    """Return the largest part of the reserve with which the loop is proved at its own gain; None where it is not proved."""
    gain = [law.gain for law in loop.laws]
    if prove_path(loop) is None:
        return None
    return next((v for v in _reserves_below(reserve) if _is_proved_with(loop, gain, disturbance, v)), None)


def _reserves_below(reserve: Fraction) -> list[Fraction]:
    """Return the factors of the disturbance to try, the largest first; the last is 1."""
    return list(dict.fromkeys(1 + part * (reserve - 1) for part in RESERVE_PARTS))


def _is_proved_with(loop: PathLoop, gain: Sequence[Fraction], disturbance: Sequence[Fraction], factor: Fraction) -> bool:
    """Whether a gain is proved for so many times the disturbance."""
    return prove_path(with_gain(loop, gain, [(factor - 1) * v for v in disturbance])) is not None


def proved_disturbance_factor(loop: PathLoop, disturbance: Sequence[Fraction]) -> Fraction:
    """Return the last of PROVED_FACTORS up to which the loop is proved for so many times the disturbance; 0 for none."""
    gain = [law.gain for law in loop.laws]
    return _last_proved(lambda factor: with_gain(loop, gain, [(factor - 1) * v for v in disturbance]))


def proved_period_factor(loop: PathLoop, period: Fraction) -> Fraction:
    """Return the last of PROVED_FACTORS up to which the loop is proved for so many times the sampling period; 0 for none."""
    return _last_proved(lambda factor: loop.with_period(factor * period))


def proved_drive_factor(loop: PathLoop) -> Fraction:
    """Return the last of PROVED_FACTORS up to which the loop is proved for drives so many times as slow; 0 for none."""
    return _last_proved(lambda factor: loop.with_drives([drive.scaled(factor) for drive in loop.drives]))


def _last_proved(loop_for: Callable[[Fraction], PathLoop]) -> Fraction:
    last_factor = Fraction(0)
    for factor in PROVED_FACTORS:
        if prove_path(loop_for(factor)) is None:
            break
        last_factor = factor
    return last_factor


def resting_gain(loop: PathLoop, i: int, resting_error: Fraction) -> Fraction:
    """Return |k| of component i with which a steady disturbance, the edges and the other inputs rest within |e| = resting_error.

    4 q(E) = 4 E cosh(E/2)^2 with E = ln((1 + e)/(1 - e)), and cosh(E/2)^2 = 1/(1 - e^2); it is 13.6 for e = 0.7. What nothing
    moves gets the gain for a closing speed that crosses the tube in its time.
    """
    ratio = (1 + resting_error) / (1 - resting_error)
    log = Fraction(log_bounds(ratio.numerator, ratio.denominator)[0], 1 << LOG_BITS)
    if any(window.closing_speed or any(window.cross) for window in loop.windows[i]):
        limits = [law.u_max or Fraction(0) for law in loop.laws]
        windows = [loop.bounds_over(i, k, k, limits) for k in range(len(loop.begins))]
        balance = max(b.closing_speed * b.wide / b.g_min for b in windows)
    else:
        balance = max(window.wide for window in loop.windows[i]) ** 2 / loop.begins[-1]
    return balance * (1 - resting_error**2) / (4 * log)


def with_gain(loop: PathLoop, gain: Sequence[Fraction], added_disturbance: Sequence[Fraction] = ()) -> PathLoop:
    """Return the loop with another |k|, and with more disturbance, by component."""
    added = added_disturbance or [Fraction(0)] * loop.n
    parts = zip(loop.laws, gain, added, strict=True)
    laws = tuple(replace(law, gain=k, shift=law.shift + v * loop.shift_time) for law, k, v in parts)
    windows = tuple(
        tuple(replace(window, closing_speed=window.closing_speed + v) for window in windows)
        for windows, v in zip(loop.windows, added, strict=True)
    )
    return replace(loop, laws=laws, windows=windows)
