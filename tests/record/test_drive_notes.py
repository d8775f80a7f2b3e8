"""Packages of a task with a drive say what is assumed of it, and of order 2 brake more weakly."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from stt_codegen.cli.main import app
from stt_codegen.record.ros2 import ros2_package
from stt_codegen.report.page.evidence import _unproved_of_the_plant
from stt_codegen.task.load import parse_task
from tests.certify.test_late_inputs import CART, DRIVES
from tests.support.controllers import build_once


def modules(name: str, **plant: Any) -> tuple[str, str, str]:
    """Return the node, its rules and its parameters, of a task with other plant bounds."""
    task = parse_task(DRIVES[name]).changed(plant=plant)
    files = {path.rpartition("/")[2]: data.decode() for path, data in ros2_package(build_once(task)).items() if b"\0" not in data}
    for module in ("drive.py", "node.py"):
        compile(files[module], module, "exec")
    return files["node.py"], files["drive.py"], files[f"{task.name}.yaml"]


def test_the_node_says_what_it_assumes_of_drives() -> None:
    node, rules, _ = modules("cart")
    assert 'DRIVES = "a drive that is no slower than a first-order lag of 0.08 s' in rules
    assert 'values["assumed of drives"] = DRIVES' in node
    assert "DRIVES" not in "".join(modules("cart", lag=None))


def test_a_brake_through_a_drive_is_weaker() -> None:
    brakes = [float(re.findall(r"brake: ([0-9.]+)", modules("order 2", lag=lag)[2])[0]) for lag in (None, "0.02", "0.04")]
    assert brakes == sorted(brakes, reverse=True)
    assert brakes[0] > 1.5 * brakes[-1]


def test_the_unit_of_a_plant_is_said_to_act_at_once(tmp_path: Path) -> None:
    notes = []
    for k, text in enumerate((CART, CART.replace("lag = 0.08", ""))):
        (tmp_path / "cart.toml").write_text(text)
        options = ["--package", "fmu", "--plant", "integrator", "--out", str(tmp_path / str(k)), "--json"]
        result = CliRunner().invoke(app, ["generate", str(tmp_path / "cart.toml"), *options])
        assert result.exit_code == 0, result.output
        assert json.loads(result.stdout)["written"][0]["certified"]
        notes.append(result.stderr)
    assert ["acts on u at once" in text for text in notes] == [True, False]


@pytest.mark.parametrize(("lag", "sentence"), [("0.08", "first-order lag of 0.08 s"), (None, "no inertia or lag")])
def test_the_page_lists_the_drive_among_what_is_not_proved(lag: str | None, sentence: str) -> None:
    controller = build_once(parse_task(CART).changed(plant={"lag": lag}))
    assert sentence in " ".join(_unproved_of_the_plant(controller))
