"""What no schema can see: how the fields of a task must fit together. Each check returns the message, or None.

Long because every message stands where its check is.
"""

from __future__ import annotations

from fractions import Fraction

from stt_codegen.decimals import decimal
from stt_codegen.program.targets import targets_of
from stt_codegen.task.checks.mission_checks import mission_problem
from stt_codegen.task.checks.set_checks import axes_problem, entries_problem, motion_problem, set_problem
from stt_codegen.task.schema import PLANT_BOUNDS, TaskTables
from stt_codegen.task.sets import (
    Box,
    BoxSet,
    Course,
    Normal,
    Region,
    UnsafeSet,
    affine_dimension,
    corners_of_cut_box,
    possible_sets,
)
from stt_codegen.task.values import ADD_IT


def first_problem(task: TaskTables) -> str | None:
    """The first thing that no schema can see, in the words of the message; None when there is none."""
    n = task.dimension
    return (
        structure_problem(task)
        or mission_problem(task)
        or _options_problem(task)
        or _containment_problem(task, n)
        or unsafe_problem(task)
    )


def structure_problem(task: TaskTables) -> str | None:
    """What makes names or numbers of entries wrong, whatever they say."""
    return _name_problem(task) or _shape_problem(task, task.dimension)


def _name_problem(task: TaskTables) -> str | None:
    name = task.name
    for target in targets_of(task.emit):
        asked = f" (emit.{target.key})" if target.option else ""
        if name in target.words:
            return f"name: {name!r} is {target.words_are}{asked}; choose another"
        if name.lower() in target.library:
            return f"name: {name!r} would shadow a part of the standard library of {target.title}{asked}; choose another"
    return None


def _shape_problem(task: TaskTables, n: int) -> str | None:
    target = task.target_set
    if target is None and not task.mission:
        return f"target_set: is missing; {ADD_IT}"
    tables: list[tuple[str, Box]] = [("state_space", task.state_space), ("initial_set", task.initial_set)]
    regions: list[tuple[str, Region]] = [("state_space", task.state_space)]
    if target is not None:
        tables.append(("target_set", target))
        regions.append(("target_set", target))
    vectors = [("initial_state", task.initial_state)]
    vectors += [(f"{field}.{name}", vector) for field, table in tables for name, vector in table.vectors()]
    if task.body is not None:
        vectors.append(("body", task.body))
    for name in ("gain", "e_max", "u_max"):
        given = getattr(task.control, name)
        if isinstance(given, tuple):
            vectors.append((f"control.{name}", given))
    for name in ("max_speed", "max_acceleration", "filter"):
        given = getattr(task.tube, name)
        if isinstance(given, tuple):
            vectors.append((f"tube.{name}", given))
    for name in PLANT_BOUNDS:
        given = getattr(task.plant, name)
        if isinstance(given, tuple):
            vectors.append((f"plant.{name}", given))
    if isinstance(task.initial_set.speed, tuple):
        vectors.append(("initial_set.speed", task.initial_set.speed))
    vectors += [(name, given) for name in ("axes", "units") if (given := getattr(task, name)) is not None]
    for field, vector in vectors:
        if len(vector) != n:
            return f"{field}: has {len(vector)} entries; state_space.lower has {n}, and all must agree"
    for field, region in regions:
        problem = axes_problem(task, region.axes) or entries_problem(task, region.axes, *region.points)
        if problem:
            return f"{field}.{problem}"
    if target is not None and (problem := motion_problem(task, target)):
        return f"target_set.{problem}"
    found = (table.problem() for _, table in tables)
    told = ((field, problem) for (field, _), problem in zip(tables, found, strict=True) if problem)
    return next((f"{field}{'.' if _of_a_field(problem) else ': '}{problem}" for field, problem in told), None) or next(
        (f"unsafe[{j}].{problem}" for j, unsafe in enumerate(task.unsafe) if (problem := set_problem(task, unsafe))), None
    )


def _of_a_field(problem: str) -> bool:
    """Whether a message about a table begins with one of its fields."""
    return problem.partition(" ")[0].endswith(":")


def _labels_problem(task: TaskTables) -> str | None:
    names = task.axes or ()
    for i, name in enumerate(names):
        if not name.strip() or name != name.strip():
            return f"axes[{i}]: is {name!r}; a name without spaces around it is needed"
        if name in names[:i]:
            return f"axes[{i}]: {name!r} is the name of axis {names.index(name) + 1} too; names must differ"
    return None


def _options_problem(task: TaskTables) -> str | None:
    if problem := _labels_problem(task):
        return problem
    for i, half in enumerate(task.body or ()):
        if half < 0:
            return f"body[{i}]: is {decimal(half)}; half extents must be 0 or greater"
    if problem := _control_problem(task):
        return problem
    for field in sorted(task.tube.capabilities.unread_options):
        if getattr(task.tube.adaptive, field) is not None:
            return f"tube.adaptive.{field}: is not a parameter of the {task.tube.design} design; leave it out"
    if problem := _limits_problem(task) or _order_problem(task) or _integers_problem(task):
        return problem
    return _plant_problem(task)


def _integers_problem(task: TaskTables) -> str | None:
    """What a controller in integers needs, and what it has no form of."""
    emit, control = task.emit, task.control
    if emit.scalar != "fixed":
        return None
    if not task.tube.capabilities.has_integer_form:
        return f'emit.scalar: "fixed" is for refined tubes; tube.design = "{task.tube.design}" takes "float" or "double"'
    if emit.tick_period is None:
        return 'emit.tick_period: is missing; with emit.scalar = "fixed" time is a count of ticks, say how many seconds one is'
    if control.u_max is None:
        return 'control.u_max: is missing; with emit.scalar = "fixed" u counts parts of it, so say how large it may be'
    if control.period is not None and (control.period / emit.tick_period).denominator != 1:
        whole = max(1, control.period // emit.tick_period)
        told = f"is {decimal(control.period)}, no whole number of ticks of {decimal(emit.tick_period)}"
        return f"control.period: {told}, at which alone integers see the time; use {decimal(whole * emit.tick_period)}"
    unknown = {
        **{f"emit.{t.key} (--package {t.key})": not t.integers for t in targets_of(emit) if t.option},
        'emit.math = "inline"': emit.math == "inline",
        'control.saturate = "scale"': task.scales_input,
        "control.e_max by component": len(set(task.e_max)) > 1,
        "control.outside": control.outside != "return",
        "repeat": task.repeat,
        'control.velocity = "differences"': task.uses_differences,
    }
    field = next((name for name, given in unknown.items() if given), None)
    return None if field is None else f'{field}: is for floating point; leave it out with emit.scalar = "fixed"'


def _plant_problem(task: TaskTables) -> str | None:
    """Bounds of a sign that bounds nothing, or that contradict each other."""
    for name in PLANT_BOUNDS:
        value = getattr(task.plant, name)
        positive = name in ("g_min", "g_max")
        for i, entry in enumerate(value if isinstance(value, tuple) else () if value is None else (value,)):
            if entry < 0 or (positive and not entry):
                field = f"plant.{name}[{i}]" if isinstance(value, tuple) else f"plant.{name}"
                return f"{field}: is {decimal(entry)}; it must be {'greater than 0' if positive else '0 or greater'}"
    if task.plant.g_min is not None and task.plant.g_max is not None:
        for i, b in enumerate(task.plant_bounds):
            if b.g_min > b.g_max:
                told = [f"[{i}]" if isinstance(v, tuple) else "" for v in (task.plant.g_min, task.plant.g_max)]
                return f"plant.g_min{told[0]}: is {decimal(b.g_min)}, above plant.g_max{told[1]} = {decimal(b.g_max)}"
    return None


def _order_problem(task: TaskTables) -> str | None:
    """What is for plants of order 2 alone, and what is not for them."""
    filter_, speed = task.tube.filter, task.initial_set.speed
    if task.order == 1:
        given: dict[str, object] = {"tube.filter": filter_, "initial_set.speed": speed, "plant.noise_v": task.plant.noise_v}
        given |= {
            "control.velocity": "differences" if task.uses_differences else None,
            "control.period_min": task.control.period_min,
        }
        field = next((name for name, value in given.items() if value is not None), None)
        return None if field is None else f"{field}: is for plants of order 2; set plant.order = 2, or leave it out"
    if not task.tube.capabilities.drives_order_two:
        return f"plant.order: is 2, which the {task.tube.design} design does not know; use the refined design"
    for name, value, least in (("tube.filter", filter_, "greater than 0"), ("initial_set.speed", speed, "0 or greater")):
        entries = () if value is None or isinstance(value, str) else value if isinstance(value, tuple) else (value,)
        for i, entry in enumerate(entries):
            if entry < 0 or (not entry and name == "tube.filter"):
                return f"{name}{f'[{i}]' if isinstance(value, tuple) else ''}: is {decimal(entry)}; it must be {least}"
    return _velocity_problem(task)


def _velocity_problem(task: TaskTables) -> str | None:
    """What differences of x need to be a velocity with a known error."""
    control = task.control
    if not task.uses_differences:
        told = "is for a velocity by differences; leave it out, or set control.velocity"
        return f"control.period_min: {told}" if control.period_min is not None else None
    for name, why in (("period", "over what time a difference is taken"), ("u_max", "how far the velocity turns in it")):
        if getattr(control, name) is None:
            return f'control.{name}: is missing; with control.velocity = "differences" it must be known {why}'
    if control.period_min is not None and control.period_min > task.sampling_period:
        told = f"is {decimal(control.period_min)}, above control.period = {decimal(task.sampling_period)}"
        return f"control.period_min: {told}; use that or less"
    tick = task.emit.tick_period
    if tick is not None and tick < task.shortest_period:
        told = f"is {decimal(tick)}, below control.period_min = {decimal(task.shortest_period)}"
        return f"emit.tick_period: {told}, which a velocity by differences needs between samples; raise it, or lower that"
    if task.plant.noise_v is not None:
        return "plant.noise_v: is of a velocity that is measured, and here it is of differences; leave it out"
    if any(task.start_speed):
        return "initial_set.speed: is not known from one sample; with a velocity by differences starts are at rest, leave it out"
    return None


def _scale_problem(task: TaskTables) -> str | None:
    """Why u cannot be limited by one factor; what is shown of that is about norms, in continuous time."""
    control = task.control
    if control.u_max is None:
        return "which limits u by control.u_max; give it, or leave saturate out"
    if len(set(task.u_max or ())) > 1 or len(set(task.gain)) > 1:
        return "for which control.u_max and control.gain must be one number each"
    if control.period is not None:
        return 'of which nothing is shown for a sampled law; leave control.period out, or use "clip"'
    if not task.tube.capabilities.scales_input or task.order == 2:
        return 'which is for the refined design and plants of order 1; use "clip"'
    if any(isinstance(v, tuple) for v in task.plant.bounds.values()):
        return "which is shown with norms of f, w and g; state plant bounds as one number each"
    return None


def _outside_problem(task: TaskTables) -> str | None:
    """Why the tube cannot do that once it is left."""
    kind = task.control.outside
    if kind == "return":
        return None
    if not task.tube.capabilities.waits_outside:
        return f'which the {task.tube.design} design does not know; use "return" or the refined design'
    if kind == "stop":
        return None
    timed = next((j for j, s in enumerate(task.unsafe) if s.is_timed), None)
    if timed is not None or task.has_moving_target:
        field = "target_set" if timed is None else f"unsafe[{timed}]"
        return f'but {field} does not wait for a tube that stands; use "return" or "stop"'
    if task.mission:
        return 'but the times of the mission do not wait for a tube that stands; use "return" or "stop"'
    if task.order == 2:
        return 'but with inertia a tube that moves cannot stand at once; use "return" or "stop"'
    return None


def _limits_problem(task: TaskTables) -> str | None:
    tube, offered = task.tube, task.tube.capabilities
    for name in ("max_speed", "max_acceleration"):
        given = getattr(tube, name)
        for i, bound in enumerate(given if isinstance(given, tuple) else () if given is None else (given,)):
            if bound <= 0:
                field = f"tube.{name}[{i}]" if isinstance(given, tuple) else f"tube.{name}"
                return f"{field}: is {decimal(bound)}; it must be greater than 0, or left out for no bound"
    if not offered.bounds_acceleration and tube.max_acceleration is not None:
        return f"tube.max_acceleration: the edges of the {tube.design} design have kinks; use the refined design, or leave it out"
    shaped = next((j for j, s in enumerate(task.unsafe) if not isinstance(s, UnsafeSet)), None)
    if not offered.avoids_any_shape and (task.space_cuts or task.target_cuts):
        field = "state_space" if task.space_cuts else "target_set"
        return f"{field}: is no box; the {tube.design} design knows boxes alone, use the refined design"
    if not offered.avoids_any_shape and shaped is not None:
        return f"unsafe[{shaped}]: is no box; the {tube.design} design avoids boxes alone, use the refined design"
    timed = next((j for j, s in enumerate(task.unsafe) if s.is_timed), None)
    if not offered.follows_moving_sets and (timed is not None or task.has_moving_target):
        field = "target_set" if timed is None else f"unsafe[{timed}]"
        return f"{field}: is not always the same; the {tube.design} design knows standing sets alone, use the refined design"
    if not offered.offers_widths and tube.prefer != "balanced":
        return f"tube.prefer: is for the refined design; the {tube.design} design has no widths to choose from; leave it out"
    return None


def _control_problem(task: TaskTables) -> str | None:
    control = task.control

    def named(field: str, i: int) -> str:
        return f"control.{field}[{i}]" if isinstance(getattr(control, field), tuple) else f"control.{field}"

    for i, k in enumerate(task.gain):
        if k == 0:
            return f"{named('gain', i)}: is 0; use a positive gain, or a negative one where g_s is negative definite"
        if (k > 0) != (task.gain[0] > 0):
            return f"{named('gain', i)}: is {decimal(k)}; all gains must have one sign, that of g_s"
    for i, clamp in enumerate(task.e_max):
        if not 0 < clamp < 1:
            return f"{named('e_max', i)}: is {decimal(clamp)}; it must lie strictly between 0 and 1, for example 0.99"
    for i, bound in enumerate(task.u_max or ()):
        if bound <= 0:
            return f"{named('u_max', i)}: is {decimal(bound)}; it must be greater than 0"
    share, most, tick = task.initial_set.share, min(task.e_max), task.emit.tick_period
    if control.period is not None and share >= most:
        told = f"not below control.e_max = {decimal(most)}, where the law is clamped"
        return f"initial_set.share: is {decimal(share)}, {told}; lower the share or raise e_max"
    if control.period is not None and tick is not None and tick > control.period:
        return f"emit.tick_period: is {decimal(tick)}, above control.period = {decimal(control.period)}; use that or less"
    if control.saturate == "scale" and (problem := _scale_problem(task)):
        return f'control.saturate: is "scale", {problem}'
    if problem := _outside_problem(task):
        return f'control.outside: is "{control.outside}", {problem}'
    if control.gain == "auto" and control.period is None:
        return 'control.gain: is "auto", which needs control.period; give the seconds between samples, or a number'
    return None


def _containment_problem(task: TaskTables, n: int) -> str | None:
    space, body = task.free_space, " less the body" if task.body and any(task.body) else ""
    for i in range(n):
        if space.lower[i] >= space.upper[i]:
            return f"body[{i}]: the body does not fit into the state space; make it smaller"
    target = task.target_set
    boxes: list[tuple[str, Region, BoxSet]] = [("state_space", task.state_space, task.state_space.convex())]
    if target is not None:
        boxes.append(("target_set", target, task.target_at_rest))
    for field, region, box in boxes:
        own, cuts = task.axis_indices(region), tuple(region.half_spaces())
        left = corners_of_cut_box(*(tuple(edges[i] for i in own) for edges in (box.lower, box.upper)), cuts) if cuts else None
        if left is not None and (not left or affine_dimension(left) < len(own)):
            told = region.points[0]
            if told == "centre":
                return f"{field}: the ball about its centre leaves nothing of the box with an interior; move one of them"
            return f"{field}: its {told} leave nothing of the box with an interior; turn the signs or move them"
    for field, box in (("initial_set", task.start), ("target_set", task.target)):
        for i in range(n):
            for edge, sign, most in (("lower", -1, "at least"), ("upper", 1, "at most")):
                end, limit = getattr(box, edge)[i], getattr(space, edge)[i]
                if sign * end > sign * limit:
                    round_ = field == "target_set" and target is not None and target.centre is not None and not target.lower
                    what = f"its ball, to {decimal(end)} in {task.axis_words[i]}," if round_ else f"{edge}[{i}] = {decimal(end)}"
                    if field == "target_set" and task.has_moving_target:
                        by = task.target_course.displacement(task.prescribed_time)[i]
                        told = (
                            f"use {most} {decimal(limit - by)} here, or a motion that ends by {most} {decimal(limit - end + by)}"
                        )
                        return f"{field}: displaced by {decimal(by)} at t_c, {what} lies outside the state space{body}; {told}"
                    return f"{field}: {what} lies outside the state space{body}; use {most} {decimal(limit)}"
    for normal, offset in task.space_cuts:
        if task.start.support(normal) > offset:
            return f"initial_set: lies outside the state space{body}, where {_half_space(task, normal, offset)}"
    for i, x in enumerate(task.initial_state):
        a, b = task.initial_set.lower[i], task.initial_set.upper[i]
        if not a < x < b:
            return (
                f"initial_state[{i}]: {decimal(x)} is not strictly inside the initial set; "
                f"use a value between {decimal(a)} and {decimal(b)}"
            )
    return None


def _may(course: Course) -> str:
    """How sure it is where a set is."""
    doubt = [
        name for name, value in (("timing", course.clock_lag), ("start_delay", course.clock_lead - course.clock_lag)) if value
    ]
    doubt += ["spread"] if course.spread else []
    return f"may be (with its {' and '.join(doubt)})" if doubt else "is"


def _half_space(task: TaskTables, normal: Normal, offset: Fraction) -> str:
    """As a formula."""
    text = ""
    for c, name in zip(normal, task.axis_names, strict=True):
        if c:
            sign = ("-" if c < 0 else "") if not text else (" - " if c < 0 else " + ")
            text += sign + (name if abs(c) == 1 else f"{abs(c)} {name}")
    return f"{text} <= {decimal(offset)}"


def unsafe_problem(task: TaskTables) -> str | None:
    """Names that are taken, and unsafe sets where the start or the target is."""
    seen: dict[str, int] = {}
    for j, unsafe in enumerate(task.unsafe):
        name = unsafe.name or f"U{j + 1}"
        if name in seen:
            return f"unsafe[{j}].name: {name!r} is already the name of unsafe[{seen[name]}]; names must differ"
        seen[name] = j
        try:
            unsafe.to_set_in(task.state_space, task.axis_indices(unsafe))
        except ValueError as error:
            return f"{task.unsafe_field(j)}.{error}"
    start, target, body = task.start, task.target, any(task.half_extents)
    for j, (grown, course) in enumerate(zip(task.obstacles, task.courses, strict=True)):
        label = task.unsafe_field(j) + (f" ({grown.name})" if grown.name else "") + (" grown by the body" if body else "")
        first, last = (possible_sets(grown, course, at) for at in (Fraction(0), task.prescribed_time))
        if any(not place.is_apart_from(start.lower, start.upper) for place in first):
            when = "" if course is None or not course.is_moving else f" where it {_may(course)} at t = 0"
            return f"initial_set: meets {label}{when}; move or shrink one of them"
        if task.target_set is not None and any(place.covers(target.lower, target.upper) for place in last):
            closes = course is not None and course.active_interval is not None and course.active_interval[1] < course.t_c
            when = (
                ""
                if course is None
                else f", which {_may(course)} unsafe at t_c"
                if closes
                else f" where it {_may(course)} at t_c"
            )
            return f"target_set: lies inside {label}{when}; move or shrink one of them"
    return None
