"""Time as a count of equal periods, exact over the whole mission: where float seconds run out of resolution, ticks do not.

A tick of P seconds is P K / t_c segments, K the number of segments: numerator/denominator in lowest terms. Segment and remainder
are integers, so only the last quotient, s = remainder / denominator, is rounded. s is within 3 eps of the exact position, eps
half a unit in the last place of 1. That is less than the `spline_time_error` of seconds (edge_errors.py), so P7 covers it.
remainder <= denominator makes s <= 1; from t_c on, s = 1 in the last segment.

refined_frame.py calls this file for `emit.tick_period`, and the lemmas `functions.*` check against its constants.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.decimals import decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.program import TICK, Block, Const, Kernel, Var, integer, real

INTEGER_LIMIT = 1 << 31  # the integers of the emitted kernel are below this, as an int32_t must be


@dataclass(frozen=True)
class TickConstants:
    """The length of a tick, numerator/denominator segments; end_tick: the first tick that is not before t_c."""

    numerator: int
    denominator: int
    end_tick: int


def tick_constants(design: RefinedDesign, period: Fraction) -> TickConstants:
    """Return the constants for ticks of `period` seconds.

    Raises `BadInput` when they lead to integers beyond 31 bits; the message names a period near this one that does not."""
    constants = _constants_within_limit(design, period)
    if constants is None:
        fewer_digits = (_to_digits(period, digits) for digits in (6, 5, 4, 3, 2, 1))
        round_periods = (Fraction(10) ** k * m for k in range(-9, 3) for m in (1, 2, 5))
        candidates = (*fewer_digits, *(p for p in round_periods if p > period))
        remedy = next((p for p in candidates if _constants_within_limit(design, p)), None)
        cause = f"{decimal(period)} s over {decimal(design.prescribed_time)} s and {design.segments} segments"
        advice = f"{decimal(remedy)} s makes smaller ones" if remedy else "make prescribed_time a number of fewer digits"
        raise BadInput(f"emit.tick_period: {cause} makes integers beyond 31 bits; {advice}")
    return constants


def _constants_within_limit(design: RefinedDesign, period: Fraction) -> TickConstants | None:
    """Return the constants for this period; None where an integer of the emitted kernel would reach INTEGER_LIMIT."""
    length = period * design.segments / design.prescribed_time  # segments
    end = design.segments * length.denominator
    if end + length.numerator >= INTEGER_LIMIT:
        return None
    return TickConstants(length.numerator, length.denominator, -(-end // length.numerator))


def _to_digits(value: Fraction, digits: int) -> Fraction:
    """Return the value rounded to this number of significant decimal digits."""
    return Fraction(f"{float(value):.{digits}g}")


def build_tick_segment_kernel(design: RefinedDesign, constants: TickConstants) -> Kernel:
    """Build the kernel from a tick to (index of the segment's first table entry, position s in the segment).

    It is the counterpart of the kernel `segment`, which takes seconds. Strings are names in emitted code."""
    k, denominator = design.segments, constants.denominator
    tick = Var("tick", TICK)
    block = Block({"tick", "row", "s"})
    end_tick = Const(constants.end_tick, TICK)
    clamped_tick = block.select("held", block.op("running", "tlt", tick, end_tick), tick, end_tick)
    passed = block.op("passed", "imul", block.op("count", "int", clamped_tick), integer(constants.numerator))
    end = integer(k * denominator)
    spline_time = block.select("place", block.op("early", "ilt", passed, end), passed, end)  # in 1/denominator of a segment
    floor = block.op("whole", "idiv", spline_time, integer(denominator))
    segment_index = block.select("segment", block.op("before_last", "ilt", floor, integer(k - 1)), floor, integer(k - 1))
    remainder = block.op("rest", "isub", spline_time, block.op("base", "imul", segment_index, integer(denominator)))
    s = block.op("share", "div", block.op("part", "real", remainder), real(denominator))
    row = block.op("first", "imul", segment_index, integer(2 * design.dimension))
    ratio = f"{constants.numerator}/{denominator}"
    return Kernel(
        name="segment_at_tick",
        inputs=(tick,),
        body=tuple(block.statements),  # type: ignore[arg-type]
        outputs=(row, s),
        output_names=("row", "s"),
        doc=(
            f"As segment, for a count of ticks: one is {ratio} of a segment, in integers; only s is rounded.",
            f"From tick {constants.end_tick} on the last segment and s = 1, which is t_c.",
        ),
    )
