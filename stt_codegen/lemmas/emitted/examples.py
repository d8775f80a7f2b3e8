"""Example programs whose functions the lemmas of functions.py follow, symbols for their inputs, and helpers for the formulas.

expected.py and expected_adaptive.py have the formulas.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache
from typing import Any, Generic, TypeVar

import sympy as sp

from stt_codegen.controller import adaptive_program, refined_program
from stt_codegen.design_kinds import CAPABILITIES, DesignKind
from stt_codegen.designs import LOWER, UPPER, AdaptiveDesign, Bump, Design, RefinedDesign
from stt_codegen.program import Program
from stt_codegen.task import Task

N, K, T_C, GAIN, E_MAX = 2, 4, Fraction(9), Fraction(1, 2), Fraction(99, 100)
U_MAX = (Fraction(3, 2), Fraction(40))
# Kernels that are followed as a part of the function.
FOLLOWED = frozenset({"segment", "segment_at_tick", "edge_at", "hold", "normalized_error"})
Point = Mapping[str, Any]


D = TypeVar("D", bound=Design)


@dataclass(frozen=True)
class CaseOf(Generic[D]):
    """A program and its design."""

    program: Program
    design: D

    @property
    def is_guarded(self) -> bool:
        """Whether the law raises widths that are below MINIMUM_WIDTH; refined tubes are never so narrow."""
        return self.design.is_stateful

    @property
    def opaque(self) -> frozenset[str]:
        return frozenset(k.name for k in self.program.kernels) - FOLLOWED


Case = CaseOf[Any]  # for formulas that are the same for every kind of tube


def _task(kind: DesignKind, has_u_max: bool) -> Task:
    """Return a task of two components for a kind of tube; only its control and names matter, since the design is given."""
    interval = {"lower": [0, 0], "upper": [5, 5]}
    return Task.model_validate(
        {
            "name": "example",
            "prescribed_time": int(T_C),
            "initial_state": [1, 1],
            "state_space": interval,
            "initial_set": interval,
            "target_set": interval,
            "tube": {"design": kind},
            "control": {"gain": Decimal("0.5"), "e_max": Decimal("0.99")}
            | ({"u_max": [Decimal("1.5"), 40]} if has_u_max else {}),
            "emit": {"scalar": "double"} | ({"tick_period": Decimal("0.001")} if CAPABILITIES[kind].counts_ticks else {}),
        }
    )


def _refined(widths: Sequence[int], has_u_max: bool) -> Case:
    """Return a tube of K segments; control point j has the width widths[j] in dimension 1, widths[-1 - j] in 2, in 2^-10 / 6."""
    rows = tuple(((100 * j, 100 * j + widths[j]), (50 - 10 * j, 50 - 10 * j + widths[-1 - j])) for j in range(K + 3))
    design = RefinedDesign(T_C, K, 10, rows)
    return Case(refined_program(_task("refined", has_u_max), design), design)


def _adaptive() -> Case:
    """Return an adaptive tube with several bumps on a side, one on another, and none on the rest."""
    bumps = [(0, LOWER, 2), (0, LOWER, 3), (0, UPPER, 5), (1, UPPER, 6)]
    shape: Any = {"height": Fraction(3, 2), "steepness": Fraction(1, 100), "radius": Fraction(1), "unsafe": "U"}
    design = AdaptiveDesign(
        kind="adaptive",
        prescribed_time=T_C,
        start=((Fraction(1, 2), Fraction(1)), (Fraction(2), Fraction(5, 2))),
        target=((Fraction(4), Fraction(9, 2)), (Fraction(1), Fraction(3, 2))),
        walls=((Fraction(0), Fraction(5)),) * N,
        bumps=tuple(Bump(dimension=i, side=side, middle=Fraction(m), **shape) for i, side, m in bumps),
        theta0=Fraction(1, 2),
        kappa=Fraction(5),
        mu=Fraction(1, 4),
        varsigma=Fraction(20),
        nu=Fraction(100),
    )
    return Case(adaptive_program(_task("adaptive", False), design), design)


@cache
def cases() -> Mapping[str, Case]:
    """Return by name a refined tube whose u is limited, the same tube without limits, and an adaptive one."""
    widths = (300, 320, 280, 400, 500, 350, 300)
    return {"limited": _refined(widths, True), "unlimited": _refined(widths, False), "adaptive": _adaptive()}


T, TICK, DT = sp.Symbol("t", real=True), sp.Symbol("tick", integer=True), sp.Symbol("dt", real=True)
X = sp.symbols(f"x1:{N + 1}", real=True)
ALPHA = sp.symbols(f"alpha1:{2 * N + 1}", real=True)
BOX = {name: sp.symbols(f"{name}1:{N + 1}", real=True) for name in ("lower", "upper")}
SYMBOLS: dict[str, Any] = {"t": T, "tick": TICK, "dt": DT, "x": X, "alpha": ALPHA, **BOX}

Expected = tuple[Any, Mapping[str, Sequence[Any]], Any]  # the regime, formulas of the outputs by name, and of the result
Specification = Callable[[Case, Point], Expected]


def are_finite(*values: Any) -> bool:
    return all(map(math.isfinite, values))


def kernel_of(name: str, output: int, *args: Any) -> Any:
    return sp.Function(f"{name}_{output}", real=True)(*(sp.expand(a) for a in args))


def rational(value: Fraction | int) -> Any:
    return sp.Rational(Fraction(value).numerator, Fraction(value).denominator)


def table_entry(table: str, index: Any) -> Any:
    return sp.Function(table, real=True)(sp.expand(index))


def is_finite_point(point: Point) -> bool:
    return are_finite(*(v for value in point.values() for v in (value if isinstance(value, Sequence) else (value,))))
