"""The text of the files of a controller in integers: what `render` makes of one in floating point."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from types import ModuleType
from typing import Any

import jinja2

from stt_codegen.certify.certificate import Certificate
from stt_codegen.certify.schedule import phases
from stt_codegen.controller.integers.law import law_of
from stt_codegen.decimals import decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.emit.naming import file_names, phase_name, selftest_name
from stt_codegen.program import Program, Status
from stt_codegen.program.print.c import CPrinter
from stt_codegen.program.print.python import PythonPrinter
from stt_codegen.task import Task

CALM: tuple[float, ...] = (0.48, 0.53, 0.505, 0.46)  # of the way from the lower edge to the upper one
STRIKING = (0.03, 0.97, -0.5, 1.5)
ENDS = (-(2**31), 2**31 - 1)


def texts(
    task: Task,
    design: RefinedDesign,
    program: Program,
    certificate: Certificate,
    common: dict[str, Any],
    template: Callable[[str], jinja2.Template],
) -> dict[str, str]:
    """Header, C and Python by name; a self-test and phases where they are asked for. common: what both templates are told."""
    assert program.tick is not None
    header, source, module, _ = file_names(task.name)
    law = law_of(task, design)
    told = common | {
        "x_bits": design.bits,
        "u_bits": law.u_bits,
        "x_scale": power_of_two(design.bits),
        "u_scale": power_of_two(law.u_bits),
        "last_tick": math.ceil(task.prescribed_time / program.tick),
        "tick": decimal(program.tick),
        "ticks_a_second": _number(1 / program.tick),
        "t_c": decimal(task.prescribed_time),
        "statuses": [Status.OK, Status.OUTSIDE_TUBE],
        "phases": [],
    }
    if certificate.mission is not None:
        told["phases"] = [(math.ceil(until / program.tick), entry) for until, entry in phases(task, certificate.mission)]
    if certificate.proved_period is not None:
        told["proved"] = int(certificate.proved_period.period / program.tick)
    printer, python = CPrinter(program), PythonPrinter(program)

    def made(name: str, **more: Any) -> str:
        return template(name).render(**told, **more)

    files = {
        header: made("fixed.h.j2", c=printer),
        source: made("fixed.c.j2", c=printer),
        module: made("fixed.py.j2", python=python),
    }
    if told["phases"]:
        files[phase_name(task.name)] = made("fixed_phase.c.j2")
    if task.emit.selftest:
        vectors = [p.name for p in program.function("control").params if p.length and not p.output]
        calls = [
            (tick, [_literal(v) for v in given], status)
            for tick, given, status in _calls(design, loaded(files[module]), int(told["last_tick"]), len(vectors))
        ]
        files[selftest_name(task.name)] = made("fixed_selftest.c.j2", vectors=vectors, calls=calls, n=program.dimension)
    return files


def loaded(text: str) -> ModuleType:
    """The emitted Python."""
    module = ModuleType("emitted")
    exec(compile(text, "emitted", "exec"), module.__dict__)
    return module


def power_of_two(bits: int) -> str:
    """2^bits as a number of C."""
    return f"{2**bits}.0" if bits >= 0 else f"(1.0 / {2**-bits}.0)"


def _number(value: Fraction) -> str:
    return str(value.numerator) if value.denominator == 1 else f"({value.numerator}.0 / {value.denominator}.0)"


def _literal(value: int) -> str:
    return "INT32_MIN" if value == ENDS[0] else str(value)


def _calls(design: RefinedDesign, module: ModuleType, last: int, vectors: int) -> list[tuple[int, list[int], str]]:
    """Calls of `control` and their results: near the middle in every third segment, where u is not saturated, so that every
    coefficient moves some u; at the edges, outside, and at the ends of all integers. Of order 2 v + lambda x stands so too."""
    places = [k for k in range(design.segments) if k % 3 == 0 or k == design.segments - 1]
    when = [(last * (2 * k + 1) // (2 * design.segments), CALM) for k in places]
    when += [(last * (2 * k + 1) // (2 * len(STRIKING)), (share,)) for k, share in enumerate(STRIKING)]
    when += [(tick, CALM) for tick in (0, last, 2**32 - 1)]
    given = []
    for k, (tick, shares) in enumerate(when):

        def standing(edges: Any, shift: int, k: int = k, shares: tuple[float, ...] = shares) -> list[int]:
            pairs = enumerate(zip(*edges, strict=True))
            return [a + round((b - a) * shares[(k + i + shift) % len(shares)]) for i, (a, b) in pairs]

        state = [standing(module.tube(tick), 0)]
        if design.filter:
            held = zip(standing(module.filtered_tube(tick), 1), design.filter, state[0], strict=True)
            state.append([round(z - value * x) for z, value, x in held])
        given.append((tick, state))
    given += [(last // 3, [[end] * design.dimension] * vectors) for end in ENDS]
    calls = []
    for tick, state in given:
        status, u = module.control(tick, *state)
        calls.append((tick, [v for vector in state for v in vector] + list(u), Status(status).name))
    return calls
