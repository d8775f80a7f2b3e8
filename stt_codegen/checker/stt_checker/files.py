"""The files beside the certificate: their hashes, and that the C, the header and the small files are the listings."""

import hashlib
import json
from pathlib import Path
from typing import Any

from . import source
from .bounds import BESIDE_BYTES, SOURCE_BYTES, read_bounded
from .exact import require
from .law import Law
from .task import Task

OTHER_LANGUAGES = (".rs",)  # files of which nothing is known but their hash


def files_of(task: Task, hashes: dict[str, str]) -> tuple[dict[str, str], set[str]]:
    """Return the C files by the name of their listing, and the C files of which nothing is known but their hash."""
    name, has_phase = task.name, "mission" in task.document and f"{task.name}_phase.c" in hashes
    small = {"guard": task.outside != "return", "wrap": task.repeats, "unwrap": bool(task.turns)}
    files = {"controller": f"{name}.c", "header": f"{name}.h"} | {
        k: f"{name}_{k}.c" for k, is_present in small.items() if is_present
    }
    return files, {f"{name}_{k}.c" for k, v in {"selftest": task.selftest, "phase": has_phase}.items() if v}


def check_hashes(task: Task, hashes: dict[str, str], text: bytes, folder: Path) -> None:
    """Require that every file has the certificate's hash; of those that are not there nothing is said."""
    listed, beside = files_of(task, hashes)
    languages = {f for f in hashes if f.removeprefix(task.name) in OTHER_LANGUAGES}
    known = {"task_data", f"{task.name}.py", *listed.values(), *beside}
    unknown = ", ".join(sorted(({*hashes} - languages) ^ known))
    require(not unknown, f"the certificate lacks a hash or has an unknown one: {unknown}")
    require(hashes["task_data"] == task.digest, "the task's data is not that of the certificate (SHA-256)")
    for file in {*hashes} - {"task_data"}:
        path = folder / file
        data = text if file == f"{task.name}.c" else read_bounded(path, BESIDE_BYTES) if path.exists() else None
        is_same = data is None or hashes[file] == hashlib.sha256(data).hexdigest()
        require(is_same, f"{file} is not that of the certificate (SHA-256)")


def check_listings(
    task: Task, law: Law, text: bytes, folder: Path, *, files: dict[str, str], options: set[str], values: dict[str, Any]
) -> None:
    """Require that the C, the header and the small files are the listings, filled with the numbers of task and certificate. text:
    the C; folder: that of the files beside it; files: their names by listing."""
    has_integers = law.scalar == "fixed"
    for listing, file in files.items():
        data = text if listing == "controller" else read_bounded(folder / file, SOURCE_BYTES)
        wanted = source.fill(f"integer {listing}" if has_integers else listing, options, task.name, values)
        source.compare(file, data, wanted, law.scalar == "float", 53 if has_integers else law.bits)


def design_hash(task: Task, tube: Any, law: Law, unit_bits: int) -> str:
    """Return the 16 hexadecimal digits that name the design in the header."""
    design: dict[str, Any] = {"prescribed_time": str(task.t_c), "segments": tube.segments, "bits": unit_bits, "table": tube.table}
    design |= {"filter": [str(v) for v in law.filters]} if law.filters else {}
    design |= {} if tube.seam is None else {"seam": tube.seam}
    data = {"task": task.digest, "scalar": law.scalar, "design": design}
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]
