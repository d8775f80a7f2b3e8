"""The report as a file: it stands alone, what is drawn is the tube, what is said was run, and what the commands do."""

from __future__ import annotations

import base64
import hashlib
import importlib.resources
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stt_codegen.cli.design_commands.report import report
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build
from stt_codegen.report.figures.design_figures import design_report
from stt_codegen.report.page.bill_of_materials import bill_of_materials
from stt_codegen.report.page.evidence import evidence
from stt_codegen.report.page.misra import DEVIATIONS
from stt_codegen.report.page.page import page
from stt_codegen.report.page.scene import SAMPLES
from stt_codegen.report.page.solids import convex_solid
from tests.support.controllers import ROOT
from tests.support.pages import KINDS, controller_of_kind, data_block, report_html

pytestmark = pytest.mark.xdist_group("page")  # every page made once

MOST = 2 << 20  # bytes of a page


# ---------------------------------------------------------------------------------------------- what the file says


@pytest.mark.parametrize("kind", [*KINDS, "moving"])
def test_a_page_stands_alone_and_has_every_property_and_file(kind: str) -> None:
    controller, text = controller_of_kind(kind), report_html(kind)
    assert len(text.encode()) <= MOST
    assert set(re.findall(r"https?://[^\s\"'<]+", text)) == {"http://www.w3.org/2000/svg"}  # a name, which nothing fetches
    assert not re.search(r"\bsrc=|@import|url\((?!#|.\(#)", re.sub(r"`[^`]*`", "", text))
    assert set(re.findall(r'\bhref="([^"#]+)', text)) == set()
    for finding in controller.certificate.findings:
        assert f"<b>{finding.subject.label}</b>" in text
    assert text.count('<tr class="bad">') == 2 * len(controller.certificate.failures)  # the certificate, and requirements
    assert ("Not certified" in text) == (not controller.certificate.holds)
    for name, content in controller.files.items():
        assert name in text
        assert hashlib.sha256(content).hexdigest() in text


@pytest.mark.parametrize("kind", ["missions", "adaptive", "moving"])
def test_what_is_drawn_is_the_tube(kind: str) -> None:
    controller = controller_of_kind(kind)
    data = data_block(report_html(kind))
    t = np.linspace(0, float(controller.task.prescribed_time), SAMPLES + 1)
    for name, edge in zip(("low", "high"), controller.design.edges_at(t), strict=True):
        size = np.abs(edge).max()
        assert np.abs(np.array(data[name]) - edge).max() <= 10.0 ** (np.ceil(np.log10(size)) - 6)  # six digits of the largest
    assert len(data["sets"]) == len(controller.task.unsafe)
    for one, table in zip(data["sets"], controller.task.unsafe, strict=True):
        assert ("knots" in one) == (table.motion is not None)


def test_a_tube_that_collides_says_where() -> None:
    """By name and time, as a search of the samples of its own finds it."""
    controller, data = controller_of_kind("literal"), data_block(report_html("literal"))
    low, high = np.array(data["low"]), np.array(data["high"])
    t = np.linspace(0, data["t_c"], SAMPLES + 1)
    for one in controller.task.unsafe_sets:
        lower, upper = (np.array([float(v) for v in edge]) for edge in (one.lower, one.upper))  # type: ignore[attr-defined]
        meets = ((low < upper) & (high > lower)).all(axis=1)
        told = [(a, b) for name, a, b, sure in data["meets"] if name == one.name and sure]
        inside = np.any([(t >= a - 1e-9) & (t <= b + 1e-9) for a, b in told] or [np.zeros(len(t), bool)], axis=0)
        assert (meets == inside).all()
    assert data["meets"]
    assert all(f"At samples the tube meets {name}" in report_html("literal") for name, *_ in data["meets"])
    assert data_block(report_html("plain"))["meets"] == []


def test_words_of_a_task_are_words_of_the_page() -> None:
    """Formulas have what HTML means otherwise. (Names and units may not.)"""
    text = report_html("missions")
    assert "dock -&gt; eventually" in text
    assert "dock -> eventually" not in text


def test_the_page_is_the_same_for_the_same_task() -> None:
    controller = build(ROOT / "tasks" / "omni_s2.toml")
    again = page(controller, design_report(controller, 0.0), evidence(controller, ROOT / "tasks" / "omni_s2.toml")).decode()
    assert again == report_html("plain")


def test_faces_of_a_solid_hold_its_corners() -> None:
    """Of a cut box: every face is flat, no corner is beyond one, and the faces close the body (Euler)."""
    points = np.array([p for p in np.ndindex(3, 3, 3) if sum(p) <= 4], dtype=float)
    corners, faces = convex_solid(points)
    edges = {frozenset(pair) for face in faces for pair in zip(face, [*face[1:], face[0]], strict=True)}
    assert len(corners) - len(edges) + len(faces) == 2
    for face in faces:
        a, b, c = corners[face[:3]]
        beyond = (corners - a) @ np.cross(b - a, c - a)
        assert np.abs(beyond[face]).max() < 1e-9
        assert (beyond <= 1e-9).all() or (beyond >= -1e-9).all()


# ---------------------------------------------------------------------------------------------- evidence


def test_the_bill_of_materials_is_cyclonedx() -> None:
    import jsonschema
    from referencing import Registry, Resource

    folder = importlib.resources.files("cyclonedx") / "schema" / "_res"
    known = {one.name: json.loads(one.read_text()) for one in folder.iterdir() if one.name.endswith(".json")}
    schema = known["bom-1.6.SNAPSHOT.schema.json"]
    others = [(s["$id"], Resource.from_contents(s)) for s in known.values() if "$id" in s]
    for kind in ("plain", "adaptive"):
        controller = controller_of_kind(kind)
        found = data_block(report_html(kind), "bill")
        jsonschema.Draft7Validator(schema, registry=Registry().with_resources(others)).validate(found)
        assert found == bill_of_materials(controller)
        hashes = {one["name"]: one["hashes"][0]["content"] for one in found["components"] if one["type"] == "file"}
        assert hashes == {name: hashlib.sha256(data).hexdigest() for name, data in controller.files.items()}


def test_the_table_of_misra_is_that_of_the_documentation() -> None:
    rows = re.findall(r"^\| (\d+\.\d+) \| (\w+) \| (.*) \| (.*) \|$", (ROOT / "docs" / "c.md").read_text(), re.M)
    assert rows == [(d.rule, d.kind, d.where, d.why) for d in DEVIATIONS.values()]


def test_what_was_run_is_told_as_it_came_out(tool: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The checker's own words; of a C that is another the checker and the comparison say no, and so does the page."""

    from stt_codegen.report.page.evidence import evidence

    for name in ("gcc", "clang", "cppcheck"):
        tool(name)
    assert "yes: omni_s2: P1 to P7 hold" in report_html("plain")
    controller = controller_of_kind("plain")
    text = controller.files["omni_s2.c"]
    bend = b"least = room * 0.005F", b"least = room * 0.006F"
    assert text.count(bend[0]) == 1
    bent = replace(controller, files={**controller.files, "omni_s2.c": text.replace(*bend)})
    found = evidence(bent, ROOT / "tasks" / "omni_s2.toml")
    said = {one.name: one.has_passed for one in found.checks}
    assert said["stand-alone checker"] is False
    assert said["compiled C beside an independent reference"] is False
    assert not found.has_no_failure
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    without = evidence(controller, None)
    assert {one.has_passed for one in without.checks} == {None}
    assert without.misra is None


# ---------------------------------------------------------------------------------------------- commands


def test_the_command_writes_one_file(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    report(ROOT / "tasks" / "omni_s1.toml")
    assert [p.name for p in tmp_path.iterdir()] == ["omni_s1.report.html"]
    assert "omni_s1.report.html" in capsys.readouterr().out
    with pytest.raises(BadInput, match=r"--out page.pdf: is no page"):
        report(ROOT / "tasks" / "omni_s1.toml", out=Path("page.pdf"))
    with pytest.raises(BadInput, match=r"--board m9: is none of m0, "):
        report(ROOT / "tasks" / "omni_s1.toml", board=["m9"])


def test_a_board_is_told_with_its_counts(tmp_path: Path, tool: Any) -> None:
    tool("arm-none-eabi-gcc"), tool("qemu-system-arm")
    path = tmp_path / "page.html"
    report(ROOT / "tasks" / "omni_s1.toml", out=path, board=["m4f"])
    told = re.search(r"Cortex-M4F, emulated</th><td>yes</td><td>(.*?)</td>", path.read_text())
    assert told is not None
    assert re.search(r"control: \d+ to \d+ instructions, \d+ B of stack", told[1])


def test_a_notebook_opens_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import webbrowser

    import stt_codegen as stt

    opened_urls = list[str]()
    monkeypatch.setattr(webbrowser, "open", opened_urls.append)
    controller = stt.build(ROOT / "tasks" / "omni_s1.toml")
    path = controller.report(tmp_path / "own.html")
    assert path == tmp_path / "own.html"
    assert opened_urls == [path.resolve().as_uri()]
    data = data_block(path.read_text())
    assert base64.b64decode(data["drive"]["wasm"])[:4] == b"\0asm"
    assert controller._repr_png_().startswith(b"\x89PNG")
