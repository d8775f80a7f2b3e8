"""The kernels of an adaptive or literal tube, lowered from the functions of stt_codegen/paper.

adaptive_parts.py and the lemmas `kernels.*` of docs/lemmas.md take them from here. Numbers in brackets are equations of
docs/paper.md. Strings are names and comments in emitted code.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from stt_codegen.paper import adaptive_tube, circumvent, reach_tube
from stt_codegen.program import REAL, Block, Kernel, Var, real
from stt_codegen.program.convert import lower


@dataclass(frozen=True, kw_only=True)
class AdaptiveKernels:
    """The kernels of (4)-(11)."""

    hold: Kernel
    profile: Kernel
    profile_rate: Kernel
    reach_edge: Kernel
    reach_rate: Kernel
    circumvent: Kernel
    circumvent_rate: Kernel
    join: Kernel
    join_rate: Kernel
    update_rate: Kernel
    implicit_start: Kernel
    newton: Kernel
    implicit_end: Kernel
    lower_edge: Kernel
    lower_edge_rate: Kernel
    upper_edge: Kernel
    upper_edge_rate: Kernel
    theta: Kernel

    def of_public_functions(self, slots: tuple[int, int]) -> tuple[Kernel, ...]:
        """Return the kernels that public functions call, for `slots` circumvent functions on each side of a dimension.

        theta is for the probe alone; joining is needed where a side has two circumvent functions."""
        unused = {"theta"}
        if max(slots) == 0:
            unused |= {"circumvent", "circumvent_rate"}
        if max(slots) < 2:
            unused |= {"join", "join_rate"}
        return tuple(k for name, k in vars(self).items() if name not in unused)


@cache  # they depend on no task
def build_adaptive_kernels() -> AdaptiveKernels:
    """Lower the functions of stt_codegen/paper that (4)-(11) need to kernels; each docstring stands in the emitted code."""
    return AdaptiveKernels(
        hold=_build_hold_kernel(),
        profile=lower(reach_tube.profile(), ("Time profile of (4): sigma = tanh(t / (t_c - t)), 1 from t_c on.",)),
        profile_rate=lower(reach_tube.profile(True), ("sigma of (4) and its derivative.",)),
        reach_edge=lower(reach_tube.reach_edge(), ("An edge of the reachability tube (4).",)),
        reach_rate=lower(reach_tube.reach_rate(), ("The rate of an edge of the reachability tube (4).",)),
        circumvent=lower(circumvent.circumvent(), ("A circumvent function (7), (8) above its rest level.",)),
        circumvent_rate=lower(circumvent.circumvent(True), ("A circumvent function (7), (8) and its derivative.",)),
        join=lower(circumvent.join(), ("Joins circumvent functions of one side smoothly, in place of (9).",)),
        join_rate=lower(circumvent.join(True), ("Joins circumvent functions of one side, with the rate.",)),
        update_rate=lower(adaptive_tube.update_rate(), ("The update function's equation (11) and its exact Jacobian.",)),
        implicit_start=lower(adaptive_tube.implicit_start(), ("Implicit step of (11): (z - p) z^2 = q, and where to start.",)),
        newton=lower(adaptive_tube.newton(), ("One Newton iterate for (z - p) z^2 = q.",)),
        implicit_end=lower(adaptive_tube.implicit_end(), ("Implicit step of (11): alpha from the root z = psi + alpha.",)),
        lower_edge=lower(adaptive_tube.lower_edge(), ("gamma_L of (10).",)),
        lower_edge_rate=lower(adaptive_tube.lower_edge(True), ("gamma_L of (10) and its total rate.",)),
        upper_edge=lower(adaptive_tube.upper_edge(), ("gamma_U of (10).",)),
        upper_edge_rate=lower(adaptive_tube.upper_edge(True), ("gamma_U of (10) and its total rate.",)),
        theta=lower(adaptive_tube.theta(), ("theta of (11).",)),
    )


def _build_hold_kernel() -> Kernel:
    """Build the kernel that clamps t to [0, t_c]."""
    t, t_c = Var("t", REAL), Var("t_c", REAL)
    block = Block({"t", "t_c"})
    is_positive = block.op("positive", "lt", real(0), t)
    nonnegative_t = block.select("started", is_positive, t, real(0))
    is_before_end = block.op("running", "lt", nonnegative_t, t_c)
    clamped_t = block.select("held", is_before_end, nonnegative_t, t_c)
    body = tuple(block.statements)
    return Kernel("hold", (t, t_c), body, (clamped_t,), ("held",), doc=("t held within [0, t_c].",))  # type: ignore[arg-type]
