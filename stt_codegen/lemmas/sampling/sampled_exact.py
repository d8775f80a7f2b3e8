"""P9 in fractions: the conditions of the sampled statements are one code, run on fractions for the certificate, with rho = e^E.

Here both kinds of number run it on the same symbols, and say the same, term by term: what is proved of one holds for the other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import sympy as sp
from flint import arb, ctx

from stt_codegen.lemmas.evaluated_expression import EvaluatedExpression
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities, prove_positive
from stt_codegen.lemmas.sampling.sampled_evaluated import METHOD, NUMBERS, POINT, V, setting, symbol
from stt_codegen.program.analyse import exact_logarithm as enclosed
from stt_codegen.sampling import FRACTIONS, Fractions, Law, Setting, Windows, inputs_where_proved, statements

EVERY = (1, 2, 3)  # three components: two others to couple with
RHO = {f"E{i}": sp.Symbol(f"rho{i}", positive=True) for i in EVERY}
BELOW, ABOVE = (
    EvaluatedExpression(sp.Symbol(word, positive=True), 1.0) for word in ("below", "above")
)  # of a logarithm's two ends
ON_SYMBOLS = Fractions(lambda y: (BELOW * y.log(), ABOVE * y.log()))
HELD = {"u1": 1.25, "u2": 1.75, "u3": 1.5, "P1'": 0.4, "P2'": 0.5, "P3'": 0.6}


# ------------------------------------------------------------------------------------------------ P9


def _both() -> tuple[Setting, Setting, Any, Any]:
    """A loop of symbols as the statements see it, the same in fractions, and the reaches of both."""
    loop = setting(len(EVERY), coupled=True)
    reach = np.array([symbol(name) for name in RHO], dtype=object)
    rho = np.array([EvaluatedExpression(v, float(np.exp(NUMBERS[name]))) for name, v in RHO.items()], dtype=object)
    return loop, loop.with_law(numbers=ON_SYMBOLS), reach, rho


def _there() -> dict[Any, float]:
    """Numbers for every symbol of the statement in fractions."""
    point = {sp.Symbol(name, positive=True): value for name, value in (HELD | {"below": 0.99, "above": 1.01}).items()}
    return POINT | point | {RHO[name]: round(float(np.exp(NUMBERS[name])), 6) for name in RHO}


def _difference(one: Any, other: Any, end: EvaluatedExpression, exactly: bool = True) -> Any:
    """One less the other, whose logarithms are taken from this end; a number where they differ at a point, since SymPy would take
    minutes over what is not 0. Not exactly: at that point alone, to 12 digits."""
    other = sp.sympify(other).replace(sp.log, lambda v: end.expression * sp.log(v))
    point = _there()
    forms = [sp.sympify(v).subs({V[name]: sp.log(rho) for name, rho in RHO.items()}) for v in (one, other)]
    rest = forms[0] - forms[1]
    off = rest.subs({s: sp.Rational(str(point[s])) for s in rest.free_symbols & point.keys()}).evalf(30)
    if abs(off) > sp.Float("1e-12"):
        return off
    return _rational(one) - _rational(other) if exactly else sp.Integer(0)


def _rational(expression: Any) -> Any:
    """E as ln rho, and every logarithm as a symbol of its argument, so that what is left is a rational function."""
    e = sp.sympify(expression).subs({V[name]: sp.log(rho) for name, rho in RHO.items()})
    e = e.replace(sp.tanh, lambda v: (sp.exp(2 * v) - 1) / (sp.exp(2 * v) + 1))
    return e.replace(sp.log, lambda v: sp.Symbol(f"ln({sp.cancel(sp.together(v))})", positive=True))


def _prove_fractions() -> Outcome:
    """Both on all components, u and P' given: the same six conditions. Of the first component exactly, of the others, for which
    the same code runs, at a point."""
    loop, exact, reach, rho = _both()
    given = {name: EvaluatedExpression(sp.Symbol(name, positive=True), value) for name, value in HELD.items()}
    u, push = (np.array([[given[name] for name in names]], dtype=object) for names in (("u1", "u2", "u3"), ("P1'", "P2'", "P3'")))
    wanted, compared = (list(statements.sharp_under(s, e, symbol("tau"), u, push)) for s, e in ((loop, reach), (exact, rho)))
    found: dict[str, Any] = {}
    wrong = [c.lemma for c in compared if not (c.values > 0).all()]
    for i in range(len(EVERY)):
        for j, (a, b) in enumerate(zip(compared, wanted, strict=True)):
            one, other = (np.asarray(c.values, dtype=object)[0, i].expression for c in (a, b))
            found[f"component {i + 1}, comparison {j + 1}"] = _difference(one, other, BELOW, exactly=i == 0)
    return all_of(
        prove_identities(found, METHOD), outcome_of_cases(len(EVERY), wrong, "six comparisons, none of which refuses"), _refuses()
    )


def _refuses() -> Outcome:
    """Which condition refuses, for numbers that fail that one and none before it. Of order 1 those of the ends (the third and the
    fifth) never refuse alone: what same side leaves is more than twice the drift, since latency is within the age."""
    wrong: list[str] = []
    tried: dict[str, tuple[int | None, dict[str, Any]]] = {
        "same side": (1, {"narrow": Fraction(1, 50)}),
        "saturated": (2, {"u_max": Fraction(1, 100)}),
        "inward at the narrow end": (4, {"narrow": Fraction(400), "wide": Fraction(400)}),
        "inward at the wide end": (6, {"wide": Fraction(400)}),
        "none": (None, {}),
    }
    for name, (place, change) in tried.items():
        answer = refusing_condition(**change)
        if answer != place:
            wrong.append(f"{name}: refused by {answer}")
    return outcome_of_cases(len(tried), wrong, "the condition that fails refuses, and none where all hold")


def refusing_condition(
    narrow: Fraction = Fraction(1),
    wide: Fraction = Fraction(2),
    u_max: Fraction = Fraction(100),
    pushes: tuple[Fraction, ...] = (Fraction(1, 5),),
) -> int | None:
    """The number of the condition by which one component in fractions is refused; None where it is not. pushes: at an edge, and
    for order 2 while a sample ages and from the middle."""
    law = _law_of_rows(_row(1)[0], _row(Fraction(999, 1000))[0], _row(u_max)[0])
    loop = _loop_of_rows(law, _row(narrow), _row(wide), *map(_row, pushes))
    u = _row(min(Fraction(20), u_max))
    return statements.first_failing(statements.sharp_under(loop, _row(6)[0], Fraction(1, 1000), u, loop.push))


def _row(*values: Fraction | int) -> Any:
    return np.array([[Fraction(v) for v in values]], dtype=object)


def _law_of_rows(gain: Any, e_max: Any, u_max: Any) -> Law:
    """A law in fractions that sees x as it is, without latency."""
    return Law(
        gain=gain, e_max=e_max, shift=0 * gain, u_max=u_max, rounding=Fraction(1, 1 << 19), latency=Fraction(0), numbers=FRACTIONS
    )


def _loop_of_rows(law: Law, narrow: Any, wide: Any, push: Any, drift: Any = None, middle: Any = None) -> Setting:
    """A loop in fractions whose g is the identity, of rows by window; windows of 2 s, and starts with |e| <= 1/2."""
    count, n = narrow.shape
    still, one = 0 * narrow, 0 * narrow + 1
    ends = np.array([Fraction(2 * k) for k in range(count + 1)])
    windows = Windows(times=ends, narrow=narrow, wide=wide, speed=still, widening=still, low=still, high=still, start=still)
    start = np.full(n, Fraction(3))
    return Setting(
        windows=windows,
        law=law,
        least=one,
        most=one,
        cross=np.zeros((count, n, n), dtype=int),
        push=push,
        narrow=narrow,
        definite=one[:, 0],
        norm=one[:, 0],
        push_norm=one[:, 0],
        start=start,
        drift=drift,
        middle=middle,
    )


def _expected_input(i: int, e_max: Fraction, is_limited: bool, is_noisy: bool) -> Any:
    """U of component i, from 1, as sampled.shift has it: free, at the clamp, or u_max; None where nothing bounds it."""
    d, eta, k, r, e = (V[name] for name in (f"n{i}", f"eta{i}", f"k{i}", "r", f"E{i}"))
    point = POINT | ({eta: 1} if is_noisy else {})
    share = sp.Rational(1 - e_max) / 2
    far, near = d / (1 + sp.exp(-e)) + eta, d / (1 + sp.exp(e)) - eta
    if sp.N((near - (far + near) * share).subs(point)) <= 0:
        far, near = (1 - share) * (d - 2 * eta), share * (d - 2 * eta)
    limit = V[f"m{i}"] if is_limited else None
    if sp.N(near.subs(point)) <= 0:
        return limit
    law = k * (1 / far + 1 / near) * (sp.log(far / near) + r) * (1 + r)
    return law if limit is None or sp.N(law.subs(point)) < point[limit] else limit


def _prove_inputs() -> Outcome:
    """`input_bound` in both kinds of numbers is that U: free, at the clamp and at u_max, each component with its own e_max."""
    found: dict[str, Any] = {}
    wrong: list[str] = []
    count = 0
    loop, exact, reach, rho = _both()
    far, near = Fraction(1023, 1024), Fraction(5, 8)
    for e_max, limited, noisy in product(((far,) * 3, (far, near, far), (near, far, near)), (False, True), (False, True)):
        shift = np.array([EvaluatedExpression(v.expression, 1.0) if noisy else v for v in loop.law.shift], dtype=object)
        limits: Any = np.array([symbol("m1"), symbol("m2"), symbol("m3")], dtype=object) if limited else np.full(3, np.inf)
        law = {"e_max": np.array(e_max, dtype=object), "shift": shift, "u_max": limits}
        bounds = [statements.input_bound(s.with_law(**law), e)[0] for s, e in ((loop, reach), (exact, rho))]
        count += 1
        name = f"e_max {e_max}, u_max {'given' if limited else 'none'}, noise {'wide' if noisy else 'small'}"
        for i, limit in zip(EVERY, e_max, strict=True):
            wanted = _expected_input(i, limit, limited, noisy)
            for kind, u, end in (
                ("E", bounds[0][i - 1], EvaluatedExpression(sp.Integer(1), 1.0)),
                ("rho", bounds[1][i - 1], ABOVE),
            ):
                if wanted is None:
                    wrong += [] if float(u) >= 1e300 else [f"{name}: U = {u}"]
                else:
                    found[f"{name}, component {i}, by {kind}"] = _difference(u.expression, wanted, end)
    return all_of(
        prove_identities(found, METHOD), outcome_of_cases(count, wrong, "as many bounds as components, none where there is none")
    )


# ------------------------------------------------------------------------------------------------ what all this stands on


def _proved_loops() -> Iterator[tuple[str, Setting, tuple[Fraction, ...], Fraction, bool]]:
    """Loops of three windows and three components: what is tried, the loop, rho, the age, and whether it is to hold."""
    narrow = np.array([[Fraction(1 + k + 2 * i, 2) for i in range(3)] for k in range(3)], dtype=object)
    e_max = (Fraction(4, 5), Fraction(3, 5), Fraction(2, 3))  # rho is 9, 4 and 5 at the most
    law = _law_of_rows(_row(1, 1, 1)[0], _row(*e_max)[0], np.full(3, np.inf))
    good, late = (_loop_of_rows(v, narrow, narrow, 0 * narrow) for v in (law, replace(law, latency=Fraction(1, 2000))))
    most, least, more, short = (Fraction(9), Fraction(4), Fraction(5)), Fraction(3), Fraction(1, 10**9), Fraction(1, 1000)
    yield "all at their most", good, most, short, True
    yield "late", late, most, short, True
    yield "less than the latency", late, most, short / 3, False
    for k, i in product(range(3), range(3)):
        thin = narrow.copy()
        thin[k, i] = Fraction(1, 1000)
        yield f"window {k}, component {i}", _loop_of_rows(law, thin, narrow, 0 * narrow), most, short, False
    for i in range(3):
        for value, holds in ((most[i] + more, False), (least, False), (least + more, True)):
            yield f"rho {value} of component {i}", good, (*most[:i], value, *most[i + 1 :]), short, holds
    slow = [
        _loop_of_rows(replace(v.law, gain=_row(*[Fraction(1, 10**4)] * 3)[0]), narrow, narrow, 0 * narrow) for v in (good, late)
    ]
    for loop, age in zip(slow, (Fraction(2), Fraction(1)), strict=True):
        yield f"an age of {age} s", loop, most, age, True
        yield f"older than {age} s", loop, most, age + more, False


def _prove_all() -> Outcome:
    """`inputs_where_proved` looks at every component in every window, at the share, the clamp and the age, and gives the largest
    U."""
    wrong: list[str] = []
    count = 0
    for name, loop, rho, age, holds in _proved_loops():
        count += 1
        u, bound = inputs_where_proved(loop, rho, age), statements.input_bound(loop, np.array(rho, dtype=object)).max(axis=0)
        if (u is not None) != holds or (u is not None and u != tuple(bound)):
            wrong.append(f"{name}: |u| <= {u}")
    return outcome_of_cases(count, wrong, "holds where every component is kept in every window, and nowhere else")


def _prove_logarithm() -> Outcome:
    """The slope of artanh less that of N terms is z^(2N)/(1 - z^2): so what is left out of artanh z is below
    z^(2N + 1)/((2N + 1)(1 - z^2)), and that is below z^(2N + 1) for z < 1/4."""
    z, left = sp.Symbol("z", positive=True), 2 * enclosed.TERMS
    terms = sum(z ** (2 * j) for j in range(enclosed.TERMS))
    wrong: list[str] = []
    count = 0
    grid = [Fraction(k, 97) for k in range(98, 98 + 97 * 3, 5)] + [Fraction(3) ** k / 2 for k in range(1, 40)]
    for y in (*grid, *(1 + Fraction(1, 10) ** k for k in range(1, 18))):
        count += 1
        low, high = enclosed.logarithm(y)
        with ctx.workprec(200):
            inside = _ball(low) <= _ball(y).log() <= _ball(high)
        if not (inside and high - low < Fraction(1, 1 << 50)):
            wrong.append(f"ln {y} is not enclosed by {float(low)} and {float(high)}, or widely")
    return all_of(
        prove_identities(
            {"1/(1 - z^2) less its terms less z^(2N)/(1 - z^2)": sp.cancel(1 / (1 - z**2) - terms - z**left / (1 - z**2))}
        ),
        prove_positive({"(2N + 1)(1 - z^2) - 1 at z = 1/4, where it is least": (left + 1) * (1 - sp.Rational(1, 16)) - 1}),
        outcome_of_cases(count, wrong, "ln y is between both ends, which are 2^-50 apart at most"),
    )


def _ball(value: Fraction) -> Any:
    return arb(value.numerator) / arb(value.denominator)


LEMMAS = (
    Lemma(
        "sampled.inputs",
        "P9 bounds u as the sampled statements do.",
        r"U_i = k_i\,h(a+\eta, b-\eta)(1+r) + \ldots",
        ("n = 3; by component, so for every n", "rho = e^E"),
        "the evaluated code",
        _prove_inputs,
        ("sampled.shift",),
    ),
    Lemma(
        "sampled.fractions",
        "P9 compares in fractions what the sharp statement computes: its conditions, one for one.",
        r"\tfrac1{1+e^{-E}} = \tfrac{\rho}{1+\rho},\quad \tanh\tfrac E2 = \tfrac{\rho-1}{\rho+1}",
        ("n = 3; by component, so for every n", "rho = e^E"),
        "the evaluated code",
        _prove_fractions,
        ("sampled.sharp_evaluated",),
    ),
    Lemma(
        "sampled.logarithm",
        "The only thing in P9 that is no fraction is a logarithm, and that is enclosed.",
        r"0 \le \operatorname{artanh} z - \sum_{j<N}\tfrac{z^{2j+1}}{2j+1} < z^{2N+1}",
        ("|z| < 1/4",),
        "the evaluated code",
        _prove_logarithm,
    ),
    Lemma(
        "sampled.all",
        "P9 asks this of every component in every window, from the starts in the share up to the clamp.",
        r"\tfrac{1+s}{1-s} < \rho_i \le \tfrac{1+e_{\max}}{1-e_{\max}},\quad \tau \le t_k - t_{k-1}",
        (),
        "the evaluated code",
        _prove_all,
        ("sampled.exact_windows", "sampled.inputs", "sampled.fractions", "sampled.logarithm", "sampled.age"),
    ),
)
