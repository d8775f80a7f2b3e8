"""In which order, and where, the events of a skeleton happen: the shortest path that its times allow.

The search extends the beginnings of paths (labels.py) by one event after the other, the shortest first. A leg from one event to
the next is the shortest path among the waypoints on which all lasting holds stay true. plans.py, conflicts.py and
mission_search.py call this.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from stt_codegen.design.half_spaces import Array
from stt_codegen.design.missions.labels import TIME_TOLERANCE, Label, LabelQueue, add_if_better, zone_after_leg
from stt_codegen.design.missions.skeleton import END, SEAM, START, TOLERANCE, Skeleton
from stt_codegen.design.missions.waypoints import Flags, Waypoints

SEARCH_LABEL_LIMIT = 10_000  # labels of one search
TOUR_EVENT_LIMIT = 9  # up to so many events the shortest tour of their nodes is a lower bound
FREE_EVENT_NODE_LIMIT = 24  # nodes that are tried for an event that may happen anywhere


@dataclass(frozen=True)
class Stop:
    """An event and the points (m, n) of the path to it from the event before; no points where both are at one place."""

    event: int
    path: Array


@dataclass
class OrderSearch:
    """A search for the order and the nodes of one skeleton's events.

    fixed_order: events in the order that they must come in; empty for any order.
    """

    waypoints: Waypoints
    skeleton: Skeleton
    fixed_order: tuple[int, ...] = ()
    _tours: dict[tuple[int, frozenset[int]], float] = field(default_factory=dict)
    _remaining: dict[int, Array] = field(default_factory=dict)

    @cached_property
    def prerequisites(self) -> list[int]:
        """Return for each event which events must be done before it, a bit each."""
        skeleton = self.skeleton
        before = [0] * skeleton.event_count
        for bound in skeleton.time_bounds:
            if bound.minimum >= 0:
                before[bound.last] |= 1 << bound.first
            elif bound.maximum <= 0:
                before[bound.first] |= 1 << bound.last
        for hold in skeleton.holds:
            if hold.first != hold.last:
                before[hold.last] |= 1 << hold.first
        assert skeleton.zone is not None
        for i in range(skeleton.event_count):
            for j in range(skeleton.event_count):
                if i != j and skeleton.zone[j, i] < -TIME_TOLERANCE:
                    before[j] |= 1 << i
        for first, last in pairwise(self.fixed_order):
            before[last] |= 1 << first
        before[END] |= self.all_done & ~(1 << END)
        return [bits & ~(1 << event) for event, bits in enumerate(before)]

    @property
    def all_done(self) -> int:
        """Return the bits of all events."""
        return (1 << self.skeleton.event_count) - 1

    @cached_property
    def possible_nodes(self) -> Flags:
        """Return at which nodes each event may happen: (events, N)."""
        waypoints, skeleton = self.waypoints, self.skeleton
        possible = np.ones((skeleton.event_count, len(waypoints.nodes)), dtype=bool)
        for hold in skeleton.holds:
            if hold.first == hold.last:
                possible[hold.first] &= waypoints.nodes_in_state[hold.state]
            else:
                possible[hold.first] &= waypoints.passable_nodes(hold.state)
                possible[hold.last] &= waypoints.passable_nodes(hold.state)
        arena, half_width = waypoints.arena, waypoints.width / 2
        lower, upper = arena.target[0] + half_width - TOLERANCE, arena.target[1] - half_width + TOLERANCE
        possible[END] &= ((waypoints.nodes >= lower) & (waypoints.nodes <= upper)).all(axis=1)
        if len(arena.target_cuts.lower_bound):
            possible[END] &= arena.target_cuts.contain_boxes(waypoints.nodes, half_width)
        return possible

    @cached_property
    def distance_bounds(self) -> dict[int, Array]:
        """Return for each event that may not happen everywhere a lower bound on its distance from each node, (N,)."""
        rows = enumerate(self.possible_nodes)
        return {event: self.waypoints.distance_bounds(row) for event, row in rows if event != START and not row.all()}

    @cached_property
    def lasting_holds(self) -> list[tuple[int, int, int]]:
        """Return the bits of state, first and last event for each hold between two events."""
        bit = {state: 1 << k for k, state in enumerate(self.waypoints.mission.states)}
        return [(bit[h.state], 1 << h.first, 1 << h.last) for h in self.skeleton.holds if h.first != h.last]

    def states_after(self, done: int) -> int:
        """Return the states that must hold when these events are done, a bit each."""
        states = 0
        for state, first, last in self.lasting_holds:
            if done & first and not done & last:
                states |= state
        return states

    @cached_property
    def event_distances(self) -> dict[tuple[int, int], float]:
        """Return a lower bound on the distance from a node of one event to a node of another one."""
        rows = {START: self.possible_nodes[START] & (np.arange(len(self.waypoints.nodes)) == 0)}
        rows |= {event: self.possible_nodes[event] for event in self.distance_bounds}
        return {
            (first, last): float(distance[row].min())
            for first, row in rows.items()
            for last, distance in self.distance_bounds.items()
            if first != last
        }

    def remaining_length(self, done: int) -> Array:
        """Return from each node a lower bound on the length of the path once these events are done: (N,).

        It is the shortest tour of the other events, as if each were at its nearest node.
        """
        if done not in self._remaining:
            self._remaining[done] = self._shortest_tour(frozenset(e for e in self.distance_bounds if not done >> e & 1))
        return self._remaining[done]

    def _shortest_tour(self, events: frozenset[int]) -> Array:
        """Return from each node a lower bound on the length of a path past nodes of all these events: (N,)."""
        if not events:
            return np.zeros(len(self.waypoints.nodes))
        if len(events) > TOUR_EVENT_LIMIT:
            return np.asarray(np.max([self.distance_bounds[e] for e in events], axis=0))
        lengths = [self.distance_bounds[e] + self._tour_from(e, events - {e}) for e in self._possibly_first(events)]
        return np.asarray(np.min(lengths, axis=0))

    def _possibly_first(self, events: frozenset[int]) -> list[int]:
        """Return which of some events may be the first of them."""
        bits = sum(1 << e for e in events)
        return [e for e in events if not self.prerequisites[e] & bits]

    def _tour_from(self, event: int, events: frozenset[int]) -> float:
        """Return a lower bound on the length of a path from a node of one event past nodes of others."""
        if not events:
            return 0.0
        if (event, events) not in self._tours:
            lengths = (self.event_distances[event, e] + self._tour_from(e, events - {e}) for e in self._possibly_first(events))
            self._tours[event, events] = min(lengths)
        return self._tours[event, events]

    def shortest_stops(self, speed: float) -> list[Stop] | None:
        """Return the stops of the shortest path that is in time at this speed, in lengths per t_c; None where none is found."""
        possible = self.possible_nodes if len(self.waypoints.nodes) else None
        if possible is None or not possible.any(axis=1).all() or not possible[START, 0]:
            return None
        queue = LabelQueue()
        zone = self.skeleton.zone if self.skeleton.has_windows else None
        queue.push(Label(length=0.0, time=0.0, done=1 << START, node=0, parent=-1, event=START, zone=zone), 0.0)
        limit, extended = min(SEARCH_LABEL_LIMIT, self.waypoints.labels_left), 0
        while queue.heap and extended < limit:
            index = queue.pop()
            label = queue.labels[index]
            if queue.is_outdated(label):
                continue
            extended += 1
            self.waypoints.labels_left -= 1
            if label.done == self.all_done:
                return self._stops_of(queue.labels, index)
            for event in self._next_events(label):
                if label.zone is None:
                    self._extend_by_length(queue, index, event)
                else:
                    self._extend_in_time(queue, index, event, speed)
        return None

    def _next_events(self, label: Label) -> Iterator[int]:
        """Yield the events that may come next."""
        for event, before in enumerate(self.prerequisites):
            if not label.done >> event & 1 and not before & ~label.done:
                yield event

    def _extend_by_length(self, queue: LabelQueue, index: int, event: int) -> None:
        """Add the labels in which an event comes next, where only the order of events counts."""
        label = queue.labels[index]
        done = label.done | 1 << event
        remaining = self.remaining_length(done)
        legs = self._legs_to(label)
        nodes = self._nearest(event, np.nonzero(self._is_possible(label, event, legs))[0], legs)
        known = queue.lengths.setdefault(done, np.full(len(legs), np.inf))
        nodes = nodes[label.length + legs[nodes] < known[nodes] - TOLERANCE]
        known[nodes] = label.length + legs[nodes]
        for node, leg in zip(nodes.tolist(), legs[nodes].tolist(), strict=True):
            length = label.length + leg
            extended = Label(length=length, time=0.0, done=done, node=node, parent=index, event=event, zone=None)
            queue.push(extended, float(remaining[node]))

    def _extend_in_time(self, queue: LabelQueue, index: int, event: int, speed: float) -> None:
        """Add the labels in which an event comes next in time, at this speed."""
        label = queue.labels[index]
        assert label.zone is not None
        done = label.done | 1 << event
        remaining = self.remaining_length(done)
        legs = self._legs_to(label)
        times = np.maximum(legs / speed - label.zone[label.event, START], -label.zone[event, START])
        is_in_time = self._is_possible(label, event, legs) & self._is_in_time(label, event, legs, times, speed=speed)
        nodes = self._nearest(event, np.nonzero(is_in_time)[0], legs)
        begins_cycle = self.skeleton.seam is not None and event == SEAM
        for node, leg, time in zip(nodes.tolist(), legs[nodes].tolist(), times[nodes].tolist(), strict=True):
            length, seam_node = label.length + leg, node if begins_cycle else label.seam_node
            if not add_if_better(queue.fronts.setdefault((done, node, seam_node), []), length, time):
                continue
            zone = zone_after_leg(label.zone, label.event, event, leg / speed)
            if not (np.diag(zone) < -TIME_TOLERANCE).any():
                extended = Label(
                    length=length, time=time, done=done, node=node, parent=index, event=event, zone=zone, seam_node=seam_node
                )
                queue.push(extended, float(remaining[node]))

    def _legs_to(self, label: Label) -> Array:
        """Return the length of the next leg to every node, while the states hold that must, inf where there is none: (N,)."""
        return self.waypoints.shortest_legs(self.states_after(label.done), label.node)[0]

    def _is_possible(self, label: Label, event: int, legs: Array) -> Flags:
        """Return at which nodes an event may come next, apart from its time: (N,). legs: (N,), their lengths."""
        is_possible = self.possible_nodes[event] & np.isfinite(legs)
        if event == END and self.skeleton.seam is not None:
            is_possible &= np.arange(len(legs)) == label.seam_node
        return np.asarray(is_possible)

    def _is_in_time(self, label: Label, event: int, legs: Array, times: Array, *, speed: float) -> Flags:
        """Return at which nodes an event comes in time, with time left for each event after it: (N,).

        legs, times: (N,), the lengths of the legs and the earliest times at their ends.
        """
        zone = label.zone
        assert zone is not None
        is_in_time = legs <= zone[label.event, event] * speed + TIME_TOLERANCE
        for later, distance in self.distance_bounds.items():
            if later != event and not label.done >> later & 1 and zone[START, later] < np.inf:
                is_in_time &= times + distance / speed <= zone[START, later] + TIME_TOLERANCE
        return np.asarray(is_in_time)

    def _nearest(self, event: int, nodes: npt.NDArray[np.int64], legs: Array) -> npt.NDArray[np.int64]:
        """Return the nodes to try for an event: all of them, or the nearest where the event may happen anywhere."""
        if event not in self.distance_bounds and len(nodes) > FREE_EVENT_NODE_LIMIT:
            return nodes[np.argsort(legs[nodes], kind="stable")[:FREE_EVENT_NODE_LIMIT]]
        return nodes

    def _stops_of(self, labels: Sequence[Label], index: int) -> list[Stop]:
        """Return the stops of the path that ends with a label, the first one first."""
        stops = []
        while labels[index].parent >= 0:
            label, parent = labels[index], labels[labels[index].parent]
            _, predecessors = self.waypoints.shortest_legs(self.states_after(parent.done), parent.node)
            nodes = [label.node]
            while nodes[-1] != parent.node:
                nodes.append(int(predecessors[nodes[-1]]))
            stops.append(Stop(label.event, self.waypoints.nodes[nodes[-2::-1]]))
            index = label.parent
        return stops[::-1]
