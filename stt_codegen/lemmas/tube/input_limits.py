"""Lemmas about limits on u: the exit inequality, and that P8 is necessary and, with a sufficient gain, sufficient.

book.py takes LEMMAS as a part of the family `limits`; the other part is sampling/saturated.py.

xdot = f + g u + w in one component, between edges L < R; a = x - L, b = R - x. What the other inputs push is in F.
"""

from __future__ import annotations

import random
from fractions import Fraction

import sympy as sp

from stt_codegen import constraints
from stt_codegen.designs import LOWER, UPPER
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities, prove_positive
from stt_codegen.program import round_down
from stt_codegen.task import Task

a, b, g, u, F, margin = sp.symbols("a b g u F room", positive=True)
lower_rate, upper_rate, x_rate = sp.symbols("Ldot Rdot xdot", real=True)
TASK_COUNT = 60  # random tasks


def _prove_exit() -> Outcome:
    """Prove the exit inequality from d eps/dt = adot/a - bdot/b with adot = xdot - Ldot and bdot = Rdot - xdot."""
    epsilon_rate = (x_rate - lower_rate) / a - (upper_rate - x_rate) / b
    return prove_identities(
        {"epsdot a b/(a + b) - (xdot - (b Ldot + a Rdot)/(a + b))": epsilon_rate * a * b / (a + b)
         - (x_rate - (b * lower_rate + a * upper_rate) / (a + b))}
    )  # fmt: skip


def _prove_saturated() -> Outcome:
    """Prove that epsdot < 0 at eps = E, which contradicts eps < E before.

    There the input is -v with v the smaller of u_max and the law's. g v = P + room and P = F + p, with p at least -Ldot and
    -Rdot, so xdot <= F - g v. The lower edge is the same by symmetry.
    """
    lower_slack, upper_slack, edge_rate = sp.symbols("s_L s_R p", nonnegative=True)  # Ldot = s_L - p, Rdot = s_R - p
    velocity = F - (F + edge_rate + margin)
    exit_rate = velocity - (b * (lower_slack - edge_rate) + a * (upper_slack - edge_rate)) / (a + b)
    return all_of(
        prove_identities({"left": exit_rate + margin + (b * lower_slack + a * upper_slack) / (a + b)}),
        prove_positive({"what is left below 0": margin + (b * lower_slack + a * upper_slack) / (a + b)}),
    )


def _prove_needed() -> Outcome:
    """Prove that R - x falls at x = R for every input within the limit, under f + w = F and the smallest g.

    For the input -v it falls at F - g v - Rdot. That is `room` for v = u_max, where g u_max = F - Rdot - room, and more for any
    smaller v.
    """
    fall, reduction = (F - g * u) - upper_rate, sp.Symbol("less", positive=True)
    u_max = (F - upper_rate - margin) / g
    return all_of(
        prove_identities({"at the limit": sp.expand(fall.subs(u, u_max) - margin)}),
        prove_positive({"at the limit": margin, "at less": sp.expand(fall.subs(u, u_max - reduction)) - margin}),
    )


def _prove_rows() -> Outcome:
    """Compare the constraints of P8 of random tasks with the inequality of the statement, in fractions."""
    draw, failures = random.Random(20), []

    def random_number(low: int, high: int) -> Fraction:
        return Fraction(draw.randint(low, high), 1000)

    for _ in range(TASK_COUNT):
        n = draw.randint(1, 3)
        plant = {key: random_number(1, 900) for key in ("f_max", "w_max", "g_min", "g_cross") if draw.random() < 0.7}
        plant = plant or {"w_max": Fraction(1)}
        u_max, scalar = [random_number(1, 5000) for _ in range(n)], draw.choice(("float", "double"))
        box = {"lower": [0] * n, "upper": [1] * n}
        task = Task(
            name="t", prescribed_time=1, initial_state=["0.5"] * n, state_space=box, initial_set=box, target_set=box,
            control={"u_max": u_max}, plant=plant, emit={"scalar": scalar},
        )  # fmt: skip
        emitted_limits = [round_down(v, scalar) for v in u_max]
        for i, v in enumerate(emitted_limits):
            coupling = plant.get("g_cross", 0) * sum(emitted_limits[:i] + emitted_limits[i + 1 :])
            authority = plant.get("g_min", 1) * v - plant.get("f_max", 0) - plant.get("w_max", 0) - coupling
            computed = [constraint for constraint in constraints.limit_constraints(task) if constraint.dimension == i]
            expected = [
                constraints.Constraint(((i, LOWER, -1),), -authority, order=1),
                constraints.Constraint(((i, UPPER, 1),), -authority, order=1),
            ]
            failures += [] if computed == expected else [f"{plant}, u_max {u_max}: {computed}"]
    return outcome_of_cases(TASK_COUNT, failures, "L' and -R' below g_min u_max - f_max - w_max - g_cross (sum of the others)")


LEMMAS = (
    Lemma(
        "limits.exit",
        "Whether eps rises is whether xdot is above a mean of both edges' rates, each weighed by the distance to the other.",
        r"\dot\epsilon\,\frac{ab}{a+b} = \dot x - \frac{b\dot L + a\dot R}{a+b}",
        ("L < x < R",),
        "ours",
        _prove_exit,
    ),
    Lemma(
        "limits.saturated",
        "Where g min(u_max, what the law asks for at |eps| = E) is above F and both edges' rates, |eps| < E stays.",
        r"g\,\min(u_{max}, k\,h) > F + \max(-\dot L, -\dot R) \Rightarrow \dot\epsilon < 0\ \mathrm{at}\ \epsilon = E",
        ("u is continuous in time", "inputs of the others are in F", "the lower edge by symmetry"),
        "ours",
        _prove_saturated,
        ("limits.exit",),
    ),
    Lemma(
        "limits.needed",
        "Where P8 fails strictly, a plant within the bounds takes the state out at that edge whatever u within the limit is.",
        r"g_{min} u_{max} < F - \dot R \Rightarrow \tfrac{d}{dt}(R - x) < 0\ \mathrm{at}\ x = R",
        ("f + w = F and g = g_min may be there",),
        "ours",
        _prove_needed,
    ),
    Lemma(
        "limits.rows",
        "The rows of P8 are those of the statement, with u_max as it is emitted.",
        r"\dot L_i, -\dot R_i < g_{min} u_i - f_{max} - w_{max} - g_{cross}\textstyle\sum_{j\ne i} u_j",
        ("by cases",),
        "the evaluated code",
        _prove_rows,
    ),
)
