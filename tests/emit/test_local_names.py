"""Locals and parameters of emitted C: none can hide a function or a table of its file, whatever the task is called, none is a common
macro, and no name was chosen by an allocator."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from stt_codegen.checker.stt_checker import source
from stt_codegen.controller.integers.fixed_program import fixed_program
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.emit.naming import check_names
from stt_codegen.pipeline import build_program
from stt_codegen.program.build import Block
from stt_codegen.program.nodes import Assign, Kernel, Op, Program, Var
from stt_codegen.program.operations import REAL
from stt_codegen.program.targets.c.macros import COMMON_MACROS
from stt_codegen.program.targets.c.printer import CPrinter
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.emit.test_runtime_errors import FOLDERS
from tests.support.controllers import ROOT, build_once, controller_of

TWO = (Fraction(1, 2), Fraction(2, 5))
THREE = (Fraction(1, 2), Fraction(2, 5), Fraction(1, 3))
TICKS: dict[str, Any] = {"tick_period": Fraction(1, 1000)}
INLINE = {"math": "inline"}

# name of a task, scalar, options of [control] and of [emit]: together every way in which statements differ
VARIANTS = {
    "gains and clamps": ("omni_s2", "float", {"gain": TWO, "e_max": (Fraction(9, 10), Fraction(4, 5))}, {}),
    "limits, inline, ticks": ("omni_s2", "double", {"u_max": (Fraction(3), Fraction(4))}, {**TICKS, **INLINE}),
    "scaled, negative": ("omni_s2", "float", {"u_max": (Fraction(3),) * 2, "saturate": "scale", "gain": -Fraction(1, 2)}, TICKS),
    "order 2": ("drone", "float", {}, {**TICKS, **INLINE}),
    "order 2 by component": ("drone", "double", {"gain": THREE, "e_max": THREE}, {}),
    "order 2, differences": ("drone", "double", {"velocity": "differences", "u_max": THREE}, TICKS),
    "adaptive": ("omni_s2", "adaptive", {"gain": TWO, "e_max": TWO, "u_max": (Fraction(3), Fraction(4))}, INLINE),
    "literal": ("omni_s1", "literal", {}, INLINE),
    "integers, gains": ("gantry", "fixed", {"gain": (-Fraction(112, 1000), -Fraction(12, 100))}, {}),
    "integers, many ticks": ("gantry", "fixed", {}, {"tick_period": Fraction(305, 10**7)}),
    "integers, order 2": ("crane", "fixed", {}, {"tick_period": Fraction(305, 10**7)}),
}


def program_of(variant: str) -> Program:
    """Return the program of a variant, for the tube of the unchanged task."""
    name, scalar, control, emit = VARIANTS[variant]
    options = (scalar, "float") if scalar in ("adaptive", "literal") else (None, scalar)
    task = load_task(ROOT / "tasks" / f"{name}.toml").with_options(*options)
    controller = build_once(task, uncertified=scalar == "literal")
    task, design = controller.task, controller.design
    changed: Task = task.model_copy(
        update={"control": task.control.model_copy(update=control), "emit": task.emit.model_copy(update=emit)}
    )
    if scalar != "fixed":
        return build_program(changed, design)
    assert isinstance(design, RefinedDesign)
    if design.filter:  # lambda of 2 or more has fewer bits behind the point, so its products have one statement more
        design = replace(design, filter=tuple(v + 2 for v in design.filter))
    return fixed_program(changed, design)


def c_words(text: str) -> Iterator[str]:
    """Yield the words of C that are no calls, without comments, strings and directives, and of a listing without its numbers."""
    code = re.sub(r'/\*.*?\*/|"[^"\n]*"|^#[^\n]*|\$\w+', " ", text, flags=re.DOTALL | re.MULTILINE)
    yield from re.findall(r"\b[A-Za-z_]\w*\b(?!\()", code)


def printed(program: Program) -> str:
    """Return the C of all parts of a program, and of the functions that they call."""
    c = CPrinter(program)
    lines = [line for kernel in program.kernels for line in c.kernel(kernel)]
    lines += [line for function in program.functions for line in [*c.prototype(function), *c.function(function)]]
    lines += [line for table in program.tables for line in c.table(table)]
    return "\n".join([*c.helpers(), *lines])


def wrong_locals(text: str, prefix: str) -> set[str]:
    """Return words that are a common macro, and words that are no external name here but would be for a task of another name."""
    externals = {word.removeprefix(f"{prefix}_") for word in re.findall(rf"\b{prefix}_\w+", text)}
    words = {word for word in c_words(text) if not word.lower().startswith(f"{prefix.lower()}_")}
    endings = tuple(f"_{name}" for name in externals)
    return {word for word in words if word.endswith(endings) or word in COMMON_MACROS}


@pytest.mark.parametrize("folder", FOLDERS)
def test_no_local_of_recorded_c_can_hide_a_name_or_is_a_macro(folder: str) -> None:
    files = [p for p in (ROOT / "generated" / folder).iterdir() if p.suffix in (".c", ".h")]
    prefix = min((p.stem for p in files), key=len)
    text = "\n".join(p.read_text() for p in files)
    assert wrong_locals(text, prefix) == set()


def test_no_local_of_the_checkers_listings_can_hide_a_name_or_is_a_macro() -> None:
    """Else the checker would accept C that does not compile, or does something else, for a task with a certain name."""
    lines = [line.partition("  [")[0] for piece in source.pieces().values() for line in piece]
    assert wrong_locals("\n".join(lines), "P") == set()


@pytest.mark.parametrize("variant", VARIANTS)
def test_no_local_of_an_option_can_hide_a_name_or_is_a_macro(variant: str) -> None:
    program = program_of(variant)
    check_names(program)
    assert wrong_locals(printed(program), program.prefix) == set()


def test_a_local_that_could_hide_a_name_or_is_a_macro_is_found() -> None:
    text = printed(program_of("integers, order 2"))
    for local in ("x_control", "low_high_product", "at_edge_at", "near", "bit"):
        assert wrong_locals(f"{text}\nconst int32_t {local} = 0;", "crane") == {local}


def test_variants_reach_every_statement_that_an_option_adds() -> None:
    texts = "\n".join(printed(program_of(variant)) for variant in VARIANTS)
    for word in (
        "gain_i",
        "e_max_i",
        "u_limited",
        "u_scaled",
        "exponent",
        "x_before_i",
        "passed_low",
        "fine",
        "lower_scaled",
        "theta0",
    ):
        assert word in set(c_words(texts)), word


def test_a_name_that_is_used_twice_in_a_block_is_refused() -> None:
    """No allocator puts a number behind it: listings name every local by hand."""
    block = Block({"t"})
    block.let("width", Var("t", REAL))
    for name in ("t", "width"):
        with pytest.raises(ValueError, match=f"the name '{name}' is used twice in one block"):
            block.let(name, Var("t", REAL))


@pytest.mark.parametrize(
    ("local", "message"),
    [
        ("a_tube", "'a_tube' would hide a function or table of a task called 'a'"),
        ("low_high_product", "'low_high_product' would hide a function or table of a task called 'low'"),
        ("x_start_lower", "would hide"),
        ("near", "'near' is a name of the library of C"),
        ("radians", "'radians' is a name of the library of C"),
        ("B0", "'B0' is no name in small letters"),
        ("F", "'F' is no name in small letters"),
    ],
)
def test_check_names_refuses_such_a_local(local: str, message: str) -> None:
    program = controller_of("gantry", "fixed").program
    x = Var("x", program.kernels[1].inputs[0].type)
    for kernel in (
        Kernel("probe", (x,), (Assign(Var(local, x.type), Op("ineg", (x,))),), (x,), ("y",)),
        Kernel("probe", (Var(local, x.type),), (), (x,), ("y",)),
    ):
        with pytest.raises(ValueError, match=message):
            check_names(replace(program, kernels=(*program.kernels, kernel)))


def test_every_list_of_macros_has_names_in_small_letters() -> None:
    assert {"abs", "bit", "far", "max", "min", "near", "round", "small", "unix"} <= COMMON_MACROS
    assert all(re.fullmatch("[a-z][a-z0-9]*", name) for name in COMMON_MACROS)
