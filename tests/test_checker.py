"""The stand-alone checker: says yes to what is shipped, alone in an empty folder, and no to every bend."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
import sys
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

import pytest
from conftest import NAMES, ROOT, controller_of
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_certificate import bend, oracle

from stt_codegen.certify import checker
from stt_codegen.pipeline import build_program, build_task, certify
from stt_codegen.task import load_task

sys.path.insert(0, str(ROOT / "benchmarks"))
import token_mutants
from mutants import BASES, draw
from mutations import Random, claiming

CHECKER = ROOT / "stt_codegen" / "certify" / "checker.py"


def lay_out(folder: Path, name: str, scalar: str = "float") -> list[str]:
    """The three files of an example task; the arguments of the checker."""
    shutil.copy(ROOT / "tasks" / f"{name}.toml", folder / "task.toml")
    for file, data in controller_of(name, scalar).files.items():
        (folder / file).write_bytes(data)
    return [str(folder / f) for f in ("task.toml", f"{name}.c", f"{name}.certificate.json")]


def sign_again(arguments: list[str], *others: str) -> None:
    """Put the hashes of the changed files into the certificate."""
    task, source, proof = map(Path, arguments)
    document = json.loads(proof.read_text())
    for name in (source.name, *others):
        document["sha256"][name] = hashlib.sha256((source.parent / name).read_bytes()).hexdigest()
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
    assert len(text.splitlines()) <= 1250


def test_the_checkers_digest_of_a_task_is_the_tools() -> None:
    for name in NAMES:
        data = (ROOT / "tasks" / f"{name}.toml").read_bytes()
        assert checker.Task(data).digest == controller_of(name).task.digest


def read(arguments: list[str], single: bool = True) -> tuple[checker.Task, checker.Source, checker.Tube]:
    """What the checker makes of the three files."""
    task = checker.Task(Path(arguments[0]).read_bytes())
    source = checker.Source(Path(arguments[1]).read_bytes(), task, single)
    return task, source, checker.Tube(source, task, json.loads(Path(arguments[2]).read_text())["grid"]["unit_bits"])


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("name", NAMES)
def test_its_bound_on_rounding_is_the_tools(name: str, scalar: str, tmp_path) -> None:
    """From the statements of the C text here, from the Program there; the tool rounds up to 17 bits."""
    _, source, tube = read(lay_out(tmp_path, name, scalar), scalar == "float")
    error = controller_of(name, scalar).certificate.edge_error
    for own, theirs in zip(checker.arithmetic(source, tube), error, strict=True):
        assert own <= theirs <= own * (1 + Fraction(1, 2**15))


def test_a_sample_of_changed_tokens_and_every_changed_claim_is_found() -> None:
    """All of them: benchmarks/token_mutants.py. What is accepted means the same."""
    for task, every in (("trolley", 20), ("omni_board", 24)):
        for mutant in token_mutants.mutants(task, every):
            if token_mutants.accepted(token_mutants.changed(mutant, task), task):
                assert token_mutants.same_meaning(mutant), mutant
    for label in token_mutants.changed_claims("trolley"):
        assert token_mutants.claim_is_true(label), label


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (
            "static const $_real $_coefficients[140] = {",
            "// static const $_real $_coefficients[140] = {\nstatic const $_real $_coefficients[140] = {",
        ),
        ("static const $_real $_coefficients[140] = {", "#if 0\n#endif\nstatic const $_real $_coefficients[140] = {"),
        (
            "static const $_real $_coefficients[140] = {",
            "#define $_coefficients evil\nstatic const $_real $_coefficients[140] = {",
        ),
        (
            "static const $_real $_coefficients[140] = {",
            'static const char *$_text = "/*";\nstatic const $_real $_coefficients[140] = {',
        ),
        ("started = positive ? t : 0.0F", "started = t + 1.0F"),
        ("positive = 0.0F < t", "positive = 4.0F < t"),
        ("place = u - base", "place = base - base"),
        ("const $_real base = ($_real)segment", "const $_real base = 0.0F"),
        (
            "first = segment * 4;\n    *row = first;\n    *s = place",
            "first = segment * 4;\n    const int32_t off = first + 40;\n    *row = off;\n    *s = place",
        ),
        (
            "const $_real scaled =",
            "// scaled = started * 4.0F;\n    const $_real scaled = 2.0F * started;\n    const $_real other =",
        ),
        ("v6 = v2 + v5", "v6 = v2 - v5"),
        ("v7 = 1.0F + v6", "v7 = 2.0F + v6"),
        ("gain = upper_nearer ? gain_minus : gain_i", "gain = upper_nearer ? gain_i : gain_minus"),
        ("0.193F, 0.436F", "0.0F, 0.436F"),
        ("u[i] = u_held;", "u[i] = 0.0F;"),
        ("outside_any = within ? outside : true", "outside_any = within ? false : true"),
        ("outside_any = within ? outside : true", "outside_any = within ? outside : false"),
        ("margin_next = less ? held_share : margin", "margin_next = less ? margin : held_share"),
        ("const int32_t upper_0 = at + 1;", "const int32_t upper_0 = at + 14;"),
        ("for (int32_t i = 0; i < 2; ++i) {", "for (int32_t i = 0; i < 1; ++i) {"),
        ("logf(v0)", "log1pf(v0)"),
        ("return TROLLEY_BAD_INPUT;", "return TROLLEY_OK;"),
        ("zero = zeros;", "zero = x_zero;"),
        ("const bool finite = zero <= 0.0F;", "const bool finite = 0.0F <= zero;"),
    ],
)
def test_another_meaning_is_found_although_the_hashes_fit(old: str, new: str, tmp_path, capsys) -> None:
    arguments = lay_out(tmp_path, "trolley")
    source = Path(arguments[1])
    old, new = old.replace("$", "trolley"), new.replace("$", "trolley")
    assert old in source.read_text()
    source.write_text(source.read_text().replace(old, new))
    sign_again(arguments)
    assert checker.main(arguments) == 1
    assert "NO" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("#define TROLLEY_N 2", "#define TROLLEY_N 2\n#define trolley_law evil"),
        ("typedef float trolley_real;", "typedef double trolley_real;"),
        ("TROLLEY_OUTSIDE_TUBE = 1", "TROLLEY_OUTSIDE_TUBE = 0"),
        ("PERIOD_PROVED 0.02F", "PERIOD_PROVED 0.1F"),
        ("TROLLEY_T_C 8.0F", "TROLLEY_T_C 9.0F"),
        ('DESIGN_HASH "', 'DESIGN_HASH "0'),
    ],
)
def test_another_header_is_found(old: str, new: str, tmp_path, capsys) -> None:
    arguments = lay_out(tmp_path, "trolley")
    head = tmp_path / "trolley.h"
    assert old in head.read_text()
    head.write_text(head.read_text().replace(old, new))
    sign_again(arguments, "trolley.h")
    assert checker.main(arguments) == 1
    assert "header" in capsys.readouterr().out


def test_a_hidden_cancellation_is_found(tmp_path, capsys) -> None:
    """The same formula in exact arithmetic, and nonsense in floats."""
    arguments = lay_out(tmp_path, "trolley")
    source = Path(arguments[1])
    old = "const trolley_real far = room - near;"
    new = "const trolley_real wide = room + 1.0e9F;\n        const trolley_real less_wide = wide - near;\n        const trolley_real far = less_wide - 1.0e9F;"
    source.write_text(source.read_text().replace(old, new))
    sign_again(arguments)
    assert checker.main(arguments) == 1
    assert "value of no use" in capsys.readouterr().out


@pytest.mark.parametrize("number", [0, 175, 214])
def test_where_the_hull_of_a_segment_shows_too_little_the_hints_cut_it(number: int, tmp_path) -> None:
    _, _, _, (task, design) = draw(Random(f"0 {number}"), BASES)
    files = claiming(task, design, certify(task, design, build_program(task, design)))
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    proof = tmp_path / f"{task.name}.certificate.json"
    document = json.loads(proof.read_text())
    assert document["grid"]["cuts"] > 1
    arguments = [str(tmp_path / "task.toml"), str(tmp_path / f"{task.name}.c"), str(proof)]
    assert checker.main(arguments) == 0
    claim = next(c for c in document["claims"] if len(c.get("hints", [])) > 2)
    del claim["hints"][1]
    proof.write_text(json.dumps(document))
    assert checker.main(arguments) == 1  # a gap in time


def test_a_bound_on_speed_is_claimed(tmp_path) -> None:
    made = build_task(load_task(ROOT / "tasks" / "omni_s1.toml").changed(tube={"segments": 8, "max_speed": 5}))
    text = (
        (ROOT / "tasks" / "omni_s1.toml").read_text().replace("min_width = 0.05", "min_width = 0.05\nsegments = 8\nmax_speed = 5")
    )
    for name, data in {**made.files, "task.toml": text.encode()}.items():
        (tmp_path / name).write_bytes(data)
    assert json.loads(made.files["omni_s1.certificate.json"])["claims"][-1]["margin"] > 0
    assert checker.main([str(tmp_path / n) for n in ("task.toml", "omni_s1.c", "omni_s1.certificate.json")]) == 0


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_with_new_hashes_every_bend_that_breaks_a_property_is_found_by_the_proof(data, tmp_path) -> None:
    """The truth by exact de Boor evaluation at samples, which shares no code with the checker."""
    name = data.draw(st.sampled_from(["omni_s1", "omni_s2", "spacecraft"]))
    controller = controller_of(name)
    j, i = data.draw(st.integers(0, 34)), data.draw(st.integers(0, controller.design.dimension - 1))
    side, amount = data.draw(st.integers(0, 1)), data.draw(st.integers(-(2**19), 2**19))
    bent = bend(controller, j, i, side, amount)
    certificate = certify(controller.task, bent, build_program(controller.task, bent))
    for file, content in claiming(controller.task, bent, certificate).items():
        (tmp_path / file).write_bytes(content)
    truth = oracle(controller.task, bent, Fraction(0))
    answer = checker.main([str(tmp_path / f) for f in ("task.toml", f"{name}.c", f"{name}.certificate.json")])
    assert answer == (0 if certificate.holds else 1)
    if not all(truth.values()):
        assert answer == 1


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
    assert "segment_at_tick of the C" in capsys.readouterr().out


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
    assert "segment of the C" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("lower = [2.0, 2.5]", "lower = [2.0, 2.5]\nupper = [3.0, 3.6]\n[[unsafe]]\nname = \"X\"\nlower = [2.0, 2.5]", "P4"),
        ("initial_state = [0.25, 4.75]", "initial_state = [0.25, 4.99999]", "P2"),
        ("lower = [4.5, 4.5]", "lower = [4.9, 4.5]", "P5"),
        ("min_width = 0.05", "min_width = 0.45", "P1"),
        ("clearance = 0.03", "clearance = 0.031", "P4"),
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


fractions = st.fractions(min_value=-3, max_value=3, max_denominator=50)
places = st.fractions(min_value=0, max_value=1, max_denominator=20)


@given(st.lists(fractions, min_size=8, max_size=8), places, places, places)
def test_a_part_of_a_piece_is_the_same_curve(c: list[Fraction], a: Fraction, b: Fraction, s: Fraction) -> None:
    def at(e: list[Fraction], place: Fraction) -> Fraction:
        r = 1 - place
        return r**3 * e[0] + 3 * r * r * place * e[1] + 3 * r * place**2 * e[2] + place**3 * e[3]

    a, b = sorted((a, b))
    if b > 0:
        (part,) = checker.within([(c[:4], c[4:])], a, b)
        for side, edge in enumerate((c[:4], c[4:])):
            assert at(part[side], s) == at(edge, a + s * (b - a))


@given(st.fractions(min_value=Fraction(1000001, 1000000), max_value=10**6))
def test_its_logarithm_encloses_the_true_one_closely(y: Fraction) -> None:
    low, high = checker.logarithm(y)
    with localcontext(prec=60):
        true = Decimal(y.numerator).ln() - Decimal(y.denominator).ln()
    assert low <= Fraction(true) + Fraction(1, 10**40)
    assert Fraction(true) - Fraction(1, 10**40) <= high
    assert high - low < Fraction(1, 10**16)


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
