"""Lemmas about constraints: how a task's are made (`stt_codegen/constraints.py`) and evaluated (`certify/slack.py`), on symbols.

A task is reduced to the numbers that its constraints consist of, each a symbol. book.py takes LEMMAS as the family `rows`.

Long because it is about the code that makes constraints and the code that evaluates them on a tube.
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

from stt_codegen import constraints
from stt_codegen.certify import slack
from stt_codegen.designs import LOWER, NARROWEST_WIDTH, UPPER
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


def _slack_of(constraint: constraints.Constraint) -> Any:
    """Return the left side less bound and clearance, of the edges as symbols."""
    return sum(c * EDGE[i, side] for i, side, c in constraint.terms) - constraint.bound - constraint.clearance


def _slack_differences(name: str, computed: Sequence[constraints.Constraint], expected: Sequence[Any]) -> dict[str, Any]:
    """Return by name the slack of each constraint less the expected one, and the difference of their counts."""
    differences = {f"{name}: how many rows": sp.Integer(len(computed) - len(expected))}
    pairs = enumerate(zip(computed, expected, strict=False), 1)
    return differences | {f"{name} {k}": sp.expand(_slack_of(constraint) - slack) for k, (constraint, slack) in pairs}


def _symbolic_task() -> Any:
    """Return a task of N components in which everything that plain constraints depend on is a symbol."""
    widths = sp.symbols(f"width1:{N + 1}", positive=True)
    speed, acceleration = (sp.symbols(f"{name}1:{N + 1}", positive=True) for name in ("fast", "bend"))
    start, space, target = (_box(name) for name in ("start", "space", "target"))
    return SimpleNamespace(
        dimension=N,
        min_widths=tuple(EvaluatedExpression(width, 0.25) for width in widths),
        initial_state=tuple(sp.Symbol(f"x{i + 1}", real=True) for i in range(N)),
        start=start,
        free_space=space,
        target=target,
        max_speed=speed,
        max_acceleration=acceleration,
        space_cuts=(),
        target_cuts=(),
    )


def _prove_plain() -> Outcome:
    """Compare the constraints of P1, P2, P3, P5 and P6 one by one with what each demands of the edges, and check their units."""
    task = _symbolic_task()
    low, high, x = EDGE[:, LOWER], EDGE[:, UPPER], task.initial_state

    def inside(box: Any) -> list[Any]:
        return [v for i in range(N) for v in (low[i] - box.lower[i], box.upper[i] - high[i])]

    def below(limits: Any) -> list[Any]:
        return [limits[i] + sign * edge for i in range(N) for edge in (low[i], high[i]) for sign in (-1, 1)]

    width = [constraints.Constraint(c.terms, c.bound.expression) for c in constraints.width_constraints(task)]  # type: ignore[attr-defined]
    initial_state, start = constraints.initial_state_constraints(task), constraints.start_constraints(task)
    stay, reach = constraints.stay_constraints(task), constraints.reach_constraints(task)
    rates = (constraints.speed_constraints(task), constraints.acceleration_constraints(task))
    differences = _slack_differences("P1 width", width, [high[i] - low[i] - task.min_widths[i].expression for i in range(N)])
    differences |= _slack_differences("P2 x(0)", initial_state, [v for i in range(N) for v in (x[i] - low[i], high[i] - x[i])])
    differences |= _slack_differences("P2 start", start, inside(task.start))
    differences |= _slack_differences(Property.STAY.code, stay, inside(task.free_space))
    differences |= _slack_differences(Property.REACH.code, reach, inside(task.target))
    differences |= _slack_differences("P6 speed", rates[0], below(task.max_speed))
    differences |= _slack_differences("P6 acceleration", rates[1], below(task.max_acceleration))
    of_edges = {Property.WIDTH: width, Property.START: (*initial_state, *start), Property.STAY: stay, Property.REACH: reach}
    failures = _unit_failures(of_edges, rates) + _default_failures(task)
    count = sum(map(len, of_edges.values())) + sum(map(len, rates)) + N + 2
    claim = "edges or rates as asked, distances undivided, no width below the least"
    return all_of(prove_identities(differences, METHOD), outcome_of_cases(count, failures, claim))


def _unit_failures(of_edges: dict[Property, Sequence[constraints.Constraint]], rates: Sequence[Any]) -> list[str]:
    """List constraints on edges that are not in their own unit without a clearance, and rates of another order."""
    failures = [
        f"{k.label}: order {c.order}, per {c.slack_per_distance}"
        for k, members in of_edges.items()
        for c in members
        if (c.order, c.slack_per_distance) != (0, 1) or c.clearance
    ]
    return failures + [f"P6: order {c.order}" for k, members in enumerate(rates, 1) for c in members if c.order != k]


def _default_failures(task: Any) -> list[str]:
    """Change the task to a smaller width than the package allows, without rates; list constraints that are not those of that."""
    task.min_widths, task.max_speed, task.max_acceleration = (NARROWEST_WIDTH / 2,) * N, None, None
    failures = [f"P1: {c.bound}" for c in constraints.width_constraints(task) if c.bound != NARROWEST_WIDTH]
    has_rates = constraints.speed_constraints(task) or constraints.acceleration_constraints(task)
    return failures + (["P6 without a bound"] if has_rates else [])


def _normals() -> Iterator[tuple[Any, ...]]:
    """Yield normals with every pattern of signs, whose coefficients are symbols."""
    c = [sp.Symbol(f"c{i + 1}", positive=True) for i in range(N)]
    for signs in product((-1, 0, 1), repeat=N):
        if any(signs):
            yield tuple(s * v for s, v in zip(signs, c, strict=True))


def _prove_apart() -> Outcome:
    """Prove that the slack of a separation constraint over |n|_1 is a distance beyond the clearance of some component.

    For y = L + s (R - L) in the tube's box and p with n.p <= h(n), n.(y - p) is at least the constraint's slack and the sum of
    |n_i| c_i, c_i the clearance of component i. Were every |y_i - p_i| below c_i + slack/|n|_1, by d_i, then n.(y - p), at most
    the sum of |n_i| |y_i - p_i|, would be less than that, by the sum of |n_i| d_i.
    """
    differences: dict[str, Any] = {}
    positive_parts: dict[str, Any] = {}
    failures: list[str] = []
    (h, surplus), z = sp.symbols("h surplus", real=True), sp.symbols("z1:4", positive=True)
    clearances, missing = (sp.symbols(f"{name}1:{N + 1}", positive=True) for name in ("clearance", "missing"))
    shares = [v / (1 + v) for v in z]  # from 0 to 1
    widths = sp.symbols("width1:4", positive=True)
    normals = list(_normals())
    for normal in normals:
        unsafe_set: Any = SimpleNamespace(faces=((normal, h),))
        (constraint,) = constraints.separation_constraints(unsafe_set, clearances)
        size, needed = sum(map(abs, normal)), sum(abs(c) * v for c, v in zip(normal, clearances, strict=True))
        nearer = [v + surplus / size - d for v, d in zip(clearances, missing, strict=True)]  # |y_i - p_i|
        shortfall = needed + surplus - sum(abs(c) * v for c, v in zip(normal, nearer, strict=True))
        smallest_product = sum(c * EDGE[i, side] for i, side, c in constraint.terms)
        point = [EDGE[i, LOWER] + shares[i] * widths[i] for i in range(N)]
        smallest_in_box = smallest_product.subs({EDGE[i, UPPER]: EDGE[i, LOWER] + widths[i] for i in range(N)})
        difference = sum(c * v for c, v in zip(normal, point, strict=True)) - smallest_in_box
        differences |= {
            f"{normal}: bound": constraint.bound - h,
            f"{normal}: clearance": sp.expand(constraint.clearance - needed),
            f"{normal}: shortfall": sp.simplify(shortfall - sum(abs(c) * d for c, d in zip(normal, missing, strict=True))),
            f"{normal}: per": sp.expand(constraint.slack_per_distance - size),
            f"{normal}: size": sp.expand(constraint.size - size),
        }
        positive_terms = [
            abs(c) * (v if c.is_positive else 1 - v) * w for c, v, w in zip(normal, shares, widths, strict=True) if c != 0
        ]
        differences[f"{normal}: n.y less low_n less its parts"] = sp.cancel(sp.together(difference - sum(positive_terms)))
        positive_parts[f"{normal}: n.y - low_n"] = sp.together(sum(sp.together(v) for v in positive_terms))
    unsafe_set = SimpleNamespace(faces=(((1, 0, 0), h), ((0, -2, 3), h)))
    unit, slanted = constraints.separation_constraints(unsafe_set, clearances)
    of_slanted = 2 * clearances[1] + 3 * clearances[2]
    differences |= {"a normal of size 1": unit.clearance - clearances[0], "a slanted one": slanted.clearance - of_slanted}
    failures += [f"needed {r.distance_error}" for r in (unit, slanted) if r.distance_error != 1]
    task: Any = SimpleNamespace(obstacles=(unsafe_set, unsafe_set), courses=(None, None), clearances=clearances)
    unsafe_set.name = "a set"
    avoidances = constraints.avoidances(task)
    failures += [f"{a}" for a in avoidances if (a.name, a.alternatives) != ("a set", (unit, slanted))] + ["a set is missing"] * (
        len(avoidances) != 2
    )
    return all_of(
        prove_identities(differences, METHOD),
        prove_positive(positive_parts),
        outcome_of_cases(len(normals) + 4, failures, "every pattern of signs; rows of every set"),
    )


def _prove_moved() -> Outcome:
    """Prove that a constraint moved to an origin o has the same slack; check dimensions and how errors count."""
    origin: Any = sp.symbols("o1:4", real=True)
    differences = {}
    for terms in (((0, LOWER, 1),), ((1, UPPER, -1),), ((0, LOWER, 2), (2, UPPER, -3)), ((1, UPPER, 1), (1, LOWER, -1))):
        bound: Any = sp.Symbol("b", real=True)
        constraint = constraints.Constraint(terms, bound)
        slack_from_origin = sum(c * (EDGE[i, side] - origin[i]) for i, side, c in terms) - constraint.bound_from(origin)
        differences[str(terms)] = sp.expand(slack_from_origin - _slack_of(constraint))
    failures = [
        f"{t}: {constraints.Constraint(t, Fraction(0)).dimension}"
        for t, d in ((((0, 1, 1),), 0), (((2, 0, 1), (2, 1, -1)), 2), (((0, 0, 1), (1, 0, 1)), None))
        if constraints.Constraint(t, Fraction(0)).dimension != d
    ]
    width_constraint, slanted_constraint = (
        constraints.Constraint(((0, UPPER, 1), (0, LOWER, -1)), Fraction(1)),
        constraints.Constraint(((0, LOWER, 2), (1, UPPER, -3)), Fraction(1), slack_per_distance=5),
    )
    failures += [
        f"{r}: needs {r.distance_error}" for r, v in ((width_constraint, 2), (slanted_constraint, 1)) if r.distance_error != v
    ]
    return all_of(
        prove_identities(differences, METHOD),
        outcome_of_cases(5, failures, "a row is about one dimension or several; an error counts |c|/per times"),
    )


def _prove_support() -> Outcome:
    """Compare faces, supports, grown supports and minima over boxes with formulas, then with corners of random boxes."""
    differences: dict[str, Any] = {}
    failures: list[str] = []
    draw, count = random.Random(3), 0
    for normal in _normals():
        box, half_sizes = _box("b"), tuple(sp.Symbol(f"half{i + 1}", positive=True) for i in range(N))
        largest = sum(c * (b if c.is_positive else a) for c, a, b in zip(normal, box.lower, box.upper, strict=True) if c != 0)
        smallest = sum(c * (a if c.is_positive else b) for c, a, b in zip(normal, box.lower, box.upper, strict=True) if c != 0)
        grown = sum(abs(c) * h for c, h in zip(normal, half_sizes, strict=True))
        differences |= {
            f"{normal}: h of a box": sp.expand(box.support(normal) - largest),
            f"{normal}: low_n": sp.expand(minimum_over_box(normal, box.lower, box.upper) - smallest),
            f"{normal}: h of a grown set": sp.expand(GrownSet(box, half_sizes).support(normal) - largest - grown),
        }
    for _ in range(20):
        lower = tuple(Fraction(draw.randint(-9, 9), 4) for _ in range(N))
        random_box = BoxSet(lower, tuple(a + Fraction(draw.randint(1, 9), 4) for a in lower))
        body = tuple(Fraction(draw.randint(0, 3), 4) for _ in range(N))
        count += 1
        for normal, h in random_box.faces:
            if max(sum(c * v for c, v in zip(normal, p, strict=True)) for p in random_box.vertices) != h:
                failures.append(f"{random_box}: {normal}")
        larger = GrownSet(random_box, body)
        for grown in (larger, random_box.grown(body)):
            faces = tuple(
                (n, max(sum(c * v for c, v in zip(n, p, strict=True)) for p in grown.vertices)) for n in random_box.normals
            )
            if grown.faces != faces or tuple(larger.span(i) for i in range(N)) != tuple(grown.span(i) for i in range(N)):
                failures.append(f"{random_box} grown by {body}")
        low = tuple(Fraction(draw.randint(-9, 9), 4) for _ in range(N))
        high = tuple(a + Fraction(draw.randint(0, 6), 4) for a in low)
        spans = [larger.span(i) for i in range(N)]
        is_apart = any(b < spans[i][0] or a > spans[i][1] for i, (a, b) in enumerate(zip(low, high, strict=True)))
        is_covered = all(spans[i][0] <= a and b <= spans[i][1] for i, (a, b) in enumerate(zip(low, high, strict=True)))
        if (larger.is_apart_from(low, high), larger.covers(low, high)) != (is_apart, is_covered):
            failures.append(f"{random_box} grown by {body} beside {low}, {high}")
    return all_of(
        prove_identities(differences, METHOD),
        outcome_of_cases(count, failures, "faces are supports, reached at a corner; grown boxes are grown sets"),
    )


# ------------------------------------------------------------------------------------------------ evaluation on a tube


def _prove_smallest_coefficient() -> Outcome:
    """Run `ConstraintBlock` on pieces whose coefficients are symbols, in every order: it must take the smallest c.E_j - bound."""
    differences: dict[str, Any] = {}
    unit, half_unit = Fraction(1), Fraction(1, 2)
    edge_constraints = [
        constraints.Constraint(((0, LOWER, 1),), Fraction(3)),
        constraints.Constraint(((1, UPPER, -1),), Fraction(-7, 2)),
    ]
    all_constraints = [
        *edge_constraints,
        constraints.Constraint(((0, LOWER, 2), (1, UPPER, -3)), Fraction(5), Fraction(1), 5),
        constraints.Constraint(((1, 1, 1), (1, 0, -1)), unit),
    ]
    for count, order in enumerate(permutations(range(4))):
        numbers = np.array([[[[*order], [9 + 2.5 * v for v in order[::-1]]]] * 2], dtype=float).reshape(1, 2, 2, 4)
        numbers[0, 1] += np.array([0.25, 0.5, 1.0, 2.0])
        symbols = np.array(sp.symbols("beta0:16", real=True), dtype=object).reshape(numbers.shape)
        pieces = np.vectorize(EvaluatedExpression, otypes=[object])(symbols, numbers)
        for kind, members in (("edges", edge_constraints), ("rows", all_constraints)):
            slacks = slack.ConstraintBlock.of(members, half_unit).slack_by_constraint(pieces)
            for r, constraint in enumerate(members):
                products = [sum(c * pieces[0, i, side, j] for i, side, c in constraint.terms) for j in range(4)]
                bound = -((-(constraint.bound + constraint.clearance)) // half_unit)
                expected = (min(products, key=float).expression - sp.Integer(int(bound))) / constraint.slack_per_distance
                differences[f"{kind}, order {count}, row {r}"] = sp.expand(slacks[0, r].expression - expected)
    return all_of(prove_identities(differences, METHOD), _check_on_integers())


def _check_on_integers() -> Outcome:
    """Check on integers the smallest slack of a block, rounded down, and that of the best constraint of every set."""
    draw, failures, count = random.Random(4), [], 0
    for _ in range(60):
        members = [_random_constraint(draw) for _ in range(draw.randint(1, 5))]
        sets = [
            constraints.Avoidance(f"set {k}", tuple(_random_constraint(draw) for _ in range(draw.randint(1, 4))))
            for k in range(3)
        ]
        pieces = np.array([[[[draw.randint(-99, 99) for _ in range(4)] for _ in range(2)] for _ in range(2)] for _ in range(3)])
        block, choice = slack.ConstraintBlock.of(members, Fraction(1, 2)), slack.ConstraintBlock.choice(sets, Fraction(1, 2))
        slacks = [[_slack_in_halves(constraint, piece) for constraint in members] for piece in pieces.tolist()]
        slacks_by_set = [
            [[_slack_in_halves(constraint, piece) for constraint in avoidance.alternatives] for avoidance in sets]
            for piece in pieces.tolist()
        ]
        smallest, smallest_index = block.slack(pieces)
        smallest_of_best, best_index = choice.slack(pieces)
        alternatives = [constraint for avoidance in sets for constraint in avoidance.alternatives]
        for k in range(3):
            count += 1
            expected = min(max(v) for v in slacks_by_set[k])
            is_right = smallest[k] == min(slacks[k]) == slacks[k][smallest_index[k]] and smallest_of_best[
                k
            ] == expected == _slack_in_halves(alternatives[best_index[k]], pieces[k].tolist())
            is_right = is_right and alternatives[best_index[k]] in sets[choice.set_of(int(best_index[k]))].alternatives
            is_right = is_right and max(slacks_by_set[k][choice.set_of(int(best_index[k]))]) == expected
            is_right = is_right and block.slack_of_block(block.slack_by_constraint(pieces))[k] == min(slacks[k])
            first_set = slack.ConstraintBlock.choice(sets[:1], Fraction(1, 2))
            is_right = is_right and first_set.slack_of_block(first_set.slack_by_constraint(pieces))[k] == max(slacks_by_set[k][0])
            failures += [] if is_right else [f"{members}: {smallest[k]}, {smallest_of_best[k]}"]
    return outcome_of_cases(
        count, failures, "whole units, rounded down; the worst row, and of the best rows of the sets the worst"
    )


def _random_constraint(draw: random.Random) -> constraints.Constraint:
    terms = {(draw.randint(0, 1), draw.randint(0, 1)): draw.choice((-3, -1, 1, 2)) for _ in range(draw.randint(1, 3))}
    size = sum(map(abs, terms.values()))
    clearance = Fraction(draw.randint(0, 3), 3)
    return constraints.Constraint(
        tuple((i, s, c) for (i, s), c in terms.items()), Fraction(draw.randint(-40, 40), 3), clearance, draw.choice((1, size))
    )


def _slack_in_halves(constraint: constraints.Constraint, piece: Any) -> int:
    """Return the slack of a constraint on a piece in halves of a unit, from its definition."""
    product = min(sum(c * piece[i][side][j] for i, side, c in constraint.terms) for j in range(4))
    return int((product + ((-(constraint.bound + constraint.clearance)) // Fraction(1, 2))) // constraint.slack_per_distance)


def _prove_subdivided() -> Outcome:
    """Compare `smallest_slack` on random segments with the slack at many points of the curve.

    No point may have less than the result, no slack may be claimed that is not there, and a slack that all points have by 2
    units more than required must be claimed.
    """
    draw, failures, count = random.Random(5), [], 0
    times = [Fraction(k, 16) for k in range(17)]
    weights = [[w * (1 - s) ** (3 - j) * s**j for j, w in enumerate((1, 3, 3, 1))] for s in times]
    for _ in range(12):
        sets = [constraints.Avoidance(f"set {k}", tuple(_random_constraint(draw) for _ in range(3))) for k in range(2)]
        bezier = np.array([[[[draw.randint(-60, 60) for _ in range(4)] for _ in range(2)] for _ in range(2)] for _ in range(5)])
        members = [_random_constraint(draw) for _ in range(2)]
        for block, groups in (
            (slack.ConstraintBlock.of(members, Fraction(1, 2)), [[r] for r in members]),
            (slack.ConstraintBlock.choice(sets, Fraction(1, 2)), [list(s.alternatives) for s in sets]),
        ):
            slacks = [_slack_at_point(groups, bezier[k], w) for k in range(5) for w in weights]
            for error in (Fraction(0), Fraction(1, 3), max(Fraction(0), min(slacks) - 3)):
                computed = slack.smallest_slack(bezier, block, error)
                if computed != _slack_in_chunks(bezier, block, error):
                    failures.append(f"{computed} in one piece, another one in chunks")
                required = error * max(r.distance_error for g in groups for r in g)
                count += 1
                if computed.slack >= required and computed.slack > min(slacks):
                    failures.append(f"{float(computed.slack)} is said to be there, {float(min(slacks))} is")
                if required > computed.slack and min(slacks) > required + 2 and len(groups[0]) == 1:
                    failures.append(f"{required} is there: {float(min(slacks))}, and {float(computed.slack)} was said")
    return outcome_of_cases(count, failures, "what is said to be there is there at every 16th of a segment")


def _slack_in_chunks(bezier: Any, block: slack.ConstraintBlock, error: Fraction) -> slack.LocatedSlack:
    """Return `smallest_slack` computed a few constraints at a time."""
    chunk, slack.BATCH_SIZE = slack.BATCH_SIZE, 2 * len(block.constraints)
    try:
        return slack.smallest_slack(bezier, block, error)
    finally:
        slack.BATCH_SIZE = chunk


def _slack_at_point(groups: Sequence[Sequence[constraints.Constraint]], piece: Any, weights: Sequence[Fraction]) -> Fraction:
    """Return the slack at one point in units: the worst over the groups of the best constraint in each."""

    def slack_at_point(constraint: constraints.Constraint) -> Fraction:
        product = sum(
            c * sum(w * int(v) for w, v in zip(weights, piece[i, side], strict=True)) for i, side, c in constraint.terms
        )
        return (
            Fraction(product + ((-(constraint.bound + constraint.clearance)) // Fraction(1, 2))) / constraint.slack_per_distance
        )

    return min(max(map(slack_at_point, group)) for group in groups)


LEMMAS = (
    Lemma(
        "rows.plain",
        "The rows of P1, P2, P3, P5 and P6 are: least width, x(0) and the start set, state space, target, bounds on both edges' "
        "rates and accelerations.",
        r"R_i - L_i \ge w_i,\quad L_i \ge \underline s_i,\ R_i \le \overline s_i,\quad |\dot E_i| \le v_i,\ |\ddot E_i| \le a_i",
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
        "Where one row of a set holds, the tube's box is farther from the set than the clearance of some component, in that "
        "component, by the slack over |n|_1.",
        r"\mathrm{low}_n(B) \ge h(n) + \sum |n_i| c_i \Rightarrow \exists i: |y_i - p_i| \ge c_i",
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
        _prove_smallest_coefficient,
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
