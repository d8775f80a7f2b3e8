"""The logarithm of a quotient of whole numbers, from below and from above, in whole numbers alone.

ln(p/q) = k ln 2 + 2 artanh z with z = (a - b)/(a + b), where a/b = p/(2^k q) is between 2^-1/2 and 2^1/2, so |z| <= 0.172.
The series of artanh is summed by Horner's rule in multiples of 2^-64, and every floor is counted (lemma `path.logarithm`). A
call takes 2 microseconds; `program/analyse/exact_logarithm.py` takes a thousand in fractions.
"""

from __future__ import annotations

LOG_BITS = 64
LOG_ONE = 1 << LOG_BITS
LAST_POWER = 27  # of the series of artanh; what is left out is below 2^-76
RECIPROCALS = tuple(LOG_ONE // j for j in range(LAST_POWER - 2, 0, -2))
ARTANH_ERROR = 6  # units of 2^-64 by which `twice_artanh` may be too small; it is never too large


def twice_artanh(numerator: int, denominator: int) -> int:
    """Return 2 artanh(numerator/denominator) in units of 2^-64, rounded down by less than ARTANH_ERROR.

    The quotient is from 0 to 0.172. In units: z is too small by less than 1, and z^2 by less than 2. A partial sum S of 1 +
    z^2/3 + .. is then too small by less than 3: 1 for its reciprocal, 1 for its floor, and 3 z^2 + 2/3 for its factors. The
    product S z is too small by less than 1 + 3 z + S < 2.6, and what the series leaves out is below 2^-12.
    """
    z = (numerator << LOG_BITS) // denominator
    square = z * z >> LOG_BITS
    total = LOG_ONE // LAST_POWER
    for reciprocal in RECIPROCALS:
        total = reciprocal + (total * square >> LOG_BITS)
    return 2 * (total * z >> LOG_BITS)


# ln 2 = 3 ln(5/4) + ln(128/125), each logarithm twice an artanh
LOG_TWO = 3 * twice_artanh(1, 9) + twice_artanh(3, 253)
LOG_TWO_ERROR = 4 * ARTANH_ERROR


def log_bounds(p: int, q: int) -> tuple[int, int]:
    """Return bounds on ln(p/q), from below and from above, in units of 2^-64; p and q are positive."""
    if p < q:
        low, high = log_bounds(q, p)
        return -high, -low
    k = p.bit_length() - q.bit_length()
    a, b = p, q << k
    if a < b:
        a, k = a << 1, k - 1
    if a * a > 2 * b * b:
        b, k = b << 1, k + 1
    if a >= b:
        low = twice_artanh(a - b, a + b)
        high = low + ARTANH_ERROR
    else:
        high = -twice_artanh(b - a, a + b)
        low = high - ARTANH_ERROR
    return low + k * LOG_TWO, high + k * (LOG_TWO + LOG_TWO_ERROR)
