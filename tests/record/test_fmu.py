"""Units of FMI: valid by FMPy, the C's bits, a closed loop of two units, what an importer may do to one, the same bytes again."""

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
from tests.support.controllers import ROOT, built

# Every shape that the unit has: axes with names, order 2, a mission that repeats, both guards.
SHAPES: dict[str, dict[str, Any]] = {
    "omni_s2": {},
    "attitude": {},
    "watchman": {},
    "hold": {"control": {"outside": "hold"}},
    "stop": {"control": {"outside": "stop"}},
}
VERSIONS = {"fmu": 3, "fmi2.fmu": 2}


@cache
def made(shape: str) -> EmittedController:
    named = shape if (ROOT / "tasks" / f"{shape}.toml").exists() else "omni_s2"
    return built(load_task(ROOT / "tasks" / f"{named}.toml").changed(**SHAPES[shape]))


PLANT = """
import casadi as ca

def f(x, p):
    return [p[0] * x[0], 0]

def g(x, p):
    return [[1, 0], [0, 1]]

def mix(x):
    return [[1, 0], [0, x[0]]]

p = [(-2, 0)]
"""  # xdot = p x + u_1; ydot = x(of the sample) u_2


class Slave:
    """One instance of a unit, by the names of its variables."""

    def __init__(self, data: bytes, folder: Path, version: int) -> None:
        folder.mkdir(parents=True)
        (folder / "unit.fmu").write_bytes(data)
        self.description = read_model_description(folder / "unit.fmu")
        self.version, self.at = version, {v.name: v for v in self.description.modelVariables}
        kind = FMU3Slave if version == 3 else FMU2Slave
        self.unit = kind(
            guid=self.description.guid, unzipDirectory=extract(folder / "unit.fmu", str(folder / "unit")),
            modelIdentifier=self.description.coSimulation.modelIdentifier, instanceName="one",
        )  # fmt: skip
        self.unit.instantiate()

    def start(self, **values: float) -> None:
        if self.version == 2:
            self.unit.setupExperiment(startTime=0.0)
        self.unit.enterInitializationMode()
        self.set(values)
        self.unit.exitInitializationMode()

    def set(self, values: dict[str, float]) -> None:
        self.put([self.at[name].valueReference for name in values], list(values.values()))

    def put(self, references: list[int], values: list[float]) -> None:
        (self.unit.setFloat64 if self.version == 3 else self.unit.setReal)(references, values)

    def get(self, *names: str) -> list[float]:
        get = self.unit.getFloat64 if self.version == 3 else self.unit.getReal
        return list(get([self.at[name].valueReference for name in names]))

    def whole(self, name: str) -> int:
        get = self.unit.getInt32 if self.version == 3 else self.unit.getInteger
        return int(get([self.at[name].valueReference])[0])

    def kept(self) -> bool:
        return bool(self.unit.getBoolean([self.at["period_kept"].valueReference])[0])

    def step(self, now: float, seconds: float) -> None:
        self.unit.doStep(currentCommunicationPoint=now, communicationStepSize=seconds)

    def numbers(self) -> list[str]:
        return [v.name for v in self.at.values() if v.type in ("Float64", "Real")]

    def names(self, letter: str) -> list[str]:
        """x1, x2 or x.east, x.north."""
        return [n for n in self.at if re.fullmatch(rf"{letter}(\d+|\.\w+)", n)]


@cache
def units_of(shape: str, plant: str | None = None) -> dict[str, bytes]:
    """The files of a shape's units, compiled once; `plant`: one of the package's."""
    controller = made(shape)
    return fmu_units(controller, None if plant is None else plant_of(plant, controller.task.dimension, controller.task.order))


def slave(shape: str, version: int, folder: Path, plant: str | None = None) -> Slave:
    ending = {n: e for e, n in VERSIONS.items()}[version]
    name = f"{made(shape).task.name}{'' if plant is None else '_plant'}.{ending}"
    return Slave(units_of(shape, plant)[name], folder, version)


@pytest.mark.parametrize("shape", SHAPES)
def test_every_unit_is_valid_and_the_same_again(shape: str, tmp_path) -> None:
    controller = made(shape)
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
        known = [e.get("dependencies") for e in structure.iter() if e.tag in ("Output", "InitialUnknown", "Unknown")]
        assert known
        assert None not in known  # an importer that sorts equations goes by these


def test_an_output_names_what_it_is_made_of(tmp_path) -> None:
    """By name, in both versions: u of all that comes in, an edge of nothing, a plant's state of its start at the start."""
    files = units_of("omni_s2", "integrator")
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
        described = read_model_description(tmp_path / name)
        at = {u.variable.name: sorted(v.name for v in u.dependencies) for u in described.outputs}
        begun = {u.variable.name: sorted(v.name for v in u.dependencies) for u in described.initialUnknowns}
        if "plant" in name:
            assert at == {"x1": [], "x2": []}
            assert begun == {"x1": ["x_start1"], "x2": ["x_start2"]}
        else:
            edges = {f"{edge}{i}": [] for edge in ("lower", "upper") for i in (1, 2)}
            assert at == begun == edges | {key: ["x1", "x2"] for key in ("u1", "u2", "margin", "status")}
    (tmp_path / "hold.fmu").write_bytes(units_of("hold")["omni_s2.fmu"])
    waits = read_model_description(tmp_path / "hold.fmu").outputs
    assert all([v.name for v in u.dependencies] == ["x1", "x2"] for u in waits)  # of a tube that waits the edges too


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("shape", ["omni_s2", "attitude", "watchman"])
def test_a_unit_gives_the_cs_bits_in_any_order_of_calls(shape: str, version: int, tmp_path) -> None:
    controller = made(shape)
    task, unit, c = controller.task, slave(shape, version, tmp_path / "a"), CompiledC(controller)
    unit.start()
    dice, n, now = np.random.default_rng(5), task.dimension, 0.0
    x_names, v_names = unit.names("x"), unit.names("v") if task.order == 2 else []
    assert len(x_names) == n
    python = load_module(task.name, controller.files[f"{task.name}.py"])
    for k in range(120):
        t = np.array([turned_back(python, now) if task.repeat else np.float32(now)])
        low, high = (a[0] for a in c.tube(t))
        x = low + dice.uniform(-0.1, 1.1, n).astype(np.float32) * (high - low)
        v = dice.uniform(-0.1, 0.1, n).astype(np.float32)
        unit.set(dict(zip(x_names, map(float, x), strict=True)) | dict(zip(v_names, map(float, v), strict=False)))
        given = [t, x[None], *([v[None]] if v_names else [])]
        status, u = c.control(*given)
        for _ in range(2):  # asked twice, the same
            assert unit.get(*unit.names("u")) == [float(value) for value in u[0]]
            assert unit.whole("status") == status[0]
        assert unit.get(*unit.names("lower"), *unit.names("upper")) == [float(value) for value in (*low, *high)]
        assert unit.get("margin") == [float(c.margin(*given)[0])]
        if "phase" in unit.at:
            assert unit.whole("phase") == python.phase(float(t[0]))
        h = [0.001, 0.0, 0.37][k % 3] * float(task.prescribed_time) / 9
        unit.step(now, h)
        now += h
    assert now > 1.5 * float(task.prescribed_time)


def turned_back(python: ModuleType, t: float) -> np.float32:
    """The C's time of a clock that never ends: whole cycles in double, the last one as `wrap` has it."""
    if t >= python.T_C + python.CYCLE:
        t -= python.CYCLE * int((t - python.T_C) / python.CYCLE)
    return np.float32(t) if np.float32(t) < np.float32(python.T_C) else np.float32(t) - np.float32(python.CYCLE)


@pytest.mark.parametrize(
    ("shape", "plant", "version"), [("omni_s2", "integrator", 3), ("attitude", str(ROOT / "tasks" / "attitude.py"), 2)]
)
def test_a_controller_and_a_plant_that_are_joined_arrive(shape: str, plant: str, version: int, tmp_path) -> None:
    """Both units in a loop at the period of the task, or 1 kHz: in the target at t_c, never outside the tube."""
    controller = made(shape)
    task, t_c = controller.task, float(controller.task.prescribed_time)
    period = float(task.control.period or 0.001)
    brain, body = slave(shape, version, tmp_path / "a"), slave(shape, version, tmp_path / "b", plant)
    brain.start()
    body.start()
    letters = ["x", "v"] if task.order == 2 else ["x"]
    measured = [name for letter in letters for name in brain.names(letter)]
    for k in range(round(t_c / period)):
        brain.set(dict(zip(measured, body.get(*measured), strict=True)))
        assert brain.whole("status") == 0
        body.set(dict(zip(body.names("u"), brain.get(*brain.names("u")), strict=True)))
        body.step(k * period, period)
        brain.step(k * period, period)
    x = body.get(*body.names("x"))
    assert task.target_set is not None
    assert all(float(a) <= value <= float(b) for a, value, b in zip(task.target_set.lower, x, task.target_set.upper, strict=True))


def test_a_plant_integrates_its_equations_and_takes_its_constants(tmp_path) -> None:
    """Beside closed forms; the error of the integration is h^4 = 1e-12 of the rate at most."""
    (tmp_path / "mine.py").write_text(PLANT)
    mine = slave("omni_s2", 3, tmp_path / "m", str(tmp_path / "mine.py"))
    mine.start(x_start1=1.0, x_start2=0.0, p1=-0.5)
    mine.set({"u1": 0.25, "u2": 2.0})
    for k in range(2):
        mine.step(0.4 * k, 0.4)
    x = [math.exp(-0.5 * t) + 0.5 * (1 - math.exp(-0.5 * t)) for t in (0.4, 0.8)]
    assert mine.get("x1", "x2") == pytest.approx([x[1], 0.4 * 2 * (1 + x[0])], rel=1e-11)
    unit = slave("omni_s2", 3, tmp_path / "a", "integrator")
    unit.start(x_start1=1.0, x_start2=2.0)
    assert unit.get("x1", "x2") == [1.0, 2.0]
    unit.set({"u1": 0.5, "w2": -0.25})
    unit.step(0.0, 0.8)
    assert unit.get("x1", "x2") == pytest.approx([1.4, 1.8], rel=1e-12)  # 800 sums, each rounded once
    for name in ("x1", "x_start1"):  # an output; a start that is over
        with pytest.raises(Exception, match="fmi3SetFloat64"):
            unit.set({name: 0.0})
    for seconds in (-0.1, float("nan")):
        with pytest.raises(Exception, match="fmi3DoStep"):
            unit.step(0.8, seconds)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("shape", ["hold", "stop"])
def test_a_guard_moves_on_once_a_step_and_a_state_can_be_put_back(shape: str, version: int, tmp_path) -> None:
    """A drive that leaves the tube and returns, beside the guard of the Python, in bits of the C. An importer that looks twice, or
    goes back to a state that it kept, sees the same."""
    controller = made(shape)
    c = CompiledC(controller)
    unit = slave(shape, version, tmp_path / "a")
    python = load_module("omni_s2", controller.files["omni_s2.py"])
    unit.start()
    held: Any = (0.0, 0.0) if shape == "hold" else False
    now, h = 0.0, 0.0625  # exact in both precisions
    seen = set()
    for k in range(100):
        at = np.array([np.float32(now - (held[0] if shape == "hold" else 0.0))])
        low, high = (a[0].astype(float) for a in c.tube(at))
        x = [float(np.float32((a + b) / 2 + (0.5 if 30 <= k < 36 else 0.0))) for a, b in zip(low, high, strict=True)]
        unit.set(dict(zip(unit.names("x"), [value + 1.0 for value in x], strict=True)))  # an importer tries something
        assert unit.whole("status") == 1
        unit.set(dict(zip(unit.names("x"), x, strict=True)))
        state = unit.unit.getFMUState()
        status, after, u = python.guard(now, x, held)
        for _ in range(2):
            assert unit.whole("status") == status
            assert unit.get(*unit.names("u")) == pytest.approx(u, rel=1e-3, abs=1e-3)
            unit.step(now, h)
            unit.unit.setFMUState(state)
        unit.unit.freeFMUState(state)
        unit.step(now, h)
        held, now = after, now + h
        seen.add(status)
    assert seen == {0, 1}


def test_another_token_makes_no_instance(tmp_path) -> None:
    for version in (2, 3):
        unit = slave("omni_s2", version, tmp_path / str(version))
        unit.unit.guid = "{of another design}"
        with pytest.raises(Exception, match="nstantiate"):
            unit.unit.instantiate()


def test_a_unit_builds_from_its_sources(tmp_path, tool) -> None:
    """As importers on another machine do it, which find no binary of theirs."""
    tool("cmake")
    for name, data in units_of("omni_s2").items():
        folder = tmp_path / name
        folder.mkdir()
        with zipfile.ZipFile(tmp_path / "of.fmu", "w") as archive, zipfile.ZipFile(BytesIO(data)) as given:
            for info in given.infolist():
                if not info.filename.startswith("binaries/"):
                    archive.writestr(info, given.read(info))
        extract(str(tmp_path / "of.fmu"), str(folder))
        build_platform_binary(str(folder), configuration="Release")
        assert list(folder.glob("binaries/*/omni_s2.so"))


@pytest.mark.parametrize(
    ("axes", "names"),
    [
        (["heading (deg)", "2nd"], ["x.heading__deg_", "x._2nd"]),
        (["a b", "a_b"], ["x1", "x2"]),  # the same name twice is none
        (None, ["x1", "x2"]),
    ],
)
def test_names_of_axes_become_names_of_variables(axes: list[str] | None, names: list[str], tmp_path) -> None:
    given = {} if axes is None else {"axes": axes, "units": ["deg", "m/s"]}
    controller = built(load_task(ROOT / "tasks" / "omni_s2.toml").changed(**given))
    (tmp_path / "unit.fmu").write_bytes(fmu_units(controller)["omni_s2.fmu"])
    assert validate_fmu(str(tmp_path / "unit.fmu")) == []
    variables = {v.name: v for v in read_model_description(tmp_path / "unit.fmu").modelVariables}
    assert [n for n in variables if n.startswith("x")] == names
    assert [variables[n].unit for n in names] == ([None, None] if axes is None else ["deg", "m/s"])


def test_everything_of_the_standard_is_there_once() -> None:
    assert len(set(NOT_OFFERED_2)) == len(NOT_OFFERED_2)
    assert len(set(NOT_OFFERED_3)) == len(NOT_OFFERED_3)


def library(data: bytes, folder: Path) -> Path:
    (folder / "one.fmu").write_bytes(data)
    (found,) = Path(extract(str(folder / "one.fmu"), str(folder / "out"))).glob("binaries/*/*.so")
    return found


def test_a_binary_shows_the_standards_functions_alone(tmp_path) -> None:
    """Else two units in one process call each other's: of one task, of another design, under names that are the same."""
    for name, data in units_of("hold", "integrator").items():
        folder = tmp_path / name
        folder.mkdir()
        told = subprocess.run(
            ["nm", "-D", "--defined-only", library(data, folder)], capture_output=True, text=True, check=True
        ).stdout
        seen = {line.split()[-1].partition("@")[0] for line in told.splitlines() if " A " not in line}
        assert len(seen) > 25
        assert all(symbol.startswith(("fmi2", "fmi3")) for symbol in seen), seen


def test_two_designs_of_one_name_loaded_globally_keep_apart(tmp_path) -> None:
    """As an importer does it that loads with RTLD_GLOBAL: the second's u is its own, not the first's."""
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    u = []
    for k, gain in enumerate((1, 3)):
        controller = built(task.changed(control={"gain": gain}))
        (tmp_path / str(k)).mkdir()
        data = fmu_units(controller)["omni_s2.fmu"]
        ctypes.CDLL(str(library(data, tmp_path / str(k))), mode=ctypes.RTLD_GLOBAL)
        unit = Slave(data, tmp_path / f"slave{k}", 3)
        unit.start(x1=0.3, x2=0.2)
        u.append(np.array(unit.get("u1", "u2")))
    assert u[1] == pytest.approx(3 * u[0], rel=1e-6)
    assert u[0].all()


@pytest.mark.parametrize("name", ["fmi2", "fmi3", "unit", "N", "reference", "tube", "FMI3"])
@pytest.mark.parametrize("task", ["omni_s2", "spacecraft", "watchman", "courier"])
def test_a_tasks_name_takes_no_file_or_name_of_the_unit(task: str, name: str, tmp_path) -> None:
    """Of tasks whose C has a velocity, a guard, phases and a wrap too."""
    outside = "stop" if task == "spacecraft" else "return"
    controller = built(load_task(ROOT / "tasks" / f"{task}.toml").changed(name=name, control={"outside": outside}))
    for version, ending in ((2, "fmi2.fmu"), (3, "fmu")):
        unit = Slave(fmu_units(controller)[f"{name}.{ending}"], tmp_path / str(version), version)
        unit.start()
        assert unit.get("margin")[0] > 0


def test_plants_of_one_task_have_tokens_of_their_own(tmp_path) -> None:
    """And so have two that differ in a constant's range alone, whose middle is where the parameter begins."""
    tokens = set()
    for text in (PLANT, PLANT.replace("(-2, 0)", "(-2, 1)"), PLANT.replace("[0, 1]]", "[0, 2]]")):
        (tmp_path / "mine.py").write_text(text)
        data = fmu_units(made("omni_s2"), plant_of(str(tmp_path / "mine.py"), 2))["omni_s2_plant.fmu"]
        (tmp_path / "p.fmu").write_bytes(data)
        tokens.add(read_model_description(tmp_path / "p.fmu").guid)
    assert len(tokens) == 3


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("plant", [None, "integrator"])
def test_calls_out_of_turn_and_times_that_are_none_are_refused(version: int, plant: str | None, tmp_path) -> None:
    unit = slave("omni_s2", version, tmp_path / "a", plant)
    with pytest.raises(Exception, match="DoStep"):
        unit.step(0.0, 0.1)  # before it began
    unit.start()
    for now, seconds in ((0.0, math.inf), (math.nan, 0.1), (math.inf, 0.1), (1e308, 1.7e308), (0.0, -0.1)):
        with pytest.raises(Exception, match="DoStep"):
            unit.step(now, seconds)
    unit.step(0.0, 0.1)
    for now in (0.0, 0.1001, 5.0):  # not where it ended
        with pytest.raises(Exception, match="DoStep"):
            unit.step(now, 0.1)
    with pytest.raises(Exception, match="EnterInitializationMode"):
        unit.unit.enterInitializationMode()
    before = unit.get(*unit.numbers())
    first = next(v for v in unit.at.values() if v.causality == "input").valueReference
    late = "t_c" if plant is None else unit.names("x_start")[0]  # a constant, or what is set before the first step alone
    for other in (999, unit.at[late].valueReference):
        with pytest.raises(Exception, match=r"Set(Float64|Real)"):
            unit.put([first, other], [0.45, 0.45])
        assert unit.get(*unit.numbers()) == before  # of what is refused nothing is set
    unit.unit.terminate()
    assert unit.get(*unit.numbers()) == before  # what it has come to can still be read
    with pytest.raises(Exception, match="DoStep"):
        unit.step(0.1, 0.1)
    unit.unit.reset()
    unit.start()
    unit.step(0.0, 0.1)


def test_a_tube_that_repeats_itself_keeps_to_its_cycle_for_a_day(tmp_path) -> None:
    """The cycle is no float: after 10,000 of them the tube stands where it stood after one, up to a float's error of one."""
    controller = built(load_task(ROOT / "tasks" / "watchman.toml").changed(prescribed_time=15.9, emit={"tick_period": None}))
    cycle = cycle_of(controller.design)
    assert cycle is not None
    assert np.float32(cycle.length) != cycle.length  # else this says nothing
    unit = Slave(fmu_units(controller)["watchman.fmu"], tmp_path / "a", 3)
    unit.start()
    edges, before = [], 0.0
    for count in (1, 10_000):
        now = float(cycle.begin + cycle.length / 3 + count * cycle.length)
        unit.step(before, now - before)
        before = now
        edges.append(unit.get(*unit.names("lower"), *unit.names("upper")))
    # The edges move at most so fast, and three roundings of a time near t_c lie between the two: the importer's sum, the unit's
    # float, the C's wrap; P7 bounds what an edge is off at each.
    speed, error = float(max(controller.certificate.speed)), float(max(controller.certificate.edge_error))
    late = 3 * float(np.spacing(np.float32(controller.task.prescribed_time)))
    assert edges[0] == pytest.approx(edges[1], abs=speed * late + 2 * error)


def test_a_unit_of_time_over_time_has_no_dimension(tmp_path) -> None:
    controller = built(load_task(ROOT / "tasks" / "omni_s2.toml").changed(axes=["a", "b"], units=["s", "deg"]))
    (tmp_path / "unit.fmu").write_bytes(fmu_units(controller)["omni_s2.fmu"])
    defined = {d.name: d.baseUnit for d in read_model_description(tmp_path / "unit.fmu").unitDefinitions}
    assert [(defined[n].s, defined[n].rad) for n in ("s", "s/s", "deg", "deg/s")] == [(1, 0), (0, 0), (0, 1), (-1, 1)]


def test_what_has_no_unit_is_refused_and_the_command_writes_the_others(tmp_path) -> None:
    adaptive = built(load_task(ROOT / "tasks" / "omni_s2.toml").with_options("adaptive"))
    with pytest.raises(BadInput, match="--package fmu: is for refined tubes"):
        fmu_units(adaptive)
    task = str(ROOT / "tasks" / "omni_s2.toml")
    result = CliRunner().invoke(app, ["generate", task, "--package", "fmu", "--plant", "integrator", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == units_of("omni_s2", "integrator")
    refused = CliRunner().invoke(app, ["generate", task, "--plant", "integrator", "--out", str(tmp_path)])
    assert "--plant: is for --package fmu" in str(refused.exception)


# Each: what an importer does from 0 on, "x": sets the state, "u": reads u, a number: steps so many periods; and whether that is kept.
IMPORTERS: dict[str, tuple[list[str | float], bool]] = {
    "in order": (["x", "u", 1.0] * 40, True),
    "faster": (["x", "u", 0.37] * 40, True),
    "twice at one time, and for a look after the step": (["x", "u", "x", "u", 1.0, "u", "x", "u", 1.0], True),
    "several steps a sample": (["x", "u", 0.25, 0.25, 0.25, 0.25] * 40, True),
    "no step": (["x", "u", 1.0, 0.0, "x", 0.0, "u", 1.0], True),
    "a step too long": (["x", "u", 1.0, "x", "u", 1.0000001], False),
    "too many steps a sample": (["x", "u", 0.5, 0.5, 0.001], False),
    "u is not read again": (["x", "u", 0.6, "x", 0.6], False),
    "u is of the state before": (["x", "u", 0.5, "u", "x", 0.5], False),
    "no sample at the start": ([1.1], False),
}


@pytest.mark.parametrize("version", [2, 3])
def test_a_unit_says_whether_its_importer_keeps_to_what_is_proved(version: int, tmp_path, capfd) -> None:
    """False from the first step on that leaves it; one warning in the importer's log says when, and the numbers."""
    unit = slave("attitude", version, tmp_path / "a")
    (period,) = unit.get("period_proved")
    x = dict.fromkeys(unit.names("x"), 0.5)
    for what, (does, good) in IMPORTERS.items():
        unit.unit.reset()
        unit.start()
        assert unit.kept()
        capfd.readouterr()
        now, went_wrong = 0.0, []
        for act in does:
            if act == "x":
                unit.set(x)
            elif act == "u":
                unit.get(*unit.names("u"))
            else:
                unit.step(now, float(act) * period)
                now += float(act) * period
                went_wrong.append(not unit.kept())
        assert went_wrong[-1] != good, what
        assert went_wrong == sorted(went_wrong), what  # it never becomes true again
        warned = capfd.readouterr().out
        assert warned.count("[WARNING]") == int(not good), (what, warned)
        if not good:
            assert re.search(
                r"t = [\d.e-]+ s: (u was read [\d.e-]+ s after x was set|[\d.e-]+ s from a state to the next)", warned
            )
            assert f"{period:.9g} s (P9)" in warned or "set x, read u, then step" in warned
    state = unit.unit.getFMUState()  # of a unit that has left it
    unit.unit.reset()
    unit.start()
    assert unit.kept()
    unit.unit.setFMUState(state)
    assert not unit.kept()
    unit.unit.freeFMUState(state)


def test_a_unit_without_a_proved_period_says_nothing_of_one() -> None:
    names = {v.name for v in controller_unit(made("omni_s2")).variables}
    assert not names & {"period_kept", "period_proved"}
    task = load_task(ROOT / "tasks" / "attitude.toml")
    uncertified = built(task.changed(control={"gain": "0.000001"}), uncertified=True)
    assert not uncertified.certificate.holds
    assert not {v.name for v in controller_unit(uncertified).variables} & {"period_kept", "period_proved"}


def test_the_pages_example_runs(tmp_path, monkeypatch) -> None:
    (source,) = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs" / "fmu.md").read_text(), re.M | re.S)
    (tmp_path / "units").mkdir()
    for name, data in units_of("omni_s2").items():
        (tmp_path / "units" / name).write_bytes(data)
    monkeypatch.chdir(tmp_path)
    printed: list[Any] = []
    exec(source, {"print": lambda *values: printed.append(values)})
    (((u1, u2, margin), (status,)),) = printed
    assert status == 0
    assert margin == pytest.approx(0.5, abs=1e-3)  # the middle of the first box, less room for rounding
    assert abs(u1) + abs(u2) < 0.01
