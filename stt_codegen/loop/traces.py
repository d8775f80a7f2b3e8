"""The trace of a run as CSV: a row for every sample, in nine digits."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy.typing as npt

from stt_codegen.task import Task

Array = npt.NDArray[Any]


def trace_columns(task: Task) -> list[str]:
    """Return the names of a trace's columns; of each moving set its displacement, and whether it is unsafe."""
    n, moving = task.dimension, [s.name for s, c in zip(task.unsafe, task.courses, strict=True) if c is not None]
    set_columns = [f"{name}.{word}" for name in moving for word in (*(f"d{i + 1}" for i in range(n)), "unsafe")]
    kinds = ("x", "u", "lower", "upper", "w", *(("v",) if task.order == 2 else ()))
    return ["t", *(f"{name}{i + 1}" for name in kinds for i in range(n)), "status", *set_columns]


def trace_csv(trace: Array, task: Task, clock: str = "stated") -> bytes:
    """Return a trace as CSV. Moving sets are where that clock says, one of CLOCKS; for "worst" where they are as stated."""
    lines, courses = [",".join(trace_columns(task))], [c for c in task.courses if c is not None]
    clock_offsets = {c: {"early": -c.clock_lag, "late": c.clock_lead}.get(clock, Fraction(0)) for c in courses}
    for row in trace.tolist():
        cells = [f"{v:.9g}" for v in row[:-1]] + [f"{int(row[-1])}"]
        for course in courses:
            tau = Fraction(row[0]) + clock_offsets[course]
            cells += [f"{float(v):.9g}" for v in course.displacement(tau)] + [f"{int(course.is_unsafe_at(tau))}"]
        lines.append(",".join(cells))
    return ("\n".join(lines) + "\n").encode()
