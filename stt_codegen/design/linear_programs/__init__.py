"""Linear programs in blocks of rows, solved by HiGHS: the solver, the rows of a tube, the box of a route's end."""

from stt_codegen.design.linear_programs.end_box import inner_box
from stt_codegen.design.linear_programs.solver import LinearProgram, Rows, Solvers, face_bound, face_terms, least
from stt_codegen.design.linear_programs.tube_rows import INNER, Template, template_of

__all__ = [
    "INNER",
    "LinearProgram",
    "Rows",
    "Solvers",
    "Template",
    "face_bound",
    "face_terms",
    "inner_box",
    "least",
    "template_of",
]
