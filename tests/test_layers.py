"""Imports follow the order of layers in pyproject.toml, no eight lines occur twice, and long files say why they are long."""

from __future__ import annotations

import ast
import re
import subprocess
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
LAYERS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["stt-codegen"]["layers"]
SOURCES = sorted(PACKAGE.rglob("*.py"))
LONGEST_FILE = 300  # lines; a longer file says why
REPEATED_LINES = 8  # as many equal lines in a row may not occur twice


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(p): p for p in SOURCES}


def imports(tree: ast.AST, modules: set[str]) -> Iterator[tuple[str, int]]:
    """Yield every module of the package that is imported anywhere in a file, with the line."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((a.name, node.lineno) for a in node.names if a.name in modules)
        elif isinstance(node, ast.ImportFrom) and node.module in modules:
            for a in node.names:
                inner = f"{node.module}.{a.name}"
                yield (inner if inner in modules else node.module), node.lineno


def breaches(files: dict[str, ast.AST], layers: list[str]) -> list[str]:
    """Return imports against the order of the layers, and cycles between modules, each with its line."""
    problems, graph, lines = [], defaultdict(set), {}
    for name, tree in files.items():
        for imported, line in imports(tree, set(files)):
            layer, imported_layer = (m.split(".")[1] if "." in m else None for m in (name, imported))
            if imported_layer is None or layer is None:
                continue
            if layer not in layers:
                problems.append(f"{name}: is in no layer; add it to pyproject.toml")
            elif layers.index(imported_layer) > layers.index(layer):
                problems.append(f"{name}, line {line}: imports {imported}, which is above it")
            if imported != name:
                graph[name].add(imported)
                lines[name, imported] = line
    visited: set[str] = set()

    def visit(name: str, path: tuple[str, ...]) -> None:
        if name in path:
            cycle = (*path[path.index(name) :], name)
            problems.append(f"{name}, line {lines[cycle[0], cycle[1]]}: imports in a circle, {' -> '.join(cycle)}")
        elif name not in visited:
            for imported in sorted(graph[name]):
                visit(imported, (*path, name))
            visited.add(name)

    for name in sorted(graph):
        visit(name, ())
    return problems


def test_imports_run_one_way() -> None:
    assert breaches({name: ast.parse(path.read_text()) for name, path in MODULES.items()}, LAYERS) == []


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"p.task": "", "p.design": "", "p.task.a": "import p.design"}, "p.task.a, line 1: imports p.design, which is above it"),
        ({"p.task": "", "p.task.b": "def f():\n    from p.design import x", "p.design": ""}, "p.task.b, line 2"),
        ({"p.task.a": "from p.task import b", "p.task.b": "from p.task.a import x", "p.task": ""}, "in a circle"),
        ({"p.unknown": "from p.task import x", "p.task": ""}, "p.unknown: is in no layer"),
    ],
)
def test_a_breach_is_named_with_its_line(files: dict[str, str], message: str) -> None:
    problems = breaches({name: ast.parse(text) for name, text in files.items()}, ["task", "design"])
    assert any(message in line for line in problems)


# Names with which a module can be reached without an import statement that always runs.
HIDDEN = {"TYPE_CHECKING", "__import__", "import_module", "spec_from_file_location", "run_module", "modules", "pkgutil"}
MODULES_BY_NAME = {"stt_codegen": {"modules"}}  # the package replaces the class of its module
STAND_ALONE = "stt_codegen.checker.stt_checker"  # it must run without this package, as a package of another name


def hidden_imports(text: str) -> set[str]:
    """Return names of `HIDDEN` that a file reads or imports, and `.` for a relative import."""
    tree = ast.parse(text)
    names = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)} | {
        part for n in ast.walk(tree) if isinstance(n, ast.ImportFrom | ast.Import) for a in n.names for part in a.name.split(".")
    }
    names |= {n.attr for n in ast.walk(tree) if isinstance(n, ast.Attribute) and isinstance(n.value, ast.Name)}
    relative = {"." for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.level}
    return names & HIDDEN | relative


def test_no_import_is_hidden_from_the_layers() -> None:
    """TYPE_CHECKING, relative imports and importlib would hide an import."""
    hidden = {name: hidden_imports(path.read_text()) for name, path in MODULES.items() if not name.startswith(STAND_ALONE)}
    assert {name: names for name, names in hidden.items() if names} == MODULES_BY_NAME


@pytest.mark.parametrize(
    "text",
    [
        "import typing\nif typing.TYPE_CHECKING: ...",
        "import importlib as i\ni.import_module('a')",
        "from importlib.util import spec_from_file_location",
        "import pkgutil",
        "import sys\nsys.modules['a'].b",
        "__import__('a')",
        "from . import a",
    ],
)
def test_a_hidden_import_is_reported(text: str) -> None:
    assert hidden_imports(text)


# --------------------------------------------------------------------------------------- repeated lines


def code_lines(text: str) -> list[tuple[int, str]]:
    """Return numbers and texts of lines with code: no blanks, comments, imports or lone brackets; white space is folded."""
    tree = ast.parse(text)
    skipped = {
        line
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    lines = []
    for number, line in enumerate(text.splitlines(), 1):
        code = " ".join(line.split())
        if number not in skipped and re.search(r"\w", code) and not code.startswith("#"):
            lines.append((number, code))
    return lines


def repeated(texts: dict[str, str], same: int = REPEATED_LINES) -> list[str]:
    """Return a message for every run of `same` equal lines in two files, or in two parts of a file."""
    first_positions: dict[tuple[str, ...], tuple[str, int]] = {}
    messages = []
    for name, text in texts.items():
        lines = code_lines(text)
        for k in range(len(lines) - same + 1):
            run = tuple(line for _, line in lines[k : k + same])
            position = (name, lines[k][0])
            first = first_positions.setdefault(run, position)
            if first != position and not (first[0] == name and position[1] - first[1] < same):
                messages.append(f"{name}, line {position[1]}: stands at {first[0]}, line {first[1]} too")
    return messages


def test_no_lines_are_repeated() -> None:
    assert repeated({str(p.relative_to(ROOT)): p.read_text() for p in SOURCES}) == []


def test_repeated_lines_are_reported() -> None:
    body = "\n".join(f"x{k} = {k} + y" for k in range(REPEATED_LINES))
    assert repeated({"a": body, "b": f"import os\n\n# note\n{body}\n"}) == ["b, line 4: stands at a, line 1 too"]
    assert repeated({"a": body, "b": body.replace("x3", "z3")}) == []


def test_long_files_say_why() -> None:
    """Over 300 lines the docstring has a sentence that begins "Long because"."""
    for path in SOURCES:
        text = path.read_text()
        if len(text.splitlines()) > LONGEST_FILE:
            assert "Long because" in (ast.get_docstring(ast.parse(text)) or ""), path


# ------------------------------------------------------------------------------------------ names of files in texts

NAMED = re.compile(r"(?<![\w/.<*])((?:[a-z_0-9]+/)*[a-z_0-9]+\.(?:py|j2|toml))(?![\w])")
NAMES_OF_EXAMPLES = {  # of files of users, which are not in the repository
    "controller.py",
    "mine.py",
    "cart.py",
    "task.toml",
    "cart.toml",
    "checker.py",
    "setup.py",
    "hall.yaml",
    "crossing.toml",
    "gantry/extras/gantry.py",
}


def mentioned(text: str) -> set[str]:
    """Return names of files in a text, without those of examples."""
    return {m for m in NAMED.findall(text) if m not in NAMES_OF_EXAMPLES}


TOP = "pyproject.toml stt_codegen generated templates tests README.md Makefile tasks benchmarks docs proof CHANGELOG.md CONTRIBUTING.md .ci"
TOP += " .gitignore .github .pre-commit-hooks.yaml locks"


def test_the_top_folder_has_only_listed_entries() -> None:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        pytest.skip("this is no repository")
    assert {line.split("/")[0] for line in listed.stdout.splitlines()} - {*TOP.split()} == set()


def test_no_document_has_an_unfilled_placeholder() -> None:
    """While a page is written, @@ or a word in capitals stands for a missing value."""
    documents = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "benchmarks").glob("*.md"), ROOT / "Makefile"]
    assert len(documents) > 15
    assert [p.name for p in documents if re.search(r"@@|\bTODO\b|\bMINUTES on\b", p.read_text())] == []


def test_files_that_are_named_exist() -> None:
    """A path in a document, docstring or comment is a file of the repository, or the end of its path."""
    everywhere = [p for p in ROOT.rglob("*") if p.is_file() and ".venv" not in p.parts and ".git" not in p.parts]
    endings = {str(p.relative_to(ROOT)) for p in everywhere}
    written = [
        *ROOT.glob("*.md"),
        *(ROOT / "docs").glob("*.md"),
        *SOURCES,
        *(ROOT / "benchmarks").rglob("*.py"),
        *(ROOT / "templates").rglob("*"),
        ROOT / "Makefile",
    ]
    missing = []
    for path in written:
        if path.is_file() and path.suffix in (".md", ".py", ".j2", ".h", ".c", ""):
            for name in mentioned(path.read_text()):
                if not any(end == name or end.endswith("/" + name) for end in endings):
                    missing.append(f"{path.relative_to(ROOT)}: {name}")
    assert missing == []
