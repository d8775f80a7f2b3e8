"""Controllers that an attacker makes: files about any tube, with C that is the checker's own listing and a certificate that claims
the smallest margins. Only a property that does not hold can refuse them."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import Context, Decimal
from fractions import Fraction
from typing import Any
from unittest import mock

from stt_codegen.checker.stt_checker import claims, controller, limits, period, source
from stt_codegen.checker.stt_checker.exact import units_above
from stt_codegen.checker.stt_checker.files import design_hash
from stt_codegen.checker.stt_checker.law import Law
from stt_codegen.checker.stt_checker.rounding import arithmetic_error
from stt_codegen.checker.stt_checker.starts import covered_starts
from stt_codegen.checker.stt_checker.task import Task
from stt_codegen.checker.stt_checker.tube import Tube
from tests.support.checked_files import Files

DIGITS = Context(prec=60)


@dataclass(frozen=True)
class ForgedDesign:
    """A tube of order 1 and what its certificate claims. table: rows of (lower, upper) by dimension, in units of 2^-unit_bits.
    hints: of P4 by the set's name. rho: of P9, where the task has a period."""

    table: Sequence[Sequence[tuple[int, int]]]
    unit_bits: int
    hints: dict[str, Any] = field(default_factory=dict)
    rho: tuple[Fraction, ...] = ()
    scalar: str = "float"


def still_design(width: int, unit_bits: int, n: int = 1, **claims_of_design: Any) -> ForgedDesign:
    """Return a tube about 0 that stands still: in every dimension from -6 width to 6 width units."""
    return ForgedDesign([[(-width, width)] * n] * 6, unit_bits, **claims_of_design)


def literal(value: Fraction, scalar: str) -> str:
    """Return a number as C has it, with enough digits."""
    mantissa, _, exponent = f"{DIGITS.divide(Decimal(value.numerator), Decimal(value.denominator)):.30e}".partition("e")
    return f"{mantissa}e{int(exponent)}" + ("F" if scalar == "float" else "")


def spelled_out(words: list[str], scalar: str) -> str:
    """Return a filled listing as C."""
    texts = []
    for word in words:
        number = re.fullmatch(r"\$(\d+(?:/\d+)?)", word)
        is_real = source.REAL.fullmatch(word) is not None
        text = literal(Fraction(number[1]), scalar) if number else word + ("F" if is_real and scalar == "float" else "")
        texts.append("\n" + text if text.startswith("#") else text)
    return " ".join(texts)


def forged_claims(task: Task, tube: Tube, error: int, hints: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the claims of order 1 with the smallest margins that are allowed."""
    end = tube.segments
    return [
        {"property": "P1", "on": [0, end], "margin": 2 * error},
        {"property": "P2", "on": [0, 0], "margin": error},
        {"property": "P3", "on": [0, end], "margin": error},
        *({"property": "P4", "on": [0, end], "set": s.name, "margin": error, "hints": hints[s.name]} for s in task.unsafe),
        {"property": "P5", "on": [end, end], "margin": error},
        {"property": "P6", "on": [0, end]} | ({"margin": 0} if task.max_speed else {}),
        *([{"property": "P8", "on": [0, end], "margin": 1}] if task.proves_limits else []),
    ]


def forged_files(text: str, design: ForgedDesign) -> Files:
    """Return task, C, header and certificate of a design. The task has order 1, and no mission, no period of an axis and no guard."""
    task, scalar, unit = Task(text.encode()), design.scalar, Fraction(2) ** -design.unit_bits
    bits = claims.BITS[scalar]
    tube = Tube([v * unit for row in design.table for pair in row for v in pair], task.n, unit, task.t_c, None)
    error = arithmetic_error(tube, bits)
    edge_claims, gain = [units_above(v, unit) for v in error], task.gain or [Fraction(1)] * task.n
    law = Law(scalar, bits, gain, [], claims.LAW_ERROR[scalar, task.inline], error, [], edge_claims, [])
    limit = limits.emitted_limits(task, bits)
    lack = [max(s[0] * unit - a, b - s[1] * unit) * 1000 - (b - a) for s, a, b in zip(tube.start, *task.start, strict=True)]
    certificate: dict[str, Any] = {
        "format": 3, "task": task.name, "certified": True, "design": "refined", "method": "exact", "order": 1, "scalar": scalar,
        "grid": {"segments": tube.segments, "cuts": 1, "unit_bits": design.unit_bits}, "edge_error": edge_claims,
        "speed": [tube.fastest(i) for i in range(task.n)], "start": [list(v) for v in tube.start], "covers_initial_set": max(lack) <= 0,
        "control": {"gain": texts(gain), "e_max": texts(task.e_max), "u_max": texts(limit) if limit else None},
        "claims": forged_claims(task, tube, max(edge_claims), design.hints),
        "sha256": {"task_data": task.digest, f"{task.name}.py": "0"},
    }  # fmt: skip
    if task.clock:
        certificate["clock"] = task.clock
    if task.period is not None:
        shift = period.shifts(task, tube, law)
        u = period.prove(task, tube, law, list(design.rho), shift)
        certificate["sampled"] = {"period": str(task.period), "latency": str(task.latency), "share": str(task.share)}
        certificate["sampled"] |= {"plant": task.stated, "rho": texts(design.rho), "u": texts(u), "shift": texts(shift)}
    files = {"task.toml": text.encode()}
    with mock.patch.object(controller, "require_in_range"), mock.patch.object(source, "require_in_range"):
        values = controller.values_of(task, tube, law, covered_starts(task, tube, law))
        values["hash"] = design_hash(task, tube, law, design.unit_bits)
        for listing, end in (("controller", "c"), ("header", "h")):
            words = source.fill(listing, controller.options_of(task, law, False), task.name, values)
            data = files[f"{task.name}.{end}"] = spelled_out(words, scalar).encode()
            certificate["sha256"][f"{task.name}.{end}"] = hashlib.sha256(data).hexdigest()
    return {**files, f"{task.name}.certificate.json": json.dumps(certificate).encode()}


def texts(values: Sequence[Fraction]) -> list[str]:
    return [str(Fraction(v)) for v in values]
