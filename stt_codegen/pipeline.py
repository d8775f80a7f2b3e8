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

Each stage is a plain function from frozen data to frozen data; no stage calls an earlier one. Other rooms use the result:

    reference.py, compare/      the same equations once more in plain NumPy, compared with every backend
    lemmas/                     the lemma book: statements about the Program that a machine proves
    sampling/, plants.py        what held inputs, late samples and noise do to a tube: sampling conditions, periods, gains
    report/, record/            what a person reads about a controller, and the files that keep it under check
    loop/, board/               the emitted C with a plant in closed loop, and on emulated boards; benchmarks/ measures both

Imports run one way: pyproject.toml has the order of all rooms, tests/test_layers.py checks it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from stt_codegen.certify import Certificate
from stt_codegen.decimals import decimal
from stt_codegen.design_kinds import DesignKind, kinds_offering
from stt_codegen.designs import AdaptiveDesign, Design, RefinedDesign, for_any_design, require_design
from stt_codegen.errors import BadInput, NotCertified, about, noted
from stt_codegen.program import Program
from stt_codegen.task import Task, load_task, require_offered


@dataclass(frozen=True)
class EmittedController:
    """Everything that the pipeline makes of one task."""

    task: Task
    design: Design
    program: Program
    certificate: Certificate
    files: dict[str, bytes]


def build(
    path: str | Path,
    design: str | None = None,
    scalar: str | None = None,
    uncertified: bool = False,
    language: str | None = None,
) -> EmittedController:
    """Make the controller of a task file; nothing is written.

    `design` and `scalar` replace the task's options. `language` adds a language to those that are printed.

    Raises `BadInput` (exit code 2), and `NotCertified` (3) when the task is infeasible or, unless `uncertified`, when
    the certificate fails.
    """
    task = load_task(path)
    with about(path):
        task = task.with_options(design, scalar, language)
    with about(path), noted(task.map_notes):
        return build_task(task, uncertified)


def build_task(task: Task, uncertified: bool = False, tube: Design | None = None) -> EmittedController:
    """Make the controller of a task, as `build` does of a file. tube: a design to use instead of a search."""
    require_supported(task)
    if tube is not None:
        require_design_for(task, tube)
    design = design_tube(task) if tube is None else tube
    task = with_chosen_control(task, design)
    program = build_program(task, design)
    certificate = certify(task, design, program)
    if not certificate.holds and not certificate.is_law_defined:
        too_narrow = "; the law divides by the tube's width: a tube narrower than 2^-18 is not written, --uncertified or not"
        raise NotCertified(certificate.refusal() + too_narrow)
    if not certificate.holds and not uncertified:
        raise NotCertified(certificate.refusal() + " (or --uncertified writes it with a banner)")
    if not certificate.holds:
        from stt_codegen.controller import without_covered_starts

        program = without_covered_starts(program)
    return EmittedController(task, design, program, certificate, render_files(task, design, program, certificate))


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


def design_tube(task: Task) -> Design:
    """Find a tube of the kind `tube.design`. Raises `NotCertified` with the reason where there is none."""
    return STAGES[task.tube.design].design_tube(task)


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

    choose_control: the task with what it leaves open chosen for the tube; None for a kind that proves no periods.
    """

    design_tube: Callable[[Task], Design]
    build_program: Callable[[Task, Design], Program]
    certify: Callable[[Task, Design, Program], Certificate]
    choose_control: Callable[[Task, Design], Task] | None = None


def _design_refined(task: Task) -> Design:
    from stt_codegen.design import refine

    return with_enough_allowance(task, refine(task))


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
    from stt_codegen.controller import edge_and_rate_errors

    if not (task.assumes_plant or task.has_automatic_limit or task.has_automatic_gain):
        return task
    if task.emit.scalar == "fixed":  # a control law in integers has no constants before there is a gain
        return choose_control(task, design, *edge_and_rate_errors(design, None, task.emit.tick_period))
    return choose_control(task, design, *edge_and_rate_errors(design, _refined_program(task, design)))


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
    ),
    "adaptive": Stages(_design_adaptive, *_OF_ADAPTIVE),
    "literal": Stages(_design_literal, *_OF_ADAPTIVE),
}
