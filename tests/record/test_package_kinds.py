"""Packages of every kind build with their tools: CMake as a subdirectory and installed, Arduino's core for AVR with the sketch."""

from __future__ import annotations

import configparser
import dataclasses
import json
import subprocess
from functools import cache
from pathlib import Path

import pytest
from typer.testing import CliRunner

from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput
from stt_codegen.files import write_files
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import plant_of
from stt_codegen.record.package import KINDS, package
from stt_codegen.task.load import load_task
from tests.support.controllers import ROOT, build_once
from tests.support.missing_tools import skip_without

MAIN = """#include <stdio.h>
#include "omni_s2.h"
int main(void)
{
    const omni_s2_real x[OMNI_S2_N] = {0.25F, 0.25F};
    omni_s2_real u[OMNI_S2_N];
    printf("%d\\n", (int)omni_s2_control(0.0F, x, u));
    return 0;
}
"""
AVR_CORE = Path("/usr/share/arduino/hardware/arduino/avr")


@cache
def controller_of_design(design: str = "refined") -> EmittedController:
    return build_once(load_task(ROOT / "tasks" / "omni_s2.toml").with_options(design))


def run(*command: object, folder: Path) -> str:
    """Run a command that must succeed in the folder, and return its standard output."""
    result = subprocess.run([str(c) for c in command], cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def build_and_run(lists: str, folder: Path, *options: str) -> str:
    """Build `MAIN` with these lines of CMakeLists.txt in a new folder, run it, and return its output."""
    folder.mkdir()
    (folder / "main.c").write_text(MAIN)
    (folder / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.13)\nproject(user C)\nadd_executable(user main.c)\n" + lists
    )
    run("cmake", "-S", ".", "-B", "build", *options, folder=folder)
    run("cmake", "--build", "build", folder=folder)
    return run(folder / "build" / "user", folder=folder).strip()


def test_cmake_builds_the_package_as_a_subdirectory_and_installed(tool, tmp_path) -> None:
    for name in ("cmake", "gcc"):
        tool(name)
    write_files(tmp_path, package(controller_of_design(), "cmake"))
    library = tmp_path / "omni_s2"
    link = "target_link_libraries(user PRIVATE omni_s2::omni_s2)\n"
    assert build_and_run(f'add_subdirectory("{library}" omni_s2)\n{link}', tmp_path / "sub") == "0"
    run("cmake", "-S", library, "-B", "b", f"-DCMAKE_INSTALL_PREFIX={tmp_path / 'installed'}", folder=tmp_path)
    run("cmake", "--build", "b", folder=tmp_path)
    run("cmake", "--install", "b", folder=tmp_path)
    output = build_and_run(
        f"find_package(omni_s2 REQUIRED)\n{link}", tmp_path / "installed_user", f"-DCMAKE_PREFIX_PATH={tmp_path / 'installed'}"
    )
    assert output == "0"


@pytest.mark.parametrize("name", ["omni_s2", "crane", pytest.param("gantry", marks=pytest.mark.slow)])
def test_the_arduino_library_and_its_sketch_compile_for_an_uno(name: str, tool, tmp_path) -> None:
    compiler, linker = tool("avr-gcc"), tool("avr-g++")
    if not AVR_CORE.is_dir():
        skip_without("arduino-core-avr is not installed")
    write_files(tmp_path, package(build_once(load_task(ROOT / "tasks" / f"{name}.toml")), "arduino"))
    library = tmp_path / name
    core, variant = AVR_CORE / "cores" / "arduino", AVR_CORE / "variants" / "standard"
    flags = ["-mmcu=atmega328p", "-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_AVR_UNO", "-Os", "-ffunction-sections"]
    flags += [f"-I{core}", f"-I{variant}", f"-I{library / 'src'}"]
    sketch = library / "examples" / f"{name}_loop" / f"{name}_loop.ino"
    run(
        linker,
        *flags,
        "-Wall",
        "-Werror",
        "-std=gnu++11",
        "-x",
        "c++",
        "-include",
        "Arduino.h",
        "-c",
        sketch,
        "-o",
        "sketch.o",
        folder=tmp_path,
    )
    for source in (library / "src").glob("*.c"):
        run(compiler, *flags, "-Wall", "-Werror", "-std=gnu11", "-ffp-contract=off", "-c", source, folder=tmp_path)
    decimal_digits = "-DDECIMAL_DIG=__DECIMAL_DIG__"  # the core needs it in C++, where avr-gcc 5 does not define it
    for part in (*core.glob("*.c"), *core.glob("*.cpp")):
        driver = [linker, "-std=gnu++11", "-fpermissive", "-fno-exceptions"] if part.suffix == ".cpp" else [compiler]
        run(*driver, *flags, decimal_digits, "-w", "-c", part, "-o", f"core_{part.stem}_{part.suffix[1:]}.o", folder=tmp_path)
    objects = sorted(tmp_path.glob("*.o"))
    run(linker, "-mmcu=atmega328p", "-Wl,--gc-sections", *objects, "-lm", "-o", "uno.elf", folder=tmp_path)
    sizes = run(tool("avr-size"), "uno.elf", folder=tmp_path).splitlines()[1].split()
    assert int(sizes[0]) + int(sizes[1]) <= 32256  # flash of an Uno less its boot loader
    assert int(sizes[1]) + int(sizes[2]) <= 2048 - 512  # memory of an Uno, less 512 bytes for the stack
    if name != "omni_s2":  # the controller in integers has its tables in flash, and calls no function of floats
        library_size = run(tool("avr-size"), f"{name}.o", folder=tmp_path).splitlines()[1].split()
        assert (library_size[1], library_size[2]) == ("0", "0")
        assert "sf" not in run(tool("avr-nm"), "-u", f"{name}.o", folder=tmp_path)  # __addsf3 and the like


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("drone", {}),
        ("drone", {"control": {"outside": "stop"}, "plant": {"noise": "0.002", "noise_v": "0.01"}}),
        ("omni_board", {}),
        ("omni_board", {"control": {"outside": "hold"}}),
        ("omni_s2", {"control": {"outside": "stop"}, "emit": {"selftest": True}}),
        ("gantry", {"emit": {"selftest": False}}),
        ("crane", {}),
    ],
)
def test_every_sketch_calls_functions_that_its_header_declares(name: str, changed: dict, tool, tmp_path) -> None:
    """The sketch compiles as C++ against a stub of Arduino's header."""
    controller = build_once(load_task(ROOT / "tasks" / f"{name}.toml").changed(**changed))
    write_files(tmp_path, package(controller, "arduino"))
    (tmp_path / "Arduino.h").write_text(
        "#include <math.h>\n#include <stdint.h>\n#define LED_BUILTIN 13\n#define OUTPUT 1\n#define HIGH 1\n#define LOW 0\n"
        "int analogRead(int pin); void analogWrite(int pin, int value); void pinMode(int pin, int mode); unsigned long micros();\n"
        "void digitalWrite(int pin, int value);\n"
        "template <class T> T constrain(T v, int a, int b) { return v < a ? a : v > b ? b : v; }\n"
    )
    library = tmp_path / name
    sketch = library / "examples" / f"{name}_loop" / f"{name}_loop.ino"
    flags = ["-Wall", "-Wextra", "-Werror", f"-I{tmp_path}", f"-I{library / 'src'}", "-std=gnu++11", "-x", "c++"]
    run(tool("g++"), *flags, "-include", "Arduino.h", "-fsyntax-only", sketch, folder=tmp_path)
    text, outside = sketch.read_text(), controller.task.control.outside
    assert f"{name}_{'control' if outside == 'return' else 'guard'}" in text
    assert (library / "src" / f"{name}_guard.c").exists() == (outside != "return")


@pytest.mark.parametrize("design", ["refined", "adaptive"])
@pytest.mark.parametrize("kind", [k for k in KINDS if k not in ("rust", "fmu", "ros2")])  # these have files of tests
def test_every_package_has_the_same_sources_and_its_certificate(kind: str, design: str) -> None:
    files = package(controller_of_design(design), kind)
    by_name = {Path(path).name: data for path, data in files.items()}
    assert all(by_name[name] == data for name, data in controller_of_design(design).files.items())
    if kind == "platformio":
        document = json.loads(by_name["library.json"])
        assert document["headers"] == "omni_s2.h"
        assert "certified" in document["description"]
    if kind in ("arduino", "platformio") and design == "adaptive":
        sketch = by_name["omni_s2_loop.ino"].decode()
        assert sketch.index("omni_s2_alpha_init(") < sketch.index("omni_s2_alpha_step(") < sketch.index("omni_s2_control(")
        period = int(sketch.split("PERIOD = ")[1].split("UL")[0])
        assert period * 10**-6 <= float(controller_of_design(design).certificate.steps[1])


def test_platformio_lists_boards_without_a_float_unit_for_integers() -> None:
    files = package(build_once(load_task(ROOT / "tasks" / "gantry.toml")), "platformio")
    boards = configparser.ConfigParser()
    boards.read_string(files["gantry/examples/gantry_loop/platformio.ini"].decode())
    assert [boards[f"env:{name}"]["board"] for name in ("uno", "pico", "c3")] == ["uno", "pico", "esp32-c3-devkitm-1"]
    assert not any(path.endswith(".ini") for path in package(controller_of_design(), "platformio"))


def test_the_command_writes_a_package_and_refuses_to_record_one(tmp_path) -> None:
    task = str(ROOT / "tasks" / "omni_s2.toml")
    result = CliRunner().invoke(app, ["generate", task, "--package", "platformio", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "omni_s2" / "src" / "omni_s2.c").read_bytes() == controller_of_design().files["omni_s2.c"]
    refused = CliRunner().invoke(app, ["generate", task, "--package", "cmake", "--record", str(tmp_path / "g")])
    assert "give one of them" in str(refused.exception)


@pytest.mark.parametrize("name", ["install", "help", "ALL_BUILD"])
def test_a_name_that_cmake_has_itself_is_refused(name: str) -> None:
    controller = build_once(load_task(ROOT / "tasks" / "omni_s2.toml").changed(name=name))
    with pytest.raises(BadInput, match=f"name: '{name}' is a target of CMake's own"):
        package(controller, "cmake")
    assert package(controller, "plain")


@pytest.mark.parametrize(
    ("name", "kind", "reason"),
    [
        ("Arduino", "arduino", "a header of Arduino's own"),
        ("wire", "platformio", "a header of Arduino's own"),
        ("left__arm", "ros2", "no two underscores in a row"),
        ("arm_", "ros2", "no two underscores in a row"),
    ],
)
def test_a_name_that_a_kind_of_package_cannot_have_is_refused(name: str, kind: str, reason: str) -> None:
    controller = controller_of_design("refined")
    renamed = dataclasses.replace(controller, task=controller.task.model_copy(update={"name": name}))
    with pytest.raises(BadInput, match=f"^name: '{name}' is .*{reason}"):
        package(renamed, kind)


@pytest.mark.parametrize("name", ["token", "features", "Statistics", "limits"])
def test_a_name_that_would_shadow_a_file_of_a_library_is_refused(name: str) -> None:
    with pytest.raises(BadInput, match=f"^name: '{name}' would shadow a part of the standard library"):
        load_task(ROOT / "tasks" / "omni_s2.toml").changed(name=name)


def test_a_plant_is_refused_for_packages_other_than_units() -> None:
    with pytest.raises(BadInput, match="--plant: is for --package fmu"):
        package(controller_of_design("refined"), "cmake", plant_of("integrator", 2, 1))
