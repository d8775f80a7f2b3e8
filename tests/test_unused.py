"""Every member of a class, every name of a module and every statement of proof/ is used, and no two classes have one name."""

from __future__ import annotations

import ast
import functools
import re
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from stt_codegen.theorem.coq import compiled_library
from tests.support.controllers import ROOT
from tests.support.mypy_reads import record_of
from tests.support.mypy_records import reads_of, run_mypy
from tests.support.unused import Module, UseCensus
from tests.support.unused_coq import WORD, unreferenced_names, unused_definitions

CACHE = ROOT / ".mypy_cache"
PACKAGE = sorted((ROOT / "stt_codegen").rglob("*.py"))
SCRIPTS = [*sorted((ROOT / "benchmarks").rglob("*.py")), *sorted((ROOT / "docs").glob("*.py"))]
PUBLIC = ("stt_codegen.api", "stt_codegen.paper")  # the Python interface and the paper's equations are for users

# Members that are used although no source that mypy checks reads them, and their users.
USED_ELSEWHERE = {
    "LoopResult._fields_": "ctypes",
    "LoopSetting._fields_": "ctypes",
    "BezierTube.bezier": "a method that this class borrows",
    "BezierTube.largest_steps": "the windows of a design",
    "TaskNumbers.emitted_u_max": "the law of a task",
    "TaskNumbers.largest_coordinate": "the law of a task",
    "_Console.on_broken_pipe": "rich",
}


def module_of(folder: Path, path: Path) -> Module:
    parts = path.relative_to(folder).with_suffix("").parts
    return Module(
        ".".join(parts[:-1] if parts[-1] == "__init__" else parts),
        path.read_text(),
        reads_of(folder, path),
        is_package=parts[-1] == "__init__",
    )


def names_in_templates(folder: Path) -> Iterator[str]:
    """Yield attributes that templates read of their values."""
    for path in folder.rglob("*.j2"):
        for code in re.findall(r"\{\{.*?\}\}|\{%.*?%\}", path.read_text(), re.S):
            yield from re.findall(r"\.(\w+)", code)


@functools.cache
def use_census() -> UseCensus:
    run_mypy(ROOT)
    result = UseCensus([module_of(ROOT, p) for p in (*PACKAGE, *SCRIPTS)])
    result.members_of_unknown_class |= set(names_in_templates(ROOT / "templates")) | set(names_in_templates(ROOT / "stt_codegen"))
    return result


@pytest.mark.xdist_group("unused")
def test_no_member_is_unused() -> None:
    """Fields, methods and properties are read of a value of their class somewhere in the package, or of a value of unknown class."""
    unused = {
        f"{c.name}.{name}": c.module.name for c, name in use_census().unused_members() if c.module.name.startswith("stt_codegen")
    }
    unused = {name: module for name, module in unused.items() if not module.startswith(PUBLIC)}
    assert {name: module for name, module in unused.items() if name not in USED_ELSEWHERE} == {}
    assert USED_ELSEWHERE.keys() - unused.keys() == set(), "take it off the list"


@pytest.mark.xdist_group("unused")
def test_no_name_is_unused() -> None:
    """Functions, classes and constants are read in another statement of their module, or imported by the package or a benchmark."""
    unused = [f"{m.name}.{name}" for m, name in use_census().unused_names() if m.name.startswith("stt_codegen")]
    entries = (ROOT / "pyproject.toml").read_text()
    assert [name for name in unused if not name.startswith(PUBLIC) and ":".join(name.rsplit(".", 1)) not in entries] == []


# Unused members and all ways to use a member. Unused ones have `dead` in their name, except `Grid.room`, whose name a used field has too.
SAMPLE = {
    "sample/__init__.py": "",
    "sample/face.py": 'from sample.parts import Grid, dead_behind_face\n__all__ = ["Grid", "dead_behind_face"]\n',
    "sample/parts.py": """
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple, Protocol

@dataclass(frozen=True)
class Grid:
    step: int
    room: int = 1
    dead_sum: int = 0

    @property
    def allowance(self) -> int:
        return 32 * self.step

    def dead_wider(self) -> "Grid":
        return replace(self, room=2 * self.room)

    def dead_recursion(self, k: int) -> int:
        return self.dead_recursion(k - 1) if k else 0

@dataclass
class Board:
    room: int
    computed: int
    known: int = 0
    shown: int = 0

    def __post_init__(self) -> None:
        self.dead_stored = self.room
        self.dead_counter = 0

    def count(self) -> None:
        self.dead_counter += 1

class Sided(Protocol):
    def side(self) -> int: ...

class Square:
    def side(self) -> int:
        return 1

    def edge(self) -> int:
        return 2

class Cube(Square):
    def edge(self) -> int:
        return 3

class Fallback:
    def corner(self) -> int:
        return 4

@dataclass(frozen=True)
class Pair:
    first: int
    dead_second: int

@dataclass(frozen=True)
class Row:
    written: int

class Point(NamedTuple):
    x: int
    y: int

def dead_function(k: int) -> int:
    return dead_function(k)

def dead_behind_face() -> None: ...
def registered() -> None: ...

DEAD_CONSTANT, LIVING = 1, 2
""",
    "sample/use.py": """
from typing import Any
from sample import parts
from sample.face import Grid
from sample.parts import LIVING, Board, Cube, Fallback, Pair, Point, Row, Sided, Square
from sample.parts import asdict

def main(grid: Grid, board: Board, sided: Sided, square: Square, unknown: Any, pair: Pair, row: Row, point: Point) -> list[Any]:
    board.count()
    x, y = point
    match pair:
        case Pair(first, _):
            x += first
    more = [getattr(board, name) for name in ("computed", "known")] + [asdict(row), board.shown, Cube(), Fallback(), Grid(1, room=3)]
    parts.registered()
    return [grid.allowance, board.room, sided.side(), square.edge(), unknown.corner(), x, y, LIVING, *more]

main(*[None] * 8)  # type: ignore[arg-type]
""",
}
CONFIGURED = "[tool.mypy]\nstrict = true\nimplicit_reexport = true\nfiles = ['sample']\nplugins = ['{plugin}']\n"


def test_an_unused_member_with_the_name_of_a_used_one_is_reported(tmp_path: Path) -> None:
    """`room` of Grid is stored, passed on and copied; only that of Board is read."""
    for name, text in SAMPLE.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "pyproject.toml").write_text(CONFIGURED.format(plugin=ROOT / "tests" / "support" / "mypy_reads.py"))
    run_mypy(tmp_path)
    sample = UseCensus([module_of(tmp_path, tmp_path / name) for name in SAMPLE])
    members = {f"{c.name}.{name}" for c, name in sample.unused_members()}
    living = {"Grid.room"}
    assert {m for m in members if "dead" not in m} == living
    defined = {f"{c.name}.{name}" for c in sample.classes.values() for name in c.members if "dead" in name}
    assert members - living == defined
    names = {name for _, name in sample.unused_names()}
    assert names == {name for name in sample.modules["sample.parts"].definitions if "dead" in name.lower()}


def test_records_follow_the_sources(tmp_path: Path) -> None:
    """A record is written again when its module changes, and when it is missing although mypy has the module in its cache."""
    source = tmp_path / "sample.py"
    (tmp_path / "pyproject.toml").write_text(
        CONFIGURED.format(plugin=ROOT / "tests" / "support" / "mypy_reads.py").replace("'sample'", "'sample.py'")
    )
    head = "class A:\n    b: int = 1\n    c: int = 2\n\n\ndef f(a: A) -> int:\n"
    source.write_text(f"{head}    return a.b\n")
    run_mypy(tmp_path)
    first = reads_of(tmp_path, source)
    assert first is not None
    assert first[7, 11] == {"sample.A.b"}
    record_of(tmp_path / ".mypy_cache", "sample.py").unlink()
    run_mypy(tmp_path)
    assert reads_of(tmp_path, source) == first
    source.write_text(
        f"{head}    return a.c  # another length: mypy tells two texts of one second and one length apart by nothing\n"
    )
    run_mypy(tmp_path)
    assert (reads_of(tmp_path, source) or {})[7, 11] == {"sample.A.c"}


# --------------------------------------------------------------------------------------------------------- classes


def repeated_classes(sources: list[str]) -> set[str]:
    names = Counter(n.name for text in sources for n in ast.walk(ast.parse(text)) if isinstance(n, ast.ClassDef))
    return {name for name, count in names.items() if count > 1}


def test_no_two_classes_have_one_name() -> None:
    """The stand-alone checker imports nothing of the package, so that it may use the same names."""
    repeated = repeated_classes([p.read_text() for p in PACKAGE if "checker" not in p.relative_to(ROOT).with_suffix("").parts])
    assert repeated == set(), "give the new class another name"


def test_classes_of_one_name_are_reported() -> None:
    assert repeated_classes(["class A: ...\nclass B: ...", "def f():\n    class A: ...", "class C: ..."]) == {"A"}


# ---------------------------------------------------------------------------------------------------------- proof/

# Statements for readers: they show that a definition is right.
FOR_READERS = {"Logarithm.bits_of_double", "Logarithm.bits_of_single", "Semantics.exponent_range", "Sets.clear_shape_of_box"}


def library_texts() -> dict[str, str]:
    listed = (ROOT / "proof" / "_CoqProject").read_text().split()
    return {name: (ROOT / "proof" / name).read_text() for name in listed if name.endswith(".v")}


def written_in_coq() -> list[str]:
    """Return the texts of theorems about controllers: templates, and strings in theorem/."""
    sources = (ast.parse(p.read_text()) for p in PACKAGE if p.parent.name == "theorem")
    strings = (n.value for tree in sources for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, str))
    return [*(p.read_text() for p in (ROOT / "templates").glob("*.v.j2")), *strings]


def test_no_definition_of_the_library_is_unused() -> None:
    unused = {re.sub(r"\.v, line \d+: ", ".", line): line for line in unused_definitions(library_texts(), written_in_coq())}
    assert [line for name, line in unused.items() if name not in FOR_READERS] == []
    assert FOR_READERS - unused.keys() == set(), "take it off the list"


@pytest.mark.slow
@pytest.mark.xdist_group("coq")
def test_no_definition_of_the_compiled_library_is_unused(tool: Callable[[str], str]) -> None:
    """The index of coqc decides, which does not confuse a definition with a bound variable of the same name."""
    tool("coqc")
    outside = {word for text in written_in_coq() for word in WORD.findall(text)}
    unused = unreferenced_names(compiled_library(), [name.removesuffix(".v") for name in library_texts()])
    assert {name for name in unused if name.split(".")[1] not in outside} == FOR_READERS


SMALL = {
    "A.v": """
(* dead_lemma is named (* twice *) alone, and "dead. string" too *)
Section S.
  Variable n : nat. Hypothesis silent : n = n.
  Definition early := 1.
  Lemma dead_lemma : early = early. Proof. exact (eq_refl early). Qed.
  Fixpoint dead_recursion (k : nat) : nat := match k with O => O | S k => dead_recursion k end.
  Record pair := Pair { unnamed : nat; second : nat }.
  Record dead_pair := { third : nat; fourth : nat }.
End S.
Fixpoint even k := match k with O => true | S k => odd k end with odd (k : nat) := match k with O => false | S k => even k end.
""",
    "B.v": """From Stt Require Import A.
Lemma used_in_template : even 2 = true. Proof. intros. split. - reflexivity. Qed.
Definition dead_last := let p := Pair 1 2 in p.(second).
""",
}


def test_an_unused_definition_is_reported() -> None:
    lines = unused_definitions(SMALL, ["Check used_in_template."])
    assert lines == [
        "A.v, line 6: dead_lemma",
        "A.v, line 7: dead_recursion",
        "A.v, line 9: dead_pair",
        "B.v, line 3: dead_last",
    ]
