"""The kinds of tubes that a task can ask for, and what can be asked of each: one row for each kind.

The checks of a task read the table, so it is in a layer below the task. designs/ says what a tube of each kind is. Only this
table and that of the stages (pipeline.py) go by the name of a kind.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

DesignKind = Literal["refined", "adaptive", "literal"]


@dataclass(frozen=True, kw_only=True)
class Capabilities:
    """What a kind of tube offers; a task that asks for more is refused."""

    accepts_user_tubes: bool = False  # `certify_tube` takes a tube that the user designed
    avoids_any_shape: bool = False  # else unsafe sets, state space and target are boxes
    bounds_acceleration: bool = False  # tube.max_acceleration
    carries_out_missions: bool = False
    counts_ticks: bool = False  # emit.tick_period
    drives_order_two: bool = False  # plants whose u makes accelerations
    follows_moving_sets: bool = False  # sets and targets that move, or exist for a while
    has_cycle_estimate: bool = False  # about how long a step takes on an Uno
    has_exact_claims: bool = False  # whole numbers in its certificate, which the stand-alone checker and Coq read
    has_integer_form: bool = False  # emit.scalar = "fixed"
    inlines_logarithm: bool = False  # emit.math = "inline"
    offers_widths: bool = False  # tube.prefer, `design --pareto`
    proves_limits: bool = False  # P8: u_max outdoes the plant bounds
    proves_periods: bool = False  # P9: control.period
    scales_input: bool = False  # control.saturate = "scale"
    shares_norm: bool = False  # control.u_norm, of which each component has the share that its tube needs
    emits_covered_starts: bool = False  # the emitted `covered`
    waits_outside: bool = False  # control.outside other than "return"
    runs_in_ros2_and_fmu: bool = False  # --package ros2 and --package fmu, which step no alpha
    unread_options: frozenset[str] = frozenset()  # fields of [tube.adaptive] that its design does not read


CAPABILITIES: Mapping[DesignKind, Capabilities] = {
    "refined": Capabilities(
        accepts_user_tubes=True,
        avoids_any_shape=True,
        bounds_acceleration=True,
        carries_out_missions=True,
        counts_ticks=True,
        drives_order_two=True,
        follows_moving_sets=True,
        has_cycle_estimate=True,
        has_exact_claims=True,
        has_integer_form=True,
        inlines_logarithm=True,
        offers_widths=True,
        proves_limits=True,
        proves_periods=True,
        scales_input=True,
        shares_norm=True,
        emits_covered_starts=True,
        waits_outside=True,
        runs_in_ros2_and_fmu=True,
    ),
    "adaptive": Capabilities(unread_options=frozenset({"bump_steepness"})),
    "literal": Capabilities(unread_options=frozenset({"target_margin"})),
}


def kinds_offering(capability: str, quoted: bool = False) -> str:
    """Return the kinds that offer a capability, for a message: one name, or several joined by "or"."""
    names = [kind for kind, offered in CAPABILITIES.items() if getattr(offered, capability)]
    return " or ".join(f'"{name}"' if quoted else name for name in names)
