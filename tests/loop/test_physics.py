"""benchmarks/physics.py's engine, its measured bounds and its runs, briefly; skipped where MuJoCo is not (make physics)."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from functools import cache
from types import ModuleType

import numpy as np
import pytest

from tests.support.missing_tools import skip_without

pytestmark = pytest.mark.xdist_group("physics")  # a worker builds the controllers once


@pytest.fixture(scope="module")
def physics() -> ModuleType:
    if importlib.util.find_spec("mujoco") is None:
        skip_without("mujoco is not installed; it is optional: make physics")
    module = importlib.import_module("benchmarks.physics")
    module.RobotSimulation = cache(module.RobotSimulation)
    return module


@pytest.mark.parametrize("name", ["base", "arm"])
def test_the_engine_is_a_plant_of_the_task(name: str, physics) -> None:
    """Its accelerations are within [plant], and what touches a geom is in an unsafe set; and either can be seen to fail."""
    measured = physics.RobotSimulation(name).measure_bounds(500)
    assert measured.are_within_stated
    assert not replace(measured, touching_count=1).are_within_stated
    for bound in ("f", "g_min", "g_max", "g_cross"):
        narrow = measured.stated[bound] * (100 if bound == "g_min" else 0.01)
        assert not replace(measured, stated=measured.stated | {bound: narrow}).are_within_stated


@pytest.mark.parametrize("name", ["base", "arm"])
def test_pushed_as_proved_it_arrives_and_touches_nothing(name: str, physics) -> None:
    assert all(physics.RobotSimulation(name).run_mission(seed).is_successful for seed in range(4))


def test_a_push_beyond_every_bound_is_seen(physics, monkeypatch) -> None:
    """What counts contacts and samples outside can count one."""
    simulation, disturb = physics.RobotSimulation("base"), physics.RobotSimulation("base").disturb
    monkeypatch.setattr(simulation, "disturb", lambda w: disturb(100 * np.array(w)))
    run = simulation.run_mission(1)
    assert run.contact_steps > 0
    assert run.outside_samples > 0
    assert not run.is_successful
