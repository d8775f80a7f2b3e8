"""The boards that are emulated: compiler, start-up code, emulator, one row each."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Board:
    """A board and how it is emulated. `ticks`: of its counter for one `unit`; room: bytes for points in one image;
    lacks: what its C library does not have."""

    name: str
    title: str
    compiler: str
    flags: tuple[str, ...]
    sources: tuple[str, ...]  # templates beside board.h
    header: str
    libraries: tuple[str, ...]
    command: tuple[str, ...]  # the image is appended
    packages: str
    ticks: float
    unit: str = "instructions"
    room: int = 1 << 20
    scalars: tuple[str, ...] = ("float", "double")
    lacks: tuple[str, ...] = ()
    paint: int = 4096  # bytes of stack that board.h paints
    rust: str = ""  # Rust's name of such a target, with the same calling convention


def _arm(name: str, title: str, cpu: str, machine: str, rust: str, fpu: str = "") -> Board:
    hard = ("-mfloat-abi=hard", f"-mfpu={fpu}") if fpu else ("-mfloat-abi=soft",)
    return Board(
        name=name,
        title=title,
        compiler="arm-none-eabi-gcc",
        flags=(f"-mcpu={cpu}", "-mthumb", *hard),
        sources=("arm.c",),
        header="arm.h",
        libraries=("-nostartfiles", "-T", "arm.ld", "--specs=nosys.specs", "-lm"),
        command=(
            *("qemu-system-arm", "-M", machine, "-nographic", "-monitor", "none", "-serial", "none"),
            *("-semihosting-config", "enable=on,target=native", "-icount", "shift=10,align=off,sleep=off", "-kernel"),
        ),
        packages="gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm",
        ticks=25.6,
        rust=rust,
    )


BOARDS = {
    b.name: b
    for b in (
        _arm("m0", "Cortex-M0 code on a Cortex-M3", "cortex-m0", "mps2-an385", "thumbv6m-none-eabi"),
        _arm("m3", "Cortex-M3, no FPU", "cortex-m3", "mps2-an385", "thumbv7m-none-eabi"),
        _arm("m4f", "Cortex-M4F", "cortex-m4", "mps2-an386", "thumbv7em-none-eabihf", "fpv4-sp-d16"),
        _arm("m7", "Cortex-M7, single-precision FPU", "cortex-m7", "mps2-an500", "thumbv7em-none-eabihf", "fpv5-sp-d16"),
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
            ticks=1.0,
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
            ticks=1.0,
            unit="cycles",
            room=12_000,
            scalars=("float",),
            lacks=("log1pf",),
            paint=300,
        ),
    )
}


def rust_boards() -> list[str]:
    """The boards whose images take the Rust in place of the C."""
    return [b.name for b in BOARDS.values() if b.rust]


def copy_board(board: Board, folder: Path) -> tuple[list[str], list[str]]:
    """Copies what the board starts with, and its header as board.h, to `folder`: the sources, and what to link with."""
    from stt_codegen.program.targets.template_files import template_folder

    templates = template_folder() / "board"
    for name in (*board.sources, *(v for v in board.libraries if v.endswith(".ld"))):
        shutil.copy(templates / name, folder)
    shutil.copy(templates / board.header, folder / "board.h")
    libraries = [str(folder / v) if v.endswith(".ld") else v for v in board.libraries]
    return [str(folder / name) for name in board.sources], libraries
