"""The truth about a tube for a plant of order 2, besides P1 to P6 of `tubes.py`: from the statements about the filtered tube
alone, in fractions, with Sturm's theorem. Nothing of `stt_codegen` but the data of task and design.

With edges L < R, W = R - L, lambda by component, F all that pushes, and u as large as the C has it:

    P1   W' + lambda W >= 2^-20, below which the emitted law is another one: room for z = v + lambda x
    P2   at 0, z strictly between L' + lambda L and R' + lambda R for every start that is claimed
    P6   L and R are at rest at t_c: their first and second derivatives vanish
    P8   g_min u > F + max(lambda^2 W + L'', lambda^2 W - R'')

Where the last one fails strictly a state in the set leaves it whatever |u| <= u_max is; `leaving` finds one.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

from benchmarks.oracles.tubes import LEAST_WIDTH, Fault
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.task.task import Task

Poly = tuple[Fraction, ...]  # coefficients of 1, s, s^2, ..: the last one is not 0
WEIGHTS = ((1, -3, 3, -1), (4, 0, -6, 3), (1, 3, 3, -3), (0, 0, 0, 1))  # of four control points over 6, by powers of s
SIGNIFICANT = {"float": 24, "double": 53}  # bits of the C's numbers
HALF = Fraction(1, 2)


# ------------------------------------------------------------------------------------------------ polynomials


def poly(coefficients: Iterable[Fraction | int]) -> Poly:
    found = [Fraction(c) for c in coefficients]
    while found and not found[-1]:
        found.pop()
    return tuple(found)


def value(p: Poly, s: Fraction) -> Fraction:
    return reduce(lambda total, c: total * s + c, reversed(p), Fraction(0))


def plus(*parts: tuple[Fraction | int, Poly]) -> Poly:
    """The sum of multiples."""
    size = max(len(p) for _, p in parts)
    return poly(sum((f * p[j] for f, p in parts if j < len(p)), Fraction(0)) for j in range(size))


def slope(p: Poly) -> Poly:
    return poly(j * c for j, c in enumerate(p) if j)


def divided(p: Poly, q: Poly) -> tuple[Poly, Poly]:
    """Quotient and remainder."""
    left, found = list(p), [Fraction(0)] * max(len(p) - len(q) + 1, 0)
    for j in reversed(range(len(found))):
        found[j] = left[j + len(q) - 1] / q[-1]
        for m, c in enumerate(q):
            left[j + m] -= found[j] * c
    return poly(found), poly(left[: len(q) - 1])


def chain(p: Poly) -> list[Poly]:
    """Sturm's: p, p', and less the remainder of each two. The last one is their greatest common divisor."""
    found = [p, slope(p)]
    while found[-1]:
        found.append(plus((-1, divided(found[-2], found[-1])[1])))
    return found[:-1]


def changes(polynomials: Iterable[Poly], s: Fraction) -> int:
    signs = [v > 0 for v in (value(p, s) for p in polynomials) if v]
    return sum(a != b for a, b in itertools.pairwise(signs))


def roots_between(p: Poly, low: Fraction, high: Fraction) -> int:
    """How many real roots, each counted once; p is 0 at neither end."""
    found = chain(p)
    return changes(found, low) - changes(found, high)


def negative_place(p: Poly) -> Fraction | None:
    """A place s in [0, 1] where p < 0, of degree 3 at most; None where there is none."""
    zero, one = Fraction(0), Fraction(1)
    if not p:
        return None
    if p[0] + sum(min(c, zero) for c in p[1:]) >= 0:  # no term takes more away than that
        return None
    for end in (zero, one):
        if value(p, end) < 0:
            return end
    q = p
    while not q[0]:  # s and 1 - s do not change the sign within
        q = q[1:]
    while not value(q, one):
        q = divided(q, poly((1, -1)))[0]
    if q[0] < 0:
        return next(s for s in (HALF**j for j in range(1, 10_000)) if value(p, s) < 0)
    if value(q, one) < 0:
        return next(s for s in (1 - HALF**j for j in range(1, 10_000)) if value(p, s) < 0)
    if len(q) < 3 or len(chain(q)[-1]) > 1 or not roots_between(q, zero, one):
        return None  # a root that is there twice leaves a factor of degree 1 that is positive at both ends
    low, high = zero, one
    while True:  # two roots, and q is negative between them
        middle = (low + high) / 2
        if not value(q, middle):  # a simple root: on one side of it
            places = (middle + sign * HALF**j for j in range(1, 10_000) for sign in (1, -1))
            return next(s for s in places if low < s < high and value(q, s) < 0)
        if value(q, middle) < 0:
            return middle
        low, high = (low, middle) if roots_between(q, low, middle) else (middle, high)


def not_positive_place(p: Poly) -> Fraction | None:
    """A place in [0, 1] where p <= 0; None where there is none. A cubic that only touches 0 does so at a rational place."""
    if not p:
        return Fraction(0)
    if p[0] + sum(min(c, Fraction(0)) for c in p[1:]) > 0:
        return None
    found = negative_place(p)
    if found is not None:
        return found
    shared = chain(p)[-1] if len(p) > 2 else poly((1,))
    doubled = [-shared[0] / shared[1]] if len(shared) == 2 else [-shared[1] / (2 * shared[2])] if len(shared) == 3 else []
    return next((s for s in (Fraction(0), Fraction(1), *doubled) if 0 <= s <= 1 and not value(p, s)), None)


# ------------------------------------------------------------------------------------------------ the tube


@dataclass(frozen=True)
class Piece:
    """Of one component in one segment, on s in [0, 1]: L and R in the task's units, lambda, and segments a second."""

    lower: Poly
    upper: Poly
    rate: Fraction
    value: Fraction  # lambda

    def derived(self, p: Poly) -> Poly:
        """By time."""
        return plus((self.rate, slope(p)))

    @property
    def width(self) -> Poly:
        return plus((1, self.upper), (-1, self.lower))

    @property
    def room(self) -> Poly:
        """W' + lambda W."""
        return plus((1, self.derived(self.width)), (self.value, self.width))

    @property
    def pushes(self) -> tuple[Poly, Poly]:
        """lambda^2 W + L'' and lambda^2 W - R''."""
        low, high = (self.derived(self.derived(p)) for p in (self.lower, self.upper))
        held = self.value**2
        return plus((held, self.width), (1, low)), plus((held, self.width), (-1, high))


def piece(design: RefinedDesign, k: int, i: int) -> Piece:
    rows = design.table[k : k + 4]
    lower, upper = (
        poly(design.unit * sum(w[m] * row[i][side] for w, row in zip(WEIGHTS, rows, strict=True)) for m in range(4))
        for side in (0, 1)
    )
    return Piece(lower, upper, Fraction(design.segments) / design.prescribed_time, design.filter[i])


def emitted_limit(task: Task) -> list[Fraction]:
    """u_max as the C has it: the largest number of the scalar that is not above."""
    bits = SIGNIFICANT[task.emit.scalar]
    found = []
    for v in task.u_max or ():
        step = Fraction(2) ** (math.frexp(float(v))[1] - bits)
        step *= 2 if v / step >= 1 << bits else HALF if v / step < 1 << (bits - 1) else 1
        found.append(math.floor(v / step) * step)
    return found


def spare_input(task: Task) -> list[Fraction] | None:
    """g_min u - F by component, with the others' inputs as large as they may be; None where nothing is claimed of it."""
    plant = task.plant
    named = (plant.f_max, plant.w_max, plant.g_min, plant.g_max, plant.g_cross)
    if task.control.u_max is None or task.control.period is not None or all(v is None for v in named):
        return None
    u, force, cross = emitted_limit(task), (plant.f_max or 0) + (plant.w_max or 0), plant.g_cross or 0
    return [least_g(task) * v - force - cross * (sum(u) - v) for v in u]


def least_g(task: Task) -> Fraction:
    """1, or g_max where that is less, where the task does not say."""
    low, high = task.plant.g_min, task.plant.g_max
    return low if low is not None else Fraction(1) if high is None else min(Fraction(1), high)


def inertia_faults(
    task: Task, design: RefinedDesign, units: Fraction | int = 0, segments: Iterable[int] | None = None
) -> Iterator[Fault]:
    """Where order 2 is broken, with `units` of the table to spare in rates and accelerations of an edge (in a segment's time); in
    all segments or in some."""
    n, rate, t_c = task.dimension, Fraction(design.segments) / design.prescribed_time, design.prescribed_time
    spare, keep = spare_input(task), units * design.unit
    for i in range(n):
        first, last = piece(design, 0, i), piece(design, design.segments - 1, i)
        room = min(_start_room(task, first, i)) - keep * rate
        if room < 0 or (task.start_speed[i] and room == 0):  # of starts at rest none is on the edge
            yield Fault("P2 z" if room else "P2 z, on the edge", Fraction(0), i)
        for p in (last.lower, last.upper):
            once = last.derived(p)
            if value(once, Fraction(1)) or value(last.derived(once), Fraction(1)):
                yield Fault("P6", t_c, i)
        for k in range(design.segments) if segments is None else segments:
            here = piece(design, k, i)
            s = negative_place(plus((1, here.room), (-1, poly((LEAST_WIDTH + keep * rate,)))))
            if s is not None:
                yield Fault("P1 z", (k + s) / rate, i)
            for push in here.pushes if spare is not None else ():
                s = not_positive_place(plus((1, poly((spare[i] - keep * rate**2,))), (-1, push)))
                if s is not None:
                    yield Fault("P8", (k + s) / rate, i)


def _start_room(task: Task, first: Piece, i: int) -> tuple[Fraction, Fraction]:
    """By how much z is inside at 0 at least, at the lower edge and the upper one. At rest a start is anywhere between the edges,
    which only a rate away from the middle allows; with a speed it is in the share, its bounds too."""
    rates = [value(first.derived(p), Fraction(0)) for p in (first.lower, first.upper)]
    speed, width = task.start_speed[i], value(first.width, Fraction(0))
    inside = first.value * (1 - task.initial_set.share) / 2 * width - speed if speed else Fraction(0)
    return inside - rates[0], inside + rates[1]


def first_inertia_fault(
    task: Task, design: RefinedDesign, units: Fraction | int = 0, segments: Iterable[int] | None = None
) -> Fault | None:
    return next(inertia_faults(task, design, units, segments), None)


def hull_fault(task: Task, design: RefinedDesign, wrong: Fraction, units: int) -> str:
    """Which property the hull of a whole segment's Bezier coefficients does not show, W' + lambda W with `wrong` to spare and the
    input with `units`: why what is safe may be refused. Empty where it shows all."""
    spare, rate = spare_input(task), Fraction(design.segments) / design.prescribed_time
    for i in range(task.dimension):
        for k in range(design.segments):
            here = piece(design, k, i)
            if min(bezier(here.room)) < LEAST_WIDTH + wrong:
                return "P1 z"
            if spare is not None and max(v for p in here.pushes for v in bezier(p)) > spare[i] - units * design.unit * rate**2:
                return "P8"
    return ""


def bezier(p: Poly) -> list[Fraction]:
    """The control ordinates of degree 3."""
    a, b, c, d = (*p, *[Fraction(0)] * (4 - len(p)))
    return [a, a + b / 3, a + 2 * b / 3 + c / 3, a + b + c + d]


def greatest(design: RefinedDesign, i: int) -> Fraction:
    """The largest of both pushes of a component: a value taken, next to none below the largest."""
    found = []
    for k in range(design.segments):
        for p in piece(design, k, i).pushes:
            a, b, c = (float(v) for v in (*slope(p), *[Fraction(0)] * 3)[:3])
            root = math.sqrt(max(b * b - 4 * a * c, 0.0))
            flat = [(-b + sign * root) / (2 * c) for sign in (1, -1)] if c else [-a / b] if b else []
            places = [Fraction(0), Fraction(1), *(Fraction(s) for s in flat if 0 < s < 1)]
            found.append(max(value(p, s) for s in places))
    return max(found)


# ------------------------------------------------------------------------------------------------ leaving


@dataclass(frozen=True)
class Leaving:
    """A state within the tube and the filtered tube, of a component, that is outside the latter after `after` seconds under f + w
    = F and g = g_min towards an edge, whatever |u| <= u_max is. side: 1 for the upper edge, 0 for the lower one."""

    time: Fraction
    dimension: int
    side: int
    x: Fraction
    v: Fraction
    acceleration: Fraction  # the most that u does against it
    after: Fraction


def leaving(task: Task, design: RefinedDesign, fault: Fault) -> Leaving | None:
    """Where P8 fails: x next to the far edge, z next to the near one. None where z has no room there, or where the fault is that
    the two sides are equal, from which nothing leaves."""
    spare, rate, i = spare_input(task), Fraction(design.segments) / design.prescribed_time, fault.dimension
    assert spare is not None
    assert i is not None
    k = min(math.floor(fault.time * rate), design.segments - 1)
    s = fault.time * rate - k
    for nudged in (s, *(s + sign * HALF**j for j in range(4, 40) for sign in (1, -1))):
        if not 0 <= nudged < 1:
            continue
        for side in (1, 0):
            found = _leaves(piece(design, k, i), nudged, side, spare[i])
            if found is not None:
                x, v, after = found
                turned = -spare[i] if side else spare[i]
                return Leaving((k + nudged) / rate, i, side, x, v, turned, after)
    return None


def _leaves(here: Piece, s: Fraction, side: int, spare: Fraction) -> tuple[Fraction, Fraction, Fraction] | None:
    """x, v and how long it takes. The lower edge is the upper one of the tube upside down."""
    lower, upper = (here.lower, here.upper) if side else (plus((-1, here.upper)), plus((-1, here.lower)))
    up = Piece(lower, upper, here.rate, here.value)
    push, width = value(up.pushes[1], s), value(up.width, s)
    beyond = push - spare
    if beyond <= 0 or width <= 0 or value(up.room, s) <= 0:
        return None
    x = value(lower, s) + min(width / 2, beyond / (4 * here.value**2))
    edge = plus((1, up.derived(upper)), (here.value, upper))  # R' + lambda R
    for j in range(80):
        after = (1 - s) / here.rate * HALF**j
        near = min(after * beyond / 8, value(up.room, s) / 2)
        v = value(edge, s) - here.value * x - near
        then = v - spare * after, x + v * after - spare * after**2 / 2
        if then[0] + here.value * then[1] >= value(edge, s + after * here.rate):
            return (x, v, after) if side else (-x, -v, after)
    return None
