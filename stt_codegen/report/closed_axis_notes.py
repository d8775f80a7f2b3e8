"""Notes for `design` and `generate` on which way round a tube goes where an axis closes, and on axes that may close."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from stt_codegen.decimals import above
from stt_codegen.task import TWO_PI, ClosedAxis, Task

FULL_TURNS = {  # by an axis's unit, what a user would write in `periodic`
    **dict.fromkeys(("rad", "radian", "radians"), "6.283185307179586"),
    **dict.fromkeys(("deg", "degree", "degrees"), "360"),
}


def turn_notes(task: Task) -> tuple[str, ...]:
    """Return a sentence on each axis that closes, and on each angle that does not although its target is the long way round."""
    return (*(_closed_axis_note(task, axis) for axis in task.closed_axes), *_open_angle_notes(task))


def _number(value: Fraction) -> str:
    return f"{float(value):.6g}"


def _turns(k: int) -> str:
    """Say by how many turns, and which way, as in "2 turns up"."""
    return f"{'one turn' if abs(k) == 1 else f'{abs(k)} turns'} {'up' if k > 0 else 'down'}"


def _closed_axis_note(task: Task, axis: ClosedAxis) -> str:
    """Say which copy of the target a tube goes to, whether the state space is a limit, and what the period approximates."""
    i, unit = axis.index, (task.units or ("",) * task.dimension)[axis.index]
    note = f"axis {task.axis_names[i]} closes at {_number(axis.period)}{f' {unit}' if unit else ''}"
    if task.target_set is not None:
        middle = (task.target.lower[i] + task.target.upper[i]) / 2
        way = f" ({_turns(axis.target_turns)})" if axis.target_turns else ", as it stands"
        note += f": the target is taken at {_number(middle)}{way}"
        if axis.target_turns != axis.nearest_turns:
            nearer = middle + (axis.nearest_turns - axis.target_turns) * axis.period
            note += f", for the nearest, at {_number(nearer)}, is not in the state space"
    if axis.is_limited:
        note += "; the state space is less than a turn wide there, so it is a limit"
    if axis.drift:
        m = round(TWO_PI / axis.period)
        pi = "2 pi" if m == 1 else f"2 pi/{m}"
        note += f"; the period stands for {pi}, and what it differs, up to {above(axis.drift, 2):g} a turn, is in the margins"
    return note


def _open_angle_notes(task: Task) -> Iterator[str]:
    """Yield a note for each angle that does not close and goes more than half a turn from start to target."""
    closed = {axis.index for axis in task.closed_axes}
    for i, unit in enumerate(task.units or ()):
        period = FULL_TURNS.get(unit.strip().lower())
        if period is None or i in closed or task.target_set is None:
            continue
        distance = (task.target.lower[i] + task.target.upper[i]) / 2 - task.initial_state[i]
        shortest = distance - round(distance / Fraction(period)) * Fraction(period)
        if abs(distance) > Fraction(period) / 2:
            name = task.axis_names[i]
            key = name if name.replace("_", "").replace("-", "").isalnum() and name.isascii() else f'"{name}"'
            yield (
                f"axis {name} goes {_number(distance)} {unit} from start to target, more than half a turn; if it closes, "
                f"`periodic = {{ {key} = {period} }}` at the top of the task goes {_number(shortest)} {unit}"
            )
