"""From a Program and its certificate to the text of its files. Templates place text; everything is decided here."""

from __future__ import annotations

import hashlib
import json
import math
import textwrap
from typing import Any

from stt_codegen.certify import Certificate, Cycle
from stt_codegen.certify.missions import cycle_of, describe_entry, phases, served_entries
from stt_codegen.controller import start_share
from stt_codegen.decimals import above, below, by_component, decimal
from stt_codegen.designs import Design, require_refined
from stt_codegen.emit.document import certificate_text
from stt_codegen.emit.naming import (
    check_names,
    file_names,
    guard_name,
    phase_name,
    selftest_name,
    spelled_name,
    unwrap_name,
    wrap_name,
)
from stt_codegen.emit.unwrapping import turns_notice, unwrapping
from stt_codegen.program import FORMATS, Const, Program, Status, round_down, round_to, round_up
from stt_codegen.program.targets import targets_of
from stt_codegen.program.targets.c import CPrinter
from stt_codegen.program.targets.template_files import template
from stt_codegen.properties import Property
from stt_codegen.task import Task

Files = dict[str, bytes]
NO_BREAK = "\u00a0"


def render(task: Task, design: Design, program: Program, certificate: Certificate) -> Files:
    """The emitted files by name: of every language, and the certificate. UTF-8 with LF line ends; no date, version or path."""
    check_names(program)
    *_, proof = file_names(task.name)
    common: dict[str, Any] = {
        "prefix": task.name,
        "macro": task.name.upper(),
        "program": program,
        "statuses": list(Status),
        "scalar": program.scalar,
        "kind": design.kind,
        "is_stateful": design.is_stateful,
        "order": task.order,
        "hash": design_hash(task, design),
        "notice": notice(task, certificate),
        "clock": clock_words(task),
        "selftest": task.emit.selftest,
        "outside": task.control.outside,
        "late": bool(task.control.latency),
        "steps": certificate.steps if certificate.holds else None,
        "entries": _entries(task, certificate),
        **unwrapping(task, program.scalar),
    }
    if program.scalar == "fixed":
        from stt_codegen.emit.integers import texts

        files = texts(task, require_refined(design), program, certificate, common)
    else:
        files = _texts(task, design, program, certificate, common)
    encoded = {name: text.encode() for name, text in files.items()}
    digests = {name: hashlib.sha256(data).hexdigest() for name, data in encoded.items()}
    if task.expanded_text is not None:
        encoded[spelled_name(task.name)] = task.expanded_text.encode()
    encoded[proof] = certificate_text(task, design, program, certificate, digests).encode()
    return encoded


def _texts(task: Task, design: Design, program: Program, certificate: Certificate, common: dict[str, Any]) -> dict[str, str]:
    """The text of all files but the certificate, in floating point. common: what every template is told."""
    common = common | {
        "precision": "single" if program.scalar == "float" else "double",
        "phases": _phases(task, program, certificate),
    }
    t_c = Const(round_to(task.prescribed_time, program.scalar))
    if design.capabilities.emits_covered_starts:
        common["share_text"] = decimal(start_share(task))
        common["share"] = Const(round_down(start_share(task), program.scalar))
    period = task.emit.tick_period
    if certificate.proved_period is not None:
        common["proved"] = Const(round_down(certificate.proved_period.period, program.scalar))
        if task.uses_differences:
            common["shortest"] = Const(round_up(task.shortest_period, program.scalar))
    if period is not None:
        common["tick"] = Const(round_to(period, program.scalar))
        common["last_tick"] = math.ceil(task.prescribed_time / period)
    cycle = cycle_of(design)
    if cycle is not None:
        common |= _cycle(task, cycle, program.scalar)
    files: dict[str, str] = {}
    for target in targets_of(task.emit):
        printer = target.printer(program)
        steps = [printer.literal(Const(round_to(v, program.scalar))) for v in common["steps"] or ()]
        words = {target.key: printer, "t_c_literal": printer.literal(t_c), "step_literals": steps}
        for suffix in target.suffixes:
            files[task.name + suffix] = template(f"{target.key}/controller{suffix}.j2").render(**common, **words)
    c = CPrinter(program)
    if task.emit.selftest and any(f.name == "control" for f in program.functions):  # a probe has none
        from stt_codegen.emit.selftest import suites

        made = suites(task, design, program)
        total = sum(len(v.statuses) for v in made)
        files[selftest_name(task.name)] = template("c/selftest.c.j2").render(**common, c=c, suites=made, total=total)
    if task.control.outside != "return":
        files[guard_name(task.name)] = template("c/guard.c.j2").render(**common)
    if common["phases"]:
        files[phase_name(task.name)] = template("c/phase.c.j2").render(**common, c=c)
    if cycle is not None:
        files[wrap_name(task.name)] = template("c/wrap.c.j2").render(**common)
    if task.closed_axes:
        files[unwrap_name(task.name)] = template("c/unwrap.c.j2").render(**common)
    return files


def design_hash(task: Task, design: Design) -> str:
    """16 hex digits that name this design and its options; firmware logs it to tell which controller runs."""
    data = {"task": task.digest, "scalar": task.emit.scalar, "design": design.numbers()}
    return hashlib.sha256(json.dumps(data, sort_keys=True, default=str).encode()).hexdigest()[:16]


def notice(task: Task, certificate: Certificate) -> list[str]:
    """The lines of every file that say what is proved about it, or loudly that nothing is."""
    if certificate.holds:
        lines = [
            f"Certified ({task.name}.certificate.json): for every t the tube keeps {decimal(task.tube.clearance)} from every",
            f"unsafe set, stays in the state space, is at least {decimal(task.tube.min_width)} wide, and "
            + (_ends(task) if task.target_set is None else "ends in the target set."),
        ]
        lines += turns_notice(task)
        lines += _mission(task, certificate)
        lines += _stated(task)
        if task.order == 2:
            moving = (
                f"with |v| <= {by_component(task.start_speed)} in the share of it" if any(task.start_speed) else "at rest in it"
            )
            of_v = "v is by differences" if task.uses_differences else "v is measured too"
            lines.append(f"The plant is of order 2: xdot = v, vdot = f + g u + w, and {of_v}. Covered is every start")
            lines.append(f"{moving}; gamma(0) is in the certificate.")
        if certificate.steps is not None:
            shortest, longest = (decimal(v) for v in certificate.steps)
            lines.append(
                f"It holds for alpha_init at t = 0 and then alpha_step with every dt from {shortest} to {longest} s, each"
            )
            lines.append("step from the t where the last one ended, and so on after t_c. In a slower loop take several a period.")
        if not certificate.covers_initial_set:
            lines.append("It starts on a part of the initial set only: see `start` in the certificate.")
        if certificate.proved_period is not None:
            (of_period,) = (f for f in certificate.findings if f.subject is Property.PERIOD)
            sentence = f"The state stays in it ({Property.PERIOD.code}) {of_period.statement}."
            for comparison in (" <= ", " = ", " < "):  # is not broken over two lines
                sentence = sentence.replace(comparison, comparison.replace(" ", NO_BREAK))
            lines += [line.replace(NO_BREAK, " ") for line in textwrap.wrap(sentence, 115)]
        elif task.scales_input and any(f.subject is Property.LIMITS for f in certificate.findings):
            lines.append("For every plant within [plant] of the task u within u_max, scaled as a whole, outdoes all that pushes")
            lines.append(f"({Property.LIMITS.code}), in continuous time. What this gain holds against `stt-codegen prove` tells.")
        elif any(f.subject is Property.LIMITS for f in certificate.findings):
            lines.append(
                "For every plant within [plant] of the task |u| <= u_max is enough to hold the state in it "
                f"({Property.LIMITS.code}), in continuous"
            )
            lines.append("time. What this gain holds against, and how fast it must be sampled, `stt-codegen prove` tells.")
        elif task.u_max is not None:
            lines.append("u is saturated: the proof that the state stays in the tube assumes that it is not.")
        return lines
    return [
        "*** NOT CERTIFIED *** NOT CERTIFIED *** NOT CERTIFIED ***",
        "This controller was written with --uncertified. Do not run it on a machine. "
        + ("What fails:" if certificate.failures else f"{Property.WIDTH.code} to {Property.SMOOTH.code} hold at samples;"),
        *(
            f"  {f.code} {f.subject.word}{' at ' + f.location(certificate.axes) if f.location() else ''}"
            for f in certificate.failures
        ),
        *(["between the samples nothing is proved."] if not certificate.failures else []),
    ]


def _ends(task: Task) -> str:
    return "repeats itself for ever." if task.repeat else "carries out the mission."


def _mission(task: Task, certificate: Certificate) -> list[str]:
    """What is shown of the mission."""
    shown = certificate.mission
    if shown is None:
        return []
    (margin,) = (f.margin for f in certificate.findings if f.subject is Property.MISSION and f.in_time)
    sentence = f"Every x(t) that stays in the tube satisfies the mission ({Property.MISSION.code}): {shown.formula}; "
    sentence += "times are seconds of t"
    sentence += (", not turned back" if task.repeat else "") + ". It still "
    sentence += f"holds where every time at which the tube is in a region, or off one, is wrong by up to {below(margin, 3):g} s."
    return textwrap.wrap(sentence, 115)


def _entries(task: Task, certificate: Certificate) -> list[str]:
    """Every entry of the mission with the times at which the tube serves it."""
    if certificate.mission is None:
        return []
    found = [f"{one.entry} {describe_entry(one)}" for one in served_entries(task, certificate.mission)]
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


def clock_words(task: Task) -> str:
    """What is said beside t_c where the clock of the sets, or that of a mission, matters."""
    if not task.has_timed_sets:
        late = f" at the latest {decimal(task.start_delay)} s after" if task.start_delay else " when"
        return f"; t = 0 is{late} the mission begins" if task.mission else ""
    late = f", or at most {decimal(task.start_delay)} s after" if task.start_delay else ""
    return f"; t = 0 is when the clock of the sets shows 0{late}"


def _stated(task: Task) -> list[str]:
    """About which sets the guarantee is, where some move or are unsafe only at times."""
    if not task.has_timed_sets:
        return []
    late = f", or up to {decimal(task.start_delay)} s later" if task.start_delay else ""
    sentence = f"The sets are those of the task, where and when it states them: t = 0 here is t = 0 on their clock{late}"
    doubt = [f"{s.name} {decimal(s.timing)} s" for s in task.unsafe if s.timing]
    sentence += f"; their times may be wrong by as much as the task says ({', '.join(doubt)})." if doubt else "."
    sentence += " Nothing is shown for sets that move in another way."
    growing = [s.name for s in task.unsafe if s.spread]
    sentence += f" Of what grows ({', '.join(growing)}) the tube keeps clear until t_c, not for every t." if growing else ""
    return textwrap.wrap(sentence, 115)
