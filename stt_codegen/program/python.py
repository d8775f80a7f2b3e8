"""Program to Python: the same functions in double arithmetic on the emitted constants, with `math` and nothing else."""

from __future__ import annotations

from collections.abc import Iterable

from stt_codegen.program.number import FORMATS, round_to, shortest
from stt_codegen.program.program import (
    INT,
    MATH_CALLS,
    TICK,
    Assign,
    Call,
    Const,
    Expression,
    For,
    Function,
    IsFinite,
    Kernel,
    Load,
    Op,
    Program,
    Return,
    Select,
    Statement,
    Status,
    Store,
    Table,
    Trunc,
    Var,
    uses_split,
)

_INFIX = {
    "add": "+",
    "sub": "-",
    "mul": "*",
    "div": "/",
    "lt": "<",
    "le": "<=",
    "eq": "==",
    "ne": "!=",
    "and": "and",
    "or": "or",
    "iadd": "+",
    "imul": "*",
    "ilt": "<",
    "isub": "-",
    "idiv": "//",
    "tlt": "<",
    "pow": "**",
}


LITERALS_A_LINE = 4


class PythonPrinter:
    """Prints the parts of one program. Arrays come in as sequences and go out as tuples; nothing is changed in place."""

    def __init__(self, program: Program) -> None:
        self.program = program

    def helpers(self) -> list[str]:
        """What some node of the program needs beside expressions."""
        if not uses_split(self.program):
            return []
        least = self.literal(Const(FORMATS[self.program.scalar].least_mantissa))
        return [
            "def _split(y):",
            '    """m and e with y = m 2^e, m in [1/sqrt 2, sqrt 2)."""',
            "    m, e = math.frexp(y)",
            f"    return (m, e) if m >= {least} else (2.0 * m, e - 1)",
        ]

    def literal(self, constant: Const) -> str:
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

    def expression(self, value: Expression) -> str:
        match value:
            case Var(name=name):
                return name
            case Const():
                return self.literal(value)
            case Select(condition=c, then=a, other=b):
                return f"{self.expression(a)} if {self.expression(c)} else {self.expression(b)}"
            case IsFinite(arg=a):
                return f"math.isfinite({self.expression(a)})"
            case Trunc(arg=a):
                return f"int({self.expression(a)})"
            case Load(array=array, index=i):
                return f"{self.array(array)}[{self.expression(i)}]"
            case Op(name=name, args=args):
                return self.operation(name, [self.expression(a) for a in args])

    def operation(self, name: str, args: list[str]) -> str:
        if name in _INFIX:
            return f"{args[0]} {_INFIX[name]} {args[1]}"
        if name in ("floor", "ceil"):  # Python's return whole numbers of another type
            return f"float(math.{name}({args[0]}))"
        if name in MATH_CALLS or name == "fabs":
            return f"math.{name}({', '.join(args)})"
        match name:
            case "neg":
                return f"-{args[0]}"
            case "not":
                return f"not {args[0]}"
            case "real":
                return f"float({args[0]})"
            case "int":
                return args[0]
            case "exponent" | "mantissa":
                return f"_split({args[0]})[{0 if name == 'mantissa' else 1}]"
        raise NotImplementedError(f"Python has no printer for operation {name!r}")

    def array(self, name: str) -> str:
        return name.upper() if any(t.name == name for t in self.program.tables) else name

    def statements(self, body: Iterable[Statement], function: Function | None, indent: int = 1) -> list[str]:
        lines: list[str] = []
        pad = "    " * indent
        for statement in body:
            match statement:
                case Assign(var=var, value=value):
                    lines.append(f"{pad}{var.name} = {self.expression(value)}")
                case Call(results=results, kernel=kernel, args=args):
                    names = ", ".join(r.name for r in results)
                    lines.append(f"{pad}{names} = _{kernel}({', '.join(self.expression(a) for a in args)})")
                case Store(array=array, index=i, value=value):
                    lines.append(f"{pad}{array}[{self.expression(i)}] = {self.expression(value)}")
                case For(index=index, count=count, body=inner, carries=carries):
                    lines += [f"{pad}{c.var.name} = {self.expression(c.initial)}" for c in carries]
                    lines.append(f"{pad}for {index.name} in range({count}):")
                    lines += self.statements(inner, function, indent + 1)
                    lines += [f"{pad}    {c.var.name} = {self.expression(c.next)}" for c in carries]
                case Return(status=status, when=when, body=inner):
                    leave = self.leave(function, status)
                    if when is None:
                        lines.append(pad + leave)
                    else:
                        lines.append(f"{pad}if {self.expression(when)}:")
                        lines += self.statements(inner, function, indent + 1)
                        lines.append(f"{pad}    {leave}")
        return lines

    def leave(self, function: Function | None, status: Expression | None) -> str:
        assert function is not None
        arrays = [f"tuple({p.name})" for p in function.outputs]
        parts = ([self.expression(status)] if status is not None else []) + arrays
        return f"return {', '.join(parts)}"

    def table(self, table: Table) -> list[str]:
        lines = [*(f"# {line}".rstrip() for line in table.doc), f"{table.name.upper()} = ("]
        for start in range(0, len(table.values), table.row):
            row = [self.literal(Const(v)) for v in table.values[start : start + table.row]]
            lines += ["    " + ", ".join(row[k : k + LITERALS_A_LINE]) + "," for k in range(0, len(row), LITERALS_A_LINE)]
        return [*lines, ")"]

    def kernel(self, kernel: Kernel) -> list[str]:
        inputs = ", ".join(v.name for v in kernel.inputs)
        outputs = ", ".join(self.expression(o) for o in kernel.outputs)
        return [
            f"def _{kernel.name}({inputs}):",
            *self.docstring(kernel.doc),
            *self.statements(kernel.body, None),
            f"    return {outputs}",
        ]

    def function(self, function: Function) -> list[str]:
        lines = [f"def {function.name}({', '.join(p.name for p in function.inputs)}):", *self.docstring(function.doc)]
        for p in function.inputs:
            scalar = f'_count("{p.name}", {p.name})' if p.type is TICK else f"float({p.name})"
            lines.append(
                f"    {p.name} = {scalar}" if p.length is None else f'    {p.name} = _vector("{p.name}", {p.name}, {p.length})'
            )
        lines += [f"    {p.name} = [0.0] * {p.length}" for p in function.outputs if not p.inout]
        return [*lines, *self.statements(function.body, function)]

    def docstring(self, doc: tuple[str, ...]) -> list[str]:
        if not doc:
            return []
        if len(doc) == 1:
            return [f'    """{doc[0]}"""']
        return [f'    """{doc[0]}', *(f"    {line}".rstrip() for line in doc[1:]), '    """']
