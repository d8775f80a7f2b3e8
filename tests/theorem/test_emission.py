"""What proof/ has of the emitted C is printed from the checker's listing, and a change of the listing changes it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from stt_codegen.checker.stt_checker.source import pieces
from stt_codegen.theorem import emission

PRINTED_PIECES = (
    "segment of a time",
    "segment of a tick",
    "basis",
    "edge",
    "error transform and law",
    "logarithm",
    "exponent and mantissa",
    "compiler flags",
    "segment and s",
    "weights",
    "places in the table",
    "edges",
    "NaN unless t is finite",
    "tube",
    "control",
    "control at a tick",
    "sum of zeros",
    "inputs that are not finite",
    "law",
    "state between the edges",
)


def test_the_files_of_proof_have_what_the_listing_says() -> None:
    """`python -m stt_codegen.theorem.emission` writes them again."""
    for path, text in emission.printed_files().items():
        assert path.read_text() == text, path


def with_listing(monkeypatch: pytest.MonkeyPatch, piece: str, lines: list[str]) -> dict[Path, str]:
    """Return the files of proof/ for a listing of which a piece has other lines."""
    changed = {**pieces(), piece: lines}
    monkeypatch.setattr(emission, "pieces", lambda: changed)
    return emission.printed_files()


def counts(line: str) -> bool:
    """Whether a line says something about a C that the theorems are about."""
    is_comment_or_bracket = line.strip() in ("", "{", "}") or line.lstrip().startswith("/*")
    is_of_unprinted_function = any(part in line for part in ("normalized_error", "v0 = a - b;", "v1 = v0 / width;", "return v1;"))
    return not is_comment_or_bracket and not is_of_unprinted_function and not re.search(r"\[(order 2|scaled)", line)


@pytest.mark.parametrize("piece", PRINTED_PIECES)
def test_without_a_line_of_the_listing_the_printed_text_differs(piece: str, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = pieces()[piece]
    for k in (k for k, line in enumerate(lines) if counts(line)):
        try:
            changed_files = with_listing(monkeypatch, piece, [*lines[:k], *lines[k + 1 :]])
        except (ValueError, KeyError):  # the rest is no C that is known
            continue
        assert any(path.read_text() != text for path, text in changed_files.items()), lines[k]


@pytest.mark.parametrize(
    "line",
    [
        "    const P_real v0 = w0 * q0 + w1;",
        "    goto end;",
        "    const float v0 = 1.0;",
        "    const P_real v0 = 1.0;  [rust]",
        "    const P_real v0 = $unknown;",
        "    const P_real v0 = w0 % q0;",
    ],
)
def test_a_line_that_coq_has_no_words_for_is_refused(line: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises((ValueError, KeyError)):
        with_listing(monkeypatch, "weights", [*pieces()["weights"], line])
