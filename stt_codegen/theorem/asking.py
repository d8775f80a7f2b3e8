"""Coq asked about a controller: the library compiled once into the cache folder, the controller's theorems each time anew."""

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
from typing import Any

from stt_codegen.certify import checker
from stt_codegen.errors import BadInput, MissingTool
from stt_codegen.lemmas import folder
from stt_codegen.theorem.reading import Unread
from stt_codegen.theorem.text import theorem_text

PACKAGES = "coq libcoq-coquelicot libcoq-flocq"
QUIET = ("-q", "-w", "-ambiguous-paths,-abstract-large-number")
LONGEST = 600  # seconds for a file; the slowest of the library takes 20
AXIOMS = frozenset(  # of Coq's real numbers, and of Coquelicot's limits on them
    "ClassicalDedekindReals.sig_not_dec ClassicalDedekindReals.sig_forall_dec "
    "FunctionalExtensionality.functional_extensionality_dep Classical_Prop.classic".split()
)


@dataclass(frozen=True)
class Answer:
    """Whether the theorems hold, or what does not; seconds of processor time that coqc took, and axioms that Coq names."""

    task: str
    holds: bool
    what: str
    seconds: float = 0.0
    axioms: tuple[str, ...] = ()

    def document(self) -> dict[str, Any]:
        found = {"task": self.task, "holds": self.holds, "what": self.what}
        return {**found, "seconds": round(self.seconds, 2), "axioms": list(self.axioms)}


def library_folder() -> Path:
    """Where the library's sources are: inside the installed package, or beside it in a checkout."""
    inside = Path(__file__).parent.parent / "proof"
    return inside if inside.is_dir() else Path(__file__).parent.parent.parent / "proof"


def names() -> list[str]:
    """The library's files in the order in which they are compiled."""
    listed = (library_folder() / "_CoqProject").read_text().splitlines()
    return [line.removesuffix(".v") for line in listed if line.endswith(".v")]


def coqc() -> str:
    """Raises `MissingTool`."""
    found = shutil.which("coqc")
    if found is None:
        raise MissingTool(f"coqc is not found; install (Debian names): {PACKAGES}")
    return found


def library() -> Path:
    """The compiled library, of these sources and this Coq; made where it is not there yet, in a minute. Raises
    `MissingTool`."""
    compiler, source = coqc(), library_folder()
    digest = hashlib.sha256(subprocess.run([compiler, "--version"], capture_output=True, check=False).stdout)
    for name in names():
        digest.update(f"{name}\0".encode() + (source / f"{name}.v").read_bytes() + b"\0")
    kept = folder() / f"proof-{digest.hexdigest()[:16]}"
    if kept.is_dir():
        return kept
    kept.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=kept.parent) as made:
        for name in names():
            shutil.copy(source / f"{name}.v", made)
            code, _, failed = _run(compiler, Path(made), f"{name}.v", ".")
            if code:
                raise MissingTool(_unfit(name, failed))
        with contextlib.suppress(OSError):  # another process was quicker
            os.rename(made, kept)
        Path(made).mkdir(exist_ok=True)  # for the end of the block
    return kept


def _unfit(name: str, failed: str) -> str:
    absent = "Cannot find a physical path" in failed or "Unable to locate library" in failed
    what = "it lacks libraries" if absent else f"it does not accept proof/{name}.v: {' '.join(failed.split())[-300:]}"
    return f"coqc is found, but {what}; install (Debian names): {PACKAGES} (8.16.1, 3.2.0 and 4.1.0 are known to do)"


def _run(compiler: str, where: Path, file: str, path: str) -> tuple[int, str, str]:
    command = [compiler, *QUIET, "-Q", path, "Stt", file]
    try:
        done = subprocess.run(command, cwd=where, capture_output=True, text=True, timeout=LONGEST, check=False)
    except subprocess.TimeoutExpired:
        return 1, "", f"coqc has not ended after {LONGEST} s"
    return done.returncode, done.stdout, done.stderr


def processor() -> float:
    """Seconds of processor time that processes made here have taken."""
    spent = os.times()
    return spent.children_user + spent.children_system


def ask_coq(text: bytes, name: str) -> Answer:
    """The theorems of a file `<name>.v`, as they are written."""
    compiler, compiled = coqc(), library()
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / f"{name}.v").write_bytes(text)
        begin = processor()
        code, said, failed = _run(compiler, Path(scratch), f"{name}.v", str(compiled))
        seconds = processor() - begin
    if code:
        return Answer(name, False, _failing(text.decode(), failed), seconds)
    before, _, listed = said.partition("Axioms:\n")
    entries = re.findall(r"^(\S.*(?:\n .*)*)", listed, re.M)  # a name with its type, which is indented where it is long
    axioms = tuple(sorted(entry.split()[0] for entry in entries))
    foreign = sorted(set(axioms) - AXIOMS)
    if before.strip() or not axioms or len(axioms) != len(set(axioms)) or any(" assumed " in e for e in entries):
        told = " ".join(said.split())[:200] or "it says nothing"
        return Answer(name, False, f"coqc does not list axioms as it should: {told}", seconds)
    stated = re.findall(r"^Theorem (\w+)", _without_strings(text.decode()), re.M)
    told = f"it rests on {', '.join(foreign)}" if foreign else f"Coq accepts {', '.join(stated)}"
    return Answer(name, not foreign, told, seconds, axioms)


def _without_strings(text: str) -> str:
    """The texts that a theorem is about are strings; what stands in them are no theorems."""
    return re.sub(r'"(?:[^"]|"")*"', lambda string: '"' + "\n" * string[0].count("\n") + '"', text)


def _failing(text: str, failed: str) -> str:
    """The lemma that coqc stopped at, with what is written above it."""
    place = re.search(r"line (\d+), characters .*?:\s*Error:(.*)", failed, re.S)
    if place is None:
        return " ".join(failed.split())[-300:]
    lines = _without_strings(text).splitlines()[: int(place[1])]
    at = next((k for k in reversed(range(len(lines))) if re.match(r"(Lemma|Theorem|Definition) \w+", lines[k])), 0)
    name = lines[at].split()[1] if lines else "?"
    above = next((line.strip("(* )") for line in reversed(lines[:at]) if line.startswith("(*")), "")
    said = "" if "eq_refl" in place[2] or "true" in place[2] else f": {' '.join(place[2].split())[:200]}"
    return f"{name} does not hold ({above}){said}"


def ask(task: Path, source: Path, certificate: Path) -> Answer:
    """The theorems of a controller's files: first the stand-alone checker, whose word connects them with the C, then Coq. Raises
    `BadInput` where no theorem is written about such a task, or a file is none; `MissingTool`."""
    coqc()
    try:
        data = [path.read_bytes() for path in (task, source.with_suffix(".h"), source, certificate)]
    except OSError as problem:
        raise BadInput(f"{problem.filename} cannot be read ({problem.strerror})") from problem
    try:
        text = theorem_text(*data)
    except Unread as problem:
        return Answer(source.stem, False, str(problem))
    refused = checker_refuses(task, source, certificate)
    return Answer(source.stem, False, refused) if refused else ask_coq(text, source.stem)


def checker_refuses(task: Path, source: Path, certificate: Path) -> str:
    """What the stand-alone checker says where it does not say yes."""
    command = [sys.executable, checker.__file__, str(task), str(source), str(certificate)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return (done.stdout + done.stderr).strip() or "the checker says nothing" if done.returncode else ""
