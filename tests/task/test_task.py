"""Loading tasks: numbers of an accepted task are exact, and a refusal is one message that says what would be right."""

from __future__ import annotations

import json
import string
import tomllib
from fractions import Fraction

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stt_codegen.errors import BadInput
from stt_codegen.task.load import json_schema, load_task, parse_task
from tests.support.controllers import ROOT, TASK_FILES

GOOD = """
name = "robot"
prescribed_time = 9.0
initial_state = [0.25, 0.25]

[state_space]
lower = [0.0, 0.0]
upper = [5.0, 5.0]

[initial_set]
lower = [0.0, 0.0]
upper = [0.5, 0.5]

[target_set]
lower = [4.5, 4.5]
upper = [5.0, 5.0]

[[unsafe]]
name = "O1"
lower = [1.0, 4.0]
upper = [2.0, 5.0]
"""

# (text of GOOD, its replacement, words that the message must contain)
REFUSALS = [
    ('name = "robot"', "", ["name", "missing"]),
    ("prescribed_time = 9.0", "", ["prescribed_time", "missing"]),
    ("[target_set]\nlower = [4.5, 4.5]\nupper = [5.0, 5.0]", "", ["target_set", "missing"]),
    ("lower = [4.5, 4.5]", "", ["target_set.lower", "missing"]),
    ('name = "robot"', 'name = "9lives"', ["name", "letter"]),
    ('name = "robot"', 'name = "a-b"', ["name", "letter"]),
    ('name = "robot"', 'name = ""', ["name", "letter"]),
    ('name = "robot"', 'name = "abcdefghijklmnopqrstu"', ["name", "20"]),
    ('name = "robot"', 'name = "n\u00e4me"', ["name", "letter"]),
    ('name = "robot"', 'name = "while"', ["name", "reserved"]),
    ('name = "robot"', 'name = "class"', ["name", "reserved"]),
    ('name = "robot"', 'name = "lambda"', ["name", "reserved"]),
    ('name = "robot"', 'name = "math"', ["name", "standard library"]),
    ('name = "robot"', 'name = "stdint"', ["name", "standard library"]),
    ('name = "robot"', "name = 7", ["name", "text"]),
    ("prescribed_time = 9.0", "prescribed_time = 0.0", ["prescribed_time", "greater than 0"]),
    ("prescribed_time = 9.0", "prescribed_time = -1", ["prescribed_time", "greater than 0"]),
    ("prescribed_time = 9.0", "prescribed_time = true", ["prescribed_time", "boolean"]),
    ("prescribed_time = 9.0", 'prescribed_time = "9"', ["prescribed_time", "number"]),
    ("prescribed_time = 9.0", "prescribed_time = nan", ["prescribed_time", "finite"]),
    ("prescribed_time = 9.0", "prescribed_time = inf", ["prescribed_time", "finite"]),
    ("prescribed_time = 9.0", "prescribed_time = 1e300", ["prescribed_time", "magnitude"]),
    ("prescribed_time = 9.0", "prescribed_time = 1e-300", ["prescribed_time", "magnitude"]),
    ("prescribed_time = 9.0", "prescribed_time = 1e999999999", ["prescribed_time", "magnitude"]),
    ("prescribed_time = 9.0", f"prescribed_time = 1.{'1' * 60}", ["prescribed_time", "digits"]),
    ("prescribed_time = 9.0", f"prescribed_time = {'9' * 5000}", ["line 3", "1,000 characters"]),
    ("prescribed_time = 9.0", "prescribed_time = 9.0\nprescribed_time = 9.0", ["TOML", "line"]),
    ("prescribed_time = 9.0", "prescribed_time = ", ["TOML", "line"]),
    ("prescribed_time = 9.0", "prescribed_time = 2026-01-01", ["prescribed_time", "number"]),
    ("prescribed_time = 9.0", "prescribed_tim = 9.0", ["prescribed_time"]),
    ("initial_state = [0.25, 0.25]", "initial_state = [0.25]", ["initial_state", "1 entries", "2"]),
    ("initial_state = [0.25, 0.25]", "initial_state = 0.25", ["initial_state", "list"]),
    ("initial_state = [0.25, 0.25]", "initial_state = []", ["initial_state", "empty"]),
    ("initial_state = [0.25, 0.25]", "initial_state = [0.25, true]", ["initial_state[1]", "boolean"]),
    ("initial_state = [0.25, 0.25]", "initial_state = [0.25, nan]", ["initial_state[1]", "finite"]),
    ("initial_state = [0.25, 0.25]", "initial_state = [0.5, 0.25]", ["initial_state[0]", "strictly inside"]),
    ("initial_state = [0.25, 0.25]", "initial_state = [0.25, 0.7]", ["initial_state[1]", "between 0 and 0.5"]),
    ("upper = [0.5, 0.5]", "upper = [0.5, 0.0]", ["initial_set", "lower[1]", "not below"]),
    ("upper = [0.5, 0.5]", "upper = [0.5, 0.5, 0.5]", ["initial_set.upper", "3 entries"]),
    ("lower = [4.5, 4.5]", "lower = [4.5, 6.0]", ["target_set", "not below"]),
    ("upper = [2.0, 5.0]", "upper = [1.0, 5.0]", ["unsafe[0]", "not below"]),
    ("lower = [0.0, 0.0]\nupper = [0.5", "lower = [-0.1, 0.0]\nupper = [0.5", ["initial_set", "outside the state space", "at least 0"]),
    ("upper = [5.0, 5.0]\n\n[[", "upper = [5.0, 5.5]\n\n[[", ["target_set", "outside the state space", "at most 5"]),
    ("lower = [1.0, 4.0]", "lower = [0.4, 0.4]", ["initial_set", "meets", "O1"]),
    ("lower = [1.0, 4.0]\nupper = [2.0, 5.0]", "lower = [0.5, 0.0]\nupper = [1.0, 1.0]", ["initial_set", "meets", "O1"]),
    ("lower = [1.0, 4.0]\nupper = [2.0, 5.0]", "lower = [4.0, 4.0]\nupper = [5.0, 5.0]", ["target_set", "inside", "O1"]),
    ("[[unsafe]]", "[unsafe]", ["unsafe", "list of tables"]),
    ("[[unsafe]]", "[[unsave]]", ["unsave", "unsafe"]),
    ("[state_space]", "state_space = 3\n[state_spac]", ["state_space", "table"]),
]  # fmt: skip

APPENDED = [
    ('[[unsafe]]\nname = "O1"\nlower = [2.0, 2.0]\nupper = [3.0, 3.0]', ["unsafe[1].name", "O1", "differ"]),
    ('[[unsafe]]\nname = "U3"\nlower = [2.0, 2.0]\nupper = [3.0, 3.0]\n[[unsafe]]\nlower = [2, 2]\nupper = [3, 3]', ["unsafe[2].name", "U3"]),
    ("[control]\ngain = 0.0", ["control.gain", "0"]),
    ("[control]\ne_max = 1.0", ["control.e_max", "between 0 and 1"]),
    ("[control]\ne_max = 0.0", ["control.e_max", "between 0 and 1"]),
    ("[control]\ngane = 0.5", ["control.gane", "gain"]),
    ("[control]\nu_max = [1.0]", ["control.u_max", "1 entries"]),
    ("[control]\nu_max = [1.0, 0.0]", ["control.u_max[1]", "greater than 0"]),
    ("[tube]\nclearance = -0.1", ["tube.clearance", "0 or greater"]),
    ("[tube]\nmin_width = -0.1", ["tube.min_width", "0 or greater"]),
    ("[tube]\nmax_speed = -1.0", ["tube.max_speed", "greater than 0"]),
    ("[tube]\nmax_speed = 0.0", ["tube.max_speed", "greater than 0"]),
    ("[tube]\nmax_speed = [1.0]", ["tube.max_speed", "1 entries"]),
    ("[tube]\nmax_speed = [1.0, 0.0]", ["tube.max_speed[1]", "greater than 0"]),
    ("[tube]\nmax_acceleration = 0.0", ["tube.max_acceleration", "greater than 0"]),
    ("[tube]\nmax_acceleration = [1.0, 2.0, 3.0]", ["tube.max_acceleration", "3 entries"]),
    ('[tube]\nmax_acceleration = "much"', ["tube.max_acceleration", "number"]),
    ('[tube]\nprefer = "fast"', ["tube.prefer", "balanced"]),
    ('[tube]\ndesign = "literal"\nmax_acceleration = 1.0', ["tube.max_acceleration", "refined"]),
    ('[tube]\ndesign = "adaptive"\nprefer = "slow"', ["tube.prefer", "leave it out"]),
    ("[tube]\nsegments = 2.5", ["tube.segments", "whole"]),
    ("[tube]\nsegments = 1", ["tube.segments", "at least 4"]),
    ("[tube]\nsegments = true", ["tube.segments", "whole"]),
    ('[tube]\ndesign = "adaptive"\nadaptive = {bump_steepness = 1.0}', ["tube.adaptive.bump_steepness", "leave it out"]),
    ('[tube]\ndesign = "literal"\nadaptive = {target_margin = 1.0}', ["tube.adaptive.target_margin", "leave it out"]),
    ('[tube]\ndesign = "clever"', ["tube.design", "refined"]),
    ('[emit]\nscalar = "half"', ["emit.scalar", "float"]),
    ("[emit]\nscalar = 4", ["emit.scalar", "float"]),
    ("[plant]\ng_min = 2.0\ng_max = 1.0", ["plant.g_min", "g_max"]),
    ("[plant]\ng_min = 0.0", ["plant.g_min", "greater than 0"]),
]  # fmt: skip


def refusal(text: str) -> str:
    """Return the message, one line with the file's name, with which the text of a task is refused."""
    with pytest.raises(BadInput) as caught:
        parse_task(text, "file.toml")
    assert caught.value.exit_code == 2
    message = str(caught.value)
    assert message.startswith("file.toml: ")
    assert "\n" not in message
    return message


def test_the_file_that_malformed_files_are_made_from_is_accepted() -> None:
    assert parse_task(GOOD).dimension == 2


@pytest.mark.parametrize(("old", "new", "words"), REFUSALS)
def test_a_malformed_field_is_named_with_what_would_be_right(old: str, new: str, words: list[str]) -> None:
    assert old in GOOD
    message = refusal(GOOD.replace(old, new))
    for word in words:
        assert word in message


@pytest.mark.parametrize(("added", "words"), APPENDED)
def test_a_malformed_addition_is_named_with_what_would_be_right(added: str, words: list[str]) -> None:
    message = refusal(GOOD + added + "\n")
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("[-0.1, 0.0]", ["body[0]", "0 or greater"]),
        ("[3.0, 0.0]", ["body[0]", "fit"]),
        ("[0.1, 0.0]", ["initial_set", "less the body", "at least 0.1"]),
        ("[0.1]", ["body", "1 entries"]),
    ],
)
def test_a_body_that_does_not_fit_is_refused(body: str, words: list[str]) -> None:
    message = refusal(GOOD.replace("initial_state =", f"body = {body}\ninitial_state ="))
    for word in words:
        assert word in message


def test_unreadable_files_are_refused(tmp_path) -> None:
    missing, folder, binary = tmp_path / "none.toml", tmp_path, tmp_path / "binary.toml"
    binary.write_bytes(b'name = "\xff\xfe"')
    for path, word in ((missing, "cannot be read"), (folder, "cannot be read"), (binary, "UTF-8")):
        with pytest.raises(BadInput, match=word):
            load_task(path)


@given(st.text(alphabet=string.printable, max_size=200))
def test_random_text_is_refused_without_a_crash(text: str) -> None:
    refusal(text)


@given(st.data())
def test_a_damaged_file_is_a_task_or_is_refused_without_a_crash(data) -> None:
    lines = GOOD.splitlines()
    k = data.draw(st.integers(0, len(lines) - 1))
    piece = data.draw(st.sampled_from(["", "[", "nan", "[[1]]", "x = {}", "name = 'a'\nname = 'b'", "lower = [[0]]", "= = ="]))
    lines[k] = piece
    try:
        parse_task("\n".join(lines))
    except BadInput as error:
        assert "\n" not in str(error)


@given(st.decimals(min_value="0.001", max_value="1000", places=6))
def test_decimal_numbers_stay_exact(value) -> None:
    task = parse_task(GOOD.replace("prescribed_time = 9.0", f"prescribed_time = {value}"))
    assert task.prescribed_time == Fraction(str(value))


def test_the_digest_is_of_the_data_and_not_of_its_spelling() -> None:
    respelled = GOOD.replace("9.0", "9.000").replace("\n", "  # note\n", 1).replace("[0.25, 0.25]", "[ 0.25,0.250 ]")
    changed = GOOD.replace("9.0", "9.0000001")
    assert parse_task(GOOD).digest == parse_task(respelled).digest != parse_task(changed).digest


def test_the_body_grows_unsafe_sets_and_shrinks_the_space() -> None:
    text = GOOD.replace("initial_state = [0.25, 0.25]", "body = [0.1, 0.2]\ninitial_state = [0.35, 0.35]")
    text = text.replace("lower = [0.0, 0.0]\nupper = [0.5, 0.5]", "lower = [0.1, 0.2]\nupper = [0.5, 0.5]")
    text = text.replace("lower = [4.5, 4.5]\nupper = [5.0, 5.0]", "lower = [4.5, 4.5]\nupper = [4.9, 4.8]")
    task = parse_task(text)
    assert task.free_space.lower == (Fraction("0.1"), Fraction("0.2"))
    assert task.free_space.upper == (Fraction("4.9"), Fraction("4.8"))
    assert task.obstacles[0].lower == (Fraction("0.9"), Fraction("3.8"))
    assert task.obstacles[0].upper == (Fraction("2.1"), Fraction("5.2"))


def test_the_committed_schema_is_the_exported_one_and_accepts_the_example_tasks() -> None:
    schema = json.loads(json_schema())
    assert (ROOT / "docs" / "task.schema.json").read_text() == json_schema()
    for path in TASK_FILES:
        jsonschema.validate(tomllib.loads(path.read_text()), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"name": "robot"}, schema)


HUGE = "0x" + "f" * 5000


@pytest.mark.parametrize("line", [f"[tube]\nseed = {HUGE}", f"[tube]\nsegments = {HUGE}", f"[emit]\nscalar = {HUGE}"])
def test_huge_hexadecimal_integers_are_refused_with_a_short_message(line: str) -> None:
    assert len(refusal(f"{GOOD}{line}\n")) < 200


@pytest.mark.parametrize("name", ["[/x]", "a*/b", "line\\nbreak", "$\\\\frac$", "x" * 41])
def test_names_of_unsafe_sets_that_could_break_text_are_refused(name: str) -> None:
    assert "unsafe[0].name" in refusal(GOOD.replace('name = "O1"', f'name = "{name}"'))


def test_an_unknown_key_is_quoted_if_it_has_special_characters() -> None:
    assert "'a\\nb'" in refusal(f'"a\\nb" = 1\n{GOOD}')


def test_a_byte_order_mark_does_no_harm(tmp_path) -> None:
    (tmp_path / "bom.toml").write_bytes(b"\xef\xbb\xbf" + GOOD.encode())
    assert load_task(tmp_path / "bom.toml").name == "robot"
