"""How long a search may take, once a task is refused as it stands."""

from stt_codegen.effort.effort import (
    CHANGES_SHARE,
    DEFAULT_SECONDS,
    TUBES_SHARE,
    Effort,
    EffortSpent,
    require_effort,
    without_limit,
)

__all__ = [
    "CHANGES_SHARE",
    "DEFAULT_SECONDS",
    "TUBES_SHARE",
    "Effort",
    "EffortSpent",
    "require_effort",
    "without_limit",
]
