"""Lemmas about sets that move: the parts of a piece, the bounds on a leg, and the displacements that a leg has.

The code is that of `certify/moving_slack.py` and of courses. book.py takes LEMMAS as the family `moving`.
"""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen import constraints
from stt_codegen.certify import moving_slack
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities
from stt_codegen.lemmas.sets.task_constraints import METHOD, N
from stt_codegen.task.sets import Course, Leg

COURSE_COUNT = 200  # random courses


def _prove_parts() -> Outcome:
    """Prove that the part of a cubic from a to b has the coefficients of `cut`; both sides are polynomials in r from 0 to 1."""
    a, b, r = sp.symbols("a b r", real=True)
    c = sp.symbols("c0:4", real=True)

    def value(coefficients: Any, at: Any) -> Any:
        return sum(sp.binomial(3, j) * at**j * (1 - at) ** (3 - j) * v for j, v in enumerate(coefficients))

    part = moving_slack.cut(np.array(c, dtype=object), a, b)
    return prove_identities({"the part": sp.expand(value(list(part), r) - value(c, a + (b - a) * r))}, METHOD)


def _random_number(draw: random.Random) -> Fraction:
    return Fraction(draw.randint(-900, 900), draw.choice((1, 7, 100, 1024)))


def _random_vector(draw: random.Random) -> tuple[Fraction, ...]:
    return tuple(_random_number(draw) for _ in range(N))


def _prove_bounds() -> Outcome:
    """Compare the bound of a constraint on a leg with h(n) + clearance + n.d(t) + g(n) growth(t) at random times.

    Constraints, displacements and growth are random; both sides are linear in t. A displacement between two others has n.d
    between theirs.
    """
    share, failures, draw = sp.Symbol("sigma", real=True), [], random.Random(10)
    u, v, normal = (sp.symbols(f"{name}1:{N + 1}", real=True) for name in "uvn")
    product_between = sum(c * (a + share * (b - a)) for c, a, b in zip(normal, u, v, strict=True))
    products_at_ends = [sum(c * a for c, a in zip(normal, end, strict=True)) for end in (u, v)]

    for _ in range(COURSE_COUNT):
        normals = [tuple(draw.choice((-5, -1, 0, 2, 3)) for _ in range(N)) for _ in range(3)]
        members = [
            constraints.Constraint(
                tuple((i, 0, c) for i, c in enumerate((*n[:-1], n[-1] or 1)) if c),
                _random_number(draw),
                abs(_random_number(draw)),
            )
            for n in normals
        ]
        begin, clock_lead, growth_rates = (
            abs(_random_number(draw)),
            abs(_random_number(draw)),
            tuple(abs(_random_number(draw)) for _ in members),
        )
        displacements = tuple((_random_vector(draw), _random_vector(draw)) for _ in range(2))
        leg = Leg(begin, begin + abs(_random_number(draw)) + Fraction(1, 3), displacements)
        course = Course(
            knots=((Fraction(0), displacements[0][0]),),
            active_interval=None,
            clock_lag=Fraction(0),
            clock_lead=clock_lead,
            spread=abs(_random_number(draw)),
            t_c=leg.end,
        )
        time, length = abs(_random_number(draw)) + 1, Fraction(1, 1 << 20)
        lines = moving_slack.MovingBounds.of(constraints.Avoidance("", tuple(members), course, growth_rates), leg, time, length)
        t = begin + (leg.end - begin) * Fraction(draw.randint(0, 64), 64)
        expected = [
            [
                constraint.bound
                + constraint.clearance
                + g * course.growth(t)
                + sum(c * displacement[i] for i, _, c in constraint.terms)
                for displacement in leg.displacements_at(t)
            ]
            for constraint, g in zip(members, growth_rates, strict=True)
        ]
        if [[v * length for v in row] for row in lines.at(t / time)] != expected:
            failures.append(f"{leg} at {t}")
    return all_of(
        prove_identities(
            {"a place between": sp.expand(product_between - (1 - share) * products_at_ends[0] - share * products_at_ends[1])},
            METHOD,
        ),
        outcome_of_cases(COURSE_COUNT, failures, "bound, clearance, displacement and growth"),
    )


def _prove_places() -> Outcome:
    """Check at random times of random courses that a leg's farthest displacement is the farthest of all readings of the clock."""
    failures, draw = [], random.Random(9)
    for _ in range(COURSE_COUNT):
        times = sorted(draw.sample(range(91), draw.randint(1, 5)))
        knots = tuple((Fraction(at, 10), tuple(Fraction(draw.randint(-40, 40), 10) for _ in range(2))) for at in times)
        clock_lag, clock_range = (Fraction(draw.choice((0, 3, 17)), 10) for _ in range(2))
        begin, end = (Fraction(v, 10) for v in sorted(draw.sample(range(91), 2)))
        window = (begin, end) if draw.random() < 0.5 else None
        course = Course(
            knots=knots,
            active_interval=window,
            clock_lag=clock_lag,
            clock_lead=clock_lag + clock_range,
            spread=Fraction(0),
            t_c=Fraction(9),
        )
        first, last = window or (-clock_lag, 9 + clock_lag + clock_range)
        t = Fraction(draw.randint(0, 9000), 1000)
        corners = [*(at for at, _ in knots), first, last]
        readings = {t - clock_lag, t + course.clock_lead, *(v for v in corners if t - clock_lag <= v <= t + course.clock_lead)}
        displacements = [course.displacement(tau) for tau in readings if first <= tau <= last]
        legs = [leg for leg in course.legs if leg.begin <= t <= leg.end]
        if bool(displacements) != bool(legs):
            failures.append(f"{course} at {t}")
        for leg in legs:
            for normal in ((1, 0), (-1, 0), (0, 1), (0, -1), (2, -3), (-1, 1)):
                farthest_of_leg, farthest_of_clock = (
                    max(sum(c * d for c, d in zip(normal, displacement, strict=True)) for displacement in group)
                    for group in (leg.displacements_at(t), displacements)
                )
                if farthest_of_leg != farthest_of_clock:
                    failures.append(f"{course} at {t} along {normal}")
    return outcome_of_cases(
        COURSE_COUNT, failures, "as far as the farthest reading of the clock; asked for while one is in the window"
    )


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
