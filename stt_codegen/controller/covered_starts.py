"""Which starts the guarantee covers, and the emitted function `covered` that tells a caller so for a measured start.

With `control.period` the covered starts are those that P9 is proved for: |e(0)| is within `initial_set.share`, and for order 2 v
+ lambda x is as near the middle of the filtered tube as it can be from the starts that the task states (`inertial_start_bound`,
at which P9's invariant begins). Without a period they are the starts of Theorem 4.1 of the paper at which the clamp does not
act: |e(0)| < e_max, in continuous time.

The bounds are narrowed on both sides by the largest error of a measurement: noise, and the rounding of x, v and their sum to the
scalar. So every state whose measurement is strictly between the bounds is covered. refined_frame.py and integers/ call this file.
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

Intervals = tuple[tuple[Fraction, Fraction], ...]  # by component, (lower, upper)
BOUND_TABLES = ("start_lower", "start_upper", "filtered_start_lower", "filtered_start_upper")  # names in emitted code


@dataclass(frozen=True)
class CoveredStarts:
    """The exact open intervals, by component, in which a measured x, and for order 2 a measured v + lambda x, is a covered start.

    An interval whose lower bound is not below its upper one is empty: the errors of a measurement leave nothing of it. `filtered`
    is () for order 1."""

    positions: Intervals
    filtered: Intervals

    def tables(self, scalar: str, unit: Fraction) -> tuple[Table, ...]:
        """Return the tables of the bounds, rounded inwards for strict comparisons.

        Where `scalar` is "fixed" they are integers and count `unit`."""
        columns = [*zip(*self.positions, strict=True), *zip(*self.filtered, strict=True)]
        names, docs = BOUND_TABLES[: len(columns)], _table_docs(has_filter=bool(self.filtered))
        is_fixed = scalar == "fixed"
        number_type: Type = INT if is_fixed else REAL
        tables = []
        for k, (name, bounds, doc) in enumerate(zip(names, columns, docs, strict=True)):
            is_upper = k % 2 == 1
            if is_fixed:  # the nearest integer that is not covered: comparisons are strict
                entries = [Fraction(math.floor(v / unit) + 1 if is_upper else math.ceil(v / unit) - 1) for v in bounds]
            else:
                entries = [round_toward(v, scalar, up=not is_upper) for v in bounds]
            tables.append(Table(name, tuple(entries), len(entries), (doc,), number_type))
        return tuple(tables)


def without_covered_starts(program: Program) -> Program:
    """Return the program with a `covered` that is always false: for a controller that is written without a certificate."""
    tables = (replace(t, values=(Fraction(0),) * len(t.values)) if t.name in BOUND_TABLES else t for t in program.tables)
    return replace(program, tables=tuple(tables))


def start_share(task: Task) -> Fraction:
    """Return the share of the half widths of gamma(0) in which starts are covered: proved for sampling, or without clamp."""
    return task.initial_set.share if task.control.period is not None else min(task.e_max)


def measurement_errors(task: Task) -> tuple[Fraction, ...]:
    """Return the largest error of each measured x_i before it is rounded: stated noise, and that of unwrapping closed axes."""
    unwrap_error = max((axis.unwrap_error for axis in task.closed_axes), default=Fraction(0))
    return tuple(v + unwrap_error for v in task.as_stated.noise)


def compute_covered_starts(task: Task, design: RefinedDesign) -> CoveredStarts:
    """Compute the intervals of covered starts, exactly, in the task's units; for v + lambda x in units per second."""
    share = start_share(task)
    edges = [(int(low) * design.unit, int(high) * design.unit) for low, high in design.bezier()[0, :, :, 0]]  # of gamma(0)
    rounding, errors = _relative_rounding(task, design) * task.largest_coordinate, measurement_errors(task)
    positions = tuple(_narrowed(low, high, share, error + rounding) for (low, high), error in zip(edges, errors, strict=True))
    if task.order == 1:
        return CoveredStarts(positions, ())
    filtered = []
    edges_and_rates = zip(edges, slopes_at_start(design), design.filter, _filtered_shares(task, design), strict=True)
    for i, ((low, high), (low_rate, high_rate), lambda_, filtered_share) in enumerate(edges_and_rates):
        lower, upper = low_rate + lambda_ * low, high_rate + lambda_ * high
        error = _filtered_error(task, design, i, max(abs(lower), abs(upper)))
        filtered.append(_narrowed(lower, upper, filtered_share, error))
    return CoveredStarts(positions, tuple(filtered))


def _filtered_shares(task: Task, design: RefinedDesign) -> list[Fraction]:
    """Return, by component, the share of the half width of the filtered tube in which v + lambda x is covered."""
    epsilon_bounds = inertial_start_bound(task, design, numbers=FRACTIONS) if task.control.period is not None else None
    if epsilon_bounds is None or not bool((epsilon_bounds < math.inf).all()):
        return [start_share(task)] * task.dimension
    return [FRACTIONS.share_of_eps(bound) for bound in epsilon_bounds]


def _filtered_error(task: Task, design: RefinedDesign, i: int, largest_edge: Fraction) -> Fraction:
    """Bound the error of v + lambda x as `covered` computes it from measurements of component i.

    largest_edge: of the filtered tube at 0.
    """
    noise_v, lambda_ = Fraction(0) if task.uses_differences else task.noise_v[i], design.filter[i]
    if task.emit.scalar == "fixed":  # x and v are half a unit off, and lambda times x is rounded down
        rounding = design.unit * (Fraction(3, 2) + lambda_ / 2)
    else:  # x, v, their product and their sum are rounded; the bracket bounds the sum of their sizes
        rounding = 2 * _relative_rounding(task, design) * (2 * lambda_ * task.largest_coordinate + largest_edge)
    return noise_v + lambda_ * measurement_errors(task)[i] + rounding


def _narrowed(low: Fraction, high: Fraction, share: Fraction, error: Fraction) -> tuple[Fraction, Fraction]:
    """Return the middle part of an interval: this share of it, less the error on both sides."""
    half, middle = share * (high - low) / 2 - error, (low + high) / 2
    return middle - half, middle + half


def _relative_rounding(task: Task, design: RefinedDesign) -> Fraction:
    """Bound the rounding of a coordinate over the largest coordinate.

    Twice half a unit in the last place, as a number may be larger before it is rounded than after; half a unit of integers."""
    if task.emit.scalar == "fixed":
        return design.unit / 2 / task.largest_coordinate
    return 2 * FORMATS[task.emit.scalar].roundoff


def _table_docs(*, has_filter: bool) -> list[str]:
    """Return one comment for each table of bounds."""
    position = "Covered starts have x strictly {} these bounds, by component."
    filtered = "The same of v + lambda x: strictly {} these bounds."
    texts = [position, filtered] if has_filter else [position]
    return [text.format(relation) for text in texts for relation in ("above", "below")]


def build_covered(task: Task, n: int, write_lambda: Callable[[Block, Operand], Operand] | None) -> Function:
    """Build `covered` in floating point; it is false for a NaN.

    write_lambda: writes statements for a component's lambda; None for order 1. Strings are names in emitted code."""
    block = Block({"x", "v"})
    with block.loop("i", n) as loop:
        is_covered, i = loop.carry("covered", TRUE), loop.index
        x = block.let("x_i", Load("x", i))
        is_inside = write_is_between_bounds(block, x, i, BOUND_TABLES[:2])
        if write_lambda is not None:
            filtered_x = block.op("x_part", "mul", x, write_lambda(block, i))
            z = block.op("z_i", "add", block.let("v_i", Load("v", i)), filtered_x)
            is_z_inside = write_is_between_bounds(block, z, i, BOUND_TABLES[2:])
            is_inside = block.op("inside", "and", is_inside, is_z_inside)
        loop.update(is_covered, block.select("covered_next", is_inside, is_covered, FALSE))
    block.leave(is_covered)
    params = tuple(Param(name, n) for name in ("x", "v")[: 1 if write_lambda is None else 2])
    body = tuple(block.statements)
    return Function("covered", params, body, returns_status=False, doc=covered_doc(task), returns_bool=True)


def write_is_between_bounds(block: Block, value: Var, i: Operand, tables: Sequence[str]) -> Var:
    """Write statements for whether a value, a real or an integer, is strictly between component i of two tables."""
    less = "ilt" if value.type is INT else "lt"
    label = value.name.removesuffix("_i")
    low, high = (
        block.let(f"{label}_{side}", Load(name, i, value.type)) for side, name in zip(("lower", "upper"), tables, strict=True)
    )
    is_above = block.op(f"{label}_above", less, low, value)
    is_below = block.op(f"{label}_below", less, value, high)
    return block.op(f"{label}_inside", "and", is_above, is_below)


def covered_doc(task: Task) -> tuple[str, ...]:
    """Return the comment of `covered` in lines: which proof covers which starts, and what to do at another start."""
    has_filter = task.order == 2
    state = "x, and at v = 0, at rest" if has_filter and task.uses_differences else "x and v" if has_filter else "x"
    continuous = "the paper's Theorem 4.1, in continuous time,"
    proof = continuous if task.control.period is None else f"the proof of the sampling period ({Property.PERIOD.code})"
    region = f"every component of x is within {decimal(start_share(task))} of the tube's half width about its middle at t = 0"
    error = "rounding and the noise of [plant]" if task.has_noise else "rounding"
    lines = (
        f"Whether {proof} covers a start at the measured {state}:",
        region + ("," if has_filter else "."),
        *((f"and v + lambda x is in its own tube, {_filtered_region_doc(task)}.",) if has_filter else ()),
        f"What a measurement may be wrong by ({error}) is taken off.",
        "Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube",
        "from where it stands.",
    )
    return lines if task.emit.scalar == "fixed" else (*lines[:-1], lines[-1] + " False for a NaN.")


def _filtered_region_doc(task: Task) -> str:
    """Return the part of the comment that says how near the middle of its tube v + lambda x must be."""
    if task.control.period is None:
        return "where the clamp does not act"
    moving = f"with |v| <= {by_component(task.start_speed)}" if any(task.start_speed) else "at rest"
    return f"no farther from the middle than from such an x {moving}"
