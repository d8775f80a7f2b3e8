"""The peers of the benchmark: their paths are safe, their answers agree with the exact ones, and a missing one says so."""

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
from benchmarks.peers.cascade import E_MAX, Filtered, Stage, drive, edges_at, inertial, pulled
from benchmarks.suites.families import FAMILIES, cubes, feasible
from stt_codegen.errors import BadInput, MissingTool
from stt_codegen.reference import transform
from stt_codegen.sampling.sampling_conditions import sharp
from tests.support.missing_tools import skip_without

PAPER = FAMILIES["paper"]
OPEN = [s for s in range(40) if feasible(PAPER, s, 0.15)]
BLOCKED = [s for s in range(500) if not feasible(PAPER, s, 0.01)]  # the widest way is below half a cell of the grids
PLANNERS = {"ompl": (peers.rrt_connect, peers.rrt_star), "pyastar2d": (peers.a_star,)}


def needs(*names: str) -> None:
    """A visible skip without a peer, a failure in CI, where `make test` installs them."""
    for name in names:
        if name == "gcc" and not (shutil.which("gcc") or shutil.which("cc")):
            skip_without("gcc is not installed")
        if name != "gcc" and importlib.util.find_spec(name) is None:
            skip_without(f"{name} is not installed; the peers are optional: make peers")


def planners():
    return [pytest.param(module, planner, id=planner.__name__) for module, own in PLANNERS.items() for planner in own]


@pytest.mark.parametrize(("module", "planner"), planners())
def test_a_path_is_free_of_collision(module, planner) -> None:
    needs(module)
    for seed in OPEN:
        boxes = cubes(PAPER, seed)
        path = planner(PAPER, boxes)
        assert path is not None
        assert peers.path_is_safe(PAPER, boxes, path)
        # Once more by points along it, apart from the exact check.
        points = np.concatenate([np.linspace(p, q, 200) for p, q in pairwise(path)])
        assert not any(np.any(np.all((box[:, 0] < points) & (points < box[:, 1]), axis=1)) for box in boxes)


def test_the_exact_check_refuses_what_is_not_safe() -> None:
    box = np.array([[[2.0, 3.0], [2.0, 3.0]]])
    start, goal = (0.25, 0.25), (4.75, 4.75)

    def safe(*between):
        return peers.path_is_safe(PAPER, box, np.array([start, *between, goal]))

    assert safe((2.0, 3.0))  # along the edge and by the corner: the unsafe box is open
    assert safe((1.0, 4.0))
    assert not safe()
    assert not safe((2.0, 3.0 - 2.0**-50))  # clips the corner by less than a sample would see
    assert not safe((2.5, 2.5), (2.5, 2.5))
    assert not safe((-0.1, 5.0))  # leaves the state space
    assert not peers.path_is_safe(PAPER, box, np.array([start, (1.0, 4.0)]))
    assert not peers.path_is_safe(PAPER, box, np.array([(1.0, 4.0), goal]))


def test_a_star_finds_a_path_where_and_only_where_there_is_one() -> None:
    needs("pyastar2d")
    narrow = (32, 98, 124, 158)  # the way closes at a reach between 0.06 and 0.15
    for seed in (*OPEN, *narrow, *BLOCKED):
        outcome = peers.plan(peers.a_star, PAPER, seed)
        assert outcome.success == feasible(PAPER, seed, 0.06), seed
    assert outcome.note == "no path found"


@pytest.mark.parametrize("planner", PLANNERS["ompl"], ids=lambda p: p.__name__)
def test_a_random_path_does_not_depend_on_the_problems_before(planner) -> None:
    needs("ompl")
    first = [planner(PAPER, cubes(PAPER, seed)) for seed in OPEN[:4]]
    again = [planner(PAPER, cubes(PAPER, seed)) for seed in reversed(OPEN[:4])]
    assert all(np.array_equal(p, q) for p, q in zip(first, reversed(again), strict=True))


def test_the_reach_avoid_tube_holds_the_start_where_and_only_where_the_target_can_be_reached() -> None:
    needs("hj_reachability")
    assert peers.reach_avoid_tube(PAPER, OPEN[0]).success
    assert not peers.reach_avoid_tube(PAPER, BLOCKED[0]).success


def test_the_filter_never_collides_and_our_step_is_quicker_and_arrives() -> None:
    needs("osqp", "scipy", "gcc")
    numbers = barrier.step_times([BLOCKED[0], *OPEN[:4]])
    assert (numbers["arenas"], numbers["certified"]) == (5, 4)
    assert numbers["cbf_collides"] == numbers["own_collides"] == 0.0
    assert numbers["own_reaches"] == 1.0
    assert 0 < numbers["cbf_reaches"] <= 0.8  # none arrives where there is no way
    assert numbers["ratio"] > 1


def test_our_step_arrives_in_narrow_tubes_when_it_is_called_often_enough() -> None:
    needs("osqp", "scipy", "gcc")
    numbers = barrier.step_times([32, 40], hertz=2000)  # width^2 / (8 gain) is 0.92 and 0.75 ms
    assert (numbers["own_reaches"], numbers["own_collides"]) == (1.0, 0.0)


def test_the_filter_serves_other_families() -> None:
    needs("osqp", "scipy", "gcc")
    assert not barrier.closed_loops(FAMILIES["space3"], 0)["cbf"].collided


@pytest.mark.parametrize("name", ["ompl", "pyastar2d", "hj_reachability", "osqp"])
def test_a_missing_package_says_what_to_install(name, monkeypatch) -> None:
    real = importlib.import_module

    def without(module):
        if module.partition(".")[0] == name:
            raise ModuleNotFoundError(f"No module named {name!r}")
        return real(module)

    monkeypatch.setattr(importlib, "import_module", without)
    for cached in (peers._ompl, peers._warm, peers._reach_avoid_solver, barrier._filter_solver):
        cached.cache_clear()
    asked = {"ompl": 0, "pyastar2d": 2, "hj_reachability": 3, "osqp": 4}[name]
    with pytest.raises(MissingTool) as caught:
        peers.PEERS[asked].run(PAPER, 0)
    assert name in str(caught.value)
    assert str(caught.value).endswith("pip install stt-codegen[peers]")
    assert "\n" not in str(caught.value)


def test_peers_can_be_sent_to_workers_and_importing_them_imports_none() -> None:
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
CASCADES = [(tube, forward, share) for tube in cascade.TUBES for forward in (True, False) for share in cascade.SHARES]


@cache
def tube_of(name):
    return inertial(name, W_MAX)


@cache
def found_for(name, forward, share):
    found = cascade.cascade(tube_of(name), forward, share)
    assert found is not None
    return found


def at_states(name, found, side=None):
    """Times, and states there with |eps1| < E1 and |v - v_ref| < rho, drawn; at E1 and rho where a side is given. What is asked at
    every one of them: the window, v_ref, and the rates of v_ref and eps1 along the state, by differences."""
    design, draw, n, h = tube_of(name).design, np.random.default_rng(5), len(found.reach), 1e-6
    t_c = float(design.prescribed_time)
    for t in draw.uniform(2 * h, t_c - 2 * h, 300).tolist():
        before, now, after = edges_at(design, np.array([t - h, t, t + h]))
        share = draw.choice((-0.999, 0.999), n) if side is None else side
        stray = draw.choice((-0.999, 0.999), n) if side is None else side
        x = now.middle + np.tanh(found.reach * share / 2) * (now.upper - now.lower) / 2
        v = found.law.wanted(now, x) + found.law.rho * stray
        turn = (found.law.wanted(after, x + h * v) - found.law.wanted(before, x - h * v)) / (2 * h)
        eps = [np.log((y - at.lower) / (at.upper - y)) for at, y in ((after, x + h * v), (before, x - h * v))]
        yield int(t / t_c * design.segments), turn, (eps[0] - eps[1]) / (2 * h)


@pytest.mark.parametrize(("name", "forward", "share"), CASCADES)
def test_v_ref_moves_no_faster_than_is_stated(name, forward, share) -> None:
    found = found_for(name, forward, share)
    bound = Stage.of(tube_of(name).design, forward).rate(found.law.k1, found.reach, found.law.rho)
    shares = np.array([np.abs(turn) / bound[window] for window, turn, _ in at_states(name, found)])
    assert shares.max() <= 1
    assert shares.max() > 0.5  # of which it says something


@pytest.mark.parametrize(("name", "forward", "share"), CASCADES)
def test_the_first_stage_turns_at_its_edge_and_half_its_gain_does_not(name, forward, share) -> None:
    found = found_for(name, forward, share)
    half = replace(found, law=replace(found.law, k1=found.law.k1 / 2))
    for side in (1.0, -1.0):
        assert all((side * rate < 0).all() for _, _, rate in at_states(name, found, side))
        assert any((side * rate > 0).any() for _, _, rate in at_states(name, half, side))


@pytest.mark.parametrize(("name", "forward", "share"), CASCADES)
def test_a_shorter_period_is_never_harder_and_the_one_found_is_the_longest(name, forward, share) -> None:
    found = found_for(name, forward, share)
    reaches = np.geomspace(found.setting.start.max() * 1.001, cascade.FARTHEST, 60)
    times = found.seconds * np.array([0.01, 0.2, 0.5, 0.9, 0.999, 1.05, 1.3])

    def conditions(reach, tau):
        with np.errstate(invalid="ignore"):
            return np.concatenate([c.values.ravel() for c in sharp(found.setting, np.full(len(found.u), reach), tau)])

    values = np.array([[conditions(reach, tau) for tau in times] for reach in reaches])
    good = (values > 0).all(axis=2)
    assert (good[:, 1:] <= good[:, :-1]).all()
    assert good.any(axis=0).tolist() == [True] * 5 + [False] * 2
    kept = values[good.nonzero()[0][0], :5]
    assert (np.diff(kept, axis=0) <= 1e-12 * np.abs(kept[:-1])).all()


def test_what_is_asked_grows_with_reach_width_and_gain() -> None:
    for forward in (True, False):
        stage = Stage.of(tube_of("omni_s2").design, forward)
        own = tuple(np.full(2, v) for v in (0.05, 1.0, 0.2))  # k1, E1, rho
        for k in range(3):
            more = tuple(v * 1.1 if j == k else v for j, v in enumerate(own))
            assert (stage.rate(*more) > stage.rate(*own)).all()
        assert (stage.least_gain(own[1], 2 * own[2]) > stage.least_gain(own[1], own[2])).all()
        assert (stage.least_gain(2 * own[1], own[2]) < stage.least_gain(own[1], own[2])).all()


@pytest.mark.parametrize(
    ("name", "forward", "share"), [("omni_s2", True, 0.05), ("spacecraft", True, 0.9), ("spacecraft", False, 0.05)]
)
def test_the_cascade_keeps_its_tube_at_its_period_and_not_far_beyond(name, forward, share) -> None:
    found, design = found_for(name, forward, share), tube_of(name).design
    begin = share * np.array([[0.0], [1.0], [-1.0]]) * np.ones(design.dimension)
    for part in (0.2, 1):
        seen = drive(design, found.law, found.seconds * part, W_MAX, begin)
        assert seen.held.max() < 1  # |v - v_ref| < rho
        assert seen.margin.min() > (1 - np.tanh(found.reach.max() / 2)) / 2  # |eps1| < E1
        assert (seen.u.max() <= max(found.u)).all()
    assert drive(design, found.law, found.seconds * 20, W_MAX, begin).margin.max() <= 0
    weak = replace(found.law, u_max=np.full(design.dimension, 0.9 * W_MAX))  # w outdoes it
    assert drive(design, weak, found.seconds, W_MAX, begin).margin.min() <= 0


def test_the_laws_are_those_that_they_are_said_to_be() -> None:
    """The clamped xi eps is the reference's, and ours what is emitted."""
    draw = np.random.default_rng(1)
    low, high, x = np.zeros(2), np.array([0.3, 2.0]), draw.uniform(-0.5, 2.5, (400, 2))
    _, eps, xi = transform(low, high, x, (E_MAX, E_MAX))
    np.testing.assert_allclose(pulled(x - low, high - x), (xi * eps).astype(float), rtol=1e-9)
    limits = {"gain": ["0.2", "0.15"], "u_max": ["3", "3.5"]}
    emitted = stt.build(tube_of("omni_s2").task.changed(control=limits, emit={"scalar": "double"}))
    values = tuple(tuple(map(Fraction, v)) for v in limits.values())
    law = Filtered(np.array([float(v) for v in emitted.design.filter]), *values)
    for t in (0.0, 2.3, 7.7):
        (at,) = edges_at(emitted.design, np.array([t]))
        x = at.middle + draw.uniform(-0.3, 0.3, (200, 2))
        v = draw.uniform(-0.6, 0.6, (200, 2))
        u, held = law(at, x, v)
        status, wanted = emitted.control(np.full(200, t), x, v)
        np.testing.assert_allclose(u, wanted, rtol=1e-6, atol=1e-9)
        inside = ((at.lower < x) & (x < at.upper)).all(axis=1) & (np.abs(held).max(axis=1) < 1)
        assert (inside == (status == 0)).all()
        assert inside.any()


def test_ours_is_proved_for_longer_than_a_cascade_and_the_table_says_so(monkeypatch) -> None:
    monkeypatch.setattr(cascade, "PERIODS", (40, 500))
    rows, lines, kept = cascade.compare(W_MAX, 1)
    assert kept
    assert len(rows) == len(cascade.TUBES) * (1 + 2 * len(cascade.SHARES))
    assert all(len(row) == len(cascade.HEADINGS) for row in rows)
    for tube in cascade.TUBES:
        ours, *others = (float(row[3]) for row in rows if row[0] == tube)
        assert ours > max(others)
        assert others[0] > others[2]  # c' fed forward, and plain
    assert "doubles" in lines[0]
    monkeypatch.setattr(cascade, "folder", lambda: Path("nowhere"))
    rows, lines, _ = cascade.compare(W_MAX, 1)
    assert not rows
    assert "nowhere" in lines[0]


@pytest.mark.slow
def test_a_loop_of_ours_that_leaves_below_its_period_is_told() -> None:
    ours = cascade.filtered(tube_of("spacecraft"))
    assert ours is not None
    design = tube_of("spacecraft").design
    good = cascade.measured("spacecraft", "ours", 0.9, ours, design, W_MAX)
    assert good.kept
    assert not replace(good, corner=100).kept
    assert replace(good, share=0.5, corner=100).kept  # nothing is owed from there
    assert not replace(good, middle=1).kept
