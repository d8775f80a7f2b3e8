"""Axes that close, such as an angle: the task with its turns spelled out, as every later stage takes it.

    periodic = { yaw = 6.283185307179586 }      # x and x + 6.28.. in yaw are one place

    unsafe sets     each joined by its images, k periods up or down, that can come near the state space
    target          moved by the number of turns that brings it nearest to the initial state
    state space     in a closed axis at least a period wide: any angle, taken as half a turn beyond start and target
    clearance       more by |k| times what the period differs from 2 pi/m, where that is what it stands for; the target less
    noise           more by what unwrapping is wrong by, where [plant] or a period is stated

Everything is exact. docs/certificate-format.md has the same rules for the stand-alone checker, which applies them by itself.

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

TWO_PI = Fraction("6.28318530717958647692528676655900576839433879875021")  # 50 digits, cut off
PI_STEP, DRIFT_STEP, ERROR_STEP = Fraction(1, 10**49), 10**18, 10**12
DIVISORS = range(1, 13)  # 2 pi/m: an axis whose positions look alike m times a turn
NEAR_TWO_PI = Fraction(1, 1000)  # relative: a period so near to 2 pi/m stands for it
REACH = Fraction(1, 8)  # of a period: images that are farther than clearance, body and this from the state space are left out
MAX_WHOLE_TURNS = 100  # between 0 and the state space's far edge
LONGEST_SET = 64  # turns from the initial state within which half-spaces must end
ROUNDOFF = {"float": Fraction(1, 1 << 24), "double": Fraction(1, 1 << 53)}


@dataclass(frozen=True, kw_only=True)
class ClosedAxis:
    """One axis that closes. drift: what the period differs from 2 pi/m at most, a turn, or 0; is_limited: the state space is a
    limit there; target_turns: by which the target was moved; nearest_turns: by which it would be without that limit; most_turns:
    of an image of an unsafe set; unwrap_error: of an unwrapped measurement; largest_step: by less than this x may move between
    two measurements. Lengths in the axis's unit."""

    index: int
    period: Fraction
    drift: Fraction
    is_limited: bool
    target_turns: int
    nearest_turns: int
    most_turns: int = 0
    unwrap_error: Fraction = Fraction(0)
    largest_step: Fraction = Fraction(0)


@dataclass(frozen=True)
class Image:
    """A set of the task, by its place in the file, moved by turns in each closed axis."""

    source: int
    turns: tuple[int, ...]


def drift_of(period: Fraction) -> Fraction:
    """What the period differs from 2 pi/m, rounded up to a multiple of 1e-18, where it is within a thousandth of that; else 0."""
    for m in DIVISORS:
        off = abs(period - TWO_PI / m)
        if off <= NEAR_TWO_PI * TWO_PI / m:
            return Fraction(math.ceil((off + PI_STEP) * DRIFT_STEP), DRIFT_STEP)
    return Fraction(0)


def turns_problem(task: TaskTables) -> str | None:
    """What of the task has no meaning where axes close."""
    names, closed = task.axis_names, task.periodic or {}
    for name in closed:
        if name not in names:
            return f"periodic.{name}: is no axis; use one of {', '.join(names)}"
    if task.emit.scalar == "fixed":
        return 'periodic: is for floating point, whose <p>_unwrap takes real numbers; use emit.scalar = "float" or "double"'
    for k, region in enumerate(task.region):
        axes = getattr(region, "axes", None)
        hit = [] if hasattr(region, "any_of") else [name for name in axes or names if name in closed]
        if hit:
            rest = [name for name in axes or names if name not in closed]
            remedy = f"give it axes = [{', '.join(map(repr, rest))}]" if rest else "leave it out"
            return f"region[{k}]: is in {hit[0]}, which closes, and missions know no turns; {remedy}, or leave periodic out"
    return None


class _Speller:
    """A task with closed axes on its way to the one that is spelled out."""

    def __init__(self, task: TaskTables) -> None:
        self.task, self.body = task, task.half_extents
        self.lower, self.upper = list(task.state_space.lower), list(task.state_space.upper)
        periods = sorted((task.axis_names.index(name), period) for name, period in (task.periodic or {}).items())
        self.target = task.target_set
        box = task.target
        self.axes = [self._axis(i, period, box.lower[i], box.upper[i]) for i, period in periods]

    def _bounds_target(self, i: int) -> bool:
        target = self.task.target_set
        return target is not None and (bool(target.lower) or i in self.task.axis_indices(target))

    def _axis(self, i: int, period: Fraction, low: Fraction, high: Fraction) -> ClosedAxis:
        """What is chosen for an axis, with the state space set to what it is then. low, high: the target's edges."""
        task, name = self.task, self.task.axis_names[i]
        drift, is_limited = drift_of(period), self.upper[i] - self.lower[i] < period
        if not is_limited and any(normal[i] for normal, _ in task.space_cuts):
            field = task.state_space.points[0]
            raise BadInput(
                f"state_space.{field}: cut {name}, which closes, and of which the state space has a whole turn; make it narrower "
                f"than {decimal(period)} there, or leave {name} out of their axes"
            )
        nearest = chosen = 0
        if self._bounds_target(i):
            about = (task.initial_state[i] - (low + high) / 2) / period
            order = sorted(
                range(math.floor(about) - MAX_WHOLE_TURNS, math.ceil(about) + MAX_WHOLE_TURNS + 1),
                key=lambda k: (abs(k - about), abs(k), -k),
            )
            nearest = chosen = order[0]
            if is_limited:
                first, last = self.lower[i] + self.body[i], self.upper[i] - self.body[i]
                fits = [k for k in order if first <= low + k * period and high + k * period <= last]
                if not fits:
                    raise BadInput(
                        f"target_set: none of its images in {name}, every {decimal(period)}, lies in the state space, which is a "
                        f"limit there, {decimal(self.upper[i] - self.lower[i])} wide; move the target, or widen the state space "
                        f"to {decimal(period)}, which is any angle"
                    )
                chosen = fits[0]
        if not is_limited:
            ends = [(task.start.lower[i], task.start.upper[i])]
            if self._bounds_target(i):
                ends.append((low + chosen * period, high + chosen * period))
            self.lower[i] = min(a for a, _ in ends) - period / 2
            self.upper[i] = max(b for _, b in ends) + period / 2
        return ClosedAxis(index=i, period=period, drift=drift, is_limited=is_limited, target_turns=chosen, nearest_turns=nearest)

    # ---- unsafe sets

    def closed_axes_of(self, table: Unsafe) -> list[ClosedAxis]:
        """The closed axes that a set is in."""
        axes = self.task.axis_indices(table)
        return [axis for axis in self.axes if axis.index in axes]

    def images(self, j: int, table: Unsafe) -> Iterator[tuple[Unsafe, Image]]:
        """The images of unsafe set j but for itself, each with its turns in the closed axes that it is in."""
        closed, own = self.closed_axes_of(table), self.task.axis_indices(table)
        ranges = [self._turns(table, own.index(axis.index), axis) for axis in closed]
        count = math.prod(map(len, ranges))
        if count > MAX_IMAGES:
            names = ", ".join(self.task.axis_names[axis.index] for axis in closed)
            raise BadInput(
                f"unsafe[{j}] ({table.name}): has {count} images in the state space, as it is many turns long in {names}; at "
                f"most {MAX_IMAGES} are taken: name its other axes in `axes`, where it is unsafe at any angle"
            )
        for turns in product(*ranges):
            if any(turns):
                by = {own.index(axis.index): k * axis.period for axis, k in zip(closed, turns, strict=True)}
                moved = translated(table, by, table.point_fields)
                suffix = "".join(f"{k:+d}" for k in turns)
                yield moved.model_copy(update={"name": table.name + suffix}), Image(j, turns)

    def _turns(self, table: Unsafe, at: int, axis: ClosedAxis) -> list[int]:
        """By how many turns the set, wherever it ever is, can come near the state space; 0 among them. at: the axis's place in
        the set's own."""
        i, task = axis.index, self.task
        ends = table.to_convex_set((), ()).span(at)
        by = [point.by[at] for point in table.motion or ()] or [Fraction(0)]
        growth = (table.spread or 0) * (task.prescribed_time + (table.timing or 0) + task.start_delay)
        reach = task.tube.clearance + self.body[i] + growth + REACH * axis.period
        first = math.ceil((self.lower[i] - reach - ends[1] - max(by)) / axis.period)
        last = math.floor((self.upper[i] + reach - ends[0] - min(by)) / axis.period)
        return sorted({0, *range(first, min(last, first + MAX_IMAGES) + 1)}, key=lambda k: (abs(k), -k))

    def as_points(self, j: int, table: Unsafe) -> Unsafe:
        """Half-spaces in a closed axis as the corners of what they leave of the other axes' state space; all else as it is."""
        closed = {axis.index: axis.period for axis in self.closed_axes_of(table)}
        if not closed or table.point_fields:
            return table
        if not isinstance(table, UnsafeHalfSpaces):
            field = next(name for name in fields_of_shape(type(table)))
            raise BadInput(f"unsafe[{j}].{field}: is not known in an axis that closes; leave it out, or periodic")
        own, state = self.task.axis_indices(table), self.task.initial_state
        far = [LONGEST_SET * closed.get(i, Fraction(0)) for i in own]
        lower = tuple(state[i] - d if i in closed else self.lower[i] for i, d in zip(own, far, strict=True))
        upper = tuple(state[i] + d if i in closed else self.upper[i] for i, d in zip(own, far, strict=True))
        try:
            corners = table.to_convex_set(lower, upper).vertices
        except ValueError as error:
            raise BadInput(f"unsafe[{j}].{error}") from None
        for at, i in enumerate(own):
            if i in closed and not all(lower[at] < p[at] < upper[at] for p in corners):
                name = self.task.axis_names[i]
                raise BadInput(
                    f"unsafe[{j}].normals: leave the set open in {name}, which closes, so its images would be everywhere; close "
                    f"it with normals that bound {name} from both sides, or leave {name} out of its axes"
                )
        kept = {name: getattr(table, name) for name in table.model_fields_set - {"normals", "offsets", "name"}}
        return UnsafePolytope.model_construct(**kept, vertices=corners, name=table.name)

    # ---- the target

    def moved_target(self, space: TaskTables) -> Target | None:
        """The target on its chosen turn, less what the periods differ from 2 pi/m. space: the task with its final state space."""
        target = self.target
        moved = [axis for axis in self.axes if axis.target_turns]
        if target is None or not moved:
            return target
        own = self.task.axis_indices(target)
        by = {axis.index: axis.target_turns * axis.period for axis in moved}
        less = {axis.index: abs(axis.target_turns) * axis.drift for axis in moved}
        if not any(less.values()):
            shifted = translated(target, {at: by[i] for at, i in enumerate(own) if i in by}, ("vertices", "centre"))
            shifted = translated(shifted, by, ("lower", "upper"))
            return _with_offsets(shifted, [(c, h + _moved(c, own, by)) for c, h in _written_half_spaces(target)])
        box = target.box(space.free_space, own)
        lower = tuple(v + by.get(i, 0) + less.get(i, 0) for i, v in enumerate(box.lower))
        upper = tuple(v + by.get(i, 0) - less.get(i, 0) for i, v in enumerate(box.upper))
        if any(a >= b for a, b in zip(lower, upper, strict=True)):
            raise BadInput("target_set: is narrower than what its turns differ from 2 pi; write more digits of the period")
        faces = [(c, h + _moved(c, own, by) - _moved(map(abs, c), own, less)) for c, h in target.half_spaces()]
        plain = {name: getattr(target, name) for name in target.model_fields_set & {"axes", "motion"}}
        return _with_offsets(Target.model_construct(**plain, lower=lower, upper=upper), faces)


def _moved(normal: Any, axes: tuple[int, ...], by: dict[int, Fraction]) -> Fraction:
    """By how much a half-space's offset grows where its points are moved by `by`, by axis."""
    return sum((c * by.get(i, Fraction(0)) for c, i in zip(normal, axes, strict=True)), Fraction(0))


def _written_half_spaces(target: Target) -> list[tuple[Vector, Fraction]]:
    return list(zip(target.normals or (), target.offsets or (), strict=True))


def _with_offsets(target: Target, faces: list[Any]) -> Target:
    """The target cut by these half-spaces; as it is where there are none."""
    if not faces:
        return target
    normals = tuple(tuple(Fraction(c) for c in normal) for normal, _ in faces)
    return target.model_copy(update={"normals": normals, "offsets": tuple(offset for _, offset in faces)})


def translated(table: Any, by: dict[int, Fraction], fields: tuple[str, ...]) -> Any:
    """A table of a set with its points moved. by: displacement by place in the points' entries; fields: that are points."""

    def moved(value: Any) -> Any:
        if value and isinstance(value[0], tuple):
            return tuple(map(moved, value))
        return tuple(v + by.get(at, Fraction(0)) for at, v in enumerate(value))

    changes = {name: moved(value) for name in fields if (value := getattr(table, name, None))}
    return table.model_copy(update=changes)


def spelled_out(task: TaskTables) -> tuple[dict[str, Any], tuple[ClosedAxis, ...], tuple[Image, ...]]:
    """The fields that change where a task's turns are spelled out, its closed axes, and for each unsafe set what it is an image
    of. Raises `BadInput`."""
    speller = _Speller(task)
    space = task.state_space.model_copy(update={"lower": tuple(speller.lower), "upper": tuple(speller.upper)})
    target = speller.moved_target(task.model_copy(update={"state_space": space}))
    sets = [speller.as_points(j, table) for j, table in enumerate(task.unsafe)]
    images = [
        pair for j, table in enumerate(sets) for pair in (speller.images(j, table) if speller.closed_axes_of(table) else ())
    ]
    _require_names(task, images)
    sources = [Image(j, ()) for j in range(len(sets))] + [image for _, image in images]
    axes = tuple(_measured(task, speller, axis, [(image, sets[image.source]) for _, image in images]) for axis in speller.axes)
    more = max(axis.most_turns * axis.drift for axis in axes)
    changes: dict[str, Any] = {
        "state_space": space, "target_set": target, "unsafe": (*sets, *(table for table, _ in images)),
        "tube": task.tube.model_copy(update={"clearance": task.tube.clearance + more}) if more else task.tube,
    }  # fmt: skip
    if task.plant.is_stated or task.control.period is not None:
        noise = (task.plant.noise or Fraction(0)) + max(axis.unwrap_error for axis in axes)
        changes["plant"] = task.plant.model_copy(update={"noise": noise})
    return changes, axes, tuple(sources)


def _require_names(task: TaskTables, images: list[tuple[Unsafe, Image]]) -> None:
    """Refuse a name of the file that an image has; two of the file that agree are refused elsewhere."""
    named = {table.name: j for j, table in enumerate(task.unsafe)}
    for table, image in images if len(named) == len(task.unsafe) else ():
        if table.name in named:
            j, name = named[table.name], task.unsafe[image.source].name
            raise BadInput(f"unsafe[{j}].name: {table.name!r} is what an image of {name} is called; choose another")
        named[table.name] = image.source


def _measured(task: TaskTables, speller: _Speller, axis: ClosedAxis, images: list[tuple[Image, Unsafe]]) -> ClosedAxis:
    """An axis with what its images and its measurements are wrong by.

    Unwrapping adds k periods to a measurement y, |y| <= P: k P is off by |k| drift and, P being rounded to the scalar, by
    |k| u P; y, the product and the sum are rounded, u P, u |k| P, u (|k| + 1) P, and a few u^2: together (3 |k| + 3) u P.
    """
    i, period, u = axis.index, axis.period, ROUNDOFF[task.emit.scalar]
    pairs = (zip(speller.closed_axes_of(table), image.turns, strict=True) for image, table in images)
    turns = [abs(k) for pair in pairs for closed, k in pair if closed.index == i]
    farthest = max(abs(speller.lower[i]), abs(speller.upper[i]))
    far, name = int(farthest / period) + 2, task.axis_names[i]
    if max(far, *turns, 0) > MAX_WHOLE_TURNS:
        field = "initial_set" if far > MAX_WHOLE_TURNS else "unsafe"
        problem = f"more than {MAX_WHOLE_TURNS} turns would be counted in {name}"
        raise BadInput(f"{field}: {problem}; write {name} nearer to 0 everywhere")
    error = Fraction(math.ceil((far * axis.drift + u * period * (3 * far + 3)) * ERROR_STEP), ERROR_STEP)
    step = period / 2 - 2 * ((task.plant.noise or Fraction(0)) + error) - 4 * error
    x, start = task.initial_state[i], task.start
    if step <= 0:
        raise BadInput(f"plant.noise: is {decimal(task.plant.noise or Fraction(0))}, and then no turn of {name} can be told")
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
        most_turns=max(turns, default=0),
        unwrap_error=error,
        largest_step=step,
    )
