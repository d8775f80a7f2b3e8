"""What a controller in integers is wrong by: its edges (P7), and its law against (13). In exact numbers, from the kernels.

*Edges.* Time: the place of a tick is late by what the length of a tick and its sum are rounded by, and by what s leaves out.
Weights: there are 2^16 of s, so all are tried. A step times its weight is exact, and two sums of these are rounded down.

*Law.* |u| = k/d |e| H(1 - |e|). Let 1/d come out as (1 + a)/d, |a| <= A, and H as (1 + b) H, |b| <= B (curves.py). Then e and y
come out with 1 + a too, rounded down to 2^-30. Since 0 <= -y H'/H <= 3/2 (with H = 8 (atanh(e)/e)/(1 - e^2), (1 - e) times the
slope of the logarithm of 1/(1 - e^2) is 2 e/(1 + e) <= 1, and of atanh(e)/e at most e/(1 + e) <= 1/2), all powers of 1 + a are
from 1/2 to 2 together. The gain's mantissa has 16 bits. The three products of `push` are rounded down, each by less than a unit
of a size that is at least |e| 2^26, which is less than 64 units of e's 2^-30; the last shift by less than a unit of u.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.controller.integers import curves
from stt_codegen.controller.integers.constants import LOOSE, FixedLaw, law_of, narrow_of, narrowest
from stt_codegen.controller.integers.integer_kernels import (
    BEND_BITS,
    HALF_WORD,
    WEIGHT_BITS,
    Clock,
    Rate,
    clock_of,
    rate_of,
    rates_kernel,
    weights_kernel,
)
from stt_codegen.decimals import by_component, decimal
from stt_codegen.designs import LOWER, UPPER, RefinedDesign, filtered_edges
from stt_codegen.errors import BadInput
from stt_codegen.program import OPERATIONS, Const, Kernel, Op, Operand, Select
from stt_codegen.program.analyse import logarithm
from stt_codegen.sampling import ROUNDING
from stt_codegen.task import Task

Integers = npt.NDArray[np.int64]
LEAST_Y = 1 << 14  # units of 2^-30: y is rounded down by one of them, which then counts for little


def late(clock: Clock) -> Fraction:
    """By how many segments the place of a tick may be wrong: a tick's length is rounded, its sum cut off, the end held a unit
    before t_c, and s is cut off."""
    unit = Fraction(1, 1 << clock.bits)
    return unit * clock.last / HALF_WORD / 2 + 2 * unit + (Fraction(1, HALF_WORD) if clock.bits > 16 else 0)


def at_all(kernel: Kernel, inputs: Mapping[str, Integers]) -> tuple[Integers, ...]:
    """The outputs of a kernel of integers without tables, for arrays of inputs; nothing may leave 63 bits."""
    known: dict[str, Any] = dict(inputs)

    def value(operand: Operand) -> Any:
        return np.int64(operand.value) if isinstance(operand, Const) else known[operand.name]  # type: ignore[arg-type]

    for assign in kernel.body:
        match assign.value:
            case Op(name="int", args=(count,)):
                known[assign.var.name] = value(count)
            case Op(name=name, args=args):
                known[assign.var.name] = OPERATIONS[name].number(*map(value, args))
            case Select(condition=c, then=then, otherwise=otherwise):
                known[assign.var.name] = np.where(value(c), value(then), value(otherwise))
            case _:
                raise NotImplementedError(f"{kernel.name}: {type(assign.value).__name__}")
    return tuple(value(o) for o in kernel.outputs)


@cache
def weight_errors() -> tuple[Fraction, Fraction]:
    """The largest error of the two outer weights together, and of the middle one, over all s: exactly."""
    s = np.arange(HALF_WORD, dtype=np.int64)
    before, middle, after = at_all(weights_kernel(), {"s": s})
    one = HALF_WORD
    cubes = 48 - WEIGHT_BITS
    outer = np.abs((before << cubes) - (one - s) ** 3) + np.abs((after << cubes) - s**3)
    inner = np.abs((middle << 48 - BEND_BITS) - (3 * s * one * one + 3 * s * s * one - 2 * s**3))
    return Fraction(int(outer.max()), 1 << 48), Fraction(int(inner.max()), 1 << 48)


def edge_error(design: RefinedDesign, period: Fraction) -> tuple[Fraction, ...]:
    """By dimension, a bound on |edge at a tick - gamma(t)|, in the task's units: for a tick of `period` seconds."""
    step = np.abs(np.diff(design.integers(), axis=0)).max(axis=(0, 2))
    slope = 3 * design.largest_steps().max(axis=0)
    moved, weights = late(clock_of(design, period)), sum(weight_errors(), Fraction(0))
    return tuple((int(v) * moved + int(d) * weights + 2) * design.unit for v, d in zip(slope, step, strict=True))


@cache
def rate_weight_error(rate: Rate, per_second: Fraction) -> Fraction:
    """The largest sum of the errors of the three weights of a rate, in steps a second, over all s: exactly."""
    s = np.arange(HALF_WORD, dtype=np.int64)
    found = at_all(rates_kernel(rate), {"s": s})
    one, s = HALF_WORD, s.astype(object)
    true = (3 * (one - s) ** 2, 3 * one**2 + 6 * s * (one - s), 3 * s**2)
    a, b = per_second.numerator << rate.places, per_second.denominator << 32
    wrong = sum(abs(w.astype(object) * b - t * a) for w, t in zip(found, true, strict=True))
    return Fraction(int(wrong.max()), b << rate.places)


def rate_error(design: RefinedDesign, period: Fraction) -> tuple[Fraction, ...]:
    """By dimension, a bound on |rate at a tick - gammadot(t)|, in units per second; it has two units more, for a v that is
    rounded to its units and a product with lambda that is rounded down."""
    per_second = Fraction(design.segments) / design.prescribed_time
    step = np.abs(np.diff(design.integers(), axis=0)).max(axis=(0, 2))
    bend = 6 * np.abs(np.diff(design.bezier(), n=2, axis=3)).max(axis=(0, 2, 3))
    weights = rate_weight_error(rate_of(design), per_second)
    moved = late(clock_of(design, period)) * per_second
    return tuple((int(v) * moved + int(d) * weights + 4) * design.unit for v, d in zip(bend, step, strict=True))


def widest(task: Task, design: RefinedDesign) -> Fraction:
    """The largest width of the emitted tube that the law goes by, in the task's units, of order 2 a second."""
    if not design.filter:
        table = design.integers()
        return 6 * int((table[:, :, UPPER] - table[:, :, LOWER]).max()) * design.unit + widths_wrong(task, design)[0]
    pieces = filtered_edges(design)
    most = int((pieces.coefficients[:, :, UPPER] - pieces.coefficients[:, :, LOWER]).max()) * pieces.unit
    return most + widths_wrong(task, design)[1]


def widths_wrong(task: Task, design: RefinedDesign) -> tuple[Fraction, Fraction]:
    """By how much the arithmetic moves the width of the tube, in the task's units, and that of the one that the law goes by, of
    order 2 a second."""
    assert task.emit.tick_period is not None  # task/checks/field_checks.py
    edges = [2 * v for v in edge_error(design, task.emit.tick_period)]
    if not design.filter:
        return max(edges), max(edges)
    rates = [2 * v for v in rate_error(design, task.emit.tick_period)]
    return max(edges), max(r + s * e for r, s, e in zip(rates, design.filter, edges, strict=True))


def require_right(task: Task, design: RefinedDesign) -> None:
    """Raise `BadInput` where the law is wrong by more than the sampled statements allow for, or takes the tube to be wider than
    it may be as it is emitted."""
    law = law_of(task, design)
    if law.lowest < LEAST_Y:
        raise BadInput("control.e_max: is so near 1 that integers of 32 bits do not hold 1 - e_max; lower it")
    for narrow, least in widths_held(task, design, law):
        if narrow > least:
            told = f"the tube is {decimal(max(least, Fraction(0)) * design.unit)} wide as it is emitted, and a law in integers"
            needed = f"{told} needs {decimal(narrow * design.unit)} here"
            raise BadInput(f'tube.min_width: {needed}; raise it, move the origin near the task, or use emit.scalar = "float"')
    allowed = Fraction(ROUNDING["fixed", "libm"])
    relative, in_eps = law_error(law, widest(task, design))
    beyond = (1 + LOOSE) / (1 - Fraction(3, 2) * LOOSE) - 1  # the clamp acts later, for e and for y
    if (1 + relative) * (1 + beyond) - 1 > allowed or in_eps > allowed:
        raise BadInput(
            f"control.gain: {by_component(law.gain)} is so small beside u_max {by_component(law.u_max)} that integers of 32 bits "
            'lose u in the middle of the tube; raise it, lower u_max, or use emit.scalar = "float"'
        )


def widths_held(task: Task, design: RefinedDesign, law: FixedLaw) -> list[tuple[int, Fraction]]:
    """What the law takes the tube to be wide at least, and for order 2 what `margin` takes x's to be, each beside what the
    emitted edges leave of it at least: whole numbers of units, and units."""
    least = [(v - wrong) / design.unit for v, wrong in zip(narrowest(design), widths_wrong(task, design), strict=True)]
    if not design.filter:
        return [(law.narrow, least[0])]
    return [(narrow_of(narrowest(design)[0] / design.unit), least[0]), (law.narrow, least[1])]


def law_error(law: FixedLaw, widest: Fraction) -> tuple[Fraction, Fraction]:
    """What |u| is wrong by against (13) on the edges as they are, where it is below u_max and |e| below e_max: relative, and in
    eps. widest: of the tube, in the task's units."""
    over, rise = curves.relative_error(law.octaves)
    a = over + Fraction(1, 1 << 17)  # the curve's 2^46 is less by so much
    assert a <= LOOSE  # on which the places of the clamps rest
    cut = (1 + Fraction(1, law.lowest - 1)) ** 2  # y is rounded down by less than its unit, which raises H by that to 3/2 at most
    relative = (1 + a) ** 2 * (1 + rise) * (1 + Fraction(1, 1 << 16)) * cut - 1
    unit = Fraction(1, 1 << law.u_bits) if law.u_bits >= 0 else Fraction(1 << -law.u_bits)
    in_eps = unit * widest / (4 * min(abs(k) for k in law.gain))  # xi is at least 4/d
    steepest = logarithm((1 + law.e_max) / (1 - law.e_max))[1] / law.e_max  # eps/e, which rises with e
    return relative, in_eps + 65 * steepest / 2**30
