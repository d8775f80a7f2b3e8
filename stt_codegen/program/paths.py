"""A reader that follows one function of a Program down the path that given numbers take, and says what it returns there as SymPy
formulas: the frame (finite test, clamps, segment index, loops, status), not only the kernels.

The function runs twice over the same statements: in doubles, which decides every comparison, and in symbols, which takes those
decisions. Points with the same decisions are on one path. Table entries stay symbols, `name(index)`; kernels that a lemma of
their own is about may stay opaque, `name_k(inputs)` for output k. For proofs only, never for printing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import sympy as sp

from stt_codegen.program.nodes import (
    Assign,
    Call,
    Const,
    Expression,
    For,
    Function,
    IsFinite,
    Kernel,
    Load,
    Op,
    Operand,
    Program,
    Return,
    Select,
    Statement,
    Status,
    Store,
    Trunc,
    Var,
)
from stt_codegen.program.operations import OPERATIONS, REAL
from stt_codegen.program.symbols import formula_of

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
    """What a kernel decides for these inputs, in doubles."""
    walk = _Walk(Program("", 1, "double", (), (kernel,), ()), {}, None, frozenset())
    walk.kernel(kernel, numbers)
    return tuple(walk.decisions)


def kernel_formulas(kernel: Kernel, symbols: Sequence[Value], decisions: Sequence[bool]) -> tuple[Value, ...]:
    """The outputs of a kernel where it decides so."""
    walk = _Walk(Program("", 1, "double", (), (kernel,), ()), {}, list(decisions), frozenset())
    return tuple(walk.kernel(kernel, symbols))


class _Left(Exception):
    """A Return was met."""

    def __init__(self, result: Value) -> None:
        self.result = result


@dataclass
class _Walk:
    program: Program
    given: Mapping[str, Value]
    taken: list[bool] | None  # decisions to take; None: decide by number and note
    opaque: frozenset[str]
    known: dict[str, Value] = field(default_factory=dict)
    arrays: dict[str, list[Value]] = field(default_factory=dict)
    decisions: list[bool] = field(default_factory=list)

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

    def statements(self, body: Sequence[Statement]) -> None:
        for statement in body:
            match statement:
                case Assign(var=var, value=value):
                    self.known[var.name] = self.value(value)
                case Call(results=results, kernel=kernel, args=args):
                    values = self.kernel(self.program.kernel(kernel), [self.operand(a) for a in args])
                    self.known |= dict(zip((r.name for r in results), values, strict=True))
                case Store(array=array, index=index, value=value):
                    self.arrays[array][self.operand(index)] = self.operand(value)
                case For(index=index, count=count, body=inner, carries=carries):
                    self.known |= {c.var.name: self.operand(c.initial) for c in carries}
                    for k in range(count):
                        self.known[index.name] = k
                        self.statements(inner)
                        self.known |= {c.var.name: self.operand(c.next) for c in carries}
                case Return(status=status, when=when, body=inner):
                    if when is None or self.operand(when):
                        self.statements(inner)
                        raise _Left(None if status is None else self.value(status))

    def kernel(self, kernel: Kernel, args: Sequence[Value]) -> list[Value]:
        if self.symbolic and kernel.name in self.opaque:
            return [sp.Function(f"{kernel.name}_{k}", real=True)(*args) for k in range(len(kernel.outputs))]
        outer, self.known = self.known, dict(zip((v.name for v in kernel.inputs), args, strict=True))
        quiet = kernel.name in self.opaque  # its decisions are not the frame's
        noted = len(self.decisions)
        for assign in kernel.body:
            self.known[assign.var.name] = self.value(assign.value)
        outputs = [self.operand(o) for o in kernel.outputs]
        self.known = outer
        if quiet:
            del self.decisions[noted:]
        return outputs

    def operand(self, operand: Operand) -> Value:
        if isinstance(operand, Var):
            return self.known[operand.name]
        number = operand.value
        if number is None:
            return sp.nan if self.symbolic else math.nan
        if isinstance(number, bool | Status) or operand.type is not REAL:
            return number
        exact = Fraction(number)
        return sp.Rational(exact.numerator, exact.denominator) if self.symbolic else float(exact)

    def value(self, expression: Expression) -> Value:
        match expression:
            case Var() | Const():
                return self.operand(expression)
            case Select(condition=condition, then=then, other=other):
                return self.operand(then) if self.operand(condition) else self.operand(other)
            case IsFinite(arg=arg):
                return self.decide(math.isfinite, self.operand(arg))
            case Trunc(arg=arg):
                number = self.operand(arg)
                return sp.floor(number) if self.symbolic else math.trunc(number)
            case Load(array=array, index=index):
                return self.load(array, self.operand(index))
            case Op(name=name, args=args):
                return self.operation(name, [self.operand(a) for a in args])
        raise NotImplementedError(f"{expression}")

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

    def load(self, array: str, index: Value) -> Value:
        if array in self.arrays:
            return self.arrays[array][index]
        if self.symbolic:
            return sp.Function(array, real=True)(sp.expand(index))
        return float(self.program.table(array).values[index])
