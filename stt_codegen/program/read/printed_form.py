"""The printed form of a Program: what a reader of its C text can know. `read/c.py` compares it with the Program that it reads."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any

from stt_codegen.program.nodes import (
    Assign,
    Call,
    Carry,
    Const,
    For,
    IsFinite,
    Kernel,
    Load,
    Op,
    Param,
    Program,
    Return,
    Select,
    Statement,
    Store,
    Table,
    Trunc,
)
from stt_codegen.program.number import round_to
from stt_codegen.program.operations import INT, REAL


def printed_form(program: Program) -> Program:
    """Return the Program as its C text shows it: constants rounded, without comments and without names that C does not have."""
    scalar = program.scalar
    return replace(
        program,
        tables=tuple(_printed_table(table, scalar) for table in program.tables),
        tick=None,
        kernels=tuple(_printed_kernel(kernel, scalar) for kernel in program.kernels),
        functions=tuple(
            replace(
                f,
                params=tuple(Param(p.name, p.length, p.output, type=p.type) for p in f.params),
                body=_printed_body(f.body, scalar),
                doc=(),
            )
            for f in program.functions
        ),
    )


def _printed_table(table: Table, scalar: str) -> Table:
    values = table.values if table.type is INT else tuple(round_to(v, scalar) for v in table.values)
    return Table(table.name, values, 0, type=table.type)


def _printed_kernel(kernel: Kernel, scalar: str) -> Kernel:
    body: Any = tuple(_printed_statement(assign, scalar) for assign in kernel.body)
    outputs = tuple(_printed_expression(output, scalar) for output in kernel.outputs)
    return Kernel(kernel.name, kernel.inputs, body, outputs, ())


def _printed_body(body: Iterable[Statement], scalar: str) -> tuple[Statement, ...]:
    """Return the statements as printed; a bare return at the end is not printed."""
    statements = tuple(_printed_statement(statement, scalar) for statement in body)
    return statements[:-1] if statements and statements[-1] == Return() else statements


def _printed_statement(statement: Statement, scalar: str) -> Statement:
    """Return a statement with its constants as printed."""

    def printed(value: Any) -> Any:
        return _printed_expression(value, scalar)

    match statement:
        case Assign(var=var, value=value):
            return Assign(var, printed(value))
        case Call(results=results, kernel=kernel, args=args):
            return Call(results, kernel, tuple(map(printed, args)))
        case Store(array=array, index=index, value=value):
            return Store(array, printed(index), printed(value))
        case For(index=index, count=count, body=body, carries=carries):
            printed_carries = tuple(Carry(c.var, printed(c.initial), printed(c.next)) for c in carries)
            return For(index, count, _printed_body(body, scalar), printed_carries)
        case Return(status=status, when=when, body=body):
            return Return(printed(status), printed(when), _printed_body(body, scalar))


def _printed_expression(value: Any, scalar: str) -> Any:
    """Return an expression with its constants as printed: rounded, and the negative of a constant as one constant."""

    def printed(operand: Any) -> Any:
        return _printed_expression(operand, scalar)

    match value:
        case Const(type=kind, value=Fraction() as number) if kind is REAL:
            return Const(round_to(number, scalar))
        case Op(name="neg", args=(Const() as constant,)):
            return Const(-printed(constant).value)
        case Op(name=name, args=args):
            return Op(name, tuple(map(printed, args)))
        case Select(condition=condition, then=then, otherwise=otherwise):
            return Select(printed(condition), printed(then), printed(otherwise))
        case IsFinite(arg=arg):
            return IsFinite(printed(arg))
        case Trunc(arg=arg):
            return Trunc(printed(arg))
        case Load(array=array, index=index):
            return Load(array, printed(index), value.type)
    return value
