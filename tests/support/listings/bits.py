"""That the functions `exponent` and `mantissa` of a listing split a number, by running their expressions on its bits."""

from __future__ import annotations

import math
import struct
from fractions import Fraction
from random import Random

import numpy as np

from stt_codegen.checker.stt_checker.controller import IEEE
from tests.support.listings.meaning import filled_listing
from tests.support.listings.reader import require

OPTIONS = {"order 1", "inline", "one gain", "one clamp", "no limits"}
READ_BITS = "number_word bits ; ( void ) memcpy ( & bits , & y , sizeof bits ) ; "
EXPONENT = (f"{READ_BITS}return ( int32_t ) (", ") ;")  # what stands around the expression
MANTISSA = (f"{READ_BITS}bits = ", " ; c_real m ; ( void ) memcpy ( & m , & bits , sizeof m ) ; return m ;")


def expression(name: str, scalar: str, frame: tuple[str, str]) -> str:
    """Return the one expression of a function, with the numbers of the scalar. `UnknownMeaning` where anything else is another."""
    _, _, cut, places, mask = IEEE[scalar]
    tokens = filled_listing("controller", {*OPTIONS, scalar}).functions[name].tokens
    text = " ".join(tokens)
    begin, end = frame
    require(text.startswith(begin) and text.endswith(end), f"{name} is not a single expression of the bits")
    words = {"number_cut": cut.rstrip("U"), "number_places": str(places), "number_mask": mask.rstrip("U")}
    return " ".join(words.get(token, token) for token in text.removeprefix(begin).removesuffix(end).split())


def check_split(scalar: str) -> None:
    """Require y = m 2^e with m in [1/sqrt 2, sqrt 2), for numbers from 1/sqrt 2 on: the farther distance over the nearer one."""
    number = np.float32 if scalar == "float" else np.float64
    code, size = ("<f", 4) if scalar == "float" else ("<d", 8)
    exponent_of, mantissa_of = expression("exponent", scalar, EXPONENT), expression("mantissa", scalar, MANTISSA)
    random = Random(7)
    values = [1.0, 2.0, 2**0.5, float(np.nextafter(number(2**0.5), number(2))), 0.7072, 2.0**100, 3.0e30]
    for value in (*values, *(math.exp(random.uniform(0, 60)) for _ in range(500))):
        y = float(number(value))
        bits = {"bits": int.from_bytes(struct.pack(code, y), "little")}
        exponent, mantissa_bits = (int(eval(text, {}, bits)) for text in (exponent_of, mantissa_of))
        require(0 <= mantissa_bits < 1 << 8 * size, f"the mantissa of {y} is no number")
        (mantissa,) = struct.unpack(code, mantissa_bits.to_bytes(size, "little"))
        is_split = Fraction(mantissa) * Fraction(2) ** exponent == Fraction(y)
        require(is_split and number(0.5**0.5) <= number(mantissa) <= number(2**0.5), f"{y} is not {mantissa} 2^{exponent}")
