"""Prescribed performance as a peer: the paper's ancestors [11] and [12] (Bechlioulis and Rovithakis, 2008 and 2014), for order 1.

They keep a state near a given trajectory x_d, within a funnel that narrows, whatever f and g are:

    |x_i - x_d,i(t)| < rho(t) = (rho_0 - rho_inf) exp(-RATE t) + rho_inf,    u_i = -k xi_i eps_i

so where to go, and how wide the funnel may be so that it meets no unsafe set, is somebody else's to find: here a way by A*, at an
even speed, off the squares by the largest of CLEARANCES that leaves one, which is rho_inf. rho_0 takes the whole initial set in.
The law is (13) of the paper, in double precision, called at every sample. Of order 2 their cascade stands in `cascade`.

[16] (Mehdifar, Bechlioulis and Dimarogonas, 2022) asks for hard bounds by component that are off the unsafe sets already,
which is what a tube is; its adaptation is the paper's alpha, and the adaptive tube stands for it. [19] (Das and Jagtap,
2023) is what the paper replaces: the same circumvent functions, no prescribed time, and g in its law; the literal tube
stands for it.
"""

from __future__ import annotations

import numpy as np

from benchmarks.peers.driven import held
from benchmarks.peers.optional import need
from benchmarks.suites.families import BOX, Array, Family
from stt_codegen.loop.compiled import LoadedController
from stt_codegen.program.targets.template_files import template

CLEARANCES = (0.25, 0.2, 0.15, 0.1, 0.075, 0.05)
CELLS = 200  # of the grid of the way, along an axis
START = 0.26  # rho_0 at least: half the start's box, and what the grid is off its middle
RATE = 2.0  # 1/s
GAIN = 0.25  # of rho_inf: u is 2 GAIN ln(9) / (1 - e^2) for e = 0.8, which a wind of 0.3 and the way's speed ask for
LAST = 8.0  # seconds in which the way is gone


def way(family: Family, squares: Array) -> tuple[Array, float] | None:
    """The way's points, (P, 2), and by how much, in the largest component, it is off all squares; None without one."""
    found = ((grid_way(family, squares, CELLS, off), off) for off in CLEARANCES)
    return next(((points, off) for points, off in found if points is not None), None)


def grid_way(family: Family, squares: Array, cells: int, off: float = 0.0) -> Array | None:
    """pyastar2d's A* from the start's middle to the target's over cells + 1 grid points an axis: points, (P, 2), that are
    `off`, in the largest component, from the squares and the room's edges. Squares grow by half a cell more, so that no diagonal
    step cuts a corner."""
    axis = np.linspace(0.0, family.side, cells + 1)
    start, goal = (int(np.argmin(abs(axis - v))) for v in (BOX / 2, family.side - BOX / 2))
    weights = np.ones((cells + 1, cells + 1), dtype=np.float32)
    for box in squares + (off + family.side / cells / 2) * np.array([-1.0, 1.0]):
        weights[np.ix_(*((low <= axis) & (axis <= high) for low, high in box))] = np.inf
    for edge in (axis < off, axis > family.side - off):
        weights[edge, :] = weights[:, edge] = np.inf
    if not np.isfinite(weights[[start, goal], [start, goal]]).all():
        return None
    path = need("pyastar2d").astar_path(weights, (start, start), (goal, goal), allow_diagonal=True)
    return None if path is None else axis[path]


def funnel(family: Family, squares: Array, tube: object) -> LoadedController | None:
    """The controller for the loops; tube: what margins are told by. None where there is no way."""
    found = way(family, squares)
    if found is None:
        return None
    points, narrow = found
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    times = lengths / lengths[-1] * LAST
    keep = _corners(points)
    text = template("bench/funnel.c.j2").render(
        points=points[keep].tolist(),
        times=times[keep].tolist(),
        wide=max(START, narrow),
        narrow=narrow,
        rate=RATE,
        gain=GAIN * narrow,
    )
    return held(text, 2, 1e6, tube, "double")


def _corners(points: Array) -> list[int]:
    """The points at which the way turns, and its ends."""
    steps = np.diff(points, axis=0)
    turns = np.any(abs(np.diff(steps, axis=0)) > 1e-9, axis=1)
    return [0, *(np.nonzero(turns)[0] + 1).tolist(), len(points) - 1]
