"""What a design is worth, as numbers and lines: tube, certificate, cost. The command line and the README print these."""

from __future__ import annotations

import math
import subprocess
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

from stt_codegen.backends import STRICT, find_compiler
from stt_codegen.design.tube import RefinedDesign
from stt_codegen.errors import SttError
from stt_codegen.pipeline import Controller
from stt_codegen.program.cost import KINDS, cost_of, table_bytes


def design_report(controller: Controller, seconds: float) -> dict[str, Any]:
    """The figures of one design as JSON data (SI units of the task; seconds is how long the design took)."""
    task, certificate, design = controller.task, controller.certificate, controller.design
    return {
        "task": task.name,
        "design": design.kind,
        "scalar": controller.program.scalar,
        "certified": certificate.holds,
        "seconds": round(seconds, 3),
        "prescribed_time": float(task.prescribed_time),
        "parameters": f"{design.segments} segments"
        if isinstance(design, RefinedDesign)
        else f"{len(design.bumps)} circumvent function{'' if len(design.bumps) == 1 else 's'}",
        "method": certificate.method,
        "least_width": float(certificate.least_width),
        "speed_bound": [float(v) for v in certificate.speed],
        "covers_initial_set": certificate.whole_start,
        "properties": [
            {
                "property": f.code,
                "title": f.title,
                "statement": f.statement,
                "holds": f.holds,
                "margin": float(f.margin),
                "where": f.place(),
            }
            for f in certificate.findings
        ],
        "input": input_report(controller),
        "cost": cost_report(controller),
    }


def input_report(controller: Controller) -> dict[str, Any]:
    """What the law asks of actuator and clock: largest_u, |u| at the clamp where the tube is narrowest; sampling, the longest
    period that is proved for the plant of the task's [plant] (`bounds.py`), with what |e| and |u| stay below, the gain at which
    it would be longest, and the gains that are proved at emit.tick_period or a millisecond; None where nothing is proved."""
    task, certificate = controller.task, controller.certificate
    width, e_max = float(certificate.least_width), float(task.control.e_max)
    report: dict[str, Any] = {
        "largest_u": None,
        "sampling": None,
        "u_max": [float(u) for u in task.control.u_max or ()],
        "tick_period": None if task.emit.tick_period is None else float(task.emit.tick_period),
    }
    if width > 0:
        gain = abs(float(task.control.gain))
        report["largest_u"] = 4 * gain / (width * (1 - e_max * e_max)) * math.log((1 + e_max) / (1 - e_max))
    if certificate.holds:
        from stt_codegen.bounds import Analysis

        report["sampling"] = Analysis(controller).sampling()
    return report


def cost_report(controller: Controller) -> dict[str, Any]:
    """Operations of one period (`control`, and `alpha_step` where there is one), bytes of tables, and of code where a C
    compiler is present (host, -Os)."""
    program = controller.program
    step = [f.name for f in program.functions if f.name in ("control", "alpha_step")]
    counts = sum((cost_of(program, name) for name in step), Counter())
    return {
        "functions": step,
        "operations": {kind: counts[kind] for kind in KINDS if counts[kind]},
        "operations_total": sum(counts.values()),
        "table_bytes": table_bytes(program),
        "host_code_bytes": _code_bytes(controller),
    }


def _code_bytes(controller: Controller) -> int | None:
    """Bytes of machine code of the whole C file on this host, or None without a compiler or `size`."""
    try:
        compiler = find_compiler()
        with tempfile.TemporaryDirectory() as folder:
            for name, data in controller.files.items():
                Path(folder, name).write_bytes(data)
            flags = [f for f in STRICT if f != "-O2"]
            source, target = f"{folder}/{controller.task.name}.c", f"{folder}/o.o"
            subprocess.run([compiler, *flags, "-Os", "-c", source, "-o", target], check=True, capture_output=True)
            output = subprocess.run(["size", "-A", target], check=True, capture_output=True, text=True).stdout
    except (SttError, OSError, subprocess.SubprocessError):
        return None
    return sum(int(line.split()[1]) for line in output.splitlines() if line.startswith(".text"))
