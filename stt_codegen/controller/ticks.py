"""Time as a count of equal periods, exact over the whole mission: where float seconds run out of resolution, ticks do not.

A tick of P seconds is P K / t_c segments = numerator/denominator in lowest terms. Segment and rest are integers, so only the last
quotient, s = rest / denominator, is rounded: s is within 3 eps of the true place, less than the `time_error` of seconds, and P7
covers it. rest <= denominator makes s <= 1; at t_c and after it is the last segment with s = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.decimals import decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.program import TICK, Block, Const, Kernel, Var, integer, real

MOST = 1 << 31  # what an int32_t holds


@dataclass(frozen=True)
class Ticks:
    """One tick in segments, numerator/denominator; `last`: the first tick that is not before t_c."""

    numerator: int
    denominator: int
    last: int


def ticks_of(design: RefinedDesign, period: Fraction) -> Ticks:
    """Raises `BadInput` when the integers that the period leads to do not fit 32 bits."""
    ticks = _fitting(design, period)
    if ticks is None:
        rounded = (_to_digits(period, digits) for digits in (6, 5, 4, 3, 2, 1))
        coarser = (Fraction(10) ** k * m for k in range(-9, 3) for m in (1, 2, 5))
        near = next((p for p in (*rounded, *(c for c in coarser if c > period)) if _fitting(design, p)), None)
        made = f"{decimal(period)} s over {decimal(design.prescribed_time)} s and {design.segments} segments"
        advice = f"{decimal(near)} s makes smaller ones" if near else "make prescribed_time a number of fewer digits"
        raise BadInput(f"emit.tick_period: {made} makes integers beyond 31 bits; {advice}")
    return ticks


def _fitting(design: RefinedDesign, period: Fraction) -> Ticks | None:
    share = period * design.segments / design.prescribed_time
    whole = design.segments * share.denominator
    return None if whole + share.numerator >= MOST else Ticks(share.numerator, share.denominator, -(-whole // share.numerator))


def _to_digits(value: Fraction, digits: int) -> Fraction:
    """The value rounded to so many significant decimal digits."""
    return Fraction(f"{float(value):.{digits}g}")


def segment_at_tick(design: RefinedDesign, ticks: Ticks) -> Kernel:
    """tick -> index of the segment's first table entry, and the place s in it, as the kernel `segment` for seconds."""
    k, den = design.segments, ticks.denominator
    tick = Var("tick", TICK)
    block = Block({"tick", "row", "s"})
    last = Const(ticks.last, TICK)
    held = block.select("held", block.op("running", "tlt", tick, last), tick, last)
    passed = block.op("passed", "imul", block.op("count", "int", held), integer(ticks.numerator))
    place = block.select("place", block.op("early", "ilt", passed, integer(k * den)), passed, integer(k * den))
    whole = block.op("whole", "idiv", place, integer(den))
    index = block.select("segment", block.op("before_last", "ilt", whole, integer(k - 1)), whole, integer(k - 1))
    rest = block.op("rest", "isub", place, block.op("base", "imul", index, integer(den)))
    s = block.op("share", "div", block.op("part", "real", rest), real(den))
    row = block.op("first", "imul", index, integer(2 * design.dimension))
    return Kernel(
        name="segment_at_tick",
        inputs=(tick,),
        body=tuple(block.statements),  # type: ignore[arg-type]
        outputs=(row, s),
        output_names=("row", "s"),
        doc=(
            f"As segment, for a count of ticks: one is {ticks.numerator}/{den} of a segment, in integers; only s is rounded.",
            f"From tick {ticks.last} on the last segment and s = 1, which is t_c.",
        ),
    )
