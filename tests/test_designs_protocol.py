"""Outside of designs/ no code tests the class of a design or compares the name of its kind.

Where behaviour differs by kind, it is in a table whose keys are kinds. A fourth kind is a row of design_kinds.py, a class in designs/ and one
entry in each of TABLES; these tests name what is missing. tests/recipes follows that recipe with a sample.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from stt_codegen import designs
from stt_codegen.design_kinds import CAPABILITIES, Capabilities, DesignKind
from stt_codegen.designs import Design
from stt_codegen.pipeline import design_tube
from stt_codegen.task import load_task
from tests.support.controllers import ROOT
from tests.support.design_kinds import (
    KINDS,
    READS_OF_A_KIND,
    REQUIRE,
    IsRead,
    Source,
    is_called_a_kind,
    lines_that_compare_kinds,
    lines_that_list_all_kinds,
)
from tests.support.mypy_records import reads_of, run_mypy

PACKAGE = ROOT / "stt_codegen"
# Tables of behaviour by kind. `Stages` has the functions that design, program and certify a tube.
TABLES = {
    "stt_codegen/compare/comparison.py: BY_KIND",
    "stt_codegen/design_kinds.py: CAPABILITIES",
    "stt_codegen/emit/document.py: BODIES",
    "stt_codegen/lemmas/emitted/functions.py: FORMULAS",
    "stt_codegen/pipeline.py: STAGES",
    "stt_codegen/report/loop_analysis.py: READINGS",
    "benchmarks/suites/printed.py: DESIGN_LABELS",
}
# Files outside the tables that write the name of a kind, and its meaning there.
WRITTEN = {
    "certify/__init__.py": "a sub-room",
    "checker/stt_checker/main.py": "the name in a certificate; the checker imports nothing of the package",
    "design/paper_tubes/adaptive_search.py": "the kind that it designs",
    "design/paper_tubes/literal.py": "the kind that it designs",
    "design_kinds.py": "the list",
    "lemmas/book.py": "a module",
    "lemmas/emitted/examples.py": "an example of each class of designs",
    "lemmas/emitted/functions.py": "the example that a lemma is about",
    "report/page/drive.py": "a key of the page's data",
    "task/schema.py": "the default",
}


def sources() -> dict[str, str]:
    return {str(path.relative_to(PACKAGE)): path.read_text() for path in sorted(PACKAGE.rglob("*.py"))}


def source_of(name: str, text: str, is_read: IsRead = is_called_a_kind) -> Source:
    """Return a source of the package, with the tables that it defines and those that it may look a kind up in."""
    defined = {table.split(": ")[1] for table in TABLES if table.startswith(f"stt_codegen/{name}: ")}
    return Source(text, defined, {table.split(": ")[1] for table in TABLES}, is_read)


def recorded(path: Path) -> IsRead:
    """Return the function that says whether mypy recorded an attribute of a source as the name of a kind."""
    reads = reads_of(ROOT, path)
    if reads is None:
        return is_called_a_kind
    return lambda node: any(
        name in READS_OF_A_KIND and name.endswith(f".{node.attr}") for name in reads.get((node.lineno, node.col_offset), ())
    )


def questions(text: str) -> list[tuple[int, str]]:
    """Return line and text of every question of kind in a single source, where `.kind` is always that of a design and BY_KIND a table."""
    return list(Source(text, {"BY_KIND"}, {"BY_KIND"}).questions())


@pytest.mark.xdist_group("unused")
def test_no_source_asks_for_the_kind_of_a_design() -> None:
    run_mypy(ROOT)
    questions_by_file = {
        name: [
            f"line {line}: {question}"
            for line, question in source_of(name, text, recorded(PACKAGE / name)).questions()
            if not (name in WRITTEN and question.startswith("writes"))
        ]
        for name, text in sources().items()
        if not name.startswith("designs/")
    }
    assert {name: lines for name, lines in questions_by_file.items() if lines} == {}


def test_names_of_kinds_are_written_where_the_list_says() -> None:
    writing = {
        name
        for name, text in sources().items()
        if any(question.startswith("writes") for _, question in source_of(name, text).questions())
    }
    assert {name for name in writing if not name.startswith("designs/")} == set(WRITTEN)


def test_mypy_records_where_the_name_of_a_kind_is_read() -> None:
    """Records have the full names that the law looks for, so that a class that moves makes this test fail."""
    run_mypy(ROOT)
    reads = reads_of(ROOT, PACKAGE / "pipeline.py")
    assert reads is not None
    names = set().union(*reads.values())
    assert {"stt_codegen.designs.tube.Design.kind", "stt_codegen.task.schema.TubeOptions.design"} <= names


SCRIPTS = sorted((ROOT / "benchmarks").rglob("*.py"))
TEMPLATES = [
    p for root in ("templates", "stt_codegen") for ending in ("j2", "js") for p in sorted((ROOT / root).rglob(f"*.{ending}"))
]
NAMED = rf"[\"'`](?:{'|'.join(sorted(KINDS))})[\"'`]"
A_KIND = r"(?:(?<![\w.])|\bdesign\.)kind\b"
IN_A_TEMPLATE = re.compile(rf"{NAMED}|{A_KIND}\s*(?:[!=]=|in\b|is\b)|[!=]==?\s*{A_KIND}")


def test_no_template_compares_the_name_of_a_kind() -> None:
    assert {p.name for p in TEMPLATES} > {"page.js", "controller.h.j2", "controller.rs.j2", "page.html.j2"}
    assert [p.name for p in TEMPLATES if IN_A_TEMPLATE.search(p.read_text())] == []


@pytest.mark.parametrize(
    ("text", "is_reported"),
    [
        ('{% if kind == "refined" %}', True),
        ("{% if kind in names %}", True),
        ("{% if names[0] == design.kind %}", True),
        ("if (setting.design === 'literal') {", True),
        ('if (wind.kind === "random") {', False),
        ("{{ kind }} tube", False),
        ("{% if is_stateful %}a literal is a number{% endif %}", False),
    ],
)
def test_a_comparison_in_a_template_is_reported(text: str, is_reported: bool) -> None:
    assert bool(IN_A_TEMPLATE.search(text)) == is_reported


def test_no_benchmark_compares_kinds_or_lists_them() -> None:
    hits = {
        str(p.relative_to(ROOT)): (lines_that_compare_kinds(p.read_text()), lines_that_list_all_kinds(p.read_text()))
        for p in SCRIPTS
    }
    assert {path: lines for path, lines in hits.items() if any(lines)} == {}
    assert lines_that_compare_kinds('job.design == "refined"') == lines_that_compare_kinds('d in ("adaptive", "x")') == [1]
    assert lines_that_list_all_kinds('("literal", "refined", "adaptive")') == [1]


@pytest.mark.parametrize(
    "text",
    [
        "isinstance(design, RefinedDesign)",
        "isinstance(a.design, (int, designs.AdaptiveDesign))",
        "isinstance(x, RefinedDesign | AdaptiveDesign)",
        "from stt_codegen.designs import RefinedDesign as R\nisinstance(design, R)",
        'task.tube.design != "refined"',
        '"literal" == kind',
        'REFINED = "refined"\ndesign.kind == REFINED',
        "design.kind in SPLINES",
        'design.kind.startswith("ref")',
        "len(design.kind) == 7",
        "kind = design.kind",
        "type(design) is RefinedDesign",
        'type(design).__name__ == "RefinedDesign"',
        "design.__class__ in (RefinedDesign, int)",
        "CLASSES = {RefinedDesign: f}",
        "match design:\n    case RefinedDesign(): ...",
        'match kind:\n    case "adaptive" | "literal": ...',
        '{"refined": f, "adaptive": g}[design.kind]()',
        'KINDS = {"refined": f}\nKINDS[design.kind]',
        "dict(refined=1)[design.kind]",
        '{"refined": f}.get(design.kind, g)',
        "BY_KIND.get(design.kind, DEFAULT)",
        "design.kind in BY_KIND",
        'getattr(controller.design, "filter", ())',
        'hasattr(tube, "bumps")',
        "try:\n    spline = require_refined(design)\nexcept TypeError: ...",
        "with suppress(TypeError):\n    require_refined(design)",
        "try:\n    for_any_design(A, f)(task, design)\nexcept TypeError: ...",
        "@singledispatch\ndef f(design: RefinedDesign): ...",
    ],
)
def test_a_question_of_kind_is_reported(text: str) -> None:
    assert questions(text)


@pytest.mark.parametrize(
    "text",
    [
        "BY_KIND[design.kind](task, design)",
        'BY_KIND = {"refined": for_any_design(RefinedDesign, f), "adaptive": g, "literal": g}',
        'BY_KIND: Final[Mapping[DesignKind, int]] = {"refined": 1, "adaptive": 2, "literal": 3}',
        'f"{design.kind} tube"',
        '{"design": design.kind}',
        "tube.kind != task.tube.design",
        "def f(design: RefinedDesign) -> AdaptiveDesign | None: ...",
        "RefinedDesign(t_c, 4, 10, rows)",
        "spline = require_refined(design)",
    ],
)
def test_code_without_a_question_of_kind_passes(text: str) -> None:
    assert questions(text) == []


# ---------------------------------------------------------------------------------------------------------- tables by kind


def lacking(texts: dict[str, str]) -> Iterator[str]:
    """Yield tables that are missing, and kinds that a table has no entry for."""
    for table in sorted(TABLES):
        path, name = table.split(": ")
        kinds = dict(Source(texts[path], {name}, {name}).tables_by_kind()).get(name)
        yield from [f"{table} is missing"] if kinds is None else [f"{table} has no {k}" for k in sorted(KINDS - kinds)]


def test_every_kind_has_an_entry_in_each_table() -> None:
    texts = {path: (ROOT / path).read_text() for path, _ in (table.split(": ") for table in TABLES)}
    assert list(lacking(texts)) == []
    assert CAPABILITIES.keys() == KINDS
    name = "stt_codegen/emit/document.py"
    shorter = texts | {name: texts[name].replace('    "literal": for_any_design(AdaptiveDesign, _decimals),\n', "")}
    assert list(lacking(shorter)) == [f"{name}: BODIES has no literal"]


# --------------------------------------------------------------------------------------------------------- the protocol


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_design_of_every_kind_answers(kind: DesignKind) -> None:
    """mypy checks the classes against the protocol; this test compares their values with the task."""
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
    for edge, sign, end in ((low, 1, task.start.lower), (high, -1, task.start.upper)):  # at the bound, or within it
        assert (sign * (edge[0] - [float(v) for v in end]) >= -1e-6).all()
    assert (low < high).all()


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_design_of_another_class_is_refused(kind: DesignKind) -> None:
    """Each function `require_<kind>` accepts designs of the class that it returns, and no others."""
    design = design_tube(load_task(ROOT / "tasks" / "omni_s2.toml").with_options(kind))
    for name, design_class in REQUIRE.items():
        if isinstance(design, design_class):
            assert getattr(designs, name)(design) is design
        else:
            with pytest.raises(TypeError, match=f"this one is {kind}"):
                getattr(designs, name)(design)


def test_a_capability_is_asked_for_by_somebody_and_offered_by_some_kind() -> None:
    """A capability is useful only if kinds differ in it and some code reads it."""
    rows = [vars(row) for row in CAPABILITIES.values()]
    assert [name for name in Capabilities.__dataclass_fields__ if len({row[name] for row in rows}) == 1] == []
    read = "\n".join(text for name, text in sources().items() if name != "design_kinds.py")
    assert [name for name in Capabilities.__dataclass_fields__ if not re.search(rf"\.{name}\b", read)] == []
