"""Ask Coq about every shipped controller, which it must accept, and about changed ones, which it must refuse.

    python -m benchmarks theorem [--no-shipped] [--mutants 200] [--tokens 100] [--seed 0] [--record FILE.md]

The table has a row for each refined controller with theorems: processor seconds of coqc, lines of the `.v`, and the sampling
period of the theorem beside the one of the certificate (P9), if any. Two kinds of mutants follow. Unsafe tubes and tasks
(mutants/tubes.py, oracles/tubes.py) are shown to Coq alone, without hashes and without the stand-alone checker. Texts of C and
header with one token changed are shown to Coq, and to the checker where the theorem is not about the changed function. The exit
code is 1 where a shipped controller is refused, or a mutant is accepted.
"""

from __future__ import annotations

import argparse
import itertools
import os
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from random import Random

from benchmarks.mutants.tubes import ALL_BASE_NAMES, MUTATIONS, draw_mutant
from benchmarks.mutations import files_claiming_success
from benchmarks.oracles.cubics import Undecided
from benchmarks.oracles.tubes import first_fault
from benchmarks.suites.report import command, machine, record, table
from benchmarks.token_mutants import changed_files, is_accepted, reason_for_same_meaning, shipped_files, token_mutants
from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_program, certify
from stt_codegen.theorem import coq
from stt_codegen.theorem.controller_theorem import controller_theorem_text, coq_string, reason_not_covered
from stt_codegen.theorem.reading import Unread, read_facts
from stt_codegen.theorem.text import theorem_text
from stt_codegen.theorem.tube_theorem import tube_theorem_text

ROOT = Path(__file__).parent.parent
PROVED_PROPERTIES = ("P1", "P2", "P3", "P4", "P5")  # of a tube, by theorem 1, which is not about P6


def shipped_rows() -> tuple[list[list[str]], bool]:
    """Ask Coq about each shipped controller. Return the rows of the table, and whether all were accepted."""
    rows, all_accepted = [], True
    for folder in sorted(p for scalar in ("float", "double") for p in (ROOT / "generated").glob(f"*/refined/{scalar}")):
        name = folder.parents[1].name
        files = [(ROOT / "tasks" / f"{name}.toml").read_bytes()]
        files += [(folder / f"{name}{end}").read_bytes() for end in (".h", ".c", ".certificate.json")]
        try:
            read = read_facts(files[0], *files[2:])
        except BadInput:
            continue  # no theorem is about it
        text, subject = theorem_text(*files), "tube" if reason_not_covered(read, *files[:3]) else "controller"
        answer = coq.check_with_coq(text, name)
        all_accepted = all_accepted and answer.holds and set(answer.axioms) == coq.ACCEPTED_AXIOMS
        period = "" if read.sampling is None else f"{decimal(read.sampling.period)} s"
        verdict = "yes" if answer.holds else answer.message
        rows.append(
            [
                name,
                folder.name,
                subject,
                f"{answer.seconds:.1f}",
                str(text.count(b"\n")),
                period if answer.holds else "",
                period,
                verdict,
            ]
        )
        print(" ".join(rows[-1]), flush=True)
    return rows, all_accepted


def unsafe_mutants(seed: int) -> Iterator[tuple[str, bytes | None, str]]:
    """Yield unsafe tubes and tasks without end: a description, the text of the theorems, and the task's name.

    The text is None where the reader of the C refuses the mutant.
    """
    for number in itertools.count(1):
        task, design = draw_mutant(Random(f"theorem {seed} {number}"), ALL_BASE_NAMES, tuple(MUTATIONS)).mutant
        try:
            fault = first_fault(task, design)
        except Undecided:
            continue
        if fault is None or fault.code not in PROVED_PROPERTIES:
            continue
        files = files_claiming_success(task, design, certify(task, design, build_program(task, design)))
        try:
            read = read_facts(files["task.toml"], files[f"{task.name}.c"], files[f"{task.name}.certificate.json"])
        except BadInput:
            continue  # sets that no theorem is about
        except Unread:
            yield f"mutant {number}: {fault}", None, task.name
        else:
            yield f"mutant {number}: {fault}", tube_theorem_text(read), task.name


def count_unsafe_answers(count: int, seed: int) -> Counter[str]:
    """Ask Coq alone about `count` unsafe tubes and tasks, and count its answers."""

    def answer(mutant: tuple[str, bytes | None, str]) -> str:
        description, text, name = mutant
        if text is None:
            return "refused by the reader"
        if not coq.check_with_coq(text, name).holds:
            return "refused by Coq"
        print(f"accepted: {description}")
        return "ACCEPTED"

    with ThreadPoolExecutor(os.cpu_count()) as pool:  # threads wait for coqc, which is a process
        return Counter(pool.map(answer, itertools.islice(unsafe_mutants(seed), count)))


def count_token_answers(name: str, count: int, seed: int) -> Counter[str]:
    """Change a token of C or header of one controller, `count` times, and count the answers of Coq and checker.

    The checker is asked where Coq accepts: the theorem is not about every function of the C.
    """
    mutants = [m for m in token_mutants(name) if m.file in (f"{name}.c", f"{name}.h")]
    task, original = (ROOT / "tasks" / f"{name}.toml").read_bytes(), shipped_files(name)
    text = controller_theorem_text(task, *(original[f"{name}{end}"] for end in (".h", ".c", ".certificate.json")))
    drawn = [(m, changed_files(m, name)) for m in Random(seed).sample(mutants, min(count, len(mutants)))]

    def coq_accepts(files: dict[str, bytes]) -> bool:
        changed_text = text
        for end in (".h", ".c"):
            changed_text = changed_text.replace(
                coq_string(original[f"{name}{end}"].decode()), coq_string(files[f"{name}{end}"].decode())
            )
        return coq.check_with_coq(changed_text.encode(), name).holds

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        coq_answers = list(pool.map(coq_accepts, (files for _, files in drawn)))
    counts = Counter[str]()
    for (mutant, files), is_accepted_by_coq in zip(drawn, coq_answers, strict=True):
        if not is_accepted_by_coq:
            counts["refused by Coq"] += 1
        elif not is_accepted(files, name):
            counts["refused by the checker; of another function, or as true"] += 1
        elif reason_for_same_meaning(mutant, name):
            counts["the same meaning"] += 1
        else:
            counts["ACCEPTED"] += 1
            print(f"accepted: {mutant}")
    return counts


def library_summary() -> str:
    """Compile the library from its sources. Return the number of files and lines, and the seconds, in a sentence."""
    sources = [coq.library_folder() / f"{name}.v" for name in coq.library_modules()]
    begin = coq.child_processor_seconds()
    with tempfile.TemporaryDirectory() as folder:
        for path in sources:
            shutil.copy(path, folder)
            done = subprocess.run(
                [coq.find_coqc(), *coq.QUIET_OPTIONS, "-Q", ".", "Stt", path.name], cwd=folder, capture_output=True, check=False
            )
            if done.returncode:
                raise RuntimeError(f"{path.name}: {done.stderr.decode()[-500:]}")
    lines = sum(path.read_text().count("\n") for path in sources)
    return f"The library: {len(sources)} files, {lines} lines, {coq.child_processor_seconds() - begin:.0f} s."


def main() -> int:
    """Ask Coq about shipped controllers and mutants, and print the answers. Return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--shipped", action=argparse.BooleanOptionalAction, default=True, help="the library and what is shipped")
    parser.add_argument("--mutants", type=int, default=200, help="unsafe tubes and tasks")
    parser.add_argument("--tokens", type=int, default=100, help="texts of each of two controllers with a token changed")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--record", type=Path)
    options = parser.parse_args()
    lines, is_good = [library_summary()] if options.shipped else [], True
    coq.compiled_library()
    if options.shipped:
        rows, is_good = shipped_rows()
        headings = ["task", "scalar", "about the", "seconds of coqc", "lines", "period of the sampled theorem", "of P9", "answer"]
        lines += ["", table(headings, rows)]
    for label, counts in (
        ("unsafe tubes and tasks, asked of Coq alone", count_unsafe_answers(options.mutants, options.seed)),
        ("texts of omni_s1 with one token changed", count_token_answers("omni_s1", options.tokens, options.seed)),
        (
            "of omni_board, with the logarithm written out and ticks",
            count_token_answers("omni_board", options.tokens, options.seed),
        ),
    ):
        is_good = is_good and not counts["ACCEPTED"]
        answers = "; ".join(f"{n} {answer}" for answer, n in counts.most_common())
        lines += ["", f"{sum(counts.values())} {label}: {answers}; {counts['ACCEPTED']} accepted."]
    print("\n".join(lines))
    if options.record is not None:
        title = f"## Theorems\n\n`{command()}` on {machine()}"
        record(options.record, "theorem", "\n".join([title, "", *lines]))
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
