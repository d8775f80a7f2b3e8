"""The certificate of an adaptive or literal tube, by enclosures, and its falsification at samples."""

from stt_codegen.certify.adaptive.alpha_curves import SLACK, Cell, Curve, extremes_ahead
from stt_codegen.certify.adaptive.enclosure import certify_enclosed, enclosed_tube, enclosed_windows
from stt_codegen.certify.adaptive.falsification import falsify

__all__ = [
    "SLACK",
    "Cell",
    "Curve",
    "alpha_curves",
    "certify_enclosed",
    "enclosed_tube",
    "enclosed_windows",
    "extremes_ahead",
    "falsify",
]
