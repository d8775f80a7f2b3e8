"""The rows of the linear program of one dimension (design/spline_tubes/shape.py): the Bezier coefficients of both edges and of
their derivatives, by control points. They depend on the number of segments alone, so they are made once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from stt_codegen.design.linear_programs.solver import Rows

# The Bezier coefficients of a segment inside it, where two meet, and at t_c, by the control points from the second on.
INNER, JOINT, END = ((2 / 3, 1 / 3), (1 / 3, 2 / 3)), (1 / 6, 4 / 6, 1 / 6), (2 / 6, 4 / 6)
BEND = (1.0, -2.0, 1.0)  # a second difference


@dataclass(frozen=True, kw_only=True)
class Template:
    """The rows of one dimension for K segments, m widened points. Columns are L's control points, K + 2 (point K + 2 is point K)
    or K + 1 for order 2 (the last three are one), or K where the last three are those from the seam on, then z's m, then where
    bends are told how much each is, up and down, then the pace: what an edge moves at most in one segment's time, for order 2 by
    how much two such moves differ. place: which rows are which."""

    rows: Rows
    place: dict[str, slice]
    columns: int
    told: bool
    column: tuple[int, ...]  # of every control point
    widened: int = 0

    @property
    def points(self) -> int:
        """How many columns L has."""
        return max(self.column) + 1


@cache
def template_of(
    segments: int, widened: int, bends: bool, told: bool, order: int = 1, steps: bool = False, seam: int | None = None
) -> Template:
    """bends: with rows of second differences; told: in columns of their own, for a cost; steps: for order 2, with rows of the
    differences of neighbours too. seam: the segment from which on a tube repeats itself; no point from there on is widened."""
    points = segments + 3 - order if seam is None else segments
    column = [*range(points), *([segments] * order if seam is None else range(seam, seam + 3))]
    early_bends = min(widened, segments + 1)  # second differences in which z counts
    pace = points + widened + (2 * (segments + 1 + early_bends) if told else 0)
    rows: list[tuple[tuple[int, ...], tuple[float, ...]]] = []
    place: dict[str, slice] = {}

    def add(name: str, found: list[tuple[tuple[int, ...], tuple[float, ...]]]) -> None:
        place[name] = slice(len(rows), len(rows) + len(found))
        rows.extend(map(merged, found))

    def merged(row: tuple[tuple[int, ...], tuple[float, ...]]) -> tuple[tuple[int, ...], tuple[float, ...]]:
        """Each column once, as the solver wants it: of the last control points two are one column."""
        total: dict[int, float] = {}
        for c, v in zip(*row, strict=True):
            total[c] = total.get(c, 0.0) + v
        return tuple(total), tuple(total.values())

    def lower(points: tuple[int, ...], values: tuple[float, ...]) -> tuple[tuple[int, ...], tuple[float, ...]]:
        return tuple(column[j] for j in points), values

    def upper(places: tuple[int, ...], values: tuple[float, ...]) -> tuple[tuple[int, ...], tuple[float, ...]]:
        wider = [(points + j, v) for j, v in zip(places, values, strict=True) if j < widened]
        return (*(column[j] for j in places), *(c for c, _ in wider)), (*values, *(v for _, v in wider))

    early = range(widened - 1)  # segments and joints in which z counts
    for k, weights in enumerate(INNER):
        add(f"inner {k}", [lower((s + 1, s + 2), weights) for s in range(segments)])
        add(f"inner {k}, wider", [upper((s + 1, s + 2), weights) for s in early])
    add("joint", [lower((s + 1, s + 2, s + 3), JOINT) for s in range(segments - 1)])
    add("joint, wider", [upper((s + 1, s + 2, s + 3), JOINT) for s in early if s < segments - 1])
    add("end", [lower((segments, segments + 1), END) if seam is None else lower((segments, segments + 1, segments + 2), JOINT)])
    add("start", [lower((0, 1, 2), JOINT)])
    add("start, wider", [upper((0, 1, 2), JOINT)])
    # |gammadot| by the Bezier coefficients of the derivative: differences of control points, and their mean at 0
    slope = ((2, 0), (0.5, -0.5))
    moves = [*(((j + 1, j), (1.0, -1.0)) for j in range(1, segments + 1)), slope]
    early_moves = [*(((j + 1, j), (1.0, -1.0)) for j in range(1, widened)), slope]
    turns = [((j, j + 1, j + 2), BEND) for j in range(segments + 1)]
    paced, early_paced = (moves, early_moves) if order == 1 else (turns, turns[:early_bends])
    for name, sign in (("rise", -1.0), ("fall", 1.0)):
        for what, edge, which in ((name, lower, paced), (f"{name}, wider", upper, early_paced)):
            found = [edge(places, values) for places, values in which]
            add(what, [((*c, pace), (*v, sign)) for c, v in found])
    if order == 2:
        add("rest", [lower(*slope)])
        add("rest, wider", [upper(*slope)])
    if steps:
        add("step", [lower(*move) for move in moves])
        add("step, wider", [upper(*move) for move in early_moves])
    if bends:
        # the second derivative is linear between the second differences of control points
        first = points + widened
        for what, edge, count in (("bend", lower, segments + 1), ("bend, wider", upper, early_bends)):
            found = [edge((j, j + 1, j + 2), BEND) for j in range(count)]
            if told:
                found = [((*c, first + 2 * j, first + 2 * j + 1), (*v, -1.0, 1.0)) for j, (c, v) in enumerate(found)]
                first += 2 * count
            add(what, found)
    return Template(rows=Rows.of(rows), place=place, columns=pace + 1, told=told, column=tuple(column), widened=widened)
