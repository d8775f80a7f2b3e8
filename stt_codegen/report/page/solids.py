"""Convert convex sets in three dimensions to corners and flat faces, for the page's view that turns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
EQUATION_DECIMALS = 6  # to which equations of triangles of one face agree, in units of the set's size


def convex_solid(points: Array) -> tuple[Array, list[list[int]]]:
    """Return the corners of the hull of points (P, 3), and its faces as numbers of corners in order around each.

    A set without a volume has no faces.
    """
    from scipy.spatial import ConvexHull, QhullError

    size = np.ptp(points, axis=0)
    if (size <= 0).any():
        return points, []
    scaled = (points - points.min(axis=0)) / size
    try:
        hull = ConvexHull(scaled)
    except QhullError:
        return points, []
    corners_by_plane: dict[tuple[float, ...], set[int]] = {}
    for equation, corners in zip(hull.equations, hull.simplices, strict=True):
        corners_by_plane.setdefault(tuple((np.round(equation, EQUATION_DECIMALS) + 0.0).tolist()), set()).update(corners.tolist())
    used_points = sorted(hull.vertices.tolist())
    new_number = {old: new for new, old in enumerate(used_points)}
    faces = []
    for plane, corners in corners_by_plane.items():
        around = _corners_in_order(scaled, sorted(corners), np.array(plane[:3]))
        faces.append([new_number[k] for k in around])
    return points[used_points], faces


def _corners_in_order(points: Array, corners: Sequence[int], normal: Array) -> list[int]:
    """Return the corners of a face in order around it."""
    first = np.eye(3)[int(np.argmin(np.abs(normal)))]
    a = np.cross(normal, first)
    b = np.cross(normal, a)
    offsets = points[list(corners)] - points[list(corners)].mean(axis=0)
    order = np.argsort(np.arctan2(offsets @ b, offsets @ a))
    return [corners[k] for k in order]
