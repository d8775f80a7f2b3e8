"""The ten properties of a certificate: code, word and sentence, the unit of the margin, and advice against a failure.

All other files take a property's code and words from here. A message has its `label`, the word and then the code: "period (P9)".
"""

from __future__ import annotations

from enum import Enum

LENGTH, RATE, SECONDS = "the task's unit of length", "the task's unit of length a second", "s"


class Property(Enum):
    """One property.

    code: its name in certificates. word: its name in messages. sentence: its meaning, for any task. unit: of the margin, unless a
    finding has another one. advice: a remedy for a failure, unless a finding has a better one.
    """

    WIDTH = (
        "P1", "width", "The tube is nowhere narrower than tube.min_width.", LENGTH,
        "lower tube.min_width, or leave tube.segments out so that a finer tube is tried",
    )  # fmt: skip
    START = (
        "P2", "start", "The tube starts inside initial_set, around initial_state.", LENGTH,
        "move initial_state inside the initial set",
    )  # fmt: skip
    STAY = (
        "P3", "stay", "The tube stays in state_space.", LENGTH,
        "enlarge the state space there, or design the tube again",
    )  # fmt: skip
    AVOID = (
        "P4", "avoid", "The tube keeps tube.clearance from every unsafe set.", LENGTH,
        "lower tube.clearance or tube.min_width, or move the unsafe set",
    )  # fmt: skip
    REACH = "P5", "reach", "The tube is inside target_set at prescribed_time.", LENGTH, "widen the target set"
    SMOOTH = (
        "P6", "smooth", "The tube has no jumps, and bounded rates.", RATE,
        "raise tube.max_speed, tube.max_acceleration or prescribed_time",
    )  # fmt: skip
    ARITHMETIC = (
        "P7", "arithmetic", "The emitted arithmetic moves no edge by more than the margins of the other properties.", LENGTH,
        "shift the origin near the task, or raise prescribed_time",
    )  # fmt: skip
    LIMITS = (
        "P8", "limits", "An input within control.u_max outweighs all disturbances that [plant] allows.", RATE,
        "raise control.u_max or prescribed_time, or state a milder plant",
    )  # fmt: skip
    PERIOD = (
        "P9", "period", "Sampled every control.period, the state stays in the tube under every plant within [plant].", SECONDS,
        "lower control.period",
    )  # fmt: skip
    MISSION = (
        "P10", "mission", "Every x(t) that stays in the tube carries out the mission.", LENGTH,
        "design the tube again, widen the regions or the windows, or lower tube.min_width",
    )  # fmt: skip

    def __init__(self, code: str, word: str, sentence: str, unit: str, advice: str) -> None:
        self.code, self.word, self.sentence, self.unit, self.advice = code, word, sentence, unit, advice

    @property
    def label(self) -> str:
        """Its name in messages: the word, then the code in brackets."""
        return self.label_of(self.word)

    def label_of(self, word: str) -> str:
        """Return a message's word for a part of the property, then the code in brackets: "speed (P6)"."""
        return f"{word} ({self.code})"


OF_THE_EDGES = (Property.WIDTH, Property.START, Property.STAY, Property.AVOID, Property.REACH, Property.MISSION)
"""The properties that need a margin for the arithmetic's error of an edge."""

OF_THE_INPUT = frozenset({Property.LIMITS, Property.PERIOD})
"""The properties that say that the input is strong enough; the tube itself may be certified without them."""
