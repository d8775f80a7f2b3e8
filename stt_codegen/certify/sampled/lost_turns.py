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
from stt_codegen.task import Task


class LostTurn(NamedTuple):
    """A closed axis, by number from 0, with the largest motion of x in a period and the largest that unwrapping allows."""

    axis: int
    motion: Fraction
    allowed: Fraction


def lost_turn(task: Task, design: RefinedDesign, proof: PeriodProof) -> LostTurn | None:
    """Return the first axis in which a turn might be miscounted; None where there is none."""
    bezier, unit = design.bezier(), design.unit
    rate = unit * design.segments / task.prescribed_time
    u = [Fraction(str(above(v))) for v in proof.u]  # as the certificate claims it
    for axis in task.closed_axes:
        i = axis.index
        width = int((bezier[:, i, 1] - bezier[:, i, 0]).max()) * unit
        speed = int(3 * abs(bezier[:, i, :, 1:] - bezier[:, i, :, :-1]).max()) * rate
        motion = width + speed * proof.period
        if task.order == 1:
            bounds = task.plant_bounds[i]
            velocity = bounds.force + bounds.g_max * u[i] + bounds.cross * (sum(u, Fraction(0)) - u[i])
            motion = min(motion, velocity * proof.period)
        else:
            motion = min(motion, (speed + design.filter[i] * width) * proof.period)
        if motion >= axis.largest_step:
            return LostTurn(i, motion, axis.largest_step)
    return None
