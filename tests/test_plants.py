"""Plants: what is refused, and bounds over a box that hold at every state in it."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import arb

from stt_codegen.errors import BadInput
from stt_codegen.plants import PLANTS, Plant, model, plant_of
from stt_codegen.sampling.plant import Bounds, PlantEnclosure, bounds_of_task, least_eigenvalue
from stt_codegen.task import load_task
from stt_codegen.task.schema import PlantBounds

ROOT = Path(__file__).parent.parent
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
            assert (np.abs(f) <= b.push).all()
            assert np.linalg.norm(f) <= b.push_norm
            assert (b.least <= np.diag(g)).all()
            assert (np.abs(np.diag(g)) <= b.most).all()
            assert (np.abs(g - np.diag(np.diag(g))) <= b.cross).all()
            assert b.definite <= np.linalg.eigvalsh((g + g.T) / 2)[0] + 1e-15  # what NumPy rounds
            assert np.linalg.norm(g, 2) <= b.norm + 1e-15


def test_bounds_are_near_what_they_bound_on_a_small_box() -> None:
    """Not only safe: on a box of 1e-6 they are within 1e-4 of the values in its middle."""
    for name, n in BOXES.items():
        middle = [0.3, 0.7, -0.4][:n]
        b = PlantEnclosure(PLANTS[name], n, 1).over([(v - 1e-6, v + 1e-6) for v in middle])
        f, g = numbers(PLANTS[name], middle)
        assert np.abs(b.push - np.abs(f)).max() < 1e-4
        assert abs(b.definite - np.linalg.eigvalsh((g + g.T) / 2)[0]) < 1e-4
        assert abs(b.norm - np.linalg.norm(g, 2)) < 1e-4


def test_the_disturbance_joins_the_push() -> None:
    still = PlantEnclosure(PLANTS["integrator"], 2, 1).over([(0, 1), (0, 1)])
    windy = PlantEnclosure(Plant("w", "", 2, lambda x: [0, 0], lambda x: [[1, 0], [0, 1]], PLANTS["robot"].w_max + 3), 2, 1)
    over = windy.over([(0, 1), (0, 1)])
    assert (over.push >= still.push + 3).all()
    assert over.push_norm >= 3


def test_an_eigenvalue_bound_holds_for_every_matrix_in_the_balls() -> None:
    draw = np.random.default_rng(1)
    for n in (1, 2, 3, 5):
        middle, radius = draw.normal(size=(n, n)), draw.uniform(0, 0.1, size=(n, n))
        middle, radius = middle + middle.T, radius + radius.T
        balls = [[arb(float(m), float(r)) for m, r in zip(*rows, strict=True)] for rows in zip(middle, radius, strict=True)]
        bound = least_eigenvalue(balls)
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
    from fractions import Fraction

    exact = {k: Fraction(v) for k, v in bounds.items()}
    task = load_task(ROOT / "tasks" / "omni_s1.toml").model_copy(update={"plant": PlantBounds(**exact)})
    b: Bounds = bounds_of_task(task)
    assert (b.push.tolist(), b.least.tolist(), b.most.tolist()) == ([push] * 2, [least] * 2, [most] * 2)
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
        PlantEnclosure(Plant("odd", "", 1, lambda x: [ca.erf(x[0])], lambda x: [[1]]), 1, 1)


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
