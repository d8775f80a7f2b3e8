"""Lines of the comments of the emitted `control`: about the law, the state and u. All builders of `control` call these."""

from __future__ import annotations

import textwrap

from stt_codegen.controller.kernels import ControlLaw
from stt_codegen.decimals import by_component
from stt_codegen.task import Task

COMMENT_WIDTH = 115  # characters


def law_doc(task: Task, law: ControlLaw) -> str:
    """Return the first line of the comment: the law, its gain, its clamp, and how u is limited."""
    gain, e_max = by_component(task.gain), by_component(task.e_max)
    limit = "." if law.u_max is None else ", u scaled as a whole." if law.scales_input else ", u saturated."
    return f"Control law (13), u = -k xi epsilon, k = {gain}, e clamped to [-{e_max}, {e_max}] by component{limit}"


def axes_doc(task: Task) -> tuple[str, ...]:
    """Return lines that name the components of x and their units; none where the task does not name them."""
    if task.axes is None and task.units is None:
        return ()
    return tuple(textwrap.wrap(f"x by component: {', '.join(task.axis_labels)}.", COMMENT_WIDTH))


def inward_doc(task: Task) -> str:
    """Return what follows "u points inward": with a negative gain it does so through a negative g."""
    return "" if task.gain[0] > 0 else " through a negative g"
