"""The shortest route of the tube's centre, in the largest-component metric, among unsafe sets grown by half a tube. Where some
dimensions may be faster than others a component counts for the time that it takes (`Arena.distance`).

Nodes are the corners of the grown sets (a shortest path in any norm bends only there in the plane); edges are the
straight lines that meet no grown set's interior. Searched by A*, edges found when a node is first expanded.
In three and more dimensions the corners give a good route rather than the shortest; the linear programs improve it. They may
miss a window between sets that has no corner of its own: then the cells between the edges are flooded (`cell_path.py`), in more
than three dimensions leg by leg, three dimensions at a time.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from stt_codegen.decimals import below
from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import inner_box
from stt_codegen.design.routes.cell_path import FINE, decides, way_through_cells, way_through_grid
from stt_codegen.design.routes.grown_sets import Obstacles, obstacles_of
from stt_codegen.errors import NotCertified
from stt_codegen.properties import Property

STRAIGHT = 1e-4  # weight of the sum of components: breaks the many ties of the largest-component metric
HALVINGS = 30  # to find the largest clearance or width with a way
LEG = 3  # dimensions that move together in a leg of a route in many dimensions
NAMED = 40  # up to so many unsafe sets, those are named that alone close the way
NEAR = 128  # nodes looked at from one, before all are
CORNERS = 6  # above 2**6 corners a set, only the corners nearest to start and target are used


@dataclass(frozen=True)
class Route:
    """A polyline of shape (m + 1, n) from the centre of the start to a point of the target; its length in the
    largest-component metric; the reach (clearance + half width, (n,)) by which it keeps off the unsafe sets."""

    points: Array
    length: float
    reach: Array


def shortest_route(arena: Arena, start: Array, width: Array) -> Route:
    """The route from the centre of the box `start` (shape (2, n)) to the target for a tube of that width, by dimension.

    Raises `NotCertified` when there is none, with the largest clearance (or width) for which there is one.
    """
    centre = (start[0] + start[1]) / 2
    route = find_route(arena, start, width)
    for find in (_cell_route, _grid_route, _leg_route):
        if route is None:
            route = find(arena, centre, arena.clearance + width / 2, width / 2)
    if route is None:
        raise NotCertified(_why_blocked(arena, centre))
    return route


def _cell_route(arena: Arena, centre: Array, reach: Array, inset: Array) -> Route | None:
    """A route through the cells between the grown sets' edges, shortened where the line of sight is free; None where the
    corners have already found every way, or where there are too many cells."""
    found = _grown(arena, reach, inset)
    if found is None or len(arena.walls.bound) or _corners_decide(arena) or not decides(len(arena.names), arena.dimension):
        return None
    obstacles, space, goal = found
    return _shortened(arena, way_through_cells(*obstacles.spans, space, goal, centre), obstacles, reach)


def _grid_route(arena: Arena, centre: Array, reach: Array, inset: Array) -> Route | None:
    """A route through fine cells, where some unsafe sets are no boxes and corners have found no way."""
    found = None if arena.boxes_only or arena.dimension not in FINE else _grown(arena, reach, inset)
    if found is None:
        return None
    obstacles, space, goal = found
    within = (arena.walls.normal, arena.walls.bound + arena.walls.box_support(inset))
    return _shortened(arena, way_through_grid(obstacles, space, goal, centre, within), obstacles, reach)


def _leg_route(arena: Arena, centre: Array, reach: Array, inset: Array) -> Route | None:
    """A route in legs, where there are too many dimensions for one flood: in each leg some LEG dimensions go all the way to the
    target and the others stand still, so that the cells of a slice decide. Every choice of the first leg is tried."""
    n = arena.dimension
    found = _grown(arena, reach, inset)
    if found is None or len(arena.walls.bound) or decides(len(arena.names), n) or not decides(len(arena.names), LEG):
        return None
    obstacles, space, goal = found
    lower, upper = obstacles.spans
    for first in itertools.combinations(range(n), LEG):
        rest = [i for i in range(n) if i not in first]
        legs = [list(first), *(rest[k : k + LEG] for k in range(0, len(rest), LEG))]
        points: list[Array] = [centre]
        for leg in legs:
            here = points[-1]
            still = [i for i in range(n) if i not in leg]
            meets = np.all((here[still] > lower[:, still]) & (here[still] < upper[:, still]), axis=1)
            slice_ = (lower[meets][:, leg], upper[meets][:, leg], space[:, leg], goal[:, leg], here[leg])
            way = way_through_cells(*slice_)
            if way is None:
                break
            for step in way[1:]:
                there = points[-1].copy()
                there[leg] = step
                points.append(there)
        else:
            return _shortened(arena, np.array(points), obstacles, reach)
    return None


def _shortened(arena: Arena, points: Array | None, obstacles: Obstacles, reach: Array) -> Route | None:
    """The polyline without the points that the line of sight makes needless, as a route."""
    if points is None:
        return None
    kept = [0]
    while kept[-1] < len(points) - 1:
        here = kept[-1]
        seen = np.nonzero(obstacles.visible(points[here], points[here + 1 :]))[0]
        kept.append(here + 1 + (int(seen[-1]) if len(seen) else 0))
    polyline = points[kept]
    return Route(polyline, float(np.cumsum(arena.distance(polyline[1:] - polyline[:-1]))[-1]), reach)


def _grown(arena: Arena, reach: Array, inset: Array) -> tuple[Obstacles, Array, Array] | None:
    """For the tube's centre: unsafe sets grown by `reach`, and state space and target shrunk by `inset` (shape (2, n)); of a
    target that is cut a box in it, None where there is none."""
    space, goal = (np.stack([box[0] + inset, box[1] - inset]) for box in (arena.space, arena.target))
    if len(arena.goals.bound) or len(arena.walls.bound):
        inner = inner_box(arena, goal, inset)
        if inner is None:
            return None
        goal = inner
    return obstacles_of(arena, reach), space, goal


def _corners_decide(arena: Arena) -> bool:
    """Whether a search among corners finds every way: in the plane, when it looks at all of them."""
    corners = sum(4 if b is None else b.shape[1] for b in arena.oblique_faces.bends)
    return arena.dimension == 2 and corners + 6 <= NEAR and arena.oblique_faces.is_complete


def find_route(arena: Arena, start: Array, width: Array, longest: float = np.inf) -> Route | None:
    """As `shortest_route`, None when there is none up to `longest`, or none is found among near nodes where there are many."""
    return _search(arena, (start[0] + start[1]) / 2, arena.clearance + width / 2, width / 2, longest)


def wide_route(arena: Arena, start: Array, width: Array, longest: float = np.inf) -> Route | None:
    """The same, with the cells between the sets where corners may miss a way."""
    route = find_route(arena, start, width, longest)
    if route is None:
        route = _cell_route(arena, (start[0] + start[1]) / 2, arena.clearance + width / 2, width / 2)
    return route if route is not None and route.length <= longest else None


def _why_blocked(arena: Arena, centre: Array) -> str:
    """The refusal when there is no route: which options, each by itself, would open a way, and at what value."""

    def way(clearance: float, width: float, without: int | None = None) -> bool:
        inset = np.full(arena.dimension, width / 2)
        keep = [j for j in range(len(arena.names)) if j != without]
        rest = arena.only(keep)
        ways = (_search, _cell_route, _grid_route, _leg_route)
        return any(find(rest, centre, clearance + inset, inset) is not None for find in ways)

    def largest(holds: Callable[[float], bool], limit: float) -> str:
        low, high = 0.0, limit
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if holds(middle) else (low, middle)
        return f"{below(Fraction(max(low - 2 * arena.allowance, 0.0) * arena.length_unit), 4):g}"

    none, narrow = arena.allowance, 2 * arena.allowance
    final = _corners_decide(arena) or (arena.boxes_only and decides(len(arena.names), arena.dimension))
    leads = "leads" if final else "was found"
    start = f"{Property.AVOID.label}: no way {leads} from the initial set to the target set between the unsafe sets"
    if not way(none, narrow):
        blocking = [n for j, n in enumerate(arena.names) if len(arena.names) <= NAMED and way(none, narrow, j)]
        remove = f"without {' or '.join(blocking)} there would be one" if blocking else "remove or shrink an unsafe set"
        return f"{start}, whatever the clearance; {remove}, or enlarge the state space"
    width = (arena.min_width - 2 * arena.allowance) * arena.length_unit
    asked = (arena.clearance - arena.allowance) * arena.length_unit
    opens = []
    if way(none, arena.min_width):
        opens.append(f"tube.clearance = {largest(lambda c: way(c, arena.min_width), arena.clearance)}")
    if way(arena.clearance, narrow):
        opens.append(f"tube.min_width = {largest(lambda w: way(arena.clearance, w), arena.min_width)}")
    if not opens:
        widest = largest(lambda w: way(none, w), arena.min_width)
        opens.append(f"tube.clearance = 0 together with tube.min_width = {widest}")
    return f"{start} for a tube of width {width:.6g} with a clearance of {asked:.6g}; a way opens at {', or at '.join(opens)}"


def _search(arena: Arena, centre: Array, reach: Array, inset: Array, longest: float = np.inf, near: int = NEAR) -> Route | None:
    """The shortest route with these distances from unsafe sets and walls, up to `longest`; from a node only the `near` nearest
    nodes are looked at, which is quick with a thousand unsafe sets and may then miss a way."""
    found = _grown(arena, reach, inset)
    if found is None:
        return None
    obstacles, space, goal = found
    nodes = route_nodes(obstacles, space, goal, centre)
    buried = obstacles.inside(nodes)
    if buried[0]:
        return None
    nodes = nodes[~buried]
    if len(arena.walls.bound):
        nodes = nodes[arena.walls.contain_boxes(nodes, inset) | (np.arange(len(nodes)) == 0)]

    ends = np.clip(nodes, goal[0], goal[1])  # the nearest point of the target to each node
    end_free = ~obstacles.inside(ends)
    remaining = _length(arena, ends - nodes)
    cost = np.full(len(nodes), np.inf)
    cost[0] = 0.0
    parent = [-1] * len(nodes)
    closed = np.zeros(len(nodes), dtype=bool)
    queue: list[tuple[float, int]] = [(float(remaining[0]), 0)]
    best, last = np.inf, -1
    most = longest * (1 + STRAIGHT * arena.dimension)  # the sum of components is at most n times the largest
    while queue:
        estimate, v = heapq.heappop(queue)
        if estimate >= best:
            break
        if closed[v]:
            continue
        closed[v] = True
        if end_free[v] and cost[v] + remaining[v] < best and obstacles.visible(nodes[v], ends[v : v + 1])[0]:
            best, last = float(cost[v] + remaining[v]), v
        candidate = cost[v] + _length(arena, nodes - nodes[v])
        open_ = np.nonzero((candidate < cost) & (candidate + remaining <= most))[0]
        if len(open_) > near:
            open_ = open_[np.argsort(candidate[open_], kind="stable")[:near]]  # ties by index, on every machine
        around = np.vstack([nodes[v], nodes[open_]])
        seen = obstacles.near(around.min(axis=0), around.max(axis=0)).visible(nodes[v], nodes[open_])
        for w in open_[seen]:
            cost[w] = candidate[w]
            parent[w] = v
            heapq.heappush(queue, (float(candidate[w] + remaining[w]), int(w)))
    if last < 0:
        return None
    points = [ends[last]]
    v = last
    while v >= 0:
        if len(points) > 1 or bool((nodes[v] != points[0]).any()) or parent[v] < 0:
            points.append(nodes[v])
        v = parent[v]
    polyline = np.array(points[::-1])
    steps = arena.distance(polyline[1:] - polyline[:-1])
    return Route(polyline, float(np.cumsum(steps)[-1]), reach)


def route_nodes(obstacles: Obstacles, space: Array, goal: Array, centre: Array) -> Array:
    """The start, the corners of the grown sets that lie in the space, and the corners and centre of the target."""
    n = len(centre)
    middle = (goal[0] + goal[1]) / 2
    found = [centre]
    for low, high in zip(obstacles.lower, obstacles.upper, strict=True):
        choices = []
        for i in range(n):
            edges = [v for v in (low[i], high[i]) if space[0, i] <= v <= space[1, i]]
            choices.append(edges or sorted({centre[i], middle[i]}))
        if n <= CORNERS:
            found += [np.array(corner) for corner in itertools.product(*choices)]
        else:
            for anchor in (centre, middle):
                near = np.array([sorted(c, key=lambda v: abs(v - anchor[i]))[0] for i, c in enumerate(choices)])
                found.append(near)
                for i, c in enumerate(choices):
                    for v in c:
                        step = anchor.copy()
                        step[i] = v
                        found.append(step)
    for anchor in (
        (centre, middle) if len(obstacles.corners) else ()
    ):  # of a set that leaves a dimension free, or ends beyond a wall
        outside = (obstacles.corners < space[0]) | (obstacles.corners > space[1])
        found += list(np.unique(np.where(outside, anchor, obstacles.corners), axis=0))
    found.append(middle)
    if n <= CORNERS:
        found += [np.array(corner) for corner in itertools.product(*zip(goal[0], goal[1], strict=True))]
    return np.array(found)


def _length(arena: Arena, steps: Array) -> Array:
    """Length of steps (shape (P, n)): what they take at full speed, ties broken by the sum of components."""
    size = np.abs(steps)
    total = size[:, 0].copy()
    for i in range(1, size.shape[1]):
        total += size[:, i]
    return np.asarray(arena.distance(steps) + STRAIGHT * total)
