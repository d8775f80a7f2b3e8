"""What the page's "Drive it" runs: the emitted C, the interface that `simulate` calls it through, and a plant, as WebAssembly.

A refined tube's logarithm is written out (emit.math = "inline"), so nothing is called from outside and the browser computes, bit
for bit, what the same C computes natively. Other tubes call exp, log and log1p: the page has those of the browser, in double and
then rounded, which is within the 2 units in the last place that the emitted C assumes.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from stt_codegen.emit.driven import adapter_source, driven_sources, plant_source
from stt_codegen.emit.render import template_folder
from stt_codegen.pipeline import Controller, render_files
from stt_codegen.pipeline import build_program as program_of
from stt_codegen.plants import Model

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


@dataclass(frozen=True)
class Driven:
    """The module, and what it was made of. sources: C files by name; inline: whether the logarithm was written out for it alone,
    where the shipped C calls the C library's; reason: why there is none, in a sentence."""

    wasm: bytes = b""
    sources: Mapping[str, bytes] | None = None
    inline: bool = False
    compiler: str = ""
    reason: str = ""

    @property
    def digest(self) -> str:
        return hashlib.sha256(self.wasm).hexdigest()


def driven(controller: Controller, plant: Model) -> Driven:
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
        (folder / "adapter.c").write_text(adapter_source(task, controller.design.stateful, controller.certificate))
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
            return Driven(reason=str(error))
        wasm = (folder / "own.wasm").read_bytes()
    return Driven(wasm, sources, inline, _version())


def shipped(controller: Controller) -> tuple[Mapping[str, bytes], bool]:
    """The emitted files, of a refined tube with the logarithm written out, and whether that makes them others than the task's."""
    task = controller.task
    if controller.design.stateful or task.emit.math == "inline":
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
