"""Combinations of the listings' options."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

# Of each choice exactly one alternative is an option; "" stands for none. Words with a plus are two options.
CHOICES = (
    ("float", "double"),
    ("order 1", "order 2"),
    ("", "ticks"),
    ("libm", "inline"),
    ("one gain", "gains"),
    ("one clamp", "clamps"),
    ("one filter", "filters"),
    ("no limits", "limits", "no limits+scaled"),
    ("", "differences"),
)


def is_possible(alternatives: tuple[str, ...]) -> bool:
    """Return whether a task can have these options.

    u is scaled for order 1 and one gain alone. Velocities by differences need u_max, and these and filters order 2."""
    options = {word for alternative in alternatives for word in alternative.split("+")}
    if "order 2" in options:
        return "scaled" not in options and ("differences" not in options or "limits" in options)
    return not options & {"differences", "filters"} and not {"scaled", "gains"} <= options


def all_combinations() -> Iterator[tuple[str, ...]]:
    return filter(is_possible, itertools.product(*CHOICES))


def options_of(alternatives: tuple[str, ...]) -> set[str]:
    """Return the words that `source.fill` takes."""
    return {word for alternative in alternatives for word in alternative.split("+") if word}


def pairs_in(alternatives: tuple[str, ...]) -> set[tuple[tuple[int, str], tuple[int, str]]]:
    return set(itertools.combinations(enumerate(alternatives), 2))


def pairwise_combinations() -> list[tuple[str, ...]]:
    """Return a few combinations in which every possible pair of alternatives occurs."""
    candidates, chosen = list(all_combinations()), list[tuple[str, ...]]()
    missing = set().union(*map(pairs_in, candidates))
    while missing:
        best = max(candidates, key=lambda candidate: len(pairs_in(candidate) & missing))
        chosen.append(best)
        missing -= pairs_in(best)
    return chosen
