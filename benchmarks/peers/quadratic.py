"""Quadratic programs of peers as OSQP's generated C: for the barrier filter and for predictive control."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers.optional import need
from benchmarks.suites.families import Array
from stt_codegen.program.targets.c.runner import find_compiler
from stt_codegen.program.targets.toolchain import run_compiler


def generated_solver(cost: Array, rows: Array, parameters: str, prefix: str, **settings: Any) -> tempfile.TemporaryDirectory[str]:
    """Generate OSQP's C for min x' cost x / 2 + q' x with low <= rows x <= high in a folder, and compile it to `osqp.o`.

    cost: (V, V); rows: (R, V); parameters: what is new at every step, "vectors" or "matrices". The folder lives as long as the
    object that is returned. Raises `MissingTool`."""
    osqp, sparse, folder = need("osqp"), need("scipy.sparse"), tempfile.TemporaryDirectory()
    bound, solver = np.ones(len(rows)), osqp.OSQP()
    matrices = sparse.csc_matrix(np.triu(cost)), np.zeros(len(cost)), sparse.csc_matrix(rows)
    solver.setup(*matrices, -bound, bound, verbose=False, **settings)
    solver.codegen(folder.name, parameters=parameters, extension_name=None, force_rewrite=True, prefix=prefix)
    sources = sorted(str(p) for p in Path(folder.name).glob("**/*.c") if p.name != "emosqp.c")  # which is the main of an example
    compile_with(folder.name, f"{folder.name}/osqp.o", "-fPIC", "-r", "-nostdlib", *sources)
    return folder


def includes(folder: str) -> list[str]:
    """Return the compiler's arguments with which a C file includes the solver of this folder."""
    return [f"-I{folder}/{part}" for part in ("inc/public", "inc/private", ".")]


def compile_with(folder: str, output: str, *arguments: str) -> None:
    """Compile C that calls the solver of this folder. arguments: its files, and more for the compiler."""
    run_compiler([find_compiler(), "-O2", "-std=c99", *includes(folder), *arguments, "-o", output])
