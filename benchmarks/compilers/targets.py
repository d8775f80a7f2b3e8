"""The compilers and processors: flags of each, how an image is linked, and what runs it."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace

from stt_codegen.board.boards import BOARDS, Board

# What board packages compile with: Arduino's AVR and SAMD cores, Zephyr; STM32Cube, ESP-IDF; Teensy; the Pico's SDK; a Makefile.
FLAG_SETS = ("-Os -std=gnu11 -flto", "-Os -std=gnu17", "-O2 -std=gnu11", "-O3 -std=c11", "-O2 -std=c99")


@dataclass(frozen=True, kw_only=True)
class Target:
    """A compiler for a processor.

    flags: of the processor. link: further arguments of the linker. emulator: what an image is appended to; empty where this
    machine runs it. board: start-up code and emulator of a processor without an operating system. packages: Debian's names of
    what it needs. ram: bytes of it, where tables may be too large. has_doubles: whether its double has 53 bits, without which a
    controller in double is refused. newest_standard: in place of gnu17, where the compiler is older. with_c_standard: a flag that
    -std=c.. needs beside it, without which floats are refused.
    """

    name: str
    compiler: str
    packages: str
    flags: tuple[str, ...] = ()
    link: tuple[str, ...] = ("-lm",)
    emulator: tuple[str, ...] = ()
    board: Board | None = None
    ram: int | None = None
    has_doubles: bool = True
    newest_standard: str = "gnu17"
    with_c_standard: str = ""
    disassembler: str = "objdump"

    @property
    def tools(self) -> tuple[str, ...]:
        """Commands that must be installed."""
        command = self.board.command if self.board else self.emulator
        return (self.compiler, self.disassembler, *command[:1])

    @property
    def missing_tools(self) -> list[str]:
        """The commands of `tools` that are not installed."""
        return [tool for tool in self.tools if shutil.which(tool) is None]

    def flag_sets(self) -> list[str]:
        """Return FLAG_SETS in words that this compiler knows."""
        sets = [flags.replace("gnu17", self.newest_standard) for flags in FLAG_SETS]
        return [f"{flags} {self.with_c_standard}".strip() if "-std=c" in flags else flags for flags in sets]


def _linux(name: str, triple: str, debian: str, emulator: str, flags: tuple[str, ...] = ()) -> Target:
    """Return a processor whose Linux programs QEMU runs. triple: prefix of the tools; debian: its name in Debian's packages."""
    return Target(
        name=name,
        compiler=f"{triple}-gcc",
        packages=f"gcc-{triple} libc6-dev-{debian}-cross qemu-user",
        flags=flags,
        link=("-static", "-lm"),
        emulator=(emulator,),
        disassembler=f"{triple}-objdump",
    )


def _on_board(name: str, board: Board, **changes: object) -> Target:
    """Return a processor without an operating system, on an emulated board. changes: of the target's fields."""
    prefix = board.compiler.removesuffix("gcc")
    target = Target(
        name=name,
        compiler=board.compiler,
        packages=board.packages,
        flags=board.flags,
        link=board.libraries,
        board=board,
        disassembler=f"{prefix}objdump",
    )
    return replace(target, **changes)  # type: ignore[arg-type]


def _by_clang(target: Target, *flags: str) -> Target:
    """Return the processor with clang in place of gcc; gcc's C library and disassembler stay."""
    changed_flags = (*flags, *target.flags)
    return replace(target, compiler="clang", packages=f"clang {target.packages}", flags=changed_flags)


M0_PLUS = replace(BOARDS["m0"], flags=("-mcpu=cortex-m0plus", "-mthumb", "-mfloat-abi=soft"))
M7_DOUBLE = replace(BOARDS["m7"], flags=("-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16"))
RV32_FLOAT = replace(BOARDS["rv32"], flags=("-march=rv32imafc", "-mabi=ilp32f"))
MEGA = replace(
    BOARDS["avr"],
    flags=("-mmcu=atmega2560", "-DF_CPU=16000000UL"),
    command=tuple(part.replace("atmega328p", "atmega2560") for part in BOARDS["avr"].command),
)
X86 = Target(name="x86-64", compiler="gcc", packages="gcc libc6-dev binutils")
X86_FMA = replace(  # emulated, because this machine's processor may have no FMA
    X86, name="x86-64 with FMA", packages=f"{X86.packages} qemu-user", flags=("-march=haswell",), link=("-static", "-lm"),
    emulator=("qemu-x86_64", "-cpu", "max"),
)  # fmt: skip
S390X = _linux("s390x, big-endian", "s390x-linux-gnu", "s390x", "qemu-s390x", ("-march=z13",))
AARCH64 = _linux("AArch64", "aarch64-linux-gnu", "arm64", "qemu-aarch64")

# gcc makes madd.s of products and sums whatever a pragma says. It rounds twice under QEMU; not every processor need do so.
MIPS_FLAGS = ("-mno-madd4",)

TARGETS = (
    X86,
    X86_FMA,
    _by_clang(X86),
    _by_clang(X86_FMA),
    AARCH64,
    _by_clang(AARCH64, "--target=aarch64-linux-gnu"),
    _linux("RV64GC", "riscv64-linux-gnu", "riscv64", "qemu-riscv64"),
    replace(S390X, with_c_standard="-fexcess-precision=fast"),  # its gcc calculates floats in double otherwise
    _by_clang(S390X, "--target=s390x-linux-gnu"),
    _linux("PowerPC, big-endian", "powerpc-linux-gnu", "powerpc", "qemu-ppc"),
    _linux("MIPS32r2, big-endian", "mips-linux-gnu", "mips", "qemu-mips", MIPS_FLAGS),
    _on_board("Cortex-M0+", M0_PLUS),
    _on_board("Cortex-M4F", BOARDS["m4f"]),
    _on_board("Cortex-M7, FPU for doubles", M7_DOUBLE),
    _on_board("RV32IMAC", BOARDS["rv32"]),
    _on_board("RV32IMAFC", RV32_FLOAT),
    _on_board("ATmega328P", BOARDS["avr"], ram=2048, has_doubles=False, newest_standard="gnu11"),
    _on_board("ATmega2560", MEGA, ram=8192, has_doubles=False, newest_standard="gnu11"),
)
