"""Program to Rust: one `no_std` module of safe code, in the program's own precision. A function returns its outputs.

Assumed of the compiler: IEEE-754 arithmetic without fused multiply-add, which is what Rust defines. A function of mathematics is
that of `std` (the C library's, on most systems), or of the crate `libm` where there is no `std`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stt_codegen.program.nodes import (
    Assign,
    Call,
    Carry,
    Const,
    Expression,
    For,
    Function,
    Kernel,
    Op,
    Operand,
    Param,
    Program,
    Return,
    Select,
    Statement,
    Status,
    Store,
    Table,
    Var,
    operands,
    uses_split,
)
from stt_codegen.program.number import round_to, shortest
from stt_codegen.program.operations import BOOL, INT, OPERATIONS, REAL, STATUS, TICK, Type
from stt_codegen.program.targets.printer import INDENT, Printer

_BIT_LAYOUTS = {  # width of a number, width of its fraction, and the bits of 1/sqrt 2
    "float": (32, 23, "0x3f35_04f3"),
    "double": (64, 52, "0x3fe6_a09e_667f_3bcd"),
}
# Names in `std` that differ from those of C.
_STD_NAMES = {"log": "ln", "log1p": "ln_1p", "expm1": "exp_m1", "pow": "powf"}


class RustPrinter(Printer):
    """Prints Rust. Arrays come in as references and go out as values; one that is read and changed is a mutable reference."""

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.real = {"float": "f32", "double": "f64"}[self.program.scalar]

    # ---- helper functions

    def library(self) -> list[str]:
        """Return the functions of mathematics that some kernel calls, by their names in C."""
        values = [a.value for kernel in self.program.kernels for a in kernel.body]
        used = {OPERATIONS[v.name].call for v in values if isinstance(v, Op)} - {"", "fabs"}
        return sorted(used)

    def helpers(self) -> list[list[str]]:
        """Return the helper functions that operations of the program call, each as a list of lines."""
        functions = [self._library_function(name) for name in self.library()]
        bits, _, _ = _BIT_LAYOUTS[self.program.scalar]
        if any(isinstance(a.value, Op) and a.value.name == "fabs" for k in self.program.kernels for a in k.body):
            sign_mask = f"0x7{'f' * (bits // 4 - 1)}"
            functions.append(["#[inline]", "fn fabs(x: Real) -> Real {", f"    Real::from_bits(x.to_bits() & {sign_mask})", "}"])
        return functions + (self._split_functions() if uses_split(self.program) else [])

    def _library_function(self, name: str) -> list[str]:
        """Return a function of mathematics, C's name of it, that calls `std` or, without it, the crate `libm`."""
        is_binary = OPERATIONS[name].args == (REAL, REAL)
        head = f"fn {name}(x: Real, y: Real) -> Real {{" if is_binary else f"fn {name}(x: Real) -> Real {{"
        std_name = _STD_NAMES.get(name, name)
        libm_name = name + ("f" if self.program.scalar == "float" else "")
        return [
            '#[cfg(feature = "std")]', "#[inline]", head, f"    x.{std_name}({'y' if is_binary else ''})", "}", "",
            '#[cfg(all(feature = "libm", not(feature = "std")))]', "#[inline]", head,
            f"    libm::{libm_name}(x{', y' if is_binary else ''})", "}",
        ]  # fmt: skip

    def _split_functions(self) -> list[list[str]]:
        """Return the functions of the operations `exponent` and `mantissa`."""
        _, shift, smallest = _BIT_LAYOUTS[self.program.scalar]
        return [
            [
                "/// y = m 2^e with m in [1/sqrt 2, sqrt 2), for y not below that: e.", "#[inline]",
                "fn exponent(y: Real) -> i32 {", f"    ((y.to_bits() - {smallest}) >> {shift}) as i32", "}",
            ],
            [
                "/// And m.", "#[inline]", "fn mantissa(y: Real) -> Real {",
                f"    Real::from_bits(((y.to_bits() - {smallest}) & 0x{(1 << shift) - 1:x}) + {smallest})", "}",
            ],
        ]  # fmt: skip

    # ---- names and literals

    def type_name(self, kind: Type) -> str:
        """Return the name of a type in Rust."""
        return {REAL: "Real", INT: "i32", TICK: "u32", BOOL: "bool", STATUS: "Status"}[kind]

    def status(self, status: Status) -> str:
        """Return the name of a status as Rust writes it: OutsideTube."""
        return "".join(word.capitalize() for word in status.name.split("_"))

    def literal(self, constant: Const) -> str:
        """Return a constant as Rust writes it."""
        value = constant.value
        if isinstance(value, Status):
            return f"Status::{self.status(value)}"
        if isinstance(value, bool):
            return "true" if value else "false"
        if constant.type in (INT, TICK):
            return str(value)
        if value is None:
            return "Real::NAN"
        return shortest(round_to(value, self.program.scalar), self.program.scalar)  # type: ignore[arg-type]

    def array(self, name: str) -> str:
        """Return the name of a table, in capitals, or of an array parameter."""
        return name.upper() if self.is_table(name) else name

    # ---- expressions: operands are names and numbers, so only a negative number needs brackets

    def format_load(self, array: str, index: str) -> str:
        return f"{array}[{self.index(index)}]"

    def index(self, index: str) -> str:
        """Return an index as Rust needs it, of type usize."""
        return index if index.isdigit() else f"{index} as usize"

    def format_select(self, _select: Select, condition: str, then: str, otherwise: str) -> str:
        return f"if {condition} {{ {then} }} else {{ {otherwise} }}"

    def format_finite(self, value: str) -> str:
        return f"{value}.is_finite()"

    def format_trunc(self, _operand: Operand, value: str) -> str:
        return f"{value} as i32"

    def format_math(self, name: str, args: Sequence[str]) -> str:
        return f"{name}({', '.join(args)})"

    def op_neg(self, a: str) -> str:
        return f"-({a})" if a.startswith("-") else f"-{a}"

    def op_not(self, a: str) -> str:
        return f"!{a}"

    def op_real(self, a: str) -> str:
        return f"{a} as Real"

    def op_int(self, a: str) -> str:
        return f"{a} as i32"

    def op_exponent(self, a: str) -> str:
        return f"exponent({a})"

    def op_mantissa(self, a: str) -> str:
        return f"mantissa({a})"

    def op_eq(self, a: str, b: str) -> str:
        return f"{a} == {b}"

    def op_ne(self, a: str, b: str) -> str:
        return f"{a} != {b}"

    # ---- statements

    def format_assign(self, var: Var, value: str) -> str:
        return f"let {var.name}: {self.type_name(var.type)} = {value};"

    def format_set(self, var: Var, value: str) -> str:
        return f"{var.name} = {value};"

    def format_carry(self, carry: Carry) -> str:
        return f"let mut {carry.var.name}: {self.type_name(carry.var.type)} = {self.expression(carry.initial)};"

    def format_store(self, array: str, index: str, value: str) -> str:
        return f"{array}[{self.index(index)}] = {value};"

    def format_for(self, index: Var, count: int) -> str:
        return f"for {self._bound(index)} in 0..{count} {{"

    def format_if(self, condition: str) -> str:
        return f"if {condition} {{"

    def format_end(self) -> list[str]:
        return ["}"]

    def format_call(self, call: Call) -> list[str]:
        names = [self._bound(r) for r in call.results]
        pattern = names[0] if len(names) == 1 else f"({', '.join(names)})"
        # The kernel goes by its path, for an argument may have its name.
        return [f"let {pattern} = self::{call.kernel}({', '.join(self.expression(a) for a in call.args)});"]

    def _bound(self, var: Var) -> str:
        """Return the name of a variable; one that nothing reads begins with an underscore, or the compiler warns."""
        return var.name if self.inside is None or var.name in self._read_names else f"_{var.name}"

    def format_leave(self, status: Expression | None) -> list[str]:
        value = self._returned(status)
        return [f"return {value};" if value else "return;"]

    def leave(self, statement: Return) -> list[str]:
        """Return the lines of a way out; at the end of a function its value alone, without `return`."""
        if statement.when is None:
            value = self._returned(statement.status)
            return [value] if value else []
        return super().leave(statement)

    def _returned(self, status: Expression | None) -> str:
        assert self.inside is not None
        parts = [p.name for p in self.inside.outputs if not p.inout]
        parts += [self.expression(status)] if status is not None else []
        return parts[0] if len(parts) == 1 else f"({', '.join(parts)})" if parts else ""

    # ---- tables, kernels, functions

    def table(self, table: Table) -> list[str]:
        """Return a table as a static array, with its comment."""
        head = f"static {table.name.upper()}: [Real; {len(table.values)}] = ["
        return [*self.comment(table.doc, "//"), head, *self.rows(table), "];"]

    def numbers(self, table: Table, row: int) -> str:
        """Return the numbers of one row of a table, with commas between them."""
        return ", ".join(self.literal(Const(v)) for v in table.values[row * table.row : (row + 1) * table.row])

    def kernel(self, kernel: Kernel) -> list[str]:
        """Return a kernel as a private function; several outputs are a tuple."""
        inputs = [f"{v.name}: {self.type_name(v.type)}" for v in kernel.inputs]
        kinds, values = [self.type_name(o.type) for o in kernel.outputs], [self.expression(o) for o in kernel.outputs]
        kind, value = (kinds[0], values[0]) if len(kinds) == 1 else (f"({', '.join(kinds)})", f"({', '.join(values)})")
        head = self.signature(f"fn {kernel.name}", inputs, f" -> {kind}")
        return [*self.comment(kernel.doc, "//"), "#[inline]", *head, *self.statements(kernel.body), INDENT + value, "}"]

    def function(self, function: Function) -> list[str]:
        """Return a public function; it returns its arrays and its status, real or truth value as a tuple."""
        self.inside, self._read_names = function, set(_names_read(function.body))
        kinds = [f"[Real; {p.length}]" for p in function.outputs if not p.inout]
        kinds += ["Status"] * function.returns_status + ["Real"] * function.returns_real + ["bool"] * function.returns_bool
        kind = kinds[0] if len(kinds) == 1 else f"({', '.join(kinds)})" if kinds else ""
        pure = not any(p.inout for p in function.params)
        lines = [*self.comment(function.doc, "///"), *(["#[must_use]"] if pure and kind else [])]
        inputs = [self.param(p) for p in function.params if not p.output or p.inout]
        lines += self.signature(f"pub fn {function.name}", inputs, f" -> {kind}" if kind else "")
        lines += [f"    let mut {p.name}: [Real; {p.length}] = [0.0; {p.length}];" for p in function.outputs if not p.inout]
        lines += [*self.statements(function.body), "}"]
        self.inside = None
        return lines

    def param(self, param: Param) -> str:
        """Return the declaration of a parameter."""
        if param.length is None:
            return f"{param.name}: {self.type_name(param.type)}"
        return f"{param.name}: &{'mut ' if param.inout else ''}[Real; {param.length}]"

    def signature(self, name: str, inputs: Sequence[str], result: str) -> list[str]:
        """Return a signature on one line, or where that is too long on one line for each argument, as rustfmt does."""
        line = f"{name}({', '.join(inputs)}){result} {{"
        return [line] if len(line) <= 100 else [f"{name}(", *(f"    {i}," for i in inputs), f"){result} {{"]

    def comment(self, doc: tuple[str, ...], mark: str) -> list[str]:
        """Return lines of text as a comment that begins with `mark`."""
        return [f"{mark} {line}".rstrip() for line in doc]


def _names_read(body: Sequence[Statement]) -> Iterator[str]:
    """Yield the names that a body reads."""
    for statement in body:
        read: Sequence[Expression] = ()
        match statement:
            case Assign(value=value):
                read = (value,)
            case Call(args=args):
                read = args
            case Store(index=index, value=value):
                read = (index, value)
            case For(body=inner, carries=carries):
                read = [v for c in carries for v in (c.initial, c.next)]
                yield from _names_read(inner)
            case Return(status=status, when=when, body=inner):
                read = [v for v in (status, when) if v is not None]
                yield from _names_read(inner)
        yield from (v.name for e in read for v in (e, *operands(e)) if isinstance(v, Var))
