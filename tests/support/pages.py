"""Pages of the report, each built once a process, and a browser that opens them (tests/report)."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from stt_codegen.pipeline import EmittedController
from stt_codegen.report.figures.design_figures import design_report
from stt_codegen.report.page.evidence import Evidence, evidence
from stt_codegen.report.page.page import page
from stt_codegen.task import load_task, parse_task
from tests.support.controllers import build_once
from tests.support.missing_tools import skip_without

ROOT = Path(__file__).parents[2]

KINDS = {
    "plain": ("omni_s2", None),
    "missions": ("courier", None),
    "for ever": ("watchman", None),
    "three dimensions, order 2": ("drone", None),
    "three dimensions": ("spacecraft", None),
    "adaptive": ("omni_s2", "adaptive"),
    "literal": ("omni_s2", "literal"),
}
MOVING = """
name = "crossing"
prescribed_time = 10
initial_state = [1, 1]
state_space = { lower = [0, 0], upper = [10, 6] }
initial_set = { lower = [0.5, 0.5], upper = [1.5, 1.5] }
target_set = { lower = [8.5, 4.5], upper = [9.5, 5.5] }
body = [0.1, 0.1]
unsafe = [{ name = "cart", lower = [4, 0], upper = [5, 2], motion = [{ at = 0, by = [0, 0] }, { at = 8, by = [0, 3] }], timing = 0.2, spread = 0.02 }]
"""
STOP = (ROOT / "tasks" / "trolley.toml").read_text().replace("[control]\n", '[control]\noutside = "stop"\n')
HOLD = (ROOT / "tasks" / "omni_s2.toml").read_text().replace("[control]\n", '[control]\noutside = "hold"\nu_max = 3\n')


@cache
def controller_of_kind(kind: str) -> EmittedController:
    """Return the controller whose page is tested: a kind of `KINDS`, or "moving", "hold", "stop" or "double"."""
    if kind == "moving":
        return build_once(parse_task(MOVING))
    if kind == "hold":
        return build_once(parse_task(HOLD))
    if kind == "stop":
        return build_once(parse_task(STOP))
    if kind == "double":
        return build_once(load_task(ROOT / "tasks" / "omni_s2.toml").with_options(scalar="double"))
    name, design = KINDS[kind]
    return build_once(load_task(ROOT / "tasks" / f"{name}.toml").with_options(design), uncertified=design == "literal")


@cache
def report_html(kind: str) -> str:
    """Return the report page of `controller_of_kind(kind)`."""
    controller = controller_of_kind(kind)
    if kind not in KINDS:  # tests look only at the loop and the picture of these pages, so the evidence may be another task's
        return page(controller, design_report(controller, 0.0), plain_evidence()).decode()
    source = ROOT / "tasks" / f"{KINDS[kind][0]}.toml"
    return page(controller, design_report(controller, 0.0), evidence(controller, source)).decode()


@cache
def plain_evidence() -> Evidence:
    """Return the evidence of the page "plain"."""
    return evidence(controller_of_kind("plain"), ROOT / "tasks" / "omni_s2.toml")


def data_block(text: str, name: str = "data") -> dict[str, Any]:
    """Return the JSON document in the page's script element with this id."""
    match = re.search(rf'<script id="{name}" type="application/json">(.*?)</script>', text, re.S)
    assert match is not None
    data: dict[str, Any] = json.loads(match[1])
    return data


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Start Chromium under Playwright; without it the test is skipped, and fails in CI."""
    chromium = shutil.which("chromium")
    if chromium is None:
        skip_without("chromium is not installed; `.ci/tools test` installs it")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield browser
        browser.close()


class OpenPage:
    """A page that is open in the browser, with its console messages and the URLs that it requested.

    As a context manager it closes the page, and fails where there was a message or a request beyond local files."""

    def __init__(self, browser: Any, path: Path, width: int = 1280, scheme: str = "light", **context: Any) -> None:
        self.console_messages, self.requested_urls = list[str](), list[str]()
        self.context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, **context)
        self.page = self.context.new_page()
        self.page.on("console", lambda message: self.console_messages.append(message.text))
        self.page.on("pageerror", lambda error: self.console_messages.append(str(error)))
        self.page.on("request", lambda request: self.requested_urls.append(request.url))
        self.page.goto(path.as_uri())
        self.wait_until("document.querySelectorAll('#strips svg').length === 1")

    def wait_until(self, expression: str, seconds: float = 30.0) -> None:
        """Wait until a JavaScript expression is true. Polls from outside, because the page's content policy forbids eval in it."""
        for _ in range(int(seconds * 20)):
            if self.page.evaluate(expression):
                return
            self.page.wait_for_timeout(50)
        pytest.fail(f"not within {seconds} s: {expression}")

    def choose_view(self, view: int) -> None:
        """Choose the plane that the picture shows, where the page offers several."""
        if self.page.locator("#plane option").count() > 1:
            self.page.select_option("#plane", str(view))

    def __enter__(self) -> OpenPage:
        return self

    def __exit__(self, *error: object) -> None:
        self.context.close()
        if error[0] is None:
            assert self.console_messages == []
            assert all(url.startswith(("file:", "blob:")) for url in self.requested_urls)


@pytest.fixture
def open_page(browser: Any, tmp_path: Path) -> Any:
    """Return a function that opens the page of a kind, with the options of `OpenPage`."""

    def open_kind(kind: str, **options: Any) -> OpenPage:
        path = tmp_path / f"{kind.replace(' ', '_')}.html"
        path.write_text(report_html(kind))
        return OpenPage(browser, path, **options)

    return open_kind
