"""When the events of a mission happen among sets that move: a way in space and time that carries them out in a given order.

The cells of search.py (spacetime/) once for every number of events that are done, a layer each. In a layer the centre keeps to
what is held meanwhile; from one to the next it goes where the next event may happen, at a time at which it may. Bounds on the
time between two events are not seen here: of a way that breaks one nothing is said.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.missions.plans import ROUNDED, Plan
from stt_codegen.design.missions.skeleton import START
from stt_codegen.design.missions.state_constraints import Mission
from stt_codegen.design.spacetime import FAR, Cell, Field, fields
from stt_codegen.task.mission import State

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class _Layers:
    """What may be where: kept: the cells of every layer; there: of every event in its order, the start first; when: from which
    segment's begin to which."""

    field: Field
    kept: list[Flags]
    there: list[Flags]
    when: list[tuple[int, int]]

    def way(self, quickest: int) -> tuple[list[int], list[Cell]] | None:
        """The knots of the events, and the cell at every time; None where none is found."""
        last, segments = len(self.there) - 1, len(self.field.free)
        cost = [np.full(self.field.goal.shape, FAR, dtype=np.int32) for _ in self.there]
        cost[0][self.field.first] = 0
        found: list[list[npt.NDArray[np.int32]]] = []
        for k in range(segments + 1):
            for m in range(1, last + 1):
                if self.when[m][0] <= k <= self.when[m][1]:
                    cost[m] = np.where(self.there[m], np.minimum(cost[m], cost[m - 1]), cost[m])
            found.append(cost)
            if k < segments:
                cost = [self._step(m, k, one, quickest) if one.min() < FAR else one for m, one in enumerate(cost)]
        final = found[-1][last]
        if final.min() >= FAR:
            return None
        cell: Cell = tuple(int(v) for v in np.unravel_index(int(final.argmin()), final.shape))
        m, cells, knots = last, [cell], [0] * (last + 1)
        for k in range(segments, -1, -1):
            while m and self.when[m][0] <= k <= self.when[m][1] and self.there[m][cell]:
                if found[k][m - 1][cell] != found[k][m][cell]:
                    break
                knots[m], m = k, m - 1
            if k:
                cell = self.field.before(cell, found[k - 1][m], int(found[k][m][cell]), self._free(m, k - 1), quickest)
                cells.append(cell)
        return knots, cells[::-1]

    def _free(self, m: int, k: int) -> Flags:
        return np.asarray(self.field.free[k] & self.kept[m])

    def _step(self, m: int, k: int, cost: npt.NDArray[np.int32], quickest: int) -> npt.NDArray[np.int32]:
        return self.field.stepped(cost, self._free(m, k), self.field.after(k), quickest)


class _Holding:
    """In which cells states hold."""

    def __init__(self, mission: Mission, arena: Arena, one: Field, width: Array) -> None:
        self.mission, self.half, self.reach, self.shape = mission, width / 2, arena.clearance + width / 2, one.goal.shape
        self.points = np.stack(np.meshgrid(*one.cells.axes, indexing="ij"), axis=-1).reshape(-1, arena.dimension)
        self.known: dict[State, Flags] = {}

    def where(self, states: list[State]) -> Flags:
        """The cells in which all of them hold."""
        cells = np.ones(self.shape, dtype=bool)
        for state in states:
            if state not in self.known:
                allowed = self.mission.states[state].allows(self.points, self.half, self.reach)
                self.known[state] = allowed.reshape(self.shape)
            cells &= self.known[state]
        return cells


def way_with_events(
    arena: Arena, mission: Mission, plan: Plan, centre: Array, width: Array, segments: int
) -> tuple[list[int], Array] | None:
    """The knot of each stop, the start's first, and the centre at the ends of segments (segments + 1, n); None where none is
    found in which everything is in time."""
    zone, events = plan.skeleton.zone, [START, *(stop.event for stop in plan.stops)]
    assert zone is not None
    for one in fields(arena, centre, width, segments, coarsely=True):
        if len(one.cells.own) < arena.dimension:  # what holds would depend on the other dimensions
            return None
        cells, holds = _Holding(mission, arena, one, width), plan.skeleton.holds
        kept = []
        for m in range(len(events)):
            done = set(events[: m + 1])
            kept.append(cells.where([h.state for h in holds if h.first in done and h.last not in done]))
        there = [cells.where([h.state for h in holds if event in (h.first, h.last)]) for event in events]
        kept[0][one.first] = there[0][one.first] = True
        there[-1] = there[-1] & one.goal
        when = [
            (int(np.ceil(-zone[e, START] * segments - ROUNDED)), int(np.floor(zone[START, e] * segments + ROUNDED)))
            for e in events
        ]
        found = _Layers(one, kept, there, when).way(one.paces[0])
        if found is not None and _in_time(plan, events, found[0], segments):
            way = one.cells.points(found[1])
            way[0] = centre
            return found[0], way
    return None


def _in_time(plan: Plan, events: list[int], knots: list[int], segments: int) -> bool:
    """Whether all bounds between events hold."""
    at = dict(zip(events, knots, strict=True))
    gaps = [(d, at[d.last] - at[d.first]) for d in plan.skeleton.differences]
    return all(d.least * segments - ROUNDED <= gap <= d.most * segments + ROUNDED for d, gap in gaps)
