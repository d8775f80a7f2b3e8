"""A reader that runs a Program in ball arithmetic (Arb, through python-flint): every output encloses all that the function
gives for inputs within the given balls.

With `rounding`, the balls also hold every number that the emitted arithmetic may give: half a unit in the last place for
+ - * / and sqrt, `LIBRARY_ULPS` units for every other function of the C library, and underflow. Constants and tables are
those that are printed. The emitted Python computes the same in double, so it is enclosed too. Overflow is not looked for:
the emitted functions hold every argument of exp below its own.

Where balls leave a comparison undecided, a kernel is run once for each outcome and the results are joined; in a function's
frame both choices of a Select, both ways of a Return and all entries of a Load are joined. A Select that is a maximum or
minimum is read as that, which is tighter.

The program is turned into Python source once, so that one operation is one call into Arb.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from flint import arb, fmpq

from stt_codegen.program.number import FORMATS, exponent_of, round_to
from stt_codegen.program.program import (
    BOOL,
    INT,
    TICK,
    Assign,
    Call,
    Const,
    Expression,
    For,
    Function,
    IsFinite,
    Kernel,
    Load,
    Op,
    Operand,
    Program,
    Return,
    Select,
    Statement,
    Status,
    Store,
    Trunc,
    Var,
    operands,
)
from stt_codegen.program.running import LIBRARY_ULPS

Ball = Any  # flint.arb has no types
OUTCOMES = (-1, 0, 1)  # of a comparison: less, equal, greater


class Enclosure:
    """The kernels and functions of one program as Python callables over balls."""

    def __init__(self, program: Program, rounding: bool) -> None:
        self.program = program
        form = FORMATS[program.scalar]
        ulps = form.roundoff * 2 * LIBRARY_ULPS
        printer = _Printer(program, rounding)
        names: dict[str, Any] = {f.__name__: f for f in _HELPERS}
        names |= {"_one": arb(1, _up(form.roundoff)), "_ulps": arb(1, _up(ulps))}
        names |= {"_least_mantissa": form.least_mantissa}
        names |= {"_tiny": arb(0, _up(form.tiny) * 2 * LIBRARY_ULPS)}
        names |= {printer.table(t.name): [ball(round_to(v, program.scalar)) for v in t.values] for t in program.tables}
        names |= {f"_k_{k.name}": self._split(k.name) for k in program.kernels}
        parts = [*map(printer.kernel, program.kernels), *map(printer.function, program.functions)]
        names |= printer.constants
        self._names = names
        exec(compile("\n".join(line for part in parts for line in part), f"<{program.prefix} in balls>", "exec"), names)

    def kernel(self, name: str, *inputs: Ball) -> tuple[Ball, ...]:
        """The outputs of a kernel."""
        outputs: tuple[Ball, ...] = self._names[f"_k_{name}"](*inputs)
        return outputs

    def run(self, function: str, **inputs: Ball | Sequence[Ball]) -> tuple[dict[str, list[Ball]], Any]:
        """The output arrays of a function; and every status that it may return (none when it returns none), or the ball of
        the real that it returns."""
        outputs, statuses = self._names[function](**inputs)
        names = [p.name for p in self.program.function(function).outputs]
        return dict(zip(names, outputs, strict=True)), statuses

    def _split(self, name: str) -> Callable[..., tuple[Ball, ...]]:
        """A kernel that is run for every outcome of the comparisons that its inputs leave undecided."""

        def run(*inputs: Ball) -> tuple[Ball, ...]:
            return split(inputs, {})

        def split(inputs: tuple[Ball, ...], assumed: dict[str, int]) -> tuple[Ball, ...]:
            try:
                outputs: tuple[Ball, ...] = self._names[f"_k_{name}_once"](assumed, *inputs)
            except _Undecided as open_:
                first, *others = (split(inputs, {**assumed, open_.pair: outcome}) for outcome in OUTCOMES)
                for other in others:
                    first = tuple(map(_hull, first, other))
                return first
            return outputs

        return run


def ball(value: Fraction | float | int) -> Ball:
    """The number as a ball; exact where it is dyadic and short."""
    exact = Fraction(value)
    return arb(fmpq(exact.numerator, exact.denominator))


def hull(low: float, high: float) -> Ball:
    """A ball that holds [low, high]."""
    return arb(low).union(arb(high))


def _up(value: Fraction) -> float:
    """A double that is not below a positive fraction."""
    return float(value) * (1 + 2**-50) + 5e-324


# ------------------------------------------------------------------------------- what the printed source calls


class _Undecided(Exception):
    """A comparison in a kernel that the balls leave open; `pair` names its operands."""

    def __init__(self, pair: str) -> None:
        self.pair = pair


@dataclass(frozen=True)
class _Span:
    """An integer known only to lie in low..high."""

    low: int
    high: int


_Int = int | _Span
_Truth = bool | None  # None: may be either


def _ends(value: _Int) -> tuple[int, int]:
    return (value, value) if isinstance(value, int) else (value.low, value.high)


def _span(values: Iterable[int]) -> _Int:
    found = list(values)
    return found[0] if min(found) == max(found) else _Span(min(found), max(found))


def _compared(assumed: dict[str, int], pair: str, a: Ball, b: Ball) -> int:
    if a < b:
        return -1
    if a > b:
        return 1
    if pair in assumed:
        return assumed[pair]
    raise _Undecided(pair)


def _less(a: Ball, b: Ball, or_equal: bool) -> _Truth:
    if a < b or (or_equal and a <= b):
        return True
    return False if a > b or (not or_equal and a >= b) else None


def _equal(a: Ball, b: Ball) -> _Truth:
    if a == b:
        return True
    return False if a != b else None


def _both(a: _Truth, b: _Truth) -> _Truth:
    if a is False or b is False:
        return False
    return True if a and b else None


def _not(a: _Truth) -> _Truth:
    return None if a is None else not a


def _hull(a: Any, b: Any) -> Any:
    """What may be either: of balls, integers, truth values or sets of statuses."""
    if isinstance(a, frozenset):
        return a | b
    if isinstance(a, bool) or a is None:
        return a if a is b else None
    if isinstance(a, int | _Span):
        return _span((*_ends(a), *_ends(b)))
    return a.union(b)


def _choose(condition: _Truth, then: Any, other: Any) -> Any:
    if condition is None:
        return _hull(then, other)
    return then if condition else other


def _finite(a: Ball) -> _Truth:
    return True if a.is_finite() else None


def _trunc(a: Ball, most: int | None) -> _Int:
    """`most`: the largest that it can be, where that is known; a ball's own end may be a little above it."""
    ends = int(float(a.lower())), int(float(a.upper()))
    return _span(ends if most is None else (min(end, most) for end in ends))


def _added(a: _Int, b: _Int) -> _Int:
    return _span(x + y for x, y in zip(_ends(a), _ends(b), strict=True))


def _times(a: _Int, b: _Int) -> _Int:
    return _span(x * y for x in _ends(a) for y in _ends(b))


def _less_by(a: _Int, b: _Int) -> _Int:
    (a_low, a_high), (b_low, b_high) = _ends(a), _ends(b)
    return _span((a_low - b_high, a_high - b_low))


def _quotient(a: _Int, b: _Int) -> _Int:
    return _span(x // y for x in _ends(a) for y in _ends(b))


def _same(a: _Int) -> _Int:
    return a


def _before(a: _Int, b: _Int) -> _Truth:
    (a_low, a_high), (b_low, b_high) = _ends(a), _ends(b)
    return True if a_high < b_low else False if a_low >= b_high else None


def _number(a: _Int) -> Ball:
    return hull(*map(float, _ends(a)))


def _load(array: list[Ball], index: _Int) -> Ball:
    low, high = _ends(index)
    if not 0 <= low <= high < len(array):
        raise IndexError(f"index {low}..{high} of {len(array)}")
    found = array[low]
    for k in range(low + 1, high + 1):
        found = found.union(array[k])
    return found


def _put(array: list[Ball], index: _Int, value: Ball) -> None:
    low, high = _ends(index)
    for k in range(low, high + 1):
        array[k] = value if low == high else array[k].union(value)


def _joined(exits: list[tuple[Any, list[list[Ball]]]]) -> tuple[list[list[Ball]], Any]:
    """The outputs and what is returned, over all ways out of a function."""
    (statuses, outputs), *others = exits
    for other_statuses, other in others:
        statuses = _hull(statuses, other_statuses)
        outputs = [[x.union(y) for x, y in zip(a, b, strict=True)] for a, b in zip(outputs, other, strict=True)]
    return outputs, statuses


def _exponent(y: Ball, least: Fraction) -> _Int:
    low, high = float(y.lower()), float(y.upper())
    if not (math.isfinite(low) and math.isfinite(high)):  # a loose ball; the number is from 1/sqrt 2 to a double's largest
        return _Span(0, 1024)
    return _span(max(0, exponent_of(max(Fraction(end), least) / least)) for end in (low, high))


def _mantissa(y: Ball, least: Fraction) -> Ball:
    e = _exponent(y, least)
    return y / 2**e if isinstance(e, int) else hull(float(least), float(2 * least))


_HELPERS = (
    _compared, _less, _equal, _both, _not, _hull, _choose, _finite, _trunc, _added, _times, _less_by, _quotient, _same,
    _before, _number, _load, _put,
    _joined, _exponent, _mantissa,
)  # fmt: skip

# -------------------------------------------------------------------------------------------- the printer

_ROUNDED = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_FRAME = {"iadd": "_added", "imul": "_times", "ilt": "_before", "eq": "_equal", "and": "_both", "not": "_not", "real": "_number"}
_FRAME |= {"isub": "_less_by", "idiv": "_quotient", "tlt": "_before", "int": "_same"}
_SIGN = {"lt": "< 0", "le": "<= 0", "eq": "== 0", "ne": "!= 0"}
_MIRROR = {"lt": "> 0", "le": ">= 0", "eq": "== 0", "ne": "!= 0"}


class _Printer:
    """Program to Python source over balls. `constants` collects the numbers that the source names."""

    def __init__(self, program: Program, rounding: bool) -> None:
        self.program, self.rounding = program, rounding
        self.constants: dict[str, Ball] = {}
        self.compares: dict[str, Op] = {}  # these two: of the kernel or function being printed
        self.selects: dict[str, Select] = {}
        self.spans = False  # whether integers are compared there, which may be left undecided
        self.frame = False

    def table(self, name: str) -> str:
        return f"_T_{name}"

    def operand(self, value: Operand) -> str:
        if isinstance(value, Var):
            return value.name
        number = value.value
        if isinstance(number, Status):
            return self._constant(f"_S_{number.name}", frozenset({number}))
        if value.type in (BOOL, INT, TICK):
            return str(number)
        if number is None:
            return self._constant("_nan", arb.nan())
        return self._constant(f"_c{len(self.constants)}", ball(round_to(Fraction(number), self.program.scalar)))

    def _constant(self, name: str, value: Any) -> str:
        self.constants[name] = value
        return name

    def expression(self, value: Expression) -> str:
        match value:
            case Var() | Const():
                return self.operand(value)
            case Op(name=name, args=args):
                return self.operation(value, name, [self.operand(a) for a in args])
            case Select(condition=c, then=then, other=other):
                a, b = self.operand(then), self.operand(other)
                extreme = self.extreme(value)
                if extreme:
                    return f"{a}.{extreme}({b})"
                return (
                    f"_choose({self.operand(c)}, {a}, {b})" if self.frame or self.spans else f"{a} if {self.operand(c)} else {b}"
                )
            case IsFinite(arg=a):
                return f"_finite({self.operand(a)})"
            case Trunc(arg=a):
                return f"_trunc({self.operand(a)}, {self.most(a)})"
            case Load(array=array, index=index):
                name = self.table(array) if any(t.name == array for t in self.program.tables) else array
                return f"_load({name}, {self.operand(index)})"

    def most(self, value: Operand) -> int | None:
        """The whole part of a constant that a value is held below."""
        held = self.selects.get(value.name) if isinstance(value, Var) else None
        if held is None or self.extreme(held) != "min":
            return None
        bounds = [v.value for v in (held.then, held.other) if isinstance(v, Const)]
        return int(round_to(Fraction(bounds[0]), self.program.scalar)) if bounds else None  # type: ignore[arg-type]

    def extreme(self, value: Select) -> str:
        """ "max" or "min" where a Select is just that."""
        condition = value.condition
        test = self.compares.get(condition.name) if isinstance(condition, Var) else None
        if test is None or test.name not in ("lt", "le"):
            return ""
        if (value.other, value.then) == test.args:
            return "max"
        return "min" if (value.then, value.other) == test.args else ""

    def operation(self, op: Op, name: str, args: list[str]) -> str:
        if name in ("lt", "le", "eq", "ne") and not self.frame:
            a, b = (repr(v) for v in op.args)
            pair, sign, order = (f"{a}|{b}", _SIGN, args) if a <= b else (f"{b}|{a}", _MIRROR, args[::-1])
            return f"_compared(_assumed, {pair!r}, {', '.join(order)}) {sign[name]}"
        if name in ("lt", "le"):
            return f"_less({args[0]}, {args[1]}, {name == 'le'})"
        if name == "ne":
            return f"_not(_equal({args[0]}, {args[1]}))"
        if name == "or":
            return f"_not(_both(_not({args[0]}), _not({args[1]})))"
        if name in _FRAME:
            return f"{_FRAME[name]}({', '.join(args)})"
        if name in ("exponent", "mantissa"):
            return f"_{name}({args[0]}, _least_mantissa)"
        if name in ("neg", "fabs"):
            return f"-{args[0]}" if name == "neg" else f"abs({args[0]})"
        if name in _ROUNDED:
            exact = f"{args[0]} {_ROUNDED[name]} {args[1]}"
            tiny = " + _tiny" if name in ("mul", "div") else ""
            by_zero = name == "mul" and any(isinstance(a, Const) and a.value == 0 for a in op.args)  # exact
            return f"({exact}) * _one{tiny}" if self.rounding and not by_zero else exact
        exact = f"{args[0]} ** {args[1]}" if name == "pow" else f"{args[0]}.{name}()"
        if not self.rounding or name in ("floor", "ceil"):
            return exact
        return f"({exact}) * {'_one' if name == 'sqrt' else '_ulps'} + _tiny"

    def statements(self, body: Iterable[Statement], function: Function | None, indent: int = 1) -> list[str]:
        lines: list[str] = []
        pad = "    " * indent
        for statement in body:
            match statement:
                case Assign(var=var, value=value):
                    lines.append(f"{pad}{var.name} = {self.expression(value)}")
                case Call(results=results, kernel=kernel, args=args):
                    names = ", ".join(r.name for r in results)
                    lines.append(f"{pad}({names},) = _k_{kernel}({', '.join(map(self.operand, args))})")
                case Store(array=array, index=index, value=value):
                    lines.append(f"{pad}_put({array}, {self.operand(index)}, {self.operand(value)})")
                case For(index=index, count=count, body=inner, carries=carries):
                    lines += [f"{pad}{c.var.name} = {self.operand(c.initial)}" for c in carries]
                    lines.append(f"{pad}for {index.name} in range({count}):")
                    lines += self.statements(inner, function, indent + 1)
                    if carries:
                        targets, values = ", ".join(c.var.name for c in carries), ", ".join(self.operand(c.next) for c in carries)
                        lines.append(f"{pad}    {targets} = {values}")
                case Return(status=status, when=when, body=inner):
                    assert function is not None
                    lines += self._leave(function, status, when, inner, indent)
        return lines

    def _leave(
        self, function: Function, status: Expression | None, when: Operand | None, body: tuple[Statement, ...], indent: int
    ) -> list[str]:
        """A way out: taken for certain, perhaps, or not at all."""
        pad = "    " * indent
        arrays = ", ".join(f"list({p.name})" for p in function.outputs)
        way_out = f"({self.expression(status) if status is not None else 'frozenset()'}, [{arrays}])"
        if when is None:
            return [f"{pad}_exits.append({way_out})", f"{pad}return _joined(_exits)"]
        kept = "".join(f"{p.name}, " for p in function.outputs)
        return [
            f"{pad}if {self.operand(when)} is not False:",
            f"{pad}    _kept = [{arrays}]",
            *self.statements(body, function, indent + 1),
            f"{pad}    _exits.append({way_out})",
            f"{pad}    if {self.operand(when)}:",
            f"{pad}        return _joined(_exits)",
            f"{pad}    ({kept}) = _kept",
        ]

    def kernel(self, kernel: Kernel) -> list[str]:
        self.frame = False
        self.spans = any(isinstance(a.value, Op) and a.value.name in ("ilt", "tlt") for a in kernel.body)
        values = {a.var.name: a.value for a in kernel.body}
        self.compares = {name: v for name, v in values.items() if isinstance(v, Op) and v.name in _SIGN}
        self.selects = {name: v for name, v in values.items() if isinstance(v, Select)}
        extremes = {v.condition for v in values.values() if isinstance(v, Select) and self.extreme(v)}
        used = {o for v in values.values() if not (isinstance(v, Select) and self.extreme(v)) for o in operands(v)}
        used |= {o for v in values.values() if isinstance(v, Select) for o in (v.then, v.other)} | set(kernel.outputs)
        body = [a for a in kernel.body if not (a.var in extremes and a.var not in used)]
        inputs = ", ".join(v.name for v in kernel.inputs)
        outputs = "".join(f"{self.operand(o)}, " for o in kernel.outputs)
        return [f"def _k_{kernel.name}_once(_assumed, {inputs}):", *self.statements(body, None), f"    return ({outputs})"]

    def function(self, function: Function) -> list[str]:
        self.frame = True
        self.compares = {
            a.var.name: a.value for a in _assigns(function.body) if isinstance(a.value, Op) and a.value.name in ("lt", "le")
        }
        self.selects = {a.var.name: a.value for a in _assigns(function.body) if isinstance(a.value, Select)}
        zero = self._constant("_zero", arb(0))
        inputs = ", ".join(p.name for p in function.inputs)
        lines = [f"def {function.name}({inputs}):", "    _exits = []"]
        lines += [f"    {p.name} = [{zero}] * {p.length}" for p in function.outputs if not p.inout]
        lines += [f"    {p.name} = list({p.name})" for p in function.outputs if p.inout]
        return [*lines, *self.statements(function.body, function)]


def _assigns(body: Iterable[Statement]) -> Iterable[Assign]:
    for statement in body:
        if isinstance(statement, Assign):
            yield statement
        elif isinstance(statement, For | Return):
            yield from _assigns(statement.body)
