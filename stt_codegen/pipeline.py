"""The map: a task file becomes a certified controller in five calls.

    load_task       task.toml -> Task                      task/     the question, checked; sets by their normals and supports
    design_tube     Task -> Design                         design/   refined: route, sides, linear programs, rounding, and once
                                                                     more where P7 needs more than was left for it;
                                                                     adaptive: search; literal: the paper's rule
                                                           designs/  what a design is; constraints.py what it must satisfy;
                                                                     design_kinds.py what each kind offers to a task
    build_program   Task, Design -> Program                paper/ (equations in CasADi), controller/ (frames), program/
    certify         Task, Design, Program -> Certificate   certify/  refined: exact P1-P6, rounding bound P7; else enclosures
    render          all of these -> files                  emit/     C, Python, certificate (templates/ place the text)

Each stage is a plain function from frozen data to frozen data; no stage calls an earlier one. Where the tube or its certificate
fails, `certified_attempt` tries what the task leaves open (`design.alternatives`), and a refusal names changes of the task that
were tried to the end (remedies/). Other rooms use the result:

    reference.py, compare/      the same equations once more in plain NumPy, compared with every backend
    lemmas/                     the lemma book: statements about the Program that a machine proves
    sampling/, plants.py        what held inputs, late samples and noise do to a tube: sampling conditions, periods, gains
    report/, record/            what a person reads about a controller, and the files that keep it under check
    loop/, board/               the emitted C with a plant in closed loop, and on emulated boards; benchmarks/ measures both

Imports run one way: pyproject.toml has the order of all rooms, tests/test_layers.py checks it.
Long because the stages, and what follows where one of them fails, are read together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from stt_codegen.certify import Certificate
from stt_codegen.decimals import decimal
from stt_codegen.design_kinds import DesignKind, kinds_offering
from stt_codegen.designs import AdaptiveDesign, Design, RefinedDesign, for_any_design, require_design
from stt_codegen.effort import CHANGES_SHARE, TUBES_SHARE, Effort, EffortSpent, require_effort
from stt_codegen.errors import BadInput, NotCertified, Reason, about, noted
from stt_codegen.program import Program
from stt_codegen.task import Task, load_task, require_offered


class EmittedFiles(Mapping[str, bytes]):
    """Contents of files by name, which cannot be changed: a certificate has their hashes.

    They can be copied and pickled; `dict(files)` is a copy that you may change.
    """

    def __init__(self, contents: Mapping[str, bytes]) -> None:
        self._contents = dict(contents)

    def __getitem__(self, name: str) -> bytes:
        return self._contents[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._contents)

    def __len__(self) -> int:
        return len(self._contents)

    def __repr__(self) -> str:
        sizes = ", ".join(f"{name}: {len(data)} bytes" for name, data in self._contents.items())
        return f"<EmittedFiles {sizes}>"


@dataclass(frozen=True)
class EmittedController:
    """Everything that the pipeline makes of one task.

    files: cannot be changed. replaces: where the tube that the task prefers is not certified, a sentence on it and on the one
    that was taken.
    """

    task: Task
    design: Design
    program: Program
    certificate: Certificate
    files: Mapping[str, bytes]
    _: KW_ONLY
    replaces: str = ""

    def __post_init__(self) -> None:
        """Keep the files from changes, also where the caller has the dictionary that they were given in."""
        object.__setattr__(self, "files", EmittedFiles(self.files))


def build(
    path: str | Path,
    design: str | None = None,
    scalar: str | None = None,
    uncertified: bool = False,
    language: str | None = None,
    *,
    effort: Effort | None = None,
) -> EmittedController:
    """Make the controller of a task file; nothing is written.

    `design` and `scalar` replace the task's options. `language` adds a language to those that are printed. effort: of the search
    for another way, where the task is refused as it stands; 10 s without.

    Raises `BadInput` (exit code 2), and `NotCertified` (3) when the task is infeasible or, unless `uncertified`, when
    the certificate fails.
    """
    task = load_task(path)
    with about(path):
        task = task.with_options(design, scalar, language)
    with about(path), noted(task.map_notes):
        return build_task(task, uncertified, effort=effort)


def build_task(
    task: Task, uncertified: bool = False, tube: Design | None = None, *, effort: Effort | None = None
) -> EmittedController:
    """Make the controller of a task, as `build` does of a file. tube: a design to use instead of a search."""
    require_supported(task)
    if tube is None:
        result = certified_attempt(task, effort, accepts_failure=uncertified)
    else:
        require_design_for(task, tube)
        result = attempt(task, tube)
    certificate, program = result.certificate, result.program
    if not certificate.holds and not certificate.is_law_defined:
        too_narrow = "; the law divides by the tube's width: a tube narrower than 2^-18 is not written, --uncertified or not"
        raise NotCertified(certificate.refusal() + too_narrow)
    if not certificate.holds and not uncertified:
        raise NotCertified(certificate.reason)
    if not certificate.holds:
        from stt_codegen.controller import without_covered_starts

        program = without_covered_starts(program)
    files = render_files(result.task, result.design, program, certificate)
    return EmittedController(result.task, result.design, program, certificate, files, replaces=result.replaces)


# ----------------------------------------------------------------------------------------------- tubes that are certified

RELEASED_SECONDS = 3.0  # for the other tubes of a changed task; the next run has more for them


@dataclass(frozen=True)
class Attempt:
    """A tube with its program and certificate, which may fail. task: with what it leaves open chosen for the tube.

    replaces: as in EmittedController.
    """

    task: Task
    design: Design
    program: Program
    certificate: Certificate
    replaces: str = ""


def attempt(task: Task, design: Design) -> Attempt:
    """Return what a tube makes of the task."""
    chosen = with_chosen_control(task, design)
    program = build_program(chosen, design)
    return Attempt(chosen, design, program, certify(chosen, design, program))


def preferred_tube(task: Task) -> Design:
    """Find the tube that the task prefers, without its certificate. Raises `NotCertified` where there is none."""
    return STAGES[task.tube.design].design_tube(task)


def design_tube(task: Task, effort: Effort | None = None) -> Design:
    """Find a tube of the kind `tube.design`: one that is certified, where the task leaves one open.

    Raises `NotCertified` with the reason, and with changes that help, where there is no tube. Where there is one and its period
    or another property is not proved, that tube is returned, and its certificate says what fails.
    """
    return certified_attempt(task, effort, accepts_failure=True).design


def certified_attempt(task: Task, effort: Effort | None = None, *, accepts_failure: bool = False) -> Attempt:
    """Return the preferred tube of a task, or where it is not certified the first other one that is.

    Raises `NotCertified` where there is none, with changes of the task that were tried to the end. accepts_failure: return the
    preferred tube where its certificate fails and no other holds.
    """
    effort = effort or Effort()
    first, refusal = _first_attempt(task)
    if first is not None and first.certificate.holds:
        return first
    reason, result, is_stopped, has_tried_all = refusal.reason, None, False, True
    effort.begin_search(reason.problem)
    try:
        with effort.limit(TUBES_SHARE):
            result = _other_attempt(task, None if first is None else first.design)
    except EffortSpent:
        has_tried_all = False
    except KeyboardInterrupt:
        if not effort.ends_on_interrupt:
            raise
        is_stopped = True
    if result is not None:
        return replace(result, replaces=_replacement_sentence(result, first, reason.problem))
    if first is not None and accepts_failure and not is_stopped:
        return first
    if not is_stopped:
        reason = _with_remedies(task, reason, effort)
    if not has_tried_all and reason.has_remedy:
        longer = f" ({effort.longer})" if effort.longer else ""
        reason = replace(reason, hint=f"{reason.hint}; of the tubes that the task leaves open not all were tried{longer}")
    if first is not None and first.certificate.is_law_defined and effort.as_it_is:
        reason = replace(reason, hint=f"{reason.hint} ({effort.as_it_is})".lstrip())
    raise NotCertified(reason)


def _first_attempt(task: Task) -> tuple[Attempt | None, NotCertified]:
    """Return the attempt with the preferred tube, None where there is none, and the refusal for the case that it fails."""
    try:
        first = attempt(task, preferred_tube(task))
    except NotCertified as refusal:
        return None, refusal
    return first, NotCertified(lambda: first.certificate.reason)


def _other_attempt(task: Task, first: Design | None) -> Attempt | None:
    """Return the first of the other tubes that the task leaves open which is certified; None where none is.

    Their order is fixed, so the time decides whether a certified tube is reached, and never which. Raises `EffortSpent` where the
    time is over.
    """
    alternatives = STAGES[task.tube.design].alternatives
    if alternatives is None:
        return None
    with suppress(NotCertified):
        for design in alternatives(task, first):
            with suppress(BadInput):  # integers may not hold this tube's numbers
                result = _certified_with(task, design)
                if result is not None:
                    return result
    return None


def _replacement_sentence(taken: Attempt, first: Attempt | None, problem: str) -> str:
    """Say why the tube that the task prefers was not taken, and what the tube that was taken has in its place."""
    if first is None:
        return f"the preferred tube is not certified ({problem}); another one was taken"
    measures = (
        ("least width", *(float(a.certificate.minimum_width) for a in (taken, first))),
        ("peak speed", *(float(max(a.certificate.speed)) for a in (taken, first))),
    )
    changes = [f"{name} {new:.4g} in place of {old:.4g}" for name, new, old in measures if f"{new:.4g}" != f"{old:.4g}"]
    if taken.design.size != first.design.size:
        changes.append(f"{taken.design.size} in place of {first.design.size}")
    if taken.design.filter != first.design.filter:
        changes.append("other filter rates")
    if not changes:
        changes.append("another plan")
    return f"the preferred tube is not certified ({problem}); taken: one with {', '.join(changes)}"


def _certified_with(task: Task, design: Design) -> Attempt | None:
    """Return what a tube makes of the task; None where it is not certified, which is known sooner than all that fails."""
    require_effort()
    may_hold = STAGES[design.kind].may_hold
    if may_hold is not None and not may_hold(task, design):
        return None
    result = attempt(task, design)
    return result if result.certificate.holds else None


def _with_remedies(task: Task, reason: Reason, effort: Effort) -> Reason:
    """Return the reason with changes of the task that were tried to the end, in place of the hint what may help."""
    from stt_codegen.remedies import CertificationTests, find_remedies

    if not reason.has_remedy:
        return reason
    tests = CertificationTests(_quick_test(task), lambda changed: _is_certified(changed, task))
    with effort.limit(CHANGES_SHARE):
        remedies = find_remedies(task, reason, tests, effort.ends)
    return replace(reason, hint=remedies.sentence(reason.hint, effort.longer))


def _quick_test(original: Task) -> Callable[[Task], bool]:
    """Return a test whether a changed task has a tube, and whether the input is strong and quick enough for it.

    It remembers its answers, for many changes of a task leave its tube as it is.
    """
    answers: dict[tuple[object, ...], bool] = {}

    def may_be_certified(task: Task) -> bool:
        """Return the answer for one task; it may be yes where the change leaves other tubes open."""
        require_supported(task)
        if _leaves_more_tubes_open(task, original):
            return True
        with suppress(NotCertified):
            design = preferred_tube(task)
            may_hold = STAGES[design.kind].may_hold
            if may_hold is None:
                return attempt(task, design).certificate.holds
            key = (design, task.control, task.plant, task.emit.scalar, task.initial_set.share)
            if key not in answers:
                answers[key] = may_hold(task, design)
            return answers[key]
        return False

    return may_be_certified


def _is_certified(task: Task, original: Task) -> bool:
    """Return whether a changed task is certified with its preferred tube, or with another one that only the change leaves open.

    Raises `BadInput` where it fits together no longer.
    """
    require_supported(task)
    first, _ = _first_attempt(task)
    if first is not None and first.certificate.holds:
        return True
    if not _leaves_more_tubes_open(task, original):
        return False
    with suppress(EffortSpent), Effort(RELEASED_SECONDS).limit(1.0):
        return _other_attempt(task, None if first is None else first.design) is not None
    return False


def _leaves_more_tubes_open(task: Task, original: Task) -> bool:
    """Return whether a changed task leaves an option of the tube open that the original states."""
    return any(_is_stated(original, key) and not _is_stated(task, key) for key in ("prefer", "filter", "segments"))


def _is_stated(task: Task, key: str) -> bool:
    tube = task.as_stated.tube
    return key in tube.model_fields_set and getattr(tube, key) not in (None, "auto")


def require_supported(task: Task) -> None:
    """Raise `BadInput` where the task uses an option that its kind of tube does not offer."""
    offered = task.tube.capabilities
    if task.emit.math == "inline" and not offered.inlines_logarithm:
        raise BadInput(
            f'emit.math: "inline" is for {kinds_offering("inlines_logarithm")} tubes; {task.tube.design} ones need exp and log1p '
            'of the C library, use "libm"'
        )
    if task.emit.tick_period is not None and not offered.counts_ticks:
        raise BadInput(
            f"emit.tick_period: is for {kinds_offering('counts_ticks')} tubes, whose time is a table index; the circumvent "
            f"functions of {task.tube.design} ones take seconds, leave it out"
        )
    if task.control.period is not None and not offered.proves_periods:
        kinds = kinds_offering("proves_periods")
        raise BadInput(f"control.period: is proved for {kinds} tubes only; leave it out for a {task.tube.design} one")
    require_offered(task, offered)


def require_design_for(task: Task, tube: Design) -> None:
    """Raise `BadInput` where it is no tube, or not of the kind, dimension, order, time or cycle that the task states.

    What a certificate must prove depends on the kind: one that proves no period would hold for a task that asks for one.
    """
    require_design(tube)
    if tube.kind != task.tube.design:
        raise BadInput(
            f'tube: is of the kind "{tube.kind}"; the task has tube.design = "{task.tube.design}", design the tube for this task'
        )
    if tube.dimension != task.dimension:
        raise BadInput(f"tube: has dimension {tube.dimension}; the task has {task.dimension}, design the tube for this task")
    if (order := 2 if tube.filter else 1) != task.order:
        raise BadInput(
            f"tube: is for a plant of order {order}; the task's is of order {task.order}, design the tube for this task"
        )
    if tube.prescribed_time != task.prescribed_time:
        raise BadInput(
            f"tube: ends at {decimal(tube.prescribed_time)} s; the task has prescribed_time = {decimal(task.prescribed_time)}, "
            "design the tube for this task"
        )
    if (tube.cycle_begin is not None) != task.repeat:
        ends = "ends at t_c" if tube.cycle_begin is None else "repeats its last part for ever"
        raise BadInput(f"tube: {ends}; the task has repeat = {str(task.repeat).lower()}, design the tube for this task")


def with_chosen_control(task: Task, design: Design) -> Task:
    """Return the task with what a task with a period leaves open chosen for this tube: its plant, the limit of u, the gain."""
    choose_control = STAGES[design.kind].choose_control
    return task if choose_control is None else choose_control(task, design)


def build_program(task: Task, design: Design) -> Program:
    """Return the controller as typed single assignments, which every printer and prover reads."""
    return STAGES[design.kind].build_program(task, design)


def certify(task: Task, design: Design, program: Program) -> Certificate:
    """Certify the tube and the program: P1 to P7, P8 with limits, P9 with a period, P10 with a mission, each with its margin.

    The certificate may fail; `build` decides what follows from that. Raises `BadInput` where the task makes a demand that
    tubes of this kind do not fulfil: their certificate would say nothing of it.
    """
    require_offered(task, design.capabilities)
    return replace(STAGES[design.kind].certify(task, design, program), axes=task.axis_words)


def render_files(task: Task, design: Design, program: Program, certificate: Certificate) -> dict[str, bytes]:
    """Return the contents of the emitted files by name."""
    from stt_codegen.emit import render

    return render(task, design, program, certificate)


# ------------------------------------------------------------------------------------------------ the stages by kind


@dataclass(frozen=True)
class Stages:
    """The functions that design, program and certify a tube of one kind.

    choose_control: the task with what it leaves open chosen for the tube; None for a kind that proves no periods. alternatives:
    other tubes of a task, for the case that its first is not certified; None for a kind that has one. may_hold: whether the input
    is strong and quick enough, in a small part of the time of a certificate that fails; None for a kind that has no such test.
    """

    design_tube: Callable[[Task], Design]
    build_program: Callable[[Task, Design], Program]
    certify: Callable[[Task, Design, Program], Certificate]
    choose_control: Callable[[Task, Design], Task] | None = None
    _: KW_ONLY
    alternatives: Callable[[Task, Any], Iterator[Design]] | None = None
    may_hold: Callable[[Task, Design], bool] | None = None


def _design_refined(task: Task) -> Design:
    """Return the preferred tube. Where control.u_norm is open without a period, the tube is first found without limits of u.

    Where no shares of the norm are enough for it (P8), the tube is designed once more, within the shares of the first.
    """
    from stt_codegen.certify import outweighs_disturbances
    from stt_codegen.design import refine

    design = with_enough_allowance(task, refine(task))
    task_with_limits = _with_norm_shares(task, design)
    if task_with_limits is task or outweighs_disturbances(task_with_limits, design):
        return design
    with suppress(NotCertified):
        return with_enough_allowance(task_with_limits, refine(task_with_limits))
    return design


def _with_norm_shares(task: Task, design: RefinedDesign) -> Task:
    """Return the task without a period with each component's share of control.u_norm; any other task as it is."""
    from stt_codegen.certify import with_shares_of_norm

    is_open = task.has_automatic_limit and task.control.period is None
    return with_shares_of_norm(task, design) if is_open else task


def _refined_alternatives(task: Task, first: RefinedDesign | None) -> Iterator[RefinedDesign]:
    from stt_codegen.design import alternatives

    return (with_enough_allowance(task, design) for design in alternatives(task, first))


def with_enough_allowance(task: Task, design: RefinedDesign) -> RefinedDesign:
    """Return the design, or a wider one where the edges are so fast that rounding needs more than the design left for it.

    The edges of the wider one are certified. Where there is none, the design stays, and its certificate says what is missing.
    """
    from stt_codegen.certify.rounding_allowance import certify_edges, needed_allowance_factor
    from stt_codegen.design import refine_with_allowance

    factor = needed_allowance_factor(task, design)
    wider_design = None if factor == 1 else refine_with_allowance(task, factor)
    return design if wider_design is None or not certify_edges(task, wider_design).holds else wider_design


def _refined_program(task: Task, design: RefinedDesign) -> Program:
    if task.emit.scalar == "fixed":
        from stt_codegen.controller.integers import fixed_program

        return within_32_bits(fixed_program(task, design))
    from stt_codegen.controller import refined_program

    return refined_program(task, design)


def _choose_refined_control(task: Task, design: RefinedDesign) -> Task:
    from stt_codegen.certify.sampled import choose_control

    if task.control.period is None:
        return _with_norm_shares(task, design)
    if not (task.assumes_plant or task.has_automatic_limit or task.has_automatic_gain):
        return task
    return choose_control(task, design, *_errors_before_choice(task, design))


def _errors_before_choice(task: Task, design: RefinedDesign) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """Return bounds on the arithmetic's error of an edge and of its rate, before there is a gain."""
    from stt_codegen.controller import edge_and_rate_errors

    if task.emit.scalar == "fixed":  # a control law in integers has no constants before there is a gain
        return edge_and_rate_errors(design, None, task.emit.tick_period)
    return edge_and_rate_errors(design, _refined_program(task, design))


def _may_hold_refined(task: Task, design: RefinedDesign) -> bool:
    from stt_codegen.certify import outweighs_disturbances
    from stt_codegen.certify.sampled import is_any_control_proved

    if not outweighs_disturbances(_with_norm_shares(task, design), design):
        return False
    return task.control.period is None or is_any_control_proved(task, design, *_errors_before_choice(task, design))


def within_32_bits(program: Program) -> Program:
    """Return the program of integers after a proof that none of them leaves 32 bits, for any arguments.

    Raises `BadInput` where there is no such proof.
    """
    from stt_codegen.program.analyse import OutOfRange, ranges

    for function in program.functions:
        try:
            ranges(program, function.name)
        except OutOfRange as problem:
            raise BadInput(f'emit.scalar: "fixed" has too few bits for this task ({problem}); use "float"') from problem
    return program


def _certify_refined(task: Task, design: RefinedDesign, program: Program) -> Certificate:
    from stt_codegen.certify.exact import certify_emitted

    return certify_emitted(task, design, program)


def _design_adaptive(task: Task) -> Design:
    from stt_codegen.design.paper_tubes import design_adaptive

    return design_adaptive(task)


def _design_literal(task: Task) -> Design:
    from stt_codegen.design.paper_tubes import design_literal

    return design_literal(task)


def _adaptive_program(task: Task, design: AdaptiveDesign) -> Program:
    from stt_codegen.controller import adaptive_program

    return adaptive_program(task, design)


def _certify_adaptive(task: Task, design: AdaptiveDesign, _program: Program) -> Certificate:
    """Look for a failure at samples, which is quick and certain; where there is none, prove by enclosures."""
    from stt_codegen.certify.adaptive import certify_enclosed, falsify

    falsified = falsify(task, design)
    return falsified if falsified.failures else certify_enclosed(task, design)


_OF_ADAPTIVE = (for_any_design(AdaptiveDesign, _adaptive_program), for_any_design(AdaptiveDesign, _certify_adaptive))
STAGES: Mapping[DesignKind, Stages] = {
    "refined": Stages(
        _design_refined,
        for_any_design(RefinedDesign, _refined_program),
        for_any_design(RefinedDesign, _certify_refined),
        for_any_design(RefinedDesign, _choose_refined_control),
        alternatives=_refined_alternatives,
        may_hold=for_any_design(RefinedDesign, _may_hold_refined),
    ),
    "adaptive": Stages(_design_adaptive, *_OF_ADAPTIVE),
    "literal": Stages(_design_literal, *_OF_ADAPTIVE),
}
