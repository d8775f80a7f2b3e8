"""A short run of benchmarks/physics.py: its engine, measured bounds and loops. Skipped where MuJoCo is missing (make physics)."""

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
    """Its accelerations are within [plant], and contacts are in unsafe sets. A contact or a narrower bound makes the test of both fail."""
    measured = physics.RobotSimulation(name).measure_bounds(500)
    assert measured.are_within_stated
    assert not replace(measured, touching_count=1).are_within_stated
    for bound in ("f", "g_min", "g_max", "g_cross"):
        narrow = measured.stated[bound] * (100 if bound == "g_min" else 0.01)
        assert not replace(measured, stated=measured.stated | {bound: narrow}).are_within_stated


@pytest.mark.parametrize("name", ["base", "arm"])
def test_with_the_proved_disturbance_it_arrives_without_contact(name: str, physics) -> None:
    assert all(physics.RobotSimulation(name).run_mission(seed).is_successful for seed in range(4))


def test_a_disturbance_beyond_every_bound_gives_contacts_and_leaves_the_tube(physics, monkeypatch) -> None:
    """So the counts of contacts and of samples outside the tube can be positive."""
    simulation, disturb = physics.RobotSimulation("base"), physics.RobotSimulation("base").disturb
    monkeypatch.setattr(simulation, "disturb", lambda w: disturb(100 * np.array(w)))
    run = simulation.run_mission(1)
    assert run.contact_steps > 0
    assert run.outside_samples > 0
    assert not run.is_successful
