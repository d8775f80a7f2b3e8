"""The truth about unsafe sets that are no boxes, for `tubes.py`: from what the task's tables say, with normals and distances of
its own. Nothing is shared with `polytopes` and `balls` of `stt_codegen.task.sets`.

Two convex polytopes are apart where one of finitely many normals says so: of faces, and in space of an edge and an axis. Every
plane through points, and every direction across a line through two points and an axis, is taken; those too many only show what
is true. They are complete in up to three dimensions. A round set is a fault where a place on its segment is exactly nearer to
the tube's box than the radius; where that might be is sought in doubles, so a fault may be missed, and none is invented.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.task.sets.shapes import UnsafeBall, UnsafeCapsule, UnsafeHalfSpaces, UnsafePolytope, UnsafeSet
from stt_codegen.task.task import Task

Points = list[tuple[Fraction, ...]]
Bound = tuple[tuple[int, ...], Fraction]  # a normal in all dimensions, and h(normal)
SAMPLES = 16  # times of a segment at which distances to round sets are sought
THIRDS = 60  # of a stretch that is narrowed down
BITS = 40  # of the places that are looked at exactly
SPACE, PLANE = 3, 2


def bounds_of(task: Task, unsafe: Any) -> list[Bound]:
    """Normals that decide whether a box is apart from a polytope, and its support."""
    n, own = task.dimension, own_axes(task, unsafe)
    points, found = points_of(task, unsafe, own), []
    for normal in normals_of(points):
        full = [0] * n
        for i, c in zip(own, normal, strict=True):
            full[i] = c
        found.append((tuple(full), max(sum((c * v for c, v in zip(normal, p, strict=True)), Fraction(0)) for p in points)))
    return found


def cuts_of(task: Task, region: Any) -> list[Bound]:
    """Half-spaces that a box must be in to be in what cuts a region; of points more than are needed. Of a ball none."""
    n, own, found = task.dimension, own_axes(task, region), []
    if region.normals is not None:
        pairs: Any = zip(region.normals, region.offsets, strict=True)
    elif region.vertices is not None:
        planes = normals_of(list(region.vertices))
        pairs = [(v, max(sum((c * x for c, x in zip(v, p, strict=True)), Fraction(0)) for p in region.vertices)) for v in planes]
    else:
        pairs = []
    for normal, offset in pairs:
        full: list[Any] = [0] * n
        for i, c in zip(own, normal, strict=True):
            full[i] = c
        found.append((tuple(full), offset))
    return found


def beyond_ball(task: Task, low: Sequence[Fraction], high: Sequence[Fraction], room: Fraction) -> bool:
    """Whether the target is a ball and a corner of a box, grown by so much, is outside."""
    target = task.target_set
    if target.centre is None or target.radius is None:
        return False
    own = own_axes(task, target)
    far = [max(c - low[i], high[i] - c) + room for i, c in zip(own, target.centre, strict=True)]
    return sum((v * v for v in far), Fraction(0)) > target.radius**2


def own_axes(task: Task, unsafe: Any) -> list[int]:
    names = list(task.axes or (f"x{i + 1}" for i in range(task.dimension)))
    return [names.index(a) for a in unsafe.axes or names]


def points_of(task: Task, unsafe: Any, own: Sequence[int]) -> Points:
    """Points whose hull a polytope is, in its own dimensions."""
    if isinstance(unsafe, UnsafePolytope):
        return list(unsafe.vertices)
    if isinstance(unsafe, UnsafeSet):
        return list(itertools.product(*zip(unsafe.lower, unsafe.upper, strict=True)))
    assert isinstance(unsafe, UnsafeHalfSpaces)
    d, space = len(own), task.state_space
    faces = [(tuple(normal), offset) for normal, offset in zip(unsafe.normals, unsafe.offsets, strict=True)]
    for k, i in enumerate(own):
        for sign, end in ((1, space.upper[i]), (-1, -space.lower[i])):
            faces.append((tuple(Fraction(sign * (m == k)) for m in range(d)), end))
    found = []
    for chosen in itertools.combinations(faces, d):  # where as many faces as dimensions meet, by Cramer's rule
        matrix, right = [list(normal) for normal, _ in chosen], [offset for _, offset in chosen]
        whole = determinant(matrix)
        if whole:
            point = tuple(
                determinant([[*row[:k], b, *row[k + 1 :]] for row, b in zip(matrix, right, strict=True)]) / whole
                for k in range(d)
            )
            if all(sum(c * v for c, v in zip(normal, point, strict=True)) <= offset for normal, offset in faces):
                found.append(point)
    return found


def determinant(matrix: list[list[Fraction]]) -> Fraction:
    if not matrix:
        return Fraction(1)
    first, rest = matrix[0], matrix[1:]
    return sum(
        ((-1) ** k * c * determinant([[*row[:k], *row[k + 1 :]] for row in rest]) for k, c in enumerate(first) if c), Fraction(0)
    )


def normals_of(points: Points) -> set[tuple[int, ...]]:
    d = len(points[0])
    found = {tuple(s * (k == i) for k in range(d)) for i in range(d) for s in (-1, 1)}
    ways = [[v - w for v, w in zip(p, q, strict=True)] for p, q in itertools.combinations(points, 2)]
    across: list[list[Fraction]] = []
    if d == PLANE:
        across = [[-w[1], w[0]] for w in ways]
    elif d == SPACE:
        units = [[Fraction(k == i) for k in range(d)] for i in range(d)]
        across = [cross(w, u) for w in ways for u in units]
        for p, q, r in itertools.combinations(points, 3):
            across.append(cross([v - w for v, w in zip(q, p, strict=True)], [v - w for v, w in zip(r, p, strict=True)]))
    elif d > SPACE:
        raise ValueError("in more than three dimensions the normals are not complete")
    for vector in across:
        if any(vector):
            scale = math.lcm(*(v.denominator for v in vector))
            numbers = [int(v * scale) for v in vector]
            common = math.gcd(*numbers)
            found |= {tuple(s * v // common for v in numbers) for s in (-1, 1)}
    return found


def cross(a: Sequence[Fraction], b: Sequence[Fraction]) -> list[Fraction]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def is_round(unsafe: Any) -> bool:
    return isinstance(unsafe, UnsafeBall | UnsafeCapsule)


def round_places(
    task: Task, unsafe: Any, edges: npt.NDArray[np.int64], unit: Fraction, grow: Sequence[Fraction]
) -> Iterator[Fraction]:
    """Spline times at which the tube's box, grown by `grow` on every side, is nearer to a ball or capsule than its radius. edges:
    `truth.signed_edges`. At most one for each segment."""
    own = own_axes(task, unsafe)
    ends = list(unsafe.segment) if isinstance(unsafe, UnsafeCapsule) else [unsafe.centre] * 2
    line, radius = np.array(ends, dtype=float), float(unsafe.radius)
    cubics = edges[:, own].astype(float) * float(unit)  # (K, d, 2, 4): lower, and minus upper
    margin = np.array([[float(grow[i])] * 2 for i in own])

    def boxes(k: npt.NDArray[np.int64], s: npt.NDArray[np.float64]) -> Any:
        powers = s[:, None] ** np.arange(4)
        return np.einsum("pdec,pc->ped", cubics[k], powers) - margin.T

    def distance(k: npt.NDArray[np.int64], s: npt.NDArray[np.float64]) -> tuple[Any, Any]:
        edge = boxes(k, s)
        return nearest(line, edge[:, 0], -edge[:, 1])

    k, s = np.repeat(np.arange(len(edges)), SAMPLES + 1), np.tile(np.linspace(0, 1, SAMPLES + 1), len(edges))
    far = distance(k, s)[0].reshape(len(edges), SAMPLES + 1)
    best = far.argmin(axis=1)
    doubtful = np.nonzero(far.min(axis=1) < radius + 0.1 * radius + float(max(grow)))[0]
    a, b = np.maximum(best[doubtful] - 1, 0) / SAMPLES, np.minimum(best[doubtful] + 1, SAMPLES) / SAMPLES
    for _ in range(THIRDS):
        c, d = a + (b - a) / 3, b - (b - a) / 3
        left = distance(doubtful, c)[0] < distance(doubtful, d)[0]
        a, b = np.where(left, a, c), np.where(left, d, b)
    found = (a + b) / 2
    value, place = distance(doubtful, found)
    for at, s_, far_, p in zip(doubtful.tolist(), found.tolist(), value.tolist(), place.tolist(), strict=True):
        for moment in dict.fromkeys((s_, *([best[at] / SAMPLES] if far_ < radius else []))):
            time, along = (Fraction(round(v * (1 << BITS)), 1 << BITS) for v in (moment, p))
            if nearer(edges[at][own], unit, [grow[i] for i in own], ends, unsafe.radius, time, along):
                yield at + time
                break


def nearest(line: Any, lower: Any, upper: Any) -> tuple[Any, Any]:
    """Distances from a segment to boxes (P, d), and where along it, by thirds."""

    def at(s: Any) -> Any:
        p = line[0] + s[:, None] * (line[1] - line[0])
        return np.sqrt(np.sum(np.maximum(np.maximum(lower - p, p - upper), 0) ** 2, axis=1))

    a, b = np.zeros(len(lower)), np.ones(len(lower))
    for _ in range(THIRDS if (line[0] != line[1]).any() else 0):
        c, d = a + (b - a) / 3, b - (b - a) / 3
        left = at(c) < at(d)
        a, b = np.where(left, a, c), np.where(left, d, b)
    places = np.stack([(a + b) / 2, np.zeros_like(a), np.ones_like(a)])
    values = np.stack([at(s) for s in places])
    least = values.argmin(axis=0)
    return values[least, np.arange(len(a))], places[least, np.arange(len(a))]


def nearer(
    edges: Any, unit: Fraction, grow: Sequence[Fraction], ends: Points, radius: Fraction, time: Fraction, along: Fraction
) -> bool:
    """Whether a place of the segment is exactly nearer to the grown box than the radius."""
    square = Fraction(0)
    for (low, high), more, p, q in zip(edges.tolist(), grow, *ends, strict=True):
        lower, upper = (sign * sum(int(a) * time**k for k, a in enumerate(e)) * unit for sign, e in ((1, low), (-1, high)))
        place = p + along * (q - p)
        square += max(lower - more - place, place - upper - more, Fraction(0)) ** 2
    return square < radius**2
