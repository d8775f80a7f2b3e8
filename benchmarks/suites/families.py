"""Random reach-avoid arenas, the same for every test and benchmark: a seed gives axis-aligned cubes in [0, side]^n, or balls and
polytopes within such cubes.

Start [0, 0.5]^n, target [side - 0.5, side]^n, 9 s. Unsafe cubes touch neither and may overlap one another. Four unit
squares in [0, 5]^2 is the paper's benchmark. A corridor is long in its first dimension and has upright slabs one behind the
other, with gaps between.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from stt_codegen.task.load import parse_task
from stt_codegen.task.task import Task

BOX = 0.5
CORNERS = 6  # points of a polytope
FINE = {2: 0.02, 3: 0.05}  # cells of the search that tells whether shapes leave a way
Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Family:
    """A family of arenas: so many cubes of this size in [0, side]^dimension, or in a corridor of this length. `reach`: an arena
    counts as feasible when a point keeps this much from every unsafe set."""

    name: str
    count: int = 4
    size: float = 1.0
    dimension: int = 2
    side: float = 5.0
    reach: float = 0.1
    length: float | None = None
    shape: Literal["cube", "ball", "polytope"] = "cube"

    @property
    def upper(self) -> tuple[float, ...]:
        """The upper corner of the state space."""
        return (self.length or self.side, *[self.side] * (self.dimension - 1))

    @property
    def prescribed_time(self) -> float:
        """Seconds; a corridor takes as long a unit as the paper's arena."""
        return 9.0 * self.upper[0] / self.side


FAMILIES = {
    f.name: f
    for f in (
        Family("paper"),
        Family("dense12", count=12, size=0.6, reach=0.13),
        Family("dense24", count=24, size=0.5, reach=0.13),
        Family("space3", count=20, dimension=3, reach=0.13),
        Family("space6", count=10, dimension=6, reach=0.13),
        Family("corridor", count=1000, length=500.0, reach=0.06),
        Family("discs", count=8, reach=0.13, shape="ball"),
        Family("balls", count=8, size=2.0, dimension=3, reach=0.13, shape="ball"),
        Family("polygons", count=20, size=0.8, reach=0.13, shape="polytope"),
        Family("solids", count=20, size=1.4, dimension=3, reach=0.13, shape="polytope"),
    )
}


def cubes(family: Family, seed: int) -> Array:
    """The unsafe cubes of one arena, shape (count, dimension, 2): lower and upper edge by dimension."""
    random = np.random.default_rng(seed)
    n, side = family.dimension, family.side
    if family.length is not None:
        pitch = (family.length - 4.0) / family.count
        left = 2.0 + pitch * np.arange(family.count)
        low = random.uniform(0.0, side - family.size, family.count)
        thick = min(family.size, 0.6 * pitch)
        return np.stack([np.stack([left, left + thick], axis=1), np.stack([low, low + family.size], axis=1)], axis=1)
    free = (np.array([[0.0, BOX]] * n), np.array([[side - BOX, side]] * n))
    found: list[Array] = []
    while len(found) < family.count:
        corner = random.uniform(0.0, side - family.size, n)
        cube = np.stack([corner, corner + family.size], axis=1)
        if not any(np.all((cube[:, 0] < f[:, 1]) & (f[:, 0] < cube[:, 1])) for f in free):
            found.append(cube)
    return np.array(found)


def tables(family: Family, seed: int) -> list[str]:
    """The unsafe sets of one arena as lines of a task file: the cubes, the balls in them, or hulls of points in them."""
    random, found = np.random.default_rng((seed, 1)), []
    for cube in cubes(family, seed):
        low, high = cube[:, 0], cube[:, 1]
        if family.shape == "ball":
            found.append(f"centre = {((low + high) / 2).tolist()}\nradius = {family.size / 2}")
        elif family.shape == "polytope":
            points = np.round(random.uniform(low, high, (CORNERS, family.dimension)), 3)
            found.append(f"vertices = {points.tolist()}")
        else:
            found.append(f"lower = {low.tolist()}\nupper = {high.tolist()}")
    return found


def arena_text(family: Family, seed: int, clearance: float = 0.03, min_width: float = 0.05) -> str:
    """One arena as the text of a task file."""
    n, upper = family.dimension, list(family.upper)

    def box(low: list[float], high: list[float]) -> str:
        return f"lower = {low}\nupper = {high}\n"

    parts = [
        f'name = "arena"\nprescribed_time = {family.prescribed_time}\ninitial_state = {[BOX / 2] * n}\n',
        "[state_space]\n" + box([0.0] * n, upper),
        "[initial_set]\n" + box([0.0] * n, [BOX] * n),
        "[target_set]\n" + box([v - BOX for v in upper], upper),
        f"[tube]\nclearance = {clearance}\nmin_width = {min_width}\n",
    ]
    for k, table in enumerate(tables(family, seed), 1):
        parts.append(f'[[unsafe]]\nname = "U{k}"\n{table}\n')
    return "\n".join(parts)


def arena_task(family: Family, seed: int, clearance: float = 0.03, min_width: float = 0.05) -> Task:
    """One arena as a task."""
    return parse_task(arena_text(family, seed, clearance, min_width), f"{family.name} {seed}")


def feasible(family: Family, seed: int, reach: float | None = None) -> bool:
    """Whether a point can go from the start's centre to the target's centre when every cube grows, and the space
    shrinks, by `reach` < 0.25 (the family's when None). Exact: flood fill of the cells between the cubes' edges. Of other shapes
    fine cells count by their middles."""
    if family.shape != "cube":
        return _fine(family, seed, family.reach if reach is None else reach)
    boxes, n = cubes(family, seed), family.dimension
    reach = family.reach if reach is None else reach
    edges = []
    for i in range(n):
        grown = np.concatenate([boxes[:, i, 0] - reach, boxes[:, i, 1] + reach])
        end = family.upper[i] - reach
        inner = grown[(grown > reach) & (grown < end)]
        edges.append(np.unique(np.concatenate([inner, [reach, end]])))
    free = np.ones([len(axis) - 1 for axis in edges], dtype=bool)
    for box in boxes:
        spans = []
        for i, axis in enumerate(edges):
            middles = (axis[:-1] + axis[1:]) / 2
            spans.append(slice(*np.searchsorted(middles, (box[i, 0] - reach, box[i, 1] + reach))))
        free[tuple(spans)] = False

    return _joined(family, edges, free)


def _fine(family: Family, seed: int, reach: float) -> bool:
    """Cells of FINE: free where the middle keeps `reach`, in the largest component, from every true set and from the walls."""
    n, step = family.dimension, FINE[family.dimension]
    edges = [np.linspace(reach, v - reach, round((v - 2 * reach) / step) + 1) for v in family.upper]
    middles = [(axis[:-1] + axis[1:]) / 2 for axis in edges]
    points = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1)
    free = np.ones(points.shape[:-1], dtype=bool)
    for one in arena_task(family, seed).unsafe_sets:
        if family.shape == "ball":
            core = [(float(one.segment_ends[0][i]),) * 2 for i in range(n)]
            gaps = [
                np.maximum(np.maximum(a - reach - points[..., i], points[..., i] - b - reach), 0) for i, (a, b) in enumerate(core)
            ]
            free &= np.sum(np.square(gaps), axis=0) >= float(one.radius) ** 2
        else:
            beyond = [
                points @ np.array(normal, dtype=float) >= float(offset) + reach * sum(map(abs, normal))
                for normal, offset in one.faces
            ]
            free &= np.any(beyond, axis=0)
    return _joined(family, edges, free)


def _joined(family: Family, edges: list[Array], free: npt.NDArray[np.bool_]) -> bool:
    """Whether free cells lead from the start's centre to the target's."""
    n = family.dimension

    def cell(point: list[float]) -> tuple[int, ...]:
        return tuple(int(np.searchsorted(axis, v, side="right")) - 1 for axis, v in zip(edges, point, strict=True))

    start, goal = cell([BOX / 2] * n), cell([v - BOX / 2 for v in family.upper])
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
