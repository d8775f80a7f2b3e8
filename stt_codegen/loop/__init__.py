"""Closed loops: the emitted C drives a plant under disturbances. Runs, their traces and pictures."""

from stt_codegen.loop.command import Request, RunReport, simulate
from stt_codegen.loop.foretold import written_drive
from stt_codegen.loop.judged_sets import enlarged_sets
from stt_codegen.loop.simulate import Loop, Scenario, scenario_of_task

__all__ = ["Loop", "Request", "RunReport", "Scenario", "enlarged_sets", "scenario_of_task", "simulate", "written_drive"]
