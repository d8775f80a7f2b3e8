"""What an array-like of the Python API may be: real numbers, all of them there. One place, for tasks, tubes, states and plants.

NumPy turns much into floats without a word: it drops imaginary parts and masks, reads texts, and counts True as 1. Here these are
refused, with what they are. NumPy is imported only where there is an array, so that a task file is read without it.
"""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from typing import Any

from stt_codegen.errors import BadInput

NOT_REAL = {
    "c": "complex numbers; give their real part, if that is what is meant",
    "b": "booleans; numbers are needed",
    "O": "objects; give a list of numbers, or convert it with astype(float)",
    "S": "texts; convert it with astype(float)",
    "U": "texts; convert it with astype(float)",
    "M": "dates; give seconds as numbers",
    "m": "durations; give seconds as numbers",
}


def is_array(value: object) -> bool:
    """Whether it is an array, or turns itself into one, as those of NumPy, pandas and xarray do."""
    return hasattr(value, "__array__") and not isinstance(value, type)


def real_array(value: Any, symbols: bool = False) -> Any:
    """An array, or what turns itself into one, as an array of NumPy's integers or floats. symbols: one of objects will do too.
    Raises ValueError with what it is where it is none of real numbers, or has masked entries."""
    import numpy as np

    if isinstance(value, np.ma.MaskedArray):
        if np.ma.getmaskarray(value).any():
            raise ValueError("has masked entries; leave them out, or fill them")
        value = value.data
    try:
        array = np.asarray(value)
    except Exception as error:  # of a foreign type, whose __array__ may raise anything
        raise ValueError(f"is a {type(value).__name__} that is no array ({str(error).partition(chr(10))[0]})") from None
    kind = array.dtype.kind
    if kind not in "iuf" and not (symbols and kind == "O"):
        if array.ndim == 0:
            raise ValueError(f"is of {NOT_REAL.get(kind, f'type {array.dtype}; numbers are needed')}")
        raise ValueError(f"is an array of {NOT_REAL.get(kind, f'{array.dtype}; numbers are needed')}")
    return array


def as_floats(name: str, value: Any, finite: bool = True, texts: bool = False) -> Any:
    """An array-like, as nested lists, tuples and arrays of numbers are, as an array of doubles. Raises `BadInput` with its name
    where it is no such thing or, if `finite`, where a number is not finite. texts: a list may hold decimals as text, as a task
    may."""
    import numpy as np

    try:
        if value is None:
            raise ValueError("is missing; an array of numbers is needed")
        for entry in _leaves(value):
            if not (texts and entry is not value and isinstance(entry, str) and _is_decimal(entry)):
                require_real(entry)
        try:
            array = np.asarray(real_array(value) if is_array(value) else value, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise ValueError("has rows of different lengths; an array of numbers is needed") from None
        if finite and not np.isfinite(array).all():
            raise ValueError("has a NaN or an infinity; finite numbers are needed")
    except ValueError as error:
        raise BadInput(f"{name}: {error}") from None
    return array


def _leaves(value: Any) -> Iterator[Any]:
    """What stands in nested lists and tuples."""
    if not isinstance(value, list | tuple):
        yield value
        return
    for entry in value:
        yield from _leaves(entry)


def _is_decimal(text: str) -> bool:
    try:
        return Decimal(text).is_finite()
    except ArithmeticError:
        return False


def require_real(value: Any, symbols: bool = False) -> None:
    """Raises ValueError, with what it is, for an entry that is no real number and no array of them."""
    if is_array(value):
        real_array(value, symbols)
    elif isinstance(value, bool):
        raise ValueError(f"has the boolean {str(value).lower()} in it; numbers are needed")
    elif isinstance(value, complex):
        raise ValueError("has complex numbers in it; give their real part, if that is what is meant")
    elif not isinstance(value, int | float | Fraction | Decimal):
        what = f"the text {value!r:.40}" if isinstance(value, str) else f"a {type(value).__name__}"
        raise ValueError(f"has {what} in it; numbers are needed")


def rows_of(value: Any) -> Any:
    """An array as lists of lists of NumPy's numbers, each of which still means its shortest decimal; what is no array stays."""
    if not is_array(value):
        return value
    array = real_array(value)
    if array.ndim == 0:
        return value
    return list(array) if array.ndim == 1 else [rows_of(row) for row in array]
