"""From a Program and its certificate to the text of its files. Templates place text; this file decides what they place.

`pipeline.render_files` calls `render`.
"""

from __future__ import annotations

import hashlib
import json
import math
import textwrap
from typing import Any

from stt_codegen.certify import Certificate, Cycle
from stt_codegen.certify.missions import cycle_of, describe_entry, phases, served_entries
from stt_codegen.controller import start_share
from stt_codegen.decimals import above, below, by_component, by_dimension, decimal
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
NO_BREAK_SPACE = "\u00a0"
NOTICE_WIDTH = 115  # characters of a line


def render(task: Task, design: Design, program: Program, certificate: Certificate) -> Files:
    """Return the emitted files by name: of every language, and the certificate. UTF-8, LF line ends; no date, version or path."""
    check_names(program)
    common = _common_names(task, design, program, certificate)
    if program.scalar == "fixed":
        from stt_codegen.emit.integers import texts

        files = texts(task, require_refined(design), program, certificate, common)
    else:
        files = _texts(task, design, program, certificate, common)
    encoded = {name: text.encode() for name, text in files.items()}
    digests = {name: hashlib.sha256(data).hexdigest() for name, data in encoded.items()}
    if task.expanded_text is not None:
        encoded[spelled_name(task.name)] = task.expanded_text.encode()
    encoded[file_names(task.name).certificate] = certificate_text(task, design, program, certificate, digests).encode()
    return encoded


def _common_names(task: Task, design: Design, program: Program, certificate: Certificate) -> dict[str, Any]:
    """Return the names that templates of every scalar read."""
    return {
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


def _texts(task: Task, design: Design, program: Program, certificate: Certificate, common: dict[str, Any]) -> dict[str, str]:
    """Return the text of all files but the certificate, in floating point. common: the names that every template reads."""
    cycle = cycle_of(design)
    names = common | _float_names(task, design, program, certificate)
    if cycle is not None:
        names |= _cycle(task, cycle, program.scalar)
    t_c = Const(round_to(task.prescribed_time, program.scalar))
    files: dict[str, str] = {}
    for target in targets_of(task.emit):
        printer = target.printer(program)
        steps = [printer.literal(Const(round_to(v, program.scalar))) for v in names["steps"] or ()]
        literals = {target.key: printer, "t_c_literal": printer.literal(t_c), "step_literals": steps}
        for suffix in target.suffixes:
            files[task.name + suffix] = template(f"{target.key}/controller{suffix}.j2").render(**names, **literals)
    c = CPrinter(program)
    if task.emit.selftest and any(f.name == "control" for f in program.functions):  # a Program without it has no self-test
        from stt_codegen.emit.selftest import selftest_suites

        suites = selftest_suites(task, design, program)
        total = sum(len(v.statuses) for v in suites)
        files[selftest_name(task.name)] = template("c/selftest.c.j2").render(**names, c=c, suites=suites, total=total)
    if task.control.outside != "return":
        files[guard_name(task.name)] = template("c/guard.c.j2").render(**names)
    if names["phases"]:
        files[phase_name(task.name)] = template("c/phase.c.j2").render(**names, c=c)
    if cycle is not None:
        files[wrap_name(task.name)] = template("c/wrap.c.j2").render(**names)
    if task.closed_axes:
        files[unwrap_name(task.name)] = template("c/unwrap.c.j2").render(**names)
    return files


def _float_names(task: Task, design: Design, program: Program, certificate: Certificate) -> dict[str, Any]:
    """Return what only the templates of floating point read. A template tests whether a name is defined."""
    names: dict[str, Any] = {
        "precision": "single" if program.scalar == "float" else "double",
        "phases": _phases(task, program, certificate),
    }
    if design.capabilities.emits_covered_starts:
        names["share_text"] = decimal(start_share(task))
        names["share"] = Const(round_down(start_share(task), program.scalar))
    if certificate.proved_period is not None:
        names["proved"] = Const(round_down(certificate.proved_period.period, program.scalar))
        if task.uses_differences:
            names["shortest"] = Const(round_up(task.shortest_period, program.scalar))
    tick_period = task.emit.tick_period
    if tick_period is not None:
        names["tick"] = Const(round_to(tick_period, program.scalar))
        names["last_tick"] = math.ceil(task.prescribed_time / tick_period)
    return names


def design_hash(task: Task, design: Design) -> str:
    """Return 16 hex digits that name this design and its options; firmware logs them to say which controller runs."""
    data = {"task": task.digest, "scalar": task.emit.scalar, "design": design.numbers()}
    return hashlib.sha256(json.dumps(data, sort_keys=True, default=str).encode()).hexdigest()[:16]


def notice(task: Task, certificate: Certificate) -> list[str]:
    """Return the lines of every file that say what is proved about it, or loudly that nothing is."""
    if not certificate.holds:
        return _warning(certificate)
    clearances = by_dimension(task.clearances)
    is_one = len(set(task.clearances)) == 1
    clearance = f" keeps {clearances} from every" if is_one else f", grown by {clearances} to both sides, meets no"
    lines = [
        f"Certified ({task.name}.certificate.json): for every t the tube{clearance}",
        f"unsafe set, stays in the state space, is at least {by_dimension(task.min_widths)} wide, and "
        + (_end_of_tube(task) if task.target_set is None else "ends in the target set."),
        *turns_notice(task),
        *_mission_lines(task, certificate),
        *_set_lines(task),
        *(_order_two_lines(task) if task.order == 2 else []),
        *_norm_lines(task),
    ]
    if certificate.steps is not None:
        shortest, longest = (decimal(v) for v in certificate.steps)
        lines.append(f"It holds for alpha_init at t = 0 and then alpha_step with every dt from {shortest} to {longest} s, each")
        lines.append("step from the t where the last one ended, and so on after t_c. In a slower loop take several a period.")
    if not certificate.covers_initial_set:
        lines.append("It starts on a part of the initial set only: see `start` in the certificate.")
    return lines + _state_lines(task, certificate)


def _warning(certificate: Certificate) -> list[str]:
    """Return the lines of a file that is not certified, with what fails."""
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


def _order_two_lines(task: Task) -> list[str]:
    """Return the lines about the plant and the starts of a task of order 2."""
    start = f"with |v| <= {by_component(task.start_speed)} in the share of it" if any(task.start_speed) else "at rest in it"
    velocity = "v is by differences" if task.uses_differences else "v is measured too"
    return [
        f"The plant is of order 2: xdot = v, vdot = f + g u + w, and {velocity}. Covered is every start",
        f"{start}; gamma(0) is in the certificate.",
    ]


def _norm_lines(task: Task) -> list[str]:
    """Return the lines about the norm of u; none where the task does not bound it."""
    if task.control.u_norm is None or task.emitted_u_max is None:
        return []
    limits = f"u is within {by_component(task.u_max or ())} by component at every call"
    sentence = f"{limits}, so that its Euclidean norm is at most {decimal(task.control.u_norm)}."
    return textwrap.wrap(sentence, NOTICE_WIDTH)


def _state_lines(task: Task, certificate: Certificate) -> list[str]:
    """Return the lines that say whether the state stays in the tube: P9 where it is proved, else what P8 says."""
    has_limits = any(f.subject is Property.LIMITS for f in certificate.findings)
    if certificate.proved_period is not None:
        (period_finding,) = (f for f in certificate.findings if f.subject is Property.PERIOD)
        sentence = f"The state stays in it ({Property.PERIOD.code}) {period_finding.statement}."
        for comparison in (" <= ", " = ", " < "):  # is not broken over two lines
            sentence = sentence.replace(comparison, comparison.replace(" ", NO_BREAK_SPACE))
        return [line.replace(NO_BREAK_SPACE, " ") for line in textwrap.wrap(sentence, NOTICE_WIDTH)]
    if task.scales_input and has_limits:
        return [
            "For every plant within [plant] of the task u within u_max, scaled as a whole, outdoes all that pushes",
            f"({Property.LIMITS.code}), in continuous time. What this gain holds against `stt-codegen prove` tells.",
        ]
    if has_limits:
        return [
            "For every plant within [plant] of the task |u| <= u_max is enough to hold the state in it "
            f"({Property.LIMITS.code}), in continuous",
            "time. What this gain holds against, and how fast it must be sampled, `stt-codegen prove` tells.",
        ]
    if task.u_max is not None:
        return ["u is saturated: the proof that the state stays in the tube assumes that it is not."]
    return []


def _end_of_tube(task: Task) -> str:
    return "repeats itself for ever." if task.repeat else "carries out the mission."


def _mission_lines(task: Task, certificate: Certificate) -> list[str]:
    """Return the lines that say what is proved about the mission."""
    proof = certificate.mission
    if proof is None:
        return []
    (margin,) = (f.margin for f in certificate.findings if f.subject is Property.MISSION and f.in_time)
    sentence = f"Every x(t) that stays in the tube satisfies the mission ({Property.MISSION.code}): {proof.formula}; "
    sentence += "times are seconds of t"
    sentence += (", not turned back" if task.repeat else "") + ". It still "
    sentence += f"holds where every time at which the tube is in a region, or off one, is wrong by up to {below(margin, 3):g} s."
    return textwrap.wrap(sentence, NOTICE_WIDTH)


def _entries(task: Task, certificate: Certificate) -> list[str]:
    """Return the lines about the entries of the mission, each with the times at which the tube serves it."""
    if certificate.mission is None:
        return []
    descriptions = [f"{served.entry} {describe_entry(served)}" for served in served_entries(task, certificate.mission)]
    return [line for text in descriptions for line in textwrap.wrap(text, NOTICE_WIDTH, subsequent_indent="  ")]


def _phases(task: Task, program: Program, certificate: Certificate) -> list[tuple[Const, int]]:
    """Return (end time, entry served until then) in order; nothing without a mission, or where no region is visited."""
    if certificate.mission is None:
        return []
    return [(Const(round_to(until, program.scalar)), entry) for until, entry in phases(task, certificate.mission)]


def _cycle(task: Task, cycle: Cycle, scalar: str) -> dict[str, Any]:
    """Return what templates read about a tube that repeats itself: its cycle in seconds and ticks, and when it begins.

    turn_error: of the clock by one cycle, in seconds, as the cycle and the difference are rounded. sum_error: of one sum of t and
    a period.
    """
    length, roundoff = round_to(cycle.length, scalar), FORMATS[scalar].roundoff
    turn_error = abs(length - cycle.length) + roundoff * task.prescribed_time
    names = {
        "cycle": Const(length),
        "cycle_begins": decimal(cycle.begin),
        "cycle_length": decimal(cycle.length),
        "turn_error": f"{above(turn_error, 2):g}",
        "sum_error": f"{above(roundoff * task.prescribed_time, 2):g}",
    }
    if task.emit.tick_period is not None:
        names["cycle_ticks"] = cycle.length / task.emit.tick_period
    return names


def clock_words(task: Task) -> str:
    """Return what is said beside t_c about the clock of the sets, or that of a mission; nothing where there is none."""
    if not task.has_timed_sets:
        late = f" at the latest {decimal(task.start_delay)} s after" if task.start_delay else " when"
        return f"; t = 0 is{late} the mission begins" if task.mission else ""
    late = f", or at most {decimal(task.start_delay)} s after" if task.start_delay else ""
    return f"; t = 0 is when the clock of the sets shows 0{late}"


def _set_lines(task: Task) -> list[str]:
    """Return the lines that say for which sets the guarantee holds, where some move or are unsafe only at times."""
    if not task.has_timed_sets:
        return []
    late = f", or up to {decimal(task.start_delay)} s later" if task.start_delay else ""
    sentence = f"The sets are those of the task, where and when it states them: t = 0 here is t = 0 on their clock{late}"
    uncertainties = [f"{s.name} {decimal(s.timing)} s" for s in task.unsafe if s.timing]
    sentence += f"; their times may be wrong by as much as the task says ({', '.join(uncertainties)})." if uncertainties else "."
    sentence += " Nothing is shown for sets that move in another way."
    growing = [s.name for s in task.unsafe if s.spread]
    sentence += f" Of what grows ({', '.join(growing)}) the tube keeps clear until t_c, not for every t." if growing else ""
    return textwrap.wrap(sentence, NOTICE_WIDTH)
