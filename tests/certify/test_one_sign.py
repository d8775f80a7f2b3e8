"""Inputs of one sign: the numbers of docs/drive.md about pumps, their flows, and the messages of tasks that state such inputs."""

from __future__ import annotations

import re
from fractions import Fraction

import numpy as np
import pytest

from stt_codegen.errors import BadInput
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.task import Task, parse_task
from tests.certify.test_control_choice import STATED
from tests.support.controllers import ROOT, build_once

CONTINUOUS = STATED.replace("period = 0.02\n", "u_norm = 1.5\n").replace("noise = 0.002\n", "")
PAGE = (ROOT / "docs" / "drive.md").read_text()


def tanks() -> Task:
    """Return the task of docs/drive.md whose pumps have one sign."""
    (text,) = (block for block in re.findall(r"```toml\n(.*?)```", PAGE, re.S) if '"tanks"' in block)
    return parse_task(text)


def ranges_of(name: str) -> list[tuple[Fraction, Fraction]]:
    """Return a row of the page's table: the ranges of both tanks."""
    (row,) = re.findall(rf"^\| {re.escape(name)} \| (.*?) \| (.*?) \|$", PAGE, re.M)
    return [(Fraction(low), Fraction(high or low)) for low, _, high in (cell.partition(" to ") for cell in row)]


def test_the_tanks_of_the_page_are_certified_and_their_numbers_follow_from_pumps_and_consumers() -> None:
    task = tanks()
    pumps, consumers, biases = (ranges_of(name) for name in ("pump u, l/s", "consumer c, l/s", "bias u_0, near the mean of c"))
    for i, ((lower, upper), (low, high), (bias, _)) in enumerate(zip(pumps, consumers, biases, strict=True)):
        g_min, g_max = task.plant_bounds[i].g_min, task.plant_bounds[i].g_max
        assert ranges_of("f = -c")[i] == (-high, -low)
        assert ranges_of("g u_0")[i] == (g_min * bias, g_max * bias)
        assert ranges_of("f + g u_0")[i] == (g_min * bias - high, g_max * bias - low)
        assert task.plant_bounds[i].force >= max(abs(g_min * bias - high), abs(g_max * bias - low))
        assert (task.u_max or ())[i] == ranges_of("min(u_0 - 0, u_upper - u_0)")[i][0] == min(bias - lower, upper - bias)
    assert build_once(task).certificate.holds


def test_pumps_fill_the_tanks_with_flows_of_one_sign() -> None:
    """The true plant, x' = g u - c with u = u_0 + v within the pump's range, stays in the tube at all corners of the bounds."""
    controller = build_once(tanks())
    code, rng = CompiledC(controller), np.random.default_rng(3)
    bias, upper = np.array([1.0, 0.6]), np.array([2.0, 1.6])
    for _ in range(4):
        x = np.array([[rng.uniform(155, 245), rng.uniform(255, 345)]])
        for second in range(900):
            status, v = code.call("control", np.array([float(second)]), x + rng.uniform(-1, 1, (1, 2)))
            assert int(status[0]) == 0
            u = bias + v.astype(float)
            assert (u >= 0).all()
            assert (u <= upper).all()
            gain, flow = rng.choice([0.95, 1.05], 2), np.array([rng.choice([0.8, 1.2]), rng.choice([0.5, 0.7])])
            x = x + gain * u - flow
        assert ((x >= [[450, 400]]) & (x <= [[550, 500]])).all()


@pytest.mark.parametrize(
    ("control", "message"),
    [
        ("u_max = [[0, 2], [0, 1.6]]", r"control.u_max\[0\]: is \[0, 2\]; .*the law is odd.*here u_0 = 1 and u_max = 1$"),
        ("u_max = [0, 2]", r"control.u_max\[0\]: is 0; it must be greater than 0: the law is odd"),
        ("u_min = 0", "control.u_min: unknown key; the law is odd, so u must reach as far one way as the other"),
        ("u_max = [[2, 1], 1]", "give the lower one first"),
    ],
)
def test_inputs_of_one_sign_are_refused_with_the_reason_and_the_remedy(control: str, message: str) -> None:
    with pytest.raises(BadInput, match=message) as refusal:
        parse_task(CONTINUOUS.replace("u_norm = 1.5", control))
    assert 'docs/drive.md, "Inputs of one sign"' in str(refusal.value)
    assert "## Inputs of one sign\n" in PAGE
