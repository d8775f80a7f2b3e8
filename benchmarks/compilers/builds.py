"""A controller under one compiler and one set of flags: warnings, fused operations, and the answer of its self-test."""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.compilers.targets import Target
from stt_codegen.board.boards import copy_board
from stt_codegen.errors import SttError
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.c.runner import STRICT

# Instructions, and calls of the library, that round a * b + c once. vmla and fmacs of ARM round twice.
FUSED = re.compile(
    r"^\s+(?:[0-9a-f]+:\s+)?(?:vfn?m[as](?:\.\w+)?|vfn?m(?:add|sub)(?:addsub)?\d*[sp][sd]|fn?m(?:add|sub)s?(?:\.[sd])?|fml[as]"
    r"|n?m(?:add|sub)\.[sd]|m[as][de]br?|[vw]fn?m[as][sd]b)\s|\b__builtin_fmaf?\b|\bfmaf?\b",
    re.MULTILINE,
)
WARNINGS = (*(v for v in STRICT if v.startswith("-W") and v != "-Werror"), "-pedantic")
ANSWER = re.compile(r"answer (\d{5})")
TIME_LIMIT = 300.0  # seconds for one image
STACK = 400  # bytes that a board needs besides its data: where less is left the image is not run
FAST_MATH_WORDS = "compile without -ffast-math"  # of the #error
REFUSED = "refused"  # by an #error of the file
NARROW_DOUBLE_WORDS = "double is not IEEE-754's here"
MAIN = r"""#ifdef ON_BOARD
#include "stt-board.h"
#else
#include <stdio.h>
#define board_start()
#define board_write(text) fputs(text, stdout)
#define board_stop()
#endif
#include "{prefix}.h"

int main(void)
{{
    char text[] = "answer 00000\n";
    board_start();
    int answer = {prefix}_selftest();
    for (int k = 11; k > 6; k--) {{
        text[k] = (char)('0' + (answer % 10));
        answer /= 10;
    }}
    board_write(text);
    board_stop();
    return 0;
}}
"""


@dataclass(frozen=True)
class BuildResult:
    """What a compiler made of a controller.

    warnings: the messages. fused: operations in the object code. fused_without_pragmas: those that the compiler makes of the same
    C without the pragmas. answer: of the self-test, 0 where it passes; None where no image ran. reason: why none had to run.
    failure: what stopped a compiler or an image that had to run.
    """

    warnings: tuple[str, ...] = ()
    fused: int = 0
    fused_without_pragmas: int = 0
    answer: int | None = None
    reason: str = ""
    failure: str = ""

    @property
    def has_passed(self) -> bool:
        """Whether there is no warning, no fused operation, and no self-test that fails."""
        has_answer = self.answer == 0 or bool(self.reason)
        return not self.warnings and self.fused == 0 and has_answer and not self.failure

    def words(self) -> str:
        """Return what came of the self-test."""
        if self.answer:
            return f"CALL {self.answer} IS OFF"
        return self.failure or self.reason or "passes"


def try_build(controller: EmittedController, target: Target, flags: Sequence[str]) -> BuildResult:
    """Compile, disassemble, link and run a controller with a self-test."""
    try:
        return _try_build(controller, target, flags)
    except subprocess.CalledProcessError as error:
        message = error.stderr if isinstance(error.stderr, str) else (error.stderr or b"").decode(errors="replace")
        return BuildResult(failure=f"FAILED: {' '.join(map(str, error.cmd))[:300]}: {' '.join(message.split())[:500]}")


def _try_build(controller: EmittedController, target: Target, flags: Sequence[str]) -> BuildResult:
    """Do so; raises CalledProcessError where a compiler fails."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, data in controller.files.items():
            (folder / file).write_bytes(data)
        sources = [file for file in controller.files if file.endswith(".c")]
        command = [*_compiler(target), *flags]
        if controller.program.scalar == "double" and not target.has_doubles:
            refusal = _refusal(command, sources, folder, NARROW_DOUBLE_WORDS)
            return BuildResult(reason=refusal) if refusal == REFUSED else BuildResult(failure=refusal)
        warnings = _compile([*command, *WARNINGS], sources, folder)
        objects = [f"{Path(file).stem}.o" for file in sources]
        fused = count_fused(target, flags, objects, folder)
        answer, reason = _selftest_answer(controller, target, flags, objects, folder)
        for file in sources:
            text = (folder / file).read_text()
            (folder / file).write_text(re.sub(r"^#pragma .*\n", "", text, flags=re.MULTILINE))
        _compile([*command, "-w"], sources, folder)
        without = count_fused(target, flags, objects, folder)
        failure = "" if answer is not None or reason else "NO ANSWER"
        return BuildResult(warnings, fused, without, answer, reason, failure)


def fast_math_answer(controller: EmittedController, target: Target) -> str:
    """Return "refused" where the file's own #error stops `-O2 -ffast-math`; else what the compiler says."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, data in controller.files.items():
            (folder / file).write_bytes(data)
        return _refusal([*_compiler(target), "-O2", "-ffast-math"], [f"{controller.task.name}.c"], folder, FAST_MATH_WORDS)


def _compiler(target: Target) -> list[str]:
    """Return the compiler with the processor's flags; with its C library's headers on a board."""
    specs = [v for v in target.link if v.startswith("--specs=picolibc")]
    return [target.compiler, *target.flags, *specs]


def _refusal(command: list[str], sources: list[str], folder: Path, words: str) -> str:
    """Return "refused" where the compiler stops with these words of an #error; else that it does not."""
    result = subprocess.run(
        [*command, "-c", sources[0], "-o", "refused.o"], cwd=folder, capture_output=True, text=True, check=False
    )
    if result.returncode == 0:
        return "NOT REFUSED"
    return REFUSED if words in result.stderr else f"STOPPED by another error: {result.stderr[:200]}"


def _compile(command: list[str], sources: list[str], folder: Path) -> tuple[str, ...]:
    """Compile each file to an object; return the warnings."""
    messages = [
        subprocess.run([*command, "-c", file], cwd=folder, check=True, capture_output=True, text=True).stderr for file in sources
    ]
    return tuple(line for text in messages for line in text.splitlines() if "warning:" in line)


def count_fused(target: Target, flags: Sequence[str], objects: Sequence[str], folder: Path) -> int:
    """Return the number of fused operations in these objects; with -flto in the machine code that all of them become."""
    texts = list(objects)
    if "-flto" in flags:
        output = [] if target.compiler == "clang" else ["-flinker-output=nolto-rel"]
        if target.compiler == "avr-gcc":  # it is older than the option, and has no such instructions
            return 0
        partial = [target.compiler, *target.flags, *flags, "-nostdlib", "-r", *output, *objects, "-o", "partial.o"]
        subprocess.run(partial, cwd=folder, check=True, capture_output=True)
        texts = ["partial.o"]
    dump = [target.disassembler, "-dr", "--no-show-raw-insn", *texts]
    code = subprocess.run(dump, cwd=folder, check=True, capture_output=True, text=True).stdout
    if "_control>:" not in code:
        raise SttError(f"{target.compiler}: no instructions of `control` are in {', '.join(texts)}")
    return len(FUSED.findall(code))


def _selftest_answer(
    controller: EmittedController, target: Target, flags: Sequence[str], objects: list[str], folder: Path
) -> tuple[int | None, str]:
    """Link the objects with a main, run it, and return the self-test's answer, or why it did not run."""
    (folder / "main.c").write_text(MAIN.format(prefix=controller.task.name))
    started, link = ["main.c"], list(target.link)
    if target.board is not None:
        started, link = copy_board(target.board, folder)
        started = ["main.c", *started]
    on_board = ["-DON_BOARD"] if target.board else []
    extra = []
    for k, file in enumerate(started):  # without -flto: a start in assembly calls functions by name
        extra.append(f"started{k}.o")
        command = [*_compiler(target), "-O2", *on_board, f"-I{folder}", "-std=gnu11", "-c", file, "-o", extra[-1]]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
    subprocess.run(
        [target.compiler, *target.flags, *flags, *extra, *objects, "-o", "image", *link],
        cwd=folder,
        check=True,
        capture_output=True,
    )
    if target.ram is not None and (data := _data_bytes(target, folder)) > target.ram - STACK:
        return None, f"{data} B of data for {target.ram} B of RAM"
    emulator = target.board.command if target.board else target.emulator
    result = subprocess.run(
        [*emulator, str(folder / "image")], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True, errors="replace", timeout=TIME_LIMIT, check=False,
    )  # fmt: skip
    answer = ANSWER.search(result.stdout)
    return (int(answer[1]), "") if answer else (None, "")


def _data_bytes(target: Target, folder: Path) -> int:
    """Return the bytes of RAM that an image's data take."""
    size = target.compiler.removesuffix("gcc") + "size"
    lines = subprocess.run([size, "-A", "image"], cwd=folder, check=True, capture_output=True, text=True).stdout.splitlines()
    sections = [line.split() for line in lines]
    return sum(int(words[1]) for words in sections if words and words[0] in (".data", ".bss", ".noinit"))
