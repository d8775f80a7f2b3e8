"""Whether a run carries out the mission: a judgement at its samples, by the exact shapes of regions."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.certify import Cycle, Span, Time, holds
from stt_codegen.task import Task
from stt_codegen.task.mission import And, Formula, InRegion, Or, state_formulas_of
from stt_codegen.task.sets import Unsafe, UnsafeBall

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]


def unsatisfied_entries(task: Task, t: Array, x: Array, cycle: Cycle | None = None) -> tuple[int, ...]:
    """Return the entries of the mission, from 1, that a trajectory does not satisfy: at times t (T,), states x (T, n).

    A formula of the state that holds at two neighbouring samples is taken to hold between them. After the last sample x stays
    where it is; with a cycle it repeats its motion of the last cycle.
    """
    spans = {
        state: _spans(t, _holds_at_samples(task, state.inner, x), cycle is None)
        for f in task.formulas
        for state in state_formulas_of(f)
    }
    end = Fraction(float(t[-1]))
    last_cycle = None if cycle is None else Cycle(end - cycle.length, end)
    return tuple(k for k, f in enumerate(task.formulas, 1) if not holds(f, spans, cycle=last_cycle))


def _holds_at_samples(task: Task, formula: Formula, x: Array) -> Flags:
    """Return at which samples a formula of the state alone holds, (T,)."""
    match formula:
        case InRegion(region, is_negated):
            return ~_is_inside(task, region, x, is_grown=True) if is_negated else _is_inside(task, region, x)
        case And(parts):
            return np.asarray(np.all([_holds_at_samples(task, p, x) for p in parts], axis=0))
        case Or(parts):
            return np.asarray(np.any([_holds_at_samples(task, p, x) for p in parts], axis=0))
    raise TypeError(formula)


def _is_inside(task: Task, name: str, x: Array, is_grown: bool = False) -> Flags:
    """Return which states are in a region, (T,); is_grown: in the region grown by the body, so that the body meets the region."""
    region = task.regions[name]
    assert isinstance(region, Unsafe)
    axes = list(task.axis_indices(region))
    half_extents = np.array([float(v) if is_grown else 0.0 for v in task.half_extents])
    if isinstance(region, UnsafeBall):
        offsets = np.maximum(np.abs(x[:, axes] - [float(v) for v in region.centre]) - half_extents[axes], 0.0)
        return np.asarray(np.hypot.reduce(offsets, axis=1) <= float(region.radius))
    faces, columns, growth = region.half_spaces(), x[:, axes], half_extents[axes]
    if not faces:  # of a capsule half-spaces that hold it, in all dimensions
        faces, columns, growth = region.to_set_in(task.state_space, axes).faces, x, half_extents
    is_inside = np.ones(len(x), dtype=bool)
    for normal, offset in faces:
        c = np.array([float(v) for v in normal])
        is_inside &= columns @ c <= float(offset) + float(np.abs(c) @ growth)
    return is_inside


def _spans(t: Array, flags: Flags, stands_at_end: bool) -> list[Span]:
    """Return the time span of every series of samples with the flag, from its first sample to its last.

    One that begins at the first sample extends to minus infinity. One that ends at the last sample extends to infinity where the
    state stays there.
    """
    changes: Any = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    pairs = zip(changes[::2].tolist(), (changes[1::2] - 1).tolist(), strict=True)
    endless_sample = len(t) - 1 if stands_at_end else None

    def time_of(k: int) -> Time:
        return float(t[k]) if stands_at_end else Fraction(float(t[k]))

    return [(-math.inf if a == 0 else time_of(a), math.inf if b == endless_sample else time_of(b)) for a, b in pairs]
