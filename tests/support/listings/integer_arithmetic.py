"""That the piece "arithmetic of integers" computes what integer_run.py says of it: both of its halves are compiled and run."""

from __future__ import annotations

import itertools
import subprocess
from functools import cache
from pathlib import Path
from random import Random

from stt_codegen.checker.stt_checker import source
from tests.support.listings.integer_run import ARITHMETIC, SHIFT
from tests.support.listings.reader import require

PROGRAM_SPACE = """#define PROGMEM
#define pgm_read_byte(address) (*(const uint8_t *)(address))
#define pgm_read_word(address) (*(const uint16_t *)(address))
#define pgm_read_dword(address) (*(const uint32_t *)(address))
"""
# Shifts by a constant have branches of their own on an AVR. -1 and -2^31 are in the table of 32 bits.
HARNESS = """#include <stdint.h>
#include <stdio.h>
{text}
static const uint8_t bytes[] M_FLASH = {{ 0, 1, 255 }};
static const uint16_t words[] M_FLASH = {{ 0, 1, 65535 }};
static const int32_t entries[] M_FLASH = {{ 1, -1, -2147483647 - 1 }};
static int32_t run(int32_t k, int32_t a, int32_t b)
{{
    switch (k) {{
        case 0: return P_shift_down(a, b);
        case 1: return P_shift_up(a, b);
        case 2: return P_product(a, b);
        case 3: return P_high_product(a, b);
        case 4: return P_leading(a);
        case 5: return P_low_bits(a, b);
        case 6: return M_READ_8(bytes[a]);
        case 7: return M_READ_16(words[a]);
        case 8: return M_READ_32(entries[a]);
        {constant_shifts}
        default: return 0;
    }}
}}
int main(void)
{{
    int32_t k, a, b;
    while (scanf("%d %d %d", &k, &a, &b) == 3) {{ printf("%d\\n", run(k, a, b)); }}
    return 0;
}}
"""
TABLES = ((0, 1, 255), (0, 1, 65535), (1, -1, -(1 << 31)))
FIRST_CONSTANT_SHIFT = 100


@cache
def cases() -> list[tuple[tuple[int, int, int], int]]:
    """Return operations with their operands, and the results: the ends of operands, powers of two and their neighbours, random ones."""
    random, known = Random(3), list[tuple[tuple[int, int, int], int]]()
    for k, (name, (operation, domains)) in enumerate(ARITHMETIC.items()):
        near = [v + more for v in (0, *(1 << bits for bits in range(32)), -(1 << 15), -(1 << 31)) for more in (-1, 0, 1)]
        columns = [sorted({v for v in (*near, *(random.choice(d) for _ in range(20))) if v in d}) for d in domains]
        if name == "low_bits":
            columns[1] = [(1 << bits) - 1 for bits in range(32)]
        for a, *rest in itertools.product(*columns):
            result, b = operation(a, *rest), rest[0] if rest else 0
            result &= 0x7FFFFFFF if name == "shift_up" else -1
            known.append(((k, a, b), result))
            if name == "shift_down":
                known.append(((FIRST_CONSTANT_SHIFT + b, a, 0), result))
    return known + [((6 + j, k, 0), entry) for j, table in enumerate(TABLES) for k, entry in enumerate(table)]


def check_arithmetic(compiler: str, folder: Path, is_avr: bool) -> None:
    """Compile one half of the piece for this machine, and require the results of all cases. Undefined behaviour ends the program."""
    (folder / "avr").mkdir(exist_ok=True)
    (folder / "avr" / "pgmspace.h").write_text(PROGRAM_SPACE)
    shifts = " ".join(f"case {FIRST_CONSTANT_SHIFT + n}: return P_shift_down(a, {n});" for n in SHIFT)
    text = "\n".join(source.chosen_lines("arithmetic of integers", set()))
    (folder / "a.c").write_text(HARNESS.format(text=text, constant_shifts=shifts))
    flags = ["-std=gnu11", "-O1", "-fsanitize-undefined-trap-on-error", "-fsanitize=undefined", "-I."]
    command = [compiler, *flags, *(["-D__AVR__"] if is_avr else []), "a.c", "-o", "a.out"]
    compilation = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    require(compilation.returncode == 0, "the arithmetic does not compile")
    operands = "".join(f"{k} {a} {b}\n" for (k, a, b), _ in cases())
    result = subprocess.run(["./a.out"], cwd=folder, input=operands, capture_output=True, text=True, timeout=60, check=False)
    require(result.returncode == 0, "the arithmetic has undefined behaviour")
    for (operation, wanted), line in zip(cases(), result.stdout.split(), strict=True):
        require(int(line) == wanted, f"operation {operation} gives {line} and not {wanted}")
