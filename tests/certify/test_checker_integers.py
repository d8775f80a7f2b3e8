"""The stand-alone checker refuses other controllers in integers: C, headers, claims and tasks that are changed.

The tables of changes are texts of emitted C: (text that occurs in the file, its replacement)."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks import token_mutants
from benchmarks.mutations import checked_tube
from stt_codegen.checker.stt_checker import claims
from stt_codegen.checker.stt_checker.curves import check_curves
from stt_codegen.checker.stt_checker.exact import Refused, units_above
from stt_codegen.checker.stt_checker.integers import Integers
from stt_codegen.checker.stt_checker.starts import covered_starts
from tests.support.checked_files import (
    REFUSED,
    certificate_of,
    recorded_files,
    verdict,
    with_certificate,
    with_hashes,
    with_text,
)

# Changes of gantry's C: each replaces a statement of another kind, a constant, or an entry of a table.
GANTRY = [
    ("tick < 4000U", "tick <= 4000U"),
    ("running ? tick : 4000U", "running ? 4000U : tick"),
    ("tick < 4000U", "tick < 3999U"),
    ("gantry_low_bits(count, 65535)", "gantry_low_bits(count, 32767)"),
    ("gantry_high_product(34359738, count_low)", "gantry_high_product(34359739, count_low)"),
    ("passed < 2097151;\n    const int32_t place = early ? passed : 2097151", "passed < 2097150;\n    const int32_t place = early ? passed : 2097150"),
    ("gantry_shift_down(place, 16)", "gantry_shift_down(place, 15)"),
    ("segment * 4", "segment * 8"),
    ("*row = first;\n    *s = share;", "*row = share;\n    *s = first;"),
    ("gantry_shift_up(s, 12)", "gantry_shift_up(s, 13)"),
    ("sum = s_fine + square", "sum = s_fine - square"),
    ("sum * 3", "sum * 2"),
    ("268435456 - three_differences", "268435455 - three_differences"),
    ("difference_over ? difference : 0", "difference_over ? 0 : difference"),
    ("middle_rounded < 65535", "middle_rounded < 65534"),
    ("middle_raised + 8192", "middle_raised + 4096"),
    ("*w0 = first_weight;\n    *w1 = middle_weight;\n    *w2 = last_weight;", "*w2 = first_weight;\n    *w1 = middle_weight;\n    *w0 = last_weight;"),
    ("at_1 = at + 4;", "at_1 = at + 2;"),
    ("q2 - q1", "q1 - q2"),
    ("(int32_t)(int16_t)difference_1", "difference_1"),
    ("six_q1 = q1 * 6", "six_q1 = q0 * 6"),
    ("gantry_product(d1, w1)", "gantry_product(d1, w0)"),
    ("d2_weighted - d0_weighted", "d2_weighted + d0_weighted"),
    ("gantry_shift_down(outer, 15)", "gantry_shift_down(outer, 14)"),
    ("base_and_middle + outer_part;\n    return value;", "base_and_middle - outer_part;\n    return value;"),
    ("gantry_shift_down(bend_t, 16)", "gantry_shift_down(bend_t, 15)"),
    ("gantry_shift_down(slope_t, 17)", "gantry_shift_down(slope_t, 16)"),
    ("difference = level - fall", "difference = level + fall"),
    ("GANTRY_READ_16(gantry_levels[row])", "GANTRY_READ_8(gantry_levels[row])"),
    ("GANTRY_READ_16(gantry_slopes[row])", "GANTRY_READ_16(gantry_bends[row])"),
    ("e_times_h = gantry_high_product(e, h)", "e_times_h = gantry_high_product(e, reciprocal)"),
    ("size = limit_under ? unlimited : limit;\n    return size;", "size = limit_under ? unlimited : limit;\n    return unlimited;"),  # never limited
    ("limit_under ? unlimited : limit", "limit_under ? limit : unlimited"),
    ("lower_edge = gantry_edge_at(lower_at, w0, w1, w2);", "lower_edge = gantry_edge_at(upper_at, w0, w1, w2);"),
    ("lower[i] = lower_edge;", "lower[i] = upper_edge;"),
    ("x_over = (-268435456) < x_any", "x_over = (-26843545) < x_any"),
    ("x_i - lower_edge", "lower_edge - x_i"),
    ("width = to_lower + to_upper;", "width = to_lower - to_upper;"),
    ("difference = to_lower - to_upper;", "difference = to_upper - to_lower;"),
    ("131072", "262144"),  # a width that the tube may not have
    ("131072", "1"),
    ("wide ? width : 131072", "wide ? 131072 : width"),
    ("width_shift = gantry_leading(safe_width);", "width_shift = gantry_leading(width);"),
    ("gantry_shift_down(width_shifted, 26)", "gantry_shift_down(width_shifted, 27)"),
    ("gantry_low_bits(width_bits, 15)", "gantry_low_bits(width_bits, 31)"),
    ("upper_nearer = 0 < difference", "upper_nearer = difference < 0"),
    ("offset = upper_nearer ? difference : difference_minus;", "offset = upper_nearer ? difference_minus : difference;"),
    ("offset_under ? offset : safe_width", "offset_under ? offset : width"),
    ("e_under ? e_any : 1063134168", "e_under ? 1063134168 : e_any"),  # the clamp inverted
    ("1063134168", "1062000000"),  # which acts before e_max
    ("1063134168", "1073741823"),
    ("10736107", "11000000"),
    ("10736107", "9000000"),
    ("10736107", "0"),
    ("remainder = width_shifted - offset_shifted", "remainder = offset_shifted - width_shifted"),
    ("y_raised < 1073741823", "y_raised < 1073741824"),
    ("octave_rows = y_shift * 8;", "octave_rows = y_shift * 4;"),
    ("first_row = octave_rows + 8;", "first_row = octave_rows + 16;"),
    ("less_width_shift = shift_offset - width_shift;", "less_width_shift = shift_offset + width_shift;"),
    ("shift_any = less_width_shift - h_shift;", "shift_any = less_width_shift;"),
    ("shift_over ? shift_any : 0", "shift_over ? 0 : shift_any"),
    ("upper_nearer ? size_minus : size;", "upper_nearer ? size : size_minus;"),  # out of the tube
    ("u[i] = u_i;", "u[i] = size;"),
    ("inside = offset < width;", "inside = offset <= width;"),
    ("inside ? outside : true", "inside ? outside : false"),
    ("inside ? outside : true", "inside ? false : true"),
    ("outside = outside_next;", "outside = false;"),
    ("return outside ? GANTRY_OUTSIDE_TUBE : GANTRY_OK;", "return outside ? GANTRY_OK : GANTRY_OUTSIDE_TUBE;"),
    ("i < 2;", "i < 1;"),
    ("int32_t margin = 32768;", "int32_t margin = 65536;"),
    ("x_nearer ? to_upper : to_lower", "x_nearer ? to_lower : to_upper"),
    ("x_share_minus = (-1) - x_share;", "x_share_minus = 1 - x_share;"),
    ("less ? margin_x : margin", "less ? margin : margin_x"),
    # tables: an entry, a type, a length
    ("    3506, 34942, 3506, 34942,", "    3506, 34942, 3506, 34941,"),
    ("    61680,\n    58253,", "    61780,\n    58253,"),
    ("    61680,\n    58253,", "    61680,\n"),
    ("    7244,\n    6462,", "    7544,\n    6462,"),
    ("    392,\n    331,", "    892,\n    331,"),
    ("    1581,\n    1104,", "    -1581,\n    1104,"),
    ("    8,\n    8,\n    8,\n    7,", "    8,\n    8,\n    7,\n    7,"),
    ("    36658, 36658", "    36658, 36660"),
    ("    18, 18", "    18, 19"),
    ("    18, 18", "    17, 17"),
    ("    40265280, 40265280", "    40265280, 40265281"),
    ("    40265280, 40265280", "    80530560, 80530560"),
    ("const uint16_t gantry_levels[72]", "const int32_t gantry_levels[72]"),
    ("const uint8_t gantry_h_shifts[72]", "const uint8_t gantry_h_shifts[73]"),
    ("gantry_bends[72] GANTRY_FLASH", "gantry_bends[72]"),
    ("static const uint16_t gantry_slopes", "static uint16_t gantry_slopes"),
    # the helper functions of integer arithmetic
    ("((-3) >> 1 == -2) ? 1 : -1", "((-3) >> 1 == -2) ? 1 : 1"),
    ("return a >> n;", "return a / (1 << n);"),
    ("(n >= 16)) {", "(n >= 15)) {"),
    ("(16 - n)", "(15 - n)"),
    ("shifted >>= 8;", "shifted >>= 4;"),
    ("shifted &= 0x7fffffffU;", "shifted &= 0xffffffffU;"),
    ("(int32_t)signed_half * (int32_t)unsigned_half", "(int32_t)(signed_half * unsigned_half)"),
    ('__asm__("" : "+r"(signed_half), "+r"(unsigned_half));', '__asm__("nop" : "+r"(signed_half), "+r"(unsigned_half));'),
    ("return a * b;", "return b + a;"),
    ("((uint32_t)a & 0xffffU) * (uint32_t)b", "((uint32_t)a & 0xfffU) * (uint32_t)b"),
    ("if (shifted < 0x800000U) { shifted <<= 8; shift += 8; }", "if (shifted < 0x800000U) { shifted <<= 8; shift += 7; }"),
    ("(uint32_t)a & (uint32_t)mask", "(uint32_t)a | (uint32_t)mask"),
    ("#if defined(__AVR__)", "#if !defined(__AVR__)"),
    ("pgm_read_word", "pgm_read_byte"),
    ("#include <stdbool.h>", "#include <stdbool.h>\n#define outside false"),
    ("bool outside = false;", "bool outside = false;\n    if (tick == 7U) { return GANTRY_OK; }"),
    ("int32_t gantry_margin(", "int32_t gantry_more(void)\n{\n    return 0;\n}\n\nint32_t gantry_margin("),
]  # fmt: skip
CRANE = [
    ("middle_per_second + 16384", "middle_per_second + 8192"),
    ("43690);", "43691);"),
    ("difference_raised < 67108864", "difference_raised < 67108863"),
    ("crane_shift_down(first_and_half, 15)", "crane_shift_down(first_and_half, 14)"),
    ("complement = 268435456 - s_fine", "complement = 268435456 - square"),
    ("*r0 = first_weight;", "*r0 = last_weight;"),
    ("_per_second, 11)", "_per_second, 12)"),
    ("*rate = value_rate;", "*rate = value;"),
    ("43360, 42848", "43361, 42848"),
    ("x_over = (-67108864) < x_any", "x_over = (-268435456) < x_any"),
    ("v_i - lower_rate", "v_i - lower_edge"),
    ("v_to_lower + lower_part", "v_to_lower - lower_part"),
    ("crane_high_product(to_upper, filter_i)", "crane_high_product(to_lower, filter_i)"),
    ("width = z_to_lower + z_to_upper", "width = to_lower + to_upper"),
    ("65536 < width", "131072 < width"),
    ("x_above && x_below", "x_above && x_above"),
    ("inside = z_inside && x_inside", "inside = z_inside && z_inside"),
    ("inside ? outside : true", "z_inside ? outside : true"),
    ("z_smaller = margin_z < margin_x;", "z_smaller = margin_x < margin_z;"),
    ("z_smaller ? margin_z : margin_x", "z_smaller ? margin_x : margin_z"),
    ("z_lower = lower_rate + lower_part", "z_lower = lower_rate"),
    ("upper[i] = z_upper", "upper[i] = z_lower"),
]
GANTRY_HEADER = [
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
]
REASONS = "checker: refused: (" + "|".join((  # of a file that is not the listing, or of a table that is not the task's
    r"\w+\.[ch] has '.*' in line \d+ where the listing has ", "a C file has ", "the C has ", "the C's table ", "the curves of the C ", "the limits of the C ",
    "a row of the curves of the C ", "a table of the C ", "a filter or the smallest width in the C ", "a shift or a limit of the C ",
    "the gain of . in the C ", "u of . in the C ", "the certificate's start is not the tube's",
)) + ")"  # fmt: skip


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        *(("gantry.c", *pair) for pair in GANTRY),
        *(("crane.c", *pair) for pair in CRANE),
        *(("gantry.h", *pair) for pair in GANTRY_HEADER),
    ],
)
def test_another_controller_in_integers_is_refused_although_the_hashes_fit(file: str, old: str, new: str, tmp_path: Path) -> None:
    code, message = verdict(with_text(recorded_files(file[:-2], "fixed"), file, old, new), tmp_path)
    assert (code, bool(re.match(REASONS, message))) == (REFUSED, True), message


def test_c_without_one_of_its_lines_is_refused(tmp_path: Path) -> None:
    """Some lines of code, and some of the many lines of numbers. benchmarks/token_mutants.py changes single tokens."""
    files = recorded_files("gantry", "fixed")
    lines = re.sub(r"/\*.*?\*/", "", files["gantry.c"].decode(), flags=re.DOTALL).splitlines()
    code = [k for k, line in enumerate(lines) if line.strip() and not re.fullmatch(r"[-\d, ]+", line)]
    numbers = [k for k, line in enumerate(lines) if re.fullmatch(r"[-\d, ]+", line)]
    for k in (*code[::25], *numbers[::40]):
        text = "\n".join(lines[:k] + lines[k + 1 :]) + "\n"
        assert verdict(with_hashes({**files, "gantry.c": text.encode()}), tmp_path).code == REFUSED, lines[k]


@pytest.mark.parametrize(("task", "stride"), [("gantry", 300), ("crane", 500)])
def test_changed_tokens_of_integers_are_refused_unless_they_mean_the_same(task: str, stride: int) -> None:
    for mutant in token_mutants.token_mutants(task, stride):
        if token_mutants.is_accepted(token_mutants.changed_files(mutant, task), task):
            assert token_mutants.reason_for_same_meaning(mutant, task), mutant


# ------------------------------------------------------------------------------------------------ claims and tasks


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("gantry", lambda c: c["edge_error"].__setitem__(0, 3), "P7"),
        ("crane", lambda c: c["rate_error"].__setitem__(1, 5), "P7"),
        ("crane", lambda c: c["filter"].__setitem__(0, "1356/2048"), "filter|P1|P7|P9"),
        ("gantry", lambda c: c["control"].__setitem__("gain", ["112/1000", "111/1000"]), "the gain of x"),
        ("gantry", lambda c: c["control"].__setitem__("gain", ["11101/100000", "11101/100000"]), "the gain of x"),
        ("gantry", lambda c: c["control"].__setitem__("e_max", ["9/10", "99/100"]), "e_max"),
        ("gantry", lambda c: c["control"].__setitem__("u_max", ["3/5", "3/5"]), "u_max"),
        ("gantry", lambda c: c["sampled"].__setitem__("shift", ["1/100000", "1/100000"]), "P9"),
        ("gantry", lambda c: c.__setitem__("scalar", "float"), "integers"),
        ("gantry", lambda c: c["grid"].__setitem__("unit_bits", 21), "."),
        ("gantry", lambda c: c["sha256"].__setitem__("gantry.py", "0"), "SHA-256"),
        *(("gantry", lambda c, key=key, by=by: c["integers"].__setitem__(key, c["integers"][key] + by), ".")
          for key in ("clock_bits", "clock_scale", "smallest_width", "largest_e", "smallest_y", "u_bits") for by in (1, -1)),
        *(("crane", lambda c, key=key, by=by: c["integers"].__setitem__(key, c["integers"][key] + by), ".")
          for key in ("smallest_x_width", "rate_mantissa", "rate_shift", "rate_bits", "filter_bits") for by in (1, -1)),
        ("gantry", lambda c: c["integers"].__setitem__("u_bits", 26.0), "decimal"),
        ("gantry", lambda c: c["integers"].__setitem__("more", 1), "integers"),
        ("gantry", lambda c: c.__setitem__("integers", []), "integers"),
    ],
)  # fmt: skip
def test_a_wrong_claim_about_integers_is_refused(name: str, change: Callable[[Any], None], message: str, tmp_path: Path) -> None:
    files = recorded_files(name, "fixed")
    document = certificate_of(files)
    change(document)
    code, output = verdict(with_certificate(files, document), tmp_path)
    assert (code, bool(re.search(message, output))) == (REFUSED, True), output


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("tick_period = 0.001", "tick_period = 0.002", "other ticks"),
        ("tick_period = 0.001", "tick_period = 0.0010001", "no whole number of ticks"),
        ("prescribed_time = 4.0", "prescribed_time = 4.001", "other ticks"),
        ("period = 0.01 ", "period = 0.02 ", "P9|listing|sampled"),
        ("u_max = [0.6, 0.6]", "u_max = [0.7, 0.6]", "u_max"),
        ("u_max = [0.6, 0.6] ", "gain = 0.112\nu_max = [0.6, 0.6] ", "gain"),
        ("u_max = [0.6, 0.6] ", "e_max = 0.98\nu_max = [0.6, 0.6] ", "e_max"),
        ("u_max = [0.6, 0.6] ", "e_max = [0.98, 0.99]\nu_max = [0.6, 0.6] ", "no controller in integers"),
        ("u_max = [0.6, 0.6] ", 'outside = "stop"\nu_max = [0.6, 0.6] ', "no controller in integers"),
        ('scalar = "fixed" ', 'math = "inline"\nscalar = "fixed" ', "no controller in integers"),
        ("w_max = 0.02", "w_max = 0.3", "P9|sampled"),
    ],
)
def test_the_integers_of_another_task_are_not_verified(old: str, new: str, message: str, tmp_path: Path) -> None:
    code, output = verdict(with_text(recorded_files("gantry", "fixed"), "task.toml", old, new), tmp_path)
    assert code != 0
    assert re.search(message, output), output


# ------------------------------------------------------------------------------------------------ errors and ranges


def integers_of(name: str) -> Integers:
    """Return a recorded controller in integers as the checker reads it."""
    _, _, controller = checked_tube(recorded_files(name, "fixed"))
    assert controller is not None
    return controller


@pytest.mark.parametrize("name", ["gantry", "crane"])
def test_the_recorded_errors_are_the_smallest_that_the_checker_verifies(name: str) -> None:
    """So tool and checker have the same bounds, in whole units."""
    files = recorded_files(name, "fixed")
    certificate, (task, tube, controller) = certificate_of(files), checked_tube(files)
    assert controller is not None
    for order, key in enumerate(("edge_error", "rate_error")[: task.order]):
        unit = tube.unit * (tube.segments / task.t_c) ** order
        assert certificate[key] == [units_above(v, unit) for v in controller.arithmetic_error(tube, 20, order)]


def test_the_checkers_errors_of_the_table_of_curves_are_true_and_close() -> None:
    """Every value that a row of the table gives, at both ends of the interval that it stands for, against 1/d and H in doubles."""
    tables = integers_of("gantry").tables
    over, rise, base = check_curves(tables)
    t, places = np.arange(1 << 16), tables["h_shifts"]
    for row in range(len(places)):
        level, slope, bend = (tables[k][row] for k in ("levels", "slopes", "bends"))
        value = level - ((slope - (bend * t >> 16)) * t >> 17)
        octave, head = divmod(row - 16, 8)
        for offset in (0.0, 1.0 - 2.0**-14):
            if row < 16:
                error, bound = value * (16 + row + (t + offset) / 2**16) / 2**20 - 1, over
            else:
                e = 1 - (8 + head + (t + offset) / 2**16) / 2 ** (4 + octave)
                error, bound = value * 2.0 ** (places[row] - base) * e * (1 - e * e) / (8 * np.arctanh(e)) - 1, rise[row - 16][0]
            assert np.abs(error).max() <= bound * (1 + 1e-9)
            assert np.abs(error).max() >= bound / 3  # the bound is not far above the error


@pytest.mark.parametrize(
    ("table", "value"),
    [
        ("levels", 100),
        ("levels", 65536),
        ("bends", 1 << 15),
        ("slopes", 1 << 15),
        ("shift_offsets", 32),
        ("limits", -1),
    ],
)
def test_tables_with_which_a_value_may_leave_its_bits_are_refused(table: str, value: int) -> None:
    """They are refused by comparisons of numbers, not because the file is compared with the listing."""
    _, tube, controller = checked_tube(recorded_files("gantry", "fixed"))
    assert controller is not None
    controller.tables[table][-1] = value
    with pytest.raises(Refused, match="of the C"):  # noqa: PT012 (either of the two refuses)
        controller._check_ranges(tube)
        check_curves(controller.tables)


@pytest.mark.parametrize(("row", "value"), [(3, 1 << 20), (3, 1 << 28), (0, -(1 << 27))])
def test_steps_and_entries_of_a_tube_must_fit_their_bits(row: int, value: int) -> None:
    _, tube, controller = checked_tube(recorded_files("gantry", "fixed"))
    assert controller is not None
    controller._check_ranges(tube)
    tube.table[row][0] = (value, value + (1 << 15))
    with pytest.raises(Refused, match="step of the C's table"):
        controller._check_ranges(tube)


def test_a_tube_beyond_the_largest_x_is_refused() -> None:
    """All of it is moved there, so that its steps are as before."""
    _, tube, controller = checked_tube(recorded_files("gantry", "fixed"))
    assert controller is not None
    tube.table = [[(a + (1 << 26), b + (1 << 26)) for a, b in pairs] for pairs in tube.table]
    with pytest.raises(Refused, match="beyond the largest x"):
        controller._check_ranges(tube)


@pytest.mark.parametrize("name", ["start_lower", "filtered_start_upper"])
def test_a_bound_of_the_starts_beyond_32_bits_is_refused(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A compiler would cut it, and `covered` would be about other starts."""

    def far_starts(*arguments: Any) -> dict[str, list[Any]]:
        starts = covered_starts(*arguments)
        return {**starts, name: [*starts[name][:-1], starts[name][-1] + (1 << 32)]}

    monkeypatch.setattr(claims, "covered_starts", far_starts)
    code, message = verdict(recorded_files("crane", "fixed"), tmp_path)
    assert code == REFUSED
    assert "more than 32 bits" in message
