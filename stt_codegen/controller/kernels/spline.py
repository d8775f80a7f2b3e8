"""What every function of a refined tube begins with: the segment at a time, the weights, and edges blended from the table.

refined_frame.py and inertial_frame.py build their functions from these. Functions named `write_..` append statements to a block
of a Program and return the variables that hold the results. Strings that they pass are names in emitted code. The lemmas
`kernels.*` and `refined.*` of docs/lemmas.md are about the kernels.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from stt_codegen.decimals import decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.paper import refined_tube
from stt_codegen.program import NAN, REAL, Block, IsFinite, Kernel, Load, Operand, Trunc, Type, Var, integer, largest_below, real
from stt_codegen.program.convert import lower


@dataclass(frozen=True)
class SplineKernels:
    """The kernels of the refined tube: segment at a time, B-spline weights and their derivatives, and the weighted sum."""

    segment: Kernel
    basis: Kernel
    basis_rate: Kernel
    blend: Kernel


@cache  # they depend on no task
def build_blending_kernels() -> tuple[Kernel, Kernel, Kernel]:
    """Build the kernels `basis`, `basis_rate` and `blend` of SplineKernels."""
    return (
        lower(refined_tube.basis(), ("6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6.",)),
        lower(refined_tube.basis_rate(), ("Derivative of the weights with respect to s.",)),
        lower(refined_tube.blend(), ("An edge of the tube (or its slope in spline time): sum of w_j q_j.",)),
    )


def build_segment_kernel(design: RefinedDesign, scalar: str) -> Kernel:
    """Build the kernel from finite t to (index of the segment's first table entry, position s in [0, 1] in the segment).

    t is clamped to [0, t_c]. Spline time is clamped to the largest number below K = `segments`: its floor is then a segment
    for every t, without a second clamp."""
    k = design.segments
    t = Var("t", REAL)
    block = Block({"t", "row", "s"})
    is_positive = block.op("positive", "lt", real(0), t)
    nonnegative_t = block.select("started", is_positive, t, real(0))
    unclamped_u = block.op("scaled", "mul", nonnegative_t, real(Fraction(k) / design.prescribed_time))
    end = real(largest_below(Fraction(k), scalar))
    u = block.select("u", block.op("early", "lt", unclamped_u, end), unclamped_u, end)
    segment_index = block.let("segment", Trunc(u))
    s = block.op("place", "sub", u, block.op("base", "real", segment_index))
    row = block.op("first", "imul", segment_index, integer(2 * design.dimension))
    return Kernel(
        name="segment",
        inputs=(t,),
        body=tuple(block.statements),  # type: ignore[arg-type]
        outputs=(row, s),
        output_names=("row", "s"),
        doc=(
            f"Spline time u = {k} t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).",
            f"Before 0 the start; from t_c on the last number below {k} (t_c = {decimal(design.prescribed_time)} s).",
        ),
    )


def write_control_points(
    block: Block, n: int, first_index: Operand, *, side: int, label: str, number_type: Type = REAL
) -> list[Var]:
    """Write statements that load the four control points of an edge: side LOWER or UPPER, of a table with n dimensions.

    first_index: table index of the component's lower edge in the segment's first row; one row is 2 n entries."""
    control_points = []
    for j in range(4):
        offset = 2 * n * j + side
        index = block.op(f"{label}_{j}", "iadd", first_index, integer(offset)) if offset else first_index
        control_points.append(block.let(f"{label}_q{j}", Load("coefficients", index, number_type)))
    return control_points


def write_edge(
    block: Block, spline: SplineKernels, first_index: Operand, weights: tuple[Var, ...], *, n: int, side: int, name: str
) -> Var:
    """Write statements for one edge, or for its slope if the weights are derivatives: control points blended by the weights.

    n, side, first_index: as in `write_control_points`. name: of the variable, "lower_edge" for example."""
    control_points = write_control_points(block, n, first_index, side=side, label=name.split("_", maxsplit=1)[0])
    (edge,) = block.call(spline.blend, *weights, *control_points, names=(name,))
    return edge


def write_first_index(block: Block, row: Operand, i: Operand) -> Var:
    """Write statements for the table index of the lower edge of dimension i in a row."""
    return block.op("at", "iadd", row, block.op("pair", "imul", i, integer(2)))


def begin_block_at_time(names: set[str], spline: SplineKernels, nan_outputs: tuple[str, ...], n: int) -> tuple[Block, Var, Var]:
    """Begin the block of a function of t: it leaves with NaN in the outputs where t is not finite, then computes the segment.

    names: the function's parameters. nan_outputs: those of them, arrays (n,), that become NaN. Returns the block, the table
    index of the segment's first row, and s."""
    block = Block(names)
    is_finite = block.let("finite", IsFinite(Var("t", REAL)))
    is_bad = block.op("bad", "not", is_finite)
    with block.leave_when(is_bad), block.loop("j", n) as loop:
        for name in nan_outputs:
            block.store(name, loop.index, NAN)
    row, s = block.call(spline.segment, Var("t", REAL))
    return block, row, s
