"""The program of a refined controller in integers, for `emit.scalar = "fixed"`. pipeline.py calls `fixed_program`."""

from __future__ import annotations

from stt_codegen.controller.covered_starts import compute_covered_starts
from stt_codegen.controller.integers.constants import (
    build_integer_law,
    build_law_tables,
    integer_table,
    law_width,
    smallest_widths,
)
from stt_codegen.controller.integers.frame import IntegerController
from stt_codegen.controller.integers.inertial_integer_frame import InertialIntegerController, IntegerLambdaFilter
from stt_codegen.controller.integers.integer_errors import require_accurate_law
from stt_codegen.controller.integers.integer_kernels import (
    build_curve_kernel,
    build_input_size_kernel,
    build_integer_segment_kernel,
    choose_clock,
    choose_rate_scale,
)
from stt_codegen.decimals import decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.program import FORMATS, Program, Table
from stt_codegen.task import Task

STEP_BITS = 15  # a step from one control point to the next is within so many bits, without its sign


def fixed_program(task: Task, design: RefinedDesign) -> Program:
    """Build all that is emitted in integers for a refined design: `tube`, `control`, `margin`, `margins` and `covered` at a tick.

    Raises `BadInput` where 32 bits do not hold the tube or the law, or are not accurate enough."""
    tick_period = task.emit.tick_period
    assert tick_period is not None  # task/checks/field_checks.py
    if design.unit / 2 > FORMATS["fixed"].roundoff * task.largest_coordinate:  # P9 allows for so large an error of x
        problem = f"counts x in units of {decimal(design.unit)}, which is too coarse beside {decimal(task.largest_coordinate)}"
        raise BadInput(f"tube: {problem}: the sampling conditions allow for x in 20 bits; give its table more bits")
    largest_step = int(abs(design.integers()[1:] - design.integers()[:-1]).max())
    if largest_step >= 1 << STEP_BITS:
        problem = f"a step of {largest_step} units is beyond the {STEP_BITS} bits that integers have"
        raise BadInput(f"tube.segments: {problem}; use more segments")
    segment = build_integer_segment_kernel(choose_clock(design, tick_period), design)
    require_accurate_law(task, design)
    n, law = design.dimension, build_integer_law(task, design)
    smallest_width = law_width(smallest_widths(design)[0] / design.unit)
    controller = IntegerController(n, segment, law, smallest_width)
    if design.filter:
        rate_scale, lambda_filter = choose_rate_scale(design), IntegerLambdaFilter.of(design.filter)
        controller = InertialIntegerController(n, segment, law, smallest_width, rate_scale=rate_scale, filter=lambda_filter)
    kernels = (*controller.time_kernels, controller.edge_kernel, build_curve_kernel(), build_input_size_kernel())
    start_tables = compute_covered_starts(task, design).tables("fixed", design.unit)
    tables = (_build_coefficient_table(design), *controller.tables, *build_law_tables(law), *start_tables)
    return Program(task.name, n, "fixed", tables, kernels, functions=controller.functions(task), tick=tick_period)


def certified_constants(task: Task, design: RefinedDesign) -> dict[str, int]:
    """Return the constants of the emitted arithmetic by name, as the certificate states them for a checker (`integers`)."""
    assert task.emit.tick_period is not None  # task/checks/field_checks.py
    clock, law = choose_clock(design, task.emit.tick_period), build_integer_law(task, design)
    constants = {
        "clock_bits": clock.bits,
        "clock_scale": clock.scale,
        "smallest_width": law.smallest_width,
        "largest_e": law.largest_e,
        "smallest_y": law.smallest_y,
        "u_bits": law.u_bits,
    }
    if not design.filter:
        return constants
    rate_scale = choose_rate_scale(design)
    return constants | {
        "smallest_x_width": law_width(smallest_widths(design)[0] / design.unit),
        "rate_mantissa": rate_scale.mantissa,
        "rate_shift": rate_scale.product_shift,
        "rate_bits": rate_scale.weight_bits,
        "filter_bits": IntegerLambdaFilter.of(design.filter).bits,
    }


def _build_coefficient_table(design: RefinedDesign) -> Table:
    """Build the table of control points, in units of x; a row has the lower and the upper edge of each dimension."""
    entries = tuple(v for row in design.table for pair in row for v in pair)
    doc = f"B-spline control points divided by 6, in 2^-{design.bits}, a row for each of {design.segments} + 3 points."
    return integer_table("coefficients", entries, 2 * design.dimension, doc)
