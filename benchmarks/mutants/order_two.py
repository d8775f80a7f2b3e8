"""Mutants of order 2 for `mutations.py --inertia`: certified tubes for plants of order 2 with a changed table or filter, or their
claims made harder, by one random change each.

Bases are the case study, other tasks and random arenas, as plants of order 2, in four ways: starts at rest or with a speed, u
free or limited with bounds on the plant, so that P8 is claimed. Sizes are of every magnitude, down to one unit of the table. "at
the flip" is the largest change that the oracle calls safe, and a little more or less. The order of random draws is part of the
benchmark.
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
    BaseTube,
    DrawnMutant,
    Mutant,
    Mutation,
    change_entries,
    draw_change,
    draw_entry,
    draw_margin,
    floor_to_file,
    is_well_formed,
    repeat_row,
    shift_row,
    swap_entries,
    table_mutation,
    with_entry,
)
from benchmarks.oracles.order_two import (
    control_authority,
    first_order_two_fault,
    largest_demanded_acceleration,
    spline_piece,
)
from benchmarks.oracles.sturm import evaluate
from benchmarks.suites.families import FAMILIES, arena_task
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task, preferred_tube
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task

TASK_NAMES = ("omni_s1", "omni_s2", "omni_s3", "spacecraft", "trolley", "drone")
BASE_NAMES = (*TASK_NAMES, *(f"paper {seed}" for seed in range(12)), *(f"dense12 {seed}" for seed in range(3)), "space3 0")
CLAIMS = ("rest", "moving", "limited", "moving limited")  # at rest or with a speed; u free or limited
SIGNIFICANT_BITS = {"float": 24, "double": 53}
DISTURBANCE = Fraction(3, 10)  # w_max of every base
SMALLEST_VALUE = Fraction(1, 1 << 20)  # of a speed or of lambda


def order_two_task(name: str, scalar: str) -> Task:
    """Return a task or arena as a plant of order 2, without its gain, limits of u, bounds of the plant and speeds of starts."""
    family, _, seed = name.partition(" ")
    task = arena_task(FAMILIES[family], int(seed)) if seed else load_task(TASKS / f"{name}.toml")
    prefer = "slow" if scalar == "double" else "balanced"  # slow tubes narrow, which is what breaks W' + lambda W
    tube = {"clearance": task.tube.clearance, "min_width": task.tube.min_width, "prefer": prefer}
    tables: dict[str, Any] = {v: getattr(task, v) for v in task.model_fields_set - {"tube", "control", "plant", "emit", "map"}}
    tables["initial_set"] = {"lower": task.initial_set.lower, "upper": task.initial_set.upper}
    return Task(**tables, tube=tube, plant={"order": 2}, emit={"scalar": scalar})


@cache
def order_two_design(name: str, scalar: str) -> tuple[Task, RefinedDesign] | None:
    """Design the tube of `order_two_task`, whose task is returned with it; None where there is no tube."""
    task = order_two_task(name, scalar)
    try:
        design = preferred_tube(task.changed(plant={"w_max": DISTURBANCE}))
    except NotCertified:
        return None
    assert isinstance(design, RefinedDesign)
    return task, design


@cache
def order_two_base(name: str, scalar: str, claims: str) -> BaseTube | None:
    """Return a certified tube of order 2 with random claims of a kind of CLAIMS; None where it is not certified."""
    designed = order_two_design(name, scalar)
    if designed is None:
        return None
    (task, design), rng = designed, Random(f"{name} {scalar} {claims}")
    plant: dict[str, Any] = {"w_max": DISTURBANCE}
    if "moving" in claims:
        share = Fraction(rng.choice((50, 70, 90)), 100)
        largest = largest_start_speeds(task.changed(initial_set={"share": share}), design)
        speeds = [v * Fraction(rng.choice((2, 5, 8)), 10) for v in largest]
        speed = tuple(max(floor_to_file(v), SMALLEST_VALUE) for v in speeds)
        task = task.changed(initial_set={"share": share, "speed": speed})
    if "limited" in claims:
        plant |= {"f_max": Fraction(rng.choice((0, 1)), 10), "g_min": Fraction(rng.choice((6, 9, 10)), 10)}
        plant |= {"g_cross": Fraction(rng.choice((0, 0, 2)), 100)}
        required = max(largest_demanded_acceleration(design, i) for i in range(design.dimension))
        needed_input = (required + DISTURBANCE + plant["f_max"]) / (plant["g_min"] - plant["g_cross"] * (design.dimension - 1))
        u_max = floor_to_file(needed_input * Fraction(rng.choice((101, 105, 130, 200)), 100))
        task = task.changed(control={"u_max": (u_max,) * design.dimension})
    try:
        controller = build_task(task.changed(plant=plant), tube=design)
    except NotCertified:
        return None
    return BaseTube(controller.task, design, {finding.code: finding.margin for finding in controller.certificate.findings})


def largest_start_speeds(task: Task, design: RefinedDesign) -> list[Fraction]:
    """Return the largest speed of a start in the start share, by component: with it z is on an edge of the filtered tube."""
    speeds = []
    for i in range(design.dimension):
        first = spline_piece(design, 0, i)
        low, high = (evaluate(first.time_derivative(p), Fraction(0)) for p in (first.lower, first.upper))
        inside = first.lambda_ * (1 - task.initial_set.share) / 2 * evaluate(first.width, Fraction(0))
        speeds.append(inside + min(-low, high))
    return speeds


# ------------------------------------------------------------------------------------------------ the table


def change_by_few_units(rng: Random, table: Any) -> None:
    """Change one entry by one unit, or a few, often in a row at which the tube starts or stops."""
    j, i, side = draw_entry(rng, table)
    j = rng.choice((0, 1, 2, len(table) - 1, len(table) - 2, len(table) - 3, j, j))
    table[j, i, side] += rng.choice((-1, 1)) * rng.choice((1, 1, 2, 5))


def move_last_rows(rng: Random, table: Any, all_three: bool) -> None:
    """Move an edge in some of the last three rows, so that it is not at rest at the end; or in all of them, so that the end is
    elsewhere."""
    _, i, side = draw_entry(rng, table)
    rows = [-3, -2, -1] if all_three else rng.choice(([-1], [-2], [-3], [-1, -2], [-1, -3], [-2, -3]))
    table[rows, i, side] += draw_change(rng, rng.choice((3, 14)))


def turn_start(rng: Random, table: Any) -> None:
    """Change an edge's rate at 0, which is 0 in most tubes."""
    _, i, side = draw_entry(rng, table)
    table[rng.choice((0, 2)), i, side] += draw_change(rng, rng.choice((2, 14)))


def last_safe_step(is_safe: Callable[[int], bool], bits: int) -> int | None:
    """Return by halving a step below 2^bits that is safe, while the next one is not; None where all are safe, or step 0 is
    not."""
    low, high = 0, 1 << bits
    if is_safe(high) or not is_safe(low):
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if is_safe(middle) else (low, middle)
    return low


def draw_beside_flip(rng: Random) -> int:
    """Draw how many steps beyond the last safe one a mutant is: 0, one, more, or less than none."""
    return rng.choice((0, 1, 1 + abs(draw_change(rng, 8)), -abs(draw_change(rng, 8))))


def move_coefficient_to_flip(rng: Random, base: BaseTube) -> Mutant:
    """Move one entry until the oracle of order 2 changes its answer."""
    for _ in range(20):
        j, i, side = rng.randrange(len(base.design.table)), rng.randrange(base.task.dimension), rng.randrange(2)
        moved = partial(_with_moved_entry, base.design, (j, i, side), rng.choice((-1, 1)))
        segments = range(max(j - 3, 0), min(j, base.design.segments - 1) + 1)  # those that the entry shapes
        step = last_safe_step(partial(_is_safe_in_segments, base.task, moved, segments), 20)
        if step is not None:
            return Mutant(base.task, moved(max(step + draw_beside_flip(rng), 1)))
    raise ValueError("no entry changes the answer")


def _with_moved_entry(design: RefinedDesign, index: tuple[int, int, int], sign: int, by: int) -> RefinedDesign:
    """Return the design with one entry of its table moved by sign * by units."""
    j, i, side = index
    table = [[list(pair) for pair in row] for row in design.table]
    table[j][i][side] += sign * by
    return replace(design, table=tuple(tuple((lower, upper) for lower, upper in row) for row in table))


def _is_safe_in_segments(task: Task, moved: Callable[[int], RefinedDesign], segments: range, by: int) -> bool:
    """Whether the oracle finds no fault of order 2 in these segments once an entry has moved by so many units."""
    return first_order_two_fault(task, moved(by), 0, segments) is None


def _is_safe(mutant: Mutant) -> bool:
    """Whether the oracle finds no fault of order 2."""
    return first_order_two_fault(*mutant) is None


# ------------------------------------------------------------------------------------------------ lambda and the time


def with_lambda(base: BaseTube, i: int, wanted: Fraction) -> Mutant:
    """Return the tube with lambda of a component, rounded to a number of the scalar."""
    bits, positive = SIGNIFICANT_BITS[base.task.emit.scalar], max(wanted, SMALLEST_VALUE)
    spacing = Fraction(2) ** (positive.numerator.bit_length() - positive.denominator.bit_length() + 1 - bits)
    rounded = round(positive / spacing) * spacing
    return Mutant(base.task, replace(base.design, filter=with_entry(base.design.filter, i, rounded)))


def draw_factor(rng: Random, largest_power: int = 1) -> Fraction:
    """Draw a factor that differs from 1 by 2^-24 to 2^largest_power, up or down."""
    by = Fraction(2) ** rng.randint(-24, largest_power) * Fraction(rng.randint(8, 16), 16)
    return 1 + by if rng.random() < 0.5 else 1 / (1 + by)


def change_lambda(rng: Random, base: BaseTube) -> Mutant:
    i = rng.randrange(base.task.dimension)
    return with_lambda(base, i, base.design.filter[i] * draw_factor(rng))


def move_lambda_to_flip(rng: Random, base: BaseTube) -> Mutant:
    """Raise or lower lambda of a component until the oracle of order 2 changes its answer: in 2^14 steps, then in finer ones."""
    i, is_raised = rng.randrange(base.task.dimension), rng.random() < 0.5
    original, fineness = base.design.filter[i], Fraction(1, 1 << 20)
    step = (3 * original if is_raised else -original) / (1 << 14)
    coarse = last_safe_step(lambda by: _is_safe(with_lambda(base, i, original + by * step)), 14)
    if coarse is None:
        raise ValueError("no lambda changes the answer")
    low = with_lambda(base, i, original + coarse * step).design.filter[i]
    fine = last_safe_step(lambda by: _is_safe(with_lambda(base, i, low + by * step * fineness)), 20)
    return with_lambda(base, i, low + ((fine or 0) + draw_beside_flip(rng)) * step * fineness)


def with_prescribed_time(base: BaseTube, t_c: Fraction) -> Mutant:
    return Mutant(base.task.model_copy(update={"prescribed_time": t_c}), replace(base.design, prescribed_time=t_c))


def change_prescribed_time(rng: Random, base: BaseTube) -> Mutant:
    """Make the task slower or faster, with the same table."""
    return with_prescribed_time(base, floor_to_file(base.task.prescribed_time * draw_factor(rng)))


def move_prescribed_time_to_flip(rng: Random, base: BaseTube) -> Mutant:
    """Make the task faster until the oracle of order 2 changes its answer."""
    t_c = base.task.prescribed_time

    def faster_by(steps: int) -> Mutant:
        return with_prescribed_time(base, floor_to_file(t_c * (1 - Fraction(steps, 1 << 20) * Fraction(15, 16))))

    steps = last_safe_step(lambda by: _is_safe(faster_by(by)), 20)
    if steps is None:
        raise ValueError("no time changes the answer")
    return faster_by(max(steps + draw_beside_flip(rng), 1))


# ------------------------------------------------------------------------------------------------ the claims


def with_plant(base: BaseTube, **change: Fraction) -> Mutant:
    return Mutant(base.task.model_copy(update={"plant": base.task.plant.model_copy(update=change)}), base.design)


def with_start(base: BaseTube, **change: Any) -> Mutant:
    return Mutant(base.task.model_copy(update={"initial_set": base.task.initial_set.model_copy(update=change)}), base.design)


def draw_claim_margin(rng: Random, base: BaseTube) -> Fraction:
    """Draw a margin, in table units or as a part of 1, of either sign."""
    return rng.choice((draw_margin(rng, base), Fraction(rng.choice((-1, 1)), 1 << rng.randint(1, 32))))


def raise_start_speed(rng: Random, base: BaseTube) -> Mutant:
    """Raise the speed of starts to its limit minus a drawn margin; exactly to it if the limit has finitely many digits."""
    i = rng.randrange(base.task.dimension)
    speed = largest_start_speeds(base.task, base.design)[i] - rng.choice((Fraction(0), draw_claim_margin(rng, base)))
    divisor = speed.denominator
    is_decimal = divisor & (divisor - 1) == 0 or divisor in (5**j << k for j in range(4) for k in range(60))
    written = speed if is_decimal else floor_to_file(speed) + Fraction(rng.choice((0, 1)), 1 << 32)
    return with_start(base, speed=with_entry(base.task.start_speed, i, written))


def raise_start_share(rng: Random, base: BaseTube) -> Mutant:
    """Raise the start share to the largest one whose start speeds keep z in the filtered tube, minus a drawn margin."""
    i = rng.randrange(base.task.dimension)
    first, speed = spline_piece(base.design, 0, i), base.task.start_speed[i]
    low, high = (evaluate(first.time_derivative(p), Fraction(0)) for p in (first.lower, first.upper))
    excluded_share = 2 * (speed - min(-low, high)) / (first.lambda_ * evaluate(first.width, Fraction(0)))
    return with_start(base, share=floor_to_file(1 - excluded_share) - draw_claim_margin(rng, base))


def _acceleration_margin(base: BaseTube, i: int) -> Fraction:
    """Return by how much the available acceleration exceeds the required one. Raises ValueError where u is not limited."""
    available = control_authority(base.task)
    if available is None:
        raise ValueError("u is not limited")
    return available[i] - largest_demanded_acceleration(base.design, i)


def lower_input_limit(rng: Random, base: BaseTube) -> Mutant:
    """Lower u_max of one component by its margin, plus or minus a drawn amount."""
    i = rng.randrange(base.task.dimension)
    margin = _acceleration_margin(base, i) / (base.task.plant.g_min or 1) + draw_claim_margin(rng, base)
    u_max = tuple(floor_to_file(v - margin) if k == i else v for k, v in enumerate(base.task.u_max or ()))
    return Mutant(base.task.model_copy(update={"control": base.task.control.model_copy(update={"u_max": u_max})}), base.design)


def worsen_plant(rng: Random, base: BaseTube) -> Mutant:
    """Worsen one bound of the plant by the margin of a component, plus or minus a drawn amount."""
    i = rng.randrange(base.task.dimension)
    margin, plant = _acceleration_margin(base, i) - draw_claim_margin(rng, base), base.task.plant
    limits = base.task.u_max or ()
    name = rng.choice(("f_max", "w_max", "g_min", "g_cross"))
    if name == "g_min":
        return with_plant(base, g_min=floor_to_file((plant.g_min or Fraction(1)) - margin / limits[i]))
    multiplier = sum(limits) - limits[i] if name == "g_cross" else Fraction(1)  # what the bound multiplies in P8
    return with_plant(base, **{name: floor_to_file((getattr(plant, name) or Fraction(0)) + margin / multiplier)})


ORDER_TWO_MUTATIONS: dict[str, Mutation] = {
    "one unit": table_mutation(change_by_few_units),
    "one coefficient": table_mutation(partial(change_entries, count_at_most=1)),
    "several coefficients": table_mutation(partial(change_entries, count_at_most=8)),
    "coefficient at the flip": move_coefficient_to_flip,
    "entries swapped": table_mutation(swap_entries),
    "row shifted": table_mutation(shift_row),
    "row repeated": table_mutation(repeat_row),
    "not at rest at the end": table_mutation(partial(move_last_rows, all_three=False)),
    "end moved": table_mutation(partial(move_last_rows, all_three=True)),
    "start turned": table_mutation(turn_start),
    "lambda": change_lambda,
    "lambda at the flip": move_lambda_to_flip,
    "prescribed time": change_prescribed_time,
    "time at the flip": move_prescribed_time_to_flip,
    "speed of the starts": raise_start_speed,
    "share of the starts": raise_start_share,
    "input limit": lower_input_limit,
    "plant": worsen_plant,
}
# What a base must claim for a mutation.
NEEDED_CLAIMS = {
    "share of the starts": "moving",
    "speed of the starts": "moving",
    "input limit": "limited",
    "plant": "limited",
}


def draw_order_two_mutant(
    rng: Random, names: Sequence[str] = BASE_NAMES, kinds: Sequence[str] = tuple(ORDER_TWO_MUTATIONS)
) -> DrawnMutant:
    """Draw a mutation of these kinds, a base of these names, and a mutant that a task file can state."""
    kind = rng.choice(list(kinds))
    for _ in range(1000):
        name, scalar = rng.choice(names), rng.choice(("float", "double"))
        claims = rng.choice([c for c in CLAIMS if NEEDED_CLAIMS.get(kind, "") in c])
        base = order_two_base(name, scalar, claims)
        with contextlib.suppress(ValueError, IndexError):
            if base is not None and can_be_stated(mutant := ORDER_TWO_MUTATIONS[kind](rng, base)):
                return DrawnMutant(kind, f"{name}, {scalar}, {claims}", base, mutant)
    raise RuntimeError(f"no mutant of the kind {kind!r} from {', '.join(names)}")


def can_be_stated(mutant: Mutant) -> bool:
    """Whether a task file may say this: numbers above 0, bounds not below 0, a start share below 1."""
    task, design = mutant
    plant, start = task.plant, task.initial_set
    g_min = Fraction(1) if plant.g_min is None else plant.g_min
    positive = (*design.filter, task.prescribed_time, g_min, *(task.u_max or ()), start.share)
    not_negative = (*task.start_speed, *(v for v in plant.bounds.values() if v is not None))
    return is_well_formed(task) and min(positive) > 0 and min(not_negative) >= 0 and start.share < 1
