"""Gappa proves the constants of P7 from the statements of the checker's listing, and no constants that are too small."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from benchmarks import gappa
from tests.support.controllers import ROOT


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_gappa_proves_the_constants_of_the_checker(scalar: str, tool: Callable[[str], str]) -> None:
    tool("gappa")
    answers = gappa.constants_answers(scalar, None)
    assert len(answers) == 6
    assert all(answers.values()), answers


def test_gappa_proves_no_smaller_constants(monkeypatch: pytest.MonkeyPatch, tool: Callable[[str], str]) -> None:
    """A thirtieth of the constants is too small, for all Q."""
    tool("gappa")
    monkeypatch.setattr(gappa, "EDGE", (4, 441))
    monkeypatch.setattr(gappa, "RATE", (6, 568))
    assert not any(gappa.constants_answers("float", None).values())


def test_gappa_proves_the_spline_time_of_a_shipped_file(tool: Callable[[str], str]) -> None:
    tool("gappa")
    folder, task = ROOT / "generated" / "drone" / "refined" / "float", ROOT / "tasks" / "drone.toml"
    answers = gappa.file_answers(folder, task, None)
    assert all(answers.values()), answers
    assert not gappa.is_proved(
        gappa.time_script("float", *map(gappa.Fraction, (3, 3, 10)), gappa.FORMATS["float"].roundoff), None, "time"
    )
