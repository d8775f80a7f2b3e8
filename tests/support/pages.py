"""Pages of the report for the tests, each made once a process, and a browser that looks at them."""

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
from tests.support.absent import absent
from tests.support.controllers import built

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
def controller_of(kind: str) -> EmittedController:
    if kind == "moving":
        return built(parse_task(MOVING))
    if kind == "hold":
        return built(parse_task(HOLD))
    if kind == "stop":
        return built(parse_task(STOP))
    if kind == "double":
        return built(load_task(ROOT / "tasks" / "omni_s2.toml").with_options(scalar="double"))
    name, design = KINDS[kind]
    return built(load_task(ROOT / "tasks" / f"{name}.toml").with_options(design), uncertified=design == "literal")


@cache
def made(kind: str) -> str:
    controller = controller_of(kind)
    if kind not in KINDS:  # of these the loop and the picture alone are looked at: the evidence is another's
        return page(controller, design_report(controller, 0.0), plain_evidence()).decode()
    source = ROOT / "tasks" / f"{KINDS[kind][0]}.toml"
    return page(controller, design_report(controller, 0.0), evidence(controller, source)).decode()


@cache
def plain_evidence() -> Evidence:
    return evidence(controller_of("plain"), ROOT / "tasks" / "omni_s2.toml")


def data_of(text: str, name: str = "data") -> dict[str, Any]:
    found = re.search(rf'<script id="{name}" type="application/json">(.*?)</script>', text, re.S)
    assert found is not None
    data: dict[str, Any] = json.loads(found[1])
    return data


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium, driven by Playwright: a visible skip without it, a failure in CI."""
    chromium = shutil.which("chromium")
    if chromium is None:
        absent("chromium is not installed; `.ci/tools test` installs it")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        found = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield found
        found.close()


class Open:
    """A page in the browser; what it says on the console, and what it asks for, is kept."""

    def __init__(self, browser: Any, path: Path, width: int = 1280, scheme: str = "light", **context: Any) -> None:
        self.said, self.asked = list[str](), list[str]()
        self.context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, **context)
        self.page = self.context.new_page()
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(path.as_uri())
        self.until("document.querySelectorAll('#strips svg').length === 1")

    def until(self, expression: str, seconds: float = 30.0) -> None:
        """Wait for something to be true; the page's own policy forbids to have it evaluated there again and again."""
        for _ in range(int(seconds * 20)):
            if self.page.evaluate(expression):
                return
            self.page.wait_for_timeout(50)
        pytest.fail(f"not within {seconds} s: {expression}")

    def look_at(self, view: int) -> None:
        """Choose a view, where there are several."""
        if self.page.locator("#plane option").count() > 1:
            self.page.select_option("#plane", str(view))

    def __enter__(self) -> Open:
        return self

    def __exit__(self, *error: object) -> None:
        self.context.close()
        if error[0] is None:
            assert self.said == []
            assert all(url.startswith(("file:", "blob:")) for url in self.asked)


@pytest.fixture
def opened(browser: Any, tmp_path: Path) -> Any:
    def look(kind: str, **how: Any) -> Open:
        path = tmp_path / f"{kind.replace(' ', '_')}.html"
        path.write_text(made(kind))
        return Open(browser, path, **how)

    return look
