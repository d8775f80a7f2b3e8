"""Benchmark results as Markdown, and where they are recorded: one section a benchmark, with the command that made it."""

from __future__ import annotations

import contextlib
import math
import os
import platform
import re
import sys
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from stt_codegen.errors import BadInput


def table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table, columns aligned so that it reads well as text too. A bar in a cell is no end of it."""
    lines = [[re.sub(r"(?<!\\)\|", r"\\|", cell) for cell in row] for row in (headings, *rows)]
    widths = [max(len(line[c]) for line in lines) for c in range(len(headings))]

    def text(line: Sequence[str]) -> str:
        return "| " + " | ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)) + " |"

    return "\n".join([text(lines[0]), "|" + "|".join("-" * (w + 2) for w in widths) + "|", *map(text, lines[1:])])


def number(value: float, digits: int = 3) -> str:
    """So many significant digits, a dash where there is no number."""
    if not math.isfinite(value):
        return "-"
    return f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"


def machine() -> str:
    """What the times were measured on."""
    model = platform.machine()
    try:
        found = re.search(r"^model name\s*:\s*(.+)$", Path("/proc/cpuinfo").read_text(), re.M)
        model = found.group(1) if found else model
    except OSError:
        pass
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}"


PEERS = ("brax", "clarabel", "drake", "fastpathplanning", "highspy", "hj-reachability", "jax", "ompl", "osqp", "pyastar2d")


def versions() -> str:
    """What is said of every peer that is installed: "; name version"."""
    found = []
    for name in PEERS:
        with contextlib.suppress(metadata.PackageNotFoundError):
            found.append(f"; {name} {metadata.version(name)}")
    return "".join(found)


def command() -> str:
    """The command line that runs, without folders."""
    name = Path(sys.argv[0]).stem
    return " ".join(["python -m benchmarks", *([] if name == "__main__" else [name]), *sys.argv[1:]])


def record(path: Path, section: str, text: str) -> None:
    """Put `text` into the file's section of that name, replacing what it held; the other sections stay."""
    begin, end = f"<!-- {section} -->", f"<!-- end of {section} -->"
    block = f"{begin}\n{text.strip()}\n{end}\n"
    try:
        old = path.read_text(encoding="utf-8") if path.exists() else "# Measured\n"
        if begin in old:
            rest = old[old.index(begin) + len(begin) :]
            after = rest[rest.index(end) + len(end) :] if end in rest else ""
            new = old[: old.index(begin)] + block + after.lstrip("\n")
        else:
            new = old.rstrip("\n") + "\n\n" + block
        half = path.with_name(path.name + ".new")
        half.write_text(new, encoding="utf-8", newline="\n")
        half.replace(path)
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: cannot be read or written ({error})") from None
