"""Program to JavaScript: the same functions in double arithmetic on the emitted constants."""

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
from stt_codegen.program.targets.printer import INDENT, Printer


class JavaScriptPrinter(Printer):
    """Prints JavaScript. A function returns an array of its status or value and of the arrays that it writes."""

    def helpers(self) -> list[str]:
        """Return the helper function of the operations `exponent` and `mantissa`, where the program has one."""
        if not uses_split(self.program):
            return []
        smallest = self.literal(Const(FORMATS[self.program.scalar].smallest_mantissa))
        return [
            "// [m, e] with y = m 2^e, m in [1/sqrt 2, sqrt 2).",
            "function split(y) {",
            "    let m = y;",
            "    let e = 0;",
            f"    while (m >= 2.0 * {smallest}) {{",
            "        m = 0.5 * m;",
            "        e += 1;",
            "    }",
            "    return [m, e];",
            "}",
        ]

    def literal(self, constant: Const) -> str:
        value = constant.value
        if isinstance(value, Status):
            return value.name
        if isinstance(value, bool):
            return "true" if value else "false"
        if value is None:
            return "NaN"
        text = str(value) if constant.type in (INT, TICK) else shortest(round_to(value, self.program.scalar), "double")
        return f"({text})" if text.startswith("-") else text

    def array(self, name: str) -> str:
        return name.upper() if self.is_table(name) else name

    def format_select(self, _select: Select, condition: str, then: str, otherwise: str) -> str:
        return f"{condition} ? {then} : {otherwise}"

    def format_finite(self, value: str) -> str:
        return f"Number.isFinite({value})"

    def format_trunc(self, _operand: Operand, value: str) -> str:
        return f"Math.trunc({value})"

    def format_math(self, name: str, args: Sequence[str]) -> str:
        return f"Math.{name}({', '.join(args)})"

    def op_fabs(self, a: str) -> str:
        return f"Math.abs({a})"

    def op_eq(self, a: str, b: str) -> str:
        return f"{a} === {b}"

    def op_ne(self, a: str, b: str) -> str:
        return f"{a} !== {b}"

    def op_neg(self, a: str) -> str:
        return f"-{a}"

    def op_not(self, a: str) -> str:
        return f"!{a}"

    def op_idiv(self, a: str, b: str) -> str:
        return f"Math.floor({a} / {b})"

    def op_real(self, a: str) -> str:
        return a

    def op_int(self, a: str) -> str:
        return a

    def op_exponent(self, a: str) -> str:
        return f"split({a})[1]"

    def op_mantissa(self, a: str) -> str:
        return f"split({a})[0]"

    def format_assign(self, var: Var, value: str) -> str:
        return f"const {var.name} = {value};"

    def format_set(self, var: Var, value: str) -> str:
        return f"{var.name} = {value};"

    def format_carry(self, carry: Carry) -> str:
        return f"let {carry.var.name} = {self.expression(carry.initial)};"

    def format_store(self, array: str, index: str, value: str) -> str:
        return f"{array}[{index}] = {value};"

    def format_for(self, index: Var, count: int) -> str:
        return f"for (let {index.name} = 0; {index.name} < {count}; ++{index.name}) {{"

    def format_if(self, condition: str) -> str:
        return f"if ({condition}) {{"

    def format_end(self) -> list[str]:
        return ["}"]

    def format_call(self, call: Call) -> list[str]:
        names = ", ".join(r.name for r in call.results)
        return [f"const [{names}] = kernel_{call.kernel}({', '.join(self.expression(a) for a in call.args)});"]

    def format_leave(self, status: Expression | None) -> list[str]:
        assert self.inside is not None
        parts = ([self.expression(status)] if status is not None else []) + [p.name for p in self.inside.outputs]
        return [f"return [{', '.join(parts)}];"]

    def table(self, table: Table) -> list[str]:
        lines = [*(f"// {line}".rstrip() for line in table.doc), f"const {table.name.upper()} = ["]
        return [*lines, *self.rows(table), "];"]

    def kernel(self, kernel: Kernel) -> list[str]:
        outputs = ", ".join(self.expression(o) for o in kernel.outputs)
        return [
            *(f"// {line}".rstrip() for line in kernel.doc),
            f"function kernel_{kernel.name}({', '.join(v.name for v in kernel.inputs)}) {{",
            *self.statements(kernel.body),
            f"{INDENT}return [{outputs}];",
            "}",
        ]

    def function(self, function: Function) -> list[str]:
        """Return the lines of a function; an argument that it changes is copied first."""
        self.inside = function
        written = [p for p in function.outputs if not p.inout]
        return [
            *(f"// {line}".rstrip() for line in function.doc),
            f"function {function.name}({', '.join(p.name for p in function.inputs)}) {{",
            *(f"{INDENT}{p.name} = {p.name}.slice();" for p in function.outputs if p.inout),
            *(f"{INDENT}const {p.name} = new Array({p.length}).fill(0);" for p in written),
            *self.statements(function.body),
            "}",
        ]
