"""Refuse to overwrite what must stay: inputs of tasks, plants, and files of another certified set.

A certified set may be replaced by itself, generated again and certified. A certificate has the hashes of its files. These lie
beside it, or, in a package, in ../src; a unit of FMI has its certificate inside. `generate`, `design` and `report` call this.
"""

from __future__ import annotations

import hashlib
import io
import os
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from stt_codegen.errors import BadInput
from stt_codegen.files import CERTIFICATE_SUFFIX, hashes_in, parse_certificate, possible_paths, read_certificate, read_input
from stt_codegen.task.map import input_files

UNIT_SUFFIX = ".fmu"
SIZE_LIMIT = 64_000_000  # bytes of a file that is read here


def require_distinct_paths(names: Sequence[str], file_sets: Sequence[Mapping[str, bytes]]) -> None:
    """Raise `BadInput` where two tasks would write one file, also on a file system that ignores case.

    file_sets: for each task of `names` its files by path.
    """
    owners: dict[str, int] = {}
    for k, files in enumerate(file_sets):
        for path in files:
            first = owners.setdefault(path.lower(), k)
            if first != k:
                raise BadInput(
                    f"the tasks {names[first]!r} and {names[k]!r} would both write {path}; "
                    "give them other names, or another --out"
                )


def refuse_to_overwrite_inputs(paths: Sequence[Path], tasks: Sequence[Path]) -> None:
    """Raise `BadInput` where a path is a task file, its map or the map's image, or Python beside a task, such as its plant.

    Python that was emitted may be overwritten.
    """
    inputs = {file.resolve() for task in tasks for file in input_files(task)}
    task_folders = {task.resolve().parent for task in tasks}
    for path in paths:
        if path.resolve() in inputs:
            raise BadInput(f"{path}: is what the task is read from; write to another folder or name")
        is_python_beside = path.suffix == ".py" and path.resolve().parent in task_folders and path.exists()
        if is_python_beside and b"DESIGN_HASH" not in read_input(path, SIZE_LIMIT, "write to another --out"):
            raise BadInput(f"{path}: is no emitted controller, perhaps a plant; write to another --out")


def refuse_to_overwrite_certified(folder: Path, files: Mapping[str, bytes]) -> None:
    """Raise `BadInput` where writing `files` into `folder` would mix two certified sets.

    A file of a certified set may only be replaced with its certificate, by a certified set of the same task. And no file of an
    older set may stay beside a new certificate that names it.
    """
    for path, data in files.items():
        for certificate, old in _certificates_with(folder, path):
            new = _unit_certificate(data) if path.endswith(UNIT_SUFFIX) else parse_certificate(files.get(certificate, b""))
            if old.get("task") != new.get("task") or new.get("certified") is not True:
                raise BadInput(
                    f"{folder}: holds a certified {old.get('task')!r} ({certificate}), of which {path} is; "
                    "write this to another --out"
                )
    for certificate in (path for path in files if path.endswith(CERTIFICATE_SUFFIX)):
        for name, digest in hashes_in(parse_certificate(files[certificate])).items():
            for path in possible_paths(certificate, name):
                if path not in files and (folder / path).is_file():
                    data = read_input(folder / path, SIZE_LIMIT, "remove it, or write to another --out")
                    if hashlib.sha256(data).hexdigest() != digest:
                        raise BadInput(
                            f"{folder / path}: is of another design than the new {certificate}, and would stay beside it; "
                            "remove it, or write to another --out"
                        )


def _certificates_with(folder: Path, path: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the certificates, with their paths, of the certified sets that the file now at `path` belongs to."""
    file = folder / path
    if path.endswith(UNIT_SUFFIX):
        certificate = _unit_certificate(_content(file))
        if certificate.get("certified") is True:
            yield path, certificate
        return
    for relative_folder in (".", "../extras"):
        for candidate in sorted((file.parent / relative_folder).glob(f"*{CERTIFICATE_SUFFIX}")) if file.exists() else ():
            certificate = read_certificate(candidate)
            has_file = candidate.name == file.name or file.name in hashes_in(certificate)
            if certificate.get("certified") is True and has_file:
                yield Path(os.path.relpath(candidate, folder)).as_posix(), certificate


def _content(path: Path) -> bytes:
    """Return the content of a file, empty where it is missing, larger than any that this package writes, or no file."""
    with suppress(BadInput):
        return read_input(path, SIZE_LIMIT, "") if path.is_file() else b""
    return b""


def _unit_certificate(data: bytes) -> dict[str, Any]:
    """Return the certificate inside a unit of FMI, empty where it has none."""
    damages = (OSError, KeyError, ValueError, NotImplementedError, RuntimeError, EOFError, zipfile.BadZipFile, zlib.error)
    with suppress(*damages), zipfile.ZipFile(io.BytesIO(data)) as unit:
        for name in unit.namelist():
            if name.startswith("resources/") and name.endswith(CERTIFICATE_SUFFIX):
                with unit.open(name) as file:  # a packed file may be a thousand times larger
                    return parse_certificate(file.read(SIZE_LIMIT))
    return {}
