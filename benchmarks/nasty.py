"""Malformed and oversized inputs of every kind that a command reads: whether each gets its message, soon, and in little memory.

    python -m benchmarks nasty [--count 1000] [--seed 54] [--families] [--keep FOLDER]

benchmarks/suites/nasty_inputs.py makes them. Each is read by its command in a process of its own with a limit on its memory. The
laws: the exit code is 0 to 4; no traceback; with code 2 to 4 a message, of printable characters; at most 1 GB of memory; never 10
seconds without output; nothing half-written, and nothing at all where the command refuses. Exit code 1 where one is broken.
--families: every bomb once, instead of drawing. --keep: the files of cases that break a law are written there.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import multiprocessing
import os
import resource
import select
import signal
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from benchmarks.suites.nasty_inputs import Case, bombs, draw_case

MEMORY_LIMIT = 1_000_000_000  # bytes resident
ADDRESS_LIMIT = 6_000_000_000  # bytes; threads of numerical libraries reserve much that they never use
SILENCE_LIMIT = 10.0  # seconds without output
TIME_LIMIT = 25.0  # seconds, after which a command that still says what it does is ended; that is no breach
EXIT_CODES = (0, 1, 2, 3, 4)
OUTPUTS = ("out", "recorded")  # folders that commands write to
PROGRESS_END = " s ..."


@dataclass(frozen=True)
class Outcome:
    """What a command did: exit code (negative: the signal), output, bytes of memory, longest silence and time in seconds."""

    code: int
    output: str
    memory: int
    silence: float
    seconds: float
    has_ended: bool


def run_case(case: Case, folder: Path) -> Outcome:
    """Run the command of a case in a child of this process, which has its imports already, in a folder with the case's files."""
    for name, data in case.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        os.close(reader)
        _run_in_child(case, folder, writer)
    os.close(writer)
    begin = last = time.monotonic()
    output, silence, has_ended = bytearray(), 0.0, False
    while time.monotonic() - begin < TIME_LIMIT:
        ready = select.select([reader], [], [], 0.5)[0]
        piece = os.read(reader, 1 << 16) if ready else b""
        if ready:
            silence, last = max(silence, time.monotonic() - last), time.monotonic()
            has_ended = not piece
            output += piece
        if has_ended or time.monotonic() - last > 2 * SILENCE_LIMIT:
            break
    silence = max(silence, time.monotonic() - last)
    if not has_ended:
        os.kill(child, signal.SIGKILL)
    _, status, usage = os.wait4(child, 0)
    os.close(reader)
    code = os.waitstatus_to_exitcode(status)
    return Outcome(code, output.decode(errors="replace"), usage.ru_maxrss * 1024, silence, time.monotonic() - begin, has_ended)


def _run_in_child(case: Case, folder: Path, writer: int) -> NoReturn:
    """Run a command line with both of its streams on a pipe, and end the process with its exit code."""
    from stt_codegen.cli.main import main

    code = 1
    try:
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_LIMIT, ADDRESS_LIMIT))
        os.dup2(writer, 1)
        os.dup2(writer, 2)
        os.close(writer)
        sys.stdout, sys.stderr = (open(k, "w", encoding="utf-8", closefd=False) for k in (1, 2))  # noqa: SIM115
        os.chdir(folder)
        sys.argv = ["stt-codegen", *case.arguments]
        main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException as error:
        os.write(2, f"Traceback: {type(error).__name__}: {error}\n".encode(errors="replace"))
    finally:
        os._exit(code)


def broken_laws(case: Case, outcome: Outcome, folder: Path) -> list[str]:
    """Return the laws that a command broke."""
    laws = []
    lines = [line for line in outcome.output.splitlines() if not line.endswith(PROGRESS_END)]
    if outcome.memory > MEMORY_LIMIT:
        laws.append(f"{outcome.memory / 1e9:.1f} GB of memory")
    if outcome.silence > SILENCE_LIMIT:
        laws.append(f"{outcome.silence:.0f} s without output")
    if "Traceback" in outcome.output or "internal error" in outcome.output:
        laws.append(f"a traceback or an internal error: {next((v for v in lines if 'rror' in v), '')[:200]}")
    if not outcome.has_ended:
        return laws
    if outcome.code not in EXIT_CODES:
        laws.append(f"exit code {outcome.code}")
    if outcome.code in (2, 3, 4) and not lines:
        laws.append("no message")
    if not all(line.isprintable() for line in lines):
        laws.append("a message with characters that cannot be printed")
    return laws + half_written(case, outcome.code, folder)


def half_written(case: Case, code: int, folder: Path) -> list[str]:
    """Return what is wrong with the files that a command left."""
    laws = []
    for path in (path for name in OUTPUTS for path in sorted((folder / name).rglob("*")) if path.is_file()):
        name = path.relative_to(folder).as_posix()
        if path.name.startswith("."):
            laws.append(f"{name} is left")
        elif code in (2, 3, 4) and case.files.get(name) != path.read_bytes():
            laws.append(f"{name} is written, and the command refuses")
        elif path.name.endswith(".certificate.json") and name not in case.files:
            hashes = json.loads(path.read_bytes())["sha256"]
            present = {n: path.parent / n for n in hashes if (path.parent / n).is_file()}
            if any(hashlib.sha256(file.read_bytes()).hexdigest() != hashes[n] for n, file in present.items()):
                laws.append(f"{name} does not fit to the files beside it")
    return laws


def import_commands() -> None:
    """Import what the commands import, so that each child begins with it."""
    import stt_codegen.checker
    import stt_codegen.loop
    import stt_codegen.report.page
    import stt_codegen.report.pictures
    import stt_codegen.steps
    import stt_codegen.task.map
    import stt_codegen.theorem  # noqa: F401


def judge(case: Case, keep: Path | None = None) -> tuple[Outcome, list[str]]:
    """Run a case and return its outcome and the laws that it broke. keep: where its files go then."""
    with tempfile.TemporaryDirectory() as name:
        outcome = run_case(case, Path(name))
        laws = broken_laws(case, outcome, Path(name))
    if laws and keep is not None:
        kept = Path(tempfile.mkdtemp(prefix=f"{case.kind}-", dir=keep))
        for file, data in {**case.files, "command": "\0".join(case.arguments).encode()}.items():
            (kept / file).parent.mkdir(parents=True, exist_ok=True)
            (kept / file).write_bytes(data)
    return outcome, laws


def judge_drawn(draw: tuple[int, int | None, Path | None]) -> tuple[str, Outcome, str]:
    """Run a case by its number and seed (None: of the bombs). Return its kind, its outcome, and a line on broken laws."""
    number, seed, keep = draw
    case = list(bombs())[number].case() if seed is None else draw_case(number, seed)
    outcome, laws = judge(case, keep)
    line = f"{number}: {case.kind}, {case.family}: {' '.join(case.arguments)[:200]!r}: {'; '.join(laws)}" if laws else ""
    return case.kind, outcome, line


def main() -> None:
    """Run the cases that the options name."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=54)
    parser.add_argument("--jobs", type=int, default=2, help="processes at once")
    parser.add_argument("--families", action="store_true", help="every bomb once")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where the files of cases that break a law go")
    options = parser.parse_args()
    import_commands()
    if options.keep is not None:
        options.keep.mkdir(parents=True, exist_ok=True)
    codes: Counter[tuple[str, str]] = Counter()
    broken, total, slowest, largest, begin = 0, 0, 0.0, 0, time.monotonic()
    count, seed = (len(list(bombs())), None) if options.families else (options.count, options.seed)
    draws = [(number, seed, options.keep) for number in range(count)]
    with multiprocessing.get_context("fork").Pool(options.jobs) as pool:
        for kind, outcome, line in pool.imap(judge_drawn, draws):
            codes[kind, str(outcome.code) if outcome.has_ended else "still working"] += 1
            broken, total = broken + bool(line), total + 1
            slowest, largest = max(slowest, outcome.silence), max(largest, outcome.memory)
            if line:
                print(line, flush=True)
    for kind in sorted({kind for kind, _ in codes}):
        print(f"{kind:12}", ", ".join(f"exit {code}: {n}" for (k, code), n in sorted(codes.items()) if k == kind))
    print(
        f"{total} inputs in {time.monotonic() - begin:.0f} s: {broken} break a law; the longest silence was {slowest:.1f} s, "
        f"the most memory {largest / 1e6:.0f} MB"
    )
    sys.exit(bool(broken))


if __name__ == "__main__":
    main()
