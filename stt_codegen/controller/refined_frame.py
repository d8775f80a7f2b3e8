"""The frame of a refined controller: finite test, spline time and segment, loop over dimensions, status."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from stt_codegen.controller.comments import axes_doc, inward_doc, law_doc
from stt_codegen.controller.covered_starts import covered_function, starts_of
from stt_codegen.controller.edge_errors import edge_error, rate_error
from stt_codegen.controller.inertial_frame import Filter, inertial_functions
from stt_codegen.controller.kernels import (
    MARGIN_DOC,
    MARGINS_DOC,
    Between,
    Law,
    SplineKernels,
    control_component,
    control_law_of,
    edge,
    entry,
    inside_of,
    kernels_of_the_tube,
    margin_component,
    not_finite,
    place_of,
    scale_input,
    segment_of,
    start,
    transform_function,
)
from stt_codegen.controller.ticks import segment_at_tick, ticks_of
from stt_codegen.decimals import decimal
from stt_codegen.designs import LOWER, MINIMUM_WIDTH, UPPER, RefinedDesign, filtered_edges
from stt_codegen.errors import BadInput
from stt_codegen.program import (
    FALSE,
    FORMATS,
    NAN,
    REAL,
    STATUS,
    TICK,
    TRUE,
    Block,
    Const,
    Function,
    Kernel,
    Load,
    Param,
    Program,
    Select,
    Status,
    Table,
    Var,
    real,
)
from stt_codegen.task import Task

OK, OUTSIDE, BAD = (Const(s, STATUS) for s in (Status.OK, Status.OUTSIDE_TUBE, Status.BAD_INPUT))


def refined_program(task: Task, design: RefinedDesign) -> Program:
    """Everything that is emitted for a refined design. Raises `BadInput` when the law's constants do not fit the scalar."""
    n = design.dimension
    spline = SplineKernels(segment_of(design, task.emit.scalar), *kernels_of_the_tube())
    law = control_law_of(task)
    tables = [_coefficients(design, task.emit.scalar), *(Filter.of(design).tables if design.filter else []), *law.tables]
    covered: tuple[Function, ...] = ()
    if design.capabilities.emits_covered_starts:
        tables += starts_of(task, design).tables(task.emit.scalar, design.unit)
        covered = (covered_function(task, n, Filter.of(design).of_component if design.filter else None),)
    period = task.emit.tick_period
    clock = (segment_at_tick(design, ticks_of(design, period)),) if period is not None else ()

    def functions(guarded: bool) -> tuple[Function, ...]:
        """Those of the law."""
        if design.filter:
            return inertial_functions(task, spline, design, law, guarded, clock)
        return (*_controls(task, spline, law, n, guarded, clock), _margin(spline, n, guarded), _margins(spline, n, guarded))

    made = Program(
        prefix=task.name,
        dimension=n,
        scalar=task.emit.scalar,
        tables=tuple(tables),
        kernels=(spline.segment, *clock, spline.basis, spline.basis_rate, spline.blend, *law.kernels),
        functions=(_tube(spline, n), _tube_rate(spline, design, n), *functions(True), *covered, transform_function(law, n)),
    )
    if not _always_wide(design, made):
        return made
    unguarded = {f.name: f for f in functions(False)}
    return replace(made, functions=tuple(unguarded.get(f.name, f) for f in made.functions))


def _always_wide(design: RefinedDesign, program: Program) -> bool:
    """Whether the emitted edges are more than MINIMUM_WIDTH apart for every t: the width is a mean, with weights of sum 6, of
    the control points' widths, and the arithmetic moves each edge by no more than P7's bound."""
    table = design.integers()
    narrowest = 6 * int((table[:, :, UPPER] - table[:, :, LOWER]).min()) * design.unit
    if narrowest - 2 * max(edge_error(design, program)) <= 2 * MINIMUM_WIDTH:
        return False
    if not design.filter:
        return True
    pieces, wrong = (
        filtered_edges(design),
        zip(edge_error(design, program), rate_error(design, program), design.filter, strict=True),
    )
    room = int((pieces.coefficients[:, :, UPPER] - pieces.coefficients[:, :, LOWER]).min()) * pieces.unit
    return room - 2 * max(r + v * e for e, r, v in wrong) > 2 * MINIMUM_WIDTH


def _coefficients(design: RefinedDesign, scalar: str) -> Table:
    """The table. Raises `BadInput` where the scalar does not hold its numbers."""
    if design.coefficient_bits > FORMATS[scalar].precision:
        raise BadInput(f'the tube needs {design.coefficient_bits} bits, too many for a {scalar}; use emit.scalar = "double"')
    both = "float and " if design.coefficient_bits <= FORMATS["float"].precision else ""
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


def _tube(spline: SplineKernels, n: int) -> Function:
    block, row, s = start({"t", "lower", "upper"}, spline, ("lower", "upper"), n)
    weights = block.call(spline.basis, s)
    with block.loop("i", n) as loop:
        at = entry(block, row, loop.index)
        for name, side in (("lower", LOWER), ("upper", UPPER)):
            block.store(name, loop.index, edge(block, spline, n, at, weights, side, f"{name}_edge"))
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
    block, row, s = start({"t", "lower_rate", "upper_rate"}, spline, ("lower_rate", "upper_rate"), n)
    weights = block.call(spline.basis_rate, s)
    over = block.op("moving", "lt", Var("t", REAL), real(design.prescribed_time))
    per_second = block.select("per_second", over, real(Fraction(design.segments) / design.prescribed_time), real(0))
    with block.loop("i", n) as loop:
        at = entry(block, row, loop.index)
        for name, side in (("lower", LOWER), ("upper", UPPER)):
            slope = edge(block, spline, n, at, weights, side, f"{name}_slope")
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
        at = entry(block, row, loop.index)
        lower_edge = edge(block, spline, n, at, weights, LOWER, "lower_edge")
        upper_edge = edge(block, spline, n, at, weights, UPPER, "upper_edge")
        share = margin_component(block, Between(lower_edge, upper_edge, block.let("x_i", Load("x", loop.index))), guarded)
        loop.update(least, block.select("margin_next", block.op("less", "lt", share, least), share, least))
    block.leave(least)
    return Function("margin", (Param("t", None), Param("x", n)), tuple(block.statements), False, MARGIN_DOC, returns_real=True)


def _margins(spline: SplineKernels, n: int, guarded: bool) -> Function:
    """The public `margins`: the margin by component."""
    block, row, s = start({"t", "x", "margin"}, spline, ("margin",), n)
    weights = block.call(spline.basis, s)
    with block.loop("i", n) as loop:
        at = entry(block, row, loop.index)
        lower_edge = edge(block, spline, n, at, weights, LOWER, "lower_edge")
        upper_edge = edge(block, spline, n, at, weights, UPPER, "upper_edge")
        x = block.let("x_i", Load("x", loop.index))
        block.store("margin", loop.index, margin_component(block, Between(lower_edge, upper_edge, x), guarded))
    block.leave()
    params = (Param("t", None), Param("x", n), Param("margin", n, True))
    return Function("margins", params, tuple(block.statements), False, MARGINS_DOC)


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
        at = entry(block, row, i)
        lower_edge = edge(block, spline, n, at, weights, LOWER, "lower_edge")
        upper_edge = edge(block, spline, n, at, weights, UPPER, "upper_edge")
        x = block.let("x_i", Load("x", i))
        place = place_of(block, law.share(block, i), Between(lower_edge, upper_edge, x), law.signed_gain(block, i), guarded)
        loop.update(outside, block.select("outside_any", inside_of(block, place), outside, TRUE))
        block.store("u", i, control_component(block, law, place, law.limit(block, i)))
    scale_input(block, law, n)
    block.leave(Select(outside, OUTSIDE, OK))
    times = "x" if when.type is TICK else "t or x"
    return Function(
        "control_tick" if when.type is TICK else "control",
        (Param(when.name, None, type=when.type), Param("x", n), Param("u", n, True)),
        tuple(block.statements),
        True,
        (
            law_doc(task, law),
            _time_doc(task, when.type is TICK),
            *axes_doc(task),
            "OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward"
            + inward_doc(task),
            f"(0 where the tube is empty). BAD_INPUT: {times} has a NaN or an infinity; u is 0. u may be the array x itself.",
        ),
    )


def _time_doc(task: Task, ticks: bool) -> str:
    if not ticks:
        since = f"seconds, as {task.name}_wrap turns them back" if task.repeat else "seconds since the start"
        return f"t: {since} (held within [0, t_c]); x: state; u: input."
    assert task.emit.tick_period is not None
    period = decimal(task.emit.tick_period)
    if task.repeat:
        return f"tick: periods of {period} s, as {task.name}_wrap_tick turns them back; x: state; u: input."
    return f"tick: periods of {period} s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input."
