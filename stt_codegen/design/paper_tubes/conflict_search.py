"""Best-first search over conflicts: which circumvent functions make a tube safe.

A node is a set of pushes; its tube is evaluated with the paper's own functions on a time grid. For the earliest conflict
with an unsafe set U_j the search branches over (dimension i, side): i must be strictly on that side of U_j over the span
around the conflict in which all other dimensions overlap U_j; on request also over holding dimension i before U_j a little
longer, which an S-bend between two walls needs. Windows come from the current tube, never from the
reachability tube alone, so they grow until nothing changes. Conflicts are checked on the hull of consecutive samples.

Limit: a push whose span reaches 0 or t_c is not tried.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stt_codegen.design.half_spaces import Array

HOLD = 0.06  # of t_c, how much longer a dimension is held at a time


@dataclass(frozen=True, order=True)
class Push:
    """Hold `dimension` on the upper (`above`) or lower side of unsafe set `unsafe` from `begin` to `end` seconds."""

    dimension: int
    above: bool
    unsafe: int
    begin: float
    end: float


@dataclass(frozen=True, kw_only=True)
class Problem:
    """What the search needs to know: grid times (N + 1), unsafe sets grown by the clearance (J, 2, n), the least width,
    the tube of a dimension under pushes (shape (2, N + 1)), whether a push can be made at all, whether to branch on holding
    a dimension back too (slower), and how many nodes to evaluate."""

    times: Array
    unsafe: Array
    min_width: float
    edges: Callable[[int, tuple[Push, ...]], Array]
    possible: Callable[[Push], bool]
    holds: bool
    nodes: int


def search(problem: Problem) -> tuple[Push, ...] | None:
    """The pushes of the first tube without conflict, or None."""
    n = problem.unsafe.shape[2] if len(problem.unsafe) else 0
    cache: dict[tuple[int, tuple[Push, ...]], Array] = {}

    def edges(i: int, pushes: tuple[Push, ...]) -> Array:
        key = (i, tuple(p for p in pushes if p.dimension == i))
        if key not in cache:
            cache[key] = problem.edges(*key)
        return cache[key]

    if n == 0:
        return ()
    queue: list[tuple[float, int, tuple[Push, ...]]] = [(0.0, 0, ())]
    seen: set[tuple[Push, ...]] = {()}
    count = 0
    for _ in range(problem.nodes):
        if not queue:
            return None
        _, _, pushes = heapq.heappop(queue)
        tube = np.stack([edges(i, pushes) for i in range(n)], axis=2)  # (2, N + 1, n)
        if (tube[1] - tube[0]).min() < problem.min_width:
            continue
        overlap = _overlaps(problem, tube)
        conflict = np.asarray(np.all(overlap, axis=2))
        if not conflict.any():
            return pushes
        k = int(np.argmax(np.any(conflict, axis=1)))
        j = int(conflict[k].argmax())
        for child in _children(problem, pushes, overlap[:, j], k, j):
            if child not in seen:
                seen.add(child)
                count += 1
                heapq.heappush(queue, (_cost(problem, child, k), count, child))
    return None


def _overlaps(problem: Problem, tube: Array) -> npt.NDArray[np.bool_]:
    """Which unsafe sets the hull of samples k and k + 1 overlaps in which dimension: shape (N, J, n)."""
    low = np.minimum(tube[0, :-1], tube[0, 1:])[:, None]
    high = np.maximum(tube[1, :-1], tube[1, 1:])[:, None]
    return np.asarray((high > problem.unsafe[None, :, 0]) & (low < problem.unsafe[None, :, 1]))


def _children(
    problem: Problem, pushes: tuple[Push, ...], overlap: npt.NDArray[np.bool_], k: int, j: int
) -> list[tuple[Push, ...]]:
    """The pushes with one more (or a longer one) against the conflict with U_j at sample k; overlap: (N, n)."""
    found = []
    last = len(overlap) - 1
    for i in range(overlap.shape[1]):
        others = np.asarray(np.all(np.delete(overlap, i, axis=1), axis=1))
        a = b = k
        while a > 0 and others[a - 1]:
            a -= 1
        while b < last and others[b + 1]:
            b += 1
        if problem.holds and a > 0:
            found += _holds(problem, pushes, overlap[:, i], k, i, j)
        if a == 0 or b >= last:
            continue  # the ramp would have to stand before 0 or after t_c
        begin, end = float(problem.times[a - 1]), float(problem.times[min(b + 2, last + 1)])
        for above in (False, True):
            near = [p for p in pushes if (p.dimension, p.above, p.unsafe) == (i, above, j) and p.begin <= end and begin <= p.end]
            push = Push(i, above, j, min([begin, *(p.begin for p in near)]), max([end, *(p.end for p in near)]))
            if push not in near and problem.possible(push):
                found.append(tuple(sorted([*(p for p in pushes if p not in near), push])))
    return found


def _holds(
    problem: Problem, pushes: tuple[Push, ...], overlap: npt.NDArray[np.bool_], k: int, i: int, j: int
) -> list[tuple[Push, ...]]:
    """Dimension i held before U_j a little longer, on the side it comes from, so that another has time to move: what an
    S-bend between two walls needs. overlap: (N,), of dimension i alone."""
    first = k
    while first > 0 and overlap[first - 1]:
        first -= 1
    if first == 0:
        return []
    result = []
    t_c = float(problem.times[-1])
    for above in (False, True):
        near = [p for p in pushes if (p.dimension, p.above, p.unsafe) == (i, above, j)]
        begin = min([float(problem.times[first - 1]), *(p.begin for p in near)])
        end = max([float(problem.times[k]), *(p.end for p in near)]) + HOLD * t_c
        push = Push(i, above, j, begin, end)
        if end < t_c and problem.possible(push):
            result.append(tuple(sorted([*(p for p in pushes if p not in near), push])))
    return result


def _cost(problem: Problem, pushes: tuple[Push, ...], k: int) -> float:
    """Few and short pushes first; among equals the one whose conflict came later."""
    n = len(problem.times)
    held = 0.0
    for p in pushes:
        held += p.end - p.begin
    return len(pushes) + 0.5 * held / float(problem.times[-1]) - 0.02 * k / n
