"""A reader that follows one function of a Program along the path that numbers take, and says what it returns there as SymPy
formulas: of the whole function (finite test, clamps, segment index, loops, status), not only of its kernels.

The function runs twice over the same statements: in doubles, which decides every comparison, and in symbols, which takes those
decisions. Points with the same decisions are on one path. Table entries stay symbols, `name(index)`; a kernel that has its own
lemma may stay opaque, `name_k(inputs)` for output k. For the proofs of lemmas/ only, never for printing.
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


def follow(program: Program, function: str, inputs: Mapping[str, Value], opaque: frozenset[str] = frozenset()) -> Path:
    """Return the path of a function in doubles; `inputs` has a number for every scalar and a sequence for every array.

    The decisions of opaque kernels are not noted.
    """
    return _PathWalk(program, inputs, None, opaque).run(program.function(function))


def formulas_on(
    program: Program, function: str, symbols: Mapping[str, Value], path: Path, opaque: frozenset[str] = frozenset()
) -> Path:
    """Return the same path in symbols, with the same kernels opaque."""
    return _PathWalk(program, symbols, list(path.decisions), opaque).run(program.function(function))


def follow_kernel(kernel: Kernel, numbers: Sequence[float]) -> tuple[bool, ...]:
    """Return the decisions that a kernel takes for these inputs, evaluated in doubles."""
    walk = _PathWalk(Program("", 1, "double", (), (kernel,), functions=()), {}, None, frozenset())
    walk.run_kernel(kernel, numbers)
    return tuple(walk.decisions)


def kernel_formulas(kernel: Kernel, symbols: Sequence[Value], decisions: Sequence[bool]) -> tuple[Value, ...]:
    """Return a kernel's outputs in symbols, on the path with these decisions."""
    walk = _PathWalk(Program("", 1, "double", (), (kernel,), functions=()), {}, list(decisions), frozenset())
    return tuple(walk.run_kernel(kernel, symbols))


class _FunctionLeft(Exception):
    """Raised where a Return ends the walk."""

    def __init__(self, result: Value) -> None:
        self.result = result


class _PathWalk(Walk):
    """Runs a function on one path. prescribed: decisions still to be taken, of a walk in symbols; None: numbers decide.

    decisions: those taken so far.
    """

    def __init__(
        self, program: Program, inputs: Mapping[str, Value], prescribed: list[bool] | None, opaque: frozenset[str]
    ) -> None:
        super().__init__(program)
        self.inputs, self.prescribed, self.opaque = inputs, prescribed, opaque
        self.decisions: list[bool] = []

    @property
    def is_symbolic(self) -> bool:
        """Whether the walk is in symbols, on a prescribed path."""
        return self.prescribed is not None

    def run(self, function: Function) -> Path:
        """Return what the function gives for the inputs."""
        for p in function.params:
            if p.length is None:
                self.known[p.name] = self.inputs[p.name]
            else:
                self.arrays[p.name] = list(self.inputs[p.name]) if p.name in self.inputs else [None] * p.length
        result = None
        try:
            self.run_statements(function.body)
        except _FunctionLeft as leave:
            result = leave.result
        outputs = {p.name: tuple(self.arrays[p.name]) for p in function.outputs}
        return Path(outputs, result, tuple(self.decisions))

    def leave(self, statement: Return) -> None:
        """Leave the function, where the statement's condition holds, by `_FunctionLeft`."""
        if statement.when is None or self.operand(statement.when):
            self.run_statements(statement.body)
            raise _FunctionLeft(None if statement.status is None else self.value(statement.status))

    def run_kernel(self, kernel: Kernel, args: Sequence[Value]) -> list[Value]:
        """Return the outputs of a kernel: in symbols those of an opaque one are functions that nothing is known of."""
        if self.is_symbolic and kernel.name in self.opaque:
            return [sp.Function(f"{kernel.name}_{k}", real=True)(*args) for k in range(len(kernel.outputs))]
        decisions_before = len(self.decisions)
        outputs = super().run_kernel(kernel, args)
        if kernel.name in self.opaque:  # a walk in symbols does not run it, and so takes none of its decisions
            del self.decisions[decisions_before:]
        return outputs

    def constant(self, constant: Const) -> Value:
        """Return a constant as a double, or exactly in symbols."""
        number = constant.value
        if number is None:
            return sp.nan if self.is_symbolic else math.nan
        if isinstance(number, bool | Status) or constant.type is not REAL:
            return number
        exact = Fraction(number)
        return sp.Rational(exact.numerator, exact.denominator) if self.is_symbolic else float(exact)

    def select(self, condition: Value, then: Value, otherwise: Value) -> Value:
        return then if condition else otherwise

    def finite(self, value: Value) -> Value:
        return self.decide(math.isfinite, value)

    def trunc(self, value: Value) -> Value:
        return sp.floor(value) if self.is_symbolic else math.trunc(value)

    def operation(self, name: str, args: list[Value]) -> Value:
        """Return an operation on doubles, or its formula in symbols; a comparison is decided."""
        row = OPERATIONS[name]
        if row.compares:
            return self.decide(row.number, *args)
        if self.is_symbolic and name == "idiv" and not all(isinstance(a, int) for a in args):
            return sp.floor(sp.Rational(1, args[1]) * args[0])
        if row.result is REAL and self.is_symbolic:
            return formula_of(name, *args)
        if name == "exponent" and self.is_symbolic:
            return formula_of(name, *args)
        return args[0] if name == "int" else row.number(*args)

    def decide(self, test: Callable[..., bool], *args: Value) -> bool:
        """Return the outcome of a test, or the next decision of the path, and note it."""
        outcome = bool(test(*args)) if self.prescribed is None else self.prescribed.pop(0)
        self.decisions.append(outcome)
        return outcome

    def entry(self, table: str, index: Value) -> Value:
        """Return an entry of a table as a double, or as the symbol `table(index)`."""
        if self.is_symbolic:
            return sp.Function(table, real=True)(sp.expand(index))
        return float(self.program.table(table).values[index])
