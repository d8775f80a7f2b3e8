"""The sampled statements as sampling/statements.py evaluates them: its very code, run on formulas, is what sampled.py proves
things about, with all that noise, latency and rounding add.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen.lemmas.lemma import Lemma, Outcome, identity
from stt_codegen.sampling import STATEMENTS, Law, Setting, Windows


@dataclass(frozen=True)
class Formula:
    """A SymPy expression with a number, in the place of a double: NumPy calculates with it, comparisons go by the number."""

    form: Any
    number: float

    def __float__(self) -> float:
        return self.number

    def exp(self) -> Formula:
        return Formula(sp.exp(self.form), float(np.exp(self.number)))

    def log(self) -> Formula:
        return Formula(sp.log(self.form), float(np.log(self.number)))

    def cosh(self) -> Formula:
        return Formula(sp.cosh(self.form), float(np.cosh(self.number)))

    def tanh(self) -> Formula:
        return Formula(sp.tanh(self.form), float(np.tanh(self.number)))

    def __neg__(self) -> Formula:
        return Formula(-self.form, -self.number)

    def __add__(self, other: Any) -> Any:
        return _join(self, other, lambda a, b: a + b)

    def __radd__(self, other: Any) -> Any:
        return _join(other, self, lambda a, b: a + b)

    def __sub__(self, other: Any) -> Any:
        return _join(self, other, lambda a, b: a - b)

    def __rsub__(self, other: Any) -> Any:
        return _join(other, self, lambda a, b: a - b)

    def __mul__(self, other: Any) -> Any:
        return _join(self, other, lambda a, b: a * b)

    def __rmul__(self, other: Any) -> Any:
        return _join(other, self, lambda a, b: a * b)

    def __truediv__(self, other: Any) -> Any:
        return _join(self, other, lambda a, b: a / b)

    def __rtruediv__(self, other: Any) -> Any:
        return _join(other, self, lambda a, b: a / b)

    def __pow__(self, power: int) -> Formula:
        return Formula(self.form**power, self.number**power)

    def __lt__(self, other: Any) -> bool:
        return self.number < float(other)

    def __gt__(self, other: Any) -> bool:
        return self.number > float(other)

    def __le__(self, other: Any) -> bool:
        return self.number <= float(other)

    def __ge__(self, other: Any) -> bool:
        return self.number >= float(other)


def _exact(value: Any) -> Any:
    return value.form if isinstance(value, Formula) else sp.Rational(Fraction(float(value)))


def _join(a: Any, b: Any, operation: Callable[[Any, Any], Any]) -> Any:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return NotImplemented
    return Formula(operation(_exact(a), _exact(b)), operation(float(a), float(b)))


NUMBERS = {
    "E": 2.0, "E1": 2.0, "E2": 1.5, "k1": 0.3, "k2": 0.4,
    "tau": 1e-3, "l": 3e-4, "k": 0.3, "r": 1e-5, "d1": 0.5, "d2": 0.6, "w1": 0.7, "w2": 0.9, "P1": 0.4, "P2": 0.3,
    "g1": 0.9, "g2": 1.1, "G1": 1.0, "G2": 1.2, "c12": 0.1, "c21": 0.05, "eta1": 1e-3, "eta2": 2e-3, "D1": 0.2, "D2": 0.1,
    "F": 0.6, "lambda": 0.8, "N": 1.3, "m1": 50.0, "m2": 60.0,
}  # fmt: skip
V: dict[str, Any] = {name: sp.Symbol(name, positive=True) for name in NUMBERS}
POINT = {V[name]: value for name, value in NUMBERS.items()}
METHOD = "SymPy: the evaluated code run on symbols"


def _f(name: str) -> Formula:
    return Formula(V[name], NUMBERS[name])


def _row(*names: str) -> Any:
    """The formulas of these names as one time window: an array of shape (1, n)."""
    return np.array([[_f(name) for name in names]], dtype=object)


def setting(n: int, coupled: bool = False) -> Setting:
    """A loop of one window and n components whose every number is a symbol; gains of their own where inputs are coupled."""
    numbers = [str(i + 1) for i in range(n)]
    zero = Formula(sp.Integer(0), 0.0)
    cross = [[_f(f"c{i}{j}") if coupled and i != j else zero for j in numbers] for i in numbers]
    eta = [_f(f"eta{i}") for i in numbers]
    gain, limits = (
        np.array([_f(f"k{i}" if coupled else "k") for i in numbers], dtype=object),
        _row(*(f"m{i}" for i in numbers))[0],
    )
    law: Any = Law(gain, np.full(n, 0.999), np.array(eta, dtype=object), limits, 0.0, 0.0)
    law = replace(law, rounding=_f("r"), latency=_f("l"))
    nothing = np.zeros((1, n))
    widths, rates = (_row(*(f"{name}{i}" for i in numbers)) for name in ("d", "D"))
    windows = Windows(np.array([0.0, 1.0]), widths, _row(*(f"w{i}" for i in numbers)), nothing, rates, nothing, nothing, nothing)
    single: Any = [np.array([_f(name)], dtype=object) for name in ("lambda", "N", "F")]
    least, most = (_row(*(f"{name}{i}" for i in numbers)) for name in ("g", "G"))
    push = _row(*(f"P{i}" for i in numbers))
    return Setting(
        windows, law, least, most, np.array([cross], dtype=object), push, widths, single[0], single[1], single[2], nothing[0]
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
    return np.asarray(conditions[k].values, dtype=object)[place].form


def _sharp() -> Outcome:
    """Both components of a coupled loop, each with its E and its gain: U, P', c, then every condition in its order."""
    reach = np.array([_f("E1"), _f("E2")], dtype=object)
    conditions = STATEMENTS["sharp"].conditions(setting(2, coupled=True), reach, _f("tau"))
    r, tau, late = V["r"], V["tau"], V["l"]
    inputs = []
    for name in ("1", "2"):
        far, near = _distances(V[f"d{name}"], -V[f"eta{name}"], V[f"E{name}"])
        inputs.append(V[f"k{name}"] * (_pull(far, near) + r * (1 / far + 1 / near)) * (1 + r))
    wanted: dict[str, Any] = {}
    for i, other in (0, 1), (1, 0):
        at = str(i + 1)
        push = V[f"P{at}"] + V[f"c{at}{other + 1}"] * inputs[other]
        c = push * tau + V[f"G{at}"] * inputs[i] * late + V[f"eta{at}"]
        side = V[f"d{at}"] / 2 * (sp.tanh(V[f"E{at}"] / 2) - r) - (push + V[f"G{at}"] * inputs[i]) * tau - V[f"eta{at}"]
        claims = [side]
        for width in (V[f"d{at}"], V[f"w{at}"]):
            far, near = _distances(width, c, V[f"E{at}"])
            held = _pull(far, near) - r * (1 / far + 1 / near)
            claims += [far - near, V[f"k{at}"] * (1 - r) * V[f"g{at}"] * held - push]
        claims.append(V[f"m{at}"] * V[f"g{at}"] - push)
        names = ("same side", "a > b at d-", "inward at d-", "a > b at d+", "inward at d+", "saturated")
        wanted |= {
            f"{name}, component {at}": _found(conditions, j, (0, i)) - v
            for j, (name, v) in enumerate(zip(names, claims, strict=True))
        }
    return identity(wanted, METHOD, POINT)


def _staleness(reach: Any, seen: Any, push: Any, g: Any, rate: Any, d: Any, eta: Any, root: Any = 1) -> tuple[Any, Any]:
    """U, and how far a held u is from the one of now: R tau, what eta adds at the steepest place that is seen, and rounding, one
    part of eps in each of root^2 components."""
    rounded = V["r"] * root * 4 * V["k"] * sp.cosh(seen / 2) ** 2 / d
    u = (4 * V["k"] * _q(seen) / d + rounded) * (1 + 2 * V["r"])
    moving = 16 * V["k"] * _q_rate(reach) * sp.cosh(reach / 2) ** 2 / d**2 * (push + g * u) + 4 * V["k"] * _q(reach) * rate / d**2
    steep = 16 * V["k"] * _q_rate(seen) * sp.cosh(seen / 2) ** 2 / d**2
    return u, moving * V["tau"] + steep * eta + V["r"] * u + rounded


def _diagonal() -> Outcome:
    conditions = STATEMENTS["diagonal"].conditions(setting(1), _f("E"), _f("tau"))
    far, near = _distances(V["d1"], -V["eta1"])
    _, stale = _staleness(V["E"], sp.log(far / near), V["P1"], V["G1"], V["D1"], V["d1"], V["eta1"])
    main = 4 * V["k"] * _q(V["E"]) / V["w1"] - stale - V["P1"] / V["g1"]
    return identity(
        {"inward": _found(conditions, 0, (0, 0)) - main, "what is seen stays inside": _found(conditions, 3, (0, 0)) - near},
        METHOD,
        POINT,
    )


def _general() -> Outcome:
    """Two components of widths d1 < d2 and w1 < w2: the least and largest count. sqrt 2 is that of the code, rounded up."""
    conditions = STATEMENTS["general"].conditions(setting(2), _f("E"), _f("tau"))
    root = sp.Rational(Fraction(float(np.sqrt(2.0) * (1 + 1e-12))))
    far, near = _distances(V["d1"], -V["eta2"])
    seen = V["E"] + root * (sp.log(far / near) - V["E"])
    _, stale = _staleness(V["E"], seen, V["F"], V["N"], V["D1"], V["d1"], V["eta2"] * root, root)
    least = V["E"] * sp.cosh(V["E"] / (2 * root)) ** 2
    main = V["k"] * V["lambda"] * 4 / V["w2"] * least - V["F"] - V["N"] * stale
    return identity(
        {"inward": _found(conditions, 0, (0,)) - main, "what is seen stays inside": _found(conditions, 3, (0,)) - near},
        METHOD,
        POINT,
    )


LEMMAS = (
    Lemma(
        "sampled.sharp_evaluated",
        "What the package evaluates for the sharp statement is that of sampled.sharp, .coupled, .shift and .saturated, with "
        "c = P' tau + G U l + eta and rounding r, relative and of eps.",
        r"k(1-r)g_{\min}\bigl(h(a,b) - r(\tfrac1a+\tfrac1b)\bigr) > P',\quad a,b = \tfrac{d}{1+e^{\mp E}} \mp c",
        ("n = 2, one window; by component, so for every n",),
        "the evaluated code",
        _sharp,
    ),
    Lemma(
        "sampled.diagonal_evaluated",
        "For the diagonal statement: R tau with the U of what is seen, eta times the steepest slope of v there, and rounding.",
        r"\frac{4kq(E)}{d_+} > \frac{P}{g_{\min}} + R\tau + \frac{16kq'(E')\cosh^2(E'/2)}{d_-^2}\,\eta + r(\ldots)",
        ("E' = ln((d/(1 + e^-E) + eta)/(d/(1 + e^E) - eta)) at d-",),
        "the evaluated code",
        _diagonal,
    ),
    Lemma(
        "sampled.general_evaluated",
        "For the general statement the same in norms, E'' = E + sqrt(n) (E' - E) bounding the norm of what is seen.",
        r"\frac{4kg_{\min}q_n(E)}{d_+} > F+S + G\bigl(R\tau + \ldots\bigr)",
        ("n = 2, one window",),
        "the evaluated code",
        _general,
    ),
)
