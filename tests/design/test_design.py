"""The design: what it promises holds for tasks it has never seen, and what is infeasible is refused with the reason."""

from __future__ import annotations

import itertools
import re
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.suites.families import FAMILIES, arena_task, cubes, feasible
from stt_codegen.design.arena import Arena, arena_of, starting_box
from stt_codegen.design.half_spaces import Array
from stt_codegen.design.refine import refine
from stt_codegen.design.routes.cell_path import find_cell_path
from stt_codegen.design.routes.corner_search import centre_problem_of, search_corners
from stt_codegen.design.routes.shortest_route import find_corner_route, shortest_route
from stt_codegen.design.routes.sides import _common_changes
from stt_codegen.design.spline_tubes.widest import ROUTE_DETOUR_LIMIT, SPEED_FACTOR_LIMIT
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task, design_tube
from stt_codegen.program.analyse.cost import cost_of
from stt_codegen.task.load import load_task, parse_task
from stt_codegen.task.task import Task
from tests.support.controllers import NAMES, ROOT, built, controller_of

PAPER = FAMILIES["paper"]

EMPTY = (ROOT / "tasks" / "empty.toml").read_text()


def unsafe(name: str, lower: list[float], upper: list[float]) -> str:
    return f'\n[[unsafe]]\nname = "{name}"\nlower = {lower}\nupper = {upper}\n'


@pytest.mark.parametrize("name", NAMES)
def test_every_example_task_is_certified(name: str) -> None:
    controller = controller_of(name)
    assert controller.certificate.holds
    sampled = ["P9"] if controller.task.control.period is not None else []
    mission = ["P10", "P10"] if controller.task.mission else []  # in space and in time
    assert [f.code for f in controller.certificate.findings] == [
        "P1",
        "P2",
        "P2",
        "P3",
        "P4",
        "P5",
        "P6",
        "P7",
        *sampled,
        *mission,
    ]


@pytest.mark.parametrize("seed", range(40))
def test_an_arena_is_certified_exactly_when_a_way_is_open(seed: int) -> None:
    """Open at 0.1 by an exact flood fill: certified. Closed at the clearance alone: refused."""
    task = arena_task(PAPER, seed)
    if feasible(PAPER, seed, 0.1):
        assert built(task).certificate.holds
    elif not feasible(PAPER, seed, 0.03):
        with pytest.raises(NotCertified, match="P4"):
            built(task)


@pytest.mark.parametrize("seed", [0, 7])
@pytest.mark.parametrize("family", ["dense12", "space3", "space6"])
def test_other_families_are_certified(family: str, seed: int) -> None:
    assert built(arena_task(FAMILIES[family], seed)).certificate.holds


def test_the_same_task_gives_the_same_design() -> None:
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    assert design_tube(task) == design_tube(task)


def test_float_and_double_share_one_tube_of_24_bit_coefficients() -> None:
    for name in NAMES:
        single, double = controller_of(name, "float"), controller_of(name, "double")
        assert single.design == double.design
        values = np.abs(single.design.integers())
        assert values.max() < 2**24
        assert all(float(np.float32(float(v * single.design.unit))) == v * single.design.unit for v in map(int, values.ravel()))


def test_order_of_unsafe_sets_and_dimensions_does_not_decide_feasibility() -> None:
    text = (ROOT / "tasks" / "omni_s3.toml").read_text()
    head, *sets = text.split("[[unsafe]]")
    *sets, last = sets
    last, tail = last.split("[tube]")
    for order in itertools.islice(itertools.permutations([*sets, last]), 0, 24, 7):
        shuffled = "[[unsafe]]".join([head, *order]) + "[tube]" + tail
        assert built(parse_task(shuffled)).certificate.holds


def test_moving_and_scaling_the_world_keeps_the_certificate() -> None:
    """Task coordinates times 3 plus 100: still certified, clearance and width scaled too."""
    task = load_task(ROOT / "tasks" / "omni_s1.toml")

    def moved(values):
        return tuple(3 * v + 100 for v in values)

    boxes = {
        name: getattr(task, name).model_copy(
            update={"lower": moved(getattr(task, name).lower), "upper": moved(getattr(task, name).upper)}
        )
        for name in ("state_space", "initial_set", "target_set")
    }
    sets = tuple(s.model_copy(update={"lower": moved(s.lower), "upper": moved(s.upper)}) for s in task.unsafe)
    tube = task.tube.model_copy(update={"clearance": Fraction("0.09"), "min_width": Fraction("0.15")})
    world = task.model_copy(update={**boxes, "unsafe": sets, "tube": tube, "initial_state": moved(task.initial_state)})
    assert built(world).certificate.holds


@pytest.mark.parametrize("name", ["omni_s1", "omni_s2", "spacecraft"])
def test_a_body_costs_room_and_is_respected(name: str) -> None:
    """Half extents h: certified against sets grown by h; the plain task's certificate with clearance + h agrees."""
    task = load_task(ROOT / "tasks" / f"{name}.toml")
    h = Fraction("0.05")
    n = task.dimension
    inner = {
        field: getattr(task, field).model_copy(
            update={
                "lower": tuple(max(v, s + h) for v, s in zip(getattr(task, field).lower, task.state_space.lower, strict=True)),
                "upper": tuple(min(v, s - h) for v, s in zip(getattr(task, field).upper, task.state_space.upper, strict=True)),
            }
        )
        for field in ("initial_set", "target_set")
    }
    bodied = task.model_copy(update={"body": (h,) * n, **inner})
    controller = built(bodied)
    low = controller.design.bezier()[:, :, 0].min(axis=(0, 2)) * float(controller.design.unit)
    assert all(low >= [float(v + h) for v in task.state_space.lower])
    wider = task.model_copy(update={"tube": task.tube.model_copy(update={"clearance": task.tube.clearance + h}), **inner})
    from stt_codegen.certify.exact import certify_refined

    again = certify_refined(wider, controller.design, controller.certificate.edge_error)
    assert next(f for f in again.findings if f.code == "P4").holds


def least_width(arena: Arena) -> Array:
    return np.full(arena.dimension, arena.min_width)


@pytest.mark.parametrize("seed", range(0, 40, 8))
def test_the_peak_speed_is_near_the_least_possible(seed: int) -> None:
    """Design promise: at most ROUTE_DETOUR_LIMIT times the shortest route over t_c, or SPEED_FACTOR_LIMIT times the slowest
    tube that is found; no tube is slower than the bound less what its own width gives (the centre may lag by half a width at both
    ends)."""
    task = arena_task(PAPER, seed)
    arena = arena_of(task)
    least = shortest_route(arena, starting_box(arena), least_width(arena)).length / arena.prescribed_time
    speed = float(max(built(task).certificate.speed))
    slowest = float(max(build_task(task, tube=refine(task.changed(tube={"prefer": "slow"}))).certificate.speed))
    assert least - 0.5 / arena.prescribed_time <= slowest <= speed * (1 + 1e-6)
    assert speed <= max(ROUTE_DETOUR_LIMIT[1] * least, SPEED_FACTOR_LIMIT * slowest) * (
        1 + 1e-6
    )  # the grid of the table moves an edge by 2^-23 of the size


@pytest.mark.parametrize("seed", range(3, 40, 9))
def test_no_tube_of_another_least_width_is_wider_and_no_faster(seed: int) -> None:
    """Asking for more width must not be the way to get it for nothing."""

    def measured(task: Task) -> tuple[float, float]:
        design = refine(task)
        bezier = design.bezier() * float(design.unit)
        return float((bezier[:, :, 1] - bezier[:, :, 0]).min()), float(np.abs(np.diff(bezier, axis=3)).max() * design.segments)

    task = arena_task(PAPER, seed)
    width, speed = measured(task)
    for share in (0.2, 0.4):
        with suppress(NotCertified):
            other, other_speed = measured(task.changed(tube={"min_width": share}))
            assert not (other >= 1.1 * width and other_speed <= 1.001 * speed)


def test_a_finer_cover_of_a_disc_makes_no_narrower_tube() -> None:
    """Strips within strips: what is implied by the coarse cover changes nothing for the worse."""
    widths = []
    for strips in (16, 64):
        half = [np.sqrt(0.25 - min(abs(k / strips - 0.5), abs((k + 1) / strips - 0.5)) ** 2) for k in range(strips)]
        half = [h if k not in (strips // 2, strips // 2 - 1) else 0.5 for k, h in enumerate(half)]
        text = EMPTY + "".join(
            f"\n[[unsafe]]\nlower = [{2 + k / strips!r}, {2.5 - float(h)!r}]\n"
            f"upper = [{2 + (k + 1) / strips!r}, {2.5 + float(h)!r}]\n"
            for k, h in enumerate(half)
        )
        design = refine(parse_task(text))
        bezier = design.bezier()
        widths.append(float((bezier[:, :, 1] - bezier[:, :, 0]).min() * design.unit))
    assert widths[1] >= widths[0] * (1 - 2.0**-20)  # the grid of the table


def test_a_tube_does_not_depend_on_what_was_designed_before_it() -> None:
    """The programs start from where they stood, within one task only."""
    one, other = arena_task(PAPER, 5), arena_task(PAPER, 11)
    alone = refine(one)
    refine(other)
    assert refine(one) == alone


def test_max_speed_is_kept_or_refused_with_the_time_that_would_do() -> None:
    slow = EMPTY + "\n[tube]\nmax_speed = 0.78\n"
    assert max(built(parse_task(slow)).certificate.speed) <= Fraction("0.78")
    with pytest.raises(NotCertified, match=r"speed \(P6\).*prescribed_time to (\d+\.\d+)") as caught:
        built(parse_task(EMPTY + "\n[tube]\nmax_speed = 0.5\n"))
    enough = float(str(caught.value).split("prescribed_time to ")[1].split()[0]) * 1.001
    assert built(
        parse_task(EMPTY.replace("prescribed_time = 4.0", f"prescribed_time = {enough}") + "\n[tube]\nmax_speed = 0.5\n")
    )


def test_segments_are_as_asked() -> None:
    assert built(parse_task(EMPTY + "\n[tube]\nsegments = 12\n")).design.segments == 12


@pytest.mark.parametrize(
    ("added", "words"),
    [
        (unsafe("wall", [2.0, 0.0], [2.5, 3.0]), ["P4", "no way leads", "whatever the clearance"]),
        (unsafe("wall", [2.0, 0.0], [2.5, 2.93]), ["P4", "a clearance of 0.03", "a way opens at tube.clearance = "]),
        (unsafe("wall", [2.0, 0.0], [2.5, 2.97]), ["P4", "tube of width 0.05", "tube.clearance = 0 together with tube.min_width = 0.02"]),
        ("\n[tube]\nmin_width = 1.2\n", ["P1", "initial_set", "too narrow"]),
        (unsafe("near", [0.4, 1.01], [0.6, 1.5]) + "[tube]\nmin_width = 0.99\n", ["avoid (P4) at t = 0", "near", "lower tube.clearance"]),
    ],
)  # fmt: skip
def test_an_infeasible_task_is_refused_with_the_reason(added: str, words: list[str]) -> None:
    with pytest.raises(NotCertified) as caught:
        built(parse_task(EMPTY + added))
    assert caught.value.exit_code == 3
    for word in words:
        assert word in str(caught.value)


def test_a_state_at_the_very_edge_of_the_initial_set_is_refused() -> None:
    with pytest.raises(NotCertified, match=r"start \(P2\): initial_state"):
        built(parse_task(EMPTY.replace("initial_state = [0.5, 0.5]", "initial_state = [0.5, 0.99999]")))


def test_an_unsafe_set_beside_the_start_costs_a_part_of_the_start_and_says_so() -> None:
    controller = built(parse_task(EMPTY + unsafe("near", [0.2, 1.01], [0.8, 1.6])))
    assert not controller.certificate.covers_initial_set
    assert controller.certificate.start[1][1] <= Fraction("0.98")
    assert controller_of("empty").certificate.covers_initial_set


def test_what_a_refusal_names_does() -> None:
    blocked = EMPTY + unsafe("wall", [2.0, 0.0], [2.5, 2.93])
    with pytest.raises(NotCertified) as caught:
        built(parse_task(blocked))
    named = re.findall(r"tube\.(\w+) = ([\d.]+)", str(caught.value))
    assert [option for option, _ in named] == ["clearance", "min_width"]
    assert 0.015 < float(named[0][1]) < 0.02
    for option, value in named:
        assert built(parse_task(f"{blocked}[tube]\n{option} = {value}\n")).certificate.holds


def test_a_set_that_closes_the_way_alone_is_named() -> None:
    with pytest.raises(NotCertified, match="whatever the clearance; without wall there would be one"):
        built(parse_task(EMPTY + unsafe("pillar", [1.4, 0.0], [1.6, 0.5]) + unsafe("wall", [2.0, 0.0], [2.5, 3.0])))


@pytest.mark.parametrize("target", ["[0.0, 0.0]\nupper = [1.0, 1.0]", "[0.0, 0.0]\nupper = [1.0, 2.0]"])
def test_a_task_that_need_not_move_is_certified(target: str) -> None:
    text = EMPTY.replace("[3.0, 2.0]\nupper = [4.0, 3.0]", target)
    assert text != EMPTY
    assert built(parse_task(text)).certificate.holds


@pytest.mark.parametrize("seed", [34, 98, 108])
def test_a_wide_tube_that_is_too_fast_does_not_hide_a_slower_one(seed: int) -> None:
    """The speed that a refusal names is enough, and it is that of the slowest tube that the tool knows."""
    task = arena_task(PAPER, seed)
    with pytest.raises(NotCertified, match="raise tube.max_speed to") as caught:
        built(limited(task, Fraction("0.01")))
    needed = Fraction(str(caught.value).split("raise tube.max_speed to ")[1].split(",")[0])
    assert built(limited(task, needed)).certificate.holds
    slowest = max(build_task(task, tube=refine(task.changed(tube={"prefer": "slow"}))).certificate.speed)
    spare = (
        Fraction(arena_of(task).allowance) * 128 / task.prescribed_time
    )  # what the arithmetic may take of every segment's step
    assert needed <= (slowest + spare) * Fraction(100002, 100000)  # and six printed digits


def limited(task, speed: Fraction):
    return task.model_copy(update={"tube": task.tube.model_copy(update={"max_speed": speed})})


@pytest.mark.parametrize("exponent", [-10, 10, 17])
def test_a_power_of_two_as_unit_of_length_changes_nothing_but_the_unit(exponent: int) -> None:
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    scale = Fraction(2) ** exponent

    def scaled(box):
        return box.model_copy(update={"lower": tuple(v * scale for v in box.lower), "upper": tuple(v * scale for v in box.upper)})

    tube = task.tube.model_copy(update={"clearance": task.tube.clearance * scale, "min_width": task.tube.min_width * scale})
    changed = task.model_copy(
        update={
            **{name: scaled(getattr(task, name)) for name in ("state_space", "initial_set", "target_set")},
            "unsafe": tuple(scaled(s) for s in task.unsafe),
            "initial_state": tuple(v * scale for v in task.initial_state),
            "tube": tube,
        }
    )
    assert design_tube(changed).table == design_tube(task).table


@pytest.mark.parametrize("t_c", ["1e-8", "9e8"])
def test_the_prescribed_time_is_only_a_unit(t_c: str) -> None:
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    assert design_tube(task.model_copy(update={"prescribed_time": Fraction(t_c)})).table == design_tube(task).table


def test_lengths_below_the_least_width_of_the_law_are_refused() -> None:
    """omni_s2 in units of 10,000 km: the emitted law would not be (13) any more."""
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    tiny = Fraction(1, 10**7)

    def scaled(box):
        return box.model_copy(update={"lower": tuple(v * tiny for v in box.lower), "upper": tuple(v * tiny for v in box.upper)})

    boxes = {name: scaled(getattr(task, name)) for name in ("state_space", "initial_set", "target_set")}
    small = task.model_copy(
        update={
            **boxes,
            "unsafe": tuple(scaled(s) for s in task.unsafe),
            "initial_state": tuple(v * tiny for v in task.initial_state),
            "tube": task.tube.model_copy(update={"clearance": Fraction(0), "min_width": Fraction(0)}),
        }
    )
    with pytest.raises(NotCertified, match="P1"):
        built(small)


BEND = (
    'name = "bend"\nprescribed_time = 9.0\ninitial_state = [0.25, 0.25]\n[state_space]\nlower = [0.0, 0.0]\nupper = [5.0, 5.0]\n'
    "[initial_set]\nlower = [0.0, 0.0]\nupper = [0.5, 0.5]\n[target_set]\nlower = [4.5, 0.0]\nupper = [5.0, 0.5]\n"
    + unsafe("A", [1.0, 0.0], [2.0, 4.0])
    + unsafe("B", [2.12, 1.0], [3.0, 5.0])
)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("segments = 5", ["spline tube of 5 segments", "tube.segments = ", "would do"]),
        ("min_width = 0.07", ["tube.clearance = 0.024", "or at tube.min_width = 0.059"]),
        ("segments = 6\nmax_speed = 1.2", ["would do"]),
        ("max_speed = 1.2", ["speed (P6)", "raise tube.max_speed", "prescribed_time to"]),
        ("min_width = 0.6", ["width (P1)", "lower tube.min_width"]),
    ],
)
def test_an_option_that_cannot_be_met_is_named_with_what_would_do(options: str, words: list[str]) -> None:
    with pytest.raises(NotCertified) as caught:
        built(parse_task(BEND + f"\n[tube]\n{options}\n"))
    assert all(word in str(caught.value) for word in words), caught.value


# ---------------------------------------------------------------------- many unsafe sets, windows, legs


def test_a_corridor_of_two_hundred_slabs_is_certified_with_a_step_that_costs_the_same() -> None:
    family = replace(FAMILIES["corridor"], count=200, length=100.0)
    controller = built(arena_task(family, 0))
    assert controller.certificate.holds
    small = controller_of("omni_s1").program
    for function in ("control", "tube"):
        assert cost_of(controller.program, function) == cost_of(small, function)


def test_looking_among_near_nodes_finds_hardly_a_longer_route_than_among_all() -> None:
    family = replace(FAMILIES["corridor"], count=60, length=30.0)
    for seed in range(3):
        arena = arena_of(arena_task(family, seed))
        start = starting_box(arena)
        near = shortest_route(arena, start, least_width(arena))
        centre, half = (start[0] + start[1]) / 2, least_width(arena) / 2
        problem = centre_problem_of(arena, centre, arena.clearance + half, half)
        assert problem is not None
        among_all = search_corners(problem, neighbour_limit=10**6)
        assert among_all is not None
        assert among_all.length - 1e-9 <= near.length <= 1.02 * among_all.length


WINDOW = [
    ("left", [2.0, 0.0, 0.0], [2.5, 1.2, 5.0]),
    ("right", [2.0, 2.0, 0.0], [2.5, 5.0, 5.0]),
    ("bottom", [2.0, 0.0, 0.0], [2.5, 5.0, 3.0]),
    ("top", [2.0, 0.0, 3.7], [2.5, 5.0, 5.0]),
]


def window(bottom: float) -> str:
    """A wall of four boxes with a window that has no corner of its own; its lower rim at `bottom`, its upper at 3.7."""
    boxes = [(n, low, [*high[:2], bottom] if n == "bottom" else high) for n, low, high in WINDOW]
    head = (
        'name = "window"\nprescribed_time = 9.0\ninitial_state = [0.25, 0.25, 0.25]\n'
        + "[state_space]\nlower = [0.0, 0.0, 0.0]\nupper = [5.0, 5.0, 5.0]\n"
        + "[initial_set]\nlower = [0.0, 0.0, 0.0]\nupper = [0.5, 0.5, 0.5]\n"
        + "[target_set]\nlower = [4.5, 4.5, 4.5]\nupper = [5.0, 5.0, 5.0]\n"
    )
    return head + "".join(unsafe(*b) for b in boxes)


def test_a_window_in_space_that_no_corner_marks_is_found_and_a_closed_one_refused() -> None:
    task = parse_task(window(3.0))
    arena = arena_of(task)
    assert find_corner_route(arena, starting_box(arena), least_width(arena)) is None  # the corners alone do not see it
    assert built(task).certificate.holds
    with pytest.raises(NotCertified, match="no way leads .*clearance = 0 together with tube.min_width = 0.049"):
        built(parse_task(window(3.65)))
    with pytest.raises(NotCertified, match="whatever the clearance"):
        built(parse_task(window(3.8)))


@pytest.mark.parametrize("seed", range(6))
def test_a_way_through_cells_is_free_and_is_there_exactly_when_flood_fill_says_so(seed: int) -> None:
    family = replace(FAMILIES["dense24"], count=30)
    boxes, reach = cubes(family, seed), 0.1
    lower, upper = boxes[:, :, 0] - reach, boxes[:, :, 1] + reach
    space, goal = np.array([[reach] * 2, [5 - reach] * 2]), np.array([[4.7] * 2, [4.8] * 2])
    way = find_cell_path(lower, upper, space, goal, np.array([0.25, 0.25]))
    assert (way is not None) == feasible(family, seed, reach)
    if way is not None:
        for a, b in itertools.pairwise(way):
            for s in np.linspace(0, 1, 101):
                p = a + s * (b - a)
                assert not np.any(np.all((lower < p) & (p < upper), axis=1))
        assert np.all((goal[0] <= way[-1]) & (way[-1] <= goal[1]))


@settings(max_examples=60)
@given(st.lists(st.tuples(st.floats(0, 10), st.floats(0, 3)), min_size=1, max_size=30))
def test_changes_of_side_fall_into_their_intervals_and_are_as_few_as_can_be(raw: list[tuple[float, float]]) -> None:
    intervals = [(a, a + width) for a, width in raw]
    moments = _common_changes(intervals)
    assert all(a <= m <= b for m, (a, b) in zip(moments, intervals, strict=True))
    apart, last = 0, -1.0  # intervals that are pairwise disjoint need as many moments
    for a, b in sorted(intervals, key=lambda v: v[1]):
        if a > last:
            apart, last = apart + 1, b
    assert len(set(moments)) <= apart


def test_each_leg_of_the_mission_ends_where_the_next_one_may_start() -> None:
    legs = [controller_of(f"mission_leg{k}").certificate for k in (1, 2, 3)]
    ends = [controller_of(f"mission_leg{k}").design.bezier()[-1, :, :, 3] for k in (1, 2, 3)]
    for k in (0, 1):
        unit, error = controller_of(f"mission_leg{k + 1}").design.unit, max(legs[k].edge_error)
        for (low, high), (begin, end) in zip(ends[k], legs[k + 1].start, strict=True):
            assert begin + error <= int(low) * unit - error
            assert int(high) * unit + error <= end - error


def test_a_refusal_among_many_small_sets_is_not_false() -> None:
    """A wall with a gap, and a crowd of small sets behind it that fills the search's near nodes: the way is there."""
    crowd = "".join(
        unsafe(f"C{i}_{j}", [2.7 + 0.25 * i, 0.3 + 0.3 * j], [2.75 + 0.25 * i, 0.35 + 0.3 * j])
        for i in range(6)
        for j in range(7)
    )
    head = BEND.split("[[unsafe]]")[0]
    wall = unsafe("lower", [2.0, 0.0], [2.5, 2.45]) + unsafe("upper", [2.0, 2.55], [2.5, 5.0])
    with pytest.raises(NotCertified) as caught:
        built(parse_task(f"{head}{wall}{crowd}\n[tube]\nclearance = 0.08\n"))
    assert "whatever the clearance" not in str(caught.value)
    value = re.search(r"tube\.clearance = ([\d.]+)", str(caught.value))
    assert value
    assert 0.02 < float(value.group(1)) < 0.025


def test_a_window_in_six_dimensions_is_passed_in_legs() -> None:
    """Too many cells for one flood; three dimensions move, then the others. A closed window is refused as not found."""

    def spread(values: list[float], rest: float) -> str:
        return str([values[0], rest, values[1], rest, values[2], rest])

    def six(bottom: float) -> str:
        text = window(bottom)
        for low, high in ((0.0, 5.0), (0.0, 0.5), (4.5, 5.0)):
            text = text.replace(f"lower = {[low] * 3}", f"lower = {[low] * 6}").replace(
                f"upper = {[high] * 3}", f"upper = {[high] * 6}"
            )
        text = text.replace("initial_state = [0.25, 0.25, 0.25]", f"initial_state = {[0.25] * 6}")
        for name, low, high in [(n, a, [*b[:2], bottom] if n == "bottom" else b) for n, a, b in WINDOW]:
            old = unsafe(name, low, high)
            text = text.replace(old, old.replace(str(low), spread(low, 0.0)).replace(str(high), spread(high, 5.0)))
        return text + "".join(unsafe(f"D{k}", [4.0] * 5 + [0.2 * k], [4.1] * 5 + [0.2 * k + 0.1]) for k in range(12))

    task = parse_task(six(3.0))
    arena = arena_of(task)
    assert find_corner_route(arena, starting_box(arena), least_width(arena)) is None
    assert built(task).certificate.holds
    with pytest.raises(NotCertified, match="no way was found"):
        built(parse_task(six(3.8)))


def test_a_way_through_cells_may_lead_back() -> None:
    """Up past the first wall, down to the gap below the second: steps in both directions of a dimension."""
    lower, upper = np.array([[1.0, 0.0], [3.0, 1.0]]), np.array([[2.0, 4.0], [4.0, 5.0]])
    space, goal = np.array([[0.0, 0.0], [5.0, 5.0]]), np.array([[4.5, 4.5], [4.9, 4.9]])
    start = np.array([0.5, 0.5])
    for ends in (goal, np.array([[4.5, 0.1], [4.9, 0.4]])):
        way = find_cell_path(lower, upper, space, ends, start)
        assert way is not None
        assert way[:, 1].max() > 4.0
        assert way[:, 1].argmax() < len(way) - 1 or ends is goal
        assert np.all((ends[0] <= way[-1]) & (way[-1] <= ends[1]))
    back = find_cell_path(lower, upper, space, np.array([[0.1, 0.1], [0.4, 0.4]]), np.array([4.7, 0.2]))
    assert back is not None
