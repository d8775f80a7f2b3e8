"""Noise by component: the starts that the proof covers, and the errors of measurements in the loop, have the entry of their axis."""

from __future__ import annotations

from fractions import Fraction

import pytest

from stt_codegen.controller.covered_starts import compute_covered_starts
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.loop import Loop, Scenario, scenario_of_task
from stt_codegen.plants import plant_of
from tests.certify.test_bounds_by_component import hall
from tests.support.controllers import build_once


def test_starts_are_narrowed_by_the_noise_of_their_own_component() -> None:
    tasks = [hall(more=f"[plant]\nnoise = {noise}") for noise in ("[0.01, 0.01]", "[0.01, 0.04]")]
    design = build_once(tasks[0]).design
    assert isinstance(design, RefinedDesign)
    first, second = (compute_covered_starts(task, design).positions for task in tasks)
    assert first[0] == second[0]
    assert (second[1][0] - first[1][0], first[1][1] - second[1][1]) == (Fraction("0.03"),) * 2


def test_the_loop_errs_by_the_noise_of_each_component() -> None:
    controller = build_once(hall(more="[plant]\nnoise = [0, 0.01]"))
    assert scenario_of_task(controller.task)["noise"] == (0.0, 0.01)
    loop = Loop(controller, plant_of("integrator", 2))
    exact, noisy, same = (loop.run(Scenario(rate=100.0, noise=v), trace=True).trace for v in (0.0, (0.0, 0.01), (0.01, 0.01)))
    assert (exact[:, 1] == noisy[:, 1]).all()
    assert (exact[:, 2] != noisy[:, 2]).any()
    assert (loop.run(Scenario(rate=100.0, noise=0.01), trace=True).trace == same).all()
    for noise, message in (((0.1,), "has 1 entries"), ((0.1, -1.0), "finite number of 0 or more"), ("a", "the text 'a'")):
        with pytest.raises(BadInput, match=message):
            loop.run(Scenario(rate=100.0, noise=noise))  # type: ignore[arg-type]
