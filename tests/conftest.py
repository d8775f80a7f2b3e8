"""Shared: the example tasks, controllers built once, and tools that may be absent."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from absent import absent
from pages import browser, opened  # noqa: F401 (fixtures of test_page_drive.py and test_page_seen.py)

from stt_codegen.pipeline import Controller, build

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "benchmarks"))  # whose oracles and arenas the tests share
TASK_FILES = sorted((ROOT / "tasks").glob("*.toml"))
INERTIAL = [p.stem for p in TASK_FILES if "\norder = 2" in p.read_text()]  # tests/test_inertia.py has them
ELSEWHERE = ("rover", "waypoints", "either", "watchman", "crawler", "gantry")  # files of their own have these
NAMES = [p.stem for p in TASK_FILES if p.stem not in (*INERTIAL, *ELSEWHERE)]  # unsafe sets are boxes
ADAPTABLE = [name for name in NAMES if name not in ("omni_board", "trolley", "courier")]  # their options are for refined tubes


@cache
def controller_of(name: str, scalar: str = "float") -> Controller:
    """The controller of an example task, built once a process."""
    return build(ROOT / "tasks" / f"{name}.toml", scalar=scalar)


@pytest.fixture
def tool() -> Callable[[str], str]:
    """The path of a system tool: a visible skip without it, a failure in CI."""

    def find(name: str) -> str:
        found = shutil.which(name)
        if found is None:
            absent(f"{name} is not installed; `.ci/tools test` installs it")
        return found

    return find
