"""The truth about unsafe sets that move, for `tubes.py`: one clock error at a time.

A clock that is wrong by a constant c shows tau = t + c. With it the set is C + d(t + c), grown by spread * tau, while tau is in
its active interval. For a few clock errors within the timing uncertainty the tube is compared with that set, exactly: between two
times at which motion, growth or activity changes every condition is a cubic. So a fault may be missed, and no false one is
reported. Nothing is shared with `stt_codegen.task.sets.motion` or `stt_codegen.certify`: no legs, no hulls of positions.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from flint import fmpz_poly

from benchmarks.oracles.cubics import point_where_all_are_negative
from benchmarks.oracles.shapes import (
    GrownTube,
    bounded_axes,
    distances_to_segment,
    is_nearer,
    is_round,
    point_on_segment,
    supporting_half_spaces,
    to_exact,
)
from stt_codegen.task.task import Task

# Clock errors that are compared, as shares of the interval of errors that the task allows.
ERROR_SHARES = (Fraction(0), Fraction(1), Fraction(1, 2), Fraction(1, 5), Fraction(7, 9))
SAMPLES_PER_STRETCH = 12  # at which distances to round sets are compared first
CANDIDATES = 3  # samples around which the smallest distance is searched for
ALWAYS = 10**9  # seconds, beyond every task
Polynomial = list[Fraction]  # coefficients of 1, s, s^2, ..


class Stretch(NamedTuple):
    """A part of a segment, from s = begin to s = end, in which displacement and growth of a set are linear in time."""

    segment: int
    begin: Fraction
    end: Fraction


class Pose(NamedTuple):
    """Where a set is at one time: its displacement in all dimensions, and by how much it has grown."""

    displacement: list[Fraction]
    growth: Fraction


def is_timed(unsafe: Any) -> bool:
    """Whether an unsafe set moves, grows or has an active interval."""
    return unsafe.motion is not None or unsafe.during is not None or bool(unsafe.spread)


def displacement_at(task: Task, table: Any, tau: Fraction) -> list[Fraction]:
    """Return the displacement d(tau) of a set in all dimensions; a set without motion has none."""
    displacement = [Fraction(0)] * task.dimension
    for k, i in enumerate(bounded_axes(task, table)):
        points = [(p.at, p.by[k]) for p in table.motion or ()]
        if points:
            displacement[i] = _interpolate(points, tau)
    return displacement


def _interpolate(points: Sequence[tuple[Fraction, Fraction]], tau: Fraction) -> Fraction:
    """Interpolate linearly between points (time, value), in the order of their times; the end values hold outside."""
    if tau <= points[0][0]:
        return points[0][1]
    if tau >= points[-1][0]:
        return points[-1][1]
    m = max(j for j, (time, _) in enumerate(points) if time <= tau)
    (a, v), (b, w) = points[m], points[m + 1]
    return v + (w - v) * (tau - a) / (b - a)


@dataclass(frozen=True)
class ClockedSet:
    """An unsafe set of a task as it moves when its clock is ahead by `clock_error` seconds, beside a tube of so many segments."""

    task: Task
    unsafe: Any
    clock_error: Fraction
    segments: int

    def stretches(self) -> Iterator[Stretch]:
        """Yield the stretches between all times at which something changes, while the set is active."""
        t_c, seconds = self.task.prescribed_time, self.task.prescribed_time / self.segments
        first, last = self.unsafe.during or (-ALWAYS, ALWAYS)
        last = ALWAYS if last == t_c else last  # a set that is active until t_c stays for ever
        begin, end = max(Fraction(0), first - self.clock_error), min(t_c, last - self.clock_error)
        changes = [-self.clock_error, *(p.at - self.clock_error for p in self.unsafe.motion or ())]  # growth begins at tau = 0
        joints = [k * seconds for k in range(self.segments + 1)]
        times = sorted({begin, end, *(t for t in (*changes, *joints) if begin < t < end)})
        for a, b in itertools.pairwise(times if begin < end else []):
            k = min(math.floor(a / seconds), self.segments - 1)
            yield Stretch(k, a / seconds - k, b / seconds - k)

    def poses(self, stretch: Stretch) -> tuple[Pose, Pose]:
        """Return where the set is at both ends of a stretch."""
        first, last = (self._pose(stretch.segment + s) for s in (stretch.begin, stretch.end))
        return first, last

    def _pose(self, spline_time: Fraction) -> Pose:
        tau = spline_time * self.task.prescribed_time / self.segments + self.clock_error
        growth = (self.unsafe.spread or Fraction(0)) * max(tau, Fraction(0))
        return Pose(displacement_at(self.task, self.unsafe, tau), growth)


def moving_contact_times(task: Task, unsafe: Any, tube: GrownTube) -> Iterator[Fraction]:
    """Yield spline times (segment + s) at which the tube's grown box meets an unsafe set that moves."""
    timing, delay = unsafe.timing or Fraction(0), task.start_delay
    contact_times = _round_contact_times if is_round(unsafe) else _polytope_contact_times
    for share in ERROR_SHARES if timing or delay else ERROR_SHARES[:1]:
        clock_error = -timing + share * (2 * timing + delay)
        yield from contact_times(ClockedSet(task, unsafe, clock_error, len(tube.edges)), tube)


# ------------------------------------------------------------------------------------------------ polytopes


def _polytope_contact_times(moving: ClockedSet, tube: GrownTube) -> Iterator[Fraction]:
    """Yield the spline times at which the tube's box is on the inner side of every half-space around the polytope."""
    axes = bounded_axes(moving.task, moving.unsafe)
    half_spaces = supporting_half_spaces(moving.task, moving.unsafe)
    for stretch in moving.stretches():
        k, begin, end = stretch
        poses = moving.poses(stretch)
        gaps = []
        for normal, support in half_spaces:
            gap = _rescaled(_smallest_along(normal, tube, k), begin, end)
            size = sum(abs(normal[i]) for i in axes)
            grown = support + sum(abs(c) * g for c, g in zip(normal, tube.growth, strict=True))
            offsets = [
                grown + sum(c * d for c, d in zip(normal, pose.displacement, strict=True)) + size * pose.growth for pose in poses
            ]
            gap[0] -= offsets[0]
            gap[1] -= offsets[1] - offsets[0]
            gaps.append(gap)
        s = point_where_all_are_negative([_with_integers(gap) for gap in gaps])
        if s is not None:
            yield k + begin + (end - begin) * s


def _smallest_along(normal: Sequence[int], tube: GrownTube, segment: int) -> Polynomial:
    """Return the smallest normal . x over the tube's box (not grown), as a cubic of a segment."""
    total = [Fraction(0)] * 4
    for i, c in enumerate(normal):
        if c:
            for p, v in enumerate(tube.edges[segment, i, 0 if c > 0 else 1].tolist()):
                total[p] += abs(c) * int(v) * tube.unit
    return total


def _rescaled(cubic: Polynomial, begin: Fraction, end: Fraction) -> Polynomial:
    """Return the cubic whose values on [0, 1] are those of this one on [begin, end]."""
    rescaled = [Fraction(0)] * 4
    for p, v in enumerate(cubic):
        for q in range(p + 1):
            rescaled[q] += v * math.comb(p, q) * begin ** (p - q) * (end - begin) ** q
    return rescaled


def _with_integers(polynomial: Polynomial) -> fmpz_poly:
    """Return a positive multiple that has integer coefficients."""
    scale = math.lcm(*(v.denominator for v in polynomial))
    return fmpz_poly([int(v * scale) for v in polynomial])


# ------------------------------------------------------------------------------------------------ balls and capsules


class _Distances:
    """Distances in doubles from the axis of a moving ball or capsule to the tube's grown box, less the set's growth."""

    def __init__(self, moving: ClockedSet, tube: GrownTube, stretches: Sequence[Stretch], ends: Sequence[Any]) -> None:
        axes = bounded_axes(moving.task, moving.unsafe)
        poses = [moving.poses(stretch) for stretch in stretches]
        self.line = np.array(ends, dtype=float)
        self.cubics = tube.edges[:, axes].astype(float) * float(tube.unit)
        self.tube_growth = np.array([[float(tube.growth[i])] * 2 for i in axes])
        self.segments = np.array([stretch.segment for stretch in stretches])
        self.spans = np.array([[float(stretch.begin), float(stretch.end)] for stretch in stretches])
        self.displacements = np.array([[[float(pose.displacement[i]) for i in axes] for pose in pair] for pair in poses])
        self.set_growth = np.array([[float(pose.growth) for pose in pair] for pair in poses])

    def at(self, m: Any, share: Any) -> tuple[Any, Any]:
        """Return distances at shares of the stretches m, and shares of the set's axis at which they are taken."""
        s = self.spans[m, 0] + share * (self.spans[m, 1] - self.spans[m, 0])
        edge = np.einsum("pdec,pc->ped", self.cubics[self.segments[m]], s[:, None] ** np.arange(4)) - self.tube_growth.T
        first, last = self.displacements[m, 0], self.displacements[m, 1]
        by = first + share[:, None] * (last - first)
        distance, along = distances_to_segment(self.line, edge[:, 0] - by, -edge[:, 1] - by)
        return distance - self.set_growth[m, 0] - share * (self.set_growth[m, 1] - self.set_growth[m, 0]), along


def _round_contact_times(moving: ClockedSet, tube: GrownTube) -> Iterator[Fraction]:
    """Yield a spline time at which a ball or capsule is, exactly, nearer to the tube than its radius, where doubles lead to one.
    Yields at most one."""
    unsafe = moving.unsafe
    ends = list(unsafe.segment) if hasattr(unsafe, "segment") else [unsafe.centre] * 2
    stretches = list(moving.stretches())
    if not stretches:
        return
    distances = _Distances(moving, tube, stretches, ends)
    m = np.repeat(np.arange(len(stretches)), SAMPLES_PER_STRETCH + 1)
    sample_shares = np.tile(np.linspace(0, 1, SAMPLES_PER_STRETCH + 1), len(stretches))
    sampled, along = distances.at(m, sample_shares)
    for q in np.argsort(sampled)[:CANDIDATES]:
        if sampled[q] > float(unsafe.radius) + 0.01:
            break
        best_share, best_along = sample_shares[q : q + 1], along[q : q + 1]
        for width in np.geomspace(1 / SAMPLES_PER_STRETCH, 1e-9, 40):
            tries = np.clip(best_share[0] + width * np.linspace(-1, 1, 9), 0, 1)
            values, tried_along = distances.at(np.full(9, m[q]), tries)
            w = int(values.argmin())
            best_share, best_along = tries[w : w + 1], tried_along[w : w + 1]
        time = _exact_contact(moving, tube, stretches[int(m[q])], ends, (to_exact(best_share[0]), to_exact(best_along[0])))
        if time is not None:
            yield time
            return


def _exact_contact(
    moving: ClockedSet, tube: GrownTube, stretch: Stretch, ends: Sequence[Any], shares: tuple[Fraction, Fraction]
) -> Fraction | None:
    """Return the spline time at a share of a stretch if there, at a share of its axis, the set is nearer than its radius; else
    None. shares: of the stretch, of the axis."""
    share, along = shares
    axes = bounded_axes(moving.task, moving.unsafe)
    first, last = moving.poses(stretch)
    by = [first.displacement[i] + share * (last.displacement[i] - first.displacement[i]) for i in axes]
    moved = [tuple(v + d for v, d in zip(p, by, strict=True)) for p in ends]
    radius = moving.unsafe.radius + first.growth + share * (last.growth - first.growth)
    s = stretch.begin + (stretch.end - stretch.begin) * share
    if is_nearer(tube.box(stretch.segment, s, axes), point_on_segment(moved, along), radius):
        return stretch.segment + s
    return None
