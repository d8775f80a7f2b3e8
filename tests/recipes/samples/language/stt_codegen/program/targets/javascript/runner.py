"""The emitted JavaScript made callable: by node, all points of a call in one process."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from stt_codegen.errors import MissingTool, SttError
from stt_codegen.program.targets.backend import Array, Backend
from stt_codegen.program.targets.target import Emitted

# Numbers that JSON does not have travel as text.
DRIVER = """const controller = require("./controller.js");
const { name, points } = JSON.parse(require("fs").readFileSync(0, "utf8"));
const number = (v) => Array.isArray(v) ? v.map(number) : Number(v);
const text = (v) => Array.isArray(v) ? v.map(text) : String(Number(v));
console.log(JSON.stringify(points.map((point) => text(controller[name](...point.map(number))))));
"""


def find_node() -> str:
    """Return the interpreter: $NODE, or node. Raises `MissingTool`."""
    path = shutil.which(os.environ.get("NODE") or "node")
    if path is None:
        raise MissingTool("no interpreter of JavaScript found; install nodejs (Debian: apt-get install nodejs), or set NODE")
    return path


def as_text(value: Any) -> Any:
    """Return numbers, in lists of any depth, as texts that JavaScript reads exactly."""
    return [as_text(v) for v in value] if isinstance(value, list) else repr(value) if math.isfinite(value) else NAMES[repr(value)]


NAMES = {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}


class RunJavaScript(Backend):
    """The emitted JavaScript, in double arithmetic."""

    name = "JavaScript"
    scalar = "double"

    def __init__(self, controller: Emitted) -> None:
        self.program = controller.program
        self.text = controller.files[f"{self.program.prefix}.js"]

    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        """Call a function at every point, in one process of node, and return its outputs as arrays over the points."""
        declaration = self.program.function(function)
        self.check_shapes(declaration.inputs, inputs)
        points = [[as_text(np.asarray(v).tolist()) for v in point] for point in zip(*inputs, strict=True)]
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "controller.js").write_bytes(self.text)
            Path(folder, "driver.js").write_text(DRIVER)
            request = json.dumps({"name": function, "points": points})
            result = subprocess.run(
                [find_node(), f"{folder}/driver.js"], input=request, capture_output=True, text=True, check=False
            )
        if result.returncode:
            raise SttError(f"node refused the emitted code:\n{result.stderr}")
        columns = zip(*json.loads(result.stdout), strict=True)
        return tuple(np.array(column, dtype=float) for column in columns)
