"""Printed C reads back as its Program, with literals bit for bit, and any other C is reported."""

from __future__ import annotations

import re
from functools import cache

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stt_codegen.pipeline import EmittedController
from stt_codegen.program.nodes import Program
from stt_codegen.program.read.c import differences
from stt_codegen.program.targets.c.printer import CPrinter
from stt_codegen.task import load_task
from tests.program.test_program import BANK
from tests.support.bank import kernel_of, one_function_program
from tests.support.controllers import ADAPTABLE, NAMES, ROOT, build_once


@cache
def emitted_controller(name: str, design: str, scalar: str) -> EmittedController:
    return build_once(load_task(ROOT / "tasks" / f"{name}.toml").with_options(design, scalar), uncertified=True)


PAIRS = [(n, d) for n in NAMES for d in ("refined", "adaptive", "literal") if d == "refined" or n in ADAPTABLE]


def texts(controller: EmittedController) -> tuple[str, str]:
    """Return header and C."""
    prefix = controller.task.name
    return controller.files[f"{prefix}.h"].decode(), controller.files[f"{prefix}.c"].decode()


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize(("name", "design"), PAIRS)
def test_every_emitted_file_reads_back_as_its_program(name: str, design: str, scalar: str) -> None:
    controller = emitted_controller(name, design, scalar)
    assert differences(controller.program, *texts(controller)) == []


def bank_texts(program: Program) -> tuple[str, str]:
    """Return header and C of a program of the bank."""
    printer = CPrinter(program)
    parts = [*map(printer.kernel, program.kernels), *map(printer.function, program.functions)]
    header = f"#define BANK_N 1\ntypedef {program.scalar} bank_real;\n"
    return header, "\n".join(line for part in parts for line in part)


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("name", BANK)
def test_every_operation_reads_back(name: str, scalar: str) -> None:
    build_, _, _ = BANK[name]
    program = one_function_program(kernel_of(name, build_, build_.__code__.co_argcount)[0], scalar)
    assert differences(program, *bank_texts(program)) == []


TOKEN = re.compile(r"\d+\.\d*(?:e-?\d+)?F?|\b\d+\b|\b[a-zA-Z_]\w*\b|<=|&&|\|\||[-+*/<?!]")


def mutate(code: str, position: float, data: st.DataObject) -> str:
    """Return the code with one token, at a relative position, changed into another of its kind: a digit, an operator or an identifier."""
    begin = code.index("static")
    tokens = list(TOKEN.finditer(code, begin))
    token = tokens[int(position * (len(tokens) - 1))]
    text = token.group()
    if text[0].isdigit():
        digits = [k for k, c in enumerate(text) if c.isdigit()]
        k = data.draw(st.sampled_from(digits))
        new = text[:k] + str((int(text[k]) + data.draw(st.integers(1, 9))) % 10) + text[k + 1 :]
    elif text[0].isalpha() or text[0] == "_":
        new = data.draw(st.sampled_from(sorted({t.group() for t in tokens if t.group()[0].isalpha()} - {text})))
    else:
        new = data.draw(st.sampled_from([v for v in ("+", "-", "*", "/", "<", "<=", "&&", "||", "!", "") if v != text]))
    return code[: token.start()] + new + code[token.end() :]


@settings(max_examples=150, deadline=None)
@given(
    which=st.sampled_from(
        [("omni_s2", "refined", "float"), ("omni_board", "refined", "float"), ("omni_s1", "adaptive", "double")]
    ),
    position=st.floats(0, 1),
    data=st.data(),
)
def test_a_changed_token_is_reported(which: tuple[str, str, str], position: float, data: st.DataObject) -> None:
    controller = emitted_controller(*which)
    header, source = texts(controller)
    plain = re.sub(r"/\*.*?\*/", " ", source, flags=re.S)
    changed = mutate(plain, position, data)
    if with_rounded_literals(changed) == with_rounded_literals(plain):
        return  # 0.50 for 0.5, or a digit that rounds to the same number, is the same C
    assert differences(controller.program, header, changed), changed_line(plain, changed)


def with_rounded_literals(code: str) -> str:
    """Return the text with every literal rounded to the precision of the file, so that equal C has equal text."""
    import numpy as np

    kind = np.float32 if re.search(r"\d\.\d*F", code) else np.float64
    return re.sub(r"\d+\.\d*(?:e-?\d+)?F?", lambda m: repr(float(kind(m.group().rstrip("F")))), code)


def changed_line(before: str, after: str) -> list[str]:
    return [f"{a} -> {b}" for a, b in zip(before.splitlines(), after.splitlines(), strict=True) if a != b]
