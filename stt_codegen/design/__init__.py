"""The search for the numbers of a tube. `refine` is the map of the refined design; the paper's tubes are in paper_tubes/.

Large because a tube is searched for in five kinds of space: routes, time, missions, linear programs, the paper's functions.
"""

from stt_codegen.design.lattice import lattice_of
from stt_codegen.design.refine import alternatives, family, refine, refine_with_allowance
from stt_codegen.design.user_tubes import fitted_tube, spline_tube

__all__ = ["alternatives", "family", "fitted_tube", "lattice_of", "paper_tubes", "refine", "refine_with_allowance", "spline_tube"]
