"""The peers of the benchmark: their paths are safe, their answers agree with the exact ones, and a missing one says so."""

from __future__ import annotations

import importlib
import importlib.util
import os
import pickle
import shutil
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest

from stt_codegen.bench import peers
from stt_codegen.bench.families import FAMILIES, cubes, feasible
from stt_codegen.errors import BadInput, MissingTool

PAPER = FAMILIES["paper"]
OPEN = [s for s in range(40) if feasible(PAPER, s, 0.15)]
BLOCKED = [s for s in range(500) if not feasible(PAPER, s, 0.01)]  # the widest way is below half a cell of the grids
PLANNERS = {"ompl": (peers.rrt_connect, peers.rrt_star), "pyastar2d": (peers.a_star,)}


def needs(*names: str) -> None:
    """A visible skip without a peer, a failure in CI, where `make test` installs them."""
    missing = pytest.fail if os.environ.get("CI") == "true" else pytest.skip
    for name in names:
        if name == "gcc" and not (shutil.which("gcc") or shutil.which("cc")):
            missing("gcc is not installed")
        if name != "gcc" and importlib.util.find_spec(name) is None:
            missing(f"{name} is not installed; the peers are optional: make peers")


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
    numbers = peers.step_times([BLOCKED[0], *OPEN[:4]])
    assert (numbers["arenas"], numbers["certified"]) == (5, 4)
    assert numbers["cbf_collides"] == numbers["own_collides"] == 0.0
    assert numbers["own_reaches"] == 1.0
    assert 0 < numbers["cbf_reaches"] <= 0.8  # none arrives where there is no way
    assert numbers["ratio"] > 1


def test_our_step_arrives_in_narrow_tubes_when_it_is_called_often_enough() -> None:
    needs("osqp", "scipy", "gcc")
    numbers = peers.step_times([32, 40], hertz=2000)  # width^2 / (8 gain) is 0.92 and 0.75 ms
    assert (numbers["own_reaches"], numbers["own_collides"]) == (1.0, 0.0)


def test_the_filter_serves_other_families() -> None:
    needs("osqp", "scipy", "gcc")
    assert not peers.closed_loops(FAMILIES["space3"], 0)["cbf"].collided


@pytest.mark.parametrize("name", ["ompl", "pyastar2d", "hj_reachability", "osqp"])
def test_a_missing_package_says_what_to_install(name, monkeypatch) -> None:
    real = importlib.import_module

    def without(module):
        if module.partition(".")[0] == name:
            raise ModuleNotFoundError(f"No module named {name!r}")
        return real(module)

    monkeypatch.setattr(importlib, "import_module", without)
    for cached in (peers._ompl, peers._warm, peers._reach_avoid_solver, peers._generated_solver):
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
    code = "import sys, stt_codegen.bench.peers; print(set(sys.modules) & {'ompl', 'pyastar2d', 'jax', 'osqp', 'scipy'})"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "set()"


def test_grids_are_for_the_plane() -> None:
    needs("pyastar2d")
    with pytest.raises(BadInput, match="3 dimensions"):
        peers.a_star(FAMILIES["space3"], cubes(FAMILIES["space3"], 0))
