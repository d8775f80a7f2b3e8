"""Write `<p>.v` with the theorems about a controller's whole C: it holds the texts of task, header and C, and Coq reads them.

Numbers that Coq does not read in these texts are checked by it: P7's bound, the unit of the table, and the hints of hints.py.
templates/controller.v.j2 places the text, theorem/text.py calls this.
"""

from __future__ import annotations

import math
import re
import textwrap
import tomllib
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

from stt_codegen.checker.stt_checker.exact import rounded
from stt_codegen.errors import BadInput
from stt_codegen.program.targets.template_files import template
from stt_codegen.task import task_keys
from stt_codegen.theorem.facts import Facts, SampledFacts
from stt_codegen.theorem.hints import input_hints, is_period_proved, smallest_cell_count
from stt_codegen.theorem.reading import FORMATS, read_facts
from stt_codegen.theorem.tube_theorem import (
    coq_box,
    coq_half_spaces,
    coq_hints,
    coq_list,
    coq_rational,
    coq_search,
    coq_shape,
    describe_sampled_claim,
)


def coq_string(text: str) -> str:
    """Return the text as a string of Coq, whose only escape is the doubled quote. The text has to be ASCII."""
    return '"' + text.replace('"', '""') + '"'


def coq_task(facts: Facts) -> str:
    """Return the task as a term of the record `task` of proof/Tube.v."""
    unsafe = ";\n   ".join(coq_shape(convex) for _, convex in facts.unsafe)
    return (
        f"(Task {facts.n} {coq_rational(facts.t_c)} {coq_list(facts.state)}\n  {coq_box(facts.space)} (* state space *)\n"
        f"  {coq_box(facts.start)} (* initial set *)\n  {coq_box(facts.target)} (* target set *)\n"
        f"  [{unsafe}] (* unsafe sets *)\n"
        f"  {coq_rational(facts.clearance)} {coq_rational(facts.min_width)} (* clearance, least width *)\n"
        f"  {coq_half_spaces(facts.walls)} {coq_half_spaces(facts.goals)} (* half-spaces that cut state space and target *))%Q"
    )


@cache
def find_example_sampling(facts: Facts) -> SampledFacts | None:
    """Choose numbers of a sampled loop for a task that states none: the largest start share in per cent that is proved, or None.

    Sampled every millisecond; inputs act at once; xdot = u + w with |w| <= 1/20; x is measured to 2^-20 and rounded.
    """
    n, noise = facts.n, Fraction(1, 1 << 20)
    ones, zeros = (Fraction(1),) * n, (Fraction(0),) * n
    shift = _round_up(facts.edge_error * facts.unit + measurement_error(facts, noise))
    law_error = Fraction(1, 1 << 14) if facts.has_inline_logarithm else Fraction(32, 1 << FORMATS[facts.scalar].bits)
    for percent in range(95, 0, -1):  # nearer to an edge, proof/HeldInputLaw.v does not bound the logarithm closely enough
        share = Fraction(percent, 100)
        numbers = SampledFacts(
            period=Fraction(1, 1000),
            latency=Fraction(0),
            share=share,
            disturbance=(Fraction(1, 20),) * n,
            g_min=ones,
            g_max=ones,
            g_cross=zeros,
            rho=((1 + share) / (1 - share),) * n,
            shift=(shift,) * n,
            law_error=law_error,
            noise=noise,
        )
        if is_period_proved(facts, numbers):
            return numbers
    return None


def _round_up(value: Fraction) -> Fraction:
    """Round up to a multiple of 2^-32, so that fractions in Coq stay short."""
    return Fraction(math.ceil(value * (1 << 32)), 1 << 32)


def measurement_error(facts: Facts, noise: Fraction) -> Fraction:
    """Bound the error of a measured state: the noise, and one rounding."""
    return noise + max(abs(v) for edge in facts.space for v in edge) / (1 << FORMATS[facts.scalar].bits)


# Keys of a task that proof/Toml.v does not read, by table: no theorem of the whole C is about a task that has one.
UNREAD_KEYS = {
    "": "periodic repeat start_delay region mission",
    "state_space": "vertices outline holes",
    "initial_set": "speed",
    "target_set": "vertices centre radius motion",
    "unsafe": "motion during timing spread",
    "tube": "filter adaptive",
    "control": "velocity period_min rest reserve u_norm",
    "emit": "",
    "plant": "order noise_v lag lag2 slew overshoot exact",
}


@cache
def readable_keys() -> dict[str, set[str]]:
    """Return by table the keys that proof/Toml.v reads, or passes over because they change no number that it reads."""
    keys = {table: set(names) - set(UNREAD_KEYS.get(table, "").split()) for table, names in task_keys().items()}
    tables = keys.keys() - set(UNREAD_KEYS[""].split())
    return {table: names - tables for table, names in keys.items() if table in tables}


# Proofs, in Coq's terms, of how accurate the logarithm is: of a called one by assumption; an inline one is no call.
LIBRARY_LOGARITHM_ACCURACY = "(fun _ => accurate)"
INLINE_LOGARITHM_ACCURACY = "(fun called => False_ind _ (Bool.diff_true_false called))"
# TOML that proof/Toml.v does not read: quoted or dotted keys, and rare forms of numbers and strings.
UNREAD_SPELLING = re.compile(
    r"['{}\\\r]|\"\"\"|\d_\d|[=\[,]\s*\+|\b0[xob]|^\s*\[\[?\s*\"|^\s*\"[^\"\n]*\"\s*[.=]|^\s*[\w-]+\s*\.[^\n=]*=", re.M
)
# C that proof/Read.v refuses: backslashes, trigraphs, directives inside a line; and where there is no directive, operators that
# could be read as one token.
UNREAD_IN_C = re.compile(rb"\\|\?\?|//|/\*/|[^\n]#")
UNREAD_SIGNS = re.compile(rb"[-+&|<>=!]\s*/|([+&|>-])\s+\1|[<>=!]\s+=")
DIRECTIVE = re.compile(rb"^#.*", re.M)


def _unread_part(task: bytes) -> str:
    """Name the first key or spelling of the task's text that proof/Toml.v does not read; empty where it reads all."""
    without_comments = re.sub(r'("(?:[^"\\\n]|\\.)*")|#[^\n]*', r"\1", task.decode())
    if UNREAD_SPELLING.search(without_comments):
        return "a task that is spelt so"
    document = tomllib.loads(task.decode())
    tables = [
        ("", {k: v for k, v in document.items() if not isinstance(v, dict) and k != "unsafe"}),
        *((k, v) for k, v in document.items() if isinstance(v, dict)),
        *(("unsafe", v) for v in document.get("unsafe", [])),
    ]
    unread_keys = (f"{name}.{k}".lstrip(".") for name, table in tables for k in table if k not in readable_keys().get(name, ()))
    return next(unread_keys, "")


def reason_not_covered(facts: Facts, task: bytes, header: bytes, source: bytes) -> str:
    """Name what of the three texts Coq does not read, or why the example of a task without a period is not proved.

    Empty where the theorems can be about the whole C.
    """
    code = (header, source)
    reasons = {
        facts.uncovered_loop_feature: bool(facts.uncovered_loop_feature),
        "e_max below 0.5, or nearly 1": not all((1 - e) * (1 << 29) >= 1 and e >= Fraction(1, 2) for e in facts.e_max),
        "texts beyond ASCII": not all(text.isascii() for text in (task, *code)),
        "comments with signs that C reads before tokens": any(
            UNREAD_IN_C.search(text) or UNREAD_SIGNS.search(DIRECTIVE.sub(b"", text)) for text in code
        ),
        "a guard": any(f"{facts.name}_guard".encode() in text for text in code),
        "ticks of segments that have more parts than a float tells apart": (
            facts.tick_period is not None and (facts.tick_period * facts.segments / facts.t_c).denominator > 1 << 24
        ),
        "a task whose name begins a variable": any(re.search(rf" {facts.name}_\w+ = ".encode(), text) for text in code),
    }
    reason = next((reason for reason, applies in reasons.items() if applies), "") or _unread_part(task)
    if reason or facts.sampling is not None or find_example_sampling(with_rounded_gain(facts)) is not None:
        return reason
    return "tubes so narrow" if facts.u_max is None else "tubes so narrow, or limits so low"


def with_rounded_gain(facts: Facts) -> Facts:
    """Return the facts with the gain that Coq reads in the C, rounded to the format. The C's limits are rounded already."""
    return replace(facts, gain=tuple(rounded(v, FORMATS[facts.scalar].bits) for v in facts.gain))


def describe_closed_loop(facts: Facts) -> str:
    """Describe the theorem of the closed loop for the comment that begins the file.

    Decimals are rounded towards the weaker statement.
    """
    numbers, origin = facts.sampling, ""
    if numbers is None:
        numbers = _proved_example(facts)
        origin = ", by example: the task has no control.period, and these numbers are not its own"
    claim = describe_sampled_claim(facts, numbers, (measurement_error(facts, numbers.noise),) * facts.n)
    by_ticks = "" if facts.tick_period is None else f", or `{facts.name}_control_tick` for its count of ticks"
    description = (
        f"The closed loop{origin}. Inputs are held: each is what `{facts.name}_control` stores for the time, exact "
        f"or rounded once{by_ticks}, and the measured state of a sample. The first is taken at 0 and acts from then on; "
        f"{claim} Unsafe sets are grown and the state space is shrunk by the body."
    )
    return textwrap.fill(description, 125, initial_indent="   ", subsequent_indent="   ")


def controller_theorem_text(task: bytes, header: bytes, source: bytes, certificate: bytes) -> str:
    """Return the text of `<p>.v`. Raises as `read_facts` does, and `BadInput` where Coq does not read one of the texts."""
    facts = with_rounded_gain(read_facts(task, source, certificate))
    if reason := reason_not_covered(facts, task, header, source):
        raise BadInput(f"theorem: that of the C's whole text is not yet about {reason}")
    return template("controller.v.j2").render(
        name=facts.name,
        loop_description=describe_closed_loop(facts),
        limits="" if facts.u_max is None else " and u held within u_max",
        quoted_name=f"{coq_string(facts.name)}%string",
        toml=coq_string(task.decode("ascii")),
        header=coq_string(header.decode("ascii")),
        text=coq_string(source.decode("ascii")),
        task=coq_task(facts),
        has_inline_logarithm=facts.has_inline_logarithm,
        logarithm_accuracy=INLINE_LOGARITHM_ACCURACY if facts.has_inline_logarithm else LIBRARY_LOGARITHM_ACCURACY,
        tick_period="" if facts.tick_period is None else coq_rational(facts.tick_period),
        law_error="(1 # 16384)" if facts.has_inline_logarithm else f"(32 * half_ulp {FORMATS[facts.scalar].coq_name})",
        unit=coq_rational(facts.unit),
        edge_error=coq_rational(facts.edge_error * facts.unit),
        format=FORMATS[facts.scalar].coq_name,
        search=coq_search(facts),
        n=facts.n,
        has_period=facts.sampling is not None,
        example_suffix="" if facts.sampling is not None else "_example",
        sampled=_sampled_template_values(facts, facts.sampling or _proved_example(facts)),
    )


def _proved_example(facts: Facts) -> SampledFacts:
    """Return the numbers of `find_example_sampling`. Raises `BadInput` where none are proved."""
    numbers = find_example_sampling(facts)
    if numbers is None:
        raise BadInput(
            "theorem: the example of a sampled loop, one millisecond, is not shown of so narrow a tube or so low limits"
        )
    return numbers


def _sampled_template_values(facts: Facts, sampling: SampledFacts) -> dict[str, Any]:
    """Return what the template needs of the sampled loop: `conditions` of proof/Sound.v, and P9's rho, shift and hints."""
    input_bounds = input_hints(facts, sampling)
    scalars = (sampling.period, sampling.latency, sampling.share, sampling.noise)
    by_component = (sampling.disturbance, sampling.g_min, sampling.g_max, sampling.g_cross)
    return {
        "conditions": " ".join([*map(coq_rational, scalars), *map(coq_list, by_component)]),
        "rho": coq_list(sampling.rho),
        "shift": coq_list(map(_round_up, sampling.shift)),
        "hints": ";\n  ".join(f"[{row}]" for row in coq_hints(input_bounds)),
        "cells": smallest_cell_count(facts, sampling, input_bounds),
    }
