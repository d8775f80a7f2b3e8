"""Clearance, least width and noise by component: a list of equal entries is the number, and each entry counts on its own axis.

The laws are about the certificate, the stand-alone checker, the oracle of benchmarks/oracles and the loop, each with code of its own.
"""

from __future__ import annotations

import json
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.oracles.tubes import faults, first_fault
from stt_codegen.certify.slack import ConstraintBlock, smallest_slack
from stt_codegen.constraints import avoidances, width_constraints
from stt_codegen.design.arena import arena_of, with_one_clearance
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.report.page.evidence import requirement_of
from stt_codegen.task.load import parse_task
from stt_codegen.task.task import Task
from tests.support.checked_files import REFUSED, VERIFIED, Files, certificate_of, verdict, verdict_of_proof, with_text
from tests.support.controllers import build_once

HALL = """
name = "mix"
prescribed_time = 10
initial_state = [0.5, 0.5]
[state_space]
lower = [0, 0]
upper = [4, 4]
[initial_set]
lower = [0.2, 0.2]
upper = [0.8, 0.8]
[target_set]
lower = [3.2, 3.2]
upper = [3.8, 3.8]
[[unsafe]]
lower = [1.5, 0]
upper = [2.0, 2.5]
[[unsafe]]
vertices = [[2.5, 3.0], [3.0, 2.6], [3.2, 2.2], [2.6, 2.3]]
[[unsafe]]
centre = [0.6, 3.2]
radius = 0.3
[[unsafe]]
lower = [3.6, 0.2]
upper = [3.8, 0.4]
motion = [{ at = 0, by = [0, 0] }, { at = 10, by = [-0.5, 0.5] }]
spread = 0.01
"""
SAMPLED = """
[control]
period = 0.02
u_max = [2, 2]
[plant]
w_max = 0.05
"""


def hall(tube: str = "", more: str = "") -> Task:
    return parse_task(f"{HALL}[tube]\n{tube}\n{more}")


def hall_files(tube: str = "", more: str = "") -> Files:
    """Return the files of a certified room, and its task."""
    controller = build_once(hall(tube, more))
    return {**controller.files, "task.toml": f"{HALL}[tube]\n{tube}\n{more}".encode()}


def with_tube(task: Task, **change: Any) -> Task:
    return task.model_copy(update={"tube": task.tube.model_copy(update=change)})


def with_entry(values: tuple[Fraction, ...], i: int, value: Fraction) -> tuple[Fraction, ...]:
    return tuple(value if k == i else v for k, v in enumerate(values))


# ------------------------------------------------------------------------------------------------ a list of equal entries


EQUAL_LISTS = {
    "refined": ("clearance = 0.1\nmin_width = 0.2", "clearance = [0.1, 0.1]\nmin_width = [0.2, 0.2]", "", ""),
    "sampled": ("", "", SAMPLED + "noise = 0.004", SAMPLED + "noise = [0.004, 0.004]"),
    "order 2": (
        "min_width = 0.3",
        "min_width = [0.3, 0.3]",
        "[control]\nperiod = 0.01\n[plant]\norder = 2\nw_max = 0.02\nnoise = 0.0005\nnoise_v = 0.001",
        "[control]\nperiod = 0.01\n[plant]\norder = 2\nw_max = 0.02\nnoise = [0.0005, 0.0005]\nnoise_v = [0.001, 0.001]",
    ),
    "differences": (
        "min_width = 0.3",
        "min_width = [0.3, 0.3]",
        '[control]\nperiod = 0.01\nvelocity = "differences"\n[plant]\norder = 2\nw_max = 0.02\nnoise = 0.00002',
        '[control]\nperiod = 0.01\nvelocity = "differences"\n[plant]\norder = 2\nw_max = 0.02\nnoise = [0.00002, 0.00002]',
    ),
}


@pytest.mark.parametrize("case", EQUAL_LISTS)
def test_a_list_of_equal_entries_gives_the_tube_and_the_numbers_of_the_number(case: str) -> None:
    tube, list_tube, more, list_more = EQUAL_LISTS[case]
    number, equal = (build_once(hall(*texts)) for texts in ((tube, more), (list_tube, list_more)))
    assert number.task.digest != equal.task.digest
    assert number.design == equal.design
    assert number.certificate == equal.certificate
    assert number.files["mix.c"] == equal.files["mix.c"]
    documents = [json.loads(v.files["mix.certificate.json"]) for v in (number, equal)]
    noise = [
        v["sampled"]["plant"].pop(k)
        for v in documents
        if "sampled" in v
        for k in ("noise", "noise_v")
        if k in v["sampled"]["plant"]
    ]
    for document in documents:
        for key in ("sha256", "design_hash"):
            document.pop(key, None)
    assert documents[0] == documents[1]
    assert all(v is None or len({*([v] if isinstance(v, str) else v)}) == 1 for v in noise)


# ------------------------------------------------------------------------------------------------ each entry on its own axis


clearances = st.tuples(*[st.integers(0, 32).map(lambda v: Fraction(v, 32))] * 2)


@given(clearances)
@settings(max_examples=40)
def test_the_searches_and_the_certificate_have_the_same_inequalities(pair: tuple[Fraction, Fraction]) -> None:
    """Larger sets with the smallest clearance, as the arena has them, are the sets of the task with the list."""
    task = with_tube(hall(), clearance=pair)
    for avoidance, grown in zip(avoidances(task), [s.grown(task.clearance_excess) for s in task.obstacles], strict=True):
        simple = with_one_clearance(avoidance, min(pair))
        for row, same in zip(avoidance.alternatives, simple.alternatives, strict=True):
            normal = [0] * 2
            for i, _, c in row.terms:
                normal[i] = c
            assert row.clearance == sum(abs(c) * v for c, v in zip(normal, pair, strict=True))
            assert (row.terms, row.bound + row.clearance) == (same.terms, same.bound + same.clearance)
            assert (same.bound, same.clearance) == (grown.support(tuple(normal)), sum(map(abs, normal)) * min(pair))


@pytest.mark.parametrize(
    "tube", ["clearance = [0.1, 0.3]", "clearance = [0.3, 0]", "clearance = [0, 0.25]\nmin_width = [0.5, 0.1]"]
)
def test_a_tube_keeps_its_lists_and_no_more_than_these_are_claimed(tube: str, tmp_path: Path) -> None:
    controller = build_once(hall(tube))
    task, design = controller.task, controller.design
    assert isinstance(design, RefinedDesign)
    error = max(controller.certificate.edge_error)
    assert controller.certificate.holds
    assert first_fault(task, design, error) is None  # of an oracle that shares no code with design and certificate
    files = hall_files(tube)
    assert verdict(files, tmp_path).code == VERIFIED, verdict(files, tmp_path)
    margin = next(f.margin for f in controller.certificate.findings if f.code == "P1")
    for i in range(2):
        for key, code, values in (("clearance", "P4", task.clearances), ("min_width", "P1", task.min_widths)):
            raised = with_tube(task, **{key: with_entry(values, i, Fraction(4))})  # as wide as the room
            assert {f.dimension for f in faults(raised, design) if f.code == code} == ({i} if code == "P1" else {None})
        at_margin = with_entry(task.min_widths, i, task.min_widths[i] + margin - 2 * error)
        assert first_fault(with_tube(task, min_width=at_margin), design) is None


def with_scaled_axis(task: Task, i: int, factor: Fraction) -> Task:
    """Return the task with another unit on axis i, without its round and moving sets: a ball would be no ball."""

    def scaled(values: Any) -> Any:
        return with_entry(tuple(values), i, values[i] * factor)

    def with_scaled(table: Any) -> Any:
        fields = {name: scaled(v) for name in ("lower", "upper") if (v := getattr(table, name, None))}
        corners = {"vertices": tuple(map(scaled, table.vertices))} if getattr(table, "vertices", None) else {}
        return table.model_copy(update={**fields, **corners})

    sets = [s for s in task.unsafe if not s.is_timed and getattr(s, "radius", None) is None]
    boxes = {name: with_scaled(getattr(task, name)) for name in ("state_space", "initial_set", "target_set")}
    tube = {"clearance": scaled(task.clearances), "min_width": scaled(task.min_widths)}
    fields = {**boxes, "initial_state": scaled(task.initial_state), "unsafe": tuple(map(with_scaled, sets))}
    return task.changed(**fields, tube=tube)


@given(st.integers(0, 1), st.integers(-3, 3), clearances, clearances)
@settings(max_examples=30, deadline=None)
def test_an_axis_in_another_unit_has_the_same_verdict(i: int, exponent: int, clearance: Any, min_width: Any) -> None:
    """Scale one axis of sets, tube, clearance and width by a power of two: whether P1 and P4 hold is the same."""
    factor, base = Fraction(2) ** exponent, build_once(hall("clearance = [0.1, 0.3]"))
    design = base.design
    assert isinstance(design, RefinedDesign)
    task = with_tube(base.task, clearance=clearance, min_width=min_width)
    bezier = design.bezier()
    scaled_bezier = bezier * 8
    scaled_bezier[:, i] = bezier[:, i] * int(8 * factor)
    assert tube_verdicts(with_scaled_axis(task, i, Fraction(1)), bezier, design.unit) == tube_verdicts(
        with_scaled_axis(task, i, factor), scaled_bezier, design.unit / 8
    )


def tube_verdicts(task: Task, bezier: Any, unit: Fraction) -> list[bool]:
    """Return whether P1 and P4 hold of a tube."""
    blocks = (ConstraintBlock.of(width_constraints(task), unit), ConstraintBlock.choice(avoidances(task), unit))
    return [smallest_slack(bezier, block, Fraction(0)).slack >= 0 for block in blocks]


@pytest.mark.parametrize(
    ("tube", "said"),
    [
        ("clearance = [0.1, 0.3]", "the tube, grown by [0.1, 0.3] (by dimension) to both sides, meets no unsafe set, stays"),
        ("clearance = 0.1", "the tube keeps 0.1 from every unsafe set, stays"),
    ],
)
def test_a_clearance_by_component_is_said_of_the_grown_tube(tube: str, said: str) -> None:
    """One component keeps its number at each moment, and nothing says that all of them do."""
    controller = build_once(hall(tube))
    header = re.sub(r"\s+\*?\s*", " ", controller.files[f"{controller.task.name}.h"].decode())
    finding = next(f for f in controller.certificate.findings if f.code == "P4")
    assert said in header
    for sentence in (finding.statement, requirement_of(controller, finding)):
        assert ("grown by [0.1, 0.3] (by dimension) to both sides, meets none of" in sentence) == ("grown" in said), sentence


@pytest.mark.parametrize(("i", "factor"), [(0, 64), (1, 100), (1, Fraction(1, 16))])
def test_a_task_in_mixed_units_is_designed(i: int, factor: Fraction) -> None:
    """With the entries of the axis scaled too, the task is certified; with one number for both it is another task."""
    task = with_scaled_axis(hall("clearance = [0.1, 0.2]\nmin_width = [0.3, 0.2]"), i, Fraction(factor))
    controller = build_once(task)
    assert controller.certificate.holds
    assert isinstance(controller.design, RefinedDesign)
    assert first_fault(task, controller.design, max(controller.certificate.edge_error)) is None


def test_the_arena_asks_for_the_width_of_each_axis() -> None:
    arena = arena_of(hall("min_width = [0.5, 0.1]\nclearance = [0.2, 0.05]"))
    assert arena.min_widths - 2 * arena.allowance == pytest.approx([0.5, 0.1])
    assert arena.clearance_excess == pytest.approx([0.15, 0])
    with pytest.raises(NotCertified, match=r"width \(P1\): initial_set is 0\.6 wide in dimension 2.*min_width 0\.7"):
        build_once(hall("min_width = [0.1, 0.7]"))


def test_a_refusal_lowers_the_entry_of_the_axis_that_fails() -> None:
    with pytest.raises(NotCertified) as refusal:
        build_once(hall("min_width = [0.3, 5]"))
    match = re.search(r"certified with tube\.min_width = \[0\.3, ([\d.]+)\]", str(refusal.value))
    assert match, refusal.value
    assert build_once(hall(f"min_width = [0.3, {match[1]}]")).certificate.holds


# ------------------------------------------------------------------------------------------------ the stand-alone checker


@pytest.mark.parametrize(
    ("tube", "more", "old", "new", "message"),
    [
        ("clearance = [0.1, 0.1]", "", "clearance = [0.1, 0.1]", "clearance = [0.1, 0.5]", "P4 does not hold"),
        ("clearance = [0.1, 0.1]", "", "clearance = [0.1, 0.1]", "clearance = [0.5, 0.1]", "P4 does not hold"),
        ("min_width = [0.1, 0.1]", "", "min_width = [0.1, 0.1]", "min_width = [0.1, 0.9]", "narrower than min_width in x2"),
        ("min_width = [0.1, 0.1]", "", "min_width = [0.1, 0.1]", "min_width = [0.9, 0.1]", "narrower than min_width in x1"),
        ("", SAMPLED + "noise = [0.001, 0.001]", "noise = [0.001, 0.001]", "noise = [0.001, 0.05]", ""),
        ("", SAMPLED + "noise = [0.001, 0.001]", "noise = [0.001, 0.001]", "noise = [0.05, 0.001]", ""),
    ],
)
def test_the_checker_refuses_files_that_keep_only_the_smaller_entry(
    tube: str, more: str, old: str, new: str, message: str, tmp_path: Path
) -> None:
    files = hall_files(tube, more)
    assert verdict(files, tmp_path).code == VERIFIED
    changed = with_text(files, "task.toml", old, new)
    if "noise" in new:  # the certificate repeats the bounds; let it repeat the larger one
        certificate = certificate_of(changed)
        certificate["sampled"]["plant"]["noise"] = [str(Fraction(v)) for v in re.findall(r"0\.\d+", new)]
        changed = {**changed, "mix.certificate.json": json.dumps(certificate).encode()}
    refused = verdict_of_proof(changed, tmp_path)
    assert refused.code == REFUSED, refused
    assert message in refused.message


STANDING_SETS = re.sub(r"\[\[unsafe\]\]\nlower = \[3\.6.*", "", HALL, flags=re.S)
LISTS = "[tube]\nclearance = [0.05, 0.1]\nmin_width = [0.2, 0.3]\n"
NOISE = "noise = [0.0005, 0.002]\n"
REGIONS = """
[[region]]
name = "bay"
lower = [0.2, 2.9]
upper = [0.9, 3.5]
[[region]]
name = "corner"
vertices = [[2.2, 3.4], [2.6, 3.4], [2.4, 3.7]]
[[mission]]
never = "bay"
[[mission]]
never = "corner"
"""
KINDS = {
    "closed axis": STANDING_SETS.replace("prescribed_time", 'axes = ["x", "yaw"]\nperiodic = { yaw = 6.2832 }\nprescribed_time')
    + f"{LISTS}[control]\nperiod = 0.01\nu_max = [2, 2]\n[plant]\nw_max = 0.02\n{NOISE}",
    "integers": f'{STANDING_SETS}{LISTS}[control]\nu_max = [2, 2]\n[emit]\nscalar = "fixed"\ntick_period = 0.01\n[plant]\n{NOISE}',
    "late inputs": f"{STANDING_SETS}{LISTS}[control]\nperiod = 0.01\n[plant]\nw_max = 0.02\nlag = 0.01\n{NOISE}",
    "mission": f"{STANDING_SETS}{REGIONS}{LISTS}",
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_checker_verifies_tasks_of_every_kind_with_lists(kind: str, tmp_path: Path) -> None:
    files = {**build_once(parse_task(KINDS[kind])).files, "task.toml": KINDS[kind].encode()}
    assert verdict(files, tmp_path).code == VERIFIED, verdict(files, tmp_path)
