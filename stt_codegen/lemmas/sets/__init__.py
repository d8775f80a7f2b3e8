"""Lemmas about unsafe sets: normals and supports, constraints, sets that move."""

__all__ = ["constraint_rows", "moving_bounds", "shape_supports"]
