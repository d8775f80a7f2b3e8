"""From a Program and its certificate to the text of the four files. Templates place text; everything is decided here."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import textwrap
from functools import cache
from pathlib import Path
from typing import Any

import jinja2

from stt_codegen.certify.certificate import Certificate
from stt_codegen.certify.mission import cycle_of
from stt_codegen.certify.monitor import Cycle
from stt_codegen.certify.schedule import phases, sentence, served
from stt_codegen.decimals import above, below, by_component, decimal
from stt_codegen.designs import AdaptiveDesign, RefinedDesign
from stt_codegen.emit.document import certificate_text
from stt_codegen.emit.naming import check_names, file_names, guard_name, phase_name, rust_name, selftest_name, wrap_name
from stt_codegen.program import Const, Program, Status
from stt_codegen.program.number import FORMATS, round_down, round_to, round_up
from stt_codegen.program.print.c import CPrinter
from stt_codegen.program.print.python import PythonPrinter
from stt_codegen.task import Task

Files = dict[str, bytes]
NO_BREAK = "\u00a0"


def render(task: Task, design: RefinedDesign | AdaptiveDesign, program: Program, certificate: Certificate) -> Files:
    """The emitted files by name: header, C, Python, certificate. UTF-8 with LF line ends; no date, version or path."""
    check_names(program)
    *_, proof = file_names(task.name)
    common: dict[str, Any] = {
        "prefix": task.name,
        "macro": task.name.upper(),
        "program": program,
        "statuses": list(Status),
        "scalar": program.scalar,
        "kind": design.kind,
        "order": task.order,
        "hash": design_hash(task, design),
        "notice": notice(task, certificate),
        "clock": _clock(task),
        "selftest": task.emit.selftest,
        "outside": task.control.outside,
        "late": bool(task.control.latency),
        "steps": certificate.steps if certificate.holds else None,
        "entries": _entries(task, certificate),
    }
    if program.scalar == "fixed":
        from stt_codegen.emit.integers import texts

        assert isinstance(design, RefinedDesign)
        files = texts(task, design, program, certificate, common, template)
    else:
        files = _texts(task, design, program, certificate, common)
    encoded = {name: text.encode() for name, text in files.items()}
    digests = {name: hashlib.sha256(data).hexdigest() for name, data in encoded.items()}
    if task.written is not None:
        encoded[f"{task.name}.task.toml"] = task.written.encode()
    encoded[proof] = certificate_text(task, design, program, certificate, digests).encode()
    return encoded


def _texts(
    task: Task, design: RefinedDesign | AdaptiveDesign, program: Program, certificate: Certificate, common: dict[str, Any]
) -> dict[str, str]:
    """The text of all files but the certificate, in floating point. common: what every template is told."""
    header, source, module, _ = file_names(task.name)
    printer, python = CPrinter(program), PythonPrinter(program)
    common = common | {
        "precision": "single" if program.scalar == "float" else "double",
        "phases": _phases(task, program, certificate),
    }
    t_c = Const(round_to(task.prescribed_time, program.scalar))
    period = task.emit.tick_period
    if certificate.proved_period is not None:
        common["proved"] = Const(round_down(certificate.proved_period.period, program.scalar))
        if task.differs:
            common["shortest"] = Const(round_up(task.shortest_period, program.scalar))
    if period is not None:
        common["tick"] = Const(round_to(period, program.scalar))
        common["last_tick"] = math.ceil(task.prescribed_time / period)
    cycle = cycle_of(design)
    if cycle is not None:
        common |= _cycle(task, cycle, program.scalar)
    shown = [printer.literal(Const(round_to(v, program.scalar))) for v in common["steps"] or ()]
    files = {
        header: template("controller.h.j2").render(**common, c=printer, t_c_literal=printer.literal(t_c), step_literals=shown),
        source: template("controller.c.j2").render(**common, c=printer),
        module: template("controller.py.j2").render(**common, python=python, t_c_literal=python.literal(t_c)),
    }
    if task.emit.rust:
        from stt_codegen.program.print.rust import RustPrinter

        rust = RustPrinter(program)
        steps = [rust.literal(Const(round_to(v, program.scalar))) for v in common["steps"] or ()]
        t_c_rust = rust.literal(t_c)
        files[rust_name(task.name)] = template("controller.rs.j2").render(
            **common, rust=rust, t_c_literal=t_c_rust, step_literals=steps
        )
    if task.emit.selftest and any(f.name == "control" for f in program.functions):  # a probe has none
        from stt_codegen.emit.selftest import suites

        made = suites(task, design, program)
        total = sum(len(v.statuses) for v in made)
        files[selftest_name(task.name)] = template("selftest.c.j2").render(**common, c=printer, suites=made, total=total)
    if task.control.outside != "return":
        files[guard_name(task.name)] = template("guard.c.j2").render(**common)
    if common["phases"]:
        files[phase_name(task.name)] = template("phase.c.j2").render(**common, c=printer)
    if cycle is not None:
        files[wrap_name(task.name)] = template("wrap.c.j2").render(**common)
    return files


def design_hash(task: Task, design: RefinedDesign | AdaptiveDesign) -> str:
    """16 hex digits that name this design and its options; firmware logs it to tell which controller runs."""
    numbers = dataclasses.asdict(design)
    for name in ("filter", "seam"):  # of order 2 alone, and of what is repeated
        if numbers.get(name) in (None, ()):
            numbers.pop(name, None)
    data = {"task": task.digest, "scalar": task.emit.scalar, "design": numbers}
    return hashlib.sha256(json.dumps(data, sort_keys=True, default=str).encode()).hexdigest()[:16]


def notice(task: Task, certificate: Certificate) -> list[str]:
    """The lines of every file that say what is proved about it, or loudly that nothing is."""
    if certificate.holds:
        lines = [
            f"Certified ({task.name}.certificate.json): for every t the tube keeps {decimal(task.tube.clearance)} from every",
            f"unsafe set, stays in the state space, is at least {decimal(task.tube.min_width)} wide, and "
            + (_ends(task) if task.target_set is None else "ends in the target set."),
        ]
        lines += _mission(task, certificate)
        lines += _stated(task)
        if task.order == 2:
            moving = (
                f"with |v| <= {by_component(task.start_speed)} in the share of it" if any(task.start_speed) else "at rest in it"
            )
            of_v = "v is by differences" if task.differs else "v is measured too"
            lines.append(f"The plant is of order 2: xdot = v, vdot = f + g u + w, and {of_v}. Covered is every start")
            lines.append(f"{moving}; gamma(0) is in the certificate.")
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
        elif task.scales and any(f.code == "P8" for f in certificate.findings):
            lines.append("For every plant within [plant] of the task u within u_max, scaled as a whole, outdoes all that pushes")
            lines.append("(P8), in continuous time. What this gain holds against `stt-codegen prove` tells.")
        elif any(f.code == "P8" for f in certificate.findings):
            lines.append(
                "For every plant within [plant] of the task |u| <= u_max is enough to hold the state in it (P8), in continuous"
            )
            lines.append("time. What this gain holds against, and how fast it must be sampled, `stt-codegen prove` tells.")
        elif task.u_max is not None:
            lines.append("u is saturated: the proof that the state stays in the tube assumes that it is not.")
        return lines
    return [
        "*** NOT CERTIFIED *** NOT CERTIFIED *** NOT CERTIFIED ***",
        "This controller was written with --uncertified. Do not run it on a machine. "
        + ("What fails:" if certificate.failures else "P1 to P6 hold at samples;"),
        *(f"  {f.code} {f.title}{' at ' + f.place(certificate.axes) if f.place() else ''}" for f in certificate.failures),
        *(["between the samples nothing is proved."] if not certificate.failures else []),
    ]


def _ends(task: Task) -> str:
    return "repeats itself for ever." if task.repeat else "carries out the mission."


def _mission(task: Task, certificate: Certificate) -> list[str]:
    """What is shown of the mission."""
    shown = certificate.mission
    if shown is None:
        return []
    (margin,) = (f.margin for f in certificate.findings if f.code == "P10" and f.in_time)
    told = f"Every x(t) that stays in the tube satisfies the mission (P10): {shown.formula}; times are seconds of t"
    told += (", not turned back" if task.repeat else "") + ". It still "
    told += f"holds where every time at which the tube is in a region, or off one, is wrong by up to {below(margin, 3):g} s."
    return textwrap.wrap(told, 115)


def _entries(task: Task, certificate: Certificate) -> list[str]:
    """Every entry of the mission with the times at which the tube serves it."""
    if certificate.mission is None:
        return []
    found = [f"{one.entry} {sentence(one)}" for one in served(task, certificate.mission)]
    return [line for text in found for line in textwrap.wrap(text, 115, subsequent_indent="  ")]


def _phases(task: Task, program: Program, certificate: Certificate) -> list[tuple[Const, int]]:
    """Until when which entry is served; empty without a mission, or where nothing is visited."""
    if certificate.mission is None:
        return []
    return [(Const(round_to(until, program.scalar)), entry) for until, entry in phases(task, certificate.mission)]


def _cycle(task: Task, cycle: Cycle, scalar: str) -> dict[str, Any]:
    """What is said of a tube that repeats itself: its cycle in seconds and ticks, when it begins, and by how much a turn of the
    clock in seconds may be off (the cycle and the difference are rounded), and each sum of t and a period."""
    length, unit = round_to(cycle.length, scalar), FORMATS[scalar].roundoff
    wrong = abs(length - cycle.length) + unit * task.prescribed_time
    found = {"cycle": Const(length), "cycle_begins": decimal(cycle.begin), "cycle_length": decimal(cycle.length)}
    found["turn_error"], found["sum_error"] = f"{above(wrong, 2):g}", f"{above(unit * task.prescribed_time, 2):g}"
    if task.emit.tick_period is not None:
        found["cycle_ticks"] = cycle.length / task.emit.tick_period
    return found


def _clock(task: Task) -> str:
    """What is said beside t_c where the clock of the sets, or that of a mission, matters."""
    if not task.timed:
        late = f" at the latest {decimal(task.start_delay)} s after" if task.start_delay else " when"
        return f"; t = 0 is{late} the mission begins" if task.mission else ""
    late = f", or at most {decimal(task.start_delay)} s after" if task.start_delay else ""
    return f"; t = 0 is when the clock of the sets shows 0{late}"


def _stated(task: Task) -> list[str]:
    """About which sets the guarantee is, where some move or are unsafe only at times."""
    if not task.timed:
        return []
    late = f", or up to {decimal(task.start_delay)} s later" if task.start_delay else ""
    told = f"The sets are those of the task, where and when it states them: t = 0 here is t = 0 on their clock{late}"
    doubt = [f"{s.name} {decimal(s.timing)} s" for s in task.unsafe if s.timing]
    told += f"; their times may be wrong by as much as the task says ({', '.join(doubt)})." if doubt else "."
    told += " Nothing is shown for sets that move in another way."
    growing = [s.name for s in task.unsafe if s.spread]
    told += f" Of what grows ({', '.join(growing)}) the tube keeps clear until t_c, not for every t." if growing else ""
    return textwrap.wrap(told, 115)


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
