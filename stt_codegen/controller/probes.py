"""Programs over the kernels of an adaptive controller that are never emitted.

`compare` holds the results of `probe_program` against the reference, since no public function returns them. The certificate
(certify/adaptive/enclosure.py) encloses the results of `lines_program`. Strings passed to a block are names in the program.
"""

from __future__ import annotations

from stt_codegen.controller.kernels import (
    SIDE_LABELS,
    AdaptiveParts,
    build_adaptive_tables,
    write_psi,
    write_rho_and_beta,
    write_time_profile,
)
from stt_codegen.designs import AdaptiveDesign
from stt_codegen.program import REAL, Block, Function, Param, Program, Var, integer
from stt_codegen.task import Task


def probe_program(task: Task, design: AdaptiveDesign) -> Program:
    """Build a program whose function `probe` returns sigma, rho, beta, psi and theta at a time t."""
    parts = AdaptiveParts.of(task, design)
    kernel_names = {"hold", "profile", "reach_edge", "theta"} | ({"circumvent"} if any(parts.slots) else set())
    kernel_names |= {"join"} if max(parts.slots) > 1 else set()
    return _build_program(task, parts, kernel_names, _build_probe(parts))


def lines_program(task: Task, design: AdaptiveDesign) -> Program:
    """Build a program whose function `lines` returns rho, beta and psi at a time t.

    It also has the kernels of theta, of the edges and of the bumps' rates, which the certificate evaluates one by one."""
    parts = AdaptiveParts.of(task, design)
    kernel_names = {"hold", "profile", "reach_edge", "theta", "lower_edge", "upper_edge", "circumvent", "circumvent_rate", "join"}
    return _build_program(task, parts, kernel_names, _build_lines(parts))


def _build_program(task: Task, parts: AdaptiveParts, kernel_names: set[str], function: Function) -> Program:
    """Build a program of one function and the kernels of these names."""
    tables = tuple(build_adaptive_tables(parts))
    kernels = tuple(k for name, k in vars(parts.kernels).items() if name in kernel_names)
    return Program(task.name, parts.n, task.emit.scalar, tables, kernels, functions=(function,))


def _build_probe(parts: AdaptiveParts) -> Function:
    """Build `probe`: sigma in profile[0], and rho, beta, psi, theta (2 n,), lower side by dimension, then upper side."""
    n = parts.n
    names = ("profile", "rho", "beta", "psi", "theta")
    block = Block({"t", *names})
    profile = write_time_profile(block, parts, Var("t", REAL))
    block.store("profile", integer(0), profile.sigma)
    theta0, _, mu, varsigma = parts.update_constants
    with block.loop("i", n) as loop:
        rho_beta = write_rho_and_beta(block, parts, loop.index, profile)
        for (side, label), psi in zip(SIDE_LABELS, write_psi(block, rho_beta), strict=True):
            index = block.op(f"{label}_out_at", "iadd", loop.index, integer(n)) if side else loop.index
            (theta,) = block.call(parts.kernels.theta, psi, theta0, mu, varsigma, names=(f"theta_{label}",))
            outputs = (("rho", rho_beta.rho[side]), ("beta", rho_beta.beta[side]), ("psi", psi), ("theta", theta))
            for name, value in outputs:
                block.store(name, index, value)
    block.leave()
    params = (Param("t", None), Param("profile", n, output=True), *(Param(p, 2 * n, output=True) for p in names[1:]))
    doc = ("sigma in profile[0], and rho, beta, psi, theta laid out as alpha.",)
    return Function("probe", params, tuple(block.statements), returns_status=False, doc=doc)


def _build_lines(parts: AdaptiveParts) -> Function:
    """Build `lines`: rho, beta and psi (2 n,) at time t, lower side by dimension, then upper side."""
    n = parts.n
    names = ("rho", "beta", "psi")
    block = Block({"t", *names})
    profile = write_time_profile(block, parts, Var("t", REAL))
    with block.loop("i", n) as loop:
        rho_beta = write_rho_and_beta(block, parts, loop.index, profile)
        psi = write_psi(block, rho_beta)
        for side, label in SIDE_LABELS:
            index = block.op(f"{label}_out_at", "iadd", loop.index, integer(n)) if side else loop.index
            for name, pair in zip(names, (rho_beta.rho, rho_beta.beta, psi), strict=True):
                block.store(name, index, pair[side])
    block.leave()
    params = (Param("t", None), *(Param(p, 2 * n, output=True) for p in names))
    return Function("lines", params, tuple(block.statements), returns_status=False)
