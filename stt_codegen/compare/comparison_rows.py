"""The results of a comparison: one row for each quantity of a backend. The files *_comparison.py of this folder add the rows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.backend import Backend

Array = npt.NDArray[Any]
BackendMaker = Callable[[EmittedController], Backend]


@dataclass(frozen=True)
class ComparisonRow:
    """The comparison of one quantity of one backend with the reference.

    error: the largest one. ulps: the same in units in the last place of the quantity's scale (see `RowCollector`). share: the
    largest share of the bound that an error takes. points: how many values are compared."""

    backend: str
    quantity: str
    error: float
    ulps: float
    share: float
    _: KW_ONLY
    points: int

    @property
    def holds(self) -> bool:
        """Whether every error is within its bound."""
        return self.share <= 1.0


class TubeWithErrors(NamedTuple):
    """The reference's edges (P, n), and a bound on how far the arithmetic moves an edge: (n,) or (P, n)."""

    lower: Array
    upper: Array
    error: Array


class RowCollector:
    """Collects the rows of one backend; eps is half a unit in the last place of 1 in its scalar.

    Units in the last place are those of the largest edge (tube), the largest rate, 1 (e), max(1, |epsilon|), xi, and
    |k| xi max(1, |epsilon|) for u: the sizes whose rounding each quantity inherits."""

    def __init__(self, backend: str, eps: float) -> None:
        self.backend, self.eps = backend, eps
        self.rows: list[ComparisonRow] = []

    def add(
        self, quantity: str, computed: npt.ArrayLike, exact: npt.ArrayLike, bound: npt.ArrayLike, scale: npt.ArrayLike
    ) -> None:
        """Add the row of a quantity: what the backend computes, the reference's values, the bounds, and the quantity's scale.

        All are of one shape, or broadcast to it. A NaN counts as an infinite error."""
        reference_values = np.asarray(exact, dtype=np.longdouble)
        error = np.abs(np.asarray(computed, dtype=np.longdouble) - reference_values)
        error = np.where(np.isnan(error), np.inf, error)
        ulp = 2 * self.eps * np.exp2(np.floor(np.log2(np.maximum(np.asarray(scale, dtype=float), 1e-300))))
        limit = np.maximum(np.asarray(bound, dtype=np.longdouble), 1e-300)
        share = np.where(np.isfinite(limit), error / limit, np.inf)  # an infinite bound proves nothing, so it does not hold
        largest_error, largest_ulps = float(error.max()), float((error / ulp).max())
        self.rows.append(
            ComparisonRow(self.backend, quantity, largest_error, largest_ulps, float(share.max()), points=error.size)
        )

    def add_count(self, quantity: str, difference_count: float, points: int) -> None:
        """Add a row that holds if none of so many points differs."""
        share = 2.0 if difference_count else 0.0
        self.rows.append(ComparisonRow(self.backend, quantity, difference_count, difference_count, share, points=points))

    def add_status(self, computed: Array, exact: Array, clearance: Array, label: str = "") -> None:
        """Add statuses (P,); they may differ only where x is too near an edge.

        clearance (P, n): how much farther x is from its nearest edge than the arithmetic can move it."""
        is_wrong = (computed != exact) & (clearance.min(axis=1) > 0)
        self.add_count("status" + label, float(is_wrong.sum()), len(computed))


@dataclass(frozen=True)
class ComparedBackend:
    """A backend of a controller, the function that makes it, and the number of points to compare.

    `references` keeps what the reference computed for an adaptive design, by scalar type, for all backends of that type."""

    controller: EmittedController
    make_backend: BackendMaker
    backend: Backend
    points: int
    references: dict[str, Any] = field(default_factory=dict)
