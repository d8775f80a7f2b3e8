"""Whether a run carries out the mission, judged at its samples by the regions' exact shapes."""

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


def missed(task: Task, t: Array, x: Array, cycle: Cycle | None = None) -> tuple[int, ...]:
    """The entries of the mission, from 1, that a trajectory does not satisfy: at times t (T,), states x (T, n). Between two
    samples at which a state holds it is taken to hold; after the last one x stands, or, with a cycle, does again and again what
    it did in the last one of that length."""
    spans = {
        state: _spans(t, _holds(task, state.inner, x), cycle is None) for f in task.formulas for state in state_formulas_of(f)
    }
    end = Fraction(float(t[-1]))
    last = None if cycle is None else Cycle(end - cycle.length, end)
    return tuple(k for k, f in enumerate(task.formulas, 1) if not holds(f, spans, cycle=last))


def _holds(task: Task, formula: Formula, x: Array) -> Flags:
    """At which samples a formula without time holds."""
    match formula:
        case InRegion(region, kept):
            return ~_inside(task, region, x, grown=True) if kept else _inside(task, region, x)
        case And(parts):
            return np.asarray(np.all([_holds(task, p, x) for p in parts], axis=0))
        case Or(parts):
            return np.asarray(np.any([_holds(task, p, x) for p in parts], axis=0))
    raise TypeError(formula)


def _inside(task: Task, name: str, x: Array, grown: bool = False) -> Flags:
    """Which states are in a region; grown: with which the body meets it."""
    region = task.regions[name]
    assert isinstance(region, Unsafe)
    own = list(task.axis_indices(region))
    half = np.array([float(task.half_extents[i]) if grown else 0.0 for i in own])
    if isinstance(region, UnsafeBall):
        away = np.maximum(np.abs(x[:, own] - [float(v) for v in region.centre]) - half, 0.0)
        return np.asarray(np.hypot.reduce(away, axis=1) <= float(region.radius))
    faces = region.half_spaces() or region.to_set_in(task.state_space, own).faces  # of a capsule half-spaces that hold it
    columns = x[:, own] if region.half_spaces() else x
    room = half if region.half_spaces() else np.array([float(v) if grown else 0.0 for v in task.half_extents])
    found = np.ones(len(x), dtype=bool)
    for normal, offset in faces:
        c = np.array([float(v) for v in normal])
        found &= columns @ c <= float(offset) + float(np.abs(c) @ room)
    return found


def _spans(t: Array, held: Flags, stands: bool) -> list[Span]:
    """The times from first to last sample of every run of samples at which a state holds; of the last sample for ever where it
    stands there."""
    edges: Any = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    pairs = zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True)
    ever = len(t) - 1 if stands else None

    def at(k: int) -> Time:
        return float(t[k]) if stands else Fraction(float(t[k]))

    return [(-math.inf if a == 0 else at(a), math.inf if b == ever else at(b)) for a, b in pairs]
