"""What a refusal names: the mildest changes that hold, verified; and how long the search for them may take."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from benchmarks.suites.demanding import task_text
from benchmarks.suites.families import FAMILIES, arena_task
from benchmarks.suites.remedies import follow_remedies, remedies_of
from stt_codegen import pipeline
from stt_codegen.design.linear_programs.solver import LinearProgram
from stt_codegen.effort import Effort, EffortSpent
from stt_codegen.errors import NotCertified, Reason
from stt_codegen.pipeline import build_task
from stt_codegen.remedies import CertificationTests, find_remedies
from stt_codegen.remedies.adjustments import adjustments_of
from stt_codegen.task import Task, load_task, parse_task
from tests.support.controllers import ROOT, controller_of

TOO_LONG = Reason("control.period is too long", codes=("P9",))
SLOW = Reason("no tube was found within tube.max_speed", codes=("P6",))


def sampled_task(period: str = "1") -> Task:
    return controller_of("omni_s2").task.changed(control={"period": period, "u_max": "2"})


def period_of(task: Task) -> Fraction:
    assert task.control.period is not None
    return task.control.period


def test_the_mildest_change_that_holds_is_named_to_within_its_halvings() -> None:
    for longest in ("0.9", "0.31", "0.07"):
        is_short = lambda task, longest=longest: period_of(task) <= Fraction(longest)  # noqa: E731
        (change,) = find_remedies(sampled_task(), TOO_LONG, CertificationTests(is_short, is_short)).changes
        ((key, value),) = change.edits
        assert key == "control.period"
        assert isinstance(value, Fraction)
        assert Fraction(longest) * Fraction("0.8") <= value <= Fraction(longest)


def test_a_change_that_the_quick_test_admits_and_the_certificate_refuses_is_not_named() -> None:
    """The stronger change that is certified is named in its place."""
    may_hold, holds = (lambda task: period_of(task) <= Fraction("0.5")), (lambda task: period_of(task) <= Fraction("0.3"))
    (change,) = find_remedies(sampled_task(), TOO_LONG, CertificationTests(may_hold, holds)).changes
    assert holds(change.of(sampled_task()))
    assert not find_remedies(sampled_task(), TOO_LONG, CertificationTests(may_hold, lambda _: False)).changes


def test_where_no_option_alone_is_enough_several_change_together_and_none_that_could_stay() -> None:
    def holds(task: Task) -> bool:
        return period_of(task) <= Fraction("0.5") and task.prescribed_time >= 20

    (change,) = find_remedies(sampled_task(), TOO_LONG, CertificationTests(holds, holds)).changes
    assert {edit.key for edit in change.edits} == {"control.period", "prescribed_time"}
    assert holds(change.of(sampled_task()))


@pytest.mark.parametrize("needed", [("0.3", "9"), ("0.3", "0.2")])
def test_a_change_that_contains_one_already_named_is_not_named(needed: tuple[str, str]) -> None:
    """The first entry is changed alone, and then both; both are named only where one alone is not enough."""
    task = sampled_task().changed(tube={"clearance": ["0.6", "0.4"]})

    def holds(changed: Task) -> bool:
        assert isinstance(changed.tube.clearance, tuple)
        return all(v <= Fraction(limit) for v, limit in zip(changed.tube.clearance, needed, strict=True))

    reason = Reason("too near", codes=("P4",), axis=0)
    changes = find_remedies(task, reason, CertificationTests(holds, holds)).changes
    (clearance,) = [edit.value for change in changes for edit in change.edits if edit.key == "tube.clearance"]
    assert isinstance(clearance, tuple)
    assert (clearance[1] == Fraction("0.4")) == (needed[1] == "9")


def test_a_search_that_finds_nothing_names_what_it_tried() -> None:
    task = arena_task(FAMILIES["paper"], 0).changed(tube={"max_speed": "0.1"})
    sentence = find_remedies(task, SLOW, CertificationTests(lambda _: False, lambda _: False)).sentence("widen it", "")
    assert sentence.startswith("no change that was tried was enough, of ")
    assert "widen it" not in sentence  # a hint that nobody tried, behind what was tried
    assert "prescribed_time" in sentence
    assert "tube.max_speed" in sentence


def test_the_search_ends_when_its_time_is_over_with_what_it_knows() -> None:
    """The time is over at the third trial, when one change is admitted."""
    trials: list[Task] = []

    def may_hold(task: Task) -> bool:
        trials.append(task)
        if len(trials) > 2:
            raise EffortSpent
        return period_of(task) <= Fraction("0.9")

    remedies = find_remedies(sampled_task(), TOO_LONG, CertificationTests(may_hold, lambda _: True))
    assert not remedies.is_complete
    assert remedies.sentence("", "--effort SECONDS").endswith("tried (--effort SECONDS)")
    assert remedies.sentence("", "").endswith("before every option was tried")
    assert [edit.key for change in remedies.changes for edit in change.edits] == ["control.period"]


def test_a_refusal_goes_to_another_process_with_its_reason() -> None:
    refusal = pickle.loads(pickle.dumps(NotCertified(lambda: Reason("no way leads", "move it", codes=("P4",), axis=1))))
    assert (str(refusal), refusal.reason.codes, refusal.reason.axis) == ("no way leads; move it", ("P4",), 1)


@pytest.mark.parametrize("seed", [36])
def test_what_another_preference_certifies_is_certified_without_one(seed: int) -> None:
    """Plants of order 2 whose preferred tube is refused, while the one for long periods is not."""
    task = arena_task(FAMILIES["paper"], seed).changed(
        plant={"order": 2, "w_max": "0.1"}, control={"period": "0.01", "u_max": "3"}
    )
    stated = task.changed(tube={"prefer": "balanced"})
    assert build_task(task.changed(tube={"prefer": "period"})).certificate.holds
    preferred = pipeline.attempt(stated, pipeline.STAGES["refined"].design_tube(stated))
    assert not preferred.certificate.holds
    controller = build_task(task)
    assert controller.certificate.holds
    chosen, design, program = designed(task)
    assert design == controller.design
    assert pipeline.certify(chosen, design, program).holds
    width, speed = float(controller.certificate.minimum_width), float(max(controller.certificate.speed))
    assert "the preferred tube is not certified (period (P9): " in controller.replaces
    assert f"least width {width:.4g} in place of {float(preferred.certificate.minimum_width):.4g}" in controller.replaces
    assert f"peak speed {speed:.4g} in place of" in controller.replaces
    assert not build_task(task.changed(tube={"prefer": "period"})).replaces


LINE = """
name = "line"
prescribed_time = {time}
initial_state = [{start}]
state_space = {{ lower = [0], upper = [5] }}
initial_set = {{ lower = [{low}], upper = [{high}] }}
target_set = {{ lower = [4], upper = [4.8] }}
control = {{ period = {period} }}
plant = {{ order = 2, w_max = 0.24, noise = {noise} }}
"""
LATE_VISIT = """
name = "late"
prescribed_time = 12
initial_state = [0.5, 0.5]
state_space = { lower = [0, 0], upper = [10, 10] }
initial_set = { lower = [0.2, 0.2], upper = [0.8, 0.8] }
target_set = { lower = [5, 0.2], upper = [5.8, 0.8] }
tube = { min_width = 0.5 }
region = [{ name = "a", lower = [4, 7.5], upper = [4.505, 8.005] }]
mission = [{ visit = "a", between = [8.4, 11.4] }]
"""


@pytest.mark.parametrize(
    ("text", "changes"),
    [
        (LINE.format(time=5.7, start=0.87, low=0.38, high=1.36, period=0.111, noise=0), {"control": {"u_max": "1.97"}}),
        (
            LINE.format(time=7.1, start=0.58, low=0.36, high=0.8, period=0.0863, noise=0.007),
            {"tube": {"filter": "2.5"}, "control": {"u_max": "4"}},
        ),
        (LATE_VISIT, {"tube": {"segments": 512}}),
    ],
    ids=["control.u_max", "tube.filter", "tube.segments"],
)
def test_what_a_stated_option_certifies_is_certified_where_it_is_open(
    text: str, changes: Mapping[str, Mapping[str, object]]
) -> None:
    """The first option is the one that is open; the other ones are stated in both tasks."""
    (table, options), *stated_tables = changes.items()
    task = parse_task(text).changed(**dict(stated_tables))
    assert build_task(task.changed(**{table: options})).certificate.holds
    assert build_task(task).certificate.holds


def designed(task: Task) -> tuple[Task, pipeline.Design, pipeline.Program]:
    """Return what the stages by themselves make of a task."""
    design = pipeline.design_tube(task)
    chosen = pipeline.with_chosen_control(task, design)
    return chosen, design, pipeline.build_program(chosen, design)


@pytest.mark.parametrize(("kind", "seed"), [("input", 1), ("passage", 3), ("speed", 1), ("mission", 2)])
def test_every_remedy_of_a_drawn_task_is_true(kind: str, seed: int) -> None:
    """`python -m benchmarks refusals` does this for 200 tasks."""
    assert follow_remedies(parse_task(task_text(kind, seed)))


def test_remedies_are_read_from_the_text_as_it_is_printed() -> None:
    message = (
        "limits (P8): no tube; certified with control.u_max = [1, 2.5], or without mission[1] (visit a, or b), or with tube.clearance = 0 "
        'and control.gain = "auto"; the time was over before every option was tried (--effort SECONDS)'
    )
    assert remedies_of(message) == [
        {"control.u_max": [1, 2.5]},
        {"mission[1]": None},
        {"tube.clearance": 0, "control.gain": "auto"},
    ]


def test_the_solver_prints_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    program = LinearProgram(1)
    program.cost[0], program.lower[0] = 1.0, 2.0
    program.add_rows([[0]], [1.0], 3.0, np.inf)
    assert program.solve() == pytest.approx([3.0])
    assert capfd.readouterr() == ("", "")


def test_design_certify_and_build_agree_about_the_tube() -> None:
    task = arena_task(FAMILIES["paper"], 36).changed(control={"period": "0.01", "u_max": "3"})
    design = pipeline.design_tube(task)
    assert design == build_task(task).design
    assert pipeline.attempt(task, design).certificate.holds


def test_a_search_without_time_ends_in_the_reason() -> None:
    """Working out a reason takes linear programs, which the limit of the search must not end."""
    for task in (arena_task(FAMILIES["paper"], 0).changed(tube={"max_speed": "0.1"}), sampled_task("5")):
        with pytest.raises(NotCertified, match="the time was over before every option was tried"):
            build_task(task, effort=Effort(0.0))


@pytest.mark.parametrize("stage", ["_other_attempt", "_is_certified"])
def test_ctrl_c_ends_the_search_on_the_command_line_and_is_the_callers_in_python(
    stage: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(pipeline, stage, interrupt)
    task = sampled_task("5")
    for is_wanted in (True, False):  # a tube that fails is not the answer to Ctrl-C, --uncertified or not
        if stage == "_is_certified" and is_wanted:
            continue  # then there is no search for changes
        with pytest.raises(NotCertified, match="control.period = 5 s is too long"):
            build_task(task, is_wanted, effort=Effort(ends_on_interrupt=True))
        with pytest.raises(KeyboardInterrupt):
            build_task(task, is_wanted, effort=Effort())


def test_an_option_of_the_command_line_is_no_key_of_the_file_to_change() -> None:
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    keys = {key for a in adjustments_of(task.with_options("literal", "float"), Reason("")) for key in a.keys}
    assert "prescribed_time" in keys
    assert not keys & {"tube.design", "emit.scalar"}
    stated = task.changed(tube={"design": "literal"}, emit={"scalar": "float"})
    assert {"tube.design", "emit.scalar"} <= {key for a in adjustments_of(stated, Reason("")) for key in a.keys}


def test_shorter_periods_are_whole_ticks() -> None:
    task = load_task(ROOT / "tasks" / "crane.toml")
    tick = task.emit.tick_period
    assert tick is not None
    task = task.changed(control={"period": f"{float(40 * tick):g}"})
    (adjustment,) = (a for a in adjustments_of(task, Reason("", codes=("P9",))) if a.keys == ("control.period",))
    periods = [adjustment.change(factor).edits[0].value for factor in (*adjustment.factors, Fraction(1, 1000))]
    assert all(isinstance(v, Fraction) and v > 0 and (v / tick).denominator == 1 for v in periods)


def test_a_change_that_leaves_other_tubes_open_is_tried_with_them() -> None:
    """The preferred tube of the changed task is the one that fails; the next run would try others."""
    open_task = arena_task(FAMILIES["paper"], 36).changed(
        plant={"order": 2, "w_max": "0.1"}, control={"period": "0.01", "u_max": "3"}
    )
    stated = open_task.changed(tube={"prefer": "balanced"})
    assert not pipeline._quick_test(open_task)(open_task)  # its preferred tube is too fast for u_max
    assert pipeline._quick_test(stated)(open_task)
    task = parse_task(task_text("inertia", 29)).changed(tube={"prefer": "balanced"})
    with pytest.raises(NotCertified, match=r"certified without tube\.prefer"):
        build_task(task)


def test_the_key_that_the_problem_is_about_is_tried_first() -> None:
    task = sampled_task("0.01").changed(plant={"lag": "0.4"})
    first = next(adjustments_of(task, Reason("", codes=("P9",), about=("plant.lag",))))
    assert first.keys == ("plant.lag",)


def test_a_refusal_keeps_its_parts_when_it_is_about_a_file(tmp_path: Path) -> None:
    path = tmp_path / "slow.toml"
    path.write_text((ROOT / "tasks" / "omni_s2.toml").read_text().replace("[tube]", "[tube]\nmax_speed = 0.1", 1))
    with pytest.raises(NotCertified) as refusal:
        pipeline.build(path, effort=Effort(0.0))
    assert refusal.value.reason.codes
    assert str(refusal.value).startswith(f"{path}: ")
