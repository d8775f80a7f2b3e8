"""The emitted C made callable: by the system's C compiler and ctypes. The flags that emitted C must pass."""

from __future__ import annotations

import ctypes
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from stt_codegen.errors import MissingTool
from stt_codegen.program.operations import REAL, TICK
from stt_codegen.program.targets.backend import Array, Backend
from stt_codegen.program.targets.target import Emitted
from stt_codegen.program.targets.toolchain import run_compiler

# What the emitted C must pass without a warning, with gcc and clang (docs/c.md).
STRICT = tuple(
    "-std=c99 -O2 -pedantic -Wall -Wextra -Werror -Wconversion -Wsign-conversion -Wdouble-promotion -Wfloat-equal -Wshadow "
    "-Wstrict-prototypes -Wmissing-prototypes -Wundef -Wcast-qual -Wvla -ffp-contract=off".split()
)


def find_compiler() -> str:
    """The system's C compiler: $CC, or the first of cc, gcc, clang. Raises `MissingTool`."""
    own = os.environ.get("CC", "")
    for candidate in (own,) if own else ("cc", "gcc", "clang"):
        found = shutil.which(candidate)
        if found:
            return found
    if own:
        raise MissingTool(f"CC names {own!r}, which is not found; set it to the command of a C compiler")
    raise MissingTool("no C compiler found; install gcc or clang (Debian: apt-get install gcc libc6-dev), or set CC")


class CompiledC(Backend):
    """The emitted C, compiled with the strict flags into a shared library (or with other flags, by who gives one)."""

    def __init__(self, controller: Emitted, compiler: str | None = None, library: Path | None = None) -> None:
        self.program = controller.program
        self.scalar = self.program.scalar
        self.name = f"C {self.scalar}"
        self.number: Any = {"float": np.float32, "double": np.float64, "fixed": np.int32}[self.scalar]
        self.real: Any = {"float": ctypes.c_float, "double": ctypes.c_double, "fixed": ctypes.c_int32}[self.scalar]
        if library is not None:
            self.library = ctypes.CDLL(str(library))
            return
        with tempfile.TemporaryDirectory() as folder:
            for name, data in controller.files.items():
                Path(folder, name).write_bytes(data)
            made = str(Path(folder, "controller.so"))
            source = str(Path(folder, f"{self.program.prefix}.c"))
            run_compiler([compiler or find_compiler(), *STRICT, "-shared", "-fPIC", "-o", made, source, "-lm"])
            self.library = ctypes.CDLL(made)

    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        params = self.program.function(function).params
        self.check_shapes(self.program.function(function).inputs, inputs)
        call = getattr(self.library, f"{self.program.prefix}_{function}")
        described = self.program.function(function)
        call.restype = self.real if described.returns_real else ctypes.c_bool if described.returns_bool else ctypes.c_int
        scalars = {REAL: self.real, TICK: ctypes.c_uint32}
        call.argtypes = [scalars[p.type] if p.length is None else ctypes.c_void_p for p in params]
        count = len(inputs[0])
        given = iter(inputs)
        columns: list[list[Any]] = []
        results = []
        kept = []  # alive until the calls are done: the columns hold bare addresses
        for p in params:
            if p.length is None:
                columns.append([int(v) if p.type is TICK else float(v) for v in next(given)])
                continue
            if p.output and not p.inout:
                array = np.zeros((count, p.length), dtype=self.number)
            else:
                array = np.array(next(given), dtype=self.number, order="C")
            kept.append(array)
            columns.append([array.ctypes.data + k * array.strides[0] for k in range(count)])
            if p.output:
                results.append(array)
        returned = [call(*row) for row in zip(*columns, strict=True)]
        returns = described.returns_status or described.returns_real or described.returns_bool
        return (np.array(returned), *results) if returns else tuple(results)
