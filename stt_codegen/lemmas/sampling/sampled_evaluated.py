"""The sampled statements as sampling/statements.py evaluates them: its very code, run on formulas, is what sampled.py proves
things about, with all that noise, latency and rounding add.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen.lemmas.evaluated_expression import EvaluatedExpression
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities
from stt_codegen.sampling import STATEMENTS, Law, Setting, Windows

NUMBERS = {
    "E": 2.0, "E1": 2.0, "E2": 1.5, "k1": 0.3, "k2": 0.4,
    "tau": 1e-3, "l": 3e-4, "k": 0.3, "r": 1e-5, "d1": 0.5, "d2": 0.6, "n1": 0.45, "n2": 0.55,
    "w1": 0.7, "w2": 0.9, "push1": 0.4, "push2": 0.3,
    "g1": 0.9, "g2": 1.1, "G1": 1.0, "G2": 1.2, "c12": 0.1, "c21": 0.05, "eta1": 1e-3, "eta2": 2e-3, "D1": 0.2, "D2": 0.1,
    "F": 0.6, "E3": 1.7, "k3": 0.35, "d3": 0.55, "n3": 0.5, "w3": 0.8, "push3": 0.35, "g3": 1.0, "G3": 1.1, "c13": 0.03,
    "c31": 0.02, "c23": 0.04, "c32": 0.06, "eta3": 1.5e-3, "D3": 0.15, "m3": 55.0,
    "lambda": 0.8, "N": 1.3, "m1": 50.0, "m2": 60.0,
}  # fmt: skip
V: dict[str, Any] = {name: sp.Symbol(name, positive=True) for name in NUMBERS}
POINT = {V[name]: value for name, value in NUMBERS.items()}
METHOD = "SymPy: the evaluated code run on symbols"


def symbol(name: str) -> EvaluatedExpression:
    return EvaluatedExpression(V[name], NUMBERS[name])


def _row(*names: str) -> Any:
    """The formulas of these names as one time window: an array of shape (1, n)."""
    return np.array([[symbol(name) for name in names]], dtype=object)


def setting(n: int, coupled: bool = False) -> Setting:
    """A loop of one window and n components whose every number is a symbol; gains of their own where inputs are coupled. d is the
    least width of the window, n that of the window and the one before."""
    numbers = [str(i + 1) for i in range(n)]
    zero = EvaluatedExpression(sp.Integer(0), 0.0)
    cross = [[symbol(f"c{i}{j}") if coupled and i != j else zero for j in numbers] for i in numbers]
    eta = [symbol(f"eta{i}") for i in numbers]
    gain, limits = (
        np.array([symbol(f"k{i}" if coupled else "k") for i in numbers], dtype=object),
        _row(*(f"m{i}" for i in numbers))[0],
    )
    law: Any = Law(gain=gain, e_max=np.full(n, 0.999), shift=np.array(eta, dtype=object), u_max=limits, rounding=0.0, latency=0.0)
    law = replace(law, rounding=symbol("r"), latency=symbol("l"))
    nothing = np.zeros((1, n))
    widths, seen, rates = (_row(*(f"{name}{i}" for i in numbers)) for name in ("d", "n", "D"))
    windows = Windows(
        times=np.array([0.0, 1.0]),
        narrow=widths,
        wide=_row(*(f"w{i}" for i in numbers)),
        speed=nothing,
        widening=rates,
        low=nothing,
        high=nothing,
        start=nothing,
    )
    single: Any = [np.array([symbol(name)], dtype=object) for name in ("lambda", "N", "F")]
    least, most = (_row(*(f"{name}{i}" for i in numbers)) for name in ("g", "G"))
    push = _row(*(f"push{i}" for i in numbers))
    return Setting(
        windows=windows,
        law=law,
        least=least,
        most=most,
        cross=np.array([cross], dtype=object),
        push=push,
        narrow=seen,
        definite=single[0],
        norm=single[1],
        push_norm=single[2],
        start=nothing[0],
    )


def _pull(a: Any, b: Any) -> Any:
    return (1 / a + 1 / b) * sp.log(a / b)


def _q(e: Any) -> Any:
    return e * sp.cosh(e / 2) ** 2


def _q_rate(e: Any) -> Any:
    return sp.cosh(e / 2) ** 2 * (1 + e * sp.tanh(e / 2))


def _distances(width: Any, change: Any, reach: Any = None) -> tuple[Any, Any]:
    """Far and near distance at |eps| = E, the far one less and the near one more by a change."""
    e = V["E"] if reach is None else reach
    return width / (1 + sp.exp(-e)) - change, width / (1 + sp.exp(e)) + change


def _found(conditions: Any, k: int, place: tuple[int, ...]) -> Any:
    return np.asarray(conditions[k].values, dtype=object)[place].expression


def _prove_sharp_evaluated() -> Outcome:
    """Every component of a coupled loop, each with its E and its gain: U, P', c, then every condition in its order."""
    every = ("1", "2", "3")
    reach = np.array([symbol(f"E{at}") for at in every], dtype=object)
    conditions = STATEMENTS["sharp"].conditions(setting(len(every), coupled=True), reach, symbol("tau"))
    r, tau, late = V["r"], V["tau"], V["l"]
    inputs = {}
    for at in every:
        far, near = _distances(V[f"n{at}"], -V[f"eta{at}"], V[f"E{at}"])
        inputs[at] = V[f"k{at}"] * (_pull(far, near) + r * (1 / far + 1 / near)) * (1 + r)
    wanted: dict[str, Any] = {}
    for i, at in enumerate(every):
        push = V[f"push{at}"] + sum(V[f"c{at}{other}"] * inputs[other] for other in every if other != at)
        c = push * tau + V[f"G{at}"] * inputs[at] * late + V[f"eta{at}"]
        side = V[f"d{at}"] / 2 * (sp.tanh(V[f"E{at}"] / 2) - r) - (push + V[f"G{at}"] * inputs[at]) * tau - V[f"eta{at}"]
        claims = [side]
        for width in (V[f"d{at}"], V[f"w{at}"]):
            far, near = _distances(width, c, V[f"E{at}"])
            held = _pull(far, near) - r * (1 / far + 1 / near)
            claims += [far - near, V[f"k{at}"] * (1 - r) * V[f"g{at}"] * held - push]
        claims.append(V[f"m{at}"] * V[f"g{at}"] - push)
        names = ("same side", "a > b at d-", "inward at d-", "a > b at d+", "inward at d+", "saturated")
        places = (0, 2, 3, 4, 5, 1)
        wanted |= {
            f"{name}, component {at}": _found(conditions, j, (0, i)) - v for name, j, v in zip(names, places, claims, strict=True)
        }
    return all_of(prove_identities(wanted, METHOD, POINT), _windows())


def _windows() -> Outcome:
    """Each statement on three windows is, by window, the statement on that window alone; of widening, with the window before."""
    draw = np.random.default_rng(6)
    wrong: list[str] = []
    n, count = 2, 0

    def drawn(low: float, high: float, *shape: int) -> Any:
        return draw.uniform(low, high, shape)

    for statement, _ in itertools.product(("sharp", "diagonal", "general"), range(4)):
        narrow = drawn(0.4, 0.6, 3, n)
        nothing = np.zeros((3, n))
        windows = Windows(
            times=np.arange(3.0),
            narrow=narrow,
            wide=narrow + drawn(0, 0.5, 3, n),
            speed=nothing,
            widening=drawn(0, 0.4, 3, n),
            low=nothing,
            high=nothing,
            start=nothing,
        )
        law = Law(
            gain=np.full(n, 0.3),
            e_max=np.full(n, 0.999),
            shift=drawn(0, 1e-3, n),
            u_max=drawn(9, 99, n),
            rounding=1e-6,
            latency=3e-4,
        )
        cross = drawn(0, 0.1, 3, n, n) * (1 - np.eye(n))
        many = Setting(
            windows=windows,
            law=law,
            least=drawn(0.8, 1, 3, n),
            most=drawn(1, 1.2, 3, n),
            cross=cross,
            push=drawn(0.1, 0.5, 3, n),
            narrow=narrow - drawn(0, 0.1, 3, n),
            definite=drawn(0.8, 1, 3),
            norm=drawn(1, 1.2, 3),
            push_norm=drawn(0.2, 0.6, 3),
            start=np.zeros(n),
        )
        reach: Any = 1.9 if statement == "general" else np.array([2.0, 1.5])
        whole = STATEMENTS[statement].conditions(many, reach, 1e-3)
        for w in range(3):
            here = slice(w, w + 1)
            widening = np.maximum(windows.widening[here], windows.widening[max(w - 1, 0)])
            names = ("least", "most", "cross", "push", "narrow", "definite", "norm", "push_norm")
            one = replace(windows, narrow=narrow[here], wide=windows.wide[here], widening=widening)
            alone = replace(many, windows=one, **{name: getattr(many, name)[here] for name in names})
            for k, (a, b) in enumerate(zip(whole, STATEMENTS[statement].conditions(alone, reach, 1e-3), strict=True)):
                count += 1
                if not np.allclose(np.asarray(a.values, float)[here], np.asarray(b.values, float), rtol=1e-12, atol=0):
                    wrong.append(f"{statement}, condition {k}, window {w}: {a.values}, alone {b.values}")
    return outcome_of_cases(
        count, wrong, "conditions on three windows are, by window, those on it alone, to the roundings of a double"
    )


def _staleness(reach: Any, seen: Any, push: Any, g: Any, rate: Any, d: Any, eta: Any, root: Any = 1) -> tuple[Any, Any]:
    """U, and how far a held u is from the one of now: R tau, what eta adds at the steepest place that is seen, and rounding, one
    part of eps in each of root^2 components."""
    rounded = V["r"] * root * 4 * V["k"] * sp.cosh(seen / 2) ** 2 / d
    u = (4 * V["k"] * _q(seen) / d + rounded) * (1 + 2 * V["r"])
    moving = 16 * V["k"] * _q_rate(reach) * sp.cosh(reach / 2) ** 2 / d**2 * (push + g * u) + 4 * V["k"] * _q(reach) * rate / d**2
    steep = 16 * V["k"] * _q_rate(seen) * sp.cosh(seen / 2) ** 2 / d**2
    return u, moving * V["tau"] + steep * eta + V["r"] * u + rounded


def _prove_diagonal_evaluated() -> Outcome:
    conditions = STATEMENTS["diagonal"].conditions(setting(1), symbol("E"), symbol("tau"))
    far, near = _distances(V["n1"], -V["eta1"])
    u, stale = _staleness(V["E"], sp.log(far / near), V["push1"], V["G1"], V["D1"], V["n1"], V["eta1"])
    main = 4 * V["k"] * _q(V["E"]) / V["w1"] - stale - V["push1"] / V["g1"]
    coupled = STATEMENTS["diagonal"].conditions(setting(2, coupled=True), symbol("E"), symbol("tau"))
    others = {
        "u_max": (_least(conditions, 1), NUMBERS["m1"] - float(sp.N(u.subs(POINT)))),
        "g_min": (_least(conditions, 2), NUMBERS["g1"]),
        "decoupled": (_least(conditions, 4), 1e-300),
        "coupled": (_least(coupled, 4), -NUMBERS["c12"]),
    }
    inside = prove_identities(
        {"inward": _found(conditions, 0, (0, 0)) - main, "what is seen stays inside": _found(conditions, 3, (0, 0)) - near},
        METHOD,
        POINT,
    )
    return all_of(inside, _agree(others))


def _least(conditions: Any, k: int) -> float:
    """The least of a condition's values, at the point."""
    return min(float(v) for v in np.asarray(conditions[k].values, dtype=object).ravel())


def _agree(values: dict[str, tuple[float, float]]) -> Outcome:
    """Conditions that are numbers, against what they must be: to 1e-9, more than doubles lose of them."""
    wrong = [f"{name} is {a}, not {b}" for name, (a, b) in values.items() if not abs(a - b) <= 1e-9 * abs(b)]
    return outcome_of_cases(
        len(values), wrong, "the other conditions are what the statement asks, and fail where it says nothing"
    )


def _prove_general_evaluated() -> Outcome:
    """Two components of widths n1 < n2 and w1 < w2: the least and largest count. sqrt 2 is that of the code, rounded up."""
    conditions = STATEMENTS["general"].conditions(setting(2), symbol("E"), symbol("tau"))
    root = sp.Rational(Fraction(float(np.sqrt(2.0) * (1 + 1e-12))))
    far, near = _distances(V["n1"], -V["eta2"])
    seen = V["E"] + root * (sp.log(far / near) - V["E"])
    u, stale = _staleness(V["E"], seen, V["F"], V["N"], V["D1"], V["n1"], V["eta2"] * root, root)
    least = V["E"] * sp.cosh(V["E"] / (2 * root)) ** 2
    main = V["k"] * V["lambda"] * 4 / V["w2"] * least - V["F"] - V["N"] * stale
    apart = STATEMENTS["general"].conditions(setting(2, coupled=True), symbol("E"), symbol("tau"))
    others = {
        "u_max": (_least(conditions, 1), NUMBERS["m1"] - float(sp.N(u.subs(POINT)))),
        "g_s": (_least(conditions, 2), NUMBERS["lambda"]),
        "one gain": (_least(conditions, 4), 1.0),
        "two gains": (_least(apart, 4), -1.0),
    }
    inside = prove_identities(
        {"inward": _found(conditions, 0, (0,)) - main, "what is seen stays inside": _found(conditions, 3, (0,)) - near},
        METHOD,
        POINT,
    )
    return all_of(inside, _agree(others))


LEMMAS = (
    Lemma(
        "sampled.sharp_evaluated",
        "What the package evaluates for the sharp statement is that of sampled.sharp, .coupled, .shift and .saturated, with "
        "c = P' tau + G U l + eta and rounding r, relative and of eps.",
        r"k(1-r)g_{\min}\bigl(h(a,b) - r(\tfrac1a+\tfrac1b)\bigr) > P',\quad a,b = \tfrac{d}{1+e^{\mp E}} \mp c",
        ("n = 3; by component, so for every n", "windows one by one"),
        "the evaluated code",
        _prove_sharp_evaluated,
        ("sampled.sharp", "sampled.coupled", "sampled.shift", "sampled.saturated"),
    ),
    Lemma(
        "sampled.diagonal_evaluated",
        "For the diagonal statement: R tau with the U of what is seen, eta times the steepest slope of v there, and rounding.",
        r"\frac{4kq(E)}{d_+} > \frac{P}{g_{\min}} + R\tau + \frac{16kq'(E')\cosh^2(E'/2)}{d_-^2}\,\eta + r(\ldots)",
        ("E' = ln((d/(1 + e^-E) + eta)/(d/(1 + e^E) - eta)) at d-",),
        "the evaluated code",
        _prove_diagonal_evaluated,
        ("sampled.diagonal", "sampled.shift"),
    ),
    Lemma(
        "sampled.general_evaluated",
        "For the general statement the same in norms, E'' = E + sqrt(n) (E' - E) bounding the norm of what is seen.",
        r"\frac{4kg_{\min}q_n(E)}{d_+} > F+S + G\bigl(R\tau + \ldots\bigr)",
        ("n = 2, one window",),
        "the evaluated code",
        _prove_general_evaluated,
        ("sampled.general", "sampled.shift"),
    ),
)
