"""The figures of a design, as data: tube, certificate, inputs, sampling and cost. `design`, `report` and the README print
them."""

from __future__ import annotations

import math
import subprocess
import tempfile
from collections import Counter
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from stt_codegen.certify.missions import ServedEntry, served_entries
from stt_codegen.errors import SttError
from stt_codegen.pipeline import EmittedController
from stt_codegen.program import COST_KINDS
from stt_codegen.program.analyse import cost_of, table_bytes
from stt_codegen.program.targets.c.runner import STRICT, find_compiler
from stt_codegen.report.analysis import Analysis
from stt_codegen.report.bounds import SamplingReport, round_up
from stt_codegen.report.figures.control_notes import choice_lines, control_notes
from stt_codegen.report.notes import controller_notes, start_rim_cause


@dataclass(frozen=True, kw_only=True)
class CertifiedProperty:
    """One property of the certificate. margin: in the task's units or seconds; where: axis, set and time of the smallest
    margin."""

    property: str
    title: str
    statement: str
    holds: bool
    margin: float
    where: str


@dataclass(frozen=True)
class InputReport:
    """What the control law needs of actuators and clock.

    largest_u: |u| at the clamp where the tube is narrowest, None for an empty tube. sampling: what is proved about periods for
    any plant within [plant], None where the tube is not certified. tick_period: in seconds. chosen: sentences on the limit and
    the gain that were chosen for the tube.
    """

    largest_u: float | None
    sampling: SamplingReport | None
    u_max: tuple[float, ...]
    tick_period: float | None
    chosen: tuple[str, ...] = ()


@dataclass(frozen=True)
class CostReport:
    """What a step costs: operations by kind, bytes of tables, and of machine code on this host at -Os (None without compiler).

    functions: those that are called at each step.
    """

    functions: tuple[str, ...]
    operations: dict[str, int]
    operations_total: int
    table_bytes: int
    host_code_bytes: int | None


@dataclass(frozen=True, kw_only=True)
class DesignReport:
    """The figures of one design in the task's units.

    seconds: how long the design took. parameters: how many numbers fix the tube, in words. picture: path of its picture. mission:
    when each entry is served. cycle: from and until when, in seconds, the tube repeats. notes: see report/notes.py.
    start_left_out: by axis, how far gamma(0) is inside the initial set; start_cause: why, where a rim of it is not covered.
    """

    task: str
    design: str
    scalar: str
    certified: bool
    seconds: float
    prescribed_time: float
    parameters: str
    method: str
    smallest_width: float
    speed_bound: tuple[float, ...]
    covers_initial_set: bool
    axes: tuple[str, ...]
    units: tuple[str, ...]
    properties: tuple[CertifiedProperty, ...]
    input: InputReport
    cost: CostReport
    picture: str | None = None
    mission: tuple[ServedEntry, ...] = ()
    cycle: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()
    start_left_out: tuple[float, ...] = ()
    start_cause: str = ""

    def with_picture(self, path: Path) -> DesignReport:
        """Return the report with the path of its picture."""
        return replace(self, picture=str(path))

    def document(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        data = {"least_width" if key == "smallest_width" else key: value for key, value in asdict(self).items()}
        sampling = self.input.sampling
        data["input"]["sampling"] = None if sampling is None else sampling.document()
        return {k: v for k, v in data.items() if v or k not in ("picture", "mission", "cycle", "notes", "start_cause")}


def design_report(controller: EmittedController, seconds: float) -> DesignReport:
    """Return the figures of a controller. seconds: how long its design took."""
    task, certificate, design = controller.task, controller.certificate, controller.design
    cycle, inputs = None if certificate.mission is None else certificate.mission.cycle, input_report(controller)
    properties = tuple(
        CertifiedProperty(
            property=f.code,
            title=f.subject.word,
            statement=f.statement,
            holds=f.holds,
            margin=float(f.margin),
            where=f.location(certificate.axes),
        )
        for f in certificate.findings
    )
    return DesignReport(
        task=task.name,
        design=design.kind,
        scalar=controller.program.scalar,
        certified=certificate.holds,
        seconds=round(seconds, 3),
        prescribed_time=float(task.prescribed_time),
        parameters=design.size,
        method=certificate.method,
        smallest_width=float(certificate.minimum_width),
        speed_bound=tuple(float(v) for v in certificate.speed),
        covers_initial_set=certificate.covers_initial_set,
        axes=task.axis_names,
        units=task.units or ("",) * task.dimension,
        properties=properties,
        input=inputs,
        cost=cost_report(controller),
        picture=None,
        mission=() if certificate.mission is None else served_entries(task, certificate.mission),
        cycle=None if cycle is None else (float(cycle.begin), float(cycle.end)),
        notes=(*controller_notes(controller), *control_notes(task, inputs.largest_u)),
        start_left_out=tuple(
            round_up(float(max(low - a, b - high, Fraction(0))))
            for (low, high), a, b in zip(certificate.start, task.start.lower, task.start.upper, strict=True)
        ),
        start_cause="" if certificate.covers_initial_set or certificate.method != "exact" else start_rim_cause(controller),
    )


def input_report(controller: EmittedController) -> InputReport:
    """Return what the control law needs of actuators and clock."""
    task, certificate = controller.task, controller.certificate
    largest_u = clamp_input(controller)
    return InputReport(
        None if largest_u is None else round_up(largest_u),
        Analysis(controller).sampling() if certificate.holds else None,
        tuple(float(u) for u in task.u_max or ()),
        None if task.emit.tick_period is None else float(task.emit.tick_period),
        tuple(choice_lines(controller)),
    )


def clamp_input(controller: EmittedController) -> float | None:
    """Return the largest |u|, at the clamp where the tube is narrowest; None for an empty tube."""
    task, width = controller.task, float(controller.certificate.minimum_width)
    if width <= 0:
        return None
    rounding = 1 + 2.0**-18  # more than the rounding of the emitted law
    pairs = [(abs(float(k)), float(e)) for k, e in zip(task.gain, task.e_max, strict=True)]
    return max(4 * k / (width * (1 - e * e)) * math.log((1 + e) / (1 - e)) for k, e in pairs) * rounding


def cost_report(controller: EmittedController) -> CostReport:
    """Count the operations of a step (`control`, and `alpha_step` where there is one), and the bytes of tables and code."""
    program = controller.program
    functions = tuple(f.name for f in program.functions if f.name in ("control", "alpha_step"))
    counts = sum((cost_of(program, name) for name in functions), Counter())
    by_kind = {kind: counts[kind] for kind in COST_KINDS if counts[kind]}
    return CostReport(functions, by_kind, sum(counts.values()), table_bytes(program), _code_bytes(controller))


def _code_bytes(controller: EmittedController) -> int | None:
    """Return the bytes of machine code of the C file on this host, None without a compiler or `size`."""
    try:
        compiler = find_compiler()
        with tempfile.TemporaryDirectory() as folder:
            for name, data in controller.files.items():
                Path(folder, name).write_bytes(data)
            flags = [f for f in STRICT if f != "-O2"]
            source, target = f"{folder}/{controller.task.name}.c", f"{folder}/o.o"
            subprocess.run([compiler, *flags, "-Os", "-c", source, "-o", target], check=True, capture_output=True)
            output = subprocess.run(["size", "-A", target], check=True, capture_output=True, text=True).stdout
    except (SttError, OSError, subprocess.SubprocessError):
        return None
    return sum(int(line.split()[1]) for line in output.splitlines() if line.startswith(".text"))
