"""The equations, in CasADi: one file per section of the paper, and the refined tube that Theorem 4.1 also licenses.

Every function here returns a `casadi.Function` of scalars; `program.convert.lower` turns it into a kernel. Numbers in brackets
are the paper's equations (Das and Jagtap, IEEE L-CSS 8, 2024)."""

__all__ = ["adaptive_tube", "circumvent", "control_law", "reach_tube", "refined_tube", "smooth"]
