"""Units of FMI 2 and 3: valid by FMPy, bit for bit the emitted C, in a closed loop of two units, and in the hands of odd importers."""

from __future__ import annotations

import ctypes
import math
import re
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from functools import cache
from io import BytesIO
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.build import build_platform_binary
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from typer.testing import CliRunner

from stt_codegen.certify.missions.proof import cycle_of
from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import PLANTS, plant_of
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.record.fmu import NOT_OFFERED_2, NOT_OFFERED_3, controller_unit, fmu_units
from stt_codegen.task.load import load_task
from tests.support.controllers import ROOT, build_once

# Tasks by name, and changes of omni_s2: axes with names, order 2, a mission that repeats, both guards.
SHAPES: dict[str, dict[str, Any]] = {
    "omni_s2": {},
    "attitude": {},
    "watchman": {},
    "hold": {"control": {"outside": "hold"}},
    "stop": {"control": {"outside": "stop"}},
}
VERSIONS = {"fmu": 3, "fmi2.fmu": 2}


@cache
def controller_of_shape(shape: str) -> EmittedController:
    task_name = shape if (ROOT / "tasks" / f"{shape}.toml").exists() else "omni_s2"
    return build_once(load_task(ROOT / "tasks" / f"{task_name}.toml").changed(**SHAPES[shape]))


PLANT = """
import casadi as ca

def f(x, p):
    return [p[0] * x[0], 0]

def g(x, p):
    return [[1, 0], [0, 1]]

def mix(x):
    return [[1, 0], [0, x[0]]]

p = [(-2, 0)]
"""  # x1' = p x1 + u1; x2' = x1 u2 with the x1 of the sample


class Slave:
    """One instance of a unit, with its variables by name."""

    def __init__(self, data: bytes, folder: Path, version: int) -> None:
        folder.mkdir(parents=True)
        (folder / "unit.fmu").write_bytes(data)
        self.description = read_model_description(folder / "unit.fmu")
        self.version, self.variables = version, {v.name: v for v in self.description.modelVariables}
        kind = FMU3Slave if version == 3 else FMU2Slave
        self.unit = kind(
            guid=self.description.guid, unzipDirectory=extract(folder / "unit.fmu", str(folder / "unit")),
            modelIdentifier=self.description.coSimulation.modelIdentifier, instanceName="instance",
        )  # fmt: skip
        self.unit.instantiate()

    def start(self, **values: float) -> None:
        if self.version == 2:
            self.unit.setupExperiment(startTime=0.0)
        self.unit.enterInitializationMode()
        self.set(values)
        self.unit.exitInitializationMode()

    def set(self, values: dict[str, float]) -> None:
        self.set_references([self.variables[name].valueReference for name in values], list(values.values()))

    def set_references(self, references: list[int], values: list[float]) -> None:
        (self.unit.setFloat64 if self.version == 3 else self.unit.setReal)(references, values)

    def get(self, *names: str) -> list[float]:
        get = self.unit.getFloat64 if self.version == 3 else self.unit.getReal
        return list(get([self.variables[name].valueReference for name in names]))

    def get_integer(self, name: str) -> int:
        get = self.unit.getInt32 if self.version == 3 else self.unit.getInteger
        return int(get([self.variables[name].valueReference])[0])

    def is_period_kept(self) -> bool:
        return bool(self.unit.getBoolean([self.variables["period_kept"].valueReference])[0])

    def step(self, now: float, seconds: float) -> None:
        self.unit.doStep(currentCommunicationPoint=now, communicationStepSize=seconds)

    def float_names(self) -> list[str]:
        return [v.name for v in self.variables.values() if v.type in ("Float64", "Real")]

    def names(self, letter: str) -> list[str]:
        """Return the names of a vector's components, such as x1, x2 or x.east, x.north."""
        return [n for n in self.variables if re.fullmatch(rf"{letter}(\d+|\.\w+)", n)]


@cache
def units_of(shape: str, plant: str | None = None) -> dict[str, bytes]:
    """Return the files of the units of a shape, compiled once; `plant` is one of the package's plants, or a file."""
    controller = controller_of_shape(shape)
    return fmu_units(controller, None if plant is None else plant_of(plant, controller.task.dimension, controller.task.order))


def slave(shape: str, version: int, folder: Path, plant: str | None = None) -> Slave:
    suffix = {n: e for e, n in VERSIONS.items()}[version]
    name = f"{controller_of_shape(shape).task.name}{'' if plant is None else '_plant'}.{suffix}"
    return Slave(units_of(shape, plant)[name], folder, version)


@pytest.mark.parametrize("shape", SHAPES)
def test_every_unit_is_valid_and_reproducible(shape: str, tmp_path) -> None:
    controller = controller_of_shape(shape)
    plant = PLANTS["integrator"]
    files = units_of(shape, "integrator")
    assert files == fmu_units(controller, plant)
    assert sorted(files) == sorted(f"{controller.task.name}{p}.{e}" for p in ("", "_plant") for e in VERSIONS)
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
        assert validate_fmu(str(tmp_path / name)) == [], name
        with zipfile.ZipFile(tmp_path / name) as archive:
            root = ET.fromstring(archive.read("modelDescription.xml"))
            assert all(info.date_time == (1980, 1, 1, 0, 0, 0) for info in archive.infolist())
        structure = root.find("ModelStructure")
        assert structure is not None
        dependencies = [e.get("dependencies") for e in structure.iter() if e.tag in ("Output", "InitialUnknown", "Unknown")]
        assert dependencies
        assert None not in dependencies  # importers sort equations by these


def test_every_output_names_the_inputs_that_it_depends_on(tmp_path) -> None:
    """In both versions u depends on all inputs, an edge on none, and a plant's first state on its start."""
    files = units_of("omni_s2", "integrator")
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
        description = read_model_description(tmp_path / name)
        of_outputs = {u.variable.name: sorted(v.name for v in u.dependencies) for u in description.outputs}
        at_start = {u.variable.name: sorted(v.name for v in u.dependencies) for u in description.initialUnknowns}
        if "plant" in name:
            assert of_outputs == {"x1": [], "x2": []}
            assert at_start == {"x1": ["x_start1"], "x2": ["x_start2"]}
        else:
            edges = {f"{edge}{i}": [] for edge in ("lower", "upper") for i in (1, 2)}
            assert of_outputs == at_start == edges | {key: ["x1", "x2"] for key in ("u1", "u2", "margin", "status")}
    (tmp_path / "hold.fmu").write_bytes(units_of("hold")["omni_s2.fmu"])
    outputs = read_model_description(tmp_path / "hold.fmu").outputs
    assert all([v.name for v in u.dependencies] == ["x1", "x2"] for u in outputs)  # edges of a tube that waits depend on x too


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("shape", ["omni_s2", "attitude", "watchman"])
def test_a_unit_equals_the_c_bit_for_bit_in_any_order_of_calls(shape: str, version: int, tmp_path) -> None:
    controller = controller_of_shape(shape)
    task, unit, c = controller.task, slave(shape, version, tmp_path / "a"), CompiledC(controller)
    unit.start()
    dice, n, now = np.random.default_rng(5), task.dimension, 0.0
    x_names, v_names = unit.names("x"), unit.names("v") if task.order == 2 else []
    assert len(x_names) == n
    python = load_module(task.name, controller.files[f"{task.name}.py"])
    for k in range(120):
        t = np.array([wrapped_time(python, now) if task.repeat else np.float32(now)])
        low, high = (a[0] for a in c.tube(t))
        x = low + dice.uniform(-0.1, 1.1, n).astype(np.float32) * (high - low)
        v = dice.uniform(-0.1, 0.1, n).astype(np.float32)
        unit.set(dict(zip(x_names, map(float, x), strict=True)) | dict(zip(v_names, map(float, v), strict=False)))
        arguments = [t, x[None], *([v[None]] if v_names else [])]
        status, u = c.control(*arguments)
        for _ in range(2):  # a second read gives the same
            assert unit.get(*unit.names("u")) == [float(value) for value in u[0]]
            assert unit.get_integer("status") == status[0]
        assert unit.get(*unit.names("lower"), *unit.names("upper")) == [float(value) for value in (*low, *high)]
        assert unit.get("margin") == [float(c.margin(*arguments)[0])]
        if "phase" in unit.variables:
            assert unit.get_integer("phase") == python.phase(float(t[0]))
        h = [0.001, 0.0, 0.37][k % 3] * float(task.prescribed_time) / 9
        unit.step(now, h)
        now += h
    assert now > 1.5 * float(task.prescribed_time)


def wrapped_time(python: ModuleType, t: float) -> np.float32:
    """Return the time that the C is called with at clock time t: full cycles are subtracted in double, the last one as in `wrap`."""
    if t >= python.T_C + python.CYCLE:
        t -= python.CYCLE * int((t - python.T_C) / python.CYCLE)
    return np.float32(t) if np.float32(t) < np.float32(python.T_C) else np.float32(t) - np.float32(python.CYCLE)


@pytest.mark.parametrize(
    ("shape", "plant", "version"), [("omni_s2", "integrator", 3), ("attitude", str(ROOT / "tasks" / "attitude.py"), 2)]
)
def test_a_controller_slavetakes_a_plant_slave_to_the_target(shape: str, plant: str, version: int, tmp_path) -> None:
    """Both units run in a loop at the period of the task, or 1 kHz. The state never leaves the tube and is in the target at t_c."""
    controller = controller_of_shape(shape)
    task, t_c = controller.task, float(controller.task.prescribed_time)
    period = float(task.control.period or 0.001)
    controller_slave, plant_slave = slave(shape, version, tmp_path / "a"), slave(shape, version, tmp_path / "b", plant)
    controller_slave.start()
    plant_slave.start()
    letters = ["x", "v"] if task.order == 2 else ["x"]
    measured = [name for letter in letters for name in controller_slave.names(letter)]
    for k in range(round(t_c / period)):
        controller_slave.set(dict(zip(measured, plant_slave.get(*measured), strict=True)))
        assert controller_slave.get_integer("status") == 0
        u = controller_slave.get(*controller_slave.names("u"))
        plant_slave.set(dict(zip(plant_slave.names("u"), u, strict=True)))
        plant_slave.step(k * period, period)
        controller_slave.step(k * period, period)
    x = plant_slave.get(*plant_slave.names("x"))
    assert task.target_set is not None
    assert all(float(a) <= value <= float(b) for a, value, b in zip(task.target_set.lower, x, task.target_set.upper, strict=True))


def test_a_plant_integrates_its_equations_and_takes_its_constants(tmp_path) -> None:
    """The closed forms are the expected values; the error of the integration is at most h^4 = 1e-12 of the rate."""
    (tmp_path / "mine.py").write_text(PLANT)
    user_plant = slave("omni_s2", 3, tmp_path / "m", str(tmp_path / "mine.py"))
    user_plant.start(x_start1=1.0, x_start2=0.0, p1=-0.5)
    user_plant.set({"u1": 0.25, "u2": 2.0})
    for k in range(2):
        user_plant.step(0.4 * k, 0.4)
    x = [math.exp(-0.5 * t) + 0.5 * (1 - math.exp(-0.5 * t)) for t in (0.4, 0.8)]
    assert user_plant.get("x1", "x2") == pytest.approx([x[1], 0.4 * 2 * (1 + x[0])], rel=1e-11)
    unit = slave("omni_s2", 3, tmp_path / "a", "integrator")
    unit.start(x_start1=1.0, x_start2=2.0)
    assert unit.get("x1", "x2") == [1.0, 2.0]
    unit.set({"u1": 0.5, "w2": -0.25})
    unit.step(0.0, 0.8)
    assert unit.get("x1", "x2") == pytest.approx([1.4, 1.8], rel=1e-12)  # 800 sums, each rounded once
    for name in ("x1", "x_start1"):  # an output, and a start value after the start
        with pytest.raises(Exception, match="fmi3SetFloat64"):
            unit.set({name: 0.0})
    for seconds in (-0.1, float("nan")):
        with pytest.raises(Exception, match="fmi3DoStep"):
            unit.step(0.8, seconds)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("shape", ["hold", "stop"])
def test_a_guard_advances_once_a_step_and_a_saved_state_can_be_restored(shape: str, version: int, tmp_path) -> None:
    """A state that leaves the tube and returns gives the statuses of the Python guard. An importer that reads twice, or restores a saved
    state, reads the same values."""
    controller = controller_of_shape(shape)
    c = CompiledC(controller)
    unit = slave(shape, version, tmp_path / "a")
    python = load_module("omni_s2", controller.files["omni_s2.py"])
    unit.start()
    guard_state: Any = (0.0, 0.0) if shape == "hold" else False
    now, h = 0.0, 0.0625  # exact in both precisions
    statuses = set()
    for k in range(100):
        tube_time = np.array([np.float32(now - (guard_state[0] if shape == "hold" else 0.0))])
        low, high = (a[0].astype(float) for a in c.tube(tube_time))
        x = [float(np.float32((a + b) / 2 + (0.5 if 30 <= k < 36 else 0.0))) for a, b in zip(low, high, strict=True)]
        unit.set(dict(zip(unit.names("x"), [value + 1.0 for value in x], strict=True)))  # an importer tries another state first
        assert unit.get_integer("status") == 1
        unit.set(dict(zip(unit.names("x"), x, strict=True)))
        state = unit.unit.getFMUState()
        status, next_guard_state, u = python.guard(now, x, guard_state)
        for _ in range(2):
            assert unit.get_integer("status") == status
            assert unit.get(*unit.names("u")) == pytest.approx(u, rel=1e-3, abs=1e-3)
            unit.step(now, h)
            unit.unit.setFMUState(state)
        unit.unit.freeFMUState(state)
        unit.step(now, h)
        guard_state, now = next_guard_state, now + h
        statuses.add(status)
    assert statuses == {0, 1}


def test_a_wrong_token_is_refused_an_instance(tmp_path) -> None:
    for version in (2, 3):
        unit = slave("omni_s2", version, tmp_path / str(version))
        unit.unit.guid = "{of another design}"
        with pytest.raises(Exception, match="nstantiate"):
            unit.unit.instantiate()


def test_a_unit_builds_from_its_sources(tmp_path, tool) -> None:
    """Importers on another machine do so, where the unit has no binary for them."""
    tool("cmake")
    for name, data in units_of("omni_s2").items():
        folder = tmp_path / name
        folder.mkdir()
        with zipfile.ZipFile(tmp_path / "sources.fmu", "w") as archive, zipfile.ZipFile(BytesIO(data)) as unit:
            for info in unit.infolist():
                if not info.filename.startswith("binaries/"):
                    archive.writestr(info, unit.read(info))
        extract(str(tmp_path / "sources.fmu"), str(folder))
        build_platform_binary(str(folder), configuration="Release")
        assert list(folder.glob("binaries/*/omni_s2.so"))


@pytest.mark.parametrize(
    ("axes", "names"),
    [
        (["heading (deg)", "2nd"], ["x.heading__deg_", "x._2nd"]),
        (["a b", "a_b"], ["x1", "x2"]),  # both would get one name, so that neither is used
        (None, ["x1", "x2"]),
    ],
)
def test_names_of_axes_become_names_of_variables(axes: list[str] | None, names: list[str], tmp_path) -> None:
    labels = {} if axes is None else {"axes": axes, "units": ["deg", "m/s"]}
    controller = build_once(load_task(ROOT / "tasks" / "omni_s2.toml").changed(**labels))
    (tmp_path / "unit.fmu").write_bytes(fmu_units(controller)["omni_s2.fmu"])
    assert validate_fmu(str(tmp_path / "unit.fmu")) == []
    variables = {v.name: v for v in read_model_description(tmp_path / "unit.fmu").modelVariables}
    assert [n for n in variables if n.startswith("x")] == names
    assert [variables[n].unit for n in names] == ([None, None] if axes is None else ["deg", "m/s"])


def test_no_function_of_the_standard_is_listed_twice() -> None:
    assert len(set(NOT_OFFERED_2)) == len(NOT_OFFERED_2)
    assert len(set(NOT_OFFERED_3)) == len(NOT_OFFERED_3)


def extract_library(data: bytes, folder: Path) -> Path:
    """Unpack a unit in the folder, and return the path of its shared library."""
    (folder / "unit.fmu").write_bytes(data)
    (library,) = Path(extract(str(folder / "unit.fmu"), str(folder / "out"))).glob("binaries/*/*.so")
    return library


def test_a_binary_exports_only_functions_of_the_standard(tmp_path) -> None:
    """Otherwise two units in one process, with functions of the same names, call each other's."""
    for name, data in units_of("hold", "integrator").items():
        folder = tmp_path / name
        folder.mkdir()
        output = subprocess.run(
            ["nm", "-D", "--defined-only", extract_library(data, folder)], capture_output=True, text=True, check=True
        ).stdout
        symbols = {line.split()[-1].partition("@")[0] for line in output.splitlines() if " A " not in line}
        assert len(symbols) > 25
        assert all(symbol.startswith(("fmi2", "fmi3")) for symbol in symbols), symbols


def test_two_designs_of_one_name_can_be_loaded_globally(tmp_path) -> None:
    """Some importers load with RTLD_GLOBAL. The second unit still computes its u, not that of the first."""
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    u = []
    for k, gain in enumerate((1, 3)):
        controller = build_once(task.changed(control={"gain": gain}))
        (tmp_path / str(k)).mkdir()
        data = fmu_units(controller)["omni_s2.fmu"]
        ctypes.CDLL(str(extract_library(data, tmp_path / str(k))), mode=ctypes.RTLD_GLOBAL)
        unit = Slave(data, tmp_path / f"slave{k}", 3)
        unit.start(x1=0.3, x2=0.2)
        u.append(np.array(unit.get("u1", "u2")))
    assert u[1] == pytest.approx(3 * u[0], rel=1e-6)
    assert u[0].all()


@pytest.mark.parametrize("name", ["fmi2", "fmi3", "unit", "N", "reference", "tube", "FMI3"])
@pytest.mark.parametrize("task", ["omni_s2", "spacecraft", "watchman", "courier"])
def test_the_name_of_a_task_does_not_collide_with_names_in_the_unit(task: str, name: str, tmp_path) -> None:
    """The tasks include C with a velocity, a guard, phases and a wrap."""
    outside = "stop" if task == "spacecraft" else "return"
    controller = build_once(load_task(ROOT / "tasks" / f"{task}.toml").changed(name=name, control={"outside": outside}))
    for version, suffix in ((2, "fmi2.fmu"), (3, "fmu")):
        unit = Slave(fmu_units(controller)[f"{name}.{suffix}"], tmp_path / str(version), version)
        unit.start()
        assert unit.get("margin")[0] > 0


def test_different_plants_of_one_task_have_different_tokens(tmp_path) -> None:
    """Two that differ only in a constant's range do too, as the default of the parameter is the middle of the range."""
    tokens = set()
    for text in (PLANT, PLANT.replace("(-2, 0)", "(-2, 1)"), PLANT.replace("[0, 1]]", "[0, 2]]")):
        (tmp_path / "mine.py").write_text(text)
        data = fmu_units(controller_of_shape("omni_s2"), plant_of(str(tmp_path / "mine.py"), 2))["omni_s2_plant.fmu"]
        (tmp_path / "p.fmu").write_bytes(data)
        tokens.add(read_model_description(tmp_path / "p.fmu").guid)
    assert len(tokens) == 3


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("plant", [None, "integrator"])
def test_calls_in_a_wrong_order_and_invalid_times_are_refused(version: int, plant: str | None, tmp_path) -> None:
    unit = slave("omni_s2", version, tmp_path / "a", plant)
    with pytest.raises(Exception, match="DoStep"):
        unit.step(0.0, 0.1)  # before the start
    unit.start()
    for now, seconds in ((0.0, math.inf), (math.nan, 0.1), (math.inf, 0.1), (1e308, 1.7e308), (0.0, -0.1)):
        with pytest.raises(Exception, match="DoStep"):
            unit.step(now, seconds)
    unit.step(0.0, 0.1)
    for now in (0.0, 0.1001, 5.0):  # not the time at which the last step ended
        with pytest.raises(Exception, match="DoStep"):
            unit.step(now, 0.1)
    with pytest.raises(Exception, match="EnterInitializationMode"):
        unit.unit.enterInitializationMode()
    before = unit.get(*unit.float_names())
    first = next(v for v in unit.variables.values() if v.causality == "input").valueReference
    fixed = (
        "t_c" if plant is None else unit.names("x_start")[0]
    )  # a constant, or a value that can be set before the first step only
    for reference in (999, unit.variables[fixed].valueReference):
        with pytest.raises(Exception, match=r"Set(Float64|Real)"):
            unit.set_references([first, reference], [0.45, 0.45])
        assert unit.get(*unit.float_names()) == before  # a refused call sets no value
    unit.unit.terminate()
    assert unit.get(*unit.float_names()) == before  # the last values can still be read
    with pytest.raises(Exception, match="DoStep"):
        unit.step(0.1, 0.1)
    unit.unit.reset()
    unit.start()
    unit.step(0.0, 0.1)


def test_a_tube_that_repeats_has_no_drift_after_10000_cycles(tmp_path) -> None:
    """The cycle is no float. After 10,000 cycles the edges are those after one cycle, up to one rounding of the time."""
    controller = build_once(load_task(ROOT / "tasks" / "watchman.toml").changed(prescribed_time=15.9, emit={"tick_period": None}))
    cycle = cycle_of(controller.design)
    assert cycle is not None
    assert np.float32(cycle.length) != cycle.length  # otherwise the test would not show anything
    unit = Slave(fmu_units(controller)["watchman.fmu"], tmp_path / "a", 3)
    unit.start()
    edges, before = [], 0.0
    for count in (1, 10_000):
        now = float(cycle.begin + cycle.length / 3 + count * cycle.length)
        unit.step(before, now - before)
        before = now
        edges.append(unit.get(*unit.names("lower"), *unit.names("upper")))
    # Three roundings of a time near t_c separate the two: the importer's sum, the unit's float and the C's wrap. The speed of an edge
    # turns them into a distance, and P7 bounds the error of an edge at both times.
    speed, error = float(max(controller.certificate.speed)), float(max(controller.certificate.edge_error))
    time_error = 3 * float(np.spacing(np.float32(controller.task.prescribed_time)))
    assert edges[0] == pytest.approx(edges[1], abs=speed * time_error + 2 * error)


def test_a_unit_of_time_over_time_has_no_dimension(tmp_path) -> None:
    controller = build_once(load_task(ROOT / "tasks" / "omni_s2.toml").changed(axes=["a", "b"], units=["s", "deg"]))
    (tmp_path / "unit.fmu").write_bytes(fmu_units(controller)["omni_s2.fmu"])
    base_units = {d.name: d.baseUnit for d in read_model_description(tmp_path / "unit.fmu").unitDefinitions}
    assert [(base_units[n].s, base_units[n].rad) for n in ("s", "s/s", "deg", "deg/s")] == [(1, 0), (0, 0), (0, 1), (-1, 1)]


def test_units_of_adaptive_tubes_are_refused_and_the_command_writes_refined_ones(tmp_path) -> None:
    adaptive = build_once(load_task(ROOT / "tasks" / "omni_s2.toml").with_options("adaptive"))
    with pytest.raises(BadInput, match="--package fmu: is for refined tubes"):
        fmu_units(adaptive)
    task = str(ROOT / "tasks" / "omni_s2.toml")
    result = CliRunner().invoke(app, ["generate", task, "--package", "fmu", "--plant", "integrator", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == units_of("omni_s2", "integrator")
    refused = CliRunner().invoke(app, ["generate", task, "--plant", "integrator", "--out", str(tmp_path)])
    assert "--plant: is for --package fmu" in str(refused.exception)


# Actions of an importer from time 0 on, and whether they keep the proved period. "x" sets the state, "u" reads u, and a number steps by
# so many periods.
IMPORTERS: dict[str, tuple[list[str | float], bool]] = {
    "in order": (["x", "u", 1.0] * 40, True),
    "faster": (["x", "u", 0.37] * 40, True),
    "twice at one time, and u read after the step": (["x", "u", "x", "u", 1.0, "u", "x", "u", 1.0], True),
    "several steps a sample": (["x", "u", 0.25, 0.25, 0.25, 0.25] * 40, True),
    "no step": (["x", "u", 1.0, 0.0, "x", 0.0, "u", 1.0], True),
    "a step too long": (["x", "u", 1.0, "x", "u", 1.0000001], False),
    "too many steps a sample": (["x", "u", 0.5, 0.5, 0.001], False),
    "u is not read again": (["x", "u", 0.6, "x", 0.6], False),
    "u of the state before": (["x", "u", 0.5, "u", "x", 0.5], False),
    "no sample at the start": ([1.1], False),
}


@pytest.mark.parametrize("version", [2, 3])
def test_a_unit_reports_whether_its_importer_keeps_the_proved_period(version: int, tmp_path, capfd) -> None:
    """`period_kept` is false from the first violation on. One warning in the importer's log has the time and the numbers."""
    unit = slave("attitude", version, tmp_path / "a")
    (period,) = unit.get("period_proved")
    x = dict.fromkeys(unit.names("x"), 0.5)
    for case, (actions, is_kept) in IMPORTERS.items():
        unit.unit.reset()
        unit.start()
        assert unit.is_period_kept()
        capfd.readouterr()
        now, was_violated = 0.0, []
        for action in actions:
            if action == "x":
                unit.set(x)
            elif action == "u":
                unit.get(*unit.names("u"))
            else:
                unit.step(now, float(action) * period)
                now += float(action) * period
                was_violated.append(not unit.is_period_kept())
        assert was_violated[-1] != is_kept, case
        assert was_violated == sorted(was_violated), case  # it never becomes true again
        log = capfd.readouterr().out
        assert log.count("[WARNING]") == int(not is_kept), (case, log)
        if not is_kept:
            assert re.search(r"t = [\d.e-]+ s: (u was read [\d.e-]+ s after x was set|[\d.e-]+ s from a state to the next)", log)
            assert f"{period:.9g} s (P9)" in log or "set x, read u, then step" in log
    state = unit.unit.getFMUState()  # of a unit that was not called in time
    unit.unit.reset()
    unit.start()
    assert unit.is_period_kept()
    unit.unit.setFMUState(state)
    assert not unit.is_period_kept()
    unit.unit.freeFMUState(state)


def test_a_unit_without_a_proved_period_has_no_variables_for_it() -> None:
    names = {v.name for v in controller_unit(controller_of_shape("omni_s2")).variables}
    assert not names & {"period_kept", "period_proved"}
    task = load_task(ROOT / "tasks" / "attitude.toml")
    uncertified = build_once(task.changed(control={"gain": "0.000001"}), uncertified=True)
    assert not uncertified.certificate.holds
    assert not {v.name for v in controller_unit(uncertified).variables} & {"period_kept", "period_proved"}


def test_the_example_of_the_page_on_units_runs(tmp_path, monkeypatch) -> None:
    (source,) = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs" / "fmu.md").read_text(), re.M | re.S)
    (tmp_path / "units").mkdir()
    for name, data in units_of("omni_s2").items():
        (tmp_path / "units" / name).write_bytes(data)
    monkeypatch.chdir(tmp_path)
    printed: list[Any] = []
    exec(source, {"print": lambda *values: printed.append(values)})
    (((u1, u2, margin), (status,)),) = printed
    assert status == 0
    assert margin == pytest.approx(0.5, abs=1e-3)  # the middle of the first box, less an allowance for rounding
    assert abs(u1) + abs(u2) < 0.01
