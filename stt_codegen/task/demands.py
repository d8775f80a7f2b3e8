"""What a task demands of its kind of tube: one row for each capability that a task can ask for.

The checks of single fields refuse such a task with advice, where it is loaded. `require_offered` is the second defence, just
before a certificate: no certifier sees a task with a demand that its kind of tube does not prove.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from stt_codegen.design_kinds import Capabilities, kinds_offering
from stt_codegen.errors import BadInput
from stt_codegen.task.schema import PLANT_BOUNDS, TaskTables
from stt_codegen.task.sets import UnsafeSet


@dataclass(frozen=True)
class Demand:
    """A demand that a task may make. field: where the task makes it; what: what it asks for, in words."""

    field: str
    what: str
    applies_to: Callable[[TaskTables], bool]


def _has_other_shapes(task: TaskTables) -> bool:
    """Whether a set is no box."""
    return bool(task.space_cuts or task.target_cuts) or not all(isinstance(unsafe, UnsafeSet) for unsafe in task.unsafe)


def _limits_input(task: TaskTables) -> bool:
    """Whether u is limited and must outdo the plant bounds, in continuous time."""
    is_bounded = any(getattr(task.plant, name) is not None for name in PLANT_BOUNDS)
    return task.u_max is not None and task.control.period is None and is_bounded


DEMANDS: Mapping[str, Demand] = {  # by the capability, a field of `Capabilities`
    "avoids_any_shape": Demand("unsafe", "a set that is no box", _has_other_shapes),
    "bounds_acceleration": Demand("tube.max_acceleration", "a bound on it", lambda task: task.tube.max_acceleration is not None),
    "carries_out_missions": Demand("mission", "a mission", lambda task: bool(task.mission) or task.repeat),
    "counts_ticks": Demand("emit.tick_period", "a count of ticks", lambda task: task.emit.tick_period is not None),
    "drives_order_two": Demand("plant.order", "a plant of order 2", lambda task: task.order == 2),
    "follows_moving_sets": Demand(
        "unsafe or target_set", "a set that moves or has an active interval",
        lambda task: task.has_moving_target or any(unsafe.is_timed for unsafe in task.unsafe),
    ),
    "has_integer_form": Demand("emit.scalar", "a controller in integers", lambda task: task.emit.scalar == "fixed"),
    "inlines_logarithm": Demand("emit.math", "an inline logarithm", lambda task: task.emit.math == "inline"),
    "offers_widths": Demand("tube.prefer", "a choice of widths", lambda task: task.tube.prefer != "balanced"),
    "proves_limits": Demand("control.u_max", "a proof that u_max outdoes the bounds of [plant]", _limits_input),
    "proves_periods": Demand("control.period", "a proof for this period", lambda task: task.control.period is not None),
    "scales_input": Demand("control.saturate", "one factor for all of u", lambda task: task.scales_input),
    "shares_norm": Demand("control.u_norm", "a bound on the norm of u", lambda task: task.control.u_norm is not None),
    "waits_outside": Demand("control.outside", "a controller that waits outside", lambda task: task.control.outside != "return"),
}  # fmt: skip


def require_offered(task: TaskTables, offered: Capabilities) -> None:
    """Raise `BadInput` where the task makes a demand that a kind of tube with these capabilities does not fulfil."""
    for capability, demand in DEMANDS.items():
        if not getattr(offered, capability) and demand.applies_to(task):
            kinds = kinds_offering(capability, quoted=True)
            raise BadInput(
                f"{demand.field}: asks for {demand.what}, which this kind of tube does not offer; use tube.design = {kinds}"
            )
