"""Recorded steps of a drive, and the lag, latency and overshoot that hold for the drive."""

from stt_codegen.steps.envelope import StepEnvelope, envelope_of
from stt_codegen.steps.recording import read_record

__all__ = ["StepEnvelope", "envelope_of", "read_record"]
