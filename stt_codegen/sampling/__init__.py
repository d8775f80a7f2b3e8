"""Sampled control in a tube: bounds on plants, time windows, sampling conditions, proved periods and gains."""

from stt_codegen.sampling.continuous import continuous_input_bound, epsilon_star, epsilon_star_norm, holds_saturated, holds_scaled
from stt_codegen.sampling.gains import (
    WORTHWHILE_PERIOD_RATIO,
    GainChoice,
    Gains,
    balancing_gain,
    choose_proved_gain,
    longest_proved_period_from,
    rounded_gain,
)
from stt_codegen.sampling.loops import condition_kinds_of, exact_loop, loop_of, start_bound_of_task
from stt_codegen.sampling.numbers import FRACTIONS, Fractions
from stt_codegen.sampling.order_two import (
    KNOWN_AGE_FACTOR,
    filtered_extremes,
    inertial_motion,
    inertial_start_bound,
    velocity_bounds,
)
from stt_codegen.sampling.periods import Period, inputs_where_proved, longest_proved_period, prove_for_period
from stt_codegen.sampling.plant import Bounds, PlantEnclosure, bounds_of_task, minimum_eigenvalue
from stt_codegen.sampling.sampled_loop import (
    ROUNDING,
    SampledLaw,
    SampledLoop,
    first_order_loop,
    in_balls,
    in_doubles,
    law_of,
    start_bound_of_share,
    worst_with_previous_window,
)
from stt_codegen.sampling.sampling_conditions import (
    SAMPLING_CONDITIONS,
    distances_at_sample,
    drift_of_sample,
    emitted_input,
    measured_distances,
    sharp_closing_speed,
    weakest_effect,
)
from stt_codegen.sampling.windows import Windows, extremes, refined_windows

__all__ = [
    "FRACTIONS",
    "KNOWN_AGE_FACTOR",
    "ROUNDING",
    "SAMPLING_CONDITIONS",
    "WORTHWHILE_PERIOD_RATIO",
    "Bounds",
    "Fractions",
    "GainChoice",
    "Gains",
    "Period",
    "PlantEnclosure",
    "SampledLaw",
    "SampledLoop",
    "Windows",
    "balancing_gain",
    "bounds_of_task",
    "choose_proved_gain",
    "condition_kinds_of",
    "continuous_input_bound",
    "distances_at_sample",
    "drift_of_sample",
    "emitted_input",
    "epsilon_star",
    "epsilon_star_norm",
    "exact_loop",
    "extremes",
    "filtered_extremes",
    "first_order_loop",
    "holds_saturated",
    "holds_scaled",
    "in_balls",
    "in_doubles",
    "inertial_motion",
    "inertial_start_bound",
    "inputs_where_proved",
    "law_of",
    "longest_proved_period",
    "longest_proved_period_from",
    "loop_of",
    "measured_distances",
    "minimum_eigenvalue",
    "prove_for_period",
    "refined_windows",
    "rounded_gain",
    "sampling_conditions",
    "sharp_closing_speed",
    "start_bound_of_share",
    "start_bound_of_task",
    "velocity_bounds",
    "weakest_effect",
    "worst_with_previous_window",
]
