"""Predictive control as a peer: a quadratic program at every step, solved by OSQP's generated C, with our tube and without.

Over STEPS samples, STEP_SECONDS apart, u and slacks s minimize

    sum |x_k - r_k|^2 + INPUT_WEIGHT |u_k|^2 + SLACK_WEIGHTS |s_k|^2,
    x_k = x_0 + STEP_SECONDS sum u,    low_k - s_k <= x_k <= high_k + s_k,    |u_i| <= u_max

With the tube r_k is its middle, and low_k and high_k are its edges, a tenth of the width inside. Without it r_k is the target's
middle, and x_k must not cross, for every unsafe square, the side that the last plan is farthest beyond, MARGIN away from it: the
usual way to make the program convex. Slacks make every program solvable. `in_loops` runs both.
"""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable
from functools import cache

import numpy as np

from benchmarks.peers.driven import compile_peer
from benchmarks.peers.quadratic import generated_solver, includes
from benchmarks.suites.families import BOX, Array, Family
from stt_codegen.loop.compiled import LoadedController
from stt_codegen.program.targets.template_files import template

STEPS = 20
STEP_SECONDS = 0.05
INPUT_WEIGHT = 0.01
MARGIN = 0.1  # from unsafe squares
SLACK_WEIGHTS = {"tube": 1e2, "goal": 1e3}  # a larger weight keeps the bounds more often, and takes longer to solve
INSET = 0.1  # of the tube's width
U_MAX = {"tube": 3.0, "goal": 1.0}  # a tube may need more than the straight way; with more, the way to the goal is less safe


def program_matrices(slack_weight: float) -> tuple[Array, Array]:
    """Return the program's matrices for both axes: of the cost, (V, V), and of the rows, (R, V). Variables: u by axis, then s."""
    sums = STEP_SECONDS * np.tril(np.ones((STEPS, STEPS)))
    identity, zero = np.eye(STEPS), np.zeros((STEPS, STEPS))
    axes = np.eye(2)
    cost = np.block([[np.kron(axes, 2 * (sums.T @ sums + INPUT_WEIGHT * identity)), np.kron(axes, zero)],
                     [np.kron(axes, zero), np.kron(axes, 2 * slack_weight * identity)]])  # fmt: skip
    rows = np.block([[np.kron(axes, sums), np.kron(axes, identity)], [np.kron(axes, sums), np.kron(axes, -identity)],
                     [np.kron(axes, identity), np.kron(axes, zero)]])  # fmt: skip
    return cost, rows


@cache
def _generated_solver(slack_weight: float) -> tempfile.TemporaryDirectory[str]:
    return generated_solver(*program_matrices(slack_weight), "vectors", "mpc_", eps_abs=1e-3, eps_rel=1e-3)


def predictive(family: Family, squares: Array, tube: Callable[..., object], with_tube: bool) -> LoadedController:
    """Compile the controller for the loops. tube: `loop_own_tube` of our controller, whose edges it follows, with_tube, and by
    which margins are measured."""
    kind = "tube" if with_tube else "goal"
    folder = _generated_solver(SLACK_WEIGHTS[kind]).name
    text = template("bench/mpc.c.j2").render(
        steps=STEPS, step=STEP_SECONDS, push=INPUT_WEIGHT, margin=MARGIN, inset=INSET, with_tube=with_tube, side=family.side,
        u_max=U_MAX[kind], goal=family.side - BOX / 2, boxes=squares.tolist(),
    )  # fmt: skip
    arguments = [*includes(folder), f"{folder}/osqp.o"]
    controller = compile_peer(text, 2, 1 / STEP_SECONDS, tube, real="double", compiler_arguments=arguments)
    controller.library.use_tube(ctypes.cast(tube, ctypes.c_void_p))  # type: ignore[arg-type]
    return controller
