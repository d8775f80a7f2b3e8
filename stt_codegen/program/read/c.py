"""C back to Program: an independent parser (pycparser) reads the printed C, and the result must be the same Program.

    printed_form(program)   the Program as a reader of the C text can know it (printed_form.py)
    read_c(...)             the Program that the text of the .h and .c file is
    differences(...)        where the two differ, in words; empty when every function, literal and table entry agrees bit for bit

A printer that drops a minus sign or swaps two operands is found here, whatever else it agrees with. The idea is that of
Copilot's verifier: show that the generated C means what the specification means.

Long because it is a whole parser, and no part of it is used alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from pycparser import c_ast, c_parser

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
    Param,
    Program,
    Return,
    Select,
    Statement,
    Status,
    Store,
    Table,
    Trunc,
    Var,
    entry_bits,
    type_of,
)
from stt_codegen.program.number import round_to
from stt_codegen.program.operations import BOOL, INT, OPERATIONS, REAL, STATUS, TICK, Type
from stt_codegen.program.read.printed_form import printed_form
from stt_codegen.program.targets.c import fixed_lines, split_lines


class Unreadable(Exception):
    """C that no Program prints; the text says what and where."""


def differences(program: Program, header: str, source: str) -> list[str]:
    """Return how the Program in the C text differs from `program`: one line for each table, kernel and function that differs."""
    try:
        read_program = read_c(program.prefix, program.scalar, header, source)
    except Unreadable as error:
        return [f"{program.prefix}.c: {error}"]
    except c_parser.ParseError as error:
        return [f"{program.prefix}.c: is not C: {error}"]
    except (AttributeError, TypeError, ValueError, LookupError, OverflowError) as error:  # a syntax tree of another shape
        return [f"{program.prefix}.c: is not as any Program is printed ({type(error).__name__}: {error})"]
    expected = printed_form(program)
    lines = []
    for kind in ("tables", "kernels", "functions"):
        expected_parts = {part.name: part for part in getattr(expected, kind)}
        read_parts = {part.name: part for part in getattr(read_program, kind)}
        for name in {**expected_parts, **read_parts}:
            if expected_parts.get(name) != read_parts.get(name):
                lines.append(f"{program.prefix}.c: {kind.removesuffix('s')} {name} is not the one that was printed")
    if (expected.dimension, expected.scalar) != (read_program.dimension, read_program.scalar):
        lines.append(f"{program.prefix}.h: another dimension or scalar type")
    return lines


# ------------------------------------------------------------------------------------------- from the text

# The preprocessor lines that a printed source may have, with the task's prefix written as P.
_DIRECTIVE = re.compile(
    r'#include ("P\.h"|<(float|math|stdbool|stdint|string)\.h>)$|#error "P\.c: |#endif$'
    r"|#if defined\(__FAST_MATH__\) \|\| \(defined\(__FINITE_MATH_ONLY__\) && \(__FINITE_MATH_ONLY__ > 0\)\)$"
    r"|#if defined\(__ASSOCIATIVE_MATH__\) \|\| defined\(__RECIPROCAL_MATH__\)$"
    r"|#if defined\(__clang__\)$|#elif defined\(__GNUC__\)$"
    r'|#pragma (STDC FP_CONTRACT OFF|clang fp reassociate\(off\)|GCC optimize \("fp-contract=off"\))$'
    r"|#if defined\(FLT_EVAL_METHOD\) && \(FLT_EVAL_METHOD != 0\)( && \(FLT_EVAL_METHOD != 1\))? && \(FLT_EVAL_METHOD != 16\)$"
    r"|#if defined\((FLT_MANT_DIG\) && \(FLT_MANT_DIG != 24|DBL_MANT_DIG\) && \(DBL_MANT_DIG != 53)\)$"
)


def read_c(prefix: str, scalar: str, header: str, source: str) -> Program:
    """Return the Program of a .h and .c text. Raises `Unreadable` for C that no Program prints."""
    dimension = re.search(rf"^#define {prefix.upper()}_N (\d+)$", header, re.M)
    real = re.search(rf"^typedef (\w+) {prefix}_real;$", header, re.M)
    if not dimension or (not real and scalar != "fixed"):
        raise Unreadable("the header has no dimension or no scalar type")
    kind = real.group(1) if real else scalar
    code = _without_helpers(_without_comments(source), prefix, scalar, kind)
    for line in re.findall(r"^#.*$", code, re.M):
        if not _DIRECTIVE.match(line.replace(prefix, "P")):
            raise Unreadable(f"the line {line!r}")
    code = re.sub(r"^#.*$", "", code, flags=re.M).replace(f"{prefix.upper()}_N", dimension.group(1))
    reader = _CReader(prefix, kind, int(dimension.group(1)))
    for part in c_parser.CParser().parse(_type_declarations(prefix, kind) + code).ext:
        reader.read_part(part)
    return Program(prefix, reader.dimension, kind, tuple(reader.tables), tuple(reader.kernels), functions=tuple(reader.functions))


def _without_comments(text: str) -> str:
    return re.sub(r"/\*.*?\*/", "", text, flags=re.S)


def _without_helpers(code: str, prefix: str, scalar: str, kind: str) -> str:
    """Return the code without the helper functions, which are no part of a Program. They must be there exactly as printed."""
    helper_lines = fixed_lines(prefix) if kind == "fixed" else split_lines(prefix, scalar)
    helpers = _without_comments("\n".join(helper_lines))
    calls_split = f"{prefix}_exponent(" in code or f"{prefix}_mantissa(" in code
    if code.count(helpers) != (kind == "fixed" or calls_split):
        subject = "what integers are counted with" if kind == "fixed" else "the split into exponent and mantissa"
        raise Unreadable(f"{subject} is not the one that was printed")
    return code.replace(helpers, "").replace(f"{prefix.upper()}_FLASH", "")


def _type_declarations(prefix: str, kind: str) -> str:
    """Return C that declares the types of the printed source, for a parser that reads no header."""
    real = "int" if kind == "fixed" else kind
    return (
        "typedef int int32_t; typedef unsigned uint32_t; typedef int bool; typedef char uint8_t; typedef short uint16_t;"
        f"typedef short int16_t; typedef {real} {prefix}_real; typedef int {prefix}_status;\n"
    )


# Helper functions of integer programs by their name in C without the prefix, each with the operation that it is.
INTEGER_HELPERS = {
    "shift_down": "ishr",
    "shift_up": "ishl",
    **{name: name for name in ("product", "high_product", "low_bits", "leading")},
}


@dataclass
class _Body:
    """What was read of a body so far: statements, the outputs of a kernel, and carried values whose loop is still to come."""

    statements: list[Statement] = field(default_factory=list)
    outputs: list[Operand] = field(default_factory=list)
    carries: list[Carry] = field(default_factory=list)


class _CReader:
    """Reads a syntax tree of pycparser into tables, kernels and functions.

    types: of the names of the function being read. pointers: the output parameters of a kernel, in order. table_bits: width of
    the entries of each table of integers.
    """

    def __init__(self, prefix: str, scalar: str, dimension: int) -> None:
        self.prefix, self.scalar, self.dimension = prefix, scalar, dimension
        self.tables: list[Table] = []
        self.kernels: list[Kernel] = []
        self.functions: list[Function] = []
        self.split_helpers = {f"{prefix}_exponent", f"{prefix}_mantissa"}
        self.integer_helpers = {f"{prefix}_{name}": op for name, op in INTEGER_HELPERS.items()} if scalar == "fixed" else {}
        self.table_bits: dict[str, int] = {}
        self.types: dict[str, Type] = {}
        self.pointers: list[str] = []

    def read_part(self, node: Any) -> None:
        """Read one declaration of the file: a table, a kernel or a function; type definitions are skipped."""
        match node:
            case c_ast.Typedef():
                return
            case c_ast.Decl(type=c_ast.ArrayDecl()):
                self.tables.append(self.table(node))
            case c_ast.FuncDef():
                self.read_function(node)
            case _:
                raise Unreadable(f"a {type(node).__name__} where a table or function should be, {node.coord}")

    def without_prefix(self, name: str) -> str:
        """Return a name without the task's prefix. Raises `Unreadable` where it has none."""
        if not name.startswith(f"{self.prefix}_"):
            raise Unreadable(f"the name {name} does not begin with {self.prefix}_")
        return name.removeprefix(f"{self.prefix}_")

    def declared_type(self, node: Any) -> Type:
        """Return the Program's type of a declared C type."""
        names = {f"{self.prefix}_real": REAL, "int32_t": INT, "uint32_t": TICK, "bool": BOOL, f"{self.prefix}_status": STATUS}
        text = " ".join(node.type.names)
        if text not in names:
            raise Unreadable(f"the type {text}, {node.coord}")
        return names[text]

    def table(self, node: Any) -> Table:
        """Return a table of constants, and note the width of its entries."""
        if node.quals != ["const"] or node.storage != ["static"]:
            raise Unreadable(f"{node.name} is not static const")
        is_integer = self.scalar == "fixed"
        values = tuple(self.integer(v) if is_integer else self.number(v) for v in node.init.exprs)
        if int(node.type.dim.value) != len(values):
            raise Unreadable(f"{node.name} has {len(values)} entries, not {node.type.dim.value}")
        table = Table(self.without_prefix(node.name), values, 0, type=INT if is_integer else REAL)
        c_type = " ".join(node.type.type.type.names)
        bits = entry_bits(table) if is_integer else 32
        if c_type != ((f"uint{bits}_t" if bits < 32 else "int32_t") if is_integer else f"{self.prefix}_real"):
            raise Unreadable(f"{node.name} is a table of {c_type}")
        self.table_bits[table.name] = bits
        return table

    def integer(self, node: Any) -> Fraction:
        """Return an integer literal, negative ones included."""
        if isinstance(node, c_ast.UnaryOp) and node.op == "-":
            return -self.integer(node.expr)
        if not isinstance(node, c_ast.Constant) or not node.value.isdigit():
            raise Unreadable(f"no whole number, {node.coord}")
        return Fraction(node.value)

    def number(self, node: Any) -> Fraction:
        """Return a floating-point literal as the compiler rounds it, negative ones included."""
        if isinstance(node, c_ast.UnaryOp) and node.op == "-":
            return -self.number(node.expr)
        if not isinstance(node, c_ast.Constant) or not re.fullmatch(r"\d+\.\d*(e-?\d+)?F?", node.value):
            raise Unreadable(f"no number, {node.coord}")
        if node.value.endswith("F") != (self.scalar == "float"):
            raise Unreadable(f"the literal {node.value} is not of type {self.scalar}, {node.coord}")
        return round_to(Fraction(node.value.rstrip("F")), self.scalar)

    @property
    def number_kind(self) -> Type:
        """The Program's type of the entries of arrays and tables."""
        return INT if self.scalar == "fixed" else REAL

    # ---- expressions

    def operand(self, node: Any) -> Operand:
        """Return a variable or constant. Raises `Unreadable` for an expression of operations."""
        value = self.expression(node)
        if not isinstance(value, Var | Const):
            raise Unreadable(f"more than one operation in a statement, {node.coord}")
        return value

    def expression(self, node: Any) -> Expression:
        """Return the expression of a syntax node."""
        match node:
            case c_ast.ID():
                return self.name_or_status(node)
            case c_ast.Constant():
                return self.constant(node)
            case c_ast.UnaryOp(op="-"):
                return self.negation(node)
            case c_ast.UnaryOp(op="!", expr=c_ast.BinaryOp(op="&&") as equality):
                return Op("ne", self.equality_operands(equality))
            case c_ast.UnaryOp(op="!"):
                return Op("not", (self.operand(node.expr),))
            case c_ast.TernaryOp():
                return Select(self.operand(node.cond), self.operand(node.iftrue), self.operand(node.iffalse))
            case c_ast.BinaryOp():
                return self.binary(node)
            case c_ast.Cast():
                return self.cast(node)
            case c_ast.ArrayRef():
                array = node.name.name
                name = array if array in self.types else self.without_prefix(array)
                return Load(name, self.operand(node.subscript), self.number_kind)
            case c_ast.FuncCall(name=c_ast.ID(name=name)):
                return self.helper_or_library_call(name, node)
        raise _unreadable(node)

    def name_or_status(self, node: Any) -> Operand:
        """Return a truth value, a status or a variable."""
        name, macro = node.name, f"{self.prefix.upper()}_"
        if name in ("true", "false"):
            return Const(name == "true", BOOL)
        if name.startswith(macro):
            return Const(Status[name.removeprefix(macro)], STATUS)
        if name in self.types:
            return Var(name, self.types[name])
        raise _unreadable(node)

    def constant(self, node: Any) -> Const:
        """Return a literal that is not negative: an integer, a count of ticks (with a U behind it) or a number."""
        text = node.value
        if text.isdigit():
            return Const(int(text), INT)
        if text[:-1].isdigit() and text.endswith("U"):
            return Const(int(text[:-1]), TICK)
        return Const(self.number(node))

    def negation(self, node: Any) -> Expression:
        """Return a negative literal, or the negative of an operand."""
        match node.expr:
            case c_ast.Constant(value=text) if text.isdigit():
                return Const(-int(text), INT)
            case c_ast.Constant():
                return Const(self.number(node))
        value = self.operand(node.expr)
        return Op("ineg" if value.type is INT else "neg", (value,))

    def binary(self, node: Any) -> Expression:
        """Return the operation of an infix sign, a test for finiteness or a test for equality."""
        match node:
            case c_ast.BinaryOp(
                op="!=", left=c_ast.FuncCall(name=c_ast.ID(name="isfinite"), args=args), right=c_ast.Constant(value="0")
            ):
                return IsFinite(self.operand(args.exprs[0]))
            case c_ast.BinaryOp(op="&&", left=c_ast.BinaryOp()):
                return Op("eq", self.equality_operands(node))
        a, b = self.operand(node.left), self.operand(node.right)
        names = [name for name, row in OPERATIONS.items() if row.infix == node.op and row.args == (a.type, b.type)]
        if not names:
            raise Unreadable(f"{a.type.value} {node.op} {b.type.value}, {node.coord}")
        return Op(names[0], (a, b))

    def equality_operands(self, node: Any) -> tuple[Operand, Operand]:
        """Return the operands of (a <= b) && (b <= a), which is how equality of reals is printed."""
        left, right = self.expression(node.left), self.expression(node.right)
        if not (
            isinstance(left, Op) and isinstance(right, Op) and left.name == right.name == "le" and left.args == right.args[::-1]
        ):
            raise Unreadable(f"a conjunction that is no comparison for equality, {node.coord}")
        return left.args[0], left.args[1]

    def cast(self, node: Any) -> Expression:
        """Return the operation of a conversion: `short`, NaN, `int`, truncation or `real`."""
        match node.expr:
            case c_ast.Cast(expr=narrowed) if self.scalar == "fixed":
                outer_type, inner_type = (" ".join(c.to_type.type.type.names) for c in (node, node.expr))
                if (outer_type, inner_type) != ("int32_t", "int16_t"):
                    raise Unreadable(f"a {inner_type} made {outer_type}, {node.coord}")
                return Op("short", (self.operand(narrowed),))
            case c_ast.ID(name="NAN"):
                return Const(None)
        value = self.operand(node.expr)
        if self.declared_type(node.to_type.type) is INT:
            return Op("int", (value,)) if value.type is TICK else Trunc(value)
        return Op("real", (value,))

    def helper_or_library_call(self, name: str, node: Any) -> Expression:
        """Return the operation of a call within an expression: of a printed helper function, or of the C library."""
        if name in self.integer_helpers:
            return Op(self.integer_helpers[name], tuple(map(self.operand, node.args.exprs)))
        if name.startswith(f"{self.prefix.upper()}_READ_"):
            (argument,) = node.args.exprs
            load = self.expression(argument)
            if not isinstance(load, Load) or self.table_bits.get(load.array) != int(name.rpartition("_")[2]):
                raise Unreadable(f"{name} of something else, {node.coord}")
            return load
        if name in self.split_helpers:
            return Op(self.without_prefix(name), tuple(map(self.operand, node.args.exprs)))
        operation = name.removesuffix("f") if self.scalar == "float" else name
        if operation not in {row.call for row in OPERATIONS.values() if row.call}:
            raise Unreadable(f"the function {name}, {node.coord}")
        return Op(operation, tuple(map(self.operand, node.args.exprs)))

    # ---- statements

    def body(self, nodes: Iterable[Any], is_kernel: bool) -> _Body:
        """Return the statements of a body; of a kernel also what it stores or returns."""
        body = _Body()
        for node in nodes or ():
            match node:
                case c_ast.Decl():
                    self.read_declaration(node, body)
                case c_ast.Assignment(op="="):
                    self.read_assignment(node, body)
                case c_ast.For():
                    body.statements.append(self.loop(node, body.carries))
                    body.carries = []
                case c_ast.If(iffalse=None):
                    body.statements.append(self.early_leave(node))
                case c_ast.FuncCall(name=c_ast.ID(name=name), args=args):
                    inputs = tuple(self.operand(a) for a in args.exprs if not isinstance(a, c_ast.UnaryOp) or a.op != "&")
                    results = tuple(self.call_result(a) for a in args.exprs[len(inputs) :])
                    body.statements.append(Call(results, self.without_prefix(name), inputs))
                case c_ast.Return(expr=None):
                    body.statements.append(Return())
                case c_ast.Return(expr=value) if is_kernel:
                    body.outputs.append(self.operand(value))
                case c_ast.Return(expr=value):
                    body.statements.append(Return(self.expression(value)))
                case _:
                    raise _unreadable(node)
        if body.carries:
            raise Unreadable(f"{body.carries[0].var.name} is changed by no loop")
        return body

    def read_declaration(self, node: Any, body: _Body) -> None:
        """Read a local variable: the result of a later call, of a call, of an assignment, or a value that a loop carries."""
        match node:
            case c_ast.Decl(init=None):
                self.declare(node)
            case c_ast.Decl(quals=["const"], init=c_ast.FuncCall(name=c_ast.ID(name=name), args=args)) if (
                name.startswith(f"{self.prefix}_") and name not in self.split_helpers and name not in self.integer_helpers
            ):
                inputs = tuple(map(self.operand, args.exprs))
                body.statements.append(Call((self.declare(node),), self.without_prefix(name), inputs))
            case c_ast.Decl(quals=["const"]):
                value = self.expression(node.init)
                var = self.declare(node)
                if type_of(value) is not var.type:
                    raise Unreadable(f"{node.name} is declared with another type than its value has")
                body.statements.append(Assign(var, value))
            case c_ast.Decl(quals=[]):
                initial = self.operand(node.init)
                var = self.declare(node)
                body.carries.append(Carry(var, initial, var))
            case _:
                raise _unreadable(node)

    def read_assignment(self, node: Any, body: _Body) -> None:
        """Read a store: through a kernel's output pointer, or to an entry of an output array."""
        match node.lvalue:
            case c_ast.UnaryOp(op="*", expr=c_ast.ID(name=name)):
                if self.pointers[len(body.outputs) : len(body.outputs) + 1] != [name]:
                    raise Unreadable(f"{name} is not the next output, {node.coord}")
                body.outputs.append(self.operand(node.rvalue))
            case c_ast.ArrayRef() as entry:
                body.statements.append(Store(entry.name.name, self.operand(entry.subscript), self.operand(node.rvalue)))
            case _:
                raise _unreadable(node)

    def early_leave(self, node: Any) -> Return:
        """Return the `if` of a Program, which ends by leaving the function."""
        statements = self.body(node.iftrue.block_items, is_kernel=False).statements
        leave = statements.pop() if statements and isinstance(statements[-1], Return) else None
        if not isinstance(leave, Return):
            raise Unreadable(f"an if that does not leave, {node.coord}")
        return Return(leave.status, self.operand(node.cond), tuple(statements))

    def declare(self, node: Any) -> Var:
        """Note the type of a local variable, and return it."""
        self.types[node.name] = self.declared_type(node.type)
        return Var(node.name, self.types[node.name])

    def call_result(self, node: Any) -> Var:
        """Return the variable whose address a call takes."""
        if not (isinstance(node, c_ast.UnaryOp) and node.op == "&"):
            raise Unreadable(f"an argument after the results, {node.coord}")
        return Var(node.expr.name, self.types[node.expr.name])

    def loop(self, node: Any, carries: list[Carry]) -> For:
        """Return a loop that counts up from 0; its last statements set the next values of these carried variables."""
        start, stop, step = node.init.decls[0], node.cond, node.next
        counts_up = step.op == "++" and step.expr.name == start.name and (stop.op, stop.left.name) == ("<", start.name)
        if not counts_up or start.init.value != "0":
            raise Unreadable(f"a loop that does not count up from 0, {node.coord}")
        index = self.declare(start)
        nodes = list(node.stmt.block_items)
        updates = nodes[len(nodes) - len(carries) :]
        names = [c.var.name for c in carries]
        if [u.lvalue.name for u in updates if isinstance(u, c_ast.Assignment) and isinstance(u.lvalue, c_ast.ID)] != names:
            raise Unreadable(f"the loop's end does not change {', '.join(names)}, {node.coord}")
        statements = self.body(nodes[: len(nodes) - len(carries)], is_kernel=False).statements
        next_values = {update.lvalue.name: self.operand(update.rvalue) for update in updates}
        updated = tuple(Carry(c.var, c.initial, next_values[c.var.name]) for c in carries)
        return For(index, int(stop.right.value), tuple(statements), updated)

    # ---- functions

    def read_function(self, node: Any) -> None:
        """Read a kernel (static) or a public function."""
        declared = node.decl
        name, is_kernel = self.without_prefix(declared.name), "static" in declared.storage
        self.types, self.pointers = {}, []
        params = self.parameters(declared.type.args.params)
        body = self.body(node.body.block_items, is_kernel)
        returned = declared.type.type.type.names
        number_type = "int32_t" if self.scalar == "fixed" else f"{self.prefix}_real"
        allowed = ["void", number_type, *(["int32_t", "bool"] if is_kernel else [f"{self.prefix}_status", "bool"])]
        if len(returned) != 1 or returned[0] not in allowed or declared.funcspec != ["inline"] * is_kernel:
            raise Unreadable(f"{name} is declared {' '.join([*declared.storage, *declared.funcspec, *returned])}, {node.coord}")
        if is_kernel:
            assigns = tuple(s for s in body.statements if isinstance(s, Assign))
            if len(assigns) != len(body.statements):
                raise Unreadable(f"the kernel {name} is not straight")
            inputs = tuple(Var(p.name, p.type) for p in params if p.length is None)
            self.kernels.append(Kernel(name, inputs, assigns, tuple(body.outputs), ()))
            return
        self.functions.append(
            Function(
                name,
                tuple(params),
                tuple(body.statements),
                returned == [f"{self.prefix}_status"],
                (),
                returns_real=returned == [number_type],
                returns_bool=returned == ["bool"],
            )
        )

    def parameters(self, nodes: Iterable[Any]) -> list[Param]:
        """Return scalar and array parameters, and note their types; a kernel's output pointers are noted apart."""
        params = []
        for node in nodes:
            match node.type:
                case c_ast.ArrayDecl(dim=dim, type=inner):
                    self.types[node.name] = self.declared_type(inner)
                    params.append(Param(node.name, self.length(dim), "const" not in inner.quals, type=self.number_kind))
                case c_ast.PtrDecl():
                    self.pointers.append(node.name)
                case _:
                    params.append(Param(node.name, None, type=self.declare(node).type))
        return params

    def length(self, node: Any) -> int:
        """Return the length of an array parameter: a number or a product of numbers."""
        if isinstance(node, c_ast.BinaryOp) and node.op == "*":
            return self.length(node.left) * self.length(node.right)
        return int(node.value)


def _unreadable(node: Any) -> Unreadable:
    return Unreadable(f"a {type(node).__name__}, {node.coord}")
