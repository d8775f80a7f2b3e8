"""The other controllers of the benchmarks: their C computes what their Python does, their bounds hold, and their judge can fail them."""

from __future__ import annotations

import ctypes
import itertools
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from benchmarks.peers import funnels, predictive
from benchmarks.peers import in_loops as contenders
from benchmarks.peers.driven import compile_peer, seconds_a_step
from benchmarks.peers.freeways import curve_is_safe, disjoint_free_boxes, drake, fast_path, maximal_free_boxes, neighbours
from benchmarks.peers.in_arenas import PEERS, PeerOutcome
from benchmarks.peers.in_loops import CONTENDERS, GRIDS, LoopArena
from benchmarks.peers.policy import (
    DECISIONS_PER_SECOND,
    OBSERVATION_SIZE,
    RAY_DIRECTIONS,
    SPEED,
    Policy,
    load_policy,
    observe,
    ray_lengths,
)
from benchmarks.peers.symbolic import NO_INPUT, UNREACHABLE, Abstraction, GridController, simulate_runs, synthesize
from benchmarks.suites import printed
from benchmarks.suites.families import BOX, FAMILIES, cubes
from benchmarks.suites.loop import LoopJob, run_job, strengths, table_rows
from benchmarks.suites.report import table
from stt_codegen.loop.simulate import Run
from tests.benchmarks.test_peers import needs

PAPER = FAMILIES["paper"]
OPEN = 0  # the seed of an arena with a wide route


def input_of(library: ctypes.CDLL, t: float, x: np.ndarray) -> np.ndarray:
    """Return u (2,) of a compiled controller that has just been started, at time t and state x."""
    library.other_step.argtypes = [ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]
    library.other_start()
    u, at = np.zeros(2), np.ascontiguousarray(x, dtype=float)
    library.other_step(t, at.ctypes.data, u.ctypes.data)
    return u


# ------------------------------------------------------------------------------------------------ symbolic control


@pytest.fixture(scope="module")
def coarse_grid() -> GridController:
    """Return the symbolic controller of the open arena on 50 x 50 cells."""
    return synthesize(PAPER, cubes(PAPER, OPEN), GRIDS["50 x 50"])


@pytest.mark.parametrize("name", ["50 x 50", "100 x 100, swept"])
def test_a_grid_keeps_its_promise_under_every_corner_wind(name: str) -> None:
    """From every winning cell: no unsafe square at a sample (swept: nor between samples), and the target in the worst-case time."""
    abstraction = GRIDS[name]
    grid, boxes = synthesize(PAPER, cubes(PAPER, OPEN), abstraction), cubes(PAPER, OPEN)
    draw, tau, step = np.random.default_rng(1), float(abstraction.period), PAPER.side / abstraction.cells
    inputs = np.array([[float(v) for v in u[:2]] for u in abstraction.inputs(2)])
    winning_cells = np.argwhere(grid.value[..., 0] < UNREACHABLE)
    x = (winning_cells[draw.integers(0, len(winning_cells), 400)] + draw.uniform(0, 1, (400, 2))) * step
    steps_left = grid.value[tuple((x / step).astype(int).T)][:, 0].astype(int)
    assert (steps_left > 10).any()
    for k in range(int(steps_left.max()) + 5):
        cells = tuple((x / step).astype(int).T)
        u = inputs[grid.table[cells][:, 0]]
        wind = 0.3 * np.sign(draw.uniform(-1, 1, x.shape)) * 0.999999  # slightly inside the corners, for the rounding of the sum
        for share in (0.25, 0.5, 0.75) if abstraction.is_swept else ():
            between = x + share * tau * (u + wind)
            assert not is_inside_box(between, boxes).any()
        x = x + tau * (u + wind)
        assert not is_inside_box(x, boxes).any()
        assert ((x >= 0) & (x <= PAPER.side)).all()
        has_arrived = steps_left <= k + 1
        assert (x[has_arrived] >= PAPER.side - BOX - 1e-12).all()  # it stays there


def is_inside_box(x: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Return, by point of x (P, 2), whether it is strictly inside of a box."""
    return np.any([np.all((b[:, 0] < x) & (x < b[:, 1]), axis=1) for b in boxes], axis=0)


def test_the_value_of_a_cell_is_one_more_than_that_of_its_worst_successor(coarse_grid: GridController) -> None:
    abstraction = coarse_grid.abstraction
    inputs, step = abstraction.inputs(2), Fraction(5) / abstraction.cells
    reach = step / 2 + abstraction.period * abstraction.w_max
    winning_cells = np.argwhere((coarse_grid.value[..., 0] < UNREACHABLE) & (coarse_grid.value[..., 0] > 0))
    for i, j in winning_cells[:: len(winning_cells) // 40]:
        u = inputs[coarse_grid.table[i, j, 0]]
        ranges_of_cells = []
        for k, v in zip((i, j), u, strict=False):
            middle = step * int(k) + step / 2 + abstraction.period * v
            ranges_of_cells.append(
                [c for c in range(abstraction.cells) if step * c <= middle + reach and step * (c + 1) > middle - reach]
            )
        worst = max(coarse_grid.value[p, q, 0] for p, q in itertools.product(*ranges_of_cells))
        assert coarse_grid.value[i, j, 0] == 1 + worst


def test_the_robots_successor_cells_contain_its_trajectories() -> None:
    """Random trajectories from a cell of three states end in the successors that the abstraction computes."""
    from benchmarks.peers.symbolic import _transition_windows

    abstraction = Abstraction(50, Fraction(1, 5), (Fraction(-1), Fraction(1)), headings=36, turns=(Fraction(1),))
    draw, tau, step = np.random.default_rng(2), 0.2, 0.1
    width = 2 * np.pi / abstraction.headings
    for heading in (0, 7, 20):
        for u in abstraction.inputs(2):
            window = _transition_windows(PAPER, abstraction, u, heading).successors
            x, angle = draw.uniform(0, step, (500, 2)), (heading + draw.uniform(0, 1, 500)) * width - np.pi
            wind = 0.3 * np.sign(draw.uniform(-1, 1, (500, 3)))
            for _ in range(400):  # Euler's error of tau^2 / 400 is below the margin of a cell
                c, s = np.cos(angle), np.sin(angle)
                drift = np.stack([c * float(u[0]) - s * float(u[1]), s * float(u[0]) + c * float(u[1])], axis=1)
                x = x + tau / 400 * (drift + wind[:, :2])
                angle = angle + tau / 400 * (float(u[2]) + wind[:, 2])
            ends = [*np.floor(x / step).T, np.floor((angle + np.pi) / width) - heading]
            for (low, high), cell in zip(window, ends, strict=True):
                assert low <= cell.min()
                assert cell.max() <= high


@pytest.mark.parametrize("seed", [0, 3])
def test_a_swept_grid_is_safe_between_samples_too(seed: int) -> None:
    """Every grid is safe at its samples; only the swept one is safe between them."""
    squares = cubes(PAPER, seed)
    plain, swept = (
        simulate_runs(synthesize(PAPER, squares, GRIDS[name]), squares, 300, step=5e-3)
        for name in ("50 x 50", "100 x 100, swept")
    )
    assert (plain.at_samples, plain.arrived) == (swept.at_samples, swept.arrived) == (0, 300)
    assert swept.between == 0
    blind = simulate_runs(synthesize(PAPER, squares[:0], GRIDS["50 x 50"]), squares, 300, step=5e-3)
    assert blind.at_samples > 0  # a controller that knows no unsafe set meets some


def test_a_robot_with_few_headings_is_safe_and_arrives() -> None:
    abstraction = Abstraction(50, Fraction(1, 5), tuple(map(Fraction, (-2, -1, 0, 1, 2))), w_max=Fraction(1, 10), headings=36)
    squares = cubes(PAPER, 0)
    grid = synthesize(PAPER, squares, abstraction)
    assert grid.is_winning
    runs = simulate_runs(grid, squares, 200, step=5e-3)
    assert (runs.at_samples, runs.arrived) == (0, 200)


def test_a_grid_that_is_blocked_wins_nothing() -> None:
    wall = np.array([[[2.0, 3.0], [0.0, 5.0]]])
    grid = synthesize(PAPER, wall, GRIDS["50 x 50"])
    assert not grid.is_winning
    assert (grid.table[0, 0] == NO_INPUT).all()


def test_a_grids_c_gives_the_inputs_of_its_table(coarse_grid: GridController) -> None:
    needs("gcc")
    controller = compile_peer(coarse_grid.source(), 2, 4.0, None)
    inputs = np.array([[float(v) for v in u[:2]] for u in coarse_grid.abstraction.inputs(2)])
    for x in np.random.default_rng(3).uniform(0, 5, (200, 2)):
        number = coarse_grid.table[tuple((x / 0.1).astype(int))][0]
        expected = np.zeros(2) if number == NO_INPUT else inputs[number]
        assert (input_of(controller.library, 0.0, x) == expected).all()


def test_a_held_input_changes_only_at_the_next_sample() -> None:
    needs("gcc")
    source = "static int decide(real t, const real *x, real *u)\n{\n    u[0] = x[0];\n    u[1] = t;\n    return 0;\n}\n"
    controller = compile_peer(source, 2, 20.0, None, real="double")
    controller.library.other_step.argtypes = [ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]
    controller.start()
    inputs = []
    for k in range(101):
        u, x = np.zeros(2), np.array([float(k), 0.0])
        controller.library.other_step(k * 0.001, x.ctypes.data, u.ctypes.data)
        inputs.append(u[0])
    assert inputs == [0.0] * 50 + [50.0] * 50 + [100.0]


# ------------------------------------------------------------------------------------------------ policies


def random_policy(seed: int = 0) -> Policy:
    """Return a policy with random weights."""
    draw = np.random.default_rng(seed)
    sizes = (OBSERVATION_SIZE, 8, 6, 4)
    layers = tuple((draw.normal(size=(i, j)) / i**0.5, draw.normal(size=j)) for i, j in itertools.pairwise(sizes))
    return Policy(draw.normal(size=OBSERVATION_SIZE) / 4, draw.uniform(0.5, 2, OBSERVATION_SIZE), layers, seed, 1.0, 2)


def test_a_policys_c_computes_what_its_python_does(tmp_path: Path) -> None:
    needs("gcc")
    random_policy().save(tmp_path / "policy_0.npz")
    policy, boxes = load_policy(tmp_path / "policy_0.npz"), cubes(PAPER, 3)
    controller = compile_peer(policy.source(boxes), 2, DECISIONS_PER_SECOND, None)
    draw = np.random.default_rng(4)
    for x, t in zip(draw.uniform(0, 5, (200, 2)), draw.uniform(0, 9, 200), strict=True):
        # Single precision: 27 terms of a few units in three layers, each within 2^-23 of its size.
        assert np.allclose(input_of(controller.library, t, x), policy(x, t, boxes), rtol=0, atol=200 * 2.0**-23)
        assert (abs(policy(x, t, boxes)) <= SPEED).all()


def test_a_ray_ends_where_a_finely_stepped_one_does() -> None:
    boxes = cubes(PAPER, 5)
    for x in ((0.3, 0.2), (2.5, 4.9), (4.0, 1.0)):
        if is_inside_box(np.array([x]), boxes)[0]:
            continue
        for length, direction in zip(ray_lengths(np, np.array(x), boxes), RAY_DIRECTIONS, strict=True):
            steps = np.arange(0, 8, 0.001)[:, None] * direction + x
            is_outside = is_inside_box(steps, boxes) | np.any((steps < 0) | (steps > 5), axis=1)
            assert abs(0.001 * np.argmax(is_outside) - length) <= 0.0011


def test_a_policy_sees_the_nearest_square_first() -> None:
    boxes, x = cubes(PAPER, 0), np.array([2.5, 0.1])
    observation = observe(np, x, np.array(3.0), boxes)
    assert observation.shape == (OBSERVATION_SIZE,)
    assert np.array_equal(observation, observe(np, x, np.array(3.0), boxes[::-1]))
    distances = np.maximum(boxes[..., 0] - x, x - boxes[..., 1]).max(axis=-1)
    assert np.allclose(observation[5:7] * 5, boxes[np.argmin(distances)].mean(axis=-1) - x)


# ------------------------------------------------------------------------------------------------ curves


@pytest.mark.parametrize("cut", [disjoint_free_boxes, maximal_free_boxes])
def test_free_boxes_are_free_and_cover_the_free_space(cut) -> None:
    for seed in (0, 7, 11):
        squares = cubes(PAPER, seed)
        low, high = cut(PAPER, squares)
        for a, b in zip(low, high, strict=True):
            assert not any(np.all((a < s[:, 1] + 0.02) & (s[:, 0] - 0.02 < b)) for s in squares)
        points = np.random.default_rng(seed).uniform(0.001, 4.999, (2000, 2))
        free = ~is_inside_box(points, squares + np.array([-0.02, 0.02]))
        covered = np.array([np.any(np.all((low <= p) & (p <= high), axis=1)) for p in points])
        assert np.array_equal(covered, free)
        assert all((j, i) in set(neighbours((low, high))) for i, j in neighbours((low, high)))


@pytest.mark.parametrize(("planner", "module"), [(drake, "pydrake"), (fast_path, "fastpathplanning")])
def test_a_curve_is_safe_and_connected_and_the_check_notices_when_it_is_not(planner, module) -> None:
    needs(module)
    squares = cubes(PAPER, OPEN)
    pieces = planner(PAPER, squares)
    assert curve_is_safe(PAPER, squares, pieces)
    for p, q in itertools.pairwise(pieces):
        assert np.allclose(p[-1], q[0], atol=1e-6)  # the solver's tolerance
    middle = pieces[len(pieces) // 2]
    low, high = middle.min(axis=0), middle.max(axis=0)
    beside = np.stack([low - 0.01, high + 0.01], axis=1)[None]
    assert not curve_is_safe(PAPER, np.concatenate([squares, beside]), pieces)
    assert not curve_is_safe(PAPER, squares, pieces[:-1])


def test_without_a_route_there_is_no_curve() -> None:
    wall = np.array([[[2.0, 3.0], [-1.0, 6.0]]])
    needs("fastpathplanning", "pydrake")
    assert fast_path(PAPER, wall) is None
    assert drake(PAPER, wall) is None


# ------------------------------------------------------------------------------------------------ in the loop


def test_the_program_of_predictive_control_has_its_documented_cost_and_rows() -> None:
    """For random inputs u and slacks s its matrices give the cost and the rows of its docstring."""
    cost, rows = predictive.program_matrices(7.0)
    draw, n, step = np.random.default_rng(0), predictive.STEPS, predictive.STEP_SECONDS
    u, s = draw.normal(size=(2, n)), draw.normal(size=(2, n))
    z, x = np.concatenate([u.ravel(), s.ravel()]), step * np.cumsum(u, axis=1)
    assert np.isclose(z @ cost @ z / 2, (x**2).sum() + predictive.INPUT_WEIGHT * (u**2).sum() + 7 * (s**2).sum())
    assert np.allclose(rows @ z, np.concatenate([(x + s).ravel(), (x - s).ravel(), u.ravel()]))


def test_a_path_of_a_star_has_its_stated_clearance() -> None:
    needs("pyastar2d")
    for seed in range(12):
        path = funnels.clearest_way(PAPER, cubes(PAPER, seed))
        assert path is not None
        points, clearance = path
        points_along = np.concatenate([np.linspace(p, q, 50) for p, q in itertools.pairwise(points)])
        for box in cubes(PAPER, seed):
            assert np.max(np.maximum(box[:, 0] - points_along, points_along - box[:, 1]), axis=1).min() >= clearance - 1e-9


@pytest.fixture(scope="module")
def outcome():
    """Return the outcome of one small job with all peers."""
    needs("gcc", "osqp", "pyastar2d")
    return run_job(LoopJob(OPEN, runs=3, peers=True, policies=Path("nowhere")))


def test_every_controller_runs_and_is_judged(outcome) -> None:
    names = [c.name for c in CONTENDERS]
    assert set(outcome.runs) == {"own", *names}
    assert all(len(runs) == 3 for runs in outcome.runs.values())
    good = {name: [r.good for r in runs] for name, runs in outcome.runs.items()}
    assert all(good["own"])
    assert not any(good["literal tube (the paper's)"])
    for name in ("prescribed performance about an A* way [11, 12]", "predictive control, our tube as reference"):
        assert all(good[name])
    assert all(good["symbolic control, 100 x 100, swept"])
    assert 0 < outcome.steps["own"] < outcome.steps["predictive control, our tube as reference"]
    row_of = {row[0]: row for row in table_rows([outcome])}
    assert row_of["own"][4:9] == ["0", "0", "0", "100.0 %", "100.0 %"]
    assert row_of["literal tube (the paper's)"][8] == "0.0 %"


def test_a_controller_that_does_not_exist_for_an_arena_is_counted_apart_from_one_that_fails(outcome) -> None:
    nobody = replace(outcome, runs={**outcome.runs, "barrier filter": ()})
    row = next(r for r in table_rows([outcome, nobody]) if r[0] == "barrier filter")
    assert row[1:4] == ["2", "1", "3"]


def test_a_controller_that_does_nothing_does_not_reach_the_target(outcome) -> None:
    """The judge counts it as not arrived."""
    from benchmarks.suites.families import arena_task
    from benchmarks.suites.loop import certified_tube, scenarios_of
    from stt_codegen.loop.simulate import Loop
    from stt_codegen.plants import PLANTS

    task = arena_task(PAPER, OPEN)
    tube = certified_tube(task)
    loop = Loop(contenders.build_task(task), PLANTS["integrator"])
    still = compile_peer(
        "static int decide(real t, const real *x, real *u)\n{\n    u[0] = u[1] = 0;\n    return 0;\n}\n", 2, 20, loop.loaded.tube
    )
    ready = LoopArena(OPEN, 0.0, loop, scenarios_of(LoopJob(OPEN, runs=1), tube, 0.5)).prepare(still)
    assert ready is not None
    assert not ready.loop.run(ready.scenarios[0]).reached
    assert seconds_a_step(still, np.zeros((10, 3))) > 0


def test_a_trained_policy_is_in_the_table(tmp_path: Path) -> None:
    random_policy(1).save(tmp_path / "policy_1.npz")
    assert [row[0] for row in strengths(tmp_path)][-1] == "reinforcement learning (PPO), seed 1"
    assert len(strengths(tmp_path / "none")) == len(CONTENDERS)


def test_every_controller_states_its_guarantee_and_what_it_does_better() -> None:
    assert all(c.advantages and c.guarantees for c in CONTENDERS)
    assert all(p.guarantees and p.lacks for p in PEERS)
    assert len({p.name for p in PEERS}) == len(PEERS)


def test_table_i_has_the_papers_figures_and_counts_our_runs(tmp_path: Path) -> None:
    """Every algorithm of the paper's table has its figures once. A policy that was not trained is named as left out. Runs are counted
    by their result."""
    run = Run(
        hit=None, hit_at=None, left_at=None, outside=0, outside_at=None, reached=True, margin=0.1, e=(0.5,), u=(1.0,), last=(4.6,)
    )
    hit, late = replace(run, hit="O1", hit_at=1.0), replace(run, reached=False)
    outcomes = {p.name: [PeerOutcome(k < 3, 0.001 * (k + 1)) for k in range(4)] for p in printed.all_peers(tmp_path)}
    rows = printed.table_i(outcomes, [], tmp_path)
    assert [r[:3] for r in rows if r[0]] == [[n, f"{s:.1f} %", f"{t:g}"] for n, s, t, _ in printed.PRINTED]
    assert [r[3:] for r in rows if r[0] == "RL"] == [["left out: `make policies` trains them", "", ""]]
    assert [r[4:] for r in rows if r[0] == "A*"] == [["3 of 4", "2.5 / 3.85 ms"]]
    assert sum(r[3].startswith("symbolic control") for r in rows) == len(GRIDS) + 1
    random_policy(1).save(tmp_path / "policy_1.npz")
    (learned,) = [p.name for p in printed.all_peers(tmp_path) if p.name not in outcomes]
    outcomes[learned] = [PeerOutcome(False, 1e-6, runs=(run, hit)), PeerOutcome(True, 3e-6, runs=(late, run))]
    assert [r[3:5] for r in printed.table_i(outcomes, [], tmp_path) if r[0] == "RL"] == [[learned, "1 of 2"]]
    assert printed.policy_rows(outcomes, tmp_path) == [[learned, "4", "3", "1", "0", "2", "2 / 2.9 us a step"]]


def test_a_grids_row_is_as_long_as_its_headings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(printed, "GRIDS", {"coarse": Abstraction(50, Fraction(1, 4), GRIDS["50 x 50"].speeds)})
    (row,) = printed.symbolic_rows(with_robot=False)
    assert len(row) == len(printed.SYMBOLIC)
    assert dict(zip(printed.SYMBOLIC, row, strict=True)) | {"memory, MB": "", "hit between": ""} == {
        "grid": "coarse", "inputs": "49", "period, ms": "250", "table, B": "2,500", "memory, MB": "", "states that win": "81 %",
        "runs": "1,000", "hit at samples": "0", "hit between": "", "arrive": "1,000",
    }  # fmt: skip


def test_a_bar_in_a_cell_of_a_table_is_escaped() -> None:
    lines = table(("a", "b"), [["|x| < 1", r"\|y\|"]]).split("\n")
    assert lines[2] == r"| \|x\| < 1 | \|y\| |"
