"""The text of a formula, read: from what binds least `->`, or, and, until; then always, eventually and not."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction

from stt_codegen.decimals import decimal
from stt_codegen.task.mission.formulas import (
    WORDS,
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
MOST_TEXT = 2000  # characters of a formula
MOST_NESTED = 40  # operators in one another
PRECEDENCE = ("->", "or", "and", "until")  # from what binds least


def parse_formula(text: str) -> Formula:
    """The formula that a text says, in negation normal form. Raises `ValueError` with the place and what would be right."""
    if len(text) > MOST_TEXT:
        raise ValueError(f"has {len(text)} characters; at most {MOST_TEXT} are taken, use several entries")
    return _Reader(text).whole()


class _Reader:
    """A reader by descent: each method reads what its name says and leaves the place behind it."""

    def __init__(self, text: str) -> None:
        self.text, self.words, self.at, self.depth = text, list(self._tokens(text)), 0, 0

    @staticmethod
    def _tokens(text: str) -> Iterator[tuple[str, int]]:
        place = 0
        while text[place:].strip():
            found = TOKEN.match(text, place)
            if found is None:
                rest = text[place:].lstrip()
                place = len(text) - len(rest)
                raise ValueError(
                    f"{rest[:12]!r} at character {place + 1} is no word of a formula; regions, {', '.join(WORDS)} are"
                )
            yield found.group().strip(), found.end() - len(found.group().strip())
            place = found.end()

    @property
    def word(self) -> str:
        return self.words[self.at][0] if self.at < len(self.words) else ""

    def fail(self, wanted: str) -> ValueError:
        if self.at >= len(self.words):
            return ValueError(f"ends where {wanted} is needed")
        before = self.words[self.at - 1][0] if self.at else ""
        close = difflib.get_close_matches(before.lower(), ("always", "eventually", "until"), 1) if before not in WORDS else []
        if self.word == "[" and before:
            return ValueError(
                f"has a window after {before!r}, which is no operator" + (f"; did you mean {close[0]!r}?" if close else "")
            )
        return ValueError(f"has {self.word!r} at character {self.words[self.at][1] + 1}, where {wanted} is needed")

    def need(self, word: str) -> None:
        if self.word != word:
            raise self.fail(repr(word))
        self.at += 1

    def whole(self) -> Formula:
        found = self.binary(0)
        if self.at < len(self.words):
            raise self.fail("the end, or one of and, or, until, ->,")
        return found

    def binary(self, level: int) -> Formula:
        """What is joined by the operators of PRECEDENCE from `level` on."""
        self.depth += 1
        if self.depth > MOST_NESTED * (len(PRECEDENCE) + 1):
            raise ValueError(f"is nested more than {MOST_NESTED} deep; use several entries")
        if level == len(PRECEDENCE):
            found = self.unary()
        else:
            sign, found = PRECEDENCE[level], self.binary(level + 1)
            while self.word == sign:
                self.at += 1
                if sign == "->":  # a -> b -> c is a -> (b -> c)
                    found = disjunction(negation(found), self.binary(level))
                elif sign == "until":
                    found = Until(self.interval(), found, self.binary(level + 1))
                else:
                    found = (conjunction if sign == "and" else disjunction)(found, self.binary(level + 1))
        self.depth -= 1
        return found

    def unary(self) -> Formula:
        word = self.word
        if word in ("not", "always", "eventually"):
            self.at += 1
            if word == "not":
                return negation(self.binary(len(PRECEDENCE)))
            over = self.interval()
            return (Always if word == "always" else Eventually)(over, self.binary(len(PRECEDENCE)))
        if word == "(":
            self.at += 1
            found = self.binary(0)
            self.need(")")
            return found
        if not re.fullmatch(r"[A-Za-z]\w*", word) or word in WORDS:
            raise self.fail("a region, a bracket, not, always or eventually")
        self.at += 1
        return InRegion(word)

    def interval(self) -> Interval:
        if self.word != "[":
            return Interval()
        self.at += 1
        begin = self.number()
        self.need(",")
        if self.word == "inf":
            self.at += 1
            end = None
        else:
            end = self.number()
        self.need("]")
        if end is not None and end < begin:
            raise ValueError(f"has a window from {decimal(begin)} to {decimal(end)}; from must not be after to")
        return Interval(begin, end)

    def number(self) -> Fraction:
        if not self.word[:1].isdigit():
            raise self.fail("a number of seconds")
        self.at += 1
        value = Decimal(self.words[self.at - 1][0])
        if value and not -10 < value.adjusted() < 10:
            raise ValueError(f"has the number {value}; use 0 or seconds from 1e-9 to 1e9")
        return Fraction(value)
