"""The numbers that a theorem is about. reading.py takes them from the three shipped files; *_theorem.py write them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.designs import RefinedDesign
from stt_codegen.theorem.unsafe_sets import Edges, HalfSpace, Normal, Shape


@dataclass(frozen=True, kw_only=True)
class SampledFacts:
    """The task's numbers of samples and plant, and the certificate's rho and shift; tuples are by component.

    disturbance: bound on |f + w|. rho: bound on e^|eps|. shift: bound on the error of x less an edge. law_error: of the law's
    arithmetic, relative and in the logarithm. noise: of a measured x, without its rounding. Times in seconds.
    """

    period: Fraction
    latency: Fraction
    share: Fraction
    disturbance: tuple[Fraction, ...]
    g_min: tuple[Fraction, ...]
    g_max: tuple[Fraction, ...]
    g_cross: tuple[Fraction, ...]
    rho: tuple[Fraction, ...]
    shift: tuple[Fraction, ...]
    law_error: Fraction
    noise: Fraction


Operand = tuple[str, int]  # ("V", number of a value) or ("C", an integer constant)
Statement = tuple[str, Operand, Operand]  # one operation of the C: sign, left, right


@dataclass(frozen=True, kw_only=True)
class Facts:
    """The numbers of one controller. Unsafe sets are grown by the body, and the state space is shrunk by it.

    design: the tube of the C's table. edge_error: P7's bound for all dimensions, in units of the table; no smaller than the
    certificate's.
    walls, goals: half-spaces that cut state space and target. normals: for each unsafe set. time_scale, last_spline_time: K/t_c
    and the end of the last segment, as the C has them. code: the statements of `basis` and then `edge_at`, on s, q0 .. q3.
    uncovered_loop_feature: what of this task no theorem about the loop covers yet; empty if all is covered.
    """

    name: str
    scalar: str
    design: RefinedDesign
    state: tuple[Fraction, ...]
    space: Edges
    start: Edges
    target: Edges
    unsafe: tuple[tuple[str, Shape], ...]  # with the set's name
    normals: tuple[tuple[Normal, ...], ...]
    walls: tuple[HalfSpace, ...]
    goals: tuple[HalfSpace, ...]
    clearance: Fraction
    min_width: Fraction
    edge_error: int
    time_scale: Fraction
    last_spline_time: Fraction
    code: tuple[Statement, ...]
    gain: tuple[Fraction, ...]
    e_max: tuple[Fraction, ...]
    u_max: tuple[Fraction, ...] | None
    tick_period: Fraction | None  # seconds
    has_inline_logarithm: bool
    uncovered_loop_feature: str
    sampling: SampledFacts | None

    @property
    def n(self) -> int:
        """The number of dimensions."""
        return len(self.state)

    @property
    def t_c(self) -> Fraction:
        """The prescribed time, in seconds."""
        return self.design.prescribed_time

    @property
    def unit(self) -> Fraction:
        """The unit of the table's integers, a power of two."""
        return self.design.unit

    @property
    def table(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """Integers (lower, upper) of the edges' spline coefficients: K + 3 rows of n pairs."""
        return self.design.table

    @property
    def segments(self) -> int:
        """The number K of spline segments from 0 to t_c."""
        return self.design.segments
