"""Polynomials in fractions, and where in [0, 1] one is negative, by Sturm's theorem: for the oracle of order 2.

A polynomial is a tuple of the coefficients of 1, s, s^2, ..; the last one is not 0, so the zero polynomial is empty.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import reduce

Polynomial = tuple[Fraction, ...]
HALF = Fraction(1, 2)
HALVINGS = 10_000  # many more than any root of such coefficients needs


def polynomial(coefficients: Iterable[Fraction | int]) -> Polynomial:
    """Return the polynomial with these coefficients of 1, s, s^2, .., without zeros at the end."""
    trimmed = [Fraction(c) for c in coefficients]
    while trimmed and not trimmed[-1]:
        trimmed.pop()
    return tuple(trimmed)


def evaluate(p: Polynomial, s: Fraction) -> Fraction:
    return reduce(lambda total, c: total * s + c, reversed(p), Fraction(0))


def linear_combination(*terms: tuple[Fraction | int, Polynomial]) -> Polynomial:
    """Return the sum of factor times polynomial over the terms."""
    size = max(len(p) for _, p in terms)
    return polynomial(sum((f * p[j] for f, p in terms if j < len(p)), Fraction(0)) for j in range(size))


def differentiate(p: Polynomial) -> Polynomial:
    return polynomial(j * c for j, c in enumerate(p) if j)


def divide(p: Polynomial, q: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Return quotient and remainder of p by q."""
    rest, quotient = list(p), [Fraction(0)] * max(len(p) - len(q) + 1, 0)
    for j in reversed(range(len(quotient))):
        quotient[j] = rest[j + len(q) - 1] / q[-1]
        for m, c in enumerate(q):
            rest[j + m] -= quotient[j] * c
    return polynomial(quotient), polynomial(rest[: len(q) - 1])


def sturm_chain(p: Polynomial) -> list[Polynomial]:
    """Return Sturm's chain: p, p', and minus the remainder of each two. Its last one is the greatest common divisor of p and
    p'."""
    chain = [p, differentiate(p)]
    while chain[-1]:
        chain.append(linear_combination((-1, divide(chain[-2], chain[-1])[1])))
    return chain[:-1]


def count_sign_changes(polynomials: Iterable[Polynomial], s: Fraction) -> int:
    """Count how often the sign changes along the polynomials at s, zeros left out."""
    signs = [v > 0 for v in (evaluate(p, s) for p in polynomials) if v]
    return sum(a != b for a, b in itertools.pairwise(signs))


def count_roots(p: Polynomial, low: Fraction, high: Fraction) -> int:
    """Count the real roots in (low, high), each once; p is 0 at neither end."""
    chain = sturm_chain(p)
    return count_sign_changes(chain, low) - count_sign_changes(chain, high)


def lower_bound(p: Polynomial) -> Fraction:
    """Bound p on [0, 1] from below: by its constant and all its negative terms."""
    return p[0] + sum(min(c, Fraction(0)) for c in p[1:])


def negative_point(p: Polynomial) -> Fraction | None:
    """Return an s in [0, 1] where p < 0; None where there is none. The degree is at most 3."""
    if not p or lower_bound(p) >= 0:
        return None
    first, last = Fraction(0), Fraction(1)
    for end in (first, last):
        if evaluate(p, end) < 0:
            return end
    q = _without_roots_at_ends(p)
    if q[0] < 0:
        return next(s for s in _halves() if evaluate(p, s) < 0)
    if evaluate(q, last) < 0:
        return next(s for s in (1 - half for half in _halves()) if evaluate(p, s) < 0)
    # q > 0 at both ends: without roots between them, or with a double one, q is nowhere negative
    if len(q) < 3 or len(sturm_chain(q)[-1]) > 1 or not count_roots(q, first, last):
        return None
    return _point_between_two_roots(q)


def _halves() -> Iterator[Fraction]:
    """Yield 1/2, 1/4, 1/8, .."""
    return (HALF**j for j in range(1, HALVINGS))


def _without_roots_at_ends(p: Polynomial) -> Polynomial:
    """Divide by s and by 1 - s as often as they are factors; neither changes the sign in (0, 1)."""
    q = p
    while not q[0]:
        q = q[1:]
    while not evaluate(q, Fraction(1)):
        q = divide(q, polynomial((1, -1)))[0]
    return q


def _point_between_two_roots(q: Polynomial) -> Fraction:
    """Return a point where q < 0. q is positive at 0 and 1, and has two simple roots between them."""
    low, high = Fraction(0), Fraction(1)
    while True:
        middle = (low + high) / 2
        if not evaluate(q, middle):  # a simple root: q is negative on one side of it
            points = (middle + sign * half for half in _halves() for sign in (1, -1))
            return next(s for s in points if low < s < high and evaluate(q, s) < 0)
        if evaluate(q, middle) < 0:
            return middle
        low, high = (low, middle) if count_roots(q, low, middle) else (middle, high)


def nonpositive_point(p: Polynomial) -> Fraction | None:
    """Return an s in [0, 1] where p <= 0; None where there is none. A cubic that only touches 0 does so at a rational point."""
    if not p:
        return Fraction(0)
    if lower_bound(p) > 0:
        return None
    s = negative_point(p)
    if s is not None:
        return s
    shared = sturm_chain(p)[-1] if len(p) > 2 else polynomial((1,))
    double_roots = [-shared[0] / shared[1]] if len(shared) == 2 else [-shared[1] / (2 * shared[2])] if len(shared) == 3 else []
    return next((s for s in (Fraction(0), Fraction(1), *double_roots) if 0 <= s <= 1 and not evaluate(p, s)), None)
