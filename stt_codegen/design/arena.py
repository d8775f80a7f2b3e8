"""The task in floating point, as the design search sees it: grown by the body, with room for rounding.

Everything in `design/` uses only correctly rounded operations (+ - * / and comparisons), element by element:
no BLAS, no sums over long axes, no transcendental functions. The linear programs are then the same bytes on every
machine, and so is what the solver makes of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from stt_codegen.constraints import (
    Avoidance,
    Constraint,
    avoidances,
    edge_speed_limits,
    reach_constraints,
    start_constraints,
    stay_constraints,
    width_constraints,
)
from stt_codegen.decimals import below, decimal
from stt_codegen.design.half_spaces import Array, HalfSpaces, ObliqueFaces
from stt_codegen.design.lattice import Lattice, lattice_of
from stt_codegen.design.moving_half_spaces import TimedObstacle, timed_obstacle_of
from stt_codegen.errors import NotCertified
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet


@dataclass(frozen=True, kw_only=True)
class Arena:
    """Boxes as arrays: `space`, `start`, `target` of shape (2, n), `unsafe` of shape (J, 2, n), the spans of the unsafe sets;
    index 0 lower, 1 upper. names: of the unsafe sets; axes: what sentences call the dimensions. oblique_faces: what the spans do
    not say. timed_obstacles: the sets that move, or are unsafe only at times, which are not among the names. walls,
    goals: cut space and target.

    clearance, min_width: what the task asks for plus the arithmetic allowance. max_speeds: by dimension (n,); max_speed: what the
    search takes for that of the swiftest; swiftness: of each, over that (n,), at most 1. max_acceleration: (n,), None for no
    bound. allowance, difference_allowance: what rounding may change an edge by, and a difference of control points (`Lattice`).
    length_unit, time_unit: what lengths and times are multiplied by to be the task's; origin: where in the task 0 is. order: of
    the plant; where it is 2 edges are to be as little accelerated as they can be. seam: as of a design."""

    names: tuple[str, ...]
    axes: tuple[str, ...]
    space: Array
    start: Array
    target: Array
    unsafe: Array
    oblique_faces: ObliqueFaces
    walls: HalfSpaces
    goals: HalfSpaces
    initial_state: Array
    prescribed_time: float
    clearance: float
    min_width: float
    max_speed: float
    max_speeds: Array
    swiftness: Array
    max_acceleration: Array | None
    allowance: float
    difference_allowance: float
    origin: tuple[Fraction, ...]
    timed_obstacles: tuple[TimedObstacle, ...] = ()
    order: int = 1
    seam: int | None = None
    length_unit: float = 1.0
    time_unit: float = 1.0

    @property
    def dimension(self) -> int:
        return int(self.space.shape[1])

    def distance(self, steps: Array) -> Array:
        """What steps (P, n) take at full speed, as a way of the swiftest dimension: the largest component over its swiftness."""
        return np.asarray((np.abs(steps) / self.swiftness).max(axis=1))

    @property
    def boxes_only(self) -> bool:
        """Whether every set is a box, so that its span says all of it."""
        return not (len(self.oblique_faces.set_index) or len(self.walls.bound) or len(self.goals.bound))

    def only(self, keep: Sequence[int]) -> Arena:
        """The arena with the unsafe sets whose numbers are in `keep` alone."""
        names = tuple(self.names[j] for j in keep)
        return replace(self, names=names, unsafe=self.unsafe[list(keep)], oblique_faces=self.oblique_faces.of_sets(keep))

    def place(self, i: int, value: float) -> float:
        """A coordinate in the task's units and from the task's origin."""
        return float(self.origin[i]) + value * self.length_unit


def arena_of(task: Task, lattice: Lattice | None = None) -> Arena:
    """The task as arrays, with the room that a lattice needs, seen from its origin. Raises `NotCertified` when sets are too
    narrow to hold a tube at all."""
    lattice = lattice or lattice_of(task)
    origin, allowance = lattice.origin, lattice.allowance
    found = list(zip(task.obstacles, avoidances(task), strict=True))
    shapes, sets = [s for s, one in found if one.course is None], [one for _, one in found if one.course is None]
    n = task.dimension
    least = max(row.bound for row in width_constraints(task))
    wide = least + 2 * allowance
    for field, box in (("initial_set", task.start), ("target_set", task.target)):
        for i in range(n):
            width = box.upper[i] - box.lower[i]
            if width < wide + 4 * allowance:
                raise NotCertified(
                    f"{Property.WIDTH.label}: {field} is {decimal(width)} wide in {task.axis_words[i]}, too narrow for a tube of "
                    f"min_width {decimal(least)} (plus {decimal(6 * allowance)} for rounding); "
                    + (
                        f"the coordinates are too large for a tube in {task.emit.scalar}: move the origin near the task"
                        + {"float": ', or use emit.scalar = "double"', "fixed": ', or use "float"'}.get(task.emit.scalar, "")
                        if width > least or width <= 6 * allowance
                        else f"lower tube.min_width to {below(width - 6 * allowance, 4):g} or widen the set"
                    )
                )
    inset = 2 * allowance
    speeds, accelerations = edge_speed_limits(task), task.max_acceleration
    return Arena(
        names=tuple(one.name for one in sets),
        axes=task.axis_words,
        space=_bounds(stay_constraints(task), allowance, origin),
        start=_bounds(start_constraints(task), inset, origin),
        target=_bounds(reach_constraints(task), allowance, origin),
        unsafe=_spans(sets, origin),
        oblique_faces=_faces(sets, shapes, origin),
        walls=_cuts(stay_constraints(task), allowance, origin),
        goals=_cuts(reach_constraints(task), allowance, origin),
        initial_state=np.array([float(v - o) for v, o in zip(task.initial_state, origin, strict=True)]),
        prescribed_time=float(task.prescribed_time),
        clearance=float(task.tube.clearance + allowance),
        min_width=float(wide),
        max_speed=math.inf if speeds is None else float(max(speeds)),
        max_speeds=np.full(n, math.inf) if speeds is None else np.array([float(v) for v in speeds]),
        swiftness=np.ones(n),
        max_acceleration=None if accelerations is None else np.array([float(v) for v in accelerations]),
        allowance=float(allowance),
        difference_allowance=float(lattice.difference_allowance),
        origin=origin,
        order=task.order,
        timed_obstacles=tuple(timed_obstacle_of(one, origin) for _, one in found if one.course is not None),
    )


def standing(arena: Arena) -> Arena:
    """The arena at t = 0: what moves stands where it may be then."""
    n, here = arena.dimension, [(m, at) for m in arena.timed_obstacles if (at := m.bounds_at_start()) is not None]
    if not here:
        return arena
    faces, first = arena.oblique_faces, len(arena.names)
    spans = np.array([np.stack([-at[0 : 2 * n : 2], at[1 : 2 * n : 2]]) for _, at in here])
    more = ObliqueFaces(
        np.concatenate([faces.normal, *(m.normal[2 * n :] for m, _ in here)]),
        np.concatenate([faces.bound, *(at[2 * n :] for _, at in here)]),
        np.concatenate([faces.set_index, *(np.full(len(at) - 2 * n, first + j) for j, (_, at) in enumerate(here))]).astype(
            np.int64
        ),
        (*faces.bends, *(None for _ in here)),
        faces.is_complete,
    )
    names = (*arena.names, *(m.name for m, _ in here))
    return replace(arena, names=names, unsafe=np.concatenate([arena.unsafe, spans]), oblique_faces=more, timed_obstacles=())


def _bounds(rows: Sequence[Constraint], room: Fraction, origin: Sequence[Fraction]) -> Array:
    """The box that rows of single edges leave, less `room`, seen from the origin: shape (2, n)."""
    box = np.stack([np.full(len(origin), -np.inf), np.full(len(origin), np.inf)])
    for row in rows:
        if row.dimension is not None:
            ((i, side, c),) = row.terms
            edge = float((row.bound_from(origin) + row.slack_per_distance * room) / c)
            box[side, i] = max(box[side, i], edge) if c > 0 else min(box[side, i], edge)
    return box


def _cuts(rows: Sequence[Constraint], room: Fraction, origin: Sequence[Fraction]) -> HalfSpaces:
    """What rows of several edges say, with `room` to spare."""
    found = [row for row in rows if row.dimension is None]
    normal = np.zeros((len(found), len(origin)))
    for x, row in enumerate(found):
        for i, _, c in row.terms:
            normal[x, i] = float(Fraction(c, row.slack_per_distance))
    return HalfSpaces(normal, np.array([float(row.bound_from(origin) / row.slack_per_distance + room) for row in found]))


def _spans(sets: Sequence[Avoidance], origin: Sequence[Fraction]) -> Array:
    """What rows of single edges say of every unsafe set, without the clearance, seen from the origin: shape (J, 2, n)."""
    spans = np.empty((len(sets), 2, len(origin)))
    for j, one in enumerate(sets):
        for row in one.alternatives:
            if row.dimension is not None:
                ((i, side, sign),) = row.terms
                spans[j, 1 - side, i] = float(row.bound_from(origin) / sign)
    return spans


def _faces(sets: Sequence[Avoidance], shapes: Sequence[ConvexSet], origin: Sequence[Fraction]) -> ObliqueFaces:
    """The avoidance rows whose normal is no axis, as arrays, seen from the origin."""
    found = [(j, row) for j, one in enumerate(sets) for row in one.alternatives if row.dimension is None]
    normal = np.zeros((len(found), len(origin)))
    for x, (_, row) in enumerate(found):
        for i, _, c in row.terms:
            normal[x, i] = float(Fraction(c, row.slack_per_distance))
    skew = {j for j, _ in found}
    return ObliqueFaces(
        normal,
        np.array([float(row.bound_from(origin) / row.slack_per_distance) for _, row in found]),
        np.array([j for j, _ in found], dtype=np.int64),
        tuple(_bends(s, origin) if j in skew else None for j, s in enumerate(shapes)),
        not any(s.radius for s in shapes),
    )


def _bends(convex: ConvexSet, origin: Sequence[Fraction]) -> Array:
    """The bends of a set seen from the origin, points and signs: shape (2, V, n)."""
    points = [[float(v - o) for v, o in zip(p, origin, strict=True)] for p, _ in convex.route_corners]
    return np.array([points, [list(map(float, signs)) for _, signs in convex.route_corners]])


def normalised(arena: Arena, exponent: int) -> Arena:
    """The same arena with lengths in units of 2**exponent (exactly) and t_c as unit of time, so that tolerances of the
    search and of the solver mean the same for every task."""
    unit, bend = 2.0**exponent, arena.max_acceleration
    return replace(
        arena,
        space=arena.space / unit,
        start=arena.start / unit,
        target=arena.target / unit,
        unsafe=arena.unsafe / unit,
        oblique_faces=arena.oblique_faces.scaled(unit),
        walls=arena.walls.scaled(unit),
        goals=arena.goals.scaled(unit),
        initial_state=arena.initial_state / unit,
        prescribed_time=1.0,
        clearance=arena.clearance / unit,
        min_width=arena.min_width / unit,
        max_speed=arena.max_speed * arena.prescribed_time / unit,
        max_speeds=arena.max_speeds * arena.prescribed_time / unit,
        max_acceleration=None if bend is None else bend * (arena.prescribed_time * arena.prescribed_time) / unit,
        allowance=arena.allowance / unit,
        difference_allowance=arena.difference_allowance / unit,
        length_unit=unit,
        time_unit=arena.prescribed_time,
        timed_obstacles=tuple(m.scaled(unit, arena.prescribed_time) for m in arena.timed_obstacles),
    )


def _cut_beyond(arena: Arena, box: Array, room: float, x: int) -> tuple[Array, int]:
    """The box cut back to keep the clearance beyond face x, `room` of which it has: along the component of its normal in which
    x(0) is farthest from the edge that moves, for what the cut takes there."""
    lack = (arena.clearance - room) * (1 + 1e-12)
    cut = box.copy()

    def left(i: int) -> float:
        c = float(arena.oblique_faces.normal[x, i])
        if not c:
            return -math.inf
        state = float(arena.initial_state[i])
        return (state - float(box[0, i]) if c > 0 else float(box[1, i]) - state) - lack / abs(c)

    i = max(range(arena.dimension), key=left)
    c = float(arena.oblique_faces.normal[x, i])
    cut[0 if c > 0 else 1, i] += lack / c
    return cut, i


def starting_box(arena: Arena) -> Array:
    """gamma(0): the initial set less the allowance, cut back where an unsafe set is nearer than the clearance.

    Shape (2, n). An unsafe set that is too near is cut away in the dimension with the largest gap.
    Raises `NotCertified` when x(0) or the least width is lost by that.
    """
    box, arena = arena.start.copy(), standing(arena)
    for j, name in enumerate(arena.names):
        below = arena.unsafe[j, 0] - box[1]  # gap with the box on the lower side of U_j
        above = box[0] - arena.unsafe[j, 1]
        gap = np.maximum(below, above)
        i = int(np.argmax(gap))
        own = arena.oblique_faces.indices_of(j)
        slanted = list(zip(arena.oblique_faces.distances_beyond(box, own.start, own.stop).tolist(), own, strict=True))
        nearest = max([float(gap[i]), *(room for room, _ in slanted)])
        if nearest >= arena.clearance:
            continue
        along = f"in {arena.axes[i]}"
        if slanted and max(slanted)[0] > gap[i]:
            along = "across a face, by component"
            box, i = _cut_beyond(arena, box, *max(slanted))
        elif below[i] >= above[i]:
            box[1, i] = arena.unsafe[j, 0, i] - arena.clearance
        else:
            box[0, i] = arena.unsafe[j, 1, i] + arena.clearance
        x, size = arena.initial_state[i], arena.length_unit
        if not box[0, i] + arena.allowance <= x <= box[1, i] - arena.allowance or (box[1, i] - box[0, i] < arena.min_width):
            kept, place, gap = (arena.clearance - arena.allowance) * size, arena.place(i, x), max(nearest, 0.0) * size
            raise NotCertified(
                f"{Property.AVOID.label} at t = 0: {name} is {gap:.6g} from the initial set {along}, nearer than the clearance "
                f"{kept:.6g}, and x(0) = {place:.6g} in {arena.axes[i]} leaves no room to start elsewhere; "
                "lower tube.clearance, or move the initial set or x(0) away from it"
            )
    for i, x in enumerate(arena.initial_state):
        if not box[0, i] + arena.allowance <= x <= box[1, i] - arena.allowance:
            raise NotCertified(
                f"{Property.START.label}: initial_state[{i}] = {arena.place(i, x):.9g} is nearer than "
                f"{4 * arena.allowance * arena.length_unit:.3g} (for rounding) to the edge of the initial set; move it inside"
            )
    return box
