"""Compare a recorded folder with what the tool builds now, for `stt-codegen check`, and record it again (`--accept`).

A difference says whether numbers changed or only text. The C is read back, and compared with the Program that was printed.
Of a folder that differs the hashes of the manifest say whether its task, its files or the tool changed.
"""

from __future__ import annotations

import difflib
import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from stt_codegen.errors import BadInput, SttError
from stt_codegen.files import parse_toml, read_input, read_task_text
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.read import differences as program_differences
from stt_codegen.record.manifest import (
    MANIFEST,
    RecordedFolder,
    build_again,
    folder_of,
    hash_of_inputs,
    read_manifest,
    record,
    recorded_tools,
    remove_folder,
    tool_versions,
)
from stt_codegen.record.number_changes import describe_numbers

SIZE_MARGIN = 1_000_000  # bytes; files that are larger than expected by more are not compared line by line
SIZE_LIMIT = 64_000_000  # bytes; recorded files that are larger count as edited, and are not read
DIFF_LINES = 40  # of one file that are shown; all other lines are counted
SPELLED_OUT = ".task.toml"  # end of the name of a task that was written beside a controller


@dataclass(frozen=True)
class Difference:
    """One file that is missing, extra or changed.

    problem: the end of a sentence that begins with the path. diff: lines of a unified diff. numbers: how its numbers changed.
    """

    path: str
    problem: str
    diff: tuple[str, ...] = ()
    numbers: str = ""


@dataclass(frozen=True, kw_only=True)
class FolderChange:
    """What changed of a folder since it was recorded.

    edited, missing, unreadable: files on disk. task_changed: None where the manifest has no hash of the task. makes_other_files:
    whether the tool makes other files than the recorded ones, for whatever cause.
    """

    folder: str
    task: str
    edited: tuple[str, ...]
    missing: tuple[str, ...]
    unreadable: tuple[str, ...]
    task_changed: bool | None
    makes_other_files: bool

    @property
    def tool_changed(self) -> bool | None:
        """Whether the tool changed; None where the changed task may be the cause."""
        return self.makes_other_files if self.task_changed is False or not self.makes_other_files else None

    def sentence(self, changed_versions: Sequence[str]) -> str:
        """Say in one line what changed. changed_versions: of tools, as in "numpy 1.0 -> 1.1"."""
        causes = [f"{', '.join(self.edited)} edited"] if self.edited else []
        causes += [f"{', '.join(self.missing)} missing"] if self.missing else []
        causes += [f"{', '.join(self.unreadable)} cannot be read"] if self.unreadable else []
        if self.task_changed:
            causes.append(f"its task {self.task} changed")
        if self.tool_changed:
            versions = f" ({', '.join(changed_versions)})" if changed_versions else ", with the versions that are recorded"
            causes.append(f"the tool changed{versions}")
        if self.tool_changed is None and self.task_changed is None:
            causes.append(f"its task {self.task} or the tool changed; the manifest has no hash of the task, --accept adds it")
        return f"{self.folder}: since it was recorded: {'; '.join(causes) or 'only the manifest changed'}"


@dataclass(frozen=True)
class CheckResult:
    """All differences, what changed of each folder that differs, and the tasks beside recorded ones that were never recorded."""

    differences: tuple[Difference, ...]
    changes: tuple[FolderChange, ...]
    unrecorded_tasks: tuple[str, ...]


def check(root: Path, progress: Callable[[str], None] = lambda _: None) -> CheckResult:
    """Build every folder of the manifest in `root` again and compare it with the files there.

    progress: called with each folder's name. The C is also read back, and compared with the Program that was printed.
    """
    differences: list[Difference] = []
    changes: list[FolderChange] = []
    known_paths, entries = {MANIFEST, "lemmas.md"}, read_manifest(root)
    for entry in entries:
        progress(entry.folder)
        try:
            controller = build_again(root, entry)
        except SttError as error:  # the other folders are compared all the same
            differences.append(Difference(entry.folder, f"is not made any more (--accept leaves it as it is): {error}"))
            changes.append(change_of(root, entry, {}))
            known_paths |= {f"{entry.folder}/{name}" for name in entry.sha256}
            continue
        known_paths |= {f"{entry.folder}/{name}" for name in entry.sha256}
        known_paths.add(f"{entry.folder}/{entry.folder.split('/')[0]}.bounds.json")  # `prove` writes it there
        if controller is None:
            problem = f"its task file {entry.task} is gone; --accept drops the folder (if it moved, record it again)"
            differences.append(Difference(entry.folder, problem))
        elif folder_of(controller) != entry.folder:
            problem = f"its task is now called {controller.task.name!r}; --accept moves the folder"
            differences.append(Difference(entry.folder, problem))
        else:
            known_paths |= {f"{entry.folder}/{name}" for name in controller.files}
            of_folder = _compare_folder(root, entry, controller)
            differences += of_folder
            changes += [change_of(root, entry, controller.files)] if of_folder else []
    on_disk = {p.relative_to(root).as_posix() for p in root.rglob("*") if p.is_file()}
    extra = "is not recorded in the manifest; delete it (--accept leaves it alone)"
    differences += [Difference(path, extra) for path in sorted(on_disk - known_paths)]
    return CheckResult(tuple(differences), tuple(changes), tuple(unrecorded_tasks(root, entries)))


def _compare_folder(root: Path, entry: RecordedFolder, controller: EmittedController) -> list[Difference]:
    """Compare the files of one recorded folder with those of its controller, which has been built again."""
    differences = []
    for name in sorted(entry.sha256.keys() - controller.files.keys()):
        differences.append(Difference(MANIFEST, f"records {entry.folder}/{name}, which is not made"))
    for name, data in controller.files.items():
        path = f"{entry.folder}/{name}"
        changes = _compare_file(root, path, data)
        differences += changes
        if not changes and hashlib.sha256(data).hexdigest() != entry.sha256.get(name):
            differences.append(Difference(MANIFEST, f"records another hash of {path} than its content has"))
    prefix = controller.task.name
    header, source = (controller.files[f"{prefix}.{kind}"].decode() for kind in ("h", "c"))
    for line in program_differences(controller.program, header, source):
        differences.append(Difference(f"{entry.folder}/{prefix}.c", f"does not mean what was to be printed: {line}"))
    return differences


def change_of(root: Path, entry: RecordedFolder, files: Mapping[str, bytes]) -> FolderChange:
    """Compare a recorded folder, its task and the files that the tool makes of it now with the hashes of the manifest."""
    on_disk = {name: root / entry.folder / name for name in entry.sha256}
    missing = tuple(name for name, path in on_disk.items() if not path.is_file())
    hashes = {name: _sha256(path) for name, path in on_disk.items() if name not in missing}
    return FolderChange(
        folder=entry.folder,
        task=os.path.normpath(root / entry.task),
        edited=tuple(name for name, digest in hashes.items() if digest not in (None, entry.sha256[name])),
        missing=missing,
        unreadable=tuple(name for name, digest in hashes.items() if digest is None),
        task_changed=_is_task_changed(root, entry),
        makes_other_files={n: hashlib.sha256(data).hexdigest() for n, data in files.items()} != entry.sha256,
    )


def _sha256(path: Path) -> str | None:
    """Return the hash of a file; None where it cannot be read. A file above the bound has none, and is another one."""
    try:
        return hashlib.sha256(read_input(path, SIZE_LIMIT, "")).hexdigest()
    except BadInput:
        return "" if path.stat().st_size > SIZE_LIMIT else None


def _is_task_changed(root: Path, entry: RecordedFolder) -> bool | None:
    """Return whether a task or its maps changed; True where they cannot be read any more, None where no hash is recorded."""
    try:
        return None if entry.inputs_sha256 is None else hash_of_inputs(root / entry.task) != entry.inputs_sha256
    except BadInput:
        return True


def unrecorded_tasks(root: Path, entries: Sequence[RecordedFolder]) -> list[str]:
    """Return the task files that lie beside recorded ones and are not in the manifest."""
    recorded_files = {(root / entry.task).resolve() for entry in entries}
    folders = {path.parent for path in recorded_files}
    files = sorted(file for folder in folders for file in folder.glob("*.toml") if not file.name.endswith(SPELLED_OUT))
    return [os.path.relpath(file) for file in files if file not in recorded_files and _is_task(file)]


def _is_task(path: Path) -> bool:
    """Return whether a file may be meant as a task: it has a state space, or is no TOML that can be read."""
    try:
        return "state_space" in parse_toml(read_task_text(path))
    except BadInput:
        return True


class AcceptedFolders(NamedTuple):
    """How many folders were written and removed (their task file is gone), and why each other one is as it was."""

    written: int
    removed: int
    refusals: tuple[SttError, ...]


def accept(root: Path, progress: Callable[[str], None] = lambda _: None) -> AcceptedFolders:
    """Write every recorded folder as the tool builds it now, and the manifest; remove folders whose task is gone or renamed.

    The folder of a task that is refused stays as it is, with its entry in the manifest.
    """
    controllers, refusals = list[tuple[RecordedFolder, EmittedController | None]](), list[SttError]()
    for entry in read_manifest(root):
        progress(entry.folder)
        try:
            controllers.append((entry, build_again(root, entry)))
        except SttError as error:
            refusals.append(error)
    for entry, controller in controllers:
        if controller is None or folder_of(controller) != entry.folder:
            remove_folder(root, entry.folder)
    written = 0
    for entry, controller in controllers:
        if controller is not None:
            try:
                record(root, root / entry.task, controller, entry.uncertified)
                written += 1
            except SttError as error:
                refusals.append(error)
    gone = sum(controller is None for _, controller in controllers)
    return AcceptedFolders(written, gone, tuple(refusals))


def changed_tools(root: Path) -> list[str]:
    """Return the tools whose version differs from the recorded one, as "name 1.0 -> 1.1"."""
    old, new = recorded_tools(root), tool_versions()
    return [f"{k} {old.get(k, 'none')} -> {v}" for k, v in new.items() if old.get(k) != v]


def folder_count(root: Path) -> int:
    """Return how many folders the manifest records."""
    return len(read_manifest(root))


def _compare_file(root: Path, path: str, expected: bytes) -> list[Difference]:
    """Compare one file with its expected content; the list has one entry or none."""
    file = root / path
    if not file.is_file():
        return [Difference(path, "is missing")]
    if file.stat().st_size > len(expected) + SIZE_MARGIN:
        return [Difference(path, f"differs, and is {file.stat().st_size:,} bytes long instead of {len(expected):,}")]
    try:
        actual = file.read_bytes()
    except OSError as error:
        return [Difference(path, f"cannot be read ({error.strerror}); give yourself the right to, or delete it")]
    if actual == expected:
        return []
    old, new = actual.decode(errors="replace"), expected.decode()
    lines = list(
        difflib.unified_diff(old.splitlines(), new.splitlines(), f"on disk: {path}", f"made now: {path}", lineterm="", n=2)
    )
    if len(lines) > DIFF_LINES:
        lines = [*lines[:DIFF_LINES], f"... and {len(lines) - DIFF_LINES} more lines"]
    diff = tuple(lines) or ("(only line ends or bytes that are no text)",)
    return [Difference(path, "differs", diff, describe_numbers(old, new))]
