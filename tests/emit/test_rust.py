"""The Rust has no warning of clippy, equals the C bit for bit, and is a crate that builds and tests itself; changes of it are detected."""

from __future__ import annotations

import faulthandler
import json
import os
import re
import shutil
import struct
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from stt_codegen.board.boards import BOARDS, rust_boards
from stt_codegen.board.emulated import Emulated
from stt_codegen.board.rust_images import core_library
from stt_codegen.cli.main import app
from stt_codegen.compare.comparison import compare, compare_backend
from stt_codegen.emit.naming import check_names
from stt_codegen.errors import BadInput, MissingTool, SttError
from stt_codegen.files import write_files
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.nodes import Assign, Kernel, Var
from stt_codegen.program.operations import REAL
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.program.targets.rust.runner import CompiledRust
from stt_codegen.record.package import package
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.support.controllers import ROOT, build_once
from tests.support.missing_tools import skip_without

# One task for each part of the template: the library's logarithm, the inline one with ticks, alpha of the adaptive tube, order 2, phases,
# wrapping, both guards.
SHAPES = {
    "omni_s2": {},
    "adaptive": {"tube": {"design": "adaptive"}},
    "omni_board": {},
    "attitude": {},
    "watchman": {},
    "hold": {"control": {"outside": "hold"}},
    "stop": {"control": {"outside": "stop"}},
    "named": {"name": "Cart__A"},  # against the conventions of Rust
    "differences": {"control": {"velocity": "differences"}, "plant": {"noise": 0.0001, "noise_v": None}},
}
TASK_OF_SHAPE = {"differences": "drone"}  # by default the task of that name, or omni_s2


def task_of(shape: str) -> Task:
    name = TASK_OF_SHAPE.get(shape, shape if (ROOT / "tasks" / f"{shape}.toml").exists() else "omni_s2")
    return load_task(ROOT / "tasks" / f"{name}.toml").changed(**SHAPES.get(shape, {}))


@cache
def rust_controller(shape: str, scalar: str = "float") -> EmittedController:
    return build_once(task_of(shape).with_options(scalar=scalar, language="rust"))


def write_workspace(folder: Path, shapes: list[str]) -> None:
    """Write a workspace of crates that are named after their shapes, and a local `libm` that calls the system's library."""
    for shape in shapes:
        write_files(folder, package(rust_controller(shape), "rust"))
        (folder / rust_controller(shape).task.name).rename(folder / f"of_{shape}")
        text = (folder / f"of_{shape}" / "Cargo.toml").read_text()
        (folder / f"of_{shape}" / "Cargo.toml").write_text(
            text.replace(f'name = "{rust_controller(shape).task.name}"', f'name = "of_{shape}"')
        )
        tests = folder / f"of_{shape}" / "tests" / "selftest.rs"
        tests.write_text(tests.read_text().replace(f"use ::{rust_controller(shape).task.name}::", f"use ::of_{shape}::"))
    (folder / "Cargo.toml").write_text('[workspace]\nresolver = "2"\nmembers = ["of_*"]\n')
    libm = folder / "vendor" / "libm"
    (libm / "src").mkdir(parents=True)
    (libm / "Cargo.toml").write_text('[package]\nname = "libm"\nversion = "0.2.99"\nedition = "2021"\n')
    (libm / ".cargo-checksum.json").write_text(json.dumps({"files": {}, "package": None}))
    names = "exp log expm1 log1p sqrt tanh sinh cosh".split()
    declared = "".join(f"fn {n}f(x: f32) -> f32; fn {n}(x: f64) -> f64;\n" for n in names)
    defined = "".join(
        f"pub fn {n}{s}(x: {t}) -> {t} {{ unsafe {{ c::{n}{s}(x) }} }}\n" for n in names for s, t in (("f", "f32"), ("", "f64"))
    )
    (libm / "src" / "lib.rs").write_text(f'mod c {{ extern "C" {{ {declared.replace("fn ", "pub fn ")} }} }}\n{defined}')
    (folder / ".cargo").mkdir()
    (folder / ".cargo" / "config.toml").write_text(
        '[source.crates-io]\nreplace-with = "here"\n[source.here]\ndirectory = "vendor"\n[net]\noffline = true\n'
    )


def run(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_every_crate_builds_without_a_warning_and_passes_its_tests(tmp_path, tool) -> None:
    cargo = tool("cargo")
    shapes = list(SHAPES)
    write_workspace(tmp_path, shapes)
    tested = run(tmp_path, cargo, "test", "--workspace")
    assert tested.returncode == 0, tested.stdout + tested.stderr
    assert len(re.findall(r"test .*gives_what_ieee_arithmetic_can \.\.\. ok", tested.stdout)) == sum(
        f.name in ("control", "control_tick") for shape in shapes for f in rust_controller(shape).program.functions
    )
    assert len(re.findall(r"test a_nan_in_any_argument_is_bad_input \.\.\. ok", tested.stdout)) == len(shapes)
    if run(tmp_path, cargo, "clippy", "--version").returncode == 0:  # not in Debian's cargo
        clippy = run(tmp_path, cargo, "clippy", "--workspace", "--all-targets", "--", "-D", "warnings")
        assert clippy.returncode == 0, clippy.stderr
    if shutil.which("rustfmt"):
        files = [str(p) for p in tmp_path.glob("of_*/**/*.rs")]
        assert run(tmp_path, "rustfmt", "--check", "--edition", "2021", *files).returncode == 0
    with_libm = run(tmp_path / "of_omni_s2", cargo, "test", "--no-default-features", "--features", "libm")
    assert with_libm.returncode == 0, with_libm.stderr
    without_library = run(tmp_path / "of_omni_s2", cargo, "build", "--no-default-features")
    assert "give feature std, or libm where there is no std" in without_library.stderr
    text = (tmp_path / "of_omni_board" / "Cargo.toml").read_text()
    assert "libm" not in text  # its logarithm is inline, and it calls no other function


def test_the_test_of_a_crate_fails_for_a_changed_number_in_the_table(tmp_path, tool) -> None:
    cargo = tool("cargo")
    write_workspace(tmp_path, ["omni_board"])
    source = tmp_path / "of_omni_board" / "src" / "lib.rs"
    text = source.read_text()
    first = re.search(r"COEFFICIENTS.*?= \[\n    (\S+),", text, re.S)
    assert first is not None
    source.write_text(text.replace(f"    {first[1]},", f"    {float(first[1]) + 0.01},", 1))
    assert "0 passed; 0 failed" in run(tmp_path, cargo, "test", "--doc").stdout
    assert run(tmp_path, cargo, "test").returncode != 0


def argument_arrays(controller: EmittedController, function: str, count: int = 400) -> list[np.ndarray]:
    """Return arguments all over the state space and at the ends of time, with some that are huge or not finite."""
    dice, task = np.random.default_rng(7), controller.task
    number = np.float32 if task.emit.scalar == "float" else np.float64
    low, high = (np.array([float(v) for v in side]) for side in (task.state_space.lower, task.state_space.upper))
    arrays = []
    for p in controller.program.function(function).inputs:
        if p.type is not REAL:
            arrays.append(dice.integers(0, 2**32, count))
        elif p.length is None:
            values = dice.uniform(-0.2, 1.2, count) * float(task.prescribed_time)
            values[:4] = 0, float(task.prescribed_time), np.nan, np.inf
            arrays.append(values.astype(number))
        else:
            wide = p.length // len(low)
            values = dice.uniform(np.tile(low, wide) - 0.1, np.tile(high, wide) + 0.1, (count, p.length))
            values[4, 0], values[5, -1], values[6, 0] = np.nan, -np.inf, 1e30
            arrays.append(values.astype(number))
    return arrays


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("shape", ["omni_s2", "adaptive", "omni_board", "attitude", "watchman", "named", "differences"])
def test_the_rust_equals_the_c_bit_for_bit(shape: str, scalar: str, tool) -> None:
    tool("rustc")
    controller = rust_controller(shape, scalar)
    assert functions_that_differ(controller, CompiledRust(controller)) == []


def functions_that_differ(controller: EmittedController, rust: CompiledRust) -> list[str]:
    """Return the functions that give other numbers than the C."""
    c, names = CompiledC(controller), []
    for function in (f for f in controller.program.functions if f.inputs):
        arguments = argument_arrays(controller, function.name)
        pairs = zip(rust.call(function.name, *arguments), c.call(function.name, *arguments), strict=True)
        if not all(np.array_equal(a, b, equal_nan=True) and np.array_equal(np.signbit(a), np.signbit(b)) for a, b in pairs):
            names.append(function.name)
    return names


def test_compare_checks_the_rust_or_says_that_no_compiler_is_installed(monkeypatch, tool) -> None:
    tool("rustc")
    task = task_of("omni_board").with_options(language="rust")
    rows = compare(task, 200)
    rust_rows = [r for r in rows if r.backend.startswith("Rust")]
    assert {r.backend for r in rust_rows} == {"Rust float", "Rust double"}
    assert all(r.holds for r in rows)
    assert len(rust_rows) == 2 * len([r for r in rows if r.backend == "C float"])
    monkeypatch.setenv("RUSTC", "no-such-compiler")
    messages: list[str] = []
    assert not [r for r in compare(task, 10, messages.append) if r.backend.startswith("Rust")]
    assert len([line for line in messages if "Rust is not compared: no Rust compiler found" in line]) == 2


SWAPS = ((" + ", " - "), (" - ", " + "), (" * ", " / "), (" / ", " * "), (" < ", " > "))


def mutants(text: str) -> list[str]:
    """Return texts with one operator of one assignment changed, for every assignment in a kernel or a function."""
    texts = []
    for line in re.findall(r"^ +let \w+: (?:Real|bool) = .*$", text, re.M):
        for old, new in SWAPS:
            if line.count(old) == 1:
                texts.append(text.replace(line, line.replace(old, new), 1))
    return texts


# Changes without an effect: 0 - 0 is 0, and no tube of this task is as narrow as the guard of the law.
EQUIVALENT = ("let zeros: Real = zero - x_zero;", "let half: Real = widened / 0.5;", "let safe_distance: Real = distance - half;")


@pytest.mark.parametrize("stride", [pytest.param(1, marks=pytest.mark.slow), 8])
def test_a_changed_operator_of_the_rust_is_detected(stride: int, tool) -> None:
    """Each mutant has one changed operator; the fast run takes every eighth mutant."""
    tool("rustc")
    controller = rust_controller("omni_s2")
    text = controller.files["omni_s2.rs"].decode()
    mutated_texts = mutants(text)
    assert len(mutated_texts) > 40
    assert not is_detected(controller, text)
    missed = {changed_line(text, mutant).strip() for mutant in mutated_texts[::stride] if not is_detected(controller, mutant)}
    assert missed <= set(EQUIVALENT)


def changed_line(before: str, after: str) -> str:
    return next(b for a, b in zip(before.split("\n"), after.split("\n"), strict=True) if a != b)


def is_detected(controller: EmittedController, text: str) -> bool:
    """Return whether compiler, `compare`, the bits of the C or a panic reject this text. It runs in a child process, which a panic ends."""

    def make(compared: EmittedController) -> CompiledRust:
        return CompiledRust(replace(compared, files={**controller.files, "omni_s2.rs": text.encode()}))

    child = os.fork()
    if child == 0:
        os.close(2)
        faulthandler.disable()  # it would print a traceback for every panic
        try:
            is_accepted = all(r.holds for r in compare_backend(controller, make, 300)) and not functions_that_differ(
                controller, make(controller)
            )
            os._exit(0 if is_accepted else 1)
        except BaseException:
            os._exit(1)
    return os.waitpid(child, 0)[1] != 0


@pytest.mark.parametrize("shape", ["hold", "stop", "watchman"])
def test_guards_phases_and_wrapping_equal_those_of_the_python(shape: str, tmp_path, tool) -> None:
    """The state leaves the tube and returns. Other tests compare the Python with the C."""
    rustc = tool("rustc")
    controller = rust_controller(shape, "double")
    name, t_c = controller.task.name, float(controller.task.prescribed_time)
    python = load_module(name, controller.files[f"{name}.py"])
    dice, lines, expected = np.random.default_rng(3), [], []
    guard_state: object = (0.0, 0.0) if shape == "hold" else False
    for k in range(60):
        t = t_c * k / 40
        if shape == "watchman":
            lines.append(f"print(&[phase({t!r}) as f64, wrap({t!r}), wrap_tick({k * 1000}) as f64]);")
            expected.append([python.phase(t), python.wrap(t), python.wrap_tick(k * 1000)])
            continue
        low, high = python.tube(t - guard_state[0] if shape == "hold" else t)
        x = [float(a + dice.uniform(0.2, 0.8) * (b - a)) + (0.5 if 20 <= k < 25 else 0.0) for a, b in zip(low, high, strict=True)]
        status, guard_state, u = python.guard(t, x, guard_state)
        lines.append(
            f"let (u, s) = guard.control({t!r}, &{x!r}); print(&[u[0], u[1], s as u8 as f64, {'guard.lag' if shape == 'hold' else 'guard.stopped as u8 as f64'}]);"
        )
        expected.append([*u, status, guard_state[0] if shape == "hold" else float(guard_state)])
    guard = "let mut guard = Guard::default();" if shape != "watchman" else ""
    (tmp_path / f"{name}.rs").write_bytes(controller.files[f"{name}.rs"])
    (tmp_path / "main.rs").write_text(
        f'use {name}::*;\nfn print(v: &[f64]) {{ for x in v {{ print!("{{:016x}} ", x.to_bits()); }} println!(); }}\n'
        f"fn main() {{ {guard}\n" + "\n".join(lines) + "\n}\n"
    )
    library = run(tmp_path, rustc, "--edition", "2021", "-O", "--crate-type", "rlib", "--cfg", 'feature="std"', f"{name}.rs")
    assert library.returncode == 0, library.stderr
    program = run(tmp_path, rustc, "--edition", "2021", "-O", "--extern", f"{name}=lib{name}.rlib", "main.rs")
    assert program.returncode == 0, program.stderr
    printed = [
        [struct.unpack(">d", bytes.fromhex(w))[0] for w in row.split()] for row in run(tmp_path, "./main").stdout.splitlines()
    ]
    assert printed == [[float(v) for v in row] for row in expected]
    if shape != "watchman":
        assert {row[2] for row in expected} >= {0, 1}


HAL = """#![no_std]
pub mod pwm {
    pub trait ErrorType { type Error; }
    pub trait SetDutyCycle: ErrorType {
        fn max_duty_cycle(&self) -> u16;
        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Self::Error>;
    }
}
"""  # the traits of embedded-hal 1.0


def test_the_drive_of_the_page_on_rust_compiles(tmp_path, tool) -> None:
    rustc = tool("rustc")
    page = (ROOT / "docs" / "rust.md").read_text()
    (source,) = re.findall(r"^```rust\n(use .*?)^```", page, re.M | re.S)
    controller = build_once(load_task(ROOT / "tasks" / "crawler.toml"))
    (tmp_path / "crawler.rs").write_bytes(controller.files["crawler.rs"])
    (tmp_path / "embedded_hal.rs").write_text(HAL)
    (tmp_path / "drive.rs").write_text("#![no_std]\n" + source)
    extern = ("-L", ".", "--extern", "crawler", "--extern", "embedded_hal")
    for name, flags in (("crawler", ()), ("embedded_hal", ()), ("drive", extern)):
        result = run(tmp_path, rustc, "--edition", "2021", "--crate-type", "rlib", "-D", "warnings", *flags, f"{name}.rs")
        assert result.returncode == 0, result.stderr


def test_reserved_words_of_rust_are_refused_as_names() -> None:
    task = task_of("omni_s2")
    for word in ("crate", "libm", "fn", "Self"):
        with pytest.raises(BadInput, match=f"name: '{word}' is a reserved word or a crate of Rust"):
            task.changed(name=word, emit={"rust": True})
    assert task.changed(name="crate").name == "crate"  # a task without Rust may have this name
    program = rust_controller("omni_s2").program
    kernel = Kernel("mine", (Var("impl", REAL),), (Assign(Var("y", REAL), Var("impl", REAL)),), (Var("y", REAL),), ("y",))
    with pytest.raises(ValueError, match="'impl' is a reserved word or a crate of Rust"):
        check_names(replace(program, kernels=(*program.kernels, kernel)))


@pytest.mark.parametrize("name", ["Real", "Status", "N", "control"])
def test_a_task_may_have_the_name_of_an_item_in_its_crate(name: str, tmp_path, tool) -> None:
    controller = build_once(task_of("omni_s2").changed(name=name, emit={"rust": True, "math": "inline"}))
    write_files(tmp_path, package(controller, "rust"))
    tested = run(tmp_path / name, tool("cargo"), "test", "--offline")
    assert tested.returncode == 0, tested.stderr


def test_generate_writes_the_crate_and_other_boards_are_refused(tmp_path, monkeypatch) -> None:
    task = str(ROOT / "tasks" / "omni_board.toml")
    result = CliRunner().invoke(app, ["generate", task, "--package", "rust", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    crate = tmp_path / "omni_board"
    assert sorted(p.relative_to(crate).as_posix() for p in crate.rglob("*") if p.is_file()) == [
        "Cargo.toml", "extras/checker.pyz", "extras/omni_board.certificate.json", "extras/omni_board.py", "src/lib.rs", "tests/selftest.rs",
    ]  # fmt: skip
    assert (crate / "src" / "lib.rs").read_bytes() == rust_controller("omni_board").files["omni_board.rs"]
    assert "omni_board.rs" not in build_once(task_of("omni_board")).files
    with pytest.raises(BadInput, match="Rust is linked with C on ARM boards alone: m0, m3, m4f, m7"):
        Emulated(rust_controller("omni_board"), BOARDS["rv32"], rust=True)
    assert rust_boards() == ["m0", "m3", "m4f", "m7"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["omni_s2", "crawler"])
def test_the_rust_on_a_board_is_within_the_bounds(name: str, tool) -> None:
    """It takes at most 1.5 times the instructions of the C, as it checks bounds of arrays and returns outputs; docs/rust.md says how
    many, for the compilers that it names."""
    for program in ("arm-none-eabi-gcc", "qemu-system-arm"):
        tool(program)
    controller = rust_controller(name)
    costs = {}
    for rust in (False, True):
        backends: list[Emulated] = []

        def make(compared: EmittedController, rust: bool = rust, backends: list[Emulated] = backends) -> Emulated:
            backends.append(Emulated(compared, BOARDS["m4f"], rust=rust))
            return backends[-1]

        try:
            rows = compare_backend(controller, make, 2000)
        except MissingTool as error:
            skip_without(str(error))
        assert all(r.holds for r in rows)
        costs[rust] = max(b.counts["control"].summary().maximum for b in backends if "control" in b.counts)
    assert costs[True] <= 1.5 * costs[False]
    compilers = ("arm-none-eabi-gcc", core_library(BOARDS["m4f"].rust_target)[0])
    versions = [run(ROOT, command, "--version").stdout for command in compilers]
    if " 12.2" in versions[0] and " 1.63" in versions[1]:
        assert f"| {costs[False]} | {costs[True]} |" in (ROOT / "docs" / "rust.md").read_text()


@pytest.mark.parametrize(("variable", "task"), [("CC", "omni_s2"), ("RUSTC", "crawler")])
def test_a_compiler_that_fails_in_silence_is_named(variable: str, task: str, monkeypatch, tool) -> None:
    tool("rustc")
    monkeypatch.setenv(variable, tool("false"))
    with pytest.raises(SttError, match=r"false refused the emitted code:\nit said nothing, and ended with 1"):
        compare(load_task(ROOT / "tasks" / f"{task}.toml"), 10)
