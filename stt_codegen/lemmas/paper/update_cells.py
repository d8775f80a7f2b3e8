"""Lemmas about the curves that enclose alpha: the code of `certify/adaptive/alpha_curves.py` run on symbols, cell by cell.

A curve u above alpha needs a slope of at least F(psi, u) wherever a step may end; below alpha, at most that. `share` and `decay`
include what rounding takes from a step, `speed_factor` the error of time. book.py takes LEMMAS as a part of the family `update`.

Long because each statement is about both curves, above and below, and a cell has three outcomes.
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

from stt_codegen.certify.adaptive import SLACK, Cell, Curve, alpha_curves, extremes_ahead
from stt_codegen.lemmas.evaluated_expression import EvaluatedExpression, recorded_comparisons
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities, prove_positive

METHOD = "SymPy: the evaluated code run on symbols"
NUMBERS = {
    "u": 0.25, "h": 0.125, "psi": 0.5, "theta": 0.5, "rho": 2.0**-18, "decay": 4.0, "rush": 1.0 + 2.0**-8, "reach": 0.0625,
    "R": 0.75, "kappa": 4.0, "least": 0.015625, "late": 2.0**-16,
}  # fmt: skip
V: dict[str, Any] = {name: sp.Symbol(name, real=True) if name == "psi" else sp.Symbol(name, positive=True) for name in NUMBERS}
PSI_VALUES = (0.5, -0.0625)  # one of either sign
S = sp.Rational(Fraction(SLACK))
u, h, psi, theta, share, decay, rush, reach, R = (V[k] for k in ("u", "h", "psi", "theta", "rho", "decay", "rush", "reach", "R"))


def _evaluated(name: str, value: float | None = None) -> EvaluatedExpression:
    return EvaluatedExpression(V[name], NUMBERS[name] if value is None else value)


@dataclass(frozen=True)
class CurveWithSymbolicRoot(Curve):
    """A curve whose `root` returns a symbol and records p and q of the cubic that it was called for."""

    root_arguments: Any = None
    root_value: float = 0.75

    def root(self, p: Any, q: Any) -> Any:
        self.root_arguments.append((p.expression, q.expression))
        return _evaluated("R", self.root_value)


def _curve(side: int, root_value: float = 0.75) -> CurveWithSymbolicRoot:
    return CurveWithSymbolicRoot(
        side, _evaluated("rho"), _evaluated("decay"), _evaluated("rush"), _evaluated("reach"), [], root_value
    )


def _rounded_speed(side: int) -> Any:
    """Return F at u, with the allowances for rounding that the code makes."""
    return theta / (psi + u * (1 - side * share)) ** 2 * (1 + side * S) - decay * u


def _prove_rounded() -> Outcome:
    """Prove that the curve's numbers are those of a step that is rounded.

    A step ends at a, rounded; unrounded at a (1 - side share) or nearer. With the step of (11) for that, (a - alpha)/dt is at
    most theta/z^2 - kappa a (1 - share) + share a/dt above, and at least the mirror of it below.
    """
    differences: dict[str, Any] = {}
    for side in (1, -1):
        steps: Any = SimpleNamespace(
            roundoff=_evaluated("rho") * Fraction(1, alpha_curves.STEP_ROUNDINGS),
            minimum=_evaluated("least"),
            late=_evaluated("late"),
            reach=_evaluated("reach"),
        )
        curve: Any = Curve.of(side, _evaluated("kappa"), steps)  # type: ignore[arg-type]
        loss = share if side > 0 else share / (1 - share)
        exact = -V["kappa"] * u * (1 - side * loss) + side * loss * u / V["least"]
        differences |= {
            f"side {side}: side": sp.sympify(curve.side) - side,
            f"side {side}: share": sp.cancel(curve.share.expression - loss),
            f"side {side}: -decay u": sp.cancel(-curve.decay.expression * u - exact * (1 - side * S)),
            f"side {side}: rush": curve.speed_factor.expression - (1 + 2 * V["late"] / V["least"] + S),
            f"side {side}: reach": curve.reach.expression - reach,
        }
    z = sp.Symbol("z", positive=True)
    small_share = z / (1 + z) / 2  # any share below a half
    return all_of(
        prove_identities(differences, METHOD),
        _check_steps(),
        prove_identities({"1/(1 - s) - (1 + s/(1 - s))": sp.cancel(1 / (1 - share) - (1 + share / (1 - share)))}),
        prove_positive(
            {
                "(1 + 2 s)(1 - s) - 1": sp.factor(sp.together((1 + 2 * small_share) * (1 - small_share) - 1)),
                "1 - (1 - 2 s)(1 + s)": sp.factor(sp.together(1 - (1 - 2 * small_share) * (1 + small_share))),
            }
        ),
    )


def _check_steps() -> Outcome:
    """Check that `Steps` rounds the longest step, with both of its ends late, up and the shortest down, each by 2^-38 at most."""
    failures: list[str] = []
    tolerance = 1 + Fraction(1, 1 << 38)
    inputs = list(product((Fraction(1, 1000), Fraction(1, 7)), (1, 40), (0.0, 1e-4), (2.0**-24, 2.0**-53)))
    for shortest, times, late, roundoff in inputs:
        steps = alpha_curves.Steps(shortest, shortest * times, late, roundoff)
        longest = steps.longest * (1 + 2 * Fraction(roundoff)) + 2 * Fraction(late)
        shortest_end = shortest * (1 - 2 * Fraction(roundoff))
        if not (
            longest <= Fraction(steps.reach) <= longest * tolerance
            and shortest_end / tolerance <= Fraction(steps.minimum) <= shortest_end
        ):
            failures.append(f"{steps}: {steps.minimum!r} to {steps.reach!r}")
    return outcome_of_cases(len(inputs), failures, "reach is above the longest step, least below the shortest")


def _prove_rises() -> Outcome:
    """Prove what `cell` returns for a curve that leads away from alpha.

    It moves at `speed_factor` times the speed F, or jumps to where F is 0 or points back; it jumps, too, where z <= 0.
    """
    differences: dict[str, Any] = {}
    failures: list[str] = []
    for side, is_far, psi_value in product((1, -1), (True, False), (*PSI_VALUES, -1.0)):
        if psi_value == -1.0 and (side < 0 or is_far):
            continue  # z <= 0 is possible above alpha alone, where the curve jumps
        # Below alpha F points down for a small force. far: the place of rest is beyond the end of the line.
        root_offsets = {(1, True): 60.0, (1, False): 0.26, (-1, True): 2.0**-12, (-1, False): 0.249}
        curve = _curve(side, root_value=psi_value + root_offsets[side, is_far])
        force = _evaluated("theta", 8.0 if side > 0 else 2.0**-6)
        after, promise, extreme = curve.cell(_evaluated("u"), _evaluated("h"), _evaluated("psi", psi_value), force)
        rest = (R - psi) * (1 + side * S) + side * S * (psi if psi_value > 0 else -psi)
        rest = rest * (1 + side * 2 * share)
        line = u + h * _rounded_speed(side) * rush * (1 + S)
        name = f"side {side}, {'line' if is_far else 'jump'}, psi {psi_value}"
        expected = (line, u, line) if is_far else (rest, rest, rest)
        for what, computed, form in zip(("end", "promise", "extreme"), (after, promise, extreme), expected, strict=True):
            differences[f"{name}: {what}"] = sp.expand(computed.expression - form)
        (p, q), *more = curve.root_arguments
        differences |= {f"{name}: p": p - psi, f"{name}: q": sp.cancel(q - theta / decay * (1 + side * S))}
        failures += [f"{name}: {len(more)} roots more"] if more else []
        curve_without_rest = _curve(side, root_value=psi_value - 0.25)  # psi + alpha < psi: no place of rest above 0
        failures += (
            [] if float(curve_without_rest.balance(_evaluated("psi", psi_value), force)) == 0 else [f"{name}: rests below 0"]
        )
    speed, y = sp.symbols("F y", positive=True)
    outside = (theta / R**2 - decay * (R - psi)).subs(theta, decay * (R - psi) * R**2 / (1 + S))
    return all_of(
        prove_identities(differences, METHOD),
        outcome_of_cases(9, failures, "one root for a place of rest, and none below 0"),
        prove_identities({"F at rest, plus decay (R - psi) S/(1 + S)": sp.cancel(outside + decay * (R - psi) * S / (1 + S))}),
        prove_positive({"h F rush (1 + S) - h F, rush = 1 + y": sp.expand(h * speed * (1 + y) * (1 + S) - h * speed)}),
    )


def _prove_falls() -> Outcome:
    """Prove what `cell` returns for a curve that leads back towards alpha: it goes no farther than an implicit step of the span.

    The span is positive for rush < 2, and rush (2 - rush) is 1 - (rush - 1)^2. So a step for which time passes `speed_factor`
    times as fast falls no more than one of its own length.
    """
    differences: dict[str, Any] = {}
    late_promises: dict[str, Any] = {}
    failures: list[str] = []
    for side, psi_value in (*product((1, -1), PSI_VALUES), (-1, -1.0)):
        name = f"side {side}, psi {psi_value}"
        force = _evaluated("theta", 2.0**-6 if side > 0 else 8.0)
        curve = _curve(side, root_value=psi_value + (0.2 if side > 0 else 0.3))
        after, promise, extreme = curve.cell(_evaluated("u"), _evaluated("h"), _evaluated("psi", psi_value), force)
        damping = (1 + (h + reach) * (2 - rush) * decay) * (1 - side * S)
        span = (h + reach) * (2 - rush)
        expected_promise = (R - psi) * (1 + side * 2 * share) * (1 + side * S) + side * S * (psi if psi_value > 0 else -psi)
        (p, q), *more = curve.root_arguments
        failures += [f"{name}: {len(more)} roots more"] if more else []
        differences |= {
            f"{name}: p": sp.cancel(p - psi - u / damping),
            f"{name}: q": sp.cancel(q - span * theta / damping),
            f"{name}: promise": sp.expand(promise.expression - expected_promise),
            f"{name}: slope": sp.cancel((after.expression - u) / h - (expected_promise - u) * (1 - S) / (h + reach)),
            f"{name}: extreme": extreme.expression - u,
        }
        # At the root theta is (R - p) R^2 damping/span; the slope to a = R - psi over the span is compared with F there.
        a = R - psi
        force_at_root = (a - u / damping) * R**2 * damping / span
        slope_less_F = sp.cancel((a - u) / span - (force_at_root / R**2 - decay * a))
        margin = side * S * a * (1 + span * decay) / span
        differences[f"{name}: slope over the span, less F, less what is spare"] = sp.cancel(slope_less_F - margin)
        # A root on the wrong side of u must not be promised.
        curve_with_late_root = _curve(side, root_value=psi_value + (4.5 if side > 0 else 2.0**-9))
        _, late_promise, _ = curve_with_late_root.cell(_evaluated("u"), _evaluated("h"), _evaluated("psi", psi_value), force)
        late_promises[f"{name}: a promise is never beyond u"] = late_promise.expression - u
    w = sp.Symbol("w", positive=True)
    rush_less_1 = w / (1 + w)  # rush - 1, from 0 to 1
    return all_of(
        prove_identities(differences, METHOD),
        prove_identities(late_promises, METHOD),
        outcome_of_cases(5, failures, "one root for a cell"),
        prove_identities({"rush (2 - rush) - 1 + (rush - 1)^2": sp.expand(rush * (2 - rush) - 1 + (rush - 1) ** 2)}),
        prove_positive({"span at rush = 1 + w/(1 + w)": sp.factor((h + reach) * (1 - rush_less_1))}),
        _check_hopeless_delay(),
    )


def _check_hopeless_delay() -> Outcome:
    """Check that nothing is claimed where a step may be late by half of its length."""
    curves = [alpha_curves.curve_values([0.0, 1.0], [0.1, 0.1], [1.0, 1.0], Curve(side, 0.0, 1.0, 2.0, 1.0)) for side in (1, -1)]
    return outcome_of_cases(
        2, [] if curves == [[float("inf")] * 2, [0.0] * 2] else [f"{curves}"], "rush >= 2: above all, above nothing"
    )


def _prove_root() -> Outcome:
    """Prove that `beyond` compared what it returns: (z - p) z^2 >= q above, <= q below, with an allowance for roundings.

    By update.unique such a z is beyond the root. Then the same is checked in exact numbers.
    """
    differences: dict[str, Any] = {}
    failures: list[str] = []
    p, q, z = (sp.Symbol(n, positive=True) for n in ("p", "q", "z"))
    for side, relative_offset in product((1, -1), (0.0, 1e-9)):
        curve = Curve(side, 0.0, 1.0, 1.0, 1.0)
        guess = 2.0 * (1 - side * relative_offset)
        with recorded_comparisons() as comparisons:
            bound = curve.beyond(EvaluatedExpression(z, guess), EvaluatedExpression(p, 1.0), EvaluatedExpression(q, 4.0))
        last = comparisons[-1]
        name = f"side {side}, a guess off by {relative_offset:g}"
        differences[f"{name}: left"] = sp.expand(last.left - (bound.expression - p) * bound.expression**2)
        differences[f"{name}: right"] = sp.expand(last.right - q * (1 + side * S / 8))
        failures += [] if last.holds else [f"{name}: the answer was no"]
        failures += [] if (bound.value - 2.0) * side > 0 else [f"{name}: {bound.value} is on the wrong side"]
    count = 4
    forces = (0.0, 1e-300, 1e-60, 1e-30, 1e-9, 0.3, 1.0, 7.0, 1e6)
    for side, size, force in product((1, -1), (0.0, 1e-6, 0.5, 3.0, 1e4), forces):
        for p_value in {size, -size}:
            curve = Curve(side, 0.0, 1.0, 1.0, 1.0)
            for is_beyond, root_bound in ((False, curve.root(p_value, force)), (True, curve.beyond(1e-5, p_value, force))):
                count += 1
                value = Fraction(root_bound)
                if value < Fraction(p_value) * (1 - Fraction(1, 1 << 30)) and not is_beyond:
                    failures.append(f"side {side}, p {p_value:g}, q {force:g}: {root_bound!r} is far below p")
                if side * ((value - Fraction(p_value)) * value * value - Fraction(force)) < 0:
                    failures.append(f"side {side}, p {p_value:g}, q {force:g}: {root_bound!r} is on the wrong side")
    return all_of(
        prove_identities(differences, METHOD),
        outcome_of_cases(count, failures, "the root's bound is on its side, in exact numbers"),
    )


@dataclass(frozen=True)
class CurveWithScriptedCells(Curve):
    """A curve whose cells are a list of (end, promise, extreme); it records the arguments u, h and theta of every call."""

    cells: Any = None
    calls: Any = None

    def cell(self, u: Any, h: Any, psi: Any, theta: Any) -> Cell:
        self.calls.append((u, h, theta))
        return Cell(*self.cells[int(psi)])

    def balance(self, psi: Any, theta: Any) -> Any:
        self.calls.append((psi, theta))
        return 2.5


def _prove_promise() -> Outcome:
    """Run `curve_values` on random cells.

    At the end of a cell the curve must be beyond the cell's end and every promise that is not yet over; the extreme must be
    beyond that of its cell and beyond both ends.
    """
    draw, failures, count = random.Random(1), [], 0
    for side, reach_, _ in product((1, -1), (0.125, 1.0, 2.5), range(20)):
        cells = [tuple(draw.uniform(-1, 3) for _ in range(3)) for _ in range(9)]
        times = [0.5 * k + draw.choice((0.0, 0.25)) for k in range(10)]
        curve = CurveWithScriptedCells(side, 0.0, 1.0, 1.0, reach_, cells, [])
        forces = [draw.random() for _ in range(10)]
        values = alpha_curves.curve_values(times, [*map(float, range(9)), 0.5], forces, curve)
        outer: Callable[..., float] = max if side > 0 else min
        expected: list[float] = []
        expected_calls: list[tuple[float, ...]] = []
        end = 0.0
        for k, (after, _kept, extreme) in enumerate(cells):
            expected_calls.append((end, times[k + 1] - times[k], forces[k]))
            alive = [cells[j][1] for j in range(k + 1) if times[j + 1] + reach_ >= times[k]]
            end = max(outer(after, *alive), 0.0)
            expected.append(outer(extreme, end))
        expected.append(outer(end, 2.5))
        expected_calls.append((0.5, forces[9]))
        count += 1
        if (values, curve.calls) != (expected, expected_calls):
            failures.append(f"side {side}, reach {reach_}: {values}, not {expected}")
    without_decay = alpha_curves.curve_values(
        [0.0, 1.0], [0.0, 0.0], [0.0, 0.0], CurveWithScriptedCells(1, 0.0, -1.0, 1.0, 1.0, [(1.0, 1.0, 1.0)], [])
    )
    failures += [] if without_decay == [float("inf")] * 2 else [f"without decay: {without_decay}"]
    return all_of(
        outcome_of_cases(count, failures, "promises are kept for as long as they hold, and no longer"),
        _check_both_curves(),
        _check_ahead(),
    )


def _check_both_curves() -> Outcome:
    """Check that `upper_curve` and `lower_curve` are the curves of either side, and that the lower one is not below 0."""
    steps = alpha_curves.Steps(Fraction(1, 100), Fraction(1, 20), 1e-5, 2.0**-24)
    times, psi, theta = [0.25 * k for k in range(13)], [0.3, 0.1, -0.05, 0.2] * 3, [0.02, 0.2, 0.4, 0.1] * 3
    curve_inputs = times, [*psi, 0.3], [*theta, 0.1]
    above, below = (alpha_curves.curve_values(*curve_inputs, Curve.of(side, 5.0, steps)) for side in (1, -1))
    failures = [] if alpha_curves.upper_curve(*curve_inputs, 5.0, steps) == above else ["upper_curve"]
    failures += [] if alpha_curves.lower_curve(*curve_inputs, 5.0, steps) == [max(v, 0.0) for v in below] else ["lower_curve"]
    failures += [f"{a} under {b}" for a, b in zip(above, below, strict=True) if a < b]
    return outcome_of_cases(3, failures, "one curve above, one below, in this order")


def _check_ahead() -> Outcome:
    """Compare `extremes_ahead` with the worst of all cells that overlap a cell or the `reach` seconds beyond it."""
    draw, failures, count = random.Random(2), [], 0
    for reach_, largest in product((0.0, 0.5, 1.25), (True, False)):
        for _ in range(10):
            times = np.cumsum([0.0, *(draw.choice((0.25, 0.5, 1.0)) for _ in range(8))])
            values = np.array([[draw.uniform(-1, 1)] for _ in range(8)])
            computed = extremes_ahead(times, values, reach_, largest)[:, 0].tolist()
            choose = max if largest else min
            expected = [choose(values[j, 0] for j in range(k, 8) if times[j] <= times[k + 1] + reach_) for k in range(8)]
            count += 1
            if computed != expected:
                failures.append(f"reach {reach_}: {computed}, not {expected}")
    return outcome_of_cases(count, failures, "the worst of a cell and of what lies within reach beyond it")


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
