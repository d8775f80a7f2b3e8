"""A file's name says what is in it, so that no two folders of the package have files of one name."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
COMMANDS = ("cli/check_commands", "cli/design_commands")  # a command's file is named as the command

# Names that are right in each of their folders. A name leaves the list when it is in one folder only, and none is added.
SHARED = {
    "printer": "of each target language, in its folder, and their common base",
    "runner": "of each target language, in a folder of its own",
}


STAND_ALONE = "checker/stt_checker/"  # a package of its own, whose files are named after what a reader of a certificate looks for


def names_in_several_rooms(paths: Iterable[str]) -> dict[str, list[str]]:
    """Return the folders by name of a file for names in several folders; paths are relative to the package, with slashes."""
    rooms = defaultdict(list)
    for path in paths:
        folder, _, name = path.removesuffix(".py").rpartition("/")
        if folder not in COMMANDS and not name.startswith("__"):
            rooms[name].append(folder)
    return {name: folders for name, folders in rooms.items() if len(folders) > 1}


def test_a_file_name_is_in_one_folder() -> None:
    paths = (str(path.relative_to(PACKAGE)) for path in sorted(PACKAGE.rglob("*.py")))
    repeated = names_in_several_rooms(path for path in paths if not path.startswith(STAND_ALONE))
    assert {name: rooms for name, rooms in repeated.items() if name not in SHARED} == {}, "say in each name what the file holds"
    assert SHARED.keys() - repeated.keys() == set(), "take it off the list"


def test_a_name_in_two_folders_is_reported() -> None:
    assert names_in_several_rooms(["a/errors.py", "errors.py", "a/b.py"]) == {"errors": ["a", ""]}
    assert names_in_several_rooms(["a/__init__.py", "b/__init__.py", "a/check.py", "cli/check_commands/check.py"]) == {}
