"""`<p>.v`: the theorems of one controller in words and for Coq. templates/theorem.v.j2 places the text."""

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
from stt_codegen.theorem.facts import Facts, Sampling, Statement
from stt_codegen.theorem.hints import Hint, cells, hints
from stt_codegen.theorem.reading import FORMATS, lateness
from stt_codegen.theorem.unsafe_sets import Edges, Face, Point, Shape, solid

DEPTH = 20  # times that a segment may be halved
SIGNS = {"+": "Add", "-": "Sub", "*": "Mul"}


def rational(value: Fraction) -> str:
    sign = f"({value.numerator})" if value < 0 else str(value.numerator)
    return f"({sign} # {value.denominator})"


def listed(values: Iterable[Fraction]) -> str:
    return f"[{'; '.join(rational(v) for v in values)}]"


def box(edges: Edges) -> str:
    return f"(Box {listed(edges[0])} {listed(edges[1])})"


def points(values: Iterable[Point]) -> str:
    return f"[{'; '.join(map(listed, values))}]"


def half_spaces(faces: Iterable[Face]) -> str:
    return f"[{'; '.join(f'({listed(face)}, {rational(offset)})' for face, offset in faces)}]"


def shape(convex: Shape) -> str:
    """An unsafe set, as proof/Sets.v has it."""
    if solid(convex):
        return f"(solid {box(convex.extent)})"
    core = f"(Cut {box(convex.room)} {half_spaces(convex.faces)})" if convex.faces else f"(Hull {points(convex.points)})"
    ball = "; ".join(map(str, convex.own if convex.radius else ()))
    return f"(Shape {core} {box(convex.extent)} [{ball}]%nat {rational(convex.radius)})"


def search(facts: Facts) -> str:
    """How Coq goes about P1 to P5: nothing in it is believed."""
    sets = ["; ".join(f"([{'; '.join(map(whole, v))}]%Z, {listed(m)}%Q)" for v, m in own) for own in facts.normals]
    return f"Search {DEPTH} [{'; '.join(f'[{own}]' for own in sets)}]"


def whole(value: int) -> str:
    return f"({value})" if value < 0 else str(value)


def real(value: Fraction) -> str:
    return f"{whole(value.numerator)} / {value.denominator}"


def dyadic(value: Fraction) -> str:
    """Mantissa and exponent of a number of the scalar."""
    mantissa, exponent = value.numerator, 1 - value.denominator.bit_length()
    while mantissa and mantissa % 2 == 0:
        mantissa, exponent = mantissa // 2, exponent + 1
    return f"{whole(mantissa)} {whole(exponent)}"


def statement(said: Statement) -> str:
    sign, *operands = said
    return f"Stmt {SIGNS[sign]} {' '.join(f'({kind} {whole(value)})' for kind, value in operands)}"


def words(facts: Facts, reason: str) -> str:
    """The theorems in words, as the comment that begins the file. reason: why none is about the whole C."""
    t_c, clear = exact(facts.t_c), exact(facts.clearance)
    told = [
        f"1. The emitted tube. Let L and U be the edges that `{facts.name}_tube` computes in {facts.scalar} arithmetic (round to "
        f"nearest even) at a time t in seconds, t exact or rounded once to {facts.scalar}. Then for every t: U is at least "
        f"{exact(facts.min_width)} above L; L and U are in the state space; every unsafe set is behind them along a "
        f"normal, by so much that every point between them is at least {clear} away, in some dimension, from every point of the "
        "set. At t = 0 they are in the initial set, and the initial state is between them. From t = "
        f"{t_c} s on they are in the target set.",
    ]
    if reason and reason != facts.beyond:
        told.insert(0, f"These are about the tube: there is no theorem yet about the whole C with {reason}.")
    if facts.beyond:
        told.append(f"There is no theorem yet about the closed loop with {facts.beyond}.")
    else:
        told.append(
            "2. The closed loop in continuous time. Take any plant xdot_i = f_i + g_i u_i, i = 1 .. n, whose |f_i| (drift and "
            "disturbance) is bounded along the trajectory, and whose g_i is at least some positive number; neither bound need "
            "be known. Let u be the law (13) of the exact tube, without limits and without rounding, with the gain of the "
            f"certificate. Then every trajectory that begins strictly inside the tube is, until t = {t_c} s, in the state space, "
            f"and the clearance away from every unsafe set; at t = {t_c} s it is in the target set."
        )
    if facts.sampling is not None:
        told.append(_sampled_words(facts, facts.sampling))
    told += [
        "Unsafe sets are grown and the state space is shrunk by the body. "
        f"Unsafe sets: {', '.join(_plain(name) for name, _ in facts.unsafe) or 'none'}.",
        "What connects these with the C: the table, the constants of time, and the statements of `basis` and `blend` are those "
        "of the C text, found by the stand-alone checker's reader; that `segment`, loops and indices use them so"
        f"{'' if facts.beyond else ', and that the law is this one and loses no more,'} is the checker's word. What is taken "
        "from the task was written out by Python. Assumed: IEEE-754 arithmetic without contraction, and that no number "
        "overflows.",
    ]
    if facts.tick is not None:
        told.append("Times in ticks are not meant: statement 1 is about the function that takes seconds.")
    return "\n\n".join(textwrap.fill(t, 125, initial_indent="   ", subsequent_indent="   ") for t in told)


def _sampled_words(facts: Facts, sampling: Sampling) -> str:
    """The third theorem; decimals are rounded to the side on which less is said."""
    lost, limits = (
        Fraction(str(below(sampling.lost))),
        "without limits" if facts.u_max is None else f"limited to {_each(facts.u_max)}",
    )
    claim = sampled_claim(facts, sampling, tuple(v - facts.error * facts.unit for v in sampling.shift))
    return (
        "3. The sampled loop. Inputs are held. Input p is made of a sample of x, and of the emitted edges at its time, by the "
        f"law (13) with e clamped to {_each(facts.e_max)}, {limits}, and with errors of {exact(lost)} in relative "
        f"terms and in the logarithm. The first sample is taken at 0 and acts from then on; {claim}"
    )


def sampled_claim(facts: Facts, sampling: Sampling, sensors: Sequence[Fraction]) -> str:
    """What is assumed of samples, sensors and plant, and what is shown of every trajectory."""
    wrong = [Fraction(str(below(v))) for v in sensors]
    reach = [Fraction(str(above((rho - 1) / (rho + 1)))) for rho in sampling.rho]
    cross = f"|g_ij| at most {_each(sampling.g_cross)}" if any(sampling.g_cross) else "g_ij = 0"
    age, late = sampling.period + sampling.latency, sampling.latency
    return (
        "an input acts at most "
        f"{exact(late)} s after its sample for the first time, and never when that is older than {exact(age)} s. What is "
        f"measured is wrong by at most {_each(wrong)}. Take any plant xdot_i = f_i + sum over j of g_ij u_j with |f_i| (drift "
        f"and disturbance) at most {_each(sampling.force)}, g_ii from {_each(sampling.g_min)} to {_each(sampling.g_max)}, "
        f"{cross} for other j. Then every trajectory from every start with |e| at most {exact(sampling.share)} keeps |e| at "
        f"most {_each(reach)} for as long as there are inputs, e being that of the exact tube; it is in the state space and the "
        f"clearance away from every unsafe set, and from t = {exact(facts.t_c)} s on in the target set."
    )


def hinted(rows: Sequence[Sequence[Hint]]) -> list[str]:
    """Bounds on |u| and on the logarithm in it, one line a window."""
    return ["; ".join(f"({rational(u)}, {rational(log)})" for u, log in row) for row in rows]


def _each(values: Sequence[Fraction]) -> str:
    """Of every component, once where all are the same."""
    said = list(dict.fromkeys(exact(v) for v in values))
    return said[0] if len(said) == 1 else f"({', '.join(exact(v) for v in values)})"


def _plain(name: str) -> str:
    """A name of the task as part of a comment: Coq reads strings and comments within comments."""
    return re.sub(r"[^\w .,-]", "_", name, flags=re.ASCII)


def _sampled(facts: Facts, sampling: Sampling) -> dict[str, Any]:
    """The numbers of the third theorem."""
    components, rows = [], hints(facts, sampling)
    for i in range(facts.n):
        limit = "None" if facts.u_max is None else f"(Some {rational(facts.u_max[i])})"
        first = [rational(facts.gain[i]), rational((1 - facts.e_max[i]) / 2), limit]
        rest = (sampling.rho, sampling.force, sampling.g_min, sampling.g_max, sampling.g_cross, sampling.shift)
        components.append(f"Component {' '.join([*first, *(rational(values[i]) for values in rest)])}")
    return {
        "tau": rational(sampling.period + sampling.latency),
        "latency": rational(sampling.latency),
        "share": rational(sampling.share),
        "lost": rational(sampling.lost),
        "components": components,
        "hints": hinted(rows),
        "cells": cells(facts, sampling, rows),
    }


def written(facts: Facts, reason: str = "") -> bytes:
    """The text of `<p>.v`. reason: why there is no theorem about the whole C."""
    late = lateness(facts.segments, facts.t_c, facts.scalar)
    text = template("theorem.v.j2").render(
        name=facts.name,
        words=words(facts, reason),
        n=facts.n,
        t_c=rational(facts.t_c),
        state=listed(facts.state),
        space=box(facts.space),
        start=box(facts.start),
        target=box(facts.target),
        unsafe=[{"name": _plain(name), "shape": shape(convex)} for name, convex in facts.unsafe],
        search=search(facts),
        walls=half_spaces(facts.walls),
        goals=half_spaces(facts.goals),
        clearance=rational(facts.clearance),
        min_width=rational(facts.min_width),
        bits=facts.design.bits,
        unit=rational(facts.unit),
        table=["; ".join(f"({whole(a)}, {whole(b)})" for a, b in row) for row in facts.table],
        code=[statement(said) for said in facts.code],
        scale=f"{dyadic(facts.rate)} {dyadic(facts.last)}",
        error=rational(facts.error * facts.unit),
        steps=f"[{'; '.join(whole(int(v)) for v in facts.design.largest_steps().max(axis=0))}]",
        late=rational(Fraction(math.ceil(late * 2**90), 2**90)),
        format=FORMATS[facts.scalar][0],
        gain="; ".join(real(k) for k in facts.gain),
        sampled=None if facts.sampling is None else _sampled(facts, facts.sampling),
        beyond=facts.beyond,
        theorems="emitted_tube"
        if facts.beyond
        else "emitted_tube, continuous_loop" + (", sampled_loop" if facts.sampling is not None else ""),
    )
    return text.encode()
