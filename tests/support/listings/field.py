"""Arithmetic on symbols, with a symbol for every rounding.

A symbol is a random element of the field of integers modulo 2^521 - 1. Formulas that are no one quotient of polynomials have equal
values with a probability below 2^-500. A rounded operation on a and b gives (a op b)(1 + d), where d is a symbol that belongs to this
operation and these operands. So two values are equal only if the same roundings lead to them. IEEE-754 rounds a + b as b + a, and a
negated result as the result: there d is the same.
"""

from __future__ import annotations

import secrets
from fractions import Fraction
from typing import Any

PRIME = 2**521 - 1


def element(value: Fraction | int) -> int:
    """Return a number as an element of the field."""
    number = Fraction(value)
    return number.numerator * pow(number.denominator, -1, PRIME) % PRIME


class Symbols:
    """Symbols by name and arguments. rounds: whether operations on real numbers round."""

    def __init__(self, rounds: bool = True) -> None:
        self.rounds = rounds
        self._by_name: dict[tuple[Any, ...], int] = {}
        self._results: dict[tuple[str, int, int], int] = {}  # of operations on real numbers

    def symbol(self, name: str, *arguments: int) -> int:
        """Return an unknown, or the value of an unknown function: the same for the same arguments."""
        return self._by_name.setdefault((name, *arguments), secrets.randbelow(PRIME))

    def integer_operation(self, sign: str, a: int, b: int) -> int:
        """Return the result of an operation on integers, none of which leaves its type."""
        exact = {"+": a + b, "-": a - b, "*": a * b}
        return exact[sign] % PRIME if sign in exact else self.symbol(f"integer {sign}", a, b)

    def real_operation(self, sign: str, a: int, b: int) -> int:
        """Return the rounded result of an operation on real numbers."""
        if (sign, a, b) not in self._results:
            self._results[sign, a, b] = self._real_operation(sign, a, b)
        return self._results[sign, a, b]

    def _real_operation(self, sign: str, a: int, b: int) -> int:
        if sign == "*" and 0 in (a, b):
            return self.symbol("zero times", (a + b) % PRIME)  # NaN for an infinity or a NaN
        if sign == "-":
            sign, b = "+", -b % PRIME
        exact = {"+": lambda: a + b, "*": lambda: a * b, "/": lambda: a * pow(b, -1, PRIME)}[sign]() % PRIME
        return self._rounded(exact, sign, a, b)

    def real_from_integer(self, value: int) -> int:
        """Return an integer as a real number, which may round it."""
        return self._rounded(value, "real", value, 0)

    def _rounded(self, exact: int, sign: str, a: int, b: int) -> int:
        if not self.rounds:
            return exact
        negated = (-a % PRIME, -b % PRIME)
        if sign == "+":
            operands = min(tuple(sorted((a, b))), tuple(sorted(negated)))
        else:
            operands = (min(a, negated[0]), min(b, negated[1]))
            operands = tuple(sorted(operands)) if sign == "*" else operands
        return exact * (1 + self.symbol(f"rounding of {sign}", *operands)) % PRIME
