"""Changed claims and tasks: the stand-alone checker proves every claim, for the task as it stands.

Hashes, header and C go along with a change where the proof alone must refuse it. benchmarks/token_mutants.py changes every number, word and
list of a certificate; benchmarks/mutations.py bends tubes and tasks by the thousand."""

from __future__ import annotations

import functools
import itertools
import json
import re
from collections.abc import Callable
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.mutants.tubes import BOX_BASE_NAMES, draw_mutant
from benchmarks.mutations import files_claiming_success
from stt_codegen.certify.claims import claims_of, cuts_of
from stt_codegen.checker.stt_checker.exact import logarithm
from stt_codegen.checker.stt_checker.task import Task as CheckedTask
from stt_codegen.checker.stt_checker.tube import part_of
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.pipeline import build_program, certify
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.certify.test_certificate import bend, oracle
from tests.support.checked_files import (
    REFUSED,
    UNUSABLE,
    VERIFIED,
    certificate_of,
    recorded_files,
    verdict,
    verdict_of_proof,
    with_certificate,
    with_text,
)
from tests.support.controllers import ROOT, build_once, controller_of

# ------------------------------------------------------------------------------------------------ tasks


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("lower = [4.0, 2.0]", "lower = [4.0]"),
        ("lower = [4.0, 2.0]", "lower = 4.0"),
        ("u_max = [2.0, 2.0]", "u_max = [2.0]"),
        ("body = [0.15, 0.1]", "body = [0.15]"),
        ("g_min = 0.9", "g_min = -0.9"),
        ("w_max = 0.1", "w_max = -0.1"),
        ("latency = 0.002", "latency = -0.002"),
        ("prescribed_time = 8.0", "prescribed_time = 1e999999999"),
        ("share = 0.9", "share = 1.0"),
        ("share = 0.9", "share = 2.5"),
        ("clearance = 0.05", "clearance = -1.0"),
        ("lower = [1.6, 0.6]", "lower = [9.6, 0.6]"),
        ("upper = [5.0, 3.0]", "upper = [5.0]"),
        ("[control]", "[control]\nlaw = 2"),
        ("[[unsafe]]", "[[unsafe]]\nmotion = 1"),
        ("[[unsafe]]", "[[unsafe]]\nmotion = [{at = 0, by = 0.5}]"),
        ("[[unsafe]]", "[[unsafe]]\nmotion = [{at = 1, by = [0, 0]}, {at = 1, by = [1, 0]}]"),
        ("[[unsafe]]", "[[unsafe]]\nduring = [3, 2]"),
        ("[target_set]", "[target_set]\nradius = 0.01"),
        ("lower = [4.0, 2.0]", "centre = [4.4, 2.4]\nradius = 0.2"),
        ("[control]", "[[unsafe]]\nname = 'pillar'\nlower = [0, 0]\nupper = [0.1, 0.1]\n[control]"),
        ("prescribed_time = 8.0", 'prescribed_time = 8.0\naxes = ["a", "a"]'),
        ("prescribed_time = 8.0", 'prescribed_time = 8.0\naxes = ["a", "b", "a"]'),
    ],
)
def test_an_invalid_task_is_an_error_of_input(old: str, new: str, tmp_path: Path) -> None:
    files = recorded_files("trolley")
    text = files["task.toml"].decode()
    assert old in text
    code, message = verdict({**files, "task.toml": text.replace(old, new).encode()}, tmp_path)
    assert (code, message.startswith("checker: cannot check: ")) == (UNUSABLE, True), message


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("lower = [2.0, 2.5]", "lower = [2.0, 2.5]\nupper = [3.0, 3.6]\n[[unsafe]]\nname = \"X\"\nlower = [2.0, 2.5]", "P4"),
        ("initial_state = [0.25, 4.75]", "initial_state = [0.25, 4.99999]", "P2"),
        ("lower = [4.5, 4.5]", "lower = [4.9, 4.5]", "P5"),
        ("min_width = 0.05", "min_width = 0.45", "P1"),
        ("clearance = 0.03", "clearance = 0.031", "P4"),
        ("min_width = 0.05", "min_width = 0.05\nmax_speed = 0.5", "P6"),
    ],
)  # fmt: skip
def test_a_harder_task_is_refused_although_the_hashes_fit(old: str, new: str, code: str, tmp_path: Path) -> None:
    exit_code, message = verdict(with_text(recorded_files("omni_s1"), "task.toml", old, new), tmp_path)
    assert exit_code == REFUSED
    assert code in message


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("period = 0.02 ", "period = 0.05 ", "P9 does not hold"),
        ("w_max = 0.1", "w_max = 1.5", "P9 does not hold"),
        ("g_max = 1.1", "g_max = 20.0", "P9 does not hold"),
        ("g_min = 0.9", "g_min = 0.2", "P9 does not hold"),
        ("noise = 0.002", "noise = 0.01", "shift"),
        ("initial_state = [0.5, 0.5]", "initial_state = [0.22, 0.5]", "P"),
    ],
)
def test_a_loop_beyond_its_proof_is_refused_although_all_files_fit_it(old: str, new: str, message: str, tmp_path: Path) -> None:
    files = with_text(recorded_files("trolley"), "task.toml", old, new)
    certificate, task = certificate_of(files), CheckedTask(files["task.toml"])
    certificate["sampled"] |= {"period": str(task.period), "plant": task.stated}
    code, output = verdict_of_proof(with_certificate(files, certificate), tmp_path)
    assert code == REFUSED
    assert message in output


@pytest.mark.parametrize(("e_max", "gain"), [("0.99", "1e30"), ("0.999999", "1e28"), ("0.99999999", "1"), ("0.0001", "1")])
def test_a_law_that_its_scalar_does_not_hold_is_refused(e_max: str, gain: str, tmp_path: Path) -> None:
    """Whatever else fits: task, certificate and the C may state any gain."""
    files = recorded_files("omni_s1")
    text = re.sub(r"^(gain|e_max) = .*$", "", files["task.toml"].decode(), flags=re.M)
    task_file = text.replace("[control]", f"[control]\ngain = {gain}\ne_max = {e_max}").encode()
    certificate = certificate_of(files)
    numbers = CheckedTask(task_file)
    certificate["control"] |= {"gain": [str(v) for v in numbers.gain], "e_max": [str(v) for v in numbers.e_max]}
    certificate["sha256"]["task_data"] = numbers.digest
    code, output = verdict(with_certificate({**files, "task.toml": task_file}, certificate), tmp_path)
    assert code == REFUSED
    assert "range" in output or "too near 0 or 1" in output


def test_what_the_checker_cannot_check_is_an_error_of_input(tmp_path: Path) -> None:
    files = recorded_files("omni_s1")
    literal = ROOT / "generated" / "omni_s1" / "literal" / "float" / "omni_s1.certificate.json"
    code, message = verdict({**files, literal.name: literal.read_bytes()}, tmp_path)
    assert (code, "only those can be checked here" in message) == (UNUSABLE, True), message


# ------------------------------------------------------------------------------------------------ claims


def changed_claim(name: str, change: Callable[[Any], None], scalar: str = "float") -> dict[str, bytes]:
    """Return the recorded files of a task with a change of the certificate."""
    files = recorded_files(name, scalar)
    certificate = certificate_of(files)
    change(certificate)
    return with_certificate(files, certificate)


@pytest.mark.parametrize(
    ("field", "factor", "message"),
    [
        ("rho", Fraction(1, 2), "rho is not between"),
        ("rho", Fraction(9, 10), "rho is not between"),
        ("u", Fraction(99, 100), "|u| may be more"),
        ("shift", Fraction(99, 100), "the law sees a larger error"),
        ("u", Fraction(101, 100), ""),
        ("shift", Fraction(10001, 10000), ""),
    ],
)
def test_a_claim_about_samples_must_be_true(field: str, factor: Fraction, message: str, tmp_path: Path) -> None:
    """A larger bound on u or on the shift is true as well."""

    def change(certificate: Any) -> None:
        certificate["sampled"][field] = [str(Fraction(v) * factor) for v in certificate["sampled"][field]]

    code, output = verdict(changed_claim("crawler", change), tmp_path)
    assert (code, message in output) == (REFUSED if message else VERIFIED, True), output


def test_the_order_of_keys_in_a_certificate_does_not_matter_but_types_do(tmp_path: Path) -> None:
    files = recorded_files("trolley")
    document, name = certificate_of(files), "trolley.certificate.json"
    assert verdict({**files, name: json.dumps(document, sort_keys=True).encode()}, tmp_path).code == VERIFIED
    for fraction in (" 95027977/5000000", "9_5027977/5000000", "95027977/5000000\n", "9.5e1"):
        changed = {**document, "sampled": {**document["sampled"], "rho": [fraction, fraction]}}
        assert verdict(with_certificate(files, changed), tmp_path).code == REFUSED
    document["claims"][0]["on"][0] = False
    assert verdict(with_certificate(files, document), tmp_path).code == REFUSED


def test_the_documents_example_is_a_recorded_certificate() -> None:
    """Every line of a claim in docs/certificate-format.md is a line of trolley's recorded certificate."""
    documented = re.findall(
        r'^ +("(?:grid|speed|start|control|edge_error)".*|\{"property".*)$',
        (ROOT / "docs" / "certificate-format.md").read_text(),
        re.M,
    )
    recorded = (ROOT / "generated" / "trolley" / "refined" / "float" / "trolley.certificate.json").read_text()
    assert len(documented) == 12
    assert all(line in recorded for line in documented)


@functools.cache
def tubes_that_need_cuts() -> list[tuple[Task, RefinedDesign]]:
    """Return the first three mutated tubes of seed 0 whose proof cuts segments into parts."""
    tubes = []
    for number in itertools.count():
        task, design = draw_mutant(Random(f"0 {number}"), BOX_BASE_NAMES).mutant
        certificate = certify(task, design, build_program(task, design))
        if certificate.holds and cuts_of(claims_of(task, design, certificate)) > 1:
            tubes.append((task, design))
        if len(tubes) == 3:
            return tubes
    return []


@pytest.mark.parametrize("number", range(3))
def test_a_proof_that_cuts_segments_is_accepted_and_refused_without_its_hints(number: int, tmp_path: Path) -> None:
    """Without the places to cut (P1, P3) the hulls are too coarse; without a normal (P4) there is a gap in time."""
    task, design = tubes_that_need_cuts()[number]
    files = files_claiming_success(task, design, certify(task, design, build_program(task, design)))
    document = certificate_of(files)
    assert document["grid"]["cuts"] > 1
    assert verdict(files, tmp_path).code == VERIFIED
    for claim in document["claims"]:
        if hints := claim.get("hints"):
            claim["hints"] = hints[1:] if claim["property"] == "P4" else []
            assert verdict(with_certificate(files, document), tmp_path).code == REFUSED, claim
            claim["hints"] = hints


def test_a_bound_on_speed_is_claimed_and_accepted(tmp_path: Path) -> None:
    controller = build_once(load_task(ROOT / "tasks" / "omni_s1.toml").changed(tube={"segments": 8, "max_speed": 5}))
    text = (
        (ROOT / "tasks" / "omni_s1.toml").read_text().replace("min_width = 0.05", "min_width = 0.05\nsegments = 8\nmax_speed = 5")
    )
    files = {**controller.files, "task.toml": text.encode()}
    assert certificate_of(files)["claims"][-1]["margin"] > 0
    assert verdict(files, tmp_path).code == VERIFIED


@pytest.mark.slow
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_with_updated_hashes_a_changed_tube_is_accepted_only_if_it_is_certified(data: Any, tmp_path: Path) -> None:
    """The oracle evaluates the edges exactly at samples and shares no code with the checker."""
    name = data.draw(st.sampled_from(["omni_s1", "omni_s2", "spacecraft"]))
    controller = controller_of(name)
    j, i = data.draw(st.integers(0, 34)), data.draw(st.integers(0, controller.design.dimension - 1))
    side, amount = data.draw(st.integers(0, 1)), data.draw(st.integers(-(2**19), 2**19))
    bent = bend(controller, j, i, side, amount)
    certificate = certify(controller.task, bent, build_program(controller.task, bent))
    holds_at_samples = oracle(controller.task, bent, Fraction(0))
    exit_code = verdict(files_claiming_success(controller.task, bent, certificate), tmp_path).code
    assert exit_code == (VERIFIED if certificate.holds else REFUSED)
    if not all(holds_at_samples.values()):
        assert exit_code == REFUSED


# ------------------------------------------------------------------------------------------------ exact numbers

fractions = st.fractions(min_value=-3, max_value=3, max_denominator=50)  # Bezier coefficients
local_times = st.fractions(min_value=0, max_value=1, max_denominator=20)


@given(st.lists(fractions, min_size=8, max_size=8), local_times, local_times, local_times)
def test_a_part_of_a_bezier_piece_is_the_same_curve(
    coefficients_of_edges: list[Fraction], a: Fraction, b: Fraction, s: Fraction
) -> None:
    def value_at(coefficients: list[Fraction], time: Fraction) -> Fraction:
        r = 1 - time
        return (
            r**3 * coefficients[0]
            + 3 * r * r * time * coefficients[1]
            + 3 * r * time**2 * coefficients[2]
            + time**3 * coefficients[3]
        )

    a, b = sorted((a, b))
    edges = (coefficients_of_edges[:4], coefficients_of_edges[4:])
    (part,) = part_of([edges], a, b)
    for side, edge in enumerate(edges):
        assert value_at(part[side], s) == value_at(edge, a + s * (b - a))


@given(st.fractions(min_value=Fraction(1000001, 1000000), max_value=10**6))
def test_the_checkers_logarithm_encloses_the_true_one_closely(y: Fraction) -> None:
    low, high = logarithm(y)
    with localcontext(prec=60):
        true_logarithm = Decimal(y.numerator).ln() - Decimal(y.denominator).ln()
    assert low <= Fraction(true_logarithm) + Fraction(1, 10**40)
    assert Fraction(true_logarithm) - Fraction(1, 10**40) <= high
    assert high - low < Fraction(1, 10**16)
