"""The control law (13) for one component of the state: error transform and input; and the public `transform`.

refined_frame.py, adaptive_frame.py and inertial_frame.py build their functions from these. Functions named `write_..` append
statements to a block of a Program and return the variables that hold the results. Strings that they pass are names in emitted
code. The lemmas `transform.*` and `functions.*` of docs/lemmas.md are about the kernels and the functions here.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from stt_codegen.controller.kernels.edge_distances import ClampedDistances, ValueBetweenEdges, write_clamped_distances
from stt_codegen.controller.kernels.logarithm import with_inline_logarithm
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
class ControlLaw:
    """The kernels of section IV and the constants of the control law (13) for one task, by component."""

    normalized_error: Kernel
    transformed_error: Kernel
    control_input: Kernel
    gain: tuple[Fraction, ...]
    e_max: tuple[Fraction, ...]
    u_max: tuple[Fraction, ...] | None
    scales_input: bool = False  # whether one factor brings all components of u within u_max, instead of saturation

    @property
    def kernels(self) -> tuple[Kernel, ...]:
        """All kernels of the law, as they are emitted."""
        return (self.normalized_error, self.transformed_error, self.control_input)

    @property
    def clamp_shares(self) -> tuple[Fraction, ...]:
        """By component, c = (1 - e_max)/2: the smallest distance to an edge over the width that the law calculates with."""
        return tuple((1 - v) / 2 for v in self.e_max)

    @property
    def tables(self) -> list[Table]:
        """The tables of constants that differ by component; a constant that all components share is written where it is used."""
        constants = (
            ("gain", self.gain, "Gain k of the control law, by component."),
            ("e_max", self.e_max, "Clamp of the normalized error, by component."),
            ("least_share", self.clamp_shares, "(1 - e_max)/2, by component."),
        )
        tables = [Table(name, values, len(values), (doc,)) for name, values, doc in constants if len(set(values)) > 1]
        if self.u_max is not None and not self.scales_input:
            tables.append(Table("u_max", self.u_max, len(self.u_max), ("Saturation of u, by component.",)))
        return tables

    def write_signed_gain(self, block: Block, i: Operand) -> tuple[Operand, Operand]:
        """Write statements for k and -k of component i."""
        return _write_signed_constant(block, "gain", self.gain, i)

    def write_signed_e_max(self, block: Block, i: Operand) -> tuple[Operand, Operand]:
        """Write statements for e_max and -e_max of component i."""
        return _write_signed_constant(block, "e_max", self.e_max, i)

    def write_clamp_share(self, block: Block, i: Operand) -> Operand:
        """Write statements for c = (1 - e_max)/2 of component i."""
        return _write_constant(block, "least_share", self.clamp_shares, i)

    def write_u_max(self, block: Block, i: Operand) -> Operand | None:
        """Write statements for u_max of component i; None where no component is saturated by itself."""
        return None if self.u_max is None or self.scales_input else block.let("u_limit", Load("u_max", i))


def _write_constant(block: Block, name: str, values: tuple[Fraction, ...], i: Operand) -> Operand:
    """Write statements for component i of `values`: the constant where all are equal, else an entry of the table `name`."""
    return real(values[0]) if len(set(values)) == 1 else block.let(f"{name}_i", Load(name, i))


def _write_signed_constant(block: Block, name: str, values: tuple[Fraction, ...], i: Operand) -> tuple[Operand, Operand]:
    """Write statements for component i of `values`, and for its negative."""
    value = _write_constant(block, name, values, i)
    return value, real(-values[0]) if isinstance(value, Const) else block.op(f"{name}_minus", "neg", value)


def build_control_law(task: Task) -> ControlLaw:
    """Build the law with the task's constants. Raises `BadInput` when u or a constant would leave the scalar's range."""
    _require_scalar_holds_law(task)
    normalized, transformed, control_input = _build_kernels()
    return ControlLaw(
        normalized_error=normalized,
        transformed_error=with_inline_logarithm(transformed) if task.emit.math == "inline" else transformed,
        control_input=control_input,
        gain=task.gain,
        e_max=task.e_max,
        u_max=task.emitted_u_max,
        scales_input=task.scales_input,
    )


def _require_scalar_holds_law(task: Task) -> None:
    """Raise `BadInput` when u could overflow the task's scalar, or when 1 - e_max or e_max is too few of its units."""
    scalar = task.emit.scalar
    largest, roundoff = FORMATS[scalar].largest, FORMATS[scalar].roundoff
    for gain, e_max in zip(task.gain, task.e_max, strict=True):
        largest_input = abs(gain) * 2 / ((1 - e_max) / 2 * MINIMUM_WIDTH) * 64  # 64 > ln((1 - c)/c) for every c in range
        if largest_input > largest / 4:
            raise BadInput(
                f"control: gain {float(gain):.6g} with e_max {float(e_max):.12g} overflows a {scalar}; "
                "lower control.gain or control.e_max"
            )
        is_too_coarse = (1 - e_max) / roundoff < 8 or e_max / roundoff < 1 << 12
        if is_too_coarse:
            limit = "1" if e_max > Fraction(1, 2) else "0"
            raise BadInput(
                f'control.e_max: {float(e_max):.12g} is too near {limit} for a {scalar}; use emit.scalar = "double" or another'
            )


@cache  # they depend on no task
def _build_kernels() -> tuple[Kernel, Kernel, Kernel]:
    """Build the kernels of the normalized error, of the transformed error, and of u by (13)."""
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


def _write_clamp(block: Block, label: str, value: Operand, low: Operand, high: Operand) -> Var:
    """Write statements for the value clamped to [low, high]; a NaN becomes `low`, so that no NaN reaches a division."""
    is_above_low = block.op(f"{label}_above", "lt", low, value)
    raised = block.select(f"{label}_raised", is_above_low, value, low)
    is_above_high = block.op(f"{label}_beyond", "lt", high, raised)
    return block.select(f"{label}_limited", is_above_high, high, raised)


def write_input(block: Block, law: ControlLaw, distances: ClampedDistances, u_max: Operand | None) -> Var:
    """Write statements for one component of u: (13) on the clamped distances, 0 where the tube is empty, saturated by u_max.

    (13) is odd about the middle of the tube: measured from the upper edge, a and b change places and u its sign."""
    epsilon, xi = block.call(law.transformed_error, distances.clamped_near, distances.clamped_far)
    (unlimited,) = block.call(law.control_input, distances.gain, xi, epsilon, names=("u_i",))
    u = unlimited if distances.is_empty is None else block.select("u_or_zero", distances.is_empty, real(0), unlimited)
    if u_max is None:
        return u
    return _write_clamp(block, "u", u, block.op("u_min", "neg", u_max), u_max)


def write_input_scaling(block: Block, law: ControlLaw, n: int) -> None:
    """Write statements that bring the stored u within u_max by one factor for all n components; none without `scales_input`."""
    if law.u_max is None or not law.scales_input:
        return
    u_max = real(law.u_max[0])
    with block.loop("p", n) as loop:
        largest = loop.carry("largest", real(0))
        u = block.let("u_p", Load("u", loop.index))
        size = block.select("size", block.op("negative", "lt", u, real(0)), block.op("minus", "neg", u), u)
        loop.update(largest, block.select("larger", block.op("more", "lt", largest, size), size, largest))
    is_beyond = block.op("over", "lt", u_max, largest)
    factor = block.op("factor", "div", u_max, block.select("divisor", is_beyond, largest, u_max))
    with block.loop("r", n) as loop:
        scaled = block.op("u_scaled", "mul", block.let("u_r", Load("u", loop.index)), factor)
        block.store("u", loop.index, _write_clamp(block, "u", scaled, real(-law.u_max[0]), u_max))


def build_transform(law: ControlLaw, n: int) -> Function:
    """Build the public `transform`: e, epsilon and xi for given edges and state (n,), clamped like `control`."""
    block = Block({"lower", "upper", "x", "e", "epsilon", "xi"})
    with block.loop("i", n) as loop:
        _write_transform_of_component(block, law, loop.index)
    block.leave()
    inputs = tuple(Param(name, n) for name in ("lower", "upper", "x"))
    return Function(
        name="transform",
        params=inputs + tuple(Param(name, n, output=True) for name in ("e", "epsilon", "xi")),
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


def _write_transform_of_component(block: Block, law: ControlLaw, i: Var) -> None:
    """Write statements that store e, epsilon and xi of component i: 0 in an empty tube, NaN where a number is not finite."""
    lower_edge = block.let("lower_edge", Load("lower", i))
    upper_edge = block.let("upper_edge", Load("upper", i))
    x = block.let("x_i", Load("x", i))
    # A gain of 1 and -1 is the sign that epsilon has: minus where the upper edge is the nearer one.
    x_between_edges = ValueBetweenEdges(lower_edge, upper_edge, x)
    d = write_clamped_distances(block, law.write_clamp_share(block, i), x_between_edges, (real(1), real(-1)), gain_name="sign")
    a = block.select("a", d.is_upper_nearer, d.clamped_far, d.clamped_near)
    b = block.select("b", d.is_upper_nearer, d.clamped_near, d.clamped_far)
    (raw_e,) = block.call(law.normalized_error, a, b, d.width, names=("e_i",))
    e_max, e_min = law.write_signed_e_max(block, i)
    e = _write_clamp(block, "e", raw_e, e_min, e_max)
    epsilon_from_nearer, xi = block.call(law.transformed_error, d.clamped_near, d.clamped_far, names=("epsilon_nearer", "xi_i"))
    epsilon = block.op("epsilon_i", "mul", d.gain, epsilon_from_nearer)
    is_x_finite = block.let("finite_x", IsFinite(x))
    is_width_finite = block.let("finite_width", IsFinite(d.raw_width))
    is_finite = block.op("finite", "and", is_x_finite, is_width_finite)
    assert d.is_empty is not None
    for name, value in (("e", e), ("epsilon", epsilon), ("xi", xi)):
        zero_if_empty = block.select(f"{name}_or_zero", d.is_empty, real(0), value)
        block.store(name, i, block.select(f"{name}_out", is_finite, zero_if_empty, NAN))
