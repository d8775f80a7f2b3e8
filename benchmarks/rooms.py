"""Design tubes in random concave rooms, and check them by the corners of the rooms alone.

    python -m benchmarks rooms [--count 500] [--seed 0] [--parts 8] [--every 10] [--record FILE.md]

Half of the rooms are mazes of corridors, with straight or slanted walls. A block of walls that corridors surround is a pillar.
Half are stars with pillars. Some have a body, some a third axis. At several times of each segment of a certified tube its exact
box must lie in the room (benchmarks/oracles/rooms.py, which shares nothing with the package). The unsafe sets must be an exact
partition of the complement of the room in its box. The stand-alone checker must verify every tenth room.

A room has a passage if a box a fifth larger than the narrowest tube gets from start to target on a grid. The exit code is 1 if a
certified tube is outside, the sets are no partition, the checker refuses, or fewer than 99 % of the rooms with a passage are
certified.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import math
import random
import sys
import tempfile
import time
from collections import Counter, deque
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.oracles.rooms import (
    ListedRoom,
    contains_box,
    corners_of,
    partition_fault,
    room_from_numbers,
    sides,
    times_outside,
)
from benchmarks.suites.report import command, machine, record
from stt_codegen.checker import check_files
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task
from stt_codegen.task.load import parse_task

CLEARANCE, MIN_WIDTH = 0.03, 0.05
END_HALF_WIDTH = 0.06  # of start and target
REQUIRED_RATIO = 0.99  # of the rooms with a passage that must be certified
PASSAGE_FACTOR = 1.2  # a room has a passage if a box so many times as large as the narrowest tube gets through
GRID_STEP = 0.1  # of the grid on which a passage is searched
NOTE = """Half are mazes with straight or slanted walls and pillars, half stars with pillars; some with a body, some with a third
axis. With a passage: a box a fifth larger than the narrowest tube gets through on a grid of 0.1. Others: no such box does.
Wrong: one of three tests fails. (1) The box of the tube is in the room and not nearer to a wall than the clearance, at eight
times in every segment (--parts changes this). (2) The sets are an exact partition of the complement of the room in its box. (3)
The stand-alone checker verifies the files; it runs for every tenth room."""
CornerList = list[list[float]]


@dataclass(frozen=True)
class DrawnRoom:
    """A room with start and target, as numbers of a task file.

    axes: the indices, among x, y, z, of the two axes of the outline; None for a task with two axes."""

    outline: CornerList
    holes: list[CornerList]
    start: tuple[float, float]
    target: tuple[float, float]
    body: tuple[float, float]
    axes: tuple[int, int] | None

    @property
    def listed_room(self) -> ListedRoom:
        return room_from_numbers(self.outline, self.holes)


def maze_cells(rng: random.Random) -> list[list[bool]]:
    """Return which cells of a maze are free. A cell with two even indices is a room of the maze and free. A cell between two
    rooms is free if it is a door: the doors of a spanning tree, and 15 % of the others."""
    size = rng.choice((2, 3, 3, 4))
    free = [[i % 2 == 0 and j % 2 == 0 for j in range(2 * size - 1)] for i in range(2 * size - 1)]
    visited, stack = {(0, 0)}, [(0, 0)]
    while stack:
        i, j = stack[-1]
        near = [(i + a, j + b) for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))]
        near = [v for v in near if v not in visited and min(v) >= 0 and max(v) < size]
        if not near:
            stack.pop()
            continue
        p, q = rng.choice(near)
        free[i + p][j + q] = True
        visited.add((p, q))
        stack.append((p, q))
    for i in range(2 * size - 1):
        for j in range(2 * size - 1):
            free[i][j] |= (i + j) % 2 == 1 and rng.random() < 0.15
    return free


def boundary_polygons(free: list[list[bool]]) -> list[list[tuple[int, int]]]:
    """Return the polygons that bound the free cells, the outline first. A polygon is the list of its corners in order."""
    size = len(free)
    sides = {}

    def at(i: int, j: int) -> bool:
        return 0 <= i < size and 0 <= j < size and free[i][j]

    for i in range(size):
        for j in range(size):
            if free[i][j]:  # with the free cell to the left
                for p, q, a, b in ((i, j - 1, (i, j), (i + 1, j)), (i + 1, j, (i + 1, j), (i + 1, j + 1)),
                                   (i, j + 1, (i + 1, j + 1), (i, j + 1)), (i - 1, j, (i, j + 1), (i, j))):  # fmt: skip
                    if not at(p, q):
                        sides[a] = b
    polygons = []
    while sides:
        ring = [min(sides)]
        while ring[-1] in sides:
            ring.append(sides.pop(ring[-1]))
        ring.pop()
        triples = zip([ring[-1], *ring[:-1]], ring, [*ring[1:], ring[0]], strict=True)
        polygons.append([b for a, b, c in triples if (a[0] == b[0]) != (b[0] == c[0])])
    return sorted(polygons, key=min)


def maze(rng: random.Random) -> tuple[CornerList, list[CornerList], list[tuple[float, float]]]:
    """Draw a maze. Return outline, holes, and the middles of free cells. In a slanted maze every corner is moved a little."""
    free, smallest_cell = maze_cells(rng), rng.choice((0.45, 0.8))
    cell_boundaries = [[0.0], [0.0]]  # by axis
    for boundaries in cell_boundaries:
        for _ in range(len(free)):
            boundaries.append(round(boundaries[-1] + rng.uniform(smallest_cell, 2 * smallest_cell), 2))
    largest_shift = rng.choice((0.0, 0.22)) * smallest_cell  # less than half of the distance of corners, so that no sides cross

    def moved_corner(corner: tuple[int, int]) -> list[float]:
        return [
            round(axis[v] + rng.uniform(-largest_shift, largest_shift), 3)
            for axis, v in zip(cell_boundaries, corner, strict=True)
        ]

    outline, *holes = [[moved_corner(c) for c in polygon] for polygon in boundary_polygons(free)]
    cells = [(i, j) for i in range(0, len(free), 2) for j in range(0, len(free), 2)]
    middles = [tuple((axis[v] + axis[v + 1]) / 2 for axis, v in zip(cell_boundaries, c, strict=True)) for c in cells]
    return outline, holes, [(round(x, 2), round(y, 2)) for x, y in middles]


def star(rng: random.Random) -> tuple[CornerList, list[CornerList], list[tuple[float, float]]]:
    """Draw a star with pillars. Return outline, holes, and points for start and target."""

    def ring(x: float, y: float, count: int, near: float, far: float) -> CornerList:
        angles = sorted((k + rng.uniform(0.1, 0.9)) * 2 * math.pi / count for k in range(count))
        return [[round(x + r * math.cos(a), 2), round(y + r * math.sin(a), 2)] for a in angles for r in (rng.uniform(near, far),)]

    holes = []
    for cell in rng.sample(range(9), rng.randrange(4)):
        middle = [v - 1 + rng.uniform(-0.1, 0.1) for v in divmod(cell, 3)]
        holes.append(ring(*middle, rng.randrange(3, 8), 0.12, 0.35))
    outline = ring(0, 0, rng.randrange(6, 17), 2.2, 5)
    angle, distance = rng.uniform(0, 7), rng.uniform(1.7, 2.2)
    points = [(round(distance * math.cos(angle + k), 2), round(distance * math.sin(angle + k), 2)) for k in range(6)]
    return outline, holes, points


def draw_room(seed: int) -> DrawnRoom:
    """Draw the room of a seed, with a start and a target that lie in it."""
    rng = random.Random(seed)
    while True:
        outline, holes, points = (maze if seed % 2 else star)(rng)
        body = rng.choice(((0.0, 0.0), (0.05, 0.08)))
        axes = rng.choice((None, None, (0, 1), (2, 0)))
        rng.shuffle(points)
        if rng.random() < 0.5:
            outline = outline[::-1]
        listed_room = room_from_numbers(outline, holes)
        inside = [
            p for p in points if contains_box(listed_room, box_about(p, [END_HALF_WIDTH + b + 2 * CLEARANCE for b in body]))
        ]
        if len(inside) > 1:
            far = max(inside[1:], key=lambda p: math.dist(p, inside[0]))
            return DrawnRoom(outline, holes, inside[0], far, body, axes)


def box_about(point: tuple[float, float], half: list[float]) -> Any:
    """Return lower and upper edges of the box with this centre and these half widths, as exact decimals."""
    middle, sizes = ([Fraction(str(v)) for v in values] for values in (point, half))
    return tuple([m + s * h for m, h in zip(middle, sizes, strict=True)] for s in (-1, 1))


def task_text(room_draw: DrawnRoom) -> str:
    """Return the text of the task file. A third axis goes from -1 to 1, with start and target near its ends."""
    axes = room_draw.axes

    def vector(plane: Any, rest: float) -> list[float]:
        if axes is None:
            return [round(v, 6) for v in plane]
        values = [rest] * 3
        for i, v in zip(axes, plane, strict=True):
            values[i] = round(v, 6)
        return values

    def box(name: str, middle: tuple[float, float], rest: float) -> list[str]:
        ends = ((f, vector([v + s * END_HALF_WIDTH for v in middle], rest + s * 0.1)) for f, s in (("lower", -1), ("upper", 1)))
        return [f"[{name}]", *(f"{f} = {values}" for f, values in ends)]

    lines = ['name = "room"', "prescribed_time = 20", f"initial_state = {vector(room_draw.start, -0.8)}"]
    lines += [f"body = {vector(room_draw.body, 0.0)}"] if any(room_draw.body) else []
    space = ["[state_space]", f"outline = {room_draw.outline}", f"holes = {room_draw.holes}"]
    if axes is not None:
        lines.append('axes = ["x", "y", "z"]')
        space += [f"axes = {[('x', 'y', 'z')[i] for i in axes]}".replace("'", '"'), "lower = [-1.0]", "upper = [1.0]"]
    lines += [*space, *box("initial_set", room_draw.start, -0.8), *box("target_set", room_draw.target, 0.8)]
    return "\n".join([*lines, "[tube]", f"clearance = {CLEARANCE}", f"min_width = {MIN_WIDTH}"]) + "\n"


def has_passage(room_draw: DrawnRoom) -> bool:
    """Return whether a box PASSAGE_FACTOR times the narrowest tube with its clearance gets from start to target over a grid.

    The box that contains both ends of a step must be free. It is computed in doubles: it decides only whether a refused room
    counts as a miss.
    """
    half = np.array([(MIN_WIDTH / 2 + CLEARANCE + b) * PASSAGE_FACTOR for b in room_draw.body])
    ends = [np.array(side, dtype=float) for polygon in room_draw.listed_room.polygons for side in sides(polygon)]
    a, b = np.array([e[0] for e in ends]), np.array([e[1] for e in ends])

    def is_free(p: Any, q: Any) -> bool:
        low, high = np.minimum(p, q) - half, np.maximum(p, q) + half
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.stack([(low - a) / (b - a), (high - a) / (b - a)])
        inside = (a > low) & (a < high)
        first = np.where(a == b, np.where(inside, -1, 2), t.min(axis=0)).max(axis=1)
        last = np.where(a == b, np.where(inside, 2, -1), t.max(axis=0)).min(axis=1)
        return not (np.maximum(first, 0) < np.minimum(last, 1)).any()

    start, target = np.array(room_draw.start), np.array(room_draw.target)
    visited, queue = {(0, 0)}, deque([(0, 0)])
    while queue:
        cell = queue.popleft()
        point = start + GRID_STEP * np.array(cell)
        if np.abs(point - target).max() <= GRID_STEP and is_free(point, target):
            return True
        for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            beside = (cell[0] + step[0], cell[1] + step[1])
            if beside not in visited and is_free(point, start + GRID_STEP * np.array(beside)):
                visited.add(beside)
                queue.append(beside)
    return False


@dataclass(frozen=True)
class RoomResult:
    """The result of a room. outcome: "certified", "refused", or a message of what is wrong. seconds: to design and certify, of
    the processor. has_passage: computed for refused and certified rooms; True for all others."""

    outcome: str
    has_passage: bool
    set_count: int
    seconds: float


def judge_room(seed: int, times_per_segment: int, runs_checker: bool) -> RoomResult:
    """Design a tube in the room of a seed, and check it. runs_checker: whether the stand-alone checker runs, too."""
    room_draw = draw_room(seed)
    listed_room, task = room_draw.listed_room, parse_task(task_text(room_draw))
    if fault := partition_fault(listed_room, [corners_of(table) for table in task.unsafe]):
        return RoomResult(fault, True, len(task.unsafe), 0.0)
    begin = time.process_time()
    try:
        controller = build_task(task)
    except NotCertified:
        return RoomResult("refused", has_passage(room_draw), len(task.unsafe), time.process_time() - begin)
    seconds = time.process_time() - begin
    axes = room_draw.axes or (0, 1)
    body = [Fraction(0)] * task.dimension if task.body is None else list(task.body)
    outside = times_outside(
        listed_room, controller.design, axes, body, clearance=Fraction(str(CLEARANCE)), times_per_segment=times_per_segment
    )
    if outside:
        return RoomResult(f"{len(outside)} times outside, first at {float(outside[0]):g} s", True, len(task.unsafe), seconds)
    refusal = checker_refusal(controller.files) if runs_checker else ""
    return RoomResult(refusal or "certified", has_passage(room_draw), len(task.unsafe), seconds)


def checker_refusal(files: dict[str, bytes]) -> str:
    """Return the message with which the stand-alone checker refuses these files; an empty text where it verifies them."""
    with tempfile.TemporaryDirectory() as folder:
        for name, data in files.items():
            Path(folder, name).write_bytes(data)
        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
            code = check_files([f"{folder}/room.{end}" for end in ("task.toml", "c", "certificate.json")])
    return output.getvalue().strip() if code else ""


def main() -> int:
    """Judge all rooms, and print a summary. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0, help="of the first room")
    parser.add_argument("--parts", type=int, default=8, help="times in every segment at which the tube is checked")
    parser.add_argument("--every", type=int, default=10, help="the stand-alone checker runs for one in so many rooms")
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    results = []
    for seed in range(options.seed, options.seed + options.count):
        result = judge_room(seed, options.parts, seed % options.every == 0)
        results.append(result)
        if result.outcome != "certified" and (result.outcome != "refused" or result.has_passage):
            print(f"seed {seed}: {result.outcome}{', has a passage' if result.has_passage else ''}")
    outcomes = Counter((v.outcome if v.outcome in ("certified", "refused") else "wrong", v.has_passage) for v in results)
    certified, wrong = outcomes["certified", True], outcomes["wrong", True]
    passable_count = certified + outcomes["refused", True]
    set_counts, milliseconds = [v.set_count for v in results], [1e3 * v.seconds for v in results]
    text = (
        f"{options.count} rooms: {certified} of {passable_count} with a passage certified, {outcomes['certified', False]} of "
        f"{options.count - passable_count - wrong} others; {wrong} wrong; "
        f"sets, median / largest: {np.median(set_counts):g} / {max(set_counts)}; "
        f"design and certificate, ms, median / 95 %: {np.median(milliseconds):.3g} / {np.quantile(milliseconds, 0.95):.3g}"
    )
    print(text)
    if options.record:
        record(options.record, "rooms", f"## Concave rooms\n\nMade by `{command()}`; {machine()}.\n\n{text}.\n\n{NOTE}\n")
    return 1 if wrong or certified < REQUIRED_RATIO * passable_count else 0


if __name__ == "__main__":
    sys.exit(main())
