"""A reader that bounds the rounding error of a kernel: for every value its exact range and its largest error.

Forward analysis in exact fractions: each operation adds at most half a unit in the last place of its result's range
(plus half the least subnormal), a function of the C library 2 units. It knows the operations that have `ranged` in their row, and
raises `NotImplementedError` for a kernel with other nodes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.program.nodes import Kernel, Op, Operand, Var
from stt_codegen.program.number import FORMATS, round_to
from stt_codegen.program.operations import OPERATIONS


@dataclass(frozen=True)
class Inexact:
    """The true value lies in [low, high]; the computed one differs from it by at most `error`."""

    low: Fraction
    high: Fraction
    error: Fraction = Fraction(0)

    @property
    def size(self) -> Fraction:
        """The largest absolute value."""
        return max(abs(self.low), abs(self.high))


def rounding_error(kernel: Kernel, inputs: Mapping[str, Inexact], scalar: str) -> tuple[Inexact, ...]:
    """Return range and error bound of each output of `kernel`, for inputs in these ranges, in this scalar type."""
    form = FORMATS[scalar]
    known: dict[str, Inexact] = dict(inputs)

    def value(operand: Operand) -> Inexact:
        if isinstance(operand, Var):
            return known[operand.name]
        exact = Fraction(operand.value)  # type: ignore[arg-type]
        return Inexact(exact, exact, abs(round_to(exact, scalar) - exact))

    def rounded(low: Fraction, high: Fraction, error: Fraction) -> Inexact:
        size = max(abs(low), abs(high)) + error
        return Inexact(low, high, error + size * form.roundoff + form.tiny)

    for assign in kernel.body:
        if not isinstance(assign.value, Op):
            raise NotImplementedError(f"{kernel.name}: no rounding bound for {type(assign.value).__name__}")
        known[assign.var.name] = _operation(assign.value, [value(a) for a in assign.value.args], rounded)
    return tuple(value(o) for o in kernel.outputs)


def _operation(op: Op, args: list[Inexact], rounded: Callable[[Fraction, Fraction, Fraction], Inexact]) -> Inexact:
    """Return the range and error of an operation, by its row; each call of `rounded` adds half a unit in the last place."""
    row = OPERATIONS[op.name]
    bounds = None if row.ranged is None else row.ranged(*args)
    if bounds is None or row.ulps is None:
        low, high = float(args[0].low), float(args[0].high)
        raise NotImplementedError(f"no rounding bound for operation {op.name!r} on [{low:g}, {high:g}]")
    result = Inexact(*bounds)
    for _ in range(math.ceil(2 * row.ulps)):
        result = rounded(result.low, result.high, result.error)
    return result
