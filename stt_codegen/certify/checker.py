#!/usr/bin/env python3
"""Checks a certified controller without the tool that made it. Standard library only.

    python3 checker.py task.toml controller.c certificate.json        (controller.h beside controller.c)

It reads the task's numbers as exact decimals and every token of the C, runs the C's statements on symbols, and finds that they
compute the tube of the C's table and the control law of the task: every branch, every index, every constant. It repeats the proof
that this tube starts, keeps its width, stays, avoids, arrives and is smooth (P1 to P6), that u can hold the state in it where it
is limited (P8), and that a sampled loop does where the task has a period (P9), in exact fractions, with a bound of its own on the
rounding of the statements read (P7). Of a controller in integers it compares every token with a text of its own, proves that its
tables are the curves of the law, that no value leaves 32 bits, and what all of it is wrong by.
Every claim of the certificate is compared; a claim that it does not know is refused. docs/certificate-format.md says what it all
means. It speaks about refined tubes; for others it says that it cannot.

Long because it is one file, to be copied anywhere and read from top to bottom: task, C, symbols, specification, integers, proof,
claims.

Assumed: a C99 compiler without contraction of a * b + c, IEEE-754 arithmetic, and a library whose logarithm is within 4 units.
Exit code 0: all holds. 1: something does not, and what. 2: a file cannot be used.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import operator
import re
import secrets
import sys
import tomllib
from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import Any, NoReturn

LEAST_WIDTH = Fraction(1, 1 << 20)  # the emitted law treats narrower tubes as this wide
RUNS = 4096  # of one function, by the answers to its comparisons
SMALL = Fraction(1, 1 << 100)  # literals and intermediate values lie between this and its inverse: none over- or underflows
KEYWORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long register restrict "
    "return short signed sizeof static struct switch typedef union unsigned void volatile while bool true false isfinite log "
    "logf memcpy"
)
LOCAL = re.compile(rf"(?!(?:{KEYWORDS.replace(' ', '|')})$)[a-z]\w*", re.ASCII)  # what a name of the C may be
LAW = {
    "libm": {24: 2.0**-19, 53: 2.0**-46},
    "inline": {24: 2.0**-14, 53: 2.0**-14},
    "integers": {20: 2.0**-10},
}  # its rounding, see docs/certificate-format.md
KNOWN = {
    "": "name axes units periodic prescribed_time repeat start_delay initial_state body state_space initial_set target_set "
        "unsafe region mission tube control emit plant",
    "state_space": "lower upper axes vertices normals offsets", "initial_set": "lower upper share speed",
    "target_set": "lower upper axes vertices normals offsets centre radius motion",
    "unsafe": "name axes motion during timing spread lower upper vertices normals offsets centre segment radius",
    "region": "name any_of axes lower upper vertices normals offsets centre segment radius",
    "mission": "visit between stay then within never before patrol every until formula",
    "tube": "design clearance min_width prefer max_speed max_acceleration filter segments seed adaptive",
    "control": "gain e_max u_max period latency outside velocity period_min saturate",
    "emit": "scalar math tick_period selftest rust", "plant": "order f_max w_max g_min g_max g_cross noise noise_v",
}  # fmt: skip
LISTS = ("unsafe", "region", "mission")
UNREAD = (".rs",)  # of files in a language that a task has to ask for: of these nothing is proved here
FORMS = ("lower upper", "vertices", "normals offsets", "centre radius", "segment radius")  # of an unsafe set
# All fields that `_cuts` reads, or that say nothing of the shape: a set by any other field has half-spaces that it does not know.
CUT_BY = "name axes motion lower upper centre radius vertices normals offsets"
FAN: tuple[tuple[tuple[int, ...], ...], ...] = (  # normals of a target that is a ball, by its dimensions
    (), ((1,),), ((1, 0), (5, 1), (5, 2), (3, 2), (1, 1)),
    ((1, 0, 0), (1, 1, 0), (1, 1, 1), (2, 1, 0), (2, 1, 1), (2, 2, 1)),
)  # fmt: skip
FARTHEST = (Fraction(1), Fraction(1), Fraction("1.0055"), Fraction("1.0495"))  # corners of that polytope about the unit ball
CLAIMS = (
    "format task certified design method order scalar sha256 grid edge_error speed start covers_initial_set control claims"
).split()


Box = tuple[list[Fraction], list[Fraction]]  # lower and upper edges
Unsafe = tuple[list[list[Fraction]], list[Fraction], list[int], Fraction]


class Failed(Exception):
    """A property, a claim, a hash or a statement of the C that does not hold."""


class Unusable(Exception):
    """A file that is not what it should be."""


def need(holds: bool, otherwise: str) -> None:
    if not holds:
        raise Failed(otherwise)


# ------------------------------------------------------------------------------------------------ the task


class Task:
    """The numbers of a task file, exact; the body already added to the sets. Keys that are not known here are refused."""

    def __init__(self, data: bytes) -> None:
        document = tomllib.loads(data.decode("utf-8-sig"), parse_float=_decimal)
        self.digest = hashlib.sha256(json.dumps(_plain(document), sort_keys=True, separators=(",", ":")).encode()).hexdigest()
        _spelled_out(document)
        tables = [(name, entry) for name, v in document.items() for entry in (v if name in LISTS else [v]) if name in KNOWN]
        for name, entry in [("", document), *tables]:
            unknown = set(entry) - set(KNOWN[name].split())
            if unknown:
                raise Unusable(f"the task has {sorted(unknown)[0]!r}, which is not known here")
        control, emit, self.name = document.get("control", {}), document.get("emit", {}), str(document["name"])
        self.t_c, self.state = _number(document["prescribed_time"]), [_number(v) for v in document["initial_state"]]
        n = self.n = len(self.state)
        body = _each(document.get("body", 0), n)
        self.start, (lower, upper) = _box(document["initial_set"], n), _box(document["state_space"], n)
        names = document.get("axes") or [f"x{i + 1}" for i in range(n)]
        walls = _cuts(document["state_space"], names)
        self.reaches = "target_set" in document or "mission" not in document
        target = document["target_set"] if self.reaches else document["state_space"]
        self.turns = Turns(document, names, self.state, self.start, body, self.t_c)
        self.turns.space(target if self.reaches else None, walls, lower, upper)
        self.farthest = max(map(abs, lower + upper))
        self.space = ([a + h for a, h in zip(lower, body)], [b - h for b, h in zip(upper, body)])
        self.target, self.goals = self.turns.target(*_target(target, names, self.space, self.t_c))
        self.walls = [(normal, offset - sum(abs(c) * h for c, h in zip(normal, body))) for normal, offset in walls]
        delay, tube = _number(document.get("start_delay", 0)), document.get("tube", {})
        moving = self._sets(document, names, (lower, upper), delay) or "motion" in target
        self.clock = {"start_delay": str(delay), "timing": self.doubt} if moving else None
        self.mission = Mission(document, names, (lower, upper), body, self.t_c, delay) if "mission" in document else None
        self.repeats = self._repeats(document, moving)
        self.min_width = max(_number(tube.get("min_width", Decimal("0.05"))), LEAST_WIDTH)
        self.segments = _number(tube["segments"]) if "segments" in tube else None
        self.limits = [_each(tube[k], n) if k in tube else None for k in ("max_speed", "max_acceleration")]
        self._plant(document)
        self.period, self.latency = (
            _number(control["period"]) if "period" in control else None,
            _number(control.get("latency", 0)),
        )
        gain = control.get("gain", Decimal("0.5") if self.period is None else "auto")
        self.gain = None if gain == "auto" else _each(gain, n)
        self.e_max = _each(control.get("e_max", Decimal("0.99")), n)
        self.u_max = _each(control["u_max"], n) if "u_max" in control else None
        self.apart, self.scales = self._apart(control, document), self._scales(control, document.get("plant", {}))
        self._emitted(control, emit)
        given = [*(self.plant["g_min"] or []), *(self.plant["g_max"] or []), self.period, self.tick, *(self.u_max or [])]
        given += [v for most in self.limits for v in most or []]
        positive = [self.t_c, self.share, *self.e_max, *(v for v in given if v is not None)]
        not_negative = [
            self.clearance,
            self.latency,
            delay,
            *body,
            *self.speed,
            *(v for values in self.plant.values() for v in values or []),
        ]
        if min(positive) <= 0 or min(not_negative) < 0 or max(self.share, *self.e_max) >= 1:
            raise Unusable("the task has a number of the wrong sign, or a share or e_max that is not below 1")

    def _sets(self, document: dict[str, Any], names: list[str], space: Box, delay: Fraction) -> bool:
        """Unsafe sets, how they move, and the clearance; whether their clock matters."""
        clearance = _number(document.get("tube", {}).get("clearance", Decimal("0.03")))
        named = [(str(e.get("name") or f"U{j}"), e) for j, e in enumerate(document.get("unsafe", []), 1)]
        found, timed = self.turns.sets(named, space, clearance, delay), {"motion", "during", "spread"}
        self.clearance = clearance + self.turns.margin
        self.unsafe = [(name, convex) for name, convex, _ in found]
        _differ([name for name, _ in self.unsafe])
        self.courses = [Course(e, names, delay, self.t_c) if timed & {*e} else None for *_, e in found]
        self.doubt = {name: str(_number(e["timing"])) for name, _, e in found if "timing" in e}
        return any({"motion", "during"} & {*e} or e.get("spread") for *_, e in found)

    def _repeats(self, document: dict[str, Any], moving: bool) -> bool:
        """Whether the tube goes on for ever."""
        told = document.get("repeat", False)
        if type(told) is not bool or (told and (self.mission is None or moving or "target_set" in document)):
            raise Unusable("the task has a `repeat` that is not known here, or for what has an end")
        return told

    def _emitted(self, control: dict[str, Any], emit: dict[str, Any]) -> None:
        """How late u may be; what the C looks like, and has beside it."""
        self.outside, self.inline = (
            _outside(control, self.order == 2 or (self.clock or self.mission) is not None),
            emit.get("math") == "inline",
        )
        self.selftest = bool(emit.get("selftest", False))
        self.tick: Fraction | None = _number(emit["tick_period"]) if "tick_period" in emit else None

    def _plant(self, document: dict[str, Any]) -> None:
        """What is said of the plant, of its starts, and for order 2 of lambda."""
        plant, tube, first = document.get("plant", {}), document.get("tube", {}), document["initial_set"]
        self.order, self.share = plant.get("order", 1), _number(first.get("share", Decimal("0.9")))
        self.speed = _each(first.get("speed", 0), self.n)
        self.filter = None if tube.get("filter", "auto") == "auto" else _each(tube["filter"], self.n)
        second = "filter" in tube or "speed" in first or "noise_v" in plant
        if type(self.order) is not int or self.order not in (1, 2) or (second and self.order == 1):
            raise Unusable("the task has an order that is not 1 or 2, or says what is for order 2 alone")
        if min([*self.speed, *(self.filter or [Fraction(1)])]) < 0:
            raise Unusable("the task has a negative speed or filter")
        known = KNOWN["plant"].split()[1 : 6 + self.order]
        self.plant = {k: _each(plant[k], self.n) if k in plant else None for k in known}
        self.stated = {k: None if k not in plant else _told(plant[k]) for k in known}
        if any(isinstance(plant.get(k), list) for k in ("noise", "noise_v")):
            raise Unusable("the task has a list as noise")

    def _scales(self, control: dict[str, Any], plant: dict[str, Any]) -> bool:
        """Whether u is limited as a whole; what is shown of that is about norms, in continuous time."""
        kind, lists = control.get("saturate", "clip"), any(isinstance(v, list) for v in plant.values())
        one = self.u_max is not None and len(set(self.u_max)) == 1 and (self.gain is None or len(set(self.gain)) == 1)
        known = kind == "clip" or (kind == "scale" and one and not lists and self.order == 1 and self.period is None)
        if not known:
            raise Unusable("the task has a `saturate` that is not known here")
        return bool(kind == "scale")

    def _apart(self, control: dict[str, Any], document: dict[str, Any]) -> Fraction | None:
        """Seconds between samples at least, where v is by differences."""
        kind, shortest = control.get("velocity", "measured"), _number(control.get("period_min", 1))
        known = kind == "differences" and self.order == 2 and self.period is not None and self.u_max is not None
        if kind != "measured" and (not known or "noise_v" in document.get("plant", {}) or any(self.speed)):
            raise Unusable("the task has a velocity that is not known here, or by differences of what is not known")
        if shortest <= 0 or (kind == "measured" and "period_min" in control):
            raise Unusable("the task has a period_min that is not positive, or for a velocity that is measured")
        if not known or self.period is None:
            return None
        return shortest if "period_min" in control else self.period / 2

    unwrap_noise: Fraction | None = None  # of a measured x, with what unwrapping adds; None where no axis closes

    def unwrapped(self, bits: int) -> None:
        """Add what unwrapping is wrong by to the noise of a measured x, for a scalar of so many bits."""
        if self.turns.periods:
            noise = self.unwrap_noise = self.turns.noise(bits, (self.plant["noise"] or [Fraction(0)])[0])
            if self.period is not None:
                self.plant["noise"], self.stated["noise"] = [noise] * self.n, str(noise)

    @property
    def limited(self) -> bool:
        """Whether P8 is asked for."""
        bounded = any(v is not None for k, v in self.plant.items() if not k.startswith("noise"))
        return self.u_max is not None and bounded and self.period is None


class Course:
    """How a set moves, and when it is unsafe: displacements at times on its clock, linear between, constant before and after; on
    the controller's that clock is `early` behind at most, and `late` ahead. Times in seconds."""

    def __init__(self, table: Any, names: list[str], delay: Fraction, t_c: Fraction) -> None:
        own, timing = _own(table, names), _number(table.get("timing", 0))
        self.early, self.late, self.spread = timing, timing + delay, _number(table.get("spread", 0))
        self.knots = [(Fraction(0), [Fraction(0)] * len(names))]
        if "motion" in table:
            entries = table["motion"]
            listed = isinstance(entries, list) and 0 < len(entries) <= 200
            if not listed or not all(isinstance(v, dict) and {*v} == {"at", "by"} for v in entries):
                raise Unusable("the task has a motion that is no list of { at, by }, 200 at most")
            given = [(_number(v["at"]), dict(zip(own, _vectors([v["by"]], len(own))[0]))) for v in entries]
            self.knots = [(at, [place.get(i, Fraction(0)) for i in range(len(names))]) for at, place in given]
        times = [at for at, _ in self.knots]
        self.first, self.last = _each(table["during"], 2) if "during" in table else (-self.early, t_c + self.late)
        window = "during" not in table or 0 <= self.first < self.last <= t_c
        if not window or min(timing, self.spread, *times) < 0 or max(times) > t_c or sorted({*times}) != times:
            raise Unusable("the task has a motion or a window that is not within its time, or in no order")

    def displaced(self, tau: Fraction) -> list[Fraction]:
        """At a time on the set's clock."""
        tau, (at, here) = min(max(tau, self.first), self.last), self.knots[0]
        for to, there in self.knots[1:]:
            if at < tau <= to:
                return [v + (tau - at) / (to - at) * (w - v) for v, w in zip(here, there)]
            if to <= tau:
                here = there
            at = to
        return here

    def legs(self, a: Fraction, b: Fraction) -> Iterator[tuple[Fraction, Fraction, list[tuple[list[Fraction], list[Fraction]]]]]:
        """From a to b on the controller's clock: where it may be unsafe, between the times at which something turns, and the
        corners of the path that it may be on, each from its first place to its last."""
        begin, end = max(a, self.first - self.late), min(b, self.last + self.early)
        turns = {self.first, self.last, *(at for at, _ in self.knots if self.first < at < self.last)}
        moments = {v for tau in turns for v in (tau + self.early, tau - self.late) if begin < v < end}
        for p, q in itertools.pairwise(sorted({begin, end, *moments}) if begin < end else []):
            still = [self.displaced(tau) for tau in turns if q - self.early <= tau <= p + self.late]
            ends = [(self.displaced(p + s), self.displaced(q + s)) for s in (-self.early, self.late)]
            yield p, q, ends + [(d, d) for d in still]


@cache
def two_pi() -> tuple[Fraction, Fraction]:
    """2 pi from below and above, by Machin's formula: partial sums of an alternating series bound it."""

    def arctangent(n: int, terms: int) -> Fraction:
        return sum((Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(terms)), Fraction(0))

    (a, b), (c, d) = (sorted(arctangent(n, terms) for terms in (40, 41)) for n in (5, 239))
    return 8 * (4 * a - d), 8 * (4 * b - c)


def drift(period: Fraction) -> Fraction:
    """What a period differs from 2 pi/m, m up to 12, up to a multiple of 1e-18, where it is within a thousandth of it; else 0."""
    low, high = two_pi()
    for m in range(1, 13):
        off = max(abs(period - low / m), abs(period - high / m))
        if off <= high / (1000 * m):
            return Fraction(math.ceil(off * 10**18), 10**18)
    return Fraction(0)


class Turns:
    """Axes that close after a period: what else their turns make of state space, target and unsafe sets. All of it is nothing
    where no axis closes."""

    def __init__(
        self, document: dict[str, Any], names: list[str], state: list[Fraction], start: Box, body: list[Fraction], t_c: Fraction
    ) -> None:
        given = document.get("periodic", {})
        known = isinstance(given, dict) and set(given) <= set(names) and ("periodic" not in document or given)
        regions = (e.get("axes", names) for e in document.get("region", []) if "any_of" not in e)
        integers = bool(given) and document.get("emit", {}).get("scalar") == "fixed"
        if not known or integers or any({*given} & {*axes} for axes in regions):
            raise Unusable("the task has axes that close and are not its own, or of a region, or of a controller in integers")
        self.names, self.state, self.start, self.body, self.t_c = names, state, start, body, t_c
        self.periods = {i: _number(given[name]) for i, name in enumerate(names) if name in given}
        if any(v <= 0 for v in self.periods.values()):
            raise Unusable("the task has a period of an axis that is not above 0")
        self.drifts = {i: drift(v) for i, v in self.periods.items()}
        self.steps = dict[int, Fraction]()  # by less than so much x may move between samples
        self.by, self.margin, self.most = dict.fromkeys(self.periods, 0), Fraction(0), 0

    def space(self, target: Any, walls: list[tuple[list[int], Fraction]], lower: list[Fraction], upper: list[Fraction]) -> None:
        """Choose the target's turn, nearest to the initial state; where the state space has a whole turn, let it go half a turn
        beyond start and target. Lower and upper edges are changed in place."""
        before = ([a + h for a, h in zip(lower, self.body)], [b - h for b, h in zip(upper, self.body)])
        edges = None if target is None else _target(target, self.names, before, self.t_c)[0]
        for i, period in self.periods.items():
            limited = upper[i] - lower[i] < period
            if not limited and any(normal[i] for normal, _ in walls):
                raise Unusable("the task has half-spaces that cut the state space in an axis that closes")
            ends = [(self.start[0][i], self.start[1][i])]
            if edges is not None and ("lower" in target or i in _own(target, self.names)):
                a, b = edges[0][i], edges[1][i]
                off = (self.state[i] - (a + b) / 2) / period
                near = list(range(math.floor(off) - 100, math.ceil(off) + 101))
                if limited:
                    near = [k for k in near if before[0][i] <= a + k * period and b + k * period <= before[1][i]]
                if not near:
                    raise Unusable("the task has a target of which no image lies in the state space")
                k = self.by[i] = min(near, key=lambda k: (abs(k - off), abs(k), -k))
                ends.append((a + k * period, b + k * period))
            if not limited:
                lower[i], upper[i] = min(a for a, _ in ends) - period / 2, max(b for _, b in ends) + period / 2
        self.far = {i: int(max(abs(lower[i]), abs(upper[i])) / v) + 2 for i, v in self.periods.items()}

    def target(self, edges: Box, goals: list[tuple[list[int], Fraction]]) -> tuple[Box, list[tuple[list[int], Fraction]]]:
        """The target on its turn, less what the periods differ from 2 pi/m."""
        for i, k in self.by.items():
            by, less = k * self.periods[i], abs(k) * self.drifts[i]
            if k:  # of a target that does not bound the axis k is 0
                edges[0][i], edges[1][i] = edges[0][i] + by + less, edges[1][i] + by - less
            goals = [(normal, offset + normal[i] * by - abs(normal[i]) * less) for normal, offset in goals]
        if any(a >= b for a, b in zip(*edges)):
            raise Unusable("the task has a target that is narrower than what its turns are wrong by")
        return edges, goals

    def sets(
        self, named: list[tuple[str, Any]], space: Box, clearance: Fraction, delay: Fraction
    ) -> list[tuple[str, Unsafe, Any]]:
        """The unsafe sets by name, and after them their images, as far as these can come near the state space."""
        found, images = list[tuple[str, Unsafe, Any]](), list[tuple[str, Unsafe, Any]]()
        for name, table in named:
            own = _own(table, self.names)
            closed = [i for i in own if i in self.periods]
            room = [list(edges) for edges in space]
            for i in closed:
                room[0][i], room[1][i] = (self.state[i] + s * 64 * self.periods[i] for s in (-1, 1))
            points, half, _, radius = convex = _unsafe(table, self.names, (room[0], room[1]), self.body)
            if "normals" in table and any(not room[0][i] < p[i] < room[1][i] for i in closed for p in points):
                raise Unusable("the task has half-spaces that leave a set open in an axis that closes")
            found.append((name, convex, table))
            ranges = []
            for i in closed:
                place, period = own.index(i), self.periods[i]
                by = [_number(p["by"][place]) for p in table.get("motion", [])] or [Fraction(0)]
                grown = _number(table.get("spread", 0)) * (self.t_c + _number(table.get("timing", 0)) + delay)
                reach = clearance + half[i] + radius + grown + period / 8
                first = math.ceil((space[0][i] - reach - max(p[i] for p in points) - max(by)) / period)
                last = math.floor((space[1][i] + reach - min(p[i] for p in points) - min(by)) / period)
                ranges.append(sorted({0, *range(first, last + 1)}, key=lambda k: (abs(k), -k)))
            if math.prod(map(len, ranges)) > 64:
                raise Unusable("the task has a set with more images than can be checked in good time")
            for turns in itertools.product(*ranges):
                if any(turns):
                    by_axis = {i: k * self.periods[i] for i, k in zip(closed, turns)}
                    moved = [[v + by_axis.get(i, Fraction(0)) for i, v in enumerate(p)] for p in points]
                    images.append((name + "".join(f"{k:+d}" for k in turns), (moved, half, own, radius), table))
                    self.margin = max([self.margin, *(abs(k) * self.drifts[i] for i, k in zip(closed, turns))])
                    self.most = max(self.most, *map(abs, turns))
        return found + images

    def noise(self, bits: int, noise: Fraction) -> Fraction:
        """A bound on the error of an unwrapped measurement; its first, and all that move by less than what is left of half a
        turn, are on the right one."""
        worst = Fraction(0)
        for i, period in self.periods.items():
            far = self.far[i]
            more = far * self.drifts[i] + period * (3 * far + 3) / (1 << bits)
            more = Fraction(math.ceil(more * 10**12), 10**12)
            step = period / 2 - 2 * (noise + more) - 4 * more
            first = max(self.state[i] - self.start[0][i], self.start[1][i] - self.state[i])
            if max(far, self.most) > 100 or first >= step:
                raise Unusable("the task has starts, turns or noise with which a measured angle is on no known turn")
            worst, self.steps[i] = max(worst, more), step
        return noise + worst


def _number(value: Any) -> Fraction:
    if isinstance(value, bool) or not isinstance(value, int | Decimal):
        raise Unusable(f"the task has {value!r} where a number is needed")
    return Fraction(value)


def _decimal(text: str) -> Decimal:
    value = Decimal(text)
    if not (value.is_finite() and abs(value.adjusted()) < 400):
        raise Unusable(f"the task has {text:.40}, which is out of range")
    return value


def _each(value: Any, n: int) -> list[Fraction]:
    found = [_number(v) for v in (value if isinstance(value, list) else [value] * n)]
    if len(found) != n:
        raise Unusable(f"the task has {len(found)} numbers where {n} are needed")
    return found


def _outside(control: dict[str, Any], goes_on: bool) -> str:
    kind = str(control.get("outside", "return"))
    if kind not in ("return", *GUARDS) or (kind == "hold" and goes_on):
        raise Unusable("the task has an `outside` that is not known here, or a tube that waits for what does not")
    return kind


def _differ(names: list[str]) -> None:
    if len({*names}) < len(names):
        raise Unusable("the task has two unsafe sets of one name")


def _spelled_out(document: dict[str, Any]) -> None:
    space = document.get("state_space")
    unread = "a map" if "map" in document else "an outline" if isinstance(space, dict) and "outline" in space else None
    if unread is not None:
        raise Unusable(
            f"the task has {unread}; give the .task.toml that was written beside the C, where its sets are spelled out"
        )


def _told(value: Any) -> Any:
    return [str(_number(v)) for v in value] if isinstance(value, list) else str(_number(value))


def _unsafe(table: Any, names: list[str], space: Box, body: list[Fraction]) -> Unsafe:
    """An unsafe set as points, half extents (n), own dimensions, radius: the hull of the points, and about each of its points a
    box and in the own dimensions a ball."""
    own = _own(table, names)
    form = " ".join(k for k in KNOWN["unsafe"].split() if k in table and k not in "name axes motion during timing spread".split())
    if form not in FORMS:
        raise Unusable("the task has an unsafe set that is said in no way that is known here")
    d, radius = len(own), _number(table.get("radius", 0))
    middle, half = [(a + b) / 2 for a, b in zip(*space)], [(b - a) / 2 + h for a, b, h in zip(*space, body)]
    extents = [Fraction(0)] * d
    if form == "lower upper":
        box = _box(table, d)
        points, extents = [[(a + b) / 2 for a, b in zip(*box)]], [(b - a) / 2 for a, b in zip(*box)]
    elif form == "normals offsets":
        normals = _vectors(table["normals"], d)
        if len(normals) > 32 or d > 3:
            raise Unusable("the task has more half-spaces than can be checked in good time")
        points = _cut(normals, _each(table["offsets"], len(normals)), *([edges[i] for i in own] for edges in space))
    elif form == "vertices":
        points = _vectors(table["vertices"], d)
    else:
        points = _vectors(table["segment"] if "segment" in table else [table["centre"]], d)
    if not points or radius < 0 or ("radius" in table and not radius):
        raise Unusable("the task has an unsafe set that is empty, or a radius that is not above 0")
    for i, extent in zip(own, extents):
        half[i] = extent + body[i]
    return [[dict(zip(own, p)).get(i, v) for i, v in enumerate(middle)] for p in points], half, own, radius


def _target(table: Any, names: list[str], space: Box, t_c: Fraction) -> tuple[Box, list[tuple[list[int], Fraction]]]:
    """The box of a target and the half-spaces that cut it, where it is at t_c; of a ball without a box its span, and in the other
    dimensions the state space."""
    by, own = Course(table, names, Fraction(0), t_c).displaced(t_c), _own(table, names)
    if ("centre" in table) != ("radius" in table) or ("lower" in table) != ("upper" in table):
        raise Unusable("the task has a target that is said by half")
    if "centre" in table and "lower" not in table:
        ball = dict(zip(own, _each(table["centre"], len(own))))
        low, high = (
            [ball[i] + s * _number(table["radius"]) if i in ball else v for i, v in enumerate(e)] for s, e in zip((-1, 1), space)
        )
    else:
        low, high = _box(table, len(names))
    cuts = [(normal, offset + sum(map(operator.mul, normal, by))) for normal, offset in _cuts(table, names)]
    return ([v + d for v, d in zip(low, by)], [v + d for v, d in zip(high, by)]), cuts


def _own(table: Any, names: list[str]) -> list[int]:
    """The dimensions that a set is in."""
    axes = table.get("axes", names)
    if not isinstance(axes, list) or not axes or not set(axes) <= set(names) or len({*axes}) < len(axes):
        raise Unusable("the task has a set whose axes are none, twice the same, or not the task's")
    return [names.index(a) for a in axes]


def _cuts(table: Any, names: list[str]) -> list[tuple[list[int], Fraction]]:
    """The half-spaces normal.x <= offset that cut the box of a table, with whole normals; of points, all planes
    through as many of them as there are dimensions that have the others on one side."""
    own, n, found = _own(table, names), len(names), []
    d = len(own)
    unknown = set(table) - set(CUT_BY.split())
    if unknown:
        raise Unusable(f"the task has a set by {sorted(unknown)[0]!r}, and the half-spaces of such a set are not known here")
    if "centre" in table:
        centre, radius = _each(table["centre"], d), _number(table["radius"])
        if d > 3 or radius <= 0 or set(table) & {"vertices", "normals", "offsets"}:
            raise Unusable("the task has a ball that is said in no way that is known here")
        orders = [order for kind in FAN[d] for order in itertools.permutations(kind)]
        for turned in {tuple(map(operator.mul, o, signs)) for o in orders for signs in itertools.product((-1, 1), repeat=d)}:
            offset = sum(map(operator.mul, turned, centre), radius / FARTHEST[d] * length(turned))
            found.append((list(map(Fraction, turned)), offset))
    elif "normals" in table or "offsets" in table:
        normals = _vectors(table["normals"], d)
        found = list(zip(normals, _each(table["offsets"], len(normals))))
    if "vertices" in table:
        points = _vectors(table["vertices"], d)
        if d > 3 or len(points) > 64 or found:
            raise Unusable("the task has a set of too many points or dimensions, or one that is said twice")
        for first, *others in itertools.combinations(points, d):
            rows = [[v - w for v, w in zip(p, first)] for p in others]
            normal = [(-1) ** k * _minor([[*r[:k], *r[k + 1 :]] for r in rows]) for k in range(d)]
            ends = [sum(map(operator.mul, normal, p), Fraction(0)) for p in points]
            here = sum(map(operator.mul, normal, first), Fraction(0))
            for sign in (1, -1):
                if any(normal) and here == sign * max(sign * e for e in ends):
                    found.append(([sign * c for c in normal], sign * here))
        if not found:
            raise Unusable("the task has a set whose vertices have no interior")
    whole = []
    for normal, offset in found:
        scale = math.lcm(*(c.denominator for c in normal))
        common = math.gcd(*(int(c * scale) for c in normal))
        if not common:
            raise Unusable("the task has a half-space whose normal is 0")
        place = dict(zip(own, normal))
        whole.append(([int(place.get(i, 0) * scale / common) for i in range(n)], offset * scale / common))
    return whole


def length(normal: Sequence[int]) -> Fraction:
    """|n|_2, rounded up to a multiple of 2^-32."""
    square = sum(c * c for c in normal) << 64
    root = math.isqrt(square)
    return Fraction(root + (root * root < square), 1 << 32)


def _minor(rows: list[list[Fraction]]) -> Fraction:
    """The determinant, of no rows 1."""
    if not rows:
        return Fraction(1)
    return sum(((-1) ** k * c * _minor([[*r[:k], *r[k + 1 :]] for r in rows[1:]]) for k, c in enumerate(rows[0])), Fraction(0))


def _vectors(value: Any, d: int) -> list[list[Fraction]]:
    if not isinstance(value, list) or not all(isinstance(p, list) for p in value):
        raise Unusable("the task has a set whose points are no lists")
    return [_each(p, d) for p in value]


def _cut(
    normals: list[list[Fraction]], offsets: list[Fraction], lower: list[Fraction], upper: list[Fraction]
) -> list[list[Fraction]]:
    """The corners of a box that is cut by half-spaces: where as many faces as there are dimensions meet and all hold."""
    d = len(lower)
    sides = [[Fraction(s * (k == i)) for k in range(d)] for i in range(d) for s in (-1, 1)]
    ends = [v for a, b in zip(lower, upper) for v in (-a, b)]
    faces, found = list(zip([*normals, *sides], [*offsets, *ends])), []
    for chosen in itertools.combinations(faces, d):
        rows: list[list[Fraction]] = []
        for normal, offset in chosen:  # Gauss and Jordan: each row is 1 in a column of its own, where the others are 0
            row = [*normal, offset]
            for r in rows:
                lead = next(i for i in range(d) if r[i])
                row = [v - row[lead] * w for v, w in zip(row, r)]
            lead = next((i for i in range(d) if row[i]), d)
            if lead == d:
                break
            row = [v / row[lead] for v in row]
            rows = [[v - r[lead] * w for v, w in zip(r, row)] for r in rows] + [row]
        else:
            point = [r[d] for r in sorted(rows, key=lambda r: r[:d], reverse=True)]
            if all(sum(c * v for c, v in zip(n, point)) <= offset for n, offset in faces):
                found.append(point)
    return found


def _box(table: Any, n: int) -> tuple[list[Fraction], list[Fraction]]:
    if not isinstance(table["lower"], list) or not isinstance(table["upper"], list):
        raise Unusable("the task has a set whose edges are no lists")
    lower, upper = _each(table["lower"], n), _each(table["upper"], n)
    if any(a >= b for a, b in zip(lower, upper)):
        raise Unusable("the task has a set with a lower edge that is not below the upper one")
    return lower, upper


def _plain(value: Any) -> Any:
    """What the hash of the task's data is taken of: every number as a reduced fraction."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_plain(v) for v in value]
    if isinstance(value, bool | str):
        return value
    number = Fraction(value)
    return f"{number.numerator}/{number.denominator}"


# ------------------------------------------------------------------------------------------------ the C, read


def rounded(value: Fraction, bits: int, toward: Callable[[Fraction], int] = round) -> Fraction:
    """The nearest number of so many significant bits, ties to even; `math.floor`: the largest that is not above. No constant of a
    controller is near the ends of the exponent's range."""
    if value == 0:
        return value
    exponent = value.numerator.bit_length() - value.denominator.bit_length() - bits
    exponent += abs(value) >= Fraction(2) ** (exponent + bits)
    return toward(value / Fraction(2) ** exponent) * Fraction(2) ** exponent


TOKEN = re.compile(
    r"(?P<skip>[ \n]+|/\*.*?\*/)|(?P<line>#[^\n]*)|(?:\d+\.\d+(?:e-?\d{1,3})?F?|0x[0-9a-f]+U|\d+U?)(?!\w)|[A-Za-z_]\w*"
    r"|\"[^\"\n]*\"|<<=|>>=|<=|>=|<<|>>|!=|==|&&|\+\+|--|\+=|&=|[-+*/<>=!?:;,(){}\[\]&]", re.DOTALL | re.ASCII,
)  # fmt: skip


def tokens(data: bytes) -> list[str]:
    """The tokens of a C file without its comments; a directive is one token."""
    text = data.decode("ascii", "replace")
    need(re.fullmatch(r"[\n -~]*", text) is not None and "\\" not in text and "??" not in text, "the C has characters of no use")
    found, place = [], 0
    while place < len(text):
        match = TOKEN.match(text, place)
        if match is None:
            raise Failed(f"the C has {text[place : place + 20].splitlines()[0]!r}, which is no part of its language")
        place = match.end()
        need(match.group() != "/" or text[place : place + 1] != "/", "the C has a comment by //")
        if match["line"]:
            need(not text[: match.start()].rpartition("\n")[2].strip(" "), "the C has a directive within a line")
            line = re.sub(r"/\*[^*]*\*/", " ", match["line"])
            need("/*" not in line and "//" not in line, f"the C has the line {line!r}")
            found.append(" ".join(line.split()))
        elif match["skip"] is None:
            found.append(match.group())
    return found


Tree = list[Any]  # statements as their tokens with a blank between; (head, Tree) for what stands in braces


def tree(words: Iterator[str], top: bool = True) -> Tree:
    """Tokens as statements and blocks."""
    found: Tree = []
    words_now: list[str] = []
    for word in words:
        if word == "{":
            head = " ".join(words_now)
            found.append((head, tree(words, False)))
            need(not head.endswith("=") or next(words, "") == ";", "the C has a table that does not end")
            words_now = []
        elif word == "}" and not top:
            return found + ([("not ended", " ".join(words_now))] if words_now else [])
        elif word == ";" and words_now.count("(") == words_now.count(")"):
            need(bool(words_now), "the C has an empty statement")
            found.append(" ".join(words_now))
            words_now = []
        else:
            words_now.append(word)
    need(top and not words_now, "the braces of the C do not match")
    return found


KERNELS = "segment segment_at_tick basis basis_rate blend normalized_error transformed_error law".split()
_SPLIT = """typedef char $_real_size[(sizeof($_real) == %dU) ? 1 : -1];
static inline int32_t $_exponent($_real y) { %s bits; (void)memcpy(&bits, &y, sizeof bits); return (int32_t)((bits - %s) >> %d); }
static inline $_real $_mantissa($_real y) { %s bits; (void)memcpy(&bits, &y, sizeof bits); bits = ((bits - %s) & %s) + %s;
    $_real m; (void)memcpy(&m, &bits, sizeof m); return m; }"""  # y = m 2^e with m in [1/sqrt 2, sqrt 2), by the bits of IEEE-754
_BITS = {
    True: (4, "uint32_t", "0x3f3504f3U", 23, "0x7fffffU"),
    False: (8, "uint64_t", "0x3fe6a09e667f3bcdU", 52, "0xfffffffffffffU"),
}
HELPERS = {s: _SPLIT % (size, word, cut, shift, word, cut, mask, cut) for s, (size, word, cut, shift, mask) in _BITS.items()}


class Function:
    """A function of the C: head, type of result, parameters (type, name, how it is passed), and its body."""

    def __init__(self, head: str, result: str, params: list[tuple[str, str, str]], body: Tree) -> None:
        self.head, self.result, self.params, self.body = head, result, params, body


class Source:
    """The C file: directives that are known, tables of numbers, functions; nothing else."""

    def __init__(self, data: bytes, task: Task, single: bool) -> None:
        p = self.p = task.name
        self.single, self.bits, self.scalar = single, 24 if single else 53, "float" if single else "double"
        self.types = {
            f"{p}_real": "real",
            "int32_t": "int",
            "uint32_t": "uint",
            "bool": "bool",
            f"{p}_status": "status",
            "void": "void",
        }
        self.tables: dict[str, list[Fraction]] = {}
        self.functions: dict[str, Function] = {}
        words, lines = tokens(data), self.lines(task)
        need(
            words[: len(lines)] == lines and "#" not in {w[0] for w in words[len(lines) :]},
            "the C has other directives than it should",
        )
        items = tree(iter(words[len(lines) :]))
        helpers = tree(iter(tokens(HELPERS[single].replace("$", p).encode()))) if task.inline else []
        for item in items:
            if item in helpers:
                helpers.remove(item)
            elif isinstance(item, tuple) and item[0].startswith("static const "):
                self.table(*item)
            else:
                need(isinstance(item, tuple), f"the C has {str(item)[:60]!r} outside a function")
                self.function(*item)
        need(not helpers, "the C lacks what splits a number")

    def lines(self, task: Task) -> list[str]:
        sure = "defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)" + ("" if self.single else " && (FLT_EVAL_METHOD != 1)")
        x87 = f"{self.scalar} arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
        return [
            f'#include "{self.p}.h"', *(f"#include <{h}.h>" for h in ("float", "math", "stdbool", "stdint")),
            *(["#include <string.h>"] if task.inline else []),
            "#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))",
            f'#error "{self.p}.c: compile without -ffast-math; it tests its inputs for NaN and infinity"', "#endif",
            f"#if {sure}", f'#error "{self.p}.c: compile for {x87}"', "#endif",
        ]  # fmt: skip

    def clock(self, task: Task, tube: Tube) -> Fraction:
        """What its time is wrong by at most, of t_c: t, K/t_c and their product are rounded."""
        return Fraction(4, 1 << self.bits)

    def number(self, token: str) -> tuple[str, Fraction]:
        """A literal's type, and its value as the compiler rounds it."""
        sign = -1 if token.startswith("- ") else 1
        token = token.removeprefix("- ")
        if "." in token:
            need(token.endswith("F") == self.single, f"the literal {token!r} is not of the file's scalar type")
            value = Fraction(token.rstrip("F"))
            need(value == 0 or SMALL <= value <= 1 / SMALL, f"the literal {token!r} is near the ends of the scalar's range")
            return "real", sign * rounded(value, self.bits)
        need(re.fullmatch(r"(0|[1-9]\d{0,9})U?", token) is not None, f"the C has {token[:40]!r} where a number is expected")
        kind, value = "uint" if token.endswith("U") else "int", Fraction(token.rstrip("U"))
        need(value < (1 << 31), f"the C has {token}, which an int32_t does not hold")
        return kind, value

    def table(self, head: str, body: Tree) -> None:
        match = re.fullmatch(rf"static const {self.p}_real {self.p}_(\w+) \[ ([1-9]\d*) \] =", head)
        entries = body[0][1] if len(body) == 1 and body[0][0] == "not ended" else ""
        numbers = [self.number(v) for v in entries.split(" , ")]
        sound = match is not None and int(match[2]) == len(numbers) and {t for t, _ in numbers} == {"real"}
        need(sound and match is not None and match[1] not in self.tables, f"the C has a table that is none: {head[:60]}")
        self.tables[match[1]] = [v for _, v in numbers]  # type: ignore[index]

    def function(self, head: str, body: Tree) -> None:
        p, known = re.escape(self.p), "|".join(map(re.escape, self.types))
        match = re.fullmatch(rf"(static inline )?({known}) {p}_(\w+) \( (.*) \)", head)
        parts = (
            [re.fullmatch(rf"(const )?({known}) (\* )?(\w+)( \[ {p.upper()}_N \])?", v) for v in match[4].split(" , ")]
            if match
            else []
        )
        if match is None or None in parts or match[3] in self.functions or (match[1] is not None) != (match[3] in KERNELS):
            raise Failed(f"the C has a function that is not known: {head[:60]}")
        params = []
        for part in parts:
            constant, kind, out, name, array = part.groups()  # type: ignore[union-attr]
            how = ("array" if constant else "result") if array else "out" if out else "value"
            good = not (array and out) and (how == "array" or not constant) and LOCAL.fullmatch(name)
            need(good is not None and bool(good), f"the C has a parameter that is not known: {name}")
            params.append((self.types[kind], name, how))
        need(len({name for _, name, _ in params}) == len(params), f"{match[3]} of the C has two parameters of one name")
        self.functions[match[3]] = Function(head, self.types[match[2]], params, body)


GUARDS = {  # P: the prefix, M: in capitals, V: v, where there is one
    "hold": """P_status P_guard(P_real t, const P_real x[M_N], P_real held[2], P_real u[M_N]) {
        const P_real now = t - held[0]; const P_status status = P_control(now, x, u);
        if (status == M_OK) { held[1] = now; } if (status != M_OUTSIDE_TUBE) { return status; }
        held[0] = t - held[1]; return P_control(held[1], x, u); }""",
    "stop": """P_status P_guard(P_real t, const P_real x[M_N], const P_real v[M_N], int *stopped, P_real u[M_N]) {
        P_status status = P_control(t, x, v, u); if (status == M_OUTSIDE_TUBE) { *stopped = 1; }
        if (*stopped != 0) { for (int i = 0; i < M_N; i++) { u[i] = 0; }
            if (status == M_OK) { status = M_OUTSIDE_TUBE; } } return status; }""",
}


def guard(task: Task) -> tuple[list[str], list[str]]:
    """The tokens of the guard's prototype, and of its file; none where there is no guard."""
    if task.outside == "return":
        return [], []
    text = GUARDS[task.outside]
    text = text if task.order == 2 else text.replace("const P_real v[M_N], ", "").replace(" v,", "")
    text = re.sub(r"\bM_", f"{task.name.upper()}_", re.sub(r"\bP_", f"{task.name}_", text))
    found = tokens(text.encode())
    return [*found[: found.index("{")], ";"], [f'#include "{task.name}.h"', *found]


def wrap(task: Task) -> tuple[list[str], list[str]]:
    """The tokens of the prototypes of what turns the clock back, and of its file; none where nothing is repeated."""
    if not task.repeats:
        return [], []
    found, heads = [f'#include "{task.name}.h"'], list[str]()
    for kind, name, end in (("P_real", "", "T_C"), ("uint32_t", "_tick", "TICKS"))[: 2 if task.tick else 1]:
        turned, t = "CYCLE_TICKS" if name else "CYCLE", name[1:] or "t"
        text = f"{kind} P_wrap{name}({kind} {t}) {{ return ({t} < M_{end}) ? {t} : ({t} - M_{turned}); }}"
        text = re.sub(r"\bM_", f"{task.name.upper()}_", re.sub(r"\bP_", f"{task.name}_", text))
        own = tokens(text.encode())
        found, heads = found + own, [*heads, *own[: own.index("{")], ";"]
    return heads, found


def unwrap(task: Task, single: bool) -> tuple[list[str], list[str]]:
    """The same of what counts an axis that closes on over its ends."""
    if not task.turns.periods:
        return [], []
    f, lines = "F" if single else "", ""
    for i in task.turns.periods:
        lines += f"""turns = (x_before[{i}] - x[{i}]) / M_TURN_{i + 1}; if ((turns > -1000.0{f}) && (turns < 1000.0{f})) {{
            x[{i}] += M_TURN_{i + 1} * (P_real)(int)(turns + ((turns < 0.0{f}) ? -0.5{f} : 0.5{f})); }}"""
    text = f"void P_unwrap(const P_real x_before[M_N], P_real x[M_N]) {{ P_real turns; {lines} }}"
    found = tokens(re.sub(r"\bM_", f"{task.name.upper()}_", re.sub(r"\bP_", f"{task.name}_", text)).encode())
    return [*found[: found.index("{")], ";"], [f'#include "{task.name}.h"', *found]


def header(source: Source, task: Task, tube: Tube, hash_: str, phased: bool) -> list[str]:
    """The tokens that the header must have; * stands for a literal that is compared by its value. phased: it has a phase."""
    p, macro = source.p, source.p.upper()
    last, turn = -(-task.t_c // task.tick) if task.tick else 0, []
    if task.repeats:
        turn = [f"#define {macro}_CYCLE *", *([f"#define {macro}_CYCLE_TICKS {tube.cycle / task.tick}U"] if task.tick else [])]
    return [
        f"#ifndef {macro}_H", f"#define {macro}_H", "#include <stdbool.h>", *(["#include <stdint.h>"] if task.tick else []),
        "#ifdef __cplusplus", "extern", '"C"', "{", "#endif",
        *f"typedef {source.scalar} {p}_real ;".split(), f"#define {macro}_N {task.n}", f"#define {macro}_T_C *",
        *([f"#define {macro}_TICK_PERIOD *", f"#define {macro}_TICKS {last}U"] if task.tick else []),
        *turn, *([f"#define {macro}_PERIOD_PROVED *"] if task.period is not None else []),
        *([f"#define {macro}_PERIOD_SHORTEST *"] if task.apart is not None else []),
        f"#define {macro}_SHARE *", *(f"#define {macro}_TURN_{i + 1} *" for i in task.turns.periods),
        f'#define {macro}_DESIGN_HASH "{hash_}"',
        *f"typedef enum {{ {macro}_OK = 0 , {macro}_OUTSIDE_TUBE = 1 , {macro}_BAD_INPUT = 2 }} {p}_status ;".split(),
        *(word for name, f in source.functions.items() if name not in KERNELS for word in (*f.head.split(), ";")),
        *guard(task)[0], *(f"int {p}_phase ( {p}_real t ) ;".split() if phased else []),
        *wrap(task)[0], *unwrap(task, source.bits == 24)[0],
        *([f"#define {macro}_SELFTEST_{hash_}", *f"int {p}_selftest ( void ) ;".split()] if task.selftest else []),
        "#ifdef __cplusplus", "}", "#endif", "#endif",
    ]  # fmt: skip


# ------------------------------------------------------------------------------------------------ the C, run on symbols

STARTS = ("start_lower", "start_upper", "filtered_start_lower", "filtered_start_upper")
PRIME = 2**521 - 1  # numbers and symbols are elements of this field
Value = tuple[str, Any]  # type, and an element, a bool or the name of a status
OPERATIONS: dict[str, Callable[[int, int], int]] = {
    "+": int.__add__,
    "-": int.__sub__,
    "*": int.__mul__,
    "/": lambda a, b: a * pow(b, -1, PRIME),
}


def operation(sign: str, a: int, b: int) -> tuple[str, int, int]:
    """What two operations must agree in, so that they round alike."""
    return (sign, min(a, b), max(a, b)) if sign[-1] in "+*" else (sign, a, b)


def element(value: Fraction | int) -> int:
    return Fraction(value).numerator * pow(Fraction(value).denominator, -1, PRIME) % PRIME


class Machine:
    """Runs the C's functions on symbols, and the specification beside them.

    A symbol is a random element of a field of 2^521 - 1 elements: formulas that are no one quotient of polynomials are found
    equal with a probability below 2^-500. What is no arithmetic (the library's logarithm, truncation, a table at an index) is a
    symbol too, one for each argument. A loop's body is run once, for the component i. Comparisons are questions; `explore` goes
    through all their answers, and with each the C must do what the specification does. Every operation, comparison and cast
    outside the spline kernels must be one that the specification has too, with the same operands, so that it rounds as that does.
    """

    def __init__(self, source: Source, task: Task) -> None:
        self.source, self.task = source, task
        self.symbols: dict[Any, int] = {}
        self.readings: dict[Any, Any] = {}  # of statements and literals: each is read once for all paths
        self.segments = len(source.tables["coefficients"]) // (2 * task.n) - 3
        name, word, out = r"([A-Za-z_]\w*)", rf"([A-Za-z_]\w*|\d\S*|\( - \S+ \)|\( {task.name}_real \) NAN)", r"\* ([A-Za-z_]\w*)"
        kind = "(" + "|".join(map(re.escape, source.types)) + ")"
        call, pick, two = rf"{name} \( (.+) \)", rf"{word} \? {word} : {word}", rf"{word} (<=|&&|[-+*/<]) {word}"
        shapes = {
            "declare": rf"{kind} {name}",
            "let": rf"(const )?{kind} {name} = (.+)",
            "out": rf"{out} = (.+)",
            "set": rf"{name} = (.+)",
            "store": rf"{name} \[ {name} \] = (.+)",
            "return": r"return(?: (.+))?",
            "call": call,
        }
        formulas = {"is": word, "pick": pick, "two": two, "one": rf"([-!]) {word}", "cast": rf"\( {kind} \) {word}",
                    "load": rf"{name} \[ {word} \]", "finite": rf"isfinite \( {word} \) != 0", "call": call}  # fmt: skip
        self.shapes, self.formulas = ({k: re.compile(v) for k, v in given.items()} for given in (shapes, formulas))
        s, at, n = self.symbol("s"), self.symbol("row") + 2 * self.symbol("i"), task.n
        self.places = {(at + c) % PRIME: c for c in range(6 * n + 2)}  # indices of the table that are within it
        weights = [(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3]
        rates = [-3 * (1 - s) ** 2, 9 * s**2 - 12 * s, -9 * s**2 + 6 * s + 3, 3 * s**2]
        self.edges: dict[int, int] = {}  # the symbol of an edge, or of its rate in spline time, by the spline's formula
        for prime, given in (("", weights), ("'", rates)):
            for side in (0, 1):
                places = (self.symbol("load coefficients", (at + 2 * n * j + side) % PRIME) for j in range(4))
                self.edges[sum(w * q for w, q in zip(given, places)) % PRIME] = self.symbol("LU"[side] + prime)

    def symbol(self, name: str, *of: int) -> int:
        """An unknown, or an unknown function's value: the same for the same arguments."""
        return self.symbols.setdefault((name, *of), secrets.randbelow(PRIME))

    # ---- questions

    def explore(self, name: str, specification: Callable[[], None], act: Callable[[], None]) -> None:
        """In every run the C does what the specification does: the same stores, carried values and result."""
        pending: list[dict[Any, bool]] = [{}]
        for _ in range(RUNS):
            if not pending:
                return
            given = pending.pop()
            self.answers, self.allowed, self.effects, self.where, self.carried, self.kernel = dict(given), set(), [], name, 0, ""  # type: ignore[var-annotated]
            self.indices()
            specification()
            wanted, self.effects, self.carried = self.effects, [], 0
            act()
            need(self.effects == wanted, f"{name} of the C does not compute what it should")
            asked = list(self.answers.items())
            pending += [{**dict(asked[:k]), asked[k][0]: not asked[k][1]} for k in range(len(given), len(asked))]
        raise Failed(f"{name} of the C has more branches than can be looked at")

    def indices(self) -> None:
        """What a loop's body computes to find its entries of the table."""
        i, row, n = self.symbol("i"), self.symbol("row"), self.task.n
        at = self.whole("+", row, self.whole("*", i, 2))
        for c in range(1, 6 * n + 2):
            self.whole("+", at, c)

    def ask(self, *question: Any) -> bool:
        return bool(self.answers.setdefault(question, True))

    def less(self, a: int, b: int, sign: str = "<") -> bool:
        """A comparison that the C may have too."""
        self.allowed.add((sign, a % PRIME, b % PRIME))
        return self.ask(sign, (b - a) % PRIME)

    def whole(self, sign: str, a: int, b: int = 0) -> int:
        """An operation on integers, or a cast, that the C may have too."""
        self.allowed.add(operation(f"int {sign}", a, b))
        return self.integer(sign, a, b)

    def integer(self, sign: str, a: int, b: int) -> int:
        if sign in ("/", "truncated"):
            return self.symbol(f"int {sign}", a, b)
        return a if sign in ("real", "int") else OPERATIONS[sign](a, b) % PRIME

    def carry(self, kind: str) -> Any:
        """What a loop carries: first as its body has it, then after it."""
        self.carried += 1
        return self.ask("carried", self.carried) if kind == "bool" else self.symbol("carried", self.carried)

    # ---- operations, of the C and of the specification

    def op(self, sign: str, a: int, b: int) -> int:
        """An operation that the C may have too."""
        self.allowed.add(operation(sign, a, b))
        return self.calculate(sign, a, b)

    def calculate(self, sign: str, a: int, b: int) -> int:
        if sign == "*" and 0 in (a, b):
            return self.symbol("zero times", a + b)  # NaN for an infinity or a NaN
        need(sign != "/" or b != 0, "the C divides by zero")
        return OPERATIONS[sign](a, b) % PRIME

    # ---- the C

    def run(self, name: str, arguments: dict[str, Value]) -> None:
        """A public function; arguments by their roles: a symbol, or an array that is read or that is the result."""
        f, wanted = self.source.functions[name], [(kind, v if isinstance(v, str) else "value") for kind, v in arguments.values()]
        need([(kind, how) for kind, _, how in f.params] == wanted, f"{name} of the C has other parameters than it should")
        scope: dict[str, Any] = {}
        for (_, label, _), (role, (kind, value)) in zip(f.params, arguments.items()):
            scope[label] = ["array", role, value == "result"] if isinstance(value, str) else [kind, value, True]
        self.result, self.stored, self.here = f.result, False, False
        if not self.block(f.body, scope):
            need(f.result == "void", f"{name} of the C ends without a result")
            self.effects.append(("return", None))

    def block(self, body: Tree, scope: dict[str, Any]) -> bool:
        """Runs statements; whether they returned."""
        for item in body:
            if isinstance(item, str):
                if self.statement(item, scope):
                    return True
                continue
            branch = re.fullmatch(r"if \( (\w+) \)", item[0])
            if branch is None:
                self.loop(item[0], item[1], scope)
            elif self.operand(branch[1], scope, "bool"):
                self.sure(self.block(item[1], dict(scope)), "a branch that goes on", item[0])
                return True
        return False

    def sure(self, holds: bool, what: str, where: str) -> None:
        if not holds:
            raise Failed(f"{self.where} of the C has {what}: {where[:80]}")

    def match(self, shapes: dict[str, re.Pattern[str]], text: str) -> tuple[str, tuple[str, ...]]:
        key = (shapes is self.shapes, text)
        if key in self.readings:
            return self.readings[key]  # type: ignore[no-any-return]
        for kind, shape in shapes.items():
            if found := shape.fullmatch(text):
                return self.readings.setdefault(key, (kind, found.groups()))  # type: ignore[no-any-return]
        raise Failed(f"{self.where} of the C has what is no statement of one operation: {text[:80]}")

    def statement(self, text: str, scope: dict[str, Any]) -> bool:
        kind, parts = self.match(self.shapes, text)
        if kind in ("declare", "let"):
            label, given = self.source.types[parts[0] if kind == "declare" else parts[1]], None
            name = parts[1] if kind == "declare" else parts[2]
            if kind == "let":
                given = self.typed(parts[3], scope, label)
            self.sure(name not in scope and label != "void" and LOCAL.fullmatch(name) is not None, "a name twice, or none", text)
            scope[name] = [label, given, kind == "let" and parts[0] is not None]
        elif kind == "set":
            held = scope.get(parts[0], ["", None, True])
            self.sure(held[2] is False and held[0] != "array", "a value set that cannot be", text)
            scope[parts[0]] = [held[0], self.typed(parts[1], scope, held[0]), False]
        elif kind == "store":
            value, held = self.typed(parts[2], scope, "real"), scope.get(parts[0], ["", None, False])
            at = self.operand(parts[1], scope, "int") == self.symbol("i")
            self.sure(held[0] == "array" and held[2] and at, "a store where none may be", text)
            self.effects.append(("store", held[1], value))
            self.stored = self.here = True
        elif kind == "return":
            value = None if parts[0] is None else self.typed(parts[0], scope, self.result)
            self.sure(value is not None or self.result == "void", "no result", text)
            self.effects.append(("return", value))
        else:
            self.sure(kind == "call" and self.call(parts[0], parts[1].split(" , "), scope)[0] == "void", "what has no use", text)
        return kind == "return"

    def loop(self, head: str, body: Tree, scope: dict[str, Any]) -> None:
        """The body once, for i; what it sets of the outside is a symbol in it and after it."""
        match = re.fullmatch(rf"for \( int32_t (\w+) = 0 ; \1 < {self.task.n} ; \+\+ \1 \)", head)
        self.sure(match is not None and all(isinstance(item, str) for item in body), "another loop than it should", head)
        inner = {name: list(entry) for name, entry in scope.items()}
        self.sure(match[1] not in inner and LOCAL.fullmatch(match[1]) is not None, "a name twice, or none", head)  # type: ignore[index]
        inner[match[1]] = ["int", self.symbol("i"), True]  # type: ignore[index]
        self.here = False
        changed = list(scope.keys() & {item.split(" = ")[0] for item in body if isinstance(item, str)})
        self.sure(len(changed) < 2, "two values carried through a loop", head)
        for name in changed:
            inner[name][1] = self.carry(scope[name][0])
        self.sure(not self.block(body, inner), "a return out of a loop", head)
        for name in changed:
            self.effects.append(("carried", scope[name][1], inner[name][1]))
            scope[name] = [scope[name][0], self.carry(scope[name][0]), False]

    def operand(self, text: str, scope: dict[str, Any], kind: str = "") -> Any:
        """The value of a name or a literal; with its type where none is asked for."""
        if text.endswith(" NAN"):
            found = ("real", self.symbol("nan"))
        elif text[0] in "(0123456789":
            if text not in self.readings:
                label, value = self.source.number(text.removeprefix("( ").removesuffix(" )"))
                self.readings[text] = (label, element(value))
            found = self.readings[text]
        elif text in ("true", "false"):
            found = ("bool", text == "true")
        elif text.startswith(f"{self.source.p.upper()}_"):
            found = ("status", text)  # type: ignore[assignment]
        else:
            label, value, _ = scope.get(text, ["array", None, True])
            self.sure(label != "array" and value is not None, "a name without a value", text)
            found = (label, value)
        self.sure(kind in ("", found[0]), f"a {found[0]} where a {kind} is needed", text)
        return found[1] if kind else found

    def typed(self, text: str, scope: dict[str, Any], kind: str) -> Any:
        found = self.value(text, scope)
        self.sure(found[0] == kind, f"a {found[0]} where a {kind} is needed", text)
        return found[1]

    def value(self, text: str, scope: dict[str, Any]) -> Value:
        """An expression of one operation."""
        kind, parts = self.match(self.formulas, text)
        if kind == "call":
            return self.call(parts[0], parts[1].split(" , "), scope)
        if kind == "load":
            return "real", self.load(parts[0], self.operand(parts[1], scope, "int"), scope)
        if kind == "finite":
            return "bool", self.ask("finite", self.operand(parts[0], scope, "real"))
        if kind == "pick":
            condition, then, other = self.operand(parts[0], scope, "bool"), *(self.operand(v, scope) for v in parts[1:])
            self.sure(then[0] == other[0], "a choice between two types", text)
            return then if condition else other  # type: ignore[no-any-return]
        if kind == "cast":
            to, (label, value) = self.source.types[parts[0]], self.operand(parts[1], scope)
            sign = {("int", "real"): "truncated", ("real", "int"): "real", ("int", "uint"): "int"}.get((to, label), "no cast")
            self.sure(operation(f"int {sign}", value, 0) in self.allowed, "another cast", text)
            return to, self.integer(sign, value, 0)
        if kind == "one" and parts[0] == "!":
            return "bool", not self.operand(parts[1], scope, "bool")
        if kind == "one":
            return "real", -self.operand(parts[1], scope, "real") % PRIME
        if kind == "is":
            return self.operand(parts[0], scope)  # type: ignore[no-any-return]
        (label, a), (other, b), sign = self.operand(parts[0], scope), self.operand(parts[2], scope), parts[1]
        fits = label == other and (label == "bool") == (sign == "&&") and (label in ("real", "int", "bool") or sign == "<")
        self.sure(fits and label != "status", "an operation on these types", text)
        if label == "bool":
            return "bool", a and b
        if sign in ("<", "<="):
            self.sure((sign, a, b) in self.allowed, "a comparison that is not the law's", text)
            return "bool", self.ask(sign, (b - a) % PRIME)
        spline = label == "real" and self.kernel in ("basis", "basis_rate", "blend")
        known = operation(sign if label == "real" else f"int {sign}", a, b)
        self.sure(spline or known in self.allowed, "an operation that is not the law's", text)
        return label, self.calculate(sign, a, b) if label == "real" else self.integer(sign, a, b)

    def load(self, array: str, index: int, scope: dict[str, Any]) -> int:
        table = array.removeprefix(f"{self.source.p}_")
        if array in scope:
            again = scope[array][2] and self.task.scales and self.stored and not self.here  # u, that a loop before has stored
            good = scope[array][0] == "array" and index == self.symbol("i") and (again or not (self.stored or scope[array][2]))
            table = scope[array][1]
        elif table == "coefficients":
            good = array != table and index in self.places
        else:
            good = array != table and len(self.source.tables.get(table, [])) == self.task.n and index == self.symbol("i")
        self.sure(good, "a number read where none may be", array)
        return self.symbol(f"load {table}", index)

    def call(self, name: str, arguments: list[str], scope: dict[str, Any]) -> Value:
        """A kernel, inlined; those of the segment are compared by themselves and give row and s."""
        values = [self.operand(a, scope) for a in arguments if a[0] != "&"]
        targets = [a[2:] for a in arguments if a[0] == "&"]
        library = name == ("logf" if self.source.single else "log")
        if not library:  # then it is the file's own
            self.sure(name.startswith(f"{self.source.p}_") and name not in scope, "a call of what is not known", name)
            name = name.removeprefix(f"{self.source.p}_")
        if library or (self.task.inline and name in ("exponent", "mantissa")):
            self.sure([t for t, _ in values] == ["real"] and not targets, "a call with other arguments", name)
            return ("int" if name == "exponent" else "real"), self.symbol(name.rstrip("f"), values[0][1])
        self.sure(self.kernel == "", "a call out of a kernel", name)
        f = self.source.functions.get(name) if name in KERNELS else None
        if f is None:
            raise Failed(f"{self.where} of the C calls {name}, which is not known")
        wanted = [kind for kind, _, how in f.params if how == "value"]
        self.sure(wanted == [t for t, _ in values] and len(targets) == len(set(targets)), "a call with other arguments", name)
        if name.startswith("segment"):
            self.sure(
                values[0][1] == self.symbol("tick" if name == "segment_at_tick" else "t"), "the segment of another time", name
            )
            results: list[Value] = [("int", self.symbol("row")), ("real", self.symbol("s"))]
        else:
            results = self.inlined(name, [v for _, v in values])
        if f.result != "void":
            self.sure(not targets, "a call with other results", name)
            return results[0]
        self.sure(len(targets) == len(results), "a call with other results", name)
        for target, (kind, value) in zip(targets, results):
            self.sure(scope.get(target) == [kind, None, False], "no place for a result", target)
            scope[target] = [kind, value, False]
        return "void", None

    def inlined(self, name: str, values: list[int]) -> list[Value]:
        """The outputs of a kernel; an edge of the tube, where it is one, by its symbol."""
        f, outer, found = self.source.functions[name], self.kernel, {}
        self.kernel = name
        outs = {label: kind for kind, label, how in f.params if how == "out"}
        inputs = [(kind, label) for kind, label, how in f.params if how == "value"]
        order = ["value"] * len(inputs) + ["out"] * len(outs)
        self.sure([how for *_, how in f.params] == order, "other parameters than it should", name)
        scope: dict[str, Any] = {label: [kind, value, True] for (kind, label), value in zip(inputs, values)}
        for text in f.body:
            kind, parts = self.match(self.shapes, text) if isinstance(text, str) else ("", ())
            label = parts[0] if kind == "out" else "return"
            if kind in ("out", "return"):
                self.sure("return" not in found and label not in found, "a result twice", text)
                found[label] = (outs.get(label, f.result), self.typed(parts[-1] or "", scope, outs.get(label, f.result)))
            else:
                self.sure(
                    kind == "let" and "return" not in found and not self.statement(text, scope),
                    "no statement of a kernel",
                    str(text),
                )
        wanted = ["return"] if f.result != "void" else list(outs)
        self.sure(set(found) == set(wanted) and bool(outs) == (f.result == "void"), "a kernel without its results", name)
        self.kernel = outer
        results = [found[label] for label in wanted]
        return [(kind, self.edges.get(value, value)) for kind, value in results] if name == "blend" else results


# ------------------------------------------------------------------------------------------------ what the C must do


class Specification:
    """What every function of the C must do, in the same operations on the same symbols."""

    def __init__(
        self, machine: Machine, gain: list[Fraction], wide: bool, filtered: list[Fraction], starts: dict[str, list[Fraction]]
    ) -> None:
        self.starts = starts
        self.m, self.task, self.bits, self.guarded = machine, machine.task, machine.source.bits, not wide
        self.k, self.n, self.i = machine.segments, machine.task.n, machine.symbol("i")
        shares = [(1 - v) / 2 for v in self.task.e_max]
        known = {"gain": gain, "e_max": self.task.e_max, "least_share": shares, **({"filter": filtered} if filtered else {})}
        self.constants = {name: [rounded(v, self.bits) for v in values] for name, values in known.items()}

    def tables(self) -> dict[str, list[Fraction]]:
        """What differs by component stands in a table."""
        found = {name: values for name, values in self.constants.items() if len(set(values)) > 1}
        limits = [rounded(v, self.bits, math.floor) for v in self.task.u_max or []]
        return found | self.starts | ({"u_max": limits} if limits and not self.task.scales else {})

    def each(self, name: str) -> int:
        values = self.constants[name]
        return self.m.symbol(f"load {name}", self.i) if len(set(values)) > 1 else element(values[0])

    def constant(self, value: Fraction) -> int:
        return element(rounded(value, self.bits))

    # ---- time

    def segment(self) -> None:
        """Spline time K t / t_c, held from 0 to the last number below K: the table's row and the place in the segment."""
        m, t = self.m, self.m.symbol("t")
        end = element(rounded(self.k - Fraction(self.k, 2 ** (self.bits + 2)), self.bits, math.floor))
        scaled = m.op("*", t if m.less(0, t) else 0, self.constant(self.k / self.task.t_c))
        u = scaled if m.less(scaled, end) else end
        whole = m.whole("truncated", u)
        m.effects.append([("int", m.whole("*", whole, 2 * self.n)), ("real", m.op("-", u, m.whole("real", whole)))])

    def segment_at_tick(self) -> None:
        """The same for a count of ticks, num/den of a segment each, in integers."""
        assert self.task.tick is not None
        m, tick, k = self.m, self.m.symbol("tick"), self.k
        num, den = (self.task.tick * k / self.task.t_c).as_integer_ratio()
        last = -(-k * den // num)
        need(k * den + num < 1 << 31, "the ticks of the C do not fit 31 bits")
        passed = m.whole("*", m.whole("int", tick if m.less(tick, last) else last), num)
        place = passed if m.less(passed, k * den) else k * den
        whole = m.whole("/", place, den)
        segment = whole if m.less(whole, k - 1) else k - 1
        rest = m.whole("real", m.whole("-", place, m.whole("*", segment, den)))
        m.effects.append([("int", m.whole("*", segment, 2 * self.n)), ("real", m.op("/", rest, self.constant(Fraction(den))))])

    # ---- the law

    def between(self, lower: int, upper: int, x: int) -> tuple[int, int, int]:
        """How far two edges are apart, and the distances to both."""
        m = self.m
        return m.op("-", upper, lower), m.op("-", x, lower), m.op("-", upper, x)

    def apart(self) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
        """The same of x between the edges; and of what is held: for order 2 v + lambda x in the filtered tube."""
        m, k = self.m, self.constant(self.k / self.task.t_c)
        own = self.between(m.symbol("L"), m.symbol("U"), m.symbol("load x", self.i))
        if self.task.order == 1:
            return own, own
        low, high = m.op("*", m.symbol("L'"), k), m.op("*", m.symbol("U'"), k)
        rates = self.between(low, high, m.symbol("load v", self.i))
        room, to_lower, to_upper = (m.op("+", v, m.op("*", x, self.each("filter"))) for v, x in zip(rates, own))
        return own, (room, to_lower, to_upper)

    def place(self, room: int, to_lower: int, to_upper: int, guarded: bool) -> tuple[int, int, int, int, int]:
        """Distance to the nearer edge, both distances clamped, width, room; notes which edge is nearer, whether there is room.
        A width below LEAST_WIDTH counts as that, about the middle."""
        m = self.m
        self.filled = not guarded or m.less(0, room)
        width = room if not guarded or m.less(element(LEAST_WIDTH), room) else element(LEAST_WIDTH)
        self.upper_nearer = m.less(to_upper, to_lower)
        nearest = to_upper if self.upper_nearer else to_lower
        least, distance = m.op("*", width, self.each("least_share")), nearest
        if guarded:
            distance = m.op("+", nearest, m.op("*", m.op("-", width, room), element(Fraction(1, 2))))
        farther = m.less(least, distance)
        near = distance if self.filled and farther else least
        return nearest, near, m.op("-", width, near), width, room

    def transformed(self, near: int, far: int) -> tuple[int, int]:
        """epsilon and xi of (13), from the nearer edge: -ln(far/near) and 1/near + 1/far."""
        m, y = self.m, self.m.op("/", far, near)
        return -self.log(y) % PRIME, m.op("/", m.op("+", 1, y), far)

    def log(self, y: int) -> int:
        """The library's; or with y = m 2^e: e ln 2 + 2 atanh((m - 1)/(m + 1)), see docs/certificate-format.md."""
        m = self.m
        if not self.task.inline:
            return m.symbol("log", y)
        mantissa = m.symbol("mantissa", y)
        s = m.op("/", m.op("-", mantissa, 1), m.op("+", mantissa, 1))
        bent = m.op("*", m.op("*", s, s), element(rounded(Fraction("0.67660441"), 24)))
        whole = m.op("*", m.whole("real", m.symbol("exponent", y)), self.constant(Fraction("0.693147180559945309417232121458")))
        return m.op("+", whole, m.op("*", s, m.op("+", bent, 2)))

    def held(self, value: int, low: int, high: int) -> int:
        raised = value if self.m.less(low, value) else low
        return high if self.m.less(high, raised) else raised

    # ---- the functions

    def bad(self, time: bool, stores: Sequence[str], status: Any) -> bool:
        """With a NaN or an infinity among t and the state: zeros, and the status."""
        m = self.m
        total = m.op("*", m.symbol("t"), 0) if time else 0
        for name in ("x", "v")[: self.task.order]:
            m.effects.append(("carried", total, m.op("+", m.carry("real"), m.op("*", m.symbol(f"load {name}", self.i), 0))))
            total = m.carry("real")
        if m.less(total, 0, "<="):
            return False
        m.effects += [*(("store", name, 0) for name in stores), ("return", status)]
        return True

    def control(self, time: bool) -> None:
        m, (ok, outside, bad) = self.m, [f"{self.task.name.upper()}_{name}" for name in ("OK", "OUTSIDE_TUBE", "BAD_INPUT")]
        if self.bad(time, ["u"], bad):
            return
        was = m.carry("bool")
        own, held = self.apart()
        nearest, near, far, _, _ = self.place(*held, self.guarded)
        inside = [m.less(0, v) for v in (nearest, *(own[1:] if self.task.order == 2 else ()))]
        epsilon, xi = self.transformed(near, far)
        gain = -self.each("gain") % PRIME if self.upper_nearer else self.each("gain")
        push = -m.op("*", m.op("*", gain, xi), epsilon) % PRIME
        u = push if self.filled else 0
        if self.task.u_max is not None and not self.task.scales:
            limit = m.symbol("load u_max", self.i)
            u = self.held(u, -limit % PRIME, limit)
        m.effects += [("store", "u", u), ("carried", False, was if all(inside) else True)]
        left = m.carry("bool")
        if self.task.u_max is not None and self.task.scales:
            self.scaled(element(rounded(self.task.u_max[0], self.bits, math.floor)))
        m.effects.append(("return", outside if left else ok))

    def scaled(self, most: int) -> None:
        """u, as it is stored, times the factor that brings the largest within the limit."""
        m, before, u = self.m, self.m.carry("real"), self.m.symbol("load u", self.i)
        size = -u % PRIME if m.less(u, 0) else u
        m.effects.append(("carried", 0, size if m.less(before, size) else before))
        largest = m.carry("real")
        factor = m.op("/", most, largest if m.less(most, largest) else most)
        m.effects.append(("store", "u", self.held(m.op("*", u, factor), -most % PRIME, most)))

    def margin(self) -> None:
        m = self.m
        if self.bad(True, [], m.symbol("nan")):
            return
        before, share = m.carry("real"), self.share()
        m.effects.append(("carried", element(Fraction(1, 2)), share if m.less(share, before) else before))
        m.effects.append(("return", m.carry("real")))

    def share(self) -> int:
        """The margin of component i: of what is held, and for order 2 of x where that is less."""
        m, shares = self.m, list[int]()
        own, held = self.apart()
        for apart in (held, own)[: self.task.order]:
            nearest, _, _, width, _ = self.place(*apart, self.guarded)
            share = m.op("/", nearest, width)
            shares.append(-1 % PRIME if m.less(share, -1) else share)
        return shares[0] if len(shares) == 1 or m.less(shares[0], shares[1]) else shares[1]

    def margins(self) -> None:
        finite = self.m.ask("finite", self.m.symbol("t"))
        self.m.effects += [("store", "margin", self.share() if finite else self.m.symbol("nan")), ("return", None)]

    def covered(self) -> None:
        """Whether x, and for order 2 v + lambda x, is strictly between the bounds of starts, in every component."""
        m = self.m
        values = [m.symbol("load x", self.i)]
        if self.task.order == 2:
            values.append(m.op("+", m.symbol("load v", self.i), m.op("*", values[0], self.each("filter"))))
        bounds = [m.symbol(f"load {name}", self.i) for name in STARTS]
        pairs = [pair for k, value in enumerate(values) for pair in ((bounds[2 * k], value), (value, bounds[2 * k + 1]))]
        answers, was = [m.less(a, b) for a, b in pairs], m.carry("bool")
        inside = all(answers)
        m.effects += [("carried", True, was if inside else False), ("return", m.carry("bool"))]

    def tube(self) -> None:
        self.of_time(["lower", "upper"], [self.m.symbol("L"), self.m.symbol("U")])

    def filtered_tube(self) -> None:
        m, k = self.m, self.constant(self.k / self.task.t_c)
        pairs = ((m.op("*", m.symbol(f"{side}'"), k), m.op("*", m.symbol(side), self.each("filter"))) for side in "LU")
        self.of_time(["lower", "upper"], [m.op("+", *pair) for pair in pairs])

    def velocity(self) -> None:
        m = self.m
        positive = m.less(0, m.symbol("dt"))
        moved = m.op("-", *(m.symbol(f"load {name}", self.i) for name in ("x", "x_before")))
        mean = m.op("/", moved, m.symbol("dt") if positive else 1)
        m.effects += [("store", "v", mean if positive else m.symbol("nan")), ("return", None)]

    def tube_rate(self) -> None:
        m = self.m
        moving = m.less(m.symbol("t"), self.constant(self.task.t_c))
        per_second = self.constant(self.k / self.task.t_c) if moving else 0
        self.of_time(["lower_rate", "upper_rate"], [m.op("*", m.symbol(name), per_second) for name in ("L'", "U'")])

    def of_time(self, names: list[str], values: list[int]) -> None:
        finite = self.m.ask("finite", self.m.symbol("t"))
        self.m.effects += [("store", name, value if finite else self.m.symbol("nan")) for name, value in zip(names, values)]
        self.m.effects.append(("return", None))

    def transform(self) -> None:
        m = self.m
        lower, upper, x = (m.symbol(f"load {name}", self.i) for name in ("lower", "upper", "x"))
        _, near, far, width, room = self.place(*self.between(lower, upper, x), True)
        a, b, sign = (far, near, -1 % PRIME) if self.upper_nearer else (near, far, 1)
        e_max = self.each("e_max")
        e = self.held(m.op("/", m.op("-", a, b), width), -e_max % PRIME, e_max)
        size, xi = self.transformed(near, far)
        finite = all([m.ask("finite", x), m.ask("finite", room)])
        for name, value in (("e", e), ("epsilon", m.op("*", sign, size)), ("xi", xi)):
            m.effects.append(("store", name, (value if self.filled else 0) if finite else m.symbol("nan")))
        m.effects.append(("return", None))


def computes(
    source: Source, task: Task, gain: list[Fraction], wide: bool, filtered: list[Fraction], starts: dict[str, list[Fraction]]
) -> None:
    """That the C computes the tube of its table and the law of the task. wide: the edges are always farther apart than
    LEAST_WIDTH, so `control` and `margin` may do without a guard against narrower tubes. starts: the tables of `covered`."""
    m, ticks = Machine(source, task), task.tick is not None
    spec, free = (Specification(m, gain, guard, filtered, starts) for guard in (False, wide))
    kernels = [k for k in KERNELS if ticks or k != "segment_at_tick"]
    second = ["filtered_tube"] if task.order == 2 else []
    velocity = ["velocity"] if task.apart is not None else []
    public = [
        "tube",
        "tube_rate",
        *second,
        *velocity,
        "control",
        *(["control_tick"] if ticks else []),
        "margin",
        "margins",
        "covered",
    ]
    public.append("transform")
    need(list(source.functions) == kernels + public, "the C has other functions than it should")
    need({k: v for k, v in source.tables.items() if k != "coefficients"} == spec.tables(), "a table of the C is not the task's")
    t, tick, x, out = ("real", m.symbol("t")), ("uint", m.symbol("tick")), ("real", "array"), ("real", "result")
    for name, time, place in (("segment", t, spec.segment), ("segment_at_tick", tick, spec.segment_at_tick))[: 1 + ticks]:
        kinds = [kind for kind, _, how in source.functions[name].params if how == "value"]
        need(kinds == [time[0]], f"{name} of the C has other parameters than it should")
        m.explore(name, place, partial(lambda name, value: m.effects.append(m.inlined(name, [value])), name, time[1]))
    state: dict[str, Value] = dict.fromkeys(("x", "v")[: task.order], x)
    functions: list[tuple[str, list[Callable[[], None]], dict[str, Value]]] = [
        ("tube", [spec.tube], {"t": t, "lower": out, "upper": out}),
        ("tube_rate", [spec.tube_rate], {"t": t, "lower_rate": out, "upper_rate": out}),
        ("transform", [spec.transform], {"lower": x, "upper": x, "x": x, "e": out, "epsilon": out, "xi": out}),
        ("margin", [free.margin, spec.margin][: 1 + wide], {"t": t, **state}),
        ("margins", [free.margins, spec.margins][: 1 + wide], {"t": t, **state, "margin": out}),
        ("covered", [spec.covered], dict(state)),
    ]
    functions += [("filtered_tube", [spec.filtered_tube], {"t": t, "lower": out, "upper": out}) for _ in second]
    apart: dict[str, Value] = {"dt": ("real", m.symbol("dt")), "x": x, "x_before": x, "v": out}
    functions += [(name, [spec.velocity], apart) for name in velocity]
    for name, time in (("control", t), ("control_tick", tick))[: 1 + ticks]:
        functions.append(
            (name, [partial(s.control, name == "control") for s in (free, spec)[: 1 + wide]], {"t": time, **state, "u": out})
        )
    for name, allowed, arguments in functions:
        failures = []
        for specification in allowed:
            try:
                m.explore(name, specification, partial(m.run, name, arguments))
            except Failed as failure:
                failures.append(failure)
        if len(failures) == len(allowed):
            raise failures[0]


# ------------------------------------------------------------------------------------------------ the tube and its arithmetic

Edge = list[Any]  # Bezier coefficients of one cubic piece, in units of the table
Piece = list[tuple[Edge, Edge]]  # by dimension: lower and upper edge


class Tube:
    """The tube of the C's table, in whole units of it: control points over 6."""

    def __init__(self, source: Source, task: Task, bits: int, seam: int | None = None) -> None:
        values = source.tables.get("coefficients", [])
        rows, rest = divmod(len(values), 2 * task.n)
        need(rows > 3 and not rest, f"the table has {len(values)} entries, no multiple of {2 * task.n}, or too few")
        self.n, self.segments, self.unit, self.t_c = task.n, rows - 3, Fraction(2) ** -bits, task.t_c
        whole = values if isinstance(source, Integers) else [v / self.unit for v in values]
        need(all(v.denominator == 1 for v in whole), "the table is not of whole units of 2^-unit_bits")
        self.table = [
            [(int(whole[j + 2 * i]), int(whole[j + 2 * i + 1])) for i in range(task.n)] for j in range(0, len(whole), 2 * task.n)
        ]
        self.seam, self.cycle = seam, Fraction(0)
        if seam is not None:
            need(0 <= seam < self.segments, "what is repeated begins with no segment")
            self.cycle = task.t_c * (self.segments - seam) / self.segments
            need(not task.tick or (self.cycle / task.tick).denominator == 1, "a cycle is no whole number of ticks")
        self.pieces: list[Piece] = []
        for k in range(self.segments):
            q = [[[self.table[k + j][i][side] for j in range(4)] for side in (0, 1)] for i in range(task.n)]
            edges = [[[a + 4 * b + c, 4 * b + 2 * c, 2 * b + 4 * c, b + 4 * c + d] for a, b, c, d in e] for e in q]
            self.pieces.append([(low, high) for low, high in edges])

    def fastest(self, i: int, order: int = 1) -> int:
        """The largest coefficient of an edge's derivative of that order in dimension i, with a segment's time as unit."""
        edges = [edge for piece in self.pieces for edge in piece[i]]
        for _ in range(order):
            edges = [[(len(c) - 1) * (b - a) for a, b in zip(c, c[1:])] for c in edges]
        return max(int(abs(v)) for edge in edges for v in edge)


def arithmetic(source: Source, tube: Tube, order: int = 0) -> list[Fraction]:
    """P7, by dimension: how far the emitted edge, of order 1 its rate, is from the tube's. Spline time is within K (2 eps +
    eps^2) of the true one; twice that is allowed, so that t may have been rounded. Then the statements of basis and blend, one
    rounding each; of a rate also the product with K/t_c, which is rounded too."""
    if isinstance(source, Integers):
        return source.moved(tube, order)
    eps, tiny = Fraction(1, 1 << source.bits), Fraction(2) ** (-150 if source.single else -1075)
    late, found = tube.segments * 4 * eps * (1 + eps) + tiny, []
    for _, _, wrong in _errors(source, "basis_rate", [(Fraction(0), Fraction(1), Fraction(0))], eps, tiny):
        need(wrong < 128 * eps, "the statements of basis_rate lose more than rounding may take")
    for i in range(tube.n):
        largest = max(abs(v) for row in tube.table for v in row[i]) * tube.unit
        weights = _errors(source, ("basis", "basis_rate")[order], [(Fraction(0), Fraction(1), Fraction(0))], eps, tiny)
        (edge,) = _errors(source, "blend", [*weights, *[(-largest, largest, Fraction(0))] * 4], eps, tiny)
        wrong = edge[2] + late * tube.fastest(i, order + 1) * tube.unit
        if order == 1:
            per_second = tube.segments / tube.t_c
            wrong = (wrong * (1 + eps) + (tube.fastest(i) * tube.unit + wrong) * 2 * eps) * per_second + tiny
        found.append(wrong)
    return found


Inexact = tuple[Fraction, Fraction, Fraction]  # least, largest, error


def _errors(source: Source, name: str, inputs: list[Inexact], eps: Fraction, tiny: Fraction) -> list[Inexact]:
    """Ranges and errors of a kernel's results, from its statements."""
    f = source.functions[name]
    results: dict[str, Inexact] = {}
    known = dict(zip((label for _, label, how in f.params if how == "value"), inputs))

    def get(text: str) -> Inexact:
        return known[text] if text in known else (source.number(text)[1], source.number(text)[1], Fraction(0))

    for text in f.body:
        left, _, right = text.removeprefix("return ").rpartition(" = ")
        words, target = right.split(), left.split()[-1] if left else "return"
        if len(words) == 1:
            (results if left in ("", f"* {target}") else known)[target] = get(words[0])
            continue
        if len(words) == 2 and words[0] == "-":
            low, high, error = get(words[1])
            known[target] = (-high, -low, error)
            continue
        need(len(words) == 3 and words[1] in "+-*", f"the rounding of a statement of {name} is not known: {text}")
        (a, b, d), (p, q, g), sign = get(words[0]), get(words[2]), words[1]
        low, high, error = (a + p, b + q, d + g) if sign == "+" else (a - q, b - p, d + g)
        if sign == "*":
            corners = [v * w for v in (a, b) for w in (p, q)]
            low, high = max(min(corners), Fraction(0)) if words[0] == words[2] else min(corners), max(corners)
            error = max(abs(a), abs(b)) * g + max(abs(p), abs(q)) * d + d * g
        size = max(abs(low), abs(high)) + error
        need(size < 1 / SMALL, f"a value of {name} may overflow")
        known[target] = (low, high, error + size * eps + tiny)
    return [results[label] for _, label, how in f.params if how == "out"] or [results["return"]]


# ------------------------------------------------------------------------------------------------ the C in integers

# What a controller in integers must be. It counts x in units of the table, u in units of 2^-U_BITS, time in ticks. Of these lines
# `<` gives a bool; `a over b` is the larger and `a under b` the lesser, in two statements; `p, q, r = size of a` are p = 0 < a,
# q = -a, r = p ? a : q; `each i` begins the loop over the components and `end` ends it; `?name` is a constant that is read from
# the C and that the proof below asks something of; `!` is C as it stands.
WEIGHTS = """s_up = up(s, 12); square = upper(s_up, s); cube = upper(square, s); sum = s_up + square; sum_3 = sum * 3;
cube_2 = cube * 2; bend = sum_3 - cube_2; less = s_up - square; less_held = less over 0; less_3 = less_held * 3;
left_square = 268435456 - less_3; left = left_square - cube; bend_held = bend over 0; bend_near_half = bend_held + 8192;
bend_near = down(bend_near_half, 14); left_held = left over 0; before_half = left_held + 4096; before = down(before_half, 13);
middle = bend_near under 65535; after_half = cube + 4096; after = down(after_half, 13);
!*w0 = before; !*w1 = middle; !*w2 = after"""
RATES = """s_up = up(s, 12); square = upper(s_up, s); less = s_up - square; less_held = less over 0;
less_most = less_held under 67108864; one_less = 268435456 - s_up; left = one_less - less_most; left_held = left over 0;
less_2 = less_most * 2; middle = 268435456 + less_2;
before_3 = left_held * 3; before_second = upper(before_3, ?mantissa); before_half = before_second + ?half;
before = down(before_half, ?down); between_3 = middle * 3; between_second = upper(between_3, ?mantissa);
between_half = between_second + ?half; between = down(between_half, ?down); after_3 = square * 3;
after_second = upper(after_3, ?mantissa); after_half = after_second + ?half; after = down(after_half, ?down);
!*r0 = before; !*r1 = between; !*r2 = after"""
EDGE = """at_q0 = coefficients[at]; at_1 = at + {a}; at_q1 = coefficients[at_1]; at_2 = at + {b}; at_q2 = coefficients[at_2];
at_3 = at + {c}; at_q3 = coefficients[at_3]; apart_0 = at_q1 - at_q0; apart_1 = at_q2 - at_q1; apart_2 = at_q3 - at_q2;
d0 = short apart_0; d1 = short apart_1; d2 = short apart_2; q1_6 = at_q1 * 6; base = q1_6 + d1; d1_w1 = product(d1, w1);
middle = down(d1_w1, 14); d2_w2 = product(d2, w2); d0_w0 = product(d0, w0); outer = d2_w2 - d0_w0; ends = down(outer, 15);
bent = base + middle; value = bent + ends"""
SLOPE = """; d1_r1 = product(d1, r1); between = down(d1_r1, ?places); d0_r0 = product(d0, r0); d2_r2 = product(d2, r2);
about = d0_r0 + d2_r2; around = down(about, ?places); slope = between + around; !*edge = value; !*rate = slope"""
CURVE = """level = levels[row]; slope = slopes[row]; bend = bends[row]; bend_t = product(bend, t); bent = down(bend_t, 16);
down = slope - bent; down_t = product(down, t); fall = down(down_t, 17); left = level - fall; found = low(left, 65535);
!return found"""
PUSH = """steep = upper(e, rise); over_width = upper(steep, over); size = upper(over_width, gain); moved = down(size, places);
push_held = moved under limit; !return push_held"""
FOUND = (  # of order 1 and 2
    "lower_edge = edge(at, {w}); upper_edge = edge(at_upper, {w})",
    "edge(at, {w}, &lower_edge, &lower_rate); edge(at_upper, {w}, &upper_edge, &upper_rate)",
)
NEAR = "{x}_all = {x}[i]; {x}_near = {x}_all over (-{far}); {x}_i = {x}_near under {far}"
HELD = NEAR + "; {x}_lower = {x}_i - lower_{of}; {x}_upper = upper_{of} - {x}_i"
WITHIN = """{start}_lower_i = {start}_lower[i]; {start}_upper_i = {start}_upper[i]; {x}_after = {start}_lower_i < {x};
{x}_before = {x} < {start}_upper_i; {x}_between = {x}_after && {x}_before"""
FILTERED = """filter_i = filters[i]; {more_l}lower_filtered = upper({l}, filter_i); to_lower = v_lower + lower_filtered;
{more_u}upper_filtered = upper({u}, filter_i); to_upper = v_upper + upper_filtered"""
OVER = """{n}_width = {room} over ?{narrow}; {n}_n = leading({n}_width); {n}_width_up = up({n}_width, {n}_n);
{n}_over_bits = down({n}_width_up, 26); {n}_over_head = low({n}_over_bits, 15); {n}_over_tail = down({n}_width_up, 10);
{n}_over_t = low({n}_over_tail, 65535); {n}_over = curve({n}_over_head, {n}_over_t)"""
PUSHED = """upper_nearer, minus, off = size of apart; off_held = off under e_width; off_up = up(off_held, e_n);
e_all = upper(off_up, e_over); e = e_all under ?top; rest = e_width_up - off_up; y_all = upper(rest, e_over);
y_near = y_all over ?lowest; y = y_near under 1073741823; m = leading(y); octaves = m * 8; octave = octaves + 8; y_up = up(y, m);
rise_bits = down(y_up, 27); rise_head = low(rise_bits, 7); rise_row = rise_head + octave; rise_tail = down(y_up, 11);
rise_t = low(rise_tail, 65535); rise = curve(rise_row, rise_t); rise_places = places[rise_row]; gain = gains[i];
offset = offsets[i]; limit = limits[i]; down_n = offset - e_n; down_all = down_n - rise_places; down = down_all over 0;
push = push(e, rise, e_over, gain, down, limit); back = -push; u_i = upper_nearer ? {turned}; !u[i] = u_i; within = off < room"""
SHARE = """{n}_room = {l} + {u}; {over}; {n}_high = {u} < {l}; {n}_nearest = {n}_high ? {u} : {l};
{n}_inside, {n}_beyond, {n}_size = size of {n}_nearest; {n}_held = {n}_size under {n}_width; {n}_up = up({n}_held, {n}_n);
{n}_quotient = upper({n}_up, {n}_over); {n}_part = down({n}_quotient, 14); {n}_most = {n}_part under 65535;
{n}_minus = (-1) - {n}_most; {n} = {n}_inside ? {n}_most : {n}_minus"""
# What integers are counted with: floor(a / 2^n); a 2^n for 0 <= a below 2^(31 - n); a b; floor(a b / 2^16) for 0 <= b < 2^16, of
# which a = 2^16 h + l gives h b and l b / 2^16; by how many places a > 0 moves up until it begins with a 1; a mod (mask + 1).
# The first half is for an AVR, where n of a constant is at most 31: (a >> 16) >> (n - 16), and for 12 < n < 16, of the same h
# and l, h 2^(16 - n) + floor(l / 2^n); shifts by the bits of n else.
COUNTED = """#if defined(__AVR__)
#include <avr/pgmspace.h>
#define M_FLASH PROGMEM
#define M_READ_8(entry) ((int32_t)pgm_read_byte(&(entry)))
#define M_READ_16(entry) ((int32_t)pgm_read_word(&(entry)))
#define M_READ_32(entry) ((int32_t)pgm_read_dword(&(entry)))
#else
#define M_FLASH
#define M_READ_8(entry) ((int32_t)(entry))
#define M_READ_16(entry) ((int32_t)(entry))
#define M_READ_32(entry) ((int32_t)(entry))
#endif
typedef char P_shifts_down[((-3) >> 1 == -2) ? 1 : -1];
#if defined(__AVR__)
static inline int32_t P_down(int32_t a, int32_t n) { int32_t rest = a;
    if (__builtin_constant_p(n) && (n >= 16)) { return (int16_t)(a >> 16) >> (n - 16); }
    if (__builtin_constant_p(n) && (n > 12)) { return ((a >> 16) * ((int32_t)1 << (16 - n))) + (int32_t)((uint16_t)a >> n); }
    if (((uint8_t)n & 16U) != 0U) { rest >>= 16; } if (((uint8_t)n & 8U) != 0U) { rest >>= 8; }
    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { rest >>= 1; } return rest; }
static inline int32_t P_up(int32_t a, int32_t n) { uint32_t rest = (uint32_t)a;
    if (((uint8_t)n & 16U) != 0U) { rest <<= 16; } if (((uint8_t)n & 8U) != 0U) { rest <<= 8; }
    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { rest <<= 1; } rest &= 0x7fffffffU; return (int32_t)rest; }
static inline int32_t P_product(int32_t a, int32_t b) { int16_t own = (int16_t)a; uint16_t other = (uint16_t)b;
    __asm__("" : "+r"(own), "+r"(other)); return (int32_t)own * (int32_t)other; }
static inline int32_t P_upper(int32_t a, int32_t b) { uint16_t own = (uint16_t)a; uint16_t other = (uint16_t)b;
    __asm__("" : "+r"(own), "+r"(other)); const uint32_t low = (uint32_t)own * other;
    return P_product(a >> 16, b) + (int32_t)(low >> 16); }
#else
static inline int32_t P_down(int32_t a, int32_t n) { return a >> n; }
static inline int32_t P_up(int32_t a, int32_t n) { const uint32_t moved = ((uint32_t)a << (uint32_t)n) & 0x7fffffffU;
    return (int32_t)moved; }
static inline int32_t P_product(int32_t a, int32_t b) { return a * b; }
static inline int32_t P_upper(int32_t a, int32_t b) { const uint32_t low = ((uint32_t)a & 0xffffU) * (uint32_t)b;
    return (P_down(a, 16) * b) + (int32_t)(low >> 16); }
#endif
static inline int32_t P_leading(int32_t a) { uint32_t rest = (uint32_t)a; int32_t places = 0;
    if (rest < 0x8000U) { rest <<= 16; places = 16; } if (rest < 0x800000U) { rest <<= 8; places += 8; }
    if (rest < 0x8000000U) { rest <<= 4; places += 4; } if (rest < 0x20000000U) { rest <<= 2; places += 2; }
    if (rest < 0x40000000U) { places += 1; } return places; }
static inline int32_t P_low(int32_t a, int32_t mask) { const uint32_t bits = (uint32_t)a & (uint32_t)mask; return (int32_t)bits; }
"""
HEAD = """#ifndef M_H
#define M_H
#include <stdbool.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {{
#endif
#define M_N {n}
#define M_X_BITS {x}
#define M_U_BITS {u}
#define M_X(v) M_UNITS(v, {x_scale})
#define M_U(v) M_UNITS(v, {u_scale})
#define M_UNITS(v, scale) ((int32_t)(((v) * (scale)) + (((v) < 0) ? -0.5 : 0.5)))
#define M_TICKS UINT32_C({last})
#define M_TICKS_A_SECOND {second}
{proved}#define M_SHARE {share}
#define M_DESIGN_HASH "{hash}"
typedef enum {{ M_OK = 0, M_OUTSIDE_TUBE = 1 }} P_status;
{heads}
#ifdef __cplusplus
}}
#endif
#endif"""
Step = tuple[str, str, tuple[str, ...]]  # name, operation, operands
STEPS = {
    "size": r"size of (\w+)", "most": r"(\S+) over (\S+)", "least": r"(\S+) under (\S+)", "pick": r"(\w+) \? (\S+) : (\S+)",
    "load": r"(\w+)\[(\w+)\]", "short": r"short (\w+)", "same": r"\(int32_t\)(\w+)", "neg": r"-(\w+)", "call": r"(\w+)\((.+)\)",
    "two": r"(\S+) ([-+*<]|&&) (\S+)",
}  # fmt: skip


SIGNS = ("+", "-", "*", "<", "&&")


def steps(text: str) -> list[Step]:
    """The statements of a listing: results, operation, operands. Of what is C as it stands the name is empty."""
    found: list[Step] = []
    for line in (part.strip() for part in text.replace("\n", " ").split(";")):
        name, _, right = line.rpartition(" = ")
        if line[0] == "!" or not name:
            found.append(("", line, ()))
            continue
        kind, match = next((k, m) for k, v in STEPS.items() if (m := re.fullmatch(v, right)))
        parts = match.groups()
        if kind == "call":
            kind, parts = parts[0], tuple(parts[1].split(", "))
        elif kind == "two":
            kind, parts = parts[1], (parts[0], parts[2])
        found.append((name, kind, parts))
    return found


def written(listing: list[Step], n: int, reads: dict[str, int]) -> Iterator[str]:
    """The C of a listing; `reads`: the bits of a table's entries."""
    for name, kind, parts in listing:
        if not name and kind[0] == "!":
            yield f"{kind[1:]};"
        elif not name and kind in ("each i", "end"):
            yield "}" if kind == "end" else f"for (int32_t i = 0; i < {n}; ++i) {{"
        elif not name:
            yield from (f"int32_t {v};" for v in re.findall(r"&(\w+)", kind))
            yield f"P_{kind};"
        elif kind in ("most", "least"):
            test, (a, b) = f"{name}_{'over' if kind == 'most' else 'under'}", parts
            yield f"const bool {test} = {f'{b} < {a}' if kind == 'most' else f'{a} < {b}'};"
            yield f"const int32_t {name} = {test} ? {a} : {b};"
        elif kind == "size":
            test, minus, size = name.split(", ")
            yield f"const bool {test} = 0 < {parts[0]}; const int32_t {minus} = -{parts[0]};"
            yield f"const int32_t {size} = {test} ? {parts[0]} : {minus};"
        else:
            truth = kind in ("<", "&&") or parts[-1] in ("true", "false")
            label = "uint32_t" if name == "held" else "bool" if truth else "int32_t"
            a, b, c = (*parts, "", "", "")[:3]
            own = {
                "pick": f"{a} ? {b} : {c}", "short": f"(int32_t)(int16_t){a}", "same": f"(int32_t){a}", "neg": f"-{a}",
                "load": f"M_READ_{reads[a]}(P_{a}[{b}])" if a in reads else f"{a}[{b}]",
            }  # fmt: skip
            called = f"{a} {kind} {b}" if kind in SIGNS else f"P_{kind}({', '.join(parts)})"
            yield f"const {label} {name} = {own.get(kind, called)};"


def listings(n: int, order: int, positive: bool, words: list[str]) -> list[tuple[str, str]]:
    """Heads and listings of all functions, in their order; `words` of the C say which of a few statements there are."""
    high, fine, more = ("passed_high" in words), ("fine" in words), ("lower_filtered_more" in words)
    moves, last = order == 2, "passed_both" if "passed_high" in words else "passed"
    w = "w0, w1, w2, r0, r1, r2" if moves else "w0, w1, w2"
    values, made = (", ".join(f"int32_t {mark}{v}" for v in w.split(", ")) for mark in ("", "*"))
    both = "; count_high = down(count, 16); passed_high = count_high * ?scale; passed_both = passed + passed_high"
    found = [("static inline void P_segment(uint32_t tick, int32_t *row, int32_t *s)", (
        "running = tick < ?lastU; held = running ? tick : ?lastU; count = (int32_t)held; count_low = low(count, 65535); "
        f"passed = upper(?scale, count_low){both if high else ''}"
        f"; place = {last} under ?end; segment = down(place, ?bits)" + ("; fine = down(place, ?fine)" if fine else "")
        + f"; share = low({'fine' if fine else 'place'}, 65535); first = segment * {2 * n}; !*row = first; !*s = share"
    ))]  # fmt: skip
    found.append((f"static inline void P_weights(int32_t s, {made.split(', int32_t *r')[0]})", WEIGHTS))
    if moves:
        found.append((f"static inline void P_rates(int32_t s, {made[made.index('int32_t *r') :]})", RATES))
    edge = EDGE.format(a=2 * n, b=4 * n, c=6 * n)
    if moves:
        found.append((f"static inline void P_edge(int32_t at, {values}, int32_t *edge, int32_t *rate)", edge + SLOPE))
    else:
        found.append((f"static inline int32_t P_edge(int32_t at, {values})", edge + "; !return value"))
    found.append(("static inline int32_t P_curve(int32_t row, int32_t t)", CURVE))
    names = ("e", "rise", "over", "gain", "places", "limit")
    found.append((f"static inline int32_t P_push({', '.join(f'int32_t {v}' for v in names)})", PUSH))
    begin = "segment(tick, &row, &s); weights(s, &w0, &w1, &w2)" + ("; rates(s, &r0, &r1, &r2)" if moves else "")
    edges = f"pair = i * 2; at = row + pair; at_upper = at + 1; {FOUND[moves].format(w=w)}"

    def times(a: str, b: str) -> str:
        """lambda times two values; where it has less than 16 bits behind the point, of the values moved up by so many."""
        up = [(f"{side}_filtered_more = {v} * ?more; " if more else "") for side, v in (("lower", a), ("upper", b))]
        a, b = ("lower_filtered_more", "upper_filtered_more") if more else (a, b)
        return FILTERED.format(more_l=up[0], more_u=up[1], l=a, u=b)

    place = f"{edges}; {HELD.format(x='x', of='edge', far=67108864 if moves else 268435456)}"
    if moves:
        place += f"; {HELD.format(x='v', of='rate', far=268435456)}; {times('x_lower', 'x_upper')}"
    low, high_ = ("to_lower", "to_upper") if moves else ("x_lower", "x_upper")
    state = "const int32_t x[M_N], " + ("const int32_t v[M_N], " if moves else "")
    sides = "uint32_t tick, int32_t lower[M_N], int32_t upper[M_N]"
    found.append((f"void P_tube({sides})", f"{begin}; each i; {edges}; !lower[i] = lower_edge; !upper[i] = upper_edge; end"))
    if moves:
        lower, _, upper = times("lower_edge", "upper_edge").partition("; to_lower = v_lower + lower_filtered;")
        upper = upper.removesuffix("; to_upper = v_upper + upper_filtered")
        factor, lower = lower.split("; ", 1)
        found.append((f"void P_filtered_tube({sides})", (
            f"{begin}; each i; {factor}; {edges}; {lower}; lower_z = lower_rate + lower_filtered; !lower[i] = lower_z; "
            f"{upper}; upper_z = upper_rate + upper_filtered; !upper[i] = upper_z; end"
        )))  # fmt: skip
    over = OVER.format(n="e", room="room", narrow="narrow")
    law = f"room = {low} + {high_}; apart = {low} - {high_}; {over}; {PUSHED}"
    law = law.format(turned="back : push" if positive else "push : back")
    inside = "; over = 0 < x_lower; under = 0 < x_upper; between = over && under; inside = within && between" if moves else ""
    found.append((f"P_status P_control(uint32_t tick, {state}int32_t u[M_N])", (
        f"{begin}; !bool outside = false; each i; {place}; {law}{inside}; "
        f"outside_any = {'inside' if moves else 'within'} ? outside : true; !outside = outside_any; end; "
        "!return outside ? M_OUTSIDE_TUBE : M_OK"
    )))  # fmt: skip
    parts = [("share", low, high_, "narrow"), *([("place", "x_lower", "x_upper", "narrow_x")] if moves else [])]
    shares = [SHARE.format(n=v, l=a, u=b, over=OVER.format(n=v, room=f"{v}_room", narrow=c)) for v, a, b, c in parts]
    least = "; filtered_less = share < place; lesser = filtered_less ? share : place" if moves else ""
    name = "lesser" if moves else "share"
    found.append((f"int32_t P_margin(uint32_t tick, {state.removesuffix(', ')})", (
        f"{begin}; !int32_t margin = 32768; each i; {place}; {'; '.join(shares)}{least}; less = {name} < margin; "
        f"margin_next = less ? {name} : margin; !margin = margin_next; end; !return margin"
    )))  # fmt: skip
    found.append((f"void P_margins(uint32_t tick, {state}int32_t margin[M_N])", (
        f"{begin}; each i; {place}; {'; '.join(shares)}{least}; !margin[i] = {name}; end"
    )))  # fmt: skip
    found.append((f"bool P_covered({state.removesuffix(', ')})", covered_listing(moves, more)))
    return found


def covered_listing(moves: bool, more: bool) -> str:
    """Whether x, and for order 2 v + lambda x, is strictly between the bounds of starts. more: lambda has less than 16 bits."""
    within, inside = WITHIN.format(x="x_i", start="start"), "x_i_between"
    if moves:
        numbers = "; ".join(NEAR.format(x=v, far=far) for v, far in (("x", 67108864), ("v", 268435456)))
        moved = "filtered_more = x_i * ?more; filtered = upper(filtered_more" if more else "filtered = upper(x_i"
        filtered, inside = WITHIN.format(x="z", start="filtered_start"), "inside"
        within = f"{numbers}; filter_i = filters[i]; {moved}, filter_i); z = v_i + filtered; {within}; {filtered}"
        within += "; inside = x_i_between && z_between"
    else:
        within = f"x_i = x[i]; {within}"
    end = "!covered = covered_next; end; !return covered"
    return f"!bool covered = true; each i; {within}; covered_next = {inside} ? covered : false; {end}"


Function1 = Callable[[Fraction], tuple[Fraction, Fraction]]  # from below and above
Span = tuple[int, int]  # all whole numbers from one to the other
INT32, INT16, HALF = (-(1 << 31), (1 << 31) - 1), (-(1 << 15), (1 << 15) - 1), (0, (1 << 16) - 1)
EXACT: dict[str, Callable[..., int]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "neg": operator.neg, "down": operator.rshift, "up": operator.lshift,
    "upper": lambda a, b: a * b >> 16, "product": operator.mul, "low": operator.and_, "most": max, "least": min,
    "same": int, "short": int,
}  # fmt: skip


ROOMS = {  # of what an operation is for, where that is not all 32 bits
    "down": [INT32, (0, 31)], "up": [(0, INT32[1]), (0, 31)], "upper": [INT32, HALF], "product": [INT16, HALF],
    "short": [INT16], "leading": [(1, INT32[1])],
}  # fmt: skip


def inside(span: Span, room: Span) -> bool:
    return room[0] <= span[0] <= span[1] <= room[1]


class Integers(Source):
    """The C and the header of a controller in integers: tables, constants, and that all else is the listing's."""

    def __init__(self, data: bytes, task: Task) -> None:
        p = self.p = task.name
        self.single, self.bits, self.scalar, self.functions = False, 20, "fixed", {}  # of u_max and of a state 20 bits are known
        self.reads = dict[str, int]()
        foreign = task.inline or task.scales or task.outside != "return" or task.repeats or task.apart is not None
        need(not foreign and len({*task.e_max}) == 1, "the task asks for what no controller in integers has")
        need(task.tick is not None and task.u_max is not None, "the task has no tick_period or no u_max, which integers need")
        assert task.tick is not None
        need(
            task.period is None or (task.period / task.tick).denominator == 1, "the task's period is no whole number of its ticks"
        )
        self.names = ["coefficients", *(["filters"] if task.order == 2 else []), "levels", "slopes", "bends", "places"]
        self.names += ["gains", "offsets", "limits", *STARTS[: 2 * task.order]]
        words = tokens(data)
        own = tokens(self.named(f'#include "{p}.h"\n#include <stdbool.h>\n' + COUNTED))
        different = next((f"{a} where {b} is expected" for a, b in zip([*words, "the end"], own) if a != b), "")
        need(not different, f"the C has {different}")
        self.tables, at = {}, len(own)
        for name in self.names:
            at = self.entries(name, words, at)
        self.holes: dict[str, int] = {}
        self.listings: dict[str, list[Step]] = {}
        self.params: dict[str, list[str]] = {}
        self.heads, wanted = list[str](), list[str]()
        positive = task.gain is None or task.gain[0] > 0
        for head, text in listings(task.n, task.order, positive, words):
            name = re.findall(r"P_(\w+)\(", head)[0]
            self.listings[name], self.params[name] = steps(text), re.findall(r"int32_t (\w+)[,)]", head)
            spelled = " ".join(written(self.listings[name], task.n, self.reads))
            external = {f"{p}_{w}" for w in [*self.names, *re.findall(r"\bP_(\w+)", f"{COUNTED} {head} {spelled}")]}
            hidden = external & {*re.findall(r"\??\w+", f"{head} {spelled}")}
            need(not hidden or p == "P", f"the C has the local {min(hidden, default='')}, which hides what has the same name")
            wanted += tokens(self.named(re.sub(r"\?(?=\w)", "__", f"{head} {{ {spelled} }}")))
            self.heads += [] if head.startswith("static") else [f"{head};"]
        for a, b in zip([*words[at:], "the end"], [*wanted, "the end"]):
            good = self.hole(b[2:], a) if b.startswith("__") else a == b
            need(good, f"the C has {a[:60]} where {b.replace('__', 'the constant ')} is expected")
        self.listings = {
            name: [(v, kind, tuple(str(self.holes[a[1:]]) if a[0] == "?" else a for a in parts)) for v, kind, parts in body]
            for name, body in self.listings.items()
        }
        self.seen: dict[Any, list[Span]] = {}

    def named(self, text: str) -> bytes:
        return re.sub(r"\bM_", f"{self.p.upper()}_", re.sub(r"\bP_", f"{self.p}_", text)).encode()

    def hole(self, name: str, token: str) -> bool:
        """A constant of the C: the same wherever it stands."""
        found = re.fullmatch(r"(0|[1-9]\d{0,9})" + ("U" if name.endswith("U") else ""), token)
        return found is not None and int(found[1]) < 1 << 31 and self.holes.setdefault(name, int(found[1])) == int(found[1])

    def entries(self, name: str, words: list[str], at: int) -> int:
        """A table, from a token on; the place behind it."""
        end = next((k for k in range(at, len(words)) if words[k] == "}"), len(words))
        head, text = " ".join(words[at : at + 10]), " ".join(words[at + 10 : end])
        shape = rf"static const (uint8_t|uint16_t|int32_t) {self.p}_{name} \[ ([1-9]\d*) \] {self.p.upper()}_FLASH = {{"
        match = re.fullmatch(shape, head)
        whole = re.fullmatch(r"(- )?(0|[1-9]\d{0,9})( , (- )?(0|[1-9]\d{0,9}))*", text) is not None
        need(match is not None and whole and words[end + 1 : end + 2] == [";"], f"the C has no table {name} where it should")
        values = [int(v.replace(" ", "")) for v in text.split(" , ")]
        self.reads[name] = {"uint8_t": 8, "uint16_t": 16, "int32_t": 32}[match[1]]  # type: ignore[index]
        room = INT32 if self.reads[name] == 32 else (0, (1 << self.reads[name]) - 1)
        need(len(values) == int(match[2]) and inside((min(values), max(values)), room), f"the table {name} is of another size")  # type: ignore[index]
        self.tables[name] = [Fraction(v) for v in values]
        return end + 2

    def header(self, text: bytes, task: Task, tube: Tube, hash_: str, phased: bool) -> None:
        """The header: nothing but its units, constants and prototypes."""
        assert task.tick is not None
        bits = {"x_scale": self.x_bits, "u_scale": self.u_bits}
        scales = {name: f"{2**v}.0" if v >= 0 else f"(1.0 / {2**-v}.0)" for name, v in bits.items()}
        whole = {name[0]: f"({v})" if v < 0 else v for name, v in bits.items()}
        a, b = (1 / task.tick).as_integer_ratio()
        proved = "" if task.period is None else f"#define M_TICKS_PROVED UINT32_C({task.period / task.tick})\n"
        heads = [*self.heads, *(["int P_phase(uint32_t tick);"] if phased else [])]
        heads += [f"\n#define M_SELFTEST_{hash_}\nint P_selftest(void);"] if task.selftest else []
        own = HEAD.format(
            n=task.n, **whole, last=-(-task.t_c // task.tick), second=f"INT32_C({a})" if b == 1 else f"({a}.0 / {b}.0)",
            proved=proved, share=repr(float(rounded(start_share(task), 53, math.floor))), hash=hash_,
            heads="\n".join(heads), **scales,
        )  # fmt: skip
        should = [*tokens(self.named(own)), "the end"]
        different = next((f"{a} where {b} is expected" for a, b in zip([*tokens(text), "the end"], should) if a != b), "")
        need(not different, f"the header has {different}")

    # ---- nothing leaves 32 bits

    def call(self, name: str, given: list[Span]) -> list[Span]:
        """From spans of what a function is given to spans of its results. One that reads tables is read index by index; weights
        are reckoned at every s."""
        key = (name, *given)
        if key not in self.seen and name in ("weights", "rates"):
            need(given == [HALF], "s of the C is not within 16 bits")
            self.seen[key] = [(min(v), max(v)) for v in every(name, tuple(self.listings[name]))]
        elif key not in self.seen and name in ("edge", "curve") and given[0][0] < given[0][1]:
            found = [self.call(name, [(k, k), *given[1:]]) for k in range(given[0][0], given[0][1] + 1)]
            self.seen[key] = [(min(v[0] for v in each), max(v[1] for v in each)) for each in zip(*found)]
        elif key not in self.seen:
            self.seen[key] = self.body(name, dict(zip(self.params[name], given)))
        return self.seen[key]

    def body(self, name: str, known: dict[str, Span]) -> list[Span]:
        """The spans of the results of a listing; `Failed` where a value may leave 32 bits, an index its table, or an operand what
        its operation is for."""
        made: dict[str, tuple[str, tuple[str, ...]]] = {}
        results: list[Span] = []

        def get(text: str) -> Span:
            return known[text] if text in known else (int(text.strip("()")), int(text.strip("()")))

        for label_, kind, parts in self.listings[name]:
            label = label_
            if not label:
                given, of = re.fullmatch(r"(\w+)\((.+)\)", kind), re.fullmatch(r"!(?:\*\w+ =|return) (\w+)", kind)
                if given:
                    words = given[2].split(", ")
                    found = self.call(given[1], [get(v) for v in words if v[0] != "&"])
                    known |= dict(zip((v[1:] for v in words if v[0] == "&"), found))
                elif of:
                    results.append(get(of[1]))
                elif kind == "each i":
                    known["i"] = (0, len(self.tables["gains"]) - 1)
                elif kind in ("!int32_t margin = 32768", "!bool covered = true"):
                    known[kind.split()[1]] = INT32  # with which nothing is reckoned
                continue
            made[label] = (kind, parts)
            if kind in ("<", "&&") or parts[-1] in ("true", "false"):
                continue
            if kind == "size":
                test, minus, label = label.split(", ")
                low, high = get(parts[0])
                made[test], known[minus] = ("<", ("0", parts[0])), (-high, -low)
                span = (0 if low <= 0 <= high else min(abs(low), abs(high)), max(abs(low), abs(high)))
                need(inside(known[minus], INT32), f"{minus} in {name} of the C may be beyond 32 bits")
            elif kind == "pick":
                span = picked(made[parts[0]], parts[1:], get)
            elif kind == "load" and parts[0] not in self.tables:
                span = INT32  # x or v, of which nothing is known
            elif kind == "load":
                at, table = get(parts[1]), self.tables[parts[0]]
                need(inside(at, (0, len(table) - 1)), f"{name} of the C may read {parts[0]} where it has no entry")
                part = table[at[0] : at[1] + 1]
                span = (int(min(part)), int(max(part)))
            elif kind in EXACT or kind == "leading":
                span = reckoned(name, kind, parts, [get(v) for v in parts], made)
            else:
                span = self.call(kind, [get(v) for v in parts])[0]
            need(inside(span, INT32), f"{label} in {name} of the C may be {span[0]} to {span[1]}, beyond 32 bits")
            known[label] = span
        return results

    # ---- what it is wrong by

    def clock(self, task: Task, tube: Tube) -> Fraction:
        """`late`: how many segments the place of a tick is off at most. It is scale/2^16 for each tick, rounded down and held a
        unit before the end, in units of 2^-bits; s has 16 bits of it; a tick's length is right within half a unit."""
        assert task.tick is not None
        holes, step = self.holes, task.tick * tube.segments / task.t_c
        bits, last = holes["bits"], math.ceil(task.t_c / task.tick)
        good = holes["lastU"] == last and bits < 31 and holes["end"] == (tube.segments << bits) - 1
        good = good and holes.get("fine", 0) == bits - 16 and abs(holes["scale"] - step * 2 ** (bits + 16)) <= Fraction(1, 2)
        all_of_it = last < 1 << 16 or any(label == "passed_both" for label, _, _ in self.listings["segment"])
        need(good and all_of_it, "segment of the C counts other ticks than the task's")
        self.late = Fraction(1, 1 << bits) * (Fraction(last, 1 << 17) + 2) + (Fraction(1, 1 << 16) if bits > 16 else 0)
        return self.late / tube.segments

    def moved(self, tube: Tube, order: int) -> list[Fraction]:
        """P7, by dimension. With d0, d1, d2 the steps between the four entries, an edge is 6 q1 + d1 + d1 (3 s + 3 s^2 - 2 s^3) +
        d2 s^3 - d0 (1 - s)^3, and its rate d0 3 (1 - s)^2 + d1 (3 + 6 s (1 - s)) + d2 3 s^2, a segment. A step times a weight is
        exact, and so are sums but for two, which are rounded down by less than a unit each. The weights are tried at every s, and
        s is late. A rate has two units more, for v, rounded to a unit, and a distance times lambda, rounded down."""
        found, per = [], Fraction(tube.segments) / tube.t_c if order else Fraction(1)
        name = ("weights", "rates")[order]
        wrong = weighed(name, tuple(self.listings[name]), per, self.holes.get("places", 0))
        for i in range(tube.n):
            edges = [[row[i][side] for row in tube.table] for side in (0, 1)]
            step = max(abs(v - w) for edge in edges for v, w in zip(edge, edge[1:]))
            found.append((step * wrong + tube.fastest(i, order + 1) * self.late * per + (2, 4)[order]) * tube.unit)
        return found

    # ---- the law

    def fitted(self, row: int, f: Function1, begin: Fraction, length: Fraction, scale: Fraction) -> tuple[Fraction, Fraction]:
        """What a row of the curves is wrong by, relative, at most against f/scale on its piece; and the least of f/scale there.

        Let P = level - (slope - bend z) z/2 be the row, z from 0 to 1, and F = f/scale - P. On a quarter of the piece F is the
        quadratic through its values at both ends and in the middle, within its three Bezier coefficients, and its third
        derivative/6 times z (z - 1/2) (z - 1), which is at most 1/20. f is 2^46/m or H. Its third derivative falls in size: of
        1/m plainly; H is 8 atanh(e)/e/(1 - e^2) with e = 1 - y, a power series in e with no negative coefficient. So a third
        difference of values up to the quarter shows no less. What is emitted is less than 1/2 below P and less than 1 above, for
        `bent` and `fall` are rounded down; and z is, by less than 2^-16, in which P falls by slope/2^17 or rises by (2 bend -
        slope)/2^17 at most."""
        level, slope, bend = (int(self.tables[name][row]) for name in ("levels", "slopes", "bends"))
        need(min(slope, bend) >= 0, f"row {row} of the curves of the C has a slope or bend below 0")
        known = {k: f(begin + length * k / 8) for k in (-6, -4, -2, *range(9))}
        doubt = 16 * max(high - low for low, high in known.values()) / scale
        value = {k: low / scale for k, (low, _) in known.items()}
        off = [value[k] - level + (slope - Fraction(bend * k, 8)) * Fraction(k, 16) for k in range(9)]
        least, most = Fraction(0), Fraction(0)
        for k in range(0, 8, 2):
            third = abs(value[k] - 3 * value[k - 2] + 3 * value[k - 4] - value[k - 6]) / 120 + doubt
            ends = off[k], 2 * off[k + 1] - (off[k] + off[k + 2]) / 2, off[k + 2]
            least, most = min(least, min(ends) - third), max(most, max(ends) + third)
        less = most + Fraction(1, 2) + Fraction(max(0, 2 * bend - slope), 1 << 17)
        return max(less, 1 + Fraction(slope, 1 << 17) - least) / (value[8] - doubt), value[8] - doubt

    def curves(self) -> tuple[Fraction, list[tuple[Fraction, Fraction]], int]:
        """What 1/d is wrong by at most; of every row of H what that is, and the least of it; and how 2^places stands for
        2^(places - base)."""
        one, places = 1 << 30, [int(v) for v in self.tables["places"]]
        size = {len(self.tables[name]) for name in ("levels", "slopes", "bends", "places")}
        whole = size == {len(places)} and len(places) % 8 == 0 and len(places) > 16
        need(whole, "the curves of the C have tables of another length")
        over = [self.fitted(k, inverse, Fraction(one + (k << 26)), Fraction(1 << 26), Fraction(1))[0] for k in range(16)]
        first = steep(Fraction(1, 2))[0] / max(self.tables["levels"][16], Fraction(1))
        base, rise = places[16] - min(range(-64, 64), key=lambda k: abs(1 - first / Fraction(2) ** k)), []
        for row in range(16, len(places)):
            octave, head = divmod(row - 16, 8)
            length = Fraction(1, 16 << octave)
            rise.append(self.fitted(row, steep, (8 + head) * length, length, Fraction(2) ** (places[row] - base)))
        return max(over), rise, base

    def law(self, task: Task, tube: Tube, gain: list[Fraction], held: list[tuple[Fraction, Fraction]]) -> None:
        """(13) within r = 2^-10, relative and in epsilon, as P9 takes it. held: by component the least and the largest width of
        what is held, in units, less and more by what the arithmetic moves it.

        With e the normalized error and d the width (13) is k/d |e| H(1 - |e|). Let a and b be what 1/d and H are wrong by, c what
        the gain is. |e| and y = 1 - |e| are wrong by a too, and rounded down to 2^-30. -y H'/H is between 0 and 3/2: 1 - e times
        the slope of -ln(1 - e^2) is 2 e/(1 + e) <= 1, and times that of ln(atanh(e)/e) at most e/(1 + e) <= 1/2. So H is wrong by
        a power of 3/2 at most; 2 is taken. Beyond e_max |e| is at most `top`, y at least `lowest`. `push` rounds three products
        down, by less than 3 of its units, and e is rounded down by one: |e| counts as so much less. At last u is rounded down by
        less than a unit, and xi is at least 4/d."""
        one, r, e_max, rest = 1 << 30, Fraction(1, 1 << 10), task.e_max[0], 1 - task.e_max[0]
        a, rises, base = self.curves()
        b = max(v for v, _ in rises)
        top, lowest, narrow = Fraction(self.holes["top"], one), Fraction(self.holes["lowest"], one), self.holes["narrow"]
        need(max(a, b) <= r, f"the curves of the C are wrong by {float(max(a, b)):.3g}: they are not 1/d and H")
        need(0 < lowest < 1, "the least y of the C is not within 0 and 1")
        over, rise = (1 - a) / 2, min(v for _, v in rises) * (1 - b) / (1 << 16)  # the least of both, over 2^16
        places, most = [int(v) for v in self.tables["places"]], 31 - narrow.bit_length()  # by which a width moves up
        for i, k in enumerate(gain):
            mantissa, offset, limit = (int(self.tables[name][i]) for name in ("gains", "offsets", "limits"))
            exact = abs(k) * Fraction(2) ** (self.x_bits + self.u_bits + offset - 28 - base)
            need(abs(mantissa - exact) <= Fraction(1, 2), f"the gain of component {i + 1} of the C is not the certificate's")
            c = Fraction(1, 2) / exact
            thin = f"the law of the C takes the tube to be {narrow} units wide or more, in component {i + 1}"
            need(0 < narrow <= held[i][0], f"{thin} it may be {float(held[i][0]):.0f}")
            off = a + 1 / (rest * one)  # relative, of the least y
            need(off <= r, "e_max is too near 1 for integers")
            inside_ = (1 + a) ** 2 * (1 + b) * (1 + c) / (1 - off) ** 2
            beyond = top / e_max * steep(lowest)[1] / steep(rest)[0] * (1 + a) * (1 + b) * (1 + c)
            less = min(1 - a, top / e_max) * (1 - a) * (1 - b) * (1 - c) / max(1 + a, lowest / rest) ** 2
            relative = max(inside_ - 1, beyond - 1, 1 - less)
            lost = (1 + 3 / (over * rise * Fraction(mantissa, 1 << 16))) * (1 + relative) / one
            lost *= logarithm((1 + e_max) / (1 - e_max))[1] / e_max  # the largest 2 atanh(e)/e
            lost += Fraction(2) ** -self.u_bits * held[i][1] * tube.unit / (4 * abs(k))
            told = f"u of component {i + 1} of the C is wrong by {float(relative):.3g} of it and {float(lost):.3g} of epsilon"
            need(relative <= r and lost <= r * (1 - relative), f"{told}, which is more than 2^-10")
            for row, (_, least) in enumerate(rises, 16):
                octave, head = divmod(row - 16, 8)
                if places[row] > offset - most:  # u would have to move up: it must be at its limit already
                    e = min(1 - a - Fraction(9 + head, 16 << octave) - Fraction(2, one), top)
                    size = e * one * least * (1 - b) * over * mantissa / (1 << 32) - 3
                    need(limit <= size, f"u of component {i + 1} of the C may be lost before it is at its limit")

    def proves(
        self, task: Task, tube: Tube, gain: list[Fraction], limits: list[Fraction], filtered: list[Fraction], x_bits: int
    ) -> None:
        """The law; that nothing leaves 32 bits; and that no state within the tube is beyond where the C holds x and v."""
        self.x_bits = x_bits
        wrong, whole, unit = self.moved(tube, 0), self.tables["limits"], tube.unit
        sizes = {len(self.tables[name]) for name in ("gains", "offsets", "limits")}
        need(sizes == {task.n}, "a table of the C has other components than the task")
        ratio = whole[0] / limits[0]
        self.u_bits = ratio.numerator.bit_length() - ratio.denominator.bit_length()
        need(whole == [v * Fraction(2) ** self.u_bits for v in limits], "the limits of the C are not u_max")
        own = [[h - v for piece in tube.pieces for v, h in zip(*piece[i])] for i in range(task.n)]
        held = [(min(v) - 2 * e / unit, max(v) + 2 * e / unit) for v, e in zip(own, wrong)]
        reach = 6 * max(abs(v) for row in tube.table for pair in row for v in pair)
        need(reach < 1 << (28 if task.order == 1 else 26), "the tube is beyond where the C holds x")
        if task.order == 2:
            more, narrow, rates = self.holes.get("more", 1), self.holes["narrow_x"], self.moved(tube, 1)
            same = self.tables["filters"] == [s * (1 << 16) / more for s in filtered]
            need(more in (1, 2, 4) and same, "the filters of the C are not lambda")
            thin = f"margin of the C takes the tube to be {narrow} units wide or more"
            need(0 < narrow <= min(v for v, _ in held), f"{thin}, which it is not")
            pieces, per = derived(tube, task, filtered)[0], tube.segments / task.t_c
            for i, s in enumerate(filtered):
                need(tube.fastest(i) * per + s * held[i][1] < 1 << 28, "the tube's rates are beyond where the C holds v")
                z, room = [(h - v) / unit for piece in pieces for v, h in zip(*piece[i])], 2 * (rates[i] + s * wrong[i]) / unit
                held[i] = (min(z) - room, max(z) + room)
        for name in self.listings.keys() & {"tube", "filtered_tube", "control", "margin", "margins", "covered"}:
            self.body(name, {"tick": (0, (1 << 32) - 1)})
        self.law(task, tube, gain, held)


@lru_cache(maxsize=8)
def every(name: str, listing: tuple[Step, ...]) -> list[list[int]]:
    """The results of `weights` or `rates` at every s, exactly."""
    known: dict[str, list[int]] = {"s": list(range(1 << 16))}
    results = []
    for label, kind, parts in listing:
        if not label:
            results.append(known[kind.rpartition(" ")[2]])
            continue
        given = [known[v] if v in known else [int(v)] * (1 << 16) for v in parts]
        for values, room in zip(given, ROOMS.get(kind, [])):
            need(inside((min(values), max(values)), room), f"{kind} in {name} of the C may be of what it is not for")
        known[label] = list(map(EXACT[kind], *given))
        need(inside((min(known[label]), max(known[label])), INT32), f"{label} in {name} of the C may be beyond 32 bits")
    return results


@lru_cache(maxsize=8)
def weighed(name: str, listing: tuple[Step, ...], per: Fraction, places: int) -> Fraction:
    """What a step is wrong by through its weights at most: of an edge, or of its rate, with `per` segments a second and weights
    in 2^-places. Of an edge the worst of the outer two together and the worst of the middle one, which are of other s."""
    one, all_s = 1 << 16, range(1 << 16)
    if name == "weights":
        before, middle, after = every(name, listing)
        outer = max(abs((a << 33) - (one - s) ** 3) + abs((c << 33) - s**3) for s, a, c in zip(all_s, before, after))
        inner = max(abs((b << 34) - s * (3 * one * one + s * (3 * one - 2 * s))) for s, b in zip(all_s, middle))
        return Fraction(outer + inner, 1 << 48)
    a, b = per.numerator << places, per.denominator << 32
    true = ((3 * (one - s) ** 2, 3 * one * one + 6 * s * (one - s), 3 * s * s) for s in all_s)
    return Fraction(
        max(sum(abs(v * b - w * a) for v, w in zip(own, of)) for *own, of in zip(*every(name, listing), true)), b << places
    )


def picked(test: tuple[str, tuple[str, ...]], chosen: tuple[str, ...], get: Callable[[str], Span]) -> Span:
    """c ? p : q; where c is a < b, and p or q is a or b itself, what is chosen is known to be on its side."""
    found = []
    for which, holds in zip(chosen, (True, False)):
        low, high = get(which)
        if test[0] == "<":
            a, b = (get(v) for v in test[1])
            if which == test[1][0]:
                low, high = (low, min(high, b[1] - 1)) if holds else (max(low, b[0]), high)
            elif which == test[1][1]:
                low, high = (max(low, a[0] + 1), high) if holds else (low, min(high, a[1]))
        if low <= high:
            found.append((low, high))
    return min(low for low, _ in found), max(high for _, high in found)


def reckoned(
    name: str, kind: str, parts: tuple[str, ...], given: list[Span], made: dict[str, tuple[str, tuple[str, ...]]]
) -> Span:
    """One operation. Each is monotone in either operand, or linear: its ends are at corners."""
    for span, room in zip(given, ROOMS.get(kind, [])):
        need(inside(span, room), f"{kind} in {name} of the C may be of {span[0]} to {span[1]}, which it is not for")
    if kind == "leading":
        return 31 - given[0][1].bit_length(), 31 - given[0][0].bit_length()
    if kind == "low":
        mask = given[1][1]
        need(given[1] == (mask, mask) and mask & (mask + 1) == 0, f"low in {name} of the C has no mask")
        need(name != "curve" or inside(given[0], (0, mask)), f"a row of the curves of the C has values beyond {mask}")
        least, most = given[0]
        return (least & mask, most & mask) if least == most or inside(given[0], (0, mask)) else (0, mask)
    if kind == "up":
        of, by = (made.get(v, ("", ())) for v in parts)
        if by == ("leading", (parts[0],)):  # moved up until it begins with a 1
            return 1 << 30, INT32[1]
        if by[0] == "leading" and of[0] == "least" and of[1][1] == by[1][0]:  # and what is at most that
            return 0, INT32[1]
    ends = [EXACT[kind](*corner) for corner in itertools.product(*given)]
    return min(ends), max(ends)


def inverse(m: Fraction) -> tuple[Fraction, Fraction]:
    """2^46/m, from below and above."""
    return (1 << 46) / m, (1 << 46) / m


@cache
def steep(y: Fraction) -> tuple[Fraction, Fraction]:
    """H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)) for 0 < y <= 1, from below and above."""
    if y == 1:
        return Fraction(8), Fraction(8)
    low, high = logarithm((2 - y) / y)
    return 4 * low / ((1 - y) * y * (2 - y)), 4 * high / ((1 - y) * y * (2 - y))


# ------------------------------------------------------------------------------------------------ P1 to P6


def parts(tube: Tube, hints: list[Any], cuts: int, whole: bool) -> Iterator[tuple[Piece, Any, tuple[int, int]]]:
    """The pieces that the hints name, each with its normal and from where to where it is: stretches in parts of a segment, one
    after the other without a gap. whole: segments of which there is no hint are taken as they are."""
    at, end = 0, tube.segments * cuts
    need(all(isinstance(hint, list) and len(hint) == (2 if whole else 3) for hint in hints), "a hint is not [from, to, normal]")
    stretches = [(*hint, None)[:3] for hint in hints]
    for begin, stop, normal in [*stretches, (end, end, None)]:
        need(all(type(v) is int for v in (begin, stop)) and at <= begin <= stop <= end, "the hints are in no order")
        need(begin == at or (whole and at % cuts == begin % cuts == 0), "the hints leave a gap in time")
        for k in range(at // cuts, begin // cuts):
            yield tube.pieces[k], None, (k * cuts, (k + 1) * cuts)
        at = begin
        while at < stop:
            k = at // cuts
            to = min(stop, (k + 1) * cuts)
            yield (
                (tube.pieces[k] if to - at == cuts else within(tube.pieces[k], Fraction(at, cuts) - k, Fraction(to, cuts) - k)),
                normal,
                (at, to),
            )
            at = to
    need(at == end, "the hints leave a gap in time")


def within(piece: Piece, a: Fraction, b: Fraction) -> Piece:
    """The Bezier coefficients of a part of a piece, by de Casteljau's rule."""

    def cut(c: Edge, s: Fraction) -> tuple[Edge, Edge]:
        first: Edge = []
        last: Edge = []
        row = list(c)
        while row:
            first.append(row[0])
            last.insert(0, row[-1])
            row = [u + s * (v - u) for u, v in zip(row, row[1:])]
        return first, last

    def part(c: Edge) -> Edge:
        return cut(cut(c, b)[0], a / b)[1]

    return [(part(low), part(high)) for low, high in piece]


def above(value: Fraction, unit: Fraction) -> int:
    """The least whole number of units that is not below."""
    return math.ceil(value / unit)


def apart(
    task: Task, tube: Tube, unsafe: Unsafe, course: Course | None, found: list[tuple[Piece, Any, tuple[int, int]]], part: Fraction
) -> Iterator[int]:
    """By how much each piece is beyond a set along its normal, in the largest component and whole units; where the set moves,
    each part of the piece in which nothing turns. part: seconds of a part of a segment."""
    points, half, own, radius = unsafe
    for piece, normal, (at, to) in found:
        good = isinstance(normal, list) and len(normal) == task.n and all(type(c) is int for c in normal)
        need(good and math.gcd(*normal) == 1, "a hint of P4 has no normal of whole numbers without a common divisor")
        size, inside = sum(map(abs, normal)), [normal[i] for i in own]
        support = max(sum(map(operator.mul, normal, p), Fraction(0)) for p in points)
        support += sum(abs(c) * h for c, h in zip(normal, half)) + radius * length(inside) + size * task.clearance
        values = [sum(c * piece[i][c < 0][k] for i, c in enumerate(normal) if c) for k in range(4)]
        if course is None:
            yield math.floor((min(values) - above(support, tube.unit)) / Fraction(size))
            continue
        grows = course.spread * (length(inside) if radius else sum(map(abs, inside)))
        for p, q, places in course.legs(at * part, to * part):
            row, room = [Fraction(v) for v in values], []
            shares = [(t / part - at) / (to - at) for t in (p, q)]
            cut = within([(row, row)], *shares)[0][0]
            for k in range(4):  # the Bezier coefficients from p to q
                s = Fraction(k, 3)
                ahead = max(sum((c * (u + s * (v - u)) for c, u, v in zip(normal, *ds)), Fraction(0)) for ds in places)
                room.append(cut[k] - above(support + ahead + grows * (p + s * (q - p) + course.late), tube.unit))
            yield math.floor(min(room) / size)


# ------------------------------------------------------------------------------------------------ P10

Formula = Any  # ("in", region), ("out", region), ("and", f, ..), ("or", f, ..), (operator, (from, to), f, ..)
PRECEDENCE = ("->", "or", "and", "until")
WORDS = ("always", "eventually", "until", "and", "or", "not", "inf")


def joined(sign: str, *parts: Formula) -> Formula:
    """ "and" or "or" of formulas, flat."""
    flat = [p for part in parts for p in (part[1:] if part[0] == sign else (part,))]
    return flat[0] if len(flat) == 1 else (sign, *flat)


def negated(f: Formula) -> Formula:
    """What holds only where a formula does not."""
    kind, *rest = f
    other = {"in": "out", "out": "in", "and": "or", "or": "and", "always": "eventually", "eventually": "always"}
    if kind in ("in", "out"):
        return (other[kind], *rest)
    if kind in ("and", "or"):
        return joined(other[kind], *map(negated, rest))
    if kind in ("always", "eventually"):
        return (other[kind], rest[0], negated(rest[1]))
    (a, b), first, last = rest[0], negated(rest[1]), negated(rest[2])
    release = ("eventually", (a, a), ("until", (Fraction(0), b - a), last, joined("and", first, last)))
    return joined("or", ("always", (a, b), last), ("eventually", (Fraction(0), a), first), release)


def formula(text: Any) -> Formula:
    """The formula that a text says, "not" down at the regions."""
    need(isinstance(text, str), "a formula is no text")
    words = [*re.findall(r"->|[A-Za-z]\w*|\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|\S", text), ""]

    def taken(word: str) -> None:
        if words.pop(0) != word:
            raise Unusable(f"the formula {text!r:.80} lacks a {word!r}")

    def window() -> tuple[Any, Any]:
        if words[0] != "[":
            return Fraction(0), math.inf
        taken("[")
        begin = Fraction(_decimal(words.pop(0)))
        taken(",")
        end = math.inf if words[0] == "inf" else Fraction(_decimal(words[0]))
        words.pop(0)
        taken("]")
        if end < begin:
            raise Unusable(f"the formula {text!r:.80} has a window that ends before it begins")
        return begin, end

    def binary(level: int) -> Formula:
        if level == len(PRECEDENCE):
            return unary()
        sign, found = PRECEDENCE[level], binary(level + 1)
        while words[0] == sign:
            taken(sign)
            if sign == "->":
                found = joined("or", negated(found), binary(level))
            elif sign == "until":
                found = ("until", window(), found, binary(level + 1))
            else:
                found = joined(sign, found, binary(level + 1))
        return found

    def unary() -> Formula:
        word = words.pop(0)
        if word == "not":
            return negated(unary())
        if word in ("always", "eventually"):
            return (word, window(), unary())
        if word == "(":
            found = binary(0)
            taken(")")
            return found
        if not re.fullmatch(r"[A-Za-z]\w*", word) or word in PRECEDENCE:
            raise Unusable(f"the formula {text!r:.80} has {word!r} where a region is needed")
        return ("in", word)

    found = binary(0)
    taken("")
    return found


def entry(table: Any, t_c: Fraction, repeats: bool) -> Formula:
    """An entry of the mission as a formula."""
    zero = Fraction(0)
    forms = [k for k in ("visit", "never", "patrol", "formula") if k in table]
    beside = {"visit": "between stay then within", "never": "before", "patrol": "every until", "formula": ""}
    if len(forms) != 1 or not set(table) <= {forms[0], *beside[forms[0]].split()}:
        raise Unusable("the task has an entry of its mission that is said in no way that is known here")
    if forms == ["formula"]:
        return formula(table["formula"])
    if forms == ["never"]:
        out = ("out", str(table["never"]))
        return (
            ("until", (zero, t_c), out, ("in", str(table["before"]))) if "before" in table else ("always", (zero, math.inf), out)
        )
    if forms == ["patrol"]:
        every, until = _number(table["every"]), _number(table["until"]) if "until" in table else t_c
        if not 0 < every <= until or not isinstance(table["patrol"], list):
            raise Unusable("the task has a patrol that is shorter than its rounds")
        over = (zero, math.inf if repeats and "until" not in table else until - every)
        rounds = (("always", over, ("eventually", (zero, every), ("in", str(r)))) for r in table["patrol"])
        return joined("and", *rounds)
    stay, begin = _number(table.get("stay", 0)), tuple(_each(table["between"], 2)) if "between" in table else (zero, t_c)
    here: Formula = ("in", str(table["visit"]))
    here = ("always", (zero, stay), here) if stay else here
    if "then" in table:
        gap = _number(table["within"]) if "within" in table else t_c
        here = joined("and", here, ("eventually", (stay, stay + gap), ("in", str(table["then"]))))
    if stay < 0 or begin[0] > begin[1] or begin[0] < 0 or ("within" in table and not _number(table["within"]) > 0):
        raise Unusable("the task has a visit in no time")
    return ("eventually", begin, here)


def united(spans: Any) -> list[tuple[Any, Any]]:
    """Intervals as disjoint ones, in order."""
    found: list[tuple[Any, Any]] = []
    for a, b in sorted(spans):
        if found and a <= found[-1][1]:
            found[-1] = (found[-1][0], max(b, found[-1][1]))
        else:
            found.append((a, b))
    return found


def met(first: Any, last: Any) -> list[tuple[Any, Any]]:
    """What is in both of two sets of intervals."""
    return united((max(a, c), min(b, d)) for a, b in first for c, d in last if max(a, c) <= min(b, d))


def ahead(t: Any, by: Any) -> Any:
    """t - by, where t may be infinite."""
    return t if math.isinf(t) else t - by


class Cycle:
    """From `begin` to `end`, and again and again; every time may be wrong by the margin."""

    def __init__(self, begin: Fraction, end: Fraction, margin: Fraction) -> None:
        self.begin, self.end, self.length, self.margin = begin, end, end - begin, margin
        need(margin <= self.length, "P10: the time margin is longer than the cycle")

    def held(self, spans: list[tuple[Any, Any]], until: Fraction) -> list[tuple[Any, Any]]:
        """What is known until `end`, told until a time, less the margin at both ends of every interval."""
        found, by = list(spans), self.length
        while self.end + by - self.length < until + self.margin:
            found += [(max(u, self.begin) + by, v + by) for u, v in spans if v >= self.begin]
            by += self.length
        left = ((u + self.margin, min(v - self.margin, until)) for u, v in united(found))
        return [(u, v) for u, v in left if u <= v]

    def looked(self, over: Any, until: Fraction) -> Fraction:
        """Until when a part must be known; what holds for ever holds for a cycle."""
        a, b = over
        far: Fraction = max(until, self.end) + a + self.length if math.isinf(b) else until + b
        return far


def satisfied(
    f: Formula, known: dict[Formula, list[tuple[Any, Any]]], cycle: Cycle | None = None, until: Fraction = Fraction(0)
) -> list[tuple[Any, Any]]:
    """When a formula holds, from when the parts hold that are known; all that is known is proved. Of what is repeated all until a
    time, and nothing after it."""
    if f in known:
        return known[f] if cycle is None else cycle.held(known[f], until)
    kind, *rest = f
    if kind in ("in", "out"):  # nothing is claimed of it
        return []
    if kind in ("and", "or"):
        found = [satisfied(p, known, cycle, until) for p in rest]
        every = found[0]
        for one in found[1:]:
            every = met(every, one)
        return every if kind == "and" else united(span for one in found for span in one)
    a, b = rest[0]
    far = until if cycle is None else cycle.looked((a, b), until)
    first, *others = (satisfied(p, known, cycle, far) for p in rest[1:])
    if kind == "always":
        ever = far if cycle is not None and math.isinf(b) else None
        spans = [(ahead(u, a), ahead(math.inf if v == ever else v, b)) for u, v in first]
    elif kind == "eventually":
        spans = [(ahead(u, b), ahead(v, a)) for u, v in first]
    else:
        spans = [(max(u, ahead(c, b)), min(v, ahead(d, a))) for u, v in first for c, d in met([(u, v)], others[0])]
    spans = spans if cycle is None else [(u, min(v, until)) for u, v in spans]
    return united((u, v) for u, v in spans if u <= v)


class Mission:
    """The regions and the formula of a task, choices told by their members."""

    def __init__(self, document: Any, names: list[str], space: Box, body: list[Fraction], t_c: Fraction, delay: Fraction) -> None:
        self.regions: dict[str, Any] = {}
        self.names, self.space, self.body, self.delay = names, space, body, delay
        for table in document.get("region", []):
            if str(table["name"]) in self.regions:
                raise Unusable("the task has two regions of one name")
            name, members = str(table["name"]), table.get("any_of")
            form = " ".join(k for k in KNOWN["region"].split()[3:] if k in table)
            known = form in FORMS if members is None else isinstance(members, list) and set(table) == {"name", "any_of"}
            if not known or not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII) or name in WORDS:
                raise Unusable("the task has a region that is said in no way that is known here")
            if members is not None and (not members or any(one not in self.regions for one in members)):
                raise Unusable("the task has a choice of regions that are not before it")
            self.regions[str(table["name"])] = table
        repeats = document.get("repeat", False) is True
        self.formula = joined("and", *(self.told(entry(table, t_c, repeats)) for table in document["mission"]))

    def told(self, f: Formula) -> Formula:
        """With every choice told by its members."""
        kind, *rest = f
        if kind not in ("in", "out"):
            parts = [self.told(p) for p in rest if isinstance(p[0], str)]
            return joined(kind, *parts) if kind in ("and", "or") else (kind, rest[0], *parts)
        if rest[0] not in self.regions:
            raise Unusable(f"the mission speaks of {rest[0]!r}, which is no region")
        members = self.regions[rest[0]].get("any_of")
        return f if members is None else joined("or" if kind == "in" else "and", *(self.told((kind, m)) for m in members))

    def box(self, name: str, more: list[Fraction]) -> list[tuple[Any, Any]] | None:
        """The edges of a region that is a box, grown; None of another. In dimensions that are not its own it has none."""
        table = self.regions[name]
        if "lower" not in table:
            return None
        own = _own(table, self.names)
        ends = dict(zip(own, zip(*_box(table, len(own)))))
        return [(ends[i][0] - m, ends[i][1] + m) if i in ends else (-math.inf, math.inf) for i, m in enumerate(more)]

    def true(self, f: Formula, point: list[Any], more: list[Fraction]) -> bool:
        """Whether a formula of boxes holds at a point that lies on no edge; of those kept off, grown by `more`."""
        kind, *rest = f
        if kind in ("and", "or"):
            return (all if kind == "and" else any)(self.true(p, point, more) for p in rest)
        need(kind in ("in", "out"), "the certificate claims a formula with times as one without")
        edges = self.box(rest[0], more if kind == "out" else [Fraction(0)] * len(more))
        need(edges is not None, "the certificate claims a choice of what are not boxes")
        inside = all(a < x < b for x, (a, b) in zip(point, edges or []))
        return bool(inside == (kind == "in"))

    def room(self, f: Formula, task: Task, tube: Tube, margin: int) -> Callable[[Piece], bool]:
        """Whether all of a piece, larger by the margin on every side, satisfies a state formula; true only where it does."""
        unit, more = tube.unit, [h + task.clearance for h in self.body]
        if f[0] == "in" and "lower" not in self.regions[f[1]]:
            faces = _cuts(self.regions[f[1]], self.names)
            if not faces:  # all of none would hold anywhere
                raise Unusable("the mission has a region to be in, of which no half-space is known here")

            def behind(piece: Piece) -> bool:
                return all(
                    sum(c * piece[i][c > 0][k] for i, c in enumerate(n) if c) * unit + sum(map(abs, n)) * margin * unit <= offset
                    for n, offset in faces
                    for k in range(4)
                )

            return behind
        edges: list[set[Any]] = [set() for _ in range(task.n)]

        def gather(p: Formula) -> None:
            if p[0] in ("and", "or"):
                for part in p[1:]:
                    gather(part)
                return
            need(p[0] in ("in", "out"), "the certificate claims a formula with times as one without")
            found = self.box(p[1], more if p[0] == "out" else [Fraction(0)] * task.n)
            need(found is not None, "the certificate claims a choice of what are not boxes")
            for i, ends in enumerate(found or []):
                edges[i].update(v for v in ends if not math.isinf(v))

        gather(f)

        def within_boxes(piece: Piece) -> bool:
            cells = []
            for (low, high), cut in zip(piece, edges):
                a, b = (min(low) - margin) * unit, (max(high) + margin) * unit
                ends = [a, *sorted(v for v in cut if a < v < b), b]
                cells.append([(p + q) / 2 for p, q in zip(ends, ends[1:])])
            return all(self.true(f, list(point), more) for point in itertools.product(*cells))

        return within_boxes

    def prove(self, task: Task, tube: Tube, error: int, claims: list[Any], cuts: int, told: Any, late: Fraction) -> None:
        """P10: every claim about a state, and that the mission follows from them."""
        need(isinstance(told, dict) and set(told) == {"formula", "time_margin"}, "the certificate's mission is not known")
        need(self.told(formula(told["formula"])) == self.formula, "the certificate's formula is not the task's mission")
        margin, part, end = told["time_margin"], task.t_c / (tube.segments * cuts), tube.segments * cuts
        clock = task.t_c * late + self.delay
        need(type(margin) is int and margin * part >= clock, "P10: the time margin is less than the clock's error")
        known: dict[Formula, list[tuple[Any, Any]]] = {}
        for claim in claims:
            keys = {"property", "set", "on", "margin"}
            need(set(claim) - {"hints"} == keys and claim["property"] == "P10", f"a claim is not of P10: {claim!s:.80}")
            on, room = claim["on"], claim["margin"]
            good = isinstance(on, list) and [type(v) for v in (*on, room)] == [int] * 3 and 0 <= on[0] <= on[1] <= end
            need(good and room >= error, f"P10: a claim has no interval, or less room than the arithmetic takes: {claim!s:.80}")
            state = self.told(formula(claim["set"]))
            self.state(state, claim, task, tube, cuts)
            stands = tube.seam is None  # of what is repeated the margin is taken off once it is unrolled
            off = margin if stands else 0
            a, b = (-math.inf if on[0] == 0 else on[0] + off), (math.inf if on[1] == end and stands else on[1] - off)
            spans = known.setdefault(state, [])
            if a <= b:
                spans.append((a * part, b * part))
        cycle = None if tube.seam is None else Cycle(task.t_c - tube.cycle, task.t_c, margin * part)
        found = satisfied(self.formula, {f: united(spans) for f, spans in known.items()}, cycle)
        need(any(a <= 0 <= b for a, b in found), "P10: the mission does not follow from what is claimed of its states")

    def state(self, f: Formula, claim: Any, task: Task, tube: Tube, cuts: int) -> None:
        """That a state holds on the interval of a claim, with its margin."""
        (begin, stop), room = claim["on"], claim["margin"]
        if f[0] == "out" and "lower" not in self.regions[f[1]]:
            table = {k: v for k, v in self.regions[f[1]].items() if k != "name"}
            unsafe = _unsafe(table, self.names, self.space, self.body)
            at, found = begin, list[Any]()
            need(isinstance(claim.get("hints"), list), "a claim to keep off what is no box has no hints")
            for hint in claim["hints"]:
                need(isinstance(hint, list) and len(hint) == 3 and at == hint[0] <= hint[1], "the hints are in no order")
                at = hint[1]
                for a, b in by_segment(hint[0], hint[1], cuts):
                    found.append((part_of(tube, a, b, cuts), hint[2], (a, b)))
            need(at == stop and bool(found), "the hints leave a gap in time")
            slack = min(apart(task, tube, unsafe, None, found, Fraction(1)))
            need(slack >= room, f"P10: {claim['set']} does not hold from {begin} to {stop} with the margin that is claimed")
            return
        shows = self.room(f, task, tube, room)
        for a, b in aligned(begin, stop, cuts):
            need(self.shown(part_of(tube, a, b, cuts), shows, 12), f"P10: {claim['set']} does not hold from {a} to {b}")

    def shown(self, piece: Piece, shows: Callable[[Piece], bool], depth: int) -> bool:
        """Whether a piece, in halves where its hull is too coarse, is as it should be."""
        if shows(piece):
            return True
        half = Fraction(1, 2)
        parts = [within(piece, Fraction(0), half), within(piece, half, Fraction(1))] if depth else []
        return bool(parts) and all(self.shown(p, shows, depth - 1) for p in parts)


def aligned(begin: int, stop: int, cuts: int) -> Iterator[tuple[int, int]]:
    """An interval, in parts of a segment, as the fewest stretches of which each is a power of two long, at most a segment, and
    begins at a multiple of its length; a moment as it is."""
    at = begin
    while at < stop:
        size = cuts
        while at % size or at + size > stop:
            size //= 2
        yield at, at + size
        at += size
    if begin == stop:
        yield begin, stop


def by_segment(begin: int, stop: int, cuts: int) -> Iterator[tuple[int, int]]:
    """An interval, in parts of a segment, segment by segment; a moment as it is."""
    at = begin
    while at < stop:
        to = min(stop, (at // cuts + 1) * cuts)
        yield at, to
        at = to
    if begin == stop:
        yield begin, stop


def part_of(tube: Tube, a: int, b: int, cuts: int) -> Piece:
    """The tube from a to b, in parts of a segment."""
    k = min(a // cuts, tube.segments - 1)
    if b - a == cuts:
        return tube.pieces[k]
    p, q = Fraction(a, cuts) - k, Fraction(b, cuts) - k
    return within(tube.pieces[k], p, q) if q > 0 else [([low[0]] * 4, [high[0]] * 4) for low, high in tube.pieces[k]]


def derived(tube: Tube, task: Task, filtered: list[Fraction]) -> tuple[list[Piece], list[Piece]]:
    """For order 2, exactly: the edges of v + lambda x, L' + lambda L and R' + lambda R; and what the tube's motion asks of u at
    each, lambda^2 (R - L) + L'' and lambda^2 (R - L) - R''. Bezier coefficients of degree 3, in the task's units."""
    k, edges, asked = tube.segments / task.t_c, [], []
    for piece in tube.pieces:
        pairs, own = [], []
        for (low, high), s in zip(piece, filtered):
            both, press = [], []
            for c, sign in ((low, 1), (high, -1)):
                d = [b - a for a, b in zip(c, c[1:])]
                e = [b - a for a, b in zip(d, d[1:])]
                rate = (3 * d[0], d[0] + 2 * d[1], 2 * d[1] + d[2], 3 * d[2])
                bend = (6 * e[0], 4 * e[0] + 2 * e[1], 2 * e[0] + 4 * e[1], 6 * e[1])
                both.append([(k * r + s * v) * tube.unit for r, v in zip(rate, c)])
                press.append([(s * s * (h - v) + sign * k * k * b) * tube.unit for v, h, b in zip(low, high, bend)])
            pairs.append((both[0], both[1]))
            own.append((press[0], press[1]))
        edges.append(pairs)
        asked.append(own)
    return edges, asked


def inertial(
    task: Task, tube: Tube, rate_error: list[int], edge_error: list[int], filtered: list[Fraction], bits: int
) -> list[tuple[str, list[int], int, Fraction, dict[str, Any]]]:
    """For order 2: room for v + lambda x, starts in it, input enough. Each as code, when, slack in whole units, what is demanded
    of it, and what else the claim says."""
    edges, asked = derived(tube, task, filtered)
    speed, common = tube.unit * tube.segments / task.t_c, math.lcm(*(s.denominator for s in filtered))
    unit = tube.unit / ((tube.segments / task.t_c).denominator * common)
    room = min(h - v for piece in edges for low, high in piece for v, h in zip(low, high))
    wrong = [2 * (r * speed + s * e * tube.unit) for r, s, e in zip(rate_error, filtered, edge_error)]
    always, starts = [0, tube.segments], []
    for i, (low, high) in enumerate(tube.pieces[0]):
        clear = min(3 * (low[0] - low[1]), 3 * (high[1] - high[0])) * speed
        if task.speed[i]:
            clear += filtered[i] * (1 - task.share) * (high[0] - low[0]) * tube.unit / 2 - task.speed[i] - wrong[i]
        starts.append(math.floor(clear / speed))
    found = [
        ("P1", always, math.floor(room / unit) - above(LEAST_WIDTH, unit), max(wrong) / unit, {"order": 2}),
        ("P2", [0, 0], min(starts), Fraction(0), {"order": 2}),
    ]
    if task.limited:
        own = tube.unit / ((tube.segments / task.t_c).denominator * common) ** 2
        most = [max(v for piece in asked for c in piece[i] for v in c) for i in range(task.n)]
        least = min(math.floor(s / own) - math.floor(v / own) for s, v in zip(spare_input(task, bits), most))
        found.append(("P8", always, least, Fraction(1), {}))
    return found


def prove(
    task: Task,
    tube: Tube,
    error: int,
    claims: list[dict[str, Any]],
    cuts: int,
    bits: int,
    more: list[tuple[str, list[int], int, Fraction, dict[str, Any]]],
    mission: Any,
    late: Fraction,
) -> None:
    """Every property's slack in whole units, as its claim says it, and what rounding may take. late: of t_c, what the clock
    is wrong by. Raises `Failed`."""
    unit, dims, end = tube.unit, range(task.n), tube.segments * cuts
    need(all(task.start[0][i] < task.start[1][i] for i in dims), "the initial set is empty")

    def claim(code: str, on: list[int], slack: int | None, needed: int | Fraction, **other: Any) -> None:
        found = claims.pop(0) if claims else {}
        told = {"property": code, **other, "on": on, **({} if slack is None else {"margin": slack})}
        need(slack is None or slack >= needed, f"{code} does not hold: {float((needed - (slack or 0)) * unit):.3g} is missing")
        need(
            json.dumps(found, sort_keys=True) == json.dumps(told, sort_keys=True),
            f"the certificate does not claim what holds of {code}: {told}",
        )

    def hints(code: str) -> list[Any]:
        found = claims[0].pop("hints", None) if claims and claims[0].get("property") == code else None
        need(found is None or (isinstance(found, list) and bool(found)), f"the hints of {code} are none")
        return found or []

    def least(code: str, slack: Callable[[Piece], Any]) -> int:
        """The slack over all pieces, in whole units."""
        found: Iterator[int] = (math.floor(slack(piece)) for piece, _, _ in parts(tube, hints(code), cuts, True))
        return min(found)

    narrow = above(task.min_width, unit)
    width = least("P1", lambda piece: min(h - v for low, high in piece for v, h in zip(low, high)) - narrow)
    claim("P1", [0, end], width, 2 * error)

    def box(edges: list[tuple[int, int]], lower: list[Fraction], upper: list[Fraction]) -> int:
        return min(min(a - above(low, unit), -above(-high, unit) - b) for (a, b), low, high in zip(edges, lower, upper))

    first = [(low[0], high[0]) for low, high in tube.pieces[0]]
    state = min(min(-above(-x, unit) - a, b - above(x, unit)) for (a, b), x in zip(first, task.state))
    claim("P2", [0, 0], min(state, box(first, *task.start)), error)

    def behind(piece: Piece, cuts: list[tuple[list[int], Fraction]]) -> list[Any]:
        """By how much a piece is within half-spaces, in the largest component."""
        rooms = []
        for normal, offset in cuts:
            values = [sum(-c * piece[i][c > 0][k] for i, c in enumerate(normal) if c) for k in range(4)]
            rooms.append(math.floor((min(values) - above(-offset, unit)) / Fraction(sum(map(abs, normal)))))
        return rooms

    def stay(piece: Piece) -> Any:
        return min([box([(min(low), max(high)) for low, high in piece], *task.space), *behind(piece, task.walls)])

    claim("P3", [0, end], least("P3", stay), error)
    for (name, unsafe), course in zip(task.unsafe, task.courses):
        found = list(apart(task, tube, unsafe, course, list(parts(tube, hints("P4"), cuts, False)), Fraction(task.t_c, end)))
        claim("P4", [0, end], min(found), error, set=name)
    last = [(low[3], high[3]) for low, high in tube.pieces[-1]]
    held: Piece = [([low[3]] * 4, [high[3]] * 4) for low, high in tube.pieces[-1]]
    if task.reaches:
        claim("P5", [end, end], min([box(last, *task.target), *behind(held, task.goals)]), error)
    if tube.seam is not None:
        need(tube.table[-3:] == tube.table[tube.seam : tube.seam + 3], "P6: the tube has a kink where it begins again")
    else:
        need(all(tube.table[-k] == tube.table[-3] for k in range(1, task.order + 1)), "P6: the tube has a kink at t_c")
    for order, most in enumerate(task.limits, 1):
        scale = (task.t_c / tube.segments) ** order / unit
        room = None if most is None else min(math.floor(most[i] * scale) - tube.fastest(i, order) for i in dims)
        if order == 1 or room is not None:
            claim("P6", [0, end], room, 0, **({} if order == 1 else {"order": order}))
    for code, on, slack, needed, told in more:
        claim(code, [v * cuts for v in on], slack, needed, **told)
    if task.limited and task.order == 1:
        claim("P8", [0, end], spare(task, tube, bits), 1)
    if task.mission is not None:
        task.mission.prove(task, tube, error, claims, cuts, mission, late)
    need(not claims or task.mission is not None, "the certificate claims more than is known")


# ------------------------------------------------------------------------------------------------ P9


def logarithm(y: Fraction) -> tuple[Fraction, Fraction]:
    """ln y for y > 1, from below and above: halved k times until it is below 3/2, and twice artanh series."""
    k = max(0, y.numerator.bit_length() - y.denominator.bit_length() - 1)
    k += y / 2**k >= Fraction(3, 2)
    pairs = [_artanh((y / 2**k - 1) / (y / 2**k + 1)), *([_artanh(Fraction(1, 3))] * k)]
    return 2 * sum((low for low, _ in pairs), Fraction(0)), 2 * sum((high for _, high in pairs), Fraction(0))


def _artanh(z: Fraction, bits: int = 80, terms: int = 26) -> tuple[Fraction, Fraction]:
    """The series z + z^3/3 + .. for |z| <= 1/3, in whole multiples of 2^-bits; what is left out is below z^(2 terms + 1)."""
    one = 1 << bits
    ends = []
    for v, toward in ((math.floor(z * one), math.floor), (math.ceil(z * one), math.ceil)):
        power, square, total = Fraction(v, one), Fraction(v, one) ** 2, Fraction(0)
        for j in range(terms):
            total += Fraction(toward(power / (2 * j + 1) * one), one)
            power = Fraction(toward(power * square * one), one)
        ends.append(total)
    left = Fraction(2, 3 ** (2 * terms + 1)) + Fraction(2 * terms, one)
    return ends[0] - left, ends[1] + left


def bounds(task: Task, i: int) -> tuple[Fraction, Fraction, Fraction, Fraction]:
    """Of component i the bound on |f_i + w_i|, g_min, g_max, g_cross; where g_min or g_max is missing it is 1, or the other one
    where 1 contradicts it."""
    own = {k: None if v is None else v[i] for k, v in task.plant.items()}
    low, high = own["g_min"], own["g_max"]
    g_min = low if low is not None else min(Fraction(1), Fraction(1) if high is None else high)
    force, cross = (own["f_max"] or Fraction(0)) + (own["w_max"] or Fraction(0)), own["g_cross"] or Fraction(0)
    return force, g_min, high if high is not None else max(Fraction(1), g_min), cross


def spare_input(task: Task, bits: int) -> list[Fraction]:
    """What an input within u_max, as it is emitted, is worth at least against all that pushes, by component."""
    limit = [rounded(v, bits, math.floor) for v in task.u_max or []]
    found = [bounds(task, i) for i in range(task.n)]
    if task.scales:  # 1/sqrt(n), rounded down
        share = Fraction(math.isqrt(10**24 // task.n), 10**12)
        return [(g_min * v - push) * share for v, (push, g_min, _, _) in zip(limit, found)]
    return [g_min * v - push - cross * (sum(limit) - v) for v, (push, g_min, _, cross) in zip(limit, found)]


def spare(task: Task, tube: Tube, bits: int) -> int:
    """P8: by how much an input within u_max moves the state faster than any edge comes towards it: units of the table in a
    segment's time."""
    room = spare_input(task, bits)
    least: list[int] = []
    for piece in tube.pieces:
        for (low, high), most in zip(piece, room):
            rates = [3 * (b - a) for a, b in zip(low, low[1:])], [3 * (a - b) for a, b in zip(high, high[1:])]
            towards = max(abs(v) if task.scales else v for edge in rates for v in edge)
            least.append(math.floor(most * task.t_c / tube.segments / tube.unit) - towards)
    return min(least)


Window = list[tuple[Fraction, Fraction, Fraction, Fraction, Fraction]]  # by component: least and largest width, three pushes


def windows(task: Task, tube: Tube, filtered: list[Fraction]) -> list[Window]:
    """Every segment, and the time from t_c on, where what is repeated begins again: the width of what is held, and what the
    tube's motion pushes it by at an edge, while a sample ages, and from the middle. Of order 1 x is held, and all three are the
    speed of the faster edge."""
    found: list[Window] = []
    if task.order == 1:
        for piece in tube.pieces:
            spans = [[h - v for v, h in zip(*edges)] for edges in piece]
            fast = [3 * max(abs(b - a) for e in edges for a, b in zip(e, e[1:])) * tube.segments / task.t_c for edges in piece]
            found.append([(min(s) * tube.unit, max(s) * tube.unit, *[f * tube.unit] * 3) for s, f in zip(spans, fast)])
        if tube.seam is not None:
            return [*found, found[tube.seam]]
        still = [(high[3] - low[3]) * tube.unit for low, high in tube.pieces[-1]]
        return [*found, [(s, s, *[Fraction(0)] * 3) for s in still]]
    second = (tube.segments / task.t_c) ** 2 * tube.unit
    edges, asked = derived(tube, task, filtered)
    for k in range(tube.segments + (tube.seam is None)):
        p, end = min(k, tube.segments - 1), k == tube.segments
        here: Window = []
        for i, s in enumerate(filtered):
            at: Any = slice(3, 4) if end else slice(0, 4)
            z = [h - v for v, h in zip(*edges[p][i])][at]
            w = max([h - v for v, h in zip(*tube.pieces[p][i])][at]) * tube.unit
            bends = [[6 * (c - 2 * b + a) * second for a, b, c in zip(e, e[1:], e[2:])] for e in tube.pieces[p][i]]
            low, high = ([Fraction(0)], [Fraction(0)]) if end else bends
            ups = max(low), max(high)
            downs = -min(low), -min(high)
            held, square = s * max(z), s * s * w
            here.append((
                min(z), max(z), max(*(max(c[at]) for c in asked[p][i]), ups[1], downs[0]),
                max(held + downs[0], square + downs[1], held + ups[1], square + ups[0], Fraction(0)),
                max(abs(a + b) for a, b in zip(low, high)) / 2 + (held + square) / 2,
            ))  # fmt: skip
        found.append(here)
    return found if tube.seam is None else [*found, found[tube.seam]]


def starting(task: Task, tube: Tube, filtered: list[Fraction]) -> list[Fraction]:
    """What a/b and b/a are at most at the start, by component."""
    if task.order == 1:
        return [(1 + task.share) / (1 - task.share)] * task.n
    speed, found = tube.unit * tube.segments / task.t_c, []
    for i, (low, high) in enumerate(tube.pieces[0]):
        rates, width = (3 * (low[1] - low[0]) * speed, 3 * (high[1] - high[0]) * speed), (high[0] - low[0]) * tube.unit
        most = [(1 + task.share) / (1 - task.share)]
        for share, v in itertools.product(((1 - task.share) / 2, (1 + task.share) / 2), (task.speed[i], -task.speed[i])):
            a, b = v - rates[0] + filtered[i] * share * width, rates[1] - v + filtered[i] * (1 - share) * width
            need(min(a, b) > 0, "P9 does not hold: a start may be outside the filtered tube")
            most += [a / b, b / a]
        found.append(max(most))
    return found


def start_share(task: Task) -> Fraction:
    """The share of gamma(0)'s half widths that covered starts are within: that of P9, or where the law is not clamped."""
    return min(task.e_max) if task.period is None else task.share


def covered_starts(task: Task, tube: Tube, source: Source, filtered: list[Fraction]) -> dict[str, list[Fraction]]:
    """The tables of `covered`: a measured x strictly between the first two, and for order 2 the C's v + lambda x strictly
    between the others, is of no state but one that P9 (or, without a period, Theorem 4.1) begins at. The middle is that of the
    tube; the half width the share of it, of v + lambda x what `starting` says, less what a measurement may be wrong by: the
    noise, and roundings. Real numbers: of x twice 2^-bits of the largest coordinate, and as much of all that v + lambda x is
    summed from, twice. Integers: half a unit of x and of v, and a unit that lambda x loses."""
    whole, unit = isinstance(source, Integers), tube.unit
    noise, noise_v = ((task.plant.get(k) or [Fraction(0)])[0] for k in ("noise", "noise_v"))
    noise = noise if task.unwrap_noise is None else task.unwrap_noise  # the period proof may do without
    speed, eps = unit * tube.segments / task.t_c, Fraction(2, 1 << source.bits)
    ratios = starting(task, tube, filtered) if task.period is not None and task.order == 2 else []
    found: list[list[Fraction]] = [[] for _ in STARTS[: 2 * task.order]]
    for i, (low, high) in enumerate(tube.pieces[0]):
        begin, end, share = low[0] * unit, high[0] * unit, start_share(task)
        wrong = [noise + (unit / 2 if whole else eps * task.farthest)]
        spans = [(begin, end, share)]
        if task.order == 2:
            s, (a, b) = filtered[i], (3 * (e[1] - e[0]) * speed + filtered[i] * e[0] * unit for e in (low, high))
            spans.append((a, b, (ratios[i] - 1) / (ratios[i] + 1) if ratios else share))
            rounded_ = unit * (Fraction(3, 2) + s / 2) if whole else 2 * eps * (2 * s * task.farthest + max(abs(a), abs(b)))
            wrong.append((Fraction(0) if task.apart is not None else noise_v) + s * noise + rounded_)
        for k, ((a, b, part), off) in enumerate(zip(spans, wrong)):
            middle, half = (a + b) / 2, part * (b - a) / 2 - off
            least, most = middle - half, middle + half
            if whole:
                found[2 * k].append(Fraction(math.ceil(least / unit) - 1))
                found[2 * k + 1].append(Fraction(math.floor(most / unit) + 1))
            else:
                found[2 * k].append(rounded(least, source.bits, math.ceil))
                found[2 * k + 1].append(rounded(most, source.bits, math.floor))
    return dict(zip(STARTS, found))


def sampled(
    task: Task,
    tube: Tube,
    gain: list[Fraction],
    bits: int,
    rho: list[Fraction],
    shift: list[Fraction],
    filtered: list[Fraction],
) -> list[Fraction]:
    """P9, window by window (a segment, and the time from t_c on; a sample may stem from the window before). Bounds on |u|; raises
    `Failed` where a condition does not hold. docs/certificate-format.md has the statement, the lemma book its proof."""
    assert task.period is not None
    n, plant = range(task.n), [bounds(task, i) for i in range(task.n)]
    need(all(g_min <= g_max for _, g_min, g_max, _ in plant), "P9 does not hold: g_min is above g_max")
    r, tau, segment = (
        Fraction(LAW["integers" if bits == 20 else "inline" if task.inline else "libm"][bits]),
        task.period + task.latency,
        task.t_c / tube.segments,
    )
    limits = None if task.u_max is None else [rounded(v, bits, math.floor) for v in task.u_max]
    need(tau <= (segment / 2 if task.latency else segment), "P9 does not hold: a sample may be older than a segment")
    for first, e, e_max, (low, high), x in zip(
        starting(task, tube, filtered), rho, task.e_max, [(a[0], b[0]) for a, b in tube.pieces[0]], task.state
    ):
        need(first < e <= (1 + e_max) / (1 - e_max), "P9 does not hold: rho is not between the share and e_max")
        a, b = low * tube.unit, high * tube.unit
        need(abs(2 * x - a - b) <= task.share * (b - a), "P9 does not hold: initial_state is outside the share")
    every = windows(task, tube, filtered)
    largest = [Fraction(0)] * task.n
    for k, window in enumerate(every):
        before = every[max(k - 1, 0)]
        u = []
        for i in n:
            seen = min(window[i][0], before[i][0])
            far, near = seen * rho[i] / (1 + rho[i]) + shift[i], seen / (1 + rho[i]) - shift[i]
            share = (1 - task.e_max[i]) / 2
            if near <= (far + near) * share:  # the clamp acts
                far, near = (1 - share) * (seen - 2 * shift[i]), share * (seen - 2 * shift[i])
            if near > 0:
                pull = abs(gain[i]) * (1 / far + 1 / near) * (logarithm(far / near)[1] + r) * (1 + r)
                u.append(pull if limits is None else min(pull, limits[i]))
            else:
                need(limits is not None, "P9 does not hold: what the law may see is wider than the tube")
                u.append((limits or [Fraction(0)])[i])
        for i in n:
            narrow, wide = window[i][:2]
            force, g_min, g_max, cross = plant[i]
            force += cross * (sum(u, Fraction(0)) - u[i])
            push, aged, turned = (force + max(a, b) for a, b in zip(window[i][2:], before[i][2:]))
            side = narrow / 2 * ((rho[i] - 1) / (rho[i] + 1) - r) > (turned + g_max * u[i]) * tau + shift[i]
            need(side, f"P9 does not hold: x may pass the middle of the tube between two samples (window {k}, component {i + 1})")
            need(
                limits is None or g_min * limits[i] > push,
                f"P9 does not hold: u_max is too small (window {k}, component {i + 1})",
            )
            drift = aged * tau + g_max * u[i] * task.latency + shift[i]
            for d in (narrow, wide):
                a, b = d * rho[i] / (1 + rho[i]) - drift, d / (1 + rho[i]) + drift
                held = a > b and abs(gain[i]) * (1 - r) * g_min * (1 / a + 1 / b) * (logarithm(a / b)[0] - r) > push
                need(held, f"P9 does not hold: the law does not push back enough (window {k}, component {i + 1})")
        largest = [max(a, b) for a, b in zip(largest, u)]
    return largest


# ------------------------------------------------------------------------------------------------ the certificate


def fractions(values: Any, n: int) -> list[Fraction]:
    need(
        isinstance(values, list) and len(values) == n and all(isinstance(v, str) for v in values),
        "a claim has no list of fractions",
    )
    need(all(re.fullmatch(r"-?\d+(/[1-9]\d*)?", v, re.ASCII) for v in values), "a claim has a fraction that is none")
    return [Fraction(v) for v in values]


def compare(task: Task, certificate: dict[str, Any], text: bytes, folder: Path) -> Tube:
    """The certificate's hashes and claims against what is read, found and proved."""
    clock: dict[str, Any] = {} if task.clock is None else {"clock": task.clock}
    second = ["filter", "rate_error"] if task.order == 2 else []
    named = [name for name, there in (("sampled", task.period), ("mission", task.mission)) if there is not None]
    unknown = set(certificate) ^ {*CLAIMS, *named, *clock, *second}
    need(not unknown, f"the certificate lacks a claim or has one that is not known: {', '.join(sorted(unknown))}")
    told = {"format": 2, "task": task.name, "certified": True, "method": "exact", "order": task.order, **clock}
    for key, value in told.items():
        same = type(certificate[key]) is type(value) and certificate[key] == value
        need(same, f"the certificate's {key} is {certificate[key]!r:.200}, the task's {value!r}")
    scalar, p = certificate["scalar"], task.name
    need(scalar in ("float", "double", *(["fixed"] if not task.turns.periods else [])), "the scalar is not known")
    source = Integers(text, task) if scalar == "fixed" else Source(text, task, scalar == "float")
    task.unwrapped(source.bits)
    phased = task.mission is not None and f"{p}_phase.c" in certificate["sha256"]
    _beside(task, certificate["sha256"], text, folder, phased, scalar == "float")
    head = (folder / f"{p}.h").read_bytes()

    grid = certificate["grid"]
    keys = {"segments", "cuts", "unit_bits", *(["seam"] if task.repeats else [])}
    need(isinstance(grid, dict) and set(grid) == keys, "the certificate's grid is not known")
    need(
        all(type(v) is int for v in grid.values()) and abs(grid["unit_bits"]) < 200,
        "the certificate's grid is not of whole numbers",
    )
    tube, cuts = Tube(source, task, grid["unit_bits"], grid.get("seam")), grid["cuts"]
    late = source.clock(task, tube)
    need(grid["segments"] == tube.segments, "the certificate has another number of segments than the C")
    need(task.segments in (None, tube.segments), "the task asks for another number of segments than the C has")
    need(cuts > 0 and cuts & (cuts - 1) == 0, "cuts is no power of two")
    error = arithmetic(source, tube)
    _rounds("edge", error, certificate["edge_error"], tube.unit)
    need(certificate["speed"] == [tube.fastest(i) for i in range(task.n)], "the certificate's speed is not the tube's")
    start = [[low[0], high[0]] for low, high in tube.pieces[0]]
    need(certificate["start"] == start, "the certificate's start is not the tube's")
    lack = [max(s[0] * tube.unit - a, b - s[1] * tube.unit) * 1000 - (b - a) for s, a, b in zip(start, *task.start)]
    need(certificate["covers_initial_set"] is (max(lack) <= 0), "the certificate's covers_initial_set is wrong")

    gain = _law(task, source, certificate["control"])
    need(isinstance(certificate["claims"], list), "the certificate's claims are no list")
    filtered, more, wide = _filter(task, tube, source, certificate, error) if task.order == 2 else ([], [], True)
    claims = [dict(claim) for claim in certificate["claims"]]
    prove(task, tube, max(certificate["edge_error"]), claims, cuts, source.bits, more, certificate.get("mission"), late)
    hash_ = design_hash(task, tube, scalar, grid["unit_bits"], filtered)
    starts = covered_starts(task, tube, source, filtered)
    if isinstance(source, Integers):
        source.proves(task, tube, gain, fractions(certificate["control"]["u_max"], task.n), filtered, grid["unit_bits"])
        need(all(source.tables[k] == v for k, v in starts.items()), "a table of the C has other starts than are covered")
    else:
        narrowest = min(h - low for piece in tube.pieces for e in piece for low, h in zip(*e)) * tube.unit
        computes(source, task, gain, wide and narrowest - 2 * max(error) > LEAST_WIDTH, filtered, starts)
    _header(head, source, task, tube, hash_, phased)
    if task.period is not None:
        _sampled(task, tube, certificate["sampled"], gain, source, error, filtered)
    return tube


def _rounds(what: str, error: list[Fraction], told: Any, unit: Fraction) -> None:
    """P7: the claim about edges, or their rates, is what the arithmetic moves them by."""
    known = isinstance(told, list) and len(told) == len(error)
    need(known, f"the certificate's {what}_error is not known: {len(error)} whole numbers are needed")
    for own, claimed in zip(error, told):
        fits = type(claimed) is int and above(own, unit) <= claimed <= above(own * Fraction(32769, 32768), unit)
        need(fits, f"P7: the arithmetic moves an edge or a rate by {float(own / unit):.4g} units, not {claimed} ({what}_error)")


def _beside(task: Task, hashes: dict[str, str], text: bytes, folder: Path, phased: bool, single: bool) -> None:
    """The files beside the C are those of the certificate, and what small ones do is known. text: of the C."""
    p, there = task.name, {"guard": task.outside != "return", "selftest": task.selftest, "phase": phased, "wrap": task.repeats}
    there["unwrap"] = bool(task.turns.periods)
    names = {f"{p}{end}" for end in (".h", ".c", ".py", *(f"_{key}.c" for key, wanted in there.items() if wanted))}
    need({*hashes} - {p + end for end in UNREAD} == {"task_data", *names}, "the certificate has other hashes than it should")
    need(hashes["task_data"] == task.digest, "the task's data is not that of the certificate (SHA-256)")
    known = {"_guard.c": (guard(task)[1], "the guard does"), "_wrap.c": (wrap(task)[1], "the clock is turned back by")}
    known["_unwrap.c"] = (unwrap(task, single)[1], "turns are counted by")
    for name in (name for name in hashes if name != "task_data"):
        data = text if name == f"{task.name}.c" else (folder / name).read_bytes() if (folder / name).exists() else None
        wanted, what = known.get(name.removeprefix(task.name), ([], ""))
        if wanted:
            need(data is not None, f"{name} is not beside the C: what it does is not known")
            need(tokens(data or b"") == wanted, f"{what} what it should not")
        same = data is None or hashes[name] == hashlib.sha256(data).hexdigest()
        need(same, f"{'the C file' if name == f'{task.name}.c' else name} is not that of the certificate (SHA-256)")


def _law(task: Task, source: Source, control: Any) -> list[Fraction]:
    """The constants of the law are the task's; the gain."""
    need(isinstance(control, dict) and set(control) == {"gain", "e_max", "u_max"}, "the certificate's control is not known")
    gain = fractions(control["gain"], task.n)
    need(task.gain in (None, gain), "the certificate's gain is not the task's")
    positive = min(gain) > 0 or (task.gain is not None and max(gain) < 0)  # one that was chosen is positive
    need(positive, "the certificate's gains are not of one sign, or not positive")
    need(fractions(control["e_max"], task.n) == task.e_max, "the certificate's e_max is not the task's")
    limits = None if control["u_max"] is None else fractions(control["u_max"], task.n)
    wanted = None if task.u_max is None else [rounded(v, source.bits, math.floor) for v in task.u_max]
    need(limits == wanted, "the certificate's u_max is not the task's, as the C has it")
    return gain


def _filter(task: Task, tube: Tube, source: Source, certificate: dict[str, Any], error: list[Fraction]) -> tuple[Any, Any, bool]:
    """For order 2: lambda, its properties, and whether the filtered tube is always wider than LEAST_WIDTH."""
    filtered, claimed = fractions(certificate["filter"], task.n), certificate["rate_error"]

    def held(s: Fraction) -> Fraction:
        """lambda as the C has it."""
        return Fraction(round(s * (1 << 14)), 1 << 14) if isinstance(source, Integers) else rounded(s, source.bits)

    good = min(filtered) > 0 and (isinstance(source, Integers) or all(held(s) == s for s in filtered))
    given = task.filter is None or [held(s) for s in task.filter] == filtered
    need(good and given, "the certificate's filter is not the task's, or no number of the C")
    speed, own = tube.unit * tube.segments / task.t_c, arithmetic(source, tube, 1)
    _rounds("rate", own, claimed, speed)
    more = inertial(task, tube, claimed, certificate["edge_error"], filtered, source.bits)
    room = min(h - v for piece in derived(tube, task, filtered)[0] for low, high in piece for v, h in zip(low, high))
    wrong = max(2 * (r + s * e) for r, s, e in zip(own, filtered, error))
    return filtered, more, room - wrong > LEAST_WIDTH


def shifts(
    task: Task, tube: Tube, source: Source, error: list[Fraction], filtered: list[Fraction]
) -> list[tuple[Fraction, Fraction]]:
    """What the law sees is wrong by: twice the arithmetic's part, which may be claimed as a little more, and the rest: x (for
    order 2 v too) rounded to the scalar, noise, and for order 2 the roundings of a and b, 8 of what is at most Z + 2 lambda W."""
    eps, (noise, noise_v) = Fraction(1, 1 << source.bits), ((task.plant.get(k) or [Fraction(0)])[0] for k in ("noise", "noise_v"))
    if task.order == 1:
        return [(2 * v, eps * task.farthest + noise) for v in error]
    edges, found = derived(tube, task, filtered)[0], []
    for i, (own, rate, s) in enumerate(zip(error, arithmetic(source, tube, 1), filtered)):
        w = max(h - v for piece in tube.pieces for v, h in zip(*piece[i])) * tube.unit
        z = max(h - v for piece in edges for v, h in zip(*piece[i]))
        fastest = tube.fastest(i) * tube.unit * tube.segments / task.t_c
        rest = eps * (s * task.farthest + fastest + s * w + 8 * (z + 2 * s * w))
        if task.apart is not None and task.period is not None:
            limit = [rounded(v, source.bits, math.floor) for v in task.u_max or []]
            force, _, g_max, cross = bounds(task, i)
            turn = force + g_max * limit[i] + cross * (sum(limit, Fraction(0)) - limit[i])
            noise_v = turn * task.period / 2 + 2 * (noise + eps * (task.farthest + noise)) / task.apart
            noise_v += 4 * eps * (fastest + s * w + noise_v)
        found.append((2 * (rate + s * own), rest + noise_v + s * noise))
    return found


def _sampled(
    task: Task,
    tube: Tube,
    claim: dict[str, Any],
    gain: list[Fraction],
    source: Source,
    error: list[Fraction],
    filtered: list[Fraction],
) -> None:
    """The claim about samples: its numbers are the task's, and what is proved with its rho."""
    known = {"period", "latency", "share", "plant", "rho", "u", "shift", *(["period_min"] if task.apart is not None else [])}
    need(set(claim) == known, "the certificate's `sampled` is not known")
    told: dict[str, Any] = {"period": str(task.period), "latency": str(task.latency), "share": str(task.share)}
    told["plant"] = task.stated
    if task.apart is not None:
        need(task.apart <= (task.period or 0), "the task has a period_min above its period")
        told["period_min"] = str(task.apart)
    for key, value in told.items():
        need(claim[key] == value, f"the certificate's sampled {key} is not the task's")
    rho, u, shift = (fractions(claim[key], task.n) for key in ("rho", "u", "shift"))
    for (own, rest), claimed in zip(shifts(task, tube, source, error, filtered), shift):
        need(own + rest <= claimed <= own * Fraction(32769, 32768) + rest, "P9: the law sees more wrong than `shift` says")
    for own, claimed in zip(sampled(task, tube, gain, source.bits, rho, shift, filtered), u):
        need(own <= claimed <= own * (1 + Fraction(1, 10**5)), f"P9: |u| is at most {float(own):.6g}, not {float(claimed):.6g}")
    _turning(task, tube, u, filtered)


def _turning(task: Task, tube: Tube, u: list[Fraction], filtered: list[Fraction]) -> None:
    """In an axis that closes a state of the loop moves by less from sample to sample than unwrapping allows: by no more than the
    tube's width and what its edges move, or what the plant does with |u_i| <= u_i, or of order 2 as fast as both tubes let it."""
    assert task.period is not None
    for i, allowed in task.turns.steps.items():
        width = max(h - v for piece in tube.pieces for v, h in zip(*piece[i])) * tube.unit
        speed = tube.fastest(i) * tube.unit * tube.segments / task.t_c
        moves = width + speed * task.period
        if task.order == 2:
            moves = min(moves, (speed + filtered[i] * width) * task.period)
        force, _, g_max, cross = bounds(task, i)
        if task.order == 1:
            moves = min(moves, (force + g_max * u[i] + cross * (sum(u, Fraction(0)) - u[i])) * task.period)
        need(moves < allowed, f"P9: between two samples an axis that closes may move by {float(moves):.6g}, its turn is lost")


def design_hash(task: Task, tube: Tube, scalar: str, bits: int, filtered: Sequence[Fraction] = ()) -> str:
    """The 16 hex digits that name the design in the header."""
    design = {"prescribed_time": str(task.t_c), "segments": tube.segments, "bits": bits, "table": tube.table}
    design |= {"filter": [str(v) for v in filtered]} if filtered else {}
    design |= {} if tube.seam is None else {"seam": tube.seam}
    data = {"task": task.digest, "scalar": scalar, "design": design}
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


def _header(text: bytes, source: Source, task: Task, tube: Tube, hash_: str, phased: bool) -> None:
    """The header: nothing but its types, constants and prototypes."""
    if isinstance(source, Integers):
        return source.header(text, task, tube, hash_, phased)
    numbers = {"T_C": task.t_c, "TICK_PERIOD": task.tick, "PERIOD_PROVED": task.period, "PERIOD_SHORTEST": task.apart}
    numbers |= {"CYCLE": tube.cycle or None, "SHARE": start_share(task)}
    numbers |= {f"TURN_{i + 1}": period for i, period in task.turns.periods.items()}
    found = tokens(text)
    for k, token in enumerate(found):
        name, value = (token.split(" ") if token.startswith("#define ") and token.count(" ") == 2 else ["", "", ""])[1:3]
        wanted = numbers.get(name.removeprefix(f"{task.name.upper()}_"))
        if wanted is not None:
            toward = math.floor if name.endswith(("PROVED", "SHARE")) else math.ceil if name.endswith("SHORTEST") else round
            need(source.number(value) == ("real", rounded(wanted, source.bits, toward)), f"{name} of the header is wrong")
            found[k] = f"#define {name} *"
    should = [*header(source, task, tube, hash_, phased), "the end"]
    different = next((f"{a} where {b} is expected" for a, b in zip([*found, "the end"], should) if a != b), "")
    need(not different, f"the header has {different}")


def _no_decimals(text: str) -> NoReturn:
    raise Failed(f"the certificate has the decimal {text}; its numbers are whole, or fractions")


def _no_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    need(len(dict(pairs)) == len(pairs), "the certificate claims something twice")
    return dict(pairs)


def main(arguments: list[str]) -> int:
    """Run the check; prints one line."""
    if len(arguments) != 3:
        print((__doc__ or "").strip(), file=sys.stderr)
        return 2
    try:
        data, text, proof = (Path(a).read_bytes() for a in arguments)
        task = Task(data)
        certificate = json.loads(proof)
        if not isinstance(certificate, dict) or certificate.get("design") != "refined":
            raise Unusable("the certificate is not of a refined tube; only those can be checked here")
        certificate = json.loads(proof, parse_float=_no_decimals, object_pairs_hook=_no_doubles)
        tube = compare(task, certificate, text, Path(arguments[1]).parent)
    except Failed as error:
        print(f"checker: NO: {error}")
        return 1
    except (OSError, Unusable) as error:
        told = f"{error.filename} cannot be read ({error.strerror})" if isinstance(error, OSError) else error
        print(f"checker: cannot check: {told}", file=sys.stderr)
        return 2
    except (RecursionError, ValueError, KeyError, TypeError, ArithmeticError, AttributeError, IndexError) as error:
        print(f"checker: cannot check: give task, C file, certificate ({type(error).__name__}: {error})", file=sys.stderr)
        return 2
    others = [name for name, there in (("P9", task.period), ("P10", task.mission)) if there is not None]
    proved = " and ".join(["P1 to " + ("P8" if task.limited else "P7"), *others])
    size = f"{tube.segments} segments, {task.n} dimensions"
    print(f"checker: yes: {task.name}: {proved} hold, and the C computes this tube and this law; {size}")
    return 0


def run() -> NoReturn:
    sys.exit(main(sys.argv[1:]))


if __name__ == "__main__":
    run()
