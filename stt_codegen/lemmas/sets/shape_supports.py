"""Lemmas about shapes: supports, distances and faces of a task's sets, on symbols or, where that is not possible, on random sets.

book.py takes LEMMAS as the family `shapes`.
"""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product
from types import SimpleNamespace
from typing import Any

import sympy as sp

from stt_codegen import constraints
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities
from stt_codegen.lemmas.sets.task_constraints import EDGE, METHOD, N
from stt_codegen.properties import Property
from stt_codegen.task.sets import Hull, Polytope, Prism, RoundSet, Segment, affine_dimension, cut_box, dot, size

SET_COUNT = 60  # random sets of each kind


def _signed_normals() -> list[tuple[Any, ...]]:
    """Return normals with every pattern of signs, whose entries are symbols."""
    c = [sp.Symbol(f"c{i + 1}", positive=True) for i in range(N)]
    return [tuple(s * v for s, v in zip(signs, c, strict=True)) for signs in product((-1, 0, 1), repeat=N) if any(signs)]


def _prove_behind() -> Outcome:
    """Prove for P3 and P5 that constraints of half-spaces, after those of the box, limit the largest n.x over the tube's box to
    b."""
    h, differences = sp.Symbol("b", real=True), {}
    normals = _signed_normals()
    zero = (0,) * N
    box: Any = SimpleNamespace(lower=zero, upper=zero)
    cuts, cuts_of_target = ([(n, b) for n in normals] for b in (h, 2 * h))
    task: Any = SimpleNamespace(free_space=box, target=box, space_cuts=cuts, target_cuts=cuts_of_target)
    failures = []
    for code, members, bound in (
        (Property.STAY.code, constraints.stay_constraints(task), h),
        (Property.REACH.code, constraints.reach_constraints(task), 2 * h),
    ):
        failures += [f"{code}: {len(members)} rows"] * (len(members) != 2 * N + len(normals))
        for normal, constraint in zip(normals, members[2 * N :], strict=True):
            largest = sum(c * EDGE[i, 1 if c.is_positive else 0] for i, c in enumerate(normal) if c != 0)
            slack = sum(c * EDGE[i, side] for i, side, c in constraint.terms) - constraint.bound - constraint.clearance
            differences[f"{code} {normal}"] = sp.expand(slack - (bound - largest))
            differences[f"{code} {normal}: per"] = sp.expand(constraint.slack_per_distance - sum(map(abs, normal)))
    return all_of(
        prove_identities(differences, METHOD), outcome_of_cases(2, failures, "a row for every half-space, after those of the box")
    )


def _prove_round() -> Outcome:
    """Prove that h(n) of a ball or capsule is at least n.(p + r u) for |u| <= 1.

    The difference is r (size(n) - n.u). Integers show size(n) >= |n|_2, and Lagrange's identity |n|_2 >= n.u.
    """
    n, u = sp.symbols("n1:4", real=True), sp.symbols("u1:4", real=True)
    squares = sum((n[i] * u[j] - n[j] * u[i]) ** 2 for i in range(N) for j in range(i))
    gap = sum(v * v for v in n) * sum(v * v for v in u) - sum(v * w for v, w in zip(n, u, strict=True)) ** 2
    failures, draw = [], random.Random(5)
    normals = [
        tuple(draw.choice((draw.randint(-9, 9), draw.randint(-(10**9), 10**9))) for _ in range(N)) for _ in range(20 * SET_COUNT)
    ]
    step = Fraction(1, 1 << 32)
    for normal in normals:
        square = sum(c * c for c in normal)
        if not size(normal) ** 2 >= square or (square and not (size(normal) - step) ** 2 < square):
            failures.append(f"size{normal}")
    for _ in range(SET_COUNT):
        ends = tuple(tuple(Fraction(draw.randint(-40, 40), 8) for _ in range(N)) for _ in range(draw.randint(1, 2)))
        radius, normal = Fraction(draw.randint(1, 40), 8), normals[draw.randrange(len(normals))]
        if RoundSet(ends, radius).support(normal) != max(dot(normal, p) for p in ends) + radius * size(normal):
            failures.append(f"{ends}, {radius}: {normal}")
    return all_of(
        prove_identities({"|n|^2 |u|^2 - (n.u)^2": sp.expand(gap - squares)}, METHOD),
        outcome_of_cases(
            len(normals) + SET_COUNT, failures, "size(n) is |n|_2 rounded up by less than 2^-32; h(n) is reached at an end"
        ),
    )


def _prove_nearest() -> Outcome:
    """Compare the squared distance from a segment to a box with that of a fine grid: no point is nearer, and some are as near."""
    failures, draw = [], random.Random(6)
    for _ in range(SET_COUNT):
        ends = tuple(tuple(Fraction(draw.randint(-40, 40), 8) for _ in range(N)) for _ in range(2))
        lower = tuple(Fraction(draw.randint(-40, 40), 8) for _ in range(N))
        upper = tuple(a + Fraction(draw.randint(0, 24), 8) for a in lower)
        computed = Segment(ends).squared_distance_to(lower, upper)
        squares = []
        for k in range(129):
            point = [a + Fraction(k, 128) * (b - a) for a, b in zip(*ends, strict=True)]
            squares.append(sum(max(a - v, v - b, Fraction(0)) ** 2 for v, a, b in zip(point, lower, upper, strict=True)))
        # Every point of the segment is within half a step of a grid point, in each coordinate.
        half_step = sum(abs(b - a) for a, b in zip(*ends, strict=True)) / 256
        if computed > min(squares) or float(min(squares)) ** 0.5 > float(computed) ** 0.5 + float(half_step) + 1e-12:
            failures.append(f"{ends}, {lower}, {upper}")
    return outcome_of_cases(SET_COUNT, failures, "the least over the segment, between what a grid of 129 places allows")


def _prove_hull() -> Outcome:
    """Check on random hulls that no point is beyond a face, and that the faces cut a box to the hull of the corners."""
    failures, draw, count = [], random.Random(7), 0
    for k in range(SET_COUNT):
        n = 2 + k % 2
        points = tuple({tuple(Fraction(draw.randint(-16, 16), 8) for _ in range(n)) for _ in range(draw.randint(n + 2, 9))})
        if affine_dimension(points) < n:
            continue
        hull = Hull.of(points)
        count += 1
        has_all_points = all(dot(normal, p) <= offset for normal, offset in hull.faces for p in points)
        box = (Fraction(-3),) * n, (Fraction(3),) * n
        cut_corners = {v.point for v in cut_box(*box, hull.faces)}
        if not has_all_points or cut_corners != {v.point for v in hull.corners}:
            failures.append(f"{points}")
    return outcome_of_cases(count, failures, "the half-spaces of the faces meet in the hull of the corners")


def _prove_prism() -> Outcome:
    """Compare the support of sets in some of the dimensions, a base and intervals, with the largest n.x over their vertices."""
    failures, draw = [], random.Random(8)
    for _ in range(SET_COUNT):
        points = [tuple(Fraction(draw.randint(-16, 16), 8) for _ in range(2)) for _ in range(3)]
        axes = tuple(draw.sample(range(N), 2))
        lower = tuple(Fraction(draw.randint(-16, 0), 8) for _ in range(N))
        upper = tuple(a + Fraction(draw.randint(1, 16), 8) for a in lower)
        prism = Prism(Polytope(points), axes, lower, upper)
        for normal in product((-2, 0, 3), repeat=N):
            corners = []
            for p, ends in product(points, product(*zip(lower, upper, strict=True))):
                point = dict(zip(axes, p, strict=True))
                corners.append(tuple(point.get(i, v) for i, v in enumerate(ends)))
            if prism.support(normal) != max(dot(normal, p) for p in corners):
                failures.append(f"{points} in {axes}: {normal}")
    return outcome_of_cases(SET_COUNT * 3**N, failures, "h(n) of a prism is the greatest over its vertices")


LEMMAS = (
    Lemma(
        "shapes.behind",
        "The rows of what cuts state space or target: the tube's box lies in every half-space; the slack over |n|_1 is by how "
        "much it may grow.",
        r"\max_{x\in B} n\cdot x \le b",
        (),
        "the evaluated code",
        _prove_behind,
    ),
    Lemma(
        "shapes.round",
        "The support of a ball or capsule is never too small.",
        r"h(n) = \max_p n\cdot p + r\,\lceil|n|_2\rceil \ge n\cdot(p + r u),\ |u|_2 \le 1",
        ("size(n) by cases",),
        "the evaluated code, Lagrange's identity",
        _prove_round,
    ),
    Lemma(
        "shapes.nearest",
        "The distance between a segment and a box is the least there is.",
        r"\min_{s\in[0,1],\,y\in B} |p + s(q - p) - y|_2^2",
        ("by cases",),
        "the evaluated code",
        _prove_nearest,
    ),
    Lemma(
        "shapes.hull",
        "The faces of a hull of points, and the corners of what half-spaces leave of a box, say the same set.",
        r"\{x : n_k\cdot x \le b_k\} = \mathrm{conv}\{p_j\}",
        ("by cases",),
        "the evaluated code",
        _prove_hull,
    ),
    Lemma(
        "shapes.prism",
        "The support of a set in some of the dimensions is that of its base and of the state space in all others.",
        r"h(n) = h_C(n_a) + \sum_{i\notin a} \max(n_i \underline x_i, n_i \overline x_i)",
        ("by cases",),
        "the evaluated code",
        _prove_prism,
    ),
)
