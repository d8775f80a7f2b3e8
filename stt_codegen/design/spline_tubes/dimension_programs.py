"""The linear programs of a spline tube: one for every dimension, or for a group of dimensions that a constraint couples.

The upper edge is the lower one, the width, and what the start is wider: U = L + w + z, z >= 0 on the first control points. So a
program has half the columns of two free edges, and its smallest peak speed is, in practice, the same. slowest_tube.py puts the
solutions together; linear_programs/tube_rows.py has the rows.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stt_codegen.design.arena import Arena
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.linear_programs import (
    INNER_BEZIER_WEIGHTS,
    ProgramBounds,
    Rows,
    RowTemplate,
    SolverCache,
    face_bound,
    minimise,
    row_template_of,
)
from stt_codegen.design.routes import SegmentBounds
from stt_codegen.designs import LOWER, UPPER

WIDENED_POINTS = 12  # control points on which the tube may be wider than asked, so that it can begin with all of gamma(0)
EXTRA_WIDTH_WEIGHT = 1e-3  # of what the tube is wider, beside the pace
PACE_TOLERANCE = 1e-8  # of the pace that the smoothest tube may take: ten times the tolerance of the solver's rows
BEZIER_WEIGHTS = ((1 / 6, 4 / 6, 1 / 6, 0.0), (0.0, 2 / 3, 1 / 3, 0.0), (0.0, 1 / 3, 2 / 3, 0.0), (0.0, 1 / 6, 4 / 6, 1 / 6))


@dataclass(frozen=True)
class _Coupling:
    """normal.x over the tube's box must be at least a bound on these segments: all of their Bezier coefficients, or the last
    alone.

    weights: of the control points, for each coefficient that counts. bounds: one for each of the weights.
    """

    normal: tuple[float, ...]
    bounds: tuple[float, ...]
    segments: tuple[int, ...]
    weights: tuple[tuple[float, ...], ...] = BEZIER_WEIGHTS

    @property
    def first_dimension(self) -> int:
        return next(i for i, c in enumerate(self.normal) if c)


@dataclass(frozen=True)
class TubeProblem:
    """What a tube is designed within: gamma(0) of shape (2, n), the bounds of every segment, and the width (n,)."""

    arena: Arena
    start: Array
    bounds: SegmentBounds
    width: Array

    @property
    def segments(self) -> int:
        return len(self.bounds.edges)

    @property
    def widened_count(self) -> int:
        """The number of control points on which the tube may be wider than asked: none that comes again."""
        return min(WIDENED_POINTS, self.segments if self.arena.seam is None else self.arena.seam)

    @cached_property
    def coefficient_bounds(self) -> Array:
        """For every Bezier coefficient the bounds on L from below and on U from above: (K, 4, 2, n)."""
        return self.bounds.coefficient_bounds(self.arena)

    @cached_property
    def couplings(self) -> list[_Coupling]:
        """What must hold of several dimensions together: beyond the faces in use, within what cuts the space and the target."""
        arena, bounds = self.arena, self.bounds
        faces, count = arena.oblique_faces, self.segments
        couplings = [
            _Coupling(
                tuple(faces.normal[x].tolist()),
                (face_bound(arena, x),) * 4,
                tuple(np.nonzero(bounds.beyond_faces[:, x])[0].tolist()),
            )
            for x in bounds.faces_in_use
        ]
        last = (count - 1,)
        for cuts, where, weights in (
            (arena.space_cuts, tuple(range(count)), BEZIER_WEIGHTS),
            (arena.target_cuts, last, BEZIER_WEIGHTS[-1:]),
        ):
            for normal, bound in zip(cuts.normal.tolist(), cuts.lower_bound.tolist(), strict=True):
                couplings.append(_Coupling(tuple(normal), (bound,) * len(weights), where, weights))
        for obstacle, sides in zip(arena.timed_obstacles, bounds.timed_sides, strict=True):
            oblique = np.nonzero(sides >= 2 * arena.dimension)[0].tolist()
            side_bounds = obstacle.bounds(count) + arena.clearance if oblique else None
            for k in oblique:
                assert side_bounds is not None
                normal = tuple(obstacle.normal[sides[k]].tolist())
                couplings.append(_Coupling(normal, tuple(side_bounds[sides[k], k].tolist()), (k,)))
        return couplings

    @property
    def groups(self) -> list[list[int]]:
        """The dimensions that the couplings join together; mostly every one by itself."""
        group = list(range(self.arena.dimension))
        for coupling in self.couplings:
            joined = {group[i] for i, c in enumerate(coupling.normal) if c}
            group = [min(joined) if g in joined else g for g in group]
        return [[i for i, g in enumerate(group) if g == first] for first in sorted(set(group))]

    def second_difference_limit(self, i: int) -> float:
        """Return the largest second difference of control points that the acceleration allows, less their rounding."""
        if self.arena.max_acceleration is None:
            return np.inf
        return float(self.arena.max_acceleration[i]) / self.segments**2 - self.arena.difference_allowance


def solve_group(
    problem: TubeProblem, members: list[int], solver_cache: SolverCache | None, pace: float | None = None
) -> tuple[Array, float] | None:
    """Return control points (2, m, K + 3) of some dimensions, and the pace that they share; None where there are none.

    They are the slowest; with a given pace the smoothest.
    """
    template = _template_of(problem, has_bend_slack=pace is not None)
    couplings = [c for c in problem.couplings if c.first_dimension in members]
    rows, row_lower, row_upper = _group_rows(problem, members, template, couplings)
    cost, lower, upper = _group_columns(problem, members, template, pace)
    bounds = ProgramBounds(lower, upper, row_lower, row_upper)
    if couplings or solver_cache is None:
        solution = minimise(cost, rows, bounds)
    else:
        solution = solver_cache.minimise((problem.segments, problem.arena.seam or 0, *members), cost, rows, bounds)
    if solution is None:
        return None
    return _control_points(problem, members, template, solution), float(solution[-1])


def _template_of(problem: TubeProblem, has_bend_slack: bool) -> RowTemplate:
    """Return the rows that the plant's order and the bounds on speed and acceleration ask for."""
    arena = problem.arena
    return row_template_of(
        segments=problem.segments,
        widened_count=problem.widened_count,
        has_bends=has_bend_slack or (arena.order == 1 and arena.max_acceleration is not None),
        has_bend_slack=has_bend_slack,
        order=arena.order,
        has_steps=arena.order == 2 and bool(np.isfinite(arena.max_speeds).any()),
        seam=arena.seam,
    )


def _group_rows(
    problem: TubeProblem, members: list[int], template: RowTemplate, couplings: list[_Coupling]
) -> tuple[Rows, Array, Array]:
    """Return the rows of a group with their bounds: the template of every member, one after the other, then the couplings."""
    stride = template.column_count - 1  # of a member's columns; the pace is the last column of all
    pace_column = stride * len(members)
    blocks, lower, upper = [], [], []
    for k, i in enumerate(members):
        rows = template.rows.shifted(k * stride, stride, pace_column)
        speed = float(problem.arena.relative_speeds[i])
        blocks.append(rows if speed == 1 else rows.with_scaled_column(pace_column, speed))
        member_lower, member_upper = _member_row_bounds(problem, template, i)
        lower.append(member_lower)
        upper.append(member_upper)
    if couplings:
        rows, low = _coupling_rows(couplings, problem.width, members, template)
        blocks.append(rows)
        lower.append(low)
        upper.append(np.full(len(low), np.inf))
    return Rows.stacked(blocks), np.concatenate(lower), np.concatenate(upper)


def _group_columns(
    problem: TubeProblem, members: list[int], template: RowTemplate, pace: float | None
) -> tuple[Array, Array, Array]:
    """Return cost, lower and upper bounds of a group's columns: the pace costs, or with a given pace the second differences."""
    stride, widened = template.column_count - 1, template.widened_count
    pace_column = stride * len(members)
    cost = np.zeros(pace_column + 1)
    lower, upper = np.full(pace_column + 1, -np.inf), np.full(pace_column + 1, np.inf)
    lower[pace_column], cost[pace_column] = 0.0, 1.0 if pace is None else 0.0
    if pace is not None:
        upper[pace_column] = pace + PACE_TOLERANCE
    elif problem.arena.order == 2:
        upper[pace_column] = min(problem.second_difference_limit(i) for i in members)
    for k, i in enumerate(members):
        extra_width = slice(k * stride + template.point_columns, k * stride + template.point_columns + widened)
        bends = slice(extra_width.stop, (k + 1) * stride)
        lower[extra_width], cost[extra_width] = 0.0, EXTRA_WIDTH_WEIGHT / widened
        lower[bends], cost[bends] = 0.0, 1.0
        upper[bends] = problem.second_difference_limit(i)
    return cost, lower, upper


def _control_points(problem: TubeProblem, members: list[int], template: RowTemplate, solution: Array) -> Array:
    """Return the control points (2, m, K + 3) of the members from the solution's columns."""
    stride, widened = template.column_count - 1, template.widened_count
    points = np.empty((2, len(members), problem.segments + 3))
    for k, i in enumerate(members):
        extra_width = k * stride + template.point_columns
        low = solution[k * stride : extra_width]
        high = low + float(problem.width[i])
        high[:widened] += solution[extra_width : extra_width + widened]
        for edge, value in ((LOWER, low), (UPPER, high)):
            points[edge, k] = value[list(template.column_of_point)]
    return points


def _member_row_bounds(problem: TubeProblem, template: RowTemplate, i: int) -> tuple[Array, Array]:
    """Return the bounds of the template's rows for dimension i."""
    arena, start, width = problem.arena, problem.start[:, i], float(problem.width[i])
    edges = problem.coefficient_bounds[..., i]  # (K, 4, 2)
    slices, widened = template.row_slices, template.widened_count
    lower, upper = np.full(template.rows.count, -np.inf), np.full(template.rows.count, np.inf)

    def bound(names: tuple[str, ...], low: float, high: float) -> None:
        """Set the bounds of the blocks that the template has."""
        for name in names:
            if name in slices:
                lower[slices[name]], upper[slices[name]] = low, high

    def bound_edges(name: str, low: Array, high: Array) -> None:
        """Set what L is at least, and U at most; U has rows of its own where z counts."""
        upper_of_lower_edge = high.copy()
        upper_of_lower_edge[: widened - 1] = np.inf
        lower[slices[name]], upper[slices[name]] = low, upper_of_lower_edge
        upper[slices[f"{name}, wider"]] = high[: widened - 1]

    low, high = edges[..., 0], edges[..., 1] - width
    for k in range(len(INNER_BEZIER_WEIGHTS)):
        bound_edges(f"inner {k}", low[:, k + 1], high[:, k + 1])
    bound_edges("joint", np.maximum(low[1:, 0], low[:-1, 3]), np.minimum(high[1:, 0], high[:-1, 3]))
    bound(("end",), max(arena.target[0, i], low[-1, 3]), min(arena.target[1, i] - width, high[-1, 3]))
    bound(("start",), start[0], start[0])
    bound(("start, wider",), start[1] - width, start[1] - width)
    bound(("rise", "rise, wider"), -np.inf, 0.0)
    bound(("fall", "fall, wider"), 0.0, np.inf)
    bound(("rest",), -np.inf, 0.0)
    bound(("rest, wider",), 0.0, np.inf)
    step = float(arena.max_speeds[i]) / problem.segments - arena.difference_allowance
    bound(("step", "step, wider"), -step, step)
    second_difference = 0.0 if template.has_bend_slack else problem.second_difference_limit(i)
    bound(("bend", "bend, wider"), -second_difference, second_difference)
    return lower, upper


def _coupling_rows(couplings: list[_Coupling], width: Array, members: list[int], template: RowTemplate) -> tuple[Rows, Array]:
    """Return the rows of the couplings, and their lower bounds."""
    stride, widened = template.column_count - 1, template.widened_count
    rows: list[tuple[tuple[int, ...], tuple[float, ...]]] = []
    bound: list[float] = []
    position = {i: k for k, i in enumerate(members)}
    for coupling in couplings:
        constant = sum(c * float(width[i]) for i, c in enumerate(coupling.normal) if c < 0)
        pairs = zip(coupling.weights, coupling.bounds, strict=True)
        for s, (weights, limit) in itertools.product(coupling.segments, pairs):
            terms: dict[int, float] = {}
            for i, c in enumerate(coupling.normal):
                if not c:
                    continue
                first = position[i] * stride
                for point, w in zip(range(s, s + 4), weights, strict=True):
                    column = first + template.column_of_point[point]
                    terms[column] = terms.get(column, 0.0) + c * w
                    if c < 0 and point < widened:
                        terms[first + template.point_columns + point] = c * w
            rows.append((tuple(terms), tuple(terms.values())))
            bound.append(limit - constant)
    return Rows.of(rows), np.array(bound)
