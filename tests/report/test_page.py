"""The report as a file: it is self-contained, draws the tube of the design, states only what was run; and the commands that write it."""

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

pytestmark = pytest.mark.xdist_group("page")  # a worker builds every page once

LARGEST_PAGE = 2 << 20  # bytes


# ---------------------------------------------------------------------------------------------- contents of the file


@pytest.mark.parametrize("kind", [*KINDS, "moving"])
def test_a_page_is_self_contained_and_has_every_property_and_file(kind: str) -> None:
    controller, text = controller_of_kind(kind), report_html(kind)
    assert len(text.encode()) <= LARGEST_PAGE
    assert set(re.findall(r"https?://[^\s\"'<]+", text)) == {
        "http://www.w3.org/2000/svg"
    }  # the name of a namespace, which no browser fetches
    assert not re.search(r"\bsrc=|@import|url\((?!#|.\(#)", re.sub(r"`[^`]*`", "", text))
    assert set(re.findall(r'\bhref="([^"#]+)', text)) == set()
    for finding in controller.certificate.findings:
        assert f"<b>{finding.subject.label}</b>" in text
    assert text.count('<tr class="bad">') == 2 * len(
        controller.certificate.failures
    )  # one in the table of the certificate, one in that of requirements
    assert ("Not certified" in text) == (not controller.certificate.holds)
    for name, content in controller.files.items():
        assert name in text
        assert hashlib.sha256(content).hexdigest() in text


@pytest.mark.parametrize("kind", ["missions", "adaptive", "moving"])
def test_the_drawn_edges_are_those_of_the_design(kind: str) -> None:
    controller = controller_of_kind(kind)
    data = data_block(report_html(kind))
    t = np.linspace(0, float(controller.task.prescribed_time), SAMPLES + 1)
    for name, edge in zip(("low", "high"), controller.design.edges_at(t), strict=True):
        size = np.abs(edge).max()
        assert np.abs(np.array(data[name]) - edge).max() <= 10.0 ** (np.ceil(np.log10(size)) - 6)  # six digits of the largest
    assert len(data["sets"]) == len(controller.task.unsafe)
    for drawn_set, table in zip(data["sets"], controller.task.unsafe, strict=True):
        assert ("knots" in drawn_set) == (table.motion is not None)


def test_a_page_says_where_a_tube_meets_an_unsafe_set() -> None:
    """The name and the times agree with a search of the samples by this test."""
    controller, data = controller_of_kind("literal"), data_block(report_html("literal"))
    low, high = np.array(data["low"]), np.array(data["high"])
    t = np.linspace(0, data["t_c"], SAMPLES + 1)
    for unsafe in controller.task.unsafe_sets:
        lower, upper = (np.array([float(v) for v in edge]) for edge in (unsafe.lower, unsafe.upper))  # type: ignore[attr-defined]
        meets = ((low < upper) & (high > lower)).all(axis=1)
        intervals = [(a, b) for name, a, b, sure in data["meets"] if name == unsafe.name and sure]
        inside = np.any([(t >= a - 1e-9) & (t <= b + 1e-9) for a, b in intervals] or [np.zeros(len(t), bool)], axis=0)
        assert (meets == inside).all()
    assert data["meets"]
    assert all(f"At samples the tube meets {name}" in report_html("literal") for name, *_ in data["meets"])
    assert data_block(report_html("plain"))["meets"] == []


def test_texts_of_a_task_are_escaped_in_the_page() -> None:
    """Formulas may have characters that HTML reserves; names and units may not."""
    text = report_html("missions")
    assert "dock -&gt; eventually" in text
    assert "dock -> eventually" not in text


def test_the_page_is_the_same_for_the_same_task() -> None:
    controller = build(ROOT / "tasks" / "omni_s2.toml")
    second_page = page(controller, design_report(controller, 0.0), evidence(controller, ROOT / "tasks" / "omni_s2.toml")).decode()
    assert second_page == report_html("plain")


def test_faces_of_a_solid_are_flat_and_enclose_its_corners() -> None:
    """For a cut box every face is flat, no corner is beyond a face, and the faces close the solid, by Euler's formula."""
    points = np.array([p for p in np.ndindex(3, 3, 3) if sum(p) <= 4], dtype=float)
    corners, faces = convex_solid(points)
    edges = {frozenset(pair) for face in faces for pair in zip(face, [*face[1:], face[0]], strict=True)}
    assert len(corners) - len(edges) + len(faces) == 2
    for face in faces:
        a, b, c = corners[face[:3]]
        distances = (corners - a) @ np.cross(b - a, c - a)
        assert np.abs(distances[face]).max() < 1e-9
        assert (distances <= 1e-9).all() or (distances >= -1e-9).all()


# ---------------------------------------------------------------------------------------------- evidence


def test_the_bill_of_materials_is_cyclonedx() -> None:
    import jsonschema
    from referencing import Registry, Resource

    folder = importlib.resources.files("cyclonedx") / "schema" / "_res"
    schemas = {path.name: json.loads(path.read_text()) for path in folder.iterdir() if path.name.endswith(".json")}
    schema = schemas["bom-1.6.SNAPSHOT.schema.json"]
    resources = [(s["$id"], Resource.from_contents(s)) for s in schemas.values() if "$id" in s]
    for kind in ("plain", "adaptive"):
        controller = controller_of_kind(kind)
        document = data_block(report_html(kind), "bill")
        jsonschema.Draft7Validator(schema, registry=Registry().with_resources(resources)).validate(document)
        assert document == bill_of_materials(controller)
        hashes = {part["name"]: part["hashes"][0]["content"] for part in document["components"] if part["type"] == "file"}
        assert hashes == {name: hashlib.sha256(data).hexdigest() for name, data in controller.files.items()}


def test_the_table_of_misra_is_that_of_the_documentation() -> None:
    rows = re.findall(r"^\| (\d+\.\d+) \| (\w+) \| (.*) \| (.*) \|$", (ROOT / "docs" / "c.md").read_text(), re.M)
    assert rows == [(d.rule, d.kind, d.where, d.why) for d in DEVIATIONS.values()]


def test_evidence_reports_checks_as_they_ended(tool: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page quotes the checker. For a changed C checker and comparison fail, and the page reports that. Without tools nothing ran."""

    from stt_codegen.report.page.evidence import evidence

    for name in ("gcc", "clang", "cppcheck"):
        tool(name)
    assert "verified: omni_s2: P1 to P7 hold" in report_html("plain")
    controller = controller_of_kind("plain")
    text = controller.files["omni_s2.c"]
    mutation = b"smallest = width * 0.005F", b"smallest = width * 0.006F"
    assert text.count(mutation[0]) == 1
    mutated = replace(controller, files={**controller.files, "omni_s2.c": text.replace(*mutation)})
    failed = evidence(mutated, ROOT / "tasks" / "omni_s2.toml")
    outcomes = {check.name: check.has_passed for check in failed.checks}
    assert outcomes["stand-alone checker"] is False
    assert outcomes["compiled C beside an independent reference"] is False
    assert not failed.has_no_failure
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    without_tools = evidence(controller, None)
    assert {check.has_passed for check in without_tools.checks} == {None}
    assert without_tools.misra is None


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


def test_the_page_of_a_board_has_its_counts(tmp_path: Path, tool: Any) -> None:
    tool("arm-none-eabi-gcc"), tool("qemu-system-arm")
    path = tmp_path / "page.html"
    report(ROOT / "tasks" / "omni_s1.toml", out=path, board=["m4f"])
    result = re.search(r"Cortex-M4F, emulated</th><td>yes</td><td>(.*?)</td>", path.read_text())
    assert result is not None
    assert re.search(r"control: \d+ to \d+ instructions, \d+ B of stack", result[1])


def test_a_notebook_opens_the_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import webbrowser

    import stt_codegen as stt

    opened_urls = list[str]()
    monkeypatch.setattr(webbrowser, "open", opened_urls.append)
    controller = stt.build(ROOT / "tasks" / "omni_s1.toml")
    path = controller.report(tmp_path / "report.html")
    assert path == tmp_path / "report.html"
    assert opened_urls == [path.resolve().as_uri()]
    data = data_block(path.read_text())
    assert base64.b64decode(data["drive"]["wasm"])[:4] == b"\0asm"
    assert controller._repr_png_().startswith(b"\x89PNG")
