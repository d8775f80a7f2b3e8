"""Unsafe sets as proof/Sets.v has them, from the task's text; and normals of the certificate, each with what shows how far a set
that half-spaces cut reaches along it. Coq reads the sets itself and believes no normal."""

from __future__ import annotations

import itertools
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any

from stt_codegen.certify import checker

Point = tuple[Fraction, ...]
Edges = tuple[Point, Point]  # of a box: lower, upper
Face = tuple[Point, Fraction]  # normal . x <= offset
Normal = tuple[tuple[int, ...], Point]  # with a multiplier for each half-space of the set


@dataclass(frozen=True, kw_only=True)
class Shape:
    """The hull of points, or where there are none a room that faces cut; about each point of that a box, and in the set's own
    dimensions a ball. In the others points and room are 0, and the box is the whole state space."""

    points: tuple[Point, ...]
    room: Edges
    faces: tuple[Face, ...]
    extent: Edges
    own: tuple[int, ...]
    radius: Fraction = Fraction(0)


@dataclass(frozen=True)
class Sets:
    """The unsafe sets of a task, and the half-spaces that cut its state space, less the body, and its target."""

    unsafe: tuple[Shape, ...]
    walls: tuple[Face, ...]
    goals: tuple[Face, ...]


def sets(data: bytes, task: checker.Task) -> Sets:
    """Those of a task that the stand-alone checker has read. Half-spaces of vertices, or within a ball, are the checker's."""
    n = task.n
    document = tomllib.loads(data.decode("utf-8-sig"), parse_float=Decimal)
    names = list(document.get("axes") or [f"x{i + 1}" for i in range(n)])
    body = document.get("body", 0)
    grown = _point(body) if isinstance(body, list) else (Fraction(body),) * n
    space = _point(document["state_space"]["lower"]), _point(document["state_space"]["upper"])
    unsafe = tuple(_shape(table, names, space, grown) for table in document.get("unsafe", []))
    walls = _faces(document["state_space"], names, grown) or _whole(task.walls)
    return Sets(unsafe, walls, _faces(document.get("target_set", {}), names, (Fraction(0),) * n) or _whole(task.goals))


def _whole(faces: Sequence[tuple[Sequence[int], Fraction]]) -> tuple[Face, ...]:
    return tuple((_point(normal), offset) for normal, offset in faces)


def _faces(table: dict[str, Any], names: list[str], body: Point) -> tuple[Face, ...]:
    own, found = [names.index(a) for a in table.get("axes", names)], []
    for normal, offset in zip(table.get("normals", []), table.get("offsets", []), strict=True):
        values = dict(zip(own, _point(normal), strict=True))
        face = tuple(values.get(i, Fraction(0)) for i in range(len(names)))
        found.append((face, Fraction(offset) - sum(abs(c) * h for c, h in zip(face, body, strict=True))))
    return tuple(found)


def _point(values: Sequence[Any]) -> Point:
    return tuple(map(Fraction, values))


def _shape(table: dict[str, Any], names: list[str], space: Edges, body: Point) -> Shape:
    own = [names.index(a) for a in table.get("axes", names)]
    zero = (Fraction(0),) * len(names)

    def laid(given: Sequence[Any], rest: Point = zero) -> Point:
        values = dict(zip(own, _point(given), strict=True))
        return tuple(values.get(i, v) for i, v in enumerate(rest))

    flat = [0] * len(own)
    lower, upper = laid(table.get("lower", flat), space[0]), laid(table.get("upper", flat), space[1])
    extent = tuple(a - h for a, h in zip(lower, body, strict=True)), tuple(b + h for b, h in zip(upper, body, strict=True))
    if "normals" in table:
        room = laid([space[0][i] for i in own]), laid([space[1][i] for i in own])
        faces = zip(map(laid, table["normals"]), _point(table["offsets"]), strict=True)
        return Shape(points=(), room=room, faces=tuple(faces), extent=extent, own=tuple(own))
    if not {"lower", "vertices", "segment", "centre"} & table.keys():
        raise checker.Unusable("the task has an unsafe set that is said in no way that is known here")
    told = table.get("vertices") or table.get("segment") or ([table["centre"]] if "centre" in table else [])
    return Shape(
        points=tuple(map(laid, told)),
        room=(zero, zero),
        faces=(),
        extent=extent,
        own=tuple(own),
        radius=Fraction(table.get("radius", 0)),
    )


def solid(shape: Shape) -> bool:
    """Whether it is a box alone."""
    return not shape.radius and not shape.points and not shape.faces


def normals(shape: Shape, hints: Any) -> tuple[Normal, ...]:
    """Those of the hints, [[from, to, normal], ..]; without half-spaces not those of the axes, which Coq tries by itself."""
    n = len(shape.extent[0])
    found = [tuple(hint[-1]) for hint in hints or [] if isinstance(hint, list) and hint and isinstance(hint[-1], list)]
    whole = [v for v in dict.fromkeys(found) if len(v) == n and all(type(c) is int for c in v)]
    return tuple((v, multipliers(shape, v)) for v in whole if shape.faces or sum(map(bool, v)) > 1)


def multipliers(shape: Shape, normal: Sequence[int]) -> Point:
    """Of the half-spaces, so that Coq's bound on the reach is the reach: those of the corner that is farthest along the normal,
    by the duality of linear programs."""
    if not shape.faces:
        return ()
    own, zero = shape.own, (Fraction(0),) * len(shape.own)
    sides = [((*zero[:k], Fraction(s), *zero[k + 1 :]), s * shape.room[s > 0][i]) for k, i in enumerate(own) for s in (-1, 1)]
    faces = [(tuple(face[i] for i in own), offset) for face, offset in shape.faces]
    best, most = (Fraction(0),) * len(faces), None
    for chosen in itertools.combinations(range(len(faces) + len(sides)), len(own)):
        rows = [[*faces, *sides][j] for j in chosen]
        shares = _solved([[face[k] for face, _ in rows] for k in range(len(own))], [Fraction(normal[i]) for i in own])
        if shares is None or min(shares) < 0:
            continue
        reach = sum((share * offset for share, (_, offset) in zip(shares, rows, strict=True)), Fraction(0))
        if most is None or reach < most:
            given = dict(zip(chosen, shares, strict=True))
            best, most = tuple(given.get(j, Fraction(0)) for j in range(len(faces))), reach
    return best


def _solved(rows: list[list[Fraction]], right: list[Fraction]) -> list[Fraction] | None:
    """The solution of as many equations as unknowns, by Gauss and Jordan; None where there is not one."""
    system = [[*row, b] for row, b in zip(rows, right, strict=True)]
    for k in range(len(system)):
        lead = next((r for r in range(k, len(system)) if system[r][k]), None)
        if lead is None:
            return None
        system[k], system[lead] = system[lead], system[k]
        system[k] = [v / system[k][k] for v in system[k]]
        for r, row in enumerate(system):
            if r != k and row[k]:
                system[r] = [v - row[k] * w for v, w in zip(row, system[k], strict=True)]
    return [row[-1] for row in system]
