"""What the designer takes as the text of a task, the checker takes too: spellings of formulas reach comments of the C."""

from __future__ import annotations

from pathlib import Path

import pytest

from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_task
from stt_codegen.task import parse_task
from tests.support.checked_files import VERIFIED, verdict

TASK = """
name = "errand"
prescribed_time = 8
initial_state = [0.5, 0.5]
state_space = {{ lower = [0, 0], upper = [6, 6] }}
initial_set = {{ lower = [0.2, 0.2], upper = [0.8, 0.8] }}
target_set = {{ lower = [4, 4], upper = [5, 5] }}
region = [{{ name = "A", lower = [2, 0], upper = [4, 2] }}, {{ name = "B", lower = [3, 2], upper = [6, 6] }}]
mission = [{{ formula = '''{formula}''' }}]
"""


@pytest.mark.parametrize("formula", ["F A /\\ F B", "F A \\/ F B", "F\u00a0A &&\u2003F B", "F A\n and F B", "F A\t\t&& F B"])
def test_every_spelling_of_a_formula_that_is_certified_is_verified(formula: str, tmp_path: Path) -> None:
    text = TASK.format(formula=formula)
    controller = build_task(parse_task(text))
    answer = verdict({**controller.files, "task.toml": text.encode()}, tmp_path)
    assert answer.code == VERIFIED, answer.message


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mission = [{ formula = '''F A''' }]", "mission = []", "mission: is empty; add .*, or leave it out"),
        (
            "mission = [",
            'unsafe = [{ name = "", lower = [0, 5], upper = [1, 6] }]\nmission = [',
            r"unsafe\[0\]\.name: '' is no name",
        ),
    ],
)
def test_what_would_be_stated_and_empty_is_refused(old: str, new: str, message: str) -> None:
    text = TASK.format(formula="F A")
    assert old in text
    with pytest.raises(BadInput, match=message):
        parse_task(text.replace(old, new))
