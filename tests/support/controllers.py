"""The example tasks, and controllers that are built once for all tests of a run.

A controller depends on its task and on the package alone. `build_once` stores it in build/tests/. The name of its folder is a hash of the
package and of the lock file; the name of its file is a hash of the task. So all test files and workers share one build.
A test that changes the package (monkeypatch), or asks whether a build repeats itself, calls `build_task` instead.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import shutil
import tempfile
import time
from functools import cache
from pathlib import Path

from stt_codegen import api
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.task import Task, load_task

ROOT = Path(__file__).parents[2]
TASK_FILES = sorted((ROOT / "tasks").glob("*.toml"))
INERTIAL = [p.stem for p in TASK_FILES if "\norder = 2" in p.read_text()]  # tests/controller/test_order_two.py tests them
TESTED_ELSEWHERE = ("rover", "waypoints", "either", "watchman", "crawler", "gantry")  # in test files for one task each
NAMES = [
    p.stem for p in TASK_FILES if p.stem not in (*INERTIAL, *TESTED_ELSEWHERE)
]  # of tasks of order 1 whose unsafe sets are boxes
ADAPTABLE = [name for name in NAMES if name not in ("omni_board", "trolley", "courier")]  # those three need a refined tube


UNUSED_STORE_AGE_LIMIT = 24 * 3600.0  # seconds


@cache
def store_folder() -> Path:
    """Return the folder of stored controllers for the present contents of the package, and remove the unused folders of earlier ones.

    A folder of other contents stays for a day after its last use: another run of the tests in this clone may be using it."""
    digest = hashlib.sha256()
    sources = [path for folder in ("stt_codegen", "templates") for path in (ROOT / folder).rglob("*") if path.suffix != ".pyc"]
    for path in sorted([*filter(Path.is_file, sources), ROOT / "locks" / "requirements.lock"]):
        digest.update(f"{path.relative_to(ROOT)}\0".encode() + path.read_bytes() + b"\0")
    folder = ROOT / "build" / "tests" / digest.hexdigest()[:16]
    folder.mkdir(parents=True, exist_ok=True)
    os.utime(folder)
    remove_unused_stores(folder.parent)
    return folder


def remove_unused_stores(parent: Path) -> None:
    """Remove the folders in `parent` that no run of the tests has used for UNUSED_STORE_AGE_LIMIT."""
    for folder in parent.iterdir():
        with contextlib.suppress(FileNotFoundError):  # another run removes folders, too
            if time.time() - folder.stat().st_mtime > UNUSED_STORE_AGE_LIMIT:
                shutil.rmtree(folder, ignore_errors=True)


def stated_fields(task: Task) -> str:
    """Return the fields that the task file states, as text.

    Two equal tasks can differ in this, where one spells a default out; then their digests differ, and so may their changed copies.
    A pickle of the task would differ by process, because sets have no order."""
    return repr(task.model_dump(exclude_unset=True, warnings=False))  # a test may bring a class of sets that no schema has


def build_once(task: Task, uncertified: bool = False) -> EmittedController:
    """Return the task's controller: load it from the store, or build it and store it."""
    content = repr((task, task.digest, stated_fields(task), stated_fields(task.as_stated), uncertified))
    path = store_folder() / hashlib.sha256(content.encode()).hexdigest()
    try:
        controller: EmittedController = pickle.loads(path.read_bytes())
    except (OSError, EOFError, pickle.UnpicklingError):
        controller = build_task(task, uncertified)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(pickle.dumps(controller))
        os.replace(file.name, path)
    return controller


@cache
def controller_of(name: str, scalar: str = "float", design: str | None = None) -> EmittedController:
    """Return the controller of the task `tasks/<name>.toml`, with this scalar type and, where given, this kind of design."""
    return build_once(load_task(ROOT / "tasks" / f"{name}.toml").with_options(design, scalar))


def interface_of(controller: EmittedController) -> api.Controller:
    """Return the controller as the class that `stt.build` returns to a script."""
    return api.Controller(controller.task, controller.design, controller.program, controller.certificate, controller.files)
