"""Lemmas about conflict windows (5), the dimension (6) and the side: where the printed rules fail, and what holds instead.

Counterexamples are exact data of small arenas. book.py takes LEMMAS as the family `windows`; docs/paper.md describes the repairs.
Long because it is one family of the book.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations_with_replacement, product
from types import FunctionType, SimpleNamespace
from typing import Any

import sympy as sp
from flint import arb, fmpq
from sympy.logic.inference import satisfiable

from stt_codegen.design.paper_tubes import OVERSHOOT
from stt_codegen.design.paper_tubes import conflict_windows as shipped
from stt_codegen.designs import Edge
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict, all_of, prove_identities, refute_by_counterexample

Box = tuple[Edge, ...]


def _box(*sides: str) -> Box:
    return tuple((Fraction(a), Fraction(b)) for a, b in (side.split() for side in sides))


# The paper's case study, then small arenas for one counterexample each. A string is one side of a box.
STATE_SPACE, TARGET = _box("0 5", "0 5"), _box("4.5 5", "4.5 5")
STARTS = {"S1": _box("0 0.5", "4.5 5"), "S2": _box("0 0.5", "0 0.5"), "S3": _box("4 4.5", "0 0.5")}
UNSAFE = {"O1": _box("1 2", "4 5"), "O2": _box("2 3", "2.5 3.5"), "O3": _box("1 2", "0.5 1.5"), "O4": _box("4 5", "1.5 2.5")}
WIDENING = _box("2 3", "0 5"), _box("4 4.5", "3.2 3.5")  # X0 and T of one dimension; two choices of U
WALL = _box("0 10", "0.1 1.5")  # X and U of one dimension
SQUEEZE = _box("4 6", "3 5"), _box("4 6", "5.2 7")  # A is pushed up, B down
DETOUR = _box("0 1", "4.5 5.5"), _box("9 10", "4.5 5.5"), _box("4 6", "4 6"), _box("4 6", "6.1 8")  # X0, T, A, C

CROSSINGS = [sp.Rational(v) for v in "-2 -1 0 1/3 2/3 1 2 3".split()]  # sigma: two of them, in every order with 0 and 1
SIGMA_GRID = [sp.Rational(k, 6) for k in range(7)]  # the crossings in [0, 1], and a point between any two


def _outcome_of_cases(method: str, claim: str, case_count: int, failures: Sequence[object]) -> Outcome:
    verdict = Verdict.PROVED if case_count and not failures else Verdict.OPEN
    return Outcome(verdict, method, (f"{claim}: {case_count} cases, {len(failures)} wrong", *map(str, failures[:3])))


def _text(*sides: Edge) -> str:
    return " x ".join(f"[{float(a):.4g}, {float(b):.4g}]" if a <= b else "none" for a, b in sides)


def _exact_time_of_sigma(sigma: Any, t_c: Any) -> Any:
    """Run the code of the shipped `time_of_sigma` on SymPy expressions, so without rounding."""
    function: Any = shipped.time_of_sigma
    exact = {"math": SimpleNamespace(atanh=sp.atanh), "float": sp.sympify}
    return FunctionType(function.__code__, {**function.__globals__, **exact})(sigma, t_c)


def _prove_inverse() -> Outcome:
    """Prove that the shipped time of sigma is the inverse of the profile, both ways.

    sigma = 1 - exp(-x) with x > 0 is every number between 0 and 1. atanh(tanh x) is x, since the difference is 0 at 0 and has
    no slope.
    """
    t, t_c, x = sp.symbols("t t_c x", positive=True)
    sigma = 1 - sp.exp(-x)
    time, a = _exact_time_of_sigma(sigma, t_c), sp.atanh(sigma)
    differences = {
        "t/(t_c - t) - a at the shipped t": time / (t_c - time) - a,
        "tanh a - sigma": sp.tanh(a) - sigma,
        "shipped t at a = t/(t_c - t), less t": time.subs(a, x).subs(x, t / (t_c - t)) - t,
        "slope of atanh(tanh x) - x": sp.diff(sp.atanh(sp.tanh(x)) - x, x),
        "shipped t at sigma = 0": _exact_time_of_sigma(sp.Integer(0), t_c),
        "shipped t at sigma = 1, less t_c": _exact_time_of_sigma(sp.Integer(1), t_c) - t_c,
    }
    return prove_identities(differences, "SymPy: the shipped function's code run on formulas; the difference of both sides is 0")


def _atanh_arguments(start: Edge, target: Edge, unsafe: Edge) -> list[Fraction | None]:
    """Return the argument of atanh in each of the four terms of (5); None for a division by 0."""
    return [(u - x) / (end - x) if end != x else None for x, end in zip(start, target, strict=True) for u in unsafe]


def _refute_printed_defined() -> Outcome:
    """Count the terms of (5) in the case study whose argument of atanh is no number between -1 and 1."""
    sides = [(s[i], TARGET[i], u[i]) for s in STARTS.values() for u in UNSAFE.values() for i in range(len(TARGET))]
    terms = [argument for side in sides for argument in _atanh_arguments(*side)]
    sizes = [abs(v) for v in terms if v is not None]
    division_count, infinite_count, undefined_count = terms.count(None), sum(v == 1 for v in sizes), sum(v > 1 for v in sizes)
    failure_count = division_count + infinite_count + undefined_count
    evidence = f"{failure_count} of {len(terms)} are not: {division_count} divide by 0, {infinite_count} are atanh of 1 or -1, "
    evidence += f"{undefined_count} of what lies beyond"
    return refute_by_counterexample(
        "every term of (5) is a number", "the case study, X0hat = X0, That = T", failure_count > 0, evidence
    )


def _symbolic_edges(names: str) -> list[tuple[Any, Any, Any]]:
    """Return (start, end, bound) of edges that cross the bound at each of CROSSINGS, or stay below, at or above it."""
    start, size = sp.Symbol(names[0], real=True), sp.Symbol(names[1], positive=True)
    sloped = [(start, start + slope, start + slope * crossing) for slope in (size, -size) for crossing in CROSSINGS]
    return sloped + [(start, start, start + k * size) for k in (-1, 0, 1)]


def _prove_interval() -> Outcome:
    """Compare the shipped interval with the two inequalities, on SIGMA_GRID, for every order of the crossings.

    Start and slope of both edges are symbols. So the function can only compare crossings with 0, with 1 and with each other.
    """
    upper = [(e, {s for s in SIGMA_GRID if e[0] + (e[1] - e[0]) * s - e[2] >= 0}) for e in _symbolic_edges("mh")]
    lower = [(e, {s for s in SIGMA_GRID if e[0] + (e[1] - e[0]) * s - e[2] <= 0}) for e in _symbolic_edges("lk")]
    failures = []
    for (u, above), (v, below) in product(upper, lower):
        edges: Any = (v[0], u[0]), (v[1], u[1]), (u[2], v[2])
        interval = shipped.conflict_in_sigma(*edges)
        inside = set() if interval is None else {s for s in SIGMA_GRID if interval[0] <= s <= interval[1]}
        if inside != above & below or not all(any(end == p for p in CROSSINGS) for end in interval or ()):
            failures.append(edges)
    sigma, s, e, c = sp.symbols("sigma X0 T c", real=True)
    affine = s + (e - s) * sigma - (s + (e - s) * c) - (e - s) * (sigma - c)
    method = "the shipped function by cases: start and slope as symbols, a pair of crossings for each order among them, 0 and 1"
    claim = "its answer and the two inequalities agree at 0, 1, every crossing and between them"
    return all_of(
        prove_identities({"rho - rho(c) - (T - X0)(sigma - c), so rho passes a bound once": affine}),
        _outcome_of_cases(method, claim, len(upper) * len(lower), failures),
    )


def _refute_printed_order() -> Outcome:
    """Compute when (5) closes for two sets that are still in the way at the end, where the conflict in truth lasts to t_c."""
    (start, target), evidence, fails = WIDENING[0], [], []
    for unsafe in WIDENING[1]:
        arguments = [v for v in _atanh_arguments(start, target, unsafe) if v is not None and abs(v) < 1]
        a = [arb(fmpq(v.numerator, v.denominator)).atanh() for v in arguments]
        terms, (window,) = [v / (1 + v) for v in a], _windows((start,), (target,), (unsafe,))
        fails.append(bool(max(terms) < 1) and window[1] == 1 and not _are_apart(target, unsafe))
        printed_window = " to ".join(f"{end.str(4, radius=False)} t_c" for end in (min(terms), max(terms)))
        printed_window += f" by the {len(a)} terms of 4 that are numbers"
        evidence.append(f"U = {_text(unsafe)}: {printed_window}, in truth sigma in {_text(window)}")
    at = f"X0 = {_text(start)}, T = {_text(target)}"
    return refute_by_counterexample("(5) closes when the conflict ends", at, all(fails), "; ".join(evidence))


def _are_apart(a: Edge, b: Edge) -> bool:
    return a[1] < b[0] or a[0] > b[1]


def _refute_one_dimension() -> Outcome:
    """List for each dimension the sets whose side includes that of T; where there is one, no That within T is apart from it."""
    blocking_sets = [
        [o for o, u in UNSAFE.items() if u[i][0] <= TARGET[i][0] and TARGET[i][1] <= u[i][1]] for i in range(len(TARGET))
    ]
    evidence = ", ".join(f"x{i + 1} of T within that of {' and '.join(sets) or 'none'}" for i, sets in enumerate(blocking_sets))
    return refute_by_counterexample(
        "T is apart from all sets in one dimension", "the case study, any That within T", all(blocking_sets), evidence
    )


def _prove_disjoint() -> Outcome:
    """Check every order of four ends: closed intervals that share a point share an end of one of them."""
    pairs = list(product(combinations_with_replacement(map(Fraction, range(4)), 2), repeat=2))
    failures = [(p, q) for p, q in pairs if _are_apart(p, q) == any(max(p[0], q[0]) <= x <= min(p[1], q[1]) for x in (*p, *q))]
    claim = "two intervals share no point exactly if one is below the other"
    return all_of(_outcome_of_cases("every order of four ends", claim, len(pairs), failures), *map(_check_separation, (2, 3, 4)))


def _check_separation(n: int) -> Outcome:
    """Check by SymPy's solver of propositions when boxes of n dimensions are disjoint, from `below` and `above` by dimension."""
    below, above = sp.symbols(f"below1:{n + 1}"), sp.symbols(f"above1:{n + 1}")
    overlap = [~(b | a) for b, a in zip(below, above, strict=True)]
    boxes_meet = sp.And(*overlap)
    claims = [sp.Equivalent(~boxes_meet, sp.Or(*below, *above))]
    for i in range(n):
        others_overlap = sp.And(*overlap[:i], *overlap[i + 1 :])
        claims += [sp.Implies(others_overlap >> side, ~boxes_meet) for side in (below[i], above[i])]
    failures = [claim for claim in claims if satisfiable(~claim) is not False]
    claim = f"n = {n}: disjoint exactly if apart somewhere; disjoint if any one dimension is on one side where all others overlap"
    return _outcome_of_cases("SymPy: propositions, nothing satisfies their negation", claim, len(claims), failures)


def _windows(start: Box, target: Box, unsafe: Box) -> list[Edge]:
    """Return the window in sigma of each dimension, (1, 0) where there is none."""
    windows = (shipped.conflict_in_sigma(*sides) for sides in zip(start, target, unsafe, strict=True))
    return [window or (Fraction(1), Fraction(0)) for window in windows]


def _common_part(windows: Sequence[Edge]) -> Edge:
    return max(a for a, _ in windows), min(b for _, b in windows)


def _possible_sides(i: int, start: Box, target: Box, unsafe: Box) -> list[str]:
    """Return the sides of the set, "above" and "below", on which dimension i can be during H.

    H is the interval of sigma in which all other dimensions overlap. A side is excluded by the start set if H includes 0, and
    by the target if H includes sigma = 1.
    """
    windows = _windows(start, target, unsafe)
    first, last = _common_part(windows[:i] + windows[i + 1 :])
    required = [start[i]] * (first == 0) + [target[i]] * (last == 1) if first <= last else []
    above, below = all(e[0] > unsafe[i][1] for e in required), all(e[1] < unsafe[i][0] for e in required)
    return ["above"] * above + ["below"] * below


def _prove_admissible() -> Outcome:
    """List for every set that the reach tube meets the sides on which a dimension can stay, more than dB away from the walls."""
    lines, failures = [], []
    for (s, start), (o, unsafe) in product(STARTS.items(), UNSAFE.items()):
        first, last = _common_part(_windows(start, TARGET, unsafe))
        if first > last:
            continue
        wall_distances = [
            {"above": wall[1] - side[1], "below": side[0] - wall[0]} for wall, side in zip(STATE_SPACE, unsafe, strict=True)
        ]
        choices = [
            (i, side)
            for i in range(len(STATE_SPACE))
            for side in _possible_sides(i, start, TARGET, unsafe)
            if wall_distances[i][side] > OVERSHOOT
        ]
        lines.append(f"{s} with {o}: {' or '.join(f'x{i + 1} {side}' for i, side in choices) or 'none'}")
        failures += [] if choices else [(s, o)]
    return _outcome_of_cases("exact, by cases", "; ".join(lines), len(lines), failures)


def _refute_shortest() -> Outcome:
    """Show two sets for which (6) picks a dimension that has to cross the set.

    One window is within the other, so it is shorter.
    """
    lines, fails = [], []
    for s, o in (("S1", "O1"), ("S3", "O4")):
        windows = _windows(STARTS[s], TARGET, UNSAFE[o])
        i = windows.index(_common_part(windows))
        fails.append(not _possible_sides(i, STARTS[s], TARGET, UNSAFE[o]))
        path = f"from {_text(STARTS[s][i])} to {_text(TARGET[i])}, through {_text(UNSAFE[o][i])} by continuity"
        lines.append(f"{s} with {o}: sigma in {_text(windows[0])} and {_text(windows[1])}; x{i + 1} is picked and goes {path}")
    at = "the case study, X0hat = X0, That = T"
    return refute_by_counterexample("the dimension that (6) picks can be held", at, all(fails), "; ".join(lines))


def _refute_from_rho() -> Outcome:
    """Show a set C that rho does not meet but the tube does: while the tube goes around A its lower edge is beta_L, not rho_L."""
    start, target, a, c = DETOUR
    window_of_a, windows_of_c, beta_L = _common_part(_windows(start, target, a)), _windows(start, target, c), a[1][1] + OVERSHOOT
    rho_meets_c = _common_part(windows_of_c)[0] <= _common_part(windows_of_c)[1]
    beta_enters_c = windows_of_c[0][0] <= window_of_a[0] <= window_of_a[1] <= windows_of_c[0][1] and c[1][0] <= beta_L <= c[1][1]
    passes_above = "above" in _possible_sides(1, start, target, a) and beta_L > max(start[1][0], target[1][0])
    evidence = f"rho overlaps A for sigma in {_text(window_of_a)}; C in x1 for {_text(windows_of_c[0])}, "
    evidence += f"in x2 for {_text(windows_of_c[1])}"
    evidence += f"; with x2 above A, beta_L = {float(beta_L):g} is within C's {_text(c[1])} meanwhile"
    arena = f"A = {_text(*a)}, C = {_text(*c)}, dB = {float(OVERSHOOT):g}"
    return refute_by_counterexample(
        "a tube that stays clear of the sets that rho meets stays clear of all",
        arena,
        passes_above and beta_enters_c and not rho_meets_c,
        evidence,
    )


def _prove_room() -> Outcome:
    """Prove for both walls that a set at least dB + w_min away leaves a width of w_min between beta and the wall."""
    wall, overshoot, width = sp.Symbol("wall", real=True), sp.Symbol("dB", positive=True), sp.Symbol("w_min", positive=True)
    margin, beyond = sp.symbols("spare beyond", nonnegative=True)
    differences = {}
    for name, sign in (("(8), beta_U below U", 1), ("(7), beta_L above U", -1)):
        edge = wall + sign * (overshoot + width + margin)
        far = edge + sign * beyond
        beta = far - sign * (sign * (far - edge) + overshoot)  # with the height B of (7) and (8)
        differences[f"{name}: from wall to edge, less w_min + spare"] = sign * (beta - wall) - (width + margin)
        differences[f"{name}: from edge to the other wall, less dB + beyond"] = sign * (far - beta) - (overshoot + beyond)
    return prove_identities(differences)


def _refute_printed_wall() -> Outcome:
    """Compute beta_U below a set that is nearer to the wall than dB: it is outside of the state space."""
    (wall, _), (edge, _) = WALL
    arena = f"X = {_text(WALL[0])}, U = {_text(WALL[1])}, dB = {float(OVERSHOOT):g}"
    fails, evidence = wall < edge < wall + OVERSHOOT, f"beta_U = {float(edge - OVERSHOOT):g}"
    return refute_by_counterexample("below a set that does not touch the wall, beta_U is within X", arena, fails, evidence)


def _refute_random_side() -> Outcome:
    """Show two sets with the same window, the lower one passed above and the upper one below, which leaves no tube."""
    (a, b), arena = SQUEEZE, f"A = {_text(*SQUEEZE[0])} pushing up, B = {_text(*SQUEEZE[1])} down, dB = {float(OVERSHOOT):g}"
    low, high = a[1][1] + OVERSHOOT, b[1][0] - OVERSHOOT
    evidence = f"beta_L = {float(low):g}, beta_U = {float(high):g}"
    return refute_by_counterexample("beta_L < beta_U", arena, a[0] == b[0] and low >= high, evidence)


LEMMAS = (
    Lemma(
        "windows.inverse",
        "The shipped `time_of_sigma` inverts the profile of (4), both ways.",
        r"\sigma = \tanh\frac{t}{t_c-t} \iff t = t_c\frac{a}{1+a},\ a = \operatorname{artanh}\sigma",
        ("0 <= sigma < 1 and 0 <= t < t_c", "in real numbers; the function rounds to double"),
        "(5)",
        _prove_inverse,
    ),
    Lemma(
        "windows.printed_defined",
        "Every term of (5) is a number.",
        r"a_k\in\mathbb{R}",
        (),
        "(5) as printed",
        _refute_printed_defined,
    ),
    Lemma(
        "windows.interval",
        "The sigma at which the reach tube overlaps a set in one dimension form an interval: the shipped `conflict_in_sigma`.",
        r"\{\sigma\in[0,1] : \rho_U \ge \underline{U},\ \rho_L \le \overline{U}\} = [\sigma_1, \sigma_2]",
        ("exact numbers",),
        "in place of (5), ours",
        _prove_interval,
    ),
    Lemma(
        "windows.printed_order",
        "(5) closes when the conflict ends.",
        r"\bar t = \max\bar a",
        (),
        "(5) as printed",
        _refute_printed_order,
    ),
    Lemma(
        "windows.disjoint",
        "Boxes are disjoint exactly if they are apart in some dimension. So a tube avoids U_j if one dimension is strictly on "
        "one side of it during H, the time in which all others overlap it: for every j a dimension, not one for all j.",
        r"\gamma\cap U_j = \emptyset \iff \exists i: \gamma_{i,U}<\underline{U}_{j,i}\text{ or }\gamma_{i,L}>\overline{U}_{j,i}",
        ("at every instant", "H is that of the tube itself, not of rho"),
        "in place of Assumption 3 and (6), ours",
        _prove_disjoint,
    ),
    Lemma(
        "windows.one_dimension",
        "T is apart from all sets in one dimension.",
        r"\exists k_T",
        (),
        "Assumption 3",
        _refute_one_dimension,
    ),
    Lemma(
        "windows.from_rho",
        "A tube off the sets that rho meets is off all.",
        r"\gamma\cap U=\emptyset",
        (),
        "(5)",
        _refute_from_rho,
    ),
    Lemma(
        "windows.admissible",
        "In the case study every set that the reach tube meets has a dimension and side that can be held during H.",
        r"\forall j\,\exists i",
        ("one set at a time",),
        "in place of (6), ours",
        _prove_admissible,
    ),
    Lemma(
        "windows.shortest",
        "The dimension that (6) picks can be held off the set.",
        r"i^j",
        (),
        "(6) as printed",
        _refute_shortest,
    ),
    Lemma(
        "windows.room",
        "With lower(U) - dB - w_min >= lower(X) a lowered beta_U leaves w_min within X; mirrored for a raised beta_L.",
        r"\underline{U} - \delta B - w \ge \underline{X} \implies \underline{X} + w \le \beta_U < \overline{X}",
        ("U begins before X ends",),
        "in place of the rule below (6), ours",
        _prove_room,
    ),
    Lemma(
        "windows.printed_wall",
        "A set off the wall leaves room.",
        r"\beta_U \ge \underline{X}",
        (),
        "below (6)",
        _refute_printed_wall,
    ),
    Lemma(
        "windows.random_side",
        "Whichever sides are drawn, a tube is left.",
        r"\beta_L < \beta_U",
        (),
        "below (6)",
        _refute_random_side,
    ),
)
