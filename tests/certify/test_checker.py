"""The stand-alone checker: it verifies what is recorded, and refuses C and headers that are changed.

The tables of changes are texts of emitted C: (text that occurs in the file, its replacement). `$` stands for the task's name. Claims and
tasks are changed in test_checker_claims.py; controllers in integers have test_checker_integers.py. benchmarks/token_mutants.py changes
every token."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import token_mutants
from stt_codegen.checker.stt_checker.task import Task
from stt_codegen.task import parse_task
from tests.support.checked_files import (
    REFUSED,
    VERIFIED,
    Files,
    recorded_files,
    verdict,
    with_hashes,
    with_text,
    write_files,
)
from tests.support.controllers import NAMES, ROOT, build_once, controller_of

RECORDED = sorted(path.parent.relative_to(ROOT).parts for path in ROOT.glob("generated/*/refined/*/*.certificate.json"))


def refused_files(files: Files, folder: Path) -> str:
    """Return the message with which the checker refuses these files."""
    code, message = verdict(files, folder)
    assert code == REFUSED, message
    return message


def filled(text: str, task: str, source: Path) -> str:
    """Return the text with the task's name for `$`, and the C's own gain and coefficient for the names in <..>."""
    content = source.read_text()
    table = re.search(r"_gain\[\d+\] = \{([^}]*)\}", content)
    gains = re.findall(r"[\d.e-]+F", table[1]) if table else []
    last = re.search(r"(\S+)\n\};", content)[1]
    return text.replace("$", task).replace("<first gain>", *gains[:1] or [""]).replace("<last coefficient>", last)


def changed(task: str, old: str, new: str) -> Files:
    """Return the recorded files of a task with a change of its C, in which `$` and names in <..> are filled."""
    source = ROOT / "generated" / task / "refined" / "float" / f"{task}.c"
    return with_text(recorded_files(task), f"{task}.c", *(filled(text, task, source) for text in (old, new)))


# ------------------------------------------------------------------------------------------------ what is verified


@pytest.mark.parametrize(("_root", "name", "_design", "scalar"), RECORDED)
def test_every_recorded_controller_is_verified(_root: str, name: str, _design: str, scalar: str, tmp_path: Path) -> None:
    """With all that its task emits."""
    code, message = verdict(recorded_files(name, scalar), tmp_path)
    assert (code, message.startswith(f"checker: verified: {name}: P1 to P")) == (VERIFIED, True), message


def test_the_command_line_runs_the_same_checker(tmp_path: Path) -> None:
    arguments = write_files(recorded_files("omni_s1"), tmp_path)
    command = [sys.executable, "-m", "stt_codegen.cli", "certify", *arguments]
    accepted = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (accepted.returncode, accepted.stdout[:17]) == (VERIFIED, "checker: verified")
    Path(arguments[1]).write_text(Path(arguments[1]).read_text() + " ")
    assert subprocess.run(command, capture_output=True, text=True, check=False).returncode == REFUSED


def test_checker_and_tool_compute_the_same_digest_of_a_task() -> None:
    for name in NAMES:
        data = (ROOT / "tasks" / f"{name}.toml").read_bytes()
        assert Task(data).digest == controller_of(name).task.digest


@pytest.mark.parametrize("name", ["M_x", "P_x", "M", "P"])
def test_a_task_may_be_named_like_the_listings_own_names(name: str, tmp_path: Path) -> None:
    """The listing has P_ for the task's name, and M_ for the same in capitals."""
    text = (ROOT / "tasks" / "empty.toml").read_text().replace('name = "empty"', f'name = "{name}"')
    files = {**build_once(parse_task(text)).files, "task.toml": text.encode()}
    assert verdict(files, tmp_path).code == VERIFIED


def test_comments_spaces_and_spelling_of_numbers_are_free(tmp_path: Path) -> None:
    """Nothing else is: names, order and types are the listing's."""
    files = recorded_files("trolley")
    text = files["trolley.c"].decode()
    for old, new in (
        ("    0.0384F, 0.0252F\n", "    3.84e-2F, 0.02520000000F\n"),
        ("= 1.0F - s;", "=1.0F\n  -s ;"),
        ("const int32_t at_1", "/* for (;;) \" // ' */ const /*/**/ int32_t at_1"),
        ("#include <math.h>", "#include /* <string.h> */ <math.h>  /* */"),
    ):
        assert old in text
        text = text.replace(old, new)
    assert verdict(with_hashes({**files, "trolley.c": text.encode()}), tmp_path).code == VERIFIED


# ------------------------------------------------------------------------------------------------ changed C

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
    ("u[i] = u_limited;", "u[i] = 0.0F;"),
    ("outside_next = inside ? outside : true", "outside_next = inside ? false : true"),
    ("outside_next = inside ? outside : true", "outside_next = inside ? outside : false"),
    ("margin_next = less ? margin_x : margin", "margin_next = less ? margin : margin_x"),
    ("const int32_t upper_at = lower_at + 1;", "const int32_t upper_at = lower_at + 14;"),
    ("for (int32_t i = 0; i < 2; ++i) {", "for (int32_t i = 0; i < 1; ++i) {"),
    ("logf(v0)", "log1pf(v0)"),
    ("return TROLLEY_BAD_INPUT;", "return TROLLEY_OK;"),
    ("zero = zeros;", "zero = x_zero;"),
    ("const bool finite = zero <= 0.0F;", "const bool finite = 0.0F <= zero;"),
]


@pytest.mark.parametrize(("old", "new"), CHANGED_MEANINGS)
def test_c_of_another_meaning_is_refused_although_the_hashes_fit(old: str, new: str, tmp_path: Path) -> None:
    assert_is_not_the_listing(changed("trolley", old, new), tmp_path)


def assert_is_not_the_listing(files: Files, folder: Path) -> None:
    """The checker refuses the files, and says that a C file or a header is not the listing with these numbers."""
    message = refused_files(files, folder)
    assert re.match(
        r"checker: refused: (\w+\.[ch] has '.*' in line \d+ where the listing has |a C file has |the C has |the C's table )",
        message,
    ), message


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
        "lower_at = row + pair;",
        "huge = row * 2000000000;\n        const int32_t none = huge - huge;\n        const int32_t near_at = row + none;\n        const int32_t lower_at = near_at + pair;",
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
    ("trolley", "const $_real width = ", "const $_real volatile = upper_edge - lower_edge;\n        const $_real width = "),
    (
        "trolley",
        "<last coefficient>\n};",
        "<last coefficient>\n}",
    ),
    ("trolley", "const $_real v0 = k * xi;", "const $_real v0 = $_law(k, xi, epsilon);"),
    ("trolley", "{\n    const bool finite = isfinite(t) != 0;", "{" * 3000 + "\n    const bool finite = isfinite(t) != 0;"),
    (
        "trolley",
        "const bool wide = 9.536743e-7F < width;",
        "const bool wide = 9.536743e-7F < width;\n        const bool wider = 1.0F < width;",
    ),
]


@pytest.mark.parametrize(("task", "old", "new"), SUBTLE_CHANGES)
def test_a_change_that_a_careless_reader_would_miss_is_refused(task: str, old: str, new: str, tmp_path: Path) -> None:
    assert_is_not_the_listing(changed(task, old, new), tmp_path)


# Changes of trolley's C that are equal in exact arithmetic, and not in floats.
REORDERED_SUMS = [
    (
        "to_farther = width - to_nearer;",
        "wide = width + 1.0e9F;\n        const $_real less = wide - to_nearer;\n        const $_real to_farther = less - 1.0e9F;",
    ),
    ("to_upper = upper_edge - x_i;", "to_upper = width - to_lower;"),
    (
        "width = upper_edge - lower_edge;",
        "to_low = x_i - lower_edge;\n        const $_real to_up = upper_edge - x_i;\n        const $_real width = to_low + to_up;",
    ),
]


@pytest.mark.parametrize(("old", "new"), REORDERED_SUMS)
def test_an_equal_formula_that_rounds_differently_is_refused(old: str, new: str, tmp_path: Path) -> None:
    """In floats the changed formula loses the distance to the nearer edge."""
    assert_is_not_the_listing(changed("trolley", old, new), tmp_path)


# Changes of time: of the segment of t in omni_s1, of the segment of a tick in omni_board.
CHANGED_TIMES = [
    ("omni_s1", "started * 3.5555556F", "started * 3.6555556F"),
    ("omni_s1", "started * 3.5555556F", "t * 3.5555556F"),
    ("omni_s1", "segment = (int32_t)u", "segment = (int32_t)scaled"),
    ("omni_s1", "segment * 4", "segment * 2"),
    ("omni_s1", "scaled < 31.999998F", "scaled < 33.0F"),
    ("omni_s1", "scaled < 31.999998F", "scaled < 31.0F"),
    ("omni_s1", "scaled : 31.999998F", "scaled : 32.0F"),
    ("omni_board", "count * 4", "count * 8"),
    ("omni_board", "whole : 31", "whole : 3100"),
    ("omni_board", "part / 1125.0F", "part / 100.0F"),
    ("omni_board", "tick < 9000U", "tick < 900U"),
    ("omni_board", "place / 1125", "place / 1124"),
]


@pytest.mark.parametrize(("task", "old", "new"), CHANGED_TIMES)
def test_another_time_scale_or_index_is_refused(task: str, old: str, new: str, tmp_path: Path) -> None:
    assert_is_not_the_listing(changed(task, old, new), tmp_path)


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
def test_a_changed_header_is_refused(old: str, new: str, tmp_path: Path) -> None:
    assert_is_not_the_listing(with_text(recorded_files("trolley"), "trolley.h", old, new), tmp_path)


def test_a_store_before_the_load_of_another_loop_is_refused(tmp_path: Path) -> None:
    """u may be the array x itself: with two loops the second would read what the first has written."""
    store = "        u[i] = u_limited;\n        outside = outside_next;\n    }\n"
    loop = "    for (int32_t k = 0; k < 2; ++k) {\n        const trolley_real x_k = x[k];\n    }\n"
    assert_is_not_the_listing(changed("trolley", store, store + loop), tmp_path)


def test_kernels_that_agree_only_for_what_they_assume_are_refused(tmp_path: Path) -> None:
    """The case that the old checker verified: `basis` hands on weights that its callers never check, `control` passes the measured
    state for one of them, and the sum adds a^16 to it and takes a^16 away: equal in fractions, and NaN or nonsense in floats."""
    files = recorded_files("omni_s1")
    text = files["omni_s1.c"].decode()
    powers = "".join(f"    const omni_s1_real a{2 * k} = a{k} * a{k};\n" for k in (1, 2, 4, 8))
    control = text.index("omni_s1_status omni_s1_control(")
    changes = (
        (
            "    *w0 = v2;\n    *w1 = v7;\n    *w2 = v9;\n    *w3 = v11;",
            "    *w0 = s;\n    *w1 = 1.0F;\n    *w2 = s;\n    *w3 = s;",
        ),
        (
            "    return v6;",
            f"    const omni_s1_real a1 = w2;\n{powers}    const omni_s1_real v7 = v6 + a16;\n    const omni_s1_real v8 = v7 - a16;\n    return v8;",
        ),
    )
    call = "omni_s1_edge_at(lower_at, w0, w1, w2, w3)"
    for number in range(3):
        attacked = text[:control] + text[control:].replace(call, call.replace("w2", "x_i"))
        for old, new in changes[:number]:
            assert old in attacked
            attacked = attacked.replace(old, new)
        assert_is_not_the_listing(with_hashes({**files, "omni_s1.c": attacked.encode()}), tmp_path)


@pytest.mark.parametrize(("name", "step"), [("trolley", 20), ("omni_board", 20), ("watchman", 30), ("drone", 80)])
def test_c_and_header_without_one_of_their_lines_are_refused(name: str, step: int, tmp_path: Path) -> None:
    """Some of the lines of code, and a hundredth of the many lines of numbers. benchmarks/token_mutants.py changes single tokens."""
    files = recorded_files(name)
    for file in (f"{name}.c", f"{name}.h"):
        lines = re.sub(r"/\*.*?\*/", "", files[file].decode(), flags=re.DOTALL).splitlines()
        code = [k for k, line in enumerate(lines) if line.strip() and not re.fullmatch(r"[-\d., eF]+", line)]
        numbers = [k for k, line in enumerate(lines) if line.strip() and k not in set(code)]
        for k in (*code[:: 5 if file.endswith(".h") else step], *numbers[::100]):
            without = "\n".join(lines[:k] + lines[k + 1 :]) + "\n"
            assert verdict(with_hashes({**files, file: without.encode()}), tmp_path).code == REFUSED, lines[k]


def test_changed_tokens_and_claims_are_refused_unless_they_mean_the_same() -> None:
    """A sample of changed tokens of C, and of changed claims; benchmarks/token_mutants.py checks all."""
    for task, stride in (("trolley", 240), ("omni_board", 288), ("drone", 500), ("watchman", 400)):
        for mutant in token_mutants.token_mutants(task, stride):
            if token_mutants.is_accepted(token_mutants.changed_files(mutant, task), task):
                assert token_mutants.reason_for_same_meaning(mutant, task), mutant
    for label in token_mutants.accepted_claims("trolley", 8):
        assert token_mutants.reason_for_true_claim(label), label


@pytest.mark.parametrize(
    ("label", "may_be_true"),
    [
        ("claims.3 P4.margin: 30 to 29", True), ("claims.3 P4.margin: 30 to 31", False), ("claims.3 P4.margin: left out", False),
        ("edge_error.0: 6 to 7", True), ("edge_error.0: 6 to 5", False), ("mission.time_margin: 2 to 1000002", True),
        ("sampled.u.0: 3/2 to 5/2", True), ("sampled.u.0: 3/2 to 1/2", False), ("sampled.rho: left out", False),
        ("sampled.shift.0: 1000001/1000000000000 to 1000001/1000000000001", True),
        ("claims.9 P10.on.1: 64 to 63", True), ("claims.9 P10.on.1: 64 to 1000064", False), ("claims.9 P10: left out", True),
        ("claims.3 P4: left out", False), ("control.gain.0: 1/2 to 1/3", False), ("sha256.trolley.c: left out", False),
    ],
)  # fmt: skip
def test_only_a_weaker_claim_may_be_accepted(label: str, may_be_true: bool) -> None:
    assert bool(token_mutants.reason_for_true_claim(label)) == may_be_true
