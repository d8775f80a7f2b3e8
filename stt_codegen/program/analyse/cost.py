"""Operation counts of a Program: what one call costs on the longest path, by kind of operation."""

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
    """Operations of one call of a public function, by kind (see COST_KINDS), longest path."""
    return _statements(program, program.function(function).body)


def table_bytes(program: Program) -> int:
    """Bytes of constant tables on the target."""
    real = 64 if program.scalar == "double" else 32
    return sum(len(t.values) * (entry_bits(t) if t.type is INT else real) for t in program.tables) // 8


def _statements(program: Program, body: Iterable[Statement]) -> Counter[str]:
    """Straight-line cost; an early leave is taken only where it is the longer path."""
    total: Counter[str] = Counter()
    longest = total
    for statement in body:
        match statement:
            case Assign(value=value):
                total = total + _expression(value)
            case Call(kernel=name):
                total = total + _statements(program, program.kernel(name).body)
            case Store():
                total = total + Counter(store=1)
            case For(count=count, body=inner):
                once = _statements(program, inner)
                total = total + Counter({k: v * count for k, v in once.items()})
            case Return(status=status, when=when, body=inner):
                leave = total + _statements(program, inner) + (_expression(status) if status is not None else Counter())
                if when is None:
                    total = leave
                elif sum(leave.values()) > sum(longest.values()):
                    longest = leave
    return max(total, longest, key=lambda c: sum(c.values()))


def _expression(value: Expression) -> Counter[str]:
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
