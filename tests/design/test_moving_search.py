"""Ways in space and time: what is searched, beside what is searched plainly."""

from __future__ import annotations

import itertools
from collections import deque
from fractions import Fraction
from random import Random

import numpy as np
import pytest

from stt_codegen.constraints import avoidances
from stt_codegen.design.arena import arena_of, normalise
from stt_codegen.design.lattice import lattice_of
from stt_codegen.design.moving_half_spaces import timed_obstacle_of
from stt_codegen.design.spacetime.free_cells import SliceCells
from stt_codegen.design.spacetime.search import CELL_COUNTS, SLICE_DIMENSIONS, SliceSearch
from stt_codegen.errors import NotCertified
from stt_codegen.task.load import parse_task
from stt_codegen.task.task import Task
from tests.design.test_moving import random_course
from tests.support.controllers import built

ROOM = """\
name = "room"
prescribed_time = 9
initial_state = [0.5, 2.5]
state_space = {{ lower = [0, 0], upper = [5, 5] }}
initial_set = {{ lower = [0.2, 2.2], upper = [0.8, 2.8] }}
target_set = {{ lower = [4.2, 2.2], upper = [4.8, 2.8] }}
{sets}"""


def random_field(draw: np.random.Generator, dimensions: int) -> SliceSearch:
    """A few cells and segments, most of them free."""
    shape = tuple(int(v) for v in draw.integers(3, 6, dimensions))
    count = int(draw.integers(2, 5))
    axes = [np.arange(size, dtype=float) for size in shape]
    free = draw.uniform(size=(count, *shape)) < 0.7
    first = tuple(int(draw.integers(size)) for size in shape)
    free[0][first] = True
    cells = SliceCells(tuple(range(dimensions)), axes, np.zeros((count + 1, dimensions)), np.zeros(dimensions))
    return SliceSearch(cells, free, draw.uniform(size=shape) < 0.2, first)


def plainly(field: SliceSearch, quickest: int) -> dict[tuple[int, ...], int]:
    """The least sum of squared steps to every cell at the end, one cell after the other. A step goes from a cell to one that
    touches it, between two free cells, whatever the cells at its sides."""
    shape, best = field.goal.shape, {field.first: 0} if field.free[(0, *field.first)] else {}
    for k, free in enumerate(field.free):
        after, now = field.free[min(k + 1, len(field.free) - 1)], dict[tuple[int, ...], int]()
        for cell, cost in best.items():
            away, queue = {cell: 0}, deque([cell] if free[cell] else [])
            while queue:
                here = queue.popleft()
                if after[here] and cost + away[here] ** 2 < now.get(here, 1 << 30):
                    now[here] = cost + away[here] ** 2
                for by in itertools.product((-1, 0, 1), repeat=len(shape)):
                    there = tuple(v + d for v, d in zip(here, by, strict=True))
                    inside = all(0 <= v < size for v, size in zip(there, shape, strict=True))
                    if inside and away[here] < quickest and there not in away and free[there]:
                        away[there] = away[here] + 1
                        queue.append(there)
        best = now
    return {cell: cost for cell, cost in best.items() if field.goal[cell]}


@pytest.mark.slow
@pytest.mark.parametrize("dimensions", range(1, SLICE_DIMENSIONS + 1))
def test_a_way_is_the_best_of_all_on_its_cells(dimensions: int) -> None:
    draw = np.random.default_rng(dimensions)
    led = 0
    for _ in range(60 if dimensions < 3 else 20):
        field = random_field(draw, dimensions)
        for quickest in (1, 2, field.paces[-1]):
            wanted, way = plainly(field, quickest), field.find_path(quickest)
            assert (way is None) == (not wanted)
            if way is not None:
                steps = np.abs(np.diff(way, axis=0)).max(axis=1)
                assert min(wanted.values()) >= (steps**2).sum()  # a detour about a corner has more steps than it is long
                cost = field.costs(quickest)[-1][field.goal]
                assert cost.min() == min(wanted.values())
                cells = way.astype(int)
                for k, free in enumerate(field.free):
                    assert free[tuple(cells[k])]
                    assert free[tuple(cells[k + 1])]
                led += 1
        assert field.has_route() == bool(plainly(field, field.paces[-1]))
    assert led > 20


def test_a_mover_is_where_its_course_says() -> None:
    """Its bounds over parts of the time are no less than where the set may be then, and no more than twice rounding where one
    leg spans a part."""
    draw = Random(3)
    for _ in range(60):
        course = random_course(draw, 2)
        motion = ", ".join(f"{{at = {float(at)}, by = [{float(x)}, {float(y)}]}}" for at, (x, y) in course.knots)
        hours = (
            ""
            if course.active_interval is None
            else f"during = [{float(course.active_interval[0])}, {float(course.active_interval[1])}]\n"
        )
        shape = draw.choice(("centre = [20, 20]\nradius = 0.5", "lower = [20, 20]\nupper = [21, 20.5]"))
        sets = f"start_delay = {float(course.clock_lead - course.clock_lag)}\n[[unsafe]]\n{shape}\nmotion = [{motion}]\n{hours}"
        sets += f"timing = {float(course.clock_lag)}\nspread = {float(course.spread)}\n"
        head, tail = sets.split("\n", 1)
        task = parse_task(f"{head}\n" + ROOM.format(sets=tail))
        (one,) = avoidances(task)
        assert one.course == course
        origin = (Fraction(0), Fraction(0))
        obstacle = timed_obstacle_of(one, origin).scaled(1.0, 9.0)
        for count in (7, 64):
            bounds = obstacle.bounds(count)
            for _ in range(40):
                k = draw.randrange(count)
                t = Fraction(9) * (k + Fraction(draw.randint(0, 48), 48)) / count
                share = float(t * count / 9 - k)
                for leg in (leg for leg in course.legs if leg.begin <= t <= leg.end):
                    for r, row in enumerate(one.alternatives):
                        moved = max(
                            sum(Fraction(c, row.slack_per_distance) * by[i] for i, _, c in row.terms)
                            for by in leg.displacements_at(t)
                        )
                        true = float(
                            row.bound / row.slack_per_distance
                            + one.growth_rates[r] / row.slack_per_distance * course.growth(t)
                            + moved
                        )
                        line = bounds[r, k, 0] + share * (bounds[r, k, 3] - bounds[r, k, 0])
                        assert line >= true - 1e-12 * max(1.0, abs(true))  # a dozen roundings of numbers below 100
            safe = [
                k
                for k in range(count)
                if not any(leg.begin < Fraction(9 * (k + 1), count) and leg.end > Fraction(9 * k, count) for leg in course.legs)
            ]
            assert all(bounds[0, k, 0] == -np.inf for k in safe)


THIN = '[[unsafe]]\nname = "door"\nlower = [2.5, -1]\nupper = [{}, 6]\n'
FAR = '[[unsafe]]\nname = "far"\nlower = [{0}, {0}]\nupper = [{1}, {1}]\nmotion = [{{at = 0, by = [0, 0]}}, {{at = 9, by = [1, 1]}}]\n'


@pytest.mark.parametrize("thick", ["2.500001", "2.51", "2.6"])
def test_nothing_thin_is_jumped(thick: str) -> None:
    door = THIN.format(thick) + "during = [0, 9]\n"
    with pytest.raises(NotCertified, match="door"):
        built(parse_task(ROOM.format(sets=door)))
    with pytest.raises(NotCertified, match="door"):  # the way is shut by a set that stands
        built(parse_task(ROOM.format(sets=THIN.format(thick) + FAR.format(20, 21))))


def test_a_mover_that_is_far_away_shuts_nothing() -> None:
    block = "[[unsafe]]\nlower = [2, -0.2]\nupper = [3, 2.4]\n[[unsafe]]\nlower = [2, 3.1]\nupper = [3, 5.2]\n"
    assert built(parse_task(ROOM.format(sets=block))).certificate.holds
    assert built(parse_task(ROOM.format(sets=block + FAR.format(20, 21)))).certificate.holds


def in_many(n: int, hours: str) -> Task:
    return Task(
        name="many",
        prescribed_time=9,
        initial_state=[0.25] * n,
        state_space={"lower": [0] * n, "upper": [5] * n},
        initial_set={"lower": [0] * n, "upper": [0.5] * n},
        target_set={"lower": [4.5] * n, "upper": [5] * n},
        unsafe=[{"name": "gate", "lower": [2] + [-0.2] * (n - 1), "upper": [3] + [5.2] * (n - 1), "during": [0, hours]}],
    )


@pytest.mark.parametrize("n", [2, 3])  # more in benchmarks/moving.py
def test_what_closes_the_way_is_named_in_any_dimension(n: int) -> None:
    with pytest.raises(
        NotCertified,
        match=r"gate \(a way would open if it were safe from [\d.]+ s to [\d.]+ s\) closes it; a way opens at, for example, prescribed_time",
    ):
        built(in_many(n, "8.9999"))


def test_cells_of_a_slice_are_free_where_the_box_about_them_is() -> None:
    """Against every set by itself, in all dimensions."""
    task = in_many(3, "4")
    lattice = lattice_of(task)
    arena = normalise(arena_of(task, lattice), lattice.exponent)
    obstacle = arena.timed_obstacles[0]
    centre, count = (arena.target[0] + arena.target[1]) / 2, CELL_COUNTS[3][0]
    axes = [np.linspace(arena.space[0, i], arena.space[1, i], count) for i in range(2)]
    rest = np.repeat(centre[None], 10, axis=0)
    cells = SliceCells((0, 1), axes, rest, np.full(3, 0.01))
    free = np.ones((9, count, count), dtype=bool)
    cells.block(free, obstacle)
    bounds = obstacle.bounds(9).max(axis=2)
    for k, (i, x), (j, y) in itertools.product(range(9), enumerate(axes[0]), enumerate(axes[1])):
        point = np.array([x, y, centre[2]])
        room = obstacle.normal @ point - np.abs(obstacle.normal) @ cells.reach - bounds[:, k]
        if abs(room.max()) > 1e-12:
            assert free[k, i, j] == (room.max() > 0)
