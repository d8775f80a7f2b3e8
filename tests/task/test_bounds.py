"""Bounds on what is read hold before it is parsed, and no string, comment or large task that is good meets them."""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import threading
import time
import tomllib
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stt_codegen.checker import FOLDER
from stt_codegen.checker.stt_checker import bounds
from stt_codegen.checker.stt_checker.exact import Unusable
from stt_codegen.errors import BadInput
from stt_codegen.files import bounded_reading, parse_json_object, parse_toml, read_input
from stt_codegen.files.bounded_toml import DEPTH_LIMIT, KEYS_LIMIT, PARTS_LIMIT, TABLES_LIMIT, WORD_LIMIT, require_bounded
from stt_codegen.files.task_text import TASK_SIZE_LIMIT
from stt_codegen.task import load_task
from stt_codegen.task.values import MAX_DIGITS
from tests.support.controllers import ROOT

SECONDS = 5.0  # of the processor, on any machine

# Beyond a bound, with a part of the message. Each is refused before it is parsed, within a second.
BEYOND = {
    "a dotted key": ("a." * 30_000 + "b = 1", "line 1: has a key of more than 16 parts"),
    "a dotted key with quotes": ('"a" . ' * 30_000 + "b = 1", "key of more than 16 parts"),
    "a dotted key with other quotes": ("'a'.\"b\"." * 9 + "b = 1", "key of more than 16 parts"),
    "a dotted header": ("x = 1\n[" + "a." * 30_000 + "b]", "line 2: has a key of more than 16 parts"),
    "a dotted key in a table": ("x = {" + "a." * 30_000 + "b = 1}", "key of more than 16 parts"),
    "a dotted key after strings": ("x = '''\n[[[\n'''\ny = \"#\" # '\n" + "a." * 30_000 + "b = 1", "line 5: has a key"),
    "lists": ("\n\nx = " + "[" * 100_000, "line 3: is nested more than 16 deep"),
    "tables": ("x = " + "{a = " * 100_000, "is nested more than 16 deep"),
    "digits": ("x = " + "1" * 1_000_000, "a number or a key of more than 1,000 characters"),
    "a hexadecimal number": ("x = 0x" + "f" * 3_000_000, "more than 1,000 characters"),
    "headers": ("[[unsafe]]\n" * 100_000, "line 50001: comes after 50,000 tables"),
    "inline tables": ("x = [" + "{}," * 100_000 + "]", "comes after 50,000 tables"),
    "keys": ("".join(f"a{i} = 1\n" for i in range(250_000)), "line 200001: comes after 200,000 keys"),
}  # fmt: skip

# The checker bounds the parts of a dotted key alone: the parser answers to all else soon.

# At a bound, or with what looks like more in strings and comments.
WITHIN = {
    "a string": 'x = "' + "a." * 30_000 + "[" * 1000 + "{" * 100_000 + "=" * 300_000 + '"',
    "a literal string": "x = '" + "a." * 30_000 + "[" * 1000 + "\\'",
    "a long string": 'x = """' + 'a."b"' * 30_000 + "[\n" * 100_000 + '\\""""""',
    "a long string that ends in five quotes": 'x = """a"""""\ny = "' + "a." * 100 + '"',
    "a long literal string": "x = '''" + "''a.''b" * 30_000 + "[\n" * 100_000 + "'''''",
    "an empty string": 'x = ""\ny = "' + "a." * 100 + '"',
    "a comment": "#" + "a." * 30_000 + "\"'''[[[" * 1000 + "\nx = 1",
    "a key": ".".join("abcdefghijklmnop") + " = 1",
    "decimals": "x = [" + "0.5, " * 100_000 + "]",
    "depth": "x = " + "[" * 16 + "]" * 16,
    "2,000 boxes": '[[unsafe]]\nname = "box"\nlower = [0.1, 0.2]\nupper = [0.3, 0.4]\n' * 2_000,
    "10,000 polygons": "[[unsafe]]\nvertices = [\n    [0.1, 0.2],\n    [0.3, 0.4],\n    [0.1, 0.9],\n]\n" * 10_000,
}


@pytest.mark.parametrize("name", BEYOND)
def test_a_text_beyond_a_bound_is_refused_before_it_is_parsed(name: str, monkeypatch) -> None:
    text, message = BEYOND[name]
    monkeypatch.setattr(tomllib, "loads", lambda *_, **__: pytest.fail("was parsed"))
    begin = time.process_time()
    with pytest.raises(BadInput, match=message.replace(".", r"\.")):
        parse_toml(text)
    if "dotted" in name:
        with pytest.raises(Unusable, match="a dotted key of more than 16 parts"):
            bounds.require_bounded(text)
    assert time.process_time() - begin < SECONDS


@pytest.mark.parametrize("name", BEYOND)
def test_the_checker_turns_a_text_beyond_a_bound_away_soon(name: str, tmp_path: Path) -> None:
    """In at most a gigabyte, of which a process of its own is given two."""
    (tmp_path / "task.toml").write_text(BEYOND[name][0])
    command = [sys.executable, "-I", str(FOLDER), *["task.toml"] * 3]
    begin = time.monotonic()
    limit = (2_000_000_000, 2_000_000_000)
    result = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limit),
    )  # fmt: skip
    assert result.returncode == 2
    assert result.stderr.startswith("checker: cannot check: ")
    assert "MemoryError" not in result.stderr
    assert time.monotonic() - begin < 4 * SECONDS  # of the wall, on a machine that is busy


@pytest.mark.parametrize("name", WITHIN)
def test_a_text_within_the_bounds_is_read(name: str) -> None:
    begin = time.process_time()
    require_bounded(WITHIN[name])
    bounds.require_bounded(WITHIN[name])
    assert time.process_time() - begin < SECONDS
    if name != "10,000 polygons":  # the parser takes seconds
        assert parse_toml(WITHIN[name])


CONTENT = st.lists(st.sampled_from(['"', "'", '""', "''", "\\\\", '\\"', "#", "a.a", "[", "\n", " "]), max_size=6).map("".join)
STRINGS = st.builds(lambda quote, content: quote + content + quote, st.sampled_from(['"', "'", '"""', "'''"]), CONTENT)
LINES = st.lists(
    st.one_of(STRINGS, STRINGS.map(lambda text: f"[{text}] # {text[:3]}"), STRINGS.map(lambda text: f"1 # {text!r}")), max_size=4
)


@settings(max_examples=200, deadline=None)
@given(
    LINES.map(lambda values: "".join(f"k{k} = {value}\n" for k, value in enumerate(values))),
    st.sampled_from(["a." * 40 + "b=1", "a=" + "[" * 40, "b=" + "1" * 1200]),
)
@example('x=""""""\n', "a." * 40 + "b=1")
@example('x="""a""""\n', "a." * 40 + "b=1")
@example("x='''a''''\n", "a." * 40 + "b=1")
def test_what_the_parser_reads_is_never_beyond_a_bound_that_was_not_seen(prefix: str, bomb: str) -> None:
    """Python's parser is the oracle: where it reads a good text before the bomb, it is seen; a dotted key by the checker too."""
    try:
        tomllib.loads(prefix)
    except (tomllib.TOMLDecodeError, ValueError, RecursionError):
        return
    with pytest.raises(BadInput):
        require_bounded(f"{prefix}\n{bomb}\n")
    if bomb.startswith("a."):
        with pytest.raises(Unusable):
            bounds.require_bounded(f"{prefix}\n{bomb}\n")


def depth_of(value: object) -> int:
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return 1 + max(map(depth_of, inner), default=0) if isinstance(value, dict | list) else 0


def numbers_in(value: object) -> Iterator[Decimal]:
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from numbers_in(inner)
    if isinstance(value, int | Decimal) and not isinstance(value, bool):
        yield Decimal(value)


def test_the_tasks_of_the_repository_use_at_most_half_of_each_bound() -> None:
    """As docs/inputs.md says. A part between signs is no shorter than a word, and a line has no fewer dots than its key."""
    paths = sorted(ROOT.rglob("tasks/*.toml"))
    assert len(paths) > 20
    for path in paths:
        text = path.read_text()
        document = tomllib.loads(text, parse_float=Decimal)
        numbers = [number for number in numbers_in(document) if number]
        assert 2 * len(text.encode()) <= TASK_SIZE_LIMIT
        assert 2 * depth_of(document) <= DEPTH_LIMIT
        assert 2 * text.count("[") <= TABLES_LIMIT
        assert 2 * text.count("=") <= KEYS_LIMIT
        assert 2 * max(map(len, re.split(r"[\s,=]", text))) <= WORD_LIMIT
        assert 2 * max(line.partition("=")[0].count(".") + 1 for line in text.splitlines() if line[:1] != "#") <= PARTS_LIMIT
        assert 2 * max(len(number.as_tuple().digits) for number in numbers) <= MAX_DIGITS
        assert 2 * Decimal("1e-9") <= min(map(abs, numbers)) <= max(map(abs, numbers)) <= Decimal("1e9") / 2
        assert load_task(path).name == document["name"]
    assert PARTS_LIMIT == bounds.PARTS


@pytest.mark.parametrize("is_open", [True, False], ids=["a writer that is slow to write", "a writer that is slow to come"])
def test_a_pipe_is_read_whole(is_open: bool, tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    data = (ROOT / "tasks" / "empty.toml").read_bytes()
    keeper = os.open(pipe, os.O_RDWR) if is_open else None

    def write_late() -> None:
        time.sleep(0.3)
        pipe.write_bytes(data)
        if keeper is not None:
            os.close(keeper)

    writer = threading.Thread(target=write_late)
    writer.start()
    assert load_task(pipe).name == "empty"
    writer.join()


def test_an_anonymous_pipe_whose_writer_has_left_is_read_at_once() -> None:
    """As those of <(command) and of a pipe to /dev/stdin."""
    for data in (b"", b"x"):
        reader, writer = os.pipe()
        os.write(writer, data)
        os.close(writer)
        begin = time.monotonic()
        assert read_input(Path(f"/dev/fd/{reader}"), 10, "") == data
        assert time.monotonic() - begin < SECONDS
        os.close(reader)


def test_a_device_a_folder_and_a_path_with_a_nul_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="/dev/zero: has more than 4,000,000 bytes"):
        load_task("/dev/zero")
    with pytest.raises(BadInput, match="Is a directory"):
        load_task(tmp_path)
    with pytest.raises(BadInput, match="no such path"):
        load_task("a\0b")


@pytest.mark.parametrize("is_open", [True, False], ids=["a writer that writes nothing", "no writer"])
def test_a_pipe_through_which_nothing_comes_is_given_up(is_open: bool, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(bounded_reading, "PIPE_WAIT_LIMIT", 0.1)
    os.mkfifo(tmp_path / "pipe")
    keeper = os.open(tmp_path / "pipe", os.O_RDWR) if is_open else None
    with pytest.raises(BadInput, match="nothing came for"):
        read_input(tmp_path / "pipe", 10, "")
    if keeper is not None:
        os.close(keeper)


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 100_000, "[]", "3", "", "{", "\xff", '{"a": ' + "1" * 5000 + "}"])
def test_json_that_is_no_object_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError, match=".*"):
        parse_json_object(text.encode("latin-1"))
