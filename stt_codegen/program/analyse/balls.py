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

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from stt_codegen.program.analyse.ball_arithmetic import HELPERS, Ball, Undecided, _hull, _joined, ball
from stt_codegen.program.nodes import (
    Assign,
    Call,
    Carry,
    Const,
    Expression,
    For,
    Function,
    Kernel,
    Op,
    Operand,
    Program,
    Return,
    Select,
    Statement,
    Status,
    Var,
    operands,
)
from stt_codegen.program.number import FORMATS, round_to
from stt_codegen.program.operations import BOOL, INT, LIBRARY_ULPS, OPERATIONS, TICK
from stt_codegen.program.targets import INDENT
from stt_codegen.program.targets.python import PythonPrinter

OUTCOMES = (-1, 0, 1)  # of a comparison: less, equal, greater


class Enclosure:
    """The kernels and functions of one program as Python callables over balls."""

    def __init__(self, program: Program, rounding: bool) -> None:
        self.program = program
        form = FORMATS[program.scalar]
        ulps = form.roundoff * 2 * LIBRARY_ULPS
        printer = _Printer(program, rounding)
        self._given: dict[str, tuple[Ball, ...]] = {}
        names: dict[str, Any] = {f.__name__: f for f in HELPERS}
        names |= {"_one": arb(1, _up(form.roundoff)), "_ulps": arb(1, _up(ulps))}
        names |= {"_least_mantissa": form.least_mantissa}
        names |= {"_tiny": arb(0, _up(form.tiny) * 2 * LIBRARY_ULPS)}
        names |= {printer.table_name(t.name): [ball(round_to(v, program.scalar)) for v in t.values] for t in program.tables}
        names |= {f"_k_{k.name}": self._split(k.name) for k in program.kernels}
        parts = [*map(printer.kernel, program.kernels), *map(printer.function, program.functions)]
        names |= printer.constants
        self._names = names
        exec(compile("\n".join(line for part in parts for line in part), f"<{program.prefix} in balls>", "exec"), names)

    def kernel(self, name: str, *inputs: Ball) -> tuple[Ball, ...]:
        """Enclosures of a kernel's outputs."""
        outputs: tuple[Ball, ...] = self._names[f"_k_{name}"](*inputs)
        return outputs

    def run(self, function: str, **inputs: Ball | Sequence[Ball]) -> tuple[dict[str, list[Ball]], Any]:
        """The output arrays of a function; and every status that it may return (none when it returns none), or the ball of
        the real that it returns."""
        outputs, statuses = self._names[function](**inputs)
        names = [p.name for p in self.program.function(function).outputs]
        return dict(zip(names, outputs, strict=True)), statuses

    def run_given(
        self, function: str, kernel: str, results: Iterable[tuple[Ball, ...]], **inputs: Ball | Sequence[Ball]
    ) -> tuple[dict[str, list[Ball]], Any]:
        """As `run`, for a kernel that gives one of these results and is not run itself."""
        exits = []
        try:
            for self._given[kernel] in results:
                exits.append(self._names[function](**inputs)[::-1])
        finally:
            self._given.clear()
        outputs, statuses = _joined(exits)
        names = [p.name for p in self.program.function(function).outputs]
        return dict(zip(names, outputs, strict=True)), statuses

    def _split(self, name: str) -> Callable[..., tuple[Ball, ...]]:
        """A kernel that is run for every outcome of the comparisons that its inputs leave undecided."""

        def run(*inputs: Ball) -> tuple[Ball, ...]:
            return self._given[name] if name in self._given else split(inputs, {})

        def split(inputs: tuple[Ball, ...], assumed: dict[str, int]) -> tuple[Ball, ...]:
            try:
                outputs: tuple[Ball, ...] = self._names[f"_k_{name}_once"](assumed, *inputs)
            except Undecided as open_:
                first, *others = (split(inputs, {**assumed, open_.pair: outcome}) for outcome in OUTCOMES)
                for other in others:
                    first = tuple(map(_hull, first, other))
                return first
            return outputs

        return run


def _up(value: Fraction) -> float:
    """A double that is not below a positive fraction."""
    return float(value) * (1 + 2**-50) + 5e-324


# ---------------------------------------------------------------------------------------- the printer

HALF = 0.5  # a unit in the last place, of a correctly rounded operation
_SIGN = {"lt": "< 0", "le": "<= 0", "eq": "== 0", "ne": "!= 0"}
_MIRROR = {"lt": "> 0", "le": ">= 0", "eq": "== 0", "ne": "!= 0"}


class _Printer(PythonPrinter):
    """Program to Python source over balls: statements as Python has them, operations by the `ball` of their rows. `constants`
    collects the numbers that the source names."""

    def __init__(self, program: Program, rounding: bool) -> None:
        super().__init__(program)
        self.rounding = rounding
        self.constants: dict[str, Ball] = {}
        self.compares: dict[str, Op] = {}  # these two: of the kernel or function being printed
        self.selects: dict[str, Select] = {}
        self.spans = False  # whether integers are compared there, which may be left undecided
        self.frame = False

    def table_name(self, name: str) -> str:
        return f"_T_{name}"

    def literal(self, constant: Const) -> str:
        number = constant.value
        if isinstance(number, Status):
            return self._constant(f"_S_{number.name}", frozenset({number}))
        if constant.type in (BOOL, INT, TICK):
            return str(number)
        if number is None:
            return self._constant("_nan", arb.nan())
        return self._constant(f"_c{len(self.constants)}", ball(round_to(Fraction(number), self.program.scalar)))

    def _constant(self, name: str, value: Any) -> str:
        self.constants[name] = value
        return name

    def array(self, name: str) -> str:
        return self.table_name(name) if self.is_table(name) else name

    def format_select(self, select: Select, condition: str, then: str, other: str) -> str:
        extreme = self.extreme(select)
        if extreme:
            return f"{then}.{extreme}({other})"
        undecided = self.frame or self.spans
        return f"_choose({condition}, {then}, {other})" if undecided else f"{then} if {condition} else {other}"

    def format_finite(self, value: str) -> str:
        return f"_finite({value})"

    def format_trunc(self, operand: Operand, value: str) -> str:
        return f"_trunc({value}, {self.most(operand)})"

    def format_load(self, array: str, index: str) -> str:
        return f"_load({array}, {index})"

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

    def operation(self, op: Op, name: str, args: Sequence[str]) -> str:
        row = OPERATIONS[name]
        if name in _SIGN and not self.frame:
            a, b = (repr(v) for v in op.args)
            pair, sign, order = (f"{a}|{b}", _SIGN, args) if a <= b else (f"{b}|{a}", _MIRROR, args[::-1])
            return f"_compared(_assumed, {pair!r}, {', '.join(order)}) {sign[name]}"
        exact = row.ball.format(*args)
        by_zero = name == "mul" and any(isinstance(a, Const) and a.value == 0 for a in op.args)  # exact
        if not self.rounding or not row.ulps or by_zero:
            return exact
        return f"({exact}) * {'_one' if row.ulps == HALF else '_ulps'}{' + _tiny' if row.underflows else ''}"

    def format_carried(self, carries: Sequence[Carry]) -> list[str]:
        if not carries:
            return []
        return [f"{', '.join(c.var.name for c in carries)} = {', '.join(self.expression(c.next) for c in carries)}"]

    def format_store(self, array: str, index: str, value: str) -> str:
        return f"_put({array}, {index}, {value})"

    def format_if(self, condition: str) -> str:
        return f"if {condition} is not False:"

    def format_call(self, call: Call) -> list[str]:
        names = ", ".join(r.name for r in call.results)
        return [f"({names},) = _k_{call.kernel}({', '.join(map(self.expression, call.args))})"]

    def format_leave(self, status: Expression | None) -> list[str]:
        way_out = f"({self.expression(status) if status is not None else 'frozenset()'}, [{self._copies()}])"
        return [f"_exits.append({way_out})", "return _joined(_exits)"]

    def _copies(self) -> str:
        assert self.inside is not None
        return ", ".join(f"list({p.name})" for p in self.inside.outputs)

    def leave(self, statement: Return) -> list[str]:
        """A way out: taken for certain, perhaps, or not at all."""
        noted, out = self.format_leave(statement.status)
        if statement.when is None:
            return [noted, out]
        assert self.inside is not None
        kept, condition = "".join(f"{p.name}, " for p in self.inside.outputs), self.expression(statement.when)
        inner = [f"_kept = [{self._copies()}]", *(v.removeprefix(INDENT) for v in self.statements(statement.body)), noted]
        inner += [f"if {condition}:", INDENT + out, f"({kept}) = _kept"]
        return [self.format_if(condition), *(INDENT + line for line in inner)]

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
        outputs = "".join(f"{self.expression(o)}, " for o in kernel.outputs)
        return [f"def _k_{kernel.name}_once(_assumed, {inputs}):", *self.statements(body), f"    return ({outputs})"]

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
        self.inside = function
        return [*lines, *self.statements(function.body)]


def _assigns(body: Iterable[Statement]) -> Iterable[Assign]:
    for statement in body:
        if isinstance(statement, Assign):
            yield statement
        elif isinstance(statement, For | Return):
            yield from _assigns(statement.body)
