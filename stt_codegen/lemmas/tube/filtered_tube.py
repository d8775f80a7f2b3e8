"""Lemmas about plants of order 2: the filtered tube, the exit inequality, the accelerations that u must balance, their bounds.

book.py takes LEMMAS as a part of the family `filtered`; the other part is inertial_inputs.py. Long because it has the formulas
and the check of the code that evaluates them.

One component: xdot = v, vdot = q = f + g u + w; a_0 = x - L, b_0 = R - x, a = (v - L') + lambda a_0, b = (R' - v) + lambda b_0.
W = R - L, Z = a + b = W' + lambda W.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
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
DESIGN_COUNT = 12  # random designs


def _prove_inside() -> Outcome:
    """Prove that b_0 stays above e^(-lambda t) b_0(0) while b > 0: b_0' = b - lambda b_0, so (e^(lambda t) b_0)' = e^(lambda t)
    b."""
    b_0_at_start = sp.Symbol("b_0(0)", positive=True)
    growth = sp.Symbol("growth", positive=True)  # the integral of e^(lambda s) b(s) from 0 to t
    return all_of(
        prove_identities(
            {
                "b_0' - (b - lambda b_0)": sp.expand(sp.diff(b0, t) - (b - lam * b0)),
                "a_0' - (a - lambda a_0)": sp.expand(sp.diff(a0, t) - (a - lam * a0)),
                "(e^(lambda t) b_0)' - e^(lambda t) b": sp.expand(sp.diff(sp.exp(lam * t) * b0, t) - sp.exp(lam * t) * b),
                "a + b - (W' + lambda W)": sp.expand(a + b - (sp.diff(R - L, t) + lam * (R - L))),
            }
        ),
        prove_positive({"e^(-lambda t) (b_0(0) + growth)": sp.exp(-lam * t) * (b_0_at_start + growth)}),
    )


def _prove_largest() -> Outcome:
    """Prove that v + lambda x > B at x = R is a velocity above R', which takes x out of the tube."""
    excess = sp.Symbol("more", positive=True)
    z = sp.diff(R, t) + lam * R + excess  # v + lambda x
    relative_velocity = (z - lam * R) - sp.diff(R, t)  # v - R' at x = R
    return all_of(
        prove_identities({"v - R' at the edge": sp.expand(relative_velocity - excess)}), prove_positive({"v - R'": excess})
    )


def _prove_exit() -> Outcome:
    """Prove the rates a' and b', and that in eps' = a'/a - b'/b the terms lambda a/a and lambda b/b cancel."""
    acceleration, lower_curvature, upper_curvature, upper_distance, lower_distance = sp.symbols("q L'' R'' R-x x-L", real=True)
    far, near = sp.symbols("a b", positive=True)
    rate_a = acceleration - lower_curvature + lam * far - lam**2 * lower_distance
    rate_b = upper_curvature - acceleration + lam * near - lam**2 * upper_distance
    tube_acceleration = (
        far * (lam**2 * upper_distance - upper_curvature) + near * (-lower_curvature - lam**2 * lower_distance)
    ) / (far + near)
    return prove_identities(
        {
            "a' as it is": sp.expand(sp.diff(a, t) - (q - sp.diff(L, t, 2) + lam * a - lam**2 * a0)),
            "b' as it is": sp.expand(sp.diff(b, t) - (sp.diff(R, t, 2) - q + lam * b - lam**2 * b0)),
            "eps' a b/(a + b) - (q + pushed)": sp.together(
                (rate_a / far - rate_b / near) * far * near / (far + near) - (acceleration + tube_acceleration)
            ),
        }
    )


def _prove_pushed() -> Outcome:
    """Prove that the mean of the exit inequality is below P, the larger of lambda^2 W - R'' and -L'', by a positive remainder."""
    far, near, lower_distance, upper_deficit, lower_deficit = sp.symbols("a b x-L s_1 s_2", positive=True)
    width, larger = sp.symbols("W P", positive=True)  # P is the larger: lambda^2 W - R'' = P - s_1, -L'' = P - s_2
    mean = (
        far * ((larger - upper_deficit) - lam**2 * lower_distance) + near * ((larger - lower_deficit) - lam**2 * lower_distance)
    ) / (far + near)
    remainder = (far * upper_deficit + near * lower_deficit) / (far + near) + lam**2 * lower_distance
    upper_difference = (
        lam**2 * (width - lower_distance)
        - (lam**2 * width - (larger - upper_deficit))
        - ((larger - upper_deficit) - lam**2 * lower_distance)
    )
    return all_of(
        prove_identities(
            {"P - the mean": sp.together(larger - mean - remainder), "lambda^2 (R - x) - R''": sp.expand(upper_difference)}
        ),
        prove_positive({"what is left": remainder}),
    )


def _prove_ages() -> Outcome:
    """Prove that a' and -b' are below P_d while g u <= 0: lambda a < lambda Z, lambda^2 (R - x) < lambda^2 W and f + w <= F."""
    drift_deficit, input_size, a_deficit, b_deficit = sp.symbols("s_F g|u| s_a s_x", nonnegative=True)
    width, z, lower_distance = sp.symbols("W Z x-L", positive=True)
    lower_curvature, upper_curvature = sp.symbols("L'' R''", real=True)
    rate_a = (F - drift_deficit) - input_size - lower_curvature + lam * (z - a_deficit) - lam**2 * lower_distance
    rate_b = upper_curvature - ((F - drift_deficit) - input_size) + lam * b_deficit - lam**2 * (width - lower_distance)
    bound_of_a, bound_of_b = F - lower_curvature + lam * z, F - upper_curvature + lam**2 * width
    return all_of(
        prove_identities(
            {
                "P_d - a'": sp.expand(
                    bound_of_a - rate_a - (drift_deficit + input_size + lam * a_deficit + lam**2 * lower_distance)
                ),
                "P_d + b'": sp.expand(
                    bound_of_b + rate_b - (drift_deficit + input_size + lam * b_deficit + lam**2 * lower_distance)
                ),
            }
        ),
        prove_positive(
            {
                "P_d - a'": drift_deficit + input_size + lam * a_deficit + lam**2 * lower_distance,
                "P_d + b'": drift_deficit + input_size + lam * b_deficit + lam**2 * lower_distance,
            }
        ),
    )


def _prove_middle() -> Outcome:
    """Prove that z moves from its middle at q - c'' + lambda (v - c'), where v - c' is a difference of two bounded distances."""
    c = (L + R) / 2
    relative_z = (v + lam * x) - (sp.diff(c, t) + lam * c)
    return prove_identities(
        {
            "(z - middle)'": sp.expand(sp.diff(relative_z, t) - (q - sp.diff(c, t, 2) + lam * (v - sp.diff(c, t)))),
            "v - c'": sp.expand((v - sp.diff(c, t)) - (relative_z - lam * (x - c))),
            "middle of the filtered tube": sp.expand(
                (sp.diff(L, t) + lam * L + sp.diff(R, t) + lam * R) / 2 - (sp.diff(c, t) + lam * c)
            ),
        }
    )


def _prove_rest() -> Outcome:
    """Prove that a = lambda a_0 - L' and b = lambda b_0 + R' at rest are positive for every x inside where L' <= 0 <= R'."""
    lower_fall, upper_rise = sp.symbols("-L' R'", nonnegative=True)
    lower_distance, upper_distance = sp.symbols("a_0 b_0", positive=True)
    return prove_positive({"a": lam * lower_distance + lower_fall, "b": lam * upper_distance + upper_rise})


def _random_design(draw: random.Random) -> RefinedDesign:
    """Return a filtered design of one or two components with random control points, at rest at the end."""
    n, segments = draw.randint(1, 2), draw.randint(4, 7)
    lower = [[draw.randint(-90, 90) for _ in range(n)] for _ in range(segments + 3)]
    widths = [[draw.randint(20, 60) for _ in range(n)] for _ in range(segments + 3)]
    table = tuple(tuple((a, a + w) for a, w in zip(*row, strict=True)) for row in zip(lower, widths, strict=True))
    table = (*table[:-2], table[-3], table[-3])
    lambdas = tuple(Fraction(draw.randint(1, 40), draw.choice((1, 3, 8))) for _ in range(n))
    return RefinedDesign(Fraction(draw.randint(1, 50), 7), segments, 6, table, filter=lambdas)


def _cubic(table: Any, k: int, i: int, side: int) -> Any:
    """Return the edge on segment k as a polynomial in s, by the B-spline's formula."""
    basis = ((1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3)
    return sp.expand(sum(int(table[k + j][i][side]) * w for j, w in enumerate(basis)))


def _prove_evaluated() -> Outcome:
    """Compare A, B and the demanded accelerations of random designs with polynomials in s by the spline's formula."""
    draw, failures = random.Random(7), []
    for _ in range(DESIGN_COUNT):
        design = _random_design(draw)
        segments_per_second = sp.Rational(design.segments) / sp.Rational(str(design.prescribed_time))
        unit = sp.Rational(str(design.unit))
        edges, accelerations = filtered_edges(design), demanded_accelerations(design)
        for k in (0, design.segments // 2, design.segments - 1):
            for i, value in enumerate(design.filter):
                lam_value = sp.Rational(str(value))
                low, high = (_cubic(design.table, k, i, side) * unit for side in (LOWER, UPPER))
                expected = [
                    (edges, side, sp.diff(e, s) * segments_per_second + lam_value * e)
                    for side, e in ((LOWER, low), (UPPER, high))
                ]
                lambda_squared_width = lam_value**2 * (high - low)
                expected += [
                    (accelerations, LOWER, lambda_squared_width + sp.diff(low, s, 2) * segments_per_second**2),
                    (accelerations, UPPER, sp.diff(high, s, 2) * segments_per_second**2 - lambda_squared_width),
                ]
                for pieces, side, polynomial in expected:
                    coefficients = [sp.Rational(str(int(c) * pieces.unit)) for c in pieces.coefficients[k, i, side]]
                    computed = sum(sp.binomial(3, j) * s**j * (1 - s) ** (3 - j) * c for j, c in enumerate(coefficients))
                    if sp.expand(computed - polynomial) != 0:
                        failures.append(f"{design} segment {k}")
    return outcome_of_cases(DESIGN_COUNT, failures, "A, B, lambda^2 W + L'' and R'' - lambda^2 W are these polynomials")


@dataclass(frozen=True)
class TubeSample:
    """One component of the tube at one time: W, Z, L'' and R''; in_window: whether the time is in the window that is checked."""

    in_window: bool
    width: float
    filtered_width: float
    lower_curvature: float
    upper_curvature: float


def _samples(design: RefinedDesign, k: int, i: int) -> Iterator[TubeSample]:
    """Yield component i at 40 times of window k and of the window before; from t_c on, where it is at rest, only at t_c."""
    segments_per_second, unit = design.segments / float(design.prescribed_time), float(design.unit)
    last = design.segments - 1
    times = np.linspace(0, 1, 40) if k < design.segments else np.ones(1)
    for segment in {min(k, last), min(max(k - 1, 0), last)}:
        cubics = [_cubic(design.table, segment, i, side) for side in (LOWER, UPPER)]
        lower, upper = (sp.lambdify(s, [cubic.diff(s, order) for order in range(3)]) for cubic in cubics)
        for time in times:
            (l0, l1, l2), (r0, r1, r2) = lower(time), upper(time)
            yield TubeSample(
                in_window=k in (segment, design.segments),
                width=(r0 - l0) * unit,
                filtered_width=((r1 - l1) * segments_per_second + float(design.filter[i]) * (r0 - l0)) * unit,
                lower_curvature=l2 * segments_per_second**2 * unit,
                upper_curvature=r2 * segments_per_second**2 * unit,
            )


def _is_bounded(motion: Any, sample: TubeSample, lam_value: float, k: int, i: int) -> bool:
    """Return whether the numbers of window k bound the sample, up to the rounding of doubles."""
    w, z = sample.width, sample.filtered_width
    bend_l, bend_r = sample.lower_curvature, sample.upper_curvature
    at_edge = max(lam_value**2 * w - bend_r, -bend_l, lam_value**2 * w + bend_l, bend_r)
    while_aging = max(lam_value * z - bend_l, lam_value**2 * w - bend_r, lam_value * z + bend_r, lam_value**2 * w + bend_l, 0)
    from_middle = abs(bend_l + bend_r) / 2 + lam_value * (z + lam_value * w) / 2
    largest_width = float(motion.wide[k, i]) if sample.in_window else np.inf
    width_holds = float(motion.narrow[k, i]) - 1e-9 * abs(z) <= z <= largest_width + 1e-9 * abs(z)
    bounds = (float(v[k, i]) for v in (motion.at_edge, motion.aging, motion.from_middle))
    pairs = zip(bounds, (at_edge, while_aging, from_middle), strict=True)
    return width_holds and all(bound >= value - 1e-9 * abs(value) for bound, value in pairs)


def _prove_windows() -> Outcome:
    """Check on random designs that the numbers of a window bound those at many times of it and of the window before."""
    draw, failures = random.Random(8), []
    for _ in range(DESIGN_COUNT):
        design = _random_design(draw)
        motion = inertial_motion(filtered_extremes(design, FRACTIONS), design.filter, FRACTIONS)
        for k, (i, lam_exact) in product(range(design.segments + 1), enumerate(design.filter)):
            for sample in _samples(design, k, i):
                if not _is_bounded(motion, sample, float(lam_exact), k, i):
                    failures.append(f"{design} window {k}")
    return outcome_of_cases(DESIGN_COUNT, failures, "width and pushes of every window bound what is there")


def _check_refusals() -> Outcome:
    """Check which condition refuses where one of three bounds alone is too large.

    It must be the first for P_m, the second for P_x, and the third for P_d, by the drift.
    """
    small_bound, failures = Fraction(1, 5), []
    cases = {
        "P_m": (1, (small_bound, small_bound, Fraction(1000))),
        "P_x": (2, (Fraction(150), small_bound, small_bound)),
        "P_d": (3, (small_bound, Fraction(500), small_bound)),
    }
    for name, (expected, bounds) in cases.items():
        if refusing_condition(pushes=bounds) != expected:
            failures.append(f"{name}: not refused by condition {expected}")
    if refusing_condition(pushes=(small_bound, small_bound, small_bound)) is not None:
        failures.append("refused where nothing pushes much")
    return outcome_of_cases(len(cases) + 1, failures, "P_m is in the first condition, P_x in the limit, P_d in the drift")


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
          r"\dot a, -\dot b \le F + \max(\lambda Z - L'', \lambda^2 W - R'')", ("the lower edge by symmetry",), "ours",
          _prove_ages, ("filtered.exit",)),
    Lemma("filtered.middle", "v + lambda x moves from the middle of its tube no faster than P_m and what u makes.",
          r"\tfrac{d}{dt}(z - \bar z) = \dot v - c'' + \lambda(v - c'),\quad |v - c'| < (Z + \lambda W)/2", (), "ours",
          _prove_middle),
    Lemma("filtered.evaluated", "The exact pieces are the filtered tube, and what its motion asks of u at both edges.",
          r"(L' + \lambda L, R' + \lambda R),\quad (\lambda^2 W + L'', R'' - \lambda^2 W)", ("by cases",), "the evaluated code",
          _prove_evaluated),
    Lemma("filtered.windows", "What P9 takes of a window bounds the widths and all three pushes in it and in the one before.",
          r"Z_{min}, P_x - F, P_d - F, P_m - F", ("by cases, at places",), "the evaluated code", _prove_windows),
    Lemma("filtered.sharp",
          "The sharp statement holds for order 2 with P_m in its first condition, P_d in the drift and P_x in the last.",
          r"|\epsilon_i| < E", ("as sampled.sharp",), "ours", lambda: all_of(_prove_exit(), _check_refusals()),
          ("sampled.same_side", "sampled.ends", "filtered.inside", "filtered.pushed", "filtered.ages", "filtered.middle")),
)  # fmt: skip
