"""Markdown of benchmark results, and the file that records them: each benchmark has a section, with its command."""

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
    """Return a Markdown table whose columns are aligned, so that it reads well as text. Bars in a cell are escaped."""
    lines = [[re.sub(r"(?<!\\)\|", r"\\|", cell) for cell in row] for row in (headings, *rows)]
    widths = [max(len(line[c]) for line in lines) for c in range(len(headings))]

    def text(line: Sequence[str]) -> str:
        return "| " + " | ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)) + " |"

    return "\n".join([text(lines[0]), "|" + "|".join("-" * (w + 2) for w in widths) + "|", *map(text, lines[1:])])


def number(value: float, digits: int = 3) -> str:
    """Return the value with `digits` significant digits, or to the whole number if that has more; a dash for NaN and infinity.

    >>> number(0.12345), number(999.9), number(12345.6)
    ('0.123', '1000', '12346')
    """
    if not math.isfinite(value):
        return "-"
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if abs(float(text)) >= 10**digits else text


def machine() -> str:
    """Return processor, number of cores and version of Python: what times were measured on."""
    model = platform.machine()
    try:
        match = re.search(r"^model name\s*:\s*(.+)$", Path("/proc/cpuinfo").read_text(), re.M)
        model = match.group(1) if match else model
    except OSError:
        pass
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}"


PEERS = ("brax", "clarabel", "drake", "fastpathplanning", "highspy", "hj-reachability", "jax", "ompl", "osqp", "pyastar2d")


def versions() -> str:
    """Return "; name version" for every installed package of PEERS."""
    texts = []
    for name in PEERS:
        with contextlib.suppress(metadata.PackageNotFoundError):
            texts.append(f"; {name} {metadata.version(name)}")
    return "".join(texts)


def command() -> str:
    """Return the command line of this process, without folders."""
    name = Path(sys.argv[0]).stem
    return " ".join(["python -m benchmarks", *([] if name == "__main__" else [name]), *sys.argv[1:]])


def record(path: Path, section: str, text: str) -> None:
    """Replace the file's section of that name by `text`, or append the section. The other sections stay.

    Raises BadInput for a file that cannot be read or written."""
    begin, end = f"<!-- {section} -->", f"<!-- end of {section} -->"
    block = f"{begin}\n{text.strip()}\n{end}\n"
    try:
        old = path.read_text(encoding="utf-8") if path.exists() else "# Measured\n"
        if begin in old:
            rest = old[old.index(begin) + len(begin) :]
            later_sections = rest[rest.index(end) + len(end) :] if end in rest else ""
            new = old[: old.index(begin)] + block + later_sections.lstrip("\n")
        else:
            new = old.rstrip("\n") + "\n\n" + block
        partial = path.with_name(path.name + ".new")
        partial.write_text(new, encoding="utf-8", newline="\n")
        partial.replace(path)
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: cannot be read or written ({error})") from None
