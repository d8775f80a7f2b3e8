"""The section "drive it" of the report: the shipped C runs in the browser bit for bit, and the page reports what is proved of its loop."""

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
from stt_codegen.report.page.drive import SliderNoise, compile_drive_module, default_plant, files_for_browser, slider_noise
from stt_codegen.report.page.evidence import evidence
from stt_codegen.report.page.page import page
from stt_codegen.report.page.scene import SAMPLES
from stt_codegen.task.sets.motion import DisplacedSet, possible_sets
from tests.support.controllers import ROOT
from tests.support.pages import OpenPage, controller_of_kind, data_block, report_html

pytestmark = pytest.mark.xdist_group("page")  # a worker starts one browser and builds every page once


# ---------------------------------------------------------------------------------------------- the C that is driven


def native_step(controller: pipeline.EmittedController, folder: Path) -> Any:
    """Return the function `loop_own_step` of the same C, compiled for this machine."""
    files, _ = files_for_browser(controller)
    for name, data in files.items():
        (folder / name).write_bytes(data)
    (folder / "adapter.c").write_text(adapter_source(controller.task, controller.design, controller.certificate))
    sources = ["adapter.c", *driven_sources(controller.task)]
    command = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", *sources, "-o", "driven.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "driven.so")).loop_own_step


def points_of(controller: pipeline.EmittedController, count: int = 2000) -> list[list[float]]:
    """Return points (t, state..) inside and outside the tube, near its edges, far away, and with values that are not finite."""
    n, order, t_c = controller.task.dimension, controller.task.order, float(controller.task.prescribed_time)
    chance = np.random.default_rng(7)
    grid = np.linspace(0, t_c, SAMPLES + 1)
    low, high = controller.design.edges_at(grid)
    points = []
    for k in chance.integers(0, SAMPLES, count).tolist():
        x = (low[k] + (high[k] - low[k]) * chance.uniform(-0.05, 1.05, n)).tolist()
        v = chance.normal(0, 0.3, n).tolist() if order == 2 else []
        points.append([float(grid[k]), *x, *v])
    special_values = [0.0, -0.0, 1e-45, -1e-38, 1e30, -1e30, np.inf, -np.inf, np.nan, 1e300]
    points += [[a, *[b] * (n * order)] for a in [0.0, t_c, -1.0, 2 * t_c, np.nan, np.inf] for b in special_values]
    return points


RUN_STEPS = """([wasm, points, numbers]) => {
  const bytes = Uint8Array.from(atob(wasm), (c) => c.charCodeAt(0));
  const driven = new WebAssembly.Instance(new WebAssembly.Module(bytes), {}).exports;
  const address = driven.report_buffer_address(), outputs = [];
  for (const hex of points) {
    const state = new DataView(driven.memory.buffer, address);
    for (let k = 0; k < hex.length - 1; k++) state.setBigUint64(8 * k, BigInt('0x' + hex[k + 1]), true);
    const t = new DataView(new ArrayBuffer(8));
    t.setBigUint64(0, BigInt('0x' + hex[0]), true);
    const status = driven.loop_own_step(t.getFloat64(0, true), address, address + 1024);
    const u = new DataView(driven.memory.buffer, address + 1024);
    outputs.push([status, ...Array.from({ length: numbers }, (_, k) => u.getBigUint64(8 * k, true).toString(16))]);
  }
  return outputs;
}"""


def hex_bits(value: float) -> str:
    return format(struct.unpack("<Q", struct.pack("<d", value))[0], "x")


@pytest.mark.parametrize("kind", ["plain", "double", "three dimensions, order 2", "for ever", "hold"])
def test_the_browser_computes_the_c_bit_for_bit(kind: str, browser: Any, tool: Any, tmp_path: Path) -> None:
    tool("gcc"), tool("clang"), tool("wasm-ld")
    controller = controller_of_kind(kind)
    n = controller.task.dimension
    drive = data_block(report_html(kind))["drive"]
    step = native_step(controller, tmp_path)
    points = points_of(controller)
    expected = []
    for t, *state in points:
        u = (ctypes.c_double * n)()
        status = step(ctypes.c_double(t), (ctypes.c_double * len(state))(*state), u)
        expected.append([status, *map(hex_bits, u)])
    blank = browser.new_page()
    computed = blank.evaluate(RUN_STEPS, [drive["wasm"], [[hex_bits(v) for v in p] for p in points], n])
    blank.close()
    assert computed == expected
    assert {row[0] for row in computed} == {0, 1, 2}


def test_an_adaptive_controller_takes_its_mathematics_from_the_browser() -> None:
    """The browser's Math has the functions that the module of an adaptive tube imports; the module of a refined tube imports none."""
    for kind, imports in (("plain", set()), ("adaptive", {"expf", "powf", "log1pf", "logf"})):
        controller = controller_of_kind(kind)
        module = compile_drive_module(controller, default_plant(controller.task)).wasm
        assert {name for name in ("expf", "powf", "log1pf", "logf", "memcpy") if name.encode() in module} == imports


def test_the_page_drives_the_plant_that_its_statements_are_about(open_page: Any) -> None:
    """`--plant`: the module computes its f and g, and the statements are about it."""
    controller = build(ROOT / "tasks" / "spacecraft.toml")
    plant = plant_of("spacecraft", 3)
    text = page(controller, design_report(controller, 0.0), evidence(controller), plant).decode()
    assert "The plant is spacecraft" in text
    assert "proved for spacecraft" in text
    assert data_block(text)["drive"]["wasm"] != data_block(report_html("three dimensions"))["drive"]["wasm"]


def test_without_clang_only_the_driven_section_is_missing(browser: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    controller = controller_of_kind("plain")
    monkeypatch.setattr("stt_codegen.report.page.drive.CLANG", "no-such-clang")
    path = tmp_path / "page.html"
    path.write_bytes(page(controller, design_report(controller, 0.0), evidence(controller)))
    with OpenPage(browser, path) as opened_page:
        assert "no-such-clang not found; install" in opened_page.page.inner_text("#drive + p")
        assert opened_page.page.locator("#arena .now").count() == 1


# ---------------------------------------------------------------------------------------------- laws of the scripts


class Scripts:
    """The page's scripts with the data of a page, but without the page: `createLoop` and the functions of scene.js can be called."""

    def __init__(self, browser: Any, kind: str) -> None:
        folder = ROOT / "templates" / "report"
        self.page = browser.new_page()
        self.page.set_content("<script id='data' type='application/json'></script>")
        text = json.dumps(data_block(report_html(kind)))
        self.page.evaluate("(text) => { document.getElementById('data').textContent = text; }", text)
        self.page.add_script_tag(content="\n".join((folder / f"{name}.js").read_text() for name in ("scene", "strips", "drive")))

    def run(self, body: str, argument: Any = None) -> Any:
        """Run a body of JavaScript with the argument `argument`, and return its value."""
        return self.page.evaluate(f"(argument) => {{ {body} }}", argument)

    def __enter__(self) -> Scripts:
        return self

    def __exit__(self, *_: object) -> None:
        self.page.close()


def test_the_outline_of_a_moving_set_covers_its_timing_uncertainty(browser: Any) -> None:
    """The dashed outline is the hull of all possible positions with growth. The set itself is drawn at its stated position."""
    task = controller_of_kind("moving").task
    times = [k * 10 / 37 for k in range(38)]
    with Scripts(browser, "moving") as scripts:
        swept = scripts.run("return argument.map((t) => possibleOutline(data.sets[0], '0,1', [0, 1], t));", times)
        stated = scripts.run("return argument.map((t) => displacementAt(data.sets[0].knots, t));", times)
    course = task.courses[0]
    assert course is not None
    for t, drawn, displacement in zip(times, swept, stated, strict=True):
        exact = Fraction(t)
        corners = np.array([p for convex in possible_sets(task.unsafe_sets[0], course, exact) for p in convex.projection(0, 1)])
        for axis in (0, 1):
            ends = [p[axis] for p in drawn]
            assert min(ends) == pytest.approx(corners[:, axis].min(), abs=2e-6)  # six digits of up to six metres
            assert max(ends) == pytest.approx(corners[:, axis].max(), abs=2e-6)
        assert displacement == pytest.approx([float(v) for v in course.displacement(exact)], abs=1e-12)


def test_the_page_decides_collisions_as_the_exact_sets_do(browser: Any) -> None:
    """Random states are compared with the set in exact fractions, at its stated position and grown by the body."""
    task = controller_of_kind("moving").task
    chance = np.random.default_rng(5)
    points = [[float(t), float(x), float(y)] for t, x, y in chance.uniform([0, 0, 0], [10, 10, 6], (400, 3))]
    with Scripts(browser, "moving") as scripts:
        is_inside = scripts.run("return argument.map(([t, ...x]) => isInSet(data.sets[0], x, t));", points)
    course = task.courses[0]
    assert course is not None
    expected = []
    for t, *x in points:
        displaced = DisplacedSet(task.obstacles[0], course.displacement(Fraction(t)))
        expected.append(not displaced.is_apart_from(tuple(map(Fraction, x)), tuple(map(Fraction, x))))
    assert is_inside == expected
    assert 10 < sum(expected) < 390


@pytest.mark.parametrize(("kind", "latency"), [("plain", 0.0), ("plain", 0.004), ("three dimensions, order 2", 0.003)])
def test_the_loop_of_the_page_agrees_with_simulate(kind: str, latency: float, browser: Any) -> None:
    """Without wind and noise both loops have the same equations and the same C. Rounding of x to a float may differ, which changes u by
    a few units in its last place, so that states agree to a few units of a float."""
    controller = controller_of_kind(kind)
    files, _ = files_for_browser(controller)
    plant = plant_of("integrator", controller.task.dimension, controller.task.order)
    rate = 400.0
    run = Loop(replace(controller, files=dict(files)), plant).run(Scenario(rate=rate, latency=latency), trace=True)
    assert run.trace is not None
    options = {"period": 1 / rate, "latency": latency, "noise": 0, "wind": 0}
    with Scripts(browser, kind) as scripts:
        drive = "const loop = createLoop(data.drive); loop.begin(0);"
        steps = "for (let k = 0; k < 1600; k++) { loop.step(argument); if (k % 100 === 99) samples.push([loop.t, ...loop.x]); }"
        samples = scripts.run(f"{drive} const samples = []; {steps} return samples;", options)
    n = controller.task.dimension
    for t, *x in samples:
        row = run.trace[round(t * rate)]
        assert row[0] == pytest.approx(t, abs=1e-9)
        assert row[1 : 1 + n] == pytest.approx(x, abs=64 * 2.0**-24 * 8)


def test_alpha_does_not_depend_on_the_path_of_the_slider(browser: Any) -> None:
    """For an adaptive tube u at a time does not depend on times that were shown before. It agrees with the emitted Python up to the
    errors of the browser's exp and log."""
    controller = controller_of_kind("adaptive")
    with Scripts(browser, "adaptive") as scripts:
        body = """const loop = createLoop(data.drive);
        const at = (t) => { loop.begin(t); return [...loop.x, ...loop.u]; };
        const first = at(4.5); at(8); at(1); return [first, at(4.5)];"""
        first, repeated = scripts.run(body)
    assert first == repeated
    api = Controller(controller.task, controller.design, controller.program, controller.certificate, controller.files)
    _, u = api.control(4.5, first[:2])
    assert first[2:] == pytest.approx(u.tolist(), rel=2e-2, abs=2e-2)  # in the middle of the tube u is the rounding of e


OPTIONS = {"period": 0.0005, "latency": 0.0, "noise": 0.0, "wind": 0.0, "kind": "outward"}


def run_loop(browser: Any, kind: str, body: str) -> list[Any]:
    """Run a body of JavaScript on the loop of a page, and return its values; `many(k, how)` takes k steps with options."""
    with Scripts(browser, kind) as scripts:
        start = "const loop = createLoop(data.drive); loop.begin(0); const many = (k, how) => { while (k--) loop.step(how); };"
        return list(scripts.run(f"{start} {body}", OPTIONS))


def test_after_a_shove_the_proof_holds_again_from_a_covered_start(browser: Any) -> None:
    """A shove takes |e| above the start share, where the proof does not hold; it holds again once the state is back within the share."""
    body = """many(50, argument); const before = loop.proved;
    const [low, high] = loop.tube(loop.t); loop.x[0] = high[0] - 0.01 * (high[0] - low[0]); loop.shove(0, 0);
    loop.step({ ...argument, period: 1e-6 }); const at = loop.proved;
    many(2000, argument); return [before, at, loop.proved, loop.status];"""
    assert run_loop(browser, "plain", body) == [True, False, True, 0]


@pytest.mark.parametrize("kind", ["plain", "for ever", "adaptive", "literal"])
def test_the_reason_why_nothing_is_proved_is_there_before_the_first_frame(browser: Any, kind: str) -> None:
    """A reader sees the same reason before and after the first frame of the animation."""
    # A task may state a period that is longer than proved; samples at the proved one, if there is one, break no assumption.
    body = """const first = loop.unprovedReason, period = data.drive.proved ? data.drive.proved.period : data.drive.period;
    many(3, { ...argument, period }); return [first, loop.unprovedReason];"""
    first, later = run_loop(browser, kind, body)
    assert first == later
    assert bool(first) == (kind in ("adaptive", "literal"))


def test_a_stopped_loop_is_no_longer_proved(browser: Any) -> None:
    body = """many(20, argument); loop.shove(0, 3); loop.step(argument); loop.shove(0, -3); many(20, argument);
    return [loop.proved, loop.status, loop.unprovedReason];"""
    assert run_loop(browser, "stop", body) == [False, 1, "outside the tube"]


def test_with_a_proved_delay_the_proof_holds_again_some_samples_after_a_shove(browser: Any) -> None:
    """Then all inputs are of samples after the shove, each of which is a covered start."""
    late = "{ ...argument, latency: data.drive.proved.latency }"
    body = f"""many(50, {late}); const before = loop.proved; loop.shove(0, 0.001); loop.step({late}); const at = loop.proved;
    many(50, {late}); return [before, at, loop.proved];"""
    assert run_loop(browser, "three dimensions, order 2", body) == [True, False, True]


def test_every_assumption_is_named_when_it_is_broken(browser: Any) -> None:
    body = """const reasons = []; for (const [name, value] of [["period", 1], ["latency", 1], ["noise", 1], ["wind", 100]]) {
    loop.begin(0); loop.step({ ...argument, [name]: value }); reasons.push(loop.unprovedReason.split(", ")[0]); } return reasons;"""
    assert run_loop(browser, "plain", body) == ["samples too rare", "delay", "noise", "wind"]


@pytest.mark.parametrize(
    ("noise", "noise_v", "slider"),
    [
        ("0.001", "0.02", SliderNoise(0.001, 1.0, 20.0)),
        ("0.001", None, SliderNoise(0.001, 1.0, 0.0)),
        (None, "0.02", SliderNoise(0.02, 0.0, 1.0)),
        (None, None, SliderNoise(0.0, 1.0, 1.0)),
    ],
)
def test_the_slider_of_noise_has_the_bounds_of_the_task(
    noise: str | None, noise_v: str | None, slider: SliderNoise, browser: Any
) -> None:
    """At its proved value the slider draws errors of x and v up to [plant] noise and noise_v, also where only v has noise."""
    task = controller_of_kind("three dimensions, order 2").task
    changed = {"noise": noise and Fraction(noise), "noise_v": noise_v and Fraction(noise_v)}
    assert slider_noise(task.model_copy(update={"plant": task.plant.model_copy(update=changed)})) == pytest.approx(slider)
    body = f"""data.drive.x_noise_ratio = {slider.x_ratio}; data.drive.v_noise_ratio = {slider.v_ratio};
    const errors = new Array(6).fill(0), control = loop.control;
    loop.control = (t, measured) => {{
      measured.forEach((value, k) => {{ errors[k] = Math.max(errors[k], Math.abs(value - [...loop.x, ...loop.v][k])); }});
      return control(t, measured);
    }};
    many(300, {{ ...argument, noise: {slider.largest} }}); return errors;"""
    errors = np.array(run_loop(browser, "three dimensions, order 2", body))
    bounds = np.repeat([float(noise or 0), float(noise_v or 0)], 3)
    assert (errors <= bounds * (1 + 1e-9)).all()
    assert (errors >= 0.9 * bounds).all()


def test_the_wind_has_the_stated_size_and_direction(browser: Any) -> None:
    """Wind is toward the nearest edge, in a direction or at random. It has the stated size, and the plant moves by it."""
    body = """const [low, high] = loop.tube(0), winds = [];
    for (const [i, share] of [[0, 0.9], [0, 0.1], [1, 0.8], [1, 0.2]]) {
      loop.x = low.map((v, k) => v + (k === i ? share : 0.5) * (high[k] - v));
      loop.step({ ...argument, wind: 0.2 }); winds.push([...loop.w]);
    }
    loop.step({ ...argument, wind: 0.2, kind: "constant", angle: Math.PI / 2, plane: [0, 1] }); winds.push([...loop.w]);
    loop.step({ ...argument, wind: 0.2, kind: "random" }); winds.push([Math.hypot(...loop.w), 0]);
    loop.begin(0); const x = [...loop.x]; const rest = [...loop.u];
    loop.step({ ...argument, wind: 3 }); const moved = loop.x.map((v, k) => (v - x[k]) / argument.period - rest[k]);
    return [...winds, moved.map((v, k) => v - loop.w[k])];"""
    *winds, error = run_loop(browser, "plain", body)
    expected = [[0.2, 0], [-0.2, 0], [0, 0.2], [0, -0.2], [0, 0.2], [0.2, 0]]
    assert np.array(winds) == pytest.approx(np.array(expected), abs=1e-12)
    assert error == pytest.approx([0, 0], abs=1e-9)


def test_the_band_of_v_is_the_range_that_both_tubes_allow(browser: Any) -> None:
    """With x and v + lambda x at edges of their tubes, v is within the band, and the extreme values are its edges."""
    with Scripts(browser, "three dimensions, order 2") as scripts:
        speeds = scripts.run("return stripGroups()[1].map((one) => [one.low, one.high, one.i]);")
    data = data_block(report_html("three dimensions, order 2"))
    x = [np.array(data[name]) for name in ("low", "high")]
    z = [np.array(data["filtered"][name]) for name in ("low", "high")]
    assert [i for *_, i in speeds] == [0, 1, 2]
    for low, high, i in speeds:
        v = np.array([a[:, i] - data["filtered"]["lambda"][i] * b[:, i] for a in z for b in x])
        assert np.array(low)[:, i] == pytest.approx(v.min(axis=0), abs=1e-12)
        assert np.array(high)[:, i] == pytest.approx(v.max(axis=0), abs=1e-12)


def test_the_log_says_how_late_the_target_is_reached(browser: Any) -> None:
    body = """loop.begin(8.9); loop.hold([[0, 1], [1, 1]]); many(1000, argument); loop.release();
    const [low, high] = loop.tube(9); loop.x = [0, 1].map((i) => (low[i] + high[i]) / 2); many(10, argument);
    return loop.log.map(([, text]) => text).filter((text) => text.includes("target"));"""
    missed, late = run_loop(browser, "plain", body)
    assert missed == "not in the target at the prescribed time"
    assert re.fullmatch(r"in the target, 0\.4\d* s late", late)


# ---------------------------------------------------------------------------------------------- in the page


SET_STRONGEST_PROVED_WIND = """(w) => {
  const slider = document.getElementById('drive-wind');
  for (let k = 0; k <= 100; k++) {
    slider.value = String((100 - k) / 100);
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    if (!slider.closest('label').classList.contains('beyond')) return;
  }
}"""


@pytest.mark.parametrize("kind", ["plain", "three dimensions, order 2"])
def test_a_driven_page_arrives_within_what_is_proved(kind: str, open_page: Any) -> None:
    """At the initial rate, with the proved wind toward the nearest edge, the state stays in the tube and within the proof."""
    with open_page(kind) as opened_page:
        opened_page.page.select_option("#drive-pace", "4")
        opened_page.page.select_option("#drive-kind", "outward")
        opened_page.page.evaluate(SET_STRONGEST_PROVED_WIND)
        opened_page.page.click("#drive-on")
        opened_page.wait_until("document.getElementById('drive-log').textContent.includes('in the target, in time')", 60)
        assert opened_page.page.inner_text("#drive-status") == "OK"
        assert opened_page.page.inner_text("#drive-state") == "Within what is proved."
        assert "outside" not in opened_page.page.inner_text("#drive-log")


def test_a_repeated_mission_stays_proved_over_three_cycles(browser: Any) -> None:
    """At the proved period every sample is inside the tube and within the proof."""
    body = """const how = { ...argument, period: data.drive.proved.period }; let smallest = 1, always = true;
    const end = data.t_c + 2 * (data.cycle[1] - data.cycle[0]);
    while (loop.t < end) { loop.step(how); smallest = Math.min(smallest, loop.margin); always = always && loop.proved; }
    return [always, smallest > 0, loop.log.length];"""
    assert run_loop(browser, "for ever", body) == [True, True, 0]


def test_a_drag_by_hand_and_a_strong_wind_are_reported_as_not_proved(open_page: Any) -> None:
    with open_page("plain") as opened_page:
        page_ = opened_page.page
        page_.click("#drive-on")
        page_.click("#play")
        box = page_.locator(".handle").bounding_box()
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


def test_the_literal_design_can_be_driven_into_an_unsafe_set(open_page: Any) -> None:
    """The drive begins where the tube meets O3, and moves to a corner of the tube in the set."""
    with open_page("literal") as opened_page:
        name, begin, end, sure = data_block(report_html("literal"))["meets"][0]
        assert sure
        opened_page.page.click("#drive-on")
        assert "no sampling period is proved" in opened_page.page.inner_text("#drive-state")
        opened_page.page.locator("button.go-to-time").first.click()
        assert opened_page.page.inner_text("#now") == f"{(begin + end) / 2:.2f} s"
        for key in ("ArrowRight", "ArrowUp", "ArrowLeft", "ArrowDown"):
            for _ in range(8):
                opened_page.page.focus(".handle")
                opened_page.page.keyboard.press(key)
        assert f"in unsafe set {name}" in opened_page.page.inner_text("#drive-log")
