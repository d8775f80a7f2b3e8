"""A linear program, built in blocks of rows and solved by HiGHS.

One thread and fixed options: the same program gives the same answer on every run. The answer is rounded to a coarse
grid and certified exactly afterwards, so nothing rests on the solver's tolerances.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import highspy
import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array

Columns = npt.NDArray[np.int64]
FEASIBILITY = 1e-9  # the least HiGHS accepts is 1e-10; the allowance of the arena is thousands of times larger


# Found by timing on the arenas: the programs are small, so presolve costs more than it saves, and Devex prices them quickest.
OPTIONS: dict[str, bool | int | float | str] = {
    "output_flag": False,
    "threads": 1,
    "random_seed": 0,
    "primal_feasibility_tolerance": FEASIBILITY,
    "presolve": "off",
    "simplex_dual_edge_weight_strategy": 1,
}


class LinearProgram:
    """minimise cost @ x subject to row_lower <= A x <= row_upper and lower <= x <= upper, built in blocks of rows."""

    def __init__(self, columns: int) -> None:
        self.cost = np.zeros(columns)
        self.lower = np.full(columns, -np.inf)
        self.upper = np.full(columns, np.inf)
        self._columns: list[Columns] = []
        self._values: list[Array] = []
        self._row_lower: list[Array] = []
        self._row_upper: list[Array] = []

    def rows(self, columns: npt.ArrayLike, values: Sequence[float] | Array, lower: npt.ArrayLike, upper: npt.ArrayLike) -> None:
        """Add R rows of k entries each: `columns` of shape (R, k), `values` of length k or (R, k), bounds broadcast to R."""
        index = np.atleast_2d(np.asarray(columns, dtype=np.int64))
        self._columns.append(index)
        for store, value, shape in (
            (self._values, values, index.shape),
            (self._row_lower, lower, len(index)),
            (self._row_upper, upper, len(index)),
        ):
            full = np.empty(shape)
            full[...] = value
            store.append(full)

    def solve(self) -> Array | None:
        """The optimal x, or None when there is none (infeasible, or given up)."""
        widths = np.concatenate([np.full(len(c), c.shape[1]) for c in self._columns])
        first = np.concatenate([[0], np.cumsum(widths)]).astype(np.int32)
        column = np.concatenate([c.ravel() for c in self._columns]).astype(np.int32)
        rows = Rows(first, column, np.concatenate([v.ravel() for v in self._values]))
        bounds = np.concatenate(self._row_lower), np.concatenate(self._row_upper)
        return least(self.cost, self.lower, self.upper, rows, *bounds)


@dataclass(frozen=True)
class Rows:
    """Rows of a matrix, one after the other: row r has entries first[r] to first[r + 1] of column and value."""

    first: npt.NDArray[np.int32]
    column: npt.NDArray[np.int32]
    value: Array

    @classmethod
    def of(cls, rows: Sequence[tuple[Sequence[int], Sequence[float]]]) -> Rows:
        """From the columns and values of each row."""
        first = np.concatenate([[0], np.cumsum([len(c) for c, _ in rows])]).astype(np.int32)
        column = np.array([c for columns, _ in rows for c in columns], dtype=np.int32)
        return cls(first, column, np.array([v for _, values in rows for v in values]))

    @classmethod
    def joined(cls, parts: Sequence[Rows]) -> Rows:
        """One block below the other."""
        if len(parts) == 1:
            return parts[0]
        ends = np.cumsum([0, *(len(p.column) for p in parts)])
        first = [p.first[:-1] + end for p, end in zip(parts, ends[:-1].tolist(), strict=True)]
        column, value = (np.concatenate([getattr(p, name) for p in parts]) for name in ("column", "value"))
        return cls(np.concatenate([*first, ends[-1:]]).astype(np.int32), column, value)

    def moved(self, by: int, last: int, there: int) -> Rows:
        """The same rows on later columns; column number `last` is moved to `there`."""
        if by == 0 and last == there:
            return self
        return replace(self, column=np.where(self.column == last, there, self.column + by).astype(np.int32))

    def times(self, column: int, factor: float) -> Rows:
        """The same rows with the entries of one column so many times as large."""
        return replace(self, value=np.where(self.column == column, factor * self.value, self.value))

    @property
    def count(self) -> int:
        return len(self.first) - 1


class Solvers:
    """The programs of one task, by what they are called: one that comes again with other bounds on its rows starts from where it
    stood. Made anew for every task, so that a tube does not depend on what was designed before it."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, ...], Any] = {}  # highspy's types leave out some of its methods

    def solve(
        self, name: tuple[int, ...], cost: Array, lower: Array, upper: Array, rows: Rows, row_lower: Array, row_upper: Array
    ) -> Array | None:
        """As `least`; of the same name only row_lower and row_upper may differ."""
        if np.any(row_lower > row_upper):
            return None
        solver = self._known.get(name)
        if solver is None:
            solver = self._known[name] = _solver(cost, lower, upper, rows, row_lower, row_upper)
        else:
            solver.changeRowsBounds(rows.count, np.arange(rows.count, dtype=np.int32), row_lower, row_upper)
        return _optimum(solver)


def least(cost: Array, lower: Array, upper: Array, rows: Rows, row_lower: Array, row_upper: Array) -> Array | None:
    """The x of least cost @ x with lower <= x <= upper and row_lower <= A x <= row_upper; None when there is none."""
    if np.any(lower > upper) or np.any(row_lower > row_upper):
        return None
    return _optimum(_solver(cost, lower, upper, rows, row_lower, row_upper))


def _solver(cost: Array, lower: Array, upper: Array, rows: Rows, row_lower: Array, row_upper: Array) -> highspy.Highs:
    model = highspy.HighsLp()
    model.num_col_, model.num_row_ = len(cost), rows.count
    model.col_cost_, model.col_lower_, model.col_upper_ = cost, lower, upper
    model.row_lower_, model.row_upper_ = row_lower, row_upper
    model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    model.a_matrix_.start_, model.a_matrix_.index_, model.a_matrix_.value_ = rows.first, rows.column, rows.value
    solver = highspy.Highs()  # type: ignore[no-untyped-call]
    for option, value in OPTIONS.items():
        solver.setOptionValue(option, value)
    solver.passModel(model)
    return solver


def _optimum(solver: highspy.Highs) -> Array | None:
    solver.run()
    if solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
        return None
    return np.array(solver.getSolution().col_value)


def face_terms(arena: Arena, x: int, edge: Columns) -> tuple[list[int], list[float]]:
    """low_n of face x as columns and values; edge: the columns of the edges, shape (2, n)."""
    terms = [(i, c) for i, c in enumerate(arena.oblique_faces.normal[x].tolist()) if c]
    return [int(edge[0 if c > 0 else 1, i]) for i, c in terms], [c for _, c in terms]


def face_bound(arena: Arena, x: int) -> float:
    """What low_n must be at least: h(n) and the clearance."""
    return float(arena.oblique_faces.bound[x] + arena.clearance)
