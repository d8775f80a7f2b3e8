"""Concave rooms at random, by outline and holes: designed and certified, and judged by the listed corners alone.

    python -m benchmarks rooms [--count 500] [--seed 0] [--parts 8] [--every 10] [--record FILE.md]

Half of the rooms are mazes of corridors, with straight and with slanted walls, pillars where corridors go around; half are stars
with pillars. Some have a body, some a third axis. Of each certified tube the exact box, at so many times of every segment, must
lie in the room (oracles/rooms.py, which shares nothing with the package), the sets must be an exact partition of what the room
leaves of its box, and of every tenth room the stand-alone checker must say yes to the task spelled out.

A room counts as one with a way where a box a fifth larger than what the tube needs gets from start to target on a grid. Exit
code 1 where a certified tube is outside, a partition is none, the checker says no, or of the rooms with a way fewer than 99 %
are certified.
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
from stt_codegen.certify import checker
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task
from stt_codegen.task.load import parse_task

CLEARANCE, MIN_WIDTH, HALF = 0.03, 0.05, 0.06  # HALF: of start and target
ENOUGH = 0.99  # of the rooms with a way, certified
LARGER = 1.2
STEP = 0.1  # of the grid on which a way is sought
ABOUT = """Half are mazes with straight or slanted walls and pillars, half stars with pillars; some with a body, some with a third
axis. With a way: a box a fifth larger than the narrowest tube gets through on a grid of 0.1. Wrong: some box of the tube, at
eight times in every segment unless --parts says otherwise, is outside of the listed corners or nearer to a wall than the
clearance; the sets are no exact partition of what the room leaves of its box; or the stand-alone checker, which is asked about
every tenth room, says no. Others: the grid finds no way for that box."""
Listed = list[list[float]]


@dataclass(frozen=True)
class Draw:
    """A room and what is asked in it, as numbers of a task file. axes: the outline's dimensions of x, y, z, or none."""

    outline: Listed
    holes: list[Listed]
    start: tuple[float, float]
    target: tuple[float, float]
    body: tuple[float, float]
    axes: tuple[int, int] | None

    @property
    def room(self) -> ListedRoom:
        return room_from_numbers(self.outline, self.holes)


def corridors(rng: random.Random) -> list[list[bool]]:
    """Free cells of a maze: all of even numbers, and doors of a spanning tree and of some more."""
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


def around_cells(free: list[list[bool]]) -> list[list[tuple[int, int]]]:
    """The corners of what bounds the free cells, each polygon in order."""
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
        turned = zip([ring[-1], *ring[:-1]], ring, [*ring[1:], ring[0]], strict=True)
        polygons.append([b for a, b, c in turned if (a[0] == b[0]) != (b[0] == c[0])])
    return sorted(polygons, key=min)


def maze(rng: random.Random) -> tuple[Listed, list[Listed], list[tuple[float, float]]]:
    """Outline, holes, and the middles of the cells of even numbers. Slanted: every corner is moved a little."""
    free, narrow = corridors(rng), rng.choice((0.45, 0.8))
    edges = [[0.0], [0.0]]
    for axis in edges:
        for _ in range(len(free)):
            axis.append(round(axis[-1] + rng.uniform(narrow, 2 * narrow), 2))
    slanted = rng.choice((0.0, 0.22)) * narrow  # of corners that far apart, so nothing crosses

    def placed(corner: tuple[int, int]) -> list[float]:
        return [round(axis[v] + rng.uniform(-slanted, slanted), 3) for axis, v in zip(edges, corner, strict=True)]

    outline, *holes = [[placed(c) for c in polygon] for polygon in around_cells(free)]
    cells = [(i, j) for i in range(0, len(free), 2) for j in range(0, len(free), 2)]
    middles = [tuple((axis[v] + axis[v + 1]) / 2 for axis, v in zip(edges, c, strict=True)) for c in cells]
    return outline, holes, [(round(x, 2), round(y, 2)) for x, y in middles]


def star(rng: random.Random) -> tuple[Listed, list[Listed], list[tuple[float, float]]]:
    """Outline, holes, and places: corners at random distances around a middle, and pillars that keep apart."""

    def ring(x: float, y: float, count: int, near: float, far: float) -> Listed:
        turns = sorted((k + rng.uniform(0.1, 0.9)) * 2 * math.pi / count for k in range(count))
        return [[round(x + r * math.cos(a), 2), round(y + r * math.sin(a), 2)] for a in turns for r in (rng.uniform(near, far),)]

    holes = []
    for cell in rng.sample(range(9), rng.randrange(4)):
        middle = [v - 1 + rng.uniform(-0.1, 0.1) for v in divmod(cell, 3)]
        holes.append(ring(*middle, rng.randrange(3, 8), 0.12, 0.35))
    outline = ring(0, 0, rng.randrange(6, 17), 2.2, 5)
    turn, way = rng.uniform(0, 7), rng.uniform(1.7, 2.2)
    places = [(round(way * math.cos(turn + k), 2), round(way * math.sin(turn + k), 2)) for k in range(6)]
    return outline, holes, places


def draw(seed: int) -> Draw:
    """A room of a seed, with a start and a target that lie in it."""
    rng = random.Random(seed)
    while True:
        outline, holes, places = (maze if seed % 2 else star)(rng)
        body = rng.choice(((0.0, 0.0), (0.05, 0.08)))
        axes = rng.choice((None, None, (0, 1), (2, 0)))
        rng.shuffle(places)
        if rng.random() < 0.5:
            outline = outline[::-1]
        room = room_from_numbers(outline, holes)
        good = [p for p in places if contains_box(room, box_about(p, [HALF + b + 2 * CLEARANCE for b in body]))]
        if len(good) > 1:
            far = max(good[1:], key=lambda p: math.dist(p, good[0]))
            return Draw(outline, holes, good[0], far, body, axes)


def box_about(point: tuple[float, float], half: list[float]) -> Any:
    middle, sizes = ([Fraction(str(v)) for v in values] for values in (point, half))
    return tuple([m + s * h for m, h in zip(middle, sizes, strict=True)] for s in (-1, 1))


def text_of(drawn: Draw) -> str:
    """The task file. A third axis goes from -1 to 1, start and target at its ends."""
    axes = drawn.axes

    def vector(plane: Any, rest: float) -> list[float]:
        if axes is None:
            return [round(v, 6) for v in plane]
        values = [rest] * 3
        for i, v in zip(axes, plane, strict=True):
            values[i] = round(v, 6)
        return values

    def box(name: str, middle: tuple[float, float], rest: float) -> list[str]:
        ends = ((f, vector([v + s * HALF for v in middle], rest + s * 0.1)) for f, s in (("lower", -1), ("upper", 1)))
        return [f"[{name}]", *(f"{f} = {values}" for f, values in ends)]

    lines = ['name = "room"', "prescribed_time = 20", f"initial_state = {vector(drawn.start, -0.8)}"]
    lines += [f"body = {vector(drawn.body, 0.0)}"] if any(drawn.body) else []
    space = ["[state_space]", f"outline = {drawn.outline}", f"holes = {drawn.holes}"]
    if axes is not None:
        lines.append('axes = ["x", "y", "z"]')
        space += [f"axes = {[('x', 'y', 'z')[i] for i in axes]}".replace("'", '"'), "lower = [-1.0]", "upper = [1.0]"]
    lines += [*space, *box("initial_set", drawn.start, -0.8), *box("target_set", drawn.target, 0.8)]
    return "\n".join([*lines, "[tube]", f"clearance = {CLEARANCE}", f"min_width = {MIN_WIDTH}"]) + "\n"


def has_way(drawn: Draw) -> bool:
    """Whether a box a fifth larger than the narrowest tube with its clearance gets from start to target over a grid, each step
    by a box that holds both ends. In doubles, so that it decides nothing but what is counted."""
    half = np.array([(MIN_WIDTH / 2 + CLEARANCE + b) * LARGER for b in drawn.body])
    ends = [np.array(side, dtype=float) for polygon in drawn.room.polygons for side in sides(polygon)]
    a, b = np.array([e[0] for e in ends]), np.array([e[1] for e in ends])

    def free(p: Any, q: Any) -> bool:
        low, high = np.minimum(p, q) - half, np.maximum(p, q) + half
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.stack([(low - a) / (b - a), (high - a) / (b - a)])
        inside = (a > low) & (a < high)
        first = np.where(a == b, np.where(inside, -1, 2), t.min(axis=0)).max(axis=1)
        last = np.where(a == b, np.where(inside, 2, -1), t.max(axis=0)).min(axis=1)
        return not (np.maximum(first, 0) < np.minimum(last, 1)).any()

    start, target = np.array(drawn.start), np.array(drawn.target)
    visited, queue = {(0, 0)}, deque([(0, 0)])
    while queue:
        cell = queue.popleft()
        point = start + STEP * np.array(cell)
        if np.abs(point - target).max() <= STEP and free(point, target):
            return True
        for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            beside = (cell[0] + step[0], cell[1] + step[1])
            if beside not in visited and free(point, start + STEP * np.array(beside)):
                visited.add(beside)
                queue.append(beside)
    return False


@dataclass(frozen=True)
class Verdict:
    """What came of a room: "certified", "refused" or what is wrong; seconds: processor time of design and certificate."""

    outcome: str
    way: bool
    sets: int
    seconds: float


def judge(seed: int, parts: int, checked: bool) -> Verdict:
    """Design a room and hold it to its corners. checked: by the stand-alone checker too."""
    drawn = draw(seed)
    room, task = drawn.room, parse_task(text_of(drawn))
    if fault := partition_fault(room, [corners_of(table) for table in task.unsafe]):
        return Verdict(fault, True, len(task.unsafe), 0.0)
    begin = time.process_time()
    try:
        controller = build_task(task)
    except NotCertified:
        return Verdict("refused", has_way(drawn), len(task.unsafe), time.process_time() - begin)
    seconds = time.process_time() - begin
    axes = drawn.axes or (0, 1)
    body = [Fraction(0)] * task.dimension if task.body is None else list(task.body)
    outside = times_outside(room, controller.design, axes, body, clearance=Fraction(str(CLEARANCE)), parts=parts)
    if outside:
        return Verdict(f"{len(outside)} times outside, first at {float(outside[0]):g} s", True, len(task.unsafe), seconds)
    problem = objection(controller.files) if checked else ""
    return Verdict(problem or "certified", has_way(drawn), len(task.unsafe), seconds)


def objection(files: dict[str, bytes]) -> str:
    """What the stand-alone checker says against these files; nothing where it says yes."""
    with tempfile.TemporaryDirectory() as folder:
        for name, data in files.items():
            Path(folder, name).write_bytes(data)
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = checker.main([f"{folder}/room.{end}" for end in ("task.toml", "c", "certificate.json")])
    return said.getvalue().strip() if code else ""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0, help="of the first room")
    parser.add_argument("--parts", type=int, default=8, help="times in every segment at which the tube is looked at")
    parser.add_argument("--every", type=int, default=10, help="of so many rooms one is given to the stand-alone checker")
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    verdicts = []
    for seed in range(options.seed, options.seed + options.count):
        verdict = judge(seed, options.parts, seed % options.every == 0)
        verdicts.append(verdict)
        if verdict.outcome != "certified" and (verdict.outcome != "refused" or verdict.way):
            print(f"seed {seed}: {verdict.outcome}{', has a way' if verdict.way else ''}")
    outcomes = Counter((v.outcome if v.outcome in ("certified", "refused") else "wrong", v.way) for v in verdicts)
    good, wrong = outcomes["certified", True], outcomes["wrong", True]
    ways = good + outcomes["refused", True]
    sets, times = [v.sets for v in verdicts], [1e3 * v.seconds for v in verdicts]
    text = (
        f"{options.count} rooms: {good} of {ways} with a way certified, {outcomes['certified', False]} of "
        f"{options.count - ways - wrong} others; {wrong} wrong; sets, median / largest: {np.median(sets):g} / {max(sets)}; "
        f"design and certificate, ms, median / 95 %: {np.median(times):.3g} / {np.quantile(times, 0.95):.3g}"
    )
    print(text)
    if options.record:
        record(options.record, "rooms", f"## Concave rooms\n\nMade by `{command()}`; {machine()}.\n\n{text}.\n\n{ABOUT}\n")
    return 1 if wrong or good < ENOUGH * ways else 0


if __name__ == "__main__":
    sys.exit(main())
