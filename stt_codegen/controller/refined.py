"""The frame of a refined controller: finite test, spline time and segment, loop over dimensions, status."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache

from stt_codegen.controller.arithmetic import edge_error
from stt_codegen.controller.law import (
    MARGIN_DOC,
    Law,
    control_component,
    control_law_of,
    inside_of,
    margin_component,
    not_finite,
    place_of,
    transform_function,
)
from stt_codegen.controller.ticks import segment_at_tick, ticks_of
from stt_codegen.controller.words import axes_doc, inward_doc, law_doc
from stt_codegen.decimals import decimal
from stt_codegen.designs import LEAST_WIDTH, LOWER, UPPER, RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.paper import refined_tube
from stt_codegen.program import (
    FALSE,
    NAN,
    REAL,
    STATUS,
    TICK,
    TRUE,
    Block,
    Const,
    Function,
    IsFinite,
    Kernel,
    Load,
    Operand,
    Param,
    Program,
    Select,
    Status,
    Table,
    Trunc,
    Var,
    integer,
    real,
)
from stt_codegen.program.lower import lower
from stt_codegen.program.number import FORMATS, largest_below
from stt_codegen.task import Task

OK, OUTSIDE, BAD = (Const(s, STATUS) for s in (Status.OK, Status.OUTSIDE_TUBE, Status.BAD_INPUT))


@dataclass(frozen=True)
class SplineKernels:
    """The kernels of the refined tube."""

    segment: Kernel
    basis: Kernel
    basis_rate: Kernel
    blend: Kernel


def refined_program(task: Task, design: RefinedDesign) -> Program:
    """Everything that is emitted for a refined design. Raises `BadInput` when the law's constants do not fit the scalar."""
    n = design.dimension
    spline = SplineKernels(_segment(design, task.emit.scalar), *_kernels_of_the_tube())
    law = control_law_of(task)
    tables = [_coefficients(design, task.emit.scalar), *law.tables]
    period = task.emit.tick_period
    clock = (segment_at_tick(design, ticks_of(design, period)),) if period is not None else ()
    guarded = Program(
        prefix=task.name,
        dimension=n,
        scalar=task.emit.scalar,
        tables=tuple(tables),
        kernels=(spline.segment, *clock, spline.basis, spline.basis_rate, spline.blend, *law.kernels),
        functions=(
            _tube(spline, n),
            _tube_rate(spline, design, n),
            *_controls(task, spline, law, n, True, clock),
            _margin(spline, n, True),
            transform_function(law, n),
        ),
    )
    if not _always_wide(design, guarded):
        return guarded
    unguarded = {f.name: f for f in (*_controls(task, spline, law, n, False, clock), _margin(spline, n, False))}
    return replace(guarded, functions=tuple(unguarded.get(f.name, f) for f in guarded.functions))


def _always_wide(design: RefinedDesign, program: Program) -> bool:
    """Whether the emitted edges are more than LEAST_WIDTH apart for every t: the width is a mean, with weights of sum 6, of
    the control points' widths, and the arithmetic moves each edge by no more than P7's bound."""
    table = design.integers()
    narrowest = 6 * int((table[:, :, UPPER] - table[:, :, LOWER]).min()) * design.unit
    return narrowest - 2 * max(edge_error(design, program)) > 2 * LEAST_WIDTH


@cache  # they depend on no task
def _kernels_of_the_tube() -> tuple[Kernel, Kernel, Kernel]:
    return (
        lower(refined_tube.basis(), ("6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6.",)),
        lower(refined_tube.basis_rate(), ("Derivative of the weights with respect to s.",)),
        lower(refined_tube.blend(), ("An edge of the tube (or its slope in spline time): sum of w_j q_j.",)),
    )


def _coefficients(design: RefinedDesign, scalar: str) -> Table:
    """The table. Raises `BadInput` where the scalar does not hold its numbers."""
    if design.significant > FORMATS[scalar].precision:
        raise BadInput(f'the tube needs {design.significant} bits, too many for a {scalar}; use emit.scalar = "double"')
    both = "float and " if design.significant <= FORMATS["float"].precision else ""
    values = tuple(v * design.unit for row in design.table for pair in row for v in pair)
    names = ", ".join(f"lower[{i}], upper[{i}]" for i in range(design.dimension))
    return Table(
        "coefficients",
        values,
        2 * design.dimension,
        (
            f"B-spline control points divided by 6, one row for each of {design.segments} + 3 points:",
            names if len(names) < 90 else "lower[0], upper[0], lower[1], upper[1], ...",
            f"Multiples of 2^{-design.bits}: exact in {both}double.",
        ),
    )


def _segment(design: RefinedDesign, scalar: str) -> Kernel:
    """t -> index of the segment's first table entry, and the place s in the segment, for finite t held within [0, t_c].

    Spline time is held at the last number below K: its floor is then a segment whatever t is, without a second clamp."""
    k = design.segments
    t = Var("t", REAL)
    block = Block({"t", "row", "s"})
    positive = block.op("positive", "lt", real(0), t)
    started = block.select("started", positive, t, real(0))
    scaled = block.op("scaled", "mul", started, real(Fraction(k) / design.prescribed_time))
    end = real(largest_below(Fraction(k), scalar))
    u = block.select("u", block.op("early", "lt", scaled, end), scaled, end)
    index = block.let("segment", Trunc(u))
    s = block.op("place", "sub", u, block.op("base", "real", index))
    row = block.op("first", "imul", index, integer(2 * design.dimension))
    return Kernel(
        name="segment",
        inputs=(t,),
        body=tuple(block.statements),  # type: ignore[arg-type]
        outputs=(row, s),
        output_names=("row", "s"),
        doc=(
            f"Spline time u = {k} t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).",
            f"Before 0 the start; from t_c on the last number below {k} (t_c = {decimal(design.prescribed_time)} s).",
        ),
    )


def _edge(block: Block, spline: SplineKernels, n: int, at: Operand, weights: tuple[Var, ...], side: int, name: str) -> Var:
    """Statements for one edge: four table entries, a row apart from table index `at` on, blended by the weights."""
    label = name.split("_", maxsplit=1)[0]
    entries = []
    for j in range(4):
        offset = 2 * n * j + side
        index = block.op(f"{label}_{j}", "iadd", at, integer(offset)) if offset else at
        entries.append(block.let(f"{label}_q{j}", Load("coefficients", index)))
    (edge,) = block.call(spline.blend, *weights, *entries, names=(name,))
    return edge


def _entry(block: Block, row: Operand, i: Operand) -> Var:
    """Table index of the first entry of dimension i."""
    return block.op("at", "iadd", row, block.op("pair", "imul", i, integer(2)))


def _start(names: set[str], spline: SplineKernels, fill: tuple[str, ...], n: int) -> tuple[Block, Var, Var]:
    """Finite test of t (outputs NaN where it fails), then the segment."""
    block = Block(names)
    finite = block.let("finite", IsFinite(Var("t", REAL)))
    bad = block.op("bad", "not", finite)
    with block.leave_when(bad), block.loop("j", n) as loop:
        for name in fill:
            block.store(name, loop.index, NAN)
    row, s = block.call(spline.segment, Var("t", REAL))
    return block, row, s


def _tube(spline: SplineKernels, n: int) -> Function:
    block, row, s = _start({"t", "lower", "upper"}, spline, ("lower", "upper"), n)
    weights = block.call(spline.basis, s)
    with block.loop("i", n) as loop:
        at = _entry(block, row, loop.index)
        for name, side in (("lower", LOWER), ("upper", UPPER)):
            block.store(name, loop.index, _edge(block, spline, n, at, weights, side, f"{name}_edge"))
    block.leave()
    return Function(
        "tube",
        (Param("t", None), Param("lower", n, True), Param("upper", n, True)),
        tuple(block.statements),
        False,
        (
            "Edges of the tube gamma at time t (seconds), in the task's units.",
            "t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.",
        ),
    )


def _tube_rate(spline: SplineKernels, design: RefinedDesign, n: int) -> Function:
    block, row, s = _start({"t", "lower_rate", "upper_rate"}, spline, ("lower_rate", "upper_rate"), n)
    weights = block.call(spline.basis_rate, s)
    over = block.op("moving", "lt", Var("t", REAL), real(design.prescribed_time))
    per_second = block.select("per_second", over, real(Fraction(design.segments) / design.prescribed_time), real(0))
    with block.loop("i", n) as loop:
        at = _entry(block, row, loop.index)
        for name, side in (("lower", LOWER), ("upper", UPPER)):
            slope = _edge(block, spline, n, at, weights, side, f"{name}_slope")
            block.store(f"{name}_rate", loop.index, block.op(f"{name}_speed", "mul", slope, per_second))
    block.leave()
    return Function(
        "tube_rate",
        (Param("t", None), Param("lower_rate", n, True), Param("upper_rate", n, True)),
        tuple(block.statements),
        False,
        (
            "Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.",
            "The rate at 0 before that and zero from t_c on; NaN when t is not finite.",
        ),
    )


def _margin(spline: SplineKernels, n: int, guarded: bool) -> Function:
    t = Var("t", REAL)
    block = Block({"t", "x"})
    bad = not_finite(block, (t,), (("x", n),))
    with block.leave_when(bad, NAN):
        pass
    row, s = block.call(spline.segment, t)
    weights = block.call(spline.basis, s)
    with block.loop("i", n) as loop:
        least = loop.carry("margin", real(Fraction(1, 2)))
        at = _entry(block, row, loop.index)
        lower_edge = _edge(block, spline, n, at, weights, LOWER, "lower_edge")
        upper_edge = _edge(block, spline, n, at, weights, UPPER, "upper_edge")
        share = margin_component(block, (lower_edge, upper_edge), block.let("x_i", Load("x", loop.index)), guarded)
        loop.update(least, block.select("margin_next", block.op("less", "lt", share, least), share, least))
    block.leave(least)
    return Function("margin", (Param("t", None), Param("x", n)), tuple(block.statements), False, MARGIN_DOC, True)


def _controls(
    task: Task, spline: SplineKernels, law: Law, n: int, guarded: bool, clock: tuple[Kernel, ...]
) -> tuple[Function, ...]:
    """`control`, and `control_tick` where there is a clock."""
    kernels = (spline.segment, *clock)
    return tuple(_control(task, replace(spline, segment=kernel), law, n, guarded) for kernel in kernels)


def _control(task: Task, spline: SplineKernels, law: Law, n: int, guarded: bool) -> Function:
    """The law at a time that is whatever `spline.segment` takes: seconds or a tick."""
    (when,) = spline.segment.inputs
    block = Block({when.name, "x", "u"})
    bad = not_finite(block, (when,) if when.type is REAL else (), (("x", n),))
    with block.leave_when(bad, BAD), block.loop("j", n) as loop:
        block.store("u", loop.index, real(0))
    row, s = block.call(spline.segment, when)
    weights = block.call(spline.basis, s)
    with block.loop("i", n) as loop:
        i = loop.index
        outside = loop.carry("outside", FALSE)
        at = _entry(block, row, i)
        lower_edge = _edge(block, spline, n, at, weights, LOWER, "lower_edge")
        upper_edge = _edge(block, spline, n, at, weights, UPPER, "upper_edge")
        x = block.let("x_i", Load("x", i))
        place = place_of(block, law.share(block, i), (lower_edge, upper_edge), x, law.signed_gain(block, i), guarded)
        loop.update(outside, block.select("outside_any", inside_of(block, place), outside, TRUE))
        block.store("u", i, control_component(block, law, place, law.limit(block, i)))
    block.leave(Select(outside, OUTSIDE, OK))
    times = "x" if when.type is TICK else "t or x"
    return Function(
        "control_tick" if when.type is TICK else "control",
        (Param(when.name, None, type=when.type), Param("x", n), Param("u", n, True)),
        tuple(block.statements),
        True,
        (
            law_doc(task, law),
            _time_doc(task) if when.type is TICK else "t: seconds since the start (held within [0, t_c]); x: state; u: input.",
            *axes_doc(task),
            "OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward"
            + inward_doc(task),
            f"(0 where the tube is empty). BAD_INPUT: {times} has a NaN or an infinity; u is 0. u may be the array x itself.",
        ),
    )


def _time_doc(task: Task) -> str:
    assert task.emit.tick_period is not None
    period = decimal(task.emit.tick_period)
    return f"tick: periods of {period} s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input."
