"""Install the oldest admitted versions of the dependencies in a new environment, then the newest, and use the tool with both.

    python -m benchmarks ends

With each end `check` builds generated/ again, `make demo` is repeated, and every command prints its JSON. Controllers of the
refined design must have the same bytes. Two kinds of files may differ, and are counted: those of the adaptive and the literal
design, because some versions of CasADi write x + x as 2 * x; and the results that the self-test of a double accepts, whose
enclosures depend on the version of FLINT. What --json prints must be one JSON document, and stderr may have progress and messages
of the commands only: no library may print or warn. The exit code is 1 where another file differs, a command fails, or something
else is printed.
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
# Lines that commands print to stderr where all is good: progress, notes, and what three commands say.
MESSAGE = re.compile(
    r"  .+|note: .+|comparing \w+: .+|axioms, all of Coq's real numbers: .+|\w+\.v: theorems about the tube alone; .+"
)
NO_TOOL = 4  # exit code where an emulator is missing
OMNI, C_FILE = "tasks/omni_s2.toml", "generated/omni_s2/refined/float/omni_s2"
JSON_COMMANDS = {  # arguments of each command that has --json
    "design": [OMNI],
    "generate": [OMNI, "--out", "{out}"],
    "simulate": [OMNI],
    "report": [OMNI, "--out", "{out}/page.html"],
    "map": ["{out}/room.yaml", "--picture", "{out}"],
    "schema": [],
    "check": ["{out}/recorded"],
    "certify": [OMNI, f"{C_FILE}.c", f"{C_FILE}.certificate.json"],
    "compare": [OMNI, "--points", "100"],
    "lag": ["{out}/step.csv"],
    "pil": [OMNI, "--board", "m4f"],
    "prove": [OMNI, "--out", "{out}"],
    "theorem": [OMNI, f"{C_FILE}.c"],
}


def requirements() -> list[str]:
    """Return the ranges of the dependencies."""
    ranges: list[str] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    return ranges


def lower_ends() -> list[str]:
    """Return the requirement of the oldest admitted version of each dependency."""
    return [re.sub(r">=([\w.]+).*", r"==\1", requirement) for requirement in requirements()]


def holds_with(versions: list[str]) -> bool:
    """Use the tool in a new environment with these versions. Return whether all of it works; print what does not."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        python = Path(folder) / "bin" / "python"
        print(f"installing {', '.join(versions)} ...", flush=True)
        install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--upgrade"]
        subprocess.run([*install, *versions, "hatchling", "editables"], check=True)
        subprocess.run([*install, "--no-deps", "--no-build-isolation", "-e", ROOT], check=True)
        listing = subprocess.run([python, "-m", "pip", "list", "--format", "freeze"], capture_output=True, text=True, check=True)
        print(", ".join(listing.stdout.split()))
        return all([_has_same_files(python), _prints_json(python), _runs_demo(python)])


def _has_same_files(python: Path) -> bool:
    """Check generated/; print the number of differences of each kind."""
    command = [python, "-m", "stt_codegen.cli", "check", ROOT / "generated"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    names = DIFFERENCE.findall(result.stdout + result.stderr)
    if result.returncode not in (0, 1) or (result.returncode == 1 and not names):
        print(result.stdout + result.stderr)
        return False
    unexpected = set(names)
    for reason, pattern in EXPECTED_DIFFERENCES.items():
        expected = {name for name in unexpected if pattern.match(name)}
        unexpected -= expected
        print(f"{len(expected):3} files differ: {reason}")
    print(f"{len(unexpected):3} other files differ", *sorted(unexpected), sep="\n    ")
    return not unexpected


def problems_of(result: subprocess.CompletedProcess[str]) -> list[str]:
    """Return what is wrong with what a command with --json printed: no document, a bad exit code, or lines of a library."""
    lines = result.stderr.splitlines()
    problems = [f"stderr has {line!r}" for line in lines if result.returncode == 0 and not MESSAGE.fullmatch(line)]
    if result.returncode not in (0, NO_TOOL):
        problems.append(f"exit code {result.returncode}: {result.stderr[-400:]}")
    try:
        json.loads(result.stdout)
    except ValueError as error:
        problems.append(f"stdout is no JSON document ({error}): {result.stdout[:200]}")
    return problems


def _prints_json(python: Path) -> bool:
    """Run every command with --json; print those whose output is more than one document, or that fail or let a library speak."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        (out / "step.csv").write_text(
            "t,u,y\n" + "".join(f"{k / 100},{int(k > 5)},{1 - 0.9 ** max(k - 5, 0)}\n" for k in range(99))
        )
        (out / "room.yaml").write_text("image: room.pgm\nresolution: 0.1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\n"
                                       "free_thresh: 0.196\nnegate: 0\n")  # fmt: skip
        (out / "room.pgm").write_bytes(b"P5 8 8 255\n" + bytes([254] * 20 + [0] * 4 + [254] * 40))
        base = [python, "-m", "stt_codegen.cli"]
        subprocess.run([*base, "generate", OMNI, "--record", out / "recorded"], cwd=ROOT, capture_output=True, check=True)
        is_good = True
        for name, arguments in JSON_COMMANDS.items():
            words = [*base, name, *(text.format(out=out) for text in arguments)]
            if name != "schema":
                words.append("--json")
            result = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
            problems = problems_of(result)
            if problems:
                print(f"{name} --json: {'; '.join(problems)}")
                is_good = False
    print(f"{len(JSON_COMMANDS)} commands with --json: {'one document each' if is_good else 'see above'}")
    return is_good


def _runs_demo(python: Path) -> bool:
    """Repeat `make demo` in a scratch copy of tasks/; print what fails or warns."""
    makefile = (ROOT / "Makefile").read_text()
    recipe = makefile.split("\ndemo:")[1].split("\n\n")[0]
    tasks = makefile.split("CASE_STUDY := ")[1].split("\n")[0]
    lines = [line.strip().removeprefix("@") for line in recipe.splitlines()[2:]]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tasks").symlink_to(ROOT / "tasks")
        script = "\n".join(line.replace("$(BIN)", str(python.parent)).replace("$$", "$") for line in lines)
        script = script.replace("$(CASE_STUDY)", tasks)
        result = subprocess.run(["sh", "-ec", script], cwd=folder, capture_output=True, text=True, check=False)
    is_good = result.returncode == 0 and all(map(MESSAGE.fullmatch, result.stderr.splitlines()))
    print("demo: good" if is_good else f"demo, exit code {result.returncode}:\n{result.stderr[-600:]}")
    return is_good


def main() -> None:
    """Use the oldest versions, then the newest."""
    sys.exit(0 if all([holds_with(lower_ends()), holds_with(requirements())]) else 1)


if __name__ == "__main__":
    main()
