"""From a CasADi function to a kernel: constants exact, opcodes canonical, one name for each value, nothing unused.

`controller/` writes most kernels as CasADi functions, and lowers them here.

It reads the instruction list, the part of CasADi that is steady between versions. Work slots are reused there, so every
write gets a fresh number; inputs are never overwritten, hence all of them are read before any output is stored.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import casadi as ca

from stt_codegen.program.nodes import Assign, Kernel, Op, Operand, Select, Var, operands, real, type_of
from stt_codegen.program.operations import BOOL, OPERATIONS, REAL


class UnknownOpcode(Exception):
    """A CasADi instruction that the Program has no node for."""


def direct_opcodes() -> dict[str, str]:
    """Return CasADi's opcodes that are one operation of the Program, with the name of that operation."""
    return {opcode: name for name, row in OPERATIONS.items() for opcode in row.casadi}


@cache
def opcode_names() -> dict[int, str]:
    """Return the names of CasADi's opcodes by their numbers."""
    return {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}


def lower(function: ca.Function, doc: tuple[str, ...] = ()) -> Kernel:
    """Return the kernel of an SX function of scalars and dense vectors (entries become `name0`, `name1`, ...).

    Raises `UnknownOpcode`, naming it, for an instruction outside the closed set.
    """
    reader = _InstructionReader(function)
    outputs = reader.read_instructions()
    names = [n for k in range(function.n_out()) for n in _entry_names(function.name_out(k), function.nnz_out(k))]
    return Kernel(
        name=function.name(),
        inputs=tuple(v for vector in reader.inputs for v in vector),
        body=_without_unused(reader.body, outputs),
        outputs=tuple(outputs),
        output_names=tuple(names),
        doc=doc,
    )


def _entry_names(name: str, count: int) -> list[str]:
    """Return the names of the entries of a scalar or vector."""
    return [name] if count == 1 else [f"{name}{k}" for k in range(count)]


class _InstructionReader:
    """One pass over the instruction list, with value numbering: an expression that has a variable is not computed again.

    slots: what each work slot of CasADi holds now. numbered: the variable of every expression.
    """

    def __init__(self, function: ca.Function) -> None:
        self.function, self.direct = function, direct_opcodes()
        self.inputs = [
            tuple(Var(n, REAL) for n in _entry_names(function.name_in(k), function.nnz_in(k))) for k in range(function.n_in())
        ]
        self.used_names = {v.name for vector in self.inputs for v in vector}
        self.body: list[Assign] = []
        self.numbered: dict[object, Var] = {}
        self.slots: dict[int, Operand] = {}

    def read_instructions(self) -> list[Operand]:
        """Add an assignment for every instruction that computes, and return the outputs."""
        f = self.function
        outputs: list[list[Operand]] = [[real(0)] * f.nnz_out(k) for k in range(f.n_out())]
        for k in range(f.n_instructions()):
            code = f.instruction_id(k)
            name = opcode_names().get(code, f"opcode {code}")
            args, results = f.instruction_input(k), f.instruction_output(k)
            if name == "OP_INPUT":
                self.slots[results[0]] = self.inputs[args[0]][args[1]]
            elif name == "OP_OUTPUT":
                outputs[results[0]][results[1]] = self._as_real(self.slots[args[0]])
            elif name == "OP_CONST":
                self.slots[results[0]] = real(Fraction(f.instruction_constant(k)))
            else:
                self.slots[results[0]] = self._operation(name, [self.slots[a] for a in args])
        return [operand for vector in outputs for operand in vector]

    def _operation(self, name: str, args: list[Operand]) -> Operand:
        """Return the value of one instruction in canonical form: a square, for example, is a product."""
        match name:
            case "OP_ASSIGN" | "OP_LIFT":
                return args[0]
            case "OP_TWICE":
                return self._emit("add", args[0], args[0])
            case "OP_SQ":
                return self._emit("mul", args[0], args[0])
            case "OP_INV":
                return self._emit("div", real(1), args[0])
            case "OP_FMIN" | "OP_FMAX":  # for finite arguments; fmin and fmax of C differ only where one is NaN
                a, b = (args[0], args[1]) if name == "OP_FMIN" else (args[1], args[0])
                return self._select(self._emit("lt", a, b), args[0], args[1])
            case "OP_SIGN":  # the sign of 0 is 0, as in CasADi
                below = self._select(self._emit("lt", args[0], real(0)), real(-1), real(0))
                return self._select(self._emit("lt", real(0), args[0]), real(1), below)
            case "OP_IF_ELSE_ZERO":
                return self._select(self._as_bool(args[0]), self._as_real(args[1]), real(0))
            case _ if name in self.direct:
                return self._emit(self.direct[name], *args)
            case _:
                raise UnknownOpcode(
                    f"{self.function.name()}: CasADi's {name} has no node in the Program; rewrite the kernel without it"
                )

    def _emit(self, operation: str, *args: Operand) -> Operand:
        """Return the value of an operation, its arguments taken as reals or as truth values."""
        logical = operation in ("and", "or", "not")
        typed = tuple(self._as_bool(a) if logical else self._as_real(a) for a in args)
        return self._number(Op(operation, typed))

    def _select(self, condition: Operand, then: Operand, otherwise: Operand) -> Operand:
        return self._number(Select(condition, then, otherwise))

    def _number(self, value: Op | Select) -> Operand:
        """Return the variable of an expression; a new one is assigned where no equal expression has one."""
        key: object = value
        if isinstance(value, Op) and OPERATIONS[value.name].commutes:
            key = (value.name, frozenset(value.args))
        if key not in self.numbered:
            var = Var(self._new_name(), type_of(value))
            self.body.append(Assign(var, value))
            self.numbered[key] = var
        return self.numbered[key]

    def _new_name(self) -> str:
        k = len(self.body)
        while f"v{k}" in self.used_names:
            k += 1
        self.used_names.add(f"v{k}")
        return f"v{k}"

    def _as_real(self, operand: Operand) -> Operand:
        """Return a number: a truth value becomes 1 or 0 (CasADi has one type for both)."""
        return self._select(operand, real(1), real(0)) if operand.type is BOOL else operand

    def _as_bool(self, operand: Operand) -> Operand:
        return operand if operand.type is BOOL else self._emit("ne", operand, real(0))


def _without_unused(body: list[Assign], outputs: list[Operand]) -> tuple[Assign, ...]:
    """Return the assignments that some output depends on."""
    needed = {o.name for o in outputs if isinstance(o, Var)}
    used: list[Assign] = []
    for assign in reversed(body):
        if assign.var.name not in needed:
            continue
        used.append(assign)
        needed |= {a.name for a in operands(assign.value) if isinstance(a, Var)}
    return tuple(reversed(used))
