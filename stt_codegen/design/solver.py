"""A linear program, built in blocks of rows and solved by HiGHS.

One thread and fixed options: the same program gives the same answer on every run. The answer is rounded to a coarse
grid and certified exactly afterwards, so nothing rests on the solver's tolerances.
"""

from __future__ import annotations

from collections.abc import Sequence

import highspy
import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena, Array

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
    """minimise cost @ x subject to row_lower <= A x <= row_upper and lower <= x <= upper.

    Once solved, `cost`, `lower` and `upper` may be changed and the program solved again, from where it stood; rows are fixed.
    """

    def __init__(self, columns: int) -> None:
        self.cost = np.zeros(columns)
        self.lower = np.full(columns, -np.inf)
        self.upper = np.full(columns, np.inf)
        self._columns: list[Columns] = []
        self._values: list[Array] = []
        self._row_lower: list[Array] = []
        self._row_upper: list[Array] = []
        self._solver: highspy.Highs | None = None

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
        if np.any(self.lower > self.upper):
            return None
        if self._solver is None:
            self._solver = self._first()
            if self._solver is None:
                return None
        else:
            count = len(self.cost)
            every = np.arange(count, dtype=np.int32)
            self._solver.changeColsCost(count, every, self.cost)
            self._solver.changeColsBounds(count, every, self.lower, self.upper)
        self._solver.run()
        if self._solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
            return None
        return np.array(self._solver.getSolution().col_value)

    def _first(self) -> highspy.Highs | None:
        """The solver with the program handed over; None when two bounds of a row cross."""
        model = highspy.HighsLp()
        model.num_col_ = len(self.cost)
        model.col_cost_, model.col_lower_, model.col_upper_ = self.cost, self.lower, self.upper
        model.row_lower_ = np.concatenate(self._row_lower)
        model.row_upper_ = np.concatenate(self._row_upper)
        model.num_row_ = len(model.row_lower_)
        if np.any(np.asarray(model.row_lower_) > np.asarray(model.row_upper_)):
            return None
        widths = np.concatenate([np.full(len(c), c.shape[1]) for c in self._columns])
        model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
        model.a_matrix_.start_ = np.concatenate([[0], np.cumsum(widths)]).astype(np.int32)
        model.a_matrix_.index_ = np.concatenate([c.ravel() for c in self._columns]).astype(np.int32)
        model.a_matrix_.value_ = np.concatenate([v.ravel() for v in self._values])
        solver = highspy.Highs()  # type: ignore[no-untyped-call]
        for option, value in OPTIONS.items():
            solver.setOptionValue(option, value)
        solver.passModel(model)
        return solver


def face_terms(arena: Arena, x: int, edge: Columns) -> tuple[list[int], list[float]]:
    """low_n of face x as columns and values; edge: the columns of the edges, shape (2, n)."""
    terms = [(i, c) for i, c in enumerate(arena.faces.normal[x].tolist()) if c]
    return [int(edge[0 if c > 0 else 1, i]) for i, c in terms], [c for _, c in terms]


def face_bound(arena: Arena, x: int) -> float:
    """What low_n must be at least: h(n) and the clearance."""
    return float(arena.faces.bound[x] + arena.faces.size[x] * arena.clearance)
