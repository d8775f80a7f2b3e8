"""Files written as one set. A certificate is removed first and written last, so a folder that has one has its whole set."""

from __future__ import annotations

import os
import re
import tempfile
from pathlib import Path

from stt_codegen.errors import BadInput

SEAL = ".certificate.json"  # its end; it has the hashes of the others
UNFINISHED = re.compile(r"\..+\.(\d+)\.unfinished")  # of a file, by the process that writes it


def write_files(folder: Path, files: dict[str, bytes]) -> None:
    """Write all files, each by renaming a finished one over the old. A killed run leaves every file whole; if it is killed
    between two renames the folder has no certificate, so that nothing vouches for the mixture. What killed runs left is swept.

    Raises `BadInput` when the folder cannot be written.
    """
    names = sorted(files, key=lambda name: name.endswith(SEAL))
    seals = [name for name in names if name.endswith(SEAL)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        old = {name: (folder / name).read_bytes() for name in names if (folder / name).exists()}
        finished: dict[str, Path] = {}
        replaced: list[str] = []
        gone: list[str] = []
        try:
            for name in names:
                path = folder / name
                path.parent.mkdir(parents=True, exist_ok=True)
                _sweep(path.parent)
                handle, temporary = tempfile.mkstemp(f".{os.getpid()}.unfinished", f".{path.name}.", path.parent)
                finished[name] = Path(temporary)
                with os.fdopen(handle, "wb") as file:
                    file.write(files[name])
                    file.flush()
                    os.fsync(file.fileno())
                finished[name].chmod(0o644)
            if len(names) > 1:  # a certificate alone replaces itself in one rename
                for name in seals:
                    (folder / name).unlink(missing_ok=True)
                    gone.append(name)
            for name in names:
                os.replace(finished[name], folder / name)
                replaced.append(name)
        except OSError:
            for name in dict.fromkeys([*replaced, *gone]):  # all new or all old, never a mixture
                (folder / name).write_bytes(old[name]) if name in old else (folder / name).unlink(missing_ok=True)
            raise
        finally:
            for name, path in finished.items():
                if name not in replaced:
                    path.unlink(missing_ok=True)
    except OSError as error:
        raise BadInput(f"{folder}: cannot be written ({error.strerror}); choose another folder") from None


def _sweep(folder: Path) -> None:
    """Remove what runs left that are no more."""
    for path in folder.glob(".*.unfinished"):
        match = UNFINISHED.fullmatch(path.name)
        if match and not _runs(int(match[1])):
            path.unlink(missing_ok=True)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
