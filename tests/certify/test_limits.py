"""P8, limits: a task with u_max and plant bounds gets a tube whose motion needs no more than u_max, or a refusal with a remedy."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stt_codegen as stt
from benchmarks.suites.remedies import follow_remedies, refusal_of
from stt_codegen.certify.certificate import Certificate
from stt_codegen.checker import check_files
from stt_codegen.compare.comparison import compare
from stt_codegen.constraints import control_authority
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.emit.render import render
from stt_codegen.errors import BadInput
from stt_codegen.loop.plants_at_bounds import corner_plants
from stt_codegen.loop.simulate import DISTURBANCES, Loop, Scenario
from stt_codegen.pipeline import EmittedController, build_program, certify, design_tube
from stt_codegen.plants import PLANTS, Plant
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.report.analysis import Analysis
from stt_codegen.sampling.continuous import holds_saturated
from stt_codegen.task.load import parse_task
from stt_codegen.task.task import Task
from tests.support.controllers import build_once, controller_of

CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "pushed": ({"u_max": "1"}, {"w_max": "0.3"}),
    "weak": ({"u_max": ["1.3", "1.1"]}, {"w_max": "0.1", "f_max": "0.1", "g_min": "0.8"}),
    "coupled": ({"u_max": ["1.2", "1.3"]}, {"w_max": "0.2", "g_cross": "0.1"}),
    "double": ({"u_max": "1"}, {"g_max": "2"}),
}


def task_with(control: dict[str, Any], plant: dict[str, Any], **more: Any) -> Task:
    """Return the task omni_s2 with another [control] and [plant]."""
    return controller_of("omni_s2").task.changed(control=control, plant=plant, **more)


def limits_finding(certificate: Certificate) -> Any:
    """Return the certificate's finding of P8."""
    (finding,) = (f for f in certificate.findings if f.code == "P8")
    return finding


def write_with_claim(task: Task, controller: EmittedController, certificate: Certificate, folder: Path) -> list[str]:
    """Write the controller's files with a certificate that claims success, and return the checker's arguments."""
    files = render(task, controller.design, controller.program, certificate)
    proof = f"{task.name}.certificate.json"
    files[proof] = json.dumps({**json.loads(files[proof]), "certified": True}).encode()
    for name, data in files.items():
        (folder / name).write_bytes(data)
    (folder / "task.toml").write_text(task_file_text(task))
    return [str(folder / name) for name in ("task.toml", f"{task.name}.c", proof)]


def task_file_text(task: Task) -> str:
    """Return the text of omni_s2's task file with the [control], [plant] and [emit] of this task."""
    text = (Path(__file__).parents[2] / "tasks" / "omni_s2.toml").read_text()
    head = text[: text.index("[control]")]

    def table(name: str, fields: Any) -> str:
        stated = {k: v for k, v in fields if v is not None and k in fields_of[name]}
        lines = [f"{k} = {[float(x) for x in v] if isinstance(v, tuple) else float(v)}" for k, v in stated.items()]
        return "\n".join([f"[{name}]", *lines, ""])

    fields_of = {"control": task.control.model_fields_set, "plant": task.plant.model_fields_set}
    emit = f'[emit]\nscalar = "{task.emit.scalar}"\n' if task.emit.model_fields_set else ""
    return head + table("control", task.control) + table("plant", task.plant) + emit


@pytest.mark.parametrize("name", CASES)
def test_the_tube_needs_no_more_input_than_u_max(name: str, tmp_path: Path) -> None:
    """The certified margin is no larger than the exact edges show at 20,001 times; the checker computes the same margin."""
    task = task_with(*CASES[name])
    controller = build_once(task)
    finding = limits_finding(controller.certificate)
    t = np.linspace(0, 9, 20001)
    lower_rate, upper_rate = edge_rates(controller, t)
    authority = np.array([float(v) for v in control_authority(task)])
    assert (lower_rate.max(axis=0) < authority).all()
    assert (-upper_rate.min(axis=0) < authority).all()
    sampled_margin = min((authority - lower_rate.max(axis=0)).min(), (authority + upper_rate.min(axis=0)).min())
    assert 0 < float(finding.margin) <= sampled_margin + 1e-9  # the certificate bounds rates by their Bezier coefficients
    assert check_files(write_with_claim(task, controller, controller.certificate, tmp_path)) == 0


def edge_rates(controller: EmittedController, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rates of the exact lower and upper edges at times t within [0, 9], from differences of the control points."""
    assert isinstance(controller.design, RefinedDesign)
    table = controller.design.integers() * float(controller.design.unit)
    k = np.minimum((t / 9 * controller.design.segments).astype(int), controller.design.segments - 1)
    s = t / 9 * controller.design.segments - k
    weights = np.stack([-3 * (1 - s) ** 2, 9 * s**2 - 12 * s, -9 * s**2 + 6 * s + 3, 3 * s**2])
    rates = sum(weights[j][:, None, None] * table[k + j] for j in range(4)) * controller.design.segments / 9
    return rates[..., 0], rates[..., 1]


def test_a_tube_that_is_too_fast_for_its_limit_is_refused_by_both(tmp_path: Path) -> None:
    """A tube of a task without limits, certified with ever lower limits: tool and checker agree, and refuse from some limit on."""
    free = controller_of("omni_s2")
    fastest = max(float(v) for v in free.certificate.speed)
    are_accepted = []
    for k, factor in enumerate((2.0, 1.1, 1.001, 0.999, 0.9, 0.5)):
        task = task_with({"u_max": f"{0.3 + factor * fastest:.6f}"}, {"w_max": "0.3"})
        certificate = certify(task, free.design, build_program(task, free.design))
        folder = tmp_path / str(k)
        folder.mkdir()
        exit_code = check_files(
            write_with_claim(
                task, dataclasses.replace(free, task=task, program=build_program(task, free.design)), certificate, folder
            )
        )
        assert (exit_code == 0) == certificate.holds == limits_finding(certificate).holds
        are_accepted.append(exit_code == 0)
    assert are_accepted[0]
    assert not are_accepted[-1]
    assert are_accepted == sorted(are_accepted, reverse=True)


def test_p8_is_required_only_where_limits_and_a_plant_are_stated_without_a_period() -> None:
    for control, plant in (({"u_max": "1"}, {}), ({}, {"w_max": "0.1"}), ({"u_max": "2"}, {"noise": "0.001"})):
        controller = build_once(task_with(control, plant))
        assert not [f for f in controller.certificate.findings if f.code == "P8"]
        assert controller.design == controller_of("omni_s2").design  # the tube has no further condition
    sampled = build_once(task_with({"u_max": "1.3", "gain": "0.05", "period": "0.02"}, {"w_max": "0.3"}))
    assert not [f for f in sampled.certificate.findings if f.code == "P8"]  # P9 implies it


@pytest.mark.parametrize(
    ("control", "plant"),
    [
        ({"u_max": "0.9"}, {"w_max": "0.3"}),
        ({"u_max": "0.25"}, {"w_max": "0.3"}),
        ({"u_max": "0.9"}, {"f_max": "0.1", "w_max": "0.2"}),
    ],
)
def test_every_remedy_that_a_refusal_names_works(control: dict[str, str], plant: dict[str, str]) -> None:
    task = task_with(control, plant)
    assert refusal_of(task).startswith(f"limits (P8): no tube was found within control.u_max = {control['u_max']}; certified ")
    assert ["control.u_max"] in [list(remedy) for remedy in follow_remedies(task)]


def test_a_saturated_law_keeps_the_state_inside_where_saturation_is_proved() -> None:
    """The gain is so high that u saturates most of the time; the disturbance is the strongest; u changes 20,000 times a second."""
    task = task_with({"u_max": "1", "gain": "5"}, {"w_max": "0.3"})
    controller = build_once(task)
    analysis = Analysis(controller)
    (saturation,) = (h for h in analysis.hypotheses() if h.name == "saturation")
    assert saturation.holds
    loop = Loop(controller, PLANTS["integrator"])
    for kind in DISTURBANCES[1:]:
        run = loop.run(Scenario(rate=20000.0, disturbance=kind, strength=0.3, seed=1))
        assert run.kept, kind
        assert max(run.u) <= 1
    with_law = analysis.sampled_loop.with_law
    assert holds_saturated(analysis.sampled_loop)
    assert not holds_saturated(with_law(gain=np.full(2, 1e-4)))  # |u| is too small even at the largest |e|
    assert not holds_saturated(with_law(u_max=np.full(2, 0.3 + 0.9 * float(min(controller.certificate.speed)))))


def test_where_p8_fails_the_state_leaves_whatever_the_gain() -> None:
    """Half of the tube's speed is more than the input has left, so the disturbance pushes the state out, at a gain of 20 too."""
    unlimited = controller_of("omni_s2")
    speed = min(float(v) for v in unlimited.certificate.speed)
    task = task_with({"u_max": f"{0.3 + 0.5 * speed:.4f}", "gain": "20"}, {"w_max": "0.3"})
    design = design_tube(unlimited.task)
    program = build_program(task, design)
    assert not certify(task, design, program).holds
    controller = dataclasses.replace(
        unlimited, task=task, program=program, files=render(task, design, program, certify(task, design, program))
    )
    runs = [
        Loop(controller, PLANTS["integrator"]).run(Scenario(rate=20000.0, disturbance=kind, strength=0.3, seed=1))
        for kind in DISTURBANCES[1:]
    ]
    assert any(not run.kept for run in runs)


def test_the_header_says_what_is_proved() -> None:
    controller = build_once(task_with(*CASES["pushed"]))
    assert b"enough to hold the state in it (P8)" in controller.files["omni_s2.h"]
    assert Fraction(1, 1) == controller.task.u_max[0]  # type: ignore[index]


def test_a_plant_that_leaves_no_input_for_the_tube_is_refused() -> None:
    for cross in ("1", "2"):
        with pytest.raises(stt.NotCertified, match=r"limits \(P8\)"):
            build_once(task_with({"u_max": "3"}, {"g_cross": cross}))


def test_a_gain_that_is_too_low_to_reach_the_limit_has_no_proof_of_saturation() -> None:
    controller = build_once(task_with({"u_max": "1", "gain": "1e-12"}, {"w_max": "0.3"}))
    (saturation,) = (h for h in Analysis(controller).hypotheses() if h.name == "saturation")
    assert not saturation.holds


# ------------------------------------------------------------------------------------------------ the vector u scaled to its limit

SCALED = """
name = "scaled"
prescribed_time = 5.0
initial_state = [0.0, 0.0]
state_space = { lower = [-3, -3], upper = [3, 3] }
initial_set = { lower = [-1, -1], upper = [1, 1] }
target_set = { lower = [-1.2, -1.2], upper = [1.2, 1.2] }
control = { gain = 1.0, u_max = 1.0, saturate = "scale" }
plant = { g_min = 0.37, g_max = 4.7 }
"""


def coupled(u: Any) -> Any:
    """Return g(u) of a plant whose inputs are much coupled; it is positive definite."""
    return [[1, 1.5], [1.5, 4]]


def test_scaled_u_stays_where_clipped_u_leaves() -> None:
    """From the same starts the clipped law leaves the tube and the scaled law never does; only the scaled one has a proof."""
    scaled = build_once(parse_task(SCALED))
    clipped = build_once(
        parse_task(SCALED.replace(', saturate = "scale"', "").replace("g_max = 4.7", "g_max = 4.7, g_cross = 0"))
    )
    plant = Plant(name="coupled", dimension=2, drift=lambda x: [0, 0], input_matrix=coupled)
    saturation = next(h for h in Analysis(scaled, plant).hypotheses() if h.name == "saturation")
    assert saturation.holds
    assert not next(h for h in Analysis(clipped, plant).hypotheses() if h.name == "saturation").holds
    draw, left_counts = np.random.default_rng(4), [0, 0]
    starts = [(0.9, -0.97), *(tuple(draw.uniform(-0.98, 0.98, size=2).tolist()) for _ in range(40))]
    for k, controller in enumerate((scaled, clipped)):
        loop = Loop(controller, plant)
        runs = [loop.run(Scenario(rate=2000.0, start=start)) for start in starts]
        left_counts[k] = sum(not run.kept for run in runs)
        assert max(max(run.u) for run in runs) <= 1.0
    assert left_counts[0] == 0
    assert left_counts[1] > 0


def test_a_scaled_u_keeps_its_direction() -> None:
    controller = build_once(parse_task(SCALED + 'emit = { scalar = "double" }'))
    without_limit = build_once(
        parse_task(SCALED.replace('u_max = 1.0, saturate = "scale"', "u_max = 1e6") + 'emit = { scalar = "double" }')
    )
    scaled, unlimited = (load_module("scaled", c.files["scaled.py"]) for c in (controller, without_limit))
    draw = np.random.default_rng(0)
    is_scaled = set()
    for _ in range(300):
        x = draw.uniform(-1.3, 1.3, size=2)
        (_, u), (_, unscaled_u) = scaled.control(1.0, x), unlimited.control(1.0, x)
        largest = max(map(abs, unscaled_u))
        is_scaled.add(largest > 1)
        assert np.allclose(u, np.array(unscaled_u) * min(1.0, 1.0 / max(largest, 1e-300)), rtol=1e-12, atol=1e-15)
        assert max(map(abs, u)) <= 1.0
    assert is_scaled == {True, False}


def test_backends_agree_on_a_scaled_u_and_the_checker_refuses_another(tmp_path: Path) -> None:
    (tmp_path / "task.toml").write_text(SCALED)
    controller = build_once(parse_task(SCALED))
    for name, data in controller.files.items():
        (tmp_path / name).write_bytes(data)
    arguments = [str(tmp_path / f) for f in ("task.toml", "scaled.c", "scaled.certificate.json")]
    assert check_files(arguments) == 0
    for old, new in (
        (b"u_r * factor", b"u_r / factor"),
        (b"over ? largest : 1.0F", b"over ? 1.0F : largest"),
        (b"more ? size : largest", b"more ? largest : size"),
        (b"const scaled_real u_r = u[r];", b"u[r] = 0.0F;\n        const scaled_real u_r = u[r];"),
        (b"const scaled_real u_r = u[r];", b"const scaled_real u_r = x[r];"),
    ):
        source = controller.files["scaled.c"]
        assert source.count(old) == 1
        changed = source.replace(old, new)
        proof = json.loads(controller.files["scaled.certificate.json"])
        proof["sha256"]["scaled.c"] = hashlib.sha256(changed).hexdigest()
        (tmp_path / "scaled.c").write_bytes(changed)
        (tmp_path / "scaled.certificate.json").write_text(json.dumps(proof))
        assert check_files(arguments) == 1
    rows = compare(controller.task, 400)
    assert all(row.share <= 1 for row in rows)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("u_max = 1.0, ", "", "control.u_max"),
        ("u_max = 1.0", "u_max = [1.0, 2.0]", "one number"),
        ("gain = 1.0", "gain = [1.0, 2.0]", "one number"),
        ("gain = 1.0", "period = 0.01", "sampled"),
        ("g_min = 0.37", "g_min = [0.37, 0.4]", "norms"),
        ("g_min = 0.37", "order = 2, g_min = 0.37", "order 1"),
    ],
)
def test_what_cannot_be_scaled_is_refused(old: str, new: str, message: str) -> None:
    with pytest.raises(BadInput, match=message):
        parse_task(SCALED.replace(old, new))


def test_a_tube_for_a_scaled_u_moves_no_faster_than_the_norm_allows() -> None:
    """Both edges move no faster than (g_min u_max - f_max - w_max)/sqrt(n), which `control_authority` rounds down."""
    text = SCALED.replace(
        "target_set = { lower = [-1.2, -1.2], upper = [1.2, 1.2] }", "target_set = { lower = [0, 0], upper = [2, 2] }"
    )
    task = parse_task(
        text.replace("g_max = 4.7", "g_max = 4.7, w_max = 0.02").replace("prescribed_time = 5.0", "prescribed_time = 15.0")
    )
    controller = build_once(task)
    assert 0 < (Fraction("0.37") - Fraction("0.02")) ** 2 / 2 - control_authority(task)[0] ** 2 < Fraction(1, 10**10)
    design = controller.design
    assert isinstance(design, RefinedDesign)
    fastest = 3 * np.abs(np.diff(design.bezier(), axis=3)).max() * float(design.unit) * design.segments / 15.0
    assert fastest <= float(control_authority(task)[0])
    assert follow_remedies(task.changed(prescribed_time=Fraction("0.5")))


@pytest.mark.parametrize(
    ("plant", "drift", "covered"),
    [
        ("g_min = 0.37, g_max = 4.7", 0.0, True),
        ("g_min = 0.9, g_max = 4.7, g_cross = 1.5", 0.0, False),  # every g_ii is above, g_s is not
        ("g_min = 0.37, g_max = 4.7, f_max = 0.3", 0.29, False),  # every |f_i| is below, |f| is not
        ("g_min = 0.37, g_max = 4.7, f_max = 0.3", 0.2, True),
    ],
)
def test_a_plant_is_covered_for_a_scaled_u_by_its_norms(plant: str, drift: float, covered: bool) -> None:
    controller = build_once(parse_task(SCALED.replace("g_min = 0.37, g_max = 4.7", plant)))
    user_plant = Plant(name="coupled", dimension=2, drift=lambda x: [drift, drift], input_matrix=coupled)
    assert Analysis(controller, user_plant).is_covered == covered


def test_the_worst_plants_for_a_scaled_u_are_within_the_norms() -> None:
    task = parse_task(SCALED.replace("g_max = 4.7", "g_max = 4.7, g_cross = 3"))
    for plant in corner_plants(task):
        g = np.array(plant.g(np.zeros((2, 1))))
        assert np.linalg.eigvalsh((g + g.T) / 2)[0] >= 0.37 - 1e-12
        assert np.linalg.norm(g, 2) <= 4.7
        assert abs(g[0, 1]) > 1
