"""Run coqc on the theorems of a controller. The library of proof/ is compiled once into the cache folder, the theorems each time.

`stt-codegen theorem` calls `check_theorems`.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from stt_codegen import checker
from stt_codegen.errors import MissingTool
from stt_codegen.files import read_input
from stt_codegen.lemmas import folder as cache_folder
from stt_codegen.theorem.reading import Unread
from stt_codegen.theorem.text import theorem_text

DEBIAN_PACKAGES = "coq libcoq-coquelicot libcoq-flocq"
QUIET_OPTIONS = ("-q", "-w", "-ambiguous-paths,-abstract-large-number")
SIZE_LIMIT = 16_000_000  # bytes of each file that is read
FILE_TIME_LIMIT = 600  # seconds for a file; the slowest of the library takes 20
ACCEPTED_AXIOMS = frozenset(  # of Coq's real numbers, and of Coquelicot's limits on them
    "ClassicalDedekindReals.sig_not_dec ClassicalDedekindReals.sig_forall_dec "
    "FunctionalExtensionality.functional_extensionality_dep Classical_Prop.classic".split()
)


@dataclass(frozen=True)
class CoqVerdict:
    """Whether the theorems of a task hold.

    message: which theorems hold, or why one does not. seconds: processor time of coqc. axioms: their names as Coq prints them.
    """

    task: str
    holds: bool
    message: str
    seconds: float = 0.0
    axioms: tuple[str, ...] = ()

    def document(self) -> dict[str, Any]:
        """Return the verdict as `stt-codegen theorem --json` prints it."""
        return {
            "task": self.task,
            "holds": self.holds,
            "what": self.message,
            "seconds": round(self.seconds, 2),
            "axioms": list(self.axioms),
        }


class CoqRun(NamedTuple):
    """The exit code of a run of coqc and the text that it printed; the code is 1 after a timeout."""

    exit_code: int
    output: str
    errors: str


def library_folder() -> Path:
    """Return the folder of the library's sources: inside the installed package, or beside it in a checkout."""
    installed = Path(__file__).parent.parent / "proof"
    return installed if installed.is_dir() else Path(__file__).parent.parent.parent / "proof"


def library_modules() -> list[str]:
    """Return the names of the library's files without `.v`, in the order in which they are compiled."""
    project_lines = (library_folder() / "_CoqProject").read_text().splitlines()
    return [line.removesuffix(".v") for line in project_lines if line.endswith(".v")]


def find_coqc() -> str:
    """Return the path of coqc. Raises `MissingTool`."""
    path = shutil.which("coqc")
    if path is None:
        raise MissingTool(f"coqc is not found; install (Debian names): {DEBIAN_PACKAGES}")
    return path


def compiled_library() -> Path:
    """Return the folder of the compiled library in the cache, one for each version of the sources and of Coq.

    Compiles it in a minute where the cache does not have it. Raises `MissingTool`.
    """
    coqc, sources = find_coqc(), library_folder()
    digest = hashlib.sha256(subprocess.run([coqc, "--version"], capture_output=True, check=False).stdout)
    for name in library_modules():
        digest.update(f"{name}\0".encode() + (sources / f"{name}.v").read_bytes() + b"\0")
    cached = cache_folder() / f"proof-{digest.hexdigest()[:16]}"
    if cached.is_dir():
        return cached
    cached.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=cached.parent) as build:
        for name in library_modules():
            shutil.copy(sources / f"{name}.v", build)
            run = _run_coqc(coqc, Path(build), f"{name}.v", library=".")
            if run.exit_code:
                raise MissingTool(_unusable_coq(name, run.errors))
        with contextlib.suppress(OSError):  # another process has renamed its folder first
            os.rename(build, cached)
        Path(build).mkdir(exist_ok=True)  # TemporaryDirectory removes it
    return cached


def _unusable_coq(name: str, errors: str) -> str:
    """Return the message for a Coq that does not compile the file `name` of the library."""
    lacks_libraries = "Cannot find a physical path" in errors or "Unable to locate library" in errors
    problem = "it lacks libraries" if lacks_libraries else f"it does not accept proof/{name}.v: {' '.join(errors.split())[-300:]}"
    return f"coqc is found, but {problem}; install (Debian names): {DEBIAN_PACKAGES} (8.16.1, 3.2.0 and 4.1.0 are known to do)"


def _run_coqc(coqc: str, folder: Path, file: str, library: str) -> CoqRun:
    """Compile `file` in `folder`, with the compiled library of the folder `library` under the name Stt."""
    command = [coqc, *QUIET_OPTIONS, "-Q", library, "Stt", file]
    try:
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=FILE_TIME_LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return CoqRun(1, "", f"coqc has not ended after {FILE_TIME_LIMIT} s")
    return CoqRun(run.returncode, run.stdout, run.stderr)


def child_processor_seconds() -> float:
    """Return the processor time of all child processes of this process that have ended."""
    times = os.times()
    return times.children_user + times.children_system


def check_with_coq(text: bytes, name: str) -> CoqVerdict:
    """Compile the text of `<name>.v` and compare the axioms that Coq prints with the accepted ones."""
    coqc, library = find_coqc(), compiled_library()
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / f"{name}.v").write_bytes(text)
        begin = child_processor_seconds()
        run = _run_coqc(coqc, Path(scratch), f"{name}.v", str(library))
        seconds = child_processor_seconds() - begin
    if run.exit_code:
        return CoqVerdict(name, False, _failure_message(text.decode(), run.errors), seconds)
    before_axioms, _, printed_axioms = run.output.partition("Axioms:\n")
    entries = re.findall(r"^(\S.*(?:\n .*)*)", printed_axioms, re.M)  # a name with its type; a long type goes on, indented
    axioms = tuple(sorted(entry.split()[0] for entry in entries))
    foreign = sorted(set(axioms) - ACCEPTED_AXIOMS)
    if before_axioms.strip() or not axioms or len(axioms) != len(set(axioms)) or any(" assumed " in e for e in entries):
        printed = " ".join(run.output.split())[:200] or "it says nothing"
        return CoqVerdict(name, False, f"coqc does not list axioms in the known form: {printed}", seconds)
    theorems = re.findall(r"^Theorem (\w+)", _without_strings(text.decode()), re.M)
    message = f"it rests on {', '.join(foreign)}" if foreign else f"Coq accepts {', '.join(theorems)}"
    return CoqVerdict(name, not foreign, message, seconds, axioms)


def _without_strings(text: str) -> str:
    """Return the Coq text with empty strings and the same lines: the C in a string may have a line that looks like a theorem."""
    return re.sub(r'"(?:[^"]|"")*"', lambda string: '"' + "\n" * string[0].count("\n") + '"', text)


def _failure_message(text: str, errors: str) -> str:
    """Name the lemma that coqc stopped at, with the comment above it."""
    location = re.search(r"line (\d+), characters .*?:\s*Error:(.*)", errors, re.S)
    if location is None:
        return " ".join(errors.split())[-300:]
    lines = _without_strings(text).splitlines()[: int(location[1])]
    at = next((k for k in reversed(range(len(lines))) if re.match(r"(Lemma|Theorem|Definition) \w+", lines[k])), 0)
    name = lines[at].split()[1] if lines else "?"
    comment = next((line.strip("(* )") for line in reversed(lines[:at]) if line.startswith("(*")), "")
    is_false_computation = "eq_refl" in location[2] or "true" in location[2]  # Coq's own words say no more then
    reason = "" if is_false_computation else f": {' '.join(location[2].split())[:200]}"
    return f"{name} does not hold ({comment}){reason}"


def check_theorems(task: Path, source: Path, certificate: Path) -> CoqVerdict:
    """Write the theorems of a controller's files, and run the stand-alone checker and then Coq on them.

    The checker's verdict connects the theorems with the C. Raises `BadInput` where no theorem is written about such a task, or a
    file cannot be read; `MissingTool`.
    """
    find_coqc()
    remedy = "give a task, the C that was generated from it, and the files beside it"
    contents = [read_input(path, SIZE_LIMIT, remedy) for path in (task, source.with_suffix(".h"), source, certificate)]
    try:
        text = theorem_text(*contents)
    except Unread as problem:
        return CoqVerdict(source.stem, False, str(problem))
    refusal = checker_refusal(task, source, certificate)
    return CoqVerdict(source.stem, False, refusal) if refusal else check_with_coq(text, source.stem)


def checker_refusal(task: Path, source: Path, certificate: Path) -> str:
    """Return the message of the stand-alone checker where it refuses the files; empty where it verifies them."""
    command = [sys.executable, "-I", str(checker.FOLDER), str(task), str(source), str(certificate)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    return (run.stdout + run.stderr).strip() or "the checker says nothing" if run.returncode else ""
