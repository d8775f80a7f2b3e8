"""`emit.selftest`: passes for every right build, fails for a wrong number, a wrong sign, and arithmetic without NaN."""

from __future__ import annotations

import re
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from stt_codegen import reference
from stt_codegen.certify import checker
from stt_codegen.compare.comparison import compare_backend
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.emit.selftest import selftest_suites
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.nodes import Status
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.task.load import parse_task
from tests.support.controllers import ROOT, built

TASK = (ROOT / "tasks" / "omni_s2.toml").read_text()
EMPTY = (ROOT / "tasks" / "empty.toml").read_text()
DRONE = (ROOT / "tasks" / "drone.toml").read_text()  # of order 2, sampled, with another lambda for z
SECOND = TASK.replace("min_width = 0.05", "min_width = 0.2") + "\n[plant]\norder = 2\n"  # nothing limits u
SLOW = SECOND.replace("prescribed_time = 9.0", "prescribed_time = 90.0")


def filtered(text: str, value: str) -> str:
    return text.replace("min_width = 0.2", f"min_width = 0.2\nfilter = {value}")


@cache
def selftested(text: str, scalar: str = "float", design: str = "refined", more: str = "") -> EmittedController:
    return built(parse_task(f"{text}\n[emit]\nselftest = true\n{more}").with_options(design, scalar))


def answer(
    controller: EmittedController, compiler: str, flags: list[str], folder: Path, bend: tuple[str, str] | None = None
) -> int:
    own = controller.task.name
    for name, data in controller.files.items():
        text = data.decode()
        if bend is not None and name == f"{own}.c":
            assert bend[0] in text
            text = text.replace(*bend)
        (folder / name).write_text(text)
    (folder / "main.c").write_text(f'#include "{own}.h"\nint main(void) {{ return {own}_selftest(); }}\n')
    command = [compiler, *flags, "main.c", f"{own}.c", f"{own}_selftest.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return subprocess.run([folder / "main"], check=False).returncode


@pytest.mark.parametrize(
    ("text", "design", "more"),
    [
        (TASK, "refined", ""),
        (TASK, "refined", 'math = "inline"'),
        (TASK, "adaptive", ""),
        (SECOND, "refined", ""),
        (DRONE, "refined", 'math = "inline"\ntick_period = 0.005'),
    ],
    ids=["refined", "inline", "adaptive", "order 2", "drone"],
)
@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_every_right_build_passes(text: str, design: str, more: str, scalar: str, compiler: str, tool, tmp_path) -> None:
    """Fused multiply-add and the compiler's own idea of order within the standard included."""
    controller = selftested(text, scalar, design, more)
    for flags in (["-std=c99", "-O0"], ["-std=c99", "-O2"], ["-O3", "-mfma", "-ffp-contract=fast"]):
        assert answer(controller, tool(compiler), flags, tmp_path) == 0, flags


@pytest.mark.parametrize(
    ("text", "bend"),
    [
        (TASK, ("? (-0.5F) : 0.5F", "? 0.5F : 0.5F")),
        (TASK, ("? (-0.5F) : 0.5F", "? (-0.501F) : 0.5F")),
        (TASK, ("room * 0.005F", "room * 0.006F")),
        (TASK, ("const bool within = 0.0F < nearest", "const bool within = -1.0F < nearest")),
        (TASK, ("logf(v0)", "log2f(v0)")),
        (SECOND, ("? (-0.5F) : 0.5F", "? (-0.501F) : 0.5F")),
        (SECOND, ("room3 * 0.005F", "room3 * 0.006F")),
        (SECOND, ("inside = within && between", "inside = within")),
        (SECOND, ("inside = within && between", "inside = between")),
        (SECOND, ("between = over && under", "between = over")),
        (SECOND, ("between = over && under", "between = under")),
        (SECOND, ("to_lower * 1.2F", "to_lower * 1.205F")),
        (SECOND, ("to_upper * 1.2F", "to_upper * 1.205F")),
        (SECOND, ("room * 1.2F", "room * 1.205F")),
        (SECOND, ("to_lower2 + filtered2", "to_lower2 - filtered2")),
        (SECOND, ("lower_slope * 3.5555556F", "lower_slope * 3.58F")),
        (SECOND, ("upper_slope * 3.5555556F", "upper_slope * 3.58F")),
        (SECOND, ("upper_rate - v_i", "upper_rate - x_i")),
    ],
)
def test_a_wrong_controller_fails(text: str, bend: tuple[str, str], tool, tmp_path) -> None:
    controller = selftested(filtered(text, "1.2") if text is SECOND else text)
    assert answer(controller, tool("gcc"), ["-O2"], tmp_path) == 0
    assert answer(controller, tool("gcc"), ["-O2"], tmp_path, bend) > 0


@pytest.mark.parametrize(
    "text",
    [
        EMPTY,
        TASK.replace("min_width = 0.05", "min_width = 0.05\nsegments = 32"),
        TASK.replace("min_width = 0.05", "min_width = 0.05\nsegments = 100"),
        SECOND,
        filtered(SLOW, "[0.416, 0.5]"),  # at 0.45 of a segment the second weight of a filtered edge is 0, with the first lambda
        DRONE,
    ],
    ids=["4", "32", "100", "order 2", "where weights cancel", "drone"],
)
def test_a_changed_entry_anywhere_in_a_table_fails(text: str, tool, tmp_path) -> None:
    """Every row, lower and upper edge, off by a twentieth of a metre (a 120th in the divided table); lambda by a hundredth."""
    controller = selftested(text)
    name = controller.task.name
    for file, data in controller.files.items():
        (tmp_path / file).write_bytes(data)
    source = (tmp_path / f"{name}.c").read_text()
    bends = {"coefficients": "+= 0.05F / 6.0F", "filter": "*= 1.01F"}
    tables = re.findall(rf"static const {name}_real {name}_({'|'.join(bends)})\[(\d+)\] = \{{", source)
    assert "coefficients" in dict(tables)
    # copies that can be written to, and a main that bends one entry after the other
    for table, _ in tables:
        source = source.replace(f"static const {name}_real {name}_{table}[", f"static {name}_real {name}_{table}[")
    (tmp_path / f"{name}.c").write_text(source)
    loops = "".join(
        f"    for (int k = 0; k < {length}; k++) {{\n        const float was = {name}_{table}[k];\n"
        f"        {name}_{table}[k] {bends[table]};\n        if ({name}_selftest() == 0) return 2;\n"
        f"        {name}_{table}[k] = was;\n    }}\n"
        for table, length in tables
    )
    (tmp_path / "main.c").write_text(
        f'#include "{name}.c"\nint main(void)\n{{\n    if ({name}_selftest() != 0) return 1;\n{loops}    return 0;\n}}\n'
    )
    command = [tool("gcc"), "-std=c99", "-O1", "main.c", f"{name}_selftest.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"], check=False).returncode == 0


@pytest.mark.parametrize(
    ("text", "bend"),
    [
        (TASK, ("running ? tick : 9000U", "running ? tick + 30U : 9000U")),
        (TASK, ("part / 1125.0F", "part / 1126.0F")),
        (TASK, ("place / 1125", "place / 1200")),
        (DRONE, ("running ? tick : 12000U", "running ? tick + 30U : 12000U")),
        (DRONE, ("part / 375.0F", "part / 376.0F")),
    ],
)
def test_wrong_time_in_ticks_fails(text: str, bend: tuple[str, str], tool, tmp_path) -> None:
    controller = selftested(text, more="tick_period = 0.001")
    assert answer(controller, tool("gcc"), ["-O2"], tmp_path) == 0
    assert answer(controller, tool("gcc"), ["-O2"], tmp_path, bend) > 0


@pytest.mark.parametrize(("text", "ticks"), [(SECOND, ""), (DRONE, "tick_period = 0.001")])
def test_of_order_2_either_tube_is_left_alone_and_a_status_says_so(text: str, ticks: str) -> None:
    """OK just where x and v + lambda x are inside, by the reference; both kinds of leaving one alone are there, on both sides."""
    controller = selftested(text, more=ticks)
    design, n = controller.design, controller.task.dimension
    assert isinstance(design, RefinedDesign)
    table, t_c = design.integers(), design.prescribed_time
    value = np.array([float(v) for v in design.filter])
    for suite in selftest_suites(controller.task, design, controller.program):
        points = np.array([float(v) for v in suite.points.values]).reshape(-1, suite.points.row)
        t = np.array(suite.ticks) * 0.001 if suite.ticks else points[:, 0]
        x, v = points[:, -2 * n : -n], points[:, -n:]
        low, high = reference.tube(table, design.unit, t_c, t)
        low_rate, high_rate = reference.tube_rate(table, design.unit, t_c, t)
        shares = [
            np.asarray((place - a) / (b - a), dtype=float)
            for place, a, b in ((x, low, high), (v + value * x, low_rate + value * low, high_rate + value * high))
        ]
        own, filtered_ = (((s > 0) & (s < 1)).all(axis=1) for s in shares)
        assert [status is Status.OK for status in suite.statuses] == (own & filtered_).tolist()
        assert set(suite.statuses) == {Status.OK, Status.OUTSIDE_TUBE}
        for left, other, share in ((~own, filtered_, shares[0]), (~filtered_, own, shares[1])):
            alone = share[left & other]
            assert (alone < 0).all(axis=1).any()
            assert (alone > 1).all(axis=1).any()


@pytest.mark.parametrize("text", [SECOND, DRONE], ids=["order 2", "drone"])
def test_of_order_2_a_float_tells_u_to_less_than_a_hundredth(text: str) -> None:
    controller = selftested(text)
    (suite,) = selftest_suites(controller.task, controller.design, controller.program)
    low, high = (np.array([float(u) for u in table.values]) for table in (suite.low, suite.high))
    assert ((high - low) < 0.005 * np.maximum(np.abs(low), np.abs(high))).all()


def test_the_stand_alone_checker_takes_a_self_test_of_order_2(tmp_path) -> None:
    controller = selftested(SECOND)
    for name, data in {**controller.files, "task.toml": f"{SECOND}\n[emit]\nselftest = true\n".encode()}.items():
        (tmp_path / name).write_bytes(data)
    assert checker.main([str(tmp_path / f) for f in ("task.toml", "omni_s2.c", "omni_s2.certificate.json")]) == 0


@pytest.mark.parametrize("limit", ["0.3", "3.0", "1000.0"])
@pytest.mark.parametrize("gain", ["-0.5", "20.0"])
@pytest.mark.parametrize("task", [TASK, SECOND], ids=["order 1", "order 2"])
def test_saturation_and_other_gains_pass_too(task: str, limit: str, gain: str, tool, tmp_path) -> None:
    text = task.replace("gain = 0.5", f"gain = {gain}\nu_max = [{limit}, {limit}]")
    assert text != task
    controller = selftested(text)
    assert answer(controller, tool("gcc"), ["-O2"], tmp_path) == 0


def test_another_designs_header_is_refused(tool, tmp_path) -> None:
    ours, other = selftested(TASK), selftested(TASK, "double")
    mixed = {**ours.files, "omni_s2_selftest.c": other.files["omni_s2_selftest.c"]}
    for name, data in mixed.items():
        (tmp_path / name).write_bytes(data)
    result = subprocess.run([tool("gcc"), "-c", "omni_s2_selftest.c"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "of another design" in result.stderr


@pytest.mark.parametrize(("text", "far"), [(TASK, 8000), (SECOND, 1000), (DRONE, 1000)], ids=["order 1", "order 2", "drone"])
def test_where_a_float_tells_too_little_that_is_said(text: str, far: int, tool, tmp_path) -> None:
    """So far from the origin that roundings hide a wrong table; doubles see it."""
    moved = re.sub(
        r"^((?:initial_state|lower|upper|centre) = )\[(.*?)\]",
        lambda m: m[1] + str([round(float(v) + far, 6) for v in m[2].split(",")]),
        text,
        flags=re.M,
    )
    with pytest.raises(BadInput, match=r"emit\.selftest: a float rounds too much .*double"):
        selftested(moved)
    assert answer(selftested(moved, "double"), tool("gcc"), ["-O2"], tmp_path) == 0


@pytest.mark.parametrize("text", [TASK, SECOND], ids=["order 1", "order 2"])
def test_arithmetic_without_nan_is_found(text: str, tool, tmp_path) -> None:
    """The refusal to compile with -ffast-math taken out: the last vector finds it."""
    controller = selftested(text)
    calls = int(re.findall(r"omni_s2_expected\[(\d+)\]", controller.files["omni_s2_selftest.c"].decode())[0])
    flags = ["-O2", "-ffinite-math-only", "-D__FINITE_MATH_ONLY__=0", "-Wno-builtin-macro-redefined"]
    assert answer(controller, tool("gcc"), flags, tmp_path, ("#error", "#warning")) == calls + 1


def test_without_the_request_there_is_none() -> None:
    files = built(parse_task(TASK)).files
    assert "omni_s2_selftest.c" not in files
    assert b"selftest" not in files["omni_s2.h"]


def test_the_comparison_of_an_adaptive_design_bears_the_request(tool) -> None:
    """Its probe has no `control` to call."""
    tool("cc")
    controller = selftested(TASK, design="adaptive")
    assert all(r.holds for r in compare_backend(controller, CompiledC, 200))
