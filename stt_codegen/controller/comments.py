"""What the comments of `control` say of the law, the state and u."""

from __future__ import annotations

import textwrap

from stt_codegen.controller.kernels import Law
from stt_codegen.decimals import by_component
from stt_codegen.task import Task


def law_doc(task: Task, law: Law) -> str:
    """The first line of what is said of `control`."""
    gain, clamp = by_component(task.gain), by_component(task.e_max)
    limited = "." if law.u_max is None else ", u scaled as a whole." if law.scales else ", u saturated."
    return f"Control law (13), u = -k xi epsilon, k = {gain}, e clamped to [-{clamp}, {clamp}] by component{limited}"


def axes_doc(task: Task) -> tuple[str, ...]:
    """What the components of x are, where the task names them."""
    if task.axes is None and task.units is None:
        return ()
    return tuple(textwrap.wrap(f"x by component: {', '.join(task.axis_labels)}.", 115))


def inward_doc(task: Task) -> str:
    """Where u points with a negative gain."""
    return "" if task.gain[0] > 0 else " through a negative g"
