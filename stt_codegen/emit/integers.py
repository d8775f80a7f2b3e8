"""The text of the files of a controller in integers: what `render` makes of one in floating point."""

from __future__ import annotations

import math
from fractions import Fraction
from types import ModuleType
from typing import Any

from stt_codegen.certify import Certificate
from stt_codegen.certify.missions import phases
from stt_codegen.controller import start_share
from stt_codegen.controller.integers import OVER_BITS, RISE_BITS, law_of
from stt_codegen.decimals import decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.emit.naming import phase_name, selftest_name
from stt_codegen.program import Program, Status, round_down, shortest
from stt_codegen.program.targets import targets_of
from stt_codegen.program.targets.template_files import template
from stt_codegen.task import Task

CALM: tuple[float, ...] = (0.48, 0.53, 0.505, 0.46)  # of the way from the lower edge to the upper one
STRIKING = (0.03, 0.97, -0.5, 1.5)
ENDS = (-(2**31), 2**31 - 1)
WATCHED = 256  # ticks of a mission, among which a wide tube and its rows are looked for


def texts(
    task: Task,
    design: RefinedDesign,
    program: Program,
    certificate: Certificate,
    common: dict[str, Any],
) -> dict[str, str]:
    """The files of each language by name, a self-test and phases where asked for. common: what all templates are told."""
    assert program.tick is not None
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
        "share_text": decimal(start_share(task)),
        "share": shortest(round_down(start_share(task), "double"), "double"),
    }
    if certificate.mission is not None:
        told["phases"] = [(math.ceil(until / program.tick), entry) for until, entry in phases(task, certificate.mission)]
    if certificate.proved_period is not None:
        told["proved"] = int(certificate.proved_period.period / program.tick)

    def made(name: str, **more: Any) -> str:
        return template(name).render(**told, **more)

    files = {
        task.name + suffix: made(f"{target.key}/fixed{suffix}.j2", **{target.key: target.printer(program)})
        for target in targets_of(task.emit)
        for suffix in target.suffixes
    }
    if told["phases"]:
        files[phase_name(task.name)] = made("c/fixed_phase.c.j2")
    if task.emit.selftest:
        vectors = [p.name for p in program.function("control").params if p.length and not p.output]
        calls = [
            (tick, [_literal(v) for v in given], status)
            for tick, given, status in _calls(design, loaded(files[f"{task.name}.py"]), int(told["last_tick"]), law.octaves)
        ]
        files[selftest_name(task.name)] = made("c/fixed_selftest.c.j2", vectors=vectors, calls=calls, n=program.dimension)
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
    return f"INT32_C({value.numerator})" if value.denominator == 1 else f"({value.numerator}.0 / {value.denominator}.0)"


def _literal(value: int) -> str:
    return "INT32_MIN" if value == ENDS[0] else str(value)


def _calls(design: RefinedDesign, module: ModuleType, last: int, octaves: int) -> list[tuple[int, list[int], str]]:
    """Calls of `control` and their results: near the middle in every third segment, where u is not saturated, so that every
    coefficient moves some u; in every row of the curves, of H where the tube is widest, so that u is the least; on the edges and
    beside them, outside, and at the ends of all integers. Of order 2 v + lambda x stands so too, and one of the two alone is
    outside."""
    n, middle = design.dimension, (0.5,) * design.dimension
    places = [k for k in range(design.segments) if k % 3 == 0 or k == design.segments - 1]
    when = [last * (2 * k + 1) // (2 * design.segments) for k in places]
    stands = [(tick, _turned(CALM, k, n), _turned(CALM, k + 1, n)) for k, tick in enumerate([*when, 0, last, 2**32 - 1])]
    striking = enumerate(STRIKING)
    stands += [(last * (2 * k + 1) // (2 * len(STRIKING)), (share,) * n, (share,) * n) for k, share in striking]
    wide = _widths(design, module, last)
    widest = max(wide, key=lambda tick: min(wide[tick]))
    for row in range(octaves << RISE_BITS):
        shares = tuple(_share_in(row + i * (octaves << RISE_BITS) // n, octaves, i % 2 == 1) for i in range(n))
        stands.append((widest, middle if design.filter else shares, shares))
    seen: set[tuple[int, int]] = set()
    for tick, widths in wide.items():  # rows of 1/d, by the leading bits of a width
        rows = {(i, w >> (w.bit_length() - 1 - OVER_BITS)) for i, w in enumerate(widths)}
        if rows - seen:
            stands.append((tick, _turned(CALM, tick, n), _turned(CALM, tick + 1, n)))
            seen |= rows
    if design.filter:
        stands += [(last // 2, (share,) * n, middle) for share in (-0.02, 1.02)]
        stands += [(last // 2, middle, (share,) * n) for share in (-0.02, 1.02)]
    given = [(tick, _state(design, module, tick, x, z)) for tick, x, z in stands]
    if not design.filter:
        lower, upper = (list(v) for v in module.tube(last // 2))
        halves = [(a + b) // 2 for a, b in zip(lower, upper, strict=True)]
        given += [(last // 2, [[v + by for v in edge]]) for edge in (lower, upper, halves) for by in (-1, 0, 1)]
    given += [(last // 3, [[end] * n] * (2 if design.filter else 1)) for end in ENDS]
    calls = []
    for tick, state in given:
        status, u = module.control(tick, *state)
        calls.append((tick, [v for vector in state for v in vector] + list(u), Status(status).name))
    return calls


def _turned(shares: tuple[float, ...], by: int, n: int) -> tuple[float, ...]:
    return tuple(shares[(by + i) % len(shares)] for i in range(n))


def _share_in(row: int, octaves: int, high: bool) -> float:
    """Of the way from the lower edge to the upper one, where y = 1 - |e| is in the middle of a row of H."""
    octave, part = divmod(row % (octaves << RISE_BITS), 1 << RISE_BITS)
    y = 2.0 ** -(octave + 1) * (1 + (part + 0.5) / (1 << RISE_BITS))
    return 1 - y / 2 if high else y / 2


def _widths(design: RefinedDesign, module: ModuleType, last: int) -> dict[int, list[int]]:
    """By tick, in units, the widths of the tube that the law goes by."""
    tube = module.filtered_tube if design.filter else module.tube
    ticks = sorted({last * k // WATCHED for k in range(WATCHED + 1)})
    return {tick: [b - a for a, b in zip(*tube(tick), strict=True)] for tick in ticks}


def _state(design: RefinedDesign, module: ModuleType, tick: int, x: tuple[float, ...], z: tuple[float, ...]) -> list[list[int]]:
    """x, and of order 2 v, from where x and v + lambda x are between their edges."""

    def standing(edges: Any, shares: tuple[float, ...]) -> list[int]:
        return [a + round((b - a) * share) for a, b, share in zip(*edges, shares, strict=True)]

    own = standing(module.tube(tick), x)
    if not design.filter:
        return [own]
    held = standing(module.filtered_tube(tick), z)
    return [own, [round(one - value * at) for one, value, at in zip(held, design.filter, own, strict=True)]]
