"""Formulas that the emitted functions of an adaptive tube must equal: (4)-(11) by dimension and side.

A formula holds in one regime, as in expected.py. functions.py compares them with the program.
"""

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
    Expected,
    N,
    Point,
    T,
    is_finite_point,
    kernel_of,
    rational,
    table_entry,
)
from stt_codegen.paper.adaptive_tube import NEWTON
from stt_codegen.paper.circumvent import CUT

AdaptiveCase = CaseOf[AdaptiveDesign]


def _clamped_time(t: float) -> tuple[str, Any]:
    return ("late", rational(T_C)) if t >= T_C else ("running", T) if t > 0 else ("early", sp.Integer(0))


def _reach_and_bumps(case: AdaptiveCase, time: Any, i: int, rates: bool = False) -> dict[tuple[str, int], Any]:
    """Return rho, beta and psi of one dimension by name and side at a time; with `rates` also the rates of rho and beta."""
    design = case.design
    t_c, nu, cut = rational(T_C), rational(design.nu), rational(CUT["double"])
    profile = "profile_rate" if rates else "profile"
    sigma = kernel_of(profile, 0, time, t_c)
    parts: dict[tuple[str, int], Any] = {}
    for side in (LOWER, UPPER):
        start, end = (table_entry("reach", 4 * i + 2 * side + k) for k in (0, 1))
        parts["rho", side] = kernel_of("reach_edge", 0, start, end, sigma)
        parts["rho_rate", side] = kernel_of("reach_rate", 0, start, end, kernel_of(profile, 1, time, t_c)) if rates else None
        joined, joined_rate = sp.Integer(0), sp.Integer(0)
        for k in range(design.slots[side]):
            row = 4 * (sum(design.slots) * i + design.slots[LOWER] * side + k)
            numbers = [table_entry("bumps", row + column) for column in range(4)]
            has_several = design.slots[side] > 1
            if rates:
                bump, bump_rate = (kernel_of("circumvent_rate", o, time, *numbers, cut) for o in (0, 1))
                inputs = (joined, bump, joined_rate, bump_rate, nu)
                joined, joined_rate = (kernel_of("join_rate", o, *inputs) for o in (0, 1)) if has_several else (bump, bump_rate)
            else:
                bump = kernel_of("circumvent", 0, time, *numbers, cut)
                joined = kernel_of("join", 0, joined, bump, nu) if has_several else bump
        sign = 1 if side == LOWER else -1
        parts["beta", side] = table_entry("walls", 2 * i + side) + sign * joined
        parts["beta_rate", side] = sign * joined_rate
    parts["psi", LOWER] = parts["beta", UPPER] - parts["rho", LOWER]
    parts["psi", UPPER] = parts["rho", UPPER] - parts["beta", LOWER]
    return parts


def _alphas(case: AdaptiveCase, point: Point, i: int) -> tuple[Any, list[Any]]:
    """Return the regimes and formulas of alpha_L and alpha_U, clamped to [0, cap]."""
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
    """Return the regime and both edges of (10) by component, of clamped time and alpha."""
    design = case.design
    regime, time = _clamped_time(point["t"])
    regimes, edges, nu = [regime], [], rational(design.nu)
    for i in range(N):
        parts = _reach_and_bumps(case, time, i)
        clamped, alpha = _alphas(case, point, i)
        regimes.append(clamped)
        names = ("lower_edge", "upper_edge")
        low, high = (kernel_of(names[s], 0, parts["rho", s], alpha[s], parts["beta", s], nu) for s in (LOWER, UPPER))
        edges.append((low, high))
    return tuple(regimes), edges


def adaptive_tube(case: AdaptiveCase, point: Point) -> Expected:
    if not is_finite_point(point):
        return "bad", {name: [sp.nan] * N for name in BOX}, None
    regime, edges = adaptive_edges(case, point)
    return regime, {name: [edge[side] for edge in edges] for side, name in enumerate(BOX)}, None


def adaptive_rate(case: AdaptiveCase, point: Point) -> Expected:
    """Return the rates of both edges, where alpha moves by (11); NaN where a number is not finite."""
    names = ("lower_rate", "upper_rate")
    if not is_finite_point(point):
        return "bad", {name: [sp.nan] * N for name in names}, None
    design = case.design
    regime, time = _clamped_time(point["t"])
    regimes: list[Any] = [regime]
    rates: dict[str, list[Any]] = {name: [] for name in names}
    for i in range(N):
        parts = _reach_and_bumps(case, time, i, rates=True)
        clamped, alpha = _alphas(case, point, i)
        regimes.append(clamped)
        for side, name in enumerate(names):
            alpha_rate = kernel_of("update_rate", 0, parts["psi", side], alpha[side], *_parameters(case))
            inputs = (parts["rho", side], alpha[side], parts["beta", side], rational(design.nu))
            kernel = "lower_edge_rate" if side == LOWER else "upper_edge_rate"
            rates[name].append(kernel_of(kernel, 1, *inputs, parts["rho_rate", side], alpha_rate, parts["beta_rate", side]))
    return tuple(regimes), rates, None


def alpha_rate(case: AdaptiveCase, point: Point) -> Expected:
    """Return (11) and its derivative in alpha by dimension and side; NaN where a number is not finite."""
    if not is_finite_point(point):
        return "bad", {name: [sp.nan] * 2 * N for name in ("rate", "jacobian")}, None
    regime, time = _clamped_time(point["t"])
    regimes, outputs = [regime], {"rate": [None] * 2 * N, "jacobian": [None] * 2 * N}
    for i in range(N):
        parts = _reach_and_bumps(case, time, i)
        clamped, alpha = _alphas(case, point, i)
        regimes.append(clamped)
        for side, (k, name) in product((LOWER, UPPER), enumerate(outputs)):
            outputs[name][i + N * side] = kernel_of("update_rate", k, parts["psi", side], alpha[side], *_parameters(case))
    return tuple(regimes), outputs, None


def alpha_step(case: AdaptiveCase, point: Point) -> Expected:
    """Return alpha after a backward Euler step to t + dt by NEWTON iterates; unchanged for dt <= 0 and where not finite."""
    if not is_finite_point(point) or point["dt"] <= 0:
        return ("stays", is_finite_point(point)), {"alpha": list(ALPHA)}, None
    is_limited = point["dt"] >= LONGEST_STEP
    h = rational(LONGEST_STEP) if is_limited else DT
    regime, time = _clamped_time(point["t"] + point["dt"])
    time = T + DT if regime == "running" else time
    regimes, next_alpha = [regime, is_limited], [sp.Integer(0)] * 2 * N
    for i in range(N):
        parts = _reach_and_bumps(case, time, i)
        clamped, alpha = _alphas(case, point, i)
        regimes.append(clamped)
        for side in (LOWER, UPPER):
            p, q, rest, z = (
                kernel_of("implicit_start", k, parts["psi", side], alpha[side], h, *_parameters(case)) for k in range(4)
            )
            for _ in range(NEWTON):
                z = kernel_of("newton", 0, p, q, z)
            next_alpha[i + N * side] = kernel_of("implicit_end", 0, q, rest, z)
    return tuple(regimes), {"alpha": next_alpha}, None


def alpha_init(_case: AdaptiveCase, _point: Point) -> Expected:
    return "always", {"alpha": [sp.Integer(0)] * 2 * N}, None
