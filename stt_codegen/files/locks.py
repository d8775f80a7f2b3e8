"""One writer at a time in a folder: a lock on the folder itself. It ends with its process, and leaves no file.

Where the system has no such lock (no `fcntl`, or a network file system without it), a writer makes the file `.stt_codegen.lock`
in the folder and removes it. One that is killed leaves it there; the message of the next writer says so. writing.py and
record/manifest.py call `locked`.
"""

from __future__ import annotations

import errno
import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

from stt_codegen.errors import BadInput

fcntl: Any
try:
    import fcntl
except ImportError:  # not a POSIX system
    fcntl = None

WAIT_LIMIT = 30.0  # seconds for which a writer waits
PAUSE = 0.05  # seconds between two attempts
LOCK_FILE = ".stt_codegen.lock"
BUSY = (errno.EAGAIN, errno.EACCES)

Identity = tuple[int, int]  # device and inode of a folder


class _LockedFolders(threading.local):
    """The folders that this thread has locked; it may lock them again."""

    def __init__(self) -> None:
        self.identities: set[Identity] = set()


_locked_folders = _LockedFolders()


@contextmanager
def locked(folders: Iterable[Path]) -> Iterator[None]:
    """Make the folders, and keep other writers out of them until the block ends.

    Raises `BadInput` where a folder cannot be made, or another writer does not end within `WAIT_LIMIT`. All writers lock in the
    order of the paths without links, a folder before those in it, so that no two wait for each other.
    """
    deadline = time.monotonic() + WAIT_LIMIT
    with ExitStack() as locks:
        for folder in sorted(set(folders), key=os.path.realpath):
            try:
                release = _lock(folder, deadline)
            except OSError as error:
                raise BadInput(f"{folder}: cannot be written ({error.strerror}); choose another folder") from None
            locks.callback(release)
        yield


def _lock(folder: Path, deadline: float) -> Callable[[], None]:
    """Lock a folder, and return what releases it."""
    while True:
        folder.mkdir(parents=True, exist_ok=True)
        identity = _identity(os.stat(folder))
        if identity in _locked_folders.identities:
            return lambda: None
        unlock = _try_lock(folder)
        if unlock is not None:
            with suppress(OSError):
                if _identity(os.stat(folder)) == identity:  # else another writer has removed the folder meanwhile
                    _locked_folders.identities.add(identity)
                    return partial(_release, identity, unlock)
            unlock()
        if time.monotonic() > deadline:
            leftover = f"; if no other runs, remove {folder / LOCK_FILE}" if (folder / LOCK_FILE).exists() else ""
            raise BadInput(
                f"{folder}: another command has been writing here for {WAIT_LIMIT:.0f} s; wait for its end, or choose another "
                f"folder{leftover}"
            )
        time.sleep(PAUSE)


def _release(identity: Identity, unlock: Callable[[], None]) -> None:
    _locked_folders.identities.discard(identity)
    unlock()


def _identity(status: os.stat_result) -> Identity:
    return status.st_dev, status.st_ino


def _try_lock(folder: Path) -> Callable[[], None] | None:
    """Lock a folder and return what unlocks it; None where another writer has it."""
    if fcntl is None:
        return _try_lock_file(folder)
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(descriptor)
        return None if error.errno in BUSY else _try_lock_file(folder)

    def unlock() -> None:
        fcntl.flock(descriptor, fcntl.LOCK_UN)  # closing is not enough where a child process has the descriptor too
        os.close(descriptor)

    return unlock


def _try_lock_file(folder: Path) -> Callable[[], None] | None:
    """Make the lock file of a folder and return what removes it; None where it exists."""
    path = folder / LOCK_FILE
    try:
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY))
    except FileExistsError:
        return None
    return lambda: path.unlink(missing_ok=True)
