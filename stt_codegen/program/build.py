"""Builders of statements: `Block` collects the statements of a kernel or function, and gives every variable a name of its own.

`controller/` makes its kernels and functions with it.
"""

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
    """Builds a list of statements in which every name is used once.

    block = Block()
    double = block.op("double", "add", x, x)  # the statement double = x + x
    """

    used_names: set[str] = field(default_factory=set)
    statements: list[Statement] = field(default_factory=list)

    def fresh(self, name: str, kind: Type) -> Var:
        """Return a variable of that name. Raises `ValueError` where the name is used already: names are given by hand."""
        if name in self.used_names:
            raise ValueError(f"the name {name!r} is used twice in one block")
        self.used_names.add(name)
        return Var(name, kind)

    def let(self, name: str, value: Expression) -> Var:
        """Assign an expression to a new variable, and return it."""
        var = self.fresh(name, type_of(value))
        self.statements.append(Assign(var, value))
        return var

    def op(self, name: str, operation: str, *args: Operand) -> Var:
        """Assign an operation, a key of OPERATIONS, to a new variable."""
        return self.let(name, Op(operation, args))

    def select(self, name: str, condition: Operand, then: Operand, otherwise: Operand) -> Var:
        """Assign `then` where a truth value holds, else `otherwise`."""
        return self.let(name, Select(condition, then, otherwise))

    def call(self, kernel: Kernel, *args: Operand, names: Sequence[str] = ()) -> tuple[Var, ...]:
        """Call a kernel, and return its results; names: of the results, in place of the names of the kernel's outputs."""
        kinds = [o.type for o in kernel.outputs]
        results = tuple(self.fresh(n, t) for n, t in zip(names or kernel.output_names, kinds, strict=True))
        self.statements.append(Call(results, kernel.name, args))
        return results

    def store(self, array: str, index: Operand, value: Operand) -> None:
        """Write one entry of an output array."""
        self.statements.append(Store(array, index, value))

    @contextmanager
    def loop(self, index: str, count: int) -> Iterator[LoopBuilder]:
        """Build a loop over 0 .. count - 1; statements made within it are its body, and carried values are declared on what it
        yields."""
        outer, self.statements = self.statements, []
        builder = LoopBuilder(self, self.fresh(index, INT))
        yield builder
        body, self.statements = self.statements, outer
        self.statements.append(For(builder.index, count, tuple(body), tuple(builder.carries)))

    def leave(self, status: Expression | None = None) -> None:
        """Leave the function, with what it returns."""
        self.statements.append(Return(status))

    @contextmanager
    def leave_when(self, condition: Operand, status: Operand | None = None) -> Iterator[None]:
        """Leave with `status` where `condition` holds; statements made within it are run before that."""
        outer, self.statements = self.statements, []
        yield
        body, self.statements = self.statements, outer
        self.statements.append(Return(status, condition, tuple(body)))


@dataclass
class LoopBuilder:
    """A loop that is being built: its counter, and the values that it carries from one turn to the next."""

    block: Block
    index: Var
    carries: list[Carry] = field(default_factory=list)

    def carry(self, name: str, initial: Operand) -> Var:
        """Return a value that the loop changes; `update` says how."""
        var = self.block.fresh(name, initial.type)
        self.carries.append(Carry(var, initial, var))
        return var

    def update(self, var: Var, value: Operand) -> None:
        """Set what a carried value becomes at the end of a turn."""
        self.carries = [Carry(c.var, c.initial, value) if c.var == var else c for c in self.carries]
