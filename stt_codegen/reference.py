"""The same equations once more, in plain NumPy, written from the paper and not from `paper/`: what every backend must match.

Imports neither CasADi nor anything of this package; works on the plain data of a design. Everything is evaluated in
`numpy.longdouble` (64 bits of significand on x86-64), so that its own rounding does not count against a double.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.longdouble]
OK, OUTSIDE_TUBE, BAD_INPUT = 0, 1, 2

# The uniform cubic B-spline in powers of s: row j holds the coefficients of 1, s, s^2, s^3 of basis function j, times 6.
BASIS = np.array([[1, -3, 3, -1], [4, 0, -6, 3], [1, 3, 3, -3], [0, 0, 0, 1]], dtype=np.longdouble)


def exact(value: Fraction) -> np.longdouble:
    """A fraction in extended precision."""
    return np.longdouble(value.numerator) / np.longdouble(value.denominator)


def tube(table: npt.ArrayLike, unit: Fraction, t_c: Fraction, t: npt.ArrayLike) -> tuple[Array, Array]:
    """Edges of a refined tube at times t (shape (P,)): lower and upper, each of shape (P, n).

    table: integers of shape (K + 3, n, 2), control points over 6 in multiples of `unit`. NaN where t is not finite.
    """
    place, segment = _place(table, t_c, t)
    powers = np.stack([np.ones_like(place), place, place**2, place**3])
    return _edges(table, unit, segment, BASIS @ powers, t)


def tube_rate(table: npt.ArrayLike, unit: Fraction, t_c: Fraction, t: npt.ArrayLike) -> tuple[Array, Array]:
    """Rates of the edges at times t, as `tube`; zero from t_c on."""
    place, segment = _place(table, t_c, t)
    slopes = np.stack([np.zeros_like(place), np.ones_like(place), 2 * place, 3 * place**2])
    segments = np.asarray(table).shape[0] - 3
    scale = np.where(np.asarray(t, dtype=np.longdouble) < exact(t_c), segments / exact(t_c), 0)
    lower, upper = _edges(table, unit, segment, BASIS @ slopes, t)
    return lower * scale[:, None], upper * scale[:, None]


def _place(table: npt.ArrayLike, t_c: Fraction, t: npt.ArrayLike) -> tuple[Array, npt.NDArray[np.intp]]:
    segments = np.asarray(table).shape[0] - 3
    time = np.nan_to_num(np.asarray(t, dtype=np.longdouble), nan=0.0, posinf=0.0, neginf=0.0)
    u = np.clip(time, 0, exact(t_c)) * segments / exact(t_c)
    segment = np.minimum(np.floor(u).astype(np.intp), segments - 1)
    return u - segment, segment


def _edges(
    table: npt.ArrayLike, unit: Fraction, segment: npt.NDArray[np.intp], weights: Array, t: npt.ArrayLike
) -> tuple[Array, Array]:
    q = np.asarray(table).astype(np.longdouble) * exact(unit)
    edges = sum(weights[j][:, None, None] * q[segment + j] for j in range(4))
    edges = np.where(np.isfinite(np.asarray(t, dtype=np.longdouble))[:, None, None], edges, np.nan)
    return edges[:, :, 0], edges[:, :, 1]


def transform(lower: npt.ArrayLike, upper: npt.ArrayLike, x: npt.ArrayLike, e_max: Fraction) -> tuple[Array, Array, Array]:
    """e, epsilon and xi of section IV by component (diagonal I - e e^T), e clamped to [-e_max, e_max].

    0 where upper <= lower, NaN where a number is not finite.
    """
    low, high, state = (np.asarray(v, dtype=np.longdouble) for v in (lower, upper, x))
    bound = exact(e_max)
    with np.errstate(all="ignore"):
        gamma_s, gamma_d = high + low, high - low
        e = np.clip((2 * state - gamma_s) / gamma_d, -bound, bound)
        epsilon = np.log((1 + e) / (1 - e))
        xi = 4 / (gamma_d * (1 - e**2))
    empty = gamma_d <= 0
    bad = ~(np.isfinite(low) & np.isfinite(high) & np.isfinite(state))
    e, epsilon, xi = (np.where(bad, np.nan, np.where(empty, 0, v)) for v in (e, epsilon, xi))
    return e, epsilon, xi


def control(
    lower: npt.ArrayLike,
    upper: npt.ArrayLike,
    x: npt.ArrayLike,
    gain: Fraction,
    e_max: Fraction,
    u_max: tuple[Fraction, ...] | None = None,
) -> tuple[npt.NDArray[np.intp], Array]:
    """Status (shape (P,)) and u = -k xi epsilon (13) for states x of shape (P, n) in the tube with these edges."""
    low, high, state = (np.asarray(v, dtype=np.longdouble) for v in (lower, upper, x))
    _, epsilon, xi = transform(low, high, state, e_max)
    u = -exact(gain) * xi * epsilon
    if u_max is not None:
        bound = np.array([exact(v) for v in u_max])
        u = np.clip(u, -bound, bound)
    bad = ~np.all(np.isfinite(state) & np.isfinite(low), axis=1)
    inside = np.all((low < state) & (state < high), axis=1)
    u = np.where(bad[:, None], 0, u)
    return np.where(bad, BAD_INPUT, np.where(inside, OK, OUTSIDE_TUBE)), u
