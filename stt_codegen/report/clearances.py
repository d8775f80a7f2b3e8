"""A tube at samples beside the sets that it is to keep off: how far it is from each, what keeps them apart, and where it meets
one. For pictures and pages; what is certified is in certify/."""

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


def _reached(row: Constraint, low: Array, high: Array) -> Array:
    """What a row is of tubes (P, n), without its bound: (P,)."""
    return np.asarray(sum((float(c) * (high if side else low)[:, i] for i, side, c in row.terms), np.zeros(len(low))))


def bounds_over(one: Avoidance, t: Array) -> Array:
    """The bounds of a set's rows over time, without the clearance, (R, T); minus infinity while it is safe."""
    if one.course is None:
        return np.repeat(np.array([[float(row.bound)] for row in one.alternatives]), len(t), axis=1)
    found = np.full((len(one.alternatives), len(t)), -np.inf)
    keep = np.array([float(row.clearance) for row in one.alternatives])[:, None]
    for leg in one.course.legs:
        lines = MovingBounds.of(one, leg)
        here = (t >= float(leg.begin)) & (t <= float(leg.end))
        constant, slope = ((v / lines.denominator).astype(float)[..., None] for v in (lines.constant, lines.slope))
        found[:, here] = np.maximum(found[:, here], (constant + slope * t[here]).max(axis=1) - keep)
    return found


def distance(one: Avoidance, t: Array, low: Array, high: Array) -> Array:
    """How far tubes at times t are from a set at least, along the best of its normals, the clearance not counted: (T,); negative
    where they meet it, infinite while it is safe."""
    slack = np.array([_reached(row, low, high) for row in one.alternatives]) - bounds_over(one, t)
    size = np.array([np.sqrt(sum(c * c for _, _, c in row.terms)) for row in one.alternatives])[:, None]
    return np.asarray((slack / size).max(axis=0))


def spans(where: Flags) -> Iterator[tuple[int, int]]:
    """First and last sample of every stretch that is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(np.int8)))
    yield from zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True)


@dataclass(frozen=True)
class Band:
    """A set in one dimension over time: edges (T,); `may`: while it may be unsafe, `kept`: of that, while nothing but this
    dimension keeps the tube off it."""

    name: str
    lower: Array
    upper: Array
    may: Flags
    kept: Flags


def bands(task: Task, i: int, t: Array, low: Array, high: Array) -> Iterator[Band]:
    """Every unsafe set in dimension i."""
    for one, convex in zip(avoidances(task), task.obstacles, strict=True):
        bounds, off = bounds_over(one, t), np.zeros(len(t), dtype=bool)
        ends = dict(zip((-1, 1), (float(v) for v in convex.span(i)), strict=True))
        lower, upper = np.full(len(t), ends[-1]), np.full(len(t), ends[1])
        for row, bound in zip(one.alternatives, bounds, strict=True):
            if {d for d, _, _ in row.terms} != {i}:
                off |= _reached(row, low, high) >= bound
            elif one.course is not None and row.terms[0][2] < 0:
                lower = -bound
            elif one.course is not None:
                upper = bound
        may = np.asarray(np.isfinite(bounds).any(axis=0))
        yield Band(one.name, lower, upper, may, may & ~off)
