"""A refined design as a program of integers."""

from __future__ import annotations

from stt_codegen.controller.covered_starts import starts_of
from stt_codegen.controller.integers.constants import law_of, law_tables, narrow_of, narrowest, table
from stt_codegen.controller.integers.frame import Frame
from stt_codegen.controller.integers.inertial_integer_frame import Filter, InertialFrame
from stt_codegen.controller.integers.integer_errors import require_right
from stt_codegen.controller.integers.integer_kernels import clock_of, curve_kernel, push_kernel, rate_of, segment_kernel
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.program import Program, Table
from stt_codegen.task import Task

STEP_BITS = 15  # a step from one control point to the next is within so many bits


def fixed_program(task: Task, design: RefinedDesign) -> Program:
    """`tube`, `control` and `margin` at a tick. Raises `BadInput` for what has no such program."""
    n, period = design.dimension, task.emit.tick_period
    assert period is not None  # task/checks/field_checks.py
    steps = int(abs(design.integers()[1:] - design.integers()[:-1]).max())
    if steps >= 1 << STEP_BITS:
        told = f"a step of {steps} units is beyond the {STEP_BITS} bits that integers have"
        raise BadInput(f"tube.segments: {told}; use more segments")
    segment, narrow = segment_kernel(clock_of(design, period), design), narrow_of(narrowest(design)[0] / design.unit)
    require_right(task, design)
    frame: Frame = Frame(n, segment, law_of(task, design), narrow)
    if design.filter:
        frame = InertialFrame(n, segment, frame.law, narrow, rate_of(design), Filter.of(design.filter))
    kernels = (*frame.of_time, frame.edge, curve_kernel(), push_kernel())
    starts = starts_of(task, design).tables("fixed", design.unit)
    tables = (*_tube_tables(design), *frame.tables, *law_tables(frame.law), *starts)
    return Program(task.name, n, "fixed", tables, kernels, functions=frame.functions(task), tick=period)


def _tube_tables(design: RefinedDesign) -> tuple[Table, ...]:
    entries = tuple(v for row in design.table for pair in row for v in pair)
    doc = f"B-spline control points divided by 6, in 2^-{design.bits}, a row for each of {design.segments} + 3 points."
    return (table("coefficients", entries, 2 * design.dimension, doc),)
