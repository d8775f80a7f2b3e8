"""The report: one HTML file that stands alone, with the tube over time, the certificate, and the files that it is about.

Everything in it comes from the controller. The page asks no network and no other file: style, script (templates/report/) and data
are in it.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from fractions import Fraction
from typing import Any

import numpy as np

from stt_codegen.certify.certificate import Finding
from stt_codegen.certify.schedule import told_visit
from stt_codegen.designs.grid import tube_at
from stt_codegen.emit.render import notice, template, template_folder
from stt_codegen.pipeline import Controller
from stt_codegen.report.design import DesignReport
from stt_codegen.report.outlines import Array, Plane, outline, target_outline
from stt_codegen.task.motion import Course
from stt_codegen.task.sets import ConvexSet
from stt_codegen.task.shapes import Unsafe

SAMPLES = 600  # of the tube over time, as it is drawn; between two of them the page goes straight
DIGITS = 6  # of a number that is drawn


def page(controller: Controller, report: DesignReport) -> bytes:
    """The report as UTF-8."""
    folder = template_folder() / "report"
    data = json.dumps(document(controller, report), separators=(",", ":")).replace("</", "<\\/")
    return (
        template("report/page.html.j2")
        .render(
            report=report,
            notice=" ".join(notice(controller.task, controller.certificate)),
            style=(folder / "page.css").read_text(encoding="utf-8"),
            script=(folder / "page.js").read_text(encoding="utf-8"),
            data=data,
            files=[(name, len(text), hashlib.sha256(text).hexdigest()) for name, text in controller.files.items()],
            said=told_visit,
            findings=[_finding(one, controller) for one in controller.certificate.findings],
        )
        .encode()
    )


def document(controller: Controller, report: DesignReport) -> dict[str, Any]:
    """What the page draws. Lengths in the task's units, times in seconds; outlines by pair of axes, "0,1"."""
    task = controller.task
    t = np.linspace(0.0, float(task.prescribed_time), SAMPLES + 1)
    low, high = tube_at(controller.design, t)
    planes = list(itertools.combinations(range(task.dimension), 2))
    grown = any(task.half_extents)
    sets = [
        _set(bare.name, bare, planes, course) | ({"grown": _outlines(large, planes)} if grown else {})
        for bare, large, course in zip(task.bare, task.obstacles, task.courses, strict=True)
    ]
    regions = [
        _set(name, shape.within(task.state_space, task.own_axes(shape)), planes, None)
        for name, shape in task.regions.items()
        if isinstance(shape, Unsafe)
    ]
    return {
        "t_c": float(task.prescribed_time),
        "cycle": report.cycle,
        "axes": list(task.axis_labels),
        "planes": [list(p) for p in planes],
        "space": [_numbers(task.state_space.lower), _numbers(task.state_space.upper)],
        "start": [_numbers(task.start.lower), _numbers(task.start.upper)],
        "target": {_key(p): _rounded(target_outline(task, p)) for p in planes} if task.target_set is not None else {},
        "low": _rounded(low),
        "high": _rounded(high),
        "sets": sets,
        "regions": regions,
        "visits": [[one.entry, v.state, v.begin, v.end] for one in report.mission for v in one.visits],
    }


def _finding(one: Finding, controller: Controller) -> dict[str, Any]:
    """A row of the certificate; time: what the page goes to where the margin is least."""
    return {
        "code": one.code,
        "statement": one.statement,
        "holds": one.holds,
        "margin": f"{float(one.margin):.3g}" + (" s" if one.in_time or one.code == "P9" else "") if one.margin else "",
        "place": one.place(controller.certificate.axes),
        "time": None if one.time is None else float(sum(one.time) / 2),
    }


def _set(name: str, convex: ConvexSet, planes: list[Plane], course: Course | None) -> dict[str, Any]:
    """A set: its outlines, and how it moves: knots (time and displacement), and when it is unsafe."""
    found: dict[str, Any] = {"name": name, "outline": _outlines(convex, planes)}
    if course is not None:
        found["knots"] = [[float(at), *_numbers(by)] for at, by in course.knots]
        found["window"] = None if course.window is None else _numbers(course.window)
    return found


def _outlines(convex: ConvexSet, planes: list[Plane]) -> dict[str, Any]:
    return {_key(plane): _rounded(outline(convex, plane)) for plane in planes}


def _key(plane: Plane) -> str:
    return f"{plane[0]},{plane[1]}"


def _numbers(values: tuple[Fraction, ...]) -> list[float]:
    return [float(v) for v in values]


def _rounded(values: Array) -> Any:
    """As nested lists, of DIGITS significant digits of the largest."""
    size = float(np.abs(values).max(initial=0.0)) or 1.0
    return np.round(values, max(0, DIGITS - int(np.ceil(np.log10(size))))).tolist()
