"""A reader that proves of a program of integers: every integer fits 32 bits, every index its table, every shift its word.

Every variable gets a span that holds for all inputs: operations by the rules of their rows (`Operation.ball`), calls with the
spans of their arguments, loops in one turn for all. Three facts are more than spans:

- in a Select on a < b the chosen operand is known to be on its side, as is what is computed of it in one step;
- a shifted left by leading(a) lies in [2^30, 2^31), and what is never above a, shifted as far, below 2^31;
- a kernel that is given an index of tables is read index by index.

`pipeline.within_32_bits` calls it for every program of integers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from stt_codegen.program.analyse import ball_arithmetic
from stt_codegen.program.nodes import (
    Assign,
    Call,
    Carry,
    Const,
    Expression,
    For,
    Kernel,
    Load,
    Op,
    Operand,
    Program,
    Return,
    Select,
    Statement,
    Store,
    Var,
)
from stt_codegen.program.operations import INT, OPERATIONS, TICK

SMALLEST, LARGEST = -(2**31), 2**31 - 1  # of 32 bits with a sign
MAX_PASSES = 4  # over a loop's body, within which the spans of what it carries must stop growing
_RULES: dict[str, Callable[..., Any]] = {f.__name__: f for f in ball_arithmetic.HELPERS}


class OutOfRange(Exception):
    """A value that its type may not hold; the text says which."""


@dataclass(frozen=True)
class Span:
    """All whole numbers from low to high."""

    low: int
    high: int

    def is_within(self, low: int, end: int) -> bool:
        """Whether low <= every number < end."""
        return low <= self.low and self.high < end


ALL_INTEGERS, ALL_TICKS = Span(SMALLEST, LARGEST), Span(0, 2**32 - 1)
Spans = dict[str, Span]


@dataclass
class _Scope:
    """What is known in one body: the spans of its integers, and the expression that each variable was assigned."""

    spans: Spans
    definitions: dict[str, Expression] = field(default_factory=dict)

    def definition_of(self, operand: Operand) -> Expression | None:
        """Return the expression that a variable was assigned; None for a constant or an input."""
        return self.definitions.get(operand.name) if isinstance(operand, Var) else None


def ranges(program: Program, function: str) -> dict[str, Span]:
    """Return the spans of the integers of a public function by name, its outputs' too, for all inputs.

    Raises `OutOfRange` where one may leave its type.
    """
    f = program.function(function)
    inputs = {p.name: ALL_TICKS if p.type is TICK else ALL_INTEGERS for p in f.inputs}
    reader = _RangeReader(program, inputs, {p.name: p.length or 0 for p in f.params})
    scope = _Scope({p.name: inputs[p.name] for p in f.inputs if p.length is None})
    reader.read_statements(f.body, scope)
    return scope.spans | reader.stored


class _RangeReader:
    """Reads the statements of one public function. stored: the span of what each output array is given."""

    def __init__(self, program: Program, inputs: Spans, lengths: Mapping[str, int]) -> None:
        self.program, self.inputs, self.stored = program, inputs, dict[str, Span]()
        self.lengths = {**lengths, **{t.name: len(t.values) for t in program.tables}}

    def read_statements(self, body: Iterable[Statement], scope: _Scope) -> None:
        """Add the spans of what these statements assign to the scope."""
        for statement in body:
            match statement:
                case Assign(var=var, value=value):
                    self.read_assignment(var, value, scope)
                case Call(results=results, kernel=name, args=args):
                    self.read_call(results, name, args, scope)
                case Store(array=array, index=index, value=value):
                    self.require_index_within(array, index, scope)
                    self.stored[array] = _hull(self.stored.get(array), self.operand_span(value, scope))
                case For(index=index, count=count, body=inner, carries=carries):
                    scope.spans[index.name] = Span(0, count - 1)
                    self.read_loop(inner, [c for c in carries if c.var.type is INT], scope)
                case Return(body=inner):
                    self.read_statements(inner, scope)

    def read_loop(self, body: Sequence[Statement], carries: Sequence[Carry], scope: _Scope) -> None:
        """Find spans of carried values that a turn of the loop does not leave; they then hold in every turn."""
        for carry in carries:
            scope.spans[carry.var.name] = self.operand_span(carry.initial, scope)
        for _ in range(MAX_PASSES):
            before = dict(scope.spans)
            self.read_statements(body, scope)
            for carry in carries:
                scope.spans[carry.var.name] = _hull(before[carry.var.name], self.operand_span(carry.next, scope))
            if all(scope.spans[c.var.name] == before[c.var.name] for c in carries):
                return
        raise OutOfRange(f"{carries[0].var.name}: is carried through a loop, and no span was found that it stays in")

    def read_call(self, results: Sequence[Var], name: str, args: Sequence[Operand], scope: _Scope) -> None:
        """Add the spans of a kernel's results, over all table entries that its arguments may select."""
        kernel = self.program.kernel(name)
        inputs = {
            v.name: self.operand_span(arg, scope) for v, arg in zip(kernel.inputs, args, strict=True) if v.type in (INT, TICK)
        }
        hulls: list[Span | None] = [None] * len(results)
        for spans in self.inputs_by_row(kernel, inputs):
            kernel_scope = _Scope(spans)
            self.read_statements(kernel.body, kernel_scope)
            outputs = [self.operand_span(o, kernel_scope) if o.type is INT else None for o in kernel.outputs]
            hulls = [hull if span is None else _hull(hull, span) for hull, span in zip(hulls, outputs, strict=True)]
        scope.spans |= {var.name: span for var, span in zip(results, hulls, strict=True) if span is not None}

    def inputs_by_row(self, kernel: Kernel, inputs: Spans) -> Iterator[Spans]:
        """Yield the spans of a kernel's inputs, once for each value of the input that indexes its tables, if there is one."""
        indices = {a.value.index.name for a in kernel.body if isinstance(a.value, Load) and isinstance(a.value.index, Var)}
        row_inputs = indices & {*inputs}
        if len(row_inputs) != 1:
            yield dict(inputs)
            return
        (name,) = row_inputs
        for row in range(inputs[name].low, inputs[name].high + 1):
            yield inputs | {name: Span(row, row)}

    def read_assignment(self, var: Var, value: Expression, scope: _Scope) -> None:
        """Add the span of an integer variable. Raises `OutOfRange` where it may leave its type."""
        scope.definitions[var.name] = value
        if var.type not in (INT, TICK):
            return
        try:
            span = self.expression_span(value, scope)
        except OutOfRange as problem:
            raise OutOfRange(f"{var.name}: {problem}") from None
        allowed = ALL_TICKS if var.type is TICK else ALL_INTEGERS
        if not allowed.low <= span.low <= span.high <= allowed.high:
            raise OutOfRange(f"{var.name} may be {span.low} to {span.high}, beyond 32 bits")
        scope.spans[var.name] = span

    def expression_span(self, value: Expression, scope: _Scope) -> Span:
        """Return the span of an expression of integers."""
        match value:
            case Var() | Const():
                return self.operand_span(value, scope)
            case Load(array=array, index=index):
                self.require_index_within(array, index, scope)
                return self.entries_span(array, index, scope)
            case Select(condition=condition, then=then, otherwise=otherwise):
                then_span = self.chosen_span(condition, True, then, scope)
                return _hull(then_span, self.chosen_span(condition, False, otherwise, scope))
            case Op():
                return self.operation_span(value, scope)
        raise OutOfRange(f"{type(value).__name__} has no rule here")

    def operation_span(self, op: Op, scope: _Scope) -> Span:
        """Return the span of an operation, by its rule over balls. Raises `OutOfRange` where an argument is not allowed."""
        args = [self.operand_span(a, scope) for a in op.args]
        _require_allowed_arguments(op.name, args)
        if op.name == "ishl":
            places = scope.definition_of(op.args[1])
            if isinstance(places, Op) and places.name == "leading":
                if places.args[0] == op.args[0]:
                    return Span(2**30, LARGEST)
                if self.is_at_most(op.args[0], places.args[0], scope):
                    return Span(0, LARGEST)
        rule, _, rest = OPERATIONS[op.name].ball.partition("(")
        if rule not in _RULES or not rest.startswith("{0}"):
            raise OutOfRange(f"{op.name} has no rule here")
        return Span(*ball_arithmetic.ends(_RULES[rule](*(ball_arithmetic.span((a.low, a.high)) for a in args))))

    def is_at_most(self, value: Operand, bound: Operand, scope: _Scope) -> bool:
        """Whether a value is at most `bound` whatever the input: it is the bound itself, or a minimum with it."""
        if value == bound:
            return True
        match scope.definition_of(value):
            case Select(condition=test, then=then, otherwise=otherwise) if scope.definition_of(test) == Op(
                "ilt", (then, otherwise)
            ):
                return self.is_at_most(then, bound, scope) or self.is_at_most(otherwise, bound, scope)
        return False

    def chosen_span(self, condition: Operand, holds: bool, chosen: Operand, scope: _Scope) -> Span:
        """Return the span of what a Select chooses where its comparison of integers holds, or does not hold."""
        test = scope.definition_of(condition)
        if not isinstance(test, Op) or test.name not in ("ilt", "tlt"):
            return self.operand_span(chosen, scope)
        a, b = (self.operand_span(v, scope) for v in test.args)
        narrowed = _spans_where_less(a, b) if holds else _spans_where_not_less(a, b)
        if narrowed is None:  # the comparison never comes out so
            return self.operand_span(chosen, scope)
        spans = scope.spans | {v.name: s for v, s in zip(test.args, narrowed, strict=True) if isinstance(v, Var)}
        narrowed_scope = _Scope(spans, scope.definitions)
        definition = None if chosen in test.args else scope.definition_of(chosen)
        if isinstance(definition, Op) and any(v in test.args for v in definition.args if isinstance(v, Var)):
            return self.operation_span(definition, narrowed_scope)
        return self.operand_span(chosen, narrowed_scope)

    def operand_span(self, operand: Operand, scope: _Scope) -> Span:
        """Return the span of a variable, or of a constant."""
        if isinstance(operand, Const):
            return Span(int(operand.value), int(operand.value))  # type: ignore[arg-type]
        return scope.spans[operand.name]

    def entries_span(self, array: str, index: Operand, scope: _Scope) -> Span:
        """Return the span of the entries of a table or of an input array that an index may select."""
        table = next((t for t in self.program.tables if t.name == array), None)
        if table is None:
            return self.inputs[array]
        rows = self.operand_span(index, scope)
        values = table.values[rows.low : rows.high + 1]
        return Span(int(min(values)), int(max(values)))

    def require_index_within(self, array: str, index: Operand, scope: _Scope) -> None:
        """Raise `OutOfRange` where an index may be outside of its table or array."""
        indices = self.operand_span(index, scope)
        if not 0 <= indices.low <= indices.high < self.lengths[array]:
            raise OutOfRange(f"{array}[{indices.low} to {indices.high}] of {self.lengths[array]}")


def _require_allowed_arguments(name: str, args: Sequence[Span]) -> None:
    """Raise `OutOfRange` where the arguments of an operation are not of the size that it is for."""
    if name in ("ishr", "ishl") and not 0 <= args[1].low <= args[1].high <= 31:
        raise OutOfRange(f"{name} by {args[1].low} to {args[1].high} places")
    if name == "short" and not args[0].is_within(-(2**15), 2**15):
        raise OutOfRange(f"{args[0].low} to {args[0].high} are not of 16 bits")
    if name == "low_bits" and (args[1].low != args[1].high or args[1].low & (args[1].low + 1)):
        raise OutOfRange(f"low: {args[1].low} to {args[1].high} is no mask")
    if name == "high_product" and not args[1].is_within(0, 2**16):
        raise OutOfRange(f"upper: its second factor may be {args[1].low} to {args[1].high}, not within 16 bits")
    if name in ("leading", "ishl") and args[0].low < (name == "leading"):
        raise OutOfRange(f"{name} of {args[0].low} to {args[0].high}")
    if name == "idiv" and not (args[0].low >= 0 < args[1].low):
        raise OutOfRange("idiv of a number that may be negative, or by one that may not be positive")
    if name == "product" and not (args[0].is_within(-(2**15), 2**15) and args[1].is_within(0, 2**16)):
        raise OutOfRange(f"product: of {args[0].low} to {args[0].high} and {args[1].low} to {args[1].high}, not of 16 bits")


def _hull(a: Span | None, b: Span) -> Span:
    """Return the smallest span that holds both."""
    return b if a is None else Span(min(a.low, b.low), max(a.high, b.high))


def _spans_where_less(a: Span, b: Span) -> tuple[Span, Span] | None:
    """Return what a and b may be where a < b; None where that never holds."""
    narrowed = Span(a.low, min(a.high, b.high - 1)), Span(max(b.low, a.low + 1), b.high)
    return narrowed if all(s.low <= s.high for s in narrowed) else None


def _spans_where_not_less(a: Span, b: Span) -> tuple[Span, Span] | None:
    """Return what a and b may be where b <= a; None where that never holds."""
    narrowed = Span(max(a.low, b.low), a.high), Span(b.low, min(b.high, a.high))
    return narrowed if all(s.low <= s.high for s in narrowed) else None
