"""An adaptive or literal tube on a grid of times, by `reference.py`, which shares no code with what is emitted; alpha is
stepped by the implicit step that the target makes."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.designs.adaptive import AdaptiveDesign
from stt_codegen.designs.refined import RefinedDesign

POINTS = 4000
Array = npt.NDArray[Any]


def parameters_of(design: AdaptiveDesign) -> reference.Parameters:
    """The plain data of a design for the reference."""

    def edges(pairs: tuple[tuple[Fraction, Fraction], ...]) -> Array:
        return np.array([[reference.exact(v) for v in pair] for pair in pairs])

    e = reference.exact
    return reference.Parameters(
        e(design.prescribed_time), edges(design.start), edges(design.target), edges(design.walls),
        tuple((b.dimension, b.side, e(b.height), e(b.steepness), e(b.middle), e(b.radius)) for b in design.bumps),
        e(design.theta0), e(design.kappa), e(design.mu), e(design.varsigma), e(design.nu),
    )  # fmt: skip


def grid_tube(design: AdaptiveDesign, points: int = POINTS) -> tuple[Array, Array, Array, Array]:
    """Times (S + 1,), and alpha, gamma and gammadot of shape (S + 1, n, 2), alpha stepped from 0 with dt = t_c / S."""
    p = parameters_of(design)
    step = float(design.prescribed_time) / points
    t = np.arange(points + 1) * step
    now = reference.lines(p, t)
    alpha = step_alpha(design, now.psi.astype(float), step)
    gamma, rate = reference.adaptive_tube(p, now, alpha)
    return t, alpha, gamma.astype(float), rate.astype(float)


def step_alpha(design: AdaptiveDesign, psi: Array, dt: float) -> Array:
    """alpha on a grid of step dt from 0, by the implicit step that is emitted; psi and the result of shape (S + 1, n, 2)."""
    steps = _steps(len(psi) - 1)
    parameters = [float(v) for v in (design.theta0, design.kappa, design.mu, design.varsigma)]
    alpha = np.zeros(psi.shape)
    for i, side in np.ndindex(*psi.shape[1:]):
        alpha[1:, i, side] = np.array(steps(0.0, psi[1:, i, side][None], dt, *parameters)).ravel()
    return alpha


def tube_at(design: RefinedDesign | AdaptiveDesign, t: Array) -> tuple[Array, Array]:
    """Edges of the tube at equally spaced times t from 0 to t_c, shape (P, n) each."""
    if isinstance(design, RefinedDesign):
        low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
        return low.astype(float), high.astype(float)
    _, _, gamma, _ = grid_tube(design, len(t) - 1)
    return gamma[:, :, 0], gamma[:, :, 1]


@cache
def _steps(count: int) -> Any:
    from stt_codegen.paper.adaptive_tube import implicit_step_function

    return implicit_step_function().mapaccum("steps", count)
