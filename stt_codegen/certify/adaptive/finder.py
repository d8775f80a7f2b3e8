"""Findings from enclosures of a tube's edges: constraints evaluated in doubles, every rounding to the safe side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.adaptive.lines import HIGH, LOW
from stt_codegen.certify.certificate import Finding
from stt_codegen.constraints import Constraint, avoidances, clearance_statement
from stt_codegen.decimals import above, by_component
from stt_codegen.properties import Property
from stt_codegen.task import Task

Array = npt.NDArray[Any]
SETTINGS = 'use tube.design = "refined", or other parameters in [tube.adaptive]'


LARGEST_EXACT = 1 << 53  # whole numbers below this are doubles


@dataclass(frozen=True)
class Finder:
    """The source of findings: an enclosure of gamma, (N + 1, n, 2 sides, 2 ends), over the cells between `times`."""

    task: Task
    times: Array
    gamma: Array

    def slack(self, constraint: Constraint) -> Array:
        """Return a lower bound on the slack of a constraint in every cell, as a distance: (N + 1,).

        Of each edge the end counts that makes the slack smallest. Operations that may round are rounded down; exact ones are not.
        """
        left: Any = None
        for i, side, c in constraint.terms:
            edge = self.gamma[:, i, side, LOW if c > 0 else HIGH]
            term = edge * c if abs(c) == 1 else _down(float(c) * edge, 1 if abs(c) < LARGEST_EXACT else 3)
            left = term if left is None else _down(left + term, 1)
        slack = gap(double_above(constraint.bound + constraint.clearance), left)
        divisor = constraint.slack_per_distance
        slack = slack if divisor == 1 else _down(slack / float(divisor), 1 if divisor < LARGEST_EXACT else 3)
        return np.where(np.isnan(slack), -np.inf, slack)  # where an enclosure is empty of information, nothing is proved

    def finding(
        self,
        constraints: Sequence[Constraint],
        subject: Property,
        statement: str,
        *,
        cells: slice = slice(None),
        advice: str = SETTINGS,
    ) -> Finding:
        """Return the finding of constraints that must all hold in some of the cells: the one with the smallest slack."""
        slack = np.stack([self.slack(constraint) for constraint in constraints], axis=1)
        k, r = np.unravel_index(int(np.argmin(slack[cells])), slack[cells].shape)
        first, index = range(len(slack))[cells][0], constraints[int(r)].dimension
        dimension = None if index is None else index + 1
        margin, time = lower_bound(slack[cells][k, r]), self.interval(first + int(k))
        return Finding(subject, statement, margin, Fraction(0), time, dimension=dimension, advice=advice)

    def avoid(self) -> Finding:
        """Return the finding of P4: in every cell the best alternative of each unsafe set."""
        sets = avoidances(self.task)
        if not sets:
            return Finding(Property.AVOID, "there is no unsafe set", Fraction(0), Fraction(0))
        worst: tuple[float, int, str] = (math.inf, 0, "")
        for avoidance in sets:
            slack = np.max([self.slack(constraint) for constraint in avoidance.alternatives], axis=0)
            k = int(np.argmin(slack))
            worst = min(worst, (float(slack[k]), k, avoidance.name))
        margin, k, name = worst
        statement = clearance_statement(self.task, len(sets))
        return Finding(
            Property.AVOID,
            statement,
            lower_bound(margin),
            Fraction(0),
            self.interval(k),
            obstacle=name,
            advice=SETTINGS,
        )

    def smooth(self, speed: Sequence[Fraction]) -> Finding:
        """Return the finding of P6: the speed of the edges, by dimension, within tube.max_speed where the task states it."""
        fastest, limit = ", ".join(f"{above(v, 4):g}" for v in speed), self.task.max_speed
        margin = Fraction(0) if limit is None else min(m - v for m, v in zip(limit, speed, strict=True))
        advice = (
            f"raise tube.max_speed to {by_component([above(v, 4) for v in speed])}, or use a refined tube: the "
            "bound is not sharp here"
        )
        statement = f"gamma is continuous, C1 up to t_c; |gammadot| <= {fastest}"
        return Finding(Property.SMOOTH, statement, margin, Fraction(0), advice=advice)

    def interval(self, cell: int) -> tuple[Fraction, Fraction]:
        """Return the begin and the end of a cell, in seconds; the last one stands for all times from t_c on."""
        t_c = self.task.prescribed_time
        return (t_c, t_c) if cell >= len(self.times) - 1 else (lower_bound(self.times[cell]), lower_bound(self.times[cell + 1]))


def _down(value: Any, steps: int) -> Array:
    """Return the double so many steps lower: one for each rounding, and two for a factor that is no double itself."""
    for _ in range(steps):
        value = np.nextafter(value, -np.inf)
    return np.asarray(value)


def gap(low: Any, high: Any) -> Array:
    """Return a lower bound on how far `high` is above `low`."""
    return np.asarray(np.nextafter(np.asarray(high, dtype=float) - low, -np.inf))


def double_above(value: Fraction) -> float:
    """Return a double above a fraction."""
    return math.nextafter(float(value), math.inf)


def lower_bound(value: float) -> Fraction:
    """Return a lower bound as a fraction; an infinite or missing one counts as far below."""
    return Fraction(value) if math.isfinite(value) else Fraction(-(10**9))
