"""Count false certificates: mutated tubes and tasks that tool or checker verify, although an oracle finds them unsafe.

    python -m benchmarks mutations [--count 10000] [--seed 0] [--processes 2] [--no-checker] [--integers]
                                   [--shapes | --moving | --inertia]
                                   [--first 0] [--record FILE.md]

The mutants are those of mutants/tubes.py, and roots of polynomials decide whether they are safe (oracles/tubes.py). With
--inertia they are tubes of order 2 (mutants/order_two.py, oracles/order_two.py) and, every fourth, sampled loops
(mutants/sampled.py), which a simulation may refute (oracles/sampled.py). With --integers the controllers are in integers.

The checker gets files whose certificate claims success, so that only its own proof can refuse. The command prints one table, and
ends with exit code 1 when an unsafe mutant passed. A mutant depends on the seed and its number alone, so `--first 1234 --count 1`
judges number 1234 again.
"""

from __future__ import annotations

import argparse
import contextlib
import decimal
import io
import json
import math
import multiprocessing
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np

from benchmarks.mutants.order_two import ORDER_TWO_MUTATIONS, draw_order_two_mutant
from benchmarks.mutants.sampled import SAMPLED_MUTATIONS, BaseLoop, draw_sampled_mutant
from benchmarks.mutants.tubes import ALL_BASE_NAMES, MUTATIONS, SHAPE_KINDS, TIMED_SET_KINDS, draw_mutant
from benchmarks.oracles.cubics import Undecided
from benchmarks.oracles.order_two import first_order_two_fault, leaving_state, property_that_hulls_miss
from benchmarks.oracles.sampled import ClaimedBounds, counterexample
from benchmarks.oracles.tubes import Fault, first_fault
from benchmarks.suites.report import command, machine, record
from stt_codegen.certify.certificate import Certificate, PeriodProof
from stt_codegen.checker.stt_checker import check_files, integers, rounding, source
from stt_codegen.checker.stt_checker.claims import BITS
from stt_codegen.checker.stt_checker.task import Task as CheckedTask
from stt_codegen.checker.stt_checker.tube import Tube as CheckedTube
from stt_codegen.controller.edge_errors import edge_error, rate_error
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.emit.render import Files, render
from stt_codegen.pipeline import build_program, certify
from stt_codegen.program.targets import optional_targets
from stt_codegen.sampling.loops import exact_loop
from stt_codegen.sampling.sampling_conditions import input_bound
from stt_codegen.task.schema import PlantBounds
from stt_codegen.task.task import Task

ORDER_TWO_KINDS = (*ORDER_TWO_MUTATIONS, *SAMPLED_MUTATIONS)
NEAR_UNITS = 16  # units of the table within which a mutant counts as near the boundary
EXACT_CONTEXT = decimal.Context(prec=200, traps=[decimal.Inexact])  # digits; a division that is not exact raises an error


class Opinion(NamedTuple):
    """What the tool or the checker says of a mutant: whether it passes, the error band of its edges, and why it is refused."""

    passed: bool
    error_band: Callable[[], Fraction]
    reason: str


@dataclass(frozen=True)
class Answer:
    """Whether the tool or the checker passed a mutant and, for a safe mutant that was refused, why.

    has_margin: whether the mutant is safe by the error band, too. reason: the properties that were refused; of a tube of order 2
    without the margin, which requirement it misses.
    """

    passed: bool
    has_margin: bool = False
    reason: str = ""


@dataclass(frozen=True)
class Judgement:
    """The truth about a mutant, beside the answers of the tool and, where it was asked, the checker.

    number: of the mutant, from which it is drawn. kind: of the mutation. base: name of the task or tube that was mutated.
    fault: the first property that is violated, None where the mutant is safe or nothing is known. is_near: whether NEAR_UNITS
    more or less would change that. is_decided: whether the oracle knows the truth.
    """

    number: int
    kind: str
    base: str
    fault: Fault | None
    is_near: bool
    is_decided: bool
    answers: tuple[Answer, ...]


def judge(
    number: int,
    seed: int,
    with_checker: bool,
    names: Sequence[str] = ALL_BASE_NAMES,
    kinds: Sequence[str] = tuple(MUTATIONS),
    *,
    scalars: Sequence[str] = ("float", "double"),
) -> Judgement:
    """Draw a mutant of order 1, and judge it by the oracle, the tool and, `with_checker`, the checker."""
    drawn = draw_mutant(Random(f"{seed} {number}"), names, kinds, scalars)
    kind, name, (task, design) = drawn.kind, drawn.base_name, drawn.mutant
    try:
        fault = first_fault(task, design)
        margin = (NEAR_UNITS if fault is None else -NEAR_UNITS) * design.unit
        is_near = (first_fault(task, design, margin) is None) != (fault is None)
    except Undecided:
        return Judgement(number, kind, name, None, False, False, ())
    certificate = certify(task, design, build_program(task, design))
    failing = " ".join(sorted({f.code for f in certificate.failures} - {"P7"}))
    opinions = [Opinion(certificate.tube_holds, lambda: max(certificate.edge_error), failing)]
    if with_checker:
        opinions.append(ask_checker(task, design, certificate))
    answers = tuple(
        Answer(o.passed) if o.passed or fault else Answer(False, first_fault(task, design, o.error_band()) is None, o.reason)
        for o in opinions
    )
    return Judgement(number, kind, name, fault, is_near, True, answers)


# ------------------------------------------------------------------------------------------------ order 2


def judge_order_two(number: int, seed: int, with_checker: bool) -> Judgement:
    """Judge a mutant of order 2: every fourth number is a sampled loop, the others are tubes."""
    rng = Random(f"inertia {seed} {number}")
    return (judge_sampled_loop if number % 4 == 3 else judge_filtered_tube)(rng, number, with_checker)


def judge_filtered_tube(rng: Random, number: int, with_checker: bool, **among: Sequence[str]) -> Judgement:
    """Draw a tube of order 2 and judge its properties P1 to P6 and P8.

    Where the limits (P8) are violated, a trajectory that leaves the tube must exist; a fault without one has another code.
    among: names of the bases and kinds of the mutations.
    """
    drawn = draw_order_two_mutant(rng, **among)
    kind, name, (task, design) = drawn.kind, drawn.base_name, drawn.mutant

    def fault_of(units: int) -> Fault | None:
        return first_fault(task, design, units * design.unit) or first_order_two_fault(task, design, units)

    try:
        fault = fault_of(0)
        is_near = (fault_of(NEAR_UNITS if fault is None else -NEAR_UNITS) is None) != (fault is None)
    except Undecided:
        return Judgement(number, kind, name, None, False, False, ())
    if fault is not None and fault.code == "P8" and leaving_state(task, design, fault) is None:
        fault = replace(fault, code="P8, nothing leaves")
    certificate = certify(task, design, build_program(task, design))
    failing = " ".join(sorted({f.code for f in certificate.failures}))
    opinions = [Opinion(certificate.holds, lambda: max(certificate.edge_error), failing)]
    if with_checker:
        opinions.append(ask_checker(task, design, certificate))
    required_width = [f.required for f in certificate.findings if f.code == "P1"][-1]

    def answer_of(opinion: Opinion) -> Answer:
        """Return the answer; where a safe mutant is refused the reason is a missing margin, a coarse hull, or the opinion's."""
        if opinion.passed or fault:
            return Answer(opinion.passed)
        if without_margin := first_fault(task, design, opinion.error_band()):
            return Answer(False, False, f"{without_margin.code} leaves no margin for the arithmetic")
        if coarse := property_that_hulls_miss(task, design, required_width, 1):
            return Answer(False, False, f"{coarse}: hull of a segment")
        return Answer(False, True, opinion.reason)

    return Judgement(number, kind, name, fault, is_near, True, tuple(answer_of(opinion) for opinion in opinions))


def judge_sampled_loop(rng: Random, number: int, with_checker: bool, **among: Sequence[str]) -> Judgement:
    """Draw a sampled loop of order 2, and judge its period (P9).

    A simulation may refute the period, or the proved bounds on the error e and the input u. Where none does, the truth is not
    known, and the judgement is undecided.
    """
    drawn = draw_sampled_mutant(rng, **among)
    kind, name, (task, design) = drawn.kind, drawn.base_name, drawn.mutant
    certificate = certify(task, design, build_program(task, design))
    proof = certificate.proved_period if certificate.holds else None
    bounds = None
    if proof is not None:
        bounds = ClaimedBounds(tuple(float((r - 1) / (r + 1)) for r in proof.rho), tuple(float(v) for v in proof.u))
    left, outside = counterexample(task, design, number, bounds), first_order_two_fault(task, design)
    fault = outside or (None if left is None else Fault("P9", Fraction(left.time), left.dimension))
    answers = [Answer(certificate.holds)]
    if with_checker:
        is_accepted = any(
            ask_checker(task, design, certificate, p).passed for p in possible_proofs(task, design, drawn.base, proof)
        )
        answers.append(Answer(is_accepted))
    return Judgement(number, kind, name, fault, False, fault is not None, tuple(answers))


def possible_proofs(task: Task, design: RefinedDesign, base: BaseLoop, proof: PeriodProof | None) -> list[PeriodProof]:
    """Return proofs of the period that a certificate may claim.

    That is the tool's proof; where there is none, one with the base's bounds on e, and one with e up to the clamp.
    """
    if proof is not None:
        return [proof]
    program = build_program(task, design)
    loop = exact_loop(task, design, edge_error(design, program), rate_error(design, program))
    proofs, rho_at_clamp = [], tuple((1 + e) / (1 - e) for e in task.e_max)
    for rho in dict.fromkeys((tuple(map(min, base.proof.rho, rho_at_clamp)), rho_at_clamp)):
        u = input_bound(loop, np.array(rho, dtype=object))
        largest = tuple(u.max(axis=0).tolist()) if (u < math.inf).all() else (Fraction(1),) * task.dimension
        control, share = task.control, task.initial_set.share
        proofs.append(
            PeriodProof(
                period=task.sampling_period,
                latency=control.latency,
                share=share,
                rho=rho,
                u=largest,
                shift=tuple(loop.law.shift.tolist()),
            )
        )
    return proofs


# ------------------------------------------------------------------------------------------------ the checker's files


def ask_checker(task: Task, design: RefinedDesign, certificate: Certificate, proof: PeriodProof | None = None) -> Opinion:
    """Run the stand-alone checker on the mutant's files.

    Return whether it verifies them, the error band that it computes, and the property that it refuses. Raises RuntimeError where
    the checker stops before its proof.
    """
    files = files_claiming_success(task, design, certificate, proof)
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as output:
        for name, data in files.items():
            Path(folder, name).write_bytes(data)
        answer = check_files(
            [str(Path(folder, name)) for name in ("task.toml", f"{task.name}.c", f"{task.name}.certificate.json")]
        )
    refusal = re.search(r"P\d+ does not hold", output.getvalue())
    if answer not in (0, 1) or (answer == 1 and not refusal):
        raise RuntimeError(f"the checker did not come to its proof: {output.getvalue()}")

    def error_band() -> Fraction:
        _, tube, controller = checked_tube(files)
        error_of = rounding.arithmetic_error if controller is None else controller.arithmetic_error
        return max(error_of(tube, BITS[task.emit.scalar]))

    return Opinion(answer == 0, error_band, refusal[0][:2] if refusal else "")


def checked_tube(files: Files) -> tuple[CheckedTask, CheckedTube, integers.Integers | None]:
    """Return the task and the tube as the checker reads them, and the controller where it is in integers.

    files: those of a controller, and the task as task.toml."""
    task = CheckedTask(files["task.toml"])
    certificate, text = json.loads(files[f"{task.name}.certificate.json"]), files[f"{task.name}.c"]
    unit, controller = Fraction(2) ** -certificate["grid"]["unit_bits"], None
    if certificate["scalar"] == "fixed":
        controller = integers.Integers(text, task, certificate["integers"])
        entries = [v * unit for v in controller.tables["coefficients"]]
    else:
        entries = source.real_table(text, f"{task.name}_coefficients", BITS[certificate["scalar"]])
    tube = CheckedTube(entries, task.n, unit, task.t_c, certificate["grid"].get("seam"))
    if controller is not None:
        controller.check_clock(tube)
    return task, tube, controller


def files_claiming_success(
    task: Task, design: RefinedDesign, certificate: Certificate, proof: PeriodProof | None = None
) -> Files:
    """Return the files of a tube that may be unsafe, its task file, and a certificate that claims success.

    Everything else in the certificate is true, so that only the checker's proof can refuse. proof: the claim about the period
    (P9), None to claim nothing.
    """
    claimed_task = task if proof else task.model_copy(update={"control": task.control.model_copy(update={"period": None})})
    if task.order == 1:  # with bounds on the plant the limits (P8) would be claimed too, which these mutants are not about
        claimed_task = claimed_task.model_copy(update={"plant": PlantBounds()})
    # The task file has only what `task_text` writes, so options beside it are switched off.
    emit: dict[str, Any] = {"selftest": False, **{t.key: False for t in optional_targets()}}
    emit |= {} if task.emit.scalar == "fixed" else {"tick_period": None}
    claimed_task = claimed_task.model_copy(update={"emit": claimed_task.emit.model_copy(update=emit)})
    text = task_text(claimed_task).encode()
    claimed_task = claimed_task.model_copy()
    claimed_task._digest = CheckedTask(text).digest
    certificate = replace(certificate, proved_period=proof)
    files = render(claimed_task, design, build_program(claimed_task, design), certificate)
    name = f"{task.name}.certificate.json"
    return {**files, "task.toml": text, name: json.dumps({**json.loads(files[name]), "certified": True}).encode()}


def number_text(value: Fraction) -> str:
    """Return all decimals of a fraction that has finitely many of them."""
    text = format(EXACT_CONTEXT.divide(decimal.Decimal(value.numerator), decimal.Decimal(value.denominator)), "f")
    return text if "." in text else text + ".0"


def vector_text(values: Iterable[Fraction]) -> str:
    return f"[{', '.join(number_text(v) for v in values)}]"


def bound_text(value: Fraction | tuple[Fraction, ...]) -> str:
    """Return a bound as a task file has it: one number, or one for each component."""
    return vector_text(value) if isinstance(value, tuple) else number_text(value)


def set_text(table: Any) -> str:
    """Return the lines of a table that describes a set, as a task file has them."""
    names = ("axes", "lower", "upper", "centre", "offsets", "vertices", "normals", "segment", "radius")
    fields = {field: value for field in names if (value := getattr(table, field, None))}
    lines = [f"axes = {json.dumps(fields['axes'])}\n"] if "axes" in fields else []
    for field in ("lower", "upper", "centre", "offsets"):
        lines += [f"{field} = {vector_text(fields[field])}\n"] if field in fields else []
    if motion := getattr(table, "motion", None):
        lines.append(f"motion = [{', '.join(f'{{at = {number_text(p.at)}, by = {vector_text(p.by)}}}' for p in motion)}]\n")
    if during := getattr(table, "during", None):
        lines.append(f"during = {vector_text(during)}\n")
    for field in ("timing", "spread"):
        if (value := getattr(table, field, None)) is not None:
            lines.append(f"{field} = {number_text(value)}\n")
    for field in ("vertices", "normals", "segment"):
        if field in fields:
            lines.append(f"{field} = [{', '.join(vector_text(p) for p in fields[field])}]\n")
    return "".join(lines) + (f"radius = {number_text(fields['radius'])}\n" if "radius" in fields else "")


def task_text(task: Task) -> str:
    """Return the text of a task file with all that the checker reads.

    Of order 1 it has no period and no plant, because these mutants are judged by P1 to P6.
    """
    limits = "" if task.u_max is None else f"u_max = {vector_text(task.u_max)}\n"
    rates = ((name, getattr(task, name)) for name in ("max_speed", "max_acceleration"))
    rate_limits = "".join(f"{name} = {vector_text(limit)}\n" for name, limit in rates if limit is not None)
    emit = f'math = "{task.emit.math}"\n'
    if task.emit.scalar == "fixed" and task.emit.tick_period is not None:
        emit = f'scalar = "fixed"\ntick_period = {number_text(task.emit.tick_period)}\n'
    starts = plant = ""
    if task.order == 2:
        starts = f"share = {number_text(task.initial_set.share)}\n"
        starts += f"speed = {vector_text(task.start_speed)}\n" if task.initial_set.speed is not None else ""
        bounds = (f"{name} = {number_text(v)}\n" for name, v in task.plant.bounds.items() if v is not None)
        plant = "[plant]\norder = 2\n" + "".join(bounds)
        if task.control.period is not None:
            limits += f"period = {number_text(task.control.period)}\nlatency = {number_text(task.control.latency)}\n"
    return "".join(
        (
            f'name = "{task.name}"\nprescribed_time = {number_text(task.prescribed_time)}\n',
            f"axes = {json.dumps(task.axes)}\n" if task.axes else "",
            f"start_delay = {number_text(task.start_delay)}\n" if task.start_delay else "",
            f"initial_state = {vector_text(task.initial_state)}\n" + (f"body = {vector_text(task.body)}\n" if task.body else ""),
            *(f"[{name}]\n{set_text(getattr(task, name))}" for name in ("state_space", "target_set", "initial_set")),
            starts,
            *(f'[[unsafe]]\nname = "{s.name}"\n{set_text(s)}' for s in task.unsafe),
            f"[tube]\nclearance = {bound_text(task.tube.clearance)}\nmin_width = {bound_text(task.tube.min_width)}\n",
            rate_limits,
            f"[control]\ngain = {vector_text(task.gain)}\ne_max = {vector_text(task.e_max)}\n{limits}[emit]\n{emit}",
            plant,
        )
    )


# ------------------------------------------------------------------------------------------------ the table


def table(judgements: Sequence[Judgement], judges: Sequence[str], kinds: Sequence[str] = tuple(MUTATIONS)) -> str:
    """Return a table with a row for each kind of mutation, what its columns mean, and why safe mutants were refused.

    judges: names of the tool and, where it was asked, the checker, in the order of the judgements' answers.
    """
    columns = "".join(f"{f'{judge_name}: passed':>18s}{'refused':>9s}{'margin':>8s}" for judge_name in judges)
    lines = [f"{'mutation':28s}{'mutants':>8s}{'unsafe':>8s}{'near':>7s}{'undecided':>11s}{columns}"]
    for kind in (*kinds, "all"):
        group = [j for j in judgements if kind in (j.kind, "all")]
        unsafe = [j for j in group if j.fault]
        near, undecided = sum(j.is_near for j in group), sum(not j.is_decided for j in group)
        line = f"{kind:28s}{len(group):8d}{len(unsafe):8d}{near:7d}{undecided:11d}"
        for a in range(len(judges)):
            refused = [j.answers[a] for j in group if j.is_decided and not j.fault and not j.answers[a].passed]
            line += f"{sum(j.answers[a].passed for j in unsafe):18d}{len(refused):9d}{sum(r.has_margin for r in refused):8d}"
        lines.append(line)
    lines += [
        f"near: {NEAR_UNITS} units of the table more or less would make it safe or unsafe; passed: though unsafe;",
        "refused: though safe; margin: refused, though it is safe by the margin that the arithmetic's error requires.",
        "unsafe, by the first property found broken: " + count_text(j.fault.code for j in judgements if j.fault),
    ]
    for a, judge_name in enumerate(judges):
        if kinds == ORDER_TWO_KINDS:
            lines += _order_two_lines(judgements, a, judge_name)
            continue
        reasons = (j.answers[a].reason for j in judgements if j.is_decided and j.answers[a].has_margin)
        lines.append(f"{judge_name}: refused with margin, by property: {count_text(reasons)}")
    return "\n".join(lines)


def _order_two_lines(judgements: Sequence[Judgement], a: int, judge_name: str) -> list[str]:
    """Return why safe tubes were refused, and how many of the loops that no simulation refutes were proved.

    a: index of the judge in the answers.
    """
    reasons = (j.answers[a].reason for j in judgements if j.is_decided and not j.fault and not j.answers[a].passed)
    unknown = [j for j in judgements if j.kind in SAMPLED_MUTATIONS and not j.is_decided]
    proved = sum(j.answers[a].passed for j in unknown)
    return [
        f"{judge_name}: refused though safe, why: {count_text(reasons)}",
        f"{judge_name}: proves {proved} of {len(unknown)} loops that no run refutes",
    ]


def count_text(names: Iterable[str]) -> str:
    """Return how often each name occurs, as "a 2, b 1"; "none" where there is no name."""
    return ", ".join(f"{name} {count}" for name, count in sorted(Counter(names).items())) or "none"


def main() -> int:
    """Judge the mutants, and print the table and every false certificate. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--shapes", action="store_true", help="only unsafe sets of other shapes, put beside a tube")
    parser.add_argument("--moving", action="store_true", help="only sets that move, put beside a tube")
    parser.add_argument("--integers", action="store_true", help="controllers in integers, of order 1")
    parser.add_argument("--checker", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    parser.add_argument("--inertia", action="store_true", help="only tubes and sampled loops for plants of order 2")
    options = parser.parse_args()
    begin, judgements = time.perf_counter(), []
    by_option = {"shapes": SHAPE_KINDS, "moving": TIMED_SET_KINDS, "inertia": ORDER_TWO_KINDS}
    kinds = next((kinds for name, kinds in by_option.items() if getattr(options, name)), tuple(MUTATIONS))
    scalars = ("fixed",) if options.integers else ("float", "double")
    judge_mutant = judge_order_two if options.inertia else partial(judge, kinds=kinds, scalars=scalars)
    with multiprocessing.Pool(options.processes) as pool:
        numbers = range(options.first, options.first + options.count)
        for judgement in pool.imap(partial(judge_mutant, seed=options.seed, with_checker=options.checker), numbers, chunksize=20):
            judgements.append(judgement)
            if len(judgements) % 100 == 0:
                print(f"\r{len(judgements)}/{options.count}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    judges = ("tool", "checker") if options.checker else ("tool",)
    text = table(judgements, judges, kinds if options.inertia else tuple(MUTATIONS))
    print(text)
    passed = [j for j in judgements if j.fault and any(a.passed for a in j.answers)]
    flags = next((f" --{name}" for name in ("shapes", "moving", "inertia") if getattr(options, name)), "")
    flags += " --integers" if options.integers else ""
    for j in passed:
        print(f"PASSED THOUGH UNSAFE: --seed {options.seed} --first {j.number} --count 1{flags}: {j.kind} of {j.base}: {j.fault}")
    took = f"{len(judgements)} mutants in {time.perf_counter() - begin:.0f} s, {options.processes} processes"
    print(took)
    if options.record:
        name, title = "mutations", "Mutated tubes and tasks"
        if options.inertia:
            name, title = "mutations inertia", "Mutated tubes and sampled loops of order 2"
        record(
            options.record,
            name,
            f"## {title}\n\nMade by `{command()}`; {took}; {machine()}.\n\n```\n{text}\n```",
        )
    return 1 if passed else 0


if __name__ == "__main__":
    sys.exit(main())
