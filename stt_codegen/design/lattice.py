"""Where the numbers of a refined tube may lie: multiples of a step, fine enough for the task and exact in the scalar.

The step is 2**-23 of the power of two above the state space's largest coordinate, 24 bits, for floats and doubles alike, so that
both share one tube, unless it is so fast that a float needs a larger allowance. Far from the origin that step is too coarse for
what is left of the space. There a double has bits to spare: the step is then 2**-23 of the space's size, and design looks at the
task from a place near it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

from stt_codegen.designs import COEFFICIENT_BIT_LIMIT
from stt_codegen.program import exponent_of
from stt_codegen.task import Task

STEP_BITS = 23  # the step over the power of two that the lattice is scaled by
FIXED_BITS = 21  # the same for a controller in integers, where a step between control points has 15 bits
ALLOWANCE_STEPS = 32  # the usual allowance for rounding, in steps
FAR = 6  # far: the power of two above the coordinates is over 2**FAR times that above the space's size
MOST = COEFFICIENT_BIT_LIMIT - STEP_BITS - 1  # so many bits more than a float's 24 a double spares


@dataclass(frozen=True)
class Lattice:
    """Lengths are measured in units of 2**exponent; no coordinate is beyond 2**largest. origin: by dimension, where design counts
    from, a multiple of 6 steps. rounding_allowance_factor: above 1 for tubes so fast that the emitted arithmetic, which rounds
    the time, moves their edges by more than the usual allowance."""

    exponent: int
    largest: int
    origin: tuple[Fraction, ...]
    rounding_allowance_factor: int = 1
    step_bits: int = STEP_BITS

    @property
    def bits(self) -> int:
        """The step is 2**-bits."""
        return self.step_bits - self.exponent

    @property
    def significant(self) -> int:
        """The bits that a number of the lattice has at most, without its sign."""
        return self.step_bits + 1 + self.largest - self.exponent

    @cached_property
    def difference_allowance(self) -> Fraction:
        """The margin left at every bound on rates and accelerations: 32 steps of a first or second difference of control points.
        It covers the rounding of the coefficients. P6 and P8 are about the exact tube, so no arithmetic takes from it."""
        return ALLOWANCE_STEPS * Fraction(2) ** -self.bits

    @cached_property
    def allowance(self) -> Fraction:
        """The margin left at every bound on edges: 32 steps times `rounding_allowance_factor`.

        It covers the rounding of the coefficients (3 steps) and the error of the emitted arithmetic, whose bound is derived for
        the finished tube and compared with the margins (property P7).
        """
        return self.rounding_allowance_factor * self.difference_allowance

    @property
    def offsets(self) -> tuple[int, ...]:
        """The origin in units of the table, whose entries are control points over 6."""
        return tuple(int(v / 6 * Fraction(2) ** self.bits) for v in self.origin)


def shared_lattice(task: Task) -> Lattice:
    """The lattice that floats and doubles share, from the task's own origin."""
    largest = power_above(max(abs(v) for v in (*task.state_space.lower, *task.state_space.upper)))
    return Lattice(largest, largest, (Fraction(0),) * task.dimension)


def lattice_of(task: Task) -> Lattice:
    """The lattice of a refined tube for the task's space and scalar."""
    lower, upper = task.state_space.lower, task.state_space.upper
    shared = shared_lattice(task)
    largest = shared.largest
    extent = power_above(max(b - a for a, b in zip(lower, upper, strict=True)))
    if task.emit.scalar == "fixed":
        return replace(shared, step_bits=FIXED_BITS)
    if task.emit.scalar == "float" or largest - extent <= FAR:
        return shared
    exponent = max(extent, largest - MOST)
    step = 6 * Fraction(2) ** (exponent - STEP_BITS)
    return Lattice(exponent, largest, tuple(round((a + b) / 2 / step) * step for a, b in zip(lower, upper, strict=True)))


def power_above(value: Fraction) -> int:
    """The exponent of the least power of two that is not below a positive value."""
    below = exponent_of(value)
    return below if value == Fraction(2) ** below else below + 1
