"""What the functions of a listing in floating point must do, as operations on the same symbols.

A specification has the effects of its function, in their order: values that are stored, pairs of what a loop carries (before the loop,
and after one more component), and the result. It rounds where the listing rounds, so that bounds on rounding hold for both.
L and U are the edges of component i at the time, L' and U' their rates by the place in the segment. Equations are those of docs/paper.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from tests.support.listings.field import PRIME, Symbols, element
from tests.support.listings.machine import Path, Value

REAL_NUMBERS = "per_second last t_c gain smallest_share e_max filter limit narrowest bend ln_2 tick_real".split()
NEGATED_NUMBERS = ("gain", "e_max", "limit")  # also with a minus, as gain_minus
INTEGERS = "n pairs entries row_1 row_2 row_3 ticks tick_num tick_den tick_end last_segment".split()
STARTS = ("start_lower", "start_upper", "filtered_start_lower", "filtered_start_upper")
PLUS_ONE, MINUS_ONE, HALF = 1, -1 % PRIME, element(Fraction(1, 2))


class Distances(NamedTuple):
    """Of a value between two edges."""

    width: int
    to_lower: int
    to_upper: int


class Clamped(NamedTuple):
    """Distances to the nearer and to the farther edge, the nearer one at least the smallest share of the width."""

    to_nearer: int
    to_farther: int
    is_upper_nearer: bool


class Specification:
    """options: the words that the listing is filled for. A method has the name of its function."""

    def __init__(self, symbols: Symbols, options: set[str]) -> None:
        self.symbols, self.options = symbols, options
        self.symbol, self.op, self.integer_op = symbols.symbol, symbols.real_operation, symbols.integer_operation
        self.i, self.has_order_2 = symbols.symbol("i"), "order 2" in options
        self.nan, self.t = symbols.symbol("nan"), symbols.symbol("t")

    def number(self, name: str) -> int:
        return self.symbol(f"number {name}")

    def component(self, name: str, option: str, table: str = "") -> int:
        """Return a number of component i: an entry of a table where the numbers differ, which the option says."""
        return self.symbol(f"load {table or name}", self.i) if option in self.options else self.number(name)

    def entry(self, array: str) -> int:
        return self.symbol(f"load {array}", self.i)

    @property
    def smallest_share(self) -> int:
        return self.component("smallest_share", "clamps", "least_share")

    @property
    def filter(self) -> int:
        return self.component("filter", "filters")

    # ---- time

    def segment(self, path: Path) -> None:
        """Row of the table, and place in the segment, of spline time K t / t_c between 0 and the last number below K."""
        scaled = self.op("*", self.t if path.is_less(0, self.t) else 0, self.number("per_second"))
        u = scaled if path.is_less(scaled, self.number("last")) else self.number("last")
        segment = self.symbol("truncated", u)
        s = self.op("-", u, self.symbols.real_from_integer(segment))
        path.effects.append([Value("int", self.integer_op("*", segment, self.number("pairs"))), Value("real", s)])

    def segment_at_tick(self, path: Path) -> None:
        """The same for a count of ticks, tick_num/tick_den of a segment each."""
        tick, end, divisor, last = (self.number(name) for name in ("ticks", "tick_end", "tick_den", "last_segment"))
        count = self.symbol("tick") if path.is_less(self.symbol("tick"), tick) else tick
        passed = self.integer_op("*", count, self.number("tick_num"))
        dividend = passed if path.is_less(passed, end) else end
        quotient = self.integer_op("/", dividend, divisor)
        segment = quotient if path.is_less(quotient, last) else last
        rest = self.integer_op("-", dividend, self.integer_op("*", segment, divisor))
        s = self.op("/", self.symbols.real_from_integer(rest), self.number("tick_real"))
        path.effects.append([Value("int", self.integer_op("*", segment, self.number("pairs"))), Value("real", s)])

    # ---- distances

    def distances(self, lower: int, upper: int, x: int) -> Distances:
        return Distances(self.op("-", upper, lower), self.op("-", x, lower), self.op("-", upper, x))

    def distances_of_state(self) -> tuple[Distances, Distances]:
        """Return the distances of x, and of what the law holds: x itself, or for order 2 v + lambda x in the filtered tube."""
        x = self.distances(self.symbol("L"), self.symbol("U"), self.entry("x"))
        if not self.has_order_2:
            return x, x
        lower_rate, upper_rate = (self.op("*", self.symbol(name), self.number("per_second")) for name in ("L'", "U'"))
        v = self.distances(lower_rate, upper_rate, self.entry("v"))
        return x, Distances(*(self.op("+", a, self.op("*", b, self.filter)) for a, b in zip(v, x, strict=True)))

    def nearest(self, path: Path, distances: Distances) -> tuple[int, bool]:
        """Return the distance to the nearer edge, and whether that is the upper one."""
        is_upper_nearer = path.is_less(distances.to_upper, distances.to_lower)
        return distances.to_upper if is_upper_nearer else distances.to_lower, is_upper_nearer

    def clamped(self, path: Path, distances: Distances) -> Clamped:
        nearest, is_upper_nearer = self.nearest(path, distances)
        smallest = self.op("*", distances.width, self.smallest_share)
        to_nearer = nearest if path.is_less(smallest, nearest) else smallest
        return Clamped(to_nearer, self.op("-", distances.width, to_nearer), is_upper_nearer)

    def limited(self, path: Path, value: int, limit: int) -> int:
        """Return the value, at least -limit and at most limit."""
        raised = value if path.is_less(-limit % PRIME, value) else -limit % PRIME
        return limit if path.is_less(limit, raised) else raised

    # ---- the law (13)

    def transformed(self, to_nearer: int, to_farther: int) -> tuple[int, int]:
        """Return epsilon, as if the lower edge were the nearer one, and xi: -ln(far/near) and (1 + far/near)/far = 1/near + 1/far."""
        ratio = self.op("/", to_farther, to_nearer)
        return -self.logarithm(ratio) % PRIME, self.op("/", self.op("+", PLUS_ONE, ratio), to_farther)

    def logarithm(self, y: int) -> int:
        """Return the library's logarithm; or with y = m 2^e the sum e ln 2 + s (2 + bend s^2), s = (m - 1)/(m + 1)."""
        if "libm" in self.options:
            return self.symbol("log", y)
        mantissa, exponent = self.symbol("mantissa", y), self.symbols.real_from_integer(self.symbol("exponent", y))
        s = self.op("/", self.op("-", mantissa, PLUS_ONE), self.op("+", mantissa, PLUS_ONE))
        bent = self.op("+", self.op("*", self.op("*", s, s), self.number("bend")), 2)
        return self.op("+", self.op("*", exponent, self.number("ln_2")), self.op("*", s, bent))

    def control(self, path: Path) -> None:
        self._control(path, self.op("*", self.t, 0))

    def control_tick(self, path: Path) -> None:
        self._control(path, 0)

    def _control(self, path: Path, zero_of_time: int) -> None:
        """u = -k xi epsilon in each component, within u_max; the status says whether x, and v + lambda x, are strictly inside."""
        if not self.finite_inputs(path, zero_of_time):
            path.effects += [("store", "u", 0), ("return", "C_BAD_INPUT")]
            return
        was_outside = path.carry("bool")
        x, z = self.distances_of_state()
        clamped, (nearest, _) = self.clamped(path, z), self.nearest(path, z)
        positive = [path.is_less(0, v) for v in ((nearest, x.to_lower, x.to_upper) if self.has_order_2 else (nearest,))]
        epsilon, xi = self.transformed(clamped.to_nearer, clamped.to_farther)
        gain = self.component("gain", "gains")
        signed_gain = -gain % PRIME if clamped.is_upper_nearer else gain
        u = -self.op("*", self.op("*", signed_gain, xi), epsilon) % PRIME
        if "limits" in self.options:
            u = self.limited(path, u, self.entry("u_max"))
        path.effects += [("store", "u", u), ("carried", False, was_outside if all(positive) else True)]
        is_outside = path.carry("bool")
        if "scaled" in self.options:
            self.scale(path)
        path.effects.append(("return", "C_OUTSIDE_TUBE" if is_outside else "C_OK"))

    def scale(self, path: Path) -> None:
        """u, as it is stored, times the one factor that brings the largest |u| within the limit; each then within the limit."""
        before, u, limit = path.carry("real"), self.entry("u"), self.number("limit")
        size = -u % PRIME if path.is_less(u, 0) else u
        path.effects.append(("carried", 0, size if path.is_less(before, size) else before))
        largest = path.carry("real")
        factor = self.op("/", limit, largest if path.is_less(limit, largest) else limit)
        path.effects.append(("store", "u", self.limited(path, self.op("*", u, factor), limit)))

    def finite_inputs(self, path: Path, zero_of_time: int) -> bool:
        """Return whether the sum of 0 times each input is <= 0, which no sum is that is NaN."""
        total = zero_of_time
        for name in ("x", "v") if self.has_order_2 else ("x",):
            path.effects.append(("carried", total, self.op("+", path.carry("real"), self.op("*", self.entry(name), 0))))
            total = path.carry("real")
        return path.is_less(total, 0, "<=")

    # ---- margins and starts

    def margin(self, path: Path) -> None:
        """The smallest margin of all components, at most 1/2; NaN for inputs that are not finite."""
        if not self.finite_inputs(path, self.op("*", self.t, 0)):
            path.effects.append(("return", self.nan))
            return
        before, share = path.carry("real"), self.margin_of_component(path)
        path.effects.append(("carried", HALF, share if path.is_less(share, before) else before))
        path.effects.append(("return", path.carry("real")))

    def margins(self, path: Path) -> None:
        path.effects += [
            ("store", "margin", self.margin_of_component(path) if path.is_finite(self.t) else self.nan),
            ("return", None),
        ]

    def margin_of_component(self, path: Path) -> int:
        """Return the distance to the nearer edge over the width, at least -1: of x, and for order 2 of v + lambda x unless that of x
        is less. So it is NaN where x or v is."""
        x, z = (self._share(path, distances) for distances in self.distances_of_state())
        return z if self.has_order_2 and not path.is_less(x, z) else x

    def _share(self, path: Path, distances: Distances) -> int:
        share = self.op("/", self.nearest(path, distances)[0], distances.width)
        return MINUS_ONE if path.is_less(share, MINUS_ONE) else share

    def covered(self, path: Path) -> None:
        """Whether x, and for order 2 v + lambda x, is strictly between the bounds of starts, in every component."""
        values = [self.entry("x")]
        if self.has_order_2:
            values.append(self.op("+", self.entry("v"), self.op("*", values[0], self.filter)))
        bounds = [self.entry(name) for name in STARTS]
        are_inside = [
            path.is_less(bounds[2 * k + side], value) if side == 0 else path.is_less(value, bounds[2 * k + side])
            for k, value in enumerate(values)
            for side in (0, 1)
        ]
        was_covered = path.carry("bool")
        path.effects.append(("carried", True, was_covered if all(are_inside) else False))
        path.effects.append(("return", path.carry("bool")))

    # ---- functions of time alone

    def tube(self, path: Path) -> None:
        self._store_at_time(path, ["lower", "upper"], [self.symbol("L"), self.symbol("U")])

    def tube_rate(self, path: Path) -> None:
        """The rates a second; 0 from t_c on."""
        per_second = self.number("per_second") if path.is_less(self.t, self.number("t_c")) else 0
        rates = [self.op("*", self.symbol(name), per_second) for name in ("L'", "U'")]
        self._store_at_time(path, ["lower_rate", "upper_rate"], rates)

    def filtered_tube(self, path: Path) -> None:
        """The edges of v + lambda x: L' + lambda L and U' + lambda U, the rates a second."""
        edges = [
            self.op(
                "+",
                self.op("*", self.symbol(f"{side}'"), self.number("per_second")),
                self.op("*", self.symbol(side), self.filter),
            )
            for side in "LU"
        ]
        self._store_at_time(path, ["lower", "upper"], edges)

    def _store_at_time(self, path: Path, arrays: Sequence[str], values: Sequence[int]) -> None:
        """Store the values, or NaN for a time that is not finite."""
        is_finite = path.is_finite(self.t)
        path.effects += [("store", array, v if is_finite else self.nan) for array, v in zip(arrays, values, strict=True)]
        path.effects.append(("return", None))

    def velocity(self, path: Path) -> None:
        """(x - x_before)/dt, and NaN unless dt is positive."""
        dt = self.symbol("dt")
        is_positive = path.is_less(0, dt)
        mean = self.op("/", self.op("-", self.entry("x"), self.entry("x_before")), dt if is_positive else PLUS_ONE)
        path.effects += [("store", "v", mean if is_positive else self.nan), ("return", None)]

    def transform(self, path: Path) -> None:
        """e, epsilon and xi of (12) and (13) between edges that are parameters: 0 in a tube without width, NaN where x or the width is
        not finite. A tube narrower than `narrowest` counts as that wide, about its middle."""
        x, narrowest = self.entry("x"), self.number("narrowest")
        width, to_lower, to_upper = self.distances(self.entry("lower"), self.entry("upper"), x)
        is_filled = path.is_less(0, width)
        safe_width = width if path.is_less(narrowest, width) else narrowest
        nearest, is_upper_nearer = self.nearest(path, Distances(width, to_lower, to_upper))
        smallest = self.op("*", safe_width, self.smallest_share)
        safe = self.op("+", nearest, self.op("*", self.op("-", safe_width, width), HALF))
        is_clear = path.is_less(smallest, safe)
        to_nearer = safe if is_filled and is_clear else smallest
        to_farther = self.op("-", safe_width, to_nearer)
        a, b = (to_farther, to_nearer) if is_upper_nearer else (to_nearer, to_farther)
        e_max = self.component("e_max", "clamps")
        e = self.limited(path, self.op("/", self.op("-", a, b), safe_width), e_max)
        epsilon, xi = self.transformed(to_nearer, to_farther)
        signed_epsilon = self.op("*", MINUS_ONE if is_upper_nearer else PLUS_ONE, epsilon)
        is_finite = all([path.is_finite(x), path.is_finite(width)])
        for array, value in (("e", e), ("epsilon", signed_epsilon), ("xi", xi)):
            path.effects.append(("store", array, (value if is_filled else 0) if is_finite else self.nan))
        path.effects.append(("return", None))
