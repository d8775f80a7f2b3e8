"""Files that were made to fool the stand-alone checker: hostile spelling, numbers and structure in C, certificate and task.

It must refuse them or say that it cannot check them, within seconds."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from stt_codegen.checker import check_files
from stt_codegen.checker.stt_checker.exact import Refused, Unusable
from stt_codegen.checker.stt_checker.formula import Cycle, of_entry, parse, satisfied
from stt_codegen.checker.stt_checker.sets import hull_faces
from stt_codegen.checker.stt_checker.source import tokens
from stt_codegen.checker.stt_checker.task import Task
from tests.support.checked_files import (
    REFUSED,
    UNUSABLE,
    VERIFIED,
    Files,
    certificate_of,
    recorded_files,
    verdict,
    with_certificate,
    with_hashes,
    write_files,
)
from tests.support.forged_controllers import forged_files, still_design

SECONDS = 5.0  # of the processor, in which the checker must answer whatever it is given


@contextmanager
def soon() -> Iterator[None]:
    """Require that what is inside takes few seconds."""
    begin = time.process_time()
    yield
    assert time.process_time() - begin < SECONDS


def is_turned_away(files: Files, folder: Path, codes: tuple[int, ...] = (REFUSED, UNUSABLE)) -> str:
    """Require that the checker does not verify the files, soon and without an exception. Return its message."""
    with soon():
        code, message = verdict(files, folder)
    assert code in codes, message
    assert message.startswith("checker: ")
    return message


# ------------------------------------------------------------------------------------------------ C

# Changes of trolley's C or header that a lenient reader of C might take for white space, a comment or the same number.
HOSTILE_TEXTS: dict[str, tuple[str, str, str]] = {
    "a literal without its F": ("c", "    0.0384F, 0.0252F", "    0.0384, 0.0252"),
    "a literal with a small f": ("c", "    0.0384F, 0.0252F", "    0.0384f, 0.0252f"),
    "a literal with an L": ("c", "    0.0384F, 0.0252F", "    0.0384L, 0.0252F"),
    "a hexadecimal literal": ("c", "1.0F - s", "0x1p0F - s"),
    "a literal with a large E": ("c", "    0.0384F, 0.0252F", "    3.84E-2F, 0.0252F"),
    "a literal with a plus": ("c", "2.0F, 2.0F", "2.0e+0F, 2.0F"),
    "a literal without a point": ("c", "1.0F - s", "1e0F - s"),
    "a literal of one more digit": ("c", "started * 4.0F", "started * 4.0F5"),
    "a literal of the neighbouring float": ("c", "    0.0384F, 0.0252F", "    0.038400006F, 0.0252F"),
    "an integer for a real": ("c", "1.0F - s", "1 - s"),
    "an octal integer": ("c", "at + 8;", "at + 010;"),
    "an integer with a suffix": ("c", "at + 8;", "at + 8L;"),
    "a digraph": ("c", "static const trolley_real trolley_gain[2]", "static const trolley_real trolley_gain<:2:>"),
    "a digraph of a directive": ("c", "#include <math.h>", "%:include <math.h>"),
    "a trigraph in a comment": ("c", "/* Control law (13)", "/* ??/\n Control law (13)"),
    "a line that goes on": ("c", "    *w0 = v2;", "    *w0 \\\n= v2;"),
    "a line that goes on in a comment": ("c", "/* Control law (13)", "/* \\\n Control law (13)"),
    "a comment that hides a statement": ("c", "    *w0 = v2;", "    // \\\n    *w0 = v2;"),
    "a comment by two slashes": ("c", "    *w0 = v2;", "    *w0 = v2; // 6 times the weight"),
    "a comment within an operator": ("c", "zero <= 0.0F", "zero </**/= 0.0F"),
    "a space within an operator": ("c", "zero <= 0.0F", "zero < = 0.0F"),
    "a space within a name": ("c", "const bool early = scaled", "const bool ear ly = scaled"),
    "a comment that does not end": ("c", "    return outside ? ", "    return /* outside ? "),
    "a comment within a directive that does not end": ("c", "#include <math.h>", "#include <math.h> /*\n*/"),
    "a string that holds a comment": ("c", "#include <math.h>", '#include <math.h>\n_Static_assert(1, "/*");'),
    "a directive after a comment": ("c", "#include <math.h>", "/* */ #include <math.h>\n#include <math.h>"),
    "a file included": ("c", "#include <math.h>", '#include <math.h>\n#include "other.h"'),
    "another file included": ("c", "#include <math.h>", '#include "math.h"'),
    "a file included within a table": ("c", "    0.0384F, 0.0252F", '#include "gain.h"'),
    "a name defined before the tables": ("c", "/* B-spline", "#define trolley_segment(t, row, s) other(t, row, s)\n/* B-spline"),
    "a keyword defined": ("c", "/* B-spline", "#define const\n/* B-spline"),
    "a name undefined": ("c", "/* B-spline", "#undef NAN\n/* B-spline"),
    "a number of lines": ("c", "/* B-spline", "#line 1\n/* B-spline"),
    "a pragma": ("c", "/* B-spline", '#pragma GCC optimize ("fast-math")\n/* B-spline'),
    "a pragma as an operator": ("c", "    *w0 = v2;", '    _Pragma("STDC FP_CONTRACT ON")\n    *w0 = v2;'),
    "no pragma": ("c", '#pragma GCC optimize ("fp-contract=off")\n', ""),
    "the other pragma": ("c", "#pragma STDC FP_CONTRACT OFF", "#pragma STDC FP_CONTRACT ON"),
    "an error that is no error": ("c", "#error", "#warning"),
    "a test of the compiler turned about": ("c", "#if defined(__FAST_MATH__)", "#if !defined(__FAST_MATH__)"),
    "code before the end": ("c", "/* B-spline", "int trolley_more(void);\n/* B-spline"),
    "assembly": ("c", "    *w0 = v2;", '    __asm__("" : : : "memory");\n    *w0 = v2;'),
    "an attribute": ("c", "static inline trolley_real trolley_law", "__attribute__((weak)) trolley_real trolley_law"),
    "a space that is none": ("c", "*w0 = v2;", "*w0\u00a0= v2;"),
    "a letter that looks the same": ("c", "    *w0 = v2;", "    *w0 = v2;\n    /* \u0430 */"),
    "a direction of writing": ("c", "/* Control law (13)", "/* \u202e Control law (13)"),
    "a NUL": ("c", "    *w0 = v2;", "    *w0 = v2;\0"),
    "a NUL in a comment": ("c", "/* Control law (13)", "/* \0 Control law (13)"),
    "a form feed": ("c", "    *w0 = v2;", "\f   *w0 = v2;"),
    "a tab": ("c", "    *w0 = v2;", "\t*w0 = v2;"),
    "lines that end as on Windows": ("c", "\n", "\r\n"),
    "lines that end as on old machines": ("c", "    *w0 = v2;\n", "    *w0 = v2;\r"),
    "a macro of the header defined twice": ("h", "#define TROLLEY_N 2", "#define TROLLEY_N 3\n#undef TROLLEY_N\n#define TROLLEY_N 2"),
    "a function of the header as a macro": ("h", "#define TROLLEY_N 2", "#define TROLLEY_N 2\n#define trolley_control trolley_other"),
    "a library's function as a macro": ("h", "#define TROLLEY_N 2", "#define TROLLEY_N 2\n#define isfinite(t) 1"),
    "a hash of another design": ("h", 'DESIGN_HASH "', 'DESIGN_HASH "0" "'),
    "a status that is none": ("h", "TROLLEY_BAD_INPUT = 2", "TROLLEY_BAD_INPUT = 02"),
}  # fmt: skip


@pytest.mark.parametrize("attack", HOSTILE_TEXTS)
def test_c_that_is_spelled_otherwise_than_comments_spaces_and_numbers_allow_is_refused(attack: str, tmp_path: Path) -> None:
    end, old, new = HOSTILE_TEXTS[attack]
    files = recorded_files("trolley")
    text = files[f"trolley.{end}"].decode()
    assert old in text
    changed = text.replace(old, new).encode()
    code, message = verdict(with_hashes({**files, f"trolley.{end}": changed}), tmp_path)
    assert code == REFUSED, message


@pytest.mark.parametrize("end", ["c", "h"])
def test_what_stands_after_the_end_of_the_listing_is_refused_and_a_comment_is_not(end: str, tmp_path: Path) -> None:
    files = recorded_files("trolley")
    name, text = f"trolley.{end}", files[f"trolley.{end}"]
    for more, code in (
        (b"\nint trolley_more(void) { return 0; }\n", REFUSED),
        (b"\n;\n", REFUSED),
        (b"\n/* more */\n", VERIFIED),
    ):
        assert verdict(with_hashes({**files, name: text + more}), tmp_path)[0] == code
    code, message = verdict(with_hashes({**files, name: text[: text.rstrip().rfind(b"\n")]}), tmp_path)
    assert code == REFUSED
    assert "'the end'" in message


@pytest.mark.parametrize("text", ["$3/4", "$0", "(-$1)", "the end", "$", "M_N", "P_real", "<<basis>>", "  [ticks]"])
def test_words_of_the_listing_are_no_words_of_c(text: str, tmp_path: Path) -> None:
    """In a file they would agree with what the listing says before it is filled."""
    files = recorded_files("trolley")
    for old in ("    0.0384F, 0.0252F", "    *w0 = v2;"):
        source = files["trolley.c"].decode().replace(old, f"{old} {text}")
        is_turned_away(with_hashes({**files, "trolley.c": source.encode()}), tmp_path, (REFUSED,))
    source = files["trolley.c"].decode().replace("0.0384F", text)
    is_turned_away(with_hashes({**files, "trolley.c": source.encode()}), tmp_path)


def test_a_table_that_is_stated_twice_is_refused(tmp_path: Path) -> None:
    """Whichever the checker reads: the numbers that it proves are those that are compiled."""
    files = recorded_files("trolley")
    text = files["trolley.c"].decode()
    begin = text.index("static const trolley_real trolley_coefficients")
    table = text[begin : text.index("};", begin) + 3]
    bent = table.replace("0.01112175F", "0.01112177F")
    assert bent != table
    for source in (text.replace(table, table + bent), text.replace(table, bent + table), text.replace(table, bent)):
        is_turned_away(with_hashes({**files, "trolley.c": source.encode()}), tmp_path, (REFUSED,))
    hidden = text.replace("#include <math.h>", f"#if 0\n{bent}#endif\n#include <math.h>")
    is_turned_away(with_hashes({**files, "trolley.c": hidden.encode()}), tmp_path, (REFUSED,))


def test_the_words_of_a_directive_end_with_its_line() -> None:
    """`#define F` and then x is not `#define F x`."""
    assert tokens("#define F\nx") != tokens("#define F x")
    assert tokens("#define F /* */ x") == tokens("#define F x")
    with pytest.raises(Refused, match="line"):
        tokens("#define F /* x\n*/")


# ------------------------------------------------------------------------------------------------ files


@pytest.mark.parametrize("file", ["trolley.c", "trolley.h", "trolley.certificate.json", "task.toml"])
def test_a_file_that_is_missing_or_empty_is_not_verified(file: str, tmp_path: Path) -> None:
    files = recorded_files("trolley")
    arguments = write_files(files, tmp_path)
    (tmp_path / file).unlink()
    from stt_codegen.checker import check_files

    assert check_files(arguments) == UNUSABLE
    is_turned_away({**files, file: b""}, tmp_path)


@pytest.mark.parametrize(("name", "file"), [("watchman", "watchman_wrap.c"), ("omni_board", "omni_board.h")])
def test_a_file_that_the_task_asks_for_is_read(name: str, file: str, tmp_path: Path) -> None:
    files = recorded_files(name)
    text = files[file].decode()
    is_turned_away(
        with_hashes({**files, file: text.replace("return", "return 0 *", 1).replace("_N 2", "_N 1").encode()}), tmp_path
    )
    del files[file]
    is_turned_away(files, tmp_path)


def test_files_may_be_links(tmp_path: Path) -> None:
    """The bytes are what counts."""
    (tmp_path / "elsewhere").mkdir()
    files = recorded_files("trolley")
    arguments = write_files(files, tmp_path / "elsewhere")
    for path in map(Path, [*arguments, str(tmp_path / "elsewhere" / "trolley.h")]):
        os.symlink(path, tmp_path / path.name)
    from stt_codegen.checker import check_files

    assert check_files([str(tmp_path / Path(path).name) for path in arguments]) == VERIFIED


@pytest.mark.parametrize("file", ["omni_board_selftest.c", "omni_board.py"])
def test_a_file_of_which_only_the_hash_is_known_must_have_it(file: str, tmp_path: Path) -> None:
    """It is compiled by itself, so that its definitions reach no other file. Where it is not there nothing is said about it."""
    files = recorded_files("omni_board")
    is_turned_away({**files, file: b"#define logf(x) 0\n" + files[file]}, tmp_path, (REFUSED,))
    del files[file]
    (tmp_path / file).unlink()
    assert verdict(files, tmp_path).code == VERIFIED


@pytest.mark.parametrize("key", ["../trolley.c", "trolley_guard.c", "TROLLEY.c", "trolley.js", "trolley.c.rs"])
def test_a_hash_of_a_file_that_no_task_asks_for_is_refused(key: str, tmp_path: Path) -> None:
    files = recorded_files("trolley")
    certificate = certificate_of(files)
    certificate["sha256"][key] = certificate["sha256"]["trolley.c"]
    is_turned_away(with_certificate(files, certificate), tmp_path, (REFUSED,))


# ------------------------------------------------------------------------------------------------ the certificate's text

# Changes of the text of trolley's certificate: JSON that Python's reader takes, and values of another type that are equal.
HOSTILE_JSON: dict[str, tuple[str, str]] = {
    "a key twice": ('"task": "trolley"', '"task": "trolley", "task": "trolley"'),
    "a claim's key twice": ('"property": "P1"', '"property": "P9", "property": "P1"'),
    "no number": ('"margin": 31', '"margin": NaN'),
    "infinity": ('"margin": 31', '"margin": Infinity'),
    "infinity as a decimal": ('"margin": 31', '"margin": 1e999'),
    "a decimal": ('"margin": 31', '"margin": 31.0'),
    "a decimal in a hint": ('"hints": [[0, ', '"hints": [[0.0, '),
    "a truth for 1": ('"cuts": 1', '"cuts": true'),
    "a truth for an order": ('"order": 1', '"order": true'),
    "a truth for 0": ('"on": [0, ', '"on": [false, '),
    "a 1 for a truth": ('"certified": true', '"certified": 1'),
    "a 1 for covers_initial_set": ('"covers_initial_set": true', '"covers_initial_set": 1'),
    "a text for a format": ('"format": 3', '"format": "3"'),
    "a text for a number": ('"cuts": 1', '"cuts": "1"'),
    "a text for a margin": ('"margin": 31', '"margin": "31"'),
    "a list for a number": ('"cuts": 1', '"cuts": [1]'),
    "a table for a list": ('"claims": [', '"claims": {}, "more": ['),
    "a fraction with a space": ('"rho": ["', '"rho": [" '),
    "a fraction with a plus": ('"rho": ["', '"rho": ["+'),
    "a fraction by 0": ('"shift": ["', '"shift": ["1/0", "'),
    "another format": ('"format": 3', '"format": 2'),
    "a format to come": ('"format": 3', '"format": 4'),
    "another method": ('"method": "exact"', '"method": "enclosures"'),
    "not certified": ('"certified": true', '"certified": false'),
    "cuts that are no power of two": ('"cuts": 1', '"cuts": 3'),
    "no cuts": ('"cuts": 1', '"cuts": 0'),
    "cuts below 0": ('"cuts": 1', '"cuts": -1'),
    "a huge number of cuts": ('"cuts": 1', '"cuts": 1' + "0" * 4000),
    "a claim as pairs": ('{"property": "P6", "on": [0, 32]}', '[["property", "P6"], ["on", [0, 32]]]'),
    "hints of a claim that has none": ('"property": "P2"', '"property": "P2", "hints": []'),
    "units beyond all": ('"unit_bits": 20', '"unit_bits": 100000'),
    "units below all": ('"unit_bits": 20', '"unit_bits": -100000'),
    "other units": ('"unit_bits": 20', '"unit_bits": 21'),
    "no segments": ('"segments": 32', '"segments": 0'),
    "a huge number": ('"margin": 31', '"margin": ' + "9" * 4200),
    "a number that Python does not read": ('"margin": 31', '"margin": ' + "9" * 5000),
    "a scalar that is none": ('"scalar": "float"', '"scalar": "half"'),
    "another scalar": ('"scalar": "float"', '"scalar": "double"'),
    "integers": ('"scalar": "float"', '"scalar": "fixed"'),
}  # fmt: skip


@pytest.mark.parametrize(("cuts", "code"), [(1 << 20, VERIFIED), (1 << 21, REFUSED)])
def test_a_segment_has_a_limited_number_of_parts(cuts: int, code: int, tmp_path: Path) -> None:
    """All places are counted in them, so the claims are as true as before; numbers of a thousand digits would only take long."""
    files = recorded_files("trolley")
    certificate = certificate_of(files)
    scale, certificate["grid"]["cuts"] = cuts // certificate["grid"]["cuts"], cuts
    for claim in certificate["claims"]:
        claim["on"] = [scale * v for v in claim["on"]]
        for hint in claim.get("hints", []):
            hint[:2] = [scale * v for v in hint[:2]]
    code_of_verdict, message = verdict(with_certificate(files, certificate), tmp_path)
    assert code_of_verdict == code, message
    assert code == VERIFIED or "cuts is no power of two up to" in message


@pytest.mark.parametrize("attack", HOSTILE_JSON)
def test_a_certificate_with_other_values_or_types_is_refused(attack: str, tmp_path: Path) -> None:
    files, (old, new) = recorded_files("trolley"), HOSTILE_JSON[attack]
    text = files["trolley.certificate.json"].decode()
    if old == '"margin": 31' and old not in text:
        old = re.search(r'"margin": \d+', text)[0]  # type: ignore[index]
    assert old in text
    is_turned_away({**files, "trolley.certificate.json": text.replace(old, new, 1).encode()}, tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        "", "null", "[]", "3", '"refined"', "{}", '{"design": "refined"}', "[" * 200_000, '{"a":' * 200_000, '{"design": "refined", "claims": ' + "[" * 50_000,
        '{"design": "refined", "design": "adaptive"}', "\ufeff{}", "{} {}", "{'design': 'refined'}",
    ],
)  # fmt: skip
def test_text_that_is_no_certificate_is_not_verified(text: str, tmp_path: Path) -> None:
    files = recorded_files("trolley")
    is_turned_away({**files, "trolley.certificate.json": text.encode()}, tmp_path)


def test_a_certificate_in_another_encoding_says_the_same(tmp_path: Path) -> None:
    files = recorded_files("trolley")
    text = files["trolley.certificate.json"].decode()
    assert verdict({**files, "trolley.certificate.json": text.encode("utf-16")}, tmp_path).code == VERIFIED
    is_turned_away({**files, "trolley.certificate.json": text.encode("utf-16")[:-200]}, tmp_path)


# ------------------------------------------------------------------------------------------------ hints

BESIDE_A_WALL = """name = "a"
prescribed_time = 1.0
initial_state = [0, 0]
[state_space]
lower = [-2, -2]
upper = [2, 2]
[initial_set]
lower = [-1, -1]
upper = [1, 1]
[target_set]
lower = [-1, -1]
upper = [1, 1]
[[unsafe]]
name = "corner"
normals = [[-1, -1], [1, 0]]
offsets = [-1.5, 1.5]
[tube]
min_width = 0.01
[control]
gain = 0.5
"""
SEPARATING = [[0, 6, [-1, -1], ["1", "0"]]]  # -x - y is below -1.5 on the set


def beside_a_wall(hints: Any) -> Files:
    """Return forged files of a tube of half width 0.49 that stands still below a slanted wall, with these hints of P4. They hold, but
    for the hints."""
    return forged_files(BESIDE_A_WALL, still_design(1 << 13, 17, 2, hints={"corner": hints}))


def test_a_forged_controller_with_true_hints_is_verified(tmp_path: Path) -> None:
    """So that what is refused below is refused for the hints alone. Twice the multipliers with twice the normal mean the same."""
    end = 3
    for hints in (
        [[0, end, [-1, -1], ["1", "0"]]],
        [[0, end, [-2, -2], ["2", "0"]]],
        [[0, 1, [-1, -1], ["1", "0"]], [1, 1, [-1, -1], ["1", "0"]], [1, end, [-3, -3], ["3", "1/1000"]]],
    ):
        assert verdict(beside_a_wall(hints), tmp_path).code == VERIFIED


HOSTILE_HINTS: dict[str, Any] = {
    "none": [],
    "a hole": [[0, 1, [-1, -1], ["1", "0"]], [2, 3, [-1, -1], ["1", "0"]]],
    "an end too soon": [[0, 2, [-1, -1], ["1", "0"]]],
    "a beginning too late": [[1, 3, [-1, -1], ["1", "0"]]],
    "a beginning too soon": [[-1, 3, [-1, -1], ["1", "0"]]],
    "an end too late": [[0, 4, [-1, -1], ["1", "0"]]],
    "an end far too late": [[0, 10**12, [-1, -1], ["1", "0"]]],
    "times backwards": [[0, 3, [-1, -1], ["1", "0"]], [3, 0, [-1, -1], ["1", "0"]]],
    "an overlap": [[0, 2, [-1, -1], ["1", "0"]], [1, 3, [-1, -1], ["1", "0"]]],
    "a truth for a time": [[False, 3, [-1, -1], ["1", "0"]]],
    "no normal": [[0, 3]],
    "a normal of 0": [[0, 3, [0, 0], ["1", "0"]]],
    "a normal of one number": [[0, 3, [-1], ["1", "0"]]],
    "a normal of three numbers": [[0, 3, [-1, -1, 0], ["1", "0"]]],
    "a normal of truths": [[0, 3, [True, True], ["1", "0"]]],
    "a normal of texts": [[0, 3, ["-1", "-1"], ["1", "0"]]],
    "a normal outwards": [[0, 3, [1, 1], ["1", "0"]]],
    "another normal": [[0, 3, [-1, 0], ["1", "0"]]],
    "a huge normal": [[0, 3, [-(10**4000), -1], ["1", "0"]]],
    "no multipliers": [[0, 3, [-1, -1]]],
    "a multiplier that is missing": [[0, 3, [-1, -1], ["1"]]],
    "a multiplier too many": [[0, 3, [-1, -1], ["1", "0", "0"]]],
    "a negative multiplier": [[0, 3, [-1, -1], ["1", "-1"]]],
    "a multiplier that is too small": [[0, 3, [-1, -1], ["1/2", "0"]]],
    "a multiplier that is too large": [[0, 3, [-1, -1], ["2", "0"]]],
    "a huge multiplier": [[0, 3, [-1, -1], ["1", "9" * 4000]]],
    "a multiplier with a huge exponent": [[0, 3, [-1, -1], ["1e999999999", "0"]]],
    "a multiplier as a number": [[0, 3, [-1, -1], [1, 0]]],
    "a multiplier as a decimal": [[0, 3, [-1, -1], ["1.0", "0"]]],
    "a multiplier by 0": [[0, 3, [-1, -1], ["1/0", "0"]]],
    "multipliers as one text": [[0, 3, [-1, -1], "10"]],
    "multipliers as a table": [[0, 3, [-1, -1], {"1": "0"}]],
    "more than a hint": [[0, 3, [-1, -1], ["1", "0"], []]],
    "a table for a hint": [{"0": 3}],
    "a text for hints": "hints",
    "a number for hints": 7,
}  # fmt: skip


@pytest.mark.parametrize("attack", HOSTILE_HINTS)
def test_a_hint_that_proves_nothing_is_refused(attack: str, tmp_path: Path) -> None:
    is_turned_away(beside_a_wall(HOSTILE_HINTS[attack]), tmp_path)


def test_hints_of_a_wall_that_reaches_the_tube_are_refused(tmp_path: Path) -> None:
    """Whatever the multipliers are: here the set has a corner in the tube."""
    text = BESIDE_A_WALL.replace("offsets = [-1.5, 1.5]", "offsets = [-0.7, 1.5]")
    for multipliers in (["1", "0"], ["0", "0"], ["0", "1"], ["1", "1"], ["1/3", "2/3"], ["9", "0"]):
        hints = {"corner": [[0, 3, [-1, -1], multipliers]]}
        is_turned_away(forged_files(text, still_design(1 << 13, 17, 2, hints=hints)), tmp_path, (REFUSED,))


# ------------------------------------------------------------------------------------------------ numbers near the ends of a float

ON_A_LINE = """name = "a"
prescribed_time = {t_c}
initial_state = [0]
[state_space]
lower = [-{space}]
upper = [{space}]
[initial_set]
lower = [-{space}]
upper = [{space}]
[target_set]
lower = [-{space}]
upper = [{space}]
[tube]
min_width = 0.000004
[control]
gain = {gain}
u_max = 1e29
e_max = {e_max}
period = {period}
[plant]
g_min = {g}
g_max = {g}
"""
IN_RANGE = {"t_c": "1", "gain": "1e6", "e_max": "0.99", "g": "1e-20", "period": "0.001", "space": "2"}


def on_a_line(scalar: str = "float", width: int = 200, unit_bits: int = 28, rho: int = 50, **numbers: str) -> Files:
    """Return forged files of a tube on a line that stands still, with a sampled loop that P9 proves."""
    text = ON_A_LINE.format(**{**IN_RANGE, **numbers})
    return forged_files(text, still_design(width, unit_bits, rho=(Fraction(rho),), scalar=scalar))


def test_a_forged_loop_is_verified(tmp_path: Path) -> None:
    for scalar in ("float", "double"):
        assert verdict(on_a_line(scalar), tmp_path).code == VERIFIED


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize(
    "numbers",
    [
        {"gain": "1e30", "e_max": "0.99999", "g": "1e-60", "rho": 150_000},  # gain times xi overflows: u is infinite near the edges
        {"gain": "1e-28", "g": "1e-20", "width": 1, "unit_bits": -20, "space": "1e8"},  # it underflows: u is 0
        {"t_c": "1e-28", "period": "1e-32", "width": 1, "unit_bits": -20, "space": "1e8"},  # rates of edges, in segments a second
    ],
)  # fmt: skip
def test_products_of_the_controller_stay_in_the_scalars_range(scalar: str, numbers: dict[str, Any], tmp_path: Path) -> None:
    """Each number is in range; P9 holds for the law in fractions. The certificate would claim a finite u, where the C has none."""
    message = is_turned_away(on_a_line(scalar, **numbers), tmp_path, (REFUSED,))
    assert "near the ends of its scalar's range" in message


# ------------------------------------------------------------------------------------------------ tasks

# Changes of trolley's task: TOML that other readers take in another way, or that the tool refuses.
HOSTILE_TASKS: dict[str, tuple[str, str]] = {
    "infinity": ("prescribed_time = 8.0", "prescribed_time = inf"),
    "no number": ("clearance = 0.05", "clearance = nan"),
    "a truth": ("share = 0.9", "share = true"),
    "a text": ("prescribed_time = 8.0", 'prescribed_time = "8.0"'),
    "a fraction as a text": ("prescribed_time = 8.0", 'prescribed_time = "8/1"'),
    "a date": ("prescribed_time = 8.0", "prescribed_time = 2024-01-01"),
    "a time": ("prescribed_time = 8.0", "prescribed_time = 08:00:00"),
    "a huge whole number": ("prescribed_time = 8.0", "prescribed_time = 1" + "0" * 4000),
    "a whole number that Python does not read": ("prescribed_time = 8.0", "prescribed_time = 1" + "0" * 5000),
    "many digits": ("clearance = 0.05", "clearance = 0.05" + "0" * 1_000_000 + "1"),
    "a number near 0": ("clearance = 0.05", "clearance = 1e-999999"),
    "one number for a body": ("body = [0.15, 0.1]", "body = 0.1"),
    "a vector in a vector": ("body = [0.15, 0.1]", "body = [[0.15, 0.1]]"),
    "a name that is a number": ('name = "trolley"', "name = 7"),
    "a name that is a path": ('name = "trolley"', 'name = "../trolley"'),
    "a name that is two words": ('name = "trolley"', 'name = "trolley; x"'),
    "no name": ('name = "trolley"', 'name = ""'),
    "axes of one name": ("body = ", 'axes = ["x", "x"]\nbody = '),
    "axes that are a text": ("body = ", 'axes = "xy"\nbody = '),
    "axes that are numbers": ("body = ", "axes = [1, 2]\nbody = "),
    "an axis too few": ("body = ", 'axes = ["x"]\nbody = '),
    "an axis too many": ("body = ", 'axes = ["x", "y", "z"]\nbody = '),
    "unsafe sets as a table": ("[[unsafe]]", "[unsafe]"),
    "a set's name that is a number": ("[[unsafe]]", "[[unsafe]]\nname = 3\nlower = [0, 0]\nupper = [0.1, 0.1]\n[[unsafe]]"),
    "an unsafe set of two kinds": ("[[unsafe]]", "[[unsafe]]\ncentre = [1, 1]\nradius = 0.1"),
    "a set with a spread that is a text": ("[[unsafe]]", "[[unsafe]]\nspread = 'no'"),
    "a set with a negative spread": ("[[unsafe]]", "[[unsafe]]\nspread = -0.1"),
    "a mission of nothing": ("[control]", "[[mission]]\n[control]"),
    "no mission": ("prescribed_time = 8.0", "prescribed_time = 8.0\nmission = []"),
    "an order that is a truth": ("[plant]", "[plant]\norder = true"),
    "an order that is a decimal": ("[plant]", "[plant]\norder = 1.0"),
    "an order of three": ("[plant]", "[plant]\norder = 3"),
    "noise that is a list": ("noise = 0.002", "noise = [0.002, 0.002]"),
    "a key of another order": ("[plant]", "[plant]\nnoise_v = 0.1"),
    "a map": ("[control]", "[map]\nfile = 'map.yaml'\n[control]"),
    "an outline": ("[state_space]", "[state_space]\noutline = [[0, 0], [1, 0], [0, 1]]"),
    "a table that is unknown": ("[control]", "[controls]\n[control]"),
    "an outside that is unknown": ("[control]", "[control]\noutside = 'fly'"),
    "a table for a number": ("share = 0.9", "share = { of = 0.9 }"),
    "a key in quotes": ("share = 0.9", '"share " = 0.9'),
}  # fmt: skip


@pytest.mark.parametrize("attack", HOSTILE_TASKS)
def test_a_task_that_the_tool_would_refuse_is_not_checked(attack: str, tmp_path: Path) -> None:
    """It is not the hash of the task's data that turns it away."""
    files, (old, new) = recorded_files("trolley"), HOSTILE_TASKS[attack]
    text = files["task.toml"].decode()
    assert old in text
    message = is_turned_away({**files, "task.toml": text.replace(old, new, 1).encode()}, tmp_path)
    assert "SHA-256" not in message


def test_the_text_of_a_task_may_change_where_its_data_do_not(tmp_path: Path) -> None:
    """Numbers are exact decimals: 0.05 is 5e-2 and 0.050, and not the nearest number of a machine."""
    files = recorded_files("trolley")
    text = files["task.toml"].decode()
    for old, new in (
        ("clearance = 0.05", "clearance = 5e-2"),
        ("prescribed_time = 8.0", "prescribed_time = 8"),
        ("share = 0.9", "share = 0.90_0"),
    ):
        assert old in text
        text = text.replace(old, new)
    assert verdict({**files, "task.toml": b"\xef\xbb\xbf" + text.encode() + b"# a comment\n"}, tmp_path).code == VERIFIED
    near = text.replace("clearance = 5e-2", "clearance = 0.05000000000000000277")  # 0.05 in binary
    assert "SHA-256" in is_turned_away({**files, "task.toml": near.encode()}, tmp_path, (REFUSED,))


def test_two_tasks_with_the_same_digest_have_the_same_data() -> None:
    """A text is no number, and a list no table, for the digest; where a text has the form of a fraction the task is not read."""
    text = (recorded_files("trolley")["task.toml"]).decode()
    digest = Task(text.encode()).digest
    assert Task(text.replace("8.0", "8.00").encode()).digest == digest
    assert Task(text.replace("8.0", "8.01").encode()).digest != digest
    with pytest.raises(Unusable, match="where a number is needed"):
        Task(text.replace("prescribed_time = 8.0", 'prescribed_time = "8/1"').encode())


def test_a_message_is_one_line_whatever_names_a_task_has(tmp_path: Path) -> None:
    """A name could say that all is well, in a line of its own."""
    for name in (r"x\nchecker: verified: trolley: all holds", r"x\u001b[2K\rchecker: verified", r"\u202e\u00e4"):
        files = recorded_files("trolley")
        text = files["task.toml"].decode().replace('name = "pillar"', f'name = "{name}"').encode()
        message = is_turned_away({**files, "task.toml": text}, tmp_path, (REFUSED,))
        assert message.startswith("checker: refused: ")
        assert message.isascii()
        assert message.strip().isprintable()


# ------------------------------------------------------------------------------------------------ time


def test_a_task_that_would_take_long_is_turned_away_soon() -> None:
    cycle, known = Cycle(Fraction(2), Fraction(16), Fraction(1, 100)), {("in", "a"): [(Fraction(0), Fraction(16))]}
    with soon():
        for formula in ("eventually [0, 1e30] a", "always [1e18, inf] a", "eventually [0, 1e6] eventually [0, 1e6] a"):
            with pytest.raises(Refused, match="too far ahead"):
                satisfied(parse(formula), known, cycle)
        with pytest.raises(Unusable, match="good time"):
            parse("not (a until " * 18 + "b" + ")" * 18)
        with pytest.raises((Unusable, RecursionError)):
            parse("(" * 100_000 + "a" + ")" * 100_000)
        corners = [[Fraction(k), Fraction(k * k), Fraction(1)] for k in range(64)]
        assert len(hull_faces(corners, 3)) == 2  # both sides of the one plane, once each
        with pytest.raises(Unusable, match="too many points"):
            hull_faces([[Fraction(k), Fraction(k * k), Fraction(k**3)] for k in range(65)], 3)


def test_within_without_then_is_no_entry_of_a_mission() -> None:
    """It would be read as a visit at any time."""
    entry = {"visit": "a", "then": "b", "within": 1}
    of_entry(entry, Fraction(9), False)
    del entry["then"]
    with pytest.raises(Unusable, match="`within` without `then`"):
        of_entry(entry, Fraction(9), False)


def test_a_formula_of_many_boxes_is_turned_away_soon(tmp_path: Path) -> None:
    """120 boxes, each other edges: they cut a piece of the tube into more than 50,000 cells, and each cell asks all boxes."""
    files, names = recorded_files("courier"), [f"r{k}" for k in range(120)]
    regions = "".join(
        f'[[region]]\nname = "{name}"\nlower = [{k / 200}, {k / 300}]\nupper = [{8 - k / 200}, {6 - k / 300}]\n'
        for k, name in enumerate(names)
    )
    text = files["task.toml"].decode().replace("[[mission]]", f"{regions}[[mission]]", 1)
    certificate = certificate_of(files)
    claims = certificate["claims"]
    first = next(k for k, claim in enumerate(claims) if claim["property"] == "P10")
    claims.insert(first, {"property": "P10", "set": " and ".join(names), "on": [0, 64 * 1024], "margin": 30})
    message = is_turned_away({**with_certificate(files, certificate), "task.toml": text.encode()}, tmp_path)
    assert "good time" in message


def test_nested_choices_of_regions_are_turned_away_soon(tmp_path: Path) -> None:
    """Each is a choice of the one before, twice: 2^40 regions written out."""
    files = recorded_files("courier")
    regions = "".join(
        f'[[region]]\nname = "r{k}"\nany_of = ["{"dock" if k == 0 else f"r{k - 1}"}", "{"dock" if k == 0 else f"r{k - 1}"}"]\n'
        for k in range(40)
    )
    text = files["task.toml"].decode().replace("[[mission]]", regions + '[[mission]]\nvisit = "r39"\n[[mission]]', 1)
    message = is_turned_away({**files, "task.toml": text.encode()}, tmp_path, (UNUSABLE,))
    assert "good time" in message


def test_an_axis_with_a_tiny_period_is_turned_away_soon(tmp_path: Path) -> None:
    files = recorded_files("trolley")
    text = files["task.toml"].decode()
    text = text.replace("body = ", 'axes = ["x", "y"]\nperiodic = { y = 1e-9 }\nbody = ', 1)
    is_turned_away({**files, "task.toml": text.encode()}, tmp_path, (UNUSABLE,))


# ------------------------------------------------------------------------------------------------ size and depth

OVERSIZED: dict[str, tuple[str, bytes]] = {
    "a dotted key": ("toml", b"a." * 30_000 + b"b = 1\n"),
    "many dotted keys": ("toml", b"".join(b"a%d.b.c.d.e.f.g.h = 1\n" % k for k in range(40_000))),
    "lists in lists": ("toml", b"z = " + b"[" * 100_000),
    "a list of numbers": ("toml", b"body = [" + b"0.1, " * 500_000 + b"]\n"),
    "digits": ("toml", b"z = 0x" + b"f" * 3_000_000),
    "a task that is too large": ("toml", b"#" * 5_000_000),
    "a C file that is too large": ("c", b"\n" * 5_000_000),
    "a certificate of lists": ("json", b"[" * 100_000),
    "a certificate that is too large": ("json", b" " * 17_000_000),
}


@pytest.mark.parametrize("attack", OVERSIZED)
def test_a_file_beyond_a_bound_is_turned_away_soon(attack: str, tmp_path: Path) -> None:
    kind, data = OVERSIZED[attack]
    paths = [Path(argument) for argument in write_files(recorded_files("trolley"), tmp_path)]
    path = paths[("toml", "c", "json").index(kind)]
    path.write_bytes(data + path.read_bytes())
    with soon():
        code = check_files([str(argument) for argument in paths])
    assert code == UNUSABLE


def test_a_pipe_is_no_file_and_is_not_waited_for(tmp_path: Path) -> None:
    arguments = write_files(recorded_files("trolley"), tmp_path)
    os.mkfifo(tmp_path / "pipe")
    for k in range(3):
        assert check_files([*arguments[:k], str(tmp_path / "pipe"), *arguments[k + 1 :]]) == UNUSABLE
