"""Axes that close in emitted files: sentences for the notice of every file, and the names that templates of <p>_unwrap read."""

from __future__ import annotations

import textwrap
from fractions import Fraction
from typing import Any

from stt_codegen.decimals import above, below, decimal
from stt_codegen.program import Const, round_to
from stt_codegen.task import Task


def turns_notice(task: Task) -> list[str]:
    """Return the lines that say what the guarantee is about where axes close."""
    if not task.closed_axes:
        return []
    periods = [f"{task.axis_names[a.index]} after {decimal(a.period)}" for a in task.closed_axes]
    text = f"Axes that close: {', '.join(periods)}. Unsafe sets count at every turn; {_target_turns(task)}x is the "
    return textwrap.wrap(text + f"unwrapped state: measured angles go through {task.name}_unwrap first.", 115)


def _target_turns(task: Task) -> str:
    """Return the middle of the target in these axes, as part of a sentence."""
    if task.target_set is None:
        return ""
    middles = ((a.index, (task.target.lower[a.index] + task.target.upper[a.index]) / 2) for a in task.closed_axes)
    return f"the target's middle is at {', '.join(f'{task.axis_names[i]} = {decimal(middle)}' for i, middle in middles)}; "


def unwrapping(task: Task, scalar: str) -> dict[str, Any]:
    """Return what templates read about axes that close: periods as in the C, the largest step, the error of unwrapping."""
    suffix = "F" if scalar == "float" else ""
    numbers = {"fewest": -1000, "most": 1000, "zero": 0, "down": -0.5, "up": 0.5}
    axes = [
        {
            "index": axis.index,
            "number": axis.index + 1,
            "name": task.axis_names[axis.index],
            "period": Const(round_to(axis.period, scalar)),
            "period_text": decimal(axis.period),
            "step": f"{below(axis.largest_step):g}",
            **{name: f"{float(value)!r}{suffix}" for name, value in numbers.items()},
        }
        for axis in task.closed_axes
    ]
    initial_state = ", ".join(map(decimal, task.initial_state))
    unwrap_error = max((axis.unwrap_error for axis in task.closed_axes), default=Fraction(0))
    return {
        "closed": axes, "first_state": f"the initial state, {initial_state}", "unwrap_error": f"{above(unwrap_error, 2):g}",
        "noise_raised": bool(task.closed_axes) and task.control.period is not None,
    }  # fmt: skip
