"""Listings with a change, for tests and benchmarks that ask whether the change is noticed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from unittest.mock import patch

from stt_codegen.checker.stt_checker import source


@contextmanager
def changed_pieces(pieces: Mapping[str, list[str]]) -> Iterator[None]:
    """Put pieces with these headings in the place of those of the listings."""
    assert pieces.keys() <= source.pieces().keys()
    changed = {**source.pieces(), **pieces}
    with patch.object(source, "pieces", lambda: changed):
        yield


@contextmanager
def replaced_text(heading: str, old: str, new: str) -> Iterator[None]:
    """Replace a text that occurs in a piece once."""
    text = "\n".join(source.pieces()[heading])
    assert text.count(old) == 1, f"{heading}: {old!r} occurs {text.count(old)} times"
    with changed_pieces({heading: text.replace(old, new).split("\n")}):
        yield
