"""What a design is worth, as data: tube, certificate, what the law asks for, cost. The command line and the README print
these."""

from __future__ import annotations

import math
import subprocess
import tempfile
from collections import Counter
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from stt_codegen.certify.schedule import Served, served
from stt_codegen.compare.toolchain import STRICT, find_compiler
from stt_codegen.errors import SttError
from stt_codegen.pipeline import Controller
from stt_codegen.program.cost import cost_of, table_bytes
from stt_codegen.program.operations import COST_KINDS
from stt_codegen.report.analysis import Analysis
from stt_codegen.report.bounds import Sampling, above_float


@dataclass(frozen=True)
class Property:
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


@dataclass(frozen=True)
class DesignReport:
    """The figures of one design in the task's units; seconds: how long the design took; picture: where it was drawn;
    mission: when each of its entries is served; cycle: when, in seconds, what is repeated for ever begins and ends."""

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
    properties: tuple[Property, ...]
    input: Input
    cost: Cost
    picture: str | None = None
    mission: tuple[Served, ...] = ()
    cycle: tuple[float, float] | None = None

    def drawn(self, path: Path) -> DesignReport:
        """The same report, naming the picture that was drawn."""
        return replace(self, picture=str(path))

    def document(self) -> dict[str, Any]:
        """The report as JSON data."""
        data = asdict(self)
        sampling = self.input.sampling
        data["input"]["sampling"] = None if sampling is None else sampling.document()
        return {k: v for k, v in data.items() if v or k not in ("picture", "mission", "cycle")}


def design_report(controller: Controller, seconds: float) -> DesignReport:
    """The figures of one design."""
    task, certificate, design = controller.task, controller.certificate, controller.design
    cycle = None if certificate.mission is None else certificate.mission.cycle
    properties = tuple(
        Property(f.code, f.title, f.statement, f.holds, float(f.margin), f.place(certificate.axes)) for f in certificate.findings
    )
    return DesignReport(
        task.name, design.kind, controller.program.scalar, certificate.holds, round(seconds, 3), float(task.prescribed_time),
        design.size, certificate.method, float(certificate.least_width), tuple(float(v) for v in certificate.speed),
        certificate.whole_start, task.axis_names, task.units or ("",) * task.dimension, properties, input_report(controller),
        cost_report(controller), None, () if certificate.mission is None else served(task, certificate.mission),
        None if cycle is None else (float(cycle.begin), float(cycle.end)),
    )  # fmt: skip


def input_report(controller: Controller) -> Input:
    """What the law asks of actuator and clock."""
    task, certificate = controller.task, controller.certificate
    largest_u = clamp_input(controller)
    return Input(
        None if largest_u is None else above_float(largest_u),
        Analysis(controller).sampling() if certificate.holds else None,
        tuple(float(u) for u in task.u_max or ()),
        None if task.emit.tick_period is None else float(task.emit.tick_period),
    )


def clamp_input(controller: Controller) -> float | None:
    """|u| at the clamp where the tube is narrowest; None for an empty tube."""
    task, width = controller.task, float(controller.certificate.least_width)
    if width <= 0:
        return None
    rounding = 1 + 2.0**-18  # more than the emitted law's own
    pairs = [(abs(float(k)), float(e)) for k, e in zip(task.gain, task.e_max, strict=True)]
    return max(4 * k / (width * (1 - e * e)) * math.log((1 + e) / (1 - e)) for k, e in pairs) * rounding


def cost_report(controller: Controller) -> Cost:
    """Operations of one period (`control`, and `alpha_step` where there is one), bytes of tables and code."""
    program = controller.program
    step = tuple(f.name for f in program.functions if f.name in ("control", "alpha_step"))
    counts = sum((cost_of(program, name) for name in step), Counter())
    by_kind = {kind: counts[kind] for kind in COST_KINDS if counts[kind]}
    return Cost(step, by_kind, sum(counts.values()), table_bytes(program), _code_bytes(controller))


def _code_bytes(controller: Controller) -> int | None:
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
