"""Distances between a tube at samples of time and the unsafe sets, for pictures and pages. The proofs are in certify/."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stt_codegen.certify import MovingBounds
from stt_codegen.constraints import Avoidance, Constraint, avoidances
from stt_codegen.task import Task

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]


def _left_side(constraint: Constraint, low: Array, high: Array) -> Array:
    """Evaluate the left-hand side of a constraint for tubes with edges (P, n): (P,)."""
    return np.asarray(sum((float(c) * (high if side else low)[:, i] for i, side, c in constraint.terms), np.zeros(len(low))))


def bounds_over(avoidance: Avoidance, t: Array) -> Array:
    """Return the right-hand sides of a set's constraints over time, without the clearance: (R, T); -inf while the set is
    inactive."""
    if avoidance.course is None:
        return np.repeat(np.array([[float(constraint.bound)] for constraint in avoidance.alternatives]), len(t), axis=1)
    bounds = np.full((len(avoidance.alternatives), len(t)), -np.inf)
    clearance = np.array([float(constraint.clearance) for constraint in avoidance.alternatives])[:, None]
    for leg in avoidance.course.legs:
        lines = MovingBounds.of(avoidance, leg)
        is_active = (t >= float(leg.begin)) & (t <= float(leg.end))
        constant, slope = ((v / lines.denominator).astype(float)[..., None] for v in (lines.constant, lines.slope))
        bounds[:, is_active] = np.maximum(bounds[:, is_active], (constant + slope * t[is_active]).max(axis=1) - clearance)
    return bounds


def component_distance(avoidance: Avoidance, lower: Array, upper: Array, *, beyond_clearance: bool = False) -> float:
    """Return the distance of a box from a set at t = 0, in the largest component, as the clearance counts; infinite where the set
    is inactive. beyond_clearance: less the clearance, which may differ by component."""
    slack = [_left_side(constraint, lower[None], upper[None])[0] for constraint in avoidance.alternatives]
    bounds = bounds_over(avoidance, np.zeros(1))[:, 0]
    size = np.array([constraint.slack_per_distance for constraint in avoidance.alternatives])
    kept = np.array([float(constraint.clearance) if beyond_clearance else 0.0 for constraint in avoidance.alternatives])
    return float(((np.array(slack) - bounds - kept) / size).max())


def distance(avoidance: Avoidance, t: Array, low: Array, high: Array) -> Array:
    """Return the distance of tubes at times t from a set, along the best of its normals: (T,).

    Negative where they overlap, infinite while the set is inactive. The clearance is not subtracted.
    """
    slack = np.array([_left_side(constraint, low, high) for constraint in avoidance.alternatives]) - bounds_over(avoidance, t)
    size = np.array([np.sqrt(sum(c * c for _, _, c in constraint.terms)) for constraint in avoidance.alternatives])[:, None]
    return np.asarray((slack / size).max(axis=0))


def true_stretches(flags: Flags) -> Iterator[tuple[int, int]]:
    """Yield the first and last index of every stretch of samples that are true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    yield from zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True)


@dataclass(frozen=True)
class ObstacleBand:
    """An unsafe set in one dimension over time: its edges (T,).

    is_active: whether it may be unsafe at a sample. separates_alone: whether, then, only this dimension separates the tube
    from it.
    """

    name: str
    lower: Array
    upper: Array
    is_active: Flags
    separates_alone: Flags


def obstacle_bands(task: Task, i: int, t: Array, low: Array, high: Array) -> Iterator[ObstacleBand]:
    """Yield every unsafe set in dimension i, beside a tube with edges `low` and `high` at times t: (T, n)."""
    for avoidance, convex in zip(avoidances(task), task.obstacles, strict=True):
        bounds, is_separated_elsewhere = bounds_over(avoidance, t), np.zeros(len(t), dtype=bool)
        ends = dict(zip((-1, 1), (float(v) for v in convex.span(i)), strict=True))
        lower, upper = np.full(len(t), ends[-1]), np.full(len(t), ends[1])
        for constraint, bound in zip(avoidance.alternatives, bounds, strict=True):
            if {d for d, _, _ in constraint.terms} != {i}:
                is_separated_elsewhere |= _left_side(constraint, low, high) >= bound
            elif avoidance.course is not None and constraint.terms[0][2] < 0:
                lower = -bound
            elif avoidance.course is not None:
                upper = bound
        is_active = np.asarray(np.isfinite(bounds).any(axis=0))
        yield ObstacleBand(avoidance.name, lower, upper, is_active, is_active & ~is_separated_elsewhere)
