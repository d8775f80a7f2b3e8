"""P9: whether a loop that is sampled at `control.period` stays in its tube, exactly."""

from stt_codegen.certify.sampled.period import certify_period, choose_gain

__all__ = ["certify_period", "choose_gain"]
