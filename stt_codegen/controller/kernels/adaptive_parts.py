"""The pieces that the functions of an adaptive or literal controller are made of: kernels, tables, and the statements for
rho, beta, psi, alpha and gamma of one dimension."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from stt_codegen.controller.kernels.law import Law
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign
from stt_codegen.paper import adaptive_tube, circumvent, reach_tube
from stt_codegen.program import REAL, Block, Const, Kernel, Load, Operand, Table, Var, integer, real
from stt_codegen.program.convert import lower

LONGEST_STEP = Fraction(1 << 20)  # seconds; a longer dt counts as this, alpha has settled long before
FILLER = (Fraction(0), Fraction(1), Fraction(0), Fraction(1))  # a bump of height 0


@dataclass(frozen=True, kw_only=True)
class Kernels:
    """The kernels of (4)-(11)."""

    hold: Kernel
    profile: Kernel
    profile_rate: Kernel
    reach_edge: Kernel
    reach_rate: Kernel
    circumvent: Kernel
    circumvent_rate: Kernel
    join: Kernel
    join_rate: Kernel
    update_rate: Kernel
    implicit_start: Kernel
    newton: Kernel
    implicit_end: Kernel
    lower_edge: Kernel
    lower_edge_rate: Kernel
    upper_edge: Kernel
    upper_edge_rate: Kernel
    theta: Kernel

    def emitted(self, slots: tuple[int, int]) -> tuple[Kernel, ...]:
        """Those that some public function calls: theta is for the probe, joining only where a side has two bumps."""
        unused = {"theta"}
        if max(slots) == 0:
            unused |= {"circumvent", "circumvent_rate"}
        if max(slots) < 2:
            unused |= {"join", "join_rate"}
        return tuple(k for name, k in vars(self).items() if name not in unused)


@cache  # they depend on no task
def kernels_of_the_paper() -> Kernels:
    return Kernels(
        hold=_hold(),
        profile=lower(reach_tube.profile(), ("Time profile of (4): sigma = tanh(t / (t_c - t)), 1 from t_c on.",)),
        profile_rate=lower(reach_tube.profile(True), ("sigma of (4) and its derivative.",)),
        reach_edge=lower(reach_tube.reach_edge(), ("An edge of the reachability tube (4).",)),
        reach_rate=lower(reach_tube.reach_rate(), ("The rate of an edge of the reachability tube (4).",)),
        circumvent=lower(circumvent.circumvent(), ("A circumvent function (7), (8) above its rest level.",)),
        circumvent_rate=lower(circumvent.circumvent(True), ("A circumvent function (7), (8) and its derivative.",)),
        join=lower(circumvent.join(), ("Joins circumvent functions of one side smoothly, in place of (9).",)),
        join_rate=lower(circumvent.join(True), ("Joins circumvent functions of one side, with the rate.",)),
        update_rate=lower(adaptive_tube.update_rate(), ("The update function's equation (11) and its exact Jacobian.",)),
        implicit_start=lower(adaptive_tube.implicit_start(), ("Implicit step of (11): (z - p) z^2 = q, and where to start.",)),
        newton=lower(adaptive_tube.newton(), ("One Newton iterate for (z - p) z^2 = q.",)),
        implicit_end=lower(adaptive_tube.implicit_end(), ("Implicit step of (11): alpha from the root z = psi + alpha.",)),
        lower_edge=lower(adaptive_tube.lower_edge(), ("gamma_L of (10).",)),
        lower_edge_rate=lower(adaptive_tube.lower_edge(True), ("gamma_L of (10) and its total rate.",)),
        upper_edge=lower(adaptive_tube.upper_edge(), ("gamma_U of (10).",)),
        upper_edge_rate=lower(adaptive_tube.upper_edge(True), ("gamma_U of (10) and its total rate.",)),
        theta=lower(adaptive_tube.theta(), ("theta of (11).",)),
    )


def _hold() -> Kernel:
    """The kernel that holds t within [0, t_c]."""
    t, t_c = Var("t", REAL), Var("t_c", REAL)
    block = Block({"t", "t_c"})
    positive = block.op("positive", "lt", real(0), t)
    started = block.select("started", positive, t, real(0))
    running = block.op("running", "lt", started, t_c)
    held = block.select("held", running, started, t_c)
    return Kernel("hold", (t, t_c), tuple(block.statements), (held,), ("held",), doc=("t held within [0, t_c].",))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Frame:
    """What every function of one program needs: the design, its kernels, and how many bumps a side has."""

    design: AdaptiveDesign
    kernels: Kernels
    law: Law
    scalar: str

    @property
    def n(self) -> int:
        return self.design.dimension

    @property
    def slots(self) -> tuple[int, int]:
        return self.design.slots

    @property
    def t_c(self) -> Const:
        return real(self.design.prescribed_time)

    @property
    def update(self) -> tuple[Const, ...]:
        d = self.design
        return tuple(real(v) for v in (d.theta0, d.kappa, d.mu, d.varsigma))


def tables_of(frame: Frame) -> list[Table]:
    d, slots = frame.design, frame.slots
    reach = [v for i in range(frame.n) for v in (d.start[i][0], d.target[i][0], d.start[i][1], d.target[i][1])]
    tables = [
        Table("reach", tuple(reach), 4, ("By dimension: X0hat and That of the lower edge, X0hat and That of the upper edge.",)),
        Table("walls", tuple(v for edge in d.walls for v in edge), 2, ("By dimension: rest levels of beta_L and beta_U.",)),
    ]
    if any(slots):
        rows = []
        for i in range(frame.n):
            for side in (LOWER, UPPER):
                own = [(b.height, b.steepness, b.middle, b.radius) for b in d.bumps_on(i, side)]
                rows += own + [FILLER] * (slots[side] - len(own))
        doc = (
            f"Circumvent functions B, k, m, r: for each dimension {slots[LOWER]} of beta_L, then {slots[UPPER]} of beta_U,",
            "filled up with height 0.",
        )
        tables.append(Table("bumps", tuple(v for row in rows for v in row), 4, doc))
    return tables


@dataclass(frozen=True)
class Lines:
    """rho and beta of one dimension at one time, (lower, upper); with rates where asked."""

    rho: tuple[Var, Var]
    beta: tuple[Var, Var]
    rho_rate: tuple[Var, Var] | None = None
    beta_rate: tuple[Var, Var] | None = None


def profile(block: Block, frame: Frame, t: Operand, rate: bool) -> tuple[Var, Var, Var | None]:
    """t held within [0, t_c], sigma there, and its rate (0 from t_c on)."""
    (held,) = block.call(frame.kernels.hold, t, frame.t_c)
    if not rate:
        (sigma,) = block.call(frame.kernels.profile, held, frame.t_c)
        return held, sigma, None
    sigma, sigma_rate = block.call(frame.kernels.profile_rate, held, frame.t_c)
    return held, sigma, sigma_rate


def lines_of(block: Block, frame: Frame, i: Operand, held: Var, sigma: Var, sigma_rate: Var | None) -> Lines:
    """Statements for rho (4) and beta (9) of dimension i."""
    k = frame.kernels
    row = block.op("reach_row", "imul", i, integer(4))
    pair = block.op("wall_row", "imul", i, integer(2))
    rho, rho_rate, beta, beta_rate = [], [], [], []
    for side, name in ((LOWER, "low"), (UPPER, "high")):
        at = block.op(f"{name}_start_at", "iadd", row, integer(2 * side)) if side else row
        start = block.let(f"{name}_start", Load("reach", at))
        end = block.let(f"{name}_end", Load("reach", block.op(f"{name}_end_at", "iadd", row, integer(2 * side + 1))))
        (edge,) = block.call(k.reach_edge, start, end, sigma, names=(f"rho_{name}",))
        rho.append(edge)
        if sigma_rate is not None:
            (speed,) = block.call(k.reach_rate, start, end, sigma_rate, names=(f"rho_{name}_rate",))
            rho_rate.append(speed)
    for side, name in ((LOWER, "low"), (UPPER, "high")):
        at = block.op(f"{name}_wall_at", "iadd", pair, integer(1)) if side else pair
        wall = block.let(f"{name}_wall", Load("walls", at))
        height, slope = _joined(block, frame, i, side, name, held, sigma_rate is not None)
        beta.append(block.op(f"beta_{name}", "add" if side == LOWER else "sub", wall, height))
        if slope is not None:
            beta_rate.append(slope if side == LOWER else block.op(f"beta_{name}_rate", "neg", slope))
    if sigma_rate is None:
        return Lines((rho[0], rho[1]), (beta[0], beta[1]))
    return Lines((rho[0], rho[1]), (beta[0], beta[1]), (rho_rate[0], rho_rate[1]), (beta_rate[0], beta_rate[1]))


def _joined(block: Block, frame: Frame, i: Operand, side: int, name: str, held: Var, rate: bool) -> tuple[Var, Var | None]:
    """Statements for the joined circumvent functions of one side of dimension i, above rest."""
    k, slots = frame.kernels, frame.slots[side]
    nu, cut = real(frame.design.nu), real(circumvent.CUT[frame.scalar])
    if slots == 0:
        rest = block.let(f"{name}_rest", real(0))
        return rest, (block.let(f"{name}_rest_rate", real(0)) if rate else None)
    first = block.op(f"{name}_bumps_at", "imul", i, integer(4 * sum(frame.slots)))
    with block.loop(f"{name}_j", slots) as loop:
        total = loop.carry(f"{name}_joined", real(0))
        total_rate = loop.carry(f"{name}_joined_rate", real(0)) if rate else None
        offset = block.op(f"{name}_offset", "imul", loop.index, integer(4))
        at = block.op(f"{name}_at", "iadd", first, offset)
        values = []
        for column, label in enumerate(("height", "steepness", "middle", "radius")):
            shift = 4 * frame.slots[LOWER] * side + column
            index = block.op(f"{name}_{label}_at", "iadd", at, integer(shift)) if shift else at
            values.append(block.let(f"{name}_{label}", Load("bumps", index)))
        if total_rate is not None:
            bump, bump_rate = block.call(k.circumvent_rate, held, *values, cut, names=(f"{name}_bump", f"{name}_bump_rate"))
            if slots > 1:
                names = (f"{name}_next", f"{name}_next_rate")
                bump, bump_rate = block.call(k.join_rate, total, bump, total_rate, bump_rate, nu, names=names)
            loop.update(total_rate, bump_rate)
        else:
            (bump,) = block.call(k.circumvent, held, *values, cut, names=(f"{name}_bump",))
            if slots > 1:
                (bump,) = block.call(k.join, total, bump, nu, names=(f"{name}_next",))
        loop.update(total, bump)
    return total, total_rate


def psi_of(block: Block, lines: Lines) -> tuple[Var, Var]:
    """psi_L = beta_U - rho_L and psi_U = rho_U - beta_L."""
    lower_psi = block.op("psi_low", "sub", lines.beta[UPPER], lines.rho[LOWER])
    return lower_psi, block.op("psi_high", "sub", lines.rho[UPPER], lines.beta[LOWER])


def alpha_cap(design: AdaptiveDesign) -> Fraction:
    """Above every alpha that (11) has: alphadot < 0 for alpha >= |psi| + (2 theta0 / kappa)^(1/3), with room of 4."""
    lengths = [b - a for a, b in design.walls] + [b.height for b in design.bumps]
    settled = Fraction(2 ** math.ceil(math.log2(2 * design.theta0 / design.kappa) / 3))
    return 4 * (2 * max(lengths) + settled)


def alphas_of(block: Block, frame: Frame, i: Operand) -> tuple[Var, Var]:
    """alpha_L and alpha_U of dimension i, held within [0, cap], which keeps everything finite for a caller's odd numbers."""
    span = alpha_cap(frame.design)
    result = []
    for side, name in ((LOWER, "low"), (UPPER, "high")):
        at = block.op(f"alpha_{name}_at", "iadd", i, integer(frame.n)) if side else i
        given = block.let(f"alpha_{name}_in", Load("alpha", at))
        positive = block.op(f"alpha_{name}_positive", "lt", real(0), given)
        raised = block.select(f"alpha_{name}_raised", positive, given, real(0))
        small = block.op(f"alpha_{name}_small", "lt", raised, real(span))
        result.append(block.select(f"alpha_{name}", small, raised, real(span)))
    return result[0], result[1]


def edges_of(block: Block, frame: Frame, lines: Lines, alphas: tuple[Var, Var]) -> tuple[Var, Var]:
    """Statements for gamma_L and gamma_U (10)."""
    k, nu = frame.kernels, real(frame.design.nu)
    (low,) = block.call(k.lower_edge, lines.rho[LOWER], alphas[LOWER], lines.beta[LOWER], nu, names=("gamma_low",))
    (high,) = block.call(k.upper_edge, lines.rho[UPPER], alphas[UPPER], lines.beta[UPPER], nu, names=("gamma_high",))
    return low, high
