"""The mission of a task: named regions, and entries that must all hold.

An entry is a formula (formulas.py), or one of the simple forms, each of which stands for a formula:

    visit = "dock", between = [3, 5], stay = 2           eventually[3, 5] always[0, 2] dock
      .. then = "exit", within = 4                       eventually[3, 5] (always[0, 2] dock and eventually[2, 6] exit)
    never = "lab"                                        always not lab
    never = "lab", before = "key"                        not lab until[0, t_c] key
    patrol = ["dock", "left"], every = 8, until = 24     always[0, 16] eventually[0, 8] dock, and the same of left
      .. without until, where the task repeats itself    always eventually[0, 8] dock
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any

from pydantic import Field

from stt_codegen.task.mission.formulas import (
    ZERO,
    Always,
    And,
    Eventually,
    Formula,
    InRegion,
    Interval,
    Or,
    Until,
    conjunction,
    disjunction,
    parts_of,
    replace_regions,
)
from stt_codegen.task.mission.grammar import parse_formula
from stt_codegen.task.sets import (
    SET_TABLES,
    OneOf,
    TomlTable,
    Unsafe,
    kind_of_set,
)
from stt_codegen.task.values import MAX_LABEL, Labels, NotNegative, Positive, Window

FORMS = {  # the key that decides the form of an entry, and the keys that may stand beside it
    "visit": ("between", "stay", "then", "within"),
    "never": ("before",),
    "patrol": ("every", "until"),
    "formula": (),
}


class RegionUnion(TomlTable):
    """A region that is the union of other regions."""

    name: str = Field(default="", max_length=MAX_LABEL)
    any_of: Labels = Field(description="names of regions, of which one is enough")


def _kind_of_region(value: Any) -> str:
    """Return the tag of the table as which an entry of [[region]] is read."""
    if isinstance(value, RegionUnion) or (isinstance(value, dict) and "any_of" in value):
        return "<RegionUnion>"
    return kind_of_set(value)


AnyRegion = Annotated[Unsafe | RegionUnion, OneOf((*SET_TABLES, RegionUnion), _kind_of_region)]


class MissionEntry(TomlTable):
    """One thing that must hold: a visit, something never, a patrol, or a formula."""

    visit: str | None = Field(default=None, description="a region to be in, at some time")
    between: Window | None = Field(
        default=None, description="[from, to], seconds: at some time of it the stay begins; absent: any time"
    )
    stay: NotNegative | None = Field(default=None, description="seconds that the visit lasts at least; absent: 0")
    then: str | None = Field(default=None, description="a region to be in after the stay")
    within: Positive | None = Field(default=None, description="seconds from the end of the stay to `then`, at most")
    never: str | None = Field(default=None, description="a region to be out of")
    before: str | None = Field(default=None, description="a region: once in it, `never` ends; it must be visited")
    patrol: Labels | None = Field(default=None, description="regions to be in again and again")
    every: Positive | None = Field(default=None, description="seconds between two visits of one of them, at most")
    until: Positive | None = Field(default=None, description="seconds: when the patrol may end; absent: t_c, with `repeat` never")
    formula: str | None = Field(default=None, description="a formula of signal temporal logic")

    @property
    def form(self) -> str | None:
        """The form of the entry; None where it has the keys of no form, or of several."""
        forms = [name for name in FORMS if getattr(self, name) is not None]
        return forms[0] if len(forms) == 1 else None

    def meaning(self, t_c: Fraction, repeats: bool = False) -> Formula:
        """Return the entry as a formula about regions by name. Raises `ValueError` where its text cannot be read.

        t_c: the prescribed time, at which windows without an end close; repeats: whether the task repeats itself."""
        if self.formula is not None:
            return parse_formula(self.formula)
        if self.visit is not None:
            stay, arrival = self.stay or ZERO, Interval(*(self.between or (ZERO, t_c)))
            visit: Formula = Always(Interval(ZERO, stay), InRegion(self.visit)) if stay else InRegion(self.visit)
            if self.then is not None:
                gap = t_c if self.within is None else self.within
                visit = conjunction(visit, Eventually(Interval(stay, stay + gap), InRegion(self.then)))
            return Eventually(arrival, visit)
        if self.never is not None:
            if self.before is None:
                return Always(Interval(), InRegion(self.never, True))
            return Until(Interval(ZERO, t_c), InRegion(self.never, True), InRegion(self.before))
        assert self.patrol is not None
        assert self.every is not None
        patrol_time, next_visit = Interval(ZERO, (self.until or t_c) - self.every), Interval(ZERO, self.every)
        if repeats and self.until is None:
            patrol_time = Interval()
        return conjunction(*(Always(patrol_time, Eventually(next_visit, InRegion(name))) for name in self.patrol))

    def title(self) -> str:
        """Return the entry in a few words, for a sentence."""
        if self.visit is not None:
            return f"visit {self.visit}" + (f" then {self.then}" if self.then else "")
        if self.never is not None:
            return f"never {self.never}" + (f" before {self.before}" if self.before else "")
        if self.patrol is not None:
            return f"patrol {', '.join(self.patrol)}"
        return _printable(str(self.formula))


def _printable(formula: str) -> str:
    """Return a formula's text as a comment of C may have it: in one line, without characters that begin an escape there."""
    return " ".join(formula.replace("/\\", " and ").replace("\\/", " or ").split())


@dataclass(frozen=True)
class StateFormula(Formula):
    """A formula without time that is decided as a unit: one region, or boxes joined by "and" and "or".

    Boxes are decided in every cell of the grid of their edges, so that a tube may lie in two boxes at once."""

    inner: Formula

    def __str__(self) -> str:
        return str(self.inner)


def expand_unions(formula: Formula, regions: Mapping[str, Unsafe | RegionUnion]) -> Formula:
    """Return the formula with the members of every union of regions in its place."""

    def members(leaf: InRegion) -> Formula:
        region = regions[leaf.region]
        if not isinstance(region, RegionUnion):
            return leaf
        join = conjunction if leaf.is_negated else disjunction
        return join(*(replace_regions(InRegion(name, leaf.is_negated), members) for name in region.any_of))

    return replace_regions(formula, members)


def with_state_formulas(formula: Formula, boxes: frozenset[str]) -> Formula:
    """Return the formula with a `StateFormula` for every part that is decided as a unit. boxes: the regions that are boxes."""
    match formula:
        case InRegion():
            return StateFormula(formula)
        case And(parts):
            return And(tuple(with_state_formulas(p, boxes) for p in parts))
        case Or(parts):
            if _has_only(formula, boxes):
                return StateFormula(formula)
            return Or(tuple(with_state_formulas(p, boxes) for p in parts))
        case Always(over, part):
            return Always(over, with_state_formulas(part, boxes))
        case Eventually(over, part):
            return Eventually(over, with_state_formulas(part, boxes))
        case Until(over, first, last):
            return Until(over, with_state_formulas(first, boxes), with_state_formulas(last, boxes))
    raise TypeError(formula)


def _has_only(formula: Formula, boxes: frozenset[str]) -> bool:
    """Whether the formula is without time and about these regions only."""
    if isinstance(formula, InRegion):
        return formula.region in boxes
    return isinstance(formula, And | Or) and all(_has_only(p, boxes) for p in formula.parts)


def state_formulas_of(formula: Formula) -> Iterator[StateFormula]:
    """Return the states of a formula in order, each once."""
    return iter(dict.fromkeys(_iterate_state_formulas(formula)))


def _iterate_state_formulas(formula: Formula) -> Iterator[StateFormula]:
    if isinstance(formula, StateFormula):
        yield formula
    for part in parts_of(formula):
        yield from _iterate_state_formulas(part)
