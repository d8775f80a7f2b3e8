"""How long the search for another way may take, once a task is refused as it stands.

A design is never cut short; what follows a refusal is. While an effort is the limit, `require_effort` raises `EffortSpent` when
its seconds are over. Solvers and proofs call it between their steps, so the search ends soon after. The proof of a change that
the search has found may take a little longer.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import KW_ONLY, dataclass, field
from typing import NamedTuple

from stt_codegen.errors import BadInput

DEFAULT_SECONDS = 10.0
# Of the seconds: until when other tubes are tried, when the search for changes of the task ends, and when the proof of a change
# that was found by then ends.
TUBES_SHARE, CHANGES_SHARE, PROOF_SHARE = 0.6, 0.8, 1.25
ANNOUNCEMENT_DELAY = 2.0  # seconds from the begin, after which a search says why it goes on
SHORTEST_ANNOUNCED = 1.0  # seconds: a search with less time than this left says nothing of it


class EffortSpent(Exception):
    """The seconds of an effort are over."""


@dataclass
class Effort:
    """The seconds that a command may take where its task is refused, from its begin; a design that is not refused takes what it
    takes.

    say: prints the first reason, and the seconds that are left, while the search goes on; None for silence. ends_on_interrupt:
    whether Ctrl-C ends the search with what is known, as on the command line; in Python the interrupt is the caller's. longer,
    as_it_is: how the caller asks for a longer search and for the tube as it is, which refusals name; empty where it cannot.
    """

    seconds: float = field(default_factory=lambda: DEFAULT_SECONDS)
    say: Callable[[str, float], None] | None = None
    _: KW_ONLY
    ends_on_interrupt: bool = False
    longer: str = ""
    as_it_is: str = ""
    _begin: float = field(default_factory=time.monotonic)
    _reason: str = ""
    _attempt_seconds: float = 0.0

    def __post_init__(self) -> None:
        """Raise `BadInput` where the seconds are no number of seconds."""
        if not isinstance(self.seconds, int | float) or not 0 <= self.seconds < math.inf:
            raise BadInput(f"effort: is {self.seconds!r:.40}; a number of seconds is needed, 0 or more")

    @property
    def elapsed(self) -> float:
        """Seconds since the begin."""
        return time.monotonic() - self._begin

    def begin_search(self, reason: str) -> None:
        """Note that the task is refused as it stands, by now: the reason is said once the search has lasted for a while.

        The seconds until now are what the proof of a change will take.
        """
        if not self._reason:
            self._reason, self._attempt_seconds = reason, self.elapsed

    @property
    def ends(self) -> tuple[type[BaseException], ...]:
        """The exceptions at which a search ends with what is known."""
        return (EffortSpent, KeyboardInterrupt) if self.ends_on_interrupt else (EffortSpent,)

    @contextmanager
    def limit(self, share: float) -> Iterator[None]:
        """Raise `EffortSpent` in `require_effort` once this share of the seconds is over, within the block."""
        with _limited(Limit(self, share * self.seconds)):
            yield

    @property
    def refinement_end(self) -> float:
        """Seconds from the begin, until which a change that was found may be made milder: then its proof needs what is left."""
        return min(CHANGES_SHARE * self.seconds, self.seconds - self._attempt_seconds)

    def check(self, limit: float) -> None:
        """Say the reason where it is time for that, and raise `EffortSpent` where so many seconds are over."""
        seconds = self.elapsed
        if self.say is not None and self._reason and seconds >= ANNOUNCEMENT_DELAY:
            if CHANGES_SHARE * self.seconds - seconds >= SHORTEST_ANNOUNCED:
                self.say(self._reason, self.seconds - seconds)
            self.say = None
        if seconds >= limit:
            raise EffortSpent


class Limit(NamedTuple):
    """When the search of an effort ends, in seconds from its begin."""

    effort: Effort
    seconds: float


_LIMIT: ContextVar[Limit | None] = ContextVar("limit of the search", default=None)


@contextmanager
def _limited(limit: Limit | None) -> Iterator[None]:
    before = _LIMIT.set(limit)
    try:
        yield
    finally:
        _LIMIT.reset(before)


def require_effort() -> None:
    """Raise `EffortSpent` where the search that this is a part of may not go on."""
    limit = _LIMIT.get()
    if limit is not None:
        limit.effort.check(limit.seconds)


def require_effort_for_proof() -> None:
    """Raise `EffortSpent` where what is left of the search is needed for the proof of what it has found."""
    limit = _LIMIT.get()
    if limit is not None:
        limit.effort.check(limit.effort.refinement_end)


@contextmanager
def proof_time() -> Iterator[None]:
    """Give the proof of what the search has found the time that is kept for it, within the block."""
    limit = _LIMIT.get()
    with _limited(None if limit is None else Limit(limit.effort, PROOF_SHARE * limit.effort.seconds)):
        yield
