"""The closed loop in C: the emitted controller as it goes on the board, a plant printed from its kernel, and the loop between
them (templates/loop/), compiled by the system's compiler and called through ctypes."""

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
MAX_DIMENSIONS = 64  # as in loop.h


class LoopSetting(ctypes.Structure):
    """`loop_setting` of loop.h, which explains the fields."""

    _fields_ = (
        ("n", ctypes.c_int32),
        ("sets", ctypes.c_int32),
        ("order", ctypes.c_int32),
        ("samples", ctypes.c_int32),
        ("integration_steps", ctypes.c_int32),
        ("disturbance_kind", ctypes.c_int32),
        ("max_lost_samples", ctypes.c_int32),
        ("has_constant_dynamics", ctypes.c_int32),
        ("seed", ctypes.c_uint64),
        ("period", ctypes.c_double),
        ("end", ctypes.c_double),
        ("w_max", ctypes.c_double),
        ("measurement_errors", ctypes.c_void_p),
        ("filter", ctypes.c_void_p),
        ("plant_constants", ctypes.c_void_p),
        ("w_ratios", ctypes.c_void_p),
        ("drives", ctypes.c_void_p),
        ("is_adverse", ctypes.c_int32),
        ("latency", ctypes.c_double),
        ("start", ctypes.c_void_p),
        ("space_face_count", ctypes.c_int32),
        ("target_face_count", ctypes.c_int32),
        ("space_faces", ctypes.c_void_p),
        ("target_faces", ctypes.c_void_p),
        ("face_range_starts", ctypes.c_void_p),
        ("faces", ctypes.c_void_p),
        ("radius", ctypes.c_void_p),
        ("segments", ctypes.c_void_p),
        ("clock", ctypes.c_int32),
        ("knot_range_starts", ctypes.c_void_p),
        ("knots", ctypes.c_void_p),
        ("activity_and_clock", ctypes.c_void_p),
    )


class LoopResult(ctypes.Structure):
    """`loop_result` of loop.h, which explains the fields."""

    _fields_ = (
        ("hit", ctypes.c_int32),
        ("left", ctypes.c_int32),
        ("reached", ctypes.c_int32),
        ("outside", ctypes.c_int32),
        ("hit_at", ctypes.c_double),
        ("left_at", ctypes.c_double),
        ("outside_at", ctypes.c_double),
        ("margin", ctypes.c_double),
        ("e", ctypes.c_double * MAX_DIMENSIONS),
        ("u", ctypes.c_double * MAX_DIMENSIONS),
        ("last", ctypes.c_double * MAX_DIMENSIONS),
    )


@dataclass(frozen=True, kw_only=True)
class LoadedController:
    """A compiled controller as the loop calls it.

    step, tube, advance: functions of C, `loop_step`, `loop_tube` and `loop_advance` of loop.h. start: sets its state to 0.
    library: keeps it loaded. waited_seconds: returns for how many seconds its tube has waited.
    """

    step: Any
    tube: Any
    advance: Any
    start: Callable[[], None]
    library: Any
    waited_seconds: Callable[[], float] = lambda: 0.0


def driver(plant: Model, dimension: int, order: int = 1) -> Any:
    """Return `loop_run` of loop.h for a plant; each plant is compiled once in a process."""
    return _compiled_driver(plant_source(plant, dimension, order))


def has_constant_dynamics(plant: Model, dimension: int, order: int = 1) -> bool:
    """Whether the plant's f and g do not depend on the state."""
    function = model(plant, dimension, order)
    return all(int(function.jac_sparsity(k, 0).nnz()) == 0 for k in (0, 1))


@cache
def _compiled_driver(source: str) -> Any:
    """Compile the loop with the C of a plant, and return its `loop_run`."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "stt-plant.c").write_text(source)
        compiled, sources = f"{folder}/loop.so", template_folder() / "loop"
        files = [f"{folder}/stt-plant.c", str(sources / "loop.c")]
        run_compiler([find_compiler(), *FLAGS, f"-I{sources}", *files, "-o", compiled, "-lm"])
        library = ctypes.CDLL(compiled)
    run = library.loop_run
    run.restype = None
    run.argtypes = [
        ctypes.POINTER(LoopSetting),
        ctypes.c_void_p,
        ctypes.c_void_p,
        ctypes.c_void_p,
        ctypes.POINTER(LoopResult),
        ctypes.c_void_p,
    ]
    return run


def load_controller(controller: EmittedController) -> LoadedController:
    """Compile the emitted C of a controller and load it."""
    outside = controller.task.control.outside
    with tempfile.TemporaryDirectory() as folder:
        for name, data in controller.files.items():
            Path(folder, name).write_bytes(data)
        Path(folder, "stt-adapter.c").write_text(adapter_source(controller.task, controller.design, controller.certificate))
        sources = [f"{folder}/{name}" for name in ("stt-adapter.c", *driven_sources(controller.task))]
        run_compiler([find_compiler(), *FLAGS, *sources, "-o", f"{folder}/controller.so", "-lm"])
        library = ctypes.CDLL(f"{folder}/controller.so")
    if outside != "return":
        library.loop_own_waited_seconds.restype = ctypes.c_double
        return LoadedController(
            step=library.loop_own_step,
            tube=library.loop_own_tube,
            advance=None,
            start=library.loop_own_start,
            library=library,
            waited_seconds=library.loop_own_waited_seconds,
        )
    if not controller.design.is_stateful:
        return LoadedController(
            step=library.loop_own_step,
            tube=library.loop_own_tube,
            advance=None,
            start=lambda: None,
            library=library,
        )
    library.loop_own_advance.argtypes = [ctypes.c_double, ctypes.c_double]
    return LoadedController(
        step=library.loop_own_step,
        tube=library.loop_own_tube,
        advance=library.loop_own_advance,
        start=library.loop_own_start,
        library=library,
    )
