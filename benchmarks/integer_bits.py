"""Whether controllers in integers give the same bits everywhere: the emitted Python, the C on this machine and on every board.

    python -m benchmarks integer_bits [--task omni_s2 crane] [--inputs 1000000] [--board m0 ...]

`tube`, `control`, `margin` and `covered` (of order 2 `filtered_tube` too) at ticks and states drawn by the same generator
everywhere: any bit patterns, the edges with two units about them, places all through the tube and beside it. What comes out
is folded into one number for each block of inputs, which the board writes. The command ends with 1 where two of these differ.
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
FOLD = re.compile("[0-9a-f]{8}")  # as a board writes it
MASK = 2**32 - 1
OFFSET, PRIME = 2166136261, 16777619  # of the hash FNV-1a, here by words

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
    """256 times lambda, rounded; empty for order 1."""
    return [round(256 * Fraction(v)) for v in controller.design.filter]


def driver(controller: EmittedController, inputs: int) -> str:
    """The C that draws the inputs and folds what comes out."""
    filter_, name = filter_of(controller), controller.program.prefix
    words = {"p": name, "P": name.upper(), "blocks": BLOCKS, "inputs": inputs // BLOCKS, "filter": ", ".join(map(str, filter_))}
    return DRIVER % {**words, "moving": MOVING % words if filter_ else "", "states": "x, v" if filter_ else "x"}


def folded(text: bytes, inputs: int, filter_: list[int], block: int) -> str:
    """The same by the emitted Python, of one block."""
    module = load_module("emitted", text)
    seed, fold = block * 2654435761 & MASK, OFFSET

    def draw() -> int:
        nonlocal seed
        seed ^= seed << 13 & MASK
        seed ^= seed >> 17
        seed ^= seed << 5 & MASK
        return seed

    def signed(word: int) -> int:
        return (word + 2**31 & MASK) - 2**31

    def keep(word: int) -> None:
        nonlocal fold
        fold = (fold ^ word & MASK) * PRIME & MASK

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
                keep(edge)
            states[0].append(near_tube(word & 3, *pair))
        if filter_:
            states.append([])
            for i, pair in enumerate(zip(*module.filtered_tube(tick), strict=True)):
                for edge in pair:
                    keep(edge)
                r = near_tube(word >> 2 & 3, *pair)
                states[1].append(signed(r - (states[0][i] >> 8 & 0xFFFF) * filter_[i]))
        status, u = module.control(tick, *states)
        for out in (status, *u, module.margin(tick, *states), int(module.covered(*states))):
            keep(out)
    return f"{fold:08x}"


def on_board(controller: EmittedController, board: Board | None, inputs: int) -> list[str]:
    """What the C gives, on a board or on this machine, by block."""
    with tempfile.TemporaryDirectory() as folder:
        name = controller.program.prefix
        for file, data in controller.files.items():
            Path(folder, file).write_bytes(data)
        own = Path(folder, "driver.c")
        own.write_text((HOST if board is None else '#include "board.h"\n') + driver(controller, inputs))
        image, mine = Path(folder, "image.elf"), [str(own), str(Path(folder, f"{name}.c"))]
        if board is None:
            run_compiler(["cc", *CFLAGS, f"-I{folder}", *mine, "-o", str(image)])
        else:
            sources, libraries = copy_board(board, Path(folder))
            run_compiler([board.compiler, *board.flags, *CFLAGS, f"-I{folder}", *sources, *mine, "-o", str(image), *libraries])
        command = [*(board.command if board else ()), str(image)]
        out = subprocess.run(command, capture_output=True, stdin=subprocess.DEVNULL, text=True, check=False)
    lines = (DECORATION.sub("", line) for line in (out.stdout + out.stderr).splitlines())  # semihosting writes to either
    return [line for line in lines if FOLD.fullmatch(line)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--task", nargs="+", default=["omni_s2", "crane"])
    parser.add_argument("--inputs", type=int, default=1_000_000)
    parser.add_argument("--board", choices=tuple(BOARDS), action="append")
    asked = parser.parse_args()
    rows, wrong = [], 0
    for task in asked.task:
        controller = build_task(limited(load_task(ROOT / "tasks" / f"{task}.toml")))
        began, text = time.perf_counter(), controller.files[f"{controller.program.prefix}.py"]
        with ProcessPoolExecutor() as pool:
            told = partial(folded, text, asked.inputs, filter_of(controller))
            expected = list(pool.map(told, range(1, BLOCKS + 1)))
        rows.append([task, "Python", f"{asked.inputs:,}", "-", f"{time.perf_counter() - began:.0f}"])
        for one in (None, *(asked.board or BOARDS)):
            began = time.perf_counter()
            got = on_board(controller, BOARDS[one] if one else None, asked.inputs)
            differ = sum(a != b for a, b in zip(got, expected, strict=False)) + abs(len(got) - len(expected))
            wrong += differ
            rows.append([task, one or "this machine", f"{asked.inputs:,}", str(differ), f"{time.perf_counter() - began:.0f}"])
    print(table(["task", "on", "inputs", f"of {BLOCKS} blocks other than the Python's", "seconds"], rows))
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
