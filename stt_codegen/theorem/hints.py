"""What helps Coq with P9, and is not believed: by window and component a bound on |u|, and one on the logarithm in it; and into
how many cells the range of a width must be cut.

A window is a segment, or the time from t_c on. The bounds are those of docs/certificate-format.md, a little larger.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from fractions import Fraction

from stt_codegen.sampling import emitted_input
from stt_codegen.theorem.reading import Facts, Sampling

BITS, ROOM = 24, 1 + Fraction(1, 1 << 20)
CELLS, ROUGH = (1, 2, 4, 8, 16, 32, 64, 128), 2.0**-16
LOG = Fraction(1, 1 << 16)  # by so much exp is known too little, see proof/HeldLaw.v
Hint = tuple[Fraction, Fraction]


def bezier(facts: Facts, k: int, i: int, side: int) -> tuple[int, int, int, int]:
    """Coefficients of an edge in segment k, in units of the table."""
    a, b, c, d = (facts.table[k + j][i][side] for j in range(4))
    return a + 4 * b + c, 4 * b + 2 * c, 2 * b + 4 * c, b + 4 * c + d


def steps(facts: Facts) -> list[int]:
    """The largest difference of neighbouring Bezier coefficients, by dimension."""
    edges = [[bezier(facts, k, i, side) for k in range(facts.segments) for side in (0, 1)] for i in range(facts.n)]
    return [max(abs(b - a) for edge in own for a, b in itertools.pairwise(edge)) for own in edges]


def widths(facts: Facts, i: int) -> list[tuple[Fraction, Fraction]]:
    """The least and the largest width in every window."""
    spans = [[b - a for a, b in zip(bezier(facts, k, i, 0), bezier(facts, k, i, 1), strict=True)] for k in range(facts.segments)]
    spans.append([spans[-1][3]])
    return [(facts.unit * min(span), facts.unit * max(span)) for span in spans]


def speeds(facts: Facts, i: int) -> list[Fraction]:
    """How fast an edge is in every window and the one before."""
    edges = [[bezier(facts, k, i, side) for side in (0, 1)] for k in range(facts.segments)]
    own = [max(abs(b - a) for edge in pair for a, b in itertools.pairwise(edge)) for pair in edges] + [0]
    return [3 * facts.unit * max(v, own[max(k - 1, 0)]) * facts.segments / facts.t_c for k, v in enumerate(own)]


def hints(facts: Facts, sampling: Sampling) -> list[list[Hint]]:
    """By window, by component."""
    columns = []
    for i in range(facts.n):
        own = widths(facts, i)
        columns.append([_hint(facts, sampling, i, min(d, own[max(k - 1, 0)][0])) for k, (d, _) in enumerate(own)])
    return [list(row) for row in zip(*columns, strict=True)]


def _hint(facts: Facts, sampling: Sampling, i: int, width: Fraction) -> Hint:
    limit = None if facts.u_max is None else facts.u_max[i]
    z, shift, lost = 1 / (1 + sampling.rho[i]), sampling.shift[i], sampling.lost
    near = width * z - shift
    if near <= 0:
        return limit or Fraction(0), Fraction(0)
    far = width * (1 - z) + shift
    log = _up(Fraction(math.log(far / near)) + LOG)
    most = _up(emitted_input(facts.gain[i], far, near, lambda _: log, lost) * ROOM)
    return (limit, Fraction(0)) if limit is not None and limit <= most else (most, log)


def _up(value: Fraction) -> Fraction:
    return Fraction(math.ceil(value * (1 << BITS)), 1 << BITS)


def cells(facts: Facts, sampling: Sampling, rows: list[list[Hint]]) -> int:
    """Into so few the range of every window's width is cut that the law is seen to push back enough in all."""
    return next((m for m in CELLS if all(_pushes_back(facts, sampling, rows, i, m) for i in range(facts.n))), CELLS[-1])


def holds(facts: Facts, sampling: Sampling) -> bool:
    """Whether `period_check` of proof/Period.v would say yes, in floating point and so with some room: the law turns in time and
    pushes back enough, within its limits."""
    rows = hints(facts, sampling)
    if any((1 - e) / 2 * (1 + rho) > 1 for e, rho in zip(facts.e_max, sampling.rho, strict=True)):
        return False
    own = all(_turns(facts, sampling, rows, i) for i in range(facts.n))
    return own and any(all(_pushes_back(facts, sampling, rows, i, m) for i in range(facts.n)) for m in CELLS)


def _pushed(facts: Facts, sampling: Sampling, rows: list[list[Hint]], i: int) -> Iterator[tuple[float, float, float, float]]:
    """Of one component by window: the least and the largest width, what pushes towards an edge, the largest |u|."""
    for (least, largest), speed, row in zip(widths(facts, i), speeds(facts, i), rows, strict=True):
        others = sum((u for j, (u, _) in enumerate(row) if j != i), Fraction(0))
        yield float(least), float(largest), float(sampling.force[i] + sampling.g_cross[i] * others + speed), float(row[i][0])


def _turns(facts: Facts, sampling: Sampling, rows: list[list[Hint]], i: int) -> bool:
    """An input that was right when it was made is not yet wrong when the next one acts; what pushes is within the limit on u."""
    rho, shift, lost = float(sampling.rho[i]), float(sampling.shift[i]), float(sampling.lost)
    before, tau, limit = 0.0, float(sampling.period + sampling.latency), None if facts.u_max is None else facts.u_max[i]
    for least, largest, push, most in _pushed(facts, sampling, rows, i):
        broadest, before = max(before, largest), largest
        moved = 2 * (push + float(sampling.g_max[i]) * most) * tau
        if 2 * shift + lost * (broadest + 2 * shift) + ROUGH * least >= least * (rho - 1) / (rho + 1) - moved:
            return False
        if limit is not None and push * (1 + ROUGH) > sampling.g_min[i] * limit:
            return False
    return True


def _pushes_back(facts: Facts, sampling: Sampling, rows: list[list[Hint]], i: int, m: int) -> bool:
    """Of one component in every window and cell, as proof/Period.v has it, in floating point and so with some room."""
    rho, shift, lost = float(sampling.rho[i]), float(sampling.shift[i]), float(sampling.lost)
    late, pull = float(sampling.latency), float(sampling.g_min[i] * facts.gain[i]) * (1 - lost)
    for least, largest, push, most in _pushed(facts, sampling, rows, i):
        drift = push * (float(sampling.period) + late) + float(sampling.g_max[i]) * most * late + shift
        for k in range(m):
            d, to = (least + (largest - least) * j / m for j in (k, k + 1))
            far, near, nearest = d * rho / (1 + rho) - drift, d / (1 + rho) + drift, to / (1 + rho) + drift
            if far <= near or pull / nearest * (1 + near / far) * (math.log(far / near) - lost - ROUGH) <= push:
                return False
    return True
