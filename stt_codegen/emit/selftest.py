"""`emit.selftest`: calls of `control` (and `control_tick`) for the board's boot, in a C file of their own.

One call for every three segments of the table (a dozen where there is none), so that every coefficient moves some u, near the
middle of the tube, where u is not saturated; and a few beside the edges, outside and far away. What u may be is an enclosure of
the emitted arithmetic (`program.analyse.balls`), so every right compiler and library passes, whether or not it fuses
multiplications or how it rounds, and nothing that is wrong by more than rounding does. A NaN at the end finds arithmetic
without it.

For plants of order 2 it is v + lambda x that stands near the middle, of the filtered tube, and x elsewhere in its own, so that
a wrong lambda moves u too; v is what is left. Then one of the two strikes while the other is calm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from flint import arb

from stt_codegen.designs import Design
from stt_codegen.errors import BadInput
from stt_codegen.program import FORMATS, REAL, Program, Status, Table, round_to, ulp_exponent
from stt_codegen.program.analyse import Enclosure, ball
from stt_codegen.task import Task

Edges = dict[str, list[arb]]
Shares = tuple[Fraction | None, Fraction | None]  # where x and v + lambda x stand between their edges; None: near the middle

# Where that is, by vector; the next dimension takes the next of the list, v + lambda x the one after x's.
CALM = tuple(Fraction(v) for v in ("0.4", "0.6", "0.45", "0.55", "0.375"))
STRIKING: tuple[Shares, ...] = tuple((Fraction(v), None) for v in ("0.03", "0.97", "-0.5", "1.5", "9"))
STRIKING_SECOND: tuple[Shares, ...] = (
    *((None, Fraction(v)) for v in ("0.03", "0.97", "-0.5", "1.5")),
    *((Fraction(v), None) for v in ("0.03", "0.97", "-0.03", "1.03")),
    (Fraction(9), Fraction(9)),
)
PARTS = 36  # of the time, where there are no segments
PLACES = tuple(Fraction(v) for v in ("0.45", "0.4", "0.5", "0.35", "0.55"))  # of t in its segment or part
PIECES = 16  # of the ball of the place in a segment, for order 2
VAGUE = 1 / 8  # of u: with more left open near the middle, a wrong table would pass
TIGHT = 1e-4  # a ball's radius over its size where nothing was left undecided


@dataclass(frozen=True, kw_only=True)
class Vectors:
    """Calls of one function: arguments one after the other (ticks apart), statuses, the least and greatest u of each."""

    function: str
    ticks: tuple[int, ...]
    points: Table
    statuses: tuple[Status, ...]
    low: Table
    high: Table
    arguments: tuple[tuple[int, bool], ...]  # where in a point, and whether it is an array


def suites(task: Task, design: Design, program: Program) -> list[Vectors]:
    """The vectors of `control`, and of `control_tick` where there is one."""
    balls = Enclosure(program, rounding=True)
    parts = design.parts or PARTS
    calm: Shares = (None, None)
    places = sorted({*range(0, parts, 3), parts - 1})
    strikes = STRIKING if task.order == 1 else STRIKING_SECOND
    struck = [parts * (2 * k + 1) // (2 * len(strikes)) for k in range(len(strikes))]
    when = [(Fraction(k, parts), calm) for k in places] + [(Fraction(k, parts), s) for k, s in zip(struck, strikes, strict=True)]
    when += [(Fraction(-1, 8), calm), (Fraction(9, 8), calm)]  # before the start and after t_c
    names = [f.name for f in program.functions if f.name in ("control", "control_tick")]
    return [_vectors(task, design, program, balls, name, when) for name in names]


def _vectors(
    task: Task,
    design: Design,
    program: Program,
    balls: Enclosure,
    name: str,
    when: Sequence[tuple[Fraction, Shares]],
) -> Vectors:
    """Calls at these shares of the time, each with where x and v + lambda x stand."""
    function, scalar, n = program.function(name), program.scalar, program.dimension
    points: list[Fraction] = []
    low: list[Fraction] = []
    high: list[Fraction] = []
    statuses: list[Status] = []
    ticks: list[int] = []
    part, places = Fraction(1, design.parts or PARTS), _places(design, balls)
    for k, (begin, (share, filtered_share)) in enumerate(when):
        given, tube, filtered = _time(task, program, balls, [begin + place * part for place in places], k)
        given["x"] = [round_to(value, scalar) for value in _standing(tube, share, k)]
        if filtered is not None:
            held = zip(_standing(filtered, filtered_share, k + 1), design.filter, given["x"], strict=True)
            given["v"] = [round_to(z - value * x, scalar) for z, value, x in held]
        if name == "control_tick":
            assert task.emit.tick_period is not None
            ticks.append(max(0, int(given.pop("t") / task.emit.tick_period)))
        inputs = {key: _balls(v) for key, v in given.items()}
        outputs, found = _found(task, balls, name, inputs | ({"tick": ticks[-1]} if ticks else {}))
        second = task.order == 2 and name == "control" and share is None and filtered_share is None
        if len(found) != 1 or any(not u.is_finite() or (second and u.rad() > VAGUE * abs(u.mid())) for u in outputs["u"]):
            doubles = 'use emit.scalar = "double", ' if scalar == "float" else ""
            raise BadInput(
                f"emit.selftest: a {scalar} rounds too much to tell u, so far from the origin or in so narrow a tube; "
                f"{doubles}put the origin near the task, or leave it out"
            )
        statuses += found
        for value in given.values():
            points += value if isinstance(value, list) else [value]
        low += [_outward(u, scalar, -1) for u in outputs["u"]]
        high += [_outward(u, scalar, 1) for u in outputs["u"]]
    numbers = [p for p in function.inputs if p.type is REAL]
    lengths = [p.length or 1 for p in numbers]
    suffix = "" if name == "control" else "_at_ticks"
    return Vectors(
        function=name,
        ticks=tuple(ticks),
        points=Table(
            "points" + suffix, tuple(points), sum(lengths), (f"Arguments of {name}: {', '.join(p.name for p in numbers)}.",)
        ),
        statuses=tuple(statuses),
        low=Table("least" + suffix, tuple(low), n, ("u may be from here",)),
        high=Table("greatest" + suffix, tuple(high), n, ("to here: all that IEEE arithmetic can give.",)),
        arguments=tuple((sum(lengths[:k]), p.length is not None) for k, p in enumerate(numbers)),
    )


def _found(task: Task, balls: Enclosure, name: str, given: dict[str, Any]) -> tuple[dict[str, list[arb]], Any]:
    """u and the statuses. Of order 2 a slope is a small difference of large terms, which all move with the place in the segment,
    but apart in balls. So that place is taken in pieces; a tick gives it so exactly that there is no need."""
    if task.order == 1 or name != "control":
        return balls.run(name, **given)
    row, place = balls.kernel("segment", given["t"])
    ends = [place.lower() + (place.upper() - place.lower()) * k / PIECES for k in range(PIECES)] + [place.upper()]
    return balls.run_assuming(name, "segment", [(row, a.union(b)) for a, b in pairwise(ends)], **given)


def _places(design: Design, balls: Enclosure) -> Sequence[Fraction]:
    """PLACES. For order 2 the best first: a table entry moves a filtered edge by the edge's rate and by lambda times the edge,
    and at some places in a segment the two cancel, so that a wrong entry is not seen there."""
    if not design.filter:
        return PLACES
    per_second = float(Fraction(design.parts or PARTS) / design.prescribed_time)

    def least_seen(place: Fraction) -> float:
        weights, rates = ([float(w.mid()) for w in balls.kernel(name, ball(place))] for name in ("basis", "basis_rate"))
        return min(
            abs(per_second * rate + float(value) * weight)
            for value in design.filter
            for weight, rate in zip(weights, rates, strict=True)
        )

    return sorted(PLACES, key=least_seen, reverse=True)


def _time(
    task: Task, program: Program, balls: Enclosure, shares: Sequence[Fraction], k: int
) -> tuple[dict[str, Any], Edges, Edges | None]:
    """Time (and alpha) of vector k, the tube's edges there, and for order 2 the filtered tube's: the first of these shares of
    the time that is not so near to a knot that either segment may be taken, which shows in the tube."""
    names = ["tube"] if task.order == 1 else ["tube", "filtered_tube"]
    for share in shares:
        given: dict[str, Any] = {"t": round_to(task.prescribed_time * share, program.scalar)}
        if any(p.name == "alpha" for p in program.function("control").params):
            given["alpha"] = [Fraction(k % 4, 8)] * (2 * program.dimension)
        tubes = [balls.run(name, **{key: _balls(v) for key, v in given.items()})[0] for name in names]
        if all(edge.rad() < TIGHT * (1 + abs(edge.mid())) for pair in tubes[0].values() for edge in pair):
            break
    return given, tubes[0], tubes[1] if len(tubes) > 1 else None


def _standing(edges: Edges, share: Fraction | None, k: int) -> list[Fraction]:
    """By component, what stands at this share of the way from the lower edge to the upper one, or near the middle."""
    found = []
    for i, (a, b) in enumerate(zip(edges["lower"], edges["upper"], strict=True)):
        first, last = Fraction(float(a.mid())), Fraction(float(b.mid()))
        found.append(first + (CALM[(k + i) % len(CALM)] if share is None else share) * (last - first))
    return found


def _balls(value: Fraction | Sequence[Fraction]) -> Any:
    return ball(value) if isinstance(value, Fraction) else [ball(v) for v in value]


def _outward(u: arb, scalar: str, side: int) -> Fraction:
    """The end of a ball, rounded outward to the scalar: two units past the nearest number to the end."""
    nearest = round_to(Fraction(float(u.upper() if side > 0 else u.lower())), scalar)
    if nearest == 0 and u.contains(0) and u.is_exact():
        return nearest
    unit = Fraction(2) ** ulp_exponent(nearest, scalar)
    return max(-FORMATS[scalar].largest, min(FORMATS[scalar].largest, nearest + 2 * side * unit))
