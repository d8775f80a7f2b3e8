"""A controller in integers of 32 bits: that nothing leaves 32 bits, how far it is off, and the numbers of its listing.

x and the edges count units of 2^-unit_bits, v as many a second, u units of 2^-u_bits, time counts ticks. The constants that the
tool chose stand in the certificate (`integers`); what they must satisfy is asked here. curves.py checks the rows of the tables.

No value leaves 32 bits, whatever the arguments. To see it read listing_integers.c from top to bottom:
  segment   `passed` is below scale 2^15: (count/2^16 + 1) scale < 2^31 is asked, and K 2^bits <= 2^31 for `place`
  weights   functions of s alone, tried at every s: w0, w2 <= 2^15, w1 <= 65535; together off by WEIGHT_ERROR
  edge      steps are below 2^15, so products with weights are below 2^31, those with w0 and w2 below 2^30; 6 |q| < far, so an
            edge is below far + 2^18 (far = 2^28, or 2^26 for order 2)
  distances x is held within far: distances are below 2 far + 2^18, their sum and difference below 4 far + 2^20 <= 2^31
  rates     3 middle <= 9/8 2^30; r1 <= 65535 and r0, r2 <= 2^15 are asked; a rate V = D (r1 + r0 + r2)/2^places + 2 < 2^28 - 2^20
            is asked, so v + lambda x, with lambda <= 4, keeps 2 (2^28 + V + 2^29 + 2^20) < 2^31
  curve     0 <= bend <= slope < 2^15 and slope/2 < level < 2^16: every product is below 2^31, the result has 16 bits
  law       a width is moved up to [2^30, 2^31), what is at most the width as far: below 2^31; `upper` makes nothing larger; m is
            from 1 to that of `lowest`, for which the curves have rows; places are at most `offset`, which is at most 31
"""

import math
from fractions import Fraction
from typing import Any

from . import source
from .curves import check_curves, steep
from .exact import Unusable, require
from .inertia import filtered_tube, widths
from .law import Law
from .limits import emitted_limits
from .period import logarithm
from .tube import Tube

TABLES = {"coefficients": 32, "levels": 16, "slopes": 16, "bends": 16, "places": 8, "gains": 16, "offsets": 8, "limits": 32}
CONSTANTS, CONSTANTS_2 = "bits scale narrow top lowest u_bits", "x_narrow mantissa rate_down rate_places more"  # the last of order 2
WEIGHT_ERROR = Fraction(17178254800, 1 << 48)  # of an edge, in steps, through its weights: the largest for all s (meaning.py)
LAW_ERROR = Fraction(1, 1 << 10)
SCALAR_BITS = 20
UNITY = 1 << 30  # 1, as e and y count it


class Integers:
    def __init__(self, text: bytes, task: Any, stated: Any) -> None:
        """text: the C; stated: the certificate's `integers`."""
        foreign = task.inline or task.scales or task.outside != "return" or task.repeats or task.differs or len({*task.e_max}) > 1
        if foreign or task.tick is None or task.u_max is None or ((task.period or 0) / task.tick).denominator != 1:
            raise Unusable("the task asks for something that no controller in integers has, or lacks something that one needs")
        self.task, self.order = task, task.order
        names = {*CONSTANTS.split(), *(CONSTANTS_2.split() if task.order == 2 else ())}
        is_known = {*stated} == names and all(type(v) is int for v in stated.values())
        require(is_known and abs(stated["u_bits"]) < 64, "the certificate's `integers` is unknown")
        self.stated, self.far = stated, 1 << (28 if task.order == 1 else 26)
        self.tables = {name: source.integer_table(text, f"{task.name}_{name}", bits) for name, bits in TABLES.items()}
        if task.order == 2:
            self.tables["filters"] = source.integer_table(text, f"{task.name}_filters", 16)
        lengths = {len(self.tables[name]) for name in ("gains", "offsets", "limits", *(["filters"] if task.order == 2 else []))}
        require(lengths == {task.n}, "a table of the C has another length than the task")

    # ---- P7

    def check_clock(self, tube: Tube) -> None:
        """Compute `clock_error`: how many segments the place of a tick is off. It is scale/2^16 a tick, rounded down and held a unit
        before the end, in units of 2^-bits; s has 16 bits of it; a tick's length is right within half a unit."""
        task, bits, scale = self.task, self.stated["bits"], self.stated["scale"]
        step, self.last = task.tick * tube.segments / task.t_c, math.ceil(task.t_c / task.tick)
        is_right = 16 <= bits < 31 and tube.segments << bits <= 1 << 31 and abs(scale - step * 2 ** (bits + 16)) <= Fraction(1, 2)
        is_small = scale > 0 and self.last < 1 << 31 and ((self.last >> 16) + 1) * scale < 1 << 31
        require(is_right and is_small, "the C counts other ticks than the task's")
        self.clock_error = Fraction(1, 1 << bits) * (Fraction(self.last, 1 << 17) + 2) + (Fraction(1, 1 << 16) if bits > 16 else 0)

    def arithmetic_error(self, tube: Tube, _bits: int, order: int = 0) -> list[Fraction]:
        """Return P7 by dimension, for edges (order 0) or their rates (order 1). With d0, d1, d2 the steps between the four entries, an
        edge is 6 q1 + d1 + d1 (3 s + 3 s^2 - 2 s^3) + d2 s^3 - d0 (1 - s)^3, and its rate d0 3 (1 - s)^2 + d1 (3 + 6 s (1 - s)) +
        d2 3 s^2, a segment. A step times a weight is exact, and so are sums, but for two that are rounded down by less than a unit.
        s is late. The three polynomials of a rate are off by 9/4 2^-28 together, their sum is 6, each result is rounded to a unit;
        a rate has two units more, for v, rounded to a unit, and a distance times lambda, rounded down."""
        per, weight_error, errors = Fraction(1), WEIGHT_ERROR, []
        if order:
            per, places, down = tube.segments / tube.t_c, self.stated["rate_places"], self.stated["rate_down"]
            emitted = Fraction(self.stated["mantissa"]) * Fraction(2) ** (12 - down - places)  # segments a second, in the C
            rounding = 3 * (Fraction(1, 2) + Fraction(1, 1 << down)) / (1 << places)
            weight_error = 6 * abs(emitted - per) + 3 * emitted * Fraction(9, 1 << 30) + rounding
        for i in range(tube.n):
            step = max(abs(b[i][side] - a[i][side]) for a, b in zip(tube.table, tube.table[1:]) for side in (0, 1))
            error = step * weight_error + tube.fastest(i, order + 1) * self.clock_error * per + (2, 4)[order]
            errors.append(error * tube.unit)
        return errors

    # ---- nothing leaves 32 bits

    def _check_ranges(self, tube: Tube) -> None:
        """Require what the docstring above says is asked of tables and constants."""
        stated, tables = self.stated, self.tables
        steps = [abs(w - v) for a, b in zip(tube.table, tube.table[1:]) for p, q in zip(a, b) for v, w in zip(p, q)]
        farthest = 6 * max(abs(v) for row in tube.table for pair in row for v in pair)
        require(max(steps) < 1 << 15, "a step of the C's table has more than 15 bits")
        require(farthest < self.far, "the tube is beyond where the C holds x")
        is_positive = all(0 < stated[name] < UNITY for name in ("lowest", "narrow"))
        require(is_positive and 0 <= stated["top"] < UNITY, "top, narrow or lowest of the C is out of range")
        rows = 8 * (31 - stated["lowest"].bit_length()) + 16
        require(rows <= len(tables["places"]), "the C has no row for the least y")
        require(max(tables["offsets"]) <= 31 and min(tables["limits"]) >= 0, "an offset or a limit of the C is out of range")
        if self.order == 2:
            m, down, places = stated["mantissa"], stated["rate_down"], stated["rate_places"]
            is_inside = 0 < m < 1 << 16 and 0 < down < 31 and 0 <= places < 31 and stated["more"] in (1, 2, 4)
            require(is_inside and 0 < stated["x_narrow"] < UNITY, "a constant of the C is out of range")
            middle, outer = (((part * m >> 16) + (1 << down - 1) >> down) for part in (9 << 27, 3 << 28))
            fastest = max(steps) * (middle + 2 * outer) / Fraction(1 << places) + 2
            is_inside = middle < 1 << 16 and outer <= 1 << 15 and fastest < (1 << 28) - (1 << 20)
            require(is_inside, "the rates of the C are out of range")

    # ---- the law

    def _check_law(self, tube: Tube, gain: list[Fraction], spans: list[tuple[Fraction, Fraction]], x_bits: int) -> None:
        """Require (13) within r = 2^-10, relative and in epsilon, as P9 takes it. spans: by component the least and the largest width
        of the tube that holds it, in units, less and more by what the arithmetic moves it.

        With e the normalized error and d the width (13) is k/d |e| H(1 - |e|). Let a and b be what 1/d and H are off by, c what
        the gain is. |e| and y = 1 - |e| are off by a too, and rounded down to 2^-30. -y H'/H is between 0 and 3/2: 1 - e times
        the slope of -ln(1 - e^2) is 2 e/(1 + e) <= 1, and times that of ln(atanh(e)/e) at most e/(1 + e) <= 1/2. So H is off by
        a power of 3/2 at most; 2 is taken. Beyond e_max |e| is at most `top`, y at least `lowest`. `push` rounds three products
        down, by less than 3 of its units, and e is rounded down by one: |e| counts as so much less. At last u is rounded down by
        less than a unit, and xi is at least 4/d."""
        r, e_max, rest, places = LAW_ERROR, self.task.e_max[0], 1 - self.task.e_max[0], self.tables["places"]
        a, steep_rows, base = check_curves(self.tables)
        b, top, lowest = max(v for v, _ in steep_rows), Fraction(self.stated["top"], UNITY), Fraction(self.stated["lowest"], UNITY)
        off = a + 1 / (rest * UNITY)  # of the least y, relative
        require(max(a, b, off) <= r, "the curves of the C are not 1/d and H, or e_max is too near 1 for integers")
        over, rise = (1 - a) / 2, min(v for _, v in steep_rows) * (1 - b) / (1 << 16)  # the least of both, over 2^16
        for i, k in enumerate(gain):
            mantissa, offset, limit, name = (*(self.tables[key][i] for key in ("gains", "offsets", "limits")), self.task.names[i])
            exact = abs(k) * Fraction(2) ** (x_bits + self.stated["u_bits"] + offset - 28 - base)
            require(abs(mantissa - exact) <= Fraction(1, 2), f"the gain of {name} of the C is not the certificate's")
            require(self.stated["narrow"] <= spans[i][0], "the law of the C takes the tube to be wider than it is")
            c = Fraction(1, 2) / exact
            inside = (1 + a) ** 2 * (1 + b) * (1 + c) / (1 - off) ** 2
            beyond = top / e_max * steep(lowest)[1] / steep(rest)[0] * (1 + a) * (1 + b) * (1 + c)
            less = min(1 - a, top / e_max) * (1 - a) * (1 - b) * (1 - c) / max(1 + a, lowest / rest) ** 2
            relative = max(inside - 1, beyond - 1, 1 - less)
            lost = (1 + 3 / (over * rise * Fraction(mantissa, 1 << 16))) * (1 + relative) / UNITY
            lost *= logarithm((1 + e_max) / (1 - e_max))[1] / e_max  # the largest 2 atanh(e)/e
            lost += Fraction(2) ** -self.stated["u_bits"] * spans[i][1] * tube.unit / (4 * abs(k))
            require(relative <= r and lost <= r * (1 - relative), f"u of {name} of the C is off by more than 2^-10")
            for row, (_, smallest) in enumerate(steep_rows, 16):
                octave, head = divmod(row - 16, 8)
                if places[row] > offset - (31 - self.stated["narrow"].bit_length()):  # u would move up: it must be at its limit
                    e = min(1 - a - Fraction(9 + head, 16 << octave) - Fraction(2, UNITY), top)
                    size = e * UNITY * smallest * (1 - b) * over * mantissa / (1 << 32) - 3
                    require(limit <= size, f"u of {name} of the C may be lost before it is at its limit")

    def prove(self, tube: Tube, law: Law, x_bits: int, has_phase: bool, starts: Any) -> tuple[set[str], dict[str, Any]]:
        """Prove all but P7: the ranges, the law, and that no state within the tube is beyond where the C holds x and v. Return the
        options and the numbers of the listing."""
        task, stated, filters = self.task, self.stated, law.filters
        self._check_ranges(tube)
        limit = [v * Fraction(2) ** stated["u_bits"] for v in emitted_limits(task, SCALAR_BITS)]
        require(self.tables["limits"] == limit, "the limits of the C are not u_max")
        spans = []
        for i, error in enumerate(law.edge_error):
            width = [h - v for piece in tube.pieces for v, h in zip(*piece[i])]
            spans.append((min(width) - 2 * error / tube.unit, max(width) + 2 * error / tube.unit))
        if task.order == 2:
            is_same = self.tables["filters"] == [s * (1 << 16) / stated["more"] for s in filters]
            is_wide = stated["x_narrow"] <= min(v for v, _ in spans)
            require(is_same and is_wide, "filters or narrow of the C are not the tube's")
            edges, per = filtered_tube(task, tube, filters)[0], tube.segments / task.t_c
            for i, s in enumerate(filters):
                require(tube.fastest(i) * per + s * spans[i][1] < 1 << 28, "the tube's rates are beyond where the C holds v")
                z, error = [v / tube.unit for v in widths(edges, i)], 2 * (law.rate_error[i] + s * law.edge_error[i]) / tube.unit
                spans[i] = (min(z) - error, max(z) + error)
        self._check_law(tube, law.gain, spans, x_bits)
        options = {f"order {task.order}", "long" if self.last >= 1 << 16 else "short", "fine" if stated["bits"] > 16 else "coarse"}
        options |= {"positive" if law.gain[0] > 0 else "negative", "more" if stated.get("more", 1) > 1 else "all"}
        options |= {name for name, v in (("period", task.period), ("selftest", task.selftest), ("phase", has_phase)) if v}
        return options, self._values(tube, x_bits, starts)

    def _values(self, tube: Tube, x_bits: int, starts: dict[str, list[Fraction]]) -> dict[str, Any]:
        """Return the numbers of the listing by name."""
        task, stated, n = self.task, self.stated, self.task.n
        a, b = (1 / task.tick).as_integer_ratio()
        bits = {"x": x_bits, "u": stated["u_bits"]}
        return {
            **stated, **self.tables, **{name: [int(v) for v in table] for name, table in starts.items()}, "n": n, "pairs": 2 * n,
            **{f"{name}_scale": f"{2**v}.0" if v >= 0 else f"(1.0 / {2**-v}.0)" for name, v in bits.items()},
            **{f"{name}_bits": f"({v})" if v < 0 else v for name, v in bits.items()}, **{f"row_{j}": 2 * n * j for j in (1, 2, 3)},
            "entries": len(self.tables["coefficients"]), "rows": len(self.tables["places"]), "ticks": self.last, "far": self.far,
            "tick_end": (tube.segments << stated["bits"]) - 1, "fine": stated["bits"] - 16,
            "half": 1 << stated.get("rate_down", 1) - 1, "share": source.rounded(task.start_share, 53, math.floor),
            "ticks_a_second": f"INT32_C({a})" if b == 1 else f"({a}.0 / {b}.0)", "ticks_proved": int((task.period or 0) / task.tick),
        }  # fmt: skip
