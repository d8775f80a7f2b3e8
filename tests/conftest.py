"""Fixtures of all tests: system tools that may be missing, and the browser that opens pages of the report."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable

import pytest

from tests.support.missing_tools import skip_without
from tests.support.pages import browser, open_page  # noqa: F401 (fixtures of test_page_drive.py and test_page_seen.py)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Send the tests of a file to one worker, which then builds and compiles the controllers of that file once."""
    for item in items:
        if item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(item.path.stem))


@pytest.fixture(autouse=True)
def longer_effort(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the search for remedies more time than a user waits, so that no refusal depends on how busy the machine is."""
    monkeypatch.setattr("stt_codegen.effort.effort.DEFAULT_SECONDS", 60.0)
    if "stt_codegen.pipeline" in sys.modules:
        monkeypatch.setattr("stt_codegen.pipeline.RELEASED_SECONDS", 30.0)
    if "stt_codegen.cli.options" in sys.modules:
        monkeypatch.setattr("stt_codegen.cli.options.DEFAULT_SECONDS", 60.0)
    if "stt_codegen.api" in sys.modules:
        for function in (sys.modules["stt_codegen.api"].build, sys.modules["stt_codegen.api"].design):
            monkeypatch.setitem(function.__kwdefaults__, "effort", 60.0)


@pytest.fixture
def tool() -> Callable[[str], str]:
    """Return a function from a tool's name to its path; without the tool the test is skipped, and fails in CI."""

    def find(name: str) -> str:
        path = shutil.which(name)
        if path is None:
            skip_without(f"{name} is not installed; `.ci/tools test` installs it")
        return path

    return find
