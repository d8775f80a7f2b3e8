"""Controllers in integers: nothing leaves 32 bits, C and Python compute the same, edges and law are what they stand for."""

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
from stt_codegen.controller.integers.constants import law_of
from stt_codegen.controller.integers.fixed_program import fixed_program
from stt_codegen.controller.integers.integer_kernels import (
    HALF_WORD,
    clock_of,
    rate_of,
    rates_kernel,
    segment_kernel,
    weights_kernel,
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
from tests.support.controllers import ROOT, built, interface_of

EXAMPLES = ("gantry", "crane")
SHAPES = ("omni_s2", "courier", "rover", *EXAMPLES, "base")


@cache
def made(name: str) -> EmittedController:
    return built(limited(load_task(ROOT / "tasks" / f"{name}.toml")))


def design_of(name: str) -> RefinedDesign:
    design = made(name).design
    assert isinstance(design, RefinedDesign)
    return design


# ------------------------------------------------------------------------------------------------ 32 bits


@pytest.mark.parametrize("name", SHAPES)
def test_nothing_leaves_32_bits_for_any_input(name: str) -> None:
    program, law = made(name).program, law_of(made(name).task, design_of(name))
    assert set(ranges(program, "tube")) >= {"lower", "upper"}
    most = max(law.limits)
    assert ranges(program, "control")["u"] == Span(-most, most)
    assert ranges(program, "margin")["margin"] == Span(-HALF_WORD, HALF_WORD // 2)


def changed(kernel: Kernel, name: str, by: int) -> Kernel:
    """The kernel with the last argument of one assignment changed."""
    body = [
        Assign(a.var, Op(a.value.name, (*a.value.args[:-1], integer(by))))
        if a.var.name == name and isinstance(a.value, Op)
        else a
        for a in kernel.body
    ]
    assert body != list(kernel.body)
    return replace(kernel, body=tuple(body))


@pytest.mark.parametrize(
    ("kernel", "name", "by", "told"),
    [
        ("edge", "q1_6", 20000, "q1_6: *may be|q1_6 may be"),  # beyond 32 bits
        ("weights", "after", 10, "not of 16 bits"),  # a factor of 18 bits
        ("segment", "share", 0x1FFFF, "not within 16 bits"),
        ("segment", "share", 0xFFFE, "is no mask"),
        ("segment", "segment", 9, r"coefficients\[.*\] of"),  # beyond its table
    ],
)
def test_what_may_leave_them_is_found(kernel: str, name: str, by: int, told: str) -> None:
    program = made("omni_s2").program
    kernels = tuple(changed(k, name, by) if k.name == kernel else k for k in program.kernels)
    with pytest.raises(OutOfRange, match=told):
        ranges(replace(program, kernels=kernels), "control")


def without_clamp(program: Program, name: str) -> Program:
    """The program's `control` with one clamp left out."""

    def body(statements: tuple) -> tuple:
        found = []
        for s in statements:
            if isinstance(s, Assign) and s.var.name == name:
                assert isinstance(s.value, Select)
                value = s.value.otherwise if isinstance(s.value.then, Const) else s.value.then
                found.append(Assign(s.var, value))
            else:
                found.append(replace(s, body=body(s.body)) if hasattr(s, "count") else s)
        return tuple(found)

    control = program.function("control")
    bent = replace(control, body=body(control.body))
    assert bent != control
    return replace(program, functions=tuple(bent if f.name == "control" else f for f in program.functions))


@pytest.mark.parametrize("name", ["x_near", "x_i", "off_held", "y_near", "e_width", "down"])
def test_clamps_without_which_a_value_leaves_its_type(name: str) -> None:
    with pytest.raises(OutOfRange):
        ranges(without_clamp(made("omni_s2").program, name), "control")


def test_clamps_without_which_a_value_means_another_thing() -> None:
    """y below 1, so that its row is one of H; |e| within what e_max says."""
    program, rows = made("omni_s2").program, len(curves.over_rows())
    law = law_of(made("omni_s2").task, design_of("omni_s2"))
    for name, row_is_of_h, held in (("", True, True), ("y", False, True), ("e", True, False)):
        found = ranges(without_clamp(program, name) if name else program, "control")
        assert (found["rise_row"].low >= rows) == row_is_of_h
        assert (found["e"].high <= law.top) == held


# ------------------------------------------------------------------------------------------------ the same everywhere


def c_of(controller: EmittedController, compiler: str, folder: Path, *flags: str) -> CompiledC:
    """Compiled with the strict flags, and every undefined behaviour an end."""
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    library, prefix = folder / "fixed.so", controller.task.name
    checks = ("-fsanitize=undefined", "-fsanitize-undefined-trap-on-error", *flags)
    subprocess.run([compiler, *STRICT, *checks, "-shared", "-fPIC", "-o", library, folder / f"{prefix}.c"], check=True)
    return CompiledC(controller, library=library)


def assert_same(controller: EmittedController, c: CompiledC, count: int, seed: int) -> None:
    python, given = (
        GeneratedPython(controller),
        dict(zip(("tick", "x", "v"), ticks_and_states(controller, controller.design, count, seed), strict=False)),
    )
    for f in controller.program.functions:
        inputs = [given[p.name] for p in f.inputs]
        for got, wanted in zip(c.call(f.name, *inputs), python.call(f.name, *inputs), strict=True):
            assert (got == wanted).all()


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("name", SHAPES)
def test_c_and_python_are_the_same_to_the_bit(name: str, compiler: str, tool, tmp_path) -> None:
    assert_same(made(name), c_of(made(name), tool(compiler), tmp_path), 1500, 3)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_a_million_inputs_are_the_same_to_the_bit(name: str, tool, tmp_path) -> None:
    c = c_of(made(name), tool("gcc"), tmp_path)
    for seed in range(100):
        assert_same(made(name), c, 10_000, seed)


def test_python_takes_whole_numbers_of_32_bits_alone() -> None:
    control = GeneratedPython(made("gantry")).module.control
    assert control(0, [1.0, 2]) == control(0, [1, 2])
    for tick, x in ((0, [0.5, 0]), (-1, [0, 0]), (2**32, [0, 0]), (0, [2**31, 0]), (0, [0]), (0.5, [0, 0])):
        with pytest.raises(ValueError, match="whole number|entries"):
            control(tick, x)


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_self_test_passes_and_finds_every_changed_coefficient(name: str, tool, tmp_path) -> None:
    controller = made(name)
    for file, data in controller.files.items():
        (tmp_path / file).write_bytes(data)
    (tmp_path / "main.c").write_text(f'#include "{name}.h"\nint main(void) {{ return {name}_selftest(); }}\n')

    def code(text: str) -> int:
        (tmp_path / f"{name}.c").write_text(text)
        sources = [tmp_path / file for file in ("main.c", f"{name}.c", f"{name}_selftest.c")]
        subprocess.run([tool("gcc"), *STRICT, "-o", tmp_path / "run", *sources], check=True)
        return subprocess.run([tmp_path / "run"], check=False).returncode

    text = controller.files[f"{name}.c"].decode()
    assert code(text) == 0
    head, rows = text.split("_coefficients[", 1)
    lines = rows.splitlines()
    places = [k for k, line in enumerate(lines) if line.startswith("    ") and line.strip()[0] in "-0123456789"]
    for k in places[: design_of(name).segments + 3][::4]:
        numbers = lines[k].split(",")
        numbers[0] = f"    {int(numbers[0]) + 2000}"
        assert code(head + "_coefficients[" + "\n".join([*lines[:k], ",".join(numbers), *lines[k + 1 :]])) != 0


ROW = ("levels", "slopes", "bends")


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_self_test_finds_a_wrong_row_of_the_curves_wherever_it_moves_u(name: str, tool, tmp_path) -> None:
    """Rows of H: where u is below its limit in the widest tube. Every row: where it is lost, which leaves no u."""
    controller = made(name)
    for file, data in controller.files.items():
        (tmp_path / file).write_bytes(data)
    (tmp_path / "main.c").write_text(f'#include "{name}.h"\nint main(void) {{ return {name}_selftest(); }}\n')
    lines = controller.files[f"{name}.c"].decode().splitlines()
    heads = [k for k, line in enumerate(lines) if line.startswith("static const") and any(f"_{t}[" in line for t in ROW)]
    law, rows = law_of(controller.task, design_of(name)), len(curves.over_rows())
    levels = [int(lines[heads[0] + 1 + k].strip(" ,")) for k in range(rows + 8 * law.octaves)]

    def noticed(row: int, *entries: int) -> bool:
        bent = [*lines]
        for head, entry in zip(heads, entries, strict=False):
            bent[head + 1 + row] = f"    {entry}" + ("," if bent[head + 1 + row].endswith(",") else "")
        (tmp_path / f"{name}.c").write_text("\n".join(bent) + "\n")
        sources = [tmp_path / file for file in ("main.c", f"{name}.c", f"{name}_selftest.c")]
        subprocess.run([tool("gcc"), "-O1", "-o", tmp_path / "run", *sources], check=True)
        return subprocess.run([tmp_path / "run"], check=False).returncode != 0

    assert len(heads) == len(ROW)
    assert not noticed(rows, levels[rows])
    assert all(noticed(row, 0, 0, 0) for row in range(rows, len(levels), 5))
    assert noticed(rows + 7, levels[rows + 7] + 60)  # next to the middle of the tube


def test_samples_are_at_ticks() -> None:
    with pytest.raises(BadInput, match=r"control\.period: is 0\.01, no whole number of ticks of 0\.003, .*; use 0\.009"):
        stt.parse(text_of("gantry", ("tick_period = 0.001", "tick_period = 0.003")))
    with pytest.raises(BadInput, match="--rate 333: samples come every 0.003003 s, and time is counted in ticks of 0.001 s"):
        made_here().simulate(rate=333)
    assert made_here().simulate(rate=500).kept


@cache
def made_here(name: str = "gantry") -> stt.Controller:
    return interface_of(built(stt.load(ROOT / "tasks" / f"{name}.toml")))


@pytest.mark.parametrize("name", ["crane", pytest.param("gantry", marks=pytest.mark.slow)])
def test_a_page_about_integers(name: str, tmp_path) -> None:
    page = made_here(name).report(tmp_path / "page.html", show=False)
    assert "at ticks" in Path(page).read_text()


# ------------------------------------------------------------------------------------------------ right


@pytest.mark.parametrize("name", SHAPES)
def test_p9_counts_that_a_state_is_measured_to_its_unit(name: str) -> None:
    """x is wrong by half a unit, for which `shift` has eps times the largest coordinate; v by half a unit a second, for which the
    error of the rates has two more."""
    task, design = made(name).task, design_of(name)
    errors_ = integer_errors.edge_error(design, made(name).program.tick or Fraction(1))
    shift = law_of_setting(task, errors_).shift
    assert all(s >= 2 * float(e) + float(design.unit) / 2 for s, e in zip(shift, errors_, strict=True))
    if design.filter:
        per_second = Fraction(design.segments) / design.prescribed_time
        tick = made(name).program.tick or Fraction(1)
        step = abs(design.integers()[1:] - design.integers()[:-1]).max(axis=(0, 2))
        own = integer_errors.rate_weight_error(rate_of(design), per_second)
        cut = [r / design.unit - int(d) * own for r, d in zip(integer_errors.rate_error(design, tick), step, strict=True)]
        assert min(cut) >= 4  # of two sums that are rounded down, v, and lambda times x


@pytest.mark.parametrize("name", SHAPES)
def test_edges_law_and_margin_are_within_what_is_derived(name: str) -> None:
    rows = compare_backend(made(name), GeneratedPython, 3000)
    assert {r.quantity for r in rows} >= {"tube", "u", "margin", "status"}
    assert all(r.holds for r in rows), [r for r in rows if not r.holds]
    assert max(r.share for r in rows if r.quantity == "tube") > 0.3  # a bound that much looser would hide an error


def test_edges_are_within_six_units_of_the_table() -> None:
    for name in SHAPES:
        design = design_of(name)
        assert max(integer_errors.edge_error(design, made(name).program.tick or Fraction(1))) <= 6 * design.unit


LAWS = [
    ("omni_s2", {"gain": Fraction(1, 2), "u_max": Fraction(4)}),
    ("omni_s2", {"gain": Fraction(20), "u_max": Fraction(1, 20)}),
    ("omni_s2", {"gain": Fraction(500), "u_max": Fraction(1000)}),
    ("omni_s2", {"gain": Fraction(-3), "u_max": Fraction(4), "e_max": Fraction(1, 2)}),
    ("omni_s2", {"gain": (Fraction(1, 10), Fraction(7)), "u_max": (Fraction(2), Fraction(40)), "e_max": Fraction(999, 1000)}),
    ("omni_s2", {"gain": Fraction(1), "u_max": Fraction(100), "e_max": Fraction(9, 10)}),
]


@pytest.mark.parametrize(("name", "control"), LAWS)
def test_every_gain_limit_and_clamp_is_right_or_refused(name: str, control: dict) -> None:
    """Where u is moved up it is beyond u_max: whatever the width, no |u| is too small."""
    task = limited(load_task(ROOT / "tasks" / f"{name}.toml"))
    task = task.model_copy(update={"control": task.control.model_copy(update=control)})
    try:
        controller = build_task(task, tube=design_of(name))
    except BadInput as refused:
        assert "control.u_max: in integers of 32 bits the least of u_max" in str(refused)
        assert control["u_max"] < 1
        return
    rows = compare_backend(controller, GeneratedPython, 1500)
    assert all(r.holds for r in rows), [r for r in rows if not r.holds]


@pytest.mark.parametrize(("rows", "curve"), [(curves.over_rows(), curves.over), (curves.rise_rows(9), curves.rise)])
def test_every_row_of_a_curve_is_within_its_error_everywhere(rows: tuple[curves.Row, ...], curve: curves.Curve) -> None:
    """All 2^16 places of every row at both of their ends, by the same integers; the truth in doubles, of which 2^-30 is forgiven:
    near y = 1 a double of H is that wrong."""
    t = np.arange(HALF_WORD, dtype=np.int64)
    for row in rows:
        down = row.slope - ((row.bend * t) >> 16)
        value = (row.level - ((down * t) >> (16 + curves.SLOPE_BITS))) * 2.0**row.places
        assert value.min() > 0
        assert value.max() < HALF_WORD * 2.0**row.places  # so that the last 16 bits are all of it
        at, value = float(row.begin) + float(row.length) * np.append(t, t + 1) / HALF_WORD, np.append(value, value)
        with np.errstate(divide="ignore", invalid="ignore"):
            true = (
                float(curves.OVER) / at if curve is curves.over else 4 * np.log1p(2 * (1 - at) / at) / ((1 - at) * at * (2 - at))
            )
        wrong = np.abs(value / true - 1)
        wrong = wrong[np.isfinite(wrong)]
        assert wrong.max() <= float(row.error(curve)) + 2.0**-30
        assert wrong.max() >= float(row.error(curve)) / 8


def test_the_steepness_of_the_rise_is_what_the_error_of_the_law_rests_on() -> None:
    """0 <= -y H'/H <= 3/2, and the curve is that of (13): k/d e H = k xi eps."""
    y = np.geomspace(1e-6, 1 - 1e-4, 200_001)
    rise = 4 * np.log((2 - y) / y) / ((1 - y) * y * (2 - y))
    steep = -np.diff(np.log(rise)) / np.diff(np.log(y))
    assert steep.min() >= 0
    assert steep.max() <= 1.5
    e = 1 - y
    assert np.allclose(e * rise, 2 * np.arctanh(e) * 4 / (1 - e**2), rtol=1e-10)
    assert all(
        abs(float(curves.rise(Fraction(v))) / (4 * math.log((2 - v) / v) / ((1 - v) * v * (2 - v))) - 1) < 1e-12
        for v in (0.01, 0.5, 0.9)
    )


@pytest.mark.parametrize("name", ["omni_s2", "courier", "crane"])
def test_a_tick_is_no_later_than_said(name: str) -> None:
    task, design = made(name).task, design_of(name)
    period = task.emit.tick_period or Fraction(1)
    clock = clock_of(design, period)
    kernel = segment_kernel(clock, design)
    ticks = np.arange(0, clock.last + 3, dtype=np.int64)
    row, s = integer_errors.at_all(kernel, {"tick": ticks})
    late = integer_errors.late(clock)
    for tick, first, place in zip(ticks.tolist(), row.tolist(), s.tolist(), strict=True):
        true = min(Fraction(tick) * period * design.segments / design.prescribed_time, Fraction(design.segments))
        assert abs(Fraction(first, 2 * design.dimension) + Fraction(place, HALF_WORD) - true) <= late


def test_rates_are_the_slopes_of_the_weights() -> None:
    """Of the outer weights (1 - s)^3 and s^3, and of the middle one 3 s + 3 s^2 - 2 s^3, in segments a second."""
    design = design_of("crane")
    per_second = Fraction(design.segments) / design.prescribed_time
    rate = integer_errors.rate_of(design)
    s = np.arange(0, HALF_WORD, 64, dtype=np.int64)
    found = integer_errors.at_all(rates_kernel(rate), {"s": s})
    x = s / HALF_WORD
    true = [3 * (1 - x) ** 2, 3 + 6 * x - 6 * x**2, 3 * x**2]
    bound = float(integer_errors.rate_weight_error(rate, per_second))
    wrong = sum(np.abs(w * 2.0**-rate.places - t * float(per_second)) for w, t in zip(found, true, strict=True))
    assert wrong.max() <= bound  # type: ignore[union-attr]
    w0, w1, w2 = (w.astype(float) for w in integer_errors.at_all(weights_kernel(), {"s": s}))
    assert np.abs(w0 * 2.0**-15 - (1 - x) ** 3).max() <= 2.0**-15
    assert np.abs(w1 * 2.0**-14 - (3 * x + 3 * x**2 - 2 * x**3)).max() <= 2.0**-14
    assert np.abs(w2 * 2.0**-15 - x**3).max() <= 2.0**-15


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_python_face_speaks_the_tasks_units(name: str) -> None:
    controller = stt.build(ROOT / "tasks" / f"{name}.toml")
    t_c = float(controller.task.prescribed_time)
    lower, upper = controller.tube([0.0, t_c / 3, t_c])
    design = controller.design
    true = reference.tube(design.integers(), design.unit, design.prescribed_time, np.array([0.0, t_c / 3, t_c]))
    tick_moves = float(max(controller.certificate.speed)) * float(controller.program.tick or 0) / 2
    assert np.allclose(np.stack([lower, upper]), np.stack(true).astype(float), atol=tick_moves + 6 * float(design.unit))
    x = (lower + upper) / 2
    speeds = () if controller.task.order == 1 else ([0.0, 0.0],)
    status, u = controller.control(0.0, x[0] + 0.1 * (upper[0] - lower[0]), *speeds)
    assert status == 0
    assert (u < 0).all()
    assert float(controller.margin(0.0, x[0], *speeds)) > 0.2
    for call in (lambda: controller.tube_rate(0.0), controller.casadi, lambda: controller.tube(math.inf)):
        with pytest.raises(BadInput):
            call()


# ------------------------------------------------------------------------------------------------ what has none


def text_of(name: str, *replaced: tuple[str, str]) -> str:
    text = (ROOT / "tasks" / f"{name}.toml").read_text()
    for old, new in replaced:
        assert old in text
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize(
    ("replaced", "told"),
    [
        (("tick_period = 0.001           # s\n", ""), r"emit\.tick_period: is missing"),
        (("u_max = [0.6, 0.6]            # m/s\n", ""), r"control\.u_max: is missing"),
        (("selftest = true", "rust = true"), r"emit\.rust \(--package rust\): is for floating point"),
        (("selftest = true", 'math = "inline"'), r'emit\.math = "inline": is for floating point'),
        (("period = 0.01 ", 'outside = "hold"\nperiod = 0.01 '), r"control\.outside: is for floating point"),
        (("period = 0.01 ", "e_max = [0.95, 0.99]\nperiod = 0.01 "), r"control\.e_max by component"),
    ],
)
def test_what_a_controller_in_integers_has_no_form_of_is_refused(replaced: tuple[str, str], told: str) -> None:
    with pytest.raises(BadInput, match=told):
        stt.parse(text_of("gantry", replaced))


def test_a_tube_a_gain_or_a_time_that_integers_do_not_hold_is_refused() -> None:
    task, design = limited(load_task(ROOT / "tasks" / "omni_s2.toml")), design_of("omni_s2")

    def with_control(**control: object) -> Task:
        return task.model_copy(update={"control": task.control.model_copy(update=control)})

    fast = replace(design, table=tuple(tuple((4 * a, 4 * b) for a, b in row) for row in design.table))
    with pytest.raises(BadInput, match=r"tube\.segments: a step of"):
        fixed_program(task, fast)
    for near in (10**6, 10**9, 10**10):
        with pytest.raises(BadInput, match=r"control\.e_max: is so near 1"):
            fixed_program(with_control(e_max=1 - Fraction(1, near)), design)
    with pytest.raises(BadInput, match=r"control\.gain: 1e-06 is so small beside u_max 1000000"):
        fixed_program(with_control(gain=Fraction(1, 10**6), u_max=Fraction(10**6)), design)
    with pytest.raises(BadInput, match=r"control\.u_max: in integers of 32 bits the least of u_max"):
        fixed_program(with_control(gain=Fraction(10**5), u_max=(Fraction(10**4), Fraction(1, 10))), design)
    with pytest.raises(BadInput, match="beyond 31 bits"):
        clock_of(design, Fraction(1, 10**9))


@pytest.mark.parametrize("segments", [4, 5, 8, 32, 1024])
def test_the_clock_of_a_mission_is_as_wrong_as_ticks_are(segments: int) -> None:
    """Whatever a tick and the number of segments; a mission's times may be wrong by so much."""
    table = design_of("gantry").table
    design = replace(design_of("gantry"), segments=segments, table=(table * segments)[: segments + 3])
    worst = Fraction(0)
    for count in (2, 1000, 2**14 - 1, 2**14, 2**20, 10**7):
        with suppress(BadInput):  # 31 bits do not hold it
            worst = max(worst, integer_errors.late(clock_of(design, design.prescribed_time / count)) / segments)
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


def test_a_tube_that_is_narrower_than_its_law_takes_it_to_be_is_refused() -> None:
    """Far from the origin units are coarse: this tube has 98, and the law would count it as 256 wide. Near an edge it would push
    back with a fiftieth of what is proved."""
    with pytest.raises(BadInput, match=r"tube\.min_width: the tube is 0\.0\d+ wide as it is emitted, .* needs 0\.125 here"):
        built(stt.parse(THIN))
    wider = THIN.replace("10.11", "10.4").replace("15.11", "15.4")
    made = built(stt.parse(wider))
    assert isinstance(made.design, RefinedDesign)
    assert all(
        narrow <= least for narrow, least in integer_errors.widths_held(made.task, made.design, law_of(made.task, made.design))
    )


def test_a_program_that_could_overflow_is_not_made(monkeypatch) -> None:
    monkeypatch.setattr("stt_codegen.controller.integers.frame.FARTHEST", 1 << 31)
    with pytest.raises(BadInput, match=r'emit\.scalar: "fixed" has too few bits'):
        build_program(limited(load_task(ROOT / "tasks" / "omni_s2.toml")), design_of("omni_s2"))


def test_the_header_names_units_ticks_and_no_bad_input() -> None:
    header = made("gantry").files["gantry.h"].decode()
    design = design_of("gantry")
    assert f"#define GANTRY_X_BITS {design.bits} " in header
    assert "#define GANTRY_TICKS UINT32_C(4000)" in header
    assert "#define GANTRY_TICKS_PROVED UINT32_C(10)" in header
    assert "BAD_INPUT" not in header
    assert "float" not in header.replace("No floating point", "")
    assert build(ROOT / "tasks" / "gantry.toml").files == made("gantry").files
    assert design_tube(made("gantry").task) == design


def test_macros_of_the_header_give_the_nearest_units(tool, tmp_path) -> None:
    for name, data in made("gantry").files.items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "units.c").write_text(
        '#include "gantry.h"\nint32_t units(int k) { static const int32_t v[] = { GANTRY_X(0.1), GANTRY_X(-0.1), GANTRY_U(0.6) };'
        " return v[k]; }\n"
    )
    subprocess.run([tool("gcc"), "-std=c99", "-shared", "-fPIC", "-o", tmp_path / "u.so", tmp_path / "units.c"], check=True)
    units = ctypes.CDLL(str(tmp_path / "u.so")).units
    design, law = design_of("gantry"), law_of(made("gantry").task, design_of("gantry"))
    want = [round(Fraction(1, 10) / design.unit), -round(Fraction(1, 10) / design.unit), round(Fraction(6, 10) * 2**law.u_bits)]
    assert [units(k) for k in range(3)] == want


def test_the_example_task_files_load() -> None:
    for name in EXAMPLES:
        assert load_task(ROOT / "tasks" / f"{name}.toml").emit.scalar == "fixed"
