"""What mypy saw read in each source: the records of mypy_reads.py, brought up to date."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.support.mypy_reads import record_of
from tests.support.unused import Reads


def reads_of(folder: Path, path: Path) -> Reads | None:
    """What mypy sees read in a source; None where it does not check it."""
    record = record_of(folder / ".mypy_cache", str(path.relative_to(folder)))
    if not record.exists():
        return None
    reads: Reads = {}
    for line in record.read_text().splitlines():
        row, column, name = line.split(" ", 2)
        reads.setdefault((int(row), int(column)), set()).add(name)
    return reads


def run_mypy(folder: Path) -> None:
    """Bring the records up to date: at once after the run of mypy in `make test`."""
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
