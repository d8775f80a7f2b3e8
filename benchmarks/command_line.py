"""Options of the suites `arenas`, `loop`, `missions` and `mcu` of `python -m benchmarks`, which benchmarks/suites/ implements."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, get_args

import typer

from stt_codegen.board import BOARDS
from stt_codegen.cli.options import Json, say
from stt_codegen.design_kinds import DesignKind
from stt_codegen.errors import BadInput

suites = typer.Typer(
    help="Measure: designs over random arenas, steps on emulated boards.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@suites.command()
def arenas(
    family: Annotated[
        list[str] | None, typer.Option(help="paper, dense12, dense24, space3, space6 or corridor; may be repeated")
    ] = None,
    design: Annotated[list[str] | None, typer.Option(help=f"{', '.join(get_args(DesignKind))}; may be repeated")] = None,
    count: Annotated[int | None, typer.Option(min=1, help="at most so many arenas of each family")] = None,
    clearance: Annotated[float | None, typer.Option(help="override tube.clearance", show_default="0.03")] = None,
    min_width: Annotated[float | None, typer.Option(help="override tube.min_width", show_default="0.05")] = None,
    processes: Annotated[int, typer.Option(min=0, help="on this machine; 0: one a core")] = 0,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="run on a Dask cluster instead")] = None,
    peers: Annotated[bool, typer.Option("--peers", help="the methods of the paper's Table I, and more, in the same run")] = False,
    policies: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="with --peers: of trained policies (default: build/policies)")
    ] = None,
    demand: Annotated[float, typer.Option(min=0, max=1, help="exit code 1 where less of the feasible are certified")] = 0.0,
    record: Annotated[Path | None, typer.Option(metavar="FILE.md", help="put the tables into this file")] = None,
    json: Json = False,
) -> None:
    """Design and certify random arenas by the hundred; tables of how many, how fast, how wide, how slow.

    Without options: all of benchmarks/RESULTS.md but the peers, about ten minutes. The workers of a cluster run in this
    repository.
    """
    from benchmarks.peers.in_loops import POLICIES
    from benchmarks.suites.command import ArenaOptions, Execution, run_arenas

    _require_peers(peers, "--policies", policies)
    options = ArenaOptions(family, design, count, clearance, min_width, peers, demand, policies or POLICIES)
    if not run_arenas(options, Execution(processes, scheduler, record, json)):
        raise typer.Exit(1)


@suites.command()
def mcu(
    board: Annotated[list[str] | None, typer.Option(help=f"one of {', '.join(BOARDS)}; may be repeated")] = None,
    points: Annotated[int, typer.Option(min=1, help="random points, beside the edges")] = 1000,
    record: Annotated[Path | None, typer.Option(metavar="FILE.md", help="put the tables into this file")] = None,
    json: Json = False,
) -> None:
    """Count what `control` costs on every emulated board, beside CasADi's C and C written by hand; about eight minutes.

    Exit code 1 when a controller is beyond a bound of `compare` on some board.
    """
    from benchmarks.suites.mcu import run_mcu

    for name in board or ():
        if name not in BOARDS:
            raise BadInput(f"--board {name}: is none of {', '.join(BOARDS)}")
    if not run_mcu(board, points, record, json, lambda what: say(f"  {what}")):
        raise typer.Exit(1)


@suites.command()
def loop(
    count: Annotated[int, typer.Option(min=1, help="arenas of the paper's kind")] = 500,
    rate: Annotated[float, typer.Option(min=1, metavar="HZ", help="samples a second")] = 1000.0,
    w_max: Annotated[float, typer.Option(min=0, help="bound on |w| of xdot = u + w")] = 0.3,
    runs: Annotated[int, typer.Option(min=1, help="runs of every arena")] = 10,
    processes: Annotated[int, typer.Option(min=0, help="on this machine; 0: one a core")] = 0,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="run on a Dask cluster instead")] = None,
    peers: Annotated[bool, typer.Option("--peers", help="all peers that can drive there; of order 2 a cascade")] = False,
    policies: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="with --peers: of trained policies (default: build/policies)")
    ] = None,
    record: Annotated[Path | None, typer.Option(metavar="FILE.md", help="put the table into this file")] = None,
    json: Json = False,
) -> None:
    """Monte Carlo: the C that ships drives random arenas under disturbances, at the gain the tool proposes.

    Exit code 1 when a run of ours collides, leaves, or misses the target. Without peers about three minutes on two cores.
    """
    from benchmarks.peers.in_loops import POLICIES
    from benchmarks.suites.command import Execution, LoopOptions, run_loop

    _require_peers(peers, "--policies", policies)
    if not run_loop(
        LoopOptions(count, rate, w_max, runs, peers, policies or POLICIES), Execution(processes, scheduler, record, json)
    ):
        raise typer.Exit(1)


@suites.command()
def missions(
    count: Annotated[int | None, typer.Option(min=1, help="random missions of each kind, at most")] = None,
    peers: Annotated[bool, typer.Option("--peers", help="the mixed-integer programs of stlpy, in the same run")] = False,
    limit: Annotated[float | None, typer.Option(min=0, metavar="SECONDS", help="for each of them (default: 60)")] = None,
    record: Annotated[Path | None, typer.Option(metavar="FILE.md", help="put the tables into this file")] = None,
    json: Json = False,
) -> None:
    """Missions: scenarios of stlpy, random ones, sets that move, published tasks.

    Exit code 1 where less than 98 of 100 among sets at rest are certified. About four minutes, with peers six.
    """
    from benchmarks.suites.missions import run_missions

    _require_peers(peers, "--limit", limit)
    if not run_missions(count, (60.0 if limit is None else limit) if peers else 0.0, record, json, lambda what: say(f"  {what}")):
        raise typer.Exit(1)


def _require_peers(peers: bool, option: str, value: object) -> None:
    """Raise BadInput where an option of the peers has a value, and there are no peers."""
    if value is not None and not peers:
        raise BadInput(f"{option}: is for --peers; give both, or leave it out")
