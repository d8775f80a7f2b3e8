"""A lemma of the book as data, and the methods of proof that all families use.

A `Lemma` has its statement, assumptions, source, and a proof that runs every time. A proof returns an `Outcome`, whose verdict
is computed, never written down. What a method cannot decide is `open`, and the evidence has what is left. The methods are
identities by SymPy (exact), signs by SymPy (for all values), inequalities over a box by Arb (enclosures on a subdivided box),
counterexamples whose numbers are enclosed, and cases, where code is run on every pattern of input.
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
BOX_COUNT_LIMIT = 200_000  # parts of a box, after which an inequality stays open
LISTED_DIFFERENCES_LIMIT = 24  # more differences than that are counted in the evidence, not listed


class Verdict(Enum):
    PROVED = "proved"
    REFUTED = "refuted"
    OPEN = "open"


@dataclass(frozen=True)
class Outcome:
    """The result of a proof, by which method, and evidence that a reader can check."""

    verdict: Verdict
    method: str
    evidence: tuple[str, ...]


@dataclass(frozen=True)
class Lemma:
    """A statement with its proof.

    name: family.word. statement: in words. latex: the formula on the page. source: an equation, lemma or theorem, or "ours".
    steps: names of lemmas, earlier in the book, that the argument goes through in this order; the lemma is open unless all of
    them are proved.
    """

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
        """Run the proof; where it raises an exception the lemma is open, with the exception's message."""
        try:
            return self.proof()
        except Exception as error:
            return Outcome(Verdict.OPEN, "none", (f"{type(error).__name__}: {error}",))


def with_steps(lemma: Lemma, outcome: Outcome, earlier_verdicts: Mapping[str, Verdict]) -> Outcome:
    """Return the lemma's outcome, which is open where one of its steps is not proved.

    earlier_verdicts: by name those of the lemmas before it in the book, so an argument cannot go in a circle.
    """
    if outcome.verdict is not Verdict.PROVED:
        return outcome
    missing = [name for name in lemma.steps if earlier_verdicts.get(name) is not Verdict.PROVED]
    return Outcome(Verdict.OPEN, "steps", tuple(f"step {name} is not proved" for name in missing)) if missing else outcome


# -------------------------------------------------------------------------------------------------- methods


def prove_identities(
    differences: Mapping[str, Any],
    method: str = "SymPy: the difference of both sides is 0",
    test_point: Mapping[Any, float] | None = None,
) -> Outcome:
    """Prove that every difference is 0 by SymPy; else the outcome is open, with what is left.

    differences: by the name that the evidence has for them. test_point: where the differences are evaluated first, since SymPy
    may take minutes to simplify what is not 0. No differences at all is an error, not a proof.
    """
    if not differences:
        raise ValueError("no difference was looked at")
    evidence: list[str] = []
    remainders: list[str] = []
    for name, difference in differences.items():
        remainder = _nonzero_value_at(difference, test_point) if test_point is not None else 0
        remainder = remainder or _simplify_difference(difference)
        (evidence if remainder == 0 else remainders).append(f"{name}: {remainder}")
    if remainders:
        return Outcome(Verdict.OPEN, method, tuple(remainders))
    if len(evidence) > LISTED_DIFFERENCES_LIMIT:
        evidence = [f"{len(evidence)} differences, {evidence[0]}, .., {evidence[-1]}"]
    return Outcome(Verdict.PROVED, method, tuple(evidence))


def _nonzero_value_at(expression: Any, point: Mapping[Any, float]) -> Any:
    """Return the expression's value at the point where that is clearly not 0, else 0."""
    expression = sp.sympify(expression)
    numbers = {symbol: sp.Rational(str(point[symbol])) for symbol in expression.free_symbols & point.keys()}
    value = expression.evalf(30, subs=numbers)
    return value if abs(value) > sp.Float("1e-12") else 0


def _simplify_difference(expression: Any) -> Any:
    """Simplify, by quick ways to 0 first: SymPy's simplify takes seconds where rewriting hyperbolic functions takes none."""
    for step in (
        sp.expand,
        lambda e: sp.cancel(sp.together(e.rewrite(sp.exp))),
        lambda e: sp.simplify(sp.logcombine(e)),  # never by force: that takes log x^2 for 2 log x where x is negative
    ):
        remainder = step(expression)
        if remainder == 0:
            return remainder
    return sp.simplify(expression)


def prove_positive(expressions: Mapping[str, Any]) -> Outcome:
    """Prove by SymPy's rules of signs that every expression is positive for all values that its symbols stand for.

    The rules are exact and need no range. No expressions at all is an error.
    """
    if not expressions:
        raise ValueError("no expression was looked at")
    method = "SymPy: signs of sums, products and functions of positive symbols"
    undecided = [f"{name}: {value}" for name, value in expressions.items() if sp.sympify(value).is_positive is not True]
    if undecided:
        return Outcome(Verdict.OPEN, method, tuple(undecided))
    return Outcome(Verdict.PROVED, method, tuple(f"{name} > 0" for name in expressions))


def prove_above(name: str, function: Callable[..., Any], box: Box, bound: float = 0.0) -> Outcome:
    """Prove that function > bound on the box, by enclosures on ever smaller parts; one point where it is below refutes it."""
    method = "Arb: enclosures over a subdivided box"
    order = count()
    undecided: list[tuple[float, int, Box]] = []  # parts by the lower end of their enclosure, the worst first

    def examine(part: Box) -> None:
        enclosure = function(*(_ball(*side) for side in part))
        if not (enclosure > bound):
            lower_end = float(enclosure.lower()) if enclosure.is_finite() else float("-inf")
            heapq.heappush(undecided, (lower_end, next(order), part))

    examine(list(box))
    examined_count = 1
    while undecided and examined_count < BOX_COUNT_LIMIT:
        _, _, part = heapq.heappop(undecided)
        middle = [(a + b) / 2 for a, b in part]
        value = function(*(arb(m) for m in middle))
        if value < bound:
            return Outcome(Verdict.REFUTED, method, (f"{name} is {value.str(6)} at {tuple(middle)}, not above {bound}",))
        widest = max(range(len(part)), key=lambda i: (part[i][1] - part[i][0]) / (box[i][1] - box[i][0]))
        a, b = part[widest]
        for side in ((a, (a + b) / 2), ((a + b) / 2, b)):
            examine([*part[:widest], side, *part[widest + 1 :]])
            examined_count += 1
    if undecided:
        remainder = f"{len(undecided)} of {examined_count} boxes left, one is {undecided[0][2]}"
        return Outcome(Verdict.OPEN, method, (f"{name}: {remainder}",))
    return Outcome(Verdict.PROVED, method, (f"{name} > {bound:g} on {list(map(tuple, box))}, {examined_count} boxes",))


def _ball(low: float, high: float) -> Any:
    return arb(low).union(arb(high))


def refute_by_counterexample(statement: str, at: str, fails: Any, evidence: str) -> Outcome:
    """Refute the statement where `fails` is true; else the outcome is open.

    at: in words the point of the counterexample. fails: computed there exactly or by enclosures, so that an enclosure which
    decides nothing is false.
    """
    verdict, verb = (Verdict.REFUTED, "fails") if bool(fails) else (Verdict.OPEN, "holds")
    return Outcome(verdict, "counterexample, exact or enclosed", (f"{statement} {verb} at {at}: {evidence}",))


def all_of(*outcomes: Outcome) -> Outcome:
    """Combine the outcomes of several claims: proved when all are, else the first that is not. No claims at all is an error."""
    if not outcomes:
        raise ValueError("no claim was looked at")
    for outcome in outcomes:
        if outcome.verdict is not Verdict.PROVED:
            return outcome
    methods = "; ".join(dict.fromkeys(o.method for o in outcomes))
    return Outcome(Verdict.PROVED, methods, tuple(line for o in outcomes for line in o.evidence))


def outcome_of_cases(case_count: int, failures: list[str], claim: str) -> Outcome:
    """Return the outcome of a claim for which code was run in so many cases: proved where none of them fails."""
    verdict = Verdict.OPEN if failures or not case_count else Verdict.PROVED
    return Outcome(verdict, "by cases: the evaluated code", (f"{claim}, in {case_count} cases", *failures[:3]))
