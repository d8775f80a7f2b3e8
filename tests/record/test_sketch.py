"""Time in the example sketches: tube time follows the clock, however long a step takes, and `late` marks a gap that is not proved.

The sketch runs with a micros() that jumps, overflows at 2^32 and advances while a step computes. The controller is a stub that prints
the time of each call; guards and the wrap of repeated missions are the emitted C.
"""

from __future__ import annotations

import itertools
import subprocess
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from stt_codegen.certify.missions.proof import cycle_of
from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput
from stt_codegen.files import write_files
from stt_codegen.pipeline import EmittedController
from stt_codegen.record.package import package
from stt_codegen.record.sketch import MICROS_RESOLUTION, LoopTimes, loop_times, sketch_notes
from stt_codegen.record.uno import RELATIVE_ERROR, step_cycles
from stt_codegen.task.load import load_task
from tests.support.controllers import ROOT, build_once

POLL = 4  # microseconds that a call of the harness's micros() takes
US = Fraction(1, 10**6)
VARIANTS: dict[str, tuple[str, dict[str, Any], str]] = {
    "seconds": ("crawler", {"emit": {"tick_period": None}}, "refined"),
    "microseconds": ("omni_s2", {"control": {"gain": "1000"}}, "refined"),  # its proved period is shorter than a loop
    "ticks": ("crawler", {}, "refined"),
    "odd ticks": ("omni_board", {"emit": {"tick_period": "0.0007123"}}, "refined"),
    "integers": ("gantry", {}, "refined"),
    "repeat": ("watchman", {}, "refined"),
    "repeat, seconds": ("watchman", {"emit": {"tick_period": None}, "prescribed_time": "15.90001"}, "refined"),
    "hold": ("omni_board", {"control": {"outside": "hold"}}, "refined"),
    "stop": ("drone", {"control": {"outside": "stop"}, "plant": {"noise": 0.002, "noise_v": 0.01}}, "refined"),
    "adaptive": ("omni_s2", {}, "adaptive"),
    "differences": ("drone", {"control": {"velocity": "differences"}, "plant": {"noise": "0.0001", "noise_v": None}}, "refined"),
}

HARNESS = """#include <math.h>
#include <stdint.h>
#include <stdio.h>
#define LED_BUILTIN 13
#define OUTPUT 1
#define HIGH 1
#define LOW 0
static const uint64_t ORIGIN = 4294967296ULL - 3000000ULL;  // micros() turns over three seconds after the start
static uint64_t world = 0, looked, step_cost, drive_cost, idle_cost;
static bool first_look, stepped;
static int led;
static unsigned long micros() {
  if (first_look) { looked = world; first_look = false; }
  const uint64_t now = world;
  world += 4;
  return (unsigned long)(uint32_t)(now + ORIGIN);
}
static int analogRead(int pin) { world += pin == 0 ? step_cost : 0; return 512; }
static void analogWrite(int pin, int) { world += pin == 3 ? drive_cost : 0; }
static void pinMode(int, int) {}
static void digitalWrite(int, int value) { led = value; world += idle_cost; }
template <class T> T constrain(T v, int a, int b) { return v < a ? a : v > b ? b : v; }
#include "sketch.ino"
static double called_at;
extern "C" {
%s
}
int main() {
  setup();
  unsigned long long cost, drives, idle;
  while (scanf("%%llu %%llu %%llu", &cost, &drives, &idle) == 3) {
    step_cost = cost, drive_cost = drives, idle_cost = idle, stepped = false;
    while (!stepped) { first_look = true; loop(); }
    printf("S %%llu %%.17g %%d %%u %%d\\n", (unsigned long long)looked, called_at, late, (unsigned)late_steps, led);
  }
}
"""


@dataclass(frozen=True)
class Step:
    """A sample: the true microseconds since the first one, the time that the controller was called with, and `late` after the call."""

    now: int
    called: float
    late: bool
    late_steps: int
    led: int
    notes: tuple[tuple[str, float, float], ...]  # ("A", t, dt) of alpha steps and ("V", dt, 0) of differences before the sample


@cache
def controller_of_variant(variant: str) -> EmittedController:
    name, changed, design = VARIANTS[variant]
    task = load_task(ROOT / "tasks" / f"{name}.toml").changed(**changed)
    return build_once(task.with_options(design))


def stubs(controller: EmittedController) -> str:
    """Return C stubs of the functions that the controller's header declares; some print or store the time of their call."""
    p, n = controller.task.name, f"{controller.task.name.upper()}_N"
    integers, real = controller.task.emit.scalar == "fixed", f"{p}_real"
    number = "int32_t" if integers else real
    v = f"const {number} v[{n}], " if controller.task.order == 2 else ""
    alpha = f"const {real} alpha[2 * {n}], " if controller.design.is_stateful else ""
    body = f"for (int i = 0; i < {n}; i++) {{ u[i] = 0; }} called_at = (double)t; stepped = true; return {p.upper()}_OK;"
    text = [
        f"{p}_status {p}_control({'uint32_t' if integers else real} t, {alpha}const {number} x[{n}], {v}{number} u[{n}]) {{ {body} }}"
    ]
    if integers:
        text.append(f"int32_t {p}_margin(uint32_t, const int32_t x[{n}]{', const int32_t v[]' if v else ''}) {{ return 32768; }}")
    elif controller.task.emit.tick_period is not None:
        text.append(f"{p}_status {p}_control_tick(uint32_t t, const {number} x[{n}], {v}{number} u[{n}]) {{ {body} }}")
    if not controller.design.is_stateful:
        text.append(f"bool {p}_covered(const {number} x[{n}]{', const ' + number + ' v[]' if v else ''}) {{ return true; }}")
    if controller.design.is_stateful:
        text.append(f"void {p}_alpha_init({real} alpha[2 * {n}]) {{}}")
        note = 'printf("A %.17g %.17g\\n", (double)t, (double)dt);'
        text.append(f"void {p}_alpha_step({real} t, {real} dt, {real} alpha[2 * {n}]) {{ {note} }}")
    if controller.task.uses_differences:
        note = f'printf("V %.17g 0\\n", (double)dt); for (int i = 0; i < {n}; i++) {{ v[i] = x[i] - b[i]; }}'
        text.append(f"void {p}_velocity({real} dt, const {real} x[{n}], const {real} b[{n}], {real} v[{n}]) {{ {note} }}")
    if controller.task.emit.selftest:
        text.append(f"int {p}_selftest(void) {{ return 0; }}")
    return "\n".join(text)


@cache
def arduino_package(variant: str) -> dict[str, bytes]:
    return package(controller_of_variant(variant), "arduino")


@cache
def times_of(variant: str) -> LoopTimes:
    """Return the period and the longest proved gap; the search for it takes a second, so that it runs once."""
    return loop_times(controller_of_variant(variant))


@pytest.fixture
def drive(tool, tmp_path: Path):
    """Return a function that runs the sketch with costs of its steps: microseconds for sensors, for the first actuator, and after both."""

    def run(variant: str, costs: list[tuple[int, int, int]]) -> list[Step]:
        """Compile the sketch of a variant with the harness, run one step for each cost, and return the steps."""
        controller = controller_of_variant(variant)
        p = controller.task.name
        write_files(tmp_path, arduino_package(variant))
        source = tmp_path / p / "src"
        (tmp_path / "sketch.ino").write_bytes((tmp_path / p / "examples" / f"{p}_loop" / f"{p}_loop.ino").read_bytes())
        (tmp_path / "main.cpp").write_text(HARNESS % stubs(controller))
        emitted = [str(f) for f in source.glob("*.c") if f.stem in (f"{p}_wrap", f"{p}_guard")]
        objects = []
        for name in emitted:
            objects.append(name.replace(".c", ".o"))
            subprocess.run([tool("gcc"), "-std=c99", "-c", name, f"-I{source}", "-o", objects[-1]], check=True)
        flags = ["-std=gnu++11", "-O1", "-Wall", f"-I{source}", f"-I{tmp_path}"]
        subprocess.run([tool("g++"), *flags, str(tmp_path / "main.cpp"), *objects, "-o", str(tmp_path / "run")], check=True)
        lines = "\n".join(" ".join(map(str, cost)) for cost in costs)
        output = subprocess.run(
            [str(tmp_path / "run")], input=lines, capture_output=True, text=True, check=True, timeout=60
        ).stdout
        return steps_of(output)

    return run


def steps_of(output: str) -> list[Step]:
    """Read the steps from the lines that the harness and the stubs print."""
    steps, notes, first = [], [], None
    for kind, *numbers in (line.split() for line in output.splitlines()):
        if kind != "S":
            notes.append((kind, float(numbers[0]), float(numbers[1])))
            continue
        looked, called, late, count, led = numbers
        first = int(looked) if first is None else first
        steps.append(Step(int(looked) - first, float(called), late == "1", int(count), int(led), tuple(notes)))
        notes = []
    return steps


def slow_costs(variant: str, jumps: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Return 300 costs of up to 2.5 periods, among them stalls of `jumps`, in microseconds."""
    period = int(times_of(variant).period / US)
    dice = np.random.default_rng(7)
    costs = [int(v) for v in np.concatenate([np.full(60, 1.065 * period), dice.uniform(0, 2.5 * period, 240)])]
    for k, jump in enumerate(jumps):
        costs[70 + 3 * k] = jump
    return [(c, 0, 0) for c in costs]


def wrapped_time(controller: EmittedController, seconds: Fraction) -> Fraction:
    """Return the time in the tube at a clock time: a repeated mission starts its cycle again."""
    cycle = cycle_of(controller.design)
    while cycle is not None and seconds >= cycle.end:
        seconds -= cycle.length * max(1, int((seconds - cycle.end) / cycle.length))
    return seconds


@pytest.mark.parametrize("variant", VARIANTS)
def test_tube_time_follows_the_clock_however_long_steps_take(variant: str, drive) -> None:
    """Steps are longer than the period, with stalls of seconds and of half an hour, past an overflow of micros(), for over 2^32 us."""
    controller = controller_of_variant(variant)
    task, t_c = controller.task, controller.task.prescribed_time
    half_hour = 1_800_000_000
    jumps = (
        (3_100_000, int(t_c / US) // 3, half_hour, half_hour, half_hour) if not controller.design.is_stateful else (3_100_000,)
    )
    steps = drive(variant, slow_costs(variant, jumps))
    assert len(steps) == 300
    assert controller.design.is_stateful or steps[-1].now > 2**32
    tick = task.emit.tick_period
    by_ticks = tick is not None and task.control.outside == "return"
    for step in steps:
        seconds = step.now * US
        if by_ticks:
            assert tick is not None
            # A tick begins in the microsecond in which its time lies, which is up to one microsecond before it.
            true_tick = int((seconds + US * Fraction(999_999, 10**6)) / tick)
            last = -(-t_c // tick)
            if task.repeat:
                cycle = cycle_of(controller.design)
                assert cycle is not None
                true_tick = int(wrapped_time(controller, true_tick * tick) / tick)
                assert step.called < last
            assert step.called == (true_tick if task.repeat else min(true_tick, last))
        else:
            true_time = float(wrapped_time(controller, seconds))
            # Three roundings: the count to a float, 1e-6 as a float, and their product. A wrapped time has one more, of t_c's size.
            tolerance = 3.01 * 2.0**-24 * true_time + (2.0**-22 * float(t_c) + 1e-6 if task.repeat else 0.0)
            if task.repeat:  # just before and just after a wrap are the same point of the tube
                cycle = cycle_of(controller.design)
                assert cycle is not None
                apart = abs(step.called - true_time)
                assert min(apart, abs(apart - float(cycle.length))) <= tolerance
            else:
                assert abs(step.called - true_time) <= tolerance


@pytest.mark.parametrize("variant", [v for v in VARIANTS if v not in ("ticks", "odd ticks", "integers", "repeat")])
def test_a_late_loop_continues_from_the_clock_without_catching_up(variant: str, drive) -> None:
    """Samples are at least a period apart, also after a stall."""
    period = times_of(variant).period
    steps = drive(variant, slow_costs(variant, (3_100_000,)))
    gaps = [b.now - a.now for a, b in itertools.pairwise(steps)]
    assert min(gaps) * US >= period
    assert max(gaps) >= 3_100_000


@pytest.mark.parametrize("variant", ["ticks", "odd ticks", "integers", "repeat"])
def test_samples_are_taken_when_ticks_begin(variant: str, drive) -> None:
    """Integers have no time between two ticks, so that the sample after a step longer than a tick is at the beginning of a tick."""
    controller = controller_of_variant(variant)
    tick = controller.task.emit.tick_period
    assert tick is not None
    steps = drive(variant, slow_costs(variant, (3_100_000,)))
    offsets = [step.now * US - int((step.now * US + US * Fraction(999_999, 10**6)) / tick) * tick for step in steps]
    # The sketch reads the clock twice in a step and once in each idle loop; a tick may begin between two readings.
    assert max(offsets) <= 2 * POLL * US
    assert min(offsets) > -US
    numbers = [int((step.now * US + US * Fraction(999_999, 10**6)) / tick) for step in steps]
    assert all(a < b for a, b in itertools.pairwise(numbers))


@pytest.mark.parametrize("variant", VARIANTS)
def test_late_is_set_by_the_first_gap_longer_than_proved_and_stays_set(variant: str, drive) -> None:
    """Gaps are just below the limit, just above it, and then short; with ticks they are multiples of a tick."""
    controller = controller_of_variant(variant)
    times, tick = times_of(variant), controller.task.emit.tick_period
    period = int(times.period / US)
    idle = [0] * 20 + [3 * period // 2, 0] * (times.longest_us > 2 * period)
    for k in range(-40, 13):
        idle += [max(0, times.longest_us + k), 0]
    steps = drive(variant, [(0, 0, cost) for cost in [*idle, 0, 0, 0, 0, 0]])
    gaps = [0, *(b.now - a.now for a, b in itertools.pairwise(steps))]
    assert any(gap > times.longest_us for gap in gaps)
    has_allowed_gap = any(period + 2 * POLL < gap <= times.longest_us for gap in gaps)
    assert has_allowed_gap == (times.longest_us > (period + 2 * POLL if tick is None else 2 * period))
    expected = 0
    for gap, step in zip(gaps, steps, strict=True):
        expected += gap > times.longest_us
        assert step.late_steps == expected
        assert step.late == (expected > 0)
        assert step.late or step.led == 0
    if times.longest is not None:  # a true gap may be longer than the count of micros() by less than its step
        assert times.longest_us == 0 or times.longest_us * US + MICROS_RESOLUTION * US <= times.longest


def test_an_input_later_than_the_latency_is_late_too(drive) -> None:
    controller = controller_of_variant("stop")
    assert controller.task.control.latency == Fraction("0.004")
    steps = drive("stop", [(0, 0, 0), (1000, 2900, 0), (0, 3900, 0), (0, 4010, 0), (0, 0, 0)])
    assert [s.late_steps for s in steps] == [0, 0, 0, 1, 1]


def test_the_led_blinks_only_while_late_is_set(drive) -> None:
    steps = drive("seconds", [(10_000, 0, 0)] * 3 + [(0, 0, 0)] * 200)
    assert {s.led for s in steps if s.late} == {0, 1}
    assert {s.led for s in steps if not s.late} == {0}


def test_alpha_follows_the_clock_in_steps_that_the_certificate_allows(drive) -> None:
    controller = controller_of_variant("adaptive")
    bounds = controller.certificate.steps
    assert bounds is not None
    shortest, longest = map(float, bounds)
    steps = drive("adaptive", slow_costs("adaptive", (3_100_000, 100_000)))
    alpha_time, previous_sample = 0.0, 0
    for step in steps[1:]:
        assert step.notes
        for kind, t, dt in step.notes:
            assert kind == "A"
            assert shortest <= dt <= longest
            assert abs(t - alpha_time) <= 4 * 2.0**-24 * (t + dt)  # t is the end of the step before, each rounded three times
            alpha_time = t + dt
        assert sum(dt for _, _, dt in step.notes) == pytest.approx((step.now - previous_sample) * 1e-6, rel=1e-6)
        previous_sample = step.now
    assert [dt for _, _, dt in steps[0].notes] == [0.0]  # alpha does not change where dt is not positive


def test_differences_are_over_the_time_between_both_samples(drive) -> None:
    controller = controller_of_variant("differences")
    steps = drive("differences", slow_costs("differences", (3_100_000,)))
    for a, b in itertools.pairwise(steps):
        ((kind, dt, _),) = b.notes
        assert kind == "V"
        assert dt == pytest.approx((b.now - a.now) * 1e-6, rel=3 * 2.0**-24)
        assert dt >= float(controller.task.shortest_period) * (1 - 2.0**-22)


def test_ticks_shorter_than_a_board_can_distinguish_are_refused() -> None:
    controller = build_once(load_task(ROOT / "tasks" / "omni_board.toml").changed(emit={"tick_period": "0.000003"}))
    with pytest.raises(
        BadInput, match=r"emit.tick_period: is 3 us; .*: give at least 0.000004 s, or take --package plain or cmake"
    ):
        package(controller, "arduino")
    assert package(controller, "cmake")


def test_a_note_says_if_an_uno_takes_longer_than_the_period() -> None:
    """The floats of omni_s2 take about 1.06 ms on an Uno: a period of 1 ms is too short, 2 ms are enough."""
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    (note,) = sketch_notes(build_once(task.changed(control={"gain": "auto", "period": "0.001"})))
    assert note.startswith(
        "a step takes about 1.06 ms on an Uno (16 MHz; an estimate), and 1 ms is proved (P9): it will be late there"
    )
    assert note.endswith('; emit.scalar = "fixed" takes less than half of that')
    assert sketch_notes(build_once(task.changed(control={"gain": "auto", "period": "0.002"}))) == []
    assert sketch_notes(controller_of_variant("adaptive")) == []  # it does not fit on an Uno
    assert sketch_notes(controller_of_variant("integers")) == []


def test_a_note_says_if_a_period_of_one_tick_leaves_no_margin() -> None:
    task = load_task(ROOT / "tasks" / "gantry.toml")
    (note,) = sketch_notes(build_once(task.changed(emit={"tick_period": "0.01"})))
    assert note == (
        "the sketch samples every 10 ms, and 10 ms is proved (P9): a sample that is microseconds late sets `late`; "
        "state a control.period of two ticks"
    )


def test_generate_prints_that_note_only_for_packages_with_sketches(tmp_path: Path) -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    task = tmp_path / "omni_s2.toml"
    task.write_text(text.replace("gain = 0.5", "period = 0.001"))
    assert "period = 0.001" in task.read_text()
    for kind, has_note in (("arduino", True), ("cmake", False)):
        result = CliRunner().invoke(app, ["generate", str(task), "--package", kind, "--out", str(tmp_path / kind)])
        assert result.exit_code == 0, result.output
        assert ("note: omni_s2: a step takes about 1.06 ms on an Uno" in result.output) == has_note


@pytest.mark.parametrize(("name", "scalar"), [("omni_s2", "float"), ("gantry", "fixed")])
def test_the_estimate_of_an_unos_cycles_is_near_the_simulated_count(name: str, scalar: str, tool) -> None:
    """With the compiler's options of Arduino's IDE; benchmarks/sketch_time.py counts more tasks and points."""
    for program in ("avr-gcc", "simavr"):
        tool(program)
    from benchmarks.sketch_time import largest_cycles

    controller = build_once(load_task(ROOT / "tasks" / f"{name}.toml").with_options(scalar=scalar))
    estimate = step_cycles(controller)
    assert estimate is not None
    assert abs(Fraction(estimate, largest_cycles(controller, 12)) - 1) <= RELATIVE_ERROR
