"""`emit.selftest`: calls of `control` (and `control_tick`) for the board's boot, in a C file of their own.

There is one call for every three segments of the table (a dozen where there is none), near the middle of the tube: u is not
saturated there, so that every coefficient moves some u. A few calls are beside the edges, outside and far away. The bounds on u
enclose the emitted arithmetic (`program.analyse.balls`): every right compiler and library passes, whether or not it fuses
multiplications, and nothing passes that is wrong by more than rounding is. A NaN at the end finds arithmetic without it.

For plants of order 2, v + lambda x stands near the middle of the filtered tube, and x elsewhere in its tube, so that a wrong
lambda moves u too; v follows from both. In the last calls one of the two leaves its tube while the other stays near the middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

from flint import arb

from stt_codegen.designs import Design
from stt_codegen.errors import BadInput
from stt_codegen.program import FORMATS, REAL, Function, Program, Status, Table, round_to, ulp_exponent
from stt_codegen.program.analyse import Enclosure, ball
from stt_codegen.task import Task

Edges = dict[str, list[arb]]  # "lower" and "upper", by component


class Position(NamedTuple):
    """The positions of x and v + lambda x between their edges: 0 at the lower edge, 1 at the upper edge, None near the middle."""

    x: Fraction | None
    filtered: Fraction | None


class CallPlan(NamedTuple):
    """A call. begin: where its segment or part begins, as a fraction of t_c; position: of the state between the edges."""

    begin: Fraction
    position: Position


NEAR_MIDDLE = Position(None, None)
# Positions near the middle. Each dimension takes the next of the list; v + lambda x takes the one after that of x.
MIDDLE_FRACTIONS = tuple(Fraction(v) for v in ("0.4", "0.6", "0.45", "0.55", "0.375"))
EDGE_POSITIONS = tuple(Position(Fraction(v), None) for v in ("0.03", "0.97", "-0.5", "1.5", "9"))
EDGE_POSITIONS_ORDER_TWO = (
    *(Position(None, Fraction(v)) for v in ("0.03", "0.97", "-0.5", "1.5")),
    *(Position(Fraction(v), None) for v in ("0.03", "0.97", "-0.03", "1.03")),
    Position(Fraction(9), Fraction(9)),
)
PARTS = 36  # of the time, where there are no segments
SEGMENT_FRACTIONS = tuple(Fraction(v) for v in ("0.45", "0.4", "0.5", "0.35", "0.55"))  # for t in a segment or part; best first
PIECES = 16  # into which the ball of t's fraction of its segment is cut, for order 2
LARGEST_RELATIVE_RADIUS = 1 / 8  # of u near the middle: if u were less certain, a wrong table would pass
DECIDED_RADIUS = 1e-4  # of an edge, over 1 + its size: a larger ball says that two segments are possible


@dataclass(frozen=True, kw_only=True)
class SelftestSuite:
    """Calls of one function: `points` has the arguments of each one after the other (ticks apart), `low` and `high` the bounds
    on its u. arguments: where each begins in a point, and whether it is an array."""

    function: str
    ticks: tuple[int, ...]
    points: Table
    statuses: tuple[Status, ...]
    low: Table
    high: Table
    arguments: tuple[tuple[int, bool], ...]


@dataclass(frozen=True)
class _Call:
    """One call with its results: the arguments but a tick, the status, and enclosures of u."""

    inputs: dict[str, Any]
    tick: int | None
    status: Status
    u: list[arb]


def selftest_suites(task: Task, design: Design, program: Program) -> list[SelftestSuite]:
    """Return the suite of `control`, and of `control_tick` where there is one. Raises `BadInput` where rounding hides u."""
    balls = Enclosure(program, rounding=True)
    parts = design.parts or PARTS
    edge_positions = EDGE_POSITIONS if task.order == 1 else EDGE_POSITIONS_ORDER_TWO
    count = len(edge_positions)
    plans = [CallPlan(Fraction(k, parts), NEAR_MIDDLE) for k in sorted({*range(0, parts, 3), parts - 1})]
    plans += [CallPlan(Fraction(parts * (2 * k + 1) // (2 * count), parts), p) for k, p in enumerate(edge_positions)]
    plans += [CallPlan(Fraction(-1, 8), NEAR_MIDDLE), CallPlan(Fraction(9, 8), NEAR_MIDDLE)]  # before the start and after t_c
    calculator = _CallCalculator(task, design, program, balls)
    functions = [f for f in program.functions if f.name in ("control", "control_tick")]
    return [_suite(f, program, [calculator.call(f.name, plan, k) for k, plan in enumerate(plans)]) for f in functions]


def _suite(function: Function, program: Program, calls: Sequence[_Call]) -> SelftestSuite:
    """Return the calls of one function as tables of numbers of the program's scalar."""
    points = [v for call in calls for value in call.inputs.values() for v in (value if isinstance(value, list) else [value])]
    low = tuple(_rounded_outward(u, program.scalar, -1) for call in calls for u in call.u)
    high = tuple(_rounded_outward(u, program.scalar, 1) for call in calls for u in call.u)
    arguments = [p for p in function.inputs if p.type is REAL]
    lengths = [p.length or 1 for p in arguments]
    suffix = "" if function.name == "control" else "_at_ticks"
    points_doc = f"Arguments of {function.name}: {', '.join(p.name for p in arguments)}."
    high_doc = "to here: all that IEEE arithmetic can give."
    return SelftestSuite(
        function=function.name,
        ticks=tuple(call.tick for call in calls if call.tick is not None),
        points=Table("points" + suffix, tuple(points), sum(lengths), (points_doc,)),
        statuses=tuple(call.status for call in calls),
        low=Table("least" + suffix, low, program.dimension, ("u may be from here",)),
        high=Table("greatest" + suffix, high, program.dimension, (high_doc,)),
        arguments=tuple((sum(lengths[:k]), p.length is not None) for k, p in enumerate(arguments)),
    )


@dataclass(frozen=True)
class _CallCalculator:
    """Calculates arguments and results of calls of the emitted functions, in balls that hold every rounding."""

    task: Task
    design: Design
    program: Program
    balls: Enclosure

    def call(self, name: str, plan: CallPlan, k: int) -> _Call:
        """Return call k of the function `name`. Raises `BadInput` where rounding leaves status or u too uncertain."""
        scalar = self.program.scalar
        part = Fraction(1, self.design.parts or PARTS)
        inputs, tube, filtered_tube = self._time([plan.begin + fraction * part for fraction in self._segment_fractions], k)
        inputs["x"] = [round_to(value, scalar) for value in _state_at(tube, plan.position.x, k)]
        if filtered_tube is not None:
            filtered_state = _state_at(filtered_tube, plan.position.filtered, k + 1)
            components = zip(filtered_state, self.design.filter, inputs["x"], strict=True)
            inputs["v"] = [round_to(z - rate * x, scalar) for z, rate, x in components]
        tick = None
        if name == "control_tick":
            assert self.task.emit.tick_period is not None
            tick = max(0, int(inputs.pop("t") / self.task.emit.tick_period))
        input_balls = {key: _balls(v) for key, v in inputs.items()} | ({} if tick is None else {"tick": tick})
        outputs, statuses = self._run(name, input_balls)
        is_limited = self.task.order == 2 and name == "control" and plan.position == NEAR_MIDDLE
        if len(statuses) != 1 or not all(_is_certain(u, is_limited) for u in outputs["u"]):
            use_double = 'use emit.scalar = "double", ' if scalar == "float" else ""
            raise BadInput(
                f"emit.selftest: a {scalar} rounds too much to tell u, so far from the origin or in so narrow a tube; "
                f"{use_double}put the origin near the task, or leave it out"
            )
        (status,) = statuses
        return _Call(inputs, tick, status, outputs["u"])

    def _run(self, name: str, inputs: dict[str, Any]) -> tuple[dict[str, list[arb]], Any]:
        """Return u and the statuses.

        Of order 2 a slope is a small difference of large terms. All of them depend on t's fraction of its segment, which balls
        forget. So that fraction is cut into pieces, except for a tick, which gives it exactly enough.
        """
        if self.task.order == 1 or name != "control":
            return self.balls.run(name, **inputs)
        row, fraction = self.balls.kernel("segment", inputs["t"])
        ends = [fraction.lower() + (fraction.upper() - fraction.lower()) * k / PIECES for k in range(PIECES)] + [fraction.upper()]
        return self.balls.run_assuming(name, "segment", [(row, a.union(b)) for a, b in pairwise(ends)], **inputs)

    @cached_property
    def _segment_fractions(self) -> Sequence[Fraction]:
        """Return SEGMENT_FRACTIONS, for order 2 those first at which a wrong table entry moves the filtered edges the most.

        An entry moves a filtered edge by the edge's rate and by lambda times the edge, and at some fractions the two cancel.
        """
        if not self.design.filter:
            return SEGMENT_FRACTIONS
        per_second = float(Fraction(self.design.parts or PARTS) / self.design.prescribed_time)

        def smallest_effect(fraction: Fraction) -> float:
            weights, rates = (
                [float(w.mid()) for w in self.balls.kernel(name, ball(fraction))] for name in ("basis", "basis_rate")
            )
            return min(
                abs(per_second * rate + float(value) * weight)
                for value in self.design.filter
                for weight, rate in zip(weights, rates, strict=True)
            )

        return sorted(SEGMENT_FRACTIONS, key=smallest_effect, reverse=True)

    def _time(self, fractions: Sequence[Fraction], k: int) -> tuple[dict[str, Any], Edges, Edges | None]:
        """Return the time (and alpha) of call k, the tube's edges then, and for order 2 those of the filtered tube.

        fractions: of t_c, tried in order. One is skipped if it is so near a knot that rounding leaves two segments possible.
        """
        names = ["tube"] if self.task.order == 1 else ["tube", "filtered_tube"]
        for fraction in fractions:
            inputs: dict[str, Any] = {"t": round_to(self.task.prescribed_time * fraction, self.program.scalar)}
            if any(p.name == "alpha" for p in self.program.function("control").params):
                inputs["alpha"] = [Fraction(k % 4, 8)] * (2 * self.program.dimension)
            tubes = [self.balls.run(name, **{key: _balls(v) for key, v in inputs.items()})[0] for name in names]
            if all(edge.rad() < DECIDED_RADIUS * (1 + abs(edge.mid())) for pair in tubes[0].values() for edge in pair):
                break
        return inputs, tubes[0], tubes[1] if len(tubes) > 1 else None


def _is_certain(u: arb, is_limited: bool) -> bool:
    """Whether u is finite and, if its radius is limited, known well enough that a wrong table entry is noticed."""
    return bool(u.is_finite() and not (is_limited and u.rad() > LARGEST_RELATIVE_RADIUS * abs(u.mid())))


def _state_at(edges: Edges, fraction: Fraction | None, k: int) -> list[Fraction]:
    """Return the state at this fraction of the way from the lower edge to the upper one, or near the middle as of call k."""
    state = []
    for i, (a, b) in enumerate(zip(edges["lower"], edges["upper"], strict=True)):
        lower, upper = Fraction(float(a.mid())), Fraction(float(b.mid()))
        middle = MIDDLE_FRACTIONS[(k + i) % len(MIDDLE_FRACTIONS)]
        state.append(lower + (middle if fraction is None else fraction) * (upper - lower))
    return state


def _balls(value: Fraction | Sequence[Fraction]) -> Any:
    return ball(value) if isinstance(value, Fraction) else [ball(v) for v in value]


def _rounded_outward(u: arb, scalar: str, side: int) -> Fraction:
    """Return the upper end (side 1) or lower end (-1) of a ball, moved outward by two units past the nearest number."""
    nearest = round_to(Fraction(float(u.upper() if side > 0 else u.lower())), scalar)
    if nearest == 0 and u.contains(0) and u.is_exact():
        return nearest
    unit = Fraction(2) ** ulp_exponent(nearest, scalar)
    return max(-FORMATS[scalar].largest, min(FORMATS[scalar].largest, nearest + 2 * side * unit))
