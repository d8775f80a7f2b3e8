"""The emitted C on an emulated board: a backend that `compare` checks against the reference, and the cost of every call.

QEMU or simavr runs an image with the C. The points are built into the image; results come back over semihosting or the UART as
the bits of the numbers. The board's counter measures each call. `pil`, summary.py and benchmarks/ call this file.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.board.boards import Board, copy_board, rust_boards
from stt_codegen.board.rust_images import board_objects
from stt_codegen.compare import ComparisonRow, compare_backend
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.errors import BadInput, MissingTool, SttError
from stt_codegen.pipeline import EmittedController
from stt_codegen.program import TICK, Function, Param, Program
from stt_codegen.program.targets import run_compiler
from stt_codegen.program.targets.backend import Backend
from stt_codegen.program.targets.c import CPrinter
from stt_codegen.program.targets.template_files import template

Array = npt.NDArray[Any]
TIME_LIMIT = 300.0  # seconds for one image
DECORATION = re.compile(r"\x1b\[[0-9;]*m|\.$")  # simavr colours a line and shows its end as a dot
RESULT = re.compile(r"([0-9a-f]{8} ?)+$")
CFLAGS = ("-O2", "-std=c99", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror")


@dataclass(frozen=True)
class CallCost:
    """The cost of the calls of one function, in the board's unit, with the arguments of the costliest; stack in bytes."""

    minimum: int
    median: int
    maximum: int
    worst_arguments: list[Any]
    stack: int

    def document(self) -> dict[str, Any]:
        """Return the fields under the names that `pil --json` has always given them."""
        return {
            "least": self.minimum,
            "median": self.median,
            "most": self.maximum,
            "worst_at": self.worst_arguments,
            "stack": self.stack,
        }

    def describe_worst(self, names: Sequence[str]) -> str:
        """Write the arguments of the costliest call, with the function's names for them: t = 6.11, x = (3.91, 2.7)."""
        return ", ".join(f"{name} = {_format_argument(v)}" for name, v in zip(names, self.worst_arguments, strict=True))


def _format_argument(value: Any) -> str:
    return f"({', '.join(f'{v:.4g}' for v in value)})" if isinstance(value, list) else f"{value:.4g}"


@dataclass
class Counts:
    """The cost of each call of one function, in the board's unit, and its stack in bytes: one entry a point."""

    costs: Array
    stack: Array
    inputs: tuple[Array, ...]

    def summary(self) -> CallCost:
        """Return smallest, median and largest cost, and the arguments of the largest."""
        worst = int(np.argmax(self.costs))
        arguments = [np.asarray(v)[worst].tolist() for v in self.inputs]
        minimum, median, maximum = (round(float(v)) for v in (self.costs.min(), np.median(self.costs), self.costs.max()))
        return CallCost(minimum, median, maximum, arguments, int(self.stack.max()))


class Emulated(Backend):
    """The emitted C, or Rust, on a board. `counts` collects the costs of the calls by function.

    extra_flags: of the C compiler. Raises `BadInput` where the board cannot run this controller, `MissingTool` without a compiler
    or an emulator.
    """

    def __init__(
        self, controller: EmittedController, board: Board, extra_flags: tuple[str, ...] = (), rust: bool = False
    ) -> None:
        if rust and not board.rust_target:
            raise BadInput(f"--board {board.name}: Rust is linked with C on ARM boards alone: {', '.join(rust_boards())}")
        if controller.program.scalar not in (*board.scalars, "fixed"):
            raise BadInput(f"--board {board.name}: its compiler has no 64-bit {controller.program.scalar}; use --scalar float")
        source = controller.files[f"{controller.program.prefix}.c"].decode()
        missing = [f for f in board.missing_functions if f"{f}(" in source]
        if missing:
            kinds = kinds_offering("inlines_logarithm")
            raise BadInput(f"--board {board.name}: its C library has no {', '.join(missing)}; use --design {kinds}")
        for tool in (board.compiler, board.command[0]):
            if shutil.which(tool) is None:
                raise MissingTool(f"{tool} is not found; for board {board.name} install (Debian names): {board.packages}")
        self.controller, self.board, self.flags, self.rust = controller, board, (*CFLAGS, *extra_flags), rust
        self.program, self.scalar = controller.program, controller.program.scalar
        self.name = f"{'Rust' if rust else 'C'} {self.scalar} on {board.name}"
        self.number: Any = {"float": np.float32, "double": np.float64, "fixed": np.int32}[self.scalar]
        self.counts: dict[str, Counts] = {}

    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        """Run a function at every point. inputs: one array a parameter, (P,) or (P, length); returns its outputs, by point."""
        f = self.program.function(function)
        words = np.hstack([self._words(p, v) for p, v in zip(f.inputs, inputs, strict=True)])
        chunk = max(1, self.board.point_bytes // (4 * words.shape[1]))
        rows = np.concatenate([self._run(f, words[k : k + chunk]) for k in range(0, len(words), chunk)])
        self._add_counts(function, Counts(rows[:, 1] / self.board.ticks_per_unit, rows[:, 2], inputs))
        results, column = [], 3
        words_per_number = self.number().itemsize // 4
        for length in [1] * f.returns_real + [p.length or 0 for p in f.outputs]:
            bits = np.ascontiguousarray(rows[:, column : column + length * words_per_number])
            results.append(bits.view(self.number).reshape(len(rows), length))
            column += length * words_per_number
        if f.returns_real:
            return (results[0].ravel(), *results[1:])
        return (rows[:, 0].astype(int), *results) if f.returns_status or f.returns_bool else tuple(results)

    def _add_counts(self, function: str, counts: Counts) -> None:
        before = self.counts.get(function)
        if before is not None:
            inputs = tuple(np.concatenate(pair) for pair in zip(before.inputs, counts.inputs, strict=True))
            costs = np.concatenate([before.costs, counts.costs])
            counts = Counts(costs, np.concatenate([before.stack, counts.stack]), inputs)
        self.counts[function] = counts

    def _words(self, p: Param, values: Array) -> Array:
        """Return the bits of one parameter at every point in words of 32; a count of ticks is padded to a number's size."""
        numbers = np.ascontiguousarray(np.asarray(values, np.uint32 if p.type is TICK else self.number).reshape(len(values), -1))
        words = numbers.view(np.uint32).reshape(len(numbers), -1)
        pad = self.number().itemsize // 4 - 1 if p.type is TICK else 0
        return np.pad(words, ((0, 0), (0, pad)))

    def _run(self, f: Function, words: Array) -> Array:
        """Build and run one image with these points; return rows of status, ticks, bytes of stack, and output words."""
        with tempfile.TemporaryDirectory() as folder:
            image = build_image(self.controller, self.board, f, words, Path(folder), flags=self.flags, rust=self.rust)
            try:
                result = subprocess.run(  # semihosting writes to either stream
                    [*self.board.command, str(image)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                    text=True, timeout=TIME_LIMIT, check=False,
                )  # fmt: skip
            except subprocess.TimeoutExpired:
                raise SttError(f"{self.board.title}: the emulator did not finish within {TIME_LIMIT:.0f} s") from None
        lines = (DECORATION.sub("", line) for line in result.stdout.splitlines())
        rows = [[int(word, 16) for word in line.split()] for line in lines if RESULT.match(line)]
        if len(rows) != len(words):
            raise SttError(
                f"{self.board.title}: the image gave {len(rows)} results for {len(words)} points "
                f"(exit code {result.returncode}): {result.stdout.strip()[-300:]}"
            )
        if any(row[2] >= self.board.painted_stack for row in rows):
            raise SttError(
                f"{self.board.title}: {f.name} uses more stack than the {self.board.painted_stack} bytes that are painted"
            )
        return np.array(rows, dtype=np.uint32)


def build_image(
    controller: EmittedController,
    board: Board,
    f: Function,
    words: Array,
    folder: Path,
    *,
    flags: Sequence[str],
    rust: bool = False,
) -> Path:
    """Build the image that calls `f` at these points; return its path. words: the bits of the points, one row each."""
    program = controller.program
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    sources, libraries = copy_board(board, folder)
    (folder / "stt-harness.c").write_text(_harness(program, f, words))
    sources.append(str(folder / "stt-harness.c"))
    sources += board_objects(controller, board.rust_target, folder) if rust else [str(folder / f"{program.prefix}.c")]
    image = folder / "image.elf"
    without_unused = ("-Wl,--gc-sections",) if rust else ()  # Rust's core library is larger than a board's memory
    run_compiler([board.compiler, *board.flags, *flags, *without_unused, f"-I{folder}", *sources, "-o", str(image), *libraries])
    return image


def _harness(program: Program, f: Function, words: Array) -> str:
    """Return the C that calls `f` at each point, measures the call and writes its results as hexadecimal words."""
    arrays: list[tuple[str, int, int | None]] = []
    arguments: list[str] = []
    offset, words_per_number = 0, 2 if program.scalar == "double" else 1
    for p in f.params:
        if p.length is None:
            arguments.append(f"raw[{offset * words_per_number}]" if p.type is TICK else f"given[{offset}]")
            offset += 1
            continue
        arguments.append(p.name)
        reads = not p.output or p.inout
        arrays.append((p.name, p.length, offset if reads else None))
        offset += p.length if reads else 0
    outputs = [(p.name, p.length) for p in f.outputs]
    length = 9 * (6 + sum((n or 0) * words_per_number for _, n in outputs))
    return template("board/harness.c.j2").render(
        prefix=program.prefix, real=CPrinter(program).real, function=f, numbers=offset, bits=32 * words_per_number, arrays=arrays,
        outputs=outputs, call=", ".join(arguments), line_length=length,
        points=[", ".join(f"0x{w:x}U" for w in row) for row in words.tolist()],
    )  # fmt: skip


def run_on_board(
    controller: EmittedController, board: Board, points: int, rust: bool = False
) -> tuple[list[ComparisonRow], dict[str, CallCost]]:
    """Compare the controller on a board with the reference; return the comparison's rows, and the costs of each public function.

    points: how many random points, besides those at the edges.
    """
    backends: list[Emulated] = []

    def make_backend(compared: EmittedController) -> Emulated:
        backends.append(Emulated(compared, board, rust=rust))
        return backends[-1]

    rows = compare_backend(controller, make_backend, points)
    public = {f.name for f in controller.program.functions}
    costs = {name: counts.summary() for backend in backends for name, counts in backend.counts.items() if name in public}
    return rows, costs
