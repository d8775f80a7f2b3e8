"""The program of a refined controller in floating point; inertial_frame.py has the functions that differ for plants of order 2.

pipeline.py calls `refined_program`. Each `_build_..` returns one public function of the emitted code: finite test, segment of the
spline, loop over the components, status. Strings that it passes to a block are names in emitted code. The lemmas `functions.*` of
docs/lemmas.md are about these functions.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from stt_codegen.controller.comments import axes_doc, inward_doc, law_doc
from stt_codegen.controller.covered_starts import build_covered, compute_covered_starts
from stt_codegen.controller.inertial_frame import build_inertial_functions
from stt_codegen.controller.kernels import (
    MARGIN_DOC,
    MARGINS_DOC,
    ControlLaw,
    LambdaFilter,
    SplineKernels,
    ValueBetweenEdges,
    begin_block_at_time,
    build_blending_kernels,
    build_control_law,
    build_segment_kernel,
    build_transform,
    write_clamped_distances,
    write_edge,
    write_edge_indices,
    write_edges,
    write_has_non_finite,
    write_input,
    write_input_scaling,
    write_is_inside,
    write_margin,
)
from stt_codegen.controller.ticks import build_tick_segment_kernel, tick_constants
from stt_codegen.decimals import decimal
from stt_codegen.designs import LOWER, UPPER, RefinedDesign
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
    """Build all that is emitted for a refined design. Raises `BadInput` when the law's constants do not fit the scalar.

    The functions that calculate with the width take it as it is: P1 keeps the edges NARROWEST_WIDTH apart, rounding included."""
    n = design.dimension
    spline = SplineKernels(build_segment_kernel(design, task.emit.scalar), *build_blending_kernels(n))
    law = build_control_law(task)
    lambda_filter = LambdaFilter.of(design) if design.filter else None
    filter_tables = lambda_filter.tables if lambda_filter is not None else []
    tables = [_build_coefficient_table(design, task.emit.scalar), *filter_tables, *law.tables]
    covered: tuple[Function, ...] = ()
    if design.capabilities.emits_covered_starts:
        tables += compute_covered_starts(task, design).tables(task.emit.scalar, design.unit)
        covered = (build_covered(task, n, lambda_filter.write_component if lambda_filter is not None else None),)
    tick_period = task.emit.tick_period
    tick_segments: tuple[Kernel, ...] = ()
    if tick_period is not None:
        tick_segments = (build_tick_segment_kernel(design, tick_constants(design, tick_period)),)

    if design.filter:
        law_functions = build_inertial_functions(task, design, spline, law, tick_segments=tick_segments)
    else:
        segments = (spline.segment, *tick_segments)
        controls = (_build_control(task, replace(spline, segment=segment), law, n) for segment in segments)
        law_functions = (*controls, _build_margin(spline, n), _build_margins(spline, n))
    return Program(
        prefix=task.name,
        dimension=n,
        scalar=task.emit.scalar,
        tables=tuple(tables),
        kernels=(spline.segment, *tick_segments, spline.basis, spline.basis_rate, spline.edge_at, *law.kernels),
        functions=(
            _build_tube(spline, n),
            _build_tube_rate(spline, design, n),
            *law_functions,
            *covered,
            build_transform(law, n),
        ),
    )


def _build_coefficient_table(design: RefinedDesign, scalar: str) -> Table:
    """Build the table of control points. Raises `BadInput` where the scalar does not hold its numbers exactly."""
    if design.coefficient_bits > FORMATS[scalar].precision:
        raise BadInput(f'the tube needs {design.coefficient_bits} bits, too many for a {scalar}; use emit.scalar = "double"')
    exact_formats = "float and " if design.coefficient_bits <= FORMATS["float"].precision else ""
    values = tuple(v * design.unit for row in design.table for pair in row for v in pair)
    names = ", ".join(f"lower[{i}], upper[{i}]" for i in range(design.dimension))
    return Table(
        "coefficients",
        values,
        2 * design.dimension,
        (
            f"B-spline control points divided by 6, one row for each of {design.segments} + 3 points:",
            names if len(names) < 90 else "lower[0], upper[0], lower[1], upper[1], ...",
            f"Multiples of 2^{-design.bits}: exact in {exact_formats}double.",
        ),
    )


def _build_tube(spline: SplineKernels, n: int) -> Function:
    """Build `tube`: the edges gamma (n,) at time t."""
    block, row, s = begin_block_at_time({"t", "lower", "upper"}, spline, ("lower", "upper"), n)
    weights = block.call(spline.basis, s)
    with block.loop("i", n) as loop:
        lower_edge, upper_edge = write_edges(block, spline, write_edge_indices(block, row, loop.index), weights)
        block.store("lower", loop.index, lower_edge)
        block.store("upper", loop.index, upper_edge)
    block.leave()
    doc = (
        "Edges of the tube gamma at time t (seconds), in the task's units.",
        "t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.",
    )
    params = (Param("t", None), Param("lower", n, output=True), Param("upper", n, output=True))
    return Function("tube", params, tuple(block.statements), returns_status=False, doc=doc)


def _build_tube_rate(spline: SplineKernels, design: RefinedDesign, n: int) -> Function:
    """Build `tube_rate`: the rates of the edges (n,) at time t."""
    block, row, s = begin_block_at_time({"t", "lower_rate", "upper_rate"}, spline, ("lower_rate", "upper_rate"), n)
    weights = block.call(spline.basis_rate, s)
    is_moving = block.op("moving", "lt", Var("t", REAL), real(design.prescribed_time))
    segments_per_second = real(Fraction(design.segments) / design.prescribed_time)
    segment_rate = block.select("per_second", is_moving, segments_per_second, real(0))
    with block.loop("i", n) as loop:
        speeds = []
        for index, name in zip(write_edge_indices(block, row, loop.index), ("lower", "upper"), strict=True):
            slope = write_edge(block, spline, index, weights, f"{name}_slope")
            speeds.append(block.op(f"{name}_speed", "mul", slope, segment_rate))
        block.store("lower_rate", loop.index, speeds[LOWER])
        block.store("upper_rate", loop.index, speeds[UPPER])
    block.leave()
    doc = (
        "Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.",
        "The rate at 0 before that and zero from t_c on; NaN when t is not finite.",
    )
    params = (Param("t", None), Param("lower_rate", n, output=True), Param("upper_rate", n, output=True))
    return Function("tube_rate", params, tuple(block.statements), returns_status=False, doc=doc)


def _write_x_between_edges(
    block: Block, spline: SplineKernels, position: tuple[Var, tuple[Var, ...]], i: Var
) -> ValueBetweenEdges:
    """Write statements for component i of x and its edges. position: table index of the segment's row, and the weights."""
    row, weights = position
    lower_edge, upper_edge = write_edges(block, spline, write_edge_indices(block, row, i), weights)
    return ValueBetweenEdges(lower_edge, upper_edge, block.let("x_i", Load("x", i)))


def _build_margin(spline: SplineKernels, n: int) -> Function:
    """Build `margin`: the smallest margin over the components of x."""
    t = Var("t", REAL)
    block = Block({"t", "x"})
    is_bad = write_has_non_finite(block, (t,), (("x", n),))
    with block.leave_when(is_bad, NAN):
        pass
    row, s = block.call(spline.segment, t)
    weights = block.call(spline.basis, s)
    with block.loop("i", n) as loop:
        smallest = loop.carry("margin", real(Fraction(1, 2)))
        value = _write_x_between_edges(block, spline, (row, weights), loop.index)
        margin = write_margin(block, value, is_width_guarded=False)
        is_smaller = block.op("less", "lt", margin, smallest)
        loop.update(smallest, block.select("margin_next", is_smaller, margin, smallest))
    block.leave(smallest)
    params = (Param("t", None), Param("x", n))
    return Function("margin", params, tuple(block.statements), returns_status=False, doc=MARGIN_DOC, returns_real=True)


def _build_margins(spline: SplineKernels, n: int) -> Function:
    """Build `margins`: the margin by component (n,)."""
    block, row, s = begin_block_at_time({"t", "x", "margin"}, spline, ("margin",), n)
    weights = block.call(spline.basis, s)
    with block.loop("i", n) as loop:
        value = _write_x_between_edges(block, spline, (row, weights), loop.index)
        block.store("margin", loop.index, write_margin(block, value, is_width_guarded=False))
    block.leave()
    params = (Param("t", None), Param("x", n), Param("margin", n, output=True))
    return Function("margins", params, tuple(block.statements), returns_status=False, doc=MARGINS_DOC)


def _build_control(task: Task, spline: SplineKernels, law: ControlLaw, n: int) -> Function:
    """Build `control`, or `control_tick` where the segment kernel of `spline` takes a tick: u (n,) by (13) and the status."""
    (time,) = spline.segment.inputs
    is_tick = time.type is TICK
    block = Block({time.name, "x", "u"})
    is_bad = write_has_non_finite(block, () if is_tick else (time,), (("x", n),))
    with block.leave_when(is_bad, BAD), block.loop("m", n) as loop:
        block.store("u", loop.index, real(0))
    row, s = block.call(spline.segment, time)
    weights = block.call(spline.basis, s)
    with block.loop("i", n) as loop:
        i = loop.index
        is_outside = loop.carry("outside", FALSE)
        value = _write_x_between_edges(block, spline, (row, weights), i)
        clamp_share, signed_gain = law.write_clamp_share(block, i), law.write_signed_gain(block, i)
        distances = write_clamped_distances(block, clamp_share, value, signed_gain, is_width_guarded=False)
        loop.update(is_outside, block.select("outside_next", write_is_inside(block, distances), is_outside, TRUE))
        block.store("u", i, write_input(block, law, distances, law.write_u_max(block, i)))
    write_input_scaling(block, law, n)
    block.leave(Select(is_outside, OUTSIDE, OK))
    tested_inputs = "x" if is_tick else "t or x"
    doc = (
        law_doc(task, law),
        _time_doc(task, is_tick),
        *axes_doc(task),
        "OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward"
        + inward_doc(task),
        f"(0 where the tube is empty). BAD_INPUT: {tested_inputs} has a NaN or an infinity; u is 0. u may be the array x itself.",
    )
    params = (Param(time.name, None, type=time.type), Param("x", n), Param("u", n, output=True))
    name = "control_tick" if is_tick else "control"
    return Function(name, params, tuple(block.statements), returns_status=True, doc=doc)


def _time_doc(task: Task, is_tick: bool) -> str:
    """Return the line of the comment of `control`, or of `control_tick`, that explains its time, x and u."""
    if not is_tick:
        origin = f"seconds, as {task.name}_wrap turns them back" if task.repeat else "seconds since the start"
        return f"t: {origin} (held within [0, t_c]); x: state; u: input."
    assert task.emit.tick_period is not None
    period = decimal(task.emit.tick_period)
    if task.repeat:
        return f"tick: periods of {period} s, as {task.name}_wrap_tick turns them back; x: state; u: input."
    return f"tick: periods of {period} s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input."
