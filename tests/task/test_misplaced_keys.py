"""A key in a wrong table, or misspelt: the message says where it stands and where it belongs, or the nearest known key."""

import pytest

import stt_codegen as stt
from stt_codegen.task import parse_task
from stt_codegen.task.keys import TOP, TableOfKeys, all_tables

TABLES = {table.heading: table for table in all_tables()}
BASE = {
    TOP: 'name = "cart"\nprescribed_time = 10\ninitial_state = [0.5, 0.5]\n',
    "[state_space]": "lower = [0, 0]\nupper = [4, 4]\n",
    "[initial_set]": "lower = [0.4, 0.4]\nupper = [0.6, 0.6]\n",
    "[target_set]": "lower = [3.4, 3.4]\nupper = [3.6, 3.6]\n",
}
ADDED = {"[[unsafe]]": "lower = [1, 1]\nupper = [2, 2]\n", "[map]": 'file = "hall.yaml"\n'}
WITHIN = ("[[unsafe.motion]]", "[[target_set.motion]]", "[[region.motion]]")


def text_of(tables: dict[str, str]) -> str:
    """Return the text of a task file with these lines by heading, those above the first table first."""
    return "".join(lines if heading == TOP else f"{heading}\n{lines}" for heading, lines in tables.items())


def refusal_of(tables: dict[str, str]) -> str:
    """Return the message with which the text is refused."""
    with pytest.raises(stt.BadInput) as refusal:
        parse_task(text_of(tables))
    return str(refusal.value)


def with_line(heading: str, line: str) -> dict[str, str]:
    """Return the lines of a task with one more line in the table of this heading."""
    tables = BASE | ({heading: ADDED.get(heading, "")} if heading not in BASE else {})
    return tables | {heading: tables[heading] + line}


def pairs() -> list[tuple[TableOfKeys, str]]:
    """Return every table with every key that only others have; tables within sets apart, which a file writes inline."""
    keys = dict.fromkeys(key for table in TABLES.values() for key in table.keys)
    tables = [table for heading, table in TABLES.items() if heading not in WITHIN]
    return [(table, key) for table in tables for key in keys if key not in table.keys]


def test_a_key_in_a_wrong_table_is_said_to_stand_there_and_to_belong_where_it_does() -> None:
    wrong = []
    for table, key in pairs():
        message = refusal_of(with_line(table.heading, f"{key} = 1\n"))
        homes = [home.heading for home in TABLES.values() if key in home.keys]
        if not (f"{key}: stands {table.position}; move it" in message and all(home in message for home in homes)):
            wrong.append(message)
    assert wrong == []


@pytest.mark.parametrize("key", ["name", "prescribed_time", "initial_state"])
@pytest.mark.parametrize("heading", [heading for heading in TABLES if heading not in WITHIN and heading != TOP])
def test_a_needed_key_below_a_header_is_not_called_missing(heading: str, key: str) -> None:
    line = next(line for line in BASE[TOP].splitlines(keepends=True) if line.startswith(key))
    tables = with_line(heading, line)
    message = refusal_of(tables | {TOP: tables[TOP].replace(line, "")})
    assert f"stands in {heading}; move it {TOP}" in message or key in TABLES[heading].keys, message


@pytest.mark.parametrize(
    ("heading", "expected"),
    [
        ("[tube.control]", "tube.control: stands in [tube]; write [control]"),
        ("[adaptive]", "adaptive: stands above the first table; write [tube.adaptive]"),
        ("[plant.unsafe]", "plant.unsafe: stands in [plant]; write [[unsafe]]"),
        ("[[tube]]", "tube: is a list; a table [tube] is needed"),
        ("[unsafe]", "unsafe: is a table; a list of tables [[unsafe]] is needed"),
    ],
)
def test_a_table_in_a_wrong_place_is_shown_as_it_is_written(heading: str, expected: str) -> None:
    assert refusal_of(BASE | {heading: "lower = [1, 1]\n"}).endswith(expected)


def misspelt(key: str) -> list[str]:
    """Return a key with capitals, with - for _, without its fourth letter and with its last letter twice."""
    return [key.upper(), key.replace("_", "-"), key[:3] + key[4:], key + key[-1]]


def test_a_misspelt_key_is_answered_with_the_known_one() -> None:
    wrong = []
    for table in TABLES.values():
        long_keys = [k for k in table.keys if len(k) > 4] if table.heading not in WITHIN else []
        for key, text in ((k, text) for k in long_keys for text in misspelt(k) if text not in table.keys):
            message = refusal_of(with_line(table.heading, f'"{text}" = 1\n'))
            if f"did you mean {key!r}" not in message and "; move it" not in message:
                wrong.append((text, message))
    assert wrong == []


@pytest.mark.parametrize("name", ["CON", "nul", "Aux", "prn", "com1", "LPT9"])
def test_a_task_has_no_name_that_windows_keeps_from_files(name: str) -> None:
    tables = BASE | {TOP: BASE[TOP].replace('"cart"', f'"{name}"')}
    assert refusal_of(tables).endswith(f"{name!r} is a device of Windows, where no file {name}.c can be; choose another")


@pytest.mark.parametrize(
    ("heading", "line", "answer"),
    [
        ("[tube]", "w_mx = 0.1\n", "tube.w_mx: unknown key; did you mean 'w_max', in [plant]?"),
        ("[control]", "Clearance = 0.1\n", "control.Clearance: unknown key; did you mean 'clearance', in [tube]?"),
        (TOP, "max-speed = 1\n", "'max-speed': unknown key; did you mean 'max_speed', in [tube]?"),
        ("[map]", 'fil = "hall.yaml"\n', "map.fil: unknown key; did you mean 'file'?"),
        ("[tube]", "fliter = 1\n", "tube.fliter: unknown key; did you mean 'filter'?"),
        ("[plant]", "wmax = 1\n", "plant.wmax: unknown key; did you mean 'w_max'?"),
        ("[map]", "resolution = 0.05\n", "map.resolution: unknown key; known keys here are file, axes, as, free"),
    ],
)
def test_the_nearest_key_may_be_of_another_table(heading: str, line: str, answer: str) -> None:
    assert refusal_of(with_line(heading, line)).endswith(answer)


@pytest.mark.parametrize("key", ["min", "max", "low", "top", "v", "pos", "rad", "tick", "norm"])
def test_a_short_key_is_not_called_a_misspelt_longer_one(key: str) -> None:
    """`min` has all its letters in `g_min`, and `motion` has them in order."""
    for heading in (heading for heading in TABLES if heading not in WITHIN):
        message = refusal_of(with_line(heading, f"{key} = 3\n"))
        suggestion = message.partition("did you mean '")[2].partition("'")[0]
        assert not suggestion or abs(len(suggestion) - len(key)) <= 1, message
