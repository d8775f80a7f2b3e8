"""The closed loop in C: the emitted controller as it goes on the board, a plant printed from its kernel, and what joins them
(templates/loop/), compiled by the system's compiler and called through ctypes."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from stt_codegen.emit import adapter_source, driven_sources, plant_source
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model, model
from stt_codegen.program.targets import run_compiler
from stt_codegen.program.targets.c.runner import find_compiler
from stt_codegen.program.targets.template_files import template_folder

FLAGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter", "-ffp-contract=off", "-shared", "-fPIC")
MOST = 64  # dimensions, as in loop.h


class Setting(ctypes.Structure):
    """`loop_setting` of loop.h."""

    _fields_ = (
        ("n", ctypes.c_int32),
        ("sets", ctypes.c_int32),
        ("order", ctypes.c_int32),
        ("samples", ctypes.c_int32),
        ("parts", ctypes.c_int32),
        ("kind", ctypes.c_int32),
        ("lost", ctypes.c_int32),
        ("constant", ctypes.c_int32),
        ("seed", ctypes.c_uint64),
        ("period", ctypes.c_double),
        ("end", ctypes.c_double),
        ("strength", ctypes.c_double),
        ("noise", ctypes.c_double),
        ("noise_v", ctypes.c_double),
        ("filter", ctypes.c_void_p),
        ("constants", ctypes.c_void_p),
        ("shares", ctypes.c_void_p),
        ("lag", ctypes.c_double),
        ("latency", ctypes.c_double),
        ("start", ctypes.c_void_p),
        ("walls", ctypes.c_int32),
        ("goals", ctypes.c_int32),
        ("space", ctypes.c_void_p),
        ("target", ctypes.c_void_p),
        ("first", ctypes.c_void_p),
        ("faces", ctypes.c_void_p),
        ("radius", ctypes.c_void_p),
        ("ends", ctypes.c_void_p),
        ("clock", ctypes.c_int32),
        ("turn", ctypes.c_void_p),
        ("turns", ctypes.c_void_p),
        ("hours", ctypes.c_void_p),
    )


class Judged(ctypes.Structure):
    """`loop_result` of loop.h."""

    _fields_ = (
        ("hit", ctypes.c_int32),
        ("left", ctypes.c_int32),
        ("reached", ctypes.c_int32),
        ("outside", ctypes.c_int32),
        ("hit_at", ctypes.c_double),
        ("left_at", ctypes.c_double),
        ("outside_at", ctypes.c_double),
        ("margin", ctypes.c_double),
        ("e", ctypes.c_double * MOST),
        ("u", ctypes.c_double * MOST),
        ("last", ctypes.c_double * MOST),
    )


@dataclass(frozen=True, kw_only=True)
class Own:
    """An emitted controller as the loop calls it; `start` sets what it keeps to 0. `library` keeps it loaded; lag: by how many
    seconds its tube waits, of one that does."""

    step: Any
    tube: Any
    advance: Any
    start: Callable[[], None]
    library: Any
    lag: Callable[[], float] = lambda: 0.0


def driver(plant: Model, dimension: int, order: int = 1) -> Any:
    """`loop_run` for a plant; compiled once a process for each."""
    return _driver(plant_source(plant, dimension, order))


def is_constant(plant: Model, dimension: int, order: int = 1) -> bool:
    """Whether the plant's f and g do not depend on the state."""
    function = model(plant, dimension, order)
    return all(int(function.jac_sparsity(k, 0).nnz()) == 0 for k in (0, 1))


@cache
def _driver(source: str) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "plant.c").write_text(source)
        made, where = f"{folder}/loop.so", template_folder() / "loop"
        run_compiler([find_compiler(), *FLAGS, f"-I{where}", f"{folder}/plant.c", str(where / "loop.c"), "-o", made, "-lm"])
        library = ctypes.CDLL(made)
    run = library.loop_run
    run.restype = None
    run.argtypes = [
        ctypes.POINTER(Setting),
        ctypes.c_void_p,
        ctypes.c_void_p,
        ctypes.c_void_p,
        ctypes.POINTER(Judged),
        ctypes.c_void_p,
    ]
    return run


def own(controller: EmittedController) -> Own:
    """Compile the emitted C of a controller and load it."""
    adaptive, outside = controller.design.is_stateful, controller.task.control.outside
    with tempfile.TemporaryDirectory() as folder:
        for name, data in controller.files.items():
            Path(folder, name).write_bytes(data)
        Path(folder, "adapter.c").write_text(adapter_source(controller.task, controller.design, controller.certificate))
        sources = [f"{folder}/{name}" for name in ("adapter.c", *driven_sources(controller.task))]
        run_compiler([find_compiler(), *FLAGS, *sources, "-o", f"{folder}/own.so", "-lm"])
        library = ctypes.CDLL(f"{folder}/own.so")
    if outside != "return":
        library.loop_own_lag.restype = ctypes.c_double
        return Own(
            step=library.loop_own_step,
            tube=library.loop_own_tube,
            advance=None,
            start=library.loop_own_start,
            library=library,
            lag=library.loop_own_lag,
        )
    if not adaptive:
        return Own(step=library.loop_own_step, tube=library.loop_own_tube, advance=None, start=lambda: None, library=library)
    library.loop_own_advance.argtypes = [ctypes.c_double, ctypes.c_double]
    return Own(
        step=library.loop_own_step,
        tube=library.loop_own_tube,
        advance=library.loop_own_advance,
        start=library.loop_own_start,
        library=library,
    )
