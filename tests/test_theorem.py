"""Theorems for Coq: the library rests on nothing of ours, shipped controllers have theirs, what is changed has none."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import ROOT
from test_cli import run

from stt_codegen.errors import BadInput
from stt_codegen.theorem import asking
from stt_codegen.theorem.reading import Facts, facts
from stt_codegen.theorem.writing import written

pytestmark = pytest.mark.xdist_group("coq")  # the library is compiled once


def files_of(name: str, scalar: str) -> tuple[bytes, bytes, bytes]:
    """Task, C and certificate as they are shipped."""
    folder = ROOT / "generated" / name / "refined" / scalar
    return (
        (ROOT / "tasks" / f"{name}.toml").read_bytes(),
        (folder / f"{name}.c").read_bytes(),
        (folder / f"{name}.certificate.json").read_bytes(),
    )


def read(name: str, scalar: str) -> Facts:
    return facts(*files_of(name, scalar))


def shipped() -> list[tuple[str, str]]:
    """Refined controllers that theorems are written about, of all that are shipped."""
    found = []
    for path in sorted((ROOT / "generated").glob("*/refined/*/*.certificate.json")):
        name, scalar = path.parents[2].name, path.parent.name
        try:
            read(name, scalar)
        except BadInput:
            continue
        found.append((name, scalar))
    return found


# ------------------------------------------------------------------------------------------------ what is written


def test_the_library_takes_nothing_for_granted() -> None:
    listed = asking.names()
    assert sorted(p.stem for p in (ROOT / "proof").glob("*.v")) == sorted(listed)
    for name in listed:
        text = re.sub(r"\(\*.*?\*\)", "", (ROOT / "proof" / f"{name}.v").read_text(), flags=re.S)
        assert not re.search(r"\b(Admitted|admit|Axioms?|Parameters?|Conjecture|Abort|give_up|bypass_check)\b", text), name
        assert not re.search(r"^(Variables?|Hypothes[ie]s)\b", text, re.M), f"{name}: outside of a section it is an axiom"


def test_most_example_tasks_of_order_1_have_theorems() -> None:
    names = {name for name, _ in shipped()}
    assert {"omni_s1", "omni_s2", "omni_s3", "omni_heading", "trolley", "crawler", "spacecraft", "empty"} <= names
    assert {(name, scalar) for name in names for scalar in ("float", "double")} == set(shipped())


@pytest.mark.parametrize(
    ("name", "scalar", "told"),
    [
        ("arm", "float", "plant.order 2"),
        ("courier", "float", "missions"),
        ("rover", "float", "unsafe sets that are no boxes"),
        ("crane", "fixed", "controllers in integers"),
    ],
)
def test_what_no_theorem_is_written_about_is_said(name: str, scalar: str, told: str) -> None:
    with pytest.raises(BadInput, match=told):
        read(name, scalar)


def test_generate_writes_what_the_command_asks(tmp_path: Path) -> None:
    """The text follows from the shipped files alone."""
    done = run("generate", "tasks/trolley.toml", "--theorem", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    data = [ROOT / "tasks/trolley.toml", tmp_path / "trolley.c", tmp_path / "trolley.certificate.json"]
    assert (tmp_path / "trolley.v").read_bytes() == written(facts(*(p.read_bytes() for p in data)))


def test_generate_says_where_there_is_no_theorem(tmp_path: Path) -> None:
    done = run("generate", "tasks/arm.toml", "--theorem", "--out", str(tmp_path))
    assert done.returncode == 2
    assert "plant.order 2" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_names_of_sets_cannot_end_the_comment() -> None:
    task, source, certificate = files_of("trolley", "float")
    text = written(facts(task.replace(b'"pillar"', b'"p *) Axiom a : False. (*"'), source, certificate)).decode()
    assert text.count("(*") == text.count("*)")
    assert "p __ Axiom a _ False. __" in text


def test_without_coq_the_command_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    done = run("theorem", "tasks/omni_s1.toml", "generated/omni_s1/refined/float/omni_s1.c", "--json")
    assert done.returncode == 4
    assert "libcoq-coquelicot" in json.loads(done.stdout)["error"]


# ------------------------------------------------------------------------------------------------ what Coq says


QUICK = [("omni_s1", "float"), ("trolley", "float"), ("omni_heading", "double")]


@pytest.mark.parametrize(("name", "scalar"), QUICK)
def test_coq_accepts_shipped_controllers(name: str, scalar: str, tool: Callable[[str], str]) -> None:
    tool("coqc")
    answer = asking.ask_coq(written(read(name, scalar)), name)
    assert answer.holds, answer.what
    assert set(answer.axioms) == asking.AXIOMS


@pytest.mark.slow
@pytest.mark.parametrize(("name", "scalar"), sorted(set(shipped()) - set(QUICK)))
def test_coq_accepts_every_shipped_controller(name: str, scalar: str, tool: Callable[[str], str]) -> None:
    test_coq_accepts_shipped_controllers(name, scalar, tool)


def test_the_command_says_yes_and_names_the_theorems(tool: Callable[[str], str]) -> None:
    tool("coqc")
    done = run("theorem", "tasks/omni_s2.toml", "generated/omni_s2/refined/float/omni_s2.c")
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith("theorem: yes: omni_s2: Coq accepts emitted_tube, closed_loop")
