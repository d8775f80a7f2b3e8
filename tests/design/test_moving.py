"""Unsafe sets that move, grow or are active for a while: where they may be, and tubes that avoid them."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from pathlib import Path
from random import Random

import numpy as np
import pytest

from benchmarks.moving import FOUR, draw_moving_sets, has_way, task_of
from benchmarks.mutants.tubes import TIMED_SET_KINDS
from benchmarks.mutations import judge
from benchmarks.oracles.tubes import first_fault
from benchmarks.suites.remedies import follow_remedies
from stt_codegen.certify.moving_slack import UNREQUIRED_SLACK, MovingBlock, MovingBounds, cut
from stt_codegen.constraints import avoidances
from stt_codegen.design.refine import refine
from stt_codegen.emit.render import render
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.command import Request, simulate
from stt_codegen.loop.simulate import CLOCKS, Loop, Scenario
from stt_codegen.loop.traces import trace_csv
from stt_codegen.pipeline import EmittedController, build_program, certify
from stt_codegen.plants import PLANTS
from stt_codegen.program.analyse.cost import cost_of
from stt_codegen.report.pictures.tube_pictures import figure_of
from stt_codegen.task.load import parse_task
from stt_codegen.task.sets.motion import Course
from stt_codegen.task.task import Task
from tests.support.controllers import build_once
from tests.task.test_shapes import checker_exit_code

HEAD = """name = "hall"
prescribed_time = 9
{head}
initial_state = [0.25, 0.25]
{body}
[state_space]
lower = [-0.2, -0.2]
upper = [5.2, 5.2]
[initial_set]
lower = [0, 0]
upper = [0.5, 0.5]
[target_set]
lower = [4.5, 4.5]
upper = [5, 5]
"""
CART = """[[unsafe]]
name = "cart"
lower = [0, 0]
upper = [1, 1]
motion = [{at = 0, by = [1, 4]}, {at = 5, by = [3.5, 1.5]}]
"""
DOOR = """[[unsafe]]
name = "door"
lower = [2, -0.2]
upper = [2.2, 5.2]
during = [0, 3]
"""
DISC = """[[unsafe]]
name = "disc"
centre = [0, 0]
radius = 0.4
motion = [{at = 1, by = [3.5, 1]}, {at = 4, by = [2, 2]}, {at = 7, by = [3, 3.5]}]
spread = 0.02
"""
WEDGE = """[[unsafe]]
name = "wedge"
vertices = [[0, 0], [1.2, 0], [0.3, 0.9]]
motion = [{at = 0, by = [3, 3]}, {at = 9, by = [0.5, 2]}]
timing = 0.3
"""
PLAIN = HEAD.format(head="", body="")
TEXTS = {
    "cart": PLAIN + CART,
    "uncertain cart": HEAD.format(head="start_delay = 0.4", body="") + CART + "timing = 0.2\n",
    "door": PLAIN + DOOR,
    "uncertain door": HEAD.format(head="start_delay = 0.4", body="") + DOOR + "timing = 0.5\n",
    "growing disc": PLAIN + DISC,
    "wedge, body": HEAD.format(head="", body="body = [0.05, 0.1]") + WEDGE,
    "all": HEAD.format(head="start_delay = 0.1", body="body = [0.05, 0.05]") + CART + DOOR + DISC + WEDGE,
    "standing disc that grows": PLAIN + '[[unsafe]]\nname = "spill"\ncentre = [2.5, 2.4]\nradius = 0.3\nspread = 0.1\n',
}


@pytest.fixture(scope="module")
def controllers() -> dict[str, EmittedController]:
    """Return the controllers of `TEXTS`, by name."""
    return {name: build_once(parse_task(text)) for name, text in TEXTS.items()}


def draw_course(draw: Random, n: int) -> Course:
    """Return a random course of a set in n dimensions: knots, active interval, timing uncertainty and growth."""
    times = sorted(draw.sample(range(91), draw.randint(1, 5)))
    knots = tuple((Fraction(at, 10), tuple(Fraction(draw.randint(-40, 40), 10) for _ in range(n))) for at in times)
    early, delay = (Fraction(draw.choice((0, 0, 3, 17)), 10) for _ in range(2))
    window = tuple(Fraction(v, 10) for v in sorted(draw.sample(range(91), 2))) if draw.random() < 0.5 else None
    return Course(
        knots=knots,
        active_interval=window,
        clock_lag=early,
        clock_lead=early + delay,
        spread=Fraction(draw.randint(0, 9), 100),
        t_c=Fraction(9),
    )  # type: ignore[arg-type]


def test_the_legs_are_exactly_where_the_set_may_be() -> None:
    """Along every direction the farthest displacement of the legs at a time is that of all clock readings which are possible then."""
    draw = Random(1)
    for _ in range(300):
        course = draw_course(draw, 2)
        t = Fraction(draw.randint(0, 9000), 1000)
        readings = {t - course.clock_lag, t + course.clock_lead}
        readings |= {at for at, _ in course.knots if t - course.clock_lag <= at <= t + course.clock_lead}
        first, last = course.active_interval or (-course.clock_lag, course.t_c + course.clock_lead)
        readings |= {v for v in (first, last) if t - course.clock_lag <= v <= t + course.clock_lead}
        displacements = [course.displacement(tau) for tau in readings if first <= tau <= last]
        legs = [leg for leg in course.legs if leg.begin <= t <= leg.end]
        assert bool(displacements) == bool(legs)
        for leg in legs:
            for normal in itertools.product((-2, 0, 1, 3), repeat=2):
                farthest = max(
                    sum(c * v for c, v in zip(normal, displacement, strict=True)) for displacement in leg.displacements_at(t)
                )
                farthest_possible = max(
                    sum(c * v for c, v in zip(normal, displacement, strict=True)) for displacement in displacements
                )
                assert farthest == farthest_possible


def test_legs_follow_one_another_without_a_gap() -> None:
    draw = Random(2)
    for _ in range(200):
        legs = draw_course(draw, 3).legs
        assert all(a.end == b.begin for a, b in itertools.pairwise(legs))
        assert all(0 <= leg.begin < leg.end <= 9 for leg in legs)


@pytest.mark.parametrize("name", TEXTS)
def test_a_tube_among_moving_sets_is_certified_accepted_and_without_a_fault(
    name: str, controllers: dict[str, EmittedController], tmp_path: Path
) -> None:
    controller = controllers[name]
    assert controller.certificate.holds
    assert checker_exit_code(TEXTS[name], controller.files, tmp_path) == 0
    assert first_fault(controller.task, controller.design) is None
    plain = build_once(parse_task(PLAIN))
    assert cost_of(controller.program, "control") == cost_of(plain.program, "control")


@pytest.mark.parametrize(
    "name", [pytest.param("uncertain cart", marks=pytest.mark.slow), "uncertain door", "growing disc", "wedge, body"]
)
def test_with_growing_uncertainty_tool_and_checker_refuse_at_the_same_step_and_no_later_than_the_oracle(
    name: str, controllers: dict[str, EmittedController], tmp_path: Path
) -> None:
    """Timing uncertainty or growth rises in ten steps for the same tube: it is certified up to one of them, and only without a fault."""
    design, verdicts = controllers[name].design, []
    for k in range(10):
        increments = {"timing": Fraction(k, 10)} if "uncertain" in name else {"spread": Fraction(k, 50)}
        unsafe = [
            s.model_copy(update={key: (getattr(s, key) or 0) + increment for key, increment in increments.items()})
            for s in controllers[name].task.unsafe
        ]
        task = controllers[name].task.changed(unsafe=tuple(unsafe))
        certificate = certify(task, design, build_program(task, design))
        verdicts.append(certificate.tube_holds)
        line = {"uncertain cart": "timing = 0.2", "uncertain door": "timing = 0.5", "growing disc": "spread = 0.02"}.get(name, "")
        field, _, value = line.partition(" = ")
        step = k / 10 if field == "timing" else k / 50
        text = (
            TEXTS[name].replace(line, f"{field} = {float(value) + step:.2f}") if line else f"{TEXTS[name]}spread = {step:.2f}\n"
        )
        assert parse_task(text).courses == task.courses
        assert (
            checker_exit_code(text, render(parse_task(text), design, controllers[name].program, certificate), tmp_path) == 0
        ) == certificate.holds
        assert not certificate.tube_holds or first_fault(task, design) is None
    assert verdicts == sorted(verdicts, reverse=True)
    assert len(set(verdicts)) == 2


@pytest.mark.slow
def test_nothing_unsafe_passes_among_moving_mutants() -> None:
    verdicts = [judge(number, 5, number % 4 == 0, ("omni_s2", "paper 3"), TIMED_SET_KINDS) for number in range(32)]
    assert not [v for v in verdicts if v.fault and any(a.passed for a in v.answers)]
    assert len({bool(v.fault) for v in verdicts}) == 2


def test_the_slack_over_moving_sets_is_the_exact_one_rounded_down() -> None:
    """Constraints of moving sets against their definition in fractions, on whole segments and on parts of them."""
    controller = build_once(parse_task(TEXTS["all"]))
    design, draw = controller.design, Random(3)
    segments_per_second = Fraction(design.segments) / design.prescribed_time
    for avoidance in avoidances(controller.task):
        assert avoidance.course is not None
        block = MovingBlock.of_set(avoidance, design)
        slack_by_segment = block.slack_by_constraint(design.bezier())
        for _ in range(12):
            k = draw.randrange(design.segments)
            begin, length = Fraction(k) + Fraction(draw.randrange(8), 8), Fraction(1, 8)
            piece = cut(design.bezier()[k].astype(object) * Fraction(1), begin - k, begin - k + length)
            slacks = block.slack_by_constraint(piece[None], begin, length)[0]
            # The slack of a part is at least that of its segment, up to a unit of rounding.
            assert (slacks >= slack_by_segment[k] - 1).all() or (slacks == UNREQUIRED_SLACK).any()
            legs = [
                leg
                for leg in avoidance.course.legs
                if leg.begin * segments_per_second < begin + length and leg.end * segments_per_second > begin
            ]
            assert (slacks == UNREQUIRED_SLACK).all() == (not legs)
            for leg in legs:
                a, b = max(leg.begin * segments_per_second, begin), min(leg.end * segments_per_second, begin + length)
                part = cut(piece, (a - begin) / length, (b - begin) / length)
                for r, constraint in enumerate(avoidance.alternatives):
                    slack_by_coefficient = []
                    for j in range(4):
                        value = sum(c * part[i, side, j] for i, side, c in constraint.terms)
                        t = (a + (b - a) * Fraction(j, 3)) / segments_per_second
                        shift = max(sum(c * by[i] for i, _, c in constraint.terms) for by in leg.displacements_at(t))
                        bound = (
                            constraint.bound
                            + constraint.clearance
                            + shift
                            + avoidance.growth_rates[r] * avoidance.course.growth(t)
                        ) / design.unit
                        slack_by_coefficient.append(value - math.ceil(bound))
                    assert slacks[r] <= math.floor(min(slack_by_coefficient) / constraint.slack_per_distance)
                    assert len(legs) > 1 or slacks[r] == math.floor(min(slack_by_coefficient) / constraint.slack_per_distance)


def test_a_slope_beyond_64_bits_is_computed_exactly() -> None:
    """Also at local time 0, where the slope is multiplied by 0."""
    steep = MovingBounds(Fraction(0), Fraction(1), np.array([[3]], dtype=object), np.array([[2**70]], dtype=object), 1)
    assert steep.bounds(np.array([[0, 0, 0, 0]]), 1).tolist() == [[[3] * 4]]
    assert steep.bounds(np.array([[0, 1, 2, 3]]), 3).tolist() == [[[3 + -(-k * 2**70 // 3) for k in range(4)]]]


@pytest.mark.parametrize("clock", CLOCKS)
def test_no_loop_meets_a_moving_set_for_any_of_its_clocks(clock: str, controllers: dict[str, EmittedController]) -> None:
    for name in ("all", "uncertain cart"):
        loop = Loop(controllers[name], PLANTS["integrator"])
        for kind, seed in (("nearest", 1), ("random", 2)):
            assert loop.run(Scenario(rate=500.0, disturbance=kind, strength=0.2, seed=seed, clock=clock)).good


def test_a_loop_reports_a_hit_by_where_the_set_is_at_that_time(controllers: dict[str, EmittedController]) -> None:
    loop = Loop(controllers["cart"], PLANTS["integrator"])
    assert loop.run(Scenario(start=(1.5, 4.5))).hit_at == 0  # where the cart is at t = 0
    assert loop.run(Scenario(start=(4.0, 2.0))).hit_at != 0  # where the cart arrives later
    uncertain = Loop(controllers["uncertain cart"], PLANTS["integrator"])
    state = (2.1, 4.2)  # where the cart is 0.6 s later
    hits = {clock: uncertain.run(Scenario(start=state, clock=clock)).hit_at == 0 for clock in CLOCKS}
    assert hits == {"stated": False, "early": False, "late": True, "worst": True}
    door = Loop(controllers["door"], PLANTS["integrator"])
    assert door.run(Scenario(start=(2.1, 1.0))).hit == "door"
    spill = Loop(controllers["standing disc that grows"], PLANTS["integrator"])
    assert spill.run(Scenario(start=(2.5, 2.11))).hit_at == 0
    assert spill.run(Scenario(start=(2.5, 2.09))).hit_at != 0  # which the disc reaches later


def test_the_trace_has_the_displacements_of_the_sets(controllers: dict[str, EmittedController]) -> None:
    controller = controllers["all"]
    run = Loop(controller, PLANTS["integrator"]).run(Scenario(rate=20.0), trace=True)
    assert run.trace is not None
    columns = np.genfromtxt(
        trace_csv(run.trace, controller.task).decode().splitlines(), delimiter=",", names=True, deletechars=""
    )
    assert columns["cart.d1"] == pytest.approx(np.interp(columns["t"], [0, 5], [1, 3.5]), abs=1e-8)  # the file has nine digits
    assert (columns["door.unsafe"] == (columns["t"] <= 3)).all()


def test_the_picture_shows_the_arena_at_several_times(controllers: dict[str, EmittedController]) -> None:
    def times(name: str) -> list[str]:
        return [axis.get_title() for axis in figure_of(controllers[name]).axes if axis.get_title().startswith("t = ")]

    assert times("all") == [f"t = {v} s" for v in ("0", "1.8", "3.6", "5.4", "7.2", "9")]
    assert not [a for a in figure_of(build_once(parse_task(PLAIN))).axes if a.get_title().startswith("t = ")]


def test_header_and_certificate_mention_the_clock_only_for_moving_sets(controllers: dict[str, EmittedController]) -> None:
    files = controllers["uncertain cart"].files
    assert b"t = 0 is when the clock of the sets shows 0, or at most 0.4 s after" in files["hall.h"]
    assert b"cart 0.2 s" in files["hall.h"]
    assert b'"clock": {"start_delay": "2/5", "timing": {"cart": "1/5"}}' in files["hall.certificate.json"]
    plain_files = build_once(parse_task(PLAIN)).files
    assert not [name for name, data in plain_files.items() if b"clock" in data]


def test_a_moving_target_is_reached_where_it_is_at_t_c(tmp_path: Path) -> None:
    text = PLAIN + "motion = [{at = 0, by = [-4, 0]}, {at = 6, by = [-2, -1.5]}]\n"
    controller = build_once(parse_task(text))
    assert controller.certificate.holds
    assert checker_exit_code(text, controller.files, tmp_path) == 0
    (lower_1, upper_1), (lower_2, upper_2) = (
        [float(v) * float(controller.design.unit) for v in (edges[0].sum(), edges[1].sum())] for edges in final_edges(controller)
    )
    assert (2.5 <= lower_1 < upper_1 <= 3, 3 <= lower_2 < upper_2 <= 3.5) == (True, True)
    assert first_fault(controller.task, controller.design) is None
    assert first_fault(parse_task(PLAIN), controller.design) is not None


@pytest.mark.parametrize(
    "target",
    [
        "centre = [3, 3]\nradius = 0.4\nmotion = [{at = 0, by = [0, 0]}, {at = 9, by = [1, 1]}]\n",
        "lower = [2, 2]\nupper = [3, 3]\nvertices = [[2, 2], [3, 2], [2.5, 3]]\nmotion = [{at = 0, by = [1.2, 1.2]}]\n",
    ],
)
def test_a_target_of_several_constraints_moves_with_all_of_them(target: str, tmp_path: Path) -> None:
    text = PLAIN.replace("lower = [4.5, 4.5]\nupper = [5, 5]\n", target)
    controller = build_once(parse_task(text))
    assert controller.certificate.holds
    assert checker_exit_code(text, controller.files, tmp_path) == 0
    assert first_fault(controller.task, controller.design) is None


@pytest.mark.parametrize("scale", ["1e-3", "1e-4", "4e-5"])
@pytest.mark.parametrize("motion", ["", "motion = [{at = 0, by = [1e9, 0]}, {at = 9, by = [1e9, 0]}]\n"])
def test_the_checker_accepts_tubes_with_sets_that_are_very_far_away(scale: str, motion: str, tmp_path: Path) -> None:
    unit = Fraction(scale)

    def pair(a: float, b: float) -> str:
        return f"[{float(Fraction(str(a)) * unit):.8f}, {float(Fraction(str(b)) * unit):.8f}]"

    corners = (pair(2, 2), pair(2.5, 2.5)) if motion else ("[100000000, 0.002]", "[900000000, 0.003]")
    text = f"""name = "small"
prescribed_time = 9
initial_state = {pair(0.25, 0.25)}
state_space = {{ lower = {pair(-0.2, -0.2)}, upper = {pair(5.2, 5.2)} }}
initial_set = {{ lower = {pair(0, 0)}, upper = {pair(0.5, 0.5)} }}
target_set = {{ lower = {pair(4.5, 4.5)}, upper = {pair(5, 5)} }}
tube = {{ clearance = {float(unit) / 100:.8f}, min_width = {float(unit) / 10:.8f} }}
[[unsafe]]
lower = {corners[0]}
upper = {corners[1]}
{motion}"""
    controller = build_once(parse_task(text))
    assert checker_exit_code(text, controller.files, tmp_path) == 0


def test_a_tube_waits_for_a_door_and_then_moves_fast() -> None:
    """In one dimension it can only wait; the search tries a faster pace where the even one has no route."""
    text = """name = "lane"
prescribed_time = 9
initial_state = [0.25]
state_space = { lower = [-0.2], upper = [5.2] }
initial_set = { lower = [0], upper = [0.5] }
target_set = { lower = [4.5], upper = [5] }
[[unsafe]]
name = "door"
lower = [0.8]
upper = [1]
during = [0, 4]
"""
    assert build_once(parse_task(text)).certificate.holds
    slow = PLAIN.replace("prescribed_time = 9", "prescribed_time = 900") + CART.replace("at = 5", "at = 500")
    assert build_once(parse_task(slow + "[tube]\nsegments = 16\n")).certificate.holds


def test_the_trace_has_the_displacements_of_the_chosen_clock(controllers: dict[str, EmittedController]) -> None:
    controller = controllers["uncertain cart"]
    for clock, clock_error in (("stated", 0.0), ("early", -0.2), ("late", 0.6)):
        run = Loop(controller, PLANTS["integrator"]).run(Scenario(rate=20.0, clock=clock), trace=True)
        assert run.trace is not None
        columns = np.genfromtxt(
            trace_csv(run.trace, controller.task, clock).decode().splitlines(), delimiter=",", names=True, deletechars=""
        )
        assert columns["cart.d1"] == pytest.approx(np.interp(columns["t"] + clock_error, [0, 5], [1, 3.5]), abs=1e-8)


def final_edges(controller: EmittedController) -> np.ndarray:
    """Return the edges at t_c, (n, 2, 1)."""
    return controller.design.bezier()[-1, :, :, 3:]


def test_a_tube_in_five_dimensions_avoids_a_moving_set() -> None:
    n = 5
    task = Task(
        name="many",
        prescribed_time=10,
        initial_state=[0.25] * n,
        state_space={"lower": [0] * n, "upper": [5] * n},
        initial_set={"lower": [0] * n, "upper": [0.5] * n},
        target_set={"lower": [4.5] * n, "upper": [5] * n},
        unsafe=[
            {"lower": [1] * n, "upper": [3] * n, "motion": [{"at": 0, "by": [0] * n}, {"at": 10, "by": [0.5] * n}]},
            {
                "centre": [3, 3],
                "radius": 0.7,
                "axes": ["x1", "x2"],
                "motion": [{"at": 0, "by": [0, 0]}, {"at": 10, "by": [-2, 1]}],
            },
        ],
    )
    controller = build_once(task)
    assert controller.certificate.holds
    assert first_fault(task.model_copy(update={"unsafe": task.unsafe[1:]}), controller.design) is None


def test_random_arenas_of_movers_with_a_route_are_certified() -> None:
    for seed in range(6):
        arena = draw_moving_sets(FOUR, seed)
        assert has_way(arena, 0.1)
        assert build_once(task_of(arena)).certificate.holds


WALL = """[[unsafe]]
name = "gate"
lower = [2, -0.2]
upper = [3, 5.2]
during = [{active_interval}]
"""


def test_a_refusal_names_the_set_that_closes_the_route_its_times_and_a_remedy() -> None:
    with pytest.raises(NotCertified, match=r"gate \(a way would open if it were safe from [\d.]+ s to [\d.]+ s\) closes it"):
        refine(parse_task(PLAIN + WALL.format(active_interval="0, 8.9")))
    assert build_once(parse_task(PLAIN + WALL.format(active_interval="0, 4"))).certificate.holds
    late = HEAD.format(head="start_delay = 8", body="") + WALL.format(active_interval="8, 9")
    remedies = follow_remedies(parse_task(late))
    assert {key for remedy in remedies for key in remedy} >= {"start_delay", "prescribed_time"}
    gap = '[[unsafe]]\nname = "{}"\nlower = [2, {}]\nupper = [3, {}]\nduring = [0, 9]\n'
    gapped = parse_task(PLAIN + gap.format("low", -0.2, 2) + gap.format("high", 2.1, 5.2))
    assert ["tube.clearance"] in [list(remedy) for remedy in follow_remedies(gapped)]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("{at = 5, by", "{at = 0, by", ["unsafe[0].motion[1].at", "not after", "must increase"]),
        ("{at = 5, by", "{at = 10, by", ["unsafe[0].motion[1].at", "prescribed_time = 9"]),
        ("{at = 5, by = [3.5, 1.5]}", "{at = 5, by = [3.5]}", ["unsafe[0].motion[1].by", "1 entries", "2 are needed"]),
        ("{at = 5, by = [3.5, 1.5]}", "{at = 5}", ["unsafe[0].motion[1].by", "is missing"]),
        ("{at = 5, by = [3.5, 1.5]}", "{at = -5, by = [3.5, 1.5]}", ["unsafe[0].motion[1].at", "0 or greater"]),
        ("motion = [{at = 0, by = [1, 4]}, {at = 5, by = [3.5, 1.5]}]", "motion = 3", ["unsafe[0].motion", "{ at, by }"]),
        ("motion = [{at = 0, by = [1, 4]}, {at = 5, by = [3.5, 1.5]}]", "motion = []", ["unsafe[0].motion", "empty"]),
        ("motion = [{at = 0, by = [1, 4]}, {at = 5", "motion = [{at = 0, by = [0, 0]}, {at = 5", ["initial_set: meets", "at t = 0"]),
        ("{at = 5, by = [3.5, 1.5]}", "{at = 5, by = [4.2, 4.2]}", ["target_set: lies inside", "at t_c"]),
        ("motion = [{at = 0, by = [1, 4]}, {at = 5, by = [3.5, 1.5]}]", "during = [3, 10]", ["unsafe[0].during", "prescribed_time = 9"]),
        ("motion = [{at = 0, by = [1, 4]}, {at = 5, by = [3.5, 1.5]}]", "during = [3, 3]", ["unsafe[0].during", "before"]),
        ("motion = [{at = 0, by = [1, 4]}, {at = 5, by = [3.5, 1.5]}]", "during = [3]", ["unsafe[0].during", "two are needed"]),
        ("motion = [{at = 0, by = [1, 4]}, {at = 5, by = [3.5, 1.5]}]", "timing = 0.1", ["unsafe[0].timing", "motion or during"]),
        ("upper = [1, 1]\n", "upper = [1, 1]\nspread = -1\n", ["unsafe[0].spread", "0 or greater"]),
        ("prescribed_time = 9", "prescribed_time = 9\nstart_delay = -1", ["start_delay", "0 or greater"]),
        ('name = "hall"', 'name = "hall"\ntube = { design = "adaptive" }', ["unsafe[0]", "not always the same", "refined"]),
        ("upper = [5, 5]\n[[", "upper = [5, 5]\nmotion = [{at = 9, by = [1, 0]}]\n[[", ["target_set", "outside the state space"]),
    ],
)  # fmt: skip
def test_an_inconsistent_motion_is_refused(old: str, new: str, words: list[str]) -> None:
    assert old in TEXTS["cart"]
    with pytest.raises(BadInput) as refusal:
        parse_task(TEXTS["cart"].replace(old, new))
    assert all(word in str(refusal.value) for word in words), refusal.value


def test_a_motion_of_open_half_spaces_is_refused() -> None:
    """Such a set ends at the state space; if it moved, its far side would leave that edge."""
    unbounded = "[[unsafe]]\nnormals = [[1, 1]]\noffsets = [1]\n"
    bounded = "[[unsafe]]\nnormals = [[1, 1], [-1, 0], [0, -1]]\noffsets = [1, -0.1, -0.1]\n"
    motion = "motion = [{at = 0, by = [2, 2]}, {at = 9, by = [3, 1]}]\n"
    with pytest.raises(BadInput, match=r"unsafe\[0\].motion: the half-spaces leave the set open"):
        parse_task(PLAIN + unbounded + motion)
    assert build_once(parse_task(PLAIN + bounded + motion)).certificate.holds


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        ("lower = [1, 1]\nupper = [2, 2]\nmotion = [{at = 0, by = [0, 0]}, {at = 9, by = [-1, -1]}]\ntiming = 9\n", "timing"),
        (
            "centre = [2, 2]\nradius = 0.2\nmotion = [{at = 0, by = [0, 0]}, {at = 1, by = [0, 1]}]\nspread = 9e8\ntiming = 1\n",
            "spread",
        ),
    ],
)
def test_a_set_that_reaches_the_start_only_by_its_uncertainty_is_refused_with_the_key(sets: str, words: str) -> None:
    with pytest.raises(BadInput, match=f"may be .with its [a-z_ ]*{words}"):
        parse_task(PLAIN + "[[unsafe]]\n" + sets)


def test_the_clock_option_is_refused_without_moving_sets() -> None:
    with pytest.raises(BadInput, match="--clock worst: no unsafe set"):
        simulate(build_once(parse_task(PLAIN)), Request(clock="worst"), None)
