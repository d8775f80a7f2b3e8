"""What a person sees of the report, in Chromium: every view, at every width, by keyboard, on paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stt_codegen.report.figures.design_figures import design_report
from stt_codegen.report.page.evidence import evidence
from stt_codegen.report.page.page import page
from stt_codegen.task.load import parse_task
from tests.support.controllers import built
from tests.support.pages import KINDS, OpenPage, controller_of_kind

pytestmark = pytest.mark.xdist_group("page")  # one browser, and every page made once
ROOM = """
name = "hall"
prescribed_time = 8
initial_state = [1, 1]
state_space = { lower = [0, 0], upper = [10, 6] }
initial_set = { lower = [0.5, 0.5], upper = [1.5, 1.5] }
target_set = { lower = [8.5, 0.5], upper = [9.5, 1.5] }
"""

# ---------------------------------------------------------------------------------------------- what a person sees


@pytest.mark.parametrize("kind", [k for k in [*KINDS, "moving", "hold"] if k != "three dimensions"])
def test_a_browser_shows_it_without_a_complaint(kind: str, open_page: Any) -> None:
    controller = controller_of_kind(kind)
    n = controller.task.dimension
    with open_page(kind) as shown:
        views = shown.page.locator("#plane option").count()
        assert views == n * (n - 1) // 2 + (n == 3)
        for k in range(views):
            shown.choose_view(k)
            assert shown.page.locator("#arena svg:not(.paper), #arena canvas").count() == 1
        assert shown.page.locator("#strips .band").count() == n * (3 if controller.task.order == 2 else 1)
        shown.page.click("#play")
        shown.wait_until("document.getElementById('time').value > 5")
        shown.page.click("#drive-on")
        shown.wait_until("document.getElementById('drive-u').textContent !== ''")


@pytest.mark.parametrize(
    ("kind", "width", "scheme"),
    [("plain", 390, "light"), ("three dimensions, order 2", 1280, "dark"), ("literal", 1280, "light"), ("moving", 390, "dark")],
)
def test_everyone_can_read_it(kind: str, width: int, scheme: str, open_page: Any) -> None:
    """WCAG AA as axe-core checks it, in light and dark, at a phone's width and a desk's, also while it drives."""
    from axe_playwright_python.sync_playwright import Axe

    rules = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]}
    with open_page(kind, width=width, scheme=scheme, bypass_csp=True) as shown:
        shown.page.click("#drive-on")
        shown.page.click("#play")
        found = Axe().run(shown.page, options=rules).response["violations"]
        assert [(v["id"], [node["html"][:120] for node in v["nodes"]]) for v in found] == []


@pytest.mark.parametrize("kind", ["plain", "missions", "three dimensions, order 2", "moving"])
def test_nothing_is_cut_off_and_no_label_is_over_another(kind: str, open_page: Any) -> None:
    places = """() => ['arena', 'strips'].flatMap((id) => [...document.querySelectorAll(`#${id} svg:not(.paper)`)].map((svg) => {
      const texts = [...svg.querySelectorAll('text')].filter((t) => t.textContent && t.getClientRects().length);
      const box = (node) => { const r = node.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; };
      return [box(svg), texts.map((t) => [t.textContent, ...box(t)])];
    }))"""
    for width in (390, 1280, 2560):
        with open_page(kind, width=width) as shown:
            assert shown.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
            shown.choose_view(shown.page.locator("#plane option").count() - 1)
            for frame, texts in shown.page.evaluate(places):
                for told, *box in texts:
                    assert box[0] >= frame[0] - 1, (width, told)
                    assert box[2] <= frame[2] + 1, (width, told)
                for k, (told, *a) in enumerate(texts):
                    for other, *b in texts[k + 1 :]:
                        assert a[0] >= b[2] or b[0] >= a[2] or a[1] >= b[3] - 2 or b[1] >= a[3] - 2, (width, told, other)


def test_every_control_is_reached_and_worked_by_keyboard(open_page: Any) -> None:
    with open_page("plain") as shown:
        page_ = shown.page
        wanted = page_.evaluate(
            "[...document.querySelectorAll('button, input, select, a[href]')].filter((e) => e.offsetParent).length"
        )
        seen = set()
        for _ in range(3 * wanted):
            page_.keyboard.press("Tab")
            seen.add(
                page_.evaluate("[...document.querySelectorAll('button, input, select, a[href]')].indexOf(document.activeElement)")
            )
        assert len(seen - {-1}) == wanted
        page_.focus("#time")
        page_.keyboard.press("ArrowRight")
        assert page_.input_value("#time") == "1"
        page_.focus("#drive-step")
        page_.keyboard.press("Enter")
        before = page_.inner_text("#drive-u")
        page_.focus(".grip")
        page_.keyboard.press("ArrowRight")
        assert page_.inner_text("#drive-u") != before


def test_the_certificate_leads_to_the_moment(open_page: Any) -> None:
    """Every row that has a time: its button brings the slider to the middle of it."""
    controller = controller_of_kind("plain")
    with open_page("plain") as shown:
        rows = shown.page.locator("section:has(> #certificate) tbody tr")
        assert rows.count() == len(controller.certificate.findings)
        for k, one in enumerate(controller.certificate.findings):
            if one.time is not None:
                rows.nth(k).locator("button.go").click()
                assert shown.page.inner_text("#now") == f"{float(sum(one.time) / 2):.2f} s"


def test_of_many_sets_the_name_under_the_pointer_is_shown(browser: Any, tmp_path: Path) -> None:
    """Up to forty names stand in the picture; of more the one that the pointer is on."""
    boxes = [f'{{ name = "B{k}", lower = [{0.2 * k:.1f}, 5], upper = [{0.2 * k + 0.1:.1f}, 6] }}' for k in range(42)]
    controller = built(parse_task(ROOM + f"unsafe = [{', '.join(boxes)}]\n"))
    path = tmp_path / "page.html"
    path.write_bytes(page(controller, design_report(controller, 0.0), evidence(controller)))
    with OpenPage(browser, path) as shown:
        assert shown.page.locator("#arena text.name").all_text_contents() == ["start", "target", ""]
        shown.page.locator("#arena [data-name=B7] .unsafe").hover()
        assert shown.page.locator("#arena text.name").last.text_content() == "B7"


def test_it_prints(open_page: Any, tmp_path: Path) -> None:
    with open_page("three dimensions, order 2") as shown:
        data = shown.page.pdf(path=tmp_path / "page.pdf", format="A4")
        assert data.startswith(b"%PDF")
        shown.page.emulate_media(media="print")
        shown.page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
        assert shown.page.locator("#arena svg.paper polygon").count() > 20
        assert shown.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
