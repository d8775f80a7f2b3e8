"""Mutants for `mutations.py`: certified tubes bent, or their tasks made harder, from a generator of random numbers.

A mutation draws where and how much. Tables are bent by 1 to 2^20 units, every magnitude alike. Demands of the task (sets,
unsafe sets, clearance, ...) are put where the tube has its exact extreme, less a slack that is often nothing or one unit.
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
from typing import Any

import numpy as np

from benchmarks.fixed import limited
from benchmarks.oracles.tubes import deepest, derivative, signed_edges, signed_faces
from benchmarks.suites.families import FAMILIES, arena_task
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.designs.tube import LOWER, UPPER
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import build_program, build_task
from stt_codegen.task.load import load_task
from stt_codegen.task.sets.shapes import Target, UnsafeBall, UnsafeCapsule, UnsafeHalfSpaces, UnsafePolytope, UnsafeSet, Waypoint
from stt_codegen.task.task import Task

TASKS = Path(__file__).parents[2] / "tasks"
ARENAS = {"paper": 12, "dense12": 4, "space3": 1}
SHAPES = {"discs": 6, "balls": 2, "polygons": 4, "solids": 1}
# omni_board is omni_s2 with ticks; tasks of order 2 have mutants of their own, what limits u adds P8
# (tests/certify/test_limits.py), and missions add P10 (mission_mutants.py)
EXAMPLES = sorted(
    p.stem
    for p in TASKS.glob("*.toml")
    if p.stem != "omni_board" and not re.search(r"^(order = 2|u_max =|\[\[mission)", p.read_text(), re.M)
)
BASES = (*EXAMPLES, *(f"{name} {seed}" for name, n in ARENAS.items() for seed in range(n)))
SHAPED = (*BASES, *(f"{name} {seed}" for name, n in SHAPES.items() for seed in range(n)))

SIZES = (1, 1, *map(Fraction, ("1.003", "1.006", "1.05")))  # of a ball, beside the one that the tube's end just fits in

Mutant = tuple[Task, RefinedDesign]
Sides = Sequence[tuple[int, int]]  # (dimension, LOWER or UPPER)


@dataclass(frozen=True)
class Base:
    """A certified tube to start from, and its margins by property."""

    task: Task
    design: RefinedDesign
    margin: dict[str, Fraction]

    @property
    def body(self) -> tuple[Fraction, ...]:
        return self.task.body or (Fraction(0),) * self.task.dimension


@cache
def base(name: str, scalar: str) -> Base | None:
    """The tube of a task or arena by name; None where there is none."""
    family, _, seed = name.partition(" ")
    task = arena_task(FAMILIES[family], int(seed)) if seed else load_task(TASKS / f"{name}.toml")
    if scalar == "fixed":  # which needs a limit of u, and a tick
        task = limited(task)
    try:
        c = build_task(task.with_options("refined", scalar))
    except NotCertified:
        return None
    assert isinstance(c.design, RefinedDesign)
    margin = {f.code: f.margin for f in c.certificate.findings}
    return Base(c.task, c.design, margin)


# ------------------------------------------------------------------------------------------------ drawing


def amount(dice: Random, top: int) -> int:
    """1 to 2^top, every magnitude alike, up or down."""
    return dice.choice((-1, 1)) * round(2 ** dice.uniform(0, top))


def slack(dice: Random, b: Base) -> Fraction:
    """What a mutation leaves or, negative, takes too much: often nothing at all or one table unit, sometimes a part of one."""
    units = dice.choice((0, dice.choice((-1, 1)), *[amount(dice, 10)] * 5))
    return units * b.design.unit / dice.choice((1, 1, 1, 256))


def short(value: Fraction) -> Fraction:
    """Rounded down to what a task file can say exactly; multiples of a table unit over 512 stay."""
    return Fraction(math.floor(value * (1 << 32)), 1 << 32)


def any_side(dice: Random, b: Base) -> tuple[int, int]:
    return dice.randrange(b.task.dimension), dice.choice((LOWER, UPPER))


def entry(values: Sequence[Fraction], i: int, value: Fraction) -> tuple[Fraction, ...]:
    return (*values[:i], value, *values[i + 1 :])


def with_face(box: Any, i: int, side: int, face: Fraction) -> Any:
    """A box with another face, as in `signed_faces`."""
    key, value = ("lower", face) if side == LOWER else ("upper", -face)
    return box.model_copy(update={key: entry(getattr(box, key), i, value)})


def with_task(b: Base, **change: Any) -> Mutant:
    return b.task.model_copy(update=change), b.design


def with_tube(b: Base, **change: Fraction) -> Mutant:
    return with_task(b, tube=b.task.tube.model_copy(update=change))


# ------------------------------------------------------------------------------------------------ bent tubes


def bent(change: Callable[[Random, Any], None]) -> Callable[[Random, Base], Mutant]:
    """A mutation from what is done to the table, an object array of shape (K + 3, n, 2)."""

    def mutate(dice: Random, b: Base) -> Mutant:
        table = np.array(b.design.table, dtype=object)
        change(dice, table)
        return b.task, replace(b.design, table=tuple(tuple((int(v), int(w)) for v, w in row) for row in table))

    return mutate


def somewhere(dice: Random, table: Any) -> tuple[int, int, int]:
    return dice.randrange(len(table)), dice.randrange(table.shape[1]), dice.randrange(2)


def bend(dice: Random, table: Any, most: int) -> None:
    for _ in range(dice.randint(1, most)):
        table[somewhere(dice, table)] += amount(dice, dice.choice((5, 20)))


def swap(dice: Random, table: Any) -> None:
    """Two entries of one dimension in rows close by, of one edge or of both."""
    j, i, side = somewhere(dice, table)
    other = min(j + dice.randint(0, 2), len(table) - 1), i, dice.choice((side, side, 1 - side))
    table[j, i, side], table[other] = table[other], table[j, i, side]


def shift(dice: Random, table: Any) -> None:
    j, i, _ = somewhere(dice, table)
    table[j, dice.choice((i, slice(None)))] += amount(dice, 20)


def repeat(dice: Random, table: Any) -> None:
    j = dice.randrange(1, len(table))
    a, b = dice.choice(((j, j - 1), (j - 1, j)))
    table[a] = table[b]


def dent(dice: Random, table: Any) -> None:
    """Bent inward, which mostly leaves a tube that is safe, with extremes inside its segments."""
    for _ in range(dice.randint(1, 4)):
        j, i, side = dice.randrange(3, len(table) - 3), *somewhere(dice, table)[1:]
        table[j, i, side] += abs(amount(dice, 17)) * (1 if side == LOWER else -1)


def end(dice: Random, table: Any, rows: Sequence[int]) -> None:
    _, i, side = somewhere(dice, table)
    table[rows, i, side] += amount(dice, 10)


# ------------------------------------------------------------------------------------------------ harder tasks


def obstacle_changed(dice: Random, b: Base) -> Mutant:
    """One unsafe set moved, or a pair of its faces moved out."""
    j, i, by = dice.randrange(len(b.task.unsafe)), dice.randrange(b.task.dimension), amount(dice, 20) * b.design.unit
    if not isinstance(b.task.unsafe[j], UnsafeSet):
        return with_task(b, unsafe=(*b.task.unsafe[:j], changed(dice, b.task.unsafe[j], i, by), *b.task.unsafe[j + 1 :]))
    low, high = signed_faces(b.task.unsafe[j])[i]
    faces = (low - abs(by), high - abs(by)) if dice.random() < 0.5 else (low + by, high - by)
    box = with_face(with_face(b.task.unsafe[j], i, LOWER, faces[LOWER]), i, UPPER, faces[UPPER])
    return with_task(b, unsafe=(*b.task.unsafe[:j], box, *b.task.unsafe[j + 1 :]))


def beside(dice: Random, b: Base, k: int, s: Fraction, sides: Sides, extent: int) -> Mutant:
    """One more unsafe set, before these sides of the tube's box at place s of segment k, with a drawn slack each."""
    faces = []
    for i, edges in enumerate(signed_edges(b.design)[k].tolist()):
        at = [short(sum(a * s**p for p, a in enumerate(edge)) * b.design.unit) for edge in edges]
        spread = [abs(amount(dice, extent)) * b.design.unit for _ in range(2)]
        pair = [at[LOWER] - spread[0], -at[UPPER] + spread[1]]
        for side in [side for m, side in sides if m == i]:
            near = at[side] - b.body[i] - b.task.tube.clearance - slack(dice, b)
            pair = [near - spread[0], near] if side == LOWER else [-near, -near + spread[0]]
        faces.append(pair)
    lower, upper = zip(*faces, strict=True)
    return with_task(b, unsafe=(*b.task.unsafe, UnsafeSet(name="added", lower=lower, upper=upper)))


def changed(dice: Random, unsafe: Any, i: int, by: Fraction) -> Any:
    """A set of another shape moved in one dimension, or made larger."""
    if isinstance(unsafe, UnsafePolytope):
        moved = [dice.random() < 0.5 for _ in unsafe.vertices]
        points = tuple(entry(p, i, p[i] + by) if m else p for m, p in zip(moved, unsafe.vertices, strict=True))
        return unsafe.model_copy(update={"vertices": points})
    if dice.random() < 0.5:
        return unsafe.model_copy(update={"radius": unsafe.radius + abs(by)})
    return unsafe.model_copy(update={"centre": entry(unsafe.centre, i, unsafe.centre[i] + by)})


def shape_beside(dice: Random, b: Base, kind: str) -> Mutant:
    """One more unsafe set of a kind, that all but touches the tube's box, grown by body and clearance, in one of its corners: all
    of it is beyond a plane through that corner, and one point of it is in the plane, but for the slack that is drawn."""
    n, k, s = b.task.dimension, dice.randrange(b.design.segments), Fraction(dice.randint(0, 8), 8)
    d = min(n, dice.choice((2, 2, 3)))
    own = sorted(dice.sample(range(n), d))
    signs, normal = [dice.choice((-1, 1)) for _ in own], [dice.randint(0, 9) for _ in own]
    normal[dice.randrange(d)] = dice.randint(1, 9)
    out, keep = [v * w for v, w in zip(signs, normal, strict=True)], b.task.tube.clearance - slack(dice, b)
    ahead = [(i, UPPER if sign > 0 else LOWER) for i, sign in zip(own, signs, strict=True)]
    edges = signed_edges(b.design)
    if dice.random() < 0.8:  # where the tube is farthest out along the normal, so that it meets the set nowhere else
        k, s = deepest(
            [sum(v * edges[:, i, side] for v, (i, side) in zip(normal, ahead, strict=True))[j] for j in range(len(edges))]
        )[:2]
        s = Fraction(round(s * 64), 64)
    corner = []
    for (i, side), sign in zip(ahead, signs, strict=True):
        at = short(sum(int(a) * s**p for p, a in enumerate(edges[k, i, side])) * b.design.unit)
        corner.append((-at if side == UPPER else at) + sign * (b.body[i] + keep))
    axes = None if d == n else tuple((b.task.axes or tuple(f"x{i + 1}" for i in range(n)))[i] for i in own)
    length = math.sqrt(sum(v * v for v in out))

    def away(reach: float) -> tuple[Fraction, ...]:
        """From the corner along the plane and a little beyond it."""
        step = [dice.uniform(-reach, reach) for _ in out]
        along = sum(v * w for v, w in zip(step, out, strict=True)) / length**2
        wanted = dice.choice((0.0, abs(along)))
        return tuple(short(c + Fraction(v + (wanted - along) * w)) for c, v, w in zip(corner, step, out, strict=True))

    size = dice.choice((0.01, 0.3, 2.0))
    radius = short(Fraction(dice.uniform(0.1, 1) * size)) + Fraction(1, 1 << 32)
    centre = tuple(short(c + Fraction(float(radius) * v / length)) for c, v in zip(corner, out, strict=True))
    added: Any
    if kind == "ball":
        added = UnsafeBall(name="added", axes=axes, centre=centre, radius=radius)
    elif kind == "capsule":
        far = tuple(c + v - w for c, v, w in zip(centre, away(size), corner, strict=True))
        added = UnsafeCapsule(name="added", axes=axes, segment=(centre, far), radius=radius)
    elif kind == "polytope":
        points = (tuple(corner), *(away(size) for _ in range(dice.randint(d, 6))))
        added = UnsafePolytope(name="added", axes=axes, vertices=points)
    else:
        offset = -sum((v * c for v, c in zip(out, corner, strict=True)), Fraction(0))
        cuts = [(tuple(Fraction(-v) for v in out), offset)]
        for _ in range(dice.randint(0, 3)):
            other = tuple(Fraction(dice.randint(-5, 5)) for _ in out)
            cuts.append(
                (other, sum((v * c for v, c in zip(other, corner, strict=True)), Fraction(0)) + short(Fraction(dice.random())))
            )
        added = UnsafeHalfSpaces(name="added", axes=axes, normals=tuple(v for v, _ in cuts), offsets=tuple(v for _, v in cuts))
    return with_task(b, unsafe=(*b.task.unsafe, added))


def region_beside(dice: Random, b: Base, kind: str) -> Mutant:
    """State space or target cut by a half-space that the tube all but touches, by a hull that has it as a face, or a target that
    is a ball with a corner of the tube's end on it, but for the slack that is drawn."""
    n = b.task.dimension
    d = min(n, dice.choice((2, 2, 3)))
    own = sorted(dice.sample(range(n), d))
    edges, axes = signed_edges(b.design), tuple((b.task.axes or tuple(f"x{i + 1}" for i in range(n)))[i] for i in own)
    last = [[int(edges[-1, i, side].sum()) * b.design.unit for side in (LOWER, UPPER)] for i in own]
    if kind == "ball":
        centre = tuple(short(Fraction(dice.uniform(float(low), -float(high)))) for low, high in last)
        far = math.sqrt(sum(max(c - low, -high - c) ** 2 for c, (low, high) in zip(centre, last, strict=True)))
        radius = short(Fraction(far) * dice.choice(SIZES) - slack(dice, b))
        return with_task(b, target_set=Target(axes=axes, centre=centre, radius=radius))
    name = dice.choice(("state_space", "target_set"))
    out = [dice.randint(-9, 9) for _ in own]
    out[dice.randrange(d)] = dice.choice((-1, 1)) * dice.randint(1, 9)
    ahead = [(i, UPPER if v > 0 else LOWER) for i, v in zip(own, out, strict=True)]
    inward = sum(abs(v) * edges[:, i, side] for v, (i, side) in zip(out, ahead, strict=True))
    least = deepest(inward)[2] if name == "state_space" else Fraction(int(inward[-1].sum()))
    body = sum((abs(v) * b.body[i] for i, v in zip(own, out, strict=True)), Fraction(0)) if name == "state_space" else 0
    offset = short(body - least * b.design.unit) - slack(dice, b)
    cut: dict[str, Any] = {"axes": axes, "normals": (tuple(map(Fraction, out)),), "offsets": (offset,)}
    if kind == "hull":  # the box's corners, those beyond the plane moved onto it along one axis
        k = max(range(d), key=lambda i: abs(out[i]))
        place = getattr(b.task, name)
        box = [(place.lower[i] - 100, place.upper[i] + 100) for i in own]
        points = []
        for corner in itertools.product(*box):
            beyond = sum((v * c for v, c in zip(out, corner, strict=True)), Fraction(0)) - offset
            points.append(entry(corner, k, short(corner[k] - beyond / out[k])) if beyond > 0 else corner)
        cut = {"axes": axes, "vertices": tuple(points)}
    return with_task(b, **{name: getattr(b.task, name).model_copy(update=cut)})


def mover_beside(dice: Random, b: Base, kind: str) -> Mutant:
    """A set that is put beside the tube as by `shape_beside`, then moved, doubted, grown or given hours: from the place where it
    all but touches the tube it goes away, or comes there from elsewhere."""
    task, _ = shape_beside(dice, b, dice.choice(("ball", "polytope", "capsule")))
    added: Any = task.unsafe[-1]
    t_c, d = task.prescribed_time, len(added.axes or task.axis_names)
    times = sorted(short(t_c * Fraction(dice.randint(0, 64), 64)) for _ in range(dice.randint(1, 4)))
    times = sorted(set(times))
    far = dice.choice((1e-4, 0.05, 0.5, 3.0))
    places = [tuple(short(Fraction(dice.uniform(-far, far))) for _ in range(d)) for _ in times]
    still = dice.randrange(len(times))
    places[still] = (Fraction(0),) * d
    if dice.random() < 0.3:  # it stands where it all but touches
        places = [(Fraction(0),) * d for _ in times]
    more: dict[str, Any] = {"motion": tuple(Waypoint(at=a, by=p) for a, p in zip(times, places, strict=True))}
    if kind == "window" or dice.random() < 0.2:
        a, z = sorted(dice.sample(range(65), 2))
        more["during"] = (short(t_c * Fraction(a, 64)), short(t_c * Fraction(z, 64)))
        if kind == "window":
            del more["motion"]
    delay = Fraction(0)
    if kind == "doubt":
        more["timing"] = short(t_c * Fraction(dice.choice((0, 1, 3, 20)), 200))
        delay = short(t_c * Fraction(dice.choice((0, 1, 3, 20)), 200))
    if kind == "spread":
        more["spread"] = short(Fraction(dice.choice((1e-6, 1e-3, 0.05))))
    changed_ = added.model_copy(update=more)
    return task.model_copy(update={"unsafe": (*task.unsafe[:-1], changed_), "start_delay": delay}), b.design


def before_face(dice: Random, b: Base) -> Mutant:
    """An unsafe set before the extreme of one edge over some segments."""
    (i, side), last = any_side(dice, b), b.design.segments - 1
    k, reach = dice.choice((0, last, *[dice.randint(0, last)] * 4)), dice.choice((0, 1, 4, 64))
    first = max(0, k - reach)
    ahead, s, _ = deepest(signed_edges(b.design)[first : k + reach + 1, i, side])
    return beside(dice, b, first + ahead, s, [(i, side)], dice.choice((4, 12, 20)))


def in_corner(dice: Random, b: Base) -> Mutant:
    """A set whose corner the tube rounds: one dimension hands over to another, without slack at a root that both share."""
    k, s = dice.randrange(b.design.segments), Fraction(dice.randint(0, 8), 8)
    slope = {(i, side): a + 2 * c * s + 3 * d * s * s
             for i, pair in enumerate(signed_edges(b.design)[k].tolist()) for side, (_, a, c, d) in enumerate(pair)}  # fmt: skip
    one = dice.choice([side for side, v in slope.items() if v < 0])
    other = dice.choice([side for side, v in slope.items() if v > 0 and side[0] != one[0]])
    return beside(dice, b, k, s, [one, other], dice.choice((8, 20)))


def obstacle_added(dice: Random, b: Base) -> Mutant:
    """An unsafe set of any size, thin ones too, beside the tube at any place."""
    sides = [(i, dice.randrange(2)) for i in dice.sample(range(b.task.dimension), dice.randint(1, 2))]
    return beside(dice, b, dice.randrange(b.design.segments), Fraction(dice.randint(0, 8), 8), sides, dice.choice((1, 20)))


def set_moved(dice: Random, b: Base) -> Mutant:
    """A face of start, target or state space put where the tube has its extreme."""
    (i, side), name = any_side(dice, b), dice.choice(("initial_set", "target_set", "state_space"))
    edge = signed_edges(b.design)[:, i, side]
    least = Fraction(int(edge[0, 0] if name == "initial_set" else edge[-1].sum()))
    if name == "state_space":
        least = deepest(edge)[2]
    face = short(least * b.design.unit) - (b.body[i] if name == "state_space" else 0) - slack(dice, b)
    return with_task(b, **{name: with_face(getattr(b.task, name), i, side, face)})


def state_moved(dice: Random, b: Base) -> Mutant:
    i, side = any_side(dice, b)
    edge = int(signed_edges(b.design)[0, i, side, 0]) * b.design.unit + slack(dice, b)
    return with_task(b, initial_state=entry(b.task.initial_state, i, edge if side == LOWER else -edge))


def clearance_raised(dice: Random, b: Base) -> Mutant:
    return with_tube(b, clearance=short(b.task.tube.clearance + b.margin["P4"] - slack(dice, b)))


def width_raised(dice: Random, b: Base) -> Mutant:
    least = deepest(-signed_edges(b.design).sum(axis=2).reshape(-1, 4))[2]
    return with_tube(b, min_width=short(least * b.design.unit) - slack(dice, b))


def body_raised(dice: Random, b: Base) -> Mutant:
    i = dice.randrange(b.task.dimension)
    return with_task(b, body=entry(b.body, i, short(b.body[i] + min(b.margin["P3"], b.margin["P4"]) - slack(dice, b))))


def speed_bounded(dice: Random, b: Base) -> Mutant:
    return with_tube(b, max_speed=_peaks(dice, b, 1))


def acceleration_bounded(dice: Random, b: Base) -> Mutant:
    return with_tube(b, max_acceleration=_peaks(dice, b, 2))


def _peaks(dice: Random, b: Base, order: int) -> Fraction | tuple[Fraction, ...]:
    """The largest derivative of that order, a little more or less: one number, or by component."""
    found = signed_edges(b.design)
    for _ in range(order):
        found = derivative(found)
    per = b.design.unit * (b.design.segments / b.design.prescribed_time) ** order
    slopes = [found[:, i].reshape(-1, 4) for i in range(b.design.dimension)]
    peaks = [-min(deepest(slope)[2], deepest(-slope)[2]) * per for slope in slopes]
    least = max(peaks) / 1000  # a dimension that stands still has a bound too
    bounds = [max(v, least) * (1 + dice.choice((-1, 1)) * Fraction(2) ** dice.randint(-20, -4)) for v in peaks]
    return tuple(map(short, bounds)) if dice.randrange(2) else short(max(bounds))


def dented(dice: Random, b: Base) -> Mutant:
    """A dented tube, then a demand put at its extreme."""
    other = replace(b, design=bent(dent)(dice, b)[1])
    return dice.choice((before_face, in_corner, set_moved, width_raised))(dice, other)


KINDS: dict[str, Callable[[Random, Base], Mutant]] = {
    "one coefficient": bent(partial(bend, most=1)),
    "several coefficients": bent(partial(bend, most=8)),
    "entries swapped": bent(swap),
    "row shifted": bent(shift),
    "row repeated": bent(repeat),
    "kink at the end": bent(partial(end, rows=[-1])),
    "end moved": bent(partial(end, rows=[-1, -3])),
    "dented, then harder": dented,
    "obstacle moved or grown": obstacle_changed,
    "obstacle added": obstacle_added,
    "obstacle before a face": before_face,
    "obstacle in a corner": in_corner,
    "set moved": set_moved,
    "initial state moved": state_moved,
    "clearance": clearance_raised,
    "least width": width_raised,
    "body": body_raised,
    "speed bound": speed_bounded,
    "acceleration bound": acceleration_bounded,
    "ball beside": partial(shape_beside, kind="ball"),
    "capsule beside": partial(shape_beside, kind="capsule"),
    "polytope beside": partial(shape_beside, kind="polytope"),
    "half-spaces beside": partial(shape_beside, kind="half-spaces"),
    "wall beside": partial(region_beside, kind="half-space"),
    "hull beside": partial(region_beside, kind="hull"),
    "target ball beside": partial(region_beside, kind="ball"),
    "motion beside": partial(mover_beside, kind="motion"),
    "window beside": partial(mover_beside, kind="window"),
    "doubt beside": partial(mover_beside, kind="doubt"),
    "spread beside": partial(mover_beside, kind="spread"),
}


MOVING = ("motion beside", "window beside", "doubt beside", "spread beside")
BESIDE = tuple(kind for kind in KINDS if kind.endswith(" beside") and kind not in MOVING)  # sets of other shapes than boxes


def draw(
    dice: Random, names: Sequence[str], kinds: Sequence[str] = tuple(KINDS), scalars: Sequence[str] = ("float", "double")
) -> tuple[str, str, Base, Mutant]:
    """A kind, the base's name, the base, and a mutant that is well formed (a box may turn over, a coefficient grow too long, or a
    step longer than integers have bits for)."""
    kind = dice.choice(list(kinds))
    for _ in range(1000):
        name, scalar = dice.choice(names), dice.choice(scalars)
        b = base(name, scalar)
        with contextlib.suppress(ValueError, IndexError, BadInput):
            if b is not None and well_formed((mutant := KINDS[kind](dice, b))[0]):
                if scalar == "fixed":
                    build_program(*mutant)
                return kind, f"{name}, {scalar}", b, mutant
    raise RuntimeError(f"no mutant of the kind {kind!r} from {', '.join(names)}")


def well_formed(task: Task) -> bool:
    boxes = [task.state_space, task.initial_set, *([task.target_set] if task.target_set.lower else [])]
    if task.state_space.problem() or task.target_set.problem():
        return False
    boxes += [s for s in task.unsafe if isinstance(s, UnsafeSet)]
    for s in task.unsafe:
        if s.problem():
            return False
        s.to_set_in(task.state_space, task.axis_indices(s))  # raises ValueError where there is nothing of it
    sizes = (*(b - a for box in boxes for a, b in zip(box.lower, box.upper, strict=True)), *(task.max_speed or (1,)))
    return min(sizes) > 0 and min(task.tube.clearance, task.tube.min_width, *(task.body or ())) >= 0
