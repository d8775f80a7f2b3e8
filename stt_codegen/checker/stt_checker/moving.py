"""Sets that move, grow, or count only during an active interval: for tasks that have such sets."""

import itertools
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from .exact import Unusable, number, vector

Point = list[Fraction]
KNOT_LIMIT = 200  # displacements of one motion


class Course:
    """How a set moves and when it counts. Displacements are at times of the set's clock: linear between them, constant before the
    first and after the last. At the controller's time t the set's clock shows some time from t - `early` to t + `late`. Times are
    in seconds."""

    def __init__(self, table: Any, moves: list[tuple[Any, dict[int, Fraction]]], task: Any) -> None:
        timing, t_c = number(table.get("timing", 0)), task.t_c
        self.early, self.late, self.spread = timing, timing + task.start_delay, number(table.get("spread", 0))
        entries = table.get("motion", [])
        if len(entries) > KNOT_LIMIT or ("motion" in table and not entries) or not all({*v} == {"at", "by"} for v in entries):
            raise Unusable(f"the task has a motion that is no list of {{ at, by }} with 1 to {KNOT_LIMIT} entries")
        still = [(Fraction(0), [Fraction(0)] * task.n)]
        self.knots = [(number(at), [by.get(i, Fraction(0)) for i in range(task.n)]) for at, by in moves] or still
        times = [at for at, _ in self.knots]
        ends: list[Fraction] = vector(table["during"], 2) if "during" in table else [-self.early, t_c + self.late]
        self.first, self.last = ends
        is_ordered = "during" not in table or 0 <= self.first < self.last <= t_c
        if not is_ordered or min(timing, self.spread, *times) < 0 or max(times) > t_c or sorted({*times}) != times:
            raise Unusable("the task has a motion or an active interval outside 0 to prescribed_time, or in no order")

    def displacement(self, tau: Fraction) -> Point:
        """Return the displacement at a time of the set's clock; outside the active interval that of its nearer end."""
        tau = min(max(tau, self.first), self.last)
        for (a, begin), (b, end) in itertools.pairwise(self.knots):
            if a <= tau <= b:
                return [v + (tau - a) / (b - a) * (w - v) for v, w in zip(begin, end, strict=True)]
        return self.knots[0 if tau < self.knots[0][0] else -1][1]

    def legs(self, a: Fraction, b: Fraction) -> Iterator[tuple[Fraction, Fraction, list[tuple[Point, Point]]]]:
        """Split the time from a to b of the controller's clock where the motion turns, and drop the time at which the set does
        not count. Yield for each part its begin p and end q, and the corners of the path on which the set may be: each moves
        linearly from its first displacement (at p) to its last (at q), and the set is at a convex combination of them."""
        begin, end = max(a, self.first - self.late), min(b, self.last + self.early)
        turns = {self.first, self.last, *(at for at, _ in self.knots if self.first < at < self.last)}
        moments = {v for tau in turns for v in (tau + self.early, tau - self.late) if begin < v < end}
        for p, q in itertools.pairwise(sorted({begin, end, *moments}) if begin < end else []):
            still = [self.displacement(tau) for tau in turns if q - self.early <= tau <= p + self.late]
            ends = [(self.displacement(p + s), self.displacement(q + s)) for s in (-self.early, self.late)]
            yield p, q, ends + [(d, d) for d in still]
