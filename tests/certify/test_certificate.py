"""The certificate of a refined tube against an oracle that shares no code with it: exact fractions at many times."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stt_codegen.certify.certificate import Certificate
from stt_codegen.certify.exact import certify_refined
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import EmittedController, build_program, build_task, certify
from stt_codegen.task.load import load_task
from stt_codegen.task.sets.shapes import UnsafeSet
from stt_codegen.task.task import Task
from tests.support.controllers import NAMES, ROOT, build_once, controller_of

SAMPLES_PER_SEGMENT = 5  # ends included


def exact_edges(design: RefinedDesign, k: int, s: Fraction) -> list[tuple[Fraction, Fraction]]:
    """Return lower and upper edge of each dimension at local time s (0 to 1) of segment k, by de Boor's recursion.

    The control points are 6 times the table's integers, in its unit; the knots are uniform."""
    result = []
    for i in range(design.dimension):
        pair = []
        for side in (0, 1):
            d = [6 * design.table[k + j][i][side] * design.unit for j in range(4)]
            for level in range(1, 4):
                for j in range(3, level - 1, -1):
                    a = (s + 3 - j) / (4 - level)
                    d[j] = (1 - a) * d[j - 1] + a * d[j]
            pair.append(d[3])
        result.append((pair[0], pair[1]))
    return result


def oracle(task: Task, design: RefinedDesign, margin: Fraction) -> dict[str, bool]:
    """Return which properties hold at the samples, with this margin: False is certain, True is not."""
    holds = dict.fromkeys(("P1", "P2", "P3", "P4", "P5"), True)
    n = task.dimension
    for k in range(design.segments):
        for step in range(SAMPLES_PER_SEGMENT):
            edges = exact_edges(design, k, Fraction(step, SAMPLES_PER_SEGMENT - 1))
            holds["P1"] &= all(b - a >= task.tube.min_width + 2 * margin for a, b in edges)
            holds["P3"] &= all(
                task.free_space.lower[i] + margin <= edges[i][0] and edges[i][1] + margin <= task.free_space.upper[i]
                for i in range(n)
            )
            distance = task.tube.clearance + margin
            holds["P4"] &= all(
                any(edges[i][1] + distance <= unsafe.lower[i] or edges[i][0] - distance >= unsafe.upper[i] for i in range(n))
                for unsafe in task.obstacles
            )
    start, end = exact_edges(design, 0, Fraction(0)), exact_edges(design, design.segments - 1, Fraction(1))
    for i in range(n):
        a, b = start[i]
        holds["P2"] &= a + margin <= task.initial_state[i] <= b - margin
        holds["P2"] &= task.initial_set.lower[i] + margin <= a and b + margin <= task.initial_set.upper[i]
        holds["P5"] &= task.target_set.lower[i] + margin <= end[i][0] and end[i][1] + margin <= task.target_set.upper[i]
    return holds


def verdicts(certificate: Certificate) -> dict[str, bool]:
    """Return, by code, whether all of a certificate's findings with that code hold."""
    holds_by_code: dict[str, bool] = {}
    for finding in certificate.findings:
        holds_by_code[finding.code] = holds_by_code.get(finding.code, True) and finding.holds
    return holds_by_code


def bend(controller: EmittedController, j: int, i: int, side: int, amount: int) -> RefinedDesign:
    """Return the controller's design with one integer of its table changed: of row j, dimension i, lower (0) or upper (1) edge."""
    table = [list(map(list, row)) for row in controller.design.table]
    table[j][i][side] += amount
    return replace(controller.design, table=tuple(tuple(tuple(p) for p in row) for row in table))  # type: ignore[misc]


@pytest.mark.parametrize("name", NAMES)
def test_the_oracle_agrees_with_every_shipped_certificate(name: str) -> None:
    controller = controller_of(name)
    error = max(controller.certificate.edge_error)
    assert all(oracle(controller.task, controller.design, error).values())


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_no_tube_that_the_oracle_finds_broken_is_certified(data) -> None:
    controller = controller_of(data.draw(st.sampled_from(["omni_s1", "omni_s2", "spacecraft"])))
    design = controller.design
    j = data.draw(st.integers(0, design.segments + 2))
    i = data.draw(st.integers(0, design.dimension - 1))
    amount = data.draw(st.one_of(st.integers(-200, 200), st.integers(-(2**19), 2**19)))
    bent = bend(controller, j, i, data.draw(st.integers(0, 1)), amount)
    certificate = certify_refined(controller.task, bent, controller.certificate.edge_error)
    truth = oracle(controller.task, bent, max(controller.certificate.edge_error))
    for code, holds in truth.items():
        if not holds:
            assert not verdicts(certificate)[code]


def failing_codes(task: Task, design: RefinedDesign, error: tuple[Fraction, ...]) -> set[str]:
    """Return the codes of the properties that the certificate says fail."""
    return {f.code for f in certify_refined(task, design, error).failures}


def test_each_property_fails_alone_when_its_part_of_the_task_changes() -> None:
    controller = controller_of("omni_s1")
    task, design, error = controller.task, controller.design, controller.certificate.edge_error
    tube = task.tube
    start, target = task.initial_set, task.target_set
    cases = {
        "P1": {"tube": tube.model_copy(update={"min_width": Fraction("0.5")})},
        "P2": {"initial_set": start.model_copy(update={"lower": (Fraction("0.1"), Fraction("4.5"))})},
        "P3": {"state_space": task.state_space.model_copy(update={"lower": (Fraction(0), Fraction("3.8"))})},
        "P4": {"tube": tube.model_copy(update={"clearance": Fraction("0.031")})},
        "P5": {"target_set": target.model_copy(update={"lower": (Fraction("4.9"), Fraction("4.5"))})},
        "P6": {"tube": tube.model_copy(update={"max_speed": Fraction("0.1")})},
    }
    assert failing_codes(task, design, error) == set()
    for code, change in cases.items():
        assert failing_codes(task.model_copy(update=change), design, error) == {code}


def test_a_kink_at_t_c_is_found() -> None:
    controller = controller_of("omni_s1")
    bent = bend(controller, controller.design.segments + 2, 0, 0, 1)
    assert "P6" in failing_codes(controller.task, bent, controller.certificate.edge_error)


def test_a_thin_unsafe_set_between_samples_is_found() -> None:
    """A slab crossed within a fraction of one segment: exact hulls cannot jump over it."""
    controller = controller_of("omni_s3")
    task = controller.task
    slab = UnsafeSet(name="slab", lower=(Fraction(0), Fraction("2.2")), upper=(Fraction(5), Fraction("2.2000001")))
    task = task.model_copy(update={"unsafe": (*task.unsafe, slab)})
    finding = next(
        f for f in certify_refined(task, controller.design, controller.certificate.edge_error).findings if f.code == "P4"
    )
    assert not finding.holds
    assert finding.obstacle == "slab"


def test_halving_certifies_what_the_hull_alone_does_not() -> None:
    """An unsafe corner that the curve rounds but the hull of its segment overlaps."""
    controller = controller_of("omni_s2")
    design, task = controller.design, controller.task
    bezier = design.bezier()
    certified_boxes = 0
    for k in range(design.segments):
        low, high = bezier[k, :, 0].min(axis=1), bezier[k, :, 1].max(axis=1)
        middle = exact_edges(design, k, Fraction(1, 2))
        # A small box at the upper left corner of the hull: it is off the curve whenever the segment rises in both dimensions.
        corner = (int(low[0]) * design.unit, int(high[1]) * design.unit)
        if not (middle[0][0] - corner[0] > Fraction("0.02") and corner[1] - middle[1][1] > Fraction("0.02")):
            continue
        size = Fraction("0.001")
        box = UnsafeSet(name="corner", lower=(corner[0] - size, corner[1] - size), upper=(corner[0] + size, corner[1] + size))
        task_with_box = task.model_copy(
            update={"unsafe": (box,), "tube": task.tube.model_copy(update={"clearance": Fraction(0)})}
        )
        error = max(controller.certificate.edge_error)
        is_clear_at_samples = all(
            any(
                a - error >= u or b + error <= lo
                for (a, b), lo, u in zip(exact_edges(design, q, Fraction(s, 64)), box.lower, box.upper, strict=True)
            )
            for q in range(design.segments)
            for s in range(65)
        )
        finding = next(
            f for f in certify_refined(task_with_box, design, controller.certificate.edge_error).findings if f.code == "P4"
        )
        if is_clear_at_samples:
            assert finding.holds
            certified_boxes += 1
    assert certified_boxes > 0


def test_a_refusal_names_property_time_dimension_and_set() -> None:
    task = load_task(ROOT / "tasks" / "omni_s1.toml")
    certified = controller_of("omni_s1")
    bent = bend(certified, 10, 1, 1, 2**18)
    with pytest.raises(NotCertified) as refusal:
        build_task(task, tube=bent)
    assert refusal.value.exit_code == 3
    for word in ("avoid (P4) at t", "dimension ", "unsafe set O1", "is missing", "lower tube.clearance"):
        assert word in str(refusal.value)
    controller = build_task(task, uncertified=True, tube=bent)
    for name, data in controller.files.items():
        assert (b"NOT CERTIFIED" in data) or (name.endswith(".json") and b'"certified": false' in data)


def test_margins_in_the_certificate_are_true_lower_bounds() -> None:
    """The smallest gap over many samples is never below the certified margin, and close to it."""
    controller = controller_of("omni_s2")
    task, design = controller.task, controller.design
    widths, gaps = [], []
    for k in range(design.segments):
        for step in range(17):
            edges = exact_edges(design, k, Fraction(step, 16))
            widths.append(min(b - a for a, b in edges) - task.tube.min_width)
            for s in task.unsafe:
                gaps.append(max(max(s.lower[i] - edges[i][1], edges[i][0] - s.upper[i]) for i in range(2)) - task.tube.clearance)
    margin = {f.code: f.margin for f in controller.certificate.findings}
    assert margin["P1"] <= min(widths) <= margin["P1"] + Fraction("0.01")
    assert margin["P4"] <= min(gaps) <= margin["P4"] + Fraction("0.001")


def moved_task(name: str, far: Fraction, scale: Fraction = Fraction(1)) -> Task:
    """Return a shipped task with every length multiplied by `scale`, and every coordinate then increased by `far`."""
    task = load_task(ROOT / "tasks" / f"{name}.toml")

    def scaled_and_shifted(values):
        return tuple(v * scale + far for v in values)

    def moved_box(box):
        return box.model_copy(update={"lower": scaled_and_shifted(box.lower), "upper": scaled_and_shifted(box.upper)})

    boxes = {name: moved_box(getattr(task, name)) for name in ("state_space", "initial_set", "target_set")}
    unsafe = tuple(moved_box(box) for box in task.unsafe)
    tube = {"clearance": task.tube.clearance * scale, "min_width": task.tube.min_width * scale}
    return task.changed(**boxes, unsafe=unsafe, initial_state=scaled_and_shifted(task.initial_state), tube=tube)


def test_far_from_the_origin_float_is_refused_with_the_reason() -> None:
    """At an offset of 5,000,000 floats are half a unit apart: float is refused, whatever the tube."""
    with pytest.raises(NotCertified, match="too narrow.*emit.scalar"):
        build_once(moved_task("empty", Fraction(5_000_000)))


@pytest.mark.parametrize("far", [Fraction(1000), Fraction(-4821733), Fraction(10**8)])
@pytest.mark.parametrize("name", ["omni_s2", "spacecraft"])
def test_a_tube_in_doubles_far_from_the_origin_is_the_one_near_it_moved(name: str, far: Fraction) -> None:
    """The two tables differ by a constant, up to two units: one for rounding, one because `far` need not be a multiple of the unit."""
    near = build_once(moved_task(name, Fraction(0)).with_options(scalar="double"))
    distant = build_once(moved_task(name, far).with_options(scalar="double"))
    assert distant.certificate.holds
    assert distant.design.bits == near.design.bits
    assert distant.design.segments == near.design.segments
    difference = distant.design.integers() - near.design.integers()
    assert np.abs(difference - difference[-1:]).max() <= 2


def test_a_task_too_small_for_doubles_at_its_distance_is_refused_with_the_reason() -> None:
    """At 10**8 doubles are 2**-26 apart; a tube needs 2**-44 of the coordinates, which is 8e-6 there."""
    far = Fraction(10**8)
    for scale in (Fraction(1, 10), Fraction(1, 1000)):
        assert build_once(moved_task("omni_s2", far, scale).with_options(scalar="double")).certificate.holds
    for scale in (Fraction(1, 10**5), Fraction(1, 10**7)):
        with pytest.raises(NotCertified, match="too large for a tube in double"):
            build_once(moved_task("omni_s2", far, scale).with_options(scalar="double"))


def test_speed_bound_covers_every_difference_quotient() -> None:
    controller = controller_of("spacecraft")
    design = controller.design
    step = design.prescribed_time / design.segments
    for k in range(design.segments):
        edges = [exact_edges(design, k, Fraction(s, 8)) for s in range(9)]
        for before, after in itertools.pairwise(edges):
            for i in range(3):
                for side in (0, 1):
                    assert abs(after[i][side] - before[i][side]) / (step / 8) <= controller.certificate.speed[i]


def test_certify_uses_the_program_that_is_printed() -> None:
    controller = controller_of("omni_s1")
    certificate = certify(controller.task, controller.design, build_program(controller.task, controller.design))
    assert certificate == controller.certificate
    assert np.all(np.array([float(v) for v in certificate.edge_error]) < 1e-5)
