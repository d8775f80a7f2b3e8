"""The peers of `python -m benchmarks arenas --peers`: planners, a reachability solver, a safety filter and others, on the same
random arenas as ours.

Each peer answers a question of its kind (`Peer.question`). None answers ours, for a proved tube with the controller that keeps an
unknown system inside it. So the tables state, beside time and success, what each guarantees and what it lacks.

Every peer gets settings that are good for it, on one thread: OMPL an exact check of motions (in Python, like the problem) in
place of samples along them, hj-reachability its quickest scheme, OSQP no scaling and a test of convergence at every iteration (a
sixth of the time that its defaults take). Imports, compilation and a first problem are not timed. The peers are optional; a
missing one raises `MissingTool`.

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
from typing import Any, NamedTuple

import numpy as np

from benchmarks.peers.barrier import SPEED, run_closed_loops
from benchmarks.peers.freeways import curve_is_safe, drake, fast_path
from benchmarks.peers.funnels import grid_way
from benchmarks.peers.in_loops import GRID_GUARANTEE, GRIDS, POLICIES, ROBOT, run_policy
from benchmarks.peers.optional import need
from benchmarks.peers.policy import load_policy
from benchmarks.peers.symbolic import Abstraction, synthesize
from benchmarks.suites.families import BOX, Array, Family, cubes
from stt_codegen.errors import BadInput
from stt_codegen.loop.simulate import Run

MARGIN = 0.02  # by which OMPL's obstacles grow
CELLS = 100  # of the grids, by dimension
OMPL_SEED = 1  # set again before each problem, so that a path does not depend on earlier problems
PLANNER_SECONDS = 1.0  # after which a random planner stops


@dataclass(frozen=True)
class PeerOutcome:
    """How one peer did on one arena. seconds: of what `Peer.timed` says; note: why it failed; runs: of a policy."""

    success: bool
    seconds: float
    note: str = ""
    runs: tuple[Run, ...] = ()


@dataclass(frozen=True)
class Peer:
    """A peer, the question that it answers, and what its answer is worth.

    run: takes a family and a seed; arena_limit: at most so many arenas, since it is slow; timed: "problem" or "step"."""

    name: str
    question: str
    guarantees: str
    lacks: str
    run: Callable[[Family, int], PeerOutcome]
    arena_limit: int | None = None
    timed: str = "problem"


Planner = Callable[[Family, Array], Array | None]  # family, boxes -> a path, shape (points, dimension), if it finds one


def try_path_planner(planner: Planner, family: Family, seed: int) -> PeerOutcome:
    """Run a planner of paths on one arena. A path counts only when `path_is_safe` says so."""
    return _try_planner(planner, family, seed, "path", path_is_safe)


def try_curve_planner(planner: Callable[[Family, Array], list[Array] | None], family: Family, seed: int) -> PeerOutcome:
    """Run a planner of curves over free boxes on one arena. A curve counts only when `curve_is_safe` says so."""
    return _try_planner(planner, family, seed, "curve", curve_is_safe)


def _try_planner(
    planner: Callable[[Family, Array], Any], family: Family, seed: int, noun: str, is_safe: Callable[..., bool]
) -> PeerOutcome:
    """Run and time a planner on one arena, after a first problem that is not timed. noun: of its result, for the note."""
    _warm_up(planner, family)
    boxes, begin = cubes(family, seed), time.perf_counter()
    result = planner(family, boxes)
    seconds = time.perf_counter() - begin
    note = f"no {noun} found" if result is None else "" if is_safe(family, boxes, result) else f"its {noun} is not safe"
    return PeerOutcome(not note, seconds, note)


@cache
def _warm_up(planner: Callable[[Family, Array], Any], family: Family) -> None:
    planner(family, cubes(family, 0))


def path_is_safe(family: Family, boxes: Array, path: Array) -> bool:
    """Whether the path's straight segments lead from the start's box to the target's, inside the state space, through no open
    box. The answer is exact."""
    points = [[Fraction(float(v)) for v in point] for point in path]
    is_inside = all(0 <= v <= family.side for point in points for v in point)
    joins_boxes = max(points[0]) <= BOX and min(points[-1]) >= family.side - BOX
    edges = [[(Fraction(float(low)), Fraction(float(high))) for low, high in box] for box in boxes]
    return is_inside and joins_boxes and not any(_meets(p, q, box) for p, q in pairwise(points) for box in edges)


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
    """Plan with OMPL's RRTConnect: two random trees that grow towards each other."""
    return _ompl_path(family, boxes, "RRTConnect")


def rrt_star(family: Family, boxes: Array) -> Array | None:
    """Plan with OMPL's RRT*, stopped at its first solution."""
    return _ompl_path(family, boxes, "RRTstar")


def _ompl_path(family: Family, boxes: Array, planner_name: str) -> Array | None:
    """Plan with a planner of OMPL from the start's centre to the target, with an exact check of motions. Returns points, or
    None."""
    ompl = _ompl()
    base = ompl.base
    ompl.util.RNG.setSeed(OMPL_SEED)
    axes = range(family.dimension)
    space = base.RealVectorStateSpace(family.dimension)
    space.setBounds(0.0, family.side)
    info = base.SpaceInformation(space)
    motions = ompl.motion_validator(info)
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
    planner = getattr(ompl.geometric, planner_name)(info)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(PLANNER_SECONDS)
    if not problem.hasExactSolution():
        return None
    return np.array([[state[i] for i in axes] for state in problem.getSolutionPath().getStates()])


class _Ompl(NamedTuple):
    """Modules of OMPL, and a class of exact validators of motions."""

    base: Any
    geometric: Any
    util: Any
    motion_validator: Any


@cache
def _ompl() -> _Ompl:
    """Import OMPL and define the class of validators. Raises `MissingTool`."""
    base, geometric, util = need("ompl.base"), need("ompl.geometric"), need("ompl.util")
    util.setLogLevel(util.LogLevel.LOG_NONE)  # else it warns that a second seed does not change older planners

    def check_motion(self: Any, first: Any, last: Any) -> bool:
        axes = range(len(self.boxes[0]))
        p, q = [first[i] for i in axes], [last[i] for i in axes]
        return not any(_meets(p, q, box) for box in self.boxes)

    return _Ompl(base, geometric, util, type("Motions", (base.MotionValidator,), {"checkMotion": check_motion}))


def a_star(family: Family, boxes: Array) -> Array | None:
    """Plan with pyastar2d's A* over grid points. Raises `BadInput` beyond the plane."""
    return grid_way(family, boxes, len(_grid_points(family)) - 1)


def try_grid(abstraction: Abstraction, family: Family, seed: int) -> PeerOutcome:
    """Synthesize a controller over a grid. Success: from every state of the start's box it is in the target within 9 s, whatever
    the wind."""
    controller = synthesize(family, cubes(family, seed), abstraction)
    return PeerOutcome(controller.is_winning, controller.seconds)


def try_policy(path: Path, family: Family, seed: int) -> PeerOutcome:
    """Run a trained policy. Success: all of ten runs, under the winds of `python -m benchmarks loop`, arrive and meet nothing.
    seconds: of a decision."""
    runs, seconds = run_policy(load_policy(path), family, seed)
    return PeerOutcome(all(r.good for r in runs), seconds, runs=runs)


def _grid_points(family: Family) -> Array:
    """Return the coordinates of the grid points along one axis. Raises `BadInput` beyond the plane."""
    if family.dimension != 2:
        raise BadInput(f"family {family.name}: has {family.dimension} dimensions; this peer runs on arenas of 2")
    return np.linspace(0.0, family.side, CELLS + 1)


def reach_avoid_tube(family: Family, seed: int) -> PeerOutcome:
    """Solve the reach-avoid problem of an arena. Success: the value at the start's centre says that xdot = u, |u_i| <= SPEED, can
    reach the target within 9 s."""
    axis, solve, boxes = _grid_points(family), _reach_avoid_solver(family), cubes(family, seed)
    begin = time.perf_counter()
    states = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1)

    def distance_to(box: Array) -> Any:
        """Return distances of all states to a box in the largest component, negative inside."""
        return np.max(np.maximum(box[:, 0] - states, states - box[:, 1]), axis=-1)

    target, space = (distance_to(np.array([[low, family.side]] * 2)) for low in (family.side - BOX, 0.0))
    avoid = np.max([space, *(-distance_to(box) for box in boxes)], axis=0)
    value = np.asarray(solve(target, avoid))
    seconds = time.perf_counter() - begin
    centre = int(np.argmin(abs(axis - BOX / 2)))
    return PeerOutcome(bool(value[centre, centre] < 0), seconds)


@cache
def _reach_avoid_solver(family: Family) -> Callable[[Array, Array], Any]:
    """Return a function of two fields on the grid, target and avoid, that gives the value. It is compiled once for all arenas of
    a family, since both fields are its arguments."""
    for setting in ("JAX_PLATFORMS=cpu", "NPROC=1", "XLA_FLAGS=--xla_cpu_multi_thread_eigen=false"):
        os.environ.setdefault(*setting.split("=", 1))  # for one thread; jax reads them when it is first imported
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


def barrier_filter(family: Family, seed: int) -> PeerOutcome:
    """Run the barrier filter. Success: the filtered go-to-goal law ends in the target after 9 s and no step lies in a box.
    seconds: of a step."""
    loop = run_closed_loops(family, seed)["cbf"]
    note = "collides" if loop.collided else "" if loop.reached else "not at the target in time"
    return PeerOutcome(not note, loop.step_seconds, note)


PEERS = (
    Peer(
        "OMPL RRTConnect",
        "a path from the start's centre to the target's, obstacles grown by 2 cm",
        "the path misses every obstacle; where a path of some width exists, one is found with probability 1 in the long run",
        "no time, no tube, no controller: what follows the path must be designed and proved apart; never says that none exists",
        partial(try_path_planner, rrt_connect),
    ),
    Peer(
        "OMPL RRT*, first solution",
        "a path from the start's centre to the target, obstacles grown by 2 cm",
        "as RRTConnect; left to run, its path tends to the shortest",
        "as RRTConnect; stopped at the first solution, the path is not short",
        partial(try_path_planner, rrt_star),
    ),
    Peer(
        "A* (pyastar2d), 101 x 101",
        "a path over grid points, obstacles grown by half a cell",
        "the path misses every obstacle and has the fewest steps on this grid; says when this grid has none",
        "no time, no tube, no controller; passages narrower than two cells may be missed; the grid grows exponentially",
        partial(try_path_planner, a_star),
    ),
    Peer(
        "hj-reachability, 101 x 101",
        "from where xdot = u with |u_i| <= 1 reaches the target within 9 s and avoids the obstacles",
        "a feedback for every state at once; the values tend to the true ones as the grid is refined",
        "no bound on the error of this grid; needs the model; a table of 10,201 values a time for the robot; exponential growth",
        reach_avoid_tube,
        arena_limit=100,
    ),
    Peer(
        "barrier filter (OSQP's generated C)",
        "the input nearest to a go-to-goal law that keeps every barrier, at every step",
        "safe in continuous time while the program has a solution and xdot = u is the true model",
        "no promise to arrive, let alone in time: it may stand still in a corner for ever; an iterative solver in every step",
        barrier_filter,
        arena_limit=100,
        timed="step",
    ),
    Peer(
        "Drake GcsTrajectoryOptimization (Clarabel)",
        "a curve of pieces of order 5, twice differentiable, through free boxes, obstacles grown by 2 cm",
        "its curve misses every obstacle at all times; a bound on how far it is from the shortest; rounding may fail",
        "no tube, no controller, no wind, and no time prescribed over all of the way",
        partial(try_curve_planner, drake),
        arena_limit=100,
    ),
    Peer(
        "fastpathplanning (Clarabel)",
        "a curve of pieces of order 5 in 9 s, least squared acceleration, through free boxes, obstacles grown by 2 cm",
        "its curve misses every obstacle at all times, and takes the time that is prescribed; says where there is none",
        "no tube, no controller, no wind; the nearest neighbour of what is designed here",
        partial(try_curve_planner, fast_path),
        arena_limit=100,
    ),
    *(
        Peer(
            f"symbolic control, {name}",
            "a feedback for the state space, |u_i| <= 1.5, |w_i| <= 0.3; success: the whole start's box is in the target in 9 s",
            GRID_GUARANTEE if not GRIDS[name].is_swept else GRID_GUARANTEE.replace("at its samples", "at all times"),
            "needs the model; grows exponentially with the dimension; misses passages of about two reachable boxes",
            partial(try_grid, GRIDS[name]),
            arena_limit=50 if name.startswith("200") else None,
        )
        for name in GRIDS
    ),
    Peer(
        "symbolic control, the robot of three states, 100 x 100 x 72",
        "the same for equation (14), |v_i| <= 2, at every heading",
        GRID_GUARANTEE.replace("xdot = u + w", "(14)"),
        "as above",
        partial(try_grid, ROBOT),
        arena_limit=4,
    ),
)


def _policy_peer(path: Path) -> Peer:
    """Return the peer of a trained policy."""
    return Peer(
        f"reinforcement learning (PPO), seed {path.stem.removeprefix('policy_')}",
        "all of ten runs in the target at 9 s, no obstacle met, |u_i| <= 1, winds of at most 0.3; one policy for all arenas",
        "none",
        "only runs show whether it works; trained for long on the arenas and winds that it will meet",
        partial(try_policy, path),
        timed="step",
    )


def all_peers(policies: Path = POLICIES) -> tuple[Peer, ...]:
    """Return PEERS, and one for every trained policy in the folder."""
    return (*PEERS, *map(_policy_peer, sorted(policies.glob("policy_*.npz"))))
