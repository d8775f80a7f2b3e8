"""The task in floating point, as the design search sees it: grown by the body, with room for rounding.

Everything in `design/` uses only correctly rounded operations (+ - * / and comparisons), element by element:
no BLAS, no sums over long axes, no transcendental functions. The linear programs are then the same bytes on every
machine, and so is what the solver makes of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from stt_codegen.certify.certificate import below
from stt_codegen.controller.component import LEAST_WIDTH
from stt_codegen.errors import NotCertified
from stt_codegen.task import Task
from stt_codegen.wording import decimal

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Arena:
    """Boxes as arrays: `space`, `start`, `target` of shape (2, n), `unsafe` of shape (J, 2, n); index 0 lower, 1 upper.

    clearance, min_width: what the task asks for plus the arithmetic allowance. allowance: what rounding of the
    coefficients and of the emitted arithmetic may move an edge by, see `arithmetic_allowance`. length_unit, time_unit:
    what lengths and times here must be multiplied by to be the task's.
    """

    names: tuple[str, ...]
    space: Array
    start: Array
    target: Array
    unsafe: Array
    initial_state: Array
    prescribed_time: float
    clearance: float
    min_width: float
    max_speed: float
    allowance: float
    length_unit: float = 1.0
    time_unit: float = 1.0

    @property
    def dimension(self) -> int:
        return int(self.space.shape[1])


def magnitude(task: Task) -> int:
    """The exponent m of the least power of two with every edge of the state space in [-2**m, 2**m]."""
    largest = max(abs(v) for v in task.state_space.lower + task.state_space.upper)
    exponent = math.frexp(float(largest))[1]
    return exponent - 1 if largest <= Fraction(2) ** (exponent - 1) else exponent


def arithmetic_allowance(task: Task) -> Fraction:
    """Room left at every bound: 2**(m - 18), 32 units in the last place of a float as large as the state space.

    It covers the rounding of the coefficients (3 table steps of 2**(m - 23)) and the error of single-precision
    evaluation, whose bound is derived for the finished tube and compared with the margins (property P7).
    """
    return Fraction(2) ** (magnitude(task) - 18)


def arena_of(task: Task) -> Arena:
    """The task as arrays. Raises `NotCertified` when sets are too narrow to hold a tube at all."""
    space, unsafe = task.free_space, task.grown_unsafe
    n = task.dimension
    allowance = arithmetic_allowance(task)
    least = max(task.tube.min_width, LEAST_WIDTH)
    wide = least + 2 * allowance
    for field, box in (("initial_set", task.initial_set), ("target_set", task.target_set)):
        for i in range(n):
            width = box.upper[i] - box.lower[i]
            if width < wide + 4 * allowance:
                raise NotCertified(
                    f"P1 width: {field} is {decimal(width)} wide in dimension {i + 1}, too narrow for a tube of "
                    f"min_width {decimal(least)} (plus {decimal(6 * allowance)} for rounding); "
                    + (
                        "the coordinates are too large for single precision: move the origin near the task"
                        if width > least
                        else f"lower tube.min_width to {below(width - 6 * allowance, 4):g} or widen the set"
                    )
                )
    inset = 2 * allowance

    def array(lower: tuple[Fraction, ...], upper: tuple[Fraction, ...]) -> list[list[float]]:
        return [[float(v) for v in lower], [float(v) for v in upper]]

    return Arena(
        names=tuple(s.name for s in unsafe),
        space=np.array(array(tuple(v + allowance for v in space.lower), tuple(v - allowance for v in space.upper))),
        start=np.array(array(tuple(v + inset for v in task.initial_set.lower), tuple(v - inset for v in task.initial_set.upper))),
        target=np.array(
            array(tuple(v + allowance for v in task.target_set.lower), tuple(v - allowance for v in task.target_set.upper))
        ),
        unsafe=np.array([array(s.lower, s.upper) for s in unsafe]).reshape(len(unsafe), 2, n),
        initial_state=np.array([float(v) for v in task.initial_state]),
        prescribed_time=float(task.prescribed_time),
        clearance=float(task.tube.clearance + allowance),
        min_width=float(wide),
        max_speed=float(task.tube.max_speed) if task.tube.max_speed is not None else math.inf,
        allowance=float(allowance),
    )


def normalised(arena: Arena, exponent: int) -> Arena:
    """The same arena with lengths in units of 2**exponent (exactly) and t_c as unit of time, so that tolerances of the
    search and of the solver mean the same for every task."""
    unit = 2.0**exponent
    return replace(
        arena,
        space=arena.space / unit,
        start=arena.start / unit,
        target=arena.target / unit,
        unsafe=arena.unsafe / unit,
        initial_state=arena.initial_state / unit,
        prescribed_time=1.0,
        clearance=arena.clearance / unit,
        min_width=arena.min_width / unit,
        max_speed=arena.max_speed * arena.prescribed_time / unit,
        allowance=arena.allowance / unit,
        length_unit=unit,
        time_unit=arena.prescribed_time,
    )


def starting_box(arena: Arena) -> Array:
    """gamma(0): the initial set less the allowance, cut back where an unsafe set is nearer than the clearance.

    Shape (2, n). An unsafe set that is too near is cut away in the dimension with the largest gap.
    Raises `NotCertified` when x(0) or the least width is lost by that.
    """
    box = arena.start.copy()
    for j, name in enumerate(arena.names):
        below = arena.unsafe[j, 0] - box[1]  # gap with the box on the lower side of U_j
        above = box[0] - arena.unsafe[j, 1]
        gap = np.maximum(below, above)
        i = int(np.argmax(gap))
        if gap[i] >= arena.clearance:
            continue
        if below[i] >= above[i]:
            box[1, i] = arena.unsafe[j, 0, i] - arena.clearance
        else:
            box[0, i] = arena.unsafe[j, 1, i] + arena.clearance
        x = arena.initial_state[i]
        if not box[0, i] + arena.allowance <= x <= box[1, i] - arena.allowance or (box[1, i] - box[0, i] < arena.min_width):
            size = arena.length_unit
            raise NotCertified(
                f"P4 avoid at t = 0: {name} is {max(float(gap[i]), 0.0) * size:.6g} from the initial set in dimension {i + 1}, "
                f"nearer than the clearance {(arena.clearance - arena.allowance) * size:.6g}, and x(0) = {x * size:.6g} there "
                "leaves no room to start elsewhere; lower tube.clearance, or move the initial set or x(0) away from it"
            )
    for i, x in enumerate(arena.initial_state):
        if not box[0, i] + arena.allowance <= x <= box[1, i] - arena.allowance:
            raise NotCertified(
                f"P2 start: initial_state[{i}] = {x * arena.length_unit:.9g} is nearer than "
                f"{4 * arena.allowance * arena.length_unit:.3g} (the room for rounding) "
                "to the edge of the initial set; move it inside"
            )
    return box
