"""The spline tube of a given width by linear programs: as slow as its limits allow, one program for every dimension.

The upper edge is the lower one, the width, and what the start is wider: U = L + w + z, z >= 0 on the first WIDENED control
points. So a program has half the columns that two free edges would have, and its least peak speed is, in practice, the same. A
tube that is wider than w here and there would be faster there: its edges move more.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from stt_codegen.design.arena import Arena, Array
from stt_codegen.design.sides import Limits, limits_of_tube
from stt_codegen.design.solver import Rows, Solvers, face_bound, least
from stt_codegen.designs import LOWER, UPPER

WIDENED = 12  # control points on which the tube may be wider than asked, so that it can begin with all of gamma(0)
NARROWS = 1e-3  # weight of what it is wider beside the pace
ROUNDS = 4  # of choosing sides anew
GAIN = 1.005  # a round must improve by this factor to be followed by another
CLOSE = 1.03  # times a bound from below is as good as it gets
# The Bezier coefficients of a segment inside it, where two meet, and at t_c, by the control points from the second on.
INNER, JOINT, END = ((2 / 3, 1 / 3), (1 / 3, 2 / 3)), (1 / 6, 4 / 6, 1 / 6), (2 / 6, 4 / 6)
BEZIER = ((1 / 6, 4 / 6, 1 / 6, 0.0), (0.0, 2 / 3, 1 / 3, 0.0), (0.0, 1 / 3, 2 / 3, 0.0), (0.0, 1 / 6, 4 / 6, 1 / 6))


@dataclass(frozen=True)
class Shape:
    """Control points of shape (2, n, K + 3) [edge, dimension, point], and their pace: the most that an edge moves in one
    segment's time."""

    points: Array
    pace: float

    @property
    def segments(self) -> int:
        return int(self.points.shape[2]) - 3

    @property
    def speed(self) -> float:
        """The peak speed of an edge, with t_c as the unit of time."""
        return self.pace * self.segments

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
    arena: Arena, start: Array, limits: Limits, width: Array, floor: float, solvers: Solvers | None = None
) -> Shape | None:
    """The slowest tube of this width (n,), with sides chosen anew while that helps; None when there is none. floor: a bound on
    the pace from below."""
    solvers = solvers or Solvers()
    best = shape_within(arena, start, limits, width, solvers)
    if best is None:
        return None
    here = limits
    for _ in range(ROUNDS):
        if best.pace <= CLOSE * floor:
            break
        others = limits_of_tube(arena, best.bezier())
        if (others.edges == here.edges).all() and (others.beyond == here.beyond).all():
            break
        trial = shape_within(arena, start, others, width, solvers)
        if trial is None or trial.pace * GAIN > best.pace:
            break
        best, here = trial, others
    return best


def shape_within(arena: Arena, start: Array, limits: Limits, width: Array, solvers: Solvers) -> Shape | None:
    """The slowest tube within these limits: every group of dimensions that the faces in use couple by itself, mostly one."""
    group = list(range(arena.dimension))
    for x in limits.faces:
        joined = {group[i] for i in np.nonzero(arena.faces.normal[x])[0]}
        group = [min(joined) if g in joined else g for g in group]
    points: Array = np.empty((2, arena.dimension, len(limits.edges) + 3))
    pace = 0.0
    for first in sorted(set(group)):
        members = [i for i, g in enumerate(group) if g == first]
        found = _group(arena, start, limits, width, members, solvers)
        if found is None:
            return None
        points[:, members] = found.points
        pace = max(pace, found.pace)
    return Shape(points, pace)


@dataclass(frozen=True)
class _Template:
    """The rows of one dimension for K segments, m widened points: columns are L's K + 2 control points (point K + 2 is point K),
    then z's m, then the pace. place: which rows are which."""

    rows: Rows
    place: dict[str, slice]
    columns: int


@cache
def _template(segments: int, widened: int) -> _Template:
    points = segments + 2
    pace = points + widened
    column = [*range(points), segments]
    rows: list[tuple[tuple[int, ...], tuple[float, ...]]] = []
    place: dict[str, slice] = {}

    def add(name: str, found: list[tuple[tuple[int, ...], tuple[float, ...]]]) -> None:
        place[name] = slice(len(rows), len(rows) + len(found))
        rows.extend(found)

    def lower(points: tuple[int, ...], values: tuple[float, ...]) -> tuple[tuple[int, ...], tuple[float, ...]]:
        return tuple(column[j] for j in points), values

    def upper(places: tuple[int, ...], values: tuple[float, ...]) -> tuple[tuple[int, ...], tuple[float, ...]]:
        wider = [(points + j, v) for j, v in zip(places, values, strict=True) if j < widened]
        return (*(column[j] for j in places), *(c for c, _ in wider)), (*values, *(v for _, v in wider))

    early = range(widened - 1)  # segments and joints in which z counts
    for k, weights in enumerate(INNER):
        add(f"inner {k}", [lower((s + 1, s + 2), weights) for s in range(segments)])
        add(f"inner {k}, wider", [upper((s + 1, s + 2), weights) for s in early])
    add("joint", [lower((s + 1, s + 2, s + 3), JOINT) for s in range(segments - 1)])
    add("joint, wider", [upper((s + 1, s + 2, s + 3), JOINT) for s in early if s < segments - 1])
    add("end", [lower((segments, segments + 1), END)])
    add("start", [lower((0, 1, 2), JOINT)])
    add("start, wider", [upper((0, 1, 2), JOINT)])
    # |gammadot| by the Bezier coefficients of the derivative: differences of control points, and their mean at 0
    for name, sign in (("rise", -1.0), ("fall", 1.0)):
        steps = [*(((j + 1, j), (1.0, -1.0)) for j in range(1, segments + 1)), ((2, 0), (0.5, -0.5))]
        early_steps = [*(((j + 1, j), (1.0, -1.0)) for j in range(1, widened)), ((2, 0), (0.5, -0.5))]
        for what, edge, which in ((name, lower, steps), (f"{name}, wider", upper, early_steps)):
            found = [edge(places, values) for places, values in which]
            add(what, [((*c, pace), (*v, sign)) for c, v in found])
    return _Template(Rows.of(rows), place, pace + 1)


def _group(arena: Arena, start: Array, limits: Limits, width: Array, members: list[int], solvers: Solvers) -> Shape | None:
    """The slowest tube of some dimensions, all with one pace."""
    segments = len(limits.edges)
    template = _template(segments, min(WIDENED, segments))
    each = template.columns - 1
    pace = each * len(members)
    parts, bounds = [], []
    for k, i in enumerate(members):
        parts.append(template.rows.moved(k * each, each, pace))
        bounds.append(_bounds(arena, start[:, i], limits.edges[:, :, i], float(width[i]), template, i))
    faces = [x for x in limits.faces if int(np.nonzero(arena.faces.normal[x])[0][0]) in members]
    if faces:
        rows, low = _faces(arena, limits, faces, width, members, each, segments)
        parts.append(rows)
        bounds.append((low, np.full(len(low), np.inf)))
    lower, upper, cost = np.full(pace + 1, -np.inf), np.full(pace + 1, np.inf), np.zeros(pace + 1)
    lower[pace], cost[pace] = 0.0, 1.0
    widened = each - segments - 2
    for k in range(len(members)):
        z = slice(k * each + segments + 2, (k + 1) * each)
        lower[z], cost[z] = 0.0, NARROWS / widened
    row_lower, row_upper = (np.concatenate([b[e] for b in bounds]) for e in (0, 1))
    rows = Rows.joined(parts)
    if faces:
        solution = least(cost, lower, upper, rows, row_lower, row_upper)
    else:
        solution = solvers.solve((segments, *members), cost, lower, upper, rows, row_lower, row_upper)
    if solution is None:
        return None
    points = np.empty((2, len(members), segments + 3))
    for k, i in enumerate(members):
        low = solution[k * each : k * each + segments + 2]
        high = low + float(width[i])
        high[:widened] += solution[k * each + segments + 2 : (k + 1) * each]
        for edge, value in ((LOWER, low), (UPPER, high)):
            points[edge, k] = np.concatenate([value, value[segments : segments + 1]])
    return Shape(points, float(solution[pace]))


def _bounds(arena: Arena, start: Array, edges: Array, width: float, template: _Template, i: int) -> tuple[Array, Array]:
    """What the template's rows of dimension i are between. start (2,); edges (K, 2): on L from below, on U from above."""
    place, count, widened = template.place, template.rows.count, template.columns - len(edges) - 3
    lower, upper = np.full(count, -np.inf), np.full(count, np.inf)
    low, high = edges[:, 0], edges[:, 1] - width
    alone = high.copy()
    alone[: widened - 1] = np.inf  # there the rows with z are U's
    for k in range(len(INNER)):
        lower[place[f"inner {k}"]], upper[place[f"inner {k}"]] = low, alone
        upper[place[f"inner {k}, wider"]] = high[: widened - 1]
    meet_low, meet_high = np.maximum(low[1:], low[:-1]), np.minimum(high[1:], high[:-1])
    meet_alone = meet_high.copy()
    meet_alone[: widened - 1] = np.inf
    lower[place["joint"]], upper[place["joint"]] = meet_low, meet_alone
    upper[place["joint, wider"]] = meet_high[: widened - 1]
    lower[place["end"]] = max(arena.target[0, i], low[-1])
    upper[place["end"]] = min(arena.target[1, i] - width, high[-1])
    for name, value in (("start", start[0]), ("start, wider", start[1] - width)):
        lower[place[name]] = upper[place[name]] = value
    for name in ("rise", "rise, wider"):
        upper[place[name]] = 0.0
    for name in ("fall", "fall, wider"):
        lower[place[name]] = 0.0
    return lower, upper


def _faces(
    arena: Arena, limits: Limits, faces: list[int], width: Array, members: list[int], each: int, segments: int
) -> tuple[Rows, Array]:
    """Rows that keep the Bezier coefficients of some segments beyond faces, and what they are at least."""
    rows: list[tuple[tuple[int, ...], tuple[float, ...]]] = []
    bound: list[float] = []
    widened = each - segments - 2
    place = {i: k for k, i in enumerate(members)}
    for x in faces:
        normal = arena.faces.normal[x].tolist()
        constant = sum(c * float(width[i]) for i, c in enumerate(normal) if c < 0)
        for s in np.nonzero(limits.beyond[:, x])[0].tolist():
            for weights in BEZIER:
                terms: dict[int, float] = {}
                for i, c in enumerate(normal):
                    if not c:
                        continue
                    first = place[i] * each
                    for point, w in zip(range(s, s + 4), weights, strict=True):
                        own = first + (segments if point == segments + 2 else point)  # the last control points are one column
                        terms[own] = terms.get(own, 0.0) + c * w
                        if c < 0 and point < widened:
                            terms[first + segments + 2 + point] = c * w
                rows.append((tuple(terms), tuple(terms.values())))
                bound.append(face_bound(arena, x) - constant)
    return Rows.of(rows), np.array(bound)
