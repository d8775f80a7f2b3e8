"""The emitted controller made callable in this process: C by the system compiler and ctypes, Python by its text, CasADi
by its kernels. All take arrays of points and return arrays, so that `compare` and tests treat them alike."""

from __future__ import annotations

import ctypes
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.compare.toolchain import STRICT, find_compiler, load_module, run_compiler
from stt_codegen.pipeline import Controller
from stt_codegen.program import REAL, TICK, Param

Array = npt.NDArray[Any]


class Backend(ABC):
    """A controller that takes arrays of points: scalars of shape (P,), arrays of shape (P, length)."""

    name: str
    scalar: str

    @abstractmethod
    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        """A public function at every point: the status first where it returns one, then its outputs in order."""

    def check_shapes(self, params: Sequence[Param], inputs: Sequence[Array]) -> None:
        """Raises ValueError where an argument is not of shape (P,) or (P, length), P that of the first."""
        for p, values in zip(params, inputs, strict=True):
            wanted = (len(inputs[0]),) if p.length is None else (len(inputs[0]), p.length)
            if np.shape(values) != wanted:
                raise ValueError(f"{p.name}: has shape {np.shape(values)}; {wanted} is needed")

    def tube(self, *inputs: Array) -> tuple[Array, ...]:
        return self.call("tube", *inputs)

    def tube_rate(self, *inputs: Array) -> tuple[Array, ...]:
        return self.call("tube_rate", *inputs)

    def transform(self, *inputs: Array) -> tuple[Array, ...]:
        return self.call("transform", *inputs)

    def control(self, *inputs: Array) -> tuple[Array, ...]:
        return self.call("control", *inputs)

    def margin(self, *inputs: Array) -> Array:
        return self.call("margin", *inputs)[0]


class CompiledC(Backend):
    """The emitted C, compiled with the strict flags into a shared library (or with other flags, by who gives one)."""

    def __init__(self, controller: Controller, compiler: str | None = None, library: Path | None = None) -> None:
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
        call.restype = self.real if self.program.function(function).returns_real else ctypes.c_int
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
        f = self.program.function(function)
        return (np.array(returned), *results) if f.returns_status or f.returns_real else tuple(results)


class GeneratedPython(Backend):
    """The emitted Python module, loaded from its text."""

    name = "Python"

    def __init__(self, controller: Controller) -> None:
        self.program = controller.program
        self.scalar = "double" if self.program.tick is None else self.program.scalar
        self.module: Any = load_module(self.program.prefix, controller.files[f"{self.program.prefix}.py"])

    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        call, described = getattr(self.module, function), self.program.function(function)
        rows = [call(*point) for point in zip(*inputs, strict=True)]
        if described.returns_real or (len(described.outputs) == 1 and not described.returns_status):
            return (np.array(rows),)
        return tuple(np.array(column) for column in zip(*rows, strict=True))
