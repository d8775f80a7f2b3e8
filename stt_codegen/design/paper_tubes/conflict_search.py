"""Best-first search over conflicts: which circumvent functions make a tube safe.

A node is a set of pushes; its tube is evaluated with the paper's own functions on a time grid. For the earliest conflict
with an unsafe set U_j the search branches over (dimension i, side): i must be strictly on that side of U_j over the span
around the conflict in which all other dimensions overlap U_j; on request also over holding dimension i before U_j a little
longer, which an S-bend between two walls needs. Windows come from the current tube, never from the
reachability tube alone, so they grow until nothing changes. Conflicts are checked on the hull of consecutive samples.

Limit: a push whose span reaches 0 or t_c is not tried. adaptive_search.py turns pushes into circumvent functions.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.design.half_spaces import Array

HOLD_SHARE = 0.06  # of t_c: how much longer a dimension is held with each branch
TIME_WEIGHT = 0.5  # of the pushes' total time over t_c, beside their number
LATE_CONFLICT_WEIGHT = 0.02  # of the time of the conflict over t_c: a later one is nearer to a solution

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True, order=True)
class Push:
    """Hold `dimension` on the upper (`above`) or lower side of unsafe set `unsafe` from `begin` to `end` seconds."""

    dimension: int
    above: bool
    unsafe: int
    begin: float
    end: float


Pushes = tuple[Push, ...]  # sorted


@dataclass(frozen=True, kw_only=True)
class ConflictProblem:
    """What the search needs to know.

    times: of the grid, (N + 1,). unsafe: the sets grown by the clearance, (J, 2, n). edges: the tube of a dimension under pushes,
    (2, N + 1). min_widths: by dimension, (n,). is_possible: whether a push can be made at all. tries_holds: whether to branch on
    holding a dimension back too, which is slower. node_limit: how many nodes to evaluate.
    """

    times: Array
    unsafe: Array
    min_widths: Array
    edges: Callable[[int, Pushes], Array]
    is_possible: Callable[[Push], bool]
    tries_holds: bool
    node_limit: int


class _Conflict(NamedTuple):
    """The earliest conflict of a tube: with unsafe set j at sample k. overlap: (N, n), in which dimensions they overlap."""

    k: int
    j: int
    overlap: Flags


def search_pushes(problem: ConflictProblem) -> Pushes | None:
    """Return the pushes of the first tube without conflict; None where there is none among the nodes that are evaluated."""
    n = problem.unsafe.shape[2] if len(problem.unsafe) else 0
    cache: dict[tuple[int, Pushes], Array] = {}

    def edges(i: int, pushes: Pushes) -> Array:
        key = (i, tuple(p for p in pushes if p.dimension == i))
        if key not in cache:
            cache[key] = problem.edges(*key)
        return cache[key]

    if n == 0:
        return ()
    queue: list[tuple[float, int, Pushes]] = [(0.0, 0, ())]
    queued: set[Pushes] = {()}
    count = 0
    for _ in range(problem.node_limit):
        if not queue:
            return None
        _, _, pushes = heapq.heappop(queue)
        tube = np.stack([edges(i, pushes) for i in range(n)], axis=2)  # (2, N + 1, n)
        if (tube[1] - tube[0] < problem.min_widths).any():
            continue
        conflict = _earliest_conflict(problem, tube)
        if conflict is None:
            return pushes
        for child in _children(problem, pushes, conflict):
            if child not in queued:
                queued.add(child)
                count += 1
                heapq.heappush(queue, (_cost(problem, child, conflict.k), count, child))
    return None


def _earliest_conflict(problem: ConflictProblem, tube: Array) -> _Conflict | None:
    """Return the earliest conflict on the hulls of samples k and k + 1; None where there is none. tube: (2, N + 1, n)."""
    low = np.minimum(tube[0, :-1], tube[0, 1:])[:, None]
    high = np.maximum(tube[1, :-1], tube[1, 1:])[:, None]
    overlaps = np.asarray((high > problem.unsafe[None, :, 0]) & (low < problem.unsafe[None, :, 1]))  # (N, J, n)
    conflicts = np.asarray(np.all(overlaps, axis=2))
    if not conflicts.any():
        return None
    k = int(np.argmax(np.any(conflicts, axis=1)))
    j = int(conflicts[k].argmax())
    return _Conflict(k, j, overlaps[:, j])


def _children(problem: ConflictProblem, pushes: Pushes, conflict: _Conflict) -> list[Pushes]:
    """Return the pushes with one more (or a longer one) against the conflict."""
    k, overlap = conflict.k, conflict.overlap
    children = []
    last = len(overlap) - 1
    for i in range(overlap.shape[1]):
        others_overlap = np.asarray(np.all(np.delete(overlap, i, axis=1), axis=1))
        a = b = k
        while a > 0 and others_overlap[a - 1]:
            a -= 1
        while b < last and others_overlap[b + 1]:
            b += 1
        if problem.tries_holds and a > 0:
            children += _children_with_hold(problem, pushes, conflict, i)
        if a == 0 or b >= last:
            continue  # the ramp would be before 0 or after t_c
        begin, end = float(problem.times[a - 1]), float(problem.times[min(b + 2, last + 1)])
        for above in (False, True):
            merged = [p for p in _same_side(pushes, i, above, conflict.j) if p.begin <= end and begin <= p.end]
            push = Push(i, above, conflict.j, min([begin, *(p.begin for p in merged)]), max([end, *(p.end for p in merged)]))
            if push not in merged and problem.is_possible(push):
                children.append(_replaced(pushes, merged, push))
    return children


def _children_with_hold(problem: ConflictProblem, pushes: Pushes, conflict: _Conflict, i: int) -> list[Pushes]:
    """Return the pushes with dimension i held before U_j a little longer, on the side that it comes from.

    So another dimension has time to move, which an S-bend between two walls needs.
    """
    k, overlap = conflict.k, conflict.overlap[:, i]
    first = k
    while first > 0 and overlap[first - 1]:
        first -= 1
    if first == 0:
        return []
    children = []
    t_c = float(problem.times[-1])
    for above in (False, True):
        merged = _same_side(pushes, i, above, conflict.j)
        begin = min([float(problem.times[first - 1]), *(p.begin for p in merged)])
        end = max([float(problem.times[k]), *(p.end for p in merged)]) + HOLD_SHARE * t_c
        push = Push(i, above, conflict.j, begin, end)
        if end < t_c and problem.is_possible(push):
            children.append(_replaced(pushes, merged, push))
    return children


def _same_side(pushes: Pushes, i: int, above: bool, j: int) -> list[Push]:
    """Return the pushes of dimension i to this side of U_j."""
    return [p for p in pushes if (p.dimension, p.above, p.unsafe) == (i, above, j)]


def _replaced(pushes: Pushes, merged: list[Push], push: Push) -> Pushes:
    """Return the pushes with one in place of those that it merges."""
    return tuple(sorted([*(p for p in pushes if p not in merged), push]))


def _cost(problem: ConflictProblem, pushes: Pushes, k: int) -> float:
    """Return the cost of a node: few and short pushes first; among equals the one whose conflict came later."""
    total_time = 0.0
    for p in pushes:
        total_time += p.end - p.begin
    time_cost = TIME_WEIGHT * total_time / float(problem.times[-1])
    return len(pushes) + time_cost - LATE_CONFLICT_WEIGHT * k / len(problem.times)
