"""What the emitted controllers cost on microcontrollers: instructions (exact, emulated), bytes of code, tables, RAM, stack;
beside CasADi's own C, C written by hand, and the floor; and how the cost grows with the dimension and with the obstacles.

Every run is a comparison with the reference too: a figure of a board is of code that was within its bounds there.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.peers.driven import as_control
from benchmarks.suites.families import FAMILIES, Family, arena_task
from benchmarks.suites.report import command, record, table
from benchmarks.suites.rivals import casadi_text, floor_text, hand_text
from stt_codegen.board.boards import BOARDS, Board
from stt_codegen.board.emulated import CFLAGS, Counts, Emulated
from stt_codegen.board.rust_images import board_objects
from stt_codegen.compare.comparison import compare_backend
from stt_codegen.errors import BadInput, MissingTool, NotCertified
from stt_codegen.pipeline import EmittedController, build_task

# Label, design, scalar, math of the paper's case study, as far as a board can have them.
VARIANTS = (
    ("refined", "refined", "float", "libm"),
    ("refined, inline", "refined", "float", "inline"),
    ("refined, double", "refined", "double", "libm"),
    ("adaptive", "adaptive", "float", "libm"),
)
CASE = FAMILIES["paper"], 0  # 4 obstacles, n = 2, 9 s
DIMENSIONS = tuple(range(1, 13))
CROWDS = (("empty", 0), ("paper", 4), ("dense12", 12), ("dense24", 24), ("corridor", 1000))


@dataclass(frozen=True)
class Line:
    """One controller on one board. Steps in the board's unit; bytes of what `control` needs, without libm; stack with it."""

    board: str
    label: str
    unit: str
    least: float
    median: float
    most: float
    worst_at: str
    code: int
    tables: int
    ram: int
    stack: int
    within: bool | None  # of the bounds of compare; None where that is not asked


def variant(
    design: str, scalar: str, math: str, family: Family = CASE[0], seed: int = CASE[1], rust: bool = False
) -> EmittedController:
    """The controller of an arena."""
    task = arena_task(family, seed).with_options(design, scalar)
    return build_task(task.model_copy(update={"emit": task.emit.model_copy(update={"math": math, "rust": rust})}))


def measured(controller: EmittedController, board: Board, label: str, points: int, rust: bool = False) -> tuple[Line, Counts]:
    """Compare with the reference on the board, and what `control` took there, the C's or the Rust's."""
    made: list[Emulated] = []

    def make(given: EmittedController) -> Emulated:
        made.append(Emulated(given, board, rust=rust))
        return made[-1]

    rows = compare_backend(controller, make, points)
    counts = next(backend.counts["control"] for backend in made if "control" in backend.counts)
    return line_of(controller, board, label, counts, all(r.holds for r in rows), rust), counts


def others(board: Board, sources: dict[str, str], points: int = 200) -> Iterator[Line]:
    """C texts with `decide` (peers/driven.py) on a board, beside the emitted `control`: the same points of the same arena."""
    controller = variant("refined", "float", "libm")
    line, counts = measured(controller, board, "emitted, refined", points)
    yield line
    yield measured(variant("refined", "float", "inline"), board, "emitted, refined, inline", points)[0]
    for label, source in sources.items():
        yield rival(controller, board, label, as_control(controller.task.name, source), counts)


def line_of(
    controller: EmittedController, board: Board, label: str, counts: Counts, within: bool | None, rust: bool = False
) -> Line:
    seen = counts.summary()
    code, tables, ram = sizes(controller, board, rust=rust)
    place = seen.describe_worst([p.name for p in controller.program.function("control").inputs])
    steps = (seen.minimum, seen.median, seen.maximum)
    return Line(board.name, label, board.unit, *steps, place, code, tables, ram, seen.stack, within)


def sizes(controller: EmittedController, board: Board, function: str = "control", rust: bool = False) -> tuple[int, int, int]:
    """Bytes of code, of tables, and of RAM that `function` and all it calls need, without the C library, at -O2; of Rust with
    what it calls of its core library."""
    p = controller.task.name
    for tool in (board.compiler, _size_tool(board)):
        if shutil.which(tool) is None:
            raise MissingTool(f"{tool} is not found; for board {board.name} install (Debian names): {board.packages}")
    with tempfile.TemporaryDirectory() as folder:
        for name, data in controller.files.items():
            Path(folder, name).write_bytes(data)
        split = ("-ffunction-sections", "-fdata-sections", "-w")
        base = [board.compiler, *board.flags]
        headers = [v for v in board.libraries if v.startswith("--specs=")]
        objects = board_objects(controller, board.rust_target, Path(folder)) if rust else ["all.o"]
        if not rust:
            subprocess.run([*base, *headers, *CFLAGS, *split, "-c", f"{p}.c", "-o", "all.o"], cwd=folder, check=True)
        keep = f"-Wl,-r,--gc-sections,-e,{p}_{function}"
        subprocess.run([*base, "-nostdlib", "-nostartfiles", keep, *objects, "-o", "kept.o"], cwd=folder, check=True)
        lines = subprocess.run([_size_tool(board), "-A", "kept.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
    found = [(row[0], int(row[1])) for row in (line.split() for line in lines.splitlines()) if len(row) == 3 and row[0][0] == "."]

    def total(*kinds: str) -> int:
        return sum(size for name, size in found if name.startswith(kinds))

    tables = total(".rodata", ".srodata")
    in_ram = tables if board.name == "avr" else 0  # AVR loads constants from RAM
    return total(".text"), tables, total(".data", ".sdata", ".bss", ".sbss") + in_ram


def _size_tool(board: Board) -> str:
    return board.compiler.removesuffix("gcc") + "size"


def all_boards(boards: Sequence[Board], points: int, named: bool, said: Callable[[str], None]) -> Iterator[Line]:
    """Every variant on every board that can have it; one whose tools are missing is left out, unless it was asked for by name."""
    for board in boards:
        for label, design, scalar, math in VARIANTS:
            said(f"{board.name}: {label}")
            try:
                line, _ = measured(variant(design, scalar, math), board, label, points)
            except BadInput:  # no double, or a function that the board's library lacks
                continue
            except MissingTool as error:
                if named:
                    raise
                said(f"{board.name} is left out: {error}")
                break
            yield line


def beside(board: Board, points: int, said: Callable[[str], None]) -> Iterator[Line]:
    """The emitted `control` beside CasADi's, a hand-written one and the floor, on the same points."""
    for design in ("refined", "adaptive"):
        controller = variant(design, "float", "libm")
        line, counts = measured(controller, board, f"emitted, {design}", points)
        yield line
        rivals = [
            ("CasADi's C, as generated", casadi_text(controller, False)),
            ("CasADi's C, single precision", casadi_text(controller, True)),
        ]
        if controller.design.capabilities.inlines_logarithm:
            yield replace(measured(variant("refined", "float", "inline"), board, "emitted, refined, inline", points)[0])
            yield from in_rust(board, points, said)
            rivals += [("written by hand", hand_text(controller)), ("n logarithms, n divisions", floor_text(controller))]
        for label, text in rivals:
            said(f"{board.name}: {label}, {design}")
            yield rival(controller, board, f"{label}, {design}", text, counts)


def in_rust(board: Board, points: int, said: Callable[[str], None]) -> Iterator[Line]:
    """The same two controllers as Rust, called as C is; left out where the board or the machine has none."""
    if not board.rust_target:
        return
    for label, math in (("emitted as Rust, refined", "libm"), ("emitted as Rust, refined, inline", "inline")):
        said(f"{board.name}: {label}")
        try:
            yield measured(variant("refined", "float", math, rust=True), board, label, points, rust=True)[0]
        except MissingTool as error:
            said(f"{label} is left out: {error}")


def rival(controller: EmittedController, board: Board, label: str, text: str, counts: Counts) -> Line:
    """Another C text for the same function, on the same points."""
    other = replace(controller, files={**controller.files, f"{controller.task.name}.c": text.encode()})
    backend = Emulated(other, board, extra_flags=("-w",))
    backend.call("control", *counts.inputs)
    return line_of(other, board, label, backend.counts["control"], None)


def growth(board: Board, points: int, said: Callable[[str], None]) -> tuple[list[Line], list[Line]]:
    """Refined `control` in 1 to 12 dimensions without obstacles, and in the plane with 0 to 1,000 of them."""
    by_dimension, by_crowd = [], []
    empty = replace(FAMILIES["paper"], name="empty", count=0)
    for n in DIMENSIONS:
        said(f"{board.name}: n = {n}")
        family = replace(empty, dimension=n)
        by_dimension.append(measured(variant("refined", "float", "libm", family), board, str(n), points)[0])
    for name, count in CROWDS:
        said(f"{board.name}: {count} obstacles")
        family = empty if name == "empty" else FAMILIES[name]
        by_crowd.append(measured(_first_certified(family), board, str(count), points)[0])
    return by_dimension, by_crowd


def _first_certified(family: Family) -> EmittedController:
    for seed in range(20):
        try:
            return variant("refined", "float", "libm", family, seed)
        except NotCertified:
            continue
    raise BadInput(f"{family.name}: none of the first 20 arenas has a certified tube")


HEADINGS = ("", "least / median / most seen", "code B", "tables B", "RAM B", "stack B", "agrees")


def row(line: Line, name: str, place: bool = False) -> list[str]:
    """A row of HEADINGS; with `place` the last column says where the worst was."""
    steps = f"{line.least:,.0f} / {line.median:,.0f} / {line.most:,.0f}"
    agrees = {True: "yes", False: "NO", None: "-"}[line.within]
    return [name, steps, *(f"{v:,}" for v in (line.code, line.tables, line.ram, line.stack)), agrees, *[line.worst_at] * place]


def run_mcu(boards: list[str] | None, points: int, out: Path | None, as_json: bool, said: Callable[[str], None]) -> bool:
    """`python -m benchmarks mcu`; whether every emitted controller was within its bounds on every board."""
    chosen = [BOARDS[b] for b in boards or BOARDS]
    costs = list(all_boards(chosen, points, boards is not None, said))
    first = BOARDS["m4f"] if BOARDS["m4f"] in chosen else chosen[0]
    others = list(beside(first, points, said))
    by_dimension, by_crowd = growth(first, points, said)
    good = all(v.within is not False for v in (*costs, *others, *by_dimension, *by_crowd))
    parts = [
        "## Microcontrollers\n\n"
        f"Made by `{command()}`: `control` of the paper's arena {CASE[1]} (n = 2, 4 obstacles), -O2, {points} random points, "
        "the edges and a closed loop; emulated, so the same in every run. Instructions, for avr cycles. Bytes are of `control` "
        "and all it calls, without the C library; stack is painted, with it. agrees: within "
        "every bound of `compare` on that board.",
        table((*HEADINGS, "most at"), [row(v, f"{v.board}: {v.label}", True) for v in costs]),
        f"### Beside others, {first.title}, the same points\n\nCasADi's C and the floor test no input and tell no status.",
        table(HEADINGS, [row(v, v.label) for v in others]),
        f"### Growth, refined, {first.title}",
        table(("dimensions", *HEADINGS[1:]), [row(v, v.label) for v in by_dimension]),
        table(("obstacles", *HEADINGS[1:]), [row(v, v.label) for v in by_crowd]),
    ]
    if as_json:
        names = ("boards", "beside", "by_dimension", "by_obstacles")
        lines = (costs, others, by_dimension, by_crowd)
        document = {k: [vars(v) for v in part] for k, part in zip(names, lines, strict=True)}
        print(json.dumps({"within_bounds": good, **document}, indent=2))
    else:
        print("\n\n".join(parts))
    if out is not None:
        record(out, "mcu", "\n\n".join(parts))
    return good
