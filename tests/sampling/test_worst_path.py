"""The worst path: its logarithm, law, drive and fall are on the safe side, it equals a slow version, and attacks see what it needs."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import replace
from decimal import Context, Decimal
from fractions import Fraction
from itertools import pairwise

import pytest

from benchmarks.lag_attack import FAMILIES, attack
from stt_codegen.program.analyse.exact_logarithm import logarithm
from stt_codegen.sampling.path import worst_path
from stt_codegen.sampling.path.drive_response import SHARE_ONE, Drive, DriveCells, decay_above
from stt_codegen.sampling.path.integer_logarithm import ARTANH_ERROR, LOG_BITS, log_bounds, twice_artanh
from stt_codegen.sampling.path.path_proof import follow_from_start, follow_local_paths, prove_path, prove_path_for
from stt_codegen.sampling.path.path_search import largest_proved, longest_path_period
from stt_codegen.sampling.path.path_windows import ComponentLaw, PathLoop, WindowBounds
from stt_codegen.sampling.path.worst_path import PathBounds, Start, follow_worst_path

F = Fraction
BOUNDS = PathBounds(
    closing_speed=F(7, 10), filter_rate=F(0), g_min=F(95, 100), g_max=F(105, 100), input_bound=F(2), u_max=F(2), gain=F(1, 25),
    narrow=F(9, 10), wide=F(1), shift=F(1, 200), rounding=F(1, 1 << 19), e_max=F(99, 100), age=F(1, 50), drive=Drive((F(6, 100),)),
)  # fmt: skip
START = Start(F(45, 1000), F(0))


def draw_bounds(rng: random.Random) -> PathBounds:
    """Draw bounds of order 1 or 2, and a drive of any kind."""
    number = lambda low, high: F(rng.uniform(low, high)).limit_denominator(10**6)  # noqa: E731
    narrow, speed, g_min = number(0.2, 2), number(0.1, 2), number(0.5, 1.2)
    u_max = speed / g_min * number(1.2, 4)
    lag = lambda: number(0.005, 0.1) * narrow / speed  # noqa: E731
    drive = Drive(
        tuple(lag() for _ in range(rng.choice((0, 1, 1, 2)))),
        rng.choice((None, None, u_max * number(5, 40))),
        rng.choice((F(0), F(0), number(0.01, 0.1))),
    )
    wide, filter_rate = narrow * rng.choice((F(1), number(1, 1.5))), rng.choice((F(0), number(0.3, 2)))
    return PathBounds(
        closing_speed=speed, filter_rate=min(filter_rate, speed / wide), g_min=g_min, g_max=g_min * number(1, 1.3),
        input_bound=u_max, u_max=u_max, gain=speed / g_min * narrow * number(0.02, 0.3), narrow=narrow,
        wide=wide, shift=narrow * number(0, 0.01), rounding=F(1, 1 << 19),
        e_max=F(99, 100), age=number(0.005, 0.1) * narrow / speed, drive=drive,
    )  # fmt: skip


def drawn(count: int, seed: int = 1) -> Iterator[tuple[PathBounds, Start]]:
    """Yield bounds with a start."""
    rng = random.Random(seed)
    for _ in range(count):
        bounds = draw_bounds(rng)
        first_input = rng.choice((F(0), bounds.age * F(rng.randrange(1, 10), 10)))
        yield bounds, Start(bounds.narrow * F(rng.randrange(50, 450), 1000), first_input)


# ------------------------------------------------------------------------------------------------------ logarithm


def scaled_logarithm(p: int, q: int) -> Decimal:
    """Return 2^64 ln(p/q) to 70 digits."""
    digits = Context(prec=70)
    return digits.multiply(digits.ln(digits.divide(Decimal(p), Decimal(q))), Decimal(1 << LOG_BITS))


def test_the_logarithm_is_between_its_bounds_which_are_close() -> None:
    rng = random.Random(3)
    for _ in range(2000):
        p, q = (rng.randrange(1, 1 << rng.randrange(2, 90)) for _ in range(2))
        low, high = log_bounds(p, q)
        assert low <= scaled_logarithm(p, q) <= high
        assert high - low <= ARTANH_ERROR + 24 * abs(p.bit_length() - q.bit_length()) + 24
        assert log_bounds(q, p) == (-high, -low)


def test_the_series_is_never_too_large_and_the_error_is_within_its_bound() -> None:
    rng = random.Random(4)
    errors = []
    for _ in range(3000):
        denominator = rng.randrange(1 << 30, 1 << 60)
        numerator = rng.randrange(int(denominator * 0.1715))
        exact = scaled_logarithm(denominator + numerator, denominator - numerator)
        errors.append(float(exact - twice_artanh(numerator, denominator)))
    assert min(errors) >= 0
    assert max(errors) < ARTANH_ERROR
    assert max(errors) > ARTANH_ERROR / 2  # the bound is not idle


# -------------------------------------------------------------------------------------------- the law from one edge


def psi(bounds: PathBounds, level: float) -> Fraction:
    """Return the bound on u where x is at most so far from the edge."""
    path = worst_path._Path(bounds, None)
    return path.law.command(math.ceil(F(level) / path.length_unit) + path.shift) * path.input_unit


def test_psi_rises_and_is_at_most_the_bound_on_the_input() -> None:
    rng = random.Random(5)
    for _ in range(20):
        bounds = draw_bounds(rng)
        values = [psi(bounds, float(bounds.wide) * k / 300) for k in range(1, 301)]
        assert all(a <= b for a, b in pairwise(values))
        assert values[0] < 0
        assert bounds.input_bound <= values[-1] <= bounds.input_bound * (1 + F(1, 1 << 46))


def test_psi_is_above_every_input_of_the_law_at_a_nearer_state() -> None:
    """States, widths, errors of measurement and rounding are drawn from what the bounds allow; psi is nearly reached."""
    rng, gaps = random.Random(6), []
    for _ in range(40):
        bounds = draw_bounds(rng)
        for level in (0.02, 0.1, 0.3, 0.6):
            bound = float(psi(bounds, level * float(bounds.narrow)))
            largest = -math.inf
            for corner in range(200):
                at_corner = rng.random() < 0.5
                width = rng.choice((bounds.narrow, bounds.wide)) if at_corner else rng.uniform(bounds.narrow, bounds.wide)
                b = level * float(bounds.narrow) * (1 if corner % 2 else rng.random())
                shift = [float(bounds.shift) * (rng.choice((-1, 1)) if at_corner else rng.uniform(-1, 1)) for _ in range(2)]
                largest = max(largest, law(bounds, float(width) - b + shift[0], b + shift[1], rng))
            assert largest <= bound + 1e-12 * float(bounds.input_bound)
            gaps.append((bound - largest) / float(bounds.input_bound))
    assert min(gaps) < 1e-4


def law(bounds: PathBounds, a: float, b: float, rng: random.Random) -> float:
    """Return the emitted law's input at measured distances, with rounding within its bound, limited to |u| <= U."""
    width, clamp, r = a + b, float(1 - bounds.e_max) / 2, float(bounds.rounding)
    near = max(min(a, b), width * clamp)
    far = width - near
    size = (1 / far + 1 / near) * (math.log(far / near) + r * rng.uniform(-1, 1)) * (1 + r * rng.uniform(-1, 1))
    limit = float(bounds.input_bound)
    return min(max((-1 if b < a else 1) * float(bounds.gain) * size, -limit), limit)


# ---------------------------------------------------------------------------------------------------------- drives


def test_the_decay_is_above_the_exponential_and_close() -> None:
    for x in (F(1, 200), F(1, 20), F(1), F(5)):
        value = decay_above(x) / SHARE_ONE
        assert math.exp(-x) <= value <= math.exp(-x) + (1e-12 if x < 1 else 0.2)


@pytest.mark.parametrize(
    "drive",
    [
        Drive((F(1, 10),)),
        Drive((F(1, 10), F(1, 20))),
        Drive(slew=F(20)),
        Drive((F(1, 10),), F(30)),
        Drive((F(1, 10),), overshoot=F(1, 10)),
    ],
)
def test_what_acts_stays_below_the_drives_bound(drive: Drive) -> None:
    """Commands stay below a bound that falls from cell to cell. Lags vary below theirs, and slews above theirs."""
    rng, cell, unit, limit = random.Random(7), F(1, 100), F(1, 1 << 40), 1 << 40
    cells, bound = DriveCells(drive, limit, unit, cell), limit
    weight = float(drive.opposite_weight)
    ramp, stages, delayed = 1.0, [1.0] * len(drive.lags), 1.0
    previous = cells.acting(bound)
    for k in range(150):
        bound -= rng.randrange(limit // 30) if k < 60 else 0
        assert cells.acting(bound) <= previous
        previous = cells.acting(bound)
        u = bound / limit - (0 if k % 2 else rng.random() / 10)
        for _ in range(10):  # parts of the cell
            dt = float(cell) / 10
            source = u
            if drive.slew is not None:
                ramp = max(u, ramp - float(drive.slew) * rng.uniform(1, 2) * dt) if ramp > u else u
                source = ramp
            for j, lag in enumerate(drive.lags):
                stages[j] = source + (stages[j] - source) * math.exp(-dt / (float(lag) * rng.uniform(0.3, 1)))
                source = stages[j]
            delayed = min(delayed, u) if weight else 0.0
            acting = source + weight * (source - rng.uniform(-1, 1))
            assert acting <= cells.acting(bound) / limit + 1e-9
        cells.step(bound)


def test_an_ideal_drive_follows_its_command_at_once() -> None:
    cells = DriveCells(Drive(), 100, F(1), F(1, 100))
    assert [cells.acting(v) for v in (100, 20, -50)] == [100, 20, -50]
    assert Drive(overshoot=F(1, 5)).amplification == F(3, 2)
    assert Drive((F(1), F(2)), F(8)).scaled(F(2)) == Drive((F(2), F(4)), F(4))


# ---------------------------------------------------------------------------------------------------------- the path


def slow_path(bounds: PathBounds, start: Start, first_level: Fraction) -> list[Fraction]:
    """Follow the path in fractions as docs/sampling-path.md states it, with cells and first level as given; return its levels."""
    cell, wide, law_bounds = bounds.cell, bounds.wide, bounds
    drive, r = bounds.drive, bounds.rounding
    decays = [F(math.exp(-cell / lag)) for lag in drive.lags]

    def log_below(y: Fraction) -> Fraction:
        return F(0) if y == 1 else logarithm(y)[0] if y > 1 else -logarithm(1 / y)[1]

    def command(level: Fraction) -> Fraction:
        """Return Psi at a level."""
        near = level + bounds.shift
        far = bounds.narrow - near
        if far <= 0:
            return bounds.input_bound
        values = []
        clamp = (1 - bounds.e_max) / 2 * (wide + 2 * bounds.shift)
        for b, a in ((near, far), (clamp, wide + 2 * bounds.shift - clamp)):
            log = log_below(a / b) - r
            values.append(-law_bounds.gain * (1 / a + 1 / b) * log * (1 - r if log > 0 else 1 + r))
        lowest = -bounds.input_bound if bounds.u_max is None else -bounds.u_max
        return min(max(*values, lowest), bounds.input_bound)

    def at_time(levels: list[Fraction], time: Fraction) -> Fraction:
        if time < 0:
            return wide
        k = min(int(time / cell), len(levels) - 1)
        share = time / cell - k
        return levels[k] + share * (levels[min(k + 1, len(levels) - 1)] - levels[k])

    levels, ramp, stages, nu = [first_level], bounds.input_bound, [bounds.input_bound] * len(drive.lags), drive.opposite_weight
    slowest = bounds.closing_speed * cell / 64
    start_time = None
    while True:
        now, level = (len(levels) - 1) * cell, levels[-1]
        if start_time is None and level <= start.nearest:
            start_time = now
        c = command(at_time(levels, now - bounds.age)) if now >= bounds.age else bounds.input_bound
        if start_time is None or now - start_time < start.first_input:
            c = max(c, F(0))
        source = c if drive.slew is None else max(c, ramp)
        y = stages[-1] if stages else source
        y += nu * (y + bounds.input_bound)
        speed = bounds.closing_speed - bounds.filter_rate * level + (bounds.g_max if y > 0 else bounds.g_min) * y
        if start_time is not None and speed < 0:
            return levels
        smallest_fall = (
            slowest if start_time is not None else cell * (bounds.closing_speed + bounds.g_max * bounds.input_bound) / 16
        )
        level -= max(cell * speed / (1 - bounds.filter_rate * cell), smallest_fall, slowest)
        if level <= 0:
            return [*levels, F(0)]
        levels.append(level.limit_denominator(1 << 60))
        if drive.slew is not None:
            ramp = max(c, ramp - drive.slew * cell)
        for k, decay in enumerate(decays):
            before = stages[k]
            stages[k] = (source + (before - source) * decay).limit_denominator(1 << 60)
            source = before


def test_the_path_equals_a_slow_version_in_fractions_and_is_on_the_safe_side(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worst_path, "DELAY_CELLS", 24)
    monkeypatch.setattr(worst_path, "CROSSING_CELLS", 64)
    compared = 0
    for bounds, start in drawn(10):
        path = worst_path._Path(bounds, start)
        result = path.follow()
        levels = slow_path(bounds, start, path.first_level * path.length_unit)
        assert result.nearest <= levels[-1] + bounds.wide / (1 << 50)
        assert levels[-1] - result.nearest < bounds.wide * F(1, 10**8)
        if result.nearest:
            assert len(levels) == result.cells
            compared += 1
    assert compared >= 5


def test_finer_cells_do_not_bring_the_path_nearer(monkeypatch: pytest.MonkeyPatch) -> None:
    """A path in coarse cells is a path that falls faster, so finer ones end farther from the edge, by a small part of the width."""
    results = [(b, s, follow_worst_path(b, s).nearest) for b, s in drawn(25)]
    monkeypatch.setattr(worst_path, "DELAY_CELLS", 96 * 8)
    monkeypatch.setattr(worst_path, "CROSSING_CELLS", 512 * 8)
    monkeypatch.setattr(worst_path, "CELL_COUNT_LIMIT", 1 << 18)
    for bounds, start, nearest in results:
        finer = follow_worst_path(bounds, start).nearest
        assert finer >= nearest * (1 - F(1, 1000))
        assert finer - nearest < bounds.wide / 40


def test_harder_bounds_bring_the_path_nearer() -> None:
    """P, U, the age, the drive, noise and the start are raised one by one; the tolerance is for changed cells, and a path that falls
    faster at first also sees the edge earlier."""
    changes = {
        "closing_speed": lambda b: replace(b, closing_speed=b.closing_speed * F(21, 20)),
        "g_min": lambda b: replace(b, g_min=b.g_min * F(9, 10)),
        "narrow": lambda b: replace(b, narrow=b.narrow * F(19, 20)),
        "shift": lambda b: replace(b, shift=b.shift + b.narrow / 50),
        "age": lambda b: replace(b, age=b.age * F(5, 4)),
        "drive": lambda b: replace(b, drive=replace(b.drive, lags=(*b.drive.lags, b.age))),
    }
    for bounds, start in drawn(20, seed=2):
        nearest = follow_worst_path(bounds, start).nearest
        if nearest < bounds.wide / 50:
            continue
        for name, change in changes.items():
            assert follow_worst_path(change(bounds), start).nearest <= nearest + bounds.wide / 1000, name
        late = Start(start.nearest, start.first_input + bounds.age)
        assert follow_worst_path(bounds, late).nearest <= nearest + bounds.wide / 1000
        assert follow_worst_path(bounds, Start(start.nearest * F(3, 4), start.first_input)).nearest < nearest


def test_the_path_ends_where_nothing_moves_it_on_and_not_before_the_start() -> None:
    """For order 2 the path may turn round above the start; it must go on, or starts below would be forgotten."""
    gentle = replace(BOUNDS, filter_rate=F(2), closing_speed=F(1, 2), drive=Drive())
    for share in (20, 10, 4):
        start = Start(gentle.narrow / share, F(0))
        path = follow_worst_path(gentle, start)
        assert 0 < path.nearest <= start.nearest
    for bounds, start in drawn(40, seed=3):
        assert follow_worst_path(bounds, start).nearest <= start.nearest


def test_a_late_first_input_counts_in_every_cell_that_begins_before_it() -> None:
    """Also a latency shorter than a cell must have an effect: the cell after the start is clipped."""
    without_latency = replace(BOUNDS, age=F(1, 50))
    cell = without_latency.cell
    nearest = [follow_worst_path(without_latency, Start(START.nearest, F(k) * cell / 4)).nearest for k in (0, 1, 4, 5)]
    assert nearest[0] > nearest[1] == nearest[2] > nearest[3]


def test_the_path_of_recent_bounds_ends_only_where_the_speed_at_the_edge_is_negative() -> None:
    """Without lambda there is no difference; with it the path of recent bounds comes nearer."""
    farther = 0
    for bounds, _ in drawn(40, seed=4):
        recent = follow_worst_path(bounds)
        if not recent.nearest:
            continue
        assert recent.history is None or recent.history > bounds.age
        from_start = follow_worst_path(bounds, Start(bounds.narrow * F(49, 100), F(0)))
        if not bounds.filter_rate:
            assert recent.nearest >= from_start.nearest * F(999, 1000)
        farther += recent.nearest < from_start.nearest
    assert farther


def test_a_path_that_proves_nothing_has_no_rho() -> None:
    assert follow_worst_path(replace(BOUNDS, input_bound=F(1, 10), u_max=F(1, 10)), START).rho(BOUNDS.wide) is None
    assert follow_worst_path(replace(BOUNDS, shift=BOUNDS.narrow), START).nearest == 0
    path = follow_worst_path(BOUNDS, START)
    assert path.rho(BOUNDS.wide) == BOUNDS.wide / path.nearest - 1


# ------------------------------------------------------------------------------------------------------ whole loops


def window(speed: float, narrow: float, wide: float, cross: tuple[Fraction, ...] = (F(0),)) -> WindowBounds:
    return WindowBounds(closing_speed=F(speed), cross=cross, g_min=F(1), g_max=F(1), narrow=F(narrow), wide=F(wide))


def loop_of_windows(windows: list[WindowBounds], drive: Drive = BOUNDS.drive, **law: Fraction) -> PathLoop:
    """Return a loop of one component whose windows last half a second each."""
    values = {
        "gain": F(1, 25), "e_max": F(99, 100), "shift": F(1, 200), "u_max": F(2), "rounding": F(1, 1 << 19),
        "filter_rate": F(0), "rho_at_start": F(19),
    }  # fmt: skip
    component = ComponentLaw(**(values | law))
    begins = tuple(F(k, 2) for k in range(len(windows)))
    return PathLoop(
        begins=begins,
        windows=(tuple(windows),),
        laws=(component,),
        drives=(drive,),
        age=F(1, 50),
        latency=F(0),
        largest_known_age=math.inf,
    )


SLOW_WIDE = [window(0.35, 0.8, 0.8)] * 6
FAST_WIDE = [window(1.5, 1.6, 1.6)] * 6


def test_recent_bounds_prove_what_bounds_of_the_whole_time_do_not() -> None:
    loop = loop_of_windows(SLOW_WIDE + [window(0.6, 1.2, 1.2)] * 4 + FAST_WIDE)
    assert follow_from_start(loop, 0, [F(2)]) is None
    path = follow_local_paths(loop, 0, [F(2)])
    assert path is not None
    assert path.history is not None
    proof = prove_path(loop)
    assert proof is not None
    assert proof.paths[0].history is not None
    assert proof.rho[0] > proof.paths[0].rho
    assert proof.rho[0] > 19


def test_bounds_older_than_the_history_do_not_matter_but_the_inputs_of_all_time_do() -> None:
    gentle = loop_of_windows([window(0.5, 1.0, 1.0)] * 12)
    path = follow_local_paths(gentle, 0, [F(2)])
    assert path is not None
    assert path.history is not None
    last = len(gentle.begins) - 1
    old = gentle.window_at(gentle.begins[last] - path.history)
    assert 0 < old < last
    harder = loop_of_windows([window(0.9, 0.9, 1.1)] * old + [window(0.5, 1.0, 1.0)] * (last + 1 - old))
    assert harder.bounds_over(0, old, last, [F(2)]) == gentle.bounds_over(0, old, last, [F(2)])
    unlimited = loop_of_windows([window(0.9, 0.9, 1.1)] * old + [window(0.5, 1.0, 1.0)] * (last + 1 - old), u_max=None)
    assert unlimited.input_bound(0, F(50)) == unlimited.laws[0].input_bound(F(0.9), F(50))  # of the first, narrowest window


def test_the_proof_of_a_loop_holds_for_its_own_rho_and_for_no_smaller_one_of_the_paths() -> None:
    loop = loop_of_windows(SLOW_WIDE, u_max=None)
    proof = prove_path(loop)
    assert proof is not None
    path = follow_from_start(loop, 0, proof.u)
    assert path == proof.paths[0]
    assert path is not None
    assert 19 < path.rho < proof.rho[0]
    assert prove_path_for(loop, proof.rho) == proof
    assert prove_path_for(loop, [proof.rho[0] * F(99, 100)]) is None
    bound = loop.input_bound(0, proof.rho[0])
    assert bound is not None
    assert bound <= proof.u[0] <= bound * F(100001, 100000)


def test_inputs_of_other_components_count_with_their_overshoot() -> None:
    cross = (F(0), F(1, 10))
    drives = (Drive(), Drive(overshoot=F(1, 5)))
    base = loop_of_windows([window(0.5, 1.0, 1.0, cross)])
    loop = replace(base, windows=base.windows * 2, laws=base.laws * 2, drives=drives)
    assert loop.bounds_over(0, 0, 0, [F(1), F(2)]).closing_speed == F(1, 2) + F(1, 10) * 2 * F(3, 2)


def test_a_component_that_little_moves_has_a_path_that_ends() -> None:
    """P is raised to a part of its largest value, or of what the input moves, and never lowered."""
    moving = loop_of_windows([window(0, 0.6, 0.6), window(0.005, 0.6, 0.6), window(0.5, 1.0, 1.0)])
    assert [moving.bounds_over(0, k, k, [F(2)]).closing_speed for k in range(3)] == [F(1, 100), F(1, 100), F(1, 2)]
    at_rest = loop_of_windows([window(0, 0.6, 0.6)] * 6)
    assert at_rest.bounds_over(0, 0, 5, [F(2)]).closing_speed == F(1, 128)
    proof = prove_path(at_rest)
    assert proof is not None
    assert proof.rho[0] < 20  # a run is hardly pushed from its start, where rho is 19


def test_a_plant_whose_bounds_are_not_known_for_such_an_age_is_not_proved() -> None:
    loop = loop_of_windows(SLOW_WIDE)
    assert prove_path(loop) is not None
    assert prove_path(replace(loop, largest_known_age=F(1, 100))) is None


def test_searches_return_the_largest_value_that_is_proved() -> None:
    assert largest_proved(lambda v: v <= F(3, 7), F(1)) == pytest.approx(3 / 7, rel=2**-11)
    assert largest_proved(lambda v: v <= F(30), F(1)) == pytest.approx(30, rel=2**-11)
    assert largest_proved(lambda _: False, F(1)) is None
    loop = loop_of_windows(SLOW_WIDE)
    period = longest_path_period(loop, F(1, 10))
    assert period is not None
    assert prove_path(loop.with_period(period)) is not None
    assert prove_path(loop.with_period(period * F(101, 100))) is None


# ---------------------------------------------------------------------------------------------------------- attacks


@pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.label)
def test_no_adversary_breaks_what_the_path_proves(family) -> None:
    result = attack(family, 3, seed=5)
    assert result.loops == 3
    assert result.violations == 0
    assert result.closest < 1


@pytest.mark.parametrize(("omitted", "family", "seed"), [("start", 0, 1), ("age", 0, 2), ("input", 0, 1), ("first", 2, 1)])
def test_the_attack_breaks_a_statement_that_leaves_a_part_out(omitted: str, family: int, seed: int) -> None:
    assert attack(FAMILIES[family], 12, seed, omitted=omitted).broken_loops > 0
