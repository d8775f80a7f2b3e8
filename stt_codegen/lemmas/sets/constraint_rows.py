"""Rows: what makes them (`stt_codegen/constraints.py`) and what evaluates them (`certify/slack.py`), run on symbols.

A task is here no more than the numbers that a row is made of, each a symbol.

Long because it holds both what makes rows and what reads them off a tube.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import permutations, product
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen import constraints as rows
from stt_codegen.certify import slack
from stt_codegen.designs import LOWER, MINIMUM_WIDTH, UPPER
from stt_codegen.lemmas.evaluated_expression import EvaluatedExpression
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities, prove_positive
from stt_codegen.properties import Property
from stt_codegen.task.sets import BoxSet, GrownSet, minimum_over_box

METHOD = "SymPy: the evaluated code run on symbols"
N = 3
EDGE: Any = np.array([[sp.Symbol(f"{name}{i + 1}", real=True) for name in ("L", "R")] for i in range(N)], dtype=object)


def _box(name: str) -> Any:
    lower, upper = (tuple(sp.Symbol(f"{name}{word}{i + 1}", real=True) for i in range(N)) for word in ("low", "high"))
    return BoxSet(lower, upper)


def _slack(row: rows.Constraint) -> Any:
    """The left side less what it must be at least."""
    return sum(c * EDGE[i, side] for i, side, c in row.terms) - row.bound - row.clearance


def _same(what: str, made: Sequence[rows.Constraint], wanted: Sequence[Any]) -> dict[str, Any]:
    found = {f"{what}: how many rows": sp.Integer(len(made) - len(wanted))}
    return found | {f"{what} {k + 1}": sp.expand(_slack(row) - w) for k, (row, w) in enumerate(zip(made, wanted, strict=False))}


def _prove_plain() -> Outcome:
    """P1, P2, P3, P5 and P6: row by row what is asked of the edges, with a distance of its own size."""
    width = sp.Symbol("width", positive=True)
    fast, bend = (sp.symbols(f"{name}1:{N + 1}", positive=True) for name in ("fast", "bend"))
    start, space, target = (_box(name) for name in ("start", "space", "target"))
    x = tuple(sp.Symbol(f"x{i + 1}", real=True) for i in range(N))
    tube = SimpleNamespace(min_width=EvaluatedExpression(width, 0.25))
    bounds = {"max_speed": fast, "max_acceleration": bend, "space_cuts": (), "target_cuts": ()}
    task: Any = SimpleNamespace(dimension=N, tube=tube, initial_state=x, start=start, free_space=space, target=target, **bounds)
    low, high = EDGE[:, LOWER], EDGE[:, UPPER]

    def inside(box: Any) -> list[Any]:
        return [v for i in range(N) for v in (low[i] - box.lower[i], box.upper[i] - high[i])]

    wide = [rows.Constraint(r.terms, r.bound.expression) for r in rows.width_constraints(task)]  # type: ignore[attr-defined]
    speed, second = rows.speed_constraints(task), rows.acceleration_constraints(task)
    found = _same("P1 width", wide, [high[i] - low[i] - width for i in range(N)])
    found |= _same(
        "P2 x(0)", rows.initial_state_constraints(task), [v for i in range(N) for v in (x[i] - low[i], high[i] - x[i])]
    )
    found |= _same("P2 start", rows.start_constraints(task), inside(start)) | _same(
        Property.STAY.code, rows.stay_constraints(task), inside(space)
    )
    found |= _same(Property.REACH.code, rows.reach_constraints(task), inside(target))
    for what, made, most in (("P6 speed", speed, fast), ("P6 acceleration", second, bend)):
        found |= _same(what, made, [most[i] + s * e for i in range(N) for e in (low[i], high[i]) for s in (-1, 1)])
    every = {
        Property.WIDTH: wide,
        Property.START: (*rows.initial_state_constraints(task), *rows.start_constraints(task)),
        Property.STAY: rows.stay_constraints(task),
    }
    every |= {Property.REACH: rows.reach_constraints(task)}
    wrong = [
        f"{k.label}: order {r.order}, per {r.slack_per_distance}"
        for k, made in every.items()
        for r in made
        if (r.order, r.slack_per_distance) != (0, 1) or r.clearance
    ]
    wrong += [f"P6: order {r.order}" for k, made in enumerate((speed, second), 1) for r in made if r.order != k]
    task.tube, task.max_speed, task.max_acceleration = SimpleNamespace(min_width=MINIMUM_WIDTH / 2), None, None
    wrong += [f"P1: {r.bound}" for r in rows.width_constraints(task) if r.bound != MINIMUM_WIDTH]
    wrong += ["P6 without a bound"] if rows.speed_constraints(task) or rows.acceleration_constraints(task) else []
    count = sum(map(len, every.values())) + len(speed) + len(second) + N + 2
    return all_of(
        prove_identities(found, METHOD),
        outcome_of_cases(count, wrong, "edges or rates as asked, distances undivided, no width below the least"),
    )


def _normals() -> Iterator[tuple[Any, ...]]:
    """Every pattern of signs, with coefficients that are symbols."""
    c = [sp.Symbol(f"c{i + 1}", positive=True) for i in range(N)]
    for signs in product((-1, 0, 1), repeat=N):
        if any(signs):
            yield tuple(s * v for s, v in zip(signs, c, strict=True))


def _prove_apart() -> Outcome:
    """For y = L + s (R - L) in the tube's box and p with n.p <= h(n): n.(y - p) is at least the row's slack and |n|_1 clearance;
    and |n.(y - p)| <= |n|_1 max|y - p|, by component. So the slack over |n|_1 is a distance beyond the clearance."""
    found: dict[str, Any] = {}
    signs: dict[str, Any] = {}
    wrong: list[str] = []
    h, keep, z = sp.Symbol("h", real=True), sp.Symbol("clearance", positive=True), sp.symbols("z1:4", positive=True)
    share = [v / (1 + v) for v in z]  # from 0 to 1
    wide = sp.symbols("width1:4", positive=True)
    normals = list(_normals())
    for normal in normals:
        one: Any = SimpleNamespace(faces=((normal, h),))
        (row,) = rows.separation_constraints(one, keep)
        size = sum(map(abs, normal))
        low = sum(c * EDGE[i, side] for i, side, c in row.terms)
        y = [EDGE[i, LOWER] + share[i] * wide[i] for i in range(N)]
        above = low.subs({EDGE[i, UPPER]: EDGE[i, LOWER] + wide[i] for i in range(N)})
        rest = sum(c * v for c, v in zip(normal, y, strict=True)) - above
        found |= {
            f"{normal}: bound": row.bound - h,
            f"{normal}: clearance": sp.expand(row.clearance - size * keep),
            f"{normal}: per": sp.expand(row.slack_per_distance - size),
            f"{normal}: size": sp.expand(row.size - size),
        }
        parts = [abs(c) * (v if c.is_positive else 1 - v) * w for c, v, w in zip(normal, share, wide, strict=True) if c != 0]
        found[f"{normal}: n.y less low_n less its parts"] = sp.cancel(sp.together(rest - sum(parts)))
        signs[f"{normal}: n.y - low_n"] = sp.together(sum(sp.together(v) for v in parts))
    one = SimpleNamespace(faces=(((1, 0, 0), h), ((0, -2, 3), h)))
    unit, slanted = rows.separation_constraints(one, keep)
    found |= {"a normal of size 1": unit.clearance - keep, "a slanted one": slanted.clearance - 5 * keep}
    wrong += [f"needed {r.distance_error}" for r in (unit, slanted) if r.distance_error != 1]
    task: Any = SimpleNamespace(obstacles=(one, one), courses=(None, None), tube=SimpleNamespace(clearance=keep))
    one.name = "a set"
    chosen = rows.avoidances(task)
    wrong += [f"{a}" for a in chosen if (a.name, a.alternatives) != ("a set", (unit, slanted))] + ["a set is missing"] * (
        len(chosen) != 2
    )
    return all_of(
        prove_identities(found, METHOD),
        prove_positive(signs),
        outcome_of_cases(len(normals) + 4, wrong, "every pattern of signs; rows of every set"),
    )


def _prove_moved() -> Outcome:
    """A row counted from an origin o: c.(E - o) is at least its bound where c.E is at least the first one."""
    origin: Any = sp.symbols("o1:4", real=True)
    found = {}
    for terms in (((0, LOWER, 1),), ((1, UPPER, -1),), ((0, LOWER, 2), (2, UPPER, -3)), ((1, UPPER, 1), (1, LOWER, -1))):
        bound: Any = sp.Symbol("b", real=True)
        row = rows.Constraint(terms, bound)
        there = sum(c * (EDGE[i, side] - origin[i]) for i, side, c in terms) - row.bound_from(origin)
        found[str(terms)] = sp.expand(there - _slack(row))
    wrong = [
        f"{t}: {rows.Constraint(t, Fraction(0)).dimension}"
        for t, d in ((((0, 1, 1),), 0), (((2, 0, 1), (2, 1, -1)), 2), (((0, 0, 1), (1, 0, 1)), None))
        if rows.Constraint(t, Fraction(0)).dimension != d
    ]
    width, far = (
        rows.Constraint(((0, UPPER, 1), (0, LOWER, -1)), Fraction(1)),
        rows.Constraint(((0, LOWER, 2), (1, UPPER, -3)), Fraction(1), slack_per_distance=5),
    )
    wrong += [f"{r}: needs {r.distance_error}" for r, v in ((width, 2), (far, 1)) if r.distance_error != v]
    return all_of(
        prove_identities(found, METHOD),
        outcome_of_cases(5, wrong, "a row is about one dimension or several; an error counts |c|/per times"),
    )


def _prove_support() -> Outcome:
    """A box's faces and support; what a body adds; low_n of a box: each is reached at a corner, and no corner is beyond."""
    found: dict[str, Any] = {}
    wrong: list[str] = []
    draw, count = random.Random(3), 0
    for normal in _normals():
        box, half = _box("b"), tuple(sp.Symbol(f"half{i + 1}", positive=True) for i in range(N))
        wanted = sum(c * (b if c.is_positive else a) for c, a, b in zip(normal, box.lower, box.upper, strict=True) if c != 0)
        least = sum(c * (a if c.is_positive else b) for c, a, b in zip(normal, box.lower, box.upper, strict=True) if c != 0)
        grown = sum(abs(c) * h for c, h in zip(normal, half, strict=True))
        found |= {
            f"{normal}: h of a box": sp.expand(box.support(normal) - wanted),
            f"{normal}: low_n": sp.expand(minimum_over_box(normal, box.lower, box.upper) - least),
            f"{normal}: h of a grown set": sp.expand(GrownSet(box, half).support(normal) - wanted - grown),
        }
    for _ in range(20):
        lower = tuple(Fraction(draw.randint(-9, 9), 4) for _ in range(N))
        solid = BoxSet(lower, tuple(a + Fraction(draw.randint(1, 9), 4) for a in lower))
        body = tuple(Fraction(draw.randint(0, 3), 4) for _ in range(N))
        count += 1
        for normal, h in solid.faces:
            if max(sum(c * v for c, v in zip(normal, p, strict=True)) for p in solid.vertices) != h:
                wrong.append(f"{solid}: {normal}")
        larger = GrownSet(solid, body)
        for grown in (larger, solid.grown(body)):
            reached = tuple(
                (n, max(sum(c * v for c, v in zip(n, p, strict=True)) for p in grown.vertices)) for n in solid.normals
            )
            if grown.faces != reached or tuple(larger.span(i) for i in range(N)) != tuple(grown.span(i) for i in range(N)):
                wrong.append(f"{solid} grown by {body}")
        low = tuple(Fraction(draw.randint(-9, 9), 4) for _ in range(N))
        high = tuple(a + Fraction(draw.randint(0, 6), 4) for a in low)
        ends = [larger.span(i) for i in range(N)]
        gap = any(b < ends[i][0] or a > ends[i][1] for i, (a, b) in enumerate(zip(low, high, strict=True)))
        held = all(ends[i][0] <= a and b <= ends[i][1] for i, (a, b) in enumerate(zip(low, high, strict=True)))
        if (larger.is_apart_from(low, high), larger.covers(low, high)) != (gap, held):
            wrong.append(f"{solid} grown by {body} beside {low}, {high}")
    return all_of(
        prove_identities(found, METHOD),
        outcome_of_cases(count, wrong, "faces are supports, reached at a corner; grown boxes are grown sets"),
    )


# ------------------------------------------------------------------------------------------------ evaluated


def _prove_told() -> Outcome:
    """`RowBlock` on pieces whose coefficients are symbols, in every order: c.E_j - bound at the j where it is least, over per."""
    found: dict[str, Any] = {}
    one, half = Fraction(1), Fraction(1, 2)
    plain = [rows.Constraint(((0, LOWER, 1),), Fraction(3)), rows.Constraint(((1, UPPER, -1),), Fraction(-7, 2))]
    mixed = [
        *plain,
        rows.Constraint(((0, LOWER, 2), (1, UPPER, -3)), Fraction(5), Fraction(1), 5),
        rows.Constraint(((1, 1, 1), (1, 0, -1)), one),
    ]
    for count, order in enumerate(permutations(range(4))):
        numbers = np.array([[[[*order], [9 + 2.5 * v for v in order[::-1]]]] * 2], dtype=float).reshape(1, 2, 2, 4)
        numbers[0, 1] += np.array([0.25, 0.5, 1.0, 2.0])
        symbols = np.array(sp.symbols("beta0:16", real=True), dtype=object).reshape(numbers.shape)
        pieces = np.vectorize(EvaluatedExpression, otypes=[object])(symbols, numbers)
        for kind, given in (("edges", plain), ("rows", mixed)):
            told = slack.RowBlock.of(given, half).told(pieces)
            for r, row in enumerate(given):
                left = [sum(c * pieces[0, i, side, j] for i, side, c in row.terms) for j in range(4)]
                bound = -((-(row.bound + row.clearance)) // half)
                wanted = (min(left, key=float).expression - sp.Integer(int(bound))) / row.slack_per_distance
                found[f"{kind}, order {count}, row {r}"] = sp.expand(told[0, r].expression - wanted)
    return all_of(prove_identities(found, METHOD), _whole())


def _whole() -> Outcome:
    """The same on whole numbers, rounded down where divided; over all rows of a block, and over the best row of every set."""
    draw, wrong, count = random.Random(4), [], 0
    for _ in range(60):
        made = [_drawn(draw) for _ in range(draw.randint(1, 5))]
        sets = [rows.Avoidance(f"set {k}", tuple(_drawn(draw) for _ in range(draw.randint(1, 4)))) for k in range(3)]
        pieces = np.array([[[[draw.randint(-99, 99) for _ in range(4)] for _ in range(2)] for _ in range(2)] for _ in range(3)])
        block, choice = slack.RowBlock.of(made, Fraction(1, 2)), slack.RowBlock.choice(sets, Fraction(1, 2))
        by_row = [[_units(row, piece) for row in made] for piece in pieces.tolist()]
        by_set = [[[_units(row, piece) for row in one.alternatives] for one in sets] for piece in pieces.tolist()]
        least, at = block.slack(pieces)
        best, chosen = choice.slack(pieces)
        every = [row for one in sets for row in one.alternatives]
        for k in range(3):
            count += 1
            wanted = min(max(v) for v in by_set[k])
            good = least[k] == min(by_row[k]) == by_row[k][at[k]] and best[k] == wanted == _units(
                every[chosen[k]], pieces[k].tolist()
            )
            good = good and every[chosen[k]] in sets[choice.set_of(int(chosen[k]))].alternatives
            good = good and max(by_set[k][choice.set_of(int(chosen[k]))]) == wanted
            good = good and block.told_of(block.told(pieces))[k] == min(by_row[k])
            alone = slack.RowBlock.choice(sets[:1], Fraction(1, 2))
            good = good and alone.told_of(alone.told(pieces))[k] == max(by_set[k][0])
            wrong += [] if good else [f"{made}: {least[k]}, {best[k]}"]
    return outcome_of_cases(count, wrong, "whole units, rounded down; the worst row, and of the best rows of the sets the worst")


def _drawn(draw: random.Random) -> rows.Constraint:
    terms = {(draw.randint(0, 1), draw.randint(0, 1)): draw.choice((-3, -1, 1, 2)) for _ in range(draw.randint(1, 3))}
    size = sum(map(abs, terms.values()))
    keep = Fraction(draw.randint(0, 3), 3)
    return rows.Constraint(
        tuple((i, s, c) for (i, s), c in terms.items()), Fraction(draw.randint(-40, 40), 3), keep, draw.choice((1, size))
    )


def _units(row: rows.Constraint, piece: Any) -> int:
    """The slack of a row on a piece in halves of a unit, from its definition."""
    left = min(sum(c * piece[i][side][j] for i, side, c in row.terms) for j in range(4))
    return int((left + ((-(row.bound + row.clearance)) // Fraction(1, 2))) // row.slack_per_distance)


def _prove_subdivided() -> Outcome:
    """`least_slack` on drawn segments: no point of the curve has less, nothing is said to have room that has none, and room that
    all points have in plenty is found."""
    draw, wrong, count = random.Random(5), [], 0
    at = [Fraction(k, 16) for k in range(17)]
    weights = [[w * (1 - s) ** (3 - j) * s**j for j, w in enumerate((1, 3, 3, 1))] for s in at]
    for _ in range(12):
        sets = [rows.Avoidance(f"set {k}", tuple(_drawn(draw) for _ in range(3))) for k in range(2)]
        bezier = np.array([[[[draw.randint(-60, 60) for _ in range(4)] for _ in range(2)] for _ in range(2)] for _ in range(5)])
        made = [_drawn(draw) for _ in range(2)]
        for block, groups in (
            (slack.RowBlock.of(made, Fraction(1, 2)), [[r] for r in made]),
            (slack.RowBlock.choice(sets, Fraction(1, 2)), [list(s.alternatives) for s in sets]),
        ):
            points = [_least_at(groups, bezier[k], w) for k in range(5) for w in weights]
            for error in (Fraction(0), Fraction(1, 3), max(Fraction(0), min(points) - 3)):
                least = slack.least_slack(bezier, block, error)
                if least != _in_chunks(bezier, block, error):
                    wrong.append(f"{least} in one piece, another one in chunks")
                required = error * max(r.distance_error for g in groups for r in g)
                count += 1
                if least.slack >= required and least.slack > min(points):
                    wrong.append(f"{float(least.slack)} is said to be there, {float(min(points))} is")
                if required > least.slack and min(points) > required + 2 and len(groups[0]) == 1:
                    wrong.append(f"{required} is there: {float(min(points))}, and {float(least.slack)} was said")
    return outcome_of_cases(count, wrong, "what is said to be there is there at every 16th of a segment")


def _in_chunks(bezier: Any, block: slack.RowBlock, error: Fraction) -> slack.Least:
    """The same, a few rows at a time."""
    kept, slack.CHUNK = slack.CHUNK, 2 * len(block.rows)
    try:
        return slack.least_slack(bezier, block, error)
    finally:
        slack.CHUNK = kept


def _least_at(groups: Sequence[Sequence[rows.Constraint]], piece: Any, weights: Sequence[Fraction]) -> Fraction:
    """The slack at one point: of every group's best row the worst, in units."""

    def one(row: rows.Constraint) -> Fraction:
        left = sum(c * sum(w * int(v) for w, v in zip(weights, piece[i, side], strict=True)) for i, side, c in row.terms)
        return Fraction(left + ((-(row.bound + row.clearance)) // Fraction(1, 2))) / row.slack_per_distance

    return min(max(map(one, group)) for group in groups)


LEMMAS = (
    Lemma(
        "rows.plain",
        "The rows of P1, P2, P3, P5 and P6 are: least width, x(0) and the start set, state space, target, bounds on both edges' "
        "rates and accelerations.",
        r"R_i - L_i \ge w,\quad L_i \ge \underline s_i,\ R_i \le \overline s_i,\quad |\dot E_i| \le v_i,\ |\ddot E_i| \le a_i",
        (),
        "the evaluated code",
        _prove_plain,
    ),
    Lemma(
        "rows.support",
        "Supports, of boxes and of what a body makes of a set, are what n.x is at most; low_n is what it is at least on a box.",
        r"h(n) = \max_{x\in C} n\cdot x,\quad \mathrm{low}_n(B) = \min_{y\in B} n\cdot y",
        (),
        "the evaluated code",
        _prove_support,
    ),
    Lemma(
        "rows.apart",
        "Where one row of a set holds, the tube's box is farther than the clearance from the set, by the slack over |n|_1, in "
        "the largest component.",
        r"\mathrm{low}_n(B) \ge h(n) + |n|_1 c \Rightarrow \|y - p\|_\infty \ge c",
        ("y in the box, n.p <= h(n)",),
        "the evaluated code, Hoelder's inequality",
        _prove_apart,
        ("rows.support",),
    ),
    Lemma(
        "rows.moved",
        "Seen from another origin a row says the same.",
        r"c\cdot(E - o) \ge b - c\cdot o",
        (),
        "the evaluated code",
        _prove_moved,
    ),
    Lemma(
        "rows.told",
        "What the certificate reads off a piece is the least of a row's Bezier coefficients less its bound, rounded down.",
        r"\min_j \sum c\,\beta_j - \lceil b \rceil",
        ("n = 2; by row, so for every n",),
        "the evaluated code",
        _prove_told,
    ),
    Lemma(
        "rows.subdivided",
        "Halved as often as it takes, no row is said to have room that it has not.",
        r"\min_t \bigl(\text{row}(t)\bigr) \ge \text{what is said}",
        (),
        "the evaluated code",
        _prove_subdivided,
        ("refined.hull", "refined.halves", "rows.told"),
    ),
)
