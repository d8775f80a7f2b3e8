"""Names in backticks and names of files, in docstrings and comments, exist: a rename that forgets the prose is seen."""

from __future__ import annotations

import ast
import io
import re
import subprocess
import tokenize
from collections.abc import Iterator
from functools import cache

from tests.support.controllers import ROOT

CODE = ("stt_codegen", "tests", "benchmarks")
# Files that a user has, or that a command writes; and the starts and ends of names that stand for several.
EXAMPLE_FILES = frozenset(
    "cart.py TASK.toml cart.toml task.toml b.md FILE.md SOURCES.md tasks/TASK.toml _comparison.py _frame.py _theorem.py".split()
)
EXAMPLE_NAMES = frozenset("name0 name1 checker.pyz".split())
FILE = re.compile(r"(?<![\w<>{}./-])((?:[\w-]+/)*[\w-]+\.(?:py|v\.j2|v|md|toml)\b)(?!\.j2)")
NAME = re.compile(r"`([A-Za-z_]\w*(?:\.\w+)*)`")


@cache
def repository_files() -> tuple[str, ...]:
    """Return the paths of all files; where the tree has no git, those of its folders."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()
    folders = (*CODE, "templates", "tasks", "proof", "docs", "generated", "locks", ".ci")
    paths = [p for folder in folders for p in (ROOT / folder).rglob("*")] + [*ROOT.glob("*")]
    return tuple(listed or (str(p.relative_to(ROOT)) for p in paths if p.is_file()))


def prose_of(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of every docstring and comment of Python."""
    for node in docstrings(ast.parse(text)):
        yield node.lineno, str(node.value)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def docstrings(tree: ast.AST) -> Iterator[ast.Constant]:
    for node in ast.walk(tree):
        match node:
            case ast.Module(body=[first, *_]) | ast.ClassDef(body=[first, *_]) | ast.FunctionDef(body=[first, *_]):
                match first:
                    case ast.Expr(value=ast.Constant(value=str()) as docstring):
                        yield docstring


def words_of(text: str) -> Iterator[str]:
    """Yield the names of a Python file, and the words of its strings, but not those of its docstrings and comments."""
    tree = ast.parse(text)
    prose = {id(node) for node in docstrings(tree)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in prose:
            yield from re.findall(r"\w+", node.value)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.NAME:
            yield token.string


@cache
def known_words() -> frozenset[str]:
    """Return all names and words of the code, the templates, the tasks and the proofs."""
    words = set[str](EXAMPLE_NAMES)
    for file in repository_files():
        folder = file.split("/")[0]
        if folder in CODE and file.endswith(".py"):
            words.update(words_of((ROOT / file).read_text()))
        elif folder in ("templates", "tasks", "proof") or file.endswith((".j2", ".toml", "Makefile")):
            words.update(re.findall(r"\w+", (ROOT / file).read_text(errors="replace")))
    return frozenset(words)


def missing_references(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and name of what the prose of a Python file refers to and nothing has."""
    files = repository_files()
    for line, prose in prose_of(text):
        for name in NAME.findall(prose):
            if not set(name.split(".")) <= known_words() and name not in EXAMPLE_FILES and name not in files:
                yield line, name
        for name in FILE.findall(prose):
            if name not in EXAMPLE_FILES and not any(file == name or file.endswith(f"/{name}") for file in files):
                yield line, name


def test_prose_refers_to_what_exists() -> None:
    paths = [file for file in repository_files() if file.split("/")[0] in CODE and file.endswith(".py")]
    assert [(path, *reference) for path in paths for reference in missing_references((ROOT / path).read_text())] == []


def test_a_wrong_reference_is_found() -> None:
    function, file, field = (
        f"no_{kind}_of_this_name" for kind in ("function", "file", "field")
    )  # put together: no word of this file
    text = f'"""Calls `{function}` of program/{file}.py, and `missing_references` of tests/test_references.py."""\n# `Task.{field}`\n'
    assert [name for _, name in missing_references(text)] == [function, f"program/{file}.py", f"Task.{field}"]
