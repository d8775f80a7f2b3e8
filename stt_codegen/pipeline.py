"""The map: a task file becomes a certified controller in five calls.

    load_task       task.toml -> Task                      task/     the question, checked; sets by their normals and supports
    design_tube     Task -> Design                         design/   refined: route, sides, linear programs, rounding;
                                                                     adaptive: search; literal: the paper's rule
                                                           designs/  what a design is; rows.py what it must satisfy
    build_program   Task, Design -> Program                paper/ (equations in CasADi), controller/ (frames), program/
    certify         Task, Design, Program -> Certificate   certify/  refined: exact P1-P6, rounding bound P7; else enclosures
    render          all of these -> files                  emit/     C, Python, certificate (templates/ place the text)

Each stage is a plain function from frozen data to frozen data; none reaches back. What stands beside it:

    reference.py, compare/      the same equations once more in plain NumPy, and every backend held against them
    lemmas/                     the lemma book: what all of this rests on, proved about the Program
    sampling/, plants.py        what held inputs, late samples and noise do to a tube: statements, periods, gains
    report/, record/            what is told of a controller, and how it is kept under check
    loop/, board/, bench/       the emitted C driving a plant, run on emulated boards, measured by the hundred

Imports run one way; the order of all rooms stands in pyproject.toml and is tested.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from stt_codegen.certify.certificate import Certificate
from stt_codegen.designs import AdaptiveDesign, RefinedDesign
from stt_codegen.errors import BadInput, NotCertified, about
from stt_codegen.program import Program
from stt_codegen.task import Task, load_task

Design = RefinedDesign | AdaptiveDesign
MORE_ROOM = 8  # times the room for rounding that usually does


@dataclass(frozen=True)
class Controller:
    """Everything that the pipeline makes of one task."""

    task: Task
    design: Design
    program: Program
    certificate: Certificate
    files: dict[str, bytes]


def build(
    path: str | Path, design: str | None = None, scalar: str | None = None, uncertified: bool = False, rust: bool = False
) -> Controller:
    """From a task file to a controller's files (nothing is written). `design` and `scalar` override the task's options, `rust`
    adds the Rust.

    Raises `BadInput` (exit code 2), and `NotCertified` (3) when the task is infeasible or, unless `uncertified`, when
    the certificate fails.
    """
    task = load_task(path)
    with about(path):
        task = task.with_options(design, scalar, rust)
    with about(path):
        return build_task(task, uncertified)


def build_task(task: Task, uncertified: bool = False, tube: Design | None = None) -> Controller:
    """As `build`, for a task already loaded; `tube`: one that is there already, in place of the search."""
    require_supported(task)
    design, given = tube or design_tube(task), task
    task = settled(task, design)
    program = build_program(task, design)
    certificate = certify(task, design, program)
    if tube is None and certificate.lacks_rounding:  # a tube so fast that time's rounding takes more than is left for it
        with suppress(NotCertified):
            other = design_tube(given, MORE_ROOM)
            settled_ = settled(given, other)
            made = build_program(settled_, other)
            found = certify(settled_, other, made)
            if found.holds:
                task, design, program, certificate = settled_, other, made, found
    if not certificate.holds and not uncertified:
        raise NotCertified(certificate.refusal() + " (or --uncertified writes it with a banner)")
    return Controller(task, design, program, certificate, render_files(task, design, program, certificate))


def require_supported(task: Task) -> None:
    """Refuse what the task format knows and this version cannot do yet, rather than leave it out silently."""
    if task.emit.math == "inline" and task.tube.design != "refined":
        raise BadInput(
            f'emit.math: "inline" is for refined tubes; {task.tube.design} ones need exp and log1p of the C library, use "libm"'
        )
    if task.emit.tick_period is not None and task.tube.design != "refined":
        raise BadInput(
            "emit.tick_period: is for refined tubes, whose time is a table index; the circumvent functions of "
            f"{task.tube.design} ones take seconds, leave it out"
        )
    if task.control.period is not None and task.tube.design != "refined":
        raise BadInput(f"control.period: is proved for refined tubes only; leave it out for a {task.tube.design} one")


def settled(task: Task, design: Design) -> Task:
    """The task with its gain chosen for this tube, where that is "auto"."""
    if not task.gain_chosen or not isinstance(design, RefinedDesign):
        return task
    from stt_codegen.certify.period import chosen_gain
    from stt_codegen.controller.arithmetic import errors_of_tube

    if task.emit.scalar == "fixed":  # whose law has no constants before there is a gain
        return task.with_gain(chosen_gain(task, design, *errors_of_tube(design, None, task.emit.tick_period)))
    return task.with_gain(chosen_gain(task, design, *errors_of_tube(design, build_program(task, design))))


def design_tube(task: Task, room: int = 1) -> Design:
    """Choose the numbers that fix a tube, as `tube.design` says. room: of a refined one, see `refine`."""
    if task.tube.design == "refined":
        from stt_codegen.design.refine import refine

        return refine(task, room)
    if task.tube.design == "adaptive":
        from stt_codegen.design.adaptive import adaptive

        return adaptive(task)
    from stt_codegen.design.literal import literal

    return literal(task)


def build_program(task: Task, design: Design) -> Program:
    """The controller as typed single assignments, which every printer and prover reads."""
    if isinstance(design, RefinedDesign):
        if task.emit.scalar == "fixed":
            from stt_codegen.controller.integers.program import fixed_program

            return within_32_bits(fixed_program(task, design))
        from stt_codegen.controller.refined import refined_program

        return refined_program(task, design)
    from stt_codegen.controller.adaptive import adaptive_program

    return adaptive_program(task, design)


def within_32_bits(program: Program) -> Program:
    """A program of integers, of which it is proved that none of them leaves 32 bits, whatever the arguments. Raises `BadInput`
    where that cannot be shown."""
    from stt_codegen.program.ranges import OutOfRange, ranges

    for function in program.functions:
        try:
            ranges(program, function.name)
        except OutOfRange as problem:
            raise BadInput(f'emit.scalar: "fixed" has too few bits for this task ({problem}); use "float"') from problem
    return program


def certify(task: Task, design: Design, program: Program) -> Certificate:
    """P1 to P7, P8 and P9 where limits or a period ask for them, P10 where there is a mission, with margins; the certificate
    may fail, `build` decides what that means."""
    if isinstance(design, RefinedDesign):
        from stt_codegen.certify.exact import certify_emitted

        found = certify_emitted(task, design, program)
    else:
        from stt_codegen.certify.enclosure import certify_enclosed
        from stt_codegen.certify.falsification import falsify

        found = falsify(task, design)  # quick, and what fails there fails for certain
        found = found if found.failures else certify_enclosed(task, design)
    return replace(found, axes=task.axis_words)


def render_files(task: Task, design: Design, program: Program, certificate: Certificate) -> dict[str, bytes]:
    """The text of the emitted files, by name."""
    from stt_codegen.emit.render import render

    return render(task, design, program, certificate)
