"""What `design` prints beside the properties: notes on visits and on the tube that was taken, and lines about sampling."""

from __future__ import annotations

import dataclasses
import re

import pytest

from stt_codegen.effort import Effort
from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task
from stt_codegen.report import Analysis, controller_notes, design_report, sampling_lines
from stt_codegen.report.notes import VISIT_NOTE
from stt_codegen.task import parse_task
from tests.support.controllers import build_once

ERRAND = """
name = "errand"
prescribed_time = 10
initial_state = [0.5]
state_space = { lower = [0], upper = [10] }
initial_set = { lower = [0.2], upper = [0.8] }
region = [{ name = "a", lower = [4.5], upper = [8] }]
mission = [{ visit = "a", between = [0, 8] }]
"""
CART = """
name = "cart"
prescribed_time = 12
initial_state = [1, 1]
state_space = { lower = [0, 0], upper = [8, 5] }
initial_set = { lower = [0.6, 0.6], upper = [1.4, 1.4] }
target_set = { lower = [6.4, 3.4], upper = [7.4, 4.4] }
unsafe = [{ name = "rack", lower = [2.5, 0], upper = [3.2, 2.6] }, { name = "pallet", lower = [4.6, 2.9], upper = [5.3, 5] }]
"""


def test_a_mission_with_a_visit_at_one_moment_gets_a_note_and_one_with_stays_none() -> None:
    visiting = build_once(parse_task(ERRAND))
    assert VISIT_NOTE in design_report(visiting, 0.0).notes
    staying = build_once(parse_task(ERRAND.replace("between = [0, 8]", "between = [0, 8], stay = 1")))
    assert VISIT_NOTE not in tuple(controller_notes(staying))


def test_a_note_says_which_tube_was_taken_in_place_of_the_preferred_one() -> None:
    controller = build_once(parse_task(ERRAND))
    sentence = "the preferred tube is not certified (why); taken: one with least width 1 in place of 2"
    assert not any("the preferred tube" in note for note in controller_notes(controller))
    assert sentence in tuple(controller_notes(dataclasses.replace(controller, replaces=sentence)))


def test_where_the_worst_path_proves_the_period_no_line_says_that_nothing_does() -> None:
    """The conditions at each time prove a shorter period alone, and say so."""
    plant = "plant = { w_max = 0.1, g_min = 0.9, g_max = 1.1, noise = 0.01 }\n"
    controller = build_once(parse_task(f"{CART}{plant}body = [0.25, 0.25]\ncontrol = {{ period = 0.161, u_max = 1.2 }}\n"))
    proof = controller.certificate.proved_period
    assert proof is not None
    assert proof.paths
    lines = [line.text for line in sampling_lines(Analysis(controller).sampling(), None)]
    (shorter,) = (float(m[1]) for line in lines if (m := re.match(r"sample every (\S+) ms", line)))
    assert shorter < 161
    assert "period (P9) is proved for [plant] of the task, every 161 ms or faster" in lines[0]
    assert "a second proof" in lines[1]
    assert not any("no gain is proved" in line for line in lines)


def test_a_start_delay_that_narrows_windows_is_named_in_the_conflict() -> None:
    text = ERRAND.replace("between = [0, 8]", "between = [0, 3]") + "start_delay = 0.2\ntube = { max_speed = 1.8 }\n"
    with pytest.raises(NotCertified, match=r"a by 3 s \(start_delay takes 0\.8 s from either end of every window\)"):
        build_task(parse_task(text), effort=Effort(0.0))


@pytest.mark.parametrize(
    "options",
    [
        'control = { period = 0.02 }\nplant = { w_max = 0.1, lag = 0.05 }',
        'control = { period = 0.02, latency = 0.01 }\nplant = { w_max = 0.1 }',
        'control = { period = 0.02, velocity = "differences" }\nplant = { order = 2, w_max = 0.1 }',
        'control = { period = 0.02, u_norm = 3 }\nplant = { w_max = 0.1 }',
    ],
)  # fmt: skip
def test_a_task_without_a_tube_is_refused_for_its_own_reason_whatever_its_sampling(options: str) -> None:
    """The search for the reason leaves limits out, and must leave nothing out that others need."""
    with pytest.raises(NotCertified, match=r"no tube was found within tube\.max_speed = 0\.3"):
        build_task(parse_task(f"{CART}tube = {{ max_speed = 0.3 }}\n{options}\n"), effort=Effort(0.0))
