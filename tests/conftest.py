"""Fixtures of all tests: tools that may be absent, and the browser of the page's tests."""

from __future__ import annotations

import shutil
from collections.abc import Callable

import pytest

from tests.support.absent import absent
from tests.support.pages import browser, opened  # noqa: F401 (fixtures of test_page_drive.py and test_page_seen.py)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Send the tests of a file to one worker, which then builds and compiles the controllers of that file once."""
    for item in items:
        if item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(item.path.stem))


@pytest.fixture
def tool() -> Callable[[str], str]:
    """The path of a system tool: a visible skip without it, a failure in CI."""

    def find(name: str) -> str:
        found = shutil.which(name)
        if found is None:
            absent(f"{name} is not installed; `.ci/tools test` installs it")
        return found

    return find
