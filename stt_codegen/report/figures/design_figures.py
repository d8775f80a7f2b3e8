"""What a design is worth, as data: tube, certificate, what the law asks for, cost. The command line and the README print
these."""

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
from stt_codegen.report.bounds import Sampling, above_float
from stt_codegen.report.notes import task_notes


@dataclass(frozen=True, kw_only=True)
class CertifiedProperty:
    """One finding of the certificate, in short: margin in the task's units."""

    property: str
    title: str
    statement: str
    holds: bool
    margin: float
    where: str


@dataclass(frozen=True)
class Input:
    """What the law asks of actuator and clock. largest_u: |u| at the clamp where the tube is narrowest, None for an empty tube;
    sampling: what is proved about the period for the plant of the task's [plant], None where the tube is not certified."""

    largest_u: float | None
    sampling: Sampling | None
    u_max: tuple[float, ...]
    tick_period: float | None


@dataclass(frozen=True)
class Cost:
    """Operations of one period by kind, bytes of tables, and bytes of code on this host at -Os (None without a compiler)."""

    functions: tuple[str, ...]
    operations: dict[str, int]
    operations_total: int
    table_bytes: int
    host_code_bytes: int | None


@dataclass(frozen=True, kw_only=True)
class DesignReport:
    """The figures of one design in the task's units; seconds: how long the design took; picture: where it was drawn;
    mission: when each of its entries is served; cycle: when, in seconds, what is repeated for ever begins and ends; notes: about
    sets that are others than the listed points may suggest, and which way round, where axes close or might; start_left_out: by
    axis how far gamma(0) stays inside the initial set."""

    task: str
    design: str
    scalar: str
    certified: bool
    seconds: float
    prescribed_time: float
    parameters: str
    method: str
    least_width: float
    speed_bound: tuple[float, ...]
    covers_initial_set: bool
    axes: tuple[str, ...]
    units: tuple[str, ...]
    properties: tuple[CertifiedProperty, ...]
    input: Input
    cost: Cost
    picture: str | None = None
    mission: tuple[ServedEntry, ...] = ()
    cycle: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()
    start_left_out: tuple[float, ...] = ()

    def drawn(self, path: Path) -> DesignReport:
        """The same report, naming the picture that was drawn."""
        return replace(self, picture=str(path))

    def document(self) -> dict[str, Any]:
        """The report as JSON data."""
        data = asdict(self)
        sampling = self.input.sampling
        data["input"]["sampling"] = None if sampling is None else sampling.document()
        return {k: v for k, v in data.items() if v or k not in ("picture", "mission", "cycle", "notes")}


def design_report(controller: EmittedController, seconds: float) -> DesignReport:
    """The figures of one design."""
    task, certificate, design = controller.task, controller.certificate, controller.design
    cycle = None if certificate.mission is None else certificate.mission.cycle
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
        least_width=float(certificate.minimum_width),
        speed_bound=tuple(float(v) for v in certificate.speed),
        covers_initial_set=certificate.covers_initial_set,
        axes=task.axis_names,
        units=task.units or ("",) * task.dimension,
        properties=properties,
        input=input_report(controller),
        cost=cost_report(controller),
        picture=None,
        mission=() if certificate.mission is None else served_entries(task, certificate.mission),
        cycle=None if cycle is None else (float(cycle.begin), float(cycle.end)),
        notes=task_notes(task),
        start_left_out=tuple(
            above_float(float(max(low - a, b - high, Fraction(0))))
            for (low, high), a, b in zip(certificate.start, task.start.lower, task.start.upper, strict=True)
        ),
    )


def input_report(controller: EmittedController) -> Input:
    """What the law asks of actuator and clock."""
    task, certificate = controller.task, controller.certificate
    largest_u = clamp_input(controller)
    return Input(
        None if largest_u is None else above_float(largest_u),
        Analysis(controller).sampling() if certificate.holds else None,
        tuple(float(u) for u in task.u_max or ()),
        None if task.emit.tick_period is None else float(task.emit.tick_period),
    )


def clamp_input(controller: EmittedController) -> float | None:
    """|u| at the clamp where the tube is narrowest; None for an empty tube."""
    task, width = controller.task, float(controller.certificate.minimum_width)
    if width <= 0:
        return None
    rounding = 1 + 2.0**-18  # more than the emitted law's own
    pairs = [(abs(float(k)), float(e)) for k, e in zip(task.gain, task.e_max, strict=True)]
    return max(4 * k / (width * (1 - e * e)) * math.log((1 + e) / (1 - e)) for k, e in pairs) * rounding


def cost_report(controller: EmittedController) -> Cost:
    """Operations of one period (`control`, and `alpha_step` where there is one), bytes of tables and code."""
    program = controller.program
    step = tuple(f.name for f in program.functions if f.name in ("control", "alpha_step"))
    counts = sum((cost_of(program, name) for name in step), Counter())
    by_kind = {kind: counts[kind] for kind in COST_KINDS if counts[kind]}
    return Cost(step, by_kind, sum(counts.values()), table_bytes(program), _code_bytes(controller))


def _code_bytes(controller: EmittedController) -> int | None:
    """Bytes of machine code of the whole C file on this host, or None without a compiler or `size`."""
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
