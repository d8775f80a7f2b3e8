"""The lower ends of the dependencies' ranges: installed in a folder of their own, then everything in generated/ is made again.

    python -m benchmarks ends

The refined design's controllers must be the same bytes. Two kinds of files may differ, and are counted apart: the adaptive and
the literal design's (CasADi writes x + x as 2 * x in some versions, which is the same number), and what a double's self-test
accepts (enclosures as narrow as the installed FLINT makes them). Exit 1 where anything else differs.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DIFFERS = re.compile(r"^(\S+): differs", re.M)
EXPECTED = {
    "CasADi's spelling of the adaptive and the literal design": re.compile(r"^[^/]+/(adaptive|literal)/"),
    "what a double's self-test accepts": re.compile(r"^\w+/refined/double/\w+(_selftest\.c|\.certificate\.json)$"),
}


def lower_ends() -> list[str]:
    """The least version of each dependency, pinned."""
    ranges = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    return [re.sub(r">=([\w.]+).*", r"==\1", each) for each in ranges]


def main() -> None:
    """Install, check, count."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        python = Path(folder) / "bin" / "python"
        print(f"installing {', '.join(lower_ends())} ...", flush=True)
        install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*install, *lower_ends(), "hatchling", "editables"], check=True)
        subprocess.run([*install, "--no-deps", "--no-build-isolation", "-e", ROOT], check=True)
        check = [python, "-m", "stt_codegen.cli", "check", ROOT / "generated"]
        result = subprocess.run(check, capture_output=True, text=True, check=False)
    names = DIFFERS.findall(result.stdout + result.stderr)
    if result.returncode not in (0, 1) or (result.returncode == 1 and not names):
        sys.exit(result.stdout + result.stderr)
    left = set(names)
    for why, pattern in EXPECTED.items():
        some = {name for name in left if pattern.match(name)}
        left -= some
        print(f"{len(some):3} files differ: {why}")
    print(f"{len(left):3} other files differ", *sorted(left), sep="\n    ")
    sys.exit(1 if left else 0)


if __name__ == "__main__":
    main()
