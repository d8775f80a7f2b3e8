"""Plain words: names are nouns and verbs of the field, sentences have no riddles, functions fit a screen and say what they do.

CONTRIBUTING.md has the rules with examples, docs/glossary.md the words.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator

import pytest

from tests.support.controllers import ROOT
from tests.support.unused_coq import WORD, without_comments

# A name with one of these words says what happened to a value, or how it stands to the reader, and not what the value is.
BANNED_WORDS = frozenset(
    """found told given own made held seen here there asked most least whole anew weighed picked reckoned settled
    seventh ninth tenth""".split()
)
BANNED_ALONE = frozenset(
    "one other others each every place back room calm dear quick".split()
)  # as a whole name; a part of a name may be one
BANNED_IN_PROOFS = frozenset("any both kept laid nobody none once only several shown".split())  # as a whole name in proof/
ALLOWED = frozenset("at_least at_most held_input held_inputs".split())  # terms of the field, as a part of a name or the whole
KEYS_OF_TASKS = {("stt_codegen/task/mission/regions.py", "every")}  # fields that are keys of the task file, which stay

# Of sentences: left the riddle or the synonym, right the word to use.
BANNED_PHRASES = {
    r"\bk(?:eep|eeps|ept|eeping) off\b": "stays clear of, avoids",
    r"\bdoubts?\b": "timing uncertainty",
    r"\b(?:have|has|having|with|its|their|no|whose|the) hours\b": "active interval",
    r"\bto spare\b": "margin",
    r"\bwhat pushes\b": "plant bounds",
    r"\bhow late\b": "sampling period, input delay",
    r"\bat the (?:most|least)\b": "at most, at least, worst case",
    r"\bshown again\b": "computed again by",
    r"\bas it should be\b": "the value that is right",
    r"\bc[ao]me of it\b": "the result",
    r"\bnone that is\b": "no",
    r"\bof these the one\b": "the one of these",
    r"\b(?:is|are|was|were|be) told\b": "is stated, reported, known",
    r"\banew\b": "again",
    r"\breckon": "compute",
}
LONGEST_FUNCTION = 60  # lines
LONGEST_WITHOUT_DOCSTRING = 10  # lines
MOST_POSITIONAL = 5
MOST_RETURNED = 3  # values of a tuple

# Released versions are described in the words of their time.
EXEMPT = ("tests/test_words.py", "docs/glossary.md")


def python_files() -> dict[str, str]:
    """Texts by path of the files that the laws hold for."""
    paths = [path for folder in ("stt_codegen", "tests", "benchmarks") for path in sorted((ROOT / folder).rglob("*.py"))]
    return {name: path.read_text() for path in paths if (name := str(path.relative_to(ROOT))) not in EXEMPT}


def prose_files() -> dict[str, str]:
    paths = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    return {name: path.read_text() for path in paths if (name := str(path.relative_to(ROOT))) not in EXEMPT}


def bound_names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield line and name of everything that the file itself names: variables, parameters, fields, functions, classes."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()) | ast.arg(arg=name):
                yield node.lineno, name
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                if not name.startswith("test_"):  # the name of a test is a sentence
                    yield node.lineno, name
            case ast.ClassDef(name=name):
                yield node.lineno, name
            case ast.ExceptHandler(name=str(name)) | ast.MatchAs(name=str(name)) | ast.MatchStar(name=str(name)):
                yield node.lineno, name


def words_of(name: str) -> list[str]:
    """Return the words of a name in lower case, written with underscores or with capitals."""
    return [word.lower() for word in re.split(r"_+|(?<=[a-z0-9])(?=[A-Z])", name) if word]


def is_banned(name: str) -> bool:
    words = words_of(name)
    rest = "_".join(words)
    for term in ALLOWED:
        rest = re.sub(rf"(?:^|(?<=_)){term}(?:$|(?=_))", "", rest)
    return bool(set(rest.split("_")) & BANNED_WORDS) or (len(words) == 1 and words[0] in BANNED_ALONE)


def sentences(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of every comment and every string of Python, docstrings included."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value


def phrases_in(text: str) -> list[str]:
    """Return what is banned in the text, with what to write."""
    plain = " ".join(text.split())
    return [f'"{hit[0]}": {remedy}' for phrase, remedy in BANNED_PHRASES.items() if (hit := re.search(phrase, plain, re.I))]


def proof_files() -> dict[str, str]:
    """Texts by path of the library of proofs, and of the templates of theorem files."""
    paths = [*sorted((ROOT / "proof").glob("*.v")), *sorted((ROOT / "templates").glob("*.v.j2"))]
    return {str(path.relative_to(ROOT)): path.read_text() for path in paths}


def coq_names(text: str) -> set[str]:
    """Return all names of a Coq text, local ones too, outside of comments, strings and expressions of a template."""
    return set(WORD.findall(without_comments(re.sub(r"\{\{.*?\}\}|\{%.*?%\}", " ", text, flags=re.S))))


def coq_comments(text: str) -> list[str]:
    return re.findall(r"\(\*.*?\*\)", text, re.S)


def is_banned_in_proofs(name: str) -> bool:
    return is_banned(name) or name in BANNED_IN_PROOFS


def functions(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def problems(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[str]:
    """Yield what is wrong with the form of a function."""
    lines = (function.end_lineno or function.lineno) - function.lineno + 1
    if lines > LONGEST_FUNCTION:
        yield f"{lines} lines: make it a list of named steps"
    is_described = ast.get_docstring(function) or function.name.startswith("test_") or function.name == "__init__"  # by its class
    if lines > LONGEST_WITHOUT_DOCSTRING and not is_described:
        yield f"{lines} lines without a docstring: say in a sentence with a verb what it does"
    positional = [a for a in (*function.args.posonlyargs, *function.args.args) if a.arg not in ("self", "cls")]
    is_command = any(
        a.annotation is not None and ast.unparse(a.annotation) == "Json" for a in positional
    )  # its options have names
    if len(positional) > MOST_POSITIONAL and not is_command and not function.name.startswith("test_"):
        yield f"{len(positional)} positional parameters: make them keyword-only, or a dataclass"
    match function.returns:
        case ast.Subscript(value=ast.Name(id="tuple"), slice=ast.Tuple(elts=parts)) if len(parts) > MOST_RETURNED:
            yield f"returns a tuple of {len(parts)}: make it a NamedTuple or a dataclass"


def test_names_say_what_a_value_is() -> None:
    bad = [
        f"{path}:{line}: {name}"
        for path, text in python_files().items()
        for line, name in bound_names(ast.parse(text))
        if is_banned(name) and (path, name) not in KEYS_OF_TASKS
    ]
    assert bad == []


def test_sentences_have_no_riddles() -> None:
    bad = [
        f"{p}:{line}: {hit}" for p, text in python_files().items() for line, part in sentences(text) for hit in phrases_in(part)
    ]
    bad += [f"{path}: {hit}" for path, text in prose_files().items() for hit in phrases_in(text)]
    assert bad == []


def test_functions_can_be_read() -> None:
    bad = [
        f"{path}:{function.lineno}: {function.name}: {problem}"
        for path, text in python_files().items()
        for function in functions(ast.parse(text))
        for problem in problems(function)
    ]
    assert bad == []


def test_names_of_proofs_say_what_a_value_is() -> None:
    """Lemmas, definitions, fields, variables and hypotheses, and what a proof names on its way."""
    assert [
        f"{path}: {n}" for path, text in proof_files().items() for n in sorted(coq_names(text)) if is_banned_in_proofs(n)
    ] == []


def test_comments_of_proofs_have_no_riddles() -> None:
    parts = [(path, part) for path, text in proof_files().items() for part in coq_comments(text)]
    assert [f"{path}: {hit}" for path, part in parts for hit in phrases_in(part)] == []
    assert [path for path, text in proof_files().items() if not text.startswith("(* ")] == [], "say what the file shows"


def test_what_is_exempt_exists() -> None:
    assert [entry for entry in EXEMPT if not (ROOT / entry).exists()] == []


def identifiers(pattern: str) -> list[str]:
    """Return the names in a list of parameters or a destructuring pattern, without default values and expressions."""
    return re.findall(r"(?<![\w.\"'])[A-Za-z_]\w*", re.sub(r"=[^,\])}]*", "", pattern))


# Where JavaScript names something: group 1, where there is one, is the name of a function, the last group a pattern of names.
JAVASCRIPT_NAMES = (
    r"\bfunction\s*(\w*)\s*\(([^)]*)\)",
    r"\b(?:const|let|var)\s+([\w$]+|[\[{][^;\n]*?[\]}])(?=\s*[=;,]|\s+of\b|\s+in\b)",
    r"(?:\blet\b|\bconst\b)[^;\n]*?,\s*(\w+)(?=\s*=[^=>])",
    r"\(([^()]*(?:\([^()]*\))?[^()]*)\)\s*=>",
    r"(?<![\w.)])(\w+)\s*=>",
    r"^\s*(?!if\b|for\b|while\b|switch\b|catch\b)(\w+)\(([^)]*)\)\s*\{$",
)
JINJA_NAMES = (
    r"\{%-?\s*set\s+([\w, ]+?)\s*(?:=|-?%\})",
    r"\{%-?\s*for\s+([\w, ()]+?)\s+in\b",
    r"\{%-?\s*macro\s+(\w+)\((.*?)\)\s*-?%\}",
)


def names_by_pattern(text: str, patterns: tuple[str, ...]) -> Iterator[tuple[int, str]]:
    """Yield line and name of everything that a pattern finds in JavaScript or a template, comments aside."""
    plain = re.sub(r"/\*.*?\*/|\{#.*?#\}|(?<![:\"'])//[^\n]*", lambda comment: "\n" * comment[0].count("\n"), text, flags=re.S)
    for pattern in patterns:
        for hit in re.finditer(pattern, plain, re.M):
            line = plain.count("\n", 0, hit.start()) + 1
            yield from ((line, name) for group in hit.groups() for name in identifiers(group or ""))


def template_files() -> dict[str, tuple[str, tuple[str, ...]]]:
    """Text and patterns by path, of every template and of the page's scripts."""
    paths = [path for folder in ("templates", "stt_codegen") for path in sorted((ROOT / folder).rglob("*.j2"))]
    files = {str(path.relative_to(ROOT)): (path.read_text(), JINJA_NAMES) for path in paths}
    scripts = sorted((ROOT / "templates" / "report").glob("*.js"))
    return files | {str(path.relative_to(ROOT)): (path.read_text(), JAVASCRIPT_NAMES) for path in scripts}


def test_names_in_templates_say_what_a_value_is() -> None:
    bad = [
        f"{path}:{line}: {name}"
        for path, (text, patterns) in template_files().items()
        for line, name in names_by_pattern(text, patterns)
        if is_banned(name)
    ]
    assert bad == []


@pytest.mark.parametrize(
    "text",
    [
        "function told() { return 0; }",
        "const found = 1;",
        "let [low, most] = ends;",
        "const { made, edge = 1 } = rows[0];",
        "let left = 48, whole = 2;",
        "for (const one of rows) draw(one);",
        "rows.map((row, least = 3) => row);",
        "rows.map(([given, [low]]) => low);",
        "rows.map(here => 1);",
        "  shape(list, asked) {",
        "{% set x, told = 1, 2 %}",
        "{% for one in rows %}",
        "{% for name, (low, made) in rows %}",
        "{%- macro lines(found, indent=2) -%}",
    ],
)
def test_the_law_of_templates_finds_a_banned_name(text: str) -> None:
    patterns = JINJA_NAMES if text.startswith("{%") else JAVASCRIPT_NAMES
    assert len({name for _, name in names_by_pattern(text, patterns) if is_banned(name)}) == 1
    assert not [
        name for _, name in names_by_pattern(f"/* {text} */" if patterns is JAVASCRIPT_NAMES else f"{{# {text} #}}", patterns)
    ]


@pytest.mark.parametrize(
    ("name", "banned"),
    [
        ("found", True),
        ("_found_tubes", True),
        ("LeastSlack", True),
        ("own_", True),
        ("other", True),
        ("other_axis", False),
        ("at_least", False),
        ("count_at_most", False),
        ("held_input", False),
        ("held", True),
        ("placement", False),
        ("foundation", False),
        ("ROOM", True),
    ],
)
def test_a_name_is_judged_by_its_words(name: str, banned: bool) -> None:
    assert is_banned(name) == banned


def test_the_laws_find_what_they_are_about() -> None:
    text = "def f(a, b, c, d, e, g) -> tuple[int, int, int, int]:\n    '''It keeps off.'''\n    made = 1  # at the most\n    return made\n"
    assert [name for _, name in bound_names(ast.parse(text)) if is_banned(name)] == ["made"]
    assert len([hit for _, part in sentences(text) for hit in phrases_in(part)]) == 2
    (function,) = functions(ast.parse(text))
    assert len(list(problems(function))) == 2
    body = "".join(f"    a{k} = {k}\n" for k in range(61))
    (function,) = functions(ast.parse(f"def f():\n{body}"))
    assert len(list(problems(function))) == 2


def test_the_laws_of_proofs_find_what_they_are_about() -> None:
    text = (
        "(* What came of it: the least (* once more *) *)\nSection Held.\n  Variables others (x_kept held_input : nat).\n"
        '  Record found := Found { most_gains : nat; at_least : nat }. (* "shown" *)\n'
        "  Lemma nobody_is_here : shown = only. Proof. intros given. exact {{ told }}. Qed.\nEnd Held.\n"
    )
    named = "Found Held found given most_gains nobody_is_here only others shown".split()
    assert sorted(name for name in coq_names(text) if is_banned_in_proofs(name)) == named
    assert len([hit for part in coq_comments(text) for hit in phrases_in(part)]) == 1
