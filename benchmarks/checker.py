"""Measure the stand-alone checker: seconds for every shipped controller, and lines of each of its files.

    python -m benchmarks checker

It ends with exit code 1 where a shipped controller is not verified. Seconds are of the processor, in this process, after imports.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import time
from pathlib import Path

from stt_codegen.checker import FOLDER, check_files

ROOT = Path(__file__).parent.parent


def refined_certificates() -> list[Path]:
    """Return the certificates of generated/ that the checker reads."""
    paths = sorted((ROOT / "generated").rglob("*.certificate.json"))
    return [path for path in paths if json.loads(path.read_text())["method"] == "exact"]


def check(certificate: Path) -> tuple[float, str]:
    """Return the seconds that the checker takes for the files beside a certificate, and its line."""
    name, folder = certificate.name.removesuffix(".certificate.json"), certificate.parent
    expanded = folder / f"{name}.task.toml"
    task = expanded if expanded.exists() else ROOT / "tasks" / f"{name}.toml"
    answer, begin = io.StringIO(), time.process_time()
    with contextlib.redirect_stdout(answer), contextlib.redirect_stderr(answer):
        check_files([str(task), str(folder / f"{name}.c"), str(certificate)])
    return time.process_time() - begin, answer.getvalue().strip()


def main() -> int:
    """Print both tables, and return the exit code."""
    total, refused = 0.0, 0
    for path in refined_certificates():
        seconds, answer = check(path)
        total += seconds
        is_verified = answer.startswith("checker: verified: ")
        refused += not is_verified
        print(f"{path.parent.relative_to(ROOT / 'generated')!s:32s} {seconds:7.3f} s  {'verified' if is_verified else answer}")
    print(f"{'together':32s} {total:7.3f} s\n")
    lines = {path: len(path.read_text().splitlines()) for path in sorted(FOLDER.rglob("*")) if path.suffix in (".py", ".c")}
    for path, count in lines.items():
        print(f"{path.relative_to(FOLDER)!s:40s} {count:5d} lines")
    print(f"{'Python':40s} {sum(count for path, count in lines.items() if path.suffix == '.py'):5d} lines")
    print(f"{'listings':40s} {sum(count for path, count in lines.items() if path.suffix == '.c'):5d} lines")
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
