"""The emitted C under the flags of real cores: no product and sum become one fused operation, and flags that would change results are
refused where the compiler tells of them.

Compilers of -std=gnu.. contract a * b + c where the processor has an instruction for it, unless a pragma of the file forbids it. Which
flags nothing can stop is said in docs/c.md.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from benchmarks.compilers.builds import FUSED
from stt_codegen.pipeline import EmittedController
from tests.support.controllers import ROOT, build_once, controller_of
from tests.support.listings.tasks import TASKS_OF_FILES, build
from tests.support.missing_tools import skip_without

STM32 = "-Os -mthumb -mfloat-abi=hard -ffunction-sections -fdata-sections --param max-inline-insns-single=500"
HEADERS = {  # for a compiler without a C library: what the files need to know of it
    "math.h": '#define NAN __builtin_nanf("")\n#define isfinite(v) __builtin_isfinite(v)\nfloat logf(float v); double log(double v);\n',
    "string.h": "void *memcpy(void *to, const void *from, __SIZE_TYPE__ size);\n",
}


@dataclass(frozen=True)
class Core:
    """A core's compiler and flags. contracts: whether it would fuse without the pragma; needs_headers: whether it has no C library;
    has_doubles: whether its double has 53 bits, without which a controller in double is refused."""

    name: str
    command: str
    contracts: bool = True
    needs_headers: bool = False
    has_doubles: bool = True


CORES = [
    Core(
        "Arduino AVR",
        "avr-gcc -mmcu=atmega328p -Os -std=gnu11 -ffunction-sections -fdata-sections",
        contracts=False,
        has_doubles=False,
    ),
    Core("STM32 F4", f"arm-none-eabi-gcc -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 {STM32} -std=gnu17"),
    Core("STM32 F7, H7", f"arm-none-eabi-gcc -mcpu=cortex-m7 -mfpu=fpv5-d16 {STM32} -std=gnu17"),
    Core("Cortex-M55, with half precision", "arm-none-eabi-gcc -mcpu=cortex-m55 -mthumb -mfloat-abi=hard -O2 -std=gnu17"),
    Core("Teensy 4", "arm-none-eabi-gcc -mcpu=cortex-m7 -mfpu=fpv5-d16 -mthumb -mfloat-abi=hard -O2 -std=gnu11"),
    Core("Arduino SAMD51", "arm-none-eabi-gcc -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mthumb -mfloat-abi=hard -O3 -std=gnu11"),
    Core("PlatformIO, its default", f"arm-none-eabi-gcc -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 {STM32}"),
    Core("ESP32-C3", "riscv64-unknown-elf-gcc -march=rv32imc -mabi=ilp32 --specs=picolibc.specs -Os -std=gnu17", contracts=False),
    Core("ESP32-P4, rv32imfc", "riscv64-unknown-elf-gcc -march=rv32imfc -mabi=ilp32f --specs=picolibc.specs -Os -std=gnu17"),
    Core("ESP32", "xtensa-esp32-elf-gcc -Os -std=gnu17"),
    Core("x86 with FMA", "gcc -O2 -mfma -std=gnu17"),
    Core("x86 of this decade", "gcc -O3 -march=haswell -std=gnu17"),
    Core("x86 with half precision", "gcc -O2 -march=sapphirerapids -std=gnu17"),
    Core("x86 with FMA, clang", "clang -O2 -mfma -std=gnu17", contracts=False),  # it fuses within an expression alone
    Core(
        "ARM, clang",
        "clang --target=thumbv7em-none-eabihf -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -Os",
        contracts=False,
        needs_headers=True,
    ),
    Core("64 bit ARM, clang", "clang --target=aarch64-none-elf -O2", contracts=False, needs_headers=True),
]


def controllers() -> dict[str, EmittedController]:
    """Order 1 and 2, float and double, ticks, inline logarithms, and axes that close."""
    omni = controller_of("omni_s2")
    return {
        "omni_s2": omni,
        "omni_s2, double": controller_of("omni_s2", "double"),
        "drone": controller_of("drone"),
        "trolley, inline": build_once(controller_of("trolley").task.changed(emit={"math": "inline", "tick_period": "0.01"})),
        "closed axes": build(TASKS_OF_FILES["closed axes"]),
        "adaptive": controller_of("omni_s2", design="adaptive"),
    }


def assembly(core: Core, source: Path, tool: Callable[[str], str], *flags: str) -> str:
    """Compile a file under a core's flags, and return the assembly text. A compiler that is missing is a visible skip."""
    compiler, *core_flags = core.command.split()
    if compiler == "xtensa-esp32-elf-gcc":
        _require_esp32(compiler)
    if core.needs_headers:
        for name, text in HEADERS.items():
            (source.parent / name).write_text(text)
        core_flags.append("-I.")
    command = [tool(compiler), *core_flags, *flags, "-w", "-S", "-o", "-", source.name]
    return subprocess.run(command, cwd=source.parent, check=True, capture_output=True, text=True).stdout


def _require_esp32(compiler: str) -> None:
    """Skip without Espressif's compiler, in CI too: no system package has it."""
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed; it comes with Espressif's tools")


def write(folder: Path, controller: EmittedController) -> list[Path]:
    """Write all files, and return the paths of the C."""
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    return [folder / name for name in controller.files if name.endswith(".c")]


@pytest.mark.parametrize("core", CORES, ids=lambda core: core.name)
def test_no_core_fuses_a_product_and_a_sum(core: Core, tool, tmp_path: Path) -> None:
    """Every C file of each controller. Without its pragmas the same C has fused operations, where the core's compiler makes them."""
    for label, controller in controllers().items():
        folder = tmp_path / label.replace(", ", "_").replace(" ", "_")
        folder.mkdir()
        sources = write(folder, controller)
        assert len(sources) >= (2 if label == "closed axes" else 1)
        if "double" in label and not core.has_doubles:
            with pytest.raises(subprocess.CalledProcessError) as refusal:
                assembly(core, sources[0], tool)
            assert "double is not IEEE-754's here" in refusal.value.stderr
            continue
        counts = {source.name: len(FUSED.findall(assembly(core, source, tool))) for source in sources}
        assert counts == dict.fromkeys(counts, 0), label
        if core.contracts and label in ("omni_s2", "closed axes"):
            for source in sources:
                source.write_text(re.sub(r"^#pragma .*\n", "", source.read_text(), flags=re.MULTILINE))
                text = assembly(core, source, tool)
                assert FUSED.search(text) or source.name.endswith("_selftest.c"), (label, source.name)


def test_link_time_optimization_keeps_products_and_sums_apart(tool, tmp_path: Path) -> None:
    """A pragma is of its file, also where all files are optimized together."""
    (source,) = write(tmp_path, controller_of("omni_s2"))
    flags = "-mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mthumb -mfloat-abi=hard -Os -std=gnu17 -flto".split()
    compiler = tool("arm-none-eabi-gcc")
    subprocess.run([compiler, *flags, "-c", source.name, "-o", "a.o"], cwd=tmp_path, check=True)
    linked = ["-nostdlib", "-r", "-flinker-output=nolto-rel", "a.o", "-o", "b.o"]
    subprocess.run([compiler, *flags, *linked], cwd=tmp_path, check=True)
    dump = [tool("arm-none-eabi-objdump"), "-d", "--no-show-raw-insn", "b.o"]
    text = subprocess.run(dump, cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert "vmul.f32" in text
    assert not re.search(r"\bvfn?m[as]", text)


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("\tvfma.f32\ts15, s14, s13\n\tvfms.f32\ts1, s2, s3\n\tvfnma.f64\td1, d2, d3\n", 3),
        ("\tvfmadd231ss\t%xmm0, %xmm1, %xmm2\n\tvfnmsub132sd\t%xmm0, %xmm1, %xmm2\n\tvfmadd213ps\t%ymm0, %ymm1, %ymm2\n", 3),
        ("\tfmadd.s\tfa5,fa4,fa3,fa2\n\tfnmsub.d\tfa5,fa4,fa3,fa2\n\tfmadd\ts0, s1, s2, s3\n\tfmla\tv0.4s, v1.4s, v2.4s\n", 4),
        ("\tcall\tfmaf\n", 1),
        ("\tmaebr\t%f0,%f2,%f4\n\tmsdb\t%f0,%f2,0(%r1)\n\twfmasb\t%f0,%f2,%f4,%f6\n\tvfnmsdb\t%v0,%v2,%v4,%v6\n", 4),
        ("\tfmadds\tf0,f1,f2,f3\n\tfnmsub\tf0,f1,f2,f3\n\tmadd.s\t$f0,$f2,$f4,$f6\n\tnmsub.d\t$f0,$f2,$f4,$f6\n", 4),
        ("  4c:\tvfma.f32\ts15, s14, s13\n\t\t\t60: R_ARM_THM_CALL\tfmaf\n", 2),
        ("\tvfmsb\t%v0,%v2,%v4\n\tmeebr\t%f0,%f2\n\tmadd\tx0, x1, x2, x3\n\tmdebr\t%f0,%f2\n", 0),
        ("\tvmla.f32\ts15, s14, s13\n\tvmul.f32\ts1, s2, s3\n\tvadd.f32\ts1, s2, s3\n\tmulss\t%xmm0, %xmm1\n", 0),
    ],
)
def test_fused_operations_are_counted(text: str, count: int) -> None:
    assert len(FUSED.findall(text)) == count


# ------------------------------------------------------------------------------------------------ flags that are refused

NAN_TESTS = "compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
BOUNDED = "compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
REFUSED_BY_GCC = {
    "-ffast-math": NAN_TESTS,
    "-Ofast": NAN_TESTS,
    "-ffinite-math-only": NAN_TESTS,
    "-funsafe-math-optimizations": BOUNDED,
    "-fassociative-math -fno-signed-zeros -fno-trapping-math": BOUNDED,  # alone it is without effect, as gcc warns
    "-freciprocal-math": BOUNDED,
}
NO_MACRO_BEFORE_GCC_10 = (
    "-funsafe-math-optimizations",
    "-fassociative-math -fno-signed-zeros -fno-trapping-math",
    "-freciprocal-math",
)


def compile_with(command: list[str], source: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*command, "-c", source.name, "-o", "a.o"], cwd=source.parent, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("flags", REFUSED_BY_GCC)
@pytest.mark.parametrize(
    "compiler",
    [
        "gcc",
        "arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16",
        "riscv64-unknown-elf-gcc -march=rv32imfc -mabi=ilp32f --specs=picolibc.specs",
        "avr-gcc -mmcu=atmega328p",
    ],
    ids=lambda command: command.split()[0],
)
def test_gcc_refuses_flags_that_change_results(compiler: str, flags: str, tool, tmp_path: Path) -> None:
    """With the words of the file's #error. A gcc before 10 has no macros for some of them (docs/c.md)."""
    name, *options = compiler.split()
    (source,) = write(tmp_path, controller_of("omni_s2"))
    command = [tool(name), *options, "-O2"]
    version = int(subprocess.run([command[0], "-dumpversion"], check=True, capture_output=True, text=True).stdout.split(".")[0])
    assert compile_with(command, source).returncode == 0
    result = compile_with([*command, *flags.split()], source)
    if version < 10 and flags in NO_MACRO_BEFORE_GCC_10:
        assert "avr-gcc 5.4" in (ROOT / "docs" / "c.md").read_text()
        assert result.returncode == 0
    else:
        assert result.returncode != 0
        assert f'#error "omni_s2.c: {REFUSED_BY_GCC[flags]}"' in result.stderr


@pytest.mark.parametrize("flag", ["-ffast-math", "-Ofast", "-ffinite-math-only"])
def test_clang_refuses_what_it_has_macros_for(flag: str, tool, tmp_path: Path) -> None:
    (source,) = write(tmp_path, controller_of("omni_s2"))
    result = compile_with([tool("clang"), flag], source)
    assert result.returncode != 0
    assert NAN_TESTS in result.stderr


def test_clang_does_not_reassociate_where_a_flag_would_let_it(tool, tmp_path: Path) -> None:
    """Its pragma holds against the flag: the instructions of every function are those without it."""
    (source,) = write(tmp_path, controller_of("omni_s2"))
    core = Core("", "clang -O2 -std=c99")
    flags = ("-fassociative-math", "-fno-signed-zeros", "-fno-trapping-math")
    without_flags, with_flags = (re.sub(r"#.*|\.\w+.*", "", assembly(core, source, tool, *f)) for f in ((), flags))
    assert operations(without_flags) == operations(with_flags)


def operations(text: str) -> dict[str, int]:
    """Count the operations on real numbers in an assembly text of x86."""
    names = re.findall(r"^\s+((?:v?(?:add|sub|mul|div)[sp][sd]))\s", text, re.MULTILINE)
    return {name: names.count(name) for name in sorted(set(names))}


def test_what_no_file_can_stop_is_in_the_documents(tool, tmp_path: Path) -> None:
    """clang contracts across statements under -ffp-contract=fast whatever the pragma says, and has no macro for -freciprocal-math."""
    text = (ROOT / "docs" / "c.md").read_text()
    assert "clang ignores its pragma under `-ffp-contract=fast`" in text
    assert "clang 14 and avr-gcc 5.4 do not" in text
    (source,) = write(tmp_path, controller_of("omni_s2"))
    clang = tool("clang")
    version = subprocess.run([clang, "--version"], check=True, capture_output=True, text=True).stdout
    if " 14." not in version:
        skip_without(f"the documents are about clang 14, this is {version.splitlines()[0]}")
    assert FUSED.search(assembly(Core("", "clang -O2 -mfma"), source, tool, "-ffp-contract=fast"))
    assert compile_with([clang, "-freciprocal-math"], source).returncode == 0
