"""The report: one HTML file that stands alone: the tube over time, the emitted C to drive, the certificate, statements, evidence.

Everything in it comes from the controller and from what is run beside it. The page asks no network and no other file: style,
scripts (templates/report/), module and data are in it.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from typing import Any

from stt_codegen import __version__
from stt_codegen.certify import Certificate, Finding
from stt_codegen.certify.missions import describe_visit
from stt_codegen.decimals import by_component, decimal
from stt_codegen.emit import notice
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model
from stt_codegen.program.targets.template_files import template, template_folder
from stt_codegen.properties import Property
from stt_codegen.report.analysis import Analysis
from stt_codegen.report.figures import DesignReport
from stt_codegen.report.page.bill_of_materials import bill, library_calls
from stt_codegen.report.page.drive import Driven, driven, plant_driven, setting
from stt_codegen.report.page.evidence import Evidence, measured
from stt_codegen.report.page.scene import scene
from stt_codegen.report.sentences import sampling_lines
from stt_codegen.task import Task

SCRIPTS = ("scene", "arena", "solid", "strips", "drive", "page")  # in this order: each uses what is above it


@dataclass(frozen=True)
class Summary:
    """The page in three sentences."""

    asked: str
    files: str
    assumed: str


def page(controller: EmittedController, report: DesignReport, shown: Evidence, model: Model | None = None) -> bytes:
    """The report as UTF-8. shown: what was run beside it; model: what is driven and what the statements are about, in place of
    [plant]."""
    task, folder = controller.task, template_folder() / "report"
    if model is not None and controller.certificate.holds:
        sampling = Analysis(controller, model).sampling()
        report = replace(report, input=replace(report.input, sampling=sampling))
    plant = model or plant_driven(task)
    made = driven(controller, plant)
    w_max = float(plant.w_max) if model is not None else min(float(b.force) for b in task.plant_bounds)
    data = document(controller, report, made, plant, w_max)
    law, proved = report.input, report.input.sampling
    return (
        template("report/page.html.j2")
        .render(
            report=report,
            tool=f"stt_codegen {__version__}",
            summary=summary(controller),
            notice=_notice(controller),
            style=(folder / "page.css").read_text(encoding="utf-8"),
            script="\n".join((folder / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS),
            data=_embedded(data),
            dimension=task.dimension,
            body=any(task.half_extents),
            hours=any(c is not None and c.active_interval for c in task.courses),
            doubtful=any(c is not None and (c.clock_lag or c.clock_lead or c.spread) for c in task.courses),
            regions=data["regions"],
            target=data["target"],
            meets=data["meets"],
            drive=made,
            wasm_bytes=len(made.wasm),
            drive_origin=_origin(controller, made),
            plant=plant.name,
            files=[(name, len(text), hashlib.sha256(text).hexdigest()) for name, text in controller.files.items()],
            said=describe_visit,
            findings=[_finding(one, controller) for one in controller.certificate.findings],
            statements=[] if proved is None else list(sampling_lines(proved, law.tick_period)),
            largest_u=law.largest_u,
            limits=f", and held within {by_component(task.u_max)} (u_max)" if task.u_max is not None else "",
            evidence=shown,
            bill=_embedded(bill(controller)),
            bill_counts=f"{len(controller.files)} files, with their SHA-256, what they call, and the versions that made them",
        )
        .encode()
    )


def document(controller: EmittedController, report: DesignReport, made: Driven, plant: Model, w_max: float) -> dict[str, Any]:
    """The data of the page's scripts; drive: None where there is no module."""
    drive = None if made.reason else setting(controller, made, plant, w_max, report.input.sampling)
    return {"name": controller.task.name, **scene(controller, report.mission, report.cycle), "drive": drive}


def summary(controller: EmittedController) -> Summary:
    """What was asked, for which files something is shown, and what is assumed."""
    task, certificate = controller.task, controller.certificate
    sets, entries = len(task.unsafe), len(task.mission)
    asked = "within state_space"
    asked += f", {decimal(task.tube.clearance)} off {sets} unsafe {'set' if sets == 1 else 'sets'}" if sets else ""
    if task.target_set is not None:
        asked = f"from initial_set to target_set in {decimal(task.prescribed_time)} s, {asked}"
    asked += f"; {entries} {'entry' if entries == 1 else 'entries'} of a mission" if entries else ""
    asked += ", for ever" if task.repeat else ""
    prefix = task.name
    named = [f"{prefix}.c (SHA-256 {hashlib.sha256(controller.files[f'{prefix}.c']).hexdigest()[:16]}..)"]
    others = len(controller.files) - 1
    return Summary(
        asked + ".", f"{named[0]} and {others} files more", _assumed(task, certificate, bool(library_calls(controller.files)))
    )


def _assumed(task: Task, certificate: Certificate, calls: bool) -> str:
    """The assumptions by name."""
    names = ["no inertia (plant.order = 1) and no lag" if task.order == 1 else "no lag"]
    names.append("the bounds of [plant]" if task.plant.is_stated else "a plant as Theorem 4.1 has it")
    names.append("what is measured is the state" + (f" to {decimal(task.plant.noise)}" if task.plant.noise else ""))
    shown = {one.subject for one in certificate.findings if one.holds}
    known = f"samples as {Property.PERIOD.label} has them"
    names.append("sampling fast enough" if certificate.proved_period is None else known)
    if task.u_max is not None and not shown & {Property.LIMITS, Property.PERIOD}:
        names.append("u never reaches u_max")
    if task.body is None:
        names.append("a point for a robot")
    if task.has_timed_sets:
        names.append("the sets' motion and clock")
    if task.expanded_keys:
        was = "was" if len(task.expanded_keys) == 1 else "were"
        names.append(f"the sets that the {' and the '.join(task.expanded_keys)} {was} turned into")
    names.append("IEEE-754, the compiler" + (" and its library" if calls else ""))
    return "; ".join(names) + "."


def _notice(controller: EmittedController) -> str:
    """The header's sentences; what fails, one after the other."""
    lines = [line.strip() for line in notice(controller.task, controller.certificate)]
    if controller.certificate.holds:
        return " ".join(lines)
    return f"{lines[0]} {lines[1]} {'; '.join(lines[2:])}."


def _origin(controller: EmittedController, made: Driven) -> str:
    """What the module was compiled from."""
    name = f"{controller.task.name}.c"
    if made.inline:
        return f'made of {name} with emit.math = "inline": the file below calls the C library for its logarithm instead'
    if not controller.design.capabilities.inlines_logarithm:
        return f"made of the {name} below; its exp and log are the browser's, rounded from double"
    return f"made of the {name} below, as it is"


def _finding(one: Finding, controller: EmittedController) -> dict[str, Any]:
    """A row of the certificate; time: what the page goes to where the margin is least."""
    return {
        "label": one.subject.label,
        "statement": one.statement,
        "holds": one.holds,
        "margin": measured(one),
        "required": f"{float(one.required):.3g}" if one.required else "",
        "place": one.location(controller.certificate.axes),
        "time": None if one.time is None else float(sum(one.time) / 2),
    }


def _embedded(document: Any) -> str:
    """JSON within a script element."""
    return json.dumps(document, separators=(",", ":")).replace("<", "\\u003c")
