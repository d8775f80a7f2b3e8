"""The report as a person sees it in Chromium: every view, at every width, by keyboard and on paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stt_codegen.report.figures.design_figures import design_report
from stt_codegen.report.page.evidence import evidence
from stt_codegen.report.page.page import page
from stt_codegen.task.load import parse_task
from tests.support.controllers import build_once
from tests.support.pages import KINDS, OpenPage, controller_of_kind

pytestmark = pytest.mark.xdist_group("page")  # a worker starts one browser and builds every page once
HALL = """
name = "hall"
prescribed_time = 8
initial_state = [1, 1]
state_space = { lower = [0, 0], upper = [10, 6] }
initial_set = { lower = [0.5, 0.5], upper = [1.5, 1.5] }
target_set = { lower = [8.5, 0.5], upper = [9.5, 1.5] }
"""


@pytest.mark.parametrize("kind", [k for k in [*KINDS, "moving", "hold"] if k != "three dimensions"])
def test_every_view_of_every_kind_opens_without_an_error(kind: str, open_page: Any) -> None:
    controller = controller_of_kind(kind)
    n = controller.task.dimension
    with open_page(kind) as opened_page:
        views = opened_page.page.locator("#plane option").count()
        assert views == n * (n - 1) // 2 + (n == 3)
        for k in range(views):
            opened_page.choose_view(k)
            assert opened_page.page.locator("#arena svg:not(.paper), #arena canvas").count() == 1
        assert opened_page.page.locator("#strips .band").count() == n * (3 if controller.task.order == 2 else 1)
        opened_page.page.click("#play")
        opened_page.wait_until("document.getElementById('time').value > 5")
        opened_page.page.click("#drive-on")
        opened_page.wait_until("document.getElementById('drive-u').textContent !== ''")


@pytest.mark.parametrize(
    ("kind", "width", "scheme"),
    [("plain", 390, "light"), ("three dimensions, order 2", 1280, "dark"), ("literal", 1280, "light"), ("moving", 390, "dark")],
)
def test_the_page_meets_wcag_aa(kind: str, width: int, scheme: str, open_page: Any) -> None:
    """axe-core checks it in light and dark, at the width of a phone and of a desktop, also while the loop runs."""
    from axe_playwright_python.sync_playwright import Axe

    rules = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]}
    with open_page(kind, width=width, scheme=scheme, bypass_csp=True) as opened_page:
        opened_page.page.click("#drive-on")
        opened_page.page.click("#play")
        violations = Axe().run(opened_page.page, options=rules).response["violations"]
        assert [(v["id"], [node["html"][:120] for node in v["nodes"]]) for v in violations] == []


@pytest.mark.parametrize("kind", ["plain", "missions", "three dimensions, order 2", "moving"])
def test_no_label_is_cut_off_or_overlaps_another(kind: str, open_page: Any) -> None:
    frames_and_labels = """() => ['arena', 'strips'].flatMap((id) => [...document.querySelectorAll(`#${id} svg:not(.paper)`)].map((svg) => {
      const texts = [...svg.querySelectorAll('text')].filter((t) => t.textContent && t.getClientRects().length);
      const box = (node) => { const r = node.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; };
      return [box(svg), texts.map((t) => [t.textContent, ...box(t)])];
    }))"""
    for width in (390, 1280, 2560):
        with open_page(kind, width=width) as opened_page:
            assert opened_page.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
            opened_page.choose_view(opened_page.page.locator("#plane option").count() - 1)
            for frame, texts in opened_page.page.evaluate(frames_and_labels):
                for text, *box in texts:
                    assert box[0] >= frame[0] - 1, (width, text)
                    assert box[2] <= frame[2] + 1, (width, text)
                for k, (text, *a) in enumerate(texts):
                    for second_text, *b in texts[k + 1 :]:
                        assert a[0] >= b[2] or b[0] >= a[2] or a[1] >= b[3] - 2 or b[1] >= a[3] - 2, (width, text, second_text)


def test_every_control_can_be_reached_and_used_by_keyboard(open_page: Any) -> None:
    with open_page("plain") as opened_page:
        page_ = opened_page.page
        control_count = page_.evaluate(
            "[...document.querySelectorAll('button, input, select, a[href]')].filter((e) => e.offsetParent).length"
        )
        focused = set()
        for _ in range(3 * control_count):
            page_.keyboard.press("Tab")
            focused.add(
                page_.evaluate("[...document.querySelectorAll('button, input, select, a[href]')].indexOf(document.activeElement)")
            )
        assert len(focused - {-1}) == control_count
        page_.focus("#time")
        page_.keyboard.press("ArrowRight")
        assert page_.input_value("#time") == "1"
        page_.focus("#drive-step")
        page_.keyboard.press("Enter")
        before = page_.inner_text("#drive-u")
        page_.focus(".handle")
        page_.keyboard.press("ArrowRight")
        assert page_.inner_text("#drive-u") != before


def test_a_row_of_the_certificate_leads_to_its_time(open_page: Any) -> None:
    """The button of a row with a time moves the slider to the middle of that interval."""
    controller = controller_of_kind("plain")
    with open_page("plain") as opened_page:
        rows = opened_page.page.locator("section:has(> #certificate) tbody tr")
        assert rows.count() == len(controller.certificate.findings)
        for k, finding in enumerate(controller.certificate.findings):
            if finding.time is not None:
                rows.nth(k).locator("button.go-to-time").click()
                assert opened_page.page.inner_text("#now") == f"{float(sum(finding.time) / 2):.2f} s"


def test_with_many_sets_only_the_name_under_the_pointer_is_shown(browser: Any, tmp_path: Path) -> None:
    """A picture shows up to forty names; with more sets it shows only the name of the set under the pointer."""
    boxes = [f'{{ name = "B{k}", lower = [{0.2 * k:.1f}, 5], upper = [{0.2 * k + 0.1:.1f}, 6] }}' for k in range(42)]
    controller = build_once(parse_task(HALL + f"unsafe = [{', '.join(boxes)}]\n"))
    path = tmp_path / "page.html"
    path.write_bytes(page(controller, design_report(controller, 0.0), evidence(controller)))
    with OpenPage(browser, path) as opened_page:
        assert opened_page.page.locator("#arena text.name").all_text_contents() == ["start", "target", ""]
        opened_page.page.locator("#arena [data-name=B7] .unsafe").hover()
        assert opened_page.page.locator("#arena text.name").last.text_content() == "B7"


def test_the_report_can_be_printed(open_page: Any, tmp_path: Path) -> None:
    with open_page("three dimensions, order 2") as opened_page:
        data = opened_page.page.pdf(path=tmp_path / "page.pdf", format="A4")
        assert data.startswith(b"%PDF")
        opened_page.page.emulate_media(media="print")
        opened_page.page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
        assert opened_page.page.locator("#arena svg.paper polygon").count() > 20
        opened_page.page.set_viewport_size({"width": 700, "height": 900})  # the views are built again, with nothing on paper
        opened_page.page.evaluate("new Promise((done) => setTimeout(() => requestAnimationFrame(done), 300))")
        assert opened_page.page.locator("#arena svg.paper polygon").count() > 20
        assert opened_page.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
