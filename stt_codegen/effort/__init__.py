"""How long a search may take, once a task is refused as it stands."""

from stt_codegen.effort.effort import (
    CHANGES_SHARE,
    DEFAULT_SECONDS,
    TUBES_SHARE,
    Effort,
    EffortSpent,
    proof_time,
    require_effort,
    require_effort_for_proof,
)

__all__ = [
    "CHANGES_SHARE",
    "DEFAULT_SECONDS",
    "TUBES_SHARE",
    "Effort",
    "EffortSpent",
    "proof_time",
    "require_effort",
    "require_effort_for_proof",
]
