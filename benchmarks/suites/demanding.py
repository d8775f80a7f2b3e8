"""Random tasks that ask for much: too little time, input, room or sampling for many of them to be certified as they are.

Each kind is a cause of refusals. A kind and a seed give the same task file every time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from benchmarks.moving import FOUR, draw_moving_sets
from benchmarks.moving import task_of as moving_task
from benchmarks.suites.families import FAMILIES, arena_task
from benchmarks.suites.scenarios import random_mission
from stt_codegen.task import parse_task
from stt_codegen.task.map import to_toml
from stt_codegen.task.task import Task, document_of

Random = np.random.Generator


def task_text(kind: str, seed: int) -> str:
    """Return the task file of this kind and seed."""
    return to_toml(document_of(KINDS[kind](seed, np.random.default_rng((seed, 7)))))


def _arena(seed: int) -> Task:
    return arena_task(FAMILIES["paper"], seed)


def _number(rng: Random, low: float, high: float) -> Fraction:
    """Return a number between two bounds, as likely in each part of the same ratio, with three digits."""
    return Fraction(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.3g}")


def _sampled(seed: int, rng: Random) -> Task:
    plant = {"f_max": _number(rng, 0.05, 0.3), "w_max": Fraction("0.1"), "g_min": Fraction(1), "g_max": Fraction("1.2")}
    control = {"period": _number(rng, 0.02, 0.4), "u_max": _number(rng, 1, 4)}
    return _arena(seed).changed(plant=plant, control=control)


def _coupled(seed: int, rng: Random) -> Task:
    plant = {"f_max": _number(rng, 0.02, 0.2), "g_min": Fraction(1), "g_max": Fraction("1.5"), "g_cross": _number(rng, 0.05, 0.6)}
    return _arena(seed).changed(plant=plant, control={"period": _number(rng, 0.005, 0.1), "u_max": _number(rng, 1, 6)})


def _inertial(seed: int, rng: Random) -> Task:
    plant = {"order": 2, "w_max": Fraction("0.1")}
    return _arena(seed).changed(plant=plant, control={"period": _number(rng, 0.01, 0.08), "u_max": _number(rng, 1.5, 4)})


def _late(seed: int, rng: Random) -> Task:
    plant = {"w_max": Fraction("0.1"), "g_min": Fraction(1), "g_max": Fraction("1.2"), "lag": _number(rng, 0.05, 0.6)}
    return _arena(seed).changed(plant=plant, control={"period": Fraction("0.02"), "u_max": "auto"})


def _weak(seed: int, rng: Random) -> Task:
    plant = {"f_max": _number(rng, 0.05, 0.3), "g_min": Fraction(1), "g_max": Fraction(1)}
    return _arena(seed).changed(plant=plant, control={"u_max": _number(rng, 0.4, 0.9)})


def _slow(seed: int, rng: Random) -> Task:
    limits = {"max_speed": _number(rng, 0.4, 0.8)} if seed % 2 else {"max_acceleration": _number(rng, 0.05, 0.5)}
    return _arena(seed).changed(tube=limits)


def _narrow(seed: int, rng: Random) -> Task:
    return _arena(seed).changed(tube={"clearance": _number(rng, 0.2, 1), "min_width": _number(rng, 0.2, 0.5)})


def _among_moving_sets(seed: int, rng: Random) -> Task:
    clearance = {"tube": {"clearance": _number(rng, 0.2, 1), "min_width": Fraction("0.1")}}
    return moving_task(draw_moving_sets(FOUR, seed), timing=float(_number(rng, 0.1, 1.5)), **clearance)


def _mission(seed: int, rng: Random) -> Task:
    task = parse_task(random_mission(seed, 2, 4))
    limits: dict[str, Any] = {"tube": {"max_speed": _number(rng, 0.8, 2.5)}}
    return task.changed(**limits)


KINDS: Mapping[str, Callable[[int, Random], Task]] = {
    "sampling": _sampled,
    "coupling": _coupled,
    "inertia": _inertial,
    "lag": _late,
    "input": _weak,
    "speed": _slow,
    "passage": _narrow,
    "moving sets": _among_moving_sets,
    "mission": _mission,
}
