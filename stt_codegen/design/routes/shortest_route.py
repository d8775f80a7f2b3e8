"""The shortest route of the tube's centre among unsafe sets grown by half a tube, or the reason why there is none.

Corners are tried first (`corner_search.py`). They may miss a window between sets that has no corner of its own: then the cells
between the edges are flooded (`cell_path.py`), and in more than three dimensions leg by leg, three dimensions at a time.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array, HalfSpaces
from stt_codegen.design.routes.cell_path import GRID_DIVISIONS, find_cell_path, find_grid_path, has_few_cells
from stt_codegen.design.routes.corner_search import (
    CentreProblem,
    Route,
    centre_problem_of,
    route_through,
    search_corners,
    search_finds_every_route,
)
from stt_codegen.errors import NotCertified, Reason
from stt_codegen.properties import Property

LEG_DIMENSIONS = 3  # dimensions that move together in a leg of a route in many dimensions
NAMED_SET_LIMIT = 40  # unsafe sets of an arena; with more, a refusal names no set that closes the route by itself


def shortest_route(arena: Arena, start: Array, width: Array) -> Route:
    """Return the route from the centre of the box `start` (shape (2, n)) to the target for a tube of that width, (n,).

    Raises `NotCertified` when there is none, with the largest clearance (or width) for which there is one.
    """
    centre = (start[0] + start[1]) / 2
    route = _first_route(arena, centre, arena.clearance + width / 2, width / 2)
    if route is None:
        raise NotCertified(lambda: _explain_blocked_route(arena, centre))
    return route


def find_corner_route(arena: Arena, start: Array, width: Array, length_limit: float = np.inf) -> Route | None:
    """Return a route as `shortest_route` does, from the search among corners alone.

    None where that search finds no route of a length up to `length_limit`; there may still be one.
    """
    problem = centre_problem_of(arena, (start[0] + start[1]) / 2, arena.clearance + width / 2, width / 2)
    return None if problem is None else search_corners(problem, length_limit=length_limit)


def find_route(arena: Arena, start: Array, width: Array, length_limit: float = np.inf) -> Route | None:
    """Return a route of a length up to `length_limit`, from the search among corners, else from the flood of cells.

    None where neither finds one; there may still be one.
    """
    problem = centre_problem_of(arena, (start[0] + start[1]) / 2, arena.clearance + width / 2, width / 2)
    if problem is None:
        return None
    route = search_corners(problem, length_limit=length_limit)
    if route is None:
        route = _find_cell_route(problem)
    return route if route is not None and route.length <= length_limit else None


def _first_route(arena: Arena, centre: Array, growth: Array, half_width: Array) -> Route | None:
    """Return the route of the first search that finds one; None where no search does.

    growth (n,): by how much the unsafe sets are grown, clearance and half width. half_width (n,): by how much the space is
    shrunk.
    """
    problem = centre_problem_of(arena, centre, growth, half_width)
    if problem is None:
        return None
    searches: tuple[Callable[[CentreProblem], Route | None], ...] = (
        search_corners,
        _find_cell_route,
        _find_grid_route,
        _find_leg_route,
    )
    return next((route for search in searches if (route := search(problem)) is not None), None)


def _find_cell_route(problem: CentreProblem) -> Route | None:
    """Return a route through the cells that the faces of the grown sets' bounding boxes cut, shortened by lines of sight.

    Every set counts as its bounding box. None where the flood finds no path. The flood is not tried, with the result None, in
    three cases: half-spaces cut the state space, the search among corners finds every route, or there are too many cells.
    """
    arena = problem.arena
    if (
        len(arena.space_cuts.lower_bound)
        or search_finds_every_route(arena)
        or not has_few_cells(len(arena.names), arena.dimension)
    ):
        return None
    return _shortened(problem, find_cell_path(*problem.obstacles.spans, problem.space, problem.goal, problem.centre))


def _find_grid_route(problem: CentreProblem) -> Route | None:
    """Return a route through the cells of a fine grid; None where all sets are boxes, or where no path is found."""
    arena = problem.arena
    if arena.has_only_boxes or arena.dimension not in GRID_DIVISIONS:
        return None
    cuts = HalfSpaces(arena.space_cuts.normal, arena.space_cuts.lower_bound + arena.space_cuts.box_support(problem.half_width))
    return _shortened(problem, find_grid_path(problem.obstacles, problem.space, problem.goal, problem.centre, cuts))


def _find_leg_route(problem: CentreProblem) -> Route | None:
    """Return a route in legs, where there are too many dimensions for one flood; None where no route is found.

    In each leg at most LEG_DIMENSIONS dimensions move all the way to the target, and the others stand still. The flood of a leg
    therefore runs in these dimensions only. Every choice of the dimensions of the first leg is tried.
    """
    arena, n = problem.arena, problem.arena.dimension
    set_count = len(arena.names)
    if len(arena.space_cuts.lower_bound) or has_few_cells(set_count, n) or not has_few_cells(set_count, LEG_DIMENSIONS):
        return None
    for first_leg in itertools.combinations(range(n), LEG_DIMENSIONS):
        rest = [i for i in range(n) if i not in first_leg]
        legs = [list(first_leg), *(rest[k : k + LEG_DIMENSIONS] for k in range(0, len(rest), LEG_DIMENSIONS))]
        points = _points_of_legs(problem, legs)
        if points is not None:
            return _shortened(problem, points)
    return None


def _points_of_legs(problem: CentreProblem, legs: list[list[int]]) -> Array | None:
    """Return the polyline in which the dimensions of one leg after the other move; None where a leg is blocked."""
    (lower, upper), space, goal = problem.obstacles.spans, problem.space, problem.goal
    points: list[Array] = [problem.centre]
    for leg in legs:
        position = points[-1]
        resting = [i for i in range(len(position)) if i not in leg]
        is_in_the_way = np.all((position[resting] > lower[:, resting]) & (position[resting] < upper[:, resting]), axis=1)
        path = find_cell_path(
            lower[is_in_the_way][:, leg], upper[is_in_the_way][:, leg], space[:, leg], goal[:, leg], position[leg]
        )
        if path is None:
            return None
        for step in path[1:]:
            point = points[-1].copy()
            point[leg] = step
            points.append(point)
    return np.array(points)


def _shortened(problem: CentreProblem, points: Array | None) -> Route | None:
    """Return the polyline as a route, without the points that a straight line past the sets can skip."""
    if points is None:
        return None
    kept = [0]
    while kept[-1] < len(points) - 1:
        last = kept[-1]
        visible = np.nonzero(problem.obstacles.visible_from(points[last], points[last + 1 :]))[0]
        kept.append(last + 1 + (int(visible[-1]) if len(visible) else 0))
    return route_through(problem, points[kept])


def _explain_blocked_route(arena: Arena, centre: Array) -> Reason:
    """Return why no route is found: which set closes every route by itself, or that the tube is too wide for all of them."""

    def has_route(clearance: float, width: float, without: int | None = None) -> bool:
        """Return whether a search finds a route for this clearance and width, without the set of this index."""
        half_width = np.full(arena.dimension, width / 2)
        kept_sets = [j for j in range(len(arena.names)) if j != without]
        return _first_route(arena.with_sets(kept_sets), centre, clearance + half_width, half_width) is not None

    smallest_clearance, smallest_width = arena.allowance, 2 * arena.allowance  # the task's 0, with the allowance for rounding
    is_final = search_finds_every_route(arena) or (arena.has_only_boxes and has_few_cells(len(arena.names), arena.dimension))
    verb = "leads" if is_final else "was found"
    problem = f"{Property.AVOID.label}: no way {verb} from the initial set to the target set between the unsafe sets"
    if not arena.clearance_excess.any() and not has_route(smallest_clearance, smallest_width):
        has_few_sets = len(arena.names) <= NAMED_SET_LIMIT
        blocking = [n for j, n in enumerate(arena.names) if has_few_sets and has_route(smallest_clearance, smallest_width, j)]
        remove = f"without {' or '.join(blocking)} there would be one" if blocking else "remove or shrink an unsafe set"
        whatever = f"{problem}, whatever the clearance; {remove}, or enlarge the state space"
        return Reason(whatever, codes=(Property.AVOID.code,), has_remedy=False)
    widths = [f"{v:.6g}" for v in (arena.min_widths - 2 * arena.allowance) * arena.length_unit]
    clearances = [f"{v:.6g}" for v in (arena.clearance - arena.allowance + arena.clearance_excess) * arena.length_unit]
    width, clearance = (v[0] if len(set(v)) == 1 else f"[{', '.join(v)}]" for v in (widths, clearances))
    wanted_tube = f"for a tube of width {width} with a clearance of {clearance}"
    return Reason(f"{problem} {wanted_tube}", Property.AVOID.advice, codes=(Property.AVOID.code,))
