"""Write files as one set. A certificate is removed first and written last, so a folder that has one has its whole set.

All commands that write files call `write_files`.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from stt_codegen.errors import BadInput

CERTIFICATE_SUFFIX = ".certificate.json"  # such a file has the hashes of the set's other files
UNFINISHED = re.compile(r"\..+\.(\d+)\.unfinished")  # name of a file that a process, whose number it has, is writing


def write_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write all files by renaming finished ones over the old. files: contents by path within the folder.

    After an error all files are old. If the process is killed, each file is whole, but some may be new; then the folder has no
    certificate that could vouch for the mixture. Raises `BadInput` when the folder cannot be written, or where a file is not the
    one that a certificate among them is about.
    """
    require_certified_contents(files)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _replace_files(folder, files)
    except OSError as error:
        raise BadInput(f"{folder}: cannot be written ({error.strerror}); choose another folder") from None


def require_certified_contents(files: Mapping[str, bytes]) -> None:
    """Raise `BadInput` where a certificate among the files has another hash of one of them."""
    for certificate in (path for path in files if path.endswith(CERTIFICATE_SUFFIX)):
        for name, digest in json_object(files[certificate]).get("sha256", {}).items():
            for path in possible_paths(certificate, name):
                if path in files and hashlib.sha256(files[path]).hexdigest() != digest:
                    raise BadInput(
                        f"{path}: is not what {certificate} is about; write the files as they were emitted, or without the "
                        "certificate"
                    )


def possible_paths(certificate: str, name: str) -> Iterator[str]:
    """Yield where the file `name` of a certificate may lie, relative to the same folder as the certificate's path."""
    parent = Path(certificate).parent
    yield (parent / name).as_posix()
    if parent.name == "extras":
        yield (parent.parent / "src" / name).as_posix()


def json_object(data: bytes) -> dict[str, Any]:
    """Return the JSON object, such as a certificate; empty where the data is none."""
    with suppress(ValueError):
        document = json.loads(data)
        if isinstance(document, dict):
            return document
    return {}


def _replace_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Replace all files, certificates last; after an `OSError` write the old ones again."""
    names = sorted(files, key=lambda name: name.endswith(CERTIFICATE_SUFFIX))
    certificates = [name for name in names if name.endswith(CERTIFICATE_SUFFIX)]
    old = {name: (folder / name).read_bytes() for name in names if (folder / name).exists()}
    finished: dict[str, Path] = {}
    replaced: list[str] = []
    removed: list[str] = []
    try:
        for name in names:
            _write_unfinished(folder, name, files[name], finished)
        if len(names) > 1:  # a certificate alone replaces itself in one rename
            for name in certificates:
                (folder / name).unlink(missing_ok=True)
                removed.append(name)
        for name in names:
            os.replace(finished[name], folder / name)
            replaced.append(name)
    except OSError:
        for name in dict.fromkeys([*replaced, *removed]):
            (folder / name).write_bytes(old[name]) if name in old else (folder / name).unlink(missing_ok=True)
        raise
    finally:
        for name, path in finished.items():
            if name not in replaced:
                path.unlink(missing_ok=True)


def _write_unfinished(folder: Path, name: str, data: bytes, finished: dict[str, Path]) -> None:
    """Write a file beside its destination; enter its path in `finished` before the first byte, so that errors leave no file."""
    destination = folder / name
    destination.parent.mkdir(parents=True, exist_ok=True)
    _remove_abandoned(destination.parent)
    handle, temporary = tempfile.mkstemp(f".{os.getpid()}.unfinished", f".{destination.name}.", destination.parent)
    finished[name] = Path(temporary)
    with os.fdopen(handle, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    finished[name].chmod(0o644)


def _remove_abandoned(folder: Path) -> None:
    """Remove unfinished files of processes that no longer run."""
    for path in folder.glob(".*.unfinished"):
        match = UNFINISHED.fullmatch(path.name)
        if match and not _is_running(int(match[1])):
            path.unlink(missing_ok=True)


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
