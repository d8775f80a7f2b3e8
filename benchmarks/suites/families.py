"""Random reach-avoid arenas, the same for every test and benchmark.

A seed gives axis-aligned cubes in [0, side]^n, or balls and polytopes within such cubes. The start is [0, 0.5]^n, the target
[side - 0.5, side]^n, the prescribed time 9 s. Unsafe cubes touch neither, and may overlap each other. Four unit squares in
[0, 5]^2 are the paper's benchmark. A corridor is long in its first dimension, and has upright slabs with gaps between them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from stt_codegen.task.load import parse_task
from stt_codegen.task.task import Task

BOX = 0.5  # width of start and target
POLYTOPE_POINTS = 6  # whose hull is a polytope
CELL_SIZES = {2: 0.02, 3: 0.05}  # by dimension, of the grid on which a way among balls and polytopes is searched
Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Family:
    """A family of arenas: `count` cubes of this size in [0, side]^dimension, or in a corridor of this length.

    reach: an arena counts as feasible when a point gets to the target at this distance from every unsafe set. shape: of the
    unsafe sets, each in its cube.
    """

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
        """Seconds; per unit of length a corridor has as many as the paper's arena."""
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
    """Return the unsafe cubes of one arena, (count, dimension, 2): lower and upper edge by dimension."""
    rng = np.random.default_rng(seed)
    n, side = family.dimension, family.side
    if family.length is not None:
        pitch = (family.length - 4.0) / family.count
        left = 2.0 + pitch * np.arange(family.count)
        low = rng.uniform(0.0, side - family.size, family.count)
        thick = min(family.size, 0.6 * pitch)
        return np.stack([np.stack([left, left + thick], axis=1), np.stack([low, low + family.size], axis=1)], axis=1)
    start_and_target = (np.array([[0.0, BOX]] * n), np.array([[side - BOX, side]] * n))
    accepted: list[Array] = []
    while len(accepted) < family.count:
        corner = rng.uniform(0.0, side - family.size, n)
        cube = np.stack([corner, corner + family.size], axis=1)
        if not any(np.all((cube[:, 0] < box[:, 1]) & (box[:, 0] < cube[:, 1])) for box in start_and_target):
            accepted.append(cube)
    return np.array(accepted)


def unsafe_tables(family: Family, seed: int) -> list[str]:
    """Return the unsafe sets of one arena as text of a task file: the cubes, the balls in them, or hulls of points in them."""
    rng, texts = np.random.default_rng((seed, 1)), []
    for cube in cubes(family, seed):
        low, high = cube[:, 0], cube[:, 1]
        if family.shape == "ball":
            texts.append(f"centre = {((low + high) / 2).tolist()}\nradius = {family.size / 2}")
        elif family.shape == "polytope":
            points = np.round(rng.uniform(low, high, (POLYTOPE_POINTS, family.dimension)), 3)
            texts.append(f"vertices = {points.tolist()}")
        else:
            texts.append(f"lower = {low.tolist()}\nupper = {high.tolist()}")
    return texts


def arena_text(family: Family, seed: int, clearance: float = 0.03, min_width: float = 0.05) -> str:
    """Return one arena as the text of a task file."""
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
    for k, table in enumerate(unsafe_tables(family, seed), 1):
        parts.append(f'[[unsafe]]\nname = "U{k}"\n{table}\n')
    return "\n".join(parts)


def arena_task(family: Family, seed: int, clearance: float = 0.03, min_width: float = 0.05) -> Task:
    """Return one arena as a task."""
    return parse_task(arena_text(family, seed, clearance, min_width), f"{family.name} {seed}")


def is_feasible(family: Family, seed: int, reach: float | None = None) -> bool:
    """Return whether a point gets from the start's centre to the target's at a distance of `reach` from every set and wall.

    reach: below 0.25; None for the family's. The answer is exact for cubes: flood fill of the cells between their grown edges.
    Among other shapes it is about the middles of small cells.
    """
    if family.shape != "cube":
        return _is_feasible_on_grid(family, seed, family.reach if reach is None else reach)
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

    return _has_path(family, edges, free)


def _is_feasible_on_grid(family: Family, seed: int, reach: float) -> bool:
    """Return whether a path of cells exists whose middles keep `reach`, by component, from every set and from the walls."""
    step = CELL_SIZES[family.dimension]
    edges = [np.linspace(reach, v - reach, round((v - 2 * reach) / step) + 1) for v in family.upper]
    middles = [(axis[:-1] + axis[1:]) / 2 for axis in edges]
    points = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1)
    free = np.ones(points.shape[:-1], dtype=bool)
    for unsafe in arena_task(family, seed).unsafe_sets:
        if family.shape == "ball":
            centre = [float(v) for v in unsafe.segment_ends[0]]
            gaps = [
                np.maximum(np.maximum(c - reach - points[..., i], points[..., i] - c - reach), 0) for i, c in enumerate(centre)
            ]
            free &= np.sum(np.square(gaps), axis=0) >= float(unsafe.radius) ** 2
        else:
            is_beyond_face = [
                points @ np.array(normal, dtype=float) >= float(offset) + reach * sum(map(abs, normal))
                for normal, offset in unsafe.faces
            ]
            free &= np.any(is_beyond_face, axis=0)
    return _has_path(family, edges, free)


def _has_path(family: Family, edges: list[Array], free: npt.NDArray[np.bool_]) -> bool:
    """Return whether free cells lead from the start's centre to the target's. edges: of the cells, by axis. Changes `free`."""
    n = family.dimension

    def cell(point: list[float]) -> tuple[int, ...]:
        return tuple(int(np.searchsorted(axis, v, side="right")) - 1 for axis, v in zip(edges, point, strict=True))

    start, goal = cell([BOX / 2] * n), cell([v - BOX / 2 for v in family.upper])
    if not (free[start] and free[goal]):
        return False
    free[start] = False
    stack = [start]
    while stack:
        current = stack.pop()
        if current == goal:
            return True
        for i in range(n):
            for step in (-1, 1):
                neighbour = (*current[:i], current[i] + step, *current[i + 1 :])
                if 0 <= neighbour[i] < free.shape[i] and free[neighbour]:
                    free[neighbour] = False
                    stack.append(neighbour)
    return False
