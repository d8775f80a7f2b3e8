"""Sets that move, are unsafe only at times, or grow: where they may be, and tubes that keep off them."""

from __future__ import annotations

import itertools
import math
import re
from fractions import Fraction
from pathlib import Path
from random import Random

import numpy as np
import pytest

from benchmarks.moving import leaves_a_way, movers, task_of
from benchmarks.mutants.tubes import MOVING
from benchmarks.mutations import judge
from benchmarks.oracles.tubes import first_fault
from stt_codegen.certify.moving_slack import UNREQUIRED_SLACK, MovingBlock, MovingBounds, cut
from stt_codegen.constraints import avoidances
from stt_codegen.design.refine import refine
from stt_codegen.emit.render import render
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.command import Request, simulate
from stt_codegen.loop.simulate import CLOCKS, Loop, Scenario, csv
from stt_codegen.pipeline import EmittedController, build_program, certify
from stt_codegen.plants import PLANTS
from stt_codegen.program.analyse.cost import cost_of
from stt_codegen.report.pictures.tube_pictures import figure_of
from stt_codegen.task.load import parse_task
from stt_codegen.task.sets.motion import Course
from stt_codegen.task.task import Task
from tests.support.controllers import built
from tests.task.test_shapes import checked

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
    "doubted cart": HEAD.format(head="start_delay = 0.4", body="") + CART + "timing = 0.2\n",
    "door": PLAIN + DOOR,
    "doubted door": HEAD.format(head="start_delay = 0.4", body="") + DOOR + "timing = 0.5\n",
    "growing disc": PLAIN + DISC,
    "wedge, body": HEAD.format(head="", body="body = [0.05, 0.1]") + WEDGE,
    "all": HEAD.format(head="start_delay = 0.1", body="body = [0.05, 0.05]") + CART + DOOR + DISC + WEDGE,
    "standing disc that grows": PLAIN + '[[unsafe]]\nname = "spill"\ncentre = [2.5, 2.4]\nradius = 0.3\nspread = 0.1\n',
}


@pytest.fixture(scope="module")
def made() -> dict[str, EmittedController]:
    return {name: built(parse_task(text)) for name, text in TEXTS.items()}


def random_course(draw: Random, n: int) -> Course:
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


def test_the_legs_are_where_the_set_may_be_and_no_more() -> None:
    """At every time the farthest place along any direction is the farthest of all readings of the clock, exactly."""
    draw = Random(1)
    for _ in range(300):
        course = random_course(draw, 2)
        t = Fraction(draw.randint(0, 9000), 1000)
        readings = {t - course.clock_lag, t + course.clock_lead}
        readings |= {at for at, _ in course.knots if t - course.clock_lag <= at <= t + course.clock_lead}
        first, last = course.active_interval or (-course.clock_lag, course.t_c + course.clock_lead)
        readings |= {v for v in (first, last) if t - course.clock_lag <= v <= t + course.clock_lead}
        places = [course.displacement(tau) for tau in readings if first <= tau <= last]
        legs = [leg for leg in course.legs if leg.begin <= t <= leg.end]
        assert bool(places) == bool(legs)
        for leg in legs:
            for normal in itertools.product((-2, 0, 1, 3), repeat=2):
                told = max(sum(c * v for c, v in zip(normal, p, strict=True)) for p in leg.displacements_at(t))
                true = max(sum(c * v for c, v in zip(normal, p, strict=True)) for p in places)
                assert told == true


def test_legs_follow_one_another_without_a_gap() -> None:
    draw = Random(2)
    for _ in range(200):
        legs = random_course(draw, 3).legs
        assert all(a.end == b.begin for a, b in itertools.pairwise(legs))
        assert all(0 <= leg.begin < leg.end <= 9 for leg in legs)


@pytest.mark.parametrize("name", TEXTS)
def test_a_tube_among_moving_sets_is_found_proved_checked_and_true(
    name: str, made: dict[str, EmittedController], tmp_path: Path
) -> None:
    controller = made[name]
    assert controller.certificate.holds
    assert checked(TEXTS[name], controller.files, tmp_path) == 0
    assert first_fault(controller.task, controller.design) is None
    plain = built(parse_task(PLAIN))
    assert cost_of(controller.program, "control") == cost_of(plain.program, "control")


@pytest.mark.parametrize(
    "name", [pytest.param("doubted cart", marks=pytest.mark.slow), "doubted door", "growing disc", "wedge, body"]
)
def test_what_gets_harder_is_refused_where_the_truth_is(name: str, made: dict[str, EmittedController], tmp_path: Path) -> None:
    """More doubt, more growth, more clearance: tool and checker agree, refuse once and for all, and never too late."""
    design, verdicts = made[name].design, []
    for k in range(10):
        more = {"timing": Fraction(k, 10)} if "doubted" in name else {"spread": Fraction(k, 50)}
        unsafe = [s.model_copy(update={f: (getattr(s, f) or 0) + v for f, v in more.items()}) for s in made[name].task.unsafe]
        task = made[name].task.changed(unsafe=tuple(unsafe))
        found = certify(task, design, build_program(task, design))
        verdicts.append(found.tube_holds)
        old = {"doubted cart": "timing = 0.2", "doubted door": "timing = 0.5", "growing disc": "spread = 0.02"}.get(name, "")
        field, _, first = old.partition(" = ")
        step = k / 10 if field == "timing" else k / 50
        text = TEXTS[name].replace(old, f"{field} = {float(first) + step:.2f}") if old else f"{TEXTS[name]}spread = {step:.2f}\n"
        assert parse_task(text).courses == task.courses
        assert (checked(text, render(parse_task(text), design, made[name].program, found), tmp_path) == 0) == found.holds
        assert not found.tube_holds or first_fault(task, design) is None
    assert verdicts == sorted(verdicts, reverse=True)
    assert len(set(verdicts)) == 2


@pytest.mark.slow
def test_nothing_unsafe_passes_among_moving_mutants() -> None:
    verdicts = [judge(number, 5, number % 4 == 0, ("omni_s2", "paper 3"), MOVING) for number in range(32)]
    assert not [v for v in verdicts if v.fault and any(a.passed for a in v.answers)]
    assert len({bool(v.fault) for v in verdicts}) == 2


def test_a_bound_in_whole_units_is_the_least_that_is_no_less() -> None:
    """The rows of a moving set over time against their definition, in fractions, on whole segments and on parts of them."""
    controller = built(parse_task(TEXTS["all"]))
    design, draw = controller.design, Random(3)
    per = Fraction(design.segments) / design.prescribed_time
    for one in avoidances(controller.task):
        assert one.course is not None
        block = MovingBlock.of_set(one, design)
        whole = block.slack_by_constraint(design.bezier())
        for _ in range(12):
            k = draw.randrange(design.segments)
            begin, length = Fraction(k) + Fraction(draw.randrange(8), 8), Fraction(1, 8)
            piece = cut(design.bezier()[k].astype(object) * Fraction(1), begin - k, begin - k + length)
            told = block.slack_by_constraint(piece[None], begin, length)[0]
            assert (told >= whole[k] - 1).all() or (
                told == UNREQUIRED_SLACK
            ).any()  # a part has at least what the whole has, but for a unit
            legs = [leg for leg in one.course.legs if leg.begin * per < begin + length and leg.end * per > begin]
            assert (told == UNREQUIRED_SLACK).all() == (not legs)
            for leg in legs:
                a, b = max(leg.begin * per, begin), min(leg.end * per, begin + length)
                part = cut(piece, (a - begin) / length, (b - begin) / length)
                for r, row in enumerate(one.alternatives):
                    slack = []
                    for j in range(4):
                        left = sum(c * part[i, side, j] for i, side, c in row.terms)
                        t = (a + (b - a) * Fraction(j, 3)) / per
                        shift = max(sum(c * by[i] for i, _, c in row.terms) for by in leg.displacements_at(t))
                        bound = (row.bound + row.clearance + shift + one.growth_rates[r] * one.course.growth(t)) / design.unit
                        slack.append(left - math.ceil(bound))
                    assert told[r] <= math.floor(min(slack) / row.slack_per_distance)
                    assert len(legs) > 1 or told[r] == math.floor(min(slack) / row.slack_per_distance)


def test_a_slope_beyond_64_bits_is_no_trouble_at_time_0() -> None:
    """At time 0 the slope counts for nothing, and is there all the same."""
    steep = MovingBounds(Fraction(0), Fraction(1), np.array([[3]], dtype=object), np.array([[2**70]], dtype=object), 1)
    assert steep.bounds(np.array([[0, 0, 0, 0]]), 1).tolist() == [[[3] * 4]]
    assert steep.bounds(np.array([[0, 1, 2, 3]]), 3).tolist() == [[[3 + -(-k * 2**70 // 3) for k in range(4)]]]


@pytest.mark.parametrize("clock", CLOCKS)
def test_no_loop_meets_a_set_whatever_its_clock(clock: str, made: dict[str, EmittedController]) -> None:
    for name in ("all", "doubted cart"):
        loop = Loop(made[name], PLANTS["integrator"])
        for kind, seed in (("nearest", 1), ("random", 2)):
            assert loop.run(Scenario(rate=500.0, disturbance=kind, strength=0.2, seed=seed, clock=clock)).good


def test_the_loop_judges_by_where_the_set_is_then(made: dict[str, EmittedController]) -> None:
    loop = Loop(made["cart"], PLANTS["integrator"])
    assert loop.run(Scenario(start=(1.5, 4.5))).hit_at == 0  # where the cart is first
    assert loop.run(Scenario(start=(4.0, 2.0))).hit_at != 0  # where it comes later
    doubted = Loop(made["doubted cart"], PLANTS["integrator"])
    place = (2.1, 4.2)  # where the cart is 0.6 s later
    hits = {clock: doubted.run(Scenario(start=place, clock=clock)).hit_at == 0 for clock in CLOCKS}
    assert hits == {"stated": False, "early": False, "late": True, "worst": True}
    door = Loop(made["door"], PLANTS["integrator"])
    assert door.run(Scenario(start=(2.1, 1.0))).hit == "door"
    spill = Loop(made["standing disc that grows"], PLANTS["integrator"])
    assert spill.run(Scenario(start=(2.5, 2.11))).hit_at == 0
    assert spill.run(Scenario(start=(2.5, 2.09))).hit_at != 0  # until it has grown so far


def test_the_trace_tells_where_the_sets_are(made: dict[str, EmittedController]) -> None:
    controller = made["all"]
    run = Loop(controller, PLANTS["integrator"]).run(Scenario(rate=20.0), trace=True)
    assert run.trace is not None
    read = np.genfromtxt(csv(run.trace, controller.task).decode().splitlines(), delimiter=",", names=True, deletechars="")
    assert read["cart.d1"] == pytest.approx(np.interp(read["t"], [0, 5], [1, 3.5]), abs=1e-8)  # nine digits are written
    assert (read["door.unsafe"] == (read["t"] <= 3)).all()


def test_the_picture_shows_the_arena_at_several_times(made: dict[str, EmittedController]) -> None:
    def times(name: str) -> list[str]:
        return [axis.get_title() for axis in figure_of(made[name]).axes if axis.get_title().startswith("t = ")]

    assert times("all") == [f"t = {v} s" for v in ("0", "1.8", "3.6", "5.4", "7.2", "9")]
    assert not [a for a in figure_of(built(parse_task(PLAIN))).axes if a.get_title().startswith("t = ")]


def test_header_and_certificate_speak_of_the_clock_only_where_it_matters(made: dict[str, EmittedController]) -> None:
    told = made["doubted cart"].files
    assert b"t = 0 is when the clock of the sets shows 0, or at most 0.4 s after" in told["hall.h"]
    assert b"cart 0.2 s" in told["hall.h"]
    assert b'"clock": {"start_delay": "2/5", "timing": {"cart": "1/5"}}' in told["hall.certificate.json"]
    plain = built(parse_task(PLAIN)).files
    assert not [name for name, data in plain.items() if b"clock" in data]


def test_a_target_that_moves_is_met_where_it_is_at_t_c(tmp_path: Path) -> None:
    text = PLAIN + "motion = [{at = 0, by = [-4, 0]}, {at = 6, by = [-2, -1.5]}]\n"
    controller = built(parse_task(text))
    assert controller.certificate.holds
    assert checked(text, controller.files, tmp_path) == 0
    (a, b), (c, d) = ([float(v) * float(controller.design.unit) for v in (e[0].sum(), e[1].sum())] for e in ends(controller))
    assert (2.5 <= a < b <= 3, 3 <= c < d <= 3.5) == (True, True)
    assert first_fault(controller.task, controller.design) is None
    assert first_fault(parse_task(PLAIN), controller.design) is not None


@pytest.mark.parametrize(
    "target",
    [
        "centre = [3, 3]\nradius = 0.4\nmotion = [{at = 0, by = [0, 0]}, {at = 9, by = [1, 1]}]\n",
        "lower = [2, 2]\nupper = [3, 3]\nvertices = [[2, 2], [3, 2], [2.5, 3]]\nmotion = [{at = 0, by = [1.2, 1.2]}]\n",
    ],
)
def test_a_target_that_is_cut_moves_as_a_whole(target: str, tmp_path: Path) -> None:
    text = PLAIN.replace("lower = [4.5, 4.5]\nupper = [5, 5]\n", target)
    controller = built(parse_task(text))
    assert controller.certificate.holds
    assert checked(text, controller.files, tmp_path) == 0
    assert first_fault(controller.task, controller.design) is None


@pytest.mark.parametrize("scale", ["1e-3", "1e-4", "4e-5"])
@pytest.mark.parametrize("motion", ["", "motion = [{at = 0, by = [1e9, 0]}, {at = 9, by = [1e9, 0]}]\n"])
def test_sets_however_far_have_the_margin_that_the_checker_finds(scale: str, motion: str, tmp_path: Path) -> None:
    unit = Fraction(scale)

    def pair(a: float, b: float) -> str:
        return f"[{float(Fraction(str(a)) * unit):.8f}, {float(Fraction(str(b)) * unit):.8f}]"

    place = (pair(2, 2), pair(2.5, 2.5)) if motion else ("[100000000, 0.002]", "[900000000, 0.003]")
    text = f"""name = "small"
prescribed_time = 9
initial_state = {pair(0.25, 0.25)}
state_space = {{ lower = {pair(-0.2, -0.2)}, upper = {pair(5.2, 5.2)} }}
initial_set = {{ lower = {pair(0, 0)}, upper = {pair(0.5, 0.5)} }}
target_set = {{ lower = {pair(4.5, 4.5)}, upper = {pair(5, 5)} }}
tube = {{ clearance = {float(unit) / 100:.8f}, min_width = {float(unit) / 10:.8f} }}
[[unsafe]]
lower = {place[0]}
upper = {place[1]}
{motion}"""
    controller = built(parse_task(text))
    assert checked(text, controller.files, tmp_path) == 0


def test_there_is_time_to_cross_after_a_door_has_opened() -> None:
    """In one dimension nothing but waiting helps; more haste is tried where the even pace finds no way."""
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
    assert built(parse_task(text)).certificate.holds
    slow = PLAIN.replace("prescribed_time = 9", "prescribed_time = 900") + CART.replace("at = 5", "at = 500")
    assert built(parse_task(slow + "[tube]\nsegments = 16\n")).certificate.holds


def test_the_trace_follows_the_clock(made: dict[str, EmittedController]) -> None:
    controller = made["doubted cart"]
    for clock, by in (("stated", 0.0), ("early", -0.2), ("late", 0.6)):
        run = Loop(controller, PLANTS["integrator"]).run(Scenario(rate=20.0, clock=clock), trace=True)
        assert run.trace is not None
        read = np.genfromtxt(
            csv(run.trace, controller.task, clock).decode().splitlines(), delimiter=",", names=True, deletechars=""
        )
        assert read["cart.d1"] == pytest.approx(np.interp(read["t"] + by, [0, 5], [1, 3.5]), abs=1e-8)


def ends(controller: EmittedController) -> np.ndarray:
    """The edges at t_c, (n, 2, 1)."""
    return controller.design.bezier()[-1, :, :, 3:]


def test_in_many_dimensions_some_move_through_cells_and_the_others_straight() -> None:
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
    controller = built(task)
    assert controller.certificate.holds
    assert first_fault(task.model_copy(update={"unsafe": task.unsafe[1:]}), controller.design) is None


def test_arenas_that_leave_a_way_are_certified() -> None:
    for seed in range(6):
        found = movers(seed, 2, 4, 0.5, 1.0, 9.0, False)
        assert leaves_a_way(found, 0.1)
        assert built(task_of(found)).certificate.holds


WALL = """[[unsafe]]
name = "gate"
lower = [2, -0.2]
upper = [3, 5.2]
during = [{hours}]
"""


def test_a_refusal_says_what_closes_the_way_and_when_and_what_opens_it() -> None:
    with pytest.raises(NotCertified, match=r"gate \(a way would open if it were safe from [\d.]+ s to [\d.]+ s\) closes it"):
        refine(parse_task(PLAIN + WALL.format(hours="0, 8.9")))
    assert built(parse_task(PLAIN + WALL.format(hours="0, 4"))).certificate.holds
    late = HEAD.format(head="start_delay = 8", body="") + WALL.format(hours="8, 9")
    with pytest.raises(NotCertified, match=r"a way opens at, for example, start_delay = ") as told:
        refine(parse_task(late))
    delay, longer = (
        re.findall(rf"{name} = ([\d.]+)", str(told.value))[0].rstrip(".") for name in ("start_delay", "prescribed_time")
    )
    assert built(parse_task(late.replace("start_delay = 8", f"start_delay = {delay}"))).certificate.holds
    assert built(parse_task(late.replace("prescribed_time = 9", f"prescribed_time = {longer}"))).certificate.holds
    gap = '[[unsafe]]\nname = "{}"\nlower = [2, {}]\nupper = [3, {}]\nduring = [0, 9]\n'
    with pytest.raises(NotCertified, match="tube.clearance = ") as told:
        refine(parse_task(PLAIN + gap.format("low", -0.2, 2) + gap.format("high", 2.1, 5.2)))
    value = str(told.value).split("tube.clearance = ")[1].split(",")[0].split(" ")[0]
    assert built(
        parse_task(PLAIN + gap.format("low", -0.2, 2) + gap.format("high", 2.1, 5.2) + f"[tube]\nclearance = {value}\n")
    ).certificate.holds


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
def test_what_is_no_motion_is_refused(old: str, new: str, words: list[str]) -> None:
    assert old in TEXTS["cart"]
    with pytest.raises(BadInput) as caught:
        parse_task(TEXTS["cart"].replace(old, new))
    assert all(word in str(caught.value) for word in words), caught.value


def test_half_spaces_that_are_open_do_not_move() -> None:
    """What ends at the state space would move as a whole, and leave the other side free."""
    open_ = "[[unsafe]]\nnormals = [[1, 1]]\noffsets = [1]\n"
    closed = "[[unsafe]]\nnormals = [[1, 1], [-1, 0], [0, -1]]\noffsets = [1, -0.1, -0.1]\n"
    motion = "motion = [{at = 0, by = [2, 2]}, {at = 9, by = [3, 1]}]\n"
    with pytest.raises(BadInput, match=r"unsafe\[0\].motion: the half-spaces leave the set open"):
        parse_task(PLAIN + open_ + motion)
    assert built(parse_task(PLAIN + closed + motion)).certificate.holds


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
def test_a_set_that_is_at_the_start_only_by_doubt_is_told_so(sets: str, words: str) -> None:
    with pytest.raises(BadInput, match=f"may be .with its [a-z_ ]*{words}"):
        parse_task(PLAIN + "[[unsafe]]\n" + sets)


def test_a_clock_that_does_not_matter_is_no_option() -> None:
    with pytest.raises(BadInput, match="--clock worst: no unsafe set"):
        simulate(built(parse_task(PLAIN)), Request(clock="worst"), None)
