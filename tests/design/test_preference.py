"""What a task may demand or prefer of its tube beyond safety: limits on speed and acceleration, slow, wide, or a long period."""

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
from benchmarks.suites.remedies import follow_remedies
from stt_codegen.checker import check_files
from stt_codegen.cli.main import app
from stt_codegen.design.spline_tubes.dimension_programs import PACE_TOLERANCE
from stt_codegen.design.spline_tubes.slowest_tube import smoothest_tube
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.report.figures.trade import trade_report
from stt_codegen.sampling.windows import refined_windows
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.support.controllers import ROOT, build_once

refine_module = import_module("stt_codegen.design.refine")
OMNI = load_task(ROOT / "tasks" / "omni_s2.toml")
BEND_TOLERANCE = 1e-6  # of sums of some hundred second differences, each of which is solved to 1e-9


def largest_accelerations(controller: EmittedController) -> list[Fraction]:
    """Return, by dimension, the largest second derivative of an edge, exactly, from second differences of the control points."""
    design = controller.design
    second = np.abs(np.diff(design.integers().astype(object), n=2, axis=0)).max(axis=(0, 2))  # control points are 6 units each
    return [6 * int(v) * design.unit * (design.segments / design.prescribed_time) ** 2 for v in second]


def exit_code_of_checker(controller: EmittedController, task: Task, folder: Path) -> int:
    """Write omni_s2's task with the limits of this one, and the controller's files; return the checker's exit code."""
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    limits = [(n, getattr(task.tube, n)) for n in ("max_speed", "max_acceleration")]
    lines = [f"{n} = {[float(x) for x in v] if isinstance(v, tuple) else float(v)}\n" for n, v in limits if v is not None]
    for name, data in {
        **controller.files,
        "task.toml": re.sub(r"(?m)^\[tube\]\n", "[tube]\n" + "".join(lines), text).encode(),
    }.items():
        (folder / name).write_bytes(data)
    return check_files([str(folder / n) for n in ("task.toml", "omni_s2.c", "omni_s2.certificate.json")])


# ------------------------------------------------------------------------------------------------ smooth tubes


@pytest.mark.parametrize("seed", [0, 5, 10, 15, 20, 30, 35])
def test_the_smoothest_tube_bends_less_and_is_as_slow_and_as_wide(seed: int) -> None:
    task = arena_task(FAMILIES["paper"], seed)
    search, shape = refine_module._search_preferred(task, refine_module._normalised_arena(task))
    smoothest = smoothest_tube(search.arena, search.start, shape)

    def total_bend(points: np.ndarray) -> float:
        return float(np.abs(np.diff(points, n=2, axis=2)).sum())

    def largest_steps(points: np.ndarray) -> np.ndarray:
        return np.abs(np.diff(points[:, :, 1:], axis=2)).max(axis=(0, 2))

    assert total_bend(smoothest.points) <= total_bend(shape.points) + BEND_TOLERANCE
    assert (largest_steps(smoothest.points) <= shape.paces + PACE_TOLERANCE + 1e-9).all()
    assert (smoothest.points[1] - smoothest.points[0] >= shape.width[:, None] - 1e-9).all()


def test_without_unsafe_sets_a_tube_goes_straight_until_it_comes_to_rest() -> None:
    """Only the last two steps, which bring the tube to rest, may differ from the others."""
    controller = build_once(load_task(ROOT / "tasks" / "empty.toml"))
    points = controller.design.integers()[:, :, 0]
    steps = np.diff(points, axis=0)
    for i in range(points.shape[1]):
        largest_bend = np.abs(np.diff(steps[:-2, i])).max()  # without the last two steps
        assert largest_bend <= 2  # every control point is rounded


# ------------------------------------------------------------------------------------------------ limits


@pytest.mark.parametrize("limits", [(0.7, 0.9), (2, 0.7), (0.6, 5)])
def test_every_component_keeps_its_own_max_speed(limits: tuple[float, float], tmp_path: Path) -> None:
    task = OMNI.changed(tube={"max_speed": limits})
    controller = build_once(task)
    assert all(v <= Fraction(str(limit)) for v, limit in zip(controller.certificate.speed, limits, strict=True))
    assert exit_code_of_checker(controller, task, tmp_path) == 0


def test_limits_by_component_admit_a_task_that_one_limit_for_all_refuses() -> None:
    with pytest.raises(NotCertified, match=r"speed \(P6\)"):
        build_once(OMNI.changed(tube={"max_speed": 0.6}))
    assert build_once(OMNI.changed(tube={"max_speed": [0.6, 5]})).certificate.holds


def test_one_limit_is_that_limit_for_every_component() -> None:
    with_one_limit, with_limits = (build_once(OMNI.changed(tube={"max_speed": v})) for v in (0.8, [0.8, 0.8]))
    assert with_one_limit.design == with_limits.design


@pytest.mark.parametrize("limit", [1, 0.6, 0.3, (1, 0.5)])
def test_accelerations_are_kept_by_both_edges_and_claimed(limit: object, tmp_path: Path) -> None:
    task = OMNI.changed(tube={"max_acceleration": limit})
    controller = build_once(task)
    largest = largest_accelerations(controller)
    assert all(a <= b for a, b in zip(largest, task.max_acceleration or (), strict=True))
    assert exit_code_of_checker(controller, task, tmp_path) == 0
    claims = json.loads(controller.files["omni_s2.certificate.json"])["claims"]
    assert [(c["property"], c.get("order")) for c in claims[-2:]] == [("P6", None), ("P6", 2)]
    assert claims[-1]["margin"] >= 0
    # Tool and checker refuse a bound just below the tube's acceleration, and accept one just above it.
    for factor, holds in ((1 - Fraction(1, 10**6), False), (1 + Fraction(1, 10**6), True)):
        bounds = [Fraction(f"{float(v * factor):.9g}") for v in largest]
        task_of_bounds = OMNI.changed(tube={"max_acceleration": bounds})
        controller_of_bounds = build_task(task_of_bounds, uncertified=True, tube=controller.design)
        assert controller_of_bounds.certificate.holds == holds
        assert (exit_code_of_checker(controller_of_bounds, task_of_bounds, tmp_path) == 0) == holds


@pytest.mark.parametrize("tube", [{"max_acceleration": 0.2}, {"max_acceleration": [1, 0.25]}, {"max_speed": [0.61, 0.62]}])
def test_a_refusal_names_a_limit_and_a_time_that_work(tube: dict[str, object]) -> None:
    (option,) = tube
    remedies = follow_remedies(OMNI.changed(tube=tube))
    assert [list(remedy) for remedy in remedies] == [["prescribed_time"], [f"tube.{option}"]]


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
def test_every_value_that_a_refusal_names_works(family: str, seed: int, tube: dict[str, object]) -> None:
    task = arena_task(FAMILIES[family], seed).changed(tube=tube)
    follow_remedies(task)


@pytest.mark.parametrize(
    ("family", "seed", "loose"),
    [("dense12", 334, 50), ("paper", 490, 50), ("dense12", 443, 50), ("paper", 1, 1e9), ("paper", 2, 5)],
)
def test_a_limit_that_the_tube_keeps_anyway_changes_nothing(family: str, seed: int, loose: float) -> None:
    task = arena_task(FAMILIES[family], seed)
    plain = build_once(task)
    just_above = [float(v) * 1.0005 for v in plain.certificate.speed]
    for bounds in (just_above, [just_above[0], loose], [loose, just_above[1]]):
        assert build_once(task.changed(tube={"max_speed": [f"{v:.7g}" for v in bounds]})).design == plain.design


@pytest.mark.parametrize("bounds", [[30, 1], [1, 1e5], [1000, 0.9], [1, 1e9]])
@pytest.mark.parametrize("seed", [0, 5, 10, 15])
def test_a_loose_limit_beside_a_tight_one_makes_no_fast_tube(seed: int, bounds: list[float]) -> None:
    task = arena_task(FAMILIES["dense12"], 420 + seed)
    try:
        plain = build_once(task)
    except NotCertified:
        return
    controller = build_once(task.changed(tube={"max_speed": bounds}))
    assert controller.certificate.holds
    assert max(controller.certificate.speed) <= 2.01 * max(plain.certificate.speed)


@pytest.mark.parametrize("design", ["adaptive", "literal"])
@pytest.mark.parametrize(("option", "value"), [("max_acceleration", 1), ("prefer", "slow")])
def test_options_of_refined_tubes_are_refused_for_other_designs(design: str, option: str, value: object) -> None:
    with pytest.raises(BadInput, match=f"tube.{option}"):
        OMNI.changed(tube={option: value, "design": design})
    with pytest.raises(BadInput, match=f"tube.{option}"):
        OMNI.changed(tube={option: value}).with_options(design)


# ------------------------------------------------------------------------------------------------ preferences


@pytest.mark.parametrize("seed", [1, 6, 11])
def test_each_preference_takes_the_best_of_the_tubes_in_the_trade_report(seed: int) -> None:
    report = trade_report(arena_task(FAMILIES["paper"], seed))
    by_preference = {name: tube for tube in report.tubes for name in tube.preferred}
    assert set(by_preference) == {"balanced", "slow", "wide", "period"}
    slowest = min(t.speed for t in report.tubes)
    assert by_preference["slow"].speed <= refine_module.SLOWEST_TOLERANCE * slowest * (1 + 1e-5)  # the tables are rounded
    assert by_preference["wide"].smallest_width >= max(t.smallest_width for t in report.tubes) - 1e-5
    # The search for periods, at gain 1/2, stops within 2 %.
    assert (by_preference["period"].period or 0) >= 0.98 * max(t.period or 0 for t in report.tubes)
    for tube in report.tubes:
        assert tube.preferred or not any(alternative.dominates(tube) for alternative in report.tubes)


def crossing_time(task: Task, design: RefinedDesign) -> float:
    """Return the least width over closing speed, in seconds, of a task of order 1: of the windows and those before them."""
    bounds = refined_windows(design)
    speeds = np.maximum(bounds.speed, np.concatenate([bounds.speed[:1], bounds.speed[:-1]]))
    return float((bounds.narrow / (speeds + [float(b.force) for b in task.plant_bounds])).min())


def test_a_drive_that_lags_gets_the_tube_with_the_largest_width_over_speed() -> None:
    plain = load_task(ROOT / "tasks" / "trolley.toml")
    task = plain.changed(plant={"lag": "0.05"})
    times = {design: crossing_time(task, design) for design in refine_module.family(task)}
    chosen, balanced = (refine_module.refine(v) for v in (task, task.changed(tube={"prefer": "balanced"})))
    assert balanced == refine_module.refine(plain)
    assert crossing_time(task, balanced) < max(times.values()) * 0.99
    assert crossing_time(task, chosen) >= max(times.values()) * (1 - 1e-3)  # the preference allows for rounding of the edges
    assert refine_module.refine(task.changed(tube={"prefer": "period"})) == chosen


def test_the_filter_of_a_drive_that_lags_is_somewhat_larger() -> None:
    """Near an edge the closing speed of v + lambda x falls with lambda; the largest lag that is proved is flat between 1 and 1.3 times."""
    plain = load_task(ROOT / "tasks" / "drone.toml").changed(tube={"filter": None, "prefer": "balanced"})
    lagging = plain.changed(plant={"lag": "0.04"})
    pairs = zip(refine_module.refine(plain).filter, refine_module.refine(lagging).filter, strict=True)
    assert all(1 < larger / rate < Fraction(13, 10) for rate, larger in pairs)


def test_with_a_drive_the_trade_report_has_periods_that_are_proved_with_it() -> None:
    task = load_task(ROOT / "tasks" / "trolley.toml").changed(plant={"lag": "0.05"}, control={"period": "0.005", "u_max": "3"})
    tubes = trade_report(task).tubes
    assert any(tube.period for tube in tubes)
    (balanced,) = (tube for tube in tubes if "balanced" in tube.preferred)
    assert balanced.period is not None
    assert balanced.gain is not None
    stated = task.changed(
        tube={"prefer": "balanced"}, control={"gain": list(balanced.gain), "period": round(balanced.period, 4) - 1e-4}
    )
    assert build_once(stated).certificate.holds
    with pytest.raises(NotCertified, match=r"period \(P9\)"):
        build_once(stated.changed(control={"period": round(balanced.period, 4) + 1e-4}))


@pytest.mark.slow
def test_pareto_prints_the_tubes_draws_them_and_writes_data(tmp_path: Path) -> None:
    task = str(ROOT / "tasks" / "trolley.toml")
    result = CliRunner().invoke(app, ["design", task, "--pareto", "--picture", str(tmp_path)])
    assert result.exit_code == 0
    assert all(word in result.stdout for word in ("least width", "peak speed", "proved period", "balanced", "slow", "wide"))
    assert (tmp_path / "trolley-pareto.png").stat().st_size > 10_000
    data = json.loads(CliRunner().invoke(app, ["design", task, "--pareto", "--json"]).stdout)
    widths = [t["least_width"] for t in data["tubes"]]
    assert widths == sorted(widths, reverse=True)
    refused = CliRunner().invoke(app, ["design", task, "--design", "adaptive", "--pareto"])
    assert isinstance(refused.exception, BadInput)
