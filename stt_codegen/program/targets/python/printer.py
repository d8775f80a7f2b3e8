"""Program to Python: the same functions in double arithmetic on the emitted constants, with `math` and nothing else."""

from __future__ import annotations

from collections.abc import Sequence

from stt_codegen.program.nodes import (
    Call,
    Carry,
    Const,
    Expression,
    Function,
    Kernel,
    Operand,
    Select,
    Status,
    Table,
    Var,
    uses_split,
)
from stt_codegen.program.number import FORMATS, round_to, shortest
from stt_codegen.program.operations import INT, TICK
from stt_codegen.program.targets.printer import Printer

_SIGNS = {"and": "and", "or": "or", "idiv": "//"}  # infix signs that differ from those of C


class PythonPrinter(Printer):
    """Prints Python. Arrays come in as sequences and go out as tuples; nothing is changed in place."""

    def helpers(self) -> list[str]:
        """Return the helper function of the operations `exponent` and `mantissa`, where the program has one."""
        if not uses_split(self.program):
            return []
        smallest = self.literal(Const(FORMATS[self.program.scalar].smallest_mantissa))
        return [
            "def _split(y):",
            '    """m and e with y = m 2^e, m in [1/sqrt 2, sqrt 2)."""',
            "    m, e = math.frexp(y)",
            f"    return (m, e) if m >= {smallest} else (2.0 * m, e - 1)",
        ]

    def literal(self, constant: Const) -> str:
        """Return a constant; a real is rounded to the program's scalar, and written as a double."""
        value = constant.value
        if isinstance(value, Status):
            return value.name
        if isinstance(value, bool):
            return str(value)
        if constant.type in (INT, TICK):
            return str(value)
        if value is None:
            return "math.nan"
        return shortest(round_to(value, self.program.scalar), "double")  # type: ignore[arg-type]

    def array(self, name: str) -> str:
        """Return the name of a table, in capitals, or of an array parameter."""
        return name.upper() if self.is_table(name) else name

    def format_select(self, _select: Select, condition: str, then: str, otherwise: str) -> str:
        return f"{then} if {condition} else {otherwise}"

    def format_finite(self, value: str) -> str:
        return f"math.isfinite({value})"

    def format_trunc(self, _operand: Operand, value: str) -> str:
        return f"int({value})"

    def format_infix(self, name: str, sign: str, a: str, b: str) -> str:
        return f"{a} {_SIGNS.get(name, sign)} {b}"

    def format_math(self, name: str, args: Sequence[str]) -> str:
        return f"math.{name}({', '.join(args)})"

    def op_floor(self, a: str) -> str:
        """Return floor as a float; that of Python is an integer, and so is its ceil."""
        return f"float(math.floor({a}))"

    def op_ceil(self, a: str) -> str:
        return f"float(math.ceil({a}))"

    def op_pow(self, a: str, b: str) -> str:
        return f"{a} ** {b}"

    def op_eq(self, a: str, b: str) -> str:
        return f"{a} == {b}"

    def op_ne(self, a: str, b: str) -> str:
        return f"{a} != {b}"

    def op_neg(self, a: str) -> str:
        return f"-{a}"

    def op_not(self, a: str) -> str:
        return f"not {a}"

    def op_real(self, a: str) -> str:
        return f"float({a})"

    def op_int(self, a: str) -> str:
        return a

    def op_high_product(self, a: str, b: str) -> str:
        return f"{a} * {b} >> 16"

    def op_ineg(self, a: str) -> str:
        return f"-{a}"

    def op_low_bits(self, a: str, mask: str) -> str:
        return f"{a} & {mask}"

    def op_short(self, a: str) -> str:
        return a

    def op_leading(self, a: str) -> str:
        return f"31 - {a}.bit_length()"

    def op_exponent(self, a: str) -> str:
        return f"_split({a})[1]"

    def op_mantissa(self, a: str) -> str:
        return f"_split({a})[0]"

    def format_assign(self, var: Var, value: str) -> str:
        return f"{var.name} = {value}"

    def format_set(self, var: Var, value: str) -> str:
        return f"{var.name} = {value}"

    def format_carry(self, carry: Carry) -> str:
        return f"{carry.var.name} = {self.expression(carry.initial)}"

    def format_store(self, array: str, index: str, value: str) -> str:
        return f"{array}[{index}] = {value}"

    def format_for(self, index: Var, count: int) -> str:
        return f"for {index.name} in range({count}):"

    def format_if(self, condition: str) -> str:
        return f"if {condition}:"

    def format_call(self, call: Call) -> list[str]:
        names = ", ".join(r.name for r in call.results)
        return [f"{names} = _{call.kernel}({', '.join(self.expression(a) for a in call.args)})"]

    def format_leave(self, status: Expression | None) -> list[str]:
        assert self.inside is not None
        arrays = [f"tuple({p.name})" for p in self.inside.outputs]
        parts = ([self.expression(status)] if status is not None else []) + arrays
        return [f"return {', '.join(parts)}"]

    def table(self, table: Table) -> list[str]:
        """Return a table as a tuple, with its comment."""
        lines = [*(f"# {line}".rstrip() for line in table.doc), f"{table.name.upper()} = ("]
        return [*lines, *self.rows(table), ")"]

    def kernel(self, kernel: Kernel) -> list[str]:
        """Return a kernel as a private function."""
        inputs = ", ".join(v.name for v in kernel.inputs)
        outputs = ", ".join(self.expression(o) for o in kernel.outputs)
        return [
            f"def _{kernel.name}({inputs}):",
            *self.docstring(kernel.doc),
            *self.statements(kernel.body),
            f"    return {outputs}",
        ]

    def function(self, function: Function) -> list[str]:
        """Return a public function, which checks and converts its arguments first."""
        lines = [f"def {function.name}({', '.join(p.name for p in function.inputs)}):", *self.docstring(function.doc)]
        for p in function.inputs:
            scalar = f'_count("{p.name}", {p.name})' if p.type is TICK else f"float({p.name})"
            vector = f'{"_whole" if p.type is INT else "_vector"}("{p.name}", {p.name}, {p.length})'
            lines.append(f"    {p.name} = {scalar if p.length is None else vector}")
        lines += [f"    {p.name} = [{'0' if p.type is INT else '0.0'}] * {p.length}" for p in function.outputs if not p.inout]
        self.inside = function
        return [*lines, *self.statements(function.body)]

    def docstring(self, doc: tuple[str, ...]) -> list[str]:
        """Return lines of text as a docstring."""
        if not doc:
            return []
        if len(doc) == 1:
            return [f'    """{doc[0]}"""']
        return [f'    """{doc[0]}', *(f"    {line}".rstrip() for line in doc[1:]), '    """']
