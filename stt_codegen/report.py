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
    """What the law asks of actuator and clock, at the tube's narrowest (rules of thumb for xdot = g u, 0 < g <= g_max).

    largest_u: |u| at the clamp, E = e_max: 4 |k| / (w (1 - E^2)) ln((1 + E)/(1 - E)). periods: by E, up to
    w^2 E (1 - E^2) / (4 |k| g_max ln((1 + E)/(1 - E))) seconds a held u never carries the state farther past the middle
    than it was, from |e| <= E. g_max is the plant's, or 1. u_max_is_slow: u_max is below the tube's speed.
    """
    task, certificate = controller.task, controller.certificate
    width, gain = float(certificate.least_width), abs(float(task.control.gain))
    g_max = float(task.plant.g_max or 1)
    limits = task.control.u_max or ()
    report: dict[str, Any] = {
        "largest_u": None,
        "periods": {},
        "g_max": g_max,
        "u_max": [float(u) for u in limits],
        "tick_period": None if task.emit.tick_period is None else float(task.emit.tick_period),
        "u_max_is_slow": any(u * g_max < v for u, v in zip(limits, certificate.speed, strict=False)),
    }
    if width <= 0:
        return report
    clamp = float(task.control.e_max)
    for e in sorted({min(0.8, clamp), clamp}):
        steep = math.log((1 + e) / (1 - e))
        report["largest_u"] = 4 * gain / (width * (1 - e * e)) * steep
        report["periods"][f"{e:g}"] = width**2 * e * (1 - e * e) / (4 * gain * g_max * steep)
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
