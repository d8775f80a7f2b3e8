"""Write `<p>.v` with the theorems about a controller's tube, in words and in Coq's terms.

templates/theorem.v.j2 places the text; theorem/text.py calls this where Coq cannot read the whole C. The functions coq_* write
one value as a term of Coq; proof/Tube.v and proof/Sets.v define the records.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from stt_codegen.decimals import above, below
from stt_codegen.decimals import exact_decimal as exact
from stt_codegen.program.targets.template_files import template
from stt_codegen.theorem.facts import Facts, SampledFacts, Statement
from stt_codegen.theorem.hints import Hint, input_hints, smallest_cell_count
from stt_codegen.theorem.reading import FORMATS, spline_time_error
from stt_codegen.theorem.unsafe_sets import Edges, HalfSpace, Point, Shape, is_box

SEARCH_DEPTH = 20  # times that Coq may halve a segment
OPERATION_NAMES = {"+": "Add", "-": "Sub", "*": "Mul"}


def coq_rational(value: Fraction) -> str:
    sign = f"({value.numerator})" if value < 0 else str(value.numerator)
    return f"({sign} # {value.denominator})"


def coq_list(values: Iterable[Fraction]) -> str:
    return f"[{'; '.join(coq_rational(v) for v in values)}]"


def coq_box(edges: Edges) -> str:
    return f"(Box {coq_list(edges[0])} {coq_list(edges[1])})"


def coq_points(values: Iterable[Point]) -> str:
    return f"[{'; '.join(map(coq_list, values))}]"


def coq_half_spaces(half_spaces: Iterable[HalfSpace]) -> str:
    return f"[{'; '.join(f'({coq_list(normal)}, {coq_rational(offset)})' for normal, offset in half_spaces)}]"


def coq_shape(unsafe: Shape) -> str:
    """Return an unsafe set as proof/Sets.v has it: a box alone is `shape_of_box`, all other sets are a `Shape`."""
    if is_box(unsafe):
        return f"(shape_of_box {coq_box(unsafe.box_about_points)})"
    core = f"(Hull {coq_points(unsafe.points)})"
    if unsafe.half_spaces:
        core = f"(Cut {coq_box(unsafe.core_box)} {coq_half_spaces(unsafe.half_spaces)})"
    ball_axes = "; ".join(map(str, unsafe.axes if unsafe.radius else ()))
    return f"(Shape {core} {coq_box(unsafe.box_about_points)} [{ball_axes}]%nat {coq_rational(unsafe.radius)})"


def coq_search(facts: Facts) -> str:
    """Return the hints for Coq's search of proofs of P1 to P5: its depth, and for each unsafe set normals with multipliers."""
    sets = [
        "; ".join(f"([{'; '.join(map(coq_integer, normal))}]%Z, {coq_list(multipliers)}%Q)" for normal, multipliers in normals)
        for normals in facts.normals
    ]
    return f"SearchPlan {SEARCH_DEPTH} [{'; '.join(f'[{normals}]' for normals in sets)}]"


def coq_integer(value: int) -> str:
    return f"({value})" if value < 0 else str(value)


def coq_real(value: Fraction) -> str:
    return f"{coq_integer(value.numerator)} / {value.denominator}"


def coq_dyadic(value: Fraction) -> str:
    """Return the odd integer mantissa and the exponent of a floating-point number, which are m and e of m 2^e."""
    mantissa, exponent = value.numerator, 1 - value.denominator.bit_length()
    while mantissa and mantissa % 2 == 0:
        mantissa, exponent = mantissa // 2, exponent + 1
    return f"{coq_integer(mantissa)} {coq_integer(exponent)}"


def coq_statement(statement: Statement) -> str:
    sign, *operands = statement
    return f"Assignment {OPERATION_NAMES[sign]} {' '.join(f'({kind} {coq_integer(value)})' for kind, value in operands)}"


def describe_theorems(facts: Facts, reason: str) -> str:
    """Describe the theorems for the comment that begins the file. reason: why none is about the whole C."""
    paragraphs = [_describe_tube(facts)]
    if reason and reason != facts.uncovered_loop_feature:
        paragraphs.insert(0, f"These are about the tube: there is no theorem yet about the whole C with {reason}.")
    if facts.uncovered_loop_feature:
        paragraphs.append(f"There is no theorem yet about the closed loop with {facts.uncovered_loop_feature}.")
    else:
        paragraphs.append(_describe_continuous_loop(facts))
    if facts.sampling is not None:
        paragraphs.append(_describe_sampled_loop(facts, facts.sampling))
    paragraphs += [
        "Unsafe sets are grown and the state space is shrunk by the body. "
        f"Unsafe sets: {', '.join(_comment_safe_name(name) for name, _ in facts.unsafe) or 'none'}.",
        _describe_connection(facts),
    ]
    if facts.tick_period is not None:
        paragraphs.append("Times in ticks are not meant: statement 1 is about the function that takes seconds.")
    return "\n\n".join(textwrap.fill(t, 125, initial_indent="   ", subsequent_indent="   ") for t in paragraphs)


def _describe_tube(facts: Facts) -> str:
    """Describe the theorem `emitted_tube`."""
    return (
        f"1. The emitted tube. Let L and U be the edges that `{facts.name}_tube` computes in {facts.scalar} arithmetic (round to "
        f"nearest even) at a time t in seconds, t exact or rounded once to {facts.scalar}. Then for every t: U is at least "
        f"{exact(facts.min_width)} above L; L and U are in the state space; every unsafe set is behind them along a "
        f"normal, by so much that every point between them is at least {exact(facts.clearance)} away, in some dimension, from "
        "every point of the set. At t = 0 they are in the initial set, and the initial state is between them. From t = "
        f"{exact(facts.t_c)} s on they are in the target set."
    )


def _describe_continuous_loop(facts: Facts) -> str:
    """Describe the theorem `continuous_loop`."""
    t_c = exact(facts.t_c)
    return (
        "2. The closed loop in continuous time. Take any plant xdot_i = f_i + g_i u_i, i = 1 .. n, whose |f_i| (drift and "
        "disturbance) is bounded along the trajectory, and whose g_i is at least some positive number; neither bound need "
        "be known. Let u be the law (13) of the exact tube, without limits and without rounding, with the gain of the "
        f"certificate. Then every trajectory that begins strictly inside the tube is, until t = {t_c} s, in the state space, "
        f"and the clearance away from every unsafe set; at t = {t_c} s it is in the target set."
    )


def _describe_connection(facts: Facts) -> str:
    """Describe what connects the theorems with the C, and what is assumed."""
    law = "" if facts.uncovered_loop_feature else ", and that the law is this one and loses no more,"
    return (
        "What connects these with the C: the table, the constants of time, and the statements of `basis` and `edge_at` are those "
        f"of the C text, found by Python; that loops and indices use them so{law} is the stand-alone checker's word, which "
        "requires that the C is its listing. What is taken from the task was written out by Python. Assumed: IEEE-754 arithmetic "
        "without contraction, and that no number overflows."
    )


def _describe_sampled_loop(facts: Facts, sampling: SampledFacts) -> str:
    """Describe the theorem `sampled_loop`; decimals are rounded towards the weaker statement."""
    law_error = Fraction(str(below(sampling.law_error)))
    limits = "without limits" if facts.u_max is None else f"limited to {_decimals(facts.u_max)}"
    sensor_errors = tuple(shift - facts.edge_error * facts.unit for shift in sampling.shift)
    claim = describe_sampled_claim(facts, sampling, sensor_errors)
    return (
        "3. The sampled loop. Inputs are held. Input p is made of a sample of x, and of the emitted edges at its time, by the "
        f"law (13) with e clamped to {_decimals(facts.e_max)}, {limits}, and with errors of {exact(law_error)} in relative "
        f"terms and in the logarithm. The first sample is taken at 0 and acts from then on; {claim}"
    )


def describe_sampled_claim(facts: Facts, sampling: SampledFacts, sensor_errors: Sequence[Fraction]) -> str:
    """Describe what is assumed of samples, sensors and plant, and what is proved of every trajectory."""
    errors = [Fraction(str(below(v))) for v in sensor_errors]
    largest_e = [Fraction(str(above((rho - 1) / (rho + 1)))) for rho in sampling.rho]
    cross = f"|g_ij| at most {_decimals(sampling.g_cross)}" if any(sampling.g_cross) else "g_ij = 0"
    age = exact(sampling.period + sampling.latency)
    return (
        f"an input acts at most {exact(sampling.latency)} s after its sample for the first time, and never when that is older "
        f"than {age} s. What is measured is wrong by at most {_decimals(errors)}. Take any plant xdot_i = f_i + sum over j of "
        f"g_ij u_j with |f_i| (drift and disturbance) at most {_decimals(sampling.disturbance)}, "
        f"g_ii from {_decimals(sampling.g_min)} to {_decimals(sampling.g_max)}, {cross} for other j. "
        f"Then every trajectory from every start with |e| at most {exact(sampling.share)} keeps |e| at most "
        f"{_decimals(largest_e)} for as long as there are inputs, e being that of the exact tube; it is in the state space "
        f"and the clearance away from every unsafe set, and from t = {exact(facts.t_c)} s on in the target set."
    )


def coq_hints(rows: Sequence[Sequence[Hint]]) -> list[str]:
    """Return the bounds on |u| and on the logarithm in it, one line for each window."""
    return ["; ".join(f"({coq_rational(u)}, {coq_rational(log)})" for u, log in row) for row in rows]


def _decimals(values: Sequence[Fraction]) -> str:
    """Return one decimal where all components are equal, else (a, b, ..)."""
    distinct = list(dict.fromkeys(exact(v) for v in values))
    return distinct[0] if len(distinct) == 1 else f"({', '.join(exact(v) for v in values)})"


def _comment_safe_name(name: str) -> str:
    """Return a name of the task that can stand in a comment: Coq reads quotes and comment signs there too."""
    return re.sub(r"[^\w .,-]", "_", name, flags=re.ASCII)


def _sampled_template_values(facts: Facts, sampling: SampledFacts) -> dict[str, Any]:
    """Return what the template needs for the theorem `sampled_loop`."""
    components, rows = [], input_hints(facts, sampling)
    for i in range(facts.n):
        limit = "None" if facts.u_max is None else f"(Some {coq_rational(facts.u_max[i])})"
        law = [coq_rational(facts.gain[i]), coq_rational((1 - facts.e_max[i]) / 2), limit]
        plant = (sampling.rho, sampling.disturbance, sampling.g_min, sampling.g_max, sampling.g_cross, sampling.shift)
        components.append(f"Component {' '.join([*law, *(coq_rational(values[i]) for values in plant)])}")
    return {
        "tau": coq_rational(sampling.period + sampling.latency),
        "latency": coq_rational(sampling.latency),
        "share": coq_rational(sampling.share),
        "law_error": coq_rational(sampling.law_error),
        "components": components,
        "hints": coq_hints(rows),
        "cells": smallest_cell_count(facts, sampling, rows),
    }


def tube_theorem_text(facts: Facts, reason: str = "") -> bytes:
    """Return the text of `<p>.v`. reason: why there is no theorem about the whole C."""
    time_error = spline_time_error(facts.segments, facts.t_c, facts.scalar)
    text = template("theorem.v.j2").render(
        name=facts.name,
        description=describe_theorems(facts, reason),
        n=facts.n,
        t_c=coq_rational(facts.t_c),
        state=coq_list(facts.state),
        space=coq_box(facts.space),
        start=coq_box(facts.start),
        target=coq_box(facts.target),
        unsafe=[{"name": _comment_safe_name(name), "shape": coq_shape(unsafe)} for name, unsafe in facts.unsafe],
        search=coq_search(facts),
        walls=coq_half_spaces(facts.walls),
        goals=coq_half_spaces(facts.goals),
        clearance=coq_rational(facts.clearance),
        min_width=coq_rational(facts.min_width),
        bits=facts.design.bits,
        unit=coq_rational(facts.unit),
        table=["; ".join(f"({coq_integer(a)}, {coq_integer(b)})" for a, b in row) for row in facts.table],
        code=[coq_statement(line) for line in facts.code],
        scale=f"{coq_dyadic(facts.time_scale)} {coq_dyadic(facts.last_spline_time)}",
        edge_error=coq_rational(facts.edge_error * facts.unit),
        steps=f"[{'; '.join(coq_integer(int(v)) for v in facts.design.largest_steps().max(axis=0))}]",
        spline_time_error=coq_rational(Fraction(math.ceil(time_error * 2**90), 2**90)),
        format=FORMATS[facts.scalar].coq_name,
        gain="; ".join(coq_real(k) for k in facts.gain),
        sampled=None if facts.sampling is None else _sampled_template_values(facts, facts.sampling),
        uncovered_loop_feature=facts.uncovered_loop_feature,
        theorem_names=_theorem_names(facts),
    )
    return text.encode()


def _theorem_names(facts: Facts) -> str:
    if facts.uncovered_loop_feature:
        return "emitted_tube"
    return "emitted_tube, continuous_loop" + (", sampled_loop" if facts.sampling is not None else "")
