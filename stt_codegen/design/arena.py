"""The task in floating point, as the design search sees it: grown by the body, with an allowance for rounding.

Everything in `design/` uses only correctly rounded operations (+ - * / and comparisons), element by element: no BLAS, no sums
over long axes, no transcendental functions. The linear programs are then the same bytes on every machine, and so are the
solutions. The lemmas `rows.*` prove the constraints that the arrays are taken from; nothing rests on the arrays. Long because
a task becomes an arena in one place: its sets, the half-spaces that cut them, and gamma(0).
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
from stt_codegen.decimals import decimal
from stt_codegen.design.half_spaces import Array, HalfSpaces, ObliqueFaces
from stt_codegen.design.lattice import Lattice, lattice_of
from stt_codegen.design.moving_half_spaces import TimedObstacle, timed_obstacle_of
from stt_codegen.errors import NotCertified, Reason
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.sets import ConvexSet


@dataclass(frozen=True, kw_only=True)
class Arena:
    """A task as arrays, of which index 0 is lower and 1 upper where they are boxes.

    space, start, target: (2, n). unsafe: (J, 2, n), the spans of the unsafe sets that are always the same; names: of these sets.
    oblique_faces: what the spans do not say. timed_obstacles: the sets that move, or are unsafe only at times. space_cuts,
    target_cuts: the half-spaces that cut space and target. axes: what sentences call the dimensions.

    clearance: the smallest that the task asks for, plus the arithmetic allowance. clearance_excess: (n,), how much larger that of
    each dimension is; all sets are grown by it. min_widths: (n,), what the task asks for plus twice the allowance. max_speeds:
    (n,); max_speed: what the search takes for that of the fastest dimension; relative_speeds: max_speeds over max_speed, at most
    1. max_acceleration: (n,), None for no bound. allowance, difference_allowance: what rounding may change an edge by, and a
    difference of control points (`Lattice`).
    length_unit, time_unit: factors that turn lengths and times into the task's. origin: the place of 0 in the task. order: of the
    plant; for order 2 the search minimises the acceleration of edges. seam: the first
    segment of the part that repeats, None where none does.
    """

    names: tuple[str, ...]
    axes: tuple[str, ...]
    space: Array
    start: Array
    target: Array
    unsafe: Array
    oblique_faces: ObliqueFaces
    space_cuts: HalfSpaces
    target_cuts: HalfSpaces
    initial_state: Array
    prescribed_time: float
    clearance: float
    clearance_excess: Array
    min_widths: Array
    max_speed: float
    max_speeds: Array
    relative_speeds: Array
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

    @property
    def has_only_boxes(self) -> bool:
        """Whether every set is a box, so that its span says all of it."""
        return not (len(self.oblique_faces.set_index) or len(self.space_cuts.lower_bound) or len(self.target_cuts.lower_bound))

    def distance(self, steps: Array) -> Array:
        """Return how far the fastest dimension gets in the time that steps (P, n) take at full speed: (P,)."""
        return np.asarray((np.abs(steps) / self.relative_speeds).max(axis=1))

    def with_sets(self, indices: Sequence[int]) -> Arena:
        """Return the arena with these unsafe sets alone."""
        names, faces = tuple(self.names[j] for j in indices), self.oblique_faces.of_sets(indices)
        return replace(self, names=names, unsafe=self.unsafe[list(indices)], oblique_faces=faces)

    def task_coordinate(self, i: int, value: float) -> float:
        """Return a coordinate in the task's units and from the task's origin."""
        return float(self.origin[i]) + value * self.length_unit


def arena_of(task: Task, lattice: Lattice | None = None) -> Arena:
    """Return the task as arrays, with the allowance of a lattice, seen from the lattice's origin.

    Raises `NotCertified` when sets are too narrow to hold a tube at all.
    """
    lattice = lattice or lattice_of(task)
    origin, allowance = lattice.origin, lattice.allowance
    sets = list(zip(task.obstacles, avoidances(task), strict=True))
    smallest, excess = min(task.clearances), task.clearance_excess
    constant = [with_one_clearance(avoidance, smallest) for _, avoidance in sets if avoidance.course is None]
    min_widths = [constraint.bound for constraint in width_constraints(task)]
    _require_wide_sets(task, min_widths, allowance)
    speeds, accelerations = edge_speed_limits(task), task.max_acceleration
    shapes = [s.grown(excess) for s, avoidance in sets if avoidance.course is None]
    return Arena(
        names=tuple(avoidance.name for avoidance in constant),
        axes=task.axis_words,
        space=_box(stay_constraints(task), allowance, origin),
        start=_box(start_constraints(task), 2 * allowance, origin),
        target=_box(reach_constraints(task), allowance, origin),
        unsafe=_spans(constant, origin),
        oblique_faces=_oblique_faces(constant, shapes, origin),
        space_cuts=_half_spaces(stay_constraints(task), allowance, origin),
        target_cuts=_half_spaces(reach_constraints(task), allowance, origin),
        initial_state=np.array([float(v - o) for v, o in zip(task.initial_state, origin, strict=True)]),
        prescribed_time=float(task.prescribed_time),
        clearance=float(smallest + allowance),
        clearance_excess=np.array([float(v) for v in excess]),
        min_widths=np.array([float(v + 2 * allowance) for v in min_widths]),
        max_speed=math.inf if speeds is None else float(max(speeds)),
        max_speeds=np.full(task.dimension, math.inf) if speeds is None else np.array([float(v) for v in speeds]),
        relative_speeds=np.ones(task.dimension),
        max_acceleration=None if accelerations is None else np.array([float(v) for v in accelerations]),
        allowance=float(allowance),
        difference_allowance=float(lattice.difference_allowance),
        origin=origin,
        order=task.order,
        timed_obstacles=tuple(
            timed_obstacle_of(with_one_clearance(avoidance, smallest), origin)
            for _, avoidance in sets
            if avoidance.course is not None
        ),
    )


def with_one_clearance(avoidance: Avoidance, clearance: Fraction) -> Avoidance:
    """Return the same constraints with one clearance for all dimensions, the smallest: what is beyond it goes into the bound.

    sum_i |n_i| c_i = sum_i |n_i| (c_i - c) + |n|_1 c, and the first sum is by how much h(n) rises where the set is grown by a box
    of half extents c_i - c. The searches then know one clearance, and larger sets.
    """

    def with_smallest(row: Constraint) -> Constraint:
        """Return the same inequality with |n|_1 times the smallest clearance."""
        smallest = row.slack_per_distance * clearance
        return replace(row, bound=row.bound + row.clearance - smallest, clearance=smallest)

    return replace(avoidance, alternatives=tuple(map(with_smallest, avoidance.alternatives)))


def _require_wide_sets(task: Task, min_widths: Sequence[Fraction], allowance: Fraction) -> None:
    """Refuse a start or target that is too narrow for a tube of the minimum width."""
    for field, box in (("initial_set", task.start), ("target_set", task.target)):
        for i, min_width in enumerate(min_widths):
            width = box.upper[i] - box.lower[i]
            if width < min_width + 6 * allowance:
                problem = (
                    f"{Property.WIDTH.label}: {field} is {decimal(width)} wide in {task.axis_words[i]}, too narrow for a tube of "
                    f"min_width {decimal(min_width)} (plus {decimal(6 * allowance)} for rounding)"
                )
                hint = "widen the set"
                if width > min_width or width <= 6 * allowance:
                    problem += f"; the coordinates are too large for a tube in {task.emit.scalar}"
                    hint = "move the origin near the task" + (', or use "float"' if task.emit.scalar == "fixed" else "")
                # in doubles no option makes room for so much rounding
                has_remedy = width > 6 * allowance or task.emit.scalar == "float"
                raise NotCertified(Reason(problem, hint, codes=(Property.WIDTH.code,), axis=i, has_remedy=has_remedy))


def _box(constraints: Sequence[Constraint], margin: Fraction, origin: Sequence[Fraction]) -> Array:
    """Return the box that constraints of single edges leave, less a margin, seen from the origin: shape (2, n)."""
    box = np.stack([np.full(len(origin), -np.inf), np.full(len(origin), np.inf)])
    for constraint in constraints:
        if constraint.dimension is not None:
            ((i, side, c),) = constraint.terms
            edge = float((constraint.bound_from(origin) + constraint.slack_per_distance * margin) / c)
            box[side, i] = max(box[side, i], edge) if c > 0 else min(box[side, i], edge)
    return box


def _normals(constraints: Sequence[Constraint], n: int) -> Array:
    """Return the normals of constraints, each over its |n|_1: shape (M, n)."""
    normal = np.zeros((len(constraints), n))
    for x, constraint in enumerate(constraints):
        for i, _, c in constraint.terms:
            normal[x, i] = float(Fraction(c, constraint.slack_per_distance))
    return normal


def _half_spaces(constraints: Sequence[Constraint], margin: Fraction, origin: Sequence[Fraction]) -> HalfSpaces:
    """Return the constraints of several edges as half-spaces, less a margin."""
    oblique = [c for c in constraints if c.dimension is None]
    bounds = [float(c.bound_from(origin) / c.slack_per_distance + margin) for c in oblique]
    return HalfSpaces(_normals(oblique, len(origin)), np.array(bounds))


def _spans(sets: Sequence[Avoidance], origin: Sequence[Fraction]) -> Array:
    """Return the span of every unsafe set, without the clearance, seen from the origin: shape (J, 2, n)."""
    spans = np.empty((len(sets), 2, len(origin)))
    for j, avoidance in enumerate(sets):
        for constraint in avoidance.alternatives:
            if constraint.dimension is not None:
                ((i, side, sign),) = constraint.terms
                spans[j, 1 - side, i] = float(constraint.bound_from(origin) / sign)
    return spans


def _oblique_faces(sets: Sequence[Avoidance], shapes: Sequence[ConvexSet], origin: Sequence[Fraction]) -> ObliqueFaces:
    """Return the alternatives whose normal is no axis, as arrays, seen from the origin."""
    faces = [(j, c) for j, avoidance in enumerate(sets) for c in avoidance.alternatives if c.dimension is None]
    oblique_sets = {j for j, _ in faces}
    return ObliqueFaces(
        _normals([c for _, c in faces], len(origin)),
        np.array([float(c.bound_from(origin) / c.slack_per_distance) for _, c in faces]),
        np.array([j for j, _ in faces], dtype=np.int64),
        tuple(_bends(s, origin) if j in oblique_sets else None for j, s in enumerate(shapes)),
        not any(s.radius for s in shapes),
    )


def _bends(convex: ConvexSet, origin: Sequence[Fraction]) -> Array:
    """Return the bends of a set seen from the origin, points and signs: shape (2, V, n)."""
    points = [[float(v - o) for v, o in zip(p, origin, strict=True)] for p, _ in convex.route_corners]
    return np.array([points, [list(map(float, signs)) for _, signs in convex.route_corners]])


def arena_at_start(arena: Arena) -> Arena:
    """Return the arena at t = 0: a timed obstacle is where it may be then."""
    n = arena.dimension
    active = [(m, bounds) for m in arena.timed_obstacles if (bounds := m.bounds_at_start()) is not None]
    if not active:
        return arena
    faces, first = arena.oblique_faces, len(arena.names)
    spans = np.array([np.stack([-bounds[0 : 2 * n : 2], bounds[1 : 2 * n : 2]]) for _, bounds in active])
    owners = [np.full(len(bounds) - 2 * n, first + j) for j, (_, bounds) in enumerate(active)]
    all_faces = ObliqueFaces(
        np.concatenate([faces.normal, *(m.normal[2 * n :] for m, _ in active)]),
        np.concatenate([faces.upper_bound, *(bounds[2 * n :] for _, bounds in active)]),
        np.concatenate([faces.set_index, *owners]).astype(np.int64),
        (*faces.bends, *(None for _ in active)),
        faces.is_complete,
    )
    names, unsafe = (*arena.names, *(m.name for m, _ in active)), np.concatenate([arena.unsafe, spans])
    return replace(arena, names=names, unsafe=unsafe, oblique_faces=all_faces, timed_obstacles=())


def normalise(arena: Arena, exponent: int) -> Arena:
    """Return the same arena with lengths in units of 2**exponent (exactly) and t_c as unit of time.

    So tolerances of the search and of the solver mean the same for every task.
    """
    unit, acceleration = 2.0**exponent, arena.max_acceleration
    return replace(
        arena,
        space=arena.space / unit,
        start=arena.start / unit,
        target=arena.target / unit,
        unsafe=arena.unsafe / unit,
        oblique_faces=arena.oblique_faces.scaled(unit),
        space_cuts=arena.space_cuts.scaled(unit),
        target_cuts=arena.target_cuts.scaled(unit),
        initial_state=arena.initial_state / unit,
        prescribed_time=1.0,
        clearance=arena.clearance / unit,
        clearance_excess=arena.clearance_excess / unit,
        min_widths=arena.min_widths / unit,
        max_speed=arena.max_speed * arena.prescribed_time / unit,
        max_speeds=arena.max_speeds * arena.prescribed_time / unit,
        max_acceleration=None if acceleration is None else acceleration * (arena.prescribed_time * arena.prescribed_time) / unit,
        allowance=arena.allowance / unit,
        difference_allowance=arena.difference_allowance / unit,
        length_unit=unit,
        time_unit=arena.prescribed_time,
        timed_obstacles=tuple(m.scaled(unit, arena.prescribed_time) for m in arena.timed_obstacles),
    )


def starting_box(arena: Arena) -> Array:
    """Return gamma(0): the initial set less the allowance, cut back where an unsafe set is nearer than the clearance.

    Shape (2, n). An unsafe set that is too near is cut away in the dimension with the largest gap.
    Raises `NotCertified` when x(0) or the minimum width is lost by that.
    """
    box, arena = arena.start.copy(), arena_at_start(arena)
    for j in range(len(arena.names)):
        box = _cut_away(arena, box, j)
    for i, x in enumerate(arena.initial_state):
        if not box[0, i] + arena.allowance <= x <= box[1, i] - arena.allowance:
            near = f"{4 * arena.allowance * arena.length_unit:.3g} (for rounding)"
            state = f"initial_state[{i}] = {arena.task_coordinate(i, x):.9g}"
            problem = f"{Property.START.label}: {state} is nearer than {near} to the edge of the initial set"
            raise NotCertified(Reason(problem, "move it inside", codes=(Property.START.code,), axis=i, has_remedy=False))
    return box


def _cut_away(arena: Arena, box: Array, j: int) -> Array:
    """Return the box cut back to keep the clearance from unsafe set j, in the dimension with the largest gap."""
    below_gap, above_gap = arena.unsafe[j, 0] - box[1], box[0] - arena.unsafe[j, 1]  # with the box on that side of U_j
    gap = np.maximum(below_gap, above_gap)
    i = int(np.argmax(gap))
    excess = float(arena.clearance_excess[i])
    faces = arena.oblique_faces.indices_of(j)
    face_gaps = arena.oblique_faces.distances_beyond(box, faces.start, faces.stop).tolist()
    widest_face = max(zip(face_gaps, faces, strict=True), default=None)
    nearest = max([float(gap[i]), *face_gaps])
    if nearest >= arena.clearance:
        return box
    box, direction = box.copy(), f"in {arena.axes[i]}"
    if widest_face is not None and widest_face[0] > gap[i]:
        direction = "across a face, by component"
        excess = float((np.abs(arena.oblique_faces.normal[widest_face[1]]) * arena.clearance_excess).sum())
        box, i = _cut_beyond_face(arena, box, *widest_face)
    elif below_gap[i] >= above_gap[i]:
        box[1, i] = arena.unsafe[j, 0, i] - arena.clearance
    else:
        box[0, i] = arena.unsafe[j, 1, i] + arena.clearance
    x, unit = arena.initial_state[i], arena.length_unit
    if not box[0, i] + arena.allowance <= x <= box[1, i] - arena.allowance or (box[1, i] - box[0, i] < arena.min_widths[i]):
        distance, clearance = max(nearest + excess, 0.0) * unit, (arena.clearance - arena.allowance + excess) * unit
        near = f"{arena.names[j]} is {distance:.6g} from the initial set {direction}, nearer than the clearance {clearance:.6g}"
        state = f"x(0) = {arena.task_coordinate(i, x):.6g} in {arena.axes[i]} leaves no room to start elsewhere"
        hint = "move the initial set or x(0) away from it"
        raise NotCertified(
            Reason(f"{Property.AVOID.label} at t = 0: {near}, and {state}", hint, codes=(Property.AVOID.code,), axis=i)
        )
    return box


def _cut_beyond_face(arena: Arena, box: Array, gap: float, x: int) -> tuple[Array, int]:
    """Return the box cut back to keep the clearance beyond face x, to which it has a gap, and the dimension that is cut.

    It is the one in which x(0) is farthest from the moved edge after the cut, among those in which the normal is not 0.
    """
    missing = (arena.clearance - gap) * (1 + 1e-12)
    normal: list[float] = arena.oblique_faces.normal[x].tolist()

    def margin(i: int) -> float:
        """Return how far x(0) is from the edge after the cut."""
        c, state = normal[i], float(arena.initial_state[i])
        if not c:
            return -math.inf
        return (state - float(box[0, i]) if c > 0 else float(box[1, i]) - state) - missing / abs(c)

    i = max(range(arena.dimension), key=margin)
    cut = box.copy()
    cut[0 if normal[i] > 0 else 1, i] += missing / normal[i]
    return cut, i
