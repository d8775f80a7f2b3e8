"""The mixed-integer programs that stlpy makes of a formula (Kurtz and Lin, 2022), solved by HiGHS: the peer of `python -m
benchmarks missions`.

A double integrator with |u| <= 0.5 at samples a second apart, a row for each predicate with a big M, and for "or" either a binary
for each predicate (standard) or a logarithmic number of binaries (sos1). It says nothing of what is between the samples.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

import highspy
import numpy as np

from stt_codegen.design.half_spaces import Array
from stt_codegen.task.mission.formulas import Always, And, Eventually, Formula, InRegion, Interval, Or, Until
from stt_codegen.task.mission.regions import StateFormula
from stt_codegen.task.sets.shapes import UnsafeSet
from stt_codegen.task.task import Task

BIG, INPUT, SPEED = 100.0, 0.5, 2.0
Terms = list[tuple[int, float]]


@dataclass
class MixedProgram:
    """Rows and columns, as they come."""

    lower: list[float] = field(default_factory=list)
    upper: list[float] = field(default_factory=list)
    whole: list[bool] = field(default_factory=list)
    rows: list[tuple[Terms, float, float]] = field(default_factory=list)

    def column(self, lower: float, upper: float, whole: bool = False) -> int:
        self.lower.append(lower)
        self.upper.append(upper)
        self.whole.append(whole)
        return len(self.lower) - 1

    def row(self, terms: Terms, lower: float, upper: float) -> None:
        self.rows.append((terms, lower, upper))

    def solve(self, seconds: float) -> tuple[str, float, Array | None]:
        """What became of it, in how many seconds, and the columns where there is a solution."""
        model = highspy.HighsLp()
        model.num_col_, model.num_row_ = len(self.lower), len(self.rows)
        model.col_cost_ = np.zeros(len(self.lower))
        model.col_lower_, model.col_upper_ = np.array(self.lower), np.array(self.upper)
        model.row_lower_, model.row_upper_ = (np.array([r[k] for r in self.rows]) for k in (1, 2))
        model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
        model.a_matrix_.start_ = np.cumsum([0, *(len(r[0]) for r in self.rows)]).astype(np.int32)
        model.a_matrix_.index_ = np.array([c for r in self.rows for c, _ in r[0]], dtype=np.int32)
        model.a_matrix_.value_ = np.array([v for r in self.rows for _, v in r[0]])
        kinds = (highspy.HighsVarType.kContinuous, highspy.HighsVarType.kInteger)
        model.integrality_ = [kinds[w] for w in self.whole]
        solver = highspy.Highs()  # type: ignore[no-untyped-call]
        for option, value in {"output_flag": False, "threads": 1, "time_limit": seconds}.items():
            solver.setOptionValue(option, value)
        solver.passModel(model)
        begin = time.perf_counter()
        solver.run()
        took = time.perf_counter() - begin
        status = solver.getModelStatus()
        if status == highspy.HighsModelStatus.kOptimal:
            return "solved", took, np.array(solver.getSolution().col_value)
        return ("none" if status == highspy.HighsModelStatus.kInfeasible else "limit"), took, None


class Encoding:
    """A formula of boxes at samples."""

    def __init__(self, task: Task, logarithmic: bool) -> None:
        self.task, self.logarithmic, self.program = task, logarithmic, MixedProgram()
        self.last = int(task.prescribed_time)
        n, space = task.dimension, task.state_space
        add = self.program.column
        self.place = [[add(float(space.lower[i]), float(space.upper[i])) for i in range(n)] for _ in range(self.last + 1)]
        speed = [[add(-SPEED, SPEED) for _ in range(n)] for _ in range(self.last + 1)]
        push = [[add(-INPUT, INPUT) for _ in range(n)] for _ in range(self.last)]
        for i, x in enumerate(task.initial_state):
            self.program.row([(self.place[0][i], 1.0)], float(x), float(x))
            self.program.row([(speed[0][i], 1.0)], 0.0, 0.0)
            for k in range(self.last):
                here, there = self.place[k][i], self.place[k + 1][i]
                self.program.row([(there, 1.0), (here, -1.0), (speed[k][i], -1.0)], 0.0, 0.0)
                self.program.row([(speed[k + 1][i], 1.0), (speed[k][i], -1.0), (push[k][i], -1.0)], 0.0, 0.0)
        for unsafe in task.unsafe:
            assert isinstance(unsafe, UnsafeSet)
            for k in range(self.last + 1):
                self.outside(k, unsafe, add(1.0, 1.0))
        assert task.formula is not None
        self.add(task.formula, 0, add(1.0, 1.0))

    def add(self, formula: Formula, at: int, on: int) -> None:
        """That the formula holds at a sample where the column `on` is 1."""
        match formula:
            case StateFormula(inner):
                self.add(inner, at, on)
            case InRegion(region, kept):
                box = self.task.regions[region]
                assert isinstance(box, UnsafeSet)
                (self.outside if kept else self.inside)(at, box, on)
            case And(parts):
                for part in parts:
                    self.add(part, at, on)
            case Or(parts):
                self.choice([(part, at) for part in parts], on)
            case Always(over, part):
                for k in self.samples(at, over):
                    self.add(part, k, on)
            case Eventually(over, part):
                self.choice([(part, k) for k in self.samples(at, over)], on)
            case Until(over, first, last):
                self.choice([(last, k) for k in self.samples(at, over)], on, first, at)

    def samples(self, at: int, over: Interval) -> range:
        if over.begin.denominator != 1 or (over.end or over.begin).denominator != 1:
            raise ValueError(f"a window {over} that is not of whole seconds has no samples at its ends")
        end = self.last if over.end is None else min(at + int(over.end), self.last)
        return range(min(at + int(over.begin), self.last), end + 1)

    def choice(self, parts: list[tuple[Formula, int]], on: int, held: Formula | None = None, since: int = 0) -> None:
        """At least one of several at their samples; until then `held`."""
        for (part, at), one in zip(parts, self.chosen(len(parts), on), strict=True):
            self.add(part, at, one)
            for k in range(since, at + 1) if held is not None else ():
                assert held is not None
                self.add(held, k, one)

    def chosen(self, count: int, on: int) -> list[int]:
        """Columns of which one is 1 where `on` is."""
        program = self.program
        if not self.logarithmic:
            found = [program.column(0.0, 1.0, True) for _ in range(count)]
            program.row([*((c, 1.0) for c in found), (on, -1.0)], 0.0, np.inf)
            return found
        share = [program.column(0.0, 1.0) for _ in range(count + 1)]  # the first: none of them
        program.row([(c, 1.0) for c in share], 1.0, 1.0)
        program.row([(share[0], 1.0), (on, 1.0)], 1.0, 1.0)
        gray = [k ^ (k >> 1) for k in range(count + 1)]
        for bit in range(max(1, math.ceil(math.log2(count + 1)))):
            side = program.column(0.0, 1.0, True)
            program.row([*((share[k], 1.0) for k in range(count + 1) if gray[k] >> bit & 1), (side, -1.0)], -np.inf, 0.0)
            program.row([*((share[k], 1.0) for k in range(count + 1) if not gray[k] >> bit & 1), (side, 1.0)], -np.inf, 1.0)
        return share[1:]

    def inside(self, at: int, box: UnsafeSet, on: int) -> None:
        for i, (a, b) in enumerate(zip(box.lower, box.upper, strict=True)):
            self.program.row([(self.place[at][i], 1.0), (on, -BIG)], float(a) - BIG, np.inf)
            self.program.row([(self.place[at][i], -1.0), (on, -BIG)], -float(b) - BIG, np.inf)

    def outside(self, at: int, box: UnsafeSet, on: int) -> None:
        sides = self.chosen(2 * self.task.dimension, on)
        for i, (a, b) in enumerate(zip(box.lower, box.upper, strict=True)):
            self.program.row([(self.place[at][i], -1.0), (sides[2 * i], -BIG)], -float(a) - BIG, np.inf)
            self.program.row([(self.place[at][i], 1.0), (sides[2 * i + 1], -BIG)], float(b) - BIG, np.inf)


@dataclass(frozen=True)
class Answer:
    """What the program says, in how many seconds, and its samples (T + 1, n); None where there are none."""

    status: str
    seconds: float
    path: Array | None


def solved(task: Task, logarithmic: bool, seconds: float) -> Answer:
    """The mission of a task as stlpy would solve it."""
    encoding = Encoding(task, logarithmic)
    status, took, columns = encoding.program.solve(seconds)
    return Answer(status, took, None if columns is None else columns[np.array(encoding.place)])


def between(task: Task, path: Array) -> float:
    """How much of the time between its samples the path is in an unsafe set, or off all of the boxes that it must always be on:
    a share."""
    steps = np.linspace(0, 1, 51)[None, :, None]
    points = (path[:-1, None] + steps * (path[1:] - path[:-1])[:, None]).reshape(-1, path.shape[1])
    bad = np.zeros(len(points), dtype=bool)
    for unsafe in task.unsafe:
        assert isinstance(unsafe, UnsafeSet)
        bad |= _in(points, unsafe)
    for formula in task.formulas:
        if isinstance(formula, Always) and isinstance(formula.part, StateFormula) and isinstance(formula.part.inner, Or):
            boxes = [task.regions[p.region] for p in formula.part.inner.parts if isinstance(p, InRegion)]
            bad |= ~np.any([_in(points, box, 1e-6) for box in boxes if isinstance(box, UnsafeSet)], axis=0)
    return float(bad.mean())


def _in(points: Array, box: UnsafeSet, room: float = -1e-6) -> Array:
    low, high = (np.array([float(v) for v in edge]) for edge in (box.lower, box.upper))
    return np.asarray(((points > low - room) & (points < high + room)).all(axis=1))
