"""Thirty of the inputs of `python -m benchmarks nasty`, of other seeds; and what its judge notices."""

from __future__ import annotations

import json
import random
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from benchmarks.nasty import Outcome, broken_laws, half_written
from benchmarks.suites.nasty_inputs import MAKERS, VALUES, Case, bombs, draw_case, fields_of_schema, good_task, mutate_structure
from tests.support.controllers import ROOT

COUNT, SEED = 30, 6
KINDS = {"task", "map", "record", "certificate", "folder", "manifest", "option"}


def test_thirty_nasty_inputs_get_their_message() -> None:
    """In a process of its own, which has no threads when it divides."""
    command = [sys.executable, "-m", "benchmarks", "nasty", "--count", str(COUNT), "--seed", str(SEED)]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=600)
    assert result.returncode == 0, result.stdout + result.stderr
    assert f"{COUNT} inputs" in result.stdout


def test_cases_are_the_same_for_a_seed_and_of_every_kind() -> None:
    first, second = ([draw_case(number, 7) for number in range(2 * len(MAKERS))] for _ in range(2))
    assert first == second
    assert len({(bomb.kind, bomb.family) for bomb in bombs()}) == len(list(bombs())) > 100
    assert ("plant", "g_min") in fields_of_schema()
    assert ("unsafe", "motion", "at") in fields_of_schema()


def test_a_drawn_structure_leaves_the_values_that_others_are_drawn_from() -> None:
    values = repr(VALUES)
    for seed in range(500):
        mutate_structure(tomllib.loads(good_task("omni_s3").decode()), random.Random(seed))
    assert repr(VALUES) == values


def test_the_drawn_inputs_and_the_bombs_are_of_every_kind() -> None:
    assert {draw_case(number, SEED).kind for number in range(COUNT)} == KINDS
    assert {bomb.kind for bomb in bombs()} == KINDS - {"folder", "option"}
    assert {Path(bomb.part).suffix for bomb in bombs() if bomb.kind == "manifest"} == {".toml"}


def outcome(**changes: object) -> Outcome:
    good = {"code": 2, "output": "stt-codegen: no\n", "memory": 10**8, "silence": 1.0, "seconds": 2.0, "has_ended": True}
    return Outcome(**{**good, **changes})  # type: ignore[arg-type]


CASE = Case("task", "none", {}, ("design", "task.toml"))


@pytest.mark.parametrize(
    ("changes", "law"),
    [
        ({"code": 5}, "exit code 5"),
        ({"code": -11}, "exit code -11"),
        ({"output": "Traceback (most recent call last)\n"}, "traceback"),
        ({"output": "stt-codegen: internal error: KeyError\n"}, "internal error"),
        ({"output": "  designing: 2 s ...\n"}, "no message"),
        ({"output": "stt-codegen: \x1b[2J\n"}, "cannot be printed"),
        ({"memory": 2 * 10**9}, "2.0 GB"),
        ({"silence": 15.0}, "15 s without output"),
        ({"silence": 15.0, "has_ended": False, "code": -9}, "15 s without output"),
    ],
)
def test_a_broken_law_is_noticed(changes: dict[str, object], law: str, tmp_path: Path) -> None:
    assert broken_laws(CASE, outcome(), tmp_path) == []
    assert any(law in line for line in broken_laws(CASE, outcome(**changes), tmp_path))


def test_half_written_files_are_noticed(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "cart.c").write_text("new")
    assert half_written(CASE, 0, tmp_path) == []
    assert half_written(CASE, 3, tmp_path) == ["out/cart.c is written, and the command refuses"]
    (tmp_path / "out" / "cart.certificate.json").write_text(json.dumps({"sha256": {"cart.c": "00"}}))
    assert half_written(CASE, 0, tmp_path) == ["out/cart.certificate.json does not fit to the files beside it"]
    (tmp_path / "out" / ".cart.c.unfinished").write_text("")
    assert "out/.cart.c.unfinished is left" in half_written(CASE, 0, tmp_path)
