"""The peers of `python -m benchmarks loop --peers`: each drives in the same arenas, from the same starts, under the same winds as
ours.

A contender is prepared for an arena in which our loop already runs: the sets of our loop decide about collisions, and "outward"
winds blow away from the middle of our tube. CONTENDERS states what each guarantees, and what it does better than ours.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.peers.barrier import filter_library
from benchmarks.peers.driven import compile_peer, seconds_a_step
from benchmarks.peers.funnels import funnel
from benchmarks.peers.policy import DECISIONS_PER_SECOND, Policy, load_policy
from benchmarks.peers.predictive import predictive
from benchmarks.peers.symbolic import Abstraction, synthesize
from benchmarks.suites.families import BOX, FAMILIES, Array, Family, arena_task, cubes
from stt_codegen.errors import NotCertified
from stt_codegen.loop.command import with_disturbance_bound
from stt_codegen.loop.compiled import LoadedController, load_controller
from stt_codegen.loop.simulate import Loop, Run, Scenario, random_start
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.plants import PLANTS

FAMILY = FAMILIES["paper"]
POLICIES = Path("build/policies")  # where `make policies` puts them
W_MAX = 0.3  # of the winds in `run_policy`
SLOW_PEER_ARENAS = 100  # for contenders that take long
DISTURBANCES = ("none", "constant", "constant", "sinusoidal", "sinusoidal", "random", "nearest", "nearest", "outward", "outward")


class PreparedLoop(NamedTuple):
    """A contender's loop in an arena, and the runs it shall make."""

    loop: Loop
    scenarios: Sequence[Scenario]


@dataclass(frozen=True)
class LoopArena:
    """An arena by its seed, with our loop in it, and the runs that every contender makes under winds of at most w_max."""

    seed: int
    w_max: float
    loop: Loop
    scenarios: Sequence[Scenario]

    @property
    def squares(self) -> Array:
        """The unsafe squares, (count, 2, 2)."""
        return cubes(FAMILY, self.seed)

    @property
    def tube(self) -> Callable[..., object]:
        """`loop_own_tube` of our loop, by whose edges margins are measured."""
        edges: Callable[..., object] = self.loop.loaded.tube
        return edges

    def prepare(self, controller: LoadedController | None) -> PreparedLoop | None:
        """Put a controller in the place of ours; None without one."""
        if controller is None:
            return None
        return PreparedLoop(Loop(self.loop.controller, self.loop.plant, controller), self.scenarios)


@dataclass(frozen=True)
class Contender:
    """A peer that drives. prepare: returns None where it has no controller for an arena.

    advantages: what it does better than ours; arena_limit: at most so many arenas, since it is slow; has_tube: whether margins
    are of its tube, not of ours; period: seconds between its decisions."""

    name: str
    prepare: Callable[[LoopArena], PreparedLoop | None]
    guarantees: str
    advantages: str
    arena_limit: int | None = None
    has_tube: bool = False
    period: float = 1 / DECISIONS_PER_SECOND


# ------------------------------------------------------------------------------------------------ a function for each contender


def _prepare_barrier(knows_w_max: bool, arena: LoopArena) -> PreparedLoop | None:
    library, edges = filter_library(FAMILY.count, FAMILY.dimension, FAMILY.side), np.ascontiguousarray(arena.squares)
    allowed = ctypes.c_double(arena.w_max if knows_w_max else 0.0)
    start = partial(_set_boxes, library, edges, allowed)
    return arena.prepare(LoadedController(step=library.filter_next, tube=arena.tube, advance=None, start=start, library=library))


def _set_boxes(library: ctypes.CDLL, edges: Array, allowed: ctypes.c_double) -> None:
    """Write the arena's boxes, and the |w| that the filter allows for, into the filter's library."""
    library.filter_boxes(ctypes.c_void_p(edges.ctypes.data), allowed)


def _prepare_tube(design: str, arena: LoopArena, *, uncertified: bool = False) -> PreparedLoop | None:
    """Prepare another design of the same task with our gain, from the starts nearest to ours that are inside its gamma(0)."""
    task = arena.loop.controller.task.with_options(design)
    try:
        loop = Loop(build_task(task, uncertified=uncertified), arena.loop.plant)
    except NotCertified:
        return None
    return PreparedLoop(loop, [_with_start_inside(s, loop.controller) for s in arena.scenarios])


def _with_start_inside(scenario: Scenario, controller: EmittedController) -> Scenario:
    """Move the start of a run into gamma(0) of a controller, 5 % of the width away from its edges."""
    if scenario.start is None:
        return scenario
    inside = [
        min(max(x, float(a) + 0.05 * float(b - a)), float(b) - 0.05 * float(b - a))
        for x, (a, b) in zip(scenario.start, controller.certificate.start, strict=True)
    ]
    return replace(scenario, start=tuple(inside))


def _prepare_funnel(arena: LoopArena) -> PreparedLoop | None:
    return arena.prepare(funnel(FAMILY, arena.squares, arena.tube))


def _prepare_predictive(with_tube: bool, arena: LoopArena) -> PreparedLoop | None:
    return arena.prepare(predictive(FAMILY, arena.squares, arena.tube, with_tube))


def _prepare_grid(abstraction: Abstraction, arena: LoopArena) -> PreparedLoop | None:
    controller = synthesize(FAMILY, arena.squares, abstraction)
    if not controller.is_winning:
        return None
    return arena.prepare(compile_peer(controller.source(), 2, float(1 / abstraction.period), arena.tube))


def _prepare_policy(path: Path, arena: LoopArena) -> PreparedLoop | None:
    return arena.prepare(compile_peer(_cached_policy(path).source(arena.squares), 2, DECISIONS_PER_SECOND, arena.tube))


@cache
def _cached_policy(path: Path) -> Policy:
    return load_policy(path)


def run_policy(policy: Policy, family: Family, seed: int) -> tuple[tuple[Run, ...], float]:
    """Run a policy alone in an arena, certified or not: ten runs from the initial set, and seconds a decision."""
    task = arena_task(family, seed).with_options("literal")
    controller = build_task(task, uncertified=True)  # gives the sets, and the tube from whose middle "outward" winds blow
    plant = with_disturbance_bound(PLANTS["integrator"], W_MAX)
    edges = load_controller(controller).tube
    loop = Loop(controller, plant, compile_peer(policy.source(cubes(family, seed)), 2, DECISIONS_PER_SECOND, edges))
    box = [(Fraction(0), Fraction(BOX))] * 2
    runs = [
        loop.run(
            Scenario(
                rate=1000.0, disturbance=kind, strength=0.0 if kind == "none" else W_MAX, seed=1000 * seed + k,
                start=random_start(box, 0.9, 1000 * seed + k, corner=k % 2 == 1) if k else None,
            )
        )
        for k, kind in enumerate(DISTURBANCES)
    ]  # fmt: skip
    rows = np.array([[0.05 * k, 4.5 * k / 180 + 0.25, 4.5 * k / 180 + 0.25] for k in range(180)])
    return tuple(runs), seconds_a_step(loop.loaded, rows)


# ------------------------------------------------------------------------------------------------ the contenders


def _speeds(*values: str) -> tuple[Fraction, ...]:
    return tuple(map(Fraction, values))


SEVEN_SPEEDS = _speeds("-3/2", "-1", "-1/2", "0", "1/2", "1", "3/2")
THREE_SPEEDS = _speeds("-3/2", "0", "3/2")
GRIDS = {
    "50 x 50": Abstraction(50, Fraction(1, 4), SEVEN_SPEEDS),
    "100 x 100": Abstraction(100, Fraction(1, 8), THREE_SPEEDS),
    "200 x 200": Abstraction(200, Fraction(1, 16), THREE_SPEEDS),
    "100 x 100, swept": Abstraction(100, Fraction(1, 8), THREE_SPEEDS, is_swept=True),
}
ROBOT = Abstraction(100, Fraction(1, 5), _speeds("-2", "-1", "-1/2", "0", "1/2", "1", "2"), headings=72)

FILTER_GUARANTEE = "safe in continuous time while its program has a solution and the model is true; no promise to arrive"
GRID_GUARANTEE = (
    "in the target in time and outside the unsafe sets at its samples, for every |w_i| <= 0.3, if xdot = u + w is true"
)
CONTENDERS = (
    Contender(
        "barrier filter", partial(_prepare_barrier, False), FILTER_GUARANTEE,
        "takes any controller, avoids sets that are known only at run time, needs no design, has a limit of u in its program",
    ),
    Contender(
        "barrier filter told w_max", partial(_prepare_barrier, True), FILTER_GUARANTEE + ", with |w| <= w_max",
        "as above",
    ),
    Contender(
        "literal tube (the paper's)", partial(_prepare_tube, "literal", uncertified=True),
        "the paper's Theorem, whose printed rule meets unsafe sets",
        "its design is a formula: no search, no program", has_tube=True,
    ),
    Contender(
        "adaptive tube (the paper's functions, mended; alpha as in [16])", partial(_prepare_tube, "adaptive"),
        "ours, for every dt of alpha_step from DT_SHORTEST to DT_LONGEST",
        "closed form in t and alpha: no table",
        arena_limit=SLOW_PEER_ARENAS, has_tube=True,
    ),
    Contender(
        "prescribed performance about an A* way [11, 12]", _prepare_funnel,
        "|x_i - x_d,i| < rho(t) for unknown f and g in continuous time; the way must keep the funnel out of unsafe sets",
        "needs only a way: no linear program, no table but the way's turns; bounds on how fast an error decays",
    ),
    Contender(
        "predictive control, our tube as reference", partial(_prepare_predictive, True),
        "none with slacks: OSQP promises a minimum of its program, which is about a model",
        "has limits of u in its program, and takes the least effort",
        arena_limit=SLOW_PEER_ARENAS,
    ),
    Contender(
        "predictive control, to the goal", partial(_prepare_predictive, False),
        "none: the program is a convex guess of one that is not", "needs no design, takes sets that are known at run time",
        arena_limit=SLOW_PEER_ARENAS,
    ),
    *(
        Contender(
            f"symbolic control, {name}", partial(_prepare_grid, GRIDS[name]),
            GRID_GUARANTEE if not GRIDS[name].is_swept else GRID_GUARANTEE.replace("at its samples", "at all times"),
            "a feedback from every state that has one, not from a tube; any input set; says when its grid has none",
            arena_limit=SLOW_PEER_ARENAS,
            period=float(GRIDS[name].period),
        )
        for name in GRIDS
    ),
)  # fmt: skip


def all_contenders(policies: Path = POLICIES) -> tuple[Contender, ...]:
    """Return CONTENDERS, and one for every trained policy in the folder."""
    paths = sorted(policies.glob("policy_*.npz"))
    learned = (
        Contender(
            f"reinforcement learning (PPO), seed {path.stem.removeprefix('policy_')}", partial(_prepare_policy, path), "none",
            "one policy for all arenas: nothing is designed for a new one; takes any sensor and any reward",
        )
        for path in paths
    )  # fmt: skip
    return (*CONTENDERS, *learned)
