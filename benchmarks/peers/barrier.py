"""A barrier filter as a peer: at every step it takes the input nearest to a go-to-goal law that keeps every barrier.

OSQP's generated C solves its quadratic program, with settings that are good for it: no scaling and a test of convergence at every
iteration, a sixth of the time that its defaults take. `in_arenas` and `in_loops` run it; templates/cbf_step.c has its C.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.peers.quadratic import compile_with, generated_solver
from benchmarks.suites.families import BOX, FAMILIES, Family, arena_task, cubes
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.program.targets.template_files import template_folder

SPEED = 1.0  # bound of each input: the straight way (4.25) takes half of the 9 s
# The class-K term is CLASS_K h. With this SHARPNESS h is at most ln(2)/40 = 0.017 below the distance to the box.
FILTER_NUMBERS = {"SPEED": SPEED, "GAIN": 2.0, "CLASS_K": 10.0, "SHARPNESS": 40.0}


@dataclass(frozen=True)
class ClosedLoop:
    """A closed loop of xdot = u for 9 s, from the start's centre. step_seconds: time of a step; reached, collided: 1 if it ended
    in the target, and if it met a box, else 0."""

    step_seconds: float
    reached: int
    collided: int


def run_closed_loops(
    family: Family, seed: int, ours: EmittedController | None = None, hertz: int = 1000
) -> dict[str, ClosedLoop]:
    """Run the filter ("cbf") and our controller, if any ("own"), one after the other in a process: templates/cbf_step.c.

    The filter minimizes |u - u_nominal|^2 over u with grad h_j . u >= -CLASS_K h_j for each box j. h_j is a smooth lower bound
    (log-sum-exp) of the largest-component distance to the box. Walls and |u_i| <= SPEED bound u itself; the nominal law is
    GAIN (target - x), clamped. Matrix and bounds of the program are new at every step; u = 0 without solution.
    """
    solver = _filter_solver(family.count, family.dimension).name
    numbers = {"BOXES": family.count, "N": family.dimension, "SIDE": family.side, "END": BOX, "HERTZ": hertz, **FILTER_NUMBERS}
    defined = [f"-D{name}={value}" for name, value in numbers.items()]
    with tempfile.TemporaryDirectory() as folder:
        if ours is not None:
            for name, data in ours.files.items():
                Path(folder, name).write_bytes(data)
            defined += ["-DOWN", f"-I{folder}", f"{folder}/arena.c"]
        compile_with(solver, f"{folder}/loops", *defined, str(template_folder() / "cbf_step.c"), f"{solver}/osqp.o", "-lm")
        edges = " ".join(repr(v) for v in cubes(family, seed).ravel().tolist())
        result = subprocess.run([f"{folder}/loops"], input=edges, capture_output=True, text=True, check=True)
    rows = (line.split() for line in result.stdout.splitlines())
    return {name: ClosedLoop(float(seconds), *map(int, counts)) for name, seconds, *counts in rows}


@cache
def filter_library(count: int, dimension: int, side: float, hertz: int = 1000) -> ctypes.CDLL:
    """Compile the filter as a library for the loops of `stt_codegen.loop`: filter_boxes(edges), filter_next(t, x, u)."""
    solver = _filter_solver(count, dimension).name
    numbers = {"BOXES": count, "N": dimension, "SIDE": side, "END": BOX, "HERTZ": hertz, **FILTER_NUMBERS}
    defined = [f"-D{name}={value}" for name, value in numbers.items()]
    with tempfile.TemporaryDirectory() as folder:
        library, source = f"{folder}/filter.so", str(template_folder() / "cbf_step.c")
        compile_with(solver, library, *defined, "-DLIBRARY", "-shared", "-fPIC", source, f"{solver}/osqp.o", "-lm")
        return ctypes.CDLL(library)


@cache
def _filter_solver(count: int, dimension: int) -> tempfile.TemporaryDirectory[str]:
    """Generate the solver of the filter's program for that many boxes."""
    rows = np.vstack([np.ones((count, dimension)), np.eye(dimension)])  # only its pattern counts
    solver_settings = {"scaling": 0, "check_termination": 1, "adaptive_rho": False}
    return generated_solver(np.eye(dimension), rows, "matrices", "cbf_", **solver_settings)


def step_times(seeds: Sequence[int], hertz: int = 1000) -> dict[str, float]:
    """Compare the filter's step with our emitted one on the paper's arenas: medians in microseconds and shares of the arenas.

    Times, their ratio and `own_...` are over the arenas with a certified design (`certified` of `arenas`). Ours leaves a tube
    so narrow that width^2 / (8 gain) is below the period: its certificate is for continuous time. Raises `BadInput` where no
    arena has a certified design.
    """
    family, loops = FAMILIES["paper"], []
    for seed in seeds:
        try:
            ours = build_task(arena_task(family, seed))
        except NotCertified:
            ours = None
        loops.append(run_closed_loops(family, seed, ours, hertz))
    both = np.array([[pair["cbf"].step_seconds, pair["own"].step_seconds] for pair in loops if "own" in pair]) * 1e6
    if not both.size:
        raise BadInput("step_times: needs the seed of at least one arena with a certified design")
    numbers = {"arenas": len(loops), "certified": len(both), "ratio": float(np.median(both[:, 0] / both[:, 1]))}
    numbers["cbf_microseconds"], numbers["own_microseconds"] = (float(v) for v in np.median(both, axis=0))
    for name in ("cbf", "own"):
        results = [pair[name] for pair in loops if name in pair]
        numbers[f"{name}_reaches"] = sum(loop.reached and not loop.collided for loop in results) / len(results)
        numbers[f"{name}_collides"] = sum(loop.collided for loop in results) / len(results)
    return numbers
