"""Several writers at once in one folder, some of them killed: a folder with a certificate has the whole set of one writer."""

from __future__ import annotations

import hashlib
import json
import os
import random
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from stt_codegen.errors import BadInput
from stt_codegen.files import locked, locks, write_files
from tests.support.controllers import ROOT

WRITERS = 3
FILES = ("cart.h", "cart.c", "cart.py", "sub/cart_guard.c")
CERTIFICATE = "cart.certificate.json"
ROUNDS = 25

# Writes sets of its own number until it is killed. The parent makes the file `go` when all have imported.
WRITER = """
import hashlib, json, sys, time
from pathlib import Path
from stt_codegen.files import write_files, locks
if sys.argv[3] == "file":
    locks.fcntl = None
folder, number = Path(sys.argv[1]), sys.argv[2]
FILES = ("cart.h", "cart.c", "cart.py", "sub/cart_guard.c")
print("ready", flush=True)
sys.stdin.readline()
for round in range(int(sys.argv[4])):
    files = {name: f"{number} {round} {name}\\n".encode() * 50 for name in FILES}
    hashes = {name: hashlib.sha256(data).hexdigest() for name, data in files.items()}
    write_files(folder, {"cart.certificate.json": json.dumps({"sha256": hashes}).encode(), **files})
"""


def start_writers(folder: Path, kind: str, rounds: int) -> list[subprocess.Popen[str]]:
    """Start processes that write sets, and let them begin at once. kind: of the lock, "folder" or "file"."""
    writers = [
        subprocess.Popen(
            [sys.executable, "-c", WRITER, str(folder), str(number), kind, str(rounds)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        for number in range(WRITERS)
    ]  # fmt: skip
    for writer in writers:
        assert writer.stdout is not None
        assert writer.stdout.readline() == "ready\n"
    for writer in writers:
        assert writer.stdin is not None
        writer.stdin.write("\n")
        writer.stdin.flush()
    return writers


def mixtures(folder: Path) -> Iterator[str]:
    """Yield the files that a certificate of the folder has, with another hash."""
    if (folder / CERTIFICATE).exists():
        for name, digest in json.loads((folder / CERTIFICATE).read_bytes())["sha256"].items():
            if hashlib.sha256((folder / name).read_bytes()).hexdigest() != digest:
                yield name


@pytest.mark.parametrize("kind", ["folder", "file"])
def test_writers_at_once_leave_the_whole_set_of_one(kind: str, tmp_path: Path) -> None:
    for number in range(2):
        folder = tmp_path / str(number)
        writers = start_writers(folder, kind, ROUNDS)
        assert [writer.wait(timeout=60) for writer in writers] == [0] * WRITERS
        assert (folder / CERTIFICATE).exists()
        assert list(mixtures(folder)) == []
        assert {path.name for path in folder.rglob("*") if path.is_file()} == {CERTIFICATE, *(Path(f).name for f in FILES)}


def test_writers_that_are_killed_leave_no_mixture_with_a_certificate(tmp_path: Path) -> None:
    """Killed one after the other at random moments; a lock ends with its process, so the others go on."""
    generator = random.Random(54)
    for number in range(8):
        folder = tmp_path / str(number)
        writers = start_writers(folder, "folder", 10_000)
        for writer in writers:
            time.sleep(generator.uniform(0.0, 0.15))
            writer.kill()
            writer.wait()
        assert list(mixtures(folder)) == []
        write_files(folder, {CERTIFICATE: b'{"sha256": {}}', **dict.fromkeys(FILES, b"last")})
        assert not list(folder.rglob(".*"))


def test_commands_at_once_record_all_their_tasks(tmp_path: Path) -> None:
    """The manifest is read and written again by each; none may lose the entry of another."""
    names = ("empty", "omni_s1", "omni_s3")
    commands = [
        subprocess.Popen(
            [sys.executable, "-m", "stt_codegen.cli", "generate", str(ROOT / "tasks" / f"{name}.toml"), "--record", "out"],
            cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        for name in names
    ]  # fmt: skip
    assert [command.wait(timeout=120) for command in commands] == [0] * len(names)
    assert {folder.split("/")[0] for folder in json.loads((tmp_path / "out" / "MANIFEST.json").read_bytes())["folders"]} == set(
        names
    )


@pytest.mark.parametrize("kind", ["folder", "file"])
def test_a_writer_that_does_not_end_is_waited_for_and_then_one_message(kind: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(locks, "WAIT_LIMIT", 0.2)
    if kind == "file":
        monkeypatch.setattr(locks, "fcntl", None)
    messages: list[str] = []

    def write() -> None:
        try:
            write_files(tmp_path, {"cart.c": b"second"})
        except BadInput as error:
            messages.append(str(error))

    with locked([tmp_path]):
        write_files(tmp_path, {"cart.c": b"first"})  # the thread that has the lock may write
        second_writer = threading.Thread(target=write)
        second_writer.start()
        second_writer.join()
    assert len(messages) == 1
    assert "another command has been writing here" in messages[0]
    assert (locks.LOCK_FILE in messages[0]) == (kind == "file")
    assert (tmp_path / "cart.c").read_bytes() == b"first"
    write_files(tmp_path, {"cart.c": b"third"})
    assert [path.name for path in tmp_path.iterdir()] == ["cart.c"]


def test_folders_are_locked_in_one_order_whatever_links_lead_to_them(tmp_path: Path, monkeypatch) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    for folder, link in ((first, "y"), (second, "x")):
        folder.mkdir()
        (tmp_path / link).symlink_to(folder)
    order: list[Path] = []
    monkeypatch.setattr(locks, "_lock", lambda folder, _: order.append(folder.resolve()) or (lambda: None))
    for folders in ([first, second], [tmp_path / "x", tmp_path / "y"], [tmp_path / "x", first]):
        order.clear()
        with locked(folders):
            assert order == [first, second]


def test_what_is_no_file_is_not_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.c")
    (tmp_path / "b.c").mkdir()
    (tmp_path / "c.c").symlink_to(tmp_path / "nowhere")
    for name in ("a.c", "b.c"):
        with pytest.raises(BadInput, match=f"{name}: is no file"):
            write_files(tmp_path, {"other.c": b"", name: b"new"})
    write_files(tmp_path, {"c.c": b"new"})  # a link to nothing is replaced by the file
    assert {path.name for path in tmp_path.iterdir()} == {"a.c", "b.c", "c.c"}
    assert not (tmp_path / "c.c").is_symlink()
