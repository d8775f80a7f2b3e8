"""Who else drives in `python -m benchmarks loop --peers`: each in the same arenas, from the same starts, under the same winds as
ours.

A contender is made for an arena, with our loop there at hand: its sets judge, and by its tube "outward" winds are blown.
What each guarantees, and what it does better than ours, stands beside it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from pathlib import Path

import numpy as np

from benchmarks.peers.barrier import filter_library
from benchmarks.peers.driven import held, seconds_a_step
from benchmarks.peers.funnels import funnel
from benchmarks.peers.policy import HERTZ, Policy, load_policy
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
W_MAX = 0.3  # of the winds that a policy is tried under
FEW = 100  # arenas of those that take long
DISTURBANCES = ("none", "constant", "constant", "sinusoidal", "sinusoidal", "random", "nearest", "nearest", "outward", "outward")
Ready = tuple[Loop, Sequence[Scenario]]


@dataclass(frozen=True)
class Ground:
    """An arena with our loop in it, and the runs that are asked for."""

    seed: int
    w_max: float
    loop: Loop
    scenarios: Sequence[Scenario]

    @property
    def squares(self) -> Array:
        return cubes(FAMILY, self.seed)

    @property
    def tube(self) -> Callable[..., object]:
        """`loop_own_tube` of ours."""
        found: Callable[..., object] = self.loop.loaded.tube
        return found

    def with_step(self, other: LoadedController | None) -> Ready | None:
        return None if other is None else (Loop(self.loop.controller, self.loop.plant, other), self.scenarios)


@dataclass(frozen=True)
class Contender:
    """make: None where it finds nothing to drive by in an arena. first: it is run in so many arenas; tube: margins are its own;
    period: seconds between its decisions, of one that holds its input longer than a sample."""

    name: str
    make: Callable[[Ground], Ready | None]
    guarantees: str
    better: str
    first: int | None = None
    tube: bool = False
    period: float = 1 / HERTZ


# ------------------------------------------------------------------------------------------------ how each is made


def _barrier(told: bool, ground: Ground) -> Ready | None:
    library, edges = filter_library(FAMILY.count, FAMILY.dimension, FAMILY.side), np.ascontiguousarray(ground.squares)
    allowed = ctypes.c_double(ground.w_max if told else 0.0)
    refill = partial(_refill, library, edges, allowed)
    return ground.with_step(
        LoadedController(step=library.filter_next, tube=ground.tube, advance=None, start=refill, library=library)
    )


def _refill(library: ctypes.CDLL, edges: Array, allowed: ctypes.c_double) -> None:
    library.filter_boxes(ctypes.c_void_p(edges.ctypes.data), allowed)


def _tube(design: str, ground: Ground, *, uncertified: bool = False) -> Ready | None:
    """Another design of the same task with our gain, from starts as near to the same as its own gamma(0) allows."""
    task = ground.loop.controller.task.with_options(design)
    try:
        loop = Loop(build_task(task, uncertified=uncertified), ground.loop.plant)
    except NotCertified:
        return None
    return loop, [_moved(s, loop.controller) for s in ground.scenarios]


def _moved(scenario: Scenario, controller: EmittedController) -> Scenario:
    if scenario.start is None:
        return scenario
    inside = [
        min(max(x, float(a) + 0.05 * float(b - a)), float(b) - 0.05 * float(b - a))
        for x, (a, b) in zip(scenario.start, controller.certificate.start, strict=True)
    ]
    return replace(scenario, start=tuple(inside))


def _funnel(ground: Ground) -> Ready | None:
    return ground.with_step(funnel(FAMILY, ground.squares, ground.tube))


def _predictive(with_tube: bool, ground: Ground) -> Ready | None:
    return ground.with_step(predictive(FAMILY, ground.squares, ground.tube, with_tube))


def _grid(abstraction: Abstraction, ground: Ground) -> Ready | None:
    made = synthesize(FAMILY, ground.squares, abstraction)
    return ground.with_step(held(made.source(), 2, float(1 / abstraction.period), ground.tube)) if made.wins else None


def _policy(path: Path, ground: Ground) -> Ready | None:
    return ground.with_step(held(_loaded(path).source(ground.squares), 2, HERTZ, ground.tube))


@cache
def _loaded(path: Path) -> Policy:
    return load_policy(path)


def drive(policy: Policy, family: Family, seed: int) -> tuple[tuple[Run, ...], float]:
    """A policy alone in an arena, certified or not: ten runs from the whole initial set, and seconds a decision."""
    task = arena_task(family, seed).with_options("literal")
    frame = build_task(task, uncertified=True)  # for its sets; "outward" is from its tube's middle
    plant = with_disturbance_bound(PLANTS["integrator"], W_MAX)
    edges = load_controller(frame).tube
    loop = Loop(frame, plant, held(policy.source(cubes(family, seed)), 2, HERTZ, edges))
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


# ------------------------------------------------------------------------------------------------ who


def _speeds(*values: str) -> tuple[Fraction, ...]:
    return tuple(map(Fraction, values))


SEVEN = _speeds("-3/2", "-1", "-1/2", "0", "1/2", "1", "3/2")
THREE = _speeds("-3/2", "0", "3/2")
GRIDS = {
    "50 x 50": Abstraction(50, Fraction(1, 4), SEVEN),
    "100 x 100": Abstraction(100, Fraction(1, 8), THREE),
    "200 x 200": Abstraction(200, Fraction(1, 16), THREE),
    "100 x 100, swept": Abstraction(100, Fraction(1, 8), THREE, swept=True),
}
ROBOT = Abstraction(100, Fraction(1, 5), _speeds("-2", "-1", "-1/2", "0", "1/2", "1", "2"), headings=72)

FILTERED = "safe in continuous time while its program has a solution and the model is true; arrives by no promise"
SAMPLED = "in the target in time and off the unsafe sets at its samples, for every |w_i| <= 0.3, if xdot = u + w is true"
CONTENDERS = (
    Contender(
        "barrier filter", partial(_barrier, False), FILTERED,
        "takes any controller, keeps sets that are told only at run time, needs no design, minds a limit of u in its program",
    ),
    Contender(
        "barrier filter told w_max", partial(_barrier, True), FILTERED + ", with |w| <= w_max",
        "as above",
    ),
    Contender(
        "literal tube (the paper's)", partial(_tube, "literal", uncertified=True),
        "the paper's Theorem, whose printed rule meets unsafe sets",
        "its design is a formula: no search, no program", tube=True,
    ),
    Contender(
        "adaptive tube (the paper's functions, mended; alpha as in [16])", partial(_tube, "adaptive"),
        "ours, for every dt of alpha_step from DT_SHORTEST to DT_LONGEST",
        "closed form in t and alpha: no table", FEW, True,
    ),
    Contender(
        "prescribed performance about an A* way [11, 12]", _funnel,
        "|x_i - x_d,i| < rho(t) for unknown f and g in continuous time; that the funnel meets no unsafe set is the way's affair",
        "a way is all it needs: no linear program, no table but the way's turns; bounds on how fast an error decays",
    ),
    Contender(
        "predictive control, our tube as reference", partial(_predictive, True),
        "none with slacks: OSQP promises a minimum of its program, of a model",
        "minds limits of u, and takes the least effort", FEW,
    ),
    Contender(
        "predictive control, to the goal", partial(_predictive, False),
        "none: the program is a convex guess of one that is not", "needs no design, takes sets that are told at run time", FEW,
    ),
    *(
        Contender(
            f"symbolic control, {name}", partial(_grid, GRIDS[name]),
            SAMPLED if not GRIDS[name].swept else SAMPLED.replace("at its samples", "at all times"),
            "a feedback from every state that has one, not from a tube; any input set; says when its grid has none", FEW,
            period=float(GRIDS[name].period),
        )
        for name in GRIDS
    ),
)  # fmt: skip


def contenders(policies: Path = POLICIES) -> tuple[Contender, ...]:
    """All, with every policy that has been trained."""
    found = sorted(policies.glob("policy_*.npz"))
    learned = (
        Contender(
            f"reinforcement learning (PPO), seed {path.stem.removeprefix('policy_')}", partial(_policy, path), "none",
            "one policy for all arenas: nothing is designed for a new one; takes any sensor and any reward",
        )
        for path in found
    )  # fmt: skip
    return (*CONTENDERS, *learned)
