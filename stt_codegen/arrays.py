"""The check of array-likes from Python: they must hold real numbers. Tasks, tubes, states and plants all use it.

NumPy converts much to floats silently: it drops imaginary parts and masks, reads texts, and counts True as 1. This file refuses
these with a message. It imports NumPy only where there is an array, so that reading a task file needs no NumPy.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeVar

from stt_codegen.errors import BadInput

Number = TypeVar("Number", float, Fraction)
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
    """Return whether the value is an array or converts itself to one, as the arrays of NumPy, pandas and xarray do."""
    return hasattr(value, "__array__") and not isinstance(value, type)


def real_array(value: Any, symbols: bool = False) -> Any:
    """Convert an array to one of NumPy's integers or floats.

    symbols: accept an array of objects too. Raises ValueError where entries are masked or no real numbers.
    """
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
    """Convert nested lists, tuples or arrays of numbers to an array of doubles.

    name: begins the message. finite: refuse a NaN or an infinity. texts: accept decimals as text in a list, as tasks do. Raises
    `BadInput` where the value is no such thing.
    """
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


def entries_of(name: str, value: Any, count: int) -> tuple[float, ...]:
    """Return one number for each of `count` components, of a number for all of them or a list; each 0 or more.

    name: begins the message. Raises `BadInput` where the value is no such thing.
    """
    array = as_floats(name, value, finite=False)
    if array.ndim > 1 or (array.ndim and len(array) != count):
        size = f"has {len(array)} entries" if array.ndim == 1 else f"has shape {array.shape}"
        raise BadInput(f"{name}: {size}; one number is needed, or {count}")
    entries = tuple(array.tolist()) if array.ndim else (float(array),) * count
    for v in entries:
        if not 0 <= v < float("inf"):
            raise BadInput(f"{name} {v:g}: a finite number of 0 or more is needed")
    return entries


def one_if_equal(values: Sequence[Number]) -> Number | tuple[Number, ...]:
    """Return a single number where all entries are equal, as tasks and reports write it, else a tuple."""
    return values[0] if len(set(values)) == 1 else tuple(values)


def _leaves(value: Any) -> Iterator[Any]:
    """Yield the entries of nested lists and tuples."""
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
    """Raise ValueError where an entry is neither a real number nor an array of them."""
    if is_array(value):
        real_array(value, symbols)
    elif isinstance(value, bool):
        raise ValueError(f"has the boolean {str(value).lower()} in it; numbers are needed")
    elif isinstance(value, complex):
        raise ValueError("has complex numbers in it; give their real part, if that is what is meant")
    elif not isinstance(value, int | float | Fraction | Decimal):
        entry = f"the text {value!r:.40}" if isinstance(value, str) else f"a {type(value).__name__}"
        raise ValueError(f"has {entry} in it; numbers are needed")


def rows_of(value: Any) -> Any:
    """Convert an array to nested lists of NumPy's numbers, which keep their shortest decimals; return anything else unchanged."""
    if not is_array(value):
        return value
    array = real_array(value)
    if array.ndim == 0:
        return value
    return list(array) if array.ndim == 1 else [rows_of(row) for row in array]
