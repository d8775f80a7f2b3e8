"""Check the error bands (P7) with Gappa: it bounds how the C's statements round, for each edge of the shipped refined tubes.

    python -m benchmarks gappa [--folder generated] [--keep DIR]

From each C file it reads the table, the constants of time, and the statements of `basis` and `blend`, with the reader of the
stand-alone checker. Gappa must prove that the spline time is within 4 rounding errors of K, also where t was rounded. It must
also prove for each dimension that the statements lose no more than the remaining part of the certificate's `edge_error`. The
exit code is 1 where Gappa does not prove it, 4 without Gappa. With --keep the scripts stay in DIR.
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

from stt_codegen.certify import checker
from stt_codegen.theorem.facts import Statement
from stt_codegen.theorem.reading import read_kernels, read_spline_time

ROOT = Path(__file__).parent.parent
FORMATS = {  # Gappa's name, bits of the significand, exponent of the smallest number
    "float": ("ieee_32", 24, 150),
    "double": ("ieee_64", 53, 1075),
}
PARTS = 16  # of [0, 1], which Gappa treats one by one


def dyadic(value: Fraction, toward: Callable[[Fraction], int] = math.floor) -> str:
    """Return a number as Gappa reads it, m 2^e with at most 60 bits of m. toward: rounds a number that needs more."""
    exponent = value.numerator.bit_length() - value.denominator.bit_length() - 60
    return f"{toward(value / Fraction(2) ** exponent)}b{exponent}"


def statements(code: tuple[Statement, ...]) -> str:
    """Return the statements as Gappa's definitions, with each value rounded (v) and exact (e)."""
    inputs = ["s", "q0", "q1", "q2", "q3"]

    def operand_name(kind: str, value: int, letter: str) -> str:
        return str(value) if kind == "C" else inputs[value] if value < len(inputs) else f"{letter}{value}"

    lines = [f"{name} = rnd(d{name});" for name in inputs]
    for k, (sign, left, right) in enumerate(code, len(inputs)):
        for letter, equals in (("v", "rnd="), ("e", "=")):
            lines.append(f"{letter}{k} {equals} {operand_name(*left, letter)} {sign} {operand_name(*right, letter)};")
    return "\n".join(lines)


def blend_script(scalar: str, code: tuple[Statement, ...], largest: Fraction, bound: Fraction) -> str:
    """Return the script that proves `bound` on the rounding of the statements, for table entries up to `largest`."""
    last = 4 + len(code)
    ranges = " /\\ ".join(f"|q{j}| <= {dyadic(largest)}" for j in range(4))
    return (
        f"@rnd = float<{FORMATS[scalar][0]}, ne>;\n{statements(code)}\n"
        f"{{ s in [0, 1] /\\ {ranges} -> |v{last} - e{last}| <= {dyadic(bound)} }}\n"
        f"v{last} - e{last} $ s in {PARTS};\n"
    )


def time_script(scalar: str, rate: Fraction, per_second: Fraction, t_c: Fraction, bound: Fraction) -> str:
    return (
        f"@rnd = float<{FORMATS[scalar][0]}, ne>;\nt = rnd(dt);\nu rnd= t * {dyadic(rate)};\nexact = dt * ({per_second});\n"
        f"{{ dt in [0, {dyadic(t_c, math.ceil)}] -> |u - exact| <= {dyadic(bound)} }}\n"
    )


def is_proved(script: str, keep: Path | None, name: str) -> bool:
    """Return whether Gappa proves the script. keep: folder in which the script is stored."""
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
        (keep / f"{name}.g").write_text(script)
    done = subprocess.run(["gappa"], input=script, capture_output=True, text=True, timeout=600, check=False)
    if done.returncode:
        print(f"{name}: {' '.join((done.stdout + done.stderr).split())[-300:]}", file=sys.stderr)
    return done.returncode == 0


def gappa_answers(folder: Path, task: Path, keep: Path | None) -> list[bool]:
    """Ask Gappa about one controller. Return whether it proves the bound on time, then the bound of each dimension."""
    name, scalar = task.stem, folder.name
    certificate = json.loads((folder / f"{name}.certificate.json").read_text())
    checked_task = checker.Task(task.read_bytes())
    source = checker.Source((folder / f"{name}.c").read_bytes(), checked_task, scalar == "float")
    tube = checker.Tube(source, checked_task, certificate["grid"]["unit_bits"], certificate["grid"].get("seam"))
    _, bits, smallest_exponent = FORMATS[scalar]
    eps, tiny = Fraction(1, 1 << bits), Fraction(1, 1 << smallest_exponent)
    time_error = tube.segments * 4 * eps * (1 + eps) + tiny
    rate, last = read_spline_time(source, checked_task.n)
    if not 0 < tube.segments - last <= time_error:
        return [False]
    script_name = f"{name}_{scalar}"
    answers = [
        is_proved(
            time_script(scalar, rate, tube.segments / checked_task.t_c, checked_task.t_c, time_error), keep, f"{script_name}_time"
        )
    ]
    for i, error in enumerate(certificate["edge_error"]):
        largest = max(abs(v) for row in tube.table for v in row[i]) * tube.unit
        bound = error * tube.unit - time_error * tube.fastest(i) * tube.unit
        answers.append(
            bound > 0 and is_proved(blend_script(scalar, read_kernels(source), largest, bound), keep, f"{script_name}_{i + 1}")
        )
    return answers


def main() -> int:
    """Ask Gappa about every shipped refined controller. Return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--folder", type=Path, default=ROOT / "generated")
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    if shutil.which("gappa") is None:
        print("gappa is not found; install (Debian names): gappa", file=sys.stderr)
        return 4
    begin, bound_count, refused = time.perf_counter(), 0, []
    for folder in sorted(p for scalar in FORMATS for p in options.folder.glob(f"*/refined/{scalar}")):
        name = folder.parents[1].name
        answers = gappa_answers(folder, ROOT / "tasks" / f"{name}.toml", options.keep)
        bound_count += len(answers)
        if not all(answers):
            refused.append(str(folder))
    print(f"Gappa: {bound_count} bounds of P7 in the shipped files; {len(refused)} files are not confirmed")
    print(f"{time.perf_counter() - begin:.0f} s" + "".join(f"\nnot confirmed: {name}" for name in refused))
    return bool(refused)


if __name__ == "__main__":
    sys.exit(main())
