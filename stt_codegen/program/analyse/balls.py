"""A reader that runs a Program in ball arithmetic (Arb, through python-flint): every output encloses all values that the function
gives for inputs within these balls.

With `rounding`, the balls also hold every number that the emitted arithmetic may give: half a unit in the last place for
+ - * / and sqrt, `LIBRARY_ULPS` units for every other function of the C library, and underflow. Constants and tables are
those that are printed. The emitted Python computes the same in double, so it is enclosed too. Overflow is not looked for:
the emitted functions keep every argument of exp below the one where it overflows.

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

from stt_codegen.program.analyse.ball_arithmetic import HELPERS, Ball, Undecided, _join_exits, _union, ball
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
    """The kernels and functions of one program as Python callables over balls. rounding: whether the balls also hold every
    number that the emitted arithmetic may give."""

    def __init__(self, program: Program, rounding: bool) -> None:
        self.program = program
        form = FORMATS[program.scalar]
        ulps = form.roundoff * 2 * LIBRARY_ULPS
        printer = _Printer(program, rounding)
        self._assumed_results: dict[str, tuple[Ball, ...]] = {}  # of kernels that are not run
        names: dict[str, Any] = {f.__name__: f for f in HELPERS}
        names |= {"_half_ulp": arb(1, _up(form.roundoff)), "_library_ulps": arb(1, _up(ulps))}
        names |= {"_smallest_mantissa": form.smallest_mantissa}
        names |= {"_tiny": arb(0, _up(form.tiny) * 2 * LIBRARY_ULPS)}
        names |= {printer.table_name(t.name): [ball(round_to(v, program.scalar)) for v in t.values] for t in program.tables}
        names |= {f"_k_{k.name}": self._over_outcomes(k.name) for k in program.kernels}
        parts = [*map(printer.kernel, program.kernels), *map(printer.function, program.functions)]
        names |= printer.constants
        self._names = names
        exec(compile("\n".join(line for part in parts for line in part), f"<{program.prefix} in balls>", "exec"), names)

    def kernel(self, name: str, *inputs: Ball) -> tuple[Ball, ...]:
        """Return enclosures of a kernel's outputs."""
        outputs: tuple[Ball, ...] = self._names[f"_k_{name}"](*inputs)
        return outputs

    def run(self, function: str, **inputs: Ball | Sequence[Ball]) -> tuple[dict[str, list[Ball]], Any]:
        """Return the output arrays of a function by name; and every status that it may return (none when it returns none), or
        the ball of the real that it returns."""
        outputs, result = self._names[function](**inputs)
        names = [p.name for p in self.program.function(function).outputs]
        return dict(zip(names, outputs, strict=True)), result

    def run_assuming(
        self, function: str, kernel: str, results: Iterable[tuple[Ball, ...]], **inputs: Ball | Sequence[Ball]
    ) -> tuple[dict[str, list[Ball]], Any]:
        """Return the same as `run`, where the kernel is not run but gives one of these results."""
        exits = []
        try:
            for self._assumed_results[kernel] in results:
                outputs, result = self._names[function](**inputs)
                exits.append((result, outputs))
        finally:
            self._assumed_results.clear()
        outputs, result = _join_exits(exits)
        names = [p.name for p in self.program.function(function).outputs]
        return dict(zip(names, outputs, strict=True)), result

    def _over_outcomes(self, name: str) -> Callable[..., tuple[Ball, ...]]:
        """Return a kernel that is run for every outcome of the comparisons that its inputs leave undecided."""

        def run(*inputs: Ball) -> tuple[Ball, ...]:
            return self._assumed_results[name] if name in self._assumed_results else run_with(inputs, {})

        def run_with(inputs: tuple[Ball, ...], assumed: dict[str, int]) -> tuple[Ball, ...]:
            try:
                outputs: tuple[Ball, ...] = self._names[f"_k_{name}_once"](assumed, *inputs)
            except Undecided as undecided:
                union, *later_outputs = (run_with(inputs, {**assumed, undecided.pair: outcome}) for outcome in OUTCOMES)
                for outputs in later_outputs:
                    union = tuple(map(_union, union, outputs))
                return union
            return outputs

        return run


def _up(value: Fraction) -> float:
    """Return a double that is not below a positive fraction."""
    return float(value) * (1 + 2**-50) + 5e-324


# ---------------------------------------------------------------------------------------- the printer

CORRECT_ROUNDING_ULPS = 0.5  # units in the last place, of a correctly rounded operation
_SIGN = {"lt": "< 0", "le": "<= 0", "eq": "== 0", "ne": "!= 0"}
_MIRROR = {"lt": "> 0", "le": ">= 0", "eq": "== 0", "ne": "!= 0"}


class _Printer(PythonPrinter):
    """Prints a Program as Python source over balls: statements as Python has them, operations by the `ball` of their rows.

    constants: numbers that the source names. comparisons, selects: of the kernel or function that is being printed, by the name
    of their result. compares_integers: whether integers are compared in it, which may be left undecided. in_function: whether a
    public function is being printed, not a kernel.
    """

    def __init__(self, program: Program, rounding: bool) -> None:
        super().__init__(program)
        self.rounding = rounding
        self.constants: dict[str, Ball] = {}
        self.comparisons: dict[str, Op] = {}
        self.selects: dict[str, Select] = {}
        self.compares_integers = False
        self.in_function = False

    def table_name(self, name: str) -> str:
        """Return the name of a table in the printed source."""
        return f"_T_{name}"

    def literal(self, constant: Const) -> str:
        """Return the name of a constant's ball, or an integer as it is."""
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

    def format_select(self, select: Select, condition: str, then: str, otherwise: str) -> str:
        method = self.min_or_max(select)
        if method:
            return f"{then}.{method}({otherwise})"
        undecided = self.in_function or self.compares_integers
        return f"_select({condition}, {then}, {otherwise})" if undecided else f"{then} if {condition} else {otherwise}"

    def format_finite(self, value: str) -> str:
        return f"_is_finite({value})"

    def format_trunc(self, operand: Operand, value: str) -> str:
        return f"_truncate({value}, {self.truncation_limit(operand)})"

    def format_load(self, array: str, index: str) -> str:
        return f"_load({array}, {index})"

    def truncation_limit(self, value: Operand) -> int | None:
        """Return the whole part of the constant that a value is a minimum with; None where it is no such minimum."""
        minimum = self.selects.get(value.name) if isinstance(value, Var) else None
        if minimum is None or self.min_or_max(minimum) != "min":
            return None
        bounds = [v.value for v in (minimum.then, minimum.otherwise) if isinstance(v, Const)]
        return int(round_to(Fraction(bounds[0]), self.program.scalar)) if bounds else None  # type: ignore[arg-type]

    def min_or_max(self, value: Select) -> str:
        """Return "max" or "min" where a Select is just that, else nothing."""
        condition = value.condition
        test = self.comparisons.get(condition.name) if isinstance(condition, Var) else None
        if test is None or test.name not in ("lt", "le"):
            return ""
        if (value.otherwise, value.then) == test.args:
            return "max"
        return "min" if (value.then, value.otherwise) == test.args else ""

    def operation(self, op: Op, name: str, args: Sequence[str]) -> str:
        """Return an operation over balls, with its rounding where that counts; in a kernel a comparison by `_compare`."""
        row = OPERATIONS[name]
        if name in _SIGN and not self.in_function:
            a, b = (repr(v) for v in op.args)
            pair, sign, order = (f"{a}|{b}", _SIGN, args) if a <= b else (f"{b}|{a}", _MIRROR, args[::-1])
            return f"_compare(_assumed, {pair!r}, {', '.join(order)}) {sign[name]}"
        exact = row.ball.format(*args)
        by_zero = name == "mul" and any(isinstance(a, Const) and a.value == 0 for a in op.args)  # exact
        if not self.rounding or not row.ulps or by_zero:
            return exact
        rounding = "_half_ulp" if row.ulps == CORRECT_ROUNDING_ULPS else "_library_ulps"
        return f"({exact}) * {rounding}{' + _tiny' if row.underflows else ''}"

    def format_carried(self, carries: Sequence[Carry]) -> list[str]:
        if not carries:
            return []
        return [f"{', '.join(c.var.name for c in carries)} = {', '.join(self.expression(c.next) for c in carries)}"]

    def format_store(self, array: str, index: str, value: str) -> str:
        return f"_store({array}, {index}, {value})"

    def format_if(self, condition: str) -> str:
        return f"if {condition} is not False:"

    def format_call(self, call: Call) -> list[str]:
        names = ", ".join(r.name for r in call.results)
        return [f"({names},) = _k_{call.kernel}({', '.join(map(self.expression, call.args))})"]

    def format_leave(self, status: Expression | None) -> list[str]:
        exit_ = f"({self.expression(status) if status is not None else 'frozenset()'}, [{self._copies()}])"
        return [f"_exits.append({exit_})", "return _join_exits(_exits)"]

    def _copies(self) -> str:
        assert self.inside is not None
        return ", ".join(f"list({p.name})" for p in self.inside.outputs)

    def leave(self, statement: Return) -> list[str]:
        """Return the lines of a way out, which is taken for certain, perhaps, or not at all.

        Where it is taken perhaps, its outputs are noted, and the function goes on with those from before it.
        """
        note_exit, leave = self.format_leave(statement.status)
        if statement.when is None:
            return [note_exit, leave]
        assert self.inside is not None
        outputs, condition = "".join(f"{p.name}, " for p in self.inside.outputs), self.expression(statement.when)
        inner = [f"_before = [{self._copies()}]", *(v.removeprefix(INDENT) for v in self.statements(statement.body)), note_exit]
        inner += [f"if {condition}:", INDENT + leave, f"({outputs}) = _before"]
        return [self.format_if(condition), *(INDENT + line for line in inner)]

    def kernel(self, kernel: Kernel) -> list[str]:
        """Return the Python of a kernel under assumptions; a comparison that only a minimum or maximum reads is left out."""
        self.in_function = False
        self.compares_integers = any(isinstance(a.value, Op) and a.value.name in ("ilt", "tlt") for a in kernel.body)
        values = {a.var.name: a.value for a in kernel.body}
        self.comparisons = {name: v for name, v in values.items() if isinstance(v, Op) and v.name in _SIGN}
        self.selects = {name: v for name, v in values.items() if isinstance(v, Select)}
        min_max_tests = {v.condition for v in values.values() if isinstance(v, Select) and self.min_or_max(v)}
        used = {o for v in values.values() if not (isinstance(v, Select) and self.min_or_max(v)) for o in operands(v)}
        used |= {o for v in values.values() if isinstance(v, Select) for o in (v.then, v.otherwise)} | set(kernel.outputs)
        body = [a for a in kernel.body if not (a.var in min_max_tests and a.var not in used)]
        inputs = ", ".join(v.name for v in kernel.inputs)
        outputs = "".join(f"{self.expression(o)}, " for o in kernel.outputs)
        return [f"def _k_{kernel.name}_once(_assumed, {inputs}):", *self.statements(body), f"    return ({outputs})"]

    def function(self, function: Function) -> list[str]:
        """Return the Python of a public function, which collects its ways out in `_exits`."""
        self.in_function = True
        self.comparisons = {
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
    """Yield the assignments of a body, those within loops and ways out too."""
    for statement in body:
        if isinstance(statement, Assign):
            yield statement
        elif isinstance(statement, For | Return):
            yield from _assigns(statement.body)
