"""The mission in floating point, as the search for a tube sees it: what each state formula requires of the tube's box.

A state comes in two forms. Half-spaces: for each set to stay clear of the box must be in one of several half-spaces, as with an
obstacle that counts only at times (moving_half_spaces.py). Convex pieces: it is enough for the box to be in one of them. Lengths
and times are the arena's. refine.py and mission_search.py call this; certify/missions/proof.py proves the result without it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.constraints import Constraint, mission_avoidances
from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array, HalfSpaces, ObliqueFaces, distances_beyond
from stt_codegen.design.linear_programs import inner_box
from stt_codegen.design.missions.expansion import expand_cyclic_formula, expand_formula
from stt_codegen.design.missions.skeleton import END, START, Skeleton, seam_times
from stt_codegen.design.moving_half_spaces import INACTIVE, TimedObstacle
from stt_codegen.design.routes import GrownObstacles, grow_obstacles
from stt_codegen.errors import NotCertified, Reason
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.mission import And, Formula, InRegion, Or, StateFormula, state_formulas_of
from stt_codegen.task.sets import Unsafe

WINDOW_MARGIN = 5e-4  # of t_c by which every window is narrower here, so that the clock has a margin
DELAY_FACTOR = 4  # of start_delay, by which every window is narrower at either end
PIECE_LIMIT = 400
BOX_TOLERANCE = 1e-9  # by which a box may be outside, for its edges are rounded
LABEL_LIMIT = 30_000  # an order of visits is found with some hundreds, for rounds of many visits with some thousands
UNREACHABLE = np.inf  # the bound of a half-space in which no box can be


class HalfSpaceChoice(NamedTuple):
    """Half-spaces of which the tube must be in at least one: normal.x >= bound.

    normal: (N, n), of which the first 2n are -e_1, +e_1, -e_2, .. bound: (N,), with clearance and rounding.
    """

    normal: Array
    bound: Array


@dataclass(frozen=True)
class ConvexPiece:
    """A convex part of space: a box (2, n), intersected with half-spaces."""

    box: Array
    half_spaces: HalfSpaces

    def contains_boxes(self, centres: Array, half_widths: Array) -> npt.NDArray[np.bool_]:
        """Return which boxes of these half widths (n,) about centres (P, n) lie in the piece: (P,)."""
        lower, upper = self.box[0] + half_widths - BOX_TOLERANCE, self.box[1] - half_widths + BOX_TOLERANCE
        inside = ((centres >= lower) & (centres <= upper)).all(axis=1)
        return np.asarray(
            inside & self.half_spaces.contain_boxes(centres, half_widths) if len(self.half_spaces.lower_bound) else inside
        )

    def box_of_centres(self, arena: Arena, half_widths: Array) -> Array | None:
        """Return a box (2, n) of centres about which boxes of these half widths lie in the piece; None where there is none."""
        box = np.stack([self.box[0] + half_widths, self.box[1] - half_widths])
        if (box[0] > box[1]).any():
            return None
        return (
            inner_box(replace(arena, target_cuts=self.half_spaces), box, half_widths)
            if len(self.half_spaces.lower_bound)
            else box
        )


@dataclass(frozen=True)
class StateConstraint:
    """What a state formula requires of the tube's box.

    choices: in each of them the box must be in one half-space. pieces: it is enough for the box to be in one of them. complement:
    an arena whose unsafe sets are where the state does not hold; None where one piece describes the state.
    """

    choices: tuple[HalfSpaceChoice, ...]
    pieces: tuple[ConvexPiece, ...]
    complement: Arena | None

    def as_timed_obstacles(self, arena: Arena, name: str, active: npt.NDArray[np.bool_], margin: Array) -> list[TimedObstacle]:
        """Return sets to stay clear of, so that the state holds at the active Bezier coefficients of the tube.

        active: (K, 4). margin: (K, 4), by how much more the tube must be in a half-space.
        """
        obstacles = []
        for normal, bound in self.choices:
            bounds = np.full((len(bound), *active.shape), INACTIVE)
            bounds[:, active] = bound[:, None] - arena.clearance + margin[active]
            obstacles.append(TimedObstacle(name, normal, (), {len(active): bounds}))
        return obstacles

    def holds_for(self, box: Array) -> bool:
        """Return whether the state holds for a box (2, n)."""
        return all(
            bool((distances_beyond(normal, np.zeros(len(bound)), box) >= bound - BOX_TOLERANCE).any())
            for normal, bound in self.choices
        )

    def grown_obstacles(self, growth: Array) -> GrownObstacles | None:
        """Return the sets of the complement, grown by `reach` (n,) for the centre of a tube; None without a complement."""
        return None if self.complement is None else grow_obstacles(self.complement, growth)

    def holds_about(self, centres: Array, half_widths: Array, growth: Array) -> npt.NDArray[np.bool_]:
        """Return about which centres (P, n) the state holds for the box of these half widths (n,): (P,).

        reach: (n,), the half widths and the clearance.
        """
        obstacles = self.grown_obstacles(growth)
        if obstacles is not None:  # the complement also allows boxes that lie across two pieces of a union
            return np.asarray(~obstacles.contain(centres))
        return np.asarray(np.any([piece.contains_boxes(centres, half_widths) for piece in self.pieces], axis=0))


@dataclass(frozen=True)
class Mission:
    """The skeletons of a mission, of which one is enough, and the constraints of their states.

    start_delay: by how much of t_c the clock may be late. fallbacks: skeletons that are tried where none of the first does.
    label_limit: how many labels a search for an order of the visits may use for each width.
    """

    skeletons: tuple[Skeleton, ...]
    states: dict[StateFormula, StateConstraint]
    start_delay: float = 0.0
    fallbacks: tuple[Skeleton, ...] = ()
    label_limit: int = LABEL_LIMIT

    @property
    def all_skeletons(self) -> tuple[Skeleton, ...]:
        """Return all skeletons, in the order in which they are tried."""
        return (*self.skeletons, *self.fallbacks)

    @cached_property
    def permanent_states(self) -> tuple[StateFormula, ...]:
        """Return the states that hold at all times, whatever the skeleton."""
        lasting = [{h.state for h in s.holds if (h.first, h.last) == (START, END)} for s in self.all_skeletons]
        return tuple(state for state in self.states if lasting and all(state in states for states in lasting))


def require_start(mission: Mission, start: Array) -> None:
    """Raise `NotCertified` where gamma(0), the box `start` (2, n), breaks a state that every skeleton holds from the start on."""
    initial = [{h.state for h in s.holds if h.first == START and not h.is_momentary} for s in mission.all_skeletons]
    for state in mission.states if initial else ():
        if all(state in states for states in initial) and not mission.states[state].holds_for(start):
            region = str(state).removeprefix("not ")
            if _is_avoidance(state):
                problem, requirement = f"is nearer to {region} than the clearance", "stay clear of it"
            else:
                problem, requirement = f"is not in {state}", "be there"
            problem = f"{Property.MISSION.label} at t = 0: the initial set {problem}, and from the start on it must {requirement}"
            raise NotCertified(Reason(problem, "move or shrink one of them", codes=(Property.MISSION.code,)))


def _is_avoidance(state: StateFormula) -> bool:
    return isinstance(state.inner, InRegion) and state.inner.is_negated


def window_margin(task: Task) -> float:
    """Return by how much of t_c every window is narrower: both ends of an interval lose the delay, and knots are whole."""
    return max(WINDOW_MARGIN, DELAY_FACTOR * float(task.start_delay / task.prescribed_time))


def mission_of(task: Task, arena: Arena, formula: Formula | None = None) -> Mission | None:
    """Return the mission of a task, or a given formula of its regions, in an arena's units; None where there is none."""
    formula = task.formula if formula is None else formula
    if formula is None:
        return None
    states = {state: _constraint_of(task, arena, state) for state in state_formulas_of(formula)}
    start_delay = float(task.start_delay / task.prescribed_time)
    t_c, margin = task.prescribed_time, window_margin(task)
    if task.repeat:
        preferred, fallbacks = expand_cyclic_formula(formula, t_c, margin, seam_times(task))
        return Mission(tuple(preferred) or tuple(fallbacks), states, start_delay, tuple(fallbacks) if preferred else ())
    return Mission(tuple(expand_formula(formula, t_c, margin, start_delay)), states, start_delay)


def _constraint_of(task: Task, arena: Arena, state: StateFormula) -> StateConstraint:
    """Return a state of the task's mission as a constraint in the arena's units."""
    avoidances, inner = mission_avoidances(task, state), state.inner
    choices = tuple(_choice_of(avoidance.alternatives, arena) for avoidance in avoidances)
    if isinstance(inner, InRegion) and not inner.is_negated:
        return StateConstraint(
            choices, (_piece_of([constraint for a in avoidances for constraint in a.alternatives], arena),), None
        )
    pieces = [] if isinstance(inner, InRegion) else _pieces_of(task, arena, inner)
    return StateConstraint(choices, tuple(pieces), _complement_of(task, arena, state, choices))


def _bound_of(constraint: Constraint, arena: Arena) -> float:
    """Return the bound of a constraint in the arena's units over |n|_1, with its clearance and the allowance for rounding."""
    return (
        float((constraint.bound_from(arena.origin) + constraint.clearance) / constraint.slack_per_distance) / arena.length_unit
        + arena.allowance
    )


def _oblique_half_spaces(constraints: Sequence[Constraint], arena: Arena) -> HalfSpaces:
    """Return the half-spaces of those constraints whose normal is not an axis."""
    oblique = [constraint for constraint in constraints if constraint.dimension is None]
    normal = np.zeros((len(oblique), arena.dimension))
    for x, constraint in enumerate(oblique):
        for i, _, c in constraint.terms:
            normal[x, i] = c / constraint.slack_per_distance
    return HalfSpaces(normal, np.array([_bound_of(constraint, arena) for constraint in oblique]))


def _choice_of(constraints: Sequence[Constraint], arena: Arena) -> HalfSpaceChoice:
    """Return the half-spaces of the constraints, the 2n axes first; an axis without one has a bound that no box can keep."""
    n, oblique = arena.dimension, _oblique_half_spaces(constraints, arena)
    normal, bound = np.zeros((2 * n, n)), np.full(2 * n, UNREACHABLE)
    normal[np.arange(0, 2 * n, 2), np.arange(n)], normal[np.arange(1, 2 * n, 2), np.arange(n)] = -1.0, 1.0
    for constraint in constraints:
        if constraint.dimension is not None:
            ((i, _, c),) = constraint.terms
            bound[2 * i + (c > 0)] = _bound_of(constraint, arena)
    return HalfSpaceChoice(np.concatenate([normal, oblique.normal]), np.concatenate([bound, oblique.lower_bound]))


def _piece_of(constraints: Sequence[Constraint], arena: Arena) -> ConvexPiece:
    """Return the part of the state space where all of the constraints hold."""
    box = arena.space.copy()
    for constraint in constraints:
        if constraint.dimension is not None:
            ((i, _, c),) = constraint.terms
            edge = _bound_of(constraint, arena) * (1 if c > 0 else -1)
            box[0 if c > 0 else 1, i] = max(box[0, i], edge) if c > 0 else min(box[1, i], edge)
    return ConvexPiece(box, _oblique_half_spaces(constraints, arena))


def _pieces_of(task: Task, arena: Arena, formula: Formula) -> list[ConvexPiece]:
    """Return boxes in each of which a formula of boxes holds; a tube across several of them may satisfy it too."""
    if isinstance(formula, InRegion):
        constraints = [
            constraint for avoidance in mission_avoidances(task, StateFormula(formula)) for constraint in avoidance.alternatives
        ]
        return (
            [_piece_of([constraint], arena) for constraint in constraints]
            if formula.is_negated
            else [_piece_of(constraints, arena)]
        )
    if isinstance(formula, Or):
        return [piece for part in formula.parts for piece in _pieces_of(task, arena, part)][:PIECE_LIMIT]
    assert isinstance(formula, And)
    combinations = itertools.islice(itertools.product(*(_pieces_of(task, arena, part) for part in formula.parts)), PIECE_LIMIT)
    boxes = (np.stack([np.max([p.box[0] for p in c], axis=0), np.min([p.box[1] for p in c], axis=0)]) for c in combinations)
    unbounded = HalfSpaces(np.empty((0, arena.dimension)), np.empty(0))
    return [ConvexPiece(box, unbounded) for box in boxes if (box[0] < box[1]).all()]


def _complement_of(task: Task, arena: Arena, state: StateFormula, choices: tuple[HalfSpaceChoice, ...]) -> Arena:
    """Return the arena whose unsafe sets are where a state does not hold; the arena's clearance is subtracted from the bounds."""
    n, count = arena.dimension, len(choices)
    unsafe, normals, bounds, set_index = np.empty((count, 2, n)), [], [], []
    for j, (normal, bound) in enumerate(choices):
        plain = bound - arena.clearance
        unsafe[j, 0], unsafe[j, 1] = -plain[0 : 2 * n : 2], plain[1 : 2 * n : 2]
        normals += list(normal[2 * n :])
        bounds += list(plain[2 * n :])
        set_index += [j] * (len(bound) - 2 * n)
    bends: tuple[Array | None, ...] = (None,) * count
    if set_index and isinstance(state.inner, InRegion):  # a region is one set; what has several sets is made of boxes
        bends = (_bends_of(task, arena, state.inner),)
    faces = ObliqueFaces(
        np.array(normals).reshape(-1, n), np.array(bounds), np.array(set_index, dtype=np.int64), bends, is_complete=True
    )
    names = tuple(f"{state} {j}" for j in range(count))
    return replace(arena, names=names, unsafe=unsafe, oblique_faces=faces, timed_obstacles=())


def _bends_of(task: Task, arena: Arena, inner: InRegion) -> Array:
    """Return where a shortest way around a region may bend, as points in the arena's units and signs: (2, V, n)."""
    region = task.regions[inner.region]
    assert isinstance(region, Unsafe)
    convex = region.to_set_in(task.state_space, task.axis_indices(region)).grown(task.half_extents).grown(task.clearance_excess)
    points = [[float(v - o) / arena.length_unit for v, o in zip(p, arena.origin, strict=True)] for p, _ in convex.route_corners]
    return np.array([points, [list(map(float, signs)) for _, signs in convex.route_corners]])
