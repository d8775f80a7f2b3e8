"""The grammar of a mission's formulas: from text to a `Formula`.

Operators from the weakest binding to the strongest: `->`, or, and, until; then the prefixes always, eventually and not.
The entries of regions.py call it; docs/missions.md explains the language.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction

from stt_codegen.decimals import decimal
from stt_codegen.task.mission.formulas import (
    KEYWORDS,
    Always,
    Eventually,
    Formula,
    InRegion,
    Interval,
    Until,
    conjunction,
    disjunction,
    negation,
)

TOKEN = re.compile(r"\s*(?:(->)|([A-Za-z][A-Za-z0-9_]*)|(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)|([\[\](),]))")
TEXT_LENGTH_LIMIT = 2000  # characters of a formula
NESTING_LIMIT = 40  # operators inside one another
PRECEDENCE = ("->", "or", "and", "until")  # from the weakest binding


def parse_formula(text: str) -> Formula:
    """Return the formula of a text, in negation normal form.

    Raises `ValueError` that says where the text is wrong and what is needed there.
    """
    if len(text) > TEXT_LENGTH_LIMIT:
        raise ValueError(f"has {len(text)} characters; at most {TEXT_LENGTH_LIMIT} are taken, use several entries")
    return _FormulaParser(text).formula()


class _FormulaParser:
    """A recursive-descent parser: each method reads the tokens that its name says and advances `index` past them."""

    def __init__(self, text: str) -> None:
        self.tokens, self.index, self.depth = list(self._split(text)), 0, 0

    @staticmethod
    def _split(text: str) -> Iterator[tuple[str, int]]:
        """Yield each token with the index of its first character."""
        position = 0
        while text[position:].strip():
            match = TOKEN.match(text, position)
            if match is None:
                rest = text[position:].lstrip()
                raise ValueError(
                    f"{rest[:12]!r} at character {len(text) - len(rest) + 1} is no word of a formula; regions, "
                    f"{', '.join(KEYWORDS)} are"
                )
            token = match.group().strip()
            yield token, match.end() - len(token)
            position = match.end()

    @property
    def token(self) -> str:
        """The next token; an empty text at the end."""
        return self.tokens[self.index][0] if self.index < len(self.tokens) else ""

    def error(self, needed: str) -> ValueError:
        """Return the error that says what is needed in place of the next token."""
        if self.index >= len(self.tokens):
            return ValueError(f"ends where {needed} is needed")
        before = self.tokens[self.index - 1][0] if self.index else ""
        close = difflib.get_close_matches(before.lower(), ("always", "eventually", "until"), 1) if before not in KEYWORDS else []
        if self.token == "[" and before:
            return ValueError(
                f"has a window after {before!r}, which is no operator" + (f"; did you mean {close[0]!r}?" if close else "")
            )
        return ValueError(f"has {self.token!r} at character {self.tokens[self.index][1] + 1}, where {needed} is needed")

    def require(self, token: str) -> None:
        """Read this token, or raise."""
        if self.token != token:
            raise self.error(repr(token))
        self.index += 1

    def formula(self) -> Formula:
        """Read a formula that goes to the end of the text."""
        formula = self.binary(0)
        if self.index < len(self.tokens):
            raise self.error("the end, or one of and, or, until, ->,")
        return formula

    def binary(self, level: int) -> Formula:
        """Read operands joined by the operators of PRECEDENCE from `level` on."""
        self.depth += 1
        if self.depth > NESTING_LIMIT * (len(PRECEDENCE) + 1):
            raise ValueError(f"is nested more than {NESTING_LIMIT} deep; use several entries")
        if level == len(PRECEDENCE):
            formula = self.unary()
        else:
            operator, formula = PRECEDENCE[level], self.binary(level + 1)
            while self.token == operator:
                self.index += 1
                if operator == "->":  # a -> b -> c is a -> (b -> c)
                    formula = disjunction(negation(formula), self.binary(level))
                elif operator == "until":
                    formula = Until(self.interval(), formula, self.binary(level + 1))
                else:
                    formula = (conjunction if operator == "and" else disjunction)(formula, self.binary(level + 1))
        self.depth -= 1
        return formula

    def unary(self) -> Formula:
        """Read a region, a formula in brackets, or one behind not, always or eventually."""
        word = self.token
        if word in ("not", "always", "eventually"):
            self.index += 1
            if word == "not":
                return negation(self.binary(len(PRECEDENCE)))
            over = self.interval()
            return (Always if word == "always" else Eventually)(over, self.binary(len(PRECEDENCE)))
        if word == "(":
            self.index += 1
            formula = self.binary(0)
            self.require(")")
            return formula
        if not re.fullmatch(r"[A-Za-z]\w*", word) or word in KEYWORDS:
            raise self.error("a region, a bracket, not, always or eventually")
        self.index += 1
        return InRegion(word)

    def interval(self) -> Interval:
        """Read [begin, end] in seconds, end may be inf; without a bracket the interval is all times."""
        if self.token != "[":
            return Interval()
        self.index += 1
        begin = self.number()
        self.require(",")
        if self.token == "inf":
            self.index += 1
            end = None
        else:
            end = self.number()
        self.require("]")
        if end is not None and end < begin:
            raise ValueError(f"has a window from {decimal(begin)} to {decimal(end)}; from must not be after to")
        return Interval(begin, end)

    def number(self) -> Fraction:
        """Read a number of seconds."""
        if not self.token[:1].isdigit():
            raise self.error("a number of seconds")
        self.index += 1
        value = Decimal(self.tokens[self.index - 1][0])
        if value and not -10 < value.adjusted() < 10:
            raise ValueError(f"has the number {value}; use 0 or seconds from 1e-9 to 1e9")
        return Fraction(value)
