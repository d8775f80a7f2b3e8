"""Benchmarks: everything that measures the package, one file each; `python -m benchmarks` lists them."""
