"""List where the emitted C deviates from MISRA C:2012 and why, and count deviations with cppcheck. docs/c.md has the same
table."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

CHECKER = "cppcheck"


@dataclass(frozen=True)
class Deviation:
    """A rule from which some emitted file deviates. where: names in Markdown, with <p> for the task's name, <P> in capitals."""

    rule: str
    kind: str
    where: str
    why: str


DEVIATIONS = {
    deviation.rule: deviation
    for deviation in (
        Deviation(
            "2.3", "advisory", "`<p>_real_size`, inline logarithms only; `<p>_shifts_down`, integers only",
            "a type that cannot be made where the scalar or the compiler is another one: C99 has no static assertion",
        ),
        Deviation(
            "2.5", "advisory", "`<P>_T_C`, `<P>_DESIGN_HASH`, `<P>_TICK_PERIOD`, `<P>_DT_SHORTEST`, `<P>_DT_LONGEST`",
            "macros for your firmware; the file itself needs none of them",
        ),
        Deviation(
            "8.9", "advisory", "tables of one function: gains and limits by component, those of `<p>_selftest.c`",
            "tables stand before the code, where a reviewer looks for them",
        ),
        Deviation(
            "10.1", "required", "`<p>_shift_down`, integers only",
            "a negative number moves right as by a division that rounds down; a type that cannot be made says so of the compiler",
        ),
        Deviation(
            "15.5", "advisory", "a return for bad input before the law",
            "the law below it then reads as the paper's, without a flag around it",
        ),
        Deviation(
            "21.15", "required", "`memcpy` between a number and an integer of its size, inline logarithms only",
            "the one way to the bits of a number that C and C++ both define",
        ),
    )
}  # fmt: skip


def count_deviations(files: Mapping[str, bytes]) -> dict[str, int] | None:
    """Count the deviations from each rule in the C of these files, taken as one program; None without cppcheck."""
    checker = shutil.which(CHECKER)
    if checker is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        for name, data in files.items():
            if name.endswith((".c", ".h")):
                Path(folder, name).write_bytes(data)
        paths = sorted(str(p) for p in Path(folder).glob("*.c"))
        command = [checker, "--std=c99", "--addon=misra", "-q", *paths]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode:
        return None
    rules = Counter(re.findall(r"\[misra-c2012-(\d+\.\d+)\]", result.stderr))
    return dict(sorted(rules.items(), key=lambda deviation: [int(v) for v in deviation[0].split(".")]))
