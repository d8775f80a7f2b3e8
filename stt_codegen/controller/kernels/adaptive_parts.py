"""What the functions of an adaptive or literal controller are built from.

These are tables, and statements for rho, beta, psi, alpha and gamma of one dimension.

adaptive_frame.py and probes.py call this file. Functions named `write_..` append statements to a block of a Program and return
the variables that hold the results. Strings that they pass are names in emitted code. Pairs are (lower, upper). Numbers in
brackets are equations of docs/paper.md; the lemmas `kernels.*`, `functions.*` and `update.*` of docs/lemmas.md are about what is
built here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from stt_codegen.controller.kernels.adaptive_kernels import AdaptiveKernels, build_adaptive_kernels
from stt_codegen.controller.kernels.law import ControlLaw, build_control_law
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign
from stt_codegen.paper import circumvent
from stt_codegen.program import Block, Const, Load, Operand, Table, Var, integer, real
from stt_codegen.task import Task

LONGEST_STEP = Fraction(1 << 20)  # seconds; a longer dt counts as this: alpha is at rest long before
FLAT_BUMP = (Fraction(0), Fraction(1), Fraction(0), Fraction(1))  # height, steepness, middle, radius
SIDE_LABELS = ((LOWER, "low"), (UPPER, "high"))  # labels are parts of names in emitted code


@dataclass(frozen=True)
class AdaptiveParts:
    """What all functions of one adaptive program are built from: the design, the kernels, and the control law.

    scalar: "float" or "double"."""

    design: AdaptiveDesign
    kernels: AdaptiveKernels
    law: ControlLaw
    scalar: str

    @classmethod
    def of(cls, task: Task, design: AdaptiveDesign) -> AdaptiveParts:
        """Collect the parts for a task. Raises `BadInput` when the law's constants do not fit its scalar."""
        return cls(design, build_adaptive_kernels(), build_control_law(task), task.emit.scalar)

    @property
    def n(self) -> int:
        """The number of dimensions."""
        return self.design.dimension

    @property
    def slots(self) -> tuple[int, int]:
        """The number of rows that each dimension has in the table of circumvent functions, by side."""
        return self.design.slots

    @property
    def t_c(self) -> Const:
        """The prescribed time, in seconds."""
        return real(self.design.prescribed_time)

    @property
    def update_constants(self) -> tuple[Const, ...]:
        """theta0, kappa, mu and varsigma of the update equation (11)."""
        d = self.design
        return tuple(real(v) for v in (d.theta0, d.kappa, d.mu, d.varsigma))


def build_adaptive_tables(parts: AdaptiveParts) -> list[Table]:
    """Build the tables of the tube: `reach`, `walls`, and `bumps` where there are circumvent functions."""
    d, slots = parts.design, parts.slots
    reach = [v for i in range(parts.n) for v in (d.start[i][0], d.target[i][0], d.start[i][1], d.target[i][1])]
    tables = [
        Table("reach", tuple(reach), 4, ("By dimension: X0hat and That of the lower edge, X0hat and That of the upper edge.",)),
        Table("walls", tuple(v for edge in d.walls for v in edge), 2, ("By dimension: rest levels of beta_L and beta_U.",)),
    ]
    if any(slots):
        rows = []
        for i in range(parts.n):
            for side in (LOWER, UPPER):
                bumps = [(b.height, b.steepness, b.middle, b.radius) for b in d.bumps_on(i, side)]
                rows += bumps + [FLAT_BUMP] * (slots[side] - len(bumps))
        doc = (
            f"Circumvent functions B, k, m, r: for each dimension {slots[LOWER]} of beta_L, then {slots[UPPER]} of beta_U,",
            "filled up with height 0.",
        )
        tables.append(Table("bumps", tuple(v for row in rows for v in row), 4, doc))
    return tables


class TimeProfile(NamedTuple):
    """t clamped to [0, t_c], sigma of (4) at that time, and the rate of sigma if it was requested (0 from t_c on)."""

    t: Var
    sigma: Var
    sigma_rate: Var | None


def write_time_profile(block: Block, parts: AdaptiveParts, t: Operand, *, with_rate: bool = False) -> TimeProfile:
    """Write statements for the time profile of (4) at time t."""
    (clamped_t,) = block.call(parts.kernels.hold, t, parts.t_c)
    if not with_rate:
        (sigma,) = block.call(parts.kernels.profile, clamped_t, parts.t_c)
        return TimeProfile(clamped_t, sigma, None)
    sigma, sigma_rate = block.call(parts.kernels.profile_rate, clamped_t, parts.t_c)
    return TimeProfile(clamped_t, sigma, sigma_rate)


@dataclass(frozen=True)
class RhoBeta:
    """rho (4) and beta (9) of one dimension at one time; with rates if the time profile has one."""

    rho: tuple[Var, Var]
    beta: tuple[Var, Var]
    rho_rate: tuple[Var, Var] | None = None
    beta_rate: tuple[Var, Var] | None = None


def write_rho_and_beta(block: Block, parts: AdaptiveParts, i: Operand, profile: TimeProfile) -> RhoBeta:
    """Write statements for rho (4) and beta (9) of dimension i, and for their rates if the profile has a rate."""
    reach_row = block.op("reach_row", "imul", i, integer(4))
    wall_row = block.op("wall_row", "imul", i, integer(2))
    rhos = [_write_rho(block, parts, reach_row, side, profile) for side in (LOWER, UPPER)]
    betas = [_write_beta(block, parts, (i, wall_row), side, profile) for side in (LOWER, UPPER)]
    (rho_low, rho_low_rate), (rho_high, rho_high_rate) = rhos
    (beta_low, beta_low_rate), (beta_high, beta_high_rate) = betas
    if rho_low_rate is None or rho_high_rate is None or beta_low_rate is None or beta_high_rate is None:
        return RhoBeta((rho_low, rho_high), (beta_low, beta_high))
    return RhoBeta((rho_low, rho_high), (beta_low, beta_high), (rho_low_rate, rho_high_rate), (beta_low_rate, beta_high_rate))


def _write_rho(block: Block, parts: AdaptiveParts, row: Var, side: int, profile: TimeProfile) -> tuple[Var, Var | None]:
    """Write statements for one edge of the reachability tube (4) and its rate. row: table index of the dimension in `reach`."""
    label = SIDE_LABELS[side][1]
    start_index = block.op(f"{label}_start_at", "iadd", row, integer(2 * side)) if side else row
    start = block.let(f"{label}_start", Load("reach", start_index))
    end_index = block.op(f"{label}_end_at", "iadd", row, integer(2 * side + 1))
    end = block.let(f"{label}_end", Load("reach", end_index))
    (rho,) = block.call(parts.kernels.reach_edge, start, end, profile.sigma, names=(f"rho_{label}",))
    if profile.sigma_rate is None:
        return rho, None
    (rate,) = block.call(parts.kernels.reach_rate, start, end, profile.sigma_rate, names=(f"rho_{label}_rate",))
    return rho, rate


def _write_beta(
    block: Block, parts: AdaptiveParts, indices: tuple[Operand, Var], side: int, profile: TimeProfile
) -> tuple[Var, Var | None]:
    """Write statements for beta (9) of one side and its rate. indices: the dimension, and its table index in `walls`."""
    label = SIDE_LABELS[side][1]
    i, row = indices
    wall_index = block.op(f"{label}_wall_at", "iadd", row, integer(1)) if side else row
    wall = block.let(f"{label}_wall", Load("walls", wall_index))
    height, height_rate = _write_joined_bumps(block, parts, i, side, profile)
    beta = block.op(f"beta_{label}", "add" if side == LOWER else "sub", wall, height)
    if height_rate is None or side == LOWER:
        return beta, height_rate
    return beta, block.op(f"beta_{label}_rate", "neg", height_rate)


def _write_joined_bumps(
    block: Block, parts: AdaptiveParts, i: Operand, side: int, profile: TimeProfile
) -> tuple[Var, Var | None]:
    """Write statements for the joined circumvent functions of one side of dimension i: height above the wall, and its rate."""
    label, kernels, slots = SIDE_LABELS[side][1], parts.kernels, parts.slots[side]
    nu, cutoff = real(parts.design.nu), real(circumvent.CUT[parts.scalar])
    has_rate = profile.sigma_rate is not None
    if slots == 0:
        height = block.let(f"{label}_rest", real(0))
        return height, (block.let(f"{label}_rest_rate", real(0)) if has_rate else None)
    first_index = block.op(f"{label}_bumps_at", "imul", i, integer(4 * sum(parts.slots)))
    with block.loop(f"{label}_j", slots) as loop:
        total = loop.carry(f"{label}_joined", real(0))
        total_rate = loop.carry(f"{label}_joined_rate", real(0)) if has_rate else None
        offset = block.op(f"{label}_offset", "imul", loop.index, integer(4))
        shape = _write_bump_shape(block, parts, block.op(f"{label}_at", "iadd", first_index, offset), side)
        if total_rate is not None:
            names: tuple[str, ...] = (f"{label}_bump", f"{label}_bump_rate")
            bump, bump_rate = block.call(kernels.circumvent_rate, profile.t, *shape, cutoff, names=names)
            if slots > 1:
                names = (f"{label}_next", f"{label}_next_rate")
                bump, bump_rate = block.call(kernels.join_rate, total, bump, total_rate, bump_rate, nu, names=names)
            loop.update(total_rate, bump_rate)
        else:
            (bump,) = block.call(kernels.circumvent, profile.t, *shape, cutoff, names=(f"{label}_bump",))
            if slots > 1:
                (bump,) = block.call(kernels.join, total, bump, nu, names=(f"{label}_next",))
        loop.update(total, bump)
    return total, total_rate


def _write_bump_shape(block: Block, parts: AdaptiveParts, index: Var, side: int) -> list[Var]:
    """Write statements that load B, k, m and r of a circumvent function.

    index: that of the lower side's entry; entries of the upper side follow those of the lower one."""
    label = SIDE_LABELS[side][1]
    shape = []
    for column, quantity in enumerate(("height", "steepness", "middle", "radius")):
        shift = 4 * parts.slots[LOWER] * side + column
        shifted_index = block.op(f"{label}_{quantity}_at", "iadd", index, integer(shift)) if shift else index
        shape.append(block.let(f"{label}_{quantity}", Load("bumps", shifted_index)))
    return shape


def write_psi(block: Block, rho_beta: RhoBeta) -> tuple[Var, Var]:
    """Write statements for psi_L = beta_U - rho_L and psi_U = rho_U - beta_L."""
    lower_psi = block.op("psi_low", "sub", rho_beta.beta[UPPER], rho_beta.rho[LOWER])
    return lower_psi, block.op("psi_high", "sub", rho_beta.rho[UPPER], rho_beta.beta[LOWER])


def alpha_cap(design: AdaptiveDesign) -> Fraction:
    """Return a bound that no alpha of (11) reaches: 4 times one where alphadot < 0.

    alphadot < 0 for alpha >= |psi| + (2 theta0 / kappa)^(1/3)."""
    lengths = [b - a for a, b in design.walls] + [b.height for b in design.bumps]
    cube_root = Fraction(2 ** math.ceil(math.log2(2 * design.theta0 / design.kappa) / 3))  # a power of two above it
    return 4 * (2 * max(lengths) + cube_root)


def write_clamped_alphas(block: Block, parts: AdaptiveParts, i: Operand) -> tuple[Var, Var]:
    """Write statements for alpha_L and alpha_U of dimension i, clamped to [0, alpha_cap].

    The clamp makes every result finite for any finite alpha that a caller passes."""
    cap = alpha_cap(parts.design)
    alphas = []
    for side, label in SIDE_LABELS:
        index = block.op(f"alpha_{label}_at", "iadd", i, integer(parts.n)) if side else i
        unclamped = block.let(f"alpha_{label}_in", Load("alpha", index))
        is_positive = block.op(f"alpha_{label}_positive", "lt", real(0), unclamped)
        raised = block.select(f"alpha_{label}_raised", is_positive, unclamped, real(0))
        is_below_cap = block.op(f"alpha_{label}_small", "lt", raised, real(cap))
        alphas.append(block.select(f"alpha_{label}", is_below_cap, raised, real(cap)))
    return alphas[0], alphas[1]


def write_gamma(block: Block, parts: AdaptiveParts, i: Operand, profile: TimeProfile) -> tuple[Var, Var]:
    """Write statements for gamma_L and gamma_U (10) of dimension i."""
    rho_beta = write_rho_and_beta(block, parts, i, profile)
    alphas = write_clamped_alphas(block, parts, i)
    kernels, nu = parts.kernels, real(parts.design.nu)
    rho, beta = rho_beta.rho, rho_beta.beta
    (low,) = block.call(kernels.lower_edge, rho[LOWER], alphas[LOWER], beta[LOWER], nu, names=("gamma_low",))
    (high,) = block.call(kernels.upper_edge, rho[UPPER], alphas[UPPER], beta[UPPER], nu, names=("gamma_high",))
    return low, high
