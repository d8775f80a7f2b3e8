"""The worst path: sampling, latency, lag, slew and overshoot proved by one falling curve, in whole numbers and without NumPy.

docs/sampling-path.md has the theorem and its proof.
"""

from stt_codegen.sampling.path.drive_response import Drive, DriveCells
from stt_codegen.sampling.path.integer_logarithm import LOG_BITS, log_bounds
from stt_codegen.sampling.path.path_gain import (
    PROVED_FACTORS,
    PathGain,
    choose_path_gain,
    proved_disturbance_factor,
    proved_drive_factor,
    proved_period_factor,
    reserve_of_gain,
    resting_gain,
    with_gain,
)
from stt_codegen.sampling.path.path_proof import PathProof, prove_path, prove_path_for
from stt_codegen.sampling.path.path_search import longest_path_period
from stt_codegen.sampling.path.path_windows import ComponentLaw, PathLoop, WindowBounds
from stt_codegen.sampling.path.worst_path import PathBounds, Start, WorstPath, follow_worst_path

__all__ = [
    "LOG_BITS",
    "PROVED_FACTORS",
    "ComponentLaw",
    "Drive",
    "DriveCells",
    "PathBounds",
    "PathGain",
    "PathLoop",
    "PathProof",
    "Start",
    "WindowBounds",
    "WorstPath",
    "choose_path_gain",
    "follow_worst_path",
    "log_bounds",
    "longest_path_period",
    "prove_path",
    "prove_path_for",
    "proved_disturbance_factor",
    "proved_drive_factor",
    "proved_period_factor",
    "reserve_of_gain",
    "resting_gain",
    "with_gain",
]
