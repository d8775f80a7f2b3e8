"""Estimate the cycles of a step on an ATmega328P, so that `generate` can say when an Arduino Uno is too slow for a period.

It is no bound: the operations of the Program, times the cycles of each. These were fitted to counts of simavr over six example
tasks (avr-gcc 5.4, -Os as in Arduino's IDE), with an error of 3 %; for a seventh, attitude in integers, the error is 9 %.
`benchmarks/sketch_time.py` counts again, and fails where an error exceeds `RELATIVE_ERROR`. record/sketch.py calls this.
"""

from __future__ import annotations

from fractions import Fraction

from stt_codegen.pipeline import EmittedController
from stt_codegen.program.analyse import cost_of

CLOCK_FREQUENCY = 16_000_000  # Hz
RELATIVE_ERROR = Fraction(1, 10)  # of the estimate, for the longest call of `control` that was counted
FLOAT_CYCLES = {"add": 151, "mul": 151, "div": 509, "math": 2139}  # with comparisons and integer operations around them
INTEGER_CYCLES = {"mul": 157}
DEFAULT_INTEGER_CYCLES = 6.7  # of every integer operation that the table above does not have
INTEGER_TO_FLOAT_RATIO = Fraction(1, 2)  # cycles in integers are below this share of those in floats, for the same task


def step_cycles(controller: EmittedController) -> int | None:
    """Estimate the cycles of the longest call of `control` on an Uno; None for designs and scalars that were not counted."""
    if not controller.design.capabilities.has_cycle_estimate or controller.program.scalar == "double":
        return None
    operations = cost_of(controller.program, "control")
    if controller.program.scalar == "fixed":
        return round(sum(count * INTEGER_CYCLES.get(kind, DEFAULT_INTEGER_CYCLES) for kind, count in operations.items()))
    return sum(count * FLOAT_CYCLES.get(kind, 0) for kind, count in operations.items())
