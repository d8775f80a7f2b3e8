"""The emitted controller made callable in this process: C by the system compiler and ctypes, Python by its text, CasADi
by its kernels. All take arrays of points and return arrays, so that `compare` and tests treat them alike."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from stt_codegen.design.tube import RefinedDesign
from stt_codegen.errors import MissingTool, SttError
from stt_codegen.task import Task

Array = npt.NDArray[np.float64]

# What the emitted C must pass without a warning, with gcc and clang (docs/c.md).
STRICT = tuple(
    "-std=c99 -O2 -pedantic -Wall -Wextra -Werror -Wconversion -Wsign-conversion -Wdouble-promotion -Wfloat-equal -Wshadow "
    "-Wstrict-prototypes -Wmissing-prototypes -Wundef -Wcast-qual -Wvla -ffp-contract=off".split()
)


class Backend(Protocol):
    """Points t of shape (P,), x of shape (P, n); results of shape (P, n), status of shape (P,)."""

    name: str
    scalar: str

    def tube(self, t: Array) -> tuple[Array, Array]: ...

    def tube_rate(self, t: Array) -> tuple[Array, Array]: ...

    def transform(self, lower: Array, upper: Array, x: Array) -> tuple[Array, Array, Array]: ...

    def control(self, t: Array, x: Array) -> tuple[npt.NDArray[np.intp], Array]: ...


def find_compiler() -> str:
    """The system's C compiler: $CC, or the first of cc, gcc, clang. Raises `MissingTool`."""
    for candidate in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
        found = shutil.which(candidate) if candidate else None
        if found:
            return found
    raise MissingTool("no C compiler found; install gcc or clang (Debian: apt-get install gcc libc6-dev), or set CC")


def run_compiler(arguments: Iterable[str]) -> None:
    """Run a compiler; its messages become the error when it fails."""
    result = subprocess.run(list(arguments), capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise SttError(f"the C compiler refused the emitted code:\n{result.stderr.strip()}")


class CompiledC:
    """The emitted C, compiled with the strict flags into a shared library."""

    def __init__(self, task: Task, files: dict[str, bytes], scalar: str, compiler: str | None = None) -> None:
        self.name = f"C {scalar}"
        self.scalar = scalar
        self.n = task.dimension
        self.number = np.float32 if scalar == "float" else np.float64
        self.real: Any = ctypes.c_float if scalar == "float" else ctypes.c_double
        with tempfile.TemporaryDirectory() as folder:
            for name, data in files.items():
                Path(folder, name).write_bytes(data)
            library = str(Path(folder, "controller.so"))
            source = str(Path(folder, f"{task.name}.c"))
            run_compiler([compiler or find_compiler(), *STRICT, "-shared", "-fPIC", "-o", library, source, "-lm"])
            self.library = ctypes.CDLL(library)
        self.prefix = task.name
        self.t_c = float(task.prescribed_time)

    def _call(self, name: str, scalars: list[Array], arrays: list[Array], outputs: int) -> tuple[list[int], list[Any]]:
        """Call `name` once for every point with its scalars, then its input arrays, then fresh output arrays."""
        function = getattr(self.library, f"{self.prefix}_{name}")
        function.restype = ctypes.c_int
        function.argtypes = [self.real] * len(scalars) + [ctypes.c_void_p] * (len(arrays) + outputs)
        count = len((scalars or arrays)[0])
        inputs = [np.ascontiguousarray(a, dtype=self.number) for a in arrays]
        results = [np.zeros((count, self.n), dtype=self.number) for _ in range(outputs)]
        size = self.n * inputs[0].itemsize if inputs else self.n * results[0].itemsize
        starts = [a.ctypes.data for a in inputs + results]
        status = []
        for p in range(count):
            status.append(function(*[float(s[p]) for s in scalars], *[start + p * size for start in starts]))
        return status, results

    def tube(self, t: Array) -> tuple[Array, Array]:
        lower, upper = self._call("tube", [t], [], 2)[1]
        return lower, upper

    def tube_rate(self, t: Array) -> tuple[Array, Array]:
        lower, upper = self._call("tube_rate", [t], [], 2)[1]
        return lower, upper

    def transform(self, lower: Array, upper: Array, x: Array) -> tuple[Array, Array, Array]:
        e, epsilon, xi = self._call("transform", [], [lower, upper, x], 3)[1]
        return e, epsilon, xi

    def control(self, t: Array, x: Array) -> tuple[npt.NDArray[np.intp], Array]:
        status, (u,) = self._call("control", [t], [x], 1)
        return np.array(status), u


class GeneratedPython:
    """The emitted Python module, loaded from its text."""

    name = "Python"
    scalar = "double"

    def __init__(self, task: Task, files: dict[str, bytes]) -> None:
        self.module: Any = load_module(task.name, files[f"{task.name}.py"])

    def tube(self, t: Array) -> tuple[Array, Array]:
        lower, upper = zip(*(self.module.tube(v) for v in t), strict=True)
        return np.array(lower), np.array(upper)

    def tube_rate(self, t: Array) -> tuple[Array, Array]:
        lower, upper = zip(*(self.module.tube_rate(v) for v in t), strict=True)
        return np.array(lower), np.array(upper)

    def transform(self, lower: Array, upper: Array, x: Array) -> tuple[Array, Array, Array]:
        e, epsilon, xi = zip(*(self.module.transform(*p) for p in zip(lower, upper, x, strict=True)), strict=True)
        return np.array(e), np.array(epsilon), np.array(xi)

    def control(self, t: Array, x: Array) -> tuple[npt.NDArray[np.intp], Array]:
        status, u = zip(*(self.module.control(*p) for p in zip(t, x, strict=True)), strict=True)
        return np.array(status), np.array(u)


def load_module(name: str, text: bytes) -> ModuleType:
    """A module from the text of a Python file that this package has just made."""
    module = ModuleType(name)
    exec(compile(text, f"{name}.py", "exec"), module.__dict__)
    return module


class CasadiKernels:
    """The kernels as CasADi evaluates them, with the frame (segment, clamp, status) in NumPy."""

    name = "CasADi"
    scalar = "double"

    def __init__(self, task: Task, design: RefinedDesign) -> None:
        from stt_codegen.paper import control_law, refined_tube

        self.task, self.design = task, design
        self.basis, self.basis_rate, self.blend = refined_tube.basis(), refined_tube.basis_rate(), refined_tube.blend()
        self.normalized, self.transformed = control_law.normalized_error(), control_law.transformed_error()
        self.law = control_law.law()

    def _edges(self, t: Array, weights: Any) -> tuple[Array, Array]:
        design = self.design
        t_c, k = float(design.prescribed_time), design.segments
        u = np.where(t < t_c, np.minimum(np.maximum(t, 0) * float(k / design.prescribed_time), k), k)
        segment = np.minimum(u.astype(int), k - 1)
        w = weights(u - segment)
        q = design.integers() * float(design.unit)
        edges = np.empty((len(t), design.dimension, 2))
        for i in range(design.dimension):
            for side in (0, 1):
                edges[:, i, side] = np.array(self.blend(w, np.stack([q[segment + j, i, side] for j in range(4)])))
        return edges[:, :, 0], edges[:, :, 1]

    def tube(self, t: Array) -> tuple[Array, Array]:
        return self._edges(t, lambda s: self.basis(s[None]))

    def tube_rate(self, t: Array) -> tuple[Array, Array]:
        lower, upper = self._edges(t, lambda s: self.basis_rate(s[None]))
        design = self.design
        scale = np.where(t < float(design.prescribed_time), float(design.segments / design.prescribed_time), 0.0)[:, None]
        return lower * scale, upper * scale

    def transform(self, lower: Array, upper: Array, x: Array) -> tuple[Array, Array, Array]:
        e_max = self.task.control.e_max
        share = float((1 - e_max) / 2)
        width = upper - lower
        a = np.clip(x - lower, share * width, float((1 + e_max) / 2) * width)
        b = np.clip(upper - x, share * width, float((1 + e_max) / 2) * width)
        e, epsilon, xi = np.empty_like(a), np.empty_like(a), np.empty_like(a)
        for i in range(a.shape[1]):
            row = [v[:, i][None] for v in (a, b, width)]
            e[:, i] = np.array(self.normalized(*row)).ravel()
            both = self.transformed(*row[:2])
            epsilon[:, i], xi[:, i] = np.array(both[0]).ravel(), np.array(both[1]).ravel()
        return np.clip(e, -float(e_max), float(e_max)), epsilon, xi

    def control(self, t: Array, x: Array) -> tuple[npt.NDArray[np.intp], Array]:
        lower, upper = self.tube(t)
        _, epsilon, xi = self.transform(lower, upper, x)
        gain = np.full((1, len(t)), float(self.task.control.gain))
        u = np.stack([np.array(self.law(gain, xi[:, i][None], epsilon[:, i][None])).ravel() for i in range(x.shape[1])], axis=1)
        if self.task.control.u_max is not None:
            bound = np.array([float(v) for v in self.task.control.u_max])
            u = np.clip(u, -bound, bound)
        inside = np.all((lower < x) & (x < upper), axis=1)
        return np.where(inside, 0, 1), u
