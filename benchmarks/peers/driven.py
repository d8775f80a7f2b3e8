"""Peers' controllers in C behind the interface of the package's loops, so that they meet the same arenas, starts and winds as
ours.

`in_loops`, `funnels` and `predictive` compile their C here; `suites/loop.py` times steps and `suites/mcu.py` compiles for boards.
"""

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

TIMING_ROUNDS = 5
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC")


def compile_peer(
    source: str, n: int, hertz: float, tube: object, *, real: str = "float", compiler_arguments: Sequence[str] = ()
) -> LoadedController:
    """Compile a C text with `static int decide(real t, const real *x, real *u)`, which is called so many times a second; u stays
    as it was between two calls.

    n: dimension; tube: the function of our controller that gives the edges by which the loop measures margins; real: "float" or
    "double". Raises `MissingTool` without a compiler.
    """
    text = template("bench/held.c.j2").render(source=source, n=n, hertz=repr(float(hertz)), real=real)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "other.c").write_text(text)
        library_path = f"{folder}/other.so"
        run_compiler([find_compiler(), *FLAGS, f"{folder}/other.c", *compiler_arguments, "-o", library_path, "-lm"])
        library = ctypes.CDLL(library_path)
    return LoadedController(step=library.other_step, tube=tube, advance=None, start=library.other_start, library=library)


def as_control(p: str, source: str) -> str:
    """Wrap a C text with `decide` as <p>_control, in single precision, for a board."""
    ok, outside = f"{p.upper()}_OK", f"{p.upper()}_OUTSIDE_TUBE"
    return (
        f'#include "{p}.h"\ntypedef float real;\nstatic int decide(real t, const real *x, real *u);\n{source}\n'
        f"{p}_status {p}_control(float t, const float *x, float *u)\n{{\n    return decide(t, x, u) ? {outside} : {ok};\n}}\n"
    )


def seconds_a_step(controller: LoadedController, rows: npt.NDArray[Any]) -> float:
    """Measure how long the controller takes for a step, called once at every row of t and x: the quickest of TIMING_ROUNDS, since
    a disturbance of the machine only adds time."""
    table, times = np.ascontiguousarray(rows, dtype=float), []
    for _ in range(TIMING_ROUNDS):
        controller.start()
        times.append(_timer()(controller.step, table.ctypes.data, table.shape[1] - 1, len(table)))
    return float(min(times))


@cache
def _timer() -> Any:
    """Compile the C function that calls a step at every row and returns the mean time in seconds."""
    with tempfile.TemporaryDirectory() as folder:
        library_path = f"{folder}/timing.so"
        run_compiler([find_compiler(), *FLAGS, str(template_folder() / "bench" / "timing.c"), "-o", library_path])
        timer = ctypes.CDLL(library_path).time_steps
    timer.restype = ctypes.c_double
    timer.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int, ctypes.c_int]
    return timer
