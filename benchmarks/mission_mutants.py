"""Missions and tubes bent by chance: what P10 certifies, beside trajectories in the tube that are judged by the definition.

    python -m benchmarks mission_mutants [--count 10000] [--first 0] [--record benchmarks/RESULTS.md]

A base is a mission and its tube. A mutant moves control points, or an edge of a region, a window, an operator. The oracle knows
neither intervals nor margins: it follows trajectories along edges and corners of the exact tube and evaluates the formula at
samples, everything between two of them taken in the formula's favour. A mutant that is certified though a trajectory breaks its
formula is a false certificate, and the command fails.
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
from typing import Any

import numpy as np

from benchmarks.suites.report import command, machine, record, table
from benchmarks.suites.scenarios import own, random_mission, stlpy
from stt_codegen.certify.claims import units_of_error
from stt_codegen.certify.missions.proof import certify_mission
from stt_codegen.controller.edge_errors import edge_error
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_program, design_tube
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.mission.formulas import Always, And, Eventually, Formula, InRegion, Interval, Or, Until, regions_of
from stt_codegen.task.mission.regions import RegionUnion, StateFormula
from stt_codegen.task.task import Task

Array = Any
TASKS = Path(__file__).parent.parent / "tasks"
RESPONSE = "always (gate -> eventually[0, 8] office) and always eventually[0, 14] gate"
CYCLES = 3  # more than the first that the oracle follows
RANDOM = 6  # random missions among the bases
EACH = 24  # samples of a segment: where the tool cuts it, and between
MOVED = ("window", "edge", "operator", "knot", "stretch", "shift")


@cache
def bases() -> tuple[tuple[str, Task, RefinedDesign, int], ...]:
    """Name, task, tube, and what the arithmetic may take."""
    texts = [(s.name, s.text) for s in (*own(), *stlpy()) if not s.closed]
    tasks = [(name, parse_task(text)) for name, text in texts]
    tasks += [(f"random {k}", parse_task(random_mission(k, 2, 5))) for k in range(RANDOM)]
    tasks += [(name, load_task(TASKS / f"{name}.toml")) for name in ("courier", "waypoints", "either", "watchman")]
    told = (
        (TASKS / "watchman.toml")
        .read_text()
        .replace('patrol = ["gate", "office", "store"]\nevery = 14', f'formula = "{RESPONSE}"')
    )
    tasks.append(("response for ever", parse_task(told)))
    found = []
    for name, task in tasks:
        design = design_tube(task)
        assert isinstance(design, RefinedDesign)
        found.append((name, task, design, units_of_error(design, edge_error(design, build_program(task, design)))))
    return tuple(found)


# ---------------------------------------------------------------------------------------------------- mutants


def mutant(number: int) -> tuple[str, Task, RefinedDesign, int] | None:
    """A base with something changed; None where that is no task."""
    dice = Random(number)
    _, task, design, error = dice.choice(bases())
    kind = dice.choice(MOVED)
    size = 10 ** dice.uniform(-4, 0.2)
    if kind in ("knot", "stretch", "shift"):
        return kind, task, bent(design, dice, kind, size), error
    try:
        return kind, changed(task, dice, kind, size), design, error
    except BadInput:
        return None


def bent(design: RefinedDesign, dice: Random, kind: str, size: float) -> RefinedDesign:
    table_ = design.integers().copy()
    first = dice.randrange(1, len(table_) - 3)
    last = (
        first + 1 if kind == "knot" else min(first + dice.randrange(2, 12), len(table_) - 3) if kind == "stretch" else len(table_)
    )
    first = 3 if kind == "shift" else first
    i = dice.randrange(table_.shape[1])
    step = int(dice.choice((-1, 1)) * size * float(np.ptp(table_)) / 4)
    sides = dice.choice(((0,), (1,), (0, 1)))
    for side in sides:
        table_[first:last, i, side] += step
    table_[:, i] = np.sort(table_[:, i], axis=1)
    if design.seam is None:
        table_[-1] = table_[-3]
    else:
        table_[-3:] = table_[design.seam : design.seam + 3]
    return replace(design, table=tuple(tuple((int(a), int(b)) for a, b in row) for row in table_.tolist()))


def changed(task: Task, dice: Random, kind: str, size: float) -> Task:
    if kind == "edge":
        boxes = [k for k, r in enumerate(task.region) if not isinstance(r, RegionUnion) and hasattr(r, "lower")]
        k = dice.choice(boxes)
        box, i = task.region[k], dice.randrange(task.dimension)
        edge = dice.choice(("lower", "upper"))
        values = list(getattr(box, edge))
        values[i] += Fraction(str(round(dice.choice((-1, 1)) * size * float(box.upper[i] - box.lower[i]), 6)))  # type: ignore[union-attr]
        regions = [given(r) | ({edge: values} if j == k else {}) for j, r in enumerate(task.region)]
        return task.changed(region=regions)
    texts = [str(e.meaning(task.prescribed_time, task.repeat)) for e in task.mission]
    k = dice.randrange(len(texts))
    if kind == "operator":
        pairs = (("eventually", "always"), ("always", "eventually"), (" and ", " or "), (" or ", " and "), ("not ", ""))
        old, new = dice.choice([p for p in pairs if p[0] in texts[k]] or [("", "")])
        texts[k] = texts[k].replace(old, new, 1) if old else texts[k]
    else:
        words = texts[k].replace("[", " [ ").replace("]", " ] ").replace(",", " , ").split()
        numbers = [j for j, w in enumerate(words) if w[:1].isdigit()]
        if numbers:
            j = dice.choice(numbers)
            moved = float(words[j]) + dice.choice((-1, 1)) * size * float(task.prescribed_time) / 4
            words[j] = f"{min(max(moved, 0.0), float(task.prescribed_time)):.4f}"
        texts[k] = " ".join(words)
    return task.changed(mission=[{"formula": text} for text in texts])


def given(table_: Any) -> dict[str, Any]:
    return {name: getattr(table_, name) for name in table_.model_fields_set}


# ---------------------------------------------------------------------------------------------------- the oracle


def trajectories(design: RefinedDesign, dice: Random, t: Array) -> Iterator[Array]:
    """Along every corner of the tube, and from one to another: (T, n)."""
    low, high = design.edges_at(turned_back(design, t))
    n = low.shape[1]
    for corner in itertools.product((0.0, 1.0), repeat=n):
        yield low + np.array(corner) * (high - low)
    for _ in range(6):
        knots = np.linspace(0, t[-1], dice.randrange(4, 60))
        mix = np.array([[dice.randrange(2) for _ in range(n)] for _ in knots], dtype=float)
        share = np.stack([np.interp(t, knots, mix[:, i]) for i in range(n)], axis=1)
        yield low + share * (high - low)


def inside(task: Task, name: str, x: Array, room: float) -> Array:
    """Which points are in a region, larger by `room`."""
    region = task.regions[name]
    assert not isinstance(region, RegionUnion)
    x = x[:, list(task.axis_indices(region))]
    if hasattr(region, "radius"):
        return np.sqrt(((x - [float(v) for v in region.centre]) ** 2).sum(axis=1)) <= float(region.radius) + room
    if hasattr(region, "lower"):
        return ((x >= [float(v) - room for v in region.lower]) & (x <= [float(v) + room for v in region.upper])).all(axis=1)
    faces = [([float(c) for c in n], float(h)) for n, h in region.half_spaces()]
    return np.all([x @ np.array(n) <= h + room * np.abs(n).sum() for n, h in faces], axis=0)


def turned_back(design: RefinedDesign, t: Array) -> Array:
    """Times on the tube's clock."""
    if design.seam is None:
        return t
    t_c = float(design.prescribed_time)
    length = t_c * (1 - design.seam / design.segments)
    return np.where(t < t_c, t, t_c - length + (t - t_c) % length)


def evaluated(formula: Formula, t: Array, atoms: dict[InRegion, Array], endless: bool = False) -> Array:
    """Where the formula may hold, at the samples: what is between two of them counts as the better; endless: and
    what is after the last one."""
    match formula:
        case StateFormula(inner):
            return evaluated(inner, t, atoms, endless)
        case InRegion():
            return atoms[formula]
        case And(parts):
            return np.all([evaluated(p, t, atoms, endless) for p in parts], axis=0)
        case Or(parts):
            return np.any([evaluated(p, t, atoms, endless) for p in parts], axis=0)
        case Always(over, part):
            bad = np.concatenate([[0], np.cumsum(~evaluated(part, t, atoms, endless))])
            first, last = samples(t, over, -1)
            return (bad[np.maximum(last, first)] - bad[first] == 0) | (endless & (t + float(over.begin) >= t[-1]))
        case Eventually(over, part):
            good = np.concatenate([[0], np.cumsum(evaluated(part, t, atoms, endless))])
            first, last = samples(t, over, 1)
            return (good[last] - good[first] > 0) | (endless & beyond(t, over))
        case Until(over, held, reached):
            keep, good = (
                evaluated(held, t, atoms, endless),
                np.concatenate([[0], np.cumsum(evaluated(reached, t, atoms, endless))]),
            )
            first, last = samples(t, over, 1)
            broken = np.full(len(t), len(t))
            where = len(t)
            for k in range(len(t) - 1, -1, -1):
                where = where if keep[k] else k
                broken[k] = where
            until = np.minimum(last, broken + 1)
            return (good[np.maximum(until, first)] - good[first] > 0) | (endless & beyond(t, over))
    raise TypeError(formula)


def beyond(t: Array, over: Interval) -> Array:
    """Whether the window of each sample goes on after the last one."""
    return t + (np.inf if over.end is None else float(over.end)) > t[-1]


def samples(t: Array, over: Interval, more: int) -> tuple[Array, Array]:
    """From which sample to which (not included) the window of each is; `more` samples at both ends. The last sample stands for
    all times after it."""
    end = np.inf if over.end is None else float(over.end)
    first = np.searchsorted(t, np.minimum(t + float(over.begin), t[-1]) - 1e-9) - more
    last = np.searchsorted(t, np.minimum(t + end, t[-1]) + 1e-9, side="right") + more
    last = np.where(t + end >= t[-1], len(t), last)
    first = np.where(t + float(over.begin) >= t[-1], len(t) - 1, first)
    return np.clip(first, 0, len(t)), np.clip(last, 0, len(t))


def broken(task: Task, design: RefinedDesign, dice: Random) -> bool:
    """Whether some trajectory in the tube breaks the mission for sure."""
    formula = task.formula
    assert formula is not None
    t = np.linspace(0, float(task.prescribed_time), design.segments * EACH + 1)
    parts = 8 * design.segments  # a state may hold next to a cut alone
    near = [float(task.prescribed_time) * (k + s) / parts for k in range(parts) for s in (4e-3, 1 - 4e-3)]
    t = np.unique(np.concatenate([t, near]))
    endless = design.seam is not None
    if design.seam is not None:  # the cycle again and again, at the same places
        begin = t[-1] * design.seam / design.segments
        again = t[(t > begin) & (t <= t[-1])]
        t = np.unique(np.concatenate([t, *(again + k * (t[-1] - begin) for k in range(1, CYCLES + 1))]))
    atoms_named = set(regions_of_states(formula))
    for x in trajectories(design, dice, t):
        atoms = {}
        for region_state in atoms_named:
            is_inside = inside(task, region_state.region, x, -1e-7 if region_state.is_negated else 1e-7)
            atoms[region_state] = ~is_inside if region_state.is_negated else is_inside
        if not evaluated(formula, t, atoms, endless)[0]:
            return True
    return False


def regions_of_states(formula: Formula) -> Iterator[InRegion]:
    if isinstance(formula, StateFormula):
        yield from regions_of(formula.inner)
        return
    parts = getattr(formula, "parts", None) or [getattr(formula, k) for k in ("part", "first", "last") if hasattr(formula, k)]
    for part in parts:
        yield from regions_of_states(part)


def judged(number: int) -> tuple[str, bool, bool] | None:
    """The kind of a mutant, whether it is certified, and whether a trajectory breaks it."""
    made = mutant(number)
    if made is None:
        return None
    kind, task, design, error = made
    findings, _ = certify_mission(task, design, error)
    certified = bool(findings) and all(f.holds for f in findings)
    return kind, certified, broken(task, design, Random(number + 1))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    options = parser.parse_args()
    seen, false = Counter[tuple[str, bool, bool]](), []
    for number in range(options.first, options.first + options.count):
        found = judged(number)
        if found is None:
            continue
        seen[found] += 1
        if found[1] and found[2]:
            false.append(number)
            print(f"mutant {number} ({found[0]}) is certified, and a trajectory breaks it", file=sys.stderr)
    rows = []
    for kind in MOVED:
        cells = [seen[kind, c, b] for c, b in ((False, True), (False, False), (True, False), (True, True))]
        rows.append([kind, *map(str, cells)])
    text = table(["changed", "broken, refused", "not broken, refused", "not broken, certified", "broken, certified"], rows)
    told = f"{sum(seen.values())} mutants of {len(bases())} missions, {len(false)} false certificates"
    print(f"{text}\n\n{told}")
    if options.record:
        title = "## Mutants of missions"
        record(options.record, "mission mutants", f"{title}\n\nMade by `{command()}`; {machine()}.\n\n{text}\n\n{told}.")
    sys.exit(1 if false else 0)


if __name__ == "__main__":
    main()
