"""P8: a task whose u is limited and whose plant has bounds gets a tube that needs no more, or is told what would do."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stt_codegen as stt
from stt_codegen.certify import checker
from stt_codegen.certify.certificate import Certificate
from stt_codegen.compare.comparison import compare
from stt_codegen.constraints import control_authority
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.emit.render import render
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.command import within_bounds
from stt_codegen.loop.simulate import KINDS, Loop, Scenario
from stt_codegen.pipeline import EmittedController, build_program, certify, design_tube
from stt_codegen.plants import PLANTS, Plant
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.report.analysis import Analysis
from stt_codegen.sampling.continuous import holds_saturated
from stt_codegen.task.load import parse_task
from stt_codegen.task.task import Task
from tests.support.controllers import built, controller_of

CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "pushed": ({"u_max": "1"}, {"w_max": "0.3"}),
    "weak": ({"u_max": ["1.3", "1.1"]}, {"w_max": "0.1", "f_max": "0.1", "g_min": "0.8"}),
    "coupled": ({"u_max": ["1.2", "1.3"]}, {"w_max": "0.2", "g_cross": "0.1"}),
    "double": ({"u_max": "1"}, {"g_max": "2"}),
}


def task_with(control: dict[str, Any], plant: dict[str, Any], **more: Any) -> Task:
    return controller_of("omni_s2").task.changed(control=control, plant=plant, **more)


def eighth(certificate: Certificate) -> Any:
    (found,) = (f for f in certificate.findings if f.code == "P8")
    return found


def claimed(task: Task, made: EmittedController, certificate: Certificate, folder: Path) -> list[str]:
    """The files, with a certificate that claims success."""
    files = render(task, made.design, made.program, certificate)
    proof = f"{task.name}.certificate.json"
    files[proof] = json.dumps({**json.loads(files[proof]), "certified": True}).encode()
    for name, data in files.items():
        (folder / name).write_bytes(data)
    (folder / "task.toml").write_text(told(task))
    return [str(folder / name) for name in ("task.toml", f"{task.name}.c", proof)]


def told(task: Task) -> str:
    """The task file of omni_s2 with another [control] and [plant]."""
    text = (Path(__file__).parents[2] / "tasks" / "omni_s2.toml").read_text()
    head = text[: text.index("[control]")]

    def table(name: str, fields: Any) -> str:
        shown = {k: v for k, v in fields if v is not None and k in fields_of[name]}
        lines = [f"{k} = {[float(x) for x in v] if isinstance(v, tuple) else float(v)}" for k, v in shown.items()]
        return "\n".join([f"[{name}]", *lines, ""])

    fields_of = {"control": task.control.model_fields_set, "plant": task.plant.model_fields_set}
    emit = f'[emit]\nscalar = "{task.emit.scalar}"\n' if task.emit.model_fields_set else ""
    return head + table("control", task.control) + table("plant", task.plant) + emit


@pytest.mark.parametrize("name", CASES)
def test_the_tube_needs_no_more_than_u_max(name: str, tmp_path: Path) -> None:
    """Seen densely at the exact edges; the checker finds the same number."""
    task = task_with(*CASES[name])
    made = built(task)
    finding = eighth(made.certificate)
    t = np.linspace(0, 9, 20001)
    low, high = made_rates(made, t)
    spare = np.array([float(v) for v in control_authority(task)])
    assert (low.max(axis=0) < spare).all()
    assert (-high.min(axis=0) < spare).all()
    seen = min((spare - low.max(axis=0)).min(), (spare + high.min(axis=0)).min())
    assert 0 < float(finding.margin) <= seen + 1e-9  # Bezier coefficients bound what is seen between them
    assert checker.main(claimed(task, made, made.certificate, tmp_path)) == 0


def made_rates(made: EmittedController, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rates of the exact edges by differences of the spline's control points."""
    assert isinstance(made.design, RefinedDesign)
    table = made.design.integers() * float(made.design.unit)
    k = np.minimum((t / 9 * made.design.segments).astype(int), made.design.segments - 1)
    s = t / 9 * made.design.segments - k
    weights = np.stack([-3 * (1 - s) ** 2, 9 * s**2 - 12 * s, -9 * s**2 + 6 * s + 3, 3 * s**2])
    rates = sum(weights[j][:, None, None] * table[k + j] for j in range(4)) * made.design.segments / 9
    return rates[..., 0], rates[..., 1]


def test_a_tube_that_is_too_fast_for_its_limit_is_refused_by_both(tmp_path: Path) -> None:
    """Tubes of a task without limits, judged by ever lower ones: tool and checker agree, and turn where the fastest edge is."""
    free = controller_of("omni_s2")
    fastest = max(float(v) for v in free.certificate.speed)
    answers = []
    for k, factor in enumerate((2.0, 1.1, 1.001, 0.999, 0.9, 0.5)):
        task = task_with({"u_max": f"{0.3 + factor * fastest:.6f}"}, {"w_max": "0.3"})
        certificate = certify(task, free.design, build_program(task, free.design))
        folder = tmp_path / str(k)
        folder.mkdir()
        answer = checker.main(
            claimed(task, dataclasses.replace(free, task=task, program=build_program(task, free.design)), certificate, folder)
        )
        assert (answer == 0) == certificate.holds == eighth(certificate).holds
        answers.append(answer == 0)
    assert answers[0]
    assert not answers[-1]
    assert answers == sorted(answers, reverse=True)


def test_p8_is_asked_for_only_where_limits_and_a_plant_are_stated_without_a_period() -> None:
    for control, plant in (({"u_max": "1"}, {}), ({}, {"w_max": "0.1"}), ({"u_max": "2"}, {"noise": "0.001"})):
        made = built(task_with(control, plant))
        assert not [f for f in made.certificate.findings if f.code == "P8"]
        assert made.design == controller_of("omni_s2").design  # nothing else is asked of the tube
    sampled = built(task_with({"u_max": "1.3", "gain": "0.05", "period": "0.02"}, {"w_max": "0.3"}))
    assert not [f for f in sampled.certificate.findings if f.code == "P8"]  # P9 asks for more


@pytest.mark.parametrize(
    ("control", "plant"),
    [
        ({"u_max": "0.9"}, {"w_max": "0.3"}),
        ({"u_max": "0.25"}, {"w_max": "0.3"}),
        ({"u_max": "0.9"}, {"f_max": "0.1", "w_max": "0.2"}),
    ],
)
def test_what_a_refusal_advises_does(control: dict[str, str], plant: dict[str, str]) -> None:
    task = task_with(control, plant)
    with pytest.raises(
        stt.NotCertified, match=r"limits \(P8\): no tube was found within control.u_max 0\.\d+; raise control.u_max to"
    ) as e:
        built(task)
    said = str(e.value)
    assert built(task.changed(control={"u_max": re.findall(r"u_max to ([\d.]+)", said)[0]})).certificate.holds
    for longer in re.findall(r"prescribed_time to ([\d.]+)", said):
        assert built(task.changed(prescribed_time=longer)).certificate.holds
    milder = dict(re.findall(r"plant\.(\w+) to ([\d.]+\d)", said))
    if milder:
        assert built(task.changed(plant=milder)).certificate.holds


def test_a_saturated_law_keeps_the_state_where_prove_says_so() -> None:
    """A high gain that saturates most of the time, pushed as hard as the bounds allow, in practice continuous."""
    task = task_with({"u_max": "1", "gain": "5"}, {"w_max": "0.3"})
    made = built(task)
    analysis = Analysis(made)
    (free,) = (h for h in analysis.hypotheses() if h.name == "saturation")
    assert free.holds
    loop = Loop(made, PLANTS["integrator"])
    for kind in KINDS[1:]:
        run = loop.run(Scenario(rate=20000.0, disturbance=kind, strength=0.3, seed=1))
        assert run.kept, kind
        assert max(run.u) <= 1
    law = analysis.setting.with_law
    assert holds_saturated(analysis.setting)
    assert not holds_saturated(law(gain=np.full(2, 1e-4)))  # asks for too little even at the clamp
    assert not holds_saturated(law(u_max=np.full(2, 0.3 + 0.9 * float(min(made.certificate.speed)))))


def test_what_is_needed_is_needed() -> None:
    """Where P8 fails the state is pushed out at that edge, whatever the gain."""
    free = controller_of("omni_s2")
    speed = min(float(v) for v in free.certificate.speed)
    task = task_with({"u_max": f"{0.3 + 0.5 * speed:.4f}", "gain": "20"}, {"w_max": "0.3"})
    design = design_tube(free.task)
    program = build_program(task, design)
    assert not certify(task, design, program).holds
    made = dataclasses.replace(
        free, task=task, program=program, files=render(task, design, program, certify(task, design, program))
    )
    runs = [
        Loop(made, PLANTS["integrator"]).run(Scenario(rate=20000.0, disturbance=kind, strength=0.3, seed=1)) for kind in KINDS[1:]
    ]
    assert any(not run.kept for run in runs)


def test_the_header_says_what_is_proved() -> None:
    made = built(task_with(*CASES["pushed"]))
    assert b"enough to hold the state in it (P8)" in made.files["omni_s2.h"]
    assert Fraction(1, 1) == made.task.u_max[0]  # type: ignore[index]


def test_a_plant_that_leaves_nothing_to_spare_is_refused() -> None:
    for cross in ("1", "2"):
        with pytest.raises(stt.NotCertified, match=r"limits \(P8\)"):
            built(task_with({"u_max": "3"}, {"g_cross": cross}))


def test_a_gain_that_asks_for_too_little_is_not_saturation_free() -> None:
    made = built(task_with({"u_max": "1", "gain": "1e-12"}, {"w_max": "0.3"}))
    (free,) = (h for h in Analysis(made).hypotheses() if h.name == "saturation")
    assert not free.holds


# ------------------------------------------------------------------------------------------------ u scaled as a whole

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
    return [[1, 1.5], [1.5, 4]]


def test_scaled_u_stays_where_clipped_u_leaves() -> None:
    """g = [[1, 1.5], [1.5, 4]], definite and much coupled: from the same starts the clipped law leaves the tube, the scaled never
    does; `prove` says "saturation: yes" of the scaled one."""
    scaled = built(parse_task(SCALED))
    clipped = built(parse_task(SCALED.replace(', saturate = "scale"', "").replace("g_max = 4.7", "g_max = 4.7, g_cross = 0")))
    plant = Plant(name="coupled", dimension=2, drift=lambda x: [0, 0], input_matrix=coupled)
    saturation = next(h for h in Analysis(scaled, plant).hypotheses() if h.name == "saturation")
    assert saturation.holds
    assert not next(h for h in Analysis(clipped, plant).hypotheses() if h.name == "saturation").holds
    draw, left = np.random.default_rng(4), [0, 0]
    starts = [(0.9, -0.97), *(tuple(draw.uniform(-0.98, 0.98, size=2).tolist()) for _ in range(40))]
    for k, controller in enumerate((scaled, clipped)):
        loop = Loop(controller, plant)
        runs = [loop.run(Scenario(rate=2000.0, start=start)) for start in starts]
        left[k] = sum(not run.kept for run in runs)
        assert max(max(run.u) for run in runs) <= 1.0
    assert left[0] == 0
    assert left[1] > 0


def test_a_scaled_u_keeps_its_direction() -> None:
    controller = built(parse_task(SCALED + 'emit = { scalar = "double" }'))
    free = built(parse_task(SCALED.replace('u_max = 1.0, saturate = "scale"', "u_max = 1e6") + 'emit = { scalar = "double" }'))
    own, other = (load_module("scaled", c.files["scaled.py"]) for c in (controller, free))
    draw = np.random.default_rng(0)
    some = set()
    for _ in range(300):
        x = draw.uniform(-1.3, 1.3, size=2)
        (_, u), (_, law) = own.control(1.0, x), other.control(1.0, x)
        largest = max(map(abs, law))
        some.add(largest > 1)
        assert np.allclose(u, np.array(law) * min(1.0, 1.0 / max(largest, 1e-300)), rtol=1e-12, atol=1e-15)
        assert max(map(abs, u)) <= 1.0
    assert some == {True, False}


def test_backends_and_checker_know_a_scaled_u(tmp_path: Path) -> None:
    (tmp_path / "task.toml").write_text(SCALED)
    controller = built(parse_task(SCALED))
    for name, data in controller.files.items():
        (tmp_path / name).write_bytes(data)
    arguments = [str(tmp_path / f) for f in ("task.toml", "scaled.c", "scaled.certificate.json")]
    assert checker.main(arguments) == 0
    for old, new in (
        (b"u_law_i * factor", b"u_law_i / factor"),
        (b"over ? largest : 1.0F", b"over ? 1.0F : largest"),
        (b"more ? size : largest", b"more ? largest : size"),
        (b"const scaled_real u_law_i = u[i3];", b"u[i3] = 0.0F;\n        const scaled_real u_law_i = u[i3];"),
        (b"const scaled_real u_law_i = u[i3];", b"const scaled_real u_law_i = x[i3];"),
    ):
        source = controller.files["scaled.c"]
        assert source.count(old) == 1
        changed = source.replace(old, new)
        proof = json.loads(controller.files["scaled.certificate.json"])
        proof["sha256"]["scaled.c"] = hashlib.sha256(changed).hexdigest()
        (tmp_path / "scaled.c").write_bytes(changed)
        (tmp_path / "scaled.certificate.json").write_text(json.dumps(proof))
        assert checker.main(arguments) == 1
    rows = compare(controller.task, 400)
    assert all(row.share <= 1 for row in rows)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("u_max = 1.0, ", "", "control.u_max"),
        ("u_max = 1.0", "u_max = [1.0, 2.0]", "one number"),
        ("gain = 1.0", "gain = [1.0, 2.0]", "one number"),
        ("gain = 1.0", "period = 0.01", "sampled"),
        ("g_min = 0.37", "g_min = [0.37, 0.4]", "norms"),
        ("g_min = 0.37", "order = 2, g_min = 0.37", "order 1"),
    ],
)
def test_what_cannot_be_scaled_is_refused(old: str, new: str, told: str) -> None:
    with pytest.raises(BadInput, match=told):
        parse_task(SCALED.replace(old, new))


def test_a_tube_for_a_scaled_u_moves_no_faster_than_the_norm_allows() -> None:
    """Either edge, either way, within (g_min u_max - f_max - w_max)/sqrt(n); and one unit more in P8's room is missing."""
    text = SCALED.replace(
        "target_set = { lower = [-1.2, -1.2], upper = [1.2, 1.2] }", "target_set = { lower = [0, 0], upper = [2, 2] }"
    )
    task = parse_task(
        text.replace("g_max = 4.7", "g_max = 4.7, w_max = 0.02").replace("prescribed_time = 5.0", "prescribed_time = 15.0")
    )
    controller = built(task)
    assert 0 < (Fraction("0.37") - Fraction("0.02")) ** 2 / 2 - control_authority(task)[0] ** 2 < Fraction(1, 10**10)
    design = controller.design
    assert isinstance(design, RefinedDesign)
    fastest = 3 * np.abs(np.diff(design.bezier(), axis=3)).max() * float(design.unit) * design.segments / 15.0
    assert fastest <= float(control_authority(task)[0])
    with pytest.raises(NotCertified, match="raise"):
        built(task.changed(prescribed_time=Fraction("0.5")))


@pytest.mark.parametrize(
    ("plant", "drift", "covered"),
    [
        ("g_min = 0.37, g_max = 4.7", 0.0, True),
        ("g_min = 0.9, g_max = 4.7, g_cross = 1.5", 0.0, False),  # every g_ii is above, g_s is not
        ("g_min = 0.37, g_max = 4.7, f_max = 0.3", 0.29, False),  # every |f_i| is below, |f| is not
        ("g_min = 0.37, g_max = 4.7, f_max = 0.3", 0.2, True),
    ],
)
def test_what_a_scaled_u_holds_against_is_told_by_norms(plant: str, drift: float, covered: bool) -> None:
    controller = built(parse_task(SCALED.replace("g_min = 0.37, g_max = 4.7", plant)))
    own = Plant(name="coupled", dimension=2, drift=lambda x: [drift, drift], input_matrix=coupled)
    assert Analysis(controller, own).is_covered == covered


def test_the_worst_plants_for_a_scaled_u_are_within_the_norms() -> None:
    task = parse_task(SCALED.replace("g_max = 4.7", "g_max = 4.7, g_cross = 3"))
    for plant in within_bounds(task):
        g = np.array(plant.g(np.zeros((2, 1))))
        assert np.linalg.eigvalsh((g + g.T) / 2)[0] >= 0.37 - 1e-12
        assert np.linalg.norm(g, 2) <= 4.7
        assert abs(g[0, 1]) > 1
