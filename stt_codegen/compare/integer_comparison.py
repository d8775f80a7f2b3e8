"""A controller in integers against the reference: edges and u within bounds derived for its ticks, its units and its curves.

tube, filtered tube   P7 (`controller.integers.errors`)
u                     what moved edges do to (13), as for floats, and `law_error`; where the clamp acts, which does so up to
                      2^-13 later, as much as `sampling.ROUNDING` says
margin                the distance moved by P7, over the width; 1/d, and a unit
status                may differ only where x is within P7 of an edge
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.compare.law_bounds import law_spread
from stt_codegen.compare.start_comparison import covered_row
from stt_codegen.controller.integers import LARGEST_STATE, MARGIN_BITS, choose_clock, curves, law_error, build_integer_law, largest_law_width
from stt_codegen.designs import RefinedDesign
from stt_codegen.pipeline import EmittedController
from stt_codegen.program import Program
from stt_codegen.program.targets.backend import Backend
from stt_codegen.program.targets.python.runner import GeneratedPython, load_module
from stt_codegen.sampling import ROUNDING

Array = npt.NDArray[Any]
Add = Callable[[str, Array, Array, Array, float], None]
PLACES = (0.5, -0.5, 1.5)  # of the way from one edge to the other
ENDS = (-(2**31), 2**31 - 1)


def ticks_and_states(controller: EmittedController, design: RefinedDesign, count: int, seed: int = 1) -> tuple[Array, ...]:
    """Ticks (P,) of the mission and of none; states (P, n) in and about the tube, at its edges and anywhere; of order 2 speeds
    with which v + lambda x is so in its own tube. By the emitted Python, with all that it takes."""
    task, dice = controller.task, Random(seed)
    assert task.emit.tick_period is not None
    python = load_module(task.name, controller.files[f"{task.name}.py"])
    last = choose_clock(design, task.emit.tick_period).end_tick
    ticks, states, speeds = [], [], []

    clamp = float(1 - max(task.e_max)) / 2  # of the way from an edge to the other
    places = (*PLACES, clamp, 1 - clamp, 0.98 * clamp, 1 - 0.98 * clamp)

    def placed(edges: tuple[Any, Any]) -> list[int]:
        found = []
        for low, high in zip(*edges, strict=True):
            near = low + round((high - low) * dice.choice([dice.random(), dice.uniform(-0.2, 1.2), dice.choice(places)]))
            found.append(dice.choice([near] * 12 + [low, high, *ENDS, dice.randrange(-(2**31), 2**31)]))
        return found

    for _ in range(count):
        ends = [0, 1, last - 1, last, last + 1, 2**32 - 1, dice.randrange(2**32)]
        tick = dice.choice([*ends, *(dice.randrange(last) for _ in range(12))])
        x = placed(python.tube(tick))
        ticks.append(tick)
        states.append(x)
        if design.filter:
            z = placed(python.filtered_tube(tick))
            v = [round(a - float(value) * b) for a, value, b in zip(z, design.filter, x, strict=True)]
            speeds.append([max(ENDS[0], min(ENDS[1], value)) for value in v])
    found = (np.array(ticks, np.uint32), np.array(states, np.int32))
    return (*found, np.array(speeds, np.int32)) if design.filter else found


def integer_rows(
    controller: EmittedController,
    design: RefinedDesign,
    backend: Backend,
    points: int,
    errors: tuple[Array, Array],
    add: Add,
    status: Callable[..., None],
) -> None:
    """The rows of one backend. errors: of edges and rates, (n,). add: a quantity, what came out, the truth, its bound and its
    scale; status: as `comparison._Rows.status`."""
    task, program = controller.task, controller.program
    assert program.tick is not None
    tick, *states = ticks_and_states(controller, design, points)
    unit, law = float(design.unit), build_integer_law(task, design)
    t = tick.astype(np.longdouble) * reference.exact(program.tick)
    places = reference.tube(design.integers(), design.unit, design.prescribed_time, t)
    delta, rate_delta = errors
    add("tube", np.stack(backend.call("tube", tick)) * unit, np.stack(places), delta[None, None], float(np.abs(places).max()))
    low, high = places
    farthest = LARGEST_STATE >> 2 if design.filter else LARGEST_STATE  # a state that is farther out counts as so far
    x = np.clip(states[0], -farthest, farthest) * unit
    held, moved = x, delta
    edges: tuple[Array, Array] = places
    if design.filter:
        slopes = reference.tube_rate(design.integers(), design.unit, design.prescribed_time, t)
        value = np.array([reference.exact(v) for v in design.filter])
        edges = (slopes[0] + value * low, slopes[1] + value * high)
        held, moved = (
            np.clip(states[1], -LARGEST_STATE, LARGEST_STATE) * unit + value * x,
            np.asarray(rate_delta + value * delta, dtype=float),
        )
        got = np.stack(backend.call("filtered_tube", tick)) * unit
        add("filtered tube", got, np.stack(edges), moved[None, None], float(np.abs(edges).max()))
    codes, u = backend.call("control", tick, *states)
    relative, in_eps = (float(v) for v in law_error(law, largest_law_width(task, design)))
    _, true = reference.control(*edges, held, task.gain, task.e_max, u_max=task.u_max)
    _, plain = reference.control(*edges, held, task.gain, task.e_max)
    e, _, xi = reference.transform(*edges, held, task.e_max)
    gain, clamp = (np.array([abs(float(v)) for v in values]) for values in (task.gain, task.e_max))
    spread = gain * law_spread(*edges, held, moved, clamp)
    own = np.where(np.abs(e) < clamp * (1 - 2.0**-12), relative, ROUNDING["fixed", "libm"])
    limit = np.array([float(v) for v in task.u_max or ()])
    bound = spread * (1 + own) + own * np.abs(plain) + gain * xi * in_eps + limit * 2.0**-19
    add("u", u * 2.0**-law.u_bits, true, np.minimum(bound, 2 * limit), float(limit.max()))
    rooms = [(held, edges, moved)] + ([(x, (low, high), delta)] if design.filter else [])
    near = [np.minimum(np.abs(z - a), np.abs(b - z)) - d for z, (a, b), d in rooms]
    inside = np.all([(a < z) & (z < b) for z, (a, b), _ in rooms], axis=(0, 2))
    status(codes, np.where(inside, 0, 1), np.minimum.reduce(near))
    shares = [np.clip(np.minimum(z - a, b - z) / (b - a), -1, 0.5) for z, (a, b), _ in rooms]
    loose = [(1 + 2 * np.abs(s)) * d / (b - a - 2 * d) for s, (_, (a, b), d) in zip(shares, rooms, strict=True)]
    want = np.minimum.reduce(shares)
    over = float(curves.relative_errors(law.octaves)[0]) + 2.0**-17
    got = backend.call("margins", tick, *states)[0] * 2.0**-MARGIN_BITS
    add("margins", got, want, np.maximum.reduce(loose) + over * np.abs(want) + 2 * 2.0**-MARGIN_BITS, 1.0)
    want, bound = want.min(axis=1), np.maximum.reduce([d.max(axis=1) for d in loose])
    got = backend.call("margin", tick, *states)[0] * 2.0**-MARGIN_BITS
    add("margin", got, want, bound + over * np.abs(want) + 2 * 2.0**-MARGIN_BITS, 1.0)
    add("covered", *covered_row(controller, design, backend, points, 0.0), 1.0)


def same_as_python(controller: EmittedController, design: RefinedDesign, backend: Backend, points: int) -> int:
    """How many of so many points give another integer than the emitted Python, over all functions."""
    python = GeneratedPython(controller)
    columns = dict(zip(("tick", "x", "v"), ticks_and_states(controller, design, points, seed=2), strict=False))

    def differs(program: Program, name: str) -> int:
        inputs = [columns[p.name] for p in program.function(name).inputs]
        pairs = zip(backend.call(name, *inputs), python.call(name, *inputs), strict=True)
        return int(np.any([np.any((a != b).reshape(len(a), -1), axis=1) for a, b in pairs], axis=0).sum())

    return sum(differs(controller.program, f.name) for f in controller.program.functions)
