"""Lemmas about refined tubes: splines, limits on u, the filtered tube of order 2."""

__all__ = ["filtered_tube", "inertial_inputs", "input_limits", "spline_edges"]
