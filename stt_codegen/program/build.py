"""Putting a Program together: statements one after the other, with names used once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from stt_codegen.program.nodes import (
    Assign,
    Call,
    Carry,
    Expression,
    For,
    Kernel,
    Op,
    Operand,
    Return,
    Select,
    Statement,
    Store,
    Var,
    type_of,
)
from stt_codegen.program.operations import INT, Type


@dataclass
class Block:
    """Builds a list of statements with names used once."""

    taken: set[str] = field(default_factory=set)
    statements: list[Statement] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)  # the last number behind each name

    def fresh(self, name: str, kind: Type) -> Var:
        """A variable of that name, with a number behind it when the name is taken."""
        k = self.counts.get(name, 1)
        candidate = name if k == 1 else f"{name}{k}"
        while candidate in self.taken:
            k += 1
            candidate = f"{name}{k}"
        self.taken.add(candidate)
        self.counts[name] = k
        return Var(candidate, kind)

    def let(self, name: str, value: Expression) -> Var:
        var = self.fresh(name, type_of(value))
        self.statements.append(Assign(var, value))
        return var

    def op(self, name: str, operation: str, *args: Operand) -> Var:
        return self.let(name, Op(operation, args))

    def select(self, name: str, condition: Operand, then: Operand, otherwise: Operand) -> Var:
        return self.let(name, Select(condition, then, otherwise))

    def call(self, kernel: Kernel, *args: Operand, names: Sequence[str] = ()) -> tuple[Var, ...]:
        kinds = [o.type for o in kernel.outputs]
        results = tuple(self.fresh(n, t) for n, t in zip(names or kernel.output_names, kinds, strict=True))
        self.statements.append(Call(results, kernel.name, args))
        return results

    def store(self, array: str, index: Operand, value: Operand) -> None:
        self.statements.append(Store(array, index, value))

    @contextmanager
    def loop(self, index: str, count: int) -> Iterator[Loop]:
        """A loop over 0 .. count - 1; carried values are declared on the object it yields."""
        outer, self.statements = self.statements, []
        handle = Loop(self, self.fresh(index, INT))
        yield handle
        body, self.statements = self.statements, outer
        self.statements.append(For(handle.index, count, tuple(body), tuple(handle.carries)))

    def leave(self, status: Expression | None = None) -> None:
        self.statements.append(Return(status))

    @contextmanager
    def leave_when(self, condition: Operand, status: Operand | None = None) -> Iterator[None]:
        """Statements to do before leaving with `status` when `condition` holds."""
        outer, self.statements = self.statements, []
        yield
        body, self.statements = self.statements, outer
        self.statements.append(Return(status, condition, tuple(body)))


@dataclass
class Loop:
    block: Block
    index: Var
    carries: list[Carry] = field(default_factory=list)

    def carry(self, name: str, initial: Operand) -> Var:
        """A value that the loop changes; say how with `update`."""
        var = self.block.fresh(name, initial.type)
        self.carries.append(Carry(var, initial, var))
        return var

    def update(self, var: Var, value: Operand) -> None:
        self.carries = [Carry(c.var, c.initial, value) if c.var == var else c for c in self.carries]
