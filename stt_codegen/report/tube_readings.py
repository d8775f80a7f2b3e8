"""Read the windows of a tube, and bounds on its update function, from each kind of design.

report/loop_analysis.py calls an entry of `READINGS`. docs/paper.md has Lemma 3.3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from stt_codegen.certify.adaptive import enclosed_tube, enclosed_windows
from stt_codegen.design_kinds import DesignKind
from stt_codegen.designs import AdaptiveDesign, Design, RefinedDesign, for_any_design
from stt_codegen.report.bounds import UpdateFunctionBounds, round_down, round_up
from stt_codegen.sampling import Windows, refined_windows
from stt_codegen.task import Task


@dataclass(frozen=True)
class TubeReading:
    """The windows of a tube, and bounds on its update function where it has one."""

    windows: Windows
    update_function: UpdateFunctionBounds | None = None


def _read_splines(_task: Task, design: RefinedDesign) -> TubeReading:
    return TubeReading(refined_windows(design))


def _read_adaptive(task: Task, design: AdaptiveDesign) -> TubeReading:
    """Enclose the tube in balls, and bound what the repaired Lemma 3.3 needs: psi, alpha and the four gaps."""
    tube = enclosed_tube(task, design)
    psi, alpha, rho, beta = tube.lines.psi, tube.alpha, tube.lines.rho, tube.lines.beta
    low, high = 0, 1
    upper = (rho[:, :, 1, low] + alpha[:, :, 1, low], beta[:, :, 1, low])
    lower = (rho[:, :, 0, high] - alpha[:, :, 0, low], beta[:, :, 0, high])
    gap = min(float((a - b).min()) for a in upper for b in lower)
    bounds = UpdateFunctionBounds(
        round_down(float((psi[..., low] + alpha[..., low]).min())),
        round_down(float(psi[0, ..., low].min())),
        round_up(float(alpha[..., high].max())),
        round_down(gap),
        round_up(math.log(4) / float(design.nu)),
    )
    return TubeReading(enclosed_windows(tube), bounds)


READINGS: Mapping[DesignKind, Callable[[Task, Design], TubeReading]] = {
    "refined": for_any_design(RefinedDesign, _read_splines),
    "adaptive": for_any_design(AdaptiveDesign, _read_adaptive),
    "literal": for_any_design(AdaptiveDesign, _read_adaptive),
}
