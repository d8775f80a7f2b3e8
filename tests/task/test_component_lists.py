"""Lists of clearance, least width and noise: turns, walls and theorems read every entry, and a bad list gets one message."""

from __future__ import annotations

import re
from fractions import Fraction

import pytest

from stt_codegen.errors import BadInput
from stt_codegen.task.load import parse_task
from stt_codegen.theorem.reading import read_task, uncovered_loop_feature
from tests.certify.test_bounds_by_component import HALL, SAMPLED, hall_files


def test_every_entry_takes_part_in_what_closed_axes_add() -> None:
    text = HALL.replace("prescribed_time", 'axes = ["x", "yaw"]\nperiodic = { yaw = 6.2832 }\nprescribed_time')
    text = re.sub(r"\[\[unsafe\]\]\nlower = \[3\.6.*", "", text, flags=re.S) + "[tube]\n"
    number, listed = (
        parse_task(f"{text}clearance = {c}\n[plant]\nnoise = {n}") for c, n in (("0.03", "0.01"), ("[0.03, 0.06]", "[0.01, 0]"))
    )
    added = [number.tube.clearance - Fraction("0.03"), number.plant.noise - Fraction("0.01")]  # type: ignore[operator]
    assert min(added) >= 0
    assert added[1] > 0
    assert listed.clearances == (Fraction("0.03") + added[0], Fraction("0.06") + added[0])
    assert listed.noise == (Fraction("0.01") + added[1], added[1])


def test_no_theorem_is_written_about_a_list() -> None:
    kinds = {"design": "refined", "scalar": "float"}
    for key in ("clearance", "min_width"):
        with pytest.raises(BadInput, match=rf"theorem: not yet about tube\.{key} by component: state one number"):
            read_task(hall_files(f"{key} = [0.1, 0.1]")["task.toml"].replace(b"motion", b"#").replace(b"spread", b"#"), kinds)
    noisy = re.sub(r"\[\[unsafe\]\]\nlower = \[3\.6.*", "", HALL, flags=re.S) + SAMPLED + "noise = [0.1, 0.1]"
    assert uncovered_loop_feature(read_task(noisy.encode(), kinds)).startswith("a control.u_max") is False
    assert uncovered_loop_feature(read_task(noisy.encode(), kinds)) == "a plant.noise by component"


BAD_LISTS = [
    ("[0.1]", r"has 1 entries; state_space\.lower has 2, and all must agree"),
    ("[0.1, 0.1, 0.1]", "has 3 entries"),
    ("[0.1, -0.1]", r"\[1\]: is -0\.1; it must be 0 or greater"),
    ('[0.1, "wide"]', r"\[1\]: is the text 'wide'; a number is needed"),
    ("[0.1, nan]", r"\[1\]: is NaN; a finite number is needed"),
    ("[]", "is an empty list"),
    ("[[0.1, 0.1], [0.1, 0.1]]", r"\[0\]: is a list; a number is needed"),
    ('"auto"', "is the text 'auto'; a number is needed, or a list with one for each dimension"),
    ("{ x = 0.1 }", "is a table; a number is needed, or a list with one for each dimension"),
    ("true", "is the boolean true; a number is needed, or a list with one for each dimension"),
    ("1e-10", r"is the number 1E-10; use 0 or a magnitude from 1e-9 to 1e9"),
    ("[0.1, 20000000000]", r"\[1\]: is the number 20000000000; use 0 or a magnitude"),
]


@pytest.mark.parametrize("key", ["tube.clearance", "tube.min_width", "plant.noise", "plant.noise_v"])
@pytest.mark.parametrize(("value", "message"), BAD_LISTS)
def test_a_bad_list_gets_one_message(key: str, value: str, message: str) -> None:
    table, _, name = key.partition(".")
    with pytest.raises(BadInput) as refusal:
        parse_task(f"{HALL}[{table}]\n{'order = 2' if name == 'noise_v' else ''}\n{name} = {value}")
    assert re.search(rf"{re.escape(key)}(: )?{message}", str(refusal.value)), refusal.value
    assert "\n" not in str(refusal.value).strip()


def test_the_list_of_a_room_with_an_outline_is_counted_before_its_walls_are_chosen() -> None:
    outline = HALL.replace("lower = [0, 0]\nupper = [4, 4]", "outline = [[0, 0], [4, 0], [4, 4], [2, 4], [2, 3.9], [0, 3.9]]")
    with pytest.raises(BadInput, match=r"tube\.clearance: has 3 entries"):
        parse_task(f"{outline}[tube]\nclearance = [0.1, 0.1, 0.1]")
