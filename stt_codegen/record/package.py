"""The emitted files as something that a build system, a simulator or ROS takes. One kind is one entry of `KINDS`."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from functools import partial
from typing import Any

from stt_codegen.emit.naming import file_names, guard_name, phase_name, rust_name, selftest_name, wrap_name
from stt_codegen.emit.render import Files, design_hash, template
from stt_codegen.emit.selftest import suites
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import Controller
from stt_codegen.plants import Model
from stt_codegen.program.print.rust import RustPrinter
from stt_codegen.record.fmu import fmu_units
from stt_codegen.record.ros2 import ros2_package
from stt_codegen.report.design import input_report

CMAKE_TARGETS = frozenset(  # what no library may be called (CMake, policy CMP0037, and its generators)
    "all help clean edit_cache rebuild_cache install preinstall test package package_source "
    "ALL_BUILD ZERO_CHECK INSTALL RUN_TESTS PACKAGE".split()
)
NO_INTEGERS = "takes and gives real numbers, and this controller has none; use --scalar float"
PERIOD = Fraction(1, 100)  # seconds, the longest of the example sketch


def loop_period(controller: Controller) -> Fraction:
    """Seconds between the example's steps: emit.tick_period, or control.period; else at most `PERIOD` and what is proved for the
    task's plant, in whole microseconds, and within the steps that an adaptive certificate allows."""
    task, steps = controller.task, controller.certificate.steps
    if task.emit.tick_period is not None:
        return task.emit.tick_period
    if task.control.period is not None:
        return Fraction(max(1, math.floor(task.control.period * 10**6)), 10**6)
    sampling = input_report(controller).sampling
    proved = None if sampling is None else sampling.at_this_gain
    period = PERIOD if proved is None else min(PERIOD, Fraction(proved.period))
    if steps is not None:
        period = min(max(period, steps[0] + Fraction(1, 10**6)), steps[1])
    return Fraction(max(1, math.floor(period * 10**6)), 10**6)


def package(controller: Controller, kind: str, plant: Model | None = None) -> Files:
    """The files by path. kind: of `KINDS`; plant: for `fmu` alone, of which units are made too. Raises `BadInput` for what a kind
    cannot have, `MissingTool` without what it takes."""
    if kind == "fmu":
        if controller.program.tick is not None:
            raise BadInput(f"--package fmu: {NO_INTEGERS}")
        return fmu_units(controller, plant)
    if plant is not None:
        raise BadInput("--plant: is for --package fmu; leave it out")
    if kind == "ros2" and controller.program.tick is not None:
        raise BadInput(f"--package ros2: {NO_INTEGERS}")
    return KINDS[kind](controller)


def _library(kind: str, controller: Controller) -> Files:
    """In a folder <p>/: sources in src/, the certificate and the Python in extras/, and what the build system reads."""
    prefix = controller.task.name
    if kind == "cmake" and prefix in CMAKE_TARGETS:
        raise BadInput(f"name: {prefix!r} is a target of CMake's own; choose another name, or another --package")
    header, source, module, proof = file_names(prefix)
    inline, integers = controller.task.emit.math == "inline", controller.program.tick is not None
    sketch = "sketch_fixed.ino" if integers else "sketch.ino"
    period, space = loop_period(controller), controller.task.state_space
    low, high = float(min(space.lower)), float(max(space.upper))
    words = {
        "prefix": prefix,
        "macro": prefix.upper(),
        "kind": controller.design.kind,
        "verdict": "certified" if controller.certificate.holds else "NOT CERTIFIED",
        "library": "" if inline or integers else "m",
        "ticks": controller.task.emit.tick_period is not None,
        "selftest": controller.task.emit.selftest,
        "hash": design_hash(controller.task, controller.design),
        "adaptive": controller.design.stateful,
        "order": controller.task.order,
        "outside": controller.task.control.outside,
        "differs": controller.task.differs,
        "repeats": controller.task.repeat,
        "period_us": int(period * 10**6),
        "period_ms": f"{float(period * 1000):g}",
        "period_rest": (period * 10**6).numerator % (period * 10**6).denominator,
        "period_parts": (period * 10**6).denominator,
        "low": f"{low:.9g}",
        "range": f"{high - low:.9g}",
        "most": f"{float((max if integers else min)(controller.task.u_max or (1,))):.9g}",
        "scale": f"{float(max(map(abs, controller.task.state_space.upper))):.9g}",
    }
    own = {
        "cmake": {"CMakeLists.txt": "CMakeLists.txt"},
        "arduino": {"library.properties": "library.properties", f"examples/{prefix}_loop/{prefix}_loop.ino": sketch},
        "platformio": {"library.json": "library.json", f"examples/{prefix}_loop/{prefix}_loop.ino": sketch},
    }[kind]
    if kind == "platformio" and integers:  # whose boards are many
        own[f"examples/{prefix}_loop/platformio.ini"] = "platformio.ini"
    sources = [
        name
        for name in (header, source, guard_name(prefix), phase_name(prefix), wrap_name(prefix), selftest_name(prefix))
        if name in controller.files
    ]
    words["sources"] = " ".join(f"src/{name}" for name in sources if name.endswith(".c"))
    files = {f"src/{name}": controller.files[name] for name in sources}
    files |= {f"extras/{name}": controller.files[name] for name in (module, proof)}
    files |= {path: template(f"package/{name}.j2").render(**words).encode() for path, name in own.items()}
    return {f"{prefix}/{path}": data for path, data in files.items()}


def _crate(controller: Controller) -> Files:
    """Of a task with emit.rust: a crate <p>/ without dependencies, or where it calls mathematics with libm for who has no std.
    `cargo test` calls it where u is known (as `emit.selftest` does), where so much can be told of u."""
    task, printer = controller.task, RustPrinter(controller.program)
    words: dict[str, Any] = {
        "prefix": task.name,
        "kind": controller.design.kind,
        "verdict": "certified" if controller.certificate.holds else "NOT CERTIFIED",
        "hash": design_hash(task, controller.design),
        "mathematics": printer.library(),
        "rust": printer,
    }
    files = {"Cargo.toml": template("package/Cargo.toml.j2").render(**words).encode()}
    files["src/lib.rs"] = controller.files[rust_name(task.name)]
    with suppress(BadInput):  # too much rounding to tell
        words["suites"] = suites(task, controller.design, controller.program)
        files["tests/selftest.rs"] = template("package/selftest.rs.j2").render(**words).encode()
    _, _, module, proof = file_names(task.name)
    files |= {f"extras/{name}": controller.files[name] for name in (module, proof)}
    return {f"{task.name}/{path}": data for path, data in files.items()}


KINDS: dict[str, Callable[[Controller], Files]] = {
    "plain": lambda controller: controller.files,
    **{kind: partial(_library, kind) for kind in ("cmake", "arduino", "platformio")},
    "rust": _crate,
    "fmu": fmu_units,
    "ros2": ros2_package,
}
