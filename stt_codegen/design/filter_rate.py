"""The choice of lambda, the rate of the filter v + lambda x of a plant of order 2, where the task leaves it open.

The filtered tube is lambda times as wide as the tube where the tube keeps its width, and u must exceed lambda^2 times the width.
So a small lambda makes the filtered tube narrow, and a large one needs large inputs. The choice maximizes the time that the plant
bounds need to take v + lambda x across half of the filtered tube. Where the drive lags, a larger lambda is worth more:
v + lambda x is pushed less as it comes nearer to an edge. docs/certificate.md states the conditions that a lambda must satisfy;
refine.py and user_tubes.py call `with_filter` for every tube.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from stt_codegen.constraints import control_authority
from stt_codegen.decimals import above, below, decimal
from stt_codegen.design.half_spaces import Array
from stt_codegen.designs import LOWER, NARROWEST_WIDTH, UPPER, RefinedDesign, demanded_accelerations, filtered_edges
from stt_codegen.errors import NotCertified, Reason
from stt_codegen.program import round_to
from stt_codegen.properties import Property
from stt_codegen.task import Task

FRACTION_BITS = 10  # of a lambda that is chosen, after the leading bit
CANDIDATES = np.geomspace(2.0**-6, 2.0**6, 97)  # times the lambda that needs as much input as the accelerations of the edges
OTHER_RATES = (0.8, 1.25, 0.6, 1.6)  # times the chosen lambda, where no tube is certified with it
LIMIT_MARGIN = 1e-6  # of the acceleration within u_max that a lambda must leave
# Of lambda times the width: -lambda b slows the approach by about so much while a late input comes. Where the drive lags.
FILTER_PULL_SHARE = 0.25
FIXED_FILTER_BITS = 14  # after the point: in integers lambda has 16 bits and is below 4


def with_filter(task: Task, design: RefinedDesign) -> RefinedDesign:
    """Return the tube with the task's lambda, as the scalar holds it, or with one that is chosen for the tube.

    Raises `NotCertified` where every lambda makes the filtered tube too narrow or needs more than u_max.
    """
    if task.order == 1:
        return design
    if task.filter is not None:
        if task.emit.scalar == "fixed":
            unit = 2**FIXED_FILTER_BITS
            return replace(design, filter=tuple(Fraction(round(v * unit), unit) for v in task.filter))
        return replace(design, filter=tuple(round_to(v, task.emit.scalar) for v in task.filter))
    return replace(design, filter=tuple(_choose_rate(task, design, i) for i in range(task.dimension)))


def with_other_filters(task: Task, design: RefinedDesign) -> Iterator[RefinedDesign]:
    """Yield the tube with other rates than the chosen ones: first of all axes, then of one axis after the other.

    A rate that makes the filtered tube too narrow is left out; whether u is enough is for the certificate to say.
    """
    tubes = [_AxisTube.of(design, i) for i in range(task.dimension)]
    axes = [tuple(range(task.dimension)), *((i,) for i in range(task.dimension) if task.dimension > 1)]
    for changed, factor in itertools.product(axes, OTHER_RATES):
        rates = [_round_to_few_bits(float(v) * factor) if i in changed else v for i, v in enumerate(design.filter)]
        if all(tube.minimum_filtered_width(float(v)) > float(NARROWEST_WIDTH) for tube, v in zip(tubes, rates, strict=True)):
            yield replace(design, filter=tuple(rates))


def _choose_rate(task: Task, design: RefinedDesign, i: int) -> Fraction:
    """Return the lambda of axis i that leaves the longest time to cross half of the filtered tube, within u_max."""
    tube, force = _AxisTube.of(design, i), float(task.plant_bounds[i].force)
    acceleration = max(float(np.abs(v).max()) for v in tube.accelerations)
    balanced = float(np.sqrt(max(acceleration + force, 1e-9) / tube.width.max()))
    rates = [_round_to_few_bits(float(v)) for v in CANDIDATES * balanced]
    candidates = [
        (tube.minimum_filtered_width(float(rate)), tube.required_acceleration(float(rate)), rate)
        for rate in rates
        if tube.minimum_filtered_width(float(rate)) > float(NARROWEST_WIDTH)
    ]
    if not candidates:
        problem = f"no tube.filter up to {float(max(rates)):g} leaves v + lambda x room in {task.axis_words[i]}"
        raise NotCertified(
            Reason(
                f"{Property.WIDTH.label}: {problem}, for the tube narrows too quickly there",
                "raise prescribed_time, or make the initial set narrower",
                codes=(Property.WIDTH.code, Property.LIMITS.code),
                axis=i,
            )
        )
    available = float(control_authority(task)[i]) if task.requires_input_limits else np.inf
    pull_share = FILTER_PULL_SHARE if task.has_drive else 0.0
    crossing_times = [
        (width / (required + force - pull_share * float(rate) * width), rate)
        for width, required, rate in candidates
        if required < available * (1 - LIMIT_MARGIN)
    ]
    if not crossing_times:
        raise NotCertified(_limit_reason(task, i, min(required for _, required, _ in candidates)))
    return max(crossing_times)[1]


def _limit_reason(task: Task, i: int, required: float) -> Reason:
    """Return why no lambda is possible on an axis on which every one requires a larger acceleration than u_max leaves."""
    assert task.u_max is not None
    authority, axis = control_authority(task)[i], task.axis_words[i]
    demand = f"in {axis} the tube asks for accelerations of {above(Fraction(required), 3):g}"
    limit = f"u_max = {decimal(task.u_max[i])}"
    left = (
        f"f, w and coupling leave {below(authority, 3):g} of {limit}"
        if authority > 0
        else f"f, w and coupling take all of {limit}"
    )
    hint = f"raise {task.limit_key} or prescribed_time, or state a milder plant"
    return Reason(f"{Property.LIMITS.label}: {demand}; {left}", hint, codes=(Property.LIMITS.code,), axis=i)


def _round_to_few_bits(value: float) -> Fraction:
    """Return the nearest number of FRACTION_BITS + 1 bits, which any scalar holds."""
    exponent = int(np.floor(np.log2(value))) - FRACTION_BITS
    return Fraction(round(value / 2.0**exponent)) * Fraction(2) ** exponent


@dataclass(frozen=True)
class _AxisTube:
    """The tube on one axis as doubles, in Bezier coefficients by segment, (K, 4) each.

    width_rate: the derivative of the width. accelerations: L'' of the lower edge and R'' of the upper edge.
    """

    width: Array
    width_rate: Array
    accelerations: tuple[Array, Array]

    @classmethod
    def of(cls, design: RefinedDesign, i: int) -> _AxisTube:
        """Return axis i of a design; with lambda = 1 the filtered tube is v + x, so the width is subtracted again."""
        unfiltered = replace(design, filter=(Fraction(1),) * design.dimension)
        edges = design.bezier()[:, i].astype(float) * float(design.unit)
        width = edges[:, UPPER] - edges[:, LOWER]
        v_edges = filtered_edges(unfiltered).floats()[:, i]
        inputs = demanded_accelerations(unfiltered).floats()[:, i]
        width_rate = v_edges[:, UPPER] - v_edges[:, LOWER] - width
        return cls(width, width_rate, (inputs[:, LOWER] - width, inputs[:, UPPER] + width))

    def minimum_filtered_width(self, rate: float) -> float:
        """Return the smallest width of the tube that is filtered at this rate."""
        return float((self.width_rate + rate * self.width).min())

    def required_acceleration(self, rate: float) -> float:
        """Return the largest acceleration that the input must give at an edge, besides what f and w take."""
        press = rate * rate * self.width
        return float(max((press + self.accelerations[0]).max(), (press - self.accelerations[1]).max()))
