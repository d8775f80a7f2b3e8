"""The plant that is assumed for a task of order 1 that has a period and states no plant.

x' = u and no other would be proved for a robot that nobody has. The checker computes the same bounds from the table
(stt_checker/task.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from stt_codegen.decimals import above
from stt_codegen.task.task import Task

ASSUMED_G = (Fraction(4, 5), Fraction(6, 5))
DISTURBANCE_SHARE = Fraction(1, 10)  # of the speed of the tube's fastest edge, by component
DISTURBANCE_DIGITS = 3


def with_assumed_plant(task: Task, edge_speeds: Sequence[Fraction]) -> Task:
    """Return the task with the plant that is assumed where it states none; else the task.

    edge_speeds: bounds on the speed of the tube's edges by dimension, in the task's units a second.
    """
    if not task.assumes_plant:
        return task
    w_max = tuple(Fraction(str(above(DISTURBANCE_SHARE * v, DISTURBANCE_DIGITS))) for v in edge_speeds)
    bounds = {"g_min": ASSUMED_G[0], "g_max": ASSUMED_G[1], "w_max": w_max}
    return task.with_choices(plant=task.plant.model_copy(update=bounds))
