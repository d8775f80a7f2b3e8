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
from stt_codegen.program import (
    INT,
    NAN,
    REAL,
    Assign,
    Block,
    IsFinite,
    Kernel,
    Load,
    Operand,
    Trunc,
    Var,
    integer,
    largest_below,
    real,
)
from stt_codegen.program.convert import lower


@dataclass(frozen=True)
class SplineKernels:
    """The kernels of the refined tube: segment at a time, B-spline weights and their derivatives, and an edge by the weights."""

    segment: Kernel
    basis: Kernel
    basis_rate: Kernel
    edge_at: Kernel


@cache
def build_blending_kernels(n: int) -> tuple[Kernel, Kernel, Kernel]:
    """Build the kernels `basis`, `basis_rate` and `edge_at` of SplineKernels, for n dimensions."""
    return (
        lower(refined_tube.basis(), ("6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6.",)),
        lower(refined_tube.basis_rate(), ("Derivative of the weights with respect to s.",)),
        _build_edge_kernel(n),
    )


def _build_edge_kernel(n: int) -> Kernel:
    """Build the kernel from a table index and the weights to an edge, or to its slope if the weights are derivatives.

    It loads the four control points, one in each of four rows of 2 n entries, and blends them as paper/refined_tube.py says."""
    blend = lower(refined_tube.blend())
    at, weights = Var("at", INT), blend.inputs[:4]
    block = Block({at.name, *(v.name for v in blend.inputs)})
    for j, point in enumerate(blend.inputs[4:]):
        index = block.op(f"at_{j}", "iadd", at, integer(2 * n * j)) if j else at
        block.statements.append(Assign(point, Load("coefficients", index)))
    doc = (
        "An edge of the tube (or its slope in spline time): sum of w_j q_j,",
        "of the control points that stand at `at` and one, two and three rows after it.",
    )
    body = (*block.statements, *blend.body)
    return Kernel("edge_at", (at, *weights), body, blend.outputs, blend.output_names, doc=doc)  # type: ignore[arg-type]


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


def write_edge(block: Block, spline: SplineKernels, index: Var, weights: tuple[Var, ...], name: str) -> Var:
    """Write statements for one edge, or for its slope if the weights are derivatives. name: of the variable."""
    (edge,) = block.call(spline.edge_at, index, *weights, names=(name,))
    return edge


def write_edge_indices(block: Block, row: Operand, i: Operand) -> tuple[Var, Var]:
    """Write statements for the table indices of both edges of dimension i in a row: lower, upper."""
    lower_index = block.op("lower_at", "iadd", row, block.op("pair", "imul", i, integer(2)))
    return lower_index, block.op("upper_at", "iadd", lower_index, integer(1))


def write_edges(block: Block, spline: SplineKernels, indices: tuple[Var, Var], weights: tuple[Var, ...]) -> tuple[Var, Var]:
    """Write statements for both edges of a dimension: lower, upper. indices: from `write_edge_indices`."""
    lower_index, upper_index = indices
    lower_edge = write_edge(block, spline, lower_index, weights, "lower_edge")
    return lower_edge, write_edge(block, spline, upper_index, weights, "upper_edge")


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
