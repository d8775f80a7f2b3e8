"""`covered` tells at run time whether the proof holds from a measured start; its bounds, and `margins` by component."""

from __future__ import annotations

import hashlib
import json
import math
import random
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import stt_codegen as stt
from stt_codegen.checker import check_files
from stt_codegen.controller.covered_starts import BOUND_TABLES, compute_covered_starts, start_share
from stt_codegen.designs.filtered import slopes_at_start
from stt_codegen.program.number import FORMATS
from stt_codegen.sampling.numbers import FRACTIONS
from stt_codegen.sampling.order_two import inertial_start_bound
from stt_codegen.task.load import load_task, parse_task
from tests.support.controllers import ROOT, TASK_FILES, build_once, interface_of

STEMS = [path.stem for path in TASK_FILES]
CHANGED_TASKS = {  # by case: an example task, and its changes
    "noisy": ("rover", {"plant": {"noise": 0.03}}),
    "fast": ("drone", {"initial_set": {"speed": 0.01}}),
    "free": ("omni_s2", {"control": {"e_max": 0.6}}),
    "double": ("attitude", {"emit": {"scalar": "double"}}),
}


@cache
def controller_of_case(name: str) -> stt.Controller:
    """Return the controller of an example task, or of a case of `CHANGED_TASKS`."""
    stem, changes = CHANGED_TASKS.get(name, (name, {}))
    task = load_task(ROOT / "tasks" / f"{stem}.toml")
    return interface_of(build_once(task.changed(**changes) if changes else task))


def is_proved_from(controller: stt.Controller, x: list[Fraction], v: list[Fraction] | None) -> bool:
    """Return whether the proof begins at a true state: by the tube's own polynomials, without the bounds of `covered`."""
    task, design = controller.task, controller.design
    share, period = start_share(task), task.control.period
    ratios = inertial_start_bound(task, design, numbers=FRACTIONS) if task.order == 2 and period is not None else None
    for i, (low_rate, high_rate) in enumerate(slopes_at_start(design) if task.order == 2 else [(0, 0)] * task.dimension):
        low, high = (int(edge) * design.unit for edge in design.bezier()[0, i, :, 0])
        if abs(2 * x[i] - low - high) > share * (high - low):
            return False
        if v is None:
            continue
        a = v[i] - low_rate + design.filter[i] * (x[i] - low)
        b = high_rate - v[i] + design.filter[i] * (high - x[i])
        limit = (1 + share) / (1 - share) if ratios is None else ratios[i]
        if a <= 0 or b <= 0 or max(a / b, b / a) > limit:
            return False
    return True


def measure(controller: stt.Controller, values: list[Fraction], noise: Fraction, draw: random.Random) -> list[float]:
    """Return a true state with noise of at most this size, rounded to the controller's scalar type."""
    kind = {"float": np.float32, "double": np.float64}.get(controller.program.scalar)
    noisy = [v + noise * draw.choice([-1, 1, Fraction(draw.uniform(-1, 1))]) for v in values]
    if kind is None:  # integers count whole units
        unit = controller.design.unit
        return [float(round(v / unit) * unit) for v in noisy]
    return [float(kind(float(v))) for v in noisy]


@pytest.mark.parametrize("name", [*STEMS, *CHANGED_TASKS])
def test_a_start_without_a_proof_is_not_covered(name: str) -> None:
    """True states near the bounds are measured with the stated noise, and rounded. Where the emitted Python says covered, the proof
    begins at the true state. Some are covered, and so is the initial state."""
    controller, draw = controller_of_case(name), random.Random(name)
    task, design = controller.task, controller.design
    starts, covered_count = compute_covered_starts(task, design), 0
    noise = task.plant.noise or Fraction(0)
    noise_v = Fraction(0) if task.uses_differences else task.plant.noise_v or Fraction(0)

    def draw_near(bounds: tuple[Fraction, Fraction], error: Fraction) -> Fraction:
        low, high = bounds
        bound = draw.choice([low, high])
        step = max(error, abs(bound) * Fraction(FORMATS["float"].roundoff))
        return draw.choice([bound + step * Fraction(draw.uniform(-3, 3)), low + (high - low) * Fraction(draw.random())])

    for _ in range(250):
        x = [draw_near(pair, noise) for pair in starts.positions]
        v = None
        if task.order == 2:
            pairs = zip(starts.filtered, design.filter, x, strict=True)
            v = [draw_near(pair, noise_v + value * noise) - value * position for pair, value, position in pairs]
        measured = measure(controller, x, noise, draw)
        measured_speeds = None if v is None else measure(controller, v, noise_v, draw)
        if controller.covered(measured, measured_speeds):
            covered_count += 1
            assert is_proved_from(controller, x, v), (measured, measured_speeds)
    assert covered_count > 0
    position = [float(v) for v in task.initial_state]
    assert controller.covered(position, [0.0] * task.dimension if task.order == 2 else None)


@pytest.mark.parametrize("name", ["omni_s2", "rover", "crane", "drone", "free", "fast"])
def test_the_bounds_of_covered_allow_for_noise_and_two_roundings_and_no_more(name: str) -> None:
    """The bounds are narrower than the start share by the noise and at most two roundings."""
    controller = controller_of_case(name)
    task, design = controller.task, controller.design
    noise = task.plant.noise or Fraction(0)
    largest_coordinate = max(abs(v) for edge in (task.state_space.lower, task.state_space.upper) for v in edge)
    for i, (low, high) in enumerate(compute_covered_starts(task, design).positions):
        a, b = (int(edge) * design.unit for edge in design.bezier()[0, i, :, 0])
        half_width = start_share(task) * (b - a) / 2
        rounding = design.unit if task.emit.scalar == "fixed" else 2 * FORMATS[task.emit.scalar].roundoff * largest_coordinate
        assert (a + b) / 2 - half_width <= low <= (a + b) / 2 - half_width + noise + rounding
        assert (a + b) / 2 + half_width >= high >= (a + b) / 2 + half_width - noise - rounding


def test_a_controller_that_is_not_certified_covers_nothing() -> None:
    task = load_task(ROOT / "tasks" / "rover.toml").changed(control={"period": 2.0, "gain": 0.5})
    controller = stt.build(task, uncertified=True)
    assert not controller.certificate.holds
    assert not controller.covered([float(v) for v in task.initial_state])


@pytest.mark.parametrize("name", ["omni_s2", "crane", "drone"])
def test_margin_is_the_smallest_of_the_margins_up_to_a_half(name: str) -> None:
    controller = controller_of_case(name)
    n, draw = controller.task.dimension, np.random.default_rng(5)
    lower, upper = controller.tube(times := np.linspace(0, float(controller.task.prescribed_time), 40))
    x = lower + (upper - lower) * draw.uniform(-0.2, 1.2, (40, n))
    state = (x,) if controller.task.order == 1 else (x, draw.uniform(-0.1, 0.1, (40, n)))
    by_component = controller.margins(times, *state)
    assert by_component.shape == (40, n)
    assert (np.minimum(by_component.min(axis=1), 0.5) == controller.margin(times, *state)).all()


def test_an_adaptive_tube_has_margins_and_refuses_covered_with_the_reason() -> None:
    controller = stt.build(load_task(ROOT / "tasks" / "omni_s2.toml").changed(tube={"design": "adaptive"}))
    assert math.isclose(float(controller.margins(0.0, [0.25, 0.1]).min()), float(controller.margin(0.0, [0.25, 0.1])))
    with pytest.raises(stt.BadInput, match="only a refined tube"):
        controller.covered([0.25, 0.25])


# ------------------------------------------------------------------------------------------------ the stand-alone checker


def with_moved_entry(text: str, name: str, entry: int, by: int) -> str:
    """Return the C's text with one entry of the table of that name moved by `by` units in the last place of a float."""
    head = text.index(f"_{name}[")
    begin, end = text.index("{", head) + 1, text.index("}", head)
    entries = text[begin:end].split(",")
    value = np.float32(entries[entry].strip().rstrip("F"))
    for _ in range(abs(by)):
        value = np.nextafter(value, np.float32(math.copysign(np.inf, by)))
    entries[entry] = f"\n    {np.format_float_positional(value, unique=True, trim='0')}F"
    return text[:begin] + ",".join(entries) + text[end:]


CHANGES_OF_C = {
    "a bound moved outwards": lambda c: with_moved_entry(c, "start_upper", 1, 1),
    "a bound moved inwards": lambda c: with_moved_entry(c, "start_lower", 0, 1),
    "the bounds exchanged": lambda c: c.replace("omni_s2_start_lower[i]", "omni_s2_start_upper[i]"),
    "one side alone": lambda c: c.replace("x_inside = x_above && x_below;", "x_inside = x_above && x_above;"),
    "an edge included": lambda c: c.replace("x_below = x_i < x_upper", "x_below = x_i <= x_upper"),
    "the last component alone": lambda c: c.replace("x_inside ? covered : false", "x_inside ? true : false"),
    "covered from the start": lambda c: c.replace("x_inside ? covered : false", "x_inside ? covered : true"),
    "nothing is covered": lambda c: c.replace("bool covered = true;", "bool covered = false;"),
    "margins of the far edge": lambda c: c.replace("margin[i] = margin_x", "margin[i] = x_share"),
}  # fmt: skip


def exit_code_of_checker(folder: Path, controller: stt.Controller, source: str, header: str) -> int:
    """Return what the checker says of this C and header, with a certificate that has their hashes."""
    name = controller.task.name
    certificate = json.loads(controller.files[f"{name}.certificate.json"])
    for file, text in ((f"{name}.c", source), (f"{name}.h", header)):
        (folder / file).write_text(text)
        certificate["sha256"][file] = hashlib.sha256(text.encode()).hexdigest()
    (folder / f"{name}.certificate.json").write_text(json.dumps(certificate))
    return check_files(
        [str(p) for p in (ROOT / "tasks" / f"{name}.toml", folder / f"{name}.c", folder / f"{name}.certificate.json")]
    )


@pytest.mark.parametrize("change", CHANGES_OF_C)
def test_a_changed_covered_is_refused_by_the_checker(change: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    controller = controller_of_case("omni_s2")
    source, header = (controller.files[f"omni_s2.{kind}"].decode() for kind in ("c", "h"))
    assert exit_code_of_checker(tmp_path, controller, source, header) == 0
    assert (altered := CHANGES_OF_C[change](source)) != source
    assert exit_code_of_checker(tmp_path, controller, altered, header) == 1, capsys.readouterr().out


@pytest.mark.parametrize(("name", "old", "new"), [
    ("omni_s2", "SHARE 0.98999995F", "SHARE 0.99F"),
    ("omni_s2", "bool omni_s2_covered", "int omni_s2_covered"),
    ("gantry", "SHARE 0.8999999999999999 ", "SHARE 0.9 "),
])  # fmt: skip
def test_another_start_share_in_the_header_is_refused(name: str, old: str, new: str, tmp_path: Path) -> None:
    controller = controller_of_case(name)
    source, header = (controller.files[f"{name}.{kind}"].decode() for kind in ("c", "h"))
    assert old in header
    assert exit_code_of_checker(tmp_path, controller, source, header.replace(old, new)) == 1


@pytest.mark.parametrize("table", BOUND_TABLES[:2])
def test_a_bound_of_integers_that_covers_more_is_refused(table: str, tmp_path: Path) -> None:
    controller = controller_of_case("gantry")
    source, header = (controller.files[f"gantry.{kind}"].decode() for kind in ("c", "h"))
    values = controller.program.table(table).values
    by = 1 if table.endswith("upper") else -1
    head = source.index(f"gantry_{table}[")
    altered = source[:head] + source[head:].replace(str(int(values[0])), str(int(values[0]) + by), 1)
    assert altered != source
    assert exit_code_of_checker(tmp_path, controller, altered, header) == 1


def test_noise_as_large_as_the_start_leaves_no_covered_start() -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text() + "\n[plant]\nnoise = 0.3\n"
    assert not stt.build(parse_task(text)).covered([0.25, 0.25])


@pytest.mark.parametrize("plant", ["", "[plant]\nw_max = 0.1\n"])
def test_without_a_period_covered_allows_for_the_error_of_unwrapping(plant: str) -> None:
    task = parse_task(
        'name = "spin"\nprescribed_time = 6\ninitial_state = [10]\naxes = ["yaw"]\nperiodic = { yaw = 6.28 }\n'
        "[state_space]\nlower = [-3]\nupper = [3.28]\n[initial_set]\nlower = [9.8]\nupper = [10.2]\n"
        "[target_set]\nlower = [8]\nupper = [9]\n" + plant
    )
    controller = stt.build(task)
    error = float(task.closed_axes[0].unwrap_error)
    lower, upper = controller.tube(0.0)
    half_width, middle = (upper[0] - lower[0]) / 2 * 0.99, (upper[0] + lower[0]) / 2
    assert not controller.covered([middle + half_width - 0.9 * error])
    assert controller.covered([middle + half_width - 1.1 * error])
