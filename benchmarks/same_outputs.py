"""Compare the shipped C with that of another commit: whether every function gives the same bits on random inputs.

    python -m benchmarks same_outputs --against COMMIT [--count 1000000] [--seed 0] [--only NAME] [--functions control,tube]
        [--special 0.01]

Each C file of generated/ is compiled beside the file of the same path in COMMIT. Functions that both have, with the same
parameters, run on the same inputs: times from before 0 to after t_c; three states of four in the tube and up to a fifth of its
width beyond, the others anywhere; a share of `--special` is a NaN, an infinity, 0 or huge. It prints one row for each file, with
the share of inputs that had status OK, and ends with exit code 1 where a bit differs. It is for changes of the printer that must
not change what a controller computes.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from stt_codegen.program.targets.c.runner import find_compiler
from stt_codegen.program.targets.toolchain import run_compiler

ROOT = Path(__file__).parent.parent
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC")
KINDS = {"float": np.float32, "double": np.float64, "int32_t": np.int32, "uint32_t": np.uint32, "bool": np.bool_}
SPECIAL = (np.nan, np.inf, -np.inf, 0.0, -0.0, 1e30, -1e30)
STATES_BY_THE_TUBE = 0.75  # of all states
BEYOND_AN_EDGE = 0.2  # of the tube's width, at most


@dataclass(frozen=True)
class Parameter:
    """A parameter of a public function: the type of its numbers, how many there are, and whether the function writes them."""

    name: str
    kind: str
    length: int
    is_output: bool


@dataclass(frozen=True)
class Prototype:
    """A public function of a header; result: the type that it returns, "void" for none."""

    name: str
    result: str
    parameters: tuple[Parameter, ...]


def prototypes(header: str, prefix: str) -> Iterator[Prototype]:
    """Yield the functions of a header in C whose parameters are numbers and arrays of numbers."""
    real = re.search(rf"typedef (\w+) {prefix}_real;", header)
    dimension = re.search(rf"#define {prefix.upper()}_N (\d+)", header)
    assert dimension is not None
    text = re.sub(r"/\*.*?\*/|^#.*?$", "", header, flags=re.S | re.M)
    for result, name, inside in re.findall(rf"^(\w+) ({prefix}_\w+)\(([^;{{}}]*)\);", text, flags=re.M):
        parameters = [_parameter(part.strip(), real[1] if real else "", prefix, int(dimension[1])) for part in inside.split(",")]
        known = [p for p in parameters if p is not None]
        if len(known) == len(parameters):
            kinds = {f"{prefix}_real": real[1] if real else "", f"{prefix}_status": "int32_t", "int": "int32_t"}
            yield Prototype(name.removeprefix(f"{prefix}_"), kinds.get(result, result), tuple(known))


def _parameter(text: str, real: str, prefix: str, n: int) -> Parameter | None:
    """Return the parameter that a declaration stands for; None for one of another kind."""
    match = re.fullmatch(rf"(const )?(\w+) (\w+)(?:\[(?:(\d+) \* )?{prefix.upper()}_N\])?", " ".join(text.split()))
    kind = match and {f"{prefix}_real": real}.get(match[2], match[2])
    if match is None or kind not in KINDS:
        return None
    is_array = "[" in text
    return Parameter(match[3], kind, n * int(match[4] or 1) if is_array else 0, is_array and not match[1])


def driver(prefix: str, functions: list[Prototype]) -> str:
    """Return C that includes the controller and calls each function for many inputs, in arrays of one row an input."""
    parts = [f'#include "{prefix}.c"']
    for f in functions:
        rows = "".join(f", {p.kind} *{p.name}" for p in f.parameters)
        arguments = ", ".join(f"{p.name} + k * {p.length}" if p.length else f"{p.name}[k]" for p in f.parameters)
        returned = "" if f.result == "void" else f", {f.result} *result_"
        target = "" if f.result == "void" else f"result_[k] = ({f.result})"
        parts.append(
            f"void many_{f.name}(long count{rows}{returned})\n"
            f"{{ for (long k = 0; k < count; ++k) {{ {target}{prefix}_{f.name}({arguments}); }} }}"
        )
    return "\n".join(parts)


class Library:
    """A compiled controller whose functions take many inputs in one call."""

    def __init__(self, files: dict[str, bytes], prefix: str, functions: list[Prototype]) -> None:
        self.functions = {f.name: f for f in functions}
        with tempfile.TemporaryDirectory() as folder:
            for name, data in files.items():
                Path(folder, name).write_bytes(data)
            Path(folder, "driver.c").write_text(driver(prefix, functions))
            compiled = f"{folder}/driver.so"
            run_compiler([find_compiler(), *FLAGS, "-o", compiled, f"{folder}/driver.c", "-lm"])
            self.library = ctypes.CDLL(compiled)

    def outputs(self, f: Prototype, inputs: dict[str, np.ndarray], count: int) -> list[np.ndarray]:
        """Return what a function writes and returns for these inputs, row by row."""
        arrays = [
            np.zeros((count, p.length), KINDS[p.kind]) if p.is_output else np.ascontiguousarray(inputs[p.name])
            for p in f.parameters
        ]
        results = [a for a, p in zip(arrays, f.parameters, strict=True) if p.is_output]
        if f.result != "void":
            results.append(np.zeros(count, KINDS[f.result]))
            arrays.append(results[-1])
        pointers = [ctypes.c_void_p(a.ctypes.data) for a in arrays]
        getattr(self.library, f"many_{f.name}")(ctypes.c_long(count), *pointers)
        return results


@dataclass(frozen=True)
class InputRanges:
    """What inputs are drawn from. duration: the prescribed time in seconds; tick_period: seconds, 0 without ticks; reach: the
    largest |coordinate| of the tube, in units of its C; filters: lambda by component, for order 2; special_share: of numbers that
    are a NaN, an infinity, 0 or huge."""

    duration: float
    tick_period: float
    reach: float
    filters: np.ndarray
    special_share: float


def random_inputs(
    f: Prototype, rng: np.random.Generator, count: int, ranges: InputRanges, library: Library
) -> dict[str, np.ndarray]:
    """Draw inputs of a function. library: the controller whose tube the states are by."""
    inputs: dict[str, np.ndarray] = {}
    duration, reach = ranges.duration, ranges.reach
    for p in (p for p in f.parameters if not p.is_output):
        size = (count, p.length) if p.length else (count,)
        if p.name == "tick":
            inputs[p.name] = rng.integers(0, int(1.2 * duration / ranges.tick_period) + 2, size).astype(KINDS[p.kind])
        elif p.kind in ("int32_t", "uint32_t"):
            inputs[p.name] = rng.uniform(-1.2 * reach, 1.2 * reach, size).astype(KINDS[p.kind])
        else:
            low, high = {"t": (-0.1 * duration, 1.1 * duration), "dt": (-0.01, 0.1), "alpha": (0.0, reach)}.get(
                p.name, (-1.2 * reach, 1.2 * reach)
            )
            inputs[p.name] = rng.uniform(low, high, size).astype(KINDS[p.kind])
    _move_states_to_the_tube(inputs, rng, ranges, library)
    for values in inputs.values():
        if values.dtype.kind == "f":
            is_special = rng.random(values.shape) < ranges.special_share
            values[is_special] = rng.choice(SPECIAL, int(is_special.sum()))
    return inputs


def _move_states_to_the_tube(
    inputs: dict[str, np.ndarray], rng: np.random.Generator, ranges: InputRanges, library: Library
) -> None:
    """Put most x, and v, between the edges at the time of the call or a little beyond. Without a time or a tube they stay."""
    names = [name for name in ("x", "v") if name in inputs]
    time = "tick" if "tick" in inputs else "t"
    if time not in inputs or "x" not in names or "tube" not in library.functions:
        return
    count = len(inputs[time])
    is_moved = rng.random(count) < STATES_BY_THE_TUBE
    x = None
    for name, function in zip(names, ("tube", "filtered_tube"), strict=False):
        tube = library.functions[function]
        known = dict(inputs)
        if tube.parameters[0].name == "t" and time == "tick":
            known["t"] = (inputs["tick"] * ranges.tick_period).astype(KINDS[tube.parameters[0].kind])
        lower, upper = (edge.astype(float) for edge in library.outputs(tube, known, count))
        drawn = lower + (upper - lower) * rng.uniform(-BEYOND_AN_EDGE, 1 + BEYOND_AN_EDGE, lower.shape)
        if x is not None:  # what was drawn is v + lambda x
            drawn -= ranges.filters * x
        x = np.where(is_moved[:, None], drawn, inputs[name])
        inputs[name] = x.astype(inputs[name].dtype)


def old_file(commit: str, path: Path) -> bytes | None:
    """Return a file of a commit; None where it has none."""
    result = subprocess.run(["git", "show", f"{commit}:{path}"], cwd=ROOT, capture_output=True, check=False)
    return result.stdout if result.returncode == 0 else None


def differences(path: Path, options: argparse.Namespace) -> list[str] | None:
    """Return one message for each function whose outputs differ; None where the commit does not have the file.

    path: of a C file, relative to the repository."""
    prefix = path.stem
    paths = [path, path.with_suffix(".h")]
    now = {p.name: (ROOT / p).read_bytes() for p in paths}
    before = {p.name: data for p in paths if (data := old_file(options.against, p)) is not None}
    if len(before) < len(paths):
        return None
    header = now[f"{prefix}.h"].decode()
    old = {f.name: f for f in prototypes(before[f"{prefix}.h"].decode(), prefix)}
    wanted = set(options.functions.split(",")) if options.functions else None
    functions = [f for f in prototypes(header, prefix) if old.get(f.name) == f and (wanted is None or f.name in wanted)]
    functions = [f for f in functions if f"{prefix}_{f.name}(".encode() in now[path.name]]  # others are in files beside it
    ranges = _input_ranges(path, header, now[path.name], options.special)
    libraries = [Library(files, prefix, functions) for files in (before, now)]
    messages, inside = [], []
    for f in functions:
        inputs = random_inputs(f, np.random.default_rng(options.seed), options.count, ranges, libraries[1])
        pairs = list(zip(*(library.outputs(f, inputs, options.count) for library in libraries), strict=True))
        if any(a.tobytes() != b.tobytes() and not _same_but_for_nan(a, b) for a, b in pairs):
            messages.append(f"{f.name} differs")
        if f.result == "int32_t" and f.name.startswith("control"):
            inside.append(f"{f.name} {(pairs[-1][1] == 0).mean():.0%}")
    share = f"; status OK: {', '.join(inside)}" if inside else ""
    return messages or [f"equal: {', '.join(f.name for f in functions)}{share}"]


def _input_ranges(path: Path, header: str, c: bytes, special_share: float) -> InputRanges:
    """Read what inputs are drawn from: times in the header, coordinates in the C's table, lambda in the certificate."""
    prefix = path.stem.upper()
    stated = {name: float(v) for name, v in re.findall(rf"#define {prefix}_(\w+) (?:U?INT32_C\()?([\d.e-]+)", header)}
    tick_period = 1 / stated["TICKS_A_SECOND"] if "TICKS_A_SECOND" in stated else stated.get("TICK_PERIOD", 0.0)
    duration = stated["T_C"] if "T_C" in stated else stated["TICKS"] * tick_period
    table = re.search(rb"_(?:coefficients|reach)\[\d+\][^{]*\{(.*?)\};", c, flags=re.S)
    reach = 6 * max(abs(float(v)) for v in re.findall(rb"-?[\d.]+(?:e-?\d+)?", table[1] if table else b"1"))
    certificate = json.loads((ROOT / path).with_suffix(".certificate.json").read_text())
    filters = np.array([float(Fraction(v)) for v in certificate.get("filter", [])])
    return InputRanges(duration, tick_period, reach, filters, special_share)


def _same_but_for_nan(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two arrays have the same bits but where both have a NaN, whose bits mean nothing."""
    if a.dtype.kind != "f":
        return bool(np.array_equal(a, b))
    words = np.uint32 if a.dtype == np.float32 else np.uint64
    return bool(((a.view(words) == b.view(words)) | (np.isnan(a) & np.isnan(b))).all())


def main() -> None:
    """Compare all files, and print a row for each."""
    parser = argparse.ArgumentParser(
        prog="benchmarks same_outputs", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--against", required=True, metavar="COMMIT")
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", metavar="NAME", help="files whose path has this in it")
    parser.add_argument("--special", type=float, default=0.01, metavar="SHARE", help="of numbers that are no ordinary input")
    parser.add_argument("--functions", default="", help="names, separated by commas; default: all that both have")
    options = parser.parse_args()
    failed = False
    for file in sorted((ROOT / "generated").rglob("*.c")):
        path = file.relative_to(ROOT)
        if options.only not in str(path) or not file.with_suffix(".h").exists():
            continue
        messages = differences(path, options)
        failed |= any("differs" in message for message in messages or ())
        print(f"{path.relative_to('generated')!s:45s} {'is new' if messages is None else '; '.join(messages)}", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
