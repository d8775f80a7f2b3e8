"""Lemmas about unsafe sets: normals and supports, constraints, sets that move."""

__all__ = ["moving_bounds", "shape_supports", "task_constraints"]
