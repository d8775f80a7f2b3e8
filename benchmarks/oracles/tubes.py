"""The truth about a refined tube, for judging its certificate: P1 to P6 of the exact edges, by roots of polynomials.

On every segment each edge is a cubic in s in [0, 1] with exact coefficients. Every property says that at every s at least one of
a few cubics is >= 0. Where that fails it fails on an open interval between two neighbouring roots, so `cubics.py` isolates the
real roots and takes exact signs at one rational point between each two. `mutations.py`, `theorem.py` and tests call this file.
Nothing is shared with `stt_codegen.certify`: no Bezier hull, no halving, no tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.oracles.cubics import eightfold_range, less_bound, point_where_all_are_negative
from benchmarks.oracles.moving_sets import displacement_at, is_timed, moving_contact_times
from benchmarks.oracles.shapes import (
    GrownTube,
    is_round,
    leaves_target_ball,
    region_half_spaces,
    round_contact_times,
    supporting_half_spaces,
)
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.designs.tube import LOWER, UPPER
from stt_codegen.task.sets.shapes import Box, UnsafeSet
from stt_codegen.task.task import Task

Integers = npt.NDArray[np.int64]
SMALLEST_WIDTH = Fraction(1, 1 << 20)  # in a narrower tube the emitted law is not the paper's
EIGHTFOLD_LIMIT = 1 << 40  # table units, beyond 8 times every edge


@dataclass(frozen=True)
class Fault:
    """A property that fails, by its code, and an exact time (seconds) where it does; dimension and unsafe set count from 0."""

    code: str
    time: Fraction
    dimension: int | None = None
    unsafe: int | None = None


@dataclass(frozen=True)
class ExactTube:
    """The edges of a design for a task. edges: `signed_edges`; unit: of the table; segment_seconds: how long a segment takes."""

    task: Task
    edges: Integers
    unit: Fraction
    segment_seconds: Fraction

    @classmethod
    def of(cls, task: Task, design: RefinedDesign) -> ExactTube:
        return cls(task, signed_edges(design), design.unit, design.prescribed_time / design.segments)

    @property
    def body(self) -> tuple[Fraction, ...]:
        """Half the body's size by axis; 0 for a point."""
        return self.task.body or (Fraction(0),) * self.task.dimension

    def signed_ends(self, segment: int) -> list[list[Fraction]]:
        """Return the lower edge and minus the upper one by axis: at the start (segment 0) or at t_c (segment -1)."""
        sums = self.edges[0, :, :, 0] if segment == 0 else self.edges[segment].sum(axis=-1)
        return [[int(v) * self.unit for v in pair] for pair in sums]


def first_fault(task: Task, design: RefinedDesign, margin: Fraction = Fraction(0)) -> Fault | None:
    """Return a property that fails; None when P1 to P6 hold with this margin (task's units; twice that in the width, none for
    P6).

    Raises `cubics.Undecided`, which Arb promises not to happen."""
    return next(faults(task, design, margin), None)


def faults(task: Task, design: RefinedDesign, margin: Fraction = Fraction(0)) -> Iterator[Fault]:
    """Yield where the tube breaks a property: one time for every segment that does, of P2 and the kink of P6 for every dimension.

    Sets are closed, so an edge may lie on a bound. But x(0) must be strictly inside gamma(0), where the law is finite.
    """
    tube = ExactTube.of(task, design)
    yield from _faults_at_start_and_end(tube, design, margin)
    yield from _target_shape_faults(tube, margin)
    yield from _state_space_shape_faults(tube, margin)
    yield from _edge_faults(tube, margin)
    yield from _unsafe_faults(tube, margin)


def _faults_at_start_and_end(tube: ExactTube, design: RefinedDesign, margin: Fraction) -> Iterator[Fault]:
    """Yield faults of P2, of P5 where the target has a box, and of P6 where an edge is not at rest at t_c."""
    task, t_c = tube.task, design.prescribed_time
    start, end = tube.signed_ends(0), tube.signed_ends(-1)
    initial_faces = signed_faces(task.initial_set)
    target_faces = [(low - 1, high - 1) for low, high in end]  # without a box nothing is required of the edges
    if task.target_set.lower:
        by = displacement_at(task, task.target_set, task.prescribed_time)
        target_faces = [(low + by[i], high - by[i]) for i, (low, high) in enumerate(signed_faces(task.target_set))]
    for i, x in enumerate(task.initial_state):
        distance = min(x - start[i][LOWER], -x - start[i][UPPER])
        starts_inside = all(start[i][side] >= initial_faces[i][side] + margin for side in (LOWER, UPPER))
        if distance <= 0 or distance < margin or not starts_inside:
            yield Fault("P2", Fraction(0), i)
        if any(end[i][side] < target_faces[i][side] + margin for side in (LOWER, UPPER)):
            yield Fault("P5", t_c, i)
        if design.table[-1][i] != design.table[-3][i]:
            yield Fault("P6", t_c, i)


def _target_shape_faults(tube: ExactTube, margin: Fraction) -> Iterator[Fault]:
    """Yield a fault of P5 where the tube's box at t_c leaves a target that is a ball or is cut by half-spaces."""
    task, end = tube.task, tube.signed_ends(-1)
    by = displacement_at(task, task.target_set, task.prescribed_time)
    low, high = ([sign * e[side] - d for e, d in zip(end, by, strict=True)] for sign, side in ((1, LOWER), (-1, UPPER)))

    def largest_along(normal: Sequence[Any]) -> Fraction:
        return sum((c * (high[i] if c > 0 else low[i]) for i, c in enumerate(normal)), Fraction(0))

    cuts = region_half_spaces(task, task.target_set)
    is_cut = any(largest_along(v) + margin * sum(map(abs, v)) > offset for v, offset in cuts)
    if leaves_target_ball(task, low, high, margin) or is_cut:
        yield Fault("P5", task.prescribed_time)


def _state_space_shape_faults(tube: ExactTube, margin: Fraction) -> Iterator[Fault]:
    """Yield faults of P3 where the tube's box, grown by the body, leaves a half-space that cuts the state space."""
    for normal, offset in region_half_spaces(tube.task, tube.task.state_space):
        inward = tuple(-c for c in normal)
        needed = sum((abs(c) * (tube.body[i] + margin) for i, c in enumerate(normal)), -offset)
        for _, time in _times_below(smallest_along(inward, tube.edges)[:, None], [[needed]], tube.unit):
            yield Fault("P3", time * tube.segment_seconds)


def _edge_faults(tube: ExactTube, margin: Fraction) -> Iterator[Fault]:
    """Yield faults of P1, of P3 in the box of the state space, and of P6 where a speed or acceleration is limited, by axis."""
    task, edges, unit, seconds = tube.task, tube.edges, tube.unit, tube.segment_seconds
    faces, slope = signed_faces(task.state_space), derivative(edges)  # the slope is per segment
    limited = [(slope, limit, seconds) for limit in (task.max_speed,) if limit is not None]
    limited += [(derivative(slope), limit, seconds**2) for limit in (task.max_acceleration,) if limit is not None]
    min_widths = by_axis(task.tube.min_width, task.dimension)
    for i in range(task.dimension):
        width = max(min_widths[i], SMALLEST_WIDTH) + 2 * margin
        for _, time in _times_below(-edges[:, i].sum(axis=1, keepdims=True), [[width]], unit):
            yield Fault("P1", time * seconds, i)
        for side in (LOWER, UPPER):
            edge = slice(side, side + 1)
            for _, time in _times_below(edges[:, i, edge], [[faces[i][side] + tube.body[i] + margin]], unit):
                yield Fault("P3", time * seconds, i)
            for rate, limit, per in limited:
                for sign in (1, -1):
                    for _, time in _times_below(sign * rate[:, i, edge], [[-limit[i] * per]], unit):
                        yield Fault("P6", time * seconds, i)


def _unsafe_faults(tube: ExactTube, margin: Fraction) -> Iterator[Fault]:
    """Yield faults of P4, where the tube's box, grown by body, clearance and margin, meets an unsafe set. Standing boxes
    first."""
    task, n, segments = tube.task, tube.task.dimension, len(tube.edges)
    clearances = by_axis(task.tube.clearance, n)
    growth = [v + c + margin for v, c in zip(tube.body, clearances, strict=True)]
    boxes = [j for j, s in enumerate(task.unsafe) if isinstance(s, UnsafeSet) and s.axes is None and not is_timed(s)]
    # outside a box: the lower edge above its upper face, or the upper edge below its lower face
    needed = [[-face + growth[i] for i in range(n) for face in reversed(signed_faces(task.unsafe[j])[i])] for j in boxes]
    for j, time in _times_below(tube.edges.reshape(segments, 2 * n, 4), needed, tube.unit):
        yield Fault("P4", time * tube.segment_seconds, unsafe=boxes[j])
    for j, unsafe in enumerate(task.unsafe):
        for time in _contact_times(task, unsafe, GrownTube(tube.edges, tube.unit, growth)) if j not in boxes else ():
            yield Fault("P4", time * tube.segment_seconds, unsafe=j)


def _contact_times(task: Task, unsafe: Any, tube: GrownTube) -> Iterable[Fraction]:
    """Return spline times at which the tube's grown box meets an unsafe set of any kind."""
    if is_timed(unsafe):
        return moving_contact_times(task, unsafe, tube)
    if is_round(unsafe):
        return round_contact_times(task, unsafe, tube)
    half_spaces = supporting_half_spaces(task, unsafe)
    cubics = np.stack([smallest_along(normal, tube.edges) for normal, _ in half_spaces], axis=1)
    needed = [offset + sum(abs(c) * tube.growth[i] for i, c in enumerate(normal)) for normal, offset in half_spaces]
    return (time for _, time in _times_below(cubics, [needed], tube.unit))


def smallest_along(normal: Sequence[int], edges: Integers) -> Any:
    """Return the smallest normal . x over the tube's box, as cubics (K, 4). edges: `signed_edges`."""
    total: Any = 0
    for i, c in enumerate(normal):
        total = total + abs(c) * edges[:, i, LOWER if c > 0 else UPPER].astype(object)
    return total


def derivative(polynomials: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Differentiate by s. Coefficients of 1, s, s^2, s^3 are on the last axis."""
    multiples = polynomials * np.arange(4)
    return np.concatenate([multiples[..., 1:], np.zeros_like(multiples[..., :1])], axis=-1)


def by_axis(value: Fraction | tuple[Fraction, ...], n: int) -> tuple[Fraction, ...]:
    """Return one number for each axis, of a number for all of them or a list."""
    return value if isinstance(value, tuple) else (value,) * n


def signed_faces(box: Box | UnsafeSet) -> list[tuple[Fraction, Fraction]]:
    """Return by dimension the lower face and minus the upper one. `signed_edges` of a tube inside the box are not below them."""
    return [(a, -b) for a, b in zip(box.lower, box.upper, strict=True)]


def signed_edges(design: RefinedDesign) -> Integers:
    """Return the lower edge, and minus the upper one, as coefficients of 1, s, s^2, s^3 in units of the table: (K, n, 2, 4)."""
    q = np.array(design.table, dtype=np.int64) * np.array([1, -1])
    q0, q1, q2, q3 = q[:-3], q[1:-2], q[2:-1], q[3:]
    return np.stack([q0 + 4 * q1 + q2, 3 * (q2 - q0), 3 * (q0 - 2 * q1 + q2), q3 - q0 + 3 * (q1 - q2)], axis=-1)


def _times_below(cubics: Integers, bounds: Sequence[Sequence[Fraction]], unit: Fraction) -> Iterator[tuple[int, Fraction]]:
    """Yield a row of bounds and a spline time (segment + s) at which all cubics are below their bounds of that row.

    cubics: (K, m, 4), in units; bounds: rows of m. There is at most one time for each row and segment."""
    lowest = eightfold_range(*np.moveaxis(cubics, -1, 0))[0]
    for j, row in enumerate(bounds):
        limit = EIGHTFOLD_LIMIT if cubics.dtype != object else EIGHTFOLD_LIMIT**4
        needed = np.array([max(-limit, min(limit, math.ceil(8 * b / unit))) for b in row], dtype=cubics.dtype)
        for k in np.flatnonzero(~(lowest >= needed).any(axis=1)):
            s = point_where_all_are_negative([less_bound(c, b / unit) for c, b in zip(cubics[k], row, strict=True)])
            if s is not None:
                yield j, int(k) + s
