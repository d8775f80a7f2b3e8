"""The interface of an emitted controller that this process can call.

All backends take arrays of points and return arrays, so that `compare`, boards and tests treat them alike.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.program.nodes import Param

Array = npt.NDArray[Any]


class Backend(ABC):
    """A controller that takes arrays of points: scalars of shape (P,), arrays of shape (P, length)."""

    name: str
    scalar: str

    @abstractmethod
    def call(self, function: str, *inputs: Array) -> tuple[Array, ...]:
        """Return what a public function gives at every point: its status or value if it has one, then its outputs."""

    def check_shapes(self, params: Sequence[Param], inputs: Sequence[Array]) -> None:
        """Raise ValueError where an argument is not of shape (P,) or (P, length), P that of the first."""
        for p, values in zip(params, inputs, strict=True):
            shape = (len(inputs[0]),) if p.length is None else (len(inputs[0]), p.length)
            if np.shape(values) != shape:
                raise ValueError(f"{p.name}: has shape {np.shape(values)}; {shape} is needed")

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
