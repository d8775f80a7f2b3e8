"""How far an emitted u may be from (13): what moved edges do to it, and a logarithm that is written out."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.controller.kernels import inline_logarithm_error
from stt_codegen.pipeline import EmittedController

Array = npt.NDArray[Any]


def logarithm_error(controller: EmittedController) -> float:
    """Relative error of epsilon where the logarithm is written out; 0 with a library's."""
    inline = controller.task.emit.math == "inline"
    return float(inline_logarithm_error(controller.program.scalar)) if inline else 0.0


def law_spread(low: Array, high: Array, x: Array, delta: Array, e_max: Array) -> Array:
    """How far (1/a + 1/b) ln(a/b) can move when each edge moves by delta (comparison.py says why the corners decide)."""
    share = (1 - e_max) / 2

    def clamped(distance: Array, width: Array) -> Array:
        return np.clip(distance, share * width, (1 - share) * width)

    def h(a: Array, b: Array) -> Array:
        return np.asarray((1 / a + 1 / b) * np.log(a / b))

    width, a, b = high - low, x - low, high - x
    middle = h(clamped(a, width), clamped(b, width))
    most = h(clamped(a + delta, width + 2 * delta), clamped(b - delta, width - 2 * delta))
    least = h(clamped(a - delta, width - 2 * delta), clamped(b + delta, width + 2 * delta))
    return np.asarray(np.maximum(most - middle, middle - least))
