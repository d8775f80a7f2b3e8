"""The vectors of `compare`, with values that are not finite added, take every branch of every emitted C file."""

from __future__ import annotations

import ctypes
import gzip
import json
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stt_codegen.compare.comparison import compare_backend
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.c.runner import CompiledC
from stt_codegen.record.manifest import read_manifest
from stt_codegen.task import load_task
from tests.emit.test_runtime_errors import FOLDERS
from tests.support.controllers import ROOT, build_once

ENDS = (-(2**31), 2**31 - 1)
SPECIAL_VALUES = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e30, -1e30)

# Branches that saturate integers for the proof of 32 bits, although the certificate excludes the values:
CRANE, GANTRY = "crane/refined/fixed", "gantry/refined/fixed"
NEVER_TAKEN = {
    "crane_leading: if (shifted < 0x8000U) { shifted <<= 16; shift = 16; }": (
        CRANE,
    ),  # of a width that is certified to be larger
    "gantry_leading: if (shifted < 0x8000U) { shifted <<= 16; shift = 16; }": (GANTRY,),
    "crane_rates: const int32_t difference_limited = difference_under ? difference_raised : 67108864;": (
        CRANE,
    ),  # 1/4 at no tick
    "crane_control: const int32_t safe_width = wide ? width : 65536;": (CRANE,),  # certified to be wider, here and below
    "crane_control: const int32_t y_limited = y_under ? y_raised : 1073741823;": (CRANE,),  # y is 1 at no rounded width
    "gantry_control: const int32_t safe_width = wide ? width : 131072;": (GANTRY,),
    "crane_margin: const int32_t z_safe_width = z_wide ? z_width : 65536;": (CRANE,),
    "crane_margin: const int32_t x_safe_width = x_wide ? x_width : 131072;": (CRANE,),
    "gantry_margin: const int32_t x_safe_width = x_wide ? x_width : 131072;": (GANTRY,),
    "crane_margins: const int32_t z_safe_width = z_wide ? z_width : 65536;": (CRANE,),
    "crane_margins: const int32_t x_safe_width = x_wide ? x_width : 131072;": (CRANE,),
    "gantry_margins: const int32_t x_safe_width = x_wide ? x_width : 131072;": (GANTRY,),
}


def controller_in(folder: str) -> EmittedController:
    """Return the controller that is recorded in a folder of generated/."""
    entry = next(e for e in read_manifest(ROOT / "generated") if e.folder == folder)
    return build_once(load_task(ROOT / "generated" / entry.task).with_options(entry.design, entry.scalar), entry.uncertified)


def call_all(controller: EmittedController, c: CompiledC) -> None:
    """Call all functions with the vectors of the comparison, special values in every argument, and narrow or empty tubes."""
    probe = "probe"

    def make(compared: EmittedController) -> CompiledC:
        return CompiledC(compared) if compared.program.functions[0].name == probe else c

    compare_backend(controller, make, 2000)
    random = np.random.default_rng(1)
    t_c = float(controller.task.prescribed_time)
    for f in controller.program.functions:
        if f.name == "alpha_init":
            continue
        inputs: list[Any] = []
        for p in f.inputs:
            shape = (3000,) if p.length is None else (3000, p.length)
            if p.type.value == "tick":
                inputs.append(random.integers(0, 20_000, 3000))
                continue
            if controller.task.emit.scalar == "fixed":
                values = np.where(random.random(shape) < 0.5, random.choice(ENDS, shape), random.integers(*ENDS, shape))
                inputs.append(values)
                continue
            values = random.uniform(-0.2, 1.2, shape) * (t_c if p.length is None else 5.0)
            values = np.where(random.random(shape) < 0.2, random.choice(SPECIAL_VALUES, shape), values)
            inputs.append(values)
        if f.name == "transform":
            inputs[1] = inputs[0] + random.choice([1e-8, 1e-3, 1.0, -1.0, np.nan], inputs[0].shape)
            inputs[2] = np.where(random.random(inputs[0].shape) < 0.9, random.uniform(-1.0, 6.0, inputs[0].shape), np.nan)
        if f.name == "alpha_step":  # so short that the implicit step's cube root underflows
            inputs[1][::3] = 5e-324 if c.scalar == "double" else 1e-45
            inputs[2][::2] = 0.0
        c.call(f.name, *inputs)


def branches_not_taken(controller: EmittedController, folder: Path, compiler: str, gcov: str) -> list[str]:
    """Return lines with a branch that no vector takes, and functions that no vector calls."""
    name = controller.task.name
    for file, data in controller.files.items():
        (folder / file).write_bytes(data)
    (folder / "flush.c").write_text("void __gcov_dump(void);\nvoid flush(void);\nvoid flush(void) { __gcov_dump(); }\n")
    flags = ["-std=c99", "-O0", "--coverage", "-shared", "-fPIC"]
    subprocess.run([compiler, *flags, f"{name}.c", "flush.c", "-o", "covered.so", "-lm"], cwd=folder, check=True)
    c = CompiledC(controller, library=folder / "covered.so")
    if any(f.name == "alpha_init" for f in controller.program.functions):
        alpha = np.zeros((1, 2 * controller.program.dimension), c.number)
        c.library[f"{name}_alpha_init"](alpha.ctypes.data_as(ctypes.c_void_p))
    call_all(controller, c)
    c.library.flush()
    data = f"covered.so-{name}.gcda"
    subprocess.run([gcov, "--json-format", "--branch-probabilities", data], cwd=folder, check=True, capture_output=True)
    report = json.loads(gzip.decompress(next(folder.glob(f"*{name}*.gcov.json.gz")).read_bytes()))
    (file_report,) = (f for f in report["files"] if f["file"] == f"{name}.c")
    text = controller.files[f"{name}.c"].decode().splitlines()
    not_taken = [f["name"] for f in file_report["functions"] if f["execution_count"] == 0]
    for line in file_report["lines"]:
        if any(b["count"] == 0 for b in line["branches"]):
            not_taken.append(f"{line['function_name']}: {text[line['line_number'] - 1].strip()}")
    return not_taken


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_branch_is_taken(folder: str, tool, tmp_path) -> None:
    not_taken = branches_not_taken(controller_in(folder), tmp_path, tool("gcc"), tool("gcov"))
    assert not_taken == [line for line, folders in NEVER_TAKEN.items() if folder in folders]


def test_a_branch_that_no_vector_takes_is_reported(tool, tmp_path) -> None:
    controller = controller_in("omni_s2/refined/float")
    text = controller.files["omni_s2.c"].decode()
    old = "const omni_s2_real started = positive ? t : 0.0F;"
    assert old in text
    mutated = text.replace(old, "const omni_s2_real started = (positive ? t : 0.0F) + ((t < 4.5F) && (t > 4.5F) ? 1.0F : 0.0F);")
    controller = replace(controller, files={**controller.files, "omni_s2.c": mutated.encode()})
    not_taken = branches_not_taken(controller, tmp_path, tool("gcc"), tool("gcov"))
    assert len(not_taken) == 1
    assert "started" in not_taken[0]
