"""Reads the records that mypy_reads.py writes: which member of which class each line of a source reads."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.support.mypy_reads import record_of
from tests.support.unused import Reads


def reads_of(folder: Path, path: Path) -> Reads | None:
    """Return the members that mypy sees read in a source, by position; None for a source that mypy does not check."""
    record = record_of(folder / ".mypy_cache", str(path.relative_to(folder)))
    if not record.exists():
        return None
    reads: Reads = {}
    for line in record.read_text().splitlines():
        row, column, name = line.split(" ", 2)
        reads.setdefault((int(row), int(column)), set()).add(name)
    return reads


def run_mypy(folder: Path) -> None:
    """Run mypy, which brings the records up to date; it is quick after the run of mypy in `make test`."""
    result = subprocess.run([sys.executable, "-m", "mypy"], cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
