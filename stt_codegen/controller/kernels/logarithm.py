"""`emit.math = "inline"`: the logarithm of the error transform by exponent and a short polynomial, so that no library is needed.

With y = m 2^e, m in [1/sqrt 2, sqrt 2) and s = (m - 1)/(m + 1), |s| <= 0.1716,

    ln y = e ln 2 + 2 atanh s,      2 atanh s = s (2 + C z) (1 + A),  z = s^2,

C is the number for which the largest |A| is smallest; `approximation_error` bounds |A|. (One more term makes |A| less than
1.5e-7 and costs a Cortex-M4F 5 instructions in two dimensions. A polynomial of the same accuracy without the quotient costs 25.)
The emitted arithmetic adds to the relative error as follows. Here eps is half a unit in the last place of 1, and y >= 1, or
below 1 by rounding only, when e is still 0:

    s             2 eps        m - 1 is exact; m + 1 and the quotient
    z, C z        5, 6 eps of a term that is at most a hundredth of 2 + C z; that sum: 1.1 eps
    2 atanh s     4.1 eps, and A
    e = 0         nothing more
    e >= 1        (2 eps e ln 2 + (4.1 eps + A) ln(2)/2) / ((e - 1/2) ln 2) + eps, most for e = 1: 9.1 eps + A

So the computed ln y is within (10 eps + A) |ln y| of the exact one; `inline_logarithm_error` returns this factor. In the law
(13) component i then has the gain k (1 + delta_i) in place of k, with |delta_i| below 2^-14 and the same sign. For diagonal g
every bound by component that holds for all gains from k (1 - 2^-14) to k (1 + 2^-14) holds for this law. For general g, v' g
diag(1 + delta) v >= (g_min - 2^-14 |g|) |v|^2, so g_min - 2^-14 G takes the place of g_min. law.py calls this file; the lemma
`transform.logarithm` is about its kernel.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

from stt_codegen.program import FORMATS, Assign, Block, Kernel, Op, Operand, Var, real, round_to

C = round_to(Fraction("0.67660441"), "float")
LN2 = Fraction("0.693147180559945309417232121458")
LARGEST_Z = Fraction("0.02943726")  # above (sqrt 2 - 1)^4 = z for m at its ends


@cache
def approximation_error() -> Fraction:
    """Bound |A|: how far s (2 + C z) is from 2 atanh s, relative to it, for z in [0, LARGEST_Z].

    2 atanh(s)/s is the sum of 2 z^k/(2k + 1), at least 2. [0, LARGEST_Z] is cut into pieces. In each the difference is at most
    its value in the middle plus its steepest slope times half the piece; the terms from z^8 on are summed."""
    piece_count, term_count = 4096, 8
    linear_coefficient = C - Fraction(2, 3)
    steepest_slope = abs(linear_coefficient) + LARGEST_Z / (1 - LARGEST_Z)  # z^j/(j + 1/2) rises slower than z^(j - 1)
    largest_middle = Fraction(0)
    for k in range(piece_count):
        z = LARGEST_Z * (2 * k + 1) / (2 * piece_count)
        difference = linear_coefficient * z - sum(z**j / (j + Fraction(1, 2)) for j in range(2, term_count))
        largest_middle = max(largest_middle, abs(difference))
    tail = LARGEST_Z**term_count / ((term_count + Fraction(1, 2)) * (1 - LARGEST_Z))
    return (largest_middle + steepest_slope * LARGEST_Z / (2 * piece_count) + tail) / 2


def inline_logarithm_error(scalar: str) -> Fraction:
    """Bound |emitted ln y - ln y| / |ln y| for y >= 1 and a scalar "float" or "double"."""
    return approximation_error() + 10 * FORMATS[scalar].roundoff


def with_inline_logarithm(kernel: Kernel) -> Kernel:
    """Return the kernel with every logarithm replaced by statements of arithmetic.

    The arguments of these logarithms must be at least 1, roundings apart."""
    used_names = {v.name for v in kernel.inputs} | {a.var.name for a in kernel.body} | set(kernel.output_names)
    block = Block(used_names)
    for assign in kernel.body:
        if isinstance(assign.value, Op) and assign.value.name == "log":
            _write_logarithm(block, assign.var, assign.value.args[0])
        else:
            block.statements.append(assign)
    note = "ln y by y = m 2^e as e ln 2 + 2 atanh((m - 1)/(m + 1)), with a relative error below 2^-14."
    return replace(kernel, body=tuple(block.statements), doc=(*kernel.doc, note))  # type: ignore[arg-type]


def _write_logarithm(block: Block, result: Var, y: Operand) -> None:
    """Write statements for result = ln y by the formulas of the module docstring. Strings are names in emitted code."""
    e = block.op("base", "real", block.op("exponent", "exponent", y))
    m = block.op("mantissa", "mantissa", y)
    s = block.op("s", "div", block.op("below", "sub", m, real(1)), block.op("above", "add", m, real(1)))
    z = block.op("z", "mul", s, s)
    factor = block.op("around", "add", block.op("bent", "mul", z, real(C)), real(2))
    ln_mantissa = block.op("part", "mul", s, factor)
    ln_power = block.op("whole", "mul", e, real(LN2))
    block.statements.append(Assign(result, Op("add", (ln_power, ln_mantissa))))
