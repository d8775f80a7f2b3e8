"""What every function of a refined tube begins with: the segment at a time, the weights, and edges blended from the table."""

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
    """The kernels of the refined tube."""

    segment: Kernel
    basis: Kernel
    basis_rate: Kernel
    blend: Kernel


@cache  # they depend on no task
def kernels_of_the_tube() -> tuple[Kernel, Kernel, Kernel]:
    return (
        lower(refined_tube.basis(), ("6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6.",)),
        lower(refined_tube.basis_rate(), ("Derivative of the weights with respect to s.",)),
        lower(refined_tube.blend(), ("An edge of the tube (or its slope in spline time): sum of w_j q_j.",)),
    )


def segment_of(design: RefinedDesign, scalar: str) -> Kernel:
    """t -> index of the segment's first table entry, and the place s in the segment, for finite t held within [0, t_c].

    Spline time is held at the last number below K: its floor is then a segment whatever t is, without a second clamp."""
    k = design.segments
    t = Var("t", REAL)
    block = Block({"t", "row", "s"})
    positive = block.op("positive", "lt", real(0), t)
    started = block.select("started", positive, t, real(0))
    scaled = block.op("scaled", "mul", started, real(Fraction(k) / design.prescribed_time))
    end = real(largest_below(Fraction(k), scalar))
    u = block.select("u", block.op("early", "lt", scaled, end), scaled, end)
    index = block.let("segment", Trunc(u))
    s = block.op("place", "sub", u, block.op("base", "real", index))
    row = block.op("first", "imul", index, integer(2 * design.dimension))
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


def loaded(block: Block, n: int, at: Operand, side: int, label: str, kind: Type = REAL) -> list[Var]:
    """Statements for the four table entries of an edge, a row apart from table index `at` on."""
    entries = []
    for j in range(4):
        offset = 2 * n * j + side
        index = block.op(f"{label}_{j}", "iadd", at, integer(offset)) if offset else at
        entries.append(block.let(f"{label}_q{j}", Load("coefficients", index, kind)))
    return entries


def edge(block: Block, spline: SplineKernels, n: int, at: Operand, weights: tuple[Var, ...], side: int, name: str) -> Var:
    """Statements for one edge: its entries, blended by the weights."""
    entries = loaded(block, n, at, side, name.split("_", maxsplit=1)[0])
    (found,) = block.call(spline.blend, *weights, *entries, names=(name,))
    return found


def entry(block: Block, row: Operand, i: Operand) -> Var:
    """Table index of the first entry of dimension i."""
    return block.op("at", "iadd", row, block.op("pair", "imul", i, integer(2)))


def start(names: set[str], spline: SplineKernels, fill: tuple[str, ...], n: int) -> tuple[Block, Var, Var]:
    """Finite test of t (outputs NaN where it fails), then the segment."""
    block = Block(names)
    finite = block.let("finite", IsFinite(Var("t", REAL)))
    bad = block.op("bad", "not", finite)
    with block.leave_when(bad), block.loop("j", n) as loop:
        for name in fill:
            block.store(name, loop.index, NAN)
    row, s = block.call(spline.segment, Var("t", REAL))
    return block, row, s
