"""Limits on u: the exit inequality, and that what P8 asks for is needed and, with a law that asks for enough, enough.

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

a, b, g, u, F, room = sp.symbols("a b g u F room", positive=True)
rise_L, rise_R, x_rate = sp.symbols("Ldot Rdot xdot", real=True)
TASKS = 60  # random ones


def _prove_exit() -> Outcome:
    """d eps/dt = adot/a - bdot/b with adot = xdot - Ldot, bdot = Rdot - xdot."""
    epsilon_rate = (x_rate - rise_L) / a - (rise_R - x_rate) / b
    return prove_identities(
        {"epsdot a b/(a + b) - (xdot - (b Ldot + a Rdot)/(a + b))": epsilon_rate * a * b / (a + b)
         - (x_rate - (b * rise_L + a * rise_R) / (a + b))}
    )  # fmt: skip


def _prove_saturated() -> Outcome:
    """At eps = E the input is -v with v the lesser of u_max and the law's, and g v = P + room, P = F + p with p at least -Ldot
    and -Rdot: xdot <= F - g v, so epsdot < 0, against eps < E before. By symmetry the lower edge."""
    p_L, p_R, p = sp.symbols("s_L s_R p", nonnegative=True)  # Ldot = s_L - p, Rdot = s_R - p
    pushed = F - (F + p + room)
    exit_rate = pushed - (b * (p_L - p) + a * (p_R - p)) / (a + b)
    return all_of(
        prove_identities({"left": exit_rate + room + (b * p_L + a * p_R) / (a + b)}),
        prove_positive({"what is left below 0": room + (b * p_L + a * p_R) / (a + b)}),
    )


def _prove_needed() -> Outcome:
    """At x = R under f + w = F and the least g, R - x falls at F - g v - Rdot for the input -v: at `room` for the largest v, of
    which g u_max = F - Rdot - room, and faster by g less for each that v is less."""
    falls, less = (F - g * u) - rise_R, sp.Symbol("less", positive=True)
    most = (F - rise_R - room) / g
    return all_of(
        prove_identities({"at the limit": sp.expand(falls.subs(u, most) - room)}),
        prove_positive({"at the limit": room, "at less": sp.expand(falls.subs(u, most - less)) - room}),
    )


def _prove_rows() -> Outcome:
    """Of random tasks: rows by hand, in fractions."""
    draw, wrong = random.Random(20), []

    def number(low: int, high: int) -> Fraction:
        return Fraction(draw.randint(low, high), 1000)

    for _ in range(TASKS):
        n = draw.randint(1, 3)
        plant = {k: number(1, 900) for k in ("f_max", "w_max", "g_min", "g_cross") if draw.random() < 0.7}
        plant = plant or {"w_max": Fraction(1)}
        u_max, scalar = [number(1, 5000) for _ in range(n)], draw.choice(("float", "double"))
        box = {"lower": [0] * n, "upper": [1] * n}
        task = Task(
            name="t", prescribed_time=1, initial_state=["0.5"] * n, state_space=box, initial_set=box, target_set=box,
            control={"u_max": u_max}, plant=plant, emit={"scalar": scalar},
        )  # fmt: skip
        held = [round_down(v, scalar) for v in u_max]
        for i, v in enumerate(held):
            others = plant.get("g_cross", 0) * sum(held[:i] + held[i + 1 :])
            most = plant.get("g_min", 1) * v - plant.get("f_max", 0) - plant.get("w_max", 0) - others
            here = [row for row in constraints.limit_constraints(task) if row.dimension == i]
            wanted = [
                constraints.Constraint(((i, LOWER, -1),), -most, order=1),
                constraints.Constraint(((i, UPPER, 1),), -most, order=1),
            ]
            wrong += [] if here == wanted else [f"{plant}, u_max {u_max}: {here}"]
    return outcome_of_cases(TASKS, wrong, "L' and -R' below g_min u_max - f_max - w_max - g_cross (sum of the others)")


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
