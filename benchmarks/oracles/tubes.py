"""The truth about a refined tube, for judging its certificate: P1 to P6 for the exact edges, by roots of polynomials.

On every segment each edge is a cubic in s in [0, 1] with exact coefficients, and every property says: at every s, at least
one of a few polynomials is >= 0. Where that fails it fails on an open interval between two neighbouring roots, so it is
enough to isolate the real roots (exactly, by Arb) and to take exact signs at one rational point between each two. Nothing
is shared with `stt_codegen.certify`: no Bezier hull, no halving, no tolerance.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import fmpq, fmpz_poly

from benchmarks.oracles.moving_sets import displaced, is_timed, moving_faults
from benchmarks.oracles.shapes import beyond_ball, bounds_of, cuts_of, is_round, round_places
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.designs.tube import LOWER, UPPER
from stt_codegen.task.sets.shapes import Box, UnsafeSet
from stt_codegen.task.task import Task

Integers = npt.NDArray[np.int64]
LEAST_WIDTH = Fraction(1, 1 << 20)  # the emitted law is another one in a narrower tube
ENDS = fmpz_poly([0, 1, -1])  # s (1 - s): 0 and 1 as roots
FAR = 1 << 40  # beyond 8 times every edge


class Undecided(Exception):
    """Roots that could not be told apart; Arb promises that this does not happen."""


@dataclass(frozen=True)
class Fault:
    """A property that fails, and an exact time (seconds) where it does; dimension and unsafe set count from 0."""

    code: str
    time: Fraction
    dimension: int | None = None
    unsafe: int | None = None


def first_fault(task: Task, design: RefinedDesign, room: Fraction = Fraction(0)) -> Fault | None:
    """None when P1 to P6 hold with `room` to spare (task's units; twice that in the width, none for P6)."""
    return next(faults(task, design, room), None)


def faults(task: Task, design: RefinedDesign, room: Fraction = Fraction(0)) -> Iterator[Fault]:
    """Where the tube breaks a property: a witness for every segment that does, of P6's kink and of P2 for every dimension.

    Sets are closed, so an edge may lie on a bound, but x(0) must be strictly inside gamma(0): the law is singular there.
    """
    n, unit, segments = design.dimension, design.unit, design.segments
    scale = design.prescribed_time / segments
    body = task.body or (Fraction(0),) * n
    edges = signed_edges(design)
    start = [[int(edges[0, i, side, 0]) * unit for side in (LOWER, UPPER)] for i in range(n)]
    end = [[int(edges[-1, i, side].sum()) * unit for side in (LOWER, UPPER)] for i in range(n)]
    first = signed_faces(task.initial_set)
    by = displaced(task, task.target_set, task.prescribed_time)
    last = [(end[i][0] - 1, end[i][1] - 1) for i in range(n)]  # no box: nothing is asked of the edges
    if task.target_set.lower:
        last = [(low + by[i], high - by[i]) for i, (low, high) in enumerate(signed_faces(task.target_set))]
    for i, x in enumerate(task.initial_state):
        slack = min(x - start[i][LOWER], -x - start[i][UPPER])
        if slack <= 0 or slack < room or any(start[i][side] < first[i][side] + room for side in (LOWER, UPPER)):
            yield Fault("P2", Fraction(0), i)
        if any(end[i][side] < last[i][side] + room for side in (LOWER, UPPER)):
            yield Fault("P5", design.prescribed_time, i)
        if design.table[-1][i] != design.table[-3][i]:
            yield Fault("P6", design.prescribed_time, i)

    low, high = ([sign * e[side] - d for e, d in zip(end, by, strict=True)] for sign, side in ((1, LOWER), (-1, UPPER)))
    farthest = ((sum((c * (high[i] if c > 0 else low[i]) for i, c in enumerate(v)), Fraction(0)), v, h)
                for v, h in cuts_of(task, task.target_set))  # fmt: skip
    if beyond_ball(task, low, high, room) or any(most + room * sum(map(abs, v)) > h for most, v, h in farthest):
        yield Fault("P5", design.prescribed_time)
    for normal, offset in cuts_of(task, task.state_space):
        inward = tuple(-c for c in normal)
        needed = sum((abs(c) * (body[i] + room) for i, c in enumerate(normal)), -offset)
        for _, u in open_places(beyond_of(inward, edges)[:, None], [[needed]], unit):
            yield Fault("P3", u * scale)

    free = signed_faces(task.state_space)
    slope = derivative(edges)  # times 1/s
    limited = [(slope, most, scale) for most in (task.max_speed,) if most is not None]
    limited += [(derivative(slope), most, scale**2) for most in (task.max_acceleration,) if most is not None]
    for i in range(n):
        width = max(task.tube.min_width, LEAST_WIDTH) + 2 * room
        for _, u in open_places(-edges[:, i].sum(axis=1, keepdims=True), [[width]], unit):
            yield Fault("P1", u * scale, i)
        for side in (LOWER, UPPER):
            one = slice(side, side + 1)
            for _, u in open_places(edges[:, i, one], [[free[i][side] + body[i] + room]], unit):
                yield Fault("P3", u * scale, i)
            for rate, most, per in limited:
                for sign in (1, -1):
                    for _, u in open_places(sign * rate[:, i, one], [[-most[i] * per]], unit):
                        yield Fault("P6", u * scale, i)

    yield from _unsafe_faults(task, edges, unit, scale, room)


def _unsafe_faults(task: Task, edges: Integers, unit: Fraction, scale: Fraction, room: Fraction) -> Iterator[Fault]:
    """Where the tube, grown by clearance and `room`, meets an unsafe set."""
    n, segments = task.dimension, len(edges)
    body = task.body or (Fraction(0),) * n
    keep = task.tube.clearance + room
    # outside a set: the lower edge above its upper face, or the upper edge below its lower face
    boxes = [j for j, s in enumerate(task.unsafe) if isinstance(s, UnsafeSet) and s.axes is None and not is_timed(s)]
    walls = [[-face + body[i] + keep for i in range(n) for face in reversed(signed_faces(task.unsafe[j])[i])] for j in boxes]
    for j, u in open_places(edges.reshape(segments, 2 * n, 4), walls, unit):
        yield Fault("P4", u * scale, unsafe=boxes[j])
    for j, s in enumerate(task.unsafe):
        if j in boxes:
            continue
        places: Iterable[Fraction]
        if is_timed(s):
            places = moving_faults(task, s, edges, unit, [body[i] + keep for i in range(n)], uncovered)
        elif is_round(s):
            places = round_places(task, s, edges, unit, [body[i] + keep for i in range(n)])
        else:
            bounds = bounds_of(task, s)
            beyond = np.stack([beyond_of(normal, edges) for normal, _ in bounds], axis=1)
            needed = [h + sum(abs(c) * (body[i] + keep) for i, c in enumerate(normal)) for normal, h in bounds]
            places = (u for _, u in open_places(beyond, [needed], unit))
        for u in places:
            yield Fault("P4", u * scale, unsafe=j)


def beyond_of(normal: Sequence[int], edges: Integers) -> Any:
    """The least of normal.x over the tube's box, as cubics (K, 4)."""
    total: Any = 0
    for i, c in enumerate(normal):
        total = total + abs(c) * edges[:, i, LOWER if c > 0 else UPPER].astype(object)
    return total


def derivative(polynomials: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """By powers of s on the last axis, with respect to s."""
    found = polynomials * np.arange(4)
    return np.concatenate([found[..., 1:], np.zeros_like(found[..., :1])], axis=-1)


def signed_faces(box: Box | UnsafeSet) -> list[tuple[Fraction, Fraction]]:
    """By dimension the lower face and minus the upper one: `signed_edges` of what lies within are not below them."""
    return [(a, -b) for a, b in zip(box.lower, box.upper, strict=True)]


def signed_edges(design: RefinedDesign) -> Integers:
    """The lower edge, and minus the upper one, as coefficients of 1, s, s^2, s^3 in units of the table: (K, n, 2, 4)."""
    q = np.array(design.table, dtype=np.int64) * np.array([1, -1])
    q0, q1, q2, q3 = q[:-3], q[1:-2], q[2:-1], q[3:]
    return np.stack([q0 + 4 * q1 + q2, 3 * (q2 - q0), 3 * (q0 - 2 * q1 + q2), q3 - q0 + 3 * (q1 - q2)], axis=-1)


def open_places(cubics: Integers, bounds: Sequence[Sequence[Fraction]], unit: Fraction) -> Iterator[tuple[int, Fraction]]:
    """For each row j of bounds and each segment k (cubics: (K, m, 4), rows of m bounds): j and a spline time u in
    [k, k + 1] at which each of the m cubics is below its bound, where there is one."""
    least = eightfold_range(*np.moveaxis(cubics, -1, 0))[0]
    for j, row in enumerate(bounds):
        far = FAR if cubics.dtype != object else FAR**4
        needed = np.array([max(-far, min(far, math.ceil(8 * b / unit))) for b in row], dtype=cubics.dtype)
        for k in np.flatnonzero(~(least >= needed).any(axis=1)):
            s = uncovered([above(c, b / unit) for c, b in zip(cubics[k], row, strict=True)])
            if s is not None:
                yield j, int(k) + s


def eightfold_range(a0: Any, a1: Any, a2: Any, a3: Any) -> tuple[Any, Any]:
    """Bounds below and above 8 times a0 + a1 s + a2 s^2 + a3 s^3 on [0, 1], from its coefficients in y = 2 s - 1."""
    middle, even = 8 * a0 + 4 * a1 + 2 * a2 + a3, 2 * a2 + 3 * a3
    odd = abs(4 * a1 + 4 * a2 + 3 * a3) + abs(a3)
    return middle - odd + (even - abs(even)) // 2, middle + odd + (even + abs(even)) // 2


def above(cubic: Sequence[Any], bound: Fraction) -> fmpz_poly:
    """An integer polynomial with the sign of cubic - bound."""
    return fmpz_poly([int(a) * bound.denominator for a in cubic]) - bound.numerator


def uncovered(polynomials: Sequence[fmpz_poly]) -> Fraction | None:
    """A place s in [0, 1] where all these cubics with integer coefficients are negative; None when there is none."""
    product, doubtful = ENDS, []
    for p in polynomials:
        low, high = eightfold_range(*(int(p[i]) for i in range(4)))
        if low >= 0:
            return None
        if high >= 0:  # else negative throughout: no help anywhere
            doubtful.append(p)
            product *= p
    for s in between_roots(product // product.gcd(product.derivative())):  # each root once, shared ones too
        if all(p(s) < 0 for p in doubtful):
            return fraction(s)
    return None


def between_roots(polynomial: fmpz_poly) -> list[fmpq]:
    """A rational point of (0, 1) between each two neighbouring real roots; 0 and 1 must be roots and all roots simple."""
    ends = sorted((r.mid().fmpq() - r.rad().fmpq(), r.mid().fmpq() + r.rad().fmpq()) for r in real_roots(polynomial))
    if any(right >= left for (_, right), (left, _) in itertools.pairwise(ends)):
        raise Undecided(str(polynomial))
    points = [(right + left) / 2 for (_, right), (left, _) in itertools.pairwise(ends)]
    return [s for s in points if 0 < s < 1]


def real_roots(polynomial: fmpz_poly) -> list[Any]:
    """Balls around the real roots. Arb proves them apart, and gives a real root an imaginary part of exactly 0."""
    roots: Any = polynomial.complex_roots()  # with multiplicities, which the library's types leave out
    return [root.real for root, _ in roots if root.imag == 0]


def deepest(cubics: Iterable[Any]) -> tuple[int, Fraction, Fraction]:
    """Which of these cubics is least on [0, 1], where and how small: a value taken, less than 2^-40 of the coefficients
    above the least."""
    found = []
    for k, cubic in enumerate(cubics):
        p = fmpz_poly([int(a) for a in cubic])
        flat = [r.mid().fmpq() for r in real_roots(p.derivative())] if p.degree() > 1 else []
        s = min((fmpq(0), fmpq(1), *(m for m in flat if 0 < m < 1)), key=p)
        found.append((p(s), k, s))
    value, k, s = min(found)
    return k, fraction(s), fraction(value)


def fraction(value: fmpq) -> Fraction:
    return Fraction(int(value.p), int(value.q))
