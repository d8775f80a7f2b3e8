"""For every unsafe set, which dimension and side separates the tube from it, along the route.

A box avoids U_j as long as in one dimension i it is strictly on one side of U_j. Along a route the choice must change
from time to time, at points where both the old and the new choice hold. The choices turn "avoid" into plain bounds on
the tube's edges, which is what makes the design a linear program.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stt_codegen.design.arena import Arena, Array
from stt_codegen.design.route import Route

BELOW, ABOVE = 0, 1
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Stay:
    """Until route parameter `until` (vertex number plus fraction), U_j is kept off in `dimension`, the tube being
    `side` (BELOW or ABOVE) of it."""

    until: float
    dimension: int
    side: int


def choose_sides(arena: Arena, route: Route, start: Array) -> tuple[tuple[Stay, ...], ...] | None:
    """For every unsafe set the choices in order, the last one until the route's end; as few changes as possible.

    `start` is gamma(0), shape (2, n): the first choice must already separate it. None when there is no such
    choice for some set.
    """
    found = [_choices(arena, route, start, j) for j in range(len(arena.names))]
    if not all(found):
        return None
    changes = _common_changes([choice.change for choices in found for choice in choices])
    moment = iter(changes)
    return tuple(tuple(Stay(next(moment), c.dimension, c.side) for c in choices) for choices in found)


@dataclass(frozen=True)
class _Choice:
    """A choice that may end at any route parameter within `change`: until then it holds, from there the next one does."""

    dimension: int
    side: int
    change: tuple[float, float]


def _common_changes(intervals: list[tuple[float, float]]) -> list[float]:
    """A moment in each interval, as few different ones as there can be: each is the middle of what its intervals share."""
    order = sorted(range(len(intervals)), key=lambda k: intervals[k][1])
    moments = [0.0] * len(intervals)
    group: list[int] = []
    for k in [*order, -1]:
        if k >= 0 and (not group or intervals[k][0] <= intervals[group[0]][1]):
            group.append(k)
            continue
        middle = (max(intervals[g][0] for g in group) + intervals[group[0]][1]) / 2 if group else 0.0
        for g in group:
            moments[g] = middle
        group = [k]
    return moments


def _choices(arena: Arena, route: Route, start: Array, j: int) -> tuple[_Choice, ...]:
    """The choices for U_j; empty when none separates the start, or the route touches the grown set. Each time, the choice
    that lasts longest is taken."""
    end = float(len(route.points) - 1)
    spans: list[tuple[float, float, float, int, int]] = []  # from, to, least gap, dimension, side
    for i in range(arena.dimension):
        for side in (BELOW, ABOVE):
            gap = (
                arena.unsafe[j, 0, i] - route.reach - route.points[:, i]
                if side == BELOW
                else route.points[:, i] - arena.unsafe[j, 1, i] - route.reach
            )
            spans += [(a, b, float(gap.min()), i, side) for a, b in _where_positive(gap)]

    def separates_start(i: int, side: int) -> bool:
        if side == BELOW:
            return bool(start[1, i] <= arena.unsafe[j, 0, i] - arena.clearance + TOLERANCE)
        return bool(start[0, i] >= arena.unsafe[j, 1, i] + arena.clearance - TOLERANCE)

    here = [(b, gap, i, s) for a, b, gap, i, s in spans if a <= TOLERANCE and separates_start(i, s)]
    if not here:
        return ()
    until, _, i, side = max(here)
    chosen, before = [], 0.0  # `before`: where the last choice ended at the latest
    while until < end - TOLERANCE:
        onward = [(b, gap, k, s, a) for a, b, gap, k, s in spans if a <= until + 1e-7 and b > until + 1e-7]
        if not onward:
            return ()
        to, _, next_i, next_side, a = max(onward)
        chosen.append(_Choice(i, side, (min(max(a, before), until), until)))
        before, i, side, until = until, next_i, next_side, to
    return (*chosen, _Choice(i, side, (end, end)))


def _where_positive(gap: Array) -> list[tuple[float, float]]:
    """The intervals of the route parameter in which the piecewise linear `gap` (value at each vertex) is not negative."""
    spans: list[tuple[float, float]] = []
    for k in range(len(gap) - 1):
        a, b = float(gap[k]), float(gap[k + 1])
        if a < -TOLERANCE and b < -TOLERANCE:
            continue
        first = float(k) if a >= -TOLERANCE else k + a / (a - max(b, 0.0))
        final = float(k + 1) if b >= -TOLERANCE else k + max(a, 0.0) / (max(a, 0.0) - b)
        if spans and first - spans[-1][1] < TOLERANCE:
            spans[-1] = (spans[-1][0], final)
        else:
            spans.append((first, final))
    return spans


def bounds_by_stretch(
    arena: Arena, sides: tuple[tuple[Stay, ...], ...], changes: tuple[tuple[int, ...], ...], count: int
) -> Array:
    """Bounds on the edges in each of `count` stretches of time: shape (count, 2, n), [k, 0] bounds the lower edge from
    below, [k, 1] the upper edge from above. `changes[j][q]` is the stretch at which choice q of U_j ends."""
    bounds = np.repeat(arena.space[None], count, axis=0)
    for j, stays in enumerate(sides):
        first = 0
        for stay, last in zip(stays, changes[j], strict=True):
            i = stay.dimension
            if stay.side == BELOW:
                bounds[first:last, 1, i] = np.minimum(bounds[first:last, 1, i], arena.unsafe[j, 0, i] - arena.clearance)
            else:
                bounds[first:last, 0, i] = np.maximum(bounds[first:last, 0, i], arena.unsafe[j, 1, i] + arena.clearance)
            first = last
    return bounds
