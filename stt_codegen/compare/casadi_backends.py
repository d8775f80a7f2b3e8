"""The controller as CasADi evaluates its kernels, with clamps, loops and table in NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.controller import compute_covered_starts
from stt_codegen.designs import MINIMUM_WIDTH, AdaptiveDesign, RefinedDesign
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.backend import Backend

Array = npt.NDArray[Any]


class _CasadiLaw(Backend):
    """Section IV as CasADi evaluates its kernels, with the clamp and the status in NumPy."""

    name = "CasADi"
    scalar = "double"

    def __init__(self, controller: EmittedController) -> None:
        from stt_codegen.paper import control_law

        self.task = controller.task
        self.normalized, self.transformed = control_law.normalized_error(), control_law.transformed_error()
        self.push = control_law.law()

    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        return tuple(getattr(self, f"_{function}")(*inputs))

    def _transform(self, lower: Array, upper: Array, x: Array) -> tuple[Array, ...]:
        e_max = np.array([float(v) for v in self.task.e_max])
        share, rest = (np.array([float((1 + sign * v) / 2) for v in self.task.e_max]) for sign in (-1, 1))
        width = upper - lower
        a = np.clip(x - lower, share * width, rest * width)
        b = np.clip(upper - x, share * width, rest * width)
        e = np.clip(_over(self.normalized, a, b, width)[0], -e_max, e_max)
        return e, *_over(self.transformed, a, b)

    def _control(self, *inputs: Array) -> tuple[Array, ...]:
        *at, x = inputs
        lower, upper = self.call("tube", *at)
        return self._law(lower, upper, x)

    def _law(self, lower: Array, upper: Array, x: Array) -> tuple[Array, ...]:
        """Status and u of (13) for x between these edges."""
        _, epsilon, xi = self.call("transform", lower, upper, x)
        (u,) = _over(self.push, np.array([float(v) for v in self.task.gain]) + 0 * xi, xi, epsilon)
        if self.task.u_max is not None:
            bound = np.array([float(v) for v in self.task.u_max])
            largest = np.maximum(np.abs(u).max(axis=1, keepdims=True), bound[:1])
            u = u * (bound[:1] / largest) if self.task.scales_input else np.clip(u, -bound, bound)
        inside = np.all((lower < x) & (x < upper), axis=1)
        return np.where(inside, 0, 1), u

    def _margin(self, *inputs: Array) -> tuple[Array, ...]:
        return (np.asarray(self._margins(*inputs)[0].min(axis=1)),)

    def _margins(self, *inputs: Array) -> tuple[Array, ...]:
        *at, x = inputs
        lower, upper = self.call("tube", *at)
        return (self._shares(lower, upper, x),)

    def _shares(self, lower: Array, upper: Array, x: Array) -> Array:
        share = np.minimum(x - lower, upper - x) / np.maximum(upper - lower, float(MINIMUM_WIDTH))
        return np.asarray(np.clip(share, -1.0, 0.5))


def _over(function: Any, *inputs: Any) -> tuple[Array, ...]:
    """A CasADi function of scalars over arrays of one shape (numbers are repeated); its outputs in that shape."""
    shape = np.broadcast_shapes(*(np.shape(v) for v in inputs))
    rows = [np.broadcast_to(v, shape).reshape(1, -1) for v in inputs]
    results = function(*rows)
    results = results if isinstance(results, tuple) else (results,)
    return tuple(np.array(r).reshape(shape) for r in results)


class CasadiRefined(_CasadiLaw):
    """A refined tube by its CasADi kernels; time, segment and table in NumPy."""

    def __init__(self, controller: EmittedController, design: RefinedDesign) -> None:
        from stt_codegen.paper import refined_tube

        super().__init__(controller)
        self.design, self.certified = design, controller.certificate.holds
        self.basis, self.basis_rate, self.blend = refined_tube.basis(), refined_tube.basis_rate(), refined_tube.blend()

    def _edges(self, t: Array, weights: Any) -> tuple[Array, Array]:
        design = self.design
        t_c, k = float(design.prescribed_time), design.segments
        u = np.where(t < t_c, np.minimum(np.maximum(t, 0) * float(k / design.prescribed_time), k), k)
        segment = np.minimum(u.astype(int), k - 1)
        w = weights(u - segment)
        q = design.integers() * float(design.unit)
        edges = np.empty((len(t), design.dimension, 2))
        for i in range(design.dimension):
            for side in (0, 1):
                edges[:, i, side] = np.array(self.blend(w, np.stack([q[segment + j, i, side] for j in range(4)])))
        return edges[:, :, 0], edges[:, :, 1]

    def _tube(self, t: Array) -> tuple[Array, ...]:
        return self._edges(t, lambda s: self.basis(s[None]))

    def _tube_rate(self, t: Array) -> tuple[Array, ...]:
        lower, upper = self._edges(t, lambda s: self.basis_rate(s[None]))
        design = self.design
        scale = np.where(t < float(design.prescribed_time), float(design.segments / design.prescribed_time), 0.0)[:, None]
        return lower * scale, upper * scale

    def _filtered_tube(self, t: Array) -> tuple[Array, ...]:
        value = np.array([float(v) for v in self.design.filter])
        return tuple(rate + value * edge for rate, edge in zip(self._tube_rate(t), self._tube(t), strict=True))

    def _velocity(self, dt: Array, x: Array, before: Array) -> tuple[Array, ...]:
        with np.errstate(divide="ignore", invalid="ignore"):
            return (np.where(dt[:, None] > 0, (x - before) / dt[:, None], np.nan),)

    def _control(self, *inputs: Array) -> tuple[Array, ...]:
        """Of order 2 the law is about v + lambda x in the filtered tube."""
        if not self.design.filter:
            return super()._control(*inputs)
        t, x, v = inputs
        lower, upper = self._filtered_tube(t)
        held = v + np.array([float(s) for s in self.design.filter]) * x
        status, u = self._law(lower, upper, held)
        low, high = self._tube(t)
        return np.where(((low < x) & (x < high)).all(axis=1), status, 1), u

    def _margins(self, *inputs: Array) -> tuple[Array, ...]:
        if not self.design.filter:
            return super()._margins(*inputs)
        t, x, v = inputs
        filtered = v + np.array([float(s) for s in self.design.filter]) * x
        (low, high), (lower, upper) = self._tube(t), self._filtered_tube(t)
        return (np.minimum(self._shares(low, high, x), self._shares(lower, upper, filtered)),)

    def _covered(self, *state: Array) -> tuple[Array, ...]:
        starts = compute_covered_starts(self.task, self.design)
        places, sums = (np.array([[float(v) for v in pair] for pair in bounds]) for bounds in (starts.positions, starts.filtered))
        inside = ((places[:, 0] < state[0]) & (state[0] < places[:, 1])).all(axis=1)
        if self.design.filter:
            filtered = state[1] + np.array([float(s) for s in self.design.filter]) * state[0]
            inside = inside & ((sums[:, 0] < filtered) & (filtered < sums[:, 1])).all(axis=1)
        return (np.asarray(inside & self.certified),)

    def _control_tick(self, ticks: Array, *state: Array) -> tuple[Array, ...]:
        assert self.task.emit.tick_period is not None
        return self._control(ticks * float(self.task.emit.tick_period), *state)


class CasadiAdaptive(_CasadiLaw):
    """An adaptive or literal tube by its CasADi kernels; loops over dimensions and circumvent functions in NumPy.

    alpha is laid out as in the emitted code: alpha_L by dimension, then alpha_U.
    """

    def __init__(self, controller: EmittedController, design: AdaptiveDesign) -> None:
        super().__init__(controller)
        self.design = design
        self.update = [float(v) for v in (design.theta0, design.kappa, design.mu, design.varsigma)]

    def _lines(self, t: Array) -> tuple[Array, Array, Array, Array, Array]:
        """sigma (P,), and rho, beta, their rates, of shape (P, 2 n)."""
        from stt_codegen.paper import circumvent, reach_tube

        d, n = self.design, self.design.dimension
        held = np.clip(t, 0, float(d.prescribed_time))
        sigma, sigma_rate = _over(reach_tube.profile(True), held, float(d.prescribed_time))
        edges = [(float(d.start[i][s]), float(d.target[i][s])) for s in (0, 1) for i in range(n)]
        rho = np.stack([_over(reach_tube.reach_edge(), a, b, sigma)[0] for a, b in edges], axis=1)
        rho_rate = np.stack([_over(reach_tube.reach_rate(), a, b, sigma_rate)[0] for a, b in edges], axis=1)
        beta, beta_rate = np.empty_like(rho), np.empty_like(rho)
        for side in (0, 1):
            for i in range(n):
                total, slope = np.zeros_like(held), np.zeros_like(held)
                for b in d.bumps_on(i, side):
                    shape = [float(v) for v in (b.height, b.steepness, b.middle, b.radius, circumvent.CUT["double"])]
                    bump, bump_rate = _over(circumvent.circumvent(True), held, *shape)
                    total, slope = _over(circumvent.join(True), total, bump, slope, bump_rate, float(d.nu))
                beta[:, i + n * side] = float(d.walls[i][side]) + (1 - 2 * side) * total
                beta_rate[:, i + n * side] = (1 - 2 * side) * slope
        return sigma, rho, beta, rho_rate, beta_rate

    def _psi(self, rho: Array, beta: Array) -> Array:
        n = self.design.dimension
        return np.hstack([beta[:, n:] - rho[:, :n], rho[:, n:] - beta[:, :n]])

    def _probe(self, t: Array) -> tuple[Array, ...]:
        from stt_codegen.paper import adaptive_tube

        sigma, rho, beta, _, _ = self._lines(t)
        psi = self._psi(rho, beta)
        theta0, _, mu, varsigma = self.update
        (theta,) = _over(adaptive_tube.theta(), psi, theta0, mu, varsigma)
        return sigma[:, None], rho, beta, psi, theta

    def _alpha_rate(self, t: Array, alpha: Array) -> tuple[Array, ...]:
        from stt_codegen.paper import adaptive_tube

        _, rho, beta, _, _ = self._lines(t)
        return _over(adaptive_tube.update_rate(), self._psi(rho, beta), alpha, *self.update)

    def _alpha_step(self, t: Array, dt: Array, alpha: Array) -> tuple[Array, ...]:
        from stt_codegen.paper import adaptive_tube

        _, rho, beta, _, _ = self._lines(t + dt)
        step = adaptive_tube.implicit_step_function()
        return _over(step, alpha, self._psi(rho, beta), np.repeat(dt[:, None], alpha.shape[1], axis=1), *self.update)

    def _tube(self, t: Array, alpha: Array) -> tuple[Array, ...]:
        from stt_codegen.paper import adaptive_tube

        n, nu = self.design.dimension, float(self.design.nu)
        _, rho, beta, _, _ = self._lines(t)
        (low,) = _over(adaptive_tube.lower_edge(), rho[:, :n], alpha[:, :n], beta[:, :n], nu)
        (high,) = _over(adaptive_tube.upper_edge(), rho[:, n:], alpha[:, n:], beta[:, n:], nu)
        return low, high

    def _tube_rate(self, t: Array, alpha: Array) -> tuple[Array, ...]:
        from stt_codegen.paper import adaptive_tube

        n, nu = self.design.dimension, float(self.design.nu)
        _, rho, beta, rho_rate, beta_rate = self._lines(t)
        rate, _ = self._alpha_rate(t, alpha)
        results = []
        for kernel, own in ((adaptive_tube.lower_edge(True), slice(0, n)), (adaptive_tube.upper_edge(True), slice(n, None))):
            data = [rho[:, own], alpha[:, own], beta[:, own], nu, rho_rate[:, own], rate[:, own], beta_rate[:, own]]
            results.append(_over(kernel, *data)[1])
        return tuple(results)
