"""A linear program, built in blocks of rows and solved by HiGHS.

One thread and fixed options: the same program gives the same answer on every run. The answer is rounded to a coarse
grid and certified exactly afterwards, so nothing rests on the solver's tolerances.
"""

from __future__ import annotations

from collections.abc import Sequence

import highspy
import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Array

Columns = npt.NDArray[np.int64]
FEASIBILITY = 1e-9  # the least HiGHS accepts is 1e-10; the allowance of the arena is thousands of times larger


class LinearProgram:
    """minimise cost @ x subject to row_lower <= A x <= row_upper and lower <= x <= upper."""

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
        self._values.append(np.broadcast_to(np.asarray(values, dtype=float), index.shape))
        self._row_lower.append(np.broadcast_to(np.asarray(lower, dtype=float), len(index)))
        self._row_upper.append(np.broadcast_to(np.asarray(upper, dtype=float), len(index)))

    def solve(self) -> Array | None:
        """The optimal x, or None when there is none (infeasible, or given up)."""
        if np.any(self.lower > self.upper):
            return None
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
        for option, value in (
            ("output_flag", False),
            ("threads", 1),
            ("random_seed", 0),
            ("primal_feasibility_tolerance", FEASIBILITY),
        ):
            solver.setOptionValue(option, value)
        solver.passModel(model)
        solver.run()
        if solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
            return None
        return np.array(solver.getSolution().col_value)
