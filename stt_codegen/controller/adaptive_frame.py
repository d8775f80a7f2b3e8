"""The frame of an adaptive or literal controller: alpha kept by the caller, tube from (4)-(11), law (13).

Which numbers are data and which are code: what there is once for every dimension or every circumvent function (X0hat, That, the
walls, and B, k, m, r of every bump) stands in tables that a loop reads, so a thousand unsafe sets add rows and no code; what
there is once for the whole task (t_c, theta0, kappa, mu, varsigma, nu, k of the law) is passed to the kernels as constants.
Every dimension has the same number of rows in the table of bumps, lower and upper side each, filled up with bumps of height 0, so
that the loops' bounds are constants and every step costs the same.
"""

from __future__ import annotations

from fractions import Fraction

from stt_codegen.controller.comments import axes_doc, inward_doc, law_doc
from stt_codegen.controller.kernels import (
    LONGEST_STEP,
    MARGIN_DOC,
    MARGINS_DOC,
    Between,
    Frame,
    alphas_of,
    control_component,
    control_law_of,
    edges_of,
    inside_of,
    kernels_of_the_paper,
    lines_of,
    margin_component,
    not_finite,
    place_of,
    profile,
    psi_of,
    tables_of,
    transform_function,
)
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign
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


def adaptive_program(task: Task, design: AdaptiveDesign) -> Program:
    """Everything that is emitted for an adaptive or literal design. Raises `BadInput` when the law's constants do not fit."""
    frame = Frame(design, kernels_of_the_paper(), control_law_of(task), task.emit.scalar)
    n = frame.n
    return Program(
        prefix=task.name,
        dimension=n,
        scalar=task.emit.scalar,
        tables=(*tables_of(frame), *frame.law.tables),
        kernels=(*frame.kernels.emitted(frame.slots), *frame.law.kernels),
        functions=(
            _alpha_init(n),
            _alpha_step(frame),
            _alpha_rate(frame),
            _tube(frame),
            _tube_rate(frame),
            _control(task, frame),
            _margin(frame),
            _margins(frame),
            transform_function(frame.law, n),
        ),
    )


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
    bad = not_finite(block, (Var("t", REAL), Var("dt", REAL)), (("alpha", 2 * n),))
    forward = block.op("forward", "lt", real(0), Var("dt", REAL))
    with block.leave_when(block.op("stay", "or", bad, block.op("backward", "not", forward))):
        pass
    short = block.op("short_step", "lt", Var("dt", REAL), real(LONGEST_STEP))
    h = block.select("h", short, Var("dt", REAL), real(LONGEST_STEP))
    held, sigma, _ = profile(block, frame, block.op("later", "add", Var("t", REAL), Var("dt", REAL)), False)
    with block.loop("i", n) as loop:
        lines = lines_of(block, frame, loop.index, held, sigma, None)
        before = alphas_of(block, frame, loop.index)
        for side, name, psi in zip((LOWER, UPPER), ("low", "high"), psi_of(block, lines), strict=True):
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
        "One implicit (backward Euler) step of (11) from t to t + dt seconds; fixed cost, stable for every dt > 0. The new",
        "alpha replaces the given one (C) or is returned (Python); it is the given one when dt <= 0 or a number is not finite.",
        "Call it once after each control step. A late start begins at t = 0 too: alpha_init, then such steps up to that t.",
    )
    params = (Param("t", None), Param("dt", None), Param("alpha", 2 * n, True, True))
    return Function("alpha_step", params, tuple(block.statements), False, doc)


def _alpha_rate(frame: Frame) -> Function:
    n = frame.n
    block = Block({"t", "alpha", "rate", "jacobian"})
    bad = not_finite(block, (Var("t", REAL),), (("alpha", 2 * n),))
    with block.leave_when(bad), block.loop("j", 2 * n) as loop:
        block.store("rate", loop.index, NAN)
        block.store("jacobian", loop.index, NAN)
    held, sigma, _ = profile(block, frame, Var("t", REAL), False)
    with block.loop("i", n) as loop:
        lines = lines_of(block, frame, loop.index, held, sigma, None)
        alphas = alphas_of(block, frame, loop.index)
        for side, name, psi in zip((LOWER, UPPER), ("low", "high"), psi_of(block, lines), strict=True):
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


def _tube(frame: Frame) -> Function:
    n = frame.n
    block = Block({"t", "alpha", "lower", "upper"})
    bad = not_finite(block, (Var("t", REAL),), (("alpha", 2 * n),))
    with block.leave_when(bad), block.loop("j", n) as loop:
        block.store("lower", loop.index, NAN)
        block.store("upper", loop.index, NAN)
    held, sigma, _ = profile(block, frame, Var("t", REAL), False)
    with block.loop("i", n) as loop:
        lines = lines_of(block, frame, loop.index, held, sigma, None)
        low, high = edges_of(block, frame, lines, alphas_of(block, frame, loop.index))
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
    bad = not_finite(block, (Var("t", REAL),), (("alpha", 2 * n),))
    with block.leave_when(bad), block.loop("j", n) as loop:
        block.store("lower_rate", loop.index, NAN)
        block.store("upper_rate", loop.index, NAN)
    held, sigma, sigma_rate = profile(block, frame, Var("t", REAL), True)
    with block.loop("i", n) as loop:
        lines = lines_of(block, frame, loop.index, held, sigma, sigma_rate)
        assert lines.rho_rate is not None
        assert lines.beta_rate is not None
        alphas = alphas_of(block, frame, loop.index)
        for side, name, psi in zip((LOWER, UPPER), ("low", "high"), psi_of(block, lines), strict=True):
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
    bad = not_finite(block, (Var("t", REAL),), (("alpha", 2 * n), ("x", n)))
    with block.leave_when(bad, BAD), block.loop("j", n) as loop:
        block.store("u", loop.index, real(0))
    held, sigma, _ = profile(block, frame, Var("t", REAL), False)
    with block.loop("i", n) as loop:
        i = loop.index
        outside = loop.carry("outside", FALSE)
        low, high = edges_of(block, frame, lines_of(block, frame, i, held, sigma, None), alphas_of(block, frame, i))
        x = block.let("x_i", Load("x", i))
        u_max = law.limit(block, i)
        place = place_of(block, law.share(block, i), Between(low, high, x), law.signed_gain(block, i))
        loop.update(outside, block.select("outside_any", inside_of(block, place), outside, TRUE))
        block.store("u", i, control_component(block, law, place, u_max))
    block.leave(Select(outside, OUTSIDE, OK))
    doc = (
        law_doc(task, law),
        "t: seconds since the start (held within [0, t_c]); alpha: the update function at t; x: state; u: input.",
        *axes_doc(task),
        "OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward"
        + inward_doc(task),
        "(0 where the tube is empty). BAD_INPUT: t, alpha or x has a NaN or an infinity; u is 0. u may be the array x itself.",
    )
    params = (Param("t", None), Param("alpha", 2 * n), Param("x", n), Param("u", n, True))
    return Function("control", params, tuple(block.statements), True, doc)


def _margin(frame: Frame) -> Function:
    n = frame.n
    block = Block({"t", "alpha", "x"})
    bad = not_finite(block, (Var("t", REAL),), (("alpha", 2 * n), ("x", n)))
    with block.leave_when(bad, NAN):
        pass
    held, sigma, _ = profile(block, frame, Var("t", REAL), False)
    with block.loop("i", n) as loop:
        i = loop.index
        least = loop.carry("margin", real(Fraction(1, 2)))
        low, high = edges_of(block, frame, lines_of(block, frame, i, held, sigma, None), alphas_of(block, frame, i))
        share = margin_component(block, Between(low, high, block.let("x_i", Load("x", i))))
        loop.update(least, block.select("margin_next", block.op("less", "lt", share, least), share, least))
    block.leave(least)
    params = (Param("t", None), Param("alpha", 2 * n), Param("x", n))
    return Function("margin", params, tuple(block.statements), False, MARGIN_DOC, returns_real=True)


def _margins(frame: Frame) -> Function:
    """The public `margins`: the margin by component."""
    n = frame.n
    block = Block({"t", "alpha", "x", "margin"})
    bad = not_finite(block, (Var("t", REAL),), (("alpha", 2 * n),))
    with block.leave_when(bad), block.loop("j", n) as loop:
        block.store("margin", loop.index, NAN)
    held_time, sigma, _ = profile(block, frame, Var("t", REAL), False)
    with block.loop("i", n) as loop:
        i = loop.index
        low, high = edges_of(block, frame, lines_of(block, frame, i, held_time, sigma, None), alphas_of(block, frame, i))
        block.store("margin", i, margin_component(block, Between(low, high, block.let("x_i", Load("x", i)))))
    block.leave()
    params = (Param("t", None), Param("alpha", 2 * n), Param("x", n), Param("margin", n, True))
    return Function("margins", params, tuple(block.statements), False, MARGINS_DOC)
