"""The constants of (13) in integers, for one task and tube."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from stt_codegen.controller.integers.curves import RISE_BITS, over_rows, rise_rows
from stt_codegen.controller.integers.integer_kernels import HALF_WORD
from stt_codegen.decimals import by_component, decimal
from stt_codegen.designs import LOWER, UPPER, RefinedDesign, filtered_edges
from stt_codegen.errors import BadInput
from stt_codegen.program import INT, Table, round_down
from stt_codegen.task import Task

NARROW = 256  # units: a narrower tube counts as so wide
ROOM = 64  # units by which the arithmetic moves both edges together at most, of a tube whose width matters
ONE = 1 << 30
LEAST_SIZE = ONE >> 4  # times |e|: the size of `push` is above that, h being above 0.43 2^16, r and the gain above 0.49 2^16
LOOSE = Fraction(1, 1 << 13)  # above what 1/width is wrong by, relative


@dataclass(frozen=True)
class FixedLaw:
    """Constants of (13) in integers, for units of 2^-bits of x and a tube whose width is at least `narrow` units."""

    gain: tuple[Fraction, ...]
    u_max: tuple[Fraction, ...]
    e_max: Fraction
    bits: int
    narrow: int

    @property
    def top(self) -> int:
        """|e| is held within this, in 2^-30: not below e_max, whatever 1/width is wrong by."""
        return min(ONE - 1, math.ceil(self.e_max * (1 + LOOSE) * ONE))

    @property
    def lowest(self) -> int:
        """y = 1 - |e| is held from there on, in 2^-30: not above 1 - e_max, whatever 1/width is wrong by."""
        return math.floor((1 - self.e_max) * (1 - LOOSE) * ONE)

    @property
    def octaves(self) -> int:
        """How many times y may be halved below 1."""
        return 31 - self.lowest.bit_length()

    @cached_property
    def places(self) -> tuple[int, ...]:
        """By row of the curve H, by how many places u moves up; at least 0, for a row near y = 1 has one less than the first."""
        rows = rise_rows(self.octaves)
        return tuple(r.places - rows[0].places + 1 for r in rows)

    @cached_property
    def base(self) -> int:
        """places stand for 2^(places - base)."""
        return 1 - rise_rows(self.octaves)[0].places

    def _split(self, gain: Fraction, u_bits: int) -> tuple[int, int]:
        """Mantissa of 16 bits and exponent of the gain for units of x and u."""
        whole = gain * Fraction(2) ** (self.bits + u_bits)
        exponent = math.frexp(float(whole))[1] - 16
        mantissa = round(whole / Fraction(2) ** exponent)
        return (mantissa, exponent) if mantissa < HALF_WORD else (mantissa >> 1, exponent + 1)

    @cached_property
    def u_bits(self) -> int:
        """So many bits of u's fraction that |u| is right below u_max: u is moved down alone, by at least 0 places; where it would
        have to move up, the size before is beyond u_max already. Raises `BadInput` where u_max has then less than 20 bits."""
        up = 31 - self.narrow.bit_length()  # of the narrowest tube
        most = 30 - math.ceil(math.log2(max(self.u_max)))
        for bits in range(most, most - 60, -1):
            room = min(self._offset(k, bits) for k in self.gain) - up
            tight = [r for r, p in zip(rise_rows(self.octaves), self.places, strict=True) if p > room]
            far = min((1 - r.begin - r.length for r in tight), default=Fraction(1))  # the least |e| of these rows
            if max(self.u_max) * 2**bits <= far * LEAST_SIZE:
                break
        if min(self.u_max) * 2**bits < 1 << 19:
            known = math.floor(min(self.u_max) * Fraction(2) ** bits).bit_length()
            told = f"the least of u_max, {decimal(min(self.u_max))}, has {known} bits"
            why = f"beside gain {by_component(self.gain)} and u_max {by_component(self.u_max)}, and needs 20"
            raise BadInput(
                f"control.u_max: in integers of 32 bits {told} {why}; make gains and limits of the components more alike, lower "
                'control.gain, raise the least u_max or tube.min_width, or use emit.scalar = "float"'
            )
        return bits

    @cached_property
    def mantissas(self) -> tuple[int, ...]:
        return tuple(self._split(abs(k), self.u_bits)[0] for k in self.gain)

    @property
    def offsets(self) -> tuple[int, ...]:
        return tuple(self._offset(k, self.u_bits) for k in self.gain)

    def _offset(self, gain: Fraction, u_bits: int) -> int:
        """u is size moved down by offset - n - places: e in 2^-30, H = h 2^(places - base), 1/width = r 2^(n - 46), the gain's
        exponent, and 2^48 that the three products of `push` cut off: 30 + base + 46 - 48 - exponent."""
        return 28 + self.base - self._split(abs(gain), u_bits)[1]

    @cached_property
    def limits(self) -> tuple[int, ...]:
        """The largest |u|, in its units: u_max to 20 bits."""
        return tuple(math.floor(round_down(v, "fixed") * Fraction(2) ** self.u_bits) for v in self.u_max)


def law_of(task: Task, design: RefinedDesign) -> FixedLaw:
    """The constants of (13) for this task and tube; for order 2 for the filtered one."""
    assert task.u_max is not None  # task/checks/field_checks.py
    return FixedLaw(
        task.gain, task.u_max, max(task.e_max), design.bits, narrow_of(narrowest(design)[bool(design.filter)] / design.unit)
    )


def narrowest(design: RefinedDesign) -> tuple[Fraction, Fraction]:
    """The least width of the tube, and for order 2 of the filtered one, in the task's units, the latter a second."""
    table = design.integers()
    own = 6 * int((table[:, :, UPPER] - table[:, :, LOWER]).min()) * design.unit
    if not design.filter:
        return own, own
    pieces = filtered_edges(design)
    return own, int((pieces.coefficients[:, :, UPPER] - pieces.coefficients[:, :, LOWER]).min()) * pieces.unit


def narrow_of(units: Fraction) -> int:
    """A power of two below a width in units, less what the arithmetic may take; at least NARROW."""
    return max(NARROW, 1 << max(0, math.floor(units - ROOM).bit_length() - 1))


def table(name: str, values: tuple[int, ...], row: int, *doc: str) -> Table:
    return Table(name, tuple(map(Fraction, values)), row, doc, INT)


def law_tables(law: FixedLaw) -> tuple[Table, ...]:
    rows = (*over_rows(), *rise_rows(law.octaves))
    doc = (
        f"Quadratics level - (slope - bend t) t, by row: {len(over_rows())} for 1/d, d in [2^30, 2^31), then",
        f"{1 << RISE_BITS} for each octave of y, for H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)), which also moves up, by:",
    )
    return (
        table("levels", tuple(r.level for r in rows), 1, *doc),
        table("slopes", tuple(r.slope for r in rows), 1),
        table("bends", tuple(r.bend for r in rows), 1),
        table("places", (*(0 for _ in over_rows()), *law.places), 1),
        table("gains", law.mantissas, len(law.gain), "By component: the gain, 16 bits of it."),
        table("offsets", law.offsets, len(law.gain), "By how many places less u moves up."),
        table("limits", law.limits, len(law.gain), "The largest |u|."),
    )
