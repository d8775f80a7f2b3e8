"""Planners over free boxes as peers: Drake's GcsTrajectoryOptimization, and fastpathplanning. Both solve with Clarabel, one
thread.

The state space without the unsafe squares, grown by MARGIN, is cut into boxes; each planner gets the cut with which it is
quickest. A curve is a chain of Bezier pieces. It counts as safe when the hull of every piece's control points is, which is
compared exactly, so for all times and not at samples. `in_arenas` runs both planners.
"""

from __future__ import annotations

import contextlib
import io
import logging
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from benchmarks.peers.optional import need
from benchmarks.suites.families import BOX, Array, Family

MARGIN = 0.02  # by which squares grow, as for OMPL
WALL_MARGIN = 1e-3  # by which the state space shrinks: a solver leaves a box by some 1e-9
ORDER = 5  # of Drake's pieces; with 4 a cell 2 cm thin has no solution that is twice differentiable
ROUNDED_PATHS = 5  # that Drake's rounding compares

Boxes = tuple[Array, Array]  # lower and upper corners, (B, 2)


def disjoint_free_boxes(family: Family, squares: Array) -> Boxes:
    """Cut the free space into boxes that share sides: free intervals of the second axis between neighbouring edges of the first,
    joined along the first axis where they are the same."""
    slabs = _Slabs.of(family, squares)
    boxes: list[tuple[float, ...]] = []
    open_boxes: dict[tuple[float, float], float] = {}  # by interval of the second axis: where it begins on the first
    for k in range(len(slabs.edges) - 1):
        continued = {gap: open_boxes.get(gap, slabs.edges[k]) for gap in slabs.free_intervals(k, k + 1)}
        boxes += [(begin, gap[0], slabs.edges[k], gap[1]) for gap, begin in open_boxes.items() if gap not in continued]
        open_boxes = continued
    boxes += [(begin, gap[0], slabs.edges[-1], gap[1]) for gap, begin in open_boxes.items()]
    corners = np.array(boxes)
    return corners[:, :2], corners[:, 2:]


def maximal_free_boxes(family: Family, squares: Array) -> Boxes:
    """Return every free box that cannot grow: they overlap."""
    slabs = _Slabs.of(family, squares)
    pairs = combinations(range(len(slabs.edges)), 2)
    spans = {(i, j, gap) for i, j in pairs for gap in slabs.free_intervals(i, j)}
    maximal = sorted((i, j, gap) for i, j, gap in spans if not {(i - 1, j, gap), (i, j + 1, gap)} & spans)
    corners = np.array([(slabs.edges[i], gap[0], slabs.edges[j], gap[1]) for i, j, gap in maximal])
    return corners[:, :2], corners[:, 2:]


@dataclass(frozen=True)
class _Slabs:
    """The edges of the grown squares and the walls on the first axis, in order, and what is between two of them on the second.

    low, high: corners of the grown squares, (count, 2); walls: of the second axis."""

    edges: list[float]
    low: Array
    high: Array
    walls: tuple[float, float]

    @classmethod
    def of(cls, family: Family, squares: Array) -> _Slabs:
        low, high = squares[:, :, 0] - MARGIN, squares[:, :, 1] + MARGIN
        walls = (WALL_MARGIN, family.side - WALL_MARGIN)
        sides = np.unique(np.concatenate([low[:, 0], high[:, 0]]))
        edges = [walls[0], *sides[(sides > walls[0]) & (sides < walls[1])].tolist(), walls[1]]
        return cls(edges, low, high, walls)

    def free_intervals(self, i: int, j: int) -> list[tuple[float, float]]:
        """Return the intervals of the second axis that are free all the way from edge i to edge j of the first."""
        intervals, y = [], self.walls[0]
        is_between = (self.low[:, 0] < self.edges[j]) & (self.edges[i] < self.high[:, 0])
        for a, b in sorted(zip(self.low[is_between, 1].tolist(), self.high[is_between, 1].tolist(), strict=True)):
            if a > y:
                intervals.append((y, min(a, self.walls[1])))
            y = max(y, b)
        return [*intervals, (y, self.walls[1])] if y < self.walls[1] else intervals


def neighbours(boxes: Boxes) -> list[tuple[int, int]]:
    """Return the pairs of boxes that meet in more than a corner, in both orders."""
    low, high = boxes
    shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    first, second = np.nonzero(np.all(shared >= 0, axis=2) & np.any(shared > 0, axis=2))
    return [(i, j) for i, j in zip(first.tolist(), second.tolist(), strict=True) if i != j]


def boxes_with(boxes: Boxes, point: Array) -> list[int]:
    """Return the numbers of the boxes that a point is in."""
    low, high = boxes
    numbers: list[int] = np.nonzero(np.all((low <= point) & (point <= high), axis=1))[0].tolist()
    return numbers


def drake(family: Family, squares: Array) -> list[Array] | None:
    """Plan with Drake: the shortest control polygon through the graph of boxes, by convex relaxation and rounding. Returns Bezier
    pieces (ORDER + 1, 2), or None without a curve.

    Drake gives every region its duration, so no time can be prescribed over all of them. Here all regions take the same time, so
    that a curve twice differentiable in the parameter is so in time, and the durations add up to 9 s.
    """
    planning, solvers = need("pydrake.planning"), need("pydrake.solvers")
    geometry, common = need("pydrake.geometry.optimization"), need("pydrake.common")
    logging.getLogger("drake").setLevel(logging.WARNING)  # importing it sets a more talkative level
    boxes = disjoint_free_boxes(family, squares)
    problem = planning.GcsTrajectoryOptimization(2)
    regions = [geometry.HPolyhedron.MakeBox(a, b) for a, b in zip(*boxes, strict=True)]
    graph = problem.AddRegions(regions, neighbours(boxes), ORDER, 1.0, 1.0, "free")
    points = [np.full(2, BOX / 2), np.full(2, family.side - BOX / 2)]
    start, goal = (
        problem.AddRegions([geometry.Point(p)], [], 0, 0.0, 0.0, name) for p, name in zip(points, ("start", "goal"), strict=True)
    )
    problem.AddEdges(start, graph, None, [(0, k) for k in boxes_with(boxes, points[0])])
    problem.AddEdges(graph, goal, None, [(k, 0) for k in boxes_with(boxes, points[1])])
    problem.AddPathLengthCost()
    for order in (1, 2):
        problem.AddPathContinuityConstraints(order)
    options = geometry.GraphOfConvexSetsOptions()
    options.solver, options.convex_relaxation, options.preprocessing = solvers.ClarabelSolver(), True, True
    options.max_rounded_paths, options.parallelism = ROUNDED_PATHS, common.Parallelism(1)
    curve, result = problem.SolvePath(start, goal, options)
    if not result.is_success():
        return None
    pieces = [curve.segment(k).control_points().T for k in range(curve.get_number_of_segments())]
    return [p for p in pieces if len(p) > 1]  # start and goal are points


def fast_path(family: Family, squares: Array) -> list[Array] | None:
    """Plan with fastpathplanning: the shortest polygon through the boxes, then the curve of smallest squared acceleration over 9
    s through the boxes of that polygon, at rest at both ends. Returns Bezier pieces (6, 2), or None without a curve."""
    package = need("fastpathplanning")
    boxes = maximal_free_boxes(family, squares)
    ends = [np.full(2, BOX / 2), np.full(2, family.side - BOX / 2)]
    if not _are_connected(boxes, *ends):  # the package raises unrelated errors there
        return None
    rest = {1: np.zeros(2)}
    with contextlib.redirect_stdout(io.StringIO()):  # it prints
        safe = package.SafeSet(*boxes, verbose=False)
        curve = package.plan(safe, *ends, family.prescribed_time, [0.0, 1.0], rest, rest, verbose=False)
    return [np.asarray(piece.points) for piece in curve.beziers]


def _are_connected(boxes: Boxes, start: Array, goal: Array) -> bool:
    """Whether neighbouring boxes lead from the start to the goal."""
    pairs, reached = neighbours(boxes), set(boxes_with(boxes, start))
    while new := {b for a, b in pairs if a in reached} - reached:
        reached |= new
    return bool(reached & set(boxes_with(boxes, goal)))


def curve_is_safe(family: Family, squares: Array, pieces: list[Array]) -> bool:
    """Whether the curve leads from the start's box to the target's, and the bounding box of every piece's control points, with
    the next piece's first, is in the state space and meets no open square. Floats are only compared, so the answer is exact."""
    hulls = [np.vstack([p, q[:1]]) for p, q in pairwise(pieces)] + [pieces[-1]]
    for points in hulls:
        low, high = points.min(axis=0), points.max(axis=0)
        if low.min() < 0 or high.max() > family.side or any(np.all((low < s[:, 1]) & (s[:, 0] < high)) for s in squares):
            return False
    return bool(pieces[0][0].max() <= BOX and pieces[-1][-1].min() >= family.side - BOX)
