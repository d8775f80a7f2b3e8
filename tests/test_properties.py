"""The ten properties are defined in one file: no other file spells a code, and messages have word and code."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

import pytest

from stt_codegen.certify.certificate import Certificate, Finding
from stt_codegen.properties import OF_THE_EDGES, SECONDS, Property
from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
SPELLED = ("properties.py", "checker/")  # the enum, and the stand-alone checker, which imports nothing of the package
PROSE = "lemmas/"  # statements of the lemma book, whose bytes are emitted
CODE = re.compile(r"(?<![A-Za-z0-9])P(10|[1-9])(?![A-Za-z0-9])")  # an underscore beside it hides nothing
ALONE = re.compile(rf"^{CODE.pattern}$")


def strings(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and value of every string of a source that is no docstring."""
    tree = ast.parse(text)
    bodies = [n.body for n in ast.walk(tree) if isinstance(n, ast.Module | ast.ClassDef | ast.FunctionDef)]
    docstrings = {id(body[0].value) for body in bodies if body and isinstance(body[0], ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node.lineno, node.value


def spelled_codes(path: str, text: str) -> list[str]:
    """Return where a source spells a code as a string, or, outside the prose of the lemma book, within a string."""
    pattern = ALONE if path.startswith(PROSE) else CODE
    spelled = [f"{path}, line {line}: {value}" for line, value in strings(text) if pattern.search(value)]
    return spelled + [f"{path}, line {line}: P and a number put together" for line in composed_codes(text)]


def composed_codes(text: str) -> Iterator[int]:
    """Yield lines of f-strings that put a value right behind the letter P."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.JoinedStr):
            for before, after in pairwise(node.values):
                letter = isinstance(before, ast.Constant) and re.search(r"(?<![A-Za-z0-9])P$", str(before.value))
                if letter and isinstance(after, ast.FormattedValue):
                    yield node.lineno


def test_no_source_spells_a_code() -> None:
    sources = {str(p.relative_to(PACKAGE)): p.read_text() for p in sorted(PACKAGE.rglob("*.py"))}
    assert [v for path, text in sources.items() if not path.startswith(SPELLED) for v in spelled_codes(path, text)] == []


@pytest.mark.parametrize(
    ("path", "text", "count"),
    [
        ("certify/exact.py", 'finding.code == "P9"', 1),
        ("design/arena.py", 'f"P4 avoid: {name}"', 1),
        ("design/arena.py", 'def f():\n    """P4, said of it."""', 0),
        ("lemmas/tube.py", 'Lemma("a", "The rows of P8 are these.")', 0),
        ("lemmas/tube.py", '{"P8": 1}', 1),
        ("report/page.py", '"P11" + "PWM" + "P1x"', 0),
        ("report/page.py", 'f"P{9}"', 1),
        ("report/page.py", 'name = "P9_x"', 1),
        ("report/page.py", 'f"STEP{9} MP{n}"', 0),
    ],
)
def test_a_spelled_code_is_reported(path: str, text: str, count: int) -> None:
    assert len(spelled_codes(path, text)) == count


def test_codes_are_p1_to_p10_and_words_are_the_glossary_s() -> None:
    assert [p.code for p in Property] == [f"P{k}" for k in range(1, 11)]
    words = "width start stay avoid reach smooth arithmetic limits period mission".split()
    assert [p.word for p in Property] == words
    assert Property.PERIOD.label == "period (P9)"
    for p in Property:
        assert p.sentence.endswith(".")
        assert len(p.sentence.split()) >= 5
        assert p.advice
        assert not p.advice.endswith(".")


def test_the_checker_has_the_same_codes() -> None:
    """The checker imports nothing of the package, so that this must be tested."""
    texts = [path.read_text() for path in (PACKAGE / "checker" / "stt_checker").glob("*.py")]
    codes = {code.group() for text in texts for _, value in strings(text) for code in CODE.finditer(value)}
    assert codes == {p.code for p in Property}


def failing(subject: Property, margin: int = -1, required: int = 0, **changes: object) -> Finding:
    return Finding(subject, "a statement", Fraction(margin), Fraction(required), **changes)  # type: ignore[arg-type]


def certificate(*findings: Finding) -> Certificate:
    return Certificate(
        findings=findings,
        edge_error=(Fraction(0),),
        speed=(Fraction(0),),
        minimum_width=Fraction(1),
        start=(),
        covers_initial_set=True,
    )


@pytest.mark.parametrize("subject", Property)
def test_a_refusal_has_word_code_and_advice(subject: Property) -> None:
    """A refusal has the advice of the finding, or by default that of the property. A time has its unit."""
    message = certificate(failing(subject)).refusal()
    if subject is Property.ARITHMETIC:  # it is named only if no other property fails
        message = certificate(failing(subject, 0, 1)).refusal()
    missing = f"1{' s' if subject.unit == SECONDS else ''} is missing"
    statement = certificate(failing(subject)).findings[0].statement
    assert message == f"{subject.label}: not shown: {statement} ({missing}); {subject.advice}"
    assert certificate(failing(subject, 0, 1, advice="do that")).refusal().endswith("; do that")


def test_a_margin_lost_to_rounding_gets_the_advice_of_the_arithmetic() -> None:
    """This holds for properties of the edges that the exact tube has; other properties keep their advice."""
    for subject in Property:
        if subject is Property.ARITHMETIC:
            continue
        failed = certificate(failing(subject, 0, 1), failing(Property.ARITHMETIC, 0, advice="more bits"))
        assert failed.refusal().endswith("; more bits") == (subject in OF_THE_EDGES)
        assert failed.lacks_rounding == (subject in OF_THE_EDGES)


def test_limits_and_period_are_no_part_of_the_tube() -> None:
    for subject in Property:
        assert certificate(failing(subject)).tube_holds == (subject in (Property.LIMITS, Property.PERIOD))
