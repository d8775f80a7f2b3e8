"""Which starts the guarantee covers, as bounds that `covered` compares a measurement with.

With `control.period` these are the starts that P9 is proved for: |e(0)| within `initial_set.share`, and for order 2 v + lambda x
as near the middle of the filtered tube as it is from the starts that the task states (`inertial_start_bound`: P9's invariant
begins there). Without it they are those of Theorem 4.1 at which the clamp does not act: |e(0)| < e_max, in continuous time.

What a measurement may be wrong by is taken off both sides: noise, and the rounding of x, v and their sum to the scalar. So a
measurement strictly between the bounds belongs to no state that is not covered.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from stt_codegen.decimals import by_component, decimal
from stt_codegen.designs import RefinedDesign, slopes_at_start
from stt_codegen.program import (
    FALSE,
    FORMATS,
    INT,
    REAL,
    TRUE,
    Block,
    Function,
    Load,
    Operand,
    Param,
    Program,
    Table,
    Type,
    Var,
    round_toward,
)
from stt_codegen.properties import Property
from stt_codegen.sampling import FRACTIONS, inertial_start_bound
from stt_codegen.task import Task

Bounds = tuple[tuple[Fraction, Fraction], ...]
NAMES = ("start_lower", "start_upper", "filtered_start_lower", "filtered_start_upper")


@dataclass(frozen=True)
class Starts:
    """By component, the exact bounds between which x, and for order 2 v + lambda x, is of a start that is covered; empty where
    the errors of a measurement leave nothing. `filtered` is () for order 1."""

    places: Bounds
    filtered: Bounds

    def tables(self, scalar: str, unit: Fraction) -> tuple[Table, ...]:
        """The bounds rounded inwards, for strict comparisons; in units of integers where `scalar` is "fixed"."""
        columns = [*zip(*self.places, strict=True), *zip(*self.filtered, strict=True)]
        names, docs = NAMES[: len(columns)], _table_docs(bool(self.filtered))
        is_fixed = scalar == "fixed"
        kind: Type = INT if is_fixed else REAL
        tables = []
        for k, (name, values, doc) in enumerate(zip(names, columns, docs, strict=True)):
            if is_fixed:  # the last integer that is not covered
                entries = [Fraction(math.floor(v / unit) + 1 if k % 2 else math.ceil(v / unit) - 1) for v in values]
            else:
                entries = [round_toward(v, scalar, up=k % 2 == 0) for v in values]
            tables.append(Table(name, tuple(entries), len(entries), (doc,), kind))
        return tuple(tables)


def without_covered_starts(program: Program) -> Program:
    """The same program, whose `covered` is always false: for a controller that is written although it is not certified."""
    empty = (replace(t, values=(Fraction(0),) * len(t.values)) if t.name in NAMES else t for t in program.tables)
    return replace(program, tables=tuple(empty))


def start_share(task: Task) -> Fraction:
    """The share of the half widths of gamma(0) in which starts are covered: proved for sampling, or unclamped."""
    return task.initial_set.share if task.control.period is not None else min(task.e_max)


def measurement_error(task: Task) -> Fraction:
    """What a measured x may be wrong by before it is rounded: noise, and where axes close what unwrapping adds, whether or not
    the task states a plant or a period."""
    return (task.as_stated.plant.noise or Fraction(0)) + max(
        (axis.unwrap_error for axis in task.closed_axes), default=Fraction(0)
    )


def starts_of(task: Task, design: RefinedDesign) -> Starts:
    """The bounds, exact, in the task's units (of v + lambda x: a second)."""
    share, noise, size = start_share(task), measurement_error(task), task.largest_coordinate
    edges = design.bezier()[0, :, :, 0]
    ends = [(int(a) * design.unit, int(b) * design.unit) for a, b in edges]
    rounding = _rounding(task, design)
    places = tuple(_inner(low, high, share, noise + rounding * size) for low, high in ends)
    if task.order == 1:
        return Starts(places, ())
    reaches = inertial_start_bound(task, design, numbers=FRACTIONS) if task.control.period is not None else None
    is_known = reaches is not None and bool((reaches < math.inf).all())
    noise_v = Fraction(0) if task.uses_differences else task.plant.noise_v or Fraction(0)
    filtered = []
    for i, ((low, high), (low_rate, high_rate), value) in enumerate(
        zip(ends, slopes_at_start(design), design.filter, strict=True)
    ):
        lower, upper = low_rate + value * low, high_rate + value * high
        far = max(abs(lower), abs(upper))
        shares = FRACTIONS.share_of_eps(reaches[i]) if reaches is not None and is_known else share
        if task.emit.scalar == "fixed":  # x and v are half a unit off, and lambda times x is rounded down
            wrong = design.unit * (Fraction(3, 2) + value / 2)
        else:  # x and v, their product and sum are rounded: each of at most what is added up here
            wrong = 2 * rounding * (2 * value * size + far)
        filtered.append(_inner(lower, upper, shares, noise_v + value * noise + wrong))
    return Starts(places, tuple(filtered))


def _inner(low: Fraction, high: Fraction, share: Fraction, wrong: Fraction) -> tuple[Fraction, Fraction]:
    """The share of an interval about its middle, less what a measurement is wrong by."""
    half, middle = share * (high - low) / 2 - wrong, (low + high) / 2
    return middle - half, middle + half


def _rounding(task: Task, design: RefinedDesign) -> Fraction:
    """What a coordinate is rounded by, over the largest one: twice half a unit in the last place, as what is rounded may be
    larger than what it is rounded to; half a unit of integers."""
    if task.emit.scalar == "fixed":
        return design.unit / 2 / task.largest_coordinate
    return 2 * FORMATS[task.emit.scalar].roundoff


def _table_docs(inertial: bool) -> list[str]:
    text = "Covered starts have x strictly {} these bounds, by component."
    more = "The same of v + lambda x: strictly {} these bounds."
    return [text.format("above"), text.format("below")] + [more.format(w) for w in ("above", "below") if inertial]


def covered_function(task: Task, n: int, filter_of: Callable[[Block, Operand], Operand] | None) -> Function:
    """`covered` in floating point; a NaN is between nothing. filter_of: statements for a component's lambda, None for order 1."""
    block = Block({"x", "v"})
    with block.loop("i", n) as loop:
        covered, i = loop.carry("covered", TRUE), loop.index
        x = block.let("x_i", Load("x", i))
        inside = between_bounds(block, x, i, NAMES[:2])
        if filter_of is not None:
            filtered = block.op("filtered", "mul", x, filter_of(block, i))
            z = block.op("z", "add", block.let("v_i", Load("v", i)), filtered)
            inside = block.op("inside", "and", inside, between_bounds(block, z, i, NAMES[2:]))
        loop.update(covered, block.select("covered_next", inside, covered, FALSE))
    block.leave(covered)
    params = tuple(Param(name, n) for name in ("x", "v")[: 1 if filter_of is None else 2])
    return Function("covered", params, tuple(block.statements), False, covered_doc(task), returns_bool=True)


def between_bounds(block: Block, value: Var, i: Operand, names: Sequence[str]) -> Var:
    """Statements for whether a value, a real or an integer, is strictly between component i of two tables."""
    less = "ilt" if value.type is INT else "lt"
    low, high = (block.let(f"{name}_i", Load(name, i, value.type)) for name in names)
    after = block.op(f"{value.name}_after", less, low, value)
    before = block.op(f"{value.name}_before", less, value, high)
    return block.op(f"{value.name}_between", "and", after, before)


def covered_doc(task: Task) -> tuple[str, ...]:
    """What `covered` says, in lines of a comment."""
    inertial = task.order == 2
    state = "x, and at v = 0, at rest" if inertial and task.uses_differences else "x and v" if inertial else "x"
    continuous = "the paper's Theorem 4.1, in continuous time,"
    proof = continuous if task.control.period is None else f"the proof of the sampling period ({Property.PERIOD.code})"
    where = f"every component of x is within {decimal(start_share(task))} of the tube's half width about its middle at t = 0"
    wrong = "rounding and the noise of [plant]" if task.plant.noise or task.plant.noise_v else "rounding"
    lines = (
        f"Whether {proof} covers a start at the measured {state}:",
        where + ("," if inertial else "."),
        *((f"and v + lambda x is in its own tube, {_filtered_words(task)}.",) if inertial else ()),
        f"What a measurement may be wrong by ({wrong}) is taken off.",
        "Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube",
        "from where it stands.",
    )
    return lines if task.emit.scalar == "fixed" else (*lines[:-1], lines[-1] + " False for a NaN.")


def _filtered_words(task: Task) -> str:
    """How near the middle of its tube v + lambda x must be."""
    if task.control.period is None:
        return "where the clamp does not act"
    moving = f"with |v| <= {by_component(task.start_speed)}" if any(task.start_speed) else "at rest"
    return f"no farther from the middle than from such an x {moving}"
