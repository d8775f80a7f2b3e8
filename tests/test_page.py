"""The report: one page that stands alone and shows the tube that is certified."""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT

from stt_codegen.cli.report import report
from stt_codegen.designs.grid import tube_at
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import Controller, build, build_task
from stt_codegen.report.design import design_report
from stt_codegen.report.page import SAMPLES, document, page
from stt_codegen.task import parse_task

MOST = 2 << 20  # bytes of a page
KINDS = {
    "missions": ("courier", None),
    "for ever": ("watchman", None),
    "three dimensions, order 2": ("drone", None),
    "many dimensions": ("arm", None),
    "adaptive": ("omni_s2", "adaptive"),
    "literal": ("omni_s2", "literal"),
}
MOVING = """
name = "crossing"
prescribed_time = 10
initial_state = [1, 1]
state_space = { lower = [0, 0], upper = [10, 6] }
initial_set = { lower = [0.5, 0.5], upper = [1.5, 1.5] }
target_set = { lower = [8.5, 4.5], upper = [9.5, 5.5] }
unsafe = [{ name = "cart", lower = [4, 0], upper = [5, 2], motion = [{ at = 0, by = [0, 0] }, { at = 8, by = [0, 4] }] }]
"""


def controller_of(kind: str) -> Controller:
    if kind == "moving":
        return build_task(parse_task(MOVING))
    name, design = KINDS[kind]
    return build(ROOT / "tasks" / f"{name}.toml", design, uncertified=design == "literal")


def made(controller: Controller) -> str:
    return page(controller, design_report(controller, 0.0)).decode()


def data_of(text: str) -> dict[str, Any]:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.S)
    assert found is not None
    data: dict[str, Any] = json.loads(found[1])
    return data


@pytest.mark.parametrize("kind", [*KINDS, "moving"])
def test_a_page_stands_alone_and_has_every_property_and_file(kind: str) -> None:
    controller = controller_of(kind)
    text = made(controller)
    assert len(text.encode()) <= MOST
    assert set(re.findall(r"https?://[^\s\"'<]+", text)) == {"http://www.w3.org/2000/svg"}  # a name, which nothing fetches
    assert not re.search(r"\b(src|href)=|@import|url\((?!#)", text)
    for finding in controller.certificate.findings:
        assert f"<b>{finding.code}</b>" in text
    assert text.count('<tr class="bad">') == len(controller.certificate.failures)
    assert ("Not certified" in text) == (not controller.certificate.holds)
    for name, content in controller.files.items():
        assert name in text
        assert hashlib.sha256(content).hexdigest() in text


@pytest.mark.parametrize("kind", ["missions", "adaptive", "moving"])
def test_what_is_drawn_is_the_tube(kind: str) -> None:
    controller = controller_of(kind)
    data = data_of(made(controller))
    t = np.linspace(0, float(controller.task.prescribed_time), SAMPLES + 1)
    for name, edge in zip(("low", "high"), tube_at(controller.design, t), strict=True):
        size = np.abs(edge).max()
        assert np.abs(np.array(data[name]) - edge).max() <= 10.0 ** (np.ceil(np.log10(size)) - 6)  # six digits of the largest
    assert len(data["sets"]) == len(controller.task.unsafe)
    for one, table in zip(data["sets"], controller.task.unsafe, strict=True):
        assert ("knots" in one) == (table.motion is not None)


def test_words_of_a_task_are_words_of_the_page() -> None:
    """Formulas have what HTML means otherwise. (Names and units may not.)"""
    text = made(controller_of("missions"))
    assert "dock -&gt; eventually" in text
    assert "dock -> eventually" not in text


@pytest.mark.parametrize("kind", ["missions", "for ever", "three dimensions, order 2", "literal", "moving"])
def test_a_browser_draws_it_without_a_complaint(kind: str, tool: Any, tmp_path: Path) -> None:
    controller = controller_of(kind)
    path = tmp_path / "page.html"
    path.write_text(made(controller))
    command = [tool("chromium"), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}"]
    command += ["--enable-logging=stderr", "--virtual-time-budget=2000", "--dump-dom", path.as_uri()]
    result = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    assert "CONSOLE" not in result.stderr, result.stderr[-2000:]
    assert result.stdout.count("<svg") == 2
    assert 'class="now" x="' in result.stdout
    assert result.stdout.count('class="band"') == controller.task.dimension
    assert ">0.00 s</output>" in result.stdout


def test_the_command_writes_one_file(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    report(ROOT / "tasks" / "omni_s1.toml")
    assert [p.name for p in tmp_path.iterdir()] == ["omni_s1.report.html"]
    assert "omni_s1.report.html" in capsys.readouterr().out
    report(ROOT / "tasks" / "omni_s1.toml", json=True)
    assert json.loads(capsys.readouterr().out)["page"] == "omni_s1.report.html"
    with pytest.raises(BadInput, match=r"--out page.pdf: is no page"):
        report(ROOT / "tasks" / "omni_s1.toml", out=Path("page.pdf"))


def test_the_document_is_the_same_for_the_same_task() -> None:
    one, other = (document(c, design_report(c, 0.0)) for c in (controller_of("missions"), controller_of("missions")))
    assert one == other
