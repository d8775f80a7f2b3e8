"""A function of a Program run statement by statement, whatever its values are: numbers and SymPy's formulas (symbolic/paths.py),
CasADi's graphs (convert/to_casadi.py). Loops are unrolled; a subclass says what each node gives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any

from stt_codegen.program.nodes import (
    Assign,
    Call,
    Const,
    Expression,
    For,
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
    Trunc,
    Var,
)


class Walk(ABC):
    """Runs statements on values of any kind. known: values by name; arrays: parameters that are arrays, entry by entry."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.known: dict[str, Any] = {}
        self.arrays: dict[str, list[Any]] = {}

    def run_statements(self, body: Iterable[Statement]) -> None:
        """Run statements: they change `known` and `arrays`."""
        for statement in body:
            match statement:
                case Assign(var=var, value=value):
                    self.known[var.name] = self.value(value)
                case Call(results=results, kernel=kernel, args=args):
                    values = self.run_kernel(self.program.kernel(kernel), [self.operand(a) for a in args])
                    self.known |= dict(zip((r.name for r in results), values, strict=True))
                case Store(array=array, index=index, value=value):
                    self.arrays[array][self.operand(index)] = self.operand(value)
                case For(index=index, count=count, body=inner, carries=carries):
                    self.known |= {c.var.name: self.operand(c.initial) for c in carries}
                    for k in range(count):
                        self.known[index.name] = k
                        self.run_statements(inner)
                        self.known |= {c.var.name: self.operand(c.next) for c in carries}
                case Return():
                    self.leave(statement)

    def run_kernel(self, kernel: Kernel, args: Sequence[Any]) -> list[Any]:
        """Return the outputs of a kernel; it sees no names but those of its inputs."""
        caller_names, self.known = self.known, dict(zip((v.name for v in kernel.inputs), args, strict=True))
        for assign in kernel.body:
            self.known[assign.var.name] = self.value(assign.value)
        outputs = [self.operand(o) for o in kernel.outputs]
        self.known = caller_names
        return outputs

    def operand(self, operand: Operand) -> Any:
        """Return the value of a variable or constant."""
        return self.known[operand.name] if isinstance(operand, Var) else self.constant(operand)

    def value(self, expression: Expression) -> Any:
        """Return the value of an expression."""
        match expression:
            case Var() | Const():
                return self.operand(expression)
            case Select(condition=condition, then=then, otherwise=otherwise):
                return self.select(*(self.operand(v) for v in (condition, then, otherwise)))
            case IsFinite(arg=arg):
                return self.finite(self.operand(arg))
            case Trunc(arg=arg):
                return self.trunc(self.operand(arg))
            case Load(array=array, index=index):
                k = self.operand(index)
                return self.arrays[array][k] if array in self.arrays else self.entry(array, k)
            case Op(name=name, args=args):
                return self.operation(name, [self.operand(a) for a in args])

    @abstractmethod
    def leave(self, statement: Return) -> None:
        """Leave the function where the statement says so."""

    @abstractmethod
    def constant(self, constant: Const) -> Any: ...
    @abstractmethod
    def select(self, condition: Any, then: Any, otherwise: Any) -> Any: ...
    @abstractmethod
    def finite(self, value: Any) -> Any: ...
    @abstractmethod
    def trunc(self, value: Any) -> Any: ...
    @abstractmethod
    def operation(self, name: str, args: list[Any]) -> Any:
        """Return an operation, a key of OPERATIONS, on values."""

    @abstractmethod
    def entry(self, table: str, index: Any) -> Any:
        """Return one entry of a table."""
