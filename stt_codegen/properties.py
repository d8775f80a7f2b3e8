"""The ten properties that a certificate shows: code, word and sentence, the unit of its margin, and what mends a failure.

Whoever speaks of a property takes it from here. A message has its `label`, the word and then the code: "period (P9)".
"""

from __future__ import annotations

from enum import Enum

LENGTH, RATE, SECONDS = "the task's unit of length", "the task's unit of length a second", "s"


class Property(Enum):
    """One property. code: as certificates spell it. sentence: what it says, for any task. unit: of the margin, where a finding
    does not say otherwise. advice: what mends a failure, where a finding has no better advice."""

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
        "P7", "arithmetic", "The emitted arithmetic moves no edge by more than the other properties have to spare.", LENGTH,
        "shift the origin near the task, or raise prescribed_time",
    )  # fmt: skip
    LIMITS = (
        "P8", "limits", "An input within control.u_max outdoes all that [plant] allows to push.", RATE,
        "raise control.u_max or prescribed_time, or state a milder plant",
    )  # fmt: skip
    PERIOD = (
        "P9", "period", "Sampled every control.period, the state stays in the tube under every plant within [plant].", SECONDS,
        "lower control.period, or raise control.u_max",
    )  # fmt: skip
    MISSION = (
        "P10", "mission", "Every x(t) that stays in the tube carries out the mission.", LENGTH,
        "design the tube again, widen the regions or the windows, or lower tube.min_width",
    )  # fmt: skip

    def __init__(self, code: str, word: str, sentence: str, unit: str, advice: str) -> None:
        self.code, self.word, self.sentence, self.unit, self.advice = code, word, sentence, unit, advice

    @property
    def label(self) -> str:
        """What messages call it: the word, then the code in brackets."""
        return self.label_of(self.word)

    def label_of(self, word: str) -> str:
        """A message's word for a part of it, then the code in brackets: "speed (P6)"."""
        return f"{word} ({self.code})"


OF_THE_EDGES = (Property.WIDTH, Property.START, Property.STAY, Property.AVOID, Property.REACH, Property.MISSION)
"""The properties that must have room for what the arithmetic moves an edge by."""
