"""The lattice of a refined tube: its numbers are multiples of a step that is fine enough for the task and exact in the scalar.

The step is 2**-23 of the power of two above the largest coordinate of the state space, so that numbers have 24 bits. Floats and
doubles use the same step and share one tube, unless the tube is so fast that a float needs a larger allowance.

Far from the origin this step is too coarse for a small state space. A double has more bits: there the step is 2**-23 of the
space's size, and the design counts from an origin near the space. The arena (arena.py) and the rounding of a tube (refine.py,
user_tubes.py) use the lattice.
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
DISTANCE_BITS = (
    6  # a space is far from the origin where its coordinates are over 2**DISTANCE_BITS times its size, by powers of two
)
EXTRA_BITS_LIMIT = COEFFICIENT_BIT_LIMIT - STEP_BITS - 1  # so many bits more than a float's 24 a double may use


@dataclass(frozen=True)
class Lattice:
    """The step of a tube's numbers, the origin they are counted from and the allowance for their rounding.

    exponent: lengths are measured in units of 2**exponent. largest_exponent: no coordinate is beyond 2**largest_exponent. origin:
    (n,), where the design counts from, a multiple of 6 steps. rounding_allowance_factor: above 1 for tubes so fast that the
    emitted arithmetic, which rounds the time, moves their edges by more than the usual allowance. step_bits: the step is
    2**-step_bits of the unit.
    """

    exponent: int
    largest_exponent: int
    origin: tuple[Fraction, ...]
    rounding_allowance_factor: int = 1
    step_bits: int = STEP_BITS

    @property
    def bits(self) -> int:
        """Return the number of bits after the point: the step is 2**-bits."""
        return self.step_bits - self.exponent

    @property
    def significant_bits(self) -> int:
        """Return how many bits a number of the lattice has at most, without its sign."""
        return self.step_bits + 1 + self.largest_exponent - self.exponent

    @cached_property
    def difference_allowance(self) -> Fraction:
        """Return the margin left at every bound on rates and accelerations: 32 steps.

        It is a margin of a first or second difference of control points and covers the rounding of the coefficients. The
        properties smooth and limits (P6 and P8) are about the exact tube, so the emitted arithmetic takes nothing from it.
        """
        return ALLOWANCE_STEPS * Fraction(2) ** -self.bits

    @cached_property
    def allowance(self) -> Fraction:
        """Return the margin left at every bound on edges: 32 steps times `rounding_allowance_factor`.

        It covers the rounding of the coefficients (3 steps) and the error of the emitted arithmetic. The bound of that error is
        derived for the finished tube and compared with the margins (property P7, arithmetic).
        """
        return self.rounding_allowance_factor * self.difference_allowance

    @property
    def offsets(self) -> tuple[int, ...]:
        """Return the origin in units of the table, whose entries are control points over 6: (n,)."""
        return tuple(int(v / 6 * Fraction(2) ** self.bits) for v in self.origin)


def shared_lattice(task: Task) -> Lattice:
    """Return the lattice that floats and doubles share, counted from the task's own origin."""
    largest_exponent = exponent_above(task.largest_coordinate)
    return Lattice(largest_exponent, largest_exponent, (Fraction(0),) * task.dimension)


def lattice_of(task: Task) -> Lattice:
    """Return the lattice of a refined tube for the task's space and scalar."""
    lower, upper = task.state_space.lower, task.state_space.upper
    shared = shared_lattice(task)
    largest_exponent = shared.largest_exponent
    size_exponent = exponent_above(max(b - a for a, b in zip(lower, upper, strict=True)))
    if task.emit.scalar == "fixed":
        return replace(shared, step_bits=FIXED_BITS)
    if task.emit.scalar == "float" or largest_exponent - size_exponent <= DISTANCE_BITS:
        return shared
    exponent = max(size_exponent, largest_exponent - EXTRA_BITS_LIMIT)
    step = 6 * Fraction(2) ** (exponent - STEP_BITS)
    return Lattice(exponent, largest_exponent, tuple(round((a + b) / 2 / step) * step for a, b in zip(lower, upper, strict=True)))


def exponent_above(value: Fraction) -> int:
    """Return the exponent of the smallest power of two that is not below a positive value."""
    below = exponent_of(value)
    return below if value == Fraction(2) ** below else below + 1
