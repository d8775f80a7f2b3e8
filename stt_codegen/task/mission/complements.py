"""What a formula of boxes leaves of space, as boxes: a tube that keeps out of all of them satisfies it, and no other does.

The edges of all boxes make a grid, and in each of its cells the formula is true or false everywhere. The cells in which it is
false are joined to boxes, greedily. So a tube may lie in two boxes at once where their union holds it, and all is exact.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.task.mission.formulas import And, Formula, In, parts_of
from stt_codegen.task.sets import Vector

Span = tuple[Vector, Vector]
Open = tuple[tuple[Fraction | None, ...], tuple[Fraction | None, ...]]  # a box; None where it has no end

MOST_CELLS = 1 << 22


def left_over(formula: Formula, boxes: Mapping[In, Span], dimension: int) -> list[Open]:
    """The boxes in which a formula of these boxes is false, their insides disjoint. boxes: what each `In` is about; of one that
    is kept off, what must be avoided. Raises `ValueError` where there are too many edges."""
    edges = [sorted({v for span in boxes.values() for v in (span[0][i], span[1][i])}) for i in range(dimension)]
    if np.prod([float(len(e) + 1) for e in edges]) > MOST_CELLS:
        raise ValueError(
            f"a union of {len(boxes)} boxes in {dimension} dimensions has too many edges; use fewer boxes in one choice"
        )
    wrong = ~_truth(formula, boxes, edges)
    found: list[Open] = []
    while wrong.any():
        first = np.unravel_index(int(wrong.argmax()), wrong.shape)
        low, high = [int(v) for v in first], [int(v) + 1 for v in first]
        for i in range(dimension):
            while high[i] < wrong.shape[i]:
                layer = tuple(slice(high[i], high[i] + 1) if k == i else slice(low[k], high[k]) for k in range(dimension))
                if not wrong[layer].all():
                    break
                high[i] += 1
        wrong[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] = False
        found.append(
            (
                tuple(edges[i][v - 1] if v else None for i, v in enumerate(low)),
                tuple(edges[i][v - 1] if v <= len(edges[i]) else None for i, v in enumerate(high)),
            )
        )
    return found


def _truth(formula: Formula, boxes: Mapping[In, Span], edges: list[list[Fraction]]) -> npt.NDArray[Any]:
    """Whether the formula is true, cell by cell: cell k of a dimension lies between its edges k - 1 and k."""
    if isinstance(formula, In):
        found = np.zeros([len(e) + 1 for e in edges], dtype=bool)
        lower, upper = boxes[formula]
        found[tuple(slice(bisect_left(e, a) + 1, bisect_left(e, b) + 1) for e, a, b in zip(edges, lower, upper, strict=True))] = (
            True
        )
        return ~found if formula.kept else found
    parts = [_truth(p, boxes, edges) for p in parts_of(formula)]
    return np.asarray((np.logical_and if isinstance(formula, And) else np.logical_or).reduce(parts))
