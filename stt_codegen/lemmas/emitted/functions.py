"""Every emitted function on every path: its frame (finite test, held time, segment, clamps, saturation, status) puts the kernels
together as the paper's equations, repaired, say.

Where its paths part is known beforehand: its comparisons are the list in `FRAMES`, and a function with another one is open. A
function of a small example program is followed at points of every regime, edges, empty tubes and odd numbers included. On the
path of a point its outputs are formulas in t, x, alpha and table entries, which stay symbols, so they hold for every design of
that shape; they are compared with formulas put together from the equations (expected.py). Kernels stay symbols too: lemmas of
their own say what they are. Points of one path that these formulas treat differently are all compared. Where neighbouring points
are on different paths, the line between them is halved to where the path changes, and both sides are looked at: so a threshold
that is off by more than a millionth of the distance shows.

Long because the points, the comparisons and the statement of every emitted function stand together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import product
from typing import Any

import sympy as sp

from stt_codegen.controller import ticks_of
from stt_codegen.design_kinds import DesignKind
from stt_codegen.lemmas.emitted import expected, expected_adaptive
from stt_codegen.lemmas.emitted.examples import FOLLOWED, SYMBOLS, Case, N, Point, Spec, cases
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict
from stt_codegen.program import Status
from stt_codegen.program.analyse import comparisons
from stt_codegen.program.symbolic import follow, formulas_on

HALVINGS = 20
STRIDES = (1, 2, 3)  # of the lists of points: two or three of a kind


def check(case: Case, function: str, points: Iterable[Point], spec: Spec, frame: Sequence[str]) -> Outcome:
    """Proved when the function's comparisons are those of its frame, each with both outcomes among the points, and on every path
    and regime of the points the outputs are those of the formulas."""
    seen: dict[Any, Any] = {}
    looked = 0
    given = list(points)
    compared = comparisons(case.program, case.program.function(function), FOLLOWED)
    left = [f"{what} is no comparison of the frame" for what in compared if what not in frame]
    left += [f"{what} is not compared" for what in frame if what not in compared]
    outcomes = set()
    for point in [*given, *_borders(case, function, given)]:
        looked += 1
        path = follow(case.program, function, point, case.opaque)
        outcomes |= set(zip(compared, path.decisions, strict=False))  # a path that leaves early decides less
        regime, outputs, result = spec(case, point)
        seen.setdefault((path.decisions, regime), (path, point, outputs, result))
    left += [f"{what} is never {value}" for what in frame for value in (True, False) if (what, value) not in outcomes]
    for path, point, outputs, result in seen.values():
        found = formulas_on(case.program, function, SYMBOLS, path, case.opaque)
        pairs = [
            (f"{name}[{i}]", v, w)
            for name in outputs
            for i, (v, w) in enumerate(zip(found.outputs[name], outputs[name], strict=True))
        ]
        pairs += [("result", found.result, result)]
        left += [f"{name} at {_shown(point)}: {v} for {w}"[:300] for name, v, w in pairs if not _same(v, w)]
    method = "SymPy: the function followed at points of every regime, its formulas on each path compared"
    if left:
        return Outcome(Verdict.OPEN, method, tuple(left))
    return Outcome(Verdict.PROVED, method, (f"{function}: {len(seen)} paths and regimes, {looked} points",))


def _borders(case: Case, function: str, points: Sequence[Point]) -> Iterator[Point]:
    """Two points close together, on either side of where the path changes between neighbours in the list."""
    crossed = set()
    paths = [follow(case.program, function, p, case.opaque).decisions for p in points]
    strides = STRIDES[:1] if case.design.is_stateful else STRIDES  # an adaptive tube's paths cost more to follow
    for stride, k in product(strides, range(len(points))):
        if k + stride >= len(points) or (paths[k], paths[k + stride]) in crossed or not points[k]:
            continue
        near, far = points[k], points[k + stride]
        if paths[k] == paths[k + stride] or not _finite_point(near) or not _finite_point(far):
            continue
        crossed.add((paths[k], paths[k + stride]))
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            same = follow(case.program, function, _between(near, far, middle), case.opaque).decisions == paths[k]
            low, high = (middle, high) if same else (low, middle)
        yield from (_between(near, far, low), _between(near, far, high))


def _between(a: Point, b: Point, share: float) -> Point:
    def mix(x: Any, y: Any) -> Any:
        if isinstance(x, list | tuple):
            return [mix(v, w) for v, w in zip(x, y, strict=True)]
        return x + round(share * (y - x)) if isinstance(x, int) else x + share * (y - x)

    return {name: mix(a[name], b[name]) for name in a}


def _finite_point(point: Point) -> bool:
    return all(math.isfinite(v) for value in point.values() for v in (value if isinstance(value, list | tuple) else [value]))


def _same(found: Any, wanted: Any) -> bool:
    if isinstance(found, bool) or isinstance(wanted, bool):
        return found is wanted
    if found is None or wanted is None or isinstance(found, Status) or isinstance(wanted, Status):
        return found is wanted
    if sp.sympify(found) is sp.nan or sp.sympify(wanted) is sp.nan:
        return sp.sympify(found) is sp.sympify(wanted)
    difference = sp.sympify(found) - wanted
    return bool(sp.expand(difference) == 0 or sp.cancel(difference) == 0)


def _shown(point: Point) -> str:
    return ", ".join(f"{k} = {v}" for k, v in point.items())


# ------------------------------------------------------------------------------------------------ points

TIMES = (-1.0, 0.0, 0.3, 2.5, 5.0, 8.9, 9.0, 12.0)
ODD = (math.nan, math.inf, -math.inf)
SHARES = (-2.5, -0.1, 0.0, 0.001, 0.2, 0.5, 0.8, 0.999, 1.0, 1.1, 3.5)  # of the width, from the lower edge
APART = (-2.5, -0.1, 0.001, 0.2, 0.8, 0.999, 1.1, 3.5)  # from ties: `tube` in seconds tells where a tick's are to rounding only
ALPHAS = ((0.0, 0.1, 0.0, 0.2), (-1.0, 0.0, 1e30, 0.5), (0.3, 1e9, 0.2, -2.0))


def _times() -> list[Point]:
    return [{"t": t} for t in (*TIMES, *ODD)]


def _states(
    case: Case, arguments: Mapping[str, Any], extra: Mapping[str, Any], several: Sequence[float] = SHARES
) -> Iterator[Point]:
    """Every share in one component while the other is at a fifth; both alike; and a narrow tube's own odd places."""
    tube = follow(case.program, "tube", arguments, case.opaque).outputs
    shares = [pair for s in several for pair in ((s, 0.2), (0.2, s), (s, s))]
    for pair in shares:
        widths = [tube["upper"][i] - tube["lower"][i] for i in range(N)]
        x = [tube["lower"][i] + pair[i] * (widths[i] if abs(widths[i]) > 1e-9 else 1e-3) for i in range(N)]
        yield {**extra, "x": [tube["upper"][i] if pair[i] == 1.0 else x[i] for i in range(N)]}


def _bad_states(extra: Mapping[str, Any]) -> Iterator[Point]:
    for odd in ODD:
        yield {**extra, "x": [odd, 1.0]}
        yield {**extra, "x": [1.0, odd]}


def _spline_points(case: Case) -> Iterator[Point]:
    for t in TIMES:
        yield from _states(case, {"t": t}, {"t": t})
    yield from _bad_states({"t": 1.0})
    yield from ({"t": odd, "x": [1.0, 1.0]} for odd in ODD)


def _start_points(case: Case) -> Iterator[Point]:
    yield from _states(case, {"t": 0.0}, {})
    yield from _bad_states({})


def _tick_points(case: Case) -> Iterator[Point]:
    ticks = ticks_of(case.design, Fraction(1, 1000))
    for tick in (0, 1, 2400, 6750, 8999, ticks.last - 1, ticks.last, ticks.last + 1, 2**32 - 1):
        yield from _states(case, {"t": tick / 1000}, {"tick": tick}, APART)
    yield from _bad_states({"tick": 7})


def _alpha_points(x: bool) -> Iterator[Point]:
    case = cases()["adaptive"]
    for t, alpha in product((-1.0, 2.5, 12.0) if x else TIMES, ALPHAS):
        extra = {"t": t, "alpha": list(alpha)}
        yield from _states(case, extra, extra) if x else (extra,)
    for odd in ODD:
        states = {"x": [1.0, 1.0]} if x else {}
        yield {"t": odd, "alpha": list(ALPHAS[0]), **states}
        for k in range(2 * N):
            yield {"t": 1.0, "alpha": [odd if i == k else 0.1 for i in range(2 * N)], **states}
    if x:
        yield from _bad_states({"t": 1.0, "alpha": list(ALPHAS[0])})


def _step_points() -> Iterator[Point]:
    for point, dt in product(_alpha_points(False), (0.01, 1e9, 0.0, -1.0, math.nan)):
        yield {**point, "dt": dt}


def _boxes() -> Iterator[Point]:
    """Edges and states of `transform`: both components alike or different, empty, narrow, wide, not finite."""
    sides = [(0.0, 1.0), (0.0, 2.0**-22), (1.0, 1.0), (2.0, 1.0), (math.nan, 1.0), (0.0, math.inf)]
    for share, (low, high) in product((*SHARES, math.nan), sides):
        x = low + share * (high - low if 0 < high - low < 10 else 1.0)
        yield {"lower": [low, 0.0], "upper": [high, 1.0], "x": [x, 0.2]}
        yield {"lower": [0.0, low], "upper": [1.0, high], "x": [0.9, x]}


# By lemma: the example, the emitted function, and its points.
SUBJECTS: Mapping[str, tuple[str, str, Callable[[Case], Iterable[Point]]]] = {
    **{f"{case}_tube": (case, "tube", lambda _: _times()) for case in ("wide", "narrow")},
    **{f"{case}_tube_rate": (case, "tube_rate", lambda _: _times()) for case in ("wide", "narrow")},
    **{f"{case}_control": (case, "control", _spline_points) for case in ("wide", "narrow")},
    **{f"{case}_margin": (case, "margin", _spline_points) for case in ("wide", "narrow")},
    **{f"{case}_margins": (case, "margins", _spline_points) for case in ("wide", "narrow")},
    "covered": ("wide", "covered", _start_points),
    "control_tick": ("wide", "control_tick", _tick_points),
    "transform": ("narrow", "transform", lambda _: _boxes()),
    "alpha_init": ("adaptive", "alpha_init", lambda _: [{}]),
    "alpha_step": ("adaptive", "alpha_step", lambda _: _step_points()),
    "alpha_rate": ("adaptive", "alpha_rate", lambda _: _alpha_points(False)),
    "adaptive_tube": ("adaptive", "tube", lambda _: _alpha_points(False)),
    "adaptive_tube_rate": ("adaptive", "tube_rate", lambda _: _alpha_points(False)),
    "adaptive_control": ("adaptive", "control", lambda _: _alpha_points(True)),
    "adaptive_margin": ("adaptive", "margin", lambda _: _alpha_points(True)),
    "adaptive_margins": ("adaptive", "margins", lambda _: _alpha_points(True)),
}
SPLINE: Mapping[str, Spec] = {
    "tube": expected.tube,
    "tube_rate": expected.tube_rate,
    "control": expected.control_of(expected.spline_edges),
    "control_tick": expected.control_of(expected.spline_edges),
    "margin": expected.margin_of(expected.spline_edges),
    "margins": expected.margins_of(expected.spline_edges),
    "covered": expected.covered,
    "transform": expected.transform,
}
ADAPTIVE: Mapping[str, Spec] = {
    "tube": expected_adaptive.adaptive_tube,
    "tube_rate": expected_adaptive.adaptive_rate,
    "control": expected.control_of(expected_adaptive.adaptive_edges),
    "margin": expected.margin_of(expected_adaptive.adaptive_edges),
    "margins": expected.margins_of(expected_adaptive.adaptive_edges),
    "alpha_init": expected_adaptive.alpha_init,
    "alpha_step": expected_adaptive.alpha_step,
    "alpha_rate": expected_adaptive.alpha_rate,
}


FORMULAS: Mapping[DesignKind, Mapping[str, Spec]] = {"refined": SPLINE, "adaptive": ADAPTIVE, "literal": ADAPTIVE}

# The comparisons of every function, by the names of what is compared: where its paths part. Another one is refused.
_TIME = ("lt 0 t", "lt scaled 4")
_PLACE = ("lt to_upper to_lower", "lt least nearest", "lt 0 nearest")
_GUARDED = ("lt 0 room", "lt 9.5367431640625e-07 room", "lt to_upper to_lower", "lt least distance")
_LIMIT = ("lt u_min push", "lt u_limit u_held_raised")
_SHARE = ("lt to_upper to_lower", "lt share -1", "lt held_share margin")
_ALPHA = ("lt 0 alpha_low_in", "lt alpha_low_raised 44", "lt 0 alpha_high_in", "lt alpha_high_raised 44")
_HELD = ("lt 0 t", "lt started t_c", *_ALPHA)
FRAMES: Mapping[str, Sequence[str]] = {
    **{f"{case}_tube": ("finite t", *_TIME) for case in ("wide", "narrow")},
    **{f"{case}_tube_rate": ("finite t", *_TIME, "lt t 9") for case in ("wide", "narrow")},
    "wide_control": ("le zero 0", *_TIME, *_PLACE, *_LIMIT),
    "narrow_control": ("le zero 0", *_TIME, *_GUARDED, "lt 0 nearest"),
    "wide_margin": ("le zero 0", *_TIME, *_SHARE),
    "narrow_margin": ("le zero 0", *_TIME, "lt 9.5367431640625e-07 room", *_SHARE),
    "wide_margins": ("finite t", *_TIME, *_SHARE[:2]),
    "narrow_margins": ("finite t", *_TIME, "lt 9.5367431640625e-07 room", *_SHARE[:2]),
    "covered": ("lt start_lower_i x_i", "lt x_i start_upper_i"),
    "control_tick": ("le zero 0", "tlt tick 9000", "ilt passed 9000", "ilt whole 3", *_PLACE, *_LIMIT),
    "transform": (*_GUARDED, "lt -0.99 e_raw", "lt 0.99 e_held_raised", "finite x_i", "finite room"),
    "alpha_init": (),
    "alpha_step": ("le zero 0", "lt 0 dt", "lt dt 1048576", *_HELD),
    "alpha_rate": ("le zero 0", *_HELD),
    "adaptive_tube": ("le zero 0", *_HELD),
    "adaptive_tube_rate": ("le zero 0", *_HELD),
    "adaptive_control": ("le zero2 0", *_HELD, *_GUARDED, "lt 0 nearest"),
    "adaptive_margin": ("le zero2 0", *_HELD, "lt 9.5367431640625e-07 room", *_SHARE),
    "adaptive_margins": ("le zero 0", *_HELD, "lt 9.5367431640625e-07 room", *_SHARE[:2]),
}


def prove(name: str) -> Outcome:
    """The function of a lemma, at its points, against its formulas."""
    kind, function, points = SUBJECTS[name]
    case = cases()[kind]
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
KINDS = {"wide": " of a refined tube", "narrow": " of a refined tube that may be empty", "adaptive": " of an adaptive tube"}


def _lemmas() -> Iterator[Lemma]:
    for name, (kind, function, _) in SUBJECTS.items():
        told, latex = STATEMENTS[function]
        yield Lemma(
            f"functions.{name}",
            f"The emitted `{function}`{KINDS[kind] if name != function else ''} gives {told}, on every path.",
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
