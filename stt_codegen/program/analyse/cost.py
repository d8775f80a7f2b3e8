"""A reader that counts operations: what one call of a function costs on its longest path, by kind of operation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from stt_codegen.program.nodes import (
    Assign,
    Call,
    Expression,
    For,
    IsFinite,
    Load,
    Op,
    Program,
    Return,
    Select,
    Statement,
    Store,
    Trunc,
    entry_bits,
)
from stt_codegen.program.operations import INT, OPERATIONS


def cost_of(program: Program, function: str) -> Counter[str]:
    """Return how many operations of each kind (COST_KINDS) one call of a public function takes on its longest path."""
    return _cost_of_body(program, program.function(function).body)


def table_bytes(program: Program) -> int:
    """Return the bytes of constant tables on the target."""
    real = 64 if program.scalar == "double" else 32
    return sum(len(t.values) * (entry_bits(t) if t.type is INT else real) for t in program.tables) // 8


def _cost_of_body(program: Program, body: Iterable[Statement]) -> Counter[str]:
    """Return the cost of the longest path through a body: an early leave counts only where it makes the longer path."""
    total: Counter[str] = Counter()
    longest = total
    for statement in body:
        match statement:
            case Assign(value=value):
                total = total + _cost_of_expression(value)
            case Call(kernel=name):
                total = total + _cost_of_body(program, program.kernel(name).body)
            case Store():
                total = total + Counter(store=1)
            case For(count=count, body=inner):
                turn = _cost_of_body(program, inner)
                total = total + Counter({kind: number * count for kind, number in turn.items()})
            case Return(status=status, when=when, body=inner):
                leave = total + _cost_of_body(program, inner)
                leave += Counter() if status is None else _cost_of_expression(status)
                if when is None:
                    total = leave
                elif sum(leave.values()) > sum(longest.values()):
                    longest = leave
    return max(total, longest, key=lambda c: sum(c.values()))


def _cost_of_expression(value: Expression) -> Counter[str]:
    """Return the cost of one expression; a variable or constant costs nothing."""
    match value:
        case Op(name=name):
            return Counter({OPERATIONS[name].cost: 1})
        case Select():
            return Counter(select=1)
        case IsFinite():
            return Counter(compare=1)
        case Trunc():
            return Counter(integer=1)
        case Load():
            return Counter(load=1)
    return Counter()
