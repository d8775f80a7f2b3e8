"""Lemmas about emitted kernels and functions: on every path their outputs are formulas of the paper, or their repairs."""

__all__ = ["functions", "printed_kernels"]
