"""Whether a sampled state is always on a known turn: between two samples of a proved loop x moves by less than unwrapping allows.

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
    """An axis that closes, by number from 0, what x may move by in a period, and what it may at most."""

    axis: int
    moves: Fraction
    allowed: Fraction


def lost_turn(task: Task, design: RefinedDesign, proof: PeriodProof) -> LostTurn | None:
    """The first axis in which a turn might be miscounted; None where none is."""
    bezier, unit = design.bezier(), design.unit
    rate = unit * design.segments / task.prescribed_time
    u = [Fraction(str(above(v))) for v in proof.u]  # as the certificate claims it
    for axis in task.closed_axes:
        i = axis.index
        width = int((bezier[:, i, 1] - bezier[:, i, 0]).max()) * unit
        speed = int(3 * abs(bezier[:, i, :, 1:] - bezier[:, i, :, :-1]).max()) * rate
        moves = width + speed * proof.period
        if task.order == 1:
            bounds = task.plant_bounds[i]
            pushed = bounds.force + bounds.g_max * u[i] + bounds.cross * (sum(u, Fraction(0)) - u[i])
            moves = min(moves, pushed * proof.period)
        else:
            moves = min(moves, (speed + design.filter[i] * width) * proof.period)
        if moves >= axis.largest_step:
            return LostTurn(i, moves, axis.largest_step)
    return None
