"""The operations of a Program, one row each: what printers and readers need to know of one.

A new operation is a new row and nothing else.

Long because each operation is described here once, with how errors pass through it.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from enum import Enum
from fractions import Fraction
from math import isqrt
from typing import Any, Protocol

LIBRARY_ULPS = 2  # units in the last place: the assumed error of a function of the C library (docs/c.md)


class Type(Enum):
    """The type of a value of a Program."""

    REAL = "real"  # float or double, the program's scalar
    INT = "int"  # a table index or loop counter, at least 32 bits
    TICK = "tick"  # a count from 0 to 2^32 - 1, a parameter only
    BOOL = "bool"
    STATUS = "status"


REAL, INT, TICK, BOOL, STATUS = Type.REAL, Type.INT, Type.TICK, Type.BOOL, Type.STATUS
COST_KINDS = ("add", "mul", "div", "math", "compare", "select", "load", "store", "integer")


class InexactRange(Protocol):
    """An argument in [low, high] that is wrong by at most `error`; size: its largest absolute value. Exact."""

    @property
    def low(self) -> Fraction: ...
    @property
    def high(self) -> Fraction: ...
    @property
    def error(self) -> Fraction: ...
    @property
    def size(self) -> Fraction: ...


class Points(Protocol):
    """Values of an argument at many points, as an array, and a bound on the error of each."""

    @property
    def value(self) -> Any: ...
    @property
    def error(self) -> Any: ...


Bounds = tuple[Fraction, Fraction, Fraction]  # the ends of the range of the results, and their error before rounding
Ranged = Callable[..., Bounds | None]  # of `InexactRange`s; exact, so that what it returns is a bound
Spread = Callable[..., tuple[Any, Any]]  # of NumPy and `Points`: the results, and their errors before rounding


@dataclass(frozen=True)
class Operation:
    """What printers and readers need to know of one operation.

    args, result: types. cost: one of COST_KINDS. number: the operation on Python's numbers. infix, call: its sign or its function
    in C, without the suffix of the precision. casadi: CasADi's names of it. ball: its Python source over balls, which may call
    functions of analyse/ball_arithmetic.py. formula: the operation on SymPy's expressions; its first argument is SymPy. opposite:
    SymPy's name of the comparison that holds where this one does not. commutes: whether arguments may change places.

    ulps: the rounding error of a result in units in the last place, 0 where it is exact, None where it is no real. underflows:
    whether a result near 0 has an absolute error besides. Errors of arguments pass through an operation by one of two fields:
    change: NumPy's name of it and where its domain begins, if it has one argument and rises or falls throughout; else spread.
    ranged: the same for ranges of arguments, None where no bound on rounding needs it.
    """

    args: tuple[Type, ...]
    result: Type
    cost: str
    number: Callable[..., Any]
    infix: str = ""
    _: KW_ONLY
    call: str = ""
    casadi: tuple[str, ...] = ()
    ball: str = ""
    ulps: float | None = None
    underflows: bool = True
    formula: Callable[..., Any] | None = None
    opposite: str = ""
    change: tuple[str, float] | None = None
    spread: Spread | None = None
    ranged: Ranged | None = None
    commutes: bool = False

    @property
    def compares(self) -> bool:
        """Whether it is a comparison of two numbers; with a NaN it is false, `ne` true, as in IEEE 754."""
        return self.result is BOOL and BOOL not in self.args


def _quotient(a: float, b: float) -> float:
    """Return a / b as IEEE 754 has it, infinite or NaN for b = 0."""
    if b:
        return a / b
    return math.nan if math.isnan(a) or not a else math.copysign(math.inf, a)


def _logarithm(a: float) -> float:
    return math.log(a) if a > 0 else math.nan


def _split(a: float) -> tuple[float, int]:
    """Return m and e with a = m 2^e, m in [1/sqrt 2, sqrt 2), for a >= 1/sqrt 2."""
    e = math.frexp(a * math.sqrt(0.5))[1]
    return a / 2.0**e, e


def monotone_change(np: Any, f: Callable[[Any], Any], a: Points, floor: float) -> Any:
    """Return the largest change of a monotone f, defined above `floor`, within the error of its argument; infinite where the
    argument may reach a pole at `floor`."""
    value = f(a.value)
    down = np.abs(value - f(np.maximum(a.value - a.error, floor)))
    up = np.abs(f(a.value + a.error) - value)
    return np.where(a.error == 0, 0.0, np.maximum(down, up))


def _quotient_spread(np: Any, a: Points, b: Points) -> tuple[Any, Any]:
    smallest_divisor, quotient = np.abs(b.value) - b.error, a.value / b.value
    error = (a.error + np.abs(quotient) * b.error) / smallest_divisor
    return quotient, np.where(smallest_divisor > 0, error, np.inf)


def _product_spread(np: Any, a: Points, b: Points) -> tuple[Any, Any]:
    return a.value * b.value, np.abs(a.value) * b.error + np.abs(b.value) * a.error + a.error * b.error


def _power_spread(np: Any, a: Points, b: Points) -> tuple[Any, Any]:
    """Return the power of a positive base and a constant exponent, with its error."""
    value = np.power(a.value, b.value)
    spread = monotone_change(np, lambda base: np.asarray(np.power(base, b.value)), a, 0.0)
    return value, spread + np.abs(value * np.log(np.maximum(a.value, 1e-300))) * b.error


def _absolute_range(a: InexactRange) -> Bounds:
    return Fraction(0) if a.low <= 0 <= a.high else min(abs(a.low), abs(a.high)), a.size, a.error


def _product_range(a: InexactRange, b: InexactRange) -> Bounds:
    """Return the range of a product; that of a square is not negative."""
    corners = [x * y for x in (a.low, a.high) for y in (b.low, b.high)]
    low = Fraction(0) if a is b and a.low <= 0 <= a.high else min(corners)
    return low, max(corners), a.size * b.error + b.size * a.error + a.error * b.error


def _quotient_range(a: InexactRange, by: InexactRange) -> Bounds | None:
    """Return the range of a quotient by a constant above 0; None for any divisor but such a constant."""
    if not by.low == by.high > 0:
        return None
    smallest_divisor = by.low - by.error
    error = (a.error + a.size / by.low * by.error) / smallest_divisor
    return min(a.low / by.low, a.high / by.low), a.high / by.low, error


def _exp_range(a: InexactRange) -> Bounds | None:
    """Return the range of exp for an argument not above 0, else None.

    The slope is at most exp(error) <= 1 + 2 error; computed exponents are not above 0 either.
    """
    return (Fraction(0), Fraction(1), min(a.error * (1 + 2 * a.error), Fraction(1))) if a.high <= 0 else None


def _log1p_range(a: InexactRange) -> Bounds | None:
    """Return the range of log1p for an argument not below 0, else None: it is below its argument, and its slope is at most 1."""
    return (Fraction(0), a.high, a.error) if a.low >= 0 else None


def _sqrt_range(a: InexactRange) -> Bounds | None:
    """Return the range of a root; None where the argument may be 0.

    |sqrt a - sqrt b| = |a - b|/(sqrt a + sqrt b) <= error/sqrt(low). Roots of fractions are those of integers of 160 bits.
    """
    if a.low <= a.error:
        return None

    def root(value: Fraction, round_up: int) -> Fraction:
        shift = 80 + max(0, value.denominator.bit_length() - value.numerator.bit_length())
        return Fraction(isqrt((value.numerator << 2 * shift) // value.denominator) + round_up, 1 << shift)

    return root(a.low, 0), root(a.high, 1), a.error / root(a.low, 0)


def _arithmetic(infix: str, number: Callable[..., Any], casadi: str, **more: Any) -> Operation:
    return Operation(
        (REAL, REAL), REAL, more.pop("cost", "add"), number, infix, casadi=(casadi,), ball=f"{{0}} {infix} {{1}}", ulps=0.5,
        formula=lambda _, a, b: number(a, b), **more,
    )  # fmt: skip


def _exact(number: Callable[..., Any], casadi: str, ball: str, **more: Any) -> Operation:
    return Operation((REAL,), REAL, more.pop("cost", "add"), number, casadi=(casadi,), ball=ball, ulps=0, **more)


def _library(name: str, number: Callable[..., Any], formula: Callable[..., Any] | None = None, **more: Any) -> Operation:
    """Return the row of a function of <math.h> of one argument."""
    sympy_formula = formula or (lambda sp, a: getattr(sp, name)(a))
    return Operation(
        (REAL,), REAL, "math", number, call=name, casadi=(f"OP_{name.upper()}",), ball=f"{{0}}.{name}()",
        ulps=more.pop("ulps", LIBRARY_ULPS), formula=sympy_formula, **more,
    )  # fmt: skip


def _comparison(
    kind: Type, infix: str, number: Callable[..., bool], *, ball: str, relation: str, opposite: str, casadi: str = ""
) -> Operation:
    """Return the row of a comparison of two numbers; relation, opposite: SymPy's names of it and of its negation."""
    return Operation(
        (kind, kind), BOOL, "compare", number, infix, casadi=(casadi,) if casadi else (), ball=ball,
        formula=lambda sp, a, b: getattr(sp, relation)(a, b), opposite=opposite, commutes=relation in ("Eq", "Ne"),
    )  # fmt: skip


def _truth(infix: str, number: Callable[..., bool], casadi: str, ball: str, count: int = 2) -> Operation:
    kinds = (BOOL,) * count
    return Operation(kinds, BOOL, "compare", number, infix, casadi=(casadi,), ball=ball, commutes=count == 2)


def _integer(infix: str, number: Callable[..., int], ball: str) -> Operation:
    return Operation((INT, INT), INT, "integer", number, infix, ball=ball)


OPERATIONS: dict[str, Operation] = {
    "add": _arithmetic(
        "+", operator.add, "OP_ADD", underflows=False, commutes=True,
        spread=lambda _, a, b: (a.value + b.value, a.error + b.error),
        ranged=lambda a, b: (a.low + b.low, a.high + b.high, a.error + b.error),
    ),
    "sub": _arithmetic(
        "-", operator.sub, "OP_SUB", underflows=False,
        spread=lambda _, a, b: (a.value - b.value, a.error + b.error),
        ranged=lambda a, b: (a.low - b.high, a.high - b.low, a.error + b.error),
    ),
    "mul": _arithmetic(
        "*", operator.mul, "OP_MUL", cost="mul", commutes=True, spread=_product_spread, ranged=_product_range,
    ),
    "div": Operation(
        (REAL, REAL), REAL, "div", _quotient, "/", casadi=("OP_DIV",), ball="{0} / {1}", ulps=0.5,
        formula=lambda _, a, b: a / b, spread=_quotient_spread, ranged=_quotient_range,
    ),
    "pow": Operation(
        (REAL, REAL), REAL, "math", operator.pow, call="pow", casadi=("OP_POW", "OP_CONSTPOW"), ball="{0} ** {1}",
        ulps=LIBRARY_ULPS, formula=lambda _, a, b: a**b, spread=_power_spread,
    ),
    "neg": _exact(
        operator.neg, "OP_NEG", "-{0}", formula=lambda _, a: -a,
        spread=lambda _, a: (-a.value, a.error), ranged=lambda a: (-a.high, -a.low, a.error),
    ),
    "fabs": _exact(
        abs, "OP_FABS", "abs({0})", call="fabs", formula=lambda sp, a: sp.Abs(a),
        spread=lambda np, a: (np.abs(a.value), a.error), ranged=_absolute_range,
    ),
    "floor": _exact(lambda a: float(math.floor(a)), "OP_FLOOR", "{0}.floor()", call="floor", cost="math"),
    "ceil": _exact(lambda a: float(math.ceil(a)), "OP_CEIL", "{0}.ceil()", call="ceil", cost="math"),
    "sqrt": _library("sqrt", math.sqrt, ulps=0.5, change=("sqrt", 0.0), ranged=_sqrt_range),
    "exp": _library("exp", math.exp, change=("exp", -math.inf), ranged=_exp_range),
    "expm1": _library("expm1", math.expm1, lambda sp, a: sp.exp(a) - 1, change=("expm1", -math.inf)),
    "log": _library("log", _logarithm, change=("log", 0.0)),
    "log1p": _library("log1p", math.log1p, lambda sp, a: sp.log(1 + a), change=("log1p", -1.0), ranged=_log1p_range),
    "tanh": _library("tanh", math.tanh, change=("tanh", -math.inf)),
    "sinh": _library("sinh", math.sinh, change=("sinh", -math.inf)),
    "cosh": _library("cosh", math.cosh),
    "atanh": _library("atanh", math.atanh),
    "sin": _library("sin", math.sin),
    "cos": _library("cos", math.cos),
    "tan": _library("tan", math.tan),
    "lt": _comparison(
        REAL, "<", operator.lt, ball="_is_less({0}, {1}, False)", relation="Lt", opposite="Ge", casadi="OP_LT",
    ),
    "le": _comparison(
        REAL, "<=", operator.le, ball="_is_less({0}, {1}, True)", relation="Le", opposite="Gt", casadi="OP_LE",
    ),
    "eq": _comparison(REAL, "", operator.eq, ball="_is_equal({0}, {1})", relation="Eq", opposite="Ne", casadi="OP_EQ"),
    "ne": _comparison(
        REAL, "", operator.ne, ball="_not(_is_equal({0}, {1}))", relation="Ne", opposite="Eq", casadi="OP_NE",
    ),
    "ilt": _comparison(INT, "<", operator.lt, ball="_is_less_integer({0}, {1})", relation="Lt", opposite="Ge"),
    "tlt": _comparison(TICK, "<", operator.lt, ball="_is_less_integer({0}, {1})", relation="Lt", opposite="Ge"),
    "and": _truth("&&", lambda a, b: a and b, "OP_AND", "_and({0}, {1})"),
    "or": _truth("||", lambda a, b: a or b, "OP_OR", "_not(_and(_not({0}), _not({1})))"),
    "not": _truth("", operator.not_, "OP_NOT", "_not({0})", 1),
    "iadd": _integer("+", operator.add, "_add({0}, {1})"),
    "isub": _integer("-", operator.sub, "_subtract({0}, {1})"),
    "ineg": Operation((INT,), INT, "integer", operator.neg, ball="_negate({0})"),
    "imul": _integer("*", operator.mul, "_multiply({0}, {1})"),
    "idiv": _integer("/", operator.floordiv, "_divide({0}, {1})"),  # of a number not negative by a positive one, rounded down
    "ishr": _integer(">>", operator.rshift, "_shift_right({0}, {1})"),  # rounded down, of a negative number too
    "ishl": _integer("<<", operator.lshift, "_shift_left({0}, {1})"),  # of a number not negative
    "high_product": Operation(  # a b / 2^16 rounded down, 0 <= b < 2^16: a product of 48 bits without its last 16
        (INT, INT), INT, "mul", lambda a, b: a * b >> 16, ball="_high_product({0}, {1})",
    ),
    # of 16 bits each, the first with a sign, the second without one
    "product": Operation((INT, INT), INT, "mul", operator.mul, "*", ball="_multiply({0}, {1})"),
    # a mod 2^k, for a second argument of 2^k - 1
    "low_bits": Operation((INT, INT), INT, "integer", operator.and_, ball="_mask({0}, {1})"),
    "short": Operation((INT,), INT, "integer", lambda a: a, ball="_unchanged({0})"),  # of 16 bits, which C then knows
    # of a > 0: by how many places it can be shifted left, so that it is in [2^30, 2^31)
    "leading": Operation((INT,), INT, "integer", lambda a: 31 - a.bit_length(), ball="_leading_places({0})"),
    "int": Operation((TICK,), INT, "integer", int, ball="_unchanged({0})"),  # of a count below 2^31
    "real": Operation((INT,), REAL, "integer", float, ball="_integer_ball({0})", formula=lambda _, a: a),
    # of y >= 1/sqrt 2, y = mantissa 2^exponent with the mantissa in [1/sqrt 2, sqrt 2); exact
    "exponent": Operation(
        (REAL,), INT, "integer", lambda a: _split(a)[1], ball="_exponent({0}, _smallest_mantissa)",
        formula=lambda sp, a: sp.Function("exponent")(a),
    ),
    "mantissa": Operation(
        (REAL,), REAL, "integer", lambda a: _split(a)[0], ball="_mantissa({0}, _smallest_mantissa)", ulps=0,
        formula=lambda sp, a: sp.Function("mantissa")(a),
    ),
}  # fmt: skip
