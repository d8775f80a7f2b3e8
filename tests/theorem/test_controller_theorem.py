"""Coq reads the texts of task, header and C by itself, proves the theorem about shipped controllers, and refuses changed texts.

A theorem is one Coq file with these three texts in it. A changed text must make a lemma of the file fail that the test names.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import pytest

from stt_codegen.errors import BadInput
from stt_codegen.theorem import coq
from stt_codegen.theorem.controller_theorem import controller_theorem_text, coq_string
from stt_codegen.theorem.text import theorem_text
from tests.certify.test_checker import CHANGED_HEADERS, CHANGED_MEANINGS, REORDERED_SUMS, SUBTLE_CHANGES, filled
from tests.support.command_line import run_command
from tests.support.controllers import ROOT

pytestmark = [pytest.mark.xdist_group("coq"), pytest.mark.slow]

LOGF_DEFINITION = "omni_s1_real logf(omni_s1_real x)\n{\n    const omni_s1_real y = -x;\n    return y;\n}\n\n"
HALL_TASK = """name = "hall"
axes = ["x", "y", "height"]
prescribed_time = 12.0
initial_state = [0.5, 0.5, 1.0]
body = [0.1, 0.1, 0.05]

[state_space]
lower = [0.0, 0.0, 0.0]
upper = [5.0, 5.0, 2.0]
axes = ["x", "y"]
normals = [[1, 0.75], [-1, -2]]
offsets = [8.5, -0.5]

[initial_set]
lower = [0.3, 0.3, 0.8]
upper = [0.7, 0.7, 1.2]

[target_set]
lower = [4.2, 4.2, 0.8]
upper = [4.8, 4.8, 1.2]
normals = [[1, 1, 0.5]]
offsets = [9.9]

[[unsafe]]
name = "beam"
segment = [[0.0, 2.0, 1.0], [2.5, 2.2, 1.1]]
radius = 0.2

[[unsafe]]
name = "pillar"
centre = [2.0, 3.5] # in the order of its own axes
radius = 0.3
axes = ["y", "x"]

[[unsafe]]
name = "ramp"
axes = ["y", "height"]
normals = [[1, 1], [-1.0, 0.5], [0, -1]]
offsets = [4.0, -2.9, -0.1]

[[unsafe]]
name = "shelf"
axes = ["height"]
lower = [1.7]
upper = [1.9]

[[unsafe]]
name = "rock"
vertices = [
    [1.0, 3.5, 0.0], [2.0, 3.5, 0.0],
    [1.5, 4.5, 0.0], [1.5, 3.9, 0.9],
]
"""


class TextMutant(NamedTuple):
    """A change of a controller's theorem: `new` replaces `old`. failing_lemma: the lemma that Coq must refuse."""

    controller: str
    old: str
    new: str
    failing_lemma: str


HALL_CHANGES = (  # of the theorem about HALL_TASK: a text, its replacement everywhere, and the lemma that must fail
    ("([0; 1; 1]%Z, [(1 # 1)", "([0; 1; 1]%Z, [(-1 # 1)", "tube_checked"),
    ("[4.0, -2.9, -0.1]", "[4.1, -2.9, -0.1]", "task_read"),
    ('axes = [""y"", ""x""]', 'axes = [""x"", ""y""]', "task_read"),
    ('axes = [""height""]', 'axes = [""z""]', "task_read"),
    ("offsets = [8.5, -0.5]", "offsets = [8.4, -0.5]", "task_read"),
    ("(333 # 40)", "(293 # 40)", "task_read"),
    ("(99 # 10)", "(96 # 10)", "task_read"),
)

MUTANTS = (  # the fields of a TextMutant, which replaces the first occurrence only
    ("omni_s1", "u - base", "base - u", "text_read"),
    ("omni_s1", "logf(v0)", "logf(v3)", "text_read"),
    ("omni_s1", "(-0.5F) : 0.5F", "0.5F : (-0.5F)", "constants_checked"),
    ("omni_s1", "0.23894978F", "0.23894979F", "tube_checked"),
    ("omni_s1", "#include <math.h>", "#include <tgmath.h>", "text_read"),
    ("omni_s1", "0.5F;", "0.5;", "text_read"),
    ("omni_s1", "typedef float", "typedef double", "header_read"),
    # What C does before it reads tokens: comments to the end of a line, spliced lines, trigraphs. And split operators.
    ("omni_s1", "b / a;", "b //**/ a; /*\n    + a; /* */", "text_read"),
    ("omni_s1", "v1 = logf(v0);", "v1 = /* *\\\n/ -v0; /* */ logf(v0);", "text_read"),
    ("omni_s1", "v1 = logf(v0);", "v1 = logf(v0); /* ??/ */", "text_read"),
    ("omni_s1", "j < 2; ++j", "j < 2; + +j", "text_read"),
    # A directive, a function with the name of a macro or of the library, and a header that defines other sizes or names.
    ("omni_s1", "static inline omni_s1_real omni_s1_law(", "#define k 1\nstatic inline omni_s1_real omni_s1_law(", "text_read"),
    ("omni_s1", "static inline omni_s1_real omni_s1_law(", "static inline omni_s1_real OMNI_S1_law(", "text_read"),
    (
        "omni_s1",
        "static inline omni_s1_real omni_s1_law(",
        f"{LOGF_DEFINITION}static inline omni_s1_real omni_s1_law(",
        "text_read",
    ),
    ("omni_s1", "#define OMNI_S1_N 2", "#define OMNI_S1_N 1", "header_read"),
    ("omni_s1", "#define OMNI_S1_N 2", "#define OMNI_S1_N 2 /*/", "header_read"),
    ("omni_s1", "} omni_s1_status;", "} omni_s1_status; /* *\\\n/\n#define OMNI_S1_OUTSIDE_TUBE OMNI_S1_OK /* */", "header_read"),
    ("omni_s1", "upper = [2.0, 5.0]", "upper = [2.1, 5.0]", "task_read"),
    ("omni_s1", "the_error : Q := (1 # 131072)", "the_error : Q := (1 # 1048576)", "rounding_checked"),
    # Operators that a comment splits, and a size with a side effect.
    ("omni_s1", "j < 2; ++j", "j < 2; +/**/+j", "text_read"),
    ("omni_s1", "j < 2; ++j", "j < 2; + /* */ +j", "text_read"),
    ("omni_s1", "#define OMNI_S1_N 2", "#define OMNI_S1_N 2 + (int)(t = 0)", "header_read"),
    ("omni_s1", "#define OMNI_S1_N 2", "#define OMNI_S1_N 2 /* two */", "header_read"),
    # After a directive that ends with a sign, and after the mark of a directive that is within a comment.
    ("omni_s1", "j < 2; ++j", "j < 2; + /*\n# */ +j", "text_read"),
    ("omni_s1", "j < 2; ++j", "j < 2; /*\n# */ + +j", "text_read"),
    ("omni_s1", "#include <stdint.h>\n", "#include <stdint.h>\n+ /* */\n", "text_read"),
    # What compilers are asked and warned of.
    ("omni_s1", "FP_CONTRACT OFF", "FP_CONTRACT ON", "text_read"),
    ("omni_s1", '""fp-contract=off""', '""fp-contract=fast""', "text_read"),
    ("omni_s1", "#if defined(__ASSOCIATIVE_MATH__)", "#if 0 && defined(__ASSOCIATIVE_MATH__)", "text_read"),
    # An edge: the entries that it is made of, and where they stand in the table.
    ("omni_s1", "at_1 = at + 4", "at_1 = at + 5", "text_read"),
    ("omni_s1", "at_3 = at + 12", "at_3 = at_2 + 4", "text_read"),
    ("omni_s1", "q2 = omni_s1_coefficients[at_2]", "q2 = omni_s1_coefficients[at_1]", "text_read"),
    ("trolley", "q0 = trolley_coefficients[at]", "q0 = trolley_gain[at]", "text_read"),
    ("omni_s1", "v2 = v0 + v1", "v2 = v1 + v0", "text_read"),
    ("omni_s1", "upper_at = lower_at + 1", "upper_at = lower_at + 3", "text_read"),
    ("omni_s1", "omni_s1_edge_at(lower_at, w0", "omni_s1_edge_at(upper_at, w0", "text_read"),
    ("omni_s1", "omni_s1_edge_at(lower_at, w0, w1", "omni_s1_edge_at(lower_at, w1, w0", "text_read"),
    ("omni_s1", "u[m] = 0.0F", "u[m] = 1.0F", "text_read"),
    # Limits, sampling conditions and plant bounds in the task.
    ("trolley", "u_max = [2.0, 2.0]", "u_max = [2.0, 1.99]", "limits_checked"),
    ("trolley", "u_max = [2.0, 2.0]", "# u_max", "limits_checked"),
    ("trolley", "period = 0.02 ", "period = 0.021 ", "conditions_read"),
    ("trolley", "latency = 0.002", "latency = 0.0021", "conditions_read"),
    ("trolley", "share = 0.9 ", "share = 0.91 ", "conditions_read"),
    ("trolley", "f_max = 0.05", "f_max = 0.051", "conditions_read"),
    ("trolley", "w_max = 0.1\n", "w_max = [0.1, 0.11]\n", "conditions_read"),
    ("trolley", "g_min = 0.9\n", "", "conditions_read"),
    ("trolley", "g_max = 1.1", "g_max = 1.2", "conditions_read"),
    ("trolley", "g_cross = 0.05", "g_cross = 0.06", "conditions_read"),
    ("trolley", "noise = 0.002", "noise = 0.003", "conditions_read"),
    ("trolley", "the_shifts : list Q := [(", "the_shifts : list Q := [(1 # 1000); (", "sensors_checked"),
    ("trolley", "the_rhos : list Q := [(", "the_rhos : list Q := [(9 # 1); (", "period_checked"),
    # One gain for each component: their table, and the statements that read it.
    ("trolley", "0.0384F, 0.0252F", "0.001F, 0.0252F", "period_checked"),
    ("trolley", "0.0384F, 0.0252F", "-0.0384F, 0.0252F", "constants_checked"),
    ("trolley", "trolley_gain[2] = {\n    0.0384F, 0.0252F", "trolley_gain[1] = {\n    0.0384F", "constants_checked"),
    ("trolley", "= trolley_gain[i]", "= trolley_u_max[i]", "text_read"),
    ("trolley", "= trolley_gain[i]", "= trolley_gain[lower_at]", "text_read"),
    ("trolley", "= -gain_i", "= gain_i", "text_read"),
    ("trolley", "upper_nearer ? gain_minus : gain_i", "upper_nearer ? gain_i : gain_minus", "text_read"),
    # Limits: the table, and the statements that clamp u to them.
    ("trolley", "2.0F, 2.0F", "0.3F, 2.0F", "period_checked"),
    ("trolley", "2.0F, 2.0F", "2.0F, -2.0F", "constants_checked"),
    ("trolley", "trolley_u_max[2] = {\n    2.0F, 2.0F", "trolley_u_max[1] = {\n    2.0F", "constants_checked"),
    ("trolley", "= trolley_u_max[i]", "= trolley_gain[i]", "text_read"),
    ("trolley", "= -u_limit", "= u_limit", "text_read"),
    ("trolley", "u_min < u_i", "u_i < u_min", "text_read"),
    ("trolley", "u_above ? u_i : u_min", "u_above ? u_min : u_i", "text_read"),
    ("trolley", "u_limit < u_raised", "u_raised < u_limit", "text_read"),
    ("trolley", "u_beyond ? u_limit : u_raised", "u_beyond ? u_raised : u_limit", "text_read"),
    ("trolley", "u[i] = u_limited;", "u[i] = u_i;", "text_read"),
    ("trolley", "u[i] = u_limited;", "u[i] = u_raised;", "text_read"),
    # Sets that are no boxes: their text in the task, the values that Coq reads, and the separating normals. Any normals that
    # separate set and tube are accepted; these changed ones do not.
    ("rover", "radius = 0.5", "radius = 0.501", "task_read"),
    ("rover", "[4.6, 2.8]", "[4.6, 2.79]", "task_read"),
    ("rover", "centre = [2.6, 1.2]", 'axes = [""y"", ""x""]\ncentre = [2.6, 1.2]', "task_read"),
    ("rover", "radius = 0.5", "radius = 0.5\nmotion = 1", "task_read"),
    ("rover", "[0; 1]%nat (1 # 2)", "[0; 1]%nat (1 # 4)", "task_read"),
    ("rover", "[0; 1]%nat (1 # 2)", "[0]%nat (1 # 2)", "task_read"),
    ("rover", "[(-1); (-5)]%Z", "[0; 0]%Z", "tube_checked"),
    ("rover", "[(-1); (-5)]%Z", "[1; 5]%Z", "tube_checked"),
    ("rover", "[(-1); (-5)]%Z", "[]%Z", "tube_checked"),
    # The inline logarithm: the bits of a float, and the statements.
    ("omni_board", "real) == 4U", "real) == 8U", "text_read"),
    ("omni_board", ">> 23", ">> 22", "text_read"),
    ("omni_board", ">> 23", "> > 23", "text_read"),
    ("omni_board", ">> 23", "<< 23", "text_read"),
    ("omni_board", "0x7fffffU", "0x3fffffU", "text_read"),
    ("omni_board", "return (int32_t)((bits - 0x3f3504f3U)", "return (int32_t)((bits - 0x3f3504f2U)", "text_read"),
    ("omni_board", "bits = ((bits - 0x3f3504f3U)", "bits = ((bits - 0x3f3504f2U)", "text_read"),
    ("omni_board", "+ 0x3f3504f3U", "+ 0x3f3504f2U", "text_read"),
    ("omni_board", "uint32_t bits", "uint64_t bits", "text_read"),
    ("omni_board", "memcpy(&bits, &y, sizeof bits)", "memcpy(&y, &bits, sizeof bits)", "text_read"),
    ("omni_board", "memcpy(&m, &bits, sizeof m)", "memcpy(&m, &y, sizeof m)", "text_read"),
    ("omni_board", "sizeof m)", "sizeof y)", "text_read"),
    ("omni_board", "return m;", "return y;", "text_read"),
    ("omni_board", "#include <string.h>", "#include <strings.h>", "text_read"),
    ("omni_board", "exponent = omni_board_exponent(v0)", "exponent = omni_board_mantissa(v0)", "text_read"),
    ("omni_board", "mantissa = omni_board_mantissa(v0)", "mantissa = omni_board_exponent(v0)", "text_read"),
    ("omni_board", "mantissa = omni_board_mantissa(v0)", "mantissa = omni_board_mantissa(a)", "text_read"),
    ("omni_board", "mantissa - 1.0F", "mantissa + 1.0F", "text_read"),
    ("omni_board", "mantissa + 1.0F", "mantissa - 1.0F", "text_read"),
    ("omni_board", "below / above", "above / below", "text_read"),
    ("omni_board", "0.6766044F", "0.6766045F", "text_read"),
    ("omni_board", "bent + 2.0F", "bent + 2.1F", "text_read"),
    ("omni_board", "s * around", "z * around", "text_read"),
    ("omni_board", "0.6931472F", "0.6931473F", "text_read"),
    ("omni_board", "whole + part", "whole - part", "text_read"),
    # The segment's index must be signed, and time in seconds must not be confused with a count of ticks.
    ("omni_board", "int32_t segment = (int32_t)u", "uint32_t segment = (uint32_t)u", "text_read"),
    ("omni_board", "segment * 4;", "segment * 4U;", "text_read"),
    ("omni_board", "omni_board_segment(t, &row, &s)", "omni_board_segment_at_tick(t, &row, &s)", "text_read"),
    ("omni_board", "omni_board_segment_at_tick(tick, &row, &s)", "omni_board_segment(tick, &row, &s)", "text_read"),
    # The tick's segment and its place s in it: four units a tick, 1125 units a segment, and the end at 9000 ticks. Then the header.
    ("omni_board", "running = tick < 9000U", "running = tick < 8999U", "text_read"),
    ("omni_board", "running ? tick : 9000U", "running ? tick : 8999U", "text_read"),
    ("omni_board", "running ? tick : 9000U", "running ? 9000U : tick", "text_read"),
    ("omni_board", "tick < 9000U", "tick < 9000", "text_read"),
    ("omni_board", "count * 4", "count * 3", "ticks_checked"),
    ("omni_board", "passed < 36000", "passed < 35999", "text_read"),
    ("omni_board", "early ? passed : 36000", "early ? 36000 : passed", "text_read"),
    ("omni_board", "place / 1125", "place / 1124", "text_read"),
    ("omni_board", "whole < 31", "whole < 30", "text_read"),
    ("omni_board", "before_last ? whole : 31", "before_last ? whole : 30", "text_read"),
    ("omni_board", "segment * 1125", "segment * 1124", "text_read"),
    ("omni_board", "place - base;\n    const omni_board_real part", "base - place;\n    const omni_board_real part", "text_read"),
    ("omni_board", "part / 1125.0F", "part / 1124.0F", "ticks_checked"),
    ("omni_board", "tick_period = 0.001", "tick_period = 0.002", "tick_period_read"),
    ("omni_board", "the_tick_period : Q := (1 # 1000)", "the_tick_period : Q := (1 # 500)", "tick_period_read"),
    ("omni_board", "#include <stdint.h>", "#include <tgmath.h>", "header_read"),
    ("omni_board", "_SELFTEST_23e458e2bad7f4ef", "_SELFTEST_(x) x", "header_read"),
    ("omni_board", "_TICKS 9000U", "_TICKS 9000U\n#define v0 1.0F", "header_read"),
)
MUTANTS_IN_DOUBLE = (
    ("omni_board", "real) == 8U", "real) == 4U", "text_read"),
    ("omni_board", ">> 52", ">> 23", "text_read"),
    ("omni_board", "0xfffffffffffffU", "0x7fffffU", "text_read"),
    ("omni_board", "0x3fe6a09e667f3bcdU", "0x3f3504f3U", "text_read"),
    ("omni_board", "0.6766043901443481", "0.6766044901443481", "text_read"),
    ("omni_board", "0.6931471805599453", "0.6931481805599453", "text_read"),
)


def theorem_of(task_path: Path, folder: Path) -> str:
    """Return the theorem about the complete text of a controller whose files are in a folder."""
    parts = (folder / f"{task_path.stem}{end}" for end in (".h", ".c", ".certificate.json"))
    return controller_theorem_text(task_path.read_bytes(), *(path.read_bytes() for path in parts))


def generated_theorem(task_text: str, folder: Path) -> str:
    """Write the task "hall" to a folder, generate its controller there, and return the theorem."""
    path = folder / "hall.toml"
    path.write_text(task_text)
    result = run_command("generate", str(path), "--out", str(folder))
    assert result.returncode == 0, result.stderr
    return theorem_of(path, folder)


def shipped_theorem(name: str, scalar: str) -> str:
    """Return the theorem about the refined controller in generated/<name>/."""
    return theorem_of(ROOT / "tasks" / f"{name}.toml", ROOT / "generated" / name / "refined" / scalar)


@pytest.mark.parametrize("name", ["omni_s1", "trolley", "rover", "omni_board", "crawler"])
@pytest.mark.parametrize("scalar", ["float", "double"])
def test_shipped_controllers_have_the_theorem(name: str, scalar: str) -> None:
    theorem = shipped_theorem(name, scalar)
    introduction = theorem.partition("*)")[0]
    calls_library = name not in ("omni_board", "crawler")  # the others compute the logarithm inline
    assert ("library" in introduction) == calls_library  # the theorem assumes a bound on the library's logarithm
    verdict = coq.check_with_coq(theorem.encode(), name)
    assert verdict.holds, verdict.message


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("omni_s1", "gain = 0.5", "gain = [0.5, 0.7]"),  # only gains by component, without a sampling period
        ("omni_s1", "gain = 0.5", "gain = 0.5\nu_max = [3.1, 40.0]"),  # only input limits
        ("omni_s1", "gain = 0.5", "gain = 0.5\ne_max = [0.99, 0.98]"),  # only clamps of the error
        ("trolley", 'gain = "auto"', 'gain = "auto"\ne_max = [0.99, 0.98]'),  # gains, limits and clamps
        ("crawler", r"\[emit\].*", ""),  # only gains, with a sampling period: no ticks, and the library's logarithm
        ("omni_s1", r"\Z", "\n[emit]\ntick_period = 0.001\n"),  # ticks, and the library's logarithm
        ("omni_s1", r"gain = 0.5(.*)", r'gain = [0.5, 0.7]\nu_max = [3.1, 40.0]\1\n[emit]\nmath = "inline"\n'),
    ],
)
def test_controllers_with_only_some_parts_have_the_theorem(name: str, old: str, new: str, tmp_path: Path) -> None:
    task_path = tmp_path / f"{name}.toml"
    before = (ROOT / "tasks" / f"{name}.toml").read_text()
    task_path.write_text(re.sub(old, new, before, flags=re.S))
    assert task_path.read_text() != before
    result = run_command("generate", str(task_path), "--out", str(tmp_path))
    assert result.returncode == 0, result.stderr
    verdict = coq.check_with_coq(theorem_of(task_path, tmp_path).encode(), name)
    assert verdict.holds, verdict.message


def test_tasks_with_sets_of_every_kind_have_the_theorem(tmp_path: Path) -> None:
    """The task has a capsule, a cylinder, half-spaces and a box on some axes, a polytope, a body, and cuts of state space and target."""
    theorem = generated_theorem(HALL_TASK, tmp_path)
    verdict = coq.check_with_coq(theorem.encode(), "hall")
    assert verdict.holds, verdict.message
    assert set(verdict.axioms) == coq.ACCEPTED_AXIOMS
    for old, new, failing_lemma in HALL_CHANGES:
        assert old in theorem
        verdict = coq.check_with_coq(theorem.replace(old, new).encode(), "hall")
        assert verdict.message.startswith(failing_lemma), verdict.message


def test_a_ball_as_target_has_the_theorem_about_the_tube(tmp_path: Path) -> None:
    ball = re.sub(r"(\[target_set\]\n).*?\n\n", r"\1centre = [4.5, 4.5, 1.0]\nradius = 0.3\n\n", HALL_TASK, flags=re.S)
    with pytest.raises(BadInput, match="target_set.centre"):
        generated_theorem(ball, tmp_path)
    data = [(tmp_path / f"hall{end}").read_bytes() for end in (".toml", ".h", ".c", ".certificate.json")]
    verdict = coq.check_with_coq(theorem_text(*data), "hall")
    assert verdict.holds, verdict.message
    assert "emitted_tube" in verdict.message


@pytest.mark.parametrize(
    ("scalar", "mutant"),
    [("float", TextMutant(*fields)) for fields in MUTANTS] + [("double", TextMutant(*fields)) for fields in MUTANTS_IN_DOUBLE],
    ids=lambda value: getattr(value, "controller", value),  # jobs of `make integration` choose by it
)
def test_changed_texts_are_refused(scalar: str, mutant: TextMutant) -> None:
    theorem = shipped_theorem(mutant.controller, scalar)
    assert mutant.old in theorem
    verdict = coq.check_with_coq(theorem.replace(mutant.old, mutant.new, 1).encode(), mutant.controller)
    assert not verdict.holds
    assert verdict.message.startswith(mutant.failing_lemma), verdict.message


CHANGED_TICK_CONSTANTS = {"9000": "8999", "count * 4": "count * 3", "36000": "35968", "1125": "1124"}


def test_consistently_changed_ticks_are_refused_by_the_period_of_the_task() -> None:
    """The changed C is consistent in itself, but does not agree with the seconds of the task."""
    theorem = shipped_theorem("omni_board", "float")
    kernel = re.search(r"static inline void omni_board_segment_at_tick.*?\n}", theorem, flags=re.S)
    assert kernel
    for changed_constants in (["9000"], ["count * 4"], ["1125", "36000"]):
        changed_kernel = kernel[0]
        for old in changed_constants:
            assert old in changed_kernel
            changed_kernel = changed_kernel.replace(old, CHANGED_TICK_CONSTANTS[old])
        verdict = coq.check_with_coq(theorem.replace(kernel[0], changed_kernel).encode(), "omni_board")
        assert not verdict.holds
        assert verdict.message.startswith("ticks_checked"), verdict.message


def test_controllers_with_ticks_have_a_theorem_about_them() -> None:
    for name in ("omni_board", "omni_s1"):
        assert ("Theorem closed_loop_tick" in shipped_theorem(name, "float")) == (name == "omni_board")


ATTACKS = (
    *(("trolley", ".c", *pair) for pair in (*CHANGED_MEANINGS, *REORDERED_SUMS)),
    *((name, ".c", old, new) for name, old, new in SUBTLE_CHANGES),
    *(("trolley", ".h", *pair) for pair in CHANGED_HEADERS),
)
UNPROVED_FUNCTIONS = r"(?:margins?|covered|transform|normalized_error|basis_rate|tube_rate)"


def proved_part(text: str, name: str) -> str:
    """Return a header or C file without the functions and numbers that the theorem is not about (the stand-alone checker verifies them)."""
    proved_functions = re.sub(rf"^(?:static inline )?\w+ {name}_{UNPROVED_FUNCTIONS}\(.*?^\}}", "", text, flags=re.S | re.M)
    return re.sub(rf"^#define {name.upper()}_(?:T_C|PERIOD_PROVED|DESIGN_HASH) .*", "", proved_functions, flags=re.M)


@pytest.mark.parametrize(("name", "end", "old", "new"), ATTACKS)
def test_attacks_on_the_checker_are_refused_by_coq(name: str, end: str, old: str, new: str) -> None:
    """Only Coq decides. It refuses every change of the part that its theorem is about, and ignores other changes."""
    folder = ROOT / "generated" / name / "refined" / "float"
    source = folder / f"{name}.c"
    old, new = (filled(part, name, source) for part in (old, new))
    before = (folder / f"{name}{end}").read_text()
    after = before.replace(old, new)
    assert after != before
    verdict = coq.check_with_coq(shipped_theorem(name, "float").replace(coq_string(before), coq_string(after)).encode(), name)
    assert verdict.holds == (proved_part(before, name) == proved_part(after, name)), verdict.message
