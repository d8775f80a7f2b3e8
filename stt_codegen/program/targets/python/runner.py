"""The emitted Python made callable: loaded from its text."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from stt_codegen.program.targets.backend import Array, Backend
from stt_codegen.program.targets.target import Emitted


def load_module(name: str, text: bytes) -> ModuleType:
    """Return a module from the text of a Python file that this package has just emitted."""
    module = ModuleType(name)
    exec(compile(text, f"{name}.py", "exec"), module.__dict__)
    return module


class GeneratedPython(Backend):
    """The emitted Python module, loaded from its text."""

    name = "Python"

    def __init__(self, controller: Emitted) -> None:
        self.program = controller.program
        self.scalar = "double" if self.program.tick is None else self.program.scalar
        self.module: Any = load_module(self.program.prefix, controller.files[f"{self.program.prefix}.py"])

    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        """Return what a public function gives at every point: its status or value if it has one, then its outputs."""
        call, described = getattr(self.module, function), self.program.function(function)
        rows = [call(*point) for point in zip(*inputs, strict=True)]
        alone = described.returns_real or described.returns_bool
        if alone or (len(described.outputs) == 1 and not described.returns_status):
            return (np.array(rows),)
        return tuple(np.array(column) for column in zip(*rows, strict=True))
