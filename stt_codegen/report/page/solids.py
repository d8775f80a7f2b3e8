"""Convex sets in three dimensions as corners and flat faces, for a view that turns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
SAME = 6  # decimals to which the equations of one face agree, of sizes of 1


def solid(points: Array) -> tuple[Array, list[list[int]]]:
    """The corners of the hull of points (P, 3), and its faces, each the numbers of its corners in order around it. A set without
    a volume has no faces."""
    from scipy.spatial import ConvexHull, QhullError

    size = np.ptp(points, axis=0)
    if (size <= 0).any():
        return points, []
    scaled = (points - points.min(axis=0)) / size
    try:
        hull = ConvexHull(scaled)
    except QhullError:
        return points, []
    together: dict[tuple[float, ...], set[int]] = {}
    for equation, corners in zip(hull.equations, hull.simplices, strict=True):
        together.setdefault(tuple((np.round(equation, SAME) + 0.0).tolist()), set()).update(corners.tolist())
    kept = sorted(hull.vertices.tolist())
    place = {old: new for new, old in enumerate(kept)}
    faces = [[place[k] for k in _around(scaled, sorted(corners), np.array(plane[:3]))] for plane, corners in together.items()]
    return points[kept], faces


def _around(points: Array, corners: Sequence[int], normal: Array) -> list[int]:
    """The corners of a face in order around it."""
    first = np.eye(3)[int(np.argmin(np.abs(normal)))]
    a = np.cross(normal, first)
    b = np.cross(normal, a)
    away = points[list(corners)] - points[list(corners)].mean(axis=0)
    order = np.argsort(np.arctan2(away @ b, away @ a))
    return [corners[k] for k in order]
