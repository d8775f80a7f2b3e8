"""`generate`: write controllers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from stt_codegen.cli.options import (
    PACKAGES,
    DesignOption,
    Json,
    ScalarOption,
    TaskFiles,
    Uncertified,
    one_of,
    patience,
    print_json,
    say,
)
from stt_codegen.errors import BadInput
from stt_codegen.program.targets import optional_targets


def generate(
    tasks: TaskFiles,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="write the files of every task here (default: .)")] = None,
    record: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="write to DIR/<task>/<design>/<scalar>/ and note it in DIR/MANIFEST.json for `check`"),
    ] = None,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    uncertified: Uncertified = False,
    package: Annotated[
        str,
        one_of(
            PACKAGES, "the files as they are, as a library or crate <name>/, as units of FMI 3.0 and 2.0, or a package of ROS 2"
        ),
    ] = "plain",
    plant: Annotated[
        str | None,
        typer.Option(metavar="PLANT", help="with --package fmu: units of this plant too: a built-in one or a .py"),
    ] = None,
    theorem: Annotated[
        bool, typer.Option("--theorem", help="write <name>.v too: the theorems for Coq, see `stt-codegen theorem`")
    ] = False,
    json: Json = False,
) -> None:
    """Write the C and Python controller of each task with its certificate: <name>.h, .c, .py, .certificate.json."""
    from stt_codegen.pipeline import build
    from stt_codegen.plants import plant_of
    from stt_codegen.record import folder_of, interface_of, keep_apart, keep_certified, keep_inputs, sketch_notes, write_files
    from stt_codegen.record import package as packed
    from stt_codegen.record import record as record_controller

    if record is not None and package != "plain":
        raise BadInput("--record and --package: give one of them; recorded folders hold the plain files")
    if out is not None and record is not None:
        raise BadInput("--out and --record: give one of them")
    if theorem and (record is not None or package != "plain"):
        raise BadInput("--theorem: is written beside the plain files; leave out --record and --package")
    language = package if package in [t.key for t in optional_targets()] else None
    made = []
    for task in tasks:  # all of them, before any is written
        with patience(f"designing {task}"):
            made.append((task, build(task, design, scalar, uncertified, language)))
    packages = []
    for _, controller in made:
        model = None if plant is None else plant_of(plant, controller.task.dimension, controller.task.order)
        packages.append(packed(controller, package, model))
    if theorem:
        packages = [
            {**files, **_theorem(task.read_bytes(), controller.task.name, files)}
            for (task, controller), files in zip(made, packages, strict=True)
        ]
    placed = [
        files if record is None else {f"{folder_of(controller)}/{path}": data for path, data in files.items()}
        for (_, controller), files in zip(made, packages, strict=True)
    ]
    keep_apart([controller.task.name for _, controller in made], placed)
    for files in placed:
        keep_inputs([(record or out or Path()) / path for path in files], tasks)
        keep_certified(record or out or Path(), files)
    if record is None:
        write_files(out or Path(), {path: data for files in packages for path, data in files.items()})
    written = []
    for (task, controller), files in zip(made, packages, strict=True):
        _tell_what_is_not_proved(controller)
        for note in sketch_notes(controller) if package in ("arduino", "platformio") else ():
            say(f"note: {controller.task.name}: {note}")
        folder = out or Path() if record is None else record_controller(record, task, controller, uncertified)
        written.append(
            {
                "task": controller.task.name,
                "certified": controller.certificate.holds,
                "folder": str(folder),
                "files": list(files),
            }
        )
        if not json:
            verdict = "certified" if controller.certificate.holds else "NOT CERTIFIED"
            print(f"{controller.task.name}: {verdict}; {', '.join(files)} in {folder}")
            if package == "ros2":
                print(f"{controller.task.name}: {interface_of(controller.task)}")
    if json:
        print_json({"written": written})


def _theorem(task: bytes, name: str, files: dict[str, bytes]) -> dict[str, bytes]:
    """<name>.v, from what is written: the task spelled out where it has a map or an outline."""
    from stt_codegen.emit import spelled_name
    from stt_codegen.theorem import theorem_text

    data = (files.get(spelled_name(name), task), *(files[f"{name}{end}"] for end in (".h", ".c", ".certificate.json")))
    text = theorem_text(*data)
    if text.startswith(f"(* {name}.v: theorems about the tube".encode()):
        say(f"{name}.v: theorems about the tube alone; its first lines say why")
    return {f"{name}.v": text}


def _tell_what_is_not_proved(controller: Any) -> None:
    """Notes on stderr about gain, limits and tick of a refined tube: what `design` would say of them. P9 is a demand, no note."""
    from stt_codegen.report import task_notes

    task = controller.task
    for text in task_notes(task):
        say(f"note: {task.name}: {text}")
    target = task.as_stated.target_set
    if target is not None and target.centre is not None:
        from stt_codegen.task.sets import FAN_CORNER_DISTANCES

        faces = len(target.half_spaces())
        share = 100 / float(FAN_CORNER_DISTANCES[len(target.centre)])
        say(f"note: {task.name}: reached is a polytope of {faces} faces in the target's ball, {share:.1f} % as wide")
    outside: dict[str, bool] = {}
    for j, (grown, course) in enumerate(zip(task.obstacles, task.courses, strict=True)):
        field, space = task.unsafe_field(j), task.state_space  # a set is outside where all of its images are
        outside[field] = outside.get(field, True) and course is None and grown.is_apart_from(space.lower, space.upper)
    for convex, is_outside in zip(task.as_stated.unsafe, outside.values(), strict=True):
        if is_outside:
            say(f"note: {task.name}: {convex.name} lies outside the state space")
    if task.control.period is not None or controller.design.is_stateful or not controller.certificate.holds:
        return
    from stt_codegen.report import Analysis

    analysis = Analysis(controller)
    told = [h.statement for h in analysis.hypotheses() if h.name in ("sampling", "saturation") and not h.holds]
    if analysis.period is None:
        told.append(f"a sampling period, from every start with {analysis.starts}")
    for statement in told:
        say(f"note: {task.name}: not shown for {analysis.name}: {statement}; see `stt-codegen design`")
