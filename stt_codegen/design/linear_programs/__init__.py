"""Linear programs in blocks of rows, solved by HiGHS: the solver, the rows of a tube, the box of a route's end."""

from stt_codegen.design.linear_programs.end_box import inner_box
from stt_codegen.design.linear_programs.solver import (
    LinearProgram,
    ProgramBounds,
    Rows,
    SolverCache,
    face_bound,
    face_terms,
    minimise,
)
from stt_codegen.design.linear_programs.tube_rows import INNER_BEZIER_WEIGHTS, RowTemplate, row_template_of

__all__ = [
    "INNER_BEZIER_WEIGHTS",
    "LinearProgram",
    "ProgramBounds",
    "RowTemplate",
    "Rows",
    "SolverCache",
    "face_bound",
    "face_terms",
    "inner_box",
    "minimise",
    "row_template_of",
]
