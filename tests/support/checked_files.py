"""Recorded controllers as files that a test changes, and what the stand-alone checker answers about them.

A changed file gets its new hash in the certificate, so that the checker must read the change to refuse it.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

from stt_codegen.checker import check_files
from stt_codegen.checker.stt_checker import files as checker_files
from stt_codegen.checker.stt_checker.task import Task
from tests.support.controllers import ROOT

VERIFIED, REFUSED, UNUSABLE = 0, 1, 2  # exit codes of the checker
Files = dict[str, bytes]  # texts by name; the task is task.toml


class Verdict(NamedTuple):
    """Exit code of the checker, and the line that it prints."""

    code: int
    message: str


@cache
def _recorded(name: str, scalar: str) -> Files:
    folder = ROOT / "generated" / name / "refined" / scalar
    return {**{p.name: p.read_bytes() for p in folder.iterdir()}, "task.toml": (ROOT / "tasks" / f"{name}.toml").read_bytes()}


def recorded_files(name: str, scalar: str = "float") -> Files:
    """Return the files of a recorded refined controller, and its task."""
    return dict(_recorded(name, scalar))


def certificate_of(files: Files) -> Any:
    """Return the certificate among the files."""
    return json.loads(files[certificate_name(files)])


def certificate_name(files: Files) -> str:
    (name,) = (file for file in files if file.endswith(".certificate.json"))
    return name


def with_certificate(files: Files, certificate: Any) -> Files:
    return {**files, certificate_name(files): json.dumps(certificate).encode()}


def with_hashes(files: Files) -> Files:
    """Return the files with a certificate that has the hashes of all files that it names, and of the task's data."""
    certificate = certificate_of(files)
    for file in {*certificate["sha256"]} & {*files}:
        certificate["sha256"][file] = hashlib.sha256(files[file]).hexdigest()
    certificate["sha256"]["task_data"] = Task(files["task.toml"]).digest
    return with_certificate(files, certificate)


def with_text(files: Files, file: str, old: str, new: str) -> Files:
    """Return the files with every occurrence of a text of one file replaced, and with new hashes."""
    text = files[file].decode()
    assert old in text, f"{file} does not have {old!r}"
    assert old != new
    return with_hashes({**files, file: text.replace(old, new).encode()})


def write_files(files: Files, folder: Path) -> list[str]:
    """Write the files into a folder, and return the arguments of the checker."""
    for file, data in files.items():
        (folder / file).write_bytes(data)
    proof = certificate_name(files)
    return [str(folder / file) for file in ("task.toml", proof.replace(".certificate.json", ".c"), proof)]


def verdict(files: Files, folder: Path) -> Verdict:
    """Run the checker on the files, written into the folder."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
        code = check_files(write_files(files, folder))
    return Verdict(code, output.getvalue())


def verdict_of_proof(files: Files, folder: Path) -> Verdict:
    """Run the checker without its comparison of hashes and listings, so that only the proof of the numbers can refuse."""
    with mock.patch.object(checker_files, "check_hashes"), mock.patch.object(checker_files, "check_listings"):
        return verdict(files, folder)
