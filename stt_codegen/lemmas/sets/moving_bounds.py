"""Sets that move: the parts of a piece, the bounds of a leg, and that its places are all there are."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen import constraints as rows
from stt_codegen.certify import moving_slack as moving
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities
from stt_codegen.lemmas.sets.constraint_rows import METHOD, N
from stt_codegen.task.sets import Course, Leg

DRAWN = 200  # random courses


def _prove_parts() -> Outcome:
    """The part of a cubic from a to b has these Bezier coefficients: both sides are polynomials in a place r of the part."""
    a, b, r = sp.symbols("a b r", real=True)
    c = sp.symbols("c0:4", real=True)

    def value(coefficients: Any, at: Any) -> Any:
        return sum(sp.binomial(3, j) * at**j * (1 - at) ** (3 - j) * v for j, v in enumerate(coefficients))

    part = moving.cut(np.array(c, dtype=object), a, b)
    return prove_identities({"the part": sp.expand(value(list(part), r) - value(c, a + (b - a) * r))}, METHOD)


def _prove_bounds() -> Outcome:
    """The bound of a row on a leg is h(n) + clearance + n.d(t) + g(n) growth(t), of random rows, places and growth at random
    times: both are lines, so two times would do. At a place between two others n.d is between theirs."""
    share, wrong, draw = sp.Symbol("sigma", real=True), [], random.Random(10)
    u, v, normal = (sp.symbols(f"{name}1:{N + 1}", real=True) for name in "uvn")
    between = sum(c * (a + share * (b - a)) for c, a, b in zip(normal, u, v, strict=True))
    ends = [sum(c * a for c, a in zip(normal, end, strict=True)) for end in (u, v)]

    def number() -> Fraction:
        return Fraction(draw.randint(-900, 900), draw.choice((1, 7, 100, 1024)))

    for _ in range(DRAWN):
        told = [tuple(draw.choice((-5, -1, 0, 2, 3)) for _ in range(N)) for _ in range(3)]
        made = [
            rows.Constraint(tuple((i, 0, c) for i, c in enumerate((*n[:-1], n[-1] or 1)) if c), number(), abs(number()))
            for n in told
        ]
        begin, late, growing = abs(number()), abs(number()), tuple(abs(number()) for _ in made)
        places = tuple((tuple(number() for _ in range(N)), tuple(number() for _ in range(N))) for _ in range(2))
        leg = Leg(begin, begin + abs(number()) + Fraction(1, 3), places)
        course = Course(
            knots=((Fraction(0), places[0][0]),),
            active_interval=None,
            clock_lag=Fraction(0),
            clock_lead=late,
            spread=abs(number()),
            t_c=leg.end,
        )
        time, length = abs(number()) + 1, Fraction(1, 1 << 20)
        lines = moving.Lines.of(rows.Avoidance("", tuple(made), course, growing), leg, time, length)
        t = begin + (leg.end - begin) * Fraction(draw.randint(0, 64), 64)
        wanted = [
            [
                r.bound + r.clearance + g * course.growth(t) + sum(c * by[i] for i, _, c in r.terms)
                for by in leg.displacements_at(t)
            ]
            for r, g in zip(made, growing, strict=True)
        ]
        if [[v * length for v in row] for row in lines.at(t / time)] != wanted:
            wrong.append(f"{leg} at {t}")
    return all_of(
        prove_identities({"a place between": sp.expand(between - (1 - share) * ends[0] - share * ends[1])}, METHOD),
        outcome_of_cases(DRAWN, wrong, "bound, clearance, displacement and growth"),
    )


def _prove_places() -> Outcome:
    """Of random courses and times: the farthest place of the leg is the farthest of all readings of the clock."""
    wrong, draw = [], random.Random(9)
    for _ in range(DRAWN):
        times = sorted(draw.sample(range(91), draw.randint(1, 5)))
        knots = tuple((Fraction(at, 10), tuple(Fraction(draw.randint(-40, 40), 10) for _ in range(2))) for at in times)
        early, delay = (Fraction(draw.choice((0, 3, 17)), 10) for _ in range(2))
        a, z = (Fraction(v, 10) for v in sorted(draw.sample(range(91), 2)))
        window = (a, z) if draw.random() < 0.5 else None
        course = Course(
            knots=knots, active_interval=window, clock_lag=early, clock_lead=early + delay, spread=Fraction(0), t_c=Fraction(9)
        )
        first, last = window or (-early, 9 + early + delay)
        t = Fraction(draw.randint(0, 9000), 1000)
        turns = [*(at for at, _ in knots), first, last]
        readings = {t - early, t + course.clock_lead, *(v for v in turns if t - early <= v <= t + course.clock_lead)}
        true = [course.displacement(tau) for tau in readings if first <= tau <= last]
        legs = [leg for leg in course.legs if leg.begin <= t <= leg.end]
        if bool(true) != bool(legs):
            wrong.append(f"{course} at {t}")
        for leg in legs:
            for normal in ((1, 0), (-1, 0), (0, 1), (0, -1), (2, -3), (-1, 1)):
                told, most = (
                    max(sum(c * d for c, d in zip(normal, by, strict=True)) for by in found)
                    for found in (leg.displacements_at(t), true)
                )
                if told != most:
                    wrong.append(f"{course} at {t} along {normal}")
    return outcome_of_cases(DRAWN, wrong, "as far as the farthest reading of the clock; asked for while one is in the window")


LEMMAS = (
    Lemma(
        "moving.parts",
        "What a piece is cut to has the Bezier coefficients of that part of its cubic.",
        r"\sum_j B_j(r)\, b_j' = \sum_j B_j(a + (b - a) r)\, b_j",
        (),
        "the evaluated code",
        _prove_parts,
    ),
    Lemma(
        "moving.bounds",
        "The bound of a moving set's row is a line in time, and between two places it is between theirs.",
        r"h(n) + c|n|_1 + n\cdot d(t) + \rho\,(t + l)\,g(n)",
        ("by cases",),
        "the evaluated code",
        _prove_bounds,
    ),
    Lemma(
        "moving.places",
        "The places of a leg are the corners of the path that the set may be on.",
        r"\max_{t - e\le\tau\le t + l} n\cdot d(\tau) = \max_{d\ \mathrm{of\ the\ leg}} n\cdot d",
        ("by cases",),
        "the evaluated code",
        _prove_places,
    ),
)
