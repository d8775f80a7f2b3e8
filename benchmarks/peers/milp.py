"""The mixed-integer programs that stlpy makes of a formula (Kurtz and Lin, 2022), solved by HiGHS: the peer of `python -m
benchmarks missions`.

They have a double integrator with |u| <= 0.5 at samples a second apart, a row for each predicate with a big M, and for "or"
either a binary for each predicate (standard) or a logarithmic number of binaries (sos1). Between the samples they require
nothing; `share_violated_between_samples` measures the result.
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

BIG_M = 100.0  # metres, more than any distance to a side of a box
INPUT_LIMIT = 0.5
SPEED_LIMIT = 2.0
Terms = list[tuple[int, float]]  # columns and their coefficients in a row


@dataclass
class MixedProgram:
    """A mixed-integer linear program without a cost, in the order in which columns and rows are added. rows: terms, lower and
    upper bound."""

    lower: list[float] = field(default_factory=list)
    upper: list[float] = field(default_factory=list)
    is_integer: list[bool] = field(default_factory=list)
    rows: list[tuple[Terms, float, float]] = field(default_factory=list)

    def add_column(self, lower: float, upper: float, is_integer: bool = False) -> int:
        """Add a variable, and return its number."""
        self.lower.append(lower)
        self.upper.append(upper)
        self.is_integer.append(is_integer)
        return len(self.lower) - 1

    def add_row(self, terms: Terms, lower: float, upper: float) -> None:
        self.rows.append((terms, lower, upper))

    def solve(self, seconds: float) -> tuple[str, float, Array | None]:
        """Return "solved", "none" (infeasible) or "limit", the seconds that HiGHS took, and the values of the columns if
        solved."""
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
        model.integrality_ = [kinds[w] for w in self.is_integer]
        solver = highspy.Highs()  # type: ignore[no-untyped-call]
        for option, value in {"output_flag": False, "threads": 1, "time_limit": seconds}.items():
            solver.setOptionValue(option, value)
        solver.passModel(model)
        begin = time.perf_counter()
        solver.run()
        duration = time.perf_counter() - begin
        status = solver.getModelStatus()
        if status == highspy.HighsModelStatus.kOptimal:
            return "solved", duration, np.array(solver.getSolution().col_value)
        return ("none" if status == highspy.HighsModelStatus.kInfeasible else "limit"), duration, None


class MissionProgram:
    """The program of a task and its mission. A formula is required at a sample where its activity, a column, is 1."""

    def __init__(self, task: Task, logarithmic: bool) -> None:
        self.task, self.logarithmic, self.program = task, logarithmic, MixedProgram()
        self.last = int(task.prescribed_time)
        space, samples = task.state_space, range(self.last + 1)
        add = self.program.add_column
        self.positions = [[add(float(a), float(b)) for a, b in zip(space.lower, space.upper, strict=True)] for _ in samples]
        self._add_dynamics()
        for unsafe in task.unsafe:
            assert isinstance(unsafe, UnsafeSet)
            for k in samples:
                self.require_outside(k, unsafe, add(1.0, 1.0))
        assert task.formula is not None
        self.require(task.formula, 0, add(1.0, 1.0))

    def _add_dynamics(self) -> None:
        """Add speeds, inputs and the rows of the double integrator, from rest at the initial state."""
        program, n = self.program, self.task.dimension
        speed = [[program.add_column(-SPEED_LIMIT, SPEED_LIMIT) for _ in range(n)] for _ in range(self.last + 1)]
        u = [[program.add_column(-INPUT_LIMIT, INPUT_LIMIT) for _ in range(n)] for _ in range(self.last)]
        for i, x in enumerate(self.task.initial_state):
            program.add_row([(self.positions[0][i], 1.0)], float(x), float(x))
            program.add_row([(speed[0][i], 1.0)], 0.0, 0.0)
            for k in range(self.last):
                position, next_position = self.positions[k][i], self.positions[k + 1][i]
                program.add_row([(next_position, 1.0), (position, -1.0), (speed[k][i], -1.0)], 0.0, 0.0)
                program.add_row([(speed[k + 1][i], 1.0), (speed[k][i], -1.0), (u[k][i], -1.0)], 0.0, 0.0)

    def require(self, formula: Formula, sample: int, activity: int) -> None:
        """Require that the formula holds at a sample where the activity is 1."""
        match formula:
            case StateFormula(inner):
                self.require(inner, sample, activity)
            case InRegion(region, is_negated):
                box = self.task.regions[region]
                assert isinstance(box, UnsafeSet)
                (self.require_outside if is_negated else self.require_inside)(sample, box, activity)
            case And(parts):
                for part in parts:
                    self.require(part, sample, activity)
            case Or(parts):
                self.require_some([(part, sample) for part in parts], activity)
            case Always(over, part):
                for k in self.samples(sample, over):
                    self.require(part, k, activity)
            case Eventually(over, part):
                self.require_some([(part, k) for k in self.samples(sample, over)], activity)
            case Until(over, first, last):
                self.require_some([(last, k) for k in self.samples(sample, over)], activity, first, sample)

    def samples(self, sample: int, over: Interval) -> range:
        """Return the samples of an interval that begins at a sample. Raises ValueError where its ends are not samples."""
        if over.begin.denominator != 1 or (over.end or over.begin).denominator != 1:
            raise ValueError(f"a window {over} that is not of whole seconds has no samples at its ends")
        end = self.last if over.end is None else min(sample + int(over.end), self.last)
        return range(min(sample + int(over.begin), self.last), end + 1)

    def require_some(
        self, parts: list[tuple[Formula, int]], activity: int, before: Formula | None = None, since: int = 0
    ) -> None:
        """Require at least one of several formulas, each at its sample; and `before`, if any, at all samples from `since` to that
        one."""
        for (part, sample), selected in zip(parts, self.add_selection(len(parts), activity), strict=True):
            self.require(part, sample, selected)
            for k in range(since, sample + 1) if before is not None else ():
                assert before is not None
                self.require(before, k, selected)

    def add_selection(self, count: int, activity: int) -> list[int]:
        """Add columns at least one of which is 1 where the activity is, and return them."""
        program = self.program
        if not self.logarithmic:
            columns = [program.add_column(0.0, 1.0, True) for _ in range(count)]
            program.add_row([*((c, 1.0) for c in columns), (activity, -1.0)], 0.0, np.inf)
            return columns
        share = [program.add_column(0.0, 1.0) for _ in range(count + 1)]  # the first one stands for no selection
        program.add_row([(c, 1.0) for c in share], 1.0, 1.0)
        program.add_row([(share[0], 1.0), (activity, 1.0)], 1.0, 1.0)
        gray = [k ^ (k >> 1) for k in range(count + 1)]
        for bit in range(max(1, math.ceil(math.log2(count + 1)))):
            side = program.add_column(0.0, 1.0, True)
            with_bit = [(share[k], 1.0) for k in range(count + 1) if gray[k] >> bit & 1]
            without_bit = [(share[k], 1.0) for k in range(count + 1) if not gray[k] >> bit & 1]
            program.add_row([*with_bit, (side, -1.0)], -np.inf, 0.0)
            program.add_row([*without_bit, (side, 1.0)], -np.inf, 1.0)
        return share[1:]

    def require_inside(self, sample: int, box: UnsafeSet, activity: int) -> None:
        for x, a, b in zip(self.positions[sample], box.lower, box.upper, strict=True):
            self.program.add_row([(x, 1.0), (activity, -BIG_M)], float(a) - BIG_M, np.inf)
            self.program.add_row([(x, -1.0), (activity, -BIG_M)], -float(b) - BIG_M, np.inf)

    def require_outside(self, sample: int, box: UnsafeSet, activity: int) -> None:
        """Require the position to be beyond one side of the box."""
        sides = self.add_selection(2 * self.task.dimension, activity)
        for i, (x, a, b) in enumerate(zip(self.positions[sample], box.lower, box.upper, strict=True)):
            self.program.add_row([(x, -1.0), (sides[2 * i], -BIG_M)], -float(a) - BIG_M, np.inf)
            self.program.add_row([(x, 1.0), (sides[2 * i + 1], -BIG_M)], float(b) - BIG_M, np.inf)


@dataclass(frozen=True)
class MissionPath:
    """What the program says ("solved", "none" or "limit"), in how many seconds, and its samples (T + 1, n) if solved."""

    status: str
    seconds: float
    path: Array | None


def solve_mission(task: Task, logarithmic: bool, seconds: float) -> MissionPath:
    """Solve the mission of a task as stlpy would, within so many seconds."""
    mission = MissionProgram(task, logarithmic)
    status, duration, columns = mission.program.solve(seconds)
    return MissionPath(status, duration, None if columns is None else columns[np.array(mission.positions)])


def share_violated_between_samples(task: Task, path: Array) -> float:
    """Return the share of the time in which the straight path between its samples is in an unsafe set, or outside of all boxes
    one of which it must always be in."""
    steps = np.linspace(0, 1, 51)[None, :, None]
    points = (path[:-1, None] + steps * (path[1:] - path[:-1])[:, None]).reshape(-1, path.shape[1])
    is_violated = np.zeros(len(points), dtype=bool)
    for unsafe in task.unsafe:
        assert isinstance(unsafe, UnsafeSet)
        is_violated |= _is_in(points, unsafe, growth=-1e-6)
    for formula in task.formulas:
        if isinstance(formula, Always) and isinstance(formula.part, StateFormula) and isinstance(formula.part.inner, Or):
            boxes = [task.regions[p.region] for p in formula.part.inner.parts if isinstance(p, InRegion)]
            is_violated |= ~np.any([_is_in(points, box, growth=1e-6) for box in boxes if isinstance(box, UnsafeSet)], axis=0)
    return float(is_violated.mean())


def _is_in(points: Array, box: UnsafeSet, growth: float) -> Array:
    """Whether points are in the open box, grown on all sides; the solver's points are exact to 1e-6 only."""
    low, high = (np.array([float(v) for v in edge]) for edge in (box.lower, box.upper))
    return np.asarray(((points > low - growth) & (points < high + growth)).all(axis=1))
