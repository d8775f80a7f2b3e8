"""Which way round a tube goes where an axis closes, and where one might: notes for `design` and `generate`."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from stt_codegen.decimals import above
from stt_codegen.task import TWO_PI, ClosedAxis, Task

FULL_TURNS = {  # of an axis by its unit: what is written in `periodic`
    **dict.fromkeys(("rad", "radian", "radians"), "6.283185307179586"),
    **dict.fromkeys(("deg", "degree", "degrees"), "360"),
}


def turn_notes(task: Task) -> tuple[str, ...]:
    """Sentences about the axes that close, and about angles that do not although the target is the long way round."""
    return (*(_closes(task, axis) for axis in task.closed_axes), *_might_close(task))


def _number(value: Fraction) -> str:
    return f"{float(value):.6g}"


def _turns(k: int) -> str:
    """By how many turns, and which way."""
    return f"{'one turn' if abs(k) == 1 else f'{abs(k)} turns'} {'up' if k > 0 else 'down'}"


def _closes(task: Task, axis: ClosedAxis) -> str:
    """One closed axis: where the target is taken, whether the state space is a limit, what the period stands for."""
    i, unit = axis.index, (task.units or ("",) * task.dimension)[axis.index]
    said = f"axis {task.axis_names[i]} closes at {_number(axis.period)}{f' {unit}' if unit else ''}"
    if task.target_set is not None:
        middle = (task.target.lower[i] + task.target.upper[i]) / 2
        way = f" ({_turns(axis.target_turns)})" if axis.target_turns else ", as it stands"
        said += f": the target is taken at {_number(middle)}{way}"
        if axis.target_turns != axis.nearest_turns:
            nearer = middle + (axis.nearest_turns - axis.target_turns) * axis.period
            said += f", for the nearest, at {_number(nearer)}, is not in the state space"
    if axis.is_limited:
        said += "; the state space is less than a turn wide there, so it is a limit"
    if axis.drift:
        m = round(TWO_PI / axis.period)
        pi = "2 pi" if m == 1 else f"2 pi/{m}"
        said += f"; the period stands for {pi}, and what it differs, up to {above(axis.drift, 2):g} a turn, is in the margins"
    return said


def _might_close(task: Task) -> Iterator[str]:
    """Axes in angles that go more than half a turn from start to target."""
    closed = {axis.index for axis in task.closed_axes}
    for i, unit in enumerate(task.units or ()):
        period = FULL_TURNS.get(unit.strip().lower())
        if period is None or i in closed or task.target_set is None:
            continue
        far = (task.target.lower[i] + task.target.upper[i]) / 2 - task.initial_state[i]
        near = far - round(far / Fraction(period)) * Fraction(period)
        if abs(far) > Fraction(period) / 2:
            name = task.axis_names[i]
            key = name if name.replace("_", "").replace("-", "").isalnum() and name.isascii() else f'"{name}"'
            yield (
                f"axis {name} goes {_number(far)} {unit} from start to target, more than half a turn; if it closes, "
                f"`periodic = {{ {key} = {period} }}` at the top of the task goes {_number(near)} {unit}"
            )
