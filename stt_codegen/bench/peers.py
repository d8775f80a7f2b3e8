"""What a user would reach for instead, run on the same random arenas: planners, a reachability solver, a safety filter.

Each peer is asked its own question (`Peer.asks`); none of them answers ours, a proved tube with the controller that keeps
an unknown system inside it. So beside time and success stands what each guarantees and what it lacks.

Every peer gets settings that are good for it, on one thread: OMPL an exact check of motions (in Python, like the problem)
in place of samples along them, hj-reachability its quickest scheme, OSQP no scaling and a test of convergence at every
iteration (a sixth of the time its defaults take). Imports, compilation and a first problem are not timed.
The peers are optional; a missing one raises `MissingTool`.

Long because every peer is set up in full, so that a reader can check that it was treated fairly.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from stt_codegen.bench.families import BOX, FAMILIES, Array, Family, arena_task, cubes
from stt_codegen.compare.toolchain import find_compiler, run_compiler
from stt_codegen.emit.render import template_folder
from stt_codegen.errors import BadInput, MissingTool, NotCertified
from stt_codegen.pipeline import Controller, build_task

MARGIN = 0.02  # by which OMPL's obstacles grow
CELLS = 100  # of the grids, by dimension
SEED = 1  # of OMPL's random numbers, for each problem anew: the path does not depend on the problems before
GIVE_UP = 1.0  # seconds after which a random planner stops
SPEED = 1.0  # bound of each input: the straight way (4.25) takes half of the 9 s
# Filter: class-K term CLASS_K h, and the barrier's sharpness: at most ln(2)/40 = 0.017 below the distance to the box.
FILTER = {"SPEED": SPEED, "GAIN": 2.0, "CLASS_K": 10.0, "SHARPNESS": 40.0}


@dataclass(frozen=True)
class Outcome:
    """One peer on one arena: seconds are for what `Peer.per` says."""

    success: bool
    seconds: float
    note: str = ""


@dataclass(frozen=True)
class Peer:
    """A peer, the question it is asked, and what its answer is worth; `sample`: at most so many arenas, it is slow."""

    name: str
    asks: str
    guarantees: str
    lacks: str
    run: Callable[[Family, int], Outcome]
    sample: int | None = None
    per: str = "problem"


def need(module: str) -> Any:
    """A module of an optional package. Raises `MissingTool`."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MissingTool(f"{module} cannot be imported ({error}): make peers, or pip install stt-codegen[peers]") from error


Planner = Callable[[Family, Array], Array | None]  # family, boxes -> a path, shape (points, dimension), if it finds one


def plan(planner: Planner, family: Family, seed: int) -> Outcome:
    """A planner on one arena; a path counts only when it is safe by our own check."""
    _warm(planner, family)
    boxes, begin = cubes(family, seed), time.perf_counter()
    path = planner(family, boxes)
    seconds = time.perf_counter() - begin
    note = "no path found" if path is None else "" if path_is_safe(family, boxes, path) else "its path is not safe"
    return Outcome(not note, seconds, note)


@cache
def _warm(planner: Planner, family: Family) -> None:
    planner(family, cubes(family, 0))


def path_is_safe(family: Family, boxes: Array, path: Array) -> bool:
    """Whether straight segments lead from the start's box to the target's, inside the space, through no open box: exactly."""
    points = [[Fraction(float(v)) for v in point] for point in path]
    inside = all(0 <= v <= family.side for point in points for v in point)
    joins = max(points[0]) <= BOX and min(points[-1]) >= family.side - BOX
    edges = [[(Fraction(float(low)), Fraction(float(high))) for low, high in box] for box in boxes]
    return inside and joins and not any(_meets(p, q, box) for p, q in pairwise(points) for box in edges)


def _meets(p: Sequence[Any], q: Sequence[Any], box: Sequence[Sequence[Any]]) -> bool:
    """Whether the segment from p to q meets the open box, for any kind of number."""
    enter, leave = 0, 1
    for a, b, (low, high) in zip(p, q, box, strict=True):
        if a <= low >= b or a >= high <= b:
            return False
        if a != b:
            first, last = (low - a) / (b - a), (high - a) / (b - a)
            enter, leave = max(enter, min(first, last)), min(leave, max(first, last))
    return enter < leave


def rrt_connect(family: Family, boxes: Array) -> Array | None:
    """OMPL's RRTConnect: two random trees that grow towards each other."""
    return _ompl_path(family, boxes, "RRTConnect")


def rrt_star(family: Family, boxes: Array) -> Array | None:
    """OMPL's RRT*, stopped at its first solution."""
    return _ompl_path(family, boxes, "RRTstar")


def _ompl_path(family: Family, boxes: Array, planner_name: str) -> Array | None:
    base, geometric, util, motion_validator = _ompl()
    util.RNG.setSeed(SEED)
    axes = range(family.dimension)
    space = base.RealVectorStateSpace(family.dimension)
    space.setBounds(0.0, family.side)
    info = base.SpaceInformation(space)
    motions = motion_validator(info)
    motions.boxes = [[(low - MARGIN, high + MARGIN) for low, high in box] for box in boxes.tolist()]
    info.setStateValidityChecker(lambda state: motions.checkMotion(state, state))
    info.setMotionValidator(motions)
    info.setup()
    problem = base.ProblemDefinition(info)
    start, goal = space.allocState(), space.allocState()
    for i in axes:
        start[i], goal[i] = BOX / 2, family.side - BOX / 2
    problem.setStartAndGoalStates(start, goal, BOX / 2)  # a ball inside the target
    length = base.PathLengthOptimizationObjective(info)
    length.setCostThreshold(length.infiniteCost())  # any path is short enough
    problem.setOptimizationObjective(length)
    planner = getattr(geometric, planner_name)(info)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(GIVE_UP)
    if not problem.hasExactSolution():
        return None
    return np.array([[state[i] for i in axes] for state in problem.getSolutionPath().getStates()])


@cache
def _ompl() -> tuple[Any, Any, Any, Any]:
    base, geometric, util = need("ompl.base"), need("ompl.geometric"), need("ompl.util")
    util.setLogLevel(util.LogLevel.LOG_NONE)  # it warns that a second seed leaves older planners as they were

    def check_motion(self: Any, first: Any, last: Any) -> bool:
        axes = range(len(self.boxes[0]))
        p, q = [first[i] for i in axes], [last[i] for i in axes]
        return not any(_meets(p, q, box) for box in self.boxes)

    return base, geometric, util, type("Motions", (base.MotionValidator,), {"checkMotion": check_motion})


def a_star(family: Family, boxes: Array) -> Array | None:
    """pyastar2d's A* over grid points. Boxes grow by half a cell, so that no diagonal step cuts a corner."""
    axis = _axis(family)
    grown = boxes + family.side / CELLS / 2 * np.array([-1.0, 1.0])
    weights = np.ones((CELLS + 1, CELLS + 1), dtype=np.float32)
    for box in grown:
        weights[np.ix_(*((low <= axis) & (axis <= high) for low, high in box))] = np.inf
    start, goal = (int(np.argmin(abs(axis - v))) for v in (BOX / 2, family.side - BOX / 2))
    path = need("pyastar2d").astar_path(weights, (start, start), (goal, goal), allow_diagonal=True)
    return None if path is None else axis[path]


def _axis(family: Family) -> Array:
    """The coordinates of the grid points along one axis."""
    if family.dimension != 2:
        raise BadInput(f"family {family.name}: has {family.dimension} dimensions; this peer runs on arenas of 2")
    return np.linspace(0.0, family.side, CELLS + 1)


def reach_avoid_tube(family: Family, seed: int) -> Outcome:
    """Success: the value at the start's centre says that xdot = u, |u_i| <= SPEED, can reach the target within 9 s."""
    axis, solve, boxes = _axis(family), _reach_avoid_solver(family), cubes(family, seed)
    begin = time.perf_counter()
    states = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1)

    def outside(box: Array) -> Any:  # how far, in the largest component; negative inside
        return np.max(np.maximum(box[:, 0] - states, states - box[:, 1]), axis=-1)

    target, space = (outside(np.array([[low, family.side]] * 2)) for low in (family.side - BOX, 0.0))
    avoid = np.max([space, *(-outside(box) for box in boxes)], axis=0)
    value = np.asarray(solve(target, avoid))
    seconds = time.perf_counter() - begin
    centre = int(np.argmin(abs(axis - BOX / 2)))
    return Outcome(bool(value[centre, centre] < 0), seconds)


@cache
def _reach_avoid_solver(family: Family) -> Callable[[Array, Array], Any]:
    """(target, avoid) on the grid -> value, compiled once: both fields are arguments, not constants of the compiled code."""
    for setting in ("JAX_PLATFORMS=cpu", "NPROC=1", "XLA_FLAGS=--xla_cpu_multi_thread_eigen=false"):
        os.environ.setdefault(*setting.split("=", 1))  # one thread; read when the package is first imported
    hj, jax, jnp = need("hj_reachability"), need("jax"), need("jax.numpy")
    equations = {
        "open_loop_dynamics": lambda self, state, time: jnp.zeros(2),
        "control_jacobian": lambda self, state, time: jnp.eye(2),
        "disturbance_jacobian": lambda self, state, time: jnp.zeros((2, 2)),
    }
    inputs, disturbances = (hj.sets.Box(jnp.full(2, -bound), jnp.full(2, bound)) for bound in (SPEED, 0.0))
    dynamics = type("Integrator", (hj.ControlAndDisturbanceAffineDynamics,), equations)("min", "max", inputs, disturbances)
    domain = hj.sets.Box(np.zeros(2), np.full(2, family.side))
    grid = hj.Grid.from_lattice_parameters_and_boundary_conditions(domain, (CELLS + 1, CELLS + 1))

    def solve(target: Any, avoid: Any) -> Any:
        tube, obstacle = hj.solver.backwards_reachable_tube, hj.solver.static_obstacle(avoid)
        settings = hj.SolverSettings.with_accuracy("low", hamiltonian_postprocessor=tube, value_postprocessor=obstacle)
        return hj.step(settings, dynamics, grid, 0.0, jnp.maximum(target, avoid), -9.0, progress_bar=False)

    compiled: Callable[[Array, Array], Any] = jax.jit(solve)
    np.asarray(compiled(np.ones(grid.shape), np.ones(grid.shape)))
    return compiled


@dataclass(frozen=True)
class Loop:
    """xdot = u for 9 s in closed loop, from the start's centre; `failed`: steps without solution or outside our tube."""

    seconds: float
    reached: int
    collided: int
    failed: int


def barrier_filter(family: Family, seed: int) -> Outcome:
    """Success: the filtered go-to-goal law ends in the target after 9 s and no step lies in a box; seconds are for a step."""
    loop = closed_loops(family, seed)["cbf"]
    note = "collides" if loop.collided else "" if loop.reached else "not at the target in time"
    return Outcome(not note, loop.seconds, note)


def closed_loops(family: Family, seed: int, own: Controller | None = None, hertz: int = 1000) -> dict[str, Loop]:
    """The filter ("cbf") and, where given, our controller ("own"), one after the other in a process: templates/cbf_step.c.

    The filter: min |u - u_nominal|^2 over u with grad h_j . u >= -CLASS_K h_j for each box j. h_j is a smooth lower bound
    (log-sum-exp) of the largest-component distance to the box. Walls and |u_i| <= SPEED bound u itself; the nominal law is
    GAIN (target - x), clamped. OSQP's generated C solves it, its matrix and bounds new at every step; u = 0 without solution.
    """
    solver = _generated_solver(family.count, family.dimension).name
    numbers = {"BOXES": family.count, "N": family.dimension, "SIDE": family.side, "END": BOX, "HERTZ": hertz, **FILTER}
    defined = [f"-D{name}={value}" for name, value in numbers.items()]
    with tempfile.TemporaryDirectory() as folder:
        if own is not None:
            for name, data in own.files.items():
                Path(folder, name).write_bytes(data)
            defined += ["-DOWN", f"-I{folder}", f"{folder}/arena.c"]
        _compile(solver, f"{folder}/loops", *defined, str(template_folder() / "cbf_step.c"), f"{solver}/osqp.o", "-lm")
        edges = " ".join(repr(v) for v in cubes(family, seed).ravel().tolist())
        result = subprocess.run([f"{folder}/loops"], input=edges, capture_output=True, text=True, check=True)
    rows = (line.split() for line in result.stdout.splitlines())
    return {name: Loop(float(seconds), *map(int, counts)) for name, seconds, *counts in rows}


@cache
def filter_library(count: int, dimension: int, side: float, hertz: int = 1000) -> ctypes.CDLL:
    """The filter as a library for the loops of `stt_codegen.loop`: filter_boxes(edges), filter_next(t, x, u)."""
    solver = _generated_solver(count, dimension).name
    numbers = {"BOXES": count, "N": dimension, "SIDE": side, "END": BOX, "HERTZ": hertz, **FILTER}
    defined = [f"-D{name}={value}" for name, value in numbers.items()]
    with tempfile.TemporaryDirectory() as folder:
        made, source = f"{folder}/filter.so", str(template_folder() / "cbf_step.c")
        _compile(solver, made, *defined, "-DLIBRARY", "-shared", "-fPIC", source, f"{solver}/osqp.o", "-lm")
        return ctypes.CDLL(made)


@cache
def _generated_solver(count: int, dimension: int) -> tempfile.TemporaryDirectory[str]:
    """OSQP's generated C for that many boxes, compiled to `osqp.o`; the folder lives as long as this process."""
    osqp, sparse, folder = need("osqp"), need("scipy.sparse"), tempfile.TemporaryDirectory()
    rows = np.vstack([np.ones((count, dimension)), np.eye(dimension)])  # only its pattern counts
    bound = np.ones(len(rows))
    data = sparse.eye(dimension, format="csc"), np.zeros(dimension), sparse.csc_matrix(rows), -bound, bound
    problem = osqp.OSQP()
    problem.setup(*data, scaling=0, check_termination=1, adaptive_rho=False, verbose=False)
    problem.codegen(folder.name, parameters="matrices", extension_name=None, force_rewrite=True, prefix="cbf_")
    sources = (str(p) for p in Path(folder.name).glob("**/*.c") if p.name != "emosqp.c")  # that one is an example's main
    _compile(folder.name, f"{folder.name}/osqp.o", "-fPIC", "-r", "-nostdlib", *sorted(sources))
    return folder


def _compile(solver: str, output: str, *arguments: str) -> None:
    includes = [f"-I{solver}/{part}" for part in ("inc/public", "inc/private", ".")]
    run_compiler([find_compiler(), "-O2", "-std=c99", *includes, *arguments, "-o", output])


def step_times(seeds: Sequence[int], hertz: int = 1000) -> dict[str, float]:
    """The filter's step beside our emitted one, on the paper's arenas: medians in microseconds and shares of the arenas.

    Times, their ratio and `own_...` are over the arenas with a certified design (`certified` of `arenas`). Ours leaves a tube
    so narrow that width^2 / (8 gain) is below the period: the certificate is for continuous time, the limit for sampled.
    """
    family, loops = FAMILIES["paper"], []
    for seed in seeds:
        try:
            own = build_task(arena_task(family, seed))
        except NotCertified:
            own = None
        loops.append(closed_loops(family, seed, own, hertz))
    both = np.array([[pair["cbf"].seconds, pair["own"].seconds] for pair in loops if "own" in pair]) * 1e6
    if not both.size:
        raise BadInput("step_times: needs the seed of at least one arena with a certified design")
    numbers = {"arenas": len(loops), "certified": len(both), "ratio": float(np.median(both[:, 0] / both[:, 1]))}
    numbers["cbf_microseconds"], numbers["own_microseconds"] = (float(v) for v in np.median(both, axis=0))
    for name in ("cbf", "own"):
        ran = [pair[name] for pair in loops if name in pair]
        numbers[f"{name}_reaches"] = sum(loop.reached and not loop.collided for loop in ran) / len(ran)
        numbers[f"{name}_collides"] = sum(loop.collided for loop in ran) / len(ran)
    return numbers


PEERS = (
    Peer(
        "OMPL RRTConnect",
        "a path from the start's centre to the target's, obstacles grown by 2 cm",
        "the path misses every obstacle; where a path of some width exists, one is found with probability 1 in the long run",
        "no time, no tube, no controller: what follows the path must be designed and proved apart; never says that there is none",
        partial(plan, rrt_connect),
    ),
    Peer(
        "OMPL RRT*, first solution",
        "a path from the start's centre to the target, obstacles grown by 2 cm",
        "as RRTConnect; left to run, its path tends to the shortest",
        "as RRTConnect; stopped at the first solution, the path is not short",
        partial(plan, rrt_star),
    ),
    Peer(
        "A* (pyastar2d), 101 x 101",
        "a path over grid points, obstacles grown by half a cell",
        "the path misses every obstacle and has the fewest steps on this grid; says when this grid has none",
        "no time, no tube, no controller; passages narrower than two cells may be missed; the grid grows exponentially",
        partial(plan, a_star),
    ),
    Peer(
        "hj-reachability, 101 x 101",
        "from where xdot = u with |u_i| <= 1 reaches the target within 9 s and avoids the obstacles",
        "a feedback for every state at once; the values tend to the true ones as the grid is refined",
        "no bound on the error of this grid; needs the model; a table of 10,201 values a time for the robot; exponential growth",
        reach_avoid_tube,
        sample=100,
    ),
    Peer(
        "barrier filter (OSQP's generated C)",
        "the input nearest to a go-to-goal law that keeps every barrier, at every step",
        "safe in continuous time while the program has a solution and xdot = u is the true model",
        "no promise to arrive, let alone in time: it may stand still in a corner for ever; an iterative solver in every step",
        barrier_filter,
        sample=100,
        per="step",
    ),
)
