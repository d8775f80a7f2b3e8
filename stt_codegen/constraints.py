"""The rows of a task: what a tube must satisfy, as inequalities that are linear in its edges.

    sum_k c_k E_k^(d) >= bound + keep        for all t, at t = 0, or at t_c

E_k is an edge (dimension, side), d = 0 the edge, d = 1 its rate and d = 2 its acceleration. A row is data. Design takes the
bounds and normals of its linear programs from the rows (design/arena.py, a little tightened for the arithmetic), and every
certificate (certify/) evaluates them: exactly on Bezier coefficients (exact.py), in balls (adaptive/enclosure.py), at samples
(adaptive/falsification.py). P4 is a choice: of the rows of one set one must hold at every moment, each with a normal n of its
own, c_i = n_i on the edge that is nearer to the set.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from stt_codegen.designs import LEAST_WIDTH, LOWER, UPPER
from stt_codegen.program import round_down
from stt_codegen.task import Task
from stt_codegen.task.mission import In, State, left_over, regions_of
from stt_codegen.task.sets import BoxSet, ConvexSet, Course, HalfSpace, Normal, Unsafe, UnsafeSet, Vector

Term = tuple[int, int, int]  # dimension, side, coefficient: a whole number, any rational row has a multiple of these


@dataclass(frozen=True)
class Row:
    """One inequality. terms: (dimension, side, c); keep: the clearance that the bound is raised by, in the units of the row; per:
    what the slack is divided by to be a distance in the task's units; order: the derivative of the edges."""

    terms: tuple[Term, ...]
    bound: Fraction
    keep: Fraction = Fraction(0)
    per: int = 1
    order: int = 0

    @property
    def size(self) -> int:
        """Sum of |c|: errors of every edge by at most delta change the left side by at most this much times delta."""
        return sum(abs(c) for _, _, c in self.terms)

    def seen_from(self, origin: Sequence[Fraction]) -> Fraction:
        """The bound of the same row on a tube whose coordinates count from `origin`."""
        return self.bound - sum(c * origin[i] for i, _, c in self.terms)

    @property
    def needed(self) -> Fraction:
        """How much slack, told as a distance, an error of 1 in every edge may take."""
        return Fraction(self.size, self.per)

    @property
    def dimension(self) -> int | None:
        """The one that the row is about, from 0; None where it is about several."""
        found = {i for i, _, _ in self.terms}
        return found.pop() if len(found) == 1 else None


@dataclass(frozen=True)
class Avoidance:
    """P4 for one set: at every moment one of the rows must hold. course: where the set is not always the same; then the rows are
    about where it is when it is not displaced, and `growing` is by how much each bound rises where the set grows by 1."""

    name: str
    rows: tuple[Row, ...]
    course: Course | None = None
    growing: tuple[Fraction, ...] = ()


def least_width(task: Task) -> Fraction:
    """What P1 demands: below LEAST_WIDTH the emitted law is another."""
    return max(task.tube.min_width, LEAST_WIDTH)


def width_rows(task: Task) -> tuple[Row, ...]:
    """P1, for all t: R_i - L_i >= min_width."""
    return tuple(Row(((i, UPPER, 1), (i, LOWER, -1)), least_width(task)) for i in range(task.dimension))


def state_rows(task: Task) -> tuple[Row, ...]:
    """P2, at t = 0: x(0) between the edges, both sides by dimension."""
    return _between([(-x, x) for x in task.initial_state], -1)


def start_rows(task: Task) -> tuple[Row, ...]:
    """P2, at t = 0: the tube within the initial set."""
    return within(task.start)


def stay_rows(task: Task) -> tuple[Row, ...]:
    """P3, for all t: the tube within the state space less the body."""
    return (*within(task.free_space), *behind_rows(task.space_cuts))


def reach_rows(task: Task) -> tuple[Row, ...]:
    """P5, at t_c: the tube within the target set."""
    return (*within(task.target), *behind_rows(task.target_cuts))


def avoid_rows(task: Task) -> tuple[Avoidance, ...]:
    """P4, for all t: for every unsafe set, grown by the body, a choice of rows."""
    found = []
    for s, course in zip(task.obstacles, task.courses, strict=True):
        larger = s.spread(Fraction(1)) if course is not None else s
        growing = () if course is None else tuple(larger.support(normal) - h for normal, h in s.faces)
        found.append(Avoidance(s.name, apart_rows(s, task.tube.clearance), course, growing))
    return tuple(found)


def mission_rows(task: Task, state: State) -> tuple[Avoidance, ...]:
    """P10, at the moments at which a state formula of the mission must hold: of each of these one row. To be in a region is to be
    behind all of its faces; out of one, with the body and the clearance, is P4; of boxes with "and" and "or" what is left over
    must be avoided (task/mission/complements.py)."""
    inner, n, regions = state.inner, task.dimension, task.regions
    if not isinstance(inner, In):
        spans = {one: _span(task, one) for one in regions_of(inner)}
        return tuple(Avoidance(str(state), _open_rows(*box)) for box in left_over(inner, spans, n))
    region = regions[inner.region]
    assert isinstance(region, Unsafe)
    own = task.axis_indices(region)
    if inner.kept:
        convex = region.within(task.state_space, own).grown(task.half_extents)
        return (Avoidance(str(state), apart_rows(convex, task.tube.clearance)),)
    places = [(dict(zip(own, normal, strict=True)), offset) for normal, offset in region.half_spaces()]
    faces = [(tuple(place.get(i, 0) for i in range(n)), offset) for place, offset in places]
    return tuple(Avoidance(str(state), (row,)) for row in behind_rows(faces))


def _span(task: Task, one: In) -> tuple[Vector, Vector]:
    """A region that is a box; of one that is kept off, with the body and the clearance; as long as anything where it has no
    edges."""
    region = task.regions[one.region]
    assert isinstance(region, UnsafeSet)
    own = dict(zip(task.axis_indices(region), zip(region.lower, region.upper, strict=True), strict=True))
    far = max(map(abs, (*task.state_space.lower, *task.state_space.upper))) * 4 + 1
    keep = [h + task.tube.clearance if one.kept else Fraction(0) for h in task.half_extents]
    ends = [own.get(i, (-far, far)) for i in range(task.dimension)]
    return tuple(a - k for (a, _), k in zip(ends, keep, strict=True)), tuple(b + k for (_, b), k in zip(ends, keep, strict=True))


def _open_rows(lower: Sequence[Fraction | None], upper: Sequence[Fraction | None]) -> tuple[Row, ...]:
    """The tube beyond a box on one of the sides on which it ends."""
    below = [Row(((i, UPPER, -1),), -a) for i, a in enumerate(lower) if a is not None]
    return (*below, *(Row(((i, LOWER, 1),), b) for i, b in enumerate(upper) if b is not None))


def speed_rows(task: Task) -> tuple[Row, ...]:
    """P6, for all t: both edges of every dimension no faster than max_speed; none where there is no bound."""
    return _rates(task.max_speed, 1)


def acceleration_rows(task: Task) -> tuple[Row, ...]:
    """P6, for all t before t_c: both edges of every dimension within max_acceleration; none where there is no bound."""
    return _rates(task.max_acceleration, 2)


def root_share(n: int) -> Fraction:
    """1/sqrt(n), rounded down."""
    return Fraction(math.isqrt(10**24 // n), 10**12)


def spare_input(task: Task) -> tuple[Fraction, ...]:
    """By component, how fast an input within u_max, as it is emitted, moves the state at least against all that may push it the
    other way: g_min u_max - |f| - |w| - |g_ij| u_max of the others. Negative where it cannot. Where u is scaled as a whole: what
    every edge may move at, so that the norm of all that pushes is below g_min u_max."""
    assert task.u_max is not None
    limit = [round_down(v, task.emit.scalar) for v in task.u_max]
    if task.scales:
        return tuple((b.g_min * v - b.force) * root_share(task.dimension) for b, v in zip(task.plant_bounds, limit, strict=True))
    total = sum(limit, Fraction(0))
    return tuple(b.g_min * v - b.force - b.cross * (total - v) for b, v in zip(task.plant_bounds, limit, strict=True))


def limit_rows(task: Task) -> tuple[Row, ...]:
    """P8, for all t: no edge comes towards the state faster than an input within u_max can move it away, L_i' and -R_i' below
    `spare_input`; none where that is not asked for, and for order 2, where it is about accelerations."""
    if not task.limits_are_demanded or task.order == 2:
        return ()
    pairs = enumerate(spare_input(task))
    if task.scales:  # the norm of the edges' rates counts, which way they move
        return _rates(spare_input(task), 1)
    return tuple(Row(((i, side, sign),), -v, order=1) for i, v in pairs for side, sign in ((LOWER, -1), (UPPER, 1)))


def fastest_edges(task: Task) -> tuple[Fraction, ...] | None:
    """How fast a search lets the edges be, by component: max_speed, and what P8 leaves, though an edge that gives way could be
    faster; None for no bound."""
    if not task.limits_are_demanded or task.order == 2:
        return task.max_speed
    spare = spare_input(task)
    return spare if task.max_speed is None else tuple(map(min, spare, task.max_speed))


def _rates(most: Sequence[Fraction] | None, order: int) -> tuple[Row, ...]:
    edges = ((i, side) for i in range(len(most or ())) for side in (LOWER, UPPER))
    return tuple(Row(((i, side, sign),), -most[i], order=order) for i, side in edges for sign in (-1, 1)) if most else ()


def within(box: BoxSet) -> tuple[Row, ...]:
    """The tube inside a box: L_i >= lower_i and -R_i >= -upper_i, both sides by dimension."""
    return _between([(a, -b) for a, b in zip(box.lower, box.upper, strict=True)], 1)


def behind_rows(half_spaces: Iterable[HalfSpace]) -> tuple[Row, ...]:
    """The tube in half-spaces normal.x <= offset: low of -normal is at least -offset. The slack over |n|_1 is by how much the
    tube may grow."""
    found = []
    for normal, offset in half_spaces:
        terms, size = _terms(tuple(-c for c in normal))
        found.append(Row(terms, -offset, per=size))
    return tuple(found)


def _between(bounds: Iterable[tuple[Fraction, Fraction]], sign: int) -> tuple[Row, ...]:
    """sign L_i >= first bound, -sign R_i >= second bound."""
    found = []
    for i, (low, high) in enumerate(bounds):
        found += [Row(((i, LOWER, sign),), low), Row(((i, UPPER, -sign),), high)]
    return tuple(found)


def apart_rows(convex: ConvexSet, clearance: Fraction) -> tuple[Row, ...]:
    """For every normal of the set: low_n(B) >= h(n) + |n|_1 clearance. The slack over |n|_1 is the clearance beyond, in the
    largest component."""
    found = []
    for normal, support in convex.faces:
        terms, size = _terms(normal)
        found.append(Row(terms, support, clearance if size == 1 else size * clearance, size))
    return tuple(found)


@cache
def _terms(normal: Normal) -> tuple[tuple[Term, ...], int]:
    """The terms of low_n, the least of n.x over the tube's box, and |n|_1."""
    return tuple((i, LOWER if c > 0 else UPPER, c) for i, c in enumerate(normal) if c), sum(map(abs, normal))
