"""A constructor that takes more than five values takes them by name, as nobody notices two exchanged numbers in a long call."""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest

from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
POSITIONAL_LIMIT = 5

# Arguments of a lemma are in reading order: name, words, formula, assumptions, source, proof. No class may be added.
POSITIONAL = """
    lemmas/lemma.py:Lemma
"""


def count_positional(node: ast.ClassDef) -> int:
    """Return how many values the constructor of a class, by its fields or its `__init__`, takes by position."""
    initializer = next((f for f in node.body if isinstance(f, ast.FunctionDef) and f.name == "__init__"), None)
    if initializer is not None:
        return len(initializer.args.posonlyargs) + len(initializer.args.args) - 1
    decorators = " ".join(ast.unparse(d) for d in node.decorator_list)
    named_tuple = any(ast.unparse(base).endswith("NamedTuple") for base in node.bases)
    if "kw_only=True" in decorators or not ("dataclass" in decorators or named_tuple):
        return 0
    count = 0
    for statement in node.body:
        kind = ast.unparse(statement.annotation) if isinstance(statement, ast.AnnAssign) else "ClassVar"
        if kind.endswith("KW_ONLY"):
            break
        count += not kind.startswith("ClassVar")
    return count


def classes_with_many_positional(texts: dict[str, str]) -> Iterator[str]:
    """Yield file and name of every class whose constructor takes too many values by position."""
    for name, text in texts.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ClassDef) and count_positional(node) > POSITIONAL_LIMIT:
                yield f"{name}:{node.name}"


def sources() -> dict[str, str]:
    """Return texts of the package by path, without the stand-alone checker, which has its own rules."""
    paths = (path.relative_to(PACKAGE) for path in sorted(PACKAGE.rglob("*.py")))
    return {str(path): (PACKAGE / path).read_text() for path in paths if "checker" not in path.with_suffix("").parts}


def test_constructors_with_many_values_take_them_by_name() -> None:
    classes = set(classes_with_many_positional(sources()))
    assert classes - set(POSITIONAL.split()) == set(), "make its fields keyword-only: @dataclass(frozen=True, kw_only=True)"
    assert set(POSITIONAL.split()) - classes == set(), "take it off the list"


SIX = "; ".join(f"f{k}: int" for k in range(6))


@pytest.mark.parametrize(
    ("text", "is_reported"),
    [
        (f"@dataclass\nclass A: {SIX}", True),
        (f"@dataclass(frozen=True)\nclass A: {SIX}", True),
        (f"class A(NamedTuple): {SIX}", True),
        ("class A:\n    def __init__(self, a, b, c, d, e, f): ...", True),
        ("class A:\n    def __init__(self, a, b, /, c, d, e, f): ...", True),
        (f"@dataclass(frozen=True, kw_only=True)\nclass A: {SIX}", False),
        ("@dataclass\nclass A: a: int; _: KW_ONLY; b: int; c: int; d: int; e: int; f: int; g: int", False),
        ("@dataclass\nclass A: a: int; b: int; c: int; d: int; e: int; f: ClassVar[int] = 1", False),
        ("class A:\n    def __init__(self, a, *, b, c, d, e, f): ...", False),
    ],
)
def test_a_long_constructor_is_reported(text: str, is_reported: bool) -> None:
    assert bool(list(classes_with_many_positional({"a.py": text}))) == is_reported
