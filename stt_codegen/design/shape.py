"""The spline tube by linear programs: least peak speed, then greatest width at SPEED_ROOM times that speed, then each dimension
as slow as its width allows, sides chosen anew in between while that helps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stt_codegen.design.arena import Arena, Array
from stt_codegen.design.sides import Limits, limits_of_tube
from stt_codegen.design.solver import LinearProgram, face_bound
from stt_codegen.design.timing import Timing
from stt_codegen.designs import LOWER, UPPER
from stt_codegen.errors import NotCertified

SPEED_ROOM = 1.25  # peak speed given up for width, times the least
ROUNDS = 4  # of choosing sides anew
GAIN = 1.01  # a round must improve by this factor to be followed by another
ROOM_FOR_SHAPE = 0.01  # weight of the mean width beside the least width or the speed
KEEP = 1 - 1e-6  # share of the greatest width kept in the last program, so that it stays feasible
# The Bezier coefficients of a segment, by its four control points.
BEZIER = ((1 / 6, 4 / 6, 1 / 6, 0.0), (0.0, 2 / 3, 1 / 3, 0.0), (0.0, 1 / 3, 2 / 3, 0.0), (0.0, 1 / 6, 4 / 6, 1 / 6))


@dataclass(frozen=True)
class Shape:
    """Control points of shape (2, n, K + 3) [edge, dimension, point], their pace (most movement of an edge in one
    segment's time), relative width by dimension."""

    points: Array
    pace: float
    widths: Array

    @property
    def width(self) -> float:
        return float(self.widths.min())

    def bezier(self) -> Array:
        """Coefficients of every segment: shape (2, n, K, 4)."""
        c = self.points
        return np.stack(
            [
                (c[..., :-3] + 4 * c[..., 1:-2] + c[..., 2:-1]) / 6,
                (2 * c[..., 1:-2] + c[..., 2:-1]) / 3,
                (c[..., 1:-2] + 2 * c[..., 2:-1]) / 3,
                (c[..., 1:-2] + 4 * c[..., 2:-1] + c[..., 3:]) / 6,
            ],
            axis=-1,
        )


def find_shape(arena: Arena, start: Array, limits: Limits, segments: int, timing: Timing, room: float) -> Shape | None:
    """Least peak speed, then greatest width, with sides chosen anew after each while that helps; then each dimension
    as slow as its width allows."""
    programs = _programs(arena, start, limits, segments)
    best = _solve_all(programs)
    if best is None:
        return None
    floor = timing.length / segments
    for _ in range(ROUNDS):
        if best.pace <= 1.03 * floor:
            break
        others = _programs(arena, start, limits_of_tube(arena, best.bezier()), segments)
        trial = _solve_all(others)
        if trial is None or trial.pace * GAIN > best.pace:
            break
        best, programs = trial, others
    per_segment = arena.prescribed_time / segments
    freely = max(room * best.pace, timing.narrowest / segments) if room > 1 else best.pace
    pace = min(freely, arena.max_speed * per_segment - arena.allowance)
    if best.pace > pace:
        needed = (best.pace + arena.allowance) / per_segment * 1.00001  # so that the printed digits are enough
        speed = arena.length_unit / arena.time_unit
        raise NotCertified(
            f"P6 speed: the slowest tube found needs {needed * speed:.6g}, above tube.max_speed {arena.max_speed * speed:.6g}; "
            f"raise tube.max_speed to that, or prescribed_time to {arena.time_unit * needed / arena.max_speed:.6g} s"
        )
    widest = _solve_all(programs, pace)
    if widest is None:
        return best
    for _ in range(ROUNDS):
        if widest.width >= 1.0:
            break
        others = _programs(arena, start, limits_of_tube(arena, widest.bezier()), segments)
        trial = _solve_all(others, pace)
        if trial is None or trial.width < GAIN * widest.width:
            break
        widest, programs = trial, others
    calm = _solve_all(programs, pace, widest.widths)
    return calm or widest


def _solve_all(programs: list[_Group], pace: float | None = None, widths: Array | None = None) -> Shape | None:
    """Every group of dimensions by itself (nothing couples them); None when one has no tube."""
    solved: dict[int, tuple[Array, float, float]] = {}
    for program in programs:
        found = program.solve(pace, None if widths is None else widths[program.dimensions])
        if found is None:
            return None
        solved |= found
    order = [solved[i] for i in range(len(solved))]
    return Shape(
        points=np.stack([points for points, _, _ in order], axis=1),
        pace=max(v for _, v, _ in order),
        widths=np.array([w for _, _, w in order]),
    )


def _programs(arena: Arena, start: Array, limits: Limits, segments: int) -> list[_Group]:
    """One linear program for every group of dimensions that the faces in use couple; most groups are one dimension."""
    group = list(range(arena.dimension))
    for x in limits.faces:
        joined = {group[i] for i in np.nonzero(arena.faces.normal[x])[0]}
        group = [min(joined) if g in joined else g for g in group]
    members = [[i for i, g in enumerate(group) if g == first] for first in sorted(set(group))]
    return [_Group(arena, start, limits, dimensions, segments) for dimensions in members]


class _Group:
    """The tube of some dimensions as a linear program in their control points, one pace, and a relative width each.

    Pace is the most that an edge moves in one segment's time. Widths are relative to the narrower of start and target, so 1
    fills it. Rows are on Bezier coefficients (hull property); the last control point equals the last but two: zero slope at t_c,
    exactly.
    """

    def __init__(self, arena: Arena, start: Array, limits: Limits, dimensions: list[int], segments: int) -> None:
        points = segments + 2  # the point K + 2 is the point K
        self.dimensions, each = dimensions, 2 * points + 1
        self.columns, self.widths = [], []
        for k in range(len(dimensions)):
            column = k * each + np.arange(2 * points).reshape(2, points)
            self.columns.append(np.concatenate([column, column[:, segments : segments + 1]], axis=1))
            self.widths.append(k * each + 2 * points)
        self.pace = len(dimensions) * each
        self.program = LinearProgram(len(dimensions) * each + 1)
        self.towards_shape = np.zeros(len(dimensions) * each + 1)
        for k, i in enumerate(dimensions):
            self._dimension(arena, start[:, i], limits.edges[:, :, i], k, i)
        place = {i: k for k, i in enumerate(dimensions)}
        for x in limits.faces:
            if all(int(i) in place for i in np.nonzero(arena.faces.normal[x])[0]):
                self._face(arena, x, limits.beyond[:, x], place)

    def _dimension(self, arena: Arena, start: Array, bounds: Array, k: int, i: int) -> None:
        """Rows of one dimension. start: the edges at t = 0; bounds: shape (K, 2)."""
        program, column, segments = self.program, self.columns[k], len(bounds)
        points = segments + 2
        relative = float(min(start[1] - start[0], arena.target[1, i] - arena.target[0, i]))

        for e in (LOWER, UPPER):
            c = column[e]
            free = np.full(segments, np.inf)
            low, high = (bounds[:, 0], free) if e == LOWER else (-free, bounds[:, 1])
            program.rows(np.stack([c[1:-2], c[2:-1]], axis=1), [2 / 3, 1 / 3], low, high)
            program.rows(np.stack([c[1:-2], c[2:-1]], axis=1), [1 / 3, 2 / 3], low, high)
            program.rows(
                np.stack([c[1:-3], c[2:-2], c[3:-1]], axis=1),
                [1 / 6, 4 / 6, 1 / 6],
                np.maximum(low[1:], low[:-1]),
                np.minimum(high[1:], high[:-1]),
            )
            program.rows(c[None, :3], [1 / 6, 4 / 6, 1 / 6], start[e], start[e])
            program.rows(
                c[None, segments : segments + 2],
                [2 / 6, 4 / 6],
                max(arena.target[0, i], low[-1]) if e == LOWER else -np.inf,
                min(arena.target[1, i], high[-1]) if e == UPPER else np.inf,
            )
            # |gammadot| by the Bezier coefficients of the derivative: differences of control points, and their mean at 0
            pairs = np.concatenate([np.stack([c[2:], c[1:-1]], axis=1), c[None, [2, 0]]])
            share = np.concatenate([np.full(segments + 1, 1.0), [0.5]])[:, None]
            shared = np.hstack([pairs, np.full((len(pairs), 1), self.pace)])
            ones = np.ones((len(pairs), 1))
            program.rows(shared, np.hstack([share, -share, -ones]), -np.inf, 0.0)
            program.rows(shared, np.hstack([share, -share, ones]), 0.0, np.inf)
        inner, outer = column[LOWER, :points], column[UPPER, :points]
        pairs = np.stack([outer, inner], axis=1)
        program.rows(pairs, [1, -1], arena.min_width, np.inf)
        program.rows(np.hstack([pairs, np.full((points, 1), self.widths[k])]), [1, -1, -relative], 0.0, np.inf)
        self.towards_shape[outer] = -ROOM_FOR_SHAPE / (points * relative)
        self.towards_shape[inner] = ROOM_FOR_SHAPE / (points * relative)

    def _face(self, arena: Arena, x: int, where: npt.NDArray[np.bool_], place: dict[int, int]) -> None:
        """Rows that keep the Bezier coefficients of some segments beyond a face."""
        for s in np.nonzero(where)[0]:
            for weights in BEZIER:
                columns, values = [], []
                for i, c in enumerate(arena.faces.normal[x].tolist()):
                    if c:
                        own = self.columns[place[i]][LOWER if c > 0 else UPPER]
                        columns += [int(v) for v in own[s : s + 4]]
                        values += [c * w for w in weights]
                together: dict[int, float] = {}
                for column, value in zip(columns, values, strict=True):  # the last control points may be one column
                    together[column] = together.get(column, 0.0) + value
                self.program.rows(list(together), list(together.values()), face_bound(arena, x), np.inf)

    def solve(self, pace: float | None, widths: Array | None) -> dict[int, tuple[Array, float, float]] | None:
        """By dimension: control points of shape (2, K + 3), pace, relative width; None when there is no tube.

        pace None: least pace. pace given, widths None: greatest width at that pace. Both given: least pace at those widths.
        """
        program = self.program
        program.lower[self.pace], program.upper[self.pace] = 0.0, np.inf if pace is None else pace
        program.lower[self.widths] = 0.0 if widths is None else widths * KEEP
        program.upper[self.widths] = 0.0 if pace is None else 1.0
        program.cost = np.zeros(len(program.cost)) if pace is None else self.towards_shape.copy()
        if pace is None:
            program.cost[self.pace] = 1.0
        elif widths is None:
            program.cost[self.widths] = -1.0
        else:
            program.cost[self.pace] = 1.0 / pace
        solution = program.solve()
        if solution is None:
            return None
        one = float(solution[self.pace])
        return {i: (solution[self.columns[k]], one, float(solution[self.widths[k]])) for k, i in enumerate(self.dimensions)}
