"""The exceptions of the package. Every stage raises them; `cli.main` alone turns them into exit codes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import KW_ONLY, dataclass, replace
from fractions import Fraction


class SttError(Exception):
    """An error that the user can act on. The message says what is wrong, where, and what would be right."""

    exit_code = 5


class BadInput(SttError):
    """A task file, option or path that cannot be used (exit code 2)."""

    exit_code = 2


@dataclass(frozen=True)
class Reason:
    """Why a task is refused.

    problem: what is wrong, where, and the value found beside the value allowed. hint: what may help, where no remedy was tried.
    codes: of the properties that fail, such as "P9"; none where the cause is not known so exactly. axis: from 0, the one that
    fails; None for all or for another cause. has_remedy: False where no option of the task can help. sufficient: keys of the task
    with values that the search for a reason found to be enough. about: keys that the problem is about.
    """

    problem: str
    hint: str = ""
    _: KW_ONLY
    codes: tuple[str, ...] = ()
    axis: int | None = None
    has_remedy: bool = True
    sufficient: tuple[tuple[str, Fraction], ...] = ()
    about: tuple[str, ...] = ()


class NotCertified(SttError):
    """The task is infeasible, or the tube fails its certificate (exit code 3).

    The reason may be a function that works it out when someone reads it: a search that tries hundreds of tasks reads none.
    """

    exit_code = 3

    def __init__(self, reason: str | Reason | Callable[[], Reason]) -> None:
        super().__init__()
        self._reason: Reason | Callable[[], Reason] = Reason(reason) if isinstance(reason, str) else reason

    @property
    def reason(self) -> Reason:
        """The reason, worked out at the first reading."""
        if not isinstance(self._reason, Reason):
            try:
                self._reason = self._reason()
            except NotCertified as nearer:  # what explains the refusal is refused for a reason of its own
                self._reason = nearer.reason
        return self._reason

    def __str__(self) -> str:
        return "; ".join(part for part in (self.reason.problem, self.reason.hint) if part)

    def __repr__(self) -> str:
        return f"NotCertified({str(self)!r})"

    def __reduce__(self) -> tuple[type[NotCertified], tuple[Reason]]:
        """Go to another process as the reason, for a function cannot."""
        return NotCertified, (self.reason,)


class MissingTool(SttError):
    """A tool that does not come with the package is needed and not installed (exit code 4)."""

    exit_code = 4


@contextmanager
def about(where: object) -> Iterator[None]:
    """Put the file that they are about before the messages of errors in the block."""
    try:
        yield
    except NotCertified as refusal:
        raise NotCertified(replace(refusal.reason, problem=f"{where}: {refusal.reason.problem}")) from None
    except SttError as error:
        raise type(error)(f"{where}: {error}") from None


@contextmanager
def noted(notes: Iterable[str]) -> Iterator[None]:
    """Put notes that may explain them behind the messages of errors in the block."""
    try:
        yield
    except NotCertified as refusal:
        raise NotCertified(replace(refusal.reason, hint="; note: ".join([refusal.reason.hint, *notes]))) from None
    except SttError as error:
        raise type(error)("; note: ".join([str(error), *notes])) from None
