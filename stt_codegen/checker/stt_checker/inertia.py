"""Plants of order 2: the law holds v + lambda x in the filtered tube, between L' + lambda L and R' + lambda R. P1, P2 and P8 of
it."""

import itertools
import math
from fractions import Fraction
from typing import Any

from .exact import require
from .law import Law
from .limits import input_margins
from .task import NARROWEST_WIDTH
from .tube import Piece, Tube, take_claim


def filtered_tube(task: Any, tube: Tube, filters: list[Fraction]) -> tuple[list[Piece], list[Piece]]:
    """Return the edges of v + lambda x, and what the tube's motion asks of u at each of them: lambda^2 (R - L) + L'' and
    lambda^2 (R - L) - R''. Both as Bezier coefficients of degree 3 in the task's units."""
    k, edges, demands = tube.segments / task.t_c, [], []
    for piece in tube.pieces:
        edge_pairs, demand_pairs = list[Any](), list[Any]()
        for (low, high), s in zip(piece, filters, strict=True):
            edge, demand = [], []
            for c, sign in ((low, 1), (high, -1)):
                d = [b - a for a, b in itertools.pairwise(c)]
                e = [b - a for a, b in itertools.pairwise(d)]
                rate = (3 * d[0], d[0] + 2 * d[1], 2 * d[1] + d[2], 3 * d[2])  # the derivative, raised to degree 3
                bend = (6 * e[0], 4 * e[0] + 2 * e[1], 2 * e[0] + 4 * e[1], 6 * e[1])  # the second one, likewise
                edge.append([(k * r + s * v) * tube.unit for r, v in zip(rate, c, strict=True)])
                demand.append([(s * s * (h - v) + sign * k * k * b) * tube.unit for v, h, b in zip(low, high, bend, strict=True)])
            edge_pairs.append((edge[0], edge[1]))
            demand_pairs.append((demand[0], demand[1]))
        edges.append(edge_pairs)
        demands.append(demand_pairs)
    return edges, demands


def widths(edges: list[Piece], i: int) -> list[Fraction]:
    """Return the widths of the filtered tube in dimension i, as Bezier coefficients of all its pieces."""
    return [h - v for piece in edges for v, h in zip(*piece[i], strict=True)]


def prove(task: Any, tube: Tube, claims: list, cuts: int, law: Law) -> None:
    """Prove that the filtered tube is wide enough, that starts are in it, and that the input is strong enough. Margins are in
    units that make these numbers whole."""
    filters = law.filters
    edges, demands = filtered_tube(task, tube, filters)
    per_segment, end = tube.unit * tube.segments / task.t_c, tube.segments * cuts  # a unit in a segment's time
    common = (tube.segments / task.t_c).denominator * math.lcm(*(s.denominator for s in filters))
    errors = [2 * (r * per_segment + s * e * tube.unit)
              for r, s, e in zip(law.rate_claims, filters, law.edge_claims, strict=True)]  # fmt: skip

    unit = tube.unit / common
    claim = take_claim(claims, "P1", [0, end], max(errors) / unit, order=2)
    narrowest = NARROWEST_WIDTH + claim["margin"] * unit
    require(all(v >= narrowest for i in range(task.n) for v in widths(edges, i)), "P1 does not hold for v + lambda x")

    claim = take_claim(claims, "P2", [0, 0], 0, order=2)
    for i, (low, high) in enumerate(tube.pieces[0]):
        clear = min(3 * (low[0] - low[1]), 3 * (high[1] - high[0])) * per_segment
        if task.speed[i]:
            clear += filters[i] * (1 - task.share) * (high[0] - low[0]) * tube.unit / 2 - task.speed[i] - errors[i]
        require(clear >= claim["margin"] * per_segment, "P2 does not hold: a start is not in the filtered tube")

    if task.proves_limits:
        claim = take_claim(claims, "P8", [0, end], 1)
        unit = tube.unit / common**2
        for i, input_margin in enumerate(input_margins(task, law.bits)):
            largest = max(v for piece in demands for c in piece[i] for v in c)
            require(
                input_margin - largest > (claim["margin"] - 1) * unit, f"P8 does not hold: u_max is too small in {task.names[i]}"
            )
