"""What every printer does alike: the order of statements, of expressions, of a table's rows. A language overrides `format_*`.

An operation is printed from its row in operations.py, by its infix sign or its call; a language that writes one differently has a
method `op_<operation>`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence

from stt_codegen.program.nodes import (
    Assign,
    Call,
    Carry,
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
    Store,
    Table,
    Trunc,
    Var,
)
from stt_codegen.program.operations import OPERATIONS

LITERALS_A_LINE = 4
INDENT = "    "


class Printer(ABC):
    """Prints the parts of one program. `inside` is the function that is being printed, None in a kernel."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.inside: Function | None = None

    def helpers(self) -> Sequence[str | Sequence[str]]:
        """Return the text of the functions that printed operations call, if the language needs any."""
        return []

    # ---- expressions

    def expression(self, value: Expression) -> str:
        match value:
            case Var():
                return self.format_var(value)
            case Const():
                return self.literal(value)
            case Select(condition=c, then=a, otherwise=b):
                return self.format_select(value, self.expression(c), self.expression(a), self.expression(b))
            case IsFinite(arg=a):
                return self.format_finite(self.expression(a))
            case Trunc(arg=a):
                return self.format_trunc(a, self.expression(a))
            case Load(array=array, index=i):
                return self.format_load(self.array(array), self.expression(i))
            case Op(name=name, args=args):
                return self.operation(value, name, [self.expression(a) for a in args])

    def operation(self, _op: Op, name: str, args: Sequence[str]) -> str:
        """By a method of the language's own, the row's infix sign, or the row's call. Raises `NotImplementedError`."""
        own = getattr(self, f"op_{name}", None)
        if own is not None:
            return str(own(*args))
        row = OPERATIONS[name]
        if row.infix:
            return self.format_infix(name, row.infix, args[0], args[1])
        if row.call:
            return self.format_math(row.call, args)
        raise NotImplementedError(f"{type(self).__name__} has no way to print the operation {name!r}")

    def is_table(self, array: str) -> bool:
        return any(t.name == array for t in self.program.tables)

    def format_var(self, var: Var) -> str:
        return var.name

    def format_load(self, array: str, index: str) -> str:
        return f"{array}[{index}]"

    def format_infix(self, _name: str, sign: str, a: str, b: str) -> str:
        return f"{a} {sign} {b}"

    @abstractmethod
    def literal(self, constant: Const) -> str: ...
    @abstractmethod
    def array(self, name: str) -> str: ...
    @abstractmethod
    def format_select(self, select: Select, condition: str, then: str, otherwise: str) -> str: ...
    @abstractmethod
    def format_finite(self, value: str) -> str: ...
    @abstractmethod
    def format_trunc(self, operand: Operand, value: str) -> str: ...
    @abstractmethod
    def format_math(self, name: str, args: Sequence[str]) -> str: ...

    # ---- statements: one line each

    def statements(self, body: Iterable[Statement], indent: int = 1) -> list[str]:
        lines: list[str] = []
        pad = INDENT * indent
        for statement in body:
            match statement:
                case Assign(var=var, value=value):
                    lines.append(pad + self.format_assign(var, self.expression(value)))
                case Call():
                    lines += [pad + line for line in self.format_call(statement)]
                case Store(array=array, index=i, value=value):
                    lines.append(pad + self.format_store(array, self.expression(i), self.expression(value)))
                case For(index=index, count=count, body=inner, carries=carries):
                    lines += [pad + self.format_carry(c) for c in carries]
                    lines.append(pad + self.format_for(index, count))
                    lines += self.statements(inner, indent + 1)
                    lines += [pad + INDENT + line for line in self.format_carried(carries)]
                    lines += [pad + line for line in self.format_end()]
                case Return():
                    lines += [pad + line for line in self.leave(statement)]
        return lines

    def leave(self, statement: Return) -> list[str]:
        """A way out of a function: taken always, or where a condition holds."""
        out = self.format_leave(statement.status)
        if statement.when is None:
            return out
        inner = [*self.statements(statement.body), *(INDENT + line for line in out)]
        return [self.format_if(self.expression(statement.when)), *inner, *self.format_end()]

    def format_carried(self, carries: Sequence[Carry]) -> list[str]:
        """What the carried values become at the end of a turn; none of them may be made of another one."""
        return [self.format_set(c.var, self.expression(c.next)) for c in carries]

    def format_end(self) -> list[str]:
        return []

    @abstractmethod
    def format_assign(self, var: Var, value: str) -> str: ...
    @abstractmethod
    def format_set(self, var: Var, value: str) -> str: ...
    @abstractmethod
    def format_carry(self, carry: Carry) -> str: ...
    @abstractmethod
    def format_call(self, call: Call) -> list[str]: ...
    @abstractmethod
    def format_store(self, array: str, index: str, value: str) -> str: ...
    @abstractmethod
    def format_for(self, index: Var, count: int) -> str: ...
    @abstractmethod
    def format_if(self, condition: str) -> str: ...
    @abstractmethod
    def format_leave(self, status: Expression | None) -> list[str]: ...

    # ---- tables and functions

    def format_entry(self, constant: Const) -> str:
        """A number of a table."""
        return self.literal(constant)

    @abstractmethod
    def table(self, table: Table) -> list[str]: ...
    @abstractmethod
    def kernel(self, kernel: Kernel) -> list[str]: ...
    @abstractmethod
    def function(self, function: Function) -> list[str]: ...

    def rows(self, table: Table) -> list[str]:
        """The literals of a table, its rows begun anew, LITERALS_A_LINE a line, each line ended by a comma."""
        lines = []
        for start in range(0, len(table.values), table.row):
            row = [self.format_entry(Const(v, table.type)) for v in table.values[start : start + table.row]]
            lines += [INDENT + ", ".join(row[k : k + LITERALS_A_LINE]) + "," for k in range(0, len(row), LITERALS_A_LINE)]
        return lines
