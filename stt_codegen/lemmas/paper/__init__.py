"""Lemmas about the paper's equations: conflict windows, circumvent and update functions, transform, Theorem 4.1."""

__all__ = ["bumps", "conflict", "reach", "smooth_maximum", "theorem_4_1", "transform", "update_cells", "update_function"]
