"""The constraints of a task: what a tube must satisfy, as inequalities that are linear in its edges.

    sum_k c_k E_k^(d) >= bound + clearance        for all t, at t = 0, or at t_c

E_k is an edge (dimension, side); d = 0 is the edge, d = 1 its rate and d = 2 its acceleration. A constraint is data. The design
search takes the bounds and normals of its linear programs from the constraints (design/arena.py, a little tightened for the
arithmetic). Every certificate (certify/) evaluates them: exactly on Bezier coefficients (exact.py), in balls
(adaptive/enclosure.py), or at samples (adaptive/falsification.py).

P4 is a choice: at every moment one of the alternatives of a set must hold. Each has a separating normal n, with c_i = n_i on the
edge that is nearer to the set. The lemmas `rows.*` prove that these inequalities say what P1 to P6 say.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from stt_codegen.decimals import by_dimension
from stt_codegen.designs import LOWER, NARROWEST_WIDTH, UPPER
from stt_codegen.task import Task
from stt_codegen.task.mission import InRegion, StateFormula, complement_boxes, regions_of
from stt_codegen.task.sets import BoxSet, ConvexSet, Course, HalfSpace, Normal, Unsafe, UnsafeSet, Vector

Term = tuple[int, int, int]  # dimension, side, coefficient: a whole number, any rational constraint has a multiple of these


@dataclass(frozen=True)
class Constraint:
    """One inequality that is linear in the edges.

    terms: (dimension, side, c). clearance: what the bound is raised by, in its units: the sum of |c| times the clearance of the
    dimension. slack_per_distance: the slack divided by it is a distance in the task's units. order: the derivative of the edges.
    """

    terms: tuple[Term, ...]
    bound: Fraction
    clearance: Fraction = Fraction(0)
    slack_per_distance: int = 1
    order: int = 0

    @property
    def size(self) -> int:
        """Sum of |c|: errors of every edge by at most delta change the left side by at most this much times delta."""
        return sum(abs(c) for _, _, c in self.terms)

    def bound_from(self, origin: Sequence[Fraction]) -> Fraction:
        """Return the bound of the same constraint on a tube whose coordinates count from `origin`."""
        return self.bound - sum(c * origin[i] for i, _, c in self.terms)

    @property
    def distance_error(self) -> Fraction:
        """How much slack, as a distance, an error of 1 in every edge may take."""
        return Fraction(self.size, self.slack_per_distance)

    @property
    def dimension(self) -> int | None:
        """The dimension whose edges the constraint bounds, from 0; None where it bounds edges of several."""
        dimensions = {i for i, _, _ in self.terms}
        return dimensions.pop() if len(dimensions) == 1 else None


@dataclass(frozen=True)
class Avoidance:
    """P4 for one set: at every moment one of the alternatives must hold.

    course: the motion of a set that moves, grows, or is unsafe only at times; the alternatives are then about the set where it is
    not displaced. growth_rates: by how much each bound rises where the set grows by 1.
    """

    name: str
    alternatives: tuple[Constraint, ...]
    course: Course | None = None
    growth_rates: tuple[Fraction, ...] = ()


def minimum_widths(task: Task) -> tuple[Fraction, ...]:
    """Return by dimension the width that P1 demands; the emitted law divides by the width as it is."""
    return tuple(max(v, NARROWEST_WIDTH) for v in task.min_widths)


def width_statement(task: Task) -> str:
    """Return what P1 says in words."""
    widths = minimum_widths(task)
    return f"width >= {by_dimension(widths)}" + (" in every dimension" if len(set(widths)) == 1 else "")


def clearance_statement(task: Task, count: int) -> str:
    """Return what P4 says in words about so many unsafe sets."""
    if len(set(task.clearances)) > 1:
        return f"gamma, grown by {by_dimension(task.clearances)} to both sides, meets none of {count} unsafe sets"
    return f"gamma at least {by_dimension(task.clearances)} from each of {count} unsafe sets"


def width_constraints(task: Task) -> tuple[Constraint, ...]:
    """Return P1, for all t: R_i - L_i >= min_width."""
    return tuple(Constraint(((i, UPPER, 1), (i, LOWER, -1)), width) for i, width in enumerate(minimum_widths(task)))


def initial_state_constraints(task: Task) -> tuple[Constraint, ...]:
    """Return P2, at t = 0: x(0) between the edges, both sides by dimension."""
    return _interval_constraints([(-x, x) for x in task.initial_state], -1)


def start_constraints(task: Task) -> tuple[Constraint, ...]:
    """Return P2, at t = 0: the tube within the initial set."""
    return box_constraints(task.start)


def stay_constraints(task: Task) -> tuple[Constraint, ...]:
    """Return P3, for all t: the tube within the state space less the body."""
    return (*box_constraints(task.free_space), *half_space_constraints(task.space_cuts))


def reach_constraints(task: Task) -> tuple[Constraint, ...]:
    """Return P5, at t_c: the tube within the target set."""
    return (*box_constraints(task.target), *half_space_constraints(task.target_cuts))


def avoidances(task: Task) -> tuple[Avoidance, ...]:
    """Return P4, for all t: for every unsafe set, grown by the body, the alternatives of which one must hold."""
    result = []
    for s, course in zip(task.obstacles, task.courses, strict=True):
        larger = s.inflated(Fraction(1)) if course is not None else s
        growth_rates = () if course is None else tuple(larger.support(normal) - h for normal, h in s.faces)
        result.append(Avoidance(s.name, separation_constraints(s, task.clearances), course, growth_rates))
    return tuple(result)


def mission_avoidances(task: Task, state: StateFormula) -> tuple[Avoidance, ...]:
    """Return P10, at the moments at which a state formula of the mission must hold: of each avoidance one alternative.

    To be in a region is to be behind all of its faces. To be out of one, with the body and the clearance, is P4. Of boxes with
    "and" and "or", what the formula leaves over must be avoided (task/mission/complements.py).
    """
    inner, n, regions = state.inner, task.dimension, task.regions
    if not isinstance(inner, InRegion):
        spans = {region_formula: _box_span(task, region_formula) for region_formula in regions_of(inner)}
        return tuple(Avoidance(str(state), _outside_box_constraints(*box)) for box in complement_boxes(inner, spans, n))
    region = regions[inner.region]
    assert isinstance(region, Unsafe)
    axes = task.axis_indices(region)
    if inner.is_negated:
        convex = region.to_set_in(task.state_space, axes).grown(task.half_extents)
        return (Avoidance(str(state), separation_constraints(convex, task.clearances)),)
    components = [(dict(zip(axes, normal, strict=True)), offset) for normal, offset in region.half_spaces()]
    half_spaces = [(tuple(component.get(i, 0) for i in range(n)), offset) for component, offset in components]
    return tuple(Avoidance(str(state), (constraint,)) for constraint in half_space_constraints(half_spaces))


def _box_span(task: Task, formula: InRegion) -> tuple[Vector, Vector]:
    """Return the lower and upper edges of a region that is a box, in all dimensions.

    The span of a region that is avoided is grown by the body and the clearance. Where the region has no edges, the span is longer
    than anything in the state space.
    """
    region = task.regions[formula.region]
    assert isinstance(region, UnsafeSet)
    edges = dict(zip(task.axis_indices(region), zip(region.lower, region.upper, strict=True), strict=True))
    unbounded = task.largest_coordinate * 4 + 1
    margins = zip(task.half_extents, task.clearances, strict=True)
    growth = [h + clearance if formula.is_negated else Fraction(0) for h, clearance in margins]
    ends = [edges.get(i, (-unbounded, unbounded)) for i in range(task.dimension)]
    lower = tuple(a - g for (a, _), g in zip(ends, growth, strict=True))
    return lower, tuple(b + g for (_, b), g in zip(ends, growth, strict=True))


def _outside_box_constraints(lower: Sequence[Fraction | None], upper: Sequence[Fraction | None]) -> tuple[Constraint, ...]:
    """Return the alternatives by which a tube is outside a box: beyond one of the sides on which the box ends."""
    below = [Constraint(((i, UPPER, -1),), -a) for i, a in enumerate(lower) if a is not None]
    return (*below, *(Constraint(((i, LOWER, 1),), b) for i, b in enumerate(upper) if b is not None))


def speed_constraints(task: Task) -> tuple[Constraint, ...]:
    """Return P6, for all t: both edges of every dimension no faster than max_speed; none where there is no bound."""
    return _rate_constraints(task.max_speed, 1)


def acceleration_constraints(task: Task) -> tuple[Constraint, ...]:
    """Return P6, for all t before t_c: both edges of every dimension within max_acceleration; none where there is no bound."""
    return _rate_constraints(task.max_acceleration, 2)


def inverse_square_root(n: int) -> Fraction:
    """Return 1/sqrt(n), rounded down."""
    return Fraction(math.isqrt(10**24 // n), 10**12)


def control_authority(task: Task) -> tuple[Fraction, ...]:
    """Return by component the least speed at which an input within u_max moves the state against the plant bounds.

    That is g_min u_max - |f| - |w| - |g_ij| u_max of the other components, in the task's units per second to the power of the
    plant's order; negative where the input cannot. Where u is scaled as a whole it is what every edge may move at, so that the
    norm of the plant bounds and the edges' rates is below g_min u_max.
    """
    limits = task.emitted_u_max
    assert limits is not None
    if task.scales_input:
        factor = inverse_square_root(task.dimension)
        return tuple((b.g_min * v - b.force) * factor for b, v in zip(task.plant_bounds, limits, strict=True))
    parts = zip(task.plant_bounds, limits, task.coupling_of(limits), strict=True)
    return tuple(b.g_min * v - b.force - coupling for b, v, coupling in parts)


def limit_constraints(task: Task) -> tuple[Constraint, ...]:
    """Return P8, for all t: no edge comes towards the state faster than an input within u_max can move it away.

    So L_i' and -R_i' are below `control_authority`. There are none where the task does not demand limits, and none for order 2,
    where P8 is about accelerations.
    """
    if not task.requires_input_limits or task.order == 2:
        return ()
    speeds = control_authority(task)
    if task.scales_input:  # the norm of the edges' rates counts, whatever their direction
        return _rate_constraints(speeds, 1)
    sides = ((LOWER, -1), (UPPER, 1))
    return tuple(Constraint(((i, side, sign),), -v, order=1) for i, v in enumerate(speeds) for side, sign in sides)


def edge_speed_limits(task: Task) -> tuple[Fraction, ...] | None:
    """Return by component how fast a search lets the edges be: max_speed, and what P8 leaves; None for no bound.

    An edge that moves away from the state could be faster under P8.
    """
    if not task.requires_input_limits or task.order == 2:
        return task.max_speed
    authority = control_authority(task)
    return authority if task.max_speed is None else tuple(map(min, authority, task.max_speed))


def _rate_constraints(limits: Sequence[Fraction] | None, order: int) -> tuple[Constraint, ...]:
    if not limits:
        return ()
    edges = ((i, side) for i in range(len(limits)) for side in (LOWER, UPPER))
    return tuple(Constraint(((i, side, sign),), -limits[i], order=order) for i, side in edges for sign in (-1, 1))


def box_constraints(box: BoxSet) -> tuple[Constraint, ...]:
    """Return the constraints that keep a tube inside a box: L_i >= lower_i and -R_i >= -upper_i, both sides by dimension."""
    return _interval_constraints([(a, -b) for a, b in zip(box.lower, box.upper, strict=True)], 1)


def half_space_constraints(half_spaces: Iterable[HalfSpace]) -> tuple[Constraint, ...]:
    """Return the constraints that keep a tube in half-spaces normal.x <= offset: low of -normal is at least -offset.

    The slack over |n|_1 is by how much the tube may grow.
    """
    result = []
    for normal, offset in half_spaces:
        terms, size = _lowest_value_terms(tuple(-c for c in normal))
        result.append(Constraint(terms, -offset, slack_per_distance=size))
    return tuple(result)


def _interval_constraints(bounds: Iterable[tuple[Fraction, Fraction]], sign: int) -> tuple[Constraint, ...]:
    """Return sign L_i >= first bound and -sign R_i >= second bound, by dimension."""
    result = []
    for i, (low, high) in enumerate(bounds):
        result += [Constraint(((i, LOWER, sign),), low), Constraint(((i, UPPER, -sign),), high)]
    return tuple(result)


def separation_constraints(convex: ConvexSet, clearances: Sequence[Fraction]) -> tuple[Constraint, ...]:
    """Return for every normal of the set the constraint that separates a tube's box B from it. clearances: by dimension.

    It is low_n(B) >= h(n) + sum_i |n_i| clearance_i, where h(n) is the support of the set and low_n(B) the smallest n.x over B.
    Then between any two points of B and the set some component i is at least clearance_i and the slack over |n|_1 apart.
    """
    result = []
    for normal, support in convex.faces:
        terms, size = _lowest_value_terms(normal)
        clearance = sum((abs(c) * v for c, v in zip(normal, clearances, strict=True) if c), Fraction(0))
        result.append(Constraint(terms, support, clearance, size))
    return tuple(result)


@cache
def _lowest_value_terms(normal: Normal) -> tuple[tuple[Term, ...], int]:
    """Return the terms of low_n, the smallest value of n.x over the tube's box, and |n|_1."""
    return tuple((i, LOWER if c > 0 else UPPER, c) for i, c in enumerate(normal) if c), sum(map(abs, normal))
