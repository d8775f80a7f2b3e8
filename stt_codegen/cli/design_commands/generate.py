"""`generate`: build the controllers of tasks and write them, as plain files, packages, or records that `check` compares."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from stt_codegen.cli.options import (
    PACKAGES,
    DesignOption,
    EffortOption,
    Json,
    ScalarOption,
    TaskFiles,
    Uncertified,
    effort_for,
    one_of,
    patience,
    print_json,
    print_line,
    say,
)
from stt_codegen.errors import BadInput
from stt_codegen.program.targets import optional_targets

Controllers = list[tuple[Path, Any]]  # task files and their controllers; pipeline.py, which has their class, is imported late


def generate(
    tasks: TaskFiles,
    out: Annotated[
        Path | None, typer.Option(readable=False, metavar="DIR", help="write the files of every task here (default: .)")
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="DIR",
            help="write to DIR/<task>/<design>/<scalar>/ and note it in DIR/MANIFEST.json for `check`",
        ),
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
    effort: EffortOption = None,
) -> None:
    """Write the C and Python controller of each task with its certificate: <name>.h, .c, .py, .certificate.json."""
    from stt_codegen.record import interface_of

    _require_compatible(out=out, record=record, package=package, theorem=theorem)
    controllers = _build_all(tasks, design=design, scalar=scalar, uncertified=uncertified, package=package, effort=effort)
    contents = _files_of_all(controllers, package=package, plant=plant, theorem=theorem)
    _require_safe_targets(controllers, contents, record, out or Path())
    folders = _write_all(controllers, contents, record=record, out=out or Path(), uncertified=uncertified)
    written = []
    for (_, controller), files, folder in zip(controllers, contents, folders, strict=True):
        name = controller.task.name
        for note in [*_notes(controller), *_package_notes(controller, package, plant)]:
            say(f"note: {name}: {note}")
        certified = controller.certificate.holds
        written.append({"task": name, "certified": certified, "folder": str(folder), "files": list(files)})
        if not json:
            print_line(f"{name}: {'certified' if certified else 'NOT CERTIFIED'}; {', '.join(files)} in {folder}")
            if package == "ros2":
                print(f"{name}: {interface_of(controller.task)}")
    if json:
        print_json({"written": written})


def _require_compatible(*, out: Path | None, record: Path | None, package: str, theorem: bool) -> None:
    """Raise `BadInput` where two options exclude each other."""
    if record is not None and package != "plain":
        raise BadInput("--record and --package: give one of them; recorded folders hold the plain files")
    if out is not None and record is not None:
        raise BadInput("--out and --record: give one of them")
    if theorem and (record is not None or package != "plain"):
        raise BadInput("--theorem: is written beside the plain files; leave out --record and --package")


def _build_all(
    tasks: list[Path], *, design: str | None, scalar: str | None, uncertified: bool, package: str, effort: float | None
) -> Controllers:
    """Build the controller of each task, all of them before any is written."""
    from stt_codegen.pipeline import build

    language = package if package in [t.key for t in optional_targets()] else None
    controllers = []
    for task in tasks:
        with patience(f"designing {task}"):
            controllers.append((task, build(task, design, scalar, uncertified, language, effort=effort_for(task, effort))))
    return controllers


def _files_of_all(controllers: Controllers, *, package: str, plant: str | None, theorem: bool) -> list[dict[str, bytes]]:
    """Return the contents of the files of each controller by path, in the package's layout."""
    from stt_codegen.files import read_task_text
    from stt_codegen.plants import plant_of
    from stt_codegen.record import package as package_files

    contents = []
    for task, controller in controllers:
        model = None if plant is None else plant_of(plant, controller.task.dimension, controller.task.order)
        files = package_files(controller, package, model)
        contents.append(
            {**files, **_theorem_file(read_task_text(task).encode(), controller.task.name, files)} if theorem else files
        )
    return contents


def _require_safe_targets(controllers: Controllers, contents: list[dict[str, bytes]], record: Path | None, out: Path) -> None:
    """Raise `BadInput` where a file would replace a task, a certified controller, or a file of another task."""
    from stt_codegen.record import folder_of, refuse_to_overwrite_certified, refuse_to_overwrite_inputs, require_distinct_paths

    targets = [
        files if record is None else {f"{folder_of(controller)}/{path}": data for path, data in files.items()}
        for (_, controller), files in zip(controllers, contents, strict=True)
    ]
    require_distinct_paths([controller.task.name for _, controller in controllers], targets)
    folder = out if record is None else record
    for files in targets:
        refuse_to_overwrite_inputs([folder / path for path in files], [task for task, _ in controllers])
        refuse_to_overwrite_certified(folder, files)


def _write_all(
    controllers: Controllers,
    contents: list[dict[str, bytes]],
    *,
    record: Path | None,
    out: Path,
    uncertified: bool,
) -> list[Path]:
    """Write every file, or record every controller; return the folder of each."""
    from stt_codegen.files import locked, write_files
    from stt_codegen.record import record as record_controller

    folder = out if record is None else record
    with patience(f"writing to {folder}"), locked([folder]):
        _require_safe_targets(controllers, contents, record, out)  # once more: another command may have written meanwhile
        if record is not None:
            return [record_controller(record, task, controller, uncertified) for task, controller in controllers]
        write_files(out, {path: data for files in contents for path, data in files.items()})
    return [out] * len(controllers)


def _theorem_file(task: bytes, name: str, files: dict[str, bytes]) -> dict[str, bytes]:
    """Return <name>.v with the theorems about the files; a task with a map or an outline is read as it is spelled out."""
    from stt_codegen.emit import spelled_name
    from stt_codegen.theorem import theorem_text

    data = (files.get(spelled_name(name), task), *(files[f"{name}{end}"] for end in (".h", ".c", ".certificate.json")))
    text = theorem_text(*data)
    if text.startswith(f"(* {name}.v: theorems about the tube".encode()):
        say(f"{name}.v: theorems about the tube alone; its first lines say why")
    return {f"{name}.v": text}


def _notes(controller: Any) -> Iterator[str]:
    """Yield what a refined tube's certificate does not prove, and what the task does not say: notes that `design` prints too."""
    from stt_codegen.report import Analysis, control_notes, controller_notes

    task = controller.task
    yield from controller_notes(controller)
    yield from control_notes(task, None)
    yield from _set_notes(task)
    proves_periods = controller.design.capabilities.proves_periods
    if task.control.period is not None or not proves_periods or not controller.certificate.holds:
        return  # a period that is stated must be proved, and needs no note
    analysis = Analysis(controller)
    unproved = [h.statement for h in analysis.hypotheses() if h.name in ("sampling", "saturation") and not h.holds]
    if analysis.period is None:
        unproved.append(f"a sampling period, from every start with {analysis.starts}")
    yield from (f"not shown for {analysis.name}: {statement}; see `stt-codegen design`" for statement in unproved)


def _package_notes(controller: Any, package: str | None, plant: str | None) -> Iterator[str]:
    """Yield notes on a package: on the time of a sketch, and on a plant's unit that knows no drive."""
    from stt_codegen.record import sketch_notes

    if package in ("arduino", "platformio"):
        yield from sketch_notes(controller)
    if package == "fmu" and plant is not None and controller.task.has_drive:
        yield "the plant's unit acts on u at once; put the drive of [plant] between both units"


def _set_notes(task: Any) -> Iterator[str]:
    """Yield notes about a round target, and about unsafe sets outside the state space."""
    from stt_codegen.task.sets import FAN_CORNER_DISTANCES

    target = task.as_stated.target_set
    if target is not None and target.centre is not None:
        faces = len(target.half_spaces())
        share = 100 / float(FAN_CORNER_DISTANCES[len(target.centre)])
        yield f"reached is a polytope of {faces} faces in the target's ball, {share:.1f} % as wide"
    outside: dict[str, bool] = {}
    for j, (grown, course) in enumerate(zip(task.obstacles, task.courses, strict=True)):
        field, space = task.unsafe_field(j), task.state_space  # a set is outside where all of its images are
        outside[field] = outside.get(field, True) and course is None and grown.is_apart_from(space.lower, space.upper)
    for convex, is_outside in zip(task.as_stated.unsafe, outside.values(), strict=True):
        if is_outside:
            yield f"{convex.name} lies outside the state space"
