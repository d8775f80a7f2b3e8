"""C back to Program: what was printed is read again by an independent parser (pycparser) and must be the same Program.

    printed(program)   the Program as a reader of the C text can know it: constants rounded, no comments
    read_c(...)        the same from the text of the .h and .c file
    differences(...)   where they differ, in words; empty when every function, literal and table entry is the same, bit for bit

A printer that drops a minus sign or swaps two operands is found here, whatever else it agrees with. The idea is that of
Copilot's verifier: show that the generated C means what the specification means.

Long because it is a whole parser, and no part of it is used alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
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
from stt_codegen.program.targets.c import fixed_lines, split_lines


class Unreadable(Exception):
    """C that no Program prints, with the place."""


def differences(program: Program, header: str, source: str) -> list[str]:
    """How the Program in the C text differs from `program`: one line for each table, kernel and function that is another."""
    try:
        found = read_c(program.prefix, program.scalar, header, source)
    except Unreadable as error:
        return [f"{program.prefix}.c: {error}"]
    except c_parser.ParseError as error:
        return [f"{program.prefix}.c: is not C: {error}"]
    except (AttributeError, TypeError, ValueError, LookupError, OverflowError) as error:  # a syntax tree of another shape
        return [f"{program.prefix}.c: is not as any Program is printed ({type(error).__name__}: {error})"]
    want = printed(program)
    lines = []
    for kind in ("tables", "kernels", "functions"):
        ours = {part.name: part for part in getattr(want, kind)}
        theirs = {part.name: part for part in getattr(found, kind)}
        for name in {**ours, **theirs}:
            if ours.get(name) != theirs.get(name):
                lines.append(f"{program.prefix}.c: {kind.removesuffix('s')} {name} is not the one that was printed")
    if (want.dimension, want.scalar) != (found.dimension, found.scalar):
        lines.append(f"{program.prefix}.h: another dimension or scalar type")
    return lines


# ------------------------------------------------------------------------------- what a reader can know


def printed(program: Program) -> Program:
    """The Program with constants as they are printed, without comments and names that C does not have."""

    def constant(value: Any) -> Any:
        match value:
            case Const(type=t, value=Fraction() as number) if t is REAL:
                return Const(round_to(number, program.scalar))
            case Op(name="neg", args=(Const() as c,)):
                return Const(-constant(c).value)
            case Op(name=name, args=args):
                return Op(name, tuple(map(constant, args)))
            case Select(condition=c, then=a, other=b):
                return Select(constant(c), constant(a), constant(b))
            case IsFinite(arg=a):
                return IsFinite(constant(a))
            case Trunc(arg=a):
                return Trunc(constant(a))
            case Load(array=array, index=i):
                return Load(array, constant(i), value.type)
        return value

    def statement(s: Statement) -> Statement:
        match s:
            case Assign(var=var, value=value):
                return Assign(var, constant(value))
            case Call(results=results, kernel=kernel, args=args):
                return Call(results, kernel, tuple(map(constant, args)))
            case Store(array=array, index=i, value=value):
                return Store(array, constant(i), constant(value))
            case For(index=index, count=count, body=body, carries=carries):
                kept = tuple(Carry(c.var, constant(c.initial), constant(c.next)) for c in carries)
                return For(index, count, statements(body), kept)
            case Return(status=status, when=when, body=body):
                return Return(constant(status), constant(when), statements(body))

    def statements(body: Iterable[Statement]) -> tuple[Statement, ...]:
        found = tuple(map(statement, body))
        return found[:-1] if found and found[-1] == Return() else found

    return replace(
        program,
        tables=tuple(
            Table(t.name, t.values if t.type is INT else tuple(round_to(v, program.scalar) for v in t.values), 0, type=t.type)
            for t in program.tables
        ),
        tick=None,
        kernels=tuple(
            Kernel(k.name, k.inputs, tuple(map(statement, k.body)), tuple(map(constant, k.outputs)), ())  # type: ignore[arg-type]
            for k in program.kernels
        ),
        functions=tuple(
            replace(
                f, params=tuple(Param(p.name, p.length, p.output, type=p.type) for p in f.params), body=statements(f.body), doc=()
            )
            for f in program.functions
        ),
    )


# ------------------------------------------------------------------------------------------- from the text

_DIRECTIVE = re.compile(
    r'#include ("P\.h"|<(float|math|stdbool|stdint|string)\.h>)$|#error "P\.c: |#endif$'
    r"|#if defined\(__FAST_MATH__\) \|\| \(defined\(__FINITE_MATH_ONLY__\) && \(__FINITE_MATH_ONLY__ > 0\)\)$"
    r"|#if defined\(FLT_EVAL_METHOD\) && \(FLT_EVAL_METHOD != 0\)( && \(FLT_EVAL_METHOD != 1\))?$"
)


def read_c(prefix: str, scalar: str, header: str, source: str) -> Program:
    """The Program of a .h and .c text. Raises `Unreadable` for C that no Program prints."""
    dimension = re.search(rf"^#define {prefix.upper()}_N (\d+)$", header, re.M)
    real = re.search(rf"^typedef (\w+) {prefix}_real;$", header, re.M)
    if not dimension or (not real and scalar != "fixed"):
        raise Unreadable("the header has no dimension or no scalar type")
    kind = real.group(1) if real else scalar
    reader = _Reader(prefix, kind, int(dimension.group(1)))
    known = "typedef int int32_t; typedef unsigned uint32_t; typedef int bool; typedef char uint8_t; typedef short uint16_t;"
    known += f"typedef short int16_t; typedef {'int' if kind == 'fixed' else kind} {prefix}_real; typedef int {prefix}_status;\n"
    code = re.sub(r"/\*.*?\*/", "", source, flags=re.S)
    # the one text that is no Program, there as printed
    own = fixed_lines(prefix) if kind == "fixed" else split_lines(prefix, scalar)
    text = re.sub(r"/\*.*?\*/", "", "\n".join(own))
    splits = f"{prefix}_exponent(" in code or f"{prefix}_mantissa(" in code
    if code.count(text) != (kind == "fixed" or splits):
        told = "what integers are counted with" if kind == "fixed" else "the split into exponent and mantissa"
        raise Unreadable(f"{told} is not the one that was printed")
    code = code.replace(text, "").replace(f"{prefix.upper()}_FLASH", "")
    for line in re.findall(r"^#.*$", code, re.M):
        if not _DIRECTIVE.match(line.replace(prefix, "P")):
            raise Unreadable(f"the line {line!r}")
    code = re.sub(r"^#.*$", "", code, flags=re.M).replace(f"{prefix.upper()}_N", dimension.group(1))
    for part in c_parser.CParser().parse(known + code).ext:
        reader.part(part)
    return Program(prefix, reader.dimension, kind, tuple(reader.tables), tuple(reader.kernels), functions=tuple(reader.functions))


COUNTED = {"down": "ishr", "up": "ishl", "product": "product", "upper": "upper", "low": "low", "leading": "leading"}


class _Reader:
    """Walks the syntax tree; `types` holds those of the names of the function being read."""

    def __init__(self, prefix: str, scalar: str, dimension: int) -> None:
        self.prefix, self.scalar, self.dimension = prefix, scalar, dimension
        self.tables: list[Table] = []
        self.kernels: list[Kernel] = []
        self.functions: list[Function] = []
        self.splits = {f"{prefix}_exponent", f"{prefix}_mantissa"}
        self.counted = {f"{prefix}_{name}": op for name, op in COUNTED.items()} if scalar == "fixed" else {}
        self.bits: dict[str, int] = {}  # of a table's entries
        self.types: dict[str, Type] = {}
        self.pointers: list[str] = []  # of a kernel: where its outputs go, in order

    def part(self, node: Any) -> None:
        match node:
            case c_ast.Typedef():
                return
            case c_ast.Decl(type=c_ast.ArrayDecl()):
                self.tables.append(self.table(node))
            case c_ast.FuncDef():
                self.function(node)
            case _:
                raise Unreadable(f"a {type(node).__name__} where a table or function should be, {node.coord}")

    def name(self, text: str) -> str:
        if not text.startswith(f"{self.prefix}_"):
            raise Unreadable(f"the name {text} does not begin with {self.prefix}_")
        return text.removeprefix(f"{self.prefix}_")

    def kind(self, node: Any) -> Type:
        names = {f"{self.prefix}_real": REAL, "int32_t": INT, "uint32_t": TICK, "bool": BOOL, f"{self.prefix}_status": STATUS}
        text = " ".join(node.type.names)
        if text not in names:
            raise Unreadable(f"the type {text}, {node.coord}")
        return names[text]

    def table(self, node: Any) -> Table:
        if node.quals != ["const"] or node.storage != ["static"]:
            raise Unreadable(f"{node.name} is not static const")
        whole = self.scalar == "fixed"
        values = tuple(self.whole(v) if whole else self.number(v) for v in node.init.exprs)
        if int(node.type.dim.value) != len(values):
            raise Unreadable(f"{node.name} has {len(values)} entries, not {node.type.dim.value}")
        found = Table(self.name(node.name), values, 0, type=INT if whole else REAL)
        kind = " ".join(node.type.type.type.names)
        bits = entry_bits(found) if whole else 32
        if kind != ((f"uint{bits}_t" if bits < 32 else "int32_t") if whole else f"{self.prefix}_real"):
            raise Unreadable(f"{node.name} is a table of {kind}")
        self.bits[found.name] = bits
        return found

    def whole(self, node: Any) -> Fraction:
        """A whole number, negative ones included."""
        if isinstance(node, c_ast.UnaryOp) and node.op == "-":
            return -self.whole(node.expr)
        if not isinstance(node, c_ast.Constant) or not node.value.isdigit():
            raise Unreadable(f"no whole number, {node.coord}")
        return Fraction(node.value)

    def number(self, node: Any) -> Fraction:
        """A literal, negative ones included, as the compiler rounds it."""
        if isinstance(node, c_ast.UnaryOp) and node.op == "-":
            return -self.number(node.expr)
        if not isinstance(node, c_ast.Constant) or not re.fullmatch(r"\d+\.\d*(e-?\d+)?F?", node.value):
            raise Unreadable(f"no number, {node.coord}")
        if node.value.endswith("F") != (self.scalar == "float"):
            raise Unreadable(f"the literal {node.value} is not of type {self.scalar}, {node.coord}")
        return round_to(Fraction(node.value.rstrip("F")), self.scalar)

    # ---- expressions

    def operand(self, node: Any) -> Operand:
        value = self.expression(node)
        if not isinstance(value, Var | Const):
            raise Unreadable(f"more than one operation in a statement, {node.coord}")
        return value

    def expression(self, node: Any) -> Expression:
        match node:
            case c_ast.ID(name="true" | "false" as name):
                return Const(name == "true", BOOL)
            case c_ast.ID(name=name) if name.startswith(f"{self.prefix.upper()}_"):
                return Const(Status[name.removeprefix(f"{self.prefix.upper()}_")], STATUS)
            case c_ast.ID(name=name) if name in self.types:
                return Var(name, self.types[name])
            case c_ast.Constant(value=text) if text.isdigit():
                return Const(int(text), INT)
            case c_ast.Constant(value=text) if text[:-1].isdigit() and text.endswith("U"):
                return Const(int(text[:-1]), TICK)
            case c_ast.UnaryOp(op="-", expr=c_ast.Constant(value=text)) if text.isdigit():
                return Const(-int(text), INT)
            case c_ast.Constant() | c_ast.UnaryOp(op="-", expr=c_ast.Constant()):
                return Const(self.number(node))
            case c_ast.UnaryOp(op="-"):
                value = self.operand(node.expr)
                return Op("ineg" if value.type is INT else "neg", (value,))
            case c_ast.UnaryOp(op="!", expr=c_ast.BinaryOp(op="&&") as both):
                return Op("ne", self.equal(both))
            case c_ast.UnaryOp(op="!"):
                return Op("not", (self.operand(node.expr),))
            case c_ast.TernaryOp():
                return Select(self.operand(node.cond), self.operand(node.iftrue), self.operand(node.iffalse))
            case c_ast.BinaryOp(
                op="!=", left=c_ast.FuncCall(name=c_ast.ID(name="isfinite"), args=args), right=c_ast.Constant(value="0")
            ):
                return IsFinite(self.operand(args.exprs[0]))
            case c_ast.BinaryOp(op="&&", left=c_ast.BinaryOp()):
                return Op("eq", self.equal(node))
            case c_ast.BinaryOp(op=op):
                return self.binary(op, self.operand(node.left), self.operand(node.right), node)
            case c_ast.Cast(expr=c_ast.Cast(expr=inner)) if self.scalar == "fixed":
                outer, own = (" ".join(c.to_type.type.type.names) for c in (node, node.expr))
                if (outer, own) != ("int32_t", "int16_t"):
                    raise Unreadable(f"a {own} made {outer}, {node.coord}")
                return Op("short", (self.operand(inner),))
            case c_ast.Cast(expr=c_ast.ID(name="NAN")):
                return Const(None)
            case c_ast.Cast():
                value = self.operand(node.expr)
                if self.kind(node.to_type.type) is INT:
                    return Op("int", (value,)) if value.type is TICK else Trunc(value)
                return Op("real", (value,))
            case c_ast.ArrayRef():
                array = node.name.name
                known = array if array in self.types else self.name(array)
                return Load(known, self.operand(node.subscript), INT if self.scalar == "fixed" else REAL)
            case c_ast.FuncCall(name=c_ast.ID(name=name), args=args) if name in self.counted:
                return Op(self.counted[name], tuple(map(self.operand, args.exprs)))
            case c_ast.FuncCall(name=c_ast.ID(name=name), args=args) if name.startswith(f"{self.prefix.upper()}_READ_"):
                (read,) = args.exprs
                load = self.expression(read)
                if not isinstance(load, Load) or self.bits.get(load.array) != int(name.rpartition("_")[2]):
                    raise Unreadable(f"{name} of something else, {node.coord}")
                return load
            case c_ast.FuncCall(name=c_ast.ID(name=name), args=args) if name in self.splits:
                return Op(self.name(name), tuple(map(self.operand, args.exprs)))
            case c_ast.FuncCall(name=c_ast.ID(name=name)):
                operation = name.removesuffix("f") if self.scalar == "float" else name
                if operation not in {row.call for row in OPERATIONS.values() if row.call}:
                    raise Unreadable(f"the function {name}, {node.coord}")
                return Op(operation, tuple(map(self.operand, node.args.exprs)))
        raise Unreadable(f"a {type(node).__name__}, {node.coord}")

    def binary(self, op: str, a: Operand, b: Operand, node: Any) -> Expression:
        found = [name for name, row in OPERATIONS.items() if row.infix == op and row.args == (a.type, b.type)]
        if not found:
            raise Unreadable(f"{a.type.value} {op} {b.type.value}, {node.coord}")
        return Op(found[0], (a, b))

    def equal(self, node: Any) -> tuple[Operand, Operand]:
        """The operands of (a <= b) && (b <= a)."""
        left, right = self.expression(node.left), self.expression(node.right)
        if not (
            isinstance(left, Op) and isinstance(right, Op) and left.name == right.name == "le" and left.args == right.args[::-1]
        ):
            raise Unreadable(f"a conjunction that is no comparison for equality, {node.coord}")
        return left.args[0], left.args[1]

    # ---- statements

    def statements(self, items: Iterable[Any], kernel: bool) -> tuple[list[Statement], list[Operand]]:
        """Statements, and what a kernel stores or returns."""
        body: list[Statement] = []
        outputs: list[Operand] = []
        waiting: list[Carry] = []  # declared before their loop
        for node in items or ():
            match node:
                case c_ast.Decl(init=None):
                    self.types[node.name] = self.kind(node.type)
                case c_ast.Decl(quals=["const"], init=c_ast.FuncCall(name=c_ast.ID(name=name), args=args)) if (
                    name.startswith(f"{self.prefix}_") and name not in self.splits and name not in self.counted
                ):
                    given = tuple(map(self.operand, args.exprs))
                    body.append(Call((self.declare(node),), self.name(name), given))
                case c_ast.Decl(quals=["const"]):
                    value = self.expression(node.init)
                    var = self.declare(node)
                    if type_of(value) is not var.type:
                        raise Unreadable(f"{node.name} is declared with another type than its value has")
                    body.append(Assign(var, value))
                case c_ast.Decl(quals=[]):
                    initial = self.operand(node.init)
                    var = self.declare(node)
                    waiting.append(Carry(var, initial, var))
                case c_ast.For():
                    body.append(self.loop(node, waiting))
                    waiting = []
                case c_ast.If(iffalse=None):
                    inner, _ = self.statements(node.iftrue.block_items, False)
                    left = inner.pop() if inner and isinstance(inner[-1], Return) else None
                    if not isinstance(left, Return):
                        raise Unreadable(f"an if that does not leave, {node.coord}")
                    body.append(Return(left.status, self.operand(node.cond), tuple(inner)))
                case c_ast.FuncCall(name=c_ast.ID(name=name), args=args):
                    given = tuple(self.operand(a) for a in args.exprs if not isinstance(a, c_ast.UnaryOp) or a.op != "&")
                    results = tuple(self.result(a) for a in args.exprs[len(given) :])
                    body.append(Call(results, self.name(name), given))
                case c_ast.Assignment(op="=", lvalue=c_ast.UnaryOp(op="*", expr=c_ast.ID(name=name)), rvalue=value):
                    if self.pointers[len(outputs) : len(outputs) + 1] != [name]:
                        raise Unreadable(f"{name} is not the next output, {node.coord}")
                    outputs.append(self.operand(value))
                case c_ast.Assignment(op="=", lvalue=c_ast.ArrayRef() as place, rvalue=value):
                    body.append(Store(place.name.name, self.operand(place.subscript), self.operand(value)))
                case c_ast.Return(expr=None):
                    body.append(Return())
                case c_ast.Return(expr=value) if kernel:
                    outputs.append(self.operand(value))
                case c_ast.Return(expr=value):
                    body.append(Return(self.expression(value)))
                case _:
                    raise Unreadable(f"a {type(node).__name__}, {node.coord}")
        if waiting:
            raise Unreadable(f"{waiting[0].var.name} is changed by no loop")
        return body, outputs

    def declare(self, node: Any) -> Var:
        self.types[node.name] = self.kind(node.type)
        return Var(node.name, self.types[node.name])

    def result(self, node: Any) -> Var:
        if not (isinstance(node, c_ast.UnaryOp) and node.op == "&"):
            raise Unreadable(f"an argument after the results, {node.coord}")
        return Var(node.expr.name, self.types[node.expr.name])

    def loop(self, node: Any, waiting: list[Carry]) -> For:
        start, stop, step = node.init.decls[0], node.cond, node.next
        counts = step.op == "++" and step.expr.name == start.name and (stop.op, stop.left.name) == ("<", start.name)
        if not counts or start.init.value != "0":
            raise Unreadable(f"a loop that does not count up from 0, {node.coord}")
        index = self.declare(start)
        items = list(node.stmt.block_items)
        following: dict[str, Operand] = {}
        moved = items[len(items) - len(waiting) :]
        names = [c.var.name for c in waiting]
        if [m.lvalue.name for m in moved if isinstance(m, c_ast.Assignment) and isinstance(m.lvalue, c_ast.ID)] != names:
            raise Unreadable(f"the loop's end does not change {', '.join(names)}, {node.coord}")
        body, _ = self.statements(items[: len(items) - len(waiting)], False)
        for m in moved:
            following[m.lvalue.name] = self.operand(m.rvalue)
        carries = tuple(Carry(c.var, c.initial, following[c.var.name]) for c in waiting)
        return For(index, int(stop.right.value), tuple(body), carries)

    # ---- functions

    @property
    def number_type(self) -> str:
        return "int32_t" if self.scalar == "fixed" else f"{self.prefix}_real"

    def function(self, node: Any) -> None:
        declared = node.decl
        name, kernel = self.name(declared.name), "static" in declared.storage
        self.types, self.pointers = {}, []
        inputs: list[Var] = []
        params: list[Param] = []
        for p in declared.type.args.params:
            match p.type:
                case c_ast.ArrayDecl(dim=dim, type=inner):
                    self.types[p.name] = self.kind(inner)
                    number = INT if self.scalar == "fixed" else REAL
                    params.append(Param(p.name, self.length(dim), "const" not in inner.quals, type=number))
                case c_ast.PtrDecl():
                    self.pointers.append(p.name)
                case _:
                    self.types[p.name] = self.kind(p.type)
                    inputs.append(Var(p.name, self.types[p.name]))
                    params.append(Param(p.name, None, type=self.types[p.name]))
        body, outputs = self.statements(node.body.block_items, kernel)
        returned = declared.type.type.type.names
        known = ["void", self.number_type, *(["int32_t", "bool"] if kernel else [f"{self.prefix}_status", "bool"])]
        if len(returned) != 1 or returned[0] not in known or declared.funcspec != ["inline"] * kernel:
            raise Unreadable(f"{name} is declared {' '.join([*declared.storage, *declared.funcspec, *returned])}, {node.coord}")
        if kernel:
            assigns = tuple(s for s in body if isinstance(s, Assign))
            if len(assigns) != len(body):
                raise Unreadable(f"the kernel {name} is not straight")
            self.kernels.append(Kernel(name, tuple(inputs), assigns, tuple(outputs), ()))
        else:
            status, real = [f"{self.prefix}_status"] == returned, [self.number_type] == returned
            self.functions.append(
                Function(name, tuple(params), tuple(body), status, (), returns_real=real, returns_bool=returned == ["bool"])
            )

    def length(self, node: Any) -> int:
        if isinstance(node, c_ast.BinaryOp) and node.op == "*":
            return self.length(node.left) * self.length(node.right)
        return int(node.value)
