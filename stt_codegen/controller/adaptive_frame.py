"""The program of an adaptive or literal controller: alpha kept by the caller, tube from (4)-(11), law (13).

pipeline.py calls `adaptive_program`. Each `_build_..` returns one public function of the emitted code: the checks, loops and
returns around the kernels. Strings that it passes to a block are names in emitted code.

Numbers that exist once for every dimension or every circumvent function (X0hat, That, the walls, and B, k, m, r of every bump)
stand in tables that a loop reads, so a thousand unsafe sets add rows and no code. Numbers that exist once for the whole task
(t_c, theta0, kappa, mu, varsigma, nu, k of the law) are passed to the kernels as constants. Every dimension has the same number
of rows in the table of bumps, lower and upper side each, filled up with bumps of height 0: so the loops' bounds are constants
and every step costs the same. The lemmas `functions.*` of docs/lemmas.md are about these functions.
"""

from __future__ import annotations

from fractions import Fraction

from stt_codegen.controller.comments import axes_doc, inward_doc, law_doc
from stt_codegen.controller.kernels import (
    LONGEST_STEP,
    MARGIN_DOC,
    MARGINS_DOC,
    SIDE_LABELS,
    AdaptiveParts,
    TimeProfile,
    ValueBetweenEdges,
    build_adaptive_tables,
    build_transform,
    write_clamped_alphas,
    write_clamped_distances,
    write_gamma,
    write_has_non_finite,
    write_input,
    write_is_inside,
    write_margin,
    write_psi,
    write_rho_and_beta,
    write_time_profile,
)
from stt_codegen.designs import LOWER, AdaptiveDesign
from stt_codegen.paper import adaptive_tube
from stt_codegen.program import (
    FALSE,
    NAN,
    REAL,
    STATUS,
    TRUE,
    Block,
    Const,
    Function,
    Load,
    Param,
    Program,
    Select,
    Status,
    Var,
    integer,
    real,
)
from stt_codegen.task import Task

OK, OUTSIDE, BAD = (Const(s, STATUS) for s in (Status.OK, Status.OUTSIDE_TUBE, Status.BAD_INPUT))
T = Var("t", REAL)  # seconds; the parameter of public functions


def adaptive_program(task: Task, design: AdaptiveDesign) -> Program:
    """Build all that is emitted for an adaptive or literal design. Raises `BadInput` when the law's constants do not fit."""
    parts = AdaptiveParts.of(task, design)
    n = parts.n
    return Program(
        prefix=task.name,
        dimension=n,
        scalar=task.emit.scalar,
        tables=(*build_adaptive_tables(parts), *parts.law.tables),
        kernels=(*parts.kernels.of_public_functions(parts.slots), *parts.law.kernels),
        functions=(
            _build_alpha_init(n),
            _build_alpha_step(parts),
            _build_alpha_rate(parts),
            _build_tube(parts),
            _build_tube_rate(parts),
            _build_control(task, parts),
            _build_margin(parts),
            _build_margins(parts),
            build_transform(parts.law, n),
        ),
    )


def _begin_block_with_alpha(n: int, nan_outputs: tuple[str, ...], length: int) -> Block:
    """Begin the block of a function of t and alpha: it leaves with NaN in the outputs, arrays of this length, for bad input."""
    block = Block({"t", "alpha", *nan_outputs})
    is_bad = write_has_non_finite(block, (T,), (("alpha", 2 * n),))
    with block.leave_when(is_bad), block.loop("m", length) as loop:
        for name in nan_outputs:
            block.store(name, loop.index, NAN)
    return block


def _write_alpha_index(block: Block, parts: AdaptiveParts, i: Var, side: int) -> Var:
    """Write statements for the index of dimension i in an array laid out as alpha: lower side by dimension, then upper side."""
    label = SIDE_LABELS[side][1]
    return block.op(f"{label}_out_at", "iadd", i, integer(parts.n)) if side else i


def _build_alpha_init(n: int) -> Function:
    """Build `alpha_init`, which sets all of alpha (2 n,) to 0."""
    block = Block({"alpha"})
    with block.loop("i", 2 * n) as loop:
        block.store("alpha", loop.index, real(0))
    block.leave()
    doc = ("Start of the update function: alpha(0) = 0 (11). alpha = [alpha_L by dimension, alpha_U by dimension].",)
    return Function("alpha_init", (Param("alpha", 2 * n, output=True),), tuple(block.statements), returns_status=False, doc=doc)


def _build_alpha_step(parts: AdaptiveParts) -> Function:
    """Build `alpha_step`, which makes one implicit Euler step of (11) by Newton's method, in place in alpha (2 n,)."""
    n = parts.n
    dt = Var("dt", REAL)
    block = Block({"t", "dt", "alpha"})
    is_bad = write_has_non_finite(block, (T, dt), (("alpha", 2 * n),))
    is_forward = block.op("forward", "lt", real(0), dt)
    with block.leave_when(block.op("stay", "or", is_bad, block.op("backward", "not", is_forward))):
        pass
    is_short = block.op("short_step", "lt", dt, real(LONGEST_STEP))
    h = block.select("h", is_short, dt, real(LONGEST_STEP))
    profile = write_time_profile(block, parts, block.op("later", "add", T, dt))
    with block.loop("i", n) as loop:
        rho_beta = write_rho_and_beta(block, parts, loop.index, profile)
        alphas = write_clamped_alphas(block, parts, loop.index)
        for (side, _), psi in zip(SIDE_LABELS, write_psi(block, rho_beta), strict=True):
            next_alpha = _write_implicit_step(block, parts, side, (psi, alphas[side], h))
            block.store("alpha", _write_alpha_index(block, parts, loop.index, side), next_alpha)
    block.leave()
    doc = (
        "One implicit (backward Euler) step of (11) from t to t + dt seconds; fixed cost, stable for every dt > 0. The new",
        "alpha replaces the given one (C) or is returned (Python); it is the given one when dt <= 0 or a number is not finite.",
        "Call it once after each control step. A late start begins at t = 0 too: alpha_init, then such steps up to that t.",
    )
    params = (Param("t", None), Param("dt", None), Param("alpha", 2 * n, output=True, inout=True))
    return Function("alpha_step", params, tuple(block.statements), returns_status=False, doc=doc)


def _write_implicit_step(block: Block, parts: AdaptiveParts, side: int, inputs: tuple[Var, Var, Var]) -> Var:
    """Write statements for the alpha of one side after an implicit step of (11), from (psi, alpha, step in seconds)."""
    label, kernels = SIDE_LABELS[side][1], parts.kernels
    names = [f"{label}_{v}" for v in ("p", "q", "theta_rest", "z_start")]
    p, q, theta_rest, z_start = block.call(kernels.implicit_start, *inputs, *parts.update_constants, names=names)
    with block.loop(f"{label}_k", adaptive_tube.NEWTON) as iteration:
        z = iteration.carry(f"{label}_z", z_start)
        (next_z,) = block.call(kernels.newton, p, q, z, names=(f"{label}_z_next",))
        iteration.update(z, next_z)
    (next_alpha,) = block.call(kernels.implicit_end, q, theta_rest, z, names=(f"alpha_{label}_out",))
    return next_alpha


def _build_alpha_rate(parts: AdaptiveParts) -> Function:
    """Build `alpha_rate`: the right side of (11) and its diagonal Jacobian, (2 n,) each."""
    n = parts.n
    block = _begin_block_with_alpha(n, ("rate", "jacobian"), 2 * n)
    profile = write_time_profile(block, parts, T)
    with block.loop("i", n) as loop:
        rho_beta = write_rho_and_beta(block, parts, loop.index, profile)
        alphas = write_clamped_alphas(block, parts, loop.index)
        for (side, label), psi in zip(SIDE_LABELS, write_psi(block, rho_beta), strict=True):
            names = (f"rate_{label}", f"jacobian_{label}")
            rate, jacobian = block.call(parts.kernels.update_rate, psi, alphas[side], *parts.update_constants, names=names)
            index = _write_alpha_index(block, parts, loop.index, side)
            block.store("rate", index, rate)
            block.store("jacobian", index, jacobian)
    block.leave()
    doc = (
        "Right side of the update equation (11) and its Jacobian d rate / d alpha (diagonal), laid out as alpha.",
        "For a solver of your own; `alpha_step` needs neither. NaN when a number is not finite.",
    )
    outputs = (Param("rate", 2 * n, output=True), Param("jacobian", 2 * n, output=True))
    params = (Param("t", None), Param("alpha", 2 * n), *outputs)
    return Function("alpha_rate", params, tuple(block.statements), returns_status=False, doc=doc)


def _build_tube(parts: AdaptiveParts) -> Function:
    """Build `tube`: the edges gamma (10), (n,) each."""
    n = parts.n
    block = _begin_block_with_alpha(n, ("lower", "upper"), n)
    profile = write_time_profile(block, parts, T)
    with block.loop("i", n) as loop:
        low, high = write_gamma(block, parts, loop.index, profile)
        block.store("lower", loop.index, low)
        block.store("upper", loop.index, high)
    block.leave()
    doc = (
        "Edges of the tube gamma (10) at time t (seconds) for the update function alpha, in the task's units.",
        "t below 0 counts as 0 and above t_c as t_c; NaN when t or alpha is not finite.",
    )
    params = (Param("t", None), Param("alpha", 2 * n), Param("lower", n, output=True), Param("upper", n, output=True))
    return Function("tube", params, tuple(block.statements), returns_status=False, doc=doc)


def _build_tube_rate(parts: AdaptiveParts) -> Function:
    """Build `tube_rate`: the total rates of the edges along (11), (n,) each."""
    n, kernels, nu = parts.n, parts.kernels, real(parts.design.nu)
    block = _begin_block_with_alpha(n, ("lower_rate", "upper_rate"), n)
    profile = write_time_profile(block, parts, T, with_rate=True)
    with block.loop("i", n) as loop:
        rho_beta = write_rho_and_beta(block, parts, loop.index, profile)
        assert rho_beta.rho_rate is not None
        assert rho_beta.beta_rate is not None
        alphas = write_clamped_alphas(block, parts, loop.index)
        for (side, label), psi in zip(SIDE_LABELS, write_psi(block, rho_beta), strict=True):
            names = (f"alpha_{label}_rate", f"jacobian_{label}")
            alpha_rate, _ = block.call(kernels.update_rate, psi, alphas[side], *parts.update_constants, names=names)
            kernel = kernels.lower_edge_rate if side == LOWER else kernels.upper_edge_rate
            values = (rho_beta.rho[side], alphas[side], rho_beta.beta[side])
            rates = (rho_beta.rho_rate[side], alpha_rate, rho_beta.beta_rate[side])
            _, rate = block.call(kernel, *values, nu, *rates, names=(f"gamma_{label}", f"gamma_{label}_rate"))
            block.store("lower_rate" if side == LOWER else "upper_rate", loop.index, rate)
    block.leave()
    doc = (
        "Total rate of the edges, d gamma / d t along (11), at time t (seconds), in units per second.",
        "Before 0 the rate at 0; from t_c on only alpha moves. NaN when t or alpha is not finite.",
    )
    outputs = (Param("lower_rate", n, output=True), Param("upper_rate", n, output=True))
    params = (Param("t", None), Param("alpha", 2 * n), *outputs)
    return Function("tube_rate", params, tuple(block.statements), returns_status=False, doc=doc)


def _build_control(task: Task, parts: AdaptiveParts) -> Function:
    """Build `control`: u (n,) by (13) and the status for the state x (n,) at time t."""
    n, law = parts.n, parts.law
    block = Block({"t", "alpha", "x", "u"})
    is_bad = write_has_non_finite(block, (T,), (("alpha", 2 * n), ("x", n)))
    with block.leave_when(is_bad, BAD), block.loop("m", n) as loop:
        block.store("u", loop.index, real(0))
    profile = write_time_profile(block, parts, T)
    with block.loop("i", n) as loop:
        i = loop.index
        is_outside = loop.carry("outside", FALSE)
        low, high = write_gamma(block, parts, i, profile)
        value = ValueBetweenEdges(low, high, block.let("x_i", Load("x", i)))
        u_max = law.write_u_max(block, i)
        distances = write_clamped_distances(block, law.write_clamp_share(block, i), value, law.write_signed_gain(block, i))
        loop.update(is_outside, block.select("outside_next", write_is_inside(block, distances), is_outside, TRUE))
        block.store("u", i, write_input(block, law, distances, u_max))
    block.leave(Select(is_outside, OUTSIDE, OK))
    doc = (
        law_doc(task, law),
        "t: seconds since the start (held within [0, t_c]); alpha: the update function at t; x: state; u: input.",
        *axes_doc(task),
        "OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward"
        + inward_doc(task),
        "(0 where the tube is empty). BAD_INPUT: t, alpha or x has a NaN or an infinity; u is 0. u may be the array x itself.",
    )
    params = (Param("t", None), Param("alpha", 2 * n), Param("x", n), Param("u", n, output=True))
    return Function("control", params, tuple(block.statements), returns_status=True, doc=doc)


def _write_margin_at(block: Block, parts: AdaptiveParts, i: Var, profile: TimeProfile) -> Var:
    """Write statements for the margin of component i of x."""
    low, high = write_gamma(block, parts, i, profile)
    return write_margin(block, ValueBetweenEdges(low, high, block.let("x_i", Load("x", i))))


def _build_margin(parts: AdaptiveParts) -> Function:
    """Build `margin`: the smallest margin over the components of x."""
    n = parts.n
    block = Block({"t", "alpha", "x"})
    is_bad = write_has_non_finite(block, (T,), (("alpha", 2 * n), ("x", n)))
    with block.leave_when(is_bad, NAN):
        pass
    profile = write_time_profile(block, parts, T)
    with block.loop("i", n) as loop:
        smallest = loop.carry("margin", real(Fraction(1, 2)))
        margin = _write_margin_at(block, parts, loop.index, profile)
        is_smaller = block.op("less", "lt", margin, smallest)
        loop.update(smallest, block.select("margin_next", is_smaller, margin, smallest))
    block.leave(smallest)
    params = (Param("t", None), Param("alpha", 2 * n), Param("x", n))
    return Function("margin", params, tuple(block.statements), returns_status=False, doc=MARGIN_DOC, returns_real=True)


def _build_margins(parts: AdaptiveParts) -> Function:
    """Build `margins`: the margin by component (n,)."""
    n = parts.n
    block = Block({"t", "alpha", "x", "margin"})
    is_bad = write_has_non_finite(block, (T,), (("alpha", 2 * n),))
    with block.leave_when(is_bad), block.loop("m", n) as loop:
        block.store("margin", loop.index, NAN)
    profile = write_time_profile(block, parts, T)
    with block.loop("i", n) as loop:
        block.store("margin", loop.index, _write_margin_at(block, parts, loop.index, profile))
    block.leave()
    params = (Param("t", None), Param("alpha", 2 * n), Param("x", n), Param("margin", n, output=True))
    return Function("margins", params, tuple(block.statements), returns_status=False, doc=MARGINS_DOC)
