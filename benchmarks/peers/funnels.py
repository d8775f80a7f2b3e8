"""Prescribed performance as a peer: the paper's ancestors [11] and [12] (Bechlioulis and Rovithakis, 2008 and 2014), for order 1.

They keep a state near a given trajectory x_d, within a funnel that narrows, whatever f and g are:

    |x_i - x_d,i(t)| < rho(t) = (rho_0 - rho_inf) exp(-RATE t) + rho_inf,    u_i = -k xi_i eps_i

A planner must find the trajectory, and how wide the funnel may be so that it meets no unsafe set. Here A* finds a way, which is
followed at an even speed. It stays clear of the squares by the largest of CLEARANCES that leaves a way, which is rho_inf. rho_0
is large enough for the initial set. The law is (13) of the paper, in double precision, called at every sample. `cascade.py` has
their cascade for plants of order 2; `in_loops` runs this peer.

[16] (Mehdifar, Bechlioulis and Dimarogonas, 2022) needs hard bounds by component that already avoid the unsafe sets, which is
what a tube is; its adaptation is the paper's alpha, and the adaptive tube stands for it. [19] (Das and Jagtap, 2023) is what the
paper replaces: the same circumvent functions, no prescribed time, and g in its law; the literal tube stands for it.
"""

from __future__ import annotations

import numpy as np

from benchmarks.peers.driven import compile_peer
from benchmarks.peers.optional import need
from benchmarks.suites.families import BOX, Array, Family
from stt_codegen.loop.compiled import LoadedController
from stt_codegen.program.targets.template_files import template

CLEARANCES = (0.25, 0.2, 0.15, 0.1, 0.075, 0.05)
CELLS = 200  # of A*'s grid, along an axis
SMALLEST_START_RADIUS = 0.26  # of rho_0: half the start's box, and the distance of the nearest grid point from its middle
RATE = 2.0  # 1/s
GAIN = 0.25  # of rho_inf: u is 2 GAIN ln(9) / (1 - e^2) for e = 0.8, enough for a wind of 0.3 and the way's speed
WAY_SECONDS = 8.0  # until the end of the way


def clearest_way(family: Family, squares: Array) -> tuple[Array, float] | None:
    """Return the way's points, (P, 2), and its clearance, in the largest component, from all squares; None without a way."""
    ways = ((grid_way(family, squares, CELLS, clearance), clearance) for clearance in CLEARANCES)
    return next(((points, clearance) for points, clearance in ways if points is not None), None)


def grid_way(family: Family, squares: Array, cells: int, clearance: float = 0.0) -> Array | None:
    """Plan with pyastar2d's A* from the start's middle to the target's over cells + 1 grid points an axis.

    Returns points, (P, 2), with this clearance, in the largest component, from the squares and the walls; None without a way.
    Squares grow by half a cell more, so that no diagonal step cuts a corner."""
    axis = np.linspace(0.0, family.side, cells + 1)
    start, goal = (int(np.argmin(abs(axis - v))) for v in (BOX / 2, family.side - BOX / 2))
    weights = np.ones((cells + 1, cells + 1), dtype=np.float32)
    for box in squares + (clearance + family.side / cells / 2) * np.array([-1.0, 1.0]):
        weights[np.ix_(*((low <= axis) & (axis <= high) for low, high in box))] = np.inf
    for edge in (axis < clearance, axis > family.side - clearance):
        weights[edge, :] = weights[:, edge] = np.inf
    if not np.isfinite(weights[[start, goal], [start, goal]]).all():
        return None
    path = need("pyastar2d").astar_path(weights, (start, start), (goal, goal), allow_diagonal=True)
    return None if path is None else axis[path]


def funnel(family: Family, squares: Array, tube: object) -> LoadedController | None:
    """Compile the controller for the loops; None where there is no way. tube: the edges by which margins are measured."""
    way = clearest_way(family, squares)
    if way is None:
        return None
    points, rho_inf = way
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    times = lengths / lengths[-1] * WAY_SECONDS
    turns = _turning_points(points)
    text = template("bench/funnel.c.j2").render(
        points=points[turns].tolist(),
        times=times[turns].tolist(),
        first_radius=max(SMALLEST_START_RADIUS, rho_inf),
        final_radius=rho_inf,
        decay_rate=RATE,
        gain=GAIN * rho_inf,
    )
    return compile_peer(text, 2, 1e6, tube, real="double")


def _turning_points(points: Array) -> list[int]:
    """Return the numbers of the points at which the way turns, and of its ends."""
    steps = np.diff(points, axis=0)
    is_turn = np.any(abs(np.diff(steps, axis=0)) > 1e-9, axis=1)
    return [0, *(np.nonzero(is_turn)[0] + 1).tolist(), len(points) - 1]
