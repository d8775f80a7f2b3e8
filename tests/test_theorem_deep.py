"""The theorem of the whole text: Coq reads task, header and C by itself, and accepts what is shipped; what is changed it does not."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from conftest import ROOT
from test_cli import run

from stt_codegen.theorem import asking
from stt_codegen.theorem.deep import deep

pytestmark = [pytest.mark.xdist_group("coq"), pytest.mark.slow]

LOGF = "omni_s1_real logf(omni_s1_real x)\n{\n    const omni_s1_real y = -x;\n    return y;\n}\n\n"
MUTANTS = (
    ("omni_s1", "u - base", "base - u", "text_read"),
    ("omni_s1", "logf(v0)", "logf(v3)", "text_read"),
    ("omni_s1", "(-0.5F) : 0.5F", "0.5F : (-0.5F)", "constants_checked"),
    ("omni_s1", "0.23894978F", "0.23894979F", "tube_checked"),
    ("omni_s1", "#include <math.h>", "#include <tgmath.h>", "text_read"),
    ("omni_s1", "0.5F;", "0.5;", "text_read"),
    ("omni_s1", "typedef float", "typedef double", "header_read"),
    # what a compiler reads otherwise than token by token: a comment to the end of its line, spliced lines, trigraphs, split signs
    ("omni_s1", "b / a;", "b //**/ a; /*\n    + a; /* */", "text_read"),
    ("omni_s1", "v1 = logf(v0);", "v1 = /* *\\\n/ -v0; /* */ logf(v0);", "text_read"),
    ("omni_s1", "v1 = logf(v0);", "v1 = logf(v0); /* ??/ */", "text_read"),
    ("omni_s1", "j < 2; ++j", "j < 2; + +j", "text_read"),
    # and what it finds elsewhere: code after a directive, a library's name, the task's name in the other case, another header
    ("omni_s1", "static inline omni_s1_real omni_s1_law(", "#define k 1\nstatic inline omni_s1_real omni_s1_law(", "text_read"),
    ("omni_s1", "static inline omni_s1_real omni_s1_law(", "static inline omni_s1_real OMNI_S1_law(", "text_read"),
    ("omni_s1", "static inline omni_s1_real omni_s1_law(", f"{LOGF}static inline omni_s1_real omni_s1_law(", "text_read"),
    ("omni_s1", "#define OMNI_S1_N 2", "#define OMNI_S1_N 1", "header_read"),
    ("omni_s1", "#define OMNI_S1_N 2", "#define OMNI_S1_N 2 /*/", "header_read"),
    ("omni_s1", "} omni_s1_status;", "} omni_s1_status; /* *\\\n/\n#define OMNI_S1_OUTSIDE_TUBE OMNI_S1_OK /* */", "header_read"),
    ("omni_s1", "upper = [2.0, 5.0]", "upper = [2.1, 5.0]", "task_read"),
    # gains by component: a table, and where it is read
    ("trolley", "0.178F, 0.168F", "0.001F, 0.168F", "period_checked"),
    ("trolley", "0.178F, 0.168F", "-0.178F, 0.168F", "constants_checked"),
    ("trolley", "trolley_gain[2] = {\n    0.178F, 0.168F", "trolley_gain[1] = {\n    0.178F", "constants_checked"),
    ("trolley", "= trolley_gain[i]", "= trolley_u_max[i]", "text_read"),
    ("trolley", "= trolley_gain[i]", "= trolley_gain[at]", "text_read"),
    ("trolley", "= -gain_i", "= gain_i", "text_read"),
    ("trolley", "upper_nearer ? gain_minus : gain_i", "upper_nearer ? gain_i : gain_minus", "text_read"),
    # limits: a table, and the statements that hold u within them
    ("trolley", "2.0F, 2.0F", "0.3F, 2.0F", "period_checked"),
    ("trolley", "2.0F, 2.0F", "2.0F, -2.0F", "constants_checked"),
    ("trolley", "trolley_u_max[2] = {\n    2.0F, 2.0F", "trolley_u_max[1] = {\n    2.0F", "constants_checked"),
    ("trolley", "= trolley_u_max[i]", "= trolley_gain[i]", "text_read"),
    ("trolley", "= -u_limit", "= u_limit", "text_read"),
    ("trolley", "u_min < push", "push < u_min", "text_read"),
    ("trolley", "u_held_above ? push : u_min", "u_held_above ? u_min : push", "text_read"),
    ("trolley", "u_limit < u_held_raised", "u_held_raised < u_limit", "text_read"),
    ("trolley", "u_held_over ? u_limit : u_held_raised", "u_held_over ? u_held_raised : u_limit", "text_read"),
    ("trolley", "u[i] = u_held;", "u[i] = push;", "text_read"),
    ("trolley", "u[i] = u_held;", "u[i] = u_held_raised;", "text_read"),
    # the logarithm written out: the bits of a float, and the statements
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
    # ticks have no meaning in what the theorem is about; a header has them, and a selftest
    ("omni_board", "int32_t segment = (int32_t)u", "uint32_t segment = (uint32_t)u", "text_read"),
    ("omni_board", "segment * 4;", "segment * 4U;", "text_read"),
    ("omni_board", "omni_board_segment(t, &row, &s)", "omni_board_segment_at_tick(t, &row, &s)", "text_read"),
    ("omni_board", "#include <stdint.h>", "#include <tgmath.h>", "header_read"),
    ("omni_board", "_SELFTEST_23e458e2bad7f4ef", "_SELFTEST_(x) x", "header_read"),
    ("omni_board", "_TICKS 9000U", "_TICKS 9000U\n#define v0 1.0F", "header_read"),
)
MUTANTS_DOUBLE = (
    ("omni_board", "real) == 8U", "real) == 4U", "text_read"),
    ("omni_board", ">> 52", ">> 23", "text_read"),
    ("omni_board", "0xfffffffffffffU", "0x7fffffU", "text_read"),
    ("omni_board", "0x3fe6a09e667f3bcdU", "0x3f3504f3U", "text_read"),
    ("omni_board", "0.6766043901443481", "0.6766044901443481", "text_read"),
    ("omni_board", "0.6931471805599453", "0.6931481805599453", "text_read"),
)


def deep_of(task: Path, folder: Path) -> str:
    parts = (folder / f"{task.stem}{end}" for end in (".h", ".c", ".certificate.json"))
    return deep(task.read_bytes(), *(path.read_bytes() for path in parts))


def text(name: str, scalar: str) -> str:
    return deep_of(ROOT / "tasks" / f"{name}.toml", ROOT / "generated" / name / "refined" / scalar)


@pytest.mark.parametrize("name", ["omni_s1", "trolley", "omni_board", "crawler"])
@pytest.mark.parametrize("scalar", ["float", "double"])
def test_shipped_controllers_have_it(name: str, scalar: str) -> None:
    told = text(name, scalar)
    about = told.partition("*)")[0]
    assert ("library" in about) == (name in ("omni_s1", "trolley"))  # its logarithm is assumed where it is called
    answer = asking.ask_coq(told.encode(), name)
    assert answer.holds, answer.what
    assert set(answer.axioms) <= asking.AXIOMS


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("omni_s1", "gain = 0.5", "gain = [0.5, 0.7]"),  # gains alone, without a period
        ("omni_s1", "gain = 0.5", "gain = 0.5\nu_max = [3.1, 40.0]"),  # limits alone
        ("crawler", r"\[emit\].*", ""),  # gains alone, with a period: a crawler in seconds, on a machine with a library
        ("omni_s1", r"\Z", "\n[emit]\ntick_period = 0.001\n"),  # ticks, and the library's logarithm
        ("omni_s1", r"gain = 0.5(.*)", r'gain = [0.5, 0.7]\nu_max = [3.1, 40.0]\1\n[emit]\nmath = "inline"\n'),
    ],
)
def test_parts_have_it_one_without_the_other(name: str, old: str, new: str, tmp_path: Path) -> None:
    task = tmp_path / f"{name}.toml"
    before = (ROOT / "tasks" / f"{name}.toml").read_text()
    task.write_text(re.sub(old, new, before, flags=re.S))
    assert task.read_text() != before
    done = run("generate", str(task), "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    answer = asking.ask_coq(deep_of(task, tmp_path).encode(), name)
    assert answer.holds, answer.what


@pytest.mark.parametrize(
    ("name", "scalar", "old", "new", "lemma"),
    [(name, "float", *rest) for name, *rest in MUTANTS] + [(name, "double", *rest) for name, *rest in MUTANTS_DOUBLE],
)
def test_changed_texts_have_none(name: str, scalar: str, old: str, new: str, lemma: str) -> None:
    whole = text(name, scalar)
    assert old in whole
    answer = asking.ask_coq(whole.replace(old, new, 1).encode(), name)
    assert not answer.holds
    assert answer.what.startswith(lemma), answer.what


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        (".c", "held = running ? tick : 9000U", "held = running ? tick : 8999U"),
        (".c", "place / 1125", "place / 1124"),
        (".c", "part / 1125.0F", "part / 1124.0F"),
        (".h", "_TICKS 9000U", "_TICKS 8999U"),
    ],
)
def test_ticks_are_the_checkers_word(file: str, old: str, new: str, tmp_path: Path) -> None:
    """Coq reads such functions and says nothing of them; the command asks the checker first."""
    shutil.copytree(ROOT / "generated/omni_board/refined/float", tmp_path / "c")
    place = tmp_path / f"c/omni_board{file}"
    before = place.read_text()
    place.write_text(before.replace(old, new, 1))
    assert place.read_text() != before
    assert "Times are in seconds" in deep_of(ROOT / "tasks/omni_board.toml", tmp_path / "c")
    done = run("theorem", "tasks/omni_board.toml", str(tmp_path / "c/omni_board.c"))
    assert done.returncode == 1, done.stdout
