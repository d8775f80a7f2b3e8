"""Plants of order 2: the filtered tube, the exit inequality, what pushes, and the code that bounds it.

One component: xdot = v, vdot = q = f + g u + w; a_0 = x - L, b_0 = R - x, a = (v - L') + lambda a_0, b = (R' - v) + lambda b_0.
W = R - L, Z = a + b = W' + lambda W.
"""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen.designs import LOWER, UPPER, RefinedDesign, demanded_accelerations, filtered_edges
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities, prove_positive
from stt_codegen.lemmas.sampling import refusing_condition
from stt_codegen.sampling import FRACTIONS, filtered_extremes, inertial_motion

t, s = sp.symbols("t s", positive=True)
lam, F = sp.symbols("lambda F", positive=True)
L, R, x = (sp.Function(name)(t) for name in "LRx")
v, q = sp.diff(x, t), sp.diff(x, t, 2)
a0, b0 = x - L, R - x
a, b = (v - sp.diff(L, t)) + lam * a0, (sp.diff(R, t) - v) + lam * b0
DESIGNS = 12  # random ones


def _prove_inside() -> Outcome:
    """b_0' = b - lambda b_0, so (e^(lambda t) b_0)' = e^(lambda t) b > 0 while b > 0: b_0 stays above e^(-lambda t) b_0(0)."""
    start = sp.Symbol("b_0(0)", positive=True)
    grown = sp.Symbol("growth", positive=True)  # the integral of e^(lambda s) b(s) from 0 to t
    return all_of(
        prove_identities(
            {
                "b_0' - (b - lambda b_0)": sp.expand(sp.diff(b0, t) - (b - lam * b0)),
                "a_0' - (a - lambda a_0)": sp.expand(sp.diff(a0, t) - (a - lam * a0)),
                "(e^(lambda t) b_0)' - e^(lambda t) b": sp.expand(sp.diff(sp.exp(lam * t) * b0, t) - sp.exp(lam * t) * b),
                "a + b - (W' + lambda W)": sp.expand(a + b - (sp.diff(R - L, t) + lam * (R - L))),
            }
        ),
        prove_positive({"e^(-lambda t) (b_0(0) + growth)": sp.exp(-lam * t) * (start + grown)}),
    )


def _prove_largest() -> Outcome:
    """At x = R a velocity above R' takes x out, and v + lambda x = B there is v = R': no larger filtered tube keeps x in."""
    more = sp.Symbol("more", positive=True)
    held = sp.diff(R, t) + lam * R + more  # v + lambda x
    out = (held - lam * R) - sp.diff(R, t)  # v - R' at x = R
    return all_of(prove_identities({"v - R' at the edge": sp.expand(out - more)}), prove_positive({"v - R'": more}))


def _prove_exit() -> Outcome:
    """a' and b' by Lemma 3 of order 2; in a'/a - b'/b the terms lambda a/a and lambda b/b cancel."""
    q_, bend_l, bend_r, p0, m0 = sp.symbols("q L'' R'' R-x x-L", real=True)
    far, near = sp.symbols("a b", positive=True)
    rate_a = q_ - bend_l + lam * far - lam**2 * m0
    rate_b = bend_r - q_ + lam * near - lam**2 * p0
    pushed = (far * (lam**2 * p0 - bend_r) + near * (-bend_l - lam**2 * m0)) / (far + near)
    return prove_identities(
        {
            "a' as it is": sp.expand(sp.diff(a, t) - (q - sp.diff(L, t, 2) + lam * a - lam**2 * a0)),
            "b' as it is": sp.expand(sp.diff(b, t) - (sp.diff(R, t, 2) - q + lam * b - lam**2 * b0)),
            "eps' a b/(a + b) - (q + pushed)": sp.together(
                (rate_a / far - rate_b / near) * far * near / (far + near) - (q_ + pushed)
            ),
        }
    )


def _prove_pushed() -> Outcome:
    """The mean of the exit inequality is at most the larger of lambda^2 W - R'' and -L'': what each lacks, weighed."""
    far, near, lesser, room, more = sp.symbols("a b x-L s_1 s_2", positive=True)
    width, top = sp.symbols("W P", positive=True)  # P is the larger: lambda^2 W - R'' = P - s_1, -L'' = P - s_2
    mean = (far * ((top - room) - lam**2 * lesser) + near * ((top - more) - lam**2 * lesser)) / (far + near)
    rest = (far * room + near * more) / (far + near) + lam**2 * lesser
    told = lam**2 * (width - lesser) - (lam**2 * width - (top - room)) - ((top - room) - lam**2 * lesser)
    return all_of(
        prove_identities({"P - the mean": sp.together(top - mean - rest), "lambda^2 (R - x) - R''": sp.expand(told)}),
        prove_positive({"what is left": rest}),
    )


def _prove_ages() -> Outcome:
    """While g u <= 0 a' and -b' are below P_d: lambda a < lambda Z, lambda^2 (R - x) < lambda^2 W, f + w <= F."""
    force, own, lesser, more = sp.symbols("s_F g|u| s_a s_x", nonnegative=True)
    width, z, left = sp.symbols("W Z x-L", positive=True)
    bend_l, bend_r = sp.symbols("L'' R''", real=True)
    rate_a = (F - force) - own - bend_l + lam * (z - lesser) - lam**2 * left
    rate_b = bend_r - ((F - force) - own) + lam * more - lam**2 * (width - left)
    first, last = F - bend_l + lam * z, F - bend_r + lam**2 * width
    return all_of(
        prove_identities(
            {
                "P_d - a'": sp.expand(first - rate_a - (force + own + lam * lesser + lam**2 * left)),
                "P_d + b'": sp.expand(last + rate_b - (force + own + lam * more + lam**2 * left)),
            }
        ),
        prove_positive(
            {"P_d - a'": force + own + lam * lesser + lam**2 * left, "P_d + b'": force + own + lam * more + lam**2 * left}
        ),
    )


def _prove_middle() -> Outcome:
    """z less its middle moves at q - c'' + lambda (v - c'); v - c' is the difference of numbers below Z/2 and lambda W/2."""
    c = (L + R) / 2
    held = (v + lam * x) - (sp.diff(c, t) + lam * c)
    return prove_identities(
        {
            "(z - middle)'": sp.expand(sp.diff(held, t) - (q - sp.diff(c, t, 2) + lam * (v - sp.diff(c, t)))),
            "v - c'": sp.expand((v - sp.diff(c, t)) - (held - lam * (x - c))),
            "middle of the filtered tube": sp.expand(
                (sp.diff(L, t) + lam * L + sp.diff(R, t) + lam * R) / 2 - (sp.diff(c, t) + lam * c)
            ),
        }
    )


def _prove_rest() -> Outcome:
    """At rest a = lambda a_0 - L' and b = lambda b_0 + R', positive for every x inside where L' <= 0 <= R'."""
    inside, out, up = sp.symbols("x-L -L' R'", nonnegative=True)
    place = sp.Symbol("a_0", positive=True)
    return prove_positive({"a": lam * place + out, "b": lam * place + up + 0 * inside})


def _random_design(draw: random.Random) -> RefinedDesign:
    n, segments = draw.randint(1, 2), draw.randint(4, 7)
    low = [[draw.randint(-90, 90) for _ in range(n)] for _ in range(segments + 3)]
    wide = [[draw.randint(20, 60) for _ in range(n)] for _ in range(segments + 3)]
    table = tuple(tuple((a, a + w) for a, w in zip(*row, strict=True)) for row in zip(low, wide, strict=True))
    table = (*table[:-2], table[-3], table[-3])
    lambdas = tuple(Fraction(draw.randint(1, 40), draw.choice((1, 3, 8))) for _ in range(n))
    return RefinedDesign(Fraction(draw.randint(1, 50), 7), segments, 6, table, filter=lambdas)


def _cubic(table: Any, k: int, i: int, side: int) -> Any:
    """The edge on segment k as a polynomial in s, from the B-spline's formula."""
    basis = ((1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3)
    return sp.expand(sum(int(table[k + j][i][side]) * w for j, w in enumerate(basis)))


def _prove_evaluated() -> Outcome:
    """Of random designs: A, B, and what is asked at both edges, as polynomials of s, from the spline's formula."""
    draw, wrong = random.Random(7), []
    for _ in range(DESIGNS):
        design = _random_design(draw)
        per, unit = sp.Rational(design.segments) / sp.Rational(str(design.prescribed_time)), sp.Rational(str(design.unit))
        edges, press = filtered_edges(design), demanded_accelerations(design)
        for k in (0, design.segments // 2, design.segments - 1):
            for i, value in enumerate(design.filter):
                own = sp.Rational(str(value))
                low, high = (_cubic(design.table, k, i, side) * unit for side in (LOWER, UPPER))
                wanted = [(edges, side, sp.diff(e, s) * per + own * e) for side, e in ((LOWER, low), (UPPER, high))]
                square = own**2 * (high - low)
                wanted += [
                    (press, LOWER, square + sp.diff(low, s, 2) * per**2),
                    (press, UPPER, sp.diff(high, s, 2) * per**2 - square),
                ]
                for pieces, side, polynomial in wanted:
                    given = [sp.Rational(str(int(c) * pieces.unit)) for c in pieces.coefficients[k, i, side]]
                    own_ = sum(sp.binomial(3, j) * s**j * (1 - s) ** (3 - j) * c for j, c in enumerate(given))
                    if sp.expand(own_ - polynomial) != 0:
                        wrong.append(f"{design} segment {k}")
    return outcome_of_cases(DESIGNS, wrong, "A, B, lambda^2 W + L'' and R'' - lambda^2 W are these polynomials")


def _prove_windows() -> Outcome:
    """Of random designs: what a window says is no less than what any of 40 places of it and of the window before has."""
    draw, wrong = random.Random(8), []
    for _ in range(DESIGNS):
        design = _random_design(draw)
        per, unit = design.segments / float(design.prescribed_time), float(design.unit)
        every = inertial_motion(filtered_extremes(design, FRACTIONS), design.filter, FRACTIONS)
        for k in range(design.segments + 1):
            for i, lambda_ in enumerate(design.filter):
                value, here = float(lambda_), []
                for p in {min(k, design.segments - 1), min(max(k - 1, 0), design.segments - 1)}:
                    low, high = (
                        sp.lambdify(s, [_cubic(design.table, p, i, side).diff(s, d) for d in range(3)]) for side in (0, 1)
                    )
                    places = np.linspace(0, 1, 40) if k < design.segments else np.ones(1)
                    here += [(k in (p, design.segments), *low(u), *high(u)) for u in places]
                for own, l0, l1, l2, r0, r1, r2 in here:
                    w, z = (r0 - l0) * unit, ((r1 - l1) * per + value * (r0 - l0)) * unit
                    bend_l, bend_r = l2 * per**2 * unit, r2 * per**2 * unit
                    at_edge = max(value**2 * w - bend_r, -bend_l, value**2 * w + bend_l, bend_r)
                    aged = max(value * z - bend_l, value**2 * w - bend_r, value * z + bend_r, value**2 * w + bend_l, 0)
                    turned = abs(bend_l + bend_r) / 2 + value * (z + value * w) / 2
                    most = float(every.wide[k, i]) if own else np.inf  # of its own window; the last stands
                    told = (float(v[k, i]) for v in (every.at_edge, every.aging, every.from_middle))
                    lengths = float(every.narrow[k, i]) - 1e-9 * abs(z) <= z <= most + 1e-9 * abs(z)
                    good = lengths and all(m >= d - 1e-9 * abs(d) for m, d in zip(told, (at_edge, aged, turned), strict=True))
                    wrong += [] if good else [f"{design} window {k}"]
    return outcome_of_cases(DESIGNS, wrong, "width and pushes of every window bound what is there")


def _places() -> Outcome:
    """Which condition refuses where one of the three pushes alone is too large: P_m in the first, P_x in the second, P_d in the
    fourth, by the drift."""
    small, wrong = Fraction(1, 5), []
    tried = {
        "P_m": (1, (small, small, Fraction(1000))),
        "P_x": (2, (Fraction(150), small, small)),
        "P_d": (3, (small, Fraction(500), small)),
    }
    for name, (place, large) in tried.items():
        if refusing_condition(pushes=large) != place:
            wrong.append(f"{name}: not refused by condition {place}")
    if refusing_condition(pushes=(small, small, small)) is not None:
        wrong.append("refused where nothing pushes much")
    return outcome_of_cases(len(tried) + 1, wrong, "P_m is in the first condition, P_x in the limit, P_d in the drift")


LEMMAS = (
    Lemma("filtered.inside", "While v + lambda x is in the filtered tube, x stays in the tube.",
          r"b_0(t) = e^{-\lambda t} b_0(0) + \int_0^t e^{-\lambda(t-s)} b(s)\,ds > 0", ("a_0(0), b_0(0) > 0", "a by symmetry"),
          "ours", _prove_inside),
    Lemma("filtered.largest", "No larger set of v + lambda x keeps x in the tube.",
          r"x = R,\ v + \lambda x > R' + \lambda R \Rightarrow \dot x > R'", ("lambda fixed", "the lower edge by symmetry"),
          "ours", _prove_largest),
    Lemma("filtered.rest", "Where no edge comes towards the state at 0, every start at rest in the tube is in the filtered one.",
          r"L'(0)\le 0\le R'(0) \Rightarrow a, b > 0", ("v = 0",), "ours", _prove_rest),
    Lemma("filtered.exit", "Whether eps of a and b rises is whether vdot is above a mean that the tube's own motion makes.",
          r"\dot\epsilon\frac{ab}{a+b} = \dot v + \frac{a(\lambda^2(R-x) - R'') + b(-L'' - \lambda^2(x-L))}{a+b}",
          ("L < x < R, a, b > 0",), "ours", _prove_exit),
    Lemma("filtered.pushed", "At the upper edge that mean is at most the larger of lambda^2 W - R'' and -L''.",
          r"\frac{a(\lambda^2(R-x) - R'') + b(-L'' - \lambda^2(x-L))}{a+b} < \max(\lambda^2 W - R'', -L'')",
          ("the lower edge by symmetry",), "ours", _prove_pushed, ("filtered.exit",)),
    Lemma("filtered.ages", "While a sample ages and u points inward, the distances change no faster than P_d.",
          r"\dot a, -\dot b \le F + \max(\lambda Z - L'', \lambda^2 W - R'')", ("the lower edge by symmetry",), "ours", _prove_ages,
          ("filtered.exit",)),
    Lemma("filtered.middle", "v + lambda x moves from the middle of its tube no faster than P_m and what u makes.",
          r"\tfrac{d}{dt}(z - \bar z) = \dot v - c'' + \lambda(v - c'),\quad |v - c'| < (Z + \lambda W)/2", (), "ours", _prove_middle),
    Lemma("filtered.evaluated", "The exact pieces are the filtered tube, and what its motion asks of u at both edges.",
          r"(L' + \lambda L, R' + \lambda R),\quad (\lambda^2 W + L'', R'' - \lambda^2 W)", ("by cases",), "the evaluated code",
          _prove_evaluated),
    Lemma("filtered.windows", "What P9 takes of a window bounds the widths and all three pushes in it and in the one before.",
          r"Z_{min}, P_x - F, P_d - F, P_m - F", ("by cases, at places",), "the evaluated code", _prove_windows),
    Lemma("filtered.sharp",
          "The sharp statement holds for order 2 with P_m in its first condition, P_d in the drift and P_x in the last.",
          r"|\epsilon_i| < E", ("as sampled.sharp",), "ours", lambda: all_of(_prove_exit(), _places()),
          ("sampled.same_side", "sampled.ends", "filtered.inside", "filtered.pushed", "filtered.ages", "filtered.middle")),
)  # fmt: skip
