"""A SymPy expression together with its value at one point, with which lemmas run the package's own code.

Lemmas pass it in the place of doubles and fractions; NumPy calculates with it in arrays of dtype object. Comparisons go by the
value. So an expression that the code returns holds on the path which the point takes, and a lemma needs one point for each path.
`recorded_comparisons` records <, <=, > and >=; it does not see comparisons of float(expression), nor those inside of abs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp


@dataclass(frozen=True)
class EvaluatedExpression:
    """expression: of SymPy. value: what it is at the lemma's point."""

    expression: Any
    value: float

    def __float__(self) -> float:
        return self.value

    def exp(self) -> EvaluatedExpression:
        return EvaluatedExpression(sp.exp(self.expression), float(np.exp(self.value)))

    def log(self) -> EvaluatedExpression:
        return EvaluatedExpression(sp.log(self.expression), float(np.log(self.value)))

    def cosh(self) -> EvaluatedExpression:
        return EvaluatedExpression(sp.cosh(self.expression), float(np.cosh(self.value)))

    def tanh(self) -> EvaluatedExpression:
        return EvaluatedExpression(sp.tanh(self.expression), float(np.tanh(self.value)))

    def __neg__(self) -> EvaluatedExpression:
        return EvaluatedExpression(-self.expression, -self.value)

    def __add__(self, operand: Any) -> Any:
        return _combine(self, operand, lambda a, b: a + b)

    def __radd__(self, operand: Any) -> Any:
        return _combine(operand, self, lambda a, b: a + b)

    def __sub__(self, operand: Any) -> Any:
        return _combine(self, operand, lambda a, b: a - b)

    def __rsub__(self, operand: Any) -> Any:
        return _combine(operand, self, lambda a, b: a - b)

    def __mul__(self, operand: Any) -> Any:
        return _combine(self, operand, lambda a, b: a * b)

    def __rmul__(self, operand: Any) -> Any:
        return _combine(operand, self, lambda a, b: a * b)

    def __truediv__(self, operand: Any) -> Any:
        return _combine(self, operand, lambda a, b: a / b)

    def __rtruediv__(self, operand: Any) -> Any:
        return _combine(operand, self, lambda a, b: a / b)

    def __pow__(self, power: int) -> EvaluatedExpression:
        return EvaluatedExpression(self.expression**power, self.value**power)

    def __abs__(self) -> EvaluatedExpression:
        return self if self.value >= 0 else -self

    def __lt__(self, operand: Any) -> bool:
        return _record_comparison(self, operand, self.value < float(operand))

    def __gt__(self, operand: Any) -> bool:
        return _record_comparison(self, operand, self.value > float(operand))

    def __le__(self, operand: Any) -> bool:
        return _record_comparison(self, operand, self.value <= float(operand))

    def __ge__(self, operand: Any) -> bool:
        return _record_comparison(self, operand, self.value >= float(operand))


@dataclass(frozen=True)
class RecordedComparison:
    """A comparison that the code made: the expressions of both sides, and whether it holds for the values."""

    left: Any
    right: Any
    holds: bool


_active_records: list[list[RecordedComparison]] = []


def _record_comparison(left: EvaluatedExpression, right: Any, holds: bool) -> bool:
    for record in _active_records:
        record.append(RecordedComparison(left.expression, _exact(right), holds))
    return holds


@contextmanager
def recorded_comparisons() -> Iterator[list[RecordedComparison]]:
    """Collect the comparisons of expressions that are made inside of the `with` block, in their order."""
    _active_records.append([])
    try:
        yield _active_records[-1]
    finally:
        _active_records.pop()


def _exact(value: Any) -> Any:
    """Return a number as an exact SymPy expression; a double becomes the fraction that it is."""
    if isinstance(value, EvaluatedExpression):
        return value.expression
    if isinstance(value, Fraction | int):
        return sp.Rational(value)
    return sp.Rational(Fraction(float(value))) if np.isfinite(value) else sp.oo * int(np.sign(value))


def _combine(a: Any, b: Any, operation: Callable[[Any, Any], Any]) -> Any:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return NotImplemented  # NumPy then applies the operation entry by entry
    return EvaluatedExpression(operation(_exact(a), _exact(b)), operation(float(a), float(b)))
