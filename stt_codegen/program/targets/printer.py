"""The base class of printers: it goes through expressions, statements and rows of tables, and a language overrides `format_*`.

An operation is printed from its row in operations.py, by its infix sign or its call; a language that writes one differently has a
method `op_<operation>`. A method returns text or lines of text.
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

LITERALS_PER_LINE = 4
INDENT = "    "


class Printer(ABC):
    """Prints the parts of one program. `inside` is the function that is being printed, None in a kernel."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.inside: Function | None = None

    def helpers(self) -> Sequence[str | Sequence[str]]:
        """Return the text of the helper functions that printed operations call, if the language needs any."""
        return []

    # ---- expressions

    def expression(self, value: Expression) -> str:
        """Return an expression as the language writes it."""
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
        """Return an operation by the method `op_<name>`, or by the infix sign or the call of its row.

        Raises `NotImplementedError` where there is none of these.
        """
        method = getattr(self, f"op_{name}", None)
        if method is not None:
            return str(method(*args))
        row = OPERATIONS[name]
        if row.infix:
            return self.format_infix(name, row.infix, args[0], args[1])
        if row.call:
            return self.format_math(row.call, args)
        raise NotImplementedError(f"{type(self).__name__} has no way to print the operation {name!r}")

    def is_table(self, array: str) -> bool:
        """Whether a name is that of a table of the program."""
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
        """Return the lines of a body, indented by so many steps."""
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
        """Return the lines of a way out of a function, which is taken always or where a condition holds."""
        leave = self.format_leave(statement.status)
        if statement.when is None:
            return leave
        inner = [*self.statements(statement.body), *(INDENT + line for line in leave)]
        return [self.format_if(self.expression(statement.when)), *inner, *self.format_end()]

    def format_carried(self, carries: Sequence[Carry]) -> list[str]:
        """Return what the carried values become at the end of a turn; none of them may depend on the new value of another."""
        return [self.format_set(c.var, self.expression(c.next)) for c in carries]

    def format_end(self) -> list[str]:
        """Return what ends a loop or a condition; nothing where indentation does."""
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
        """Return a number of a table."""
        return self.literal(constant)

    @abstractmethod
    def table(self, table: Table) -> list[str]: ...
    @abstractmethod
    def kernel(self, kernel: Kernel) -> list[str]: ...
    @abstractmethod
    def function(self, function: Function) -> list[str]: ...

    def rows(self, table: Table) -> list[str]:
        """Return the literals of a table: a row begins a new line, which has LITERALS_PER_LINE of them and ends with a comma."""
        lines = []
        for start in range(0, len(table.values), table.row):
            row = [self.format_entry(Const(v, table.type)) for v in table.values[start : start + table.row]]
            lines += [INDENT + ", ".join(row[k : k + LITERALS_PER_LINE]) + "," for k in range(0, len(row), LITERALS_PER_LINE)]
        return lines
