"""Measure what the gentle gain saves: the root mean square of the change of u from sample to sample, beside the tight gain.

    python -m benchmarks gain_table [--task NAME ..] [--runs N] [--record FILE.md]

Each task is driven with control.gain = "tight" and with "auto", in the same tube: with random disturbances and measurements, and
with disturbances that always push outward, from random starts in the start share. The table also has the proved |e|, and the
factors of disturbance and period up to which the worst path proves the gentle gain. Where a task states no noise, some is added.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.suites.report import command, record, table
from stt_codegen.controller import edge_and_rate_errors
from stt_codegen.decimals import above, by_component
from stt_codegen.designs import RefinedDesign, require_refined
from stt_codegen.pipeline import EmittedController, build_task, preferred_tube
from stt_codegen.sampling import exact_loop, path_loop_of
from stt_codegen.sampling.path import proved_disturbance_factor, proved_period_factor
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task

Array = npt.NDArray[np.float64]
ROOT = Path(__file__).parents[1]
RUN_COUNT, SEED = 24, 5
LONGEST_STEP = 2.5e-3  # seconds, of the simulation; a period has at least STEPS_OF_A_PERIOD
STEPS_OF_A_PERIOD = 4
CHANGES: Mapping[str, dict[str, Any]] = {  # of the shipped tasks
    "trolley": {},
    "omni_s2": {
        "control": {"period": "0.02", "gain": "auto", "u_max": "1.5"},
        "plant": {"w_max": "0.1", "noise": "0.003"},
    },
    "crawler": {"plant": {"noise": "0.003"}},
    "rover": {},
    "gantry": {},
    "drone": {},
    "base": {},
    "crane": {"plant": {"noise": "0.001", "noise_v": "0.01"}},
    "attitude": {},
    "arm": {"plant": {"noise": "0.0002", "noise_v": "0.002"}},
}


@dataclass(frozen=True)
class MovingTube:
    """The edges of a tube and their rates, in doubles."""

    design: RefinedDesign
    points: Array = field(init=False)

    def __post_init__(self) -> None:
        """Read the Bezier coefficients, (K, n, 2, 4)."""
        object.__setattr__(self, "points", self.design.bezier().astype(float) * float(self.design.unit))

    def at(self, t: float) -> tuple[Array, Array]:
        """Return edges and their rates at a time, (n, 2) each; from t_c on the tube stands."""
        end, segments = float(self.design.prescribed_time), self.design.segments
        spline_time = min(max(t, 0.0), end) / end * segments
        k = min(int(spline_time), segments - 1)
        s = spline_time - k
        weights = np.array([(1 - s) ** 3, 3 * s * (1 - s) ** 2, 3 * s**2 * (1 - s), s**3])
        slopes = np.array([-((1 - s) ** 2), (1 - s) * (1 - 3 * s), s * (2 - 3 * s), s**2]) * 3 * segments / end
        return self.points[k] @ weights, self.points[k] @ slopes * (t < end)


@dataclass(frozen=True)
class Measured:
    """What runs of one gain showed: the rms of the change of u and of u, the largest |e|, and how many runs left the tube."""

    change: float
    input: float
    error: float
    left: int


@dataclass
class Runs:
    """Closed loops of one controller, many at once, with everything at the bounds of [plant]."""

    controller: EmittedController
    is_outward: bool
    count: int

    def measure(self) -> Measured:
        """Drive all runs to t_c."""
        task = self.controller.task
        rng, n, period = np.random.default_rng(SEED), task.dimension, float(task.sampling_period)
        tube = MovingTube(require_refined(self.controller.design))
        steps = max(STEPS_OF_A_PERIOD, math.ceil(period / LONGEST_STEP))
        late_step, dt = round(float(task.control.latency) / period * steps), period / steps
        edges, _ = tube.at(0.0)
        share = float(task.initial_set.share)
        x = edges.mean(axis=1) + (edges[:, 1] - edges[:, 0]) / 2 * share * rng.uniform(-1, 1, (self.count, n))
        v, u, before = np.zeros_like(x), np.zeros_like(x), None
        g_min, g_max = (np.array([float(getattr(b, name)) for b in task.plant_bounds]) for name in ("g_min", "g_max"))
        g = g_min + (g_max - g_min) * rng.random(x.shape)
        noise, noise_v = (np.array([float(v) for v in values]) for values in (task.noise, task.noise_v))
        left, largest_error = np.zeros(self.count, bool), 0.0
        changes: list[float] = []
        inputs: list[float] = []
        for k in range(math.ceil(float(task.prescribed_time) / period)):
            measurement = x + noise * rng.uniform(-1, 1, x.shape), v + noise_v * rng.uniform(-1, 1, x.shape)
            commanded = self._law(tube, k * period, *measurement)
            changes += [] if before is None else [((commanded - before) ** 2).mean()]
            inputs.append((commanded**2).mean())
            before, push = commanded, rng.uniform(-1, 1, x.shape)
            for j in range(steps):
                u = commanded if j == (late_step if k else 0) else u
                x, v = self._moved(tube, (k * period + j * dt, dt), (x, v), u, push=push, g=(g_min, g, g_max))
            edges, _ = tube.at((k + 1) * period)
            error = np.abs(2 * x - edges.sum(axis=1)) / (edges[:, 1] - edges[:, 0])
            left |= (error >= 1).any(axis=1)
            largest_error = max(largest_error, float(error.max()))
        return Measured(math.sqrt(np.mean(changes)), math.sqrt(np.mean(inputs)), largest_error, int(left.sum()))

    def _distances(self, tube: MovingTube, t: float, x: Array, v: Array) -> tuple[Array, Array]:
        """Return the distances to both edges, for order 2 those of v + lambda x."""
        edges, rates = tube.at(t)
        a, b = x - edges[:, 0], edges[:, 1] - x
        if self.controller.task.order == 2:
            rate = np.array([float(s) for s in tube.design.filter])
            a, b = v - rates[:, 0] + rate * a, rates[:, 1] - v + rate * b
        return a, b

    def _law(self, tube: MovingTube, t: float, x: Array, v: Array) -> Array:
        """Return u of (13), with its clamp and its limit."""
        task = self.controller.task
        a, b = self._distances(tube, t, x, v)
        gain, clamp = (np.array([float(k) for k in values]) for values in (task.gain, task.e_max))
        near = np.maximum(np.minimum(a, b), (a + b) * (1 - clamp) / 2)
        far = a + b - near
        u = np.where(b < a, -1, 1) * gain * (1 / near + 1 / far) * np.log(far / near)
        limit = np.array([float(w) for w in task.u_max or ()]) if task.u_max else np.inf
        return np.asarray(np.clip(u, -limit, limit))

    def _moved(
        self,
        tube: MovingTube,
        time: tuple[float, float],
        state: tuple[Array, Array],
        u: Array,
        *,
        push: Array,
        g: tuple[Array, Array, Array],
    ) -> tuple[Array, Array]:
        """Return the state a step later. time: now, and the step. push: of each component, as a share of its bound."""
        (x, v), (t, dt), bounds = state, time, self.controller.task.plant_bounds
        force, cross = (np.array([float(getattr(b, name)) for b in bounds]) for name in ("force", "cross"))
        g_min, g_drawn, g_max = g
        if self.is_outward:
            a, b = self._distances(tube, t, x, v)
            push = np.where(a >= b, 1.0, -1.0)
            g_drawn = np.where(u * push < 0, g_min, g_max)
        coupled_inputs = np.abs(u).sum(axis=1, keepdims=True) - np.abs(u)
        rate = force * push + g_drawn * u + cross * coupled_inputs * np.sign(push)
        if self.controller.task.order == 1:
            return x + rate * dt, v
        return x + v * dt + rate * dt**2 / 2, v + rate * dt


def controllers_of(name: str) -> dict[str, EmittedController]:
    """Return the controllers with the tight and with the gentle gain, in one tube."""
    task: Task = load_task(ROOT / "tasks" / f"{name}.toml")
    task = task.changed(**CHANGES[name]) if CHANGES[name] else task
    design = preferred_tube(task)
    return {rule: build_task(task.changed(control={"gain": rule}), tube=design) for rule in ("tight", "auto")}


def row_of(name: str, run_count: int) -> list[str]:
    """Return the table's row of a task."""
    controllers = controllers_of(name)
    measured = {
        (rule, is_outward): Runs(controller, is_outward, run_count).measure()
        for rule, controller in controllers.items()
        for is_outward in (False, True)
    }
    gentle = controllers["auto"]
    task, design = gentle.task, require_refined(gentle.design)
    loop = path_loop_of(task, design, exact_loop(task, design, *edge_and_rate_errors(design, gentle.program)))
    forces = [bounds.force for bounds in task.plant_bounds]
    reserves = [proved_disturbance_factor(loop, forces), proved_period_factor(loop, task.sampling_period)]
    proofs = [controller.certificate.proved_period for controller in controllers.values()]
    errors = [max((v - 1) / (v + 1) for v in proof.rho) for proof in proofs if proof is not None]
    return [
        name,
        *(by_component([float(k) for k in controller.task.gain]) for controller in controllers.values()),
        *(" -> ".join(f"{measured[rule, is_outward].change:.3g}" for rule in controllers) for is_outward in (False, True)),
        " -> ".join(f"{measured[rule, False].input:.3g}" for rule in controllers),
        ", ".join(f"{above(v, 3):.3f}" for v in errors),
        ", ".join(f"{float(v):g}" for v in reserves),
        "path" if proofs[1] is not None and proofs[1].paths else "sharp",
        f"{max(m.error for m in measured.values()):.2f}, {sum(m.left for m in measured.values())}",
    ]


def main() -> int:
    """Print the table. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", action="append", choices=list(CHANGES))
    parser.add_argument("--runs", type=int, default=RUN_COUNT)
    parser.add_argument("--record", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    headings = ["task", "tight gain", "gain", "rms of u's change, random", "outward", "rms of u", "proved |e|"]
    headings += ["proved for times w, period", "P9 by", "|e| seen, runs that left"]
    rows = []
    for name in options.task or CHANGES:
        rows.append(row_of(name, options.runs))
        print(" | ".join(rows[-1]), flush=True)
    text = table(headings, rows)
    print(text)
    if options.record:
        about = 'From control.gain = "tight" to "auto", in the same tube, at the period of the task.'
        record(options.record, "gain-table", f"## The gentlest gain\n\n`{command()}`\n\n{about}\n\n{text}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
