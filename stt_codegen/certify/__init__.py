"""Certificates: properties P1 to P10 of a design and its Program, exact for refined tubes, by enclosures for adaptive ones."""

from stt_codegen.certify.certificate import Certificate, Finding, MissionProof, PathClaim, PeriodProof
from stt_codegen.certify.claims import SlackClaim, Stretch, claims_of, cuts_of
from stt_codegen.certify.limits import outweighs_disturbances, with_shares_of_norm
from stt_codegen.certify.monitor import Cycle, Span, Time, holds
from stt_codegen.certify.moving_slack import MovingBounds

__all__ = [
    "Certificate",
    "Cycle",
    "Finding",
    "MissionProof",
    "MovingBounds",
    "PathClaim",
    "PeriodProof",
    "SlackClaim",
    "Span",
    "Stretch",
    "Time",
    "adaptive",
    "claims_of",
    "cuts_of",
    "exact",
    "holds",
    "missions",
    "moving_slack",
    "outweighs_disturbances",
    "rounding_allowance",
    "sampled",
    "slack",
    "with_shares_of_norm",
]
