"""The functions of a controller for a plant of order 2, in floating point.

The law keeps v + lambda x in the filtered tube; kernels/inertial_parts.py has its distances to the edges. refined_frame.py calls
`build_inertial_functions`. Functions named `write_..` append statements to a block of a Program and return the variables that
hold the results. Strings that they pass are names in emitted code.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from stt_codegen.controller.comments import axes_doc, inward_doc, law_doc
from stt_codegen.controller.kernels import (
    MARGINS_DOC,
    ControlLaw,
    FilteredDistances,
    InertialParts,
    LambdaFilter,
    SplineKernels,
    SplinePosition,
    begin_block_at_time,
    write_clamped_distances,
    write_has_non_finite,
    write_input,
    write_is_inside,
    write_margin,
)
from stt_codegen.decimals import decimal
from stt_codegen.designs import RefinedDesign
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
    Param,
    Select,
    Status,
    Var,
    real,
)
from stt_codegen.task import Task

OK, OUTSIDE, BAD = (Const(s, STATUS) for s in (Status.OK, Status.OUTSIDE_TUBE, Status.BAD_INPUT))


def build_inertial_functions(
    task: Task,
    design: RefinedDesign,
    spline: SplineKernels,
    law: ControlLaw,
    *,
    tick_segments: tuple[Kernel, ...],
) -> tuple[Function, ...]:
    """Build `filtered_tube`, `velocity` where the task uses differences, `control`, `margin` and `margins`.

    tick_segments: the segment kernel of ticks, for `control_tick`; empty without ticks."""
    parts = InertialParts(spline, LambdaFilter.of(design), design.dimension)
    velocity = (_build_velocity(task, parts.n),) if task.uses_differences else ()
    controls = (
        _build_control(task, replace(parts, spline=replace(spline, segment=segment)), law)
        for segment in (spline.segment, *tick_segments)
    )
    return (_build_filtered_tube(parts), *velocity, *controls, _build_margin(parts), _build_margins(parts))


def _build_velocity(task: Task, n: int) -> Function:
    """Build `velocity`: v (n,) by differences of two samples of x."""
    dt = Var("dt", REAL)
    block = Block({"dt", "x", "x_before", "v"})
    is_positive = block.op("positive", "lt", real(0), dt)
    divisor = block.select("step", is_positive, dt, real(1))
    with block.loop("i", n) as loop:
        x, x_before = (block.let(f"{name}_i", Load(name, loop.index)) for name in ("x", "x_before"))
        mean_velocity = block.op("mean", "div", block.op("moved", "sub", x, x_before), divisor)
        block.store("v", loop.index, block.select("v_i", is_positive, mean_velocity, NAN))
    block.leave()
    doc = (
        "Velocity by differences, v = (x - x_before) / dt, for `control`: dt is the time between both samples, as it was and",
        f"not as it should have been, from {decimal(task.shortest_period)} to {decimal(task.sampling_period)} s.",
        "At the first sample, at rest, v is 0. x_before is yours: put x there afterwards. NaN where dt is not positive, and",
        "`control` then says BAD_INPUT.",
    )
    params = (Param("dt", None), Param("x", n), Param("x_before", n), Param("v", n, output=True))
    return Function("velocity", params, tuple(block.statements), returns_status=False, doc=doc)


def _build_filtered_tube(parts: InertialParts) -> Function:
    """Build `filtered_tube`: the edges L' + lambda L and R' + lambda R (n,) at time t."""
    n = parts.n
    block, row, s = begin_block_at_time({"t", "lower", "upper"}, parts.spline, ("lower", "upper"), n)
    position = SplinePosition(row, block.call(parts.spline.basis, s), block.call(parts.spline.basis_rate, s))
    with block.loop("i", n) as loop:
        edges = parts.write_edges(block, position, loop.index)
        lambda_ = parts.filter.write_component(block, loop.index)
        for name, edge, rate in (("lower", edges.lower, edges.lower_rate), ("upper", edges.upper, edges.upper_rate)):
            filtered_edge = block.op(f"z_{name}", "add", rate, block.op(f"{name}_part", "mul", edge, lambda_))
            block.store(name, loop.index, filtered_edge)
    block.leave()
    doc = (
        f"Edges of the filtered tube at time t, in units per second: of v + lambda x, lambda = {parts.filter}.",
        "While v + lambda x is between them, x stays in the tube. NaN when t is not finite.",
    )
    params = (Param("t", None), Param("lower", n, output=True), Param("upper", n, output=True))
    return Function("filtered_tube", params, tuple(block.statements), returns_status=False, doc=doc)


def _build_control(task: Task, parts: InertialParts, law: ControlLaw) -> Function:
    """Build `control`, or `control_tick` where the segment kernel of `parts` takes a tick: u (n,) by (13) and the status."""
    n = parts.n
    (time,) = parts.spline.segment.inputs
    is_tick = time.type is TICK
    block = Block({time.name, "x", "v", "u"})
    is_bad = write_has_non_finite(block, () if is_tick else (time,), (("x", n), ("v", n)))
    with block.leave_when(is_bad, BAD), block.loop("m", n) as loop:
        block.store("u", loop.index, real(0))
    position = parts.write_position(block, time)
    with block.loop("i", n) as loop:
        i = loop.index
        is_outside = loop.carry("outside", FALSE)
        filtered = parts.write_filtered_distances(block, position, i)
        clamp_share, signed_gain = law.write_clamp_share(block, i), law.write_signed_gain(block, i)
        distances = write_clamped_distances(block, clamp_share, filtered, signed_gain, is_width_guarded=False)
        to_lower, to_upper = filtered.of_x.to_edges
        is_above_lower = block.op("x_above", "lt", real(0), to_lower)
        is_x_inside = block.op("x_inside", "and", is_above_lower, block.op("x_below", "lt", real(0), to_upper))
        is_inside = block.op("inside", "and", write_is_inside(block, distances, "z_inside"), is_x_inside)
        loop.update(is_outside, block.select("outside_next", is_inside, is_outside, TRUE))
        block.store("u", i, write_input(block, law, distances, law.write_u_max(block, i)))
    block.leave(Select(is_outside, OUTSIDE, OK))
    tested_inputs = "x or v" if is_tick else "t, x or v"
    doc = (
        law_doc(task, law),
        f"for v + lambda x in its tube, lambda = {parts.filter}. "
        + (_tick_doc(task) if is_tick else "t: seconds since the start (held within [0, t_c]);"),
        "x: state; v: its rate; u: input.",
        *axes_doc(task),
        "OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law,",
        f"finite, and points inward{inward_doc(task)} (0 where the tube is empty). BAD_INPUT: {tested_inputs} has a NaN or an",
        "infinity; u is 0. u may be the array x or v itself.",
    )
    params = (Param(time.name, None, type=time.type), Param("x", n), Param("v", n), Param("u", n, output=True))
    return Function("control_tick" if is_tick else "control", params, tuple(block.statements), returns_status=True, doc=doc)


def _tick_doc(task: Task) -> str:
    """Return the part of the comment of `control_tick` that explains the tick."""
    assert task.emit.tick_period is not None
    return f"tick: periods of {decimal(task.emit.tick_period)} s since the start (it must not wrap to 0: stop counting at t_c);"


def _build_margin(parts: InertialParts) -> Function:
    """Build `margin`: the smallest margin over the components of x and of v + lambda x."""
    n = parts.n
    t = Var("t", REAL)
    block = Block({"t", "x", "v"})
    is_bad = write_has_non_finite(block, (t,), (("x", n), ("v", n)))
    with block.leave_when(is_bad, NAN):
        pass
    position = parts.write_position(block, t)
    with block.loop("i", n) as loop:
        smallest = loop.carry("margin", real(Fraction(1, 2)))
        distances = parts.write_filtered_distances(block, position, loop.index)
        margin = _write_smaller_margin(block, distances)
        is_smaller = block.op("less", "lt", margin, smallest)
        loop.update(smallest, block.select("margin_next", is_smaller, margin, smallest))
    block.leave(smallest)
    doc = (
        "How far x is from leaving the tube, and v + lambda x from leaving its own: the distance to the nearest edge",
        "over the width there, the lesser of both, least over the components. 0.5 in the middle, positive inside,",
        "negative outside, at least -1; NaN when an argument is not finite.",
        "Watch it: act while there is margin, not when the tube is left.",
    )
    params = (Param("t", None), Param("x", n), Param("v", n))
    return Function("margin", params, tuple(block.statements), returns_status=False, doc=doc, returns_real=True)


def _write_smaller_margin(block: Block, distances: FilteredDistances) -> Var:
    """Write statements for the smaller one of two margins: that of v + lambda x in the filtered tube, that of x in the tube."""
    filtered_margin = write_margin(block, distances, label="z", is_width_guarded=False)
    x_margin = write_margin(block, distances.of_x, is_width_guarded=False)
    is_x_smaller = block.op("x_smaller", "lt", x_margin, filtered_margin)  # false for a NaN of v, so that the result is NaN
    return block.select("smaller", is_x_smaller, x_margin, filtered_margin)


def _build_margins(parts: InertialParts) -> Function:
    """Build `margins`: by component (n,) the smaller margin of v + lambda x and of x."""
    n = parts.n
    t = Var("t", REAL)
    block = Block({"t", "x", "v", "margin"})
    is_bad = block.op("bad", "not", block.let("finite", IsFinite(t)))
    with block.leave_when(is_bad), block.loop("j", n) as loop:
        block.store("margin", loop.index, NAN)
    position = parts.write_position(block, t)
    with block.loop("i", n) as loop:
        distances = parts.write_filtered_distances(block, position, loop.index)
        block.store("margin", loop.index, _write_smaller_margin(block, distances))
    block.leave()
    params = (Param("t", None), Param("x", n), Param("v", n), Param("margin", n, output=True))
    return Function("margins", params, tuple(block.statements), returns_status=False, doc=MARGINS_DOC)
