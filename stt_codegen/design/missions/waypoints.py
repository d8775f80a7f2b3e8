"""The places between which a mission is planned, and the shortest legs between them while some states are held."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.missions.skeleton import TINY
from stt_codegen.design.missions.state_constraints import LABELS, Mission
from stt_codegen.design.routes import STRAIGHT, obstacles_of, route_nodes
from stt_codegen.task.mission import State

MOST_PAIRS = 576  # of regions of which the nearest points are places too
CORNERS = 3  # dimensions in which all corners of a region are places
ALL_LEGS = 300  # places between which all legs are found at once
TINIEST = 1e-12  # between nodes at one place, for 0 is no edge of a graph
THIN = 1e-7  # sets are so much smaller where a leg is looked along their edge
Flags = npt.NDArray[np.bool_]


@dataclass(kw_only=True)
class Places:
    """Where the centre of a tube of some width may be: nodes (N, n), the first that of the start, and which see each other. left:
    how many labels may still be looked at in searches for an order of the visits among them."""

    arena: Arena
    mission: Mission
    start: Array
    width: Array
    left: int = LABELS
    _sights: dict[State, Flags] = field(default_factory=dict)
    _graphs: dict[int, Array] = field(default_factory=dict)
    _far: dict[bytes, Array] = field(default_factory=dict)
    _legs: dict[tuple[int, int], tuple[Array, npt.NDArray[np.int32]]] = field(default_factory=dict)

    @cached_property
    def reach(self) -> Array:
        return np.asarray(self.arena.clearance + self.width / 2)

    @cached_property
    def nodes(self) -> Array:
        arena, half = self.arena, self.width / 2
        space = np.stack([arena.space[0] + half, arena.space[1] - half])
        centre = (self.start[0] + self.start[1]) / 2
        grown = obstacles_of(arena, self.reach)
        goal = np.stack([arena.target[0] + half, arena.target[1] - half])
        found = [route_nodes(grown, space, goal, centre)]
        middles = []
        for asked in self.mission.states.values():
            blocking = asked.obstacles(self.reach)
            if blocking is not None:
                found.append(route_nodes(blocking, space, goal, centre))
            for piece in asked.pieces:
                box = piece.centres(arena, half)
                if box is not None:
                    middles.append((box[0] + box[1]) / 2)
                    found.append(self._corners(box, centre))
        for asked in self.mission.states.values():  # the point of a region that is nearest to another region
            boxes = [box for piece in asked.pieces if (box := piece.centres(arena, half)) is not None]
            if len(boxes) * len(middles) <= MOST_PAIRS:
                found += [np.clip(m, box[0], box[1])[None] for box in boxes for m in middles]
        points = np.concatenate(found)
        free = ~grown.inside(points) & ((points >= space[0] - TINY) & (points <= space[1] + TINY)).all(axis=1)
        if len(arena.walls.bound):
            free &= arena.walls.contain_boxes(points, half)
        free[0] |= not grown.inside(points[:1])[0]
        for state in self.mission.permanent:
            asked = self.mission.states[state]
            blocking = asked.obstacles(self.reach - THIN)
            free &= asked.allows(points, half, self.reach) if blocking is None else ~blocking.inside(points)
        first = points[0]
        rest = np.unique(np.round(points[1:][free[1:]], 12), axis=0)
        return np.concatenate([first[None], rest]) if free[0] else np.empty((0, len(first)))

    @staticmethod
    def _corners(box: Array, centre: Array) -> Array:
        n = len(centre)
        points = [(box[0] + box[1]) / 2, np.clip(centre, box[0], box[1])]
        if n <= CORNERS:
            points += [np.where(np.array([k >> i & 1 for i in range(n)]) == 1, box[1], box[0]) for k in range(1 << n)]
        return np.array(points)

    @cached_property
    def distance(self) -> Array:
        """Between nodes, ties broken as for a route: (N, N)."""
        found = np.zeros((len(self.nodes),) * 2)
        for k, node in enumerate(self.nodes):
            steps = np.abs(self.nodes - node)
            total = steps[:, 0].copy()
            for i in range(1, steps.shape[1]):
                total += steps[:, i]
            found[k] = self.arena.distance(steps) + STRAIGHT * total
        return found

    @cached_property
    def sight(self) -> Flags:
        """Which nodes see each other past the unsafe sets: (N, N)."""
        return self._seen(self.arena)

    def _seen(self, arena: Arena) -> Flags:
        """Past the unsafe sets of an arena, a little smaller than they are, so that a way along an edge is one."""
        grown = obstacles_of(arena, self.reach - THIN)
        found = np.ones((len(self.nodes),) * 2, dtype=bool)
        if len(arena.names):
            for k, node in enumerate(self.nodes[:-1]):
                found[k, k + 1 :] = grown.visible(node, self.nodes[k + 1 :])
        upper = np.triu(found)
        return np.asarray(upper | upper.T)

    @cached_property
    def allowed(self) -> dict[State, Flags]:
        """At which nodes each state holds: (N,)."""
        half = self.width / 2
        return {state: asked.allows(self.nodes, half, self.reach) for state, asked in self.mission.states.items()}

    def sight_of(self, state: State) -> Flags:
        """Between which nodes a state is kept all the way."""
        if state not in self._sights:
            asked, here = self.mission.states[state], self.passable(state)
            seen = np.ones_like(self.sight) if asked.blocking is None else self._seen(asked.blocking)
            self._sights[state] = seen & here[:, None] & here[None]
        return self._sights[state]

    def passable(self, state: State) -> Flags:
        """At which nodes a hold of the state may be open: for a union of boxes between two of them too."""
        asked = self.mission.states[state]
        grown = asked.obstacles(self.reach - THIN)
        return self.allowed[state] if grown is None else ~grown.inside(self.nodes)

    def _graph(self, states: int) -> Array:
        """The lengths of what is in sight while these states are held, 0 where nothing is."""
        if states not in self._graphs:
            seen = self.sight
            for k, state in enumerate(self.mission.states):
                seen = seen & self.sight_of(state) if states >> k & 1 else seen
            self._graphs[states] = np.where(seen, self.distance + TINIEST, 0.0)
        return self._graphs[states]

    def legs(self, states: int, source: int) -> tuple[Array, npt.NDArray[np.int32]]:
        """Distances from a node to all, and the node before each, while these states are held, a bit each in the mission's
        order."""
        if (states, source) not in self._legs:
            from scipy.sparse.csgraph import dijkstra

            if len(self.nodes) > ALL_LEGS:
                self._legs[states, source] = dijkstra(self._graph(states), indices=source, return_predecessors=True)
            else:
                lengths, before = dijkstra(self._graph(states), return_predecessors=True)
                self._legs.update({(states, k): (lengths[k], before[k]) for k in range(len(self.nodes))})
        return self._legs[states, source]

    def far(self, goals: Flags) -> Array:
        """How far it is at least from every node to the nearest of some, whatever is held: (N,)."""
        if (name := goals.tobytes()) not in self._far:
            from scipy.sparse.csgraph import dijkstra

            lengths = dijkstra(self._graph(0), indices=np.nonzero(goals)[0], min_only=True)
            self._far[name] = np.asarray(lengths / (1 + STRAIGHT * self.arena.dimension))
        return self._far[name]
