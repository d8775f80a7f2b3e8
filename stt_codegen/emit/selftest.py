"""`emit.selftest`: calls of `control` (and `control_tick`) for the board's boot, in a C file of their own.

One call for every three segments of the table (a dozen where there is none), so that every coefficient moves some u, near the
middle of the tube, where u is not saturated; and a few beside the edges, outside and far away. What u may be is an enclosure of
the emitted arithmetic (`program.arb`), so every right compiler and library passes, whether or not it fuses multiplications or how
it rounds, and nothing that is wrong by more than rounding does. A NaN at the end finds arithmetic without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb

from stt_codegen.designs import AdaptiveDesign, RefinedDesign
from stt_codegen.program import REAL, Program, Status, Table
from stt_codegen.program.ball_arithmetic import ball
from stt_codegen.program.balls import Enclosure
from stt_codegen.program.number import FORMATS, round_to, ulp_exponent
from stt_codegen.task import Task

# Where x stands between the edges, by vector; the next dimension takes the next of the list.
CALM = tuple(Fraction(v) for v in ("0.4", "0.6", "0.45", "0.55", "0.375"))
STRIKING = tuple(Fraction(v) for v in ("0.03", "0.97", "-0.5", "1.5", "9"))
PARTS = 36  # of the time, where there are no segments
PLACES = tuple(Fraction(v) for v in ("0.45", "0.4", "0.5", "0.35", "0.55"))  # of t in its segment or part
TIGHT = 1e-4  # a ball's radius over its size where nothing was left undecided


@dataclass(frozen=True)
class Vectors:
    """Calls of one function: arguments one after the other (ticks apart), statuses, the least and greatest u of each."""

    function: str
    ticks: tuple[int, ...]
    points: Table
    statuses: tuple[Status, ...]
    low: Table
    high: Table
    arguments: tuple[tuple[int, bool], ...]  # where in a point, and whether it is an array


def suites(task: Task, design: RefinedDesign | AdaptiveDesign, program: Program) -> list[Vectors]:
    """The vectors of `control`, and of `control_tick` where there is one."""
    balls = Enclosure(program, rounding=True)
    parts = design.parts or PARTS
    calm = sorted({*range(0, parts, 3), parts - 1})
    striking = [parts * (2 * k + 1) // (2 * len(STRIKING)) for k in range(len(STRIKING))]
    when = [(Fraction(k, parts), None) for k in calm] + [(Fraction(k, parts), s) for k, s in zip(striking, STRIKING, strict=True)]
    when += [(Fraction(-1, 8), None), (Fraction(9, 8), None)]  # before the start and after t_c
    names = [f.name for f in program.functions if f.name in ("control", "control_tick")]
    return [_vectors(task, program, balls, name, when, Fraction(1, parts)) for name in names]


def _vectors(
    task: Task, program: Program, balls: Enclosure, name: str, when: Sequence[tuple[Fraction, Fraction | None]], part: Fraction
) -> Vectors:
    """Calls at these shares of the time, each with where x stands (near the middle without)."""
    function, scalar, n = program.function(name), program.scalar, program.dimension
    points: list[Fraction] = []
    low: list[Fraction] = []
    high: list[Fraction] = []
    statuses: list[Status] = []
    ticks: list[int] = []
    for k, (begin, share) in enumerate(when):
        given, edges = _time(task, program, balls, begin, part, k)
        x = []
        for i, (a, b) in enumerate(zip(edges["lower"], edges["upper"], strict=True)):
            first, last = Fraction(float(a.mid())), Fraction(float(b.mid()))
            x.append(round_to(first + (CALM[(k + i) % len(CALM)] if share is None else share) * (last - first), scalar))
        given["x"] = x
        if name == "control_tick":
            assert task.emit.tick_period is not None
            ticks.append(max(0, int(given.pop("t") / task.emit.tick_period)))
            outputs, found = balls.run(name, tick=ticks[-1], **{key: _balls(v) for key, v in given.items()})
        else:
            outputs, found = balls.run(name, **{key: _balls(v) for key, v in given.items()})
        (status,) = found
        statuses.append(status)
        for value in given.values():
            points += value if isinstance(value, list) else [value]
        low += [_outward(u, scalar, -1) for u in outputs["u"]]
        high += [_outward(u, scalar, 1) for u in outputs["u"]]
    numbers = [p for p in function.inputs if p.type is REAL]
    lengths = [p.length or 1 for p in numbers]
    suffix = "" if name == "control" else "_at_ticks"
    return Vectors(
        name,
        tuple(ticks),
        Table("points" + suffix, tuple(points), sum(lengths), (f"Arguments of {name}: {', '.join(p.name for p in numbers)}.",)),
        tuple(statuses),
        Table("least" + suffix, tuple(low), n, ("u may be from here",)),
        Table("greatest" + suffix, tuple(high), n, ("to here: all that IEEE arithmetic can give.",)),
        tuple((sum(lengths[:k]), p.length is not None) for k, p in enumerate(numbers)),
    )


def _time(
    task: Task, program: Program, balls: Enclosure, begin: Fraction, part: Fraction, k: int
) -> tuple[dict[str, Any], dict[str, list[arb]]]:
    """Time (and alpha) of vector k and the tube's edges there: the first place that is not so near to a knot that either segment
    may be taken."""
    for place in PLACES:
        given: dict[str, Any] = {"t": round_to(task.prescribed_time * (begin + place * part), program.scalar)}
        if any(p.name == "alpha" for p in program.function("control").params):
            given["alpha"] = [Fraction(k % 4, 8)] * (2 * program.dimension)
        edges, _ = balls.run("tube", **{name: _balls(v) for name, v in given.items()})
        if all(edge.rad() < TIGHT * (1 + abs(edge.mid())) for pair in edges.values() for edge in pair):
            break
    return given, edges


def _balls(value: Fraction | Sequence[Fraction]) -> Any:
    return ball(value) if isinstance(value, Fraction) else [ball(v) for v in value]


def _outward(u: arb, scalar: str, side: int) -> Fraction:
    """The end of a ball, rounded outward to the scalar: two units past the nearest number to the end."""
    nearest = round_to(Fraction(float(u.upper() if side > 0 else u.lower())), scalar)
    if nearest == 0 and u.contains(0) and u.is_exact():
        return nearest
    unit = Fraction(2) ** ulp_exponent(nearest, scalar)
    return max(-FORMATS[scalar].largest, min(FORMATS[scalar].largest, nearest + 2 * side * unit))
