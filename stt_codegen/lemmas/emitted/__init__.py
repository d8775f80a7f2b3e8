"""Lemmas about emitted functions: every path of each equals a formula."""

__all__ = ["functions", "printed_kernels"]
