"""Compile the emitted C, its interface for `simulate` and a plant to WebAssembly, which the page's section "Drive it" runs.

A refined tube has an inline logarithm here (emit.math = "inline"), so that the browser computes bit for bit what the same C
computes natively. Other tubes call exp, log and log1p of the browser, rounded from double, which is within the 2 units in the
last place that the emitted C assumes. report/page/page.py calls this.
"""

from __future__ import annotations

import base64
import hashlib
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from stt_codegen.arrays import one_if_equal
from stt_codegen.decimals import by_component
from stt_codegen.emit import adapter_source, driven_sources, plant_source
from stt_codegen.pipeline import EmittedController, render_files
from stt_codegen.pipeline import build_program as program_of
from stt_codegen.plants import Model, Plant
from stt_codegen.program.targets.template_files import template_folder
from stt_codegen.report.bounds import ProvedPeriod, SamplingReport
from stt_codegen.report.figures import clamp_input
from stt_codegen.task import Task

CFLAGS = (
    "--target=wasm32", "-std=c99", "-O2", "-Wall", "-Wextra", "-Wno-unused-parameter", "-ffp-contract=off", "-mbulk-memory", "-c",
)  # fmt: skip
LDFLAGS = ("--no-entry", "--strip-all", "--allow-undefined", "-z", "stack-size=16384")
EXPORTS = {
    "report_buffer_address", "loop_own_step", "loop_own_tube", "loop_own_margin", "loop_own_start", "loop_own_advance",
    "loop_own_waited_seconds", "loop_plant",
}  # fmt: skip
CLANG, LINKER = "clang", "wasm-ld"
DEBIAN_PACKAGES = "clang lld"


def default_plant(task: Task) -> Plant:
    """Return the plant that is driven unless one is chosen: f = 0, and g in the middle of [plant], or 1; -g for a negative
    gain."""
    sign = 1 if task.gain[0] > 0 else -1
    middle = [float(sign * (b.g_min + b.g_max) / 2) for b in task.plant_bounds]
    n = task.dimension

    def g(*_: Any) -> list[list[float]]:
        return [[middle[i] if i == j else 0.0 for j in range(n)] for i in range(n)]

    rate = "xdot" if task.order == 1 else "vdot"
    is_identity = all(v == 1 for v in middle)
    name = f"{rate} = {'' if is_identity else by_component([Fraction(v) for v in middle]) + ' '}u + w"
    return Plant(
        name=name,
        dimension=n,
        drift=lambda x, *_: [0] * x.shape[0],
        input_matrix=g,
        w_max=task.disturbance_bound,
        order=task.order,
    )


@dataclass(frozen=True)
class DriveModule:
    """A WebAssembly module, or the reason why there is none, as a sentence.

    has_inline_logarithm: whether the module's C has an inline logarithm and the shipped C has not.
    """

    wasm: bytes = b""
    has_inline_logarithm: bool = False
    compiler: str = ""
    reason: str = ""

    @property
    def digest(self) -> str:
        return hashlib.sha256(self.wasm).hexdigest()


def compile_drive_module(controller: EmittedController, plant: Model) -> DriveModule:
    """Compile controller and plant; return a reason where clang or its linker is missing or fails."""
    missing = [name for name in (CLANG, LINKER) if shutil.which(name) is None]
    if missing:
        remedy = f"install (Debian names): {DEBIAN_PACKAGES}, and make the report again"
        return DriveModule(reason=f"{' and '.join(missing)} not found; {remedy}")
    task = controller.task
    files, has_inline_logarithm = files_for_browser(controller)
    sources = {name: files[name] for name in (f"{task.name}.h", *driven_sources(task))}
    templates = template_folder()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for file, data in sources.items():
            (folder / file).write_bytes(data)
        (folder / "stt-adapter.c").write_text(adapter_source(task, controller.design, controller.certificate))
        (folder / "stt-plant.c").write_text(plant_source(plant, task.dimension, task.order))
        shutil.copy(templates / "report" / "wasm" / "buffer.c", folder / "stt-buffer.c")
        paths = [p for p in sorted(folder.iterdir()) if p.suffix == ".c"]
        include = [f"-I{templates / 'report' / 'wasm'}", f"-I{templates / 'loop'}", f"-I{folder}"]
        try:
            for path in paths:
                _run([CLANG, *CFLAGS, *include, str(path), "-o", str(path.with_suffix(".o"))])
            exports = [f"--export-if-defined={name}" for name in sorted(EXPORTS)]
            _run([LINKER, *LDFLAGS, *exports, *(str(p.with_suffix(".o")) for p in paths), "-o", str(folder / "module.wasm")])
        except RuntimeError as error:
            return DriveModule(reason=str(error).replace(f"{folder}/", ""))
        wasm = (folder / "module.wasm").read_bytes()
    return DriveModule(wasm, has_inline_logarithm, _compiler_version())


def files_for_browser(controller: EmittedController) -> tuple[Mapping[str, bytes], bool]:
    """Return the emitted files, with an inline logarithm where the design can have one, and whether they differ from the
    task's."""
    task = controller.task
    inlines = controller.design.capabilities.inlines_logarithm
    if not inlines or task.emit.math == "inline" or task.emit.scalar == "fixed":
        return controller.files, False
    inline_task = task.model_copy(update={"emit": task.emit.model_copy(update={"math": "inline"})})
    program = program_of(inline_task, controller.design)
    return render_files(inline_task, controller.design, program, controller.certificate), True


def _run(command: list[str]) -> None:
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode:
        raise RuntimeError(f"{Path(command[0]).name} refused it: {result.stderr.strip()[-300:]}")


def _compiler_version() -> str:
    output = subprocess.run([CLANG, "--version"], capture_output=True, text=True, check=False).stdout
    return output.partition("\n")[0].strip()


def drive_settings(
    controller: EmittedController, module: DriveModule, plant: Model, w_max: float, sampling: SamplingReport | None
) -> dict[str, Any]:
    """Return the data of the page's loop: the module, sizes, and what is proved for |w| <= w_max."""
    task = controller.task
    noise = slider_noise(task)
    proved_period = None if sampling is None else sampling.at_this_gain
    proved = None
    if sampling is not None and proved_period is not None:
        proved = {
            "period": proved_period.period,
            "shortest": sampling.shortest,
            "latency": float(task.control.latency or 0),
            "noise": noise.largest,
            "w": w_max,
            "start_share": float(task.initial_set.share),
        }
    return {
        "wasm": base64.b64encode(module.wasm).decode(),
        "order": task.order,
        "adaptive": controller.design.is_stateful,
        "uses_differences": task.uses_differences,
        "x": [float(v) for v in task.initial_state],
        "x_noise_ratio": noise.x_ratio,
        "v_noise_ratio": noise.v_ratio,
        "constants": [(low + high) / 2 for low, high in plant.constants],
        "period": first_period(controller, proved_period),
        "proved": proved,
    }


class SliderNoise(NamedTuple):
    """The noise that the page's slider sets: errors of x up to x_ratio times its value, and errors of v up to v_ratio times its
    value. A ratio is one number, or one for each component.

    largest: the value of the slider up to which the noise is within [plant].
    """

    largest: float
    x_ratio: float | tuple[float, ...]
    v_ratio: float | tuple[float, ...]


def slider_noise(task: Task) -> SliderNoise:
    """Return the noise of the page's slider, which is noise of x unless [plant] states noise of v alone."""
    noise, noise_v = ([float(v) for v in values] for values in (task.noise, task.noise_v))
    largest = max(noise) or max(noise_v)
    if not largest:
        return SliderNoise(0.0, 1.0, 1.0)
    x_ratio, v_ratio = (one_if_equal(tuple(v / largest for v in values)) for values in (noise, noise_v))
    return SliderNoise(largest, x_ratio, v_ratio)


def first_period(controller: EmittedController, proved_period: ProvedPeriod | None) -> float:
    """Return the sampling period, in seconds, with which the section begins: that of the task, else one that is chosen here.

    It is at most 0.01 s, a hundredth of t_c, and the proved period where there is one. Of order 1, without u_max and alpha, it is
    also so short that u at its clamp moves the state by at most 0.8 of the tube's smallest width.
    """
    task = controller.task
    stated = task.control.period or task.emit.tick_period
    if stated is not None:
        return float(stated)
    period = min(proved_period.period if proved_period else 0.01, 0.01, float(task.prescribed_time) / 100)
    largest_u = clamp_input(controller)
    if task.order == 1 and task.u_max is None and largest_u is not None and not controller.design.is_stateful:
        period = min(period, 0.8 * float(controller.certificate.minimum_width) / largest_u)
    return period
