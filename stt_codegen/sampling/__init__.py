"""What held inputs, late samples, noise and limits do to a tube: bounds of plants, time windows, statements, periods, gains."""

from stt_codegen.sampling.gains import Gains, most_room
from stt_codegen.sampling.inertia import difference_age, eps_of_starts, inertial_law, inertial_setting, speeds
from stt_codegen.sampling.periods import Period, holds, least, longest
from stt_codegen.sampling.plant import Bounds, PlantEnclosure, bounds_of_task
from stt_codegen.sampling.setting import Law, Setting, eps_of_share, eps_of_state, law_of, setting_of
from stt_codegen.sampling.statements import STATEMENTS, input_bound, pull, q
from stt_codegen.sampling.windows import Windows, extremes, refined_windows

__all__ = [
    "STATEMENTS", "Bounds", "Gains", "Law", "Period", "PlantEnclosure", "Setting", "Windows", "bounds_of_task",
    "difference_age",
    "eps_of_share", "eps_of_starts", "eps_of_state", "extremes", "holds", "inertial_law", "inertial_setting", "input_bound",
    "law_of", "least", "longest", "most_room", "pull", "q", "refined_windows", "setting_of", "speeds",
]  # fmt: skip
