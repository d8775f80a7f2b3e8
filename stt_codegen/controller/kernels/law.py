"""The frame around (13) for one component of the state: clamp, error transform, law; and the public `transform`.

Clamping e to [-e_max, e_max] is the same as keeping both distances a = x - gamma_L and b = gamma_U - x within
[c, 1 - c] times the width, c = (1 - e_max) / 2. Only the lesser of them can be below c, and the other one is what the width
leaves: so one comparison clamps, nothing overflows and no division is by zero, whatever x is.

Long because a component's law is one piece: place, clamp, transform, law, margin, for every kind of tube.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Protocol

from stt_codegen.controller.kernels.logarithm import without_library
from stt_codegen.designs import MINIMUM_WIDTH
from stt_codegen.errors import BadInput
from stt_codegen.paper import control_law
from stt_codegen.program import (
    FORMATS,
    NAN,
    Block,
    Const,
    Function,
    IsFinite,
    Kernel,
    Load,
    Operand,
    Param,
    Table,
    Var,
    real,
)
from stt_codegen.program.convert import lower
from stt_codegen.task import Task


@dataclass(frozen=True, kw_only=True)
class Law:
    """The kernels of section IV and the constants of the control law for one task, by component."""

    normalized_error: Kernel
    transformed_error: Kernel
    law: Kernel
    gain: tuple[Fraction, ...]
    e_max: tuple[Fraction, ...]
    u_max: tuple[Fraction, ...] | None
    scales: bool = False  # whether u_max limits u as a whole

    @property
    def kernels(self) -> tuple[Kernel, ...]:
        return (self.normalized_error, self.transformed_error, self.law)

    @property
    def shares(self) -> tuple[Fraction, ...]:
        """c = (1 - e_max)/2, the least distance to an edge, over the width, that the law goes by."""
        return tuple((1 - v) / 2 for v in self.e_max)

    @property
    def tables(self) -> list[Table]:
        """What differs by component; a constant that all share stands where it is used."""
        known = (
            ("gain", self.gain, "Gain k of the control law, by component."),
            ("e_max", self.e_max, "Clamp of the normalized error, by component."),
            ("least_share", self.shares, "(1 - e_max)/2, by component."),
        )
        found = [Table(name, values, len(values), (doc,)) for name, values, doc in known if len(set(values)) > 1]
        if self.u_max is not None and not self.scales:
            found.append(Table("u_max", self.u_max, len(self.u_max), ("Saturation of u, by component.",)))
        return found

    def signed_gain(self, block: Block, i: Operand) -> tuple[Operand, Operand]:
        """k and -k of component i."""
        return _signed(block, "gain", self.gain, i)

    def signed_clamp(self, block: Block, i: Operand) -> tuple[Operand, Operand]:
        """e_max and -e_max of component i."""
        return _signed(block, "e_max", self.e_max, i)

    def share(self, block: Block, i: Operand) -> Operand:
        """c of component i."""
        return _of_component(block, "least_share", self.shares, i)

    def limit(self, block: Block, i: Operand) -> Operand | None:
        """u_max of component i; None where u is not limited."""
        return None if self.u_max is None or self.scales else block.let("u_limit", Load("u_max", i))


def _of_component(block: Block, name: str, values: tuple[Fraction, ...], i: Operand) -> Operand:
    """One of the values: the constant where all agree, else from the table of that name."""
    return real(values[0]) if len(set(values)) == 1 else block.let(f"{name}_i", Load(name, i))


def _signed(block: Block, name: str, values: tuple[Fraction, ...], i: Operand) -> tuple[Operand, Operand]:
    value = _of_component(block, name, values, i)
    return value, real(-values[0]) if isinstance(value, Const) else block.op(f"{name}_minus", "neg", value)


def control_law_of(task: Task) -> Law:
    """The law with the task's constants. Raises `BadInput` when u or a constant would leave the scalar's range."""
    scalar = task.emit.scalar
    largest, roundoff = FORMATS[scalar].largest, FORMATS[scalar].roundoff
    for gain, e_max in zip(task.gain, task.e_max, strict=True):
        steepest = abs(gain) * 2 / ((1 - e_max) / 2 * MINIMUM_WIDTH) * 64  # 64 > ln((1 - c)/c) for every c in range
        if steepest > largest / 4:
            raise BadInput(
                f"control: gain {float(gain):.6g} with e_max {float(e_max):.12g} overflows a {scalar}; "
                "lower control.gain or control.e_max"
            )
        coarse = (1 - e_max) / roundoff < 8 or e_max / roundoff < 1 << 12
        if coarse:
            side = "1" if e_max > Fraction(1, 2) else "0"
            raise BadInput(
                f'control.e_max: {float(e_max):.12g} is too near {side} for a {scalar}; use emit.scalar = "double" or another'
            )
    normalized, transformed, law = _kernels_of_the_law()
    return Law(
        normalized_error=normalized,
        transformed_error=without_library(transformed) if task.emit.math == "inline" else transformed,
        law=law,
        gain=task.gain,
        e_max=task.e_max,
        u_max=task.emitted_u_max,
        scales=task.scales_input,
    )


@cache  # they depend on no task
def _kernels_of_the_law() -> tuple[Kernel, Kernel, Kernel]:
    return (
        lower(
            control_law.normalized_error(),
            ("Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x.",),
        ),
        lower(
            control_law.transformed_error(),
            ("Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b.",),
        ),
        lower(control_law.law(), ("Control law (13): u = -k xi epsilon.",)),
    )


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where x stands between its two edges: the distance to the nearer one (negative outside), whether that is the upper one,
    and `gain` with the sign of that side (minus at the upper one); near and far, the clamped distances to both, and the width
    that they add up to (never below MINIMUM_WIDTH); the room between the edges; whether the tube is empty in this component
    (None where it never is)."""

    nearest: Var
    upper_nearer: Var
    gain: Var
    near: Var
    far: Var
    width: Var
    room: Var
    empty: Var | None


@dataclass(frozen=True)
class Between:
    """A number between two edges."""

    lower: Operand
    upper: Operand
    x: Operand

    def room(self, block: Block) -> Var:
        """Statements for how far the edges are apart."""
        return block.op("room", "sub", self.upper, self.lower)

    def distances(self, block: Block) -> tuple[Var, Var]:
        """Statements for the distances to both edges."""
        return block.op("to_lower", "sub", self.x, self.lower), block.op("to_upper", "sub", self.upper, self.x)


class Apart(Protocol):
    """What the law asks of a component: how far its edges are apart, and how far it is from both."""

    def room(self, block: Block) -> Var: ...
    def distances(self, block: Block) -> tuple[Var, Var]: ...


def nearest_of(block: Block, apart: Apart) -> tuple[Var, Var]:
    """Statements for the distance to the nearer edge and whether that is the upper one. Between two edges it is above 0 just
    where lower < x < upper: a difference of two numbers has the sign of their comparison, gradual underflow included."""
    to_lower, to_upper = apart.distances(block)
    upper_nearer = block.op("upper_nearer", "lt", to_upper, to_lower)
    return block.select("nearest", upper_nearer, to_upper, to_lower), upper_nearer


def _width(block: Block, room: Var) -> Var:
    wide = block.op("wide", "lt", real(MINIMUM_WIDTH), room)
    return block.select("width", wide, room, real(MINIMUM_WIDTH))


def place_of(
    block: Block,
    share: Operand,
    apart: Apart,
    signed_gain: tuple[Operand, Operand],
    guarded: bool = True,
) -> Place:
    """Statements for where a component stands; near is within [c, 1/2] and far within [1/2, 1 - c] of the width, c = `share`,
    roundings apart. A NaN counts as outside. signed_gain: k and -k. guarded=False: the caller has proved that the edges are more
    than MINIMUM_WIDTH apart."""
    room = apart.room(block)
    filled = block.op("filled", "lt", real(0), room) if guarded else None
    empty = block.op("empty", "not", filled) if filled is not None else None
    width = _width(block, room) if guarded else room
    nearest, upper_nearer = nearest_of(block, apart)
    signed = block.select("gain", upper_nearer, signed_gain[1], signed_gain[0])
    least = block.op("least", "mul", width, share)
    if filled is None:
        near = block.select("near", block.op("clear", "lt", least, nearest), nearest, least)
    else:  # a narrower tube counts as widened about its middle; in an empty one, or one that is no tube, near is `least`
        spare = block.op("spare", "mul", block.op("widened", "sub", width, room), real(Fraction(1, 2)))
        distance = block.op("distance", "add", nearest, spare)
        clear = block.op("clear", "and", filled, block.op("farther", "lt", least, distance))
        near = block.select("near", clear, distance, least)
    far = block.op("far", "sub", width, near)
    return Place(nearest=nearest, upper_nearer=upper_nearer, gain=signed, near=near, far=far, width=width, room=room, empty=empty)


def inside_of(block: Block, place: Place) -> Var:
    """Statements for lower < x < upper, false in an empty tube."""
    return block.op("within", "lt", real(0), place.nearest)


def not_finite(block: Block, scalars: Sequence[Var], arrays: Sequence[tuple[str, int]]) -> Var:
    """Statements for whether a number of these is not finite: 0 times it is then NaN, and so is the sum, which is else 0 and is
    tested once. `arrays`: names and lengths."""
    total: Operand = real(0)
    for k, scalar in enumerate(scalars):
        term = block.op(f"{scalar.name}_zero", "mul", scalar, real(0))
        total = block.op("both_zero", "add", total, term) if k else term
    for array, length in arrays:
        with block.loop("j", length) as loop:
            zero = loop.carry("zero", total)
            term = block.op(f"{array}_zero", "mul", block.let(f"{array}_j", Load(array, loop.index)), real(0))
            loop.update(zero, block.op("zeros", "add", zero, term))
        total = zero
    return block.op("bad", "not", block.op("finite", "le", total, real(0)))


def _clamp(block: Block, name: str, value: Operand, low: Operand, high: Operand) -> Var:
    """Statements for value held within [low, high]; a NaN becomes `low`, so that no NaN reaches a division."""
    over_low = block.op(f"{name}_above", "lt", low, value)
    raised = block.select(f"{name}_raised", over_low, value, low)
    over = block.op(f"{name}_over", "lt", high, raised)
    return block.select(name, over, high, raised)


def control_component(block: Block, law: Law, place: Place, u_max: Operand | None) -> Var:
    """Statements for one component of u: (13) on the clamped distances, 0 where the tube is empty, saturated if asked.

    (13) is odd about the middle of the tube: measured from the upper edge, a and b change places and u its sign."""
    epsilon, xi = block.call(law.transformed_error, place.near, place.far)
    (push,) = block.call(law.law, place.gain, xi, epsilon, names=("push",))
    u = push if place.empty is None else block.select("u_law", place.empty, real(0), push)
    if u_max is None:
        return u
    minus = block.op("u_min", "neg", u_max)
    return _clamp(block, "u_held", u, minus, u_max)


def scale_input(block: Block, law: Law, n: int) -> None:
    """Statements that bring u, as it is stored, within u_max by one factor for all components, where it is not."""
    if law.u_max is None or not law.scales:
        return
    most = real(law.u_max[0])
    with block.loop("i", n) as loop:
        largest = loop.carry("largest", real(0))
        u = block.let("u_i", Load("u", loop.index))
        size = block.select("size", block.op("negative", "lt", u, real(0)), block.op("minus", "neg", u), u)
        loop.update(largest, block.select("larger", block.op("more", "lt", largest, size), size, largest))
    factor = block.op("factor", "div", most, block.select("divisor", block.op("over", "lt", most, largest), largest, most))
    with block.loop("i", n) as loop:
        scaled = block.op("scaled_u", "mul", block.let("u_law_i", Load("u", loop.index)), factor)
        block.store("u", loop.index, _clamp(block, "u_held", scaled, real(-law.u_max[0]), most))


def margin_component(block: Block, apart: Apart, guarded: bool = True) -> Var:
    """Statements for the distance to the nearer edge over the width, at least -1. `guarded` as in `place_of`."""
    room = apart.room(block)
    width = _width(block, room) if guarded else room
    nearest, _ = nearest_of(block, apart)
    share = block.op("share", "div", nearest, width)
    beyond = block.op("beyond", "lt", share, real(-1))
    return block.select("held_share", beyond, real(-1), share)


MARGIN_DOC = (
    "How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the",
    "components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.",
    "Watch it: act while there is margin, not when the tube is left.",
)


MARGINS_DOC = (
    "The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all",
    "components where another argument is not finite.",
)


def transform_function(law: Law, n: int) -> Function:
    """The public `transform`: e, epsilon and xi for given edges and state, clamped like `control`."""
    block = Block({"lower", "upper", "x", "e", "epsilon", "xi"})
    with block.loop("i", n) as loop:
        i = loop.index
        lower_edge = block.let("lower_edge", Load("lower", i))
        upper_edge = block.let("upper_edge", Load("upper", i))
        x = block.let("x_i", Load("x", i))
        d = place_of(block, law.share(block, i), Between(lower_edge, upper_edge, x), (real(1), real(-1)))
        a = block.select("a", d.upper_nearer, d.far, d.near)
        b = block.select("b", d.upper_nearer, d.near, d.far)
        (raw,) = block.call(law.normalized_error, a, b, d.width, names=("e_raw",))
        most, least = law.signed_clamp(block, i)
        e = _clamp(block, "e_held", raw, least, most)
        size, xi = block.call(law.transformed_error, d.near, d.far, names=("epsilon_near", "xi_i"))
        epsilon = block.op("epsilon_i", "mul", d.gain, size)
        finite_x = block.let("finite_x", IsFinite(x))
        finite_room = block.let("finite_room", IsFinite(d.room))
        finite = block.op("finite", "and", finite_x, finite_room)
        for name, value in (("e", e), ("epsilon", epsilon), ("xi", xi)):
            assert d.empty is not None
            settled = block.select(f"{name}_settled", d.empty, real(0), value)
            block.store(name, i, block.select(f"{name}_out", finite, settled, NAN))
    block.leave()
    return Function(
        name="transform",
        params=tuple(Param(p, n) for p in ("lower", "upper", "x")) + tuple(Param(p, n, True) for p in ("e", "epsilon", "xi")),
        body=tuple(block.statements),
        returns_status=False,
        doc=(
            "Error transform of section IV for the state x in the box (lower, upper), by component:",
            "  e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]",
            "  epsilon = ln((1 + e) / (1 - e))",
            "  xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx",
            "0 in a component with upper <= lower; a width below 2^-20 counts as that.",
            "NaN where an edge, x or upper - lower is not finite.",
        ),
    )
