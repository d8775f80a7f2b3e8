"""What a refined design is: two uniform cubic B-splines for each dimension, in exact integers.

The tube's edge at spline time u = K t / t_c, in segment k = floor(u) with s = u - k, is

    gamma(u) = 2**-bits * sum_{j=0..3} table[k + j] * w_j(s),      w = ((1-s)^3, 3s^3-6s^2+4, -3s^3+3s^2+3s+1, s^3)

so a table entry is a control point divided by 6: the division is done here, once, and not on the target.
The numbers are dyadic, hence exact in the emitted file, and the certificate is about these very numbers. The design search
(design/refine.py) or the user (design/user_tubes.py) makes them. The lemmas `refined.*` prove what the edges are between.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, asdict, dataclass
from fractions import Fraction
from functools import cached_property
from numbers import Integral
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from stt_codegen import reference
from stt_codegen.design_kinds import CAPABILITIES, Capabilities, DesignKind
from stt_codegen.designs.tube import LOWER, UPPER, Array, Design, require_time
from stt_codegen.errors import BadInput

COEFFICIENT_BIT_LIMIT = 50  # of a table entry; Bezier coefficients are up to 6 times as large


@dataclass(frozen=True)
class RefinedDesign:
    """A refined tube.

    table: control points over 6 in units of 2**-bits, `table[j][i]` = (lower, upper) for control point j = 0..K+2 and
    dimension i. prescribed_time: t_c in seconds. filter: lambda by component, for a plant of order 2 whose v + lambda x is held
    in the tube (L' + lambda L, R' + lambda R); empty for order 1. seam: the first segment of the part that is repeated for ever,
    up to t_c; the first three control points of that part equal the last three, so that the tube is C2 there too. None for a tube
    that is constant from t_c on.
    """

    prescribed_time: Fraction
    segments: int
    bits: int
    table: tuple[tuple[tuple[int, int], ...], ...]
    _: KW_ONLY
    filter: tuple[Fraction, ...] = ()
    seam: int | None = None

    kind: ClassVar[DesignKind] = "refined"
    is_stateful: ClassVar[bool] = False  # the tube is a function of time alone

    def __post_init__(self) -> None:
        """Raise `BadInput` where the numbers are of no tube, or of one whose Bezier coefficients are not exact in a double.

        The certificate and the emitted file rest on all of this, and a user may change any field.
        """
        require_time(self.prescribed_time)
        count, n = len(self.table), len(self.table[0]) if self.table else 0
        if self.segments < 1 or count != self.segments + 3:
            raise BadInput(f"tube: has {count} control points; {self.segments} segments need {self.segments + 3}, and at least 4")
        if not n or any(len(row) != n or any(len(pair) != 2 for pair in row) for row in self.table):
            raise BadInput("tube: has rows of unequal length in its table; each has a pair, lower and upper, for every dimension")
        if not all(isinstance(v, Integral) for row in self.table for pair in row for v in pair):
            raise BadInput("tube: has a number in its table that is not whole; entries are counted in units of 2**-bits")
        if self.filter and (len(self.filter) != n or not all(isinstance(v, Fraction) and v > 0 for v in self.filter)):
            raise BadInput(f"tube: has the filter {self.filter!r}; it is empty, or has {n} Fractions above 0")
        if self.seam is not None and not 0 <= self.seam < self.segments:
            raise BadInput(f"tube: has its seam at segment {self.seam}; it is one of the {self.segments} segments, or None")
        if self.coefficient_bits > COEFFICIENT_BIT_LIMIT:
            raise BadInput(f"tube: a coefficient needs more than {COEFFICIENT_BIT_LIMIT} bits")

    @property
    def capabilities(self) -> Capabilities:
        return CAPABILITIES[self.kind]

    @property
    def dimension(self) -> int:
        return len(self.table[0])

    @cached_property
    def coefficient_bits(self) -> int:
        """The number of bits of the largest table entry, without its sign."""
        return max(abs(v) for row in self.table for pair in row for v in pair).bit_length()

    @property
    def size(self) -> str:
        """How large the design is, in words."""
        return f"{self.segments} segments"

    @property
    def parts(self) -> int | None:
        """The number of parts of equal length into which its data divide the time: the segments."""
        return self.segments

    @property
    def cycle_begin(self) -> Fraction | None:
        return None if self.seam is None else self.prescribed_time * self.seam / self.segments

    def numbers(self) -> dict[str, Any]:
        """Return all numbers by name; the filter and the seam only where there are any."""
        return {name: value for name, value in asdict(self).items() if name not in ("filter", "seam") or value not in (None, ())}

    def edges_at(self, t: Array) -> tuple[Array, Array]:
        """Return lower and upper edges at any times t, shape (P, n) each, by `reference`."""
        low, high = reference.tube(self.integers(), self.unit, self.prescribed_time, t)
        return low.astype(float), high.astype(float)

    @property
    def unit(self) -> Fraction:
        """The value of one table step, 2**-bits."""
        return Fraction(1, 1 << self.bits) if self.bits >= 0 else Fraction(1 << -self.bits)

    def integers(self) -> npt.NDArray[np.int64]:
        """Return the table as an array of shape (K + 3, n, 2)."""
        return np.array(self.table, dtype=np.int64)

    def bezier(self) -> npt.NDArray[np.int64]:
        """Return the Bezier coefficients of every segment, exact, in units of 2**-bits: shape (K, n, 2, 4)."""
        q = self.integers()
        q0, q1, q2, q3 = q[:-3], q[1:-2], q[2:-1], q[3:]
        return np.stack([q0 + 4 * q1 + q2, 4 * q1 + 2 * q2, 2 * q1 + 4 * q2, q1 + 4 * q2 + q3], axis=-1)

    def windows(self) -> npt.NDArray[np.int64]:
        """Return the coefficients of `bezier`, and last those of the time from t_c on: shape (K + 1, n, 2, 4).

        From t_c on the tube is constant, or the repeated part begins again.
        """
        segments = self.bezier()
        after = np.repeat(segments[-1:, ..., 3:], 4, axis=-1) if self.seam is None else segments[self.seam : self.seam + 1]
        return np.concatenate([segments, after])

    def largest_steps(self) -> npt.NDArray[np.int64]:
        """Return the largest |difference| of neighbouring coefficients of `windows`, (K + 1, n), in units of 2**-bits.

        Times `speed_per_step` it bounds the speed of both edges in that window (the lemma `sampled.windows`).
        """
        return np.asarray(np.abs(np.diff(self.windows(), axis=-1)).max(axis=(2, 3)))

    @property
    def speed_per_step(self) -> Fraction:
        """The speed of an edge whose coefficients differ by one unit of 2**-bits, in units per second."""
        return 3 * self.unit * self.segments / self.prescribed_time

    def edge_speed_bounds(self) -> tuple[Fraction, ...]:
        """Return by dimension a bound on the speed of both edges at all times, in units per second."""
        return tuple(int(v) * self.speed_per_step for v in self.largest_steps().max(axis=0))

    def smallest_hull_width(self) -> Fraction:
        """Return the least Bezier coefficient of the width, which bounds it from below; at most 0 where the edges cross."""
        edges = self.bezier()
        return int((edges[:, :, UPPER] - edges[:, :, LOWER]).min()) * self.unit

    def kink(self, order: int = 1) -> npt.NDArray[np.int64]:
        """Return by dimension by how many steps the control points differ that must agree for a smooth tube at t_c.

        Of a repeated tube these are the last three and the first three of the repeated part. Of a tube that is constant from t_c
        on they are, for order 1, the last and the last but two; for order 2 all of the last three.
        """
        q = self.integers()
        expected = q[-3:-2] if self.seam is None else q[self.seam : self.seam + 3]
        last = q[-order:] if self.seam is None else q[-3:]
        return np.asarray(np.abs(last - expected).max(axis=(0, 2)))


def require_refined(design: Design) -> RefinedDesign:
    """Return the design, which is refined wherever this is called: a table of kinds led there, or an option of refined tubes."""
    if not isinstance(design, RefinedDesign):
        raise TypeError(f"a refined tube is needed here; this one is {design.kind}")
    return design
