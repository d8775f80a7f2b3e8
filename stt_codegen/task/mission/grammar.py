"""The grammar of a mission's formulas: from text to a `Formula`.

Operators from the weakest binding to the strongest: `<->` and `->`, or, and, until; then the prefixes always, eventually and not,
as in rtamt. A chain of `->`, `<->` or until needs brackets.
What other tools write for them is read too (SYNONYMS). A word such as G or AND is an operator only where a region cannot stand,
so that regions may have such names. The entries of regions.py call it; docs/missions.md explains the language.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Mapping
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
    parts_of,
)
from stt_codegen.task.mission.unread_text import (
    UNREAD_BINARY,
    UNREAD_PREFIXES,
    chain_error,
    require_no_assignment,
    unread_character,
)

TOKEN = re.compile(
    r"\s*(?:(<->|<=>|->|=>|&&|\|\||/\\|\\/|[&|!~])|([A-Za-z][A-Za-z0-9_]*)|(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)|([\[\](),:]))"
)
TEXT_LENGTH_LIMIT = 2000  # characters of a formula
SIZE_LIMIT = 1000  # regions and operators of a formula that is negated
NESTING_LIMIT = 40  # operators inside one another
PRECEDENCE = ("->", "or", "and", "until")  # from the weakest binding; "<->" binds as "->"
BINARY_SYNONYMS = {
    **dict.fromkeys(("implies", "=>"), "->"),
    **dict.fromkeys(("iff", "<=>"), "<->"),
    **dict.fromkeys(("||", "|", "\\/"), "or"),
    **dict.fromkeys(("&&", "&", "/\\"), "and"),
    **dict.fromkeys(("u", "until_"), "until"),
    **{name: name for name in ("->", "<->", "or", "and", "until")},
}
PREFIX_SYNONYMS = {
    **dict.fromkeys(("g", "globally", "alw", "alw_"), "always"),
    **dict.fromkeys(("f", "finally", "ev", "ev_"), "eventually"),
    **dict.fromkeys(("!", "~"), "not"),
    **{name: name for name in ("always", "eventually", "not")},
}
SECONDS = {"s": Fraction(1), "ms": Fraction(1, 10**3), "us": Fraction(1, 10**6), "ns": Fraction(1, 10**9)}  # of units in a window


def parse_formula(text: str) -> Formula:
    """Return the formula of a text, in negation normal form.

    Raises `ValueError` that says where the text is wrong and what is needed there.
    """
    if len(text) > TEXT_LENGTH_LIMIT:
        raise ValueError(f"has {len(text)} characters; at most {TEXT_LENGTH_LIMIT} are taken, use several entries")
    return _FormulaParser(text).formula()


def negated(formula: Formula) -> Formula:
    """Return the negation of a formula. Raises `ValueError` where it is so large that it may double without end.

    The negation of "until" has its parts more than once, and so has <->.
    """
    count, unseen = 0, [formula]
    while unseen:
        count += 1
        unseen.extend(parts_of(unseen.pop()))
        if count > SIZE_LIMIT:
            raise ValueError(f"has over {SIZE_LIMIT} operators once `not` and <-> are taken apart; use several entries")
    return negation(formula)


class _FormulaParser:
    """A recursive-descent parser: each method reads the tokens that its name says and advances `index` past them."""

    def __init__(self, text: str) -> None:
        require_no_assignment(text)
        self.text, self.tokens, self.index, self.depth = text, list(self._split(text)), 0, 0

    @staticmethod
    def _split(text: str) -> Iterator[tuple[str, int]]:
        """Yield each token with the index of its first character."""
        position = 0
        while text[position:].strip():
            match = TOKEN.match(text, position)
            if match is None:
                raise unread_character(text, len(text) - len(text[position:].lstrip()))
            token = match.group().strip()
            yield token, match.end() - len(token)
            position = match.end()

    @property
    def token(self) -> str:
        """The next token; an empty text at the end."""
        return self.token_after(0)

    def token_after(self, count: int) -> str:
        """Return the token after the next `count` tokens; an empty text beyond the end."""
        return self.tokens[self.index + count][0] if self.index + count < len(self.tokens) else ""

    @property
    def binary_operator(self) -> str:
        """The operator that the next token is, where an operand was read; an empty text for none."""
        return BINARY_SYNONYMS.get(self.token.lower(), "")

    @property
    def is_prefix(self) -> bool:
        """Whether the next token is followed by what an operand may begin with, or by a window, as a region never is."""
        following = self.token_after(1)
        is_operand = bool(re.fullmatch(r"[A-Za-z]\w*|[(!~]", following)) and following.lower() not in BINARY_SYNONYMS
        return self.token in KEYWORDS or not self.token.isidentifier() or is_operand or following == "["

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
            raise self.error("the end, or one of and, or, until, ->, <->,")
        return formula

    def binary(self, level: int) -> Formula:
        """Read operands joined by the operators of PRECEDENCE from `level` on."""
        self.depth += 1
        if self.depth > NESTING_LIMIT * (len(PRECEDENCE) + 1):
            raise ValueError(f"is nested more than {NESTING_LIMIT} deep; use several entries")
        if level == len(PRECEDENCE):
            formula = self.unary()
            self.refuse_unread(UNREAD_BINARY)
        else:
            formula = self.joined(level)
        self.depth -= 1
        return formula

    def joined(self, level: int) -> Formula:
        """Read operands of the next level, joined by operators of this one.

        Raises where ->, <-> or until are in a chain: rtamt takes the first two operands together, others the last two.
        """
        operators = ("->", "<->") if level == 0 else (PRECEDENCE[level],)
        begin, formula = self.index, self.binary(level + 1)
        operands, operator_texts = [self.span_from(begin)], list[str]()
        while (operator := self.binary_operator) in operators:
            begin = self.index
            self.index += 1
            over = self.interval() if operator == "until" else Interval()
            operator_texts.append(self.text[slice(*self.span_from(begin))])
            begin, last = self.index, self.binary(level + 1)
            operands.append(self.span_from(begin))
            if operator in ("and", "or"):
                formula = (conjunction if operator == "and" else disjunction)(formula, last)
            elif len(operands) > 2:
                continue  # to the end of the chain, for the message
            elif operator == "->":
                formula = disjunction(negated(formula), last)
            elif operator == "<->":
                formula = conjunction(disjunction(negated(formula), last), disjunction(negated(last), formula))
            else:
                formula = Until(over, formula, last)
        if len(operands) > 2 and operators not in (("and",), ("or",)):
            raise chain_error(self.text, operands, operator_texts)
        return formula

    def span_from(self, first: int) -> tuple[int, int]:
        """Return begin and end in the text of the tokens from `first` to the one that was read last."""
        last, position = self.tokens[self.index - 1]
        return self.tokens[first][1], position + len(last)

    def unary(self) -> Formula:
        """Read a region, a formula in brackets, or one behind not, always or eventually."""
        word = self.token
        operator = PREFIX_SYNONYMS.get(word.lower()) if self.is_prefix else None
        if operator is not None:
            self.index += 1
            if operator == "not":
                return negated(self.binary(len(PRECEDENCE)))
            if self.token == "(" and self.token_after(1)[:1].isdigit():
                raise ValueError(f"has a window in round brackets after {word!r}; its ends count: write [a, b]")
            over = self.interval()
            return (Always if operator == "always" else Eventually)(over, self.binary(len(PRECEDENCE)))
        if self.is_prefix and word.isidentifier():
            self.refuse_unread(UNREAD_PREFIXES)
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
        """Read [begin, end] in seconds or with units, end may be inf; without a bracket the interval is all times."""
        if self.token != "[":
            return Interval()
        self.index += 1
        begin, unit_of_begin = self.number()
        self.require(":" if self.token == ":" else ",")  # rtamt writes [0:8]
        is_endless = self.token == "inf"
        if is_endless:
            self.index += 1
        end, unit_of_end = (None, unit_of_begin) if is_endless else self.number()
        self.require(")" if is_endless and self.token == ")" else "]")  # no time is infinite, so the end may be left open
        if end is not None and end < begin:
            raise ValueError(f"has a window from {decimal(begin)} to {decimal(end)}; from must not be after to")
        if begin and "" in (unit_of_begin, unit_of_end) and {unit_of_begin, unit_of_end} - {"", "s"}:
            raise ValueError(
                f"has a window from {decimal(begin)} s with one unit, {unit_of_begin or unit_of_end!r}, which some tools give "
                "to both bounds; give each its own"
            )
        return Interval(begin, end)

    def number(self) -> tuple[Fraction, str]:
        """Read a number of seconds, and the unit behind it; empty for none."""
        if not self.token[:1].isdigit():
            raise self.error("a number of seconds")
        self.index += 1
        value = Decimal(self.tokens[self.index - 1][0])
        if value and not -10 < value.adjusted() < 10:
            raise ValueError(f"has the number {value}; use 0 or seconds from 1e-9 to 1e9")
        unit = SECONDS.get(self.token)
        if unit is None and self.token.isidentifier() and self.token != "inf":
            position = self.tokens[self.index][1] + 1
            raise ValueError(
                f"has the unit {self.token!r} at character {position}; units are {', '.join(SECONDS)}, and seconds without one"
            )
        if unit is None:
            return Fraction(value), ""
        self.index += 1
        return Fraction(value) * unit, self.tokens[self.index - 1][0]

    def refuse_unread(self, operators: Mapping[str, str]) -> None:
        """Raise where the next token is an operator of other tools that has no synonym here."""
        if reason := operators.get(self.token.lower()):
            raise ValueError(f"{self.token!r} at character {self.tokens[self.index][1] + 1} {reason}")
