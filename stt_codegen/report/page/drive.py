"""What the page's "Drive it" runs: the emitted C, the interface that `simulate` calls it through, and a plant, as WebAssembly.

A refined tube's logarithm is written out (emit.math = "inline"), so nothing is called from outside and the browser computes, bit
for bit, what the same C computes natively. Other tubes call exp, log and log1p: the page has those of the browser, in double and
then rounded, which is within the 2 units in the last place that the emitted C assumes.
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
from typing import Any

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
    "report_room_address", "loop_own_step", "loop_own_tube", "loop_own_margin", "loop_own_start", "loop_own_advance",
    "loop_own_lag", "loop_plant",
}  # fmt: skip
CLANG, LINKER = "clang", "wasm-ld"
PACKAGES = "clang lld"  # Debian's


def plant_driven(task: Task) -> Plant:
    """What is driven where no plant is named: no f, and g in the middle of what [plant] allows, or 1; -g for a negative gain."""
    sign = 1 if task.gain[0] > 0 else -1
    middle = [float(sign * (b.g_min + b.g_max) / 2) for b in task.plant_bounds]
    n = task.dimension

    def g(*_: Any) -> list[list[float]]:
        return [[middle[i] if i == j else 0.0 for j in range(n)] for i in range(n)]

    rate = "xdot" if task.order == 1 else "vdot"
    one = all(v == 1 for v in middle)
    name = f"{rate} = {'' if one else by_component([Fraction(v) for v in middle]) + ' '}u + w"
    return Plant(
        name=name,
        dimension=n,
        drift=lambda x, *_: [0] * x.shape[0],
        input_matrix=g,
        w_max=task.disturbance_bound,
        order=task.order,
    )


@dataclass(frozen=True)
class Driven:
    """The module, and what it was made of. inline: whether the logarithm was written out for it alone,
    where the shipped C calls the C library's; reason: why there is none, in a sentence."""

    wasm: bytes = b""
    inline: bool = False
    compiler: str = ""
    reason: str = ""

    @property
    def digest(self) -> str:
        return hashlib.sha256(self.wasm).hexdigest()


def driven(controller: EmittedController, plant: Model) -> Driven:
    """Compile; with a reason instead of a module where clang or its linker is missing or refuses."""
    missing = [name for name in (CLANG, LINKER) if shutil.which(name) is None]
    if missing:
        return Driven(reason=f"{' and '.join(missing)} not found; install (Debian names): {PACKAGES}, and make the report again")
    task = controller.task
    files, inline = shipped(controller)
    sources = {name: files[name] for name in (f"{task.name}.h", *driven_sources(task))}
    where = template_folder()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, data in sources.items():
            (folder / file).write_bytes(data)
        (folder / "adapter.c").write_text(adapter_source(task, controller.design, controller.certificate))
        (folder / "plant.c").write_text(plant_source(plant, task.dimension, task.order))
        shutil.copy(where / "report" / "wasm" / "room.c", folder)
        paths = [p for p in sorted(folder.iterdir()) if p.suffix == ".c"]
        include = [f"-I{where / 'report' / 'wasm'}", f"-I{where / 'loop'}", f"-I{folder}"]
        try:
            for path in paths:
                _run([CLANG, *CFLAGS, *include, str(path), "-o", str(path.with_suffix(".o"))])
            exports = [f"--export-if-defined={one}" for one in sorted(EXPORTS)]
            _run([LINKER, *LDFLAGS, *exports, *(str(p.with_suffix(".o")) for p in paths), "-o", str(folder / "own.wasm")])
        except RuntimeError as error:
            return Driven(reason=str(error).replace(f"{folder}/", ""))
        wasm = (folder / "own.wasm").read_bytes()
    return Driven(wasm, inline, _version())


def shipped(controller: EmittedController) -> tuple[Mapping[str, bytes], bool]:
    """The emitted files, of a refined tube with the logarithm written out, and whether that makes them others than the task's."""
    task = controller.task
    inlines = controller.design.capabilities.inlines_logarithm
    if not inlines or task.emit.math == "inline" or task.emit.scalar == "fixed":
        return controller.files, False
    inline = task.model_copy(update={"emit": task.emit.model_copy(update={"math": "inline"})})
    program = program_of(inline, controller.design)
    return render_files(inline, controller.design, program, controller.certificate), True


def _run(command: list[str]) -> None:
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode:
        raise RuntimeError(f"{Path(command[0]).name} refused it: {result.stderr.strip()[-300:]}")


def _version() -> str:
    told = subprocess.run([CLANG, "--version"], capture_output=True, text=True, check=False).stdout
    return told.partition("\n")[0].strip()


def setting(
    controller: EmittedController, made: Driven, plant: Model, w_max: float, sampling: SamplingReport | None
) -> dict[str, Any]:
    """What the page's loop needs: the module, sizes, and what is proved for |w| <= w_max: period, latency, noise, starts."""
    task = controller.task
    own = None if sampling is None else sampling.at_this_gain
    proved = None
    if sampling is not None and own is not None:
        proved = {
            "period": own.period,
            "shortest": sampling.shortest,
            "latency": float(task.control.latency or 0),
            "noise": float(task.plant.noise or 0),
            "w": w_max,
            "share": float(task.initial_set.share),
        }
    return {
        "wasm": base64.b64encode(made.wasm).decode(),
        "order": task.order,
        "adaptive": controller.design.is_stateful,
        "differs": task.uses_differences,
        "x": [float(v) for v in task.initial_state],
        "noise_v": float(task.plant.noise_v or 0) / float(task.plant.noise) if task.plant.noise else 1.0,
        "constants": [(low + high) / 2 for low, high in plant.constants],
        "period": first_period(controller, own),
        "proved": proved,
    }


def first_period(controller: EmittedController, own: ProvedPeriod | None) -> float:
    """The period that driving begins with: that of the task; else one that is proved and so short that u at its clamp, of order
    1, throws the state no farther than the tube is wide."""
    task = controller.task
    asked = task.control.period or task.emit.tick_period
    if asked is not None:
        return float(asked)
    found = min(own.period if own else 0.01, 0.01, float(task.prescribed_time) / 100)
    most = clamp_input(controller)
    if task.order == 1 and task.u_max is None and most is not None and not controller.design.is_stateful:
        found = min(found, 0.8 * float(controller.certificate.minimum_width) / most)
    return found
