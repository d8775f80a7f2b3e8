"""Sets that move: the parts of a piece, the bounds of a leg, and that its places are all there are."""

from __future__ import annotations

import random
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen import rows
from stt_codegen.certify import moving
from stt_codegen.lemmas.lemma import Lemma, Outcome, cases, identity
from stt_codegen.lemmas.rows import METHOD, N
from stt_codegen.task.motion import Course, Leg

DRAWN = 200  # random courses


def _parts() -> Outcome:
    """The part of a cubic from a to b has these Bezier coefficients: both sides are polynomials in a place r of the part."""
    a, b, r = sp.symbols("a b r", real=True)
    c = sp.symbols("c0:4", real=True)

    def value(coefficients: Any, at: Any) -> Any:
        return sum(sp.binomial(3, j) * at**j * (1 - at) ** (3 - j) * v for j, v in enumerate(coefficients))

    part = moving.cut(np.array(c, dtype=object), a, b)
    return identity({"the part": sp.expand(value(list(part), r) - value(c, a + (b - a) * r))}, METHOD)


def _bounds() -> Outcome:
    """The bound of a row on a leg at t is h(n) + clearance + n.d(t) + g(n) growth(t), for a place that moves evenly; at a place
    between two others it is between theirs."""
    t, p, q, late, rho, g, h, keep, share = sp.symbols("t p q l rho g h k sigma", positive=True)
    u, v = (sp.symbols(f"{name}1:{N + 1}", real=True) for name in "uv")
    normal = sp.symbols(f"n1:{N + 1}", real=True)
    row: Any = SimpleNamespace(bound=h, keep=keep, terms=tuple((i, 0, c) for i, c in enumerate(normal)))
    course: Any = SimpleNamespace(growth=lambda at: rho * (at + late))
    leg = Leg(p, q, ((u, v),))
    told = rows.Avoidance("", (row,), course, (g,)).bounds(leg, t)[0][0]
    by = [a + (t - p) / (q - p) * (b - a) for a, b in zip(u, v, strict=True)]
    wanted = h + keep + g * rho * (t + late) + sum(c * d for c, d in zip(normal, by, strict=True))
    between = sum(c * (a + share * (b - a)) for c, a, b in zip(normal, u, v, strict=True))
    ends = [sum(c * a for c, a in zip(normal, end, strict=True)) for end in (u, v)]
    return identity(
        {
            "the bound": sp.simplify(sp.expand(told - wanted)),
            "a place between": sp.expand(between - (1 - share) * ends[0] - share * ends[1]),
        },
        METHOD,
    )


def _places() -> Outcome:
    """Of random courses and times: the farthest place of the leg is the farthest of all readings of the clock."""
    wrong, draw = [], random.Random(9)
    for _ in range(DRAWN):
        times = sorted(draw.sample(range(91), draw.randint(1, 5)))
        knots = tuple((Fraction(at, 10), tuple(Fraction(draw.randint(-40, 40), 10) for _ in range(2))) for at in times)
        early, delay = (Fraction(draw.choice((0, 3, 17)), 10) for _ in range(2))
        a, z = (Fraction(v, 10) for v in sorted(draw.sample(range(91), 2)))
        window = (a, z) if draw.random() < 0.5 else None
        course = Course(knots, window, early, early + delay, Fraction(0), Fraction(9))
        first, last = window or (-early, 9 + early + delay)
        t = Fraction(draw.randint(0, 9000), 1000)
        turns = [*(at for at, _ in knots), first, last]
        readings = {t - early, t + course.late, *(v for v in turns if t - early <= v <= t + course.late)}
        true = [course.displaced(tau) for tau in readings if first <= tau <= last]
        legs = [leg for leg in course.legs if leg.begin <= t <= leg.end]
        if bool(true) != bool(legs):
            wrong.append(f"{course} at {t}")
        for leg in legs:
            for normal in ((1, 0), (-1, 0), (0, 1), (0, -1), (2, -3), (-1, 1)):
                told, most = (
                    max(sum(c * d for c, d in zip(normal, by, strict=True)) for by in found) for found in (leg.at(t), true)
                )
                if told != most:
                    wrong.append(f"{course} at {t} along {normal}")
    return cases(DRAWN, wrong, "as far as the farthest reading of the clock; asked for while one is in the window")


LEMMAS = (
    Lemma(
        "moving.parts",
        "What a piece is cut to has the Bezier coefficients of that part of its cubic.",
        r"\sum_j B_j(r)\, b_j' = \sum_j B_j(a + (b - a) r)\, b_j",
        (),
        "the evaluated code",
        _parts,
    ),
    Lemma(
        "moving.bounds",
        "The bound of a moving set's row is a line in time, and between two places it is between theirs.",
        r"h(n) + c|n|_1 + n\cdot d(t) + \rho\,(t + l)\,g(n)",
        (),
        "the evaluated code",
        _bounds,
    ),
    Lemma(
        "moving.places",
        "The places of a leg are the corners of the path that the set may be on.",
        r"\max_{t - e\le\tau\le t + l} n\cdot d(\tau) = \max_{d\ \mathrm{of\ the\ leg}} n\cdot d",
        ("by cases",),
        "the evaluated code",
        _places,
    ),
)
