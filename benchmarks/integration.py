"""Run the laws that are too heavy for `make test`, as named jobs, one after the other. `make integration` calls this.

    python -m benchmarks integration [--list] [--only NAME] [--jobs-matching PATH] [--again] [--minutes N]

A job is one command that fails where its law is broken. Its result is kept in benchmarks/integration_records/, in a file of its
own, as soon as it ends, so a run that is stopped goes on where it stopped. Commit the records: they spare the next person what is
green and still valid. What a job wrote is in build/integration/. A run ends with a table, and with exit code 1 where a job
failed, was never run, or is older than what it measures.

A result is valid while three things are as they were:

- The command, with its seed.
- The contents of the job's inputs as they are on disk, committed or not. What .gitignore names does not count.
- The versions of Python and of the job's tools.

Inputs are wide: a job that runs once too often costs minutes, a green that is not true costs more. So the default is the package,
the templates, the tasks and the lock file, besides the script, what it imports, and what the suites share. Faces of rooms import
widely, so no room is left out. Slow tests have the shipped files and their test file with its imports besides; of other test
files nothing. tests/benchmarks/test_integration.py follows the imports, and fails where they lead out of the inputs.

A job whose tool is missing is not run. Its row says so; with CI=true that is a failure. A job of pytest that skipped a test has
the same state: what was skipped was not measured.

Jobs that failed run first, then the shortest: so most laws answer early.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from fnmatch import fnmatch
from functools import cache
from importlib import metadata
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parent.parent
SHORTEST_LIMIT, LIMIT_FACTOR = 30.0, 8.0  # a job ends after 8 times its minutes, but not before 30 minutes
OUTPUT_KEPT = 4000  # characters of a job's output in its record
LINES_SHOWN = 15  # lines of a failed job's output on the terminal


@dataclass(frozen=True)
class Job:
    """A command that fails where a law is broken, and what decides whether its result is still valid.

    minutes: on two quiet cores. seed: replaces {seed} in the command; None where the command always draws the same. command:
    arguments of Python. inputs: files and folders, relative to the repository. tools: commands, or paths of files that `make`
    installs. packages: Python packages that locks/requirements.lock does not have.
    """

    name: str
    law: str
    minutes: float
    seed: int | None
    command: tuple[str, ...]
    inputs: tuple[str, ...]
    tools: tuple[str, ...] = ()
    packages: tuple[str, ...] = ()

    @property
    def arguments(self) -> tuple[str, ...]:
        return tuple(part.replace("{seed}", str(self.seed)) for part in self.command)

    def reads(self, path: PurePosixPath) -> bool:
        """Whether an input contains the path, or is in it."""
        inputs = map(PurePosixPath, self.inputs)
        return any(path == name or name in path.parents or path in name.parents for name in inputs)


# ------------------------------------------------------------------------------------------ the jobs

# Inputs, from wide to narrow; the docstring says why.
PACKAGE = ("stt_codegen", "templates", "tasks", "locks/requirements.lock")
SHARED = ("benchmarks/suites", "benchmarks/peers", "benchmarks/command_line.py")  # arenas, missions and loops to measure on
MUTANTS = ("benchmarks/oracles", "benchmarks/mutants", "benchmarks/mutations.py", "benchmarks/fixed.py")
SHIPPED = ("generated", "proof")
STARTED = ("benchmarks/__init__.py", "benchmarks/__main__.py")  # what `python -m benchmarks` begins with
TESTS = (*PACKAGE, *SHIPPED, "pyproject.toml", "tests/__init__.py", "tests/conftest.py", "tests/support")
ARM = ("arm-none-eabi-gcc", "qemu-system-arm")
RISC_V = ("riscv64-unknown-elf-gcc", "qemu-system-riscv32")
AVR = ("avr-gcc", "simavr")
LINUX = ("aarch64", "riscv64", "s390x", "powerpc", "mips")  # processors whose programs QEMU runs here
CROSS = (*(f"{name}-linux-gnu-gcc" for name in LINUX), "qemu-x86_64", "qemu-s390x")
CHECKED = ("tests/certify", "docs/certificate-format.md", "benchmarks/token_mutants.py")
SETS = ("tests/task",)


def script(
    name: str,
    law: str,
    minutes: float,
    command: str,
    inputs: tuple[str, ...],
    *,
    seed: int | None = None,
    tools: tuple[str, ...] = (),
    packages: tuple[str, ...] = (),
) -> Job:
    """Return the job of a script of benchmarks/. command: its file and options."""
    path, *options = command.split()
    arguments = ("-m", "benchmarks", Path(path).stem, *options)
    return Job(name, law, minutes, seed, arguments, (path, *STARTED, *SHARED, *inputs), tools, packages)


def bench(name: str, law: str, minutes: float, options: str, tools: tuple[str, ...] = ()) -> Job:
    """Return the job of a suite of benchmarks/. options: the suite and its options."""
    inputs = (*STARTED, *SHARED, *PACKAGE)
    return Job(name, law, minutes, None, ("-m", "benchmarks", *options.split()), inputs, tools)


def slow_tests(
    file: str,
    law: str,
    minutes: float,
    *,
    tools: tuple[str, ...] = (),
    helpers: tuple[str, ...] = (),
    part: str = "",
    only: str = "",
    dist: str = "loadgroup",
) -> Job:
    """Return the job of the slow tests of a file.

    part: the suffix of the job's name, where several jobs share the file. only: pytest's expression that selects tests.
    """
    folder, _, stem = file.rpartition("/")
    package = f"tests/{folder}/" if folder else "tests/"
    path = f"{package}test_{stem}.py"
    command = ("-m", "pytest", "-n", "auto", "--dist", dist, "-m", "slow", path, *(("-k", only) if only else ()))
    name = f"tests-{stem.replace('_', '-')}{part and '-' + part}"
    inputs = (path, f"{package}__init__.py", *STARTED, *SHARED, *TESTS, *helpers)
    return Job(name, law, minutes, None, command, inputs, tools)


JOBS = (
    # slow tests: what `make test` leaves out
    slow_tests(
        "controller/adaptive_emitted", "The paper's tubes, emitted, stay within their error bounds in every language.", 1.5,
        tools=("cc",),
        helpers=("tests/emit",),
    ),
    slow_tests(
        "benchmarks/bench", "Arenas give the same results in one process, in two, and on a Dask cluster.", 0.5,
        helpers=("benchmarks/ends.py",),
    ),
    slow_tests(
        "certify/checker_claims", "The stand-alone checker refuses tubes that are bent and hashed again.", 1,
        helpers=(*CHECKED, *MUTANTS)
    ),
    slow_tests(
        "certify/listing_meaning", "The listing of every combination of options does what the specification says.", 3,
        helpers=CHECKED
    ),
    *(
        slow_tests("certify/listing_mutants", law, 5, part=part, only=only, dist="load")
        for part, only, law in (
            ("symbols", "symbolic", "A wrong statement of a listing is noticed by the symbolic machine."),
            ("fractions", "not symbolic", "A wrong statement of a listing is noticed by --meaning."),
        )
    ),
    slow_tests(
        "certify/integer_mutants", "A wrong statement of the listing in integers is noticed by symbols, or by results in C.", 5,
        tools=("gcc",), dist="load",
    ),
    slow_tests("cli/cli", "A command whose reader closes the pipe ends without an error.", 1),
    slow_tests(
        "program/enclosure", "The proof by enclosures never accepts a tube that fails at a sample.", 1,
        helpers=("tests/program/test_program.py", "tests/support/bank.py"),
    ),
    slow_tests(
        "controller/fixed", "Integers give the same bits in C and in Python, for a million inputs.", 4, tools=("gcc",),
        helpers=("benchmarks/fixed.py",),
    ),
    slow_tests("lemmas/lemmas", "A wrong kernel leaves the lemma about it open.", 5),
    slow_tests(
        "sampling/one_formula", "A wrong term of the sampling conditions leaves a lemma about it open.", 4,
        helpers=("tests/sampling",),
    ),
    slow_tests(
        "emit/lint", "clang-tidy finds nothing in the C that is shipped.", 1, tools=("clang-tidy",),
        helpers=("tests/emit/test_runtime_errors.py", "docs/c.md"),
    ),
    slow_tests("board/mcu", "The costs on a board grow with the dimension and not with the obstacles.", 2, tools=(*ARM, "rustc")),
    slow_tests(
        "design/moving", "Among sets that move no unsafe tube is certified.", 2,
        helpers=(*SETS, *MUTANTS, "benchmarks/moving.py"),
    ),
    slow_tests("record/package_kinds", "The Arduino library of integers compiles for an Uno.", 1, tools=("avr-gcc", "avr-g++")),
    slow_tests(
        "paper/paper", "The implicit step of alpha is of first order, beside a stiff integrator.", 1,
        helpers=("benchmarks/alpha.py",)
    ),
    slow_tests(
        "benchmarks/peers", "A loop of order 2 that leaves its tube below the proved period is reported.", 1, tools=("cc",),
    ),
    slow_tests("design/preference", "`design --pareto` writes tubes, picture and data that agree.", 1),
    slow_tests(
        "record/ros2", "The ROS 2 node carries its mission out, and stops.", 4, tools=("build/ros/bin/python",),
        helpers=("benchmarks/ros.py", "locks/ros.lock"),
    ),
    slow_tests("emit/runtime_errors", "The C in integers passes the sanitizers, for a million inputs.", 1, tools=("gcc",)),
    slow_tests(
        "emit/rust", "A changed operator of the Rust shows, and on a board the Rust is within its bounds.", 4,
        tools=("rustc", *ARM),
        helpers=("docs/rust.md",),
    ),
    slow_tests("task/shapes", "Certificate, checker and oracle agree about sets that are no boxes.", 1, helpers=SETS),
    slow_tests(
        "certify/oracle", "Among mutants of orders 1 and 2 no unsafe tube is certified.", 2,
        helpers=(*MUTANTS, "tests/certify/test_certificate.py", "tests/controller"),
    ),
    slow_tests(
        "design/moving_search", "A way in space and time is the best on its cells.", 1,
        helpers=("tests/design/test_moving.py", *SETS, *MUTANTS, "benchmarks/moving.py"),
    ),
    *(
        slow_tests(
            "theorem/theorem", law, minutes, part=part, only=only, dist="load", tools=("coqc",),
            helpers=("tests/theorem/test_controller_theorem.py", "tests/cli", *CHECKED, *MUTANTS),
        )
        for part, only, minutes, law in (
            ("shipped", "accepts", 3, "Coq accepts every controller that is shipped."),
            ("changed", "not accepts", 3, "Coq refuses a changed table, constant, task or certificate."),
        )
    ),
    *(
        slow_tests(
            "theorem/controller_theorem", law, minutes, part=part, only=only, dist="load", tools=("coqc",),
            helpers=("tests/cli", *CHECKED, *MUTANTS),
        )
        for part, only, minutes, law in (
            ("ticks", "changed_texts and omni_board", 5, "Coq refuses changed C with ticks and a logarithm of its text."),
            ("texts", "changed_texts and not omni_board", 5, "Coq refuses changed C and headers."),
            ("attacks", "not changed_texts and attacks", 5, "Coq refuses the attacks that the checker refuses."),
            ("parts", "not changed_texts and not attacks", 5, "Gains, limits, clamps and sets have theorems by themselves."),
        )
    ),
    slow_tests("unused", "No definition of the compiled Coq library stands unused.", 3, tools=("coqc",)),
    # mutants: no certificate for what is not safe
    *(
        script(
            f"mutations-{k + 1}", "No unsafe tube is certified, by the tool or by the checker.", 3,
            "benchmarks/mutations.py --count 1000 --first {seed}", (*MUTANTS, *PACKAGE), seed=1000 * k,
        )
        for k in range(3)
    ),
    script(
        "mutations-shapes", "No tube is certified that meets a set which is no box.", 3,
        "benchmarks/mutations.py --shapes --count 1000", (*MUTANTS, *PACKAGE),
    ),
    script(
        "mutations-integers", "No unsafe tube is certified for a controller in integers.", 3,
        "benchmarks/mutations.py --integers --count 300", (*MUTANTS, *PACKAGE),
    ),
    script(
        "mutations-moving", "No tube is certified that meets a set which moves.", 3,
        "benchmarks/mutations.py --moving --count 500", (*MUTANTS, *PACKAGE),
    ),
    script(
        "mutations-inertia", "No unsafe tube and no unsafe period is certified for a plant of order 2.", 3,
        "benchmarks/mutations.py --inertia --count 400", (*MUTANTS, *PACKAGE),
    ),
    *(
        script(
            f"tokens-{task}", "The checker accepts no changed token of the C and no changed claim.", 3,
            f"benchmarks/token_mutants.py --every 8 --task {task}", PACKAGE,
        )
        for task in ("trolley", "omni_board", "gantry", "crane")
    ),
    script(
        "lemma-mutants", "The lemma book notices changed kernels.", 5, "benchmarks/lemma_mutants.py 120", PACKAGE,
    ),
    script(
        "lag-attack", "No adversary breaks a loop at the largest lag, or the longest period, that the worst path proves.", 3,
        "benchmarks/lag_attack.py --runs 12000 --seed {seed}", PACKAGE, seed=7,
    ),
    *(
        script(
            f"lag-attack-without-{part}", "The attack breaks a loop where a part of the worst path's statement is left out.", 1,
            f"benchmarks/lag_attack.py --runs 2000 --omit {part}", PACKAGE,
        )
        for part in ("start", "age", "input", "first")
    ),
    script(
        "missions-mutants", "No mission is certified that a trajectory in the tube breaks.", 3,
        "benchmarks/mission_mutants.py --count 1000", PACKAGE,
    ),
    # arenas, maps, rooms: if there is a passage there is a certified tube
    script(
        "sampled", "No adversary breaks a loop at its proved period.", 3, "benchmarks/sampled.py 100", PACKAGE,
    ),
    script(
        "refusals", "Every remedy that a refusal names is true, for tasks of nine kinds.", 5,
        "benchmarks/refusals.py --count 27", (*PACKAGE, "benchmarks/moving.py"),
    ),
    script(
        "nasty", "A malformed or oversized input gets its message, soon and in little memory, and nothing is half-written.", 8,
        "benchmarks/nasty.py --count 1000 --seed {seed}", (*PACKAGE, *SHIPPED), seed=54,
    ),
    script(
        "tubes", "Arenas with a way have a tube, and no setting has a tube that is wider and no faster.", 3,
        "benchmarks/tubes.py --count 60 --others 60", PACKAGE,
    ),
    script(
        "moving", "Arenas whose sets move have tubes, and closed loops stay in them.", 5,
        "benchmarks/moving.py --count 60", (*PACKAGE, "stt_codegen/report"), tools=("cc",),
    ),
    script(
        "inertia", "Arenas have tubes of order 2, and closed loops stay in them.", 5,
        "benchmarks/inertia.py --count 60 --loops 1000", PACKAGE, tools=("cc", *ARM),
    ),
    script(
        "map-levels", "No certified tube lies on a cell of a map that is not free.", 3,
        "benchmarks/map_levels.py", PACKAGE,
    ),
    script(
        "rooms", "Concave rooms with a passage have a tube, and it stays inside.", 3,
        "benchmarks/rooms.py --count 200", ("benchmarks/oracles", *PACKAGE),
    ),
    bench(
        "bench-arenas", "Of random arenas with a way 99 % have a certified tube.", 1,
        "arenas --family paper --family dense12 --family space3 --design refined --count 200 --demand 0.99",
    ),
    bench(
        "bench-loop", "The emitted C drives random arenas: no collision, and always in the target.", 1, "loop --count 100",
        ("cc",),
    ),
    bench("bench-missions", "Of random missions 98 % are carried out.", 2, "missions --count 30", ("cc",)),
    # machines: a physics engine, boards, sketches
    script(
        "physics", "In a physics engine the bounds of [plant] hold and no run has a contact.", 3,
        "benchmarks/physics.py --runs 100", ("benchmarks/bodies.py", "locks/physics.lock", *PACKAGE), tools=("cc",),
        packages=("mujoco",),
    ),
    *(
        script(
            f"fixed-{part}", "Boards give the bits of the emitted Python, for controllers in integers.", 1,
            f"benchmarks/fixed.py {' '.join(f'--board {board}' for board in boards.split())}", PACKAGE, tools=tools,
        )
        for part, boards, tools in (("arm", "m0 m3 m4f", ARM), ("rv32", "rv32", RISC_V), ("avr", "avr", AVR))
    ),
    *(
        script(
            f"integer-bits-{part}", "100,000 inputs give the same bits in Python, in C on this machine, and on boards.", 2,
            f"benchmarks/integer_bits.py --inputs 100000 {' '.join(f'--board {board}' for board in boards.split())}",
            ("benchmarks/fixed.py", *PACKAGE), tools=("cc", *tools),
        )
        for part, boards, tools in (("arm", "m0 m3 m4f m7", ARM), ("rv32", "rv32", RISC_V), ("avr", "avr", AVR))
    ),
    script(
        "sketches", "On a simulated Uno the tube is where the clock is, and steps take what `generate` estimates.", 3,
        "benchmarks/sketch_time.py", ("benchmarks/fixed.py", *PACKAGE), tools=AVR,
    ),
    script(
        "toolchains", "Compilers neither warn nor fuse a product and a sum, and self-tests pass, also where big-endian.", 10,
        "benchmarks/toolchains.py", ("benchmarks/compilers", *PACKAGE), tools=("gcc", "clang", *CROSS, *ARM, *RISC_V, *AVR),
    ),
    # proofs
    script(
        "gappa", "Gappa confirms the constants of P7, and the spline time of every shipped controller.", 1, "benchmarks/gappa.py",
        (
            *SHIPPED[:1], "stt_codegen/theorem", *PACKAGE,
        ),
        tools=("gappa",),
    ),
    script(
        "theorem-shipped", "Coq accepts the library and every shipped controller.", 6,
        "benchmarks/theorem.py --mutants 0 --tokens 0",
        (*MUTANTS, "benchmarks/token_mutants.py", *PACKAGE, *SHIPPED), tools=("coqc",),
    ),
    *(
        script(
            f"theorem-mutants-{k + 1}", "Coq accepts no unsafe tube and no unsafe task.", 6,
            "benchmarks/theorem.py --no-shipped --mutants 100 --tokens 0 --seed {seed}",
            (*MUTANTS, "benchmarks/token_mutants.py", *PACKAGE, *SHIPPED), seed=k, tools=("coqc",),
        )
        for k in range(2)
    ),
    *(
        script(
            f"theorem-tokens-{k + 1}", "No changed token of C or header gets through both Coq and the checker.", 6,
            "benchmarks/theorem.py --no-shipped --mutants 0 --tokens 50 --seed {seed}",
            (*MUTANTS, "benchmarks/token_mutants.py", *PACKAGE, *SHIPPED), seed=k, tools=("coqc",),
        )
        for k in range(2)
    ),
)  # fmt: skip

UNLISTED = {  # scripts of benchmarks/ with an exit code that are no job, and why
    "arithmetic.py": "It takes hours for every task; gappa proves the same bounds, and make test compares at 10,000 points.",
    "beside.py": "It compares with another checkout.",
    "ends.py": "make ends runs it: it installs the oldest versions apart.",
    "page.py": "It measures seconds and frames, which depend on the machine; it fails only without a browser.",
    "public_maps.py": "It needs maps that are not in the repository.",
    "checker.py": "It measures; that shipped controllers are verified is in make test.",
    "same_outputs.py": "It compares with another commit, where a change must leave what controllers compute as it was.",
    "ros.py": "tests-ros2 runs it, in the environment that has ROS 2.",
    "gain_table.py": "It measures, and has no number that it must reach.",
    "lag_table.py": "It measures, and has no number that it must reach.",
}


# ------------------------------------------------------------------------------------------ records and states


class State(StrEnum):
    """What is known of a job."""

    GREEN = "green"
    FAILED = "failed"
    STALE = "stale"
    NOT_RUN = "not run"
    MISSING_TOOL = "missing tool"


@dataclass(frozen=True)
class Basis:
    """What a result rests on: the command, digests of the inputs, versions of the tools."""

    command: tuple[str, ...]
    inputs: dict[str, str]
    tools: dict[str, str]

    @property
    def missing(self) -> list[str]:
        """Tools that are not installed."""
        return sorted(name for name, version in self.tools.items() if not version)

    def changes_since(self, before: Basis) -> list[str]:
        """Return the names of the inputs and tools that differ; "the command" where that does."""
        names = [] if self.command == before.command else ["the command"]
        for now, then in ((self.inputs, before.inputs), (self.tools, before.tools)):
            names += [name for name in sorted({*now, *then}) if now.get(name) != then.get(name)]
        return names


@dataclass(frozen=True)
class Record:
    """The last run of a job.

    commit: with a plus where inputs had uncommitted changes. ended: date and time. exit_code: None where the job took too long
    and was ended. output: the end of its output; empty where it is green.
    """

    outcome: State
    basis: Basis
    commit: str
    ended: str
    seconds: float
    exit_code: int | None
    output: str


@dataclass(frozen=True)
class Status:
    """The state of a job, and the reason for it. can_run: whether its tools are installed."""

    job: Job
    state: State
    record: Record | None
    reason: str = ""
    can_run: bool = True


class Ledger:
    """The records in benchmarks/integration_records/, and the disk that they are compared with."""

    def __init__(self, root: Path) -> None:
        self.root, self.folder = root, root / "benchmarks" / "integration_records"
        self.logs = root / "build" / "integration"
        ignore = root / ".gitignore"
        lines = ignore.read_text().split() if ignore.is_file() else []
        self.ignored = [line.rstrip("/") for line in lines]

    def digests(self, paths: Iterable[str]) -> dict[str, str]:
        """Return SHA-256 of names and contents of files and folders, by path; of no content where a path does not exist."""
        return {path: self._digest(self.root / path) for path in sorted(set(paths))}

    def _digest(self, top: Path) -> str:
        files = [top] if top.is_file() else sorted(p for p in top.rglob("*") if p.is_file() and not self._is_ignored(p))
        total = hashlib.sha256()
        for file in files:
            with contextlib.suppress(FileNotFoundError):  # removed meanwhile
                content = hashlib.sha256(file.read_bytes()).digest()
                total.update(f"{file.relative_to(self.root).as_posix()}\0".encode() + content)
        return total.hexdigest()

    def _is_ignored(self, file: Path) -> bool:
        return any(fnmatch(part, pattern) for part in file.relative_to(self.root).parts for pattern in self.ignored)

    def basis(self, job: Job, digests: dict[str, str] | None = None) -> Basis:
        """Return the basis that a run of the job would have now. digests: of its inputs, if they are computed already."""
        by_path = self.digests(job.inputs) if digests is None else digests
        versions = {"python": platform.python_version()}
        versions |= {name: tool_version(name, self.root) or "" for name in job.tools}
        versions |= {name: package_version(name) or "" for name in job.packages}
        return Basis(job.arguments, {path: by_path[path] for path in job.inputs}, versions)

    def record(self, job: Job) -> Record | None:
        """Return the last run; None where there was none, or its file cannot be read."""
        try:
            document = json.loads((self.folder / f"{job.name}.json").read_text())
            basis = document.pop("basis")
            basis = Basis(tuple(basis["command"]), basis["inputs"], basis["tools"])
            return Record(**{**document, "outcome": State(document["outcome"]), "basis": basis})
        except (OSError, ValueError, TypeError, KeyError):
            return None

    def write(self, job: Job, record: Record) -> None:
        """Replace the record's file in one step, so that an interrupted process leaves the old or the new one."""
        partial = self.folder / f"{job.name}.json.part"
        partial.write_text(json.dumps(asdict(record), indent=2) + "\n")
        partial.replace(self.folder / f"{job.name}.json")

    def statuses(self, jobs: Sequence[Job]) -> list[Status]:
        digests = self.digests(path for job in jobs for path in job.inputs)
        return [self._status(job, self.basis(job, digests)) for job in jobs]

    def _status(self, job: Job, now: Basis) -> Status:
        """Return the state of a job, by its last run and the present basis."""
        record = self.record(job)
        if now.missing:
            state = State.FAILED if os.environ.get("CI") == "true" else State.MISSING_TOOL
            return Status(job, state, record, f"{', '.join(now.missing)}: not installed", can_run=False)
        if record is None:
            return Status(job, State.NOT_RUN, None)
        changes = now.changes_since(record.basis)
        if changes:
            return Status(job, State.STALE, record, f"{record.outcome} before {', '.join(changes)} changed")
        reasons = {
            State.FAILED: "it took too long" if record.exit_code is None else f"exit code {record.exit_code}",
            State.MISSING_TOOL: "it skipped tests",
        }
        return Status(job, record.outcome, record, reasons.get(record.outcome, ""))

    def log(self, job: Job) -> Path:
        return self.logs / f"{job.name}.log"

    def run(self, job: Job) -> Record:
        """Run the job to its end and write its record. On KeyboardInterrupt end the job and write nothing."""
        for folder in (self.folder, self.logs):
            folder.mkdir(parents=True, exist_ok=True)
        before, begin = self.basis(job), time.monotonic()
        with self.log(job).open("wb") as log:
            process = subprocess.Popen(
                [sys.executable, *job.arguments],
                cwd=self.root,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # so that the job and its processes can be ended together
            )
            try:
                exit_code: int | None = process.wait(60 * max(SHORTEST_LIMIT, LIMIT_FACTOR * job.minutes))
            except subprocess.TimeoutExpired:
                exit_code = None
            finally:
                end_group(process)
        seconds, after = time.monotonic() - begin, self.basis(job)
        stable = {path: digest if after.inputs[path] == digest else "changed meanwhile" for path, digest in before.inputs.items()}
        output = self.log(job).read_text(errors="replace")[-OUTPUT_KEPT:]
        outcome = outcome_of(exit_code, output)
        record = Record(
            outcome=outcome,
            basis=Basis(before.command, stable, before.tools),
            commit=commit_of(self.root, job.inputs),
            ended=time.strftime("%Y-%m-%d %H:%M:%S %z"),
            seconds=round(seconds, 1),
            exit_code=exit_code,
            output="" if outcome is State.GREEN else output,
        )
        self.write(job, record)
        return record


def outcome_of(exit_code: int | None, output: str) -> State:
    """Return the state of an ended job: green where it succeeded, and pytest reports no skipped test in its last line."""
    if exit_code != 0:
        return State.FAILED
    last = (output.strip().splitlines() or [""])[-1]
    return State.MISSING_TOOL if re.search(r"\b[1-9]\d* skipped\b", last) else State.GREEN


def end_group(process: subprocess.Popen[bytes]) -> None:
    """End a job that still runs, with all the processes that it started."""
    for kind in (signal.SIGTERM, signal.SIGKILL):
        if process.poll() is not None:
            return
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, kind)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(10)


@cache
def tool_version(name: str, root: Path) -> str | None:
    """Return the line of `--version` with a number, or the path of a tool without one; None where the tool is missing."""
    path = str(root / name) if (root / name).is_file() else shutil.which(name)
    if path is None:
        return None
    process = subprocess.run(
        [path, "--version"], stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False
    )
    return next((line.strip() for line in (process.stdout + process.stderr).splitlines() if re.search(r"\d\.\d", line)), path)


@cache
def package_version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def commit_of(root: Path, inputs: Sequence[str]) -> str:
    """Return the commit that is checked out, with a plus where the inputs have uncommitted changes; "-" without git."""

    def git(*arguments: str) -> str:
        return subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=True).stdout.strip()

    try:
        return git("rev-parse", "--short", "HEAD") + ("+" if git("status", "--porcelain", "--", *inputs) else "")
    except (OSError, subprocess.CalledProcessError):
        return "-"


def expected_seconds(status: Status) -> float:
    return status.record.seconds if status.record else 60 * status.job.minutes


def in_order(statuses: Sequence[Status]) -> list[Status]:
    """Return the jobs in the order in which they run: those that failed, then the shortest."""
    failed = {s.job.name for s in statuses if s.record and s.record.outcome is State.FAILED}
    return sorted(statuses, key=lambda s: (s.job.name not in failed, expected_seconds(s)))


def table(statuses: Sequence[Status]) -> str:
    """Return a table with a row for each job, and the names of the jobs that are not green, by state and reason."""
    rows: list[tuple[str, ...]] = [("job", "law", "state", "seconds", "commit")]
    for s in statuses:
        seconds, commit = (f"{s.record.seconds:.0f}", s.record.commit) if s.record else (f"~{60 * s.job.minutes:.0f}", "-")
        rows.append((s.job.name, s.job.law, s.state, seconds, commit))
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    rows.insert(1, tuple("-" * width for width in widths))
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    waiting = [s for s in statuses if s.state is not State.GREEN]
    lines += ["", f"{len(statuses) - len(waiting)} of {len(statuses)} jobs are green."]
    if waiting:
        minutes = sum(expected_seconds(s) for s in waiting if s.can_run) / 60
        lines[-1] += f" What is not takes about {minutes:.0f} minutes."
    names: dict[str, list[str]] = {}
    for s in sorted(waiting, key=lambda s: tuple(State).index(s.state)):
        names.setdefault(f"{s.state}{s.reason and f' ({s.reason})'}", []).append(s.job.name)
    return "\n".join([*lines, *(f"{label}: {', '.join(jobs)}" for label, jobs in names.items())])


def is_good(statuses: Iterable[Status]) -> bool:
    """Return whether no job failed, is stale or was not run. A missing tool is allowed; in CI its job has the state failed."""
    return not {s.state for s in statuses} & {State.FAILED, State.STALE, State.NOT_RUN}


def run_all(ledger: Ledger, waiting: Sequence[Status], minutes: float) -> None:
    """Run the jobs and print their results; start none after so many minutes."""
    begin = time.monotonic()
    for number, status in enumerate(waiting, 1):
        job, elapsed = status.job, (time.monotonic() - begin) / 60  # minutes
        if elapsed >= minutes:
            print(f"{elapsed:.1f} minutes are over; {len(waiting) - number + 1} jobs are not run")
            return
        about = expected_seconds(status) / 60
        print(f"[{number} of {len(waiting)}, {elapsed:.1f} min] {job.name}, about {about:.1f} min: {job.law}", flush=True)
        record = ledger.run(job)
        print(f"    {record.outcome} after {record.seconds:.0f} s", flush=True)
        if record.outcome is State.FAILED:
            print(f"    exit code {record.exit_code}; the end of {ledger.log(job)}:")
            print("\n".join(f"    | {line}" for line in record.output.splitlines()[-LINES_SHOWN:]), flush=True)


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """Raise KeyboardInterrupt at the first Ctrl-C or SIGTERM, also where a shell started this process with Ctrl-C ignored."""
    kinds = (signal.SIGINT, signal.SIGTERM)

    def interrupt(*_: object) -> None:
        for kind in kinds:
            signal.signal(kind, signal.SIG_IGN)  # until the job has ended
        raise KeyboardInterrupt

    before = [signal.signal(kind, interrupt) for kind in kinds]
    try:
        yield
    finally:
        for kind, handler in zip(kinds, before, strict=True):
            signal.signal(kind, handler)


def select_jobs(jobs: Sequence[Job], names: Sequence[str] | None, paths: Sequence[str] | None, root: Path) -> list[Job]:
    """Return the jobs with one of these names or patterns that read one of these paths. Raises ValueError for an unknown name."""
    for name in names or ():
        if not any(fnmatch(job.name, name) for job in jobs):
            raise ValueError(f"--only {name}: no job has that name; --list shows them")
    relative = [PurePosixPath(os.path.relpath(os.path.abspath(path), root)) for path in paths or ()]
    return [
        job
        for job in jobs
        if (not names or any(fnmatch(job.name, name) for name in names))
        and (not relative or any(job.reads(path) for path in relative))
    ]


def main(arguments: Sequence[str] | None = None, jobs: Sequence[Job] | None = None, root: Path = ROOT) -> int:
    """Run the jobs that are not green, and print the table. Return the exit code. jobs: those of JOBS where it is None."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--list", action="store_true", help="only write the table; nothing is run")
    parser.add_argument("--only", action="append", metavar="NAME", help="only this job; a pattern such as 'tests-*'; repeatable")
    parser.add_argument(
        "--jobs-matching", action="append", metavar="PATH", help="only jobs whose inputs contain this file or folder; repeatable"
    )
    parser.add_argument("--again", action="store_true", help="run green jobs too")
    parser.add_argument("--minutes", type=float, default=float("inf"), metavar="N", help="start no job after so many minutes")
    options = parser.parse_args(arguments)
    try:
        selected = select_jobs(JOBS if jobs is None else jobs, options.only, options.jobs_matching, root)
    except ValueError as error:
        parser.error(str(error))
    ledger = Ledger(root)
    statuses = ledger.statuses(selected)
    if not options.list:
        waiting = [s for s in statuses if s.can_run and (options.again or s.state is not State.GREEN)]
        with interruptible():
            try:
                run_all(ledger, in_order(waiting), options.minutes)
            except KeyboardInterrupt:
                print("interrupted; what ended before is kept")
        statuses = ledger.statuses(selected)
        print()
    print(table(statuses))
    return 0 if is_good(statuses) else 1


if __name__ == "__main__":
    sys.exit(main())
