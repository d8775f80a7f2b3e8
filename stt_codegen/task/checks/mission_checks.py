"""Checks of the regions and the mission of a task.

Each check returns the message of the first field that is wrong, or None. `first_problem` of field_checks.py calls them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction

from stt_codegen.decimals import decimal
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.task.checks.set_checks import set_problem
from stt_codegen.task.mission import FORMS, KEYWORDS, MissionEntry, RegionUnion, intervals_of, regions_of
from stt_codegen.task.schema import TaskTables
from stt_codegen.task.sets import Unsafe, UnsafePolytope, concave_problem

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
# By scalar: the relative rounding error of a sum of times.
ROUNDOFF = {"float": Fraction(1, 1 << 24), "double": Fraction(1, 1 << 53), "fixed": Fraction(0)}
PERIOD_PER_ROUNDING = 1000  # a shorter period would be wrong by more than a thousandth when it is added to the time
REGION_COUNT_LIMIT, ENTRY_COUNT_LIMIT = 400, 40
CONVEX_PARTS = "give its convex parts as regions, and a region that is any_of of them"


def mission_problem(task: TaskTables) -> str | None:
    """Return the message of the first check of regions and mission that fails, or None."""
    for field, limit in (("region", REGION_COUNT_LIMIT), ("mission", ENTRY_COUNT_LIMIT)):
        if len(getattr(task, field)) > limit:
            return f"{field}: has {len(getattr(task, field))} entries; at most {limit} are taken"
    if "mission" in task.model_fields_set and not task.mission:
        return "mission: is empty; add [[mission]], or leave it out"
    if task.region and not task.mission:
        return "region: is only read by a mission; add [[mission]], or leave the regions out"
    if task.repeat and (problem := _repeat_problem(task)):
        return problem
    if task.mission and not task.tube.capabilities.carries_out_missions:
        kinds = kinds_offering("carries_out_missions")
        return f"mission: is for the {kinds} design; the {task.tube.design} one knows one target alone, leave the mission out"
    known: dict[str, Unsafe | RegionUnion] = {}
    for j, region in enumerate(task.region):
        if problem := _region_problem(task, region, known):
            return f"region[{j}].{problem}"
        known[region.name] = region
    return next((f"mission[{k}]{p}" for k, e in enumerate(task.mission) if (p := _entry_problem(task, e, known))), None)


def _repeat_problem(task: TaskTables) -> str | None:
    """Return a message where a field does not fit to a tube that never ends, else None."""
    if not task.mission:
        return "repeat: is for missions; say by [[mission]] what is done for ever, as a patrol, or leave repeat out"
    if task.target_set is not None:
        return "target_set: is where a tube ends, and with repeat = true it does not; leave it out, or visit it as a region"
    period, step = task.control.period, task.prescribed_time * ROUNDOFF[task.emit.scalar]
    if period is not None and task.emit.tick_period is None and step * PERIOD_PER_ROUNDING > period:
        problem = (
            f"{decimal(period)} s is lost where a {task.emit.scalar} adds it to a time of up to {decimal(task.prescribed_time)} s"
        )
        return f"control.period: {problem}, for ever; count in ticks: give emit.tick_period"
    for j, unsafe in enumerate(task.unsafe):
        for field in ("motion", "during", "timing", "spread"):
            if getattr(unsafe, field) is not None:
                return f"unsafe[{j}].{field}: with repeat = true unsafe sets stand still and are always there; leave it out"
    return None


def _region_problem(task: TaskTables, region: Unsafe | RegionUnion, known: dict[str, Unsafe | RegionUnion]) -> str | None:
    """Return a message about a region without "region[j].", or None. known: the regions before it, by name."""
    if "name" not in region.model_fields_set or not NAME.fullmatch(region.name) or region.name in (*KEYWORDS, "inf"):
        reason = f"{region.name!r} is no name of a region" if region.name else "is missing"
        return f"name: {reason}; use a letter, then letters, digits or _, and none of {', '.join(KEYWORDS)}, inf"
    if region.name in known:
        return f"name: {region.name!r} is already the name of region[{list(known).index(region.name)}]; names must differ"
    if isinstance(region, RegionUnion):
        unknown = next((name for name in region.any_of if name not in known), None)
        if unknown is not None or not region.any_of:
            reason = f"{unknown!r} is no region before this one" if region.any_of else "is empty"
            return f"any_of: {reason}; name some of {', '.join(known) or 'those that you add before it'}"
        return None
    for field in ("motion", "during", "timing", "spread"):
        if getattr(region, field) is not None:
            return f"{field}: is for unsafe sets; regions stand still and are always there, leave it out"
    if problem := set_problem(task, region):
        return problem
    try:
        region.to_set_in(task.state_space, task.axis_indices(region))
    except ValueError as error:
        return str(error)
    return None


def _entry_problem(task: TaskTables, entry: MissionEntry, known: dict[str, Unsafe | RegionUnion]) -> str | None:
    """Return a message about an entry that begins with ": " or with ".field: ", or None."""
    fields = [name for name in MissionEntry.model_fields if getattr(entry, name) is not None]
    form = entry.form
    if form is None:
        forms = [name for name in FORMS if name in fields]
        reason = f"has {' and '.join(forms)}" if forms else "says nothing"
        return f": {reason}; one of {', '.join(FORMS)} is needed"
    extra = next((name for name in fields if name != form and name not in FORMS[form]), None)
    if extra is not None:
        return f".{extra}: is not for {form}; leave it out" + (
            f", beside it stand {', '.join(FORMS[form])}" if FORMS[form] else ""
        )
    if problem := _times_problem(task, entry):
        return problem
    try:
        meaning = entry.meaning(task.prescribed_time, task.repeat)
    except ValueError as error:
        return f".formula: {error}"
    for leaf in regions_of(meaning):
        if leaf.region not in known:
            field = next((n for n in ("visit", "then", "never", "before") if getattr(entry, n) == leaf.region), form)
            if form == "formula" and leaf.region.lower() in ("true", "false"):
                return f".formula: {leaf.region!r} is no region; for `true until g` write eventually g, else leave it out"
            return f".{field}: {leaf.region!r} is no region; known are {', '.join(known) or 'none, add [[region]]'}"
        if not leaf.is_negated and (member := _member_without_half_spaces(known, leaf.region)):
            return f".{form}: {member} can only be avoided, as every capsule; to be in, give any_of of balls, or vertices"
        if not leaf.is_negated and (concave := _concave_member_problem(known, leaf.region)):
            return f".{form}: {concave}"
    t_c = task.prescribed_time
    windows = () if task.repeat or not entry.formula else intervals_of(meaning)
    late = next((w for w in windows if w.end is not None and w.end > t_c), None)
    if late is not None:
        reason = f"the window {late} ends after prescribed_time = {decimal(t_c)}"
        return f".formula: {reason}, from when on the tube stands; use at most that, or inf"
    return None


def _times_problem(task: TaskTables, entry: MissionEntry) -> str | None:
    """Return a message where a time of an entry is missing, out of order or after the prescribed time, else None."""
    t_c, window = task.prescribed_time, entry.between
    if window is not None and not 0 <= window[0] <= window[1] <= t_c:
        ends = f"[{decimal(window[0])}, {decimal(window[1])}]"
        return f".between: is {ends}; from must not be after to, and both between 0 and prescribed_time = {decimal(t_c)}"
    if entry.within is not None and entry.then is None:
        return ".within: is about `then`; give it, or leave within out"
    end = (window[0] if window else Fraction(0)) + (entry.stay or 0)
    if end > t_c and not task.repeat:
        return f".stay: lasts to {decimal(end)} s at the earliest, after prescribed_time = {decimal(t_c)}; shorten it"
    if entry.patrol is not None:
        if not entry.patrol:
            return ".patrol: is empty; name the regions to be visited again and again"
        if entry.every is None:
            return ".every: is missing; give the seconds between two visits of one region, at most"
        until = entry.until or t_c
        if task.repeat and entry.every > t_c and entry.until is None:
            problem = f"is {decimal(entry.every)}, longer than prescribed_time = {decimal(t_c)}, by when the first cycle ends"
            return f".every: {problem}; use that or less"
        if until > t_c:
            return f".until: is {decimal(until)}, after prescribed_time = {decimal(t_c)}; use that or less"
        if entry.every > until:
            return f".every: is {decimal(entry.every)}, longer than the patrol, which ends at {decimal(until)}; use that or less"
    return None


def _members(known: dict[str, Unsafe | RegionUnion], name: str) -> Iterator[Unsafe]:
    """Yield the region, or all members of a union, also of nested ones."""
    region = known[name]
    if isinstance(region, RegionUnion):
        for member in region.any_of:
            yield from _members(known, member)
    else:
        yield region


def _member_without_half_spaces(known: dict[str, Unsafe | RegionUnion], name: str) -> str | None:
    """Return the name of the first member of a region that has no half-spaces inside it, as a capsule, or None."""
    return next((member.name for member in _members(known, name) if not member.half_spaces()), None)


def _concave_member_problem(known: dict[str, Unsafe | RegionUnion], name: str) -> str | None:
    """Return a message where the points of a region's member are not convex, so that their hull may hold too much, else None."""
    for member in _members(known, name):
        if isinstance(member, UnsafePolytope) and (problem := concave_problem(member.vertices, CONVEX_PARTS)):
            return f"region {member.name}, {problem}"
    return None
