"""The formulas that the emitted functions of an adaptive tube must equal: (4)-(11) by dimension and side. One formula for each
regime, as in expected.py."""

from __future__ import annotations

from itertools import product
from typing import Any

import sympy as sp

from stt_codegen.controller.kernels import LONGEST_STEP, alpha_cap
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign
from stt_codegen.lemmas.emitted.examples import (
    ALPHA,
    BOX,
    DT,
    T_C,
    CaseOf,
    N,
    Point,
    T,
    Wanted,
    all_finite,
    entry,
    kernel_of,
    rational,
)
from stt_codegen.paper.adaptive_tube import NEWTON
from stt_codegen.paper.circumvent import CUT

AdaptiveCase = CaseOf[AdaptiveDesign]


def _held(t: float) -> tuple[str, Any]:
    return ("late", rational(T_C)) if t >= T_C else ("running", T) if t > 0 else ("early", sp.Integer(0))


def _lines(case: AdaptiveCase, held: Any, i: int, rates: bool = False) -> dict[tuple[str, int], Any]:
    """rho and beta of one dimension by name and side, and their rates."""
    design = case.design
    t_c, nu, cut = rational(T_C), rational(design.nu), rational(CUT["double"])
    profile = "profile_rate" if rates else "profile"
    sigma = kernel_of(profile, 0, held, t_c)
    found: dict[tuple[str, int], Any] = {}
    for side in (LOWER, UPPER):
        start, end = (entry("reach", 4 * i + 2 * side + k) for k in (0, 1))
        found["rho", side] = kernel_of("reach_edge", 0, start, end, sigma)
        found["rho_rate", side] = kernel_of("reach_rate", 0, start, end, kernel_of(profile, 1, held, t_c)) if rates else None
        joined, slope = sp.Integer(0), sp.Integer(0)
        for k in range(design.slots[side]):
            row = 4 * (sum(design.slots) * i + design.slots[LOWER] * side + k)
            numbers = [entry("bumps", row + column) for column in range(4)]
            several = design.slots[side] > 1
            if rates:
                bump, rate = (kernel_of("circumvent_rate", o, held, *numbers, cut) for o in (0, 1))
                inputs = (joined, bump, slope, rate, nu)
                joined, slope = (kernel_of("join_rate", o, *inputs) for o in (0, 1)) if several else (bump, rate)
            else:
                bump = kernel_of("circumvent", 0, held, *numbers, cut)
                joined = kernel_of("join", 0, joined, bump, nu) if several else bump
        sign = 1 if side == LOWER else -1
        found["beta", side] = entry("walls", 2 * i + side) + sign * joined
        found["beta_rate", side] = sign * slope
    found["psi", LOWER] = found["beta", UPPER] - found["rho", LOWER]
    found["psi", UPPER] = found["rho", UPPER] - found["beta", LOWER]
    return found


def _alphas(case: AdaptiveCase, point: Point, i: int) -> tuple[Any, list[Any]]:
    """alpha_L and alpha_U held within [0, cap]."""
    design = case.design
    cap = alpha_cap(design)
    regimes, values = [], []
    for side in (LOWER, UPPER):
        number, symbol = point["alpha"][i + N * side], ALPHA[i + N * side]
        regime = "none" if number <= 0 else "cap" if number >= cap else "free"
        regimes.append(regime)
        values.append({"none": sp.Integer(0), "cap": rational(cap), "free": symbol}[regime])
    return tuple(regimes), values


def _parameters(case: AdaptiveCase) -> list[Any]:
    design = case.design
    return [rational(v) for v in (design.theta0, design.kappa, design.mu, design.varsigma)]


def adaptive_edges(case: AdaptiveCase, point: Point) -> tuple[Any, list[tuple[Any, Any]]]:
    design = case.design
    regime, held = _held(point["t"])
    regimes, edges, nu = [regime], [], rational(design.nu)
    for i in range(N):
        lines = _lines(case, held, i)
        clamped, alpha = _alphas(case, point, i)
        regimes.append(clamped)
        names = ("lower_edge", "upper_edge")
        low, high = (kernel_of(names[s], 0, lines["rho", s], alpha[s], lines["beta", s], nu) for s in (LOWER, UPPER))
        edges.append((low, high))
    return tuple(regimes), edges


def adaptive_tube(case: AdaptiveCase, point: Point) -> Wanted:
    if not all_finite(point):
        return "bad", {name: [sp.nan] * N for name in BOX}, None
    regime, edges = adaptive_edges(case, point)
    return regime, {name: [edge[side] for edge in edges] for side, name in enumerate(BOX)}, None


def adaptive_rate(case: AdaptiveCase, point: Point) -> Wanted:
    names = ("lower_rate", "upper_rate")
    if not all_finite(point):
        return "bad", {name: [sp.nan] * N for name in names}, None
    design = case.design
    regime, held = _held(point["t"])
    regimes: list[Any] = [regime]
    rates: dict[str, list[Any]] = {name: [] for name in names}
    for i in range(N):
        lines = _lines(case, held, i, rates=True)
        clamped, alpha = _alphas(case, point, i)
        regimes.append(clamped)
        for side, name in enumerate(names):
            moving = kernel_of("update_rate", 0, lines["psi", side], alpha[side], *_parameters(case))
            inputs = (lines["rho", side], alpha[side], lines["beta", side], rational(design.nu))
            kernel = "lower_edge_rate" if side == LOWER else "upper_edge_rate"
            rates[name].append(kernel_of(kernel, 1, *inputs, lines["rho_rate", side], moving, lines["beta_rate", side]))
    return tuple(regimes), rates, None


def alpha_rate(case: AdaptiveCase, point: Point) -> Wanted:
    if not all_finite(point):
        return "bad", {name: [sp.nan] * 2 * N for name in ("rate", "jacobian")}, None
    regime, held = _held(point["t"])
    regimes, outputs = [regime], {"rate": [None] * 2 * N, "jacobian": [None] * 2 * N}
    for i in range(N):
        lines = _lines(case, held, i)
        clamped, alpha = _alphas(case, point, i)
        regimes.append(clamped)
        for side, (k, name) in product((LOWER, UPPER), enumerate(outputs)):
            outputs[name][i + N * side] = kernel_of("update_rate", k, lines["psi", side], alpha[side], *_parameters(case))
    return tuple(regimes), outputs, None


def alpha_step(case: AdaptiveCase, point: Point) -> Wanted:
    """Backward Euler to t + dt: p, q, rest and z_0, NEWTON iterates, the end. Unchanged for dt <= 0 or what is not finite."""
    if not all_finite(point) or point["dt"] <= 0:
        return ("stays", all_finite(point)), {"alpha": list(ALPHA)}, None
    long = point["dt"] >= LONGEST_STEP
    h = rational(LONGEST_STEP) if long else DT
    regime, held = _held(point["t"] + point["dt"])
    held = T + DT if regime == "running" else held
    regimes, after = [regime, long], [sp.Integer(0)] * 2 * N
    for i in range(N):
        lines = _lines(case, held, i)
        clamped, alpha = _alphas(case, point, i)
        regimes.append(clamped)
        for side in (LOWER, UPPER):
            p, q, rest, z = (
                kernel_of("implicit_start", k, lines["psi", side], alpha[side], h, *_parameters(case)) for k in range(4)
            )
            for _ in range(NEWTON):
                z = kernel_of("newton", 0, p, q, z)
            after[i + N * side] = kernel_of("implicit_end", 0, q, rest, z)
    return tuple(regimes), {"alpha": after}, None


def alpha_init(_case: AdaptiveCase, _point: Point) -> Wanted:
    return "always", {"alpha": [sp.Integer(0)] * 2 * N}, None
