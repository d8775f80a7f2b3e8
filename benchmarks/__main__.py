"""`python -m benchmarks NAME [options]`: run one benchmark; without a name, list them.

`arenas`, `loop`, `missions` and `mcu` are the suites of command_line.py. Every other file of this folder is a benchmark by itself
and takes its own options (`python -m benchmarks tubes --help`). This file imports nothing but the standard library, because some
benchmarks run in environments that lack the package's dependencies.
"""

from __future__ import annotations

import ast
import runpy
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
SUITES = {
    "arenas": "Random arenas designed and certified by the hundred: how many, how fast, how wide, how slow.",
    "loop": "Monte Carlo of closed loops: the emitted C drives through random arenas under disturbances.",
    "missions": "Missions designed and certified: published scenarios, random ones, sets that move.",
    "mcu": "Instructions, code, tables and stack of the emitted controllers on emulated boards.",
}
SHARED = ("__init__", "__main__", "command_line", "bodies")  # files of this folder that are no benchmarks


def benchmarks() -> dict[str, str]:
    """Return the first paragraph of what every benchmark says of itself, by name."""
    paths = [p for p in sorted(FOLDER.glob("*.py")) if p.stem not in SHARED]
    return SUITES | {path.stem: description_of(path).split("\n\n")[0].replace("\n", " ") for path in paths}


def description_of(path: Path) -> str:
    """Return what a benchmark says of itself."""
    return ast.get_docstring(ast.parse(path.read_text())) or ""


def main() -> None:
    """Run the benchmark that the command line names; without one, or with a name that none has (exit code 2), list them."""
    name = sys.argv[1] if len(sys.argv) > 1 else "--help"
    if name in SUITES:
        from benchmarks.command_line import suites
        from stt_codegen.cli.main import run

        run(suites, "benchmarks")
    elif name in benchmarks():
        path = FOLDER / f"{name}.py"
        if {"-h", "--help"} & set(sys.argv) and "ArgumentParser" not in path.read_text():
            print(description_of(path))
            return
        del sys.argv[1]
        runpy.run_module(f"benchmarks.{name}", run_name="__main__", alter_sys=True)
    else:
        for known, paragraph in benchmarks().items():
            print(f"{known}\n    {paragraph}")
        if name not in ("-h", "--help"):
            print(f"benchmarks: {name} is none of these", file=sys.stderr)
            sys.exit(2)


if __name__ == "__main__":
    main()
