"""A reader that turns a function of a Program into a CasADi function: the statements that are printed, for a user's optimiser,
observer or controller, with CasADi's derivatives.

Arguments count as finite numbers, so no early leave is taken. A table is a piecewise constant function of
the index; whole parts have the derivative 0, as they have almost everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import casadi as ca

from stt_codegen.program.nodes import Const, Program, Return, Status
from stt_codegen.program.number import round_to
from stt_codegen.program.operations import OPERATIONS, REAL
from stt_codegen.program.walk import Walk

_LOGIC: dict[str, Any] = {"and": ca.logic_and, "or": ca.logic_or, "not": ca.logic_not}


@dataclass(frozen=True)
class ScaledInteger:
    """An integer scale * base + shift that depends on arguments; base is the whole part of a real."""

    base: Any
    scale: int = 1
    shift: int = 0

    @property
    def value(self) -> Any:
        """The integer as an expression of CasADi."""
        return self.scale * self.base + self.shift


def casadi_function(program: Program, name: str) -> Any:
    """Return the public function `name` as a CasADi function; inputs and outputs are columns with the names of its parameters.

    A status comes first, as `status`; a real or truth value as `value`. An array that is read and changed comes out as
    `<name>_next`. Raises `NotImplementedError` for a function that counts ticks.
    """
    function = program.function(name)
    if any(p.type is not REAL for p in function.params):
        raise NotImplementedError(f"{name}: takes a count of ticks, which is no real number; use the function of seconds")
    inputs = {p.name: ca.SX.sym(p.name, p.length or 1) for p in function.inputs}
    walk = _CasadiWalk(program)
    for p in function.params:
        if p.length is None:
            walk.known[p.name] = inputs[p.name]
        else:
            walk.arrays[p.name] = [inputs[p.name][k] for k in range(p.length)] if p.name in inputs else [0] * p.length
    walk.run_statements(function.body)
    outputs = {p.name: ca.vertcat(*walk.arrays[p.name]) for p in function.outputs}
    if function.returns_status:
        outputs = {"status": ca.SX(walk.result), **outputs}
    elif function.returns_real or function.returns_bool:
        outputs = {"value": ca.SX(walk.result)}
    output_names = [n + "_next" if n in inputs else n for n in outputs]
    return ca.Function(f"{program.prefix}_{name}", list(inputs.values()), list(outputs.values()), list(inputs), output_names)


class _CasadiWalk(Walk):
    """Runs a function on expressions of CasADi. `result` is what the function returns."""

    result: Any = None

    def leave(self, statement: Return) -> None:
        """Note what the last statement returns; an early leave is for arguments that are refused."""
        if statement.when is None and statement.status is not None:
            self.result = self.value(statement.status)

    def constant(self, constant: Const) -> Any:
        """Return a constant as a number; a real is rounded to the scalar, as it is printed."""
        number = constant.value
        if isinstance(number, Status):
            return number.value
        if constant.type is not REAL or number is None:
            return float("nan") if number is None else number
        return float(round_to(Fraction(number), self.program.scalar))

    def select(self, condition: Any, then: Any, otherwise: Any) -> Any:
        return (then if condition else otherwise) if isinstance(condition, bool) else ca.if_else(condition, then, otherwise)

    def finite(self, _value: Any) -> Any:
        return True

    def trunc(self, value: Any) -> Any:
        return ScaledInteger(ca.floor(value))  # no Program truncates a negative number

    def operation(self, name: str, args: list[Any]) -> Any:
        """Return an operation on numbers, expressions of CasADi and integers that depend on arguments."""
        row = OPERATIONS[name]
        if name in ("iadd", "imul", "isub") and any(isinstance(a, ScaledInteger) for a in args):
            return _scaled_integer(name, *args)
        if name == "real":
            return args[0].value if isinstance(args[0], ScaledInteger) else float(args[0])
        if name in _LOGIC:
            return row.number(*args) if all(isinstance(a, bool) for a in args) else _LOGIC[name](*args)
        if name in ("exponent", "mantissa"):
            return self.split(name, args[0])
        if row.call:
            return getattr(ca, "power" if row.call == "pow" else row.call)(*args)
        return args[0] / args[1] if name == "div" else row.number(*args)

    def split(self, name: str, y: Any) -> Any:
        """Return the exponent or the mantissa of y = mantissa 2^exponent: e is the whole part of log2(y sqrt 2)."""
        exponent = ca.floor(ca.log(y * 2**0.5) / ca.log(2))
        return ScaledInteger(exponent) if name == "exponent" else y / 2**exponent

    def entry(self, table: str, index: Any) -> Any:
        """Return an entry of a table: a piecewise constant function where the index depends on arguments."""
        values = [float(round_to(v, self.program.scalar)) for v in self.program.table(table).values]
        if isinstance(index, int):
            return values[index]
        selectable = values[index.shift :: index.scale]
        cuts = [k + 0.5 for k in range(len(selectable) - 1)]
        return ca.pw_const(index.base, ca.DM(cuts), ca.DM(selectable)) if cuts else selectable[0]


def _scaled_integer(name: str, a: Any, b: Any) -> ScaledInteger:
    """Return the sum, difference or product of an integer that depends on arguments and a constant."""
    if name == "isub":
        return _scaled_integer("iadd", a, -b if isinstance(b, int) else ScaledInteger(b.base, -b.scale, -b.shift))
    variable, number = (a, b) if isinstance(a, ScaledInteger) else (b, a)
    if name == "imul":
        return ScaledInteger(variable.base, variable.scale * number, variable.shift * number)
    return ScaledInteger(variable.base, variable.scale, variable.shift + number)
