"""Read the constants of spline time, and the statements of `basis` and `edge_at`, from C.

A theorem about the tube alone has these as numbers and statements of the C file; theorem/reading.py calls this. What is not read,
as the loads of `edge_at`, has to be the text of the stand-alone checker's listing. benchmarks/gappa.py reads the listing itself.
"""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Any

from stt_codegen.checker.stt_checker.exact import require, rounded
from stt_codegen.checker.stt_checker.source import REAL, fill, is_same
from stt_codegen.theorem.facts import Operand, Statement

KERNEL_STATEMENT = re.compile(r"const \w+ (\w+) = (?:(\S+) )?([-+*]) (\S+)")  # a sign alone is a difference from 0
TIME_CONSTANTS = ("per_second", "last")  # in the listing: K/t_c, and the largest spline time below K


class KernelText:
    """The tokens of a C file in floating point, for n dimensions and numbers of so many bits.

    All methods raise `Refused` where the C has something else.
    """

    def __init__(self, words: list[str], name: str, n: int, bits: int) -> None:
        self.words, self.name, self.n, self.bits = words, name, n, bits

    def number(self, literal: str) -> Fraction:
        """Return the value of a literal, as the compiler rounds it."""
        is_single, digits = self.bits == 24, literal.removesuffix("F")
        is_literal = REAL.fullmatch(digits) is not None and literal.endswith("F") == is_single
        require(is_literal, f"the C has {literal!r} where a number is needed")
        return rounded(Fraction(digits), self.bits)

    def listed(self, piece: str) -> list[str]:
        """Return the tokens of a piece of the listing. In place of the time constants it has their names."""
        rows = {f"row_{j}": 2 * self.n * j for j in (1, 2, 3)}
        values: dict[str, Any] = {"pairs": 2 * self.n, **rows, **{name: name for name in TIME_CONSTANTS}}
        return fill(piece, set(), self.name, values)

    def read(self, function: str, listed: list[str]) -> tuple[dict[str, str], list[str]]:
        """Require that the definition of a function begins with these tokens. Return the C's literals for the time constants, and
        the other statements of the body."""
        label = f"{self.name}_{function}"
        require(label in self.words, f"the C has no {function}")
        begin, constants = self.words.index(label) - listed.index(label), dict[str, str]()
        end = begin + len(listed)
        for word, expected in zip(self.words[begin:end], listed, strict=False):
            if expected in TIME_CONSTANTS:
                is_known = constants.setdefault(expected, word) == word
                require(is_known, f"`{function}` holds time at another number than it compares it with")
            else:
                is_listed = is_same(word, expected, self.bits == 24, self.bits)
                require(is_listed, f"`{function}` of the C has {word!r} where the listing has {expected!r}")
        rest = " ".join(self.words[end:]).partition(" }")[0]
        return constants, [statement.strip() for statement in rest.split(";")[:-1]]


def read_spline_time(c: KernelText) -> tuple[Fraction, Fraction]:
    """Return K/t_c and the largest spline time below K, the two constants of `segment`."""
    constants, _ = c.read("segment", c.listed("segment of a time"))
    per_second, last = (c.number(constants[name]) for name in TIME_CONSTANTS)
    return per_second, last


class KernelReader:
    """Turns the statements of straight-line C functions into one list of numbered `Statement`s.

    Values 0 to 4 are s and the four entries of the table; the k-th statement, from 1, is value 4 + k.
    """

    def __init__(self, c: KernelText) -> None:
        self.c = c
        self.code: list[Statement] = []

    @property
    def last_value(self) -> int:
        """The number of the value that the last statement computes."""
        return 4 + len(self.code)

    def read(self, statements: list[str], known: dict[str, int]) -> dict[str, int]:
        """Append statements; return the numbers of what they store and return, by `* w0 =`, `return`.

        known: numbers of the values that they take, by name.
        """
        numbers, results = dict(known), dict[str, int]()
        for statement in statements:
            match = KERNEL_STATEMENT.fullmatch(statement)
            if match is None:
                destination, _, value = statement.rpartition(" ")
                results[destination] = numbers[value]
                continue
            self.code.append((match[3], self._operand(match[2], numbers), self._operand(match[4], numbers)))
            numbers[match[1]] = self.last_value
        return results

    def _operand(self, text: str | None, numbers: dict[str, int]) -> Operand:
        if text in numbers:
            return "V", numbers[text]
        value = Fraction(0) if text is None else self.c.number(text)
        require(value.denominator == 1, f"`basis` has the constant {text}, which is not whole")
        return "C", int(value)


def read_kernels(c: KernelText, is_rate: bool = False) -> tuple[Statement, ...]:
    """Return the statements of `basis` and then those of `edge_at` on four entries of the table, as one list.

    is_rate: those of `basis_rate`, for the edge's slope, in place of those of `basis`."""
    piece, function, weight = ("rate of the basis", "basis_rate", "dw") if is_rate else ("basis", "basis", "w")
    reader, basis, edge = KernelReader(c), c.listed(piece), c.listed("edge")
    stored = reader.read(c.read(function, basis[: basis.index("{") + 1])[1], {"s": 0})
    require(list(stored) == [f"* {weight}{j} =" for j in range(4)], f"`{function}` stores other results than it should")
    values = {f"w{j}": stored[f"* {weight}{j} ="] for j in range(4)} | {f"q{j}": 1 + j for j in range(4)}
    returned = reader.read(c.read("edge_at", edge[: edge.index("v0") - 2])[1], values)  # after the four loads
    require(returned == {"return": reader.last_value}, "`edge_at` returns another value than its last")
    return tuple(reader.code)
