"""The truth about unsafe sets that move, for `tubes.py`: one clock at a time.

A clock that is wrong by a constant c shows tau = t + c. With it the set is C + d(t + c), grown by spread tau, while tau is in its
window. For a handful of clocks within the doubt the tube is compared with that set, exactly: between two times at which something
turns every condition is a cubic. So a fault may be missed, and none is invented. Nothing is shared with
`stt_codegen.task.sets.motion` or `stt_codegen.certify`: no legs, no hulls of places.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from flint import fmpz_poly

from benchmarks.oracles.shapes import BITS, bounds_of, is_round, nearer, nearest, own_axes
from stt_codegen.task.task import Task

CLOCKS = (Fraction(0), Fraction(1), Fraction(1, 2), Fraction(1, 5), Fraction(7, 9))  # shares of the doubt
SAMPLES = 12  # times of a stretch at which distances to round sets are looked at
Polynomial = list[Fraction]  # by powers
Uncovered = Callable[[Any], Any]  # where polynomials are all negative


def is_timed(unsafe: Any) -> bool:
    return unsafe.motion is not None or unsafe.during is not None or bool(unsafe.spread)


def displaced(task: Task, unsafe: Any, tau: Fraction) -> list[Fraction]:
    """d(tau) in all dimensions."""
    found = [Fraction(0)] * task.dimension
    own, motion = own_axes(task, unsafe), unsafe.motion or ()
    for k, i in enumerate(own):
        points = [(p.at, p.by[k]) for p in motion]
        if not points:
            continue
        if tau <= points[0][0]:
            found[i] = points[0][1]
        elif tau >= points[-1][0]:
            found[i] = points[-1][1]
        else:
            m = max(j for j, (at, _) in enumerate(points) if at <= tau)
            (a, v), (b, w) = points[m], points[m + 1]
            found[i] = v + (w - v) * (tau - a) / (b - a)
    return found


def stretches(task: Task, unsafe: Any, clock: Fraction, segments: int) -> Iterator[tuple[int, Fraction, Fraction]]:
    """Segments, and from where to where in them (0 to 1), between all times at which something turns, while the set is unsafe."""
    t_c, per = task.prescribed_time, task.prescribed_time / segments
    first, last = unsafe.during or (-(10**9), 10**9)
    last = 10**9 if last == t_c else last  # a window that ends at t_c stays closed
    begin, end = max(Fraction(0), first - clock), min(t_c, last - clock)
    turns = [-clock, *(p.at - clock for p in unsafe.motion or ())]  # at -clock growth begins
    cuts = sorted(
        {begin, end, *(v for v in turns if begin < v < end), *(k * per for k in range(segments + 1) if begin < k * per < end)}
    )
    for a, b in itertools.pairwise(cuts if begin < end else []):
        k = min(math.floor(a / per), segments - 1)
        yield k, a / per - k, b / per - k


def moving_faults(
    task: Task, unsafe: Any, edges: Any, unit: Fraction, grow: Sequence[Fraction], uncovered: Uncovered
) -> Iterator[Fraction]:
    """Spline times at which the tube's box, grown by `grow`, meets a set that moves. edges: `truth.signed_edges`."""
    timing, delay = unsafe.timing or Fraction(0), task.start_delay
    for share in CLOCKS if timing or delay else CLOCKS[:1]:
        clock = -timing + share * (2 * timing + delay)
        found = _round if is_round(unsafe) else _flat
        yield from found(task, unsafe, edges, unit, grow, clock, uncovered)


def _line(task: Task, unsafe: Any, k: int, a: Fraction, b: Fraction, segments: int, clock: Fraction) -> list[Any]:
    """Displacement and growth at both ends of a stretch; in its inside, where they may turn at an end."""
    per = task.prescribed_time / segments
    found = []
    for s in (a, b):
        tau = (k + s) * per + clock
        found.append((displaced(task, unsafe, tau), (unsafe.spread or Fraction(0)) * max(tau, Fraction(0))))
    return found


def _flat(
    task: Task,
    unsafe: Any,
    edges: Any,
    unit: Fraction,
    grow: Sequence[Fraction],
    clock: Fraction,
    uncovered: Uncovered,
) -> Iterator[Fraction]:
    bounds, segments, own = bounds_of(task, unsafe), len(edges), own_axes(task, unsafe)
    for k, a, b in stretches(task, unsafe, clock, segments):
        (first, small), (last, large) = _line(task, unsafe, k, a, b, segments, clock)
        conditions = []
        for normal, support in bounds:
            total = [Fraction(0)] * 4
            for i, c in enumerate(normal):
                if c:
                    for p, v in enumerate(edges[k, i, 0 if c > 0 else 1].tolist()):
                        total[p] += abs(c) * int(v) * unit
            total = within(total, a, b)
            size = sum(abs(normal[i]) for i in own)
            ends = [
                support + sum(c * d for c, d in zip(normal, by, strict=True)) + size * growth
                + sum(abs(c) * g for c, g in zip(normal, grow, strict=True))
                for by, growth in ((first, small), (last, large))
            ]  # fmt: skip
            total[0] -= ends[0]
            total[1] -= ends[1] - ends[0]
            conditions.append(total)
        s = uncovered([_whole(p) for p in conditions])
        if s is not None:
            yield k + a + (b - a) * s


def within(cubic: Polynomial, a: Fraction, b: Fraction) -> Polynomial:
    """The same values with a at 0 and b at 1."""
    found = [Fraction(0)] * 4
    for p, v in enumerate(cubic):
        for q in range(p + 1):
            found[q] += v * math.comb(p, q) * a ** (p - q) * (b - a) ** q
    return found


def _whole(polynomial: Polynomial) -> fmpz_poly:
    scale = math.lcm(*(v.denominator for v in polynomial))
    return fmpz_poly([int(v * scale) for v in polynomial])


def _round(
    task: Task,
    unsafe: Any,
    edges: Any,
    unit: Fraction,
    grow: Sequence[Fraction],
    clock: Fraction,
    _uncovered: Uncovered,
) -> Iterator[Fraction]:
    """Where, sought in doubles, a ball or capsule is exactly nearer than its radius."""
    own, segments = own_axes(task, unsafe), len(edges)
    ends = list(unsafe.segment) if hasattr(unsafe, "segment") else [unsafe.centre] * 2
    line, parts = np.array(ends, dtype=float), list(stretches(task, unsafe, clock, segments))
    if not parts:
        return
    cubics = edges[:, own].astype(float) * float(unit)
    margin = np.array([[float(grow[i])] * 2 for i in own])
    told = [_line(task, unsafe, k, a, b, segments, clock) for k, a, b in parts]
    places = np.array([[[float(by[i]) for i in own] for by, _ in one] for one in told])
    growth = np.array([[float(g) for _, g in one] for one in told])
    where, spans = np.array([k for k, _, _ in parts]), np.array([[float(a), float(b)] for _, a, b in parts])

    def lack(m: Any, r: Any) -> tuple[Any, Any]:
        s = spans[m, 0] + r * (spans[m, 1] - spans[m, 0])
        edge = np.einsum("pdec,pc->ped", cubics[where[m]], s[:, None] ** np.arange(4)) - margin.T
        by = places[m, 0] + r[:, None] * (places[m, 1] - places[m, 0])
        distance, place = nearest(line, edge[:, 0] - by, -edge[:, 1] - by)
        return distance - growth[m, 0] - r * (growth[m, 1] - growth[m, 0]), place

    m, r = np.repeat(np.arange(len(parts)), SAMPLES + 1), np.tile(np.linspace(0, 1, SAMPLES + 1), len(parts))
    found, place = lack(m, r)
    for q in np.argsort(found)[:3]:
        if found[q] > float(unsafe.radius) + 0.01:
            break
        best_r, best_p = r[q : q + 1], place[q : q + 1]
        for width in np.geomspace(1 / SAMPLES, 1e-9, 40):
            tries = np.clip(best_r[0] + width * np.linspace(-1, 1, 9), 0, 1)
            values, there = lack(np.full(9, m[q]), tries)
            w = int(values.argmin())
            best_r, best_p = tries[w : w + 1], there[w : w + 1]
        share, along = (Fraction(round(float(v) * (1 << BITS)), 1 << BITS) for v in (best_r[0], best_p[0]))
        k, a, b = parts[int(m[q])]
        (first, small), (last, large) = told[int(m[q])]
        by = [first[i] + share * (last[i] - first[i]) for i in own]
        moved = [tuple(v + d for v, d in zip(p, by, strict=True)) for p in ends]
        radius, time = unsafe.radius + small + share * (large - small), a + (b - a) * share
        if nearer(edges[k][own], unit, [grow[i] for i in own], moved, radius, time, along):
            yield k + time
            return
