"""The sets of a task as proof/Sets.v and proof/Tube.v have them, and the certificate's normals for the unsafe ones.

The sets are those that the stand-alone checker reads. Where a theorem is about the whole C, Coq reads the task's text by itself
and compares. It believes no normal: a normal of a set that half-spaces cut comes with multipliers, which prove how far the set
reaches along it. theorem/reading.py calls this.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from stt_codegen.checker.stt_checker.exact import require
from stt_codegen.checker.stt_checker.sets import HalfSpace as CheckedHalfSpace
from stt_codegen.checker.stt_checker.sets import Obstacle, spread_over
from stt_codegen.checker.stt_checker.task import Task
from stt_codegen.task.sets import inscribed

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


@dataclass(frozen=True, kw_only=True)
class TaskSets:
    """The boxes of a task, its unsafe sets, and the half-spaces that cut its state space (`walls`) and its target (`goals`).

    The state space is shrunk by the body. Of a ball as target, `target` is the box about it, and all that is within `goals` is
    within the ball.
    """

    space: Edges
    start: Edges
    target: Edges
    unsafe: tuple[Shape, ...]
    walls: tuple[HalfSpace, ...]
    goals: tuple[HalfSpace, ...]


def sets_of(task: Task) -> TaskSets:
    """Return the sets of a task with a target, as the stand-alone checker has read them."""
    n, inside = task.n, task.target
    assert inside is not None
    space = _box_of(task.space.faces[: 2 * n])  # the checker lists the faces of a box first
    has_box = len(inside.faces) >= 2 * n
    target, goals = _box_of(inside.faces[: 2 * n]), _half_spaces(inside.faces[2 * n :])
    if inside.ball is not None:
        (centre, radius), axes = inside.ball, inside.axes
        within_ball = inscribed(tuple(centre), radius)
        goals += _half_spaces([(spread_over(axes, [Fraction(c) for c in v], n), offset) for v, offset in within_ball])
        if not has_box:
            by_axis = dict(zip(axes, centre, strict=True))
            target = (
                tuple(by_axis[i] - radius if i in by_axis else v for i, v in enumerate(space[0])),
                tuple(by_axis[i] + radius if i in by_axis else v for i, v in enumerate(space[1])),
            )
    unsafe = tuple(shape_of(obstacle) for obstacle in task.unsafe)
    start = tuple(task.start[0]), tuple(task.start[1])
    walls = _half_spaces(task.space.faces[2 * n :])
    return TaskSets(space=space, start=start, target=target, unsafe=unsafe, walls=walls, goals=goals)


def _half_spaces(faces: Sequence[CheckedHalfSpace]) -> tuple[HalfSpace, ...]:
    return tuple((tuple(normal), offset) for normal, offset in faces)


def _box_of(faces: Sequence[CheckedHalfSpace]) -> Edges:
    """Return the box of faces that come in pairs, x_i <= b and -x_i <= -a."""
    return tuple(-offset for _, offset in faces[1::2]), tuple(offset for _, offset in faces[::2])


def shape_of(obstacle: Obstacle) -> Shape:
    """Return an unsafe set of the stand-alone checker, which has the state space about each point in free dimensions."""
    axes, n = obstacle.axes, len(obstacle.half)
    free_axes = [i for i in range(n) if i not in axes]
    is_box = not obstacle.faces and any(obstacle.half[i] for i in axes)
    edges = [[v + side * h for v, h in zip(obstacle.points[0], obstacle.half, strict=True)] for side in (-1, 1)]
    lower, upper = (_with_zeros(edge, range(n) if is_box else free_axes) for edge in edges)
    points, cut_axes = ([], axes) if obstacle.faces else ([] if is_box else obstacle.points, [])
    return Shape(
        points=tuple(_with_zeros(point, axes) for point in points),
        core_box=(_with_zeros(edges[0], cut_axes), _with_zeros(edges[1], cut_axes)),
        half_spaces=_half_spaces(obstacle.faces),
        box_about_points=(
            tuple(a - h for a, h in zip(lower, obstacle.body, strict=True)),
            tuple(b + h for b, h in zip(upper, obstacle.body, strict=True)),
        ),
        axes=tuple(axes),
        radius=obstacle.radius,
    )


def _with_zeros(values: Sequence[Fraction], axes: Sequence[int]) -> Point:
    """Return a vector with 0 in place of the values in all other dimensions."""
    return tuple(v if i in axes else Fraction(0) for i, v in enumerate(values))


def is_box(shape: Shape) -> bool:
    """Whether the set is `box_about_points` alone, with no core and no ball."""
    return not shape.radius and not shape.points and not shape.half_spaces


def usable_normals(shape: Shape, hints: Any) -> tuple[Normal, ...]:
    """Return the normals of a claim's hints [from, to, normal] or [from, to, normal, multipliers], each once.

    Without half-spaces, normals along an axis are left out: Coq tries these by itself. Raises `Refused` for other hints.
    """
    n, normals = len(shape.box_about_points[0]), dict[Normal, None]()
    for _, _, normal, *multipliers in hints or []:
        require(len(normal) == n and all(type(c) is int for c in normal), "a hint has no normal of whole numbers")
        bounds = tuple(Fraction(v) for v in multipliers[0]) if multipliers else ()
        require(len(bounds) == len(shape.half_spaces), "a hint does not have a multiplier for every half-space")
        if shape.half_spaces or sum(map(bool, normal)) > 1:
            normals[tuple(normal), bounds] = None
    return tuple(normals)
