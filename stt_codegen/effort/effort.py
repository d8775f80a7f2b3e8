"""How long the search for another way may take, once a task is refused as it stands.

A design is never cut short; what follows a refusal is. While an effort is the limit, `require_effort` raises `EffortSpent` when
its seconds are over. Solvers and proofs call it between their steps, so the search ends soon after.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import KW_ONLY, dataclass, field

from stt_codegen.errors import BadInput

DEFAULT_SECONDS = 10.0
# Of the seconds: until when other tubes are tried, and when the search for changes of the task ends. The rest is for the steps
# that are begun by then.
TUBES_SHARE, CHANGES_SHARE = 0.6, 0.8
ANNOUNCEMENT_DELAY = 2.0  # seconds from the begin, after which a search says why it goes on


class EffortSpent(Exception):
    """The seconds of an effort are over."""


@dataclass
class Effort:
    """The seconds that a command may take where its task is refused, from its begin; a design that is not refused takes what it
    takes.

    say: prints the first reason while the search goes on; None for silence. ends_on_interrupt: whether Ctrl-C ends the search
    with what is known, as on the command line; in Python the interrupt is the caller's. longer, as_it_is: how the caller asks for
    a longer search and for the tube as it is, which refusals name; empty where it cannot.
    """

    seconds: float = field(default_factory=lambda: DEFAULT_SECONDS)
    say: Callable[[str], None] | None = None
    _: KW_ONLY
    ends_on_interrupt: bool = False
    longer: str = ""
    as_it_is: str = ""
    _begin: float = field(default_factory=time.monotonic)
    _reason: Callable[[], str] | None = None

    def __post_init__(self) -> None:
        """Raise `BadInput` where the seconds are no number of seconds."""
        if not isinstance(self.seconds, int | float) or not 0 <= self.seconds < math.inf:
            raise BadInput(f"effort: is {self.seconds!r:.40}; a number of seconds is needed, 0 or more")

    @property
    def elapsed(self) -> float:
        """Seconds since the begin."""
        return time.monotonic() - self._begin

    def announce_later(self, reason: Callable[[], str]) -> None:
        """Say the reason once, as soon as the search has lasted for a while."""
        self._reason = self._reason or reason

    @property
    def ends(self) -> tuple[type[BaseException], ...]:
        """The exceptions at which a search ends with what is known."""
        return (EffortSpent, KeyboardInterrupt) if self.ends_on_interrupt else (EffortSpent,)

    @contextmanager
    def limit(self, share: float) -> Iterator[None]:
        """Raise `EffortSpent` in `require_effort` once this share of the seconds is over, within the block."""
        before = _CHECK.set(lambda: self._check(share * self.seconds))
        try:
            yield
        finally:
            _CHECK.reset(before)

    def _check(self, limit: float) -> None:
        seconds = self.elapsed
        if self.say is not None and self._reason is not None and seconds >= ANNOUNCEMENT_DELAY:
            say, reason, self.say = self.say, self._reason, None
            with without_limit():
                say(reason())
        if seconds >= limit:
            raise EffortSpent


_CHECK: ContextVar[Callable[[], None] | None] = ContextVar("check of the effort", default=None)


def require_effort() -> None:
    """Raise `EffortSpent` where the search that this is a part of may not go on."""
    check = _CHECK.get()
    if check is not None:
        check()


@contextmanager
def without_limit() -> Iterator[None]:
    """Let what is begun come to its end, within the block."""
    before = _CHECK.set(None)
    try:
        yield
    finally:
        _CHECK.reset(before)
