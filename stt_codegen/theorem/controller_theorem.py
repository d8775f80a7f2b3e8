"""`<p>.v` from the texts of the task, the header and the C: the file holds these texts, and Coq reads them. Nothing else is
believed: P7's bound, the unit of the table, and numbers that bound logarithms and widths are checked."""

from __future__ import annotations

import math
import re
import textwrap
import tomllib
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

from stt_codegen.certify import checker
from stt_codegen.errors import BadInput
from stt_codegen.program.targets.template_files import template
from stt_codegen.task import task_keys
from stt_codegen.theorem.facts import Facts, Sampling
from stt_codegen.theorem.hints import cells, hints, holds
from stt_codegen.theorem.reading import FORMATS, facts
from stt_codegen.theorem.tube_theorem import box, half_spaces, hinted, listed, rational, sampled_claim, search, shape


def quoted(text: str) -> str:
    """A Coq string. Coq knows no escape but the doubled quote, and these texts are ASCII."""
    return '"' + text.replace('"', '""') + '"'


def the_task(found: Facts) -> str:
    unsafe = ";\n   ".join(shape(convex) for _, convex in found.unsafe)
    return (
        f"(Task {found.n} {rational(found.t_c)} {listed(found.state)}\n  {box(found.space)} (* state space *)\n"
        f"  {box(found.start)} (* initial set *)\n  {box(found.target)} (* target set *)\n  [{unsafe}] (* unsafe sets *)\n"
        f"  {rational(found.clearance)} {rational(found.min_width)} (* clearance, least width *)\n"
        f"  {half_spaces(found.walls)} {half_spaces(found.goals)} (* half-spaces that cut state space and target *))%Q"
    )


@cache
def example(found: Facts) -> Sampling | None:
    """For tasks that have no period: one millisecond, inputs that act at once, xdot = u + w, |w| <= 1/20, x measured to 2^-20,
    rounding apart; from the largest share of a grid that is proved, or None."""
    n, noise = found.n, Fraction(1, 1 << 20)
    one, none, wind = (Fraction(1),) * n, (Fraction(0),) * n, (Fraction(1, 20),) * n
    shift = (short(found.error * found.unit + sensed(found, noise)),) * n
    for k in range(95, 0, -1):  # nearer to an edge logarithms are longer than proof/HeldLaw.v bounds them closely
        share = Fraction(k, 100)
        rho = ((1 + share) / (1 - share),) * n
        lost = Fraction(1, 1 << 14) if found.inline else Fraction(32, 1 << FORMATS[found.scalar][1])
        numbers = Sampling(
            period=Fraction(1, 1000),
            latency=Fraction(0),
            share=share,
            force=wind,
            g_min=one,
            g_max=one,
            g_cross=none,
            rho=rho,
            shift=shift,
            lost=lost,
            noise=noise,
        )
        if holds(found, numbers):
            return numbers
    return None


def short(value: Fraction) -> Fraction:
    """A little more than the value, so that fractions in Coq stay short."""
    return Fraction(math.ceil(value * (1 << 32)), 1 << 32)


def sensed(found: Facts, noise: Fraction) -> Fraction:
    """What a measured state is wrong by at most: the noise, and one rounding."""
    return noise + max(abs(v) for edge in found.space for v in edge) / (1 << FORMATS[found.scalar][1])


UNREAD = {  # keys of a task that proof/Toml.v does not read, by table: no theorem of the whole C is about such a task
    "": "periodic repeat start_delay region mission",
    "state_space": "vertices outline holes",
    "initial_set": "speed",
    "target_set": "vertices centre radius motion",
    "unsafe": "motion during timing spread",
    "tube": "filter adaptive",
    "control": "velocity period_min",
    "emit": "",
    "plant": "order noise_v",
}


@cache
def readable_keys() -> dict[str, set[str]]:
    """Return the keys that proof/Toml.v reads, or knows to leave what is read alone, by table."""
    keys = {table: set(names) - set(UNREAD.get(table, "").split()) for table, names in task_keys().items()}
    tables = keys.keys() - set(UNREAD[""].split())
    return {table: names - tables for table, names in keys.items() if table in tables}


CALLED, WRITTEN_OUT = "(fun _ => accurate)", "(fun called => False_ind _ (Bool.diff_true_false called))"  # of the logarithm
SPELT = re.compile(  # keys with quotes or dots are read by no one here; nor other spellings of numbers and texts
    r"['{}\\\r]|\"\"\"|\d_\d|[=\[,]\s*\+|\b0[xob]|^\s*\[\[?\s*\"|^\s*\"[^\"\n]*\"\s*[.=]|^\s*[\w-]+\s*\.[^\n=]*=", re.M
)  # in the task, what proof/Toml.v does not read
BEFORE = re.compile(rb"\\|\?\?|//|/\*/|[^\n]#|[-+&|<>=!]\s*/|([+&|>-])\s+\1|[<>=!]\s+=")  # in the C, what proof/Read.v refuses


def _foreign(task: bytes) -> str:
    """What of the task's text proof/Toml.v does not read; empty where it reads all."""
    text = re.sub(r'("(?:[^"\\\n]|\\.)*")|#[^\n]*', r"\1", task.decode())
    if SPELT.search(text):
        return "a task that is spelt so"
    given = tomllib.loads(task.decode())
    top = {k: v for k, v in given.items() if not isinstance(v, dict) and k != "unsafe"}
    tables = [
        ("", top),
        *((k, v) for k, v in given.items() if isinstance(v, dict)),
        *(("unsafe", v) for v in given.get("unsafe", [])),
    ]
    return next((f"{h}.{k}".lstrip(".") for h, table in tables for k in table if k not in readable_keys().get(h, ())), "")


def uncovered(found: Facts, *texts: bytes) -> str:
    """What of task, header or C Coq does not read, or for a task without a period why its example has no theorem; empty where
    it does."""
    task, *code = texts
    reasons = {
        found.beyond: bool(found.beyond),
        "e_max below 0.5, or nearly 1": not all((1 - e) * (1 << 29) >= 1 and e >= Fraction(1, 2) for e in found.e_max),
        "texts beyond ASCII": not all(text.isascii() for text in texts),
        "comments with signs that C reads before tokens": any(BEFORE.search(text) for text in code),
        "a guard": any(f"{found.name}_guard".encode() in text for text in code),
        "ticks of segments that have more parts than a float tells apart": (
            found.tick is not None and (found.tick * found.segments / found.t_c).denominator > 1 << 24
        ),
        "a task whose name begins a variable": any(re.search(rf" {found.name}_\w+ = ".encode(), text) for text in code),
    }
    told = next((name for name, given in reasons.items() if given), "") or _foreign(task)
    if told or found.sampling is not None or example(rounded(found)) is not None:
        return told
    return "tubes so narrow" if found.u_max is None else "tubes so narrow, or limits so low"


def rounded(found: Facts) -> Facts:
    """With gains as Coq reads them in the C: numbers of the format, near the certificate's, whose limits are such numbers."""
    return replace(found, gain=tuple(checker.rounded(v, FORMATS[found.scalar][1]) for v in found.gain))


def words(found: Facts) -> str:
    """The closed loop in words, part of the comment that begins the file; decimals are rounded to the side that says less."""
    numbers, whose = found.sampling, ""
    if numbers is None:
        numbers, whose = _example(found), ", by example: the task has no control.period, and these numbers are not its own"
    claim = sampled_claim(found, numbers, (sensed(found, numbers.noise),) * found.n)
    counted = "" if found.tick is None else f", or `{found.name}_control_tick` for its count of ticks"
    told = (
        f"The closed loop{whose}. Inputs are held: each is what `{found.name}_control` stores for the time, exact "
        f"or rounded once{counted}, and the measured state of a sample. The first is taken at 0 and acts from then on; "
        f"{claim} Unsafe sets are grown and the state space is shrunk by the body."
    )
    return textwrap.fill(told, 125, initial_indent="   ", subsequent_indent="   ")


def deep(task: bytes, header: bytes, source: bytes, certificate: bytes) -> str:
    """The text of `<p>.v` for Coq. Raises as `reading.facts` does."""
    found = rounded(facts(task, source, certificate))
    if reason := uncovered(found, task, header, source):
        raise BadInput(f"theorem: that of the C's whole text is not yet about {reason}")
    return template("controller.v.j2").render(
        name=found.name,
        loop=words(found),
        limited="" if found.u_max is None else " and u held within u_max",
        quoted_name=f"{quoted(found.name)}%string",
        toml=quoted(task.decode("ascii")),
        header=quoted(header.decode("ascii")),
        text=quoted(source.decode("ascii")),
        task=the_task(found),
        inline=found.inline,
        accuracy=WRITTEN_OUT if found.inline else CALLED,
        ticks="" if found.tick is None else rational(found.tick),
        lost="(1 # 16384)" if found.inline else f"(32 * half_ulp {FORMATS[found.scalar][0]})",
        unit=rational(found.unit),
        error=rational(found.error * found.unit),
        format=FORMATS[found.scalar][0],
        search=search(found),
        n=found.n,
        stated=found.sampling is not None,
        example="" if found.sampling is not None else "_example",
        sampled=_sampled(found, found.sampling or _example(found)),
    )


def _example(found: Facts) -> Sampling:
    numbers = example(found)
    if numbers is None:
        raise BadInput(
            "theorem: the example of a sampled loop, one millisecond, is not shown of so narrow a tube or so low limits"
        )
    return numbers


def _sampled(found: Facts, s: Sampling) -> dict[str, Any]:
    """The record `conditions` of proof/Sound.v, and what P9 takes besides, of the certificate or chosen."""
    bounds = hints(found, s)
    scalars = (s.period, s.latency, s.share, s.noise)
    return {
        "conditions": " ".join([*map(rational, scalars), *map(listed, (s.force, s.g_min, s.g_max, s.g_cross))]),
        "rho": listed(s.rho),
        "shift": listed(map(short, s.shift)),
        "hints": ";\n  ".join(f"[{row}]" for row in hinted(bounds)),
        "cells": cells(found, s, bounds),
    }
