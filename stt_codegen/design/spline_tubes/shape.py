"""The spline tube of a given width by linear programs: as slow as its limits allow, one program for every dimension.

The upper edge is the lower one, the width, and what the start is wider: U = L + w + z, z >= 0 on the first WIDENED control
points. So a program has half the columns of two free edges, and its least peak speed is, in practice, the same.

Many tubes are as slow as the slowest: where a dimension has time to spare, any way of spending it will do. Of them the calmest is
taken: least sum of |second differences| of control points, by one more program for every dimension, at the pace it needs anyway.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import INNER, Rows, Solvers, Template, face_bound, least, template_of
from stt_codegen.design.moving_half_spaces import TimedObstacle
from stt_codegen.design.routes import Limits, limits_of_tube
from stt_codegen.designs import LOWER, UPPER

WIDENED = 12  # control points on which the tube may be wider than asked, so that it can begin with all of gamma(0)
NARROWS = 1e-3  # weight of what it is wider beside the pace
ROUNDS = 4  # of choosing sides anew
GAIN = 1.005  # a round must improve by this factor to be followed by another
SPARE = 1e-8  # of the pace that the calmest tube may take: ten times what the solver's rows are kept to
CLOSE = 1.03  # times a bound from below is as good as it gets
BEZIER = ((1 / 6, 4 / 6, 1 / 6, 0.0), (0.0, 2 / 3, 1 / 3, 0.0), (0.0, 1 / 3, 2 / 3, 0.0), (0.0, 1 / 6, 4 / 6, 1 / 6))


@dataclass(frozen=True, kw_only=True)
class Shape:
    """Control points of shape (2, n, K + 3) [edge, dimension, point], and by dimension (n,) their paces: the most that an edge
    moves in one segment's time, or for order 2 the most that two such moves differ. limits, width: what it was made within;
    demands: what a mission asks of it there, beside the arena's timed obstacles; seam: as of a design; way: of its centre."""

    points: Array
    paces: Array
    limits: Limits
    width: Array
    order: int = 1
    demands: tuple[TimedObstacle, ...] = ()
    seam: int | None = None
    way: Array | None = None

    @property
    def pace(self) -> float:
        """The most of all dimensions."""
        return float(self.paces.max())

    @property
    def segments(self) -> int:
        return int(self.points.shape[2]) - 3

    @property
    def speed(self) -> float:
        """The peak speed of an edge, with t_c as the unit of time; for order 2 a quarter of the peak acceleration."""
        return self.pace * (self.segments if self.order == 1 else self.segments * self.segments / 4)

    def bezier(self) -> Array:
        """Coefficients of every segment: shape (2, n, K, 4)."""
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


def slowest_shape(
    arena: Arena, start: Array, limits: Limits, width: Array, length: float, solvers: Solvers | None = None
) -> Shape | None:
    """The slowest tube of this width (n,), with sides chosen anew while that helps; None when there is none. length: of the way,
    a bound on the speed from below."""
    solvers = solvers or Solvers()
    best = shape_within(arena, start, limits, width, solvers)
    if best is None:
        return None
    here = limits
    for _ in range(ROUNDS):
        if best.speed <= CLOSE * length:
            break
        others = limits_of_tube(arena, best.bezier())
        if others.same(here):
            break
        trial = shape_within(arena, start, others, width, solvers)
        if trial is None or trial.pace * GAIN > best.pace:
            break
        best, here = trial, others
    return best


def shape_within(arena: Arena, start: Array, limits: Limits, width: Array, solvers: Solvers) -> Shape | None:
    """The slowest tube within these limits: every group of dimensions that the faces in use couple by itself, mostly one."""
    points: Array = np.empty((2, arena.dimension, len(limits.edges) + 3))
    paces: Array = np.empty(arena.dimension)
    edges = limits.coefficients(arena)  # (K, 4, 2, n)
    for members in _groups(arena, limits):
        found = _group(arena, start, limits, edges, width, members, solvers)
        if found is None:
            return None
        points[:, members], paces[members] = found
    return Shape(points=points, paces=paces, limits=limits, width=width, order=arena.order, seam=arena.seam)


def calmest(arena: Arena, start: Array, shape: Shape) -> Shape:
    """The calmest tube of the same width within the same limits, no dimension faster than it is: the one that bends least."""
    points, arena = shape.points.copy(), replace(arena, timed_obstacles=(*arena.timed_obstacles, *shape.demands), seam=shape.seam)
    edges = shape.limits.coefficients(arena)
    for members in _groups(arena, shape.limits):
        found = _group(arena, start, shape.limits, edges, shape.width, members, None, float(shape.paces[members[0]]))
        if found is not None:
            points[:, members] = found[0]
    return replace(shape, points=points)


@dataclass(frozen=True)
class _Coupling:
    """normal.x over the tube's box must be at least a bound on these segments: by `weights` all of their Bezier coefficients, or
    the last alone. bounds: one for each of the weights."""

    normal: tuple[float, ...]
    bounds: tuple[float, ...]
    segments: tuple[int, ...]
    weights: tuple[tuple[float, ...], ...] = BEZIER

    @property
    def first(self) -> int:
        """The first dimension that it is about."""
        return next(i for i, c in enumerate(self.normal) if c)


def widened_points(segments: int, seam: int | None) -> int:
    """On how many control points the tube may be wider than asked: none that comes again."""
    return min(WIDENED, segments if seam is None else seam)


def _couplings(arena: Arena, limits: Limits) -> list[_Coupling]:
    """What must hold of several dimensions together: beyond the faces in use, within what cuts the space and the target."""
    faces, count = arena.oblique_faces, len(limits.edges)
    found = [
        _Coupling(
            tuple(faces.normal[x].tolist()), (face_bound(arena, x),) * 4, tuple(np.nonzero(limits.beyond[:, x])[0].tolist())
        )
        for x in limits.faces
    ]
    for cuts, where, weights in ((arena.walls, tuple(range(count)), BEZIER), (arena.goals, (count - 1,), BEZIER[-1:])):
        for normal, bound in zip(cuts.normal.tolist(), cuts.bound.tolist(), strict=True):
            found.append(_Coupling(tuple(normal), (bound,) * len(weights), where, weights))
    for obstacle, chosen in zip(arena.timed_obstacles, limits.beside, strict=True):
        slanted = np.nonzero(chosen >= 2 * arena.dimension)[0].tolist()
        bounds = obstacle.bounds(count) + arena.clearance if slanted else None
        for k in slanted:
            assert bounds is not None
            found.append(_Coupling(tuple(obstacle.normal[chosen[k]].tolist()), tuple(bounds[chosen[k], k].tolist()), (k,)))
    return found


def _groups(arena: Arena, limits: Limits) -> list[list[int]]:
    """The dimensions that the faces in use couple, together; mostly every one by itself."""
    group = list(range(arena.dimension))
    for coupling in _couplings(arena, limits):
        joined = {group[i] for i, c in enumerate(coupling.normal) if c}
        group = [min(joined) if g in joined else g for g in group]
    return [[i for i, g in enumerate(group) if g == first] for first in sorted(set(group))]


def _group(
    arena: Arena,
    start: Array,
    limits: Limits,
    edges: Array,
    width: Array,
    members: list[int],
    solvers: Solvers | None,
    pace: float | None = None,
) -> tuple[Array, float] | None:
    """Control points (2, m, K + 3) of some dimensions, all with one pace, and it: the slowest; of a given pace the calmest."""
    segments, told = len(limits.edges), pace is not None
    bent = told or (arena.order == 1 and arena.max_acceleration is not None)
    steps = arena.order == 2 and bool(np.isfinite(arena.max_speeds).any())
    widened = widened_points(segments, arena.seam)
    template = template_of(segments, widened, bent, told, arena.order, steps, arena.seam)
    each = template.columns - 1
    last = each * len(members)
    parts, bounds = [], []
    for k, i in enumerate(members):
        own = template.rows.moved(k * each, each, last)
        parts.append(own if arena.swiftness[i] == 1 else own.times(last, float(arena.swiftness[i])))
        bounds.append(_bounds(arena, start[:, i], edges[..., i], float(width[i]), template, i))
    couplings = [c for c in _couplings(arena, limits) if c.first in members]
    if couplings:
        rows, low = _coupled(couplings, width, members, each, template)
        parts.append(rows)
        bounds.append((low, np.full(len(low), np.inf)))
    lower, upper, cost = np.full(last + 1, -np.inf), np.full(last + 1, np.inf), np.zeros(last + 1)
    lower[last], cost[last] = 0.0, 0.0 if told else 1.0
    if pace is not None:
        upper[last] = pace + SPARE
    elif arena.order == 2:
        upper[last] = min(_bend(arena, segments, i) for i in members)
    for k, i in enumerate(members):
        z = slice(k * each + template.points, k * each + template.points + widened)
        bends = slice(z.stop, (k + 1) * each)
        lower[z], cost[z] = 0.0, NARROWS / widened
        lower[bends], cost[bends] = 0.0, 1.0
        upper[bends] = _bend(arena, segments, i)
    row_lower, row_upper = (np.concatenate([b[e] for b in bounds]) for e in (0, 1))
    rows = Rows.joined(parts)
    if couplings or solvers is None:
        solution = least(cost, lower, upper, rows, row_lower, row_upper)
    else:
        solution = solvers.solve((segments, arena.seam or 0, *members), cost, lower, upper, rows, row_lower, row_upper)
    if solution is None:
        return None
    points = np.empty((2, len(members), segments + 3))
    for k, i in enumerate(members):
        low = solution[k * each : k * each + template.points]
        high = low + float(width[i])
        high[:widened] += solution[k * each + template.points : k * each + template.points + widened]
        for edge, value in ((LOWER, low), (UPPER, high)):
            points[edge, k] = value[list(template.column)]
    return points, float(solution[last])


def _bend(arena: Arena, segments: int, i: int) -> float:
    """The largest second difference of control points that the acceleration allows, with room for their rounding."""
    if arena.max_acceleration is None:
        return np.inf
    return float(arena.max_acceleration[i]) / segments**2 - arena.difference_allowance


def _bounds(arena: Arena, start: Array, edges: Array, width: float, template: Template, i: int) -> tuple[Array, Array]:
    """What the template's rows of dimension i are between. start (2,); edges (K, 4, 2): for every Bezier coefficient on L from
    below, on U from above."""
    place, count, segments = template.place, template.rows.count, len(edges)
    widened = template.widened
    lower, upper = np.full(count, -np.inf), np.full(count, np.inf)

    def put(name: str, low: Array, high: Array) -> None:
        alone = high.copy()
        alone[: widened - 1] = np.inf  # there the rows with z are U's
        lower[place[name]], upper[place[name]] = low, alone
        upper[place[f"{name}, wider"]] = high[: widened - 1]

    low, high = edges[..., 0], edges[..., 1] - width
    for k in range(len(INNER)):
        put(f"inner {k}", low[:, k + 1], high[:, k + 1])
    put("joint", np.maximum(low[1:, 0], low[:-1, 3]), np.minimum(high[1:, 0], high[:-1, 3]))
    lower[place["end"]] = max(arena.target[0, i], low[-1, 3])
    upper[place["end"]] = min(arena.target[1, i] - width, high[-1, 3])
    for name, value in (("start", start[0]), ("start, wider", start[1] - width)):
        lower[place[name]] = upper[place[name]] = value
    for name in ("rise", "rise, wider"):
        upper[place[name]] = 0.0
    for name in ("fall", "fall, wider"):
        lower[place[name]] = 0.0
    for name, low_, high_ in (("rest", -np.inf, 0.0), ("rest, wider", 0.0, np.inf)):
        if name in place:
            lower[place[name]], upper[place[name]] = low_, high_
    for name in ("step", "step, wider"):
        if name in place:
            most = float(arena.max_speeds[i]) / segments - arena.difference_allowance
            lower[place[name]], upper[place[name]] = -most, most
    for name in ("bend", "bend, wider"):
        if name in place:
            most = 0.0 if template.told else _bend(arena, segments, i)
            lower[place[name]], upper[place[name]] = -most, most
    return lower, upper


def _coupled(couplings: list[_Coupling], width: Array, members: list[int], each: int, template: Template) -> tuple[Rows, Array]:
    """The rows of couplings, and what they are at least."""
    rows: list[tuple[tuple[int, ...], tuple[float, ...]]] = []
    bound: list[float] = []
    widened = template.widened
    place = {i: k for k, i in enumerate(members)}
    for one in couplings:
        constant = sum(c * float(width[i]) for i, c in enumerate(one.normal) if c < 0)
        for s, (weights, limit) in itertools.product(one.segments, zip(one.weights, one.bounds, strict=True)):
            terms: dict[int, float] = {}
            for i, c in enumerate(one.normal):
                if not c:
                    continue
                first = place[i] * each
                for point, w in zip(range(s, s + 4), weights, strict=True):
                    own = first + template.column[point]
                    terms[own] = terms.get(own, 0.0) + c * w
                    if c < 0 and point < widened:
                        terms[first + template.points + point] = c * w
            rows.append((tuple(terms), tuple(terms.values())))
            bound.append(limit - constant)
    return Rows.of(rows), np.array(bound)
