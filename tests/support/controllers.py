"""The example tasks, and controllers that are built once for all tests of a run.

A controller depends on its task and on the package alone. `built` keeps it in build/tests/, in a folder for the contents of the
package and of the lock file, and a file for the task's, so that every file of tests and every worker takes the one that was built first. A test that changes the
package (monkeypatch) or asks whether a build repeats itself calls `build_task` instead.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import tempfile
from functools import cache
from pathlib import Path

from stt_codegen import api
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.task import Task, load_task

ROOT = Path(__file__).parents[2]
TASK_FILES = sorted((ROOT / "tasks").glob("*.toml"))
INERTIAL = [p.stem for p in TASK_FILES if "\norder = 2" in p.read_text()]  # tests/controller/test_order_two.py has them
ELSEWHERE = ("rover", "waypoints", "either", "watchman", "crawler", "gantry")  # files of their own have these
NAMES = [p.stem for p in TASK_FILES if p.stem not in (*INERTIAL, *ELSEWHERE)]  # unsafe sets are boxes
ADAPTABLE = [name for name in NAMES if name not in ("omni_board", "trolley", "courier")]  # their options are for refined tubes


@cache
def store() -> Path:
    """Return the folder of the controllers that the package as it is builds; those of other contents are removed."""
    digest = hashlib.sha256()
    read = [path for folder in ("stt_codegen", "templates") for path in (ROOT / folder).rglob("*") if path.suffix != ".pyc"]
    for path in sorted([*filter(Path.is_file, read), ROOT / "locks" / "requirements.lock"]):
        digest.update(f"{path.relative_to(ROOT)}\0".encode() + path.read_bytes() + b"\0")
    folder = ROOT / "build" / "tests" / digest.hexdigest()[:16]
    folder.mkdir(parents=True, exist_ok=True)
    for stale in folder.parent.iterdir():
        if stale != folder:
            shutil.rmtree(stale, ignore_errors=True)
    return folder


def stated_fields(task: Task) -> str:
    """Return what the task states: equal tasks differ where one spells a default out, and so do their digests and what is changed of them.

    A pickle would differ by process, because sets have no order."""
    return repr(task.model_dump(exclude_unset=True, warnings=False))  # sets that a test brings are in no schema


def built(task: Task, uncertified: bool = False) -> EmittedController:
    """Return the task's controller, from the store where it was built before."""
    content = repr((task, task.digest, stated_fields(task), stated_fields(task.as_stated), uncertified))
    path = store() / hashlib.sha256(content.encode()).hexdigest()
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
    """Return the controller of an example task."""
    return built(load_task(ROOT / "tasks" / f"{name}.toml").with_options(design, scalar))


def interface_of(controller: EmittedController) -> api.Controller:
    """Return a controller as `stt.build` does: with the interface for scripts."""
    return api.Controller(controller.task, controller.design, controller.program, controller.certificate, controller.files)
