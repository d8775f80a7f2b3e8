"""Read what a theorem is about from the three shipped files: task, C and certificate. No other data of the design is used.

Task, table and sets are read by the stand-alone checker's reader, constants of time and statements that compute by kernels.py.
That loops, comparisons, indices and the law are those of the listing is the checker's answer: theorem/coq.py asks it first.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

from stt_codegen.checker.stt_checker.claims import LAW_ERROR
from stt_codegen.checker.stt_checker.exact import Refused, Unusable, fractions, rounded
from stt_codegen.checker.stt_checker.rounding import arithmetic_error
from stt_codegen.checker.stt_checker.source import real_table, tokens
from stt_codegen.checker.stt_checker.task import Task
from stt_codegen.checker.stt_checker.tube import Tube
from stt_codegen.design_kinds import CAPABILITIES, kinds_offering
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.properties import Property
from stt_codegen.theorem.facts import Facts, SampledFacts
from stt_codegen.theorem.hints import is_period_proved
from stt_codegen.theorem.kernels import KernelText, read_kernels, read_spline_time
from stt_codegen.theorem.unsafe_sets import sets_of, usable_normals


class Format(NamedTuple):
    """A floating-point format: its name in proof/Rounding.v, the bits of its mantissa, and k where half its smallest number is
    2^-k."""

    coq_name: str
    bits: int
    underflow_exponent: int


FORMATS = {"float": Format("Single", 24, 150), "double": Format("Double", 53, 1075)}
SCALE_ROUNDINGS = 4  # roundings of K/t_c that are allowed for; three occur, see proof/Emitted.v


class Unread(Exception):
    """A file does not have what a theorem needs, so none can be written."""


def read_task(task: bytes, certificate: dict[str, Any]) -> Task:
    """Read the task's numbers. Raises `BadInput` that names what no theorem is written about yet."""
    capabilities = CAPABILITIES.get(certificate.get("design", ""))
    if capabilities is None or not capabilities.has_exact_claims:
        kinds = kinds_offering("has_exact_claims")
        raise BadInput(f"theorem: a {certificate.get('design')} tube has none; theorems are about {kinds} ones")
    if certificate.get("scalar") not in ("float", "double"):
        raise BadInput("theorem: not yet about controllers in integers; use --scalar float or double")
    try:
        numbers = Task(task)
    except Unusable as problem:
        raise BadInput(f"theorem: {problem}") from problem
    for has_feature, feature in (
        ("mission" in numbers.document, "missions"),
        (numbers.moves, "sets that move, or are unsafe only for a while"),
        (numbers.turns is not None, "axes that close (periodic): Coq does not read turns yet"),
        *(
            (isinstance(numbers.document.get("tube", {}).get(key), list), f"tube.{key} by component: state one number")
            for key in ("clearance", "min_width")
        ),
    ):
        if has_feature:
            raise BadInput(f"theorem: not yet about {feature}")
    return numbers


def uncovered_loop_feature(task: Task) -> str:
    """Return what of the task no theorem about the loop covers yet; empty where there is none.

    The theorem about the emitted tube covers such a task: it does not mention the law.
    """
    features = {
        "plant.order 2": task.order != 1,
        'saturate = "scale"': task.scales,
        "negative gains": task.gain is not None and min(task.gain) < 0,
        "a drive of [plant]": bool(task.drive.stated),
        "a plant that is assumed": task.assumes_plant,
        "a control.u_max that was chosen": task.leaves_limit,
        "a plant.noise by component": isinstance(task.stated["noise"], list),
    }
    return next((feature for feature, has_feature in features.items() if has_feature), "")


def read_facts(task: bytes, source: bytes, certificate: bytes) -> Facts:
    """Read the three files. Raises `BadInput` for a task without theorems, `Unread` where C or certificate do not fit it."""
    try:
        document = json.loads(certificate)
        numbers = read_task(task, document if isinstance(document, dict) else {})
        return _without_loop_of_path(_facts(numbers, source, document), document)
    except (Refused, Unusable) as problem:
        raise Unread(str(problem)) from problem
    except (KeyError, TypeError, ValueError, ArithmeticError, AttributeError, IndexError, RecursionError) as problem:
        raise Unread(f"a file is not what it should be ({type(problem).__name__}: {problem})") from problem


def _without_loop_of_path(facts: Facts, document: dict[str, Any]) -> Facts:
    """Return the facts without a sampled loop where the certificate's period is proved by the worst path alone."""
    if facts.sampling is None or "path" not in document["sampled"] or is_period_proved(facts, facts.sampling):
        return facts
    return replace(facts, sampling=None, uncovered_loop_feature="a period that only the worst path proves")


def _facts(task: Task, source: bytes, document: dict[str, Any]) -> Facts:
    """Compare the numbers of the three files, and collect them. document: the certificate."""
    sets, scalar, unit_bits = sets_of(task), document["scalar"], document["grid"]["unit_bits"]
    bits = FORMATS[scalar].bits
    c = KernelText(tokens(source.decode("ascii", "replace")), task.name, task.n, bits)
    tube = Tube(real_table(source, f"{task.name}_coefficients", bits), task.n, Fraction(2) ** -unit_bits, task.t_c, None)
    time_scale, last_spline_time = read_spline_time(c)
    edge_error = max(*document["edge_error"], rounding_bound(tube, scalar))
    gain, u_max = _gain_and_limits(task, source, bits, document["control"])
    if type(edge_error) is not int:
        raise Unread("the certificate has an edge error that is no whole number")
    hints = {claim["set"]: claim.get("hints") for claim in document["claims"] if claim["property"] == Property.AVOID.code}
    names, has_sampled_loop = (
        [obstacle.name for obstacle in task.unsafe],
        task.period is not None and not uncovered_loop_feature(task),
    )
    return Facts(
        name=task.name,
        scalar=scalar,
        design=RefinedDesign(task.t_c, tube.segments, unit_bits, tuple(tuple(row) for row in tube.table)),
        state=tuple(task.state),
        space=sets.space,
        start=sets.start,
        target=sets.target,
        unsafe=tuple(zip(names, sets.unsafe, strict=True)),
        normals=tuple(usable_normals(shape, hints.get(name)) for name, shape in zip(names, sets.unsafe, strict=True)),
        walls=sets.walls,
        goals=sets.goals,
        clearance=task.clearance[0],
        min_width=task.min_width[0],
        edge_error=edge_error,
        time_scale=time_scale,
        last_spline_time=last_spline_time,
        code=read_kernels(c),
        gain=tuple(gain),
        e_max=tuple(task.e_max),
        u_max=None if u_max is None else tuple(u_max),
        tick_period=task.tick,
        has_inline_logarithm=task.inline,
        uncovered_loop_feature=uncovered_loop_feature(task),
        sampling=_sampled_facts(task, scalar, document["sampled"], edge_error * tube.unit) if has_sampled_loop else None,
    )


def _gain_and_limits(
    task: Task, source: bytes, bits: int, control: dict[str, Any]
) -> tuple[list[Fraction], list[Fraction] | None]:
    """Return gain and u_max of the certificate's table `control`. Raises `Unread` where task or C have other ones."""
    gain = fractions(control["gain"], task.n)
    u_max = None if control["u_max"] is None else fractions(control["u_max"], task.n)
    has_law = not uncovered_loop_feature(task)
    if task.gain not in (None, gain) or (has_law and min(gain) <= 0):
        raise Unread("the certificate's gain is not the task's, or not positive")
    for name, values in (("gain", gain), ("u_max", u_max)):
        if has_law and values is not None and not _has_values(source, f"{task.name}_{name}", values, bits):
            raise Unread(f"the C has another {name} than the certificate")
    limits = u_max if task.leaves_limit else task.u_max
    if (u_max is None) != (limits is None) or any(a > b for a, b in zip(u_max or [], limits or [], strict=True)):
        raise Unread("the certificate's u_max is not the task's")
    return gain, u_max


def _has_values(source: bytes, table: str, values: Sequence[Fraction], bits: int) -> bool:
    """Whether the C's table has these values, rounded; also where it has no such table."""
    return f" {table}[".encode() not in source or real_table(source, table, bits) == [rounded(v, bits) for v in values]


def spline_time_error(segments: int, t_c: Fraction, scalar: str) -> Fraction:
    """Bound the error of the emitted spline time, in segments."""
    half_ulp, smallest = Fraction(1, 1 << FORMATS[scalar].bits), Fraction(1, 1 << FORMATS[scalar].underflow_exponent)
    return segments * SCALE_ROUNDINGS * half_ulp * (1 + half_ulp) + smallest * (1 + segments / t_c)


def rounding_bound(tube: Tube, scalar: str) -> int:
    """Return P7's bound in units as proof/EmittedTube.v has it.

    It is the largest error of `basis` and `edge_at` in any dimension, plus the largest movement of an edge by the time's error.
    """
    time_error = spline_time_error(tube.segments, tube.t_c, scalar)
    errors = arithmetic_error(tube, FORMATS[scalar].bits)
    by_time = [time_error * tube.fastest(i) for i in range(tube.n)]
    by_kernels = [v / tube.unit - moved for v, moved in zip(errors, by_time, strict=True)]
    return math.ceil(max(by_kernels) + max(by_time) + Fraction(1, 1 << 30))


def _sampled_facts(task: Task, scalar: str, claim: dict[str, Any], edge_error: Fraction) -> SampledFacts:
    """Return the numbers of the sampled loop. claim: the certificate's table `sampled`; edge_error: no longer in units."""
    assert task.period is not None
    disturbance, g_min, g_max, g_cross = zip(*(task.bounds(i) for i in range(task.n)), strict=True)
    rho, certified_shift = (tuple(fractions(claim[key], task.n)) for key in ("rho", "shift"))
    noise, half_ulp = task.noise(0)[0], Fraction(1, 1 << FORMATS[scalar].bits)
    # The certificate's shift has edge errors that are not rounded up to whole units, so it may be smaller.
    needed_shift = edge_error + noise + half_ulp * task.farthest
    return SampledFacts(
        period=task.period,
        latency=task.latency,
        share=task.share,
        disturbance=disturbance,
        g_min=g_min,
        g_max=g_max,
        g_cross=g_cross,
        rho=rho,
        shift=tuple(max(v, needed_shift) for v in certified_shift),
        law_error=LAW_ERROR[scalar, task.inline],
        noise=noise,
    )
