"""The refined design: a route, its sides, the least times, then a spline tube by linear programming.

    arena -> route -> sides -> stretch times (one small linear program)
          -> least peak speed, then greatest width at SPEED_ROOM times that speed, then each dimension as slow as its
             width allows (small linear programs, one for each dimension)
          -> sides chosen anew where the tube has more room on another side, repeated while it helps
          -> coefficients rounded to a dyadic grid that a float holds exactly

Nothing here is trusted: the exact certificate is computed from the rounded coefficients alone.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from stt_codegen.certify.certificate import below
from stt_codegen.design.arena import Arena, Array, arena_of, magnitude, normalised, starting_box
from stt_codegen.design.route import Route, find_route, shortest_route
from stt_codegen.design.sides import ABOVE, BELOW, Stay, bounds_by_stretch, choose_sides
from stt_codegen.design.solver import LinearProgram
from stt_codegen.design.tube import LOWER, UPPER, RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.task import Task

SEGMENTS = (32, 48, 64, 96, 128, *(1 << k for k in range(8, 14)))  # tried in this order when the task names no number,
FEWEST, MOST = 0.5, 8  # between so many times the number of unsafe sets, but always up to PLENTY
PLENTY = 128
CALM = (0, 1, 4)  # segments that every stretch of the polyline tube gets at least; tried in this order
SPEED_ROOM = 1.25  # peak speed given up for width, times the least
WIDE_ROUTES = (1.0, 0.5)  # widths to find a route for before the least width, relative to start and target
DETOUR = 1.1  # how much longer than the shortest such a route may be
ROUNDS = 4  # of choosing sides anew
GAIN = 1.01  # a round must improve by this factor to be followed by another
ROOM_FOR_SHAPE = 0.01  # weight of the mean width beside the least width or the speed
NARROWING = 5  # halvings to find the largest value of an option that would do
KEEP = 1 - 1e-6  # share of the greatest width kept in the last program, so that it stays feasible

Sides = tuple[tuple[Stay, ...], ...]


@dataclass(frozen=True)
class Timing:
    """The polyline tube of least time: route parameters of its vertices and the share of time of each stretch.

    length: sum of the stretches' lengths (largest movement of any edge), a distance; length / t_c bounds the peak
    speed of any tube with these sides from below. narrowest: the least width of start and target in any dimension.
    """

    vertices: tuple[float, ...]
    shares: tuple[float, ...]
    length: float
    narrowest: float


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


def refine(task: Task, room: float = SPEED_ROOM) -> RefinedDesign:
    """Design a refined tube. Raises `NotCertified` with the reason when none is found.

    room: the peak speed over the least that was found; at 1 the tube is as slow, and so as narrow, as it gets.
    """
    arena = normalised(arena_of(task), magnitude(task))
    start = starting_box(arena)
    ladder = (task.tube.segments,) if task.tube.segments else segments_for(len(arena.names))
    *wide, shortest = candidate_routes(arena, start)
    for route in wide:
        with suppress(NotCertified):  # too fast along this one; the shortest may do
            shape = _follow(arena, start, route, ladder[:1], room)
            if shape is not None:
                return round_design(task, shape)
    shape = _follow(arena, start, shortest, ladder, room)
    if shape is not None:
        return round_design(task, shape)
    count = f"{task.tube.segments} segments" if task.tube.segments else f"up to {ladder[-1]} segments"
    raise NotCertified(f"P4 avoid: no spline tube of {count} was found along the shortest route; {_what_binds(task, arena)}")


def _what_binds(task: Task, arena: Arena) -> str:
    """Which options, changed one at a time, would let a tube be found, and how far each must go."""
    size = arena.length_unit

    def found(clearance: float, min_width: float, ladder: tuple[int, ...]) -> Shape | None:
        trial = replace(arena, clearance=clearance, min_width=min_width)
        with suppress(NotCertified):
            begin = starting_box(trial)
            return _follow(trial, begin, shortest_route(trial, begin, min_width), ladder, SPEED_ROOM)
        return None

    def largest(holds: Callable[[float], bool], least: float, most: float) -> float | None:
        if not holds(least):
            return None
        for _ in range(NARROWING):
            middle = (least + most) / 2
            least, most = (middle, most) if holds(middle) else (least, middle)
        return least

    usual = segments_for(len(arena.names))
    ladder = (task.tube.segments,) if task.tube.segments else usual
    would_do = []
    if task.tube.segments:
        more = (*range(task.tube.segments + 1, SEGMENTS[0]), *usual)
        shape = found(arena.clearance, arena.min_width, tuple(k for k in more if k > task.tube.segments))
        if shape is not None:
            would_do.append(f"tube.segments = {shape.points.shape[2] - 3} (or leave it out)")
    spare = arena.allowance
    clearance = largest(lambda c: found(c, arena.min_width, ladder) is not None, spare, arena.clearance)
    if clearance is not None:
        would_do.append(f"tube.clearance = {below(Fraction((clearance - spare) * size), 3):g}")
    width = largest(lambda w: found(arena.clearance, w, ladder) is not None, 2 * spare, arena.min_width)
    if width is not None:
        would_do.append(f"tube.min_width = {below(Fraction((width - 2 * spare) * size), 3):g}")
    if not would_do and arena.max_speed < np.inf:
        return "without tube.max_speed, " + _what_binds(task, replace(arena, max_speed=np.inf))
    if not would_do:
        return "no single option of [tube] would change that: lower tube.clearance and tube.min_width, or make more room"
    return ", or ".join(would_do) + " would do"


def segments_for(unsafe: int) -> tuple[int, ...]:
    """The numbers of segments to try for so many unsafe sets."""
    return tuple(k for k in SEGMENTS if FEWEST * unsafe <= k <= max(PLENTY, MOST * unsafe))


def candidate_routes(arena: Arena, start: Array) -> list[Route]:
    """Routes to try: with room for a wide tube where that costs little length, and last the shortest."""
    shortest = shortest_route(arena, start, arena.min_width)
    full = float(np.minimum(start[1] - start[0], arena.target[1] - arena.target[0]).min())
    routes = []
    for share in WIDE_ROUTES:
        if share * full > arena.min_width:
            route = find_route(arena, start, share * full)
            if route is not None and route.length <= DETOUR * shortest.length:
                routes.append(route)
    return [*routes, shortest]


def _follow(arena: Arena, start: Array, route: Route, ladder: tuple[int, ...], room: float) -> Shape | None:
    """A spline tube along the route, with the fewest segments of the ladder that do."""
    sides = choose_sides(arena, route, start)
    timing = least_times(arena, sides, start, route) if sides is not None else None
    if sides is None or timing is None:
        return None
    for segments in ladder:
        for shares in _time_plans(timing, segments):
            changes = _changes(timing, sides, shares, segments)
            if changes is None:
                continue
            shape = _shape(arena, start, bounds_by_stretch(arena, sides, changes, segments), segments, timing, room)
            if shape is not None:
                return shape
    return None


# ------------------------------------------------------------------------------------------------- times


def least_times(arena: Arena, sides: Sides, start: Array, route: Route) -> Timing | None:
    """A polyline tube with a vertex at every change of side, its total movement least (a linear program).

    One duration for each stretch, shared by all dimensions; no edge moves by more than the duration. None when no tube
    of least width fits.
    """
    n = arena.dimension
    inner = sorted({round(stay.until, 9) for stays in sides for stay in stays[:-1]})
    vertices = (0.0, *(v for v in inner if v > 0), float(len(route.points) - 1))
    m = len(vertices) - 1
    place = {v: k for k, v in enumerate(vertices)}
    changes = tuple((*(place.get(round(s.until, 9), m) for s in stays[:-1]), m) for stays in sides)
    bounds = bounds_by_stretch(arena, sides, changes, m)

    program = LinearProgram(2 * n * (m + 1) + m)
    edge = np.arange(2 * n * (m + 1)).reshape(m + 1, 2, n)
    duration = 2 * n * (m + 1) + np.arange(m)
    program.cost[duration] = 1.0
    program.lower[duration] = 0.0
    for v in range(m + 1):
        near = bounds[max(v - 1, 0) : v + 1]
        low, high = near[:, 0].max(axis=0), near[:, 1].min(axis=0)
        if v == m:
            low, high = np.maximum(low, arena.target[0]), np.minimum(high, arena.target[1])
        program.lower[edge[v]] = start if v == 0 else low
        program.upper[edge[v]] = start if v == 0 else high
    for v in range(1, m + 1):
        program.rows(np.stack([edge[v, UPPER], edge[v, LOWER]], axis=1), [1, -1], arena.min_width, np.inf)
        columns = np.stack([np.full(2 * n, duration[v - 1]), edge[v].ravel(), edge[v - 1].ravel()], axis=1)
        program.rows(columns, [1, -1, 1], 0.0, np.inf)
        program.rows(columns, [1, 1, -1], 0.0, np.inf)
    solution = program.solve()
    if solution is None:
        return None
    durations = [max(float(d), 0.0) for d in solution[duration]]
    length = float(np.cumsum(durations)[-1])
    shares = tuple(d / length for d in durations) if length > 0 else (1.0 / m,) * m
    widths = np.minimum(start[1] - start[0], arena.target[1] - arena.target[0])
    return Timing(vertices, shares, length, float(widths.min()))


def _time_plans(timing: Timing, segments: int) -> list[tuple[float, ...]]:
    """Shares of time to try: as the linear program has them, then with some segments at least for every stretch, so that a
    spline can turn where the polyline has a corner."""
    plans: list[tuple[float, ...]] = []
    for least in CALM:
        stretched = [max(share, least / segments) for share in timing.shares]
        total = float(np.cumsum(stretched)[-1])
        plan = tuple(share / total for share in stretched)
        if least * len(stretched) < segments and plan not in plans:
            plans.append(plan)
    return plans


def _changes(timing: Timing, sides: Sides, shares: tuple[float, ...], segments: int) -> tuple[tuple[int, ...], ...] | None:
    """The segment at which each choice of side ends, at least one segment for each choice; None when they do not fit."""
    times = np.concatenate([[0.0], np.cumsum(shares)]) * segments
    place = {round(v, 9): float(t) for v, t in zip(timing.vertices, times, strict=True)}
    result = []
    for stays in sides:
        if len(stays) > segments:
            return None
        ends, last = [], 0
        for q, stay in enumerate(stays[:-1]):
            latest = segments - (len(stays) - 1 - q)
            last = min(max(round(place[round(stay.until, 9)]), last + 1), latest)
            ends.append(last)
        result.append((*ends, segments))
    return tuple(result)


# ------------------------------------------------------------------------------------------------- shape


def _shape(arena: Arena, start: Array, bounds: Array, segments: int, timing: Timing, room: float) -> Shape | None:
    """Least peak speed, then greatest width, with sides chosen anew after each while that helps; then each dimension
    as slow as its width allows."""
    programs = _programs(arena, start, bounds, segments)
    best = _solve_all(programs)
    if best is None:
        return None
    floor = timing.length / segments
    for _ in range(ROUNDS):
        if best.pace <= 1.03 * floor:
            break
        others = _programs(arena, start, _sides_of(arena, best, segments), segments)
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
        others = _programs(arena, start, _sides_of(arena, widest, segments), segments)
        trial = _solve_all(others, pace)
        if trial is None or trial.width < GAIN * widest.width:
            break
        widest, programs = trial, others
    calm = _solve_all(programs, pace, widest.widths)
    return calm or widest


def _solve_all(programs: list[_Dimension], pace: float | None = None, widths: Array | None = None) -> Shape | None:
    """Every dimension by itself (with the sides fixed, nothing couples them); None when one has no tube."""
    solved = []
    for i, program in enumerate(programs):
        one = program.solve(pace, None if widths is None else float(widths[i]))
        if one is None:
            return None
        solved.append(one)
    return Shape(
        points=np.stack([points for points, _, _ in solved], axis=1),
        pace=max(v for _, v, _ in solved),
        widths=np.array([w for _, _, w in solved]),
    )


def _programs(arena: Arena, start: Array, bounds: Array, segments: int) -> list[_Dimension]:
    return [_Dimension(arena, start[:, i], bounds[:, :, i], i, segments) for i in range(arena.dimension)]


class _Dimension:
    """The tube of dimension i as a linear program in its control points, its pace and its relative width.

    Pace is the most that an edge moves in one segment's time. Widths are relative to the narrower of start and target, so 1
    fills it. start: the edges at t = 0. bounds: shape (K, 2), from `bounds_by_stretch`. Constraints are on Bezier coefficients
    (hull property); the last control point equals the last but two: zero slope at t_c, exactly.
    """

    def __init__(self, arena: Arena, start: Array, bounds: Array, i: int, segments: int) -> None:
        points = segments + 2  # the point K + 2 is the point K
        column = np.arange(2 * points).reshape(2, points)
        self.column = column = np.concatenate([column, column[:, segments : segments + 1]], axis=1)
        self.width, self.pace = 2 * points, 2 * points + 1
        self.program = program = LinearProgram(2 * points + 2)
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
        program.rows(np.hstack([pairs, np.full((points, 1), self.width)]), [1, -1, -relative], 0.0, np.inf)
        self.towards_shape = np.zeros(2 * points + 2)
        self.towards_shape[outer] = -ROOM_FOR_SHAPE / (points * relative)
        self.towards_shape[inner] = ROOM_FOR_SHAPE / (points * relative)

    def solve(self, pace: float | None, width: float | None) -> tuple[Array, float, float] | None:
        """Control points of shape (2, K + 3), pace, relative width; None when there is no tube.

        pace None: least pace. pace given, width None: greatest width at that pace. Both given: least pace at that width.
        """
        program = self.program
        program.lower[self.pace], program.upper[self.pace] = 0.0, np.inf if pace is None else pace
        program.lower[self.width] = 0.0 if width is None else width * KEEP
        program.upper[self.width] = 0.0 if pace is None else 1.0
        program.cost = np.zeros(len(program.cost)) if pace is None else self.towards_shape.copy()
        if pace is None:
            program.cost[self.pace] = 1.0
        elif width is None:
            program.cost[self.width] = -1.0
        else:
            program.cost[self.pace] = 1.0 / pace
        solution = program.solve()
        if solution is None:
            return None
        return solution[self.column], float(solution[self.pace]), float(solution[self.width])


def _sides_of(arena: Arena, shape: Shape, segments: int) -> Array:
    """Bounds as `bounds_by_stretch`, with the side for every segment and unsafe set on which this tube has most room."""
    c = shape.points
    bezier = np.stack(
        [
            (c[..., :-3] + 4 * c[..., 1:-2] + c[..., 2:-1]) / 6,
            (2 * c[..., 1:-2] + c[..., 2:-1]) / 3,
            (c[..., 1:-2] + 2 * c[..., 2:-1]) / 3,
            (c[..., 1:-2] + 4 * c[..., 2:-1] + c[..., 3:]) / 6,
        ],
        axis=-1,
    )
    lowest, highest = bezier[LOWER].min(axis=-1), bezier[UPPER].max(axis=-1)  # (n, K)
    bounds = np.repeat(arena.space[None], segments, axis=0)
    if not arena.names:
        return bounds
    gaps = np.stack(
        [arena.unsafe[:, 0, :, None] - highest[None], lowest[None] - arena.unsafe[:, 1, :, None]], axis=1
    )  # (J, side, n, K)
    choice = gaps.reshape(len(arena.names), 2 * arena.dimension, segments).argmax(axis=1)
    for side in (BELOW, ABOVE):
        for i in range(arena.dimension):
            chosen = choice == side * arena.dimension + i
            if side == BELOW:
                limit = np.where(chosen, (arena.unsafe[:, 0, i] - arena.clearance)[:, None], np.inf).min(axis=0)
                bounds[:, 1, i] = np.minimum(bounds[:, 1, i], limit)
            else:
                limit = np.where(chosen, (arena.unsafe[:, 1, i] + arena.clearance)[:, None], -np.inf).max(axis=0)
                bounds[:, 0, i] = np.maximum(bounds[:, 0, i], limit)
    return bounds


# ---------------------------------------------------------------------------------------------- rounding


def round_design(task: Task, shape: Shape) -> RefinedDesign:
    """Control points over 6 (here in units of 2**m, the size of the state space), rounded to multiples of 2**(m - 23): 24
    bits hold them exactly, in float as in double, so both scalar types share one tube and one certificate."""
    integers = np.rint(np.ldexp(shape.points / 6, 23)).astype(np.int64)
    integers[:, :, -1] = integers[:, :, -3]
    table = tuple(
        tuple((int(integers[LOWER, i, j]), int(integers[UPPER, i, j])) for i in range(integers.shape[1]))
        for j in range(integers.shape[2])
    )
    return RefinedDesign(task.prescribed_time, integers.shape[2] - 3, 23 - magnitude(task), table)
