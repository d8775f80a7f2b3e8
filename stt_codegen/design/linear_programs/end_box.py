"""Where a route may end: a box for the tube's centre in a target that half-spaces cut.

Routes (routes/, spacetime/) end in it, and missions ask it for the regions that are visited.
"""

from __future__ import annotations

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs.solver import ProgramBounds, Rows, minimise


def inner_box(arena: Arena, goal: Array, half_width: Array) -> Array | None:
    """Return the largest box with the proportions of `goal` in which a tube's centre may be, (2, n); None where there is none.

    goal: (2, n), the target for the centre. half_width: (n,), of the tube. A box of these half widths about any point of
    the result lies in all half-spaces that cut the space and the target. One linear program finds the box's centre and its size
    relative to the goal.
    """
    n, half = arena.dimension, (goal[1] - goal[0]) / 2
    if (half < 0).any():
        return None
    normal = np.concatenate([arena.space_cuts.normal, arena.target_cuts.normal])
    low = np.concatenate([arena.space_cuts.lower_bound, arena.target_cuts.lower_bound])
    rows: list[tuple[list[int], list[float]]] = []
    for row in normal.tolist():
        size = 0.0
        for c, h in zip(row, half.tolist(), strict=True):
            size += abs(c) * h
        rows.append(([*range(n), n], [*row, -size]))
    for i, r in enumerate(half_width.tolist()):
        low = low + np.abs(normal[:, i]) * r
    for i in range(n):
        rows += [([i, n], [1.0, -float(half[i])]), ([i, n], [1.0, float(half[i])])]
    ends = np.array([v for i in range(n) for v in (goal[0, i], goal[1, i])])
    bounds = ProgramBounds(
        lower=np.append(np.full(n, -np.inf), 0.0),
        upper=np.append(np.full(n, np.inf), 1.0),
        row_lower=np.concatenate([low, np.where(np.arange(2 * n) % 2 == 0, ends, -np.inf)]),
        row_upper=np.concatenate([np.full(len(low), np.inf), np.where(np.arange(2 * n) % 2 == 1, ends, np.inf)]),
    )
    solution = minimise(np.append(np.zeros(n), -1.0), Rows.of(rows), bounds)
    if solution is None:
        return None
    centre, size_ratio = solution[:n], float(solution[n])
    return np.stack([centre - size_ratio * half, centre + size_ratio * half])
