"""The checker, the Coq proof and the page on tasks know the same keys as `task_keys()`, which is the one list of a task's keys."""

from __future__ import annotations

import re

from stt_codegen.checker.stt_checker import files as checked_files
from stt_codegen.checker.stt_checker import keys as checked_keys
from stt_codegen.checker.stt_checker import sets as checked_sets
from stt_codegen.program.targets import optional_targets
from stt_codegen.task import task_keys
from stt_codegen.task.sets.shapes import KINDS, SET_TABLES, fields_of_shape
from stt_codegen.theorem.controller_theorem import UNREAD_KEYS, readable_keys
from tests.support.controllers import ROOT

# Keys that the checker does not read: the .task.toml beside the C has the sets that they stand for.
SPELLED_OUT = {"state_space": {"outline", "holes"}}
MOTION_KEYS = {"motion", "during", "timing", "spread"}  # of unsafe sets only: a region does not move
COQ = (ROOT / "proof" / "Toml.v").read_text()
PAGE = (ROOT / "docs" / "task.md").read_text()


def keys_of_coq() -> dict[str, set[str]]:
    """Return the keys by table that the list `known_sections` of proof/Toml.v has."""
    (text,) = re.findall(r"Definition known_sections [^=]*:= \[(.*?)\]\.\n", COQ, re.S)
    return {table: set(re.findall(r'"(\w+)"', keys)) for table, keys in re.findall(r'\("(\w*)", \[(.*?)\]\)', text)}


def test_the_checker_knows_the_keys_of_the_task_and_no_others() -> None:
    expected = {table: set(keys) - SPELLED_OUT.get(table, set()) for table, keys in task_keys().items()}
    expected["region"] -= MOTION_KEYS
    assert {table: set(keys.split()) for table, keys in checked_keys.KNOWN_KEYS.items()} == expected


def test_the_checker_knows_the_fields_of_every_shape_and_no_others() -> None:
    assert {*map(frozenset, checked_sets.FORMS)} == {frozenset(fields_of_shape(table)) for table in SET_TABLES}


def test_the_checker_knows_the_files_of_every_language_that_it_does_not_read() -> None:
    assert sorted(checked_files.OTHER_LANGUAGES) == sorted(suffix for target in optional_targets() for suffix in target.suffixes)


def test_coq_reads_the_readable_keys_and_unread_keys_are_keys_of_a_task() -> None:
    assert keys_of_coq() == readable_keys()
    known = task_keys()
    assert {table: set(keys.split()) - set(known[table]) for table, keys in UNREAD_KEYS.items()} == {
        table: set() for table in UNREAD_KEYS
    }


def test_every_field_of_a_shape_selects_its_kind() -> None:
    assert {field for table in SET_TABLES[1:] for field in fields_of_shape(table)} == set(KINDS)


def documented_keys(page: str) -> dict[str, set[str]]:
    """Return by table the keys in the first column of the page's first table.

    A row is about the tables that its first column names, or else about those of the row above.
    """
    keys: dict[str, set[str]] = {"": set()}
    tables = [""]
    for first_column in re.findall(r"^\| (`.*?) \|", page.partition("\nDesigns:")[0], re.M):
        words = re.findall(r"`([^`]+)`", first_column)
        if any(word.startswith("[") for word in words):
            tables = []
        for word in words:
            if word.startswith("["):
                table, _, key = word.strip("[]").partition(".")
                tables.append(table)
                keys[""].add(table)
                keys.setdefault(table, set()).update([key] if key else [])
            else:
                for table in tables:
                    keys.setdefault(table, set()).add(word)
        if "a shape" in first_column:  # which the rows of unsafe sets describe
            keys[tables[-1]] |= keys.get("unsafe", set())
    return keys


def undocumented_keys(page: str) -> dict[str, set[str]]:
    """Return by table the keys of a task that the page does not document."""
    documented = documented_keys(page)
    missing = {table: set(keys) - documented.get(table, set()) for table, keys in task_keys().items()}
    return {table: keys for table, keys in missing.items() if keys}


def test_the_page_on_tasks_names_every_key() -> None:
    assert undocumented_keys(PAGE) == {}


def test_no_row_of_the_page_can_be_left_out() -> None:
    """Without any one row some key is no longer documented, even where other tables of the page mention it."""
    lines = PAGE.partition("\nDesigns:")[0].splitlines()
    rows = [line for line in lines if line.startswith("| `") and "`[map]`" not in line]  # which is replaced by unsafe sets
    assert len(rows) > 50
    assert [row for row in rows if undocumented_keys(PAGE.replace(row + "\n", "")) == {}] == []
