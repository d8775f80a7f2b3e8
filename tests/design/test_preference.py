"""What a user may ask of a tube beside being safe: limits on speed and acceleration, and what width is given up for."""

from __future__ import annotations

import json
import re
from fractions import Fraction
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.suites.families import FAMILIES, arena_task
from stt_codegen.certify import checker
from stt_codegen.cli.main import app
from stt_codegen.design.spline_tubes.dimension_programs import PACE_TOLERANCE
from stt_codegen.design.spline_tubes.slowest_tube import smoothest_tube
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.report.figures.trade import trade_report
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.support.controllers import ROOT, built

refining = import_module("stt_codegen.design.refine")
OMNI = load_task(ROOT / "tasks" / "omni_s2.toml")
SOLVED = 1e-6  # what sums of some hundred second differences may differ by: each row is kept to 1e-9


def accelerations(controller: EmittedController) -> list[Fraction]:
    """By dimension the largest second derivative, from second differences of the control points: exact."""
    design = controller.design
    second = np.abs(np.diff(design.integers().astype(object), n=2, axis=0)).max(axis=(0, 2))  # control points are 6 units each
    return [6 * int(v) * design.unit * (design.segments / design.prescribed_time) ** 2 for v in second]


def checked(controller: EmittedController, task: Task, folder: Path) -> int:
    """The exit code of the stand-alone checker; tasks/omni_s2.toml with the options of the controller's [tube]."""
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    limits = [(n, getattr(task.tube, n)) for n in ("max_speed", "max_acceleration")]
    lines = [f"{n} = {[float(x) for x in v] if isinstance(v, tuple) else float(v)}\n" for n, v in limits if v is not None]
    for name, data in {
        **controller.files,
        "task.toml": re.sub(r"(?m)^\[tube\]\n", "[tube]\n" + "".join(lines), text).encode(),
    }.items():
        (folder / name).write_bytes(data)
    return checker.main([str(folder / n) for n in ("task.toml", "omni_s2.c", "omni_s2.certificate.json")])


# ------------------------------------------------------------------------------------------------ calm


@pytest.mark.parametrize("seed", [0, 5, 10, 15, 20, 30, 35])
def test_of_the_tubes_that_are_as_slow_the_one_that_bends_least_is_taken(seed: int) -> None:
    task = arena_task(FAMILIES["paper"], seed)
    search, shape = refining._search_preferred(task, refining._normalised_arena(task))
    calm = smoothest_tube(search.arena, search.start, shape)

    def bends(points: np.ndarray) -> float:
        return float(np.abs(np.diff(points, n=2, axis=2)).sum())

    def pace(points: np.ndarray) -> np.ndarray:
        return np.abs(np.diff(points[:, :, 1:], axis=2)).max(axis=(0, 2))

    assert bends(calm.points) <= bends(shape.points) + SOLVED
    assert (pace(calm.points) <= shape.paces + PACE_TOLERANCE + 1e-9).all()
    assert (calm.points[1] - calm.points[0] >= shape.width[:, None] - 1e-9).all()


def test_where_nothing_is_in_the_way_a_dimension_with_time_to_spare_goes_straight() -> None:
    """It bends only at the end, where the tube comes to rest: not more than its own speed allows."""
    controller = built(load_task(ROOT / "tasks" / "empty.toml"))
    points = controller.design.integers()[:, :, 0]
    moved = np.diff(points, axis=0)
    for i in range(points.shape[1]):
        bends = np.abs(np.diff(moved[:-2, i])).max()  # the last two bring it to rest
        assert bends <= 2  # every control point is rounded


# ------------------------------------------------------------------------------------------------ limits


@pytest.mark.parametrize("limits", [(0.7, 0.9), (2, 0.7), (0.6, 5)])
def test_every_component_keeps_to_its_own_speed(limits: tuple[float, float], tmp_path: Path) -> None:
    task = OMNI.changed(tube={"max_speed": limits})
    controller = built(task)
    assert all(v <= Fraction(str(most)) for v, most in zip(controller.certificate.speed, limits, strict=True))
    assert checked(controller, task, tmp_path) == 0


def test_a_task_that_one_bound_for_all_refuses_may_be_done_with_one_for_each() -> None:
    with pytest.raises(NotCertified, match=r"speed \(P6\)"):
        built(OMNI.changed(tube={"max_speed": 0.6}))
    assert built(OMNI.changed(tube={"max_speed": [0.6, 5]})).certificate.holds


def test_one_bound_for_all_is_that_bound_for_each() -> None:
    alone, each = (built(OMNI.changed(tube={"max_speed": v})) for v in (0.8, [0.8, 0.8]))
    assert alone.design == each.design


@pytest.mark.parametrize("most", [1, 0.6, 0.3, (1, 0.5)])
def test_accelerations_are_kept_by_both_edges_and_claimed(most: object, tmp_path: Path) -> None:
    task = OMNI.changed(tube={"max_acceleration": most})
    controller = built(task)
    found = accelerations(controller)
    assert all(a <= b for a, b in zip(found, task.max_acceleration or (), strict=True))
    assert checked(controller, task, tmp_path) == 0
    claims = json.loads(controller.files["omni_s2.certificate.json"])["claims"]
    assert [(c["property"], c.get("order")) for c in claims[-2:]] == [("P6", None), ("P6", 2)]
    assert claims[-1]["margin"] >= 0
    # a bound just below what the tube has is refused by both, one just above is not
    for factor, holds in ((1 - Fraction(1, 10**6), False), (1 + Fraction(1, 10**6), True)):
        bounds = [Fraction(f"{float(v * factor):.9g}") for v in found]
        other = OMNI.changed(tube={"max_acceleration": bounds})
        made = build_task(other, uncertified=True, tube=controller.design)
        assert made.certificate.holds == holds
        assert (checked(made, other, tmp_path) == 0) == holds


@pytest.mark.parametrize("tube", [{"max_acceleration": 0.2}, {"max_acceleration": [1, 0.25]}, {"max_speed": [0.61, 0.62]}])
def test_a_refusal_names_a_bound_and_a_time_that_would_do(tube: dict[str, object]) -> None:
    with pytest.raises(NotCertified) as caught:
        built(OMNI.changed(tube=tube))
    (option,) = tube
    told = re.search(r"raise tube.max_\w+ to (\[?[\d., ]+\]?),", str(caught.value))
    assert told is not None
    assert built(OMNI.changed(tube={option: json.loads(told[1])})).certificate.holds
    longer = re.search(r"prescribed_time to ([\d.]+) s", str(caught.value))
    assert longer is not None
    assert built(OMNI.changed(tube=tube, prescribed_time=longer[1])).certificate.holds


@pytest.mark.parametrize(
    ("family", "seed", "tube"),
    [
        ("dense12", 100, {"max_speed": [0.604212, 0.658266]}),
        ("dense12", 110, {"max_speed": [0.463206, 1.59693], "prefer": "wide"}),
        ("dense12", 137, {"max_speed": [0.823026, 0.568129], "max_acceleration": 2.77142}),
        ("paper", 202, {"max_speed": 0.677526, "max_acceleration": [1.44696, 0.303437]}),
        ("paper", 3, {"max_speed": 1e-3}),
        ("paper", 3, {"max_acceleration": 1e-7}),
        ("paper", 3, {"max_acceleration": 0.1, "max_speed": 0.1}),
    ],
)
def test_every_value_that_a_refusal_names_does(family: str, seed: int, tube: dict[str, object]) -> None:
    task = arena_task(FAMILIES[family], seed).changed(tube=tube)
    try:
        built(task)
    except NotCertified as caught:
        told = str(caught)
    else:
        return
    values = re.findall(r"(?:raise tube\.(max_\w+)|(prescribed_time)) to (\[[^]]*\]|[\d.e+-]+)", told)
    assert values, told
    for option, time, text in values:
        value = json.loads(text)
        change = {"prescribed_time": value} if time else {"tube": {option: value}}
        assert built(task.changed(**change)).certificate.holds, (told, option or time)


@pytest.mark.parametrize(
    ("family", "seed", "loose"),
    [("dense12", 334, 50), ("paper", 490, 50), ("dense12", 443, 50), ("paper", 1, 1e9), ("paper", 2, 5)],
)
def test_a_bound_that_the_tube_keeps_anyway_changes_nothing(family: str, seed: int, loose: float) -> None:
    task = arena_task(FAMILIES[family], seed)
    plain = built(task)
    own = [float(v) * 1.0005 for v in plain.certificate.speed]
    for bounds in (own, [own[0], loose], [loose, own[1]]):
        assert built(task.changed(tube={"max_speed": [f"{v:.7g}" for v in bounds]})).design == plain.design


@pytest.mark.parametrize("bounds", [[30, 1], [1, 1e5], [1000, 0.9], [1, 1e9]])
@pytest.mark.parametrize("seed", [0, 5, 10, 15])
def test_a_loose_bound_beside_a_tight_one_is_no_reason_for_haste(seed: int, bounds: list[float]) -> None:
    task = arena_task(FAMILIES["dense12"], 420 + seed)
    try:
        plain = built(task)
    except NotCertified:
        return
    made = built(task.changed(tube={"max_speed": bounds}))
    assert made.certificate.holds
    assert max(made.certificate.speed) <= 2.01 * max(plain.certificate.speed)


@pytest.mark.parametrize("design", ["adaptive", "literal"])
@pytest.mark.parametrize(("option", "value"), [("max_acceleration", 1), ("prefer", "slow")])
def test_what_only_a_refined_tube_can_do_is_refused_for_the_others(design: str, option: str, value: object) -> None:
    with pytest.raises(BadInput, match=f"tube.{option}"):
        OMNI.changed(tube={option: value, "design": design})
    with pytest.raises(BadInput, match=f"tube.{option}"):
        OMNI.changed(tube={option: value}).with_options(design)


# ------------------------------------------------------------------------------------------------ preferences


@pytest.mark.parametrize("seed", [1, 6, 11])
def test_no_tube_of_the_family_is_slower_wider_or_longer_proved_than_the_one_preferred_for_it(seed: int) -> None:
    report = trade_report(arena_task(FAMILIES["paper"], seed))
    by = {name: tube for tube in report.tubes for name in tube.preferred}
    assert set(by) == {"balanced", "slow", "wide", "period"}
    slowest = min(t.speed for t in report.tubes)
    assert by["slow"].speed <= refining.SLOWEST_TOLERANCE * slowest * (1 + 1e-5)  # the tables are rounded
    assert by["wide"].least_width >= max(t.least_width for t in report.tubes) - 1e-5
    # at gain 1/2, which the task leaves open, periods are searched for to CLOSE
    assert (by["period"].period or 0) >= 0.98 * max(t.period or 0 for t in report.tubes)
    for tube in report.tubes:
        assert tube.preferred or not any(other.beats(tube) for other in report.tubes)


@pytest.mark.slow
def test_pareto_prints_the_tubes_draws_them_and_writes_data(tmp_path: Path) -> None:
    task = str(ROOT / "tasks" / "trolley.toml")
    shown = CliRunner().invoke(app, ["design", task, "--pareto", "--picture", str(tmp_path)])
    assert shown.exit_code == 0
    assert all(word in shown.stdout for word in ("least width", "peak speed", "proved period", "balanced", "slow", "wide"))
    assert (tmp_path / "trolley-pareto.png").stat().st_size > 10_000
    data = json.loads(CliRunner().invoke(app, ["design", task, "--pareto", "--json"]).stdout)
    widths = [t["least_width"] for t in data["tubes"]]
    assert widths == sorted(widths, reverse=True)
    refused = CliRunner().invoke(app, ["design", task, "--design", "adaptive", "--pareto"])
    assert isinstance(refused.exception, BadInput)
