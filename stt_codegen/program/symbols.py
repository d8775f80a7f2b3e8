"""A reader that turns a kernel into SymPy expressions, branch by branch: what is proved is what is printed.

A kernel with comparisons is read once for every way they can come out; a branch is those conditions and the outputs there.
Numbers are the exact ones of the Program, before they are rounded to the scalar. For proofs only, never for printing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import sympy as sp

from stt_codegen.program.program import Assign, Kernel, Op, Operand, Select, Var

OPERATIONS: dict[str, Any] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
    "pow": lambda a, b: a**b,
    "fabs": sp.Abs,
    "sqrt": sp.sqrt,
    "exp": sp.exp,
    "expm1": lambda a: sp.exp(a) - 1,
    "log": sp.log,
    "log1p": lambda a: sp.log(1 + a),
    "tanh": sp.tanh,
    "sinh": sp.sinh,
    "cosh": sp.cosh,
    "atanh": sp.atanh,
    "sin": sp.sin,
    "cos": sp.cos,
    "tan": sp.tan,
    "exponent": sp.Function("exponent"),
    "mantissa": sp.Function("mantissa"),
    "real": lambda a: a,
}
COMPARISONS: dict[str, Any] = {"lt": sp.Lt, "le": sp.Le, "eq": sp.Eq, "ne": sp.Ne, "ilt": sp.Lt, "tlt": sp.Lt}
NEGATED: dict[str, Any] = {"lt": sp.Ge, "le": sp.Gt, "eq": sp.Ne, "ne": sp.Eq, "ilt": sp.Ge, "tlt": sp.Ge}


@dataclass(frozen=True)
class Branch:
    """One way through a kernel: what holds there, and the outputs, in the kernel's order."""

    conditions: tuple[Any, ...]
    outputs: tuple[Any, ...]

    def taken_at(self, numbers: Mapping[Any, Any]) -> bool:
        """Whether the conditions hold for these numbers: that a branch is the one of a regime, not just some branch."""
        return all(bool(sp.sympify(c).subs(numbers)) for c in self.conditions)


def branches(kernel: Kernel, given: Mapping[str, Any]) -> Iterator[Branch]:
    """Every way through the kernel, for inputs that are SymPy expressions. Raises `NotImplementedError`, naming it, for a node
    that is no formula (integers, loads)."""
    tests = [a.var.name for a in kernel.body if isinstance(a.value, Op) and a.value.name in COMPARISONS]
    for outcomes in product((True, False), repeat=len(tests)):
        yield _through(kernel, given, dict(zip(tests, outcomes, strict=True)))


def formulas(kernel: Kernel, given: Mapping[str, Any]) -> tuple[Any, ...]:
    """The outputs of a kernel without comparisons."""
    (only,) = branches(kernel, given)
    return only.outputs


def _through(kernel: Kernel, given: Mapping[str, Any], outcomes: Mapping[str, bool]) -> Branch:
    known: dict[str, Any] = dict(given)
    conditions: list[Any] = []

    def value(operand: Operand) -> Any:
        if isinstance(operand, Var):
            return known[operand.name]
        number = operand.value
        if isinstance(number, bool):
            return number
        return sp.Rational(Fraction(number).numerator, Fraction(number).denominator)  # type: ignore[arg-type]

    for assign in kernel.body:
        known[assign.var.name] = _assigned(assign, value, outcomes, conditions)
    return Branch(tuple(conditions), tuple(value(o) for o in kernel.outputs))


def _assigned(assign: Assign, value: Any, outcomes: Mapping[str, bool], conditions: list[Any]) -> Any:
    match assign.value:
        case Op(name=name, args=args) if name in COMPARISONS:
            holds = outcomes[assign.var.name]
            conditions.append((COMPARISONS if holds else NEGATED)[name](*map(value, args)))
            return holds
        case Op(name="and" | "or" | "not" as name, args=args):
            truths = [value(a) for a in args]
            return {"and": all(truths), "or": any(truths), "not": not truths[0]}[name]
        case Op(name=name, args=args) if name in OPERATIONS:
            return OPERATIONS[name](*map(value, args))
        case Select(condition=condition, then=then, other=other):
            return value(then) if value(condition) else value(other)
    raise NotImplementedError(f"{assign.var.name}: no formula for {assign.value}")
