"""The gain of a loop whose inputs act late: the gentlest that rests well inside the tube and is proved with a reserve.

Where a steady disturbance holds the state at |e| < 1, k = P W/(4 g_min q(E)) with e = tanh(E/2). A smaller gain rests nearer to
an edge; a larger one answers to noise with more input, and needs a quicker drive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from stt_codegen.decimals import above
from stt_codegen.sampling.path.path_proof import prove_path
from stt_codegen.sampling.path.path_windows import PathLoop

RESTING_DIVISOR = Fraction(136, 10)  # 4 q(1.735): a steady disturbance rests at |e| = 0.7
MULTIPLES = [Fraction(5, 4) ** k for k in range(-4, 21)]  # of the gain that rests there; smaller ones are a last resort
RESERVES = (Fraction(3, 2), Fraction(5, 4), Fraction(11, 10), Fraction(1))  # times the disturbance of [plant]
GAIN_DIGITS = 3


def choose_path_gain(loop: PathLoop, disturbance: Sequence[Fraction]) -> tuple[Fraction, ...] | None:
    """Choose |k| by component: the smallest multiple of the resting gain that is proved with the largest reserve.

    disturbance: the bound on |f + w| by component, of which the reserves are multiples. Where inputs are coupled, all components
    have one multiple. None where no gain that is tried is proved.
    """
    if any(any(row.cross) for rows in loop.rows for row in rows):
        return _choose_for(loop, disturbance)
    gains: list[Fraction] = []
    for i in range(loop.n):
        gain = _choose_for(loop.component(i), disturbance[i : i + 1])
        if gain is None:
            return None
        gains += gain
    return tuple(gains)


def _choose_for(loop: PathLoop, disturbance: Sequence[Fraction]) -> tuple[Fraction, ...] | None:
    """Choose one multiple for all components of a loop."""
    resting = [resting_gain(loop, i) for i in range(loop.n)]
    proved = []
    for multiple in MULTIPLES:
        gain = tuple(Fraction(str(above(multiple * k, GAIN_DIGITS))) for k in resting)
        if prove_path(with_gain(loop, gain)) is not None:
            proved.append((multiple, gain))
    proved.sort(key=lambda choice: choice[0] < 1)  # gains that rest nearer to an edge come last
    for reserve in RESERVES:
        added = [(reserve - 1) * v for v in disturbance]
        for _, gain in proved:
            if reserve == 1 or prove_path(with_gain(loop, gain, added)) is not None:
                return gain
    return None


def resting_gain(loop: PathLoop, i: int) -> Fraction:
    """Return |k| of component i with which a steady disturbance, the edges and the other inputs rest at |e| = 0.7."""
    limits = [law.u_max or Fraction(0) for law in loop.laws]
    rows = (loop.bounds_over(i, k, k, limits) for k in range(len(loop.begins)))
    return max(b.closing_speed * b.wide / b.g_min for b in rows) / RESTING_DIVISOR


def with_gain(loop: PathLoop, gain: Sequence[Fraction], added_disturbance: Sequence[Fraction] = ()) -> PathLoop:
    """Return the loop with another |k|, and with more disturbance, by component."""
    laws = tuple(replace(law, gain=k) for law, k in zip(loop.laws, gain, strict=True))
    added = added_disturbance or [Fraction(0)] * loop.n
    rows = tuple(
        tuple(replace(row, closing_speed=row.closing_speed + v) for row in rows) for rows, v in zip(loop.rows, added, strict=True)
    )
    return replace(loop, laws=laws, rows=rows)
