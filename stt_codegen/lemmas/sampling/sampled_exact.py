"""Lemmas about P9 in fractions: the certificate runs the code of the sampled conditions on fractions, with rho = e^E.

Here that code runs with both kinds of number on the same symbols and returns the same terms, so what is proved of one kind holds
for the other. book.py takes LEMMAS as a part of the family `sampled`.

Long because it compares conditions, inputs, windows and logarithms of both kinds of number.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from flint import arb, ctx

from stt_codegen.lemmas.evaluated_expression import EvaluatedExpression
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities, prove_positive
from stt_codegen.lemmas.sampling.sampled_evaluated import METHOD, NUMBERS, TEST_POINT, V, setting, symbol
from stt_codegen.program.analyse import exact_logarithm
from stt_codegen.sampling import FRACTIONS, Fractions, SampledLaw, SampledLoop, Windows, inputs_where_proved, sampling_conditions

COMPONENTS = (1, 2, 3)  # each has two that it is coupled with
RHO = {f"E{i}": sp.Symbol(f"rho{i}", positive=True) for i in COMPONENTS}
BELOW, ABOVE = (
    EvaluatedExpression(sp.Symbol(word, positive=True), 1.0) for word in ("below", "above")
)  # factors of a logarithm's ends
ON_SYMBOLS = Fractions(lambda y: (BELOW * y.log(), ABOVE * y.log()))
INPUT_VALUES = {"u1": 1.25, "u2": 1.75, "u3": 1.5, "P1'": 0.4, "P2'": 0.5, "P3'": 0.6}


# ------------------------------------------------------------------------------------------------ P9


class LoopPair(NamedTuple):
    """One loop of symbols for both kinds of number: for doubles with its E by component, for fractions with its rho."""

    for_doubles: SampledLoop
    E: Any
    for_fractions: SampledLoop
    rho: Any


def _loop_pair() -> LoopPair:
    """Return the coupled loop of three components in which every number is a symbol."""
    loop = setting(len(COMPONENTS), coupled=True)
    E = np.array([symbol(name) for name in RHO], dtype=object)
    rho = np.array([EvaluatedExpression(v, float(np.exp(NUMBERS[name]))) for name, v in RHO.items()], dtype=object)
    return LoopPair(loop, E, loop.with_law(numbers=ON_SYMBOLS), rho)


def _test_point() -> dict[Any, float]:
    """Return a number for every symbol of the conditions in fractions."""
    point = {sp.Symbol(name, positive=True): value for name, value in (INPUT_VALUES | {"below": 0.99, "above": 1.01}).items()}
    return TEST_POINT | point | {RHO[name]: round(float(np.exp(NUMBERS[name])), 6) for name in RHO}


def _difference(first: Any, second: Any, end_factor: EvaluatedExpression, exactly: bool = True) -> Any:
    """Return the first expression less the second, in which every logarithm is multiplied by the factor of its end.

    Where they differ at the test point the result is that number, since SymPy would take minutes over what is not 0. Without
    `exactly` they are compared at that point alone, to 12 digits.
    """
    second = sp.sympify(second).replace(sp.log, lambda v: end_factor.expression * sp.log(v))
    point = _test_point()
    in_rho = [sp.sympify(v).subs({V[name]: sp.log(rho) for name, rho in RHO.items()}) for v in (first, second)]
    remainder = in_rho[0] - in_rho[1]
    remainder_at_point = remainder.subs({s: sp.Rational(str(point[s])) for s in remainder.free_symbols & point.keys()}).evalf(30)
    if abs(remainder_at_point) > sp.Float("1e-12"):
        return remainder_at_point
    return _rational(first) - _rational(second) if exactly else sp.Integer(0)


def _rational(expression: Any) -> Any:
    """Rewrite E as ln rho and every logarithm as a symbol of its argument; the result is a rational function."""
    e = sp.sympify(expression).subs({V[name]: sp.log(rho) for name, rho in RHO.items()})
    e = e.replace(sp.tanh, lambda v: (sp.exp(2 * v) - 1) / (sp.exp(2 * v) + 1))
    return e.replace(sp.log, lambda v: sp.Symbol(f"ln({sp.cancel(sp.together(v))})", positive=True))


def _prove_fractions() -> Outcome:
    """Compare the six conditions in both kinds of number, for the same u and P'.

    Those of the first component are compared exactly, those of the others, for which the same code runs, at a point.
    """
    pair = _loop_pair()
    inputs = {name: EvaluatedExpression(sp.Symbol(name, positive=True), value) for name, value in INPUT_VALUES.items()}
    u, push = (
        np.array([[inputs[name] for name in names]], dtype=object) for names in (("u1", "u2", "u3"), ("P1'", "P2'", "P3'"))
    )
    conditions_doubles, conditions_fractions = (
        list(sampling_conditions.sharp_under(s, e, symbol("tau"), u, push))
        for s, e in ((pair.for_doubles, pair.E), (pair.for_fractions, pair.rho))
    )
    differences: dict[str, Any] = {}
    failures = [c.lemma for c in conditions_fractions if not (c.values > 0).all()]
    for i in range(len(COMPONENTS)):
        for j, (a, b) in enumerate(zip(conditions_fractions, conditions_doubles, strict=True)):
            first, second = (np.asarray(c.values, dtype=object)[0, i].expression for c in (a, b))
            differences[f"component {i + 1}, comparison {j + 1}"] = _difference(first, second, BELOW, exactly=i == 0)
    return all_of(
        prove_identities(differences, METHOD),
        outcome_of_cases(len(COMPONENTS), failures, "six comparisons, none of which refuses"),
        _check_refusals(),
    )


def _check_refusals() -> Outcome:
    """Check which condition refuses, for numbers that fail that one and none before it.

    For order 1 the third and the fifth never refuse alone: the first leaves more than twice the drift, since the latency is
    within the age.
    """
    failures: list[str] = []
    cases: dict[str, tuple[int | None, dict[str, Any]]] = {
        "same side": (1, {"narrow": Fraction(1, 50)}),
        "saturated": (2, {"u_max": Fraction(1, 100)}),
        "inward at the narrow end": (4, {"narrow": Fraction(400), "wide": Fraction(400)}),
        "inward at the wide end": (6, {"wide": Fraction(400)}),
        "none": (None, {}),
    }
    for name, (expected, change) in cases.items():
        condition = refusing_condition(**change)
        if condition != expected:
            failures.append(f"{name}: refused by {condition}")
    return outcome_of_cases(len(cases), failures, "the condition that fails refuses, and none where all hold")


def refusing_condition(
    narrow: Fraction = Fraction(1),
    wide: Fraction = Fraction(2),
    u_max: Fraction = Fraction(100),
    pushes: tuple[Fraction, ...] = (Fraction(1, 5),),
) -> int | None:
    """Return the number, from 1, of the condition that refuses a loop of one component in fractions; None where none does.

    pushes: plant bounds at an edge, and for order 2 also while a sample ages and relative to the middle.
    """
    law = _law_of_rows(_row(1)[0], _row(Fraction(999, 1000))[0], _row(u_max)[0])
    loop = _loop_of_rows(
        law,
        _row(narrow),
        _row(wide),
        **dict(zip(("closing_speed", "closing_speed_aging", "closing_speed_middle"), map(_row, pushes), strict=False)),
    )
    u = _row(min(Fraction(20), u_max))
    return sampling_conditions.first_failing(
        sampling_conditions.sharp_under(loop, _row(6)[0], Fraction(1, 1000), u, loop.closing_speed)
    )


def _row(*values: Fraction | int) -> Any:
    return np.array([[Fraction(v) for v in values]], dtype=object)


def _law_of_rows(gain: Any, e_max: Any, u_max: Any) -> SampledLaw:
    """Return a law in fractions that sees x without an error, without latency."""
    return SampledLaw(
        gain=gain, e_max=e_max, shift=0 * gain, u_max=u_max, rounding=Fraction(1, 1 << 19), latency=Fraction(0), numbers=FRACTIONS
    )


def _loop_of_rows(
    law: SampledLaw,
    narrow: Any,
    wide: Any,
    *,
    closing_speed: Any,
    closing_speed_aging: Any = None,
    closing_speed_middle: Any = None,
) -> SampledLoop:
    """Return a loop in fractions whose g is the identity, with windows of 2 s and starts with |e| <= 1/2; rows are by window."""
    count, n = narrow.shape
    zeros, ones = 0 * narrow, 0 * narrow + 1
    ends = np.array([Fraction(2 * k) for k in range(count + 1)])
    windows = Windows(times=ends, narrow=narrow, wide=wide, speed=zeros, widening=zeros, low=zeros, high=zeros, start=zeros)
    start = np.full(n, Fraction(3))
    return SampledLoop(
        windows=windows,
        law=law,
        diagonal_min=ones,
        diagonal_max=ones,
        cross=np.zeros((count, n, n), dtype=int),
        closing_speed=closing_speed,
        narrow=narrow,
        eigenvalue_min=ones[:, 0],
        norm=ones[:, 0],
        closing_speed_norm=ones[:, 0],
        start=start,
        closing_speed_aging=closing_speed_aging,
        closing_speed_middle=closing_speed_middle,
    )


def _expected_input(i: int, e_max: Fraction, is_limited: bool, is_noisy: bool) -> Any:
    """Return U of component i, from 1, by sampled.shift: of the law, at the clamp, or u_max; None where nothing bounds it."""
    d, eta, k, r, e = (V[name] for name in (f"n{i}", f"eta{i}", f"k{i}", "r", f"E{i}"))
    point = TEST_POINT | ({eta: 1} if is_noisy else {})
    share = sp.Rational(1 - e_max) / 2
    far, near = d / (1 + sp.exp(-e)) + eta, d / (1 + sp.exp(e)) - eta
    if sp.N((near - (far + near) * share).subs(point)) <= 0:
        far, near = (1 - share) * (d - 2 * eta), share * (d - 2 * eta)
    limit = V[f"m{i}"] if is_limited else None
    if sp.N(near.subs(point)) <= 0:
        return limit
    u = k * (1 / far + 1 / near) * (sp.log(far / near) + r) * (1 + r)
    return u if limit is None or sp.N(u.subs(point)) < point[limit] else limit


def _prove_inputs() -> Outcome:
    """Compare `input_bound` in both kinds of number with that U, where components have different values of e_max."""
    differences: dict[str, Any] = {}
    failures: list[str] = []
    count = 0
    pair = _loop_pair()
    e_max_far, e_max_near = Fraction(1023, 1024), Fraction(5, 8)
    for e_max, is_limited, is_noisy in product(
        ((e_max_far,) * 3, (e_max_far, e_max_near, e_max_far), (e_max_near, e_max_far, e_max_near)), (False, True), (False, True)
    ):
        shift = np.array(
            [EvaluatedExpression(v.expression, 1.0) if is_noisy else v for v in pair.for_doubles.law.shift], dtype=object
        )
        limits: Any = np.array([symbol("m1"), symbol("m2"), symbol("m3")], dtype=object) if is_limited else np.full(3, np.inf)
        law = {"e_max": np.array(e_max, dtype=object), "shift": shift, "u_max": limits}
        bounds = [
            sampling_conditions.input_bound(s.with_law(**law), e)[0]
            for s, e in ((pair.for_doubles, pair.E), (pair.for_fractions, pair.rho))
        ]
        count += 1
        name = f"e_max {e_max}, u_max {'given' if is_limited else 'none'}, noise {'wide' if is_noisy else 'small'}"
        for i, clamp in zip(COMPONENTS, e_max, strict=True):
            expected = _expected_input(i, clamp, is_limited, is_noisy)
            for kind, u, end in (
                ("E", bounds[0][i - 1], EvaluatedExpression(sp.Integer(1), 1.0)),
                ("rho", bounds[1][i - 1], ABOVE),
            ):
                if expected is None:
                    failures += [] if float(u) >= 1e300 else [f"{name}: U = {u}"]
                else:
                    differences[f"{name}, component {i}, by {kind}"] = _difference(u.expression, expected, end)
    return all_of(
        prove_identities(differences, METHOD),
        outcome_of_cases(count, failures, "as many bounds as components, none where there is none"),
    )


# ------------------------------------------------------------------------------------------------ windows and logarithms


class LoopCase(NamedTuple):
    """A loop in fractions with rho by component and the age of samples; holds: whether it must be proved."""

    name: str
    loop: SampledLoop
    rho: tuple[Fraction, ...]
    age: Fraction
    holds: bool


def _loop_cases() -> Iterator[LoopCase]:
    """Yield loops of three windows and three components for which it is known whether `inputs_where_proved` must hold."""
    narrow = np.array([[Fraction(1 + k + 2 * i, 2) for i in range(3)] for k in range(3)], dtype=object)
    e_max = (Fraction(4, 5), Fraction(3, 5), Fraction(2, 3))  # rho is at most 9, 4 and 5
    law = _law_of_rows(_row(1, 1, 1)[0], _row(*e_max)[0], np.full(3, np.inf))
    good, late = (
        _loop_of_rows(v, narrow, narrow, closing_speed=0 * narrow) for v in (law, replace(law, latency=Fraction(1, 2000)))
    )
    largest_rho, smallest_rho = (Fraction(9), Fraction(4), Fraction(5)), Fraction(3)
    tiny, short_age = Fraction(1, 10**9), Fraction(1, 1000)
    yield LoopCase("all at their most", good, largest_rho, short_age, True)
    yield LoopCase("late", late, largest_rho, short_age, True)
    yield LoopCase("less than the latency", late, largest_rho, short_age / 3, False)
    for k, i in product(range(3), range(3)):
        thin = narrow.copy()
        thin[k, i] = Fraction(1, 1000)
        yield LoopCase(
            f"window {k}, component {i}",
            _loop_of_rows(law, thin, narrow, closing_speed=0 * narrow),
            largest_rho,
            short_age,
            False,
        )
    for i in range(3):
        for value, holds in ((largest_rho[i] + tiny, False), (smallest_rho, False), (smallest_rho + tiny, True)):
            yield LoopCase(
                f"rho {value} of component {i}", good, (*largest_rho[:i], value, *largest_rho[i + 1 :]), short_age, holds
            )
    slow = [
        _loop_of_rows(replace(v.law, gain=_row(*[Fraction(1, 10**4)] * 3)[0]), narrow, narrow, closing_speed=0 * narrow)
        for v in (good, late)
    ]
    for loop, age in zip(slow, (Fraction(2), Fraction(1)), strict=True):
        yield LoopCase(f"an age of {age} s", loop, largest_rho, age, True)
        yield LoopCase(f"older than {age} s", loop, largest_rho, age + tiny, False)


def _prove_all() -> Outcome:
    """Check that `inputs_where_proved` examines every component in every window, the share, the clamp and the age.

    Where all hold it must return the largest U of each component.
    """
    failures: list[str] = []
    count = 0
    for name, loop, rho, age, holds in _loop_cases():
        count += 1
        u, bound = (
            inputs_where_proved(loop, rho, age),
            sampling_conditions.input_bound(loop, np.array(rho, dtype=object)).max(axis=0),
        )
        if (u is not None) != holds or (u is not None and u != tuple(bound)):
            failures.append(f"{name}: |u| <= {u}")
    return outcome_of_cases(count, failures, "holds where every component is kept in every window, and nowhere else")


def _prove_logarithm() -> Outcome:
    """Prove a bound on the remainder of the series, and check that the code's ends enclose ln y at many y.

    The slope of artanh less that of N terms is z^(2N)/(1 - z^2). So the remainder of artanh z is below
    z^(2N + 1)/((2N + 1)(1 - z^2)), which is below z^(2N + 1) for z < 1/4.
    """
    z, exponent = sp.Symbol("z", positive=True), 2 * exact_logarithm.TERMS
    terms = sum(z ** (2 * j) for j in range(exact_logarithm.TERMS))
    failures: list[str] = []
    count = 0
    grid = [Fraction(k, 97) for k in range(98, 98 + 97 * 3, 5)] + [Fraction(3) ** k / 2 for k in range(1, 40)]
    for y in (*grid, *(1 + Fraction(1, 10) ** k for k in range(1, 18))):
        count += 1
        low, high = exact_logarithm.logarithm(y)
        with ctx.workprec(200):
            is_enclosed = _ball(low) <= _ball(y).log() <= _ball(high)
        if not (is_enclosed and high - low < Fraction(1, 1 << 50)):
            failures.append(f"ln {y} is not enclosed by {float(low)} and {float(high)}, or widely")
    return all_of(
        prove_identities(
            {"1/(1 - z^2) less its terms less z^(2N)/(1 - z^2)": sp.cancel(1 / (1 - z**2) - terms - z**exponent / (1 - z**2))}
        ),
        prove_positive({"(2N + 1)(1 - z^2) - 1 at z = 1/4, where it is least": (exponent + 1) * (1 - sp.Rational(1, 16)) - 1}),
        outcome_of_cases(count, failures, "ln y is between both ends, which are 2^-50 apart at most"),
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
