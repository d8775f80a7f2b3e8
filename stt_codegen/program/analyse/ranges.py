"""A reader that proves that no integer of a program of integers leaves 32 bits, no index its table, no shift its word.

Every variable gets a span that holds for all inputs: operations by the rules of their rows (`Operation.ball`), calls with the
spans of their arguments, loops in one turn for all. Three facts are more than spans:

- in a Select on a < b the chosen operand is known to be on its side, as is what is computed of it in one step;
- a moved up by leading(a) places lies in [2^30, 2^31), and what is never above a, moved up as far, below 2^31;
- a kernel that is given an index of tables is read index by index.
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

LEAST, MOST = -(2**31), 2**31 - 1
TURNS = 4  # in which what a loop carries must have found its span
_RULES: dict[str, Callable[..., Any]] = {f.__name__: f for f in ball_arithmetic.HELPERS}


class OutOfRange(Exception):
    """A value that may not be what its type holds; the text says which."""


@dataclass(frozen=True)
class Span:
    """All whole numbers from low to high."""

    low: int
    high: int

    def within(self, low: int, end: int) -> bool:
        return low <= self.low and self.high < end


FULL, COUNT = Span(LEAST, MOST), Span(0, 2**32 - 1)
Known = dict[str, Span]


@dataclass
class _Scope:
    """What is known in one body: spans of its integers, and what every variable was made of."""

    known: Known
    made: dict[str, Expression] = field(default_factory=dict)


def ranges(program: Program, function: str) -> dict[str, Span]:
    """The spans of the integers of a public function, its outputs' too, for all inputs. Raises `OutOfRange` where one may leave
    its type."""
    f = program.function(function)
    inputs = {p.name: COUNT if p.type is TICK else FULL for p in f.inputs}
    reader = _Reader(program, inputs, {p.name: p.length or 0 for p in f.params})
    scope = _Scope({p.name: inputs[p.name] for p in f.inputs if p.length is None})
    reader.statements(f.body, scope)
    return scope.known | reader.stored


class _Reader:
    def __init__(self, program: Program, inputs: Known, lengths: Mapping[str, int]) -> None:
        self.program, self.inputs, self.stored = program, inputs, dict[str, Span]()
        self.lengths = {**lengths, **{t.name: len(t.values) for t in program.tables}}

    def statements(self, body: Iterable[Statement], scope: _Scope) -> None:
        for statement in body:
            match statement:
                case Assign(var=var, value=value):
                    self.assign(var, value, scope)
                case Call(results=results, kernel=name, args=args):
                    self.call(results, name, args, scope)
                case Store(array=array, index=index, value=value):
                    self.within(array, index, scope)
                    self.stored[array] = _hull(self.stored.get(array), self.span(value, scope))
                case For(index=index, count=count, body=inner, carries=carries):
                    scope.known[index.name] = Span(0, count - 1)
                    self.loop(inner, [c for c in carries if c.var.type is INT], scope)
                case Return(body=inner):
                    self.statements(inner, scope)

    def loop(self, body: Sequence[Statement], carries: Sequence[Carry], scope: _Scope) -> None:
        """One turn for all: what is carried is within a span that a turn does not leave."""
        for carry in carries:
            scope.known[carry.var.name] = self.span(carry.initial, scope)
        for _ in range(TURNS):
            before = dict(scope.known)
            self.statements(body, scope)
            for carry in carries:
                scope.known[carry.var.name] = _hull(before[carry.var.name], self.span(carry.next, scope))
            if all(scope.known[c.var.name] == before[c.var.name] for c in carries):
                return
        raise OutOfRange(f"{carries[0].var.name}: is carried through a loop, and no span was found that it stays in")

    def call(self, results: Sequence[Var], name: str, args: Sequence[Operand], scope: _Scope) -> None:
        kernel = self.program.kernel(name)
        given = {v.name: self.span(arg, scope) for v, arg in zip(kernel.inputs, args, strict=True) if v.type in (INT, TICK)}
        found: list[Span | None] = [None] * len(results)
        for known in self.by_row(kernel, given):
            own = _Scope(known)
            self.statements(kernel.body, own)
            ends = [self.span(o, own) if o.type is INT else None for o in kernel.outputs]
            found = [span if span is None else _hull(before, span) for before, span in zip(found, ends, strict=True)]
        scope.known |= {var.name: span for var, span in zip(results, found, strict=True) if span is not None}

    def by_row(self, kernel: Kernel, given: Known) -> Iterator[Known]:
        """What is known of a kernel's inputs: row by row, where one of them says which entry of tables it goes by."""
        indices = {a.value.index.name for a in kernel.body if isinstance(a.value, Load) and isinstance(a.value.index, Var)}
        rows = indices & {*given}
        if len(rows) != 1:
            yield dict(given)
            return
        (name,) = rows
        for row in range(given[name].low, given[name].high + 1):
            yield given | {name: Span(row, row)}

    def assign(self, var: Var, value: Expression, scope: _Scope) -> None:
        scope.made[var.name] = value
        if var.type in (INT, TICK):
            try:
                found = self.value(value, scope)
            except OutOfRange as problem:
                raise OutOfRange(f"{var.name}: {problem}") from None
            room = COUNT if var.type is TICK else FULL
            if not room.low <= found.low <= found.high <= room.high:
                raise OutOfRange(f"{var.name} may be {found.low} to {found.high}, beyond 32 bits")
            scope.known[var.name] = found

    def value(self, value: Expression, scope: _Scope) -> Span:
        match value:
            case Var() | Const():
                return self.span(value, scope)
            case Load(array=array, index=index):
                self.within(array, index, scope)
                return self.entries(array, index, scope)
            case Select(condition=condition, then=then, other=other):
                return _hull(self.on_side(condition, True, then, scope), self.on_side(condition, False, other, scope))
            case Op():
                return self.operation(value, scope)
        raise OutOfRange(f"{type(value).__name__} has no rule here")

    def operation(self, op: Op, scope: _Scope) -> Span:
        args = [self.span(a, scope) for a in op.args]
        if op.name in ("ishr", "ishl") and not 0 <= args[1].low <= args[1].high <= 31:
            raise OutOfRange(f"{op.name} by {args[1].low} to {args[1].high} places")
        if op.name == "short" and not args[0].within(-(2**15), 2**15):
            raise OutOfRange(f"{args[0].low} to {args[0].high} are not of 16 bits")
        if op.name == "low" and (args[1].low != args[1].high or args[1].low & (args[1].low + 1)):
            raise OutOfRange(f"low: {args[1].low} to {args[1].high} is no mask")
        if op.name == "upper" and not args[1].within(0, 2**16):
            raise OutOfRange(f"upper: its second factor may be {args[1].low} to {args[1].high}, not within 16 bits")
        if op.name in ("leading", "ishl") and args[0].low < (op.name == "leading"):
            raise OutOfRange(f"{op.name} of {args[0].low} to {args[0].high}")
        if op.name == "idiv" and not (args[0].low >= 0 < args[1].low):
            raise OutOfRange("idiv of a number that may be negative, or by one that may not be positive")
        if op.name == "product" and not (args[0].within(-(2**15), 2**15) and args[1].within(0, 2**16)):
            raise OutOfRange(f"product: of {args[0].low} to {args[0].high} and {args[1].low} to {args[1].high}, not of 16 bits")
        if op.name == "ishl":
            by = op.args[1]
            places = scope.made.get(by.name) if isinstance(by, Var) else None
            if isinstance(places, Op) and places.name == "leading":
                if places.args[0] == op.args[0]:
                    return Span(2**30, MOST)
                if self.never_above(op.args[0], places.args[0], scope):
                    return Span(0, MOST)
        rule, _, rest = OPERATIONS[op.name].ball.partition("(")
        if rule not in _RULES or not rest.startswith("{0}"):
            raise OutOfRange(f"{op.name} has no rule here")
        return Span(*ball_arithmetic.ends(_RULES[rule](*(ball_arithmetic.span((a.low, a.high)) for a in args))))

    def never_above(self, value: Operand, most: Operand, scope: _Scope) -> bool:
        """Whether a value is at most another one, whatever the input."""
        if value == most:
            return True
        match scope.made.get(value.name) if isinstance(value, Var) else None:
            case Select(condition=Var(name=name), then=then, other=other) if scope.made.get(name) == Op("ilt", (then, other)):
                return self.never_above(then, most, scope) or self.never_above(other, most, scope)
        return False

    def on_side(self, condition: Operand, holds: bool, chosen: Operand, scope: _Scope) -> Span:
        """The span of what is chosen where a comparison of integers comes out so."""
        test = scope.made.get(condition.name) if isinstance(condition, Var) else None
        if not isinstance(test, Op) or test.name not in ("ilt", "tlt"):
            return self.span(chosen, scope)
        a, b = (self.span(v, scope) for v in test.args)
        sided = _less(a, b) if holds else _not_less(a, b)
        if sided is None:  # never
            return self.span(chosen, scope)
        known = scope.known | {v.name: s for v, s in zip(test.args, sided, strict=True) if isinstance(v, Var)}
        inner = _Scope(known, scope.made)
        made = scope.made.get(chosen.name) if isinstance(chosen, Var) and chosen not in test.args else None
        if isinstance(made, Op) and any(v in test.args for v in made.args if isinstance(v, Var)):
            return self.operation(made, inner)
        return self.span(chosen, inner)

    def span(self, operand: Operand, scope: _Scope) -> Span:
        if isinstance(operand, Const):
            return Span(int(operand.value), int(operand.value))  # type: ignore[arg-type]
        return scope.known[operand.name]

    def entries(self, array: str, index: Operand, scope: _Scope) -> Span:
        table = next((t for t in self.program.tables if t.name == array), None)
        if table is None:
            return self.inputs[array]
        at = self.span(index, scope)
        values = table.values[at.low : at.high + 1]
        return Span(int(min(values)), int(max(values)))

    def within(self, array: str, index: Operand, scope: _Scope) -> None:
        at = self.span(index, scope)
        if not 0 <= at.low <= at.high < self.lengths[array]:
            raise OutOfRange(f"{array}[{at.low} to {at.high}] of {self.lengths[array]}")


def _hull(a: Span | None, b: Span) -> Span:
    return b if a is None else Span(min(a.low, b.low), max(a.high, b.high))


def _less(a: Span, b: Span) -> tuple[Span, Span] | None:
    """a and b where a < b."""
    found = Span(a.low, min(a.high, b.high - 1)), Span(max(b.low, a.low + 1), b.high)
    return found if all(s.low <= s.high for s in found) else None


def _not_less(a: Span, b: Span) -> tuple[Span, Span] | None:
    """a and b where b <= a."""
    found = Span(max(a.low, b.low), a.high), Span(b.low, min(b.high, a.high))
    return found if all(s.low <= s.high for s in found) else None
