"""The search for routes in space and time against a plain search, and the bounds of moving sets that it uses."""

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
from tests.design.test_moving import draw_course
from tests.support.controllers import build_once

ROOM_TASK = """\
name = "room"
prescribed_time = 9
initial_state = [0.5, 2.5]
state_space = {{ lower = [0, 0], upper = [5, 5] }}
initial_set = {{ lower = [0.2, 2.2], upper = [0.8, 2.8] }}
target_set = {{ lower = [4.2, 2.2], upper = [4.8, 2.8] }}
{sets}"""


def draw_search(draw: np.random.Generator, dimensions: int) -> SliceSearch:
    """Return a search over a few random cells and segments, most of them free."""
    shape = tuple(int(v) for v in draw.integers(3, 6, dimensions))
    count = int(draw.integers(2, 5))
    axes = [np.arange(size, dtype=float) for size in shape]
    free = draw.uniform(size=(count, *shape)) < 0.7
    first = tuple(int(draw.integers(size)) for size in shape)
    free[0][first] = True
    cells = SliceCells(tuple(range(dimensions)), axes, np.zeros((count + 1, dimensions)), np.zeros(dimensions))
    return SliceSearch(cells, free, draw.uniform(size=shape) < 0.2, first)


def costs_by_plain_search(search: SliceSearch, quickest: int) -> dict[tuple[int, ...], int]:
    """Return the smallest sum of squared steps to every goal cell, by a search of one cell after the other.

    In a segment of time a path makes at most `quickest` steps. A step goes from a free cell to a free cell that touches it, also at a corner."""
    shape, costs = search.goal.shape, {search.start_cell: 0} if search.free[(0, *search.start_cell)] else {}
    for k, free in enumerate(search.free):
        after, costs_after = search.free[min(k + 1, len(search.free) - 1)], dict[tuple[int, ...], int]()
        for cell, cost in costs.items():
            steps_to, queue = {cell: 0}, deque([cell] if free[cell] else [])
            while queue:
                cell_on_path = queue.popleft()
                if after[cell_on_path] and cost + steps_to[cell_on_path] ** 2 < costs_after.get(cell_on_path, 1 << 30):
                    costs_after[cell_on_path] = cost + steps_to[cell_on_path] ** 2
                for step in itertools.product((-1, 0, 1), repeat=len(shape)):
                    neighbour = tuple(v + d for v, d in zip(cell_on_path, step, strict=True))
                    inside = all(0 <= v < size for v, size in zip(neighbour, shape, strict=True))
                    if inside and steps_to[cell_on_path] < quickest and neighbour not in steps_to and free[neighbour]:
                        steps_to[neighbour] = steps_to[cell_on_path] + 1
                        queue.append(neighbour)
        costs = costs_after
    return {cell: cost for cell, cost in costs.items() if search.goal[cell]}


@pytest.mark.slow
@pytest.mark.parametrize("dimensions", range(1, SLICE_DIMENSIONS + 1))
def test_a_path_has_the_smallest_cost_of_all_on_its_cells(dimensions: int) -> None:
    draw = np.random.default_rng(dimensions)
    path_count = 0
    for _ in range(60 if dimensions < 3 else 20):
        search = draw_search(draw, dimensions)
        for quickest in (1, 2, search.paces[-1]):
            expected_costs, path = costs_by_plain_search(search, quickest), search.find_path(quickest)
            assert (path is None) == (not expected_costs)
            if path is not None:
                steps = np.abs(np.diff(path, axis=0)).max(axis=1)
                assert (
                    min(expected_costs.values()) >= (steps**2).sum()
                )  # a detour around a corner takes more steps than its ends are apart
                cost = search.costs(quickest)[-1][search.goal]
                assert cost.min() == min(expected_costs.values())
                cells = path.astype(int)
                for k, free in enumerate(search.free):
                    assert free[tuple(cells[k])]
                    assert free[tuple(cells[k + 1])]
                path_count += 1
        assert search.has_route() == bool(costs_by_plain_search(search, search.paces[-1]))
    assert path_count > 20


def test_the_bounds_of_a_moving_set_are_not_below_its_course() -> None:
    """In each of `count` parts of the time the bound is a line that lies above the exact support of the set at every time."""
    draw = Random(3)
    for _ in range(60):
        course = draw_course(draw, 2)
        motion = ", ".join(f"{{at = {float(at)}, by = [{float(x)}, {float(y)}]}}" for at, (x, y) in course.knots)
        active = (
            ""
            if course.active_interval is None
            else f"during = [{float(course.active_interval[0])}, {float(course.active_interval[1])}]\n"
        )
        shape = draw.choice(("centre = [20, 20]\nradius = 0.5", "lower = [20, 20]\nupper = [21, 20.5]"))
        sets = f"start_delay = {float(course.clock_lead - course.clock_lag)}\n[[unsafe]]\n{shape}\nmotion = [{motion}]\n{active}"
        sets += f"timing = {float(course.clock_lag)}\nspread = {float(course.spread)}\n"
        head, tail = sets.split("\n", 1)
        task = parse_task(f"{head}\n" + ROOM_TASK.format(sets=tail))
        (avoidance,) = avoidances(task)
        assert avoidance.course == course
        origin = (Fraction(0), Fraction(0))
        obstacle = timed_obstacle_of(avoidance, origin).scaled(1.0, 9.0)
        for count in (7, 64):
            bounds = obstacle.bounds(count)
            for _ in range(40):
                k = draw.randrange(count)
                t = Fraction(9) * (k + Fraction(draw.randint(0, 48), 48)) / count
                share = float(t * count / 9 - k)
                for leg in (leg for leg in course.legs if leg.begin <= t <= leg.end):
                    for r, constraint in enumerate(avoidance.alternatives):
                        shift = max(
                            sum(Fraction(c, constraint.slack_per_distance) * displacement[i] for i, _, c in constraint.terms)
                            for displacement in leg.displacements_at(t)
                        )
                        support = float(
                            constraint.bound / constraint.slack_per_distance
                            + avoidance.growth_rates[r] / constraint.slack_per_distance * course.growth(t)
                            + shift
                        )
                        line = bounds[r, k, 0] + share * (bounds[r, k, 3] - bounds[r, k, 0])
                        # The allowance is for a dozen roundings of numbers below 100.
                        assert line >= support - 1e-12 * max(1.0, abs(support))
            safe = [
                k
                for k in range(count)
                if not any(leg.begin < Fraction(9 * (k + 1), count) and leg.end > Fraction(9 * k, count) for leg in course.legs)
            ]
            assert all(bounds[0, k, 0] == -np.inf for k in safe)


THIN = '[[unsafe]]\nname = "door"\nlower = [2.5, -1]\nupper = [{}, 6]\n'
FAR = '[[unsafe]]\nname = "far"\nlower = [{0}, {0}]\nupper = [{1}, {1}]\nmotion = [{{at = 0, by = [0, 0]}}, {{at = 9, by = [1, 1]}}]\n'


@pytest.mark.parametrize("right_edge", ["2.500001", "2.51", "2.6"])
def test_a_thin_set_closes_a_route_like_a_thick_one(right_edge: str) -> None:
    door = THIN.format(right_edge) + "during = [0, 9]\n"
    with pytest.raises(NotCertified, match="door"):
        build_once(parse_task(ROOM_TASK.format(sets=door)))
    with pytest.raises(NotCertified, match="door"):  # a standing set closes the route; the moving one is far away
        build_once(parse_task(ROOM_TASK.format(sets=THIN.format(right_edge) + FAR.format(20, 21))))


def test_a_moving_set_that_is_far_away_closes_no_route() -> None:
    block = "[[unsafe]]\nlower = [2, -0.2]\nupper = [3, 2.4]\n[[unsafe]]\nlower = [2, 3.1]\nupper = [3, 5.2]\n"
    assert build_once(parse_task(ROOM_TASK.format(sets=block))).certificate.holds
    assert build_once(parse_task(ROOM_TASK.format(sets=block + FAR.format(20, 21)))).certificate.holds


def gated_task(n: int, end: str) -> Task:
    """Return a task in n dimensions with a gate that closes the route from 0 s until `end`."""
    return Task(
        name="many",
        prescribed_time=9,
        initial_state=[0.25] * n,
        state_space={"lower": [0] * n, "upper": [5] * n},
        initial_set={"lower": [0] * n, "upper": [0.5] * n},
        target_set={"lower": [4.5] * n, "upper": [5] * n},
        unsafe=[{"name": "gate", "lower": [2] + [-0.2] * (n - 1), "upper": [3] + [5.2] * (n - 1), "during": [0, end]}],
    )


@pytest.mark.parametrize("n", [2, 3])  # more in benchmarks/moving.py
def test_the_set_that_closes_the_route_is_named_in_any_dimension(n: int) -> None:
    with pytest.raises(
        NotCertified,
        match=r"gate \(a way would open if it were safe from [\d.]+ s to [\d.]+ s\) closes it; certified with prescribed_time",
    ):
        build_once(gated_task(n, "8.9999"))


def test_a_cell_of_a_slice_is_free_exactly_where_the_box_around_it_is() -> None:
    """The box around a cell is compared with the obstacle in all dimensions, not only in those of the slice."""
    task = gated_task(3, "4")
    lattice = lattice_of(task)
    arena = normalise(arena_of(task, lattice), lattice.exponent)
    obstacle = arena.timed_obstacles[0]
    centre, count = (arena.target[0] + arena.target[1]) / 2, CELL_COUNTS[3][0]
    axes = [np.linspace(arena.space[0, i], arena.space[1, i], count) for i in range(2)]
    path_in_other_axes = np.repeat(centre[None], 10, axis=0)
    cells = SliceCells((0, 1), axes, path_in_other_axes, np.full(3, 0.01))
    free = np.ones((9, count, count), dtype=bool)
    cells.block(free, obstacle)
    bounds = obstacle.bounds(9).max(axis=2)
    for k, (i, x), (j, y) in itertools.product(range(9), enumerate(axes[0]), enumerate(axes[1])):
        point = np.array([x, y, centre[2]])
        distance = obstacle.normal @ point - np.abs(obstacle.normal) @ cells.growth - bounds[:, k]
        if abs(distance.max()) > 1e-12:
            assert free[k, i, j] == (distance.max() > 0)
