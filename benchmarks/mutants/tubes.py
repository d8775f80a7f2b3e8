"""Mutants for `mutations.py`: certified tubes with a changed table, or their tasks made harder, by one random change each.

A mutation draws where it changes something and by how much. Entries of tables change by 1 to 2^20 units, every magnitude alike.
A requirement of the task (a set, an unsafe set, the clearance, ..) is changed to what the tube just meets, minus a drawn margin,
which is often 0 or one table unit. With a negative margin the tube is unsafe. `draw_mutant` draws a mutation, a tube to start
from, and the mutant. A mutant depends on the state of
the random generator only, so the order of draws is part of the benchmark.
"""

from __future__ import annotations

import contextlib
import itertools
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np

from benchmarks.fixed import limited
from benchmarks.oracles.cubics import smallest_value
from benchmarks.oracles.tubes import derivative, signed_edges, signed_faces
from benchmarks.suites.families import FAMILIES, arena_task
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.designs.tube import LOWER, UPPER
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import build_program, build_task
from stt_codegen.task.load import load_task
from stt_codegen.task.sets.shapes import Target, UnsafeBall, UnsafeCapsule, UnsafeHalfSpaces, UnsafePolytope, UnsafeSet, Waypoint
from stt_codegen.task.task import Task

TASKS = Path(__file__).parents[2] / "tasks"
BOX_ARENA_COUNTS = {"paper": 12, "dense12": 4, "space3": 1}
SHAPE_ARENA_COUNTS = {"discs": 6, "balls": 2, "polygons": 4, "solids": 1}
# omni_board is omni_s2 with ticks. Tasks of order 2 have mutants in order_two.py, a limit of u adds P8
# (tests/certify/test_limits.py), and missions add P10 (mission_mutants.py).
EXAMPLES = sorted(
    p.stem
    for p in TASKS.glob("*.toml")
    if p.stem != "omni_board" and not re.search(r"^(order = 2|u_max =|\[\[mission)", p.read_text(), re.M)
)
BOX_BASE_NAMES = (*EXAMPLES, *(f"{name} {seed}" for name, n in BOX_ARENA_COUNTS.items() for seed in range(n)))
ALL_BASE_NAMES = (*BOX_BASE_NAMES, *(f"{name} {seed}" for name, n in SHAPE_ARENA_COUNTS.items() for seed in range(n)))

# Radii of target balls, as multiples of the smallest ball that holds the tube's end.
RADIUS_FACTORS = (1, 1, *map(Fraction, ("1.003", "1.006", "1.05")))


class EdgeIndex(NamedTuple):
    """One of the 2 n edges of a tube. side: LOWER or UPPER."""

    dimension: int
    side: int


class Mutant(NamedTuple):
    """A task, and a design whose tube may violate the task."""

    task: Task
    design: RefinedDesign


@dataclass(frozen=True)
class BaseTube:
    """A certified tube that mutations start from, and its margins by the code of a property."""

    task: Task
    design: RefinedDesign
    margins: dict[str, Fraction]

    @property
    def body(self) -> tuple[Fraction, ...]:
        """Half the body's size by axis; 0 for a point."""
        return self.task.body or (Fraction(0),) * self.task.dimension


Mutation = Callable[[Random, BaseTube], Mutant]


@dataclass(frozen=True)
class DrawnMutant:
    """A mutant, the name of its mutation, and the tube that it was made from, with a name."""

    kind: str
    base_name: str
    base: BaseTube
    mutant: Mutant


@cache
def base_tube(name: str, scalar: str) -> BaseTube | None:
    """Return the certified tube of a task ("omni_s1") or an arena ("paper 3"); None where no tube is certified."""
    family, _, seed = name.partition(" ")
    task = arena_task(FAMILIES[family], int(seed)) if seed else load_task(TASKS / f"{name}.toml")
    if scalar == "fixed":  # a controller in integers needs a limit of u, and a tick
        task = limited(task)
    try:
        controller = build_task(task.with_options("refined", scalar))
    except NotCertified:
        return None
    assert isinstance(controller.design, RefinedDesign)
    margins = {finding.code: finding.margin for finding in controller.certificate.findings}
    return BaseTube(controller.task, controller.design, margins)


# ------------------------------------------------------------------------------------------------ drawing


def draw_change(rng: Random, bits: int) -> int:
    """Draw a whole number of 1 to 2^bits, every magnitude alike, with either sign."""
    return rng.choice((-1, 1)) * round(2 ** rng.uniform(0, bits))


def draw_margin(rng: Random, base: BaseTube) -> Fraction:
    """Draw the margin that a mutation leaves between tube and requirement: often 0 or one table unit, sometimes a part of a unit.

    A negative margin makes the tube violate the requirement."""
    units = rng.choice((0, rng.choice((-1, 1)), *[draw_change(rng, 10)] * 5))
    return units * base.design.unit / rng.choice((1, 1, 1, 256))


def draw_edge(rng: Random, base: BaseTube) -> EdgeIndex:
    return EdgeIndex(rng.randrange(base.task.dimension), rng.choice((LOWER, UPPER)))


def draw_entry(rng: Random, table: Any) -> tuple[int, int, int]:
    """Draw the index of a table's entry: row, dimension, side."""
    return rng.randrange(len(table)), rng.randrange(table.shape[1]), rng.randrange(2)


def floor_to_file(value: Fraction) -> Fraction:
    """Round down to a multiple of 2^-32, which a task file can state exactly; multiples of a table unit over 512 stay."""
    return Fraction(math.floor(value * (1 << 32)), 1 << 32)


def with_entry(values: Sequence[Fraction], i: int, value: Fraction) -> tuple[Fraction, ...]:
    """Return the values with another one at index i."""
    return (*values[:i], value, *values[i + 1 :])


def with_face(box: Any, i: int, side: int, face: Fraction) -> Any:
    """Return a box with another face. face: for LOWER the lower edge on axis i, for UPPER minus the upper edge."""
    key, value = ("lower", face) if side == LOWER else ("upper", -face)
    return box.model_copy(update={key: with_entry(getattr(box, key), i, value)})


def with_task(base: BaseTube, **change: Any) -> Mutant:
    """Return the base's tube for a changed task."""
    return Mutant(base.task.model_copy(update=change), base.design)


def with_tube_table(base: BaseTube, **change: Any) -> Mutant:
    """Return the base's tube for a task whose table `tube` is changed."""
    return with_task(base, tube=base.task.tube.model_copy(update=change))


def with_obstacle(base: BaseTube, obstacle: Any) -> Mutant:
    """Return the base's tube for a task with one more unsafe set."""
    return with_task(base, unsafe=(*base.task.unsafe, obstacle))


# ------------------------------------------------------------------------------------------------ changed tables


def table_mutation(change: Callable[[Random, Any], None]) -> Mutation:
    """Return a mutation that changes the table, an object array of shape (K + 3, n, 2), in place."""

    def mutate(rng: Random, base: BaseTube) -> Mutant:
        table = np.array(base.design.table, dtype=object)
        change(rng, table)
        rows = tuple(tuple((int(lower), int(upper)) for lower, upper in row) for row in table)
        return Mutant(base.task, replace(base.design, table=rows))

    return mutate


def change_entries(rng: Random, table: Any, count_at_most: int) -> None:
    for _ in range(rng.randint(1, count_at_most)):
        table[draw_entry(rng, table)] += draw_change(rng, rng.choice((5, 20)))


def swap_entries(rng: Random, table: Any) -> None:
    """Swap two entries of one dimension: at most two rows apart, and of the same edge or of opposite edges."""
    j, i, side = draw_entry(rng, table)
    second = min(j + rng.randint(0, 2), len(table) - 1), i, rng.choice((side, side, 1 - side))
    table[j, i, side], table[second] = table[second], table[j, i, side]


def shift_row(rng: Random, table: Any) -> None:
    """Shift both edges of a row, in one dimension or in all."""
    j, i, _ = draw_entry(rng, table)
    table[j, rng.choice((i, slice(None)))] += draw_change(rng, 20)


def repeat_row(rng: Random, table: Any) -> None:
    """Replace a row by a copy of its neighbour."""
    j = rng.randrange(1, len(table))
    target, source = rng.choice(((j, j - 1), (j - 1, j)))
    table[target] = table[source]


def dent_edges(rng: Random, table: Any) -> None:
    """Move entries toward the middle of the tube. The tube mostly stays safe, and its edges get extremes inside segments."""
    for _ in range(rng.randint(1, 4)):
        j, i, side = rng.randrange(3, len(table) - 3), *draw_entry(rng, table)[1:]
        table[j, i, side] += abs(draw_change(rng, 17)) * (1 if side == LOWER else -1)


def move_end(rng: Random, table: Any, rows: Sequence[int]) -> None:
    """Move one edge by the same amount in each of these rows."""
    _, i, side = draw_entry(rng, table)
    table[rows, i, side] += draw_change(rng, 10)


# ------------------------------------------------------------------------------------------------ harder tasks: boxes


def move_or_grow_obstacle(rng: Random, base: BaseTube) -> Mutant:
    """Move one unsafe set on one axis, or grow it."""
    j, i, by = (
        rng.randrange(len(base.task.unsafe)),
        rng.randrange(base.task.dimension),
        draw_change(rng, 20) * base.design.unit,
    )
    obstacle = base.task.unsafe[j]
    if isinstance(obstacle, UnsafeSet):
        low, high = signed_faces(obstacle)[i]
        faces = (low - abs(by), high - abs(by)) if rng.random() < 0.5 else (low + by, high - by)
        changed: Any = with_face(with_face(obstacle, i, LOWER, faces[LOWER]), i, UPPER, faces[UPPER])
    else:
        changed = _move_or_grow_shape(rng, obstacle, i, by)
    return with_task(base, unsafe=(*base.task.unsafe[:j], changed, *base.task.unsafe[j + 1 :]))


def _move_or_grow_shape(rng: Random, obstacle: Any, i: int, by: Fraction) -> Any:
    """Move some vertices of a polytope on one axis; move a round set on one axis, or grow it."""
    if isinstance(obstacle, UnsafePolytope):
        is_moved = [rng.random() < 0.5 for _ in obstacle.vertices]
        points = tuple(with_entry(p, i, p[i] + by) if moved else p for moved, p in zip(is_moved, obstacle.vertices, strict=True))
        return obstacle.model_copy(update={"vertices": points})
    if rng.random() < 0.5:
        return obstacle.model_copy(update={"radius": obstacle.radius + abs(by)})
    return obstacle.model_copy(update={"centre": with_entry(obstacle.centre, i, obstacle.centre[i] + by)})


def _with_box_beside(
    rng: Random, base: BaseTube, segment: int, s: Fraction, *, touched_edges: Sequence[EdgeIndex], size_bits: int
) -> Mutant:
    """Add an unsafe box whose distance from each touched edge, at s of a segment, is the required one plus a drawn margin.

    On the axes without a touched edge it overlaps the tube. It is up to 2^size_bits units larger than that."""
    faces = []
    for i, cubics in enumerate(signed_edges(base.design)[segment].tolist()):
        signed_ends = [floor_to_file(sum(a * s**p for p, a in enumerate(cubic)) * base.design.unit) for cubic in cubics]
        sizes = [abs(draw_change(rng, size_bits)) * base.design.unit for _ in range(2)]
        pair = [signed_ends[LOWER] - sizes[0], -signed_ends[UPPER] + sizes[1]]
        for side in [side for axis, side in touched_edges if axis == i]:
            near_face = signed_ends[side] - base.body[i] - base.task.tube.clearance - draw_margin(rng, base)
            pair = [near_face - sizes[0], near_face] if side == LOWER else [-near_face, -near_face + sizes[0]]
        faces.append(pair)
    lower, upper = zip(*faces, strict=True)
    return with_obstacle(base, UnsafeSet(name="added", lower=lower, upper=upper))


def add_box_at_extreme(rng: Random, base: BaseTube) -> Mutant:
    """Add an unsafe box beside an edge of the tube, at the outermost point that the edge reaches over some segments."""
    edge, last_segment = draw_edge(rng, base), base.design.segments - 1
    k = rng.choice((0, last_segment, *[rng.randint(0, last_segment)] * 4))
    neighbours = rng.choice((0, 1, 4, 64))
    first_segment = max(0, k - neighbours)
    extreme = smallest_value(signed_edges(base.design)[first_segment : k + neighbours + 1, edge.dimension, edge.side])
    size_bits = rng.choice((4, 12, 20))
    segment = first_segment + extreme.cubic
    return _with_box_beside(rng, base, segment, extreme.s, touched_edges=[edge], size_bits=size_bits)


def add_box_in_corner(rng: Random, base: BaseTube) -> Mutant:
    """Add an unsafe box whose corner the tube rounds: at one s an edge moves toward the box, and an edge of another dimension
    moves away from it."""
    k, s = rng.randrange(base.design.segments), Fraction(rng.randint(0, 8), 8)
    slopes = {
        EdgeIndex(i, side): linear + 2 * quadratic * s + 3 * cubic * s * s
        for i, pair in enumerate(signed_edges(base.design)[k].tolist())
        for side, (_, linear, quadratic, cubic) in enumerate(pair)
    }
    arriving = rng.choice([edge for edge, slope in slopes.items() if slope < 0])
    leaving = rng.choice([edge for edge, slope in slopes.items() if slope > 0 and edge.dimension != arriving.dimension])
    return _with_box_beside(rng, base, k, s, touched_edges=[arriving, leaving], size_bits=rng.choice((8, 20)))


def add_box_anywhere(rng: Random, base: BaseTube) -> Mutant:
    """Add an unsafe box of any size, thin ones too, beside the tube at any time."""
    touched_edges = [EdgeIndex(i, rng.randrange(2)) for i in rng.sample(range(base.task.dimension), rng.randint(1, 2))]
    k, s = rng.randrange(base.design.segments), Fraction(rng.randint(0, 8), 8)
    return _with_box_beside(rng, base, k, s, touched_edges=touched_edges, size_bits=rng.choice((1, 20)))


# ------------------------------------------------------------------------------------------------ harder tasks: shapes


def _draw_axes(rng: Random, base: BaseTube) -> list[int]:
    """Draw the indices of the axes that a new set bounds: two or three, or all axes of a task with fewer."""
    n = base.task.dimension
    d = min(n, rng.choice((2, 2, 3)))
    return sorted(rng.sample(range(n), d))


def _axis_names(base: BaseTube, axes: Sequence[int]) -> tuple[str, ...]:
    names = base.task.axes or tuple(f"x{i + 1}" for i in range(base.task.dimension))
    return tuple(names[i] for i in axes)


@dataclass(frozen=True)
class _TouchedCorner:
    """A corner of the tube's box at one time, and an outward normal of a plane through the corner, on some axes.

    The box is grown by body and clearance, and shrunk by a drawn margin. names: of the axes; None if they are all axes."""

    axes: list[int]
    names: tuple[str, ...] | None
    corner: list[Fraction]
    outward: list[int]

    @property
    def length(self) -> float:
        return math.sqrt(sum(v * v for v in self.outward))

    def draw_point_beyond(self, rng: Random, reach: float) -> tuple[Fraction, ...]:
        """Draw a point up to `reach` away from the corner, in the plane or beyond it."""
        step = [rng.uniform(-reach, reach) for _ in self.outward]
        along = sum(v * w for v, w in zip(step, self.outward, strict=True)) / self.length**2
        correction = rng.choice((0.0, abs(along))) - along  # puts the point in the plane or beyond it; in multiples of the normal
        return tuple(
            floor_to_file(c + Fraction(v + correction * w)) for c, v, w in zip(self.corner, step, self.outward, strict=True)
        )


def _draw_touched_corner(rng: Random, base: BaseTube) -> _TouchedCorner:
    """Draw a corner of the tube, mostly at the time at which the tube reaches farthest along the normal.

    Then a set beyond the plane cannot meet the tube at another time."""
    n, k, s = base.task.dimension, rng.randrange(base.design.segments), Fraction(rng.randint(0, 8), 8)
    axes = _draw_axes(rng, base)
    signs, sizes = [rng.choice((-1, 1)) for _ in axes], [rng.randint(0, 9) for _ in axes]
    sizes[rng.randrange(len(axes))] = rng.randint(1, 9)
    outward, distance = [v * w for v, w in zip(signs, sizes, strict=True)], base.task.tube.clearance - draw_margin(rng, base)
    sides = [(i, UPPER if sign > 0 else LOWER) for i, sign in zip(axes, signs, strict=True)]
    edges = signed_edges(base.design)
    if rng.random() < 0.8:
        minus_height = sum(v * edges[:, i, side] for v, (i, side) in zip(sizes, sides, strict=True))
        k, s, _ = smallest_value(minus_height[j] for j in range(len(edges)))
        s = Fraction(round(s * 64), 64)
    corner = []
    for (i, side), sign in zip(sides, signs, strict=True):
        signed_end = floor_to_file(sum(int(a) * s**p for p, a in enumerate(edges[k, i, side])) * base.design.unit)
        corner.append((-signed_end if side == UPPER else signed_end) + sign * (base.body[i] + distance))
    return _TouchedCorner(axes, None if len(axes) == n else _axis_names(base, axes), corner, outward)


def add_shape_beside(rng: Random, base: BaseTube, shape: str) -> Mutant:
    """Add a ball, capsule, polytope or half-spaces whose distance from the tube is the required one plus a drawn margin.

    The set is beyond a plane through the touched corner, and one point of the set is in the plane."""
    touched = _draw_touched_corner(rng, base)
    size = rng.choice((0.01, 0.3, 2.0))
    radius = floor_to_file(Fraction(rng.uniform(0.1, 1) * size)) + Fraction(1, 1 << 32)
    centre = tuple(
        floor_to_file(c + Fraction(float(radius) * v / touched.length))
        for c, v in zip(touched.corner, touched.outward, strict=True)
    )
    added: Any
    if shape == "ball":
        added = UnsafeBall(name="added", axes=touched.names, centre=centre, radius=radius)
    elif shape == "capsule":
        beyond = touched.draw_point_beyond(rng, size)
        far_end = tuple(c + v - w for c, v, w in zip(centre, beyond, touched.corner, strict=True))
        added = UnsafeCapsule(name="added", axes=touched.names, segment=(centre, far_end), radius=radius)
    elif shape == "polytope":
        count = rng.randint(len(touched.axes), 6)
        points = (tuple(touched.corner), *(touched.draw_point_beyond(rng, size) for _ in range(count)))
        added = UnsafePolytope(name="added", axes=touched.names, vertices=points)
    else:
        added = _draw_half_spaces(rng, touched)
    return with_obstacle(base, added)


def _draw_half_spaces(rng: Random, touched: _TouchedCorner) -> UnsafeHalfSpaces:
    """Draw the set beyond the plane, cut by up to three half-spaces that contain the corner."""

    def at_corner(normal: Sequence[Any]) -> Fraction:
        return sum((v * c for v, c in zip(normal, touched.corner, strict=True)), Fraction(0))

    normals, offsets = [tuple(Fraction(-v) for v in touched.outward)], [-at_corner(touched.outward)]
    for _ in range(rng.randint(0, 3)):
        normals.append(tuple(Fraction(rng.randint(-5, 5)) for _ in touched.outward))
        offsets.append(at_corner(normals[-1]) + floor_to_file(Fraction(rng.random())))
    return UnsafeHalfSpaces(name="added", axes=touched.names, normals=tuple(normals), offsets=tuple(offsets))


def make_target_ball(rng: Random, base: BaseTube) -> Mutant:
    """Make the target a ball about a drawn centre. Its radius is the smallest that contains the tube's end, or slightly larger,
    minus a drawn margin."""
    axes = _draw_axes(rng, base)
    edges = signed_edges(base.design)
    last = [[int(edges[-1, i, side].sum()) * base.design.unit for side in (LOWER, UPPER)] for i in axes]
    centre = tuple(floor_to_file(Fraction(rng.uniform(float(low), -float(high)))) for low, high in last)
    farthest = math.sqrt(sum(max(c - low, -high - c) ** 2 for c, (low, high) in zip(centre, last, strict=True)))
    radius = floor_to_file(Fraction(farthest) * rng.choice(RADIUS_FACTORS) - draw_margin(rng, base))
    return with_task(base, target_set=Target(axes=_axis_names(base, axes), centre=centre, radius=radius))


def cut_region(rng: Random, base: BaseTube, as_hull: bool) -> Mutant:
    """Cut state space or target along a plane that the tube touches but for a drawn margin.

    as_hull: the cut is a polytope with that plane as a face; otherwise it is a half-space."""
    axes = _draw_axes(rng, base)
    edges = signed_edges(base.design)
    name = rng.choice(("state_space", "target_set"))
    outward = [rng.randint(-9, 9) for _ in axes]
    outward[rng.randrange(len(axes))] = rng.choice((-1, 1)) * rng.randint(1, 9)
    sides = [(i, UPPER if v > 0 else LOWER) for i, v in zip(axes, outward, strict=True)]
    minus_height = sum(abs(v) * edges[:, i, side] for v, (i, side) in zip(outward, sides, strict=True))
    extreme, body = Fraction(int(minus_height[-1].sum())), Fraction(0)
    if name == "state_space":
        extreme = smallest_value(minus_height).value
        body = sum((abs(v) * base.body[i] for i, v in zip(axes, outward, strict=True)), Fraction(0))
    offset = floor_to_file(body - extreme * base.design.unit) - draw_margin(rng, base)
    region = getattr(base.task, name)
    cut: dict[str, Any] = {"axes": _axis_names(base, axes)}
    if as_hull:
        bounds = [(region.lower[i] - 100, region.upper[i] + 100) for i in axes]
        cut["vertices"] = _cut_corners(list(itertools.product(*bounds)), outward, offset)
    else:
        cut |= {"normals": (tuple(map(Fraction, outward)),), "offsets": (offset,)}
    return with_task(base, **{name: region.model_copy(update=cut)})


def _cut_corners(corners: Sequence[tuple[Fraction, ...]], normal: Sequence[int], offset: Fraction) -> tuple[Any, ...]:
    """Return the corners; those beyond the plane are moved onto it, along the axis of the normal's largest component."""
    k = max(range(len(normal)), key=lambda i: abs(normal[i]))
    points = []
    for corner in corners:
        beyond = sum((v * c for v, c in zip(normal, corner, strict=True)), Fraction(0)) - offset
        points.append(with_entry(corner, k, floor_to_file(corner[k] - beyond / normal[k])) if beyond > 0 else corner)
    return tuple(points)


def add_timed_set(rng: Random, base: BaseTube, feature: str) -> Mutant:
    """Add a set beside the tube as `add_shape_beside` does, which moves, grows, or has an active interval or timing uncertainty.

    At one time it is where `add_shape_beside` puts it; before and after that it is elsewhere. Sometimes it stands still.
    feature: "motion", "window", "timing" or "spread"."""
    task, _ = add_shape_beside(rng, base, rng.choice(("ball", "polytope", "capsule")))
    added: Any = task.unsafe[-1]
    t_c, d = task.prescribed_time, len(added.axes or task.axis_names)
    times = sorted(floor_to_file(t_c * Fraction(rng.randint(0, 64), 64)) for _ in range(rng.randint(1, 4)))
    times = sorted(set(times))
    reach = rng.choice((1e-4, 0.05, 0.5, 3.0))
    displacements = [tuple(floor_to_file(Fraction(rng.uniform(-reach, reach))) for _ in range(d)) for _ in times]
    displacements[rng.randrange(len(times))] = (Fraction(0),) * d
    if rng.random() < 0.3:
        displacements = [(Fraction(0),) * d for _ in times]
    change: dict[str, Any] = {"motion": tuple(Waypoint(at=a, by=p) for a, p in zip(times, displacements, strict=True))}
    if feature == "window" or rng.random() < 0.2:
        begin, end = sorted(rng.sample(range(65), 2))
        change["during"] = (floor_to_file(t_c * Fraction(begin, 64)), floor_to_file(t_c * Fraction(end, 64)))
        if feature == "window":
            del change["motion"]
    start_delay = Fraction(0)
    if feature == "timing":
        change["timing"] = floor_to_file(t_c * Fraction(rng.choice((0, 1, 3, 20)), 200))
        start_delay = floor_to_file(t_c * Fraction(rng.choice((0, 1, 3, 20)), 200))
    if feature == "spread":
        change["spread"] = floor_to_file(Fraction(rng.choice((1e-6, 1e-3, 0.05))))
    unsafe = (*task.unsafe[:-1], added.model_copy(update=change))
    return Mutant(task.model_copy(update={"unsafe": unsafe, "start_delay": start_delay}), base.design)


# ----------------------------------------------------------------------------------------------- harder tasks: other requirements


def move_set_face(rng: Random, base: BaseTube) -> Mutant:
    """Put a face of start, target or state space where the tube has its extreme."""
    (i, side), name = draw_edge(rng, base), rng.choice(("initial_set", "target_set", "state_space"))
    cubics = signed_edges(base.design)[:, i, side]
    extreme, body = Fraction(int(cubics[0, 0] if name == "initial_set" else cubics[-1].sum())), Fraction(0)
    if name == "state_space":
        extreme, body = smallest_value(cubics).value, base.body[i]
    face = floor_to_file(extreme * base.design.unit) - body - draw_margin(rng, base)
    return with_task(base, **{name: with_face(getattr(base.task, name), i, side, face)})


def move_initial_state(rng: Random, base: BaseTube) -> Mutant:
    """Put the initial state inside an edge of the tube, at the distance of a drawn margin."""
    i, side = draw_edge(rng, base)
    signed_value = int(signed_edges(base.design)[0, i, side, 0]) * base.design.unit + draw_margin(rng, base)
    value = signed_value if side == LOWER else -signed_value
    return with_task(base, initial_state=with_entry(base.task.initial_state, i, value))


def raise_clearance(rng: Random, base: BaseTube) -> Mutant:
    return with_tube_table(base, clearance=floor_to_file(base.task.tube.clearance + base.margins["P4"] - draw_margin(rng, base)))


def raise_min_width(rng: Random, base: BaseTube) -> Mutant:
    smallest_width = smallest_value(-signed_edges(base.design).sum(axis=2).reshape(-1, 4)).value
    return with_tube_table(base, min_width=floor_to_file(smallest_width * base.design.unit) - draw_margin(rng, base))


def grow_body(rng: Random, base: BaseTube) -> Mutant:
    """Grow the body on one axis by the smaller margin of P3 and P4, minus a drawn margin."""
    i = rng.randrange(base.task.dimension)
    margin = min(base.margins["P3"], base.margins["P4"])
    return with_task(base, body=with_entry(base.body, i, floor_to_file(base.body[i] + margin - draw_margin(rng, base))))


def bound_speed(rng: Random, base: BaseTube) -> Mutant:
    return with_tube_table(base, max_speed=_draw_derivative_bound(rng, base, 1))


def bound_acceleration(rng: Random, base: BaseTube) -> Mutant:
    return with_tube_table(base, max_acceleration=_draw_derivative_bound(rng, base, 2))


def _draw_derivative_bound(rng: Random, base: BaseTube, order: int) -> Fraction | tuple[Fraction, ...]:
    """Draw a bound near the largest derivative of that order, a little above or below: one number, or one for each axis."""
    derivatives = signed_edges(base.design)
    for _ in range(order):
        derivatives = derivative(derivatives)
    scale = base.design.unit * (base.design.segments / base.design.prescribed_time) ** order
    by_axis = [derivatives[:, i].reshape(-1, 4) for i in range(base.design.dimension)]
    peaks = [-min(smallest_value(cubics).value, smallest_value(-cubics).value) * scale for cubics in by_axis]
    smallest_peak = max(peaks) / 1000  # an axis that stands still needs a positive bound too
    bounds = [max(v, smallest_peak) * (1 + rng.choice((-1, 1)) * Fraction(2) ** rng.randint(-20, -4)) for v in peaks]
    return tuple(map(floor_to_file, bounds)) if rng.randrange(2) else floor_to_file(max(bounds))


def dent_then_harden(rng: Random, base: BaseTube) -> Mutant:
    """Dent the tube, then change a requirement to what the dented tube just meets."""
    dented = replace(base, design=table_mutation(dent_edges)(rng, base).design)
    return rng.choice((add_box_at_extreme, add_box_in_corner, move_set_face, raise_min_width))(rng, dented)


MUTATIONS: dict[str, Mutation] = {
    "one coefficient": table_mutation(partial(change_entries, count_at_most=1)),
    "several coefficients": table_mutation(partial(change_entries, count_at_most=8)),
    "entries swapped": table_mutation(swap_entries),
    "row shifted": table_mutation(shift_row),
    "row repeated": table_mutation(repeat_row),
    "kink at the end": table_mutation(partial(move_end, rows=[-1])),
    "end moved": table_mutation(partial(move_end, rows=[-1, -3])),
    "dented, then harder": dent_then_harden,
    "obstacle moved or grown": move_or_grow_obstacle,
    "obstacle added": add_box_anywhere,
    "obstacle before a face": add_box_at_extreme,
    "obstacle in a corner": add_box_in_corner,
    "set moved": move_set_face,
    "initial state moved": move_initial_state,
    "clearance": raise_clearance,
    "least width": raise_min_width,
    "body": grow_body,
    "speed bound": bound_speed,
    "acceleration bound": bound_acceleration,
    "ball beside": partial(add_shape_beside, shape="ball"),
    "capsule beside": partial(add_shape_beside, shape="capsule"),
    "polytope beside": partial(add_shape_beside, shape="polytope"),
    "half-spaces beside": partial(add_shape_beside, shape="half-spaces"),
    "wall beside": partial(cut_region, as_hull=False),
    "hull beside": partial(cut_region, as_hull=True),
    "target ball beside": make_target_ball,
    "motion beside": partial(add_timed_set, feature="motion"),
    "window beside": partial(add_timed_set, feature="window"),
    "timing beside": partial(add_timed_set, feature="timing"),
    "spread beside": partial(add_timed_set, feature="spread"),
}


TIMED_SET_KINDS = ("motion beside", "window beside", "timing beside", "spread beside")
SHAPE_KINDS = tuple(kind for kind in MUTATIONS if kind.endswith(" beside") and kind not in TIMED_SET_KINDS)  # no boxes


def draw_mutant(
    rng: Random,
    names: Sequence[str],
    kinds: Sequence[str] = tuple(MUTATIONS),
    scalars: Sequence[str] = ("float", "double"),
) -> DrawnMutant:
    """Draw a mutation of these kinds, a base of these names, and a well-formed mutant.

    A mutant is drawn again if its task is not well-formed (a box with lower > upper, for instance), if a coefficient does not fit
    the table's format, or if a statement of a controller in integers needs more bits than its integers have."""
    kind = rng.choice(list(kinds))
    for _ in range(1000):
        name, scalar = rng.choice(names), rng.choice(scalars)
        base = base_tube(name, scalar)
        with contextlib.suppress(ValueError, IndexError, BadInput):
            if base is not None and is_well_formed((mutant := MUTATIONS[kind](rng, base)).task):
                if scalar == "fixed":
                    build_program(*mutant)
                return DrawnMutant(kind, f"{name}, {scalar}", base, mutant)
    raise RuntimeError(f"no mutant of the kind {kind!r} from {', '.join(names)}")


def is_well_formed(task: Task) -> bool:
    """Return whether a task file may state this: no set is empty, and sizes are positive. Raises ValueError if an unsafe set is
    outside the state space."""
    boxes = [task.state_space, task.initial_set, *([task.target_set] if task.target_set.lower else [])]
    if task.state_space.problem() or task.target_set.problem():
        return False
    boxes += [s for s in task.unsafe if isinstance(s, UnsafeSet)]
    for s in task.unsafe:
        if s.problem():
            return False
        s.to_set_in(task.state_space, task.axis_indices(s))
    sizes = (*(b - a for box in boxes for a, b in zip(box.lower, box.upper, strict=True)), *(task.max_speed or (1,)))
    return min(sizes) > 0 and min(task.tube.clearance, task.tube.min_width, *(task.body or ())) >= 0
