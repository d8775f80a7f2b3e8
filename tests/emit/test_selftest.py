"""`emit.selftest` passes for every correct build, and fails for a wrong number, a wrong sign and arithmetic without NaN."""

from __future__ import annotations

import re
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from stt_codegen import reference
from stt_codegen.checker import check_files
from stt_codegen.compare.comparison import compare_backend
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.emit.selftest import selftest_suites
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.nodes import Status
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.task.load import parse_task
from tests.support.controllers import ROOT, build_once

TASK = (ROOT / "tasks" / "omni_s2.toml").read_text()
EMPTY = (ROOT / "tasks" / "empty.toml").read_text()
DRONE = (ROOT / "tasks" / "drone.toml").read_text()  # of order 2, sampled, with another lambda for z
ORDER_TWO = TASK.replace("min_width = 0.05", "min_width = 0.2") + "\n[plant]\norder = 2\n"  # without a limit of u
SLOW = ORDER_TWO.replace("prescribed_time = 9.0", "prescribed_time = 90.0")


def with_filter(text: str, value: str) -> str:
    """Return the text of a task of order 2 with this value of lambda."""
    return text.replace("min_width = 0.2", f"min_width = 0.2\nfilter = {value}")


@cache
def selftested(text: str, scalar: str = "float", design: str = "refined", more: str = "") -> EmittedController:
    return build_once(parse_task(f"{text}\n[emit]\nselftest = true\n{more}").with_options(design, scalar))


def selftest_result(
    controller: EmittedController, compiler: str, flags: list[str], folder: Path, mutation: tuple[str, str] | None = None
) -> int:
    """Compile the controller, with a change of its C if one is stated, and return the result of its self-test: 0 where it passes."""
    prefix = controller.task.name
    for name, data in controller.files.items():
        text = data.decode()
        if mutation is not None and name == f"{prefix}.c":
            assert mutation[0] in text
            text = text.replace(*mutation)
        (folder / name).write_text(text)
    (folder / "main.c").write_text(f'#include "{prefix}.h"\nint main(void) {{ return {prefix}_selftest(); }}\n')
    command = [compiler, *flags, "main.c", f"{prefix}.c", f"{prefix}_selftest.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return subprocess.run([folder / "main"], check=False).returncode


@pytest.mark.parametrize(
    ("text", "design", "more"),
    [
        (TASK, "refined", ""),
        (TASK, "refined", 'math = "inline"'),
        (TASK, "adaptive", ""),
        (ORDER_TWO, "refined", ""),
        (DRONE, "refined", 'math = "inline"\ntick_period = 0.005'),
    ],
    ids=["refined", "inline", "adaptive", "order 2", "drone"],
)
@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_every_correct_build_passes(text: str, design: str, more: str, scalar: str, compiler: str, tool, tmp_path) -> None:
    """The builds include fused multiply-add and any order of evaluation that the standard allows."""
    controller = selftested(text, scalar, design, more)
    for flags in (["-std=c99", "-O0"], ["-std=c99", "-O2"], ["-O3", "-mfma", "-ffp-contract=fast"]):
        assert selftest_result(controller, tool(compiler), flags, tmp_path) == 0, flags


@pytest.mark.parametrize(
    ("text", "mutation"),
    [
        (TASK, ("? (-0.5F) : 0.5F", "? 0.5F : 0.5F")),
        (TASK, ("? (-0.5F) : 0.5F", "? (-0.501F) : 0.5F")),
        (TASK, ("width * 0.005F", "width * 0.006F")),
        (TASK, ("const bool inside = 0.0F < distance", "const bool inside = -1.0F < distance")),
        (TASK, ("logf(v0)", "log2f(v0)")),
        (ORDER_TWO, ("? (-0.5F) : 0.5F", "? (-0.501F) : 0.5F")),
        (ORDER_TWO, ("z_width * 0.005F", "z_width * 0.006F")),
        (ORDER_TWO, ("inside = z_inside && x_inside", "inside = z_inside")),
        (ORDER_TWO, ("inside = z_inside && x_inside", "inside = x_inside")),
        (ORDER_TWO, ("x_inside = x_above && x_below", "x_inside = x_above")),
        (ORDER_TWO, ("x_inside = x_above && x_below", "x_inside = x_below")),
        (ORDER_TWO, ("to_lower * 1.2F", "to_lower * 1.205F")),
        (ORDER_TWO, ("to_upper * 1.2F", "to_upper * 1.205F")),
        (ORDER_TWO, ("width * 1.2F", "width * 1.205F")),
        (ORDER_TWO, ("v_to_lower + lower_part", "v_to_lower - lower_part")),
        (ORDER_TWO, ("lower_slope * 3.5555556F", "lower_slope * 3.58F")),
        (ORDER_TWO, ("upper_slope * 3.5555556F", "upper_slope * 3.58F")),
        (ORDER_TWO, ("upper_rate - v_i", "upper_rate - x_i")),
    ],
)
def test_a_wrong_controller_fails(text: str, mutation: tuple[str, str], tool, tmp_path) -> None:
    controller = selftested(with_filter(text, "1.2") if text is ORDER_TWO else text)
    assert selftest_result(controller, tool("gcc"), ["-O2"], tmp_path) == 0
    assert selftest_result(controller, tool("gcc"), ["-O2"], tmp_path, mutation) > 0


@pytest.mark.parametrize(
    "text",
    [
        EMPTY,
        TASK.replace("min_width = 0.05", "min_width = 0.05\nsegments = 32"),
        TASK.replace("min_width = 0.05", "min_width = 0.05\nsegments = 100"),
        ORDER_TWO,
        with_filter(
            SLOW, "[0.416, 0.5]"
        ),  # at 0.45 of a segment the second weight of a filtered edge is 0, with the first lambda
        DRONE,
    ],
    ids=["4", "32", "100", "order 2", "where weights cancel", "drone"],
)
def test_a_changed_entry_anywhere_in_a_table_fails(text: str, tool, tmp_path) -> None:
    """Each entry of an edge is changed by a twentieth of a metre (a 120th in the divided table), lambda by a hundredth."""
    controller = selftested(text)
    name = controller.task.name
    for file, data in controller.files.items():
        (tmp_path / file).write_bytes(data)
    source = (tmp_path / f"{name}.c").read_text()
    changes = {"coefficients": "+= 0.05F / 6.0F", "filter": "*= 1.01F"}
    tables = re.findall(rf"static const {name}_real {name}_({'|'.join(changes)})\[(\d+)\] = \{{", source)
    assert "coefficients" in dict(tables)
    # The tables become writable, and a main changes one entry after the other.
    for table, _ in tables:
        source = source.replace(f"static const {name}_real {name}_{table}[", f"static {name}_real {name}_{table}[")
    (tmp_path / f"{name}.c").write_text(source)
    loops = "".join(
        f"    for (int k = 0; k < {length}; k++) {{\n        const float original = {name}_{table}[k];\n"
        f"        {name}_{table}[k] {changes[table]};\n        if ({name}_selftest() == 0) return 2;\n"
        f"        {name}_{table}[k] = original;\n    }}\n"
        for table, length in tables
    )
    (tmp_path / "main.c").write_text(
        f'#include "{name}.c"\nint main(void)\n{{\n    if ({name}_selftest() != 0) return 1;\n{loops}    return 0;\n}}\n'
    )
    command = [tool("gcc"), "-std=c99", "-O1", "main.c", f"{name}_selftest.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"], check=False).returncode == 0


@pytest.mark.parametrize(
    ("text", "mutation"),
    [
        (TASK, ("running ? tick : 9000U", "running ? tick + 30U : 9000U")),
        (TASK, ("part / 1125.0F", "part / 1126.0F")),
        (TASK, ("place / 1125", "place / 1200")),
        (DRONE, ("running ? tick : 12000U", "running ? tick + 30U : 12000U")),
        (DRONE, ("part / 375.0F", "part / 376.0F")),
    ],
)
def test_wrong_time_in_ticks_fails(text: str, mutation: tuple[str, str], tool, tmp_path) -> None:
    controller = selftested(text, more="tick_period = 0.001")
    assert selftest_result(controller, tool("gcc"), ["-O2"], tmp_path) == 0
    assert selftest_result(controller, tool("gcc"), ["-O2"], tmp_path, mutation) > 0


@pytest.mark.parametrize(("text", "ticks"), [(ORDER_TWO, ""), (DRONE, "tick_period = 0.001")])
def test_points_of_order_2_leave_each_of_both_tubes_alone_on_both_sides(text: str, ticks: str) -> None:
    """By the reference the status is OK exactly if x and v + lambda x are inside. Some points leave only one of the tubes."""
    controller = selftested(text, more=ticks)
    design, n = controller.design, controller.task.dimension
    assert isinstance(design, RefinedDesign)
    table, t_c = design.integers(), design.prescribed_time
    filter_rate = np.array([float(v) for v in design.filter])
    for suite in selftest_suites(controller.task, design, controller.program):
        points = np.array([float(v) for v in suite.points.values]).reshape(-1, suite.points.row)
        t = np.array(suite.ticks) * 0.001 if suite.ticks else points[:, 0]
        x, v = points[:, -2 * n : -n], points[:, -n:]
        low, high = reference.tube(table, design.unit, t_c, t)
        low_rate, high_rate = reference.tube_rate(table, design.unit, t_c, t)
        shares = [
            np.asarray((point - a) / (b - a), dtype=float)
            for point, a, b in (
                (x, low, high),
                (v + filter_rate * x, low_rate + filter_rate * low, high_rate + filter_rate * high),
            )
        ]
        x_inside, filtered_inside = (((s > 0) & (s < 1)).all(axis=1) for s in shares)
        assert [status is Status.OK for status in suite.statuses] == (x_inside & filtered_inside).tolist()
        assert set(suite.statuses) == {Status.OK, Status.OUTSIDE_TUBE}
        for has_left, other_is_inside, share in (
            (~x_inside, filtered_inside, shares[0]),
            (~filtered_inside, x_inside, shares[1]),
        ):
            left_alone = share[has_left & other_is_inside]
            assert (left_alone < 0).all(axis=1).any()
            assert (left_alone > 1).all(axis=1).any()


@pytest.mark.parametrize("text", [ORDER_TWO, DRONE], ids=["order 2", "drone"])
def test_expected_u_of_order_2_is_known_to_less_than_a_hundredth(text: str) -> None:
    controller = selftested(text)
    (suite,) = selftest_suites(controller.task, controller.design, controller.program)
    low, high = (np.array([float(u) for u in table.values]) for table in (suite.low, suite.high))
    assert ((high - low) < 0.005 * np.maximum(np.abs(low), np.abs(high))).all()


def test_the_checker_verifies_files_with_a_self_test_of_order_2(tmp_path) -> None:
    controller = selftested(ORDER_TWO)
    for name, data in {**controller.files, "task.toml": f"{ORDER_TWO}\n[emit]\nselftest = true\n".encode()}.items():
        (tmp_path / name).write_bytes(data)
    assert check_files([str(tmp_path / f) for f in ("task.toml", "omni_s2.c", "omni_s2.certificate.json")]) == 0


@pytest.mark.parametrize("limit", ["0.3", "3.0", "1000.0"])
@pytest.mark.parametrize("gain", ["-0.5", "20.0"])
@pytest.mark.parametrize("task", [TASK, ORDER_TWO], ids=["order 1", "order 2"])
def test_correct_builds_with_saturation_and_other_gains_pass(task: str, limit: str, gain: str, tool, tmp_path) -> None:
    text = task.replace("gain = 0.5", f"gain = {gain}\nu_max = [{limit}, {limit}]")
    assert text != task
    controller = selftested(text)
    assert selftest_result(controller, tool("gcc"), ["-O2"], tmp_path) == 0


def test_the_header_of_another_design_is_refused(tool, tmp_path) -> None:
    float_controller, double_controller = selftested(TASK), selftested(TASK, "double")
    mixed = {**float_controller.files, "omni_s2_selftest.c": double_controller.files["omni_s2_selftest.c"]}
    for name, data in mixed.items():
        (tmp_path / name).write_bytes(data)
    result = subprocess.run([tool("gcc"), "-c", "omni_s2_selftest.c"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "of another design" in result.stderr


@pytest.mark.parametrize(
    ("text", "offset"), [(TASK, 8000), (ORDER_TWO, 1000), (DRONE, 1000)], ids=["order 1", "order 2", "drone"]
)
def test_a_float_far_from_the_origin_is_refused_for_a_self_test(text: str, offset: int, tool, tmp_path) -> None:
    """There roundings of floats would hide a wrong table; doubles do not."""
    moved = re.sub(
        r"^((?:initial_state|lower|upper|centre) = )\[(.*?)\]",
        lambda m: m[1] + str([round(float(v) + offset, 6) for v in m[2].split(",")]),
        text,
        flags=re.M,
    )
    with pytest.raises(BadInput, match=r"emit\.selftest: a float rounds too much .*double"):
        selftested(moved)
    assert selftest_result(selftested(moved, "double"), tool("gcc"), ["-O2"], tmp_path) == 0


@pytest.mark.parametrize("text", [TASK, ORDER_TWO], ids=["order 1", "order 2"])
def test_arithmetic_without_nan_fails_the_self_test(text: str, tool, tmp_path) -> None:
    """Without the refusal to compile with -ffast-math, the last vector fails."""
    controller = selftested(text)
    calls = int(re.findall(r"omni_s2_expected\[(\d+)\]", controller.files["omni_s2_selftest.c"].decode())[0])
    flags = ["-O2", "-ffinite-math-only", "-D__FINITE_MATH_ONLY__=0", "-Wno-builtin-macro-redefined"]
    assert selftest_result(controller, tool("gcc"), flags, tmp_path, ("#error", "#warning")) == calls + 1


def test_without_emit_selftest_there_is_no_self_test() -> None:
    files = build_once(parse_task(TASK)).files
    assert "omni_s2_selftest.c" not in files
    assert b"selftest" not in files["omni_s2.h"]


def test_an_adaptive_design_with_a_self_test_can_be_compared(tool) -> None:
    """Its probe has no `control` for a self-test to call."""
    tool("cc")
    controller = selftested(TASK, design="adaptive")
    assert all(r.holds for r in compare_backend(controller, CompiledC, 200))
