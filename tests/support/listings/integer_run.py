"""Run the functions of a listing of integers on numbers, for one task.

Every value must fit the type of its name, and every operand its operation: else `UnknownMeaning`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from stt_codegen.checker.stt_checker import source
from tests.support.listings.reader import (
    PREFIX,
    Block,
    Expression,
    Function,
    Statement,
    UnknownMeaning,
    read_listing,
    require,
    statements,
)

INT16, INT32, UINT32 = range(-(1 << 15), 1 << 15), range(-(1 << 31), 1 << 31), range(1 << 32)
HALF, NATURAL, SHIFT, POSITIVE = range(1 << 16), range(1 << 31), range(32), range(1, 1 << 31)
# What the piece "arithmetic of integers" computes, and for which operands.
ARITHMETIC: Mapping[str, tuple[Callable[..., int], tuple[range, ...]]] = {
    "shift_down": (lambda a, n: a >> n, (INT32, SHIFT)),
    "shift_up": (lambda a, n: a << n, (NATURAL, SHIFT)),
    "product": (lambda a, b: a * b, (INT16, HALF)),
    "high_product": (lambda a, b: a * b >> 16, (INT32, HALF)),
    "leading": (lambda a: 31 - a.bit_length(), (POSITIVE,)),
    "low_bits": (lambda a, mask: a & mask, (INT32, NATURAL)),
}
SIGNS: Mapping[str, Callable[[int, int], int]] = {
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "<": lambda a, b: a < b,
    "&&": lambda a, b: a and b,
}  # fmt: skip
PIECES = (  # in the order of the file; of these the functions are run
    "integer segment", "integer weights", "integer rates", "integer edge", "curve", "size of an input", "integer tube",
    "integer filtered tube", "integer control", "integer margin", "integer margins", "integer covered",
)  # fmt: skip
ORDER_2_PIECES = ("integer rates", "integer filtered tube")
TYPES = {"int": INT32, "uint": UINT32, "bool": range(2)}


def integer_functions(options: set[str], values: dict[str, Any]) -> dict[str, Function]:
    """Return the functions of the listing by name, filled with the numbers of a task."""
    pieces = [piece for piece in PIECES if "order 2" in options or piece not in ORDER_2_PIECES]
    tokens = [token for piece in pieces for token in source.fill(piece, options, PREFIX, values)]
    return read_listing(tokens).functions


def literal(text: str) -> int | None:
    """Return the value of a whole number as C writes it, negative ones in brackets; None for a name."""
    digits = text.removeprefix("( ").removesuffix(" )").replace(" ", "").rstrip("U")
    return int(digits) if digits.lstrip("-").isdecimal() else None


@cache
def results_at_every_s(tokens: tuple[str, ...]) -> tuple[np.ndarray, ...]:
    """Return the results of the straight line of `weights` or `rates` for all s from 0 to 65535, one array for each.

    tokens: of the function's body. All values and operands are checked as in a run for one s."""
    columns: dict[str, Any] = {"s": np.arange(len(HALF))}
    results = list[np.ndarray]()
    for statement in statements(iter(tokens)):
        assert isinstance(statement, Statement)
        assert statement.value is not None
        kind, parts = statement.value
        names = parts[1].split(" , ") if kind == "call" else parts
        operands: list[Any] = [columns.get(name, literal(name)) for name in names]
        if statement.kind == "output":
            results.append(operands[0])
            continue
        if kind == "call":
            operation, domains = ARITHMETIC[parts[0].removeprefix(f"{PREFIX}_")]
            for operand, domain in zip(operands, domains, strict=True):
                require(domain[0] <= np.min(operand) and np.max(operand) <= domain[-1], f"{statement.text} gets other numbers")
            column: Any = operation(*operands)
        else:
            column = np.where(*operands) if kind == "choice" else SIGNS[parts[1]](operands[0], operands[2])
        require(INT32[0] <= column.min() and column.max() <= INT32[-1], f"{statement.target} may leave 32 bits")
        columns[statement.target] = column
    return tuple(results)


class IntegerRun:
    """tables: by name, as `values` of `source.fill` has them."""

    def __init__(self, functions: Mapping[str, Function], tables: Mapping[str, Sequence[int]]) -> None:
        self.functions, self.tables = functions, tables

    def call(self, name: str, *arguments: Any) -> Any:
        """Run a function, and return its result, or a tuple of what it writes through pointers. Arrays are changed in place."""
        function = self.functions[name]
        inputs = [p.name for p in function.parameters if p.passing != "output"]
        scope: dict[str, Any] = dict(zip(inputs, arguments, strict=True))
        result = self._block(function.body, scope)
        outputs = [p.name for p in function.parameters if p.passing == "output"]
        return tuple(scope[f"* {name}"] for name in outputs) if outputs else result

    def _block(self, body: Sequence[Statement | Block], scope: dict[str, Any]) -> Any:
        """Run statements, and return the function's result where one of them has it."""
        for item in body:
            if isinstance(item, Block):
                require(bool(item.index), f"a branch: {item.head}")
                for i in range(int(item.count)):
                    outer = {**scope, item.index: i}
                    self._block(item.body, outer)
                    scope |= {name: outer[name] for name in scope}
            elif item.kind == "return":
                return None if item.value is None else self._value(item.value, scope)
            else:
                self._statement(item, scope)
        return None

    def _statement(self, statement: Statement, scope: dict[str, Any]) -> None:
        """Give a name, an entry of an array, or a kernel's outputs their values."""
        if statement.kind == "declare":
            return
        assert statement.value is not None
        if statement.kind == "call":
            name, arguments = statement.value.parts
            inputs = [self._operand(text, scope) for text in arguments.split(" , ") if text[0] != "&"]
            outputs = [text[2:] for text in arguments.split(" , ") if text[0] == "&"]
            scope |= dict(zip(outputs, self.call(name.removeprefix(f"{PREFIX}_"), *inputs), strict=True))
            return
        value = self._value(statement.value, scope)
        if statement.kind == "define" and statement.value_type in TYPES:
            require(value in TYPES[statement.value_type], f"{statement.target} is {value}")
        if statement.kind == "store":
            scope[statement.target][scope[statement.index]] = value
        else:
            scope[f"* {statement.target}" if statement.kind == "output" else statement.target] = value

    def _operand(self, text: str, scope: dict[str, Any]) -> Any:
        constants = {"true": True, "false": False, "C_OK": 0, "C_OUTSIDE_TUBE": 1}
        if text in scope or text in constants:
            return scope[text] if text in scope else constants[text]
        value = literal(text)
        require(value is not None, f"{text} has no value")
        return value

    def _value(self, expression: Expression, scope: dict[str, Any]) -> Any:
        """Return the value of an expression."""
        match expression:
            case Expression("operand", (text,)):
                return self._operand(text, scope)
            case Expression("negation", (text,)):
                return -self._operand(text, scope)
            case Expression("choice", (condition, first, second)):
                return self._operand(first if scope[condition] else second, scope)
            case Expression("operation", (first, sign, second)):
                return SIGNS[sign](self._operand(first, scope), self._operand(second, scope))
            case Expression("cast", (_, text)):
                return self._operand(text, scope)
            case Expression("low half", (text,)):
                require(scope[text] in INT16, f"{text} is {scope[text]}")
                return scope[text]
            case Expression("table", (_, table, index)):
                require(scope[index] in range(len(self.tables[table])), f"{table} has no entry {scope[index]}")
                return int(self.tables[table][scope[index]])
            case Expression("load", (array, index)):
                return scope[array][scope[index]]
            case Expression("call", (name, arguments)):
                return self._called(name.removeprefix(f"{PREFIX}_"), [self._operand(t, scope) for t in arguments.split(" , ")])
        raise UnknownMeaning(f"this is no expression of integers: {expression}")

    def _called(self, name: str, arguments: list[int]) -> Any:
        if name not in ARITHMETIC:
            return self.call(name, *arguments)
        operation, domains = ARITHMETIC[name]
        is_inside = all(v in domain for v, domain in zip(arguments, domains, strict=True))
        require(is_inside, f"{name} gets {arguments}")
        return operation(*arguments)
