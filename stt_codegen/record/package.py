"""Package the emitted files for a build system, a simulator or ROS. Each kind of package is one entry of `KINDS`.

`generate --package` and the Python interface call `package`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from stt_codegen.decimals import decimal
from stt_codegen.emit import (
    Files,
    design_hash,
    extra_files,
    file_names,
    guard_name,
    phase_name,
    selftest_name,
    selftest_suites,
    unwrap_name,
    wrap_name,
)
from stt_codegen.errors import BadInput
from stt_codegen.files import require_certified_contents
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model
from stt_codegen.program.targets import TARGETS, TargetLanguage
from stt_codegen.program.targets.template_files import template
from stt_codegen.record.fmu import fmu_units
from stt_codegen.record.ros2 import ros2_package
from stt_codegen.record.sketch import sketch_words

CMAKE_TARGETS = frozenset(  # names that no library may have (CMake, policy CMP0037, and its generators)
    "all help clean edit_cache rebuild_cache install preinstall test package package_source "
    "ALL_BUILD ZERO_CHECK INSTALL RUN_TESTS PACKAGE".split()
)
ARDUINO_HEADERS = frozenset("arduino avr binary client hid ipaddress print printable server spi stream udp wire wiring".split())
# By kind of package: whether its tools refuse a task's name, and why, as the end of a sentence.
RESERVED_NAMES: Mapping[str, tuple[Callable[[str], bool], str]] = {
    "cmake": (lambda name: name in CMAKE_TARGETS, "a target of CMake's own"),
    "arduino": (lambda name: name.lower() in ARDUINO_HEADERS, "a header of Arduino's own"),
    "platformio": (lambda name: name.lower() in ARDUINO_HEADERS, "a header of Arduino's own"),
    "ros2": (lambda name: "__" in f"{name}_", "no name of a ROS package, which has no two underscores in a row"),
}
NEEDS_REAL_NUMBERS = "takes and gives real numbers, and this controller has none; use --scalar float"


def package(controller: EmittedController, kind: str, plant: Model | None = None) -> Files:
    """Return the files of a package by path. kind: of `KINDS`; plant: for `fmu` alone, gets units too.

    Raises `BadInput` where the kind cannot hold this controller or a file is not what the certificate is about, `MissingTool`
    without its compiler.
    """
    require_certified_contents(controller.files)
    is_reserved, reason = RESERVED_NAMES.get(kind, (lambda _: False, ""))
    if is_reserved(controller.task.name):
        raise BadInput(f"name: {controller.task.name!r} is {reason}; choose another name, or another --package")
    if kind == "fmu":
        if controller.program.tick is not None:
            raise BadInput(f"--package fmu: {NEEDS_REAL_NUMBERS}")
        if controller.task.closed_axes:
            raise BadInput("--package fmu: a unit does not count turns (periodic); package the C, which has <p>_unwrap")
        return fmu_units(controller, plant)
    if plant is not None:
        raise BadInput("--plant: is for --package fmu; leave it out")
    if kind == "ros2" and controller.program.tick is not None:
        raise BadInput(f"--package ros2: {NEEDS_REAL_NUMBERS}")
    return KINDS[kind](controller)


def _library(kind: str, controller: EmittedController) -> Files:
    """Return a folder <p>/ for a build system: its files, the C in src/, files for people in extras/."""
    prefix = controller.task.name
    common = file_names(prefix)
    inline, integers = controller.task.emit.math == "inline", controller.program.tick is not None
    sketch = "sketch_fixed.ino" if integers else "sketch.ino"
    words = {
        "prefix": prefix,
        "macro": prefix.upper(),
        "kind": controller.design.kind,
        "verdict": "certified" if controller.certificate.holds else "NOT CERTIFIED",
        "library": "" if inline or integers else "m",
        "selftest": controller.task.emit.selftest,
        "hash": design_hash(controller.task, controller.design),
        "is_stateful": controller.design.is_stateful,
        "order": controller.task.order,
        "outside": controller.task.control.outside,
        "differs": controller.task.uses_differences,
        "repeats": controller.task.repeat,
        "closed": bool(controller.task.closed_axes),
        "first_state": ", ".join(map(decimal, controller.task.initial_state)),
        **(sketch_words(controller) if kind in ("arduino", "platformio") else {}),
    }
    template_names = {
        "cmake": {"CMakeLists.txt": "CMakeLists.txt"},
        "arduino": {"library.properties": "library.properties", f"examples/{prefix}_loop/{prefix}_loop.ino": sketch},
        "platformio": {"library.json": "library.json", f"examples/{prefix}_loop/{prefix}_loop.ino": sketch},
    }[kind]
    if kind == "platformio" and integers:  # the example of integers names boards without a floating-point unit
        template_names[f"examples/{prefix}_loop/platformio.ini"] = "platformio.ini"
    optional = (guard_name, phase_name, wrap_name, unwrap_name, selftest_name)
    sources = [n for n in (common.header, common.source, *(name_of(prefix) for name_of in optional)) if n in controller.files]
    words["sources"] = " ".join(f"src/{name}" for name in sources if name.endswith(".c"))
    files = {f"src/{name}": controller.files[name] for name in sources}
    extras = extra_files(prefix, controller.design, controller.files)
    files |= {f"extras/{name}": data for name, data in extras.items()}
    files |= {path: template(f"package/{name}.j2").render(**words).encode() for path, name in template_names.items()}
    return {f"{prefix}/{path}": data for path, data in files.items()}


def _of_language(target: TargetLanguage, controller: EmittedController) -> Files:
    """Return a folder <p>/ for the build system of a target language, such as Rust, with the sources where it looks for them.

    Its tests call `control` at points where u is known, as `emit.selftest` does, unless rounding hides u there.
    """
    task, layout = controller.task, target.package
    assert layout is not None
    words: dict[str, Any] = {
        "prefix": task.name,
        "kind": controller.design.kind,
        "verdict": "certified" if controller.certificate.holds else "NOT CERTIFIED",
        "hash": design_hash(task, controller.design),
        target.key: target.printer(controller.program),
    }
    files = {path: template(f"{target.key}/{name}").render(**words).encode() for path, name in layout.templates.items()}
    files |= {path: controller.files[task.name + suffix] for suffix, path in layout.sources.items()}
    if layout.selftest is not None:
        path, name = layout.selftest
        with suppress(BadInput):  # rounding hides u: a package without tests
            test_suites = selftest_suites(task, controller.design, controller.program)
            files[path] = template(f"{target.key}/{name}").render(**words, suites=test_suites).encode()
    extras = extra_files(task.name, controller.design, controller.files)
    files |= {f"extras/{name}": data for name, data in extras.items()}
    return {f"{task.name}/{path}": data for path, data in files.items()}


KINDS: dict[str, Callable[[EmittedController], Files]] = {
    "plain": lambda controller: dict(controller.files),
    **{kind: partial(_library, kind) for kind in ("cmake", "arduino", "platformio")},
    **{target.key: partial(_of_language, target) for target in TARGETS if target.package},
    "fmu": fmu_units,
    "ros2": ros2_package,
}
