"""Predictive control as a peer: a quadratic program at every step, solved by OSQP's generated C, with our tube and without.

Over STEPS samples, STEP seconds apart, u and slacks s minimize

    sum |x_k - r_k|^2 + PUSH |u_k|^2 + SOFT |s_k|^2,
    x_k = x_0 + STEP sum u,    low_k - s_k <= x_k <= high_k + s_k,    |u_i| <= u_max

with the tube: r_k its middle, low_k and high_k its edges, a tenth of the width inside. Without: r_k the target's middle, and for
every unsafe square the side that the last plan is farthest beyond is not to be crossed, MARGIN away from it: the usual way
to make a program convex that is not. Slacks make every program solvable.
"""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable
from functools import cache

import numpy as np

from benchmarks.peers.driven import held
from benchmarks.peers.quadratic import generated_solver, includes
from benchmarks.suites.families import BOX, Array, Family
from stt_codegen.loop.compiled import LoadedController
from stt_codegen.program.targets.template_files import template

STEPS, STEP = 20, 0.05
PUSH, MARGIN = 0.01, 0.1
SOFT = {"tube": 1e2, "goal": 1e3}  # the harder, the more often kept, and the longer to solve
INSET = 0.1  # of the tube's width
U_MAX = {"tube": 3.0, "goal": 1.0}  # a tube may ask for more than the way does; quicker to the goal is more often wrong


def program(soft: float) -> tuple[Array, Array]:
    """The program's matrices for both axes: of the cost, (V, V), and of the rows, (R, V). Variables: u by axis, then s."""
    sums = STEP * np.tril(np.ones((STEPS, STEPS)))
    one, none = np.eye(STEPS), np.zeros((STEPS, STEPS))
    axes = np.eye(2)
    cost = np.block([[np.kron(axes, 2 * (sums.T @ sums + PUSH * one)), np.kron(axes, none)],
                     [np.kron(axes, none), np.kron(axes, 2 * soft * one)]])  # fmt: skip
    rows = np.block([[np.kron(axes, sums), np.kron(axes, one)], [np.kron(axes, sums), np.kron(axes, -one)],
                     [np.kron(axes, one), np.kron(axes, none)]])  # fmt: skip
    return cost, rows


@cache
def _generated(soft: float) -> tempfile.TemporaryDirectory[str]:
    return generated_solver(*program(soft), "vectors", "mpc_", eps_abs=1e-3, eps_rel=1e-3)


def predictive(family: Family, squares: Array, tube: Callable[..., object], with_tube: bool) -> LoadedController:
    """The controller for the loops. tube: `loop_own_tube` of our controller, whose edges it follows or that margins are told
    by."""
    kind = "tube" if with_tube else "goal"
    folder = _generated(SOFT[kind]).name
    text = template("bench/mpc.c.j2").render(
        steps=STEPS, step=STEP, push=PUSH, margin=MARGIN, inset=INSET, with_tube=with_tube, side=family.side,
        u_max=U_MAX[kind], goal=family.side - BOX / 2, boxes=squares.tolist(),
    )  # fmt: skip
    own = held(text, 2, 1 / STEP, tube, "double", [*includes(folder), f"{folder}/osqp.o"])
    own.library.use_tube(ctypes.cast(tube, ctypes.c_void_p))  # type: ignore[arg-type]
    return own
