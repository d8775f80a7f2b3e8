"""Drive it: the C that ships, in the browser, bit for bit; and what is said of the loop around it."""

from __future__ import annotations

import ctypes
import json
import re
import struct
import subprocess
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stt_codegen import pipeline
from stt_codegen.api import Controller
from stt_codegen.emit.driven import adapter_source, driven_sources
from stt_codegen.loop.simulate import Loop, Scenario
from stt_codegen.pipeline import build
from stt_codegen.plants import plant_of
from stt_codegen.report.figures.design_figures import design_report
from stt_codegen.report.page.drive import compile_drive_module, default_plant, files_for_browser
from stt_codegen.report.page.evidence import evidence
from stt_codegen.report.page.page import page
from stt_codegen.report.page.scene import SAMPLES
from stt_codegen.task.sets.motion import DisplacedSet, possible_sets
from tests.support.controllers import ROOT
from tests.support.pages import OpenPage, controller_of_kind, data_block, report_html

pytestmark = pytest.mark.xdist_group("page")  # one browser, and every page made once


# ---------------------------------------------------------------------------------------------- the C that is driven


def native(controller: pipeline.EmittedController, folder: Path) -> Any:
    """`loop_own_step` of the same C, compiled for this machine."""
    files, _ = files_for_browser(controller)
    for name, data in files.items():
        (folder / name).write_bytes(data)
    (folder / "adapter.c").write_text(adapter_source(controller.task, controller.design, controller.certificate))
    sources = ["adapter.c", *driven_sources(controller.task)]
    command = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", *sources, "-o", "own.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "own.so")).loop_own_step


def points_of(controller: pipeline.EmittedController, count: int = 2000) -> list[list[float]]:
    """t, then the state: inside, at edges, outside, far, and what is no number."""
    n, order, t_c = controller.task.dimension, controller.task.order, float(controller.task.prescribed_time)
    chance = np.random.default_rng(7)
    grid = np.linspace(0, t_c, SAMPLES + 1)
    low, high = controller.design.edges_at(grid)
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
    controller = controller_of_kind(kind)
    n = controller.task.dimension
    drive = data_block(report_html(kind))["drive"]
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
        controller = controller_of_kind(kind)
        module = compile_drive_module(controller, default_plant(controller.task)).wasm
        assert {name for name in ("expf", "powf", "log1pf", "logf", "memcpy") if name.encode() in module} == wanted


def test_a_plant_is_driven_as_it_is_proved_about(open_page: Any) -> None:
    """`--plant`: the module computes its f and g, and the statements are about it."""
    controller = build(ROOT / "tasks" / "spacecraft.toml")
    plant = plant_of("spacecraft", 3)
    text = page(controller, design_report(controller, 0.0), evidence(controller), plant).decode()
    assert "The plant is spacecraft" in text
    assert "proved for spacecraft" in text
    assert data_block(text)["drive"]["wasm"] != data_block(report_html("three dimensions"))["drive"]["wasm"]


def test_without_clang_the_section_says_so_and_the_rest_stands(
    browser: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    controller = controller_of_kind("plain")
    monkeypatch.setattr("stt_codegen.report.page.drive.CLANG", "no-such-clang")
    path = tmp_path / "page.html"
    path.write_bytes(page(controller, design_report(controller, 0.0), evidence(controller)))
    with OpenPage(browser, path) as shown:
        assert "no-such-clang not found; install" in shown.page.inner_text("#drive + p")
        assert shown.page.locator("#arena .now").count() == 1


# ---------------------------------------------------------------------------------------------- laws of the scripts


class Scripts:
    """The page's scripts alone, with a page's data: `loopOf` and what stands in scene.js, to be called."""

    def __init__(self, browser: Any, kind: str) -> None:
        folder = ROOT / "templates" / "report"
        self.page = browser.new_page()
        self.page.set_content("<script id='data' type='application/json'></script>")
        text = json.dumps(data_block(report_html(kind)))
        self.page.evaluate("(text) => { document.getElementById('data').textContent = text; }", text)
        self.page.add_script_tag(content="\n".join((folder / f"{name}.js").read_text() for name in ("scene", "strips", "drive")))

    def run(self, body: str, given: Any = None) -> Any:
        return self.page.evaluate(f"(given) => {{ {body} }}", given)

    def __enter__(self) -> Scripts:
        return self

    def __exit__(self, *_: object) -> None:
        self.page.close()


def test_a_set_may_be_where_the_certificate_takes_it_to_be(browser: Any) -> None:
    """With timing and growth: the dashed outline is the hull of all places, grown; and the set stands where it is stated to."""
    task = controller_of_kind("moving").task
    times = [k * 10 / 37 for k in range(38)]
    with Scripts(browser, "moving") as scripts:
        swept = scripts.run("return given.map((t) => swept(data.sets[0], '0,1', [0, 1], t));", times)
        stated = scripts.run("return given.map((t) => displaced(data.sets[0].knots, t));", times)
    course = task.courses[0]
    assert course is not None
    for t, drawn, by in zip(times, swept, stated, strict=True):
        exact = Fraction(t)
        corners = np.array([p for convex in possible_sets(task.unsafe_sets[0], course, exact) for p in convex.projection(0, 1)])
        for axis in (0, 1):
            ends = [p[axis] for p in drawn]
            assert min(ends) == pytest.approx(corners[:, axis].min(), abs=2e-6)  # six digits of six metres
            assert max(ends) == pytest.approx(corners[:, axis].max(), abs=2e-6)
        assert by == pytest.approx([float(v) for v in course.displacement(exact)], abs=1e-12)


def test_a_state_is_in_a_set_where_the_exact_set_says_so(browser: Any) -> None:
    """The body counted, the set where it is stated to be: random states, and the same set as exact fractions."""
    task = controller_of_kind("moving").task
    chance = np.random.default_rng(5)
    points = [[float(t), float(x), float(y)] for t, x, y in chance.uniform([0, 0, 0], [10, 10, 6], (400, 3))]
    with Scripts(browser, "moving") as scripts:
        found = scripts.run("return given.map(([t, ...x]) => inside(data.sets[0], x, t));", points)
    course = task.courses[0]
    assert course is not None
    truth = []
    for t, *x in points:
        here = DisplacedSet(task.obstacles[0], course.displacement(Fraction(t)))
        truth.append(not here.is_apart_from(tuple(map(Fraction, x)), tuple(map(Fraction, x))))
    assert found == truth
    assert 10 < sum(truth) < 390


@pytest.mark.parametrize(("kind", "latency"), [("plain", 0.0), ("plain", 0.004), ("three dimensions, order 2", 0.003)])
def test_the_pages_loop_is_that_of_simulate(kind: str, latency: float, browser: Any) -> None:
    """Without wind and noise both are the same equations under the same C; the float of x may fall the other way here and there,
    which moves u by a few of its own last places, so states agree to a few units of the float's."""
    controller = controller_of_kind(kind)
    files, _ = files_for_browser(controller)
    plant = plant_of("integrator", controller.task.dimension, controller.task.order)
    rate = 400.0
    run = Loop(replace(controller, files=dict(files)), plant).run(Scenario(rate=rate, latency=latency), trace=True)
    assert run.trace is not None
    given = {"period": 1 / rate, "latency": latency, "noise": 0, "wind": 0}
    with Scripts(browser, kind) as scripts:
        drive = "const loop = loopOf(data.drive); loop.begin(0);"
        steps = "for (let k = 0; k < 1600; k++) { loop.step(given); if (k % 100 === 99) found.push([loop.t, ...loop.x]); }"
        found = scripts.run(f"{drive} const found = []; {steps} return found;", given)
    n = controller.task.dimension
    for t, *x in found:
        row = run.trace[round(t * rate)]
        assert row[0] == pytest.approx(t, abs=1e-9)
        assert row[1 : 1 + n] == pytest.approx(x, abs=64 * 2.0**-24 * 8)


def test_alpha_is_where_it_is_however_the_slider_went(browser: Any) -> None:
    """An adaptive tube: u at a time does not depend on what was looked at before, and is the emitted Python's to what the browser's
    exp and log may differ by: the comparison's own bounds are some units in the last place of k xi eps."""
    controller = controller_of_kind("adaptive")
    with Scripts(browser, "adaptive") as scripts:
        body = """const loop = loopOf(data.drive);
        const at = (t) => { loop.begin(t); return [...loop.x, ...loop.u]; };
        const first = at(4.5); at(8); at(1); return [first, at(4.5)];"""
        first, again = scripts.run(body)
    assert first == again
    api = Controller(controller.task, controller.design, controller.program, controller.certificate, controller.files)
    _, u = api.control(4.5, first[:2])
    assert first[2:] == pytest.approx(u.tolist(), rel=2e-2, abs=2e-2)  # in the middle of the tube u is the rounding of e


GOOD = {"period": 0.0005, "latency": 0.0, "noise": 0.0, "wind": 0.0, "kind": "outward"}


def told(browser: Any, kind: str, body: str) -> list[Any]:
    with Scripts(browser, kind) as scripts:
        start = "const loop = loopOf(data.drive); loop.begin(0); const many = (k, how) => { while (k--) loop.step(how); };"
        return list(scripts.run(f"{start} {body}", GOOD))


def test_what_is_proved_comes_back_only_with_a_start(browser: Any) -> None:
    """A shove to where |e| is above the share is not a start; a state that has come back to one is."""
    body = """many(50, given); const before = loop.proved;
    const [low, high] = loop.tube(loop.t); loop.x[0] = high[0] - 0.01 * (high[0] - low[0]); loop.shove(0, 0);
    loop.step({ ...given, period: 1e-6 }); const at = loop.proved;
    many(2000, given); return [before, at, loop.proved, loop.status];"""
    assert told(browser, "plain", body) == [True, False, True, 0]


@pytest.mark.parametrize("kind", ["plain", "for ever", "adaptive", "literal"])
def test_what_is_said_at_the_beginning_is_said_after_calm_samples_too(browser: Any, kind: str) -> None:
    """The reader may look before or after the first frame of the animation: why nothing is proved must not depend on that."""
    # A task may name a period beyond what is proved for it; the proved one, where there is one, is the calm sample's.
    body = """const first = loop.broken, period = data.drive.proved ? data.drive.proved.period : data.drive.period;
    many(3, { ...given, period }); return [first, loop.broken];"""
    first, later = told(browser, kind, body)
    assert first == later
    assert bool(first) == (kind in ("adaptive", "literal"))


def test_a_loop_that_was_stopped_is_proved_no_more(browser: Any) -> None:
    body = """many(20, given); loop.shove(0, 3); loop.step(given); loop.shove(0, -3); many(20, given);
    return [loop.proved, loop.status, loop.broken];"""
    assert told(browser, "stop", body) == [False, 1, "outside the tube"]


def test_a_delay_within_what_is_proved_does_not_end_it_for_ever(browser: Any) -> None:
    """Some samples after a shove all inputs are of samples that were starts; before that they are not."""
    late = "{ ...given, latency: data.drive.proved.latency }"
    body = f"""many(50, {late}); const before = loop.proved; loop.shove(0, 0.001); loop.step({late}); const at = loop.proved;
    many(50, {late}); return [before, at, loop.proved];"""
    assert told(browser, "three dimensions, order 2", body) == [True, False, True]


def test_every_assumption_is_named_when_it_is_broken(browser: Any) -> None:
    body = """const found = []; for (const [name, value] of [["period", 1], ["latency", 1], ["noise", 1], ["wind", 100]]) {
    loop.begin(0); loop.step({ ...given, [name]: value }); found.push(loop.broken.split(", ")[0]); } return found;"""
    assert told(browser, "plain", body) == ["samples too rare", "delay", "noise", "wind"]


def test_the_wind_blows_as_it_is_said_to(browser: Any) -> None:
    """Towards the nearest edge, in a direction, at random: of the size that is asked, and what the plant gets."""
    body = """const [low, high] = loop.tube(0), found = [];
    for (const [i, share] of [[0, 0.9], [0, 0.1], [1, 0.8], [1, 0.2]]) {
      loop.x = low.map((v, k) => v + (k === i ? share : 0.5) * (high[k] - v));
      loop.step({ ...given, wind: 0.2 }); found.push([...loop.w]);
    }
    loop.step({ ...given, wind: 0.2, kind: "constant", angle: Math.PI / 2, plane: [0, 1] }); found.push([...loop.w]);
    loop.step({ ...given, wind: 0.2, kind: "random" }); found.push([Math.hypot(...loop.w), 0]);
    loop.begin(0); const x = [...loop.x]; const rest = [...loop.u];
    loop.step({ ...given, wind: 3 }); const moved = loop.x.map((v, k) => (v - x[k]) / given.period - rest[k]);
    return [...found, moved.map((v, k) => v - loop.w[k])];"""
    *found, error = told(browser, "plain", body)
    wanted = [[0.2, 0], [-0.2, 0], [0, 0.2], [0, -0.2], [0, 0.2], [0.2, 0]]
    assert np.array(found) == pytest.approx(np.array(wanted), abs=1e-12)
    assert error == pytest.approx([0, 0], abs=1e-9)


def test_the_band_of_v_holds_every_v_that_the_tubes_leave(browser: Any) -> None:
    """x at an edge of its tube and v + lambda x at one of its own: v between the band's edges, and at them in the extremes."""
    with Scripts(browser, "three dimensions, order 2") as scripts:
        speeds = scripts.run("return stripsOf()[1].map((one) => [one.low, one.high, one.i]);")
    data = data_block(report_html("three dimensions, order 2"))
    x = [np.array(data[name]) for name in ("low", "high")]
    z = [np.array(data["filtered"][name]) for name in ("low", "high")]
    assert [i for *_, i in speeds] == [0, 1, 2]
    for low, high, i in speeds:
        v = np.array([a[:, i] - data["filtered"]["lambda"][i] * b[:, i] for a in z for b in x])
        assert np.array(low)[:, i] == pytest.approx(v.min(axis=0), abs=1e-12)
        assert np.array(high)[:, i] == pytest.approx(v.max(axis=0), abs=1e-12)


def test_who_comes_late_is_told_so(browser: Any) -> None:
    body = """loop.begin(8.9); loop.hold([[0, 1], [1, 1]]); many(1000, given); loop.release();
    const [low, high] = loop.tube(9); loop.x = [0, 1].map((i) => (low[i] + high[i]) / 2); many(10, given);
    return loop.log.map(([, text]) => text).filter((text) => text.includes("target"));"""
    first, late = told(browser, "plain", body)
    assert first == "not in the target at the prescribed time"
    assert re.fullmatch(r"in the target, 0\.4\d* s late", late)


# ---------------------------------------------------------------------------------------------- in the page


WIND = """(w) => {
  const slider = document.getElementById('drive-wind');
  for (let k = 0; k <= 100; k++) {
    slider.value = String((100 - k) / 100);
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    if (!slider.closest('label').classList.contains('beyond')) return;
  }
}"""  # the strongest that is proved


@pytest.mark.parametrize("kind", ["plain", "three dimensions, order 2"])
def test_it_arrives_when_driven_and_says_what_is_proved(kind: str, open_page: Any) -> None:
    """At the rate that it begins with, with the wind that is proved towards the nearest edge: never outside, always proved."""
    with open_page(kind) as shown:
        shown.page.select_option("#drive-pace", "4")
        shown.page.select_option("#drive-kind", "outward")
        shown.page.evaluate(WIND)
        shown.page.click("#drive-on")
        shown.wait_until("document.getElementById('drive-log').textContent.includes('in the target, in time')", 60)
        assert shown.page.inner_text("#drive-status") == "OK"
        assert shown.page.inner_text("#drive-state") == "Within what is proved."
        assert "outside" not in shown.page.inner_text("#drive-log")


def test_it_goes_on_for_ever(browser: Any) -> None:
    """Over three cycles at the proved period: inside, and within what is proved, at every sample."""
    body = """const how = { ...given, period: data.drive.proved.period }; let least = 1, always = true;
    const end = data.t_c + 2 * (data.cycle[1] - data.cycle[0]);
    while (loop.t < end) { loop.step(how); least = Math.min(least, loop.margin); always = always && loop.proved; }
    return [always, least > 0, loop.log.length];"""
    assert told(browser, "for ever", body) == [True, True, 0]


def test_a_hand_and_a_wind_leave_what_is_proved(open_page: Any) -> None:
    with open_page("plain") as shown:
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


def test_the_papers_own_rule_is_driven_into_a_set(open_page: Any) -> None:
    """Begun where the tube meets O3, at a corner of it that is in the set."""
    with open_page("literal") as shown:
        name, begin, end, sure = data_block(report_html("literal"))["meets"][0]
        assert sure
        shown.page.click("#drive-on")
        assert "no sampling period is proved" in shown.page.inner_text("#drive-state")
        shown.page.locator("button.go").first.click()
        assert shown.page.inner_text("#now") == f"{(begin + end) / 2:.2f} s"
        for key in ("ArrowRight", "ArrowUp", "ArrowLeft", "ArrowDown"):
            for _ in range(8):
                shown.page.focus(".grip")
                shown.page.keyboard.press(key)
        assert f"in unsafe set {name}" in shown.page.inner_text("#drive-log")
