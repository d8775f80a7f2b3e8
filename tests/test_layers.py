"""The house: imports run one way (pyproject.toml has the order), nothing stands twice, files can be read."""

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
MOST_LINES, SAME = 300, 8


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(p): p for p in SOURCES}


def imports(tree: ast.AST, modules: set[str]) -> Iterator[tuple[str, int]]:
    """Every module of the package that is imported anywhere in the file, with the line."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((a.name, node.lineno) for a in node.names if a.name in modules)
        elif isinstance(node, ast.ImportFrom) and node.module in modules:
            for a in node.names:
                inner = f"{node.module}.{a.name}"
                yield (inner if inner in modules else node.module), node.lineno


def breaches(files: dict[str, ast.AST], layers: list[str]) -> list[str]:
    """Imports against the order of the layers, and cycles between modules, each with the line that does it."""
    found, graph, lines = [], defaultdict(set), {}
    for name, tree in files.items():
        for other, line in imports(tree, set(files)):
            mine, theirs = (m.split(".")[1] if "." in m else None for m in (name, other))
            if theirs is None or mine is None:
                continue
            if mine not in layers:
                found.append(f"{name}: is in no layer; add it to pyproject.toml")
            elif layers.index(theirs) > layers.index(mine):
                found.append(f"{name}, line {line}: imports {other}, which is above it")
            if other != name:
                graph[name].add(other)
                lines[name, other] = line
    done: set[str] = set()

    def visit(name: str, way: tuple[str, ...]) -> None:
        if name in way:
            around = (*way[way.index(name) :], name)
            found.append(f"{name}, line {lines[around[0], around[1]]}: imports in a circle, {' -> '.join(around)}")
        elif name not in done:
            for other in sorted(graph[name]):
                visit(other, (*way, name))
            done.add(name)

    for name in sorted(graph):
        visit(name, ())
    return found


def test_imports_run_one_way() -> None:
    assert breaches({name: ast.parse(path.read_text()) for name, path in MODULES.items()}, LAYERS) == []


@pytest.mark.parametrize(
    ("files", "told"),
    [
        ({"p.task": "", "p.design": "", "p.task.a": "import p.design"}, "p.task.a, line 1: imports p.design, which is above it"),
        ({"p.task": "", "p.task.b": "def f():\n    from p.design import x", "p.design": ""}, "p.task.b, line 2"),
        ({"p.task.a": "from p.task import b", "p.task.b": "from p.task.a import x", "p.task": ""}, "in a circle"),
        ({"p.unknown": "from p.task import x", "p.task": ""}, "p.unknown: is in no layer"),
    ],
)
def test_a_breach_is_named_with_its_line(files: dict[str, str], told: str) -> None:
    found = breaches({name: ast.parse(text) for name, text in files.items()}, ["task", "design"])
    assert any(told in line for line in found)


# ways to a module beside an import statement that always runs
HIDDEN = {"TYPE_CHECKING", "__import__", "import_module", "spec_from_file_location", "run_module", "modules", "pkgutil"}
MODULES_BY_NAME = {"stt_codegen": {"modules"}}  # the interface replaces its class


def hidden_imports(text: str) -> set[str]:
    """Names of what goes round the contract, whether read of a module or imported; relative imports are `.`."""
    tree = ast.parse(text)
    names = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)} | {
        part for n in ast.walk(tree) if isinstance(n, ast.ImportFrom | ast.Import) for a in n.names for part in a.name.split(".")
    }
    names |= {n.attr for n in ast.walk(tree) if isinstance(n, ast.Attribute) and isinstance(n.value, ast.Name)}
    relative = {"." for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.level}
    return names & HIDDEN | relative


def test_no_import_hides_from_the_contract() -> None:
    """Neither TYPE_CHECKING nor a relative import nor importlib goes round it."""
    hidden = {name: hidden_imports(path.read_text()) for name, path in MODULES.items()}
    assert {name: found for name, found in hidden.items() if found} == MODULES_BY_NAME


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
def test_a_hidden_import_is_seen(text: str) -> None:
    assert hidden_imports(text)


# --------------------------------------------------------------------------------------- nothing twice


def code_lines(text: str) -> list[tuple[int, str]]:
    """Lines that say something: no blanks, comments, imports or lone brackets; white space folded."""
    tree = ast.parse(text)
    skipped = {
        line
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    kept = []
    for number, line in enumerate(text.splitlines(), 1):
        said = " ".join(line.split())
        if number not in skipped and re.search(r"\w", said) and not said.startswith("#"):
            kept.append((number, said))
    return kept


def repeated(texts: dict[str, str], same: int = SAME) -> list[str]:
    """Runs of `same` equal lines in two places."""
    seen: dict[tuple[str, ...], tuple[str, int]] = {}
    found = []
    for name, text in texts.items():
        lines = code_lines(text)
        for k in range(len(lines) - same + 1):
            run = tuple(line for _, line in lines[k : k + same])
            place = (name, lines[k][0])
            first = seen.setdefault(run, place)
            if first != place and not (first[0] == name and place[1] - first[1] < same):
                found.append(f"{name}, line {place[1]}: stands at {first[0]}, line {first[1]} too")
    return found


def test_nothing_stands_twice() -> None:
    assert repeated({str(p.relative_to(ROOT)): p.read_text() for p in SOURCES}) == []


def test_what_stands_twice_is_found() -> None:
    body = "\n".join(f"x{k} = {k} + y" for k in range(SAME))
    assert repeated({"a": body, "b": f"import os\n\n# note\n{body}\n"}) == ["b, line 4: stands at a, line 1 too"]
    assert repeated({"a": body, "b": body.replace("x3", "z3")}) == []


def test_long_files_say_why() -> None:
    """Over 300 lines the docstring has a sentence that begins "Long because"."""
    for path in SOURCES:
        text = path.read_text()
        if len(text.splitlines()) > MOST_LINES:
            assert "Long because" in (ast.get_docstring(ast.parse(text)) or ""), path


# ------------------------------------------------------------------------------------------ names in what is written

NAMED = re.compile(r"(?<![\w/.<*])((?:[a-z_0-9]+/)*[a-z_0-9]+\.(?:py|j2|toml))(?![\w])")
OTHERS = {
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
    return {m for m in NAMED.findall(text) if m not in OTHERS}


TOP = "pyproject.toml stt_codegen generated templates tests README.md Makefile tasks benchmarks docs proof CHANGELOG.md CONTRIBUTING.md .ci"
TOP += " .gitignore .github .pre-commit-hooks.yaml locks"


def test_nothing_else_is_at_the_top() -> None:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        pytest.skip("this is no repository")
    assert {line.split("/")[0] for line in listed.stdout.splitlines()} - {*TOP.split()} == set()


def test_no_document_has_a_gap_that_was_to_be_filled() -> None:
    """@@ or a word of capitals stands for what is not known yet, while a page is written."""
    documents = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "benchmarks").glob("*.md"), ROOT / "Makefile"]
    assert len(documents) > 15
    assert [p.name for p in documents if re.search(r"@@|\bTODO\b|\bMINUTES on\b", p.read_text())] == []


def test_files_that_are_named_exist() -> None:
    """In documents, docstrings and comments: a path is one of the repository, of the package, or of a folder beside it."""
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
