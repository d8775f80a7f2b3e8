"""What held inputs, late samples, noise and limits do to a tube: bounds of plants, time windows, statements, periods, gains."""

from stt_codegen.sampling.continuous import effort, epsilon_star, epsilon_star_norm, holds_saturated, holds_scaled
from stt_codegen.sampling.gains import MUCH, Gains, longest_from, most_room, natural_gain, rounded_gain
from stt_codegen.sampling.loops import eps_of_states, exact_loop, loop_of, statements_of
from stt_codegen.sampling.numbers import FRACTIONS, Fractions
from stt_codegen.sampling.order_two import BEYOND, extent, inertial_motion, speeds, start_reach
from stt_codegen.sampling.periods import Period, inputs_where_proved, least, longest
from stt_codegen.sampling.plant import Bounds, PlantEnclosure, bounds_of_task, least_eigenvalue
from stt_codegen.sampling.setting import ROUNDING, Law, Setting, back, in_balls, law_of, reach_of_starts, setting_of
from stt_codegen.sampling.statements import STATEMENTS, emitted_input
from stt_codegen.sampling.windows import Windows, extremes, refined_windows

__all__ = [
    "BEYOND",
    "FRACTIONS",
    "MUCH",
    "ROUNDING",
    "STATEMENTS",
    "Bounds",
    "Fractions",
    "Gains",
    "Law",
    "Period",
    "PlantEnclosure",
    "Setting",
    "Windows",
    "back",
    "bounds_of_task",
    "effort",
    "emitted_input",
    "eps_of_states",
    "epsilon_star",
    "epsilon_star_norm",
    "exact_loop",
    "extent",
    "extremes",
    "holds_saturated",
    "holds_scaled",
    "in_balls",
    "inertial_motion",
    "inputs_where_proved",
    "law_of",
    "least",
    "least_eigenvalue",
    "longest",
    "longest_from",
    "loop_of",
    "most_room",
    "natural_gain",
    "reach_of_starts",
    "refined_windows",
    "rounded_gain",
    "setting_of",
    "speeds",
    "start_reach",
    "statements",
    "statements_of",
]
