"""A reader that runs a Program on many points at once and carries, with every value, a bound on its error.

Values are what exact arithmetic on the exact constants gives (in extended precision); errors bound how far the emitted
arithmetic may be from them: half a unit in the last place for + - * / and sqrt, 2 units for every other function of the
C library, the rounding of constants and tables, all propagated through each statement. `compare` uses the bounds.

Table indices must not depend on data (they do not in adaptive and literal programs).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.program.nodes import (
    Assign,
    Call,
    Const,
    Expression,
    For,
    IsFinite,
    Kernel,
    Load,
    Op,
    Operand,
    Program,
    Return,
    Select,
    Statement,
    Store,
    Var,
)
from stt_codegen.program.number import FORMATS, round_to
from stt_codegen.program.operations import INT, OPERATIONS, REAL, monotone_change

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Real:
    """Values of shape (P,) and how far the emitted numbers may be from them."""

    value: Array
    error: Array


@dataclass(frozen=True)
class Truth:
    """Comparison results of shape (P,), and where the errors leave them undecided."""

    value: Array
    undecided: Array


Value = Real | Truth | int


def exact(value: Fraction | int) -> np.longdouble:
    """Return a fraction in extended precision."""
    fraction = Fraction(value)
    return np.longdouble(fraction.numerator) / np.longdouble(fraction.denominator)


class Runner:
    """Runs the functions of one program.

    newton_iterates: names of carried values whose error is not propagated from one turn of their loop to the next. Newton's map
    has slope zero at the root, so that their error enters squared.
    """

    def __init__(self, program: Program, newton_iterates: Iterable[str] = ()) -> None:
        self.program = program
        self.newton_iterates = frozenset(newton_iterates)
        form = FORMATS[program.scalar]
        self.half_ulp, self.tiny = float(form.roundoff), float(form.tiny) or 5e-324

    def run(self, function: str, inputs: Mapping[str, Array]) -> dict[str, Real]:
        """Return the outputs by name, of shape (P, length), for inputs of shape (P,) or (P, length), taken as exact and finite. A
        real that the function returns is "return"."""
        f = self.program.function(function)
        points = len(next(iter(inputs.values())))
        zero = np.zeros(points)
        state: dict[str, Value] = {}
        self.arrays: dict[str, dict[int, Real]] = {}
        for p in f.inputs:
            data = np.asarray(inputs[p.name], dtype=np.longdouble)
            if p.length is None:
                state[p.name] = Real(data, zero)
            else:
                self.arrays[p.name] = {k: Real(data[:, k], zero) for k in range(p.length)}
        for p in f.outputs:
            self.arrays.setdefault(p.name, {})
        self._run_statements(f.body, state)
        results = {"return": self.arrays["return"][0]} if f.returns_real else {}
        for p in f.outputs:
            stored = self.arrays[p.name]
            cells = [stored.get(k, Real(zero, zero)) for k in range(p.length or 0)]
            results[p.name] = Real(
                np.stack([np.broadcast_to(c.value, points) for c in cells], axis=1),
                np.stack([np.broadcast_to(c.error, points) for c in cells], axis=1),
            )
        return results

    def _run_statements(self, body: Iterable[Statement], state: dict[str, Value]) -> None:
        """Run statements; `state` has the values by name, and `arrays` what is stored."""
        for statement in body:
            match statement:
                case Assign(var=var, value=value):
                    state[var.name] = self._expression(value, state)
                case Call(results=results, kernel=name, args=args):
                    outputs = self._kernel(self.program.kernel(name), [self._operand(a, state) for a in args])
                    state.update({r.name: v for r, v in zip(results, outputs, strict=True)})
                case Store(array=array, index=index, value=value):
                    entry, stored = self._operand(index, state), self._operand(value, state)
                    assert isinstance(entry, int)
                    assert isinstance(stored, Real)
                    self.arrays[array][entry] = stored
                case For(index=index, count=count, body=inner, carries=carries):
                    for c in carries:
                        state[c.var.name] = self._operand(c.initial, state)
                    for k in range(count):
                        state[index.name] = k
                        for c in carries:
                            carried = state[c.var.name]
                            if c.var.name in self.newton_iterates and isinstance(carried, Real):
                                state[c.var.name] = Real(carried.value, np.zeros_like(carried.error))
                        self._run_statements(inner, state)
                        state.update({c.var.name: self._operand(c.next, state) for c in carries})
                case Return(status=Var() | Const() as value, when=None) if value.type is REAL:
                    returned = self._operand(value, state)
                    assert isinstance(returned, Real)
                    self.arrays["return"] = {0: returned}
                case Return():
                    pass  # inputs are finite, so no early leave is taken; a status is not a number

    def _kernel(self, kernel: Kernel, args: list[Value]) -> list[Value]:
        state: dict[str, Value] = dict(zip((v.name for v in kernel.inputs), args, strict=True))
        self._run_statements(kernel.body, state)
        return [self._operand(o, state) for o in kernel.outputs]

    def _operand(self, operand: Operand, state: Mapping[str, Value]) -> Value:
        if isinstance(operand, Var):
            return state[operand.name]
        return self._constant(operand)

    def _constant(self, constant: Const) -> Value:
        """Return a constant with the error of its rounding; NaN has none."""
        value = constant.value
        if constant.type is INT:
            assert isinstance(value, int)
            return value
        if isinstance(value, bool):
            return Truth(np.array(value), np.array(False))
        if not isinstance(value, Fraction):
            return Real(np.array(np.nan), np.array(0.0))
        error = abs(round_to(value, self.program.scalar) - value)
        return Real(np.array(exact(value)), np.array(float(error)))

    def _expression(self, value: Expression, state: Mapping[str, Value]) -> Value:
        """Return the value of an expression. Raises `NotImplementedError` for a node that has no error bound."""
        match value:
            case Var() | Const():
                return self._operand(value, state)
            case Op(name=name, args=args):
                return self._operation(name, [self._operand(a, state) for a in args])
            case Select(condition=c, then=a, otherwise=b):
                return self._select(self._operand(c, state), self._operand(a, state), self._operand(b, state))
            case IsFinite():
                return Truth(np.array(True), np.array(False))
            case Load(array=array, index=index):
                entry = self._operand(index, state)
                assert isinstance(entry, int)
                if any(t.name == array for t in self.program.tables):
                    return self._constant(Const(self.program.table(array).values[entry]))
                return self.arrays[array][entry]
        raise NotImplementedError(f"no error bound for {type(value).__name__}")

    def _select(self, condition: Value, then: Value, otherwise: Value) -> Value:
        """Return what a Select chooses; where its condition is undecided, the error reaches to the value that it might choose."""
        if isinstance(then, Truth) and isinstance(otherwise, Truth) and isinstance(condition, Truth):
            return Truth(
                np.where(condition.value, then.value, otherwise.value), condition.undecided | then.undecided | otherwise.undecided
            )
        assert isinstance(condition, Truth)
        assert isinstance(then, Real)
        assert isinstance(otherwise, Real)
        value = np.where(condition.value, then.value, otherwise.value)
        error = np.where(condition.value, then.error, otherwise.error)
        reach = np.abs(then.value - otherwise.value).astype(float) + np.maximum(then.error, otherwise.error)
        return Real(value, np.where(condition.undecided, reach, error))

    def _operation(self, name: str, args: list[Value]) -> Value:
        """Return an operation; a comparison is undecided where its operands are as near as their errors."""
        if name in ("iadd", "imul"):
            a, b = args
            assert isinstance(a, int)
            assert isinstance(b, int)
            return a + b if name == "iadd" else a * b
        if name in ("and", "or", "not"):
            return _logic(name, [a for a in args if isinstance(a, Truth)])
        reals = [a for a in args if isinstance(a, Real)]
        if OPERATIONS[name].compares:
            a, b = reals
            near = np.abs(a.value - b.value).astype(float) <= a.error + b.error
            return Truth(OPERATIONS[name].number(a.value, b.value), near & (a.error + b.error > 0))
        return self._arithmetic(name, reals)

    def _arithmetic(self, name: str, args: list[Real]) -> Real:
        """Return an operation on reals, by the `spread` or `change` of its row."""
        row = OPERATIONS[name]
        with np.errstate(all="ignore"):
            if row.spread is not None and row.ulps is not None:
                value, spread = row.spread(np, *args)
                return self._rounded(value, spread, row.ulps) if row.ulps else Real(value, spread)
            if row.change is not None and row.ulps is not None:
                f, floor = getattr(np, row.change[0]), row.change[1]
                return self._rounded(f(args[0].value), monotone_change(np, f, args[0], floor), row.ulps)
        raise NotImplementedError(f"no error bound for operation {name!r}")

    def _rounded(self, value: Array, spread: Array, ulps: float) -> Real:
        """Return a result with its error: `spread`, from its arguments, and its rounding by `ulps` units in the last place."""
        rounding = (np.abs(value) + spread) * (2 * ulps * self.half_ulp) + 2 * ulps * self.tiny
        return Real(value, np.asarray(spread + rounding, dtype=float))


def _logic(name: str, args: list[Truth]) -> Truth:
    undecided = args[0].undecided
    for arg in args[1:]:
        undecided = undecided | arg.undecided
    if name == "not":
        return Truth(~args[0].value, undecided)
    return Truth(args[0].value & args[1].value if name == "and" else args[0].value | args[1].value, undecided)
