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
    module.Bench = cache(module.Bench)
    return module


@pytest.mark.parametrize("name", ["base", "arm"])
def test_the_engine_is_a_plant_of_the_task(name: str, physics) -> None:
    """Its accelerations are within [plant], and what touches a geom is in an unsafe set; and either can be seen to fail."""
    found = physics.Bench(name).measure(500)
    assert found.holds
    assert not replace(found, touching=1).holds
    for bound in ("f", "g_min", "g_max", "g_cross"):
        narrow = found.stated[bound] * (100 if bound == "g_min" else 0.01)
        assert not replace(found, stated=found.stated | {bound: narrow}).holds


@pytest.mark.parametrize("name", ["base", "arm"])
def test_pushed_as_proved_it_arrives_and_touches_nothing(name: str, physics) -> None:
    assert all(physics.Bench(name).run(seed).good for seed in range(4))


def test_a_push_beyond_every_bound_is_seen(physics, monkeypatch) -> None:
    """What counts contacts and samples outside can count one."""
    bench, push = physics.Bench("base"), physics.Bench("base").push
    monkeypatch.setattr(bench, "push", lambda w: push(100 * np.array(w)))
    found = bench.run(1)
    assert found.contacts > 0
    assert found.outside > 0
    assert not found.good
