"""The stand-alone checker: it accepts what is shipped, alone in an empty folder, and refuses what is changed.

The tables of changes are texts of emitted C: (text that occurs in the file, its replacement). `$` stands for the task's name."""

from __future__ import annotations

import functools
import hashlib
import itertools
import json
import math
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks import token_mutants
from benchmarks.mutants.tubes import BOX_BASE_NAMES, draw_mutant
from benchmarks.mutations import files_claiming_success
from stt_codegen.certify import checker
from stt_codegen.certify.claims import claims_of, cuts_of
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.emit.integers import loaded
from stt_codegen.pipeline import build_program, certify
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.certify.test_certificate import bend, oracle
from tests.support.controllers import NAMES, ROOT, build_once, controller_of

CHECKER = ROOT / "stt_codegen" / "certify" / "checker.py"


def write_files(folder: Path, name: str, scalar: str = "float") -> list[str]:
    """Write the three files of an example task into the folder, and return them as arguments of the checker."""
    shutil.copy(ROOT / "tasks" / f"{name}.toml", folder / "task.toml")
    for file, data in controller_of(name, scalar).files.items():
        (folder / file).write_bytes(data)
    return [str(folder / f) for f in ("task.toml", f"{name}.c", f"{name}.certificate.json")]


def update_hashes(arguments: list[str], *more_files: str) -> None:
    """Put the hashes of the files as they are now into the certificate. more_files: names of files beside task and C."""
    task, source, proof = map(Path, arguments)
    document = json.loads(proof.read_text())
    for name in (source.name, *more_files):
        document["sha256"][name] = hashlib.sha256((source.parent / name).read_bytes()).hexdigest()
    document["sha256"]["task_data"] = checker.Task(task.read_bytes()).digest
    proof.write_text(json.dumps(document))


def refusal_of_change(arguments: list[str], file: str, old: str, new: str, capsys) -> str:
    """Replace a text in a file, update the hashes, and return the message with which the checker refuses the files."""
    path = Path(arguments[0]).parent / file
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    update_hashes(arguments, *([file] if file.endswith(".h") else []))
    assert checker.main(arguments) == 1
    return capsys.readouterr().out


RECORDED = sorted(path.parent.relative_to(ROOT) for path in ROOT.glob("generated/*/refined/*/*.certificate.json"))


@pytest.mark.parametrize("folder", RECORDED, ids=str)
def test_every_shipped_controller_is_accepted_in_an_empty_folder(folder: Path, tmp_path) -> None:
    """Every recorded refined controller, with all that its task emits."""
    name = folder.parts[1]
    shutil.copytree(ROOT / folder, tmp_path, dirs_exist_ok=True)
    shutil.copy(ROOT / "tasks" / f"{name}.toml", tmp_path / "task.toml")
    shutil.copy(CHECKER, tmp_path)
    command = [sys.executable, "-I", "-S", "checker.py", "task.toml", f"{name}.c", f"{name}.certificate.json"]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.startswith(f"checker: yes: {name}")


def test_the_checker_imports_the_standard_library_only_and_is_short() -> None:
    text = CHECKER.read_text()
    imported = set(re.findall(r"^(?:from|import) (\w+)", text, re.M))
    assert imported <= set(sys.stdlib_module_names)
    assert len(text.splitlines()) <= 3350


def test_checker_and_tool_compute_the_same_digest_of_a_task() -> None:
    for name in NAMES:
        data = (ROOT / "tasks" / f"{name}.toml").read_bytes()
        assert checker.Task(data).digest == controller_of(name).task.digest


def read_files(arguments: list[str], single: bool = True) -> tuple[checker.Task, checker.Source, checker.Tube]:
    """Return the three files as the checker reads them. single: whether the C computes in float."""
    task = checker.Task(Path(arguments[0]).read_bytes())
    source = checker.Source(Path(arguments[1]).read_bytes(), task, single)
    return task, source, checker.Tube(source, task, json.loads(Path(arguments[2]).read_text())["grid"]["unit_bits"])


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("name", NAMES)
def test_checker_and_tool_have_the_same_bound_on_rounding(name: str, scalar: str, tmp_path) -> None:
    """The checker reads the C, the tool its Program; the tool rounds the bound up to 17 bits."""
    _, source, tube = read_files(write_files(tmp_path, name, scalar), scalar == "float")
    error = controller_of(name, scalar).certificate.edge_error
    for bound, tool_bound in zip(checker.arithmetic(source, tube), error, strict=True):
        assert bound <= tool_bound <= bound * (1 + Fraction(1, 2**15))


def test_changed_tokens_and_claims_are_refused_unless_they_mean_the_same() -> None:
    """A sample of changed tokens of C, and every changed claim; benchmarks/token_mutants.py checks all tokens."""
    for task, stride in (("trolley", 240), ("omni_board", 288)):
        for mutant in token_mutants.token_mutants(task, stride):
            if token_mutants.is_accepted(token_mutants.changed_files(mutant, task), task):
                assert token_mutants.reason_for_same_meaning(mutant, task), mutant
    for label in token_mutants.accepted_claims("trolley"):
        assert token_mutants.reason_for_true_claim(label), label


def gains(source: Path) -> list[str]:
    """Return the gains as the table in the C writes them."""
    table = re.search(r"_gain\[\d+\] = \{([^}]*)\}", source.read_text())
    return re.findall(r"[\d.e-]+F", table[1]) if table else []


def filled(text: str, task: str, source: Path) -> str:
    """Return the text with the task's name for `$`, and the C's own gain and coefficient for the names in <..>."""
    last = re.search(r"(\S+)\n\};", source.read_text())[1]
    return text.replace("$", task).replace("<first gain>", *gains(source)[:1] or [""]).replace("<last coefficient>", last)


# Changes of trolley's C that a compiler accepts and that change the meaning.
CHANGED_MEANINGS = [
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
    ("<first gain>", "0.0F"),
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
]


@pytest.mark.parametrize(("old", "new"), CHANGED_MEANINGS)
def test_c_of_another_meaning_is_refused_although_the_hashes_fit(old: str, new: str, tmp_path, capsys) -> None:
    arguments = write_files(tmp_path, "trolley")
    source = Path(arguments[1])
    old, new = (filled(text, "trolley", source) for text in (old, new))
    assert old in source.read_text()
    source.write_text(source.read_text().replace(old, new))
    update_hashes(arguments)
    assert checker.main(arguments) == 1
    assert "NO" in capsys.readouterr().out


# Changes that a careless reader of C would miss: comments, octal numbers, other names, and sums that round or overflow.
SUBTLE_CHANGES = [
    ("trolley", "v4 = v3 / b;", "v4 = v3 //* */ b\n    ;"),
    ("trolley", "logf(v0)", "trolley_logf(v0)"),
    ("trolley", "trolley_segment(t, &row, &s);", "segment(t, &row, &s);"),
    ("trolley", "at + 12;", "at + 012;"),
    ("trolley", "coefficients[140]", "coefficients[0214]"),
    (
        "trolley",
        "    *w0 = v2;",
        "    const $_real z0 = 0.0F;\n    const $_real big = v2 + 100000000.0F;\n    const $_real less = big - 100000000.0F;\n    *w0 = less;",
    ),
    (
        "trolley",
        "    *w0 = v2;",
        "    const $_real up = v2 * 1.0e30F;\n    const $_real upper = up * 1.0e30F;\n    const $_real down = upper * 1.0e-30F;\n    const $_real w = down * 1.0e-30F;\n    *w0 = w;",
    ),
    (
        "trolley",
        "    *w0 = v2;",
        "    const $_real low = v2 * 0.0000000000000000000000000000000000000000000000001F;\n    *w0 = low;",
    ),
    (
        "trolley",
        "    *dw0 = v5;",
        "    const $_real big = v5 + 100000000.0F;\n    const $_real less = big - 100000000.0F;\n    *dw0 = less;",
    ),
    (
        "omni_board",
        "below = mantissa - 1.0F;\n    const $_real above = mantissa + 1.0F;",
        "above = mantissa + 1.0F;\n    const $_real below = above - 2.0F;",
    ),
    (
        "trolley",
        "    bool outside = false;",
        "    const $_status TROLLEY_OUTSIDE_TUBE = TROLLEY_OK;\n    bool outside = false;",
    ),
    (
        "omni_board",
        "at = row + pair;",
        "huge = row * 2000000000;\n        const int32_t none = huge - huge;\n        const int32_t near_at = row + none;\n        const int32_t at = near_at + pair;",
    ),
    (
        "omni_board",
        "const bool before_last = whole < 31;",
        "const int32_t moved = whole + 2147483640;\n    const bool before_last = moved < 2147483671;",
    ),
    (
        "omni_board",
        "const int32_t whole = place / 1125;",
        "const int32_t none = place - place;\n    const int32_t odd = place / none;\n    const int32_t whole = place / 1125;",
    ),
    (
        "omni_board",
        "const bool running = tick < 9000U;",
        "const int32_t ahead = (int32_t)tick;\n    const bool running = tick < 9000U;",
    ),
    (
        "trolley",
        "const int32_t segment = (int32_t)u;",
        "const int32_t early_one = (int32_t)scaled;\n    const int32_t segment = (int32_t)u;",
    ),
    ("trolley", "const $_real room = ", "const $_real volatile = upper_edge - lower_edge;\n        const $_real room = "),
    (
        "trolley",
        "<last coefficient>\n};",
        "<last coefficient>\n}",
    ),
    ("trolley", "const $_real v0 = k * xi;", "const $_real v0 = $_law(k, xi, epsilon);"),
    ("trolley", "{\n    const bool finite = isfinite(t) != 0;", "{" * 3000 + "\n    const bool finite = isfinite(t) != 0;"),
    (
        "trolley",
        "const bool wide = 9.536743e-7F < room;",
        "const bool wide = 9.536743e-7F < room;\n        const bool wider = 1.0F < room;",
    ),
]


@pytest.mark.parametrize(("task", "old", "new"), SUBTLE_CHANGES)
def test_a_change_that_a_careless_reader_would_miss_is_refused(task: str, old: str, new: str, tmp_path, capsys) -> None:
    arguments = write_files(tmp_path, task)
    source = Path(arguments[1])
    old, new = (filled(text, task, source) for text in (old, new))
    assert old in source.read_text()
    source.write_text(source.read_text().replace(old, new))
    update_hashes(arguments)
    assert checker.main(arguments) in (1, 2)
    output = capsys.readouterr()
    assert re.search("of the C|the C has|basis|P7|Recursion|of the scalar's range", output.out + output.err)


def test_a_store_before_the_load_of_another_loop_is_refused(tmp_path, capsys) -> None:
    """u may be the array x itself: with two loops the second would read what the first has written."""
    arguments = write_files(tmp_path, "trolley")
    source = Path(arguments[1])
    text = source.read_text()
    begin = text.index("trolley_status trolley_control(")
    position = text.index("        u[i] = u_held;\n        outside = outside_any;\n    }\n", begin)
    two_loops = "        u[i] = u_held;\n        outside = outside_any;\n    }\n    for (int32_t k = 0; k < 2; ++k) {\n        const trolley_real x_k = x[k];\n    }\n"
    source.write_text(
        text[:position] + two_loops + text[position + len("        u[i] = u_held;\n        outside = outside_any;\n    }\n") :]
    )
    update_hashes(arguments)
    assert checker.main(arguments) == 1
    assert "a number read where none may be" in capsys.readouterr().out


def test_a_chosen_gain_is_positive(tmp_path, capsys) -> None:
    arguments = write_files(tmp_path, "trolley")
    source, proof = Path(arguments[1]), Path(arguments[2])
    for number in gains(source):
        source.write_text(source.read_text().replace(number, f"-{number}"))
    claimed = json.loads(proof.read_text())["control"]["gain"]
    for number in claimed:
        proof.write_text(proof.read_text().replace(f'"{number}"', f'"-{number}"'))
    update_hashes(arguments)
    assert checker.main(arguments) == 1
    assert "not of one sign, or not positive" in capsys.readouterr().out


# Changes of trolley's header.
CHANGED_HEADERS = [
    ("#define TROLLEY_T_C 8.0F", "#define TROLLEY_T_C 8.0F / 100.0F"),
    ('extern "C" {\n#endif', 'extern "C" { #endif'),
    ("#define TROLLEY_N 2", "#define TROLLEY_N 2\n#define trolley_law evil"),
    ("typedef float trolley_real;", "typedef double trolley_real;"),
    ("TROLLEY_OUTSIDE_TUBE = 1", "TROLLEY_OUTSIDE_TUBE = 0"),
    ("PERIOD_PROVED 0.02F", "PERIOD_PROVED 0.1F"),
    ("TROLLEY_T_C 8.0F", "TROLLEY_T_C 9.0F"),
    ('DESIGN_HASH "', 'DESIGN_HASH "0'),
]


@pytest.mark.parametrize(("old", "new"), CHANGED_HEADERS)
def test_a_changed_header_is_refused(old: str, new: str, tmp_path, capsys) -> None:
    arguments = write_files(tmp_path, "trolley")
    header = tmp_path / "trolley.h"
    assert old in header.read_text()
    header.write_text(header.read_text().replace(old, new))
    update_hashes(arguments, "trolley.h")
    assert checker.main(arguments) == 1
    assert re.search("header|directive", capsys.readouterr().out)


# Changes of trolley's C that are equal in exact arithmetic, and not in floats.
REORDERED_SUMS = [
    (
        "far = room - near;",
        "wide = room + 1.0e9F;\n        const $_real less = wide - near;\n        const $_real far = less - 1.0e9F;",
    ),
    ("to_upper = upper_edge - x_i;", "to_upper = room - to_lower;"),
    (
        "room = upper_edge - lower_edge;",
        "to_low = x_i - lower_edge;\n        const $_real to_up = upper_edge - x_i;\n        const $_real room = to_low + to_up;",
    ),
]


@pytest.mark.parametrize(("old", "new"), REORDERED_SUMS)
def test_an_equal_formula_that_rounds_differently_is_refused(old: str, new: str, tmp_path, capsys) -> None:
    """In floats the changed formula loses the distance to the nearer edge."""
    arguments = write_files(tmp_path, "trolley")
    source = Path(arguments[1])
    assert old in source.read_text()
    source.write_text(source.read_text().replace(old, new.replace("$", "trolley")))
    update_hashes(arguments)
    assert checker.main(arguments) == 1
    assert "not the law's" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("lower = [4.0, 2.0]", "lower = [4.0]"),
        ("lower = [4.0, 2.0]", "lower = 4.0"),
        ("u_max = [2.0, 2.0]", "u_max = [2.0]"),
        ("body = [0.15, 0.1]", "body = [0.15]"),
        ("g_min = 0.9", "g_min = -0.9"),
        ("w_max = 0.1", "w_max = -0.1"),
        ("latency = 0.002", "latency = -0.002"),
        ("prescribed_time = 8.0", "prescribed_time = 1e999999999"),
        ("share = 0.9", "share = 1.0"),
        ("share = 0.9", "share = 2.5"),
        ("clearance = 0.05", "clearance = -1.0"),
        ("lower = [1.6, 0.6]", "lower = [9.6, 0.6]"),
        ("upper = [5.0, 3.0]", "upper = [5.0]"),
        ("[control]", "[control]\nlaw = 2"),
        ("[[unsafe]]", "[[unsafe]]\nmotion = 1"),
        ("[[unsafe]]", "[[unsafe]]\nmotion = [{at = 0, by = 0.5}]"),
        ("[[unsafe]]", "[[unsafe]]\nmotion = [{at = 1, by = [0, 0]}, {at = 1, by = [1, 0]}]"),
        ("[[unsafe]]", "[[unsafe]]\nduring = [3, 2]"),
        ("[target_set]", "[target_set]\nradius = 0.01"),
        ("lower = [4.0, 2.0]", "centre = [4.4, 2.4]\nradius = 0.2"),
        ("[control]", "[[unsafe]]\nname = 'pillar'\nlower = [0, 0]\nupper = [0.1, 0.1]\n[control]"),
    ],
)
def test_an_invalid_task_is_an_error_of_input(old: str, new: str, tmp_path, capsys) -> None:
    arguments = write_files(tmp_path, "trolley")
    task = Path(arguments[0])
    assert old in task.read_text()
    task.write_text(task.read_text().replace(old, new))
    assert checker.main(arguments) == 2
    assert "the task has" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("field", "change", "message"),
    [
        ("rho", lambda v: v / 2, "rho is not between"),
        ("rho", lambda v: v * Fraction(9, 10), "rho is not between"),
        ("u", lambda v: v * Fraction(99, 100), "|u| is at most"),
        ("u", lambda v: v * Fraction(101, 100), "|u| is at most"),
        ("shift", lambda v: v * Fraction(99, 100), "the law sees more wrong"),
        ("shift", lambda v: v * Fraction(101, 100), "the law sees more wrong"),
    ],
)
def test_a_wrong_claim_about_samples_is_refused(field: str, change: Callable, message: str, tmp_path, capsys) -> None:
    arguments = write_files(tmp_path, "trolley")
    proof = Path(arguments[2])
    document = json.loads(proof.read_text())
    document["sampled"][field] = [str(change(Fraction(v))) for v in document["sampled"][field]]
    proof.write_text(json.dumps(document))
    assert checker.main(arguments) == 1
    assert message in capsys.readouterr().out


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("period = 0.02 ", "period = 0.05 ", "P9 does not hold"),
        ("w_max = 0.1", "w_max = 1.5", "P9 does not hold"),
        ("g_max = 1.1", "g_max = 20.0", "P9 does not hold"),
        ("g_min = 0.9", "g_min = 0.2", "P9 does not hold"),
        ("noise = 0.002", "noise = 0.01", "shift"),
        ("initial_state = [0.5, 0.5]", "initial_state = [0.22, 0.5]", "P"),
    ],
)
def test_a_loop_beyond_its_proof_is_refused_although_certificate_and_header_fit_it(
    old: str, new: str, message: str, tmp_path, capsys
) -> None:
    arguments = write_files(tmp_path, "trolley")
    task, proof = Path(arguments[0]), Path(arguments[2])
    assert old in task.read_text()
    task.write_text(task.read_text().replace(old, new))
    checked_task = checker.Task(task.read_bytes())
    document = json.loads(proof.read_text())
    document["sampled"]["period"] = str(checked_task.period)
    document["sampled"]["plant"] = checked_task.stated
    proof.write_text(json.dumps(document))
    header = tmp_path / "trolley.h"
    header.write_text(
        header.read_text().replace(
            "PERIOD_PROVED 0.02F", f"PERIOD_PROVED {float(checker.rounded(checked_task.period, 24, math.floor))}F"
        )
    )
    update_hashes(arguments, "trolley.h")
    document = json.loads(proof.read_text())
    design = checker.design_hash(checked_task, read_files(arguments)[2], "float", document["grid"]["unit_bits"])
    header.write_text(re.sub(r'DESIGN_HASH "\w+"', f'DESIGN_HASH "{design}"', header.read_text()))
    update_hashes(arguments, "trolley.h")
    source, tube = checker.Source(Path(arguments[1]).read_bytes(), checked_task, True), read_files(arguments)[2]
    Path(arguments[1]).write_text(
        with_starts(Path(arguments[1]).read_text(), checker.covered_starts(checked_task, tube, source, []))
    )
    update_hashes(arguments, "trolley.c")
    assert checker.main(arguments) == 1
    assert message in capsys.readouterr().out


def with_starts(text: str, tables: dict[str, list[Fraction]]) -> str:
    """Return the text of a C file in float with other tables of the covered starts."""
    for name, values in tables.items():
        entries = ", ".join(f"{float(v)!r}F" for v in values)
        text = re.sub(rf"(_{name}\[\d+\] = {{)[^}}]*}}", rf"\1\n    {entries}\n}}", text)
    return text


def test_the_order_of_keys_in_a_certificate_does_not_matter_but_types_do(tmp_path) -> None:
    arguments = write_files(tmp_path, "trolley")
    proof = Path(arguments[2])
    document = json.loads(proof.read_text())
    proof.write_text(json.dumps(document, sort_keys=True))
    assert checker.main(arguments) == 0
    for fraction in (" 95027977/5000000", "9_5027977/5000000", "95027977/5000000\n"):
        proof.write_text(json.dumps({**document, "sampled": {**document["sampled"], "rho": [fraction, fraction]}}))
        assert checker.main(arguments) == 1
    document["claims"][0]["on"][0] = False
    proof.write_text(json.dumps(document))
    assert checker.main(arguments) == 1
    proof.write_text("[" * 100_000)
    assert checker.main(arguments) == 2


def test_the_documents_example_is_a_recorded_certificate() -> None:
    """Every line of a claim in docs/certificate-format.md is a line of trolley's recorded certificate."""
    documented = re.findall(
        r'^ +("(?:grid|speed|start|control|edge_error)".*|\{"property".*)$',
        (ROOT / "docs" / "certificate-format.md").read_text(),
        re.M,
    )
    recorded = (ROOT / "generated" / "trolley" / "refined" / "float" / "trolley.certificate.json").read_text()
    assert len(documented) == 12
    assert all(line in recorded for line in documented)


@functools.cache
def tubes_that_need_cuts() -> list[tuple[Task, RefinedDesign]]:
    """Return the first three mutated tubes of seed 0 whose proof cuts segments into parts."""
    tubes = []
    for number in itertools.count():
        task, design = draw_mutant(Random(f"0 {number}"), BOX_BASE_NAMES).mutant
        certificate = certify(task, design, build_program(task, design))
        if certificate.holds and cuts_of(claims_of(task, design, certificate)) > 1:
            tubes.append((task, design))
        if len(tubes) == 3:
            return tubes
    return []


@pytest.mark.parametrize("number", range(3))
def test_a_proof_that_cuts_segments_is_accepted_and_refused_with_a_cut_left_out(number: int, tmp_path) -> None:
    task, design = tubes_that_need_cuts()[number]
    files = files_claiming_success(task, design, certify(task, design, build_program(task, design)))
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


def test_a_bound_on_speed_is_claimed_and_accepted(tmp_path) -> None:
    controller = build_once(load_task(ROOT / "tasks" / "omni_s1.toml").changed(tube={"segments": 8, "max_speed": 5}))
    text = (
        (ROOT / "tasks" / "omni_s1.toml").read_text().replace("min_width = 0.05", "min_width = 0.05\nsegments = 8\nmax_speed = 5")
    )
    for name, data in {**controller.files, "task.toml": text.encode()}.items():
        (tmp_path / name).write_bytes(data)
    assert json.loads(controller.files["omni_s1.certificate.json"])["claims"][-1]["margin"] > 0
    assert checker.main([str(tmp_path / n) for n in ("task.toml", "omni_s1.c", "omni_s1.certificate.json")]) == 0


@pytest.mark.slow
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_with_updated_hashes_a_changed_tube_is_accepted_only_if_it_is_certified(data, tmp_path) -> None:
    """The oracle evaluates the edges exactly at samples and shares no code with the checker."""
    name = data.draw(st.sampled_from(["omni_s1", "omni_s2", "spacecraft"]))
    controller = controller_of(name)
    j, i = data.draw(st.integers(0, 34)), data.draw(st.integers(0, controller.design.dimension - 1))
    side, amount = data.draw(st.integers(0, 1)), data.draw(st.integers(-(2**19), 2**19))
    bent = bend(controller, j, i, side, amount)
    certificate = certify(controller.task, bent, build_program(controller.task, bent))
    for file, content in files_claiming_success(controller.task, bent, certificate).items():
        (tmp_path / file).write_bytes(content)
    holds_at_samples = oracle(controller.task, bent, Fraction(0))
    exit_code = checker.main([str(tmp_path / f) for f in ("task.toml", f"{name}.c", f"{name}.certificate.json")])
    assert exit_code == (0 if certificate.holds else 1)
    if not all(holds_at_samples.values()):
        assert exit_code == 1


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
def test_another_time_in_ticks_is_refused(old: str, new: str, tmp_path, capsys) -> None:
    message = refusal_of_change(write_files(tmp_path, "omni_board"), "omni_board.c", old, new, capsys)
    assert "segment_at_tick of the C" in message


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
def test_another_time_scale_or_index_is_refused(old: str, new: str, tmp_path, capsys) -> None:
    assert "segment of the C" in refusal_of_change(write_files(tmp_path, "omni_s1"), "omni_s1.c", old, new, capsys)


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
def test_a_harder_task_is_refused_although_the_hashes_fit(old: str, new: str, code: str, tmp_path, capsys) -> None:
    arguments = write_files(tmp_path, "omni_s1")
    task = Path(arguments[0])
    assert old in task.read_text()
    task.write_text(task.read_text().replace(old, new))
    update_hashes(arguments)
    assert checker.main(arguments) == 1
    assert code in capsys.readouterr().out


fractions = st.fractions(min_value=-3, max_value=3, max_denominator=50)  # Bezier coefficients
local_times = st.fractions(min_value=0, max_value=1, max_denominator=20)


@given(st.lists(fractions, min_size=8, max_size=8), local_times, local_times, local_times)
def test_a_part_of_a_bezier_piece_is_the_same_curve(
    coefficients_of_edges: list[Fraction], a: Fraction, b: Fraction, s: Fraction
) -> None:
    def value_at(coefficients: list[Fraction], time: Fraction) -> Fraction:
        r = 1 - time
        return (
            r**3 * coefficients[0]
            + 3 * r * r * time * coefficients[1]
            + 3 * r * time**2 * coefficients[2]
            + time**3 * coefficients[3]
        )

    a, b = sorted((a, b))
    if b > 0:
        (part,) = checker.within([(coefficients_of_edges[:4], coefficients_of_edges[4:])], a, b)
        for side, edge in enumerate((coefficients_of_edges[:4], coefficients_of_edges[4:])):
            assert value_at(part[side], s) == value_at(edge, a + s * (b - a))


@given(st.fractions(min_value=Fraction(1000001, 1000000), max_value=10**6))
def test_the_checkers_logarithm_encloses_the_true_one_closely(y: Fraction) -> None:
    low, high = checker.logarithm(y)
    with localcontext(prec=60):
        true_logarithm = Decimal(y.numerator).ln() - Decimal(y.denominator).ln()
    assert low <= Fraction(true_logarithm) + Fraction(1, 10**40)
    assert Fraction(true_logarithm) - Fraction(1, 10**40) <= high
    assert high - low < Fraction(1, 10**16)


def test_what_the_checker_cannot_check_is_an_error_of_input(tmp_path, capsys) -> None:
    arguments = write_files(tmp_path, "omni_s1")
    folder = ROOT / "generated" / "omni_s1" / "literal" / "float"
    literal = [arguments[0], str(folder / "omni_s1.c"), str(folder / "omni_s1.certificate.json")]
    assert checker.main(literal) == 2
    assert "only those can be checked here" in capsys.readouterr().err
    assert checker.main(arguments[:2]) == 2
    assert checker.main([*arguments[:2], str(tmp_path / "none.json")]) == 2


def test_the_command_line_runs_the_same_checker(tmp_path) -> None:
    arguments = write_files(tmp_path, "omni_s1")
    command = [sys.executable, "-m", "stt_codegen.cli", "certify", *arguments]
    accepted = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (accepted.returncode, accepted.stdout[:12]) == (0, "checker: yes")
    Path(arguments[1]).write_text(Path(arguments[1]).read_text() + " ")
    assert subprocess.run(command, capture_output=True, text=True, check=False).returncode == 1


# ------------------------------------------------------------------------------------------------ integers

# Changes of the C in integers: each replaces a statement of another kind, a constant, or an entry of a table.
GANTRY = [
    ("tick < 4000U", "tick <= 4000U"),
    ("running ? tick : 4000U", "running ? 4000U : tick"),
    ("tick < 4000U", "tick < 3999U"),
    ("gantry_low(count, 65535)", "gantry_low(count, 32767)"),
    ("gantry_upper(34359738, count_low)", "gantry_upper(34359739, count_low)"),
    ("passed < 2097151;\n    const int32_t place = place_under ? passed : 2097151", "passed < 2097150;\n    const int32_t place = place_under ? passed : 2097150"),
    ("gantry_down(place, 16)", "gantry_down(place, 15)"),
    ("segment * 4", "segment * 8"),
    ("*row = first;\n    *s = share;", "*row = share;\n    *s = first;"),
    ("gantry_up(s, 12)", "gantry_up(s, 13)"),
    ("sum = s_up + square", "sum = s_up - square"),
    ("sum * 3", "sum * 2"),
    ("268435456 - less_3", "268435455 - less_3"),
    ("less_held_over ? less : 0", "less_held_over ? 0 : less"),
    ("bend_near < 65535", "bend_near < 65534"),
    ("bend_held + 8192", "bend_held + 4096"),
    ("*w0 = before;\n    *w1 = middle;\n    *w2 = after;", "*w2 = before;\n    *w1 = middle;\n    *w0 = after;"),
    ("at_1 = at + 4;", "at_1 = at + 2;"),
    ("at_q2 - at_q1", "at_q1 - at_q2"),
    ("(int32_t)(int16_t)apart_1", "apart_1"),
    ("q1_6 = at_q1 * 6", "q1_6 = at_q0 * 6"),
    ("gantry_product(d1, w1)", "gantry_product(d1, w0)"),
    ("d2_w2 - d0_w0", "d2_w2 + d0_w0"),
    ("gantry_down(outer, 15)", "gantry_down(outer, 14)"),
    ("bent + ends;\n    return value;", "bent - ends;\n    return value;"),
    ("gantry_down(bend_t, 16)", "gantry_down(bend_t, 15)"),
    ("gantry_down(down_t, 17)", "gantry_down(down_t, 16)"),
    ("left = level - fall", "left = level + fall"),
    ("GANTRY_READ_16(gantry_levels[row])", "GANTRY_READ_8(gantry_levels[row])"),
    ("GANTRY_READ_16(gantry_slopes[row])", "GANTRY_READ_16(gantry_bends[row])"),
    ("steep = gantry_upper(e, rise)", "steep = gantry_upper(e, over)"),
    ("moved < limit;\n    const int32_t push_held = push_held_under ? moved : limit;\n    return push_held;", "moved < limit;\n    const int32_t push_held = push_held_under ? moved : limit;\n    return moved;"),  # never saturated
    ("push_held_under ? moved : limit", "push_held_under ? limit : moved"),
    ("lower_edge = gantry_edge(at, w0, w1, w2);", "lower_edge = gantry_edge(at_upper, w0, w1, w2);"),
    ("lower[i] = lower_edge;", "lower[i] = upper_edge;"),
    ("x_near_over = (-268435456) < x_all", "x_near_over = (-26843545) < x_all"),
    ("x_i - lower_edge", "lower_edge - x_i"),
    ("room = x_lower + x_upper;", "room = x_lower - x_upper;"),
    ("apart = x_lower - x_upper;", "apart = x_upper - x_lower;"),
    ("131072", "262144"),  # a width that the tube may not have
    ("131072", "1"),
    ("e_width_over ? room : 131072", "e_width_over ? 131072 : room"),
    ("e_n = gantry_leading(e_width);", "e_n = gantry_leading(room);"),
    ("gantry_down(e_width_up, 26)", "gantry_down(e_width_up, 27)"),
    ("gantry_low(e_over_bits, 15)", "gantry_low(e_over_bits, 31)"),
    ("upper_nearer = 0 < apart", "upper_nearer = apart < 0"),
    ("off = upper_nearer ? apart : minus;", "off = upper_nearer ? minus : apart;"),
    ("off_held_under ? off : e_width", "off_held_under ? off : room"),
    ("e_under ? e_all : 1063134168", "e_under ? 1063134168 : e_all"),  # the clamp inverted
    ("1063134168", "1062000000"),  # which acts before e_max
    ("1063134168", "1073741823"),
    ("10736107", "11000000"),
    ("10736107", "9000000"),
    ("10736107", "0"),
    ("rest = e_width_up - off_up", "rest = off_up - e_width_up"),
    ("y_near < 1073741823", "y_near < 1073741824"),
    ("octaves = m * 8;", "octaves = m * 4;"),
    ("octave = octaves + 8;", "octave = octaves + 16;"),
    ("down_n = offset - e_n;", "down_n = offset + e_n;"),
    ("down_all = down_n - rise_places;", "down_all = down_n;"),
    ("down_over ? down_all : 0", "down_over ? 0 : down_all"),
    ("upper_nearer ? back : push;", "upper_nearer ? push : back;"),  # out of the tube
    ("u[i] = u_i;", "u[i] = push;"),
    ("within = off < room;", "within = off <= room;"),
    ("within ? outside : true", "within ? outside : false"),
    ("within ? outside : true", "within ? false : true"),
    ("outside = outside_any;", "outside = false;"),
    ("return outside ? GANTRY_OUTSIDE_TUBE : GANTRY_OK;", "return outside ? GANTRY_OK : GANTRY_OUTSIDE_TUBE;"),
    ("i < 2;", "i < 1;"),
    ("int32_t margin = 32768;", "int32_t margin = 65536;"),
    ("share_high ? x_upper : x_lower", "share_high ? x_lower : x_upper"),
    ("share_minus = (-1) - share_most;", "share_minus = 1 - share_most;"),
    ("less ? share : margin", "less ? margin : share"),
    # tables: an entry, a type, a length
    ("    3506, 34942, 3506, 34942,", "    3506, 34942, 3506, 34941,"),
    ("    61680,\n    58253,", "    61780,\n    58253,"),
    ("    61680,\n    58253,", "    61680,\n"),
    ("    7244,\n    6462,", "    7544,\n    6462,"),
    ("    392,\n    331,", "    892,\n    331,"),
    ("    1581,\n    1104,", "    -1581,\n    1104,"),
    ("    8,\n    8,\n    8,\n    7,", "    8,\n    8,\n    7,\n    7,"),
    ("    58196, 58196", "    58196, 58198"),
    ("    14, 14", "    14, 15"),
    ("    14, 14", "    13, 13"),
    ("    40265280, 40265280", "    40265280, 40265281"),
    ("    40265280, 40265280", "    80530560, 80530560"),
    ("const uint16_t gantry_levels[72]", "const int32_t gantry_levels[72]"),
    ("const uint8_t gantry_places[72]", "const uint8_t gantry_places[73]"),
    ("gantry_bends[72] GANTRY_FLASH", "gantry_bends[72]"),
    ("static const uint16_t gantry_slopes", "static uint16_t gantry_slopes"),
    # the helper functions of integer arithmetic
    ("((-3) >> 1 == -2) ? 1 : -1", "((-3) >> 1 == -2) ? 1 : 1"),
    ("return a >> n;", "return a / (1 << n);"),
    ("(n >= 16)) {", "(n >= 15)) {"),
    ("(16 - n)", "(15 - n)"),
    ("rest >>= 8;", "rest >>= 4;"),
    ("rest &= 0x7fffffffU;", "rest &= 0xffffffffU;"),
    ("(int32_t)own * (int32_t)other", "(int32_t)(own * other)"),
    ('__asm__("" : "+r"(own), "+r"(other));', '__asm__("nop" : "+r"(own), "+r"(other));'),
    ("return a * b;", "return b + a;"),
    ("((uint32_t)a & 0xffffU) * (uint32_t)b", "((uint32_t)a & 0xfffU) * (uint32_t)b"),
    ("if (rest < 0x800000U) { rest <<= 8; places += 8; }", "if (rest < 0x800000U) { rest <<= 8; places += 7; }"),
    ("(uint32_t)a & (uint32_t)mask", "(uint32_t)a | (uint32_t)mask"),
    ("#if defined(__AVR__)", "#if !defined(__AVR__)"),
    ("pgm_read_word", "pgm_read_byte"),
    ("#include <stdbool.h>", "#include <stdbool.h>\n#define outside false"),
    ("bool outside = false;", "bool outside = false;\n    if (tick == 7U) { return GANTRY_OK; }"),
    ("int32_t gantry_margin(", "int32_t gantry_more(void)\n{\n    return 0;\n}\n\nint32_t gantry_margin("),
]  # fmt: skip
CRANE = [
    ("before_second + 16384", "before_second + 8192"),
    ("43690", "43691"),
    ("less_held < 67108864", "less_held < 67108863"),
    ("before_half, 15)", "before_half, 14)"),
    ("one_less = 268435456 - s_up", "one_less = 268435456 - square"),
    ("*r0 = before;", "*r0 = after;"),
    ("crane_down(d1_r1, 11)", "crane_down(d1_r1, 12)"),
    ("d0_r0 + d2_r2", "d0_r0 - d2_r2"),
    ("*rate = slope;", "*rate = value;"),
    ("43360, 42848", "43361, 42848"),
    ("x_near_over = (-67108864) < x_all", "x_near_over = (-268435456) < x_all"),
    ("v_i - lower_rate", "v_i - lower_edge"),
    ("v_lower + lower_filtered", "v_lower - lower_filtered"),
    ("crane_upper(x_upper, filter_i)", "crane_upper(x_lower, filter_i)"),
    ("room = to_lower + to_upper", "room = x_lower + x_upper"),
    ("65536 < room", "131072 < room"),
    ("over && under", "over && over"),
    ("inside = within && between", "inside = within && within"),
    ("inside ? outside : true", "within ? outside : true"),
    ("share < place;", "place < share;"),
    ("filtered_less ? share : place", "filtered_less ? place : share"),
    ("lower_z = lower_rate + lower_filtered", "lower_z = lower_rate"),
    ("upper[i] = upper_z", "upper[i] = lower_z"),
]


@pytest.mark.parametrize(("name", "old", "new"), [*(("gantry", *pair) for pair in GANTRY), *(("crane", *pair) for pair in CRANE)])
def test_another_controller_in_integers_is_refused_although_the_hashes_fit(
    name: str, old: str, new: str, tmp_path, capsys
) -> None:
    message = refusal_of_change(write_files(tmp_path, name, "fixed"), f"{name}.c", old, new, capsys)
    assert re.match("checker: NO: .*(the C has|of the C|the C may|the table|P7|not the tube's)", message)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("GANTRY_X_BITS 20", "GANTRY_X_BITS 21"),
        ("GANTRY_U_BITS 26", "GANTRY_U_BITS 25"),
        ("GANTRY_UNITS(v, 1048576.0)", "GANTRY_UNITS(v, 1048575.0)"),
        ("GANTRY_UNITS(v, 67108864.0)", "GANTRY_UNITS(v, 33554432.0)"),
        ("? -0.5 : 0.5", "? 0.5 : 0.5"),
        ("GANTRY_TICKS UINT32_C(4000)", "GANTRY_TICKS UINT32_C(4001)"),
        ("TICKS_A_SECOND INT32_C(1000)", "TICKS_A_SECOND INT32_C(100)"),
        ("TICKS_PROVED UINT32_C(10)", "TICKS_PROVED UINT32_C(11)"),
        ("GANTRY_N 2", "GANTRY_N 3"),
        ("GANTRY_OUTSIDE_TUBE = 1", "GANTRY_OUTSIDE_TUBE = 0"),
        ('DESIGN_HASH "', 'DESIGN_HASH "0'),
        ("void gantry_tube(uint32_t tick,", "void gantry_tube(int32_t tick,"),
        ("#include <stdint.h>", "#include <stdint.h>\n#define int32_t short"),
        ("int gantry_selftest(void);", ""),
    ],
)
def test_another_header_of_a_controller_in_integers_is_refused(old: str, new: str, tmp_path, capsys) -> None:
    assert "header" in refusal_of_change(write_files(tmp_path, "gantry", "fixed"), "gantry.h", old, new, capsys)


def test_c_without_one_of_its_lines_is_refused(tmp_path) -> None:
    """Every line of code, and every tenth of the many lines of numbers. benchmarks/token_mutants.py changes single tokens."""
    arguments = write_files(tmp_path, "gantry", "fixed")
    source = Path(arguments[1])
    text = re.sub(r"/\*.*?\*/", "", source.read_text(), flags=re.DOTALL)
    lines = text.splitlines()
    code = [k for k, line in enumerate(lines) if line.strip() and not re.fullmatch(r"[-\d, ]+", line)]
    numbers = [k for k, line in enumerate(lines) if re.fullmatch(r"[-\d, ]+", line)]
    for k in (*code, *numbers[::10]):
        source.write_text("\n".join(lines[:k] + lines[k + 1 :]) + "\n")
        update_hashes(arguments)
        assert checker.main(arguments) == 1, lines[k]


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("gantry", lambda c: c["edge_error"].__setitem__(0, 3), "P7"),
        ("gantry", lambda c: c["edge_error"].__setitem__(0, 5), "P7"),
        ("crane", lambda c: c["rate_error"].__setitem__(1, 5), "P7"),
        ("crane", lambda c: c["filter"].__setitem__(0, "1356/2048"), "filter"),
        ("gantry", lambda c: c["control"].__setitem__("gain", ["112/1000", "111/1000"]), "gain of component 1"),
        ("gantry", lambda c: c["control"].__setitem__("gain", ["11101/100000", "11101/100000"]), "gain of component 1"),
        ("gantry", lambda c: c["control"].__setitem__("e_max", ["9/10", "99/100"]), "e_max"),
        ("gantry", lambda c: c["control"].__setitem__("u_max", ["3/5", "3/5"]), "u_max"),
        ("gantry", lambda c: c["sampled"].__setitem__("shift", ["1/1000", "1/1000"]), "P9"),
        ("gantry", lambda c: c.__setitem__("scalar", "float"), "directives"),
        ("gantry", lambda c: c.__setitem__("scalar", "double"), "directives"),
        ("gantry", lambda c: c["grid"].__setitem__("unit_bits", 21), "covers_initial_set"),
        ("gantry", lambda c: c["sha256"].__setitem__("gantry.py", "0"), "SHA-256"),
    ],
)
def test_a_wrong_claim_about_integers_is_refused(name: str, change: Callable, message: str, tmp_path, capsys) -> None:
    arguments = write_files(tmp_path, name, "fixed")
    proof = Path(arguments[2])
    document = json.loads(proof.read_text())
    change(document)
    proof.write_text(json.dumps(document))
    assert checker.main(arguments) == 1
    assert re.search(message, capsys.readouterr().out)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("tick_period = 0.001", "tick_period = 0.002", "other ticks"),
        ("tick_period = 0.001", "tick_period = 0.0010001", "no whole number of its ticks"),
        ("prescribed_time = 4.0", "prescribed_time = 4.001", "other ticks"),
        ("period = 0.01 ", "period = 0.02 ", "P9|header|sampled"),
        ("u_max = [0.6, 0.6]", "u_max = [0.7, 0.6]", "u_max"),
        ("u_max = [0.6, 0.6] ", "gain = 0.112\nu_max = [0.6, 0.6] ", "gain"),
        ("u_max = [0.6, 0.6] ", "e_max = 0.98\nu_max = [0.6, 0.6] ", "e_max"),
        ("u_max = [0.6, 0.6] ", "e_max = [0.98, 0.99]\nu_max = [0.6, 0.6] ", "no controller in integers"),
        ("u_max = [0.6, 0.6] ", 'outside = "stop"\nu_max = [0.6, 0.6] ', "no controller in integers"),
        ('scalar = "fixed" ', 'math = "inline"\nscalar = "fixed" ', "no controller in integers"),
        ("w_max = 0.02", "w_max = 0.3", "header"),
    ],
)
def test_the_integers_of_another_task_are_refused(old: str, new: str, message: str, tmp_path, capsys) -> None:
    assert re.search(message, refusal_of_change(write_files(tmp_path, "gantry", "fixed"), "task.toml", old, new, capsys))


@pytest.mark.parametrize(("task", "stride"), [("gantry", 90), ("crane", 120)])
def test_changed_tokens_of_integers_are_refused_unless_they_mean_the_same(task: str, stride: int) -> None:
    for mutant in token_mutants.token_mutants(task, stride):
        if token_mutants.is_accepted(token_mutants.changed_files(mutant, task), task):
            assert token_mutants.reason_for_same_meaning(mutant, task), mutant


def integers_of(name: str, tmp_path: Path) -> tuple[checker.Task, checker.Integers, checker.Tube]:
    """Return the files of an example task in integers as the checker reads them."""
    arguments = write_files(tmp_path, name, "fixed")
    task = checker.Task(Path(arguments[0]).read_bytes())
    source = checker.Integers(Path(arguments[1]).read_bytes(), task)
    tube = checker.Tube(source, task, json.loads(Path(arguments[2]).read_text())["grid"]["unit_bits"])
    source.clock(task, tube)
    return task, source, tube


@pytest.mark.parametrize("name", ["gantry", "crane"])
def test_checker_and_tool_have_the_same_error_in_integers(name: str, tmp_path) -> None:
    """The checker reads the C, the tool its Program."""
    task, source, tube = integers_of(name, tmp_path)
    certificate = controller_of(name, "fixed").certificate
    assert source.moved(tube, 0) == list(certificate.edge_error)
    assert source.moved(tube, 1) == list(certificate.rate_error) if task.order == 2 else not certificate.rate_error


def test_the_checkers_errors_of_the_table_of_curves_are_true_and_close(tmp_path) -> None:
    """Every value that a row of the table gives, at both ends of the interval that it stands for, against 1/d and H in doubles."""
    _, source, _ = integers_of("gantry", tmp_path)
    over, rise, base = source.curves()
    t, places = np.arange(1 << 16), [int(v) for v in source.tables["places"]]
    for row in range(len(places)):
        level, slope, curved = (int(source.tables[k][row]) for k in ("levels", "slopes", "bends"))
        value = level - ((slope - (curved * t >> 16)) * t >> 17)
        octave, head = divmod(row - 16, 8)
        for offset in (0.0, 1.0 - 2.0**-14):
            if row < 16:
                error, bound = value * (16 + row + (t + offset) / 2**16) / 2**20 - 1, over
            else:
                e = 1 - (8 + head + (t + offset) / 2**16) / 2 ** (4 + octave)
                error, bound = value * 2.0 ** (places[row] - base) * e * (1 - e * e) / (8 * np.arctanh(e)) - 1, rise[row - 16][0]
            assert np.abs(error).max() <= bound * (1 + 1e-9)
            assert np.abs(error).max() >= bound / 3  # the bound is not far above the error


def test_the_checkers_ranges_bound_u_by_its_limit_and_refuse_what_may_overflow(tmp_path) -> None:
    _, source, _ = integers_of("gantry", tmp_path)
    any_tick = {"tick": (0, (1 << 32) - 1)}
    source.body("control", dict(any_tick))
    ranges_of_push = [results[0] for key, results in source.seen.items() if key[0] == "push"]
    assert ranges_of_push == [(0, int(max(source.tables["limits"])))]
    for name, value in (
        ("coefficients", 1 << 29),
        ("levels", 100),
        ("levels", 65536),
        ("bends", 1 << 15),
        ("offsets", 60),
        ("gains", 1 << 16),
    ):
        original = list(source.tables[name])
        source.tables[name][-1] = Fraction(value)
        source.seen.clear()
        with pytest.raises(checker.Failed, match="beyond 32 bits|which it is not for|values beyond 65535"):
            source.body("control", dict(any_tick))
        source.tables[name] = original


@pytest.mark.parametrize("name", ["gantry", "crane"])
def test_the_checkers_statements_compute_what_the_emitted_python_does(name: str, tmp_path) -> None:
    """The checker computes every kernel with ranges of one number each, so its ranges are about the statements that run."""
    task, source, tube = integers_of(name, tmp_path)
    module = loaded(controller_of(name, "fixed").files[f"{name}.py"].decode())
    draw, row_count = Random("listings"), len(source.tables["levels"])

    def run_in_checker(kernel: str, *inputs: int) -> tuple[int, ...]:
        results = source.body(kernel, dict(zip(source.params[kernel], ((v, v) for v in inputs), strict=True)))
        assert all(low == high for low, high in results)
        return tuple(low for low, _ in results)

    for _ in range(200):
        tick, s, t = draw.choice((draw.randrange(5000), 2**32 - 1)), draw.randrange(1 << 16), draw.randrange(1 << 16)
        weights = [
            v[s] for kernel in ("weights", "rates")[: task.order] for v in checker.every(kernel, tuple(source.listings[kernel]))
        ]
        at, row = draw.randrange(tube.segments * 2 * task.n), draw.randrange(row_count)
        push = [draw.randrange(1 << 30), *(draw.randrange(1 << 15, 1 << 16) for _ in range(3)), draw.randrange(20), 1 << 25]
        for kernel, values in (("segment", [tick]), ("edge", [at, *weights]), ("curve", [row, t]), ("push", push)):
            emitted = getattr(module, f"_{kernel}")(*values)
            assert run_in_checker(kernel, *values) == (emitted if isinstance(emitted, tuple) else (emitted,))
        assert [w for kernel in ("weights", "rates")[: task.order] for w in getattr(module, f"_{kernel}")(s)] == weights
