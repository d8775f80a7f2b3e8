"""Controllers with random numbers for meaning.py: the listing's functions, and what docs/paper.md says that these compute."""

import math
import secrets
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

from .exact import require
from .translation import functions

Values = list[Fraction]


def random_number() -> Fraction:
    return Fraction(secrets.randbits(200) + 1, secrets.randbits(200) + 1)


@cache
def log(_: Fraction) -> Fraction:
    """Stand for the logarithm: an unknown function."""
    return random_number()


def margin(a: Fraction, b: Fraction) -> Fraction:
    """Return the nearer distance over the width, at least -1."""
    return max(min(a, b) / (a + b), Fraction(-1))


class State(NamedTuple):
    """arguments: x, and for order 2 v. values: x, and for order 2 v + lambda x. sides: by component the distances of x to its
    edges; filtered_sides: those of v + lambda x, and for order 1 of x."""

    arguments: list[Values]
    values: list[Values]
    sides: list[tuple[Fraction, Fraction]]
    filtered_sides: list[tuple[Fraction, Fraction]]


class RandomController:
    """Random numbers of a controller with these options, its functions as Python (c), and what they compute by docs/paper.md."""

    def __init__(self, options: set[str]) -> None:
        self.options, self.n, self.segments, self.t_c, self.divisor = options, 3, 5, random_number(), 7
        n, k = self.n, self.segments
        table = [random_number() for _ in range(2 * n * (k + 3))]
        self.table = [v + table[j - 1] + 1 if j % 2 else v for j, v in enumerate(table)]  # upper edges above lower ones
        self.lists = {name: [random_number() for _ in range(n)] for name in ("gain", "u_max", "e_max", "filter")}
        self.lists["e_max"] = [v / (1 + v) for v in self.lists["e_max"]]
        self.lists["filter"] = [v + 10**80 for v in self.lists["filter"]]  # large, so that the filtered tube has a width
        self.lists["u_max"] = [v / 64 for v in self.lists["u_max"]]  # small, so that u is limited in most states
        if "order 2" in options:
            self.lists["gain"] = [v * 10**80 for v in self.lists["gain"]]  # so that u is about as large as its limits
        for option, name in (("one gain", "gain"), ("one clamp", "e_max"), ("one filter", "filter")):
            self.lists[name] = self.lists[name][:1] * n if option in options else self.lists[name]
        self.lists["least_share"] = [(1 - v) / 2 for v in self.lists["e_max"]]
        self.starts = {f"{kind}start_{side}": [Fraction(0)] * n for kind in ("", "filtered_") for side in ("lower", "upper")}
        numbers: dict[str, Any] = {name: self.lists[name][0] for name in ("gain", "e_max", "filter")} | {
            "limit": random_number() / 64
        }
        numbers |= {f"{name}_minus": -v for name, v in numbers.items()} | {f"row_{j}": 2 * n * j for j in (1, 2, 3)}
        numbers |= {"n": n, "pairs": 2 * n, "t_c": self.t_c, "per_second": k / self.t_c, "last": k - Fraction(1, 1 << 200)}
        numbers |= {"smallest_share": self.lists["least_share"][0], "narrowest": Fraction(1, 1 << 20), "ticks": 12, "tick_num": 3}
        numbers |= {"tick_den": self.divisor, "tick_real": Fraction(7), "tick_end": k * self.divisor, "last_segment": k - 1}
        known: dict[str, Any] = {"N": numbers, "Fraction": Fraction, "log": log, "true": True, "false": False, "NAN": None}
        known |= {"isfinite": lambda _: 1, "M_OK": 0, "M_OUTSIDE_TUBE": 1, "M_BAD_INPUT": 2, "P_coefficients": self.table}
        known |= {f"P_{name}": values for name, values in (self.lists | self.starts).items()}
        self.numbers, self.c = numbers, functions("controller", options, known)

    # ---- by the words

    def edges(self, u: Fraction, i: int, order: int = 0) -> Values:
        """Return both edges at spline time u (order 1: their rates a second): cubic B-splines with control points over 6."""
        segment = min(math.floor(u), self.segments - 1)
        s, first = u - segment, 2 * (self.n * segment + i)
        w = [(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3]
        if order:
            w = [v * self.segments / self.t_c for v in (-3 * (1 - s) ** 2, 9 * s**2 - 12 * s, -9 * s**2 + 6 * s + 3, 3 * s**2)]
        entries = [self.table[first + side :: 2 * self.n][:4] for side in (0, 1)]
        return [sum((a * q for a, q in zip(w, e, strict=True)), Fraction(0)) for e in entries]

    def filtered_edges(self, u: Fraction, i: int) -> Values:
        return [r + self.lists["filter"][i] * e for e, r in zip(self.edges(u, i), self.edges(u, i, 1), strict=True)]

    def transformed(self, a: Fraction, b: Fraction, i: int) -> Values:
        """Return epsilon = ln(a/b) and xi = 1/a + 1/b, of distances to both edges, the nearer one a least share of the width."""
        near = max(min(a, b), self.lists["least_share"][i] * (a + b))
        far = a + b - near
        return [log(far / near) if b < a else -log(far / near), 1 / near + 1 / far]

    def state(self, u: Fraction, *positions: Values) -> State:
        """Return the state that has x, and for order 2 v + lambda x, at these positions between their edges at spline time u."""
        values, sides = [], []
        for edges_of, shares in zip((self.edges, self.filtered_edges), positions, strict=False):
            edges = [edges_of(u, i) for i in range(self.n)]
            values.append([low + (high - low) * p for (low, high), p in zip(edges, shares, strict=True)])
            sides.append([(v - low, high - v) for v, (low, high) in zip(values[-1], edges, strict=True)])
        x, z = values[0], values[-1]
        v = [b - s * a for a, b, s in zip(x, z, self.lists["filter"], strict=True)]
        return State([x, v] if len(values) == 2 else [x], values, sides[0], sides[-1])

    # ---- the listing beside the words

    def check_time(self, t: Fraction, u: Fraction) -> None:
        """Compare the functions of time alone at t, which is spline time u."""
        rates = [tuple(v * (t < self.t_c) for v in self.edges(u, i, 1)) for i in range(self.n)]
        wanted = {"tube": [tuple(self.edges(u, i)) for i in range(self.n)], "tube_rate": rates}
        if "order 2" in self.options:
            wanted["filtered_tube"] = [tuple(self.filtered_edges(u, i)) for i in range(self.n)]
        for name, pairs in wanted.items():
            low, high = [Fraction(0)] * self.n, [Fraction(0)] * self.n
            getattr(self.c, name)(t, low, high)
            require([*zip(low, high, strict=True)] == pairs, f"`{name}` does not compute what it should")

    def check_law(self, control: Callable[..., int], state: State) -> None:
        """Compare `control` or `control_tick`."""
        wanted, outputs = [], [Fraction(0)] * self.n
        for i, (a, b) in enumerate(state.filtered_sides):
            epsilon, xi = self.transformed(a, b, i)
            limit, u = self.lists["u_max"][i], -self.lists["gain"][i] * xi * epsilon
            wanted.append(max(-limit, min(limit, u)) if "limits" in self.options else u)
        if "scaled" in self.options:
            wanted = [v * self.numbers["limit"] / max(self.numbers["limit"], *map(abs, wanted)) for v in wanted]
        is_outside = min(v for pair in (*state.sides, *state.filtered_sides) for v in pair) <= 0
        status = control(*state.arguments, outputs)
        require(status == int(is_outside) and outputs == wanted, "`control` is not the law (13)")

    def check_margins(self, t: Fraction, state: State) -> None:
        """Compare margins, and `covered`: with all bounds about the state, and with each of them at the state itself."""
        outputs = [Fraction(0)] * self.n
        margins = [min(margin(*p), margin(*q)) for p, q in zip(state.sides, state.filtered_sides, strict=True)]
        self.c.margins(t, *state.arguments, outputs)
        is_same = outputs == margins and self.c.margin(t, *state.arguments) == min(Fraction(1, 2), *margins)
        require(is_same, "a margin is not the distance to the nearer edge over the width")
        bounds = [*zip(self.starts.values(), [v for v in state.values for _ in (0, 1)], strict=False)]
        for touching in (None, *((k, i) for k in range(len(bounds)) for i in range(self.n))):
            for k, (bound, values) in enumerate(bounds):
                bound[:] = [v + (0 if touching == (k, i) else (-1, 1)[k % 2]) for i, v in enumerate(values)]
            require(self.c.covered(*state.arguments) == (touching is None), "`covered` is not that all are between their bounds")

    def check_transform(self, width: Fraction, position: Fraction) -> None:
        """Compare `transform` in a tube of this width. One narrower than `narrowest` counts as that wide, about its middle."""
        low, wide = random_number(), max(width, self.numbers["narrowest"])
        x, outputs = low + position * width, [[Fraction(0)] * self.n for _ in range(3)]
        a, b = (v + (wide - width) / 2 for v in (x - low, low + width - x))
        self.c.transform([low] * self.n, [low + width] * self.n, [x] * self.n, *outputs)
        for i, emitted in enumerate(zip(*outputs, strict=True)):
            e_max = self.lists["e_max"][i]
            wanted = [max(-e_max, min(e_max, (a - b) / wide)), *self.transformed(a, b, i)] if width > 0 else [0, 0, 0]
            require([*emitted] == wanted, "`transform` is not e, epsilon and xi")
