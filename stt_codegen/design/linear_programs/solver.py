"""A linear program, built in blocks of rows and solved by HiGHS.

One thread and fixed options: the same program gives the same answer on every run. The answer is rounded to a coarse grid and
certified exactly afterwards, so nothing rests on the solver's tolerances. The spline tubes, their stretch times, the plans of
missions and the end box of a route are solved here.
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
from stt_codegen.effort import require_effort

Columns = npt.NDArray[np.int64]
FEASIBILITY_TOLERANCE = 1e-9  # the smallest that HiGHS accepts is 1e-10; the arena's allowance is thousands of times larger


# Chosen by timing on the arenas: the programs are small, so presolve costs more than it saves, and Devex prices them quickest.
OPTIONS: dict[str, bool | int | float | str] = {
    "output_flag": False,
    "threads": 1,
    "random_seed": 0,
    "primal_feasibility_tolerance": FEASIBILITY_TOLERANCE,
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

    def add_rows(
        self, columns: npt.ArrayLike, values: Sequence[float] | Array, lower: npt.ArrayLike, upper: npt.ArrayLike
    ) -> None:
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
        """Return the optimal x, or None when there is none (infeasible, or given up)."""
        widths = np.concatenate([np.full(len(c), c.shape[1]) for c in self._columns])
        first = np.concatenate([[0], np.cumsum(widths)]).astype(np.int32)
        column = np.concatenate([c.ravel() for c in self._columns]).astype(np.int32)
        rows = Rows(first, column, np.concatenate([v.ravel() for v in self._values]))
        bounds = ProgramBounds(self.lower, self.upper, np.concatenate(self._row_lower), np.concatenate(self._row_upper))
        return minimise(self.cost, rows, bounds)


@dataclass(frozen=True)
class Rows:
    """Rows of a matrix, one after the other: row r has entries first[r] to first[r + 1] of column and value."""

    first: npt.NDArray[np.int32]
    column: npt.NDArray[np.int32]
    value: Array

    @classmethod
    def of(cls, rows: Sequence[tuple[Sequence[int], Sequence[float]]]) -> Rows:
        """Return the rows with these columns and values."""
        first = np.concatenate([[0], np.cumsum([len(c) for c, _ in rows])]).astype(np.int32)
        column = np.array([c for columns, _ in rows for c in columns], dtype=np.int32)
        return cls(first, column, np.array([v for _, values in rows for v in values]))

    @classmethod
    def stacked(cls, blocks: Sequence[Rows]) -> Rows:
        """Return one block below the other."""
        if len(blocks) == 1:
            return blocks[0]
        ends = np.cumsum([0, *(len(p.column) for p in blocks)])
        first = [p.first[:-1] + end for p, end in zip(blocks, ends[:-1].tolist(), strict=True)]
        column, value = (np.concatenate([getattr(p, name) for p in blocks]) for name in ("column", "value"))
        return cls(np.concatenate([*first, ends[-1:]]).astype(np.int32), column, value)

    def shifted(self, offset: int, shared: int, shared_target: int) -> Rows:
        """Return the rows with every column number raised by `offset`, but column `shared` becomes column `shared_target`."""
        if offset == 0 and shared == shared_target:
            return self
        return replace(self, column=np.where(self.column == shared, shared_target, self.column + offset).astype(np.int32))

    def with_scaled_column(self, column: int, factor: float) -> Rows:
        """Return the rows with the entries of one column multiplied by a factor."""
        return replace(self, value=np.where(self.column == column, factor * self.value, self.value))

    @property
    def count(self) -> int:
        return len(self.first) - 1


@dataclass(frozen=True)
class ProgramBounds:
    """The bounds of a linear program: lower <= x <= upper and row_lower <= A x <= row_upper."""

    lower: Array
    upper: Array
    row_lower: Array
    row_upper: Array


class _SilentSolver(highspy.Highs):
    """HiGHS without the callbacks that its Python class adds: from 1.16 on, adding them prints a banner on stdout."""

    def __init__(self) -> None:
        super(highspy.Highs, self).__init__()


class SolverCache:
    """The solvers of one task by the names of their programs.

    A program that comes again with other bounds on its rows starts from its last solution. Every task has a new cache, so that a
    tube does not depend on what was designed before it.
    """

    def __init__(self) -> None:
        self._solvers: dict[tuple[int, ...], Any] = {}  # highspy's types leave out some of its methods

    def minimise(self, name: tuple[int, ...], cost: Array, rows: Rows, bounds: ProgramBounds) -> Array | None:
        """Solve as `minimise`; programs of one name may differ in row_lower and row_upper only."""
        if np.any(bounds.row_lower > bounds.row_upper):
            return None
        solver = self._solvers.get(name)
        if solver is None:
            solver = self._solvers[name] = _load(cost, rows, bounds)
        else:
            solver.changeRowsBounds(rows.count, np.arange(rows.count, dtype=np.int32), bounds.row_lower, bounds.row_upper)
        return _solve(solver)


def minimise(cost: Array, rows: Rows, bounds: ProgramBounds) -> Array | None:
    """Return the x within the bounds that minimises cost @ x; None when there is none."""
    if np.any(bounds.lower > bounds.upper) or np.any(bounds.row_lower > bounds.row_upper):
        return None
    return _solve(_load(cost, rows, bounds))


def _load(cost: Array, rows: Rows, bounds: ProgramBounds) -> highspy.Highs:
    """Return a solver that holds the program."""
    model = highspy.HighsLp()
    model.num_col_, model.num_row_ = len(cost), rows.count
    model.col_cost_, model.col_lower_, model.col_upper_ = cost, bounds.lower, bounds.upper
    model.row_lower_, model.row_upper_ = bounds.row_lower, bounds.row_upper
    model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    model.a_matrix_.start_, model.a_matrix_.index_, model.a_matrix_.value_ = rows.first, rows.column, rows.value
    solver = _SilentSolver()
    for option, value in OPTIONS.items():
        solver.setOptionValue(option, value)
    solver.passModel(model)
    return solver


def _solve(solver: highspy.Highs) -> Array | None:
    require_effort()
    solver.run()
    if solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
        return None
    return np.array(solver.getSolution().col_value)


def face_terms(arena: Arena, x: int, edge: Columns) -> tuple[list[int], list[float]]:
    """Return low_n of the oblique face x as columns and values; edge: the columns of the edges, shape (2, n)."""
    terms = [(i, c) for i, c in enumerate(arena.oblique_faces.normal[x].tolist()) if c]
    return [int(edge[0 if c > 0 else 1, i]) for i, c in terms], [c for _, c in terms]


def face_bound(arena: Arena, x: int) -> float:
    """Return what low_n must be at least for the oblique face x: h(n) and the clearance."""
    return float(arena.oblique_faces.upper_bound[x] + arena.clearance)
