"""The theorem of the whole text: Coq reads task, header and C by itself, and accepts what is shipped; what is changed it does not."""

from __future__ import annotations

import pytest
from conftest import ROOT

from stt_codegen.errors import BadInput
from stt_codegen.theorem import asking
from stt_codegen.theorem.deep import deep

pytestmark = [pytest.mark.xdist_group("coq"), pytest.mark.slow]

MUTANTS = (
    ("u - base", "base - u", "text_read"),
    ("logf(v0)", "logf(v3)", "text_read"),
    ("(-0.5F) : 0.5F", "0.5F : (-0.5F)", "constants_checked"),
    ("0.23894978F", "0.23894979F", "tube_checked"),
    ("#include <math.h>", "#include <tgmath.h>", "text_read"),
    ("0.5F;", "0.5;", "text_read"),
    ("typedef float", "typedef double", "header_read"),
    ("upper = [2.0, 5.0]", "upper = [2.1, 5.0]", "task_read"),
)


@pytest.fixture(autouse=True)
def _coqc(tool) -> None:
    tool("coqc")


def text(name: str, scalar: str) -> str:
    folder = ROOT / "generated" / name / "refined" / scalar
    parts = (folder / f"{name}{end}" for end in (".h", ".c", ".certificate.json"))
    return deep((ROOT / "tasks" / f"{name}.toml").read_bytes(), *(path.read_bytes() for path in parts))


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_shipped_controllers_have_it(scalar: str) -> None:
    answer = asking.ask_coq(text("omni_s1", scalar).encode(), "omni_s1")
    assert answer.holds, answer.what
    assert set(answer.axioms) <= asking.AXIOMS


@pytest.mark.parametrize(("old", "new", "lemma"), MUTANTS)
def test_changed_texts_have_none(old: str, new: str, lemma: str) -> None:
    whole = text("omni_s1", "float")
    assert old in whole
    answer = asking.ask_coq(whole.replace(old, new, 1).encode(), "omni_s1")
    assert not answer.holds
    assert answer.what.startswith(lemma), answer.what


def test_the_example_is_the_one_that_is_written() -> None:
    assert (ROOT / "proof" / "examples" / "omni_s1.v").read_text() == text("omni_s1", "float")


def test_limits_are_not_covered() -> None:
    with pytest.raises(BadInput, match="u_max"):
        text("trolley", "float")
