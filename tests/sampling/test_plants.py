"""Plants: which descriptions are refused, bounds over a box that hold at every state in it, and [plant] proposed from equations."""

from __future__ import annotations

import json
import random
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from flint import arb
from typer.testing import CliRunner

from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_task
from stt_codegen.plants import PLANTS, Plant, model, plant_of
from stt_codegen.report.analysis import Analysis
from stt_codegen.report.plant_table import component_extremes, propose_bounds, uncovered_bounds
from stt_codegen.sampling.plant import Bounds, PlantEnclosure, bounds_of_task, minimum_eigenvalue
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.schema import PlantBounds
from tests.support.controllers import controller_of

ROOT = Path(__file__).parents[2]
DIMENSIONS = {"integrator": 2, "robot": 3, "spacecraft": 3, "arm": 2}


def values_at(plant: Any, x: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return f(x) (n,) and g(x) (n, n) of a plant."""
    f, g = model(plant, len(x))(x)
    return np.array(f).ravel(), np.array(g)


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("sign", [1, -1])
def test_bounds_over_a_box_hold_at_random_states_in_it(name: str, sign: int) -> None:
    draw = random.Random(name)
    plant, n = PLANTS[name], DIMENSIONS[name]
    for _ in range(5):
        box = [tuple(sorted(draw.uniform(-2, 2) for _ in range(2))) for _ in range(n)]
        bounds = PlantEnclosure(plant, n, sign).over(box)
        for _ in range(100):
            f, g = values_at(plant, [draw.uniform(*side) for side in box])
            g = sign * g
            assert (np.abs(f) <= bounds.disturbance).all()
            assert np.linalg.norm(f) <= bounds.disturbance_norm
            assert (bounds.diagonal_min <= np.diag(g)).all()
            assert (np.abs(np.diag(g)) <= bounds.diagonal_max).all()
            assert (np.abs(g - np.diag(np.diag(g))) <= bounds.cross).all()
            assert bounds.eigenvalue_min <= np.linalg.eigvalsh((g + g.T) / 2)[0] + 1e-15  # NumPy rounds
            assert np.linalg.norm(g, 2) <= bounds.norm + 1e-15


def test_bounds_on_a_small_box_are_close_to_the_values() -> None:
    """On a box of half width 1e-6 they are within 1e-4 of the values in its middle."""
    for name, n in DIMENSIONS.items():
        middle = [0.3, 0.7, -0.4][:n]
        bounds = PlantEnclosure(PLANTS[name], n, 1).over([(v - 1e-6, v + 1e-6) for v in middle])
        f, g = values_at(PLANTS[name], middle)
        assert np.abs(bounds.disturbance - np.abs(f)).max() < 1e-4
        assert abs(bounds.eigenvalue_min - np.linalg.eigvalsh((g + g.T) / 2)[0]) < 1e-4
        assert abs(bounds.norm - np.linalg.norm(g, 2)) < 1e-4


def test_w_max_is_added_to_the_bounds_on_f() -> None:
    bounds = PlantEnclosure(PLANTS["integrator"], 2, 1).over([(0, 1), (0, 1)])
    enclosure = PlantEnclosure(
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
    windy_bounds = enclosure.over([(0, 1), (0, 1)])
    assert (windy_bounds.disturbance >= bounds.disturbance + 3).all()
    assert windy_bounds.disturbance_norm >= 3


def test_an_eigenvalue_bound_holds_for_every_matrix_in_the_balls() -> None:
    draw = np.random.default_rng(1)
    for n in (1, 2, 3, 5):
        middle, radius = draw.normal(size=(n, n)), draw.uniform(0, 0.1, size=(n, n))
        middle, radius = middle + middle.T, radius + radius.T
        balls = [[arb(float(m), float(r)) for m, r in zip(*rows, strict=True)] for rows in zip(middle, radius, strict=True)]
        bound = minimum_eigenvalue(balls)
        for _ in range(50):
            share = np.triu(draw.uniform(-1, 1, size=(n, n)))
            matrix = middle + radius * (share + np.triu(share, 1).T)
            assert bound <= np.linalg.eigvalsh(matrix)[0] + 1e-14


@pytest.mark.parametrize(
    ("bounds", "force", "g_min", "g_max"),
    [
        ({}, 0.0, 1.0, 1.0),
        ({"f_max": 1, "w_max": 2}, 3.0, 1.0, 1.0),
        ({"g_min": 2}, 0.0, 2.0, 2.0),
        ({"g_max": 3}, 0.0, 1.0, 3.0),
        ({"g_max": "0.5"}, 0.0, 0.5, 0.5),
    ],
)
def test_bounds_that_a_task_leaves_out_get_consistent_defaults(
    bounds: dict[str, Any], force: float, g_min: float, g_max: float
) -> None:
    exact = {k: Fraction(v) for k, v in bounds.items()}
    task = load_task(ROOT / "tasks" / "omni_s1.toml").model_copy(update={"plant": PlantBounds(**exact)})
    filled: Bounds = bounds_of_task(task)
    assert (filled.disturbance.tolist(), filled.diagonal_min.tolist(), filled.diagonal_max.tolist()) == (
        [force] * 2,
        [g_min] * 2,
        [g_max] * 2,
    )
    assert not filled.cross.any()


WRONG_FILES = {  # text of a plant file, and a part of the message that refuses it
    "def f(x): return [0, 0]": "no function g(x)",
    "def f(x): return [0, 0]\ndef g(x): return [[1, 0]]": "g(x) has shape (1, 2)",
    "def f(x): return [0]\ndef g(x): return [[1, 0], [0, 1]]": "f(x) has shape (1, 1)",
    "import no_such_module": "ModuleNotFoundError",
    "def f(x): return 1 / 0\ndef g(x): return [[1, 0], [0, 1]]": "ZeroDivisionError",
    "def f(x): return [0, 0]\ndef g(x): return [[1, 0], [0, 1]]\nw_max = -1": "w_max is -1",
    "def f(x): return [0, 0]\ndef g(x): return [[1, 0], [0, 1]]\nw_max = 'much'": "w_max is 'much'",
}


@pytest.mark.parametrize(("text", "message"), WRONG_FILES.items())
def test_a_wrong_plant_file_is_refused_with_the_reason(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(text)
    with pytest.raises(BadInput) as refusal:
        plant_of(str(path), 2)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_users_plant_is_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text("import casadi as ca\ndef f(x): return ca.sin(x)\ndef g(x): return ca.diag(2 + x)\nw_max = 0.25\n")
    plant = plant_of(str(path), 2)
    f, g = values_at(plant, [0.5, 1.0])
    assert np.allclose(f, np.sin([0.5, 1.0]), atol=0, rtol=1e-15)
    assert (g == np.diag([2.5, 3.0])).all()
    assert (plant.name, plant.w_max) == ("mine", 0.25)


def test_an_operation_that_cannot_be_enclosed_is_refused_by_name() -> None:
    with pytest.raises(BadInput, match=r"cannot be enclosed.*(ERF|erf)"):
        PlantEnclosure(Plant(name="odd", dimension=1, drift=lambda x: [ca.erf(x[0])], input_matrix=lambda x: [[1]]), 1, 1)


@pytest.mark.parametrize(("name", "n"), [("robot", 2), ("arm", 3), ("nonesuch", 2), ("missing.py", 2)])
def test_a_plant_that_does_not_fit_is_refused(name: str, n: int) -> None:
    with pytest.raises(BadInput) as refusal:
        plant_of(name, n)
    assert name in str(refusal.value)


def test_every_built_in_plant_has_the_dimension_of_an_example_task() -> None:
    dimensions = {load_task(p).dimension for p in sorted((ROOT / "tasks").glob("*.toml"))}
    for plant in PLANTS.values():
        assert plant.dimension is None or plant.dimension in dimensions
    assert set(DIMENSIONS) == set(PLANTS)


# ----------------------------------------------------------------------------------------------- [plant] of equations

ENTRY_SIZES = (0.0, 1e-18, 1e-10, 1e-9, 3e-7, 0.1234567, 1.0, 4321.5, 9.99e7)


def draw_plant(draw: random.Random, order: int) -> Plant:
    """Return a plant with entries of f, g and w of very different sizes, some linear in x; one in eight is beyond what a task accepts."""
    drift = [(draw.choice(ENTRY_SIZES), draw.choice(ENTRY_SIZES)) for _ in range(2)]
    drift[0] = (draw.choice((*[drift[0][0]] * 7, 1e12)), drift[0][1])
    sign = draw.choice((1, 1, -1))
    diagonal = [sign * draw.choice(ENTRY_SIZES[3:]) for _ in range(2)]
    diagonal[1] *= draw.choice((1, 1, 1, 1, 1, -1))
    off_diagonal = draw.choice((0.0, 0.1, 1e-14)) * min(map(abs, diagonal))
    w_max = Fraction(draw.choice((0.0, 1e-17, 0.1, 1 / 3)))

    def f(x: Any, *_: Any) -> Any:
        return [a + b * x[0] for a, b in drift]

    def g(x: Any, *_: Any) -> Any:
        return [[diagonal[0] * (1 + 0.1 * x[1]), off_diagonal], [off_diagonal * x[0], diagonal[1]]]

    return Plant(name="drawn", dimension=2, drift=f, input_matrix=g, w_max=w_max, order=order)


def with_table(text: str, lines: tuple[str, ...]) -> Any:
    """Return the task with its [plant] replaced by these lines."""
    rest = re.sub(r"(?ms)^\[plant\].*?(?=^\[|\Z)", "", text)
    return parse_task(rest + "\n" + "\n".join(lines) + "\n")


@pytest.mark.parametrize("order", [1, 2])
def test_a_proposed_plant_table_is_valid_and_covers_the_plant(order: int) -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    draw, proposal_count, reasons = random.Random(order), 0, set()
    box = [(0.1, 0.6), (-0.3, 0.4), (1.0, 1.0), (1.0, 1.0)][: 2 * order]
    for _ in range(60):
        sign = draw.choice((1, 1, -1))
        task = with_table(text.replace("gain = 0.5", f"gain = {0.5 * sign}"), ("[plant]", f"order = {order}"))
        plant = draw_plant(draw, order)
        bounds = [PlantEnclosure(plant, 2, sign, order).over(box)]
        proposal = propose_bounds(
            task, bounds, plant.w_max, lambda p=plant, s=sign: [PlantEnclosure(p, 2, -s, order).over(box)], [0.0]
        )
        if proposal.reason:
            reasons.add(re.search(r"would be|greater than 0; use|greater than 0$", proposal.reason)[0])
            assert not proposal.lines
            continue
        proposal_count += 1
        stated = with_table(text.replace("gain = 0.5", f"gain = {0.5 * sign}"), proposal.lines)
        assert uncovered_bounds(stated, bounds) == []
    assert proposal_count > 10
    assert reasons == {"would be", "greater than 0; use", "greater than 0"}


def test_a_bound_that_does_not_cover_the_plant_is_named_with_its_value() -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    bounds = [PlantEnclosure(PLANTS["arm"], 2, 1).over([(0.1, 0.6), (-0.3, 0.4)])]
    task = with_table(text, ("[plant]",))
    lines = propose_bounds(task, bounds, Fraction(0), lambda: bounds, [0.0]).lines
    for name, beginning in (("f_max", "|f + w| of"), ("g_max", "g_ii of"), ("g_cross", "|g_ij| of"), ("g_min", "g_ii of")):
        value = float(next(line for line in lines if line.startswith(name)).partition("= ")[2])
        too_weak = value * 1.4 if name == "g_min" else value / 1.4

        def uncovered_with(number: float, name: str = name) -> list[str]:
            stated = tuple(f"{name} = {number:.6g}" if v.startswith(name) else v for v in lines)
            return uncovered_bounds(with_table(text, stated), bounds)

        uncovered = uncovered_with(too_weak)
        assert uncovered
        assert all(line.startswith(beginning) and f"{too_weak:.6g} is stated, " in line for line in uncovered), uncovered
        advised = [float(re.search(rf"plant\.{name} = (\S+) covers it$", line)[1]) for line in uncovered]
        assert uncovered_with((min if name == "g_min" else max)(advised)) == []


@pytest.mark.parametrize("name", ["f_max", "g_max", "g_cross", "g_min"])
def test_the_value_that_is_advised_for_an_axis_covers_it_and_uncovers_no_other(name: str) -> None:
    """The table has lists. Every line is followed by itself."""
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    bounds = [PlantEnclosure(PLANTS["arm"], 2, 1).over([(0.1, 0.6), (-0.3, 0.4)])]
    worst = component_extremes(bounds)
    table = {"f_max": worst.disturbance, "g_max": worst.g_upper, "g_cross": worst.g_cross, "g_min": worst.g_lower}
    stated = {key: [f"{v * (0.5 if key == 'g_min' else 2):.6g}" for v in values] for key, values in table.items()}
    stated[name] = [f"{v * (1.1 if name == 'g_min' else 0.9):.6g}" for v in table[name]]

    def uncovered() -> list[str]:
        lines = ("[plant]", *(f"{key} = [{', '.join(values)}]" for key, values in stated.items()))
        return uncovered_bounds(with_table(text, lines), bounds)

    lines, too_weak = uncovered(), stated[name]
    assert len(lines) == 2
    for line in lines:
        advised = re.search(rf"plant\.{name} = (.*) covers it$", line)[1]
        stated[name] = advised[1:-1].split(", ") if advised.startswith("[") else [advised] * 2
        assert uncovered() == []
    stated[name] = [too_weak[0], "2" if name == "g_max" else "0.01" if name == "g_min" else "1"]  # then the second stays
    advised = re.search(rf"plant\.{name} = \[(.*), (.*)\] covers it$", uncovered()[0])
    assert float(advised[2]) == float(stated[name][1])


def test_where_w_is_larger_than_stated_its_bound_is_named() -> None:
    """f is within f_max in the first axis, and not in the second."""
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    plant = Plant(
        name="gusts", dimension=2, drift=lambda _: [0.02, 0.04], input_matrix=lambda _: [[1, 0], [0, 1]], w_max=Fraction("0.06")
    )
    bounds = [PlantEnclosure(plant, 2, 1).over([(0.1, 0.6), (-0.3, 0.4)])]

    def uncovered(*lines: str) -> list[str]:
        return uncovered_bounds(with_table(text, ("[plant]", *lines)), bounds, plant.w_max)

    (line,) = uncovered("f_max = [0.021, 0.041]", "w_max = [0.05, 0.07]")
    assert line.endswith("dimension 1 reaches 0.0800000001, 0.071 is stated, plant.w_max = [0.06, 0.07] covers it")
    lines = uncovered("f_max = 0.03", "w_max = 0.05")
    assert [line.partition("is stated, ")[2] for line in lines] == ["plant.w_max = 0.06 and plant.f_max = 0.04001 cover it"]


def test_bounds_with_an_unknown_payload_are_near_the_sampled_ones() -> None:
    """Of the arm with 0 to 0.3 kg in its hand: every sample of |f + w| and |g_ij| is within them; they are not far wider."""
    plant, box, drift = plant_of(str(ROOT / "tasks" / "arm.py"), 2, 2), [(-0.3, 0.3), (0.5, 1.1), (-1, 1), (-1, 1)], [0.02, 0.02]
    bounds, function, draw = PlantEnclosure(plant, 2, 1, 2).over(box, drift), model(plant, 2, 2), random.Random(4)

    def value(low: float, high: float) -> float:
        return draw.choice([low, high, draw.uniform(low, high)])

    disturbance, cross = np.zeros(2), np.zeros((2, 2))
    for _ in range(3000):
        state, drifts = [value(*side) for side in box], [value(-d, d) for d in drift]
        f, g = function([*state, value(0, 0.3), *(x + d for x, d in zip(state, drifts, strict=False))])
        disturbance = np.maximum(disturbance, np.abs(np.array(f).ravel()) + float(plant.w_max))
        cross = np.maximum(cross, np.abs(np.array(g)) * (1 - np.eye(2)))
    assert (disturbance <= bounds.disturbance).all()
    assert (cross <= bounds.cross).all()
    assert (bounds.disturbance <= 1.6 * disturbance).all(), (bounds.disturbance, disturbance)
    assert bounds.cross[1, 0] <= 1.3 * cross[1, 0], (bounds.cross, cross)


def test_where_no_bound_is_known_the_axis_and_the_time_are_said() -> None:
    """1/x over a box with 0 in it: the second window is the first with such a box."""
    plant = Plant(name="pole", dimension=2, drift=lambda x: [0, 1 / x[1]], input_matrix=lambda _: [[1, 0], [0, 1]])
    enclosure = PlantEnclosure(plant, 2, 1)
    bounds = [enclosure.over([(1, 2), (1, 2)]), enclosure.over([(1, 2), (-1, 2)])]
    proposal = propose_bounds(controller_of("omni_s2").task, bounds, Fraction(0), lambda: bounds, [0.0, 2.5])
    assert proposal.reason.startswith("no bound on f of dimension 2 is known over the tube at t = 2.5 s: a divisor may be 0")
    assert not proposal.lines


def prove(path: Path, *arguments: str) -> dict[str, Any]:
    """Run `stt-codegen prove` on a task file, and return its report."""
    result = CliRunner().invoke(app, ["prove", str(path), "--out", str(path.parent), "--json", *arguments])
    return dict(json.loads(result.stdout))


@pytest.mark.parametrize(("name", "plant"), [("omni_heading", "robot"), ("arm", "arm.py")])
def test_the_hypothesis_about_a_plant_holds_with_the_proposed_table(name: str, plant: str) -> None:
    """The table replaces the task's own, with a period, without which there is no such hypothesis."""
    text = (ROOT / "tasks" / f"{name}.toml").read_text()
    controller = controller_of(name)
    user_plant = plant_of(
        str(ROOT / "tasks" / plant) if plant.endswith(".py") else plant, 2 + (name == "omni_heading"), controller.task.order
    )
    proposed = Analysis(controller, user_plant).proposed
    assert proposed is not None
    task = with_table(text, proposed.lines).changed(control={"period": Fraction(1, 1000)})
    analysis = Analysis(build_task(task, uncertified=True, tube=controller.design), user_plant)
    hypothesis = next(h for h in analysis.hypotheses() if h.name == "[plant]")
    assert hypothesis.holds, hypothesis.statement
    positive = next(h for h in analysis.hypotheses() if h.name == "Assumption 2")
    assert positive.statement.endswith("locally Lipschitz is not looked at")


def test_for_a_plant_of_the_other_sign_the_advice_is_a_negative_gain(tmp_path: Path) -> None:
    """For g = -1 and a positive gain no table is proposed; with a negative gain there is one."""
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
