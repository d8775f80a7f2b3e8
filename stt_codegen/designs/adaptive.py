"""What an adaptive or literal design is: the numbers of (2)-(11), as exact fractions; and its tube on a grid of times.

The tube is computed by `reference.py`, which shares no code with what is emitted. alpha is stepped by the implicit step that the
emitted code makes. The falsification and the comparison with the emitted code read the grid; the lemmas `update.*` are about the
step.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from fractions import Fraction
from functools import cache
from typing import Any, ClassVar, NamedTuple

import numpy as np

from stt_codegen import reference
from stt_codegen.decimals import nine_digits
from stt_codegen.design_kinds import CAPABILITIES, Capabilities, DesignKind
from stt_codegen.designs.tube import LOWER, UPPER, Array, Design, Edge, require_time
from stt_codegen.errors import BadInput

GRID_STEPS = 4000  # steps from 0 to t_c
ALPHA_STEPS = 2000  # steps of alpha from 0 to t_c, where no certificate bounds them


@dataclass(frozen=True, kw_only=True)
class Bump:
    """One circumvent function (7) or (8): `side` LOWER raises beta_L of `dimension`, UPPER lowers beta_U.

    height: B, the task's units. steepness: k^j. middle, radius: m^j, r^j in seconds. unsafe: name of the set it is for.
    """

    dimension: int
    side: int
    height: Fraction
    steepness: Fraction
    middle: Fraction
    radius: Fraction
    unsafe: str


@dataclass(frozen=True, kw_only=True)
class AdaptiveDesign:
    """An adaptive tube (10): `kind` is "adaptive" (sound windows and sides) or "literal" (the paper's rule).

    start, target, walls: X0hat, That and the rest levels X_i of (7), (8), lower and upper by dimension.
    theta0 (units cubed per second), kappa (1/s), mu (units), varsigma, nu (1/units): parameters of (10) and (11).
    """

    kind: DesignKind
    prescribed_time: Fraction
    start: tuple[Edge, ...]
    target: tuple[Edge, ...]
    walls: tuple[Edge, ...]
    bumps: tuple[Bump, ...]
    theta0: Fraction
    kappa: Fraction
    mu: Fraction
    varsigma: Fraction
    nu: Fraction
    seed: int | None = None  # of the literal design's random sides

    is_stateful: ClassVar[bool] = True  # the caller keeps alpha
    filter: ClassVar[tuple[Fraction, ...]] = ()
    cycle_begin: ClassVar[None] = None
    parts: ClassVar[None] = None

    def __post_init__(self) -> None:
        """Raise `BadInput` where the numbers are of no tube: a user may change any field."""
        require_time(self.prescribed_time)
        if self.kind not in ("adaptive", "literal"):
            raise BadInput(f'tube: is of the kind {self.kind!r}; these numbers are of an "adaptive" or a "literal" one')
        n = len(self.start)
        for name in ("start", "target", "walls"):
            pairs = getattr(self, name)
            if not n or len(pairs) != n or any(len(pair) != 2 for pair in pairs):
                raise BadInput(f"tube: has {len(pairs)} entries in {name}; {n or 1} pairs are needed, lower and upper")
        numbers = [getattr(self, name) for name in ("theta0", "kappa", "mu", "varsigma", "nu")]
        numbers += [v for name in ("start", "target", "walls") for pair in getattr(self, name) for v in pair]
        if not all(isinstance(v, Fraction) for v in numbers):
            raise BadInput("tube: has a parameter that is no Fraction")
        if any(not 0 <= bump.dimension < n or bump.side not in (LOWER, UPPER) for bump in self.bumps):
            raise BadInput(f"tube: has a circumvent function for no edge; dimensions are 0 to {n - 1}, sides {LOWER} and {UPPER}")

    @property
    def capabilities(self) -> Capabilities:
        return CAPABILITIES[self.kind]

    @property
    def dimension(self) -> int:
        return len(self.start)

    def parameters(self) -> dict[str, Any]:
        """Return what a certificate says about the design itself: all of its parameters, to nine digits."""
        names = ("theta0", "kappa", "mu", "varsigma", "nu")
        bumps = [
            {
                "unsafe_set": b.unsafe,
                "dimension": b.dimension + 1,
                "side": "lower" if b.side == LOWER else "upper",
                **{name: nine_digits(getattr(b, name)) for name in ("height", "steepness", "middle", "radius")},
            }
            for b in self.bumps
        ]
        seed = {} if self.seed is None else {"seed": self.seed}
        return {**{name: nine_digits(getattr(self, name)) for name in names}, **seed, "circumvent_functions": bumps}

    @property
    def size(self) -> str:
        """How large the design is, in words."""
        return f"{len(self.bumps)} circumvent function{'' if len(self.bumps) == 1 else 's'}"

    def numbers(self) -> dict[str, Any]:
        """Return all numbers by name."""
        return asdict(self)

    def edges_at(self, t: Array) -> tuple[Array, Array]:
        """Return lower and upper edges at equally spaced times t from 0 to t_c, shape (P, n) each, in doubles."""
        gamma = grid_tube(self, len(t) - 1).gamma
        return gamma[:, :, LOWER], gamma[:, :, UPPER]

    def bumps_on(self, dimension: int, side: int) -> tuple[Bump, ...]:
        """Return the bumps on one side of one dimension."""
        return tuple(b for b in self.bumps if (b.dimension, b.side) == (dimension, side))

    @property
    def slots(self) -> tuple[int, int]:
        """The number of bumps that every dimension gets on its lower and on its upper side: as many as any dimension needs."""
        low, high = (max(len(self.bumps_on(i, side)) for i in range(self.dimension)) for side in (LOWER, UPPER))
        return low, high


def require_adaptive(design: Design) -> AdaptiveDesign:
    """Return the design, which is adaptive or literal wherever this is called: a table of kinds led there."""
    if not isinstance(design, AdaptiveDesign):
        raise TypeError(f"an adaptive or literal tube is needed here; this one is {design.kind}")
    return design


def parameters_of(design: AdaptiveDesign) -> reference.Parameters:
    """Return the plain data of a design for the reference."""

    def edges(pairs: tuple[tuple[Fraction, Fraction], ...]) -> Array:
        return np.array([[reference.exact(v) for v in pair] for pair in pairs])

    e = reference.exact
    return reference.Parameters(
        t_c=e(design.prescribed_time), start=edges(design.start), target=edges(design.target), walls=edges(design.walls),
        bumps=tuple((b.dimension, b.side, e(b.height), e(b.steepness), e(b.middle), e(b.radius)) for b in design.bumps),
        theta0=e(design.theta0), kappa=e(design.kappa), mu=e(design.mu), varsigma=e(design.varsigma), nu=e(design.nu),
    )  # fmt: skip


class GridTube(NamedTuple):
    """A tube on a grid: times (S + 1,), and alpha, gamma and gammadot of shape (S + 1, n, 2)."""

    t: Array
    alpha: Array
    gamma: Array
    rate: Array


def uncertified_alpha_step(prescribed_time: Fraction) -> Fraction:
    """Return the step of alpha, in seconds, that is taken where no certificate says how long a step may be."""
    return prescribed_time / ALPHA_STEPS


def grid_tube(design: AdaptiveDesign, steps: int = GRID_STEPS) -> GridTube:
    """Return the tube at S + 1 equally spaced times, with alpha stepped from 0 by dt = t_c / S."""
    p = parameters_of(design)
    step = float(design.prescribed_time) / steps
    t = np.arange(steps + 1) * step
    lines = reference.lines(p, t)
    alpha = step_alpha(design, lines.psi.astype(float), step)
    gamma, rate = reference.adaptive_tube(p, lines, alpha)
    return GridTube(t, alpha, gamma.astype(float), rate.astype(float))


def step_alpha(design: AdaptiveDesign, psi: Array, dt: float) -> Array:
    """Return alpha on a grid of step dt from 0, by the implicit step that is emitted. psi and alpha: (S + 1, n, 2)."""
    steps = _steps(len(psi) - 1)
    parameters = [float(v) for v in (design.theta0, design.kappa, design.mu, design.varsigma)]
    alpha = np.zeros(psi.shape)
    for i, side in np.ndindex(*psi.shape[1:]):
        alpha[1:, i, side] = np.array(steps(0.0, psi[1:, i, side][None], dt, *parameters)).ravel()
    return alpha


@cache
def _steps(count: int) -> Any:
    from stt_codegen.paper.adaptive_tube import implicit_step_function

    return implicit_step_function().mapaccum("steps", count)
