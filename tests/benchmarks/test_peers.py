"""The peers of the benchmarks: planners whose paths are safe, and a cascade of two stages for plants of order 2. A missing peer
says what to install."""

from __future__ import annotations

import importlib
import importlib.util
import pickle
import shutil
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import stt_codegen as stt
from benchmarks.peers import barrier, cascade
from benchmarks.peers import in_arenas as peers
from benchmarks.peers.cascade import (
    E_MAX,
    ComparedController,
    FilteredLaw,
    FirstStage,
    build_double_integrator,
    edges_at,
    simulate,
    xi_eps,
)
from benchmarks.suites.families import FAMILIES, cubes, is_feasible
from stt_codegen.errors import BadInput, MissingTool
from stt_codegen.reference import transform
from stt_codegen.sampling.sampling_conditions import sharp
from tests.support.missing_tools import skip_without

PAPER = FAMILIES["paper"]
OPEN = [s for s in range(40) if is_feasible(PAPER, s, 0.15)]
BLOCKED = [s for s in range(500) if not is_feasible(PAPER, s, 0.01)]  # the widest route is narrower than half a cell of the grids
PLANNERS = {"ompl": (peers.rrt_connect, peers.rrt_star), "pyastar2d": (peers.a_star,)}


def needs(*names: str) -> None:
    """Skip the test where a peer is not installed; in CI, where `make test` installs them, fail it."""
    for name in names:
        if name == "gcc" and not (shutil.which("gcc") or shutil.which("cc")):
            skip_without("gcc is not installed")
        if name != "gcc" and importlib.util.find_spec(name) is None:
            skip_without(f"{name} is not installed; the peers are optional: make peers")


def planners():
    """Return parameters (module, planner) for every planner."""
    return [pytest.param(module, planner, id=planner.__name__) for module, several in PLANNERS.items() for planner in several]


@pytest.mark.parametrize(("module", "planner"), planners())
def test_a_path_is_free_of_collision(module, planner) -> None:
    needs(module)
    for seed in OPEN:
        boxes = cubes(PAPER, seed)
        path = planner(PAPER, boxes)
        assert path is not None
        assert peers.path_is_safe(PAPER, boxes, path)
        # Points along the path check the same without the exact check.
        points = np.concatenate([np.linspace(p, q, 200) for p, q in pairwise(path)])
        assert not any(np.any(np.all((box[:, 0] < points) & (points < box[:, 1]), axis=1)) for box in boxes)


def test_the_exact_check_refuses_unsafe_paths() -> None:
    box = np.array([[[2.0, 3.0], [2.0, 3.0]]])
    start, goal = (0.25, 0.25), (4.75, 4.75)

    def is_safe(*between):
        return peers.path_is_safe(PAPER, box, np.array([start, *between, goal]))

    assert is_safe((2.0, 3.0))  # along the edge and through the corner: the unsafe box is open
    assert is_safe((1.0, 4.0))
    assert not is_safe()
    assert not is_safe((2.0, 3.0 - 2.0**-50))  # it cuts the corner by less than a sample would show
    assert not is_safe((2.5, 2.5), (2.5, 2.5))
    assert not is_safe((-0.1, 5.0))  # leaves the state space
    assert not peers.path_is_safe(PAPER, box, np.array([start, (1.0, 4.0)]))
    assert not peers.path_is_safe(PAPER, box, np.array([(1.0, 4.0), goal]))


def test_a_star_has_a_path_exactly_where_one_exists() -> None:
    needs("pyastar2d")
    narrow = (32, 98, 124, 158)  # the route closes at a clearance between 0.06 and 0.15
    for seed in (*OPEN, *narrow, *BLOCKED):
        outcome = peers.try_path_planner(peers.a_star, PAPER, seed)
        assert outcome.success == is_feasible(PAPER, seed, 0.06), seed
    assert outcome.note == "no path found"


@pytest.mark.parametrize("planner", PLANNERS["ompl"], ids=lambda p: p.__name__)
def test_a_random_path_does_not_depend_on_earlier_problems(planner) -> None:
    needs("ompl")
    first = [planner(PAPER, cubes(PAPER, seed)) for seed in OPEN[:4]]
    again = [planner(PAPER, cubes(PAPER, seed)) for seed in reversed(OPEN[:4])]
    assert all(np.array_equal(p, q) for p, q in zip(first, reversed(again), strict=True))


def test_the_reach_avoid_tube_contains_the_start_exactly_where_the_target_can_be_reached() -> None:
    needs("hj_reachability")
    assert peers.reach_avoid_tube(PAPER, OPEN[0]).success
    assert not peers.reach_avoid_tube(PAPER, BLOCKED[0]).success


def test_the_barrier_filter_never_collides_and_our_step_is_faster_and_arrives() -> None:
    needs("osqp", "scipy", "gcc")
    numbers = barrier.step_times([BLOCKED[0], *OPEN[:4]])
    assert (numbers["arenas"], numbers["certified"]) == (5, 4)
    assert numbers["cbf_collides"] == numbers["own_collides"] == 0.0
    assert numbers["own_reaches"] == 1.0
    assert 0 < numbers["cbf_reaches"] <= 0.8  # none arrives without a route
    assert numbers["ratio"] > 1


def test_our_step_arrives_in_narrow_tubes_when_it_is_called_often_enough() -> None:
    needs("osqp", "scipy", "gcc")
    numbers = barrier.step_times([32, 40], hertz=2000)  # width^2 / (8 gain) is 0.92 and 0.75 ms
    assert (numbers["own_reaches"], numbers["own_collides"]) == (1.0, 0.0)


def test_the_barrier_filter_works_in_three_dimensions() -> None:
    needs("osqp", "scipy", "gcc")
    assert not barrier.run_closed_loops(FAMILIES["space3"], 0)["cbf"].collided


@pytest.mark.parametrize("name", ["ompl", "pyastar2d", "hj_reachability", "osqp"])
def test_a_missing_package_says_what_to_install(name, monkeypatch) -> None:
    real = importlib.import_module

    def without(module):
        if module.partition(".")[0] == name:
            raise ModuleNotFoundError(f"No module named {name!r}")
        return real(module)

    monkeypatch.setattr(importlib, "import_module", without)
    for cached in (peers._ompl, peers._warm_up, peers._reach_avoid_solver, barrier._filter_solver):
        cached.cache_clear()
    index = {"ompl": 0, "pyastar2d": 2, "hj_reachability": 3, "osqp": 4}[name]
    with pytest.raises(MissingTool) as refusal:
        peers.PEERS[index].run(PAPER, 0)
    assert name in str(refusal.value)
    assert str(refusal.value).endswith("pip install stt-codegen[peers]")
    assert "\n" not in str(refusal.value)


def test_peers_can_be_pickled_and_importing_their_module_imports_no_library() -> None:
    for peer in peers.PEERS:
        assert pickle.loads(pickle.dumps(peer)).name == peer.name
    code = "import sys, benchmarks.peers.in_arenas; print(set(sys.modules) & {'ompl', 'pyastar2d', 'jax', 'osqp', 'scipy'})"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "set()"


def test_grids_are_for_the_plane() -> None:
    needs("pyastar2d")
    with pytest.raises(BadInput, match="3 dimensions"):
        peers.a_star(FAMILIES["space3"], cubes(FAMILIES["space3"], 0))


# ------------------------------------------------------------------------------------------------ the cascade, order 2

W_MAX = 0.3
CASCADES = [(tube, forward, share) for tube in cascade.TUBES for forward in (True, False) for share in cascade.START_SHARES]


@cache
def tube_of(name):
    """Return our controller of order 2 for an example task, with disturbances up to W_MAX."""
    return build_double_integrator(name, W_MAX)


@cache
def proved_cascade(name, forward, share):
    """Return the cascade with its longest proved period; forward: with feed-forward of the centre's motion; share: of the start."""
    proved = cascade.cascade_of_longest_period(tube_of(name), forward, share)
    assert proved is not None
    return proved


def rates_at_states(name, proved, side=None):
    """Yield (window, rate of v_ref, rate of eps1) at random times and states, by differences along the state's motion.

    The states have |eps1| < E1 and |v - v_ref| < rho; with a side (1 or -1) they are at these bounds on that side."""
    design, draw, n, h = tube_of(name).design, np.random.default_rng(5), len(proved.e1), 1e-6
    t_c = float(design.prescribed_time)
    for t in draw.uniform(2 * h, t_c - 2 * h, 300).tolist():
        edges_before, edges_now, edges_after = edges_at(design, np.array([t - h, t, t + h]))
        share = draw.choice((-0.999, 0.999), n) if side is None else side
        velocity_share = draw.choice((-0.999, 0.999), n) if side is None else side
        x = edges_now.middle + np.tanh(proved.e1 * share / 2) * (edges_now.upper - edges_now.lower) / 2
        v = proved.law.reference_speed(edges_now, x) + proved.law.rho * velocity_share
        v_ref_rate = (
            proved.law.reference_speed(edges_after, x + h * v) - proved.law.reference_speed(edges_before, x - h * v)
        ) / (2 * h)
        eps = [
            np.log((y - edges.lower) / (edges.upper - y)) for edges, y in ((edges_after, x + h * v), (edges_before, x - h * v))
        ]
        yield int(t / t_c * design.segments), v_ref_rate, (eps[0] - eps[1]) / (2 * h)


@pytest.mark.parametrize(("name", "forward", "share"), CASCADES)
def test_v_ref_changes_no_faster_than_its_bound(name, forward, share) -> None:
    proved = proved_cascade(name, forward, share)
    bound = FirstStage.of(tube_of(name).design, forward).reference_acceleration(proved.law.k1, proved.e1, proved.law.rho)
    shares = np.array([np.abs(turn) / bound[window] for window, turn, _ in rates_at_states(name, proved)])
    assert shares.max() <= 1
    assert shares.max() > 0.5  # the bound is not far above


@pytest.mark.parametrize(("name", "forward", "share"), CASCADES)
def test_the_first_stage_moves_inward_at_its_bound_and_half_its_gain_does_not(name, forward, share) -> None:
    proved = proved_cascade(name, forward, share)
    half = replace(proved, law=replace(proved.law, k1=proved.law.k1 / 2))
    for side in (1.0, -1.0):
        assert all((side * rate < 0).all() for _, _, rate in rates_at_states(name, proved, side))
        assert any((side * rate > 0).any() for _, _, rate in rates_at_states(name, half, side))


@pytest.mark.parametrize(("name", "forward", "share"), CASCADES)
def test_shorter_periods_are_proved_too_and_the_period_is_the_longest(name, forward, share) -> None:
    proved = proved_cascade(name, forward, share)
    reaches = np.geomspace(proved.sampled_loop.start.max() * 1.001, cascade.EPS_LIMIT, 60)
    times = proved.period * np.array([0.01, 0.2, 0.5, 0.9, 0.999, 1.05, 1.3])

    def conditions(reach, tau):
        with np.errstate(invalid="ignore"):
            return np.concatenate(
                [c.values.ravel() for c in sharp(proved.sampled_loop, np.full(len(proved.input_bounds), reach), tau)]
            )

    values = np.array([[conditions(reach, tau) for tau in times] for reach in reaches])
    is_proved = (values > 0).all(axis=2)
    assert (is_proved[:, 1:] <= is_proved[:, :-1]).all()
    assert is_proved.any(axis=0).tolist() == [True] * 5 + [False] * 2
    slacks = values[is_proved.nonzero()[0][0], :5]
    assert (np.diff(slacks, axis=0) <= 1e-12 * np.abs(slacks[:-1])).all()


def test_the_rate_of_v_ref_grows_with_reach_width_and_gain() -> None:
    for forward in (True, False):
        stage = FirstStage.of(tube_of("omni_s2").design, forward)
        values = tuple(np.full(2, v) for v in (0.05, 1.0, 0.2))  # k1, E1, rho
        for k in range(3):
            larger = tuple(v * 1.1 if j == k else v for j, v in enumerate(values))
            assert (stage.reference_acceleration(*larger) > stage.reference_acceleration(*values)).all()
        assert (stage.smallest_gain(values[1], 2 * values[2]) > stage.smallest_gain(values[1], values[2])).all()
        assert (stage.smallest_gain(2 * values[1], values[2]) < stage.smallest_gain(values[1], values[2])).all()


@pytest.mark.parametrize(
    ("name", "forward", "share"), [("omni_s2", True, 0.05), ("spacecraft", True, 0.9), ("spacecraft", False, 0.05)]
)
def test_the_cascade_stays_in_its_tube_at_its_period_and_not_at_20_times_it(name, forward, share) -> None:
    proved, design = proved_cascade(name, forward, share), tube_of(name).design
    begin = share * np.array([[0.0], [1.0], [-1.0]]) * np.ones(design.dimension)
    for share_of_period in (0.2, 1):
        run = simulate(design, proved.law, proved.period * share_of_period, W_MAX, begin)
        assert run.error.max() < 1  # |v - v_ref| < rho
        assert run.margin.min() > (1 - np.tanh(proved.e1.max() / 2)) / 2  # |eps1| < E1
        assert (run.u.max() <= max(proved.input_bounds)).all()
    assert simulate(design, proved.law, proved.period * 20, W_MAX, begin).margin.max() <= 0
    weak = replace(proved.law, u_max=np.full(design.dimension, 0.9 * W_MAX))  # w exceeds it
    assert simulate(design, weak, proved.period, W_MAX, begin).margin.min() <= 0


def test_the_laws_of_the_comparison_are_those_of_reference_and_emitted_code() -> None:
    """The clamped xi eps is that of the reference; our law is that of the emitted code."""
    draw = np.random.default_rng(1)
    low, high, x = np.zeros(2), np.array([0.3, 2.0]), draw.uniform(-0.5, 2.5, (400, 2))
    _, eps, xi = transform(low, high, x, (E_MAX, E_MAX))
    np.testing.assert_allclose(xi_eps(x - low, high - x), (xi * eps).astype(float), rtol=1e-9)
    limits = {"gain": ["0.2", "0.15"], "u_max": ["3", "3.5"]}
    emitted = stt.build(tube_of("omni_s2").task.changed(control=limits, emit={"scalar": "double"}))
    values = tuple(tuple(map(Fraction, v)) for v in limits.values())
    law = FilteredLaw(np.array([float(v) for v in emitted.design.filter]), *values)
    for t in (0.0, 2.3, 7.7):
        (edges,) = edges_at(emitted.design, np.array([t]))
        x = edges.middle + draw.uniform(-0.3, 0.3, (200, 2))
        v = draw.uniform(-0.6, 0.6, (200, 2))
        u, errors = law(edges, x, v)
        status, emitted_u = emitted.control(np.full(200, t), x, v)
        np.testing.assert_allclose(u, emitted_u, rtol=1e-6, atol=1e-9)
        is_inside = ((edges.lower < x) & (x < edges.upper)).all(axis=1) & (np.abs(errors).max(axis=1) < 1)
        assert (is_inside == (status == 0)).all()
        assert is_inside.any()


def test_our_proved_period_is_longer_than_that_of_a_cascade_in_the_table(monkeypatch) -> None:
    monkeypatch.setattr(cascade, "PERIODS_MS", (40, 500))
    rows, lines, all_inside = cascade.compare(W_MAX, 1)
    assert all_inside
    assert len(rows) == len(cascade.TUBES) * (1 + 2 * len(cascade.START_SHARES))
    assert all(len(row) == len(cascade.HEADINGS) for row in rows)
    for tube in cascade.TUBES:
        our_period, *cascade_periods = (float(row[3]) for row in rows if row[0] == tube)
        assert our_period > max(cascade_periods)
        assert cascade_periods[0] > cascade_periods[2]  # with feed-forward, and without
    assert "doubles" in lines[0]
    monkeypatch.setattr(cascade, "example_tasks", lambda: Path("nowhere"))
    rows, lines, _ = cascade.compare(W_MAX, 1)
    assert not rows
    assert "nowhere" in lines[0]


@pytest.mark.slow
def test_a_loop_that_leaves_below_its_proved_period_is_reported() -> None:
    proved = cascade.filtered_controller(tube_of("spacecraft"))
    assert proved is not None
    design = tube_of("spacecraft").design
    good = cascade.measure(ComparedController("spacecraft", "ours", 0.9, proved), design, W_MAX)
    assert good.stays_where_proved
    assert not replace(good, left_from_corner=100).stays_where_proved
    assert replace(good, share=0.5, left_from_corner=100).stays_where_proved  # nothing is proved from there
    assert not replace(good, left_from_middle=1).stays_where_proved
