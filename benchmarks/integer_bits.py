"""Check that controllers in integers give the same bits in the emitted Python, in C on this machine, and on every board.

    python -m benchmarks integer_bits [--task omni_s2 crane] [--inputs 1000000] [--board m0 ...]

It calls `tube`, `control`, `margin` and `covered`, and of order 2 `filtered_tube`. The same generator draws ticks and states
everywhere: any bit patterns, values up to two units from an edge, and values in and near the tube. The outputs of a block of
inputs are hashed into one number, which the board writes. The exit code is 1 where two hashes differ.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from functools import partial
from pathlib import Path

from benchmarks.fixed import ROOT, limited
from benchmarks.suites.report import table
from stt_codegen.board.boards import BOARDS, Board, copy_board
from stt_codegen.board.emulated import CFLAGS, DECORATION
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.program.targets.toolchain import run_compiler
from stt_codegen.task.load import load_task

BLOCKS = 16
HASH = re.compile("[0-9a-f]{8}")  # as a board writes it
MASK = 2**32 - 1
OFFSET, PRIME = 2166136261, 16777619  # of the hash FNV-1a, by words of 32 bits instead of bytes

HOST = """#include <stdint.h>
#include <stdio.h>
static void board_start(void) {}
static void board_write(const char *text) { (void)fputs(text, stdout); }
static void board_stop(void) {}
"""

DRIVER = """
#include "%(p)s.h"

static uint32_t seed;
static uint32_t fold;

static uint32_t draw(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed;
}

static void keep(uint32_t word)
{
    fold = (fold ^ word) * 16777619U;
}

static int32_t near_tube(uint32_t kind, int32_t lower, int32_t upper)
{
    const uint32_t width = (uint32_t)upper - (uint32_t)lower;
    if (kind == 0U) {
        return (int32_t)draw();
    }
    if (kind == 1U) {
        return (int32_t)((uint32_t)lower + (draw() %% 5U) - 2U);
    }
    if (kind == 2U) {
        return (int32_t)((uint32_t)upper + (draw() %% 5U) - 2U);
    }
    return (int32_t)((uint32_t)lower + (draw() %% ((2U * width) + 1U)) - (width / 2U));
}

int main(void)
{
    board_start();
    for (uint32_t block = 1; block <= %(blocks)dU; block++) {
        seed = block * 2654435761U;
        fold = 2166136261U;
        for (uint32_t k = 0; k < %(inputs)dU; k++) {
            const uint32_t any = draw();
            const uint32_t tick = ((any & 16U) != 0U) ? draw() : draw() %% (%(P)s_TICKS + 2U);
            int32_t lower[%(P)s_N], upper[%(P)s_N], x[%(P)s_N], u[%(P)s_N];
            %(p)s_tube(tick, lower, upper);
            for (int i = 0; i < %(P)s_N; i++) {
                keep((uint32_t)lower[i]);
                keep((uint32_t)upper[i]);
                x[i] = near_tube(any & 3U, lower[i], upper[i]);
            }
%(moving)s
            keep((uint32_t)%(p)s_control(tick, %(states)s, u));
            for (int i = 0; i < %(P)s_N; i++) {
                keep((uint32_t)u[i]);
            }
            keep((uint32_t)%(p)s_margin(tick, %(states)s));
            keep(%(p)s_covered(%(states)s) ? 1U : 0U);
        }
        char text[] = "00000000\\n";
        for (int k = 0; k < 8; k++) {
            text[k] = "0123456789abcdef"[(fold >> (28 - (4 * k))) & 15U];
        }
        board_write(text);
    }
    board_stop();
    return 0;
}
"""

MOVING = """            static const int32_t filter[%(P)s_N] = {%(filter)s}; /* 256 times lambda */
            int32_t v[%(P)s_N];
            %(p)s_filtered_tube(tick, lower, upper);
            for (int i = 0; i < %(P)s_N; i++) {
                keep((uint32_t)lower[i]);
                keep((uint32_t)upper[i]);
                const uint32_t r = (uint32_t)near_tube((any >> 2) & 3U, lower[i], upper[i]);
                v[i] = (int32_t)(r - (uint32_t)((x[i] >> 8) & 0xffff) * (uint32_t)filter[i]);
            }"""


def filter_of(controller: EmittedController) -> list[int]:
    """Return 256 times lambda for each axis, rounded; an empty list for order 1."""
    return [round(256 * Fraction(v)) for v in controller.design.filter]


def driver_text(controller: EmittedController, inputs: int) -> str:
    """Return the C program that draws the inputs, calls the controller and hashes its outputs."""
    filter_, name = filter_of(controller), controller.program.prefix
    words = {"p": name, "P": name.upper(), "blocks": BLOCKS, "inputs": inputs // BLOCKS, "filter": ", ".join(map(str, filter_))}
    return DRIVER % {**words, "moving": MOVING % words if filter_ else "", "states": "x, v" if filter_ else "x"}


def python_hash(text: bytes, inputs: int, filter_: list[int], block: int) -> str:
    """Return the hash of one block by the emitted Python, as the C program computes it. text: of the Python module."""
    module = load_module("emitted", text)
    seed, hash_ = block * 2654435761 & MASK, OFFSET

    def draw() -> int:
        nonlocal seed
        seed ^= seed << 13 & MASK
        seed ^= seed >> 17
        seed ^= seed << 5 & MASK
        return seed

    def signed(word: int) -> int:
        return (word + 2**31 & MASK) - 2**31

    def update_hash(word: int) -> None:
        nonlocal hash_
        hash_ = (hash_ ^ word & MASK) * PRIME & MASK

    def near_tube(kind: int, lower: int, upper: int) -> int:
        width = upper - lower & MASK
        if kind == 0:
            return signed(draw())
        if kind == 3:
            return signed(lower + draw() % ((2 * width + 1) & MASK) - width // 2)
        return signed((lower if kind == 1 else upper) + draw() % 5 - 2)

    for _ in range(inputs // BLOCKS):
        word = draw()
        tick = draw() if word & 16 else draw() % (module.TICKS + 2)
        states = [[]]
        for pair in zip(*module.tube(tick), strict=True):
            for edge in pair:
                update_hash(edge)
            states[0].append(near_tube(word & 3, *pair))
        if filter_:
            states.append([])
            for i, pair in enumerate(zip(*module.filtered_tube(tick), strict=True)):
                for edge in pair:
                    update_hash(edge)
                r = near_tube(word >> 2 & 3, *pair)
                states[1].append(signed(r - (states[0][i] >> 8 & 0xFFFF) * filter_[i]))
        status, u = module.control(tick, *states)
        for output in (status, *u, module.margin(tick, *states), int(module.covered(*states))):
            update_hash(output)
    return f"{hash_:08x}"


def c_hashes(controller: EmittedController, board: Board | None, inputs: int) -> list[str]:
    """Return the hashes of all blocks by the C, on a board, or on this machine (None)."""
    with tempfile.TemporaryDirectory() as folder:
        name = controller.program.prefix
        for file, data in controller.files.items():
            Path(folder, file).write_bytes(data)
        driver_file = Path(folder, "driver.c")
        driver_file.write_text((HOST if board is None else '#include "stt-board.h"\n') + driver_text(controller, inputs))
        image, c_files = Path(folder, "image.elf"), [str(driver_file), str(Path(folder, f"{name}.c"))]
        if board is None:
            run_compiler(["cc", *CFLAGS, f"-I{folder}", *c_files, "-o", str(image)])
        else:
            sources, libraries = copy_board(board, Path(folder))
            run_compiler([board.compiler, *board.flags, *CFLAGS, f"-I{folder}", *sources, *c_files, "-o", str(image), *libraries])
        command = [*(board.command if board else ()), str(image)]
        process = subprocess.run(command, capture_output=True, stdin=subprocess.DEVNULL, text=True, check=False)
    lines = (DECORATION.sub("", line) for line in (process.stdout + process.stderr).splitlines())  # semihosting writes to either
    return [line for line in lines if HASH.fullmatch(line)]


def main() -> int:
    """Compare all hashes, and print the table. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--task", nargs="+", default=["omni_s2", "crane"])
    parser.add_argument("--inputs", type=int, default=1_000_000)
    parser.add_argument("--board", choices=tuple(BOARDS), action="append")
    options = parser.parse_args()
    rows, differing = [], 0
    for task in options.task:
        controller = build_task(limited(load_task(ROOT / "tasks" / f"{task}.toml")))
        begin, text = time.perf_counter(), controller.files[f"{controller.program.prefix}.py"]
        with ProcessPoolExecutor() as pool:
            hash_block = partial(python_hash, text, options.inputs, filter_of(controller))
            expected = list(pool.map(hash_block, range(1, BLOCKS + 1)))
        rows.append([task, "Python", f"{options.inputs:,}", "-", f"{time.perf_counter() - begin:.0f}"])
        for board in (None, *(options.board or BOARDS)):
            begin = time.perf_counter()
            hashes = c_hashes(controller, BOARDS[board] if board else None, options.inputs)
            count = sum(a != b for a, b in zip(hashes, expected, strict=False)) + abs(len(hashes) - len(expected))
            differing += count
            rows.append([task, board or "this machine", f"{options.inputs:,}", str(count), f"{time.perf_counter() - begin:.0f}"])
    print(table(["task", "on", "inputs", f"of {BLOCKS} blocks other than the Python's", "seconds"], rows))
    return int(differing > 0)


if __name__ == "__main__":
    raise SystemExit(main())
