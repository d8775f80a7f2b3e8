"""The refined design: a width, a route for a tube of that width, its sides, then a spline tube by linear programming.

    arena -> the widest share of start and target for which a route is short enough (design/spline_tubes/widest.py)
          -> sides of the box of that width that moves along the route; where that fails, the sides that last longest, with times
          -> the slowest tube of that width (small linear programs, one for each dimension), sides chosen again while it helps
          -> a smaller share, until the tube is slow enough; then the smoothest of all that are as slow
          -> coefficients rounded to a dyadic grid that a float holds exactly

So the width is in every bound from the start. Nothing here is trusted: the exact certificate is computed from the rounded
coefficients alone.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from stt_codegen.design.arena import Arena, arena_of, normalise, starting_box
from stt_codegen.design.filter_rate import with_filter, with_other_filters
from stt_codegen.design.lattice import lattice_of
from stt_codegen.design.mission_search import MissionSearch, search_of, without_solver_cache
from stt_codegen.design.missions import mission_of, require_start
from stt_codegen.design.refusals import explain_refusal
from stt_codegen.design.spline_tubes import (
    MANY_OBSTACLES,
    SEGMENT_TRIALS,
    SplineTube,
    TubeSearch,
    crossing_time,
    longest_period,
    segment_counts_of,
    smoothest_tube,
    strength_of,
)
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.task import Task

SPEED_CAPS = (2, 1, 4, 16)  # times the speed needed without bounds by component: the limits that are tried, in this order
ADVICE_LABEL_LIMIT = 3_000  # labels of a search for an order of visits, for advice: it is made some dozens of times
MANY_SEGMENTS = 512  # where sets move or a mission has times, and no tube of fewer segments is found
FILTERED_TUBES = 2  # for which other filter rates are tried, where no tube is certified with its own
SLOWEST_TOLERANCE = 1.01  # a tube so many times as fast as the slowest counts as slow as it, and the widest of these is taken


class _SearchResult(NamedTuple):
    """A tube, and the search that found it."""

    search: TubeSearch
    tube: SplineTube


def refine(task: Task) -> RefinedDesign:
    """Design a refined tube, the one that tube.prefer asks for. Raises `NotCertified` with the reason when none is found."""
    return _design_of(task, _search_or_refuse(task))


def alternatives(task: Task, first: RefinedDesign | None) -> Iterator[RefinedDesign]:
    """Yield other tubes of the task, for the case that its first one is not certified: those that it leaves open.

    First come tubes of other widths, where the task states no `tube.prefer`; then other plans of a mission, more segments, and
    for order 2 other filter rates. Tubes that are no better for the period than the first are left out, but with noise for
    other filter rates. Every tube is rounded and has its filter. first: None where there is none.
    """
    result = _search(task)
    if result is None and task.tube.segments is None and (task.mission or task.has_timed_sets):
        task = task.changed(tube={"segments": MANY_SEGMENTS})
        result = _search(task)
    if result is None:
        return
    search = without_solver_cache(result.search)
    allowance = Fraction(search.arena.allowance) * Fraction(search.arena.length_unit)
    strength_of_first = None if first is None else strength_of(task, first, allowance)

    def promising(designs: Iterable[RefinedDesign]) -> list[RefinedDesign]:
        """Return those that may be better than the first, the strongest first."""
        pairs = [(strength_of(task, design, allowance), design) for design in designs if design != first]
        promising_pairs = [pair for pair in pairs if strength_of_first is None or pair[0].is_promising_beside(strength_of_first)]
        return [design for _, design in sorted(promising_pairs, key=lambda pair: pair[0].crossing_time, reverse=True)]

    leaves_width_open = "prefer" not in task.tube.model_fields_set
    tubes = [result.tube, *(_tubes_of_other_widths(search) if leaves_width_open else [])]
    designs = [design for tube in tubes if (design := _filtered_or_none(task, search, tube)) is not None]
    yield from promising(designs)
    for tube in _other_plans_and_segments(search):
        design = _filtered_or_none(task, search, tube)
        if design is not None:
            designs.append(design)
            yield from promising([design])
    if task.order == 2 and task.filter is None:
        best = sorted(designs, key=lambda design: strength_of(task, design, allowance).crossing_time, reverse=True)
        filtered = itertools.chain.from_iterable(with_other_filters(task, design) for design in best[:FILTERED_TUBES])
        # with noise a faster filter may be better although its tube is quicker to cross
        yield from filtered if task.has_noise else promising(filtered)


def _other_plans_and_segments(search: TubeSearch) -> Iterator[SplineTube]:
    """Yield tubes along other plans of a mission, and tubes of more segments where their number is open."""
    if isinstance(search, MissionSearch):
        yield from (tube for tube in search.generate_other_plans() if search.meets_speed_limits(tube))
    elif len(search.segment_counts) > SEGMENT_TRIALS and len(search.arena.names) <= MANY_OBSTACLES:
        finer = without_solver_cache(replace(search, segment_counts=search.segment_counts[SEGMENT_TRIALS:]))
        tube = finer.find_widest()
        yield from [] if tube is None or not search.meets_speed_limits(tube) else [tube]


def _filtered_or_none(task: Task, search: TubeSearch, tube: SplineTube) -> RefinedDesign | None:
    """Return the rounded tube with its filter; None where the tube admits none."""
    with suppress(NotCertified):
        return _round_and_filter(task, search, tube)
    return None


def _search_or_refuse(task: Task) -> _SearchResult:
    """Return the preferred tube. Raises `NotCertified` where there is none; its reason is worked out when it is read."""
    result = _search(task)
    if result is None:
        raise NotCertified(lambda: explain_refusal(task, _normalised_arena(task), _has_tube))
    return result


def _search(task: Task) -> _SearchResult | None:
    return _search_preferred(task, _normalised_arena(task))


def refine_with_allowance(task: Task, rounding_allowance_factor: int) -> RefinedDesign | None:
    """Design the tube that is preferred with so many times the usual allowance for rounding at every bound on its edges. Returns
    None where there is none."""
    with suppress(NotCertified):
        result = _search_preferred(task, _normalised_arena(task, rounding_allowance_factor))
        return None if result is None else _design_of(task, result)
    return None


def family(task: Task) -> list[RefinedDesign]:
    """Return tubes of several widths for one task, the widest first; of many unsafe sets the slowest alone.

    They are those that tube.prefer chooses from.
    """
    result = _search_preferred(task, _normalised_arena(task))
    if result is None:
        return []
    search = without_solver_cache(result.search)
    return [_round_and_filter(task, search, tube) for tube in _tubes_of_other_widths(search)]


def _normalised_arena(task: Task, rounding_allowance_factor: int = 1) -> Arena:
    lattice = replace(lattice_of(task), rounding_allowance_factor=rounding_allowance_factor)
    return normalise(arena_of(task, lattice), lattice.exponent)


def _has_tube(task: Task) -> bool:
    """Return whether a tube within its limits is found for a task that a refusal proposes."""
    with suppress(NotCertified):
        return _search_preferred(task, _normalised_arena(task), ADVICE_LABEL_LIMIT) is not None
    return False


def _design_of(task: Task, result: _SearchResult) -> RefinedDesign:
    """Round the tube and choose its filter; where no filter does, those of the slowest tube."""
    try:
        return _round_and_filter(task, *result)
    except NotCertified:  # of order 2: a narrower tube demands less acceleration
        slowest = without_solver_cache(result.search).find_slowest() if task.order == 2 else None
        if slowest is None:
            raise
        return _round_and_filter(task, result.search, slowest)


def _search_preferred(task: Task, arena: Arena, label_limit: int | None = None) -> _SearchResult | None:
    """Return the tube that is preferred, within its limits; None where none is found.

    A bound on a component's speed is no reason to use it up. So a tube is first searched without these bounds, and returned if it
    keeps to them; then no component may be faster than a few times what it needs without such bounds. label_limit: labels that
    are looked at for an order of the visits.
    """
    start, segment_counts = starting_box(arena), segment_counts_of(task, arena)
    mission = mission_of(task, arena)
    if mission is not None and label_limit is not None:
        mission = replace(mission, label_limit=label_limit)
    if mission is not None:
        require_start(mission, start)
    search = search_of(arena, start, segment_counts, mission)
    tube = _preferred_tube(task, search)
    if tube is not None and search.meets_speed_limits(tube):
        return _SearchResult(search, tube)
    if np.all(arena.max_speeds == arena.max_speed):
        return None
    lowest_limit = float(arena.max_speeds.min())
    needed_speed = lowest_limit if tube is None else max(tube.speed, lowest_limit)
    for cap in SPEED_CAPS:
        speeds = np.minimum(arena.max_speeds, cap * needed_speed)
        fastest = float(speeds.max())
        capped_arena = replace(arena, max_speed=fastest, relative_speeds=speeds / fastest)
        search = search_of(capped_arena, start, segment_counts, mission)
        tube = _preferred_tube(task, search)
        if tube is not None and search.meets_speed_limits(tube):
            return _SearchResult(search, tube)
    return None


def _preferred_tube(task: Task, search: TubeSearch) -> SplineTube | None:
    """Return the tube that tube.prefer asks for, of all that are found."""
    has_many_obstacles = len(search.arena.names) > MANY_OBSTACLES
    balanced = search.find_among_many_obstacles() if has_many_obstacles else search.find_widest()
    if _preference(task) == "balanced":
        return balanced
    tubes = [] if balanced is None or not search.meets_speed_limits(balanced) else [balanced]
    # without the cache these are the same tubes whatever was solved before
    tubes += _tubes_of_other_widths(without_solver_cache(search))
    return _choose_preferred(task, search, tubes)


def _preference(task: Task) -> str:
    """Return tube.prefer; where it is left open and the drive lags, "period", since many tubes are too fast for a slow drive."""
    return "period" if task.has_drive and "prefer" not in task.tube.model_fields_set else task.tube.prefer


def _tubes_of_other_widths(search: TubeSearch) -> list[SplineTube]:
    if len(search.arena.names) <= MANY_OBSTACLES:
        return list(search.generate_family())
    slowest = search.find_slowest()
    return [slowest] if slowest is not None and search.meets_speed_limits(slowest) else []


def _choose_preferred(task: Task, search: TubeSearch, tubes: list[SplineTube]) -> SplineTube | None:
    """Return the tube that tube.prefer asks for; the first of equals."""
    if not tubes:
        return None
    preference = _preference(task)
    if preference == "period":
        allowance = Fraction(search.arena.allowance) * Fraction(search.arena.length_unit)
        measure = crossing_time if task.has_drive else longest_period
        return max(tubes, key=lambda tube: measure(task, _round_and_filter(task, search, tube), allowance))
    if preference == "wide":
        return max(tubes, key=lambda tube: (tube.width.min(), -tube.speed))
    slow = [tube for tube in tubes if tube.speed <= SLOWEST_TOLERANCE * min(t.speed for t in tubes)]
    return max(slow, key=lambda tube: tube.width.min())


def _round_and_filter(task: Task, search: TubeSearch, tube: SplineTube) -> RefinedDesign:
    return with_filter(task, round_design(task, smoothest_tube(search.arena, search.start, tube)))


def round_design(task: Task, tube: SplineTube) -> RefinedDesign:
    """Return the design whose table is the tube's control points over 6, rounded to the lattice, so that the scalar holds them.

    The tube's points are in units of the lattice's size, from its origin. Floats and doubles share one tube, and one certificate,
    unless the task is far from the origin or a float needs a larger allowance.
    """
    lattice = lattice_of(task)
    integers = np.rint(np.ldexp(tube.points / 6, lattice.step_bits)).astype(np.int64)
    integers += np.array(lattice.offsets, dtype=np.int64)[:, None]
    if tube.seam is None:
        integers[:, :, -task.order :] = integers[:, :, -3:-2]
    else:
        integers[:, :, -3:] = integers[:, :, tube.seam : tube.seam + 3]
    table = tuple(tuple((low, high) for low, high in row) for row in integers.transpose(2, 1, 0).tolist())
    return RefinedDesign(task.prescribed_time, integers.shape[2] - 3, lattice.bits, table, seam=tube.seam)
