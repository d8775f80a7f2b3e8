"""That the listing in integers means what integer_specification.py says, for one combination of its options, and how wrong its weights are.

Holes are filled with words that stand for symbols. Each function is compared twice: with every loss of bits, and without any.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

from stt_codegen.checker.stt_checker import source
from stt_codegen.checker.stt_checker.integers import RATE_POWER_ERROR, WEIGHT_ERROR
from tests.support.listings.changes import changed_pieces
from tests.support.listings.field import PRIME
from tests.support.listings.integer_run import ARITHMETIC, HALF, integer_functions, results_at_every_s
from tests.support.listings.integer_specification import (
    HOLES,
    ExactIntegerSpecification,
    IntegerPath,
    IntegerSpecification,
    IntegerSymbols,
)
from tests.support.listings.machine import Array, Path, Scope, SymbolicMachine, Value
from tests.support.listings.meaning import add_results
from tests.support.listings.reader import PREFIX, Expression, Function, Listing, Table, UnknownMeaning, read_listing, require

CHOICES = (
    ("order 1", "order 2"),
    ("short", "long"),
    ("coarse", "fine"),
    ("positive", "negative"),
    ("plain filter", "scaled filter"),
)
STARTS = ("start_lower", "start_upper", "filtered_start_lower", "filtered_start_upper")
BY_COMPONENT = {
    "filters": "",
    "gains": "16",
    "shift_offsets": "8",
    "limits": "32",
    **dict.fromkeys(STARTS, ""),
}  # bits, or a hole
CURVES = {"levels": "16", "slopes": "16", "bends": "16", "h_shifts": "8"}
TYPES = {"8": "uint8_t", "16": "uint16_t", "32": "int32_t"}


def integer_combinations() -> Iterator[set[str]]:
    """Yield all combinations of options. Filters are of order 2."""
    for alternatives in itertools.product(*CHOICES):
        if "order 2" in alternatives or "plain filter" in alternatives:
            yield {word for word in alternatives if "filter" not in word or "order 2" in alternatives}


def filled_integer_listing(options: set[str]) -> Listing:
    """Return the listing with the word number_<name> in the place of every number, without the arithmetic: that is compiled."""
    tables = ("coefficients", *BY_COMPONENT, *CURVES)
    names = (*HOLES, "ticks", *tables, *(f"{name}_{part}" for name in tables for part in ("type", "bits")))
    with changed_pieces({"arithmetic of integers": []}):
        return read_listing(source.fill("integer controller", options, PREFIX, {name: f"number_{name}" for name in names}))


def expected_tables(options: set[str]) -> dict[str, Table]:
    """Return the words for size, entries and type of all tables, by name and in their order."""
    has_order_2 = "order 2" in options
    sizes = {"coefficients": "entries", **({"filters": "n"} if has_order_2 else {}), **dict.fromkeys(CURVES, "rows")}
    sizes |= {name: "n" for name in BY_COMPONENT if has_order_2 or not name.startswith("filter")}
    return {name: Table(f"number_{size}", f"number_{name}", type_of(name)) for name, size in sizes.items()}


def bits_of(table: str) -> str:
    """Return how many bits an entry of a table has, or the word for it."""
    return (BY_COMPONENT | CURVES).get(table) or f"number_{table}_bits"


def type_of(table: str) -> str:
    return TYPES.get(bits_of(table), f"number_{table}_type")


class IntegerMachine(SymbolicMachine):
    """Runs integers. A comparison is a symbol, and so is the choice after it."""

    number_type, path_type, opaque = "int", IntegerPath, ("segment", "weights", "rates", "edge_at")
    symbols: IntegerSymbols

    def _value(self, path: Path, expression: Expression | None, scope: Scope) -> Value:
        """Return the value of an expression. A choice is a symbol, and a table has entries of its type."""
        match expression:
            case Expression("choice", (condition, first, second)):
                choices = [self._operand(text, scope) for text in (first, second)]
                require(choices[0].value_type == choices[1].value_type, f"a choice between two types: {expression}")
                answer = self._typed_operand(condition, scope, "bool")
                return Value(choices[0].value_type, self.symbols.choice(answer, choices[0].content, choices[1].content))
            case Expression("operation", (first, "&&", second)):
                return Value(
                    "bool", self.symbols.symbol("and", *(self._typed_operand(v, scope, "bool") for v in (first, second)))
                )
            case Expression("low half", (text,)):
                return Value("int", self._typed_operand(text, scope, "int"))  # integer_ranges.py: it has 16 bits
            case Expression("table", (bits, table, index)):
                return Value("int", self._entry(bits, table, self._typed_operand(index, scope, "int")))
        return super()._value(path, expression, scope)

    def _entry(self, bits: str, table: str, index: int) -> int:
        require(table in self.listing.tables and bits == bits_of(table), f"{table} has no entries of {bits} bits")
        require(table not in BY_COMPONENT or index == self.i, f"{table} is read at another component")
        return self.symbols.symbol(f"load {table}", index)

    def _call(self, path: Path, name: str, arguments: Sequence[str], scope: Scope) -> Value:
        operation = name.removeprefix(f"{PREFIX}_")
        if operation not in ARITHMETIC:
            return super()._call(path, name, arguments, scope)
        require(len(arguments) == len(ARITHMETIC[operation][1]), f"{name} gets {len(arguments)} operands")
        return Value("int", self.symbols.arithmetic(operation, *(self._typed_operand(text, scope, "int") for text in arguments)))

    def _opaque(self, kernel: str, inputs: Sequence[Value]) -> list[Value]:
        """Return symbols for the results of a kernel. `UnknownMeaning` where it gets anything else than the tick, its place, an index of
        this segment, or the weights of this place in their order."""
        parameters = self.listing.functions[kernel].parameters
        types = [p.value_type for p in parameters if p.passing == "value"]
        require([v.value_type for v in inputs] == types, f"{kernel} gets other arguments")
        symbol, contents = self.symbols.symbol, [v.content for v in inputs]
        weights = {name: [symbol(f"{name[0]}{j}") for j in range(3)] for name in ("weights", "rates")}
        row, has_rates = symbol("row"), "rates" in self.listing.functions
        lower = (row + 2 * self.i) % PRIME
        match kernel:
            case "segment":
                known = {symbol("tick"): [row, symbol("s")]}.get(contents[0])
            case "curve":
                known = [symbol("curve", *contents)]
            case "edge_at":
                is_known = contents[1:] == [*weights["weights"], *(weights["rates"] if has_rates else [])]
                side = {lower: "L", (lower + 1) % PRIME: "U"}.get(contents[0])
                known = [symbol(f"{side}{prime}") for prime in ("", "'")[: 1 + has_rates]] if is_known and side else None
            case _:
                known = weights[kernel] if contents == [symbol("s")] else None
        if known is None:
            raise UnknownMeaning(f"{kernel} gets something else than what belongs to this tick and component")
        return [Value("int", value) for value in known]


class ExactIntegerMachine(IntegerMachine):
    """Runs integers of which no bit is lost; the curves are functions."""

    opaque = (*IntegerMachine.opaque, "curve")


def arguments_of_kernels(symbols: IntegerSymbols, options: set[str], is_exact: bool) -> dict[str, list[Value]]:
    """Return the arguments of kernels by name. Without rounding those of `edge_at` are the weights of a place."""
    symbol = symbols.symbol
    weights = [symbol(f"{name}{j}") for name in ("wr" if "order 2" in options else "w") for j in range(3)]
    if is_exact:
        s, unit = symbol("place"), symbols.power(symbol("number rate_bits")) * symbol("segments a second")
        steps = (1 - s) ** 3 << 15, 3 * s + 3 * s**2 - 2 * s**3 << 14, s**3 << 15
        rates = 3 * (1 - s) ** 2 * unit, (3 + 6 * s * (1 - s)) * unit, 3 * s**2 * unit
        weights = [v % PRIME for v in (*steps, *rates)][: len(weights)]
        return {"edge_at": [Value("int", v) for v in (symbol("at"), *weights)]}
    arguments = {"weights": ["s"], "rates": ["s"], "curve": ["row", "t"]}
    values = {name: [Value("int", symbol(v)) for v in names] for name, names in arguments.items()}
    return values | {"segment": [Value("uint", symbol("tick"))], "edge_at": [Value("int", v) for v in (symbol("at"), *weights)]}


def arguments_of_functions(symbols: IntegerSymbols, options: set[str]) -> dict[str, list[Value | Array]]:
    """Return the arguments of the public functions by name."""
    tick = Value("uint", symbols.symbol("tick"))
    state = [Array(name, False) for name in (("x", "v") if "order 2" in options else ("x",))]
    tube = [tick, Array("lower", True), Array("upper", True)]
    filtered = {"filtered_tube": tube} if "order 2" in options else {}
    return {
        "tube": tube, **filtered, "control": [tick, *state, Array("u", True)], "margin": [tick, *state],
        "margins": [tick, *state, Array("margin", True)], "covered": [*state],
    }  # fmt: skip


def check_integer_meaning(options: set[str]) -> int:
    """Compare every function of the listing with its specification, and return how many comparisons there were.

    Raises `UnknownMeaning` where they differ."""
    listing, has_order_2 = filled_integer_listing(options), "order 2" in options
    includes = ('#include "c.h"', "#include <stdbool.h>")
    require(listing.directives == includes and not listing.assertions, "the listing has other directives than it should")
    kernels = ["segment", "weights", *(["rates"] if has_order_2 else []), "edge_at", "curve", "input_size"]
    public = [*arguments_of_functions(IntegerSymbols(), options)]
    require([*listing.functions] == [*kernels, *public], "the listing has other functions than it should")
    require([*listing.tables.items()] == [*expected_tables(options).items()], "the listing has other tables than it should")
    count = 0
    for is_exact in (False, True):
        symbols = IntegerSymbols(rounds=not is_exact)
        words = {f"number_{name}": Value("int", symbols.symbol(f"number {name}")) for name in HOLES}
        words["( - number_largest_x )"] = Value("int", -symbols.symbol("number largest_x") % PRIME)
        words["number_ticksU"] = Value("uint", symbols.symbol("number ticks"))
        machine = (ExactIntegerMachine if is_exact else IntegerMachine)(listing, symbols, words)
        specification = (ExactIntegerSpecification if is_exact else IntegerSpecification)(symbols, options)
        for name, inputs in arguments_of_kernels(symbols, options, is_exact).items():
            if name in listing.functions:
                count += machine.explore(name, getattr(specification, name), partial(add_results, machine, name, inputs))
        for name, arguments in arguments_of_functions(symbols, options).items():
            action: Callable[[Path], None] = partial(machine.run, name=name, arguments=arguments)
            count += machine.explore(name, getattr(specification, name), action)
    return count


# ---- errors of weights, at every place of a segment


def weight_error(functions: Mapping[str, Function]) -> Fraction:
    """Return how far the weights of an edge are off at most, in steps: the outer two together, and the middle one of another step."""
    w0, w1, w2 = results_at_every_s(functions["weights"].tokens)
    s, unity = np.arange(len(HALF), dtype=np.int64), 1 << 16
    outer = abs((w0 << 33) - (unity - s) ** 3) + abs((w2 << 33) - s**3)
    inner = abs((w1 << 34) - s * (3 * unity * unity + s * (3 * unity - 2 * s)))
    return Fraction(int(outer.max()) + int(inner.max()), 1 << 48)


def rate_power_error(options: set[str], values: Mapping[str, Any]) -> Fraction:
    """Return how far the powers of s in the weights of a rate are off together: what is left of the statements before the products with
    a mantissa."""
    tokens = integer_functions(options, dict(values))["rates"].tokens
    lines = [line for line in " ".join(tokens).split(" ; ") if not any(v in line for v in ("per_second", "and_half", "_weight"))]
    outputs = [f"* r{k} = {name}_tripled" for k, name in enumerate(("first", "middle", "last"))]
    columns = results_at_every_s(tuple(" ; ".join([*lines, *outputs, ""]).split()))
    s, unity = np.arange(len(HALF), dtype=np.int64), 1 << 16
    exact = 3 * (unity - s) ** 2, 3 * unity * unity + 6 * s * (unity - s), 3 * s * s  # in units of 2^-32
    errors = sum(abs((column << 4) - v) for column, v in zip(columns, exact, strict=True))
    return Fraction(int(np.max(errors)), 1 << 32)


def check_weight_errors(options: set[str], values: Mapping[str, Any]) -> None:
    """Require that the constants of integers.py are the errors of all weights, and no larger."""
    functions = integer_functions(options, dict(values))
    require(weight_error(functions) == WEIGHT_ERROR, "the weights of an edge are off by another constant")
    if "order 2" in options:
        require(rate_power_error(options, values) == RATE_POWER_ERROR, "the powers of s in a rate are off by another constant")
