"""Formulas that the emitted functions of a refined tube must equal: tube, rates, control, margins, status.

A formula holds in one regime, which is a stretch of time and a side of the tube. functions.py compares them with the program.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy as sp

from stt_codegen.controller import tick_constants
from stt_codegen.designs import LOWER, MINIMUM_WIDTH, UPPER
from stt_codegen.lemmas.emitted.examples import (
    BOX,
    E_MAX,
    GAIN,
    T_C,
    TICK,
    U_MAX,
    Case,
    Expected,
    K,
    N,
    Point,
    Specification,
    T,
    X,
    are_finite,
    kernel_of,
    rational,
    table_entry,
)
from stt_codegen.program import Status, largest_below
from stt_codegen.program.symbolic import follow

Edges = Callable[[Case, Point], tuple[Any, list[tuple[Any, Any]]]]  # the regime, and formulas of both edges by component
Numbers = tuple[float, float, float]  # lower edge, upper edge and x of a component


def _segment_at(case: Case, point: Point) -> tuple[Any, Any, Any]:
    """Return (regime, segment j, s from 0 to 1 in it) of the spline time K t/t_c, limited to [0, K), or of a tick."""
    if "tick" in point:
        return _segment_at_tick(case, point["tick"])
    t = point["t"]
    end_time = largest_below(Fraction(K), "double")
    if t <= 0:
        return "early", sp.Integer(0), sp.Integer(0)
    u = T * rational(Fraction(K) / T_C)
    if t * float(Fraction(K) / T_C) >= float(end_time):
        u = rational(end_time)
    return ("late" if u.is_Rational else "running"), sp.floor(u), u - sp.floor(u)


def _segment_at_tick(case: Case, tick: int) -> tuple[Any, Any, Any]:
    """Return (regime, segment j, s in it) of a tick; the regime says in which stretch of the ticks it is."""
    ticks = tick_constants(case.design, Fraction(1, 1000))
    is_late = tick >= ticks.end_tick
    elapsed = (ticks.end_tick if is_late else TICK) * ticks.numerator
    elapsed_number = ticks.numerator * (ticks.end_tick if is_late else tick)
    end = K * ticks.denominator
    clamped = end if elapsed_number >= end else elapsed
    segment = min(elapsed_number, end) // ticks.denominator
    if segment >= K - 1:
        return ("last", is_late), K - 1, sp.Rational(1, ticks.denominator) * (clamped - (K - 1) * ticks.denominator)
    j = sp.floor(sp.Rational(1, ticks.denominator) * clamped)
    return ("running", is_late), j, (clamped - j * ticks.denominator) * sp.Rational(1, ticks.denominator)


def _edge(j: Any, s: Any, i: int, side: int, basis: str = "basis") -> Any:
    """Return the sum of w_k(s) q[j + k] over four rows of the table, from row j on."""
    weights = [kernel_of(basis, k, s) for k in range(4)]
    return sum(w * table_entry("coefficients", 2 * N * (j + k) + 2 * i + side) for k, w in enumerate(weights))


def tube(case: Case, point: Point) -> Expected:
    if not are_finite(point["t"]):
        return "bad", {name: [sp.nan] * N for name in BOX}, None
    regime, j, s = _segment_at(case, point)
    return regime, {name: [_edge(j, s, i, side) for i in range(N)] for side, name in enumerate(BOX)}, None


def tube_rate(case: Case, point: Point) -> Expected:
    """Return the rates of both edges: those of the weights times K/t_c before t_c, else 0; NaN for a t that is not finite."""
    names = [f"{name}_rate" for name in BOX]
    if not are_finite(point["t"]):
        return "bad", {name: [sp.nan] * N for name in names}, None
    regime, j, s = _segment_at(case, point)
    is_moving = point["t"] < T_C
    speed = rational(Fraction(K) / T_C) if is_moving else 0
    rates = {n: [_edge(j, s, i, side, "basis_rate") * speed for i in range(N)] for side, n in enumerate(names)}
    return (regime, is_moving), rates, None


@dataclass(frozen=True, kw_only=True)
class Component:
    """Formulas of one component: distances to both edges, e clamped, and width; and which branches of the law its numbers take.

    is_narrow: the width is raised to MINIMUM_WIDTH. is_unclamped: the nearer distance is above c times the width.
    """

    near: Any
    far: Any
    width: Any
    is_upper_nearer: bool
    is_inside: bool
    is_empty: bool
    is_narrow: bool
    is_unclamped: bool

    @property
    def regime(self) -> tuple[bool, ...]:
        return (self.is_upper_nearer, self.is_inside, self.is_empty, self.is_narrow, self.is_unclamped)


def _component(low: Any, high: Any, x: Any, numbers: Numbers, guarded: bool) -> Component:
    """Return the formulas of a component for the branches that its numbers take; e is clamped to [-e_max, e_max].

    low, high, x: formulas. guarded: the law raises narrow widths to MINIMUM_WIDTH, half on each side.
    """
    lower, upper, state = numbers
    a, b, width_number = state - lower, upper - state, upper - lower
    is_upper_nearer, is_inside, is_empty = b < a, min(a, b) > 0, guarded and not width_number > 0
    c = rational((1 - E_MAX) / 2)
    is_narrow = guarded and not float(MINIMUM_WIDTH) < width_number
    width = rational(MINIMUM_WIDTH) if is_narrow else high - low
    widening = (width - (high - low)) / 2 if guarded else 0
    nearest = (high - x if is_upper_nearer else x - low) + widening
    raised_width = float(MINIMUM_WIDTH) if is_narrow else width_number
    nearest_number = min(a, b) + ((raised_width - width_number) / 2 if guarded else 0)
    is_unclamped = float((1 - E_MAX) / 2) * raised_width < nearest_number and not is_empty
    near = nearest if is_unclamped else c * width
    return Component(
        near=near,
        far=width - near,
        width=width,
        is_upper_nearer=is_upper_nearer,
        is_inside=is_inside,
        is_empty=is_empty,
        is_narrow=is_narrow,
        is_unclamped=is_unclamped,
    )


def _law(component: Component) -> Any:
    """Return u = -k xi eps, measured from the nearer edge: from the upper one eps and k have the other sign."""
    epsilon, xi = (kernel_of("transformed_error", k, component.near, component.far) for k in (0, 1))
    gain = rational(-GAIN if component.is_upper_nearer else GAIN)
    return sp.Integer(0) if component.is_empty else kernel_of("law", 0, gain, xi, epsilon)


def _law_number(numbers: Numbers) -> float:
    """Return u of the law before saturation, as a number."""
    lower, upper, state = numbers
    width = upper - lower
    c = float((1 - E_MAX) / 2)
    a = min(max(state - lower, c * width), (1 - c) * width)
    return -float(GAIN) * (1 / a + 1 / (width - a)) * math.log(a / (width - a))


def _components(case: Case, point: Point, edges: Edges, clock: str = "t") -> Iterator[tuple[Any, Component, Numbers]]:
    """Yield by component (regime of the edges, formulas, numbers); the numbers of the edges are those of the program's tube."""
    regime, formulas = edges(case, point)
    arguments = {name: v for name, v in point.items() if name in ("t", "alpha")}
    if clock == "tick":
        arguments = {"t": point["tick"] / 1000}
    outputs = follow(case.program, "tube", arguments, case.opaque).outputs
    for i, (low, high) in enumerate(formulas):
        numbers = (outputs["lower"][i], outputs["upper"][i], point["x"][i])
        yield regime, _component(low, high, X[i], numbers, case.is_guarded), numbers


def spline_edges(case: Case, point: Point) -> tuple[Any, list[tuple[Any, Any]]]:
    regime, j, s = _segment_at(case, point)
    return regime, [(_edge(j, s, i, LOWER), _edge(j, s, i, UPPER)) for i in range(N)]


def _numbers_of(point: Point) -> list[float]:
    """Return all numbers of a point but a tick, which is finite always."""
    return [v for name, value in point.items() if name != "tick" for v in (value if isinstance(value, Sequence) else (value,))]


def control_of(edges: Edges) -> Specification:
    """Return the specification of `control` for a tube with these edges."""

    def control(case: Case, point: Point) -> Expected:
        """Return u of the law, at u_max where it is beyond, and the status; 0 and BAD_INPUT where a number is not finite."""
        if not are_finite(*_numbers_of(point)):
            return "bad", {"u": [sp.Integer(0)] * N}, Status.BAD_INPUT
        is_saturating = any(t.name == "u_max" for t in case.program.tables)
        regimes, u, is_inside = [], [], True
        for i, (regime, component, numbers) in enumerate(_components(case, point, edges, "tick" if "tick" in point else "t")):
            value, side = _law(component), 0
            if is_saturating:
                number, limit = _law_number(numbers), float(U_MAX[i])
                side = (number > limit) - (number < -limit)
                value = side * table_entry("u_max", i) if side else value
            is_inside = is_inside and component.is_inside
            u.append(value)
            regimes.append((regime, component.regime, side))
        return tuple(regimes), {"u": u}, Status.OK if is_inside else Status.OUTSIDE_TUBE

    return control


def _shares(case: Case, point: Point, edges: Edges) -> Iterator[tuple[Any, float, Any]]:
    """Yield by component the distance to the nearer edge over the width, at least -1: (formula, number, regime)."""
    formulas = edges(case, point)[1]
    for i, (regime, component, numbers) in enumerate(_components(case, point, edges)):
        (low, high), (lower, upper, state) = formulas[i], numbers
        share = (high - X[i] if component.is_upper_nearer else X[i] - low) / component.width
        number = min(state - lower, upper - state) / (float(MINIMUM_WIDTH) if component.is_narrow else upper - lower)
        is_far_outside = number < -1
        share, number = (sp.Integer(-1), -1.0) if is_far_outside else (share, number)
        yield share, number, (regime, component.regime, is_far_outside)


def margin_of(edges: Edges) -> Specification:
    """Return the specification of `margin` for a tube with these edges."""

    def margin(case: Case, point: Point) -> Expected:
        """Return the smallest share of the width to the nearer edge, at most 1/2; NaN where a number is not finite."""
        if not are_finite(*_numbers_of(point)):
            return "bad", {}, sp.nan
        smallest, smallest_number, regimes = rational(Fraction(1, 2)), 0.5, []
        for share, number, regime in _shares(case, point, edges):
            is_smaller = number < smallest_number
            smallest, smallest_number = (share, number) if is_smaller else (smallest, smallest_number)
            regimes.append((regime, is_smaller))
        return tuple(regimes), {}, smallest

    return margin


def margins_of(edges: Edges) -> Specification:
    """Return the specification of `margins` for a tube with these edges."""

    def margins(case: Case, point: Point) -> Expected:
        """Return by component the share of the width to the nearer edge; NaN in all where t or alpha is not finite."""
        if not are_finite(point["t"], *point.get("alpha", ())):
            return "bad", {"margin": [sp.nan] * N}, None
        shares = list(_shares(case, point, edges))
        return tuple(regime for *_, regime in shares), {"margin": [share for share, *_ in shares]}, None

    return margins


def covered(case: Case, point: Point) -> Expected:
    """Return whether every component is strictly between the entries of two tables."""
    low, high = (case.program.table(name).values for name in ("start_lower", "start_upper"))
    sides = tuple((low[i] < x, x < high[i]) for i, x in enumerate(point["x"]))
    return sides, {}, all(above and below for above, below in sides)


def transform(_case: Case, point: Point) -> Expected:
    """Return e, eps, xi by component; 0 in an empty one, NaN where something is not finite."""
    outputs: dict[str, list[Any]] = {"e": [], "epsilon": [], "xi": []}
    regimes: list[Any] = []
    for i in range(N):
        lower, upper, state = numbers = (point["lower"][i], point["upper"][i], point["x"][i])
        if not are_finite(state, upper - lower):
            regimes.append(("bad", upper - lower > 0, upper - state < state - lower))
            for values in outputs.values():
                values.append(sp.nan)
            continue
        component = _component(BOX["lower"][i], BOX["upper"][i], X[i], numbers, True)
        for values, value in zip(outputs.values(), _transformed(component), strict=True):
            values.append(sp.Integer(0) if component.is_empty else value)
        regimes.append(component.regime)
    return tuple(regimes), outputs, None


def _transformed(component: Component) -> tuple[Any, Any, Any]:
    """Return e, eps and xi of a component; e is exactly e_max or -e_max where it is clamped."""
    near, far, sign = component.near, component.far, -1 if component.is_upper_nearer else 1
    e = sign * (near - far) / component.width if component.is_unclamped else -sign * rational(E_MAX)
    epsilon, xi = (kernel_of("transformed_error", k, near, far) for k in (0, 1))
    return e, sign * epsilon, xi
