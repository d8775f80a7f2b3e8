"""Random reach-avoid arenas, the same for every test and benchmark: a seed gives axis-aligned cubes in [0, side]^n.

Start [0, 0.5]^n, target [side - 0.5, side]^n, 9 s. Unsafe cubes touch neither and may overlap one another. Four unit
squares in [0, 5]^2 is the paper's benchmark.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stt_codegen.task import Task, parse_task

BOX = 0.5
Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Family:
    """A family of arenas: so many cubes of this size in [0, side]^dimension."""

    name: str
    count: int = 4
    size: float = 1.0
    dimension: int = 2
    side: float = 5.0


FAMILIES = {
    f.name: f
    for f in (
        Family("paper"),
        Family("dense12", count=12, size=0.6),
        Family("dense24", count=24, size=0.5),
        Family("space3", count=20, dimension=3),
        Family("space6", count=10, dimension=6),
    )
}


def cubes(family: Family, seed: int) -> Array:
    """The unsafe cubes of one arena, shape (count, dimension, 2): lower and upper edge by dimension."""
    random = np.random.default_rng(seed)
    n, side = family.dimension, family.side
    free = (np.array([[0.0, BOX]] * n), np.array([[side - BOX, side]] * n))
    found: list[Array] = []
    while len(found) < family.count:
        corner = random.uniform(0.0, side - family.size, n)
        cube = np.stack([corner, corner + family.size], axis=1)
        if not any(np.all((cube[:, 0] < f[:, 1]) & (f[:, 0] < cube[:, 1])) for f in free):
            found.append(cube)
    return np.array(found)


def arena_text(family: Family, seed: int, clearance: float = 0.03, min_width: float = 0.05) -> str:
    """One arena as the text of a task file."""
    n, side = family.dimension, family.side

    def box(lower: float, upper: float) -> str:
        return f"lower = {[lower] * n}\nupper = {[upper] * n}\n"

    parts = [
        f'name = "arena"\nprescribed_time = 9.0\ninitial_state = {[BOX / 2] * n}\n',
        "[state_space]\n" + box(0.0, side),
        "[initial_set]\n" + box(0.0, BOX),
        "[target_set]\n" + box(side - BOX, side),
        f"[tube]\nclearance = {clearance}\nmin_width = {min_width}\n",
    ]
    for k, cube in enumerate(cubes(family, seed), 1):
        parts.append(f'[[unsafe]]\nname = "U{k}"\nlower = {cube[:, 0].tolist()}\nupper = {cube[:, 1].tolist()}\n')
    return "\n".join(parts)


def arena_task(family: Family, seed: int, clearance: float = 0.03, min_width: float = 0.05) -> Task:
    """One arena as a task."""
    return parse_task(arena_text(family, seed, clearance, min_width), f"{family.name} {seed}")


def feasible(family: Family, seed: int, reach: float) -> bool:
    """Whether a point can go from the start's centre to the target's centre when every cube grows, and the space
    shrinks, by `reach` < 0.25. Exact: flood fill of the cells between the cubes' edges."""
    boxes, side, n = cubes(family, seed), family.side, family.dimension
    edges = []
    for i in range(n):
        grown = np.concatenate([boxes[:, i, 0] - reach, boxes[:, i, 1] + reach])
        inner = grown[(grown > reach) & (grown < side - reach)]
        edges.append(np.unique(np.concatenate([inner, [reach, side - reach]])))
    free = np.ones([len(axis) - 1 for axis in edges], dtype=bool)
    for box in boxes:
        spans = []
        for i, axis in enumerate(edges):
            middles = (axis[:-1] + axis[1:]) / 2
            spans.append(slice(*np.searchsorted(middles, (box[i, 0] - reach, box[i, 1] + reach))))
        free[tuple(spans)] = False

    def cell(value: float) -> tuple[int, ...]:
        return tuple(int(np.searchsorted(axis, value, side="right")) - 1 for axis in edges)

    start, goal = cell(BOX / 2), cell(side - BOX / 2)
    if not (free[start] and free[goal]):
        return False
    free[start] = False
    stack = [start]
    while stack:
        here = stack.pop()
        if here == goal:
            return True
        for i in range(n):
            for step in (-1, 1):
                there = (*here[:i], here[i] + step, *here[i + 1 :])
                if 0 <= there[i] < free.shape[i] and free[there]:
                    free[there] = False
                    stack.append(there)
    return False
