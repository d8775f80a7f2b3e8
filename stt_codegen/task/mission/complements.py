"""The complement of a formula of boxes, as boxes: a tube satisfies the formula just where it avoids all of these.

The edges of all boxes make a grid, and in each of its cells the formula is true or false everywhere. The cells in which it is
false are joined to boxes, greedily. So a tube may lie in two boxes at once where their union contains it. All is exact.

The constraints of a mission (constraints.py) call it; docs/missions.md has the argument.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.task.mission.formulas import And, Formula, InRegion, parts_of
from stt_codegen.task.sets import Vector

Span = tuple[Vector, Vector]
OpenBox = tuple[tuple[Fraction | None, ...], tuple[Fraction | None, ...]]  # lower and upper edges; None where there is none

CELL_COUNT_LIMIT = 1 << 22


def complement_boxes(formula: Formula, boxes: Mapping[InRegion, Span], dimension: int) -> list[OpenBox]:
    """Return boxes with disjoint interiors that together are where a formula of boxes is false.

    boxes: the edges of each `InRegion`, of a negated one those of what must be avoided. Raises `ValueError` where there are too
    many edges.
    """
    edges = [sorted({v for span in boxes.values() for v in (span[0][i], span[1][i])}) for i in range(dimension)]
    if np.prod([float(len(e) + 1) for e in edges]) > CELL_COUNT_LIMIT:
        raise ValueError(
            f"a union of {len(boxes)} boxes in {dimension} dimensions has too many edges; use fewer boxes in one choice"
        )
    return [
        (
            tuple(edges[i][v - 1] if v else None for i, v in enumerate(low)),
            tuple(edges[i][v - 1] if v <= len(edges[i]) else None for i, v in enumerate(high)),
        )
        for low, high in _blocks_of(~_truth(formula, boxes, edges))
    ]


def _blocks_of(cells: npt.NDArray[Any]) -> Iterator[tuple[list[int], list[int]]]:
    """Yield disjoint blocks of cells, from `low` up to but without `high`, that cover all true cells; the array becomes false."""
    dimension = cells.ndim
    while cells.any():
        first = np.unravel_index(int(cells.argmax()), cells.shape)
        low, high = [int(v) for v in first], [int(v) + 1 for v in first]
        for i in range(dimension):
            while high[i] < cells.shape[i]:
                layer = tuple(slice(high[i], high[i] + 1) if k == i else slice(low[k], high[k]) for k in range(dimension))
                if not cells[layer].all():
                    break
                high[i] += 1
        cells[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] = False
        yield low, high


def _truth(formula: Formula, boxes: Mapping[InRegion, Span], edges: Sequence[Sequence[Fraction]]) -> npt.NDArray[Any]:
    """Return whether the formula is true, cell by cell: cell k of a dimension lies between its edges k - 1 and k."""
    if isinstance(formula, InRegion):
        is_inside = np.zeros([len(e) + 1 for e in edges], dtype=bool)
        ends = zip(edges, *boxes[formula], strict=True)
        is_inside[tuple(slice(bisect_left(e, a) + 1, bisect_left(e, b) + 1) for e, a, b in ends)] = True
        return ~is_inside if formula.is_negated else is_inside
    parts = [_truth(p, boxes, edges) for p in parts_of(formula)]
    return np.asarray((np.logical_and if isinstance(formula, And) else np.logical_or).reduce(parts))
