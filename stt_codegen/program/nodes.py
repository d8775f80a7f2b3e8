"""The Program: everything that is emitted, as typed single assignments over a small closed set of nodes.

    Program = tables + kernels + functions
    Kernel  = pure straight-line function of scalars; lowered from CasADi (convert/from_casadi.py) or written here
    Function = a public entry point: loads, loops over a constant count, calls of kernels, stores, a status

controller/ makes Programs. targets/ has a folder for each language: printer, templates, runner. read/ reads the C back and shows
that it is this Program. analyse/ has enclosures, rounding errors, ranges, costs; symbolic/ SymPy; convert/ CasADi. Proofs and
costs are of this Program, which is what is printed. A new operation is one row of operations.py.

Long because the nodes are one small language, and every reader needs all of them.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from enum import Enum
from fractions import Fraction

from stt_codegen.program.operations import BOOL, INT, OPERATIONS, REAL, Type


class Status(Enum):
    """What `control` returns; the numbers are part of the C interface."""

    OK = 0
    OUTSIDE_TUBE = 1
    BAD_INPUT = 2


@dataclass(frozen=True)
class Var:
    """The result of one assignment, a parameter, or a loop counter."""

    name: str
    type: Type


@dataclass(frozen=True)
class Const:
    """An exact number (rounded to the program's scalar only when printed), a truth value, a Status or NaN (None)."""

    value: Fraction | int | bool | Status | None
    type: Type = REAL


Operand = Var | Const


@dataclass(frozen=True)
class Op:
    """Arithmetic and mathematics: `name` is a key of OPERATIONS."""

    name: str
    args: tuple[Operand, ...]

    def __post_init__(self) -> None:
        if self.name not in OPERATIONS:
            raise ValueError(f"unknown operation {self.name!r}")
        expected = OPERATIONS[self.name].args
        if tuple(a.type for a in self.args) != expected:
            raise TypeError(f"{self.name} takes {[t.value for t in expected]}, got {[a.type.value for a in self.args]}")


@dataclass(frozen=True)
class Select:
    """`then` where `condition` holds, else `otherwise`; both are already computed."""

    condition: Operand
    then: Operand
    otherwise: Operand

    def __post_init__(self) -> None:
        if self.condition.type is not BOOL or self.then.type is not self.otherwise.type:
            raise TypeError("Select takes a truth value and two operands of one type")


@dataclass(frozen=True)
class IsFinite:
    """Whether a real is neither NaN nor infinite."""

    arg: Operand


@dataclass(frozen=True)
class Trunc:
    """A real toward zero as an integer; the argument must be finite and within 31 bits."""

    arg: Operand


@dataclass(frozen=True)
class Load:
    """One entry of a table or of an array parameter: a real, or an integer of an array of integers."""

    array: str
    index: Operand
    type: Type = REAL


Expression = Operand | Op | Select | IsFinite | Trunc | Load


def type_of(expression: Expression) -> Type:
    """Return the type of an expression's value."""
    match expression:
        case Var(type=t) | Const(type=t):
            return t
        case Op(name=name):
            return OPERATIONS[name].result
        case Select(then=then):
            return then.type
        case IsFinite():
            return BOOL
        case Trunc():
            return INT
        case Load(type=t):
            return t


def operands(expression: Expression) -> tuple[Operand, ...]:
    """Return the operands that an expression reads; none for a variable or constant itself."""
    match expression:
        case Op(args=args):
            return args
        case Select(condition=condition, then=then, otherwise=otherwise):
            return (condition, then, otherwise)
        case IsFinite(arg=arg) | Trunc(arg=arg):
            return (arg,)
        case Load(index=index):
            return (index,)
    return ()


# ---------------------------------------------------------------------------------------------- statements


@dataclass(frozen=True)
class Assign:
    """`var` is `value` from here on; a variable is assigned once."""

    var: Var
    value: Expression


@dataclass(frozen=True)
class Call:
    """`results` = the outputs of the kernel named `kernel`."""

    results: tuple[Var, ...]
    kernel: str
    args: tuple[Operand, ...]


@dataclass(frozen=True)
class Store:
    """Write one entry of an output array."""

    array: str
    index: Operand
    value: Operand


@dataclass(frozen=True)
class Carry:
    """A value carried through a loop: `var` is `initial` before the first turn and `next` after each."""

    var: Var
    initial: Operand
    next: Operand


@dataclass(frozen=True)
class For:
    """`body` for index = 0 .. count - 1."""

    index: Var
    count: int
    body: tuple[Statement, ...]
    carries: tuple[Carry, ...] = ()


@dataclass(frozen=True)
class Return:
    """Leave the function with `status` (None where it returns nothing); with `when`, only if that holds and after `body`."""

    status: Expression | None = None
    when: Operand | None = None
    body: tuple[Statement, ...] = ()


Statement = Assign | Call | Store | For | Return


# ---------------------------------------------------------------------------------- tables and functions


@dataclass(frozen=True)
class Table:
    """Constants, rounded to the scalar when printed, or integers (`type`); `row`: entries of one row, in which it is printed."""

    name: str
    values: tuple[Fraction, ...]
    row: int
    doc: tuple[str, ...] = ()
    type: Type = REAL


def entry_bits(table: Table) -> int:
    """Return the bits of the smallest type that holds a table's integers: 8 or 16 where none is negative, else 32."""
    return next((bits for bits in (8, 16) if all(0 <= v < 1 << bits for v in table.values)), 32)


@dataclass(frozen=True)
class Kernel:
    """A pure function of scalars. `outputs` are operands, so an input or constant may be passed through."""

    name: str
    inputs: tuple[Var, ...]
    body: tuple[Assign, ...]
    outputs: tuple[Operand, ...]
    output_names: tuple[str, ...]
    _: KW_ONLY
    doc: tuple[str, ...] = ()


@dataclass(frozen=True)
class Param:
    """A parameter of a public function: a scalar (`length` None, input only; a real or a count) or an array of reals or
    integers: read, written (`output`), or read and changed in place (`output` and `inout`)."""

    name: str
    length: int | None
    output: bool = False
    inout: bool = False
    type: Type = REAL


@dataclass(frozen=True)
class Function:
    """A public entry point. It returns a status, a real, a truth value, or nothing; `Return.status` holds what is returned."""

    name: str
    params: tuple[Param, ...]
    body: tuple[Statement, ...]
    returns_status: bool
    doc: tuple[str, ...] = ()
    _: KW_ONLY
    returns_real: bool = False
    returns_bool: bool = False

    @property
    def inputs(self) -> tuple[Param, ...]:
        """Parameters that are read, those that are changed in place too."""
        return tuple(p for p in self.params if not p.output or p.inout)

    @property
    def outputs(self) -> tuple[Param, ...]:
        """Arrays that are written, those that are changed in place too."""
        return tuple(p for p in self.params if p.output)


@dataclass(frozen=True)
class Program:
    """Everything that is emitted for one task.

    prefix: the task's name; names of parts are without it, and the printers add it. dimension: of the state. scalar: "float",
    "double", or "fixed" where there is no real. tick: seconds of one tick, where time is counted in ticks only.
    """

    prefix: str
    dimension: int
    scalar: str
    tables: tuple[Table, ...]
    kernels: tuple[Kernel, ...]
    _: KW_ONLY
    functions: tuple[Function, ...]
    tick: Fraction | None = None

    def kernel(self, name: str) -> Kernel:
        """Return the kernel of this name."""
        return next(k for k in self.kernels if k.name == name)

    def function(self, name: str) -> Function:
        """Return the public function of this name."""
        return next(f for f in self.functions if f.name == name)

    def table(self, name: str) -> Table:
        """Return the table of this name."""
        return next(t for t in self.tables if t.name == name)


def uses_split(program: Program) -> bool:
    """Whether a kernel splits a number into exponent and mantissa."""
    values = (a.value for kernel in program.kernels for a in kernel.body)
    return any(isinstance(v, Op) and v.name in ("exponent", "mantissa") for v in values)


def uses_fixed(program: Program) -> bool:
    """Whether the program calculates in integers that stand for reals."""
    return program.scalar == "fixed"


def real(value: Fraction | int) -> Const:
    """Return a number as a real constant."""
    return Const(Fraction(value), REAL)


def integer(value: int) -> Const:
    """Return a number as an integer constant."""
    return Const(value, INT)


TRUE, FALSE, NAN = Const(True, BOOL), Const(False, BOOL), Const(None, REAL)
