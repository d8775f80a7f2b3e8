"""Arguments that several commands have, and how they print. Results go to stdout, progress and messages to stderr."""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from stt_codegen.cli.streams import discard, escape_control_characters
from stt_codegen.design_kinds import DesignKind
from stt_codegen.effort import DEFAULT_SECONDS, Effort
from stt_codegen.program.targets import TARGETS

TaskFile = Annotated[Path, typer.Argument(readable=False, metavar="TASK", help="a task file, see tasks/")]
TaskFiles = Annotated[list[Path], typer.Argument(readable=False, metavar="TASK...", help="task files, see tasks/")]
Json = Annotated[bool, typer.Option("--json", help="one JSON document on stdout")]
DesignOption = Annotated[DesignKind | None, typer.Option(help="override tube.design")]
Axes = Annotated[
    list[str] | None,
    typer.Option(metavar="A,B", help="two dimensions by name (x1, x2, .. or the task's axes) to draw in; may be given again"),
]
ScalarOption = Annotated[Literal["float", "double", "fixed"] | None, typer.Option(help="override emit.scalar")]
PlantOption = Annotated[
    str | None,
    typer.Option(
        metavar="PLANT", help="integrator, robot, spacecraft, arm, or a Python file with f(x) and g(x); default: [plant]"
    ),
]
EffortOption = Annotated[
    float | None,
    typer.Option(
        "--effort",
        min=0,
        metavar="SECONDS",
        help="how long to look for another way, where the task is refused",
        show_default=f"{DEFAULT_SECONDS:g}",
    ),
]
Uncertified = Annotated[bool, typer.Option("--uncertified", help="write a tube whose certificate fails; every file says so")]
Noise = Annotated[
    float | None,
    typer.Option(min=0, help="bound on the error of every measured component (default: the task's plant.noise, or 0)"),
]
Latency = Annotated[
    float | None, typer.Option(min=0, help="seconds from a sample to its input (default: the task's control.latency, or 0)")
]


PACKAGES = ("plain", "cmake", "arduino", "platformio", *(t.key for t in TARGETS if t.package), "fmu", "ros2")


def one_of(names: Sequence[str], explanation: str) -> Any:
    """Return an option whose value is one of these names, which its help lists."""

    def require_known(value: str) -> str:
        if value not in names:
            raise typer.BadParameter(f"{value!r} is none of {', '.join(names)}")
        return value

    return typer.Option(metavar=f"[{'|'.join(names)}]", help=explanation, callback=require_known)


def say(text: str) -> None:
    """Print progress or a message to stderr, as one line. Where nobody can read it, the command goes on."""
    try:
        print(escape_control_characters(text), file=sys.stderr, flush=True)
    except OSError:
        discard(sys.stderr)


def print_line(text: str) -> None:
    """Print a line with paths or texts of files to stdout."""
    print(escape_control_characters(text))


def print_json(document: Any) -> None:
    """Print a result to stdout."""
    print(json.dumps(document, indent=2, allow_nan=False))


def counted(number: int, thing: str) -> str:
    """Write a number with its noun: 3 folders, 1 folder."""
    return f"{number} {thing}" + ("" if number == 1 else "s")


def effort_for(task: Path, seconds: float | None, has_uncertified: bool = True) -> Effort:
    """Return the effort of a search for another way, which says why it goes on.

    seconds: those of --effort; None for its default. has_uncertified: whether the command has --uncertified.
    """
    limit = DEFAULT_SECONDS if seconds is None else seconds

    def announce(reason: str, seconds_left: float) -> None:
        say(f"{task}: {reason}; looking for what would do, for about {seconds_left:.0f} s; Ctrl-C ends the search")

    return Effort(
        limit,
        announce,
        ends_on_interrupt=True,
        longer="--effort SECONDS",
        as_it_is="--uncertified writes the tube as it is, with a banner" if has_uncertified else "",
    )


@contextmanager
def patience(what: str) -> Iterator[None]:
    """Print a line to stderr after a second and then every two seconds, until the block ends."""
    done = threading.Event()
    begin = time.perf_counter()

    def print_progress() -> None:
        pause = 1.0
        while not done.wait(pause):
            say(f"  {what}: {time.perf_counter() - begin:.0f} s ...")
            pause = 2.0

    thread = threading.Thread(target=print_progress, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
