"""Units of co-simulation (FMI 3.0 and 2.0) of a controller and of a plant: sources, a binary of this machine, a description.

An output follows the inputs at once, as in the reference units of the standard: set x, read u, step. An importer that connects
a controller with a plant therefore exchanges x and u once a step, as a board and a robot do once a sample.

record/package.py calls `fmu_units`.

Long because FMI wants a description of every variable, and a definition of every function, also of those that return an error.
"""

from __future__ import annotations

import io
import platform
import re
import sys
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from fractions import Fraction
from pathlib import Path

from stt_codegen.design_kinds import kinds_offering
from stt_codegen.emit import Files, cycle_literal, driven_sources, extra_files, file_names, phase_name
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model, model
from stt_codegen.program import Program, round_to, shortest
from stt_codegen.program.convert import lower as lower_to_kernel
from stt_codegen.program.targets import run_compiler
from stt_codegen.program.targets.c import CPrinter
from stt_codegen.program.targets.c.runner import STRICT, find_compiler
from stt_codegen.program.targets.template_files import template
from stt_codegen.properties import Property
from stt_codegen.record.fmu_description import Unit, Variable, describe_build, describe_fmi_2, describe_fmi_3, to_xml
from stt_codegen.task import Task

ARCHIVE_DATE = (1980, 1, 1, 0, 0, 0)  # of every file in a unit, so that the bytes do not depend on when it is packed
# Functions of FMI 2.0 and 3.0 that a unit has because importers look for them, and that return an error.
NOT_OFFERED_2 = """GetBoolean GetString SetInteger SetBoolean SetString SerializedFMUstateSize SerializeFMUstate
DeSerializeFMUstate GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives CancelStep GetStatus GetRealStatus
GetIntegerStatus GetBooleanStatus GetStringStatus""".split()
NOT_OFFERED_3 = """EnterEventMode GetFloat32 GetInt8 GetUInt8 GetInt16 GetUInt16 GetUInt32 GetInt64 GetUInt64 GetBoolean GetString
GetBinary GetClock SetFloat32 SetInt8 SetUInt8 SetInt16 SetUInt16 SetInt32 SetUInt32 SetInt64 SetUInt64 SetBoolean SetString
SetBinary SetClock GetNumberOfVariableDependencies GetVariableDependencies SerializedFMUStateSize SerializeFMUState
DeserializeFMUState GetDirectionalDerivative GetAdjointDerivative EnterConfigurationMode ExitConfigurationMode GetIntervalDecimal
GetIntervalFraction GetShiftDecimal GetShiftFraction SetIntervalDecimal SetIntervalFraction SetShiftDecimal SetShiftFraction
EvaluateDiscreteStates UpdateDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates
GetContinuousStateDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates GetNumberOfEventIndicators
GetNumberOfContinuousStates EnterStepMode GetOutputDerivatives ActivateModelPartition""".split()


def fmu_units(controller: EmittedController, plant: Model | None = None) -> Files:
    """Return `<p>.fmu` and `<p>.fmi2.fmu` of a controller, and with a plant `<p>_plant.fmu` and `<p>_plant.fmi2.fmu`.

    Raises `BadInput`, and `MissingTool` without a C compiler.
    """
    units = [controller_unit(controller)]
    if plant is not None:
        units.append(plant_unit(controller.task, plant))
    return {f"{unit.name}{end}": pack(unit, version) for unit in units for version, end in ((3, ".fmu"), (2, ".fmi2.fmu"))}


# ------------------------------------------------------------------------------------------------ variables and C of a unit


class VariableList:
    """The variables of a unit in the order of their references, and the first reference of each group of variables."""

    def __init__(self) -> None:
        self.variables = [_seconds("time", "independent", "since the start")]
        self.first_references: dict[str, int] = {}  # by group, for the template

    def append_group(self, group: str, *variables: Variable) -> None:
        """Append variables to a group. A group that has variables already keeps its first reference."""
        self.first_references.setdefault(group, len(self.variables))
        self.variables.extend(variables)


@dataclass(frozen=True)
class Signal:
    """One variable for each dimension of a task.

    letter: begins the names. initial_values: literals of C. rate_order: the unit is divided by seconds to this power.
    """

    letter: str
    causality: str
    description: str
    initial_values: Sequence[str]
    rate_order: int
    _: KW_ONLY
    follows_inputs: bool = False
    start_of: str = ""  # of a parameter: the letter of the outputs whose initial values it sets


def _signal_variables(task: Task, signal: Signal) -> list[Variable]:
    """Return the variables of a signal, named after the task's dimensions."""
    n = task.dimension
    outputs = _dimension_names(task, signal.start_of) if signal.start_of else [""] * n
    return [
        Variable(
            name,
            signal.causality,
            signal.description,
            initial_value,
            _over_time(unit, signal.rate_order),
            base_unit=unit,
            rate_order=signal.rate_order,
            follows_inputs=signal.follows_inputs,
            start_of=output,
        )
        for name, initial_value, unit, output in zip(
            _dimension_names(task, signal.letter), signal.initial_values, task.units or ("",) * n, outputs, strict=True
        )
    ]


def _dimension_names(task: Task, letter: str) -> list[str]:
    """Return names such as x.heading where the task names its axes; else, and where two would be the same, x1, x2, .."""
    words = [re.sub(r"^(?=\d)|[^A-Za-z0-9_]", "_", axis) for axis in task.axes or ()]
    if not words or "" in words or len(set(words)) < len(words):
        return [f"{letter}{i + 1}" for i in range(task.dimension)]
    return [f"{letter}.{word}" for word in words]


def _over_time(unit: str, rate_order: int) -> str:
    """Return unit, unit/s or unit/s2; a unit that is a quotient gets brackets first."""
    if not unit or not rate_order:
        return unit
    numerator = f"({unit})" if "/" in unit else unit
    return f"{numerator}/s{'' if rate_order == 1 else rate_order}"


def _seconds(name: str, causality: str, description: str, initial_value: str = "0.0") -> Variable:
    return Variable(name, causality, description, initial_value, "s", base_unit="s")


def _double_literal(value: Fraction) -> str:
    return shortest(round_to(value, "double"), "double")


def controller_unit(controller: EmittedController) -> Unit:
    """Return the unit of the emitted C, whose t is the importer's time. Raises `BadInput` where no importer can drive it."""
    task, design, certificate = controller.task, controller.design, controller.certificate
    _require_external_time(controller)
    has_phases = phase_name(task.name) in controller.files
    proved = certificate.proved_period if certificate.holds else None
    proved_period = None if proved is None else _double_literal(proved.period)
    variables = _controller_variables(task, proved_period, has_phases)
    body = template("fmu/controller.c.j2").render(
        prefix=task.name, macro=task.name.upper(), order=task.order, outside=task.control.outside,
        cycle=cycle_literal(design), phases=has_phases, first_references=variables.first_references, proved=proved is not None,
    )  # fmt: skip
    common = file_names(task.name)
    sources = [common.header, *driven_sources(task), *([phase_name(task.name)] if has_phases else [])]
    verdict = "certified" if certificate.holds else "NOT CERTIFIED"
    return Unit(
        name=task.name,
        description=f"Prescribed-time reach-avoid-stay controller {task.name}, {design.kind} tube, {verdict}",
        variables=tuple(variables.variables),
        body=body,
        header=common.header,
        sources={name: controller.files[name] for name in sources},
        state_members=_state_members(task.control.outside, proved is not None),
        stop_time=_double_literal(task.prescribed_time),
        step_size="" if task.control.period is None else _double_literal(task.control.period),
        extras=extra_files(task.name, design, controller.files, has_module=False),
    )


def _require_external_time(controller: EmittedController) -> None:
    """Raise `BadInput` for a controller that has an alpha or takes a velocity by differences: it needs more than the time."""
    if not controller.design.capabilities.runs_in_ros2_and_fmu:
        kinds = kinds_offering("runs_in_ros2_and_fmu")
        raise BadInput(f"--package fmu: is for {kinds} tubes; the {controller.design.kind} one has steps of its own")
    if controller.task.uses_differences:
        raise BadInput("--package fmu: velocity by differences depends on when x is sampled, which no importer says; measure v")


def _controller_variables(task: Task, proved_period: str | None, has_phases: bool) -> VariableList:
    """Return the variables of a controller's unit. proved_period: a literal of C in seconds."""
    zeros, initial_state = ["0.0"] * task.dimension, [_double_literal(v) for v in task.initial_state]
    tube_waits = task.control.outside == "hold"  # then the tube's time depends on x
    signals = [
        Signal("x", "input", "measured state", initial_state, 0, follows_inputs=tube_waits),
        *([Signal("v", "input", "measured velocity", zeros, 1, follows_inputs=tube_waits)] if task.order == 2 else []),
        Signal("u", "output", "input of the plant, held until the next sample", zeros, task.order, follows_inputs=True),
        Signal("lower", "output", "lower edge of the tube", zeros, 0, follows_inputs=tube_waits),
        Signal("upper", "output", "upper edge of the tube", zeros, 0, follows_inputs=tube_waits),
    ]
    variables = VariableList()
    for signal in signals:
        variables.append_group(signal.letter, *_signal_variables(task, signal))
    margin = "distance to the nearest edge over the width: 0.5 in the middle, 0 at an edge"
    variables.append_group("margin", Variable("margin", "output", margin, follows_inputs=True))
    variables.variables.append(_seconds("t_c", "local", "prescribed time", _double_literal(task.prescribed_time)))
    if proved_period is not None:
        bound = f"between samples, at most ({Property.PERIOD.code})"
        variables.append_group("period_proved", _seconds("period_proved", "local", bound, proved_period))
    status = "0: inside the tube, 1: outside, 2: an input is not finite"
    variables.variables.append(Variable("status", "output", status, is_integer=True, follows_inputs=True))
    if has_phases:
        phase = "entry of the mission that is being served, from 1; 0: done"
        variables.variables.append(Variable("phase", "output", phase, is_integer=True, follows_inputs=tube_waits))
    if proved_period is not None:
        condition = "states were no farther apart than period_proved, and every u was read where its state was set"
        variables.variables.append(Variable("period_kept", "output", condition, is_boolean=True))
    return variables


def _state_members(outside: str, has_proved_period: bool) -> tuple[str, ...]:
    """Return declarations in C of what the unit remembers between steps. outside: the task's control.outside."""
    members = {"hold": ["double kept[2], next[2];"], "stop": ["double kept[1], next[1];"]}.get(outside, [])
    if has_proved_period:
        members.append(
            "double sample_age, input_age, delay; /* seconds since x was set, of the x of the last u, at the reading of u */"
        )
    return tuple(members)


def plant_unit(task: Task, plant: Model) -> Unit:
    """Return the unit of a plant in the task's dimensions. It begins in the task's initial state; order 2: at rest."""
    n, order = task.dimension, task.order
    variables = _plant_variables(task, plant)
    kernel = lower_to_kernel(model(plant, n, order))
    lines = CPrinter(Program("plant", n, "double", (), (kernel,), functions=())).kernel(kernel)
    sizes = {"x": order * n, "p": len(plant.constants), "sample": n if plant.mixing else 0}
    inputs = [f"{array}[{i}]" for array, size in sizes.items() for i in range(size)]
    outputs = [f"&f[{i}]" for i in range(n)] + [f"&g[{i}]" for i in range(n * n)]
    body = template("fmu/plant.c.j2").render(
        name=plant.name, kernel="\n".join(lines), n=n, order=order, first_references=variables.first_references,
        arguments=", ".join([*inputs, *outputs]),
    )  # fmt: skip
    return Unit(
        f"{task.name}_plant",
        f"Plant {plant.name} for {task.name}",
        tuple(variables.variables),
        body=body,
        stop_time=_double_literal(task.prescribed_time),
    )


def _plant_variables(task: Task, plant: Model) -> VariableList:
    """Return the variables of a plant's unit: input, disturbance, state, start, and the plant's constants p1, p2, .."""
    zeros, initial_state = ["0.0"] * task.dimension, [_double_literal(v) for v in task.initial_state]
    states = [("x", "state", initial_state, 0), *([("v", "velocity", zeros, 1)] if task.order == 2 else [])]
    variables = VariableList()
    variables.append_group(
        "u", *_signal_variables(task, Signal("u", "input", "input, held between two steps", zeros, task.order))
    )
    variables.append_group(
        "w", *_signal_variables(task, Signal("w", "input", "disturbance, held between two steps", zeros, task.order))
    )
    for letter, description, initial_values, rate_order in states:
        variables.append_group(
            letter, *_signal_variables(task, Signal(letter, "output", description, initial_values, rate_order))
        )
    for letter, _, initial_values, rate_order in states:
        start = Signal(f"{letter}_start", "parameter", "at the start", initial_values, rate_order, start_of=letter)
        variables.append_group("start", *_signal_variables(task, start))
    constants = [
        Variable(f"p{k + 1}", "parameter", f"a constant of the plant, from {a:g} to {b:g}", repr((a + b) / 2))
        for k, (a, b) in enumerate(plant.constants)
    ]
    variables.append_group("p", *constants)
    return variables


# ------------------------------------------------------------------------------------------------ how they are packed


def pack(unit: Unit, version: int) -> bytes:
    """Return the unit's archive for FMI `version`. The same sources, compiler and machine give the same bytes.

    It has a binary on 64-bit x86 Linux alone, else only sources.
    """
    interface = f"{unit.name}_fmi{version}.c"  # no file of a controller can have this name
    not_offered = NOT_OFFERED_2 if version == 2 else NOT_OFFERED_3
    if unit.checks_steps:
        not_offered = [name for name in not_offered if name != "GetBoolean"]
    words = {
        "name": unit.name, "version": version, "token": unit.token, "state_members": unit.state_members, "body": unit.body,
        "numbers": [v for v in unit.variables if not v.is_integer and not v.is_boolean],
        "wholes": [v for v in unit.variables if v.is_integer], "flags": [v for v in unit.variables if v.is_boolean],
        "includes": f'#include "{unit.header}"\n' if unit.header else "",
        "not_offered": not_offered,
    }  # fmt: skip
    sources = {interface: template("fmu/unit.c.j2").render(**words).encode()} | unit.sources
    compiled = [name for name in sources if name.endswith(".c")]
    description = (describe_fmi_2 if version == 2 else describe_fmi_3)(unit, compiled)
    files = {"modelDescription.xml": to_xml(description)}
    files |= {f"sources/{name}": data for name, data in sources.items()}
    if version == 3:
        files["sources/buildDescription.xml"] = to_xml(describe_build(unit, compiled))
    files |= {f"resources/{name}": data for name, data in unit.extras.items()}
    if sys.platform == "linux" and platform.machine() == "x86_64":
        folder = "binaries/x86_64-linux" if version == 3 else "binaries/linux64"
        files[f"{folder}/{unit.name}.so"] = _binary(unit.name, version, sources, compiled)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:
        for name, data in sorted(files.items()):
            archive.writestr(zipfile.ZipInfo(name, ARCHIVE_DATE), data)
    return out.getvalue()


def _binary(name: str, version: int, sources: Files, compiled: Sequence[str]) -> bytes:
    """Compile a shared library that exports the standard's functions alone, so that two units in one process never mix.

    The linker refuses undefined names here (-z defs), so that loading the unit cannot fail because of one.
    """
    with tempfile.TemporaryDirectory() as folder:
        for file, data in sources.items():
            Path(folder, file).write_bytes(data)
        library, exported_names = Path(folder, f"{name}.so"), Path(folder, "exported.map")
        exported_names.write_text(f"{{ global: fmi{version}*; local: *; }};\n")
        flags = [f for f in STRICT if f not in ("-Wcast-qual", "-Wconversion", "-Wsign-conversion")]
        files = [str(Path(folder, file)) for file in compiled]
        flags += ["-s", f"-ffile-prefix-map={folder}=.", "-shared", "-fPIC", "-Wno-unused-parameter"]
        flags.append(f"-Wl,--version-script={exported_names},-z,defs")
        run_compiler([find_compiler(), *flags, "-o", str(library), *files, "-lm"])
        return library.read_bytes()
