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

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers.barrier import SPEED, closed_loops
from benchmarks.peers.freeways import curve_is_safe, drake, fast_path
from benchmarks.peers.funnels import grid_way
from benchmarks.peers.in_loops import GRIDS, POLICIES, ROBOT, SAMPLED, drive
from benchmarks.peers.optional import need
from benchmarks.peers.policy import load_policy
from benchmarks.peers.symbolic import Abstraction, synthesize
from benchmarks.suites.families import BOX, Array, Family, cubes
from stt_codegen.errors import BadInput
from stt_codegen.loop.simulate import Run

MARGIN = 0.02  # by which OMPL's obstacles grow
CELLS = 100  # of the grids, by dimension
SEED = 1  # of OMPL's random numbers, for each problem anew: the path does not depend on the problems before
GIVE_UP = 1.0  # seconds after which a random planner stops


@dataclass(frozen=True)
class Outcome:
    """One peer on one arena: seconds are for what `Peer.per` says; the runs of one that is tried."""

    success: bool
    seconds: float
    note: str = ""
    runs: tuple[Run, ...] = ()


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


Planner = Callable[[Family, Array], Array | None]  # family, boxes -> a path, shape (points, dimension), if it finds one


def plan(planner: Planner, family: Family, seed: int) -> Outcome:
    """A planner of paths on one arena; a path counts only when it is safe by our own check."""
    return _asked(planner, family, seed, "path", path_is_safe)


def curve(planner: Callable[[Family, Array], list[Array] | None], family: Family, seed: int) -> Outcome:
    """A planner of curves over free boxes, as `plan`."""
    return _asked(planner, family, seed, "curve", curve_is_safe)


def _asked(planner: Callable[[Family, Array], Any], family: Family, seed: int, what: str, safe: Callable[..., bool]) -> Outcome:
    _warm(planner, family)
    boxes, begin = cubes(family, seed), time.perf_counter()
    found = planner(family, boxes)
    seconds = time.perf_counter() - begin
    note = f"no {what} found" if found is None else "" if safe(family, boxes, found) else f"its {what} is not safe"
    return Outcome(not note, seconds, note)


@cache
def _warm(planner: Callable[[Family, Array], Any], family: Family) -> None:
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
    """pyastar2d's A* over grid points. Raises `BadInput` beyond the plane."""
    return grid_way(family, boxes, len(_axis(family)) - 1)


def symbolic(abstraction: Abstraction, family: Family, seed: int) -> Outcome:
    """Success: from every state of the start's box, in the target within 9 s whatever the wind."""
    made = synthesize(family, cubes(family, seed), abstraction)
    return Outcome(made.wins, made.seconds)


def learned(path: Path, family: Family, seed: int) -> Outcome:
    """Success: all of ten runs, under the winds of `python -m benchmarks loop`, arrive and meet nothing; seconds are for a
    decision."""
    runs, seconds = drive(load_policy(path), family, seed)
    return Outcome(all(r.good for r in runs), seconds, runs=runs)


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
        "open_loop_dynamics": lambda *_: jnp.zeros(2),
        "control_jacobian": lambda *_: jnp.eye(2),
        "disturbance_jacobian": lambda *_: jnp.zeros((2, 2)),
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


def barrier_filter(family: Family, seed: int) -> Outcome:
    """Success: the filtered go-to-goal law ends in the target after 9 s and no step lies in a box; seconds are for a step."""
    loop = closed_loops(family, seed)["cbf"]
    note = "collides" if loop.collided else "" if loop.reached else "not at the target in time"
    return Outcome(not note, loop.seconds, note)


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
    Peer(
        "Drake GcsTrajectoryOptimization (Clarabel)",
        "a curve of pieces of order 5, twice differentiable, through free boxes, obstacles grown by 2 cm",
        "its curve misses every obstacle at all times; a bound on how far it is from the shortest; rounding may fail",
        "no tube, no controller, no wind, and no time prescribed over all of the way",
        partial(curve, drake),
        sample=100,
    ),
    Peer(
        "fastpathplanning (Clarabel)",
        "a curve of pieces of order 5 in 9 s, least squared acceleration, through free boxes, obstacles grown by 2 cm",
        "its curve misses every obstacle at all times, and takes the time that is prescribed; says where there is none",
        "no tube, no controller, no wind; the nearest neighbour of what is designed here",
        partial(curve, fast_path),
        sample=100,
    ),
    *(
        Peer(
            f"symbolic control, {name}",
            "a feedback for the room, |u_i| <= 1.5, |w_i| <= 0.3; success: the whole start's box is in the target in 9 s",
            SAMPLED if not GRIDS[name].swept else SAMPLED.replace("at its samples", "at all times"),
            "needs the model; grows exponentially with the dimension; misses passages of about two reachable boxes",
            partial(symbolic, GRIDS[name]),
            sample=50 if name.startswith("200") else None,
        )
        for name in GRIDS
    ),
    Peer(
        "symbolic control, the robot of three states, 100 x 100 x 72",
        "the same for equation (14), |v_i| <= 2, at every heading",
        SAMPLED.replace("xdot = u + w", "(14)"),
        "as above",
        partial(symbolic, ROBOT),
        sample=4,
    ),
)


def _policy(path: Path) -> Peer:
    return Peer(
        f"reinforcement learning (PPO), seed {path.stem.removeprefix('policy_')}",
        "all of ten runs in the target at 9 s, no obstacle met, |u_i| <= 1, winds of at most 0.3; one policy for all arenas",
        "none",
        "whoever wants to know must try; trained for long on what it will meet",
        partial(learned, path),
        per="step",
    )


def all_peers(policies: Path = POLICIES) -> tuple[Peer, ...]:
    """PEERS, and a row for every policy that has been trained."""
    return (*PEERS, *map(_policy, sorted(policies.glob("policy_*.npz"))))
