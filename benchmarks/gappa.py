"""Check the rounding bounds (property P7) of refined tubes in floating point with Gappa.

    python -m benchmarks gappa [--folder generated] [--keep DIR]

A tube has K segments. The C turns the time t in [0, t_c] into the spline time K t / t_c, whose whole part is the index of the
segment and whose rest is s. The functions `basis` and `edge_at` then compute an edge from s and four entries of the table,
`basis_rate` and `edge_at` its slope. The statements of these functions are the same in every C, so this script reads them in the
stand-alone checker's listing. Gappa must prove, for float and for double:

- Where the entries are at most Q in size, an edge rounds by at most (123 eps + 441 eps^2) Q, and a slope by (175 eps + 568 eps^2)
  Q; both plus what numbers near 0 lose. These are the constants of the checker (rounding.py). Gappa takes all entries up to 2 Q
  and the bound of Q, for three Q that are powers of two: the smallest and the largest that a controller may have, and 1. A factor
  2^k in all entries is a factor 2^k in all that is computed from them, except near 0, so this is the bound for all Q.
- For each shipped file, the rounding error of the spline time is at most about 4 K eps. The rounding of t is part of this error.

That a certificate's `edge_error` and `rate_error` are at least these bounds with the file's own numbers is computed here.
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

from stt_codegen.checker.stt_checker.exact import SMALLEST, units_above
from stt_codegen.checker.stt_checker.rounding import EDGE, RATE, arithmetic_error
from stt_codegen.checker.stt_checker.source import fill, real_table, tokens
from stt_codegen.checker.stt_checker.task import Task
from stt_codegen.checker.stt_checker.tube import Tube
from stt_codegen.theorem.facts import Statement
from stt_codegen.theorem.kernels import KernelText, read_kernels, read_spline_time

ROOT = Path(__file__).parent.parent
S_INTERVALS = 16  # Gappa bounds the statements on so many equal parts of 0 <= s <= 1, one by one
SPLINE_TIME_ROUNDINGS = 4
TINY_FACTOR = 200  # of half the smallest number, times one more than Q
ENTRY_SIZES = (SMALLEST, Fraction(1), 1 / SMALLEST / 2)


class GappaFormat(NamedTuple):
    """A floating-point format: its name in Gappa, the bits of its significand, and k: half of its smallest number is 2^-k."""

    gappa_name: str
    significand_bits: int
    underflow_exponent: int

    @property
    def roundoff(self) -> Fraction:
        return Fraction(1, 1 << self.significand_bits)

    @property
    def tiny(self) -> Fraction:
        return Fraction(1, 1 << self.underflow_exponent)


FORMATS = {"float": GappaFormat("ieee_32", 24, 150), "double": GappaFormat("ieee_64", 53, 1075)}


def dyadic(value: Fraction, toward: Callable[[Fraction], int] = math.floor) -> str:
    """Return a positive number as Gappa reads it: "<m>b<e>" is m 2^e, with 60 or 61 bits of m.

    toward: rounds m where the number has more bits: down with math.floor, up with math.ceil."""
    exponent = value.numerator.bit_length() - value.denominator.bit_length() - 60
    return f"{toward(value / Fraction(2) ** exponent)}b{exponent}"


def listed_kernels() -> KernelText:
    """Return the checker's listing of the kernels, for a task named p in one dimension, with literals as a double has them."""
    rows = {f"row_{j}": 2 * j for j in (1, 2, 3)}
    words = [word for piece in ("basis", "rate of the basis", "edge") for word in fill(piece, set(), "p", rows)]
    return KernelText(words, "p", 1, FORMATS["double"].significand_bits)


def statements(code: tuple[Statement, ...]) -> str:
    """Return two definitions in Gappa's language for each statement: v<k> is the rounded value, e<k> the exact one.

    Values 0 to 4 are s and the four entries of the table, as in `KernelReader` of stt_codegen/theorem/kernels.py."""
    inputs = ["s", "q0", "q1", "q2", "q3"]

    def operand_name(kind: str, value: int, letter: str) -> str:  # kind "C": `value` is a constant, else a value's number
        return str(value) if kind == "C" else inputs[value] if value < len(inputs) else f"{letter}{value}"

    lines = [f"{name} = rnd(d{name});" for name in inputs]
    for k, (sign, left, right) in enumerate(code, len(inputs)):
        for letter, equals in (("v", "rnd="), ("e", "=")):
            lines.append(f"{letter}{k} {equals} {operand_name(*left, letter)} {sign} {operand_name(*right, letter)};")
    return "\n".join(lines)


def kernel_script(number_format: GappaFormat, code: tuple[Statement, ...], largest: Fraction, bound: Fraction) -> str:
    """Return the script that proves: for |table entries| <= largest the statements round their last value by `bound` at most."""
    last_value = 4 + len(code)
    ranges = " /\\ ".join(f"|q{j}| <= {dyadic(largest, math.ceil)}" for j in range(4))
    return (
        f"@rnd = float<{number_format.gappa_name}, ne>;\n{statements(code)}\n"
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


def constants_answers(scalar: str, keep: Path | None) -> dict[str, bool]:
    """Ask Gappa about the checker's constants for an edge and for a slope. Return whether it proves each, by name."""
    number_format, answers = FORMATS[scalar], {}
    eps = number_format.roundoff
    for label, is_rate, (first, second) in (("edge", False, EDGE), ("slope", True, RATE)):
        code = read_kernels(listed_kernels(), is_rate)
        for number, size in enumerate(ENTRY_SIZES, 1):
            bound = (first * eps + second * eps**2) * size + TINY_FACTOR * (size + 1) * number_format.tiny
            name = f"{label}_{scalar}_{number}"
            answers[name] = is_proved(kernel_script(number_format, code, 2 * size, bound), keep, name)
    return answers


def file_answers(folder: Path, task_path: Path, keep: Path | None) -> dict[str, bool]:
    """Ask Gappa about the spline time of one controller, and compare its certificate with the bounds.

    Return the answers by name."""
    name, scalar = task_path.stem, folder.name
    bits, certificate = FORMATS[scalar].significand_bits, json.loads((folder / f"{name}.certificate.json").read_text())
    task, data, grid = Task(task_path.read_bytes()), (folder / f"{name}.c").read_bytes(), certificate["grid"]
    unit = Fraction(2) ** -grid["unit_bits"]
    tube = Tube(real_table(data, f"{name}_coefficients", bits), task.n, unit, task.t_c, grid.get("seam"))
    rounded_scale, last_spline_time = read_spline_time(KernelText(tokens(data.decode()), name, task.n, bits))
    eps = FORMATS[scalar].roundoff
    time_error = tube.segments * SPLINE_TIME_ROUNDINGS * eps * (1 + eps) + FORMATS[scalar].tiny
    answers = {"the last spline time": 0 < tube.segments - last_spline_time <= time_error}
    script = time_script(scalar, rounded_scale, tube.segments / task.t_c, task.t_c, time_error)
    answers["the spline time"] = is_proved(script, keep, f"{name}_{scalar}_time")
    for order, (key, key_unit) in enumerate((("edge_error", unit), ("rate_error", unit * tube.segments / task.t_c))):
        errors = arithmetic_error(tube, bits, order) if key in certificate else []
        stated = certificate.get(key, [])
        answers[key] = all(units_above(v, key_unit) <= c for v, c in zip(errors, stated, strict=True))
    return answers


def main() -> int:
    """Ask Gappa about the constants and every shipped refined controller. Return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--folder", type=Path, default=ROOT / "generated")
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    if shutil.which("gappa") is None:
        print("gappa is not found; install (Debian names): gappa", file=sys.stderr)
        return 4
    begin, answers = time.perf_counter(), dict[str, bool]()
    for scalar in FORMATS:
        answers |= constants_answers(scalar, options.keep)
    for folder in sorted(p for scalar in FORMATS for p in options.folder.glob(f"*/refined/{scalar}")):
        task_path = ROOT / "tasks" / f"{folder.parents[1].name}.toml"
        by_name = file_answers(folder, task_path, options.keep)
        answers |= {f"{folder}: {name}": answer for name, answer in by_name.items()}
    refused = [name for name, answer in answers.items() if not answer]
    print(f"Gappa: {len(answers)} bounds of P7, of the listing and of shipped files; {len(refused)} are not confirmed")
    print(f"{time.perf_counter() - begin:.0f} s" + "".join(f"\nnot confirmed: {name}" for name in refused))
    return bool(refused)


if __name__ == "__main__":
    sys.exit(main())
