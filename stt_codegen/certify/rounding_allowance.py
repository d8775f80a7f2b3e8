"""The allowance for rounding that a tube needs, before there is a program to certify.

Design leaves an allowance at every bound on the edges. P7's error grows with the speed of the tube, so a very fast tube may need
more: the exact tube is then sound and yet refused. The test costs one bound (controller/edge_errors.py), which the certificate
uses again. Where that bound is near the allowance, it costs the exact comparisons of P1 to P6 and P10 too.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from stt_codegen.certify.certificate import Certificate
from stt_codegen.certify.claims import units_of_error
from stt_codegen.certify.exact import certify_refined
from stt_codegen.certify.missions import certify_mission
from stt_codegen.controller import edge_error_of_design
from stt_codegen.design import lattice_of
from stt_codegen.designs import RefinedDesign
from stt_codegen.task import Task

# An error below this share of the allowance is always covered: of its 32 steps, 3 are for the coefficients and one is for
# comparisons in whole steps, and the linear programs meet their bounds to a hundredth of a step.
COVERED_SHARE = Fraction(3, 4)
ERROR_GROWTH = 2  # times the present error; a tube with a larger allowance may be faster


def needed_allowance_factor(task: Task, design: RefinedDesign) -> int:
    """Return the factor by which the allowance for rounding must grow for a tube like this one to be certified.

    It is 1 where the usual allowance is enough, and where more than the margin for rounding is missing.
    """
    if task.emit.scalar == "fixed":  # steps of at most 15 bits bound the error, so it is always covered
        return 1
    error, allowance = edge_error_of_design(task, design), lattice_of(task).allowance
    if max(error) <= COVERED_SHARE * allowance or not certify_edges(task, design).lacks_rounding:
        return 1
    return math.ceil(ERROR_GROWTH * max(error) / allowance)


def certify_edges(task: Task, design: RefinedDesign) -> Certificate:
    """Certify P1 to P6 and P10 alone, the properties that need a margin for the arithmetic."""
    error = edge_error_of_design(task, design)
    certificate = certify_refined(task, design, error)
    mission, _ = certify_mission(task, design, units_of_error(design, error))
    return replace(certificate, findings=(*certificate.findings, *mission))
