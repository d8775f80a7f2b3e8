"""The values of a task file: exact numbers, vectors, labels, points and windows, with one message for each error.

The tables of schema.py and sets/shapes.py are made of these types; pydantic calls the functions, and a `ValueError` of theirs
becomes the message of a refused field (checks/schema_messages.py).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Discriminator, PlainSerializer, Tag, ValidationInfo, WithJsonSchema

from stt_codegen.arrays import is_array, real_array, rows_of
from stt_codegen.decimals import decimal

MAX_DIMENSION = 64
NEEDS_NUMBER = "a number is needed, for example 1.0"
MAX_NAME = 20
ADD_IT = "add it (docs/task.md has an example of every field)"
MAX_LABEL = 40
MAX_POINTS = 64  # of a polytope in up to three dimensions
MAX_POINTS_BEYOND = 16  # in more dimensions, where computing faces exactly takes longer
MAX_NORMALS = 32  # half-spaces of a set
MAX_TURNS = 200  # entries of a motion
MAX_IMAGES = 64  # of an unsafe set, where axes close
MAX_DIGITS = 40
GAIN_RULES = ("auto", "tight")  # by which control.gain is chosen
FILE = "file"  # key of pydantic's validation context, true where the values are from a file


def kind_of(value: object) -> str:
    """Return in words what a value of a TOML file is, with at most 40 characters of the value."""
    if isinstance(value, bool):
        return f"the boolean {str(value).lower()}"
    if isinstance(value, str):
        return f"the text {value!r:.40}"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, int) and value.bit_length() > 63:
        return "a very large number"
    if isinstance(value, int | float | Decimal | Fraction):
        return f"the number {value!s:.40}"
    return f"a {type(value).__name__}"


def _number(value: object, info: ValidationInfo, power: int = 9) -> Fraction:
    """Return a number as an exact fraction, 0 or from 10^-power to 10^power in size.

    A file may have numbers of TOML only. From Python floats (each means its shortest decimal), NumPy's numbers, fractions that
    are decimals, and decimals as text are taken too. Raises `ValueError` with the reason.
    """
    if isinstance(value, bool) or type(value).__name__ == "bool":
        raise ValueError(f"is the boolean {str(value).lower()}; {NEEDS_NUMBER}")
    if not (info.context and info.context.get(FILE)):
        value = _from_python(value)
    if not isinstance(value, int | Decimal):
        raise ValueError(f"is {kind_of(value)}; {NEEDS_NUMBER}")
    if isinstance(value, Decimal):
        if not value.is_finite():
            raise ValueError(f"is {value}; a finite number is needed")
        if value and (value.adjusted() > power or value.adjusted() < -power - 1 or len(value.as_tuple().digits) > MAX_DIGITS):
            raise ValueError(
                f"is {value!s:.40}; use 0 or a magnitude from 1e-{power} to 1e{power} of at most {MAX_DIGITS} digits "
                "(rescale the units)"
            )
    exact = Fraction(value)
    if exact and not Fraction(1, 10**power) <= abs(exact) <= 10**power:
        raise ValueError(f"is {kind_of(value)}; use 0 or a magnitude from 1e-{power} to 1e{power} (rescale the units)")
    return exact


def _gain(value: object, info: ValidationInfo) -> Fraction:
    """Return a gain as an exact fraction; its unit has a length squared, so its range is that of a number squared."""
    return _number(value, info, 18)


def _from_python(value: object) -> object:
    """Return a value from Python as a file would hold it, an int or a decimal; other values unchanged."""
    if is_array(value) and not isinstance(value, str):
        array = real_array(value)
        if array.shape:
            raise ValueError(f"is an array of shape {array.shape}; {NEEDS_NUMBER}")
        value = str(array)  # a NumPy number also means its shortest decimal
    elif isinstance(value, float):
        value = str(value)
    if isinstance(value, str):
        try:
            return Decimal(value)
        except ArithmeticError:
            return value
    if isinstance(value, Fraction):
        cofactor = value.denominator
        for prime in (2, 5):
            while cofactor % prime == 0:
                cofactor //= prime
        if cofactor != 1:
            raise ValueError(f"is {value}, which is no decimal; round it, for example to {float(value):.9g}")
        with localcontext() as context:
            context.prec = 2 * (MAX_DIGITS + value.denominator.bit_length())
            return Decimal(value.numerator) / value.denominator
    return value


def _positive(value: Fraction) -> Fraction:
    if value <= 0:
        raise ValueError(f"is {decimal(value)}; it must be greater than 0")
    return value


def _not_negative(value: Fraction) -> Fraction:
    if value < 0:
        raise ValueError(f"is {decimal(value)}; it must be 0 or greater")
    return value


def at_least_one(value: Fraction) -> Fraction:
    """Return the value, or raise `ValueError` where it is less than 1."""
    if value < 1:
        raise ValueError(f"is {decimal(value)}; it must be 1 or greater")
    return value


def below_one(value: Fraction) -> Fraction:
    """Return the value, or raise `ValueError` where it is not less than 1."""
    if value >= 1:
        raise ValueError(f"is {decimal(value)}; it must be less than 1")
    return value


def _number_or_list(value: object) -> str:
    """Return the tag of the type as which a value is read: a number, a list, or "auto"."""
    if isinstance(value, str) and value == "auto":  # an array would compare with a text entry by entry
        return "<auto>"
    is_list = isinstance(value, list | tuple) or (is_array(value) and getattr(value, "ndim", 1) != 0)
    return "<list>" if is_list else "<number>"


def _gain_or_rule(value: object) -> str:
    """Return the tag of the type as which a gain is read: a number, a list, or a rule by which it is chosen."""
    return "<auto>" if isinstance(value, str) and value in GAIN_RULES else _number_or_list(value)


Number = Annotated[
    Fraction,
    BeforeValidator(_number),
    PlainSerializer(float, return_type=float),
    WithJsonSchema({"type": "number"}),
]
Positive = Annotated[Number, AfterValidator(_positive), WithJsonSchema({"type": "number", "exclusiveMinimum": 0})]
NotNegative = Annotated[Number, AfterValidator(_not_negative), WithJsonSchema({"type": "number", "minimum": 0})]


def _vector(value: object) -> object:
    """Return the rows of a vector for validation of each entry; raise `ValueError` where it is no list of a valid length."""
    if is_array(value) and real_array(value).ndim == 1:
        value = rows_of(value)
    if not isinstance(value, list | tuple):
        raise ValueError(f"is {kind_of(value)}; a list of numbers is needed, one for each dimension")
    if not value:
        raise ValueError("is an empty list; give one number for each dimension")
    if len(value) > MAX_DIMENSION:
        raise ValueError(f"has {len(value)} entries; at most {MAX_DIMENSION} dimensions are supported")
    return value


Vector = Annotated[tuple[Number, ...], BeforeValidator(_vector)]
PerComponent = Annotated[  # one number for all components, or a list with one number per component
    Annotated[Number, Tag("<number>")] | Annotated[Vector, Tag("<list>")], Discriminator(_number_or_list)
]
NotNegativeVector = Annotated[tuple[NotNegative, ...], BeforeValidator(_vector)]
NotNegativePerComponent = Annotated[  # the same of numbers that are 0 or greater
    Annotated[NotNegative, Tag("<number>")] | Annotated[NotNegativeVector, Tag("<list>")], Discriminator(_number_or_list)
]
PerComponentOrAuto = Annotated[
    Annotated[Number, Tag("<number>")] | Annotated[Vector, Tag("<list>")] | Annotated[Literal["auto"], Tag("<auto>")],
    Discriminator(_number_or_list),
]
Gain = Annotated[Fraction, BeforeValidator(_gain), PlainSerializer(float, return_type=float), WithJsonSchema({"type": "number"})]


def labels(value: object) -> object:
    """Return a list of labels; raise `ValueError` where an entry is no text, too long, or has a sign that no label has."""
    if not isinstance(value, list | tuple):
        raise ValueError(f"is {kind_of(value)}; a list of texts is needed")
    for v in value:
        if not isinstance(v, str):
            raise ValueError(f"has {kind_of(v)} in it; a list of texts is needed, in quotes")
    for v in value:
        if len(v) > MAX_LABEL or not re.fullmatch(r"[A-Za-z0-9 ._/^%()+-]*", v):
            raise ValueError(
                f"{v!r} is no label; use letters, digits, spaces or . _ / ^ % ( ) + -, at most {MAX_LABEL} characters"
            )
    return value


class Periods(dict[str, Fraction]):
    """Periods by the names of axes. It has a hash, as every value of a task."""

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))


def periods(value: object) -> object:
    """Return a table of periods as a dictionary; raise `ValueError` where it is no table or empty."""
    if not isinstance(value, Mapping) or not value:
        kind = "an empty table" if isinstance(value, Mapping) else kind_of(value)
        raise ValueError(f"is {kind}; a table of periods by axis is needed, {{ yaw = 6.283185307179586 }}")
    return dict(value)


def points(value: object) -> object:
    """Return a list of points; raise `ValueError` where it is no list or empty."""
    rows = rows_of(value)
    if not isinstance(rows, list | tuple) or not rows:
        kind = "an empty list" if isinstance(rows, list | tuple) else kind_of(value)
        raise ValueError(f"is {kind}; a list of points is needed, [[x, y], ..]")
    return rows


def polygons(value: object) -> object:
    """Return a list of polygons; raise `ValueError` where it is no list."""
    if not isinstance(value, list | tuple):
        raise ValueError(f"is {kind_of(value)}; a list of lists of points is needed, [[[x, y], ..], ..]")
    return value


def waypoints(value: object) -> object:
    """Return a list of waypoints; raise `ValueError` where it is no list or empty."""
    if not isinstance(value, list | tuple) or not value:
        kind = "an empty list" if isinstance(value, list | tuple) else kind_of(value)
        raise ValueError(f"is {kind}; a list of {{ at, by }} is needed, seconds and displacement")
    return value


def window(value: object) -> object:
    """Return the two ends of a window; raise `ValueError` where it is no list of two."""
    value = rows_of(value)
    if not isinstance(value, list | tuple) or len(value) != 2:
        problem = f"has {len(value)} entries" if isinstance(value, list | tuple) else f"is {kind_of(value)}"
        raise ValueError(f"{problem}; two are needed, [from, to] in seconds")
    return value


PeriodOfAxis = Annotated[dict[str, Positive], BeforeValidator(periods), AfterValidator(Periods)]
Window = Annotated[tuple[Number, ...], BeforeValidator(window)]
Labels = Annotated[tuple[str, ...], BeforeValidator(labels)]
GainVector = Annotated[tuple[Gain, ...], BeforeValidator(_vector)]
GainOrAuto = Annotated[
    Annotated[Gain, Tag("<number>")] | Annotated[GainVector, Tag("<list>")] | Annotated[Literal["auto", "tight"], Tag("<auto>")],
    Discriminator(_gain_or_rule),
]


def read_integer(value: object) -> object:
    """Return an integer; raise `ValueError` where the value is none, or 2^63 or more in size."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"is {kind_of(value)}; a whole number is needed")
    if value.bit_length() > 63:
        raise ValueError("is out of range; use a whole number below 2^63")
    return value
