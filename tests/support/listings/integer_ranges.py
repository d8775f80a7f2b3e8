"""Ranges of all values in a listing of integers, for one task and for whatever arguments its functions get.

A span is all whole numbers from one to another. Each operation takes spans to a span that holds its results. `UnknownMeaning` where a
value may leave 32 bits, an operand may be none that the operation is for, or an index may be none of its table.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tests.support.listings.integer_run import ARITHMETIC, HALF, literal, results_at_every_s
from tests.support.listings.reader import PREFIX, Block, Expression, Function, Statement, UnknownMeaning, require

Span = tuple[int, int]
INT16_SPAN, INT32_SPAN, UINT32_SPAN = (-(1 << 15), (1 << 15) - 1), (-(1 << 31), (1 << 31) - 1), (0, (1 << 32) - 1)
NORMAL = (1 << 30, (1 << 31) - 1)  # a number that is shifted up as far as it can be
READ_BY_INDEX = ("edge_at", "curve")  # one index after the other: their entries go together
READ_AT_EVERY_S = ("weights", "rates")  # functions of s alone


def is_inside(span: Span, limits: Span) -> bool:
    return limits[0] <= span[0] <= span[1] <= limits[1]


def hull(spans: Sequence[Span]) -> Span:
    return min(low for low, _ in spans), max(high for _, high in spans)


@dataclass
class Names:
    """The spans of names, and the expressions that defined them."""

    spans: dict[str, Span]
    definitions: dict[str, Expression] = field(default_factory=dict)

    def span(self, text: str) -> Span:
        if text in self.spans:
            return self.spans[text]
        value = literal(text)
        if value is None:
            raise UnknownMeaning(f"{text} has no span")
        limits = UINT32_SPAN if text.endswith("U") else INT32_SPAN
        require(is_inside((value, value), limits), f"{text} is no number of 32 bits")
        return value, value


class IntegerRanges:
    """tables: by name, as `values` of `source.fill` has them."""

    def __init__(self, functions: Mapping[str, Function], tables: Mapping[str, Sequence[int]]) -> None:
        self.functions, self.tables = functions, tables
        self._results: dict[tuple[str | Span, ...], list[Span]] = {}

    def check(self) -> int:
        """Compute the spans of all public functions for any argument, and return how many functions there are."""
        public = [f for f in self.functions.values() if not f.is_kernel]
        for function in public:
            spans = {p.name: UINT32_SPAN for p in function.parameters if p.passing == "value"}
            self._body(function, spans)
        return len(public)

    def results(self, name: str, *arguments: Span) -> list[Span]:
        """Return the spans of a kernel's results."""
        key: tuple[str | Span, ...] = (name, *arguments)
        if key not in self._results:
            self._results[key] = self._computed_results(name, arguments)
        return self._results[key]

    def _computed_results(self, name: str, arguments: Sequence[Span]) -> list[Span]:
        """Compute spans from the results at every s, from those of one index after the other, or from the spans of the arguments."""
        if name in READ_AT_EVERY_S:
            require(arguments[0] == (HALF[0], HALF[-1]), f"{name} gets s within {arguments[0]}")
            return [(int(column.min()), int(column.max())) for column in results_at_every_s(self.functions[name].tokens)]
        first = arguments[0]
        if name in READ_BY_INDEX and first[0] < first[1]:
            rows = [self.results(name, (k, k), *arguments[1:]) for k in range(first[0], first[1] + 1)]
            return [hull(column) for column in zip(*rows, strict=True)]
        function = self.functions[name]
        inputs = [p.name for p in function.parameters if p.passing == "value"]
        return self._body(function, dict(zip(inputs, arguments, strict=True)))

    def _body(self, function: Function, spans: dict[str, Span]) -> list[Span]:
        """Return the spans of what a function writes through pointers, or of what it returns."""
        names, results = Names(spans), list[Span]()
        items = [*function.body]
        while items:
            item = items.pop(0)
            if isinstance(item, Block):
                names.spans[item.index] = (0, int(item.count) - 1)
                items = [*item.body, *items]
            elif item.kind == "output" or (item.kind == "return" and function.is_kernel):
                assert item.value is not None
                results.append(names.span(item.value.parts[0]))
            elif item.kind == "call":
                self._call(item, names)
            elif item.kind == "define":
                self._define(item, names)
        return results

    def _call(self, statement: Statement, names: Names) -> None:
        assert statement.value is not None
        name, arguments = statement.value.parts
        words = arguments.split(" , ")
        spans = self.results(name.removeprefix(f"{PREFIX}_"), *(names.span(v) for v in words if v[0] != "&"))
        names.spans |= dict(zip((v[2:] for v in words if v[0] == "&"), spans, strict=True))

    def _define(self, statement: Statement, names: Names) -> None:
        """Give a name its span. A value that a loop carries has any value of its type: nothing is computed with it."""
        assert statement.value is not None
        target, value = statement.target, statement.value
        names.definitions[target] = value
        if statement.value_type == "bool":
            return
        span = self._span(value, names)
        if not statement.is_constant:
            span = INT32_SPAN
        limits = UINT32_SPAN if statement.value_type == "uint" else INT32_SPAN
        require(is_inside(span, limits), f"{target} may be {span}")
        names.spans[target] = span

    def _span(self, expression: Expression, names: Names) -> Span:
        """Return the span of an expression."""
        match expression:
            case Expression("operand" | "cast", (*_, text)):
                return names.span(text)
            case Expression("negation", (text,)):
                low, high = names.span(text)
                return -high, -low
            case Expression("choice", (condition, first, second)):
                return self._chosen(names.definitions[condition], (first, second), names)
            case Expression("operation", (first, sign, second)):
                a, b = names.span(first), names.span(second)
                ends = [{"+": v + w, "-": v - w, "*": v * w}[sign] for v, w in itertools.product(a, b)]
                return min(ends), max(ends)
            case Expression("low half", (text,)):
                require(is_inside(names.span(text), INT16_SPAN), f"{text} may be {names.span(text)}, beyond 16 bits")
                return names.span(text)
            case Expression("table", (_, table, index)):
                low, high = names.span(index)
                require(0 <= low <= high < len(self.tables[table]), f"{table} is read at {low} to {high}")
                entries = [int(v) for v in self.tables[table][low : high + 1]]
                return min(entries), max(entries)
            case Expression("load", _):
                return INT32_SPAN
            case Expression("call", (name, arguments)):
                return self._operation(name.removeprefix(f"{PREFIX}_"), arguments.split(" , "), names)
        raise UnknownMeaning(f"the span of this is not derived here: {expression}")

    def _chosen(self, test: Expression, alternatives: Sequence[str], names: Names) -> Span:
        """Return the span of a choice. After a comparison an alternative that was compared, or is the negative of it, is on its side."""
        spans = []
        for text, holds in zip(alternatives, (True, False), strict=True):
            low, high = names.span(text)
            if test.kind == "operation" and test.parts[1] == "<":
                low, high = self._limited(text, test, holds, names)
            if low <= high:
                spans.append((low, high))
        return hull(spans)

    def _limited(self, text: str, test: Expression, holds: bool, names: Names) -> Span:
        """Return the span of `text` where `first < second` holds, or does not."""
        first, _, second = test.parts
        low, high = names.span(text)
        (a_low, a_high), (b_low, b_high) = names.span(first), names.span(second)
        if names.definitions.get(text) == Expression("negation", (second,)):
            low, high = self._limited(second, test, holds, names)
            return -high, -low
        if text == first:
            return (low, min(high, b_high - 1)) if holds else (max(low, b_low), high)
        if text == second:
            return (max(low, a_low + 1), high) if holds else (low, min(high, a_high))
        return low, high

    def _operation(self, name: str, texts: Sequence[str], names: Names) -> Span:
        """Return the span of an operation of ARITHMETIC, or of a kernel. Those of ARITHMETIC are monotone in each operand."""
        spans = [names.span(text) for text in texts]
        if name not in ARITHMETIC:
            (result,) = self.results(name, *spans)
            return result
        operation, domains = ARITHMETIC[name]
        for span, domain in zip(spans, domains, strict=True):
            require(is_inside(span, (domain[0], domain[-1])), f"{name} gets {span}")
        if name == "low_bits":
            low, high = spans[0]
            mask = spans[1][1]
            require(spans[1] == (mask, mask) and mask & (mask + 1) == 0, "low_bits gets no mask")
            return (low, high) if 0 <= low <= high <= mask else (0, mask)
        if name == "shift_up" and (related := self._shifted_up(texts, names)):
            return related
        ends = [operation(*corner) for corner in itertools.product(*spans)]
        return min(ends), max(ends)

    @staticmethod
    def _shifted_up(texts: Sequence[str], names: Names) -> Span | None:
        """Return the span of a value that is shifted up by the leading bits of itself, or of a value that it is at most."""
        by, value = names.definitions.get(texts[1]), names.definitions.get(texts[0])
        if by is None or by.kind != "call" or by.parts[0] != f"{PREFIX}_leading":
            return None
        leading = by.parts[1]
        if leading == texts[0]:
            return NORMAL
        if value is not None and value.kind == "choice" and value.parts[2] == leading:
            test = names.definitions[value.parts[0]]
            if test == Expression("operation", (value.parts[1], "<", leading)):
                return 0, NORMAL[1]
        return None
