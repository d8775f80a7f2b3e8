"""What the sampled statements and P9 are told of a tube, a plant and a law: the code that makes these numbers, run on symbols.

Long because both kinds of numbers are looked at, doubles with their roundings and fractions.
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
    Law,
    extremes,
    in_balls,
    law_of,
    reach_of_starts,
    refined_windows,
    setting_of,
)

SPARE = Fraction(1, 10**9) + Fraction(1, 1 << 50)  # what doubles are rounded outward by at most, and the rounding of that


@dataclass(frozen=True)
class Table:
    """A refined tube of which no more is known than its Bezier coefficients, which may be symbols: (K, n, 2, 4), and whether it
    repeats itself, from segment `seam` on."""

    coefficients: Any
    prescribed_time: Fraction
    unit: Fraction
    seam: int | None = None

    windows = RefinedDesign.windows

    @property
    def segments(self) -> int:
        return len(self.coefficients)

    def bezier(self) -> Any:
        return self.coefficients


def tables() -> Iterator[Table]:
    """One segment with its lower coefficients and its widths in every order, then two segments of two components."""
    orders = list(permutations(range(4)))
    for low, wide in zip(orders, orders[::-1], strict=True):
        high = [a + 9 + 2.5 * w for a, w in zip(low, wide, strict=True)]
        yield _table(np.array([[[low, high]]], dtype=float), Fraction(3, 2))
    rising = np.arange(32, dtype=float).reshape(2, 2, 2, 4)
    yield _table(rising + np.sin(rising) / 2, Fraction(10))
    many = np.arange(48.0).reshape(6, 1, 2, 4)
    longer = _table(many * 7 % 31 + np.array([[0.0], [40.0]]) + np.sin(many), Fraction(5))
    yield longer
    yield replace(longer, seam=2)
    yield _table(40 - rising + np.sin(3 * rising), Fraction(7, 3))


def _table(numbers: Any, seconds: Fraction) -> Table:
    symbols = np.array(sp.symbols(f"beta0:{numbers.size}", real=True), dtype=object).reshape(numbers.shape)
    make = np.vectorize(EvaluatedExpression, otypes=[object])
    return Table(make(symbols, numbers), seconds, Fraction(1, 8))


def _wanted(table: Table) -> dict[str, Any]:
    """By name the entries (W + 1, n) that the windows must have, in units of the table: found by the numbers, one by one."""
    c = table.coefficients
    count, n = len(c), c.shape[1]
    result: dict[str, list[list[Any]]] = {k: [] for k in ("narrow", "wide", "step", "width_step", "low", "high")}
    for k, i in product(range(count + 1), range(n)):
        held = [c[-1, i, side, 3] for side in (LOWER, UPPER)]
        again = table.seam if k == count else k  # from t_c on the cycle's first segment comes again, or the tube stands
        low, high = ([held[s]] * 4 if again is None else list(c[again, i, s]) for s in (LOWER, UPPER))
        width = [b - a for a, b in zip(low, high, strict=True)]
        steps = [b - a for edge in (low, high) for a, b in pairwise(edge)]
        row = {
            "narrow": min(width, key=float), "wide": max(width, key=float), "low": min(low, key=float),
            "high": max(high, key=float), "step": _largest(steps), "width_step": _largest([b - a for a, b in pairwise(width)]),
        }  # fmt: skip
        for name, value in row.items():
            result[name].append(value.expression)
    return result


def _largest(values: list[EvaluatedExpression]) -> EvaluatedExpression:
    worst = max(values, key=lambda v: abs(v.value))
    return worst if worst.value >= 0 else -worst


def _bezier_rate() -> Outcome:
    """The slope of a cubic is the quadratic of three times its coefficients' differences."""
    s, beta = sp.Symbol("s", real=True), sp.symbols("beta0:4", real=True)
    curve = sum(sp.binomial(3, j) * s**j * (1 - s) ** (3 - j) * b for j, b in enumerate(beta))
    slope = sum(sp.binomial(2, j) * s**j * (1 - s) ** (2 - j) * 3 * (beta[j + 1] - beta[j]) for j in range(3))
    return prove_identities({"slope less its Bezier form": sp.expand(sp.diff(curve, s) - slope)})


def _prove_windows() -> Outcome:
    """Both forms: in units of the table for P9, and in doubles for the search, rates rounded outward."""
    found: dict[str, Any] = {}
    wrong: list[str] = []
    count = 0
    for number, given in enumerate(tables()):
        table: Any = given
        wanted, whole, windows = _wanted(given), extremes(table), refined_windows(table)
        rate = Fraction(3 * given.segments) / given.prescribed_time * given.unit
        unit = sp.Rational(given.unit)
        in_doubles = {"narrow": windows.narrow, "wide": windows.wide, "low": windows.low, "high": windows.high}
        for name, forms in wanted.items():
            pairs = zip(forms, getattr(whole, name).ravel(), strict=True)
            found |= {f"{name} {number}.{j}": form - v.expression for j, (form, v) in enumerate(pairs)}
        for name, values in in_doubles.items():
            pairs = zip(wanted[name], values.ravel(), strict=True)
            found |= {
                f"{name} {number}.{j}, doubles": sp.Rational(given.unit) * form - v.expression
                for j, (form, v) in enumerate(pairs)
            }
        for name, values in (("step", windows.speed), ("width_step", windows.widening)):
            for form, v in zip(wanted[name], values.ravel(), strict=True):
                count += 1
                share = sp.cancel(v.expression / form) if form != 0 else None
                if (
                    (v.expression != 0)
                    if share is None
                    else not (rate <= Fraction(str(share)) <= rate * (1 + Fraction(1, 1 << 40)))
                ):
                    wrong.append(f"{name} is {v.expression}, not {rate} times {form}")
        starts = zip(given.coefficients[0, :, :, 0].ravel(), windows.start.ravel(), strict=True)
        found |= {f"start {number}.{j}": unit * a.expression - b.expression for j, (a, b) in enumerate(starts)}
        ends = [float(given.prescribed_time) * k / given.segments for k in range(given.segments + 1)]
        count += 1
        if not np.allclose(windows.times, ends, rtol=1e-15, atol=0):
            wrong.append(f"windows end at {windows.times}, not at {ends}")
    return all_of(
        _bezier_rate(),
        prove_identities(found, "SymPy: the evaluated code run on symbols, lower coefficients and widths in every order"),
        outcome_of_cases(count, wrong, "rates in doubles are at least 3 K/t_c times the differences, and at most 2^-40 more"),
    )


class _OnSymbols(Fractions):
    """Fractions, of symbols; no norm is asked for."""

    def root_above(self, value: Any) -> Any:
        return 0 * value


def _prove_exact_windows() -> Outcome:
    """The windows and the setting in fractions: those of the segment, and the worse of it and of the one before. Where nothing
    else pushes the push is the edges' speed."""
    wrong: list[str] = []
    found: dict[str, Any] = {}
    nothing = np.array([Fraction(0)], dtype=object)
    for number, given in enumerate(tables()):
        table: Any = given
        unit, rate = sp.Rational(given.unit), sp.Rational(Fraction(3 * given.segments) / given.prescribed_time * given.unit)
        narrow, wide, step = (getattr(extremes(table), name) for name in ("narrow", "wide", "step"))
        n = narrow.shape[1]
        law: Any = SimpleNamespace(numbers=_OnSymbols())
        still = Bounds(
            push=nothing,
            least=nothing,
            most=nothing,
            cross=nothing,
            push_norm=Fraction(0),
            definite=Fraction(0),
            norm=Fraction(0),
        )
        made = setting_of(refined_windows(table, law.numbers), [still] * (given.segments + 1), law, np.zeros(n))
        ends = [given.prescribed_time * k / given.segments for k in range(given.segments + 1)]
        wrong += [] if len(made.narrow) == len(table.windows()) else [f"{len(made.narrow)} windows"]
        wrong += [] if made.windows.times.tolist() == ends else [f"windows end at {made.windows.times}, not at {ends}"]
        for k, i in product(range(given.segments + 1), range(n)):
            before = max(k - 1, 0)
            wanted = {
                "narrow": (made.windows.narrow, unit * narrow[k, i].expression),
                "narrow_seen": (made.narrow, unit * min(narrow[k, i], narrow[before, i], key=float).expression),
                "wide": (made.windows.wide, unit * wide[k, i].expression),
                "speed": (made.push, rate * max(step[k, i], step[before, i], key=float).expression),
            }
            found |= {f"{name} {number}.{k}.{i}": getattr(a[k, i], "expression", a[k, i]) - b for name, (a, b) in wanted.items()}
    return all_of(
        prove_identities(found, "SymPy: the evaluated code run on symbols, lower coefficients and widths in every order"),
        outcome_of_cases(number + 1, wrong, "a window for every segment, and one from t_c on"),
    )


def _prove_setting() -> Outcome:
    """What a statement is told is on the safe side of what the task and the windows say, and not by more than 1e-9."""
    wrong: list[str] = []
    count = 0

    def near(name: str, given: Any, exact: Any, up: bool = True) -> None:
        nonlocal count
        for a, b in zip(np.ravel(given).tolist(), np.ravel(exact).tolist(), strict=True):
            count += 1
            over = (Fraction(a) - Fraction(b)) * (1 if up else -1)
            if not 0 <= over <= Fraction(b) * SPARE:
                wrong.append(f"{name} is {float(a)}, not {float(b)}")

    for scalar, noise, limit in product(("float", "double"), (0.0, 0.03), (None, (Fraction(1, 3), Fraction(2)))):
        ends: Any = ((Fraction(-7, 3), Fraction(0)), (Fraction(1), Fraction(2)))
        ends = ends if noise else (tuple(-v for v in ends[1]), tuple(-v for v in ends[0]))  # the largest |x| at either end
        box = SimpleNamespace(lower=ends[0], upper=ends[1])
        emit = SimpleNamespace(scalar=scalar, math="libm")
        task: Any = SimpleNamespace(
            dimension=2, order=1, state_space=box, emit=emit, gain=(Fraction(1, 3), Fraction(-2, 7)),
            e_max=(Fraction(9, 10),) * 2, u_max=limit, plant=SimpleNamespace(noise=Fraction(noise)),
        )  # fmt: skip
        error = (Fraction(1, 977), Fraction(1, 1013))
        law = law_of(task, error, noise, 0.25)
        exact = [2 * e + FORMATS[scalar].roundoff * Fraction(7, 3) + Fraction(noise) for e in error]
        near("shift", law.shift, np.array(exact, dtype=object))
        count, wrong = (
            count + 1,
            wrong + _wrong_in_fractions(task, law_of(task, error, Fraction(noise), Fraction(1, 4), FRACTIONS), exact),
        )
        gain = np.array([abs(v) for v in task.gain], dtype=object)
        near("gain", law.gain * (1 + 2.0**-52), gain)  # the nearest double: law.rounding has that rounding
        near("e_max", law.e_max, [float(v) for v in task.e_max])
        near("eps at the clamp", law.farthest, [float(_eps(v)) for v in task.e_max])
        near("eps of the share", reach_of_starts(Fraction(9, 10), 2), np.array([_eps(Fraction(9, 10))] * 2, dtype=object))
        near("u_max", law.u_max[np.isfinite(law.u_max)], [float(round_down(v, scalar)) for v in limit or ()], up=False)
        count += 1
        if law.latency != 0.25 or law.rounding < 32 * FORMATS[scalar].roundoff:
            wrong.append(f"latency {law.latency}, rounding {law.rounding}")
        low = np.arange(16.0).reshape(2, 2, 4) * 7 % 5
        edges = np.stack([low, low + 3 + np.arange(16.0).reshape(2, 2, 4) * 5 % 7], axis=2)
        table: Any = Table(edges, Fraction(3), Fraction(1))
        windows = refined_windows(table)
        for k in (1, -1):
            sizes = [(j + 1.0) ** k for j in range(3)]
            each = [np.array([0.5, 0.25]) * v for v in sizes]
            p = [
                Bounds(
                    push=v,
                    least=v / 2,
                    most=v * 3,
                    cross=np.array([[0.0, w], [2 * w, 0.0]]),
                    push_norm=0.75 * w,
                    definite=0.5,
                    norm=2.0,
                )
                for v, w in zip(each, sizes, strict=True)
            ]
            made = setting_of(windows, p, law, np.zeros(2))
            speed = np.maximum(windows.speed, windows.speed[[0, 0, 1]])
            near("push", made.push, speed + [b.push for b in p])
            near("narrow", made.narrow, np.minimum(windows.narrow, windows.narrow[[0, 0, 1]]), up=False)
            near("push_norm", made.push_norm, np.sqrt((speed**2).sum(axis=1)) + [b.push_norm for b in p])
            near("g_min", made.least, [b.least for b in p], up=False)
            near("g_max", made.most, [b.most for b in p])
            near("g_ij", made.cross, [b.cross for b in p])
            near("of the whole", [made.definite, made.norm], [[b.definite for b in p], [b.norm for b in p]])
            balls, alone = in_balls(made), made.component(1)
            for name in ("least", "most", "cross", "push", "narrow", "definite", "norm", "push_norm"):
                near(f"{name} in balls", [float(v) for v in np.ravel(getattr(balls, name))], np.ravel(getattr(made, name)))
            for name in ("narrow", "wide", "speed", "widening"):
                near(
                    f"{name} in balls", [float(v) for v in np.ravel(getattr(balls.windows, name))], getattr(windows, name).ravel()
                )
                near(f"{name} of one component", getattr(alone.windows, name)[:, 0], getattr(windows, name)[:, 1])
            for name in ("least", "most", "push", "narrow"):
                near(f"{name} of one component", getattr(alone, name)[:, 0], getattr(made, name)[:, 1])
            near("gain in balls", [float(v) for v in balls.law.gain], law.gain)
    return outcome_of_cases(count, wrong, "what the statements are told is on the safe side, by 1e-9 of it at most")


def _wrong_in_fractions(task: Any, law: Law, shift: list[Fraction]) -> list[str]:
    """What the law in fractions has that the task does not say."""
    limits = [math.inf] * task.dimension if task.u_max is None else [round_down(v, task.emit.scalar) for v in task.u_max]
    ends = [(1 + v) / (1 - v) for v in task.e_max]
    said = [shift, [abs(v) for v in task.gain], list(task.e_max), limits, ends, [Fraction(1, 4)]]
    has = [v.tolist() for v in (law.shift, law.gain, law.e_max, law.u_max, law.farthest)] + [[law.latency]]
    return [f"in fractions {a}, not {b}" for a, b in zip(has, said, strict=True) if a != b]


def _eps(share: Fraction) -> Fraction:
    """ln((1 + share)/(1 - share)) from below, to 2^-55."""
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
