"""A controller in integers of 32 bits: no value leaves 32 bits, how wrong its arithmetic is, and the numbers of its listing.

x and the edges count units of 2^-unit_bits, v as many a second, u units of 2^-u_bits, and time counts ticks. The certificate
states the constants that the tool chose (`integers`); this file says what they must satisfy. curves.py checks the tables of 1/d
and H.

Why no value leaves 32 bits, whatever the arguments are. Where it says "required", a comparison below requires it.
  segment    (last/2^16 + 1) clock_scale < 2^31 is required, so `passed` fits; so is K 2^clock_bits <= 2^31, so `place` fits
  weights    depend on s alone, and every s was tried (meaning.py): w0, w2 <= 2^15, w1 <= 65535
  edge_at    steps d < 2^15 are required, so products with weights are below 2^31, and those with w0 and w2 below 2^30;
             6 |q| < X is required, X = 2^28, or 2^26 for order 2, so an edge is below X + 2^18
  distances  |x_i| <= X, so distances are below 2 X + 2^18, and their sum and difference below 4 X + 2^20 < 2^31
  rates      3 middle <= 9/8 2^30; r1 <= 65535 and r0, r2 <= 2^15 are required. With steps up to D a rate is below
             V = D (r0 + r1 + r2)/2^rate_bits + 2, and V < 2^28 - 2^20 is required: as |v_i| <= 2^28 and lambda <= 4, distances of
             v + lambda x are below 2^28 + V + 2^29 + 2^20, and their sum and difference below 2^31
  curve      0 <= bend <= slope < 2^15 and slope/2 < level < 2^16 are required: products are below 2^31, the result has 16 bits
  law        smallest_width > 0 is required, so a width can be shifted up to [2^30, 2^31), and what is not above a width is then
             below 2^31; high_product makes no value larger. y is from smallest_y to 2^30 - 1, so y_shift is at least 1, and y_row
             is a row of the curves, as required. A shift is at most a shift_offset, and these are at most 31, as required
"""

import math
from fractions import Fraction
from typing import Any

from . import source
from .curves import check_curves, h_of
from .exact import Unusable, logarithm, require, rounded
from .inertia import filtered_tube, widths
from .law import Law
from .limits import emitted_limits
from .tube import Tube

TABLES = {"levels": 16, "slopes": 16, "bends": 16, "h_shifts": 8, "gains": 16, "shift_offsets": 8, "limits": 32}  # name: bits
CONSTANTS = "clock_bits clock_scale smallest_width largest_e smallest_y u_bits"
CONSTANTS_OF_ORDER_2 = "smallest_x_width rate_mantissa rate_shift rate_bits filter_bits"
WEIGHT_ERROR = Fraction(17178254800, 1 << 48)  # of an edge by its weights, in steps: the largest for all s (meaning.py)
RATE_POWER_ERROR = Fraction(27, 1 << 30)  # 3 times 9/4 of 2^-28: the same of the powers of s in the weights of a rate
LAW_ERROR = Fraction(1, 1 << 10)  # of the law, relative and in epsilon, that P9 allows
SCALAR_BITS = 20
UNITY = 1 << 30  # the number 1 in the units of e and y


class Integers:
    """The tables and constants of a controller in integers, and what must hold for them."""

    def __init__(self, text: bytes, task: Any, stated: Any) -> None:
        """text: the C. stated: the certificate's `integers`."""
        unsupported = task.inline or task.scales or task.outside != "return" or task.repeats or task.differs
        if unsupported or task.tick is None or task.u_max is None or len({*task.e_max}) > 1:
            raise Unusable("the task has an option that no controller in integers has, or lacks one that it needs")
        if ((task.period or 0) / task.tick).denominator != 1:
            raise Unusable("the task's period is no whole number of ticks")
        self.task, self.stated, self.largest_x = task, stated, 1 << (28 if task.order == 1 else 26)
        names = {*CONSTANTS.split(), *(CONSTANTS_OF_ORDER_2.split() if task.order == 2 else ())}
        has_integers = type(stated) is dict and {*stated} == names and all(type(v) is int for v in stated.values())
        require(has_integers, "the certificate's `integers` is unknown")
        is_inside = 16 <= stated["clock_bits"] < 31 and abs(stated["u_bits"]) < 64
        if task.order == 2:
            is_inside &= 0 < stated["rate_shift"] < 31 and 0 <= stated["rate_bits"] < 31 and stated["filter_bits"] in (14, 15, 16)
        require(is_inside, "a number of bits or a shift of the certificate's `integers` is out of range")
        self.tables = {name: source.integer_table(text, f"{task.name}_{name}", bits) for name, bits in TABLES.items()}
        self.tables["coefficients"] = source.integer_table(text, f"{task.name}_coefficients", 32)
        by_component = ["gains", "shift_offsets", "limits"]
        if task.order == 2:
            self.tables["filters"] = source.integer_table(text, f"{task.name}_filters", 16)
            by_component.append("filters")
        lengths = {len(self.tables[name]) for name in by_component}
        require(lengths == {task.n}, "a table of the C has another length than the task")

    # ---- P7

    def check_clock(self, tube: Tube) -> None:
        """Require that the C counts the task's ticks, and compute `clock_error`: how wrong the place of a tick is at most, in
        segments. A unit is 2^-clock_bits. The length of a tick is clock_scale/2^16 units, with an error of at most 2^-17 of a
        unit; its multiple is rounded down, and kept a unit before the end; s has 16 bits of it."""
        task, bits, scale = self.task, self.stated["clock_bits"], self.stated["clock_scale"]
        length, self.last = task.tick * tube.segments / task.t_c, math.ceil(task.t_c / task.tick)
        is_clock = scale > 0 and abs(scale - length * 2 ** (bits + 16)) <= Fraction(1, 2)
        fits = self.last < 1 << 31 and ((self.last >> 16) + 1) * scale < 1 << 31 and tube.segments << bits <= 1 << 31
        require(is_clock and fits, "the C counts other ticks than the task's")
        cut = Fraction(1, 1 << 16) if bits > 16 else 0
        self.clock_error = (Fraction(self.last, 1 << 17) + 2) / (1 << bits) + cut

    def arithmetic_error(self, tube: Tube, _bits: int, order: int = 0) -> list[Fraction]:
        """Return P7 by dimension, for edges (order 0) or their rates (order 1).

        Let d0, d1, d2 be the steps between four entries. Their edge is 6 q1 + d1 + d1 (3 s + 3 s^2 - 2 s^3) + d2 s^3 -
        d0 (1 - s)^3, and its rate is 3 d0 (1 - s)^2 + d1 (3 + 6 s (1 - s)) + 3 d2 s^2 times the segments in a second. Steps times
        weights are exact, and so are sums, but two of them are rounded down by less than a unit. s is wrong by `clock_error`.
        For a rate s^2 is cut by up to 9/16 of 2^-28, which makes (1 - s)^2, 1 + 2 s (1 - s) and s^2 wrong by 9/4 of 2^-28 in
        all; their sum is 2. The product of each with the segments in a second is rounded down, and then to the nearest. A rate
        has two units more: v is rounded to a unit, and a distance times lambda is rounded down."""
        per_second, weight_error, errors = Fraction(1), WEIGHT_ERROR, []
        if order:
            per_second, shift, bits = tube.segments / tube.t_c, self.stated["rate_shift"], self.stated["rate_bits"]
            emitted = Fraction(self.stated["rate_mantissa"]) * Fraction(2) ** (12 - shift - bits)
            rounding = 3 * (Fraction(1, 2) + Fraction(1, 1 << shift)) / (1 << bits)
            weight_error = 6 * abs(emitted - per_second) + RATE_POWER_ERROR * emitted + rounding
        for i in range(tube.n):
            step = max(abs(b[i][side] - a[i][side]) for a, b in zip(tube.table, tube.table[1:], strict=False) for side in (0, 1))
            clock_part = tube.fastest(i, order + 1) * self.clock_error * per_second
            errors.append((step * weight_error + clock_part + (2, 4)[order]) * tube.unit)
        return errors

    # ---- no value leaves 32 bits

    def _check_ranges(self, tube: Tube) -> None:
        """Require what the first docstring says is required, and that a unit is small enough for a measured x to have 20 bits."""
        stated, tables = self.stated, self.tables
        pairs = [(p, q) for a, b in zip(tube.table, tube.table[1:], strict=False) for p, q in zip(a, b, strict=True)]
        largest_step = max(abs(q[side] - p[side]) for p, q in pairs for side in (0, 1))
        require(largest_step < 1 << 15, "a step of the C's table has more than 15 bits")
        farthest = 6 * max(abs(v) for row in tube.table for pair in row for v in pair)
        require(farthest < self.largest_x, "the tube is beyond the largest x of the C")
        require(tube.unit <= self.task.farthest / (1 << SCALAR_BITS - 1), "the units of x are too large")
        is_inside = (
            all(0 < stated[name] < UNITY for name in ("smallest_y", "smallest_width")) and 0 <= stated["largest_e"] < UNITY
        )
        require(is_inside, "largest_e, smallest_y or smallest_width is out of range")
        rows = 8 * (31 - stated["smallest_y"].bit_length()) + 16
        require(rows <= len(tables["h_shifts"]), "the C has no row for the smallest y")
        is_inside = max(tables["shift_offsets"]) <= 31 and min(tables["limits"]) >= 0
        require(is_inside, "a shift or a limit of the C is out of range")
        if self.task.order == 2:
            m, shift, bits = stated["rate_mantissa"], stated["rate_shift"], stated["rate_bits"]
            require(0 < m < 1 << 16 and 0 < stated["smallest_x_width"] < UNITY, "a constant of the C is out of range")
            r1, r0 = (((v * m >> 16) + (1 << shift - 1) >> shift) for v in (9 << 27, 3 << 28))  # the largest; r2 is at most r0
            fastest = Fraction(largest_step * (r1 + 2 * r0), 1 << bits) + 2
            is_inside = r1 < 1 << 16 and r0 <= 1 << 15 and fastest < (1 << 28) - (1 << 20)
            require(is_inside, "the rates of the C are out of range")

    # ---- the law

    def _check_law(self, tube: Tube, gain: list[Fraction], spans: list[tuple[Fraction, Fraction]], x_bits: int) -> None:
        """Require that u is (13) with an error of at most r = 2^-10, relative and in epsilon, as P9 takes it. spans: by component
        the smallest and the largest width of the emitted tube that the law is about, in units.

        With e the normalized error and d the width, (13) is k/d |e| H(1 - |e|). Let a, b and c be the relative errors of 1/d, of
        H and of the gain. |e| and y = 1 - |e| have the relative error a too, and are rounded down to 2^-30. -y H'/H is between 0
        and 3/2: 1 - e times the slope of -ln(1 - e^2) is 2 e/(1 + e) <= 1, and of ln(atanh(e)/e) at most e/(1 + e) <= 1/2. So H
        changes by the ratio of y to a power of at most 3/2; 2 is taken. Beyond e_max |e| is at most largest_e and y at least
        smallest_y. `input_size` rounds three products down, which loses less than 3 units of the last one, and e loses one unit:
        |e| is taken to be so much smaller. The last shift rounds u down by less than a unit; xi is at least 4/d."""
        r, stated, e_max, h_shifts = LAW_ERROR, self.stated, self.task.e_max[0], self.tables["h_shifts"]
        a, h_rows, base = check_curves(self.tables)
        b, (largest_e, smallest_y) = (
            max(v for v, _ in h_rows),
            (Fraction(stated[name], UNITY) for name in ("largest_e", "smallest_y")),
        )
        y_error = a + 1 / ((1 - e_max) * UNITY)  # relative, of the smallest y
        require(max(a, b, y_error) <= r, "the curves of the C are not 1/d and H, or e_max is too near 1 for integers")
        smallest_reciprocal, smallest_h = (1 - a) / 2, min(v for _, v in h_rows) * (1 - b) / (1 << 16)  # over 2^16
        for i, k in enumerate(gain):
            mantissa, offset, limit = (self.tables[name][i] for name in ("gains", "shift_offsets", "limits"))
            exact, name = abs(k) * Fraction(2) ** (x_bits + stated["u_bits"] + offset - 28 - base), self.task.names[i]
            require(abs(mantissa - exact) <= Fraction(1, 2), f"the gain of {name} in the C is not the certificate's")
            require(stated["smallest_width"] <= spans[i][0], "the law of the C takes the tube to be wider than it is")
            c = Fraction(1, 2) / exact
            inside = (1 + a) ** 2 * (1 + b) * (1 + c) / (1 - y_error) ** 2
            beyond = largest_e / e_max * h_of(smallest_y)[1] / h_of(1 - e_max)[0] * (1 + a) * (1 + b) * (1 + c)
            smallest = min(1 - a, largest_e / e_max) * (1 - a) * (1 - b) * (1 - c) / max(1 + a, smallest_y / (1 - e_max)) ** 2
            relative = max(inside - 1, beyond - 1, 1 - smallest)
            lost = (1 + 3 / (smallest_reciprocal * smallest_h * Fraction(mantissa, 1 << 16))) * (1 + relative) / UNITY  # of |e|
            lost *= logarithm((1 + e_max) / (1 - e_max))[1] / e_max  # the largest epsilon/e
            lost += Fraction(2) ** -stated["u_bits"] * spans[i][1] * tube.unit / (4 * abs(k))
            require(relative <= r and lost <= r * (1 - relative), f"u of {name} in the C is wrong by more than 2^-10")
            for row, (_, smallest_in_row) in enumerate(h_rows, 16):
                if h_shifts[row] > offset - (31 - stated["smallest_width"].bit_length()):  # u would be shifted up: not done
                    octave, piece = divmod(row - 16, 8)
                    e = min(1 - a - Fraction(9 + piece, 16 << octave) - Fraction(2, UNITY), largest_e)  # the smallest in this row
                    size = e * UNITY * smallest_in_row * (1 - b) * smallest_reciprocal * mantissa / (1 << 32) - 3
                    require(limit <= size, f"u of {name} in the C may be wrong before it is at its limit")

    def prove(self, tube: Tube, law: Law, x_bits: int, has_phase: bool, starts: Any) -> tuple[set[str], dict[str, Any]]:
        """Prove all but P7: the ranges, the law, and that no state in the tube is beyond the largest x and v of the C. Return the
        options and the numbers of the listing."""
        task, stated, filters = self.task, self.stated, law.filters
        self._check_ranges(tube)
        limits = [v * Fraction(2) ** stated["u_bits"] for v in emitted_limits(task, SCALAR_BITS)]
        require(self.tables["limits"] == limits, "the limits of the C are not u_max")
        spans = []
        for i, error in enumerate(law.edge_error):
            width = [h - v for piece in tube.pieces for v, h in zip(*piece[i], strict=True)]
            spans.append((min(width) - 2 * error / tube.unit, max(width) + 2 * error / tube.unit))
        options = {f"order {task.order}", "positive" if law.gain[0] > 0 else "negative"}
        options |= {"long" if self.last >= 1 << 16 else "short", "fine" if stated["clock_bits"] > 16 else "coarse"}
        options |= {name for name, v in (("period", task.period), ("selftest", task.selftest), ("phase", has_phase)) if v}
        if task.order == 2:
            options.add("scaled filter" if stated["filter_bits"] < 16 else "plain filter")
            is_same = self.tables["filters"] == [s * (1 << stated["filter_bits"]) for s in filters]
            is_same &= stated["smallest_x_width"] <= min(v for v, _ in spans)
            require(is_same, "a filter or the smallest width in the C is not the tube's")
            edges, per_second = filtered_tube(task, tube, filters)[0], tube.segments / task.t_c
            for i, s in enumerate(filters):
                fastest = tube.fastest(i) * per_second + s * spans[i][1]  # of v in the filtered tube
                require(fastest < 1 << 28, "the tube's rates are beyond the largest v of the C")
                z, error = [v / tube.unit for v in widths(edges, i)], 2 * (law.rate_error[i] + s * law.edge_error[i]) / tube.unit
                spans[i] = (min(z) - error, max(z) + error)
        self._check_law(tube, law.gain, spans, x_bits)
        return options, self._values(tube, x_bits, starts)

    def _values(self, tube: Tube, x_bits: int, starts: dict[str, list[Fraction]]) -> dict[str, Any]:
        """Return the numbers of the listing by name."""
        task, stated, n = self.task, self.stated, self.task.n
        numerator, denominator = (1 / task.tick).as_integer_ratio()
        bits = {"x": x_bits, "u": stated["u_bits"]}
        tables = self.tables | {name: [int(v) for v in table] for name, table in starts.items()}
        is_inside = all(abs(v) < 1 << 31 for name in starts for v in tables[name])
        require(is_inside, "a bound of the covered starts has more than 32 bits; the noise is too large")
        of_varying_type = ("coefficients", "filters", *starts)
        sizes = {name: source.entry_bits(table) for name, table in tables.items() if name in of_varying_type}
        return {
            "smallest_x_width": stated["smallest_width"], **stated, **tables, "n": n, "pairs": 2 * n, "ticks": self.last,
            **{f"{name}_type": f"uint{v}_t" if v < 32 else "int32_t" for name, v in sizes.items()},
            **{f"{name}_bits": v for name, v in sizes.items()}, **{f"row_{j}": 2 * n * j for j in (1, 2, 3)},
            **{f"{name}_scale": f"{2**v}.0" if v >= 0 else f"(1.0 / {2**-v}.0)" for name, v in bits.items()},
            **{f"{name}_bits": f"({v})" if v < 0 else v for name, v in bits.items()},
            "entries": len(tables["coefficients"]), "rows": len(tables["h_shifts"]), "largest_x": self.largest_x,
            "tick_end": (tube.segments << stated["clock_bits"]) - 1, "fine_shift": stated["clock_bits"] - 16,
            "rate_half": 1 << stated.get("rate_shift", 1) - 1, "filter_scale": 1 << 16 - stated.get("filter_bits", 16),
            "share": rounded(task.start_share, 53, math.floor), "ticks_proved": int((task.period or 0) / task.tick),
            "ticks_a_second": f"INT32_C({numerator})" if denominator == 1 else f"({numerator}.0 / {denominator}.0)",
        }  # fmt: skip
