"""Lemmas about held inputs: sampling conditions, the code that evaluates them, saturated inputs, bounds of plants."""

from stt_codegen.lemmas.sampling.sampled_exact import refusing_condition

__all__ = [
    "definite_plants",
    "first_exit",
    "refusing_condition",
    "sampled",
    "sampled_evaluated",
    "sampled_exact",
    "sampled_windows",
    "saturated",
    "worst_path_evaluated",
    "worst_path_theorem",
]
