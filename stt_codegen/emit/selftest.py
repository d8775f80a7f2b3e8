"""`emit.selftest`: a dozen calls of `control` for the board's boot, in a C file of their own.

What u may be is an enclosure of the emitted arithmetic (`program.arb`), so every right compiler and library passes, whether or
not it fuses multiplications, and nothing that is wrong by more than rounding does. A NaN at the end finds -ffast-math.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb

from stt_codegen.program.arb import Enclosure, ball
from stt_codegen.program.number import FORMATS, round_to, ulp_exponent
from stt_codegen.program.program import Program, Status, Table
from stt_codegen.task import Task

# Where x stands between the edges, by vector; the next dimension takes the next of the list.
SHARES = tuple(Fraction(v) for v in ("0.5", "0.25", "0.75", "0.03", "0.97", "-0.5", "1.5", "0.125", "0.875", "0.6", "0.375", "9"))
PLACES = tuple(Fraction(v) for v in ("0.4", "0.45", "0.35", "0.55", "0.3"))  # of t in its twelfth of the time
TIGHT = 1e-4  # a ball's radius over its size where nothing was left undecided


@dataclass(frozen=True)
class Vectors:
    """Arguments of `control` one after the other, statuses, and the least and greatest u of each vector."""

    points: Table
    statuses: tuple[Status, ...]
    low: Table
    high: Table
    offsets: tuple[int, ...]  # of the arguments in a point
    arrays: tuple[bool, ...]  # which of them are arrays


def vectors(task: Task, program: Program) -> Vectors:
    """Twelve points of `control`: times spread over [0, t_c], states in the middle, beside the edges, outside, far away."""
    balls = Enclosure(program, rounding=True)
    control = program.function("control")
    n, scalar = program.dimension, program.scalar
    points: list[Fraction] = []
    low: list[Fraction] = []
    high: list[Fraction] = []
    statuses: list[Status] = []
    for k in range(len(SHARES)):
        for place in PLACES:  # the first that is not so near to a knot that either segment may be taken
            given: dict[str, Any] = {"t": round_to(task.prescribed_time * (k + place) / len(SHARES), scalar)}
            if any(p.name == "alpha" for p in control.params):
                given["alpha"] = [Fraction(k % 4, 8)] * (2 * n)
            edges, _ = balls.run("tube", **{name: _balls(v) for name, v in given.items()})
            if all(edge.rad() < TIGHT * (1 + abs(edge.mid())) for pair in edges.values() for edge in pair):
                break
        x = []
        for i, (a, b) in enumerate(zip(edges["lower"], edges["upper"], strict=True)):
            first, last = Fraction(float(a.mid())), Fraction(float(b.mid()))
            x.append(round_to(first + SHARES[(k + i) % len(SHARES)] * (last - first), scalar))
        given["x"] = x
        outputs, found = balls.run("control", **{name: _balls(v) for name, v in given.items()})
        (status,) = found
        statuses.append(status)
        for value in given.values():
            points += value if isinstance(value, list) else [value]
        low += [_outward(u, scalar, -1) for u in outputs["u"]]
        high += [_outward(u, scalar, 1) for u in outputs["u"]]
    lengths = [p.length or 1 for p in control.inputs]
    return Vectors(
        Table(
            "points", tuple(points), sum(lengths), ("Arguments of control: " + ", ".join(p.name for p in control.inputs) + ".",)
        ),
        tuple(statuses),
        Table("least", tuple(low), n, ("u may be from here",)),
        Table("greatest", tuple(high), n, ("to here: all that IEEE arithmetic can give.",)),
        tuple(sum(lengths[:k]) for k in range(len(lengths))),
        tuple(p.length is not None for p in control.inputs),
    )


def _balls(value: Fraction | Sequence[Fraction]) -> Any:
    return ball(value) if isinstance(value, Fraction) else [ball(v) for v in value]


def _outward(u: arb, scalar: str, side: int) -> Fraction:
    """The end of a ball, rounded outward to the scalar: two units past the nearest number to the end."""
    nearest = round_to(Fraction(float(u.upper() if side > 0 else u.lower())), scalar)
    if nearest == 0 and u.contains(0) and u.is_exact():
        return nearest
    unit = Fraction(2) ** ulp_exponent(nearest, scalar)
    return max(-FORMATS[scalar].largest, min(FORMATS[scalar].largest, nearest + 2 * side * unit))
