"""The refined design: a width, a route with room for it, its sides, then a spline tube by linear programming.

    arena -> the widest share of start and target for which a route is short enough (design/spline_tubes/widest.py)
          -> sides of the box of that width that moves along the route; where that fails, stays and stretch times
          -> the slowest tube of that width (small linear programs, one for each dimension), sides chosen anew while it helps
          -> a smaller share, until the tube is slow enough; then, of all that slow, the one that bends least
          -> coefficients rounded to a dyadic grid that a float holds exactly

So the width is in every bound from the start. Nothing here is trusted: the exact certificate is computed from the rounded
coefficients alone.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np

from stt_codegen.design.arena import Arena, arena_of, normalised, starting_box
from stt_codegen.design.filter_rate import with_filter
from stt_codegen.design.lattice import lattice_of
from stt_codegen.design.mission_search import search_of, without_solver_cache
from stt_codegen.design.missions import mission_of, require_start
from stt_codegen.design.refusals import explain_refusal
from stt_codegen.design.spline_tubes import PLENTY, Search, Shape, calmest, segments_tried
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.sampling import Gains, condition_kinds_of, loop_of, natural_gain
from stt_codegen.task import Task

CAPS = (2, 1, 4, 16)  # times the speed without bounds by component is what one may have, in this order
LITTLE = 3_000  # labels of a search for an order, where it is only asked what would do: that is asked some dozens of times
AS_SLOW = 1.01  # times the slowest tube is as slow, where that is preferred: so much for width


def refine(task: Task) -> RefinedDesign:
    """Design a refined tube, the one that tube.prefer asks for. Raises `NotCertified` with the reason when none is found."""
    arena = _arena(task)
    found = _designed(task, arena)
    if found is None:
        raise NotCertified(explain_refusal(task, arena, _is_found))
    return _completed(task, *found)


def refine_with_allowance(task: Task, rounding_allowance_factor: int) -> RefinedDesign | None:
    """Design the tube that is preferred with so many times the usual allowance for rounding at every bound on its edges. Returns
    None where there is none."""
    with suppress(NotCertified):
        designed = _designed(task, _arena(task, rounding_allowance_factor))
        return None if designed is None else _completed(task, *designed)
    return None


def _completed(task: Task, search: Search, shape: Shape) -> RefinedDesign:
    """Round the tube and choose its filter; where no filter does, those of the slowest tube."""
    try:
        return _finished(task, search, shape)
    except NotCertified:  # of order 2: a narrower tube presses less
        slow = without_solver_cache(search).slowest() if task.order == 2 else None
        if slow is None:
            raise
        return _finished(task, search, slow)


def family(task: Task) -> list[RefinedDesign]:
    """Tubes of several widths for one task, the widest first; of many unsafe sets the slowest alone. They are those that
    tube.prefer chooses from."""
    found = _designed(task, _arena(task))
    if found is None:
        return []
    fresh = without_solver_cache(found[0])
    return [_finished(task, fresh, shape) for shape in _others(fresh)]


def _arena(task: Task, rounding_allowance_factor: int = 1) -> Arena:
    lattice = replace(lattice_of(task), rounding_allowance_factor=rounding_allowance_factor)
    return normalised(arena_of(task, lattice), lattice.exponent)


def _is_found(task: Task) -> bool:
    with suppress(NotCertified):
        return _designed(task, _arena(task), LITTLE) is not None
    return False


def _designed(task: Task, arena: Arena, effort: int | None = None) -> tuple[Search, Shape] | None:
    """The tube that is preferred, within its limits; None where none is found. A bound on a component's speed is no reason to
    use it up: first it is only asked whether it is kept, then no component may be faster than a few times what it takes without
    such bounds. effort: labels that are looked at for an order of the visits."""
    start, ladder = starting_box(arena), segments_tried(task, arena)
    mission = mission_of(task, arena)
    if mission is not None and effort is not None:
        mission = replace(mission, label_limit=effort)
    if mission is not None:
        require_start(mission, start)
    plain = search_of(arena, start, ladder, mission)
    shape = _chosen(task, plain)
    if shape is not None and plain.keeps(shape):
        return plain, shape
    if np.all(arena.max_speeds == arena.max_speed):
        return None
    base = plain.arena.max_speeds.min() if shape is None else max(shape.speed, float(plain.arena.max_speeds.min()))
    for times in CAPS:
        speeds = np.minimum(arena.max_speeds, times * base)
        fastest = float(speeds.max())
        search = search_of(replace(arena, max_speed=fastest, swiftness=speeds / fastest), start, ladder, mission)
        shape = _chosen(task, search)
        if shape is not None and search.keeps(shape):
            return search, shape
    return None


def _chosen(task: Task, search: Search) -> Shape | None:
    """Of the tubes that are found the one that tube.prefer asks for."""
    shape = search.many() if len(search.arena.names) > PLENTY else search.widest()
    if task.tube.prefer == "balanced":
        return shape
    own = [] if shape is None or not search.keeps(shape) else [shape]
    # made anew, so that they are the same tubes whatever was solved before
    return _preferred(task, search, own + _others(without_solver_cache(search)))


def _others(search: Search) -> list[Shape]:
    if len(search.arena.names) <= PLENTY:
        return list(search.family())
    slow = search.slowest()
    return [slow] if slow is not None and search.keeps(slow) else []


def _preferred(task: Task, search: Search, shapes: list[Shape]) -> Shape | None:
    """Of several tubes the one that tube.prefer asks for; the first of equals."""
    if not shapes:
        return None
    if task.tube.prefer == "period":
        allowance = Fraction(search.arena.allowance) * Fraction(search.arena.length_unit)
        return max(shapes, key=lambda shape: _longest_period(task, _finished(task, search, shape), allowance))
    if task.tube.prefer == "wide":
        return max(shapes, key=lambda shape: (shape.width.min(), -shape.speed))
    slow = [shape for shape in shapes if shape.speed <= AS_SLOW * min(s.speed for s in shapes)]
    return max(slow, key=lambda shape: shape.width.min())


def _finished(task: Task, search: Search, shape: Shape) -> RefinedDesign:
    return with_filter(task, round_design(task, calmest(search.arena, search.start, shape)))


def _longest_period(task: Task, design: RefinedDesign, allowance: Fraction) -> float:
    """Seconds between samples that are proved for the plant's bounds and the share of starts: at the task's gain, over all gains
    where that is left open. 0 where there are none. allowance: for the arithmetic, whose error is not derived yet."""
    edge, rate = ((v,) * task.dimension for v in (allowance, allowance * design.segments / design.prescribed_time))
    setting, statements = loop_of(task, design, edge, rate), condition_kinds_of(task)
    if task.control.gain is None or task.has_automatic_gain:
        best = Gains(setting, natural_gain(setting), kinds=statements).longest
        return 0.0 if best is None else best[1].seconds
    period = Gains(setting, setting.law.gain, kinds=statements).at(setting.law.gain)
    return 0.0 if period is None else period.seconds


def round_design(task: Task, shape: Shape) -> RefinedDesign:
    """Control points over 6 (here in units of the lattice's size, from its origin), rounded to the lattice, so that the scalar
    holds them exactly. Floats and doubles share one tube, and one certificate, unless the task is far from the origin or a
    float needs a larger allowance."""
    lattice = lattice_of(task)
    integers = np.rint(np.ldexp(shape.points / 6, lattice.step_bits)).astype(np.int64)
    integers += np.array(lattice.offsets, dtype=np.int64)[:, None]
    if shape.seam is None:
        integers[:, :, -task.order :] = integers[:, :, -3:-2]
    else:
        integers[:, :, -3:] = integers[:, :, shape.seam : shape.seam + 3]
    table = tuple(tuple((low, high) for low, high in row) for row in integers.transpose(2, 1, 0).tolist())
    return RefinedDesign(task.prescribed_time, integers.shape[2] - 3, lattice.bits, table, seam=shape.seam)
