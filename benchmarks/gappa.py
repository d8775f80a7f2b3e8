"""Check the rounding bounds (property P7) of the shipped refined tubes with Gappa.

    python -m benchmarks gappa [--folder generated] [--keep DIR]

A tube has K segments. The C turns the time t in [0, t_c] into the spline time K t / t_c, whose whole part is the index of the
segment and whose rest is s. The functions `basis` and `blend` then compute an edge from s and four entries of the table. This
script reads the table, the constants of `segment`, and these statements from each C file, with the reader of the stand-alone
checker. Gappa must prove two bounds:

- The rounding error of the spline time is at most about 4 K 2^-24 (2^-53 for double). The rounding of t is part of this error.
- For each dimension, `basis` and `blend` round by no more than the certificate's `edge_error` minus what the error of the spline
  time adds to it.

The exit code is 1 if Gappa does not prove a bound, and 4 if Gappa is not installed. With --keep the scripts stay in DIR.
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
from typing import NamedTuple

from stt_codegen.certify import checker
from stt_codegen.theorem.facts import Statement
from stt_codegen.theorem.reading import read_kernels, read_spline_time

ROOT = Path(__file__).parent.parent
S_INTERVALS = 16  # Gappa bounds the statements on so many equal parts of 0 <= s <= 1, one by one
SPLINE_TIME_ROUNDINGS = 4


class GappaFormat(NamedTuple):
    """A floating-point format: its name in Gappa, the bits of its significand, and k: half of its smallest number is 2^-k."""

    gappa_name: str
    significand_bits: int
    underflow_exponent: int


FORMATS = {"float": GappaFormat("ieee_32", 24, 150), "double": GappaFormat("ieee_64", 53, 1075)}


def dyadic(value: Fraction, toward: Callable[[Fraction], int] = math.floor) -> str:
    """Return a positive number as Gappa reads it: "<m>b<e>" is m 2^e, with 60 or 61 bits of m.

    toward: rounds m where the number has more bits: down with math.floor, up with math.ceil."""
    exponent = value.numerator.bit_length() - value.denominator.bit_length() - 60
    return f"{toward(value / Fraction(2) ** exponent)}b{exponent}"


def statements(code: tuple[Statement, ...]) -> str:
    """Return two definitions in Gappa's language for each statement: v<k> is the rounded value, e<k> the exact one.

    Values 0 to 4 are s and the four entries of the table, as in `KernelReader` of stt_codegen/theorem/reading.py."""
    inputs = ["s", "q0", "q1", "q2", "q3"]

    def operand_name(kind: str, value: int, letter: str) -> str:  # kind "C": `value` is a constant, else a value's number
        return str(value) if kind == "C" else inputs[value] if value < len(inputs) else f"{letter}{value}"

    lines = [f"{name} = rnd(d{name});" for name in inputs]
    for k, (sign, left, right) in enumerate(code, len(inputs)):
        for letter, equals in (("v", "rnd="), ("e", "=")):
            lines.append(f"{letter}{k} {equals} {operand_name(*left, letter)} {sign} {operand_name(*right, letter)};")
    return "\n".join(lines)


def blend_script(scalar: str, code: tuple[Statement, ...], largest: Fraction, bound: Fraction) -> str:
    """Return the script that proves: for |table entries| <= largest the statements round their last value by `bound` at most."""
    last_value = 4 + len(code)
    ranges = " /\\ ".join(f"|q{j}| <= {dyadic(largest)}" for j in range(4))
    return (
        f"@rnd = float<{FORMATS[scalar].gappa_name}, ne>;\n{statements(code)}\n"
        f"{{ s in [0, 1] /\\ {ranges} -> |v{last_value} - e{last_value}| <= {dyadic(bound)} }}\n"
        f"v{last_value} - e{last_value} $ s in {S_INTERVALS};\n"
    )


def time_script(scalar: str, rounded_scale: Fraction, exact_scale: Fraction, t_c: Fraction, bound: Fraction) -> str:
    """Return the script that proves: the spline time has an error of at most `bound` (segments) for times from 0 to t_c.

    rounded_scale: the constant K/t_c (segments a second) as the C has it; exact_scale: its exact value."""
    return (
        f"@rnd = float<{FORMATS[scalar].gappa_name}, ne>;\nt = rnd(dt);\nu rnd= t * {dyadic(rounded_scale)};\n"
        f"exact = dt * ({exact_scale});\n"
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


def gappa_answers(folder: Path, task_path: Path, keep: Path | None) -> list[bool]:
    """Ask Gappa about one controller. Return whether it proves the bound of the spline time, then the bound of each dimension."""
    name, scalar = task_path.stem, folder.name
    certificate = json.loads((folder / f"{name}.certificate.json").read_text())
    checked_task = checker.Task(task_path.read_bytes())
    source = checker.Source((folder / f"{name}.c").read_bytes(), checked_task, scalar == "float")
    tube = checker.Tube(source, checked_task, certificate["grid"]["unit_bits"], certificate["grid"].get("seam"))
    unit_roundoff = Fraction(1, 1 << FORMATS[scalar].significand_bits)
    underflow_error = Fraction(1, 1 << FORMATS[scalar].underflow_exponent)
    time_error = tube.segments * SPLINE_TIME_ROUNDINGS * unit_roundoff * (1 + unit_roundoff) + underflow_error
    rounded_scale, last_spline_time = read_spline_time(source, checked_task.n)
    if not 0 < tube.segments - last_spline_time <= time_error:
        return [False]
    script_name = f"{name}_{scalar}"
    answers = [
        is_proved(
            time_script(scalar, rounded_scale, tube.segments / checked_task.t_c, checked_task.t_c, time_error),
            keep,
            f"{script_name}_time",
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
