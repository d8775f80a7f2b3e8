"""Which lambda a tube for a plant of order 2 is filtered with, where the task leaves it open.

The filtered tube is lambda times as wide as the tube where that keeps its width, and u must outdo lambda^2 times the width: a
small lambda leaves no room, a large one asks for much. What is weighed is the time in which all that pushes may take v + lambda x
across half of the filtered tube.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from stt_codegen.constraints import control_authority
from stt_codegen.decimals import above
from stt_codegen.design.half_spaces import Array
from stt_codegen.designs import LOWER, MINIMUM_WIDTH, UPPER, RefinedDesign, demanded_accelerations, filtered_edges
from stt_codegen.errors import NotCertified
from stt_codegen.program import round_to
from stt_codegen.properties import Property
from stt_codegen.task import Task

BITS = 10  # of a lambda that is chosen, after the leading one
TRIED = np.geomspace(2.0**-6, 2.0**6, 97)  # times the lambda that presses as much as the edges' acceleration


def with_filter(task: Task, design: RefinedDesign) -> RefinedDesign:
    """The tube with the task's lambda, as the scalar holds it, or one that is chosen for it. Raises `NotCertified` where none
    leaves room, or asks for no more than u_max."""
    if task.order == 1:
        return design
    if task.filter is not None:
        if task.emit.scalar == "fixed":  # of 16 bits, and below 4
            return replace(design, filter=tuple(Fraction(round(v * 2**14), 2**14) for v in task.filter))
        return replace(design, filter=tuple(round_to(v, task.emit.scalar) for v in task.filter))
    chosen = [_chosen(task, design, i) for i in range(task.dimension)]
    return replace(design, filter=tuple(chosen))


def _chosen(task: Task, design: RefinedDesign, i: int) -> Fraction:
    """lambda of one component: of those that leave room, and ask for no more than u_max, that with the longest time to cross."""
    edges, push = _Edges.of(design, i), float(task.plant_bounds[i].force)
    bend = max(float(np.abs(v).max()) for v in edges.bend)
    balanced = float(np.sqrt(max(bend + push, 1e-9) / edges.width.max()))
    tried = [short(float(v)) for v in TRIED * balanced]
    wide = [(edges.room(float(v)), edges.asked(float(v)), v) for v in tried if edges.room(float(v)) > 4 * float(MINIMUM_WIDTH)]
    if not wide:
        raise NotCertified(
            f"{Property.WIDTH.label}: no tube.filter up to {float(max(tried)):g} leaves v + lambda x room in "
            f"{task.axis_words[i]}, for the tube narrows too quickly there; raise prescribed_time, or make "
            "the initial set narrower"
        )
    most = float(control_authority(task)[i]) if task.requires_input_limits else np.inf
    good = [(room / (asked + push), v) for room, asked, v in wide if asked < most * (1 - 1e-6)]
    if not good:
        raise NotCertified(_too_much(task, i, min(asked for _, asked, _ in wide)))
    return max(good)[1]


def _too_much(task: Task, i: int, asked: float) -> str:
    """The refusal where every lambda asks for more than u_max leaves."""
    assert task.u_max is not None
    lack = Fraction(asked) - control_authority(task)[i]
    bounds = task.plant_bounds[i]
    enough = task.u_max[i] + lack / bounds.g_min
    if bounds.cross:  # the others' inputs grow too: one limit for all
        own = bounds.g_min - (task.dimension - 1) * bounds.cross
        if own <= 0:
            return (
                f"{Property.LIMITS.label}: in {task.axis_words[i]} the others push by g_cross as much as u holds by g_min, "
                "whatever the limit; state a milder plant.g_cross"
            )
        enough = (Fraction(asked) + bounds.force) / own
    enough *= Fraction(101, 100)
    return (
        f"{Property.LIMITS.label}: in {task.axis_words[i]} the tube asks for accelerations of {above(Fraction(asked), 3):g}, "
        f"{above(lack, 3):g} more than u within control.u_max leaves; raise control.u_max to {above(enough, 3):g}, raise "
        "prescribed_time, or state a milder plant"
    )


def short(value: float) -> Fraction:
    """The nearest number of few bits, which any scalar holds."""
    exponent = int(np.floor(np.log2(value))) - BITS
    return Fraction(round(value / 2.0**exponent)) * Fraction(2) ** exponent


@dataclass(frozen=True)
class _Edges:
    """Of one dimension, as doubles: the width, its rate, and both edges' accelerations, Bezier coefficients by segment (K, 4)."""

    width: Array
    rate: Array
    bend: tuple[Array, Array]

    @classmethod
    def of(cls, design: RefinedDesign, i: int) -> _Edges:
        still = tuple(Fraction(1) for _ in range(design.dimension))
        both = replace(design, filter=still)
        edges = design.bezier()[:, i].astype(float) * float(design.unit)
        width = edges[:, UPPER] - edges[:, LOWER]
        room = filtered_edges(both).floats()[:, i]
        press = demanded_accelerations(both).floats()[:, i]
        return cls(width, room[:, UPPER] - room[:, LOWER] - width, (press[:, LOWER] - width, press[:, UPPER] + width))

    def room(self, value: float) -> float:
        """The least width of the filtered tube."""
        return float((self.rate + value * self.width).min())

    def asked(self, value: float) -> float:
        """What is asked of u besides f and w."""
        press = value * value * self.width
        return float(max((press + self.bend[0]).max(), (press - self.bend[1]).max()))
