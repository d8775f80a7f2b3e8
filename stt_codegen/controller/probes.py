"""Programs over the kernels of an adaptive controller that are never emitted: what `compare` holds against the reference between
the public functions, and what the certificate encloses."""

from __future__ import annotations

from stt_codegen.controller.kernels import Frame, control_law_of, kernels_of_the_paper, lines_of, profile, psi_of, tables_of
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign
from stt_codegen.program import REAL, Block, Function, Param, Program, Var, integer
from stt_codegen.task import Task


def probe_program(task: Task, design: AdaptiveDesign) -> Program:
    """A program that returns what no emitted function does: sigma, rho, beta, psi, theta. For `compare`, never committed."""
    frame = Frame(design, kernels_of_the_paper(), control_law_of(task), task.emit.scalar)
    tables = tables_of(frame)
    names = {"hold", "profile", "reach_edge", "theta"} | ({"circumvent"} if any(frame.slots) else set())
    names |= {"join"} if max(frame.slots) > 1 else set()
    kernels = tuple(k for name, k in vars(frame.kernels).items() if name in names)
    return Program(task.name, frame.n, task.emit.scalar, tuple(tables), kernels, functions=(_probe(frame),))


def lines_program(task: Task, design: AdaptiveDesign) -> Program:
    """What the certificate encloses, from the kernels that are printed: rho, beta, psi; and theta, the edges, bumps' rates."""
    frame = Frame(design, kernels_of_the_paper(), control_law_of(task), task.emit.scalar)
    names = {"hold", "profile", "reach_edge", "theta", "lower_edge", "upper_edge", "circumvent", "circumvent_rate", "join"}
    kernels = tuple(k for name, k in vars(frame.kernels).items() if name in names)
    tables = tuple(tables_of(frame))
    return Program(task.name, frame.n, task.emit.scalar, tables, kernels, functions=(_lines(frame),))


def _probe(frame: Frame) -> Function:
    n = frame.n
    names = ("sigma", "rho", "beta", "psi", "theta")
    block = Block({"t", *names})
    held, sigma, _ = profile(block, frame, Var("t", REAL), False)
    block.store("sigma", integer(0), sigma)
    theta0, _, mu, varsigma = frame.update
    with block.loop("i", n) as loop:
        lines = lines_of(block, frame, loop.index, held, sigma, None)
        for side, label, psi in zip((LOWER, UPPER), ("low", "high"), psi_of(block, lines), strict=True):
            at = block.op(f"{label}_out_at", "iadd", loop.index, integer(n)) if side else loop.index
            (theta,) = block.call(frame.kernels.theta, psi, theta0, mu, varsigma, names=(f"theta_{label}",))
            for name, value in (("rho", lines.rho[side]), ("beta", lines.beta[side]), ("psi", psi), ("theta", theta)):
                block.store(name, at, value)
    block.leave()
    params = (Param("t", None), Param("sigma", n, True), *(Param(p, 2 * n, True) for p in names[1:]))
    return Function("probe", params, tuple(block.statements), False, ("sigma[0], and rho, beta, psi, theta laid out as alpha.",))


def _lines(frame: Frame) -> Function:
    """rho, beta and psi at time t, each laid out as alpha."""
    n = frame.n
    names = ("rho", "beta", "psi")
    block = Block({"t", *names})
    held, sigma, _ = profile(block, frame, Var("t", REAL), False)
    with block.loop("i", n) as loop:
        lines = lines_of(block, frame, loop.index, held, sigma, None)
        psi = psi_of(block, lines)
        for side, label in ((LOWER, "low"), (UPPER, "high")):
            at = block.op(f"{label}_out_at", "iadd", loop.index, integer(n)) if side else loop.index
            for name, pair in zip(names, (lines.rho, lines.beta, psi), strict=True):
                block.store(name, at, pair[side])
    block.leave()
    return Function("lines", (Param("t", None), *(Param(p, 2 * n, True) for p in names)), tuple(block.statements), False)
