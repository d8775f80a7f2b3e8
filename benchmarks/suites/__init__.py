"""Suites: arenas, loops, missions and boards that are measured by the hundred, with their tables."""
