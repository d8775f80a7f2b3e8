"""Every backend against the reference, on points that include the edges, each quantity within a derived bound.

A backend is CasADi, or the emitted code of one language in one precision. `stt-codegen compare` and the tests call `compare`.
eps is half a unit in the last place of 1 in the backend's scalar (2^-24 or 2^-53). delta is property P7's bound on an
emitted edge. The bounds, first-order terms rounded up:

    tube, tube rate   refined: `controller.edge_errors`, delta and its counterpart for the rate
    margin m          (1 + 2 |m|) delta over the width (an edge in the distance, both in the width), and 8 eps
    e                 8 eps           the nearer distance: 3 roundings; the farther: what the width leaves; difference, quotient
    epsilon           (8 + 4 |epsilon|) eps    a/b within 7 eps, and a logarithm within 2 units in its last place; for
                      `math = "inline"` the relative error of `controller.kernels.logarithm` more, for u too
    xi                12 eps xi       b/a, 1 + b/a, division by b
    u                 refined: h(a, b) = (1/a + 1/b) ln(a/b) rises in a and falls in b, so edges moved by delta change k h by no
                      more than to the two corners (a +- delta, b -+ delta) clamped in a width changed by 2 delta; plus
                      |k| xi (8 + 4 |epsilon|) eps + 16 eps |u| for the arithmetic of the law
    status            may differ only where x is within delta (plus rounding) of an edge

integer_comparison.py has the bounds of a controller in integers, adaptive_comparison.py those of adaptive and literal designs.
docs/accuracy.md explains them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from stt_codegen.compare.adaptive_comparison import add_adaptive_rows
from stt_codegen.compare.casadi_backends import CasadiAdaptive, CasadiRefined
from stt_codegen.compare.comparison_rows import BackendMaker, ComparedBackend, ComparisonRow, RowCollector
from stt_codegen.compare.integer_comparison import add_integer_rows, count_differences_from_python
from stt_codegen.compare.refined_comparison import add_refined_rows
from stt_codegen.design_kinds import DesignKind
from stt_codegen.designs import AdaptiveDesign, Design, RefinedDesign, for_any_design
from stt_codegen.effort import Effort
from stt_codegen.errors import MissingTool, NotCertified
from stt_codegen.pipeline import EmittedController, build_program, build_task
from stt_codegen.program import FORMATS
from stt_codegen.program.targets import targets_of
from stt_codegen.program.targets.backend import Backend
from stt_codegen.task import Task

POINTS = 10_000


def compare(
    task: Task,
    points: int = POINTS,
    progress: Callable[[str], None] = lambda _: None,
    *,
    effort: Callable[[], Effort] = Effort,
) -> list[ComparisonRow]:
    """Compare all backends of a task with the reference.

    These are CasADi, the emitted Python, and the emitted C (and Rust) in both precisions. Of a controller in integers they are
    the Python and the C, which are also compared with one another, bit for bit. A task of doubles that cannot be certified in
    floats (far from the origin) is compared in double alone, and `progress` says so. effort: makes that of each design."""
    rows: list[ComparisonRow] = []
    references: dict[str, Any] = {}
    for controller, make_backend in _backends(task, progress, effort):
        progress(f"comparing {task.name}: {make_backend(controller).name}")
        rows += compare_backend(controller, make_backend, points, references)
    return rows


def _backends(
    task: Task, progress: Callable[[str], None], effort: Callable[[], Effort]
) -> Iterator[tuple[EmittedController, BackendMaker]]:
    """Yield the controllers to compare, certified or not, each with the function that makes its backend."""
    if task.emit.scalar == "fixed":
        yield from _emitted_backends(build_task(task, uncertified=True, effort=effort()), progress)
        return
    double = build_task(task.with_options(scalar="double"), uncertified=True, effort=effort())
    casadi = BY_KIND[double.design.kind].casadi
    yield double, lambda controller: casadi(controller, controller.design)
    yield from _emitted_backends(double, progress)
    try:
        single = build_task(task.with_options(scalar="float"), uncertified=True, effort=effort())
    except NotCertified:
        if task.emit.scalar == "float":
            raise
        progress(f"{task.name}: a float has no room for this task, so double alone is compared")
    else:
        yield from _emitted_backends(single, progress)


def _emitted_backends(
    controller: EmittedController, progress: Callable[[str], None]
) -> Iterator[tuple[EmittedController, BackendMaker]]:
    """Yield the backend of each language of the task; an optional language is left out where its tools are missing."""
    scalar = controller.task.emit.scalar
    for target in targets_of(controller.task.emit):
        if scalar not in (*target.scalars, "fixed"):
            continue
        try:
            make_backend = target.runner()
        except MissingTool as error:
            if not target.option:
                raise
            progress(f"{controller.task.name}: the {scalar} {target.title} is not compared: {error}")
        else:
            yield controller, make_backend


def compare_backend(
    controller: EmittedController,
    make_backend: BackendMaker,
    points: int = POINTS,
    references: dict[str, Any] | None = None,
) -> list[ComparisonRow]:
    """Compare one backend with the reference.

    references: what the reference computed for other backends of the controller, by scalar type; it is kept up to date."""
    backend = make_backend(controller)
    task = controller.task.with_options(scalar=backend.scalar)
    controller = replace(controller, task=task, program=build_program(task, controller.design))
    rows = RowCollector(backend.name, float(FORMATS[backend.scalar].roundoff))
    compared = ComparedBackend(controller, make_backend, backend, points, {} if references is None else references)
    BY_KIND[controller.design.kind].add_rows(rows, controller.design, compared)
    return rows.rows


def _add_rows_of_refined(rows: RowCollector, design: RefinedDesign, compared: ComparedBackend) -> None:
    """Compare a refined controller, in integers or in floating point."""
    if compared.controller.program.tick is None:
        add_refined_rows(rows, design, compared)
        return
    add_integer_rows(rows, design, compared)
    differences = count_differences_from_python(compared.controller, design, compared.backend, compared.points)
    rows.add_count("bits as Python's", float(differences), compared.points)


@dataclass(frozen=True)
class _KindComparison:
    """How a kind of tube is compared: its CasADi backend, and the function that adds the rows of any backend."""

    casadi: Callable[[EmittedController, Design], Backend]
    add_rows: Callable[[RowCollector, Design, ComparedBackend], None]


_OF_ADAPTIVE = _KindComparison(for_any_design(AdaptiveDesign, CasadiAdaptive), for_any_design(AdaptiveDesign, add_adaptive_rows))
BY_KIND: Mapping[DesignKind, _KindComparison] = {
    "refined": _KindComparison(for_any_design(RefinedDesign, CasadiRefined), for_any_design(RefinedDesign, _add_rows_of_refined)),
    "adaptive": _OF_ADAPTIVE,
    "literal": _OF_ADAPTIVE,
}
