"""Read what a theorem is about from the three shipped files: task, C and certificate. No other data of the design is used.

The C is read by the stand-alone checker's reader. Only statements that compute are read here. Loops, comparisons, indices and the
law around them are compared by the checker: theorem/coq.py runs it first.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from stt_codegen.certify import checker
from stt_codegen.design_kinds import CAPABILITIES, kinds_offering
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.properties import Property
from stt_codegen.theorem.facts import Facts, Operand, SampledFacts, Statement
from stt_codegen.theorem.unsafe_sets import Edges, read_sets, usable_normals


class Format(NamedTuple):
    """A floating-point format: its name in proof/Rounding.v, the bits of its mantissa, and k where half its smallest number is
    2^-k."""

    coq_name: str
    bits: int
    underflow_exponent: int


FORMATS = {"float": Format("Single", 24, 150), "double": Format("Double", 53, 1075)}
SCALE_ROUNDINGS = 4  # roundings of K/t_c that are allowed for; three occur, see proof/Emitted.v
KERNEL_STATEMENT = re.compile(r"const \w+ (\w+) = (\S+) ([-+*]) (\S+)")
SEGMENT_STATEMENTS = (  # of `segment`, in order; only its two constants are rounded
    r"const bool positive = 0\.0F? < t",
    r"const \w+ started = positive \? t : 0\.0F?",
    r"const \w+ scaled = started \* (?P<scale>\S+)",
    r"const bool early = scaled < (?P<last>\S+)",
    r"const \w+ u = early \? scaled : (?P<last_again>\S+)",
    r"const int32_t segment = \( int32_t \) u",
    r"const \w+ base = \( \w+ \) segment",
    r"const \w+ place = u - base",
    r"const int32_t first = segment \* (?P<row_length>\d+)",
    r"\* row = first",
    r"\* s = place",
)


class Unread(Exception):
    """A file does not have what a theorem needs, so none can be written."""


def read_task(task: bytes, certificate: dict[str, Any]) -> checker.Task:
    """Read the task's numbers. Raises `BadInput` that names what no theorem is written about yet."""
    capabilities = CAPABILITIES.get(certificate.get("design", ""))
    if capabilities is None or not capabilities.has_exact_claims:
        kinds = kinds_offering("has_exact_claims")
        raise BadInput(f"theorem: a {certificate.get('design')} tube has none; theorems are about {kinds} ones")
    if certificate.get("scalar") not in ("float", "double"):
        raise BadInput("theorem: not yet about controllers in integers; use --scalar float or double")
    try:
        numbers = checker.Task(task)
    except checker.Unusable as problem:
        raise BadInput(f"theorem: {problem}") from problem
    has_changing_sets = numbers.clock is not None or any(course is not None for course in numbers.courses)
    for has_feature, feature in (
        (numbers.mission is not None, "missions"),
        (has_changing_sets, "sets that move, or are unsafe only for a while"),
        (bool(numbers.turns.periods), "axes that close (periodic): Coq does not read turns yet"),
    ):
        if has_feature:
            raise BadInput(f"theorem: not yet about {feature}")
    return numbers


def uncovered_loop_feature(task: checker.Task) -> str:
    """Return what of the task no theorem about the loop covers yet; empty where there is none.

    The theorem about the emitted tube covers such a task: it does not mention the law.
    """
    features = {
        "plant.order 2": task.order != 1,
        'saturate = "scale"': task.scales,
        "negative gains": task.gain is not None and min(task.gain) < 0,
    }
    return next((feature for feature, has_feature in features.items() if has_feature), "")


def read_facts(task: bytes, source: bytes, certificate: bytes) -> Facts:
    """Read the three files. Raises `BadInput` for a task without theorems, `Unread` where C or certificate do not fit it."""
    try:
        document = json.loads(certificate)
        numbers = read_task(task, document if isinstance(document, dict) else {})
        return _facts(numbers, task, source, document)
    except (checker.Failed, checker.Unusable) as problem:
        raise Unread(str(problem)) from problem
    except (KeyError, TypeError, ValueError, ArithmeticError, AttributeError, IndexError, RecursionError) as problem:
        raise Unread(f"a file is not what it should be ({type(problem).__name__}: {problem})") from problem


def _facts(task: checker.Task, task_file: bytes, source: bytes, document: dict[str, Any]) -> Facts:
    """Compare the numbers of the three files, and collect them. document: the certificate."""
    sets = read_sets(task_file, task)
    c = checker.Source(source, task, document["scalar"] == "float")
    tube = checker.Tube(c, task, document["grid"]["unit_bits"])
    time_scale, last_spline_time = read_spline_time(c, task.n)
    edge_error = max(*document["edge_error"], rounding_bound(c, tube))
    gain, u_max = _gain_and_limits(task, c, document["control"])
    if type(edge_error) is not int:
        raise Unread("the certificate has an edge error that is no whole number")
    hints = {claim["set"]: claim.get("hints") for claim in document["claims"] if claim["property"] == Property.AVOID.code}
    names, has_sampled_loop = [name for name, _ in task.unsafe], task.period is not None and not uncovered_loop_feature(task)
    return Facts(
        name=task.name,
        scalar=document["scalar"],
        design=RefinedDesign(task.t_c, tube.segments, document["grid"]["unit_bits"], tuple(tuple(row) for row in tube.table)),
        state=tuple(task.state),
        space=_edges(task.space),
        start=_edges(task.start),
        target=_edges(task.target),
        unsafe=tuple(zip(names, sets.unsafe, strict=True)),
        normals=tuple(usable_normals(shape, hints.get(name)) for name, shape in zip(names, sets.unsafe, strict=True)),
        walls=sets.walls,
        goals=sets.goals,
        clearance=task.clearance,
        min_width=task.min_width,
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
        sampling=_sampled_facts(task, c, document["sampled"], edge_error * tube.unit) if has_sampled_loop else None,
    )


def _gain_and_limits(
    task: checker.Task, c: checker.Source, control: dict[str, Any]
) -> tuple[list[Fraction], list[Fraction] | None]:
    """Return gain and u_max of the certificate's table `control`. Raises `Unread` where task or C have other ones."""
    gain = checker.fractions(control["gain"], task.n)
    u_max = None if control["u_max"] is None else checker.fractions(control["u_max"], task.n)
    has_law = not uncovered_loop_feature(task)
    if task.gain not in (None, gain) or (has_law and min(gain) <= 0):
        raise Unread("the certificate's gain is not the task's, or not positive")
    for name, values in (("gain", gain), ("u_max", u_max)):
        if has_law and values is not None and not _has_values(c, name, values):
            raise Unread(f"the C has another {name} than the certificate")
    if (u_max is None) != (task.u_max is None) or any(a > b for a, b in zip(u_max or [], task.u_max or [], strict=True)):
        raise Unread("the certificate's u_max is not the task's")
    return gain, u_max


def _has_values(c: checker.Source, name: str, values: Sequence[Fraction]) -> bool:
    """Whether the C's table `name` has these values, exact or rounded; also where it has no such table."""
    return c.tables.get(name, values) in (values, [checker.rounded(v, c.bits) for v in values])


def spline_time_error(segments: int, t_c: Fraction, scalar: str) -> Fraction:
    """Bound the error of the emitted spline time, in segments."""
    half_ulp, smallest = Fraction(1, 1 << FORMATS[scalar].bits), Fraction(1, 1 << FORMATS[scalar].underflow_exponent)
    return segments * SCALE_ROUNDINGS * half_ulp * (1 + half_ulp) + smallest * (1 + segments / t_c)


def rounding_bound(source: checker.Source, tube: checker.Tube) -> int:
    """Return P7's bound in units as proof/EmittedTube.v has it.

    It is the largest error of `basis` and `blend` in any dimension, plus the largest movement of an edge by the time's error.
    """
    time_error = spline_time_error(tube.segments, tube.t_c, source.scalar)
    by_time = [time_error * tube.fastest(i, 1) for i in range(tube.n)]
    by_kernels = [v / tube.unit - moved for v, moved in zip(checker.arithmetic(source, tube), by_time, strict=True)]
    return math.ceil(max(by_kernels) + max(by_time) + Fraction(1, 1 << 30))


def _edges(box: checker.Box) -> Edges:
    return tuple(box[0]), tuple(box[1])


def _sampled_facts(task: checker.Task, source: checker.Source, claim: dict[str, Any], edge_error: Fraction) -> SampledFacts:
    """Return the numbers of the sampled loop. claim: the certificate's table `sampled`; edge_error: no longer in units."""
    assert task.period is not None
    disturbance, g_min, g_max, g_cross = zip(*(checker.bounds(task, i) for i in range(task.n)), strict=True)
    rho, certified_shift = (tuple(checker.fractions(claim[key], task.n)) for key in ("rho", "shift"))
    noise, half_ulp = (task.plant["noise"] or [Fraction(0)])[0], Fraction(1, 1 << source.bits)
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
        law_error=Fraction(checker.LAW["inline" if task.inline else "libm"][source.bits]),
        noise=noise,
    )


def _function_body(source: checker.Source, name: str) -> checker.Tree:
    if name not in source.functions:
        raise Unread(f"the C has no {name}")
    return source.functions[name].body


def read_spline_time(source: checker.Source, n: int) -> tuple[Fraction, Fraction]:
    """Return K/t_c and the last spline time, the two constants of `segment`, whose statements have to be `SEGMENT_STATEMENTS`."""
    body, constants = _function_body(source, "segment"), {}
    matches = [re.fullmatch(pattern, str(line)) for pattern, line in zip(SEGMENT_STATEMENTS, body, strict=False)]
    if len(body) != len(SEGMENT_STATEMENTS) or None in matches:
        raise Unread("the statements of `segment` are not those of a spline's time")
    for match in matches:
        constants.update(match.groupdict() if match is not None else {})
    if constants["last"] != constants["last_again"] or constants["row_length"] != str(2 * n):
        raise Unread("`segment` holds time at another number than it compares it with, or has another length of rows")
    return source.number(constants["scale"])[1], source.number(constants["last"])[1]


class KernelReader:
    """Turns the statements of straight-line C functions into one list of numbered `Statement`s.

    Values 0 to 4 are s and the four coefficients; the k-th statement, from 1, is value 4 + k.
    """

    def __init__(self, source: checker.Source) -> None:
        self.source = source
        self.code: list[Statement] = []

    @property
    def last_value(self) -> int:
        """The number of the value that the last statement computes."""
        return 4 + len(self.code)

    def read(self, name: str, parameters: dict[str, int]) -> dict[str, int]:
        """Append the statements of the function `name`; return the numbers of what it stores and returns, by `* w0 =`, `return`.

        parameters: numbers of the values that the function takes, by name.
        """
        numbers, results = dict(parameters), dict[str, int]()
        for line in _function_body(self.source, name):
            match = KERNEL_STATEMENT.fullmatch(str(line))
            if match is None:
                destination, _, value = str(line).rpartition(" ")
                results[destination] = numbers[value]
                continue
            self.code.append((match[3], self._operand(match[2], numbers), self._operand(match[4], numbers)))
            numbers[match[1]] = self.last_value
        return results

    def _operand(self, text: str, numbers: dict[str, int]) -> Operand:
        if text in numbers:
            return "V", numbers[text]
        value = self.source.number(text)[1]
        if value.denominator != 1:
            raise Unread(f"`basis` has the constant {text}, which is not whole")
        return "C", int(value)


def read_kernels(source: checker.Source) -> tuple[Statement, ...]:
    """Return the statements of `basis` and then `blend` as one list. Raises `Unread` for other parameters or results."""
    coefficients = {f"q{j}": 1 + j for j in range(4)}
    for name, parameters in (("basis", ["s", "w0", "w1", "w2", "w3"]), ("blend", [f"{a}{j}" for a in "wq" for j in range(4)])):
        if name in source.functions and [label for _, label, _ in source.functions[name].params] != parameters:
            raise Unread(f"{name} of the C has other parameters than it should")
    reader = KernelReader(source)
    stored = reader.read("basis", {"s": 0})
    if list(stored) != [f"* w{j} =" for j in range(4)]:
        raise Unread("`basis` stores other results than it should")
    weights = {f"w{j}": stored[f"* w{j} ="] for j in range(4)}
    if reader.read("blend", coefficients | weights) != {"return": reader.last_value}:
        raise Unread("`blend` returns another value than its last")
    return tuple(reader.code)
