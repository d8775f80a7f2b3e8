"""A reader that lists the comparisons of a function in the order of its statements, for messages about the path that is taken."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from stt_codegen.decimals import decimal
from stt_codegen.program.nodes import Assign, Call, Const, For, Function, IsFinite, Op, Operand, Program, Return, Statement
from stt_codegen.program.operations import OPERATIONS, REAL


def comparisons(program: Program, function: Function, inlined: frozenset[str]) -> tuple[str, ...]:
    """Return every comparison of a function, and of the kernels `inlined` that it calls, as text: "lt t zero".

    Those of a loop come once for each turn. So the k-th decision of a path (symbolic/paths.py) is about the k-th entry.
    """
    return tuple(_comparisons_of(program, function.body, inlined))


def _comparisons_of(program: Program, body: Iterable[Statement], inlined: frozenset[str]) -> Iterator[str]:
    """Yield the comparisons of a body, those of its loops and inlined kernels too."""
    for statement in body:
        match statement:
            case Assign(value=Op(name=name, args=args)) if OPERATIONS[name].compares:
                yield f"{name} {' '.join(map(_operand_text, args))}"
            case Assign(value=IsFinite(arg=arg)):
                yield f"finite {_operand_text(arg)}"
            case Call(kernel=kernel) if kernel in inlined:
                yield from _comparisons_of(program, program.kernel(kernel).body, inlined)
            case For(body=inner, count=count):
                for _ in range(count):
                    yield from _comparisons_of(program, inner, inlined)
            case Return(body=inner):
                yield from _comparisons_of(program, inner, inlined)


def _operand_text(operand: Operand) -> str:
    if isinstance(operand, Const):
        return decimal(operand.value) if operand.type is REAL and operand.value is not None else str(operand.value)  # type: ignore[arg-type]
    return operand.name
