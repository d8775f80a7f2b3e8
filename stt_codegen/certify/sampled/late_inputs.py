"""P9 by the worst path (sampling/path/): for inputs that act late, and where the sharp conditions fail.

The path is followed in whole numbers, so search and proof are one computation. docs/sampling-path.md has the theorem.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

from stt_codegen.certify.certificate import PathClaim, PeriodProof
from stt_codegen.decimals import above, below, by_component, decimal
from stt_codegen.sampling.path import (
    Drive,
    PathLoop,
    PathProof,
    choose_path_gain,
    largest_drive_factor,
    longest_path_period,
    prove_path,
    prove_path_for,
)
from stt_codegen.task import DriveBounds, Task

DIFFERENCES_ADVICE = (
    "use another control.period (the error of a velocity by differences grows with it, what noise adds falls), state less noise, "
    "or measure the velocity"
)
PROMISING_DELAY_SHARE = Fraction(1, 2)  # of W/P: a drive that is later than this needs another tube, and no search is made
RETREATS = tuple(Fraction(k, 100) for k in (100, 99, 97, 90))  # of a searched value, until it is proved with few digits
SHARES = tuple(Fraction(k, 20) for k in range(18, 3, -1))  # of the starts, which a refusal tries


def prove_late_period(task: Task, loop: PathLoop, rho_of_conditions: Sequence[Fraction] | None) -> PeriodProof | None:
    """Prove the task's period by the path; None where it does not.

    rho_of_conditions: e^E by component as the sharp conditions prove it for such an age. The path takes it where that is larger,
    so that theorems about these conditions are about the same numbers.
    """
    proof = prove_path(loop)
    if proof is not None and rho_of_conditions is not None:
        proof = prove_path_for(loop, [max(pair) for pair in zip(proof.rho, rho_of_conditions, strict=True)]) or proof
    return None if proof is None else _period_proof(task, loop, proof)


def _period_proof(task: Task, loop: PathLoop, proof: PathProof) -> PeriodProof:
    return PeriodProof(
        period=task.sampling_period,
        latency=task.control.latency,
        share=task.initial_set.share,
        rho=proof.rho,
        u=proof.u,
        shift=tuple(law.shift for law in loop.laws),
        paths=tuple(PathClaim(path.nearest, path.history) for path in proof.paths),
    )


def disturbances(task: Task) -> list[Fraction]:
    """Return the bounds on |f + w| by component."""
    return [bounds.force for bounds in task.plant_bounds]


def drive_words(task: Task) -> list[str]:
    """Return what the proof assumes of when inputs act, in words; empty where they act at once."""
    drives, words = task.drive_bounds, []
    if task.control.latency:
        words.append(f"u acts at most {decimal(task.control.latency)} s after its sample")
    lags = [by_component(values) for values in ([d.lag for d in drives], [d.lag2 for d in drives]) if any(values)]
    kinds = []
    if len(lags) > 1:
        kinds.append(f"is no slower than two first-order lags in series, of {' s and '.join(lags)} s")
    elif lags:
        exponent = "lag" if lags[0].startswith("[") else lags[0]
        answer = f" (its step response never falls and is never below 1 - e^(-t/{exponent}))"
        kinds.append(f"is no slower than a first-order lag of {lags[0]} s{'' if any(d.overshoot for d in drives) else answer}")
    if any(d.slew for d in drives):
        kinds.append(f"follows u by at least {by_component([d.slew or Fraction(0) for d in drives])} a second")
    if any(d.overshoot for d in drives):
        kinds.append(f"overshoots a step by at most {by_component([d.overshoot for d in drives])} of it")
    if kinds:
        words.append(f"a drive that {', '.join(kinds[:-1])}{' and ' * (len(kinds) > 1)}{kinds[-1]}, at rest at 0")
    return words


def late_advice(task: Task, loop: PathLoop) -> str:
    """Return what would be proved where the task's drive and period are not: each remedy was tried."""
    if task.uses_differences:
        return DIFFERENCES_ADVICE
    delay, crossing = _delay_beside_tube(loop)
    if delay > PROMISING_DELAY_SHARE * crossing:
        late = f"the drive's delay + 0.6 (period + latency) is {above(delay, 3):g} s"
        speed = f"width over closing speed is {below(crossing, 3):g} s"
        why = f"inputs are too late for this tube: {late}, and {speed}, of which about a fifth is proved"
        remedies = [*_quicker_drives(task, loop), *_shorter_periods(task, loop)]
        return f"{why}; use {', or '.join(remedies)}" if remedies else why
    remedies = list(_remedies(task, loop))
    if remedies:
        return f"use {', or '.join(remedies)}"
    return "nothing that was tried is proved: widen or slow the tube, raise control.u_max, or state a milder plant"


def _delay_beside_tube(loop: PathLoop) -> tuple[Fraction, Fraction]:
    """Return the largest delay of a drive with 0.6 of the age of a sample, and the least W/P of any window, in seconds."""
    delays = (drive.delay(law.u_max or Fraction(1)) for drive, law in zip(loop.drives, loop.laws, strict=True))
    crossings = (window.narrow / window.closing_speed for windows in loop.windows for window in windows if window.closing_speed)
    return max(delays) + Fraction(3, 5) * loop.age, min(crossings, default=Fraction(1))


def _remedies(task: Task, loop: PathLoop) -> Iterator[str]:
    """Yield changes of the task with which the path proves it, one at a time; those but the first keep this gain."""
    sign = 1 if task.gain[0] > 0 else -1
    with_this_gain = f"with gain {by_component(task.gain)}"
    choice = choose_path_gain(loop, disturbances(task), task.resting_error, task.reserve)
    if choice is not None:
        chosen = by_component([sign * v for v in choice.gain])
        yield f'control.gain = "auto" (here {chosen})' if sign > 0 else f"control.gain = {chosen}"
    yield from _shorter_periods(task, loop)
    yield from _quicker_drives(task, loop)
    share = _smaller_share(task, loop) if task.order == 1 else None
    if share is not None:
        yield f"initial_set.share = {decimal(share)} {with_this_gain}"


def _shorter_periods(task: Task, loop: PathLoop) -> Iterator[str]:
    """Yield the longest period that the path proves with the task's gain."""
    period = longest_path_period(loop, task.sampling_period)
    for value in [] if period is None else [period * retreat for retreat in RETREATS]:
        rounded = Fraction(str(below(value, 3)))
        if prove_path(loop.with_period(rounded)) is not None:
            yield f"control.period = {decimal(rounded)} with gain {by_component(task.gain)}"
            break


def _quicker_drives(task: Task, loop: PathLoop) -> Iterator[str]:
    """Yield the slowest drive of this kind that the path proves with the task's gain, where the task's is slower."""
    factor = largest_drive_factor(loop) if any(drive.delay(Fraction(1)) for drive in loop.drives) else None
    for value in [] if factor is None or factor >= 1 else [factor * retreat for retreat in RETREATS]:
        drives = [_quicker(bounds, value) for bounds in task.drive_bounds]
        if prove_path(loop.with_drives([Drive.of(bounds) for bounds in drives])) is not None:
            yield f"a drive with {_written(drives)} with gain {by_component(task.gain)}"
            break


def _quicker(bounds: DriveBounds, factor: Fraction) -> DriveBounds:
    """Return a drive that takes this part of the time, in numbers of 3 digits that make it no slower than that."""
    lag, lag2 = (Fraction(str(below(v * factor, 3))) for v in (bounds.lag, bounds.lag2))
    slew = None if bounds.slew is None else Fraction(str(above(bounds.slew / factor, 3)))
    return DriveBounds(lag, lag2, slew, bounds.overshoot)


def _written(drives: Sequence[DriveBounds]) -> str:
    """Write lags and slew as a task file states them."""
    stated = {name: [getattr(bounds, name) for bounds in drives] for name in ("lag", "lag2", "slew")}
    return " and ".join(f"plant.{name} = {by_component(values)}" for name, values in stated.items() if any(values))


def _smaller_share(task: Task, loop: PathLoop) -> Fraction | None:
    """Return the largest share of the starts below the task's with which the path proves the task; None where none does."""
    for share in SHARES:
        if share < task.initial_set.share:
            laws = [replace(law, rho_at_start=(1 + share) / (1 - share)) for law in loop.laws]
            if prove_path(loop.with_laws(laws)) is not None:
                return share
    return None
