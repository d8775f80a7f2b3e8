"""Theorems for Coq: the library has no axioms of its own, Coq accepts every shipped controller, and it refuses changed files."""

from __future__ import annotations

import hashlib
import itertools
import json
import operator
import re
import shutil
from collections.abc import Callable, Iterable
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from stt_codegen.certify.multipliers import multipliers_in
from stt_codegen.checker.stt_checker.sets import euclidean_norm
from stt_codegen.checker.stt_checker.task import Task
from stt_codegen.errors import BadInput
from stt_codegen.task.load import load_task
from stt_codegen.theorem import coq
from stt_codegen.theorem.controller_theorem import coq_string
from stt_codegen.theorem.facts import Facts
from stt_codegen.theorem.reading import Unread, read_facts
from stt_codegen.theorem.text import theorem_text
from stt_codegen.theorem.tube_theorem import coq_list, coq_rational, tube_theorem_text
from stt_codegen.theorem.unsafe_sets import is_box, sets_of
from tests.support.command_line import run_command
from tests.support.controllers import ROOT
from tests.theorem.test_controller_theorem import HALL_TASK

pytestmark = pytest.mark.xdist_group("coq")  # the library is compiled once


def files_of(name: str, scalar: str) -> tuple[bytes, bytes, bytes]:
    """Return task, C and certificate of a shipped controller."""
    folder = ROOT / "generated" / name / "refined" / scalar
    return (
        (ROOT / "tasks" / f"{name}.toml").read_bytes(),
        (folder / f"{name}.c").read_bytes(),
        (folder / f"{name}.certificate.json").read_bytes(),
    )


def read(name: str, scalar: str) -> Facts:
    return read_facts(*files_of(name, scalar))


def shipped() -> list[tuple[str, str]]:
    """Return name and scalar of every shipped refined controller that has a theorem."""
    names = []
    for path in sorted((ROOT / "generated").glob("*/refined/*/*.certificate.json")):
        name, scalar = path.parents[2].name, path.parent.name
        try:
            read(name, scalar)
        except BadInput:
            continue
        names.append((name, scalar))
    return names


# ------------------------------------------------------------------------------------------------ the text of a theorem


def test_the_library_has_no_axioms_or_open_proofs() -> None:
    listed = coq.library_modules()
    assert sorted(p.stem for p in (ROOT / "proof").glob("*.v")) == sorted(listed)
    for name in listed:
        text = re.sub(r"\(\*.*?\*\)", "", (ROOT / "proof" / f"{name}.v").read_text(), flags=re.S)
        assert not re.search(r"\b(Admitted|admit|Axioms?|Parameters?|Conjecture|Abort|give_up|bypass_check)\b", text), name
        assert not re.search(r"^(Variables?|Hypothes[ie]s)\b", text, re.M), f"{name}: outside of a section it is an axiom"


def test_most_example_tasks_of_order_1_have_theorems() -> None:
    names = {name for name, _ in shipped()}
    assert {"omni_s1", "omni_s2", "omni_s3", "omni_heading", "trolley", "crawler", "spacecraft", "rover", "empty"} <= names
    assert {(name, scalar) for name in names for scalar in ("float", "double")} == set(shipped())


@pytest.mark.parametrize(
    ("name", "scalar", "reason"),
    [
        ("courier", "float", "missions"),
        ("crane", "fixed", "controllers in integers"),
    ],
)
def test_a_controller_without_a_theorem_is_refused_with_the_reason(name: str, scalar: str, reason: str) -> None:
    with pytest.raises(BadInput, match=reason):
        read(name, scalar)


@pytest.mark.parametrize("name", ["arm", "attitude", "base", "drone"])
def test_with_order_2_the_theorem_is_about_the_tube_only(name: str) -> None:
    text = text_of(name)
    assert b"There is no theorem yet about the closed loop with plant.order 2." in text
    assert re.findall(rb"^Theorem (\w+)", text, re.M) == [b"emitted_tube"]


def test_generate_writes_the_theorem_of_the_shipped_files(tmp_path: Path) -> None:
    """The text of the theorem depends only on the shipped files."""
    result = run_command("generate", "tasks/trolley.toml", "--theorem", "--out", str(tmp_path))
    assert result.returncode == 0, result.stderr
    data = [ROOT / "tasks/trolley.toml", *(tmp_path / f"trolley{end}" for end in (".h", ".c", ".certificate.json"))]
    assert (tmp_path / "trolley.v").read_bytes() == theorem_text(*(p.read_bytes() for p in data))


def text_of(name: str, task: bytes | None = None) -> bytes:
    """Return the theorem about a shipped controller in float, or about its files with another text of the task."""
    shipped_task, source, certificate = files_of(name, "float")
    header = (ROOT / "generated" / name / "refined" / "float" / f"{name}.h").read_bytes()
    return theorem_text(shipped_task if task is None else task, header, source, certificate)


def test_the_example_in_proof_is_the_theorem_of_omni_s1() -> None:
    assert (ROOT / "proof" / "examples" / "omni_s1.v").read_bytes() == text_of("omni_s1")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"[tube]", "# 5 \u00b5m\n[tube]".encode()),  # beyond ASCII
        (b'name = "omni_s1"', b"name = 'omni_s1'"),
        (b"prescribed_time = 9.0", b"prescribed_time = +9.0"),
        (b"prescribed_time = 9.0", b"prescribed_time = 9.0\nstart_delay = 0.0"),
        (b"[tube]", b"[plant]\norder = 1\n\n[tube]"),
        (b"clearance = 0.03", b'"clearance" = 0.03'),
        (b"prescribed_time = 9.0", b'prescribed_time = 9.0\nemit.math = "libm"'),
        (b"gain = 0.5", b"gain = 0.5\ne_max = 0.4"),
        (b'name = "O1"', b'name = "O1"\ntiming = 0.1'),
    ],
)
def test_a_task_text_that_coq_does_not_read_has_only_the_theorem_about_the_tube(old: bytes, new: bytes) -> None:
    task = files_of("omni_s1", "float")[0]
    assert old in task
    assert text_of("omni_s1").startswith(b"(* omni_s1.v: theorems about the controller")
    changed_text = text_of("omni_s1", task.replace(old, new, 1))
    assert changed_text.startswith(b"(* omni_s1.v: theorems about the tube")
    assert b"there is no theorem yet about the whole C with" in b" ".join(changed_text.split())


def test_generate_refuses_a_task_without_a_theorem(tmp_path: Path) -> None:
    result = run_command("generate", "tasks/courier.toml", "--theorem", "--out", str(tmp_path))
    assert result.returncode == 2
    assert "missions" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_sets_reach_as_far_as_those_of_the_checker_and_of_the_design(tmp_path: Path) -> None:
    """Along many normals, by the formulas of proof/Sets.v, of the checker and of the tool. Half-spaces have the file's numbers."""
    path = tmp_path / "hall.toml"
    path.write_text(HALL_TASK)
    checked_task, task = Task(HALL_TASK.encode()), load_task(path)
    sets = sets_of(checked_task)
    assert sets.space == tuple(tuple(map(Fraction, edge)) for edge in (("0.1", "0.1", "0.05"), ("4.9", "4.9", "1.95")))
    assert sets.walls == tuple(
        (tuple(map(Fraction, normal)), Fraction(b) - dot(map(abs, map(Fraction, normal)), checked_task.body))
        for normal, b in (((1, "0.75", 0), "8.5"), ((-1, -2, 0), "-0.5"))
    )
    assert sets.goals == (((Fraction(1), Fraction(1), Fraction("0.5")), Fraction("9.9")),)
    assert [bool(s.points) + 2 * bool(s.half_spaces) + 4 * is_box(s) for s in sets.unsafe] == [1, 1, 2, 4, 1]
    for j, (obstacle, shape) in enumerate(zip(checked_task.unsafe, sets.unsafe, strict=True)):
        assert (shape.radius, shape.axes) == (obstacle.radius, tuple(obstacle.axes))
        multipliers_of = multipliers_in(task, task.stated_set(j))
        for normal in itertools.product((-3, -1, 0, 2), repeat=3):
            shares, axes_normal = multipliers_of(normal) or (), [normal[i] for i in shape.axes]
            support = dot(normal, [shape.box_about_points[c > 0][i] for i, c in enumerate(normal)])
            support += shape.radius * euclidean_norm(axes_normal)
            if shape.half_spaces:
                rest = [c - dot(shares, [face[i] for face, _ in shape.half_spaces]) for i, c in enumerate(normal)]
                support += dot(shares, [o for _, o in shape.half_spaces]) + dot(
                    rest, [shape.core_box[c > 0][i] for i, c in enumerate(rest)]
                )
            elif shape.points:
                support += max(map(partial(dot, normal), shape.points))
            assert support == obstacle.largest_height(list(normal), shares)
            assert support == task.obstacles[j].support(normal)


def dot(a: Iterable[Any], b: Iterable[Any]) -> Any:
    return sum(map(operator.mul, a, b))


def test_a_theorem_in_a_string_is_not_counted() -> None:
    text = text_of("omni_s1").decode().replace("/* omni_s1.h:", "/* \nTheorem of_all_plants\nomni_s1.h:", 1)
    assert "\nTheorem of_all_plants" in text
    theorems = re.findall(r"^Theorem (\w+)", coq._without_strings(text), re.M)
    assert theorems == ["controller", "closed_loop_example"]
    assert coq._without_strings(text).count("\n") == text.count("\n")


def test_names_of_sets_cannot_end_the_comment() -> None:
    task, source, certificate = files_of("trolley", "float")
    text = tube_theorem_text(read_facts(task.replace(b'"pillar"', b'"p *) Axiom a : False. (*"'), source, certificate)).decode()
    assert text.count("(*") == text.count("*)")
    assert "p __ Axiom a _ False. __" in text


def test_without_coq_the_command_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    result = run_command("theorem", "tasks/omni_s1.toml", "generated/omni_s1/refined/float/omni_s1.c", "--json")
    assert result.returncode == 4
    assert "libcoq-coquelicot" in json.loads(result.stdout)["error"]


# ------------------------------------------------------------------------------------------------ accepted by Coq


@pytest.mark.slow
@pytest.mark.parametrize(("name", "scalar"), shipped())
def test_coq_accepts_every_shipped_controller(name: str, scalar: str, tool: Callable[[str], str]) -> None:
    tool("coqc")
    source = ROOT / "generated" / name / "refined" / scalar / name
    parts = (source.with_suffix(end).read_bytes() for end in (".h", ".c", ".certificate.json"))
    verdict = coq.check_with_coq(theorem_text((ROOT / "tasks" / f"{name}.toml").read_bytes(), *parts), name)
    assert verdict.holds, verdict.message
    assert set(verdict.axioms) == coq.ACCEPTED_AXIOMS


@pytest.mark.slow
def test_the_sampled_theorem_reaches_the_longest_period_of_p9(tmp_path: Path, tool: Callable[[str], str]) -> None:
    """A longer period is proved by the worst path, about which there is no theorem; docs/theorem.md states 0.066 s."""
    tool("coqc")
    text = (ROOT / "tasks/omni_s1.toml").read_text().replace("[target_set]", "share = 0.5\n\n[target_set]")
    text = text.replace("gain = 0.5", 'gain = "tight"\nu_max = 1000.0\nperiod = {}\n\n[plant]\nw_max = 0.05')
    for period, has_theorem in (("0.069", False), ("0.066", True)):
        (tmp_path / "task.toml").write_text(text.format(period))
        result = run_command("generate", str(tmp_path / "task.toml"), "--out", str(tmp_path))
        assert result.returncode == 0, result.stderr
        result = run_command("theorem", str(tmp_path / "task.toml"), str(tmp_path / "omni_s1.c"))
        assert result.returncode == 0, result.stdout
        assert ("closed_loop" in result.stdout) == has_theorem, period


@pytest.mark.slow
def test_the_command_theorem_names_the_accepted_theorems(tool: Callable[[str], str]) -> None:
    tool("coqc")
    result = run_command("theorem", "tasks/omni_s2.toml", "generated/omni_s2/refined/float/omni_s2.c")
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.startswith("theorem: yes: omni_s2: Coq accepts controller, closed_loop_example")


PLANTS = (
    "",
    "[plant]\ng_min = 0.5",
    "[plant]\ng_min = 2.5",
    "[plant]\ng_max = 0.5",
    "[plant]\ng_max = [3, 0.25]\nf_max = 1e-2",
    "[plant]\ng_min = [0.5, 3.0]\ng_max = 4\nnoise = 2.5e-4",
    "[plant]\nf_max = [0.1, 0.2]\nw_max = [0.03, 0]\ng_cross = [0, 0.125]",
    "[plant]\nw_max = 0.1 # gusts\ng_cross = 1E-1",
)
CONTROLS = ("period = 0.02", "period = 2E-2\nlatency = 3.0e-3", "latency = 1\nperiod = 0.5e+1")


@pytest.mark.slow
def test_coq_takes_the_conditions_of_a_task_as_the_checker_does(tool: Callable[[str], str]) -> None:
    """There is one lemma for each text; bounds are missing, one for all components, or by component."""
    tool("coqc")
    before = (ROOT / "tasks/trolley.toml").read_text().partition("[control]")[0]
    lemmas = []
    for plant, control, share in itertools.product(PLANTS, CONTROLS, ("share = 0.8", "")):
        text = f"{before.replace('share = 0.9 ', f'{share} ')}[control]\n{control}\n{plant}\n"
        task = Task(text.encode())
        force, low, high, cross = zip(*(task.bounds(i) for i in range(task.n)), strict=True)
        assert task.period is not None
        numbers = (task.period, task.latency, task.share, (task.plant["noise"] or [Fraction(0)])[0])
        expected = " ".join([*map(coq_rational, numbers), *map(coq_list, (force, low, high, cross))])
        lemmas.append(
            f"Lemma conditions_{len(lemmas)} : conditions_in {coq_string(text)} = Some (Conditions {expected})%Q.\nProof. vm_compute. reflexivity. Qed."
        )
    head = "From Coq Require Import QArith String List.\nFrom Stt Require Import Sound Toml.\nImport ListNotations.\nOpen Scope string_scope."
    verdict = coq.check_with_coq(
        "\n".join([head, *lemmas, "Print Assumptions ClassicalDedekindReals.sig_forall_dec."]).encode(), "conditions"
    )
    assert verdict.holds, verdict.message


# ------------------------------------------------------------------------------------------------ changed files

MUTANTS = [  # controller, file (0 task, 1 C, 2 certificate), pattern, replacement, and the lemma or message that refuses it
    ("omni_s1", 1, rb"(_coefficients\[\d+\] = \{\s+)-?[\d.]+F", rb"\g<1>0.5F", "tube_checked"),
    ("omni_s1", 1, rb"started \* 3\.5555556F", b"started * 3.5555F", "rounding_checked"),
    ("omni_s1", 1, rb"31\.999998F", b"31.99F", "rounding_checked"),
    ("omni_s1", 1, rb"scaled < 31\.999998F", b"scaled < 32.0F", "holds time at another number"),
    ("omni_s1", 1, rb"= 1\.0F - s;", b"= s - 1.0F;", "statements"),
    ("omni_s1", 1, rb"= 3\.0F \* v4;", b"= 2.0F * v4;", "statements"),
    ("omni_s1", 1, rb"= 3\.0F \* v4;", b"= 3.5F * v4;", "which is not whole"),
    ("omni_s1", 1, rb"= v2 \+ v5;", b"= v2 - v5;", "statements"),
    ("omni_s1", 1, rb"at_2 = at \+ 8;", b"at_2 = at + 4;", "`edge_at` of the C has '4' where the listing has '8'"),
    ("omni_s1", 1, rb"= omni_s1_coefficients\[at_1\]", b"= omni_s1_coefficients[at]", "`edge_at` of the C has 'at'"),
    ("omni_s1", 1, rb"return v6;", b"return v5;", "another value than its last"),
    ("omni_s1", 1, rb"segment \* 4;", b"segment * 2;", "`segment` of the C has '2'"),
    ("omni_s1", 1, rb"\*w1 = v7;", b"*w1 = v9;", "statements"),
    ("omni_s1", 0, rb"prescribed_time = 9\.0", b"prescribed_time = 9.1", "rounding_checked"),
    ("omni_s1", 0, rb"clearance = 0\.03", b"clearance = 0.04", "tube_checked"),
    ("omni_s1", 0, rb"min_width = 0\.05", b"min_width = 0.5", "tube_checked"),
    ("omni_s1", 0, rb"initial_state = \[0\.25, 4\.75\]", b"initial_state = [0.55, 4.75]", "tube_checked"),
    ("omni_s1", 0, rb"lower = \[2\.0, 2\.5\]", b"lower = [1.5, 2.5]", "tube_checked"),
    ("omni_s1", 0, rb"(target_set\]\s+lower = )\[4\.5, 4\.5\]", rb"\g<1>[4.6, 4.5]", "tube_checked"),
    ("crawler", 0, rb"period = 0\.005", b"period = 0.3", "period_checked"),
    ("crawler", 0, rb"w_max = 0\.1\n", b"w_max = 1.75\n", "period_checked"),
    ("crawler", 0, rb"\[initial_set\]\n", b"[initial_set]\nshare = 0.95\n", "period_checked"),
    ("trolley", 2, rb'"gain": \["24/625"', b'"gain": ["24/6250"', "another gain"),
    ("rover", 0, rb"radius = 0\.5", b"radius = 0.501", "tube_checked"),
    ("rover", 0, rb"centre = \[2\.6, 1\.2\]", b"centre = [2.6, 1.3]", "tube_checked"),
    ("rover", 0, rb"centre = \[2\.6, 1\.2\]\nradius", b'axes = ["x"]\ncentre = [2.6]\nradius', "tube_checked"),
    ("rover", 0, rb"\[4\.6, 2\.8\]", b"[4.6, 2.79]", "tube_checked"),
    ("rover", 0, rb"\[4\.9, 3\.8\]", b"[4.9, 3.8], [6.1, 4.1]", "tube_checked"),
    ("rover", 0, rb"\[control\]", b"[tube]\nclearance = 0.031\n\n[control]", "tube_checked"),
    ("rover", 0, rb"body = \[0\.45, 0\.45\]", b"body = [0.45, 0.451]", "tube_checked"),
    ("rover", 2, rb"\[-1, -5\]", b"[0, 0]", "tube_checked"),
    ("rover", 2, rb"\[-1, -5\]", b"[1, 5]", "tube_checked"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "file", "old", "new", "refusal"), MUTANTS)
def test_changed_files_have_no_theorem(
    name: str, file: int, old: bytes, new: bytes, refusal: str, tool: Callable[[str], str]
) -> None:
    """Reading and Coq refuse them; hashes and the checker are not used."""
    tool("coqc")
    data = list(files_of(name, "float"))
    changed = re.sub(old, new, data[file])
    assert changed != data[file]
    data[file] = changed
    try:
        verdict = coq.check_with_coq(tube_theorem_text(read_facts(*data)), name)
    except Unread as problem:
        assert refusal in str(problem)
        return
    assert not verdict.holds
    assert refusal in verdict.message


@pytest.mark.slow
def test_the_command_also_runs_the_checker_for_code_that_coq_does_not_read(tmp_path: Path, tool: Callable[[str], str]) -> None:
    """The law has the wrong sign, while table, constants and kernels of the tube are unchanged."""
    tool("coqc")
    shutil.copytree(ROOT / "generated/omni_s1/refined/float", tmp_path / "c")
    source, proof = tmp_path / "c/omni_s1.c", tmp_path / "c/omni_s1.certificate.json"
    text = source.read_text().replace("upper_nearer ? gain_minus : gain_i", "upper_nearer ? gain_i : gain_minus")
    text = text.replace("upper_nearer ? (-0.5F) : 0.5F", "upper_nearer ? 0.5F : (-0.5F)")
    assert text != source.read_text()
    source.write_text(text)
    document = json.loads(proof.read_text())
    document["sha256"]["omni_s1.c"] = hashlib.sha256(source.read_bytes()).hexdigest()
    proof.write_text(json.dumps(document))
    result = run_command("theorem", "tasks/omni_s1.toml", str(source), "--json")
    assert result.returncode == 1
    assert "checker: refused: omni_s1.c has" in json.loads(result.stdout)["what"]
