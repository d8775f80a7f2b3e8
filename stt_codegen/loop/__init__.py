"""Closed loops: the emitted C drives a plant under disturbances; runs, traces, pictures."""

from stt_codegen.loop.command import Request, RunReport, simulate
from stt_codegen.loop.simulate import Loop, Scenario, doubtful, of_task

__all__ = ["Loop", "Request", "RunReport", "Scenario", "doubtful", "of_task", "simulate"]
