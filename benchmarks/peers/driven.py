"""Controllers of others in C, behind the interface of the loops, so that they meet the same arenas, starts and winds as ours."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.loop.compiled import LoadedController
from stt_codegen.program.targets.c.runner import find_compiler
from stt_codegen.program.targets.template_files import template, template_folder
from stt_codegen.program.targets.toolchain import run_compiler

ROUNDS = 5
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC")


def held(source: str, n: int, hertz: float, tube: object, real: str = "float", linked: Sequence[str] = ()) -> LoadedController:
    """A C text with `static int decide(real t, const real *x, real *u)`, called so many times a second and held between.

    tube: edges that the loop measures margins by, of ours; linked: more arguments for the compiler. Raises `MissingTool` without
    one.
    """
    text = template("bench/held.c.j2").render(source=source, n=n, hertz=repr(float(hertz)), real=real)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "other.c").write_text(text)
        made = f"{folder}/other.so"
        run_compiler([find_compiler(), *FLAGS, f"{folder}/other.c", *linked, "-o", made, "-lm"])
        library = ctypes.CDLL(made)
    return LoadedController(step=library.other_step, tube=tube, advance=None, start=library.other_start, library=library)


def as_control(p: str, source: str) -> str:
    """Such a text as <p>_control, in single precision, for a board."""
    good, outside = f"{p.upper()}_OK", f"{p.upper()}_OUTSIDE_TUBE"
    return (
        f'#include "{p}.h"\ntypedef float real;\nstatic int decide(real t, const real *x, real *u);\n{source}\n'
        f"{p}_status {p}_control(float t, const float *x, float *u)\n{{\n    return decide(t, x, u) ? {outside} : {good};\n}}\n"
    )


def seconds_a_step(own: LoadedController, rows: npt.NDArray[Any]) -> float:
    """How long the controller takes, called once at every row of t and x: the quickest of ROUNDS, for what disturbs a
    machine only ever adds."""
    table, found = np.ascontiguousarray(rows, dtype=float), []
    for _ in range(ROUNDS):
        own.start()
        found.append(_timer()(own.step, table.ctypes.data, table.shape[1] - 1, len(table)))
    return float(min(found))


@cache
def _timer() -> Any:
    with tempfile.TemporaryDirectory() as folder:
        made = f"{folder}/timing.so"
        run_compiler([find_compiler(), *FLAGS, str(template_folder() / "bench" / "timing.c"), "-o", made])
        timer = ctypes.CDLL(made).time_steps
    timer.restype = ctypes.c_double
    timer.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int, ctypes.c_int]
    return timer
