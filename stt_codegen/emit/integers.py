"""The text of the files of a controller in integers: what render.py does for one in floating point, whose `render` calls it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from types import ModuleType
from typing import Any, NamedTuple

from stt_codegen.certify import Certificate
from stt_codegen.certify.missions import phases
from stt_codegen.controller import start_share
from stt_codegen.controller.integers import H_PIECE_BITS, RECIPROCAL_PIECE_BITS, build_integer_law
from stt_codegen.decimals import decimal
from stt_codegen.designs import RefinedDesign
from stt_codegen.emit.naming import phase_name, selftest_name
from stt_codegen.program import Program, Status, round_down, shortest
from stt_codegen.program.targets import targets_of
from stt_codegen.program.targets.template_files import template
from stt_codegen.task import Task

Positions = tuple[float, ...]  # by component, of the way from the lower edge to the upper one

NEAR_MIDDLE_POSITIONS: Positions = (0.48, 0.53, 0.505, 0.46)
EDGE_POSITIONS = (0.03, 0.97, -0.5, 1.5)  # beside the edges and outside
OUTSIDE_POSITIONS = (-0.02, 1.02)  # just outside
INTEGER_ENDS = (-(2**31), 2**31 - 1)
SEARCHED_TICKS = 256  # of a mission, among which the widest tube and all rows of 1/d are looked for


def texts(
    task: Task,
    design: RefinedDesign,
    program: Program,
    certificate: Certificate,
    common: dict[str, Any],
) -> dict[str, str]:
    """Return the text of each file by name: of every language, and of phases and self-test where there are any.

    common: the names that templates of every scalar read.
    """
    assert program.tick is not None
    law = build_integer_law(task, design)
    names = common | _template_names(task, design, program, certificate)

    def rendered(template_name: str, **more_names: Any) -> str:
        return template(template_name).render(**names, **more_names)

    files = {
        task.name + suffix: rendered(f"{target.key}/fixed{suffix}.j2", **{target.key: target.printer(program)})
        for target in targets_of(task.emit)
        for suffix in target.suffixes
    }
    if names["phases"]:
        files[phase_name(task.name)] = rendered("c/fixed_phase.c.j2")
    if task.emit.selftest:
        vectors = [p.name for p in program.function("control").params if p.length and not p.output]
        module = loaded(files[f"{task.name}.py"])
        calls = [
            (tick, [_literal(v) for v in numbers], status)
            for tick, numbers, status in _selftest_calls(design, module, int(names["last_tick"]), law.octaves)
        ]
        files[selftest_name(task.name)] = rendered("c/fixed_selftest.c.j2", vectors=vectors, calls=calls, n=program.dimension)
    return files


def _template_names(task: Task, design: RefinedDesign, program: Program, certificate: Certificate) -> dict[str, Any]:
    """Return what only the templates of integers read, or read in another form."""
    assert program.tick is not None
    law = build_integer_law(task, design)
    names: dict[str, Any] = {
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
        names["phases"] = [(math.ceil(until / program.tick), entry) for until, entry in phases(task, certificate.mission)]
    if certificate.proved_period is not None:
        names["proved"] = int(certificate.proved_period.period / program.tick)
    return names


def loaded(text: str) -> ModuleType:
    """Return the emitted Python as a module."""
    module = ModuleType("emitted")
    exec(compile(text, "emitted", "exec"), module.__dict__)
    return module


def power_of_two(bits: int) -> str:
    """Return 2^bits as a number of C."""
    return f"{2**bits}.0" if bits >= 0 else f"(1.0 / {2**-bits}.0)"


def _number(value: Fraction) -> str:
    return f"INT32_C({value.numerator})" if value.denominator == 1 else f"({value.numerator}.0 / {value.denominator}.0)"


def _literal(value: int) -> str:
    return "INT32_MIN" if value == INTEGER_ENDS[0] else str(value)


# ------------------------------------------------------------------------------------------------ self-test


class _TubeState(NamedTuple):
    """A tick, and the positions of x and v + lambda x between their edges at that tick.

    A position is 0 at the lower edge and 1 at the upper edge. Without a filter only x counts.
    """

    tick: int
    x: Positions
    filtered: Positions


@dataclass(frozen=True)
class _State:
    """A tick, and x (of order 2 also v) in units."""

    tick: int
    vectors: list[list[int]]


def _selftest_calls(design: RefinedDesign, module: ModuleType, last_tick: int, octaves: int) -> list[tuple[int, list[int], str]]:
    """Return calls of `control`: the tick, its arguments with the u that they give, and the name of the status."""
    widths = _widths_by_tick(design, module, last_tick)
    tube_states = [
        *_states_in_segments(design, last_tick),
        *_states_in_rise_rows(design, widths, octaves),
        *_states_in_over_rows(design, widths),
    ]
    if design.filter:
        tube_states += _states_outside_one_tube(design, last_tick)
    states = [_State(s.tick, _state_at(design, module, s)) for s in tube_states]
    if not design.filter:
        states += _states_beside_edges(module, last_tick)
    vector_count = 2 if design.filter else 1
    states += [_State(last_tick // 3, [[end] * design.dimension] * vector_count) for end in INTEGER_ENDS]
    calls = []
    for state in states:
        status, u = module.control(state.tick, *state.vectors)
        calls.append((state.tick, [v for vector in state.vectors for v in vector] + list(u), Status(status).name))
    return calls


def _states_in_segments(design: RefinedDesign, last_tick: int) -> list[_TubeState]:
    """Return states near the middle in every third segment, where u is not saturated, so that every coefficient moves some u;
    and states beside the edges and outside, spread over the mission."""
    n = design.dimension
    segments = [k for k in range(design.segments) if k % 3 == 0 or k == design.segments - 1]
    ticks = [last_tick * (2 * k + 1) // (2 * design.segments) for k in segments]
    tube_states = [_near_middle(tick, k, n) for k, tick in enumerate([*ticks, 0, last_tick, 2**32 - 1])]
    for k, position in enumerate(EDGE_POSITIONS):
        tube_states.append(_TubeState(last_tick * (2 * k + 1) // (2 * len(EDGE_POSITIONS)), (position,) * n, (position,) * n))
    return tube_states


def _states_in_rise_rows(design: RefinedDesign, widths: dict[int, list[int]], octaves: int) -> list[_TubeState]:
    """Return a state for every row of the curve H, where the tube is widest, so that u is the smallest."""
    n, rows = design.dimension, octaves << H_PIECE_BITS
    widest_tick = max(widths, key=lambda tick: min(widths[tick]))
    tube_states = []
    for row in range(rows):
        positions = tuple(_position_in_row(row + i * rows // n, octaves, i % 2 == 1) for i in range(n))
        tube_states.append(_TubeState(widest_tick, (0.5,) * n if design.filter else positions, positions))
    return tube_states


def _states_in_over_rows(design: RefinedDesign, widths: dict[int, list[int]]) -> list[_TubeState]:
    """Return a state near the middle for every row of the curve 1/d, which the leading bits of a width select."""
    tube_states = []
    covered_rows: set[tuple[int, int]] = set()
    for tick, tick_widths in widths.items():
        rows = {(i, w >> (w.bit_length() - 1 - RECIPROCAL_PIECE_BITS)) for i, w in enumerate(tick_widths)}
        if rows - covered_rows:
            tube_states.append(_near_middle(tick, tick, design.dimension))
            covered_rows |= rows
    return tube_states


def _states_outside_one_tube(design: RefinedDesign, last_tick: int) -> list[_TubeState]:
    """Return states of order 2 of which only x, or only v + lambda x, is outside its tube."""
    n = design.dimension
    middle = (0.5,) * n
    tube_states = [_TubeState(last_tick // 2, (position,) * n, middle) for position in OUTSIDE_POSITIONS]
    return tube_states + [_TubeState(last_tick // 2, middle, (position,) * n) for position in OUTSIDE_POSITIONS]


def _states_beside_edges(module: ModuleType, last_tick: int) -> list[_State]:
    """Return states on the edges and in the middle, and one unit below and above them."""
    tick = last_tick // 2
    lower, upper = (list(v) for v in module.tube(tick))
    middle = [(a + b) // 2 for a, b in zip(lower, upper, strict=True)]
    return [_State(tick, [[v + step for v in x]]) for x in (lower, upper, middle) for step in (-1, 0, 1)]


def _near_middle(tick: int, k: int, n: int) -> _TubeState:
    """Return a state near the middle of both tubes: NEAR_MIDDLE_POSITIONS from entry k on, and from entry k + 1 on."""

    def positions_from(first: int) -> Positions:
        return tuple(NEAR_MIDDLE_POSITIONS[(first + i) % len(NEAR_MIDDLE_POSITIONS)] for i in range(n))

    return _TubeState(tick, positions_from(k), positions_from(k + 1))


def _position_in_row(row: int, octaves: int, is_high: bool) -> float:
    """Return the position at which y = 1 - |e| is in the middle of a row of H; is_high: on the upper half."""
    octave, part = divmod(row % (octaves << H_PIECE_BITS), 1 << H_PIECE_BITS)
    y = 2.0 ** -(octave + 1) * (1 + (part + 0.5) / (1 << H_PIECE_BITS))
    return 1 - y / 2 if is_high else y / 2


def _widths_by_tick(design: RefinedDesign, module: ModuleType, last_tick: int) -> dict[int, list[int]]:
    """Return by tick, in units, the widths of the tube that the control law uses: with a filter those of the filtered tube."""
    tube = module.filtered_tube if design.filter else module.tube
    ticks = sorted({last_tick * k // SEARCHED_TICKS for k in range(SEARCHED_TICKS + 1)})
    return {tick: [b - a for a, b in zip(*tube(tick), strict=True)] for tick in ticks}


def _state_at(design: RefinedDesign, module: ModuleType, stand: _TubeState) -> list[list[int]]:
    """Return x, and of order 2 v, in units."""

    def between(edges: Any, positions: Positions) -> list[int]:
        return [a + round((b - a) * position) for a, b, position in zip(*edges, positions, strict=True)]

    x = between(module.tube(stand.tick), stand.x)
    if not design.filter:
        return [x]
    filtered = between(module.filtered_tube(stand.tick), stand.filtered)
    return [x, [round(z - rate * x_i) for z, rate, x_i in zip(filtered, design.filter, x, strict=True)]]
