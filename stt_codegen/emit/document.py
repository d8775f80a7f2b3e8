"""The certificate as a JSON document, format 3, which docs/certificate-format.md specifies. `render` calls it.

The claims of a refined tube are whole numbers in units of its table, and fractions; one line each. Those of adaptive and literal
designs are decimals, rounded to the safe side.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from stt_codegen.certify import (
    Certificate,
    Finding,
    MissionProof,
    PathClaim,
    PeriodProof,
    SlackClaim,
    Stretch,
    claims_of,
    cuts_of,
)
from stt_codegen.certify.missions import SLICES
from stt_codegen.controller.integers import certified_constants
from stt_codegen.decimals import above, below, decimal, exact_decimal, nine_digits
from stt_codegen.design_kinds import DesignKind
from stt_codegen.designs import AdaptiveDesign, Design, RefinedDesign, for_any_design
from stt_codegen.program import Program
from stt_codegen.task import Task

CERTIFICATE_FORMAT = 3
# Significant digits of margins and bounds, by method: fewer where the last digits of a library's functions reach them.
DIGITS = {"enclosure": 4, "sampled": 6}


def certificate_text(task: Task, design: Design, program: Program, certificate: Certificate, digests: dict[str, str]) -> str:
    """Return the certificate as text, one claim on a line. digests: the SHA-256 of every file that it is about."""
    head = {
        "format": CERTIFICATE_FORMAT,
        "task": task.name,
        "certified": certificate.holds,
        "design": design.kind,
        "method": certificate.method,
        "order": task.order,
        "scalar": program.scalar,
        "sha256": {"task_data": task.digest, **digests},
    }
    return _lines({**head, **BODIES[design.kind](task, design, certificate)}) + "\n"


def _lines(document: dict[str, Any]) -> str:
    """Return the document as JSON: an entry on one line, but lists of claims and long tables with a line for each of theirs."""
    entries = []
    for key, value in document.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            text = "[\n" + ",\n".join(f"    {json.dumps(item)}" for item in value) + "\n  ]"
        elif isinstance(value, dict) and len(json.dumps(value)) > 100:
            text = "{\n" + ",\n".join(f"    {json.dumps(k)}: {json.dumps(v)}" for k, v in value.items()) + "\n  }"
        else:
            text = json.dumps(value)
        entries.append(f"  {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(entries) + "\n}"


# ------------------------------------------------------------------------------------------------ exact


def _exact(task: Task, design: RefinedDesign, certificate: Certificate) -> dict[str, Any]:
    """Return the claims about a refined tube, and the numbers that a checker needs for them."""
    claims, bezier = claims_of(task, design, certificate), design.bezier()
    cuts = cuts_of(claims)
    return {
        "grid": {
            "segments": design.segments,
            "cuts": cuts,
            "unit_bits": design.bits,
            **({} if design.seam is None else {"seam": design.seam}),
        },
        "edge_error": [math.ceil(v / design.unit) for v in certificate.edge_error],
        **({} if task.order == 1 else _filter(design, certificate)),
        "speed": [3 * int(v) for v in design.largest_steps().max(axis=0)],
        "start": [[int(a), int(b)] for a, b in bezier[0, :, :, 0]],
        "covers_initial_set": certificate.covers_initial_set,
        "control": _control(task),
        **({"integers": certified_constants(task, design)} if task.emit.scalar == "fixed" else {}),
        **({"clock": _clock(task)} if task.has_timed_sets else {}),
        "claims": [_claim(claim, cuts) for claim in claims],
        **({} if certificate.mission is None else {"mission": _mission(certificate.mission, cuts)}),
        **({} if certificate.proved_period is None else {"sampled": _sampled(task, certificate.proved_period)}),
    }


def _filter(design: RefinedDesign, certificate: Certificate) -> dict[str, Any]:
    """Return lambda, and the error of an edge's rate by the arithmetic, in units of the table per segment."""
    unit = design.unit * design.segments / Fraction(design.prescribed_time)
    rate_error = [math.ceil(v / unit) for v in certificate.rate_error]
    return {"filter": [str(v) for v in design.filter], "rate_error": rate_error}


def _claim(claim: SlackClaim, cuts: int) -> dict[str, Any]:
    """Return one claim; its times are in parts of a segment."""
    entry: dict[str, Any] = {"property": claim.subject.code}
    if claim.name is not None:
        entry["set"] = claim.name
    if claim.order is not None:
        entry["order"] = claim.order
    entry["on"] = [int(v * cuts) for v in claim.on]
    if claim.margin is not None:
        entry["margin"] = claim.margin
    if claim.hints:
        entry["hints"] = [_hint(hint, cuts) for hint in claim.hints]
    return entry


def _hint(hint: Stretch, cuts: int) -> list[Any]:
    """Return a hint: from, to, and where there are any the normal, and the multipliers of the set's half-spaces."""
    entry: list[Any] = [int(hint.begin * cuts), int(hint.end * cuts)]
    if hint.normal is not None:
        entry.append(list(hint.normal))
    if hint.multipliers is not None:
        entry.append([str(v) for v in hint.multipliers])
    return entry


def _control(task: Task) -> dict[str, Any]:
    """Return the constants of the control law by component, as the task has them; u_max as it is emitted. u_norm: if stated."""
    limit = None if task.emitted_u_max is None else [str(v) for v in task.emitted_u_max]
    norm = {} if task.control.u_norm is None else {"u_norm": str(task.control.u_norm)}
    return {"gain": [str(v) for v in task.gain], "e_max": [str(v) for v in task.e_max], "u_max": limit, **norm}


def _clock(task: Task) -> dict[str, Any]:
    """Return the timing uncertainty of moving sets, within which the claims hold."""
    return {"start_delay": str(task.start_delay), "timing": {s.name: str(s.timing) for s in task.unsafe if s.timing is not None}}


def _mission(proof: MissionProof, cuts: int) -> dict[str, Any]:
    """Return the formula, and by how many parts of a segment every interval of P10 may be shorter at both ends."""
    return {"formula": str(proof.formula), "time_margin": proof.time_margin * cuts // SLICES}


def _sampled(task: Task, proof: PeriodProof) -> dict[str, Any]:
    """Return the numbers of P9: fractions, and |u| rounded up. A bound that [plant] lacks is null or the default of its field."""
    return {
        "period": str(proof.period),
        "latency": str(proof.latency),
        "share": str(proof.share),
        "plant": {
            name: [str(v) for v in value] if isinstance(value, tuple) else None if value is None else str(value)
            for name, value in task.plant.bounds.items()
        },
        **({"period_min": str(task.shortest_period)} if task.uses_differences else {}),
        "rho": [str(v) for v in proof.rho],
        "u": [str(Fraction(str(above(v)))) for v in proof.u],
        "shift": [str(v) for v in proof.shift],
        **({"path": [_path(path) for path in proof.paths]} if proof.paths else {}),
    }


def _path(path: PathClaim) -> dict[str, Any]:
    """Return Q_pk, the distance to which no path of a component comes nearer, and A in seconds; null where one path is enough."""
    return {"nearest": str(Fraction(str(below(path.nearest)))), "history": None if path.history is None else str(path.history)}


# ------------------------------------------------------------------------------------------------ decimals


def _decimals(task: Task, design: AdaptiveDesign, certificate: Certificate) -> dict[str, Any]:
    """Return the claims about an adaptive or literal tube: margins rounded down, bounds up."""
    digits = DIGITS[certificate.method]
    steps = {} if certificate.steps is None else {"alpha_steps": [float(v) for v in certificate.steps]}
    return {
        "prescribed_time": exact_decimal(design.prescribed_time),
        "parameters": design.parameters(),
        "clearance": _one_or_each(task.tube.clearance),
        "min_width": _one_or_each(task.tube.min_width),
        "start": {
            "lower": [_inward(a, b - a, 1) for a, b in certificate.start],
            "upper": [_inward(b, b - a, -1) for a, b in certificate.start],
        },
        "covers_initial_set": certificate.covers_initial_set,
        "control": {
            name: value if value is None else [decimal(Fraction(v)) for v in value] for name, value in _control(task).items()
        },
        "least_width": below(certificate.minimum_width, digits),
        "speed_bound": [above(v, digits) for v in certificate.speed],
        "edge_error_bound": [above(v) for v in certificate.edge_error],
        **steps,
        "claims": [_finding(f, digits) for f in certificate.findings],
    }


def _one_or_each(value: Fraction | tuple[Fraction, ...]) -> str | list[str]:
    """Return a number of the task with all its digits, or one for each component where the task has a list."""
    return [exact_decimal(v) for v in value] if isinstance(value, tuple) else exact_decimal(value)


def _inward(value: Fraction, width: Fraction, inward: int) -> str:
    """Return an edge of gamma(0), rounded inward (1: up, -1: down) by at most a thousandth of the width.

    It has fewer digits than were computed, so that the last digits of a library's functions do not reach the file.
    """
    step = Fraction(10) ** (math.floor(math.log10(width)) - 3) if width > 0 else Fraction(1, 10**9)
    return exact_decimal(inward * math.ceil(inward * value / step) * step)


def _finding(finding: Finding, digits: int) -> dict[str, Any]:
    """Return one finding of an adaptive or literal tube."""
    entry: dict[str, Any] = {
        "property": finding.code,
        "statement": finding.statement,
        "holds": finding.holds,
        "margin": below(finding.margin, digits),
        "required": above(finding.required),
    }
    if finding.time is not None:
        entry["time"] = [nine_digits(v) for v in finding.time]
    if finding.dimension is not None:
        entry["dimension"] = finding.dimension
    if finding.obstacle is not None:
        entry["unsafe_set"] = finding.obstacle
    return entry


BODIES: Mapping[DesignKind, Callable[[Task, Design, Certificate], dict[str, Any]]] = {
    "refined": for_any_design(RefinedDesign, _exact),
    "adaptive": for_any_design(AdaptiveDesign, _decimals),
    "literal": for_any_design(AdaptiveDesign, _decimals),
}
