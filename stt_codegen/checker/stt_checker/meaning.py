"""What the listings compute, shown once: `python3 checker.pyz --meaning`. To check a controller nothing of this is needed.

The straight lines of the listings are run as Python. On random fractions they must give what the words here say: the tube's edges
and rates, the law (13), its status, the margins, the covered starts and the transform. Two formulas that are no one quotient of
polynomials agree at a point of 200 random bits with a probability below 2^-180. Comparisons are decided by the point; points are
drawn in all their cases. With ranges and errors in place of fractions the same lines give the constants of rounding.py, and for
all 2^16 places in a segment those of integers.py. Loops, calls, casts and tests for NaN are for the reader's eye.
"""

import re
import secrets
from fractions import Fraction
from functools import cache
from typing import Any

from .exact import require
from .integers import WEIGHT_ERROR
from .rounding import EDGE, RATE
from .source import chosen_lines

EPS = Fraction(1, 1 << 24)  # terms with eps^2 are the largest for float
ORDER_1 = frozenset({"order 1", "one gain", "one clamp", "no limits", "libm"})
ORDER_2 = frozenset({"order 2", "one gain", "one clamp", "one filter", "limits", "libm"})
PLACES = tuple(Fraction(v) for v in ("0", "1/10000", "1/3", "1/2", "2/3", "9999/10000", "1", "-1", "3"))  # the edges at 0 and 1
RATE_ERROR = Fraction(9, 4)  # of the three polynomials of an integer rate, in 2^-28


@cache
def statements(piece: str, options: frozenset[str]) -> list[tuple[list[str], Any]]:
    """Return the statements of a straight line: the names that get a value, and the formula as Python, or a kernel's call."""
    result: list[tuple[list[str], Any]] = []
    for line in chosen_lines(piece, set(options)):
        text = re.sub(r"\bP_|\bM_|\$|\((?:P_real|int32_t)\)", "", line.strip())
        assigned = re.fullmatch(r"(?:const )?\w+ \*?(\w+) = (.*);", text) or re.fullmatch(r"\*?(\w+)(?:\[\w+\])? = (.*);", text)
        called = re.fullmatch(r"(\w+)\((.*)\);", text)
        if assigned:
            formula = re.sub(r"(\S+) \? (.+) : (.+)", r"(\2) if (\1) else (\3)", assigned[2])
            formula = re.sub(r"(\d+\.\d+)", r"Fraction('\1')", re.sub(r"!(?!=)", "not ", formula.replace("&&", "and")))
            result.append(([assigned[1]], compile(formula, piece, "eval")))
        elif called:
            words = [v.strip() for v in called[2].split(",")]
            outputs = [v[1:] for v in words if v[0] == "&"]
            inputs = ", ".join(v for v in words if v[0] != "&")
            result.append((outputs, compile(f"{called[1]}({inputs})", piece, "eval")))
    return result


def run(piece: str, options: frozenset[str] = ORDER_1, **known: Any) -> dict[str, Any]:
    """Return the values of all names after a piece. known: values of names before it."""
    known = KERNELS | known
    for names, formula in statements(piece, options):
        value = eval(formula, {}, known)  # noqa: S307 (of the listings, which are ours)
        known |= dict(zip(names, value if len(names) > 1 else [value], strict=True))
    return known


def kernel(name: str) -> list[tuple[str, str]]:
    """Return the assignments of a function of the piece "error transform and law", in order."""
    lines = "\n".join(chosen_lines("error transform and law", set(ORDER_1)))
    body = re.search(rf"P_{name}\(.*?\n\{{\n(.*?)\n\}}", lines, re.DOTALL)
    require(body is not None, f"the listing has no {name}")
    text = re.sub(r"\$|(?:const )?P_real |\*(?=\w+ =)|^\s+|;$", "", body[1] if body else "", flags=re.MULTILINE)
    text = re.sub(r"return (\w+)", r"result = \1", text)
    return [(line.partition(" = ")[0], re.sub(r"(\d+\.\d+)", r"Fraction('\1')", line.partition(" = ")[2])) for line in text.splitlines()]


def call(name: str, *results: str, **known: Any) -> Any:
    known |= {"log": log, "Fraction": Fraction}
    for target, formula in kernel(name):
        known[target] = eval(formula, {}, known)  # noqa: S307 (of the listings, which are ours)
    return [known[r] for r in results] if len(results) > 1 else known[results[0]]


def blend(*values: Any) -> Any:
    """Run the kernel on four weights and four entries."""
    return run("blend", **dict(zip(("w0", "w1", "w2", "w3", "q0", "q1", "q2", "q3"), values, strict=True)))["v6"]


def random_number() -> Fraction:
    return Fraction(secrets.randbits(200), secrets.randbits(200) + 1)


@cache
def log(_: Fraction) -> Fraction:
    """Stand for the logarithm: an unknown function."""
    return random_number()


KERNELS: dict[str, Any] = {
    "shift_up": lambda a, n: a << n, "shift_down": lambda a, n: a >> n, "high_product": lambda a, b: a * b >> 16,
    "Fraction": Fraction, "true": True, "false": False, "isfinite": lambda _: 1, "NAN": None, "blend": blend,
    "transformed_error": lambda a, b: call("transformed_error", "epsilon", "xi", a=a, b=b),
    "law": lambda k, xi, epsilon: call("law", "result", k=k, xi=xi, epsilon=epsilon),
    "normalized_error": lambda a, b, width: call("normalized_error", "result", a=a, b=b, width=width),
}  # fmt: skip


class Inexact:
    """A value between two numbers, and how far it is off; every operation rounds once."""

    def __init__(self, low: Any, high: Any, error: Any = 0) -> None:
        self.low, self.high, self.error = Fraction(low), Fraction(high), Fraction(error)

    def rounded(self) -> "Inexact":
        return Inexact(self.low, self.high, self.error + (max(abs(self.low), abs(self.high)) + self.error) * EPS)

    def __neg__(self) -> "Inexact":
        return Inexact(-self.high, -self.low, self.error)

    def __add__(self, value: Any) -> "Inexact":
        o = value if isinstance(value, Inexact) else Inexact(value, value)
        return Inexact(self.low + o.low, self.high + o.high, self.error + o.error).rounded()

    def __sub__(self, value: Any) -> "Inexact":
        return self + -(value if isinstance(value, Inexact) else Inexact(value, value))

    def __mul__(self, value: Any) -> "Inexact":
        o = value if isinstance(value, Inexact) else Inexact(value, value)
        ends = [v * w for v in (self.low, self.high) for w in (o.low, o.high)]
        lowest = max(min(ends), Fraction(0)) if self is o else min(ends)  # a square is not negative
        sizes = [max(abs(v.low), abs(v.high)) for v in (self, o)]
        return Inexact(lowest, max(ends), sizes[0] * o.error + sizes[1] * self.error + self.error * o.error).rounded()

    def __rsub__(self, value: Any) -> "Inexact":
        return Inexact(value, value) - self

    __radd__, __rmul__ = __add__, __mul__


def weights(s: Any, letter: str = "w") -> dict[str, Any]:
    """Return the weights of `basis` by name, or with the letters dw those of `basis_rate`."""
    known = run("basis" if letter == "w" else "rate of the basis", s=s)
    return {f"{letter}{j}": known[f"{letter}{j}"] for j in range(4)}


def spline(entries: list[Fraction], s: Fraction) -> tuple[Fraction, Fraction]:
    """Return the uniform cubic B-spline with these control points over 6, and its rate in a segment's time, by the words."""
    w = [(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3]
    d = [-3 * (1 - s) ** 2, 9 * s**2 - 12 * s, -9 * s**2 + 6 * s + 3, 3 * s**2]
    return sum((a * q for a, q in zip(w, entries, strict=True)), Fraction(0)), sum((a * q for a, q in zip(d, entries, strict=True)), Fraction(0))


def law(a: Fraction, b: Fraction, k: Fraction, share: Fraction) -> Fraction:
    """Return u = -k xi epsilon with e clamped, by the words: epsilon = ln(a/b), xi = 1/a + 1/b; a and b are at least the share."""
    near = max(min(a, b), share * (a + b))
    far = a + b - near
    epsilon = log(far / near) if b < a else -log(far / near)
    return -k * (1 / near + 1 / far) * epsilon


def smaller_share(a: Fraction, b: Fraction) -> Fraction:
    """Return a margin by the words: the nearer distance over the width, at least -1."""
    return max(min(a, b) / (a + b), Fraction(-1))


def clip(u: Fraction, limit: Fraction) -> Fraction:
    return max(-limit, min(limit, u))


def check_functions() -> None:
    """Compare the straight lines with the words, at places within, at and beyond both edges of x and of v + lambda x."""
    n, s = 3, Fraction(secrets.randbits(200), 1 << 200)
    i, row = secrets.randbelow(n), 2 * n * secrets.randbelow(5)
    table = [random_number() for _ in range(2 * n * 9)]
    table = [v + table[j - 1] + 1 if j % 2 else v for j, v in enumerate(table)]  # upper edges above lower ones
    k, share, limit, per = random_number(), Fraction(1, 200), random_number(), random_number()
    (low, low_rate), (high, high_rate) = (spline(table[row + 2 * i + side :: 2 * n][:4], s) for side in (0, 1))
    low_rate, high_rate = low_rate * per, high_rate * per
    lambda_ = random_number() + abs(high_rate - low_rate) / (high - low)  # so that the filtered tube has a width
    known: dict[str, Any] = {**weights(s), **weights(s, "dw"), "row": row, "i": i, "coefficients": table, "per_second": per}
    known |= {"edge_at": lambda at, *w: run("edge", coefficients=table, at=at, **{f"row_{j}": 2 * n * j for j in (1, 2, 3)},
                                            **{f"w{j}": v for j, v in enumerate(w)})["v0"]}  # fmt: skip
    known |= {"gain": k, "gain_minus": -k, "smallest_share": share, "filter": lambda_, "outside": False, "u_max": [limit] * n}
    for outer in PLACES:
        x = [low + (high - low) * outer] * n
        a, b = x[i] - low, high - x[i]
        state = run("state between the edges", ORDER_1, **known, x=x)
        epsilon, xi = KERNELS["transformed_error"](state["to_nearer"], state["to_farther"])
        require(KERNELS["law"](state["gain"], xi, epsilon) == law(a, b, k, share), "the listing's law is not (13)")
        require(state["outside_next"] == (not min(a, b) > 0), "the listing's status is not that of x")
        margin = run("margin of a component", ORDER_1, **known, x=x)
        require(margin["margin_x"] == smaller_share(a, b), "the listing's margin is not that of x")
        for inner in PLACES:
            width = high_rate - low_rate + lambda_ * (high - low)
            v = [low_rate - lambda_ * a + inner * width] * n
            p, q = v[i] - low_rate + lambda_ * a, high_rate - v[i] + lambda_ * b
            state = run("state and rate between the edges", ORDER_2, **known, x=x, v=v)
            epsilon, xi = KERNELS["transformed_error"](state["to_nearer"], state["to_farther"])
            require(KERNELS["law"](state["gain"], xi, epsilon) == law(p, q, k, share), "the listing's law of order 2 is not (13)")
            require(state["outside_next"] == (not min(a, b, p, q) > 0), "the listing's status is not that of x and v")
            margin = run("margin of a component", ORDER_2, **known, x=x, v=v)
            wanted = min(smaller_share(a, b), smaller_share(p, q))
            require(margin["smaller"] == wanted, "the listing's margin is not the smaller one")


def check_rounding() -> None:
    """Compute the constants of rounding.py and of integers.py."""
    for letter, (first, second) in (("w", EDGE), ("dw", RATE)):
        error = blend(*weights(Inexact(0, 1), letter).values(), *[Inexact(-1, 1) for _ in range(4)]).error / EPS
        require(round(error) == first and (error - round(error)) / EPS <= second, f"an edge or a rate rounds by {float(error):.6g} eps")
    outer = inner = between = Fraction(0)
    for ticks in range(1 << 16):
        s, w = Fraction(ticks, 1 << 16), run("integer weights", s=ticks)
        outer = max(outer, abs(Fraction(w["before"], 1 << 15) - (1 - s) ** 3) + abs(Fraction(w["after"], 1 << 15) - s**3))
        inner = max(inner, abs(Fraction(w["middle"], 1 << 14) - 3 * s - 3 * s**2 + 2 * s**3))
        r = run("integer rates", frozenset({"order 2"}), s=ticks, mantissa=0, half=0, rate_down=0)
        exact = (1 - s) ** 2, 1 + 2 * s * (1 - s), s * s
        emitted = (r["left_held"], r["middle"], r["square"])
        between = max(between, sum(abs(v - c * (1 << 28)) for v, c in zip(emitted, exact, strict=True)))
    require((outer + inner, between) == (WEIGHT_ERROR, RATE_ERROR), "the weights of integers are off by other constants")


def main() -> int:
    """Check everything, and print one line. Raises `Refused` where a listing means something else."""
    for _ in range(3):
        check_functions()
    check_rounding()
    print("checker: the listings compute the tube and the law, and round no more than rounding.py and integers.py say")
    return 0
