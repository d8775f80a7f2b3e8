"""A tube is certified only for a task of its shape: anything else is refused with one message, and so is a task with a demand
that the tube's kind does not fulfil."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from typing import Any

import pytest

from stt_codegen import api
from stt_codegen.design_kinds import CAPABILITIES, Capabilities, DesignKind
from stt_codegen.designs.adaptive import AdaptiveDesign
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.designs.tube import Design
from stt_codegen.errors import BadInput
from stt_codegen.lemmas.emitted.examples import _adaptive
from stt_codegen.pipeline import build_task, certify, require_design_for, require_supported
from stt_codegen.task.demands import DEMANDS, require_offered
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.support.controllers import TASK_FILES

TASKS = {path.stem: load_task(path) for path in TASK_FILES}
PLAIN = TASKS["omni_s2"]
WITH_LIMITS = {"control": {"u_max": 3}, "plant": {"w_max": Fraction(1, 10)}}
BALL = {"name": "ball", "centre": [2, 2], "radius": Fraction(1, 10)}
# By capability: a change of the plain task by which the task demands it.
CHANGES: dict[str, dict[str, Any]] = {
    "avoids_any_shape": {"unsafe": [BALL]},
    "bounds_acceleration": {"tube": {"max_acceleration": 9}},
    "carries_out_missions": {
        "region": [{"name": "dock", "lower": [2, 3], "upper": [3, 4]}],
        "mission": [{"visit": "dock"}],
    },
    "counts_ticks": {"emit": {"tick_period": Fraction(1, 1000)}},
    "drives_order_two": {"plant": {"order": 2}},
    "follows_moving_sets": {"unsafe": [{"name": "door", "lower": [4, 0], "upper": [5, 1], "during": [1, 2]}]},
    "has_integer_form": {
        "emit": {"scalar": "fixed", "tick_period": Fraction(1, 1000)},
        "control": {"u_max": 3, "gain": Fraction(1, 2)},
    },
    "inlines_logarithm": {"emit": {"math": "inline"}},
    "offers_widths": {"tube": {"prefer": "wide"}},
    "proves_limits": WITH_LIMITS,
    "proves_periods": {"control": {"period": Fraction(1, 100)}},
    "scales_input": {"control": {"saturate": "scale", "u_max": 3}},
    "shares_norm": {"control": {"u_norm": 3}},
    "waits_outside": {"control": {"outside": "stop"}},
}
# Capabilities that commands, reports and interfaces need, and no task demands.
DEMANDED_BY_NO_TASK = {"accepts_user_tubes", "has_exact_claims", "emits_covered_starts", "unread_options"}
DEMANDED_BY_NO_TASK |= {"has_cycle_estimate", "runs_in_ros2_and_fmu"}


def tube_like(task: Task) -> RefinedDesign:
    """Return a refined tube with dimension, order, time and cycle of the task; its edges fit no task."""
    n = task.dimension
    filter_ = (Fraction(1),) * n if task.order == 2 else ()
    return RefinedDesign(task.prescribed_time, 4, 20, (((0, 1),) * n,) * 7, filter=filter_, seam=0 if task.repeat else None)


def shape_of_task(task: Task) -> tuple[object, ...]:
    """Return what a tube must share with its task."""
    return task.dimension, task.order, task.prescribed_time, task.repeat


@pytest.mark.parametrize("name", TASKS)
def test_a_tube_is_certified_for_a_task_of_its_shape_alone(name: str) -> None:
    tube = tube_like(TASKS[name])
    for task in TASKS.values():
        if shape_of_task(task) == shape_of_task(TASKS[name]):
            require_design_for(task, tube)
            continue
        for entry in (api.certify, lambda task, tube: build_task(task, uncertified=True, tube=tube)):
            with pytest.raises(BadInput, match=r"^tube: .*design the tube for this task"):
                entry(task, tube)


@pytest.mark.parametrize("value", ["x", [1, 2], 3, PLAIN, RefinedDesign, None])
def test_a_value_that_is_no_tube_is_refused_with_one_message(value: Any) -> None:
    with pytest.raises(BadInput, match=r"^tube: is a \w+; a design is needed"):
        api.certify(PLAIN, value)
    if value is not None:  # with None the pipeline designs a tube
        with pytest.raises(BadInput, match=r"^tube: is a \w+; a design is needed"):
            build_task(PLAIN, tube=value)


@pytest.mark.parametrize(
    "changed",
    [
        {"prescribed_time": Fraction(0)},
        {"prescribed_time": Fraction(-9)},
        {"prescribed_time": 9.0},
        {"segments": 3},
        {"segments": 5},
        {"segments": 0, "table": (((0, 1),),) * 3},
        {"table": ()},
        {"table": ((),) * 7},
        {"table": (((0, 1),),) * 6 + (((0, 1),) * 2,)},
        {"table": (((0, 1, 2),),) * 7},
        {"table": (((0, 0.5),),) * 7},
        {"table": (((0, 1 << 50),),) * 7},
        {"filter": (Fraction(1),)},
        {"filter": (Fraction(1), Fraction(-1))},
        {"filter": (Fraction(1), Fraction(0))},
        {"filter": (1.0, 1.0)},
        {"seam": 4},
        {"seam": -1},
    ],
    ids=str,
)
def test_a_refined_design_with_numbers_that_fix_no_tube_is_refused(changed: dict[str, Any]) -> None:
    with pytest.raises(BadInput, match=r"^tube: "):
        dataclasses.replace(tube_like(PLAIN), **changed)


@pytest.mark.parametrize(
    "changed",
    [
        {"prescribed_time": Fraction(0)},
        {"kind": "refined"},
        {"kind": "periodic"},
        {"start": ()},
        {"target": ((Fraction(0), Fraction(1)),)},
        {"walls": ((Fraction(0),),) * 2},
        {"kappa": 5.0},
        {"start": ((0.0, 1.0),) * 2},
    ],
    ids=str,
)
def test_an_adaptive_design_with_numbers_that_fix_no_tube_is_refused(changed: dict[str, Any]) -> None:
    with pytest.raises(BadInput, match=r"^tube: "):
        dataclasses.replace(adaptive_tube(), **changed)


def adaptive_tube() -> AdaptiveDesign:
    """Return the adaptive tube of an example."""
    design = _adaptive().design
    assert isinstance(design, AdaptiveDesign)
    return design


# ------------------------------------------------------------------------------------------------ demands by capability


def test_every_capability_has_its_demand() -> None:
    assert DEMANDS.keys() == CHANGES.keys() == set(Capabilities.__dataclass_fields__) - DEMANDED_BY_NO_TASK


def is_refused(task: Task, kind: DesignKind) -> bool:
    """Return whether the pipeline, or a check of a single field, refuses the task with a tube of the kind."""
    try:
        require_supported(task.with_options(kind))
    except BadInput:
        return True
    return False


@pytest.mark.parametrize("capability", CHANGES)
@pytest.mark.parametrize("kind", CAPABILITIES)
def test_a_certifier_refuses_a_demand_that_the_kind_does_not_fulfil(capability: str, kind: DesignKind) -> None:
    """The task goes straight to the certifier, as if no check of a field had refused it."""
    task = PLAIN.changed(**CHANGES[capability])
    assert DEMANDS[capability].applies_to(task)
    assert not DEMANDS[capability].applies_to(PLAIN)
    offers = getattr(CAPABILITIES[kind], capability)
    assert is_refused(task, kind) == (not offers)
    unchecked = task.model_copy(update={"tube": task.tube.model_copy(update={"design": kind})})
    tube: Design = tube_like(task) if offers else dataclasses.replace(adaptive_tube(), kind=kind)
    if offers:
        require_offered(unchecked, tube.capabilities)
        return
    with pytest.raises(BadInput, match="which this kind of tube does not offer"):
        certify(unchecked, tube, None)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("kind", CAPABILITIES)
def test_example_tasks_are_refused_with_a_kind_exactly_where_it_lacks_a_capability(name: str, kind: DesignKind) -> None:
    offers_all = all(
        getattr(CAPABILITIES[kind], capability) or not demand.applies_to(TASKS[name]) for capability, demand in DEMANDS.items()
    )
    assert is_refused(TASKS[name], kind) == (not offers_all)
