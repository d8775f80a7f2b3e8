"""Where a route may end: a box for the tube's centre in a target that half-spaces cut."""

from __future__ import annotations

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs.solver import Rows, least


def inner_box(arena: Arena, goal: Array, inset: Array) -> Array | None:
    """The largest box of the target's proportions, `goal` (2, n), for the centres of boxes of these half widths that lie in all
    that cuts space and target; None where there is none."""
    n, half = arena.dimension, (goal[1] - goal[0]) / 2
    if (half < 0).any():
        return None
    normal = np.concatenate([arena.walls.normal, arena.goals.normal])
    low = np.concatenate([arena.walls.bound, arena.goals.bound])
    rows: list[tuple[list[int], list[float]]] = []
    for row in normal.tolist():
        size = 0.0
        for c, h in zip(row, half.tolist(), strict=True):
            size += abs(c) * h
        rows.append(([*range(n), n], [*row, -size]))
    for i, r in enumerate(inset.tolist()):
        low = low + np.abs(normal[:, i]) * r
    for i in range(n):
        rows += [([i, n], [1.0, -float(half[i])]), ([i, n], [1.0, float(half[i])])]
    ends = np.array([v for i in range(n) for v in (goal[0, i], goal[1, i])])
    lower = np.concatenate([low, np.where(np.arange(2 * n) % 2 == 0, ends, -np.inf)])
    upper = np.concatenate([np.full(len(low), np.inf), np.where(np.arange(2 * n) % 2 == 1, ends, np.inf)])
    free = np.append(np.full(n, -np.inf), 0.0), np.append(np.full(n, np.inf), 1.0)
    solution = least(np.append(np.zeros(n), -1.0), *free, Rows.of(rows), lower, upper)
    if solution is None:
        return None
    centre, share = solution[:n], float(solution[n])
    return np.stack([centre - share * half, centre + share * half])
