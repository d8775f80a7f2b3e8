"""What the functions of a listing in integers must do, on symbols.

Sums are exact. A product or a shift that loses bits is a symbol that belongs to this operation and these operands in their order, and so
is a comparison, or a choice after one: nothing is explored. `ExactIntegerSpecification` says what the same functions compute where no bit
is lost: formulas of docs/paper.md in the units of the listing. integer_ranges.py shows that nothing leaves its type.
"""

from __future__ import annotations

import itertools
from fractions import Fraction
from typing import Any, NamedTuple

from tests.support.listings.field import PRIME, Symbols, element
from tests.support.listings.machine import Path, Value

HOLES = (  # numbers, of type int
    "n pairs entries rows row_1 row_2 row_3 clock_scale clock_bits tick_end fine_shift rate_mantissa rate_half rate_shift rate_bits "
    "largest_x filter_scale smallest_width smallest_x_width largest_e smallest_y"
).split()
LARGEST_V, UNITY, HALF_OF_16_BITS, LARGEST_16_BITS = 1 << 28, 1 << 30, 1 << 15, (1 << 16) - 1


class IntegerSymbols(Symbols):
    """rounds: whether products and shifts lose bits; else they are quotients."""

    def arithmetic(self, name: str, *operands: int) -> int:
        """Return the result of an operation of ARITHMETIC."""
        if self.rounds or name in ("leading", "low_bits"):
            return self.symbol(name, *operands)
        a, b = operands
        factor = {
            "product": lambda: b,
            "high_product": lambda: b * element(Fraction(1, 1 << 16)),
            "shift_up": lambda: self.power(b),
            "shift_down": lambda: pow(self.power(b), -1, PRIME),
        }[name]()
        return a * factor % PRIME

    def power(self, exponent: int) -> int:
        """Return 2^exponent, a symbol where the exponent is one."""
        return pow(2, exponent, PRIME) if exponent < 64 else self.symbol("power of two", exponent)

    def choice(self, condition: int, first: Any, second: Any) -> Any:
        return self.symbol("choice", condition, first, second)

    def define(self, name: str, arguments: tuple[int, ...], value: int) -> int:
        """Give an unknown function its value for these arguments, before anybody asks for it."""
        self._by_name[name, *arguments] = value % PRIME
        return value % PRIME


class IntegerPath(Path):
    """The one path: a comparison has a symbol, and a choice has both alternatives."""

    def is_less(self, a: int, b: int, sign: str = "<") -> Any:
        return self.symbols.symbol(f"comparison {sign}", a % PRIME, b % PRIME)

    def carry(self, value_type: str) -> Any:
        self.carried_values += 1
        return self.symbols.symbol("carried", self.carried_values)


class Sides(NamedTuple):
    """The distances of a value to its lower and to its upper edge."""

    to_lower: int
    to_upper: int


class IntegerSpecification:
    """options: the words that the listing is filled for. A method has the name of its function."""

    def __init__(self, symbols: IntegerSymbols, options: set[str]) -> None:
        self.symbols, self.options, self.symbol = symbols, options, symbols.symbol
        self.i, self.has_order_2 = symbols.symbol("i"), "order 2" in options

    def number(self, name: str) -> int:
        return self.symbol(f"number {name}")

    def entry(self, array: str) -> int:
        return self.symbol(f"load {array}", self.i)

    # ---- operations

    def down(self, a: int, bits: int) -> int:
        return self.symbols.arithmetic("shift_down", a % PRIME, bits)

    def up(self, a: int, bits: int) -> int:
        return self.symbols.arithmetic("shift_up", a % PRIME, bits)

    def high(self, a: int, b: int) -> int:
        """Return a b / 2^16."""
        return self.symbols.arithmetic("high_product", a % PRIME, b % PRIME)

    def product(self, a: int, b: int) -> int:
        return self.symbols.arithmetic("product", a % PRIME, b % PRIME)

    def low_bits(self, a: int, mask: int) -> int:
        return self.symbols.arithmetic("low_bits", a % PRIME, mask)

    def leading(self, a: int) -> int:
        return self.symbols.arithmetic("leading", a % PRIME)

    def less(self, a: int, b: int) -> int:
        return self.symbol("comparison <", a % PRIME, b % PRIME)

    def both(self, a: int, b: int) -> int:
        return self.symbol("and", a, b)

    def choice(self, condition: int, first: Any, second: Any) -> Any:
        return self.symbols.choice(condition, *(v if isinstance(v, str) else v % PRIME for v in (first, second)))

    def at_least(self, a: int, low: int) -> int:
        return self.choice(self.less(low, a), a, low)

    def at_most(self, a: int, high: int) -> int:
        return self.choice(self.less(a, high), a, high)

    @staticmethod
    def results(path: Path, *values: int) -> None:
        path.effects.append([Value("int", value % PRIME) for value in values])

    # ---- kernels

    def segment(self, path: Path) -> None:
        """Row of the table and s at tick clock_scale/2^16, a segment being 2^clock_bits: up to the last tick and before the end."""
        scale = self.number("clock_scale")
        tick, end = (self.symbol("tick"), self.number("ticks"))
        count = self.at_most(tick, end)
        passed = self.high(scale, self.low_bits(count, LARGEST_16_BITS))
        if "long" in self.options:
            passed += self.down(count, 16) * scale
        position = self.at_most(passed, self.number("tick_end"))
        fine = self.down(position, self.number("fine_shift")) if "fine" in self.options else position
        row = self.down(position, self.number("clock_bits")) * self.number("pairs")
        self.results(path, row, self.low_bits(fine, LARGEST_16_BITS))

    def powers(self) -> tuple[int, int]:
        """Return s and s^2 in units of 2^-28."""
        s = self.up(self.symbol("s"), 12)
        return s, self.high(s, self.symbol("s"))

    def weights(self, path: Path) -> None:
        """(1 - s)^3 = 1 - 3 (s - s^2) - s^3 and s^3 in 2^-15, 3 (s + s^2) - 2 s^3 in 2^-14, none of them negative, to the nearest."""
        s, square = self.powers()
        cube = self.high(square, self.symbol("s"))
        first = self.at_least((1 << 28) - 3 * self.at_least(s - square, 0) - cube, 0)
        middle = self.at_least(3 * (s + square) - 2 * cube, 0)
        nearest = [self.down(v + (1 << bits - 1), bits) for v, bits in ((first, 13), (middle, 14), (cube, 13))]
        self.results(path, nearest[0], self.at_most(nearest[1], LARGEST_16_BITS), nearest[2])

    def rates(self, path: Path) -> None:
        """3 (1 - s)^2 with (1 - s)^2 = 1 - s - (s - s^2), 3 + 6 (s - s^2) and 3 s^2, times the rate's mantissa, to the nearest; s - s^2
        is at most 1/4."""
        s, square = self.powers()
        bend = self.at_most(self.at_least(s - square, 0), 1 << 26)
        first, middle = self.at_least((1 << 28) - s - bend, 0), (1 << 28) + 2 * bend
        mantissa, half, shift = (self.number(f"rate_{name}") for name in ("mantissa", "half", "shift"))
        self.results(path, *(self.down(self.high(3 * v, mantissa) + half, shift) for v in (first, middle, square)))

    def edge_at(self, path: Path) -> None:
        """6 q1 + d1 + w1 d1 + w2 d2 - w0 d0, and its rate r0 d0 + r1 d1 + r2 d2, d being the steps between four entries q."""
        at, rows = self.symbol("at"), [0, *(self.number(f"row_{j}") for j in (1, 2, 3))]
        q = [self.symbol("load coefficients", (at + row) % PRIME) for row in rows]
        d = [b - a for a, b in itertools.pairwise(q)]
        w, r = ([self.symbol(f"{name}{j}") for j in range(3)] for name in "wr")
        middle = self.down(self.product(d[1], w[1]), 14)
        outer = self.down(self.product(d[2], w[2]) - self.product(d[0], w[0]), 15)
        edge, bits = 6 * q[1] + d[1] + middle + outer, self.number("rate_bits")
        rate = self.down(self.product(d[1], r[1]), bits) + self.down(self.product(d[0], r[0]) + self.product(d[2], r[2]), bits)
        self.results(path, *([edge, rate] if self.has_order_2 else [edge]))

    def curve(self, path: Path) -> None:
        self.results(path, self.curve_at(self.symbol("row"), self.symbol("t")))

    def curve_at(self, row: int, t: int) -> int:
        """Return level - (slope - bend t) t/2 of a row, t in units of 2^-16."""
        level, slope, bend = (self.symbol(f"load {name}", row % PRIME) for name in ("levels", "slopes", "bends"))
        mean_slope = slope - self.down(self.product(bend, t), 16)
        return self.low_bits(level - self.down(self.product(mean_slope, t), 17), LARGEST_16_BITS)

    # ---- edges and distances

    def sum_with_filter(self, rate: int, value: int) -> int:
        """Return rate + lambda value."""
        scale = self.number("filter_scale") if "scaled filter" in self.options else 1
        return rate + self.high(value * scale, self.entry("filters"))

    def limited(self, array: str) -> int:
        """Return x or v, between the largest ones that integers are for."""
        largest = self.number("largest_x") if array == "x" else LARGEST_V
        return self.at_most(self.at_least(self.entry(array), -largest), largest)

    def sides(self) -> list[Sides]:
        """Return the distances of x, and for order 2 those of v + lambda x."""
        x, low, high = self.limited("x"), self.symbol("L"), self.symbol("U")
        of_x = Sides(x - low, high - x)
        if not self.has_order_2:
            return [of_x]
        v = self.limited("v")
        rates = v - self.symbol("L'"), self.symbol("U'") - v
        return [of_x, Sides(*(self.sum_with_filter(rate, value) for rate, value in zip(rates, of_x, strict=True)))]

    def tube(self, path: Path) -> None:
        path.effects += [("store", "lower", self.symbol("L")), ("store", "upper", self.symbol("U")), ("return", None)]

    def filtered_tube(self, path: Path) -> None:
        edges = [self.sum_with_filter(self.symbol(f"{side}'"), self.symbol(side)) % PRIME for side in "LU"]
        path.effects += [("store", "lower", edges[0]), ("store", "upper", edges[1]), ("return", None)]

    # ---- the law

    def reciprocal(self, width: int) -> tuple[int, int]:
        """Return the leading bits n of a width, and 2^46/(2^n width): the curve in the row of the 4 bits after the first one."""
        n = self.leading(width)
        m = self.up(width, n)
        row, t = self.low_bits(self.down(m, 26), 15), self.low_bits(self.down(m, 10), LARGEST_16_BITS)
        return n, self.curve_of_width(m, row, t)

    def curve_of_width(self, _m: int, row: int, t: int) -> int:
        return self.curve_at(row, t)

    def curve_of_y(self, y: int) -> tuple[int, int]:
        """Return H(y) and its shift: 8 rows for each octave, by the 3 bits after the first one."""
        n = self.leading(y)
        m = self.up(y, n)
        row = 8 * n + 8 + self.low_bits(self.down(m, 27), 7)
        return self.h_at(row, self.low_bits(self.down(m, 11), LARGEST_16_BITS)), self.symbol("load h_shifts", row % PRIME)

    def h_at(self, row: int, t: int) -> int:
        return self.curve_at(row, t)

    def error_and_complement(self, offset: int, width: int, n: int, reciprocal: int) -> tuple[int, int]:
        """Return |e| = offset/width and 1 - |e| in units of 2^-30."""
        shifted = self.up(offset, n)
        return self.high(shifted, reciprocal), self.high(self.up(width, n) - shifted, reciprocal)

    def size(self, e: int, h: int, reciprocal: int, gain: int, shift: int) -> int:
        """Return |u| = gain e H/width."""
        return self.down(self.high(self.high(self.high(e, h), reciprocal), gain), shift)

    def law(self, sides: Sides) -> tuple[int, int]:
        """Return u, and whether the value is strictly between its edges: |e| < 1. A tube is at least the smallest width wide."""
        width, difference = sum(sides), sides.to_lower - sides.to_upper
        is_upper_nearer = self.less(0, difference)
        offset, safe_width = (
            self.choice(is_upper_nearer, difference, -difference),
            self.at_least(width, self.number("smallest_width")),
        )
        n, reciprocal = self.reciprocal(safe_width)
        e, y = self.error_and_complement(self.at_most(offset, safe_width), safe_width, n, reciprocal)
        h, h_shift = self.curve_of_y(self.at_most(self.at_least(y, self.number("smallest_y")), UNITY - 1))
        shift = self.at_least(self.entry("shift_offsets") - n - h_shift, 0)
        size = self.size(self.at_most(e, self.number("largest_e")), h, reciprocal, self.entry("gains"), shift)
        size = self.at_most(size, self.entry("limits"))
        pulls = (-size, size) if "positive" in self.options else (size, -size)
        return self.choice(is_upper_nearer, *pulls), self.less(offset, width)

    def control(self, path: Path) -> None:
        """u in each component; the status says whether x, and v + lambda x, are strictly inside."""
        was_outside, sides = path.carry("bool"), self.sides()
        u, is_inside = self.law(sides[-1])
        if self.has_order_2:
            is_inside = self.both(is_inside, self.both(*(self.less(0, distance) for distance in sides[0])))
        path.effects += [("store", "u", u), ("carried", False, self.choice(is_inside, was_outside, True))]
        path.effects.append(("return", self.choice(path.carry("bool"), "C_OUTSIDE_TUBE", "C_OK")))

    # ---- margins and starts

    def share(self, sides: Sides, smallest: str) -> int:
        """Return the distance to the nearer edge over the width in units of 2^-16, at least -1 and less than 1, rounded down."""
        width = self.at_least(sum(sides), self.number(smallest))
        distance = self.choice(self.less(sides.to_upper, sides.to_lower), sides.to_upper, sides.to_lower)
        is_inside = self.less(0, distance)
        size = self.at_most(self.choice(is_inside, distance, -distance), width)
        share = self.at_most(self.quotient(size, width), LARGEST_16_BITS)
        return self.choice(is_inside, share, -1 - share)

    def quotient(self, size: int, width: int) -> int:
        """Return size/width in units of 2^-16."""
        n, reciprocal = self.reciprocal(width)
        return self.down(self.high(self.up(size, n), reciprocal), 14)

    def margin_of_component(self) -> int:
        sides = self.sides()
        x = self.share(sides[0], "smallest_x_width")
        return self.at_most(self.share(sides[1], "smallest_width"), x) if self.has_order_2 else x

    def margin(self, path: Path) -> None:
        """The smallest margin of all components, at most 1/2."""
        before = path.carry("int")
        path.effects.append(("carried", HALF_OF_16_BITS, self.at_most(self.margin_of_component(), before)))
        path.effects.append(("return", path.carry("int")))

    def margins(self, path: Path) -> None:
        path.effects += [("store", "margin", self.margin_of_component()), ("return", None)]

    def covered(self, path: Path) -> None:
        """Whether x, and for order 2 v + lambda x, is strictly between the bounds of starts, in every component."""
        values = {"start": self.entry("x")}
        if self.has_order_2:
            values["start"] = self.limited("x")
            values["filtered_start"] = self.sum_with_filter(self.limited("v"), values["start"])
        are_inside = [
            self.both(self.less(self.entry(f"{name}_lower"), value), self.less(value, self.entry(f"{name}_upper")))
            for name, value in values.items()
        ]
        was_covered = path.carry("bool")
        path.effects.append(
            ("carried", True, self.choice(self.both(*are_inside) if self.has_order_2 else are_inside[0], was_covered, False))
        )
        path.effects.append(("return", path.carry("bool")))


class ExactIntegerSpecification(IntegerSpecification):
    """Where no bit is lost: 1/width is a quotient, and H is a function of y.

    The law is then -k xi epsilon of (13): with |e| = 1 - y it is k |e| H(y)/width, H(y) = 4 ln((2 - y)/y)/((1 - y) y (2 - y))."""

    def edge_at(self, path: Path) -> None:
        """The cubic B-spline of four entries and its rate, 6 times, if the weights are those of s. Else nothing is claimed."""
        at, s, per_second = self.symbol("at"), self.symbol("place"), self.symbol("segments a second")
        q = [self.symbol("load coefficients", (at + row) % PRIME) for row in (0, *(self.number(f"row_{j}") for j in (1, 2, 3)))]
        basis = (1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3
        slopes = -3 * (1 - s) ** 2, 9 * s**2 - 12 * s, -9 * s**2 + 6 * s + 3, 3 * s**2
        edge, slope = (sum(b * entry for b, entry in zip(p, q, strict=True)) for p in (basis, slopes))
        self.results(path, *([edge, slope * per_second] if self.has_order_2 else [edge]))

    def curve_of_width(self, m: int, row: int, t: int) -> int:
        return self.symbols.define("curve", (row, t), (1 << 46) * pow(m, -1, PRIME))

    def h_at(self, row: int, t: int) -> int:
        return self.symbol("curve", row % PRIME, t)

    def error_and_complement(self, offset: int, width: int, n: int, reciprocal: int) -> tuple[int, int]:
        e = UNITY * offset * pow(width, -1, PRIME) % PRIME
        return e, (UNITY - e) % PRIME

    def size(self, e: int, h: int, reciprocal: int, gain: int, shift: int) -> int:
        """e counts 2^-30, and 1/width 2^-46 of 2^n: so 2^-48 is left of the three products."""
        return e * h * reciprocal * gain * pow((1 << 48) * self.symbols.power(shift), -1, PRIME) % PRIME

    def quotient(self, size: int, width: int) -> int:
        self.reciprocal(width)
        return (1 << 16) * size * pow(width, -1, PRIME) % PRIME
