"""P10: every x(t) that stays in the tube carries out the mission. For tasks with a mission."""

import itertools
import math
import re
from fractions import Fraction
from functools import cache
from typing import Any

from .exact import Unusable, require
from .formula import WORDS, Cycle, Formula, Interval, joined, of_entry, parse, satisfied
from .sets import FORMS, SHAPE_FIELDS, Inside, Obstacle, axes_of, box
from .tube import Piece, Tube, avoids, by_segment, part_of

DEEPEST_HALVING = 12  # of a piece whose hull is too coarse
HALF = Fraction(1, 2)
CHOICE_LIMIT = 400  # regions of a choice
CELL_LIMIT = 1 << 18  # cells into which the edges of boxes cut a piece of the tube, times the boxes


class Mission:
    """The regions and the formula of a task. A choice of regions is written out as its members."""

    def __init__(self, task: Any) -> None:
        self.task, self.regions, self.sizes = task, dict[str, Any](), dict[str, int]()  # size: the regions that a choice is of
        self.sets = dict[str, Inside]()  # regions to be in that are no boxes
        self.edges = cache(self.edges_of)
        for table in task.document.get("region", []):
            name, members = str(table["name"]), table.get("any_of")
            if members is None:
                is_known = {*table} & SHAPE_FIELDS in FORMS
            else:
                is_known = {*table} == {"name", "any_of"} and bool(members) and {*members} <= {*self.regions}
            is_word = re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII) is not None and name not in WORDS
            if not is_known or not is_word or name in self.regions:
                raise Unusable("the task has a region with a shape that is unknown here, or two regions of one name")
            self.regions[name], self.sizes[name] = table, sum(self.sizes[m] for m in members or []) or 1
            if self.sizes[name] > CHOICE_LIMIT:
                raise Unusable("the task has a choice of more regions than can be checked in good time")
        entries = (of_entry(table, task.t_c, task.repeats) for table in task.document["mission"])
        self.formula = joined("and", *(self.written_out(f) for f in entries))

    def written_out(self, f: Formula) -> Formula:
        """Return a formula with every choice of regions replaced by its members."""
        kind, *parts = f
        if kind not in ("in", "out"):
            formulas = [self.written_out(p) for p in parts if isinstance(p[0], str)]
            return joined(kind, *formulas) if kind in ("and", "or") else (kind, parts[0], *formulas)
        if parts[0] not in self.regions:
            raise Unusable(f"the mission speaks of {parts[0]!r}, which is no region")
        members = self.regions[parts[0]].get("any_of")
        return f if members is None else joined("or" if kind == "in" else "and", *(self.written_out((kind, m)) for m in members))

    def edges_of(self, f: Formula) -> list[Interval] | None:
        """Return the edges of a region that is a box, None of another region. One to avoid is larger by body and clearance."""
        table = self.regions[f[1]]
        if "lower" not in table:
            return None
        axes = axes_of(table, self.task.names)
        ends = dict(zip(axes, zip(*box(table, len(axes)), strict=True), strict=True))
        margins = zip(self.task.body, self.task.clearance, strict=True)
        growth = [h + v if f[0] == "out" else Fraction(0) for h, v in margins]
        return [(ends[i][0] - g, ends[i][1] + g) if i in ends else (-math.inf, math.inf) for i, g in enumerate(growth)]

    def atoms(self, f: Formula) -> list[Formula]:
        require(f[0] in ("and", "or", "in", "out"), "the certificate claims a formula with times as one without")
        return [f] if f[0] in ("in", "out") else [atom for p in f[1:] for atom in self.atoms(p)]

    def holds_at(self, f: Formula, point: tuple[Any, ...]) -> bool:
        """Return whether a formula of boxes holds at a point that is on no edge."""
        if f[0] in ("and", "or"):
            return (all if f[0] == "and" else any)(self.holds_at(p, point) for p in f[1:])
        return all(a < x < b for x, (a, b) in zip(point, self.edges(f) or [], strict=True)) == (f[0] == "in")

    def holds_in(self, f: Formula, piece: Piece, tube: Tube, margin: int, depth: int = DEEPEST_HALVING) -> bool:
        """Return whether a state formula holds in a piece, larger by the margin on every side; in its halves where its hull is
        too coarse."""
        edges, unit = [self.edges(atom) for atom in self.atoms(f)], tube.unit
        if all(edges):  # the edges cut the piece's box into cells, in each of which one point tells
            cells = []
            for i, (low, high) in enumerate(piece):
                a, b = (min(low) - margin) * unit, (max(high) + margin) * unit
                ends = [a, *sorted({v for e in edges for v in (e or [])[i] if a < v < b}), b]
                cells.append([(p + q) / 2 for p, q in itertools.pairwise(ends)])
            is_small = math.prod(map(len, cells)) * len(edges) <= CELL_LIMIT
            require(is_small, "a formula has more boxes than can be checked in good time")
            holds = all(self.holds_at(f, point) for point in itertools.product(*cells))
        else:
            require(f[0] == "in", "the certificate claims a choice of regions that are not boxes")
            if f[1] not in self.sets:
                self.sets[f[1]] = Inside(self.regions[f[1]], self.task.names, [Fraction(0)] * self.task.n, box_has_all_axes=False)
            holds = all(self.sets[f[1]].contains([(low[k], high[k]) for low, high in piece], margin, unit) for k in range(4))
        halves = (part_of(piece, a, a + HALF) for a in (Fraction(0), HALF))
        return holds or (depth > 0 and all(self.holds_in(f, half, tube, margin, depth - 1) for half in halves))

    def holds_on(self, f: Formula, claim: Any, tube: Tube, cuts: int) -> bool:
        """Return whether a state formula holds on the interval of a claim, with its margin."""
        if f[0] == "out" and self.edges(f) is None:
            return avoids(self.task, tube, Obstacle(self.regions[f[1]], "", self.task), claim, cuts)
        begin, stop = claim["on"]
        return all(self.holds_in(f, tube.part(a, b, cuts), tube, claim["margin"]) for a, b in by_segment(begin, stop, cuts))

    def prove(self, tube: Tube, error: int, claims_and_cuts: tuple[list, int], stated: Any, clock_error: Fraction) -> None:
        """Prove every claim about a state formula, and that the mission follows from them. error: of an edge, in units; stated:
        the certificate's `mission`; clock_error: of t_c."""
        claims, cuts = claims_and_cuts
        require({*stated} == {"formula", "time_margin"}, "the certificate's mission has unknown keys")
        require(self.written_out(parse(stated["formula"])) == self.formula, "the certificate's formula is not the task's mission")
        margin, part, end = stated["time_margin"], tube.t_c / (tube.segments * cuts), tube.segments * cuts
        is_enough = type(margin) is int and margin * part >= tube.t_c * clock_error + self.task.start_delay
        require(is_enough, "P10 does not hold: the time margin is less than the clock's error")
        known: dict[Formula, list[Interval]] = {}
        for claim in claims:
            is_known = {*claim} - {"hints"} == {"property", "set", "on", "margin"} and claim["property"] == "P10"
            require(is_known, f"a claim is unknown: {claim!s:.80}")
            (a, b), spacing = claim["on"], claim["margin"]
            is_known = [type(v) for v in (a, b, spacing)] == [int] * 3 and 0 <= a <= b <= end
            require(is_known and spacing >= error, f"P10 does not hold: {claim!s:.80} has less margin than the arithmetic takes")
            f = self.written_out(parse(claim["set"]))
            require(self.holds_on(f, claim, tube, cuts), f"P10 does not hold: {claim['set']} from {a} to {b}")
            # The margin of a tube that repeats is taken off when its cycle is unrolled, and nothing is known for ever.
            less, is_endless = (margin, b == end) if tube.seam is None else (0, False)
            begin, stop = -math.inf if a == 0 else a + less, math.inf if is_endless else b - less
            known.setdefault(f, []).append((begin * part, stop * part))
        cycle = None if tube.seam is None else Cycle(tube.t_c - tube.cycle, tube.t_c, margin * part)
        require(cycle is None or cycle.margin <= cycle.length, "P10 does not hold: the time margin is longer than the cycle")
        times = satisfied(self.formula, known, cycle)
        require(any(a <= 0 <= b for a, b in times), "P10 does not hold: the mission does not follow from the claims")
