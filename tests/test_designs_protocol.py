"""A design answers for itself: outside of designs/ nobody asks of which class it is or compares the name of its kind.

What must differ by kind stands in tables whose keys are kinds. A fourth kind is a row of design_kinds.py, a class in designs/ and one
entry in each of TABLES; these tests name what is missing.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from typing import get_args

import numpy as np
import pytest

from stt_codegen.design_kinds import CAPABILITIES, Capabilities, DesignKind
from stt_codegen.designs import Design, require_adaptive, require_refined
from stt_codegen.pipeline import design_tube
from stt_codegen.task import load_task
from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
KINDS = set(get_args(DesignKind))
CLASSES = {
    node.name
    for path in (PACKAGE / "designs").glob("*.py")
    for node in ast.parse(path.read_text()).body
    if isinstance(node, ast.ClassDef) and node.name.endswith("Design")
}
REQUIRE = {
    node.name
    for path in (PACKAGE / "designs").glob("*.py")
    for node in ast.parse(path.read_text()).body
    if isinstance(node, ast.FunctionDef) and node.name.startswith("require_")
}
MAY_ASK = {"certify/checker.py": "it imports nothing of the package and reads the name in a certificate"}

# What differs by kind, each in one place. `Stages`: how a tube is designed, programmed and certified.
TABLES = {
    "compare/comparison.py: BY_KIND",
    "design_kinds.py: CAPABILITIES",
    "emit/document.py: BODIES",
    "lemmas/emitted/functions.py: FORMULAS",
    "pipeline.py: STAGES",
    "report/analysis.py: READINGS",
}


def constants_in(*nodes: ast.AST) -> set[object]:
    return {n.value for node in nodes for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)}


def names_in(node: ast.AST) -> set[str]:
    names = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
    return names | {n.attr for n in ast.walk(node) if isinstance(n, ast.Attribute)}


def is_a_design(node: ast.AST) -> bool:
    return (isinstance(node, ast.Name) and node.id == "design") or (isinstance(node, ast.Attribute) and node.attr == "design")


def questions(text: str) -> Iterator[tuple[int, str]]:
    """Lines that ask of which kind a design is, and how: of its class, its name, or what attributes it has."""
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Call(func=ast.Name(id="isinstance" | "issubclass"), args=[_, classes]) if names_in(classes) & CLASSES:
                yield node.lineno, "asks of its class"
            case ast.Call(func=ast.Name(id="hasattr" | "getattr"), args=[subject, *_]) if is_a_design(subject):
                yield node.lineno, "asks what attributes it has"
            case ast.Compare() if constants_in(node.left, *node.comparators) & KINDS:
                yield node.lineno, "compares the name of a kind"
            case ast.Compare(ops=[ast.Is() | ast.IsNot() | ast.Eq() | ast.NotEq()]) if names_in(node) & CLASSES:
                yield node.lineno, "compares its class"
            case ast.MatchClass(cls=cls) if names_in(cls) & CLASSES:
                yield node.lineno, "matches its class"
            case ast.MatchValue(value=value) if constants_in(value) & KINDS:
                yield node.lineno, "matches the name of a kind"
            case ast.Try(body=body) if any(names_in(statement) & REQUIRE for statement in body):
                yield node.lineno, "asks by an exception"
            case ast.Subscript(value=ast.Dict(keys=keys)) if constants_in(*filter(None, keys)) & KINDS:
                yield node.lineno, "looks the name of a kind up"
            case ast.Call(func=ast.Attribute(value=ast.Dict(keys=keys))) if constants_in(*filter(None, keys)) & KINDS:
                yield node.lineno, "looks the name of a kind up"


def sources() -> dict[str, str]:
    return {str(path.relative_to(PACKAGE)): path.read_text() for path in sorted(PACKAGE.rglob("*.py"))}


def test_nobody_asks_of_which_kind_a_design_is() -> None:
    assert {"RefinedDesign", "AdaptiveDesign"} <= CLASSES
    asked = {
        name: list(questions(text))
        for name, text in sources().items()
        if not name.startswith("designs/") and any(questions(text))
    }
    assert {name: lines for name, lines in asked.items() if name not in MAY_ASK} == {}
    assert MAY_ASK.keys() - asked.keys() == set(), "take it off the list"


def test_no_template_compares_the_name_of_a_kind() -> None:
    compared = re.compile(r"\b(\w*kind|design)\s*[!=]=\s*[\"'](" + "|".join(sorted(KINDS)) + ")[\"']")
    assert compared.search('{% if kind == "refined" %}')
    assert [p.name for p in (ROOT / "templates").rglob("*.j2") if compared.search(p.read_text())] == []


@pytest.mark.parametrize(
    "text",
    [
        "isinstance(design, RefinedDesign)",
        "isinstance(a.design, (int, designs.AdaptiveDesign))",
        "isinstance(x, RefinedDesign | AdaptiveDesign)",
        'task.tube.design != "refined"',
        '"literal" == kind',
        'design.kind in ("adaptive", "literal")',
        "type(design) is RefinedDesign",
        "match design:\n    case RefinedDesign(): ...",
        'match kind:\n    case "adaptive" | "literal": ...',
        '{"refined": f, "adaptive": g}[design.kind]()',
        '{"refined": f}.get(design.kind, g)',
        'getattr(controller.design, "filter", ())',
        'hasattr(design, "bumps")',
        "try:\n    spline = require_refined(design)\nexcept TypeError: ...",
    ],
)
def test_a_question_of_kind_is_seen(text: str) -> None:
    assert list(questions(text))


# ---------------------------------------------------------------------------------------------------------- tables by kind


def tables(texts: dict[str, str]) -> dict[str, set[object]]:
    """The keys of every table that is annotated to have kinds as keys."""
    return {
        f"{name}: {ast.unparse(node.target)}": constants_in(*filter(None, node.value.keys))
        for name, text in texts.items()
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.AnnAssign)
        and isinstance(node.value, ast.Dict)
        and re.match(r"(Mapping|dict)\[DesignKind,", ast.unparse(node.annotation))
    }


def without_an_entry(texts: dict[str, str], kinds: set[str]) -> list[str]:
    return [f"{table} has no {kind}" for table, keys in sorted(tables(texts).items()) for kind in sorted(kinds - keys)]


def test_every_kind_has_an_entry_in_each_table() -> None:
    assert tables(sources()).keys() == TABLES
    assert without_an_entry(sources(), KINDS) == []
    assert CAPABILITIES.keys() == KINDS


def test_a_fourth_kind_is_told_what_it_lacks() -> None:
    assert without_an_entry(sources(), KINDS | {"periodic"}) == [f"{table} has no periodic" for table in sorted(TABLES)]


# --------------------------------------------------------------------------------------------------------- the protocol


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_design_of_every_kind_answers(kind: DesignKind) -> None:
    """mypy holds the classes to the protocol; here the answers agree with the task and with each other."""
    task = load_task(ROOT / "tasks" / "omni_s2.toml").with_options(kind)
    design: Design = design_tube(task)
    assert design.kind == kind
    assert design.capabilities is CAPABILITIES[kind] is task.tube.capabilities
    assert (design.prescribed_time, design.dimension) == (task.prescribed_time, task.dimension)
    assert design.filter == ()
    assert design.cycle_begin is None
    assert design.parts is None or design.size == f"{design.parts} segments"
    times = np.linspace(0.0, float(task.prescribed_time), 401)
    low, high = design.edges_at(times)
    assert low.shape == high.shape == (len(times), task.dimension)
    for edge, sign, end in ((low, 1, task.start.lower), (high, -1, task.start.upper)):  # inwards, or on it
        assert (sign * (edge[0] - [float(v) for v in end]) >= -1e-6).all()
    assert (low < high).all()


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_design_of_another_kind_is_refused(kind: DesignKind) -> None:
    design = design_tube(load_task(ROOT / "tasks" / "omni_s2.toml").with_options(kind))
    is_spline = kind == "refined"
    accepted, refused = (require_refined, require_adaptive) if is_spline else (require_adaptive, require_refined)
    assert accepted(design) is design
    with pytest.raises(TypeError, match=f"this one is {kind}"):
        refused(design)


def test_a_capability_is_asked_for_by_somebody_and_offered_by_some_kind() -> None:
    """A column in which all rows agree says nothing about kinds."""
    rows = [vars(row) for row in CAPABILITIES.values()]
    assert [name for name in Capabilities.__dataclass_fields__ if len({row[name] for row in rows}) == 1] == []
    read = "\n".join(text for name, text in sources().items() if name != "design_kinds.py")
    assert [name for name in Capabilities.__dataclass_fields__ if not re.search(rf"\.{name}\b", read)] == []


def test_the_kinds_are_listed_once() -> None:
    """Whoever offers a choice of kinds takes it from the one list."""
    listed = [
        name
        for name, text in sources().items()
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Subscript) and ast.unparse(node.value) == "Literal" and constants_in(node.slice) & KINDS
    ]
    assert listed == ["design_kinds.py"]
