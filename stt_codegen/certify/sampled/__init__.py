"""P9: whether a loop that is sampled at `control.period` stays in its tube, exactly."""

from stt_codegen.certify.sampled.control_choice import choose_control, is_any_control_proved
from stt_codegen.certify.sampled.late_inputs import drive_words
from stt_codegen.certify.sampled.period import certify_period

__all__ = ["certify_period", "choose_control", "drive_words", "is_any_control_proved"]
