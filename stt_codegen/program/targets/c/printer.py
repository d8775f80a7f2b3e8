"""Program to C99: types, names and literals. Every statement is one line.

Assumed of the compiler: IEEE-754 arithmetic in the program's own type (FLT_EVAL_METHOD 0), no fused multiply-add
(-ffp-contract=off, the default of -std=c99), no -ffast-math. An emitted file refuses to compile with the last.
"""

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
    Param,
    Program,
    Return,
    Select,
    Status,
    Table,
    Var,
    entry_bits,
    uses_fixed,
    uses_split,
)
from stt_codegen.program.number import round_to, shortest
from stt_codegen.program.operations import BOOL, INT, REAL, STATUS, TICK, Type
from stt_codegen.program.targets.c.helpers import fixed_lines, split_lines
from stt_codegen.program.targets.printer import Printer


class CPrinter(Printer):
    """Prints C99; `real` is the name of the scalar's type in the emitted files."""

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.prefix = program.prefix
        self.macro = program.prefix.upper()
        self.real = "int32_t" if uses_fixed(program) else f"{self.prefix}_real"

    def helpers(self) -> list[str]:
        """Return the helper functions that operations of the program call."""
        if uses_fixed(self.program):
            return fixed_lines(self.prefix)
        return split_lines(self.prefix, self.program.scalar) if uses_split(self.program) else []

    # ---- names and literals

    def type_name(self, kind: Type) -> str:
        """Return the name of a type in C."""
        return {REAL: self.real, INT: "int32_t", TICK: "uint32_t", BOOL: "bool", STATUS: f"{self.prefix}_status"}[kind]

    def literal(self, constant: Const) -> str:
        """Return a constant as C writes it, a negative one in brackets."""
        value = constant.value
        if isinstance(value, Status):
            return f"{self.macro}_{value.name}"
        if isinstance(value, bool):
            return "true" if value else "false"
        if constant.type is INT:
            return f"({value})" if value < 0 else str(value)  # type: ignore[operator]
        if constant.type is TICK:
            return f"{value}U"
        if value is None:
            return f"({self.real})NAN"
        text = shortest(round_to(value, self.program.scalar), self.program.scalar)  # type: ignore[arg-type]
        text += "F" if self.program.scalar == "float" else ""
        return f"({text})" if text.startswith("-") else text

    def format_entry(self, constant: Const) -> str:
        """Return a number of a table, where a negative one needs no brackets."""
        return self.literal(constant).strip("()")

    # ---- expressions

    def array(self, name: str) -> str:
        """Return the name of a table, with the prefix, or of an array parameter."""
        return f"{self.prefix}_{name}" if self.is_table(name) else name

    def format_load(self, array: str, index: str) -> str:
        """Return an entry; one of a table of integers is read by a macro, since it may be in flash."""
        entry = super().format_load(array, index)
        table = next((t for t in self.program.tables if self.array(t.name) == array), None)
        if table is None or not uses_fixed(self.program):
            return entry
        return f"{self.macro}_READ_{entry_bits(table)}({entry})"

    def format_select(self, _select: Select, condition: str, then: str, otherwise: str) -> str:
        return f"{condition} ? {then} : {otherwise}"

    def format_finite(self, value: str) -> str:
        return f"isfinite({value}) != 0"

    def format_trunc(self, _operand: Operand, value: str) -> str:
        return f"(int32_t){value}"

    def format_math(self, name: str, args: Sequence[str]) -> str:
        """Return a call of the C library's function in the program's precision."""
        return f"{name}{'f' if self.program.scalar == 'float' else ''}({', '.join(args)})"

    def op_neg(self, a: str) -> str:
        return f"-{a}"

    def op_not(self, a: str) -> str:
        return f"!{a}"

    def op_real(self, a: str) -> str:
        return f"({self.real}){a}"

    def op_int(self, a: str) -> str:
        return f"(int32_t){a}"

    def op_exponent(self, a: str) -> str:
        return f"{self.prefix}_exponent({a})"

    def op_mantissa(self, a: str) -> str:
        return f"{self.prefix}_mantissa({a})"

    def op_high_product(self, a: str, b: str) -> str:
        return f"{self.prefix}_high_product({a}, {b})"

    def op_ishr(self, a: str, b: str) -> str:
        return f"{self.prefix}_shift_down({a}, {b})"

    def op_ishl(self, a: str, b: str) -> str:
        return f"{self.prefix}_shift_up({a}, {b})"

    def op_product(self, a: str, b: str) -> str:
        return f"{self.prefix}_product({a}, {b})"

    def op_ineg(self, a: str) -> str:
        return f"-{a}"

    def op_low_bits(self, a: str, mask: str) -> str:
        return f"{self.prefix}_low_bits({a}, {mask})"

    def op_short(self, a: str) -> str:
        return f"(int32_t)(int16_t){a}"

    def op_leading(self, a: str) -> str:
        return f"{self.prefix}_leading({a})"

    def op_eq(self, a: str, b: str) -> str:
        """Return a test for equality without ==, which -Wfloat-equal refuses; it is false for NaN too."""
        return f"({a} <= {b}) && ({b} <= {a})"

    def op_ne(self, a: str, b: str) -> str:
        return f"!({self.op_eq(a, b)})"

    # ---- statements

    def format_assign(self, var: Var, value: str) -> str:
        return f"const {self.type_name(var.type)} {var.name} = {value};"

    def format_set(self, var: Var, value: str) -> str:
        return f"{var.name} = {value};"

    def format_carry(self, carry: Carry) -> str:
        return f"{self.type_name(carry.var.type)} {carry.var.name} = {self.expression(carry.initial)};"

    def format_store(self, array: str, index: str, value: str) -> str:
        return f"{array}[{index}] = {value};"

    def format_for(self, index: Var, count: int) -> str:
        return f"for (int32_t {index.name} = 0; {index.name} < {count}; ++{index.name}) {{"

    def format_if(self, condition: str) -> str:
        return f"if ({condition}) {{"

    def format_end(self) -> list[str]:
        return ["}"]

    def format_leave(self, status: Expression | None) -> list[str]:
        return ["return;" if status is None else f"return {self.expression(status)};"]

    def leave(self, statement: Return) -> list[str]:
        """Return the lines of a way out; none at the end of a function that returns nothing."""
        return [] if statement.when is None and statement.status is None else super().leave(statement)

    def format_call(self, call: Call) -> list[str]:
        """Return a call: one result is its value, several go through pointers."""
        args = [self.expression(a) for a in call.args]
        name = f"{self.prefix}_{call.kernel}"
        if len(call.results) == 1:
            result = call.results[0]
            return [f"const {self.type_name(result.type)} {result.name} = {name}({', '.join(args)});"]
        lines = [f"{self.type_name(r.type)} {r.name};" for r in call.results]
        return [*lines, f"{name}({', '.join(args + [f'&{r.name}' for r in call.results])});"]

    # ---- tables, kernels, functions

    def table(self, table: Table) -> list[str]:
        """Return a table as a static array."""
        bits, flash = entry_bits(table) if table.type is INT else 32, f" {self.macro}_FLASH" if uses_fixed(self.program) else ""
        kind = f"uint{bits}_t" if bits < 32 else self.type_name(table.type)
        lines = [*self.comment(table.doc), f"static const {kind} {self.prefix}_{table.name}[{len(table.values)}]{flash} = {{"]
        lines += self.rows(table)
        lines[-1] = lines[-1].removesuffix(",")
        return [*lines, "};"]

    def kernel(self, kernel: Kernel) -> list[str]:
        """Return a kernel as a static function: one output is its value, several are written through pointers."""
        inputs = [f"{self.type_name(v.type)} {v.name}" for v in kernel.inputs]
        lines = self.comment(kernel.doc)
        if len(kernel.outputs) == 1:
            kind = self.type_name(kernel.outputs[0].type)
            lines += self.wrap(f"static inline {kind} {self.prefix}_{kernel.name}(", inputs, ")")
            return [*lines, "{", *self.statements(kernel.body), f"    return {self.expression(kernel.outputs[0])};", "}"]
        local_names = {v.name for v in kernel.inputs} | {a.var.name for a in kernel.body}
        names = [n + "_out" if n in local_names else n for n in kernel.output_names]
        pointers = [f"{self.type_name(o.type)} *{n}" for o, n in zip(kernel.outputs, names, strict=True)]
        lines += self.wrap(f"static inline void {self.prefix}_{kernel.name}(", inputs + pointers, ")")
        stores = [f"    *{n} = {self.expression(o)};" for n, o in zip(names, kernel.outputs, strict=True)]
        return [*lines, "{", *self.statements(kernel.body), *stores, "}"]

    def function(self, function: Function) -> list[str]:
        """Return a public function with its body."""
        return [*self.signature(function), "{", *self.statements(function.body), "}"]

    def prototype(self, function: Function) -> list[str]:
        """Return the declaration of a public function, with its comment."""
        lines = [*self.comment(function.doc), *self.signature(function)]
        lines[-1] += ";"
        return lines

    def signature(self, function: Function) -> list[str]:
        """Return the first lines of a public function: what it returns, its name, its parameters."""
        if function.returns_status:
            kind = f"{self.prefix}_status"
        else:
            kind = self.real if function.returns_real else "bool" if function.returns_bool else "void"
        return self.wrap(f"{kind} {self.prefix}_{function.name}(", [self.param(p) for p in function.params], ")")

    def param(self, param: Param) -> str:
        """Return the declaration of a parameter."""
        if param.length is None:
            return f"{self.type_name(param.type)} {param.name}"
        factor = param.length // self.program.dimension
        length = f"{self.macro}_N" if factor == 1 else f"{factor} * {self.macro}_N"
        return f"{'' if param.output else 'const '}{self.type_name(param.type)} {param.name}[{length}]"

    def wrap(self, head: str, parts: list[str], tail: str, width: int = 112) -> list[str]:
        """Return `head` + parts separated by commas + `tail`, broken under the opening parenthesis where too long."""
        lines, line = [], head
        for k, part in enumerate(parts):
            piece = part + (tail if k == len(parts) - 1 else ",")
            if len(line) + len(piece) + 1 > width and line.strip() != head.strip():
                lines.append(line.rstrip())
                line = " " * len(head)
            line += piece if line.endswith("(") or not line.strip() else " " + piece
        return [*lines, line]

    def comment(self, doc: tuple[str, ...]) -> list[str]:
        """Return lines of text as a comment."""
        if not doc:
            return []
        if len(doc) == 1:
            return [f"/* {doc[0]} */"]
        return [f"/* {doc[0]}", *(f" * {line}".rstrip() for line in doc[1:]), " */"]
