"""What Coq says of every shipped controller, in how many seconds, and of changed ones, where it must not say yes.

    python -m benchmarks theorem [--no-shipped] [--mutants 200] [--tokens 100] [--seed 0] [--record FILE.md]

One row for each refined controller that theorems are written about: processor seconds of coqc, lines of the `.v`, and where the
task has a period the one of the sampled theorem beside the one of P9. Then mutants. Tubes and tasks of `mutants/tubes.py` that
`oracles/tubes.py` finds unsafe are asked of Coq alone, without hashes and the stand-alone checker; so are texts of C and header
with one token changed, where what the theorem is not about is the checker's. Exit code 1 where a shipped controller is refused
or a mutant gets through both.
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

from benchmarks.mutants.tubes import KINDS, SHAPED, draw
from benchmarks.mutations import files_claiming_success
from benchmarks.oracles.tubes import Undecided, first_fault
from benchmarks.suites.report import command, machine, record, table
from benchmarks.token_mutants import accepted, changed, files_of, mutants, same_meaning
from stt_codegen.decimals import decimal
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import build_program, certify
from stt_codegen.theorem import coq
from stt_codegen.theorem.controller_theorem import controller_theorem_text, coq_string, reason_not_covered
from stt_codegen.theorem.reading import Unread, read_facts
from stt_codegen.theorem.text import theorem_text
from stt_codegen.theorem.tube_theorem import tube_theorem_text

ROOT = Path(__file__).parent.parent
CLAIMED = ("P1", "P2", "P3", "P4", "P5")  # of a tube, by theorem 1; P6 is no part of it


def shipped() -> tuple[list[list[str]], bool]:
    """Rows of the table, and whether every answer is yes."""
    rows, good = [], True
    for folder in sorted(p for scalar in ("float", "double") for p in (ROOT / "generated").glob(f"*/refined/{scalar}")):
        name = folder.parents[1].name
        own = [(folder / f"{name}{end}").read_bytes() for end in (".h", ".c", ".certificate.json")]
        files = [(ROOT / "tasks" / f"{name}.toml").read_bytes(), *own]
        try:
            read = read_facts(files[0], *files[2:])
        except BadInput:
            continue
        text, about = theorem_text(*files), "tube" if reason_not_covered(read, *files[:3]) else "controller"
        answer = coq.check_with_coq(text, name)
        good = good and answer.holds and set(answer.axioms) == coq.ACCEPTED_AXIOMS
        period = "" if read.sampling is None else f"{decimal(read.sampling.period)} s"
        verdict = "yes" if answer.holds else answer.message
        rows.append(
            [
                name,
                folder.name,
                about,
                f"{answer.seconds:.1f}",
                str(text.count(b"\n")),
                period if answer.holds else "",
                period,
                verdict,
            ]
        )
        print(" ".join(rows[-1]), flush=True)
    return rows, good


def unsafe(seed: int) -> Iterator[tuple[str, bytes | None, str]]:
    """Tubes and tasks that are unsafe: what is wrong, the theorems' text where the reader has one, the task's name."""
    for number in itertools.count(1):
        _, _, _, (task, design) = draw(Random(f"theorem {seed} {number}"), SHAPED, tuple(KINDS))
        try:
            fault = first_fault(task, design)
        except Undecided:
            continue
        if fault is None or fault.code not in CLAIMED:
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


def unsafe_mutants(count: int, seed: int) -> Counter[str]:
    """Answers to tubes and tasks that are unsafe, asked of Coq alone."""

    def answer(mutant: tuple[str, bytes | None, str]) -> str:
        what, text, name = mutant
        if text is None:
            return "refused by the reader"
        if not coq.check_with_coq(text, name).holds:
            return "refused by Coq"
        print(f"accepted: {what}")
        return "ACCEPTED"

    with ThreadPoolExecutor(os.cpu_count()) as pool:  # what takes time is coqc
        return Counter(pool.map(answer, itertools.islice(unsafe(seed), count)))


def token_mutants(name: str, count: int, seed: int) -> Counter[str]:
    """Answers to the text of one controller with a token of C or header changed. Coq alone is asked, but where what is changed
    is of functions that the theorem is not about: those are the stand-alone checker's."""
    every = [m for m in mutants(name) if m.file in (f"{name}.c", f"{name}.h")]
    task, plain = (ROOT / "tasks" / f"{name}.toml").read_bytes(), files_of(name)
    text = controller_theorem_text(task, *(plain[f"{name}{end}"] for end in (".h", ".c", ".certificate.json")))
    drawn = [(m, changed(m, name)) for m in Random(seed).sample(every, min(count, len(every)))]

    def by_coq(files: dict[str, bytes]) -> bool:
        bent = text
        for end in (".h", ".c"):
            bent = bent.replace(coq_string(plain[f"{name}{end}"].decode()), coq_string(files[f"{name}{end}"].decode()))
        return coq.check_with_coq(bent.encode(), name).holds

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        holds = list(pool.map(by_coq, (files for _, files in drawn)))
    found = Counter[str]()
    for (mutant, files), held in zip(drawn, holds, strict=True):
        if not held:
            found["refused by Coq"] += 1
        elif not accepted(files, name):
            found["refused by the checker; of another function, or as true"] += 1
        elif same_meaning(mutant, name):
            found["the same meaning"] += 1
        else:
            found["ACCEPTED"] += 1
            print(f"accepted: {mutant}")
    return found


def library() -> str:
    """Seconds to compile it anew, and its lines."""
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
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--shipped", action=argparse.BooleanOptionalAction, default=True, help="the library and what is shipped")
    parser.add_argument("--mutants", type=int, default=200, help="unsafe tubes and tasks")
    parser.add_argument("--tokens", type=int, default=100, help="texts of each of two controllers with a token changed")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--record", type=Path)
    asked = parser.parse_args()
    told, good = [library()] if asked.shipped else [], True
    coq.compiled_library()
    if asked.shipped:
        rows, good = shipped()
        headings = ["task", "scalar", "about the", "seconds of coqc", "lines", "period of the sampled theorem", "of P9", "answer"]
        told += ["", table(headings, rows)]
    for what, found in (
        ("unsafe tubes and tasks, asked of Coq alone", unsafe_mutants(asked.mutants, asked.seed)),
        ("texts of omni_s1 with one token changed", token_mutants("omni_s1", asked.tokens, asked.seed)),
        ("of omni_board, with the logarithm written out and ticks", token_mutants("omni_board", asked.tokens, asked.seed)),
    ):
        good = good and not found["ACCEPTED"]
        counts = "; ".join(f"{n} {answer}" for answer, n in found.most_common())
        told += ["", f"{sum(found.values())} {what}: {counts}; {found['ACCEPTED']} accepted."]
    print("\n".join(told))
    if asked.record is not None:
        title = f"## Theorems\n\n`{command()}` on {machine()}"
        record(asked.record, "theorem", "\n".join([title, "", *told]))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
