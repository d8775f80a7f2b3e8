"""Evidence for an assessor, made while the report is: the stand-alone checker, compilers, the reference, the self-test, MISRA.

Every number here comes from this run; where a tool is missing, the row says so."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from stt_codegen.certify import Finding, checker
from stt_codegen.compare import Row, compare_backend
from stt_codegen.decimals import decimal
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.emit import selftest_name, spelled_name
from stt_codegen.errors import SttError
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.c.runner import STRICT, CompiledC, find_compiler
from stt_codegen.properties import Property
from stt_codegen.report.page.bill_of_materials import library_calls
from stt_codegen.report.page.misra import DEVIATIONS, findings

COMPILERS = ("gcc", "clang")
SECONDS = 60  # that the self-test may take
POINTS = 2000  # random points of the comparison, beside the edges
HOW = {
    "exact": "exact rational arithmetic on the coefficients in the C",
    "enclosure": "enclosures of the emitted statements",
    "sampled": "samples, which prove nothing between them",
}


@dataclass(frozen=True, kw_only=True)
class Requirement:
    """A line of the chain from what the task asks to what was measured."""

    asked: str
    label: str
    statement: str
    holds: bool
    shown: str
    checked: str
    measured: str


@dataclass(frozen=True)
class Check:
    """Something that was run: whether it is as it should be (None: it could not be run), and what came of it."""

    name: str
    good: bool | None
    told: str


@dataclass(frozen=True, kw_only=True)
class Evidence:
    requirements: tuple[Requirement, ...]
    checks: tuple[Check, ...]
    misra: tuple[tuple[str, int, str, str, str], ...] | None  # rule, how often, kind, where, why
    unlisted: tuple[str, ...]
    flags: str
    not_shown: tuple[str, ...]

    @property
    def good(self) -> bool:
        return all(one.good is not False for one in self.checks) and not self.unlisted


def evidence(controller: EmittedController, source: Path | None = None, boards: Sequence[Check] = ()) -> Evidence:
    """Run what can be run here. source: the task's file, which the stand-alone checker reads; boards: what ran on boards."""
    stand_alone = _stand_alone(controller, source)
    compared = _compared(controller)
    found = findings(controller.files)
    prefix = controller.task.name
    rules = None
    if found is not None:
        known = [(rule, count, DEVIATIONS[rule]) for rule, count in found.items() if rule in DEVIATIONS]
        text = b"\n".join(controller.files.values()).decode()
        rules = tuple((rule, count, d.kind, _named(d.where, prefix, text), d.why) for rule, count, d in known)
    return Evidence(
        requirements=tuple(_requirements(controller, stand_alone, compared)),
        checks=(stand_alone, compared, *_compiled(controller), _selftest(controller), *boards),
        misra=rules,
        unlisted=tuple(rule for rule in found or () if rule not in DEVIATIONS),
        flags=" ".join(STRICT),
        not_shown=tuple(not_shown(controller)),
    )


def _named(where: str, prefix: str, text: str) -> str:
    """Where a rule is not kept, with the names of this task; of several names those that it has."""
    told = where.replace("<p>", prefix).replace("<P>", prefix.upper())
    names = re.findall(r"`(\w+)`", told)
    absent = [name for name in names if name not in text] if len(names) > 1 else []
    for name in absent:
        told = told.replace(f", `{name}`", "").replace(f"`{name}`, ", "")
    return told.replace("`", "")


def _requirements(controller: EmittedController, stand_alone: Check, compared: Check) -> Iterator[Requirement]:
    """What the task asks, property by property."""
    certificate = controller.certificate
    again = "the stand-alone checker, from the C" if stand_alone.good else "nothing else here"
    for one in certificate.findings:
        how = HOW[certificate.method]
        checked = again
        if one.subject is Property.ARITHMETIC:
            how = "a derived bound on every rounding"
            checked += ", and the compiled C beside a reference" if compared.good else ""
        elif one.subject is Property.PERIOD:
            how = "intervals over every time window, with the theorem of the lemma book"
        yield Requirement(
            asked=asked(controller, one),
            label=one.subject.label,
            statement=one.statement,
            holds=one.holds,
            shown=how,
            checked=checked,
            measured=measured(one),
        )


def measured(one: Finding) -> str:
    """What is left to spare, with its unit; of what fails, by how much, with a minus."""
    return f"{float(one.margin):.3g}{' s' if one.is_in_seconds else ''}" if one.margin else ""


def asked(controller: EmittedController, one: Finding) -> str:
    """The requirement of the task that a property is about."""
    task = controller.task
    texts = {
        Property.WIDTH: f"The tube is nowhere narrower than tube.min_width = {decimal(task.tube.min_width)}.",
        Property.AVOID: f"The tube keeps {decimal(task.tube.clearance)} from each of {len(task.unsafe)} unsafe sets.",
        Property.ARITHMETIC: f"All this holds in {controller.program.scalar} arithmetic.",
        Property.PERIOD: f"control.period = {decimal(task.control.period or Fraction(0))} s is short enough.",
    }
    if any(task.half_extents):
        texts[Property.STAY] = "The tube stays in state_space, the body with it."
    if task.target_set is None:
        texts[Property.REACH] = "The tube ends where the mission lets it."
    return texts.get(one.subject, one.subject.sentence)


def _stand_alone(controller: EmittedController, source: Path | None) -> Check:
    """The checker as a process of its own, which imports nothing of this package."""
    name, prefix = "stand-alone checker", controller.task.name
    if not controller.design.capabilities.has_exact_claims:
        return Check(name, None, f"is for {kinds_offering('has_exact_claims')} tubes; this one is {controller.design.kind}")
    if source is None and controller.task.expanded_text is None:
        return Check(name, None, "reads the task's file; this task was made without one")
    with tempfile.TemporaryDirectory() as folder:
        for file, data in controller.files.items():
            Path(folder, file).write_bytes(data)
        read = (
            source if controller.task.expanded_text is None else f"{folder}/{spelled_name(prefix)}"
        )  # with its map or outline spelled out
        paths = [str(read), f"{folder}/{prefix}.c", f"{folder}/{prefix}.certificate.json"]
        command = [sys.executable, "-I", checker.__file__, *paths]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
    told = (result.stdout or result.stderr).strip().rpartition("\n")[2].removeprefix("checker: ").replace(f"{folder}/", "")
    return Check(name, result.returncode == 0, told)


def _compared(controller: EmittedController) -> Check:
    """The compiled C beside the reference, quantity by quantity."""
    name = "compiled C beside an independent reference"
    try:
        rows: list[Row] = compare_backend(controller, CompiledC, POINTS)
    except SttError as error:
        return Check(name, None, str(error).partition("\n")[0])
    worst = max(rows, key=lambda r: r.share)
    total = sum(r.points for r in rows)
    told = f"{total:,} values; nearest to its derived bound: {worst.quantity}, at {worst.share:.0%} of it"
    return Check(name, all(r.holds for r in rows), told)


def _compiled(controller: EmittedController) -> Iterator[Check]:
    """Every C file under the strict flags, by every compiler that is here."""
    for compiler in COMPILERS:
        path = shutil.which(compiler)
        if path is None:
            yield Check(f"{compiler}, strict flags", None, "is not installed here")
            continue
        version = subprocess.run([path, "--version"], capture_output=True, text=True, check=False).stdout.partition("\n")[0]
        with tempfile.TemporaryDirectory() as folder:
            for file, data in controller.files.items():
                Path(folder, file).write_bytes(data)
            sources = sorted(p.name for p in Path(folder).glob("*.c"))
            command = [path, *STRICT, "-c", *sources]
            result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        told = (
            f"{version}: no warning in {', '.join(sources)}"
            if result.returncode == 0
            else result.stderr.strip()[:300].replace(f"{folder}/", "")
        )
        yield Check(f"{compiler}, strict flags", result.returncode == 0, told)


def _selftest(controller: EmittedController) -> Check:
    """The emitted self-test, compiled and run on this host."""
    name, prefix = "self-test on this host", controller.task.name
    if selftest_name(prefix) not in controller.files:
        return Check(name, None, "is not emitted; emit.selftest = true adds it")
    try:
        compiler = find_compiler()
    except SttError as error:
        return Check(name, None, str(error))
    with tempfile.TemporaryDirectory() as folder:
        for file, data in controller.files.items():
            Path(folder, file).write_bytes(data)
        Path(folder, "main.c").write_text(f'#include "{prefix}.h"\nint main(void) {{ return {prefix}_selftest(); }}\n')
        sources = ["main.c", f"{prefix}.c", selftest_name(prefix)]
        made = subprocess.run([compiler, *STRICT, *sources, "-o", "main", "-lm"], cwd=folder, capture_output=True, check=False)
        if made.returncode:
            return Check(name, False, "does not compile under the strict flags")
        try:
            code = subprocess.run([f"{folder}/main"], check=False, capture_output=True, timeout=SECONDS).returncode
        except subprocess.TimeoutExpired:
            return Check(name, False, f"does not end within {SECONDS} s")
    return Check(name, code == 0, "every vector within its enclosure" if code == 0 else f"vector {code} is off")


def not_shown(controller: EmittedController) -> Iterator[str]:
    """What no line of the report shows, for this task."""
    task, certificate = controller.task, controller.certificate
    shown = {one.subject for one in certificate.findings if one.holds}
    if not certificate.holds:
        yield "That this tube does its task (see the properties that fail), and that a controller keeps any state in it."
    elif Property.PERIOD not in shown:
        yield (
            "That your sampling is fast enough: the state stays in the tube by Theorem 4.1, in continuous time"
            + (", while u is not held within u_max" if task.u_max is not None else "")
            + "; what is proved of held inputs stands above under its own assumptions "
            + f"(control.period makes it {Property.PERIOD.label})."
        )
    if certificate.holds and task.u_max is not None and not shown & {Property.LIMITS, Property.PERIOD}:
        yield (
            "That u_max is enough: Theorem 4.1 assumes that u never reaches it "
            f"(bounds in [plant] make that {Property.LIMITS.label})."
        )
    if task.u_max is None:
        yield "That u is within what your actuators can do: nothing limits it but the clamp (control.u_max)."
    if Property.PERIOD in shown:
        yield (
            "That samples come every control.period or faster, that none is lost, that the first input acts at once and all "
            "others within control.latency."
        )
    else:
        yield "Anything about an input that acts later than at its sample, but for what stands above with its latency."
    stated = "the bounds of [plant]" if task.plant.is_stated else "what Theorem 4.1 asks of a plant"
    yield f"That your plant is within {stated}, and that nothing else acts on it."
    yield f"That there is no {'inertia or ' if task.order == 1 else ''}lag between u and what it moves."
    yield "That what you measure is the state" + (
        f", to {decimal(task.plant.noise)} at most." if task.plant.noise else ", without an error."
    )
    if controller.design.is_stateful:
        yield "That alpha begins with alpha_init at t = 0 and is stepped within the steps that the certificate names."
    if task.has_timed_sets:
        yield "That the sets are where and when the task says, by a clock that agrees with the controller's."
    if "outline" in task.expanded_keys:
        yield "That the sets fill what the outline leaves of its box: this tool's word; the checker reads them spelled out."
    if "map" in task.expanded_keys:
        yield "That the sets hold every occupied cell of the map: this tool's word; the checker reads them spelled out."
    if task.body is None:
        yield "Anything about a robot that has a size: the state is a point here (body)."
    calls = [name for name in library_calls(controller.files) if name != "memcpy"]
    yield (
        "That the compiler, its options and the C library do what C99, IEEE-754 and docs/c.md say"
        + (f": {', '.join(calls)} within 2 units in the last place." if calls else ".")
    )
    if task.repeat:
        yield "That a clock in seconds is right after many turns: its rounding adds up; ticks lose nothing."
