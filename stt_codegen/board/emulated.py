"""The emitted C on an emulated board: an image around it, run by QEMU or simavr, as a backend that `compare` can hold
against the reference; and what every call took, by the board's own counter.

Points are built into the image, results come back over semihosting or the UART as the bits of the numbers.
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
from stt_codegen.compare import Row, compare_backend
from stt_codegen.errors import BadInput, MissingTool, SttError
from stt_codegen.pipeline import EmittedController
from stt_codegen.program import TICK, Function, Param, Program
from stt_codegen.program.targets import run_compiler
from stt_codegen.program.targets.backend import Backend
from stt_codegen.program.targets.c import CPrinter
from stt_codegen.program.targets.template_files import template

Array = npt.NDArray[Any]
LONGEST_RUN = 300.0  # seconds
DECORATION = re.compile(r"\x1b\[[0-9;]*m|\.$")  # simavr colours a line and shows its end as a dot
RESULT = re.compile(r"([0-9a-f]{8} ?)+$")


CFLAGS = ("-O2", "-std=c99", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror")


@dataclass(frozen=True)
class CallCost:
    """What the calls of one function took in the board's unit, at which point most, and bytes of stack."""

    least: int
    median: int
    most: int
    worst_at: list[Any]
    stack: int

    def place(self, names: Sequence[str]) -> str:
        """Where a call took most, with the names of the function's arguments: t = 6.11, x = (3.91, 2.7)."""
        return ", ".join(f"{name} = {_short(v)}" for name, v in zip(names, self.worst_at, strict=True))


def _short(value: Any) -> str:
    return f"({', '.join(f'{v:.4g}' for v in value)})" if isinstance(value, list) else f"{value:.4g}"


@dataclass
class Counts:
    """What the calls of one function took, in the board's unit, and how many bytes of stack they used, by point."""

    taken: Array
    stack: Array
    inputs: tuple[Array, ...]

    def summary(self) -> CallCost:
        worst = int(np.argmax(self.taken))
        at = [np.asarray(v)[worst].tolist() for v in self.inputs]
        least, median, most = (round(float(v)) for v in (self.taken.min(), np.median(self.taken), self.taken.max()))
        return CallCost(least, median, most, at, int(self.stack.max()))


class Emulated(Backend):
    """The emitted C on a board. `counts` collects what each function's calls took."""

    def __init__(self, controller: EmittedController, board: Board, extra: tuple[str, ...] = (), rust: bool = False) -> None:
        if rust and not board.rust:
            raise BadInput(f"--board {board.name}: Rust is linked with C on ARM boards alone: {', '.join(rust_boards())}")
        if controller.program.scalar not in (*board.scalars, "fixed"):
            raise BadInput(f"--board {board.name}: its compiler has no 64-bit {controller.program.scalar}; use --scalar float")
        source = controller.files[f"{controller.program.prefix}.c"].decode()
        missing = [f for f in board.lacks if f"{f}(" in source]
        if missing:
            raise BadInput(f"--board {board.name}: its C library has no {', '.join(missing)}; use --design refined")
        for tool in (board.compiler, board.command[0]):
            if shutil.which(tool) is None:
                raise MissingTool(f"{tool} is not found; for board {board.name} install (Debian names): {board.packages}")
        self.controller, self.board, self.flags, self.rust = controller, board, (*CFLAGS, *extra), rust
        self.program, self.scalar = controller.program, controller.program.scalar
        self.name = f"{'Rust' if rust else 'C'} {self.scalar} on {board.name}"
        self.number: Any = {"float": np.float32, "double": np.float64, "fixed": np.int32}[self.scalar]
        self.counts: dict[str, Counts] = {}

    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        f = self.program.function(function)
        words = np.hstack([self._words(p, v) for p, v in zip(f.inputs, inputs, strict=True)])
        chunk = max(1, self.board.room // (4 * words.shape[1]))
        rows = np.concatenate([self._run(f, words[k : k + chunk]) for k in range(0, len(words), chunk)])
        taken, stack = rows[:, 1] / self.board.ticks, rows[:, 2]
        if function in self.counts:
            before = self.counts[function]
            taken, stack = np.concatenate([before.taken, taken]), np.concatenate([before.stack, stack])
            inputs_so_far = tuple(np.concatenate([a, b]) for a, b in zip(before.inputs, inputs, strict=True))
        else:
            inputs_so_far = inputs
        self.counts[function] = Counts(taken, stack, inputs_so_far)
        results, at = [], 3
        per = self.number().itemsize // 4
        for length in [1] * f.returns_real + [p.length or 0 for p in f.outputs]:
            bits = np.ascontiguousarray(rows[:, at : at + length * per])
            results.append(bits.view(self.number).reshape(len(rows), length))
            at += length * per
        if f.returns_real:
            return (results[0].ravel(), *results[1:])
        return (rows[:, 0].astype(int), *results) if f.returns_status or f.returns_bool else tuple(results)

    def _words(self, p: Param, values: Array) -> Array:
        """The bits of one parameter at every point, in words of 32; a count is one number's worth, padded."""
        numbers = np.ascontiguousarray(np.asarray(values, np.uint32 if p.type is TICK else self.number).reshape(len(values), -1))
        words = numbers.view(np.uint32).reshape(len(numbers), -1)
        pad = self.number().itemsize // 4 - 1 if p.type is TICK else 0
        return np.pad(words, ((0, 0), (0, pad)))

    def _run(self, f: Function, words: Array) -> Array:
        """One image with these points: rows of status, ticks, bytes of stack, and output words."""
        with tempfile.TemporaryDirectory() as folder:
            image = build_image(self.controller, self.board, f, words, Path(folder), self.flags, self.rust)
            try:
                result = subprocess.run(  # semihosting writes to either stream
                    [*self.board.command, str(image)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                    text=True, timeout=LONGEST_RUN, check=False,
                )  # fmt: skip
            except subprocess.TimeoutExpired:
                raise SttError(f"{self.board.title}: the emulator did not finish within {LONGEST_RUN:.0f} s") from None
        lines = (DECORATION.sub("", line) for line in result.stdout.splitlines())
        rows = [[int(word, 16) for word in line.split()] for line in lines if RESULT.match(line)]
        if len(rows) != len(words):
            raise SttError(
                f"{self.board.title}: the image gave {len(rows)} results for {len(words)} points "
                f"(exit code {result.returncode}): {result.stdout.strip()[-300:]}"
            )
        if any(row[2] >= self.board.paint for row in rows):
            raise SttError(f"{self.board.title}: {f.name} uses more stack than the {self.board.paint} bytes that are painted")
        return np.array(rows, dtype=np.uint32)


def build_image(
    controller: EmittedController, board: Board, f: Function, words: Array, folder: Path, flags: Sequence[str], rust: bool = False
) -> Path:
    """The image that calls `f` at these points (words of their bits), in `folder`."""
    program = controller.program
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    sources, libraries = copy_board(board, folder)
    (folder / "harness.c").write_text(_harness(program, f, words))
    sources.append(str(folder / "harness.c"))
    sources += board_objects(controller, board.rust, folder) if rust else [str(folder / f"{program.prefix}.c")]
    image = folder / "image.elf"
    thin = ("-Wl,--gc-sections",) if rust else ()  # of the core library what is called
    run_compiler([board.compiler, *board.flags, *flags, *thin, f"-I{folder}", *sources, "-o", str(image), *libraries])
    return image


def _harness(program: Program, f: Function, words: Array) -> str:
    arrays: list[tuple[str, int, int | None]] = []
    arguments: list[str] = []
    offset, per = 0, 2 if program.scalar == "double" else 1
    for p in f.params:
        if p.length is None:
            arguments.append(f"raw[{offset * per}]" if p.type is TICK else f"given[{offset}]")
            offset += 1
            continue
        arguments.append(p.name)
        reads = not p.output or p.inout
        arrays.append((p.name, p.length, offset if reads else None))
        offset += p.length if reads else 0
    outputs = [(p.name, p.length) for p in f.outputs]
    length = 9 * (6 + sum((n or 0) * per for _, n in outputs))
    return template("board/harness.c.j2").render(
        prefix=program.prefix, real=CPrinter(program).real, function=f, numbers=offset, bits=32 * per, arrays=arrays,
        outputs=outputs, call=", ".join(arguments), line_length=length,
        points=[", ".join(f"0x{w:x}U" for w in row) for row in words.tolist()],
    )  # fmt: skip


def run_on_board(
    controller: EmittedController, board: Board, points: int, rust: bool = False
) -> tuple[list[Row], dict[str, CallCost]]:
    """The comparison with the reference on so many random points and the edges; and for each public function what its calls
    took: least, median and most in the board's unit, the inputs of the longest, and the most stack."""
    made: list[Emulated] = []

    def make(given: EmittedController) -> Emulated:
        made.append(Emulated(given, board, rust=rust))
        return made[-1]

    rows = compare_backend(controller, make, points)
    public = {f.name for f in controller.program.functions}
    costs = {name: counts.summary() for backend in made for name, counts in backend.counts.items() if name in public}
    return rows, costs
