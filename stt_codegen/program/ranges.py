"""A reader that proves that no integer of a program of integers leaves 32 bits, no index its table, no shift its word.

Every variable gets a span that holds for all inputs: operations by the rules of their rows (`Operation.ball`), calls with the
spans of their arguments, loops in one turn for all. Four facts are more than spans:

- a square is not negative;
- in a Select on a < b the chosen operand is known to be on its side, as is what is computed of it in one step;
- a moved up by leading(a) places lies in [2^30, 2^31);
- v <= m >> k, moved up by k places, is not above m.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from stt_codegen.program import ball_arithmetic
from stt_codegen.program.nodes import (
    Assign,
    Call,
    Const,
    Expression,
    For,
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
_RULES: dict[str, Callable[..., Any]] = {f.__name__: f for f in ball_arithmetic.HELPERS}


class OutOfRange(Exception):
    """A value that may not be what its type holds; the text says which."""


@dataclass(frozen=True)
class Span:
    """All whole numbers from low to high."""

    low: int
    high: int


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
                    if any(c.var.type is INT for c in carries):
                        raise OutOfRange(f"{index.name}: an integer is carried through a loop, which has no rule here")
                    scope.known[index.name] = Span(0, count - 1)
                    self.statements(inner, scope)
                case Return(body=inner):
                    self.statements(inner, scope)

    def call(self, results: Sequence[Var], name: str, args: Sequence[Operand], scope: _Scope) -> None:
        kernel = self.program.kernel(name)
        own = _Scope({})
        for var, arg in zip(kernel.inputs, args, strict=True):
            if var.type in (INT, TICK):
                own.known[var.name] = self.span(arg, scope)
        self.statements(kernel.body, own)
        for var, output in zip(results, kernel.outputs, strict=True):
            if var.type is INT:
                scope.known[var.name] = self.span(output, own)

    def assign(self, var: Var, value: Expression, scope: _Scope) -> None:
        scope.made[var.name] = value
        if var.type in (INT, TICK):
            found, room = self.value(value, scope), COUNT if var.type is TICK else FULL
            if not room.low <= found.low <= found.high <= room.high:
                raise OutOfRange(f"{var.name} may be {found.low} to {found.high}, beyond 32 bits")
            scope.known[var.name] = found

    def value(self, value: Expression, scope: _Scope) -> Span:
        match value:
            case Var() | Const():
                return self.span(value, scope)
            case Load(array=array, index=index):
                self.within(array, index, scope)
                return self.entries(array)
            case Select(condition=condition, then=then, other=other):
                return _hull(self.on_side(condition, True, then, scope), self.on_side(condition, False, other, scope))
            case Op():
                return self.operation(value, scope)
        raise OutOfRange(f"{type(value).__name__} has no rule here")

    def operation(self, op: Op, scope: _Scope) -> Span:
        args = [self.span(a, scope) for a in op.args]
        if op.name in ("ishr", "ishl") and not 0 <= args[1].low <= args[1].high <= 31:
            raise OutOfRange(f"{op.name} by {args[1].low} to {args[1].high} places")
        if op.name == "upper" and not 0 <= args[1].low <= args[1].high < 2**16:
            raise OutOfRange(f"upper: its second factor may be {args[1].low} to {args[1].high}, not within 16 bits")
        if op.name in ("leading", "ishl") and args[0].low < (op.name == "leading"):
            raise OutOfRange(f"{op.name} of {args[0].low} to {args[0].high}")
        if op.name == "idiv" and not (args[0].low >= 0 < args[1].low):
            raise OutOfRange("idiv of a number that may be negative, or by one that may not be positive")
        if op.name == "ishl":
            by = op.args[1]
            made = scope.made.get(by.name) if isinstance(by, Var) else None
            if made == Op("leading", (op.args[0],)):
                return Span(2**30, MOST)
            most = self.bound_above(op.args[0], by, scope)
            if most is not None:
                return Span(0, most)
        if op.name == "imul" and op.args[0] == op.args[1]:
            a = args[0]
            return Span(0 if a.low <= 0 <= a.high else min(a.low**2, a.high**2), max(a.low**2, a.high**2))
        rule, _, rest = OPERATIONS[op.name].ball.partition("(")
        if rule not in _RULES or not rest.startswith("{0}"):
            raise OutOfRange(f"{op.name} has no rule here")
        return Span(*ball_arithmetic.ends(_RULES[rule](*(ball_arithmetic.span((a.low, a.high)) for a in args))))

    def bound_above(self, value: Operand, by: Operand, scope: _Scope) -> int | None:
        """m, where value was made as the lesser of something and m >> by."""
        made = scope.made.get(value.name) if isinstance(value, Var) else None
        if not isinstance(made, Select) or not isinstance(made.condition, Var):
            return None
        test = scope.made.get(made.condition.name)
        if not isinstance(test, Op) or test.name != "ilt":
            return None
        for limit in (made.then, made.other) if test.args == (made.then, made.other) else ():  # a < b ? a : b
            source = scope.made.get(limit.name) if isinstance(limit, Var) else None
            if isinstance(source, Op) and source.name == "ishr" and source.args[1] == by:
                return self.span(source.args[0], scope).high
        return None

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

    def entries(self, array: str) -> Span:
        table = next((t for t in self.program.tables if t.name == array), None)
        return self.inputs[array] if table is None else Span(int(min(table.values)), int(max(table.values)))

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
