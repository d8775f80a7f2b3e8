"""Mutants of order 2 for `mutations.py --inertia`: certified tubes for plants of order 2 bent, or what is claimed of them made
harder, one change each.

Bases: the case study, others of tasks/ and random arenas as plants of order 2, in four ways: starts at rest or with a speed, u
free or limited with bounds on the plant, so that P8 is claimed. Sizes are of every magnitude, one unit of the table too. "at the
flip": as large as it may be to the unit, by the truth, and a little more or less.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial
from random import Random
from typing import Any

from benchmarks.mutants.tubes import (
    TASKS,
    Base,
    Mutant,
    amount,
    bend,
    bent,
    entry,
    repeat,
    shift,
    short,
    slack,
    somewhere,
    swap,
    well_formed,
)
from benchmarks.oracles.order_two import first_inertia_fault, greatest, piece, spare_input, value
from benchmarks.suites.families import FAMILIES, arena_task
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task, design_tube
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task

OWN = ("omni_s1", "omni_s2", "omni_s3", "spacecraft", "trolley", "drone")
NAMES = (*OWN, *(f"paper {seed}" for seed in range(12)), *(f"dense12 {seed}" for seed in range(3)), "space3 0")
WAYS = ("rest", "moving", "limited", "moving limited")
SCALARS = {"float": 24, "double": 53}
PUSH = Fraction(3, 10)


def inertial_task(name: str, scalar: str) -> Task:
    """A task or arena as a plant of order 2 with nothing else said of u, plant and starts."""
    family, _, seed = name.partition(" ")
    task = arena_task(FAMILIES[family], int(seed)) if seed else load_task(TASKS / f"{name}.toml")
    prefer = "slow" if scalar == "double" else "balanced"  # slow tubes narrow, which is what breaks W' + lambda W
    tube = {"clearance": task.tube.clearance, "min_width": task.tube.min_width, "prefer": prefer}
    given: dict[str, Any] = {v: getattr(task, v) for v in task.model_fields_set - {"tube", "control", "plant", "emit", "map"}}
    given["initial_set"] = {"lower": task.initial_set.lower, "upper": task.initial_set.upper}
    return Task(**given, tube=tube, plant={"order": 2}, emit={"scalar": scalar})


@cache
def tube_of(name: str, scalar: str) -> tuple[Task, RefinedDesign] | None:
    task = inertial_task(name, scalar)
    try:
        design = design_tube(task.changed(plant={"w_max": PUSH}))
    except NotCertified:
        return None
    assert isinstance(design, RefinedDesign)
    return task, design


@cache
def inertial_base(name: str, scalar: str, way: str) -> Base | None:
    """A certified tube of order 2 with what is claimed of it; None where there is none."""
    found = tube_of(name, scalar)
    if found is None:
        return None
    (task, design), dice = found, Random(f"{name} {scalar} {way}")
    plant: dict[str, Any] = {"w_max": PUSH}
    if "moving" in way:
        share = Fraction(dice.choice((50, 70, 90)), 100)
        room = [v * Fraction(dice.choice((2, 5, 8)), 10) for v in start_rooms(task.changed(initial_set={"share": share}), design)]
        task = task.changed(initial_set={"share": share, "speed": tuple(max(short(v), Fraction(1, 1 << 20)) for v in room)})
    if "limited" in way:
        plant |= {"f_max": Fraction(dice.choice((0, 1)), 10), "g_min": Fraction(dice.choice((6, 9, 10)), 10)}
        plant |= {"g_cross": Fraction(dice.choice((0, 0, 2)), 100)}
        most = max(greatest(design, i) for i in range(design.dimension))
        needed = (most + PUSH + plant["f_max"]) / (plant["g_min"] - plant["g_cross"] * (design.dimension - 1))
        u_max = short(needed * Fraction(dice.choice((101, 105, 130, 200)), 100))
        task = task.changed(control={"u_max": (u_max,) * design.dimension})
    try:
        c = build_task(task.changed(plant=plant), tube=design)
    except NotCertified:
        return None
    return Base(c.task, design, {f.code: f.margin for f in c.certificate.findings})


def start_rooms(task: Task, design: RefinedDesign) -> list[Fraction]:
    """The largest speed of a start in the share, by component: where z would be on an edge of the filtered tube."""
    found = []
    for i in range(design.dimension):
        first = piece(design, 0, i)
        low, high = (value(first.derived(p), Fraction(0)) for p in (first.lower, first.upper))
        inside = first.value * (1 - task.initial_set.share) / 2 * value(first.width, Fraction(0))
        found.append(inside + min(-low, high))
    return found


# ------------------------------------------------------------------------------------------------ the table


def unit_moved(dice: Random, table: Any) -> None:
    """One entry by one unit, or a few, often of the rows that start and stop the tube."""
    j, i, side = somewhere(dice, table)
    j = dice.choice((0, 1, 2, len(table) - 1, len(table) - 2, len(table) - 3, j, j))
    table[j, i, side] += dice.choice((-1, 1)) * dice.choice((1, 1, 2, 5))


def stop(dice: Random, table: Any, all_three: bool) -> None:
    """The end no longer at rest; or all of it elsewhere."""
    _, i, side = somewhere(dice, table)
    rows = [-3, -2, -1] if all_three else dice.choice(([-1], [-2], [-3], [-1, -2], [-1, -3], [-2, -3]))
    table[rows, i, side] += amount(dice, dice.choice((3, 14)))


def start_turned(dice: Random, table: Any) -> None:
    """An edge's rate at 0, which is 0 in most tubes."""
    _, i, side = somewhere(dice, table)
    table[dice.choice((0, 2)), i, side] += amount(dice, dice.choice((2, 14)))


def flip(safe: Callable[[int], bool], top: int) -> int | None:
    """The largest whole number below 2^top up to which it is safe, by halving; None where all is, or nothing."""
    low, high = 0, 1 << top
    if safe(high) or not safe(low):
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if safe(middle) else (low, middle)
    return low


def near(dice: Random) -> int:
    """Beside a flip: on its safe side or beyond it by one unit, or more."""
    return dice.choice((0, 1, 1 + abs(amount(dice, 8)), -abs(amount(dice, 8))))


def coefficient_at_flip(dice: Random, b: Base) -> Mutant:
    """One entry moved until the truth of order 2 turns."""
    for _ in range(20):
        j, i, side = dice.randrange(len(b.design.table)), dice.randrange(b.task.dimension), dice.randrange(2)
        sign = dice.choice((-1, 1))

        def moved(by: int, j: int = j, i: int = i, side: int = side, sign: int = sign) -> RefinedDesign:
            table = [[list(pair) for pair in row] for row in b.design.table]
            table[j][i][side] += sign * by
            return replace(b.design, table=tuple(tuple((p, q) for p, q in row) for row in table))

        last = b.design.segments - 1
        around = range(max(j - 3, 0), min(j, last) + 1)
        found = flip(lambda by, m=moved, a=around: first_inertia_fault(b.task, m(by), 0, a) is None, 20)  # type: ignore[misc]
        if found is not None:
            return b.task, moved(max(found + near(dice), 1))
    raise ValueError("no entry turns it")


# ------------------------------------------------------------------------------------------------ lambda and the time


def with_filter(b: Base, i: int, wanted: Fraction) -> Mutant:
    """lambda of a component as a number of the scalar."""
    bits, whole = SCALARS[b.task.emit.scalar], max(wanted, Fraction(1, 1 << 20))
    grain = Fraction(2) ** (whole.numerator.bit_length() - whole.denominator.bit_length() + 1 - bits)
    return b.task, replace(b.design, filter=entry(b.design.filter, i, round(whole / grain) * grain))


def factor(dice: Random, most: int = 1) -> Fraction:
    """1 but for 2^-24 to 2^most, up or down."""
    by = Fraction(2) ** dice.randint(-24, most) * Fraction(dice.randint(8, 16), 16)
    return 1 + by if dice.random() < 0.5 else 1 / (1 + by)


def filter_changed(dice: Random, b: Base) -> Mutant:
    i = dice.randrange(b.task.dimension)
    return with_filter(b, i, b.design.filter[i] * factor(dice))


def filter_at_flip(dice: Random, b: Base) -> Mutant:
    """lambda raised or lowered until the truth of order 2 turns."""
    i, up = dice.randrange(b.task.dimension), dice.random() < 0.5
    own, grain = b.design.filter[i], Fraction(1, 1 << 20)
    step = (3 * own if up else -own) / (1 << 14)

    def at(by: int) -> Mutant:
        return with_filter(b, i, own + by * step)

    found = flip(lambda by: first_inertia_fault(*at(by)) is None, 14)
    if found is None:
        raise ValueError("no lambda turns it")
    low = at(found)[1].filter[i]  # finer, within one of these steps
    fine = flip(lambda by: first_inertia_fault(*with_filter(b, i, low + by * step * grain)) is None, 20)
    return with_filter(b, i, low + ((fine or 0) + near(dice)) * step * grain)


def with_time(b: Base, t_c: Fraction) -> Mutant:
    return b.task.model_copy(update={"prescribed_time": t_c}), replace(b.design, prescribed_time=t_c)


def time_changed(dice: Random, b: Base) -> Mutant:
    """A slower or a faster task, with the same table."""
    return with_time(b, short(b.task.prescribed_time * factor(dice)))


def time_at_flip(dice: Random, b: Base) -> Mutant:
    """As fast as it may be."""
    t_c = b.task.prescribed_time

    def at(by: int) -> Mutant:
        return with_time(b, short(t_c * (1 - Fraction(by, 1 << 20) * Fraction(15, 16))))

    found = flip(lambda by: first_inertia_fault(*at(by)) is None, 20)
    if found is None:
        raise ValueError("no time turns it")
    return at(max(found + near(dice), 1))


# ------------------------------------------------------------------------------------------------ what is claimed


def with_plant(b: Base, **change: Fraction) -> Mutant:
    return b.task.model_copy(update={"plant": b.task.plant.model_copy(update=change)}), b.design


def some_slack(dice: Random, b: Base) -> Fraction:
    """Of table units, or of a part of the number."""
    return dice.choice((slack(dice, b), Fraction(dice.choice((-1, 1)), 1 << dice.randint(1, 32))))


def speed_raised(dice: Random, b: Base) -> Mutant:
    """The speed of starts as large as may be, to the last digit where it has finitely many."""
    i = dice.randrange(b.task.dimension)
    most = start_rooms(b.task, b.design)[i] - dice.choice((Fraction(0), some_slack(dice, b)))
    exact = most.denominator & (most.denominator - 1) == 0 or most.denominator in (5**j << k for j in range(4) for k in range(60))
    speed = entry(b.task.start_speed, i, most if exact else short(most) + Fraction(dice.choice((0, 1)), 1 << 32))
    return b.task.model_copy(update={"initial_set": b.task.initial_set.model_copy(update={"speed": speed})}), b.design


def share_raised(dice: Random, b: Base) -> Mutant:
    """Starts nearer to the edges, as near as the speed lets them be."""
    i = dice.randrange(b.task.dimension)
    first, speed = piece(b.design, 0, i), b.task.start_speed[i]
    low, high = (value(first.derived(p), Fraction(0)) for p in (first.lower, first.upper))
    room = 2 * (speed - min(-low, high)) / (first.value * value(first.width, Fraction(0)))
    share = short(1 - room) - some_slack(dice, b)
    return b.task.model_copy(update={"initial_set": b.task.initial_set.model_copy(update={"share": share})}), b.design


def _least_spare(b: Base, i: int) -> Fraction:
    """What an input has to spare over all that pushes."""
    found = spare_input(b.task)
    if found is None:
        raise ValueError("u is not limited")
    return found[i] - greatest(b.design, i)


def limit_lowered(dice: Random, b: Base) -> Mutant:
    """u_max of one component as small as may be."""
    i = dice.randrange(b.task.dimension)
    least = _least_spare(b, i) / (b.task.plant.g_min or 1) + some_slack(dice, b)
    limit = tuple(short(v - least) if k == i else v for k, v in enumerate(b.task.u_max or ()))
    return b.task.model_copy(update={"control": b.task.control.model_copy(update={"u_max": limit})}), b.design


def plant_harder(dice: Random, b: Base) -> Mutant:
    """One bound of the plant as hard as may be."""
    i = dice.randrange(b.task.dimension)
    least, plant = _least_spare(b, i) - some_slack(dice, b), b.task.plant
    limits = b.task.u_max or ()
    name = dice.choice(("f_max", "w_max", "g_min", "g_cross"))
    if name == "g_min":
        return with_plant(b, g_min=short((plant.g_min or Fraction(1)) - least / limits[i]))
    others = sum(limits) - limits[i] if name == "g_cross" else Fraction(1)
    return with_plant(b, **{name: short((getattr(plant, name) or Fraction(0)) + least / others)})


INERTIAL: dict[str, Callable[[Random, Base], Mutant]] = {
    "one unit": bent(unit_moved),
    "one coefficient": bent(partial(bend, most=1)),
    "several coefficients": bent(partial(bend, most=8)),
    "coefficient at the flip": coefficient_at_flip,
    "entries swapped": bent(swap),
    "row shifted": bent(shift),
    "row repeated": bent(repeat),
    "not at rest at the end": bent(partial(stop, all_three=False)),
    "end moved": bent(partial(stop, all_three=True)),
    "start turned": bent(start_turned),
    "lambda": filter_changed,
    "lambda at the flip": filter_at_flip,
    "prescribed time": time_changed,
    "time at the flip": time_at_flip,
    "speed of the starts": speed_raised,
    "share of the starts": share_raised,
    "input limit": limit_lowered,
    "plant": plant_harder,
}
NEEDS = {"share of the starts": "moving", "speed of the starts": "moving", "input limit": "limited", "plant": "limited"}


def draw_inertial(
    dice: Random, names: Sequence[str] = NAMES, kinds: Sequence[str] = tuple(INERTIAL)
) -> tuple[str, str, Base, Mutant]:
    """A kind, the base's name, the base, and a mutant that is well formed."""
    kind = dice.choice(list(kinds))
    for _ in range(1000):
        name, scalar = dice.choice(names), dice.choice(("float", "double"))
        way = dice.choice([w for w in WAYS if NEEDS.get(kind, "") in w])
        b = inertial_base(name, scalar, way)
        with contextlib.suppress(ValueError, IndexError):
            if b is not None and possible(mutant := INERTIAL[kind](dice, b)):
                return kind, f"{name}, {scalar}, {way}", b, mutant
    raise RuntimeError(f"no mutant of the kind {kind!r} from {', '.join(names)}")


def possible(mutant: Mutant) -> bool:
    """Whether a task file can say it."""
    task, design = mutant
    plant, first = task.plant, task.initial_set
    positive = (*design.filter, task.prescribed_time, least(plant.g_min), *(task.u_max or ()), first.share)
    not_negative = (*task.start_speed, *(v for v in plant.bounds.values() if v is not None))
    return well_formed(task) and min(positive) > 0 and min(not_negative) >= 0 and first.share < 1


def least(given: Fraction | None) -> Fraction:
    return Fraction(1) if given is None else given
