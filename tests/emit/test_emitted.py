"""The emitted files: strict compilers accept them, the object file has only the public names, and C and Python behave as the header
promises."""

from __future__ import annotations

import ctypes
import math
import re
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stt_codegen.designs.tube import MINIMUM_WIDTH
from stt_codegen.emit.naming import _locals, check_names
from stt_codegen.emit.render import render
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.pipeline import EmittedController, build_program, build_task
from stt_codegen.program.nodes import Assign, Kernel, Op, Program, Var
from stt_codegen.program.targets.c.runner import STRICT, CompiledC
from stt_codegen.program.targets.python.runner import GeneratedPython
from stt_codegen.task.load import parse_task
from tests.support.controllers import NAMES, ROOT, build_once, controller_of

OK, OUTSIDE, BAD = 0, 1, 2
BITS = st.integers(0, 2**32 - 1).map(lambda b: float(np.array([b], dtype=np.uint32).view(np.float32)[0]))
CORTEX_M4F = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]


@pytest.fixture(scope="module")
def c_float() -> CompiledC:
    controller = controller_of("omni_s2", "float")
    return CompiledC(controller)


@pytest.fixture(scope="module")
def backends(c_float) -> list:
    double = controller_of("omni_s2", "double")
    return [c_float, CompiledC(double), GeneratedPython(double)]


def write(folder: Path, controller: EmittedController) -> Path:
    """Write the emitted files, and return the path of the C."""
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    return folder / f"{controller.task.name}.c"


def arguments_at(t: float, *x: float) -> tuple[np.ndarray, np.ndarray]:
    """Return t and x as arrays of one point."""
    return np.array([t]), np.array([x])


# ------------------------------------------------------------------------------------------- the object file


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_strict_compilers_give_no_warning(compiler: str, name: str, scalar: str, tool, tmp_path) -> None:
    source = write(tmp_path, controller_of(name, scalar))
    subprocess.run([tool(compiler), *STRICT, "-c", str(source), "-o", str(tmp_path / "o.o")], check=True)


def test_the_header_is_usable_from_cpp_and_links_to_c(tool, tmp_path) -> None:
    source = write(tmp_path, controller_of("omni_s2"))
    main = tmp_path / "main.cpp"
    main.write_text(
        '#include "omni_s2.h"\nint main() { float x[OMNI_S2_N] = {0.25F, 0.25F}; float u[OMNI_S2_N];\n'
        "return omni_s2_control(0.0F, x, u) == OMNI_S2_OK ? 0 : 1; }\n"
    )
    subprocess.run([tool("gcc"), *STRICT, "-c", str(source), "-o", str(tmp_path / "c.o")], check=True)
    flags = ["-std=c++11", "-Wall", "-Wextra", "-pedantic", "-Werror"]
    subprocess.run([tool("g++"), *flags, str(main), str(tmp_path / "c.o"), "-o", str(tmp_path / "main"), "-lm"], check=True)
    subprocess.run([str(tmp_path / "main")], check=True)


def symbols(nm: str, object_file: Path) -> dict[str, str]:
    """Return the symbols of an object file with their kinds, letters of `nm`."""
    lines = subprocess.run([nm, str(object_file)], check=True, capture_output=True, text=True).stdout.splitlines()
    return {line.split()[-1]: line.split()[-2] for line in lines if len(line.split()) >= 2}


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_no_writable_data_and_every_external_name_has_the_prefix(scalar: str, tool, tmp_path) -> None:
    source = write(tmp_path, controller_of("omni_s2", scalar))
    target = tmp_path / "o.o"
    subprocess.run([tool("gcc"), *STRICT, "-fno-pic", "-c", str(source), "-o", str(target)], check=True)
    kinds = symbols(tool("nm"), target)
    assert not [n for n, kind in kinds.items() if kind in "dDbBC"]
    public = {n for n, kind in kinds.items() if kind in "TR"}
    assert public == {f"omni_s2_{f}" for f in ("tube", "tube_rate", "control", "margin", "margins", "covered", "transform")}
    needed = {n for n, kind in kinds.items() if kind == "U"}
    assert needed == {"logf" if scalar == "float" else "log"}


@pytest.mark.parametrize("name", ["omni_s2", "spacecraft"])
def test_a_float_file_has_no_double_arithmetic_on_a_cortex_m4f(name: str, tool, tmp_path) -> None:
    source = write(tmp_path, controller_of(name))
    target = tmp_path / "o.o"
    subprocess.run([tool("arm-none-eabi-gcc"), *CORTEX_M4F, *STRICT, "-c", str(source), "-o", str(target)], check=True)
    kinds = symbols(tool("arm-none-eabi-nm"), target)
    assert {n for n, kind in kinds.items() if kind == "U"} == {"logf"}  # no __aeabi_d*, no double-precision libm name
    text = subprocess.run([tool("arm-none-eabi-objdump"), "-d", str(target)], check=True, capture_output=True, text=True).stdout
    assert not re.search(r"\.f64", text)


def test_fast_math_is_refused_by_the_file_itself(tool, tmp_path) -> None:
    source = write(tmp_path, controller_of("omni_s2"))
    result = subprocess.run(
        [tool("gcc"), "-ffast-math", "-c", str(source)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert result.returncode != 0
    assert "compile without -ffast-math" in result.stderr


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_the_x87_is_refused_by_the_file_itself(scalar: str, tool, tmp_path) -> None:
    source = write(tmp_path, controller_of("omni_s2", scalar))
    command = [tool("gcc"), "-std=c99", "-mfpmath=387", "-c", str(source)]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode != 0
    assert f"compile for {scalar} arithmetic" in result.stderr


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_every_real_literal_reads_back_exactly_and_has_its_suffix(scalar: str) -> None:
    text = controller_of("omni_s2", scalar).files["omni_s2.c"].decode()
    code = re.sub(r"/\*.*?\*/|\"[^\"]*\"", "", text, flags=re.DOTALL)
    literals = re.findall(r"(?<![\w.])\d+\.\d*(?:e-?\d+)?F?", code)
    assert len(literals) > 140
    assert all(v.endswith("F") == (scalar == "float") for v in literals)
    design = controller_of("omni_s2", scalar).design
    table = re.search(r"_coefficients\[140\] = \{(.*?)\};", text, re.DOTALL)
    values = [float(v.strip().rstrip("F")) for v in table.group(1).split(",")]
    rounded = [float(np.float32(v)) if scalar == "float" else v for v in values]
    assert rounded == [v * float(design.unit) for row in design.table for pair in row for v in pair]


def test_files_are_utf8_with_unix_line_ends_and_name_no_date_version_or_path() -> None:
    from stt_codegen import __version__

    for name in NAMES:
        for data in controller_of(name).files.values():
            text = data.decode()
            assert "\r" not in text
            assert text.endswith("\n")
            assert not text.endswith("\n\n")
            assert str(ROOT) not in text
            assert f"stt_codegen {__version__}" not in text
            assert not re.search(r"20\d\d-\d\d-\d\d", text)
            assert max(len(line) for line in text.splitlines() if not line.lstrip().startswith(('"', "{"))) <= 130


def test_generated_python_needs_only_math_and_runs_without_this_package(tmp_path) -> None:
    controller = controller_of("omni_s2")
    (tmp_path / "omni_s2.py").write_bytes(controller.files["omni_s2.py"])
    code = (
        "import sys, omni_s2\n"
        "assert omni_s2.control(0.0, [0.25, 0.25])[0] == omni_s2.OK\n"
        "assert not [m for m in ('numpy', 'casadi', 'stt_codegen') if m in sys.modules]\n"
    )
    subprocess.run([sys.executable, "-I", "-S", "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n{code}"], check=True)
    assert re.findall(rb"^(?:import|from) .*$", controller.files["omni_s2.py"], re.M) == [b"import math"]


def test_names_that_collide_are_refused() -> None:
    program = controller_of("omni_s2").program
    x = Var("x", program.kernels[0].inputs[0].type)
    for kernel in (
        Kernel("tube", (x,), (), (x,), ("y",)),
        Kernel("negation", (x,), (Assign(x, Op("neg", (x,))),), (x,), ("y",)),
        Kernel("identity", (Var("double", x.type),), (), (x,), ("y",)),
        Kernel("gamma", (x,), (), (x,), ("y",)),
    ):
        with pytest.raises(ValueError, match="is used twice|is a reserved word of C|is a name of the library of C"):
            check_names(
                Program(program.prefix, 2, "float", program.tables, (*program.kernels, kernel), functions=program.functions)
            )
    check_names(program)


def prefixes_of_locals(program: Program) -> list[str]:
    """Return every prefix before an underscore that a name of a local has."""
    return sorted({name[: match.start()] for name in _locals(program) for match in re.finditer("_", name) if match.start()})


@pytest.mark.parametrize(("name", "scalar"), [("crane", "fixed"), ("drone", "float"), ("omni_s1", "adaptive")])
def test_a_task_with_the_name_of_a_local_compiles(name: str, scalar: str, tool, tmp_path: Path) -> None:
    """No local is <name>_<function or table>, which would hide a name of the task called <name> (tests/emit/test_local_names.py)."""
    controller = controller_of(name, "float", "adaptive") if scalar == "adaptive" else controller_of(name, scalar)
    task, program, sources = controller.task, controller.program, []
    for prefix in prefixes_of_locals(program):
        renamed = task.model_copy(update={"name": prefix}), controller.design, replace(program, prefix=prefix)
        files = render(*renamed, controller.certificate)
        for file in (f"{prefix}.c", f"{prefix}.h"):
            (tmp_path / file).write_bytes(files[file])
        sources.append(str(tmp_path / f"{prefix}.c"))
    subprocess.run([tool("gcc"), *STRICT, "-fsyntax-only", *sources], check=True)
    assert len(sources) > 10


# -------------------------------------------------------------------------------------------- the behaviour


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_control_returns_bad_input_and_zero_for_any_non_finite_number(backends, bad: float) -> None:
    for backend in backends:
        for t, x in (
            arguments_at(bad, 0.25, 0.25),
            arguments_at(1.0, bad, 0.25),
            arguments_at(1.0, 0.25, bad),
            arguments_at(bad, bad, bad),
        ):
            status, u = backend.control(t, x)
            assert status[0] == BAD
            assert np.all(u == 0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_tube_and_rate_of_a_non_finite_time_are_nan(backends, bad: float) -> None:
    for backend in backends:
        for values in (backend.tube(np.array([bad])), backend.tube_rate(np.array([bad]))):
            assert np.all(np.isnan(np.stack(values)))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_transform_is_nan_only_in_components_that_are_not_finite(backends, bad: float) -> None:
    for backend in backends:
        for k in range(3):
            arrays = [np.array([[1.0, 1.0]]), np.array([[2.0, 2.0]]), np.array([[1.5, 1.25]])]
            arrays[k] = np.array([[arrays[k][0, 0], bad]])
            e, epsilon, xi = backend.transform(*arrays)
            for v in (e, epsilon, xi):
                assert np.isfinite(v[0, 0])
                assert np.isnan(v[0, 1])


def test_transform_is_zero_in_an_empty_box(backends) -> None:
    for backend in backends:
        for low, high in ((1.0, 1.0), (2.0, 1.0)):
            results = backend.transform(np.array([[low, low]]), np.array([[high, high]]), np.array([[1.0, 5.0]]))
            assert np.all(np.stack(results) == 0)


def test_before_0_and_after_t_c_the_tube_is_constant(backends) -> None:
    for backend in backends:
        first, last = (np.stack(backend.tube(np.array([t]))) for t in (0.0, 9.0))
        for t in (-1e-30, -1.0, -1e30, -0.0):
            assert np.array_equal(np.stack(backend.tube(np.array([t]))), first)
        for t in (9.000001, 18.0, 1e30):
            assert np.array_equal(np.stack(backend.tube(np.array([t]))), last)
            assert np.all(np.stack(backend.tube_rate(np.array([t]))) == 0)
        assert np.all(np.stack(backend.tube_rate(np.array([9.0]))) == 0)
        assert np.array_equal(np.stack(backend.tube_rate(np.array([-3.0]))), np.stack(backend.tube_rate(np.array([0.0]))))


def test_status_is_decided_by_the_numbers_that_tube_returns(backends) -> None:
    """Strictly inside is OK; an edge itself, and anything beyond, is OUTSIDE_TUBE."""
    for backend in backends:
        number = np.float32 if backend.scalar == "float" else np.float64
        for t in np.linspace(-1, 11, 49):
            time = np.array([t], dtype=number)
            low, high = (v[0] for v in backend.tube(time))
            middle = (low + high) / 2
            assert backend.control(time, middle[None])[0][0] == OK
            for i in range(2):
                for edge, beyond in ((low[i], -np.inf), (high[i], np.inf)):
                    for value, expected in (
                        (edge, OUTSIDE),
                        (np.nextafter(number(edge), number(beyond)), OUTSIDE),
                        (np.nextafter(number(edge), number(-beyond)), OK),
                    ):
                        x = middle.copy()
                        x[i] = value
                        assert backend.control(time, x[None])[0][0] == expected


def test_outside_the_tube_u_points_inward_and_is_the_clamped_law(backends) -> None:
    e_max, k = 0.99, 0.5
    for backend in backends:
        low, high = (v[0].astype(float) for v in backend.tube(np.array([4.0])))
        width = high - low
        bound = 4 * k / (width * (1 - e_max**2)) * math.log((1 + e_max) / (1 - e_max))
        for distance in (1e-3, 1.0, 1e30):
            status, u = backend.control(*arguments_at(4.0, low[0] - distance, high[1] + distance))
            assert status[0] == OUTSIDE
            assert u[0, 0] > 0 > u[0, 1]
            tolerance = 1e-4 if backend.scalar == "float" else 1e-12  # width is rounded; the clamp is steep in it
            assert np.allclose(np.abs(u[0]), bound, rtol=tolerance)


def test_a_negative_gain_changes_the_sign_of_u() -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    positive = build_once(parse_task(text))
    negative = build_once(parse_task(text.replace("gain = 0.5", "gain = -0.5")))
    points = np.linspace(0, 9, 40), np.random.default_rng(0).uniform(0, 5, (40, 2))
    a = CompiledC(positive).control(*points)
    b = CompiledC(negative).control(*points)
    assert np.array_equal(a[0], b[0])
    assert np.array_equal(a[1], -b[1])


def test_u_max_saturates_u_and_changes_no_smaller_u() -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    unlimited = build_once(parse_task(text))
    limited = build_once(parse_task(text.replace("gain = 0.5", "gain = 0.5\nu_max = [1.5, 0.75]")))
    points = np.linspace(-1, 10, 200), np.random.default_rng(1).uniform(-1, 6, (200, 2))
    for kind in (lambda c: CompiledC(c), lambda c: GeneratedPython(c)):
        a, b = kind(unlimited).control(*points), kind(limited).control(*points)
        assert np.array_equal(a[0], b[0])
        assert np.array_equal(b[1], np.clip(a[1], [-1.5, -0.75], [1.5, 0.75]).astype(b[1].dtype))
        assert np.any(a[1] != b[1])


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_u_may_be_the_array_x_itself(scalar: str) -> None:
    controller = controller_of("spacecraft", scalar)
    backend = CompiledC(controller)
    real = ctypes.c_float if scalar == "float" else ctypes.c_double
    control = backend.library.spacecraft_control
    control.argtypes = [real, ctypes.c_void_p, ctypes.c_void_p]
    random = np.random.default_rng(2)
    for _ in range(50):
        t, x = float(random.uniform(0, 15)), random.uniform(0, 3.2, 3).astype(backend.number)
        separate, shared = np.zeros(3, dtype=backend.number), x.copy()
        first = control(t, x.ctypes.data, separate.ctypes.data)
        assert control(t, shared.ctypes.data, shared.ctypes.data) == first
        assert np.array_equal(separate, shared)


@pytest.mark.parametrize("aliased", ["lower", "upper", "x"])
def test_an_output_of_transform_may_be_an_input(aliased: str, c_float) -> None:
    low, high, x = (np.array(v, dtype=np.float32) for v in ([0.0, 1.0], [2.0, 4.0], [0.5, 3.5]))
    expected = [np.zeros(2, dtype=np.float32) for _ in range(3)]
    call = c_float.library.omni_s2_transform
    call.argtypes = [ctypes.c_void_p] * 6
    call(*(a.ctypes.data for a in (low, high, x, *expected)))
    for k in range(3):
        inputs = {"lower": low.copy(), "upper": high.copy(), "x": x.copy()}
        outputs = [np.zeros(2, dtype=np.float32) for _ in range(3)]
        outputs[k] = inputs[aliased]
        call(*(a.ctypes.data for a in (*inputs.values(), *outputs)))
        for output, separate_output in zip(outputs, expected, strict=True):
            assert np.array_equal(output, separate_output)


@settings(max_examples=400, deadline=None)
@given(st.lists(BITS, min_size=3, max_size=3))
def test_u_is_finite_for_every_bit_pattern(numbers: list[float]) -> None:
    controller = controller_of("omni_s2", "float")
    backend = compiled_once(controller)
    t, *x = numbers
    status, u = backend.control(np.array([t], dtype=np.float32), np.array([x], dtype=np.float32))
    assert np.all(np.isfinite(u))
    assert (status[0] == BAD) == (not all(map(math.isfinite, numbers)))


COMPILED: dict[int, CompiledC] = {}


def compiled_once(controller: EmittedController) -> CompiledC:
    if id(controller) not in COMPILED:
        COMPILED[id(controller)] = CompiledC(controller)
    return COMPILED[id(controller)]


@settings(max_examples=300, deadline=None)
@given(st.lists(BITS, min_size=3, max_size=3), st.sampled_from([1.0, 1e-12, 1e-30]))
def test_transform_is_clamped_and_never_fails_for_any_numbers(numbers: list[float], scale: float) -> None:
    """C and Python, which must not raise, agree that |e| <= e_max."""
    low, high, x = (v * scale if math.isfinite(v) else v for v in numbers)
    controller = controller_of("omni_s2", "float")
    python = GeneratedPython(controller)
    arrays = [np.array([[v, 0.0]], dtype=np.float32) for v in (low, high, x)]
    for backend in (python, compiled_once(controller)):
        e, epsilon, xi = (v[0, 0] for v in backend.transform(*arrays))
        if math.isnan(e):
            assert math.isnan(epsilon)
            assert math.isnan(xi)
            continue
        assert abs(e) <= np.float32(0.99)
        assert math.isfinite(epsilon)
        assert math.isfinite(xi)
        assert xi >= 0


def test_python_refuses_a_vector_of_the_wrong_length() -> None:
    module = GeneratedPython(controller_of("omni_s2")).module
    with pytest.raises(ValueError, match="x has 3 entries, 2 are needed"):
        module.control(0.0, [1.0, 2.0, 3.0])


@pytest.mark.parametrize("width", ["crossed", "0", "2^-19"])
@pytest.mark.parametrize("scalar", ["float", "double"])
def test_a_tube_by_whose_width_the_law_cannot_divide_is_not_written(scalar: str, width: str) -> None:
    """Its edges cross, meet or come very close somewhere. Also --uncertified does not write it: u would be outward, or a NaN."""
    controller = controller_of("empty")
    table = [[list(pair) for pair in row] for row in controller.design.table]
    for row in table[12:20]:
        for pair in row:
            middle, gap = sum(pair) // 2, {"crossed": -50, "0": 0, "2^-19": int(2**-19 / 6 / controller.design.unit)}[width]
            pair[:] = [middle, middle + gap]
    narrow = replace(controller.design, table=tuple(tuple((a, b) for a, b in row) for row in table))
    with pytest.raises(NotCertified, match=r"width \(P1\).*narrower than 2\^-18 is not written"):
        build_task(controller.task.with_options(scalar=scalar), uncertified=True, tube=narrow)


def test_a_tube_below_the_minimum_width_gives_finite_inward_u(backends) -> None:
    width = float(MINIMUM_WIDTH) / 1000
    for backend in backends:
        e, epsilon, xi = backend.transform(np.zeros((1, 2)), np.full((1, 2), width), np.array([[-1.0, 1.0]]))
        assert np.all(np.isfinite(np.stack([e, epsilon, xi])))
        assert epsilon[0, 0] < 0 < epsilon[0, 1]


def test_a_gain_or_clamp_that_would_overflow_is_refused() -> None:

    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    for control in ("gain = 1e9\ne_max = 0.999999999999999999999999999999", "gain = 0.5\ne_max = 0.999999999999999"):
        task = parse_task(text.replace("gain = 0.5", control))
        with pytest.raises(BadInput, match="control"):
            build_program(task, controller_of("omni_s2").design)


def test_the_design_hash_differs_for_every_design_and_option() -> None:
    def design_hash(controller: EmittedController) -> str:
        return re.search(r'DESIGN_HASH "(\w+)"', controller.files[f"{controller.task.name}.h"].decode()).group(1)

    hashes = {design_hash(controller_of(name, scalar)) for name in NAMES for scalar in ("float", "double")}
    assert len(hashes) == 2 * len(NAMES)
    assert all(len(n) == 16 for n in hashes)
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    gain = build_once(parse_task(text.replace("gain = 0.5", "gain = 0.25")))
    assert design_hash(gain) != design_hash(controller_of("omni_s2"))


def test_the_certificate_has_digests_of_task_and_files_and_margins_in_units() -> None:
    import hashlib
    import json

    controller = controller_of("omni_s2")
    document = json.loads(controller.files["omni_s2.certificate.json"])
    assert document["sha256"]["task_data"] == controller.task.digest
    for name in ("omni_s2.h", "omni_s2.c", "omni_s2.py"):
        assert document["sha256"][name] == hashlib.sha256(controller.files[name]).hexdigest()
    assert document["format"] == 3
    unit, error = controller.design.unit, max(document["edge_error"])
    margins = {c: min(f.margin for f in controller.certificate.findings if f.code == c) for c in ("P1", "P2", "P3", "P4", "P5")}
    assert min(c["margin"] for c in document["claims"] if c["property"] == "P4") * unit <= margins["P4"]
    for claim in document["claims"]:
        if "margin" in claim:
            code = claim["property"]
            assert claim["margin"] * unit >= margins[code] - unit  # rounded down to whole units
            if code != "P4":  # a finding has the smallest margin of all sets
                assert claim["margin"] * unit <= margins[code]
            assert claim["margin"] >= (2 * error if code == "P1" else error)


def test_a_clamp_too_near_zero_or_one_for_the_scalar_is_refused() -> None:

    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    for e_max in ("0.00000002", "0.99999998"):
        task = parse_task(text.replace("gain = 0.5", f"gain = 0.5\ne_max = {e_max}"))
        with pytest.raises(BadInput, match=r"control.e_max: .* too near"):
            build_program(task, controller_of("omni_s2").design)
        assert build_program(task.with_options(scalar="double"), controller_of("omni_s2").design)


def test_the_emitted_u_never_exceeds_u_max_although_0_1_is_no_float() -> None:
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    limited = build_once(parse_task(text.replace("gain = 0.5", "gain = 0.5\nu_max = [0.1, 0.7]")))
    _, u = CompiledC(limited).control(np.linspace(0, 9, 50), np.random.default_rng(1).uniform(-1, 6, (50, 2)))
    for k, bound in enumerate((Fraction("0.1"), Fraction("0.7"))):
        largest = Fraction(float(np.abs(u[:, k]).max()))
        assert bound * (1 - Fraction(1, 2**22)) < largest <= bound


def test_the_margin_is_half_in_the_middle_positive_inside_and_negative_outside(backends) -> None:
    for backend in backends:
        number = np.float32 if backend.scalar == "float" else np.float64
        t = np.linspace(-1, 11, 60).astype(number)
        low, high = backend.tube(t)
        for e, sign in ((0.0, 1), (0.5, 1), (-0.99, 1), (1.01, -1), (-1.5, -1), (1e6, -1), (-1e30, -1)):
            x = ((low.astype(float) + high) / 2 + (high.astype(float) - low) / 2 * e).astype(number)
            margin = backend.margin(t, x)
            assert (np.sign(margin) == sign).all()
            assert (margin >= -1).all()
            # by definition (1 - |e|) / 2; the edges are rounded by 4 eps of their size, the width is at least 0.05
            assert np.abs(margin - max((1 - abs(e)) / 2, -1)).max() < 1e-3 * (number is np.float32) + 1e-9 or abs(e) > 100
        status, _ = backend.control(t, (low + high) / 2)
        assert (status == OK).all()


def test_the_margin_is_positive_exactly_where_the_status_is_ok(backends) -> None:
    random = np.random.default_rng(9)
    for backend in backends:
        number = np.float32 if backend.scalar == "float" else np.float64
        t = random.uniform(0, 9, 400).astype(number)
        low, high = backend.tube(t)
        side = random.choice([0, 1, 2], low.shape)  # at the lower edge, at the upper one, or just inside
        x = np.where(side == 0, low, np.where(side == 1, high, np.nextafter(low, high))).astype(number)
        status, _ = backend.control(t, x)
        margin = backend.margin(t, x)
        assert np.array_equal(margin > 0, status == OK)
        assert (margin[status != OK] <= 0).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_the_margin_of_a_non_finite_number_is_nan(backends, bad: float) -> None:
    for backend in backends:
        assert np.isnan(backend.margin(np.array([bad]), np.array([[1.0, 1.0]])))[0]
        assert np.isnan(backend.margin(np.array([1.0]), np.array([[1.0, bad]])))[0]


def test_transform_of_any_empty_tube_is_zero_without_an_error(backends) -> None:
    """Edges cross by little, by much, or by more than the precision of a number: the values are 0, and Python raises nothing."""
    random = np.random.default_rng(11)
    lower = random.choice([0.0, 1.0, 8589934592.0, 1e30, -9.5e-6], (2000, 2))
    upper = lower - random.choice([0.0, 5e-324, 9.5e-6, 1.0, 17.0, 1e9, 1e30], lower.shape)
    x = np.where(
        random.random(lower.shape) < 0.5, (lower + upper) / 2, random.choice([-1e30, 0.0, 1e9, 4294967296.0], lower.shape)
    )
    for backend in backends:
        empty = (
            np.asarray(upper, backend.number) <= np.asarray(lower, backend.number)
            if hasattr(backend, "number")
            else upper <= lower
        )
        for values in backend.transform(lower, upper, x):
            assert (np.asarray(values)[empty] == 0).all()
