"""What stands where files are to be written: a certified set is replaced by itself, made anew and certified, or not at all.

A certificate has the hashes of its files. They lie beside it, or, in a package, in ../src; a unit of FMI has its certificate
within.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from stt_codegen.errors import BadInput
from stt_codegen.record.files import SEAL
from stt_codegen.task.map import input_files

UNIT = ".fmu"


def keep_apart(names: Sequence[str], sets: Sequence[Mapping[str, bytes]]) -> None:
    """Refuse tasks whose files would overwrite each other, also where a file system knows no upper case. sets: files by path, of
    each task. Raises `BadInput`."""
    owners: dict[str, int] = {}
    for k, files in enumerate(sets):
        for path in files:
            first = owners.setdefault(path.lower(), k)
            if first != k:
                raise BadInput(
                    f"the tasks {names[first]!r} and {names[k]!r} would both write {path}; "
                    "give them other names, or another --out"
                )


def keep_inputs(paths: Sequence[Path], tasks: Sequence[Path]) -> None:
    """Refuse to write over a task file, a map of it or the map's image, or over Python beside a task that is no emitted
    controller, such as its plant. Raises `BadInput`."""
    behind = {file.resolve() for task in tasks for file in input_files(task)}
    beside = {task.resolve().parent for task in tasks}
    for path in paths:
        if path.resolve() in behind:
            raise BadInput(f"{path}: is what the task is read from; write to another folder or name")
        if path.suffix == ".py" and path.resolve().parent in beside and path.exists() and b"DESIGN_HASH" not in path.read_bytes():
            raise BadInput(f"{path}: is no emitted controller, perhaps a plant; write to another --out")


def keep_certified(folder: Path, files: Mapping[str, bytes]) -> None:
    """Refuse to write `files` where that would replace a file of a certified set by one that is not of its new certificate, or
    leave a file of an older set beside a new certificate. Raises `BadInput`."""
    for path, data in files.items():
        for seal, old in _certified_over(folder, path):
            new = _units_seal(data) if path.endswith(UNIT) else _document(files.get(seal, b""))
            if old.get("task") != new.get("task") or new.get("certified") is not True:
                raise BadInput(
                    f"{folder}: holds a certified {old.get('task')!r} ({seal}), of which {path} is; write this to another --out"
                )
    for seal in (path for path in files if path.endswith(SEAL)):
        for name, digest in _document(files[seal]).get("sha256", {}).items():
            for path in _paths(seal, name):
                with suppress(OSError):
                    if path not in files and hashlib.sha256((folder / path).read_bytes()).hexdigest() != digest:
                        raise BadInput(
                            f"{folder / path}: is of another design than the new {seal}, and would stay beside it; "
                            "remove it, or write to another --out"
                        )


def _certified_over(folder: Path, path: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Certified certificates, with their paths, that the file at `path` belongs to as it stands now."""
    here = folder / path
    if path.endswith(UNIT):
        with suppress(OSError):
            found = _units_seal(here.read_bytes())
            if found.get("certified") is True:
                yield path, found
        return
    for place in (".", "../extras"):
        for seal in sorted((here.parent / place).glob(f"*{SEAL}")) if here.exists() else ():
            with suppress(OSError):
                document, relative = _document(seal.read_bytes()), Path(os.path.relpath(seal, folder)).as_posix()
                if document.get("certified") is True and (seal.name == here.name or here.name in document.get("sha256", {})):
                    yield relative, document


def _paths(seal: str, name: str) -> Iterator[str]:
    """Where the file `name` of a certificate may lie, as paths like the certificate's."""
    parent = Path(seal).parent
    yield (parent / name).as_posix()
    if parent.name == "extras":
        yield (parent.parent / "src" / name).as_posix()


def _document(data: bytes) -> dict[str, Any]:
    """A certificate, or nothing where that is none."""
    with suppress(ValueError):
        found = json.loads(data)
        if isinstance(found, dict):
            return found
    return {}


def _units_seal(data: bytes) -> dict[str, Any]:
    """The certificate in a unit of FMI, or nothing where it has none."""
    with suppress(OSError, KeyError, zipfile.BadZipFile), zipfile.ZipFile(io.BytesIO(data)) as unit:
        for name in unit.namelist():
            if name.startswith("resources/") and name.endswith(SEAL):
                return _document(unit.read(name))
    return {}
