"""What every design answers, whatever its kind: a tube has a lower and an upper edge in every dimension.

The classes are in refined.py and adaptive.py; the rooms after the design stage ask designs through this protocol.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar, runtime_checkable

import numpy.typing as npt

from stt_codegen.design_kinds import Capabilities, DesignKind
from stt_codegen.errors import BadInput

LOWER, UPPER = 0, 1  # the sides, as indices
Edge = tuple[Fraction, Fraction]  # lower, upper
MINIMUM_WIDTH = Fraction(1, 1 << 20)  # narrower tubes are treated as this wide, so that xi stays finite
NARROWEST_WIDTH = Fraction(1, 1 << 18)  # P1 demands at least this: laws of refined tubes divide by the width as it is
Array = npt.NDArray[Any]


@runtime_checkable
class Design(Protocol):
    """The numbers that fix a tube. What is done by kind stands in tables whose keys are kinds; this protocol has the rest."""

    @property
    def kind(self) -> DesignKind:
        """The name of its kind, as `tube.design` has it."""

    @property
    def capabilities(self) -> Capabilities:
        """What its kind offers."""

    @property
    def is_stateful(self) -> bool:
        """Whether the tube depends on an update function alpha that the caller keeps and steps; else on time alone."""

    @property
    def prescribed_time(self) -> Fraction:
        """t_c in seconds."""

    @property
    def dimension(self) -> int:
        """n, the number of state components."""

    @property
    def size(self) -> str:
        """How large the design is, in words."""

    @property
    def parts(self) -> int | None:
        """The number of parts of equal length into which its data divide the time; None where they divide nothing."""

    @property
    def filter(self) -> tuple[Fraction, ...]:
        """lambda by component, 1/s, where v + lambda x is held in a tube too, for plants of order 2; else empty."""

    @property
    def cycle_begin(self) -> Fraction | None:
        """The time at which the repeated part begins, which ends at t_c; None for a tube that is constant from t_c on."""

    def numbers(self) -> dict[str, Any]:
        """Return all numbers that fix the tube, by name, as the design's hash reads them."""

    def edges_at(self, t: Array) -> tuple[Array, Array]:
        """Return lower and upper edges at equally spaced times t from 0 to t_c, shape (P, n) each, in doubles."""


First = TypeVar("First")
Narrow = TypeVar("Narrow", bound=Design)
Rest = ParamSpec("Rest")
Result = TypeVar("Result")


def for_any_design(
    design_class: type[Narrow], function: Callable[Concatenate[First, Narrow, Rest], Result]
) -> Callable[Concatenate[First, Design, Rest], Result]:
    """Return the function, whose second parameter is a design of this class, with a second parameter of any class.

    Tables by kind take such functions: the kind's name leads to the class. Raises `TypeError` where it is another one.
    """

    def with_class_checked(first: First, design: Design, /, *rest: Rest.args, **named: Rest.kwargs) -> Result:
        if not isinstance(design, design_class):
            raise TypeError(f"a {design_class.__name__} is needed here; this tube is {design.kind}")
        return function(first, design, *rest, **named)

    return with_class_checked


def require_design(value: object) -> Design:
    """Return the value if it is a design of any kind; raise `BadInput` with what it is otherwise."""
    if isinstance(value, type) or not isinstance(value, Design):
        raise BadInput(f"tube: is a {type(value).__name__}; a design is needed, as `design` returns it")
    return value


def require_time(prescribed_time: object) -> None:
    """Raise `BadInput` where the prescribed time of a design is no exact number above 0."""
    if not isinstance(prescribed_time, Fraction) or prescribed_time <= 0:
        raise BadInput(f"tube: has prescribed_time = {prescribed_time}; a Fraction above 0 is needed, in seconds")
