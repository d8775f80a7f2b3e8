"""The emitted C made callable, by the system's C compiler and ctypes; and the flags that emitted C must pass."""

from __future__ import annotations

import ctypes
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from stt_codegen.errors import MissingTool
from stt_codegen.program.nodes import Function
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
    """Return the path of the system's C compiler: $CC, or the first of cc, gcc, clang. Raises `MissingTool`."""
    chosen = os.environ.get("CC", "")
    for candidate in (chosen,) if chosen else ("cc", "gcc", "clang"):
        path = shutil.which(candidate)
        if path:
            return path
    if chosen:
        raise MissingTool(f"CC names {chosen!r}, which is not found; set it to the command of a C compiler")
    raise MissingTool("no C compiler found; install gcc or clang (Debian: apt-get install gcc libc6-dev), or set CC")


class CompiledC(Backend):
    """The emitted C, compiled with the strict flags into a shared library. library: a compiled one, to use in its place."""

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
            compiled = str(Path(folder, "controller.so"))
            source = str(Path(folder, f"{self.program.prefix}.c"))
            run_compiler([compiler or find_compiler(), *STRICT, "-shared", "-fPIC", "-o", compiled, source, "-lm"])
            self.library = ctypes.CDLL(compiled)

    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        """Return what a public function gives at every point: its status or value if it has one, then its outputs."""
        described = self.program.function(function)
        self.check_shapes(described.inputs, inputs)
        compiled = self._compiled_function(described)
        count = len(inputs[0])
        remaining_inputs = iter(inputs)
        columns: list[list[Any]] = []  # of every argument, its value or address at each point
        arrays = []  # stay alive until the calls are done: the columns have bare addresses
        outputs = []
        for p in described.params:
            if p.length is None:
                columns.append([int(v) if p.type is TICK else float(v) for v in next(remaining_inputs)])
                continue
            if p.output and not p.inout:
                array = np.zeros((count, p.length), dtype=self.number)
            else:
                array = np.array(next(remaining_inputs), dtype=self.number, order="C")
            arrays.append(array)
            columns.append([array.ctypes.data + k * array.strides[0] for k in range(count)])
            if p.output:
                outputs.append(array)
        returned = [compiled(*arguments) for arguments in zip(*columns, strict=True)]
        returns = described.returns_status or described.returns_real or described.returns_bool
        return (np.array(returned), *outputs) if returns else tuple(outputs)

    def _compiled_function(self, function: Function) -> Any:
        """Return a function of the library, with its types for ctypes."""
        compiled = getattr(self.library, f"{self.program.prefix}_{function.name}")
        compiled.restype = self.real if function.returns_real else ctypes.c_bool if function.returns_bool else ctypes.c_int
        scalars = {REAL: self.real, TICK: ctypes.c_uint32}
        compiled.argtypes = [scalars[p.type] if p.length is None else ctypes.c_void_p for p in function.params]
        return compiled
