"""A SymPy expression that carries a number: what lemmas run the package's own code on, in the place of doubles and fractions.

NumPy calculates with it. Comparisons go by the number, so what is found holds on the path that this number takes; a lemma takes
as many as there are paths. `questions` hears <, <=, > and >= of formulas, not what is asked of float(formula) or by abs.
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
class Formula:
    """form: the SymPy expression. number: its value at the lemma's point."""

    form: Any
    number: float

    def __float__(self) -> float:
        return self.number

    def exp(self) -> Formula:
        return Formula(sp.exp(self.form), float(np.exp(self.number)))

    def log(self) -> Formula:
        return Formula(sp.log(self.form), float(np.log(self.number)))

    def cosh(self) -> Formula:
        return Formula(sp.cosh(self.form), float(np.cosh(self.number)))

    def tanh(self) -> Formula:
        return Formula(sp.tanh(self.form), float(np.tanh(self.number)))

    def __neg__(self) -> Formula:
        return Formula(-self.form, -self.number)

    def __add__(self, other: Any) -> Any:
        return _join(self, other, lambda a, b: a + b)

    def __radd__(self, other: Any) -> Any:
        return _join(other, self, lambda a, b: a + b)

    def __sub__(self, other: Any) -> Any:
        return _join(self, other, lambda a, b: a - b)

    def __rsub__(self, other: Any) -> Any:
        return _join(other, self, lambda a, b: a - b)

    def __mul__(self, other: Any) -> Any:
        return _join(self, other, lambda a, b: a * b)

    def __rmul__(self, other: Any) -> Any:
        return _join(other, self, lambda a, b: a * b)

    def __truediv__(self, other: Any) -> Any:
        return _join(self, other, lambda a, b: a / b)

    def __rtruediv__(self, other: Any) -> Any:
        return _join(other, self, lambda a, b: a / b)

    def __pow__(self, power: int) -> Formula:
        return Formula(self.form**power, self.number**power)

    def __abs__(self) -> Formula:
        return self if self.number >= 0 else -self

    def __lt__(self, other: Any) -> bool:
        return _ask(self, other, self.number < float(other))

    def __gt__(self, other: Any) -> bool:
        return _ask(self, other, self.number > float(other))

    def __le__(self, other: Any) -> bool:
        return _ask(self, other, self.number <= float(other))

    def __ge__(self, other: Any) -> bool:
        return _ask(self, other, self.number >= float(other))


@dataclass(frozen=True)
class Question:
    """A comparison that the code made: of which forms, and what came of it for the numbers."""

    left: Any
    right: Any
    answer: bool


_listening: list[list[Question]] = []


def _ask(a: Formula, b: Any, answer: bool) -> bool:
    for heard in _listening:
        heard.append(Question(a.form, _exact(b), answer))
    return answer


@contextmanager
def questions() -> Iterator[list[Question]]:
    """The comparisons of formulas that are made meanwhile, in their order."""
    _listening.append([])
    try:
        yield _listening[-1]
    finally:
        _listening.pop()


def _exact(value: Any) -> Any:
    if isinstance(value, Formula):
        return value.form
    if isinstance(value, Fraction | int):
        return sp.Rational(value)
    return sp.Rational(Fraction(float(value))) if np.isfinite(value) else sp.oo * int(np.sign(value))


def _join(a: Any, b: Any, operation: Callable[[Any, Any], Any]) -> Any:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return NotImplemented
    return Formula(operation(_exact(a), _exact(b)), operation(float(a), float(b)))
