"""A reader that lists the comparisons of a function, in the order of its statements: where a path can part from another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from stt_codegen.decimals import decimal
from stt_codegen.program.nodes import Assign, Call, Const, For, Function, IsFinite, Op, Operand, Program, Return, Statement
from stt_codegen.program.operations import OPERATIONS, REAL


def comparisons(program: Program, function: Function, inlined: frozenset[str]) -> tuple[str, ...]:
    """Every comparison of a function and of the kernels `inlined` that it calls, by the names that its operands have. Those of a
    loop come once for each turn, so that a path's decisions go by this list as far as it comes."""
    return tuple(_of(program, function.body, inlined))


def _of(program: Program, body: Iterable[Statement], inlined: frozenset[str]) -> Iterator[str]:
    for statement in body:
        match statement:
            case Assign(value=Op(name=name, args=args)) if OPERATIONS[name].compares:
                yield f"{name} {' '.join(map(_shown, args))}"
            case Assign(value=IsFinite(arg=arg)):
                yield f"finite {_shown(arg)}"
            case Call(kernel=kernel) if kernel in inlined:
                yield from _of(program, program.kernel(kernel).body, inlined)
            case For(body=inner, count=count):
                for _ in range(count):
                    yield from _of(program, inner, inlined)
            case Return(body=inner):
                yield from _of(program, inner, inlined)


def _shown(operand: Operand) -> str:
    if isinstance(operand, Const):
        return decimal(operand.value) if operand.type is REAL and operand.value is not None else str(operand.value)  # type: ignore[arg-type]
    return operand.name
