"""Say for a reviewer which numbers changed between two texts of one emitted file, and how far the tube's edges move by it."""

from __future__ import annotations

import re

_NUMBER = re.compile(r"(?<![\w.])-?(?:0[xX][0-9a-fA-F]+|\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)[FfUuLl]*\b")
_HASH = re.compile(r'"[0-9a-f]{16}"|"[0-9a-f]{64}"')
_START_BOX = re.compile(r"_start_(?:lower|upper)\[\d+\][^;]*;")
_COEFFICIENTS = re.compile(r"_coefficients\[\d+\] = \{(.*?)\};", re.DOTALL)


def describe_numbers(old: str, new: str) -> str:
    """Say for a reviewer whether numbers changed between two texts of one file, how many, and by how much."""
    old, new = (_HASH.sub("", text) for text in (old, new))  # a hash changes with any number
    before, after = _NUMBER.findall(old), _NUMBER.findall(new)
    if _NUMBER.sub("#", old) != _NUMBER.sub("#", new):
        if before == after:
            return "the text changed, no number did"
        return f"the structure changed ({len(before)} numbers before, {len(after)} now); compare it as new"
    pairs = [(_value(a), _value(b)) for a, b in zip(before, after, strict=True)]
    changed = [(a, b) for a, b in pairs if a != b]
    if not changed:
        return "no number changed"
    a, b = max(changed, key=lambda p: abs(p[0] - p[1]) / max(abs(p[0]), abs(p[1])))
    relative_change = abs(a - b) / max(abs(a), abs(b))
    text = (
        f"{len(changed)} of {len(pairs)} numbers changed, the largest relative change is {relative_change:.3g} ({a!r} -> {b!r})"
    )
    movement = largest_edge_movement(old, new)
    return text if movement is None else f"{text}; the tube's edges move by at most {movement:.3g}"


def _value(text: str) -> float:
    """Return the value of a number of C or Python."""
    if "x" in text.lower():
        return float(int(text.rstrip("UuLl"), 16))
    return float(text.rstrip("FfUuLl"))


def largest_edge_movement(old: str, new: str) -> float | None:
    """Bound how far the tube's edges differ between two C files that differ in spline coefficients, and so in the start box.

    An edge is a sum of coefficients with weights >= 0 that sum to 6. None where anything else changed, such as the time scale.
    """
    tables = [_COEFFICIENTS.search(text) for text in (old, new)]
    remainders = [_START_BOX.sub("", _COEFFICIENTS.sub("", text)) for text in (old, new)]
    if not all(tables) or remainders[0] != remainders[1]:
        return None
    before, after = ([_value(v) for v in _NUMBER.findall(t.group(1))] for t in tables if t)
    return 6 * max(abs(a - b) for a, b in zip(before, after, strict=True))
