"""The shortest route of the tube's centre over the corners of the grown unsafe sets, in the largest-component metric.

Nodes are the corners of the grown sets (a shortest path in any norm bends only there in the plane); edges are the straight lines
that meet no grown set's interior. The search is A*; it finds the edges of a node when it first expands the node. In three and
more dimensions the corners give a good route rather than the shortest; the linear programs improve it. Where some dimensions may
be faster than others, a component counts by the time that it takes (`Arena.distance`). shortest_route.py has the searches that
follow where this one finds no route.
"""

from __future__ import annotations

import heapq
import itertools
from dataclasses import dataclass

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import inner_box
from stt_codegen.design.routes.grown_sets import GrownObstacles, grow_obstacles

COMPONENT_SUM_WEIGHT = 1e-4  # of the sum of components: breaks the many ties of the largest-component metric
NEIGHBOUR_LIMIT = 128  # nearest nodes to which a node's lines of sight are checked
CORNER_DIMENSION_LIMIT = 6  # dimensions; with more, only the corners of a set nearest to start and target are nodes


@dataclass(frozen=True)
class Route:
    """A polyline from the centre of the start to a point of the target.

    points: (m + 1, n). length: in the largest-component metric. growth: (n,), clearance plus half width of the
    tube: the route is outside of the unsafe sets grown by it.
    """

    points: Array
    length: float
    growth: Array


@dataclass(frozen=True, kw_only=True)
class CentreProblem:
    """The space in which a route of the tube's centre is searched.

    growth (n,): clearance plus half width of the tube. half_width (n,): of the tube. obstacles: the unsafe sets grown by
    `growth`. space, goal: state space and target shrunk by `half_width`, (2, n); where half-spaces cut the target, `goal` is a
    box in it.
    """

    arena: Arena
    centre: Array
    growth: Array
    half_width: Array
    obstacles: GrownObstacles
    space: Array
    goal: Array


def centre_problem_of(arena: Arena, centre: Array, growth: Array, half_width: Array) -> CentreProblem | None:
    """Return the search problem of a tube from `centre`; None where half-spaces leave no box in the target for its centre.

    growth (n,): the distance of the centre from unsafe sets. half_width (n,): its distance from the ends of the space.
    """
    space, goal = (np.stack([box[0] + half_width, box[1] - half_width]) for box in (arena.space, arena.target))
    if len(arena.target_cuts.lower_bound) or len(arena.space_cuts.lower_bound):
        inner = inner_box(arena, goal, half_width)
        if inner is None:
            return None
        goal = inner
    return CentreProblem(
        arena=arena,
        centre=centre,
        growth=growth,
        half_width=half_width,
        obstacles=grow_obstacles(arena, growth),
        space=space,
        goal=goal,
    )


def search_finds_every_route(arena: Arena) -> bool:
    """Return whether the search among corners finds a route whenever there is one.

    It does in the plane, if it checks all lines of sight and the half-spaces of every set describe the set completely.
    """
    corners = sum(4 if b is None else b.shape[1] for b in arena.oblique_faces.bends)
    return arena.dimension == 2 and corners + 6 <= NEIGHBOUR_LIMIT and arena.oblique_faces.is_complete


def search_corners(
    problem: CentreProblem, *, length_limit: float = np.inf, neighbour_limit: int = NEIGHBOUR_LIMIT
) -> Route | None:
    """Return the shortest route over corners that is no longer than `length_limit`; None where none is found.

    The search checks only the `neighbour_limit` nearest nodes of each node. That is quick with a thousand unsafe sets, but it may
    miss a route.
    """
    arena, obstacles = problem.arena, problem.obstacles
    nodes = _free_nodes(problem)
    if nodes is None:
        return None
    ends = np.clip(nodes, problem.goal[0], problem.goal[1])  # the nearest point of the target to each node
    is_end_free = ~obstacles.contain(ends)
    remaining = _length(arena, ends - nodes)
    cost = np.full(len(nodes), np.inf)
    cost[0] = 0.0
    parent = [-1] * len(nodes)
    closed = np.zeros(len(nodes), dtype=bool)
    queue: list[tuple[float, int]] = [(float(remaining[0]), 0)]
    best_cost, last = np.inf, -1
    cost_limit = length_limit * (
        1 + COMPONENT_SUM_WEIGHT * arena.dimension
    )  # the sum of components is at most n times the largest
    while queue:
        estimate, v = heapq.heappop(queue)
        if estimate >= best_cost:
            break
        if closed[v]:
            continue
        closed[v] = True
        if is_end_free[v] and cost[v] + remaining[v] < best_cost and obstacles.visible_from(nodes[v], ends[v : v + 1])[0]:
            best_cost, last = float(cost[v] + remaining[v]), v
        candidate = cost[v] + _length(arena, nodes - nodes[v])
        improved = np.nonzero((candidate < cost) & (candidate + remaining <= cost_limit))[0]
        if len(improved) > neighbour_limit:  # ties by index, on every machine
            improved = improved[np.argsort(candidate[improved], kind="stable")[:neighbour_limit]]
        around = np.vstack([nodes[v], nodes[improved]])
        near_obstacles = obstacles.without_distant_boxes(around.min(axis=0), around.max(axis=0))
        for w in improved[near_obstacles.visible_from(nodes[v], nodes[improved])]:
            cost[w] = candidate[w]
            parent[w] = v
            heapq.heappush(queue, (float(candidate[w] + remaining[w]), int(w)))
    return None if last < 0 else _route_to(problem, nodes, parent, last, ends[last])


def _free_nodes(problem: CentreProblem) -> Array | None:
    """Return the nodes that are in no unsafe set and within the walls, the centre first; None where the centre is in a set."""
    arena = problem.arena
    nodes = route_nodes(problem.obstacles, problem.space, problem.goal, problem.centre)
    buried = problem.obstacles.contain(nodes)
    if buried[0]:
        return None
    nodes = nodes[~buried]
    if len(arena.space_cuts.lower_bound):
        nodes = nodes[arena.space_cuts.contain_boxes(nodes, problem.half_width) | (np.arange(len(nodes)) == 0)]
    return np.asarray(nodes)


def _route_to(problem: CentreProblem, nodes: Array, parent: list[int], last: int, end: Array) -> Route:
    """Return the route over the parents of node `last`, and from there to `end`."""
    points = [end]
    v = last
    while v >= 0:
        if len(points) > 1 or bool((nodes[v] != points[0]).any()) or parent[v] < 0:
            points.append(nodes[v])
        v = parent[v]
    return route_through(problem, np.array(points[::-1]))


def route_through(problem: CentreProblem, points: Array) -> Route:
    """Return the route over these points (m + 1, n)."""
    steps = problem.arena.distance(points[1:] - points[:-1])
    return Route(points, float(np.cumsum(steps)[-1]), problem.growth)


def route_nodes(obstacles: GrownObstacles, space: Array, goal: Array, centre: Array) -> Array:
    """Return the start, the corners of the grown sets that lie in the space, and the corners and centre of the target: (N, n)."""
    middle = (goal[0] + goal[1]) / 2
    has_few_corners = len(centre) <= CORNER_DIMENSION_LIMIT
    nodes = [centre]
    for low, high in zip(obstacles.lower, obstacles.upper, strict=True):
        choices = []
        for i in range(len(centre)):
            edges = [v for v in (low[i], high[i]) if space[0, i] <= v <= space[1, i]]
            choices.append(edges or sorted({centre[i], middle[i]}))
        if has_few_corners:
            nodes += [np.array(corner) for corner in itertools.product(*choices)]
        else:
            for anchor in (centre, middle):
                nodes += _nodes_beside(choices, anchor)
    # the corner of a set that leaves a dimension free, or ends beyond a wall, takes the coordinates outside from an anchor
    for anchor in (centre, middle) if len(obstacles.corners) else ():
        outside = (obstacles.corners < space[0]) | (obstacles.corners > space[1])
        nodes += list(np.unique(np.where(outside, anchor, obstacles.corners), axis=0))
    nodes.append(middle)
    if has_few_corners:
        nodes += [np.array(corner) for corner in itertools.product(*zip(goal[0], goal[1], strict=True))]
    return np.array(nodes)


def _nodes_beside(choices: list[list[float]], anchor: Array) -> list[Array]:
    """Return the corner of a box that is nearest to the anchor, and the anchor moved to each of the box's edges."""
    nodes = [np.array([sorted(c, key=lambda v: abs(v - anchor[i]))[0] for i, c in enumerate(choices)])]
    for i, c in enumerate(choices):
        for v in c:
            step = anchor.copy()
            step[i] = v
            nodes.append(step)
    return nodes


def _length(arena: Arena, steps: Array) -> Array:
    """Return the length of steps (P, n) as a search compares it: `Arena.distance`, with ties broken by the sum of components."""
    size = np.abs(steps)
    total = size[:, 0].copy()
    for i in range(1, size.shape[1]):
        total += size[:, i]
    return np.asarray(arena.distance(steps) + COMPONENT_SUM_WEIGHT * total)
