"""A lemma is data: what is said, under which assumptions, where it is from, and a proof that is run every time.

A proof returns an `Outcome`; its verdict is computed, never written down. What a method cannot settle is `open`, with what is
left. The methods: an identity by SymPy (exact), a sign by SymPy (for all values), an inequality over a box by Arb (enclosures,
subdivided), a counterexample whose numbers are enclosed.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import count
from typing import Any

import sympy as sp
from flint import arb

Box = Sequence[tuple[float, float]]
MOST_BOXES = 200_000
MOST_TOLD = 24  # differences that are listed one by one


class Verdict(Enum):
    PROVED = "proved"
    REFUTED = "refuted"
    OPEN = "open"


@dataclass(frozen=True)
class Outcome:
    """What a proof came to, how, and what a reader can check."""

    verdict: Verdict
    method: str
    evidence: tuple[str, ...]


@dataclass(frozen=True)
class Lemma:
    """`name` is family.what; `statement` in words, `latex` for the page; `source` an equation, lemma or theorem, or "ours".
    steps: the lemmas, earlier in the book, that the argument goes through in this order; it is open unless all are proved."""

    name: str
    statement: str
    latex: str
    assumptions: tuple[str, ...]
    source: str
    proof: Callable[[], Outcome]
    steps: tuple[str, ...] = ()

    @property
    def family(self) -> str:
        return self.name.split(".", maxsplit=1)[0]

    def run(self) -> Outcome:
        """The proof's outcome; a method that fails leaves the lemma open, with its message."""
        try:
            return self.proof()
        except Exception as error:
            return Outcome(Verdict.OPEN, "none", (f"{type(error).__name__}: {error}",))


def with_steps(lemma: Lemma, outcome: Outcome, known: Mapping[str, Verdict]) -> Outcome:
    """The lemma's outcome, open where one of its steps is not proved; `known`: the verdicts so far, so there is no circle."""
    if outcome.verdict is not Verdict.PROVED:
        return outcome
    missing = [name for name in lemma.steps if known.get(name) is not Verdict.PROVED]
    return Outcome(Verdict.OPEN, "steps", tuple(f"step {name} is not proved" for name in missing)) if missing else outcome


# -------------------------------------------------------------------------------------------------- methods


def identity(
    differences: Mapping[str, Any],
    method: str = "SymPy: the difference of both sides is 0",
    somewhere: Mapping[Any, float] | None = None,
) -> Outcome:
    """Proved when every difference simplifies to 0; else open with what is left. somewhere: a point at which the differences are
    looked at first, since SymPy may take minutes over what is not 0. No difference at all is an error, not a proof."""
    if not differences:
        raise ValueError("no difference was looked at")
    evidence: list[str] = []
    left: list[str] = []
    for name, difference in differences.items():
        rest = _value_at(difference, somewhere) if somewhere is not None else 0
        rest = rest or _simplest(difference)
        (evidence if rest == 0 else left).append(f"{name}: {rest}")
    if left:
        return Outcome(Verdict.OPEN, method, tuple(left))
    told = evidence if len(evidence) <= MOST_TOLD else [f"{len(evidence)} differences, {evidence[0]}, .., {evidence[-1]}"]
    return Outcome(Verdict.PROVED, method, tuple(told))


def _value_at(expression: Any, point: Mapping[Any, float]) -> Any:
    """The expression's value there where it is clearly not 0, else 0."""
    here = sp.sympify(expression)
    value = here.evalf(30, subs={symbol: sp.Rational(str(point[symbol])) for symbol in here.free_symbols & point.keys()})
    return value if abs(value) > sp.Float("1e-12") else 0


def _simplest(expression: Any) -> Any:
    """Quick ways to 0 first: SymPy's own simplify takes seconds where rewriting hyperbolic functions takes none."""
    for step in (
        sp.expand,
        lambda e: sp.cancel(sp.together(e.rewrite(sp.exp))),
        lambda e: sp.simplify(sp.logcombine(e)),  # never by force: that takes log x^2 for 2 log x where x is negative
    ):
        rest = step(expression)
        if rest == 0:
            return rest
    return sp.simplify(expression)


def sign(expressions: Mapping[str, Any]) -> Outcome:
    """Proved when every expression is positive for all values that its symbols stand for, by SymPy's rules of signs; exact, on no
    range. None at all is an error."""
    if not expressions:
        raise ValueError("no expression was looked at")
    method = "SymPy: signs of sums, products and functions of positive symbols"
    left = [f"{name}: {value}" for name, value in expressions.items() if sp.sympify(value).is_positive is not True]
    if left:
        return Outcome(Verdict.OPEN, method, tuple(left))
    return Outcome(Verdict.PROVED, method, tuple(f"{name} > 0" for name in expressions))


def positive(name: str, function: Callable[..., Any], box: Box, least: float = 0.0) -> Outcome:
    """Proved when function > least on the box, by balls on ever smaller parts; refuted when one point says otherwise."""
    method = "Arb: enclosures over a subdivided box"
    order = count()
    parts: list[tuple[float, int, Box]] = []

    def push(part: Box) -> None:
        value = function(*(_ball(*side) for side in part))
        if not (value > least):
            heapq.heappush(parts, (float(value.lower()) if value.is_finite() else float("-inf"), next(order), part))

    push(list(box))
    looked = 1
    while parts and looked < MOST_BOXES:
        _, _, part = heapq.heappop(parts)
        middle = [(a + b) / 2 for a, b in part]
        there = function(*(arb(m) for m in middle))
        if there < least:
            return Outcome(Verdict.REFUTED, method, (f"{name} is {there.str(6)} at {tuple(middle)}, not above {least}",))
        widest = max(range(len(part)), key=lambda i: (part[i][1] - part[i][0]) / (box[i][1] - box[i][0]))
        a, b = part[widest]
        for side in ((a, (a + b) / 2), ((a + b) / 2, b)):
            push([*part[:widest], side, *part[widest + 1 :]])
            looked += 1
    if parts:
        return Outcome(Verdict.OPEN, method, (f"{name}: {len(parts)} of {looked} boxes left, one is {parts[0][2]}",))
    return Outcome(Verdict.PROVED, method, (f"{name} > {least:g} on {list(map(tuple, box))}, {looked} boxes",))


def _ball(low: float, high: float) -> Any:
    return arb(low).union(arb(high))


def counterexample(statement: str, at: str, fails: Any, shown: str) -> Outcome:
    """Refuted when `fails`, computed exactly or by enclosures at the place `at`, is true of the statement; else open."""
    verdict, verb = (Verdict.REFUTED, "fails") if bool(fails) else (Verdict.OPEN, "holds")
    return Outcome(verdict, "counterexample, exact or enclosed", (f"{statement} {verb} at {at}: {shown}",))


def all_of(*outcomes: Outcome) -> Outcome:
    """The verdict of several claims: proved when all are, else that of the first which is not. None at all is an error."""
    if not outcomes:
        raise ValueError("no claim was looked at")
    for outcome in outcomes:
        if outcome.verdict is not Verdict.PROVED:
            return outcome
    methods = "; ".join(dict.fromkeys(o.method for o in outcomes))
    return Outcome(Verdict.PROVED, methods, tuple(line for o in outcomes for line in o.evidence))


def cases(count: int, wrong: list[str], what: str) -> Outcome:
    """The outcome of a claim that was looked at in so many cases: proved where none is wrong."""
    verdict = Verdict.OPEN if wrong or not count else Verdict.PROVED
    return Outcome(verdict, "by cases: the evaluated code", (f"{what}, in {count} cases", *wrong[:3]))
