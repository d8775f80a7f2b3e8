"""Plants: what is refused, and bounds over a box that hold at every state in it."""

from __future__ import annotations

import json
import random
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import arb
from typer.testing import CliRunner

from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_task
from stt_codegen.plants import PLANTS, Plant, model, plant_of
from stt_codegen.report.analysis import Analysis
from stt_codegen.report.plant_table import propose_bounds, uncovered_bounds
from stt_codegen.sampling.plant import Bounds, PlantEnclosure, bounds_of_task, minimum_eigenvalue
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.schema import PlantBounds
from tests.support.controllers import controller_of

ROOT = Path(__file__).parents[2]
BOXES = {"integrator": 2, "robot": 3, "spacecraft": 3, "arm": 2}


def numbers(plant: Any, x: list[float]) -> tuple[np.ndarray, np.ndarray]:
    f, g = model(plant, len(x))(x)
    return np.array(f).ravel(), np.array(g)


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("sign", [1, -1])
def test_bounds_over_a_box_hold_at_random_states_in_it(name: str, sign: int) -> None:
    draw = random.Random(name)
    plant, n = PLANTS[name], BOXES[name]
    for _ in range(5):
        box = [tuple(sorted(draw.uniform(-2, 2) for _ in range(2))) for _ in range(n)]
        b = PlantEnclosure(plant, n, sign).over(box)
        for _ in range(100):
            f, g = numbers(plant, [draw.uniform(*side) for side in box])
            g = sign * g
            assert (np.abs(f) <= b.disturbance).all()
            assert np.linalg.norm(f) <= b.disturbance_norm
            assert (b.diagonal_min <= np.diag(g)).all()
            assert (np.abs(np.diag(g)) <= b.diagonal_max).all()
            assert (np.abs(g - np.diag(np.diag(g))) <= b.cross).all()
            assert b.eigenvalue_min <= np.linalg.eigvalsh((g + g.T) / 2)[0] + 1e-15  # what NumPy rounds
            assert np.linalg.norm(g, 2) <= b.norm + 1e-15


def test_bounds_are_near_what_they_bound_on_a_small_box() -> None:
    """Not only safe: on a box of 1e-6 they are within 1e-4 of the values in its middle."""
    for name, n in BOXES.items():
        middle = [0.3, 0.7, -0.4][:n]
        b = PlantEnclosure(PLANTS[name], n, 1).over([(v - 1e-6, v + 1e-6) for v in middle])
        f, g = numbers(PLANTS[name], middle)
        assert np.abs(b.disturbance - np.abs(f)).max() < 1e-4
        assert abs(b.eigenvalue_min - np.linalg.eigvalsh((g + g.T) / 2)[0]) < 1e-4
        assert abs(b.norm - np.linalg.norm(g, 2)) < 1e-4


def test_the_disturbance_joins_the_push() -> None:
    still = PlantEnclosure(PLANTS["integrator"], 2, 1).over([(0, 1), (0, 1)])
    windy = PlantEnclosure(
        Plant(
            name="w",
            dimension=2,
            drift=lambda x: [0, 0],
            input_matrix=lambda x: [[1, 0], [0, 1]],
            w_max=PLANTS["robot"].w_max + 3,
        ),
        2,
        1,
    )
    over = windy.over([(0, 1), (0, 1)])
    assert (over.disturbance >= still.disturbance + 3).all()
    assert over.disturbance_norm >= 3


def test_an_eigenvalue_bound_holds_for_every_matrix_in_the_balls() -> None:
    draw = np.random.default_rng(1)
    for n in (1, 2, 3, 5):
        middle, radius = draw.normal(size=(n, n)), draw.uniform(0, 0.1, size=(n, n))
        middle, radius = middle + middle.T, radius + radius.T
        balls = [[arb(float(m), float(r)) for m, r in zip(*rows, strict=True)] for rows in zip(middle, radius, strict=True)]
        bound = minimum_eigenvalue(balls)
        for _ in range(50):
            share = np.triu(draw.uniform(-1, 1, size=(n, n)))
            inside = middle + radius * (share + np.triu(share, 1).T)
            assert bound <= np.linalg.eigvalsh(inside)[0] + 1e-14


@pytest.mark.parametrize(
    ("bounds", "push", "least", "most"),
    [
        ({}, 0.0, 1.0, 1.0),
        ({"f_max": 1, "w_max": 2}, 3.0, 1.0, 1.0),
        ({"g_min": 2}, 0.0, 2.0, 2.0),
        ({"g_max": 3}, 0.0, 1.0, 3.0),
        ({"g_max": "0.5"}, 0.0, 0.5, 0.5),
    ],
)
def test_a_task_states_its_plant_and_gaps_are_filled_without_contradiction(
    bounds: dict[str, Any], push: float, least: float, most: float
) -> None:
    exact = {k: Fraction(v) for k, v in bounds.items()}
    task = load_task(ROOT / "tasks" / "omni_s1.toml").model_copy(update={"plant": PlantBounds(**exact)})
    b: Bounds = bounds_of_task(task)
    assert (b.disturbance.tolist(), b.diagonal_min.tolist(), b.diagonal_max.tolist()) == ([push] * 2, [least] * 2, [most] * 2)
    assert not b.cross.any()


FILES = {
    "def f(x): return [0, 0]": "no function g(x)",
    "def f(x): return [0, 0]\ndef g(x): return [[1, 0]]": "g(x) has shape (1, 2)",
    "def f(x): return [0]\ndef g(x): return [[1, 0], [0, 1]]": "f(x) has shape (1, 1)",
    "import no_such_module": "ModuleNotFoundError",
    "def f(x): return 1 / 0\ndef g(x): return [[1, 0], [0, 1]]": "ZeroDivisionError",
    "def f(x): return [0, 0]\ndef g(x): return [[1, 0], [0, 1]]\nw_max = -1": "w_max is -1",
    "def f(x): return [0, 0]\ndef g(x): return [[1, 0], [0, 1]]\nw_max = 'much'": "w_max is 'much'",
}


@pytest.mark.parametrize(("text", "told"), FILES.items())
def test_a_plant_file_that_is_wrong_is_refused_with_what_is_wrong(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(text)
    with pytest.raises(BadInput) as refusal:
        plant_of(str(path), 2)
    assert told in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_plant_of_ones_own_is_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text("import casadi as ca\ndef f(x): return ca.sin(x)\ndef g(x): return ca.diag(2 + x)\nw_max = 0.25\n")
    plant = plant_of(str(path), 2)
    f, g = numbers(plant, [0.5, 1.0])
    assert np.allclose(f, np.sin([0.5, 1.0]), atol=0, rtol=1e-15)
    assert (g == np.diag([2.5, 3.0])).all()
    assert (plant.name, plant.w_max) == ("mine", 0.25)


def test_an_operation_that_cannot_be_enclosed_is_refused_by_name() -> None:
    import casadi as ca

    with pytest.raises(BadInput, match=r"cannot be enclosed.*(ERF|erf)"):
        PlantEnclosure(Plant(name="odd", dimension=1, drift=lambda x: [ca.erf(x[0])], input_matrix=lambda x: [[1]]), 1, 1)


@pytest.mark.parametrize(("name", "n"), [("robot", 2), ("arm", 3), ("nonesuch", 2), ("missing.py", 2)])
def test_a_plant_that_does_not_fit_is_refused(name: str, n: int) -> None:
    with pytest.raises(BadInput) as refusal:
        plant_of(name, n)
    assert name in str(refusal.value)


def test_all_built_in_plants_fit_some_example_task() -> None:
    dimensions = {load_task(p).dimension for p in sorted((ROOT / "tasks").glob("*.toml"))}
    for plant in PLANTS.values():
        assert plant.dimension is None or plant.dimension in dimensions
    assert set(BOXES) == set(PLANTS)


# ----------------------------------------------------------------------------------------------- [plant] of equations

SIZES = (0.0, 1e-18, 1e-10, 1e-9, 3e-7, 0.1234567, 1.0, 4321.5, 9.99e7)


def drawn_plant(draw: random.Random, order: int) -> Plant:
    """f and g with entries of any size, some linear in x, and |w| of any size; one in eight with a size that no task takes."""
    drift = [(draw.choice(SIZES), draw.choice(SIZES)) for _ in range(2)]
    drift[0] = (draw.choice((*[drift[0][0]] * 7, 1e12)), drift[0][1])
    sign = draw.choice((1, 1, -1))
    diagonal = [sign * draw.choice(SIZES[3:]) for _ in range(2)]
    diagonal[1] *= draw.choice((1, 1, 1, 1, 1, -1))
    beside = draw.choice((0.0, 0.1, 1e-14)) * min(map(abs, diagonal))
    w = Fraction(draw.choice((0.0, 1e-17, 0.1, 1 / 3)))

    def f(x: Any, *_: Any) -> Any:
        return [a + b * x[0] for a, b in drift]

    def g(x: Any, *_: Any) -> Any:
        return [[diagonal[0] * (1 + 0.1 * x[1]), beside], [beside * x[0], diagonal[1]]]

    return Plant(name="drawn", dimension=2, drift=f, input_matrix=g, w_max=w, order=order)


def with_table(text: str, lines: tuple[str, ...]) -> Any:
    """The task with its [plant] replaced by these lines."""
    rest = re.sub(r"(?ms)^\[plant\].*?(?=^\[|\Z)", "", text)
    return parse_task(rest + "\n" + "\n".join(lines) + "\n")


@pytest.mark.parametrize("order", [1, 2])
def test_bounds_that_are_printed_are_a_table_that_a_task_takes_and_that_covers_the_plant(order: int) -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    draw, printed, reasons = random.Random(order), 0, set()
    box = [(0.1, 0.6), (-0.3, 0.4), (1.0, 1.0), (1.0, 1.0)][: 2 * order]
    for _ in range(60):
        sign = draw.choice((1, 1, -1))
        task = with_table(text.replace("gain = 0.5", f"gain = {0.5 * sign}"), ("[plant]", f"order = {order}"))
        plant = drawn_plant(draw, order)
        bounds = [PlantEnclosure(plant, 2, sign, order).over(box)]
        found = propose_bounds(task, bounds, plant.w_max, lambda p=plant, s=sign: [PlantEnclosure(p, 2, -s, order).over(box)])
        if found.reason:
            reasons.add(re.search(r"would be|greater than 0; use|greater than 0$", found.reason)[0])
            assert not found.lines
            continue
        printed += 1
        stated = with_table(text.replace("gain = 0.5", f"gain = {0.5 * sign}"), found.lines)
        assert uncovered_bounds(stated, bounds) == []
    assert printed > 10
    assert reasons == {"would be", "greater than 0; use", "greater than 0"}


def test_what_does_not_cover_a_plant_is_named_with_both_numbers() -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    bounds = [PlantEnclosure(PLANTS["arm"], 2, 1).over([(0.1, 0.6), (-0.3, 0.4)])]
    task = with_table(text, ("[plant]",))
    lines = propose_bounds(task, bounds, Fraction(0), lambda: bounds).lines
    for name, told in (("f_max", "|f + w| of"), ("g_max", "g_ii of"), ("g_cross", "|g_ij| of"), ("g_min", "g_ii of")):
        value = float(next(line for line in lines if line.startswith(name)).partition("= ")[2])
        worse = value * 1.4 if name == "g_min" else value / 1.4
        missing = uncovered_bounds(
            with_table(text, tuple(f"{name} = {worse:.6g}" if v.startswith(name) else v for v in lines)), bounds
        )
        assert missing
        assert all(line.startswith(told) and line.endswith(f"{worse:.6g} is stated") for line in missing), missing


def prove(path: Path, *arguments: str) -> dict[str, Any]:
    result = CliRunner().invoke(app, ["prove", str(path), "--out", str(path.parent), "--json", *arguments])
    return dict(json.loads(result.stdout))


@pytest.mark.parametrize(("name", "plant"), [("omni_heading", "robot"), ("arm", "arm.py")])
def test_the_hypothesis_about_a_plant_holds_with_the_table_that_is_printed(name: str, plant: str) -> None:
    """Pasted in place of the task's own, with a period, for which [plant] has a row."""
    text = (ROOT / "tasks" / f"{name}.toml").read_text()
    controller = controller_of(name)
    model_ = plant_of(
        str(ROOT / "tasks" / plant) if plant.endswith(".py") else plant, 2 + (name == "omni_heading"), controller.task.order
    )
    proposed = Analysis(controller, model_).proposed
    assert proposed is not None
    task = with_table(text, proposed.lines).changed(control={"period": Fraction(1, 1000)})
    analysis = Analysis(build_task(task, uncertified=True, tube=controller.design), model_)
    row = next(h for h in analysis.hypotheses() if h.name == "[plant]")
    assert row.holds, row.statement


def test_a_plant_that_pulls_the_wrong_way_is_told_the_sign_that_does(tmp_path: Path) -> None:
    """No table for g = -1 with a positive gain; with the gain that is advised the table is there, and good."""
    plant, path = tmp_path / "wrong.py", tmp_path / "task.toml"
    plant.write_text("def f(x): return [0, 0]\ndef g(x): return [[-1, 0.005], [0.005, -1]]\n")
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    path.write_text(text)
    proposed = prove(path, "--plant", str(plant))["proposed_plant"]
    assert proposed["toml"] == ""
    assert "use a negative control.gain" in proposed["reason"]
    path.write_text(text.replace("gain = 0.5", "gain = -0.5"))
    proposed = prove(path, "--plant", str(plant))["proposed_plant"]
    assert proposed["reason"] == ""
    assert 0.99 < proposed["g_min"] < 1
