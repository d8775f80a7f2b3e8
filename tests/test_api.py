"""The Python interface, `import stt_codegen as stt`, as a notebook uses it."""

from __future__ import annotations

import doctest
import json
import os
import pickle
import subprocess
import sys
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stt_codegen as stt
from stt_codegen import api
from stt_codegen.checker import check_files
from stt_codegen.design.user_tubes import fitted_tube, spline_tube
from stt_codegen.pipeline import require_supported
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.task.load import parse_task
from tests.support.controllers import ADAPTABLE, ROOT, TASK_FILES

CART = {
    "name": "cart",
    "prescribed_time": 6.0,
    "initial_state": [0.5, 0.5],
    "state_space": {"lower": [0, 0], "upper": [4, 3]},
    "initial_set": {"lower": [0, 0], "upper": [1, 1]},
    "target_set": {"lower": [3, 2], "upper": [4, 3]},
    "unsafe": [{"name": "pillar", "lower": [1.6, 0.8], "upper": [2.2, 1.8]}],
    "tube": {"clearance": 0.05},
    "control": {"period": 0.005},
}
README = (ROOT / "README.md").read_text().partition("```toml\n")[2].partition("```")[0]


def run(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


# ------------------------------------------------------------------------------------------------------------- importing


def test_importing_loads_nothing_heavy_and_changes_no_backend() -> None:
    heavy = "casadi control sympy highspy matplotlib pydantic flint numpy".split()
    loaded = json.loads(run("import sys, json, stt_codegen; print(json.dumps([m for m in sys.modules]))"))
    assert not set(heavy) & set(loaded)
    code = "import matplotlib; matplotlib.use('svg'); import stt_codegen.report.pictures.tube_pictures, stt_codegen.loop.picture; print(matplotlib.get_backend())"
    assert run(code).strip() == "svg"


def test_the_interface_loads_no_solver() -> None:
    """Solvers are loaded when a tube is designed, so that scripts and notebooks start fast."""
    loaded = json.loads(run("import sys, json, stt_codegen.api; print(json.dumps([m for m in sys.modules]))"))
    assert not set("casadi control sympy highspy matplotlib flint scipy".split()) & set(loaded)


def test_package_module_and_stub_have_the_same_names() -> None:
    """The package, the module `api` and the stub for type checkers list the same names."""
    stub = (ROOT / "stt_codegen" / "__init__.pyi").read_text()
    stub_names = [line.split(" as ")[1] for line in stub.splitlines() if " as " in line]
    assert sorted(stt.__all__) == sorted(api.__all__) == sorted(stub_names)

    for name in stt.__all__:
        assert getattr(stt, name) is getattr(api, name)
        assert getattr(api, name).__doc__
    with pytest.raises(AttributeError, match="nothing"):
        _ = stt.nothing
    assert (ROOT / "stt_codegen" / "py.typed").exists()


def test_every_function_has_a_correct_example(monkeypatch, tool) -> None:
    tool("gcc")
    monkeypatch.chdir(ROOT)
    doctests = doctest.DocTestFinder().find(api, globs=vars(api).copy())
    examples = {test.name.removeprefix("stt_codegen.api."): test for test in doctests if test.examples}
    functions = [name for name in api.__all__ if not isinstance(getattr(api, name), type)]
    methods = [f"Controller.{name}" for name in ("tube", "control", "margin", "casadi", "write", "plot", "simulate")]
    assert {*functions, *methods, "Controller"} <= set(examples)
    runner = doctest.DocTestRunner()
    for test in examples.values():
        assert runner.run(test).failed == 0, test.name


def test_functions_of_a_task_accept_the_path_of_its_file() -> None:
    path = ROOT / "tasks" / "omni_s2.toml"
    tube = stt.design(str(path))
    assert stt.certify(path, tube) == stt.certify(stt.load(path), tube)
    for wrong in (3, None, {"name": "cart"}):
        with pytest.raises(stt.BadInput, match="a Task or the path"):
            stt.design(wrong)  # type: ignore[arg-type]


def test_a_controller_goes_through_pickle(controller) -> None:
    controller.tube(1.0)  # values that it caches by this must not prevent pickling
    copy = pickle.loads(pickle.dumps(controller))
    assert copy.files == controller.files
    assert copy.control(1.0, [0.5, 0.5])[1].tolist() == controller.control(1.0, [0.5, 0.5])[1].tolist()


@pytest.mark.parametrize(
    "start", [[1, 1], np.array([1, 1]), np.array([1.0, 1.0], np.float32), (np.float32(1),) * 2, (Fraction(1), "1")], ids=repr
)
def test_a_start_of_any_numbers_is_that_start(controller, start, tool) -> None:
    """C reads doubles by their address, so that integers and other floats must be converted before."""
    tool("gcc")
    assert controller.simulate(start=start).trace[0, 1:3].tolist() == [1.0, 1.0]


@pytest.mark.parametrize(
    ("start", "message"), [([0.5], "1 numbers, 2"), ("ab", "2 numbers"), ([0.5, None], "2 numbers"), (3, "2 numbers")]
)
def test_a_malformed_start_is_refused(controller, start, message, tool) -> None:
    tool("gcc")
    with pytest.raises(stt.BadInput, match=message):
        controller.simulate(start=start)


def test_a_function_that_is_no_plant_is_refused(controller) -> None:
    with pytest.raises(stt.BadInput, match="plant: is a function"):
        controller.simulate(lambda x: x)


# ---------------------------------------------------------------------------------------------------------- tasks in code


def test_changed_replaces_only_the_stated_fields_of_a_table() -> None:
    """Otherwise a task with another design would lose its clearance."""
    task = stt.Task(**{**CART, "tube": {"clearance": 0.05, "min_width": 0.2}})
    adaptive_task = task.changed(tube={"design": "adaptive"}, name="van")
    assert (
        adaptive_task.name,
        adaptive_task.tube.design,
        adaptive_task.tube.clearance,
        adaptive_task.tube.min_width,
    ) == (
        "van",
        "adaptive",
        Fraction(1, 20),
        Fraction(1, 5),
    )
    assert task.changed(tube={"clearance": None}).tube.clearance == stt.Task(**{**CART, "tube": {}}).tube.clearance
    assert task.changed(unsafe=None).unsafe == ()


@pytest.mark.parametrize("path", TASK_FILES, ids=lambda p: p.stem)
def test_a_task_in_python_equals_the_task_of_its_file(path) -> None:
    loaded = stt.load(path)
    task = stt.Task(**{name: getattr(loaded, name) for name in loaded.model_fields_set})
    assert task == loaded
    assert task.digest == loaded.digest


def test_numbers_of_every_kind_are_the_same_number() -> None:
    cart = {**CART, "plant": {"w_max": 0.1, "g_min": 0.95, "g_max": 1.05, "noise": 0.002, "lag": 0.02}}
    plain = stt.Task(**cart)
    assert plain.digest == stt.parse(README).digest
    for convert in (
        np.array,
        tuple,
        lambda v: [str(x) for x in v],
        lambda v: [Fraction(str(x)) for x in v],
        lambda v: np.array(v, np.float32),
    ):
        boxes = {k: {e: convert(v) for e, v in CART[k].items()} for k in ("state_space", "initial_set", "target_set")}
        unsafe = [{"name": "pillar", "lower": convert([1.6, 0.8]), "upper": convert([2.2, 1.8])}]
        assert stt.Task(**{**cart, **boxes, "unsafe": unsafe}) == plain


@given(st.floats(allow_nan=True, allow_infinity=True))
def test_a_float_means_its_shortest_decimal(value: float) -> None:
    try:
        task = stt.Task(**{**CART, "prescribed_time": value})
    except stt.BadInput as error:
        assert "prescribed_time" in str(error)
        assert not 1e-9 <= value <= 1e9
        return
    assert task.prescribed_time == Fraction(repr(value))


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"body": [-1, -1]}, "body[0]"),
        ({"target_set": {"lower": [3, 2], "upper": [4.5, 3]}}, "target_set"),
        ({"control": {"gain": 0}}, "control.gain"),
        ({"control": {"gain": 0.5, "u_max": [-1, 1]}}, "control.u_max[0]"),
        ({"name": "int"}, "name"),
        ({"initial_state": [0.5]}, "initial_state"),
        ({"initial_state": np.zeros((2, 2))}, "initial_state"),
        ({"initial_state": np.zeros(0)}, "initial_state"),
        ({"prescribed_time": np.array([1.0, 2.0])}, "prescribed_time"),
        ({"prescribed_time": True}, "boolean"),
        ({"prescribed_time": np.bool_(True)}, "boolean"),
        ({"prescribed_time": Fraction(1, 3)}, "no decimal"),
        ({"prescribed_time": "soon"}, "prescribed_time"),
        ({"colour": "red"}, "colour"),
        ({"unsafe": [{"lower": [0, 0], "upper": [1, 1]}]}, "initial_set"),
    ],
    ids=str,
)
def test_task_and_changed_refuse_malformed_fields_by_name(change: dict, field: str) -> None:
    with pytest.raises(stt.BadInput, match=field.replace("[", r"\[")):
        stt.Task(**{**CART, **change})
    with pytest.raises(stt.BadInput, match=field.replace("[", r"\[")):
        stt.Task(**CART).changed(**change)


def test_a_file_with_a_number_as_text_is_refused() -> None:
    with pytest.raises(stt.BadInput, match="prescribed_time"):
        parse_task(README.replace("prescribed_time = 6.0", 'prescribed_time = "6.0"'))


# ---------------------------------------------------------------------------------------------------------- controllers


@pytest.fixture(scope="module")
def controller():
    return stt.build(stt.Task(**CART))


def points(c, count: int = 60):
    rng = np.random.default_rng(5)
    t = np.sort(rng.uniform(-0.2, 1.2, count)) * float(c.task.prescribed_time)
    lower, upper = c.tube(t)
    return t, lower + (upper - lower) * rng.uniform(-0.2, 1.2, lower.shape)


def test_the_repr_of_a_controller_is_one_line_with_its_main_facts(controller) -> None:
    text = repr(controller)
    assert len(text) < 120
    for part in ("cart", "refined", "certified", "float"):
        assert part in text
    assert controller._repr_png_().startswith(b"\x89PNG")


def test_vectorised_calls_equal_single_calls(controller) -> None:
    t, x = points(controller)
    lower, upper = controller.tube(t)
    status, u = controller.control(t, x)
    margin = controller.margin(t, x)
    assert lower.shape == u.shape == x.shape
    for k in range(0, len(t), 7):
        assert np.array_equal(controller.tube(t[k])[0], lower[k])
        assert np.array_equal(controller.tube(float(t[k]))[1], upper[k])
        single_status, single_u = controller.control(t[k], x[k])
        assert (single_status, single_u.tolist(), controller.margin(t[k], x[k])) == (status[k], u[k].tolist(), margin[k])
    assert np.array_equal(controller.control(1.0, x)[1][3], controller.control(1.0, x[3])[1])


@pytest.mark.parametrize("shape", [(1,), (3,), (1, 3), (3, 2), (2, 2, 2), ()])
def test_wrong_shapes_are_refused(controller, shape) -> None:
    with pytest.raises(stt.BadInput, match="shape"):
        controller.control(np.array([1.0, 2.0]), np.zeros(shape))


@pytest.mark.parametrize("shape", [(4, 1), (4, 3), (3, 2), (4,)])
def test_the_compiled_backend_refuses_them_before_a_pointer_is_passed(controller, shape, tool) -> None:
    tool("gcc")
    with pytest.raises(ValueError, match="shape"):
        CompiledC(controller).control(np.zeros(4), np.zeros(shape))


@pytest.mark.parametrize("design", ["refined", "adaptive"])
@pytest.mark.parametrize("name", ["omni_s2", "spacecraft"])
def test_functions_for_casadi_equal_the_emitted_ones(name: str, design: str) -> None:
    """Values to 1e-12 relative, for SX and MX; derivatives against differences of the emitted function."""
    assert name in ADAPTABLE
    c = stt.build(stt.load(ROOT / "tasks" / f"{name}.toml").with_options(design))
    functions = c.casadi()
    t, x = points(c, 25)
    alpha = [[a] for a in c.alpha(t)] if c.design.is_stateful else [[]] * len(t)
    _, u = c.control(t, x)
    lower, upper = c.tube(t)
    rates = c.tube_rate(t)
    for k in range(len(t)):
        got = np.array(functions["control"](t[k], *alpha[k], x[k])[1]).ravel()
        assert np.all(np.abs(got - u[k]) <= 1e-12 * np.maximum(np.abs(u[k]), 1))
        edges = np.array(functions["tube"](t[k], *alpha[k])).reshape(2, -1)
        assert np.allclose(edges, [lower[k], upper[k]], rtol=1e-12, atol=1e-13)
        slopes = np.array(functions["tube_rate"](t[k], *alpha[k])).reshape(2, -1)
        assert np.allclose(slopes, [rates[0][k], rates[1][k]], rtol=1e-10, atol=1e-12)
        inside = np.all((lower[k] + 0.1 * (upper[k] - lower[k]) < x[k]) & (x[k] < upper[k] - 0.1 * (upper[k] - lower[k])))
        if inside and not c.design.is_stateful:
            step = 1e-6 * (upper[k] - lower[k])
            for i in range(len(step)):
                ahead, behind = (c.control(t[k], x[k] + s * step * np.eye(len(step))[i])[1] for s in (1, -1))
                jacobian = np.array(functions["du_dx"](t[k], x[k]))[:, i]
                assert np.allclose(jacobian, (ahead - behind) / (2 * step[i]), rtol=1e-4, atol=1e-4 * np.abs(jacobian).max())
    symbol = ca.MX.sym("t")
    assert functions["tube"](symbol, *([ca.MX.zeros(2 * c.task.dimension)] if c.design.is_stateful else []))[0].shape == (
        c.task.dimension,
        1,
    )


def test_functions_for_casadi_have_the_inline_logarithm(tmp_path) -> None:
    c = stt.build(stt.load(ROOT / "tasks" / "omni_board.toml"))
    assert c.task.emit.math == "inline"
    law = c.casadi()["control"]
    t, x = points(c, 25)
    status, u = c.control(t, x)
    for k in range(len(t)):
        casadi_status, casadi_u = law(t[k], x[k])
        assert int(casadi_status) == status[k]
        assert np.allclose(np.array(casadi_u).ravel(), u[k], rtol=1e-12, atol=1e-12)


def test_write_plot_simulate(controller, tmp_path, tool) -> None:
    tool("gcc")
    written = controller.write(tmp_path / "src")
    assert sorted(p.name for p in written) == sorted(controller.files)
    assert (tmp_path / "src" / "cart.c").read_bytes() == controller.files["cart.c"]
    figure = controller.plot()
    axis = figure.add_subplot()
    assert controller.plot(ax=axis) is axis
    run_ = controller.simulate("integrator", rate=500.0, disturbance="nearest", strength=0.1)
    assert run_.good
    assert run_.trace.shape[1] == 5 * 2 + 2
    with pytest.raises(stt.BadInput, match="speed"):
        controller.simulate(speed=3)


def test_refusals_are_exceptions_of_the_package(tmp_path) -> None:
    wall = [{"name": "wall", "lower": [1.5, 0], "upper": [2.5, 3]}]
    with pytest.raises(stt.NotCertified, match="P4"):
        stt.build(stt.Task(**{**CART, "unsafe": wall}))
    with pytest.raises(stt.BadInput, match="cannot be read"):
        stt.build(tmp_path / "none.toml")
    with pytest.raises(stt.BadInput, match="alpha"):
        stt.build(stt.Task(**CART)).alpha(0.0)
    with pytest.raises(stt.BadInput, match=r"emit\.math"):
        require_supported(stt.Task(**{**CART, "emit": {"math": "inline"}, "tube": {"design": "adaptive"}}))


def test_prove_outside_a_repository_says_where_the_book_goes(tmp_path) -> None:
    """It writes no generated/ folder into whatever folder one stands in."""
    command = [sys.executable, "-m", "stt_codegen.cli", "prove"]
    result = subprocess.run(command, cwd=tmp_path, env={**os.environ}, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert "--out" in result.stderr
    assert not any(tmp_path.iterdir())


# ------------------------------------------------------------------------------------------------------ a user's tube


def control_points(controller) -> np.ndarray:
    design = controller.design
    return 6 * design.integers() * float(design.unit)


@pytest.mark.parametrize("path", TASK_FILES, ids=lambda p: p.stem)
def test_a_designed_tube_passed_as_points_is_emitted_to_the_same_bytes(path) -> None:
    designed = stt.build(path)
    assert stt.certify_tube(designed.task, points=control_points(designed)).files == designed.files


@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_rounding_goes_inwards_and_by_less_than_a_step(seed: int, segments: int) -> None:
    task, rng = stt.Task(**CART), np.random.default_rng(seed)
    points = rng.uniform(0, 3, (segments + 3, 2, 2))
    points[-1] = points[-3]
    tube = spline_tube(task, points)
    inwards = (tube.integers() * float(tube.unit) - points / 6) * [1, -1]
    assert (inwards > -1e-15).all()  # points / 6 is at most 1/2, rounded to 2^-54
    assert (inwards < float(tube.unit)).all()


def straight(share, lower=(0.1, 0.1), upper=(0.9, 0.9), displacement=(3.0, 2.0)):
    """Return edges of a box that moves by `displacement`, at rest at both ends."""
    moved = (share**2 * (3 - 2 * share))[:, None] * displacement
    return moved + lower, moved + upper


def test_samples_of_a_cubic_are_fitted_certified_and_checked(tmp_path) -> None:
    empty = README.partition("[[unsafe]]")[0] + "[tube]\nclearance = 0.05\nmin_width = 0.1\nsegments = 16\n"
    (tmp_path / "task.toml").write_text(empty)
    task, t = stt.parse(empty), np.linspace(0, 6, 60)
    samples = (t, *straight(t / 6))
    fitted = stt.certify_tube(task, samples=samples)
    assert fitted.certificate.holds
    assert (
        fitted.distance(*samples) < 2.0 ** (2 - 20)
    ).all()  # a spline represents a cubic; its control points are rounded inward by up to 6 units of 2^-21
    fitted.write(tmp_path)
    assert check_files([str(tmp_path / name) for name in ("task.toml", "cart.c", "cart.certificate.json")]) == 0


def test_a_tube_through_an_obstacle_is_refused_by_the_obstacles_name() -> None:
    task, t = stt.Task(**CART), np.linspace(0, 6, 60)
    with pytest.raises(stt.NotCertified, match=r"avoid \(P4\).*pillar"):
        stt.certify_tube(task, samples=(t, *straight(t / 6)))
    uncertified = stt.certify_tube(task, samples=(t, *straight(t / 6)), uncertified=True)
    assert not uncertified.certificate.holds
    assert b"NOT CERTIFIED" in uncertified.files["cart.c"]


T = np.linspace(0, 6, 60)
LOW, HIGH = straight(T / 6)


@pytest.mark.parametrize(
    ("tube_arguments", "message"),
    [
        ({}, "give points or samples"),
        ({"points": np.zeros((9, 2, 2)), "samples": (T, LOW, HIGH)}, "give points or samples"),
        ({"points": np.zeros((9, 3, 2))}, "shape"),
        ({"points": np.zeros((3, 2, 2))}, "shape"),
        ({"points": [[1, 2], [3]]}, "numbers"),
        ({"points": np.arange(36.0).reshape(9, 2, 2)}, "rest"),
        ({"points": np.full((9, 2, 2), np.nan)}, "NaN"),
        ({"points": np.full((9, 2, 2), 1e9)}, "further out"),
        ({"samples": (T, LOW[:, :1], HIGH)}, "shape"),
        ({"samples": (T[::-1], LOW, HIGH)}, "rise"),
        ({"samples": (T / 2, LOW, HIGH)}, "rise"),
        ({"samples": (np.concatenate([T[:59] / 1e3, T[59:]]), LOW, HIGH)}, "not determined"),
    ],
)
def test_malformed_points_or_samples_are_refused(tube_arguments, message) -> None:
    with pytest.raises(stt.BadInput, match=message):
        stt.certify_tube(stt.Task(**CART), **tube_arguments)
    with pytest.raises(stt.BadInput, match=r"tube\.design"):
        stt.certify_tube(stt.Task(**{**CART, "tube": {"design": "adaptive"}}), points=np.zeros((9, 2, 2)))


# ------------------------------------------------------------------------------------------------ kinds of arrays

GOOD_POINTS = np.array([[[0.2, 0.8]] * 2] * 2 + [[[1.0, 2.0]] * 2] * 4 + [[[3.2, 3.8], [2.2, 2.8]]] * 3)
STATES = np.array([[0.5, 0.5], [0.6, 0.4], [0.7, 0.6]])


class ForeignArray:
    """An array of another library, such as pandas, which has only `__array__`."""

    def __init__(self, values: np.ndarray) -> None:
        self.values = values

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return np.asarray(self.values, dtype=dtype)


def with_entry(values: np.ndarray, entry: object) -> list:
    """Return the array as nested lists, with its first number replaced by an entry."""
    rows = np.asarray(values).tolist()
    inner = rows
    while isinstance(inner[0], list):
        inner = inner[0]
    inner[0] = entry
    return rows


NO_ARRAYS = {
    "complex": lambda v: v + 0.5j,
    "complex without an imaginary part": lambda v: v.astype(complex),
    "complex in a list": lambda v: with_entry(v, 1 + 2j),
    "masked": lambda v: np.ma.array(v, mask=np.arange(v.size).reshape(v.shape) == 0),
    "masked in a list": lambda v: with_entry(v, np.ma.masked),
    "masked by value": lambda v: np.ma.masked_equal(v, v.ravel()[0]),
    "objects": lambda v: v.astype(object),
    "texts": lambda v: v.astype(str),
    "bytes": lambda v: v.astype("S8"),
    "booleans": lambda v: v.astype(bool),
    "a boolean in a list": lambda v: with_entry(v, True),
    "NumPy's boolean in a list": lambda v: with_entry(v, np.True_),
    "dates": lambda v: v.astype(int).astype("M8[s]"),
    "None": lambda v: with_entry(v, None),
    "a word": lambda v: "many",
    "a word in a list": lambda v: with_entry(v, "many"),
    "a table": lambda v: {"x": 1},
    "one axis more": lambda v: v[None, None],
    "no entries": lambda v: v[:0],
    "rows of different lengths": lambda v: [*v.tolist(), [1.0, 2.0, 3.0]],
    "a foreign one of complex numbers": lambda v: ForeignArray(v + 0.5j),
    "a foreign one of booleans": lambda v: ForeignArray(v.astype(bool)),
    "a foreign one of objects": lambda v: ForeignArray(v.astype(object)),
}
NOT_FINITE = {
    "NaN": lambda v: with_entry(v, float("nan")),
    "an infinity": lambda v: with_entry(v, float("inf")),
    "a NaN in an array": lambda v: np.array(with_entry(v, np.nan)),
}
LIKE_ARRAYS = {
    "lists": lambda v: v.tolist(),
    "tuples": lambda v: tuple(map(tuple, v)) if v.ndim > 1 else tuple(v),
    "array": np.array,
    "floats of 32 bits": lambda v: v.astype(np.float32),
    "extended": lambda v: v.astype(np.longdouble),
    "masked nowhere": np.ma.array,
    "foreign": ForeignArray,
    "list of arrays": list,
    "not contiguous": lambda v: np.repeat(v, 2, axis=0)[::2],
    "reversed in memory": np.asfortranarray,
}


def task_with(*path: str, table: dict | None = None):
    """Return a function that takes an array as a field of a task."""

    def take(controller, value):
        data = {**CART, "tube": {**CART["tube"]}, "control": {}}
        inner = data
        for name in path[:-1]:
            inner[name] = dict(inner.get(name) or table or {})
            inner = inner[name]
        inner[path[-1]] = value
        return stt.Task(**data)

    return take


def task_with_set(**fields):
    """Return a function that takes an array as a field of an unsafe set."""

    def take(controller, value):
        return stt.Task(**{**CART, "unsafe": [{k: value if v is None else v for k, v in fields.items()}]})

    return take


def plant_with(f=None, g=None):
    """Return a function that takes an array as the value of a plant's function."""
    from stt_codegen.plants import Plant, model

    def take(controller, value):
        plant = Plant(name="user_plant", dimension=2, drift=f or (lambda x: value), input_matrix=g or (lambda x: value))
        return model(plant, 2)(STATES[0])

    return take


TIMES = np.array([0.0, 2.0, 6.0])
EDGES = STATES - 0.2
EYE = np.array([[1.0, 0.5], [0.25, 1.0]])
# By name: a function that takes an array, and an array that it accepts.
ENTRIES = {
    "initial_state": (task_with("initial_state"), STATES[0]),
    "state_space.upper": (task_with("state_space", "upper"), np.array([4.0, 3.0])),
    "initial_set.lower": (task_with("initial_set", "lower"), np.array([0.1, 0.2])),
    "target_set.lower": (task_with("target_set", "lower"), np.array([3.25, 2.25])),
    "body": (task_with("body"), np.array([0.0, 0.0])),
    "control.gain": (task_with("control", "gain"), np.array([0.5, 0.25])),
    "control.u_max": (task_with("control", "u_max"), np.array([5.0, 6.0])),
    "control.e_max": (task_with("control", "e_max"), np.array([0.5, 0.75])),
    "plant.f_max": (task_with("plant", "f_max"), np.array([0.5, 0.25])),
    "plant.g_min": (task_with("plant", "g_min"), np.array([0.5, 0.25])),
    "tube.max_speed": (task_with("tube", "max_speed"), np.array([5.0, 6.0])),
    "vertices": (task_with_set(name="hill", vertices=None), np.array([[1.5, 1.0], [2.0, 1.0], [1.75, 1.5]])),
    "normals": (
        task_with_set(name="hill", normals=None, offsets=[2, -1.5, 1.5, -1]),
        np.array([[1.0, 0], [-1, 0], [0, 1], [0, -1]]),
    ),
    "offsets": (
        task_with_set(name="hill", normals=[[1, 0], [-1, 0], [0, 1], [0, -1]], offsets=None),
        np.array([2.0, -1.5, 1.5, -1.0]),
    ),
    "centre": (task_with_set(name="hill", centre=None, radius=0.25), np.array([1.75, 1.25])),
    "during": (task_with_set(name="hill", lower=[1.5, 1], upper=[2, 1.5], during=None), np.array([1.0, 2.0])),
    "points": (lambda c, v: spline_tube(c.task, v), GOOD_POINTS),
    "samples, t": (lambda c, v: fitted_tube(c.task, v, LOW, HIGH), T),
    "samples, lower": (lambda c, v: fitted_tube(c.task, T, v, HIGH), LOW),
    "samples, upper": (lambda c, v: fitted_tube(c.task, T, LOW, v), HIGH),
    "tube": (lambda c, v: c.tube(v), TIMES),
    "tube_rate": (lambda c, v: c.tube_rate(v), TIMES),
    "control, t": (lambda c, v: c.control(v, STATES), TIMES),
    "control, x": (lambda c, v: c.control(TIMES, v), STATES),
    "margin, t": (lambda c, v: c.margin(v, STATES), TIMES),
    "margin, x": (lambda c, v: c.margin(TIMES, v), STATES),
    "distance, t": (lambda c, v: c.distance(v, EDGES, STATES), TIMES),
    "distance, lower": (lambda c, v: c.distance(TIMES, v, STATES), EDGES),
    "distance, upper": (lambda c, v: c.distance(TIMES, EDGES, v), STATES),
    "a plant's f": (plant_with(g=lambda x: [[1, 0], [0, 1]]), np.array([0.5, 0.25])),
    "a plant's g": (plant_with(f=lambda x: [0, 0]), EYE),
}
CERTIFIED = {  # the public function for four of them
    "points": lambda c, v: stt.certify_tube(c.task, points=v, uncertified=True),
    "samples, t": lambda c, v: stt.certify_tube(c.task, samples=(v, LOW, HIGH), uncertified=True),
    "samples, lower": lambda c, v: stt.certify_tube(c.task, samples=(T, v, HIGH), uncertified=True),
    "samples, upper": lambda c, v: stt.certify_tube(c.task, samples=[T, LOW, v], uncertified=True),
}
EMITTED = {"tube", "tube_rate", "control, t", "control, x", "margin, t", "margin, x"}  # NaN goes to the emitted functions


@pytest.mark.parametrize("name", ENTRIES)
def test_every_entry_refuses_values_that_are_no_arrays_of_real_numbers(controller, name: str) -> None:
    take, good = ENTRIES[name]
    wrong = {**NO_ARRAYS, **({} if name in EMITTED else NOT_FINITE)}
    for kind, spoil in wrong.items():
        if kind in ("objects", "a foreign one of objects") and name in ("a plant's f", "a plant's g"):
            continue  # such arrays hold expressions
        try:
            CERTIFIED.get(name, take)(controller, spoil(good))
        except stt.BadInput as refusal:
            assert "\n" not in str(refusal), (kind, refusal)
            assert ";" in str(refusal) or "(" in str(refusal), (kind, refusal)  # the remedy
        else:
            pytest.fail(f"{name}: took {kind}: {spoil(good)!r}")


@pytest.mark.parametrize("name", ENTRIES)
def test_every_entry_takes_array_likes_as_the_same_array(controller, name: str) -> None:
    """Numbers have few bits, so that floats of 32 bits represent them."""
    take, good = ENTRIES[name]
    good = np.round(good * 64) / 64 if good is not T else good

    expected = repr(take(controller, good))
    for kind, like in LIKE_ARRAYS.items():
        if kind == "floats of 32 bits" and good is T:
            continue  # its last time would not be t_c
        assert repr(take(controller, like(good))) == expected, kind
    if name not in ("samples, t", "samples, lower", "samples, upper") and (good == good.astype(int)).all():
        assert repr(take(controller, good.astype(int))) == expected


@pytest.mark.parametrize(
    ("samples", "message"),
    [
        ((T, LOW), "three arrays"),
        ((T, LOW, HIGH, HIGH), "three arrays"),
        ((), "three arrays"),
        ({"t": T}, "a tuple of three"),
        ("samples", "a tuple of three"),
        (5, "a tuple of three"),
        (np.zeros((3, 4)), "a tuple of three"),
        ((np.where(T[5] == T, T[4], T), LOW, HIGH), "rise"),
        ((T[:, None], LOW, HIGH), "shape"),
        ((T, LOW.ravel(), HIGH), "shape"),
        ((T, LOW, None), "upper: is missing"),
        ((3.0, LOW, HIGH), "shape"),
    ],
)
def test_samples_are_three_arrays_over_rising_times(samples, message) -> None:
    with pytest.raises(stt.BadInput, match=message):
        stt.certify_tube(stt.Task(**CART), samples=samples)


@pytest.mark.parametrize("spoil", NO_ARRAYS.values(), ids=NO_ARRAYS)
def test_a_start_that_is_no_array_of_real_numbers_is_refused(controller, spoil, tool) -> None:
    tool("gcc")
    with pytest.raises(stt.BadInput, match="--start"):
        controller.simulate(start=spoil(STATES[0]))


@pytest.mark.parametrize("name", ["rate", "strength", "noise", "latency", "lag", "noise_v", "lost", "seed"])
@pytest.mark.parametrize("value", [1j, "2", None, True, [1.0], np.ma.masked, float("nan"), -1.0])
def test_a_malformed_number_of_a_scenario_is_refused(controller, name: str, value) -> None:
    with pytest.raises(stt.BadInput):
        controller.simulate(**{name: value})


def test_a_period_for_an_adaptive_tube_is_refused_by_build_and_certify() -> None:
    """A period is proved for refined tubes only, so that no certificate without P9 may hold for an adaptive tube."""
    task = stt.load(ROOT / "tasks" / "omni_s1.toml").changed(tube={"design": "adaptive"})
    tube = stt.design(task)
    for refuse in (stt.build, lambda sampled: stt.certify(sampled, tube)):
        with pytest.raises(stt.BadInput, match=r"control\.period: is proved for refined tubes only"):
            refuse(task.changed(control={"period": Fraction(1, 2)}))


def test_a_tube_of_another_kind_size_order_or_time_is_refused() -> None:
    """The task decides what a certificate must prove, so that a tube of another task could be certified for less."""
    tube = stt.design(ROOT / "tasks" / "omni_s1.toml")
    task = stt.load(ROOT / "tasks" / "omni_s1.toml")
    for changed, problem in (
        (task.changed(tube={"design": "adaptive"}), r'kind "refined"; .*tube\.design = "adaptive"'),
        (task.changed(prescribed_time=Fraction(10)), r"ends at .*prescribed_time = 10"),
        (stt.load(ROOT / "tasks" / "drone.toml"), "has dimension 2; the task has 3"),
        (stt.load(ROOT / "tasks" / "crane.toml"), "order 1; the task's is of order 2"),
    ):
        with pytest.raises(stt.BadInput, match=problem):
            stt.certify(changed, tube)
