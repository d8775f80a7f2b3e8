"""The rounding allowance, the distance that a design leaves for rounding in the emitted code: a tube so fast that it needs more
than usual is designed with a larger one, by every entry."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

from stt_codegen import api
from stt_codegen.certify import rounding_allowance
from stt_codegen.certify.rounding_allowance import COVERED_SHARE, needed_allowance_factor
from stt_codegen.checker import check_files
from stt_codegen.cli.design_commands.design import design as command
from stt_codegen.controller.edge_errors import edge_error_of_design
from stt_codegen.controller.integers import integer_errors
from stt_codegen.controller.integers.fixed_program import STEP_BITS
from stt_codegen.design.arena import arena_of
from stt_codegen.design.lattice import ALLOWANCE_STEPS, lattice_of
from stt_codegen.designs import RefinedDesign
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task, design_tube
from stt_codegen.task import Task, load_task, parse_task
from tests.support.controllers import ROOT, controller_of


def shuttle(axes: int, legs: int, more: str = "") -> str:
    """Return a mission that visits two corners of a room by turns, one leg a second. legs: their number; more: lines of the task file."""

    def box(lower: float, upper: float) -> str:
        return f"lower = {[lower] * axes}\nupper = {[upper] * axes}\n"

    entries = "".join(f'[[mission]]\nvisit = "{("far", "near")[k % 2]}"\nbetween = [{k + 0.5}, {k + 1}]\n' for k in range(legs))
    return (
        f'name = "shuttle"\nprescribed_time = {legs + 1}\ninitial_state = {[0.5] * axes}\n[state_space]\n{box(0, 4)}'
        f'[initial_set]\n{box(0.1, 0.9)}[[region]]\nname = "far"\n{box(3.1, 3.9)}[[region]]\nname = "near"\n{box(0.1, 0.9)}'
        f"{entries}{more}"
    )


def maze(walls: int, head: str = "", tube: str = "", more: str = "", target_height: float | None = None) -> str:
    """Return a task in a room of 4 by 4 with walls that a tube passes on the left and on the right by turns."""
    pitch = 4 / (walls + 1)
    sets = "".join(
        f"[[unsafe]]\nlower = [{0 if k % 2 else 0.4}, {pitch * k - 0.005:.4f}]\n"
        f"upper = [{3.6 if k % 2 else 4}, {pitch * k + 0.005:.4f}]\n"
        for k in range(1, walls + 1)
    )
    height = pitch - 0.03 if target_height is None else target_height
    return (
        f'name = "maze"\nprescribed_time = 10\ninitial_state = [0.1, {pitch / 2:.4f}]\n{head}\n'
        "[state_space]\nlower = [0, 0]\nupper = [4, 4]\n"
        f"[initial_set]\nlower = [0.01, 0.01]\nupper = [0.2, {pitch - 0.02:.4f}]\n"
        f"[target_set]\nlower = [0.01, {3.99 - height:.9f}]\nupper = [3.99, 3.99]\n"
        f"[tube]\nclearance = 0.002\nmin_width = 0.01\n{tube}\n{sets}{more}"
    )


CART = '[[unsafe]]\nname = "cart"\nlower = [1.9, 0]\nupper = [2.1, 0.4]\nmotion = [{at = 0, by = [0, 0]}, {at = 10, by = [0.5, 0]}]\n'
POST = "[[unsafe]]\ncentre = [2, 1]\nradius = 0.3\n"
SAMPLED = '[plant]\ng_min = 0.9\ng_max = 1.1\n[control]\nperiod = 0.0005\ngain = "auto"\n'
PATROL = '[[mission]]\npatrol = ["far", "near"]\nevery = 2\n[tube]\nsegments = 32\n'
KINDS = {
    "maze": maze(13),
    "body, limits of speed": maze(13, head="body = [0.01, 0.01]", tube="max_speed = 8\nmax_acceleration = 200"),
    "order 2": maze(8, more="[plant]\norder = 2\n"),
    "mission, ticks, disc": shuttle(2, 14, f'{POST}[tube]\nsegments = 64\n[emit]\ntick_period = 0.001\nmath = "inline"\n'),
    "moving set": shuttle(2, 14, f"{CART}[tube]\nsegments = 128\n"),
    "period, chosen gain": shuttle(1, 16, f"[tube]\nsegments = 64\n{SAMPLED}"),
    "for ever": shuttle(1, 0, PATROL).replace("prescribed_time = 1", "prescribed_time = 8\nrepeat = true"),
}


# The design stage reads both functions from this module; the package's name `design` is a function.
designs = import_module("stt_codegen.design")
refine = cache(designs.refine)
refine_with_allowance = cache(designs.refine_with_allowance)
certify_edges = cache(rounding_allowance.certify_edges)


@pytest.fixture(autouse=True, scope="module")
def searches_run_once() -> Iterator[None]:
    """Cache design and exact comparison, whose results depend only on the task, so that all entries share them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(designs, "refine", refine)
        patch.setattr(designs, "refine_with_allowance", refine_with_allowance)
        patch.setattr(rounding_allowance, "certify_edges", certify_edges)
        yield


@cache
def task_of(kind: str) -> Task:
    """Return the task of this name in `KINDS`."""
    return parse_task(KINDS[kind])


@cache
def build_once(kind: str) -> api.Controller:
    """Return the controller of a task of `KINDS`, as a script gets it."""
    return api.build(task_of(kind))


def margins_per_error(task: Task, design: RefinedDesign) -> Iterator[Fraction]:
    """Yield the margins of the edges, each divided by how many times the error of an edge enters it, in units of the table."""
    error = max(edge_error_of_design(task, design))
    for finding in certify_edges(task, design).findings:
        if finding.required > 0 and not finding.in_time:
            needed = round(finding.required / error)  # 2 for widths, where both edges err
            yield finding.margin / needed / design.unit


@pytest.mark.parametrize("kind", KINDS)
def test_a_task_that_needs_a_larger_allowance_is_certified(kind: str) -> None:
    """With the usual allowance its edges fail; `design` and `build` give the same tube, which is certified."""
    task = task_of(kind)
    assert certify_edges(task, refine(task)).lacks_rounding
    design = api.design(task)
    certificate = api.certify(task, design)
    assert certificate.holds
    assert (design, certificate) == (build_once(kind).design, build_once(kind).certificate)


@pytest.mark.parametrize("kind", ["maze", "for ever"])
def test_its_tube_of_the_usual_allowance_is_refused(kind: str) -> None:
    with pytest.raises(NotCertified, match="the task needs more room than single precision leaves"):
        build_task(task_of(kind), tube=refine(task_of(kind)))


@pytest.mark.parametrize("kind", ["maze", "for ever"])
def test_the_stand_alone_checker_accepts_it(kind: str, tmp_path: Path) -> None:
    for name, data in build_once(kind).files.items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "task.toml").write_text(KINDS[kind])
    name = build_once(kind).task.name
    assert check_files([str(tmp_path / file) for file in ("task.toml", f"{name}.c", f"{name}.certificate.json")]) == 0


def test_the_command_line_designs_the_same_tube(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "task.toml"
    file.write_text(KINDS["for ever"])
    command(file, json=True)
    report = json.loads(capsys.readouterr().out)
    margins = [float(finding.margin) for finding in build_once("for ever").certificate.findings]
    assert report["certified"]
    assert [p["margin"] for p in report["properties"]] == pytest.approx(margins)


def test_the_uncertified_flag_does_not_change_the_tube() -> None:
    assert build_task(task_of("maze"), uncertified=True).files == build_once("maze").files


def test_where_no_tube_has_the_larger_allowance_the_refusal_is_about_rounding(monkeypatch: pytest.MonkeyPatch) -> None:
    """The target is high enough for the smallest width and 6 times the usual allowance, and not for 6 times the larger one."""
    task = parse_task(maze(15, target_height=0.01 + 1.5 * float(6 * lattice_of(parse_task(maze(15))).allowance)))
    usual = refine(task)
    factor = needed_allowance_factor(task, usual)
    assert factor > 1
    assert refine_with_allowance(task, factor) is None
    assert api.design(task) == usual
    with pytest.raises(NotCertified, match=r"\w+ \(P\d\) .*is missing.*certified with emit.scalar = .double"):
        api.build(task)
    uncertified = build_task(task, uncertified=True)
    assert b"NOT CERTIFIED" in uncertified.files["maze.c"]
    # A tube of larger allowance is not taken either if it is not certified.
    monkeypatch.setattr(designs, "refine_with_allowance", lambda *_: replace(usual, table=usual.table[::-1]))
    assert api.design(task) == usual


def test_a_fast_tube_with_enough_margin_keeps_the_usual_allowance() -> None:
    """Its error is above the usual allowance, but a tube of order 2 touches no bound of a wider room."""
    text = shuttle(1, 14, "[tube]\nsegments = 64\n[plant]\norder = 2\n")
    task = parse_task(text.replace("lower = [0]\nupper = [4]", "lower = [-1]\nupper = [5]"))
    usual = refine(task)
    assert max(edge_error_of_design(task, usual)) > lattice_of(task).allowance
    assert design_tube(task) == usual


@pytest.mark.parametrize("name", ["omni_s2", "spacecraft", "mission_leg1"])
def test_an_ordinary_tube_is_not_certified_in_advance(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    controller = controller_of(name)
    assert isinstance(controller.design, RefinedDesign)
    monkeypatch.setattr(rounding_allowance, "certify_edges", lambda *_: pytest.fail("certified in advance"))
    assert needed_allowance_factor(controller.task, controller.design) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_a_design_leaves_its_allowance_up_to_the_rounding_of_coefficients(kind: str) -> None:
    """Therefore an error below COVERED_SHARE of the allowance needs no certificate in advance, and the factor multiplies the margin."""
    task = task_of(kind)
    usual = refine(task)
    factor = needed_allowance_factor(task, usual)
    assert factor > 1
    larger = build_once(kind).design
    assert isinstance(larger, RefinedDesign)
    for design, times in ((usual, 1), (larger, factor)):
        assert min(margins_per_error(task, design)) >= COVERED_SHARE * ALLOWANCE_STEPS * times


def test_the_factor_changes_every_bound_on_edges_and_none_on_rates() -> None:
    task = load_task(ROOT / "tasks" / "gantry.toml")
    usual = lattice_of(task)
    larger = replace(usual, rounding_allowance_factor=5)
    assert larger.allowance == 5 * usual.allowance
    usual_arena, larger_arena = arena_of(task, usual), arena_of(task, larger)
    added = 4 * float(usual.allowance)
    assert larger_arena.clearance - usual_arena.clearance == pytest.approx(added)
    assert larger_arena.min_widths - usual_arena.min_widths == pytest.approx(2 * added)
    assert larger_arena.start[0] - usual_arena.start[0] == pytest.approx(2 * added)
    assert usual_arena.target[1] - larger_arena.target[1] == pytest.approx(added)
    assert usual_arena.space[1] - larger_arena.space[1] == pytest.approx(added)
    assert larger_arena.difference_allowance == usual_arena.difference_allowance == float(usual.allowance)
    assert list(larger_arena.max_speeds) == list(usual_arena.max_speeds)


def test_the_error_computed_from_a_design_is_that_of_its_emitted_program() -> None:
    controller = build_once("maze")
    assert isinstance(controller.design, RefinedDesign)
    assert edge_error_of_design(controller.task, controller.design) == controller.certificate.edge_error


def test_the_error_in_integers_is_always_below_the_allowance() -> None:
    """Steps of 15 bits bound the errors of the clock and of the weights."""
    step = (1 << STEP_BITS) - 1
    table = tuple(((low, low + step),) for low in (0, *([step, 2 * step, 3 * step, 2 * step, step, 0] * 10)))
    design = RefinedDesign(Fraction(9), len(table) - 3, 20, table)
    for tick in ("0.00001", "0.001", "0.06"):
        assert max(integer_errors.edge_error(design, Fraction(tick))) <= COVERED_SHARE * ALLOWANCE_STEPS * design.unit
