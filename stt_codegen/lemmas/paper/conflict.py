"""Conflict windows (5), the dimension (6) and the side: where the printed rules fail, on exact data, and what holds instead."""

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


# The paper's case study; then the small arenas of single counterexamples, one side of a box a string.
ROOM, TARGET = _box("0 5", "0 5"), _box("4.5 5", "4.5 5")
STARTS = {"S1": _box("0 0.5", "4.5 5"), "S2": _box("0 0.5", "0 0.5"), "S3": _box("4 4.5", "0 0.5")}
UNSAFE = {"O1": _box("1 2", "4 5"), "O2": _box("2 3", "2.5 3.5"), "O3": _box("1 2", "0.5 1.5"), "O4": _box("4 5", "1.5 2.5")}
WIDENING = _box("2 3", "0 5"), _box("4 4.5", "3.2 3.5")  # X0 and T of one dimension; two choices of U
WALL = _box("0 10", "0.1 1.5")  # X and U of one dimension
SQUEEZE = _box("4 6", "3 5"), _box("4 6", "5.2 7")  # A is pushed up, B down
DETOUR = _box("0 1", "4.5 5.5"), _box("9 10", "4.5 5.5"), _box("4 6", "4 6"), _box("4 6", "6.1 8")  # X0, T, A, C

PLACES = [sp.Rational(v) for v in "-2 -1 0 1/3 2/3 1 2 3".split()]  # of crossings: two of them in every order with 0 and 1
LINE = [sp.Rational(k, 6) for k in range(7)]  # the places in [0, 1], and a point between any two


def _by_cases(method: str, shown: str, cases: int, wrong: Sequence[object]) -> Outcome:
    verdict = Verdict.PROVED if cases and not wrong else Verdict.OPEN
    return Outcome(verdict, method, (f"{shown}: {cases} cases, {len(wrong)} wrong", *map(str, wrong[:3])))


def _text(*sides: Edge) -> str:
    return " x ".join(f"[{float(a):.4g}, {float(b):.4g}]" if a <= b else "none" for a, b in sides)


def _time(sigma: Any, t_c: Any) -> Any:
    """The shipped `time_of_sigma`: its own code, run on formulas, so without rounding."""
    function: Any = shipped.time_of_sigma
    exact = {"math": SimpleNamespace(atanh=sp.atanh), "float": sp.sympify}
    return FunctionType(function.__code__, {**function.__globals__, **exact})(sigma, t_c)


def _prove_inverse() -> Outcome:
    """sigma = 1 - exp(-x) with x > 0 is every number between 0 and 1. atanh(tanh x) - x is 0 at 0 and has no slope."""
    t, t_c, x = sp.symbols("t t_c x", positive=True)
    sigma = 1 - sp.exp(-x)
    there, a = _time(sigma, t_c), sp.atanh(sigma)
    found = {
        "t/(t_c - t) - a at the shipped t": there / (t_c - there) - a,
        "tanh a - sigma": sp.tanh(a) - sigma,
        "shipped t at a = t/(t_c - t), less t": there.subs(a, x).subs(x, t / (t_c - t)) - t,
        "slope of atanh(tanh x) - x": sp.diff(sp.atanh(sp.tanh(x)) - x, x),
        "shipped t at sigma = 0": _time(sp.Integer(0), t_c),
        "shipped t at sigma = 1, less t_c": _time(sp.Integer(1), t_c) - t_c,
    }
    return prove_identities(found, "SymPy: the shipped function's code run on formulas; the difference of both sides is 0")


def _arguments(start: Edge, target: Edge, unsafe: Edge) -> list[Fraction | None]:
    """What atanh is applied to in the four terms of (5); None for a division by 0."""
    return [(u - x) / (end - x) if end != x else None for x, end in zip(start, target, strict=True) for u in unsafe]


def _refute_printed_defined() -> Outcome:
    sides = [(s[i], TARGET[i], u[i]) for s in STARTS.values() for u in UNSAFE.values() for i in range(len(TARGET))]
    terms = [argument for side in sides for argument in _arguments(*side)]
    known = [abs(v) for v in terms if v is not None]
    zero, one, more = terms.count(None), sum(v == 1 for v in known), sum(v > 1 for v in known)
    bad = zero + one + more
    shown = f"{bad} of {len(terms)} are not: {zero} divide by 0, {one} are atanh of 1 or -1, {more} of what lies beyond"
    return refute_by_counterexample("every term of (5) is a number", "the case study, X0hat = X0, That = T", bad > 0, shown)


def _edges(names: str) -> list[tuple[Any, Any, Any]]:
    """(start, end, bound) of an edge that rises or falls and crosses the bound at each place, or stays below, at, above it."""
    start, size = sp.Symbol(names[0], real=True), sp.Symbol(names[1], positive=True)
    sloped = [(start, start + slope, start + slope * place) for slope in (size, -size) for place in PLACES]
    return sloped + [(start, start, start + k * size) for k in (-1, 0, 1)]


def _prove_interval() -> Outcome:
    """Start and slope are symbols. What is left are comparisons of crossings with 0, 1 and each other: a place for each order."""
    upper = [(e, {s for s in LINE if e[0] + (e[1] - e[0]) * s - e[2] >= 0}) for e in _edges("mh")]
    lower = [(e, {s for s in LINE if e[0] + (e[1] - e[0]) * s - e[2] <= 0}) for e in _edges("lk")]
    wrong = []
    for (u, above), (v, below) in product(upper, lower):
        edges: Any = (v[0], u[0]), (v[1], u[1]), (u[2], v[2])
        found = shipped.conflict_in_sigma(*edges)
        inside = set() if found is None else {s for s in LINE if found[0] <= s <= found[1]}
        if inside != above & below or not all(any(end == p for p in PLACES) for end in found or ()):
            wrong.append(edges)
    sigma, s, e, c = sp.symbols("sigma X0 T c", real=True)
    affine = s + (e - s) * sigma - (s + (e - s) * c) - (e - s) * (sigma - c)
    method = "the shipped function by cases: start and slope as symbols, a pair of crossings for each order among them, 0 and 1"
    shown = "its answer and the two inequalities agree at 0, 1, every crossing and between them"
    return all_of(
        prove_identities({"rho - rho(c) - (T - X0)(sigma - c), so rho passes a bound once": affine}),
        _by_cases(method, shown, len(upper) * len(lower), wrong),
    )


def _refute_printed_order() -> Outcome:
    (start, target), shown, fails = WIDENING[0], [], []
    for unsafe in WIDENING[1]:
        known = [v for v in _arguments(start, target, unsafe) if v is not None and abs(v) < 1]
        a = [arb(fmpq(v.numerator, v.denominator)).atanh() for v in known]
        terms, (window,) = [v / (1 + v) for v in a], _windows((start,), (target,), (unsafe,))
        fails.append(bool(max(terms) < 1) and window[1] == 1 and not _apart(target, unsafe))
        ends = " to ".join(f"{end.str(4, radius=False)} t_c" for end in (min(terms), max(terms)))
        shown.append(
            f"U = {_text(unsafe)}: {ends} by the {len(a)} terms of 4 that are numbers, in truth sigma in {_text(window)}"
        )
    at = f"X0 = {_text(start)}, T = {_text(target)}"
    return refute_by_counterexample("(5) closes when the conflict ends", at, all(fails), "; ".join(shown))


def _apart(a: Edge, b: Edge) -> bool:
    return a[1] < b[0] or a[0] > b[1]


def _refute_one_dimension() -> Outcome:
    """The set in the way of each dimension; where it holds all of T's side, no That within T would do."""
    held = [[o for o, u in UNSAFE.items() if u[i][0] <= TARGET[i][0] and TARGET[i][1] <= u[i][1]] for i in range(len(TARGET))]
    shown = ", ".join(f"x{i + 1} of T within that of {' and '.join(sets) or 'none'}" for i, sets in enumerate(held))
    return refute_by_counterexample(
        "T is apart from all sets in one dimension", "the case study, any That within T", all(held), shown
    )


def _prove_disjoint() -> Outcome:
    """Closed intervals that share a point share an end of one, and only the order of the four ends matters."""
    pairs = list(product(combinations_with_replacement(map(Fraction, range(4)), 2), repeat=2))
    wrong = [(p, q) for p, q in pairs if _apart(p, q) == any(max(p[0], q[0]) <= x <= min(p[1], q[1]) for x in (*p, *q))]
    shown = "two intervals share no point exactly if one is below the other"
    return all_of(_by_cases("every order of four ends", shown, len(pairs), wrong), *map(_separated, (2, 3, 4)))


def _separated(n: int) -> Outcome:
    below, above = sp.symbols(f"below1:{n + 1}"), sp.symbols(f"above1:{n + 1}")
    overlap = [~(b | a) for b, a in zip(below, above, strict=True)]
    meet = sp.And(*overlap)
    claims = [sp.Equivalent(~meet, sp.Or(*below, *above))]
    for i in range(n):
        others = sp.And(*overlap[:i], *overlap[i + 1 :])
        claims += [sp.Implies(others >> side, ~meet) for side in (below[i], above[i])]
    wrong = [claim for claim in claims if satisfiable(~claim) is not False]
    shown = f"n = {n}: disjoint exactly if apart somewhere; disjoint if any one dimension is on one side where all others overlap"
    return _by_cases("SymPy: propositions, nothing satisfies their negation", shown, len(claims), wrong)


def _windows(start: Box, target: Box, unsafe: Box) -> list[Edge]:
    """The window in sigma of each dimension; (1, 0) for none."""
    found = (shipped.conflict_in_sigma(*sides) for sides in zip(start, target, unsafe, strict=True))
    return [window or (Fraction(1), Fraction(0)) for window in found]


def _common(windows: Sequence[Edge]) -> Edge:
    return max(a for a, _ in windows), min(b for _, b in windows)


def _sides(i: int, start: Box, target: Box, unsafe: Box) -> list[str]:
    """Where dimension i can be during H, the sigma at which all others overlap: where it is at 0 and at t_c, if H has these."""
    windows = _windows(start, target, unsafe)
    first, last = _common(windows[:i] + windows[i + 1 :])
    ends = [start[i]] * (first == 0) + [target[i]] * (last == 1) if first <= last else []
    above, below = all(e[0] > unsafe[i][1] for e in ends), all(e[1] < unsafe[i][0] for e in ends)
    return ["above"] * above + ["below"] * below


def _prove_admissible() -> Outcome:
    """For every set that the reach tube meets: the sides that can be held, and lie away from the walls by more than dB."""
    shown, wrong = [], []
    for (s, start), (o, unsafe) in product(STARTS.items(), UNSAFE.items()):
        first, last = _common(_windows(start, TARGET, unsafe))
        if first > last:
            continue
        room = [{"above": wall[1] - side[1], "below": side[0] - wall[0]} for wall, side in zip(ROOM, unsafe, strict=True)]
        free = [(i, side) for i in range(len(ROOM)) for side in _sides(i, start, TARGET, unsafe) if room[i][side] > OVERSHOOT]
        shown.append(f"{s} with {o}: {' or '.join(f'x{i + 1} {side}' for i, side in free) or 'none'}")
        wrong += [] if free else [(s, o)]
    return _by_cases("exact, by cases", "; ".join(shown), len(shown), wrong)


def _refute_shortest() -> Outcome:
    """Both times one window is within the other, so (6) picks it, in sigma as in time: sigma rises."""
    shown, fails = [], []
    for s, o in (("S1", "O1"), ("S3", "O4")):
        windows = _windows(STARTS[s], TARGET, UNSAFE[o])
        i = windows.index(_common(windows))
        fails.append(not _sides(i, STARTS[s], TARGET, UNSAFE[o]))
        way = f"from {_text(STARTS[s][i])} to {_text(TARGET[i])}, through {_text(UNSAFE[o][i])} by continuity"
        shown.append(f"{s} with {o}: sigma in {_text(windows[0])} and {_text(windows[1])}; x{i + 1} is picked and goes {way}")
    at = "the case study, X0hat = X0, That = T"
    return refute_by_counterexample("the dimension that (6) picks can be held", at, all(fails), "; ".join(shown))


def _refute_from_rho() -> Outcome:
    """In the middle of the push around A, inside rho's window, the lower edge is beta_L, which is above rho_L."""
    start, target, a, c = DETOUR
    during, beside, edge = _common(_windows(start, target, a)), _windows(start, target, c), a[1][1] + OVERSHOOT
    met = _common(beside)[0] <= _common(beside)[1]
    enters = beside[0][0] <= during[0] <= during[1] <= beside[0][1] and c[1][0] <= edge <= c[1][1]
    held = "above" in _sides(1, start, target, a) and edge > max(start[1][0], target[1][0])
    shown = f"rho overlaps A for sigma in {_text(during)}; C in x1 for {_text(beside[0])}, in x2 for {_text(beside[1])}"
    shown += f"; with x2 above A, beta_L = {float(edge):g} is within C's {_text(c[1])} meanwhile"
    at = f"A = {_text(*a)}, C = {_text(*c)}, dB = {float(OVERSHOOT):g}"
    return refute_by_counterexample("a tube kept off the sets that rho meets is off all", at, held and enters and not met, shown)


def _prove_room() -> Outcome:
    """U begins dB + w_min and a spare beyond the wall; the other wall is further on than U's edge."""
    wall, reach, width = sp.Symbol("wall", real=True), sp.Symbol("dB", positive=True), sp.Symbol("w_min", positive=True)
    spare, beyond = sp.symbols("spare beyond", nonnegative=True)
    found = {}
    for name, sign in (("(8), beta_U below U", 1), ("(7), beta_L above U", -1)):
        edge = wall + sign * (reach + width + spare)
        far = edge + sign * beyond
        beta = far - sign * (sign * (far - edge) + reach)  # B as (7), (8) have it
        found[f"{name}: from wall to edge, less w_min + spare"] = sign * (beta - wall) - (width + spare)
        found[f"{name}: from edge to the other wall, less dB + beyond"] = sign * (far - beta) - (reach + beyond)
    return prove_identities(found)


def _refute_printed_wall() -> Outcome:
    (wall, _), (edge, _) = WALL
    at = f"X = {_text(WALL[0])}, U = {_text(WALL[1])}, dB = {float(OVERSHOOT):g}"
    fails, shown = wall < edge < wall + OVERSHOOT, f"beta_U = {float(edge - OVERSHOOT):g}"
    return refute_by_counterexample("below a set that does not touch the wall, beta_U is within X", at, fails, shown)


def _refute_random_side() -> Outcome:
    """Both in x2, and with the same x1, so with the same window."""
    (a, b), at = SQUEEZE, f"A = {_text(*SQUEEZE[0])} pushing up, B = {_text(*SQUEEZE[1])} down, dB = {float(OVERSHOOT):g}"
    low, high = a[1][1] + OVERSHOOT, b[1][0] - OVERSHOOT
    shown = f"beta_L = {float(low):g}, beta_U = {float(high):g}"
    return refute_by_counterexample("beta_L < beta_U", at, a[0] == b[0] and low >= high, shown)


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
