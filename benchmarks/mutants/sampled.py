"""Mutants of P9 for `mutations.py --inertia`: certified loops of order 2 with held inputs, and one number of theirs changed.

Bases are tasks and arenas as plants of order 2 with a random period, plant and start share. `draw_sampled_mutant` draws a
mutation, a base and the mutant. The order of random draws is part of the benchmark.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial
from random import Random
from typing import Any

from benchmarks.mutants.order_two import (
    DISTURBANCE,
    SMALLEST_VALUE,
    TASK_NAMES,
    draw_factor,
    largest_start_speeds,
    order_two_design,
)
from benchmarks.mutants.tubes import Mutant, floor_to_file, with_entry
from benchmarks.oracles.order_two import largest_demanded_acceleration
from stt_codegen.certify.certificate import PeriodProof
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_program, build_task, certify
from stt_codegen.task.task import Task

BASE_NAMES = (*TASK_NAMES, *(f"paper {seed}" for seed in range(6)))
CLAIMS = ("limited", "limited, noise", "limited, moving", "free")
PERIODS = tuple(Fraction(1, k) for k in (50, 100, 200, 400))  # seconds
DECIMALS = 10**12  # a number of a task file is a multiple of 1 / DECIMALS


@dataclass(frozen=True)
class BaseLoop:
    """A certified loop that mutations start from. longest: what the tool says it proves with this gain, period and latency
    together, in seconds."""

    task: Task
    design: RefinedDesign
    proof: PeriodProof
    longest: Fraction


@dataclass(frozen=True)
class DrawnLoopMutant:
    """A mutant, the name of its mutation, and the loop that it was made from, with a name."""

    kind: str
    base_name: str
    base: BaseLoop
    mutant: Mutant


@cache
def base_loop(name: str, claims: str) -> BaseLoop | None:
    """Return a certified loop with random claims of a kind of CLAIMS, its period stretched towards the longest proved one; None
    where none of PERIODS is proved."""
    designed = order_two_design(name, "float")
    if designed is None:
        return None
    (task, design), rng = designed, Random(f"{name} {claims}")
    plant: dict[str, Any] = {"w_max": DISTURBANCE, "f_max": Fraction(rng.choice((0, 1)), 20)}
    control: dict[str, Any] = {}
    if "limited" in claims:
        plant |= {"g_min": Fraction(rng.choice((9, 10)), 10), "g_max": Fraction(rng.choice((10, 11)), 10)}
        required = max(largest_demanded_acceleration(design, i) for i in range(design.dimension))
        needed_input = (required + DISTURBANCE + plant["f_max"]) / plant["g_min"]
        control["u_max"] = floor_to_file(needed_input * Fraction(rng.choice((110, 130, 200)), 100))
    if "noise" in claims:
        plant |= {"noise": Fraction(1, 1000), "noise_v": Fraction(rng.choice((0, 5)), 1000)}
        control["latency"] = Fraction(rng.choice((0, 2)), 1000)
    start: dict[str, Any] = {"share": Fraction(rng.choice((50, 80, 90)), 100)}
    if "moving" in claims:
        largest = largest_start_speeds(task.changed(initial_set=start), design)
        start["speed"] = tuple(max(floor_to_file(v / rng.choice((2, 5))), SMALLEST_VALUE) for v in largest)
    task = task.changed(initial_set=start)
    for period in PERIODS:
        with contextlib.suppress(NotCertified):
            controller = build_task(task.changed(plant=plant, control={**control, "period": period}), tube=design)
            latency = controller.task.control.latency
            longest = period + latency + max(controller.certificate.findings[-1].margin, Fraction(0))
            stretched = round_to_decimals(longest * Fraction(rng.choice((50, 90, 99)), 100) - latency)
            task = with_control(controller.task, period=stretched if stretched > 0 else period)
            proof = certify(task, design, build_program(task, design)).proved_period
            return BaseLoop(task, design, proof, longest) if proof is not None else None
    return None


def round_to_decimals(value: Fraction) -> Fraction:
    """Round to a multiple of 1 / DECIMALS, which a task file states in few digits."""
    return Fraction(round(value * DECIMALS), DECIMALS)


def with_control(task: Task, **change: Any) -> Task:
    return task.model_copy(update={"control": task.control.model_copy(update=change)})


def with_plant(task: Task, **change: Any) -> Task:
    return task.model_copy(update={"plant": task.plant.model_copy(update=change)})


def with_start(task: Task, **change: Any) -> Task:
    return task.model_copy(update={"initial_set": task.initial_set.model_copy(update=change)})


# ------------------------------------------------------------------------------------------------ the mutations


def draw_factor_above_one(rng: Random, largest_power: int) -> Fraction:
    """Draw a factor above 1 by 2^-20 to 2^largest_power."""
    power = rng.choice((rng.randint(-20, largest_power), rng.randint(-2, largest_power), largest_power))
    return 1 + Fraction(2) ** power * Fraction(rng.randint(8, 16), 16)


def lengthen_period(rng: Random, base: BaseLoop) -> Task:
    return with_control(base.task, period=round_to_decimals(base.task.sampling_period * draw_factor_above_one(rng, 5)))


def set_period_near_longest(rng: Random, base: BaseLoop) -> Task:
    """Put the period a little above or below the longest that the tool proves."""
    near_longest = base.longest * (1 + rng.choice((-1, 1)) * Fraction(1, 1 << rng.randint(2, 24)))
    period = max(round_to_decimals(near_longest - base.task.control.latency), Fraction(1, DECIMALS))
    return with_control(base.task, period=period)


def change_gain(rng: Random, base: BaseLoop) -> Task:
    """Multiply the gain of one component, or of all."""
    factor, i = draw_factor(rng, 3), rng.randrange(base.task.dimension + 1)
    gain = [v * factor if i in (k, base.task.dimension) else v for k, v in enumerate(base.task.gain)]
    return with_control(base.task, gain=tuple(round_to_decimals(v) for v in gain))


def lengthen_latency(rng: Random, base: BaseLoop) -> Task:
    more = base.task.sampling_period * (draw_factor_above_one(rng, 1) - 1)
    return with_control(base.task, latency=round_to_decimals(base.task.control.latency + more))


def raise_noise(rng: Random, base: BaseLoop) -> Task:
    name = rng.choice(("noise", "noise_v"))
    more = Fraction(1, 200) * (draw_factor_above_one(rng, 5) - 1)
    return with_plant(base.task, **{name: round_to_decimals((getattr(base.task.plant, name) or 0) + more)})


def change_e_max(rng: Random, base: BaseLoop) -> Task:
    """Lower e_max of one component, which weakens the law, or raise it."""
    by = Fraction(2) ** rng.randint(-12, -1)
    i = rng.randrange(base.task.dimension)
    e_max = base.task.e_max[i]
    changed = e_max * (1 - by) if rng.random() < 0.7 else 1 - (1 - e_max) * (1 - by)
    return with_control(base.task, e_max=with_entry(base.task.e_max, i, round_to_decimals(changed)))


def raise_start_share(rng: Random, base: BaseLoop) -> Task:
    excluded = 1 - base.task.initial_set.share
    return with_start(base.task, share=round_to_decimals(1 - excluded * (1 - Fraction(2) ** rng.randint(-16, -1))))


def set_start_speed(rng: Random, base: BaseLoop) -> Task:
    """Set the speed of starts on one axis to a part of the largest possible one, or close to it."""
    i = rng.randrange(base.task.dimension)
    largest = max(largest_start_speeds(base.task, base.design)[i], Fraction(1, 1000))
    factor = rng.choice((Fraction(rng.randint(1, 16), 16), 1 + rng.choice((-1, 1)) * Fraction(1, 1 << rng.randint(4, 20))))
    return with_start(base.task, speed=with_entry(base.task.start_speed, i, round_to_decimals(largest * factor)))


def lower_input_limit(rng: Random, base: BaseLoop) -> Task:
    """Lower u_max of one component; where u is free, limit it first."""
    i, needed_input = rng.randrange(base.task.dimension), largest_demanded_acceleration(base.design, 0) + DISTURBANCE
    u_max = base.task.u_max or (2 * needed_input,) * base.task.dimension
    lowered = with_entry(u_max, i, u_max[i] / draw_factor_above_one(rng, 0))
    return with_control(base.task, u_max=tuple(map(round_to_decimals, lowered)))


def worsen_plant(rng: Random, base: BaseLoop, names: Sequence[str]) -> Task:
    """Worsen one of these bounds of the plant."""
    name, factor = rng.choice(names), draw_factor_above_one(rng, 1)
    plant, bounds = base.task.plant, base.task.plant_bounds
    if name == "g_min":
        value = min(v.g_min for v in bounds) / factor
    elif name == "g_max":
        value = max(v.g_max for v in bounds) * factor
    elif name == "g_cross":
        value = (plant.g_cross or 0) + (factor - 1) / 4
    else:
        value = (getattr(plant, name) or Fraction(0)) + DISTURBANCE * (factor - 1)
    return with_plant(base.task, **{name: round_to_decimals(value)})


SAMPLED_MUTATIONS: dict[str, Callable[[Random, BaseLoop], Task]] = {
    "held: period": lengthen_period,
    "held: period at its longest": set_period_near_longest,
    "held: gain": change_gain,
    "held: latency": lengthen_latency,
    "held: noise": raise_noise,
    "held: e_max": change_e_max,
    "held: share": raise_start_share,
    "held: speed of the starts": set_start_speed,
    "held: input limit": lower_input_limit,
    "held: push": partial(worsen_plant, names=("f_max", "w_max")),
    "held: g": partial(worsen_plant, names=("g_min", "g_max", "g_cross")),
}


def draw_sampled_mutant(
    rng: Random, names: Sequence[str] = BASE_NAMES, kinds: Sequence[str] = tuple(SAMPLED_MUTATIONS)
) -> DrawnLoopMutant:
    """Draw a mutation of these kinds, a base of these names, and a mutant that a task file can state. Limited inputs are drawn
    more often than free ones."""
    kind = rng.choice(list(kinds))
    for _ in range(1000):
        name, claims = rng.choice(names), rng.choice((*CLAIMS[:3], *CLAIMS))
        base = base_loop(name, claims)
        if base is None:
            continue
        task = SAMPLED_MUTATIONS[kind](rng, base)
        if max(*task.e_max, task.initial_set.share) < 1 and min(*task.gain, *task.e_max, task.sampling_period) > 0:
            return DrawnLoopMutant(kind, f"{name}, {claims}", base, Mutant(task, base.design))
    raise RuntimeError(f"no mutant of the kind {kind!r} from {', '.join(names)}")
