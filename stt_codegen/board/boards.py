"""The boards that are emulated: compiler, start-up code, emulator, one row each."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Board:
    """A board, its compiler and its emulator."""

    name: str
    title: str
    compiler: str
    flags: tuple[str, ...]
    sources: tuple[str, ...]  # templates beside stt-board.h
    header: str
    libraries: tuple[str, ...]
    command: tuple[str, ...]  # the image is appended
    packages: str
    ticks_per_unit: float  # of the board's counter
    unit: str = "instructions"
    point_bytes: int = 1 << 20  # for the points of one image
    scalars: tuple[str, ...] = ("float", "double")
    missing_functions: tuple[str, ...] = ()  # of its C library
    painted_stack: int = 4096  # bytes that stt-board.h paints, to see how far the stack reaches
    rust_target: str = ""  # Rust's name of a target with the same calling convention


def _arm(name: str, title: str, cpu: str, machine: str, *, rust_target: str, fpu: str = "") -> Board:
    """Return a Cortex-M board that QEMU emulates. fpu: GCC's name of its floating-point unit; machine: QEMU's of the board."""
    float_abi = ("-mfloat-abi=hard", f"-mfpu={fpu}") if fpu else ("-mfloat-abi=soft",)
    return Board(
        name=name,
        title=title,
        compiler="arm-none-eabi-gcc",
        flags=(f"-mcpu={cpu}", "-mthumb", *float_abi),
        sources=("arm.c",),
        header="arm.h",
        libraries=("-nostartfiles", "-T", "arm.ld", "--specs=nosys.specs", "-lm"),
        command=(
            *("qemu-system-arm", "-M", machine, "-nographic", "-monitor", "none", "-serial", "none"),
            *("-semihosting-config", "enable=on,target=native", "-icount", "shift=10,align=off,sleep=off", "-kernel"),
        ),
        packages="gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm",
        ticks_per_unit=25.6,
        rust_target=rust_target,
    )


BOARDS = {
    b.name: b
    for b in (
        _arm("m0", "Cortex-M0 code on a Cortex-M3", "cortex-m0", "mps2-an385", rust_target="thumbv6m-none-eabi"),
        _arm("m3", "Cortex-M3, no FPU", "cortex-m3", "mps2-an385", rust_target="thumbv7m-none-eabi"),
        _arm("m4f", "Cortex-M4F", "cortex-m4", "mps2-an386", rust_target="thumbv7em-none-eabihf", fpu="fpv4-sp-d16"),
        _arm(
            "m7",
            "Cortex-M7, single-precision FPU",
            "cortex-m7",
            "mps2-an500",
            rust_target="thumbv7em-none-eabihf",
            fpu="fpv5-sp-d16",
        ),
        Board(
            name="rv32",
            title="RISC-V RV32IMAC, no FPU",
            compiler="riscv64-unknown-elf-gcc",
            flags=("-march=rv32imac", "-mabi=ilp32"),
            sources=("rv32.c",),
            header="rv32.h",
            libraries=("--specs=picolibc.specs", "-nostartfiles", "-T", "rv32.ld", "-lm"),
            command=(
                "qemu-system-riscv32",
                "-M",
                "virt",
                "-bios",
                "none",
                "-nographic",
                "-monitor",
                "none",
                "-serial",
                "none",
                "-semihosting-config",
                "enable=on,target=native",
                "-icount",
                "shift=0",
                "-kernel",
            ),
            packages="gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf qemu-system-misc",
            ticks_per_unit=1.0,
        ),
        Board(
            name="avr",
            title="ATmega328P, 8 bits",
            compiler="avr-gcc",
            flags=("-mmcu=atmega328p", "-DF_CPU=16000000UL"),
            sources=(),
            header="avr.h",
            libraries=("-lm",),
            command=("simavr", "-m", "atmega328p", "-f", "16000000"),
            packages="gcc-avr avr-libc simavr",
            ticks_per_unit=1.0,
            unit="cycles",
            point_bytes=12_000,
            scalars=("float",),
            missing_functions=("log1pf",),
            painted_stack=300,
        ),
    )
}


def rust_boards() -> list[str]:
    """Return the names of the boards that can run the Rust as well as the C."""
    return [b.name for b in BOARDS.values() if b.rust_target]


def copy_board(board: Board, folder: Path) -> tuple[list[str], list[str]]:
    """Copy start-up code and header (as stt-board.h) to `folder`; return the paths of the sources, and the linker's arguments.

    Their names have a hyphen, so that no task is called so.
    """
    from stt_codegen.program.targets.template_files import template_folder

    templates = template_folder() / "board"
    for name in (*board.sources, *(v for v in board.libraries if v.endswith(".ld"))):
        shutil.copy(templates / name, folder / f"stt-{name}")
    shutil.copy(templates / board.header, folder / "stt-board.h")
    libraries = [str(folder / f"stt-{v}") if v.endswith(".ld") else v for v in board.libraries]
    return [str(folder / f"stt-{name}") for name in board.sources], libraries
