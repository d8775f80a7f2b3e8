"""Unsafe sets as proof/Sets.v has them, read from the task's text, and the certificate's normals for them.

Coq reads the sets itself and believes no normal. A normal of a set that half-spaces cut comes with multipliers, which prove how
far the set reaches along it. theorem/reading.py calls this.
"""

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
HalfSpace = tuple[Point, Fraction]  # (normal, offset): normal . x <= offset
Normal = tuple[tuple[int, ...], Point]  # with a multiplier for each half-space of the set


@dataclass(frozen=True, kw_only=True)
class Shape:
    """An unsafe set: a core, plus a box about each of its points, plus a ball in the set's dimensions.

    The core is the hull of `points`; without points it is `core_box`, cut by `half_spaces`. axes: the dimensions that the set
    bounds, from 0. In all other dimensions the core is 0. `box_about_points` is the box about each point of the core, grown by
    the body; in dimensions that the set does not bound it is the state space, grown by the body.
    """

    points: tuple[Point, ...]
    core_box: Edges
    half_spaces: tuple[HalfSpace, ...]
    box_about_points: Edges
    axes: tuple[int, ...]
    radius: Fraction = Fraction(0)


@dataclass(frozen=True)
class TaskSets:
    """The unsafe sets of a task, and the half-spaces that cut its state space (shrunk by the body) and its target."""

    unsafe: tuple[Shape, ...]
    walls: tuple[HalfSpace, ...]
    goals: tuple[HalfSpace, ...]


def read_sets(data: bytes, task: checker.Task) -> TaskSets:
    """Read the sets of a task file that the stand-alone checker has read as `task`.

    Half-spaces that the file states by vertices, or as a ball, are those of the checker.
    """
    n = task.n
    document = tomllib.loads(data.decode("utf-8-sig"), parse_float=Decimal)
    names = list(document.get("axes") or [f"x{i + 1}" for i in range(n)])
    body = document.get("body", 0)
    body_half_widths = _point(body) if isinstance(body, list) else (Fraction(body),) * n
    space = _point(document["state_space"]["lower"]), _point(document["state_space"]["upper"])
    unsafe = tuple(_read_shape(table, names, space, body_half_widths) for table in document.get("unsafe", []))
    walls = _read_half_spaces(document["state_space"], names, body_half_widths) or _exact_half_spaces(task.walls)
    target, no_body = document.get("target_set", {}), (Fraction(0),) * n
    return TaskSets(unsafe, walls, _read_half_spaces(target, names, no_body) or _exact_half_spaces(task.goals))


def _exact_half_spaces(half_spaces: Sequence[tuple[Sequence[int], Fraction]]) -> tuple[HalfSpace, ...]:
    return tuple((_point(normal), offset) for normal, offset in half_spaces)


def _read_half_spaces(table: dict[str, Any], names: list[str], body: Point) -> tuple[HalfSpace, ...]:
    """Return the half-spaces of a table with `normals` and `offsets`, in all dimensions, moved inwards by the body."""
    axes = [names.index(axis) for axis in table.get("axes", names)]
    half_spaces = []
    for axes_normal, offset in zip(table.get("normals", []), table.get("offsets", []), strict=True):
        by_axis = dict(zip(axes, _point(axes_normal), strict=True))
        normal = tuple(by_axis.get(i, Fraction(0)) for i in range(len(names)))
        body_reach = sum(abs(c) * h for c, h in zip(normal, body, strict=True))
        half_spaces.append((normal, Fraction(offset) - body_reach))
    return tuple(half_spaces)


def _point(values: Sequence[Any]) -> Point:
    return tuple(map(Fraction, values))


def _read_shape(table: dict[str, Any], names: list[str], space: Edges, body: Point) -> Shape:
    """Return the set of an `unsafe` table, grown by the body. Raises `checker.Unusable` for a form that is not known."""
    axes = [names.index(axis) for axis in table.get("axes", names)]
    zero = (Fraction(0),) * len(names)

    def in_all_dimensions(values: Sequence[Any], elsewhere: Point = zero) -> Point:
        by_axis = dict(zip(axes, _point(values), strict=True))
        return tuple(by_axis.get(i, v) for i, v in enumerate(elsewhere))

    axes_zero = [0] * len(axes)
    lower = in_all_dimensions(table.get("lower", axes_zero), space[0])
    upper = in_all_dimensions(table.get("upper", axes_zero), space[1])
    box_about_points = (
        tuple(a - h for a, h in zip(lower, body, strict=True)),
        tuple(b + h for b, h in zip(upper, body, strict=True)),
    )
    if "normals" in table:
        core_box = in_all_dimensions([space[0][i] for i in axes]), in_all_dimensions([space[1][i] for i in axes])
        half_spaces = tuple(zip(map(in_all_dimensions, table["normals"]), _point(table["offsets"]), strict=True))
        return Shape(points=(), core_box=core_box, half_spaces=half_spaces, box_about_points=box_about_points, axes=tuple(axes))
    if not {"lower", "vertices", "segment", "centre"} & table.keys():
        raise checker.Unusable("the task has an unsafe set of a form that is not known here")
    core_points = table.get("vertices") or table.get("segment") or ([table["centre"]] if "centre" in table else [])
    return Shape(
        points=tuple(map(in_all_dimensions, core_points)),
        core_box=(zero, zero),
        half_spaces=(),
        box_about_points=box_about_points,
        axes=tuple(axes),
        radius=Fraction(table.get("radius", 0)),
    )


def is_box(shape: Shape) -> bool:
    """Whether the set is `box_about_points` alone, with no core and no ball."""
    return not shape.radius and not shape.points and not shape.half_spaces


def usable_normals(shape: Shape, hints: Any) -> tuple[Normal, ...]:
    """Return the normals of the certificate's hints [[from, to, normal], ..], with their multipliers.

    Without half-spaces, normals along an axis are left out: Coq tries these by itself.
    """
    n = len(shape.box_about_points[0])
    hinted = [tuple(hint[-1]) for hint in hints or [] if isinstance(hint, list) and hint and isinstance(hint[-1], list)]
    integer_normals = [v for v in dict.fromkeys(hinted) if len(v) == n and all(type(c) is int for c in v)]
    return tuple((v, half_space_multipliers(shape, v)) for v in integer_normals if shape.half_spaces or sum(map(bool, v)) > 1)


def half_space_multipliers(shape: Shape, normal: Sequence[int]) -> Point:
    """Return a multiplier >= 0 for each half-space, with which Coq's bound on the set's reach along the normal is the reach.

    By the duality of linear programs they belong to the core's farthest corner. Every choice of as many bounds as dimensions is
    tried.
    """
    if not shape.half_spaces:
        return ()
    axes, zero = shape.axes, (Fraction(0),) * len(shape.axes)
    box_bounds = [
        ((*zero[:k], Fraction(s), *zero[k + 1 :]), s * shape.core_box[s > 0][i]) for k, i in enumerate(axes) for s in (-1, 1)
    ]
    bounds = [*((tuple(n[i] for i in axes), offset) for n, offset in shape.half_spaces), *box_bounds]
    count = len(shape.half_spaces)
    best, smallest_reach = (Fraction(0),) * count, None
    for chosen in itertools.combinations(range(len(bounds)), len(axes)):
        chosen_bounds = [bounds[j] for j in chosen]
        columns = [[bound_normal[k] for bound_normal, _ in chosen_bounds] for k in range(len(axes))]
        multipliers = _solve_linear_system(columns, [Fraction(normal[i]) for i in axes])
        if multipliers is None or min(multipliers) < 0:
            continue
        reach = sum((m * offset for m, (_, offset) in zip(multipliers, chosen_bounds, strict=True)), Fraction(0))
        if smallest_reach is None or reach < smallest_reach:
            by_bound = dict(zip(chosen, multipliers, strict=True))
            best, smallest_reach = tuple(by_bound.get(j, Fraction(0)) for j in range(count)), reach
    return best


def _solve_linear_system(rows: list[list[Fraction]], right: list[Fraction]) -> list[Fraction] | None:
    """Solve as many equations as unknowns by Gauss-Jordan elimination; None where the solution is not unique."""
    system = [[*row, b] for row, b in zip(rows, right, strict=True)]
    for k in range(len(system)):
        pivot = next((r for r in range(k, len(system)) if system[r][k]), None)
        if pivot is None:
            return None
        system[k], system[pivot] = system[pivot], system[k]
        system[k] = [v / system[k][k] for v in system[k]]
        for r, row in enumerate(system):
            if r != k and row[k]:
                system[r] = [v - row[k] * w for v, w in zip(row, system[k], strict=True)]
    return [row[-1] for row in system]
