"""The command line. Imports stay inside the commands, so that --help answers at once; `main` alone makes exit codes.

0 good, 1 drift or a failed comparison, 2 bad input, 3 not certified or infeasible, 4 a needed tool is missing, 5 internal.
Results go to stdout (one JSON document with --json), progress and messages to stderr.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from stt_codegen.errors import BadInput, SttError

app = typer.Typer(
    name="stt-codegen",
    help="Certified prescribed-time reach-avoid-stay controllers in C and Python, from one TOML file.",
    rich_markup_mode=None,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)

bench = typer.Typer(help="Measure: designs over random arenas, steps on emulated boards.", no_args_is_help=True)
app.add_typer(bench, name="bench")

TaskFile = Annotated[Path, typer.Argument(metavar="TASK", help="a task file, see tasks/")]
TaskFiles = Annotated[list[Path], typer.Argument(metavar="TASK...", help="task files, see tasks/")]
Json = Annotated[bool, typer.Option("--json", help="one JSON document on stdout")]
DesignOption = Annotated[Literal["refined", "adaptive", "literal"] | None, typer.Option(help="override tube.design")]
ScalarOption = Annotated[Literal["float", "double"] | None, typer.Option(help="override emit.scalar")]
PlantOption = Annotated[
    str | None,
    typer.Option(
        metavar="PLANT", help="integrator, robot, spacecraft, arm, or a Python file with f(x) and g(x); default: [plant]"
    ),
]
Uncertified = Annotated[bool, typer.Option("--uncertified", help="write a tube whose certificate fails; every file says so")]


def _say(text: str) -> None:
    """Progress and messages, on stderr."""
    print(text, file=sys.stderr, flush=True)


def _print_json(document: Any) -> None:
    print(json.dumps(document, indent=2, allow_nan=False))


def _keep_certified(folder: Path, controller: Any) -> None:
    """Refuse to write an uncertified controller over a certified one of the same name."""
    import json

    old = folder / f"{controller.task.name}.certificate.json"
    if controller.certificate.holds or not old.exists():
        return
    try:
        certified = json.loads(old.read_bytes()).get("certified") is True
    except (OSError, ValueError, AttributeError):
        certified = False
    if certified:
        raise BadInput(f"{folder}: holds a certified {controller.task.name!r}; write the uncertified one to another --out")


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}" + ("" if number == 1 else "s")


@contextmanager
def _patience(what: str) -> Iterator[None]:
    """A line on stderr every two seconds while something takes longer."""
    done = threading.Event()
    begin = time.perf_counter()

    def tell() -> None:
        while not done.wait(2.0):
            _say(f"  {what}: {time.perf_counter() - begin:.0f} s ...")

    thread = threading.Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _tell_slow_ticks(controller: Any) -> None:
    """A note on stderr when emit.tick_period is longer than what is proved for the plant that the task states."""
    if controller.task.emit.tick_period is None or not controller.certificate.holds:
        return
    from stt_codegen.bounds import Analysis

    for h in Analysis(controller).hypotheses():
        if h.name == "sampling" and not h.holds:
            _say(f"note: {controller.task.name}: does not hold: {h.statement}; see `stt-codegen design`")


def _built(task: Path, design: str | None, scalar: str | None) -> Any:
    from stt_codegen.pipeline import build

    with _patience(f"designing {task}"):
        return build(task, design, scalar)


def _version(wanted: bool) -> None:
    if wanted:
        from stt_codegen import __version__

        print(f"stt-codegen {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version and leave")
    ] = False,
) -> None:
    pass


@app.command()
def design(
    task: TaskFile,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    picture: Annotated[Path | None, typer.Option(metavar="DIR", help="where <name>.png goes; none without")] = None,
    json: Json = False,
    uncertified: Uncertified = False,
) -> None:
    """Show the tube of a task before anything is emitted: width, speed, certificate, cost, picture."""
    from stt_codegen.pipeline import build
    from stt_codegen.report import design_report

    begin = time.perf_counter()
    with _patience(f"designing {task}"):
        controller = build(task, design, scalar, uncertified)
    report = design_report(controller, time.perf_counter() - begin)
    if picture is not None:
        from stt_codegen.picture import draw

        path = picture / f"{controller.task.name}.png"
        draw(controller, path)
        report["picture"] = str(path)
    if json:
        _print_json(report)
    else:
        from stt_codegen.show import show_design

        show_design(report)


@app.command()
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
        Literal["plain", "cmake", "arduino", "platformio"], typer.Option(help="the files as they are, or as a library <name>/")
    ] = "plain",
    json: Json = False,
) -> None:
    """Write the C and Python controller of each task with its certificate: <name>.h, .c, .py, .certificate.json."""
    from stt_codegen.emit.manifest import record as record_controller
    from stt_codegen.emit.manifest import write_files
    from stt_codegen.emit.package import package as packed
    from stt_codegen.pipeline import build

    if record is not None and package != "plain":
        raise BadInput("--record and --package: give one of them; recorded folders hold the plain files")
    if out is not None and record is not None:
        raise BadInput("--out and --record: give one of them")
    made = []
    for task in tasks:  # all of them, before any is written
        with _patience(f"designing {task}"):
            made.append((task, build(task, design, scalar, uncertified)))
    names = [controller.task.name for _, controller in made]
    lowered = [name.lower() for name in names]
    for name in names:
        if lowered.count(name.lower()) > 1:
            raise BadInput(f"two of the task files have the name {name!r}; they would overwrite each other")
    written = []
    if record is None:
        for _, controller in made:
            _keep_certified(out or Path(), controller)
    for task, controller in made:
        _tell_slow_ticks(controller)
        if record is not None:
            folder = record_controller(record, task, controller, uncertified)
        else:
            folder = out or Path()
            write_files(folder, packed(controller, package))
        written.append(
            {
                "task": controller.task.name,
                "certified": controller.certificate.holds,
                "folder": str(folder),
                "files": list(packed(controller, package)),
            }
        )
        if not json:
            verdict = "certified" if controller.certificate.holds else "NOT CERTIFIED"
            print(f"{controller.task.name}: {verdict}; {', '.join(packed(controller, package))} in {folder}")
    if json:
        _print_json({"written": written})


@app.command()
def check(
    folder: Annotated[Path, typer.Argument(metavar="[DIR]", help="the folder of MANIFEST.json")] = Path("generated"),
    accept: Annotated[bool, typer.Option("--accept", help="write what the tool makes now, instead of comparing")] = False,
    json: Json = False,
) -> None:
    """Make every recorded controller again and compare with the files on disk, both ways. Exit code 1 on any difference."""
    from stt_codegen.emit import check as checks

    progress = (lambda name: _say(f"  {name}")) if sys.stderr.isatty() else (lambda _: None)
    if accept:
        count = checks.accept(folder, progress)
        written, dropped = count
        note = f", {dropped} dropped (their task files are gone)" if dropped else ""
        _print_json({"written": written, "dropped": dropped}) if json else print(
            f"{folder}: {_count(written, 'folder')} written{note}"
        )
        return
    found = checks.check(folder, progress)
    tools = checks.changed_tools(folder)
    if json:
        _print_json(
            {
                "differences": [{"path": d.path, "what": d.what, "numbers": d.numbers, "diff": list(d.diff)} for d in found],
                "changed_tools": tools,
            }
        )
    else:
        for d in found:
            print(f"{d.path}: {d.what}" + (f" ({d.numbers})" if d.numbers else ""))
            for line in d.diff:
                print(f"    {line}")
        for line in tools:
            print(f"note: other version than recorded: {line}")
        if found:
            print(
                f"\n{_count(len(found), 'difference')}. To accept what the tool makes now:  stt-codegen check {folder} --accept"
            )
        else:
            print(f"{folder}: {_count(checks.folders(folder), 'folder')}, no difference")
    if found:
        raise typer.Exit(1)


@app.command()
def compare(
    task: TaskFile,
    design: DesignOption = None,
    points: Annotated[int, typer.Option(min=1, help="random points, beside the edges")] = 10_000,
    json: Json = False,
) -> None:
    """Compare CasADi, the Python, and the C in float and double with an independent reference. Exit code 1 beyond a bound."""
    from dataclasses import asdict

    from stt_codegen.compare import compare as compare_task
    from stt_codegen.pipeline import require_supported
    from stt_codegen.task import load_task

    loaded = load_task(task).with_options(design)
    require_supported(loaded)
    rows = compare_task(loaded, points, progress=_say)
    good = all(r.holds for r in rows)
    if json:
        _print_json({"task": loaded.name, "within_bounds": good, "rows": [{**asdict(r), "holds": r.holds} for r in rows]})
    else:
        from stt_codegen.show import show_rows

        show_rows(f"{loaded.name}, {loaded.tube.design}", rows)
    if not good:
        raise typer.Exit(1)


@app.command()
def simulate(
    task: TaskFile,
    plant: Annotated[str, typer.Option(metavar="PLANT", help="integrator, robot, spacecraft, arm, or a file .py")] = "integrator",
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="samples a second (default: 1/emit.tick_period, or 1000)")
    ] = None,
    disturbance: Annotated[str, typer.Option(help="none, constant, sinusoidal, random, nearest or outward")] = "none",
    w_max: Annotated[float | None, typer.Option(min=0, help="bound on |w| (default: the plant's, or the task's)")] = None,
    noise: Annotated[float, typer.Option(min=0, help="bound on the error of every measured component")] = 0.0,
    lost: Annotated[int, typer.Option(min=0, help="samples that may be lost in a row, at random")] = 0,
    latency: Annotated[float, typer.Option(min=0, help="seconds from a sample to the input that it makes")] = 0.0,
    start: Annotated[str | None, typer.Option(metavar="X1,X2,...", help="x(0) in place of initial_state")] = None,
    seed: Annotated[int, typer.Option(min=0, help="of all that is random")] = 0,
    gain: Annotated[str | None, typer.Option(help='another control.gain, or "best": that with the longest proved period')] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="write <name>.loop.csv and <name>.loop.png here")] = None,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    uncertified: Uncertified = False,
    json: Json = False,
) -> None:
    """Drive a plant with the emitted C, held between samples: what is hit, left, reached. Exit code 1 when the task is missed."""
    from stt_codegen.loop.command import simulate_task

    with _patience(f"simulating {task}"):
        options = (plant, rate, disturbance, w_max, noise, lost, latency, start, seed, gain)
        report = simulate_task(task, design, scalar, uncertified, out, *options)
    if json:
        _print_json(report)
    else:
        from stt_codegen.show import show_run

        show_run(report)
    if not report["fulfilled"]:
        raise typer.Exit(1)


@app.command()
def pil(
    task: TaskFile,
    board: Annotated[Literal["m0", "m3", "m4f", "m7", "rv32", "avr"], typer.Option(help="the emulated board")],
    design: DesignOption = None,
    scalar: ScalarOption = None,
    points: Annotated[int, typer.Option(min=1, help="random points, beside the edges")] = 2000,
    json: Json = False,
) -> None:
    """Processor in the loop: run the emitted C on an emulated board, compare with the reference, count what a call takes."""
    from dataclasses import asdict

    from stt_codegen.board.emulated import BOARDS, run_on_board
    from stt_codegen.pipeline import build

    controller = build(task, design, scalar)
    with _patience(f"running {controller.task.name} on {board}"):
        rows, costs = run_on_board(controller, BOARDS[board], points)
    good = all(r.holds for r in rows)
    if json:
        compared = [{**asdict(r), "holds": r.holds} for r in rows]
        _print_json({"task": controller.task.name, "board": board, "within_bounds": good, "rows": compared, "calls": costs})
    else:
        from stt_codegen.show import show_rows

        show_rows(f"{controller.task.name}, {controller.design.kind}", rows)
        unit = BOARDS[board].unit
        for name, c in costs.items():
            taken = f"{c['least']} to {c['most']} {unit}, median {c['median']}"
            print(f"  {name}: {taken}; {c['stack']} B of stack; most at {c['worst_at']}")
    if not good:
        raise typer.Exit(1)


@app.command()
def certify(
    task: TaskFile,
    source: Annotated[Path, typer.Argument(metavar="FILE.c", help="the emitted C file")],
    certificate: Annotated[Path, typer.Argument(metavar="CERTIFICATE", help="its .certificate.json")],
    json: Json = False,
) -> None:
    """Repeat the proof of a refined tube from the C file alone, by the stand-alone checker. Exit code 1 when it fails."""
    import contextlib
    import io

    from stt_codegen.certify.checker import main as check_files

    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        code = check_files([str(task), str(source), str(certificate)])
    if json:
        _print_json({"holds": code == 0, "message": said.getvalue().strip()})
    else:
        print(said.getvalue(), end="")
    if code:
        raise typer.Exit(code)


@app.command()
def prove(
    task: Annotated[Path | None, typer.Argument(metavar="[TASK]", help="a task file; without one, the lemma book")] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="PATH",
            help="the book's page, .md or .tex (default: generated/lemmas.md); with TASK, the folder of <name>.bounds.json",
        ),
    ] = None,
    check: Annotated[bool, typer.Option("--check", help="compare with what is on disk, instead of writing it")] = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="prove all lemmas, also those proved before with these sources")] = False,
    plant: PlantOption = None,
    noise: Annotated[float, typer.Option(min=0, help="bound on the error of a measured state, by component")] = 0.0,
    latency: Annotated[float, typer.Option(min=0, help="seconds from a sample to the input that it makes")] = 0.0,
    design: DesignOption = None,
    scalar: ScalarOption = None,
    json: Json = False,
) -> None:
    """Prove, or refute, what the controllers rest on, about the expressions that are printed; with a TASK, evaluate the
    hypotheses and bounds for its tube and plant. Exit code 1 when a lemma is open or a hypothesis fails."""
    if task is None:
        if plant is not None or noise or latency or design is not None or scalar is not None:
            told = "--plant, --noise, --latency, --design and --scalar belong to a TASK"
            raise BadInput(f"prove: {told}; the book is about every task")
        good = _prove_book(out or Path("generated/lemmas.md"), check, fresh, json)
    else:
        if fresh:
            raise BadInput("prove: --fresh is for the lemma book; bounds of a TASK are always made anew")
        good = _prove_task(_built(task, design, scalar), plant, (noise, latency), out or Path(), check, json)
    if not good:
        raise typer.Exit(1)


def _prove_book(out: Path, check: bool, fresh: bool, json: bool) -> bool:
    from stt_codegen.emit.manifest import write_files
    from stt_codegen.lemmas.book import page, prove_all
    from stt_codegen.lemmas.lemma import Verdict

    if out.suffix not in (".md", ".tex"):
        raise BadInput(f"--out {out}: the book is written as .md or .tex")
    entries = prove_all(lambda title: _say(f"  {title}"), fresh)
    text = page(entries, out.suffix).encode()
    still_open = [e for e in entries if e.verdict is Verdict.OPEN]
    differs = check and (not out.is_file() or out.read_bytes() != text)
    if not check:
        write_files(out.parent, {out.name: text})
    if json:
        rows = [
            {"lemma": e.lemma.name, "verdict": e.verdict.value, "method": e.outcome.method, "evidence": list(e.outcome.evidence)}
            for e in entries
        ]
        _print_json({"lemmas": rows, "open": len(still_open), "page_differs": differs})
    else:
        for verdict in Verdict:
            print(f"{sum(e.verdict is verdict for e in entries):4d} {verdict.value}")
        for e in still_open:
            print(f"open: {e.lemma.name}: {'; '.join(e.outcome.evidence)}")
        print(f"{out}: {_compared(check, differs)}")
    return not still_open and not differs


def _compared(check: bool, differs: bool) -> str:
    return "differs; run without --check to write it" if differs else "as it should be" if check else "written"


def _prove_task(
    controller: Any, plant: str | None, errors: tuple[float, float], folder: Path, check: bool, as_json: bool
) -> bool:
    from stt_codegen.bounds import Analysis
    from stt_codegen.emit.manifest import write_files
    from stt_codegen.plants import plant_of
    from stt_codegen.show import show_bounds

    task = controller.task
    model = None if plant is None else plant_of(plant, task.dimension)
    with _patience(f"bounds of {task.name}"):
        document = Analysis(controller, model, *errors).document()
    name = f"{task.name}.bounds.json"
    text = (json.dumps(document, indent=2) + "\n").encode()
    path = folder / name
    differs = check and (not path.is_file() or path.read_bytes() != text)
    if not check:
        write_files(folder, {name: text})
    good = all(h["holds"] for h in document["hypotheses"])
    if as_json:
        _print_json({**document, "file_differs": differs})
    else:
        show_bounds(document)
        print(f"{path}: {_compared(check, differs)}")
    return good and not differs


@bench.command()
def arenas(
    family: Annotated[
        list[str] | None, typer.Option(help="paper, dense12, dense24, space3, space6 or corridor; may be repeated")
    ] = None,
    design: Annotated[list[str] | None, typer.Option(help="refined, adaptive or literal; may be repeated")] = None,
    count: Annotated[int | None, typer.Option(min=1, help="at most so many arenas of each family")] = None,
    clearance: Annotated[float | None, typer.Option(help="override tube.clearance", show_default="0.03")] = None,
    min_width: Annotated[float | None, typer.Option(help="override tube.min_width", show_default="0.05")] = None,
    processes: Annotated[int, typer.Option(min=0, help="on this machine; 0: one a core")] = 0,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="run on a Dask cluster instead")] = None,
    peers: Annotated[bool, typer.Option("--peers", help="planners, reachability and a barrier filter in the same run")] = False,
    record: Annotated[Path | None, typer.Option(metavar="FILE.md", help="put the tables into this file")] = None,
    json: Json = False,
) -> None:
    """Design and certify random arenas by the hundred; tables of how many, how fast, how wide, how slow.

    Without options: all of benchmarks/RESULTS.md but the peers, about ten minutes. The workers of a cluster need this package.
    """
    from stt_codegen.bench.command import run_arenas

    run_arenas(family, design, count, clearance, min_width, processes, scheduler, peers, record, json)


@bench.command()
def mcu(
    board: Annotated[list[str] | None, typer.Option(help="m0, m3, m4f, m7, rv32 or avr; may be repeated")] = None,
    points: Annotated[int, typer.Option(min=1, help="random points, beside the edges")] = 1000,
    record: Annotated[Path | None, typer.Option(metavar="FILE.md", help="put the tables into this file")] = None,
    json: Json = False,
) -> None:
    """Count what `control` costs on every emulated board, beside CasADi's C and C written by hand; about eight minutes.

    Exit code 1 when a controller is beyond a bound of `compare` on some board.
    """
    from stt_codegen.bench.mcu import run_mcu
    from stt_codegen.board.emulated import BOARDS

    for name in board or ():
        if name not in BOARDS:
            raise BadInput(f"--board {name}: is none of {', '.join(BOARDS)}")
    if not run_mcu(board, points, record, json, lambda what: _say(f"  {what}")):
        raise typer.Exit(1)


@bench.command()
def loop(
    count: Annotated[int, typer.Option(min=1, help="arenas of the paper's kind")] = 500,
    rate: Annotated[float, typer.Option(min=1, metavar="HZ", help="samples a second")] = 1000.0,
    w_max: Annotated[float, typer.Option(min=0, help="bound on |w| of xdot = u + w")] = 0.3,
    runs: Annotated[int, typer.Option(min=1, help="runs of every arena")] = 10,
    processes: Annotated[int, typer.Option(min=0, help="on this machine; 0: one a core")] = 0,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="run on a Dask cluster instead")] = None,
    peers: Annotated[bool, typer.Option("--peers", help="a barrier filter and the literal tube in the same loops")] = False,
    record: Annotated[Path | None, typer.Option(metavar="FILE.md", help="put the table into this file")] = None,
    json: Json = False,
) -> None:
    """Monte Carlo: the C that ships drives random arenas under disturbances, at the gain the tool proposes.

    Exit code 1 when a run of ours collides, leaves, or misses the target. Without peers about three minutes on two cores.
    """
    from stt_codegen.bench.command import run_loop

    if not run_loop(count, rate, w_max, runs, processes, scheduler, peers, record, json):
        raise typer.Exit(1)


@app.command()
def schema(json: Json = True) -> None:
    """Print the JSON Schema of task files, for editors."""
    from stt_codegen.task import json_schema

    print(json_schema(), end="")


def main() -> None:
    """Run the command line; every `SttError` becomes one message and its exit code (with --json also one document)."""
    try:
        app()
        sys.stdout.flush()
    except SttError as error:
        _say(f"stt-codegen: {error}")
        if "--json" in sys.argv:
            _print_json({"error": str(error), "exit_code": error.exit_code})
        sys.exit(error.exit_code)
    except BrokenPipeError:  # the reader has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except OSError as error:
        _say(f"stt-codegen: the output cannot be written ({error.strerror})")
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:
        if os.environ.get("STT_CODEGEN_DEBUG"):
            raise
        _say(
            f"stt-codegen: internal error: {type(error).__name__}: {error}; "
            "please report it with the traceback that STT_CODEGEN_DEBUG=1 shows"
        )
        sys.exit(5)


if __name__ == "__main__":
    main()
