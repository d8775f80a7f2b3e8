"""The record of which folder was generated from which task: MANIFEST.json beside the folders <task>/<design>/<scalar>/.

`record` writes a controller into its folder and the manifest; `build_again` builds a recorded controller from its task file.
record/check.py compares the two.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import platform
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Any, get_args

from stt_codegen import __version__
from stt_codegen.design_kinds import DesignKind
from stt_codegen.effort import Effort
from stt_codegen.errors import BadInput, about
from stt_codegen.files import CERTIFICATE_SUFFIX, locked, parse_json_object, parse_toml, read_input, read_task_text, write_files
from stt_codegen.pipeline import EmittedController, build
from stt_codegen.task.map import IMAGE_SIZE_LIMIT, input_files

MANIFEST = "MANIFEST.json"
MANIFEST_FORMAT = 1
SEARCH_SECONDS = 600.0  # for the tube of a recorded task, which may have been found with a longer --effort on a quicker machine
SIZE_LIMIT = 16_000_000  # bytes of a manifest; a folder takes about a kilobyte
TOOLS = ("casadi", "highspy", "jinja2", "numpy")


@dataclass(frozen=True)
class RecordedFolder:
    """One recorded folder, its task file and its options. Paths are relative to the manifest's folder.

    sha256: by file name. inputs_sha256: of what the task is read from (`hash_of_inputs`); None in a manifest of an older version.
    """

    folder: str
    task: str
    design: str
    scalar: str
    uncertified: bool
    _: KW_ONLY
    sha256: dict[str, str]
    inputs_sha256: str | None = None


def record(root: Path, task_file: Path, controller: EmittedController, uncertified: bool) -> Path:
    """Write a controller to root/<task>/<design>/<scalar>/ and enter it in root/MANIFEST.json. Returns the folder.

    Raises `BadInput` where another task file of this name is recorded.
    """
    with locked([root]):
        return _record(root, task_file, controller, uncertified)


def _record(root: Path, task_file: Path, controller: EmittedController, uncertified: bool) -> Path:
    """Record a controller, as `record` does, while no one else writes the manifest."""
    task = controller.task
    name = folder_of(controller)
    entries = {e.folder: e for e in read_manifest(root)} if (root / MANIFEST).exists() else {}
    source = Path(os.path.relpath(task_file, root)).as_posix()
    for entry in entries.values():
        if entry.folder.split("/")[0].lower() == task.name.lower() and entry.task != source:
            raise BadInput(f"{task_file}: the name {task.name!r} is recorded for {entry.task} already; choose another name")
    entries[name] = RecordedFolder(
        folder=name,
        task=source,
        design=controller.design.kind,
        scalar=controller.program.scalar,
        uncertified=uncertified,
        sha256={file: hashlib.sha256(data).hexdigest() for file, data in controller.files.items()},
        inputs_sha256=hash_of_inputs(task_file),
    )
    write_files(root / name, controller.files)
    write_files(root, {MANIFEST: _manifest_text(entries)})
    return root / name


def hash_of_inputs(task_file: Path) -> str:
    """Return the SHA-256 of what a task is read from: the data of its file, without comments and layout, and its maps.

    No code of the tool changes it, so it is the same for every version of the tool. Raises `BadInput` where one of them cannot be
    read.
    """
    text = read_task_text(task_file)
    with about(task_file):
        document = parse_toml(text)
    digest = hashlib.sha256(json.dumps(document, sort_keys=True, default=str).encode())
    for file in input_files(task_file)[1:]:
        data = read_input(file, IMAGE_SIZE_LIMIT, f"{task_file} is read from it")
        digest.update(hashlib.sha256(data).digest())
    return digest.hexdigest()


def _manifest_text(entries: dict[str, RecordedFolder]) -> bytes:
    """Return MANIFEST.json with the recorded folders, which are given by name."""
    folders = {}
    for name in sorted(entries):
        entry = entries[name]
        options: dict[str, Any] = {"design": entry.design, "scalar": entry.scalar}
        if entry.uncertified:
            options["uncertified"] = True
        inputs = {} if entry.inputs_sha256 is None else {"inputs_sha256": entry.inputs_sha256}
        folders[name] = {"task": entry.task, **inputs, "options": options, "sha256": dict(sorted(entry.sha256.items()))}
    document = {"format": MANIFEST_FORMAT, "tools": tool_versions(), "folders": folders}
    return (json.dumps(document, indent=2) + "\n").encode()


def tool_versions() -> dict[str, str]:
    """Return the versions of tools that could change the output. `check` prints changed ones; they are no difference."""
    versions = {name: importlib.metadata.version(name) for name in TOOLS}
    return {"stt_codegen": __version__, "python": platform.python_version(), **versions}


def read_manifest(root: Path) -> list[RecordedFolder]:
    """Return the recorded folders. Raises `BadInput` when there is no readable manifest."""
    path = root / MANIFEST
    if root.is_file():
        raise BadInput(f"{root}: is a file; give the folder that holds {MANIFEST}")
    try:
        document = parse_json_object(read_input(path, SIZE_LIMIT, f"make one with: stt-codegen generate TASK --record {root}"))
        if document["format"] != MANIFEST_FORMAT:
            problem = f"has format {document['format']!r:.20}, this version writes {MANIFEST_FORMAT}"
            raise BadInput(f"{path}: {problem}; record the tasks again")
        entries = [
            RecordedFolder(
                folder=str(folder),
                task=str(data["task"]),
                design=str(data["options"]["design"]),
                scalar=str(data["options"]["scalar"]),
                uncertified=bool(data["options"].get("uncertified", False)),
                sha256={str(k): str(v) for k, v in data["sha256"].items()},
                inputs_sha256=None if data.get("inputs_sha256") is None else str(data["inputs_sha256"]),
            )
            for folder, data in document["folders"].items()
        ]
    except (ValueError, KeyError, TypeError, AttributeError):
        raise BadInput(f"{path}: is not a manifest of this tool; delete it and record the tasks again") from None
    for entry in entries:  # `--accept` removes files by these names
        if entry.design not in get_args(DesignKind) or entry.scalar not in ("float", "double", "fixed"):
            problem = f"has the design {entry.design!r:.20} in {entry.scalar!r:.20} for {entry.folder!r:.60}"
            raise BadInput(f"{path}: {problem}, which this tool does not make; record the tasks again")
        if "\0" in entry.task:
            raise BadInput(f"{path}: has the task {entry.task!r:.60}, which is no path; record the tasks again")
        for name in (entry.folder, *entry.sha256):
            if Path(name).is_absolute() or ".." in Path(name).parts or not Path(name).parts or "\0" in name:
                raise BadInput(f"{path}: has the path {name!r:.60}, which leaves its folder; record the tasks again")
    return entries


def recorded_tools(root: Path) -> dict[str, str]:
    """Return the tool versions that the manifest names."""
    tools = parse_json_object(read_input(root / MANIFEST, SIZE_LIMIT, "record the tasks again")).get("tools")
    return {str(k): str(v) for k, v in tools.items()} if isinstance(tools, dict) else {}


def remove_folder(root: Path, folder: str) -> None:
    """Remove a recorded folder from the manifest, and its recorded files, certificates first; other files in it stay."""
    with locked([root]):
        entries = {e.folder: e for e in read_manifest(root)}
        recorded_files = entries.pop(folder).sha256 if folder in entries else {}
        if (root / folder).is_dir():
            with locked([root / folder]):
                for name in sorted(recorded_files, key=lambda name: not name.endswith(CERTIFICATE_SUFFIX)):
                    (root / folder / name).unlink(missing_ok=True)
        for path in (root / folder, *(root / folder).parents):
            if path == root or not path.is_dir() or any(path.iterdir()):
                break
            with suppress(OSError):  # another command writes into it at this moment
                path.rmdir()
        write_files(root, {MANIFEST: _manifest_text(entries)})


def build_again(root: Path, entry: RecordedFolder) -> EmittedController | None:
    """Build a recorded controller from its task file and options; None when its task file is gone."""
    if not (root / entry.task).exists():
        return None
    with about(f"{root / MANIFEST}: {entry.folder}"):
        return build(root / entry.task, entry.design, entry.scalar, entry.uncertified, effort=Effort(SEARCH_SECONDS))


def folder_of(controller: EmittedController) -> str:
    """Return the folder that a controller is recorded in, relative to the manifest's folder."""
    return f"{controller.task.name}/{controller.design.kind}/{controller.program.scalar}"
