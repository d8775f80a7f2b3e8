"""The truth about unsafe sets that are not boxes, for `tubes.py`: derived again from the task's tables, with this file's normals
and distances. Nothing is shared with `polytopes` and `round_sets` of `stt_codegen.task.sets`.

Two convex polytopes are apart where one of finitely many normals separates them: of faces, and in space of an edge and an axis.
In the plane this file takes the normals of all lines through two points of the set; in space, of all planes through three points
and of all planes parallel to a line through two points and to an axis. The directions of the axes are
normals, too. Superfluous normals do no harm. All normals that are needed are among them in up to three dimensions.

For a round set a search in doubles proposes a time and a point of its segment. A fault is reported if this point is, in exact
numbers, nearer to the tube's box than the radius. So a fault may be missed, but no false fault is reported.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.task.sets.shapes import UnsafeBall, UnsafeCapsule, UnsafeHalfSpaces, UnsafePolytope, UnsafeSet
from stt_codegen.task.task import Task

Points = list[tuple[Fraction, ...]]
HalfSpace = tuple[tuple[int, ...], Fraction]  # a normal in all dimensions, and its offset: normal . x <= offset
SAMPLES_PER_SEGMENT = 16  # at which distances to round sets are compared first
TERNARY_STEPS = 60  # each leaves two thirds of an interval
EXACT_BITS = 40  # after the point, of a time or a share that a search in doubles has proposed
SPACE, PLANE = 3, 2


@dataclass(frozen=True)
class GrownTube:
    """A tube whose box grows on every side. edges: `tubes.signed_edges`, (K, n, 2, 4); unit: of the table; growth: by axis, of
    body, clearance and margin together."""

    edges: npt.NDArray[np.int64]
    unit: Fraction
    growth: Sequence[Fraction]

    def box(self, segment: int, s: Fraction, axes: Sequence[int]) -> list[tuple[Fraction, Fraction]]:
        """Return the grown box at s of a segment, exactly: lower and upper edge by axis."""
        box = []
        for i in axes:
            lower, minus_upper = (sum(int(a) * s**p for p, a in enumerate(edge)) * self.unit for edge in self.edges[segment, i])
            box.append((lower - self.growth[i], -minus_upper + self.growth[i]))
        return box


def supporting_half_spaces(task: Task, unsafe: Any) -> list[HalfSpace]:
    """Return half-spaces around a polytope: a box is apart from it exactly where the box is outside one of them."""
    axes = bounded_axes(task, unsafe)
    points = hull_points(task, unsafe, axes)
    half_spaces = []
    for normal in candidate_normals(points):
        support = max(sum((c * v for c, v in zip(normal, p, strict=True)), Fraction(0)) for p in points)
        half_spaces.append((_in_all_dimensions(task, axes, normal), support))
    return half_spaces


def region_half_spaces(task: Task, region: Any) -> list[HalfSpace]:
    """Return the half-spaces that cut a region, state space or target: a box must be in all of them.

    For vertices some of the half-spaces are superfluous. A region without a cut and a ball have none."""
    axes = bounded_axes(task, region)
    if region.normals is not None:
        pairs: Any = zip(region.normals, region.offsets, strict=True)
    elif region.vertices is not None:
        normals = candidate_normals(list(region.vertices))
        pairs = [(v, max(sum((c * x for c, x in zip(v, p, strict=True)), Fraction(0)) for p in region.vertices)) for v in normals]
    else:
        pairs = []
    return [(_in_all_dimensions(task, axes, normal), offset) for normal, offset in pairs]


def _in_all_dimensions(task: Task, axes: Sequence[int], normal: Sequence[Any]) -> tuple[Any, ...]:
    """Return a normal of some axes as one of all axes of the task, with zeros."""
    full: list[Any] = [0] * task.dimension
    for i, c in zip(axes, normal, strict=True):
        full[i] = c
    return tuple(full)


def leaves_target_ball(task: Task, low: Sequence[Fraction], high: Sequence[Fraction], margin: Fraction) -> bool:
    """Return whether the target is a ball and a corner of the box, grown by the margin, is outside of the ball."""
    target = task.target_set
    if target.centre is None or target.radius is None:
        return False
    axes = bounded_axes(task, target)
    farthest = [max(c - low[i], high[i] - c) + margin for i, c in zip(axes, target.centre, strict=True)]
    return sum((v * v for v in farthest), Fraction(0)) > target.radius**2


def bounded_axes(task: Task, table: Any) -> list[int]:
    """Return the indices of the axes that a set of the task bounds: all axes if its table names none."""
    names = list(task.axes or (f"x{i + 1}" for i in range(task.dimension)))
    return [names.index(a) for a in table.axes or names]


def hull_points(task: Task, unsafe: Any, axes: Sequence[int]) -> Points:
    """Return points on these axes whose convex hull is the polytope: its vertices, or a box's corners."""
    if isinstance(unsafe, UnsafePolytope):
        return list(unsafe.vertices)
    if isinstance(unsafe, UnsafeSet):
        return list(itertools.product(*zip(unsafe.lower, unsafe.upper, strict=True)))
    assert isinstance(unsafe, UnsafeHalfSpaces)
    d, space = len(axes), task.state_space
    faces = [(tuple(normal), offset) for normal, offset in zip(unsafe.normals, unsafe.offsets, strict=True)]
    for k, i in enumerate(axes):
        for sign, end in ((1, space.upper[i]), (-1, -space.lower[i])):
            faces.append((tuple(Fraction(sign * (m == k)) for m in range(d)), end))
    return _vertices_of_faces(faces, d)


def _vertices_of_faces(faces: Sequence[tuple[tuple[Fraction, ...], Fraction]], d: int) -> Points:
    """Return the vertices of a polytope: the points at which d faces meet (by Cramer's rule) and that satisfy all half-spaces."""
    vertices = []
    for meeting in itertools.combinations(faces, d):
        matrix, right = [list(normal) for normal, _ in meeting], [offset for _, offset in meeting]
        divisor = determinant(matrix)
        if divisor:
            point = tuple(
                determinant([[*row[:k], b, *row[k + 1 :]] for row, b in zip(matrix, right, strict=True)]) / divisor
                for k in range(d)
            )
            if all(sum(c * v for c, v in zip(normal, point, strict=True)) <= offset for normal, offset in faces):
                vertices.append(point)
    return vertices


def determinant(matrix: list[list[Fraction]]) -> Fraction:
    if not matrix:
        return Fraction(1)
    first, rest = matrix[0], matrix[1:]
    return sum(
        ((-1) ** k * c * determinant([[*row[:k], *row[k + 1 :]] for row in rest]) for k, c in enumerate(first) if c), Fraction(0)
    )


def candidate_normals(points: Points) -> set[tuple[int, ...]]:
    """Return integer normals, both signs, one of which separates the hull of these points from a box where the two are apart.

    Raises ValueError in more than three dimensions, where they would be incomplete."""
    d = len(points[0])
    normals = {tuple(s * (k == i) for k in range(d)) for i in range(d) for s in (-1, 1)}
    differences = [[v - w for v, w in zip(p, q, strict=True)] for p, q in itertools.combinations(points, 2)]
    across: list[list[Fraction]] = []
    if d == PLANE:
        across = [[-w[1], w[0]] for w in differences]
    elif d == SPACE:
        units = [[Fraction(k == i) for k in range(d)] for i in range(d)]
        across = [cross_product(w, u) for w in differences for u in units]
        for p, q, r in itertools.combinations(points, 3):
            first, second = ([v - w for v, w in zip(point, p, strict=True)] for point in (q, r))
            across.append(cross_product(first, second))
    elif d > SPACE:
        raise ValueError("in more than three dimensions the normals are not complete")
    for vector in across:
        if any(vector):
            scale = math.lcm(*(v.denominator for v in vector))
            numbers = [int(v * scale) for v in vector]
            common = math.gcd(*numbers)
            normals |= {tuple(s * v // common for v in numbers) for s in (-1, 1)}
    return normals


def cross_product(a: Sequence[Fraction], b: Sequence[Fraction]) -> list[Fraction]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def is_round(unsafe: Any) -> bool:
    """Whether the set is a ball or a capsule."""
    return isinstance(unsafe, UnsafeBall | UnsafeCapsule)


def round_contact_times(task: Task, unsafe: Any, tube: GrownTube) -> Iterator[Fraction]:
    """Yield spline times (segment + s) at which the tube's grown box is nearer to a ball or capsule than its radius, at most one
    for each segment. A ternary search in doubles proposes them, `is_nearer` decides exactly."""
    axes, segments = bounded_axes(task, unsafe), len(tube.edges)
    ends = list(unsafe.segment) if isinstance(unsafe, UnsafeCapsule) else [unsafe.centre] * 2
    line, radius = np.array(ends, dtype=float), float(unsafe.radius)
    cubics = tube.edges[:, axes].astype(float) * float(tube.unit)  # (K, d, 2, 4): lower, and minus upper
    growth = np.array([[float(tube.growth[i])] * 2 for i in axes])

    def distance(k: npt.NDArray[np.int64], s: npt.NDArray[np.float64]) -> tuple[Any, Any]:
        edge = np.einsum("pdec,pc->ped", cubics[k], s[:, None] ** np.arange(4)) - growth.T
        return distances_to_segment(line, edge[:, 0], -edge[:, 1])

    samples = np.tile(np.linspace(0, 1, SAMPLES_PER_SEGMENT + 1), segments)
    sampled = distance(np.repeat(np.arange(segments), SAMPLES_PER_SEGMENT + 1), samples)[0].reshape(segments, -1)
    nearest_sample = sampled.argmin(axis=1)
    near = np.nonzero(sampled.min(axis=1) < radius + 0.1 * radius + float(max(tube.growth)))[0]
    a = np.maximum(nearest_sample[near] - 1, 0) / SAMPLES_PER_SEGMENT
    b = np.minimum(nearest_sample[near] + 1, SAMPLES_PER_SEGMENT) / SAMPLES_PER_SEGMENT
    for _ in range(TERNARY_STEPS):
        c, d = a + (b - a) / 3, b - (b - a) / 3
        left = distance(near, c)[0] < distance(near, d)[0]
        a, b = np.where(left, a, c), np.where(left, d, b)
    times = (a + b) / 2
    distances, shares = distance(near, times)
    for k, time, gap, share in zip(near.tolist(), times.tolist(), distances.tolist(), shares.tolist(), strict=True):
        for moment in dict.fromkeys((time, *([nearest_sample[k] / SAMPLES_PER_SEGMENT] if gap < radius else []))):
            s, along = to_exact(moment), to_exact(share)
            if is_nearer(tube.box(k, s, axes), point_on_segment(ends, along), unsafe.radius):
                yield k + s
                break


def distances_to_segment(line: Any, lower: Any, upper: Any) -> tuple[Any, Any]:
    """Return the distances from a line segment (2, d) to boxes (P, d), and the shares of the segment at which they are taken, by
    a ternary search."""

    def distance(s: Any) -> Any:
        p = line[0] + s[:, None] * (line[1] - line[0])
        return np.sqrt(np.sum(np.maximum(np.maximum(lower - p, p - upper), 0) ** 2, axis=1))

    a, b = np.zeros(len(lower)), np.ones(len(lower))
    for _ in range(TERNARY_STEPS if (line[0] != line[1]).any() else 0):
        c, d = a + (b - a) / 3, b - (b - a) / 3
        left = distance(c) < distance(d)
        a, b = np.where(left, a, c), np.where(left, d, b)
    shares = np.stack([(a + b) / 2, np.zeros_like(a), np.ones_like(a)])
    distances = np.stack([distance(s) for s in shares])
    best, every_box = distances.argmin(axis=0), np.arange(len(a))
    return distances[best, every_box], shares[best, every_box]


def to_exact(value: Any) -> Fraction:
    """Round a double to EXACT_BITS bits after the point."""
    return Fraction(round(float(value) * (1 << EXACT_BITS)), 1 << EXACT_BITS)


def point_on_segment(ends: Points, share: Fraction) -> list[Fraction]:
    """Return the point at this share of the way from the first end to the second."""
    return [p + share * (q - p) for p, q in zip(*ends, strict=True)]


def is_nearer(box: Sequence[tuple[Fraction, Fraction]], point: Sequence[Fraction], radius: Fraction) -> bool:
    """Whether the point is, exactly, nearer to the box than the radius."""
    square = sum((max(lower - v, v - upper, Fraction(0)) ** 2 for (lower, upper), v in zip(box, point, strict=True)), Fraction(0))
    return square < radius**2
