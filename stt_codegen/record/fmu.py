"""Units of co-simulation (FMI 3.0 and 2.0) of a controller and of a plant: sources, a binary of this machine, a description.

An output follows the inputs at once, as in the reference units of the standard: set x, read u, step. So a controller and a plant,
joined elsewhere, exchange what a board and a robot do at a sample.
"""

from __future__ import annotations

import io
import platform
import re
import sys
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

from stt_codegen.design_kinds import kinds_offering
from stt_codegen.emit import Files, cycle_literal, driven_sources, file_names, phase_name, spelled_name
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model, model
from stt_codegen.program import Program, round_to, shortest
from stt_codegen.program.convert import lower
from stt_codegen.program.targets import run_compiler
from stt_codegen.program.targets.c import CPrinter
from stt_codegen.program.targets.c.runner import STRICT, find_compiler
from stt_codegen.program.targets.template_files import template
from stt_codegen.properties import Property
from stt_codegen.record.fmu_description import Unit, Variable, build_description, description_2, description_3, text
from stt_codegen.task import Task

EPOCH = (1980, 1, 1, 0, 0, 0)  # of every file in a unit, so that its bytes say nothing of when
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
    """`<p>.fmu` and `<p>.fmi2.fmu` of a controller, and with a plant `<p>_plant.fmu` and `<p>_plant.fmi2.fmu`. Raises `BadInput`,
    and `MissingTool` without a C compiler."""
    made = [controller_unit(controller)]
    if plant is not None:
        made.append(plant_unit(controller.task, plant))
    return {f"{u.name}{end}": packed(u, version) for u in made for version, end in ((3, ".fmu"), (2, ".fmi2.fmu"))}


# ------------------------------------------------------------------------------------------------ what is in them


def _named(task: Task, letter: str) -> list[str]:
    """x.heading where the task names its dimensions, else x1; also where two names would be the same."""
    words = [re.sub(r"^(?=\d)|[^A-Za-z0-9_]", "_", axis) for axis in task.axes or ()]
    if not words or "" in words or len(set(words)) < len(words):
        return [f"{letter}{i + 1}" for i in range(task.dimension)]
    return [f"{letter}.{word}" for word in words]


def _over_time(unit: str, order: int) -> str:
    """unit, unit/s or unit/s2; a unit that is a quotient stands in brackets."""
    whole = f"({unit})" if "/" in unit and order else unit
    return f"{whole}/s{'' if order == 1 else order}" if unit and order else whole


def _seconds(name: str, causality: str, told: str, begin: str = "0.0") -> Variable:
    return Variable(name, causality, told, begin, "s", base="s")


def controller_unit(controller: EmittedController) -> Unit:
    """The emitted C, t being the importer's time. Raises `BadInput` for what has an alpha or takes a velocity by differences."""
    task, n = controller.task, controller.task.dimension
    if not controller.design.capabilities.runs_in_ros2_and_fmu:
        kinds = kinds_offering("runs_in_ros2_and_fmu")
        raise BadInput(f"--package fmu: is for {kinds} tubes; the {controller.design.kind} one has steps of its own")
    if task.uses_differences:
        raise BadInput("--package fmu: velocity by differences depends on when x is sampled, which no importer says; measure v")
    units, waits = task.units or ("",) * n, task.control.outside == "hold"  # then the tube's time depends on x
    literal = [shortest(round_to(v, "double"), "double") for v in task.initial_state]
    groups = {
        "x": ("input", "measured state", literal, 0),
        **({"v": ("input", "measured velocity", ["0.0"] * n, 1)} if task.order == 2 else {}),
        "u": ("output", "input of the plant, held until the next sample", ["0.0"] * n, task.order),
        "lower": ("output", "lower edge of the tube", ["0.0"] * n, 0),
        "upper": ("output", "upper edge of the tube", ["0.0"] * n, 0),
    }
    variables, places = [_seconds("time", "independent", "since the start")], dict[str, int]()
    for letter, (causality, what, begin, order) in groups.items():
        places[letter] = len(variables)
        variables += [
            Variable(name, causality, what, b, _over_time(u, order), base=u, order=order, direct=letter == "u" or waits)
            for name, b, u in zip(_named(task, letter), begin, units, strict=True)
        ]
    places["margin"] = len(variables)
    told = "distance to the nearest edge over the width: 0.5 in the middle, 0 at an edge"
    variables.append(Variable("margin", "output", told, direct=True))
    t_c = shortest(round_to(task.prescribed_time, "double"), "double")
    variables.append(_seconds("t_c", "local", "prescribed time", t_c))
    proved = controller.certificate.proved_period if controller.certificate.holds else None
    if proved is not None:
        places["period_proved"] = len(variables)
        longest = shortest(round_to(proved.period, "double"), "double")
        variables.append(_seconds("period_proved", "local", f"between samples, at most ({Property.PERIOD.code})", longest))
    variables.append(
        Variable("status", "output", "0: inside the tube, 1: outside, 2: an input is not finite", whole=True, direct=True)
    )
    header, _, _, proof = file_names(task.name)
    phases = phase_name(task.name) in controller.files
    if phases:
        variables.append(
            Variable("phase", "output", "entry of the mission that is being served, from 1; 0: done", whole=True, direct=waits)
        )
    if proved is not None:
        meaning = "states were no farther apart than period_proved, and every u was read where its state was set"
        variables.append(Variable("period_kept", "output", meaning, truth=True))
    kept = {"hold": ["double kept[2], next[2];"], "stop": ["double kept[1], next[1];"]}.get(task.control.outside, [])
    if proved is not None:
        kept.append(
            "double sample_age, input_age, delay; /* seconds since x was set, of the x of the last u, at the reading of u */"
        )
    own = template("fmu/controller.c.j2").render(
        prefix=task.name, macro=task.name.upper(), order=task.order, outside=task.control.outside,
        cycle=cycle_literal(controller.design), phases=phases, places=places, proved=proved is not None,
    )  # fmt: skip
    names = [header, *driven_sources(task), *([phase_name(task.name)] if phases else [])]
    verdict = "certified" if controller.certificate.holds else "NOT CERTIFIED"
    told = f"Prescribed-time reach-avoid-stay controller {task.name}, {controller.design.kind} tube, {verdict}"
    return Unit(
        name=task.name,
        description=told,
        variables=tuple(variables),
        body=own,
        header=header,
        sources={name: controller.files[name] for name in names},
        kept=tuple(kept),
        stop=t_c,
        step="" if task.control.period is None else shortest(round_to(task.control.period, "double"), "double"),
        extras={name: controller.files[name] for name in (proof, spelled_name(task.name)) if name in controller.files},
    )


def plant_unit(task: Task, plant: Model) -> Unit:
    """A plant in the task's dimensions, from the task's initial state; order 2: at rest."""
    n, order, name = task.dimension, task.order, f"{task.name}_plant"
    units = task.units or ("",) * n
    literal = [shortest(round_to(v, "double"), "double") for v in task.initial_state]
    state = [("x", literal, 0), *([("v", ["0.0"] * n, 1)] if order == 2 else [])]
    variables, places = [_seconds("time", "independent", "since the start")], dict[str, int]()

    def add(letter: str, causality: str, what: str, begin: Sequence[str], speed: int, begins: str = "") -> None:
        places.setdefault(begins or letter, len(variables))
        of = _named(task, letter.removesuffix("_start")) if begins else [""] * n
        variables.extend(
            Variable(named, causality, what, b, _over_time(u, speed), base=u, order=speed, of=start_of)
            for named, b, u, start_of in zip(_named(task, letter), begin, units, of, strict=True)
        )

    add("u", "input", "input, held between two steps", ["0.0"] * n, order)
    add("w", "input", "disturbance, held between two steps", ["0.0"] * n, order)
    for letter, begin, speed in state:
        add(letter, "output", "state" if letter == "x" else "velocity", begin, speed)
    for letter, begin, speed in state:
        add(f"{letter}_start", "parameter", "at the start", begin, speed, "start")
    places["p"] = len(variables)
    variables += [
        Variable(f"p{k + 1}", "parameter", f"a constant of the plant, from {a:g} to {b:g}", repr((a + b) / 2))
        for k, (a, b) in enumerate(plant.constants)
    ]
    kernel = lower(model(plant, n, order))
    lines = CPrinter(Program("plant", n, "double", (), (kernel,), functions=())).kernel(kernel)
    sizes = {"x": order * n, "p": len(plant.constants), "sample": n if plant.mixing else 0}
    given = [f"{what}[{i}]" for what, size in sizes.items() for i in range(size)]
    outputs = [f"&f[{i}]" for i in range(n)] + [f"&g[{i}]" for i in range(n * n)]
    own = template("fmu/plant.c.j2").render(
        name=plant.name, kernel="\n".join(lines), n=n, order=order, places=places, arguments=", ".join([*given, *outputs])
    )
    t_c = shortest(round_to(task.prescribed_time, "double"), "double")
    return Unit(name, f"Plant {plant.name} for {task.name}", tuple(variables), body=own, stop=t_c)


# ------------------------------------------------------------------------------------------------ how they are packed


def packed(unit: Unit, version: int) -> bytes:
    """The unit's archive, stored without compression and without dates. Of the same sources, compiler and machine the same bytes;
    on other machines than 64-bit x86 Linux it has sources alone."""
    interface = f"{unit.name}_fmi{version}.c"  # no file of the controller is called so, whatever the task's name
    not_offered = NOT_OFFERED_2 if version == 2 else NOT_OFFERED_3
    if unit.watched:
        not_offered = [name for name in not_offered if name != "GetBoolean"]
    words = {
        "name": unit.name, "version": version, "token": unit.token, "kept": unit.kept, "body": unit.body,
        "numbers": [v for v in unit.variables if not v.whole and not v.truth], "wholes": [v for v in unit.variables if v.whole],
        "flags": [v for v in unit.variables if v.truth],
        "includes": f'#include "{unit.header}"\n' if unit.header else "",
        "not_offered": not_offered,
    }  # fmt: skip
    sources = {interface: template("fmu/unit.c.j2").render(**words).encode()} | unit.sources
    compiled = [name for name in sources if name.endswith(".c")]
    description = (description_2 if version == 2 else description_3)(unit, compiled)
    files = {"modelDescription.xml": text(description)}
    files |= {f"sources/{name}": data for name, data in sources.items()}
    if version == 3:
        files["sources/buildDescription.xml"] = text(build_description(unit, compiled))
    files |= {f"resources/{name}": data for name, data in unit.extras.items()}
    if sys.platform == "linux" and platform.machine() == "x86_64":
        folder = "binaries/x86_64-linux" if version == 3 else "binaries/linux64"
        files[f"{folder}/{unit.name}.so"] = _binary(unit.name, version, sources, compiled)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:
        for name, data in sorted(files.items()):
            archive.writestr(zipfile.ZipInfo(name, EPOCH), data)
    return out.getvalue()


def _binary(name: str, version: int, sources: Files, compiled: Sequence[str]) -> bytes:
    """A shared library with the standard's functions and no other name to be seen: two units in one process, of one task even,
    do not call each other. What it does not define is an error here, not where it is loaded."""
    with tempfile.TemporaryDirectory() as folder:
        for file, data in sources.items():
            Path(folder, file).write_bytes(data)
        made, seen = Path(folder, f"{name}.so"), Path(folder, "exported.map")
        seen.write_text(f"{{ global: fmi{version}*; local: *; }};\n")
        flags = [f for f in STRICT if f not in ("-Wcast-qual", "-Wconversion", "-Wsign-conversion")]
        text = [str(Path(folder, file)) for file in compiled]
        flags += ["-s", f"-ffile-prefix-map={folder}=.", "-shared", "-fPIC", "-Wno-unused-parameter"]
        run_compiler([find_compiler(), *flags, f"-Wl,--version-script={seen},-z,defs", "-o", str(made), *text, "-lm"])
        return made.read_bytes()
