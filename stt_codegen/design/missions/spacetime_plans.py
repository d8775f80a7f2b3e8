"""When the events of a mission happen among sets that move: a route in space and time on which they happen in a given order.

The cells of spacetime/ are used in layers, one for each number of events that are done. In a layer the centre stays in cells
where the open holds are true. It goes to the next layer where the next event may happen, at a time at which it may. Time bounds
between two chosen events are not part of the search: a route that breaks one is dropped. mission_search.py calls this.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.missions.plans import KNOT_TOLERANCE, Plan
from stt_codegen.design.missions.skeleton import START
from stt_codegen.design.missions.state_constraints import Mission
from stt_codegen.design.spacetime import UNREACHABLE, Cell, SliceSearch, slice_searches
from stt_codegen.task.mission import StateFormula

Flags = npt.NDArray[np.bool_]
Costs = npt.NDArray[np.int32]


class EventRoute(NamedTuple):
    """A route with its events: the knot of each event, the start's first, and the centre at the ends of segments (K + 1, n)."""

    knots: list[int]
    centre: Array


@dataclass(frozen=True)
class _Layers:
    """The search for a route through the layers. Events are numbered in their order, the start is 0.

    allowed_cells: of each layer. event_cells: of each event. windows: the first and last knot of each event.
    """

    search: SliceSearch
    allowed_cells: list[Flags]
    event_cells: list[Flags]
    windows: list[tuple[int, int]]

    def cheapest_route(self, pace: int) -> tuple[list[int], list[Cell]] | None:
        """Return the knots of the events and the cell at every knot; None where there is no route of at most `pace` cells."""
        costs = self._costs(pace)
        final = costs[-1][-1]
        if final.min() >= UNREACHABLE:
            return None
        cell: Cell = tuple(int(v) for v in np.unravel_index(int(final.argmin()), final.shape))
        layer, cells, knots = len(self.event_cells) - 1, [cell], [0] * len(self.event_cells)
        for k in range(len(self.search.free), -1, -1):
            while self._may_happen(layer, k) and self.event_cells[layer][cell]:
                if costs[k][layer - 1][cell] != costs[k][layer][cell]:
                    break
                knots[layer], layer = k, layer - 1
            if k:
                free = self._free_cells(layer, k - 1)
                cell = self.search.predecessor(cell, costs[k - 1][layer], int(costs[k][layer][cell]), free, pace)
                cells.append(cell)
        return knots, cells[::-1]

    def _costs(self, pace: int) -> list[list[Costs]]:
        """Return the smallest cost to each cell by knot and layer; UNREACHABLE where no route leads."""
        cost = [np.full(self.search.goal.shape, UNREACHABLE, dtype=np.int32) for _ in self.event_cells]
        cost[0][self.search.start_cell] = 0
        costs: list[list[Costs]] = []
        segments = len(self.search.free)
        for k in range(segments + 1):
            for layer in range(1, len(self.event_cells)):
                if self._may_happen(layer, k):
                    cost[layer] = np.where(self.event_cells[layer], np.minimum(cost[layer], cost[layer - 1]), cost[layer])
            costs.append(cost)
            if k < segments:
                cost = [self._next_cost(layer, k, c, pace) if c.min() < UNREACHABLE else c for layer, c in enumerate(cost)]
        return costs

    def _may_happen(self, event: int, k: int) -> bool:
        """Return whether an event after the start may happen at knot k."""
        return event > 0 and self.windows[event][0] <= k <= self.windows[event][1]

    def _free_cells(self, layer: int, k: int) -> Flags:
        return np.asarray(self.search.free[k] & self.allowed_cells[layer])

    def _next_cost(self, layer: int, k: int, cost: Costs, pace: int) -> Costs:
        return self.search.next_costs(cost, self._free_cells(layer, k), self.search.free_after(k), pace)


class _StateCells:
    """The cells in which the states of a mission hold."""

    def __init__(self, mission: Mission, arena: Arena, search: SliceSearch, width: Array) -> None:
        self.mission, self.half_width, self.growth = mission, width / 2, arena.clearance + width / 2
        self.shape = search.goal.shape
        self.points = np.stack(np.meshgrid(*search.cells.axes, indexing="ij"), axis=-1).reshape(-1, arena.dimension)
        self.cache: dict[StateFormula, Flags] = {}

    def cells_of(self, states: Iterable[StateFormula]) -> Flags:
        """Return the cells in which all of these states hold."""
        cells = np.ones(self.shape, dtype=bool)
        for state in states:
            if state not in self.cache:
                allowed = self.mission.states[state].holds_about(self.points, self.half_width, self.growth)
                self.cache[state] = allowed.reshape(self.shape)
            cells &= self.cache[state]
        return cells


def route_with_events(
    arena: Arena, mission: Mission, plan: Plan, *, centre: Array, width: Array, segments: int
) -> EventRoute | None:
    """Return a route from `centre` (n,) on which the plan's events happen in time, in the plan's order; None where none is found.

    width: (n,), of the tube.
    """
    events = [START, *(stop.event for stop in plan.stops)]
    for search in slice_searches(arena, centre, width, segments, is_coarse=True):
        if len(search.cells.moving) < arena.dimension:  # where a state holds would depend on the axes outside of the slice
            return None
        layers = _layers_of(plan, events, search, _StateCells(mission, arena, search, width))
        route = layers.cheapest_route(search.paces[0])
        if route is not None:
            knots, cells = route
            if _is_in_time(plan, events, knots, segments):
                points = search.cells.path_through(cells)
                points[0] = centre
                return EventRoute(knots, points)
    return None


def _layers_of(plan: Plan, events: Sequence[int], search: SliceSearch, state_cells: _StateCells) -> _Layers:
    """Return the layers of a plan: where its holds are true, and where and when its events may happen."""
    zone, holds, segments = plan.skeleton.zone, plan.skeleton.holds, len(search.free)
    assert zone is not None
    allowed_cells = []
    for layer in range(len(events)):
        done = set(events[: layer + 1])
        allowed_cells.append(state_cells.cells_of(h.state for h in holds if h.first in done and h.last not in done))
    event_cells = [state_cells.cells_of(h.state for h in holds if event in (h.first, h.last)) for event in events]
    allowed_cells[0][search.start_cell] = event_cells[0][search.start_cell] = True
    event_cells[-1] = event_cells[-1] & search.goal
    windows = [
        (
            int(np.ceil(-zone[event, START] * segments - KNOT_TOLERANCE)),
            int(np.floor(zone[START, event] * segments + KNOT_TOLERANCE)),
        )
        for event in events
    ]
    return _Layers(search, allowed_cells, event_cells, windows)


def _is_in_time(plan: Plan, events: Sequence[int], knots: Sequence[int], segments: int) -> bool:
    """Return whether all time bounds hold for events at these knots."""
    knot_of = dict(zip(events, knots, strict=True))
    return all(
        bound.minimum * segments - KNOT_TOLERANCE
        <= knot_of[bound.last] - knot_of[bound.first]
        <= bound.maximum * segments + KNOT_TOLERANCE
        for bound in plan.skeleton.time_bounds
    )
