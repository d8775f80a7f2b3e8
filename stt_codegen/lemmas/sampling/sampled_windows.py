"""Lemmas about the numbers of tube, plant and law that the sampled statements and P9 use, computed on symbols.

book.py takes LEMMAS as a part of the family `sampled`. Long because it is about both kinds of number, doubles with their
roundings and fractions.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise, permutations, product
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp
from flint import arb, ctx

from stt_codegen.designs import LOWER, UPPER, RefinedDesign
from stt_codegen.lemmas.evaluated_expression import EvaluatedExpression
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases, prove_identities
from stt_codegen.program import FORMATS, round_down
from stt_codegen.sampling import (
    FRACTIONS,
    Bounds,
    Fractions,
    SampledLaw,
    SampledLoop,
    Windows,
    extremes,
    first_order_loop,
    in_balls,
    law_of,
    refined_windows,
    start_bound_of_share,
)
from stt_codegen.task import Task

OUTWARD_ROUNDING = Fraction(1, 10**9) + Fraction(1, 1 << 50)  # relative: of doubles at most, and the rounding of that


class TaskNumbers(SimpleNamespace):
    """The numbers of a task that its law reads, which no file could spell; what a task derives from them it derives here too."""

    emitted_u_max = Task.emitted_u_max
    largest_coordinate = Task.largest_coordinate


@dataclass(frozen=True)
class BezierTube:
    """A refined tube given by its Bezier coefficients (K, n, 2, 4), which may be symbols.

    seam: the first segment of the cycle, where the tube repeats itself.
    """

    coefficients: Any
    prescribed_time: Fraction
    unit: Fraction
    seam: int | None = None

    windows = RefinedDesign.windows
    largest_steps = RefinedDesign.largest_steps

    @property
    def segments(self) -> int:
        return len(self.coefficients)

    def bezier(self) -> Any:
        return self.coefficients


def sample_tubes() -> Iterator[BezierTube]:
    """Yield tubes of one segment, with lower coefficients and widths in every order, then tubes of several segments."""
    orders = list(permutations(range(4)))
    for low, wide in zip(orders, orders[::-1], strict=True):
        high = [a + 9 + 2.5 * w for a, w in zip(low, wide, strict=True)]
        yield _tube_on_symbols(np.array([[[low, high]]], dtype=float), Fraction(3, 2))
    rising = np.arange(32, dtype=float).reshape(2, 2, 2, 4)
    yield _tube_on_symbols(rising + np.sin(rising) / 2, Fraction(10))
    many = np.arange(48.0).reshape(6, 1, 2, 4)
    longer = _tube_on_symbols(many * 7 % 31 + np.array([[0.0], [40.0]]) + np.sin(many), Fraction(5))
    yield longer
    yield replace(longer, seam=2)
    yield _tube_on_symbols(40 - rising + np.sin(3 * rising), Fraction(7, 3))


def _tube_on_symbols(numbers: Any, seconds: Fraction) -> BezierTube:
    symbols = np.array(sp.symbols(f"beta0:{numbers.size}", real=True), dtype=object).reshape(numbers.shape)
    make = np.vectorize(EvaluatedExpression, otypes=[object])
    return BezierTube(make(symbols, numbers), seconds, Fraction(1, 8))


def _expected_extremes(tube: BezierTube) -> dict[str, Any]:
    """Return by name the entries (K + 1, n) that the windows must have, in units of the table."""
    coefficients = tube.coefficients
    segments, n = len(coefficients), coefficients.shape[1]
    result: dict[str, list[list[Any]]] = {k: [] for k in ("narrow", "wide", "step", "width_step", "low", "high")}
    for k, i in product(range(segments + 1), range(n)):
        end = [coefficients[-1, i, side, 3] for side in (LOWER, UPPER)]
        segment = tube.seam if k == segments else k  # from t_c on the cycle's first segment follows, or the tube is at rest
        low, high = ([end[s]] * 4 if segment is None else list(coefficients[segment, i, s]) for s in (LOWER, UPPER))
        width = [b - a for a, b in zip(low, high, strict=True)]
        steps = [b - a for edge in (low, high) for a, b in pairwise(edge)]
        expected = {
            "narrow": min(width, key=float), "wide": max(width, key=float), "low": min(low, key=float),
            "high": max(high, key=float), "step": _largest_size(steps),
            "width_step": _largest_size([b - a for a, b in pairwise(width)]),
        }  # fmt: skip
        for name, value in expected.items():
            result[name].append(value.expression)
    return result


def _largest_size(values: list[EvaluatedExpression]) -> EvaluatedExpression:
    largest = max(values, key=lambda v: abs(v.value))
    return largest if largest.value >= 0 else -largest


def _bezier_rate() -> Outcome:
    """Prove that the slope of a cubic is the quadratic of three times its coefficients' differences."""
    s, beta = sp.Symbol("s", real=True), sp.symbols("beta0:4", real=True)
    curve = sum(sp.binomial(3, j) * s**j * (1 - s) ** (3 - j) * b for j, b in enumerate(beta))
    slope = sum(sp.binomial(2, j) * s**j * (1 - s) ** (2 - j) * 3 * (beta[j + 1] - beta[j]) for j in range(3))
    return prove_identities({"slope less its Bezier form": sp.expand(sp.diff(curve, s) - slope)})


def _prove_windows() -> Outcome:
    """Compare both forms with the expected extremes: in units of the table for P9, and in doubles, with rates rounded outward."""
    differences: dict[str, Any] = {}
    failures: list[str] = []
    count = 0
    for number, symbolic_tube in enumerate(sample_tubes()):
        tube: Any = symbolic_tube
        expected, extremes_in_units, windows = _expected_extremes(symbolic_tube), extremes(tube), refined_windows(tube)
        rate = Fraction(3 * symbolic_tube.segments) / symbolic_tube.prescribed_time * symbolic_tube.unit
        unit = sp.Rational(symbolic_tube.unit)
        windows_in_doubles = {"narrow": windows.narrow, "wide": windows.wide, "low": windows.low, "high": windows.high}
        for name, expressions in expected.items():
            pairs = zip(expressions, getattr(extremes_in_units, name).ravel(), strict=True)
            differences |= {f"{name} {number}.{j}": expression - v.expression for j, (expression, v) in enumerate(pairs)}
        for name, values in windows_in_doubles.items():
            pairs = zip(expected[name], values.ravel(), strict=True)
            differences |= {
                f"{name} {number}.{j}, doubles": sp.Rational(symbolic_tube.unit) * expression - v.expression
                for j, (expression, v) in enumerate(pairs)
            }
        for name, values in (("step", windows.speed), ("width_step", windows.widening)):
            for expression, v in zip(expected[name], values.ravel(), strict=True):
                count += 1
                share = sp.cancel(v.expression / expression) if expression != 0 else None
                if (
                    (v.expression != 0)
                    if share is None
                    else not (rate <= Fraction(str(share)) <= rate * (1 + Fraction(1, 1 << 40)))
                ):
                    failures.append(f"{name} is {v.expression}, not {rate} times {expression}")
        starts = zip(symbolic_tube.coefficients[0, :, :, 0].ravel(), windows.start.ravel(), strict=True)
        differences |= {f"start {number}.{j}": unit * a.expression - b.expression for j, (a, b) in enumerate(starts)}
        ends = [float(symbolic_tube.prescribed_time) * k / symbolic_tube.segments for k in range(symbolic_tube.segments + 1)]
        count += 1
        if not np.allclose(windows.times, ends, rtol=1e-15, atol=0):
            failures.append(f"windows end at {windows.times}, not at {ends}")
    return all_of(
        _bezier_rate(),
        prove_identities(differences, "SymPy: the evaluated code run on symbols, lower coefficients and widths in every order"),
        outcome_of_cases(count, failures, "rates in doubles are at least 3 K/t_c times the differences, and at most 2^-40 more"),
    )


class _OnSymbols(Fractions):
    """Fractions for symbols; norms, which these lemmas do not use, are 0."""

    def root_above(self, value: Any) -> Any:
        return 0 * value


def _prove_exact_windows() -> Outcome:
    """Compare windows and setting in fractions with those of the segment, and the worse of it and of the one before.

    The plant bounds are 0 here, so that the push is the edges' speed.
    """
    failures: list[str] = []
    differences: dict[str, Any] = {}
    zero = np.array([Fraction(0)], dtype=object)
    for number, symbolic_tube in enumerate(sample_tubes()):
        tube: Any = symbolic_tube
        unit, rate = (
            sp.Rational(symbolic_tube.unit),
            sp.Rational(Fraction(3 * symbolic_tube.segments) / symbolic_tube.prescribed_time * symbolic_tube.unit),
        )
        narrow, wide, step = (getattr(extremes(tube), name) for name in ("narrow", "wide", "step"))
        n = narrow.shape[1]
        law: Any = SimpleNamespace(numbers=_OnSymbols())
        no_bounds = Bounds(
            disturbance=zero,
            diagonal_min=zero,
            diagonal_max=zero,
            cross=zero,
            disturbance_norm=Fraction(0),
            eigenvalue_min=Fraction(0),
            norm=Fraction(0),
        )
        setting = first_order_loop(
            refined_windows(tube, law.numbers), [no_bounds] * (symbolic_tube.segments + 1), law, np.zeros(n)
        )
        ends = [symbolic_tube.prescribed_time * k / symbolic_tube.segments for k in range(symbolic_tube.segments + 1)]
        failures += [] if len(setting.narrow) == len(tube.windows()) else [f"{len(setting.narrow)} windows"]
        failures += [] if setting.windows.times.tolist() == ends else [f"windows end at {setting.windows.times}, not at {ends}"]
        for k, i in product(range(symbolic_tube.segments + 1), range(n)):
            before = max(k - 1, 0)
            expected = {
                "narrow": (setting.windows.narrow, unit * narrow[k, i].expression),
                "narrow_seen": (setting.narrow, unit * min(narrow[k, i], narrow[before, i], key=float).expression),
                "wide": (setting.windows.wide, unit * wide[k, i].expression),
                "speed": (setting.closing_speed, rate * max(step[k, i], step[before, i], key=float).expression),
            }
            differences |= {
                f"{name} {number}.{k}.{i}": getattr(a[k, i], "expression", a[k, i]) - b for name, (a, b) in expected.items()
            }
    return all_of(
        prove_identities(differences, "SymPy: the evaluated code run on symbols, lower coefficients and widths in every order"),
        outcome_of_cases(number + 1, failures, "a window for every segment, and one from t_c on"),
    )


class SafeSideChecks:
    """Counts comparisons of computed numbers with exact ones, and lists those that are not on the safe side, or far from it."""

    def __init__(self) -> None:
        self.count = 0
        self.failures: list[str] = []

    def require_safe(self, name: str, computed: Any, exact: Any, upward: bool = True) -> None:
        """Compare arrays: computed must be at least exact, or at most with upward=False, and within OUTWARD_ROUNDING of it."""
        for a, b in zip(np.ravel(computed).tolist(), np.ravel(exact).tolist(), strict=True):
            excess = (Fraction(a) - Fraction(b)) * (1 if upward else -1)
            self.require(0 <= excess <= Fraction(b) * OUTWARD_ROUNDING, f"{name} is {float(a)}, not {float(b)}")

    def require(self, holds: bool, failure: str) -> None:
        self.count += 1
        self.failures += [] if holds else [failure]


def _prove_setting() -> Outcome:
    """Check that all numbers of a setting are on the safe side of those of task and windows, by 1e-9 of them at most."""
    checks = SafeSideChecks()
    for scalar, noise, limit in product(("float", "double"), (0.0, 0.03), (None, (Fraction(1, 3), Fraction(2)))):
        law = _check_law(checks, scalar, noise, limit)
        low = np.arange(16.0).reshape(2, 2, 4) * 7 % 5
        edges = np.stack([low, low + 3 + np.arange(16.0).reshape(2, 2, 4) * 5 % 7], axis=2)
        tube: Any = BezierTube(edges, Fraction(3), Fraction(1))
        windows = refined_windows(tube)
        for power in (1, -1):
            setting = _check_bounds(checks, windows, law, power)
            _check_copies(checks, setting)
    return outcome_of_cases(
        checks.count, checks.failures, "what the sampling conditions use is on the safe side, by 1e-9 of it at most"
    )


def _check_law(checks: SafeSideChecks, scalar: str, noise: float, limit: tuple[Fraction, ...] | None) -> SampledLaw:
    """Compare the law of a task of two components with the task's own numbers, in doubles and in fractions."""
    ends: Any = ((Fraction(-7, 3), Fraction(0)), (Fraction(1), Fraction(2)))
    ends = ends if noise else (tuple(-v for v in ends[1]), tuple(-v for v in ends[0]))  # the largest |x| at either end
    box = SimpleNamespace(lower=ends[0], upper=ends[1])
    emit = SimpleNamespace(scalar=scalar, math="libm")
    task: Any = TaskNumbers(
        dimension=2, order=1, state_space=box, emit=emit, gain=(Fraction(1, 3), Fraction(-2, 7)),
        e_max=(Fraction(9, 10),) * 2, u_max=limit, plant=SimpleNamespace(noise=Fraction(noise)),
    )  # fmt: skip
    error = (Fraction(1, 977), Fraction(1, 1013))
    law = law_of(task, error, noise, 0.25)
    shift = [2 * e + FORMATS[scalar].roundoff * Fraction(7, 3) + Fraction(noise) for e in error]
    checks.require_safe("shift", law.shift, np.array(shift, dtype=object))
    differences = _differences_in_fractions(task, law_of(task, error, Fraction(noise), Fraction(1, 4), FRACTIONS), shift)
    checks.count += 1
    checks.failures += differences
    gain = np.array([abs(v) for v in task.gain], dtype=object)
    checks.require_safe("gain", law.gain * (1 + 2.0**-52), gain)  # the nearest double; law.rounding includes that rounding
    checks.require_safe("e_max", law.e_max, [float(v) for v in task.e_max])
    checks.require_safe("eps at the clamp", law.eps_at_clamp, [float(_eps(v)) for v in task.e_max])
    share_eps = np.array([_eps(Fraction(9, 10))] * 2, dtype=object)
    checks.require_safe("eps of the share", start_bound_of_share(Fraction(9, 10), 2), share_eps)
    limits = [float(round_down(v, scalar)) for v in limit or ()]
    checks.require_safe("u_max", law.u_max[np.isfinite(law.u_max)], limits, upward=False)
    is_exact = law.latency == 0.25 and law.rounding >= 32 * FORMATS[scalar].roundoff
    checks.require(is_exact, f"latency {law.latency}, rounding {law.rounding}")
    return law


def _check_bounds(checks: SafeSideChecks, windows: Windows, law: SampledLaw, power: int) -> SampledLoop:
    """Compare a setting with the worse of two windows, for plant bounds that grow (power 1) or shrink (-1) with the window."""
    sizes = [(k + 1.0) ** power for k in range(3)]
    bounds = [_scaled_bounds(size) for size in sizes]
    setting = first_order_loop(windows, bounds, law, np.zeros(2))
    speed = np.maximum(windows.speed, windows.speed[[0, 0, 1]])
    checks.require_safe("push", setting.closing_speed, speed + [b.disturbance for b in bounds])
    checks.require_safe("narrow", setting.narrow, np.minimum(windows.narrow, windows.narrow[[0, 0, 1]]), upward=False)
    push_norm = np.sqrt((speed**2).sum(axis=1)) + [b.disturbance_norm for b in bounds]
    checks.require_safe("push_norm", setting.closing_speed_norm, push_norm)
    checks.require_safe("g_min", setting.diagonal_min, [b.diagonal_min for b in bounds], upward=False)
    checks.require_safe("g_max", setting.diagonal_max, [b.diagonal_max for b in bounds])
    checks.require_safe("g_ij", setting.cross, [b.cross for b in bounds])
    norms = [[b.eigenvalue_min for b in bounds], [b.norm for b in bounds]]
    checks.require_safe("of the whole", [setting.eigenvalue_min, setting.norm], norms)
    return setting


def _scaled_bounds(size: float) -> Bounds:
    """Return plant bounds of two components, those of the disturbance and of g_ij in proportion to the size."""
    push = np.array([0.5, 0.25]) * size
    cross = np.array([[0.0, size], [2 * size, 0.0]])
    return Bounds(
        disturbance=push,
        diagonal_min=push / 2,
        diagonal_max=push * 3,
        cross=cross,
        disturbance_norm=0.75 * size,
        eigenvalue_min=0.5,
        norm=2.0,
    )


def _check_copies(checks: SafeSideChecks, setting: SampledLoop) -> None:
    """Check that the setting in balls and that of its second component have the setting's own numbers."""
    balls, component = in_balls(setting), setting.component(1)
    for name in (
        "diagonal_min",
        "diagonal_max",
        "cross",
        "closing_speed",
        "narrow",
        "eigenvalue_min",
        "norm",
        "closing_speed_norm",
    ):
        in_doubles = [float(v) for v in np.ravel(getattr(balls, name))]
        checks.require_safe(f"{name} in balls", in_doubles, np.ravel(getattr(setting, name)))
    for name in ("narrow", "wide", "speed", "widening"):
        values = getattr(setting.windows, name)
        in_doubles = [float(v) for v in np.ravel(getattr(balls.windows, name))]
        checks.require_safe(f"{name} in balls", in_doubles, values.ravel())
        checks.require_safe(f"{name} of one component", getattr(component.windows, name)[:, 0], values[:, 1])
    for name in ("diagonal_min", "diagonal_max", "closing_speed", "narrow"):
        checks.require_safe(f"{name} of one component", getattr(component, name)[:, 0], getattr(setting, name)[:, 1])
    checks.require_safe("gain in balls", [float(v) for v in balls.law.gain], setting.law.gain)


def _differences_in_fractions(task: Any, law: SampledLaw, shift: list[Fraction]) -> list[str]:
    """Return where the law in fractions differs from the task."""
    u_max = [math.inf] * task.dimension if task.u_max is None else [round_down(v, task.emit.scalar) for v in task.u_max]
    rho_max = [(1 + v) / (1 - v) for v in task.e_max]
    expected = [shift, [abs(v) for v in task.gain], list(task.e_max), u_max, rho_max, [Fraction(1, 4)]]
    computed = [v.tolist() for v in (law.shift, law.gain, law.e_max, law.u_max, law.eps_at_clamp)] + [[law.latency]]
    return [f"in fractions {a}, not {b}" for a, b in zip(computed, expected, strict=True) if a != b]


def _eps(share: Fraction) -> Fraction:
    """Return ln((1 + share)/(1 - share)) from below, to 2^-55."""
    with ctx.workprec(200):
        value = (
            arb((1 + share).numerator * (1 - share).denominator) / arb((1 + share).denominator * (1 - share).numerator)
        ).log()
        return Fraction(math.floor(float((value * 2**40).lower()) * 2**15), 2**55)


LEMMAS = (
    Lemma(
        "sampled.windows",
        "In a segment the width is between the least and the greatest difference of the edges' coefficients, and rates are at "
        "most 3 K/t_c times the largest difference of neighbours: what the code takes, with roundings outward. From t_c on the "
        "edges are those at t_c, or, of a tube that repeats itself, those of the cycle's first segment.",
        r"|\dot\gamma| \le \tfrac{3K}{t_c}\max_j|\beta_{j+1}-\beta_j|",
        (),
        "the evaluated code",
        _prove_windows,
        ("refined.hull",),
    ),
    Lemma(
        "sampled.exact_windows",
        "P9 takes the same, in fractions, the worse of a window and the one before where a sample may stem from there.",
        r"d_-,\ d_+,\ S \in \mathbb Q",
        (),
        "the evaluated code",
        _prove_exact_windows,
        ("sampled.windows", "sampled.before"),
    ),
    Lemma(
        "sampled.setting",
        "eta bounds the error of what the law sees: both edges' arithmetic, x rounded, noise. Every bound is the worse of two "
        "windows, rounded to the safe side.",
        r"\eta \ge 2\delta + \epsilon\max|x| + b",
        (),
        "the evaluated code",
        _prove_setting,
        ("sampled.before",),
    ),
)
