"""The report: one page that stands alone, shows the tube that is certified, and drives the C that ships."""

from __future__ import annotations

import base64
import ctypes
import hashlib
import importlib.resources
import json
import os
import re
import shutil
import struct
import subprocess
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

from stt_codegen.cli.report import report
from stt_codegen.designs.grid import tube_at
from stt_codegen.emit.driven import adapter_source, driven_sources
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import Controller, build, build_task
from stt_codegen.plants import plant_of
from stt_codegen.report.design import design_report
from stt_codegen.report.drive import driven, plant_driven, shipped
from stt_codegen.report.materials import bill
from stt_codegen.report.misra import DEVIATIONS
from stt_codegen.report.evidence import evidence
from stt_codegen.report.page import page
from stt_codegen.report.scene import SAMPLES
from stt_codegen.report.solids import solid
from stt_codegen.task import parse_task

pytestmark = pytest.mark.xdist_group("page")  # one browser, and every page made once

MOST = 2 << 20  # bytes of a page
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
HOLD = (ROOT / "tasks" / "omni_s2.toml").read_text().replace("[control]\n", '[control]\noutside = "hold"\nu_max = 3\n')


@cache
def controller_of(kind: str) -> Controller:
    if kind == "moving":
        return build_task(parse_task(MOVING))
    if kind == "hold":
        return build_task(parse_task(HOLD))
    if kind == "double":
        return build(ROOT / "tasks" / "omni_s2.toml", scalar="double")
    name, design = KINDS[kind]
    return build(ROOT / "tasks" / f"{name}.toml", design, uncertified=design == "literal")


@cache
def made(kind: str) -> str:
    controller = controller_of(kind)
    source = None if kind in ("moving", "hold", "double") else ROOT / "tasks" / f"{KINDS[kind][0]}.toml"
    return page(controller, design_report(controller, 0.0), EXTRAS(source)).decode()


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
        if os.environ.get("CI") == "true":
            pytest.fail("chromium is missing; `.ci/tools test` should have installed it")
        pytest.skip("chromium is not installed")
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


# ---------------------------------------------------------------------------------------------- what the file says


@pytest.mark.parametrize("kind", [*KINDS, "moving"])
def test_a_page_stands_alone_and_has_every_property_and_file(kind: str) -> None:
    controller, text = controller_of(kind), made(kind)
    assert len(text.encode()) <= MOST
    assert set(re.findall(r"https?://[^\s\"'<]+", text)) == {"http://www.w3.org/2000/svg"}  # a name, which nothing fetches
    assert not re.search(r"\bsrc=|@import|url\((?!#|.\(#)", re.sub(r"`[^`]*`", "", text))
    assert set(re.findall(r'\bhref="([^"#]+)', text)) == set()
    for finding in controller.certificate.findings:
        assert f"<b>{finding.code}</b>" in text
    assert text.count('<tr class="bad">') == 2 * len(controller.certificate.failures)  # the certificate, and requirements
    assert ("Not certified" in text) == (not controller.certificate.holds)
    for name, content in controller.files.items():
        assert name in text
        assert hashlib.sha256(content).hexdigest() in text


@pytest.mark.parametrize("kind", ["missions", "adaptive", "moving"])
def test_what_is_drawn_is_the_tube(kind: str) -> None:
    controller = controller_of(kind)
    data = data_of(made(kind))
    t = np.linspace(0, float(controller.task.prescribed_time), SAMPLES + 1)
    for name, edge in zip(("low", "high"), tube_at(controller.design, t), strict=True):
        size = np.abs(edge).max()
        assert np.abs(np.array(data[name]) - edge).max() <= 10.0 ** (np.ceil(np.log10(size)) - 6)  # six digits of the largest
    assert len(data["sets"]) == len(controller.task.unsafe)
    for one, table in zip(data["sets"], controller.task.unsafe, strict=True):
        assert ("knots" in one) == (table.motion is not None)


def test_a_tube_that_collides_says_where() -> None:
    """By name and time, as a search of the samples of its own finds it."""
    controller, data = controller_of("literal"), data_of(made("literal"))
    low, high = np.array(data["low"]), np.array(data["high"])
    t = np.linspace(0, data["t_c"], SAMPLES + 1)
    for one in controller.task.bare:
        lower, upper = (np.array([float(v) for v in edge]) for edge in (one.lower, one.upper))  # type: ignore[attr-defined]
        meets = ((low < upper) & (high > lower)).all(axis=1)
        told = [(a, b) for name, a, b in data["meets"] if name == one.name]
        inside = np.any([(t >= a - 1e-9) & (t <= b + 1e-9) for a, b in told] or [np.zeros(len(t), bool)], axis=0)
        assert (meets == inside).all()
    assert data["meets"]
    assert all(f"The tube meets {name}" in made("literal") for name, _, _ in data["meets"])
    assert data_of(made("plain"))["meets"] == []


def test_words_of_a_task_are_words_of_the_page() -> None:
    """Formulas have what HTML means otherwise. (Names and units may not.)"""
    text = made("missions")
    assert "dock -&gt; eventually" in text
    assert "dock -> eventually" not in text


def test_the_page_is_the_same_for_the_same_task() -> None:
    controller = build(ROOT / "tasks" / "courier.toml")
    again = page(controller, design_report(controller, 0.0), EXTRAS(ROOT / "tasks" / "courier.toml")).decode()
    assert again == made("missions")


def test_faces_of_a_solid_hold_its_corners() -> None:
    """Of a cut box: every face is flat, no corner is beyond one, and the faces close the body (Euler)."""
    points = np.array([p for p in np.ndindex(3, 3, 3) if sum(p) <= 4], dtype=float)
    corners, faces = solid(points)
    edges = {frozenset(pair) for face in faces for pair in zip(face, [*face[1:], face[0]], strict=True)}
    assert len(corners) - len(edges) + len(faces) == 2
    for face in faces:
        a, b, c = corners[face[:3]]
        beyond = (corners - a) @ np.cross(b - a, c - a)
        assert np.abs(beyond[face]).max() < 1e-9
        assert (beyond <= 1e-9).all() or (beyond >= -1e-9).all()


# ---------------------------------------------------------------------------------------------- evidence


def test_the_bill_of_materials_is_cyclonedx() -> None:
    import jsonschema
    from referencing import Registry, Resource

    folder = importlib.resources.files("cyclonedx") / "schema" / "_res"
    known = {one.name: json.loads(one.read_text()) for one in folder.iterdir() if one.name.endswith(".json")}
    schema = known["bom-1.6.SNAPSHOT.schema.json"]
    others = [(s["$id"], Resource.from_contents(s)) for s in known.values() if "$id" in s]
    for kind in ("plain", "adaptive"):
        controller = controller_of(kind)
        found = data_of(made(kind), "bill")
        jsonschema.Draft7Validator(schema, registry=Registry().with_resources(others)).validate(found)
        assert found == bill(controller)
        hashes = {one["name"]: one["hashes"][0]["content"] for one in found["components"] if one["type"] == "file"}
        assert hashes == {name: hashlib.sha256(data).hexdigest() for name, data in controller.files.items()}


def test_the_table_of_misra_is_that_of_the_documentation() -> None:
    rows = re.findall(r"^\| (\d+\.\d+) \| (\w+) \| (.*) \| (.*) \|$", (ROOT / "docs" / "c.md").read_text(), re.M)
    assert rows == [(d.rule, d.kind, d.where, d.why) for d in DEVIATIONS.values()]


def test_what_was_run_is_told_as_it_came_out(tool: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The checker's own words; of a C that is another the checker and the comparison say no, and so does the page."""
    from dataclasses import replace

    from stt_codegen.report.evidence import evidence

    for name in ("gcc", "clang", "cppcheck"):
        tool(name)
    assert "yes: omni_s2: P1 to P7 hold" in made("plain")
    controller = controller_of("plain")
    text = controller.files["omni_s2.c"]
    bend = b"least = room * 0.005F", b"least = room * 0.006F"
    assert text.count(bend[0]) == 1
    bent = replace(controller, files={**controller.files, "omni_s2.c": text.replace(*bend)})
    found = evidence(bent, ROOT / "tasks" / "omni_s2.toml")
    said = {one.name: one.good for one in found.checks}
    assert said["stand-alone checker"] is False
    assert said["compiled C beside an independent reference"] is False
    assert not found.good
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    without = evidence(controller, None)
    assert {one.good for one in without.checks} == {None}
    assert without.misra is None


# ---------------------------------------------------------------------------------------------- the C that is driven


def native(controller: Controller, folder: Path) -> Any:
    """`loop_own_step` of the same C, compiled for this machine."""
    files, _ = shipped(controller)
    for name, data in files.items():
        (folder / name).write_bytes(data)
    (folder / "adapter.c").write_text(adapter_source(controller.task, controller.design.stateful, controller.certificate))
    sources = ["adapter.c", *driven_sources(controller.task)]
    command = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", *sources, "-o", "own.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "own.so")).loop_own_step


def points_of(controller: Controller, count: int = 2000) -> list[list[float]]:
    """t, then the state: inside, at edges, outside, far, and what is no number."""
    n, order, t_c = controller.task.dimension, controller.task.order, float(controller.task.prescribed_time)
    chance = np.random.default_rng(7)
    grid = np.linspace(0, t_c, SAMPLES + 1)
    low, high = tube_at(controller.design, grid)
    found = []
    for k in chance.integers(0, SAMPLES, count).tolist():
        x = (low[k] + (high[k] - low[k]) * chance.uniform(-0.05, 1.05, n)).tolist()
        v = chance.normal(0, 0.3, n).tolist() if order == 2 else []
        found.append([float(grid[k]), *x, *v])
    odd = [0.0, -0.0, 1e-45, -1e-38, 1e30, -1e30, np.inf, -np.inf, np.nan, 1e300]
    found += [[a, *[b] * (n * order)] for a in [0.0, t_c, -1.0, 2 * t_c, np.nan, np.inf] for b in odd]
    return found


BITS = """([wasm, points, numbers]) => {
  const bytes = Uint8Array.from(atob(wasm), (c) => c.charCodeAt(0));
  const own = new WebAssembly.Instance(new WebAssembly.Module(bytes), {}).exports;
  const at = own.report_room_address(), found = [];
  for (const hex of points) {
    const room = new DataView(own.memory.buffer, at);
    for (let k = 0; k < hex.length - 1; k++) room.setBigUint64(8 * k, BigInt('0x' + hex[k + 1]), true);
    const t = new DataView(new ArrayBuffer(8));
    t.setBigUint64(0, BigInt('0x' + hex[0]), true);
    const status = own.loop_own_step(t.getFloat64(0, true), at, at + 1024);
    const u = new DataView(own.memory.buffer, at + 1024);
    found.push([status, ...Array.from({ length: numbers }, (_, k) => u.getBigUint64(8 * k, true).toString(16))]);
  }
  return found;
}"""


def bits(value: float) -> str:
    return format(struct.unpack("<Q", struct.pack("<d", value))[0], "x")


@pytest.mark.parametrize("kind", ["plain", "double", "three dimensions, order 2", "for ever", "hold"])
def test_the_browser_computes_what_the_c_computes_bit_for_bit(kind: str, browser: Any, tool: Any, tmp_path: Path) -> None:
    tool("gcc"), tool("clang"), tool("wasm-ld")
    controller = controller_of(kind)
    n = controller.task.dimension
    drive = data_of(made(kind))["drive"]
    step = native(controller, tmp_path)
    points = points_of(controller)
    expected = []
    for t, *state in points:
        u = (ctypes.c_double * n)()
        status = step(ctypes.c_double(t), (ctypes.c_double * len(state))(*state), u)
        expected.append([status, *map(bits, u)])
    blank = browser.new_page()
    found = blank.evaluate(BITS, [drive["wasm"], [[bits(v) for v in p] for p in points], n])
    blank.close()
    assert found == expected
    assert {row[0] for row in found} == {0, 1, 2}


def test_a_controller_that_calls_the_library_has_it_from_the_browser() -> None:
    """What the module of an adaptive tube asks for is in the browser's Math; a refined one asks for nothing."""
    for kind, wanted in (("plain", set()), ("adaptive", {"expf", "powf", "log1pf", "logf"})):
        controller = controller_of(kind)
        module = driven(controller, plant_driven(controller.task)).wasm
        assert {name for name in ("expf", "powf", "log1pf", "logf", "memcpy") if name.encode() in module} == wanted


def test_a_plant_is_driven_as_it_is_proved_about(opened: Any) -> None:
    """`--plant`: the module computes its f and g, and the statements are about it."""
    controller = build(ROOT / "tasks" / "spacecraft.toml")
    plant = plant_of("spacecraft", 3)
    text = page(controller, design_report(controller, 0.0), EXTRAS(ROOT / "tasks" / "spacecraft.toml", plant)).decode()
    assert "The plant is spacecraft" in text
    assert "proved for spacecraft" in text
    assert data_of(text)["drive"]["wasm"] != data_of(made("three dimensions"))["drive"]["wasm"]


def test_without_clang_the_section_says_so_and_the_rest_stands(
    browser: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    controller = controller_of("plain")
    monkeypatch.setattr("stt_codegen.report.drive.CLANG", "no-such-clang")
    path = tmp_path / "page.html"
    path.write_bytes(page(controller, design_report(controller, 0.0)))
    with Open(browser, path) as shown:
        assert "no-such-clang not found; install" in shown.page.inner_text("#drive + p")
        assert shown.page.locator("#arena .now").count() == 1


# ---------------------------------------------------------------------------------------------- what a person sees


@pytest.mark.parametrize("kind", [*KINDS, "moving", "hold"])
def test_a_browser_shows_it_without_a_complaint(kind: str, opened: Any) -> None:
    controller = controller_of(kind)
    n = controller.task.dimension
    with opened(kind) as shown:
        views = shown.page.locator("#plane option").count()
        assert views == n * (n - 1) // 2 + (n == 3)
        for k in range(views):
            shown.look_at(k)
            assert shown.page.locator("#arena svg:not(.paper), #arena canvas").count() == 1
        assert shown.page.locator("#strips .band").count() == n * (3 if controller.task.order == 2 else 1)
        shown.page.click("#play")
        shown.until("document.getElementById('time').value > 5")
        shown.page.click("#drive-on")
        shown.until("document.getElementById('drive-u').textContent !== ''")


@pytest.mark.parametrize("kind", ["plain", "three dimensions, order 2", "literal", "moving"])
def test_everyone_can_read_it(kind: str, opened: Any) -> None:
    """WCAG AA as axe-core checks it, in light and dark, at a phone's width and a desk's, also while it drives."""
    from axe_playwright_python.sync_playwright import Axe

    rules = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]}
    for width, scheme in ((390, "light"), (1280, "dark")):
        with opened(kind, width=width, scheme=scheme, bypass_csp=True) as shown:
            shown.page.click("#drive-on")
            shown.page.click("#play")
            found = Axe().run(shown.page, options=rules).response["violations"]
            assert [(v["id"], [node["html"][:120] for node in v["nodes"]]) for v in found] == []


@pytest.mark.parametrize("kind", ["plain", "missions", "three dimensions, order 2", "moving"])
def test_nothing_is_cut_off_and_no_label_is_over_another(kind: str, opened: Any) -> None:
    places = """() => ['arena', 'strips'].flatMap((id) => [...document.querySelectorAll(`#${id} svg:not(.paper)`)].map((svg) => {
      const texts = [...svg.querySelectorAll('text')].filter((t) => t.textContent && t.getClientRects().length);
      const box = (node) => { const r = node.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; };
      return [box(svg), texts.map((t) => [t.textContent, ...box(t)])];
    }))"""
    for width in (390, 1280, 2560):
        with opened(kind, width=width) as shown:
            assert shown.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
            shown.look_at(shown.page.locator("#plane option").count() - 1)
            for frame, texts in shown.page.evaluate(places):
                for told, *box in texts:
                    assert box[0] >= frame[0] - 1, (width, told)
                    assert box[2] <= frame[2] + 1, (width, told)
                for k, (told, *a) in enumerate(texts):
                    for other, *b in texts[k + 1 :]:
                        assert a[0] >= b[2] or b[0] >= a[2] or a[1] >= b[3] - 2 or b[1] >= a[3] - 2, (width, told, other)


def test_every_control_is_reached_and_worked_by_keyboard(opened: Any) -> None:
    with opened("plain") as shown:
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


def test_the_certificate_leads_to_the_moment(opened: Any) -> None:
    controller = controller_of("plain")
    with opened("plain") as shown:
        for one in controller.certificate.findings:
            if one.time is not None:
                middle = float(sum(one.time) / 2)
                shown.page.locator(f"#certificate ~ .wide tr:has(b:text-is('{one.code}')) button.go").first.click()
                assert shown.page.inner_text("#now") in {
                    f"{float(sum(f.time) / 2):.2f} s" for f in controller.certificate.findings if f.code == one.code and f.time
                }
                assert 0 <= middle <= 9


@pytest.mark.parametrize("kind", ["plain", "three dimensions, order 2", "for ever"])
def test_it_arrives_when_driven_and_says_what_is_proved(kind: str, opened: Any) -> None:
    """At the rate that it begins with, with the wind that is proved towards the nearest edge: never outside, always proved."""
    controller = controller_of(kind)
    with opened(kind) as shown:
        page_ = shown.page
        page_.select_option("#drive-pace", "4")
        if kind == "for ever":  # whose tick is longer than what is proved
            page_.fill("#drive-rate", "3")
        page_.click("#drive-on")
        log = "document.getElementById('drive-log').textContent.includes('in the target, in time')"
        turned = "Number(document.getElementById('time').value) > 1990"
        shown.until(turned if controller.task.repeat else log, 60)
        assert page_.inner_text("#drive-status") == "OK"
        assert page_.inner_text("#drive-state") == "Within what is proved."
        assert "outside" not in page_.inner_text("#drive-log")


def test_a_hand_and_a_wind_leave_what_is_proved(opened: Any) -> None:
    with opened("plain") as shown:
        page_ = shown.page
        page_.click("#drive-on")
        page_.click("#play")
        box = page_.locator(".grip").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page_.mouse.move(x, y)
        page_.mouse.down()
        page_.mouse.move(x + 150, y - 40, steps=4)
        assert "a hand" in page_.inner_text("#drive-state")
        page_.mouse.up()
        page_.click("#drive-again")
        page_.click("#play")
        page_.fill("#drive-wind", "1")
        page_.click("#drive-step")
        assert "wind" in page_.inner_text("#drive-state")
        assert "beyond" in page_.locator("label:has(#drive-wind)").get_attribute("class")


def test_the_papers_own_rule_is_driven_into_a_set(opened: Any) -> None:
    with opened("literal") as shown:
        shown.page.select_option("#drive-pace", "4")
        shown.page.click("#drive-on")
        assert "no sampling period is proved" in shown.page.inner_text("#drive-state")


def test_it_prints(opened: Any, tmp_path: Path) -> None:
    with opened("three dimensions, order 2") as shown:
        data = shown.page.pdf(path=tmp_path / "page.pdf", format="A4")
        assert data.startswith(b"%PDF")
        shown.page.emulate_media(media="print")
        shown.page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
        assert shown.page.locator("#arena svg.paper polygon").count() > 20
        assert shown.page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


# ---------------------------------------------------------------------------------------------- commands


def test_the_command_writes_one_file(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    report(ROOT / "tasks" / "omni_s1.toml")
    assert [p.name for p in tmp_path.iterdir()] == ["omni_s1.report.html"]
    assert "omni_s1.report.html" in capsys.readouterr().out
    with pytest.raises(BadInput, match=r"--out page.pdf: is no page"):
        report(ROOT / "tasks" / "omni_s1.toml", out=Path("page.pdf"))
    with pytest.raises(BadInput, match=r"--board m9: is none of m0, "):
        report(ROOT / "tasks" / "omni_s1.toml", board=["m9"])


def test_a_board_is_told_with_its_counts(tmp_path: Path, tool: Any) -> None:
    tool("arm-none-eabi-gcc"), tool("qemu-system-arm")
    path = tmp_path / "page.html"
    report(ROOT / "tasks" / "omni_s1.toml", out=path, board=["m4f"])
    told = re.search(r"Cortex-M4F, emulated</th><td>yes</td><td>(.*?)</td>", path.read_text())
    assert told is not None
    assert re.search(r"control: \d+ to \d+ instructions, \d+ B of stack", told[1])


def test_a_notebook_opens_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import webbrowser

    import stt_codegen as stt

    opened = list[str]()
    monkeypatch.setattr(webbrowser, "open", opened.append)
    controller = stt.build(ROOT / "tasks" / "omni_s1.toml")
    path = controller.report(tmp_path / "own.html")
    assert path == tmp_path / "own.html"
    assert opened == [path.resolve().as_uri()]
    data = data_of(path.read_text())
    assert base64.b64decode(data["drive"]["wasm"])[:4] == b"\0asm"
    assert controller._repr_png_().startswith(b"\x89PNG")
