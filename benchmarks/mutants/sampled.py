"""Mutants of P9 for `mutations.py --inertia`: held loops of order 2 that are certified, and one number of theirs changed."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial
from random import Random
from typing import Any

from benchmarks.mutants.order_two import OWN, PUSH, factor, start_rooms, tube_of
from benchmarks.mutants.tubes import Mutant, entry, short
from benchmarks.oracles.order_two import greatest
from stt_codegen.certify.certificate import PeriodProof
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_program, build_task, certify
from stt_codegen.task.task import Task

NAMES = (*OWN, *(f"paper {seed}" for seed in range(6)))
WAYS = ("limited", "limited, noise", "limited, moving", "free")
PERIODS = tuple(Fraction(1, k) for k in (50, 100, 200, 400))
DIGITS = 10**12


@dataclass(frozen=True)
class Held:
    """A certified loop; longest: what the tool says it proves with this gain, seconds."""

    task: Task
    design: RefinedDesign
    proof: PeriodProof
    longest: Fraction


@cache
def held_base(name: str, way: str) -> Held | None:
    found = tube_of(name, "float")
    if found is None:
        return None
    (task, design), dice = found, Random(f"{name} {way}")
    plant: dict[str, Any] = {"w_max": PUSH, "f_max": Fraction(dice.choice((0, 1)), 20)}
    control: dict[str, Any] = {}
    if "limited" in way:
        plant |= {"g_min": Fraction(dice.choice((9, 10)), 10), "g_max": Fraction(dice.choice((10, 11)), 10)}
        most = max(greatest(design, i) for i in range(design.dimension))
        control["u_max"] = short((most + PUSH + plant["f_max"]) / plant["g_min"] * Fraction(dice.choice((110, 130, 200)), 100))
    if "noise" in way:
        plant |= {"noise": Fraction(1, 1000), "noise_v": Fraction(dice.choice((0, 5)), 1000)}
        control["latency"] = Fraction(dice.choice((0, 2)), 1000)
    share = Fraction(dice.choice((50, 80, 90)), 100)
    first: dict[str, Any] = {"share": share}
    if "moving" in way:
        rooms = start_rooms(task.changed(initial_set=first), design)
        first["speed"] = tuple(max(short(v / dice.choice((2, 5))), Fraction(1, 1 << 20)) for v in rooms)
    task = task.changed(initial_set=first)
    for period in PERIODS:
        with contextlib.suppress(NotCertified):
            c = build_task(task.changed(plant=plant, control={**control, "period": period}), tube=design)
            latency = c.task.control.latency
            longest = period + latency + max(c.certificate.findings[-1].margin, Fraction(0))
            stretched = decimal(longest * Fraction(dice.choice((50, 90, 99)), 100) - latency)
            task = with_control(c.task, period=stretched if stretched > 0 else period)
            proof = certify(task, design, build_program(task, design)).proved_period
            return Held(task, design, proof, longest) if proof is not None else None
    return None


def decimal(value: Fraction) -> Fraction:
    """Rounded to what a task file says in few digits."""
    return Fraction(round(value * DIGITS), DIGITS)


def with_control(task: Task, **change: Any) -> Task:
    return task.model_copy(update={"control": task.control.model_copy(update=change)})


def with_plant(task: Task, **change: Any) -> Task:
    return task.model_copy(update={"plant": task.plant.model_copy(update=change)})


def with_start(task: Task, **change: Any) -> Task:
    return task.model_copy(update={"initial_set": task.initial_set.model_copy(update=change)})


# ------------------------------------------------------------------------------------------------ the mutations


def harder(dice: Random, most: int) -> Fraction:
    """Above 1 by 2^-20 to 2^most."""
    power = dice.choice((dice.randint(-20, most), dice.randint(-2, most), most))
    return 1 + Fraction(2) ** power * Fraction(dice.randint(8, 16), 16)


def period(dice: Random, b: Held) -> Task:
    return with_control(b.task, period=decimal(b.task.sampling_period * harder(dice, 2)))


def period_at_longest(dice: Random, b: Held) -> Task:
    """Where the tool's proof ends, and a little on both sides."""
    whole = b.longest * (1 + dice.choice((-1, 1)) * Fraction(1, 1 << dice.randint(2, 24)))
    return with_control(b.task, period=max(decimal(whole - b.task.control.latency), Fraction(1, DIGITS)))


def gain(dice: Random, b: Held) -> Task:
    by, i = factor(dice, 3), dice.randrange(b.task.dimension + 1)
    changed = [v * by if i in (k, b.task.dimension) else v for k, v in enumerate(b.task.gain)]
    return with_control(b.task, gain=tuple(decimal(v) for v in changed))


def latency(dice: Random, b: Held) -> Task:
    return with_control(b.task, latency=decimal(b.task.control.latency + b.task.sampling_period * (harder(dice, 1) - 1)))


def noise(dice: Random, b: Held) -> Task:
    name = dice.choice(("noise", "noise_v"))
    least = Fraction(1, 200)
    return with_plant(b.task, **{name: decimal((getattr(b.task.plant, name) or 0) + least * (harder(dice, 5) - 1))})


def e_max(dice: Random, b: Held) -> Task:
    """The clamp lower, which weakens the law, or higher."""
    by = Fraction(2) ** dice.randint(-12, -1)
    i = dice.randrange(b.task.dimension)
    own = b.task.e_max[i]
    value = own * (1 - by) if dice.random() < 0.7 else 1 - (1 - own) * (1 - by)
    return with_control(b.task, e_max=entry(b.task.e_max, i, decimal(value)))


def share(dice: Random, b: Held) -> Task:
    own = b.task.initial_set.share
    return with_start(b.task, share=decimal(1 - (1 - own) * (1 - Fraction(2) ** dice.randint(-16, -1))))


def speed(dice: Random, b: Held) -> Task:
    i = dice.randrange(b.task.dimension)
    room = max(start_rooms(b.task, b.design)[i], Fraction(1, 1000))
    by = dice.choice((Fraction(dice.randint(1, 16), 16), 1 + dice.choice((-1, 1)) * Fraction(1, 1 << dice.randint(4, 20))))
    return with_start(b.task, speed=entry(b.task.start_speed, i, decimal(room * by)))


def limit(dice: Random, b: Held) -> Task:
    """u_max of one component lower; one where there was none."""
    i, needed = dice.randrange(b.task.dimension), greatest(b.design, 0) + PUSH
    given = b.task.u_max or (2 * needed,) * b.task.dimension
    return with_control(b.task, u_max=tuple(map(decimal, entry(given, i, given[i] / harder(dice, 0)))))


def plant(dice: Random, b: Held, names: Sequence[str]) -> Task:
    """One of its bounds harder."""
    name, by = dice.choice(names), harder(dice, 1)
    if name == "g_min":
        return with_plant(b.task, g_min=decimal(min(v.g_min for v in b.task.plant_bounds) / by))
    if name == "g_max":
        return with_plant(b.task, g_max=decimal(max(v.g_max for v in b.task.plant_bounds) * by))
    if name == "g_cross":
        return with_plant(b.task, g_cross=decimal((b.task.plant.g_cross or 0) + (by - 1) / 4))
    return with_plant(b.task, **{name: decimal((getattr(b.task.plant, name) or Fraction(0)) + PUSH * (by - 1))})


HELD: dict[str, Callable[[Random, Held], Task]] = {
    "held: period": period,
    "held: period at its longest": period_at_longest,
    "held: gain": gain,
    "held: latency": latency,
    "held: noise": noise,
    "held: e_max": e_max,
    "held: share": share,
    "held: speed of the starts": speed,
    "held: input limit": limit,
    "held: push": partial(plant, names=("f_max", "w_max")),
    "held: g": partial(plant, names=("g_min", "g_max", "g_cross")),
}


def draw_held(dice: Random, names: Sequence[str] = NAMES, kinds: Sequence[str] = tuple(HELD)) -> tuple[str, str, Held, Mutant]:
    """A kind, the base's name, the base, and a mutant."""
    kind = dice.choice(list(kinds))
    for _ in range(1000):
        name, way = dice.choice(names), dice.choice((*WAYS[:3], *WAYS))
        b = held_base(name, way)
        if b is None:
            continue
        task = HELD[kind](dice, b)
        if max(*task.e_max, task.initial_set.share) < 1 and min(*task.gain, *task.e_max, task.sampling_period) > 0:
            return kind, f"{name}, {way}", b, (task, b.design)
    raise RuntimeError(f"no mutant of the kind {kind!r} from {', '.join(names)}")
