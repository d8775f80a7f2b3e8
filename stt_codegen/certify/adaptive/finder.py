"""From enclosures of a tube's edges to findings: rows and widths evaluated in doubles, every rounding to the safe side."""

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
from stt_codegen.constraints import Constraint, avoidances
from stt_codegen.decimals import decimal
from stt_codegen.properties import Property
from stt_codegen.task import Task

Array = npt.NDArray[Any]
SETTINGS = 'use tube.design = "refined", or other parameters in [tube.adaptive]'


EXACT = 1 << 53  # whole numbers below this are doubles


@dataclass(frozen=True)
class Finder:
    """Findings from the enclosure of gamma, shape (N + 1, n, 2 sides, 2 ends), over the cells between `times`."""

    task: Task
    times: Array
    gamma: Array

    def slack(self, row: Constraint) -> Array:
        """A lower bound on the slack of a row in every cell, as a distance: (N + 1,). Of an edge the end counts that makes it
        least; every operation that may round is rounded down, and what is exact is not."""
        left: Any = None
        for i, side, c in row.terms:
            edge = self.gamma[:, i, side, LOW if c > 0 else HIGH]
            term = edge * c if abs(c) == 1 else _down(float(c) * edge, 1 if abs(c) < EXACT else 3)
            left = term if left is None else _down(left + term, 1)
        found = gap(double_above(row.bound + row.clearance), left)
        found = (
            found
            if row.slack_per_distance == 1
            else _down(found / float(row.slack_per_distance), 1 if row.slack_per_distance < EXACT else 3)
        )
        return np.where(np.isnan(found), -np.inf, found)  # where an enclosure says nothing, nothing is shown

    def least(
        self, rows: Sequence[Constraint], cells: slice, subject: Property, statement: str, advice: str = SETTINGS
    ) -> Finding:
        """The row that holds by least over some of the cells, as a finding."""
        slack = np.stack([self.slack(row) for row in rows], axis=1)
        k, r = np.unravel_index(int(np.argmin(slack[cells])), slack[cells].shape)
        first, dimension = range(len(slack))[cells][0], rows[int(r)].dimension
        where = None if dimension is None else dimension + 1
        found = lower_bound(slack[cells][k, r])
        return Finding(subject, statement, found, Fraction(0), self.interval(first + int(k)), where, None, advice)

    def avoid(self) -> Finding:
        """P4: in every cell the best row of each unsafe set."""
        sets = avoidances(self.task)
        if not sets:
            return Finding(Property.AVOID, "there is no unsafe set", Fraction(0), Fraction(0))
        worst: tuple[float, int, str] = (math.inf, 0, "")
        for one in sets:
            slack = np.max([self.slack(row) for row in one.alternatives], axis=0)
            k = int(np.argmin(slack))
            worst = min(worst, (float(slack[k]), k, one.name))
        slack_, k, name = worst
        statement = f"gamma at least {decimal(self.task.tube.clearance)} from each of {len(sets)} unsafe sets"
        return Finding(Property.AVOID, statement, lower_bound(slack_), Fraction(0), self.interval(k), None, name, SETTINGS)

    def interval(self, cell: int) -> tuple[Fraction, Fraction]:
        t_c = self.task.prescribed_time
        return (t_c, t_c) if cell >= len(self.times) - 1 else (lower_bound(self.times[cell]), lower_bound(self.times[cell + 1]))


def _down(value: Any, steps: int) -> Array:
    """So many doubles lower: one for each rounding, and two for a factor that is no double itself."""
    for _ in range(steps):
        value = np.nextafter(value, -np.inf)
    return np.asarray(value)


def gap(low: Any, high: Any) -> Array:
    """A lower bound on how far `high` is above `low`."""
    return np.asarray(np.nextafter(np.asarray(high, dtype=float) - low, -np.inf))


def double_above(value: Fraction) -> float:
    return math.nextafter(float(value), math.inf)


def lower_bound(value: float) -> Fraction:
    """A lower bound as a fraction; what could not be bounded counts as far below."""
    return Fraction(value) if math.isfinite(value) else Fraction(-(10**9))
