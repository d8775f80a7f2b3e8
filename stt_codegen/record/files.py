"""Files written all or none."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from stt_codegen.errors import BadInput


def write_files(folder: Path, files: dict[str, bytes]) -> None:
    """Write all files, each by renaming a finished one over the old: a killed run leaves every old file whole.

    Raises `BadInput` when the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        old = {name: (folder / name).read_bytes() for name in files if (folder / name).exists()}
        finished: dict[str, str] = {}
        replaced: list[str] = []
        try:
            for name, data in files.items():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                handle, finished[name] = tempfile.mkstemp(prefix=f".{Path(name).name}.", dir=(folder / name).parent)
                with os.fdopen(handle, "wb") as file:
                    file.write(data)
                    file.flush()
                    os.fsync(file.fileno())
                os.chmod(finished[name], 0o644)
            for name in files:
                os.replace(finished[name], folder / name)
                replaced.append(name)
        except OSError:
            for name in replaced:  # all new or all old, never a mixture
                (folder / name).write_bytes(old[name]) if name in old else (folder / name).unlink()
            raise
        finally:
            for name, temporary in finished.items():
                if name not in replaced:
                    os.unlink(temporary)
    except OSError as error:
        raise BadInput(f"{folder}: cannot be written ({error.strerror}); choose another folder") from None
