"""What helps Coq with P9, and is not believed: by window and component a bound on |u|, and one on the logarithm in it.

A window is a segment, or the time from t_c on. The bounds are those of docs/certificate-format.md, a little larger.
"""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

from stt_codegen.theorem.reading import Facts, Sampling

BITS, ROOM = 24, 1 + Fraction(1, 1 << 20)
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


def widths(facts: Facts, i: int) -> list[Fraction]:
    """The least width in every window."""
    spans = [[b - a for a, b in zip(bezier(facts, k, i, 0), bezier(facts, k, i, 1), strict=True)] for k in range(facts.segments)]
    return [facts.unit * min(span) for span in spans] + [facts.unit * spans[-1][3]]


def hints(facts: Facts, sampling: Sampling) -> list[list[Hint]]:
    """By window, by component."""
    columns = []
    for i in range(facts.n):
        own = widths(facts, i)
        columns.append([_hint(facts, sampling, i, min(d, own[max(k - 1, 0)])) for k, d in enumerate(own)])
    return [list(row) for row in zip(*columns, strict=True)]


def _hint(facts: Facts, sampling: Sampling, i: int, width: Fraction) -> Hint:
    limit = None if facts.u_max is None else facts.u_max[i]
    z, shift, lost = 1 / (1 + sampling.rho[i]), sampling.shift[i], sampling.lost
    near = width * z - shift
    if near <= 0:
        return limit or Fraction(0), Fraction(0)
    ratio = (width * (1 - z) + shift) / near
    log = _up(Fraction(math.log(ratio)) + LOG)
    most = _up(facts.gain[i] / near * (1 + 1 / ratio) * (1 + lost) * (log + lost) * ROOM)
    return (limit, Fraction(0)) if limit is not None and limit <= most else (most, log)


def _up(value: Fraction) -> Fraction:
    return Fraction(math.ceil(value * (1 << BITS)), 1 << BITS)
