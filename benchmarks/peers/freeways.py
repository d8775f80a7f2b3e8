"""Planners over free boxes as peers: Drake's GcsTrajectoryOptimization, and fastpathplanning. Both solve with Clarabel, one
thread.

The room without the unsafe squares, grown by MARGIN, is cut into boxes, each planner's own way of cutting being the one that it
is quickest with. A curve is a chain of Bezier pieces; it is held to be safe when the hull of every piece's control points
is, which is looked at in exact arithmetic, for all times and not at samples.
"""

from __future__ import annotations

import contextlib
import io
import logging
from itertools import combinations, pairwise
from typing import Any

import numpy as np

from benchmarks.peers.optional import need
from benchmarks.suites.families import BOX, Array, Family

MARGIN = 0.02  # by which squares grow, as for OMPL
WALL = 1e-3  # by which the room shrinks: a solver leaves a box by some 1e-9
ORDER = 5  # of Drake's pieces; with 4 a cell 2 cm thin has no solution that is twice differentiable
ROUNDED = 5  # paths that Drake rounds to

Boxes = tuple[Array, Array]  # lower and upper corners, (B, 2)


def cells(family: Family, squares: Array) -> Boxes:
    """The free intervals of the second axis between neighbouring edges of the first, joined where they are the same: they share
    sides."""
    edges, gaps = _slabs(family, squares)
    found: list[tuple[float, ...]] = []
    begun: dict[tuple[float, float], float] = {}
    for k in range(len(edges) - 1):
        here = {gap: begun.get(gap, edges[k]) for gap in gaps(k, k + 1)}
        found += [(since, gap[0], edges[k], gap[1]) for gap, since in begun.items() if gap not in here]
        begun = here
    found += [(since, gap[0], edges[-1], gap[1]) for gap, since in begun.items()]
    table = np.array(found)
    return table[:, :2], table[:, 2:]


def largest(family: Family, squares: Array) -> Boxes:
    """Every free box that cannot grow: they overlap."""
    edges, gaps = _slabs(family, squares)
    spans = {(i, j, gap) for i, j in combinations(range(len(edges)), 2) for gap in gaps(i, j)}
    kept = sorted((i, j, g) for i, j, g in spans if not {(i - 1, j, g), (i, j + 1, g)} & spans)
    table = np.array([(edges[i], g[0], edges[j], g[1]) for i, j, g in kept])
    return table[:, :2], table[:, 2:]


def _slabs(family: Family, squares: Array) -> tuple[list[float], Any]:
    """The edges of the first axis, and a function: the free intervals of the second between two of them, by their numbers."""
    low, high = squares[:, :, 0] - MARGIN, squares[:, :, 1] + MARGIN
    ends = (WALL, family.side - WALL)
    inner = np.unique(np.concatenate([low[:, 0], high[:, 0]]))
    edges = [ends[0], *inner[(inner > ends[0]) & (inner < ends[1])].tolist(), ends[1]]

    def gaps(i: int, j: int) -> list[tuple[float, float]]:
        between, y = [], ends[0]
        hit = (low[:, 0] < edges[j]) & (edges[i] < high[:, 0])
        for a, b in sorted(zip(low[hit, 1].tolist(), high[hit, 1].tolist(), strict=True)):
            if a > y:
                between.append((y, min(a, ends[1])))
            y = max(y, b)
        return [*between, (y, ends[1])] if y < ends[1] else between

    return edges, gaps


def neighbours(boxes: Boxes) -> list[tuple[int, int]]:
    """Pairs of boxes that meet in more than a corner, both ways round."""
    low, high = boxes
    shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    first, second = np.nonzero(np.all(shared >= 0, axis=2) & np.any(shared > 0, axis=2))
    return [(i, j) for i, j in zip(first.tolist(), second.tolist(), strict=True) if i != j]


def within(boxes: Boxes, point: Array) -> list[int]:
    """The boxes that a point is in."""
    low, high = boxes
    found: list[int] = np.nonzero(np.all((low <= point) & (point <= high), axis=1))[0].tolist()
    return found


def drake(family: Family, squares: Array) -> list[Array] | None:
    """Drake: the shortest control polygon through the graph of boxes, by its convex relaxation and rounding; pieces (ORDER +
    1, 2).

    No time can be prescribed over all regions, for every one has a duration of its own. So all are traversed in the same
    time, which makes "twice differentiable in the parameter" the same in time, and 9 s are what they add up to.
    """
    planning, solvers = need("pydrake.planning"), need("pydrake.solvers")
    geometry, common = need("pydrake.geometry.optimization"), need("pydrake.common")
    logging.getLogger("drake").setLevel(logging.WARNING)  # its import sets more
    boxes = cells(family, squares)
    problem = planning.GcsTrajectoryOptimization(2)
    regions = [geometry.HPolyhedron.MakeBox(a, b) for a, b in zip(*boxes, strict=True)]
    graph = problem.AddRegions(regions, neighbours(boxes), ORDER, 1.0, 1.0, "free")
    points = [np.full(2, BOX / 2), np.full(2, family.side - BOX / 2)]
    start, goal = (
        problem.AddRegions([geometry.Point(p)], [], 0, 0.0, 0.0, name) for p, name in zip(points, ("start", "goal"), strict=True)
    )
    problem.AddEdges(start, graph, None, [(0, k) for k in within(boxes, points[0])])
    problem.AddEdges(graph, goal, None, [(k, 0) for k in within(boxes, points[1])])
    problem.AddPathLengthCost()
    for order in (1, 2):
        problem.AddPathContinuityConstraints(order)
    options = geometry.GraphOfConvexSetsOptions()
    options.solver, options.convex_relaxation, options.preprocessing = solvers.ClarabelSolver(), True, True
    options.max_rounded_paths, options.parallelism = ROUNDED, common.Parallelism(1)
    curve, result = problem.SolvePath(start, goal, options)
    if not result.is_success():
        return None
    pieces = [curve.segment(k).control_points().T for k in range(curve.get_number_of_segments())]
    return [p for p in pieces if len(p) > 1]  # start and goal are points


def fast_path(family: Family, squares: Array) -> list[Array] | None:
    """fastpathplanning: the shortest polygon through the boxes, then the least squared acceleration over 9 s through those
    that it passes, at rest at both ends; pieces (6, 2)."""
    package = need("fastpathplanning")
    boxes = largest(family, squares)
    ends = [np.full(2, BOX / 2), np.full(2, family.side - BOX / 2)]
    if not _joined(boxes, *ends):  # the package raises other errors there, instead of saying so
        return None
    rest = {1: np.zeros(2)}
    with contextlib.redirect_stdout(io.StringIO()):  # it prints
        safe = package.SafeSet(*boxes, verbose=False)
        curve = package.plan(safe, *ends, family.prescribed_time, [0.0, 1.0], rest, rest, verbose=False)
    return [np.asarray(piece.points) for piece in curve.beziers]


def _joined(boxes: Boxes, start: Array, goal: Array) -> bool:
    pairs, seen = neighbours(boxes), set(within(boxes, start))
    while new := {b for a, b in pairs if a in seen} - seen:
        seen |= new
    return bool(seen & set(within(boxes, goal)))


def curve_is_safe(family: Family, squares: Array, pieces: list[Array]) -> bool:
    """Whether every piece's control points, with the next piece's first, have a bounding box that meets no open square and
    is in the room, from the start's box to the target's. Floats are only compared, so it is exact."""
    joints = [np.vstack([p, q[:1]]) for p, q in pairwise(pieces)] + [pieces[-1]]
    for points in joints:
        low, high = points.min(axis=0), points.max(axis=0)
        if low.min() < 0 or high.max() > family.side or any(np.all((low < s[:, 1]) & (s[:, 0] < high)) for s in squares):
            return False
    return bool(pieces[0][0].max() <= BOX and pieces[-1][-1].min() >= family.side - BOX)
