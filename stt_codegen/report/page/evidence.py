"""Run the evidence of the page for an assessor: stand-alone checker, compilers, reference, self-test, MISRA.

Every number comes from this run; where a tool is missing, the row says so. `report` and report/page/page.py use it.

Long because every row of the page's evidence, and what no row proves, is in one place.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from stt_codegen.certify import Finding
from stt_codegen.certify.sampled import drive_words
from stt_codegen.checker import archive
from stt_codegen.compare import ComparisonRow, compare_backend
from stt_codegen.decimals import by_component, by_dimension, decimal
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.emit import selftest_name, spelled_name
from stt_codegen.errors import SttError
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.c.runner import STRICT, CompiledC, find_compiler
from stt_codegen.properties import OF_THE_INPUT, Property
from stt_codegen.report.figures import assumed_words
from stt_codegen.report.page.bill_of_materials import library_calls
from stt_codegen.report.page.misra import DEVIATIONS, count_deviations
from stt_codegen.task import Task

COMPILERS = ("gcc", "clang")
SELFTEST_TIME_LIMIT = 60  # seconds
RANDOM_POINTS = 2000  # of the comparison with the reference, beside points at the edges
PROOFS = {  # by method of the certificate
    "exact": "exact rational arithmetic on the coefficients in the C",
    "enclosure": "enclosures of the emitted statements",
    "sampled": "samples, which prove nothing between them",
}


@dataclass(frozen=True, kw_only=True)
class Requirement:
    """A row of the table that leads from what the task requires to the margin of the certificate.

    proof: how the certificate proves it; second_check: what computes it again. All are texts but `holds`.
    """

    requirement: str
    label: str
    statement: str
    holds: bool
    proof: str
    second_check: str
    margin: str


@dataclass(frozen=True)
class Check:
    """A check that was run. has_passed: None where it could not be run. message: its result, or why it was not run."""

    name: str
    has_passed: bool | None
    message: str


class MisraDeviation(NamedTuple):
    """A row of the table of deviations. place_count: places in the C; where: the names there."""

    rule: str
    place_count: int
    kind: str
    where: str
    why: str


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What was run for a page. misra: None without cppcheck; unlisted: rules that are broken without a stated reason.

    flags: of the compilers. not_shown: sentences on what no row proves.
    """

    requirements: tuple[Requirement, ...]
    checks: tuple[Check, ...]
    misra: tuple[MisraDeviation, ...] | None
    unlisted: tuple[str, ...]
    flags: str
    not_shown: tuple[str, ...]

    @property
    def has_no_failure(self) -> bool:
        """Whether no check failed and every deviation from MISRA has a reason."""
        return all(check.has_passed is not False for check in self.checks) and not self.unlisted


def evidence(controller: EmittedController, source: Path | None = None, boards: Sequence[Check] = ()) -> Evidence:
    """Run all checks whose tools are installed. source: the task file, for the stand-alone checker; boards: checks on boards."""
    stand_alone = _run_stand_alone_checker(controller, source)
    compared = _compare_with_reference(controller)
    counts = count_deviations(controller.files)
    return Evidence(
        requirements=tuple(_requirements(controller, stand_alone, compared)),
        checks=(stand_alone, compared, *_compile_strictly(controller), _run_selftest(controller), *boards),
        misra=None if counts is None else _listed_deviations(controller, counts),
        unlisted=tuple(rule for rule in counts or () if rule not in DEVIATIONS),
        flags=" ".join(STRICT),
        not_shown=tuple(unproved_statements(controller)),
    )


def _listed_deviations(controller: EmittedController, counts: Mapping[str, int]) -> tuple[MisraDeviation, ...]:
    """Return the deviations with a stated reason. counts: places by rule."""
    text, prefix = b"\n".join(controller.files.values()).decode(), controller.task.name
    listed = ((rule, count, DEVIATIONS[rule]) for rule, count in counts.items() if rule in DEVIATIONS)
    return tuple(
        MisraDeviation(rule, count, deviation.kind, _names_in_file(deviation.where, prefix, text), deviation.why)
        for rule, count, deviation in listed
    )


def _names_in_file(where: str, prefix: str, text: str) -> str:
    """Write the names of a deviation for this task, without those of several that the C does not have."""
    description = where.replace("<p>", prefix).replace("<P>", prefix.upper())
    names = re.findall(r"`(\w+)`", description)
    absent = [name for name in names if name not in text] if len(names) > 1 else []
    for name in absent:
        description = description.replace(f", `{name}`", "").replace(f"`{name}`, ", "")
    return description.replace("`", "")


def _requirements(controller: EmittedController, stand_alone: Check, compared: Check) -> Iterator[Requirement]:
    """Yield a row for each property of the certificate."""
    certificate = controller.certificate
    checker_passed = "the stand-alone checker, from the C" if stand_alone.has_passed else "nothing else here"
    for finding in certificate.findings:
        proof = PROOFS[certificate.method]
        second_check = checker_passed
        if finding.subject is Property.ARITHMETIC:
            proof = "a derived bound on every rounding"
            second_check += ", and the compiled C beside a reference" if compared.has_passed else ""
        elif finding.subject is Property.PERIOD:
            proof = "intervals over every time window, with the theorem of the lemma book"
        yield Requirement(
            requirement=requirement_of(controller, finding),
            label=finding.subject.label,
            statement=finding.statement,
            holds=finding.holds,
            proof=proof,
            second_check=second_check,
            margin=format_margin(finding),
        )


def format_margin(finding: Finding) -> str:
    """Return the margin of a property, with its unit if that is seconds; negative where the property fails."""
    return f"{float(finding.margin):.3g}{' s' if finding.is_in_seconds else ''}" if finding.margin else ""


def _clearance_requirement(task: Task) -> str:
    clearances = by_dimension(task.clearances)
    if len(set(task.clearances)) > 1:
        return f"The tube, grown by {clearances} to both sides, meets none of {len(task.unsafe)} unsafe sets."
    return f"The tube keeps {clearances} from each of {len(task.unsafe)} unsafe sets."


def requirement_of(controller: EmittedController, finding: Finding) -> str:
    """Return the requirement of the task that a property is about, as a sentence."""
    task = controller.task
    texts = {
        Property.WIDTH: f"The tube is nowhere narrower than tube.min_width = {by_component(task.min_widths)}.",
        Property.AVOID: _clearance_requirement(task),
        Property.ARITHMETIC: f"All this holds in {controller.program.scalar} arithmetic.",
        Property.PERIOD: f"control.period = {decimal(task.control.period or Fraction(0))} s is short enough.",
    }
    if any(task.half_extents):
        texts[Property.STAY] = "The tube stays in state_space, the body with it."
    if task.target_set is None:
        texts[Property.REACH] = "The tube ends where the mission lets it."
    return texts.get(finding.subject, finding.subject.sentence)


def _run_stand_alone_checker(controller: EmittedController, source: Path | None) -> Check:
    """Run the checker as packages have it, in a process of its own that imports nothing of this package."""
    name, prefix = "stand-alone checker", controller.task.name
    if not controller.design.capabilities.has_exact_claims:
        return Check(name, None, f"is for {kinds_offering('has_exact_claims')} tubes; this one is {controller.design.kind}")
    if source is None and controller.task.expanded_text is None:
        return Check(name, None, "reads the task's file; this task was made without one")
    with tempfile.TemporaryDirectory() as folder:
        for file, data in controller.files.items():
            Path(folder, file).write_bytes(data)
        task_file = (
            source if controller.task.expanded_text is None else f"{folder}/{spelled_name(prefix)}"
        )  # has no map or outline
        Path(folder, archive.ARCHIVE_NAME).write_bytes(archive.archive_bytes())
        paths = [str(task_file), f"{folder}/{prefix}.c", f"{folder}/{prefix}.certificate.json"]
        command = [sys.executable, "-I", "-S", f"{folder}/{archive.ARCHIVE_NAME}", *paths]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
    last_line = (result.stdout or result.stderr).strip().rpartition("\n")[2]
    message = last_line.removeprefix("checker: ").replace(f"{folder}/", "")
    return Check(name, result.returncode == 0, message)


def _compare_with_reference(controller: EmittedController) -> Check:
    """Compare the compiled C with an independent reference, quantity by quantity."""
    name = "compiled C beside an independent reference"
    try:
        rows: list[ComparisonRow] = compare_backend(controller, CompiledC, RANDOM_POINTS)
    except SttError as error:
        return Check(name, None, str(error).partition("\n")[0])
    worst = max(rows, key=lambda r: r.share)
    total = sum(r.points for r in rows)
    message = f"{total:,} values; nearest to its derived bound: {worst.quantity}, at {worst.share:.0%} of it"
    return Check(name, all(r.holds for r in rows), message)


def _compile_strictly(controller: EmittedController) -> Iterator[Check]:
    """Compile every C file under the strict flags, with every compiler that is installed."""
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
        message = (
            f"{version}: no warning in {', '.join(sources)}"
            if result.returncode == 0
            else result.stderr.strip()[:300].replace(f"{folder}/", "")
        )
        yield Check(f"{compiler}, strict flags", result.returncode == 0, message)


def _run_selftest(controller: EmittedController) -> Check:
    """Compile the emitted self-test and run it on this host."""
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
        command = [compiler, *STRICT, *sources, "-o", "main", "-lm"]
        compilation = subprocess.run(command, cwd=folder, capture_output=True, check=False)
        if compilation.returncode:
            return Check(name, False, "does not compile under the strict flags")
        try:
            code = subprocess.run([f"{folder}/main"], check=False, capture_output=True, timeout=SELFTEST_TIME_LIMIT).returncode
        except subprocess.TimeoutExpired:
            return Check(name, False, f"does not end within {SELFTEST_TIME_LIMIT} s")
    return Check(name, code == 0, "every vector within its enclosure" if code == 0 else f"vector {code} is off")


def unproved_statements(controller: EmittedController) -> Iterator[str]:
    """Yield sentences on what nothing in the report proves about this task, each beginning with "That" or "Anything"."""
    task, certificate = controller.task, controller.certificate
    proved = {finding.subject for finding in certificate.findings if finding.holds}
    yield from _unproved_of_control(controller, proved)
    yield from _unproved_of_the_plant(controller)
    yield from _unproved_of_the_task(task)
    calls = [name for name in library_calls(controller.files) if name != "memcpy"]
    yield (
        "That the compiler, its options and the C library do what C99, IEEE-754 and docs/c.md say"
        + (f": {', '.join(calls)} within 2 units in the last place." if calls else ".")
    )
    if task.repeat:
        yield "That a clock in seconds is right after many turns: its rounding adds up; ticks lose nothing."


def _unproved_of_control(controller: EmittedController, proved: set[Property]) -> Iterator[str]:
    """Yield what is not proved of sampling, of the limits of u and of input delays."""
    task, certificate = controller.task, controller.certificate
    if not certificate.holds:
        yield "That this tube does its task (see the properties that fail), and that a controller keeps any state in it."
    elif Property.PERIOD not in proved:
        yield (
            "That your sampling is fast enough: the state stays in the tube by Theorem 4.1, in continuous time"
            + (", while u is not held within u_max" if task.u_max is not None else "")
            + "; what is proved of held inputs stands above under its own assumptions "
            + f"(control.period makes it {Property.PERIOD.label})."
        )
    if certificate.holds and task.u_max is not None and not proved & OF_THE_INPUT:
        yield (
            "That u_max is enough: Theorem 4.1 assumes that u never reaches it "
            f"(bounds in [plant] make that {Property.LIMITS.label})."
        )
    if task.u_max is None:
        yield "That u is within what your actuators can do: nothing limits it but the clamp (control.u_max)."
    if Property.PERIOD in proved:
        yield (
            "That samples come every control.period or faster, that none is lost, that the first input acts at once and all "
            "others within control.latency."
        )
    else:
        yield "Anything about an input that acts later than at its sample, but for what stands above with its latency."


def _unproved_of_the_plant(controller: EmittedController) -> Iterator[str]:
    """Yield what is assumed of plant, actuators, sensors and alpha."""
    task = controller.task
    stated = "the bounds of [plant]" if task.plant.is_stated else "what Theorem 4.1 asks of a plant"
    if task.assumes_plant:
        stated = f"bounds that are assumed, as [plant] states no bounds: {assumed_words(task)}"
    yield f"That your plant is within {stated}, and that nothing else acts on it."
    if task.has_drive:
        yield f"That what acts of u is as stated: {'; '.join(drive_words(task))}."
        yield "That the drive does not saturate below control.u_max and does not wind up. The page's own plant acts at once."
    else:
        yield f"That there is no {'inertia or ' if task.order == 1 else ''}lag between u and what it moves."
    yield "That what you measure is the state" + (
        f", to {by_dimension(task.noise)} at most." if any(task.noise) else ", without an error."
    )
    if controller.design.is_stateful:
        yield "That alpha begins with alpha_init at t = 0 and is stepped within the steps that the certificate names."


def _unproved_of_the_task(task: Task) -> Iterator[str]:
    """Yield what is assumed of sets, maps and the robot's size."""
    if task.has_timed_sets:
        yield "That the sets are where and when the task says, by a clock that agrees with the controller's."
    if "outline" in task.expanded_keys:
        yield "That the sets fill what the outline leaves of its box: this tool's word; the checker reads them spelled out."
    if "map" in task.expanded_keys:
        yield "That the sets hold every occupied cell of the map: this tool's word; the checker reads them spelled out."
    if task.body is None:
        yield "Anything about a robot that has a size: the state is a point here (body)."
