"""The exceptions of the package. Every stage raises them; `cli.main` alone turns them into exit codes."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager


class SttError(Exception):
    """An error that the user can act on. The message says what is wrong, where, and what would be right."""

    exit_code = 5


class BadInput(SttError):
    """A task file, option or path that cannot be used (exit code 2)."""

    exit_code = 2


class NotCertified(SttError):
    """The task is infeasible, or the tube fails its certificate (exit code 3)."""

    exit_code = 3


class MissingTool(SttError):
    """A tool that does not come with the package is needed and not installed (exit code 4)."""

    exit_code = 4


@contextmanager
def about(where: object) -> Iterator[None]:
    """Put the file that they are about before the messages of errors in the block."""
    try:
        yield
    except SttError as error:
        raise type(error)(f"{where}: {error}") from None


@contextmanager
def noted(notes: Iterable[str]) -> Iterator[None]:
    """Put notes that may explain them behind the messages of errors in the block."""
    try:
        yield
    except SttError as error:
        raise type(error)("; note: ".join([str(error), *notes])) from None
