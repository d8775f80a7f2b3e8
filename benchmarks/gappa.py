"""A second opinion on P7: Gappa bounds the rounding of the C's statements, for every edge of every refined tube that is shipped.

    python -m benchmarks gappa [--folder generated] [--keep DIR]

Of each C file it reads the table, the constants of time, and the statements of `basis` and `blend` as the stand-alone checker's
reader finds them, and asks Gappa two things: that spline time is within 4 rounding errors of K, also where t was rounded; and, by
dimension, that the statements lose no more than what the certificate's `edge_error` leaves beside that. Exit code 1 where Gappa
cannot show it, 4 without Gappa. With --keep the scripts are left in DIR.
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
FORMATS = {"float": ("ieee_32", 24, 150), "double": ("ieee_64", 53, 1075)}
PARTS = 16  # into so many [0, 1] is cut


def dyadic(value: Fraction, toward: Callable[[Fraction], int] = math.floor) -> str:
    """A number as Gappa reads it, m 2^e with 60 bits of m or fewer; one that needs more is rounded `toward`."""
    exponent = value.numerator.bit_length() - value.denominator.bit_length() - 60
    return f"{toward(value / Fraction(2) ** exponent)}b{exponent}"


def statements(code: tuple[Statement, ...]) -> str:
    """Every value rounded (v) and not rounded (e)."""
    inputs = ["s", "q0", "q1", "q2", "q3"]

    def named(kind: str, value: int, letter: str) -> str:
        return str(value) if kind == "C" else inputs[value] if value < len(inputs) else f"{letter}{value}"

    lines = [f"{name} = rnd(d{name});" for name in inputs]
    for k, (sign, left, right) in enumerate(code, len(inputs)):
        for letter, equals in (("v", "rnd="), ("e", "=")):
            lines.append(f"{letter}{k} {equals} {named(*left, letter)} {sign} {named(*right, letter)};")
    return "\n".join(lines)


def blend_script(scalar: str, code: tuple[Statement, ...], largest: Fraction, bound: Fraction) -> str:
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


def holds(script: str, keep: Path | None, name: str) -> bool:
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
        (keep / f"{name}.g").write_text(script)
    done = subprocess.run(["gappa"], input=script, capture_output=True, text=True, timeout=600, check=False)
    if done.returncode:
        print(f"{name}: {' '.join((done.stdout + done.stderr).split())[-300:]}", file=sys.stderr)
    return done.returncode == 0


def confirmed(folder: Path, task: Path, keep: Path | None) -> list[bool]:
    """Of one controller: its time, and every dimension."""
    name, scalar = task.stem, folder.name
    certificate = json.loads((folder / f"{name}.certificate.json").read_text())
    known = checker.Task(task.read_bytes())
    source = checker.Source((folder / f"{name}.c").read_bytes(), known, scalar == "float")
    tube = checker.Tube(source, known, certificate["grid"]["unit_bits"], certificate["grid"].get("seam"))
    _, bits, least = FORMATS[scalar]
    eps, tiny = Fraction(1, 1 << bits), Fraction(1, 1 << least)
    late = tube.segments * 4 * eps * (1 + eps) + tiny
    rate, last = read_spline_time(source, known.n)
    if not 0 < tube.segments - last <= late:
        return [False]
    said = f"{name}_{scalar}"
    found = [holds(time_script(scalar, rate, tube.segments / known.t_c, known.t_c, late), keep, f"{said}_time")]
    for i, error in enumerate(certificate["edge_error"]):
        largest = max(abs(v) for row in tube.table for v in row[i]) * tube.unit
        bound = error * tube.unit - late * tube.fastest(i) * tube.unit
        found.append(bound > 0 and holds(blend_script(scalar, read_kernels(source), largest, bound), keep, f"{said}_{i + 1}"))
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--folder", type=Path, default=ROOT / "generated")
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    if shutil.which("gappa") is None:
        print("gappa is not found; install (Debian names): gappa", file=sys.stderr)
        return 4
    begin, asked, refused = time.perf_counter(), 0, []
    for folder in sorted(p for scalar in FORMATS for p in options.folder.glob(f"*/refined/{scalar}")):
        name = folder.parents[1].name
        answers = confirmed(folder, ROOT / "tasks" / f"{name}.toml", options.keep)
        asked += len(answers)
        if not all(answers):
            refused.append(str(folder))
    print(f"Gappa: {asked} bounds asked for, of P7 of the shipped files; {len(refused)} files are not confirmed")
    print(f"{time.perf_counter() - begin:.0f} s" + "".join(f"\nnot confirmed: {name}" for name in refused))
    return bool(refused)


if __name__ == "__main__":
    sys.exit(main())
