"""The curves that enclose alpha (`certify/adaptive/alpha_curves.py`): its own code run on symbols, cell by cell.

A curve u above alpha needs a slope of at least F(psi, u) wherever a step may end; below alpha at most. What rounding takes from a
step is in `share` and `decay`, what time is late by in `rush`.

Long because both curves, above and below, are told of one cell, and a cell has three outcomes.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen.certify.adaptive import SLACK, Cell, Curve, ahead, alpha_curves
from stt_codegen.lemmas.evaluated_expression import EvaluatedExpression, recorded_comparisons
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities, prove_positive

METHOD = "SymPy: the evaluated code run on symbols"
NUMBERS = {
    "u": 0.25, "h": 0.125, "psi": 0.5, "theta": 0.5, "rho": 2.0**-18, "decay": 4.0, "rush": 1.0 + 2.0**-8, "reach": 0.0625,
    "R": 0.75, "kappa": 4.0, "least": 0.015625, "late": 2.0**-16,
}  # fmt: skip
V: dict[str, Any] = {name: sp.Symbol(name, real=True) if name == "psi" else sp.Symbol(name, positive=True) for name in NUMBERS}
PSI = (0.5, -0.0625)  # psi of either sign
S = sp.Rational(Fraction(SLACK))
u, h, psi, theta, share, decay, rush, reach, R = (V[k] for k in ("u", "h", "psi", "theta", "rho", "decay", "rush", "reach", "R"))


def _f(name: str, number: float | None = None) -> EvaluatedExpression:
    return EvaluatedExpression(V[name], NUMBERS[name] if number is None else number)


@dataclass(frozen=True)
class Rooted(Curve):
    """A curve of which the root is a symbol; asked: what it was the root of."""

    asked: Any = None
    at: float = 0.75

    def root(self, p: Any, q: Any) -> Any:
        self.asked.append((p.expression, q.expression))
        return _f("R", self.at)


def _curve(side: int, at: float = 0.75) -> Rooted:
    return Rooted(side, _f("rho"), _f("decay"), _f("rush"), _f("reach"), [], at)


def _speed(side: int) -> Any:
    """F at u, with what rounding adds."""
    return theta / (psi + u * (1 - side * share)) ** 2 * (1 + side * S) - decay * u


def _prove_rounded() -> Outcome:
    """A step ends at a, rounded; unrounded at a (1 - side share) or nearer. With (11)'s step for that: (a - alpha)/dt is at most
    theta/z^2 - kappa a (1 - share) + share a/dt above, and at least the mirror of it below."""
    found: dict[str, Any] = {}
    for side in (1, -1):
        steps: Any = SimpleNamespace(
            roundoff=_f("rho") * Fraction(1, alpha_curves.STEP_ROUNDINGS), least=_f("least"), late=_f("late"), reach=_f("reach")
        )
        made: Any = Curve.of(side, _f("kappa"), steps)  # type: ignore[arg-type]
        taken = share if side > 0 else share / (1 - share)
        exact = -V["kappa"] * u * (1 - side * taken) + side * taken * u / V["least"]
        found |= {
            f"side {side}: side": sp.sympify(made.side) - side,
            f"side {side}: share": sp.cancel(made.share.expression - taken),
            f"side {side}: -decay u": sp.cancel(-made.decay.expression * u - exact * (1 - side * S)),
            f"side {side}: rush": made.rush.expression - (1 + 2 * V["late"] / V["least"] + S),
            f"side {side}: reach": made.reach.expression - reach,
        }
    z = sp.Symbol("z", positive=True)
    few = z / (1 + z) / 2  # any share below a half
    return all_of(
        prove_identities(found, METHOD),
        _steps(),
        prove_identities({"1/(1 - s) - (1 + s/(1 - s))": sp.cancel(1 / (1 - share) - (1 + share / (1 - share)))}),
        prove_positive(
            {
                "(1 + 2 s)(1 - s) - 1": sp.factor(sp.together((1 + 2 * few) * (1 - few) - 1)),
                "1 - (1 - 2 s)(1 + s)": sp.factor(sp.together(1 - (1 - 2 * few) * (1 + few))),
            }
        ),
    )


def _steps() -> Outcome:
    """The longest step with both of its ends late, the shortest as rounding may leave it: on the safe side, by 2^-38 at most."""
    wrong: list[str] = []
    more = 1 + Fraction(1, 1 << 38)
    tried = list(product((Fraction(1, 1000), Fraction(1, 7)), (1, 40), (0.0, 1e-4), (2.0**-24, 2.0**-53)))
    for shortest, times, late, roundoff in tried:
        steps = alpha_curves.Steps(shortest, shortest * times, late, roundoff)
        longest = steps.longest * (1 + 2 * Fraction(roundoff)) + 2 * Fraction(late)
        least = shortest * (1 - 2 * Fraction(roundoff))
        if not (longest <= Fraction(steps.reach) <= longest * more and least / more <= Fraction(steps.least) <= least):
            wrong.append(f"{steps}: {steps.least!r} to {steps.reach!r}")
    return outcome_of_cases(len(tried), wrong, "reach is above the longest step, least below the shortest")


def _prove_rises() -> Outcome:
    """Away from alpha: at the speed F, `rush` times, or with a jump to where F is 0 or points back; a jump, too, where z <= 0."""
    found: dict[str, Any] = {}
    wrong: list[str] = []
    for side, far, at in product((1, -1), (True, False), (*PSI, -1.0)):
        if at == -1.0 and (side < 0 or far):
            continue  # z <= 0: alpha is below, and the curve above it jumps
        # below alpha F points down: a small force. far: the place of rest is farther out than a line gets
        places = {(1, True): 60.0, (1, False): 0.26, (-1, True): 2.0**-12, (-1, False): 0.249}
        curve = _curve(side, at=at + places[side, far])
        force = _f("theta", 8.0 if side > 0 else 2.0**-6)
        after, kept, extreme = curve.cell(_f("u"), _f("h"), _f("psi", at), force)
        rest = (R - psi) * (1 + side * S) + side * S * (psi if at > 0 else -psi)
        rest = rest * (1 + side * 2 * share)
        line = u + h * _speed(side) * rush * (1 + S)
        name = f"side {side}, {'line' if far else 'jump'}, psi {at}"
        wanted = (line, u, line) if far else (rest, rest, rest)
        for what, got, form in zip(("end", "promise", "extreme"), (after, kept, extreme), wanted, strict=True):
            found[f"{name}: {what}"] = sp.expand(got.expression - form)
        (p, q), *more = curve.asked
        found |= {f"{name}: p": p - psi, f"{name}: q": sp.cancel(q - theta / decay * (1 + side * S))}
        wrong += [f"{name}: {len(more)} roots more"] if more else []
        nowhere = _curve(side, at=at - 0.25)  # psi + alpha < psi: no place of rest above 0
        wrong += [] if float(nowhere.balance(_f("psi", at), force)) == 0 else [f"{name}: rests below 0"]
    speed, y = sp.symbols("F y", positive=True)
    outside = (theta / R**2 - decay * (R - psi)).subs(theta, decay * (R - psi) * R**2 / (1 + S))
    return all_of(
        prove_identities(found, METHOD),
        outcome_of_cases(9, wrong, "one root for a place of rest, and none below 0"),
        prove_identities({"F at rest, plus decay (R - psi) S/(1 + S)": sp.cancel(outside + decay * (R - psi) * S / (1 + S))}),
        prove_positive({"h F rush (1 + S) - h F, rush = 1 + y": sp.expand(h * speed * (1 + y) * (1 + S) - h * speed)}),
    )


def _prove_falls() -> Outcome:
    """Back towards alpha: no farther than an implicit step of the whole span would, and no faster. span is positive for rush < 2,
    and rush (2 - rush) is 1 - (rush - 1)^2: a step that passes `rush` times as fast falls no more than its own length does."""
    found: dict[str, Any] = {}
    ends: dict[str, Any] = {}
    wrong: list[str] = []
    for side, at in (*product((1, -1), PSI), (-1, -1.0)):
        name = f"side {side}, psi {at}"
        force = _f("theta", 2.0**-6 if side > 0 else 8.0)
        curve = _curve(side, at=at + (0.2 if side > 0 else 0.3))
        after, kept, extreme = curve.cell(_f("u"), _f("h"), _f("psi", at), force)
        damping = (1 + (h + reach) * (2 - rush) * decay) * (1 - side * S)
        span = (h + reach) * (2 - rush)
        least = (R - psi) * (1 + side * 2 * share) * (1 + side * S) + side * S * (psi if at > 0 else -psi)
        (p, q), *more = curve.asked
        wrong += [f"{name}: {len(more)} roots more"] if more else []
        found |= {
            f"{name}: p": sp.cancel(p - psi - u / damping),
            f"{name}: q": sp.cancel(q - span * theta / damping),
            f"{name}: promise": sp.expand(kept.expression - least),
            f"{name}: slope": sp.cancel((after.expression - u) / h - (least - u) * (1 - S) / (h + reach)),
            f"{name}: extreme": extreme.expression - u,
        }
        # at the root theta = (R - p) R^2 damping/span: the slope to a = R - psi over the span, less F there
        a = R - psi
        forced = (a - u / damping) * R**2 * damping / span
        rest = sp.cancel((a - u) / span - (forced / R**2 - decay * a))
        spare = side * S * a * (1 + span * decay) / span
        found[f"{name}: slope over the span, less F, less what is spare"] = sp.cancel(rest - spare)
        held = _curve(side, at=at + (4.5 if side > 0 else 2.0**-9))  # a root on the wrong side of u is not kept to
        _, promise, _ = held.cell(_f("u"), _f("h"), _f("psi", at), force)
        ends[f"{name}: a promise is never beyond u"] = promise.expression - u
    w = sp.Symbol("w", positive=True)
    slow = w / (1 + w)  # rush - 1, from 0 to 1
    return all_of(
        prove_identities(found, METHOD),
        prove_identities(ends, METHOD),
        outcome_of_cases(5, wrong, "one root for a cell"),
        prove_identities({"rush (2 - rush) - 1 + (rush - 1)^2": sp.expand(rush * (2 - rush) - 1 + (rush - 1) ** 2)}),
        prove_positive({"span at rush = 1 + w/(1 + w)": sp.factor((h + reach) * (1 - slow))}),
        _hopeless(),
    )


def _hopeless() -> Outcome:
    """Where a step may be late by half of its length nothing is claimed."""
    found = [alpha_curves.curve_values([0.0, 1.0], [0.1, 0.1], [1.0, 1.0], Curve(side, 0.0, 1.0, 2.0, 1.0)) for side in (1, -1)]
    return outcome_of_cases(
        2, [] if found == [[float("inf")] * 2, [0.0] * 2] else [f"{found}"], "rush >= 2: above all, above nothing"
    )


def _prove_root() -> Outcome:
    """What is returned was asked for: (z - p) z^2 >= q above, <= q below, with room for the roundings of that; update.unique says
    that this is beyond the root. Then in exact numbers."""
    found: dict[str, Any] = {}
    wrong: list[str] = []
    p, q, z = (sp.Symbol(n, positive=True) for n in ("p", "q", "z"))
    for side, off in product((1, -1), (0.0, 1e-9)):
        curve = Curve(side, 0.0, 1.0, 1.0, 1.0)
        near = 2.0 * (1 - side * off)
        with recorded_comparisons() as asked:
            found_at = curve.beyond(EvaluatedExpression(z, near), EvaluatedExpression(p, 1.0), EvaluatedExpression(q, 4.0))
        last = asked[-1]
        name = f"side {side}, a guess off by {off:g}"
        found[f"{name}: left"] = sp.expand(last.left - (found_at.expression - p) * found_at.expression**2)
        found[f"{name}: right"] = sp.expand(last.right - q * (1 + side * S / 8))
        wrong += [] if last.holds else [f"{name}: the answer was no"]
        wrong += [] if (found_at.value - 2.0) * side > 0 else [f"{name}: {found_at.value} is on the wrong side"]
    count = 4
    tried = (0.0, 1e-300, 1e-60, 1e-30, 1e-9, 0.3, 1.0, 7.0, 1e6)
    for side, size, force in product((1, -1), (0.0, 1e-6, 0.5, 3.0, 1e4), tried):
        for at in {size, -size}:
            curve = Curve(side, 0.0, 1.0, 1.0, 1.0)
            for far, given in ((False, curve.root(at, force)), (True, curve.beyond(1e-5, at, force))):
                count += 1
                value = Fraction(given)
                if value < Fraction(at) * (1 - Fraction(1, 1 << 30)) and not far:
                    wrong.append(f"side {side}, p {at:g}, q {force:g}: {given!r} is far below p")
                if side * ((value - Fraction(at)) * value * value - Fraction(force)) < 0:
                    wrong.append(f"side {side}, p {at:g}, q {force:g}: {given!r} is on the wrong side")
    return all_of(
        prove_identities(found, METHOD), outcome_of_cases(count, wrong, "the root's bound is on its side, in exact numbers")
    )


@dataclass(frozen=True)
class Scripted(Curve):
    """A curve whose cells are given: end, promise, extreme; asked: where each began, how long it is, and theta."""

    cells: Any = None
    asked: Any = None

    def cell(self, u: Any, h: Any, psi: Any, theta: Any) -> Cell:
        self.asked.append((u, h, theta))
        return Cell(*self.cells[int(psi)])

    def balance(self, psi: Any, theta: Any) -> Any:
        self.asked.append((psi, theta))
        return 2.5


def _prove_promise() -> Outcome:
    """`curve_values` on cells that are drawn: at the end of a cell it is beyond the cell's end and every promise not yet over;
    an extreme is beyond its cell's and beyond both ends."""
    draw, wrong, count = random.Random(1), [], 0
    for side, reach_, _ in product((1, -1), (0.125, 1.0, 2.5), range(20)):
        cells = [tuple(draw.uniform(-1, 3) for _ in range(3)) for _ in range(9)]
        times = [0.5 * k + draw.choice((0.0, 0.25)) for k in range(10)]
        curve = Scripted(side, 0.0, 1.0, 1.0, reach_, cells, [])
        forces = [draw.random() for _ in range(10)]
        values = alpha_curves.curve_values(times, [*map(float, range(9)), 0.5], forces, curve)
        outer: Callable[..., float] = max if side > 0 else min
        expected: list[float] = []
        asked: list[tuple[float, ...]] = []
        end = 0.0
        for k, (after, _kept, extreme) in enumerate(cells):
            asked.append((end, times[k + 1] - times[k], forces[k]))
            alive = [cells[j][1] for j in range(k + 1) if times[j + 1] + reach_ >= times[k]]
            end = max(outer(after, *alive), 0.0)
            expected.append(outer(extreme, end))
        expected.append(outer(end, 2.5))
        asked.append((0.5, forces[9]))
        count += 1
        if (values, curve.asked) != (expected, asked):
            wrong.append(f"side {side}, reach {reach_}: {values}, not {expected}")
    lost = alpha_curves.curve_values([0.0, 1.0], [0.0, 0.0], [0.0, 0.0], Scripted(1, 0.0, -1.0, 1.0, 1.0, [(1.0, 1.0, 1.0)], []))
    wrong += [] if lost == [float("inf")] * 2 else [f"without decay: {lost}"]
    return all_of(outcome_of_cases(count, wrong, "promises are kept for as long as they hold, and no longer"), _both(), _ahead())


def _both() -> Outcome:
    """`upper_curve` and `lower_curve` are the curves of either side, and the lower one is not below 0."""
    steps = alpha_curves.Steps(Fraction(1, 100), Fraction(1, 20), 1e-5, 2.0**-24)
    times, psi, theta = [0.25 * k for k in range(13)], [0.3, 0.1, -0.05, 0.2] * 3, [0.02, 0.2, 0.4, 0.1] * 3
    given = times, [*psi, 0.3], [*theta, 0.1]
    above, below = (alpha_curves.curve_values(*given, Curve.of(side, 5.0, steps)) for side in (1, -1))
    wrong = [] if alpha_curves.upper_curve(*given, 5.0, steps) == above else ["upper_curve"]
    wrong += [] if alpha_curves.lower_curve(*given, 5.0, steps) == [max(v, 0.0) for v in below] else ["lower_curve"]
    wrong += [f"{a} under {b}" for a, b in zip(above, below, strict=True) if a < b]
    return outcome_of_cases(3, wrong, "one curve above, one below, in this order")


def _ahead() -> Outcome:
    """`ahead` against every cell that has a moment in common with the cell and `reach` seconds beyond it."""
    draw, wrong, count = random.Random(2), [], 0
    for reach_, largest in product((0.0, 0.5, 1.25), (True, False)):
        for _ in range(10):
            times = np.cumsum([0.0, *(draw.choice((0.25, 0.5, 1.0)) for _ in range(8))])
            values = np.array([[draw.uniform(-1, 1)] for _ in range(8)])
            got = ahead(times, values, reach_, largest)[:, 0].tolist()
            choose = max if largest else min
            wanted = [choose(values[j, 0] for j in range(k, 8) if times[j] <= times[k + 1] + reach_) for k in range(8)]
            count += 1
            if got != wanted:
                wrong.append(f"reach {reach_}: {got}, not {wanted}")
    return outcome_of_cases(count, wrong, "the worst of a cell and of what lies within reach beyond it")


LEMMAS = (
    Lemma(
        "update.rounded",
        "What rounding does to an emitted step is in the curve's share and decay, what time is late by in its rush.",
        r"\frac{a-\alpha}{\Delta t} \le \frac{\theta}{(\psi + a(1-s))^2} - \Bigl(\kappa(1-s) - \frac{s}{\Delta t}\Bigr)a",
        ("a relative error of at most s in a step", "dt at least the shortest"),
        "the evaluated code",
        _prove_rounded,
    ),
    Lemma(
        "update.root",
        "The root of an implicit step is bounded on the right side: what is returned was verified.",
        r"(z-p)z^2 \ge q \text{ above},\ \le q \text{ below}",
        ("four roundings of a double in what is compared",),
        "the evaluated code",
        _prove_root,
        ("update.unique",),
    ),
    Lemma(
        "update.rises",
        "A curve that leads away from alpha is as fast as (11) where it begins, or jumps to where (11) points back.",
        r"\dot u \ge F(\psi, u)",
        ("F falls in u and in psi (update.jacobian)",),
        "the evaluated code",
        _prove_rises,
        ("update.jacobian", "update.rounded", "update.root"),
    ),
    Lemma(
        "update.falls",
        "A curve that leads back towards alpha is no faster than (11) at what it promises to stay beyond.",
        r"\dot u \ge F(\psi, u_{\min}),\quad \frac{u_{\min}-u}{h+\text{reach}} \ge F(\psi, u_{\min})",
        ("F falls in u and in psi (update.jacobian)",),
        "the evaluated code",
        _prove_falls,
        ("update.jacobian", "update.cubic", "update.rounded", "update.root"),
    ),
    Lemma(
        "update.promise",
        "What a cell promises for the reach beyond it, later cells keep.",
        r"u(t) \ge u_{\min} \text{ for } t \le t_k + \text{reach}",
        (),
        "the evaluated code",
        _prove_promise,
        ("update.rises", "update.falls"),
    ),
)
