"""`simulate`: run the emitted C in closed loop with a plant."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stt_codegen.cli.options import (
    Axes,
    DesignOption,
    EffortOption,
    Json,
    Latency,
    Noise,
    ScalarOption,
    TaskFile,
    Uncertified,
    effort_for,
    patience,
    print_json,
    say,
)


def simulate(
    task: TaskFile,
    plant: Annotated[
        str,
        typer.Option(
            metavar="PLANT", help="integrator, robot, spacecraft, arm, bounds (the worst within [plant]), or a file .py"
        ),
    ] = "integrator",
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="samples a second (default: that of the task's period or tick, or 1000)")
    ] = None,
    disturbance: Annotated[str, typer.Option(help="none, constant, sinusoidal, random, nearest, outward or motion")] = "none",
    w_max: Annotated[float | None, typer.Option(min=0, help="bound on |w| (default: the plant's, or the task's)")] = None,
    noise: Noise = None,
    lost: Annotated[int, typer.Option(min=0, help="samples that may be lost in a row, at random")] = 0,
    latency: Latency = None,
    lag: Annotated[
        float | None,
        typer.Option(min=0, metavar="SECONDS", help="u acts through one first-order lag (default: the drives of [plant])"),
    ] = None,
    clock: Annotated[
        str,
        typer.Option(help="error of the sets' clock: stated (none), early (behind by timing), late (ahead), or worst of nine"),
    ] = "stated",
    start: Annotated[str | None, typer.Option(metavar="X1,X2,...", help="x(0) in place of initial_state")] = None,
    seed: Annotated[int, typer.Option(min=0, help="of all that is random")] = 0,
    gain: Annotated[
        str | None,
        typer.Option(help='another control.gain, or "best": the proved gain with the largest margin'),
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="write <name>.loop.csv and <name>.loop.png here")] = None,
    axes: Axes = None,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    uncertified: Uncertified = False,
    json: Json = False,
    effort: EffortOption = None,
) -> None:
    """Simulate a plant in closed loop with the emitted C, held between samples. Exit code 1 when the task is missed."""
    with patience(f"simulating {task}"):
        from stt_codegen.loop import Request, enlarged_sets
        from stt_codegen.loop import simulate as run_loop
        from stt_codegen.pipeline import build

        request = Request(
            plant=plant, rate=rate, disturbance=disturbance, w_max=w_max, noise=noise, lost=lost, latency=latency,
            lag=lag, start=start, seed=seed, gain=gain, axes=tuple(axes or ()), clock=clock,
        )  # fmt: skip
        controller = build(task, design, scalar, uncertified, effort=effort_for(task, effort))
        report = run_loop(controller, request, out)
    for name in enlarged_sets(controller.task):
        say(f"note: {controller.task.name}: {name} is judged by a larger set, so a reported collision may not have happened")
    if json:
        print_json(report.document())
    else:
        from stt_codegen.cli.show import show_run

        show_run(report)
    if not report.fulfilled:
        raise typer.Exit(1)
