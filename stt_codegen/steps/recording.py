"""Read a recorded step: a text file with a row for every sample, and in a row the time, the command and the response.

Cells are separated by semicolons, tabs, commas or spaces; with semicolons or tabs a comma may be the decimal point. Empty lines
and those that begin with # or % are skipped. Lines before the first row of numbers are headings, and the last of them has the
names of the columns.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stt_codegen.errors import BadInput
from stt_codegen.files import decode, read_input

QUANTITIES = ("time", "command", "response")
COMMENT_MARKS = ("#", "%")
RECORD_SIZE_LIMIT = 32_000_000  # bytes
ROWS_LIMIT = 500_000  # a row takes about a kilobyte of memory while it is read


@dataclass(frozen=True)
class StepRecord:
    """Samples of a drive: time in seconds, rising; command and response in units of their own. lines: of each sample in its file,
    from 1. columns: the names of the three columns, or their numbers."""

    time: tuple[float, ...]
    command: tuple[float, ...]
    response: tuple[float, ...]
    lines: tuple[int, ...]
    columns: tuple[str, ...]


def read_record(path: Path, columns: Sequence[str] = ()) -> StepRecord:
    """Read a file. Raises `BadInput` with the file and the line; `parse_record` explains `columns`."""
    remedy = f"give a record as CSV, of at most {ROWS_LIMIT:,} rows"
    return parse_record(decode(path, read_input(path, RECORD_SIZE_LIMIT, remedy), remedy), str(path), columns)


def parse_record(text: str, name: str = "record", columns: Sequence[str] = ()) -> StepRecord:
    """Parse the text of a record.

    columns: names or numbers from 1 of the columns of time, command and response; empty: the first three. Raises `BadInput` where
    the text is no record; the message begins with `name`.
    """
    lines = [(k, line.strip()) for k, line in enumerate(text.splitlines(), 1)]
    if len(lines) > ROWS_LIMIT:
        raise BadInput(f"{name}: has {len(lines):,} lines; at most {ROWS_LIMIT:,} are read, keep the rows about the step")
    rows = [(k, line) for k, line in lines if line and not line.startswith(COMMENT_MARKS)]
    first = next((j for j, (_, line) in enumerate(rows) if _is_number(_cells(line)[0])), None)
    if first is None:
        raise BadInput(f"{name}: has no row of numbers; a row for every sample is needed: time, command, response")
    headings = _cells(rows[first - 1][1]) if first else []
    numbers = _column_numbers(name, columns, headings, len(_cells(rows[first][1])))
    samples = [_sample(f"{name}, line {k}", line, numbers) for k, line in rows[first:]]
    for (k, _), sample, before in zip(rows[first + 1 :], samples[1:], samples, strict=False):
        if not sample[0] > before[0]:
            problem = f"time {sample[0]:g} is not after {before[0]:g} of the row before"
            raise BadInput(f"{name}, line {k}: {problem}; times must rise, in seconds")
    time, command, response = zip(*samples, strict=True)
    labels = tuple(headings[j] if j < len(headings) else f"column {j + 1}" for j in numbers)
    return StepRecord(time, command, response, tuple(k for k, _ in rows[first:]), labels)


def _cells(line: str) -> list[str]:
    """Split a line into cells."""
    mark = next((mark for mark in (";", "\t", ",") if mark in line), None)
    cells = [cell.strip().strip('"') for cell in line.split(mark)]
    return [cell.replace(",", ".") for cell in cells] if mark in (";", "\t") else cells


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _column_numbers(name: str, columns: Sequence[str], headings: Sequence[str], count: int) -> list[int]:
    """Return the numbers from 0 of the columns of time, command and response. Raises `BadInput`."""
    if columns and len(columns) != len(QUANTITIES):
        raise BadInput(f"--columns {','.join(columns)}: names {len(columns)}; three are needed: time, command, response")
    numbers = []
    for column in columns or ("1", "2", "3"):
        if column in headings:
            numbers.append(headings.index(column))
        elif column.isdecimal() and len(column) < 10 and 1 <= int(column) <= count:
            numbers.append(int(column) - 1)
        elif columns:
            names = f"one of {', '.join(headings)}, or " if headings else ""
            raise BadInput(f"--columns {column}: {name} has no such column; use {names}a number from 1 to {count}")
        else:
            raise BadInput(f"{name}: has {count} column{'s' * (count > 1)}; three are needed: time, command, response")
    if len(set(numbers)) < len(numbers):
        raise BadInput(f"--columns {','.join(columns)}: names a column twice; time, command and response are three columns")
    return numbers


def _sample(where: str, line: str, numbers: Sequence[int]) -> tuple[float, float, float]:
    """Return time, command and response of a row. Raises `BadInput`, which begins with `where`."""
    cells, values = _cells(line), []
    for quantity, j in zip(QUANTITIES, numbers, strict=True):
        if j >= len(cells):
            raise BadInput(f"{where}: has {len(cells)} cell{'s' * (len(cells) > 1)}; the {quantity} is in column {j + 1}")
        if not _is_number(cells[j]) or not math.isfinite(float(cells[j])):
            raise BadInput(f"{where}: the {quantity} is {cells[j]!r:.40}; a finite number is needed")
        values.append(float(cells[j]))
    return values[0], values[1], values[2]
