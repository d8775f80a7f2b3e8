"""Rooms and faces: other folders import from a room only what its `__init__.py` lists, and a room has a limited size.

A room is a folder of the package. Its face is the `__all__` of its `__init__.py`: names, sub-rooms, and modules that others may import
as a module (the paper's equations, modules for the lemma book, modules that are slow to import). Tests and benchmarks may import anything.
"""

from __future__ import annotations

import ast
import functools
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
FILES_OF_A_ROOM = 10  # without its __init__.py; with more files it has sub-rooms
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
    """Yield module, name and line of every name that a file imports from `modules`; an imported module has the name ""."""
    for node in ast.walk(parsed(text)):
        if isinstance(node, ast.Import):
            yield from ((a.name, "", node.lineno) for a in node.names if a.name in modules)
        elif isinstance(node, ast.ImportFrom) and node.module in modules:
            for a in node.names:
                inner = f"{node.module}.{a.name}"
                yield (inner, "", node.lineno) if inner in modules else (node.module, a.name, node.lineno)


def read_of_modules(text: str, modules: set[str]) -> Iterator[tuple[str, int]]:
    """Yield every dotted name `a.b.c` of a file, with its line, where `a` is an imported module; `a` is written in full."""
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


def names_that_are_modules_too(text: str, folder: str, modules: set[str]) -> set[str]:
    """Return names that a face imports from a module of the same name; others see the name, and not the module."""
    nodes = [n for n in parsed(text).body if isinstance(n, ast.ImportFrom) and n.module != folder]
    return {a.asname or a.name for n in nodes for a in n.names if f"{n.module}.{a.name}" not in modules} & {
        m.removeprefix(f"{folder}.") for m in modules
    }


def is_beside(importer: str, module: str) -> bool:
    """Return whether a file is in the folder of a module that is in a room."""
    folder = module.rpartition(".")[0]
    return "." in folder and importer.startswith(folder + ".")


def bypassed_faces(sources: dict[str, str], rooms: set[str]) -> tuple[list[str], dict[str, set[str]]]:
    """Return messages about imports and attributes that bypass a face, and the names that others use of every face."""
    faces = {folder: face_of(sources[folder]) for folder in rooms}
    not_to_enter = {folder: names_that_are_modules_too(sources[folder], folder, set(sources)) for folder in rooms}
    breaches: list[str] = []
    used: dict[str, set[str]] = {folder: set() for folder in rooms}
    for importer, text in sources.items():
        reads = [(".".join(filter(None, [m, name])), line) for m, name, line in imported(text, set(sources))]
        for full, line in [*reads, *read_of_modules(text, set(sources))]:
            steps, before = full.split("."), len(breaches)
            for depth in range(1, len(steps)):
                folder, step = ".".join(steps[:depth]), steps[depth]
                if importer == folder or importer.startswith(folder + "."):
                    continue
                if step.startswith("_") and not step.endswith("__") and folder in sources and not is_beside(importer, folder):
                    breaches.append(f"{importer}, line {line}: imports {step}, which is private to {folder}")
                if folder not in rooms:
                    continue
                used[folder].add(step)
                if step not in faces[folder]:
                    breaches.append(f"{importer}, line {line}: imports {full}, but {step} is not in the face of {folder}")
                elif step in not_to_enter[folder] and depth + 1 < len(steps) and (full, line) in reads:
                    breaches.append(f"{importer}, line {line}: imports {full}, but the face of {folder} has {step} as a name")
            del breaches[before + 1 :]
    return list(dict.fromkeys(breaches)), used


@functools.cache
def faces_of_the_package() -> tuple[list[str], dict[str, set[str]]]:
    return bypassed_faces(SOURCES, ROOMS)


def test_imports_go_through_faces() -> None:
    assert faces_of_the_package()[0] == []


def test_a_face_lists_what_others_import_and_no_more() -> None:
    used = faces_of_the_package()[1]
    assert {
        folder: face_of(SOURCES[folder]) - used[folder] for folder in sorted(ROOMS) if face_of(SOURCES[folder]) - used[folder]
    } == {}


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
def test_an_import_that_bypasses_a_face_is_reported(files: dict[str, str], message: str) -> None:
    rooms = {name for name in files if any(path.startswith(name + ".") for path in files)} | {
        n for n in files if "__all__" in files[n]
    }
    assert any(message in line for line in bypassed_faces(files, rooms)[0])


def test_imports_within_a_room_need_no_face() -> None:
    files = {"p.a": '__all__ = ["f"]', "p.a.m": "from p.a.n import g", "p.a.n": "", "p.b": "from p.a import f"}
    assert bypassed_faces(files, {"p.a", "p.b"})[0] == []


def too_large(files: dict[str, str]) -> list[str]:
    """Return messages about rooms with too many files, or with too many lines and no reason in the docstring; files are texts by path."""
    messages = []
    for folder in sorted({path.rsplit("/", 1)[0] for path in files}):
        paths = [path for path in files if path.rsplit("/", 1)[0] == folder and not path.endswith("/__init__.py")]
        lines = sum(len(text.splitlines()) for path, text in files.items() if path.startswith(folder + "/"))
        if len(paths) > FILES_OF_A_ROOM:
            messages.append(f"{folder}: {len(paths)} files; at most {FILES_OF_A_ROOM} are allowed, make sub-rooms")
        if (
            lines > LINES_OF_A_ROOM
            and "/" in folder
            and "Large because" not in (ast.get_docstring(ast.parse(files[folder + "/__init__.py"])) or "")
        ):
            messages.append(f"{folder}: {lines} lines; over {LINES_OF_A_ROOM} its docstring says why")
    return messages


def test_no_room_is_too_large() -> None:
    """The stand-alone checker has a budget of lines of its own (tests/certify/test_listing.py)."""
    files = {str(p.relative_to(ROOT)): p.read_text() for p in PACKAGE.rglob("*.py")}
    assert too_large({path: text for path, text in files.items() if "/stt_checker/" not in path}) == []


def test_a_room_that_is_too_large_is_reported() -> None:
    small = {f"p/a/{k}.py": "" for k in range(FILES_OF_A_ROOM)} | {"p/a/__init__.py": ""}
    assert too_large(small) == []
    assert too_large(small | {"p/a/more.py": ""}) == ["p/a: 11 files; at most 10 are allowed, make sub-rooms"]
    long = small | {"p/a/s/long.py": "x = 1\n" * (LINES_OF_A_ROOM + 1), "p/a/s/__init__.py": '"""Large because of a table."""'}
    assert [line.split(":")[0] for line in too_large(long)] == ["p/a"]


def test_every_folder_has_a_docstring() -> None:
    """The docstring of an `__init__.py` is a sentence, so that a listing of them describes the package. A folder without that file would
    not be checked as a room."""
    folders = {p.parent for top in (PACKAGE, ROOT / "benchmarks") for p in top.rglob("*.py")}
    assert [str(folder) for folder in sorted(folders) if not (folder / "__init__.py").is_file()] == []
    docstrings = {folder: ast.get_docstring(ast.parse((folder / "__init__.py").read_text())) or "" for folder in folders}
    assert [str(folder) for folder in sorted(folders) if len(docstrings[folder].split()) < 4] == []
