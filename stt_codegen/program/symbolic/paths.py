"""A reader that follows one function of a Program down the path that given numbers take, and says what it returns there as SymPy
formulas: the frame (finite test, clamps, segment index, loops, status), not only the kernels.

The function runs twice over the same statements: in doubles, which decides every comparison, and in symbols, which takes those
decisions. Points with the same decisions are on one path. Table entries stay symbols, `name(index)`; kernels that a lemma of
their own is about may stay opaque, `name_k(inputs)` for output k. For proofs only, never for printing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy as sp

from stt_codegen.program.nodes import Const, Function, Kernel, Program, Return, Status
from stt_codegen.program.operations import OPERATIONS, REAL
from stt_codegen.program.symbolic.symbols import formula_of
from stt_codegen.program.walk import Walk

Value = Any


@dataclass(frozen=True)
class Path:
    """What a function returns on one path: `outputs` by array, `result` a Status, a real or None; `decisions` of every
    comparison on the way."""

    outputs: Mapping[str, tuple[Value, ...]]
    result: Value
    decisions: tuple[bool, ...]


def follow(program: Program, function: str, given: Mapping[str, Value], opaque: frozenset[str] = frozenset()) -> Path:
    """The function in doubles; `given` has a number for every scalar and a sequence for every array. What opaque kernels
    decide is not noted."""
    return _Walk(program, given, None, opaque).run(program.function(function))


def formulas_on(
    program: Program, function: str, symbols: Mapping[str, Value], path: Path, opaque: frozenset[str] = frozenset()
) -> Path:
    """The same path in symbols, with the same kernels opaque."""
    return _Walk(program, symbols, list(path.decisions), opaque).run(program.function(function))


def follow_kernel(kernel: Kernel, numbers: Sequence[float]) -> tuple[bool, ...]:
    """The decisions that a kernel takes for these inputs, evaluated in doubles."""
    walk = _Walk(Program("", 1, "double", (), (kernel,), functions=()), {}, None, frozenset())
    walk.kernel(kernel, numbers)
    return tuple(walk.decisions)


def kernel_formulas(kernel: Kernel, symbols: Sequence[Value], decisions: Sequence[bool]) -> tuple[Value, ...]:
    """A kernel's outputs in symbols, on the path with these decisions."""
    walk = _Walk(Program("", 1, "double", (), (kernel,), functions=()), {}, list(decisions), frozenset())
    return tuple(walk.kernel(kernel, symbols))


class _Left(Exception):
    """Raised where a Return ends the walk."""

    def __init__(self, result: Value) -> None:
        self.result = result


class _Walk(Walk):
    """taken: decisions to take; None: decide by number and note."""

    def __init__(self, program: Program, given: Mapping[str, Value], taken: list[bool] | None, opaque: frozenset[str]) -> None:
        super().__init__(program)
        self.given, self.taken, self.opaque = given, taken, opaque
        self.decisions: list[bool] = []

    @property
    def symbolic(self) -> bool:
        return self.taken is not None

    def run(self, function: Function) -> Path:
        for p in function.params:
            if p.length is None:
                self.known[p.name] = self.given[p.name]
            else:
                self.arrays[p.name] = list(self.given[p.name]) if p.name in self.given else [None] * p.length
        result = None
        try:
            self.statements(function.body)
        except _Left as left:
            result = left.result
        outputs = {p.name: tuple(self.arrays[p.name]) for p in function.outputs}
        return Path(outputs, result, tuple(self.decisions))

    def leave(self, statement: Return) -> None:
        if statement.when is None or self.operand(statement.when):
            self.statements(statement.body)
            raise _Left(None if statement.status is None else self.value(statement.status))

    def kernel(self, kernel: Kernel, args: Sequence[Value]) -> list[Value]:
        if self.symbolic and kernel.name in self.opaque:
            return [sp.Function(f"{kernel.name}_{k}", real=True)(*args) for k in range(len(kernel.outputs))]
        noted = len(self.decisions)
        outputs = super().kernel(kernel, args)
        if kernel.name in self.opaque:  # its decisions are not the frame's
            del self.decisions[noted:]
        return outputs

    def constant(self, constant: Const) -> Value:
        number = constant.value
        if number is None:
            return sp.nan if self.symbolic else math.nan
        if isinstance(number, bool | Status) or constant.type is not REAL:
            return number
        exact = Fraction(number)
        return sp.Rational(exact.numerator, exact.denominator) if self.symbolic else float(exact)

    def select(self, condition: Value, then: Value, otherwise: Value) -> Value:
        return then if condition else otherwise

    def finite(self, value: Value) -> Value:
        return self.decide(math.isfinite, value)

    def trunc(self, value: Value) -> Value:
        return sp.floor(value) if self.symbolic else math.trunc(value)

    def operation(self, name: str, args: list[Value]) -> Value:
        row = OPERATIONS[name]
        if row.compares:
            return self.decide(row.number, *args)
        if self.symbolic and name == "idiv" and not all(isinstance(a, int) for a in args):
            return sp.floor(sp.Rational(1, args[1]) * args[0])
        if row.result is REAL and self.symbolic:
            return formula_of(name, *args)
        if name == "exponent" and self.symbolic:
            return formula_of(name, *args)
        return args[0] if name == "int" else row.number(*args)

    def decide(self, test: Callable[..., bool], *args: Value) -> bool:
        outcome = bool(test(*args)) if self.taken is None else self.taken.pop(0)
        self.decisions.append(outcome)
        return outcome

    def entry(self, table: str, index: Value) -> Value:
        if self.symbolic:
            return sp.Function(table, real=True)(sp.expand(index))
        return float(self.program.table(table).values[index])
