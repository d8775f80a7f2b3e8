"""A file's name alone tells what it holds: no two rooms have files of one name."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
COMMANDS = ("cli/check_commands", "cli/design_commands")  # a command's file is named as the command

# Names that are right in each of their rooms. A name leaves the list when it is in one room only, and none is added.
SHARED = {
    "printer": "of each target language, in a folder of its own, and what they share",
    "runner": "of each target language, in a folder of its own",
}


def names_in_several_rooms(paths: Iterable[str]) -> dict[str, list[str]]:
    """The rooms by name of a file, where they are several. paths: in the package, with slashes."""
    rooms = defaultdict(list)
    for path in paths:
        room, _, name = path.removesuffix(".py").rpartition("/")
        if room not in COMMANDS and not name.startswith("__"):
            rooms[name].append(room)
    return {name: found for name, found in rooms.items() if len(found) > 1}


def test_a_file_name_is_in_one_room() -> None:
    repeated = names_in_several_rooms(str(path.relative_to(PACKAGE)) for path in sorted(PACKAGE.rglob("*.py")))
    assert {name: rooms for name, rooms in repeated.items() if name not in SHARED} == {}, "say in each name what the file holds"
    assert SHARED.keys() - repeated.keys() == set(), "take it off the list"


def test_a_name_in_two_rooms_is_seen() -> None:
    assert names_in_several_rooms(["a/errors.py", "errors.py", "a/b.py"]) == {"errors": ["a", ""]}
    assert names_in_several_rooms(["a/__init__.py", "b/__init__.py", "a/check.py", "cli/check_commands/check.py"]) == {}
