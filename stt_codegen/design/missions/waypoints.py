"""The waypoints between which a mission is planned, and the shortest legs between them while some states hold.

orders.py and plans.py search among the waypoints. Their grown sets and their lines of sight are those of routes/.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.missions.skeleton import TOLERANCE
from stt_codegen.design.missions.state_constraints import LABEL_LIMIT, Mission
from stt_codegen.design.routes import COMPONENT_SUM_WEIGHT, GrownObstacles, grow_obstacles, route_nodes
from stt_codegen.task.mission import StateFormula

PAIR_LIMIT = 576  # pairs of regions; with more, their nearest points are no waypoints
CORNER_DIMENSION_LIMIT = 3  # up to so many dimensions all corners of a region are waypoints
ALL_LEGS_LIMIT = 300  # up to so many waypoints all legs are computed at once
MINIMUM_LENGTH = 1e-12  # added to the length between two nodes; in a graph the length 0 means that no line joins them
EDGE_ALLOWANCE = 1e-7  # sets are smaller by this where lines of sight are checked, so that a leg may run along an edge
Flags = npt.NDArray[np.bool_]
Predecessors = npt.NDArray[np.int32]


@dataclass(kw_only=True)
class Waypoints:
    """Where the centre of a tube of some width may be: nodes (N, n), the first one that of the start.

    start: gamma(0), (2, n). width: (n,). labels_left: how many labels the searches for an order of the visits may still use.
    """

    arena: Arena
    mission: Mission
    start: Array
    width: Array
    labels_left: int = LABEL_LIMIT
    _visibility: dict[StateFormula, Flags] = field(default_factory=dict)
    _graphs: dict[int, Array] = field(default_factory=dict)
    _distance_bounds: dict[bytes, Array] = field(default_factory=dict)
    _legs: dict[tuple[int, int], tuple[Array, Predecessors]] = field(default_factory=dict)

    @cached_property
    def growth(self) -> Array:
        """Return how far a set must be from the centre, on each axis: the clearance and half of the width, (n,)."""
        return np.asarray(self.arena.clearance + self.width / 2)

    @cached_property
    def nodes(self) -> Array:
        """Return the waypoints (N, n) that are in the space, clear of the unsafe sets and in all permanent states.

        They are the nodes of a route among the unsafe sets and among the sets that the states exclude, the centres and corners of
        regions and the points of regions that are nearest to another region. There are none where the start is not free.
        """
        half_width, centre = self.width / 2, (self.start[0] + self.start[1]) / 2
        space, target = (np.stack([box[0] + half_width, box[1] - half_width]) for box in (self.arena.space, self.arena.target))
        obstacles = grow_obstacles(self.arena, self.growth)
        points = np.concatenate([route_nodes(obstacles, space, target, centre), *self._region_points(space, target, centre)])
        is_free = self._free(points, space, obstacles)
        if not is_free[0]:
            return np.empty((0, len(centre)))
        further = np.unique(np.round(points[1:][is_free[1:]], 12), axis=0)
        return np.concatenate([points[:1], further])

    def _region_points(self, space: Array, target: Array, centre: Array) -> list[Array]:
        """Return the waypoints that the states of the mission add, as arrays (P, n)."""
        points, middles = [], []
        boxes: list[list[Array]] = []  # of centres, for each state
        for constraint in self.mission.states.values():
            excluded = constraint.grown_obstacles(self.growth)
            if excluded is not None:
                points.append(route_nodes(excluded, space, target, centre))
            pieces = (piece.box_of_centres(self.arena, self.width / 2) for piece in constraint.pieces)
            boxes.append([box for box in pieces if box is not None])
            middles += [(box[0] + box[1]) / 2 for box in boxes[-1]]
            points += [_corners_of(box, centre) for box in boxes[-1]]
        for state_boxes in boxes:  # the point of a region that is nearest to another region
            if len(state_boxes) * len(middles) <= PAIR_LIMIT:
                points += [np.clip(middle, box[0], box[1])[None] for box in state_boxes for middle in middles]
        return points

    def _free(self, points: Array, space: Array, obstacles: GrownObstacles) -> Flags:
        """Return which points (P, n) are in the space, clear of the obstacles and in all permanent states: (P,)."""
        is_clear = ~obstacles.contain(points)
        is_free = is_clear & ((points >= space[0] - TOLERANCE) & (points <= space[1] + TOLERANCE)).all(axis=1)
        if len(self.arena.space_cuts.lower_bound):
            is_free &= self.arena.space_cuts.contain_boxes(points, self.width / 2)
        is_free[0] |= is_clear[0]  # gamma(0) is in the space, though a box of this width about its centre may not be
        for state in self.mission.permanent_states:
            constraint = self.mission.states[state]
            excluded = constraint.grown_obstacles(self.growth - EDGE_ALLOWANCE)
            if excluded is None:
                is_free &= constraint.holds_about(points, self.width / 2, self.growth)
            else:
                is_free &= ~excluded.contain(points)
        return np.asarray(is_free)

    @cached_property
    def distances(self) -> Array:
        """Return the distances between nodes, with ties decided as for a route: (N, N)."""
        distances = np.zeros((len(self.nodes),) * 2)
        for k, node in enumerate(self.nodes):
            steps = np.abs(self.nodes - node)
            total = steps[:, 0].copy()
            for i in range(1, steps.shape[1]):
                total += steps[:, i]
            distances[k] = self.arena.distance(steps) + COMPONENT_SUM_WEIGHT * total
        return distances

    @cached_property
    def visibility(self) -> Flags:
        """Return between which nodes the straight line meets no unsafe set: (N, N)."""
        return self._visibility_in(self.arena)

    def _visibility_in(self, arena: Arena) -> Flags:
        """Return between which nodes the straight line meets none of an arena's unsafe sets, made a little smaller: (N, N)."""
        obstacles = grow_obstacles(arena, self.growth - EDGE_ALLOWANCE)
        is_visible = np.ones((len(self.nodes),) * 2, dtype=bool)
        if len(arena.names):
            for k, node in enumerate(self.nodes[:-1]):
                is_visible[k, k + 1 :] = obstacles.visible_from(node, self.nodes[k + 1 :])
        upper = np.triu(is_visible)
        return np.asarray(upper | upper.T)

    @cached_property
    def nodes_in_state(self) -> dict[StateFormula, Flags]:
        """Return for each state at which nodes it holds: (N,)."""
        half_width = self.width / 2
        return {state: c.holds_about(self.nodes, half_width, self.growth) for state, c in self.mission.states.items()}

    def visibility_within(self, state: StateFormula) -> Flags:
        """Return between which nodes a state holds all along the straight line: (N, N)."""
        if state not in self._visibility:
            constraint, is_passable = self.mission.states[state], self.passable_nodes(state)
            excluded = constraint.complement
            is_visible = np.ones_like(self.visibility) if excluded is None else self._visibility_in(excluded)
            self._visibility[state] = is_visible & is_passable[:, None] & is_passable[None]
        return self._visibility[state]

    def passable_nodes(self, state: StateFormula) -> Flags:
        """Return at which nodes the tube may be while a state holds, also across two boxes of a union: (N,)."""
        obstacles = self.mission.states[state].grown_obstacles(self.growth - EDGE_ALLOWANCE)
        return self.nodes_in_state[state] if obstacles is None else ~obstacles.contain(self.nodes)

    def _graph(self, states: int) -> Array:
        """Return the lengths of the straight lines along which these states hold, 0 where there is none: (N, N)."""
        if states not in self._graphs:
            is_visible = self.visibility
            for k, state in enumerate(self.mission.states):
                if states >> k & 1:
                    is_visible = is_visible & self.visibility_within(state)
            self._graphs[states] = np.where(is_visible, self.distances + MINIMUM_LENGTH, 0.0)
        return self._graphs[states]

    def shortest_legs(self, states: int, source: int) -> tuple[Array, Predecessors]:
        """Return the distances from a node to all nodes while these states hold, and the node before each one: (N,) each.

        states: a bit for each state, in the mission's order.
        """
        if (states, source) not in self._legs:
            from scipy.sparse.csgraph import dijkstra

            if len(self.nodes) > ALL_LEGS_LIMIT:
                self._legs[states, source] = dijkstra(self._graph(states), indices=source, return_predecessors=True)
            else:
                lengths, predecessors = dijkstra(self._graph(states), return_predecessors=True)
                self._legs.update({(states, k): (lengths[k], predecessors[k]) for k in range(len(self.nodes))})
        return self._legs[states, source]

    def distance_bounds(self, goals: Flags) -> Array:
        """Return a lower bound on the distance from each node to the nearest of some nodes, whatever states hold: (N,)."""
        if (key := goals.tobytes()) not in self._distance_bounds:
            from scipy.sparse.csgraph import dijkstra

            lengths = dijkstra(self._graph(0), indices=np.nonzero(goals)[0], min_only=True)
            self._distance_bounds[key] = np.asarray(lengths / (1 + COMPONENT_SUM_WEIGHT * self.arena.dimension))
        return self._distance_bounds[key]


def _corners_of(box: Array, centre: Array) -> Array:
    """Return the middle of a box, its point nearest to the centre and, in few dimensions, its corners: (P, n)."""
    n = len(centre)
    points = [(box[0] + box[1]) / 2, np.clip(centre, box[0], box[1])]
    if n <= CORNER_DIMENSION_LIMIT:
        points += [np.where(np.array([k >> i & 1 for i in range(n)]) == 1, box[1], box[0]) for k in range(1 << n)]
    return np.array(points)
