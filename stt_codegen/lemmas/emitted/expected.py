"""The formulas that the emitted functions of a refined tube must equal: tube, rates, law, status and margin. One formula for each
regime, which is a stretch of time and a side of the tube."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy as sp

from stt_codegen.controller import ticks_of
from stt_codegen.designs import LOWER, MINIMUM_WIDTH, UPPER
from stt_codegen.lemmas.emitted.examples import (
    BOX,
    E_MAX,
    GAIN,
    T_C,
    TICK,
    U_MAX,
    Case,
    K,
    N,
    Point,
    Spec,
    T,
    Wanted,
    X,
    entry,
    finite,
    kernel_of,
    rational,
)
from stt_codegen.program import Status, largest_below
from stt_codegen.program.symbolic import follow


def _place(case: Case, point: Point) -> tuple[Any, Any, Any]:
    """(regime, segment j, place s): spline time K t/t_c held within [0, K), or of a tick, in integers."""
    if "tick" in point:
        ticks = ticks_of(case.design, Fraction(1, 1000))
        late = point["tick"] >= ticks.last
        passed = (ticks.last if late else TICK) * ticks.numerator
        whole = ticks.numerator * (ticks.last if late else point["tick"])
        end = K * ticks.denominator
        held = end if whole >= end else passed
        number = min(whole, end) // ticks.denominator
        if number >= K - 1:
            return ("last", late), K - 1, sp.Rational(1, ticks.denominator) * (held - (K - 1) * ticks.denominator)
        j = sp.floor(sp.Rational(1, ticks.denominator) * held)
        return ("running", late), j, (held - j * ticks.denominator) * sp.Rational(1, ticks.denominator)
    t = point["t"]
    end_time = largest_below(Fraction(K), "double")
    if t <= 0:
        return "early", sp.Integer(0), sp.Integer(0)
    u = T * rational(Fraction(K) / T_C)
    if t * float(Fraction(K) / T_C) >= float(end_time):
        u = rational(end_time)
    return ("late" if u.is_Rational else "running"), sp.floor(u), u - sp.floor(u)


def _edge(j: Any, s: Any, i: int, side: int, basis: str = "basis") -> Any:
    """sum of w_k(s) q[j + k]: four rows from row j on."""
    weights = [kernel_of(basis, k, s) for k in range(4)]
    return kernel_of("blend", 0, *weights, *(entry("coefficients", 2 * N * (j + k) + 2 * i + side) for k in range(4)))


def tube(case: Case, point: Point) -> Wanted:
    if not finite(point["t"]):
        return "bad", {name: [sp.nan] * N for name in BOX}, None
    regime, j, s = _place(case, point)
    return regime, {name: [_edge(j, s, i, side) for i in range(N)] for side, name in enumerate(BOX)}, None


def tube_rate(case: Case, point: Point) -> Wanted:
    names = [f"{name}_rate" for name in BOX]
    if not finite(point["t"]):
        return "bad", {name: [sp.nan] * N for name in names}, None
    regime, j, s = _place(case, point)
    moving = point["t"] < T_C
    speed = rational(Fraction(K) / T_C) if moving else 0
    return (
        (regime, moving),
        {n: [_edge(j, s, i, side, "basis_rate") * speed for i in range(N)] for side, n in enumerate(names)},
        None,
    )


@dataclass(frozen=True, kw_only=True)
class Component:
    """One component's regime, and formulas for near, far, the sign of the side, and the law before saturation."""

    regime: Any
    near: Any
    far: Any
    width: Any
    upper_nearer: bool
    inside: bool
    empty: bool


def _component(low: Any, high: Any, x: Any, numbers: tuple[float, float, float], guarded: bool) -> Component:
    """Where x stands: the distances to both edges, e clamped to [-e_max, e_max], as distances within [c, 1 - c] of the width."""
    lower, upper, at = numbers
    a, b, room = at - lower, upper - at, upper - lower
    upper_nearer, inside, empty = b < a, min(a, b) > 0, guarded and not room > 0
    c = rational((1 - E_MAX) / 2)
    least = rational(MINIMUM_WIDTH)
    narrow = guarded and not float(MINIMUM_WIDTH) < room
    width = least if narrow else high - low
    spare = (width - (high - low)) / 2 if guarded else 0
    nearest = (high - x if upper_nearer else x - low) + spare
    number = float(MINIMUM_WIDTH) if narrow else room
    clear = float((1 - E_MAX) / 2) * number < min(a, b) + ((number - room) / 2 if guarded else 0)
    clear = clear and not empty
    near = nearest if clear else c * width
    return Component(
        regime=(upper_nearer, inside, empty, narrow, clear),
        near=near,
        far=width - near,
        width=width,
        upper_nearer=upper_nearer,
        inside=inside,
        empty=empty,
    )


def _law(part: Component) -> Any:
    """u = -k xi eps, measured from the nearer edge: from the upper one eps and k change their signs."""
    epsilon, xi = (kernel_of("transformed_error", k, part.near, part.far) for k in (0, 1))
    gain = rational(-GAIN if part.upper_nearer else GAIN)
    return sp.Integer(0) if part.empty else kernel_of("law", 0, gain, xi, epsilon)


def _law_number(numbers: tuple[float, float, float]) -> float:
    lower, upper, at = numbers
    width = upper - lower
    c = float((1 - E_MAX) / 2)
    a = min(max(at - lower, c * width), (1 - c) * width)
    return -float(GAIN) * (1 / a + 1 / (width - a)) * math.log(a / (width - a))


def _with_edges(
    case: Case, point: Point, edges: Callable[[Case, Point], tuple[Any, list[tuple[Any, Any]]]], clock: str = "t"
) -> Iterator[tuple[Any, Component, tuple[float, float, float]]]:
    """(formula of x's place) by component, from formulas of the edges and their numbers."""
    regime, lines = edges(case, point)
    arguments = {name: v for name, v in point.items() if name in ("t", "alpha")}
    if clock == "tick":
        arguments = {"t": point["tick"] / 1000}
    numbers = follow(case.program, "tube", arguments, case.opaque).outputs
    for i, (low, high) in enumerate(lines):
        found = (numbers["lower"][i], numbers["upper"][i], point["x"][i])
        yield regime, _component(low, high, X[i], found, case.guarded), found


def spline_edges(case: Case, point: Point) -> tuple[Any, list[tuple[Any, Any]]]:
    regime, j, s = _place(case, point)
    return regime, [(_edge(j, s, i, LOWER), _edge(j, s, i, UPPER)) for i in range(N)]


def control_of(edges: Callable[[Case, Point], tuple[Any, list[tuple[Any, Any]]]]) -> Spec:
    def control(case: Case, point: Point) -> Wanted:
        read = [
            v for name, value in point.items() if name != "tick" for v in (value if isinstance(value, Sequence) else (value,))
        ]
        if not finite(*read):
            return "bad", {"u": [sp.Integer(0)] * N}, Status.BAD_INPUT
        saturated = any(t.name == "u_max" for t in case.program.tables)
        regimes, u, inside = [], [], True
        for i, (regime, part, numbers) in enumerate(_with_edges(case, point, edges, "tick" if "tick" in point else "t")):
            value, side = _law(part), 0
            if saturated:
                number, limit = _law_number(numbers), float(U_MAX[i])
                side = (number > limit) - (number < -limit)
                value = side * entry("u_max", i) if side else value
            inside = inside and part.inside
            u.append(value)
            regimes.append((regime, part.regime, side))
        return tuple(regimes), {"u": u}, Status.OK if inside else Status.OUTSIDE_TUBE

    return control


def margin_of(edges: Callable[[Case, Point], tuple[Any, list[tuple[Any, Any]]]]) -> Spec:
    def margin(case: Case, point: Point) -> Wanted:
        read = [v for value in point.values() for v in (value if isinstance(value, Sequence) else (value,))]
        if not finite(*read):
            return "bad", {}, sp.nan
        least, number, regimes = rational(Fraction(1, 2)), 0.5, []
        for i, (regime, part, numbers) in enumerate(_with_edges(case, point, edges)):
            lower, upper, at = numbers
            low, high = edges(case, point)[1][i]
            share = (high - X[i] if part.upper_nearer else X[i] - low) / part.width
            size = min(at - lower, upper - at) / (float(MINIMUM_WIDTH) if part.regime[3] else upper - lower)
            beyond = size < -1
            share, size = (sp.Integer(-1), -1.0) if beyond else (share, size)
            less = size < number
            least, number = (share, size) if less else (least, number)
            regimes.append((regime, part.regime, beyond, less))
        return tuple(regimes), {}, least

    return margin


def margins_of(edges: Callable[[Case, Point], tuple[Any, list[tuple[Any, Any]]]]) -> Spec:
    """By component the share of the width to the nearer edge; NaN in all where t or alpha is not finite."""

    def margins(case: Case, point: Point) -> Wanted:
        if not finite(point["t"], *point.get("alpha", ())):
            return "bad", {"margin": [sp.nan] * N}, None
        regimes, shares = [], []
        for i, (regime, part, numbers) in enumerate(_with_edges(case, point, edges)):
            lower, upper, at = numbers
            low, high = edges(case, point)[1][i]
            size = min(at - lower, upper - at) / (float(MINIMUM_WIDTH) if part.regime[3] else upper - lower)
            beyond = size < -1
            shares.append(sp.Integer(-1) if beyond else (high - X[i] if part.upper_nearer else X[i] - low) / part.width)
            regimes.append((regime, part.regime, beyond))
        return tuple(regimes), {"margin": shares}, None

    return margins


def covered(case: Case, point: Point) -> Wanted:
    """Whether every component is strictly between the entries of two tables."""
    low, high = (case.program.table(name).values for name in ("start_lower", "start_upper"))
    sides = tuple((low[i] < x, x < high[i]) for i, x in enumerate(point["x"]))
    return sides, {}, all(above and below for above, below in sides)


def transform(_case: Case, point: Point) -> Wanted:
    """e, eps, xi by component; 0 in an empty one, NaN where something is not finite."""
    outputs: dict[str, list[Any]] = {"e": [], "epsilon": [], "xi": []}
    regimes = []
    for i in range(N):
        numbers = (point["lower"][i], point["upper"][i], point["x"][i])
        if not finite(numbers[2], numbers[1] - numbers[0]):
            regimes.append(("bad", numbers[1] - numbers[0] > 0, numbers[1] - numbers[2] < numbers[2] - numbers[0]))
            for values in outputs.values():
                values.append(sp.nan)
            continue
        part = _component(BOX["lower"][i], BOX["upper"][i], X[i], numbers, True)
        a, b = (part.far, part.near) if part.upper_nearer else (part.near, part.far)
        clear = part.regime[4]
        e = (a - b) / part.width if clear else rational(E_MAX) * (1 if part.upper_nearer else -1)
        epsilon, xi = (kernel_of("transformed_error", k, part.near, part.far) for k in (0, 1))
        sign = -1 if part.upper_nearer else 1
        found = (e, sign * epsilon, xi)
        for values, value in zip(outputs.values(), found, strict=True):
            values.append(sp.Integer(0) if part.empty else value)
        regimes.append(part.regime)
    return tuple(regimes), outputs, None
