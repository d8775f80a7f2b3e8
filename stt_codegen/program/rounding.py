"""A reader that bounds the rounding error of a kernel: for every value its range and how far it may be from the truth.

Forward analysis in exact fractions: each operation adds at most half a unit in the last place of its result's range
(plus half the least subnormal), a function of the C library 2 units. The operations are those of the refined tube and of the
edges (10), and what has a range in its row; a kernel with other nodes is an error here.
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
        return max(abs(self.low), abs(self.high))


def rounding_error(kernel: Kernel, inputs: Mapping[str, Inexact], scalar: str) -> tuple[Inexact, ...]:
    """Range and error bound of each output of `kernel`, for inputs in the given ranges, in this scalar type."""
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
    a = args[0]
    result: Inexact
    match op.name:
        case "neg":
            return Inexact(-a.high, -a.low, a.error)
        case "fabs":
            return Inexact(Fraction(0) if a.low <= 0 <= a.high else min(abs(a.low), abs(a.high)), a.size, a.error)
        case "div" if args[1].low == args[1].high > 0:  # by a constant
            by = args[1]
            least = by.low - by.error
            return rounded(min(a.low / by.low, a.high / by.low), a.high / by.low, (a.error + a.size / by.low * by.error) / least)
        case "add" | "sub" | "mul":
            b = args[1]
        case _:
            return _of_library(op.name, a, rounded)
    if op.name == "add":
        result = rounded(a.low + b.low, a.high + b.high, a.error + b.error)
    elif op.name == "sub":
        result = rounded(a.low - b.high, a.high - b.low, a.error + b.error)
    else:
        corners = [x * y for x in (a.low, a.high) for y in (b.low, b.high)]
        low = Fraction(0) if op.args[0] == op.args[1] and a.low <= 0 <= a.high else min(corners)
        result = rounded(low, max(corners), a.size * b.error + b.size * a.error + a.error * b.error)
    return result


def _of_library(name: str, a: Inexact, rounded: Callable[[Fraction, Fraction, Fraction], Inexact]) -> Inexact:
    """A function of one argument, from its row: each `rounded` adds half a unit."""
    row = OPERATIONS[name]
    found = None if row.ranged is None else row.ranged(a.low, a.high, a.error)
    if found is None or row.ulps is None:
        raise NotImplementedError(f"no rounding bound for operation {name!r} on [{float(a.low):g}, {float(a.high):g}]")
    result = Inexact(*found)
    for _ in range(math.ceil(2 * row.ulps)):
        result = rounded(result.low, result.high, result.error)
    return result
