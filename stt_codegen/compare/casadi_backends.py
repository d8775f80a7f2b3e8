"""Controllers as CasADi evaluates their kernels: clamps, loops and the table are in NumPy.

comparison.py compares these backends like any other: `call(name, *inputs)` calls the method `_name`. Inputs and outputs are
those of the emitted functions: t (P,), x and u (P, n), alpha (P, 2 n), P points and n dimensions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.controller import compute_covered_starts
from stt_codegen.designs import MINIMUM_WIDTH, AdaptiveDesign, RefinedDesign
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.backend import Backend

Array = npt.NDArray[Any]


class _CasadiLaw(Backend):
    """The functions that are the same for all tubes: transform, law and margins of section IV, from the edges of `_tube`."""

    name = "CasADi"
    scalar = "double"

    def __init__(self, controller: EmittedController) -> None:
        from stt_codegen.paper import control_law

        self.task = controller.task
        self.normalized_error, self.transformed_error = control_law.normalized_error(), control_law.transformed_error()
        self.control_input = control_law.law()

    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        """Return what the emitted function of this name gives, computed by the method `_<name>`."""
        return tuple(getattr(self, f"_{function}")(*inputs))

    def _transform(self, lower: Array, upper: Array, x: Array) -> tuple[Array, ...]:
        """Return e, epsilon and xi for states x in boxes (lower, upper)."""
        e_max = np.array([float(v) for v in self.task.e_max])
        low_share, high_share = (np.array([float((1 + sign * v) / 2) for v in self.task.e_max]) for sign in (-1, 1))
        width = upper - lower
        a = np.clip(x - lower, low_share * width, high_share * width)
        b = np.clip(upper - x, low_share * width, high_share * width)
        e = np.clip(_evaluate(self.normalized_error, a, b, width)[0], -e_max, e_max)
        return e, *_evaluate(self.transformed_error, a, b)

    def _control(self, *inputs: Array) -> tuple[Array, ...]:
        *time_inputs, x = inputs
        lower, upper = self.call("tube", *time_inputs)
        return self._law(lower, upper, x)

    def _law(self, lower: Array, upper: Array, x: Array) -> tuple[Array, ...]:
        """Return status and u of (13) for x between these edges."""
        _, epsilon, xi = self.call("transform", lower, upper, x)
        gain = np.array([float(v) for v in self.task.gain]) + 0 * xi  # in the shape of xi
        (u,) = _evaluate(self.control_input, gain, xi, epsilon)
        if self.task.u_max is not None:
            u_max = np.array([float(v) for v in self.task.u_max])
            largest = np.maximum(np.abs(u).max(axis=1, keepdims=True), u_max[:1])
            u = u * (u_max[:1] / largest) if self.task.scales_input else np.clip(u, -u_max, u_max)
        is_inside = np.all((lower < x) & (x < upper), axis=1)
        return np.where(is_inside, 0, 1), u

    def _margin(self, *inputs: Array) -> tuple[Array, ...]:
        return (np.asarray(self._margins(*inputs)[0].min(axis=1)),)

    def _margins(self, *inputs: Array) -> tuple[Array, ...]:
        *time_inputs, x = inputs
        lower, upper = self.call("tube", *time_inputs)
        return (self._margins_between(lower, upper, x),)

    def _margins_between(self, lower: Array, upper: Array, x: Array) -> Array:
        """Return the distances to the nearer edge over the width."""
        margins = np.minimum(x - lower, upper - x) / np.maximum(upper - lower, float(MINIMUM_WIDTH))
        return np.asarray(np.clip(margins, -1.0, 0.5))


def _evaluate(function: Any, *inputs: Any) -> tuple[Array, ...]:
    """Evaluate a CasADi function of scalars on arrays of one shape (numbers are repeated); its outputs have that shape."""
    shape = np.broadcast_shapes(*(np.shape(v) for v in inputs))
    rows = [np.broadcast_to(v, shape).reshape(1, -1) for v in inputs]
    results = function(*rows)
    results = results if isinstance(results, tuple) else (results,)
    return tuple(np.array(r).reshape(shape) for r in results)


class CasadiRefined(_CasadiLaw):
    """A refined controller by its CasADi kernels; time, segment and table are in NumPy."""

    def __init__(self, controller: EmittedController, design: RefinedDesign) -> None:
        from stt_codegen.paper import refined_tube

        super().__init__(controller)
        self.design, self.is_certified = design, controller.certificate.holds
        self.basis, self.basis_rate, self.blend = refined_tube.basis(), refined_tube.basis_rate(), refined_tube.blend()
        self.lambda_ = np.array([float(v) for v in design.filter])

    def _blend_edges(self, t: Array, weights_of: Callable[[Array], Any]) -> tuple[Array, Array]:
        """Return lower and upper edges (P, n) at times t: control points blended by weights, a function of s (P,)."""
        design = self.design
        t_c, k = float(design.prescribed_time), design.segments
        u = np.where(t < t_c, np.minimum(np.maximum(t, 0) * float(k / design.prescribed_time), k), k)
        segment = np.minimum(u.astype(int), k - 1)
        weights = weights_of(u - segment)
        table = design.integers() * float(design.unit)
        edges = np.empty((len(t), design.dimension, 2))
        for i in range(design.dimension):
            for side in (0, 1):
                control_points = np.stack([table[segment + j, i, side] for j in range(4)])
                edges[:, i, side] = np.array(self.blend(weights, control_points))
        return edges[:, :, 0], edges[:, :, 1]

    def _tube(self, t: Array) -> tuple[Array, ...]:
        return self._blend_edges(t, lambda s: self.basis(s[None]))

    def _tube_rate(self, t: Array) -> tuple[Array, ...]:
        lower, upper = self._blend_edges(t, lambda s: self.basis_rate(s[None]))
        t_c = self.design.prescribed_time
        segments_per_second = np.where(t < float(t_c), float(self.design.segments / t_c), 0.0)[:, None]
        return lower * segments_per_second, upper * segments_per_second

    def _filtered_tube(self, t: Array) -> tuple[Array, ...]:
        return tuple(rate + self.lambda_ * edge for rate, edge in zip(self._tube_rate(t), self._tube(t), strict=True))

    def _velocity(self, dt: Array, x: Array, x_before: Array) -> tuple[Array, ...]:
        with np.errstate(divide="ignore", invalid="ignore"):
            return (np.where(dt[:, None] > 0, (x - x_before) / dt[:, None], np.nan),)

    def _control(self, *inputs: Array) -> tuple[Array, ...]:
        """Return status and u; for order 2 the law is about v + lambda x in the filtered tube."""
        if not self.design.filter:
            return super()._control(*inputs)
        t, x, v = inputs
        filtered_lower, filtered_upper = self._filtered_tube(t)
        status, u = self._law(filtered_lower, filtered_upper, v + self.lambda_ * x)
        lower, upper = self._tube(t)
        return np.where(((lower < x) & (x < upper)).all(axis=1), status, 1), u

    def _margins(self, *inputs: Array) -> tuple[Array, ...]:
        """Return margins; for order 2 the smaller ones of x and of v + lambda x."""
        if not self.design.filter:
            return super()._margins(*inputs)
        t, x, v = inputs
        (lower, upper), (filtered_lower, filtered_upper) = self._tube(t), self._filtered_tube(t)
        filtered_margins = self._margins_between(filtered_lower, filtered_upper, v + self.lambda_ * x)
        return (np.minimum(self._margins_between(lower, upper, x), filtered_margins),)

    def _covered(self, *state: Array) -> tuple[Array, ...]:
        """Return whether each state is a covered start; state: x, and v for order 2."""
        starts = compute_covered_starts(self.task, self.design)
        is_covered = _is_within(state[0], starts.positions)
        if self.design.filter:
            is_covered = is_covered & _is_within(state[1] + self.lambda_ * state[0], starts.filtered)
        return (np.asarray(is_covered & self.is_certified),)

    def _control_tick(self, ticks: Array, *state: Array) -> tuple[Array, ...]:
        assert self.task.emit.tick_period is not None
        return self._control(ticks * float(self.task.emit.tick_period), *state)


def _is_within(values: Array, intervals: tuple[tuple[Any, Any], ...]) -> Array:
    """Return (P,): whether all components of values (P, n) are strictly within their intervals."""
    bounds = np.array([[float(v) for v in pair] for pair in intervals])
    return np.asarray(((bounds[:, 0] < values) & (values < bounds[:, 1])).all(axis=1))


class _RhoBeta(NamedTuple):
    """sigma (P,), and rho, beta and their rates, (P, 2 n) laid out as alpha."""

    sigma: Array
    rho: Array
    beta: Array
    rho_rate: Array
    beta_rate: Array


class CasadiAdaptive(_CasadiLaw):
    """An adaptive or literal controller by its CasADi kernels; loops over dimensions and circumvent functions are in NumPy.

    alpha is laid out as in the emitted code: alpha_L by dimension, then alpha_U.
    """

    def __init__(self, controller: EmittedController, design: AdaptiveDesign) -> None:
        super().__init__(controller)
        self.design = design
        self.update_constants = [float(v) for v in (design.theta0, design.kappa, design.mu, design.varsigma)]

    def _rho_and_beta(self, t: Array) -> _RhoBeta:
        """Return sigma, rho (4), beta (9) and rates at times t."""
        from stt_codegen.paper import reach_tube

        d, n = self.design, self.design.dimension
        clamped_t = np.clip(t, 0, float(d.prescribed_time))
        sigma, sigma_rate = _evaluate(reach_tube.profile(True), clamped_t, float(d.prescribed_time))
        ends = [(float(d.start[i][side]), float(d.target[i][side])) for side in (0, 1) for i in range(n)]
        rho = np.stack([_evaluate(reach_tube.reach_edge(), a, b, sigma)[0] for a, b in ends], axis=1)
        rho_rate = np.stack([_evaluate(reach_tube.reach_rate(), a, b, sigma_rate)[0] for a, b in ends], axis=1)
        beta, beta_rate = np.empty_like(rho), np.empty_like(rho)
        for side in (0, 1):
            sign = 1 - 2 * side
            for i in range(n):
                height, height_rate = self._joined_bumps(i, side, clamped_t)
                beta[:, i + n * side] = float(d.walls[i][side]) + sign * height
                beta_rate[:, i + n * side] = sign * height_rate
        return _RhoBeta(sigma, rho, beta, rho_rate, beta_rate)

    def _joined_bumps(self, i: int, side: int, t: Array) -> tuple[Array, Array]:
        """Return the joined circumvent functions of one side of dimension i, above its wall, and their rate."""
        from stt_codegen.paper import circumvent

        height, height_rate = np.zeros_like(t), np.zeros_like(t)
        for b in self.design.bumps_on(i, side):
            shape = [float(v) for v in (b.height, b.steepness, b.middle, b.radius, circumvent.CUT["double"])]
            bump, bump_rate = _evaluate(circumvent.circumvent(True), t, *shape)
            joined = _evaluate(circumvent.join(True), height, bump, height_rate, bump_rate, float(self.design.nu))
            height, height_rate = joined
        return height, height_rate

    def _psi(self, rho: Array, beta: Array) -> Array:
        """Return psi_L = beta_U - rho_L and psi_U = rho_U - beta_L, laid out as alpha."""
        n = self.design.dimension
        return np.hstack([beta[:, n:] - rho[:, :n], rho[:, n:] - beta[:, :n]])

    def _probe(self, t: Array) -> tuple[Array, ...]:
        from stt_codegen.paper import adaptive_tube

        sigma, rho, beta, _, _ = self._rho_and_beta(t)
        psi = self._psi(rho, beta)
        theta0, _, mu, varsigma = self.update_constants
        (theta,) = _evaluate(adaptive_tube.theta(), psi, theta0, mu, varsigma)
        return sigma[:, None], rho, beta, psi, theta

    def _alpha_rate(self, t: Array, alpha: Array) -> tuple[Array, ...]:
        from stt_codegen.paper import adaptive_tube

        _, rho, beta, _, _ = self._rho_and_beta(t)
        return _evaluate(adaptive_tube.update_rate(), self._psi(rho, beta), alpha, *self.update_constants)

    def _alpha_step(self, t: Array, dt: Array, alpha: Array) -> tuple[Array, ...]:
        from stt_codegen.paper import adaptive_tube

        _, rho, beta, _, _ = self._rho_and_beta(t + dt)
        repeated_dt = np.repeat(dt[:, None], alpha.shape[1], axis=1)
        step = adaptive_tube.implicit_step_function()
        return _evaluate(step, alpha, self._psi(rho, beta), repeated_dt, *self.update_constants)

    def _tube(self, t: Array, alpha: Array) -> tuple[Array, ...]:
        from stt_codegen.paper import adaptive_tube

        n, nu = self.design.dimension, float(self.design.nu)
        _, rho, beta, _, _ = self._rho_and_beta(t)
        (lower,) = _evaluate(adaptive_tube.lower_edge(), rho[:, :n], alpha[:, :n], beta[:, :n], nu)
        (upper,) = _evaluate(adaptive_tube.upper_edge(), rho[:, n:], alpha[:, n:], beta[:, n:], nu)
        return lower, upper

    def _tube_rate(self, t: Array, alpha: Array) -> tuple[Array, ...]:
        """Return the total rates of both edges along (11)."""
        from stt_codegen.paper import adaptive_tube

        n, nu = self.design.dimension, float(self.design.nu)
        _, rho, beta, rho_rate, beta_rate = self._rho_and_beta(t)
        alpha_rate, _ = self._alpha_rate(t, alpha)
        values, rates = (rho, alpha, beta), (rho_rate, alpha_rate, beta_rate)
        edge_rates = []
        for kernel, columns in ((adaptive_tube.lower_edge(True), slice(0, n)), (adaptive_tube.upper_edge(True), slice(n, None))):
            inputs = [*(v[:, columns] for v in values), nu, *(v[:, columns] for v in rates)]
            edge_rates.append(_evaluate(kernel, *inputs)[1])
        return tuple(edge_rates)
