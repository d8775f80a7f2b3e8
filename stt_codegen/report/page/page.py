"""Write the report: one HTML file with the tube over time, the emitted C to drive, the certificate, sampling and evidence.

The page loads no other file and needs no network: style, scripts (templates/report/), module and data are in it.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from typing import Any

from stt_codegen import __version__
from stt_codegen.certify import Certificate, Finding
from stt_codegen.certify.missions import describe_visit
from stt_codegen.decimals import by_component, by_dimension, decimal
from stt_codegen.emit import notice
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model
from stt_codegen.program.targets.template_files import template, template_folder
from stt_codegen.properties import OF_THE_INPUT, Property
from stt_codegen.report.analysis import Analysis
from stt_codegen.report.figures import DesignReport, assumed_words
from stt_codegen.report.page.bill_of_materials import bill_of_materials, library_calls
from stt_codegen.report.page.drive import DriveModule, compile_drive_module, default_plant, drive_settings
from stt_codegen.report.page.evidence import Evidence, format_margin
from stt_codegen.report.page.scene import scene
from stt_codegen.report.sentences import Line, sampling_lines
from stt_codegen.task import Task

SCRIPT_NAMES = ("scene", "arena", "solid", "strips", "drive", "page")  # in this order: each uses names of those before it


@dataclass(frozen=True)
class Summary:
    """The head of the page. requirement: of the task; files: those that the certificate is about; assumptions: by name."""

    requirement: str
    files: str
    assumptions: str


def page(controller: EmittedController, report: DesignReport, evidence: Evidence, model: Model | None = None) -> bytes:
    """Return the page as UTF-8. model: the plant to drive, and to prove sampling for, in place of the table [plant]."""
    task, folder = controller.task, template_folder() / "report"
    if model is not None and controller.certificate.holds:
        sampling = Analysis(controller, model).sampling()
        report = replace(report, input=replace(report.input, sampling=sampling))
    plant = model or default_plant(task)
    module = compile_drive_module(controller, plant)
    w_max = float(plant.w_max) if model is not None else min(float(b.force) for b in task.plant_bounds)
    data = page_data(controller, report, module, plant, w_max)
    inputs, sampling_report = report.input, report.input.sampling
    return (
        template("report/page.html.j2")
        .render(
            report=report,
            tool=f"stt_codegen {__version__}",
            summary=summary(controller),
            notice=_notice_sentences(controller),
            style=(folder / "page.css").read_text(encoding="utf-8"),
            script="\n".join((folder / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPT_NAMES),
            data=_json_for_script(data),
            dimension=task.dimension,
            has_body=any(task.half_extents),
            has_active_intervals=any(c is not None and c.active_interval for c in task.courses),
            has_timing_uncertainty=any(c is not None and (c.clock_lag or c.clock_lead or c.spread) for c in task.courses),
            regions=data["regions"],
            target=data["target"],
            meets=data["meets"],
            module=module,
            wasm_bytes=len(module.wasm),
            module_origin=_module_origin(controller, module),
            plant=plant.name,
            files=[(name, len(text), hashlib.sha256(text).hexdigest()) for name, text in controller.files.items()],
            describe_visit=describe_visit,
            findings=[_finding_row(finding, controller) for finding in controller.certificate.findings],
            sampling_lines=[Line(text) for text in inputs.chosen]
            + ([] if sampling_report is None else list(sampling_lines(sampling_report, inputs.tick_period))),
            largest_u=inputs.largest_u,
            limits=f", and held within {by_component(task.u_max)} (u_max)" if task.u_max is not None else "",
            evidence=evidence,
            bill=_json_for_script(bill_of_materials(controller)),
            bill_counts=f"{len(controller.files)} files, with their SHA-256, what they call, and the versions that made them",
        )
        .encode()
    )


def page_data(
    controller: EmittedController, report: DesignReport, module: DriveModule, plant: Model, w_max: float
) -> dict[str, Any]:
    """Return the data of the page's scripts. w_max: bound on |w| for which sampling is proved."""
    drive = None if module.reason else drive_settings(controller, module, plant, w_max, report.input.sampling)
    return {"name": controller.task.name, **scene(controller, report.mission, report.cycle), "drive": drive}


def summary(controller: EmittedController) -> Summary:
    """Summarize what the task requires, which files the certificate is about, and what is assumed."""
    task, certificate = controller.task, controller.certificate
    sets, entries = len(task.unsafe), len(task.mission)
    requirement = "within state_space"
    requirement += f", {by_dimension(task.clearances)} off {sets} unsafe {'set' if sets == 1 else 'sets'}" if sets else ""
    if task.target_set is not None:
        requirement = f"from initial_set to target_set in {decimal(task.prescribed_time)} s, {requirement}"
    requirement += f"; {entries} {'entry' if entries == 1 else 'entries'} of a mission" if entries else ""
    requirement += ", for ever" if task.repeat else ""
    prefix = task.name
    digest = hashlib.sha256(controller.files[f"{prefix}.c"]).hexdigest()[:16]
    files = f"{prefix}.c (SHA-256 {digest}..) and {len(controller.files) - 1} files more"
    return Summary(f"{requirement}.", files, _assumptions(task, certificate, bool(library_calls(controller.files))))


def _assumptions(task: Task, certificate: Certificate, calls_library: bool) -> str:
    """Return the assumptions by name, as one sentence."""
    lag = "drives as [plant] states them" if task.has_drive else "no lag"
    names = [f"no inertia (plant.order = 1) and {lag}" if task.order == 1 else lag]
    stated = "the bounds of [plant]" if task.plant.is_stated else "a plant as Theorem 4.1 has it"
    names.append(f"a plant of which the task says nothing: {assumed_words(task)}" if task.assumes_plant else stated)
    names.append("what is measured is the state" + (f" to {by_dimension(task.noise)}" if any(task.noise) else ""))
    proved_properties = {finding.subject for finding in certificate.findings if finding.holds}
    proved_sampling = f"samples as {Property.PERIOD.label} has them"
    names.append("sampling fast enough" if certificate.proved_period is None else proved_sampling)
    if task.u_max is not None and not proved_properties & OF_THE_INPUT:
        names.append("u never reaches u_max")
    if task.body is None:
        names.append("a point for a robot")
    if task.has_timed_sets:
        names.append("the sets' motion and clock")
    if task.expanded_keys:
        was = "was" if len(task.expanded_keys) == 1 else "were"
        names.append(f"the sets that the {' and the '.join(task.expanded_keys)} {was} turned into")
    names.append("IEEE-754, the compiler" + (" and its library" if calls_library else ""))
    return "; ".join(names) + "."


def _notice_sentences(controller: EmittedController) -> str:
    """Return the notice of the emitted header as one paragraph, with the properties that fail."""
    lines = [line.strip() for line in notice(controller.task, controller.certificate)]
    if controller.certificate.holds:
        return " ".join(lines)
    return f"{lines[0]} {lines[1]} {'; '.join(lines[2:])}."


def _module_origin(controller: EmittedController, module: DriveModule) -> str:
    """Say from which C the module was compiled."""
    name = f"{controller.task.name}.c"
    if module.has_inline_logarithm:
        return f'made of {name} with emit.math = "inline": the file below calls the C library for its logarithm instead'
    if not controller.design.capabilities.inlines_logarithm:
        return f"made of the {name} below; its exp and log are the browser's, rounded from double"
    return f"made of the {name} below, as it is"


def _finding_row(finding: Finding, controller: EmittedController) -> dict[str, Any]:
    """Return a row of the certificate's table. time: the middle of the interval with the smallest margin, in seconds."""
    return {
        "label": finding.subject.label,
        "statement": finding.statement,
        "holds": finding.holds,
        "margin": format_margin(finding),
        "required": f"{float(finding.required):.3g}" if finding.required else "",
        "where": finding.location(controller.certificate.axes),
        "time": None if finding.time is None else float(sum(finding.time) / 2),
    }


def _json_for_script(page_data: Any) -> str:
    """Return JSON that can stand in a script element."""
    return json.dumps(page_data, separators=(",", ":")).replace("<", "\\u003c")
