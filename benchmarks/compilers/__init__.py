"""Compilers and processors that the emitted C is tried on, by `python -m benchmarks toolchains` and by tests."""
