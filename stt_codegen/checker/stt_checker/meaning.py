"""What the listings compute, shown once: `python3 checker.pyz --meaning`. To check a controller nothing of this is needed.

The functions of the listings are run as Python (translation.py), loops and calls too, on random fractions. They must give what
the words of random_controllers.py say: the tube, the law (13), its status, margins, covered starts, the transform. Formulas
that are no one quotient of polynomials agree at a point of 200 random bits with a probability below 2^-180. Points are drawn in
all cases of the comparisons. With ranges and errors in place of fractions the same lines give the constants of rounding.py, and
at all 2^16 places of a segment those of integers.py. Tests for NaN, what a cast may lose, and a u that is stored over x are for
the reader's eye.
"""

import math
import secrets
from fractions import Fraction
from functools import partial
from typing import Any

from .controller import BEND, LN_2
from .exact import require, rounded
from .integers import RATE_POWER_ERROR, WEIGHT_ERROR
from .random_controllers import RandomController, random_number
from .rounding import EDGE, RATE
from .translation import EPS, Inexact, functions

POSITIONS = tuple(
    Fraction(v) for v in ("0", "1/10000", "1/3", "1/2", "2/3", "9999/10000", "1", "-1", "3", "1e-100")
)  # the edges at 0 and 1
INSIDE = (Fraction(1, 3), Fraction(2, 3), Fraction(3, 5))  # positions of three components
COMBINATIONS = (  # every line of the listings in floating point is in one of them, but for the inline logarithm
    "order 1, one gain, one clamp, no limits, libm, ticks", "order 1, gains, clamps, no limits, scaled, libm",
    "order 2, one gain, one clamp, one filter, no limits, libm",
    "order 2, gains, clamps, filters, limits, differences, libm, ticks",
)  # fmt: skip


def check_functions(options: set[str]) -> None:
    """Compare all functions of a listing, at times and positions within, at and beyond the ends and the edges."""
    controller, orders = RandomController(options), 1 + ("order 2" in options)
    end, c = controller.numbers["last"], controller.c
    for share in (Fraction(secrets.randbits(200), 1 << 200), *map(Fraction, (-1, 0, 1, 2))):
        controller.check_time(share * controller.t_c, max(Fraction(0), min(end, share * controller.segments)))
    u = Fraction(secrets.randbits(200), 1 << 200) * controller.segments
    t, states = u * controller.t_c / controller.segments, []
    for k, position in enumerate(POSITIONS):  # of one component, the others being inside, so that the status depends on it
        for j, filtered_position in enumerate(POSITIONS if orders == 2 else POSITIONS[:1]):
            x, z = [*INSIDE], [*reversed(INSIDE)]
            x[(k + j) % 3], z[(k + j) % 3] = position, filtered_position
            states.append([x, z][:orders])
        for width in (random_number(), Fraction(1, 1 << 30), Fraction(0), Fraction(-1)):
            controller.check_transform(width, position)
    states.append([[Fraction("0.5000000001")] * 3] * orders)  # near the middle, where u is within its limits
    for positions in states:
        state = controller.state(u, *positions)
        controller.check_law(partial(c.control, t), state)
        controller.check_margins(t, state)
    for positions in 4 * states if "scaled" in options else []:  # with u about as large as its limit, which is far below 1
        controller.lists["gain"][:] = [random_number() * controller.numbers["limit"] for _ in positions[0]]
        controller.check_law(partial(c.control, t), controller.state(u, *positions))
    for tick in range(14) if "ticks" in options else ():
        u = min(Fraction(3 * min(tick, 12), controller.divisor), Fraction(controller.segments))
        controller.check_law(partial(c.control_tick, tick), controller.state(u, *states[tick % len(states)]))
    for dt in (random_number(), Fraction(1, 1 << 99), Fraction(0), -random_number()) if "differences" in options else ():
        x, before, v = ([random_number()] * 3 for _ in range(3))
        c.velocity(dt, x, before, v)
        require(v == [(x[0] - before[0]) / dt if dt > 0 else None] * 3, "`velocity` is no difference over dt")


def check_logarithm() -> None:
    """Compare the inline logarithm with ln y, for y = m 2^e with m in [1/sqrt 2, sqrt 2)."""
    for y in (Fraction(m, 100) * Fraction(2) ** e for e in range(-20, 21, 4) for m in range(71, 142)):
        e = math.floor(math.log2(y) + 0.5)
        known = {"N": {"bend": rounded(BEND, 24), "ln_2": rounded(LN_2, 53)}, "Fraction": Fraction, "P_exponent": lambda _: e}  # noqa: B023
        c = functions("error transform and law", {"inline"}, known | {"P_mantissa": lambda _: y / Fraction(2) ** e})  # noqa: B023
        require(abs(float(c.transformed_error(Fraction(1), y)[0]) + math.log(y)) < 2**-14, "the inline logarithm is no logarithm")


def check_rounding() -> None:
    """Compute the constants of rounding.py and of integers.py."""
    numbers = {f"row_{j}": j for j in (1, 2, 3)}
    known: dict[str, Any] = {"N": numbers, "Fraction": Fraction, "P_coefficients": [Inexact(-1, 1) for _ in range(4)]}
    edge_at = functions("edge", set(), known).edge_at
    for piece, weights, (first, second) in (("basis", "basis", EDGE), ("rate of the basis", "basis_rate", RATE)):
        error = edge_at(0, *getattr(functions(piece, set(), known), weights)(Inexact(0, 1))).error / EPS
        is_bound = round(error) == first and (error - round(error)) / EPS <= second
        require(is_bound, f"an edge or a rate rounds by {float(error):.6g} eps")
    counted: dict[str, Any] = {"P_shift_up": lambda a, n: a << n, "P_shift_down": lambda a, n: a >> n}
    counted["P_high_product"] = lambda a, b: a * b >> 16
    # With these constants rates are three times their polynomials in 2^-28.
    counted["N"] = {"rate_mantissa": 1 << 16, "rate_half": 0, "rate_shift": 0}
    weights_at, rates_at = functions("integer weights", set(), counted).weights, functions("integer rates", set(), counted).rates
    outer = inner = between = Fraction(0)
    for tick in range(1 << 16):
        s, (w0, w1, w2) = Fraction(tick, 1 << 16), weights_at(tick)
        outer = max(outer, abs(Fraction(w0, 1 << 15) - (1 - s) ** 3) + abs(Fraction(w2, 1 << 15) - s**3))
        inner = max(inner, abs(Fraction(w1, 1 << 14) - 3 * s - 3 * s**2 + 2 * s**3))
        exact = (1 - s) ** 2, 1 + 2 * s * (1 - s), s * s
        errors = [abs(Fraction(r, 3) - c * (1 << 28)) for r, c in zip(rates_at(tick), exact, strict=True)]
        between = max(between, sum(errors, Fraction(0)))
    is_bound = (outer + inner, 3 * between / (1 << 28)) == (WEIGHT_ERROR, RATE_POWER_ERROR)
    require(is_bound, "the weights of integers are wrong by other constants")


def check_meaning() -> None:
    """Check everything. Raises `Refused` where a listing means something else."""
    for options in COMBINATIONS:
        check_functions({*options.split(", ")})
    check_logarithm()
    check_rounding()
