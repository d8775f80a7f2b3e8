"""The record of what was generated from what: MANIFEST.json beside the folders <task>/<design>/<scalar>/.

`record` writes a controller into its folder and notes it; `replay` makes every recorded folder again. Files are
replaced whole or not at all.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import platform
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stt_codegen import __version__
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import Controller, build

MANIFEST = "MANIFEST.json"
FORMAT = 1
TOOLS = ("casadi", "highspy", "jinja2", "numpy")


@dataclass(frozen=True)
class Entry:
    """One recorded folder: where its task file is (relative to the manifest's folder) and with which options."""

    folder: str
    task: str
    design: str
    scalar: str
    uncertified: bool
    sha256: dict[str, str]


def write_files(folder: Path, files: dict[str, bytes]) -> None:
    """Write all files, each by renaming a finished one over the old: a killed run leaves every old file whole.

    Raises `BadInput` when the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        finished: list[tuple[str, Path]] = []
        try:
            for name, data in files.items():
                handle, temporary = tempfile.mkstemp(prefix=f".{name}.", dir=folder)
                finished.append((temporary, folder / name))
                with os.fdopen(handle, "wb") as file:
                    file.write(data)
                os.chmod(temporary, 0o644)
            while finished:
                temporary, target = finished[0]
                os.replace(temporary, target)
                finished.pop(0)
        finally:
            for temporary, _ in finished:
                os.unlink(temporary)
    except OSError as error:
        raise BadInput(f"{folder}: cannot be written ({error.strerror}); choose another --out") from None


def record(root: Path, task_file: Path, controller: Controller, uncertified: bool) -> Path:
    """Write a controller to root/<task>/<design>/<scalar>/ and note it in root/MANIFEST.json. Returns the folder."""
    task = controller.task
    name = f"{task.name}/{controller.design.kind}/{controller.program.scalar}"
    entries = {e.folder: e for e in read_manifest(root)} if (root / MANIFEST).exists() else {}
    entries[name] = Entry(
        folder=name,
        task=Path(os.path.relpath(task_file, root)).as_posix(),
        design=controller.design.kind,
        scalar=controller.program.scalar,
        uncertified=uncertified,
        sha256={file: hashlib.sha256(data).hexdigest() for file, data in controller.files.items()},
    )
    write_files(root / name, controller.files)
    write_files(root, {MANIFEST: _manifest_text(entries)})
    return root / name


def _manifest_text(entries: dict[str, Entry]) -> bytes:
    folders = {}
    for name in sorted(entries):
        entry = entries[name]
        options: dict[str, Any] = {"design": entry.design, "scalar": entry.scalar}
        if entry.uncertified:
            options["uncertified"] = True
        folders[name] = {"task": entry.task, "options": options, "sha256": dict(sorted(entry.sha256.items()))}
    document = {"format": FORMAT, "tools": tool_versions(), "folders": folders}
    return (json.dumps(document, indent=2) + "\n").encode()


def tool_versions() -> dict[str, str]:
    """Versions that could matter to the output; reported when they differ, never compared."""
    versions = {name: importlib.metadata.version(name) for name in TOOLS}
    return {"stt_codegen": __version__, "python": platform.python_version(), **versions}


def read_manifest(root: Path) -> list[Entry]:
    """The recorded folders. Raises `BadInput` when there is no readable manifest."""
    path = root / MANIFEST
    try:
        document = json.loads(path.read_bytes())
        return [
            Entry(
                folder=str(folder),
                task=str(data["task"]),
                design=str(data["options"]["design"]),
                scalar=str(data["options"]["scalar"]),
                uncertified=bool(data["options"].get("uncertified", False)),
                sha256={str(k): str(v) for k, v in data["sha256"].items()},
            )
            for folder, data in document["folders"].items()
        ]
    except OSError as error:
        raise BadInput(
            f"{path}: cannot be read ({error.strerror}); make one with: stt-codegen generate TASK --record {root}"
        ) from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise BadInput(f"{path}: is not a manifest of this tool; delete it and record the tasks again") from None


def recorded_tools(root: Path) -> dict[str, str]:
    """The tool versions that the manifest names."""
    tools = json.loads((root / MANIFEST).read_bytes()).get("tools", {})
    return {str(k): str(v) for k, v in tools.items()}


def replay(root: Path, progress: Callable[[str], None] = lambda _: None) -> Iterator[tuple[Entry, Controller]]:
    """Make every recorded folder again, from its task file and options."""
    for entry in read_manifest(root):
        progress(entry.folder)
        yield entry, build(root / entry.task, entry.design, entry.scalar, entry.uncertified)
