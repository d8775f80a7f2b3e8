"""The stand-alone checker: says yes to what is shipped, alone in an empty folder, and no to every bend."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest
from conftest import NAMES, ROOT, controller_of
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_certificate import bend, oracle

from stt_codegen.certify import checker
from stt_codegen.program.number import shortest

CHECKER = ROOT / "stt_codegen" / "certify" / "checker.py"


def lay_out(folder: Path, name: str, scalar: str = "float") -> list[str]:
    """The three files of an example task; the arguments of the checker."""
    shutil.copy(ROOT / "tasks" / f"{name}.toml", folder / "task.toml")
    for file, data in controller_of(name, scalar).files.items():
        (folder / file).write_bytes(data)
    return [str(folder / f) for f in ("task.toml", f"{name}.c", f"{name}.certificate.json")]


def sign_again(arguments: list[str]) -> None:
    """Put the hashes of the changed files into the certificate."""
    task, source, proof = map(Path, arguments)
    document = json.loads(proof.read_text())
    document["sha256"][source.name] = hashlib.sha256(source.read_bytes()).hexdigest()
    document["sha256"]["task_data"] = checker.Task(task.read_bytes()).digest
    proof.write_text(json.dumps(document))


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("name", NAMES)
def test_every_shipped_controller_is_confirmed_alone_in_an_empty_folder(name: str, scalar: str, tmp_path) -> None:
    lay_out(tmp_path, name, scalar)
    shutil.copy(CHECKER, tmp_path)
    command = [sys.executable, "-I", "-S", "checker.py", "task.toml", f"{name}.c", f"{name}.certificate.json"]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.startswith(f"checker: yes: {name}")


def test_the_checker_imports_the_standard_library_only_and_is_short() -> None:
    text = CHECKER.read_text()
    imported = set(re.findall(r"^(?:from|import) (\w+)", text, re.M))
    assert imported <= set(sys.stdlib_module_names)
    assert len(text.splitlines()) <= 300


def test_the_checkers_digest_of_a_task_is_the_tools() -> None:
    for name in NAMES:
        data = (ROOT / "tasks" / f"{name}.toml").read_bytes()
        assert checker.Task(data).digest == controller_of(name).task.digest


def test_its_bound_on_rounding_is_near_the_tools_and_never_needed_to_be_larger() -> None:
    for name in NAMES:
        controller = controller_of(name)
        tube = checker.Tube(controller.files[f"{name}.c"].decode(), checker.Task((ROOT / "tasks" / f"{name}.toml").read_bytes()))
        own = checker.arithmetic(tube, list(tube.pieces()))
        assert max(controller.certificate.edge_error) / 3 <= own <= 2 * max(controller.certificate.edge_error)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.floats(0, 1), file=st.sampled_from([0, 1, 2]))
def test_every_changed_digit_is_found_by_the_hashes_or_the_claims(place: float, file: int, tmp_path) -> None:
    arguments = lay_out(tmp_path, "omni_s1")
    target = Path(arguments[file])
    text = target.read_text()
    code = re.sub(r"#.*", lambda m: " " * len(m.group()), text) if file == 0 else text
    spots = [m.start() for m in re.finditer(r"\d", code)]
    k = spots[int(place * (len(spots) - 1))]
    changed = str((int(text[k]) + 1) % 10)
    target.write_text(text[:k] + changed + text[k + 1 :])
    if file == 2:
        before, after = json.loads(text), json.loads(target.read_text())
        if not claims_more(before, after):
            return  # a smaller claim, or a place: true all the same, or of no consequence
    assert checker.main(arguments) != 0


def claims_more(before: dict, after: dict) -> bool:
    """Whether a changed certificate has another hash of a file that is checked, or another number that binds."""
    keys = ("segments", "clearance", "min_width", "prescribed_time", "scalar", "certified")
    if any(before.get(k) != after.get(k) for k in keys) or before["parameters"]["segments"] != after.get("parameters", {}).get(
        "segments"
    ):
        return True
    return any(before["sha256"].get(k) != after.get("sha256", {}).get(k) for k in ("task_data", "omni_s1.c"))


@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_with_new_hashes_every_bend_that_breaks_a_property_is_found_by_the_proof(data, tmp_path) -> None:
    """The truth by exact de Boor evaluation at samples, which shares no code with the checker."""
    name = data.draw(st.sampled_from(["omni_s1", "omni_s2", "spacecraft"]))
    controller = controller_of(name)
    j, i = data.draw(st.integers(0, 34)), data.draw(st.integers(0, controller.design.dimension - 1))
    side, amount = data.draw(st.integers(0, 1)), data.draw(st.integers(-(2**19), 2**19))
    bent = bend(controller, j, i, side, amount)
    arguments = lay_out(tmp_path, name)
    source = Path(arguments[1])
    source.write_text(with_table(source.read_text(), bent))
    sign_again(arguments)
    truth = oracle(controller.task, bent, Fraction(0))
    answer = checker.main(arguments)
    assert answer in (0, 1)
    if not all(truth.values()):
        assert answer == 1


def with_table(text: str, design) -> str:
    values = [shortest(v * design.unit, "float") + "F" for row in design.table for pair in row for v in pair]
    return re.sub(r"(_coefficients\[\d+\] = \{).*?(\};)", lambda m: m[1] + ", ".join(values) + m[2], text, flags=re.DOTALL)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("count * 4", "count * 8"),
        ("whole : 31", "whole : 3100"),
        ("part / 1125.0F", "part / 100.0F"),
        ("tick < 9000U", "tick < 900U"),
        ("place / 1125", "place / 1124"),
    ],
)
def test_another_time_in_ticks_is_found(old: str, new: str, tmp_path, capsys) -> None:
    arguments = lay_out(tmp_path, "omni_board")
    source = Path(arguments[1])
    assert old in source.read_text()
    source.write_text(source.read_text().replace(old, new))
    sign_again(arguments)
    assert checker.main(arguments) == 1
    assert "ticks of the C file" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("started * 3.5555556F", "started * 3.6555556F"),
        ("started * 3.5555556F", "t * 3.5555556F"),
        ("segment = (int32_t)u", "segment = (int32_t)scaled"),
        ("segment * 4", "segment * 2"),
        ("scaled < 31.999998F", "scaled < 33.0F"),
        ("scaled < 31.999998F", "scaled < 31.0F"),
        ("scaled : 31.999998F", "scaled : 32.0F"),
    ],
)
def test_another_time_scale_or_index_is_found(old: str, new: str, tmp_path, capsys) -> None:
    arguments = lay_out(tmp_path, "omni_s1")
    source = Path(arguments[1])
    assert old in source.read_text()
    source.write_text(source.read_text().replace(old, new))
    sign_again(arguments)
    assert checker.main(arguments) == 1
    assert "C file" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("lower = [2.0, 2.5]", "lower = [2.0, 2.5]\nupper = [3.0, 3.6]\n[[unsafe]]\nname = \"X\"\nlower = [2.0, 2.5]", "P4"),
        ("initial_state = [0.25, 4.75]", "initial_state = [0.25, 4.99999]", "P2"),
        ("lower = [4.5, 4.5]", "lower = [4.9, 4.5]", "P5"),
        ("min_width = 0.05", "min_width = 0.45", "min_width"),
        ("clearance = 0.03", "clearance = 0.031", "clearance"),
        ("min_width = 0.05", "min_width = 0.05\nmax_speed = 0.5", "P6"),
    ],
)  # fmt: skip
def test_a_harder_task_is_found_although_the_hashes_fit(old: str, new: str, code: str, tmp_path, capsys) -> None:
    arguments = lay_out(tmp_path, "omni_s1")
    task = Path(arguments[0])
    assert old in task.read_text()
    task.write_text(task.read_text().replace(old, new))
    sign_again(arguments)
    assert checker.main(arguments) == 1
    assert code in capsys.readouterr().out


def test_a_width_that_task_and_certificate_agree_on_but_the_tube_has_not_is_found(tmp_path, capsys) -> None:
    arguments = lay_out(tmp_path, "omni_s1")
    task, proof = Path(arguments[0]), Path(arguments[2])
    task.write_text(task.read_text().replace("min_width = 0.05", "min_width = 0.42"))  # the tube's least is 0.411
    proof.write_text(proof.read_text().replace('"min_width": "0.05"', '"min_width": "0.42"'))
    sign_again(arguments)
    assert checker.main(arguments) == 1
    assert "P1 does not hold" in capsys.readouterr().out


fractions = st.fractions(min_value=-3, max_value=3, max_denominator=50)


@given(st.lists(fractions, min_size=8, max_size=8), st.fractions(min_value=0, max_value=1, max_denominator=20))
def test_halving_changes_no_point_of_the_curve(c: list[Fraction], s: Fraction) -> None:
    def at(e: list[Fraction], place: Fraction) -> Fraction:
        r = 1 - place
        return r**3 * e[0] + 3 * r * r * place * e[1] + 3 * r * place**2 * e[2] + place**3 * e[3]

    piece = [(c[:4], c[4:])]
    first, second = checker.halves(piece)
    for side in (0, 1):
        assert at(first[0][side], s) == at(piece[0][side], s / 2)
        assert at(second[0][side], s) == at(piece[0][side], (1 + s) / 2)


def test_halving_shows_what_the_hull_alone_does_not() -> None:
    """The cubic 0, 1, 1, 0 peaks at 3/4: below 4/5 by halving, although its hull reaches 1."""
    peak = [Fraction(v) for v in (0, 1, 1, 0)]
    needed = Fraction(1, 1000)

    def slack(piece) -> Fraction:
        return Fraction(4, 5) - max(piece[0][1])

    assert slack([(peak, peak)]) < 0
    assert needed <= checker.least([(peak, peak)], slack, needed) <= Fraction(4, 5) - Fraction(3, 4)


def test_a_claim_of_more_room_than_there_is_is_found(tmp_path, capsys) -> None:
    arguments = lay_out(tmp_path, "omni_s1")
    proof = Path(arguments[2])
    document = json.loads(proof.read_text())
    entry = next(p for p in document["properties"] if p["property"] == "P4")
    entry["margin"] += 0.001
    proof.write_text(json.dumps(document))
    assert checker.main(arguments) == 1
    assert "claims more room for P4" in capsys.readouterr().out


def test_what_it_cannot_check_it_says_so(tmp_path, capsys) -> None:
    arguments = lay_out(tmp_path, "omni_s1")
    folder = ROOT / "generated" / "omni_s1" / "literal" / "float"
    literal = [arguments[0], str(folder / "omni_s1.c"), str(folder / "omni_s1.certificate.json")]
    assert checker.main(literal) == 2
    assert "only those can be checked here" in capsys.readouterr().err
    assert checker.main(arguments[:2]) == 2
    assert checker.main([*arguments[:2], str(tmp_path / "none.json")]) == 2


def test_the_command_line_runs_the_same_checker(tmp_path) -> None:
    arguments = lay_out(tmp_path, "omni_s1")
    command = [sys.executable, "-m", "stt_codegen.cli", "certify", *arguments]
    good = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (good.returncode, good.stdout[:12]) == (0, "checker: yes")
    Path(arguments[1]).write_text(Path(arguments[1]).read_text() + " ")
    assert subprocess.run(command, capture_output=True, text=True, check=False).returncode == 1
