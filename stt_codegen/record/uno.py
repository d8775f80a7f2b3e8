"""About how many cycles a step takes on an ATmega328P, so that `generate` can say when an Uno does not keep a period.

An estimate, no bound: the operations of the Program, times what each takes there, by a fit to counts of simavr over six example
tasks (avr-gcc 5.4, -Os as in Arduino's IDE). `benchmarks/sketch_time.py` counts again; it fails where one is off by more
than `ERROR`. Of those it is off by 3 %, of a seventh, attitude in integers, by 9 %.
"""

from __future__ import annotations

from fractions import Fraction

from stt_codegen.pipeline import EmittedController
from stt_codegen.program.analyse import cost_of

CLOCK = 16_000_000  # cycles a second
ERROR = Fraction(1, 10)  # of the estimate, for the longest call of `control` that was counted
FLOATS = {"add": 151, "mul": 151, "div": 509, "math": 2139}  # cycles; comparisons and integers are in the first two
INTEGERS = {"mul": 157}
INTEGER = 6.7  # cycles of every other operation of integers
INTEGERS_SHARE = Fraction(1, 2)  # of the floats' cycles: integers of the same task take less


def step_cycles(controller: EmittedController) -> int | None:
    """About the most cycles of a call of `control` on an Uno; None for what cannot be linked or was not counted there."""
    if not controller.design.capabilities.has_cycle_estimate or controller.program.scalar == "double":
        return None
    operations = cost_of(controller.program, "control")
    if controller.program.scalar == "fixed":
        return round(sum(count * INTEGERS.get(kind, INTEGER) for kind, count in operations.items()))
    return sum(count * FLOATS.get(kind, 0) for kind, count in operations.items())
