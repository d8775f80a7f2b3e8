"""Is what lies on disk what the tool writes? Compares both ways, and says whether numbers changed or only text; and reads the
C back, to show that it means the Program that was printed."""

from __future__ import annotations

import difflib
import hashlib
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from stt_codegen.program.read import differences
from stt_codegen.record.manifest import MANIFEST, folder_of, forget, make, read_manifest, record, recorded_tools, tool_versions

DIFF_LINES = 40  # of one file; the rest is counted
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?F?\b")
_HASH = re.compile(r'"[0-9a-f]{16}"|"[0-9a-f]{64}"')
_STARTS = re.compile(r"_start_(?:lower|upper)\[\d+\][^;]*;")
_TABLE = re.compile(r"_coefficients\[\d+\] = \{(.*?)\};", re.DOTALL)


@dataclass(frozen=True)
class Difference:
    """One file that is missing, extra or other than the tool writes it."""

    path: str
    what: str
    diff: tuple[str, ...] = ()
    numbers: str = ""


def check(root: Path, progress: Callable[[str], None] = lambda _: None) -> list[Difference]:
    """Replay the manifest in `root` and compare with the files there; empty when nothing differs."""
    found: list[Difference] = []
    known = {MANIFEST}
    for entry in read_manifest(root):
        progress(entry.folder)
        controller = make(root, entry)
        known |= {f"{entry.folder}/{name}" for name in entry.sha256}
        if controller is None:
            found.append(
                Difference(
                    entry.folder, f"its task file {entry.task} is gone; --accept drops the folder (if it moved, record it again)"
                )
            )
            continue
        if folder_of(controller) != entry.folder:
            found.append(Difference(entry.folder, f"its task is now called {controller.task.name!r}; --accept moves the folder"))
            continue
        for name in sorted(entry.sha256.keys() - controller.files.keys()):
            found.append(Difference(MANIFEST, f"records {entry.folder}/{name}, which is not made"))
        for name, data in controller.files.items():
            path = f"{entry.folder}/{name}"
            known.add(path)
            changes = _compare(root, path, data)
            found += changes
            if not changes and hashlib.sha256(data).hexdigest() != entry.sha256.get(name):
                found.append(Difference(MANIFEST, f"records another hash of {path} than its content has"))
        prefix = controller.task.name
        texts = (controller.files[f"{prefix}.{kind}"].decode() for kind in ("h", "c"))
        for line in differences(controller.program, *texts):
            found.append(Difference(f"{entry.folder}/{prefix}.c", f"does not mean what was to be printed: {line}"))
    on_disk = {p.relative_to(root).as_posix() for p in root.rglob("*") if p.is_file()}
    extra = "is not recorded in the manifest; delete it (--accept leaves it alone)"
    beside = {"lemmas.md"} | {f"{e.folder}/{e.folder.split('/')[0]}.bounds.json" for e in read_manifest(root)}
    found += [Difference(path, extra) for path in sorted(on_disk - known - beside)]
    return found


def accept(root: Path, progress: Callable[[str], None] = lambda _: None) -> tuple[int, int]:
    """Write every recorded folder as the tool makes it now, and the manifest; folders whose task is gone or renamed are
    removed. Returns how many folders were written, and how many dropped because their task file is gone."""
    made = []
    for entry in read_manifest(root):
        progress(entry.folder)
        made.append((entry, make(root, entry)))
    for entry, controller in made:
        if controller is None or folder_of(controller) != entry.folder:
            forget(root, entry.folder)
    for entry, controller in made:
        if controller is not None:
            record(root, root / entry.task, controller, entry.uncertified)
    written = sum(controller is not None for _, controller in made)
    return written, len(made) - written


def changed_tools(root: Path) -> list[str]:
    """Tools whose version differs from the recorded one, as "name 1.0 -> 1.1"."""
    old, new = recorded_tools(root), tool_versions()
    return [f"{k} {old.get(k, 'none')} -> {v}" for k, v in new.items() if old.get(k) != v]


def folders(root: Path) -> int:
    """How many folders the manifest records."""
    return len(read_manifest(root))


def _compare(root: Path, path: str, expected: bytes) -> list[Difference]:
    file = root / path
    if not file.is_file():
        return [Difference(path, "is missing")]
    actual = file.read_bytes()
    if actual == expected:
        return []
    old, new = actual.decode(errors="replace"), expected.decode()
    lines = list(
        difflib.unified_diff(old.splitlines(), new.splitlines(), f"on disk: {path}", f"made now: {path}", lineterm="", n=2)
    )
    if len(lines) > DIFF_LINES:
        lines = [*lines[:DIFF_LINES], f"... and {len(lines) - DIFF_LINES} more lines"]
    return [
        Difference(path, "differs", tuple(lines) or ("(only line ends or bytes that are no text)",), describe_numbers(old, new))
    ]


def describe_numbers(old: str, new: str) -> str:
    """What a reviewer wants to know of two texts of one file: did numbers change, how many, by how much."""
    old, new = (_HASH.sub("", text) for text in (old, new))  # hashes follow from the rest
    before, after = _NUMBER.findall(old), _NUMBER.findall(new)
    if _NUMBER.sub("#", old) != _NUMBER.sub("#", new):
        if before == after:
            return "the text changed, no number did"
        return f"the structure changed ({len(before)} numbers before, {len(after)} now); compare it as new"
    pairs = [(float(a.rstrip("F")), float(b.rstrip("F"))) for a, b in zip(before, after, strict=True)]
    changed = [(a, b) for a, b in pairs if a != b]
    if not changed:
        return "no number changed"
    a, b = max(changed, key=lambda p: abs(p[0] - p[1]) / max(abs(p[0]), abs(p[1])))
    share = abs(a - b) / max(abs(a), abs(b))
    text = f"{len(changed)} of {len(pairs)} numbers changed, the largest relative change is {share:.3g} ({a!r} -> {b!r})"
    moved = _edge_movement(old, new)
    return text if moved is None else f"{text}; the tube's edges move by at most {moved:.3g}"


def _edge_movement(old: str, new: str) -> float | None:
    """Bound on the movement of the tube between two C files that differ in coefficients alone, and in the bounds of starts, which
    follow from them: the weights are >= 0 and sum to 6. None where anything else changed, the time scale for one."""
    tables = [_TABLE.search(text) for text in (old, new)]
    rest = [_STARTS.sub("", _TABLE.sub("", text)) for text in (old, new)]
    if not all(tables) or rest[0] != rest[1]:
        return None
    before, after = ([float(v.rstrip("F")) for v in _NUMBER.findall(t.group(1))] for t in tables if t)
    return 6 * max(abs(a - b) for a, b in zip(before, after, strict=True))
