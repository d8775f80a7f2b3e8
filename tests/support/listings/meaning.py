"""That the listings in floating point mean what specification.py says, for one combination of their options.

Holes are filled with words, and the words stand for symbols: what is found to be equal is equal for all numbers of all tasks.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from stt_codegen.checker.stt_checker import source
from tests.support.listings.field import PRIME, Symbols
from tests.support.listings.machine import Array, Path, SymbolicMachine, Value
from tests.support.listings.reader import PREFIX, Listing, Table, read_listing, require
from tests.support.listings.specification import INTEGERS, NEGATED_NUMBERS, REAL_NUMBERS, STARTS, Specification

KERNELS = "segment basis basis_rate edge_at normalized_error transformed_error law".split()
HEADERS = ('"c.h"', "<float.h>", "<math.h>", "<stdbool.h>", "<stdint.h>", "<string.h>")
DIRECTIVES = "#if #elif #endif #error".split()  # these change nothing of the code between them, since none is
WORDS_OF_TEXTS = "bytes cut places mask word hash".split()  # of what is no number of the law


def filled_listing(name: str, options: set[str]) -> Listing:
    """Return a listing with the word number_<name> in the place of every number."""
    words = {hole: f"number_{hole}" for hole in (*REAL_NUMBERS, *INTEGERS, *STARTS, *WORDS_OF_TEXTS, "coefficients")}
    words |= {f"{hole}_minus": f"number_{hole}_minus" for hole in NEGATED_NUMBERS}
    words |= {f"{hole}_table": f"number_{hole}_table" for hole in (*REAL_NUMBERS, "u_max")}
    words |= {"log": "logf" if "float" in options else "log", "scalar": "float" if "float" in options else "double"}
    return read_listing(source.fill(name, options, PREFIX, words))


def values_of_words(symbols: Symbols) -> dict[str, Value]:
    """Return the symbols that stand for the words."""
    words = {f"number_{name}": Value("real", symbols.symbol(f"number {name}")) for name in REAL_NUMBERS}
    words |= {f"number_{name}_minus": Value("real", -symbols.symbol(f"number {name}") % PRIME) for name in NEGATED_NUMBERS}
    words |= {f"number_{name}": Value("int", symbols.symbol(f"number {name}")) for name in INTEGERS}
    return words | {"number_ticksU": Value("uint", symbols.symbol("number ticks"))}


def expected_functions(options: set[str]) -> list[str]:
    """Return the names of all functions in their order."""
    has_ticks, has_order_2 = "ticks" in options, "order 2" in options
    names = ["exponent", "mantissa"] if "inline" in options else []
    names += ["segment", *(["segment_at_tick"] if has_ticks else []), *KERNELS[1:], "tube", "tube_rate"]
    names += ["filtered_tube"] if has_order_2 else []
    names += ["velocity"] if has_order_2 and "differences" in options else []
    return [*names, "control", *(["control_tick"] if has_ticks else []), "margin", "margins", "covered", "transform"]


def expected_tables(options: set[str]) -> dict[str, Table]:
    """Return the words for size, entries and type of all tables, by name and in their order."""
    has_order_2 = "order 2" in options
    tables = {"coefficients": ("entries", "coefficients")}
    tables |= {"filter": ("n", "filter_table")} if has_order_2 and "filters" in options else {}
    tables |= {"gain": ("n", "gain_table")} if "gains" in options else {}
    tables |= {"e_max": ("n", "e_max_table"), "least_share": ("n", "smallest_share_table")} if "clamps" in options else {}
    tables |= {"u_max": ("n", "u_max_table")} if "limits" in options else {}
    tables |= {name: ("n", name) for name in STARTS[: 4 if has_order_2 else 2]}
    return {name: Table(f"number_{size}", f"number_{entries}", f"{PREFIX}_real") for name, (size, entries) in tables.items()}


def arguments_of_functions(symbols: Symbols, options: set[str]) -> dict[str, list[Value | Array]]:
    """Return the arguments of the public functions by name."""
    t, tick, dt = Value("real", symbols.symbol("t")), Value("uint", symbols.symbol("tick")), Value("real", symbols.symbol("dt"))
    state = [Array(name, False) for name in (("x", "v") if "order 2" in options else ("x",))]
    lower, upper = (Array(name, True) for name in ("lower", "upper"))
    return {
        "tube": [t, lower, upper],
        "tube_rate": [t, Array("lower_rate", True), Array("upper_rate", True)],
        "filtered_tube": [t, lower, upper],
        "velocity": [dt, Array("x", False), Array("x_before", False), Array("v", True)],
        "control": [t, *state, Array("u", True)],
        "control_tick": [tick, *state, Array("u", True)],
        "margin": [t, *state],
        "margins": [t, *state, Array("margin", True)],
        "covered": [*state],
        "transform": [*(Array(k, False) for k in ("lower", "upper", "x")), *(Array(k, True) for k in ("e", "epsilon", "xi"))],
    }


def check_meaning(options: set[str], listing: Listing | None = None) -> int:
    """Compare every function of the listing with its specification. Return how many combinations of answers were compared.

    Raises `UnknownMeaning` where they differ."""
    listing = listing or filled_listing("controller", options)
    check_directives(listing)
    symbols = Symbols()
    machine = SymbolicMachine(listing, symbols, values_of_words(symbols), "scaled" in options)
    specification = Specification(symbols, options)
    require([*listing.functions] == expected_functions(options), "the listing has other functions than it should")
    require([*listing.tables.items()] == [*expected_tables(options).items()], "the listing has other tables than it should")
    count = sum(check_spline_kernel(listing, name) for name in ("basis", "basis_rate", "edge_at"))
    for name in ("segment", "segment_at_tick") if "ticks" in options else ("segment",):
        time = Value("uint", symbols.symbol("tick")) if name == "segment_at_tick" else Value("real", symbols.symbol("t"))
        count += machine.explore(name, getattr(specification, name), partial(add_results, machine, name, [time]))
    for name, arguments in arguments_of_functions(symbols, options).items():
        if name in listing.functions:
            action: Callable[[Path], None] = partial(machine.run, name=name, arguments=arguments)
            count += machine.explore(name, getattr(specification, name), action)
    return count


def check_directives(listing: Listing) -> None:
    """Require that nothing but known headers is included, that no macro is defined, and that pragmas only forbid what would change
    results."""
    pragmas = [line for line in listing.directives if line.startswith("#pragma")]
    forbidding = ["#pragma STDC FP_CONTRACT OFF", "#pragma clang fp reassociate(off)", '#pragma GCC optimize ("fp-contract=off")']
    require(pragmas == forbidding, "the listing has other pragmas than it should")
    for line in listing.directives:
        word, _, rest = line.partition(" ")
        is_known = word in DIRECTIVES or line in pragmas or (word == "#include" and rest in HEADERS)
        require(is_known, f"the listing has the directive {line}")


def add_results(machine: SymbolicMachine, name: str, arguments: list[Value], path: Path) -> None:
    path.effects.append(machine.kernel_results(path, name, arguments))


def check_spline_kernel(listing: Listing, name: str) -> int:
    """Compare a kernel that evaluates splines with its polynomials, without rounding: rounding.py bounds that."""
    symbols = Symbols(rounds=False)
    machine = SymbolicMachine(listing, symbols, values_of_words(symbols))
    s, at = symbols.symbol("s"), symbols.symbol("at")
    weights = [Value("real", symbols.symbol(f"w{j}")) for j in range(4)]
    rows = [at, *(at + symbols.symbol(f"number row_{j}") for j in (1, 2, 3))]
    polynomials = {
        "basis": [(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3],
        "basis_rate": [-3 * (1 - s) ** 2, 9 * s**2 - 12 * s, -9 * s**2 + 6 * s + 3, 3 * s**2],
        "edge_at": [
            sum(w.content * symbols.symbol("load coefficients", row % PRIME) for w, row in zip(weights, rows, strict=True))
        ],
    }
    arguments = [Value("int", at), *weights] if name == "edge_at" else [Value("real", s)]

    def specify(path: Path) -> None:
        path.effects.append([Value("real", value % PRIME) for value in polynomials[name]])

    return machine.explore(name, specify, partial(add_results, machine, name, arguments))
