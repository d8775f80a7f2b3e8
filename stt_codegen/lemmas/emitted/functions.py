"""Lemmas about emitted functions: on every path each combines the kernels as the equations of the paper, repaired, demand.

A function's frame is everything around its kernels: the test for finite numbers, clamped time, segment, clamps, saturation,
status. `FRAMES` lists the comparisons of every function; a function with another one stays open. A function of a small example
program is followed at points of every regime, edges, empty tubes and numbers that are not finite included. On the path of a
point its outputs are formulas in t, x, alpha and table entries. These are symbols, so the formulas hold for every design of that
shape. They are compared with formulas that expected.py and expected_adaptive.py build from the equations. Kernels are symbols,
too: printed_kernels.py has lemmas about them. Points of one path for which these formulas differ are all compared. Where
neighbouring points are on different paths, the line between them is halved up to where the path changes, and points on both
sides are compared. So a threshold that is wrong by more than a millionth of the distance is detected.

book.py takes LEMMAS as the family `functions`. Long because it has the points, comparisons and statements of all functions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import product
from typing import Any

import sympy as sp

from stt_codegen.controller import tick_constants
from stt_codegen.design_kinds import DesignKind
from stt_codegen.lemmas.emitted import expected, expected_adaptive
from stt_codegen.lemmas.emitted.examples import FOLLOWED, SYMBOLS, Case, N, Point, Specification, cases, is_finite_point
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict
from stt_codegen.program import Status
from stt_codegen.program.analyse import comparisons
from stt_codegen.program.symbolic import follow, formulas_on

HALVINGS = 20
STRIDES = (1, 2, 3)  # between neighbours in the lists of points, which have two or three of a kind in a row


def check(case: Case, function: str, points: Iterable[Point], specification: Specification, frame: Sequence[str]) -> Outcome:
    """Prove that the function's outputs equal the formulas of the specification on every path and regime of the points.

    Its comparisons must be those of the frame, and each must have both outcomes among the points.
    """
    path_regimes: dict[Any, Any] = {}
    point_count = 0
    listed_points = list(points)
    compared = comparisons(case.program, case.program.function(function), FOLLOWED)
    failures = [f"{what} is no comparison of the frame" for what in compared if what not in frame]
    failures += [f"{what} is not compared" for what in frame if what not in compared]
    decided = set()
    for point in [*listed_points, *_path_changes(case, function, listed_points)]:
        point_count += 1
        path = follow(case.program, function, point, case.opaque)
        decided |= set(zip(compared, path.decisions, strict=False))  # a path that returns early has fewer decisions
        regime, outputs, result = specification(case, point)
        path_regimes.setdefault((path.decisions, regime), (path, point, outputs, result))
    failures += [f"{what} is never {value}" for what in frame for value in (True, False) if (what, value) not in decided]
    for path, point, outputs, result in path_regimes.values():
        computed = formulas_on(case.program, function, SYMBOLS, path, case.opaque)
        pairs = [
            (f"{name}[{i}]", v, w)
            for name in outputs
            for i, (v, w) in enumerate(zip(computed.outputs[name], outputs[name], strict=True))
        ]
        pairs += [("result", computed.result, result)]
        failures += [f"{name} at {_in_words(point)}: {v} for {w}"[:300] for name, v, w in pairs if not _are_equal(v, w)]
    method = "SymPy: the function followed at points of every regime, its formulas on each path compared"
    if failures:
        return Outcome(Verdict.OPEN, method, tuple(failures))
    return Outcome(Verdict.PROVED, method, (f"{function}: {len(path_regimes)} paths and regimes, {point_count} points",))


def _path_changes(case: Case, function: str, points: Sequence[Point]) -> Iterator[Point]:
    """Yield pairs of points close together, one on each side of where the path changes between neighbours in the list."""
    known_changes = set()
    paths = [follow(case.program, function, p, case.opaque).decisions for p in points]
    strides = STRIDES[:1] if case.design.is_stateful else STRIDES  # paths of an adaptive tube take longer to follow
    for stride, k in product(strides, range(len(points))):
        if k + stride >= len(points) or (paths[k], paths[k + stride]) in known_changes or not points[k]:
            continue
        first, second = points[k], points[k + stride]
        if paths[k] == paths[k + stride] or not is_finite_point(first) or not is_finite_point(second):
            continue
        known_changes.add((paths[k], paths[k + stride]))
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            is_first_path = follow(case.program, function, _between(first, second, middle), case.opaque).decisions == paths[k]
            low, high = (middle, high) if is_first_path else (low, middle)
        yield from (_between(first, second, low), _between(first, second, high))


def _between(a: Point, b: Point, share: float) -> Point:
    """Return the point at a share of the way from a to b, with integers rounded."""

    def mix(x: Any, y: Any) -> Any:
        if isinstance(x, list | tuple):
            return [mix(v, w) for v, w in zip(x, y, strict=True)]
        return x + round(share * (y - x)) if isinstance(x, int) else x + share * (y - x)

    return {name: mix(a[name], b[name]) for name in a}


def _are_equal(computed: Any, expected: Any) -> bool:
    """Return whether two outputs are equal: the same truth value, status or NaN, or formulas whose difference is 0."""
    if isinstance(computed, bool) or isinstance(expected, bool):
        return computed is expected
    if computed is None or expected is None or isinstance(computed, Status) or isinstance(expected, Status):
        return computed is expected
    if sp.sympify(computed) is sp.nan or sp.sympify(expected) is sp.nan:
        return sp.sympify(computed) is sp.sympify(expected)
    difference = sp.sympify(computed) - expected
    return bool(sp.expand(difference) == 0 or sp.cancel(difference) == 0)


def _in_words(point: Point) -> str:
    return ", ".join(f"{name} = {value}" for name, value in point.items())


# ------------------------------------------------------------------------------------------------ points

TIMES = (-1.0, 0.0, 0.3, 2.5, 5.0, 8.9, 9.0, 12.0)
NOT_FINITE = (math.nan, math.inf, -math.inf)
SHARES = (-2.5, -0.1, 0.0, 0.001, 0.2, 0.5, 0.8, 0.999, 1.0, 1.1, 3.5)  # of the width, from the lower edge
# Away from ties, since the edges at a tick differ from those of `tube` in seconds by rounding.
SHARES_OFF_TIES = (-2.5, -0.1, 0.001, 0.2, 0.8, 0.999, 1.1, 3.5)
ALPHAS = ((0.0, 0.1, 0.0, 0.2), (-1.0, 0.0, 1e30, 0.5), (0.3, 1e9, 0.2, -2.0))


def _time_points() -> list[Point]:
    return [{"t": t} for t in (*TIMES, *NOT_FINITE)]


def _states(
    case: Case, arguments: Mapping[str, Any], extra: Mapping[str, Any], shares: Sequence[float] = SHARES
) -> Iterator[Point]:
    """Yield states with every share of the width in one component and 0.2 in the other one, and with one share in both."""
    tube = follow(case.program, "tube", arguments, case.opaque).outputs
    pairs = [pair for s in shares for pair in ((s, 0.2), (0.2, s), (s, s))]
    for pair in pairs:
        widths = [tube["upper"][i] - tube["lower"][i] for i in range(N)]
        x = [tube["lower"][i] + pair[i] * (widths[i] if abs(widths[i]) > 1e-9 else 1e-3) for i in range(N)]
        yield {**extra, "x": [tube["upper"][i] if pair[i] == 1.0 else x[i] for i in range(N)]}


def _bad_states(extra: Mapping[str, Any]) -> Iterator[Point]:
    for number in NOT_FINITE:
        yield {**extra, "x": [number, 1.0]}
        yield {**extra, "x": [1.0, number]}


def _spline_points(case: Case) -> Iterator[Point]:
    for t in TIMES:
        yield from _states(case, {"t": t}, {"t": t})
    yield from _bad_states({"t": 1.0})
    yield from ({"t": number, "x": [1.0, 1.0]} for number in NOT_FINITE)


def _start_points(case: Case) -> Iterator[Point]:
    yield from _states(case, {"t": 0.0}, {})
    yield from _bad_states({})


def _tick_points(case: Case) -> Iterator[Point]:
    ticks = tick_constants(case.design, Fraction(1, 1000))
    for tick in (0, 1, 2400, 6750, 8999, ticks.end_tick - 1, ticks.end_tick, ticks.end_tick + 1, 2**32 - 1):
        yield from _states(case, {"t": tick / 1000}, {"tick": tick}, SHARES_OFF_TIES)
    yield from _bad_states({"tick": 7})


def _alpha_points(has_states: bool) -> Iterator[Point]:
    """Yield times and values of alpha of the adaptive example, with numbers that are not finite; has_states: also states x."""
    case = cases()["adaptive"]
    for t, alpha in product((-1.0, 2.5, 12.0) if has_states else TIMES, ALPHAS):
        extra = {"t": t, "alpha": list(alpha)}
        yield from _states(case, extra, extra) if has_states else (extra,)
    for number in NOT_FINITE:
        states = {"x": [1.0, 1.0]} if has_states else {}
        yield {"t": number, "alpha": list(ALPHAS[0]), **states}
        for k in range(2 * N):
            yield {"t": 1.0, "alpha": [number if i == k else 0.1 for i in range(2 * N)], **states}
    if has_states:
        yield from _bad_states({"t": 1.0, "alpha": list(ALPHAS[0])})


def _step_points() -> Iterator[Point]:
    for point, dt in product(_alpha_points(False), (0.01, 1e9, 0.0, -1.0, math.nan)):
        yield {**point, "dt": dt}


def _boxes() -> Iterator[Point]:
    """Yield edges and states of `transform`: one component is empty, narrow, wide or not finite, the other one plain."""
    intervals = [(0.0, 1.0), (0.0, 2.0**-22), (1.0, 1.0), (2.0, 1.0), (math.nan, 1.0), (0.0, math.inf)]
    for share, (low, high) in product((*SHARES, math.nan), intervals):
        x = low + share * (high - low if 0 < high - low < 10 else 1.0)
        yield {"lower": [low, 0.0], "upper": [high, 1.0], "x": [x, 0.2]}
        yield {"lower": [0.0, low], "upper": [1.0, high], "x": [0.9, x]}


# By the word of the lemma: the example, the emitted function, and its points.
SUBJECTS: Mapping[str, tuple[str, str, Callable[[Case], Iterable[Point]]]] = {
    "tube": ("limited", "tube", lambda _: _time_points()),
    "tube_rate": ("limited", "tube_rate", lambda _: _time_points()),
    "control": ("unlimited", "control", _spline_points),
    "control_limited": ("limited", "control", _spline_points),
    "margin": ("limited", "margin", _spline_points),
    "margins": ("limited", "margins", _spline_points),
    "covered": ("limited", "covered", _start_points),
    "control_tick": ("limited", "control_tick", _tick_points),
    "transform": ("limited", "transform", lambda _: _boxes()),
    "alpha_init": ("adaptive", "alpha_init", lambda _: [{}]),
    "alpha_step": ("adaptive", "alpha_step", lambda _: _step_points()),
    "alpha_rate": ("adaptive", "alpha_rate", lambda _: _alpha_points(False)),
    "adaptive_tube": ("adaptive", "tube", lambda _: _alpha_points(False)),
    "adaptive_tube_rate": ("adaptive", "tube_rate", lambda _: _alpha_points(False)),
    "adaptive_control": ("adaptive", "control", lambda _: _alpha_points(True)),
    "adaptive_margin": ("adaptive", "margin", lambda _: _alpha_points(True)),
    "adaptive_margins": ("adaptive", "margins", lambda _: _alpha_points(True)),
}
SPLINE: Mapping[str, Specification] = {
    "tube": expected.tube,
    "tube_rate": expected.tube_rate,
    "control": expected.control_of(expected.spline_edges),
    "control_tick": expected.control_of(expected.spline_edges),
    "margin": expected.margin_of(expected.spline_edges),
    "margins": expected.margins_of(expected.spline_edges),
    "covered": expected.covered,
    "transform": expected.transform,
}
ADAPTIVE: Mapping[str, Specification] = {
    "tube": expected_adaptive.adaptive_tube,
    "tube_rate": expected_adaptive.adaptive_rate,
    "control": expected.control_of(expected_adaptive.adaptive_edges),
    "margin": expected.margin_of(expected_adaptive.adaptive_edges),
    "margins": expected.margins_of(expected_adaptive.adaptive_edges),
    "alpha_init": expected_adaptive.alpha_init,
    "alpha_step": expected_adaptive.alpha_step,
    "alpha_rate": expected_adaptive.alpha_rate,
}


FORMULAS: Mapping[DesignKind, Mapping[str, Specification]] = {"refined": SPLINE, "adaptive": ADAPTIVE, "literal": ADAPTIVE}

# The comparisons of every function, by the names of both sides. They decide its path; any other comparison leaves it open.
_SPLINE_TIME = ("lt 0 t", "lt scaled 4")
_NEAREST_EDGE = ("lt to_upper to_lower", "lt smallest distance", "lt 0 distance")
_GUARDED = ("lt 0 width", "lt 9.5367431640625e-07 width", "lt to_upper to_lower", "lt smallest safe_distance")
_LIMIT = ("lt u_min u_i", "lt u_limit u_raised")
_WIDTH_SHARE = ("lt to_upper to_lower", "lt x_share -1", "lt margin_x margin")
_ALPHA = ("lt 0 alpha_low_in", "lt alpha_low_raised 44", "lt 0 alpha_high_in", "lt alpha_high_raised 44")
_CLAMPED = ("lt 0 t", "lt started t_c", *_ALPHA)
FRAMES: Mapping[str, Sequence[str]] = {
    "tube": ("finite t", *_SPLINE_TIME),
    "tube_rate": ("finite t", *_SPLINE_TIME, "lt t 9"),
    "control": ("le zero 0", *_SPLINE_TIME, *_NEAREST_EDGE),
    "control_limited": ("le zero 0", *_SPLINE_TIME, *_NEAREST_EDGE, *_LIMIT),
    "margin": ("le zero 0", *_SPLINE_TIME, *_WIDTH_SHARE),
    "margins": ("finite t", *_SPLINE_TIME, *_WIDTH_SHARE[:2]),
    "covered": ("lt x_lower x_i", "lt x_i x_upper"),
    "control_tick": ("le zero 0", "tlt tick 9000", "ilt passed 9000", "ilt whole 3", *_NEAREST_EDGE, *_LIMIT),
    "transform": (*_GUARDED, "lt -0.99 e_i", "lt 0.99 e_raised", "finite x_i", "finite width"),
    "alpha_init": (),
    "alpha_step": ("le zero 0", "lt 0 dt", "lt dt 1048576", *_CLAMPED),
    "alpha_rate": ("le zero 0", *_CLAMPED),
    "adaptive_tube": ("le zero 0", *_CLAMPED),
    "adaptive_tube_rate": ("le zero 0", *_CLAMPED),
    "adaptive_control": ("le x_zeros 0", *_CLAMPED, *_GUARDED, "lt 0 distance"),
    "adaptive_margin": ("le x_zeros 0", *_CLAMPED, "lt 9.5367431640625e-07 width", *_WIDTH_SHARE),
    "adaptive_margins": ("le zero 0", *_CLAMPED, "lt 9.5367431640625e-07 width", *_WIDTH_SHARE[:2]),
}


def prove(name: str) -> Outcome:
    """Compare the function of a lemma with its formulas at its points."""
    example, function, points = SUBJECTS[name]
    case = cases()[example]
    return check(case, function, points(case), FORMULAS[case.design.kind][function], FRAMES[name])


STATEMENTS = {
    "tube": ("both edges, NaN for a t that is not finite", r"\gamma_{L,U}(t)"),
    "tube_rate": ("the rates of both edges, 0 from t_c on", r"\dot\gamma_{L,U}(t)"),
    "control": (
        "u = -k xi eps on distances held by e_max, saturated where asked, 0 in an empty tube; and the status",
        r"u = -k\,\xi\,\varepsilon",
    ),
    "margin": ("the least share of the width to the nearer edge, from 1/2 down to -1", r"\min_i \min(a_i, b_i)/\gamma_{d,i}"),
    "margins": (
        "by component the share of the width to the nearer edge, at most 1/2 and at least -1",
        r"\min(a_i, b_i)/\gamma_{d,i}",
    ),
    "covered": ("whether every component of x is strictly between both tables of starts", r"s^-_i < x_i < s^+_i"),
    "control_tick": ("the same law at tick periods, segment and rest in integers", r"u = -k\,\xi\,\varepsilon"),
    "transform": ("e clamped, eps and xi; 0 in an empty component, NaN where something is not finite", r"e,\ \varepsilon,\ \xi"),
    "alpha_init": ("zeros", r"\alpha(0) = 0"),
    "alpha_step": ("one implicit step of (11) to t + dt, or none", r"\alpha(t+dt)"),
    "alpha_rate": ("(11) and its Jacobian with psi of rho and beta", r"\dot\alpha"),
}
KINDS = {"limited": " with u_max", "adaptive": " of an adaptive tube"}


def _lemmas() -> Iterator[Lemma]:
    """Yield one lemma for each of SUBJECTS."""
    for name, (example, function, _) in SUBJECTS.items():
        words, latex = STATEMENTS[function]
        yield Lemma(
            f"functions.{name}",
            f"The emitted `{function}`{KINDS[example] if name != function else ''} gives {words}, on every path.",
            latex,
            (
                "every kernel is what its own lemma says",
                "its comparisons are those of the frame's list, no others, and each has both outcomes among the points",
                "paths taken at points of every regime and on both sides of every change",
            ),
            "Program",
            partial(prove, name),
        )


LEMMAS = tuple(_lemmas())
