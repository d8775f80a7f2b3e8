"""Write files as one set. A certificate is removed first and written last, so a folder that has one has its whole set.

All commands that write files call `write_files`.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from stt_codegen.errors import BadInput
from stt_codegen.files.certified_contents import (
    CERTIFICATE_SUFFIX,
    require_certificates_that_stay_to_fit,
    require_certified_contents,
)
from stt_codegen.files.locks import locked

UNFINISHED_SUFFIX = ".unfinished"  # of a file that is being written; its name begins with a dot


def write_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write all files by renaming finished ones over the old. files: contents by path within the folder.

    One writer at a time: others wait. After an error all files are old. If the process is killed, each file is whole, but some
    may be new; then the folder has no certificate that could vouch for the mixture. Raises `BadInput` when the folder cannot be
    written, another writer does not end, or a file is not the one that a certificate is about, which is among them
    or stays in the folder.
    """
    require_certified_contents(files)
    with locked({folder, *((folder / name).parent for name in files)}):
        require_certificates_that_stay_to_fit(folder, files)
        try:
            _replace_files(folder, files)
        except OSError as error:
            raise BadInput(f"{folder}: cannot be written ({error.strerror}); choose another folder") from None


def _replace_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Replace all files, certificates last; after an `OSError` write the old ones again."""
    names = sorted(files, key=lambda name: name.endswith(CERTIFICATE_SUFFIX))
    certificates = [name for name in names if name.endswith(CERTIFICATE_SUFFIX)]
    _remove_abandoned({(folder / name).parent for name in names})
    old = _old_contents(folder, names)
    finished: dict[str, Path] = {}
    replaced: list[str] = []
    removed: list[str] = []
    try:
        for name in names:
            _write_unfinished(folder / name, files[name], name, finished)
        if len(names) > 1:  # a certificate alone replaces itself in one rename
            for name in certificates:
                (folder / name).unlink(missing_ok=True)
                removed.append(name)
        for name in names:
            os.replace(finished[name], folder / name)
            replaced.append(name)
    except OSError:
        for name in dict.fromkeys([*replaced, *removed]):
            if name in old:
                (folder / name).write_bytes(old[name])
            else:
                (folder / name).unlink(missing_ok=True)
        raise
    finally:
        for name, path in finished.items():
            if name not in replaced:
                path.unlink(missing_ok=True)


def _old_contents(folder: Path, names: list[str]) -> dict[str, bytes]:
    """Return the contents of the files that are replaced. Raises `BadInput` where one is a folder, a pipe or a device."""
    old = {}
    for name in names:
        path = folder / name
        if path.is_file():
            try:
                old[name] = path.read_bytes()
            except OSError as error:
                raise BadInput(f"{path}: cannot be read ({error.strerror}), so it is not replaced; remove it") from None
        elif path.exists():
            raise BadInput(f"{path}: is no file, and is not replaced; remove it, or choose another folder")
    return old


def _write_unfinished(destination: Path, data: bytes, name: str, finished: dict[str, Path]) -> None:
    """Write a file beside its destination; enter its path in `finished` before the first byte, so that errors leave no file."""
    handle, temporary = tempfile.mkstemp(UNFINISHED_SUFFIX, f".{destination.name}.", destination.parent)
    finished[name] = Path(temporary)
    with os.fdopen(handle, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    finished[name].chmod(0o644)


def _remove_abandoned(folders: set[Path]) -> None:
    """Remove unfinished files: this process has the lock of their folders, so nobody else is writing them."""
    for folder in folders:
        for path in folder.glob(f".*{UNFINISHED_SUFFIX}"):
            path.unlink(missing_ok=True)
