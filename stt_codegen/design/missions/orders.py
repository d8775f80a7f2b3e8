"""In which order, and where, the events of a skeleton happen: the shortest way that its times allow.

Labels are searched, shortest first: which events are done, at which place the centre is, and the zone, the closed
difference-bound matrix of all times with the legs so far. A leg is the shortest way among the places that keeps to all holds that
are open. Of labels with the same events and place those count that are shorter or earlier than the others, at most BEAM of them.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from stt_codegen.design.half_spaces import Array
from stt_codegen.design.missions.skeleton import END, SEAM, START, TINY, Skeleton
from stt_codegen.design.missions.waypoints import Flags, Places

BEAM = 3
LATE = 1e-7  # what a time may lack for rounding
MOST_LABELS = 10_000  # of one search
MOST_TOURED = 9  # places of events whose shortest tour is a bound
NEAREST = 24  # places at which an event happens that may be anywhere


@dataclass(frozen=True)
class Stop:
    """An event, and the points of the way to it from the one before, (m, n); none where it is at the same place."""

    event: int
    way: Array


@dataclass(frozen=True, kw_only=True)
class _Label:
    """A beginning of a way: its length and the earliest time at its end, which events are done, a bit each, and where it is. The
    last leg came from label `parent` and ended with `event`; zone: of all times, where there are any; home: where the cycle of a
    tube that repeats itself begins, once it has, and ends."""

    length: float
    time: float
    done: int
    place: int
    parent: int
    event: int
    zone: Array | None
    home: int = -1


@dataclass
class Order:
    """A search for one skeleton. given: the events in the order that they must come in; empty: in any."""

    places: Places
    skeleton: Skeleton
    given: tuple[int, ...] = ()
    tours: dict[tuple[int, frozenset[int]], float] = field(default_factory=dict)

    @cached_property
    def before(self) -> list[int]:
        """Which events must be done before each: bits."""
        s = self.skeleton
        found = [0] * s.events
        for d in s.differences:
            if d.least >= 0:
                found[d.last] |= 1 << d.first
            elif d.most <= 0:
                found[d.first] |= 1 << d.last
        for hold in s.holds:
            if hold.first != hold.last:
                found[hold.last] |= 1 << hold.first
        assert s.zone is not None
        for i in range(s.events):
            for j in range(s.events):
                if i != j and s.zone[j, i] < -1e-7:
                    found[j] |= 1 << i
        for first, last in pairwise(self.given):
            found[last] |= 1 << first
        found[END] |= ((1 << s.events) - 1) & ~(1 << END)
        return [bits & ~(1 << k) for k, bits in enumerate(found)]

    @cached_property
    def possible(self) -> Flags:
        """At which nodes each event may happen: (events, N)."""
        places, s = self.places, self.skeleton
        found = np.ones((s.events, len(places.nodes)), dtype=bool)
        for hold in s.holds:
            if hold.first == hold.last:
                found[hold.first] &= places.allowed[hold.state]
            else:
                found[hold.first] &= places.passable(hold.state)
                found[hold.last] &= places.passable(hold.state)
        arena, half = places.arena, places.width / 2
        inside = (places.nodes >= arena.target[0] + half - TINY) & (places.nodes <= arena.target[1] - half + TINY)
        found[END] &= inside.all(axis=1)
        if len(arena.goals.bound):
            found[END] &= arena.goals.contain_boxes(places.nodes, half)
        return found

    @cached_property
    def far(self) -> dict[int, Array]:
        """For each event that may not be anywhere how far it is at least from every node, (N,)."""
        return {e: self.places.far(row) for e, row in enumerate(self.possible) if e != START and not row.all()}

    @cached_property
    def held(self) -> list[tuple[int, int, int]]:
        """The holds of some length: the bits of state, first and last event."""
        bit = {state: 1 << k for k, state in enumerate(self.places.mission.states)}
        return [(bit[h.state], 1 << h.first, 1 << h.last) for h in self.skeleton.holds if h.first != h.last]

    def open_after(self, done: int) -> int:
        """The states that are held when these events are done, a bit each."""
        found = 0
        for state, first, last in self.held:
            if done & first and not done & last:
                found |= state
        return found

    @cached_property
    def gaps(self) -> dict[tuple[int, int], float]:
        """How far it is at least from a place of one event to one of another."""
        rows = {START: self.possible[START] & (np.arange(len(self.places.nodes)) == 0)}
        rows |= {e: self.possible[e] for e in self.far}
        return {(e, f): float(away[row].min()) for e, row in rows.items() for f, away in self.far.items() if e != f}

    def rest(self, done: int) -> Array:
        """What is left to go at least, from every node (N,), once these events are done: the shortest tour of their places, as if
        each were as near as its nearest point."""
        left = frozenset(e for e in self.far if not done >> e & 1)
        if not left:
            return np.zeros(len(self.places.nodes))
        if len(left) > MOST_TOURED:
            return np.asarray(np.max([self.far[e] for e in left], axis=0))
        return np.asarray(np.min([self.far[e] + self._tour(e, left - {e}) for e in self._first(left)], axis=0))

    def _first(self, left: frozenset[int]) -> list[int]:
        """Those of some events that may come first."""
        bits = sum(1 << e for e in left)
        return [e for e in left if not self.before[e] & bits]

    def _tour(self, here: int, left: frozenset[int]) -> float:
        """What it takes at least from a place of an event to visit those of others."""
        if not left:
            return 0.0
        if (here, left) not in self.tours:
            found = (self.gaps[here, e] + self._tour(e, left - {e}) for e in self._first(left))
            self.tours[here, left] = min(found)
        return self.tours[here, left]

    def shortest(self, speed: float) -> list[Stop] | None:
        """The shortest way that is in time at this speed, lengths per t_c; None where none was found."""
        nodes = len(self.places.nodes)
        if not nodes or not self.possible.any(axis=1).all() or not self.possible[START, 0]:
            return None
        labels = [
            _Label(
                length=0.0,
                time=0.0,
                done=1,
                place=0,
                parent=-1,
                event=START,
                zone=self.skeleton.zone if self.skeleton.timed else None,
            )
        ]
        fronts: dict[tuple[int, int, int], list[tuple[float, float]]] = {}
        repeats = self.skeleton.seam is not None
        ahead: dict[int, Array] = {}
        best: dict[int, Array] = {}  # where only the order counts, the length to every node
        queue, popped = [(0.0, 0)], 0
        most = min(MOST_LABELS, self.places.left)
        while queue and popped < most:
            _, k = heapq.heappop(queue)
            label = labels[k]
            if label.done in best and label.length > best[label.done][label.place] + TINY:
                continue
            popped += 1
            self.places.left -= 1
            if label.done == (1 << self.skeleton.events) - 1:
                return self._way(labels, k)
            for event, done in self._next(label):
                if done not in ahead:
                    ahead[done] = self.rest(done)
                places, lengths, times = self._reached(label, event, done, speed)
                if label.zone is None:
                    known = best.setdefault(done, np.full(nodes, np.inf))
                    better = label.length + lengths < known[places] - TINY
                    places, lengths = places[better], lengths[better]
                    known[places] = label.length + lengths
                    for place, leg in zip(places.tolist(), lengths.tolist(), strict=True):
                        labels.append(
                            _Label(length=label.length + leg, time=0.0, done=done, place=place, parent=k, event=event, zone=None)
                        )
                        heapq.heappush(queue, (label.length + leg + float(ahead[done][place]), len(labels) - 1))
                    continue
                for place, leg, time in zip(places.tolist(), lengths.tolist(), times.tolist(), strict=True):
                    length, home = label.length + leg, place if repeats and event == SEAM else label.home
                    if _improves(fronts.setdefault((done, place, home), []), length, time):
                        zone = _after(label.zone, label.event, event, leg / speed)
                        if not (np.diag(zone) < -LATE).any():
                            labels.append(
                                _Label(
                                    length=length, time=time, done=done, place=place, parent=k, event=event, zone=zone, home=home
                                )
                            )
                            heapq.heappush(queue, (length + float(ahead[done][place]), len(labels) - 1))
        return None

    def _next(self, label: _Label) -> Iterator[tuple[int, int]]:
        """The events that may come next, and what is done with them."""
        for event, before in enumerate(self.before):
            if not label.done >> event & 1 and not before & ~label.done:
                yield event, label.done | 1 << event

    def _reached(self, label: _Label, event: int, done: int, speed: float) -> tuple[npt.NDArray[np.int64], Array, Array]:
        """Where an event may happen in time, how far that is, and the earliest time: three times (M,)."""
        lengths, _ = self.places.legs(self.open_after(label.done), label.place)
        good, when, zone = self.possible[event] & np.isfinite(lengths), np.zeros(len(lengths)), label.zone
        if event == END and self.skeleton.seam is not None:
            good &= np.arange(len(good)) == label.home
        if zone is not None:
            when = np.maximum(lengths / speed - zone[label.event, START], -zone[event, START])
            good &= lengths <= zone[label.event, event] * speed + LATE
            for other, away in self.far.items():
                if not done >> other & 1 and zone[START, other] < np.inf:
                    good &= when + away / speed <= zone[START, other] + LATE
        places = np.nonzero(good)[0]
        if event not in self.far and len(places) > NEAREST:
            places = places[np.argsort(lengths[places], kind="stable")[:NEAREST]]
        return places, lengths[places], when[places]

    def _way(self, labels: Sequence[_Label], k: int) -> list[Stop]:
        """The stops of a label, from the first on."""
        stops = []
        while labels[k].parent >= 0:
            label, above = labels[k], labels[labels[k].parent]
            _, before = self.places.legs(self.open_after(above.done), above.place)
            path = [label.place]
            while path[-1] != above.place:
                path.append(int(before[path[-1]]))
            stops.append(Stop(label.event, self.places.nodes[path[-2::-1]]))
            k = label.parent
        return stops[::-1]


def _improves(front: list[tuple[float, float]], length: float, time: float) -> bool:
    """Whether a label is shorter or earlier than all that are there; if it is, it is put among them."""
    if any(a <= length + TINY and b <= time + TINY for a, b in front):
        return False
    if len(front) >= BEAM and not all(length < a for a, _ in front):
        return False
    front.append((length, time))
    return True


def _after(zone: Array, first: int, last: int, least: float) -> Array:
    """The zone where there is at least so much time between two events."""
    return np.asarray(np.minimum(zone, zone[:, last, None] - least + zone[None, first]))
