"""Multipliers with which a certificate shows how far an intersection of half-spaces extends along a normal.

The set is all x of a box with a_k.x <= b_k for every k. For any y_k >= 0 and any x of the set,

    n.x <= y.b + (n - y a).x <= y.b + the largest value of (n - y a).x over the box,

so whoever checks needs no corners of the set: wrong multipliers only make the bound larger (weak duality). There are multipliers
for which it is the largest n.x itself: at the corner x with that value, n is a sum of the faces' normals with weights >= 0, and d
of these faces are enough, in d dimensions. claims.py writes them into hints for sets that a task states by `normals` and
`offsets`."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from fractions import Fraction

from stt_codegen.task import SET_TURNS_LIMIT, Task
from stt_codegen.task.sets import Normal, Unsafe, UnsafeHalfSpaces, Vector, cut_box, dot

Multipliers = tuple[Fraction, ...]
ZERO = Fraction(0)


def multipliers_in(task: Task, table: Unsafe) -> Callable[[Normal], Multipliers | None]:
    """Return the function from a normal (n,) to one multiplier for each of the set's half-spaces; None for a set without them.

    table: of a set of the file, before turns of closed axes were expanded. Where an axis closes, the box is so wide that the set,
    which is bounded there, does not reach its faces."""
    if not isinstance(table, UnsafeHalfSpaces):
        return lambda _normal: None
    axes, periods = task.axis_indices(table), {axis.index: axis.period for axis in task.closed_axes}
    space, middle = task.state_space, task.initial_state
    reach = SET_TURNS_LIMIT
    lower = tuple(middle[i] - reach * periods[i] if i in periods else space.lower[i] for i in axes)
    upper = tuple(middle[i] + reach * periods[i] if i in periods else space.upper[i] for i in axes)
    half_spaces = tuple(zip(table.normals, table.offsets, strict=True))
    return lambda normal: tightest_multipliers(lower, upper, half_spaces, tuple(normal[i] for i in axes))


def tightest_multipliers(
    lower: Vector, upper: Vector, half_spaces: Sequence[tuple[Vector, Fraction]], normal: Normal
) -> Multipliers:
    """Return multipliers, one for each half-space (a, b), with which the bound of the module is the largest normal.x.

    lower, upper, normal: (d,). The intersection must not be empty.

        >>> half = Fraction(1, 2)
        >>> tightest_multipliers((ZERO, ZERO), (Fraction(1), Fraction(1)), [((Fraction(1), Fraction(1)), half)], (2, 2))
        (Fraction(2, 1),)
    """
    d, count = len(lower), len(half_spaces)
    corner = max(cut_box(lower, upper, half_spaces), key=lambda vertex: dot(normal, vertex.point))
    normals = [tuple(Fraction(side * (i == k)) for i in range(d)) for k in range(d) for side in (-1, 1)]
    normals += [a for a, _ in half_spaces]
    faces = [k for k in range(2 * d + count) if corner.face_mask >> k & 1]
    for chosen in itertools.combinations(faces, d):
        weights = _solve([[normals[k][i] for k in chosen] for i in range(d)], normal)
        if weights is not None and min(weights) >= 0:
            by_face = dict(zip(chosen, weights, strict=True))
            return tuple(by_face.get(2 * d + k, ZERO) for k in range(count))
    raise AssertionError("a corner has no faces that bound the normal")  # impossible: it is the corner with the largest value


def _solve(rows: list[list[Fraction]], right: Sequence[Fraction | int]) -> list[Fraction] | None:
    """Solve as many equations as unknowns by Gauss-Jordan elimination; None where the solution is not unique."""
    system = [[*row, Fraction(b)] for row, b in zip(rows, right, strict=True)]
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
