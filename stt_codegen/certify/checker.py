#!/usr/bin/env python3
"""Checks a certified controller without the tool that made it. Standard library only.

    python3 checker.py task.toml controller.c certificate.json

It reads the task's numbers as exact decimals and the tube's coefficients out of the C text, and repeats the proof that the
tube starts, keeps its width, stays, avoids and arrives (P1 to P6), in exact fractions, with a bound of its own on the rounding
of the emitted arithmetic (P7). Then it compares with what the certificate claims, and the hashes. It does not read the rest
of the C code. It speaks about refined tubes; for others it says that it cannot.

Exit code 0: all holds. 1: something does not, and what. 2: a file cannot be used.
"""

from __future__ import annotations

import hashlib
import json
import re
import struct
import sys
import tomllib
from collections.abc import Callable, Iterator
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, NoReturn

Edge = list[Fraction]  # Bezier coefficients of one cubic piece
Piece = list[tuple[Edge, Edge]]  # by dimension: lower and upper edge
LEAST_WIDTH = Fraction(1, 1 << 20)  # the emitted law treats narrower tubes as this wide
DEPTH = 20  # how often a piece is halved where its hull is too coarse


class Failed(Exception):
    """A property, a claim or a hash that does not hold."""


class Unusable(Exception):
    """A file that is not what it should be."""


class Task:
    """The numbers of a task file that the proof is about, exact; body already added to the sets."""

    def __init__(self, data: bytes) -> None:
        document = tomllib.loads(data.decode("utf-8-sig"), parse_float=Decimal)
        self.digest = hashlib.sha256(json.dumps(_plain(document), sort_keys=True, separators=(",", ":")).encode()).hexdigest()
        self.name = str(document["name"])
        self.t_c = _number(document["prescribed_time"])
        self.period = _number(document.get("emit", {}).get("tick_period", document["prescribed_time"]))
        self.state = [_number(v) for v in document["initial_state"]]
        self.n = len(self.state)
        body = [_number(v) for v in document.get("body", [0] * self.n)]
        self.start, self.target = _box(document["initial_set"]), _box(document["target_set"])
        lower, upper = _box(document["state_space"])
        self.space = ([a + h for a, h in zip(lower, body)], [b - h for b, h in zip(upper, body)])
        self.unsafe = []
        for j, entry in enumerate(document.get("unsafe", []), 1):
            lower, upper = _box(entry)
            grown = ([a - h for a, h in zip(lower, body)], [b + h for b, h in zip(upper, body)])
            self.unsafe.append((str(entry.get("name") or f"U{j}"), grown))
        tube = document.get("tube", {})
        self.clearance = _number(tube.get("clearance", Decimal("0.03")))
        self.min_width = max(_number(tube.get("min_width", Decimal("0.05"))), LEAST_WIDTH)
        self.max_speed = _number(tube["max_speed"]) if "max_speed" in tube else None


def _number(value: Any) -> Fraction:
    if isinstance(value, bool) or not isinstance(value, int | Decimal):
        raise Unusable(f"the task has {value!r} where a number is needed")
    return Fraction(value)


def _box(table: Any) -> tuple[list[Fraction], list[Fraction]]:
    return [_number(v) for v in table["lower"]], [_number(v) for v in table["upper"]]


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


class Tube:
    """The tube that the C text describes: control points over 6, as the numbers that the compiler makes of the literals."""

    def __init__(self, text: str, task: Task) -> None:
        p = re.escape(task.name)
        code = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
        tables = re.findall(rf"static const {p}_real {p}_coefficients\[(\d+)\] = \{{(.*?)\}};", code, re.DOTALL)
        if len(tables) != 1:
            raise Unusable("the C file has no table of coefficients of this task; only refined tubes can be checked here")
        literals = [v.strip() for v in tables[0][1].split(",")]
        if len(literals) != int(tables[0][0]) or len(literals) % (2 * task.n):
            raise Failed(f"the table has {len(literals)} entries, it should have {tables[0][0]}, a multiple of {2 * task.n}")
        self.single = any(v.endswith("F") for v in literals)
        values = [self.read(v) for v in literals]
        rows = [values[k : k + 2 * task.n] for k in range(0, len(values), 2 * task.n)]
        self.table = [[(row[2 * i], row[2 * i + 1]) for i in range(task.n)] for row in rows]
        self.segments = len(rows) - 3
        self.eps = Fraction(1, 1 << (24 if self.single else 53))
        self._check_time(code, task)

    def read(self, literal: str) -> Fraction:
        """A literal as the compiler rounds it. (Decimal to double to float can only differ where both round up to a tie.)"""
        if not re.fullmatch(r"-?\d+\.\d*(e-?\d+)?F?", literal) or literal.endswith("F") != self.single:
            raise Failed(f"the literal {literal!r} is not of the file's scalar type")
        value = float(literal.rstrip("F"))
        return Fraction(struct.unpack("<f", struct.pack("<f", value))[0] if self.single else value)

    def _check_time(self, code: str, task: Task) -> None:
        """The constants of the time scale: K / t_c and the last number below K, where the code has them."""
        body = re.search(rf"static inline void {re.escape(task.name)}_segment\(.*?\n\}}", code, re.DOTALL)
        found = body.group(0) if body else ""
        k = Fraction(self.segments)
        patterns = (r"scaled = started \* ([^;]+);", r"early = scaled < ([^;]+);", r"u = early \? scaled : ([^;]+);")
        rate, early, end = (self.read(m.group(1)) if (m := re.search(p, found)) else Fraction(0) for p in patterns)
        if abs(rate - k / task.t_c) > self.eps * k / task.t_c or not k * (1 - 2 * self.eps) <= early == end < k:
            raise Failed(f"the time scale of the C file is not that of {self.segments} segments over {float(task.t_c)} s")
        if "segment = (int32_t)u;" not in found or f"segment * {2 * task.n};" not in found:
            raise Failed("the table index of the C file does not fit its table")
        if "_control_tick(" in code:
            self._check_ticks(code, task)

    def _check_ticks(self, code: str, task: Task) -> None:
        """Integer time: every constant follows from the task's period."""
        body = re.search(rf"static inline void {re.escape(task.name)}_segment_at_tick\(.*?\n\}}", code, re.DOTALL)
        k, found, last = self.segments, body.group(0) if body else "", -(-task.t_c // task.period)
        num, den = (task.period * k / task.t_c).as_integer_ratio()
        wanted = (
            f"tick < {last}U;|running ? tick : {last}U;|count * {num};|passed < {k * den};|early ? passed : {k * den};|"
            f"place / {den};|whole < {k - 1};|before_last ? whole : {k - 1};|segment * {den};|place - base;|"
            f"segment * {2 * task.n};"
        ).split("|")
        part = re.search(r"share = part / ([^;]+);", found)
        if any(f" = {v}" not in found for v in wanted) or not part or abs(self.read(part.group(1)) - den) > self.eps * den:
            raise Failed(f"the ticks of the C file are not those of {float(task.period)} s over {float(task.t_c)} s")

    def pieces(self) -> Iterator[Piece]:
        """Bezier coefficients of every segment, by dimension (lower, upper)."""
        for k in range(self.segments):
            piece = []
            for i in range(len(self.table[0])):
                edges = []
                for side in (0, 1):
                    q0, q1, q2, q3 = (self.table[k + j][i][side] for j in range(4))
                    edges.append([q0 + 4 * q1 + q2, 4 * q1 + 2 * q2, 2 * q1 + 4 * q2, q1 + 4 * q2 + q3])
                piece.append((edges[0], edges[1]))
            yield piece


def arithmetic(tube: Tube, pieces: list[Piece]) -> Fraction:
    """P7, by hand: the emitted spline time is within 4 K eps (two roundings, and the end below K); every weight is a sum and
    product of positive numbers with at most 7 roundings, product and sums add 3, so the blend is within 11 eps of 6 times the
    largest coefficient."""
    steepest = max(3 * abs(b - a) for piece in pieces for pair in piece for e in pair for a, b in zip(e, e[1:]))
    largest = max(abs(v) for row in tube.table for pair in row for v in pair)
    return 4 * tube.segments * tube.eps * steepest + 66 * tube.eps * largest


def halves(piece: Piece) -> tuple[Piece, Piece]:
    """De Casteljau at the middle."""

    def cut(c: Edge) -> tuple[Edge, Edge]:
        a, b, d = ((u + v) / 2 for u, v in zip(c, c[1:]))
        e, f = (a + b) / 2, (b + d) / 2
        return [c[0], a, e, (e + f) / 2], [(e + f) / 2, f, d, c[3]]

    pairs = [(cut(low), cut(high)) for low, high in piece]
    return [(low[0], high[0]) for low, high in pairs], [(low[1], high[1]) for low, high in pairs]


def least(piece: Piece, slack: Callable[[Piece], Fraction], needed: Fraction, depth: int = DEPTH) -> Fraction:
    """A lower bound on the slack over the piece, halving it where the hull does not show what is needed; where the curve itself
    lacks it, what it has at one such point."""
    value = slack(piece)
    if value >= needed or depth == 0:
        return value
    begin = slack([([low[0]] * 4, [high[0]] * 4) for low, high in piece])
    if begin < needed:
        return begin
    first, second = halves(piece)
    return min(least(first, slack, needed, depth - 1), least(second, slack, needed, depth - 1))


def prove(task: Task, tube: Tube) -> dict[str, Fraction]:
    """The margin of every property; raises `Failed` when one is below what rounding may take."""
    pieces = list(tube.pieces())
    error = arithmetic(tube, pieces)
    dims = range(task.n)

    def width(piece: Piece) -> Fraction:
        return min(h - low for e, u in piece for low, h in zip(e, u)) - task.min_width

    def stay(piece: Piece) -> Fraction:
        low, high = task.space
        return min(min(min(piece[i][0]) - low[i], high[i] - max(piece[i][1])) for i in dims)

    def avoid(piece: Piece) -> Fraction:
        gaps = []
        for _, (low, high) in task.unsafe:
            gaps.append(max(max(low[i] - max(piece[i][1]), min(piece[i][0]) - high[i]) for i in dims))
        return min(gaps) - task.clearance

    first, last = ([(low[k], high[k]) for low, high in pieces[k]] for k in (0, -1))
    margins = {
        "P1": min(least(p, width, 2 * error) for p in pieces) - 2 * error,
        "P2": min(
            min(
                task.state[i] - first[i][0],
                first[i][1] - task.state[i],
                first[i][0] - task.start[0][i],
                task.start[1][i] - first[i][1],
            )
            for i in dims
        )
        - error,
        "P3": min(least(p, stay, error) for p in pieces) - error,
        "P5": min(min(last[i][0] - task.target[0][i], task.target[1][i] - last[i][1]) for i in dims) - error,
    }
    if task.unsafe:
        margins["P4"] = min(least(p, avoid, error) for p in pieces) - error
    if any(tube.table[-1][i][s] != tube.table[-3][i][s] for i in dims for s in (0, 1)):
        raise Failed("P6: the tube has a kink at t_c")
    if task.max_speed is not None:
        steps = (abs(b - a) for piece in pieces for pair in piece for e in pair for a, b in zip(e, e[1:]))
        margins["P6"] = task.max_speed - 3 * max(steps) * tube.segments / task.t_c
    for code in sorted(margins):
        if margins[code] < 0:
            raise Failed(f"{code} does not hold: {float(-margins[code]):.3g} is missing")
    return margins


def compare(task: Task, tube: Tube, certificate: dict[str, Any], source: bytes) -> None:
    """The certificate's hashes and claims against what was read."""
    if certificate.get("certified") is not True or certificate.get("task") != task.name:
        raise Failed("the certificate does not certify this task")
    if certificate["sha256"]["task_data"] != task.digest:
        raise Failed("the task's data is not that of the certificate (SHA-256)")
    if certificate["sha256"][f"{task.name}.c"] != hashlib.sha256(source).hexdigest():
        raise Failed("the C file is not that of the certificate (SHA-256)")
    if certificate["parameters"]["segments"] != tube.segments or certificate["scalar"] != ("float" if tube.single else "double"):
        raise Failed("the certificate names another number of segments or scalar type than the C file has")
    for key, value in (("clearance", task.clearance), ("min_width", task.min_width), ("prescribed_time", task.t_c)):
        if Fraction(str(certificate[key])) != value and not (key == "min_width" and value == LEAST_WIDTH):
            raise Failed(f"the certificate's {key} is not the task's")
    slack = prove(task, tube)
    for entry in certificate["properties"]:
        code, room = entry["property"], Fraction(str(entry["margin"])) - Fraction(str(entry["required"]))
        if entry["holds"] is not True:
            raise Failed(f"the certificate itself says that {code} does not hold")
        # both bounds on rounding differ by less than half of the certificate's own; a larger claim is a wrong one
        if (
            code in slack
            and code not in ("P2", "P6")
            and room > slack[code] + 2 * Fraction(str(max(certificate["edge_error_bound"])))
        ):
            raise Failed(f"the certificate claims more room for {code} than there is")


def main(arguments: list[str]) -> int:
    """Run the check; prints one line."""
    if len(arguments) != 3:
        print((__doc__ or "").strip(), file=sys.stderr)
        return 2
    try:
        data, source, proof = (Path(a).read_bytes() for a in arguments)
        task = Task(data)
        certificate = json.loads(proof)
        if not isinstance(certificate, dict) or certificate.get("design") != "refined":
            raise Unusable("the certificate is not of a refined tube; only those can be checked here")
        tube = Tube(source.decode(), task)
        compare(task, tube, certificate, source)
    except Failed as error:
        print(f"checker: NO: {error}")
        return 1
    except (OSError, Unusable) as error:
        told = f"{error.filename} cannot be read ({error.strerror})" if isinstance(error, OSError) else error
        print(f"checker: cannot check: {told}", file=sys.stderr)
        return 2
    except (ValueError, KeyError, TypeError, ArithmeticError, AttributeError, IndexError) as error:
        print(f"checker: cannot check: give task, C file, certificate ({type(error).__name__}: {error})", file=sys.stderr)
        return 2
    size = f"{tube.segments} segments, {task.n} dimensions"
    print(f"checker: yes: {task.name}: P1 to P7 hold for the coefficients in the C file, {size}")
    return 0


def run() -> NoReturn:
    sys.exit(main(sys.argv[1:]))


if __name__ == "__main__":
    run()
