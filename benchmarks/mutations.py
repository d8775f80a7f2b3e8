"""Does the certificate ever say yes to a tube that is not safe? Mutated tubes and tasks, judged by roots (oracles/tubes.py).

    python -m benchmarks mutations [--count 10000] [--seed 0] [--processes 2] [--no-checker] [--integers]
                                   [--shapes | --moving | --inertia]
                                   [--first 0] [--record FILE.md]

The mutants are those of `mutants/tubes.py`; with --inertia those of `mutants/order_two.py`, judged by `oracles/order_two.py`
too, and, every fourth, of `mutants/sampled.py`, which a run of `oracles/sampled.py` may refute; with --integers those of
controllers in integers. The tool's certificate is asked, and the stand-alone checker, which gets files whose certificate claims
success, so that only its own proof can refuse. Prints one table; exit code 1 when something unsafe passed. A mutant depends on
the seed and its number only, so `--first 1234 --count 1` judges number 1234 again.
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
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.mutants.order_two import INERTIAL, draw_inertial
from benchmarks.mutants.sampled import HELD, Held, draw_held
from benchmarks.mutants.tubes import BESIDE, KINDS, MOVING, SHAPED, draw
from benchmarks.oracles.order_two import first_inertia_fault, hull_fault, leaving
from benchmarks.oracles.sampled import Bounds, counterexample
from benchmarks.oracles.tubes import Fault, Undecided, first_fault
from benchmarks.suites.report import command, machine, record
from stt_codegen.certify import checker
from stt_codegen.certify.certificate import Certificate, PeriodProof
from stt_codegen.controller.edge_errors import edge_error, rate_error
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.emit.render import Files, render
from stt_codegen.pipeline import build_program, certify
from stt_codegen.program.targets import optional_targets
from stt_codegen.sampling.loops import exact_loop
from stt_codegen.sampling.sampling_conditions import input_bound
from stt_codegen.task.schema import PlantBounds
from stt_codegen.task.sets.shapes import Box
from stt_codegen.task.task import Task

SECOND = (*INERTIAL, *HELD)
NEAR = 16  # units of the table within which a mutant counts as near the boundary
EXACT = decimal.Context(prec=200, traps=[decimal.Inexact])


@dataclass(frozen=True)
class Answer:
    """Of the tool or the checker. When a safe mutant is refused: whether it has the room that is demanded, and the reason; of
    order 2, where it has not, what is demanded."""

    passed: bool
    room: bool = False
    reason: str = ""


@dataclass(frozen=True)
class Verdict:
    """What is true of a mutant, and what was answered."""

    number: int
    kind: str
    base: str
    fault: Fault | None
    near: bool
    decided: bool
    answers: tuple[Answer, ...]


def judge(
    number: int,
    seed: int,
    with_checker: bool,
    names: Sequence[str] = SHAPED,
    kinds: Sequence[str] = tuple(KINDS),
    scalars: Sequence[str] = ("float", "double"),
) -> Verdict:
    """Draw a mutant, find the truth and ask the tool and, `with_checker`, the checker."""
    kind, name, _, (task, design) = draw(Random(f"{seed} {number}"), names, kinds, scalars)
    try:
        fault = first_fault(task, design)
        near = (first_fault(task, design, (NEAR if fault is None else -NEAR) * design.unit) is None) != (fault is None)
    except Undecided:
        return Verdict(number, kind, name, None, False, False, ())
    certificate = certify(task, design, build_program(task, design))
    failing = " ".join(sorted({f.code for f in certificate.failures} - {"P7"}))
    asked: list[tuple[bool, Callable[[], Fraction], str]] = [
        (certificate.tube_holds, lambda: max(certificate.edge_error), failing)
    ]
    if with_checker:
        asked.append(ask_checker(task, design, certificate))
    answers = tuple(
        Answer(passed) if passed or fault else Answer(passed, first_fault(task, design, error()) is None, reason)
        for passed, error, reason in asked
    )
    return Verdict(number, kind, name, fault, near, True, answers)


# ------------------------------------------------------------------------------------------------ order 2


def judge_inertia(number: int, seed: int, with_checker: bool) -> Verdict:
    """Every fourth is a held loop."""
    dice = Random(f"inertia {seed} {number}")
    return (judge_held if number % 4 == 3 else judge_filtered)(dice, number, with_checker)


def judge_filtered(dice: Random, number: int, with_checker: bool, **among: Sequence[str]) -> Verdict:
    """P1 to P6 and P8 of order 2; what leaves where P8 fails must be found, too."""
    kind, name, _, (task, design) = draw_inertial(dice, **among)

    def fault_of(units: int) -> Fault | None:
        return first_fault(task, design, units * design.unit) or first_inertia_fault(task, design, units)

    try:
        fault = fault_of(0)
        near = (fault_of(NEAR if fault is None else -NEAR) is None) != (fault is None)
    except Undecided:
        return Verdict(number, kind, name, None, False, False, ())
    if fault is not None and fault.code == "P8" and leaving(task, design, fault) is None:
        fault = replace(fault, code="P8, nothing leaves")
    certificate = certify(task, design, build_program(task, design))
    failing = " ".join(sorted({f.code for f in certificate.failures}))
    asked = [(certificate.holds, lambda: max(certificate.edge_error), failing)]
    if with_checker:
        asked.append((ask_numbers if fault is None else asked_twice)(task, design, certificate))
    wrong = [f.required for f in certificate.findings if f.code == "P1"][-1]

    def answer(passed: bool, error: Callable[[], Fraction], missed: str) -> Answer:
        if passed or fault:
            return Answer(passed)
        found = first_fault(task, design, error())
        coarse = "" if found else hull_fault(task, design, wrong, 1)
        why = f"{found.code} leaves no room for the arithmetic" if found else f"{coarse}: hull of a segment" if coarse else ""
        return Answer(False, not why, why or missed)

    return Verdict(number, kind, name, fault, near, True, tuple(answer(*one) for one in asked))


def judge_held(dice: Random, number: int, with_checker: bool, **among: Sequence[str]) -> Verdict:
    """P9: a run may refute it; where none does, nothing is known (undecided). Of what is proved the bounds on e and u, too."""
    kind, name, base, (task, design) = draw_held(dice, **among)
    certificate = certify(task, design, build_program(task, design))
    proof = certificate.proved_period if certificate.holds else None
    bounds = None
    if proof is not None:
        bounds = Bounds(tuple(float((r - 1) / (r + 1)) for r in proof.rho), tuple(float(v) for v in proof.u))
    left, outside = counterexample(task, design, number, bounds), first_inertia_fault(task, design)
    fault = outside or (None if left is None else Fault("P9", Fraction(left.time), left.dimension))
    answers, ask = [Answer(certificate.holds)], asked_twice if fault else ask_numbers
    if with_checker:
        answers.append(Answer(any(ask(task, design, certificate, p)[0] for p in proofs(task, design, base, proof))))
    return Verdict(number, kind, name, fault, False, fault is not None, tuple(answers))


def proofs(task: Task, design: RefinedDesign, base: Held, proof: PeriodProof | None) -> list[PeriodProof]:
    """What may be claimed of P9: the tool's own, or with bounds on e of the base, and up to the clamp."""
    if proof is not None:
        return [proof]
    program = build_program(task, design)
    loop = exact_loop(task, design, edge_error(design, program), rate_error(design, program))
    found, most = [], tuple((1 + e) / (1 - e) for e in task.e_max)
    for rho in dict.fromkeys((tuple(map(min, base.proof.rho, most)), most)):
        u = input_bound(loop, np.array(rho, dtype=object))
        largest = tuple(u.max(axis=0).tolist()) if (u < math.inf).all() else (Fraction(1),) * task.dimension
        control, share = task.control, task.initial_set.share
        found.append(
            PeriodProof(
                period=task.sampling_period,
                latency=control.latency,
                share=share,
                rho=rho,
                u=largest,
                shift=tuple(loop.law.shift.tolist()),
            )
        )
    return found


# ------------------------------------------------------------------------------------------------ the checker's files


def ask_numbers(
    task: Task, design: RefinedDesign, certificate: Certificate, proof: PeriodProof | None = None
) -> tuple[bool, Callable[[], Fraction], str]:
    """As `ask_checker`, without what takes it most of the time and does not depend on the numbers: running the C's statements.
    So it can only say yes more often."""
    with patch.object(checker, "computes", lambda *_: None):
        return ask_checker(task, design, certificate, proof)


def asked_twice(
    task: Task, design: RefinedDesign, certificate: Certificate, proof: PeriodProof | None = None
) -> tuple[bool, Callable[[], Fraction], str]:
    """A yes to what is unsafe is asked for again in full."""
    found = ask_numbers(task, design, certificate, proof)
    return ask_checker(task, design, certificate, proof) if found[0] else found


def ask_checker(
    task: Task, design: RefinedDesign, certificate: Certificate, proof: PeriodProof | None = None
) -> tuple[bool, Callable[[], Fraction], str]:
    """Whether the checker says yes to the mutant's files, its own bound on rounding, and the property that it misses."""
    files = claiming(task, design, certificate, proof)
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as said:
        for name, data in files.items():
            Path(folder, name).write_bytes(data)
        answer = checker.main(
            [str(Path(folder, name)) for name in ("task.toml", f"{task.name}.c", f"{task.name}.certificate.json")]
        )
    found = re.search(r"P\d does not hold|P6: the tube has a kink", said.getvalue())
    if answer not in (0, 1) or (answer == 1 and not found):
        raise RuntimeError(f"the checker did not come to its proof: {said.getvalue()}")

    def error() -> Fraction:
        known = checker.Task(files["task.toml"])
        text, whole = files[f"{task.name}.c"], task.emit.scalar == "fixed"
        source = checker.Integers(text, known) if whole else checker.Source(text, known, task.emit.scalar == "float")
        tube = checker.Tube(source, known, design.bits)
        source.clock(known, tube)
        return max(checker.arithmetic(source, tube))

    return answer == 0, error, found[0][:2] if found else ""


def claiming(task: Task, design: RefinedDesign, certificate: Certificate, proof: PeriodProof | None = None) -> Files:
    """The files of a tube that may be unsafe, with its task, and a certificate that claims success: all that it says of the tube
    is true, so that only the checker's own proof can refuse. proof: what it says of P9, where it is asked for that."""
    known = task if proof else task.model_copy(update={"control": task.control.model_copy(update={"period": None})})
    if task.order == 1:  # its mutants are not about u: with bounds on the plant P8 would be claimed where u is limited
        known = known.model_copy(update={"plant": PlantBounds()})
    plain: dict[str, Any] = {
        "selftest": False,
        **{t.key: False for t in optional_targets()},
    }  # of the mutants is what `toml` says, and nothing beside it
    plain |= {} if task.emit.scalar == "fixed" else {"tick_period": None}
    known = known.model_copy(update={"emit": known.emit.model_copy(update=plain)})
    text = toml(known).encode()
    known = known.model_copy()
    known._digest = checker.Task(text).digest
    certificate = replace(certificate, proved_period=proof)
    files = render(known, design, build_program(known, design), certificate)
    proof = f"{task.name}.certificate.json"
    return {**files, "task.toml": text, proof: json.dumps({**json.loads(files[proof]), "certified": True}).encode()}


def number_text(value: Fraction) -> str:
    """All decimals of a fraction that has finitely many."""
    text = format(EXACT.divide(decimal.Decimal(value.numerator), decimal.Decimal(value.denominator)), "f")
    return text if "." in text else text + ".0"


def toml(task: Task) -> str:
    """What the checker reads of a task file. Of order 1 without period and plant, for its mutants are judged by P1 to P6."""

    def vector(values: Iterable[Fraction]) -> str:
        return f"[{', '.join(number_text(v) for v in values)}]"

    def box(head: str, b: Box) -> str:
        return f"{head}\n{told(b)}"

    def told(unsafe: Any) -> str:
        """What a table says, in the order of its fields."""
        names = ("axes", "lower", "upper", "centre", "offsets", "vertices", "normals", "segment", "radius")
        given = {field: value for field in names if (value := getattr(unsafe, field, None))}
        lines = [f"axes = {json.dumps(given['axes'])}\n"] if "axes" in given else []
        for field in ("lower", "upper", "centre", "offsets"):
            lines += [f"{field} = {vector(given[field])}\n"] if field in given else []
        if motion := getattr(unsafe, "motion", None):
            lines.append(f"motion = [{', '.join(f'{{at = {number_text(p.at)}, by = {vector(p.by)}}}' for p in motion)}]\n")
        if during := getattr(unsafe, "during", None):
            lines.append(f"during = {vector(during)}\n")
        for field in ("timing", "spread"):
            if (value := getattr(unsafe, field, None)) is not None:
                lines.append(f"{field} = {number_text(value)}\n")
        for field in ("vertices", "normals", "segment"):
            if field in given:
                lines.append(f"{field} = [{', '.join(vector(p) for p in given[field])}]\n")
        return "".join(lines) + (f"radius = {number_text(given['radius'])}\n" if "radius" in given else "")

    limits = "" if task.u_max is None else f"u_max = {vector(task.u_max)}\n"
    limited = ((name, getattr(task, name)) for name in ("max_speed", "max_acceleration"))
    speed = "".join(f"{name} = {vector(most)}\n" for name, most in limited if most is not None)
    emit = f'math = "{task.emit.math}"\n'
    if task.emit.scalar == "fixed" and task.emit.tick_period is not None:
        emit = f'scalar = "fixed"\ntick_period = {number_text(task.emit.tick_period)}\n'
    starts = plant = ""
    if task.order == 2:
        starts = f"share = {number_text(task.initial_set.share)}\n"
        starts += f"speed = {vector(task.start_speed)}\n" if task.initial_set.speed is not None else ""
        bounds = (f"{name} = {number_text(v)}\n" for name, v in task.plant.bounds.items() if v is not None)
        plant = "[plant]\norder = 2\n" + "".join(bounds)
        if task.control.period is not None:
            limits += f"period = {number_text(task.control.period)}\nlatency = {number_text(task.control.latency)}\n"
    return "".join(
        (
            f'name = "{task.name}"\nprescribed_time = {number_text(task.prescribed_time)}\n',
            f"axes = {json.dumps(task.axes)}\n" if task.axes else "",
            f"start_delay = {number_text(task.start_delay)}\n" if task.start_delay else "",
            f"initial_state = {vector(task.initial_state)}\n" + (f"body = {vector(task.body)}\n" if task.body else ""),
            *(box(f"[{name}]", getattr(task, name)) for name in ("state_space", "target_set", "initial_set")),
            starts,
            *(f'[[unsafe]]\nname = "{s.name}"\n{told(s)}' for s in task.unsafe),
            f"[tube]\nclearance = {number_text(task.tube.clearance)}\nmin_width = {number_text(task.tube.min_width)}\n{speed}",
            f"[control]\ngain = {vector(task.gain)}\ne_max = {vector(task.e_max)}\n{limits}[emit]\n{emit}",
            plant,
        )
    )


# ------------------------------------------------------------------------------------------------ the table


def table(verdicts: Sequence[Verdict], askers: Sequence[str], kinds: Sequence[str] = tuple(KINDS)) -> str:
    """One row for each kind of mutation, then what the columns mean, and reasons."""
    columns = "".join(f"{f'{asker}: passed':>18s}{'refused':>9s}{'room':>6s}" for asker in askers)
    lines = [f"{'mutation':28s}{'mutants':>8s}{'unsafe':>8s}{'near':>7s}{'undecided':>11s}{columns}"]
    for kind in (*kinds, "all"):
        group = [v for v in verdicts if kind in (v.kind, "all")]
        bad = [v for v in group if v.fault]
        near, undecided = sum(v.near for v in group), sum(not v.decided for v in group)
        line = f"{kind:28s}{len(group):8d}{len(bad):8d}{near:7d}{undecided:11d}"
        for a in range(len(askers)):
            refused = [v.answers[a] for v in group if v.decided and not v.fault and not v.answers[a].passed]
            line += f"{sum(v.answers[a].passed for v in bad):18d}{len(refused):9d}{sum(r.room for r in refused):6d}"
        lines.append(line)
    lines += [
        f"near: the truth is another with {NEAR} table units more or less to spare; passed: though unsafe; refused: though safe;",
        "room: of these, those that have the room which is demanded for the arithmetic's error.",
        "unsafe, by the first property found broken: " + counted(v.fault.code for v in verdicts if v.fault),
    ]
    for a, asker in enumerate(askers):
        if kinds == SECOND:
            lines += _of_second(verdicts, a, asker)
            continue
        reasons = (v.answers[a].reason for v in verdicts if v.decided and v.answers[a].room)
        lines.append(f"{asker}: refused with room, by property: {counted(reasons)}")
    return "\n".join(lines)


def _of_second(verdicts: Sequence[Verdict], a: int, asker: str) -> list[str]:
    """Why what is safe was refused, and what was said of loops of which nothing is known."""
    reasons = (v.answers[a].reason for v in verdicts if v.decided and not v.fault and not v.answers[a].passed)
    unknown = [v for v in verdicts if v.kind in HELD and not v.decided]
    proved = sum(v.answers[a].passed for v in unknown)
    return [
        f"{asker}: refused though safe, why: {counted(reasons)}",
        f"{asker}: proves {proved} of {len(unknown)} loops that no run refutes",
    ]


def counted(names: Iterable[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in sorted(Counter(names).items())) or "none"


def main() -> int:
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
    parser.add_argument("--inertia", action="store_true", help="only tubes and held loops for plants of order 2")
    options = parser.parse_args()
    begin, verdicts = time.perf_counter(), []
    kinds = BESIDE if options.shapes else MOVING if options.moving else SECOND if options.inertia else tuple(KINDS)
    scalars = ("fixed",) if options.integers else ("float", "double")
    asked = judge_inertia if options.inertia else partial(judge, kinds=kinds, scalars=scalars)
    with multiprocessing.Pool(options.processes) as pool:
        numbers = range(options.first, options.first + options.count)
        for v in pool.imap(partial(asked, seed=options.seed, with_checker=options.checker), numbers, chunksize=20):
            verdicts.append(v)
            if len(verdicts) % 100 == 0:
                print(f"\r{len(verdicts)}/{options.count}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    found = table(verdicts, ("tool", "checker") if options.checker else ("tool",), kinds if options.inertia else tuple(KINDS))
    print(found)
    passed = [v for v in verdicts if v.fault and any(a.passed for a in v.answers)]
    again = next((f" --{name}" for name in ("shapes", "moving", "inertia") if getattr(options, name)), "")
    again += " --integers" if options.integers else ""
    for v in passed:
        print(f"PASSED THOUGH UNSAFE: --seed {options.seed} --first {v.number} --count 1{again}: {v.kind} of {v.base}: {v.fault}")
    took = f"{len(verdicts)} mutants in {time.perf_counter() - begin:.0f} s, {options.processes} processes"
    print(took)
    if options.record:
        name, title = "mutations", "Mutated tubes and tasks"
        if options.inertia:
            name, title = "mutations inertia", "Mutated tubes and held loops of order 2"
        record(
            options.record,
            name,
            f"## {title}\n\nMade by `{command()}`; {took}; {machine()}.\n\n```\n{found}\n```",
        )
    return 1 if passed else 0


if __name__ == "__main__":
    sys.exit(main())
