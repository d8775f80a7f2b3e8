"""Count false certificates of missions: P10 is certified, although a trajectory in the tube breaks the mission.

    python -m benchmarks mission_mutants [--count 10000] [--first 0] [--record benchmarks/RESULTS.md]

A base is a mission and its tube. A mutant moves control points of the tube, or changes an edge of a region, a window or an
operator of the mission. The oracle uses neither intervals nor margins. It follows trajectories along edges and corners of the
exact tube, and evaluates the formula at samples by its definition; between two samples it assumes the better. The exit code is 1
where a mutant is certified and a trajectory breaks its formula. docs/missions.md has the definitions.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np

from benchmarks.suites.report import command, machine, record, table
from benchmarks.suites.scenarios import project_scenarios, random_mission, stlpy_scenarios
from stt_codegen.certify.claims import units_of_error
from stt_codegen.certify.missions.proof import certify_mission
from stt_codegen.controller.edge_errors import edge_error
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_program, preferred_tube
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.mission.formulas import Always, And, Eventually, Formula, InRegion, Interval, Or, Until, regions_of
from stt_codegen.task.mission.regions import RegionUnion, StateFormula
from stt_codegen.task.task import Task

Array = Any
TASKS = Path(__file__).parent.parent / "tasks"
RESPONSE = "always (gate -> eventually[0, 8] office) and always eventually[0, 14] gate"
REPEATED_CYCLES = 3  # cycles that the oracle follows after the first, where a mission repeats for ever
RANDOM_MISSIONS = 6  # among the bases
SAMPLES_PER_SEGMENT = 24  # the tool cuts segments at some of these times
MUTATIONS = ("window", "edge", "operator", "knot", "stretch", "shift")


class Case(NamedTuple):
    """A mission with its tube. error: of the arithmetic, in units of the table. name: of the base, or of the mutation."""

    name: str
    task: Task
    design: RefinedDesign
    error: int


class Judgement(NamedTuple):
    """A mutant's mutation, whether it is certified, and whether a trajectory in the tube breaks the mission."""

    mutation: str
    is_certified: bool
    is_broken: bool


@cache
def bases() -> tuple[Case, ...]:
    """Design the tubes of all bases: scenarios, random missions, tasks that are shipped, and a response without end."""
    texts = [(s.name, s.text) for s in (*project_scenarios(), *stlpy_scenarios()) if not s.is_infeasible]
    tasks = [(name, parse_task(text)) for name, text in texts]
    tasks += [(f"random {k}", parse_task(random_mission(k, 2, 5))) for k in range(RANDOM_MISSIONS)]
    tasks += [(name, load_task(TASKS / f"{name}.toml")) for name in ("courier", "waypoints", "either", "watchman")]
    watchman = (TASKS / "watchman.toml").read_text()
    response = watchman.replace('patrol = ["gate", "office", "store"]\nevery = 14', f'formula = "{RESPONSE}"')
    tasks.append(("response for ever", parse_task(response)))
    cases = []
    for name, task in tasks:
        design = preferred_tube(task)
        assert isinstance(design, RefinedDesign)
        cases.append(Case(name, task, design, units_of_error(design, edge_error(design, build_program(task, design)))))
    return tuple(cases)


# ---------------------------------------------------------------------------------------------------- mutants


def draw_mutant(number: int) -> Case | None:
    """Return a base with one change, drawn by its number; None where the changed task is refused as bad input."""
    rng = Random(number)
    _, task, design, error = rng.choice(bases())
    mutation = rng.choice(MUTATIONS)
    size = 10 ** rng.uniform(-4, 0.2)
    if mutation in ("knot", "stretch", "shift"):
        return Case(mutation, task, with_changed_table(design, rng, mutation, size), error)
    try:
        changed_task = (
            with_changed_edge(task, rng, size) if mutation == "edge" else with_changed_formula(task, rng, mutation, size)
        )
    except BadInput:
        return None
    return Case(mutation, changed_task, design, error)


def with_changed_table(design: RefinedDesign, rng: Random, mutation: str, size: float) -> RefinedDesign:
    """Return the tube with control points of an axis moved: one (knot), up to 12 in a row (stretch), or all from 3 on (shift)."""
    points = design.integers().copy()
    first = rng.randrange(1, len(points) - 3)
    if mutation == "knot":
        last = first + 1
    elif mutation == "stretch":
        last = min(first + rng.randrange(2, 12), len(points) - 3)
    else:
        first, last = 3, len(points)
    i = rng.randrange(points.shape[1])
    step = int(rng.choice((-1, 1)) * size * float(np.ptp(points)) / 4)
    sides = rng.choice(((0,), (1,), (0, 1)))
    for side in sides:
        points[first:last, i, side] += step
    points[:, i] = np.sort(points[:, i], axis=1)
    if design.seam is None:
        points[-1] = points[-3]
    else:
        points[-3:] = points[design.seam : design.seam + 3]
    return replace(design, table=tuple(tuple((int(a), int(b)) for a, b in row) for row in points.tolist()))


def with_changed_edge(task: Task, rng: Random, size: float) -> Task:
    """Return the task with an edge of a box among its regions moved by `size` times its width."""
    boxes = [k for k, r in enumerate(task.region) if not isinstance(r, RegionUnion) and hasattr(r, "lower")]
    k = rng.choice(boxes)
    box, i = task.region[k], rng.randrange(task.dimension)
    edge = rng.choice(("lower", "upper"))
    values = list(getattr(box, edge))
    values[i] += Fraction(str(round(rng.choice((-1, 1)) * size * float(box.upper[i] - box.lower[i]), 6)))  # type: ignore[union-attr]
    regions = [fields_of(r) | ({edge: values} if j == k else {}) for j, r in enumerate(task.region)]
    return task.changed(region=regions)


def with_changed_formula(task: Task, rng: Random, mutation: str, size: float) -> Task:
    """Return the task with an operator or a time of its formulas changed. size: of a time, over a quarter of t_c."""
    texts = [str(e.meaning(task.prescribed_time, task.repeat)) for e in task.mission]
    k = rng.randrange(len(texts))
    if mutation == "operator":
        pairs = (("eventually", "always"), ("always", "eventually"), (" and ", " or "), (" or ", " and "), ("not ", ""))
        old, new = rng.choice([p for p in pairs if p[0] in texts[k]] or [("", "")])
        texts[k] = texts[k].replace(old, new, 1) if old else texts[k]
    else:
        words = texts[k].replace("[", " [ ").replace("]", " ] ").replace(",", " , ").split()
        numbers = [j for j, w in enumerate(words) if w[:1].isdigit()]
        if numbers:
            j = rng.choice(numbers)
            moved = float(words[j]) + rng.choice((-1, 1)) * size * float(task.prescribed_time) / 4
            words[j] = f"{min(max(moved, 0.0), float(task.prescribed_time)):.4f}"
        texts[k] = " ".join(words)
    return task.changed(mission=[{"formula": text} for text in texts])


def fields_of(table_: Any) -> dict[str, Any]:
    """Return the keys that a table of the task file has, with their values."""
    return {name: getattr(table_, name) for name in table_.model_fields_set}


# ---------------------------------------------------------------------------------------------------- the oracle


def trajectories(design: RefinedDesign, rng: Random, t: Array) -> Iterator[Array]:
    """Yield trajectories at the times t, (T, n): along each corner of the tube, and some that go from corner to corner."""
    low, high = design.edges_at(to_cycle_time(design, t))
    n = low.shape[1]
    for corner in itertools.product((0.0, 1.0), repeat=n):
        yield low + np.array(corner) * (high - low)
    for _ in range(6):
        knots = np.linspace(0, t[-1], rng.randrange(4, 60))
        mix = np.array([[rng.randrange(2) for _ in range(n)] for _ in knots], dtype=float)
        share = np.stack([np.interp(t, knots, mix[:, i]) for i in range(n)], axis=1)
        yield low + share * (high - low)


def is_in_region(task: Task, name: str, x: Array, margin: float) -> Array:
    """Return which of the points x, (T, n), are in a region that is grown by `margin`, which may be negative."""
    region = task.regions[name]
    assert not isinstance(region, RegionUnion)
    x = x[:, list(task.axis_indices(region))]
    if hasattr(region, "radius"):
        return np.sqrt(((x - [float(v) for v in region.centre]) ** 2).sum(axis=1)) <= float(region.radius) + margin
    if hasattr(region, "lower"):
        return ((x >= [float(v) - margin for v in region.lower]) & (x <= [float(v) + margin for v in region.upper])).all(axis=1)
    faces = [([float(c) for c in n], float(h)) for n, h in region.half_spaces()]
    return np.all([x @ np.array(n) <= h + margin * np.abs(n).sum() for n, h in faces], axis=0)


def to_cycle_time(design: RefinedDesign, t: Array) -> Array:
    """Return the times at which a tube that repeats has the same edges within its table; of another tube the times."""
    if design.seam is None:
        return t
    t_c = float(design.prescribed_time)
    length = t_c * (1 - design.seam / design.segments)
    return np.where(t < t_c, t, t_c - length + (t - t_c) % length)


def may_hold(formula: Formula, t: Array, atoms: dict[InRegion, Array], endless: bool = False) -> Array:
    """Return at which of the samples t the formula may hold, (T,), if the better is assumed between two samples.

    atoms: for each statement about a region, at which samples it holds. endless: whether time goes on after the last sample,
    where the better is assumed, too.
    """
    match formula:
        case StateFormula(inner):
            return may_hold(inner, t, atoms, endless)
        case InRegion():
            return atoms[formula]
        case And(parts):
            return np.all([may_hold(p, t, atoms, endless) for p in parts], axis=0)
        case Or(parts):
            return np.any([may_hold(p, t, atoms, endless) for p in parts], axis=0)
        case Always(over, part):
            failure_counts = np.concatenate([[0], np.cumsum(~may_hold(part, t, atoms, endless))])
            first, last = window_samples(t, over, -1)
            return (failure_counts[np.maximum(last, first)] - failure_counts[first] == 0) | (
                endless & (t + float(over.begin) >= t[-1])
            )
        case Eventually(over, part):
            hold_counts = np.concatenate([[0], np.cumsum(may_hold(part, t, atoms, endless))])
            first, last = window_samples(t, over, 1)
            return (hold_counts[last] - hold_counts[first] > 0) | (endless & window_goes_on(t, over))
        case Until(over, first_part, last_part):
            first_holds = may_hold(first_part, t, atoms, endless)
            hold_counts = np.concatenate([[0], np.cumsum(may_hold(last_part, t, atoms, endless))])
            first, last = window_samples(t, over, 1)
            next_failure = np.full(len(t), len(t))  # for each sample, the first from it on at which first_part fails
            failure = len(t)
            for k in range(len(t) - 1, -1, -1):
                failure = failure if first_holds[k] else k
                next_failure[k] = failure
            until = np.minimum(last, next_failure + 1)
            return (hold_counts[np.maximum(until, first)] - hold_counts[first] > 0) | (endless & window_goes_on(t, over))
    raise TypeError(formula)


def window_goes_on(t: Array, over: Interval) -> Array:
    """Return for each sample whether its window ends after the last sample, (T,)."""
    return t + (np.inf if over.end is None else float(over.end)) > t[-1]


def window_samples(t: Array, over: Interval, more: int) -> tuple[Array, Array]:
    """Return the first sample of each sample's window, and the one after the last, (T,) each.

    The window is `more` samples longer at both ends. The last sample stands for all times after it.
    """
    end = np.inf if over.end is None else float(over.end)
    first = np.searchsorted(t, np.minimum(t + float(over.begin), t[-1]) - 1e-9) - more
    last = np.searchsorted(t, np.minimum(t + end, t[-1]) + 1e-9, side="right") + more
    last = np.where(t + end >= t[-1], len(t), last)
    first = np.where(t + float(over.begin) >= t[-1], len(t) - 1, first)
    return np.clip(first, 0, len(t)), np.clip(last, 0, len(t))


def breaks_mission(task: Task, design: RefinedDesign, rng: Random) -> bool:
    """Return whether a trajectory in the tube breaks the mission, whatever happens between the samples."""
    formula = task.formula
    assert formula is not None
    t = sample_times(task, design)
    states = set(region_states(formula))
    for x in trajectories(design, rng, t):
        atoms = {}
        for state in states:
            is_inside = is_in_region(task, state.region, x, -1e-7 if state.is_negated else 1e-7)
            atoms[state] = ~is_inside if state.is_negated else is_inside
        if not may_hold(formula, t, atoms, design.seam is not None)[0]:
            return True
    return False


def sample_times(task: Task, design: RefinedDesign) -> Array:
    """Return the times at which the oracle looks at a trajectory, (T,), with further cycles of a tube that repeats."""
    t = np.linspace(0, float(task.prescribed_time), design.segments * SAMPLES_PER_SEGMENT + 1)
    parts = 8 * design.segments  # a statement may hold only next to the end of a part, where the tool cuts the tube
    near_cuts = [float(task.prescribed_time) * (k + s) / parts for k in range(parts) for s in (4e-3, 1 - 4e-3)]
    t = np.unique(np.concatenate([t, near_cuts]))
    if design.seam is not None:
        begin = t[-1] * design.seam / design.segments
        cycle = t[(t > begin) & (t <= t[-1])]
        t = np.unique(np.concatenate([t, *(cycle + k * (t[-1] - begin) for k in range(1, REPEATED_CYCLES + 1))]))
    return t


def region_states(formula: Formula) -> Iterator[InRegion]:
    """Yield the statements of a formula about regions."""
    if isinstance(formula, StateFormula):
        yield from regions_of(formula.inner)
        return
    parts = getattr(formula, "parts", None) or [getattr(formula, k) for k in ("part", "first", "last") if hasattr(formula, k)]
    for part in parts:
        yield from region_states(part)


def judge_mutant(number: int) -> Judgement | None:
    """Certify a mutant, and search a trajectory that breaks its mission; None where its task is refused as bad input."""
    mutant = draw_mutant(number)
    if mutant is None:
        return None
    findings, _ = certify_mission(mutant.task, mutant.design, mutant.error)
    is_certified = bool(findings) and all(f.holds for f in findings)
    return Judgement(mutant.name, is_certified, breaks_mission(mutant.task, mutant.design, Random(number + 1)))


def main() -> None:
    """Judge the mutants, and print the table and each false certificate."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    options = parser.parse_args()
    counts, false_certificates = Counter[Judgement](), []
    for number in range(options.first, options.first + options.count):
        judgement = judge_mutant(number)
        if judgement is None:
            continue
        counts[judgement] += 1
        if judgement.is_certified and judgement.is_broken:
            false_certificates.append(number)
            print(f"mutant {number} ({judgement.mutation}) is certified, and a trajectory breaks it", file=sys.stderr)
    rows = []
    for mutation in MUTATIONS:
        cells = [counts[Judgement(mutation, c, b)] for c, b in ((False, True), (False, False), (True, False), (True, True))]
        rows.append([mutation, *map(str, cells)])
    text = table(["changed", "broken, refused", "not broken, refused", "not broken, certified", "broken, certified"], rows)
    summary = f"{sum(counts.values())} mutants of {len(bases())} missions, {len(false_certificates)} false certificates"
    print(f"{text}\n\n{summary}")
    if options.record:
        title = "## Mutants of missions"
        record(options.record, "mission mutants", f"{title}\n\nMade by `{command()}`; {machine()}.\n\n{text}\n\n{summary}.")
    sys.exit(1 if false_certificates else 0)


if __name__ == "__main__":
    main()
