"""What in a task can be made easier, the cheapest change first: the tool's own settings, sampling, times, the tube, the robot.

An adjustment is one option of the task file with steps from a mild to a strong change. It is tried where it can matter: for the
properties that fail, and where the task states the option at all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from stt_codegen.decimals import above, below
from stt_codegen.errors import Reason
from stt_codegen.properties import OF_THE_EDGES, Property
from stt_codegen.remedies.changes import Change, Edit, Value
from stt_codegen.task import Task

Numbers = Fraction | tuple[Fraction, ...]  # of an option: one, or one by component
Factors = tuple[Fraction, ...]
DIGITS = 3  # of a number in a change
RAISING = tuple(Fraction(v) for v in ("1.1", "1.5", "2.5", "6"))  # times the value
RAISING_FAR = (*RAISING, *(Fraction(v) for v in ("30", "300", "1e4", "1e6", "1e8")))  # of a limit on the tube
LOWERING = tuple(Fraction(v) for v in ("0.85", "0.5", "0.2", "0.05"))
REMOVING = (*LOWERING, Fraction(0))
ADVANCES = tuple(Fraction(v) for v in ("1.01", "1.1", "1.5", "3"))  # times a control.u_norm that just balances what acts
# times a value at which a property would just hold
RETREATS = tuple(Fraction(v) for v in ("0.999", "0.98", "0.9", "0.7", "0.4", "0.1"))
SHARES = tuple(Fraction(v) for v in ("0.8", "0.6", "0.4", "0.2"))  # of the start box

EDGES = frozenset(p.code for p in OF_THE_EDGES if p is not Property.START)
WIDTH, START, SPEED, LIMITS, PERIOD, ARITHMETIC = (
    p.code for p in (Property.WIDTH, Property.START, Property.SMOOTH, Property.LIMITS, Property.PERIOD, Property.ARITHMETIC)
)
MOTION = frozenset({SPEED, LIMITS, PERIOD})
INPUT = frozenset({LIMITS, PERIOD})
ALL_CODES = frozenset(p.code for p in Property)


@dataclass(frozen=True)
class Adjustment:
    """One way to make a task easier.

    codes: of the properties that it can help. change: the change for a factor. factors: from a mild to a strong change; the best
    between two of them is searched for, unless there is one alone. unchanged: the factor that changes nothing.
    """

    codes: frozenset[str]
    change: Callable[[Fraction], Change]
    factors: Factors
    unchanged: Fraction = Fraction(1)

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of the task file that it changes."""
        return tuple(edit.key for edit in self.change(self.factors[-1]).edits)

    @property
    def leaves_out_an_entry(self) -> bool:
        """Whether it is a mission without one of its entries."""
        return any(edit.value is None and edit.key.endswith("]") for edit in self.change(self.factors[-1]).edits)

    @property
    def is_choice(self) -> bool:
        """Whether the adjustment has one value alone."""
        return len(self.factors) == 1


def adjustments_of(task: Task, reason: Reason) -> Iterator[Adjustment]:
    """Yield the adjustments that may help against the reason of a refusal, the cheapest first.

    Numbers of the axis that fails are changed alone before those of all axes.
    """
    axis, codes = reason.axis, set(reason.codes)
    in_order = (*_settings(task), *_sampling(task), *_times(task), *_tube(task, axis), *_robot(task, axis), *_entries(task))
    known = dict(reason.sufficient)
    ranks = {key: rank for rank, key in enumerate(reason.about)}  # the keys that the problem is about come first, in their order
    useful = [a for a in in_order if (not codes or a.codes & codes) and not task.overridden_keys & set(a.keys)]
    for adjustment in sorted(useful, key=lambda a: min(ranks.get(key, len(ranks)) for key in a.keys)):
        if len(adjustment.keys) == 1 and (value := known.get(adjustment.keys[0])) is not None:
            yield _near(task, adjustment, value)
        else:
            yield adjustment


def _near(task: Task, adjustment: Adjustment, value: Fraction) -> Adjustment:
    """Return the adjustment that tries values near one with which the failing property would just hold.

    They are at and below a sampling period or a bound on the tube, and above a norm of u.
    """
    table, _, key = adjustment.keys[0].partition(".")
    known, steps = value / getattr(getattr(task, table), key), ADVANCES if key == "u_norm" else RETREATS
    return replace(adjustment, factors=tuple(known * step for step in steps), unchanged=known)


def _choice(codes: frozenset[str], key: str, value: Value, remark: str = "") -> Adjustment:
    return Adjustment(codes, lambda _: Change((Edit(key, value),), remark), (Fraction(1),))


def _scaled(codes: frozenset[str], key: str, value: Numbers, factors: Factors, axis: int | None = None) -> Adjustment:
    """Return the adjustment that multiplies a number, or the numbers of all axes, or that of one axis (from 0)."""

    def change(factor: Fraction) -> Change:
        if isinstance(value, tuple):
            scaled: Value = tuple(_rounded(v, factor) if axis in (None, i) else v for i, v in enumerate(value))
        else:
            scaled = _rounded(value, factor)
        return Change((Edit(key, scaled),))

    return Adjustment(codes, change, factors)


def _rounded(value: Fraction, factor: Fraction) -> Fraction:
    """Return a value times a factor with DIGITS digits, rounded so that the change is no smaller."""
    return Fraction(str((above if factor > 1 else below)(value * factor, DIGITS)))


def _settings(task: Task) -> Iterator[Adjustment]:
    """Yield what the tool chooses where the task does not."""
    stated, fields = task.as_stated, task.as_stated.control.model_fields_set
    if task.control.period is not None and "gain" in fields and task.control.gain != "auto":
        yield _choice(frozenset({PERIOD}), "control.gain", "auto")
    if "prefer" in stated.tube.model_fields_set:
        yield _choice(ALL_CODES, "tube.prefer", None)
    if stated.tube.filter not in (None, "auto"):
        yield _choice(ALL_CODES, "tube.filter", "auto")
    if stated.tube.segments is not None:
        yield _choice(ALL_CODES, "tube.segments", None)
    if task.emit.scalar == "float":
        yield _choice(EDGES | {START, ARITHMETIC}, "emit.scalar", "double")
    if task.control.outside != "return" and task.control.period is not None:
        yield _choice(frozenset({PERIOD}), "control.outside", "return")
    if "design" in stated.tube.model_fields_set:
        yield _choice(ALL_CODES, "tube.design", None)


def _sampling(task: Task) -> Iterator[Adjustment]:
    """Yield quicker sampling, a shorter input delay, and a smaller start share."""
    control, codes = task.as_stated.control, frozenset({PERIOD})
    if control.period is not None:
        yield _shorter_periods(task, control.period)
        if control.latency:
            yield _scaled(codes, "control.latency", control.latency, REMOVING)
        if shares := tuple(share for share in SHARES if share < task.initial_set.share):
            yield Adjustment(codes, lambda share: Change((Edit("initial_set.share", share),)), shares, task.initial_set.share)


def _shorter_periods(task: Task, period: Fraction) -> Adjustment:
    """Return the adjustment to a shorter period, which is a number of whole ticks where the task counts them."""
    tick = task.emit.tick_period

    def change(factor: Fraction) -> Change:
        shorter = period * factor
        rounded = _rounded(period, factor) if tick is None else max(shorter // tick, 1) * tick
        return Change((Edit("control.period", rounded),))

    return Adjustment(frozenset({PERIOD}), change, LOWERING)


def _times(task: Task) -> Iterator[Adjustment]:
    """Yield more time: for the task, for entries of its mission, and less timing uncertainty of sets."""
    stated = task.as_stated
    timed = EDGES if task.mission or any(s.motion or s.during for s in stated.unsafe) else frozenset({WIDTH})
    yield from _mission_times(task)
    yield _scaled(MOTION | timed | {ARITHMETIC}, "prescribed_time", task.prescribed_time, RAISING)
    if stated.start_delay:
        yield _scaled(EDGES | MOTION, "start_delay", stated.start_delay, REMOVING)
    for key in ("timing", "spread"):
        values = [(k, getattr(s, key)) for k, s in enumerate(stated.unsafe) if getattr(s, key)]
        if values:
            yield _scaled_together(EDGES, [(f"unsafe[{k}].{key}", value) for k, value in values], REMOVING)


def _scaled_together(
    codes: frozenset[str], values: Sequence[tuple[str, Numbers]], factors: Factors, axis: int | None = None
) -> Adjustment:
    """Return the adjustment that multiplies several values by one factor, of lists the entry of one axis where it is given."""
    parts = [_scaled(codes, key, value, factors, axis) for key, value in values]
    return Adjustment(codes, lambda factor: Change(tuple(e for part in parts for e in part.change(factor).edits)), factors)


def _alone_then_all(
    codes: frozenset[str], values: Sequence[tuple[str, Numbers]], factors: Factors, axis: int | None
) -> Iterator[Adjustment]:
    """Yield the adjustment of an axis that fails alone, where each value is a list with a number for it, and that of all axes."""
    if axis is not None and values and all(isinstance(value, tuple) for _, value in values):
        of_axis = [(key, value) for key, value in values if isinstance(value, tuple) and value[axis]]
        if of_axis:
            yield _scaled_together(codes, of_axis, factors, axis)
    if values and any(_has_any(value) for _, value in values):
        yield _scaled_together(codes, values, factors)


def _mission_times(task: Task) -> Iterator[Adjustment]:
    """Yield each time of a mission's entry that may change: windows are wider, a stay is shorter, a round longer."""
    t_c, codes = task.prescribed_time, EDGES | MOTION
    for k, entry in enumerate(task.mission):
        key = f"mission[{k}]"
        if entry.between is not None:
            first, last = entry.between
            latest = max(last, t_c - (entry.stay or 0))
            if latest > last:
                yield _towards(codes, f"{key}.between", last, latest, lambda v, first=first: (first, v))  # type: ignore[misc]
            if first > 0:
                yield _towards(codes, f"{key}.between", first, Fraction(0), lambda v, last=last: (v, last))  # type: ignore[misc]
        if entry.stay:
            yield _towards(codes, f"{key}.stay", entry.stay, Fraction(0), lambda v: v)
        if entry.within is not None and t_c > entry.within:
            yield _towards(codes, f"{key}.within", entry.within, t_c, lambda v: v)
        if entry.every is not None and (entry.until or t_c) > entry.every:
            yield _towards(codes, f"{key}.every", entry.every, entry.until or t_c, lambda v: v)


def _towards(
    codes: frozenset[str], key: str, now: Fraction, loosest: Fraction, value_of: Callable[[Fraction], Value]
) -> Adjustment:
    """Return the adjustment that moves a time towards the loosest value; a factor is the part of that way."""

    def change(part: Fraction) -> Change:
        time = now + part * (loosest - now)
        rounded = Fraction(str((above if loosest > now else below)(time, DIGITS))) if 0 < part < 1 else time
        return Change((Edit(key, value_of(rounded)),))

    return Adjustment(codes, change, (Fraction(1, 8), Fraction(1, 2), Fraction(1)), unchanged=Fraction(0))


def _tube(task: Task, axis: int | None) -> Iterator[Adjustment]:
    """Yield weaker limits on the tube's edges, less clearance and a narrower tube; of a list the entry of the axis first."""
    tube, codes = task.tube, EDGES | MOTION | {START}
    for key, value in (("tube.max_speed", tube.max_speed), ("tube.max_acceleration", tube.max_acceleration)):
        if value is not None:
            yield _scaled(MOTION, key, value, RAISING_FAR)
    for key, value in (("tube.clearance", tube.clearance), ("tube.min_width", tube.min_width)):
        yield from _alone_then_all(codes, [(key, value)], REMOVING, axis)


def _robot(task: Task, axis: int | None) -> Iterator[Adjustment]:
    """Yield more input, a quicker drive, better sensors, and milder bounds on the plant."""
    control, plant = task.as_stated.control, task.as_stated.plant
    if control.u_max is not None and not isinstance(control.u_max, str):
        if control.period is not None:
            yield _choice(INPUT, "control.u_max", "auto")
        if axis is not None and task.dimension > 1 and task.u_max is not None:
            yield _scaled(MOTION, "control.u_max", task.u_max, RAISING, axis)
        yield _scaled(MOTION, "control.u_max", control.u_max, RAISING)
    if control.u_norm is not None:
        yield _scaled(MOTION, "control.u_norm", control.u_norm, RAISING)
    drive = [(f"plant.{k}", v, REMOVING) for k in ("lag", "lag2", "overshoot") if (v := getattr(plant, k)) and _has_any(v)]
    drive += [("plant.slew", plant.slew, RAISING)] if plant.slew is not None else []
    for key, value, factors in drive:
        yield from _alone_then_all(frozenset({PERIOD}), [(key, value)], factors, axis)
    noise, forces, coupling = (
        [(f"plant.{k}", v) for k in keys if (v := getattr(plant, k)) and _has_any(v)]
        for keys in (("noise", "noise_v"), ("f_max", "w_max"), ("g_cross",))
    )
    yield from _alone_then_all(frozenset({PERIOD}), noise, REMOVING, axis)
    if any(v is not None for v in (control.u_max, control.u_norm, control.period)):
        yield from _alone_then_all(INPUT, forces, REMOVING, axis)
    yield from _alone_then_all(INPUT, coupling, REMOVING, axis)
    if task.order == 2 and any(task.start_speed):
        speed = task.as_stated.initial_set.speed
        if speed is not None:
            yield _scaled(frozenset({START}), "initial_set.speed", speed, REMOVING)


def _entries(task: Task) -> Iterator[Adjustment]:
    """Yield the mission without one of its entries."""
    for k, entry in enumerate(task.mission):
        if len(task.mission) > 1:
            yield _choice(EDGES | MOTION, f"mission[{k}]", None, entry.title())


def _has_any(value: Numbers) -> bool:
    return any(value) if isinstance(value, tuple) else bool(value)
