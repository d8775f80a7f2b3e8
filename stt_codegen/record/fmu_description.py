"""A unit of co-simulation before it is packed, and its XML descriptions by FMI 3.0 and 2.0. record/fmu.py fills and packs it."""

from __future__ import annotations

import hashlib
import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field

from stt_codegen.emit import Files

# Known units of tasks, as attributes of FMI's element BaseUnit.
SI_BASE_UNITS = {
    "s": {"s": "1"},
    "m": {"m": "1"},
    "rad": {"rad": "1"},
    "deg": {"rad": "1", "factor": repr(math.pi / 180)},
}


@dataclass(frozen=True, repr=False)
class Variable:
    """One variable of a unit: a double unless `is_integer` (int32) or `is_boolean` (true at the start).

    causality: independent, input, output, parameter or local (a constant). initial_value: before the first step, a literal of C.
    base_unit: the task's unit; `unit` is it divided by seconds to the power `rate_order`. start_of: of a parameter, the name of
    the output whose initial value it sets.
    """

    name: str
    causality: str
    description: str
    initial_value: str = "0.0"
    unit: str = ""
    _: KW_ONLY
    is_integer: bool = False
    is_boolean: bool = False
    base_unit: str = ""
    rate_order: int = 0
    follows_inputs: bool = False  # an output that depends on the inputs of the same time
    start_of: str = ""

    def __repr__(self) -> str:
        """Return the text that `Unit.token` hashes. Its names never change, so that an unchanged unit has the same token."""
        texts = (
            f"name={self.name!r}, causality={self.causality!r}, description={self.description!r}, begin={self.initial_value!r}"
        )
        kinds = f"unit={self.unit!r}, whole={self.is_integer!r}, base={self.base_unit!r}, order={self.rate_order!r}"
        return f"Variable({texts}, {kinds}, direct={self.follows_inputs!r}, of={self.start_of!r})"

    @property
    def settable(self) -> int:
        """Return when an importer may set the variable: 0 never, 1 at any time, 2 only before the first step."""
        return {"input": 1, "parameter": 2}.get(self.causality, 0)


@dataclass(frozen=True)
class Unit:
    """A unit before it is packed.

    body: the C of `unit_start`, `unit_evaluate` and `unit_advance`; header: the file that it includes; sources: more C files by
    name; state_members: declarations in C of what the unit remembers. stop_time, step_size: decimals in seconds that are proposed
    to the importer, empty for none. extras: files for people, by name.
    """

    name: str
    description: str
    variables: tuple[Variable, ...]
    body: str
    stop_time: str
    _: KW_ONLY
    header: str = ""
    sources: Files = field(default_factory=dict)
    state_members: tuple[str, ...] = ()
    step_size: str = ""
    extras: Files = field(default_factory=dict)

    @property
    def checks_steps(self) -> bool:
        """Whether the unit checks the times at which the importer steps, and warns in the log."""
        return any(v.is_boolean for v in self.variables)

    @property
    def token(self) -> str:
        """Return the name with a hash of everything that changes what the unit does, by which an importer identifies it."""
        digest = hashlib.sha256(repr((self.variables, self.body, sorted(self.sources.items()))).encode()).hexdigest()
        return f"{self.name}-{digest[:16]}"


def to_xml(root: ET.Element) -> bytes:
    """Return an indented XML file."""
    ET.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root) + b"\n"


def _units(root: ET.Element, unit: Unit) -> None:
    """Add the definitions of the variables' units; known ones are given in SI units."""
    definitions = ET.SubElement(root, "UnitDefinitions")
    by_known_unit = sorted(unit.variables, key=lambda v: v.base_unit in SI_BASE_UNITS)
    examples = {v.unit: v for v in by_known_unit if v.unit}  # one variable of each unit, with a known base unit if there is one
    for name, v in sorted(examples.items()):
        element = ET.SubElement(definitions, "Unit", name=name)
        if v.base_unit in SI_BASE_UNITS:
            seconds = int(SI_BASE_UNITS[v.base_unit].get("s", 0)) - v.rate_order
            ET.SubElement(element, "BaseUnit", SI_BASE_UNITS[v.base_unit] | {"s": str(seconds)})


def _log_categories(root: ET.Element, unit: Unit) -> None:
    """Add the category of the warnings in the importer's log."""
    if unit.checks_steps:
        ET.SubElement(ET.SubElement(root, "LogCategories"), "Category", name="logStatusWarning")


def _variable_attributes(v: Variable, reference: int) -> dict[str, str]:
    """Return the attributes that FMI 2.0 and 3.0 share. reference: the variable's value reference."""
    attributes = {"name": v.name, "valueReference": str(reference), "causality": v.causality, "description": v.description}
    variability = "discrete" if v.is_integer or v.is_boolean else "continuous"
    attributes["variability"] = {"parameter": "fixed", "local": "constant"}.get(v.causality, variability)
    if v.causality == "output":
        attributes["initial"] = "calculated"
    return attributes


def describe_fmi_3(unit: Unit, _compiled: Sequence[str]) -> ET.Element:
    """Return modelDescription.xml of FMI 3.0, which lists C files in a file of its own: `describe_build`."""
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
    ET.SubElement(root, "DefaultExperiment", _default_experiment(unit))
    variables = ET.SubElement(root, "ModelVariables")
    for k, v in enumerate(_by_reference(unit)):
        attributes = _variable_attributes(v, k)
        if v.settable or v.causality == "local":
            attributes["start"] = v.initial_value
        if v.unit:
            attributes["unit"] = v.unit
        ET.SubElement(variables, "Boolean" if v.is_boolean else "Int32" if v.is_integer else "Float64", attributes)
    structure = ET.SubElement(root, "ModelStructure")
    for tag, initial in (("Output", False), ("InitialUnknown", True)):
        for k, references in _dependencies(unit, initial):
            ET.SubElement(structure, tag, {"valueReference": str(k)} | _dependency_attributes(references))
    return root


def describe_fmi_2(unit: Unit, compiled: Sequence[str]) -> ET.Element:
    """Return modelDescription.xml of FMI 2.0. compiled: names of the C files to compile."""
    root = ET.Element(
        "fmiModelDescription", fmiVersion="2.0", modelName=unit.name, guid=unit.token, description=unit.description,
        generationTool="stt_codegen", variableNamingConvention="structured", numberOfEventIndicators="0",
    )  # fmt: skip
    element = ET.SubElement(
        root, "CoSimulation", modelIdentifier=unit.name, canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true", canNotUseMemoryManagementFunctions="true",
    )  # fmt: skip
    files = ET.SubElement(element, "SourceFiles")
    for name in compiled:
        ET.SubElement(files, "File", name=name)
    _units(root, unit)
    _log_categories(root, unit)
    ET.SubElement(root, "DefaultExperiment", _default_experiment(unit))
    variables = ET.SubElement(root, "ModelVariables")
    for k, v in enumerate(_by_reference(unit)):
        number = ET.SubElement(variables, "ScalarVariable", _variable_attributes(v, k))
        attributes = {"start": v.initial_value} if v.settable or v.causality == "local" else {}
        if v.unit:
            attributes["unit"] = v.unit
        ET.SubElement(number, "Boolean" if v.is_boolean else "Integer" if v.is_integer else "Real", attributes)
    structure = ET.SubElement(root, "ModelStructure")
    for tag, initial in (("Outputs", False), ("InitialUnknowns", True)):
        table = ET.SubElement(structure, tag)
        for k, references in _dependencies(unit, initial):  # counted from 1
            ET.SubElement(table, "Unknown", {"index": str(k + 1)} | _dependency_attributes([j + 1 for j in references]))
    return root


def _by_reference(unit: Unit) -> list[Variable]:
    """Return the variables in the order of their value references: doubles, integers, booleans."""
    return sorted(unit.variables, key=lambda v: (v.is_boolean, v.is_integer))


def _dependencies(unit: Unit, initial: bool) -> list[tuple[int, list[int]]]:
    """Return for each output its value reference and those of the variables that it depends on, time aside.

    initial: at the start, where an output of a plant depends on its start value. Outputs of a controller depend on all inputs,
    because one that is not finite stops all of u; edges of a tube depend on none, unless its time waits for the state.
    """
    ordered = _by_reference(unit)
    inputs = [k for k, v in enumerate(ordered) if v.causality == "input"]
    starts = {v.start_of: [k] for k, v in enumerate(ordered) if v.start_of}
    return [
        (k, inputs if v.follows_inputs else starts.get(v.name, []) if initial else [])
        for k, v in enumerate(ordered)
        if v.causality == "output"
    ]


def _dependency_attributes(references: Sequence[int]) -> dict[str, str]:
    kinds = {"dependenciesKind": " ".join(["dependent"] * len(references))} if references else {}
    return {"dependencies": " ".join(map(str, references))} | kinds


def _default_experiment(unit: Unit) -> dict[str, str]:
    return {"startTime": "0", "stopTime": unit.stop_time} | ({"stepSize": unit.step_size} if unit.step_size else {})


def describe_build(unit: Unit, compiled: Sequence[str]) -> ET.Element:
    """Return buildDescription.xml of FMI 3.0: which C files an importer compiles, and how."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    element = ET.SubElement(root, "BuildConfiguration", modelIdentifier=unit.name)
    files = ET.SubElement(element, "SourceFileSet", language="C99", compilerOptions="-ffp-contract=off")
    for name in compiled:
        ET.SubElement(files, "SourceFile", name=name)
    ET.SubElement(element, "Library", name="m", external="true")
    return root
