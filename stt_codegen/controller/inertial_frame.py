"""The frame of a controller for a plant of order 2: v + lambda x is held in the filtered tube (designs/filtered.py), by the same
law, from distances that lose nothing where both edges are near:

    a = (v - L') + lambda (x - L),    b = (R' - v) + lambda (R - x),    a + b = (R' - L') + lambda (R - L)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

from stt_codegen.controller.comments import axes_doc, inward_doc, law_doc
from stt_codegen.controller.kernels import (
    MARGINS_DOC,
    Between,
    Law,
    SplineKernels,
    control_component,
    entry,
    inside_of,
    loaded,
    margin_component,
    not_finite,
    place_of,
    start,
)
from stt_codegen.decimals import by_component, decimal
from stt_codegen.designs import LOWER, UPPER, RefinedDesign
from stt_codegen.program import (
    FALSE,
    NAN,
    REAL,
    STATUS,
    TICK,
    TRUE,
    Block,
    Const,
    Function,
    IsFinite,
    Kernel,
    Load,
    Operand,
    Param,
    Select,
    Status,
    Table,
    Var,
    real,
)
from stt_codegen.task import Task

OK, OUTSIDE, BAD = (Const(s, STATUS) for s in (Status.OK, Status.OUTSIDE_TUBE, Status.BAD_INPUT))


@dataclass(frozen=True)
class Filter:
    """lambda by component; per_second: segments in a second."""

    values: tuple[Fraction, ...]
    per_second: Fraction

    @classmethod
    def of(cls, design: RefinedDesign) -> Filter:
        return cls(design.filter, Fraction(design.segments) / design.prescribed_time)

    def __str__(self) -> str:
        """As people are told."""
        return by_component(self.values)

    @property
    def tables(self) -> list[Table]:
        """Where lambda differs by component."""
        doc = ("lambda of v + lambda x, by component.",)
        return [Table("filter", self.values, len(self.values), doc)] if len(set(self.values)) > 1 else []

    def of_component(self, block: Block, i: Operand) -> Operand:
        return real(self.values[0]) if len(set(self.values)) == 1 else block.let("filter_i", Load("filter", i))


@dataclass(frozen=True)
class Known:
    """How far the edges are apart, and the distances to both, once computed."""

    width: Var
    to_edges: tuple[Var, Var]

    @classmethod
    def of(cls, block: Block, between: Between) -> Known:
        return cls(between.room(block), between.distances(block))

    def room(self, _block: Block) -> Var:
        return self.width

    def distances(self, _block: Block) -> tuple[Var, Var]:
        return self.to_edges


@dataclass(frozen=True)
class Filtered:
    """v + lambda x between the edges of the filtered tube: x between its edges, v between their rates."""

    places: Known
    rates: Known
    filter: Operand

    def room(self, block: Block) -> Var:
        return self._sum(block, "room", self.rates.room(block), self.places.room(block))

    def distances(self, block: Block) -> tuple[Var, Var]:
        (v_lower, v_upper), (x_lower, x_upper) = self.rates.distances(block), self.places.distances(block)
        return self._sum(block, "to_lower", v_lower, x_lower), self._sum(block, "to_upper", v_upper, x_upper)

    def _sum(self, block: Block, name: str, rate: Var, place: Var) -> Var:
        return block.op(name, "add", rate, block.op("filtered", "mul", place, self.filter))


@dataclass(frozen=True)
class Frame:
    """What the functions have in common."""

    spline: SplineKernels
    filter: Filter
    n: int

    def edges(self, block: Block, row: Operand, i: Operand, weights: tuple[Var, ...], rates: tuple[Var, ...]) -> list[Var]:
        """Statements for L, R, L', R' of component i."""
        at = entry(block, row, i)
        places: list[Var] = []
        slopes: list[Var] = []
        for side, name in ((LOWER, "lower"), (UPPER, "upper")):
            entries = loaded(block, self.n, at, side, name)
            places += block.call(self.spline.blend, *weights, *entries, names=(f"{name}_edge",))
            (slope,) = block.call(self.spline.blend, *rates, *entries, names=(f"{name}_slope",))
            slopes.append(block.op(f"{name}_rate", "mul", slope, real(self.filter.per_second)))
        return [*places, *slopes]

    def apart(self, block: Block, row: Operand, i: Operand, weights: tuple[Var, ...], slopes: tuple[Var, ...]) -> Filtered:
        """Statements for where component i is."""
        low, high, low_rate, high_rate = self.edges(block, row, i, weights, slopes)
        x, v = (block.let(f"{name}_i", Load(name, i)) for name in ("x", "v"))
        places, rates = Known.of(block, Between(low, high, x)), Known.of(block, Between(low_rate, high_rate, v))
        return Filtered(places, rates, self.filter.of_component(block, i))

    def begun(self, block: Block, when: Var) -> tuple[Var, tuple[Var, ...], tuple[Var, ...]]:
        """Statements for the table's row, and the weights of edges and of their rates."""
        row, s = block.call(self.spline.segment, when)
        return row, block.call(self.spline.basis, s), block.call(self.spline.basis_rate, s)


def inertial_functions(
    task: Task, spline: SplineKernels, design: RefinedDesign, law: Law, guarded: bool, clock: tuple[Kernel, ...]
) -> tuple[Function, ...]:
    """`filtered_tube`, `control`, `control_tick` where there is a clock, `margin` and `margins`."""
    frame = Frame(spline, Filter.of(design), design.dimension)
    frames = [replace(frame, spline=replace(spline, segment=kernel)) for kernel in (spline.segment, *clock)]
    velocity = (_velocity(task, frame.n),) if task.uses_differences else ()
    controls = (_control(task, f, law, guarded) for f in frames)
    return (_filtered_tube(frame), *velocity, *controls, _margin(frame, guarded), _margins(frame, guarded))


def _velocity(task: Task, n: int) -> Function:
    dt = Var("dt", REAL)
    block = Block({"dt", "x", "x_before", "v"})
    positive = block.op("positive", "lt", real(0), dt)
    step = block.select("step", positive, dt, real(1))
    with block.loop("i", n) as loop:
        now, before = (block.let(f"{name}_i", Load(name, loop.index)) for name in ("x", "x_before"))
        mean = block.op("mean", "div", block.op("moved", "sub", now, before), step)
        block.store("v", loop.index, block.select("v_i", positive, mean, NAN))
    block.leave()
    return Function(
        "velocity",
        (Param("dt", None), Param("x", n), Param("x_before", n), Param("v", n, True)),
        tuple(block.statements),
        False,
        (
            "Velocity by differences, v = (x - x_before) / dt, for `control`: dt is the time between both samples, as it was and",
            f"not as it should have been, from {decimal(task.shortest_period)} to {decimal(task.sampling_period)} s.",
            "At the first sample, at rest, v is 0. x_before is yours: put x there afterwards. NaN where dt is not positive, and",
            "`control` then says BAD_INPUT.",
        ),
    )


def _filtered_tube(frame: Frame) -> Function:
    block, row, s = start({"t", "lower", "upper"}, frame.spline, ("lower", "upper"), frame.n)
    weights, rates = block.call(frame.spline.basis, s), block.call(frame.spline.basis_rate, s)
    with block.loop("i", frame.n) as loop:
        low, high, low_rate, high_rate = frame.edges(block, row, loop.index, weights, rates)
        value = frame.filter.of_component(block, loop.index)
        for name, place, rate in (("lower", low, low_rate), ("upper", high, high_rate)):
            block.store(name, loop.index, block.op("edge", "add", rate, block.op("filtered", "mul", place, value)))
    block.leave()
    return Function(
        "filtered_tube",
        (Param("t", None), Param("lower", frame.n, True), Param("upper", frame.n, True)),
        tuple(block.statements),
        False,
        (
            f"Edges of the filtered tube at time t, in units per second: of v + lambda x, lambda = {frame.filter}.",
            "While v + lambda x is between them, x stays in the tube. NaN when t is not finite.",
        ),
    )


def _control(task: Task, frame: Frame, law: Law, guarded: bool) -> Function:
    """The law at a time that is whatever `segment` takes: seconds or a tick."""
    (when,) = frame.spline.segment.inputs
    block = Block({when.name, "x", "v", "u"})
    bad = not_finite(block, (when,) if when.type is REAL else (), (("x", frame.n), ("v", frame.n)))
    with block.leave_when(bad, BAD), block.loop("j", frame.n) as loop:
        block.store("u", loop.index, real(0))
    row, weights, rates = frame.begun(block, when)
    with block.loop("i", frame.n) as loop:
        i = loop.index
        outside = loop.carry("outside", FALSE)
        apart = frame.apart(block, row, i, weights, rates)
        place = place_of(block, law.share(block, i), apart, law.signed_gain(block, i), guarded)
        x_lower, x_upper = apart.places.distances(block)
        between = block.op("between", "and", block.op("over", "lt", real(0), x_lower), block.op("under", "lt", real(0), x_upper))
        inside = block.op("inside", "and", inside_of(block, place), between)
        loop.update(outside, block.select("outside_any", inside, outside, TRUE))
        block.store("u", i, control_component(block, law, place, law.limit(block, i)))
    block.leave(Select(outside, OUTSIDE, OK))
    times = "x or v" if when.type is TICK else "t, x or v"
    return Function(
        "control_tick" if when.type is TICK else "control",
        (Param(when.name, None, type=when.type), Param("x", frame.n), Param("v", frame.n), Param("u", frame.n, True)),
        tuple(block.statements),
        True,
        (
            law_doc(task, law),
            f"for v + lambda x in its tube, lambda = {frame.filter}. "
            + (_ticks(task) if when.type is TICK else "t: seconds since the start (held within [0, t_c]);"),
            "x: state; v: its rate; u: input.",
            *axes_doc(task),
            "OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law,",
            f"finite, and points inward{inward_doc(task)} (0 where the tube is empty). BAD_INPUT: {times} has a NaN or an",
            "infinity; u is 0. u may be the array x or v itself.",
        ),
    )


def _ticks(task: Task) -> str:
    assert task.emit.tick_period is not None
    return f"tick: periods of {decimal(task.emit.tick_period)} s since the start (it must not wrap to 0: stop counting at t_c);"


def _margin(frame: Frame, guarded: bool) -> Function:
    t = Var("t", REAL)
    block = Block({"t", "x", "v"})
    bad = not_finite(block, (t,), (("x", frame.n), ("v", frame.n)))
    with block.leave_when(bad, NAN):
        pass
    row, weights, rates = frame.begun(block, t)
    with block.loop("i", frame.n) as loop:
        least = loop.carry("margin", real(Fraction(1, 2)))
        apart = frame.apart(block, row, loop.index, weights, rates)
        lesser = _margin_component(block, apart, guarded)
        loop.update(least, block.select("margin_next", block.op("less", "lt", lesser, least), lesser, least))
    block.leave(least)
    return Function(
        "margin",
        (Param("t", None), Param("x", frame.n), Param("v", frame.n)),
        tuple(block.statements),
        False,
        (
            "How far x is from leaving the tube, and v + lambda x from leaving its own: the distance to the nearest edge",
            "over the width there, the lesser of both, least over the components. 0.5 in the middle, positive inside,",
            "negative outside, at least -1; NaN when an argument is not finite.",
            "Watch it: act while there is margin, not when the tube is left.",
        ),
        returns_real=True,
    )


def _margin_component(block: Block, apart: Filtered, guarded: bool) -> Var:
    """Statements for the lesser margin of v + lambda x in its tube and of x in its own."""
    filtered, position = (margin_component(block, inside, guarded) for inside in (apart, apart.places))
    return block.select("lesser", block.op("filtered_less", "lt", filtered, position), filtered, position)


def _margins(frame: Frame, guarded: bool) -> Function:
    """The public `margins`: by component the lesser margin of v + lambda x and of x."""
    block = Block({"t", "x", "v", "margin"})
    bad = block.op("bad", "not", block.let("finite", IsFinite(Var("t", REAL))))
    with block.leave_when(bad), block.loop("j", frame.n) as loop:
        block.store("margin", loop.index, NAN)
    row, weights, rates = frame.begun(block, Var("t", REAL))
    with block.loop("i", frame.n) as loop:
        apart = frame.apart(block, row, loop.index, weights, rates)
        block.store("margin", loop.index, _margin_component(block, apart, guarded))
    block.leave()
    params = (Param("t", None), Param("x", frame.n), Param("v", frame.n), Param("margin", frame.n, True))
    return Function("margins", params, tuple(block.statements), False, MARGINS_DOC)
