"""The facts that a theorem is about, as reading.py takes them from the three files that are shipped."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from stt_codegen.designs import RefinedDesign
from stt_codegen.theorem.unsafe_sets import Edges, Face, Normal, Shape


@dataclass(frozen=True, kw_only=True)
class Sampling:
    """What the task says of samples and of the plant, by component, and the certificate's rho and shift. lost: by the arithmetic
    of the law. noise: of a measured x, besides its rounding."""

    period: Fraction
    latency: Fraction
    share: Fraction
    force: tuple[Fraction, ...]
    g_min: tuple[Fraction, ...]
    g_max: tuple[Fraction, ...]
    g_cross: tuple[Fraction, ...]
    rho: tuple[Fraction, ...]
    shift: tuple[Fraction, ...]
    lost: Fraction
    noise: Fraction


Operand = tuple[str, int]  # ("V", number of a value) or ("C", a whole constant)
Statement = tuple[str, Operand, Operand]  # one operation of the C: sign, left, right


@dataclass(frozen=True, kw_only=True)
class Facts:
    """Unsafe sets are grown by the body and the state space shrunk; `unsafe` by name, `normals` for each of them; walls, goals:
    half-spaces that cut state space and target. design: the tube of the C's table; error: P7's bound in its units, at least the
    certificate's of every dimension. rate, last: K/t_c and the last spline time, as the C has them. code: `basis` and then
    `blend`, on s, q0 .. q3. beyond: what of this task the theorems about the loop are not yet about."""

    name: str
    scalar: str
    design: RefinedDesign
    state: tuple[Fraction, ...]
    space: Edges
    start: Edges
    target: Edges
    unsafe: tuple[tuple[str, Shape], ...]
    normals: tuple[tuple[Normal, ...], ...]
    walls: tuple[Face, ...]
    goals: tuple[Face, ...]
    clearance: Fraction
    min_width: Fraction
    error: int
    rate: Fraction
    last: Fraction
    code: tuple[Statement, ...]
    gain: tuple[Fraction, ...]
    e_max: tuple[Fraction, ...]
    u_max: tuple[Fraction, ...] | None
    tick: Fraction | None  # seconds
    inline: bool  # the logarithm is written out
    beyond: str
    sampling: Sampling | None

    @property
    def n(self) -> int:
        return len(self.state)

    @property
    def t_c(self) -> Fraction:
        return self.design.prescribed_time

    @property
    def unit(self) -> Fraction:
        return self.design.unit

    @property
    def table(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        return self.design.table

    @property
    def segments(self) -> int:
        return self.design.segments
