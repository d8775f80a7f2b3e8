"""benchmarks/physics.py's engine, its measured bounds and its runs, briefly; skipped where MuJoCo is not (make physics)."""

from __future__ import annotations

import importlib.util
import os
import sys
from types import ModuleType

import numpy as np
import pytest
from conftest import ROOT

pytestmark = pytest.mark.xdist_group("physics")  # a worker builds the controllers once


@pytest.fixture(scope="module")
def physics() -> ModuleType:
    """A visible skip without MuJoCo, a failure in CI, where `make test` installs it."""
    if importlib.util.find_spec("mujoco") is None:
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)("mujoco is not installed; it is optional: make physics")
    spec = importlib.util.spec_from_file_location("physics", ROOT / "benchmarks" / "physics.py")
    assert spec is not None
    assert spec.loader is not None
    sys.modules["physics"] = module = importlib.util.module_from_spec(spec)  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["base", "arm"])
def test_the_engine_is_a_plant_of_the_task(name: str, physics) -> None:
    """Its accelerations are within [plant], and what touches a geom is in an unsafe set."""
    bench = physics.Bench(name)
    found, plant = bench.bounds(500, np.random.default_rng(1)), bench.task.plant
    stated = {key: np.array(getattr(plant, key), float) for key in ("g_min", "g_max", "g_cross")}
    assert (found["f"] <= np.array(plant.f_max, float)).all()
    assert (found["g_min"] >= stated["g_min"]).all()
    assert (found["g_max"] <= stated["g_max"]).all()
    assert (found["g_cross"] <= stated["g_cross"]).all()
    assert bench.geoms_within(2000, np.random.default_rng(2)) == 0


@pytest.mark.parametrize("name", ["base", "arm"])
def test_pushed_as_proved_it_arrives_and_touches_nothing(name: str, physics) -> None:
    bench = physics.Bench(name)
    for seed in range(4):
        found = bench.run(seed)
        assert (found["contacts"], found["outside"], found["arrived"]) == (0, 0, True)


def test_a_push_beyond_every_bound_is_seen(physics) -> None:
    """What counts contacts and samples outside can count one."""
    bench = physics.Bench("base")
    bench.pushed = lambda w: type(bench).pushed(bench, 100 * np.array(w))
    found = bench.run(1)
    assert found["contacts"] > 0
    assert found["outside"] > 0
