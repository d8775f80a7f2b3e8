"""Checks that no schema can make: how the fields of a task must fit together.

Each check returns the message of the first field that is wrong, or None. `Task` calls `first_problem` when it is made.

Long because every message stands where its check is.
"""

from __future__ import annotations

from collections.abc import Sized
from fractions import Fraction

from stt_codegen.decimals import decimal
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.program.targets import targets_of
from stt_codegen.task.added_names import ADDED_NAMES
from stt_codegen.task.checks.mission_checks import mission_problem
from stt_codegen.task.checks.schema_messages import ONE_SIGN_REMEDY
from stt_codegen.task.checks.set_checks import axes_problem, entries_problem, motion_problem, set_problem
from stt_codegen.task.input_norm import shares_of_norm
from stt_codegen.task.schema import DRIVE_BOUNDS, PLANT_BOUNDS, TaskTables
from stt_codegen.task.sets import (
    Box,
    BoxSet,
    Course,
    Normal,
    Region,
    TomlTable,
    UnsafeSet,
    affine_dimension,
    corners_of_cut_box,
    possible_sets,
)
from stt_codegen.task.values import ADD_IT

DEVICES = frozenset(["con", "prn", "aux", "nul", *(f"{port}{k}" for port in ("com", "lpt") for k in range(10))])  # of Windows


def first_problem(task: TaskTables) -> str | None:
    """Return the message of the first check that fails, or None."""
    n = task.dimension
    return (
        structure_problem(task)
        or mission_problem(task)
        or _options_problem(task)
        or _language_problem(task)
        or _containment_problem(task, n)
        or unsafe_problem(task)
    )


def structure_problem(task: TaskTables) -> str | None:
    """Return a message where a name is reserved or a list has a wrong number of entries, else None."""
    return _name_problem(task) or _shape_problem(task, task.dimension)


def _name_problem(task: TaskTables) -> str | None:
    """Return a message where the task's name is a word, a file or a device that its files would hide or meet, else None."""
    name = task.name
    if name.lower() in DEVICES:
        return f"name: {name!r} is a device of Windows, where no file {name}.c can be; choose another"
    for target in targets_of(task.emit):
        option = f" (emit.{target.key})" if target.option else ""
        if name in target.words:
            return f"name: {name!r} is {target.words_are}{option}; choose another"
        if name.lower() in target.library:
            return f"name: {name!r} would shadow a part of the standard library of {target.title}{option}; choose another"
    return None


def _language_problem(task: TaskTables) -> str | None:
    """Return a message where the task owes a function that a language of it does not have, else None."""
    for target in targets_of(task.emit):
        for name, added in ADDED_NAMES.items():
            if name in target.lacks and not added.is_constant and added.applies_to(task):
                return f"emit.{target.key}: {target.title} has no `{name}`, which {added.option} needs; leave one of them out"
    return None


def _boxes_of(task: TaskTables) -> list[tuple[str, Box]]:
    """Return the tables that have a box, by field name."""
    boxes: list[tuple[str, Box]] = [("state_space", task.state_space), ("initial_set", task.initial_set)]
    return boxes if task.target_set is None else [*boxes, ("target_set", task.target_set)]


def _full_length_fields(task: TaskTables) -> list[tuple[str, Sized]]:
    """Return every list of the task that must have one entry for each dimension, by field name."""
    fields: list[tuple[str, Sized]] = [("initial_state", task.initial_state)]
    fields += [(f"{field}.{name}", vector) for field, table in _boxes_of(task) for name, vector in table.vectors()]
    if task.body is not None:
        fields.append(("body", task.body))
    options: tuple[tuple[str, TomlTable, tuple[str, ...]], ...] = (
        ("control", task.control, ("gain", "e_max", "u_max")),
        ("tube", task.tube, ("clearance", "min_width", "max_speed", "max_acceleration", "filter")),
        ("plant", task.plant, (*PLANT_BOUNDS, *DRIVE_BOUNDS, "noise", "noise_v")),
        ("initial_set", task.initial_set, ("speed",)),
    )
    for title, table, names in options:
        fields += [(f"{title}.{name}", value) for name in names if isinstance(value := getattr(table, name), tuple)]
    return [*fields, *((name, value) for name in ("axes", "units") if (value := getattr(task, name)) is not None)]


def _shape_problem(task: TaskTables, n: int) -> str | None:
    """Return a message where a vector has another number of entries than its set or the task, or a table is no set, else None."""
    target = task.target_set
    if target is None and not task.mission:
        return f"target_set: is missing; {ADD_IT}"
    for field, vector in _full_length_fields(task):
        if len(vector) != n:
            return f"{field}: has {len(vector)} entries; state_space.lower has {n}, and all must agree"
    regions: list[tuple[str, Region]] = [("state_space", task.state_space)]
    if target is not None:
        regions.append(("target_set", target))
    for field, region in regions:
        problem = axes_problem(task, region.axes) or entries_problem(task, region.axes, *region.points)
        if problem:
            return f"{field}.{problem}"
    if target is not None and (problem := motion_problem(task, target)):
        return f"target_set.{problem}"
    for field, table in _boxes_of(task):
        if problem := table.problem():
            return f"{field}{'.' if _names_a_field(problem) else ': '}{problem}"
    return next(
        (f"unsafe[{j}].{problem}" for j, unsafe in enumerate(task.unsafe) if (problem := set_problem(task, unsafe))), None
    )


def _names_a_field(problem: str) -> bool:
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
    """Return a message where an option is out of range or does not fit to the others, else None."""
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
    """Return a message where a controller in integers lacks a field or has no form of an option, else None."""
    emit, control = task.emit, task.control
    if emit.scalar != "fixed":
        return None
    if not task.tube.capabilities.has_integer_form:
        kinds = kinds_offering("has_integer_form")
        return f'emit.scalar: "fixed" is for {kinds} tubes; tube.design = "{task.tube.design}" takes "float" or "double"'
    if emit.tick_period is None:
        return 'emit.tick_period: is missing; with emit.scalar = "fixed" time is a count of ticks, say how many seconds one is'
    if task.u_max is None and not task.has_automatic_limit:
        return 'control.u_max: is missing; with emit.scalar = "fixed" u counts parts of it, so say how large it may be'
    if control.period is not None and (control.period / emit.tick_period).denominator != 1:
        ticks = max(1, control.period // emit.tick_period)
        problem = f"is {decimal(control.period)}, no whole number of ticks of {decimal(emit.tick_period)}"
        return f"control.period: {problem}, at which alone integers see the time; use {decimal(ticks * emit.tick_period)}"
    unsupported = {
        **{f"emit.{t.key} (--package {t.key})": not t.integers for t in targets_of(emit) if t.option},
        'emit.math = "inline"': emit.math == "inline",
        'control.saturate = "scale"': task.scales_input,
        "control.e_max by component": len(set(task.e_max)) > 1,
        "control.outside": control.outside != "return",
        "repeat": task.repeat,
        'control.velocity = "differences"': task.uses_differences,
    }
    field = next((name for name, is_set in unsupported.items() if is_set), None)
    return None if field is None else f'{field}: is for floating point; leave it out with emit.scalar = "fixed"'


def _plant_problem(task: TaskTables) -> str | None:
    """Return a message where a plant bound has a wrong sign or contradicts another, else None."""
    stated = [name for name in PLANT_BOUNDS if getattr(task.plant, name) is not None]
    if task.plant.exact and stated:
        return f"plant.exact: is true, so f = w = 0 and g = 1; leave plant.{stated[0]} out, or exact"
    for name in PLANT_BOUNDS:
        value = getattr(task.plant, name)
        positive = name in ("g_min", "g_max")
        for i, entry in enumerate(value if isinstance(value, tuple) else () if value is None else (value,)):
            if entry < 0 or (positive and not entry):
                field = f"plant.{name}[{i}]" if isinstance(value, tuple) else f"plant.{name}"
                return f"{field}: is {decimal(entry)}; it must be {'greater than 0' if positive else '0 or greater'}"
    if problem := _drive_problem(task):
        return problem
    if task.plant.g_min is not None and task.plant.g_max is not None:
        for i, b in enumerate(task.plant_bounds):
            if b.g_min > b.g_max:
                low, high = (f"[{i}]" if isinstance(v, tuple) else "" for v in (task.plant.g_min, task.plant.g_max))
                return f"plant.g_min{low}: is {decimal(b.g_min)}, above plant.g_max{high} = {decimal(b.g_max)}"
    return None


def _drive_problem(task: TaskTables) -> str | None:
    """Return a message where a bound on a drive is out of range, or lacks what its proof needs, else None."""
    for name in DRIVE_BOUNDS:
        value = getattr(task.plant, name)
        for i, entry in enumerate(value if isinstance(value, tuple) else () if value is None else (value,)):
            field = f"plant.{name}[{i}]" if isinstance(value, tuple) else f"plant.{name}"
            if entry < 0 or (name == "slew" and not entry):
                return f"{field}: is {decimal(entry)}; it must be {'greater than 0' if name == 'slew' else '0 or greater'}"
            if name == "overshoot" and entry >= 1:
                return f"{field}: is {decimal(entry)}; it must be less than 1, a share of a step"
        if value is None:
            continue
        if task.control.period is None:
            return f"control.period: is missing; with plant.{name} a proof needs the time between samples"
    return None


def _order_problem(task: TaskTables) -> str | None:
    """Return a message where an option does not fit to the order of the plant, else None."""
    filter_, speed = task.tube.filter, task.initial_set.speed
    if task.order == 1:
        for_order_two: dict[str, object] = {
            "tube.filter": filter_,
            "initial_set.speed": speed,
            "plant.noise_v": task.plant.noise_v,
            "control.velocity": "differences" if task.uses_differences else None,
            "control.period_min": task.control.period_min,
        }
        field = next((name for name, value in for_order_two.items() if value is not None), None)
        return None if field is None else f"{field}: is for plants of order 2; set plant.order = 2, or leave it out"
    if not task.tube.capabilities.drives_order_two:
        kinds = kinds_offering("drives_order_two")
        return f"plant.order: is 2, which the {task.tube.design} design does not know; use the {kinds} design"
    for name, value, allowed in (("tube.filter", filter_, "greater than 0"), ("initial_set.speed", speed, "0 or greater")):
        entries = () if value is None or isinstance(value, str) else value if isinstance(value, tuple) else (value,)
        for i, entry in enumerate(entries):
            if entry < 0 or (not entry and name == "tube.filter"):
                return f"{name}{f'[{i}]' if isinstance(value, tuple) else ''}: is {decimal(entry)}; it must be {allowed}"
    return _velocity_problem(task)


def _velocity_problem(task: TaskTables) -> str | None:
    """Return a message where a velocity by differences of x would have no known error, else None."""
    control = task.control
    if not task.uses_differences:
        problem = "is for a velocity by differences; leave it out, or set control.velocity"
        return f"control.period_min: {problem}" if control.period_min is not None else None
    if control.period is None:
        why = "it must be known over what time a difference is taken"
        return f'control.period: is missing; with control.velocity = "differences" {why}'
    if control.period_min is not None and control.period_min > task.sampling_period:
        problem = f"is {decimal(control.period_min)}, above control.period = {decimal(task.sampling_period)}"
        return f"control.period_min: {problem}; use that or less"
    tick = task.emit.tick_period
    if tick is not None and tick < task.shortest_period:
        problem = f"is {decimal(tick)}, below control.period_min = {decimal(task.shortest_period)}"
        return f"emit.tick_period: {problem}, which a velocity by differences needs between samples; raise it, or lower that"
    if task.plant.noise_v is not None:
        return "plant.noise_v: is of a velocity that is measured, and here it is of differences; leave it out"
    if any(task.start_speed):
        return "initial_set.speed: is not known from one sample; with a velocity by differences starts are at rest, leave it out"
    return None


def _scale_problem(task: TaskTables) -> str | None:
    """Return why one factor cannot limit u, or None. The proof for such a factor is about norms, in continuous time."""
    control = task.control
    if control.u_max is None:
        return "which limits u by control.u_max; give it, or leave saturate out"
    if control.period is not None:
        return 'of which nothing is shown for a sampled law; leave control.period out, or use "clip"'
    if len(set(task.u_max or ())) > 1 or len(set(task.gain)) > 1:
        return "for which control.u_max and control.gain must be one number each"
    if not task.tube.capabilities.scales_input or task.order == 2:
        return f'which is for the {kinds_offering("scales_input")} design and plants of order 1; use "clip"'
    if any(isinstance(v, tuple) for v in task.plant.bounds.values()):
        return "which is shown with norms of f, w and g; state plant bounds as one number each"
    return None


def _norm_problem(task: TaskTables, norm: Fraction) -> str | None:
    """Return why the norm of u cannot be limited by components, or None."""
    if not task.tube.capabilities.shares_norm:
        kinds = kinds_offering("shares_norm")
        return f"is for {kinds} tubes, for which each component's share is known; give control.u_max by component"
    if task.control.saturate == "scale":
        equal_limit = shares_of_norm((Fraction(0),) * task.dimension, norm)[0]
        return (
            'gives each component its own limit, and saturate = "scale" has one limit for all; leave u_norm out and give '
            f"control.u_max = {decimal(equal_limit)}, which keeps |u| within {decimal(norm)}"
        )
    return None


def _outside_problem(task: TaskTables) -> str | None:
    """Return why control.outside cannot be carried out once x is outside the tube, or None."""
    kind = task.control.outside
    if kind == "return":
        return None
    if not task.tube.capabilities.waits_outside:
        kinds = kinds_offering("waits_outside")
        return f'which the {task.tube.design} design does not know; use "return" or the {kinds} design'
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
    """Return a message where a bound on the edges is not positive, or the kind of tube does not offer what is set, else None."""
    tube, offered = task.tube, task.tube.capabilities
    for name in ("max_speed", "max_acceleration"):
        value = getattr(tube, name)
        for i, bound in enumerate(value if isinstance(value, tuple) else () if value is None else (value,)):
            if bound <= 0:
                field = f"tube.{name}[{i}]" if isinstance(value, tuple) else f"tube.{name}"
                return f"{field}: is {decimal(bound)}; it must be greater than 0, or left out for no bound"
    if not offered.bounds_acceleration and tube.max_acceleration is not None:
        remedy = f"use the {kinds_offering('bounds_acceleration')} design, or leave it out"
        return f"tube.max_acceleration: the edges of the {tube.design} design have kinks; {remedy}"
    not_a_box = next((j for j, s in enumerate(task.unsafe) if not isinstance(s, UnsafeSet)), None)
    remedy = f"use the {kinds_offering('avoids_any_shape')} design"
    if not offered.avoids_any_shape and (task.space_cuts or task.target_cuts):
        field = "state_space" if task.space_cuts else "target_set"
        return f"{field}: is no box; the {tube.design} design knows boxes alone, {remedy}"
    if not offered.avoids_any_shape and not_a_box is not None:
        return f"unsafe[{not_a_box}]: is no box; the {tube.design} design avoids boxes alone, {remedy}"
    timed = next((j for j, s in enumerate(task.unsafe) if s.is_timed), None)
    if not offered.follows_moving_sets and (timed is not None or task.has_moving_target):
        field = "target_set" if timed is None else f"unsafe[{timed}]"
        remedy = f"use the {kinds_offering('follows_moving_sets')} design"
        return f"{field}: is not always the same; the {tube.design} design knows standing sets alone, {remedy}"
    if not offered.offers_widths and tube.prefer != "balanced":
        kinds = kinds_offering("offers_widths")
        return f"tube.prefer: is for the {kinds} design; the {tube.design} design has no widths to choose from; leave it out"
    return None


def _control_problem(task: TaskTables) -> str | None:
    """Return a message where an option of the control law is out of range or does not fit to the others, else None."""
    control = task.control

    def entry(field: str, i: int) -> str:
        return f"control.{field}[{i}]" if isinstance(getattr(control, field), tuple) else f"control.{field}"

    for i, k in enumerate(task.gain):
        if k == 0:
            return f"{entry('gain', i)}: is 0; use a positive gain, or a negative one where g_s is negative definite"
        if (k > 0) != (task.gain[0] > 0):
            return f"{entry('gain', i)}: is {decimal(k)}; all gains must have one sign, that of g_s"
    for i, clamp in enumerate(task.e_max):
        if not 0 < clamp < 1:
            return f"{entry('e_max', i)}: is {decimal(clamp)}; it must lie strictly between 0 and 1, for example 0.99"
    for i, bound in enumerate(task.stated_u_max or ()):
        if bound <= 0:
            return f"{entry('u_max', i)}: is {decimal(bound)}; it must be greater than 0: {ONE_SIGN_REMEDY}"
    share, clamp, tick = task.initial_set.share, min(task.e_max), task.emit.tick_period
    if control.period is not None and share >= clamp:
        reason = f"not below control.e_max = {decimal(clamp)}, where the law is clamped"
        return f"initial_set.share: is {decimal(share)}, {reason}; lower the share or raise e_max"
    if control.period is not None and tick is not None and tick > control.period:
        return f"emit.tick_period: is {decimal(tick)}, above control.period = {decimal(control.period)}; use that or less"
    if control.u_norm is not None and (problem := _norm_problem(task, control.u_norm)):
        return f"control.u_norm: {problem}"
    if control.saturate == "scale" and (problem := _scale_problem(task)):
        return f'control.saturate: is "scale", {problem}'
    if problem := _outside_problem(task):
        return f'control.outside: is "{control.outside}", {problem}'
    return _choice_problem(task)


def _choice_problem(task: TaskTables) -> str | None:
    """Return a message where a gain or a limit is to be chosen and cannot be, or where an option of that choice has no use."""
    control = task.control
    if control.period is None:
        for name in ("gain", "u_max"):
            is_bounded = name == "u_max" and control.u_norm is not None
            if isinstance(rule := getattr(control, name), str) and not is_bounded:
                return f'control.{name}: is "{rule}", which needs control.period; give the seconds between samples, or a number'
    is_gentle = task.has_automatic_gain and control.gain != "tight"
    chooses_limit = task.has_automatic_limit and task.stated_u_max is None and control.period is not None
    for name, is_read, rules in (
        ("rest", is_gentle, 'control.gain is "auto"'),
        ("reserve", is_gentle or chooses_limit, 'control.gain or control.u_max is "auto"'),
    ):
        if getattr(control, name) is not None and not is_read:
            return f"control.{name}: is read where {rules}; leave it out, or let the tool choose"
    return None


def _containment_problem(task: TaskTables, n: int) -> str | None:
    """Return a message where the body, the start, the target or the initial state lies outside of its set, else None."""
    space, less_body = task.free_space, " less the body" if task.body and any(task.body) else ""
    for i in range(n):
        if space.lower[i] >= space.upper[i]:
            return f"body[{i}]: the body does not fit into the state space; make it smaller"
    if problem := _empty_cut_problem(task):
        return problem
    for field, box in (("initial_set", task.start), ("target_set", task.target)):
        for i in range(n):
            for edge in ("lower", "upper"):
                if problem := _outside_space_problem(task, field, box, i, edge):
                    return problem
    for normal, offset in task.space_cuts:
        if task.start.support(normal) > offset:
            return f"initial_set: lies outside the state space{less_body}, where {_half_space(task, normal, offset)}"
    for i, x in enumerate(task.initial_state):
        a, b = task.initial_set.lower[i], task.initial_set.upper[i]
        if not a < x < b:
            return (
                f"initial_state[{i}]: {decimal(x)} is not strictly inside the initial set; "
                f"use a value between {decimal(a)} and {decimal(b)}"
            )
    return None


def _empty_cut_problem(task: TaskTables) -> str | None:
    """Return a message where the cuts of the state space or target leave no interior of their box, else None."""
    boxes: list[tuple[str, Region, BoxSet]] = [("state_space", task.state_space, task.state_space.convex())]
    if task.target_set is not None:
        boxes.append(("target_set", task.target_set, task.target_at_rest))
    for field, region, box in boxes:
        axes, cuts = task.axis_indices(region), tuple(region.half_spaces())
        edges = (tuple(edge[i] for i in axes) for edge in (box.lower, box.upper))
        corners = corners_of_cut_box(*edges, cuts) if cuts else None
        if corners is not None and (not corners or affine_dimension(corners) < len(axes)):
            cut_field = region.points[0]
            if cut_field == "centre":
                return f"{field}: the ball about its centre leaves nothing of the box with an interior; move one of them"
            return f"{field}: its {cut_field} leave nothing of the box with an interior; turn the signs or move them"
    return None


def _outside_space_problem(task: TaskTables, field: str, box: BoxSet, i: int, edge: str) -> str | None:
    """Return a message where an edge ("lower" or "upper") of a field's box lies outside the state space, else None."""
    sign, bound = (-1, "at least") if edge == "lower" else (1, "at most")
    end, limit, target = getattr(box, edge)[i], getattr(task.free_space, edge)[i], task.target_set
    if sign * end <= sign * limit:
        return None
    space = f"the state space{' less the body' if task.body and any(task.body) else ''}"
    is_ball = field == "target_set" and target is not None and target.centre is not None and not target.lower
    part = f"its ball, to {decimal(end)} in {task.axis_words[i]}," if is_ball else f"{edge}[{i}] = {decimal(end)}"
    if field == "target_set" and task.has_moving_target:
        by = task.target_course.displacement(task.prescribed_time)[i]
        remedy = f"use {bound} {decimal(limit - by)} here, or a motion that ends by {bound} {decimal(limit - end + by)}"
        return f"{field}: displaced by {decimal(by)} at t_c, {part} lies outside {space}; {remedy}"
    return f"{field}: {part} lies outside {space}; use {bound} {decimal(limit)}"


def _is_or_may_be(course: Course) -> str:
    """Return "is", or "may be" with the fields that make the place of a set uncertain."""
    fields = [
        name for name, value in (("timing", course.clock_lag), ("start_delay", course.clock_lead - course.clock_lag)) if value
    ]
    fields += ["spread"] if course.spread else []
    return f"may be (with its {' and '.join(fields)})" if fields else "is"


def _half_space(task: TaskTables, normal: Normal, offset: Fraction) -> str:
    """Return a half-space as an inequality in the names of the axes."""
    text = ""
    for c, name in zip(normal, task.axis_names, strict=True):
        if c:
            sign = ("-" if c < 0 else "") if not text else (" - " if c < 0 else " + ")
            text += sign + (name if abs(c) == 1 else f"{abs(c)} {name}")
    return f"{text} <= {decimal(offset)}"


def unsafe_problem(task: TaskTables) -> str | None:
    """Return a message where two sets have one name, or a set is empty, meets the start or holds the target, else None."""
    indices: dict[str, int] = {}
    for j, unsafe in enumerate(task.unsafe):
        name = unsafe.name or f"U{j + 1}"
        if name in indices:
            return f"unsafe[{j}].name: {name!r} is already the name of unsafe[{indices[name]}]; names must differ"
        indices[name] = j
        try:
            unsafe.to_set_in(task.state_space, task.axis_indices(unsafe))
        except ValueError as error:
            return f"{task.unsafe_field(j)}.{error}"
    start, target, body = task.start, task.target, any(task.half_extents)
    for j, (grown, course) in enumerate(zip(task.obstacles, task.courses, strict=True)):
        label = task.unsafe_field(j) + (f" ({grown.name})" if grown.name else "") + (" grown by the body" if body else "")
        first, last = (possible_sets(grown, course, at) for at in (Fraction(0), task.prescribed_time))
        if any(not convex.is_apart_from(start.lower, start.upper) for convex in first):
            when = "" if course is None or not course.is_moving else f" where it {_is_or_may_be(course)} at t = 0"
            return f"initial_set: meets {label}{when}; move or shrink one of them"
        if task.target_set is not None and any(convex.covers(target.lower, target.upper) for convex in last):
            closes = course is not None and course.active_interval is not None and course.active_interval[1] < course.t_c
            when = (
                ""
                if course is None
                else f", which {_is_or_may_be(course)} unsafe at t_c"
                if closes
                else f" where it {_is_or_may_be(course)} at t_c"
            )
            return f"target_set: lies inside {label}{when}; move or shrink one of them"
    return None
