"""What is wrong with one set of a task, beside what its own table can tell. Each check returns the message, or None."""

from __future__ import annotations

from stt_codegen.decimals import decimal
from stt_codegen.task.schema import TaskTables
from stt_codegen.task.sets import Target, Unsafe, Vector
from stt_codegen.task.values import MAX_TURNS


def set_problem(task: TaskTables, unsafe: Unsafe) -> str | None:
    """An unsafe set that is in other dimensions than it says, or is none."""
    if problem := axes_problem(task, unsafe.axes):
        return problem
    names, own = task.axis_names, unsafe.axes
    for field, vector in unsafe.vectors():
        if own is not None and len(vector) != len(own):
            return f"{field}: has {len(vector)} entries; its axes are {len(own)}: {', '.join(own)}"
        if own is None and len(vector) != len(names):
            told = f"has {len(vector)} entries; state_space.lower has {len(names)}, and all must agree"
            return f"{field}: {told}" + (
                f", unless axes names those of {', '.join(names)} that it is in" if len(vector) < len(names) else ""
            )
    return unsafe.problem() or motion_problem(task, unsafe) or _hours_problem(task, unsafe)


def motion_problem(task: TaskTables, table: Unsafe | Target) -> str | None:
    """A motion whose times do not increase, or whose displacements are in other dimensions than the set."""
    wanted, t_c = len(table.axes or task.axis_names), task.prescribed_time
    if table.motion is not None and len(table.motion) > MAX_TURNS:
        return f"motion: has {len(table.motion)} entries; at most {MAX_TURNS} are taken"
    for k, point in enumerate(table.motion or ()):
        if len(point.by) != wanted:
            return f"motion[{k}].by: has {len(point.by)} entries; {wanted} are needed, one for each of the set's axes"
        if point.at > t_c:
            told = f"is {decimal(point.at)}, after prescribed_time = {decimal(t_c)}; from then on sets stand"
            return f"motion[{k}].at: {told}, so use at most {decimal(t_c)}"
        if k and table.motion and point.at <= table.motion[k - 1].at:
            before = decimal(table.motion[k - 1].at)
            return f"motion[{k}].at: is {decimal(point.at)}, not after the entry before, {before}; times must increase"
    return None


def _hours_problem(task: TaskTables, unsafe: Unsafe) -> str | None:
    """A window outside the task's time, or doubt about times that are not there."""
    window, t_c = unsafe.during, task.prescribed_time
    if window is not None and not 0 <= window[0] < window[1] <= t_c:
        told = f"[{decimal(window[0])}, {decimal(window[1])}]"
        return f"during: is {told}; from must be before to, and both between 0 and prescribed_time = {decimal(t_c)}"
    if unsafe.timing is not None and unsafe.motion is None and unsafe.during is None:
        return "timing: is about a motion or a window; give motion or during, or leave it out"
    return None


def axes_problem(task: TaskTables, own: tuple[str, ...] | None) -> str | None:
    names = task.axis_names
    if own is not None and (not own or len(set(own)) < len(own) or not set(own) <= set(names)):
        return f"axes: are {', '.join(own) or 'none'}; different ones of {', '.join(names)} are needed"
    return None


def entries_problem(task: TaskTables, own: tuple[str, ...] | None, field: str, found: tuple[Vector, ...]) -> str | None:
    wanted = task.dimension if own is None else len(own)
    for k, vector in enumerate(found):
        if len(vector) != wanted:
            more = " of its axes" if own is not None else ", or axes that name fewer"
            return f"{field}[{k}]: has {len(vector)} entries; {wanted} are needed, one for each dimension{more}"
    return None
