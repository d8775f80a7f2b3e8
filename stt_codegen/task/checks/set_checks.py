"""Checks of one set that need the task: its axes, the lengths of its vectors, its motion and active interval.

Each check returns a message without the name of the set's table, or None. The other checks call them.
"""

from __future__ import annotations

from stt_codegen.decimals import decimal
from stt_codegen.task.schema import TaskTables
from stt_codegen.task.sets import Target, Unsafe, Vector
from stt_codegen.task.values import MAX_TURNS


def set_problem(task: TaskTables, unsafe: Unsafe) -> str | None:
    """Return a message where the vectors of a set do not fit to its axes, or its fields describe no set, else None."""
    if problem := axes_problem(task, unsafe.axes):
        return problem
    names, axes = task.axis_names, unsafe.axes
    for field, vector in unsafe.vectors():
        if axes is not None and len(vector) != len(axes):
            return f"{field}: has {len(vector)} entries; its axes are {len(axes)}: {', '.join(axes)}"
        if axes is None and len(vector) != len(names):
            problem = f"has {len(vector)} entries; state_space.lower has {len(names)}, and all must agree"
            return f"{field}: {problem}" + (
                f", unless axes names those of {', '.join(names)} that it is in" if len(vector) < len(names) else ""
            )
    return unsafe.problem() or motion_problem(task, unsafe) or _active_interval_problem(task, unsafe)


def motion_problem(task: TaskTables, table: Unsafe | Target) -> str | None:
    """Return a message where the times of a motion do not increase, or a displacement does not fit to the axes, else None."""
    needed, t_c = len(table.axes or task.axis_names), task.prescribed_time
    if table.motion is not None and len(table.motion) > MAX_TURNS:
        return f"motion: has {len(table.motion)} entries; at most {MAX_TURNS} are taken"
    for k, point in enumerate(table.motion or ()):
        if len(point.by) != needed:
            return f"motion[{k}].by: has {len(point.by)} entries; {needed} are needed, one for each of the set's axes"
        if point.at > t_c:
            problem = f"is {decimal(point.at)}, after prescribed_time = {decimal(t_c)}; from then on sets stand"
            return f"motion[{k}].at: {problem}, so use at most {decimal(t_c)}"
        if k and table.motion and point.at <= table.motion[k - 1].at:
            before = decimal(table.motion[k - 1].at)
            return f"motion[{k}].at: is {decimal(point.at)}, not after the entry before, {before}; times must increase"
    return None


def _active_interval_problem(task: TaskTables, unsafe: Unsafe) -> str | None:
    """Return a message where an active interval exceeds the task's time, or a timing uncertainty has no time, else None."""
    window, t_c = unsafe.during, task.prescribed_time
    if window is not None and not 0 <= window[0] < window[1] <= t_c:
        ends = f"[{decimal(window[0])}, {decimal(window[1])}]"
        return f"during: is {ends}; from must be before to, and both between 0 and prescribed_time = {decimal(t_c)}"
    if unsafe.timing is not None and unsafe.motion is None and unsafe.during is None:
        return "timing: is about a motion or a window; give motion or during, or leave it out"
    return None


def axes_problem(task: TaskTables, axes: tuple[str, ...] | None) -> str | None:
    """Return a message where the axes of a set are not different axes of the task, else None."""
    names = task.axis_names
    if axes is not None and (not axes or len(set(axes)) < len(axes) or not set(axes) <= set(names)):
        return f"axes: are {', '.join(axes) or 'none'}; different ones of {', '.join(names)} are needed"
    return None


def entries_problem(task: TaskTables, axes: tuple[str, ...] | None, field: str, vectors: tuple[Vector, ...]) -> str | None:
    """Return a message where a vector of a field has another number of entries than the set has axes, else None."""
    needed = task.dimension if axes is None else len(axes)
    for k, vector in enumerate(vectors):
        if len(vector) != needed:
            remedy = " of its axes" if axes is not None else ", or axes that name fewer"
            return f"{field}[{k}]: has {len(vector)} entries; {needed} are needed, one for each dimension{remedy}"
    return None
