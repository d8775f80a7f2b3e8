"""What a theorem is about, from the three files that are shipped: task, C, certificate. Nothing is taken from how they were made.

The C is read by the stand-alone checker's reader. That the frame around the statements read here is what it should be (loops,
comparisons, indices, the law) is that checker's word: `stt_codegen.theorem.asking` asks it first.
"""

from __future__ import annotations

import json
import math
import re
from fractions import Fraction
from typing import Any

from stt_codegen.certify import checker
from stt_codegen.design_kinds import CAPABILITIES, kinds_offering
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.properties import Property
from stt_codegen.theorem.facts import Facts, Operand, Sampling, Statement
from stt_codegen.theorem.unsafe_sets import Edges, Sets, normals, sets

LATE = 4  # rounding errors of K: three are made, see proof/Emitted.v
FORMATS = {"float": ("Single", 24, 150), "double": ("Double", 53, 1075)}  # for Coq, bits, half the least number is 2^- that
KERNEL = re.compile(r"const \w+ (\w+) = (\S+) ([-+*]) (\S+)")
TIME = (  # the statements of `segment`; what is rounded in them are the two constants
    r"const bool positive = 0\.0F? < t",
    r"const \w+ started = positive \? t : 0\.0F?",
    r"const \w+ scaled = started \* (?P<rate>\S+)",
    r"const bool early = scaled < (?P<last>\S+)",
    r"const \w+ u = early \? scaled : (?P<held>\S+)",
    r"const int32_t segment = \( int32_t \) u",
    r"const \w+ base = \( \w+ \) segment",
    r"const \w+ place = u - base",
    r"const int32_t first = segment \* (?P<row>\d+)",
    r"\* row = first",
    r"\* s = place",
)


class Unread(Exception):
    """A file that does not say what a theorem needs: the theorem is not there."""


def covered(task: bytes, certificate: dict[str, Any]) -> checker.Task:
    """The task's numbers. Raises `BadInput`, with what it is that no theorem is written about yet."""
    offered = CAPABILITIES.get(certificate.get("design", ""))
    if offered is None or not offered.has_exact_claims:
        kinds = kinds_offering("has_exact_claims")
        raise BadInput(f"theorem: a {certificate.get('design')} tube has none; theorems are about {kinds} ones")
    if certificate.get("scalar") not in ("float", "double"):
        raise BadInput("theorem: not yet about controllers in integers; use --scalar float or double")
    try:
        read = checker.Task(task)
    except checker.Unusable as problem:
        raise BadInput(f"theorem: {problem}") from problem
    moving = read.clock is not None or any(course is not None for course in read.courses)
    for there, what in (
        (read.mission is not None, "missions"),
        (moving, "sets that move, or are unsafe only for a while"),
        (bool(read.turns.periods), "axes that close (periodic): Coq does not read turns yet"),
    ):
        if there:
            raise BadInput(f"theorem: not yet about {what}")
    return read


def beyond(task: checker.Task) -> str:
    """What the theorems about the loop are not yet about; that about the emitted tube is, for it goes by no law."""
    kinds = {
        "plant.order 2": task.order != 1,
        'saturate = "scale"': task.scales,
        "negative gains": task.gain is not None and min(task.gain) < 0,
    }
    return next((what for what, there in kinds.items() if there), "")


def facts(task: bytes, source: bytes, certificate: bytes) -> Facts:
    """Read the three files. Raises `BadInput` for what no theorem is written about, `Unread` where the C or the certificate is
    not what it should be."""
    try:
        document = json.loads(certificate)
        read = covered(task, document if isinstance(document, dict) else {})
        return _facts(read, sets(task, read), source, document)
    except (checker.Failed, checker.Unusable) as problem:
        raise Unread(str(problem)) from problem
    except (KeyError, TypeError, ValueError, ArithmeticError, AttributeError, IndexError, RecursionError) as problem:
        raise Unread(f"a file is not what it should be ({type(problem).__name__}: {problem})") from problem


def _facts(task: checker.Task, told: Sets, source: bytes, document: dict[str, Any]) -> Facts:
    c = checker.Source(source, task, document["scalar"] == "float")
    tube = checker.Tube(c, task, document["grid"]["unit_bits"])
    rate, last = spline_time(c, task.n)
    control, error = document["control"], max(*document["edge_error"], rounding_bound(c, tube))
    hints = {claim["set"]: claim.get("hints") for claim in document["claims"] if claim["property"] == Property.AVOID.code}
    gain = checker.fractions(control["gain"], task.n)
    u_max = None if control["u_max"] is None else checker.fractions(control["u_max"], task.n)
    looped = not beyond(task)
    if task.gain not in (None, gain) or (looped and min(gain) <= 0) or type(error) is not int:
        raise Unread("the certificate's gain is not the task's, or not positive, or an error is no whole number")
    for name, values in (("gain", gain), ("u_max", u_max)):
        if (
            looped
            and values is not None
            and c.tables.get(name, values) not in (values, [checker.rounded(v, c.bits) for v in values])
        ):
            raise Unread(f"the C has another {name} than the certificate")
    if (u_max is None) != (task.u_max is None) or any(a > b for a, b in zip(u_max or [], task.u_max or [], strict=True)):
        raise Unread("the certificate's u_max is not the task's")
    return Facts(
        name=task.name,
        scalar=document["scalar"],
        design=RefinedDesign(task.t_c, tube.segments, document["grid"]["unit_bits"], tuple(tuple(row) for row in tube.table)),
        state=tuple(task.state),
        space=_edges(task.space),
        start=_edges(task.start),
        target=_edges(task.target),
        unsafe=tuple((name, shape) for (name, _), shape in zip(task.unsafe, told.unsafe, strict=True)),
        normals=tuple(normals(shape, hints.get(name)) for (name, _), shape in zip(task.unsafe, told.unsafe, strict=True)),
        walls=told.walls,
        goals=told.goals,
        clearance=task.clearance,
        min_width=task.min_width,
        error=error,
        rate=rate,
        last=last,
        code=kernels(c),
        gain=tuple(gain),
        e_max=tuple(task.e_max),
        u_max=None if u_max is None else tuple(u_max),
        tick=task.tick,
        inline=task.inline,
        beyond=beyond(task),
        sampling=None if task.period is None or not looped else _sampling(task, c, document["sampled"], error * tube.unit),
    )


def lateness(segments: int, t_c: Fraction, scalar: str) -> Fraction:
    """What the emitted spline time may be wrong by, in segments."""
    _, bits, least = FORMATS[scalar]
    eps = Fraction(1, 1 << bits)
    return segments * LATE * eps * (1 + eps) + Fraction(1, 1 << least) * (1 + segments / t_c)


def rounding_bound(source: checker.Source, tube: checker.Tube) -> int:
    """P7's bound in units as proof/EmittedTube.v has it: for each dimension the largest loss in `basis` and `blend` of all."""
    late = lateness(tube.segments, tube.t_c, source.scalar)
    moved = [late * tube.fastest(i, 1) for i in range(tube.n)]
    lost = [v / tube.unit - m for v, m in zip(checker.arithmetic(source, tube), moved, strict=True)]
    return math.ceil(max(lost) + max(moved) + Fraction(1, 1 << 30))


def _edges(box: checker.Box) -> Edges:
    return tuple(box[0]), tuple(box[1])


def _sampling(task: checker.Task, source: checker.Source, claim: dict[str, Any], error: Fraction) -> Sampling:
    assert task.period is not None
    force, g_min, g_max, cross = zip(*(checker.bounds(task, i) for i in range(task.n)), strict=True)
    rho, shift = (tuple(checker.fractions(claim[key], task.n)) for key in ("rho", "shift"))
    lost = Fraction(checker.LAW["inline" if task.inline else "libm"][source.bits])
    noise, eps = (task.plant["noise"] or [Fraction(0)])[0], Fraction(1, 1 << source.bits)
    shift = tuple(max(v, error + noise + eps * task.farthest) for v in shift)  # error: of whole units, unlike the shift
    return Sampling(
        period=task.period,
        latency=task.latency,
        share=task.share,
        force=force,
        g_min=g_min,
        g_max=g_max,
        g_cross=cross,
        rho=rho,
        shift=shift,
        lost=lost,
        noise=noise,
    )


def _body(source: checker.Source, name: str) -> checker.Tree:
    if name not in source.functions:
        raise Unread(f"the C has no {name}")
    return source.functions[name].body


def spline_time(source: checker.Source, n: int) -> tuple[Fraction, Fraction]:
    """K/t_c and the last spline time, from the statements of `segment`, which are these."""
    body, found = _body(source, "segment"), {}
    matches = [re.fullmatch(pattern, str(said)) for pattern, said in zip(TIME, body, strict=False)]
    if len(body) != len(TIME) or None in matches:
        raise Unread("the statements of `segment` are not those of a spline's time")
    for match in matches:
        found.update(match.groupdict() if match is not None else {})
    if found["last"] != found["held"] or found["row"] != str(2 * n):
        raise Unread("`segment` holds time at another number than it compares it with, or has another length of rows")
    return source.number(found["rate"])[1], source.number(found["last"])[1]


def kernels(source: checker.Source) -> tuple[Statement, ...]:
    """`basis` and then `blend` as one list: every statement has a number, after s and the four coefficients. What is stored and
    returned is checked by name."""
    numbers = {name: k for k, name in enumerate(("s", "q0", "q1", "q2", "q3"))}
    code: list[Statement] = []

    def operand(text: str, known: dict[str, int]) -> Operand:
        if text in known:
            return "V", known[text]
        value = source.number(text)[1]
        if value.denominator != 1:
            raise Unread(f"`basis` has the constant {text}, which is not whole")
        return "C", int(value)

    def run(name: str, known: dict[str, int]) -> dict[str, int]:
        results: dict[str, int] = {}
        for said in _body(source, name):
            match = KERNEL.fullmatch(str(said))
            if match is None:
                target, _, value = str(said).rpartition(" ")
                results[target] = known[value]
                continue
            code.append((match[3], operand(match[2], known), operand(match[4], known)))
            known[match[1]] = 4 + len(code)
        return results

    for name, parameters in (("basis", ["s", "w0", "w1", "w2", "w3"]), ("blend", [f"{a}{j}" for a in "wq" for j in range(4)])):
        if name in source.functions and [label for _, label, _ in source.functions[name].params] != parameters:
            raise Unread(f"{name} of the C has other parameters than it should")
    stored = run("basis", {"s": numbers["s"]})
    if list(stored) != [f"* w{j} =" for j in range(4)]:
        raise Unread("`basis` stores other results than it should")
    weights = {f"w{j}": stored[f"* w{j} ="] for j in range(4)}
    returned = run("blend", {k: v for k, v in numbers.items() if k != "s"} | weights)
    if returned != {"return": 4 + len(code)}:
        raise Unread("`blend` returns another value than its last")
    return tuple(code)
