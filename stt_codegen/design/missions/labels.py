"""The labels of a search for an order of events: beginnings of paths, and which of them to extend next.

A label says which events are done, at which node the centre is, and the zone: the closed difference-bound matrix (skeleton.py) of
all times that the legs leave. Of labels with the same events and node only those remain that are shorter or earlier than the
others, at most FRONT_LIMIT of them. orders.py calls this.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field

import numpy as np

from stt_codegen.design.half_spaces import Array
from stt_codegen.design.missions.skeleton import TOLERANCE

FRONT_LIMIT = 3
TIME_TOLERANCE = 1e-7  # by which a time may be late, for it is rounded


@dataclass(frozen=True, kw_only=True)
class Label:
    """The beginning of a path, whose last leg came from the label `parent` and ended with `event` at `node`.

    length: of the path. time: the earliest one at its end. done: a bit for each event that is done. zone: of all times; None
    where only the order counts. seam_node: where the cycle of a tube that repeats itself begins, and ends; -1 before that.
    """

    length: float
    time: float
    done: int
    node: int
    parent: int
    event: int
    zone: Array | None
    seam_node: int = -1


@dataclass
class LabelQueue:
    """The labels of one search, and which of them to extend next.

    lengths: by the events done the smallest length to every node, where only the order counts. fronts: by events done, node and
    seam node the lengths and times that no other label beats, where times count.
    """

    labels: list[Label] = field(default_factory=list)
    heap: list[tuple[float, int]] = field(default_factory=list)
    lengths: dict[int, Array] = field(default_factory=dict)
    fronts: dict[tuple[int, int, int], list[tuple[float, float]]] = field(default_factory=dict)

    def push(self, label: Label, remaining: float) -> None:
        """Add a label from which the path is longer by at least `remaining`."""
        self.labels.append(label)
        heapq.heappush(self.heap, (label.length + remaining, len(self.labels) - 1))

    def pop(self) -> int:
        """Return the index of the label whose path may become the shortest."""
        return heapq.heappop(self.heap)[1]

    def is_outdated(self, label: Label) -> bool:
        """Return whether a shorter label reached the same node since this one was added."""
        return label.done in self.lengths and label.length > self.lengths[label.done][label.node] + TOLERANCE


def add_if_better(front: list[tuple[float, float]], length: float, time: float) -> bool:
    """Add a length and a time to the front if none there is both shorter and earlier, and return whether they were added."""
    if any(a <= length + TOLERANCE and b <= time + TOLERANCE for a, b in front):
        return False
    if len(front) >= FRONT_LIMIT and not all(length < a for a, _ in front):
        return False
    front.append((length, time))
    return True


def zone_after_leg(zone: Array, first: int, last: int, duration: float) -> Array:
    """Return the zone where at least this much time passes from the event `first` to the event `last`."""
    return np.asarray(np.minimum(zone, zone[:, last, None] - duration + zone[None, first]))
