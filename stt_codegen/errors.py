"""The one exception family. Every stage raises these; `cli.main` alone turns them into exit codes."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager


class SttError(Exception):
    """Anything the user can act on. The message says what was found, where, and what would be right."""

    exit_code = 5


class BadInput(SttError):
    """A task file, option or path that cannot be used (exit code 2)."""

    exit_code = 2


class NotCertified(SttError):
    """The task is infeasible, or the tube found does not satisfy its certificate (exit code 3)."""

    exit_code = 3


class MissingTool(SttError):
    """A tool outside the package is needed and absent (exit code 4)."""

    exit_code = 4


@contextmanager
def about(where: object) -> Iterator[None]:
    """Errors of the block begin with the file that they are about."""
    try:
        yield
    except SttError as error:
        raise type(error)(f"{where}: {error}") from None


@contextmanager
def noted(notes: Iterable[str]) -> Iterator[None]:
    """Errors of the block end with notes that may explain them."""
    try:
        yield
    except SttError as error:
        raise type(error)("; note: ".join([str(error), *notes])) from None
