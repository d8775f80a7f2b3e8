"""Axes that close, such as an angle: the task is expanded to one without periods, which every later stage reads.

    periodic = { yaw = 6.283185307179586 }      # x and x + 6.28.. in yaw are the same angle

    unsafe sets     with all images, k periods up or down, that can come near the state space
    target          moved by the number of turns that brings it nearest to the initial state
    state space     where it is at least a period wide in a closed axis, it means any angle: half a turn beyond start and target
    clearance       increased by |k| times the drift: how far the period is from the 2 pi/m that it stands for; the target shrinks
    noise           increased by the error of unwrapping, where the task has plant bounds or a period

Of a clearance or a noise by component every entry is increased by the same.

Everything is exact. docs/certificate-format.md has the same rules for the stand-alone checker, which applies them by itself.
`Task` calls `expand_turns` when it is made; the emitted unwrapping reads the `ClosedAxis` values.

Long because state space, target, unsafe sets and measurements follow from one choice of turns, and every message stands here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput
from stt_codegen.task.schema import TaskTables
from stt_codegen.task.sets import Target, Unsafe, UnsafeHalfSpaces, UnsafePolytope, Vector, fields_of_shape
from stt_codegen.task.values import MAX_IMAGES

TWO_PI = Fraction("6.28318530717958647692528676655900576839433879875021")  # 50 digits, truncated
TWO_PI_ERROR = Fraction(1, 10**49)  # by less than this 2 pi is above TWO_PI
DRIFT_PARTS, ERROR_PARTS = 10**18, 10**12  # a drift and an unwrapping error are rounded up to such a part of 1
DIVISORS = range(1, 13)  # 2 pi/m: an axis whose positions look alike m times a turn
NEAR_TWO_PI = Fraction(1, 1000)  # relative: a period so near to 2 pi/m stands for it
IMAGE_MARGIN = Fraction(1, 8)  # of a period: images farther from the state space than clearance, body and this are left out
TURN_COUNT_LIMIT = 100  # between 0 and the far edge of the state space
SET_TURNS_LIMIT = 64  # turns from the initial state within which half-spaces must bound a set
ROUNDOFF = {"float": Fraction(1, 1 << 24), "double": Fraction(1, 1 << 53)}


@dataclass(frozen=True, kw_only=True)
class ClosedAxis:
    """One axis that closes; lengths are in the axis's unit.

    drift: a bound on how far the period is from 2 pi/m, or 0; is_limited: whether the state space limits the axis; target_turns:
    the turns by which the target was moved; nearest_turns: the turns that it would be moved by without that limit; image_turns:
    the maximum of the turns of images of unsafe sets; unwrap_error: a bound on the error of an unwrapped measurement;
    largest_step: x must move by less than this between two measurements.
    """

    index: int
    period: Fraction
    drift: Fraction
    is_limited: bool
    target_turns: int
    nearest_turns: int
    image_turns: int = 0
    unwrap_error: Fraction = Fraction(0)
    largest_step: Fraction = Fraction(0)


@dataclass(frozen=True)
class SetImage:
    """An image of unsafe set `source` of the file, moved by `turns` in each of the closed axes that the set has."""

    source: int
    turns: tuple[int, ...]


def drift_of(period: Fraction) -> Fraction:
    """Return the distance of a period from 2 pi/m, rounded up to a multiple of 1e-18, where it is near one of these; else 0."""
    for m in DIVISORS:
        distance = abs(period - TWO_PI / m)
        if distance <= NEAR_TWO_PI * TWO_PI / m:
            return Fraction(math.ceil((distance + TWO_PI_ERROR) * DRIFT_PARTS), DRIFT_PARTS)
    return Fraction(0)


def turns_problem(task: TaskTables) -> str | None:
    """Return a message where a field of the task has no meaning beside axes that close, else None."""
    names, closed = task.axis_names, task.periodic or {}
    for name in closed:
        if name not in names:
            return f"periodic.{name}: is no axis; use one of {', '.join(names)}"
    if task.emit.scalar == "fixed":
        return 'periodic: is for floating point, whose <p>_unwrap takes real numbers; use emit.scalar = "float" or "double"'
    for k, region in enumerate(task.region):
        axes = getattr(region, "axes", None)
        closed_names = [] if hasattr(region, "any_of") else [name for name in axes or names if name in closed]
        if closed_names:
            open_names = [name for name in axes or names if name not in closed]
            remedy = f"give it axes = [{', '.join(map(repr, open_names))}]" if open_names else "leave it out"
            problem = f"is in {closed_names[0]}, which closes, and missions know no turns"
            return f"region[{k}]: {problem}; {remedy}, or leave periodic out"
    return None


class _TurnExpansion:
    """The expansion of a task with closed axes: the turns chosen for each axis, and the edges of the state space."""

    def __init__(self, task: TaskTables) -> None:
        self.task, self.body = task, task.half_extents
        self.lower, self.upper = list(task.state_space.lower), list(task.state_space.upper)
        periods = sorted((task.axis_names.index(name), period) for name, period in (task.periodic or {}).items())
        self.target = task.target_set
        box = task.target
        self.axes = [self._choose_turns(i, period, box.lower[i], box.upper[i]) for i, period in periods]

    def _bounds_target(self, i: int) -> bool:
        """Whether the target is bounded in dimension i."""
        target = self.task.target_set
        return target is not None and (bool(target.lower) or i in self.task.axis_indices(target))

    def _choose_turns(self, i: int, period: Fraction, low: Fraction, high: Fraction) -> ClosedAxis:
        """Choose the target's turns in axis i and set the edges of the state space there. low, high: the target's edges."""
        task, name = self.task, self.task.axis_names[i]
        drift, is_limited = drift_of(period), self.upper[i] - self.lower[i] < period
        if not is_limited and any(normal[i] for normal, _ in task.space_cuts):
            field = task.state_space.points[0]
            raise BadInput(
                f"state_space.{field}: cut {name}, which closes, and of which the state space has a whole turn; make it narrower "
                f"than {decimal(period)} there, or leave {name} out of their axes"
            )
        nearest = turns = 0
        if self._bounds_target(i):
            exact_turns = (task.initial_state[i] - (low + high) / 2) / period
            candidates = sorted(
                range(math.floor(exact_turns) - TURN_COUNT_LIMIT, math.ceil(exact_turns) + TURN_COUNT_LIMIT + 1),
                key=lambda k: (abs(k - exact_turns), abs(k), -k),
            )
            nearest = turns = candidates[0]
            if is_limited:
                first, last = self.lower[i] + self.body[i], self.upper[i] - self.body[i]
                within_limits = [k for k in candidates if first <= low + k * period and high + k * period <= last]
                if not within_limits:
                    raise BadInput(
                        f"target_set: none of its images in {name}, every {decimal(period)}, lies in the state space, which is a "
                        f"limit there, {decimal(self.upper[i] - self.lower[i])} wide; move the target, or widen the state space "
                        f"to {decimal(period)}, which is any angle"
                    )
                turns = within_limits[0]
        if not is_limited:
            ends = [(task.start.lower[i], task.start.upper[i])]
            if self._bounds_target(i):
                ends.append((low + turns * period, high + turns * period))
            self.lower[i] = min(a for a, _ in ends) - period / 2
            self.upper[i] = max(b for _, b in ends) + period / 2
        return ClosedAxis(index=i, period=period, drift=drift, is_limited=is_limited, target_turns=turns, nearest_turns=nearest)

    # ---- unsafe sets

    def closed_axes_of(self, table: Unsafe) -> list[ClosedAxis]:
        """Return the closed axes among the axes of a set."""
        axes = self.task.axis_indices(table)
        return [axis for axis in self.axes if axis.index in axes]

    def images(self, j: int, table: Unsafe) -> Iterator[tuple[Unsafe, SetImage]]:
        """Yield the images of unsafe set j, without the set itself, each with its turns."""
        closed, axes = self.closed_axes_of(table), self.task.axis_indices(table)
        ranges = [self._turns(table, axes.index(axis.index), axis) for axis in closed]
        count = math.prod(map(len, ranges))
        if count > MAX_IMAGES:
            names = ", ".join(self.task.axis_names[axis.index] for axis in closed)
            raise BadInput(
                f"unsafe[{j}] ({table.name}): has {count} images in the state space, as it is many turns long in {names}; at "
                f"most {MAX_IMAGES} are taken: name its other axes in `axes`, where it is unsafe at any angle"
            )
        for turns in product(*ranges):
            if any(turns):
                by = {axes.index(axis.index): k * axis.period for axis, k in zip(closed, turns, strict=True)}
                moved = translated(table, by, table.point_fields)
                suffix = "".join(f"{k:+d}" for k in turns)
                yield moved.model_copy(update={"name": table.name + suffix}), SetImage(j, turns)

    def _turns(self, table: Unsafe, at: int, axis: ClosedAxis) -> list[int]:
        """Return the turns by which the set, at any time, can come near the state space, 0 among them, smallest first.

        at: the index of the axis among those of the set.
        """
        i, task = axis.index, self.task
        ends = table.to_convex_set((), ()).span(at)
        by = [point.by[at] for point in table.motion or ()] or [Fraction(0)]
        growth = (table.spread or 0) * (task.prescribed_time + (table.timing or 0) + task.start_delay)
        reach = task.clearances[i] + self.body[i] + growth + IMAGE_MARGIN * axis.period
        first = math.ceil((self.lower[i] - reach - ends[1] - max(by)) / axis.period)
        last = math.floor((self.upper[i] + reach - ends[0] - min(by)) / axis.period)
        return sorted({0, *range(first, min(last, first + MAX_IMAGES) + 1)}, key=lambda k: (abs(k), -k))

    def as_points(self, j: int, table: Unsafe) -> Unsafe:
        """Return half-spaces in a closed axis as the corners of their intersection with the state space; other tables unchanged.

        Raises `BadInput` where a set cannot be translated, or where the half-spaces leave it unbounded in a closed axis."""
        closed = {axis.index: axis.period for axis in self.closed_axes_of(table)}
        if not closed or table.point_fields:
            return table
        if not isinstance(table, UnsafeHalfSpaces):
            field = next(name for name in fields_of_shape(type(table)))
            raise BadInput(f"unsafe[{j}].{field}: is not known in an axis that closes; leave it out, or periodic")
        axes, state = self.task.axis_indices(table), self.task.initial_state
        distances = [SET_TURNS_LIMIT * closed.get(i, Fraction(0)) for i in axes]
        lower = tuple(state[i] - d if i in closed else self.lower[i] for i, d in zip(axes, distances, strict=True))
        upper = tuple(state[i] + d if i in closed else self.upper[i] for i, d in zip(axes, distances, strict=True))
        try:
            corners = table.to_convex_set(lower, upper).vertices
        except ValueError as error:
            raise BadInput(f"unsafe[{j}].{error}") from None
        for at, i in enumerate(axes):
            if i in closed and not all(lower[at] < p[at] < upper[at] for p in corners):
                name = self.task.axis_names[i]
                raise BadInput(
                    f"unsafe[{j}].normals: leave the set open in {name}, which closes, so its images would be everywhere; close "
                    f"it with normals that bound {name} from both sides, or leave {name} out of its axes"
                )
        fields = {name: getattr(table, name) for name in table.model_fields_set - {"normals", "offsets", "name"}}
        return UnsafePolytope.model_construct(**fields, vertices=corners, name=table.name)

    # ---- the target

    def moved_target(self, space: TaskTables) -> Target | None:
        """Return the target moved by its turns, smaller by the drift of the periods. space: the task with its new state space."""
        target = self.target
        moved = [axis for axis in self.axes if axis.target_turns]
        if target is None or not moved:
            return target
        axes = self.task.axis_indices(target)
        by = {axis.index: axis.target_turns * axis.period for axis in moved}
        drift = {axis.index: abs(axis.target_turns) * axis.drift for axis in moved}
        if not any(drift.values()):
            shifted = translated(target, {at: by[i] for at, i in enumerate(axes) if i in by}, ("vertices", "centre"))
            shifted = translated(shifted, by, ("lower", "upper"))
            return _with_half_spaces(shifted, [(c, h + _offset_change(c, axes, by)) for c, h in _half_spaces_of(target)])
        box = target.box(space.free_space, axes)
        lower = tuple(v + by.get(i, 0) + drift.get(i, 0) for i, v in enumerate(box.lower))
        upper = tuple(v + by.get(i, 0) - drift.get(i, 0) for i, v in enumerate(box.upper))
        if any(a >= b for a, b in zip(lower, upper, strict=True)):
            raise BadInput("target_set: is narrower than what its turns differ from 2 pi; write more digits of the period")
        half_spaces = [
            (c, h + _offset_change(c, axes, by) - _offset_change(map(abs, c), axes, drift)) for c, h in target.half_spaces()
        ]
        fields = {name: getattr(target, name) for name in target.model_fields_set & {"axes", "motion"}}
        return _with_half_spaces(Target.model_construct(**fields, lower=lower, upper=upper), half_spaces)


def _offset_change(normal: Any, axes: tuple[int, ...], by: dict[int, Fraction]) -> Fraction:
    """Return the change of a half-space's offset where its points are displaced. by: displacements by axis."""
    return sum((c * by.get(i, Fraction(0)) for c, i in zip(normal, axes, strict=True)), Fraction(0))


def _half_spaces_of(target: Target) -> list[tuple[Vector, Fraction]]:
    """Return the half-spaces of a target's fields, with the normals of the file."""
    return list(zip(target.normals or (), target.offsets or (), strict=True))


def _with_half_spaces(target: Target, half_spaces: list[Any]) -> Target:
    """Return the target with these half-spaces; unchanged where there are none."""
    if not half_spaces:
        return target
    normals = tuple(tuple(Fraction(c) for c in normal) for normal, _ in half_spaces)
    return target.model_copy(update={"normals": normals, "offsets": tuple(offset for _, offset in half_spaces)})


def translated(table: Any, by: dict[int, Fraction], fields: tuple[str, ...]) -> Any:
    """Return the table of a set with its points displaced.

    by: displacements by the index of a point's entry; fields: the names of fields that are points or lists of points."""

    def displaced(value: Any) -> Any:
        if value and isinstance(value[0], tuple):
            return tuple(map(displaced, value))
        return tuple(v + by.get(at, Fraction(0)) for at, v in enumerate(value))

    changes = {name: displaced(value) for name in fields if (value := getattr(table, name, None))}
    return table.model_copy(update=changes)


def expand_turns(task: TaskTables) -> tuple[dict[str, Any], tuple[ClosedAxis, ...], tuple[SetImage, ...]]:
    """Return the changed fields of a task with its turns expanded, its closed axes, and for each unsafe set its source.

    Raises `BadInput` where the task has no such expansion."""
    expansion = _TurnExpansion(task)
    space = task.state_space.model_copy(update={"lower": tuple(expansion.lower), "upper": tuple(expansion.upper)})
    target = expansion.moved_target(task.model_copy(update={"state_space": space}))
    sets = [expansion.as_points(j, table) for j, table in enumerate(task.unsafe)]
    images = [
        pair for j, table in enumerate(sets) for pair in (expansion.images(j, table) if expansion.closed_axes_of(table) else ())
    ]
    _require_free_names(task, images)
    sources = [SetImage(j, ()) for j in range(len(sets))] + [image for _, image in images]
    pairs = [(image, sets[image.source]) for _, image in images]
    axes = tuple(_with_errors(task, expansion, axis, pairs) for axis in expansion.axes)
    image_drift = max(axis.image_turns * axis.drift for axis in axes)
    clearance = _raised(task.tube.clearance, image_drift)
    changes: dict[str, Any] = {
        "state_space": space, "target_set": target, "unsafe": (*sets, *(table for table, _ in images)),
        "tube": task.tube.model_copy(update={"clearance": clearance}) if image_drift else task.tube,
    }  # fmt: skip
    if task.plant.is_stated or task.control.period is not None:
        noise = _raised(task.plant.noise or Fraction(0), max(axis.unwrap_error for axis in axes))
        changes["plant"] = task.plant.model_copy(update={"noise": noise})
    return changes, axes, tuple(sources)


def _raised(value: Fraction | tuple[Fraction, ...], by: Fraction) -> Fraction | tuple[Fraction, ...]:
    """Return a number, or the number of each component, raised by the same amount."""
    return tuple(v + by for v in value) if isinstance(value, tuple) else value + by


def _require_free_names(task: TaskTables, images: list[tuple[Unsafe, SetImage]]) -> None:
    """Raise `BadInput` where a set of the file has the name of an image; equal names in the file are refused elsewhere."""
    named = {table.name: j for j, table in enumerate(task.unsafe)}
    for table, image in images if len(named) == len(task.unsafe) else ():
        if table.name in named:
            j, name = named[table.name], task.unsafe[image.source].name
            raise BadInput(f"unsafe[{j}].name: {table.name!r} is what an image of {name} is called; choose another")
        named[table.name] = image.source


def _with_errors(
    task: TaskTables, expansion: _TurnExpansion, axis: ClosedAxis, images: list[tuple[SetImage, Unsafe]]
) -> ClosedAxis:
    """Return a closed axis with the turns of its images, the error of unwrapping and the largest step between measurements.

    Unwrapping adds k periods P to a measurement y, |y| <= P. k P is off by |k| drift and, as P is rounded to the scalar,
    by |k| u P. Rounding of y, of the product and of the sum adds u P, u |k| P, u (|k| + 1) P and a few u^2. Together the rounding
    is at most (3 |k| + 3) u P. u: the unit roundoff of the scalar.
    """
    i, period, u = axis.index, axis.period, ROUNDOFF[task.emit.scalar]
    pairs = (zip(expansion.closed_axes_of(table), image.turns, strict=True) for image, table in images)
    turns = [abs(k) for pair in pairs for closed, k in pair if closed.index == i]
    largest = max(abs(expansion.lower[i]), abs(expansion.upper[i]))
    counted_turns, name = int(largest / period) + 2, task.axis_names[i]
    if max(counted_turns, *turns, 0) > TURN_COUNT_LIMIT:
        field = "initial_set" if counted_turns > TURN_COUNT_LIMIT else "unsafe"
        problem = f"more than {TURN_COUNT_LIMIT} turns would be counted in {name}"
        raise BadInput(f"{field}: {problem}; write {name} nearer to 0 everywhere")
    error_bound = counted_turns * axis.drift + u * period * (3 * counted_turns + 3)
    error = Fraction(math.ceil(error_bound * ERROR_PARTS), ERROR_PARTS)
    step = period / 2 - 2 * (task.noise[i] + error) - 4 * error
    x, start = task.initial_state[i], task.start
    if step <= 0:
        field = f"plant.noise[{i}]" if isinstance(task.plant.noise, tuple) else "plant.noise"
        raise BadInput(f"{field}: is {decimal(task.noise[i])}, and then turns of {name} cannot be distinguished")
    if max(x - start.lower[i], start.upper[i] - x) >= step:
        raise BadInput(
            f"initial_set: reaches half a turn from initial_state in {name}, and a first measurement is unwrapped from there; "
            f"keep it within {decimal(step)}"
        )
    return ClosedAxis(
        index=i,
        period=period,
        drift=axis.drift,
        is_limited=axis.is_limited,
        target_turns=axis.target_turns,
        nearest_turns=axis.nearest_turns,
        image_turns=max(turns, default=0),
        unwrap_error=error,
        largest_step=step,
    )
