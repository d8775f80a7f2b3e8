"""The numbers of the emitted law and of its arithmetic, as the certificate states them and as they are computed here."""

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True)
class Law:
    """bits: of the scalar. gain and filters (lambda, for order 2) by component. rounding: what the law itself is off by, relative
    and in epsilon. edge_error and rate_error: by dimension what the arithmetic moves an edge or its rate by (P7), in the task's
    units and a second. edge_claims and rate_claims: the certificate's whole units for these."""

    scalar: str
    bits: int
    gain: list[Fraction]
    filters: list[Fraction]
    rounding: Fraction
    edge_error: list[Fraction]
    rate_error: list[Fraction]
    edge_claims: list[int]
    rate_claims: list[int]
