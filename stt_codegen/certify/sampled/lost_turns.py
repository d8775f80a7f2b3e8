"""Whether the turn of every closed axis is always known: between two samples x moves by less than unwrapping allows.

|x_i(t + tau) - x_i(t)| <= max width + speed tau              x is in the tube at both times
                        <= (|f + w| + g_max u_i + g_cross sum of the other u_j) tau      order 1, |u_i| as proved
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from stt_codegen.certify.certificate import PeriodProof
from stt_codegen.decimals import above
from stt_codegen.designs import RefinedDesign
from stt_codegen.sampling import FRACTIONS, refined_windows
from stt_codegen.task import Task


class LostTurn(NamedTuple):
    """A closed axis, by number from 0, with the largest motion of x in a period and the largest that unwrapping allows."""

    axis: int
    motion: Fraction
    allowed: Fraction


def lost_turn(task: Task, design: RefinedDesign, proof: PeriodProof) -> LostTurn | None:
    """Return the first axis in which a turn might be miscounted; None where there is none."""
    windows, speeds = refined_windows(design, FRACTIONS), design.edge_speed_bounds()
    velocities = task.largest_derivative([Fraction(str(above(v))) for v in proof.u])  # for u as the certificate claims it
    for axis in task.closed_axes:
        i = axis.index
        width, speed = windows.wide[:, i].max(), speeds[i]
        motion = width + speed * proof.period
        if task.order == 1:
            motion = min(motion, velocities[i] * proof.period)
        else:
            motion = min(motion, (speed + design.filter[i] * width) * proof.period)
        if motion >= axis.largest_step:
            return LostTurn(i, motion, axis.largest_step)
    return None
