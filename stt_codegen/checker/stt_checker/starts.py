"""The starts that the C's `covered` says yes to: states that P9, or without a period Theorem 4.1, begins at."""

import math
from fractions import Fraction
from typing import Any

from .exact import rounded
from .law import Law
from .period import start_ratios
from .tube import Tube

TABLES = ("start_lower", "start_upper", "filtered_start_lower", "filtered_start_upper")  # the last two for order 2


def covered_starts(task: Any, tube: Tube, law: Law) -> dict[str, list[Fraction]]:
    """Return the tables of `covered`. A measured x strictly between the first two, and for order 2 the C's v + lambda x strictly
    between the others, belongs to no state but one that is covered. The middle is the tube's. The half width is the start share
    of it, for v + lambda x what `start_ratios` says, less what a measurement may be wrong by: the noise, and roundings. A C in
    integers has them in units of the table."""
    unit, eps, counts_units = tube.unit, Fraction(2, 1 << law.bits), law.scalar == "fixed"
    per_segment = unit * tube.segments / task.t_c
    ratios = start_ratios(task, tube, law.filters) if task.period is not None and task.order == 2 else []
    tables: list[list[Fraction]] = [[] for _ in range(2 * task.order)]
    for i, (low, high) in enumerate(tube.pieces[0]):
        noise, noise_v = task.noise(i)
        noise = task.turns.unwrap_noise[i] if task.turns else noise
        spans = [(low[0] * unit, high[0] * unit, task.start_share, noise + (unit / 2 if counts_units else eps * task.farthest))]
        if task.order == 2:
            s = law.filters[i]
            a, b = (3 * (e[1] - e[0]) * per_segment + s * e[0] * unit for e in (low, high))
            share = (ratios[i] - 1) / (ratios[i] + 1) if ratios else task.start_share
            rounding = 2 * eps * (2 * s * task.farthest + max(abs(a), abs(b)))
            rounding = unit * (Fraction(3, 2) + s / 2) if counts_units else rounding
            spans.append((a, b, share, (Fraction(0) if task.differs else noise_v) + s * noise + rounding))
        for k, (a, b, share, error) in enumerate(spans):
            middle, half = (a + b) / 2, share * (b - a) / 2 - error
            if counts_units:
                tables[2 * k].append(Fraction(math.ceil((middle - half) / unit) - 1))
                tables[2 * k + 1].append(Fraction(math.floor((middle + half) / unit) + 1))
            else:
                tables[2 * k].append(rounded(middle - half, law.bits, math.ceil))
                tables[2 * k + 1].append(rounded(middle + half, law.bits, math.floor))
    return dict(zip(TABLES[: len(tables)], tables, strict=True))
