"""What the kernels of a controller in integers compute at many inputs, and the errors of weights that follow from it."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen.controller.integers.integer_kernels import (
    HALF_WORD,
    MIDDLE_WEIGHT_BITS,
    OUTER_WEIGHT_BITS,
    RateScale,
    build_rate_weights_kernel,
    build_weights_kernel,
)
from stt_codegen.program.nodes import Const, Kernel, Op, Operand, Select
from stt_codegen.program.operations import OPERATIONS

Integers = npt.NDArray[np.int64]


def evaluate_kernel(kernel: Kernel, inputs: Mapping[str, Integers]) -> tuple[Integers, ...]:
    """Evaluate a kernel of integers without tables at arrays of inputs; its values must fit 63 bits."""
    values: dict[str, Any] = dict(inputs)

    def value_of(operand: Operand) -> Any:
        return np.int64(operand.value) if isinstance(operand, Const) else values[operand.name]  # type: ignore[arg-type]

    for assign in kernel.body:
        match assign.value:
            case Op(name="int", args=(count,)):
                values[assign.var.name] = value_of(count)
            case Op(name=name, args=args):
                values[assign.var.name] = OPERATIONS[name].number(*map(value_of, args))
            case Select() as choice:
                condition, then = value_of(choice.condition), value_of(choice.then)
                values[assign.var.name] = np.where(condition, then, value_of(choice.otherwise))
            case _:
                raise NotImplementedError(f"{kernel.name}: {type(assign.value).__name__}")
    return tuple(value_of(output) for output in kernel.outputs)


def derived_weight_error() -> Fraction:
    """Return the largest sum of the errors of the two outer weights of an edge, plus the largest error of the middle one."""
    s = np.arange(HALF_WORD, dtype=np.int64)
    first, middle, last = evaluate_kernel(build_weights_kernel(), {"s": s})
    s_one = HALF_WORD
    outer_shift, middle_shift = 48 - OUTER_WEIGHT_BITS, 48 - MIDDLE_WEIGHT_BITS  # to units of 2^-48, those of a cube of s
    outer_errors = np.abs((first << outer_shift) - (s_one - s) ** 3) + np.abs((last << outer_shift) - s**3)
    middle_errors = np.abs((middle << middle_shift) - (3 * s * s_one * s_one + 3 * s * s * s_one - 2 * s**3))
    return Fraction(int(outer_errors.max()) + int(middle_errors.max()), 1 << 48)


def derived_rate_weight_error(rate_scale: RateScale, segments_per_second: Fraction) -> Fraction:
    """Return the largest sum of the errors of the three weights of a rate, in steps a second, over all s."""
    s = np.arange(HALF_WORD, dtype=np.int64)
    weights = evaluate_kernel(build_rate_weights_kernel(rate_scale), {"s": s})
    s_one, s = HALF_WORD, s.astype(object)
    exact = (3 * (s_one - s) ** 2, 3 * s_one**2 + 6 * s * (s_one - s), 3 * s**2)  # in 2^-32, per segment
    to_weight_bits = segments_per_second.numerator << rate_scale.weight_bits
    denominator = segments_per_second.denominator << 32
    pairs = zip(weights, exact, strict=True)
    errors = sum(abs(w.astype(object) * denominator - v * to_weight_bits) for w, v in pairs)
    return Fraction(int(errors.max()), denominator << rate_scale.weight_bits)
