"""Controllers in integers (`emit.scalar = "fixed"`): no value exceeds 32 bits, C and Python compute the same bits, and edges and
law are within their derived errors."""

from __future__ import annotations

import ctypes
import math
import subprocess
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import stt_codegen as stt
from benchmarks.fixed import limited
from stt_codegen import reference
from stt_codegen.certify.missions.proof import CLOCK
from stt_codegen.compare.comparison import compare_backend
from stt_codegen.compare.integer_comparison import ticks_and_states
from stt_codegen.controller.integers import curves, integer_errors
from stt_codegen.controller.integers.constants import build_integer_law
from stt_codegen.controller.integers.fixed_program import fixed_program
from stt_codegen.controller.integers.integer_kernels import (
    HALF_WORD,
    choose_clock,
    choose_rate_scale,
)
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController, build, build_program, build_task, design_tube
from stt_codegen.program.analyse.ranges import OutOfRange, Span, ranges
from stt_codegen.program.nodes import Assign, Const, Kernel, Op, Program, Select, integer
from stt_codegen.program.targets.c.runner import STRICT, CompiledC
from stt_codegen.program.targets.python.runner import GeneratedPython
from stt_codegen.sampling.sampled_loop import law_of as law_of_setting
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.support.controllers import ROOT, build_once, interface_of

EXAMPLES = ("gantry", "crane")
SHAPES = ("omni_s2", "courier", "rover", *EXAMPLES, "base")


@cache
def limited_controller(name: str) -> EmittedController:
    """Return the controller of an example task as `limited` changes it: in integers, with what integers need."""
    return build_once(limited(load_task(ROOT / "tasks" / f"{name}.toml")))


def design_of(name: str) -> RefinedDesign:
    """Return the design of `limited_controller(name)`."""
    design = limited_controller(name).design
    assert isinstance(design, RefinedDesign)
    return design


# ------------------------------------------------------------------------------------------------ 32 bits


@pytest.mark.parametrize("name", SHAPES)
def test_no_value_exceeds_32_bits_for_any_input(name: str) -> None:
    program, law = limited_controller(name).program, build_integer_law(limited_controller(name).task, design_of(name))
    assert set(ranges(program, "tube")) >= {"lower", "upper"}
    largest_limit = max(law.u_limits)
    assert ranges(program, "control")["u"] == Span(-largest_limit, largest_limit)
    assert ranges(program, "margin")["margin"] == Span(-HALF_WORD, HALF_WORD // 2)


def with_changed_argument(kernel: Kernel, name: str, value: int) -> Kernel:
    """Return the kernel with the last argument of one assignment replaced by an integer."""
    body = [
        Assign(a.var, Op(a.value.name, (*a.value.args[:-1], integer(value))))
        if a.var.name == name and isinstance(a.value, Op)
        else a
        for a in kernel.body
    ]
    assert body != list(kernel.body)
    return replace(kernel, body=tuple(body))


@pytest.mark.parametrize(
    ("kernel", "name", "value", "message"),
    [
        ("edge_at", "six_q1", 20000, "six_q1: *may be|six_q1 may be"),  # beyond 32 bits
        ("weights", "last_weight", 10, "not of 16 bits"),  # a factor of 18 bits
        ("segment", "share", 0x1FFFF, "not within 16 bits"),
        ("segment", "share", 0xFFFE, "is no mask"),
        ("segment", "segment", 9, r"coefficients\[.*\] of"),  # beyond its table
    ],
)
def test_a_value_that_may_exceed_its_bits_is_refused(kernel: str, name: str, value: int, message: str) -> None:
    program = limited_controller("omni_s2").program
    kernels = tuple(with_changed_argument(k, name, value) if k.name == kernel else k for k in program.kernels)
    with pytest.raises(OutOfRange, match=message):
        ranges(replace(program, kernels=kernels), "control")


def without_clamp(program: Program, name: str) -> Program:
    """Return the program with one clamp of `control` left out: its value is the clamp's input."""

    def without_it(statements: tuple) -> tuple:
        result = []
        for s in statements:
            if isinstance(s, Assign) and s.var.name == name:
                assert isinstance(s.value, Select)
                value = s.value.otherwise if isinstance(s.value.then, Const) else s.value.then
                result.append(Assign(s.var, value))
            else:
                result.append(replace(s, body=without_it(s.body)) if hasattr(s, "count") else s)
        return tuple(result)

    control = program.function("control")
    unclamped = replace(control, body=without_it(control.body))
    assert unclamped != control
    return replace(program, functions=tuple(unclamped if f.name == "control" else f for f in program.functions))


@pytest.mark.parametrize("name", ["x_raised", "x_i", "offset_limited", "y_raised", "safe_width", "shift"])
def test_without_one_of_these_clamps_a_value_may_exceed_its_type(name: str) -> None:
    with pytest.raises(OutOfRange):
        ranges(without_clamp(limited_controller("omni_s2").program, name), "control")


def test_without_one_of_these_clamps_a_value_has_another_meaning() -> None:
    """The clamp of y keeps it below 1, so that its row is one of H; the clamp of e keeps |e| within e_max."""
    program, rows = limited_controller("omni_s2").program, len(curves.reciprocal_pieces())
    law = build_integer_law(limited_controller("omni_s2").task, design_of("omni_s2"))
    for name, row_is_of_h, e_is_clamped in (("", True, True), ("y_limited", False, True), ("e_limited", True, False)):
        spans = ranges(without_clamp(program, name) if name else program, "control")
        assert (spans["y_row"].low >= rows) == row_is_of_h
        assert (spans["e_limited"].high <= law.largest_e) == e_is_clamped


# ------------------------------------------------------------------------------------------------ the same in C and Python


def compile_with_checks(controller: EmittedController, compiler: str, folder: Path, *flags: str) -> CompiledC:
    """Return the controller compiled with the strict flags; undefined behaviour ends the process."""
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    library, prefix = folder / "fixed.so", controller.task.name
    checks = ("-fsanitize=undefined", "-fsanitize-undefined-trap-on-error", *flags)
    subprocess.run([compiler, *STRICT, *checks, "-shared", "-fPIC", "-o", library, folder / f"{prefix}.c"], check=True)
    return CompiledC(controller, library=library)


def assert_c_and_python_agree(controller: EmittedController, compiled: CompiledC, count: int, seed: int) -> None:
    """Assert that C and Python give the same results for `count` random ticks and states."""
    python = GeneratedPython(controller)
    values = dict(zip(("tick", "x", "v"), ticks_and_states(controller, controller.design, count, seed), strict=False))
    for function in controller.program.functions:
        inputs = [values[p.name] for p in function.inputs]
        for from_c, from_python in zip(compiled.call(function.name, *inputs), python.call(function.name, *inputs), strict=True):
            assert (from_c == from_python).all()


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("name", SHAPES)
def test_c_and_python_are_the_same_to_the_bit(name: str, compiler: str, tool, tmp_path) -> None:
    assert_c_and_python_agree(
        limited_controller(name), compile_with_checks(limited_controller(name), tool(compiler), tmp_path), 1500, 3
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_a_million_inputs_are_the_same_to_the_bit(name: str, tool, tmp_path) -> None:
    c = compile_with_checks(limited_controller(name), tool("gcc"), tmp_path)
    for seed in range(100):
        assert_c_and_python_agree(limited_controller(name), c, 10_000, seed)


def test_python_accepts_only_whole_numbers_of_32_bits() -> None:
    control = GeneratedPython(limited_controller("gantry")).module.control
    assert control(0, [1.0, 2]) == control(0, [1, 2])
    for tick, x in ((0, [0.5, 0]), (-1, [0, 0]), (2**32, [0, 0]), (0, [2**31, 0]), (0, [0]), (0.5, [0, 0])):
        with pytest.raises(ValueError, match="whole number|entries"):
            control(tick, x)


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_self_test_passes_and_fails_with_a_changed_coefficient(name: str, tool, tmp_path) -> None:
    controller = limited_controller(name)
    for file, data in controller.files.items():
        (tmp_path / file).write_bytes(data)
    (tmp_path / "main.c").write_text(f'#include "{name}.h"\nint main(void) {{ return {name}_selftest(); }}\n')

    def exit_code(text: str) -> int:
        (tmp_path / f"{name}.c").write_text(text)
        sources = [tmp_path / file for file in ("main.c", f"{name}.c", f"{name}_selftest.c")]
        subprocess.run([tool("gcc"), *STRICT, "-o", tmp_path / "run", *sources], check=True)
        return subprocess.run([tmp_path / "run"], check=False).returncode

    text = controller.files[f"{name}.c"].decode()
    assert exit_code(text) == 0
    before_table, table_text = text.split("_coefficients[", 1)
    lines = table_text.splitlines()
    coefficient_lines = [k for k, line in enumerate(lines) if line.startswith("    ") and line.strip()[0] in "-0123456789"]
    for k in coefficient_lines[: design_of(name).segments + 3][::4]:
        numbers = lines[k].split(",")
        numbers[0] = f"    {int(numbers[0]) + 2000}"
        assert exit_code(before_table + "_coefficients[" + "\n".join([*lines[:k], ",".join(numbers), *lines[k + 1 :]])) != 0


CURVE_TABLES = ("levels", "slopes", "bends")  # a row of a curve has an entry in each


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_self_test_fails_with_a_wrong_row_of_the_curves_where_u_shows_it(name: str, tool, tmp_path) -> None:
    """A row of H shows where u is below its limit in the widest tube. Every row shows where it is 0, because then u is 0."""
    controller = limited_controller(name)
    for file, data in controller.files.items():
        (tmp_path / file).write_bytes(data)
    (tmp_path / "main.c").write_text(f'#include "{name}.h"\nint main(void) {{ return {name}_selftest(); }}\n')
    lines = controller.files[f"{name}.c"].decode().splitlines()
    first_lines = [
        k for k, line in enumerate(lines) if line.startswith("static const") and any(f"_{t}[" in line for t in CURVE_TABLES)
    ]
    law, rows = build_integer_law(controller.task, design_of(name)), len(curves.reciprocal_pieces())
    levels = [int(lines[first_lines[0] + 1 + k].strip(" ,")) for k in range(rows + 8 * law.octaves)]

    def is_noticed(row: int, *entries: int) -> bool:
        changed_lines = [*lines]
        for head, entry in zip(first_lines, entries, strict=False):
            changed_lines[head + 1 + row] = f"    {entry}" + ("," if changed_lines[head + 1 + row].endswith(",") else "")
        (tmp_path / f"{name}.c").write_text("\n".join(changed_lines) + "\n")
        sources = [tmp_path / file for file in ("main.c", f"{name}.c", f"{name}_selftest.c")]
        subprocess.run([tool("gcc"), "-O1", "-o", tmp_path / "run", *sources], check=True)
        return subprocess.run([tmp_path / "run"], check=False).returncode != 0

    assert len(first_lines) == len(CURVE_TABLES)
    assert not is_noticed(rows, levels[rows])
    assert all(is_noticed(row, 0, 0, 0) for row in range(rows, len(levels), 5))
    assert is_noticed(rows + 7, levels[rows + 7] + 60)  # next to the middle of the tube


def test_samples_come_at_whole_ticks() -> None:
    with pytest.raises(BadInput, match=r"control\.period: is 0\.01, no whole number of ticks of 0\.003, .*; use 0\.009"):
        stt.parse(text_of("gantry", ("tick_period = 0.001", "tick_period = 0.003")))
    with pytest.raises(BadInput, match="--rate 333: samples come every 0.003003 s, and time is counted in ticks of 0.001 s"):
        example_controller().simulate(rate=333)
    assert example_controller().simulate(rate=500).kept


@cache
def example_controller(name: str = "gantry") -> stt.Controller:
    """Return the controller of an example task in integers as a script gets it."""
    return interface_of(build_once(stt.load(ROOT / "tasks" / f"{name}.toml")))


@pytest.mark.parametrize("name", ["crane", pytest.param("gantry", marks=pytest.mark.slow)])
def test_the_report_of_a_controller_in_integers_speaks_of_ticks(name: str, tmp_path) -> None:
    page = example_controller(name).report(tmp_path / "page.html", show=False)
    assert "at ticks" in Path(page).read_text()


# ------------------------------------------------------------------------------------------------ errors of edges, law and margin


@pytest.mark.parametrize("name", SHAPES)
def test_p9_allows_for_the_rounding_of_a_measured_state_to_its_unit(name: str) -> None:
    """The error of x is half a unit; `shift` allows for it. That of v is half a unit a second; the error of the rates has two units
    more for it."""
    task, design = limited_controller(name).task, design_of(name)
    edge_errors = integer_errors.edge_error(design, limited_controller(name).program.tick or Fraction(1))
    shift = law_of_setting(task, edge_errors).shift
    assert all(s >= 2 * float(e) + float(design.unit) / 2 for s, e in zip(shift, edge_errors, strict=True))
    if design.filter:
        per_second = Fraction(design.segments) / design.prescribed_time
        tick = limited_controller(name).program.tick or Fraction(1)
        step = abs(design.integers()[1:] - design.integers()[:-1]).max(axis=(0, 2))
        weight_error = integer_errors.rate_weight_error(choose_rate_scale(design), per_second)
        rounding_units = [
            r / design.unit - int(d) * weight_error for r, d in zip(integer_errors.rate_error(design, tick), step, strict=True)
        ]
        assert min(rounding_units) >= 4  # of two sums that are rounded down, of v, and of lambda times x


@pytest.mark.parametrize("name", SHAPES)
def test_edges_law_and_margin_are_within_their_derived_errors(name: str) -> None:
    rows = compare_backend(limited_controller(name), GeneratedPython, 3000)
    assert {row.quantity for row in rows} >= {"tube", "u", "margin", "status"}
    assert all(row.holds for row in rows), [row for row in rows if not row.holds]
    assert max(row.share for row in rows if row.quantity == "tube") > 0.3  # a bound that is far looser would hide an error


def test_edges_are_within_six_units_of_the_table() -> None:
    for name in SHAPES:
        design = design_of(name)
        assert max(integer_errors.edge_error(design, limited_controller(name).program.tick or Fraction(1))) <= 6 * design.unit


LAWS = [
    ("omni_s2", {"gain": Fraction(1, 2), "u_max": Fraction(4)}),
    ("omni_s2", {"gain": Fraction(20), "u_max": Fraction(1, 20)}),
    ("omni_s2", {"gain": Fraction(500), "u_max": Fraction(1000)}),
    ("omni_s2", {"gain": Fraction(-3), "u_max": Fraction(4), "e_max": Fraction(1, 2)}),
    ("omni_s2", {"gain": (Fraction(1, 10), Fraction(7)), "u_max": (Fraction(2), Fraction(40)), "e_max": Fraction(999, 1000)}),
    ("omni_s2", {"gain": Fraction(1), "u_max": Fraction(100), "e_max": Fraction(9, 10)}),
]


@pytest.mark.parametrize(("name", "control"), LAWS)
def test_with_every_gain_limit_and_clamp_u_is_within_its_error_or_refused(name: str, control: dict) -> None:
    """u may be rounded up only where it exceeds u_max, so |u| is never too small."""
    task = limited(load_task(ROOT / "tasks" / f"{name}.toml"))
    task = task.model_copy(update={"control": task.control.model_copy(update=control)})
    try:
        controller = build_task(task, tube=design_of(name))
    except BadInput as refusal:
        assert "control.u_max: in integers of 32 bits the least of u_max" in str(refusal)
        assert control["u_max"] < 1
        return
    rows = compare_backend(controller, GeneratedPython, 1500)
    assert all(row.holds for row in rows), [row for row in rows if not row.holds]


@pytest.mark.parametrize(
    ("rows", "curve"), [(curves.reciprocal_pieces(), curves.scaled_reciprocal), (curves.h_pieces(9), curves.curve_h)]
)
def test_every_row_of_a_curve_is_within_its_error_everywhere(
    rows: tuple[curves.QuadraticPiece, ...], curve: curves.Curve
) -> None:
    """The test computes all 2^16 values of a row with the controller's integers, and compares at both ends of each value's interval.
    The truth is in doubles, whose own error of H is up to 2^-30 near y = 1."""
    t = np.arange(HALF_WORD, dtype=np.int64)
    for row in rows:
        slope = row.slope - ((row.bend * t) >> 16)
        value = (row.level - ((slope * t) >> (16 + curves.SLOPE_BITS))) * 2.0**row.shift
        assert value.min() > 0
        assert value.max() < HALF_WORD * 2.0**row.shift  # it fits into the last 16 bits
        argument, value = float(row.begin) + float(row.length) * np.append(t, t + 1) / HALF_WORD, np.append(value, value)
        with np.errstate(divide="ignore", invalid="ignore"):
            exact_value = (
                float(curves.RECIPROCAL_NUMERATOR) / argument
                if curve is curves.scaled_reciprocal
                else 4 * np.log1p(2 * (1 - argument) / argument) / ((1 - argument) * argument * (2 - argument))
            )
        relative_error = np.abs(value / exact_value - 1)
        relative_error = relative_error[np.isfinite(relative_error)]
        assert relative_error.max() <= float(row.relative_error(curve)) + 2.0**-30
        assert relative_error.max() >= float(row.relative_error(curve)) / 8


def test_the_rise_has_the_steepness_that_the_error_of_the_law_assumes() -> None:
    """0 <= -y H'/H <= 3/2, and the curve is that of the paper's equation (13): k/d e H = k xi eps."""
    y = np.geomspace(1e-6, 1 - 1e-4, 200_001)
    rise = 4 * np.log((2 - y) / y) / ((1 - y) * y * (2 - y))
    steepness = -np.diff(np.log(rise)) / np.diff(np.log(y))
    assert steepness.min() >= 0
    assert steepness.max() <= 1.5
    e = 1 - y
    assert np.allclose(e * rise, 2 * np.arctanh(e) * 4 / (1 - e**2), rtol=1e-10)
    assert all(
        abs(float(curves.curve_h(Fraction(v))) / (4 * math.log((2 - v) / v) / ((1 - v) * v * (2 - v))) - 1) < 1e-12
        for v in (0.01, 0.5, 0.9)
    )


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_interface_for_scripts_uses_the_tasks_units(name: str) -> None:
    controller = stt.build(ROOT / "tasks" / f"{name}.toml")
    t_c = float(controller.task.prescribed_time)
    lower, upper = controller.tube([0.0, t_c / 3, t_c])
    design = controller.design
    exact_edges = reference.tube(design.integers(), design.unit, design.prescribed_time, np.array([0.0, t_c / 3, t_c]))
    motion_in_half_a_tick = float(max(controller.certificate.speed)) * float(controller.program.tick or 0) / 2
    assert np.allclose(
        np.stack([lower, upper]), np.stack(exact_edges).astype(float), atol=motion_in_half_a_tick + 6 * float(design.unit)
    )
    x = (lower + upper) / 2
    speeds = () if controller.task.order == 1 else ([0.0, 0.0],)
    status, u = controller.control(0.0, x[0] + 0.1 * (upper[0] - lower[0]), *speeds)
    assert status == 0
    assert (u < 0).all()
    assert float(controller.margin(0.0, x[0], *speeds)) > 0.2
    for call in (lambda: controller.tube_rate(0.0), controller.casadi, lambda: controller.tube(math.inf)):
        with pytest.raises(BadInput):
            call()


# ------------------------------------------------------------------------------------------------ what has no form in integers


def text_of(name: str, *replacements: tuple[str, str]) -> str:
    """Return the text of a task file with these texts replaced."""
    text = (ROOT / "tasks" / f"{name}.toml").read_text()
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize(
    ("replacement", "message"),
    [
        (("tick_period = 0.001           # s\n", ""), r"emit\.tick_period: is missing"),
        (("selftest = true", "rust = true"), r"emit\.rust \(--package rust\): is for floating point"),
        (("selftest = true", 'math = "inline"'), r'emit\.math = "inline": is for floating point'),
        (("period = 0.01 ", 'outside = "hold"\nperiod = 0.01 '), r"control\.outside: is for floating point"),
        (("period = 0.01 ", "e_max = [0.95, 0.99]\nperiod = 0.01 "), r"control\.e_max by component"),
    ],
)
def test_options_without_a_form_in_integers_are_refused(replacement: tuple[str, str], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        stt.parse(text_of("gantry", replacement))


def test_a_tube_a_gain_or_a_time_beyond_32_bits_is_refused() -> None:
    task, design = limited(load_task(ROOT / "tasks" / "omni_s2.toml")), design_of("omni_s2")

    def with_control(**control: object) -> Task:
        return task.model_copy(update={"control": task.control.model_copy(update=control)})

    fast = replace(design, table=tuple(tuple((4 * a, 4 * b) for a, b in row) for row in design.table))
    with pytest.raises(BadInput, match=r"tube\.segments: a step of"):
        fixed_program(task, fast)
    for part in (10**6, 10**9, 10**10):
        with pytest.raises(BadInput, match=r"control\.e_max: is so near 1"):
            fixed_program(with_control(e_max=1 - Fraction(1, part)), design)
    with pytest.raises(BadInput, match=r"control\.gain: 1e-06 is so small beside u_max 1000000"):
        fixed_program(with_control(gain=Fraction(1, 10**6), u_max=Fraction(10**6)), design)
    with pytest.raises(BadInput, match=r"control\.u_max: in integers of 32 bits the least of u_max"):
        fixed_program(with_control(gain=Fraction(10**5), u_max=(Fraction(10**4), Fraction(1, 10))), design)
    with pytest.raises(BadInput, match="beyond 31 bits"):
        choose_clock(design, Fraction(1, 10**9))


@pytest.mark.parametrize("segments", [4, 5, 8, 32, 1024])
def test_the_time_error_of_missions_covers_that_of_ticks(segments: int) -> None:
    """P10 allows for `CLOCK["fixed"]` of t_c, for every tick and number of segments."""
    table = design_of("gantry").table
    design = replace(design_of("gantry"), segments=segments, table=(table * segments)[: segments + 3])
    worst = Fraction(0)
    for count in (2, 1000, 2**14 - 1, 2**14, 2**20, 10**7):
        with suppress(BadInput):  # beyond 31 bits
            worst = max(
                worst, integer_errors.segment_position_error(choose_clock(design, design.prescribed_time / count)) / segments
            )
    assert 0 < worst <= CLOCK["fixed"]
    assert worst > CLOCK["fixed"] / 5 * 4 or segments > 4


THIN = """
name = "thin"
prescribed_time = 100
initial_state = [10.05]
state_space = {lower = [0], upper = [1000]}
initial_set = {lower = [10], upper = [10.11]}
target_set = {lower = [15], upper = [15.11]}
tube = {clearance = 0.01, min_width = 0.005}
control = {gain = 0.01, u_max = [0.6]}
emit = {scalar = "fixed", tick_period = 0.001}
"""


def test_a_tube_narrower_than_the_width_that_its_law_assumes_is_refused() -> None:
    """Far from the origin units are coarse: this tube is 98 units wide, and the law would assume 256. Near an edge u would be a
    fiftieth of what is proved."""
    with pytest.raises(BadInput, match=r"tube\.min_width: the tube is 0\.0\d+ wide as it is emitted, .* needs 0\.125 here"):
        build_once(stt.parse(THIN))
    wider = THIN.replace("10.11", "10.4").replace("15.11", "15.4")
    controller = build_once(stt.parse(wider))
    assert isinstance(controller.design, RefinedDesign)
    assert all(
        assumed <= narrowest
        for assumed, narrowest in integer_errors.assumed_and_emitted_widths(
            controller.task, controller.design, build_integer_law(controller.task, controller.design)
        )
    )


def test_a_program_that_could_overflow_is_refused(monkeypatch) -> None:
    monkeypatch.setattr("stt_codegen.controller.integers.frame.LARGEST_STATE", 1 << 31)
    with pytest.raises(BadInput, match=r'emit\.scalar: "fixed" has too few bits'):
        build_program(limited(load_task(ROOT / "tasks" / "omni_s2.toml")), design_of("omni_s2"))


def test_the_header_defines_units_and_ticks_and_no_bad_input() -> None:
    header = limited_controller("gantry").files["gantry.h"].decode()
    design = design_of("gantry")
    assert f"#define GANTRY_X_BITS {design.bits} " in header
    assert "#define GANTRY_TICKS UINT32_C(4000)" in header
    assert "#define GANTRY_TICKS_PROVED UINT32_C(10)" in header
    assert "BAD_INPUT" not in header
    assert "float" not in header.replace("No floating point", "")
    assert build(ROOT / "tasks" / "gantry.toml").files == limited_controller("gantry").files
    assert design_tube(limited(load_task(ROOT / "tasks" / "gantry.toml"))) == design


def test_macros_of_the_header_give_the_nearest_units(tool, tmp_path) -> None:
    for name, data in limited_controller("gantry").files.items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "units.c").write_text(
        '#include "gantry.h"\nint32_t units(int k) { static const int32_t v[] = { GANTRY_X(0.1), GANTRY_X(-0.1), GANTRY_U(0.6) };'
        " return v[k]; }\n"
    )
    subprocess.run([tool("gcc"), "-std=c99", "-shared", "-fPIC", "-o", tmp_path / "u.so", tmp_path / "units.c"], check=True)
    units = ctypes.CDLL(str(tmp_path / "u.so")).units
    design, law = design_of("gantry"), build_integer_law(limited_controller("gantry").task, design_of("gantry"))
    nearest = [
        round(Fraction(1, 10) / design.unit),
        -round(Fraction(1, 10) / design.unit),
        round(Fraction(6, 10) * 2**law.u_bits),
    ]
    assert [units(k) for k in range(3)] == nearest


def test_the_example_task_files_load() -> None:
    for name in EXAMPLES:
        assert load_task(ROOT / "tasks" / f"{name}.toml").emit.scalar == "fixed"
