"""P7: how far the emitted arithmetic moves an edge, or its rate. The statements are the listing's, so the constants are too.

eps is half a unit in the last place of 1: 2^-24 or 2^-53. A result is off by eps times its size, and by `tiny`, half the least
subnormal number, where it is near 0. With the values of `basis` (listing_controller.c) for s in [0, 1], each its size and its
error in eps:

    v0 1, 1    v1 1, 3    v2 1, 5     v3 1, 2     v4 2, 4     v5 6, 18
    v6 6, 30   v7 7, 37   v8 6, 24    v9 7, 31    v10 1, 1    v11 1, 2

The weights are off by 5, 37, 31 and 2. Four products with q, |q| <= Q, add 1, 7, 7 and 1, the sums 8, 8 and 16: 123 eps Q. Terms
with eps^2 and more are below 441 eps^2 Q, those with tiny below 200 (Q + 1) tiny. For `basis_rate` the weights are off by 14, 42,
39 and 8, the products by 3, 9, 9 and 3, the sums by 12, 12 and 24: 175 eps Q and 568 eps^2 Q. meaning.py computes these constants
again.
"""

from fractions import Fraction

from .tube import Tube

EDGE, RATE = (123, 441), (175, 568)  # by eps and by eps^2, times the largest control point over 6


def arithmetic_error(tube: Tube, bits: int, order: int = 0) -> list[Fraction]:
    """Return by dimension how far an edge may be off (order 0), in the task's units, or its rate (order 1), a second. Spline time
    is off by K (2 eps + eps^2): t, K/t_c and their product are rounded. Twice that is allowed, so that t may have been
    rounded."""
    eps, tiny = Fraction(1, 1 << bits), Fraction(1, 1 << (150 if bits == 24 else 1075))
    time_error, errors = tube.segments * 4 * eps * (1 + eps) + tiny, []
    first, second = (EDGE, RATE)[order]
    for i in range(tube.n):
        largest = max(abs(v) for row in tube.table for v in row[i]) * tube.unit
        error = largest * (first * eps + second * eps**2) + 200 * (largest + 1) * tiny
        error += time_error * tube.fastest(i, order + 1) * tube.unit
        if order == 1:  # the product with K/t_c, which is rounded too
            per_second = tube.segments / tube.t_c
            error = (error * (1 + eps) + (tube.fastest(i) * tube.unit + error) * 2 * eps) * per_second + tiny
        errors.append(error)
    return errors
