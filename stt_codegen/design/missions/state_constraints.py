"""The mission in floating point, as the search for a tube sees it: what every state formula asks of the tube's box.

It comes as half-spaces, a choice for each set that must be kept off, like a set that moves (design/moving_half_spaces.py) and
only counts at times; and as convex pieces, in one of which it is enough to be. Lengths and times are the arena's.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stt_codegen.constraints import Constraint, mission_avoidances
from stt_codegen.decimals import decimal
from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array, HalfSpaces, ObliqueFaces
from stt_codegen.design.linear_programs import inner_box
from stt_codegen.design.missions.expansion import cyclic, skeletons
from stt_codegen.design.missions.skeleton import END, START, Skeleton
from stt_codegen.design.moving_half_spaces import INACTIVE, TimedObstacle
from stt_codegen.design.routes import Obstacles, obstacles_of
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.properties import Property
from stt_codegen.task import Task
from stt_codegen.task.mission import And, Formula, InRegion, Or, State, states_of
from stt_codegen.task.sets import Unsafe

MARGIN = 5e-4  # of t_c by which every window is narrower here, so that the clock has room
MOST_PIECES = 400
LEAST = 1e-9  # what a box may lack for rounding
LABELS = 30_000  # what is found is found with some hundreds, for rounds of many visits with some thousands
LEADS = (Fraction(1, 4), Fraction(1, 8), Fraction(1, 2))  # of t_c: lead-ins that are tried, beside those for a round of a patrol,
CLOSE = Fraction(19, 20)  # of a round that a cycle takes
SEAM_KNOTS = 32  # at a knot of so many segments: all numbers of them that are tried are multiples
NOWHERE = np.inf  # the bound of a half-space that does not count


@dataclass(frozen=True)
class Piece:
    """A convex part of space: a box (2, n), and what cuts it."""

    box: Array
    cuts: HalfSpaces

    def hold(self, points: Array, inset: Array) -> npt.NDArray[np.bool_]:
        """Whether boxes of these half widths (n,) about points (P, n) lie in it."""
        inside = ((points >= self.box[0] + inset - 1e-9) & (points <= self.box[1] - inset + 1e-9)).all(axis=1)
        return np.asarray(inside & self.cuts.contain_boxes(points, inset) if len(self.cuts.bound) else inside)

    def centres(self, arena: Arena, inset: Array) -> Array | None:
        """A box (2, n) of centres of boxes of these half widths that lie in it; None where there is none."""
        box = np.stack([self.box[0] + inset, self.box[1] - inset])
        if (box[0] > box[1]).any():
            return None
        return inner_box(replace(arena, goals=self.cuts), box, inset) if len(self.cuts.bound) else box


@dataclass(frozen=True)
class Asked:
    """What a state asks. sets: of each of these one half-space must be kept, normal (N, n), of which the first 2n are those of
    `axes`, bound (N,), in which clearance and rounding are. pieces: in one of them is enough. blocking: what stands in the way
    of one who keeps to it, as an arena of unsafe sets; None where its one piece says it all."""

    sets: tuple[tuple[Array, Array], ...]
    pieces: tuple[Piece, ...]
    blocking: Arena | None

    def demands(self, arena: Arena, name: str, wanted: npt.NDArray[np.bool_], room: Array) -> list[TimedObstacle]:
        """The state at the Bezier coefficients (K, 4) that are wanted, as sets that are avoided there; room: more of it."""
        found = []
        for normal, bound in self.sets:
            bounds = np.full((len(bound), *wanted.shape), INACTIVE)
            bounds[:, wanted] = bound[:, None] - arena.clearance + room[wanted]
            found.append(TimedObstacle(name, normal, (), {len(wanted): bounds}))
        return found

    def of_box(self, box: Array) -> bool:
        """Whether a box (2, n) satisfies it."""
        for normal, bound in self.sets:
            low = np.zeros(len(bound))
            for i in range(normal.shape[1]):
                low = low + np.maximum(normal[:, i], 0.0) * box[0, i] + np.minimum(normal[:, i], 0.0) * box[1, i]
            if not (low >= bound - LEAST).any():
                return False
        return True

    def obstacles(self, reach: Array) -> Obstacles | None:
        """What blocks, grown for the centre of a tube."""
        return None if self.blocking is None else obstacles_of(self.blocking, reach)

    def allows(self, nodes: Array, inset: Array, reach: Array) -> npt.NDArray[np.bool_]:
        """At which nodes (P, n) the box of these half widths satisfies it."""
        grown = self.obstacles(reach)
        if grown is not None:  # of a union: across two of its boxes too
            return np.asarray(~grown.inside(nodes))
        return np.asarray(np.any([piece.hold(nodes, inset) for piece in self.pieces], axis=0))


@dataclass(frozen=True)
class Mission:
    """All that is asked: skeletons, of which one is enough, and what their states ask. doubt: by how much of t_c the clock may be
    late. others: skeletons that are tried where none of the first does; effort: how many labels are looked at for each width."""

    skeletons: tuple[Skeleton, ...]
    states: dict[State, Asked]
    doubt: float = 0.0
    others: tuple[Skeleton, ...] = ()
    effort: int = LABELS

    @property
    def all_skeletons(self) -> tuple[Skeleton, ...]:
        """All skeletons, in the order in which they are tried."""
        return (*self.skeletons, *self.others)

    @cached_property
    def permanent(self) -> tuple[State, ...]:
        """The states that hold at all times, whatever the skeleton."""
        held = [{h.state for h in one.holds if (h.first, h.last) == (START, END)} for one in self.all_skeletons]
        return tuple(state for state in self.states if held and all(state in one for one in held))


def require_start(mission: Mission, start: Array) -> None:
    """Raises `NotCertified` where gamma(0), the box `start` (2, n), breaks what every skeleton holds from the start on."""
    held = [{h.state for h in one.holds if h.first == START and not h.at_once} for one in mission.all_skeletons]
    for state in mission.states if held else ():
        if all(state in one for one in held) and not mission.states[state].of_box(start):
            what = (
                f"is nearer to {str(state).removeprefix('not ')} than the clearance"
                if _keeps_off(state)
                else f"is not in {state}"
            )
            told = "from the start on it must " + ("keep off it" if _keeps_off(state) else "be there")
            raise NotCertified(
                f"{Property.MISSION.label} at t = 0: the initial set {what}, and {told}; move or shrink one of them"
            )


def _keeps_off(state: State) -> bool:
    return isinstance(state.inner, InRegion) and state.inner.is_negated


def margin_of(task: Task) -> float:
    """By how much of t_c every window is narrower: both ends of an interval lose the delay, and knots are whole."""
    return max(MARGIN, 4 * float(task.start_delay / task.prescribed_time))


def mission_of(task: Task, arena: Arena, formula: Formula | None = None) -> Mission | None:
    """The mission of a task, or another formula of its regions, in an arena's units; None where there is none."""
    formula = task.formula if formula is None else formula
    if formula is None:
        return None
    states = {state: _asked(task, arena, state) for state in states_of(formula)}
    doubt = float(task.start_delay / task.prescribed_time)
    t_c, margin = task.prescribed_time, margin_of(task)
    if task.repeat:
        first, others = cyclic(formula, t_c, margin, seams_of(task))
        return Mission(tuple(first) or tuple(others), states, doubt, tuple(others) if first else ())
    return Mission(tuple(skeletons(formula, t_c, margin, doubt)), states, doubt)


def seams_of(task: Task) -> list[float]:
    """When the cycle of a task that repeats itself may begin, in parts of t_c: at a knot, and so that it lasts whole ticks; also
    so that it is as short as a round of a patrol. Raises `BadInput` where there is no such time."""
    knots, tick = task.tube.segments or SEAM_KNOTS, task.emit.tick_period
    rounds = {entry.every / task.prescribed_time for entry in task.mission if entry.every is not None and entry.until is None}
    leads = (*LEADS, *(1 - Fraction(math.floor(share * knots * CLOSE), knots) for share in sorted(rounds)))
    near = (Fraction(min(max(round(share * knots), 1), knots - 3), knots) for share in leads)
    found = [s for s in near if tick is None or ((1 - s) * task.prescribed_time / tick).denominator == 1]
    if not found:
        told = f"is {decimal(tick or Fraction(0))} s, and with repeat = true no cycle would last whole ticks"
        parts = 8 if knots == SEAM_KNOTS else knots  # of those leads are multiples
        more = ", or leave tube.segments out" if task.tube.segments else ""
        length = float(task.prescribed_time / parts)
        raise BadInput(f"emit.tick_period: {told}; use one that divides prescribed_time / {parts} = {length:.9g} s{more}")
    return [float(s) for s in dict.fromkeys(found)]


def _asked(task: Task, arena: Arena, state: State) -> Asked:
    found = mission_avoidances(task, state)
    sets = tuple(_half_spaces(one.alternatives, arena) for one in found)
    inner = state.inner
    if isinstance(inner, InRegion) and not inner.is_negated:
        return Asked(sets, (_piece([row for one in found for row in one.alternatives], arena),), None)
    pieces = [] if isinstance(inner, InRegion) else _pieces(task, arena, inner)
    return Asked(sets, tuple(pieces), _blocking(task, arena, state, sets))


def _room(row: Constraint, arena: Arena) -> float:
    """The bound of a row in the arena's units over |n|_1, with its clearance and what rounding takes."""
    return float((row.bound_from(arena.origin) + row.clearance) / row.slack_per_distance) / arena.length_unit + arena.allowance


def _normal(row: Constraint, n: int) -> Array:
    normal = np.zeros(n)
    for i, _, c in row.terms:
        normal[i] = c / row.slack_per_distance
    return normal


def _half_spaces(rows: tuple[Constraint, ...], arena: Arena) -> tuple[Array, Array]:
    """normal (N, n), the 2n axes first, and bound (N,); what no row says counts for nothing."""
    n = arena.dimension
    normal, bound = np.zeros((2 * n, n)), np.full(2 * n, NOWHERE)
    normal[np.arange(0, 2 * n, 2), np.arange(n)], normal[np.arange(1, 2 * n, 2), np.arange(n)] = -1.0, 1.0
    more = []
    for row in rows:
        if row.dimension is None:
            more.append((_normal(row, n), _room(row, arena)))
        else:
            ((i, _, c),) = row.terms
            bound[2 * i + (c > 0)] = _room(row, arena)
    if more:
        normal, bound = np.concatenate([normal, [v for v, _ in more]]), np.concatenate([bound, [b for _, b in more]])
    return normal, bound


def _piece(rows: list[Constraint], arena: Arena) -> Piece:
    """Where all of these rows hold."""
    box, cuts = arena.space.copy(), []
    for row in rows:
        if row.dimension is None:
            cuts.append((_normal(row, arena.dimension), _room(row, arena)))
        else:
            ((i, _, c),) = row.terms
            edge = _room(row, arena) * (1 if c > 0 else -1)
            box[0 if c > 0 else 1, i] = max(box[0, i], edge) if c > 0 else min(box[1, i], edge)
    normal = np.array([v for v, _ in cuts]).reshape(-1, arena.dimension)
    return Piece(box, HalfSpaces(normal, np.array([b for _, b in cuts])))


def _pieces(task: Task, arena: Arena, formula: Formula) -> list[Piece]:
    """Boxes in each of which a formula of boxes is true; a tube that is in none of them alone may still satisfy it."""
    if isinstance(formula, InRegion):
        rows = mission_avoidances(task, State(formula))
        return (
            [_piece([row], arena) for one in rows for row in one.alternatives]
            if formula.is_negated
            else [_piece([row for one in rows for row in one.alternatives], arena)]
        )
    if isinstance(formula, Or):
        return [piece for part in formula.parts for piece in _pieces(task, arena, part)][:MOST_PIECES]
    assert isinstance(formula, And)
    choices = itertools.islice(itertools.product(*(_pieces(task, arena, part) for part in formula.parts)), MOST_PIECES)
    boxes = (np.stack([np.max([p.box[0] for p in c], axis=0), np.min([p.box[1] for p in c], axis=0)]) for c in choices)
    return [Piece(box, HalfSpaces(np.empty((0, arena.dimension)), np.empty(0))) for box in boxes if (box[0] < box[1]).all()]


def _blocking(task: Task, arena: Arena, state: State, sets: tuple[tuple[Array, Array], ...]) -> Arena:
    """The sets that a state keeps off as the unsafe sets of an arena, whose clearance is taken off again."""
    n, count = arena.dimension, len(sets)
    unsafe, normals, bounds, owner = np.empty((count, 2, n)), [], [], []
    for j, (normal, bound) in enumerate(sets):
        plain = bound - arena.clearance
        unsafe[j, 0], unsafe[j, 1] = -plain[0 : 2 * n : 2], plain[1 : 2 * n : 2]
        normals += list(normal[2 * n :])
        bounds += list(plain[2 * n :])
        owner += [j] * (len(bound) - 2 * n)
    bends: tuple[Array | None, ...] = (None,) * count
    inner = state.inner
    if owner and isinstance(inner, InRegion):
        region = task.regions[inner.region]
        assert isinstance(region, Unsafe)
        convex = region.to_set_in(task.state_space, task.axis_indices(region)).grown(task.half_extents)
        places = [
            [float(v - o) / arena.length_unit for v, o in zip(p, arena.origin, strict=True)] for p, _ in convex.route_corners
        ]
        bends = (np.array([places, [list(map(float, signs)) for _, signs in convex.route_corners]]),)
    faces = ObliqueFaces(np.array(normals).reshape(-1, n), np.array(bounds), np.array(owner, dtype=np.int64), bends, True)
    return replace(
        arena, names=tuple(f"{state} {j}" for j in range(count)), unsafe=unsafe, oblique_faces=faces, timed_obstacles=()
    )
