"""One list of a task's keys: what stands alone, or is written for people, has the same keys, and no others."""

from __future__ import annotations

import re

from stt_codegen.certify import checker
from stt_codegen.program.targets import optional_targets
from stt_codegen.task import task_keys
from stt_codegen.task.sets.shapes import KINDS, SET_TABLES, fields_of_shape
from stt_codegen.theorem.controller_theorem import UNREAD, readable_keys
from tests.support.controllers import ROOT

# Keys of which the checker wants the sets spelled out, in the .task.toml beside the C.
SPELLED_OUT = {"state_space": {"outline", "holes"}}
STANDING = {"motion", "during", "timing", "spread"}  # of unsafe sets; a region stands still
COQ = (ROOT / "proof" / "Toml.v").read_text()
PAGE = (ROOT / "docs" / "task.md").read_text()


def keys_of_coq() -> dict[str, set[str]]:
    """The list `sections_known` of proof/Toml.v."""
    (text,) = re.findall(r"Definition sections_known [^=]*:= \[(.*?)\]\.\n", COQ, re.S)
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
    assert {table: set(keys.split()) - set(known[table]) for table, keys in UNREAD.items()} == {table: set() for table in UNREAD}


def test_what_tells_a_set_is_a_field_of_its_table() -> None:
    assert {field for table in SET_TABLES[1:] for field in fields_of_shape(table)} == set(KINDS)


def test_the_page_on_tasks_names_every_key() -> None:
    written = {word for code in re.findall(r"`([^`\n]+)`", PAGE) for word in re.findall(r"\w+", code)}
    missing = {table: set(keys) - written for table, keys in task_keys().items() if set(keys) - written}
    assert missing == {}
