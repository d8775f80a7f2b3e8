"""A reader that turns a kernel into SymPy expressions, branch by branch: what is proved is what is printed.

A kernel with comparisons is read once for every combination of their outcomes; a branch is those conditions and the outputs
under them. Numbers are the exact ones of the Program, before they are rounded to the scalar. For the proofs of lemmas/ only,
never for printing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import sympy as sp

from stt_codegen.program.nodes import Assign, Kernel, Op, Operand, Select, Var
from stt_codegen.program.operations import OPERATIONS


def formula_of(name: str, *args: Any) -> Any:
    """Return an operation on SymPy expressions. Raises `NotImplementedError` for one that is no formula."""
    formula = OPERATIONS[name].formula
    if formula is None:
        raise NotImplementedError(f"no formula for operation {name!r}")
    return formula(sp, *args)


@dataclass(frozen=True)
class Branch:
    """One way through a kernel: what holds there, and the outputs, in the kernel's order."""

    conditions: tuple[Any, ...]
    outputs: tuple[Any, ...]


def branches(kernel: Kernel, inputs: Mapping[str, Any]) -> Iterator[Branch]:
    """Yield every way through the kernel, for inputs that are SymPy expressions.

    Raises `NotImplementedError`, naming it, for a node that has no formula (integers, loads).
    """
    tests = [a.var.name for a in kernel.body if isinstance(a.value, Op) and OPERATIONS[a.value.name].compares]
    for outcomes in product((True, False), repeat=len(tests)):
        yield _branch_with(kernel, inputs, dict(zip(tests, outcomes, strict=True)))


def formulas(kernel: Kernel, inputs: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return the outputs, in symbols, of a kernel without comparisons."""
    (branch,) = branches(kernel, inputs)
    return branch.outputs


def _branch_with(kernel: Kernel, inputs: Mapping[str, Any], outcomes: Mapping[str, bool]) -> Branch:
    """Return the branch on which the comparisons, by the names of their results, come out so."""
    known: dict[str, Any] = dict(inputs)
    conditions: list[Any] = []

    def value(operand: Operand) -> Any:
        if isinstance(operand, Var):
            return known[operand.name]
        number = operand.value
        if isinstance(number, bool):
            return number
        return sp.Rational(Fraction(number).numerator, Fraction(number).denominator)  # type: ignore[arg-type]

    for assign in kernel.body:
        known[assign.var.name] = _assigned_value(assign, value, outcomes, conditions)
    return Branch(tuple(conditions), tuple(value(o) for o in kernel.outputs))


def _assigned_value(assign: Assign, value: Any, outcomes: Mapping[str, bool], conditions: list[Any]) -> Any:
    """Return what is assigned, `value` being that of an operand; a comparison adds its condition to `conditions`."""
    match assign.value:
        case Op(name=name, args=args) if OPERATIONS[name].compares:
            holds = outcomes[assign.var.name]
            compared = list(map(value, args))
            conditions.append(formula_of(name, *compared) if holds else getattr(sp, OPERATIONS[name].opposite)(*compared))
            return holds
        case Op(name="and" | "or" | "not" as name, args=args):
            truths = [value(a) for a in args]
            return {"and": all(truths), "or": any(truths), "not": not truths[0]}[name]
        case Op(name=name, args=args) if OPERATIONS[name].formula is not None:
            return formula_of(name, *map(value, args))
        case Select(condition=condition, then=then, otherwise=otherwise):
            return value(then) if value(condition) else value(otherwise)
    raise NotImplementedError(f"{assign.var.name}: no formula for {assign.value}")
