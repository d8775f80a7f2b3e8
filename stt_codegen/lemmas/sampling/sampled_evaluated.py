"""Lemmas about the evaluated sampling conditions: the code of sampling/sampling_conditions.py computes what sampled.py proves.

The code itself is run on symbols, so the lemmas include what noise, latency and rounding add. book.py takes LEMMAS as a part of
the family `sampled`; sampled_exact.py uses the loop of symbols, too.

Long because three kinds of condition are written out as formulas, beside a loop in which every number is a symbol.
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
from stt_codegen.sampling import SAMPLING_CONDITIONS, SampledLaw, SampledLoop, Windows

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
TEST_POINT = {V[name]: value for name, value in NUMBERS.items()}
METHOD = "SymPy: the evaluated code run on symbols"


def symbol(name: str) -> EvaluatedExpression:
    return EvaluatedExpression(V[name], NUMBERS[name])


def _row(*names: str) -> Any:
    """Return the symbols of these names as the row of one time window: an array of shape (1, n)."""
    return np.array([[symbol(name) for name in names]], dtype=object)


def setting(n: int, coupled: bool = False) -> SampledLoop:
    """Return a loop of one window and n components in which every number is a symbol.

    Where inputs are coupled, components have different gains. d is the smallest width of the window, n that of the window and
    the one before.
    """
    numbers = [str(i + 1) for i in range(n)]
    zero = EvaluatedExpression(sp.Integer(0), 0.0)
    cross = [[symbol(f"c{i}{j}") if coupled and i != j else zero for j in numbers] for i in numbers]
    eta = [symbol(f"eta{i}") for i in numbers]
    gain, limits = (
        np.array([symbol(f"k{i}" if coupled else "k") for i in numbers], dtype=object),
        _row(*(f"m{i}" for i in numbers))[0],
    )
    law: Any = SampledLaw(
        gain=gain, e_max=np.full(n, 0.999), shift=np.array(eta, dtype=object), u_max=limits, rounding=0.0, latency=0.0
    )
    law = replace(law, rounding=symbol("r"), latency=symbol("l"))
    zeros = np.zeros((1, n))
    widths, window_pair_widths, rates = (_row(*(f"{name}{i}" for i in numbers)) for name in ("d", "n", "D"))
    windows = Windows(
        times=np.array([0.0, 1.0]),
        narrow=widths,
        wide=_row(*(f"w{i}" for i in numbers)),
        speed=zeros,
        widening=rates,
        low=zeros,
        high=zeros,
        start=zeros,
    )
    norms: Any = [np.array([symbol(name)], dtype=object) for name in ("lambda", "N", "F")]
    smallest_gain, largest_gain = (_row(*(f"{name}{i}" for i in numbers)) for name in ("g", "G"))
    push = _row(*(f"push{i}" for i in numbers))
    return SampledLoop(
        windows=windows,
        law=law,
        diagonal_min=smallest_gain,
        diagonal_max=largest_gain,
        cross=np.array([cross], dtype=object),
        closing_speed=push,
        narrow=window_pair_widths,
        eigenvalue_min=norms[0],
        norm=norms[1],
        closing_speed_norm=norms[2],
        start=zeros[0],
    )


def _law_over_gain(a: Any, b: Any) -> Any:
    return (1 / a + 1 / b) * sp.log(a / b)


def _q(e: Any) -> Any:
    return e * sp.cosh(e / 2) ** 2


def _q_rate(e: Any) -> Any:
    return sp.cosh(e / 2) ** 2 * (1 + e * sp.tanh(e / 2))


def _distances(width: Any, change: Any, reach: Any = None) -> tuple[Any, Any]:
    """Return the distances to both edges at |eps| = E: the far one less the change, the near one plus the change."""
    e = V["E"] if reach is None else reach
    return width / (1 + sp.exp(-e)) - change, width / (1 + sp.exp(e)) + change


def _condition_expression(conditions: Any, k: int, index: tuple[int, ...]) -> Any:
    return np.asarray(conditions[k].values, dtype=object)[index].expression


def _prove_sharp_evaluated() -> Outcome:
    """Compare every condition of a coupled loop of three components, each with its E and its gain, with the proved one."""
    components = ("1", "2", "3")
    reach = np.array([symbol(f"E{i}") for i in components], dtype=object)
    conditions = SAMPLING_CONDITIONS["sharp"].conditions(setting(len(components), coupled=True), reach, symbol("tau"))
    r, tau, latency = V["r"], V["tau"], V["l"]
    U = {}
    for i in components:
        far, near = _distances(V[f"n{i}"], -V[f"eta{i}"], V[f"E{i}"])
        U[i] = V[f"k{i}"] * (_law_over_gain(far, near) + r * (1 / far + 1 / near)) * (1 + r)
    differences: dict[str, Any] = {}
    for index, i in enumerate(components):
        push = V[f"push{i}"] + sum(V[f"c{i}{j}"] * U[j] for j in components if j != i)
        c = push * tau + V[f"G{i}"] * U[i] * latency + V[f"eta{i}"]
        same_side = V[f"d{i}"] / 2 * (sp.tanh(V[f"E{i}"] / 2) - r) - (push + V[f"G{i}"] * U[i]) * tau - V[f"eta{i}"]
        claims = [same_side]
        for width in (V[f"d{i}"], V[f"w{i}"]):
            far, near = _distances(width, c, V[f"E{i}"])
            h = _law_over_gain(far, near) - r * (1 / far + 1 / near)
            claims += [far - near, V[f"k{i}"] * (1 - r) * V[f"g{i}"] * h - push]
        claims.append(V[f"m{i}"] * V[f"g{i}"] - push)
        names = ("same side", "a > b at d-", "inward at d-", "a > b at d+", "inward at d+", "saturated")
        order = (0, 2, 3, 4, 5, 1)
        differences |= {
            f"{name}, component {i}": _condition_expression(conditions, k, (0, index)) - v
            for name, k, v in zip(names, order, claims, strict=True)
        }
    return all_of(prove_identities(differences, METHOD, TEST_POINT), _check_windows())


def _random_setting(generator: np.random.Generator, n: int) -> SampledLoop:
    """Return a loop of three windows and n components with random numbers."""

    def random_array(low: float, high: float, *shape: int) -> Any:
        return generator.uniform(low, high, shape)

    narrow = random_array(0.4, 0.6, 3, n)
    zeros = np.zeros((3, n))
    windows = Windows(
        times=np.arange(3.0),
        narrow=narrow,
        wide=narrow + random_array(0, 0.5, 3, n),
        speed=zeros,
        widening=random_array(0, 0.4, 3, n),
        low=zeros,
        high=zeros,
        start=zeros,
    )
    law = SampledLaw(
        gain=np.full(n, 0.3),
        e_max=np.full(n, 0.999),
        shift=random_array(0, 1e-3, n),
        u_max=random_array(9, 99, n),
        rounding=1e-6,
        latency=3e-4,
    )
    cross = random_array(0, 0.1, 3, n, n) * (1 - np.eye(n))
    return SampledLoop(
        windows=windows,
        law=law,
        diagonal_min=random_array(0.8, 1, 3, n),
        diagonal_max=random_array(1, 1.2, 3, n),
        cross=cross,
        closing_speed=random_array(0.1, 0.5, 3, n),
        narrow=narrow - random_array(0, 0.1, 3, n),
        eigenvalue_min=random_array(0.8, 1, 3),
        norm=random_array(1, 1.2, 3),
        closing_speed_norm=random_array(0.2, 0.6, 3),
        start=np.zeros(n),
    )


def _on_one_window(setting: SampledLoop, k: int) -> SampledLoop:
    """Return the loop on window k alone, with the larger widening of that window and the one before."""
    windows, window = setting.windows, slice(k, k + 1)
    widening = np.maximum(windows.widening[window], windows.widening[max(k - 1, 0)])
    window_alone = replace(windows, narrow=windows.narrow[window], wide=windows.wide[window], widening=widening)
    names = ("diagonal_min", "diagonal_max", "cross", "closing_speed", "narrow", "eigenvalue_min", "norm", "closing_speed_norm")
    return replace(setting, windows=window_alone, **{name: getattr(setting, name)[window] for name in names})


def _check_windows() -> Outcome:
    """Check on random loops that the conditions on three windows are, by window, those on that window alone."""
    generator = np.random.default_rng(6)
    failures: list[str] = []
    count = 0
    for statement, _ in itertools.product(("sharp", "diagonal", "general"), range(4)):
        setting = _random_setting(generator, 2)
        reach: Any = 1.9 if statement == "general" else np.array([2.0, 1.5])
        conditions = SAMPLING_CONDITIONS[statement].conditions(setting, reach, 1e-3)
        for k in range(3):
            conditions_alone = SAMPLING_CONDITIONS[statement].conditions(_on_one_window(setting, k), reach, 1e-3)
            for j, (a, b) in enumerate(zip(conditions, conditions_alone, strict=True)):
                count += 1
                values, values_alone = np.asarray(a.values, float)[k : k + 1], np.asarray(b.values, float)
                if not np.allclose(values, values_alone, rtol=1e-12, atol=0):
                    failures.append(f"{statement}, condition {j}, window {k}: {a.values}, alone {b.values}")
    return outcome_of_cases(
        count, failures, "conditions on three windows are, by window, those on it alone, to the roundings of a double"
    )


def _held_input_error(
    *, reach: Any, E_measured: Any, push: Any, g: Any, rate: Any, d: Any, eta: Any, root: Any = 1
) -> tuple[Any, Any]:
    """Return U, and a bound on the difference between a held u and the present one.

    The bound is R tau, what eta adds where v is steepest within E_measured, and rounding, one part of eps in each of root^2
    components.
    """
    rounding = V["r"] * root * 4 * V["k"] * sp.cosh(E_measured / 2) ** 2 / d
    u = (4 * V["k"] * _q(E_measured) / d + rounding) * (1 + 2 * V["r"])
    rate_of_v = (
        16 * V["k"] * _q_rate(reach) * sp.cosh(reach / 2) ** 2 / d**2 * (push + g * u) + 4 * V["k"] * _q(reach) * rate / d**2
    )
    steep = 16 * V["k"] * _q_rate(E_measured) * sp.cosh(E_measured / 2) ** 2 / d**2
    return u, rate_of_v * V["tau"] + steep * eta + V["r"] * u + rounding


def _prove_diagonal_evaluated() -> Outcome:
    """Compare the diagonal conditions of one component with the proved ones, and check that they refuse coupled inputs."""
    conditions = SAMPLING_CONDITIONS["diagonal"].conditions(setting(1), symbol("E"), symbol("tau"))
    far, near = _distances(V["n1"], -V["eta1"])
    u, error = _held_input_error(
        reach=V["E"], E_measured=sp.log(far / near), push=V["push1"], g=V["G1"], rate=V["D1"], d=V["n1"], eta=V["eta1"]
    )
    inward = 4 * V["k"] * _q(V["E"]) / V["w1"] - error - V["push1"] / V["g1"]
    coupled = SAMPLING_CONDITIONS["diagonal"].conditions(setting(2, coupled=True), symbol("E"), symbol("tau"))
    numbers = {
        "u_max": (_smallest_value(conditions, 1), NUMBERS["m1"] - float(sp.N(u.subs(TEST_POINT)))),
        "g_min": (_smallest_value(conditions, 2), NUMBERS["g1"]),
        "decoupled": (_smallest_value(conditions, 4), 1e-300),
        "coupled": (_smallest_value(coupled, 4), -NUMBERS["c12"]),
    }
    inside = prove_identities(
        {
            "inward": _condition_expression(conditions, 0, (0, 0)) - inward,
            "what is seen stays inside": _condition_expression(conditions, 3, (0, 0)) - near,
        },
        METHOD,
        TEST_POINT,
    )
    return all_of(inside, _compare_numbers(numbers))


def _smallest_value(conditions: Any, k: int) -> float:
    """Return the smallest of a condition's values at the point."""
    return min(float(v) for v in np.asarray(conditions[k].values, dtype=object).ravel())


def _compare_numbers(values: dict[str, tuple[float, float]]) -> Outcome:
    """Compare numbers (computed, expected) by name, to 1e-9 of the expected one, which is more than the error of doubles."""
    failures = [f"{name} is {a}, not {b}" for name, (a, b) in values.items() if not abs(a - b) <= 1e-9 * abs(b)]
    return outcome_of_cases(
        len(values), failures, "the other conditions are what the statement asks, and fail where it says nothing"
    )


def _prove_general_evaluated() -> Outcome:
    """Compare the general condition for two components of widths n1 < n2 and w1 < w2; sqrt 2 is rounded up as in the code."""
    conditions = SAMPLING_CONDITIONS["general"].conditions(setting(2), symbol("E"), symbol("tau"))
    root = sp.Rational(Fraction(float(np.sqrt(2.0) * (1 + 1e-12))))
    far, near = _distances(V["n1"], -V["eta2"])
    E_measured = V["E"] + root * (sp.log(far / near) - V["E"])
    u, error = _held_input_error(
        reach=V["E"], E_measured=E_measured, push=V["F"], g=V["N"], rate=V["D1"], d=V["n1"], eta=V["eta2"] * root, root=root
    )
    q_n = V["E"] * sp.cosh(V["E"] / (2 * root)) ** 2
    inward = V["k"] * V["lambda"] * 4 / V["w2"] * q_n - V["F"] - V["N"] * error
    coupled = SAMPLING_CONDITIONS["general"].conditions(setting(2, coupled=True), symbol("E"), symbol("tau"))
    numbers = {
        "u_max": (_smallest_value(conditions, 1), NUMBERS["m1"] - float(sp.N(u.subs(TEST_POINT)))),
        "g_s": (_smallest_value(conditions, 2), NUMBERS["lambda"]),
        "one gain": (_smallest_value(conditions, 4), 1.0),
        "two gains": (_smallest_value(coupled, 4), -1.0),
    }
    inside = prove_identities(
        {
            "inward": _condition_expression(conditions, 0, (0,)) - inward,
            "what is seen stays inside": _condition_expression(conditions, 3, (0,)) - near,
        },
        METHOD,
        TEST_POINT,
    )
    return all_of(inside, _compare_numbers(numbers))


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
