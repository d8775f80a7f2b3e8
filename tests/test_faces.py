"""Rooms and faces: what others import from a room stands in its `__init__.py`, and a room can be held in the head.

A room is a folder of the package. Its face is the `__all__` of its `__init__.py`: names, sub-rooms, and modules that others may look
inside as a whole (the paper's equations, what the lemma book runs, what is heavy to import). Tests and benchmarks look where they like.
"""

from __future__ import annotations

import ast
import functools
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
FILES_OF_A_ROOM = 10  # beside its __init__.py; with more it has sub-rooms
LINES_OF_A_ROOM = 4000  # with its sub-rooms; with more its docstring has a sentence that begins "Large because"


parsed = functools.cache(ast.parse)


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


SOURCES = {module_of(path): path.read_text() for path in sorted(PACKAGE.rglob("*.py"))}
ROOMS = {module_of(path) for path in PACKAGE.rglob("__init__.py")} - {"stt_codegen"}


def face_of(text: str) -> set[str]:
    """Return the names in a room's `__all__`."""
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets):
            return set(ast.literal_eval(node.value))
    return set()


def imported(text: str, modules: set[str]) -> Iterator[tuple[str, str, int]]:
    """Every name that a file imports from `modules`: the module, the name, the line. A whole module has the name ""."""
    for node in ast.walk(parsed(text)):
        if isinstance(node, ast.Import):
            yield from ((a.name, "", node.lineno) for a in node.names if a.name in modules)
        elif isinstance(node, ast.ImportFrom) and node.module in modules:
            for a in node.names:
                inner = f"{node.module}.{a.name}"
                yield (inner, "", node.lineno) if inner in modules else (node.module, a.name, node.lineno)


def read_of_modules(text: str, modules: set[str]) -> Iterator[tuple[str, int]]:
    """Every dotted name `a.b.c` of a file whose `a` is a module that the file imports, written out, with the line."""
    tree = parsed(text)
    modules_by_name: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules_by_name |= {
                a.asname or a.name.split(".")[0]: a.name if a.asname else a.name.split(".")[0] for a in node.names
            }
        elif isinstance(node, ast.ImportFrom):
            modules_by_name |= {a.asname or a.name: f"{node.module}.{a.name}" for a in node.names}
    for node in ast.walk(tree):
        attributes: list[str] = []
        value = node
        while isinstance(value, ast.Attribute):
            attributes.insert(0, value.attr)
            value = value.value
        if attributes and isinstance(value, ast.Name) and modules_by_name.get(value.id) in modules:
            yield ".".join([modules_by_name[value.id], *attributes]), node.lineno


def names_that_are_modules_too(text: str, room: str, modules: set[str]) -> set[str]:
    """Names that a face takes from a module of the same name: what others get is the name, and the module stays inside."""
    nodes = [n for n in parsed(text).body if isinstance(n, ast.ImportFrom) and n.module != room]
    return {a.asname or a.name for n in nodes for a in n.names if f"{n.module}.{a.name}" not in modules} & {
        m.removeprefix(f"{room}.") for m in modules
    }


def is_beside(importer: str, module: str) -> bool:
    """Whether a file is in the folder of a module that is in a room."""
    folder = module.rpartition(".")[0]
    return "." in folder and importer.startswith(folder + ".")


def past_a_face(sources: dict[str, str], rooms: set[str]) -> tuple[list[str], dict[str, set[str]]]:
    """Imports and attributes that go past a face, and what every face is used for from outside."""
    faces = {room: face_of(sources[room]) for room in rooms}
    not_to_enter = {room: names_that_are_modules_too(sources[room], room, set(sources)) for room in rooms}
    breaches: list[str] = []
    used: dict[str, set[str]] = {room: set() for room in rooms}
    for importer, text in sources.items():
        reads = [(".".join(filter(None, [m, name])), line) for m, name, line in imported(text, set(sources))]
        for full, line in [*reads, *read_of_modules(text, set(sources))]:
            steps, before = full.split("."), len(breaches)
            for depth in range(1, len(steps)):
                room, step = ".".join(steps[:depth]), steps[depth]
                if importer == room or importer.startswith(room + "."):
                    continue
                if step.startswith("_") and not step.endswith("__") and room in sources and not is_beside(importer, room):
                    breaches.append(f"{importer}, line {line}: imports {step}, which is private to {room}")
                if room not in rooms:
                    continue
                used[room].add(step)
                if step not in faces[room]:
                    breaches.append(f"{importer}, line {line}: imports {full}, but {step} is not in the face of {room}")
                elif step in not_to_enter[room] and depth + 1 < len(steps) and (full, line) in reads:
                    breaches.append(f"{importer}, line {line}: imports {full}, but the face of {room} has {step} as a name")
            del breaches[before + 1 :]
    return list(dict.fromkeys(breaches)), used


@functools.cache
def of_the_package() -> tuple[list[str], dict[str, set[str]]]:
    return past_a_face(SOURCES, ROOMS)


def test_imports_go_through_faces() -> None:
    assert of_the_package()[0] == []


def test_a_face_lists_what_others_import_and_no_more() -> None:
    used = of_the_package()[1]
    assert {room: face_of(SOURCES[room]) - used[room] for room in sorted(ROOMS) if face_of(SOURCES[room]) - used[room]} == {}


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"p.a": '__all__ = ["f"]', "p.a.m": "f = g = 1", "p.b": "from p.a.m import g"}, "m is not in the face of p.a"),
        ({"p.a": '__all__ = ["f"]', "p.a.m": "", "p.b": "from p.a import m"}, "m is not in the face of p.a"),
        ({"p.a": '__all__ = ["f"]', "p.b": "def h():\n    from p.a import g"}, "p.b, line 2: imports p.a.g"),
        ({"p.a": '__all__ = ["s"]', "p.a.s": "__all__ = []", "p.b": "from p.a.s import f"}, "f is not in the face of p.a.s"),
        ({"p.a": '__all__ = ["m"]', "p.a.m": "_f = 1", "p.b": "from p.a.m import _f"}, "private"),
        (
            {"p.a": '__all__ = ["s"]', "p.a.s": '__all__ = ["f"]', "p.a.t": "from p.a.s.m import f", "p.a.s.m": ""},
            "m is not in the",
        ),
        ({"p.a": '__all__ = ["f"]', "p.a.m": "", "p.b": "import p.a.m as x"}, "m is not in the face of p.a"),
        ({"p.a": '__all__ = ["f"]', "p.b": "from p.a import *"}, "* is not in the face of p.a"),
        ({"p": "", "p.a": '__all__ = ["f"]', "p.a.m": "", "p.b": "from p import a\na.m.g()"}, "line 2: imports p.a.m"),
        ({"p": "", "p.a": '__all__ = ["f"]', "p.a.m": "", "p.b": "import p.a\np.a.m.g()"}, "line 2: imports p.a.m"),
        ({"p.a": '__all__ = ["m"]', "p.a.m": "_f = 1", "p.b": "from p.a import m\nm._f"}, "_f, which is private to p.a.m"),
        ({"p": "", "p.m": "_f = 1", "p.b": "from p.m import _f"}, "_f, which is private to p.m"),
        ({"p.a": '__all__ = ["m"]', "p.a.m": "_f = 1", "p.ab": "", "p.ab.c": "from p.a.m import _f"}, "private to p.a.m"),
        (
            {"p.a": 'from p.a.f import f\n__all__ = ["f"]', "p.a.f": "f = g = 1", "p.b": "from p.a.f import g"},
            "the face of p.a has f as a name",
        ),
    ],
)
def test_an_import_past_a_face_is_named(files: dict[str, str], message: str) -> None:
    rooms = {name for name in files if any(other.startswith(name + ".") for other in files)} | {
        n for n in files if "__all__" in files[n]
    }
    assert any(message in line for line in past_a_face(files, rooms)[0])


def test_rooms_look_inside_themselves_as_they_like() -> None:
    files = {"p.a": '__all__ = ["f"]', "p.a.m": "from p.a.n import g", "p.a.n": "", "p.b": "from p.a import f"}
    assert past_a_face(files, {"p.a", "p.b"})[0] == []


def too_large(files: dict[str, str]) -> list[str]:
    """Rooms of too many files, and rooms of too many lines whose docstring gives no reason. files: the text by path."""
    messages = []
    for room in sorted({path.rsplit("/", 1)[0] for path in files}):
        here = [path for path in files if path.rsplit("/", 1)[0] == room and not path.endswith("/__init__.py")]
        lines = sum(len(text.splitlines()) for path, text in files.items() if path.startswith(room + "/"))
        if len(here) > FILES_OF_A_ROOM:
            messages.append(f"{room}: {len(here)} files; {FILES_OF_A_ROOM} at the most, make sub-rooms")
        if (
            lines > LINES_OF_A_ROOM
            and "/" in room
            and "Large because" not in (ast.get_docstring(ast.parse(files[room + "/__init__.py"])) or "")
        ):
            messages.append(f"{room}: {lines} lines; over {LINES_OF_A_ROOM} its docstring says why")
    return messages


def test_a_room_can_be_held_in_the_head() -> None:
    assert too_large({str(p.relative_to(ROOT)): p.read_text() for p in PACKAGE.rglob("*.py")}) == []


def test_a_room_that_is_too_large_is_named() -> None:
    small = {f"p/a/{k}.py": "" for k in range(FILES_OF_A_ROOM)} | {"p/a/__init__.py": ""}
    assert too_large(small) == []
    assert too_large(small | {"p/a/more.py": ""}) == ["p/a: 11 files; 10 at the most, make sub-rooms"]
    long = small | {"p/a/s/long.py": "x = 1\n" * (LINES_OF_A_ROOM + 1), "p/a/s/__init__.py": '"""Large because of a table."""'}
    assert [line.split(":")[0] for line in too_large(long)] == ["p/a"]


def test_every_folder_says_what_it_is() -> None:
    """The docstring of an `__init__.py` is a sentence, so that a listing of the faces is the map of the house. A folder without that
    file would be no room, and have no face to go past."""
    folders = {p.parent for top in (PACKAGE, ROOT / "benchmarks") for p in top.rglob("*.py")}
    assert [str(folder) for folder in sorted(folders) if not (folder / "__init__.py").is_file()] == []
    docstrings = {folder: ast.get_docstring(ast.parse((folder / "__init__.py").read_text())) or "" for folder in folders}
    assert [str(folder) for folder in sorted(folders) if len(docstrings[folder].split()) < 4] == []
