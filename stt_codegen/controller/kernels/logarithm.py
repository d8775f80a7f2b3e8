"""`emit.math = "inline"`: the logarithm of the error transform by exponent and a short polynomial, so that no library is needed.

With y = m 2^e, m in [1/sqrt 2, sqrt 2) and s = (m - 1)/(m + 1), |s| <= 0.1716,

    ln y = e ln 2 + 2 atanh s,      2 atanh s = s (2 + C z) (1 + A),  z = s^2,

C the number for which the largest |A| is least; `approximation_error` bounds it. (One term more, |A| below 1.5e-7, costs a
Cortex-M4F 5 instructions in two dimensions; a polynomial of the same accuracy without the quotient costs 25.) What the emitted
arithmetic adds to the relative error, eps half a unit in the last place of 1, for y >= 1 (or below it by rounding: e = 0 still):

    s             2 eps        m - 1 is exact; m + 1 and the quotient
    z, C z        5, 6 eps of a term that is at most a hundredth of 2 + C z; that sum: 1.1 eps
    2 atanh s     4.1 eps, and A
    e = 0         nothing more
    e >= 1        (2 eps e ln 2 + (4.1 eps + A) ln(2)/2) / ((e - 1/2) ln 2) + eps, most for e = 1: 9.1 eps + A

so ln y comes out with `relative_error`: (10 eps + A) |ln y|. What it changes: component i of the law (13) has the gain
k (1 + delta_i) in place of k, |delta_i| below 2^-14, with the same sign. For diagonal g every bound by component that holds for
all gains from k (1 - 2^-14) to k (1 + 2^-14) holds for it; for general g, v' g diag(1 + delta) v >= (g_min - 2^-14 |g|) |v|^2,
so g_min - 2^-14 G takes the place of g_min.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

from stt_codegen.program import FORMATS, Assign, Block, Kernel, Op, Operand, Var, real, round_to

C = round_to(Fraction("0.67660441"), "float")
LN2 = Fraction("0.693147180559945309417232121458")
FARTHEST = Fraction("0.02943726")  # above (sqrt 2 - 1)^4 = z for m at its ends


@cache
def approximation_error() -> Fraction:
    """A bound on |A|: how far s (2 + C z) is from 2 atanh s, relative to it, for z in [0, FARTHEST].

    2 atanh(s)/s is the sum of 2 z^k/(2k + 1), at least 2. The difference is bounded piece by piece: its value in the middle, and
    its steepest slope times half the piece; the terms from z^8 on are summed."""
    pieces, terms = 4096, 8
    first = C - Fraction(2, 3)
    slope = abs(first) + FARTHEST / (1 - FARTHEST)  # z^j/(j + 1/2) rises slower than z^(j - 1)
    worst = Fraction(0)
    for k in range(pieces):
        z = FARTHEST * (2 * k + 1) / (2 * pieces)
        worst = max(worst, abs(first * z - sum(z**j / (j + Fraction(1, 2)) for j in range(2, terms))))
    tail = FARTHEST**terms / ((terms + Fraction(1, 2)) * (1 - FARTHEST))
    return (worst + slope * FARTHEST / (2 * pieces) + tail) / 2


def relative_error(scalar: str) -> Fraction:
    """The bound on |emitted ln y - ln y| / |ln y|."""
    return approximation_error() + 10 * FORMATS[scalar].roundoff


def without_library(kernel: Kernel) -> Kernel:
    """The kernel with every logarithm (of an argument that is not below 1, rounding apart) written out."""
    taken = {v.name for v in kernel.inputs} | {a.var.name for a in kernel.body} | set(kernel.output_names)
    block = Block(taken)
    for assign in kernel.body:
        if isinstance(assign.value, Op) and assign.value.name == "log":
            _logarithm(block, assign.var, assign.value.args[0])
        else:
            block.statements.append(assign)
    note = "ln y by y = m 2^e as e ln 2 + 2 atanh((m - 1)/(m + 1)), with a relative error below 2^-14."
    return replace(kernel, body=tuple(block.statements), doc=(*kernel.doc, note))  # type: ignore[arg-type]


def _logarithm(block: Block, result: Var, y: Operand) -> None:
    """Statements for result = ln y."""
    e = block.op("base", "real", block.op("exponent", "exponent", y))
    m = block.op("mantissa", "mantissa", y)
    s = block.op("s", "div", block.op("below", "sub", m, real(1)), block.op("above", "add", m, real(1)))
    z = block.op("z", "mul", s, s)
    around = block.op("around", "add", block.op("bent", "mul", z, real(C)), real(2))
    part = block.op("part", "mul", s, around)
    whole = block.op("whole", "mul", e, real(LN2))
    block.statements.append(Assign(result, Op("add", (whole, part))))
