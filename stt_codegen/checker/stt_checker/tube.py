"""The tube of the C's table, and P1 to P6: each property holds with the margin that is claimed, in units of the table."""

import itertools
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from .exact import Numbers, fractions, integers, require
from .sets import Obstacle, euclidean_norm

Piece = list[tuple[list, list]]  # by dimension the four Bezier coefficients of the lower and of the upper edge


class Tube:
    """Control points over 6 in whole units. The edge of segment k is the cubic B-spline of the table's rows k to k + 3."""

    def __init__(self, entries: list[Fraction], n: int, unit: Fraction, t_c: Fraction, seam: int | None) -> None:
        """seam: the segment with which a tube that repeats begins again."""
        units = [v / unit for v in entries]
        require(all(v.denominator == 1 for v in units), "the C's table is not of whole units of 2^-unit_bits")
        require(len(units) % (2 * n) == 0 and len(units) > 6 * n, "the C's table has a number of entries that no tube has")
        self.table = [[(int(units[j + 2 * i]), int(units[j + 2 * i + 1])) for i in range(n)] for j in range(0, len(units), 2 * n)]
        self.n, self.unit, self.t_c, self.seam, self.segments = n, unit, t_c, seam, len(self.table) - 3
        require(seam is None or 0 <= seam < self.segments, "the cycle of the tube begins with no segment")
        self.cycle = Fraction(0) if seam is None else t_c * (self.segments - seam) / self.segments
        self.pieces: list[Piece] = []
        for k in range(self.segments):
            rows = [[[row[i][side] for row in self.table[k : k + 4]] for side in (0, 1)] for i in range(n)]
            self.pieces.append([(bezier(*low), bezier(*high)) for low, high in rows])
        self.start = [(low[0], high[0]) for low, high in self.pieces[0]]
        self.end = [(low[3], high[3]) for low, high in self.pieces[-1]]

    def fastest(self, i: int, order: int = 1) -> int:
        """Return the largest coefficient of an edge's derivative of that order in dimension i, in units by a segment's time."""
        edges = [edge for piece in self.pieces for edge in piece[i]]
        for _ in range(order):
            edges = [[(len(c) - 1) * (b - a) for a, b in itertools.pairwise(c)] for c in edges]
        return max(abs(v) for edge in edges for v in edge)

    def speed(self, i: int) -> Fraction:
        """Return a bound on the speed of the edges of dimension i, in the task's units a second."""
        return self.fastest(i) * self.unit * self.segments / self.t_c

    def part(self, a: int, b: int, cuts: int) -> Piece:
        """Return the tube from a to b, counted in parts of a segment; a segment has `cuts` parts."""
        k = min(a // cuts, self.segments - 1)
        return self.pieces[k] if b - a == cuts else part_of(self.pieces[k], Fraction(a, cuts) - k, Fraction(b, cuts) - k)


def bezier(a: int, b: int, c: int, d: int) -> list[int]:
    """Return the Bezier coefficients of a cubic B-spline with these control points over 6."""
    return [a + 4 * b + c, 4 * b + 2 * c, 2 * b + 4 * c, b + 4 * c + d]


def part_of(piece: Piece, a: Fraction, b: Fraction) -> Piece:
    """Return the Bezier coefficients of a piece from a to b, of 0 to 1."""
    return [(cut(low, a, b), cut(high, a, b)) for low, high in piece]


def cut(c: list, a: Fraction, b: Fraction) -> list:
    """Return the Bezier coefficients of an edge from a to b: its blossom at (a, a, a), (a, a, b), (a, b, b), (b, b, b)."""
    coefficients = []
    for j in range(4):
        row = c
        for t in [a] * (3 - j) + [b] * j:
            row = [u + t * (v - u) for u, v in itertools.pairwise(row)]
        coefficients += row
    return coefficients


def by_segment(begin: int, stop: int, cuts: int) -> Iterator[tuple[int, int]]:
    """Yield a stretch, in parts of a segment, segment by segment; a moment as it is."""
    return itertools.pairwise([begin, *range((begin // cuts + 1) * cuts, stop, cuts), stop])


def normals_of(claim: Any, n: int, cuts: int) -> Iterator[tuple[int, int, list[int], Numbers]]:
    """Read the hints of a claim: stretches without a gap over its interval, each with a normal and perhaps multipliers. Yield
    them segment by segment."""
    (at, stop), hints = claim["on"], claim.get("hints")
    require(isinstance(hints, list) and bool(hints), "a claim to avoid a set has no hints")
    for first, last, normal, *more in hints:
        require(type(first) is type(last) is int and at == first <= last <= stop, "the hints leave a gap, or are in no order")
        is_hint = any(integers(normal, n)) and len(more) <= 1 and all(isinstance(v, list) for v in more)
        require(is_hint, "a hint is not two times, a normal and perhaps multipliers")
        multipliers = [y for values in more for y in fractions(values, len(values))]
        for a, b in by_segment(first, last, cuts):
            yield a, b, normal, multipliers
        at = last
    require(at == stop, "the hints leave a gap in time")


def avoids(task: Any, tube: Tube, obstacle: Obstacle, claim: Any, cuts: int) -> bool:
    """Return whether the tube is beyond a set along the normals of the hints, by the clearance and the margin. Where the set
    moves this is asked for each part of a piece in which no motion turns."""
    seconds = task.t_c / (tube.segments * cuts)  # of a part of a segment
    for a, b, normal, multipliers in normals_of(claim, task.n, cuts):
        size, piece = sum(map(abs, normal)), tube.part(a, b, cuts)
        clearance = sum(abs(c) * v for c, v in zip(normal, task.clearance, strict=True))
        needed = (obstacle.largest_height(normal, multipliers) + clearance) / tube.unit + claim["margin"] * size
        heights = [sum(c * piece[i][c < 0][k] for i, c in enumerate(normal) if c) for k in range(4)]
        if obstacle.course is None:
            if min(heights) < needed:
                return False
        elif not is_ahead(obstacle, normal, [h - needed for h in heights], (a * seconds, b * seconds), tube.unit):
            return False
    return True


def is_ahead(obstacle: Obstacle, normal: list[int], excess: list[Any], times: tuple[Fraction, Fraction], unit: Fraction) -> bool:
    """Return whether the tube is ahead of a set that moves and grows. excess: Bezier coefficients of what the tube is beyond the
    set at rest, in units. The largest height of the set is linear in time on each leg, or convex: its values at the coefficients'
    places bound it."""
    begin, end = times
    course: Any = obstacle.course
    part = [normal[i] for i in obstacle.axes]
    growth = course.spread * (euclidean_norm(part) if obstacle.radius else sum(map(abs, part)))
    for p, q, corners in course.legs(begin, end):
        for k, value in enumerate(cut(excess, *((t - begin) / (end - begin) for t in (p, q)))):
            share = Fraction(k, 3)
            moved = max(sum(c * (u + share * (v - u)) for c, u, v in zip(normal, *ends, strict=True)) for ends in corners)
            if value < (moved + growth * (p + share * (q - p) + course.late)) / unit:
                return False
    return True


def prove(task: Any, tube: Tube, claims: list, cuts: int, error: int) -> None:
    """Prove P1 to P6 with the margins of the claims, in their order, and take these off the list. error: the most that the
    arithmetic moves an edge, in units."""
    unit, end = tube.unit, tube.segments * cuts

    def pieces(claim: Any) -> Iterator[Piece]:
        """Yield the tube piece by piece, and cut where the hints say so: at any places, for a cut changes nothing."""
        places = {v for hint in claim.get("hints", []) for v in hint if type(v) is int and 0 <= v <= end}
        return (tube.part(a, b, cuts) for a, b in itertools.pairwise(sorted(places | {*range(0, end + 1, cuts)})))

    claim = take_claim(claims, "P1", [0, end], 2 * error)
    narrowest = [v / unit + claim["margin"] for v in task.min_width]
    for piece in pieces(claim):
        for name, edges, width in zip(task.names, piece, narrowest, strict=True):
            is_wide = all(b - a >= width for a, b in zip(*edges, strict=True))
            require(is_wide, f"P1 does not hold: the tube is narrower than min_width in {name}")

    margin = take_claim(claims, "P2", [0, 0], error)["margin"]
    for name, (a, b), x, low, high in zip(task.names, tube.start, task.state, *task.start, strict=True):
        has_state = a + margin <= x / unit <= b - margin
        require(has_state, f"P2 does not hold: {name} of initial_state is not between the tube's edges at 0")
        is_within = low / unit + margin <= a and b + margin <= high / unit
        require(is_within, f"P2 does not hold: the tube at 0 is not within initial_set in {name}")

    claim = take_claim(claims, "P3", [0, end], error)
    hulls = ([(low[k], high[k]) for low, high in piece] for piece in pieces(claim) for k in range(4))
    is_within = all(task.space.contains(edges, claim["margin"], unit) for edges in hulls)
    require(is_within, "P3 does not hold: the tube leaves the state space")

    for obstacle in task.unsafe:
        claim = take_claim(claims, "P4", [0, end], error, set=obstacle.name)
        require(avoids(task, tube, obstacle, claim, cuts), f"P4 does not hold: {obstacle.name}")

    if task.reaches:
        claim = take_claim(claims, "P5", [end, end], error)
        require(task.target.contains(tube.end, claim["margin"], unit), "P5 does not hold: the tube at t_c is not in the target")

    last = tube.table[-3:]
    is_smooth = all(row == last[0] for row in last[3 - task.order :])
    if tube.seam is not None:
        is_smooth = last == tube.table[tube.seam : tube.seam + 3]
    require(is_smooth, "P6 does not hold: the tube has a kink")
    for order, limits in ((1, task.max_speed), (2, task.max_acceleration)):
        if order == 1 or limits:
            claim = take_claim(claims, "P6", [0, end], 0 if limits else None, **({} if order == 1 else {"order": order}))
            scale = (task.t_c / tube.segments) ** order / unit
            is_slow = all(tube.fastest(i, order) + claim["margin"] <= v * scale for i, v in enumerate(limits or []))
            require(is_slow, f"P6 does not hold: the tube moves too fast (derivative {order})")


def take_claim(claims: list, code: str, on: list[int], needed: Any, **more: Any) -> Any:
    """Return the next claim, which must be about this property. needed: the margin that it must have; None where it has none."""
    claim = claims.pop(0) if claims else {}
    wanted = {"property": code, "on": on, **more}
    optional = ("margin", "hints") if code in ("P1", "P3", "P4") else ("margin",)
    is_wanted = {k: v for k, v in claim.items() if k not in optional} == wanted and type(claim["on"]) is list
    require(is_wanted and all(type(v) is int for v in claim["on"]), f"the certificate does not claim {wanted}")
    if needed is None:
        require("margin" not in claim, f"{code} is claimed with a margin that it does not have")
    else:
        require(type(claim.get("margin")) is int and claim["margin"] >= needed, f"{code} does not hold: its margin is too small")
    return claim
