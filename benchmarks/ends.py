"""Install the oldest allowed versions of the dependencies in a new environment, then the newest, and check generated/ with both.

    python -m benchmarks ends

Controllers of the refined design must have the same bytes. Two kinds of files may differ, and are counted: those of the adaptive
and the literal design, because some versions of CasADi write x + x as 2 * x; and the results that the self-test of a double
accepts, whose enclosures depend on the version of FLINT. What --json prints must be one JSON document, so no library may print.
The exit code is 1 where another file differs, or where --json prints something else.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DIFFERENCE = re.compile(r"^(\S+): differs", re.M)
EXPECTED_DIFFERENCES = {  # by reason: paths in generated/
    "CasADi's spelling of the adaptive and the literal design": re.compile(r"^[^/]+/(adaptive|literal)/"),
    "what a double's self-test accepts": re.compile(r"^\w+/refined/double/\w+(_selftest\.c|\.certificate\.json)$"),
}


def lower_ends() -> list[str]:
    """Return the requirement of the oldest allowed version of each dependency."""
    ranges = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    return [re.sub(r">=([\w.]+).*", r"==\1", requirement) for requirement in ranges]


def newest_versions() -> list[str]:
    """Return the names of the dependencies, of which pip installs the newest versions."""
    ranges = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    return [re.sub(r"[><=!~].*", "", requirement) for requirement in ranges]


def holds_with(requirements: list[str]) -> bool:
    """Check generated/ and --json in a new environment with these versions; print the number of differences of each kind."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        python = Path(folder) / "bin" / "python"
        print(f"installing {', '.join(requirements)} ...", flush=True)
        install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*install, *requirements, "hatchling", "editables"], check=True)
        subprocess.run([*install, "--no-deps", "--no-build-isolation", "-e", ROOT], check=True)
        command = [python, "-m", "stt_codegen.cli"]
        result = subprocess.run([*command, "check", ROOT / "generated"], capture_output=True, text=True, check=False)
        design = [*command, "design", ROOT / "tasks" / "omni_s2.toml", "--json"]
        printed = subprocess.run(design, capture_output=True, text=True, check=True).stdout
    names = DIFFERENCE.findall(result.stdout + result.stderr)
    if result.returncode not in (0, 1) or (result.returncode == 1 and not names):
        sys.exit(result.stdout + result.stderr)
    unexpected = set(names)
    for reason, pattern in EXPECTED_DIFFERENCES.items():
        expected = {name for name in unexpected if pattern.match(name)}
        unexpected -= expected
        print(f"{len(expected):3} files differ: {reason}")
    print(f"{len(unexpected):3} other files differ", *sorted(unexpected), sep="\n    ")
    try:
        json.loads(printed)
    except ValueError as error:
        print(f"--json does not print one document: {error}\n{printed[:200]}")
        return False
    print("--json prints one document")
    return not unexpected


def main() -> None:
    """Check with the oldest versions, then with the newest."""
    sys.exit(0 if all([holds_with(lower_ends()), holds_with(newest_versions())]) else 1)


if __name__ == "__main__":
    main()
