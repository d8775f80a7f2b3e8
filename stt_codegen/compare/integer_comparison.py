"""A controller in integers against the reference: edges and u within bounds derived for its ticks, its units and its curves.

    tube, filtered tube   P7 (`controller.integers.integer_errors`)
    u                     what moved edges change in (13), as for floats, and `law_error`; at the clamp, which acts up to 2^-13
                          late, `sampling.ROUNDING`
    margin                the distance moved by P7, over the width; the error of 1/d, and a unit
    status                may differ only where x is within P7 of an edge

comparison.py calls this file. Arrays are (P, n): P points, n dimensions. A backend's integers are turned to the task's units.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.compare.comparison_rows import ComparedBackend, RowCollector, TubeWithErrors
from stt_codegen.compare.law_comparison import law_change
from stt_codegen.compare.start_comparison import compare_covered
from stt_codegen.controller import edge_and_rate_errors
from stt_codegen.controller.integers import (
    LARGEST_STATE,
    MARGIN_BITS,
    build_integer_law,
    choose_clock,
    curves,
    largest_law_width,
    law_error,
)
from stt_codegen.designs import RefinedDesign
from stt_codegen.pipeline import EmittedController
from stt_codegen.program import Program
from stt_codegen.program.targets.backend import Backend
from stt_codegen.program.targets.python.runner import GeneratedPython, load_module
from stt_codegen.sampling import ROUNDING

Array = npt.NDArray[Any]
SPECIAL_POSITIONS = (0.5, -0.5, 1.5)  # as a share of the way from the lower to the upper edge
SMALLEST_INT32, LARGEST_INT32 = -(2**31), 2**31 - 1


def ticks_and_states(controller: EmittedController, design: RefinedDesign, count: int, seed: int = 1) -> tuple[Array, ...]:
    """Choose ticks (P,) and states x (P, n); for order 2 also v (P, n). P is `count`.

    Ticks are of the mission and beyond it. States are in and about the tube, at its edges and anywhere; v is such that
    v + lambda x is so in the filtered tube. The emitted Python computes the edges."""
    dice = Random(seed)
    period = controller.task.emit.tick_period
    assert period is not None
    python = load_module(controller.task.name, controller.files[f"{controller.task.name}.py"])
    end_tick = choose_clock(design, period).end_tick
    clamp_share = float(1 - max(controller.task.e_max)) / 2
    ticks, states, velocities = [], [], []
    for _ in range(count):
        special = [0, 1, end_tick - 1, end_tick, end_tick + 1, 2**32 - 1, dice.randrange(2**32)]
        tick = dice.choice([*special, *(dice.randrange(end_tick) for _ in range(12))])
        x = _random_integer_state(dice, python.tube(tick), clamp_share)
        ticks.append(tick)
        states.append(x)
        if design.filter:
            z = _random_integer_state(dice, python.filtered_tube(tick), clamp_share)
            v = [round(z_i - float(lambda_) * x_i) for z_i, lambda_, x_i in zip(z, design.filter, x, strict=True)]
            velocities.append([max(SMALLEST_INT32, min(LARGEST_INT32, v_i)) for v_i in v])
    ticks_and_positions = (np.array(ticks, np.uint32), np.array(states, np.int32))
    return (*ticks_and_positions, np.array(velocities, np.int32)) if design.filter else ticks_and_positions


def _random_integer_state(dice: Random, edges: tuple[Any, Any], clamp_share: float) -> list[int]:
    """Choose a number for each component: mostly about its edges, or on them, at the clamp of e, or any integer of 32 bits."""
    clamp_positions = (clamp_share, 1 - clamp_share, 0.98 * clamp_share, 1 - 0.98 * clamp_share)
    positions = (*SPECIAL_POSITIONS, *clamp_positions)
    state = []
    for low, high in zip(*edges, strict=True):
        position = dice.choice([dice.random(), dice.uniform(-0.2, 1.2), dice.choice(positions)])
        near = low + round((high - low) * position)
        anywhere = dice.randrange(-(2**31), 2**31)
        state.append(dice.choice([near] * 12 + [low, high, SMALLEST_INT32, LARGEST_INT32, anywhere]))
    return state


class _ValueInTube(NamedTuple):
    """A value, x or v + lambda x, and the tube that it must be in, in the task's units."""

    value: Array
    tube: TubeWithErrors

    def margin(self) -> Array:
        """Return the distance to the nearer edge over the width, by component."""
        low, high, _ = self.tube
        return np.asarray(np.clip(np.minimum(self.value - low, high - self.value) / (high - low), -1, 0.5))

    def margin_error(self) -> Array:
        """Bound how far errors of the edges move the margin."""
        low, high, error = self.tube
        return np.asarray((1 + 2 * np.abs(self.margin())) * error / (high - low - 2 * error))

    def clearance(self) -> Array:
        """Return how much farther the value is from its nearest edge than errors can move that."""
        low, high, error = self.tube
        return np.asarray(np.minimum(np.abs(self.value - low), np.abs(high - self.value)) - error)

    def is_inside(self) -> Array:
        """Return, by component, whether the value is strictly between its edges."""
        return (self.tube.lower < self.value) & (self.value < self.tube.upper)


@dataclass(frozen=True)
class _IntegerPoints:
    """Ticks (P,) and states as the backend takes them; x in its tube, and the value that the law is about in its own.

    For order 1 both values are x; for order 2 the law is about v + lambda x in the filtered tube."""

    tick: Array
    states: list[Array]
    x: _ValueInTube
    law_value: _ValueInTube


def add_integer_rows(rows: RowCollector, design: RefinedDesign, compared: ComparedBackend) -> None:
    """Compare all that the backend of a controller in integers computes."""
    backend, controller = compared.backend, compared.controller
    points = _choose_points(controller, design, compared.points)
    unit = float(design.unit)
    low, high, error = points.x.tube
    largest_edge = float(np.abs([low, high]).max())
    rows.add("tube", np.stack(backend.call("tube", points.tick)) * unit, np.stack([low, high]), error[None, None], largest_edge)
    if design.filter:
        low, high, error = points.law_value.tube
        computed = np.stack(backend.call("filtered_tube", points.tick)) * unit
        rows.add("filtered tube", computed, np.stack([low, high]), error[None, None], float(np.abs([low, high]).max()))
    status, u = backend.call("control", points.tick, *points.states)
    _add_input_row(rows, controller, design, points, u)
    values = [points.law_value] + ([points.x] if design.filter else [])
    is_inside = np.all([value.is_inside() for value in values], axis=(0, 2))
    rows.add_status(status, np.where(is_inside, 0, 1), np.minimum.reduce([value.clearance() for value in values]))
    _add_margin_rows(rows, controller, design, backend, points)
    rows.add("covered", *compare_covered(controller, design, backend, compared.points, 0.0), 1.0)


def _choose_points(controller: EmittedController, design: RefinedDesign, count: int) -> _IntegerPoints:
    """Choose points, and compute the exact tubes and values there."""
    edge_error, rate_error = (np.array([float(v) for v in error]) for error in edge_and_rate_errors(design, controller.program))
    tick_period = controller.program.tick
    assert tick_period is not None
    tick, *states = ticks_and_states(controller, design, count)
    t = tick.astype(np.longdouble) * reference.exact(tick_period)
    low, high = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
    unit = float(design.unit)
    largest_position = LARGEST_STATE >> 2 if design.filter else LARGEST_STATE  # the emitted code clamps x to it
    x = np.clip(states[0], -largest_position, largest_position) * unit
    x_in_tube = _ValueInTube(x, TubeWithErrors(low, high, edge_error))
    if not design.filter:
        return _IntegerPoints(tick, states, x_in_tube, x_in_tube)
    low_rate, high_rate = reference.tube_rate(design.integers(), design.unit, design.prescribed_time, t)
    lambda_ = np.array([reference.exact(v) for v in design.filter])
    z = np.clip(states[1], -LARGEST_STATE, LARGEST_STATE) * unit + lambda_ * x
    filtered_error = np.asarray(rate_error + lambda_ * edge_error, dtype=float)
    filtered_tube = TubeWithErrors(low_rate + lambda_ * low, high_rate + lambda_ * high, filtered_error)
    return _IntegerPoints(tick, states, x_in_tube, _ValueInTube(z, filtered_tube))


def _add_input_row(
    rows: RowCollector, controller: EmittedController, design: RefinedDesign, points: _IntegerPoints, computed_u: Array
) -> None:
    """Compare u (P, n), in units of 2^-u_bits, with (13) for the value that the law is about."""
    task = controller.task
    law = build_integer_law(task, design)
    value, (low, high, edge_error) = points.law_value
    _, u = reference.control(low, high, value, task.gain, task.e_max, u_max=task.u_max)
    _, unlimited_u = reference.control(low, high, value, task.gain, task.e_max)
    e, _, xi = reference.transform(low, high, value, task.e_max)
    gain, e_max = (np.array([abs(float(v)) for v in values]) for values in (task.gain, task.e_max))
    change = gain * law_change(low, high, value, edge_error, e_max)
    relative_error, epsilon_error = (float(v) for v in law_error(law, largest_law_width(task, design)))
    is_unclamped = np.abs(e) < e_max * (1 - 2.0**-12)
    relative_error_at_e = np.where(is_unclamped, relative_error, ROUNDING["fixed", "libm"])
    u_max = np.array([float(v) for v in task.u_max or ()])
    arithmetic = relative_error_at_e * np.abs(unlimited_u) + gain * xi * epsilon_error + u_max * 2.0**-19
    bound = change * (1 + relative_error_at_e) + arithmetic
    rows.add("u", computed_u * 2.0**-law.u_bits, u, np.minimum(bound, 2 * u_max), float(u_max.max()))


def _add_margin_rows(
    rows: RowCollector, controller: EmittedController, design: RefinedDesign, backend: Backend, points: _IntegerPoints
) -> None:
    """Compare `margins` and `margin`, in units of 2^-MARGIN_BITS: for order 2 the smaller one of v + lambda x and of x."""
    unit = 2.0**-MARGIN_BITS
    values = [points.law_value] + ([points.x] if design.filter else [])
    margins = np.minimum.reduce([value.margin() for value in values])
    errors = [value.margin_error() for value in values]
    law = build_integer_law(controller.task, design)
    reciprocal_error = float(curves.relative_errors(law.octaves)[0]) + 2.0**-17  # relative
    computed = backend.call("margins", points.tick, *points.states)[0] * unit
    bound = np.maximum.reduce(errors) + reciprocal_error * np.abs(margins) + 2 * unit
    rows.add("margins", computed, margins, bound, 1.0)
    smallest = margins.min(axis=1)
    bound = np.maximum.reduce([error.max(axis=1) for error in errors]) + reciprocal_error * np.abs(smallest) + 2 * unit
    rows.add("margin", backend.call("margin", points.tick, *points.states)[0] * unit, smallest, bound, 1.0)


def count_differences_from_python(controller: EmittedController, design: RefinedDesign, backend: Backend, count: int) -> int:
    """Count the points, over all functions, at which the backend returns another integer than the emitted Python."""
    python = GeneratedPython(controller)
    columns = dict(zip(("tick", "x", "v"), ticks_and_states(controller, design, count, seed=2), strict=False))

    def count_differences(program: Program, name: str) -> int:
        """Count the points at which one function returns another integer."""
        inputs = [columns[p.name] for p in program.function(name).inputs]
        pairs = zip(backend.call(name, *inputs), python.call(name, *inputs), strict=True)
        return int(np.any([np.any((a != b).reshape(len(a), -1), axis=1) for a, b in pairs], axis=0).sum())

    return sum(count_differences(controller.program, f.name) for f in controller.program.functions)
