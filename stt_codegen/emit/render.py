"""From a Program and its certificate to the text of the four files. Templates place text; everything is decided here."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import textwrap
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import jinja2

from stt_codegen.certify.certificate import Certificate, Finding, PeriodProof
from stt_codegen.decimals import above, below, decimal, exact_decimal, nine_digits
from stt_codegen.designs import AdaptiveDesign, RefinedDesign
from stt_codegen.emit.naming import check_names, file_names, selftest_name
from stt_codegen.program import Const, Program, Status
from stt_codegen.program.number import round_down, round_to
from stt_codegen.program.print.c import CPrinter
from stt_codegen.program.print.python import PythonPrinter
from stt_codegen.task import Task

Files = dict[str, bytes]
NO_BREAK = "\u00a0"
CERTIFICATE_FORMAT = 1
DIGITS = {"exact": 6, "enclosure": 4, "sampled": 6}  # of margins and bounds: fewer where a library's last digit has a part


def render(task: Task, design: RefinedDesign | AdaptiveDesign, program: Program, certificate: Certificate) -> Files:
    """The emitted files by name: header, C, Python, certificate. UTF-8 with LF line ends; no date, version or path."""
    check_names(program)
    header, source, module, proof = file_names(task.name)
    printer, python = CPrinter(program), PythonPrinter(program)
    precision = "single" if program.scalar == "float" else "double"
    common: dict[str, Any] = {
        "prefix": task.name,
        "macro": task.name.upper(),
        "program": program,
        "statuses": list(Status),
        "precision": precision,
        "scalar": program.scalar,
        "kind": design.kind,
        "hash": design_hash(task, design),
        "notice": _notice(task, certificate),
        "selftest": task.emit.selftest,
        "steps": certificate.steps if certificate.holds else None,
    }
    t_c = Const(round_to(task.prescribed_time, program.scalar))
    period = task.emit.tick_period
    if certificate.proved_period is not None:
        common["proved"] = Const(round_down(certificate.proved_period.period, program.scalar))
    if period is not None:
        common["tick"] = Const(round_to(period, program.scalar))
        common["last_tick"] = math.ceil(task.prescribed_time / period)
    shown = [printer.literal(Const(round_to(v, program.scalar))) for v in common["steps"] or ()]
    files = {
        header: template("controller.h.j2").render(**common, c=printer, t_c_literal=printer.literal(t_c), step_literals=shown),
        source: template("controller.c.j2").render(**common, c=printer),
        module: template("controller.py.j2").render(**common, python=python, t_c_literal=python.literal(t_c)),
    }
    if task.emit.selftest and any(f.name == "control" for f in program.functions):  # a probe has none
        from stt_codegen.emit.selftest import suites

        made = suites(task, design, program)
        total = sum(len(v.statuses) for v in made)
        files[selftest_name(task.name)] = template("selftest.c.j2").render(**common, c=printer, suites=made, total=total)
    encoded = {name: text.encode() for name, text in files.items()}
    digests = {name: hashlib.sha256(data).hexdigest() for name, data in encoded.items()}
    document = certificate_document(task, design, program, certificate, digests)
    encoded[proof] = (json.dumps(document, indent=2, ensure_ascii=True) + "\n").encode()
    return encoded


def design_hash(task: Task, design: RefinedDesign | AdaptiveDesign) -> str:
    """16 hex digits that name this design and its options; firmware logs it to tell which controller runs."""
    data = {"task": task.digest, "scalar": task.emit.scalar, "design": dataclasses.asdict(design)}
    return hashlib.sha256(json.dumps(data, sort_keys=True, default=str).encode()).hexdigest()[:16]


def certificate_document(
    task: Task, design: RefinedDesign | AdaptiveDesign, program: Program, certificate: Certificate, digests: dict[str, str]
) -> dict[str, Any]:
    """The certificate as JSON data. Margins are rounded down, bounds up; `exact` fields are fractions."""
    return {
        "format": CERTIFICATE_FORMAT,
        "task": task.name,
        "certified": certificate.holds,
        "method": certificate.method,
        "design": design.kind,
        "scalar": program.scalar,
        "dimension": design.dimension,
        "prescribed_time": exact_decimal(design.prescribed_time),
        "parameters": design.parameters(),
        "clearance": exact_decimal(task.tube.clearance),
        "min_width": exact_decimal(task.tube.min_width),
        "start": {
            "lower": [_edge(a, b - a, certificate, 1) for a, b in certificate.start],
            "upper": [_edge(b, b - a, certificate, -1) for a, b in certificate.start],
            "covers_initial_set": certificate.whole_start,
        },
        "control": {
            "gain": _one_or_each(task.gain),
            "e_max": _one_or_each(task.e_max),
            "u_max": None if task.u_max is None else [decimal(v) for v in task.u_max],
        },
        "least_width": below(certificate.least_width, DIGITS[certificate.method]),
        "speed_bound": [above(v, DIGITS[certificate.method]) for v in certificate.speed],
        "edge_error_bound": [above(v) for v in certificate.edge_error],
        **({} if certificate.steps is None else {"alpha_steps": [float(v) for v in certificate.steps]}),
        **({} if certificate.proved_period is None else {"sampled": _sampled(task, certificate.proved_period)}),
        "properties": [_finding(f, certificate.method) for f in certificate.findings],
        "sha256": {"task_data": task.digest, **digests},
    }


def _one_or_each(values: Sequence[Fraction]) -> str | list[str]:
    shown = [decimal(v) for v in values]
    return shown[0] if len(set(shown)) == 1 else shown


def _edge(value: Fraction, width: Fraction, certificate: Certificate, inward: int) -> str:
    """An edge of gamma(0), exact where the certificate is, else rounded inward (1: up, -1: down) by at most a thousandth of the
    width: fewer digits than were computed, so that no library's last digit reaches the file."""
    if certificate.method == "exact":
        return str(value)
    step = Fraction(10) ** (math.floor(math.log10(width)) - 3) if width > 0 else Fraction(1, 10**9)
    return exact_decimal(inward * math.ceil(inward * value / step) * step)


def _finding(finding: Finding, method: str) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "property": finding.code,
        "title": finding.title,
        "statement": finding.statement,
        "holds": finding.holds,
        "margin": below(finding.margin, DIGITS[method]),
        "required": above(finding.required),
    }
    if method == "exact":
        entry["margin_exact"] = str(finding.margin)
    if finding.time is not None:
        entry["time"] = [nine_digits(v) for v in finding.time]
    if finding.dimension is not None:
        entry["dimension"] = finding.dimension
    if finding.obstacle is not None:
        entry["unsafe_set"] = finding.obstacle
    return entry


def _sampled(task: Task, proved: PeriodProof) -> dict[str, Any]:
    """P9's numbers: fractions, and |u| rounded up. An absent bound of the plant is as its field says."""
    return {
        "period": str(proved.period),
        "latency": str(proved.latency),
        "share": str(proved.share),
        "plant": {name: None if value is None else str(value) for name, value in task.plant},
        "rho": [str(v) for v in proved.rho],
        "u": [above(v) for v in proved.u],
        "shift": [str(v) for v in proved.shift],
    }


def _notice(task: Task, certificate: Certificate) -> list[str]:
    """The lines of every file that say what is proved about it, or loudly that nothing is."""
    if certificate.holds:
        lines = [
            f"Certified ({task.name}.certificate.json): for every t the tube keeps {decimal(task.tube.clearance)} from every",
            f"unsafe set, stays in the state space, is at least {decimal(task.tube.min_width)} wide, and ends in the target set.",
        ]
        if certificate.steps is not None:
            shortest, longest = (decimal(v) for v in certificate.steps)
            lines.append(
                f"It holds for alpha_init at t = 0 and then alpha_step with every dt from {shortest} to {longest} s, each"
            )
            lines.append("step from the t where the last one ended, and so on after t_c. In a slower loop take several a period.")
        if not certificate.whole_start:
            lines.append("It starts on a part of the initial set only: see `start` in the certificate.")
        if certificate.proved_period is not None:
            (ninth,) = (f for f in certificate.findings if f.code == "P9")
            told = f"The state stays in it (P9) {ninth.statement}."
            for comparison in (" <= ", " = ", " < "):  # is not broken over two lines
                told = told.replace(comparison, comparison.replace(" ", NO_BREAK))
            lines += [line.replace(NO_BREAK, " ") for line in textwrap.wrap(told, 115)]
        elif task.u_max is not None:
            lines.append("u is saturated: the proof that the state stays in the tube assumes that it is not.")
        return lines
    return [
        "*** NOT CERTIFIED *** NOT CERTIFIED *** NOT CERTIFIED ***",
        "This controller was written with --uncertified. Do not run it on a machine. "
        + ("What fails:" if certificate.failures else "P1 to P6 hold at samples;"),
        *(f"  {f.code} {f.title}{' at ' + f.place() if f.place() else ''}" for f in certificate.failures),
        *(["between the samples nothing is proved."] if not certificate.failures else []),
    ]


def template_folder() -> Path:
    """Where the templates are: inside the installed package, or beside it in a checkout."""
    inside = Path(__file__).parent.parent / "templates"
    return inside if inside.is_dir() else Path(__file__).parent.parent.parent / "templates"


@cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(template_folder(), encoding="utf-8"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        newline_sequence="\n",
        autoescape=False,
    )


def template(name: str) -> jinja2.Template:
    """A template of the folder, undefined names being errors."""
    return _environment().get_template(name)
