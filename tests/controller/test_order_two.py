"""Plants of order 2: the filtered tube (bounds on v + lambda x), its proof, the emitted code, and closed loops with inertia."""

from __future__ import annotations

import hashlib
import json
import random
import re
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stt_codegen as stt
from benchmarks.suites.remedies import follow_remedies, refusal_of
from stt_codegen.certify.filtered_findings import distance_errors, filtered_width_slack, input_slack, start_slack
from stt_codegen.checker import check_files
from stt_codegen.compare.comparison import compare
from stt_codegen.controller.edge_errors import edge_error, rate_error
from stt_codegen.designs.filtered import demanded_accelerations, filtered_edges
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.effort import Effort
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.foretold import describe_proof, drives_of
from stt_codegen.loop.plants_at_bounds import corner_plants
from stt_codegen.loop.simulate import DISTURBANCES, Loop, Scenario
from stt_codegen.loop.simulate import random_start as draw_start
from stt_codegen.pipeline import EmittedController, build_task, certify
from stt_codegen.plants import PLANTS, plant_of
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.report.analysis import Analysis
from stt_codegen.sampling.loops import exact_loop, loop_of
from stt_codegen.sampling.numbers import FRACTIONS
from stt_codegen.sampling.order_two import inertial_start_bound
from stt_codegen.sampling.periods import inputs_where_proved, longest_proved_period
from stt_codegen.task.load import parse_task
from tests.support.controllers import ROOT, build_once

INERTIAL = ("arm", "drone")  # two tasks of order 2; tests/loop/test_robots.py tests all

ORDER_TWO = "\n[plant]\norder = 2\nw_max = 0.3\n"
TEXTS = {  # by case: an example task, the lines of its [control], and what follows
    "plain": ("omni_s2", "", ORDER_TWO),
    "limited": ("omni_s2", "u_max = [3, 3.5]\n", ORDER_TWO),
    "sampled": ("omni_s2", "period = 0.04\nu_max = [2.4, 2.9]\n", ORDER_TWO),
    "space": ("spacecraft", "", ORDER_TWO + "g_min = 0.9\ng_max = 1.1\n"),
    "noisy": ("omni_s2", "period = 0.02\nu_max = [3, 3.5]\nlatency = 0.002\n", ORDER_TWO + "noise = 0.001\nnoise_v = 0.005\n"),
    "doubles": ("omni_s2", "", ORDER_TWO + '[emit]\nscalar = "double"\nmath = "inline"\ntick_period = 0.01\n'),
    "own filter": ("omni_s2", "", "\n[tube]\nfilter = [1.4, 2]\nmin_width = 0.2" + ORDER_TWO),
    "moving starts": ("omni_s2", "", ORDER_TWO),
    **{name: (name, "", "") for name in INERTIAL},
}


def text_of(name: str) -> str:
    """Return a task file of order 2: an example task with the control and plant of the case."""
    task, control, more = TEXTS[name]
    text = (ROOT / "tasks" / f"{task}.toml").read_text()
    if name in INERTIAL:
        return text
    head = text[: text.index("[tube]")] if "[tube]" in text else text[: text.index("[control]")] if "[control]" in text else text
    if name == "moving starts":
        head = head.replace("upper = [0.5, 0.5]", "upper = [0.5, 0.5]\nspeed = 0.02\nshare = 0.7")
    return head + (f"[control]\n{control}" if control else "") + more


@cache
def controller_of_case(name: str) -> EmittedController:
    """Return the controller of a case."""
    return build_once(parse_task(text_of(name)))


def write_for_checker(controller: EmittedController, name: str, folder: Path, **changes: Any) -> list[str]:
    """Write the controller's files, with these entries of the certificate changed, and return the checker's arguments."""
    task = controller.task.name
    for file, data in controller.files.items():
        (folder / file).write_bytes(data)
    proof = folder / f"{task}.certificate.json"
    if changes:
        proof.write_text(json.dumps({**json.loads(proof.read_text()), **changes}))
    (folder / "task.toml").write_text(text_of(name))
    return [str(folder / "task.toml"), str(folder / f"{task}.c"), str(proof)]


def edges(design: RefinedDesign, t: np.ndarray) -> list[np.ndarray]:
    """Return lower and upper edge, their rates and their second derivatives, each (P, n), at times t within [0, t_c]."""
    table, t_c = design.integers() * float(design.unit), float(design.prescribed_time)
    u = t / t_c * design.segments
    k = np.minimum(u.astype(int), design.segments - 1)
    s = u - k
    weights = [
        np.stack([(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3]),
        np.stack([-3 * (1 - s) ** 2, 9 * s**2 - 12 * s, -9 * s**2 + 6 * s + 3, 3 * s**2]),
        np.stack([6 * (1 - s), 18 * s - 12, -18 * s + 6, 6 * s]),
    ]
    result = []
    for d, w in enumerate(weights):
        value = sum(w[j][:, None, None] * table[k + j] for j in range(4)) * (design.segments / t_c) ** d
        result += [value[..., 0], value[..., 1]]
    return result


# ------------------------------------------------------------------------------------------------ the tube


@pytest.mark.parametrize("name", TEXTS)
def test_certified_margins_are_below_sampled_ones_and_not_far_below(name: str) -> None:
    """No margin exceeds the one at 20,001 times; it is a little smaller, because pieces are bounded by their Bezier hulls."""
    controller = controller_of_case(name)
    design, task = controller.design, controller.task
    assert isinstance(design, RefinedDesign)
    assert controller.certificate.holds
    t = np.linspace(0, float(design.prescribed_time), 20_001)
    low, high, low_rate, high_rate, low_bend, high_bend = edges(design, t)
    filter_ = np.array([float(v) for v in design.filter])
    sampled_width = ((high_rate - low_rate) + filter_ * (high - low)).min()
    slack = filtered_width_slack(design)
    assert float(slack.units * slack.unit) <= sampled_width + 1e-9
    assert float(slack.units * slack.unit) >= 0.9 * sampled_width - 1e-5
    assert (low_rate[0] <= 1e-12).all()
    assert (high_rate[0] >= -1e-12).all()
    for values in (low_rate, high_rate, low_bend, high_bend):
        assert np.abs(values[-1]).max() < 1e-9  # the tube stands from t_c on, and its acceleration does not jump
    acceleration = np.maximum(filter_**2 * (high - low) + low_bend, filter_**2 * (high - low) - high_bend).max(axis=0)
    margin = input_slack(task, design)
    if margin is not None:
        sampled_margin = np.array([float(v) for v in task.u_max or ()]) - float(task.plant.w_max or 0) - acceleration
        assert 0 < float(margin.units * margin.unit) <= sampled_margin.min() + 1e-6


def test_the_exact_bezier_pieces_are_those_of_the_spline() -> None:
    design = controller_of_case("plain").design
    assert isinstance(design, RefinedDesign)
    t = (np.arange(design.segments) + 0.37) * float(design.prescribed_time) / design.segments
    low, high, low_rate, high_rate, low_bend, high_bend = edges(design, t)
    filter_ = np.array([float(v) for v in design.filter])
    weight = np.array([0.63**3, 3 * 0.63**2 * 0.37, 3 * 0.63 * 0.37**2, 0.37**3])
    filtered_lower, filtered_upper = np.moveaxis((filtered_edges(design).floats() * weight).sum(axis=-1), 2, 0)
    # 1e-11 allows for a hundred roundings of numbers below 20.
    np.testing.assert_allclose(filtered_lower, low_rate + filter_ * low, rtol=0, atol=1e-11)
    np.testing.assert_allclose(filtered_upper, high_rate + filter_ * high, rtol=0, atol=1e-11)
    lower, upper = np.moveaxis((demanded_accelerations(design).floats() * weight).sum(axis=-1), 2, 0)
    np.testing.assert_allclose(lower, filter_**2 * (high - low) + low_bend, rtol=0, atol=1e-10)
    np.testing.assert_allclose(upper, high_bend - filter_**2 * (high - low), rtol=0, atol=1e-10)


def test_a_users_tube_gets_a_filter_too() -> None:
    """The designed control points as a user's tube give the same files; a tube that does not stop is refused."""
    controller = controller_of_case("plain")
    assert isinstance(controller.design, RefinedDesign)
    points = controller.design.integers() * 6.0 * float(controller.design.unit)
    user_controller = stt.certify_tube(controller.task, points=points)
    assert user_controller.files == controller.files
    points[-2, 0] += 0.01
    with pytest.raises(BadInput, match="make the last three equal"):
        stt.certify_tube(controller.task, points=points)


def test_limits_on_the_edges_are_kept() -> None:
    text = text_of("plain").replace(ORDER_TWO, "\n[tube]\nmax_speed = 1.2\nmax_acceleration = [0.9, 0.7]\n" + ORDER_TWO)
    controller = build_once(parse_task(text))
    assert isinstance(controller.design, RefinedDesign)
    *_, low_rate, high_rate, low_bend, high_bend = edges(controller.design, np.linspace(0, 9, 5001))
    assert np.abs([low_rate, high_rate]).max() <= 1.2
    assert (np.abs([low_bend, high_bend]).max(axis=(0, 1)) <= [0.9, 0.7]).all()
    with pytest.raises(NotCertified, match="certified with .*tube.max_acceleration = "):
        build_once(parse_task(text.replace("[0.9, 0.7]", "0.1")))


def test_starts_are_certified_up_to_their_stated_speed() -> None:
    controller = controller_of_case("moving starts")
    errors = distance_errors(controller.design, controller.certificate.edge_error, controller.certificate.rate_error)  # type: ignore[arg-type]
    slack = start_slack(controller.task, controller.design, errors)  # type: ignore[arg-type]
    assert slack.units >= 0
    faster = parse_task(text_of("moving starts").replace("speed = 0.02", "speed = 0.3"))
    with pytest.raises(NotCertified, match="certified with initial_set.speed = "):
        build_once(faster)


# ------------------------------------------------------------------------------------------------ proofs


@pytest.mark.parametrize("name", TEXTS)
def test_the_checker_accepts_what_is_certified(name: str, tmp_path: Path) -> None:
    assert check_files(write_for_checker(controller_of_case(name), name, tmp_path)) == 0


@pytest.mark.parametrize("name", ["plain", "limited", "sampled"])
def test_the_checker_refuses_a_changed_certificate_or_c(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    controller = controller_of_case(name)
    proof = json.loads(controller.files["omni_s2.certificate.json"])
    wrong_filter = [str(Fraction(v) * Fraction(5, 4)) for v in proof["filter"]]
    changes: list[dict[str, Any]] = [
        {"order": 1},
        {"filter": wrong_filter},
        {"filter": proof["filter"][:1]},
        {"rate_error": [v - 1 for v in proof["rate_error"]]},
        {"claims": [c for c in proof["claims"] if c.get("order") != 2]},
    ]
    for k, claim in enumerate(proof["claims"]):
        if claim.get("order") == 2 or claim["property"] == "P8":
            claims = [{**c, "margin": c["margin"] + (k == j)} for j, c in enumerate(proof["claims"]) if "margin" in c]
            changes.append({"claims": claims})
    if "sampled" in proof:
        changes += [
            {"sampled": {**proof["sampled"], field: [str(Fraction(v) * Fraction(9, 10)) for v in proof["sampled"][field]]}}
            for field in ("rho", "u", "shift")
        ]
    for change in changes:
        assert check_files(write_for_checker(controller, name, tmp_path, **change)) == 1, change
    assert "checker: refused" in capsys.readouterr().out
    source = (tmp_path / "omni_s2.c").read_text()
    for old, new in (("v_i - lower_rate", "v_i - upper_rate"), ("* filter_i", "* x_i"), ("v[k]", "x[k]")):
        assert old in source
        write_for_checker(controller, name, tmp_path)
        (tmp_path / "omni_s2.c").write_text(source.replace(old, new, 1))
        proof_path = tmp_path / "omni_s2.certificate.json"
        signed = json.loads(proof_path.read_text())
        signed["sha256"]["omni_s2.c"] = hashlib.sha256((tmp_path / "omni_s2.c").read_bytes()).hexdigest()
        proof_path.write_text(json.dumps(signed))
        assert check_files([str(tmp_path / "task.toml"), str(tmp_path / "omni_s2.c"), str(proof_path)]) == 1, old


def test_a_changed_table_is_certified_only_if_samples_agree() -> None:
    """Whenever the tool certifies a table with a changed number, 4001 times show a positive width, starts at rest and a smooth stop."""
    controller, draw = controller_of_case("plain"), random.Random(5)
    design, certified_count = controller.design, 0
    assert isinstance(design, RefinedDesign)
    for _ in range(60):
        table = [[list(pair) for pair in row] for row in design.table]
        j = draw.choice((0, 1, 2, draw.randrange(len(table)), len(table) - 1, len(table) - 2))
        i, side = draw.randrange(2), draw.randrange(2)
        table[j][i][side] += draw.choice((-1, 1)) * draw.choice((1, 40, 3000, 60000))
        mutant = replace(design, table=tuple(tuple((a, b) for a, b in row) for row in table))
        certificate = certify(controller.task, mutant, controller.program)
        if not certificate.holds:
            continue
        certified_count += 1
        low, high, low_rate, high_rate, low_bend, high_bend = edges(mutant, np.linspace(0, 9, 4001))
        filter_ = np.array([float(v) for v in mutant.filter])
        assert ((high_rate - low_rate) + filter_ * (high - low)).min() > 0
        assert (low_rate[0] <= 1e-12).all()
        assert (high_rate[0] >= -1e-12).all()
        assert max(np.abs(v[-1]).max() for v in (low_rate, high_rate, low_bend, high_bend)) < 1e-9
    assert certified_count


# ------------------------------------------------------------------------------------------------ emitted code


@pytest.mark.parametrize("name", ["plain", "doubles", "sampled", *INERTIAL])
def test_every_backend_is_within_its_bound(name: str) -> None:
    rows = compare(controller_of_case(name).task, 600)
    assert {"filtered tube", "margin", "u", "status"} <= {row.quantity for row in rows}
    assert [row for row in rows if not row.holds] == []


@settings(max_examples=200, deadline=None)
@given(st.tuples(*[st.integers(0, 2**32 - 1)] * 5))
def test_u_is_finite_for_every_bit_pattern(bits: tuple[int, ...]) -> None:
    backend = compiled_controller()
    t, *state = np.array(bits, dtype=np.uint32).view(np.float32)
    status, u = backend.call("control", np.array([t]), np.array([state[:2]]), np.array([state[2:]]))
    assert np.isfinite(u).all()
    is_bad = not np.isfinite([t, *state]).all()
    assert (status[0] == 2) == is_bad
    if is_bad:
        assert (u == 0).all()
    (margin,) = backend.call("margin", np.array([t]), np.array([state[:2]]), np.array([state[2:]]))
    assert np.isnan(margin[0]) if is_bad else -1 <= margin[0] <= 0.5
    if status[0] == 0:
        assert margin[0] > 0
    (margins,) = backend.call("margins", np.array([t]), np.array([state[:2]]), np.array([state[2:]]))
    for i, value in enumerate(margins[0]):  # a NaN of v alone is seen too
        component = [t, state[i], state[2 + i]]
        if np.isnan(component).any() or np.isinf(t):
            assert np.isnan(value)
        elif np.isfinite(component).all():
            assert -1 <= value <= 0.5


@cache
def compiled_controller() -> CompiledC:
    """Return the plain case's controller in compiled C."""
    return CompiledC(controller_of_case("plain"))


def test_the_interface_takes_x_and_v() -> None:
    controller = stt.build(parse_task(text_of("plain")))
    status, u = controller.control([0.0, 0.1], [[0.1, 0.4], [0.2, 0.3]], [[0.0, 0.0], [0.1, 0.0]])
    assert status.tolist() == [0, 0]
    assert u[0, 0] > 0 > u[0, 1]
    lower, upper = controller.filtered_tube(0.0)
    low, high = controller.tube(0.0)
    assert 0.3 < controller.margin(0.0, (low + high) / 2, [0.0, 0.0]) <= 0.5  # an edge that recedes at 0 leaves more distance
    assert (lower < upper).all()
    with pytest.raises(BadInput, match="v: is missing"):
        controller.control(0.0, [0.1, 0.4])
    first = stt.build(ROOT / "tasks" / "omni_s2.toml")
    with pytest.raises(BadInput, match="order 1"):
        first.control(0.0, [0.1, 0.4], [0.0, 0.0])
    with pytest.raises(BadInput, match="order 1"):
        first.filtered_tube(0.0)


# ------------------------------------------------------------------------------------------------ loops


@pytest.mark.parametrize("name", ["sampled", "noisy", *INERTIAL])
def test_no_loop_leaves_at_the_proved_period_and_some_do_at_32_times_it(name: str) -> None:
    """The worst plants within [plant] start at rest in and at the corners of the start share, with disturbances; e stays within the
    bound of P9."""
    controller = controller_of_case(name)
    task, proved = controller.task, controller.certificate.proved_period
    assert proved is not None
    force = float(min(b.force for b in task.plant_bounds))
    rate, e_bounds = 1 / float(proved.period), [float((r - 1) / (r + 1)) for r in proved.rho]
    noise = (float(task.plant.noise or 0), float(task.plant.noise_v or 0))
    for model in corner_plants(task):
        loop = Loop(controller, model)
        for k in range(15):
            start = draw_start(controller.certificate.start, float(task.initial_set.share), k, corner=k % 2 == 0)
            run = loop.run(
                Scenario(
                    rate=rate,
                    disturbance=DISTURBANCES[1 + k % 5],
                    strength=force,
                    seed=k,
                    noise=noise[0],
                    noise_v=noise[1],
                    start=start,
                    latency=float(task.control.latency),
                )
            )
            assert run.kept
            assert run.good
            assert all(e <= bound * (1 + 1e-6) for e, bound in zip(run.e, e_bounds, strict=True))
        slow_runs = [
            loop.run(
                Scenario(
                    rate=rate / 32,
                    disturbance=DISTURBANCES[1 + k % 5],
                    strength=force,
                    seed=k,
                    start=draw_start(controller.certificate.start, float(task.initial_set.share), k),
                )
            )
            for k in range(5)
        ]
        assert any(not run.kept for run in slow_runs)


def test_the_period_in_fractions_is_the_one_of_the_search() -> None:
    controller = controller_of_case("sampled")
    task, design, program = controller.task, controller.design, controller.program
    assert isinstance(design, RefinedDesign)
    errors = edge_error(design, program), rate_error(design, program)
    longest = longest_proved_period("sharp", loop_of(task, design, *errors))
    assert longest is not None

    def holds(seconds: float) -> bool:
        period = Fraction(f"{seconds:.12g}")
        with_period = task.model_copy(update={"control": task.control.model_copy(update={"period": period})})
        rho = tuple(Fraction(str(np.exp(v) * (1 + 1e-9))) for v in longest.eps_bound)
        limit = [(1 + e) / (1 - e) for e in with_period.e_max]
        loop, age = exact_loop(with_period, design, *errors), period + with_period.control.latency
        return inputs_where_proved(loop, tuple(map(min, rho, limit)), age) is not None

    assert holds(longest.seconds * 0.999)
    assert not holds(longest.seconds * 1.01)


def test_a_period_that_is_too_long_is_refused_with_a_remedy_that_works() -> None:
    task = parse_task(text_of("sampled").replace("period = 0.04", "period = 0.4"))
    assert re.match(r"period \(P9\): control.period = 0.4 s is too long; 0\.\d+ s is the longest", refusal_of(task))
    assert ["control.period"] in [list(remedy) for remedy in follow_remedies(task)]


def test_limits_that_are_too_low_are_refused_with_a_remedy_that_works() -> None:
    task = parse_task(text_of("limited").replace("[3, 3.5]", "0.6"))
    assert refusal_of(task).startswith("limits (P8): ")
    assert follow_remedies(task)


def test_a_plant_of_order_two_is_a_file_with_x_and_v(tmp_path: Path) -> None:
    path = tmp_path / "cart.py"
    path.write_text("def f(x, v):\n    return [-0.1 * v[0], -0.1 * v[1]]\n\n\ndef g(x, v):\n    return [[1, 0], [0, 1]]\n")
    controller = controller_of_case("plain")
    assert Loop(controller, plant_of(str(path), 2, 2)).run(Scenario(rate=200.0, disturbance="outward", strength=0.2)).good
    with pytest.raises(BadInput, match="of order 2, the task of order 1"):
        plant_of(str(path), 2)
    with pytest.raises(BadInput, match="of order 1, the task of order 2"):
        plant_of("arm", 2, 2)
    assert Loop(controller, PLANTS["integrator"]).run(Scenario(rate=200.0, start=(0.1, 0.1, 0.05, 0.05))).good


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ("[tube]\nfilter = 1\n", ["tube.filter", "order 2"]),
        ("[plant]\nnoise_v = 0.1\n", ["plant.noise_v", "order 2"]),
        ("[plant]\norder = 3\n", ["plant.order"]),
        ("[plant]\norder = true\n", ["plant.order", "boolean"]),
        ("[tube]\nfilter = [1, 0]\n[plant]\norder = 2\n", ["tube.filter[1]", "greater than 0"]),
        ("[tube]\nfilter = [1, 2, 3]\n[plant]\norder = 2\n", ["tube.filter", "3 entries"]),
        ('[tube]\ndesign = "adaptive"\n[plant]\norder = 2\n', ["plant.order", "refined"]),
    ],
)
def test_an_option_that_does_not_fit_the_order_is_refused(tables: str, words: list[str]) -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    with pytest.raises(BadInput) as refusal:
        parse_task(text[: text.index("[tube]")] + tables)
    assert all(word in str(refusal.value) for word in words), refusal.value


def test_a_lag_is_simulated_and_reported_as_not_proved() -> None:
    """v follows the lag's exact solution for held inputs; the notes before the loop say that nothing is proved."""
    controller = controller_of_case("plain")
    drives = drives_of(0.3, controller.task)
    run = Loop(controller, PLANTS["integrator"]).run(Scenario(rate=100.0, drives=drives), trace=True)
    without_lag = Loop(controller, PLANTS["integrator"]).run(Scenario(rate=100.0), trace=True)
    assert run.trace is not None
    assert without_lag.trace is not None
    n, rows = 2, run.trace
    u, v, t = rows[:, 1 + n : 1 + 2 * n], rows[:, -1 - n : -1], rows[:, 0]
    lagged_input, velocity = np.zeros(n), np.zeros(n)
    for k in range(100):
        h = t[k + 1] - t[k]
        lag_integral = 0.3 * (1 - np.exp(-h / 0.3))
        velocity = velocity + u[k] * h + (lagged_input - u[k]) * lag_integral
        lagged_input = u[k] + (lagged_input - u[k]) * np.exp(-h / 0.3)
        np.testing.assert_allclose(v[k + 1], velocity, rtol=0, atol=1e-9)  # the steps of the loop, a few milliseconds each
    assert not np.allclose(rows, without_lag.trace)
    notes = describe_proof(controller, PLANTS["integrator"], Scenario(rate=100.0, drives=drives))
    assert notes == ["not proved: u acts through a drive with a lag of 0.3 s, and the task states none; put it into [plant]"]


def test_the_bound_on_e_is_never_below_its_value_at_the_start() -> None:
    """This also holds for a tube whose edges both recede at 0, where v + lambda x is nearer to the middle than x is."""
    controller = controller_of_case("sampled")
    assert isinstance(controller.design, RefinedDesign)
    table = [[list(pair) for pair in row] for row in controller.design.table]
    for j, row in enumerate(table):
        for pair in row:
            pair[0] += 600 if j in (0, 1) else 0
            pair[1] -= 600 if j in (0, 1) else 0
    design = replace(controller.design, table=tuple(tuple((a, b) for a, b in row) for row in table))
    share = controller.task.initial_set.share
    start_ratio = (1 + share) / (1 - share)
    ratios = inertial_start_bound(controller.task, design, numbers=FRACTIONS)
    assert min(ratios) >= start_ratio
    proved = controller.certificate.proved_period
    assert proved is not None
    assert all(rho > start_ratio for rho in proved.rho)
    eps = inertial_start_bound(controller.task, design)
    assert (eps >= np.log(float(start_ratio)) * (1 - 1e-12)).all()


def test_the_notes_before_a_loop_name_its_starts() -> None:
    controller = controller_of_case("plain")
    assert Analysis(controller).starts.endswith("and at rest")
    assert "|v(0)| <= 0.02" in Analysis(controller_of_case("moving starts")).starts
    notes = describe_proof(controller, None, Scenario(rate=1000.0, start=(0.25, 0.25, 0.01, 0.0)))
    assert notes[-1].startswith("proved from this start")


def test_where_no_limit_outweighs_the_coupling_the_refusal_asks_for_less_coupling() -> None:
    text = text_of("limited").replace(ORDER_TWO, ORDER_TWO + "g_cross = {}\n")
    coupled = parse_task(text.format(1))
    assert "f, w and coupling take all of u_max = " in refusal_of(coupled)
    assert [list(remedy) for remedy in follow_remedies(coupled)] == [["plant.g_cross"]]
    remedies = follow_remedies(parse_task(text.format(0.3)).changed(control={"u_max": "0.8"}))
    assert ["control.u_max"] in [list(remedy) for remedy in remedies]


@pytest.mark.parametrize(("speed", "rate"), [("0.3", "[tube]\nfilter = 0.8"), ("5", "")])
def test_a_start_faster_than_the_tube_bears_is_refused_with_a_speed_that_it_bears(speed: str, rate: str) -> None:
    """With a period: the distance to an edge of v + lambda x is not positive, so that rho at the start is infinite."""
    text = f"""
name = "t"
prescribed_time = 7
initial_state = [0.5]
state_space = {{ lower = [0], upper = [5] }}
initial_set = {{ lower = [0.1], upper = [0.9], speed = {speed} }}
target_set = {{ lower = [4.1], upper = [4.9] }}
control = {{ period = 0.03 }}
plant = {{ order = 2, w_max = 0.05 }}
{rate}
"""
    with pytest.raises(NotCertified, match=r"start \(P2\).*certified with initial_set\.speed = "):
        build_task(parse_task(text), effort=Effort(15.0))
