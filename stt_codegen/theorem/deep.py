"""`<p>.v` from the texts of the task, the header and the C: the file holds these texts, and Coq reads them. Nothing else is
believed: P7's bound, the unit of the table, and numbers that bound logarithms and widths are checked."""

from __future__ import annotations

import math
import re
import textwrap
import tomllib
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from stt_codegen.certify import checker
from stt_codegen.decimals import below
from stt_codegen.decimals import exact_decimal as exact
from stt_codegen.emit.render import template
from stt_codegen.errors import BadInput
from stt_codegen.theorem.hints import cells, hints, steps, widths
from stt_codegen.theorem.reading import Facts, Sampling, facts
from stt_codegen.theorem.writing import DEPTH, FORMATS, box, listed, rational, sampled_claim

GRID = 1 << 24  # logarithms, widths and shares are multiples of 1/GRID
SLACK = 4096  # how far the bound of a logarithm is from it, in these: Coq's enclosure of exp is not exact


def quoted(text: str) -> str:
    """A Coq string. Coq knows no escape but the doubled quote, and these texts are ASCII."""
    return '"' + text.replace('"', '""') + '"'


def the_task(found: Facts) -> str:
    unsafe = ";\n   ".join(box(edges) for _, edges in found.unsafe)
    return (
        f"(Task {found.n} {rational(found.t_c)} {listed(found.state)}\n  {box(found.space)} (* state space *)\n"
        f"  {box(found.start)} (* initial set *)\n  {box(found.target)} (* target set *)\n  [{unsafe}] (* unsafe sets *)\n"
        f"  {rational(found.clearance)} {rational(found.min_width)} (* clearance, least width *))%Q"
    )


@dataclass(frozen=True)
class Bounds:
    """What is known of the plant, by component: force is drift and disturbance, cross what other inputs pull, a share of each."""

    force: list[Fraction]
    g_min: list[Fraction]
    g_max: list[Fraction]
    cross: list[Fraction]
    tau: Fraction  # no acting sample is older
    latency: Fraction
    noise: Fraction


@dataclass(frozen=True)
class Plant:
    """The record `plant` of proof/Uniform.v."""

    bounds: Bounds
    rho: list[Fraction]
    narrowest: list[Fraction]
    widest: list[Fraction]
    log_up: list[Fraction]
    log_down: list[Fraction]

    def __str__(self) -> str:
        b = self.bounds
        rows = [self.rho, b.g_min, b.g_max, b.force, b.cross]
        scalars = " ".join(map(rational, (b.tau, b.latency, b.noise)))
        rest = [self.narrowest, self.widest, self.log_up, self.log_down]
        return f"(Plant {' '.join(map(listed, rows))}\n  {scalars}\n  {' '.join(map(listed, rest))})%Q"


def plant(found: Facts, bounds: Bounds, rho: Fraction) -> Plant | None:
    """Numbers with which `plant_check` holds for this rho, or None: the same formulas as in proof/Uniform.v."""
    r = Fraction(1, 1 << 14) if found.inline else 32 * Fraction(1, 1 << FORMATS[found.scalar][1])
    eta = found.error * found.unit + bounds.noise
    spans = [widths(found, i) for i in range(found.n)]
    narrowest, widest = ([pick(v[k] for v in own) for own in spans] for k, pick in enumerate((min, max)))
    z = 1 / (1 + rho)
    most, log_up, log_down = [], [], []
    for i in range(found.n):
        least = narrowest[i] * z - eta
        if least <= 0:
            return None
        y = (narrowest[i] * (1 - z) + eta) / least
        log_up.append(Fraction(math.ceil(math.log(y) * GRID) + SLACK, GRID))
        most.append(found.gain[i] / least * (1 + 1 / y) * (1 + r) * (log_up[i] + r))
    for i in range(found.n):
        v = found.unit * 3 * steps(found)[i] * Fraction(found.segments) / found.t_c
        force = bounds.force[i] + bounds.cross[i] * sum(most[j] for j in range(found.n) if j != i)
        drift = (force + v) * bounds.tau + bounds.g_max[i] * most[i] * bounds.latency
        y = (narrowest[i] * (1 - z) - drift - eta) / (narrowest[i] * z + drift + eta)
        if y <= 1:
            return None
        log_down.append(Fraction(math.floor(math.log(y) * GRID) - SLACK, GRID))
        side = narrowest[i] * (rho - 1) / (rho + 1) - 2 * (force + v + bounds.g_max[i] * most[i]) * bounds.tau
        pull = bounds.g_min[i] * found.gain[i] / (widest[i] * z + drift + eta) * (1 + 1 / y) * (1 - r) * (log_down[i] - r)
        if found.u_max is not None and force + v > bounds.g_min[i] * found.u_max[i]:
            return None
        if 2 * eta + r * (widest[i] + 2 * eta) >= side or force + v > pull or log_down[i] < r:
            return None
    return Plant(bounds, [rho] * found.n, narrowest, widest, log_up, log_down)


def found_plant(found: Facts, bounds: Bounds) -> Plant | None:
    """The greatest rho of a grid with which the check holds: |e| stays below (rho - 1)/(rho + 1) from every start there."""
    for k in range(98, 0, -1):
        rho = (1 + Fraction(k, 100)) / (1 - Fraction(k, 100))
        numbers = plant(found, bounds, rho)
        if numbers is not None:
            return numbers
    return None


def example(found: Facts) -> Bounds:
    """A plant for tasks that have none: xdot = u + w, |w| <= 1/20, sampled every millisecond, x measured to 2^-20, or to the
    scalar where that is coarser."""
    n = found.n
    farthest = max(abs(v) for edge in found.space for v in edge)
    return Bounds(
        [Fraction(1, 20)] * n,
        [Fraction(1)] * n,
        [Fraction(1)] * n,
        [Fraction(0)] * n,
        Fraction(1, 1000),
        Fraction(0),
        max(Fraction(1, 1 << 20), farthest / (1 << FORMATS[found.scalar][1])),
    )


# What the task's text may have, for proof/Toml.v to read it; the key is a table's name.
KEYS = {
    "": "name axes units prescribed_time initial_state body",
    "state_space": "lower upper",
    "initial_set": "lower upper share",
    "target_set": "lower upper",
    "unsafe": "name lower upper",
    "tube": "clearance min_width design prefer max_speed max_acceleration segments seed",
    "control": "gain e_max u_max period latency outside saturate",
    "emit": "scalar math tick_period selftest rust",
    "plant": "f_max w_max g_min g_max g_cross noise",
}
CALLED, WRITTEN_OUT = "(fun _ => accurate)", "(fun called => False_ind _ (Bool.diff_true_false called))"  # of the logarithm
SPELT = re.compile(r"['{}\\\r]|\"\"\"|\d_\d|[=\[,]\s*\+")  # in the task, what proof/Toml.v does not read
BEFORE = re.compile(rb"\\|\?\?|//|/\*/|([+&|>-])\s+\1|[<>=!]\s+=")  # in the C, what proof/Read.v refuses


def _foreign(task: bytes) -> str:
    """What of the task's text proof/Toml.v does not read; empty where it reads all."""
    text = "\n".join(line.partition("#")[0] for line in task.decode().splitlines())
    if SPELT.search(text):
        return "a task that is spelt so"
    given = tomllib.loads(task.decode())
    top = {k: v for k, v in given.items() if not isinstance(v, dict) and k != "unsafe"}
    tables = [
        ("", top),
        *((k, v) for k, v in given.items() if isinstance(v, dict)),
        *(("unsafe", v) for v in given.get("unsafe", [])),
    ]
    return next((f"{h}.{k}".lstrip(".") for h, table in tables for k in table if k not in KEYS.get(h, "").split()), "")


def uncovered(found: Facts, *texts: bytes) -> str:
    """What of task, header or C Coq does not read, or for a task without a period why its example has no theorem; empty where
    it does."""
    task, *code = texts
    reasons = {
        "values of e_max that differ": len({*found.e_max}) > 1,
        "texts beyond ASCII": not all(text.isascii() for text in texts),
        "comments with signs that C reads before tokens": any(BEFORE.search(text) for text in code),
        "a guard": any(f"{found.name}_guard".encode() in text for text in code),
        "a task whose name begins a variable": any(re.search(rf" {found.name}_\w+ = ".encode(), text) for text in code),
    }
    told = next((name for name, given in reasons.items() if given), "") or _foreign(task)
    if told or found.sampling is not None or found_plant(rounded(found), example(found)) is not None:
        return told
    return "tubes so narrow" if found.u_max is None else "tubes so narrow, or limits so low"


def rounded(found: Facts) -> Facts:
    """With gains as Coq reads them in the C: numbers of the format, near the certificate's, whose limits are such numbers."""
    return replace(found, gain=tuple(checker.rounded(v, FORMATS[found.scalar][1]) for v in found.gain))


def words(found: Facts) -> str:
    """The closed loop in words, part of the comment that begins the file; decimals are rounded to the side that says less."""
    clear, t_c = exact(found.clearance), exact(found.t_c)
    kept = f"in the state space, {clear} away from every unsafe set, and from t = {t_c} s on in the target set"
    end = f"{kept}, state space and unsafe sets having the body added."
    held = (
        f"The closed loop. Inputs are held: each is what `{found.name}_control` stores for the time and the state of a sample. "
        "The first is taken at 0 and acts from then on; "
    )
    if found.sampling is None:
        b, numbers = example(found), _example(found)
        rho = numbers.rho[0]
        reach = Fraction(str(below((rho - 1) / (rho + 1))))
        told = (
            f"{held}each acts at once, and for at most {exact(b.tau)} s. The task has no control.period, so the plant is an "
            f"example: any xdot_i = f_i + u_i with |f_i| at most {exact(b.force[0])}, x measured to {exact(b.noise)}. "
            f"For as long as there are inputs, every trajectory from every start with |e| at most {exact(reach)} is {end}"
        )
    else:
        told = f"{held}{sampled_claim(found, found.sampling)}"
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
        ticks=found.ticks,
        lost="(1 # 16384)" if found.inline else f"(32 * half_ulp {FORMATS[found.scalar][0]})",
        unit=rational(found.unit),
        error=rational(found.error * found.unit),
        format=FORMATS[found.scalar][0],
        depth=DEPTH,
        n=found.n,
        sampled=None if found.sampling is None else _sampled(found, found.sampling),
        plant=_example(found) if found.sampling is None else "",
    )


def _example(found: Facts) -> Plant:
    numbers = found_plant(found, example(found))
    if numbers is None:
        raise BadInput("theorem: the example of a sampled loop, one millisecond, has no inner tube")
    return numbers


def _sampled(found: Facts, s: Sampling) -> dict[str, Any]:
    """The record `sampling` of proof/Period.v, with gain, clamp and limit as the C has them."""
    rest = (s.rho, s.force, s.g_min, s.g_max, s.g_cross, s.shift)
    law = [f"(nth {i} the_gains 0) the_clamp (nth {i} the_limits None)" for i in range(found.n)]
    parts = [f"Component {law[i]} {' '.join(rational(v[i]) for v in rest)}" for i in range(found.n)]
    bounds = hints(found, s)
    rows = ["; ".join(f"({rational(u)}, {rational(log)})" for u, log in row) for row in bounds]
    return {
        "tau": rational(s.period + s.latency),
        "latency": rational(s.latency),
        "share": rational(s.share),
        "lost": rational(s.lost),
        "components": ";\n  ".join(parts),
        "hints": ";\n  ".join(f"[{row}]" for row in rows),
        "cells": cells(found, s, bounds),
    }
