"""Measure emitted controllers on emulated microcontrollers: instructions (exact), bytes of code, tables, RAM and stack.

`python -m benchmarks mcu` calls this (benchmarks/command_line.py). CasADi's C, C written by hand and a lower limit are measured
at the same points, and the growth with the dimension and the obstacles. Every run also compares the results with the reference,
so that a cost is of code within its error bounds.
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

# Of the paper's case study: label, design, scalar, math. A board that cannot run a variant leaves it out.
VARIANTS = (
    ("refined", "refined", "float", "libm"),
    ("refined, inline", "refined", "float", "inline"),
    ("refined, double", "refined", "double", "libm"),
    ("adaptive", "adaptive", "float", "libm"),
)
PAPER_CASE = FAMILIES["paper"], 0  # family and seed: 4 obstacles, n = 2, 9 s
DIMENSIONS = tuple(range(1, 13))
OBSTACLE_COUNTS = (  # family, unsafe sets
    ("empty", 0),
    ("paper", 4),
    ("dense12", 12),
    ("dense24", 24),
    ("corridor", 1000),
)


@dataclass(frozen=True)
class BoardCost:
    """The cost of `control` of one controller on one board.

    minimum, median, maximum: in the board's unit, instructions or cycles. worst_arguments: those of the maximum, as text. code,
    tables, ram: bytes of `control` and all it calls, without the C library. stack: bytes, with the library. within_bounds:
    whether the results are within the bounds of compare; None where they are not compared.
    """

    board: str
    label: str
    unit: str
    minimum: float
    median: float
    maximum: float
    worst_arguments: str
    code: int
    tables: int
    ram: int
    stack: int
    within_bounds: bool | None


def arena_controller(
    design: str, scalar: str, math: str, family: Family = PAPER_CASE[0], seed: int = PAPER_CASE[1], *, rust: bool = False
) -> EmittedController:
    """Build the controller of an arena; the paper's where no family is given."""
    task = arena_task(family, seed).with_options(design, scalar)
    return build_task(task.model_copy(update={"emit": task.emit.model_copy(update={"math": math, "rust": rust})}))


def measure_on_board(
    controller: EmittedController, board: Board, label: str, points: int, rust: bool = False
) -> tuple[BoardCost, Counts]:
    """Compare a controller with the reference on a board. Return its cost there, and the counts of `control`.

    points: random ones, beside the edges. rust: whether the Rust runs instead of the C.
    """
    backends: list[Emulated] = []

    def make(compared: EmittedController) -> Emulated:
        backends.append(Emulated(compared, board, rust=rust))
        return backends[-1]

    rows = compare_backend(controller, make, points)
    counts = next(backend.counts["control"] for backend in backends if "control" in backend.counts)
    return board_cost(controller, board, label, counts, all(r.holds for r in rows), rust=rust), counts


def other_costs(board: Board, sources: dict[str, str], points: int = 200) -> Iterator[BoardCost]:
    """Yield the costs of the emitted `control` and of peers' C texts with `decide` (peers/driven.py), at the same points.

    sources: the C texts, by label.
    """
    controller = arena_controller("refined", "float", "libm")
    cost, counts = measure_on_board(controller, board, "emitted, refined", points)
    yield cost
    yield measure_on_board(arena_controller("refined", "float", "inline"), board, "emitted, refined, inline", points)[0]
    for label, source in sources.items():
        yield rival_cost(controller, board, label, as_control(controller.task.name, source), counts)


def board_cost(
    controller: EmittedController, board: Board, label: str, counts: Counts, within_bounds: bool | None, *, rust: bool = False
) -> BoardCost:
    """Return the cost of counted calls of `control`, with the sizes of its code."""
    call_cost = counts.summary()
    code, tables, ram = sizes(controller, board, rust=rust)
    worst_arguments = call_cost.describe_worst([p.name for p in controller.program.function("control").inputs])
    steps = (call_cost.minimum, call_cost.median, call_cost.maximum)
    return BoardCost(board.name, label, board.unit, *steps, worst_arguments, code, tables, ram, call_cost.stack, within_bounds)


def sizes(controller: EmittedController, board: Board, function: str = "control", rust: bool = False) -> tuple[int, int, int]:
    """Return the bytes of code, tables and RAM that `function` and all it calls need, at -O2.

    The C library is not counted; what Rust calls of its core library is. Raises MissingTool.
    """
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
        link_flags = f"-Wl,-r,--gc-sections,-e,{p}_{function}"
        subprocess.run([*base, "-nostdlib", "-nostartfiles", link_flags, *objects, "-o", "kept.o"], cwd=folder, check=True)
        lines = subprocess.run([_size_tool(board), "-A", "kept.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
    fields = [line.split() for line in lines.splitlines()]
    sections = [(words[0], int(words[1])) for words in fields if len(words) == 3 and words[0][0] == "."]

    def total(*kinds: str) -> int:
        return sum(size for name, size in sections if name.startswith(kinds))

    tables = total(".rodata", ".srodata")
    in_ram = tables if board.name == "avr" else 0  # AVR loads constants from RAM
    return total(".text"), tables, total(".data", ".sdata", ".bss", ".sbss") + in_ram


def _size_tool(board: Board) -> str:
    return board.compiler.removesuffix("gcc") + "size"


def variant_costs(boards: Sequence[Board], points: int, named: bool, say: Callable[[str], None]) -> Iterator[BoardCost]:
    """Yield the cost of every variant on every board that can run it.

    A board whose tools are missing is left out; with `named` MissingTool is raised instead. say: called with what runs now.
    """
    for board in boards:
        for label, design, scalar, math in VARIANTS:
            say(f"{board.name}: {label}")
            try:
                cost, _ = measure_on_board(arena_controller(design, scalar, math), board, label, points)
            except BadInput:  # the board has no double, or its library lacks a function
                continue
            except MissingTool as error:
                if named:
                    raise
                say(f"{board.name} is left out: {error}")
                break
            yield cost


def rival_costs(board: Board, points: int, say: Callable[[str], None]) -> Iterator[BoardCost]:
    """Yield the costs of the emitted `control`, of CasADi's, of a hand-written one and of the lower limit, at the same points."""
    for design in ("refined", "adaptive"):
        controller = arena_controller(design, "float", "libm")
        cost, counts = measure_on_board(controller, board, f"emitted, {design}", points)
        yield cost
        rivals = [
            ("CasADi's C, as generated", casadi_text(controller, False)),
            ("CasADi's C, single precision", casadi_text(controller, True)),
        ]
        if controller.design.capabilities.inlines_logarithm:
            yield replace(
                measure_on_board(arena_controller("refined", "float", "inline"), board, "emitted, refined, inline", points)[0]
            )
            yield from rust_costs(board, points, say)
            rivals += [("written by hand", hand_text(controller)), ("n logarithms, n divisions", floor_text(controller))]
        for label, text in rivals:
            say(f"{board.name}: {label}, {design}")
            yield rival_cost(controller, board, f"{label}, {design}", text, counts)


def rust_costs(board: Board, points: int, say: Callable[[str], None]) -> Iterator[BoardCost]:
    """Yield the costs of the two refined controllers as Rust; none where the board or this machine has no Rust."""
    if not board.rust_target:
        return
    for label, math in (("emitted as Rust, refined", "libm"), ("emitted as Rust, refined, inline", "inline")):
        say(f"{board.name}: {label}")
        try:
            yield measure_on_board(arena_controller("refined", "float", math, rust=True), board, label, points, rust=True)[0]
        except MissingTool as error:
            say(f"{label} is left out: {error}")


def rival_cost(controller: EmittedController, board: Board, label: str, text: str, counts: Counts) -> BoardCost:
    """Return the cost of another C text of the same function, at the points of `counts`."""
    rival_controller = replace(controller, files={**controller.files, f"{controller.task.name}.c": text.encode()})
    backend = Emulated(rival_controller, board, extra_flags=("-w",))
    backend.call("control", *counts.inputs)
    return board_cost(rival_controller, board, label, backend.counts["control"], None)


def growth_costs(board: Board, points: int, say: Callable[[str], None]) -> tuple[list[BoardCost], list[BoardCost]]:
    """Return the costs of refined `control` in 1 to 12 dimensions without obstacles, and in the plane with 0 to 1,000 of them."""
    by_dimension, by_obstacles = [], []
    empty = replace(FAMILIES["paper"], name="empty", count=0)
    for n in DIMENSIONS:
        say(f"{board.name}: n = {n}")
        family = replace(empty, dimension=n)
        by_dimension.append(measure_on_board(arena_controller("refined", "float", "libm", family), board, str(n), points)[0])
    for name, count in OBSTACLE_COUNTS:
        say(f"{board.name}: {count} obstacles")
        family = empty if name == "empty" else FAMILIES[name]
        by_obstacles.append(measure_on_board(_first_certified(family), board, str(count), points)[0])
    return by_dimension, by_obstacles


def _first_certified(family: Family) -> EmittedController:
    """Return the controller of the first arena that has a certified tube. Raises BadInput where none of 20 has one."""
    for seed in range(20):
        try:
            return arena_controller("refined", "float", "libm", family, seed)
        except NotCertified:
            continue
    raise BadInput(f"{family.name}: none of the first 20 arenas has a certified tube")


HEADINGS = ("", "least / median / most seen", "code B", "tables B", "RAM B", "stack B", "agrees")


def table_row(line: BoardCost, name: str, with_worst: bool = False) -> list[str]:
    """A row of HEADINGS; with `place` the last column says where the worst was."""
    steps = f"{line.minimum:,.0f} / {line.median:,.0f} / {line.maximum:,.0f}"
    agrees = {True: "yes", False: "NO", None: "-"}[line.within_bounds]
    return [
        name,
        steps,
        *(f"{v:,}" for v in (line.code, line.tables, line.ram, line.stack)),
        agrees,
        *[line.worst_arguments] * with_worst,
    ]


def run_mcu(boards: list[str] | None, points: int, out: Path | None, as_json: bool, say: Callable[[str], None]) -> bool:
    """Run `python -m benchmarks mcu`. Return whether every emitted controller was within its bounds on every board."""
    board_list = [BOARDS[b] for b in boards or BOARDS]
    costs = list(variant_costs(board_list, points, boards is not None, say))
    first = BOARDS["m4f"] if BOARDS["m4f"] in board_list else board_list[0]
    rivals = list(rival_costs(first, points, say))
    by_dimension, by_obstacles = growth_costs(first, points, say)
    all_within_bounds = all(v.within_bounds is not False for v in (*costs, *rivals, *by_dimension, *by_obstacles))
    parts = [
        "## Microcontrollers\n\n"
        f"Made by `{command()}`: `control` of the paper's arena {PAPER_CASE[1]} (n = 2, 4 obstacles), -O2, {points} random "
        "points, the edges and a closed loop; emulated, so the same in every run. Instructions, for avr cycles. "
        "Bytes are of `control` "
        "and all it calls, without the C library; stack is painted, with it. agrees: within "
        "every bound of `compare` on that board.",
        table((*HEADINGS, "most at"), [table_row(v, f"{v.board}: {v.label}", True) for v in costs]),
        f"### Beside others, {first.title}, the same points\n\nCasADi's C and the floor test no input and tell no status.",
        table(HEADINGS, [table_row(v, v.label) for v in rivals]),
        f"### Growth, refined, {first.title}",
        table(("dimensions", *HEADINGS[1:]), [table_row(v, v.label) for v in by_dimension]),
        table(("obstacles", *HEADINGS[1:]), [table_row(v, v.label) for v in by_obstacles]),
    ]
    if as_json:
        names = ("boards", "beside", "by_dimension", "by_obstacles")
        lines = (costs, rivals, by_dimension, by_obstacles)
        document = {k: [vars(v) for v in part] for k, part in zip(names, lines, strict=True)}
        print(json.dumps({"within_bounds": all_within_bounds, **document}, indent=2))
    else:
        print("\n\n".join(parts))
    if out is not None:
        record(out, "mcu", "\n\n".join(parts))
    return all_within_bounds
