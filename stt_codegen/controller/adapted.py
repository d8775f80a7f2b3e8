"""The frame of an adaptive or literal controller: alpha kept by the caller, tube from (4)-(11), law (13).

Which numbers are data and which are code: what there is once for every dimension or every circumvent function (X0hat, That, the
walls, and B, k, m, r of every bump) stands in tables that a loop reads, so a thousand unsafe sets add rows and no code; what
there is once for the whole task (t_c, theta0, kappa, mu, varsigma, nu, k of the law) is passed to the kernels as constants.
Each side of each dimension has the same number of rows in the table of bumps, filled up with bumps of height 0, so that the
loop's bound is a constant and every step costs the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.controller.component import (
    Law,
    clamped_distances,
    control_component,
    control_law_of,
    strictly_inside,
    transform_function,
)
from stt_codegen.design.adapted import AdaptiveDesign
from stt_codegen.design.tube import LOWER, UPPER
from stt_codegen.paper import adaptive_tube, circumvent, reach_tube
from stt_codegen.program.lower import lower
from stt_codegen.program.program import (
    NAN,
    REAL,
    STATUS,
    TRUE,
    Block,
    Const,
    Function,
    IsFinite,
    Kernel,
    Load,
    Operand,
    Param,
    Program,
    Select,
    Status,
    Table,
    Var,
    integer,
    real,
)
from stt_codegen.task import Task, decimal

OK, OUTSIDE, BAD = (Const(s, STATUS) for s in (Status.OK, Status.OUTSIDE_TUBE, Status.BAD_INPUT))
LONGEST_STEP = Fraction(1 << 20)  # seconds; a longer dt counts as this, alpha has settled long before
FILLER = (Fraction(0), Fraction(1), Fraction(0), Fraction(1))  # a bump of height 0


@dataclass(frozen=True)
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

    def emitted(self, slots: int) -> tuple[Kernel, ...]:
        """Those that some public function calls: theta is for the probe, joining only where a side has two bumps."""
        unused = {"theta"}
        if slots == 0:
            unused |= {"circumvent", "circumvent_rate"}
        if slots < 2:
            unused |= {"join", "join_rate"}
        return tuple(k for name, k in vars(self).items() if name not in unused)


def _kernels() -> Kernels:
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
    """t held within [0, t_c]."""
    t, t_c = Var("t", REAL), Var("t_c", REAL)
    block = Block({"t", "t_c"})
    positive = block.op("positive", "lt", real(0), t)
    started = block.select("started", positive, t, real(0))
    running = block.op("running", "lt", started, t_c)
    held = block.select("held", running, started, t_c)
    return Kernel("hold", (t, t_c), tuple(block.statements), (held,), ("held",), ("t held within [0, t_c].",))  # type: ignore[arg-type]


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
    def slots(self) -> int:
        return self.design.slots

    @property
    def t_c(self) -> Const:
        return real(self.design.prescribed_time)

    @property
    def update(self) -> tuple[Const, ...]:
        d = self.design
        return tuple(real(v) for v in (d.theta0, d.kappa, d.mu, d.varsigma))


def adapted_program(task: Task, design: AdaptiveDesign) -> Program:
    """Everything that is emitted for an adaptive or literal design. Raises `BadInput` when the law's constants do not fit."""
    frame = Frame(design, _kernels(), control_law_of(task), task.emit.scalar)
    n = frame.n
    return Program(
        prefix=task.name,
        dimension=n,
        scalar=task.emit.scalar,
        tables=tuple(_tables(frame)),
        kernels=(*frame.kernels.emitted(frame.slots), *frame.law.kernels),
        functions=(
            _alpha_init(n),
            _alpha_step(frame),
            _alpha_rate(frame),
            _tube(frame),
            _tube_rate(frame),
            _control(task, frame),
            transform_function(frame.law, n),
        ),
    )


def probe_program(task: Task, design: AdaptiveDesign) -> Program:
    """A program that returns what no emitted function does: sigma, rho, beta, psi, theta. For `compare`, never committed."""
    frame = Frame(design, _kernels(), control_law_of(task), task.emit.scalar)
    tables = [t for t in _tables(frame) if t.name != "u_max"]
    names = {"hold", "profile", "reach_edge", "theta"} | ({"circumvent"} if frame.slots else set())
    names |= {"join"} if frame.slots > 1 else set()
    kernels = tuple(k for name, k in vars(frame.kernels).items() if name in names)
    return Program(task.name, frame.n, task.emit.scalar, tuple(tables), kernels, (_probe(frame),))


def _tables(frame: Frame) -> list[Table]:
    d, m = frame.design, frame.slots
    reach = [v for i in range(frame.n) for v in (d.start[i][0], d.target[i][0], d.start[i][1], d.target[i][1])]
    tables = [
        Table("reach", tuple(reach), 4, ("By dimension: X0hat and That of the lower edge, X0hat and That of the upper edge.",)),
        Table("walls", tuple(v for edge in d.walls for v in edge), 2, ("By dimension: rest levels of beta_L and beta_U.",)),
    ]
    if m:
        rows = []
        for i in range(frame.n):
            for side in (LOWER, UPPER):
                own = [(b.height, b.steepness, b.middle, b.radius) for b in d.of(i, side)]
                rows += own + [FILLER] * (m - len(own))
        doc = (
            "Circumvent functions B, k, m, r: for each dimension those of beta_L, then those of beta_U,",
            f"{m} each, filled up with height 0.",
        )
        tables.append(Table("bumps", tuple(v for row in rows for v in row), 4, doc))
    if frame.law.u_max is not None:
        tables.append(Table("u_max", frame.law.u_max, frame.n, ("Saturation of u, by component.",)))
    return tables


# --------------------------------------------------------------------------------------------- the pieces


@dataclass(frozen=True)
class Lines:
    """rho and beta of one dimension at one time, (lower, upper); with rates where asked."""

    rho: tuple[Var, Var]
    beta: tuple[Var, Var]
    rho_rate: tuple[Var, Var] | None = None
    beta_rate: tuple[Var, Var] | None = None


def _profile(block: Block, frame: Frame, t: Operand, rate: bool) -> tuple[Var, Var, Var | None]:
    """t held within [0, t_c], sigma there, and its rate (0 from t_c on)."""
    (held,) = block.call(frame.kernels.hold, t, frame.t_c)
    if not rate:
        (sigma,) = block.call(frame.kernels.profile, held, frame.t_c)
        return held, sigma, None
    sigma, sigma_rate = block.call(frame.kernels.profile_rate, held, frame.t_c)
    return held, sigma, sigma_rate


def _lines(block: Block, frame: Frame, i: Operand, held: Var, sigma: Var, sigma_rate: Var | None) -> Lines:
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
    k, slots = frame.kernels, frame.slots
    nu, cut = real(frame.design.nu), real(circumvent.CUT[frame.scalar])
    if slots == 0:
        rest = block.let(f"{name}_rest", real(0))
        return rest, (block.let(f"{name}_rest_rate", real(0)) if rate else None)
    first = block.op(f"{name}_bumps_at", "imul", i, integer(8 * slots))
    with block.loop(f"{name}_j", slots) as loop:
        total = loop.carry(f"{name}_joined", real(0))
        total_rate = loop.carry(f"{name}_joined_rate", real(0)) if rate else None
        offset = block.op(f"{name}_offset", "imul", loop.index, integer(4))
        at = block.op(f"{name}_at", "iadd", first, offset)
        values = []
        for column, label in enumerate(("height", "steepness", "middle", "radius")):
            shift = 4 * slots * side + column
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


def _psi(block: Block, lines: Lines) -> tuple[Var, Var]:
    """psi_L = beta_U - rho_L and psi_U = rho_U - beta_L."""
    lower_psi = block.op("psi_low", "sub", lines.beta[UPPER], lines.rho[LOWER])
    return lower_psi, block.op("psi_high", "sub", lines.rho[UPPER], lines.beta[LOWER])


def _alphas(block: Block, frame: Frame, i: Operand) -> tuple[Var, Var]:
    """alpha_L and alpha_U of dimension i, held within [0, 4 times the widest wall], beyond which none ever is."""
    span = 4 * max(b - a for a, b in frame.design.walls)
    result = []
    for side, name in ((LOWER, "low"), (UPPER, "high")):
        at = block.op(f"alpha_{name}_at", "iadd", i, integer(frame.n)) if side else i
        given = block.let(f"alpha_{name}_in", Load("alpha", at))
        positive = block.op(f"alpha_{name}_positive", "lt", real(0), given)
        raised = block.select(f"alpha_{name}_raised", positive, given, real(0))
        small = block.op(f"alpha_{name}_small", "lt", raised, real(span))
        result.append(block.select(f"alpha_{name}", small, raised, real(span)))
    return result[0], result[1]


def _finite(block: Block, frame: Frame, scalars: Sequence[str], arrays: Sequence[tuple[str, int]]) -> Var:
    """Whether all scalars and arrays are finite; the result says "not"."""
    finite: Var | None = None
    for name in scalars:
        here = block.let(f"finite_{name}", IsFinite(Var(name, REAL)))
        finite = here if finite is None else block.op("finite_both", "and", finite, here)
    assert finite is not None
    for array, length in arrays:
        with block.loop(f"{array}_j", length) as loop:
            total = loop.carry(f"finite_{array}s", finite)
            here = block.let(f"finite_{array}", IsFinite(block.let(f"{array}_entry", Load(array, loop.index))))
            loop.update(total, block.op(f"finite_{array}_too", "and", total, here))
        finite = total
    return block.op("bad", "not", finite)


# ------------------------------------------------------------------------------------ the public functions


def _alpha_init(n: int) -> Function:
    block = Block({"alpha"})
    with block.loop("i", 2 * n) as loop:
        block.store("alpha", loop.index, real(0))
    block.leave()
    doc = ("Start of the update function: alpha(0) = 0 (11). alpha = [alpha_L by dimension, alpha_U by dimension].",)
    return Function("alpha_init", (Param("alpha", 2 * n, True),), tuple(block.statements), False, doc)


def _alpha_step(frame: Frame) -> Function:
    n, k = frame.n, frame.kernels
    block = Block({"t", "dt", "alpha"})
    bad = _finite(block, frame, ("t", "dt"), (("alpha", 2 * n),))
    forward = block.op("forward", "lt", real(0), Var("dt", REAL))
    with block.leave_when(block.op("stay", "or", bad, block.op("backward", "not", forward))):
        pass
    short = block.op("short_step", "lt", Var("dt", REAL), real(LONGEST_STEP))
    h = block.select("h", short, Var("dt", REAL), real(LONGEST_STEP))
    held, sigma, _ = _profile(block, frame, block.op("later", "add", Var("t", REAL), Var("dt", REAL)), False)
    with block.loop("i", n) as loop:
        lines = _lines(block, frame, loop.index, held, sigma, None)
        before = _alphas(block, frame, loop.index)
        for side, name, psi in zip((LOWER, UPPER), ("low", "high"), _psi(block, lines), strict=True):
            p, q, rest, start = block.call(
                k.implicit_start, psi, before[side], h, *frame.update, names=[f"{name}_{v}" for v in ("p", "q", "rest", "z0")]
            )
            with block.loop(f"{name}_k", adaptive_tube.NEWTON) as iteration:
                z = iteration.carry(f"{name}_z", start)
                (following,) = block.call(k.newton, p, q, z, names=(f"{name}_z_next",))
                iteration.update(z, following)
            (after,) = block.call(k.implicit_end, q, rest, z, names=(f"alpha_{name}_out",))
            at = block.op(f"{name}_out_at", "iadd", loop.index, integer(n)) if side else loop.index
            block.store("alpha", at, after)
    block.leave()
    doc = (
        "One implicit (backward Euler) step of (11) from t to t + dt seconds, in place; fixed cost, stable for every dt > 0.",
        "alpha stays as it was when dt <= 0 or a number is not finite. Call it once after each control step.",
    )
    params = (Param("t", None), Param("dt", None), Param("alpha", 2 * n, True, True))
    return Function("alpha_step", params, tuple(block.statements), False, doc)


def _alpha_rate(frame: Frame) -> Function:
    n = frame.n
    block = Block({"t", "alpha", "rate", "jacobian"})
    bad = _finite(block, frame, ("t",), (("alpha", 2 * n),))
    with block.leave_when(bad), block.loop("j", 2 * n) as loop:
        block.store("rate", loop.index, NAN)
        block.store("jacobian", loop.index, NAN)
    held, sigma, _ = _profile(block, frame, Var("t", REAL), False)
    with block.loop("i", n) as loop:
        lines = _lines(block, frame, loop.index, held, sigma, None)
        alphas = _alphas(block, frame, loop.index)
        for side, name, psi in zip((LOWER, UPPER), ("low", "high"), _psi(block, lines), strict=True):
            names = (f"rate_{name}", f"jacobian_{name}")
            rate, jacobian = block.call(frame.kernels.update_rate, psi, alphas[side], *frame.update, names=names)
            at = block.op(f"{name}_out_at", "iadd", loop.index, integer(n)) if side else loop.index
            block.store("rate", at, rate)
            block.store("jacobian", at, jacobian)
    block.leave()
    doc = (
        "Right side of the update equation (11) and its Jacobian d rate / d alpha (diagonal), laid out as alpha.",
        "For a solver of your own; `alpha_step` needs neither. NaN when a number is not finite.",
    )
    params = (Param("t", None), Param("alpha", 2 * n), Param("rate", 2 * n, True), Param("jacobian", 2 * n, True))
    return Function("alpha_rate", params, tuple(block.statements), False, doc)


def _edges(block: Block, frame: Frame, lines: Lines, alphas: tuple[Var, Var]) -> tuple[Var, Var]:
    """Statements for gamma_L and gamma_U (10)."""
    k, nu = frame.kernels, real(frame.design.nu)
    (low,) = block.call(k.lower_edge, lines.rho[LOWER], alphas[LOWER], lines.beta[LOWER], nu, names=("gamma_low",))
    (high,) = block.call(k.upper_edge, lines.rho[UPPER], alphas[UPPER], lines.beta[UPPER], nu, names=("gamma_high",))
    return low, high


def _tube(frame: Frame) -> Function:
    n = frame.n
    block = Block({"t", "alpha", "lower", "upper"})
    bad = _finite(block, frame, ("t",), (("alpha", 2 * n),))
    with block.leave_when(bad), block.loop("j", n) as loop:
        block.store("lower", loop.index, NAN)
        block.store("upper", loop.index, NAN)
    held, sigma, _ = _profile(block, frame, Var("t", REAL), False)
    with block.loop("i", n) as loop:
        lines = _lines(block, frame, loop.index, held, sigma, None)
        low, high = _edges(block, frame, lines, _alphas(block, frame, loop.index))
        block.store("lower", loop.index, low)
        block.store("upper", loop.index, high)
    block.leave()
    doc = (
        "Edges of the tube gamma (10) at time t (seconds) for the update function alpha, in the task's units.",
        "t below 0 counts as 0 and above t_c as t_c; NaN when t or alpha is not finite.",
    )
    params = (Param("t", None), Param("alpha", 2 * n), Param("lower", n, True), Param("upper", n, True))
    return Function("tube", params, tuple(block.statements), False, doc)


def _tube_rate(frame: Frame) -> Function:
    n, k, nu = frame.n, frame.kernels, real(frame.design.nu)
    block = Block({"t", "alpha", "lower_rate", "upper_rate"})
    bad = _finite(block, frame, ("t",), (("alpha", 2 * n),))
    with block.leave_when(bad), block.loop("j", n) as loop:
        block.store("lower_rate", loop.index, NAN)
        block.store("upper_rate", loop.index, NAN)
    held, sigma, sigma_rate = _profile(block, frame, Var("t", REAL), True)
    with block.loop("i", n) as loop:
        lines = _lines(block, frame, loop.index, held, sigma, sigma_rate)
        assert lines.rho_rate is not None
        assert lines.beta_rate is not None
        alphas = _alphas(block, frame, loop.index)
        for side, name, psi in zip((LOWER, UPPER), ("low", "high"), _psi(block, lines), strict=True):
            names = (f"alpha_{name}_rate", f"jacobian_{name}")
            alpha_rate, _ = block.call(k.update_rate, psi, alphas[side], *frame.update, names=names)
            kernel = k.lower_edge_rate if side == LOWER else k.upper_edge_rate
            rates = (lines.rho_rate[side], alpha_rate, lines.beta_rate[side])
            _, rate = block.call(
                kernel, lines.rho[side], alphas[side], lines.beta[side], nu, *rates, names=(f"gamma_{name}", f"gamma_{name}_rate")
            )
            block.store("lower_rate" if side == LOWER else "upper_rate", loop.index, rate)
    block.leave()
    doc = (
        "Total rate of the edges, d gamma / d t along (11), at time t (seconds), in units per second.",
        "Before 0 the rate at 0; from t_c on only alpha moves. NaN when t or alpha is not finite.",
    )
    params = (Param("t", None), Param("alpha", 2 * n), Param("lower_rate", n, True), Param("upper_rate", n, True))
    return Function("tube_rate", params, tuple(block.statements), False, doc)


def _control(task: Task, frame: Frame) -> Function:
    n, law = frame.n, frame.law
    block = Block({"t", "alpha", "x", "u"})
    bad = _finite(block, frame, ("t",), (("alpha", 2 * n), ("x", n)))
    with block.leave_when(bad, BAD), block.loop("j", n) as loop:
        block.store("u", loop.index, real(0))
    held, sigma, _ = _profile(block, frame, Var("t", REAL), False)
    with block.loop("i", n) as loop:
        i = loop.index
        inside = loop.carry("inside", TRUE)
        low, high = _edges(block, frame, _lines(block, frame, i, held, sigma, None), _alphas(block, frame, i))
        x = block.let("x_i", Load("x", i))
        u_max = block.let("u_limit", Load("u_max", i)) if law.u_max is not None else None
        block.store("u", i, control_component(block, law, clamped_distances(block, law, low, high, x), u_max))
        loop.update(inside, block.op("inside_all", "and", inside, strictly_inside(block, low, high, x)))
    block.leave(Select(inside, OK, OUTSIDE))
    gain, e_max = decimal(task.control.gain), decimal(task.control.e_max)
    doc = (
        f"Control law (13), u = -k xi epsilon, k = {gain}, e clamped to [-{e_max}, {e_max}] by component"
        + (", u saturated." if law.u_max is not None else "."),
        "t: seconds since the start (held within [0, t_c]); alpha: the update function at t; x: state; u: input.",
        "OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward for k > 0",
        "(0 where the tube is empty). BAD_INPUT: t, alpha or x has a NaN or an infinity; u is 0. u may be the array x itself.",
    )
    params = (Param("t", None), Param("alpha", 2 * n), Param("x", n), Param("u", n, True))
    return Function("control", params, tuple(block.statements), True, doc)


def _probe(frame: Frame) -> Function:
    n = frame.n
    names = ("sigma", "rho", "beta", "psi", "theta")
    block = Block({"t", *names})
    held, sigma, _ = _profile(block, frame, Var("t", REAL), False)
    block.store("sigma", integer(0), sigma)
    theta0, _, mu, varsigma = frame.update
    with block.loop("i", n) as loop:
        lines = _lines(block, frame, loop.index, held, sigma, None)
        for side, label, psi in zip((LOWER, UPPER), ("low", "high"), _psi(block, lines), strict=True):
            at = block.op(f"{label}_out_at", "iadd", loop.index, integer(n)) if side else loop.index
            (theta,) = block.call(frame.kernels.theta, psi, theta0, mu, varsigma, names=(f"theta_{label}",))
            for name, value in (("rho", lines.rho[side]), ("beta", lines.beta[side]), ("psi", psi), ("theta", theta)):
                block.store(name, at, value)
    block.leave()
    params = (Param("t", None), Param("sigma", n, True), *(Param(p, 2 * n, True) for p in names[1:]))
    return Function("probe", params, tuple(block.statements), False, ("sigma[0], and rho, beta, psi, theta laid out as alpha.",))
