"""Every picture of the documents shows what its page says: the runs behind it are made again, and end as its caption has it."""

from __future__ import annotations

import importlib.util
import json
import re
import shlex
import sys
from functools import cache
from types import ModuleType

import pytest

from tests.support.command_line import run_command
from tests.support.controllers import ROOT

BY_ANOTHER_COMMAND = {"physics.png": "python -m benchmarks physics --picture"}  # it needs MuJoCo; its job says that no run fails
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PICTURE = re.compile(r"\[([^\[\]]*)\]\((?:docs/)?([\w.-]+\.png)\)")  # a picture, or a link to one: caption, file


@cache
def figures() -> ModuleType:
    """Return docs/figures.py as a module."""
    spec = importlib.util.spec_from_file_location("figures", ROOT / "docs" / "figures.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["figures"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


NAMES = list(figures().PICTURES)


def test_every_picture_of_a_page_is_in_the_list_with_its_caption() -> None:
    shown = {(page.relative_to(ROOT).as_posix(), *match) for page in PAGES for match in PICTURE.findall(page.read_text())}
    listed = {(p.page, p.caption, f"{p.name}.png") for p in figures().PICTURES.values()}
    assert {entry for entry in shown if entry[2] not in BY_ANOTHER_COMMAND} == listed
    images = {path.name for path in (ROOT / "docs").glob("*.png")}
    assert images == {entry[2] for entry in shown}
    documents = "".join(path.read_text() for path in (ROOT / "benchmarks").glob("*.py"))
    assert all(command in documents for command in BY_ANOTHER_COMMAND.values())


@pytest.mark.parametrize("name", NAMES)
def test_the_runs_of_a_picture_end_as_its_caption_says(name: str, tool) -> None:
    """The designs, the runs and the image are those of the record: a tube that has changed since wants `python docs/figures.py`."""
    tool("cc")
    module, picture = figures(), figures().PICTURES[name]
    scenes = picture.scenes()
    image = (ROOT / "docs" / f"{name}.png").read_bytes()
    assert module.record_of(scenes, image) == json.loads(module.RECORD.read_text())[name]
    runs = [run for _, runs in scenes for run in runs]
    assert [module.ending_of(run) for run in runs] == [picture.ending] * len(runs)
    assert bool(runs) == bool(picture.ending)
    if runs and picture.ending != "fulfilled":
        assert picture.ending in picture.caption
    for controller, _ in scenes:
        assert controller.certificate.holds == (controller.design.kind != "literal")


def test_the_caption_of_a_tube_that_collides_names_the_set() -> None:
    (literal, _), _ = figures().PICTURES["literal_beside_refined"].scenes()
    assert "O1" in {finding.obstacle for finding in literal.certificate.findings if not finding.holds}
    assert "runs through O1" in figures().PICTURES["literal_beside_refined"].caption


@pytest.mark.parametrize("page", ["README.md", "docs/loop.md"])
def test_a_run_that_a_page_shows_succeeds_unless_the_page_says_otherwise(page: str, tool, tmp_path) -> None:
    """A page writes the exit code behind a command that fails."""
    tool("cc")
    lines = re.findall(r"^    stt-codegen (simulate .*)$", (ROOT / page).read_text(), re.M)
    assert lines
    for line in lines:
        command, _, comment = line.partition("#")
        code = re.search(r"exit code (\d)", comment)
        words = [str(tmp_path) if word == "." else word for word in shlex.split(command)]
        result = run_command(*words, cwd=ROOT)
        assert result.returncode == (int(code[1]) if code else 0), result.stdout


def test_the_numbers_beside_the_failing_run_are_those_of_its_report(tool) -> None:
    """The period, the proved one, and that 20 Hz is still fulfilled."""
    tool("cc")
    text = (ROOT / "docs" / "loop.md").read_text()
    options = ("--disturbance", "outward", "--w-max", "0.3")
    slow = run_command("simulate", "tasks/omni_s2.toml", "--rate", f"{figures().TOO_SLOW:g}", *options, cwd=ROOT).stdout
    assert f"At {figures().TOO_SLOW:g} Hz samples are {1000 / figures().TOO_SLOW:g} ms apart" in text
    proved = re.search(r"up to ([\d.]+) ms are proved from this start", slow)
    assert proved is not None
    assert f"{float(proved[1]):.1f} ms are proved for this gain and start" in text
    assert "At 20 Hz the same run is still fulfilled" in text
    assert ": fulfilled;" in run_command("simulate", "tasks/omni_s2.toml", "--rate", "20", *options, cwd=ROOT).stdout
