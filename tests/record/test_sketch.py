"""Time in the example sketches: tube time is what the clock says, whatever a step takes; `late` says which gap is not proved.

The sketch itself runs here, with a micros() that jumps, turns over at 2^32 and goes on while a step computes. The controller is
a stub that notes the time at which it is called; guards and turned clocks are the emitted C.
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
from stt_codegen.pipeline import EmittedController
from stt_codegen.record.files import write_files
from stt_codegen.record.package import package
from stt_codegen.record.sketch import MICROS_RESOLUTION, LoopTimes, loop_times, sketch_notes
from stt_codegen.record.uno import RELATIVE_ERROR, step_cycles
from stt_codegen.task.load import load_task
from tests.support.controllers import ROOT, built

POLL = 4  # microseconds that a call of the harness's micros() takes
US = Fraction(1, 10**6)
VARIANTS: dict[str, tuple[str, dict[str, Any], str]] = {
    "seconds": ("crawler", {"emit": {"tick_period": None}}, "refined"),
    "microseconds": ("omni_s2", {"control": {"gain": "1000"}}, "refined"),  # which no loop keeps
    "ticks": ("crawler", {}, "refined"),
    "odd ticks": ("omni_board", {"emit": {"tick_period": "0.0007123"}}, "refined"),
    "integers": ("gantry", {}, "refined"),
    "repeat": ("watchman", {}, "refined"),
    "repeat, seconds": ("watchman", {"emit": {"tick_period": None}, "prescribed_time": "15.90001"}, "refined"),
    "hold": ("omni_board", {"control": {"outside": "hold"}}, "refined"),
    "stop": ("drone", {"control": {"outside": "stop"}}, "refined"),
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
    """A sample: microseconds of the world since the first, the time that the controller was called with, `late` after it."""

    now: int
    called: float
    late: bool
    late_steps: int
    led: int
    notes: tuple[tuple[str, float, float], ...]  # alpha steps (t, dt) and differences (dt, 0) before it


@cache
def made(variant: str) -> EmittedController:
    name, changed, design = VARIANTS[variant]
    task = load_task(ROOT / "tasks" / f"{name}.toml").changed(**changed)
    return built(task.with_options(design))


def stubs(controller: EmittedController) -> str:
    """The controller's functions, as its header declares them: each notes when it is called."""
    p, n = controller.task.name, f"{controller.task.name.upper()}_N"
    integers, real = controller.task.emit.scalar == "fixed", f"{p}_real"
    number = "int32_t" if integers else real
    v = f"const {number} v[{n}], " if controller.task.order == 2 else ""
    alpha = f"const {real} alpha[2 * {n}], " if controller.design.is_stateful else ""
    told = f"for (int i = 0; i < {n}; i++) {{ u[i] = 0; }} called_at = (double)t; stepped = true; return {p.upper()}_OK;"
    text = [
        f"{p}_status {p}_control({'uint32_t' if integers else real} t, {alpha}const {number} x[{n}], {v}{number} u[{n}]) {{ {told} }}"
    ]
    if integers:
        text.append(f"int32_t {p}_margin(uint32_t, const int32_t x[{n}]{', const int32_t v[]' if v else ''}) {{ return 32768; }}")
    elif controller.task.emit.tick_period is not None:
        text.append(f"{p}_status {p}_control_tick(uint32_t t, const {number} x[{n}], {v}{number} u[{n}]) {{ {told} }}")
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
def arduino(variant: str) -> dict[str, bytes]:
    return package(made(variant), "arduino")


@cache
def times_of(variant: str) -> LoopTimes:
    """The search for what is proved at the task's gain takes a second, once."""
    return loop_times(made(variant))


@pytest.fixture
def drive(tool, tmp_path: Path):
    """Runs the sketch with these costs of its steps: microseconds for sensors, for the first actuator, and after both."""

    def run(variant: str, costs: list[tuple[int, int, int]]) -> list[Step]:
        controller = made(variant)
        p = controller.task.name
        write_files(tmp_path, arduino(variant))
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
        given = "\n".join(" ".join(map(str, cost)) for cost in costs)
        told = subprocess.run([str(tmp_path / "run")], input=given, capture_output=True, text=True, check=True, timeout=60).stdout
        return steps_of(told)

    return run


def steps_of(told: str) -> list[Step]:
    steps, notes, first = [], [], None
    for kind, *numbers in (line.split() for line in told.splitlines()):
        if kind != "S":
            notes.append((kind, float(numbers[0]), float(numbers[1])))
            continue
        looked, called, late, count, led = numbers
        first = int(looked) if first is None else first
        steps.append(Step(int(looked) - first, float(called), late == "1", int(count), int(led), tuple(notes)))
        notes = []
    return steps


def slow_costs(variant: str, jumps: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Steps of which each takes up to 2.5 periods, among them stalls of these microseconds."""
    period = int(times_of(variant).period / US)
    dice = np.random.default_rng(7)
    costs = [int(v) for v in np.concatenate([np.full(60, 1.065 * period), dice.uniform(0, 2.5 * period, 240)])]
    for k, jump in enumerate(jumps):
        costs[70 + 3 * k] = jump
    return [(c, 0, 0) for c in costs]


def turned_back(controller: EmittedController, seconds: Fraction) -> Fraction:
    cycle = cycle_of(controller.design)
    while cycle is not None and seconds >= cycle.end:
        seconds -= cycle.length * max(1, int((seconds - cycle.end) / cycle.length))
    return seconds


@pytest.mark.parametrize("variant", VARIANTS)
def test_tube_time_is_what_the_clock_says_however_long_steps_take(variant: str, drive) -> None:
    """Steps longer than the period, stalls of seconds and of half an hour, past the turn of micros(), to more than 2^32 in all."""
    controller = made(variant)
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
            # A tick begins in the microsecond in which its time lies, which is up to one before it.
            true = int((seconds + US * Fraction(999_999, 10**6)) / tick)
            last = -(-t_c // tick)
            if task.repeat:
                cycle = cycle_of(controller.design)
                assert cycle is not None
                true = int(turned_back(controller, true * tick) / tick)
                assert step.called < last
            assert step.called == (true if task.repeat else min(true, last))
        else:
            true_time = float(turned_back(controller, seconds))
            # The count to a float, 1e-6 as a float, their product: three roundings; turned back, one more of t_c's size.
            tolerance = 3.01 * 2.0**-24 * true_time + (2.0**-22 * float(t_c) + 1e-6 if task.repeat else 0.0)
            if task.repeat:  # just before a turn or just after it: the same place of the tube
                cycle = cycle_of(controller.design)
                assert cycle is not None
                apart = abs(step.called - true_time)
                assert min(apart, abs(apart - float(cycle.length))) <= tolerance
            else:
                assert abs(step.called - true_time) <= tolerance


@pytest.mark.parametrize("variant", [v for v in VARIANTS if v not in ("ticks", "odd ticks", "integers", "repeat")])
def test_a_late_loop_goes_on_from_the_clock_and_makes_up_for_nothing(variant: str, drive) -> None:
    """No two samples are nearer than the period, also after a stall."""
    period = times_of(variant).period
    steps = drive(variant, slow_costs(variant, (3_100_000,)))
    gaps = [b.now - a.now for a, b in itertools.pairwise(steps)]
    assert min(gaps) * US >= period
    assert max(gaps) >= 3_100_000


@pytest.mark.parametrize("variant", ["ticks", "odd ticks", "integers", "repeat"])
def test_samples_are_taken_when_ticks_begin(variant: str, drive) -> None:
    """Integers know no time between two ticks: a step longer than a tick is followed by a sample at the begin of another."""
    controller = made(variant)
    tick = controller.task.emit.tick_period
    assert tick is not None
    steps = drive(variant, slow_costs(variant, (3_100_000,)))
    offsets = [step.now * US - int((step.now * US + US * Fraction(999_999, 10**6)) / tick) * tick for step in steps]
    # It looks at the clock twice in a step and once a turn; a tick may begin between the last look and the next.
    assert max(offsets) <= 2 * POLL * US
    assert min(offsets) > -US
    numbers = [int((step.now * US + US * Fraction(999_999, 10**6)) / tick) for step in steps]
    assert all(a < b for a, b in itertools.pairwise(numbers))


@pytest.mark.parametrize("variant", VARIANTS)
def test_late_is_set_by_the_first_gap_that_is_longer_than_what_is_proved_and_stays(variant: str, drive) -> None:
    """Gaps that nearly are, that just are, and then short ones; by ticks the gaps are whole ticks."""
    controller = made(variant)
    times, tick = times_of(variant), controller.task.emit.tick_period
    period = int(times.period / US)
    idle = [0] * 20 + [3 * period // 2, 0] * (times.longest_us > 2 * period)
    for k in range(-40, 13):
        idle += [max(0, times.longest_us + k), 0]
    steps = drive(variant, [(0, 0, cost) for cost in [*idle, 0, 0, 0, 0, 0]])
    gaps = [0, *(b.now - a.now for a, b in itertools.pairwise(steps))]
    assert any(gap > times.longest_us for gap in gaps)
    between = any(period + 2 * POLL < gap <= times.longest_us for gap in gaps)
    assert between == (times.longest_us > (period + 2 * POLL if tick is None else 2 * period))
    expected = 0
    for gap, step in zip(gaps, steps, strict=True):
        expected += gap > times.longest_us
        assert step.late_steps == expected
        assert step.late == (expected > 0)
        assert step.late or step.led == 0
    if times.longest is not None:  # in truth a gap is less than what micros() counts by longer than what it shows
        assert times.longest_us == 0 or times.longest_us * US + MICROS_RESOLUTION * US <= times.longest


def test_an_input_later_than_the_latency_is_late_too(drive) -> None:
    controller = made("stop")
    assert controller.task.control.latency == Fraction("0.004")
    steps = drive("stop", [(0, 0, 0), (1000, 2900, 0), (0, 3900, 0), (0, 4010, 0), (0, 0, 0)])
    assert [s.late_steps for s in steps] == [0, 0, 0, 1, 1]


def test_late_blinks_and_the_rest_of_the_time_the_led_is_off(drive) -> None:
    steps = drive("seconds", [(10_000, 0, 0)] * 3 + [(0, 0, 0)] * 200)
    assert {s.led for s in steps if s.late} == {0, 1}
    assert {s.led for s in steps if not s.late} == {0}


def test_alpha_goes_with_the_clock_in_steps_that_the_certificate_is_about(drive) -> None:
    controller = made("adaptive")
    bounds = controller.certificate.steps
    assert bounds is not None
    shortest, longest = map(float, bounds)
    steps = drive("adaptive", slow_costs("adaptive", (3_100_000, 100_000)))
    at, before = 0.0, 0
    for step in steps[1:]:
        assert step.notes
        for kind, t, dt in step.notes:
            assert kind == "A"
            assert shortest <= dt <= longest
            assert abs(t - at) <= 4 * 2.0**-24 * (t + dt)  # t is that of the last step's end, each rounded three times
            at = t + dt
        assert sum(dt for _, _, dt in step.notes) == pytest.approx((step.now - before) * 1e-6, rel=1e-6)
        before = step.now
    assert [dt for _, _, dt in steps[0].notes] == [0.0]  # alpha stays where dt is not positive


def test_differences_are_over_the_time_between_both_samples(drive) -> None:
    controller = made("differences")
    steps = drive("differences", slow_costs("differences", (3_100_000,)))
    for a, b in itertools.pairwise(steps):
        ((kind, dt, _),) = b.notes
        assert kind == "V"
        assert dt == pytest.approx((b.now - a.now) * 1e-6, rel=3 * 2.0**-24)
        assert dt >= float(controller.task.shortest_period) * (1 - 2.0**-22)


def test_ticks_that_no_board_can_tell_apart_are_refused() -> None:
    controller = built(load_task(ROOT / "tasks" / "omni_board.toml").changed(emit={"tick_period": "0.000003"}))
    with pytest.raises(
        BadInput, match=r"emit.tick_period: is 3 us; .*: give at least 0.000004 s, or take --package plain or cmake"
    ):
        package(controller, "arduino")
    assert package(controller, "cmake")


def test_an_uno_that_takes_longer_than_the_period_is_told_of_beforehand() -> None:
    """The floats of omni_s2 take about 1.05 ms of an Uno: a millisecond is not kept, two are."""
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    (note,) = sketch_notes(built(task.changed(control={"gain": "auto", "period": "0.001"})))
    assert note.startswith(
        "a step takes about 1.05 ms on an Uno (16 MHz; an estimate), and 1 ms is proved (P9): it will be late there"
    )
    assert note.endswith('; emit.scalar = "fixed" takes less than half of that')
    assert sketch_notes(built(task.changed(control={"gain": "auto", "period": "0.002"}))) == []
    assert sketch_notes(made("adaptive")) == []  # which no Uno links
    assert sketch_notes(made("integers")) == []


def test_a_period_of_one_tick_leaves_no_room_and_is_told_of() -> None:
    task = load_task(ROOT / "tasks" / "gantry.toml")
    (note,) = sketch_notes(built(task.changed(emit={"tick_period": "0.01"})))
    assert note == (
        "the sketch samples every 10 ms, and 10 ms is proved (P9): a sample that is microseconds late sets `late`; "
        "state a control.period of two ticks"
    )


def test_generate_notes_it_for_sketches_alone(tmp_path: Path) -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    task = tmp_path / "omni_s2.toml"
    task.write_text(text.replace("gain = 0.5", "period = 0.001"))
    assert "period = 0.001" in task.read_text()
    for kind, told in (("arduino", True), ("cmake", False)):
        result = CliRunner().invoke(app, ["generate", str(task), "--package", kind, "--out", str(tmp_path / kind)])
        assert result.exit_code == 0, result.output
        assert ("note: omni_s2: a step takes about 1.05 ms on an Uno" in result.output) == told


@pytest.mark.parametrize(("name", "scalar"), [("omni_s2", "float"), ("gantry", "fixed")])
def test_the_estimate_of_an_unos_cycles_is_near_what_is_counted(name: str, scalar: str, tool) -> None:
    """With the compiler's options of Arduino's IDE; benchmarks/sketch_time.py counts more tasks and points."""
    for needed in ("avr-gcc", "simavr"):
        tool(needed)
    from benchmarks.sketch_time import counted

    controller = built(load_task(ROOT / "tasks" / f"{name}.toml").with_options(scalar=scalar))
    estimate = step_cycles(controller)
    assert estimate is not None
    assert abs(Fraction(estimate, counted(controller, 12)) - 1) <= RELATIVE_ERROR
