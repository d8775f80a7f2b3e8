"""P9 (`certify/period.py`), run on symbols: the sharp statement in fractions, with rho = e^E.

What it compares is here what `sampling/statements.py` computes, term by term, so what is proved of one holds for the other.

Long because one code is run three ways: on symbols, on numbers that fail one condition, and on stubs that count questions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import permutations, product
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp
from flint import arb, ctx

from stt_codegen.certify import components, period
from stt_codegen.lemmas.formula import Formula, questions
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, cases, identity, sign
from stt_codegen.lemmas.sampled_evaluated import METHOD, NUMBERS, POINT, V, setting, symbol
from stt_codegen.program import enclosed
from stt_codegen.sampling import statements

LIMITS = (Fraction(5, 2), Fraction(5), Fraction(4))  # u_max, numbers of the scalar
Component: Any = components.Component  # of symbols here
EVERY = (1, 2, 3)  # three components: two others to couple with
RHO = {f"E{i}": sp.Symbol(f"rho{i}", positive=True) for i in EVERY}
BELOW, ABOVE = (Formula(sp.Symbol(word, positive=True), 1.0) for word in ("below", "above"))  # of a logarithm's two ends
OWN = {"f": 0.1, "w": 0.05, "s1": 0.25, "s2": 0.15, "s3": 0.2, "g": 0.9, "G": 1.0, "c": 0.05, "T": 7e-4}
HELD = {"u1": 1.25, "u2": 1.75, "u3": 1.5}


# ------------------------------------------------------------------------------------------------ P9


def _loop(limited: bool) -> tuple[Any, list[Any], list[Formula], dict[Any, Any]]:
    """The statement in fractions on symbols; its window and rho; and what the symbols of the other one are here."""
    own = {name: Formula(sp.Symbol(name, positive=True), value) for name, value in OWN.items()}
    plant = SimpleNamespace(force=own["f"] + own["w"], g_min=own["g"], g_max=own["G"], cross=own["c"])
    task: Any = SimpleNamespace(
        dimension=len(EVERY),
        order=1,
        plant_bounds=(plant,) * len(EVERY),
        control=SimpleNamespace(period=own["T"], latency=symbol("l")),
        emit=SimpleNamespace(scalar="float", math="libm"),
        e_max=(Fraction(999, 1000),) * len(EVERY),
        gain=(symbol("k1"), -symbol("k2"), symbol("k3")),
        u_max=LIMITS if limited else None,
    )
    shift: Any = tuple(symbol(f"eta{i}") for i in EVERY)
    tube: Any = SimpleNamespace()
    statement = period.SharpStatement(task, tube, shift, lambda y: (BELOW * y.log(), ABOVE * y.log()))
    window = [Component(symbol(f"d{i}"), symbol(f"n{i}"), symbol(f"w{i}"), own[f"s{i}"]) for i in EVERY]
    rho = [Formula(RHO[f"E{i}"], float(np.exp(NUMBERS[f"E{i}"]))) for i in EVERY]
    here = {name: value.form for name, value in own.items()}
    same = {V[f"P{i}"]: here["f"] + here["w"] + here[f"s{i}"] for i in EVERY} | {V["tau"]: here["T"] + V["l"]}
    same |= {V[f"g{i}"]: here["g"] for i in EVERY} | {V[f"G{i}"]: here["G"] for i in EVERY}
    same |= {V[f"c{i}{j}"]: here["c"] for i, j in permutations(EVERY, 2)} | {V["r"]: sp.Rational(statement.rounding)}
    same |= {V[f"m{i}"]: sp.Rational(limit) for i, limit in zip(EVERY, LIMITS, strict=True)}
    return statement, window, rho, same


def _there() -> dict[Any, float]:
    """Numbers for every symbol of the statement in fractions."""
    point = {
        sp.Symbol(name, positive=True): value for name, value in (OWN | HELD | {"P": 0.4, "below": 0.99, "above": 1.01}).items()
    }
    return POINT | point | {RHO[name]: round(float(np.exp(NUMBERS[name])), 6) for name in RHO}


def _difference(one: Any, other: Any, end: Formula, exactly: bool = True) -> Any:
    """One less the other, whose logarithms are taken from this end; a number where they differ at a point, since SymPy would take
    minutes over what is not 0. Not exactly: at that point alone, to 12 digits."""
    other = sp.sympify(other).replace(sp.log, lambda v: end.form * sp.log(v))
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


def _fractions() -> Outcome:
    """`_kept` on both components, u given: its six questions are the six conditions of `sharp_under`. Of the first
    component exactly, of the others, for which the same code runs, at a point."""
    u = [Formula(sp.Symbol(name, positive=True), value) for name, value in HELD.items()]
    statement, window, rho, same = _loop(limited=True)
    loop = setting(len(EVERY), coupled=True)
    given = np.array([u], dtype=object)
    reach = np.array([symbol(name) for name in RHO], dtype=object)
    conditions = statements.sharp_under(loop, reach, symbol("tau"), given, statements.sharp_push(loop, given))
    side, ends_low, inward_low, ends_high, inward_high, saturated = (c.values for c in conditions)
    found: dict[str, Any] = {}
    wrong: list[str] = []
    here = {name: sp.Symbol(name, positive=True) for name in OWN}
    for i in range(len(EVERY)):
        with questions() as asked:
            kept = statement._kept(i, window[i], rho[i], u)
        wanted = (side, saturated, ends_low, inward_low, ends_high, inward_high)
        if len(asked) != len(wanted) or not kept:
            wrong.append(f"component {i + 1}: {len(asked)} comparisons, {'kept' if kept else 'not kept'}")
            continue
        # P' and tau as one symbol each, so that SymPy has less to multiply out
        pushed = (
            sp.Symbol("P", positive=True) - here["w"] - here[f"s{i + 1}"] - here["c"] * sum(v.form for v in u if v is not u[i])
        )
        shorter = {here["f"]: pushed, here["T"]: V["tau"] - V["l"]}
        for j, (q, values) in enumerate(zip(asked, wanted, strict=True)):
            claimed = np.asarray(values, dtype=object)[0, i].form.subs(same)
            asks = (q.left - q.right).subs(shorter)
            found[f"component {i + 1}, comparison {j + 1}"] = _difference(asks, claimed.subs(shorter), BELOW, exactly=i == 0)
    return all_of(identity(found, METHOD), cases(len(EVERY), wrong, "six comparisons, none of which refuses"), _refuses())


def _refuses() -> Outcome:
    """Which comparison of `_kept` refuses, for numbers that fail that one and none before it. Those of the ends (the third and
    the fifth) never refuse alone: what same side leaves is more than twice the drift, since latency is within the age."""
    wrong: list[str] = []
    tried: dict[str, tuple[int, dict[str, Any]]] = {
        "same side": (1, {"narrow": Fraction(1, 50)}),
        "saturated": (2, {"u_max": Fraction(1, 100)}),
        "inward at the narrow end": (4, {"narrow": Fraction(400), "wide": Fraction(400)}),
        "inward at the wide end": (6, {"wide": Fraction(400)}),
        "none": (6, {}),
    }
    for name, (last, change) in tried.items():
        answer, asked = kept_after(**change)
        if (answer, asked) != (name == "none", last):
            wrong.append(f"{name}: {'kept' if answer else 'refused'} after {asked} comparisons")
    return cases(len(tried), wrong, "`_kept` refuses by the comparison that fails, and keeps where none does")


def kept_after(
    narrow: Fraction = Fraction(1),
    wide: Fraction = Fraction(2),
    u_max: Fraction = Fraction(100),
    pushes: tuple[Fraction, ...] = (Fraction(1, 10),),
) -> tuple[bool, int]:
    """The answer of `_kept` for one component, and after how many comparisons. pushes: at an edge, and for order 2 while a sample
    ages and from the middle."""
    plant = SimpleNamespace(force=_number(Fraction(1, 10)), g_min=Fraction(1), g_max=Fraction(1), cross=Fraction(0))
    task: Any = SimpleNamespace(
        dimension=1,
        order=1,
        plant_bounds=(plant,),
        control=SimpleNamespace(period=Fraction(1, 1000), latency=Fraction(0)),
        emit=SimpleNamespace(scalar="float", math="libm"),
        e_max=(Fraction(999, 1000),),
        gain=(Fraction(1),),
        u_max=(u_max,),
    )
    statement = period.SharpStatement(task, SimpleNamespace(), (Fraction(0),), lambda y: (y.log(), y.log()))  # type: ignore[arg-type]
    window = Component(_number(narrow), _number(narrow), _number(wide), *pushes)
    with questions() as asked:
        kept = statement._kept(0, window, _number(Fraction(6)), [_number(min(Fraction(20), u_max))])  # type: ignore[arg-type, list-item]
    return kept, len(asked)


def _number(value: Fraction) -> Formula:
    return Formula(sp.Rational(value), float(value))


def _inputs() -> Outcome:
    """`inputs` on every component: the same U as `input_bound`, free, at the clamp and at u_max, each with its own e_max."""
    found: dict[str, Any] = {}
    wrong: list[str] = []
    count = 0
    far, near = Fraction(1023, 1024), Fraction(5, 8)
    for e_max, limited, noisy in product(((far,) * 3, (far, near, far), (near, far, near)), (False, True), (False, True)):
        statement, window, rho, same = _loop(limited)
        statement.task.e_max = e_max
        if noisy:  # the law may see any width
            statement = replace(statement, shift=tuple(Formula(v.form, 1.0) for v in statement.shift))
        limits = np.array([float(v) if limited else np.inf for v in LIMITS])
        shift = np.array(statement.shift, dtype=object)
        loop = setting(len(EVERY), coupled=True)
        loop = replace(loop, law=replace(loop.law, e_max=np.array([float(v) for v in e_max]), u_max=limits, shift=shift))
        wanted = statements.input_bound(loop, np.array([symbol(name) for name in RHO], dtype=object))[0]
        u = statement.inputs(window, rho)
        count += 1
        name = f"e_max {e_max}, u_max {'given' if limited else 'none'}, noise {'wide' if noisy else 'small'}"
        if noisy and not limited:
            wrong += [f"{name}: U = {u}"] if u or not all(float(v) >= 1e300 for v in wanted) else []
        elif len(u) != len(EVERY):
            wrong.append(f"{name}: {len(u)} bounds")
        else:
            for i, values in enumerate(zip(u, wanted, strict=True)):
                a, b = (sp.sympify(getattr(v, "form", v)) for v in values)
                found[f"{name}, component {i + 1}"] = _difference(a, b.subs(same), ABOVE)
    return all_of(identity(found, METHOD), cases(count, wrong, "as many bounds as components, none where there is none"))


# ------------------------------------------------------------------------------------------------ what all this stands on


def _holds() -> Outcome:
    """`holds` looks at every component in every window, at the share, the clamp and the age, and gives the largest U."""
    wrong: list[str] = []
    count = 0

    def answer(
        fails: tuple[int, int] | None, rho: tuple[Fraction, ...], age: Fraction, late: Fraction, known: bool = True
    ) -> Any:
        asked: list[tuple[int, int]] = []

        class Stub(period.SharpStatement):
            def windows(self) -> Iterator[tuple[Any, ...]]:
                return iter(((0, 0, 0), (1, 1, 1), (2, 2, 2)))

            def inputs(self, window: Any, rho: Any) -> list[Fraction]:
                return [Fraction(1 + window[0]), Fraction(5 - window[1]), Fraction(2)] if known or window[0] < 2 else []

            def _kept(self, i: int, c: Any, rho: Fraction, u: list[Fraction]) -> bool:
                asked.append((c, i))
                return (c, i) != fails

        task = SimpleNamespace(
            dimension=3, order=1, prescribed_time=Fraction(4), e_max=(Fraction(4, 5), Fraction(3, 5), Fraction(2, 3)),
            initial_set=SimpleNamespace(share=Fraction(1, 2)), control=SimpleNamespace(period=age - late, latency=late),
        )  # fmt: skip
        found = Stub(task, SimpleNamespace(segments=2), ()).holds(rho)  # type: ignore[arg-type]
        return found, asked

    good, every = (Fraction(3), Fraction(5), Fraction(2)), [(c, i) for c in range(3) for i in range(3)]
    # 1/2 of the share is rho = 3, and e_max is rho = 9, 4 and 5; segments of 2 s, half of one where there is latency
    most, least, more = (Fraction(9), Fraction(4), Fraction(5)), Fraction(3), Fraction(1, 10**9)
    tried: list[tuple[tuple[Fraction, ...], Fraction, Fraction, bool]] = [
        (most, Fraction(2), Fraction(0), True),
        (most, Fraction(1), Fraction(1, 2), True),
    ]
    tried += [(most, Fraction(2) + more, Fraction(0), False), (most, Fraction(1) + more, Fraction(1, 2), False)]
    for i in range(3):
        for value, fine in ((most[i] + more, False), (least, False), (least + more, True)):
            tried.append(((*most[:i], value, *most[i + 1 :]), Fraction(1), Fraction(0), fine))
    for rho, age, late, fine in tried:
        found, asked = answer(None, rho, age, late)
        count += 1
        if (found, asked) != ((good, every) if fine else (None, [])):
            wrong.append(f"rho {rho}, age {age}, latency {late}: {found} after {len(asked)} questions")
    for place in every:
        count += 1
        if answer(place, most, Fraction(1), Fraction(0))[0] is not None:
            wrong.append(f"window {place[0]}, component {place[1]} fails, and all is said to hold")
    count += 1
    if answer(None, most, Fraction(1), Fraction(0), known=False)[0] is not None:
        wrong.append("a window without a bound on u, and all is said to hold")
    return cases(count, wrong, "holds where every component is kept in every window, and nowhere else")


def _series() -> Outcome:
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
        identity({"1/(1 - z^2) less its terms less z^(2N)/(1 - z^2)": sp.cancel(1 / (1 - z**2) - terms - z**left / (1 - z**2))}),
        sign({"(2N + 1)(1 - z^2) - 1 at z = 1/4, where it is least": (left + 1) * (1 - sp.Rational(1, 16)) - 1}),
        cases(count, wrong, "ln y is between both ends, which are 2^-50 apart at most"),
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
        _inputs,
        ("sampled.shift",),
    ),
    Lemma(
        "sampled.fractions",
        "P9 compares in fractions what the sharp statement computes: its conditions, one for one.",
        r"\tfrac1{1+e^{-E}} = \tfrac{\rho}{1+\rho},\quad \tanh\tfrac E2 = \tfrac{\rho-1}{\rho+1}",
        ("n = 3; by component, so for every n", "rho = e^E"),
        "the evaluated code",
        _fractions,
        ("sampled.sharp_evaluated",),
    ),
    Lemma(
        "sampled.logarithm",
        "The only thing in P9 that is no fraction is a logarithm, and that is enclosed.",
        r"0 \le \operatorname{artanh} z - \sum_{j<N}\tfrac{z^{2j+1}}{2j+1} < z^{2N+1}",
        ("|z| < 1/4",),
        "the evaluated code",
        _series,
    ),
    Lemma(
        "sampled.all",
        "P9 asks this of every component in every window, from the starts in the share up to the clamp.",
        r"\tfrac{1+s}{1-s} < \rho_i \le \tfrac{1+e_{\max}}{1-e_{\max}},\quad \tau \le t_k - t_{k-1}",
        (),
        "the evaluated code",
        _holds,
        ("sampled.exact_windows", "sampled.inputs", "sampled.fractions", "sampled.logarithm", "sampled.age"),
    ),
)
