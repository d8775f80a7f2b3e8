"""The spline tube of a given width by linear programs: as slow as its bounds allow, one program for every dimension.

The search for a width (widest.py, moving_search.py, mission_search.py) asks for the slowest tube within the bounds of a choice of
sides. Many tubes are as slow as the slowest: a dimension that has time left can use it in any way. Of them the smoothest is
taken: the smallest sum of |second differences| of control points, by one more program for every dimension, at the pace that it
needs anyway. dimension_programs.py has the programs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import SolverCache
from stt_codegen.design.moving_half_spaces import TimedObstacle
from stt_codegen.design.routes import SegmentBounds, bounds_around_tube
from stt_codegen.design.spline_tubes.dimension_programs import TubeProblem, solve_group

SIDE_ROUNDS = 4  # rounds in which sides are chosen again
PACE_GAIN = 1.005  # a round must improve by this factor to be followed by another
CLOSE_TO_BOUND = 1.03  # a tube this many times as fast as a lower bound is not improved further


@dataclass(frozen=True, kw_only=True)
class SplineTube:
    """A tube of uniform cubic B-splines.

    points: control points, shape (2, n, K + 3) [edge, dimension, point]. paces: by dimension (n,) the most that an edge moves in
    one segment's time, or for order 2 the most that two such moves differ. bounds, width: what the tube was designed within.
    mission_obstacles: what a mission asks of it there, beside the arena's obstacles. seam: the first segment of the part that
    repeats, None where none does. centre_route: the route of its centre.
    """

    points: Array
    paces: Array
    bounds: SegmentBounds
    width: Array
    order: int = 1
    mission_obstacles: tuple[TimedObstacle, ...] = ()
    seam: int | None = None
    centre_route: Array | None = None

    @property
    def pace(self) -> float:
        """The largest pace of all dimensions."""
        return float(self.paces.max())

    @property
    def segments(self) -> int:
        return int(self.points.shape[2]) - 3

    @property
    def speed(self) -> float:
        """The peak speed of an edge, with t_c as the unit of time; for order 2 a quarter of the peak acceleration."""
        return self.pace * (self.segments if self.order == 1 else self.segments * self.segments / 4)

    def bezier(self) -> Array:
        """Return the Bezier coefficients of every segment: shape (2, n, K, 4)."""
        c = self.points
        return np.stack(
            [
                (c[..., :-3] + 4 * c[..., 1:-2] + c[..., 2:-1]) / 6,
                (2 * c[..., 1:-2] + c[..., 2:-1]) / 3,
                (c[..., 1:-2] + 2 * c[..., 2:-1]) / 3,
                (c[..., 1:-2] + 4 * c[..., 2:-1] + c[..., 3:]) / 6,
            ],
            axis=-1,
        )


def slowest_tube(
    arena: Arena, start: Array, bounds: SegmentBounds, width: Array, *, route_length: float, solver_cache: SolverCache
) -> SplineTube | None:
    """Return the slowest tube of this width (n,); None when there is none.

    Sides are chosen again while that makes it slower. route_length: the length of its route, a lower bound on the speed.
    """
    best = _slowest_within(arena, start, bounds, width, solver_cache)
    if best is None:
        return None
    for _ in range(SIDE_ROUNDS):
        if best.speed <= CLOSE_TO_BOUND * route_length:
            break
        other_bounds = bounds_around_tube(arena, best.bezier())
        if other_bounds.equals(best.bounds):
            break
        trial = _slowest_within(arena, start, other_bounds, width, solver_cache)
        if trial is None or trial.pace * PACE_GAIN > best.pace:
            break
        best = trial
    return best


def _slowest_within(
    arena: Arena, start: Array, bounds: SegmentBounds, width: Array, solver_cache: SolverCache
) -> SplineTube | None:
    """Return the slowest tube within these bounds, None where a group of dimensions has none.

    Dimensions that a coupling joins are solved together; most are solved alone."""
    problem = TubeProblem(arena, start, bounds, width)
    points: Array = np.empty((2, arena.dimension, len(bounds.edges) + 3))
    paces: Array = np.empty(arena.dimension)
    for members in problem.groups:
        solution = solve_group(problem, members, solver_cache)
        if solution is None:
            return None
        points[:, members], paces[members] = solution
    return SplineTube(points=points, paces=paces, bounds=bounds, width=width, order=arena.order, seam=arena.seam)


def smoothest_tube(arena: Arena, start: Array, tube: SplineTube) -> SplineTube:
    """Return the tube of the same width within the same bounds that bends least, with no dimension faster than it is."""
    points = tube.points.copy()
    arena = replace(arena, timed_obstacles=(*arena.timed_obstacles, *tube.mission_obstacles), seam=tube.seam)
    problem = TubeProblem(arena, start, tube.bounds, tube.width)
    for members in problem.groups:
        solution = solve_group(problem, members, None, float(tube.paces[members[0]]))
        if solution is not None:
            points[:, members] = solution[0]
    return replace(tube, points=points)
