"""A constructor that takes more than five values takes them by name: two exchanged numbers in a row are seen by nobody."""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest

from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
MOST_POSITIONAL = 5

# A lemma is written as it is read: name, words, formula, assumptions, source, proof. No class is added.
POSITIONAL = """
    lemmas/lemma.py:Lemma
"""


def positional(node: ast.ClassDef) -> int:
    """How many values the constructor of a class takes without their names, of its own fields or of its `__init__`."""
    written = next((f for f in node.body if isinstance(f, ast.FunctionDef) and f.name == "__init__"), None)
    if written is not None:
        return len(written.args.posonlyargs) + len(written.args.args) - 1
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


def with_many(texts: dict[str, str]) -> Iterator[str]:
    for name, text in texts.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ClassDef) and positional(node) > MOST_POSITIONAL:
                yield f"{name}:{node.name}"


def sources() -> dict[str, str]:
    """The package; the stand-alone checker shares nothing with it, and so not its rules."""
    paths = (path.relative_to(PACKAGE) for path in sorted(PACKAGE.rglob("*.py")))
    return {str(path): (PACKAGE / path).read_text() for path in paths if "checker" not in path.with_suffix("").parts}


def test_many_values_are_given_by_name() -> None:
    found = set(with_many(sources()))
    assert found - set(POSITIONAL.split()) == set(), "make its fields keyword-only: @dataclass(frozen=True, kw_only=True)"
    assert set(POSITIONAL.split()) - found == set(), "take it off the list"


SIX = "; ".join(f"f{k}: int" for k in range(6))


@pytest.mark.parametrize(
    ("text", "is_seen"),
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
def test_a_long_constructor_is_seen(text: str, is_seen: bool) -> None:
    assert bool(list(with_many({"a.py": text}))) == is_seen
