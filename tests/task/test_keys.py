"""One list of a task's keys: what stands alone, or is written for people, has the same keys, and no others."""

from __future__ import annotations

import re

from stt_codegen.certify import checker
from stt_codegen.program.targets import optional_targets
from stt_codegen.task import task_keys
from stt_codegen.task.sets.shapes import KINDS, SET_TABLES, fields_of_shape
from stt_codegen.theorem.controller_theorem import UNREAD_KEYS, readable_keys
from tests.support.controllers import ROOT

# Keys of which the checker wants the sets spelled out, in the .task.toml beside the C.
SPELLED_OUT = {"state_space": {"outline", "holes"}}
STANDING = {"motion", "during", "timing", "spread"}  # of unsafe sets; a region stands still
COQ = (ROOT / "proof" / "Toml.v").read_text()
PAGE = (ROOT / "docs" / "task.md").read_text()


def keys_of_coq() -> dict[str, set[str]]:
    """The list `known_sections` of proof/Toml.v."""
    (text,) = re.findall(r"Definition known_sections [^=]*:= \[(.*?)\]\.\n", COQ, re.S)
    return {table: set(re.findall(r'"(\w+)"', keys)) for table, keys in re.findall(r'\("(\w*)", \[(.*?)\]\)', text)}


def test_the_checker_knows_the_keys_of_the_task_and_no_others() -> None:
    wanted = {table: set(keys) - SPELLED_OUT.get(table, set()) for table, keys in task_keys().items()}
    wanted["region"] -= STANDING
    assert {table: set(keys.split()) for table, keys in checker.KNOWN.items()} == wanted


def test_the_checker_knows_the_ways_to_say_a_set_and_no_others() -> None:
    assert [form.split() for form in checker.FORMS] == [fields_of_shape(table) for table in SET_TABLES]


def test_the_checker_knows_the_files_of_every_language() -> None:
    assert sorted(checker.UNREAD) == sorted(suffix for target in optional_targets() for suffix in target.suffixes)


def test_coq_knows_the_keys_that_it_reads_and_the_rest_is_listed() -> None:
    assert keys_of_coq() == readable_keys()
    known = task_keys()
    assert {table: set(keys.split()) - set(known[table]) for table, keys in UNREAD_KEYS.items()} == {
        table: set() for table in UNREAD_KEYS
    }


def test_what_tells_a_set_is_a_field_of_its_table() -> None:
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
    written = documented_keys(page)
    missing = {table: set(keys) - written.get(table, set()) for table, keys in task_keys().items()}
    return {table: keys for table, keys in missing.items() if keys}


def test_the_page_on_tasks_names_every_key() -> None:
    assert undocumented_keys(PAGE) == {}


def test_every_row_of_the_page_is_needed() -> None:
    """Without a row, which other tables of the page may mention, some key is no longer documented."""
    lines = PAGE.partition("\nDesigns:")[0].splitlines()
    rows = [line for line in lines if line.startswith("| `") and "`[map]`" not in line]  # which is replaced by unsafe sets
    assert len(rows) > 50
    assert [row for row in rows if undocumented_keys(PAGE.replace(row + "\n", "")) == {}] == []
