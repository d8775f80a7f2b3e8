"""What a unit of co-simulation has, and how FMI 3.0 and 2.0 describe that."""

from __future__ import annotations

import hashlib
import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field

from stt_codegen.emit import Files

BASE = {
    "s": {"s": "1"},
    "m": {"m": "1"},
    "rad": {"rad": "1"},
    "deg": {"rad": "1", "factor": repr(math.pi / 180)},
}  # of these units


@dataclass(frozen=True)
class Variable:
    """One number of a unit. causality: independent, input, output, parameter or local (a constant); begin: its literal in C
    before the first step; whole: an int32; truth: a boolean, true at the start."""

    name: str
    causality: str
    description: str
    begin: str = "0.0"
    unit: str = ""
    _: KW_ONLY
    whole: bool = False
    truth: bool = field(default=False, repr=False)  # tokens of units without one stay
    base: str = ""  # the task's unit that `unit` is, over seconds to the power `order`
    order: int = 0
    direct: bool = False  # an output that follows the inputs at once
    of: str = ""  # the output that a parameter is the start of

    @property
    def settable(self) -> int:
        """When an importer may set it: 0 never, 1 at any time, 2 before the first step alone."""
        return {"input": 1, "parameter": 2}.get(self.causality, 0)


@dataclass(frozen=True)
class Unit:
    """A unit before it is packed. variables: in the order of their references. body: the C of `unit_start`, `unit_evaluate` and
    `unit_advance`; header: what this includes; sources: more C files; kept: members of its state. stop, step: seconds that an
    importer may take, literals. extras: more files, for people."""

    name: str
    description: str
    variables: tuple[Variable, ...]
    body: str
    stop: str
    _: KW_ONLY
    header: str = ""
    sources: Files = field(default_factory=dict)
    kept: tuple[str, ...] = ()
    step: str = ""
    extras: Files = field(default_factory=dict)

    @property
    def watched(self) -> bool:
        """Whether it looks at how the importer steps, and warns in its log."""
        return any(v.truth for v in self.variables)

    @property
    def token(self) -> str:
        """Of all that decides what the unit does, so that an importer takes no other unit for it."""
        told = hashlib.sha256(repr((self.variables, self.body, sorted(self.sources.items()))).encode()).hexdigest()
        return f"{self.name}-{told[:16]}"


def text(root: ET.Element) -> bytes:
    ET.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root) + b"\n"


def _units(root: ET.Element, unit: Unit) -> None:
    """What units are in SI, of those that are known."""
    definitions = ET.SubElement(root, "UnitDefinitions")
    named = {v.unit: v for v in sorted(unit.variables, key=lambda v: v.base in BASE) if v.unit}  # what is known comes last
    for name, v in sorted(named.items()):
        own = ET.SubElement(definitions, "Unit", name=name)
        if v.base in BASE:
            seconds = int(BASE[v.base].get("s", 0)) - v.order
            ET.SubElement(own, "BaseUnit", BASE[v.base] | {"s": str(seconds)})


def _log_categories(root: ET.Element, unit: Unit) -> None:
    """The one category of what it writes to the importer's log."""
    if unit.watched:
        ET.SubElement(ET.SubElement(root, "LogCategories"), "Category", name="logStatusWarning")


def _attributes(v: Variable, reference: int) -> dict[str, str]:
    found = {"name": v.name, "valueReference": str(reference), "causality": v.causality, "description": v.description}
    found["variability"] = {"parameter": "fixed", "local": "constant"}.get(
        v.causality, "discrete" if v.whole or v.truth else "continuous"
    )
    if v.causality == "output":
        found["initial"] = "calculated"
    return found


def description_3(unit: Unit, _compiled: Sequence[str]) -> ET.Element:
    root = ET.Element(
        "fmiModelDescription", fmiVersion="3.0", modelName=unit.name, instantiationToken=unit.token, description=unit.description,
        generationTool="stt_codegen", variableNamingConvention="structured",
    )  # fmt: skip
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=unit.name,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUState="true",
    )
    _units(root, unit)
    _log_categories(root, unit)
    ET.SubElement(root, "DefaultExperiment", _experiment(unit))
    variables = ET.SubElement(root, "ModelVariables")
    for k, v in enumerate(_ordered(unit)):
        given = _attributes(v, k)
        if v.settable or v.causality == "local":
            given["start"] = v.begin
        if v.unit:
            given["unit"] = v.unit
        ET.SubElement(variables, "Boolean" if v.truth else "Int32" if v.whole else "Float64", given)
    structure = ET.SubElement(root, "ModelStructure")
    for tag, initial in (("Output", False), ("InitialUnknown", True)):
        for k, known in _dependencies(unit, initial):
            ET.SubElement(structure, tag, {"valueReference": str(k)} | _known(known))
    return root


def description_2(unit: Unit, compiled: Sequence[str]) -> ET.Element:
    root = ET.Element(
        "fmiModelDescription", fmiVersion="2.0", modelName=unit.name, guid=unit.token, description=unit.description,
        generationTool="stt_codegen", variableNamingConvention="structured", numberOfEventIndicators="0",
    )  # fmt: skip
    own = ET.SubElement(
        root, "CoSimulation", modelIdentifier=unit.name, canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true", canNotUseMemoryManagementFunctions="true",
    )  # fmt: skip
    files = ET.SubElement(own, "SourceFiles")
    for name in compiled:
        ET.SubElement(files, "File", name=name)
    _units(root, unit)
    _log_categories(root, unit)
    ET.SubElement(root, "DefaultExperiment", _experiment(unit))
    variables = ET.SubElement(root, "ModelVariables")
    for k, v in enumerate(_ordered(unit)):
        number = ET.SubElement(variables, "ScalarVariable", _attributes(v, k))
        given = {"start": v.begin} if v.settable or v.causality == "local" else {}
        if v.unit:
            given["unit"] = v.unit
        ET.SubElement(number, "Boolean" if v.truth else "Integer" if v.whole else "Real", given)
    structure = ET.SubElement(root, "ModelStructure")
    for tag, initial in (("Outputs", False), ("InitialUnknowns", True)):
        table = ET.SubElement(structure, tag)
        for k, known in _dependencies(unit, initial):  # counted from 1
            ET.SubElement(table, "Unknown", {"index": str(k + 1)} | _known([j + 1 for j in known]))
    return root


def _ordered(unit: Unit) -> list[Variable]:
    """By value reference."""
    return sorted(unit.variables, key=lambda v: (v.truth, v.whole))


def _dependencies(unit: Unit, initial: bool) -> list[tuple[int, list[int]]]:
    """What every output is made of, beside the time: of a controller all inputs, since one that is not finite stops all of u, but
    the tube's edges none, unless the tube waits; of a plant its own start at the start, and later nothing that comes in."""
    ordered = _ordered(unit)
    inputs = [k for k, v in enumerate(ordered) if v.causality == "input"]
    starts = {v.of: [k] for k, v in enumerate(ordered) if v.of}
    return [
        (k, inputs if v.direct else starts.get(v.name, []) if initial else [])
        for k, v in enumerate(ordered)
        if v.causality == "output"
    ]


def _known(known: Sequence[int]) -> dict[str, str]:
    dependent = {"dependenciesKind": " ".join(["dependent"] * len(known))} if known else {}
    return {"dependencies": " ".join(map(str, known))} | dependent


def _experiment(unit: Unit) -> dict[str, str]:
    return {"startTime": "0", "stopTime": unit.stop} | ({"stepSize": unit.step} if unit.step else {})


def build_description(unit: Unit, compiled: Sequence[str]) -> ET.Element:
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    own = ET.SubElement(root, "BuildConfiguration", modelIdentifier=unit.name)
    files = ET.SubElement(own, "SourceFileSet", language="C99", compilerOptions="-ffp-contract=off")
    for name in compiled:
        ET.SubElement(files, "SourceFile", name=name)
    ET.SubElement(own, "Library", name="m", external="true")
    return root
