"""The paper's equations in plain NumPy, which every backend must match: written from the paper, and not from `paper/`.

This file imports neither CasADi nor anything of this package, and works on the plain data of a design. It evaluates everything in
`numpy.longdouble` (64 bits of significand on x86-64), so that its own rounding is negligible beside a double's. compare/ calls
it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.longdouble]
OK, OUTSIDE_TUBE, BAD_INPUT = 0, 1, 2

# The uniform cubic B-spline in powers of s: row j holds the coefficients of 1, s, s^2, s^3 of basis function j, times 6.
BASIS = np.array([[1, -3, 3, -1], [4, 0, -6, 3], [1, 3, 3, -3], [0, 0, 0, 1]], dtype=np.longdouble)


def exact(value: Fraction) -> np.longdouble:
    """Return a fraction in extended precision."""
    return np.longdouble(value.numerator) / np.longdouble(value.denominator)


def tube(table: npt.ArrayLike, unit: Fraction, t_c: Fraction, t: npt.ArrayLike) -> tuple[Array, Array]:
    """Return the edges of a refined tube at times t (shape (P,)): lower and upper, each of shape (P, n).

    table: integers of shape (K + 3, n, 2), control points over 6 in multiples of `unit`. NaN where t is not finite.
    """
    s, segment = _spline_time(table, t_c, t)
    powers = np.stack([np.ones_like(s), s, s**2, s**3])
    return _edges(table, unit, segment, BASIS @ powers, t)


def tube_rate(table: npt.ArrayLike, unit: Fraction, t_c: Fraction, t: npt.ArrayLike) -> tuple[Array, Array]:
    """Return the rates of the edges at times t, as `tube`; zero from t_c on."""
    s, segment = _spline_time(table, t_c, t)
    slopes = np.stack([np.zeros_like(s), np.ones_like(s), 2 * s, 3 * s**2])
    segments = np.asarray(table).shape[0] - 3
    scale = np.where(np.asarray(t, dtype=np.longdouble) < exact(t_c), segments / exact(t_c), 0)
    lower, upper = _edges(table, unit, segment, BASIS @ slopes, t)
    return lower * scale[:, None], upper * scale[:, None]


def _spline_time(table: npt.ArrayLike, t_c: Fraction, t: npt.ArrayLike) -> tuple[Array, npt.NDArray[np.intp]]:
    """Return s in [0, 1] within the segment, and the number of the segment, at times t held within [0, t_c]."""
    segments = np.asarray(table).shape[0] - 3
    time = np.nan_to_num(np.asarray(t, dtype=np.longdouble), nan=0.0, posinf=0.0, neginf=0.0)
    u = np.clip(time, 0, exact(t_c)) * segments / exact(t_c)
    segment = np.minimum(np.floor(u).astype(np.intp), segments - 1)
    return u - segment, segment


def _edges(
    table: npt.ArrayLike, unit: Fraction, segment: npt.NDArray[np.intp], weights: Array, t: npt.ArrayLike
) -> tuple[Array, Array]:
    """Return the lower and the upper edge: sums of control points with these weights (4, P); NaN where t is not finite."""
    q = np.asarray(table).astype(np.longdouble) * exact(unit)
    edges = sum(weights[j][:, None, None] * q[segment + j] for j in range(4))
    edges = np.where(np.isfinite(np.asarray(t, dtype=np.longdouble))[:, None, None], edges, np.nan)
    return edges[:, :, 0], edges[:, :, 1]


def transform(
    lower: npt.ArrayLike, upper: npt.ArrayLike, x: npt.ArrayLike, e_max: Sequence[Fraction]
) -> tuple[Array, Array, Array]:
    """Return e, epsilon and xi of section IV by component (diagonal I - e e^T), with e clamped to [-e_max, e_max].

    0 where upper <= lower, NaN where a number is not finite.
    """
    low, high, state = (np.asarray(v, dtype=np.longdouble) for v in (lower, upper, x))
    bound, smallest = np.array([exact(v) for v in e_max]), np.array([exact(1 - v) for v in e_max])
    with np.errstate(all="ignore"):
        gamma_s, gamma_d = high + low, high - low
        e = np.clip((2 * state - gamma_s) / gamma_d, -bound, bound)
        # 1 + e and 1 - e come from the distances to the edges, because near an edge 1 - e would lose the rounding of e
        plus, minus = (np.clip(2 * d / gamma_d, smallest, 2 - smallest) for d in (state - low, high - state))
        epsilon = np.log(plus / minus)
        xi = 4 / (gamma_d * plus * minus)
    empty = gamma_d <= 0
    bad = ~(np.isfinite(low) & np.isfinite(high) & np.isfinite(state))
    e, epsilon, xi = (np.where(bad, np.nan, np.where(empty, 0, v)) for v in (e, epsilon, xi))
    return e, epsilon, xi


def control(
    lower: npt.ArrayLike,
    upper: npt.ArrayLike,
    x: npt.ArrayLike,
    gain: Sequence[Fraction],
    e_max: Sequence[Fraction],
    *,
    u_max: Sequence[Fraction] | None = None,
    scales: bool = False,
) -> tuple[npt.NDArray[np.intp], Array]:
    """Return the status (P,) and u = -k xi epsilon (13) for states x (P, n) in the tube with these edges.

    u_max limits u by component or, if `scales`, as a vector.
    """
    low, high, state = (np.asarray(v, dtype=np.longdouble) for v in (lower, upper, x))
    _, epsilon, xi = transform(low, high, state, e_max)
    u = -np.array([exact(v) for v in gain]) * xi * epsilon
    if u_max is not None:
        bound = np.array([exact(v) for v in u_max])
        largest = np.maximum(np.abs(u).max(axis=1, keepdims=True), bound[:1])
        u = u * (bound[:1] / largest) if scales else np.clip(u, -bound, bound)
    bad = ~np.all(np.isfinite(state) & np.isfinite(low), axis=1)
    inside = np.all((low < state) & (state < high), axis=1)
    u = np.where(bad[:, None], 0, u)
    return np.where(bad, BAD_INPUT, np.where(inside, OK, OUTSIDE_TUBE)), u


def margin(lower: npt.ArrayLike, upper: npt.ArrayLike, x: npt.ArrayLike, minimum_width: float) -> Array:
    """Return the smallest of `margins` over the components; NaN where a number of x or an edge is not finite."""
    low, state = (np.asarray(v, dtype=np.longdouble) for v in (lower, x))
    smallest = margins(lower, upper, x, minimum_width).min(axis=1)
    return np.where(np.isfinite(state).all(axis=1) & np.isfinite(low).all(axis=1), smallest, np.nan)


def margins(lower: npt.ArrayLike, upper: npt.ArrayLike, x: npt.ArrayLike, minimum_width: float) -> Array:
    """Return the distance of x (P, n) to the nearest edge over the width (at least minimum_width), by component, in [-1, 0.5]."""
    low, high, state = (np.asarray(v, dtype=np.longdouble) for v in (lower, upper, x))
    with np.errstate(all="ignore"):
        distance_ratio = np.minimum(state - low, high - state) / np.maximum(high - low, minimum_width)
    return np.asarray(np.clip(distance_ratio, -1, np.longdouble(0.5)))


# -------------------------------------------------------------------------- the paper's tube (4)-(11)


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """The numbers of an adaptive or literal design, as arrays in extended precision.

    start, target, walls: (n, 2), lower and upper. bumps: (dimension, side, B, k, m, r) with side 0 for beta_L.
    """

    t_c: np.longdouble
    start: Array
    target: Array
    walls: Array
    bumps: tuple[tuple[int, int, np.longdouble, np.longdouble, np.longdouble, np.longdouble], ...]
    theta0: np.longdouble
    kappa: np.longdouble
    mu: np.longdouble
    varsigma: np.longdouble
    nu: np.longdouble


@dataclass(frozen=True, kw_only=True)
class LineValues:
    """sigma (P,), and rho, beta, psi, theta of shape (P, n, 2), [lower, upper], with rates of rho and beta in time."""

    sigma: Array
    rho: Array
    beta: Array
    psi: Array
    theta: Array
    rho_rate: Array
    beta_rate: Array


def lines(p: Parameters, t: npt.ArrayLike) -> LineValues:
    """Return everything in (4)-(11) that depends on time alone, at times t (held within [0, t_c])."""
    time = np.clip(np.asarray(t, dtype=np.longdouble), 0, p.t_c)
    with np.errstate(all="ignore"):
        s = np.where(time < p.t_c, time / (p.t_c - time), 0)
        sigma = np.where(time < p.t_c, np.tanh(s), 1)
        sech = 1 / np.cosh(np.minimum(s, 5000))
        sigma_rate = np.where(time < p.t_c, ((1 + s) * sech) ** 2 / p.t_c, 0)
    span = p.target - p.start
    rho = p.start + span * sigma[:, None, None]
    heights = np.zeros(rho.shape, dtype=np.longdouble)
    slopes = np.zeros(rho.shape, dtype=np.longdouble)
    for i in range(p.start.shape[0]):
        for side in (0, 1):
            bumps = [_bump(time, *b[2:]) for b in p.bumps if b[:2] == (i, side)]
            if bumps:
                heights[:, i, side], slopes[:, i, side] = _joined(bumps, p.nu)
    sign = np.array([1, -1], dtype=np.longdouble)
    beta = p.walls + sign * heights
    psi = np.stack([beta[:, :, 1] - rho[:, :, 0], rho[:, :, 1] - beta[:, :, 0]], axis=2)
    with np.errstate(over="ignore"):  # theta0 (1 - tanh y) = 2 theta0 / (1 + exp(2 y)), without the cancellation
        theta = 2 * p.theta0 / (1 + np.exp(2 * p.varsigma * (psi - p.mu)))
    return LineValues(
        sigma=sigma, rho=rho, beta=beta, psi=psi, theta=theta, rho_rate=span * sigma_rate[:, None, None], beta_rate=sign * slopes
    )


def _bump(t: Array, b: np.longdouble, k: np.longdouble, m: np.longdouble, r: np.longdouble) -> tuple[Array, Array]:
    """Return (7) above its rest level, and its derivative."""
    inside = np.abs(t - m) < r
    d = np.where(inside, t - m, 0)
    rest = np.where(inside, r**2 - (t - m) ** 2, 1)
    value = np.where(inside, b * np.exp(-k * d**2 / rest), 0)
    return value, np.where(inside, value * -2 * k * d * r**2 / rest**2, 0)


def _joined(bumps: list[tuple[Array, Array]], nu: np.longdouble) -> tuple[Array, Array]:
    """Return the joined bumps, ln(1 + sum(exp(nu b) - 1)) / nu in place of the max in (9), and their derivative."""
    values, slopes = (np.stack(v) for v in zip(*bumps, strict=True))
    top = values.max(axis=0)
    terms = np.exp(nu * (values - top))
    rest = np.exp(-nu * top)
    total = rest + (terms - rest).sum(axis=0)
    return top + np.log(total) / nu, (terms * slopes).sum(axis=0) / total


def alpha_rate(p: Parameters, psi: npt.ArrayLike, theta: npt.ArrayLike, alpha: npt.ArrayLike) -> tuple[Array, Array]:
    """Return alphadot (11) and its derivative in alpha; all arguments of one shape."""
    z = np.asarray(psi, dtype=np.longdouble) + np.asarray(alpha, dtype=np.longdouble)
    force = np.asarray(theta, dtype=np.longdouble)
    return force / z**2 - p.kappa * np.asarray(alpha, dtype=np.longdouble), -2 * force / z**3 - p.kappa


def alpha_steps(p: Parameters, t: npt.ArrayLike, dt: npt.ArrayLike, alpha: npt.ArrayLike) -> Array:
    """Return alpha (P, n, 2) after backward Euler steps of (11) from t to t + dt (shape (P,)), by bisection of the cubic."""
    h = np.asarray(dt, dtype=np.longdouble)[:, None, None]
    now = lines(p, np.asarray(t, dtype=np.longdouble) + np.asarray(dt, dtype=np.longdouble))
    rest = np.asarray(alpha, dtype=np.longdouble) / (1 + h * p.kappa)
    shift, force = now.psi + rest, h * now.theta / (1 + h * p.kappa)
    low = np.maximum(shift, 0)
    high = low + np.cbrt(force) + np.longdouble(1e-30)
    for _ in range(100):
        middle = (low + high) / 2
        above = (middle - shift) * middle**2 > force
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(rest + force / ((low + high) / 2) ** 2)


def adaptive_tube(p: Parameters, now: LineValues, alpha: npt.ArrayLike) -> tuple[Array, Array]:
    """Return gamma of (10) and its total rate along (11), shape (P, n, 2), for alpha of that shape."""
    a = np.asarray(alpha, dtype=np.longdouble)
    sign = np.array([-1, 1], dtype=np.longdouble)
    moved = now.rho + sign * a
    rate, _ = alpha_rate(p, now.psi, now.theta, a)
    adapted_rate = now.rho_rate + sign * rate
    gap = np.abs(moved - now.beta)
    best = np.where(sign < 0, np.maximum(moved, now.beta), np.minimum(moved, now.beta))
    gamma = best - sign * np.log1p(np.exp(-p.nu * gap)) / p.nu
    weight = 1 / (1 + np.exp(np.clip(sign * p.nu * (moved - now.beta), -10000, 10000)))  # of `moved`
    return gamma, weight * adapted_rate + (1 - weight) * now.beta_rate
