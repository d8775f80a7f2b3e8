"""The rows of the linear program of one dimension (design/spline_tubes/dimension_programs.py): the Bezier coefficients of both
edges and of their derivatives, by control points. They depend on the number of segments alone, so they are made once.

The upper edge is U = L + w + z, with z >= 0 on the first control points ("widened"). So a row of U is a row of L with z added;
its name ends in ", wider", and it stands only where z counts. The lemmas `refined.*` prove what the coefficients bound.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from stt_codegen.design.linear_programs.solver import Rows

# The Bezier coefficients of a segment inside it, where two meet, and at t_c, by the control points from the second on.
INNER_BEZIER_WEIGHTS, JOINT_WEIGHTS, END_WEIGHTS = ((2 / 3, 1 / 3), (1 / 3, 2 / 3)), (1 / 6, 4 / 6, 1 / 6), (2 / 6, 4 / 6)
SECOND_DIFFERENCE = (1.0, -2.0, 1.0)
DIFFERENCE = (1.0, -1.0)

Row = tuple[tuple[int, ...], tuple[float, ...]]  # columns and values
Terms = tuple[tuple[int, ...], tuple[float, ...]]  # control points and weights
Blocks = list[tuple[str, list[Row]]]


@dataclass(frozen=True, kw_only=True)
class RowTemplate:
    """The rows of one dimension for K segments and a number of widened control points.

    Columns are L's control points: K + 2 (point K + 2 is point K), or K + 1 for order 2 (the last three are one), or K where the
    last three are those from the seam on. Then come z's columns. With `has_bend_slack` each second difference has two columns,
    its positive and its negative part, for a cost. The last column is the pace: what an edge moves at most in one segment's time,
    for order 2 by how much two such moves differ. row_slices: the rows by name. column_of_point: the column of every control
    point.
    """

    rows: Rows
    row_slices: dict[str, slice]
    column_count: int
    has_bend_slack: bool
    column_of_point: tuple[int, ...]
    widened_count: int = 0

    @property
    def point_columns(self) -> int:
        """The number of L's columns."""
        return max(self.column_of_point) + 1


@dataclass(frozen=True, kw_only=True)
class _Layout:
    """The columns of a template, and the rows of either edge in them."""

    segments: int
    widened_count: int
    has_bend_slack: bool
    order: int
    seam: int | None

    @property
    def point_columns(self) -> int:
        return self.segments + 3 - self.order if self.seam is None else self.segments

    @property
    def column_of_point(self) -> list[int]:
        repeated = [self.segments] * self.order if self.seam is None else [*range(self.seam, self.seam + 3)]
        return [*range(self.point_columns), *repeated]

    @property
    def widened_bends(self) -> int:
        """The number of second differences in which z counts."""
        return min(self.widened_count, self.segments + 1)

    @property
    def pace_column(self) -> int:
        bend_columns = 2 * (self.segments + 1 + self.widened_bends) if self.has_bend_slack else 0
        return self.point_columns + self.widened_count + bend_columns

    def lower_row(self, points: tuple[int, ...], weights: tuple[float, ...]) -> Row:
        """Return the row of L for these control points."""
        column_of_point = self.column_of_point
        return tuple(column_of_point[j] for j in points), weights

    def upper_row(self, points: tuple[int, ...], weights: tuple[float, ...]) -> Row:
        """Return the row of L + z for these control points."""
        columns, _ = self.lower_row(points, weights)
        added = [(self.point_columns + j, v) for j, v in zip(points, weights, strict=True) if j < self.widened_count]
        return (*columns, *(c for c, _ in added)), (*weights, *(v for _, v in added))


@cache
def row_template_of(
    *,
    segments: int,
    widened_count: int,
    has_bends: bool,
    has_bend_slack: bool,
    order: int = 1,
    has_steps: bool = False,
    seam: int | None = None,
) -> RowTemplate:
    """Return the template for so many segments and widened control points.

    has_bends: add rows of second differences. has_bend_slack: give each its own columns, for a cost. has_steps: for order 2, add
    rows of the differences of neighbours too. seam: the segment from which on a tube repeats itself; no point from there on is
    widened.
    """
    layout = _Layout(segments=segments, widened_count=widened_count, has_bend_slack=has_bend_slack, order=order, seam=seam)
    blocks = [*_position_blocks(layout), *_pace_blocks(layout)]
    if order == 2:
        blocks += _rest_blocks(layout)
    if has_steps:
        blocks += _step_blocks(layout)
    if has_bends:
        blocks += _second_difference_blocks(layout)
    rows: list[Row] = []
    row_slices: dict[str, slice] = {}
    for name, block in blocks:
        row_slices[name] = slice(len(rows), len(rows) + len(block))
        rows.extend(map(_merge_columns, block))
    return RowTemplate(
        rows=Rows.of(rows),
        row_slices=row_slices,
        column_count=layout.pace_column + 1,
        has_bend_slack=has_bend_slack,
        column_of_point=tuple(layout.column_of_point),
        widened_count=widened_count,
    )


def _merge_columns(row: Row) -> Row:
    """Return the row with each column once, as the solver wants it: several of the last control points share a column."""
    total: dict[int, float] = {}
    for c, v in zip(*row, strict=True):
        total[c] = total.get(c, 0.0) + v
    return tuple(total), tuple(total.values())


def _position_blocks(layout: _Layout) -> Blocks:
    """Return the rows of the edges' Bezier coefficients: inside segments, where two meet, at t_c and at 0."""
    segments, lower, upper = layout.segments, layout.lower_row, layout.upper_row
    widened_segments = range(layout.widened_count - 1)  # segments and joints in which z counts
    blocks: Blocks = []
    for k, weights in enumerate(INNER_BEZIER_WEIGHTS):
        blocks.append((f"inner {k}", [lower((s + 1, s + 2), weights) for s in range(segments)]))
        blocks.append((f"inner {k}, wider", [upper((s + 1, s + 2), weights) for s in widened_segments]))
    joints = [s for s in widened_segments if s < segments - 1]
    blocks.append(("joint", [lower((s + 1, s + 2, s + 3), JOINT_WEIGHTS) for s in range(segments - 1)]))
    blocks.append(("joint, wider", [upper((s + 1, s + 2, s + 3), JOINT_WEIGHTS) for s in joints]))
    if layout.seam is None:
        end = lower((segments, segments + 1), END_WEIGHTS)
    else:
        end = lower((segments, segments + 1, segments + 2), JOINT_WEIGHTS)
    blocks.append(("end", [end]))
    blocks.append(("start", [lower((0, 1, 2), JOINT_WEIGHTS)]))
    blocks.append(("start, wider", [upper((0, 1, 2), JOINT_WEIGHTS)]))
    return blocks


SLOPE_AT_START: Terms = ((2, 0), (0.5, -0.5))  # the mean of the first two differences


def _differences(count: int) -> list[Terms]:
    """Return the Bezier coefficients of the derivative: `count` differences of control points, and the slope at 0."""
    return [*(((j + 1, j), DIFFERENCE) for j in range(1, count)), SLOPE_AT_START]


def _pace_blocks(layout: _Layout) -> Blocks:
    """Return the rows that hold the pace above each difference of control points; for order 2 above each second difference."""
    if layout.order == 1:
        lower_terms, upper_terms = _differences(layout.segments + 1), _differences(layout.widened_count)
    else:
        lower_terms = [((j, j + 1, j + 2), SECOND_DIFFERENCE) for j in range(layout.segments + 1)]
        upper_terms = lower_terms[: layout.widened_bends]
    blocks: Blocks = []
    for name, sign in (("rise", -1.0), ("fall", 1.0)):
        for block, edge_row, terms in ((name, layout.lower_row, lower_terms), (f"{name}, wider", layout.upper_row, upper_terms)):
            rows = [edge_row(points, weights) for points, weights in terms]
            blocks.append((block, [((*c, layout.pace_column), (*v, sign)) for c, v in rows]))
    return blocks


def _rest_blocks(layout: _Layout) -> Blocks:
    """Return the rows of both edges' slopes at 0, where a tube of order 2 begins at rest or gives way."""
    return [("rest", [layout.lower_row(*SLOPE_AT_START)]), ("rest, wider", [layout.upper_row(*SLOPE_AT_START)])]


def _step_blocks(layout: _Layout) -> Blocks:
    """Return the rows of the differences of control points, where a tube of order 2 has a bound on speed."""
    lower_rows = [layout.lower_row(*terms) for terms in _differences(layout.segments + 1)]
    return [("step", lower_rows), ("step, wider", [layout.upper_row(*terms) for terms in _differences(layout.widened_count)])]


def _second_difference_blocks(layout: _Layout) -> Blocks:
    """Return the rows of the second differences of control points, between which the second derivative is linear."""
    first_column = layout.point_columns + layout.widened_count
    blocks: Blocks = []
    edges = (("bend", layout.lower_row, layout.segments + 1), ("bend, wider", layout.upper_row, layout.widened_bends))
    for name, edge_row, count in edges:
        rows = [edge_row((j, j + 1, j + 2), SECOND_DIFFERENCE) for j in range(count)]
        if layout.has_bend_slack:
            rows = [((*c, first_column + 2 * j, first_column + 2 * j + 1), (*v, -1.0, 1.0)) for j, (c, v) in enumerate(rows)]
            first_column += 2 * count
        blocks.append((name, rows))
    return blocks
