"""`compare` accepts the emitted code and reports small errors in it, and its reference is right."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from stt_codegen import reference
from stt_codegen.compare.comparison import compare, compare_backend
from stt_codegen.compare.points import random_states, random_times, with_trajectory
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.read.c import differences
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.program.targets.python.runner import GeneratedPython
from tests.support.controllers import NAMES, build_once, controller_of

QUANTITIES = ["tube", "tube rate", "e", "epsilon", "xi", "covered", "margin", "margins", "u", "status"]


@pytest.mark.parametrize("name", NAMES)
def test_every_backend_is_within_its_bounds_on_every_example_task(name: str, tool) -> None:
    tool("cc")
    task = controller_of(name).task
    rows = compare(task, 10_000)
    quantities = QUANTITIES + (["u at a tick", "status at a tick"] if task.emit.tick_period is not None else [])
    assert [r.backend for r in rows] == [b for b in ("CasADi", "C double", "Python", "C float") for _ in quantities]
    assert [r.quantity for r in rows] == quantities * 4
    assert min(r.points for r in rows) >= 10_000
    assert not [r for r in rows if not r.holds]


def test_no_bound_is_more_than_twenty_times_too_wide() -> None:
    """Errors reach a twentieth of every bound, except for truth values, so that an error of twenty times the usual is reported."""
    for row in compare(controller_of("omni_s2").task, 10_000):
        assert row.quantity in ("status", "covered") or row.share > 0.05


def with_changed_c(controller: EmittedController, old: str, new: str) -> EmittedController:
    text = controller.files["omni_s1.c"].decode()
    assert old in text
    return replace(controller, files={**controller.files, "omni_s1.c": text.replace(old, new, 1).encode()})


def changed_coefficient(controller: EmittedController) -> tuple[str, str]:
    """Return the literal of one coefficient in the table, and one that is larger by 64 units in the last place of 1."""
    text = controller.files["omni_s1.c"].decode()
    values = re.search(r"_coefficients\[140\] = \{(.*?)\};", text, re.DOTALL).group(1).split(",")
    old = values[41].strip()
    step = 64 * np.spacing(np.float32(1))
    return old, f"{float(np.float32(float(old.rstrip('F'))) + step):.9g}F"


MUTATIONS = [
    ("(-0.5F) : 0.5F", "(-0.5F) : 0.5001F", "u"),
    ("1.0F + v0", "1.00001F + v0", "xi"),
    ("logf(v0)", "log1pf(v0)", "epsilon"),
    ("const bool inside = 0.0F < distance", "const bool inside = -0.001F < distance", "status"),
    ("3.0F * v4", "3.00002F * v4", "tube"),
    ("v0 - s", "v0 + s", "tube rate"),
]


@pytest.mark.parametrize(("old", "new", "quantity"), MUTATIONS)
def test_a_small_error_in_the_c_is_reported_for_its_quantity(old: str, new: str, quantity: str) -> None:
    controller = with_changed_c(controller_of("omni_s1"), old, new)
    rows = compare_backend(controller, CompiledC, 3000)
    assert quantity in [r.quantity for r in rows if not r.holds]


def test_one_changed_coefficient_is_reported() -> None:
    emitted = controller_of("omni_s1")
    controller = with_changed_c(emitted, *changed_coefficient(emitted))
    rows = compare_backend(controller, CompiledC, 3000)
    assert not next(r for r in rows if r.quantity == "tube").holds


def test_points_have_the_type_of_the_backend_and_include_the_edges() -> None:
    controller = controller_of("omni_s1")
    design = controller.design
    t = random_times(controller.task, np.linspace(0, 9, 33), 10_000, "float")
    low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
    x = random_states(controller.task, low, high, "float")
    assert t.dtype == x.dtype == np.float32
    assert len(t) >= 10_000
    assert {0.0, 9.0, float(np.nextafter(np.float32(9), np.float32(10)))} <= {float(v) for v in t}
    assert t.min() < -1e20
    outside = ~np.all((low < x) & (x < high), axis=1)
    assert 0.1 < outside.mean() < 0.9
    assert np.abs(x).max() > 1e20


def test_the_reference_tube_is_the_spline_by_de_boors_recursion() -> None:
    from tests.certify.test_certificate import exact_edges

    design = controller_of("spacecraft").design
    for k in (0, 7, design.segments - 1):
        for s in (Fraction(0), Fraction(1, 3), Fraction(7, 8)):
            t = (k + s) * design.prescribed_time / design.segments
            low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, [float(t)])
            for i, (a, b) in enumerate(exact_edges(design, k, s)):
                # The tolerance covers the rounding of t to a double, times the speed of an edge.
                assert abs(float(low[0, i]) - float(a)) < 1e-14
                assert abs(float(high[0, i]) - float(b)) < 1e-14


def test_the_reference_rate_is_the_derivative_of_the_reference_tube() -> None:
    """The error of central differences is h^2/6 times the third derivative, which is constant on a segment."""
    design = controller_of("omni_s2").design
    t = np.random.default_rng(5).uniform(0.01, 8.99, 500)
    h = 1e-5
    third = np.abs(np.diff(design.bezier(), n=3, axis=3)).max() * 6 * float(design.unit) * float(32 / design.prescribed_time) ** 3
    before, after = (
        np.stack(reference.tube(design.integers(), design.unit, design.prescribed_time, (t + s * h).astype(np.longdouble)))
        for s in (-1, 1)
    )
    rate = np.stack(reference.tube_rate(design.integers(), design.unit, design.prescribed_time, t))
    assert np.abs((after - before) / (2 * h) - rate).max() <= third * h * h + 1e-9  # C2, so also across knots


def test_reference_imports_nothing_of_this_package() -> None:
    from pathlib import Path

    text = Path(reference.__file__).read_text()
    imports = re.findall(r"^(?:from|import) (\S+)", text, re.M)
    assert set(imports) == {"__future__", "collections.abc", "dataclasses", "fractions", "numpy", "numpy.typing"}


def test_generated_python_of_a_float_task_uses_the_float_constants() -> None:
    """Its values in double arithmetic are within P7's bound of those of the C in float."""
    controller = controller_of("omni_s1", "float")
    python, c = GeneratedPython(controller), CompiledC(controller)
    t = np.linspace(-1, 10, 500).astype(np.float32).astype(float)
    bound = np.array([float(v) for v in controller.certificate.edge_error])
    assert np.all(np.abs(np.stack(python.tube(t)) - np.stack(c.tube(t))) <= bound)


@pytest.mark.parametrize("name", ["omni_s1", "omni_s2", "mission_leg1"])
def test_the_points_include_a_closed_loop_that_keeps_the_tube_and_arrives(name: str) -> None:
    controller = controller_of(name)
    task, design = controller.task, controller.design
    t = random_times(task, np.linspace(0, float(task.prescribed_time), 33), 3000, "float")
    low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
    unset = np.full(low.shape, np.nan)
    x = with_trajectory(task, t, low, high, unset)
    loop = ~np.isnan(x[:, 0])
    assert np.unique(t[loop]).size >= 500
    assert ((low[loop] < x[loop]) & (x[loop] < high[loop])).all()
    last = x[loop][np.argmax(t[loop])]
    assert all(float(a) <= v <= float(b) for a, v, b in zip(task.target_set.lower, last, task.target_set.upper, strict=True))


@pytest.mark.parametrize("u_max", [None, 3, ["3", "4"]], ids=repr)
@pytest.mark.parametrize(
    ("name", "design", "emit"),
    [
        ("omni_s2", "refined", {}),
        ("omni_s2", "refined", {"math": "inline", "tick_period": "0.01"}),
        ("omni_s2", "refined", {"scalar": "double"}),
        ("omni_s1", "adaptive", {}),
    ],
)
def test_constants_by_component_agree_in_every_backend(name: str, design: str, emit: dict, u_max: object, tool) -> None:
    """Gain, clamp and limit differ by component. The C also reads back as its Program."""
    tool("gcc")
    task = controller_of(name).task.changed(
        tube={"design": design}, emit=emit, control={"gain": ["0.5", "0.25"], "e_max": ["0.99", "0.9"], "u_max": u_max}
    )
    rows = compare(task, 300)
    assert {r.backend for r in rows} == {"CasADi", "Python", "C double", "C float"}
    assert all(r.holds for r in rows), [r for r in rows if not r.holds]
    controller = build_once(task)
    assert not differences(controller.program, controller.files[f"{name}.h"].decode(), controller.files[f"{name}.c"].decode())
    assert ("u_max" in {t.name for t in controller.program.tables}) == (u_max is not None)
    with_equal_components = build_once(task.changed(control={"gain": ["0.5", "0.5"], "e_max": "0.99"}))
    assert not {"gain", "e_max", "least_share"} & {t.name for t in with_equal_components.program.tables}  # these are constants


@pytest.mark.parametrize("e_max", ["0.99999", "0.9999999", "0.001"])
def test_a_clamp_near_one_is_within_its_bounds(e_max: str, tool) -> None:
    """The reference computes 1 - e from the distance to the edge, as 1 - e of a rounded e would have a large error."""
    tool("cc")
    task = controller_of("omni_s2", "double").task.changed(control={"e_max": e_max})
    assert not [r for r in compare_backend(build_once(task), CompiledC, 3000) if not r.holds]
